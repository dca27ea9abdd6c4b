//! How many spheres have what radius.

use statrs::function::gamma::ln_gamma;
use std::f64::consts::{PI, TAU};

/// A distribution of radii, µm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sizes {
    /// All have this radius.
    One(f64),
    /// The logarithm is normally distributed: about the median with the logarithm of the geometric standard
    /// deviation, which is above 1.
    LogNormal {
        /// Median radius.
        median: f64,
        /// Geometric standard deviation, above 1.
        spread: f64,
    },
    /// Hansen's gamma distribution, n(r) ∝ r^((1−3b)/b) e^(−r/(ab)), of effective radius a and effective
    /// variance b below 1/2 (Hansen, "Multiple scattering of polarized light in planetary atmospheres. Part
    /// II", Journal of the Atmospheric Sciences 28, 1971).
    Gamma {
        /// Effective radius: the third moment over the second.
        effective: f64,
        /// Effective variance, above 0 and below ½.
        variance: f64,
    },
}

/// A radius, µm, that stands for a fraction of all spheres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    pub radius: f64,
    pub number: f64,
}

impl Sizes {
    /// µm³.
    pub fn mean_volume(&self) -> f64 {
        let cube = match *self {
            Self::One(radius) => radius.powi(3),
            Self::LogNormal { median, spread } => median.powi(3) * (4.5 * spread.ln().powi(2)).exp(),
            Self::Gamma { effective: a, variance: b } => a.powi(3) * (1.0 - b) * (1.0 - 2.0 * b),
        };
        4.0 / 3.0 * PI * cube
    }

    /// Numbers per unit of ln r, of integral 1.
    fn density(&self, radius: f64) -> f64 {
        match *self {
            Self::One(_) => 1.0,
            Self::LogNormal { median, spread } => {
                let deviation = spread.ln();
                let z = (radius / median).ln() / deviation;
                (-0.5 * z * z).exp() / (deviation * TAU.sqrt())
            }
            Self::Gamma { effective, variance } => {
                let (k, scaled) = (1.0 / variance - 2.0, radius / (effective * variance));
                (k * scaled.ln() - scaled - ln_gamma(k)).exp()
            }
        }
    }

    /// The radii that matter, by equal steps of ln r: the rule of trapezes converges fast for what falls off
    /// at both ends. `per_radius`: the size parameter of a radius of 1 µm.
    pub fn nodes(&self, per_radius: f64) -> Vec<Node> {
        /// What all left out on either side scatter is about this fraction of the rest.
        const NEGLIGIBLE: f64 = 1e-6;
        const SCAN: u32 = 4000;
        let (low, high) = match *self {
            Self::One(radius) => return vec![Node { radius, number: 1.0 }],
            Self::LogNormal { median, spread } => {
                let deviation = spread.ln();
                let reach = 7.0 * deviation + 6.0 * deviation * deviation;
                (median.ln() - reach, median.ln() + reach)
            }
            Self::Gamma { effective, variance } => {
                let deviation = variance.sqrt();
                let reach = (1.0 + 20.0 * deviation).ln() + 20.0 * variance;
                (effective.ln() - 30.0 * deviation, effective.ln() + reach)
            }
        };
        // About what spheres of a radius scatter.
        let weight = |ln: f64| {
            let radius = ln.exp();
            let size = radius * per_radius;
            self.density(radius) * radius * radius * size.powi(4).min(1.0)
        };
        let step = (high - low) / f64::from(SCAN);
        let weights: Vec<f64> = (0..=SCAN).map(|i| weight(low + step * f64::from(i))).collect();
        let greatest = weights.iter().copied().fold(0.0, f64::max);
        let counts = |&weight: &f64| weight > NEGLIGIBLE * greatest;
        let first = weights.iter().position(counts).unwrap_or(0);
        let last = weights.iter().rposition(counts).unwrap_or(SCAN as usize);
        let [low, high] = [first, last].map(|i| low + step * i as f64);
        // Neighbours differ by about this much in their size parameter, so that what each scatters by
        // interference is smoothed out.
        const STEP: f64 = 1.0;
        let largest = high.exp() * per_radius;
        let count = (largest * (high - low) / STEP / 2.0).clamp(48.0, 320.0).ceil() as u32;
        let step = (high - low) / f64::from(count);
        (0..=count)
            .map(|i| {
                let radius = (low + step * f64::from(i)).exp();
                Node { radius, number: self.density(radius) * step }
            })
            .collect()
    }
}
