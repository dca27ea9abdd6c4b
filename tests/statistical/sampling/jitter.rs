//! What jitter does to aliases (Cook, "Stochastic sampling in computer graphics", ACM TOG 5(1), 1986, section
//! 4), and to edges.

use super::{band, points, spectrum};
use abbe::sampling::{Dimensions, Sampler, SamplerKind};
use abbe::stats::Moments;
use statrs::distribution::{ContinuousCDF, Normal};
use std::f64::consts::TAU;

/// Samples of one stretch of the signal, a unit apart but for their jitter.
const STRETCH: u32 = 1 << 14;

/// What sines of frequency ν and random phases leave in their samples at n + ζₙ.
struct Sampled {
    /// Power at the frequency itself, and all other power, as shares of the signal's.
    coherent: f64,
    noise: f64,
    /// Correlation of neighbouring residuals over its standard error: the noise is white where it is nothing.
    z: f64,
    /// Mean of the samples over its standard error.
    level: f64,
}

/// Samples sines of frequency `nu` in `stretches` of random phase; `jitter` makes the displacement of a
/// uniform number.
fn sampled(nu: f64, stretches: u32, jitter: impl Fn(f64) -> f64) -> Sampled {
    let sampler = Sampler::new(SamplerKind::Jittered, 1, 1);
    let n = f64::from(STRETCH);
    let (mut power, mut projected, mut lagged, mut squared) = (0.0, 0.0, 0.0, 0.0);
    let mut level = Moments::default();
    let (step_sin, step_cos) = (TAU * nu).sin_cos();
    for stretch in 0..stretches {
        let [phase, ..] = sampler.stream([stretch, 0], 1, 0).draw(Dimensions::Lens);
        let (mut sin_sum, mut cos_sum, mut sum) = (0.0, 0.0, 0.0);
        let mut signal = Vec::with_capacity(STRETCH as usize);
        for i in 0..STRETCH {
            let [u, ..] = sampler.stream([i, stretch], 0, 0).draw(Dimensions::Camera);
            signal.push((TAU * (nu * (f64::from(i) + jitter(u)) + phase)).sin());
        }
        let (mut sin, mut cos) = (0.0, 1.0);
        for &value in &signal {
            (sin_sum, cos_sum, sum) = (sin_sum + value * sin, cos_sum + value * cos, sum + value);
            power += value * value;
            (sin, cos) = (sin * step_cos + cos * step_sin, cos * step_cos - sin * step_sin);
        }
        projected += 2.0 * (sin_sum * sin_sum + cos_sum * cos_sum) / (n * n);
        level.push(sum / n);
        let (mut sin, mut cos, mut before) = (0.0, 1.0, 0.0);
        for &value in &signal {
            let residual = value - 2.0 * (sin_sum * sin + cos_sum * cos) / n;
            lagged += residual * before;
            squared += (residual * before).powi(2);
            before = residual;
            (sin, cos) = (sin * step_cos + cos * step_sin, cos * step_cos - sin * step_sin);
        }
    }
    let (power, projected) = (power / (n * f64::from(stretches)), projected / f64::from(stretches));
    // White noise of power W has W/n at any frequency, which the projection counts twice.
    let coherent = (projected - 2.0 * power / n) / (1.0 - 2.0 / n);
    Sampled {
        coherent: coherent / 0.5,
        noise: (power - coherent) / 0.5,
        z: lagged / squared.sqrt(),
        level: level.mean() / level.estimate().error(),
    }
}

/// Cook's equations (2) and (3), at frequencies that are not their own aliases.
#[test]
fn a_jittered_sine_keeps_cooks_gain_and_the_rest_is_white_noise() {
    let sinc = |x: f64| (std::f64::consts::PI * x).sin() / (std::f64::consts::PI * x);
    let normal = Normal::new(0.0, 1.0).unwrap();
    let sigma = 0.2;
    for nu in [0.25, 0.4, 0.73, 0.9, 1.25, 2.3] {
        for (name, gain) in [("white", sinc(nu).powi(2)), ("Gaussian", (-(TAU * nu * sigma).powi(2)).exp())] {
            // The smaller the gain, the more the noise hides it; what is below 1 % is not looked for.
            if gain < 0.01 {
                continue;
            }
            let stretches = (6.0 / gain).ceil() as u32;
            let seen = match name {
                "white" => sampled(nu, stretches, |u| u - 0.5),
                _ => sampled(nu, stretches, |u| sigma * normal.inverse_cdf(u)),
            };
            let told = format!(
                "{name}, νT = {nu}: gain {:.5} for {gain:.5}, noise {:.5}",
                seen.coherent, seen.noise
            );
            println!("{told}");
            assert!((seen.coherent / gain - 1.0).abs() < 0.02, "{told}");
            assert!((seen.noise / (1.0 - gain) - 1.0).abs() < 0.02, "{told}");
            assert!(seen.z.abs() < 4.0, "{told}: not white, z = {}", seen.z);
            assert!(seen.level.abs() < 4.0, "{told}: the grey level is off, z = {}", seen.level);
        }
    }
}

/// The trade-off of section 4.1: white jitter over the whole cell removes the alias of νT = 1; over half a
/// cell it leaves 40 % of it.
#[test]
fn the_alias_of_the_sampling_frequency_vanishes_with_full_jitter() {
    // At νT = 1 the alias is the grey level: the power of the mean.
    let alias = |gamma: f64| {
        let sampler = Sampler::new(SamplerKind::Jittered, 3, 1);
        let n = 400_000;
        let [re, im] = (0..n).fold([0.0; 2], |[re, im], i| {
            let [u, ..] = sampler.stream([i, 0], 0, 0).draw(Dimensions::Camera);
            let (sin, cos) = (TAU * 2.0 * gamma * (u - 0.5)).sin_cos();
            [re + cos, im + sin]
        });
        (re * re + im * im) / f64::from(n).powi(2)
    };
    assert!(alias(0.5) < 1e-3, "{}", alias(0.5));
    assert!((alias(0.25) / 0.4053 - 1.0).abs() < 0.02, "{}", alias(0.25));
}

/// Root of the mean squared error of a pixel's coverage by an edge.
fn edge_noise(kind: SamplerKind, samples: u32, turned: bool) -> f64 {
    let (sampler, edges) = (Sampler::new(kind, 7, samples), Sampler::new(SamplerKind::Independent, 8, 1));
    let pixels = 20_000;
    let mut sum = 0.0;
    for pixel in 0..pixels {
        let [offset, angle, ..] = edges.stream([pixel, 0], 0, 0).draw(Dimensions::Lens);
        let (sin, cos) = if turned { (TAU / 4.0 * angle).sin_cos() } else { (0.0, 1.0) };
        // The edge x cos θ + y sin θ = d crosses the pixel anywhere.
        let d = offset * (sin + cos);
        let inside = points(&sampler, [pixel, 0], Dimensions::Camera, samples)
            .into_iter()
            .filter(|[x, y]| x * cos + y * sin < d)
            .count();
        // The covered part: the integral of the width of the pixel below the edge.
        let covered = if sin < 1e-9 {
            d
        } else {
            let triangle = |d: f64| if d > 0.0 { d * d / (2.0 * sin * cos) } else { 0.0 };
            triangle(d) - triangle(d - sin) - triangle(d - cos)
        };
        sum += (inside as f64 / f64::from(samples) - covered).powi(2);
    }
    (sum / f64::from(pixels)).sqrt()
}

/// N^(−1/2) for random and N^(−3/4) for jittered samples, with their factors: 1/√6 for edges along an axis.
#[test]
fn edges_are_as_noisy_as_theory_says() {
    for n in [1, 4, 9, 16, 25] {
        let count = f64::from(n);
        for (kind, power) in [(SamplerKind::Independent, -0.5), (SamplerKind::Jittered, -0.75)] {
            let straight = edge_noise(kind, n, false) / (count.powf(power) / 6f64.sqrt());
            assert!((straight - 1.0).abs() < 0.03, "{kind:?}, {n}: {straight}");
        }
        // Mean of p(1 − p) over edges of any direction, and the same for each of the cells that jitter makes.
        let random = edge_noise(SamplerKind::Independent, n, true) / (0.3608 * count.powf(-0.5));
        assert!((random - 1.0).abs() < 0.03, "{n}: {random}");
    }
    for (n, noise) in [(1, 0.3607), (4, 0.1271), (9, 0.0693), (16, 0.0451), (25, 0.0322)] {
        let jittered = edge_noise(SamplerKind::Jittered, n, true);
        assert!((jittered / noise - 1.0).abs() < 0.03, "{n}: {jittered}");
    }
}

/// Power 1 − sinc²(ν_x) sinc²(ν_y) of the random level, ν in cycles per cell.
#[test]
fn the_spectrum_of_a_jittered_pattern_lacks_low_frequencies() {
    let cells = 64.0;
    for (kind, expected) in
        [(SamplerKind::Jittered, [0.017, 0.110, 0.40, 0.76]), (SamplerKind::Independent, [1.0; 4])]
    {
        let sampler = Sampler::new(kind, 11, 4096);
        let mut power = Vec::new();
        for pixel in 0..3 {
            power.extend(spectrum(&points(&sampler, [pixel, 0], Dimensions::Camera, 4096), 48));
        }
        let edges = [0.02, 0.1, 0.25, 0.5, 0.75];
        for (edges, expected) in edges.windows(2).zip(expected) {
            let seen = band(&power, edges[0] * cells, edges[1] * cells);
            // The figures were rounded to two digits.
            let off = (seen.mean - expected).abs();
            assert!(off < 4.0 * seen.error() + 0.01 * expected.max(0.1), "{kind:?} {edges:?}: {seen:?}");
        }
    }
}
