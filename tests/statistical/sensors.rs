//! Sensors and films against closed forms: irradiance, distant views, spectral responses, alpha and borders.

use crate::common::{bins, described, expose, made, settings};
use abbe::film::{Film, FilterKind, Measured};
use abbe::render::{WavelengthCount, render};
use abbe::scene::{CompileOptions, Scene, compile};
use abbe::stats::sidak;
use abbe::units::WavelengthRange;
use statrs::distribution::{ContinuousCDF, StudentsT};
use std::f64::consts::PI;

/// How many results are judged in this file.
const TESTS: usize = 61;

/// A scene and its film, compiled for the wavelengths that the film asks for.
fn scene(content: &str) -> (Scene, WavelengthRange) {
    let description = described(content);
    let range = description.sensor.film.wavelength_range();
    let options = CompileOptions { range, spectral: true, ..CompileOptions::default() };
    (compile(&description, &options).unwrap_or_else(|errors| panic!("{errors}")), range)
}

/// Renders with one spectral bin over all wavelengths.
fn exposed(content: &str, samples: u32) -> Film {
    let (scene, range) = scene(content);
    let mut settings = settings(samples, WavelengthCount::Four, 5);
    settings.bins = bins(range, 1);
    expose(&scene, &settings)
}

#[track_caller]
fn assert_is(found: Measured, truth: f64, film: &Film) {
    let difference = (found.mean - truth).abs();
    if difference <= 1e-9 * truth.abs() {
        return;
    }
    let t = StudentsT::new(0.0, 1.0, f64::from(film.replicates) - 1.0).unwrap();
    let p = 2.0 * t.sf(difference / found.error);
    assert!(p > sidak(0.01, TESTS), "{found:?} instead of {truth}: p = {p}");
    // A test that cannot tell 1 % from nothing is none.
    assert!(found.error < 3e-3 * truth.abs().max(0.25), "{found:?} is too uncertain");
}

fn film(plugin: &str, width: u32, content: &str) -> String {
    format!(
        r#"<film type="{plugin}"><integer name="width" value="{width}"/><integer name="height" value="1"/>{content}</film>"#
    )
}

fn pixel() -> String {
    film("hdrfilm", 1, r#"<rfilter type="box"/>"#)
}

const SKY: &str = r#"<emitter type="constant"><spectrum name="radiance" value="1"/></emitter>"#;
const BLACK: &str = r#"<bsdf type="diffuse"><spectrum name="reflectance" value="0"/></bsdf>"#;

#[test]
fn irradiance_under_a_sky_and_under_a_disk() {
    let meter =
        |shape: &str| format!("<shape {shape}<sensor type=\"irradiancemeter\">{}</sensor></shape>", pixel());
    for shape in [
        r#"type="sphere">"#,
        r#"type="cube">"#,
        // A surface that Mitsuba 3 would sample unevenly.
        r#"type="cylinder"><transform name="to_world"><scale x="3"/></transform>"#,
    ] {
        let sky = exposed(&format!("{SKY}{}", meter(shape)), 4096);
        assert_is(sky.bin(0, 0, 0), PI, &sky);
    }
    // Straight below the middle of a disk of radius 2 at height 3: E = π L r² / (r² + h²). The meter is small
    // against both.
    let small = r#"type="disk"><transform name="to_world"><scale value="0.001"/></transform>"#;
    let lamp = format!(
        r#"<shape type="disk"><transform name="to_world"><scale value="2"/><rotate x="1" angle="180"/><translate z="3"/></transform>
           {BLACK}<emitter type="area"><spectrum name="radiance" value="1"/></emitter></shape>"#
    );
    let below = exposed(&format!("{}{lamp}", meter(small)), 65_536);
    assert_is(below.bin(0, 0, 0), PI * 4.0 / 13.0, &below);
}

/// No ray ever meets a light without extent, and few meet one that is far away: the meter itself seeks them.
#[test]
fn irradiance_of_lights_that_rays_do_not_find() {
    let meter = |shape: &str, bsdf: &str| {
        format!("<shape {shape}{bsdf}<sensor type=\"irradiancemeter\">{}</sensor></shape>", pixel())
    };
    let small = r#"type="disk"><transform name="to_world"><scale value="0.0005"/></transform>"#;
    let spectrum = |name: &str| format!(r#"<spectrum name="{name}" value="2"/>"#);
    // At (3, 0, 4): cos θ = 0.8 and d = 5.
    let from_there =
        r#"<transform name="to_world"><lookat origin="3, 0, 4" target="0, 0, 0" up="0, 1, 0"/></transform>"#;
    let place = r#"<point name="position" x="3" y="0" z="4"/>"#;
    let ball = format!(
        r#"<shape type="sphere"><point name="center" x="3" y="0" z="4"/><float name="radius" value="0.01"/>{BLACK}
           <emitter type="area"><spectrum name="radiance" value="2"/></emitter></shape>"#
    );
    for (light, truth) in [
        (format!(r#"<emitter type="point">{place}{}</emitter>"#, spectrum("intensity")), 2.0 * 0.8 / 25.0),
        (
            format!(r#"<emitter type="spot">{from_there}{}</emitter>"#, spectrum("intensity")),
            2.0 * 0.8 / 25.0,
        ),
        (
            format!(
                r#"<emitter type="directional"><vector name="direction" x="-3" y="0" z="-4"/>{}</emitter>"#,
                spectrum("irradiance")
            ),
            2.0 * 0.8,
        ),
        (ball, 2.0 * PI * 1e-4 * 0.8 / 25.0),
    ] {
        let found = exposed(&format!("{light}{}", meter(small, BLACK)), 4096);
        assert_is(found.bin(0, 0, 0), truth, &found);
    }
    // In a sphere of radius r and reflectance ρ around a point light: E = I / r² / (1 − ρ).
    let inside =
        r#"type="sphere"><float name="radius" value="2"/><boolean name="flip_normals" value="true"/>"#;
    let half = r#"<bsdf type="diffuse"><spectrum name="reflectance" value="0.5"/></bsdf>"#;
    let lamp = format!(r#"<emitter type="point">{}</emitter>"#, spectrum("intensity"));
    let found = exposed(&format!("{lamp}{}", meter(inside, half)), 4096);
    assert_is(found.bin(0, 0, 0), 2.0 / 4.0 / (1.0 - 0.5), &found);
}

/// E = π L / 2 (1 − (z² + ρ² − r²) / √((z² + ρ² + r²)² − 4 ρ² r²)) at the distance ρ from the axis of a disk
/// of radius r at the height z (Howell, *A Catalog of Radiation Heat Transfer Configuration Factors*, B-13),
/// averaged over pixels.
#[test]
fn a_sensor_plane_measures_the_sky_through_its_stop() {
    for (radius, distance) in [(0.5, 2.0), (3.0, 1.0)] {
        let sensor = format!(
            r#"<sensor type="sensorplane"><float name="width" value="3"/>
               <float name="aperture_radius" value="{radius}"/><float name="aperture_distance" value="{distance}"/>
               <transform name="to_world"><lookat origin="5, -2, 7" target="1, 1, 1" up="0, 0, 1"/></transform>{}</sensor>"#,
            film("hdrfilm", 3, r#"<rfilter type="box"/>"#)
        );
        let found = exposed(&format!("{SKY}{sensor}"), 65_536);
        for x in 0..3 {
            const STEPS: usize = 100;
            let at = |i: usize| (i as f64 + 0.5) / STEPS as f64 - 0.5;
            let of_sky = |i: usize| {
                let (x, y) = (f64::from(x) - 1.0 + at(i % STEPS), at(i / STEPS));
                let (z, rho, r) = (distance * distance, x * x + y * y, f64::powi(radius, 2));
                0.5 * PI * (1.0 - (z + rho - r) / ((z + rho + r).powi(2) - 4.0 * rho * r).sqrt())
            };
            let truth = (0..STEPS * STEPS).map(of_sky).sum::<f64>() / (STEPS * STEPS) as f64;
            assert_is(found.bin(x, 0, 0), truth, &found);
        }
    }
}

/// Two half circles on two pixels.
#[test]
fn outside_of_a_fisheye_there_is_nothing() {
    for projection in ["equidistant", "equisolid", "stereographic", "orthographic"] {
        let sensor = format!(
            r#"<sensor type="fisheye"><string name="projection" value="{projection}"/>{}</sensor>"#,
            film("hdrfilm", 2, r#"<rfilter type="box"/>"#)
        );
        let found = exposed(&format!("{SKY}{sensor}"), 65_536);
        (0..2).for_each(|x| assert_is(found.bin(x, 0, 0), PI / 8.0, &found));
    }
    let panorama = format!(
        r#"<sensor type="panorama">{}</sensor>"#,
        film("hdrfilm", 2, r#"<rfilter type="gaussian"/>"#)
    );
    let found = exposed(&format!("{SKY}{panorama}"), 4096);
    assert_is(found.bin(1, 0, 0), 1.0, &found);
}

/// A lamp without extent is as bright as one is near to it, and one nanometre holds hardly any luminance:
/// neither leaves the film's scale.
#[test]
fn a_near_point_of_one_wavelength_is_not_too_bright_for_the_film() {
    let floor = r#"<shape type="rectangle"><transform name="to_world"><scale value="200"/></transform>
        <bsdf type="diffuse"><spectrum name="reflectance" value="0.5"/></bsdf></shape>
        <emitter type="point"><point name="position" value="0 0 1"/><spectrum name="intensity" value="1"/></emitter>"#;
    let look =
        r#"<transform name="to_world"><lookat origin="1, 0, 1" target="0, 0, 0" up="0, 0, 1"/></transform>"#;
    let range = WavelengthRange { min: 555.0, max: 556.0 };
    let options = CompileOptions { range, spectral: true, ..CompileOptions::default() };
    let scene = made(&format!(r#"{floor}<sensor type="radiancemeter">{look}{}</sensor>"#, pixel()), &options);
    let mut settings = settings(4096, WavelengthCount::Four, 5);
    settings.bins = bins(range, 1);
    // Fails where a value is left out.
    let film = expose(&scene, &settings);
    let found = film.bin(0, 0, 0).mean;
    assert!((found * PI / 0.5 - 1.0).abs() < 1e-4, "{found}");
}

#[test]
fn a_distant_sensor_sees_the_cross_section_of_the_scene() {
    let sphere = format!(r#"<shape type="sphere"><point name="center" value="7 0 0"/>{BLACK}</shape>"#);
    let view = |target: &str| {
        let sensor = format!(r#"<sensor type="distant">{target}{}</sensor>"#, pixel());
        exposed(&format!("{SKY}{sphere}{sensor}"), 16_384)
    };
    // A black sphere before a bright sky covers a third of its bounding box's bounding sphere, which is 1500
    // steps of single precision larger in Mitsuba 3.
    let whole = view("");
    assert_is(whole.bin(0, 0, 0), 1.0 - 1.0 / (3.0 * (1.0 + 1500.0 / 16_777_216.0f64).powi(2)), &whole);
    // A square around it, and one point of it.
    let square = view(
        r#"<shape type="rectangle" name="target"><transform name="to_world"><scale value="2"/><translate x="7"/></transform></shape>"#,
    );
    assert_is(square.bin(0, 0, 0), 1.0 - PI / 16.0, &square);
    let point = view(r#"<point name="target" value="6.5 0 0"/>"#);
    assert_eq!(point.bin(0, 0, 0).mean, 0.0);
}

#[test]
fn responses_are_integrated_over() {
    // Under a flat sky a channel is the integral of its response, beyond what can be seen too; a response of
    // the sensor itself is a factor.
    let film_of = |content: &str| film("specfilm", 1, content);
    let channels = r#"<spectrum name="box" value="500:1, 600:1"/><spectrum name="narrow" value="550:0, 551:1, 552:0"/>
        <spectrum name="ultraviolet" value="100:1, 300:1"/><spectrum name="rise" value="400:0, 700:3, 900:1"/>"#;
    let radiance = format!(r#"<sensor type="radiancemeter">{}</sensor>"#, film_of(channels));
    let spectral = exposed(&format!("{SKY}{radiance}"), 65_536);
    for (channel, truth) in [100.0, 1.0, 200.0, 450.0 + 400.0].into_iter().enumerate() {
        assert_is(spectral.response(0, 0, channel), truth, &spectral);
    }
    let factor = r#"<spectrum name="srf" value="360:2, 830:4"/>"#;
    let weighed = format!(r#"<sensor type="radiancemeter">{factor}{}</sensor>"#, pixel());
    let weighed = exposed(&format!("{SKY}{weighed}"), 4096);
    assert_is(weighed.bin(0, 0, 0), 3.0, &weighed);
}

#[test]
fn alpha_is_what_mitsuba_says_it_is() {
    // The middle quarter of a pixel is covered. The values are those of Mitsuba 3.9.1, renders.
    let covered = |bsdf: &str| {
        format!(
            r#"<shape type="rectangle"><transform name="to_world"><scale x="0.25" y="9"/><rotate y="1" angle="180"/>
               <translate z="5"/></transform><bsdf type="{bsdf}</bsdf></shape>"#
        )
    };
    let behind = r#"<shape type="rectangle"><transform name="to_world"><scale value="9"/><rotate y="1" angle="180"/>
        <translate z="6"/></transform><bsdf type="diffuse"/></shape>"#;
    let (diffuse, null) = (covered("diffuse\">"), covered("null\">"));
    let mask = covered(r#"mask"><float name="opacity" value="0.3"/><bsdf type="diffuse"/>"#);
    let depth = |depth: u32| format!(r#"<integer name="max_depth" value="{depth}"/>"#);
    let hidden = r#"<boolean name="hide_emitters" value="true"/>"#;
    let alpha = |integrator: &str, parameters: &str, objects: &[&str]| {
        let format = r#"<rfilter type="box"/><string name="pixel_format" value="rgba"/>"#;
        let sensor = format!(r#"<sensor type="orthographic">{}</sensor>"#, film("hdrfilm", 1, format));
        let text = format!(
            r#"<integrator type="{integrator}">{parameters}</integrator>{sensor}{}"#,
            objects.concat()
        );
        let film = exposed(&text, 65_536);
        (film.alpha(0, 0), film)
    };
    for (integrator, parameters, objects, truth) in [
        ("path", "", &[diffuse.as_str()][..], 0.25),
        ("path", "", &[&diffuse, SKY], 1.0),
        ("path", hidden, &[&diffuse, SKY], 0.25),
        ("path", "", &[], 0.0),
        ("path", "", &[&null], 0.0),
        ("path", &depth(1), &[&diffuse], 0.25),
        ("path", &depth(1), &[&null, behind], 0.75),
        ("path", &depth(2), &[&null, behind], 1.0),
        ("path", "", &[&mask], 0.075),
        ("volpath", &depth(1), &[&null, behind], 1.0),
        ("volpath", "", &[&mask], 0.075),
        ("direct", "", &[&diffuse, SKY], 0.25),
        ("direct", "", &[SKY], 0.0),
        ("direct", "", &[&null], 0.25),
        ("walk", "", &[&mask], 0.075),
    ] {
        let (found, film) = alpha(integrator, parameters, objects);
        assert_is(found, truth, &film);
    }
}

/// Surroundings that the camera must not see are not seen through a mask either, and light what is behind it.
#[test]
fn hidden_surroundings_are_hidden_behind_masks() {
    let mask = format!(
        r#"<shape type="rectangle"><transform name="to_world"><scale value="9"/><rotate y="1" angle="180"/>
           <translate z="5"/></transform><bsdf type="mask"><float name="opacity" value="0.3"/>{BLACK}</bsdf></shape>"#
    );
    let behind = r#"<shape type="rectangle"><transform name="to_world"><scale value="9"/><rotate y="1" angle="180"/>
        <translate z="6"/></transform><bsdf type="null"/></shape>"#;
    for integrator in ["path", "volpath", "walk"] {
        for (hides, truth) in [(true, 0.0), (false, 0.7)] {
            let sensor = format!(r#"<sensor type="orthographic">{}</sensor>"#, pixel());
            let text = format!(
                r#"<integrator type="{integrator}"><boolean name="hide_emitters" value="{hides}"/></integrator>
                   {sensor}{mask}{behind}{SKY}"#
            );
            let film = exposed(&text, 16_384);
            assert_is(film.bin(0, 0, 0), truth, &film);
        }
    }
}

#[test]
fn a_window_with_its_border_shows_what_the_whole_shows() {
    // Half of the scene is bright; its edge lies on the edge of the crop window.
    let lamp = r#"<shape type="rectangle"><transform name="to_world"><scale x="5" y="9"/><rotate y="1" angle="180"/>
        <translate x="5" z="5"/></transform><emitter type="area"><spectrum name="radiance" value="1"/></emitter></shape>"#;
    let view = |content: &str| {
        let sensor = format!(r#"<sensor type="orthographic">{}</sensor>"#, film("hdrfilm", 8, content));
        exposed(&format!("{lamp}{sensor}"), 16_384)
    };
    let whole = view("");
    let window = r#"<integer name="crop_offset_x" value="4"/><integer name="crop_width" value="2"/>"#;
    let bordered = view(&format!(r#"{window}<boolean name="sample_border" value="true"/>"#));
    let cut = view(window);
    // Local +x is the picture's left: pixels 0 to 3 are bright, and pixel 4 has the filter's tail beyond 1/2.
    let filter = FilterKind::Gaussian { stddev: 0.5 };
    let integral = |from: f64| {
        let step = (2.0 - from) / 1e5;
        (0..100_000).map(|i| filter.at(from + step * (f64::from(i) + 0.5)) * step).sum::<f64>()
    };
    let tail = integral(0.5) / integral(-2.0);
    for (film, x, truth) in [(&whole, 4, tail), (&bordered, 0, tail), (&cut, 0, 0.0)] {
        assert_is(film.bin(x, 0, 0), truth, film);
    }
}

#[test]
fn depth_zero_is_black() {
    let brightness = |depth: u32| {
        let text = format!(
            r#"<integrator type="path"><integer name="max_depth" value="{depth}"/></integrator>{SKY}<sensor type="radiancemeter">{}</sensor>"#,
            pixel()
        );
        let (scene, _) = scene(&text);
        let film = render(&scene, &settings(16, WavelengthCount::Four, 1), &abbe::render::NoProgress::new());
        film.combined(0, 0, [0.0, 1.0, 0.0]).mean
    };
    assert_eq!(brightness(0), 0.0);
    assert!(brightness(1) > 0.0);
}
