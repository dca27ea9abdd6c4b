//! Power spectra: of the points that a sampler makes in a pixel, and of the error of an image.

use super::{Purpose, derived_seed};
use crate::sampling::{Dimensions, Sampler, SamplerKind};
use crate::stats::fourier;
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftDirection};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Power by distance from frequency 0, relative to white noise.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Radial {
    /// Middle of each ring: cycles per pixel for images; cycles per mean distance of the points, 1/√N, for
    /// patterns.
    pub frequency: Vec<f64>,
    /// Mean over the ring; 1 for white noise.
    pub power: Vec<f64>,
}

/// Radial power and, for those that are shown, the power in the plane.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spectrum {
    /// Mean power over rings of equal frequency.
    pub radial: Radial,
    /// Width of the picture; 0 where there is none.
    pub width: usize,
    /// Row by row, frequency 0 in the middle; relative to white noise. The power of frequency 0 itself is
    /// left out (−1).
    pub power: Vec<f64>,
}

/// The mark of a place that has no power.
const NONE: f64 = -1.0;

/// Means over rings, for frequencies from 0 to `to`.
struct Rings {
    to: f64,
    sums: Vec<(f64, u32)>,
}

impl Rings {
    fn new(count: usize, to: f64) -> Self {
        Self { to, sums: vec![(0.0, 0); count.max(1)] }
    }

    fn add(&mut self, frequency: f64, power: f64) {
        let ring = (frequency / self.to * self.sums.len() as f64).floor();
        if let Some((sum, count)) = self.sums.get_mut(ring as usize) {
            *sum += power;
            *count += 1;
        }
    }

    fn finish(self) -> Radial {
        let width = self.to / self.sums.len() as f64;
        let filled = self.sums.iter().enumerate().filter(|(_, (_, count))| *count > 0);
        let (frequency, power) =
            filled.map(|(i, (sum, count))| ((i as f64 + 0.5) * width, sum / f64::from(*count))).unzip();
        Radial { frequency, power }
    }
}

/// Mean power spectrum of several images of errors.
pub(super) struct ImageSpectrum {
    width: usize,
    height: usize,
    power: Vec<f64>,
    rows: Arc<dyn Fft<f64>>,
    columns: Arc<dyn Fft<f64>>,
}

/// Largest edge of the picture of a spectrum.
const LARGEST_PICTURE: usize = 128;

impl ImageSpectrum {
    pub fn new(width: usize, height: usize) -> Self {
        let [rows, columns] = [width, height].map(|length| fourier(length, FftDirection::Forward));
        Self { width, height, power: vec![0.0; width * height], rows, columns }
    }

    pub fn add(&mut self, errors: &[f64]) {
        let (width, height) = (self.width, self.height);
        let mut rows: Vec<Complex<f64>> = errors.iter().map(|&e| Complex::new(e, 0.0)).collect();
        self.rows.process(&mut rows);
        let mut columns: Vec<Complex<f64>> = (0..width)
            .flat_map(|x| (0..height).map(move |y| (x, y)))
            .map(|(x, y)| rows[y * width + x])
            .collect();
        self.columns.process(&mut columns);
        for (i, value) in columns.into_iter().enumerate() {
            let (x, y) = (i / height, i % height);
            self.power[y * width + x] += value.norm_sqr();
        }
    }

    pub fn finish(self, with_picture: bool) -> Spectrum {
        // From −½ to ½ cycles per pixel.
        let signed = |i: usize, n: usize| {
            let f = i as f64 / n as f64;
            if f >= 0.5 { f - 1.0 } else { f }
        };
        let all: f64 = self.power[1..].iter().sum();
        let mean = all / (self.power.len() - 1).max(1) as f64;
        let scale = if mean > 0.0 { 1.0 / mean } else { 0.0 };
        let shorter = self.width.min(self.height);
        let mut rings = Rings::new((shorter / 2).clamp(1, 48), 0.5);
        let edge = shorter.min(LARGEST_PICTURE);
        let mut picture = vec![(0.0, 0u32); edge * edge];
        for (i, &power) in self.power.iter().enumerate().skip(1) {
            let [x, y] = [signed(i % self.width, self.width), signed(i / self.width, self.height)];
            rings.add(x.hypot(y), power * scale);
            let cell = |f: f64| ((f + 0.5) * edge as f64 + 1e-9).floor().min(edge as f64 - 1.0) as usize;
            let (sum, count) = &mut picture[cell(y) * edge + cell(x)];
            *sum += power * scale;
            *count += 1;
        }
        let mean = |(sum, count): (f64, u32)| if count > 0 { sum / f64::from(count) } else { NONE };
        let (width, power) =
            if with_picture { (edge, picture.into_iter().map(mean).collect()) } else { (0, Vec::new()) };
        Spectrum { radial: rings.finish(), width, power }
    }
}

/// Frequencies of a pattern go this far, in cycles per mean distance of the points.
const FARTHEST: f64 = 2.0;

/// Mean power spectrum of the film positions that a sampler makes in a pixel, over many pixels.
///
/// Power |Σ exp(−2πi f·x)|²/N at whole cycles per pixel f ≠ 0: 1 for independent points.
pub(super) fn pattern(kind: SamplerKind, seed: u64, samples: u32) -> Spectrum {
    let n = f64::from(samples);
    let farthest = ((FARTHEST * n.sqrt()).ceil() as i32).max(2);
    let edge = (2 * farthest + 1) as usize;
    // Half of the plane tells the other.
    let half = (farthest + 1) as usize;
    let pixels = (4e7 / (n * (edge * half) as f64)).clamp(4.0, 256.0) as u32;
    let seed = derived_seed(seed, Purpose::Pattern, [u64::from(samples)]);
    let sampler = Sampler::new(kind, seed, samples);
    let mut sums = vec![0.0; edge * half];
    let mut wave = vec![Complex::new(0.0, 0.0); edge * half];
    for pixel in 0..pixels {
        // Each with a sequence of its own: neighbours may share one, and would show its peculiarities.
        wave.fill(Complex::new(0.0, 0.0));
        for index in 0..samples {
            let [x, y, ..] = sampler.stream([pixel % 16, pixel / 16], pixel, index).draw(Dimensions::Camera);
            let turn = |u: f64| Complex::from_polar(1.0, -TAU * u);
            let mut row = Complex::new(1.0, 0.0);
            for waves in wave.chunks_exact_mut(edge) {
                let mut value = row * Complex::from_polar(1.0, TAU * x * f64::from(farthest));
                for wave in waves {
                    *wave += value;
                    value *= turn(x);
                }
                row *= turn(y);
            }
        }
        for (sum, wave) in sums.iter_mut().zip(&wave) {
            *sum += wave.norm_sqr();
        }
    }
    let scale = 1.0 / (n * f64::from(pixels));
    let mut rings = Rings::new(((farthest as usize) * 2).min(64), FARTHEST);
    let mut power = vec![NONE; edge * edge];
    for (i, sum) in sums.into_iter().enumerate() {
        let (x, y) = ((i % edge) as i32 - farthest, (i / edge) as i32);
        if (x, y) == (0, 0) {
            continue;
        }
        let frequency = f64::from(x).hypot(f64::from(y)) / n.sqrt();
        rings.add(frequency, sum * scale);
        for (x, y) in [(x, y), (-x, -y)] {
            power[(y + farthest) as usize * edge + (x + farthest) as usize] = sum * scale;
        }
    }
    Spectrum { radial: rings.finish(), width: edge, power }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::mix;

    fn band(radial: &Radial, from: f64, to: f64) -> f64 {
        let inside: Vec<f64> = radial
            .frequency
            .iter()
            .zip(&radial.power)
            .filter(|(f, _)| (from..to).contains(*f))
            .map(|(_, power)| *power)
            .collect();
        inside.iter().sum::<f64>() / inside.len() as f64
    }

    /// Independent points have the power 1 at every frequency: the mean of 256 exponential values a
    /// frequency, two of which (f and −f) are one.
    #[test]
    fn independent_points_are_white() {
        let spectrum = pattern(SamplerKind::Independent, 1, 64);
        for (from, to) in [(0.0, 0.5), (0.5, 1.0), (1.0, 2.0)] {
            let power = band(&spectrum.radial, from, to);
            assert!((power - 1.0).abs() < 0.06, "{from} to {to}: {power}");
        }
    }

    /// 1 − sinc²(νx)·sinc²(νy) (Cook 1986, equation 3, in two dimensions).
    #[test]
    fn jittered_points_have_the_spectrum_of_cooks_equation() {
        let spectrum = pattern(SamplerKind::Jittered, 1, 64);
        let sinc = |f: f64| if f == 0.0 { 1.0 } else { (TAU / 2.0 * f).sin() / (TAU / 2.0 * f) };
        let middle = spectrum.width / 2;
        let (mut chi_square, mut count) = (0.0, 0.0);
        for (i, &power) in spectrum.power.iter().enumerate().filter(|(_, power)| **power != NONE) {
            let cycles = |i: usize| (i as f64 - middle as f64) / 8.0;
            let (x, y) = (cycles(i % spectrum.width), cycles(i / spectrum.width));
            let expected = 1.0 - (sinc(x) * sinc(y)).powi(2);
            // The mean of 256 values, each about exponential.
            chi_square += ((power - expected) / (expected / 16.0)).powi(2);
            count += 1.0;
        }
        let reduced = chi_square / count;
        assert!((0.7..1.3).contains(&reduced), "χ² over its degrees of freedom is {reduced}");
    }

    /// White noise is flat; noise whose neighbours cancel has nothing at low frequencies.
    #[test]
    fn an_images_errors_show_their_colour() {
        let (width, height) = (48, 40);
        let noise = |seed: u64| -> Vec<f64> {
            (0..(width * height) as u64).map(|i| mix(i ^ seed << 32) as f64 / u64::MAX as f64 - 0.5).collect()
        };
        let (mut white, mut blue) = (ImageSpectrum::new(width, height), ImageSpectrum::new(width, height));
        for seed in 1..=16 {
            let errors = noise(seed);
            white.add(&errors);
            let at = |x: usize, y: usize| errors[(y % height) * width + x % width];
            blue.add(
                &(0..width * height)
                    .map(|i| {
                        let (x, y) = (i % width, i / width);
                        4.0 * at(x, y)
                            - at(x + 1, y)
                            - at(x + width - 1, y)
                            - at(x, y + 1)
                            - at(x, y + height - 1)
                    })
                    .collect::<Vec<_>>(),
            );
        }
        let (white, blue) = (white.finish(true), blue.finish(false));
        assert!((band(&white.radial, 0.0, 0.25) - 1.0).abs() < 0.1, "{white:?}");
        assert!(band(&blue.radial, 0.0, 0.1) < 0.02 && band(&blue.radial, 0.4, 0.5) > 1.0, "{blue:?}");
        assert!((white.width, white.power.len(), blue.width) == (40, 1600, 0));
    }
}
