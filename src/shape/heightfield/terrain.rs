//! Fractal terrain by spectral synthesis.
//!
//! White noise whose Fourier transform is multiplied by f^−(H+1), f being the distance from frequency 0: a
//! surface whose power spectrum falls as f^−(2H+2), and whose height differs over a distance d by about d^H
//! (Saupe, "Algorithms for random fractals", in Peitgen and Saupe (eds.), *The Science of Fractal Images*,
//! 1988, 2.5). H is Hurst's exponent: 0.8 is what mountains look like, near 0 is rough and near 1 smooth.
//! Unlike displaced midpoints (Fournier, Fussell and Carpenter 1982; Glassner, ch. 3, 3.3) it has no creases
//! along the axes, and it can be laid side by side.

use super::HeightData;
use crate::shape::ShapeError;
use crate::stats::fourier;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rustfft::FftDirection;
use rustfft::num_complex::Complex;
use std::f64::consts::TAU;

/// What a terrain follows from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Terrain {
    /// There are 2 to this power, and one more, points along both axes: 1 to [`Terrain::MOST_LEVELS`].
    pub levels: u32,
    /// Above 0 and below 1.
    pub hurst: f64,
    /// Seed of the noise.
    pub seed: u64,
}

impl Terrain {
    /// Most levels of detail: 2^levels cells a side.
    pub const MOST_LEVELS: u32 = 11;

    /// Heights from 0 to 1.
    pub fn heights(&self) -> Result<HeightData, ShapeError> {
        let side = 1usize << self.levels.min(Self::MOST_LEVELS);
        let mut field = self.spectrum(side);
        transform(&mut field, side, FftDirection::Inverse);
        let heights: Vec<f64> = field.iter().map(|height| height.re).collect();
        let low = heights.iter().copied().fold(f64::INFINITY, f64::min);
        let high = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let points = side + 1;
        let value = |i: usize| {
            let (x, y) = (i % points % side, i / points % side);
            ((heights[y * side + x] - low) / (high - low)) as f32
        };
        HeightData::new([points; 2], (0..points * points).map(value).collect())
    }

    /// Row by row, frequencies in the order of the transform.
    fn spectrum(&self, side: usize) -> Vec<Complex<f64>> {
        let mut random = Pcg64Mcg::seed_from_u64(self.seed);
        let mut normal = || {
            let (u, v): (f64, f64) = (random.random(), random.random());
            // Box and Muller; 1 − u is never 0.
            (-2.0 * (1.0 - u).ln()).sqrt() * (TAU * v).cos()
        };
        let mut field: Vec<_> = (0..side * side).map(|_| Complex::new(normal(), 0.0)).collect();
        transform(&mut field, side, FftDirection::Forward);
        for (i, value) in field.iter_mut().enumerate() {
            let frequency = |k: usize| k.min(side - k) as f64;
            let squared = frequency(i % side).powi(2) + frequency(i / side).powi(2);
            *value *= if squared == 0.0 { 0.0 } else { squared.powf(-0.5 * (self.hurst + 1.0)) };
        }
        field
    }
}

/// Fourier's in two dimensions, without a factor.
fn transform(field: &mut [Complex<f64>], side: usize, direction: FftDirection) {
    let along = fourier(side, direction);
    for _ in 0..2 {
        along.process(field);
        for row in 0..side {
            for column in 0..row {
                field.swap(row * side + column, column * side + row);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::distribution::{ChiSquared, ContinuousCDF};
    use std::f64::consts::PI;

    /// The logarithm of a power that is exponentially distributed has the variance π²/6: the slope against
    /// log f, over the half plane of independent frequencies, is −(2H + 2) within its standard error.
    #[test]
    fn the_power_falls_as_it_should() {
        const TERRAINS: u64 = 24;
        let mut statistic = 0.0;
        for seed in 0..TERRAINS {
            let hurst = [0.2, 0.5, 0.8][seed as usize % 3];
            let terrain = Terrain { levels: 7, hurst, seed };
            let data = terrain.heights().unwrap();
            let ([points, _], values) = data.grid();
            let side = points - 1;
            let at = |x: usize, y: usize| f64::from(values[y * points + x]);
            let mut field: Vec<_> =
                (0..side * side).map(|i| Complex::new(at(i % side, i / side), 0.0)).collect();
            transform(&mut field, side, FftDirection::Forward);
            let mut known = Vec::new();
            // Beyond half of the frequencies the rounding of heights begins to show where H is large.
            for y in 0..side {
                for x in 1..side / 4 {
                    let v = y.min(side - y);
                    let frequency = ((x * x + v * v) as f64).sqrt();
                    if v < side / 4 {
                        known.push((frequency.ln(), field[y * side + x].norm_sqr().ln()));
                    }
                }
            }
            let count = known.len() as f64;
            let mean = |f: &dyn Fn(&(f64, f64)) -> f64| known.iter().map(f).sum::<f64>() / count;
            let (x, y) = (mean(&|k| k.0), mean(&|k| k.1));
            let spread = mean(&|k| (k.0 - x).powi(2));
            let slope = mean(&|k| (k.0 - x) * (k.1 - y)) / spread;
            let error = PI / (6.0 * count * spread).sqrt();
            statistic += ((slope + 2.0 * hurst + 2.0) / error).powi(2);
            assert!(error < 0.1);
            // It goes on on the other side.
            for i in 0..points {
                assert!(at(i, 0) == at(i, side) && at(0, i) == at(side, i));
            }
            assert_eq!(data.range(), [0.0, 1.0]);
            assert_eq!(terrain.heights().unwrap().grid().1, values);
        }
        let p = ChiSquared::new(TERRAINS as f64).unwrap().sf(statistic);
        assert!(p > 1e-3, "{statistic}");
    }
}
