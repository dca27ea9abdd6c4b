//! The same picture in expectation, whatever the number of wavelengths a path carries, whether pixels share the suffixes of their
//! paths, and for the random walk that knows of no light sampling, no weights and no companions: Welch's t-test per pixel,
//! channel by channel. Pixels that share have noise in common, so means over them are judged by those of each replicate.

use crate::common::{ALL_COUNTS, expose, scene, settings};
use abbe::film::{Film, Measured, Quantity, Region};
use abbe::integrator::Estimator;
use abbe::render::{Settings, WavelengthCount};
use abbe::scene::Scene;
use abbe::stats::{Estimate, Welch, sidak, welch};
use abbe::units::WavelengthRange;

const XYZ: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

struct Case {
    name: &'static str,
    samples: u32,
    /// The walk needs more, because it finds lights by chance. 0 where it cannot find them at all.
    walk_samples: u32,
    /// Columns, and rows, of the blocks of pixels that are compared with the walk's.
    walk_block: u32,
}

const CASES: [Case; 17] = [
    Case { name: "diffuse", samples: 1024, walk_samples: 16_384, walk_block: 1 },
    Case { name: "metals", samples: 1024, walk_samples: 4096, walk_block: 1 },
    // What is seen through one body and lit through another is found seldom, by the walk never in some pixels: there it knows no error.
    Case { name: "dispersion", samples: 16_384, walk_samples: 65_536, walk_block: 4 },
    Case { name: "frosted", samples: 2048, walk_samples: 4096, walk_block: 1 },
    Case { name: "absorption", samples: 1024, walk_samples: 4096, walk_block: 1 },
    Case { name: "lines", samples: 2048, walk_samples: 16_384, walk_block: 1 },
    Case { name: "extentless", samples: 1024, walk_samples: 0, walk_block: 1 },
    Case { name: "veils", samples: 1024, walk_samples: 8192, walk_block: 1 },
    // A pixel at the border sees light by way of the glass alone, in few samples: with 1024 its error bar was too small by far.
    Case { name: "motion", samples: 4096, walk_samples: 8192, walk_block: 1 },
    Case { name: "contact", samples: 1024, walk_samples: 8192, walk_block: 1 },
    Case { name: "quadrics", samples: 1024, walk_samples: 8192, walk_block: 1 },
    Case { name: "solids", samples: 1024, walk_samples: 8192, walk_block: 1 },
    Case { name: "caustics", samples: 2048, walk_samples: 65_536, walk_block: 1 },
    Case { name: "lamps", samples: 1024, walk_samples: 16_384, walk_block: 2 },
    Case { name: "chamber", samples: 4096, walk_samples: 65_536, walk_block: 1 },
    Case { name: "fog", samples: 1024, walk_samples: 16_384, walk_block: 1 },
    Case { name: "smoke", samples: 1024, walk_samples: 8192, walk_block: 1 },
];

fn load(case: &Case, integrator: &str) -> Scene {
    let file = format!("tests/scenes/agreement/{}.xml", case.name);
    scene(&file, &[("integrator", integrator)], WavelengthRange::VISIBLE)
}

/// The mean over some pixels, with an error that holds what a filter and light paths make them have in
/// common.
fn mean_over(film: &Film, pixels: impl IntoIterator<Item = (u32, u32)>, weights: [f64; 3]) -> Estimate {
    let Measured { mean, error } = film.mean_over(pixels, Quantity::Combined(weights));
    Estimate { mean, variance: error.powi(2), degrees: f64::from(film.replicates) - 1.0 }
}

/// The smallest p-value over blocks of pixels and channels after Šidák's correction, and the test of the mean
/// luminances.
fn compare(a: &Film, b: &Film, block: u32) -> (f64, Welch) {
    let mut tests = 0;
    let mut smallest = 1.0f64;
    for y in (0..a.height).step_by(block as usize) {
        for x in (0..a.width).step_by(block as usize) {
            for weights in XYZ {
                let area = Region { offset: [x, y], size: [block.min(a.width - x), block.min(a.height - y)] };
                let [p, q] = [a, b].map(|film| mean_over(film, area.pixels().map(|[x, y]| (x, y)), weights));
                // Two pixels without noise are equal up to rounding, or they differ.
                if p.variance.max(q.variance).sqrt() <= 1e-7 * p.mean.abs() {
                    assert!((p.mean - q.mean).abs() <= 1e-6 * p.mean.abs(), "{p:?} {q:?}");
                    continue;
                }
                tests += 1;
                smallest = smallest.min(welch(&p, &q).p_value);
            }
        }
    }
    let corrected = 1.0 - (1.0 - smallest).powi(tests.max(1));
    let [mean_a, mean_b] = [a, b].map(|film| mean_over(film, film.shown(), XYZ[1]));
    (corrected, welch(&mean_a, &mean_b))
}

/// Of each part of a verdict: 1 % over all comparisons of this file.
fn level() -> f64 {
    sidak(0.01, 2 * (CASES.len() * 6 + 5))
}

/// Both parts of the verdict.
fn assert_same(what: &str, a: &Film, b: &Film, block: u32) {
    let (p, means) = compare(a, b, block);
    println!("{what}: smallest p {p:.3}; of the means {means}");
    assert!(p > level(), "{what}: a pixel differs, p = {p:e}");
    assert!(means.p_value > level(), "{what}: the means differ: {means}");
}

fn agrees(name: &str) {
    let case = CASES.iter().find(|case| case.name == name).unwrap();
    let path = load(case, "path");
    let films = ALL_COUNTS.map(|count| expose(&path, &settings(case.samples, count, 1 + count.get() as u64)));
    assert_same(&format!("{name}, 4 and 1"), &films[1], &films[0], 1);
    assert_same(&format!("{name}, 4 and 8"), &films[1], &films[2], 1);
    for (count, plain) in ALL_COUNTS.into_iter().zip(&films) {
        let plan = Settings {
            estimator: Estimator::Shared,
            ..settings(case.samples, count, 11 + count.get() as u64)
        };
        assert_same(&format!("{name}, shared and plain, {count}"), &expose(&path, &plan), plain, 1);
    }
    if case.walk_samples > 0 {
        let walk = expose(&load(case, "walk"), &settings(case.walk_samples, WavelengthCount::One, 9));
        assert_same(&format!("{name}, path and walk"), &films[1], &walk, case.walk_block);
    }
}

#[test]
fn diffuse() {
    agrees("diffuse");
}

#[test]
fn metals() {
    agrees("metals");
}

#[test]
fn dispersion() {
    agrees("dispersion");
}

#[test]
fn frosted() {
    agrees("frosted");
}

#[test]
fn absorption() {
    agrees("absorption");
}

#[test]
fn lines() {
    agrees("lines");
}

#[test]
fn extentless() {
    agrees("extentless");
}

#[test]
fn motion() {
    agrees("motion");
}

/// Quadrics as lights, whose light samples are chords, and as things that stand in the light.
#[test]
fn quadrics() {
    agrees("quadrics");
}

/// Bodies with faces in common and priorities: also where light samples pass through what is hidden.
#[test]
fn contact() {
    agrees("contact");
    let case = CASES.iter().find(|case| case.name == "contact").unwrap();
    let [path, volpath] = ["path", "volpath"].map(|integrator| {
        expose(&load(case, integrator), &settings(case.samples, WavelengthCount::Four, 21))
    });
    assert_same("contact, path and volpath", &path, &volpath, 1);
}

/// Light paths find what chance finds, and are what finds it.
#[test]
fn caustics() {
    agrees("caustics");
    let case = CASES.iter().find(|case| case.name == "caustics").unwrap();
    assert!(load(case, "path").needs().light_paths && !load(case, "walk").needs().light_paths);
}

#[test]
fn lamps() {
    agrees("lamps");
}

/// Light paths go on where they have been scattered, and share with paths from the camera what both find.
#[test]
fn chamber() {
    agrees("chamber");
    let case = CASES.iter().find(|case| case.name == "chamber").unwrap();
    assert!(load(case, "path").needs().light_paths);
}

/// Media that scatter: the walk tracks them with null collisions, and knows nothing of densities of distances.
#[test]
fn fog() {
    media_agree("fog");
}

/// Grids: what is integrated piece by piece is what null collisions find.
#[test]
fn smoke() {
    media_agree("smoke");
}

/// Also where light samples pass the boundaries of media.
fn media_agree(name: &str) {
    agrees(name);
    let case = CASES.iter().find(|case| case.name == name).unwrap();
    assert!(load(case, "path").needs().scattering);
    let [path, volpath] = ["path", "volpath"].map(|integrator| {
        expose(&load(case, integrator), &settings(case.samples, WavelengthCount::Four, 21))
    });
    assert_same(&format!("{name}, path and volpath"), &path, &volpath, 1);
}

/// All that light samples lose in its shadow comes back on light paths.
#[test]
fn a_ball_of_air_casts_no_shadow() {
    let with = |height: &str| {
        scene("tests/scenes/agreement/air.xml", &[("height", height)], WavelengthRange::VISIBLE)
    };
    assert!(with("1").needs().light_paths);
    let films = ["1", "-2"].map(|height| expose(&with(height), &settings(1024, WavelengthCount::Four, 3)));
    assert_same("a ball of air and none", &films[0], &films[1], 1);
}

/// Lights of which parts are cut away, or lie within other parts, some of them moving.
#[test]
fn solids() {
    agrees("solids");
}

/// Light samples that pass through what is not there find what paths find behind it.
#[test]
fn veils() {
    agrees("veils");
    let case = CASES.iter().find(|case| case.name == "veils").unwrap();
    let [path, volpath] = ["path", "volpath"].map(|integrator| {
        expose(&load(case, integrator), &settings(case.samples, WavelengthCount::Four, 21))
    });
    assert_same("veils, path and volpath", &path, &volpath, 1);
}

/// The test of the test: one per cent more light is seen.
#[test]
fn a_brighter_lamp_is_noticed() {
    let file = "tests/scenes/agreement/brighter.xml";
    let at = |radiance: &str| scene(file, &[("radiance", radiance)], WavelengthRange::VISIBLE);
    let films =
        ["1", "1.01"].map(|radiance| expose(&at(radiance), &settings(1024, WavelengthCount::Four, 3)));
    let (_, means) = compare(&films[0], &films[1], 1);
    assert!(means.p_value < level(), "{means}");
}
