//! What the whole-program tests share: from a scene's text to an exposed film.

#![allow(dead_code)] // each binary uses its own part

#[cfg(unix)]
pub mod browser;
pub mod folder;
pub mod mutation;
pub mod stress;

use abbe::film::{Film, SpectralBins};
use abbe::integrator::Estimator;
use abbe::render::{NoProgress, Schedule, Settings, WavelengthCount, render};
use abbe::sampling::SamplerKind;
use abbe::scene::{CompileOptions, Description, ReadOptions, Scene, compile, read, read_str};
use abbe::stats::sidak;
use abbe::units::WavelengthRange;
use statrs::distribution::{ContinuousCDF, Normal};
use std::path::Path;

pub const ALL_COUNTS: [WavelengthCount; 3] =
    [WavelengthCount::One, WavelengthCount::Four, WavelengthCount::Eight];

/// What stands in a text file.
pub fn text_of(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Compiles a scene file with values for its `<default>`s.
pub fn scene(file: &str, defines: &[(&str, &str)], range: WavelengthRange) -> Scene {
    compiled(&described_file(file, defines), &CompileOptions { range, ..CompileOptions::default() })
}

/// The same for measuring spectral bins.
pub fn spectral_scene(file: &str, defines: &[(&str, &str)], range: WavelengthRange) -> Scene {
    let options = CompileOptions { range, spectral: true, ..CompileOptions::default() };
    compiled(&described_file(file, defines), &options)
}

/// What a scene file says, with values for its `<default>`s.
pub fn described_file(file: &str, defines: &[(&str, &str)]) -> Description {
    let defines = defines.iter().map(|&(name, value)| (name.to_owned(), value.to_owned())).collect();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    read(&path, &ReadOptions { defines, ..ReadOptions::default() })
        .unwrap_or_else(|errors| panic!("{errors}"))
}

pub fn compiled(description: &Description, options: &CompileOptions) -> Scene {
    compile(description, options).unwrap_or_else(|errors| panic!("{errors}"))
}

/// What a scene of this content is. Files are named from the root of the repository.
pub fn described(content: &str) -> Description {
    let text = format!(r#"<scene version="3.0.0">{content}</scene>"#);
    read_str(text, Path::new("scene.xml"), &ReadOptions::default())
        .unwrap_or_else(|errors| panic!("{errors}"))
}

/// The same, compiled.
pub fn made(content: &str, options: &CompileOptions) -> Scene {
    compiled(&described(content), options)
}

/// Standard errors within which all of `tests` results lie with 99 % probability if nothing is wrong. Never
/// less than 3.
pub fn bound(tests: usize) -> f64 {
    let tail = sidak(0.01, tests) / 2.0;
    Normal::standard().inverse_cdf(1.0 - tail).max(3.0)
}

/// Standard errors of a difference that a test which allows `bound` of them finds with a probability of 90 %.
pub fn found(bound: f64) -> f64 {
    bound + Normal::standard().inverse_cdf(0.9)
}

pub fn settings(samples: u32, wavelengths: WavelengthCount, seed: u64) -> Settings {
    // Pixels and replicates that are independent of one another: that is what the tests' statistics rest on.
    let dealt = Schedule::new(samples);
    Settings {
        schedule: Schedule::independent(dealt.replicates, dealt.samples_per_replicate),
        seed,
        sampler: SamplerKind::Sobol,
        wavelengths: Some(wavelengths),
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
