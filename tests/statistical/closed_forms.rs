//! Whole renders against closed forms, wavelength by wavelength: furnaces, and the energy that gets through
//! dispersive glass. Each test bounds the standard error of what it measures: it sees five of them.
//! `validation/transport/furnace`, `validation/optics/slab` and `validation/optics/prism` claim more, of more
//! materials and integrators; `ABBE_STRESS=full` takes 16 times as many samples here, and sees a quarter.

use crate::common::{ALL_COUNTS, bins, bound, expose, mean_over_pixels, settings, spectral_scene, stress};
use abbe::film::Film;
use abbe::render::{Settings, WavelengthCount};
use abbe::sampling::SamplerKind;
use abbe::units::WavelengthRange;

const BINS: usize = 10;
const RANGES: [WavelengthRange; 2] = [WavelengthRange::VISIBLE, WavelengthRange { min: 380.0, max: 780.0 }];

/// The mean radiance of each bin with its standard error, for every number of wavelengths per path.
fn measure(
    file: &str,
    defines: &[(&str, &str)],
    range: WavelengthRange,
    samples: u32,
) -> Vec<Vec<(f64, f64)>> {
    let scene = spectral_scene(file, defines, range);
    ALL_COUNTS
        .map(|count| {
            let mut settings = settings(more(samples), count, 11 + count.get() as u64);
            settings.bins = bins(range, BINS);
            by_bin(&expose(&scene, &settings))
        })
        .to_vec()
}

fn more(samples: u32) -> u32 {
    samples * stress::count(1, 16)
}

/// The mean radiance of the whole range, which is surer than that of a bin.
fn measure_whole(defines: &[(&str, &str)], range: WavelengthRange, samples: u32) -> (f64, f64) {
    let settings = Settings { bins: bins(range, 1), ..settings(more(samples), WavelengthCount::Four, 23) };
    let film = expose(&spectral_scene(FURNACE, defines, range), &settings);
    mean_over_pixels(&film, |x, y| film.bin(x, y, 0))
}

fn by_bin(film: &Film) -> Vec<(f64, f64)> {
    (0..BINS).map(|bin| mean_over_pixels(film, |x, y| film.bin(x, y, bin))).collect()
}

const FURNACE: &str = "tests/scenes/closed/furnace.xml";

/// Sees 2 % in a bin, and 0.3 % in the mean of all.
#[test]
fn what_absorbs_nothing_vanishes_in_a_furnace() {
    // Where reflected and transmitted shares change with wavelength, companions weigh differently each time.
    let materials = [
        ("white", 3072),
        ("twosided", 3072),
        ("transmitter", 12_288),
        ("mirror", 3072),
        ("glass", 3072),
        ("matched", 3072),
        ("flint", 3072),
        ("reflectance", 3072),
    ];
    let bound = bound(materials.len() * RANGES.len() * (ALL_COUNTS.len() * BINS + 1));
    let mut worst = 0.0f64;
    let mut judge = |material: &str, (mean, error): (f64, f64), surest: f64| {
        assert!(error < surest, "{material}: standard error {error}");
        let deviation = (mean - 1.0).abs();
        worst = worst.max(deviation / error.max(1e-12));
        assert!(deviation <= bound * error + 1e-9, "{material}: {mean} ± {error}");
    };
    for (material, samples) in materials {
        for range in RANGES {
            let defines = [("bsdf", material)];
            for found in measure(FURNACE, &defines, range, samples).into_iter().flatten() {
                judge(material, found, 4e-3);
            }
            judge(material, measure_whole(&defines, range, samples), 6e-4);
        }
    }
    println!("largest deviation {worst:.2} standard errors of {bound:.2} allowed");
}

/// Every sampler that has replicates, where directions, lobes, survival and wavelengths all matter.
#[test]
fn a_furnace_is_one_with_every_sampler() {
    let range = WavelengthRange::VISIBLE;
    let kinds = SamplerKind::NAMES.into_iter().filter(|(_, kind)| kind.is_random());
    let bound = bound(kinds.clone().count() * 3 * BINS);
    for material in ["white", "transmitter", "flint"] {
        let scene = spectral_scene(FURNACE, &[("bsdf", material)], range);
        for (name, sampler) in kinds.clone() {
            let settings =
                Settings { sampler, bins: bins(range, BINS), ..settings(4096, WavelengthCount::Four, 3) };
            for (mean, error) in by_bin(&expose(&scene, &settings)) {
                assert!(error < 0.02, "{name}, {material}: standard error {error}");
                assert!((mean - 1.0).abs() <= bound * error + 1e-9, "{name}, {material}: {mean} ± {error}");
            }
        }
    }
}

/// What a ball of rough material returns of a furnace's radiance, stated in docs/trust.md: single scattering
/// loses the rest.
const STATED: [(&str, &str, f64); 6] = [
    ("roughmirror_ggx", "0.1", 0.978),
    ("roughmirror_ggx", "0.3", 0.857),
    ("roughmirror_beckmann", "0.3", 0.967),
    ("roughflint_ggx", "0.1", 0.937),
    ("roughflint_ggx", "0.3", 0.701),
    ("roughflint_beckmann", "0.3", 0.900),
];

/// Sees 5 % in a bin, and 0.5 % in the mean of all beyond the spread over wavelengths.
#[test]
fn rough_balls_return_what_is_stated_at_every_wavelength() {
    let bound = bound(STATED.len() * RANGES.len() * (ALL_COUNTS.len() * BINS + 1));
    let judge = |what: &str, (mean, error): (f64, f64), stated: f64, surest: f64| {
        println!("{what}: {mean:.4} ± {error:.1e}");
        assert!(error < surest, "{what}: standard error {error}");
        assert!(mean <= 1.0 + bound * error, "{what}: {mean} ± {error} makes energy");
        // The index of flint changes over the wavelengths, and what is lost with it, by less than 0.015.
        let spread = if what.contains("flint") { 0.015 } else { 0.0005 };
        assert!((mean - stated).abs() < spread + bound * error, "{what}: {mean} ± {error}");
    };
    for (material, alpha, stated) in STATED {
        let (defines, what) = ([("bsdf", material), ("alpha", alpha)], format!("{material}, alpha {alpha}"));
        for range in RANGES {
            for found in measure(FURNACE, &defines, range, 3072).into_iter().flatten() {
                judge(&what, found, stated, 1e-2);
            }
            judge(&what, measure_whole(&defines, range, 8192), stated, 1e-3);
        }
    }
}

/// What a white principled ball returns, stated in docs/trust.md: plugin, roughness, sheen, clear coat; as
/// Mitsuba has it, and where it conserves energy.
const PRINCIPLED: [(&str, &str, &str, &str, [f64; 2]); 7] = [
    ("principled", "0.1", "0", "0", [1.04, 0.98]),
    ("principled", "0.5", "0", "0", [1.055, 0.983]),
    ("principled", "1", "0", "0", [1.064, 0.972]),
    ("principled", "0.5", "1", "0", [1.063, 0.977]),
    ("principled", "0.5", "0", "1", [1.071, 0.986]),
    ("principledthin", "0.5", "0", "0", [1.006, 0.996]),
    ("principledthin", "1", "0", "0", [1.048, 0.974]),
];

/// Sees 4 % in a bin, and 0.5 % in the mean of all.
#[test]
fn principled_balls_make_energy_unless_they_conserve_it() {
    let range = WavelengthRange::VISIBLE;
    let bound = bound(PRINCIPLED.len() * 2 * (ALL_COUNTS.len() * BINS + 1));
    for (plugin, roughness, sheen, clearcoat, stated) in PRINCIPLED {
        for (conserve, stated) in ["false", "true"].into_iter().zip(stated) {
            let defines = [
                ("bsdf", plugin),
                ("alpha", roughness),
                ("sheen", sheen),
                ("clearcoat", clearcoat),
                ("conserve", conserve),
            ];
            let what = format!("{plugin} {roughness}, sheen {sheen}, coat {clearcoat}, {conserve}");
            let judge = |(mean, error): (f64, f64), surest: f64| {
                println!("{what}: {mean:.4} ± {error:.1e}");
                assert!(error < surest, "{what}: standard error {error}");
                assert!(conserve == "false" || mean <= 1.0 + bound * error, "{what}: {mean} ± {error}");
                assert!((mean - stated).abs() < 0.0006 + bound * error, "{what}: {mean} ± {error}");
            };
            for found in measure(FURNACE, &defines, range, 2048).into_iter().flatten() {
                judge(found, 8e-3);
            }
            judge(measure_whole(&defines, range, 1024), 1e-3);
        }
    }
}

/// SCHOTT SF11 by its Sellmeier coefficients (`data/dielectrics/dispersion_formulas.csv`), λ in nm.
fn sf11(nm: f64) -> f64 {
    let squared = (nm * 1e-3).powi(2);
    let terms = [(1.73848403, 0.0136068604), (0.311168974, 0.0615960463), (1.17490871, 121.922711)];
    (1.0 + terms.iter().map(|(b, c)| b * squared / (squared - c)).sum::<f64>()).sqrt()
}

/// Unpolarised reflectance from Fresnel's two equations.
fn fresnel(n1: f64, n2: f64, sin_incident: f64) -> f64 {
    let (cos_i, sin_t) = ((1.0 - sin_incident * sin_incident).sqrt(), n1 / n2 * sin_incident);
    if sin_t >= 1.0 {
        return 1.0;
    }
    let cos_t = (1.0 - sin_t * sin_t).sqrt();
    let s = (n1 * cos_i - n2 * cos_t) / (n1 * cos_i + n2 * cos_t);
    let p = (n2 * cos_i - n1 * cos_t) / (n2 * cos_i + n1 * cos_t);
    0.5 * (s * s + p * p)
}

/// The mean of a function of wavelength over each bin.
fn over_bins(range: WavelengthRange, f: impl Fn(f64) -> f64) -> Vec<f64> {
    let (width, steps) = (range.width() / BINS as f64, 1000);
    let mean = |bin: usize| {
        let nm = |i: usize| range.min + width * (bin as f64 + (i as f64 + 0.5) / steps as f64);
        (0..steps).map(|i| f(nm(i))).sum::<f64>() / steps as f64
    };
    (0..BINS).map(mean).collect()
}

/// Every bin of every number of wavelengths against what it should be.
fn assert_bins(file: &str, expected: impl Fn(f64) -> f64) {
    let range = WavelengthRange::VISIBLE;
    let expected = over_bins(range, expected);
    let bound = bound(ALL_COUNTS.len() * BINS);
    for (count, found) in ALL_COUNTS.iter().zip(measure(file, &[], range, 2048)) {
        for (bin, ((mean, error), expected)) in found.into_iter().zip(&expected).enumerate() {
            let z = (mean - expected) / error;
            println!("{count:?}, bin {bin}: {mean:.6} ± {error:.1e}, expected {expected:.6}, {z:+.2}");
            assert!(error < 4e-3, "{count:?}, bin {bin}: the error is {error}");
            assert!(z.abs() < bound, "{file}, {count:?}, bin {bin}: {mean} ± {error} is not {expected}");
        }
    }
}

#[test]
fn a_dispersive_slab_transmits_2n_over_n_squared_plus_1_in_every_bin() {
    assert_bins("tests/scenes/closed/slab.xml", |nm| {
        let n = sf11(nm);
        2.0 * n / (n * n + 1.0)
    });
}

#[test]
fn a_dispersive_prism_transmits_what_fresnel_says_in_every_bin() {
    assert_bins("tests/scenes/closed/prism.xml", |nm| {
        let (n, apex, incident) = (sf11(nm), 60f64.to_radians(), 60f64.to_radians());
        let inside = (incident.sin() / n).asin();
        let at_exit = (apex - inside).sin();
        (1.0 - fresnel(1.0, n, incident.sin())) * (1.0 - fresnel(n, 1.0, at_exit)) // 0 where violet is reflected totally
    });
}

/// Chance has no part in it: a path goes both ways where either brings something.
#[test]
fn what_glass_mirrors_of_a_lamp_is_in_every_sample() {
    let expected = fresnel(1.0, 1.5, 75f64.to_radians().sin());
    // Narrow, so that nothing depends on which wavelengths are sampled.
    let range = WavelengthRange { min: 550.0, max: 550.000001 };
    let scene = spectral_scene("tests/scenes/closed/glance.xml", &[], range);
    for count in ALL_COUNTS {
        let mut settings = settings(8, count, 5);
        settings.bins = bins(range, 1);
        let film = expose(&scene, &settings);
        let (mean, error) = mean_over_pixels(&film, |x, y| film.bin(x, y, 0));
        println!("{mean:.8} ± {error:.1e}, expected {expected:.8}");
        // What is in view is a ten-millionth as wide as the body, so the angle differs by less than a
        // millionth of a radian.
        assert!((mean - expected).abs() < 1e-6, "{mean} is not {expected}");
        assert!(error < 1e-6, "the error is {error}");
    }
}
