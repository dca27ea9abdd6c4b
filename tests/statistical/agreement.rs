//! The same picture in expectation, whatever the number of wavelengths a path carries, whether pixels share
//! the suffixes of their paths, and for the random walk that knows of no light sampling, no weights and no
//! companions: Welch's t-test per pixel, channel by channel. Pixels that share have noise in common, so means
//! over them are judged by those of each replicate.
//!
//! Each scene states how small a difference of the mean luminances its tests find in nine of ten cases.
//! `ABBE_STRESS=full` takes 16 times as many samples, and finds a quarter of it.

use crate::common::{ALL_COUNTS, compiled, described_file, expose, settings, stress};
use abbe::film::{Film, Measured, Quantity, Region};
use abbe::integrator::{Estimator, why_nothing_is_shared};
use abbe::render::{Schedule, Settings, WavelengthCount};
use abbe::scene::{CompileOptions, Scene};
use abbe::stats::{Estimate, Welch, sidak, student_quantile, welch};

const XYZ: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Columns and rows of the pictures.
const SIZE: u32 = 8;

/// Few replicates would leave the errors uncertain, and Student's t would see only large differences.
const REPLICATES: u32 = 16;

struct Case {
    name: &'static str,
    samples: u32,
    /// The walk needs more, because it finds lights by chance. 0 where it cannot find them at all.
    walk_samples: u32,
    /// Columns, and rows, of the blocks of pixels that are compared with the walk's.
    walk_block: u32,
    /// Relative difference of the mean luminances that every comparison of the scene finds with a probability
    /// of 90 %.
    sees: f64,
}

const CASES: [Case; 30] = [
    Case { name: "diffuse", samples: 512, walk_samples: 16_384, walk_block: 1, sees: 0.065 },
    Case { name: "metals", samples: 1024, walk_samples: 2048, walk_block: 1, sees: 0.02 },
    // What is seen through one body and lit through another is found seldom, by the walk never in some
    // pixels: there it knows no error.
    Case { name: "dispersion", samples: 3072, walk_samples: 12_288, walk_block: 4, sees: 0.023 },
    Case { name: "frosted", samples: 640, walk_samples: 2560, walk_block: 1, sees: 0.03 },
    Case { name: "absorption", samples: 512, walk_samples: 2048, walk_block: 1, sees: 0.015 },
    Case { name: "lines", samples: 640, walk_samples: 6144, walk_block: 1, sees: 0.06 },
    Case { name: "extentless", samples: 640, walk_samples: 0, walk_block: 1, sees: 0.04 },
    Case { name: "veils", samples: 1024, walk_samples: 8192, walk_block: 1, sees: 0.08 },
    Case { name: "panes", samples: 2048, walk_samples: 16_384, walk_block: 1, sees: 0.08 },
    // A pixel at the border sees light by way of the glass alone, in few samples.
    Case { name: "motion", samples: 1536, walk_samples: 3072, walk_block: 1, sees: 0.055 },
    Case { name: "contact", samples: 768, walk_samples: 6144, walk_block: 1, sees: 0.055 },
    Case { name: "quadrics", samples: 1024, walk_samples: 8192, walk_block: 1, sees: 0.07 },
    Case { name: "solids", samples: 1024, walk_samples: 4096, walk_block: 1, sees: 0.1 },
    Case { name: "caustics", samples: 768, walk_samples: 24_576, walk_block: 1, sees: 0.07 },
    Case { name: "polish", samples: 1024, walk_samples: 32_768, walk_block: 2, sees: 0.025 },
    Case { name: "visible_lamps", samples: 512, walk_samples: 24_576, walk_block: 1, sees: 0.07 },
    Case { name: "skylight", samples: 512, walk_samples: 8192, walk_block: 1, sees: 0.07 },
    Case { name: "lamps", samples: 1024, walk_samples: 16_384, walk_block: 2, sees: 0.07 },
    Case { name: "chamber", samples: 1536, walk_samples: 24_576, walk_block: 1, sees: 0.08 },
    Case { name: "coats", samples: 1024, walk_samples: 16_384, walk_block: 1, sees: 0.08 },
    Case { name: "glaze", samples: 8192, walk_samples: 131_072, walk_block: 1, sees: 0.07 },
    Case { name: "facets", samples: 4096, walk_samples: 0, walk_block: 1, sees: 0.08 },
    Case { name: "surface", samples: 8192, walk_samples: 16_384, walk_block: 1, sees: 0.07 },
    Case { name: "relief", samples: 8192, walk_samples: 32_768, walk_block: 1, sees: 0.07 },
    Case { name: "fibre", samples: 4096, walk_samples: 65_536, walk_block: 2, sees: 0.08 },
    Case { name: "window", samples: 1024, walk_samples: 16_384, walk_block: 1, sees: 0.08 },
    Case { name: "fog", samples: 640, walk_samples: 5120, walk_block: 1, sees: 0.09 },
    Case { name: "smoke", samples: 512, walk_samples: 2048, walk_block: 1, sees: 0.06 },
    Case { name: "haze", samples: 512, walk_samples: 4096, walk_block: 1, sees: 0.06 },
    Case { name: "beacons", samples: 1024, walk_samples: 32_768, walk_block: 1, sees: 0.09 },
];

fn case(name: &str) -> &'static Case {
    CASES.iter().find(|case| case.name == name).expect("a case")
}

/// A scene of the folder, seen by few pixels.
fn small(name: &str, defines: &[(&str, &str)]) -> Scene {
    let mut description = described_file(&format!("tests/scenes/agreement/{name}.xml"), defines);
    (description.sensor.film.width, description.sensor.film.height) = (SIZE, SIZE);
    compiled(&description, &CompileOptions::default())
}

fn load(case: &Case, integrator: &str) -> Scene {
    small(case.name, &[("integrator", integrator)])
}

fn plan(samples: u32, wavelengths: WavelengthCount, seed: u64) -> Settings {
    let each = samples * stress::count(1, 16) / REPLICATES;
    Settings { schedule: Schedule::independent(REPLICATES, each), ..settings(samples, wavelengths, seed) }
}

/// The mean over some pixels, with an error that holds what a filter and light subpaths make them have in
/// common.
fn mean_over(film: &Film, pixels: impl IntoIterator<Item = (u32, u32)>, weights: [f64; 3]) -> Estimate {
    let Measured { mean, error } = film.mean_over(pixels, Quantity::Combined(weights));
    Estimate { mean, variance: error.powi(2), degrees: f64::from(film.replicates) - 1.0 }
}

/// What the comparison of two pictures finds.
struct Verdict {
    /// The smallest p-value over blocks of pixels and channels, after Šidák's correction.
    smallest: f64,
    /// Welch's test of the mean luminances.
    means: Welch,
    /// Relative difference of the mean luminances that would be found with a probability of 90 %.
    sees: f64,
    /// The same for the luminance of a block of pixels, the median of all.
    sees_in_block: f64,
}

/// The relative difference that Welch's test of these estimates finds at a level with a probability of 90 %.
fn sees(a: &Estimate, b: &Estimate, level: f64) -> f64 {
    let degrees = welch(a, b).degrees;
    let quantiles = student_quantile(1.0 - 0.5 * level, degrees) + student_quantile(0.9, degrees);
    quantiles * (a.variance + b.variance).sqrt() / b.mean.abs()
}

fn compare(a: &Film, b: &Film, block: u32) -> Verdict {
    let mut pairs = Vec::new();
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
                pairs.push((p, q));
            }
        }
    }
    let smallest = pairs.iter().map(|(p, q)| welch(p, q).p_value).fold(1.0, f64::min);
    let mut in_blocks: Vec<f64> =
        pairs.iter().map(|(p, q)| sees(p, q, sidak(level(), pairs.len()))).collect();
    in_blocks.sort_by(f64::total_cmp);
    let [mean_a, mean_b] = [a, b].map(|film| mean_over(film, film.shown(), XYZ[1]));
    Verdict {
        smallest: 1.0 - (1.0 - smallest).powi(pairs.len().max(1) as i32),
        means: welch(&mean_a, &mean_b),
        sees: sees(&mean_a, &mean_b, level()),
        sees_in_block: in_blocks.get(in_blocks.len() / 2).copied().unwrap_or(0.0),
    }
}

/// Level of each part of a verdict: 1 % over all comparisons of this file.
fn level() -> f64 {
    sidak(0.01, 2 * (CASES.len() * 6 + 8))
}

/// Both parts of the verdict, and that they could have been otherwise.
fn assert_same(what: &str, a: &Film, b: &Film, block: u32, least: f64) {
    let Verdict { smallest, means, sees, sees_in_block } = compare(a, b, block);
    println!(
        "{what}: smallest p {smallest:.3}; of the means {means}; {:.2} % are seen, {:.0} % in a block",
        100.0 * sees,
        100.0 * sees_in_block
    );
    assert!(smallest > level(), "{what}: a pixel differs, p = {smallest:e}");
    assert!(means.p_value > level(), "{what}: the means differ: {means}");
    assert!(sees < least, "{what}: a difference of {sees} may go unseen");
}

fn agrees(name: &str) {
    let case = case(name);
    let path = load(case, "path");
    let films = ALL_COUNTS.map(|count| expose(&path, &plan(case.samples, count, 1 + count.get() as u64)));
    assert_same(&format!("{name}, 4 and 1"), &films[1], &films[0], 1, case.sees);
    assert_same(&format!("{name}, 4 and 8"), &films[1], &films[2], 1, case.sees);
    // Where nothing is shared, both are the same paths.
    let is_shared = why_nothing_is_shared(&path).is_none();
    for (count, plain) in ALL_COUNTS.into_iter().zip(&films).filter(|_| is_shared) {
        let plan =
            Settings { estimator: Estimator::Shared, ..plan(case.samples, count, 11 + count.get() as u64) };
        let what = format!("{name}, shared and plain, {count}");
        assert_same(&what, &expose(&path, &plan), plain, 1, case.sees);
    }
    if case.walk_samples > 0 {
        let walk = expose(&load(case, "walk"), &plan(case.walk_samples, WavelengthCount::One, 9));
        assert_same(&format!("{name}, path and walk"), &films[1], &walk, case.walk_block, case.sees);
    }
}

fn volpath_agrees(name: &str) {
    let case = case(name);
    let [path, volpath] = ["path", "volpath"]
        .map(|integrator| expose(&load(case, integrator), &plan(case.samples, WavelengthCount::Four, 21)));
    assert_same(&format!("{name}, path and volpath"), &path, &volpath, 1, case.sees);
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
    volpath_agrees("contact");
}

/// Light subpaths find what chance finds, and are what finds it.
#[test]
fn caustics() {
    agrees("caustics");
    let case = case("caustics");
    assert!(load(case, "path").features().caustics && !load(case, "walk").features().caustics);
}

/// Light subpaths, light samples and scattering find what polished metals send on, and each weighs the
/// others.
#[test]
fn polish() {
    agrees("polish");
    assert!(load(case("polish"), "path").features().caustics);
}

/// Lamps that a lens spreads, and one of less than a pixel, are found from their own side.
#[test]
fn visible_lamps() {
    agrees("visible_lamps");
    let case = case("visible_lamps");
    let [path, walk] = ["path", "walk"].map(|integrator| load(case, integrator));
    assert!(
        path.features().visible_lamps && path.visible_lamps().is_some() && walk.light_tracing().is_none()
    );
}

/// Light subpaths from beyond the scene, too.
#[test]
fn skylight() {
    agrees("skylight");
    let case = case("skylight");
    assert!(load(case, "path").features().caustics && !load(case, "walk").features().caustics);
}

#[test]
fn lamps() {
    agrees("lamps");
}

/// Light subpaths go on where they have been scattered, and share with paths from the camera what both find.
#[test]
fn chamber() {
    agrees("chamber");
    assert!(load(case("chamber"), "path").features().caustics);
}

/// What a coat mirrors and what its base scatters, each by itself on the first surface.
#[test]
fn coats() {
    agrees("coats");
    assert!(load(case("coats"), "path").features().caustics);
}

/// What coats cast: a ceiling has no other light.
#[test]
fn glaze() {
    agrees("glaze");
    assert!(load(case("glaze"), "path").features().caustics);
}

/// What sees the back of a shading normal shares nothing with what sees its front.
#[test]
fn facets() {
    agrees("facets");
}

/// What is behind an open surface has no bounds, so light subpaths do not know where they begin.
#[test]
fn surface() {
    agrees("surface");
    assert!(!load(case("surface"), "path").features().caustics);
}

/// A curve is met from outside alone: light that goes back gets out where it would have to get in.
#[test]
fn fibre() {
    agrees("fibre");
    assert!(!load(case("fibre"), "path").features().caustics);
}

/// Light that comes by a surface with a normal map, which scatters by a frame of its own from either end.
#[test]
fn relief() {
    agrees("relief");
    assert!(load(case("relief"), "path").features().caustics);
}

/// What shared suffixes find behind glass, where they split.
#[test]
fn window() {
    agrees("window");
    assert!(load(case("window"), "path").features().caustics);
}

/// Media that scatter: the walk tracks them with null collisions, and knows nothing of densities of
/// distances.
#[test]
fn fog() {
    media_agree("fog");
}

/// Grids: what is integrated piece by piece is what null collisions find.
#[test]
fn smoke() {
    media_agree("smoke");
}

#[test]
fn haze() {
    media_agree("haze");
}

/// Lamps in fog, to which distances are chosen.
#[test]
fn beacons() {
    assert!(load(case("beacons"), "path").limits.aims_at_lamps);
    media_agree("beacons");
}

/// Distances chosen by a spot light, which the walk never finds, change nothing but the noise, for every
/// number of wavelengths.
#[test]
fn aiming_at_lamps_changes_the_noise_alone() {
    let mut scenes = [(); 2].map(|()| small("beam", &[]));
    assert!(scenes[0].limits.aims_at_lamps);
    scenes[1].limits.aims_at_lamps = false;
    for count in ALL_COUNTS {
        let films = [0, 1].map(|i| expose(&scenes[i], &plan(1280, count, 31 + i as u64)));
        assert_same(&format!("a beam aimed at and not, {count}"), &films[0], &films[1], 1, 0.09);
    }
}

/// Also where light samples pass the boundaries of media.
fn media_agree(name: &str) {
    agrees(name);
    assert!(load(case(name), "path").features().scattering);
    volpath_agrees(name);
}

/// All that light samples lose in its shadow comes back on light subpaths.
#[test]
fn a_ball_of_air_casts_no_shadow() {
    let with = |height: &str| small("air", &[("height", height)]);
    assert!(with("1").features().caustics);
    let films = ["1", "-2"].map(|height| expose(&with(height), &plan(1024, WavelengthCount::Four, 3)));
    assert_same("a ball of air and none", &films[0], &films[1], 1, 0.011);
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
    volpath_agrees("veils");
}

/// The same through panes, which are segments of the path: light samples pass no more of them than paths of
/// so many segments do.
#[test]
fn panes() {
    agrees("panes");
    volpath_agrees("panes");
    let case = case("panes");
    for depth in ["2", "3", "4"] {
        let limited = |integrator| small("panes", &[("integrator", integrator), ("depth", depth)]);
        let (path, walk) = (limited("path"), limited("walk"));
        assert_eq!(path.features().transparent_shadows, depth != "2");
        let path = expose(&path, &plan(case.samples, WavelengthCount::Four, 5));
        let walk = expose(&walk, &plan(case.walk_samples, WavelengthCount::One, 6));
        assert_same(&format!("{depth} segments, path and walk"), &path, &walk, 1, case.sees);
    }
}

/// The test of the test: one per cent more light is seen.
#[test]
fn a_brighter_lamp_is_noticed() {
    let films = ["1", "1.01"].map(|radiance| {
        let scene = small("brighter", &[("radiance", radiance)]);
        expose(&scene, &plan(16_384, WavelengthCount::Four, 3))
    });
    let verdict = compare(&films[0], &films[1], 1);
    println!("{:.2} % are seen", 100.0 * verdict.sees);
    assert!(verdict.means.p_value < level() && verdict.sees < 0.01, "{}", verdict.means);
}
