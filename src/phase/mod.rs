//! Phase functions: in what directions a medium scatters.
//!
//! Each is a density over directions, per steradian, of the angle θ between the way that light comes and the
//! way that it goes on: cos θ = 1 straight ahead. It is the same at all wavelengths and in both directions of
//! the path, and each is sampled as it is, so value and density are one.

mod table;
#[cfg(test)]
mod tests;

pub use table::PhaseTable;

use crate::geometry::{Frame, Vec3};
use crate::sampling::{decide, warp};
use crate::texture::{Texture, TexturePoint};
use std::f64::consts::{FRAC_1_PI, TAU};

#[derive(Clone, Debug)]
pub enum Phase {
    Isotropic,
    /// With the mean cosine, between −1 and 1 (Henyey and Greenstein, "Diffuse radiation in the galaxy",
    /// Astrophysical Journal 93, 1941).
    HenyeyGreenstein(f64),
    /// Spheres much smaller than the wavelength.
    Rayleigh,
    Table(Box<PhaseTable>),
    /// The first, and the second by its weight.
    Blend {
        weight: Texture,
        nested: Box<[Phase; 2]>,
    },
}

/// A direction that was sampled.
#[derive(Clone, Copy, Debug)]
pub struct PhaseSample {
    pub direction: Vec3,
    /// Value and density, sr⁻¹.
    pub value: f64,
}

impl Phase {
    /// The value for a cosine of the angle at a place, sr⁻¹.
    pub fn evaluate(&self, cos: f64, position: Vec3) -> f64 {
        match self {
            Self::Isotropic => 0.25 * FRAC_1_PI,
            Self::HenyeyGreenstein(g) => henyey_greenstein(*g, cos),
            Self::Rayleigh => 3.0 / 16.0 * FRAC_1_PI * (1.0 + cos * cos),
            Self::Table(table) => table.density(cos) / TAU,
            Self::Blend { weight, nested } => {
                let [first, second] = &**nested;
                let fraction = fraction(weight, position);
                first.evaluate(cos, position) * (1.0 - fraction) + second.evaluate(cos, position) * fraction
            }
        }
    }

    /// A direction for a ray that comes in another, by three uniform numbers.
    pub fn sample(&self, comes: Vec3, position: Vec3, [u, v, choice]: [f64; 3]) -> PhaseSample {
        let cos = self.cosine(position, u, choice).clamp(-1.0, 1.0);
        let direction = Frame::around(comes).to_world(warp::around_z(cos, v));
        PhaseSample { direction, value: self.evaluate(cos, position) }
    }

    fn cosine(&self, position: Vec3, u: f64, mut choice: f64) -> f64 {
        match self {
            Self::Isotropic => 2.0 * u - 1.0,
            Self::HenyeyGreenstein(g) => {
                // The usual inverse, brought into a form without a division by g.
                let s = 2.0 * u - 1.0;
                let numerator = s + 0.5 * g * (3.0 + s * s) + g * g * s - 0.5 * g * g * g * (1.0 - s * s);
                numerator / ((1.0 + g * s) * (1.0 + g * s))
            }
            Self::Rayleigh => {
                let z = 4.0 * u - 2.0;
                let root = (z + (z * z + 1.0).sqrt()).cbrt();
                root - 1.0 / root
            }
            Self::Table(table) => table.sample(u),
            Self::Blend { weight, nested } => {
                let [first, second] = &**nested;
                let chosen = if decide(&mut choice, fraction(weight, position)) { second } else { first };
                chosen.cosine(position, u, choice)
            }
        }
    }
}

fn henyey_greenstein(g: f64, cos: f64) -> f64 {
    // (1 − g)² + 2 g (1 − cos θ), which loses no digits straight ahead.
    let squared = (1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - cos);
    0.25 * FRAC_1_PI * (1.0 - g * g) / (squared * squared.sqrt())
}

fn fraction(weight: &Texture, position: Vec3) -> f64 {
    weight.value(&TexturePoint::in_space(position)).clamp(0.0, 1.0)
}
