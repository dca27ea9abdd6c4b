//! Phase functions: in what directions a medium scatters.
//!
//! Each is a density over directions, per steradian, of the way that light goes on, given the way that it
//! comes. Most depend on the angle θ between the two alone: cos θ = 1 straight ahead. Each is sampled as it
//! is, so value and density are one. Some differ from wavelength to wavelength: the hero samples, and the
//! companions say with what density they would have gone the same way.

pub mod air;
pub mod mie;
mod mixture;
mod sggx;
mod spectral_table;
mod table;
#[cfg(test)]
mod tests;

pub use mixture::Mixture;
pub use sggx::Sggx;
pub use spectral_table::SpectralTable;
pub use table::PhaseTable;

use crate::geometry::{Frame, Vec3};
use crate::sampling::{decide, warp};
use crate::spectrum::Sampled;
use crate::texture::{Texture, TexturePoint};
use std::f64::consts::{FRAC_1_PI, TAU};

/// How a medium's particles scatter.
#[derive(Clone, Debug)]
pub enum Phase {
    /// The same in all directions.
    Isotropic,
    /// With the mean cosine, between −1 and 1 (Henyey and Greenstein, "Diffuse radiation in the galaxy",
    /// Astrophysical Journal 93, 1941).
    HenyeyGreenstein(f64),
    /// Spheres much smaller than the wavelength.
    Rayleigh,
    /// Values by angle.
    Table(Box<PhaseTable>),
    /// By wavelength, such as that of spheres ([`mie`]).
    Spectral(Box<SpectralTable>),
    /// Small flakes.
    Sggx(Box<Sggx>),
    /// The first, and the second by its weight.
    Blend {
        /// Weight of the second, from 0 to 1.
        weight: Texture,
        /// The two phase functions.
        nested: Box<[Phase; 2]>,
    },
    /// Several by what each scatters of a wavelength.
    Mixture(Mixture),
}

/// A direction that was sampled.
#[derive(Clone, Copy, Debug)]
pub struct PhaseSample<const C: usize> {
    /// Unit vector along which light arrives.
    pub direction: Vec3,
    /// Value and density for each wavelength, sr⁻¹.
    pub value: Sampled<C>,
}

/// What the value of a phase function may depend on.
#[derive(Clone, Copy)]
struct Arguments<'a, const C: usize> {
    cos: f64,
    comes: Vec3,
    goes: Vec3,
    position: Vec3,
    nm: &'a [f64; C],
}

/// What a phase function samples.
enum Sampling {
    Cosine(f64),
    Direction(Vec3),
}

impl Phase {
    /// The values for light that goes on one way after it has come another, both of unit length, sr⁻¹.
    pub fn evaluate<const C: usize>(
        &self,
        comes: Vec3,
        goes: Vec3,
        position: Vec3,
        nm: &[f64; C],
    ) -> Sampled<C> {
        self.value(&Arguments { cos: comes.dot(goes), comes, goes, position, nm })
    }

    fn value<const C: usize>(&self, arguments: &Arguments<C>) -> Sampled<C> {
        let cos = arguments.cos;
        match self {
            Self::Isotropic => Sampled::splat(0.25 * FRAC_1_PI),
            Self::HenyeyGreenstein(g) => Sampled::splat(henyey_greenstein(*g, cos)),
            Self::Rayleigh => Sampled::splat(3.0 / 16.0 * FRAC_1_PI * (1.0 + cos * cos)),
            Self::Table(table) => Sampled::splat(table.density(cos) / TAU),
            Self::Spectral(table) => Sampled(table.density(cos, arguments.nm)) * (1.0 / TAU),
            Self::Sggx(flakes) => Sampled::splat(flakes.evaluate(arguments.comes, arguments.goes)),
            Self::Blend { weight, nested } => {
                let [first, second] = &**nested;
                let fraction = fraction(weight, arguments.position);
                first.value(arguments) * (1.0 - fraction) + second.value(arguments) * fraction
            }
            Self::Mixture(mixture) => mixture
                .fractions(arguments.nm)
                .fold(Sampled::ZERO, |sum, (fraction, phase)| sum + fraction * phase.value(arguments)),
        }
    }

    /// A direction for a ray that comes in another, by three uniform numbers, as the first wavelength says.
    pub fn sample<const C: usize>(
        &self,
        comes: Vec3,
        position: Vec3,
        nm: &[f64; C],
        [u, v, choice]: [f64; 3],
    ) -> PhaseSample<C> {
        let (cos, goes) = match self.choose(comes, position, nm[0], [u, v], choice) {
            Sampling::Cosine(cos) => {
                let cos = cos.clamp(-1.0, 1.0);
                (cos, Frame::around(comes).to_world(warp::around_z(cos, v)))
            }
            Sampling::Direction(goes) => (comes.dot(goes), goes),
        };
        PhaseSample { direction: goes, value: self.value(&Arguments { cos, comes, goes, position, nm }) }
    }

    fn choose(&self, comes: Vec3, position: Vec3, nm: f64, [u, v]: [f64; 2], mut choice: f64) -> Sampling {
        Sampling::Cosine(match self {
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
            Self::Spectral(table) => table.sample(nm, u, choice),
            Self::Sggx(flakes) => return Sampling::Direction(flakes.sample(comes, [u, v])),
            Self::Blend { weight, nested } => {
                let [first, second] = &**nested;
                let chosen = if decide(&mut choice, fraction(weight, position)) { second } else { first };
                return chosen.choose(comes, position, nm, [u, v], choice);
            }
            Self::Mixture(mixture) => {
                let mut left = 1.0;
                let wavelength = [nm];
                let mut chosen = None;
                for (fraction, phase) in mixture.fractions(&wavelength) {
                    chosen = Some(phase);
                    let fraction = fraction.hero();
                    if decide(&mut choice, (fraction / left).min(1.0)) {
                        break;
                    }
                    left -= fraction;
                }
                return match chosen {
                    Some(phase) => phase.choose(comes, position, nm, [u, v], choice),
                    None => Sampling::Cosine(2.0 * u - 1.0),
                };
            }
        })
    }

    /// What the extinction along a direction is multiplied by: the projected area of flakes.
    pub fn projected_area(&self, direction: Vec3) -> f64 {
        match self {
            Self::Sggx(flakes) => flakes.projected_area(direction),
            _ => 1.0,
        }
    }

    /// [`Self::projected_area`] is at most this.
    pub fn max_projected_area(&self) -> f64 {
        match self {
            Self::Sggx(flakes) => flakes.max_projected_area(),
            _ => 1.0,
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
