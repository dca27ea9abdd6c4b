//! What texts of 1989 and 1995 claim of pictures, by small renders: the figures of
//! `docs/claims-then-and-now.md`. Each test says by its bounds what difference it sees.

use crate::common::{bins, compiled, described_file, expose, made, settings};
use abbe::film::Measured;
use abbe::render::{Schedule, WavelengthCount};
use abbe::sampling::SamplerKind;
use abbe::scene::{CompileOptions, Counts, RayKind, Scene};
use abbe::units::WavelengthRange;

/// Half of the last digit of a figure with two or with three digits behind the point.
const HALF_A_HUNDREDTH: f64 = 0.005;
const HALF_A_THOUSANDTH: f64 = 0.0005;

fn film(width: u32, height: u32, format: &str) -> String {
    format!(
        r#"<film type="hdrfilm"><integer name="width" value="{width}"/><integer name="height" value="{height}"/>
           <string name="pixel_format" value="{format}"/><rfilter type="box"/></film>"#
    )
}

/// Sees the radiance that comes to one place from one direction.
fn meter(origin: &str, target: &str) -> String {
    format!(
        r#"<sensor type="radiancemeter"><transform name="to_world">
           <lookat origin="{origin}" target="{target}" up="0, 1, 0"/></transform>{}</sensor>"#,
        film(1, 1, "xyz")
    )
}

fn path(max_depth: i32) -> String {
    format!(r#"<integrator type="path"><integer name="max_depth" value="{max_depth}"/></integrator>"#)
}

/// The mean of independent pixels, and its standard error.
fn mean(pixels: &[Measured]) -> (f64, f64) {
    let n = pixels.len() as f64;
    let variance: f64 = pixels.iter().map(|pixel| pixel.error * pixel.error).sum();
    (pixels.iter().map(|pixel| pixel.mean).sum::<f64>() / n, variance.sqrt() / n)
}

/// The mean radiance over all wavelengths in each pixel, where a lamp or sky of 1 is 1.
fn radiance(content: &str, samples: u32) -> Vec<Measured> {
    let range = WavelengthRange::VISIBLE;
    let scene = made(content, &CompileOptions { range, spectral: true, ..CompileOptions::default() });
    let mut settings = settings(samples, WavelengthCount::Four, 5);
    settings.bins = bins(range, 1);
    let film = expose(&scene, &settings);
    (0..film.height)
        .flat_map(|y| (0..film.width).map(move |x| (x, y)))
        .map(|(x, y)| film.bin(x, y, 0))
        .collect()
}

/// The chromaticity that a meter sees, and its standard error in x and y.
fn chromaticity(content: &str) -> ([f64; 2], [f64; 2]) {
    let scene = made(content, &CompileOptions::default());
    let film = expose(&scene, &settings(8192, WavelengthCount::Four, 5));
    let [x, y, z] =
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|weights| film.combined(0, 0, weights).mean);
    let sum = x + y + z;
    let place = [x / sum, y / sum];
    // To first order x / sum is off by (δx − place · δsum) / sum.
    let error = |axis: usize| {
        let mut weights = [-place[axis]; 3];
        weights[axis] += 1.0;
        film.combined(0, 0, weights).error / sum
    };
    (place, [error(0), error(1)])
}

/// H21: a metal's highlight has the metal's colour at normal incidence, and the light's at grazing angles.
#[test]
fn highlights_of_metals_lose_their_colour_at_grazing_angles() {
    let sky = r#"<emitter type="constant"><spectrum name="radiance" type="d65"/></emitter>"#;
    let (light, light_error) = chromaticity(&(meter("0, 0, 1", "1, 0, 1") + sky));
    // D65 to the CIE's four digits (CIE 15:2018, table 8).
    for (found, (expected, error)) in light.into_iter().zip([0.3127, 0.3290].into_iter().zip(light_error)) {
        assert!((found - expected).abs() < 1e-4 + 4.0 * error, "{light:?} ± {light_error:?}");
    }
    for (metal, table) in [
        ("Cu", [0.046, 0.046, 0.043, 0.034, 0.015, 0.006]),
        ("Au", [0.091, 0.091, 0.082, 0.061, 0.026, 0.011]),
    ] {
        let mut nearer = f64::INFINITY;
        for (degrees, expected) in [0.0, 30.0, 60.0, 75.0, 85.0, 88.0].into_iter().zip(table) {
            let (sin, cos) = f64::to_radians(degrees).sin_cos();
            let plane = format!(
                r#"<shape type="rectangle"><transform name="to_world"><scale value="100"/></transform>
                   <bsdf type="conductor"><string name="material" value="{metal}"/></bsdf></shape>"#
            );
            let origin = format!("{sin}, 0, {cos}");
            let (seen, error) = chromaticity(&(meter(&origin, "0, 0, 0") + &plane + sky));
            let away = [0, 1].map(|axis| seen[axis] - light[axis]);
            let distance = away[0].hypot(away[1]);
            let error = [0, 1].map(|axis: usize| error[axis].hypot(light_error[axis]));
            let error = error[0].hypot(error[1]);
            println!("{metal} at {degrees}°: {distance} ± {error}");
            assert!(error < 2e-4, "{metal} at {degrees}°: ± {error} tells nothing");
            assert!(
                (distance - expected).abs() < HALF_A_THOUSANDTH + 4.0 * error,
                "{metal} at {degrees}°: {distance} ± {error}, not {expected}"
            );
            // From 30° on it moves toward the light's.
            assert!(degrees < 60.0 || distance < nearer, "{metal} at {degrees}°: {distance}");
            nearer = distance;
        }
    }
}

/// H25: how deep paths must go in a diamond.
#[test]
fn a_diamond_in_a_furnace_asks_for_long_paths() {
    const PIXELS: u32 = 48;
    let returned = |depth: i32| {
        let pixels = radiance(
            &format!(
                r#"{}<sensor type="orthographic"><transform name="to_world">
                   <lookat origin="0, 0, 5" target="0, 0, 0" up="0, 1, 0"/></transform>{}</sensor>
                   <emitter type="constant"><spectrum name="radiance" value="1"/></emitter>
                   <shape type="revolution">
                   <string name="profile" value="0 -0.45, 0.95 0.15, 0.95 0.2, 0.55 0.5, 0 0.5"/>
                   <bsdf type="dielectric"><spectrum name="int_ior" type="measured">
                   <string name="name" value="diamond"/></spectrum></bsdf></shape>"#,
                path(depth),
                film(PIXELS, PIXELS, "luminance")
            ),
            16,
        );
        let across = |i: usize| 2.0 * (i as f64 + 0.5) / f64::from(PIXELS) - 1.0;
        let inside = |i: usize| across(i % PIXELS as usize).hypot(across(i / PIXELS as usize)) < 0.9;
        let inside: Vec<Measured> =
            pixels.into_iter().enumerate().filter(|(i, _)| inside(*i)).map(|(_, pixel)| pixel).collect();
        mean(&inside)
    };
    let table = [(4, 0.20), (8, 0.70), (16, 0.90), (32, 0.98), (64, 1.00), (128, 1.00)];
    for (depth, expected) in table {
        let (found, error) = returned(depth);
        println!("depth {depth}: {found} ± {error}");
        assert!(
            error < 0.004 && (found - expected).abs() < HALF_A_HUNDREDTH + 4.0 * error,
            "depth {depth}: {found} ± {error}, not {expected}"
        );
    }
}

/// H30: a tree of rays that is cut off loses all of the light beyond; roulette loses none on average.
#[test]
fn thirty_mirrors_are_passed_by_roulette_and_not_by_a_limit() {
    let mirror = r#"<bsdf type="conductor"><string name="material" value="none"/>
        <spectrum name="specular_reflectance" value="0.9"/></bsdf>"#;
    let plane = |z: u32, turn: &str| {
        format!(
            r#"<shape type="rectangle"><transform name="to_world"><scale x="16" y="5"/>{turn}
               <translate x="15" z="{z}"/></transform>{mirror}</shape>"#
        )
    };
    let seen = |depth: i32, samples: u32| {
        let lamp = r#"<shape type="rectangle"><transform name="to_world"><scale value="5"/>
            <rotate y="1" angle="-90"/><translate x="30"/></transform>
            <emitter type="area"><spectrum name="radiance" value="1"/></emitter></shape>"#;
        let planes = plane(0, "") + &plane(1, r#"<rotate x="1" angle="180"/>"#);
        mean(&radiance(&(path(depth) + &meter("0, 0, 0.5", "1, 0, 1.5") + &planes + lamp), samples))
    };
    let (found, error) = seen(-1, 1 << 17);
    let expected = 0.9f64.powi(30);
    println!("{found} ± {error}, expected {expected}");
    assert!(error < 0.03 * expected && (found - expected).abs() < 4.0 * error, "{found} ± {error}");
    assert_eq!(seen(16, 64), (0.0, 0.0));
    // One segment fewer than there are, and as many.
    assert_eq!(seen(30, 4096), (0.0, 0.0));
    let (found, error) = seen(31, 1 << 17);
    assert!(error < 0.03 * expected && (found - expected).abs() < 4.0 * error, "{found} ± {error}");
}

/// H26: the error of a zone plate at four samples, over its mean. The truth is the rings themselves; what the
/// whole picture is off, by wavelengths on a regular grid, is no part of it.
#[test]
fn a_zone_plate_at_four_samples_tells_samplers_apart() {
    const FROM: u32 = 64;
    const SIZE: u32 = 64;
    const FINE: u32 = 64;
    let scene =
        compiled(&described_file("scenes/effects/zone-plate/scene.xml", &[]), &CompileOptions::default());
    let pixels: Vec<[u32; 2]> =
        (FROM..FROM + SIZE).flat_map(|y| (FROM..FROM + SIZE).map(move |x| [x, y])).collect();
    // Ring k, which reaches to the radius √(128 k), is white where k is odd, as the middle is.
    let white = |[x, y]: [u32; 2]| {
        let at = |pixel: u32, i: u32| f64::from(pixel) + (f64::from(i) + 0.5) / f64::from(FINE) - 128.0;
        let inside = (0..FINE * FINE).filter(|i| {
            let [x, y] = [at(x, i % FINE), at(y, i / FINE)];
            (((x * x + y * y) / 128.0) as u32).is_multiple_of(2)
        });
        inside.count() as f64 / f64::from(FINE * FINE)
    };
    let truth: Vec<f64> = pixels.iter().map(|&pixel| white(pixel)).collect();
    let mean = truth.iter().sum::<f64>() / truth.len() as f64;
    let error = |sampler: SamplerKind| {
        let mut settings = settings(4, WavelengthCount::Four, 0);
        settings.schedule = Schedule::independent(1, 4);
        settings.sampler = sampler;
        let film = expose(&scene, &settings);
        let seen: Vec<f64> = pixels.iter().map(|&[x, y]| film.combined(x, y, [0.0, 1.0, 0.0]).mean).collect();
        let scale = mean / (seen.iter().sum::<f64>() / seen.len() as f64);
        let squares = seen.iter().zip(&truth).map(|(seen, truth)| (scale * seen - truth).powi(2));
        (squares.sum::<f64>() / truth.len() as f64).sqrt() / mean
    };
    use SamplerKind::{Independent, Jittered, Poisson, Regular, Sobol};
    let table = [(Independent, 0.363), (Poisson, 0.270), (Jittered, 0.261), (Regular, 0.169), (Sobol, 0.234)];
    let found = table.map(|(sampler, _)| error(sampler));
    println!("{found:?}");
    for ((sampler, expected), found) in table.into_iter().zip(found) {
        // Squares of normal errors spread by √2 of their mean: the root of the mean of so many by 1/√(2 n).
        let spread = expected / (2.0 * truth.len() as f64).sqrt();
        let off = (found - expected).abs();
        assert!(off < HALF_A_THOUSANDTH + 4.0 * spread, "{sampler:?}: {found} is not {expected}");
    }
    let [independent, poisson, jittered, _, sobol] = found;
    assert!(sobol < jittered && jittered < poisson && poisson < independent, "{found:?}");
}

/// H18: all effects together need the camera rays of one, and not many more of other kinds.
#[test]
fn all_effects_together_trace_as_many_rays_as_none() {
    let counted = |name: &str| -> Counts {
        let mut description = described_file(&format!("scenes/effects/{name}/scene.xml"), &[]);
        (description.sensor.film.width, description.sensor.film.height) = (64, 48);
        let scene: Scene = compiled(&description, &CompileOptions::default()).counting();
        expose(&scene, &settings(16, WavelengthCount::Four, 1));
        scene.counters().expect("it counts").take()
    };
    let [alone, all] = ["antialias", "all-together"].map(counted);
    let camera = [&alone, &all].map(|counts| counts.of(RayKind::Camera).rays);
    assert_eq!(camera[0], camera[1]);
    let rays = all.rays() as f64 / alone.rays() as f64;
    let nodes = all.tests().nodes as f64 / alone.tests().nodes as f64;
    println!("rays {rays}, nodes {nodes}");
    assert!(rays < 1.5 && nodes < 1.5, "all effects together: {rays} times the rays, {nodes} the nodes");
}

/// H22: a ball of a measured yellow keeps its chromaticity while it blurs.
#[test]
fn what_moves_fast_keeps_its_measured_colour() {
    let ball = |place: &str| {
        format!(
            r#"{}<sensor type="orthographic"><float name="shutter_close" value="1"/><transform name="to_world">
               <scale x="2" y="2"/><lookat origin="0, 0, 5" target="0, 0, 0" up="0, 1, 0"/></transform>{}</sensor>
               <emitter type="directional"><vector name="direction" value="1, -1, -2"/>
               <spectrum name="irradiance" type="d65"/></emitter>
               <shape type="sphere"><float name="radius" value="0.4"/>{place}<bsdf type="diffuse">
               <spectrum name="reflectance" type="measured"><string name="name" value="colorchecker/yellow"/>
               </spectrum></bsdf></shape>"#,
            path(2),
            film(32, 32, "xyz")
        )
    };
    let key = |time: u32, x: f64| format!(r#"<transform time="{time}"><translate x="{x}"/></transform>"#);
    let moving = format!(r#"<animation name="to_world">{}{}</animation>"#, key(0, -1.4), key(1, 1.4));
    // Chromaticity of all the light, its errors, and how many pixels have some.
    let seen = |place: &str| {
        let film =
            expose(&made(&ball(place), &CompileOptions::default()), &settings(64, WavelengthCount::Four, 5));
        let pixels = || (0..32).flat_map(|y| (0..32).map(move |x| (x, y)));
        let all = |weights: [f64; 3]| {
            mean(&pixels().map(|(x, y)| film.combined(x, y, weights)).collect::<Vec<_>>())
        };
        let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|weights| all(weights).0);
        let sum = x + y + z;
        let place = [x / sum, y / sum];
        let error = [0, 1].map(|axis: usize| {
            let mut weights = [-place[axis]; 3];
            weights[axis] += 1.0;
            all(weights).1 / sum
        });
        let lit = pixels().filter(|&(x, y)| film.combined(x, y, [0.0, 1.0, 0.0]).mean > 0.0).count();
        (place, error, lit)
    };
    let (still, still_error, still_lit) = seen("");
    let (fast, fast_error, fast_lit) = seen(&moving);
    println!("{still:?} ± {still_error:?} in {still_lit}, {fast:?} ± {fast_error:?} in {fast_lit}");
    assert!(2 * fast_lit > 5 * still_lit, "it moves over {fast_lit} pixels, and {still_lit} at rest");
    for axis in [0, 1] {
        let error = still_error[axis].hypot(fast_error[axis]);
        assert!(
            error < 1e-3 && (still[axis] - fast[axis]).abs() < 4.0 * error,
            "{still:?}, {fast:?} ± {error}"
        );
    }
    // Far from the light's 0.3127, 0.3290.
    assert!(still[0] > 0.40 && still[1] > 0.42, "{still:?}: not yellow");
}
