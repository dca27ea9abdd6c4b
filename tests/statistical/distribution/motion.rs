//! Motion across the film against the time for which each pixel is covered; `validation/transport/motion`
//! makes the claim.

use super::{assert_agree, compiled, coverage, expose, flat_camera, mean, pixels, radiance, settings};
use abbe::sampling::SamplerKind;
use abbe::scene::Scene;
use abbe::stats::{Estimate, welch};

const SHUTTER: &str = r#"<float name="shutter_open" value="0"/><float name="shutter_close" value="1"/>"#;
const SQUARE: f64 = 8.0;
const WIDTH: u32 = 96;

/// Where the middle of the square is at certain times, straight between them.
type Path = [(f64, f64)];

fn at(path: &Path, time: f64) -> f64 {
    let after = path.iter().position(|key| key.0 >= time).unwrap_or(path.len() - 1).max(1);
    let ((t0, x0), (t1, x1)) = (path[after - 1], path[after]);
    x0 + (x1 - x0) * ((time - t0) / (t1 - t0)).clamp(0.0, 1.0)
}

/// A square that moves along x and covers all rows of the film.
fn scene(path: &Path, shutter: &str) -> Scene {
    let keys: String = path
        .iter()
        .map(|(time, x)| {
            format!(
                r#"<transform time="{time}"><scale x="{0}" y="{SQUARE}"/><translate x="{x}"/></transform>"#,
                SQUARE / 2.0
            )
        })
        .collect();
    let camera = flat_camera(WIDTH, 4, &format!("{SHUTTER}{shutter}"));
    compiled(&format!(
        r#"{camera}<shape type="rectangle"><animation name="to_world">{keys}</animation></shape>"#
    ))
}

/// The share of the light that comes while the square covers column `i`, for light let in as `density` says.
fn expected(path: &Path, density: impl Fn(f64) -> f64, i: u32) -> f64 {
    const STEPS: u32 = 20_000;
    let left = f64::from(i) - f64::from(WIDTH) / 2.0;
    let covered = |step: u32| {
        let time = (f64::from(step) + 0.5) / f64::from(STEPS);
        let x = at(path, time);
        let overlap = (left + 1.0).min(x + SQUARE / 2.0) - left.max(x - SQUARE / 2.0);
        density(time) * overlap.max(0.0)
    };
    (0..STEPS).map(covered).sum::<f64>() / f64::from(STEPS)
}

/// Every column against what covers it; columns that nothing reaches exactly.
fn check(name: &str, path: &Path, shutter: &str, expected: impl Fn(u32) -> f64) {
    let film = expose(&scene(path, shutter), 16, 256, 7);
    let profile: Vec<f64> = (0..WIDTH).map(expected).collect();
    let column = |i: u32| mean((0..4).map(|y| coverage(&film, i, y)));
    assert_agree(name, (0..WIDTH).map(|i| (column(i), Estimate::exact(profile[i as usize]))));
    let all = mean((0..WIDTH).map(column));
    let z = (all.mean - profile.iter().sum::<f64>() / f64::from(WIDTH)) / all.error();
    assert!(z.abs() < 3.3, "{name}: what is covered in all is off by {z} standard errors");
}

#[test]
fn a_fast_square_leaves_a_trapezoid() {
    let path = [(0.0, -32.0), (1.0, 32.0)];
    check("trapezoid", &path, "", |i| {
        // Ramps as wide as the square, and s/d = 1/8 between.
        let x = f64::from(i) + 0.5 - 48.0;
        ((36.0 - x.abs()) / 64.0).clamp(0.0, 0.125)
    });
}

#[test]
fn shutters_weigh_time() {
    let path = [(0.0, -32.0), (1.0, 32.0)];
    let triangle = |time: f64| 2.0 - (4.0 * time - 2.0).abs();
    let name = |kind: &str| format!(r#"<string name="shutter" value="{kind}"/>"#);
    check("triangle", &path, &name("triangle"), |i| expected(&path, triangle, i));
    // Two sharp pictures of half the coverage.
    check("strobe", &path, &name("strobe"), |i| {
        let x = (f64::from(i) + 0.5 - 48.0).abs();
        if (x - 32.0).abs() < 4.0 { 0.5 } else { 0.0 }
    });
}

#[test]
fn what_moves_unevenly_is_where_it_should_be_for_as_long_as_it_should() {
    // Balls that turn abruptly, move in the middle only, start near the end.
    let turns = [(0.0, -30.0), (0.5, 20.0), (0.75, 10.0), (1.0, 40.0)];
    let middle = [(0.0, -20.0), (0.35, -20.0), (0.65, 20.0), (1.0, 20.0)];
    let late = [(0.0, 0.0), (0.9, 0.0), (1.0, 12.0)];
    for (name, path) in [("turns", &turns), ("middle", &middle)] {
        check(name, path, "", |i| expected(path, |_| 1.0, i));
    }
    check("late", &late, "", |i| expected(&late, |_| 1.0, i));
}

/// A fixed pattern in which time follows place sees movers one way only.
#[test]
fn movers_to_the_left_and_to_the_right_are_covered_equally() {
    for (_, sampler) in SamplerKind::NAMES.into_iter().filter(|(_, sampler)| sampler.is_random()) {
        let total = |from: f64| {
            // Small and fast: it crosses a pixel in a tenth of the time between two of 16 samples.
            let keys = [(0.0, from), (1.0, -from)].map(|(time, x)| {
                format!(r#"<transform time="{time}"><scale x="0.5" y="8"/><translate x="{x}"/></transform>"#)
            });
            let scene = compiled(&format!(
                r#"{}<shape type="rectangle"><animation name="to_world">{}</animation></shape>"#,
                flat_camera(WIDTH, 16, SHUTTER),
                keys.concat(),
            ));
            let film = crate::common::expose(&scene, &settings(sampler, 16, 16, 2));
            mean(pixels(&film).map(|(x, y)| coverage(&film, x, y)))
        };
        let [right, left] = [-80.0, 80.0].map(total);
        let exact = Estimate::exact(1.0 / 160.0);
        for (name, p) in [
            ("left and right", welch(&right, &left).p_value),
            ("right", welch(&right, &exact).p_value),
            ("left", welch(&left, &exact).p_value),
        ] {
            println!("{sampler:?}, {name}: {} and {}, p {p:.3}", right.mean, left.mean);
            assert!(p > super::LEVEL, "{sampler:?}, {name}: p = {p:e}");
        }
    }
}

#[test]
fn a_hidden_wing_never_shows() {
    let wing = |z: f64, to: f64, what: &str| {
        let keys = [(0.0, -20.0), (1.0, to)].map(|(time, x)| {
            format!(
                r#"<transform time="{time}"><scale x="6" y="20"/><rotate z="1" angle="{}"/><translate x="{x}" z="{z}"/></transform>"#,
                30.0 * time
            )
        });
        format!(
            r#"<shape type="rectangle"><animation name="to_world">{}</animation>{what}</shape>"#,
            keys.concat()
        )
    };
    let black = r#"<bsdf type="diffuse"><spectrum name="reflectance" value="0"/></bsdf>"#;
    let light = r#"<emitter type="area"><spectrum name="radiance" value="1"/></emitter>"#;
    let seen = |to: f64| {
        let scene = compiled(&format!(
            "{}{}{}",
            flat_camera(64, 48, SHUTTER),
            wing(0.0, 20.0, black),
            wing(-5.0, to, light)
        ));
        let film = expose(&scene, 8, 32, 1);
        pixels(&film).map(|(x, y)| radiance(&film, x, y).mean).fold(0.0, f64::max)
    };
    assert_eq!(seen(20.0), 0.0);
    // The same wings one of which lags behind: then the test does see the lower one.
    assert!(seen(19.0) > 1e-3);
}
