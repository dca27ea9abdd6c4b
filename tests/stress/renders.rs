//! What the tests that render share: from a scene's text to estimates of radiance.

use abbe::film::{Film, Measured, SpectralBins};
use abbe::integrator::Estimator;
use abbe::render::{NoProgress, Schedule, Settings, WavelengthCount, render};
use abbe::sampling::SamplerKind;
use abbe::scene::{CompileOptions, Description, ReadOptions, Scene, compile, read_str};
use abbe::stats::Estimate;
use abbe::units::WavelengthRange;
use std::path::Path;

/// Replicates of every render.
pub const REPLICATES: u32 = 16;

/// The whole spectrum in one bin, so that radiance is measured as such.
const ONE_BIN: SpectralBins = SpectralBins { range: WavelengthRange::VISIBLE, count: 1 };

/// Reads the content of a scene. Files are named from the folder `scenes`.
pub fn description(content: &str) -> Description {
    let text = format!(r#"<scene version="3.0.0">{content}</scene>"#);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/scene.xml");
    read_str(text, &path, &ReadOptions::default()).unwrap_or_else(|errors| panic!("{errors}"))
}

pub fn compiled(description: &Description) -> Scene {
    let options = CompileOptions { spectral: true, ..CompileOptions::default() };
    compile(description, &options).unwrap_or_else(|errors| panic!("{errors}"))
}

/// Independent samples, so that every pixel is an estimate of its own.
pub fn expose(scene: &Scene, samples_per_replicate: u32, seed: u64) -> Film {
    let settings = Settings {
        schedule: Schedule::independent(REPLICATES, samples_per_replicate),
        seed,
        sampler: SamplerKind::Independent,
        wavelengths: Some(WavelengthCount::Four),
        estimator: Estimator::Plain,
        bins: Some(ONE_BIN),
    };
    render(scene, &settings, &NoProgress::new())
}

/// Spectral radiance of all pixels, row by row.
pub fn radiances(film: &Film) -> Vec<Estimate> {
    let estimate = |Measured { mean, error }: Measured| Estimate {
        mean,
        variance: error * error,
        degrees: f64::from(REPLICATES - 1),
    };
    let pixels = (0..film.height).flat_map(|y| (0..film.width).map(move |x| (x, y)));
    pixels.map(|(x, y)| estimate(film.bin(x, y, 0))).collect()
}

/// The mean of independent estimates.
pub fn mean(estimates: &[Estimate]) -> Estimate {
    let count = estimates.len() as f64;
    Estimate {
        mean: estimates.iter().map(|estimate| estimate.mean).sum::<f64>() / count,
        variance: estimates.iter().map(|estimate| estimate.variance).sum::<f64>() / (count * count),
        degrees: estimates.iter().map(|estimate| estimate.degrees).sum(),
    }
}
