//! What distributed samples add up to: whole renders of lenses, shutters, lights with an extent and rough
//! surfaces against closed forms, or against renders in which the same is done without distributing.

mod lens;
mod motion;
mod penumbra;
mod roughness;
mod same_motion;
mod slopes;
mod time;

use abbe::film::{Film, Measured, SpectralBins};
use abbe::integrator::Estimator;
use abbe::render::{Schedule, Settings, WavelengthCount};
use abbe::sampling::SamplerKind;
use abbe::scene::{CompileOptions, Scene};
use abbe::stats::{Estimate, sidak, welch};
use abbe::units::WavelengthRange;

/// False alarms of one test in this file.
const LEVEL: f64 = 0.001;

fn compiled(content: &str) -> Scene {
    crate::common::made(content, &CompileOptions { spectral: true, ..CompileOptions::default() })
}

/// A film of this size that keeps alpha, and a box filter.
fn film(width: u32, height: u32) -> String {
    format!(
        r#"<film type="hdrfilm"><integer name="width" value="{width}"/><integer name="height" value="{height}"/>
           <string name="pixel_format" value="rgba"/><rfilter type="box"/></film>"#
    )
}

/// A camera that looks down -z, a unit being a pixel, the middle of the film at the origin. `more` goes into
/// the sensor.
fn flat_camera(width: u32, height: u32, more: &str) -> String {
    format!(
        r#"<sensor type="orthographic"><transform name="to_world"><scale x="{0}" y="{0}"/>
           <lookat origin="0, 0, 100" target="0, 0, 0" up="0, 1, 0"/></transform>{more}{1}</sensor>"#,
        f64::from(width) / 2.0,
        film(width, height)
    )
}

/// The whole spectrum in one bin, so that radiance is measured as such.
const ONE_BIN: SpectralBins = SpectralBins { range: WavelengthRange::VISIBLE, count: 1 };

fn settings(sampler: SamplerKind, replicates: u32, samples_per_replicate: u32, seed: u64) -> Settings {
    let schedule = Schedule::independent(replicates, samples_per_replicate);
    Settings {
        schedule,
        seed,
        sampler,
        wavelengths: Some(WavelengthCount::Four),
        estimator: Estimator::Plain,
        bins: Some(ONE_BIN),
    }
}

/// Films for judging pixel by pixel: means of many independent samples, which are nearly normal.
fn expose(scene: &Scene, replicates: u32, samples_per_replicate: u32, seed: u64) -> Film {
    crate::common::expose(scene, &settings(SamplerKind::Independent, replicates, samples_per_replicate, seed))
}

fn estimate(film: &Film, measured: Measured) -> Estimate {
    let degrees = f64::from(film.replicates) - 1.0;
    Estimate { mean: measured.mean, variance: measured.error * measured.error, degrees }
}

/// The share of samples that meet something.
fn coverage(film: &Film, x: u32, y: u32) -> Estimate {
    estimate(film, film.alpha(x, y))
}

/// Spectral radiance.
fn radiance(film: &Film, x: u32, y: u32) -> Estimate {
    estimate(film, film.bin(x, y, 0))
}

/// All pixels of a film, row by row.
fn pixels(film: &Film) -> impl Iterator<Item = (u32, u32)> + use<> {
    let (width, height) = (film.width, film.height);
    (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)))
}

/// The smallest of many p-values, corrected for how many there are. Pairs that are known exactly must be
/// equal to within rounding.
fn smallest_p(pairs: impl Iterator<Item = (Estimate, Estimate)>) -> f64 {
    let (mut smallest, mut count) = (1.0f64, 0);
    for (found, expected) in pairs {
        if found.variance + expected.variance == 0.0 {
            let apart = (found.mean - expected.mean).abs();
            assert!(apart <= 1e-9 * expected.mean.abs().max(1.0), "{found:?} {expected:?}");
            continue;
        }
        count += 1;
        smallest = smallest.min(welch(&found, &expected).p_value);
    }
    assert!(count > 0, "nothing was random");
    1.0 - (1.0 - smallest).powi(count)
}

/// Judges pixel by pixel, at [`LEVEL`] in all.
#[track_caller]
fn assert_agree(what: &str, pairs: impl Iterator<Item = (Estimate, Estimate)>) {
    let p = smallest_p(pairs);
    println!("{what}: smallest p {p:.4}");
    assert!(p > LEVEL, "{what}: p = {p:e}");
}

/// The mean of independent estimates.
fn mean(estimates: impl Iterator<Item = Estimate>) -> Estimate {
    let (mut sum, mut variance, mut degrees, mut count) = (0.0, 0.0, 0.0, 0.0);
    for estimate in estimates {
        sum += estimate.mean;
        variance += estimate.variance;
        degrees += estimate.degrees;
        count += 1.0;
    }
    Estimate { mean: sum / count, variance: variance / (count * count), degrees }
}

/// The test of the test: the smallest p-value finds a hundredth too much in one of many pixels.
#[test]
fn a_wrong_pixel_is_found() {
    let found = |mean: f64| Estimate { mean, variance: 1e-6, degrees: 15.0 };
    let pairs =
        |wrong: f64| (0..100).map(move |i| (found(if i == 7 { wrong } else { 1.0 }), Estimate::exact(1.0)));
    assert!(smallest_p(pairs(1.0)) > 0.5 && smallest_p(pairs(1.01)) < sidak(LEVEL, 1));
}
