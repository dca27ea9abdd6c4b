//! What the whole-program tests share: from a scene's text to an exposed film.

#![allow(dead_code)] // each test file uses its own part

use abbe::film::{Film, SpectralBins};
use abbe::integrator::Estimator;
use abbe::render::{NoProgress, Schedule, Settings, WavelengthCount, render};
use abbe::sampling::SamplerKind;
use abbe::scene::{CompileOptions, ReadOptions, Scene, compile, read};
use abbe::units::WavelengthRange;
use std::path::Path;

pub const ALL_COUNTS: [WavelengthCount; 3] =
    [WavelengthCount::One, WavelengthCount::Four, WavelengthCount::Eight];

/// Compiles a scene file with values for its `<default>`s.
pub fn scene(file: &str, defines: &[(&str, &str)], range: WavelengthRange) -> Scene {
    compiled(file, defines, CompileOptions { range, ..CompileOptions::default() })
}

/// The same for measuring spectral bins.
pub fn spectral_scene(file: &str, defines: &[(&str, &str)], range: WavelengthRange) -> Scene {
    compiled(file, defines, CompileOptions { range, spectral: true, ..CompileOptions::default() })
}

fn compiled(file: &str, defines: &[(&str, &str)], options: CompileOptions) -> Scene {
    let defines = defines.iter().map(|&(name, value)| (name.to_owned(), value.to_owned())).collect();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    let description = read(&path, &ReadOptions { defines, ..ReadOptions::default() })
        .unwrap_or_else(|errors| panic!("{errors}"));
    compile(&description, &options).unwrap_or_else(|errors| panic!("{errors}"))
}

pub fn settings(samples: u32, wavelengths: WavelengthCount, seed: u64) -> Settings {
    // Pixels and replicates that are independent of one another: that is what the tests' statistics rest on.
    let dealt = Schedule::new(samples);
    Settings {
        schedule: Schedule::independent(dealt.replicates, dealt.samples_per_replicate),
        seed,
        sampler: SamplerKind::Sobol,
        wavelengths,
        estimator: Estimator::Plain,
        bins: None,
    }
}

pub fn bins(range: WavelengthRange, count: usize) -> Option<SpectralBins> {
    Some(SpectralBins { range, count })
}

pub fn expose(scene: &Scene, settings: &Settings) -> Film {
    let film = render(scene, settings, &NoProgress::new());
    assert_eq!(film.bad.total(), 0, "bad values: {:?}", film.bad);
    film
}

/// The mean over all pixels of something measured, and its standard error. Pixels must be independent: the
/// film has a box filter, and the [`settings`] are those above. Elsewhere `Film::mean_over` says it.
pub fn mean_over_pixels(film: &Film, measure: impl Fn(u32, u32) -> abbe::film::Measured) -> (f64, f64) {
    let n = f64::from(film.width) * f64::from(film.height);
    let pixels = (0..film.height).flat_map(|y| (0..film.width).map(move |x| (x, y)));
    let (mean, variance) = pixels.fold((0.0, 0.0), |(mean, variance), (x, y)| {
        let m = measure(x, y);
        (mean + m.mean, variance + m.error * m.error)
    });
    (mean / n, variance.sqrt() / n)
}
