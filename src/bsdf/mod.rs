//! How a surface scatters light at one point.
//!
//! A [`Bsdf`] holds only numbers: the material has looked up its spectra at the wavelengths of the
//! path already. Evaluation, sampling and density therefore agree by construction.
//!
//! Conventions, for every variant:
//! - Directions are in the local frame whose z axis is the shading normal, point away from the
//!   surface and have unit length. `toward_eye` is where the path came from.
//! - Everything is unpolarised and for radiance carried from light to eye: a refracted ray's weight
//!   includes the factor (η_eye/η_light)² by which radiance is compressed.
//! - A direction is sampled for the hero wavelength alone. Each companion reports with what density
//!   it would have gone the same way, so that the path can weigh all of them by the balance heuristic
//!   (Wilkie et al., "Hero Wavelength Spectral Sampling", EGSR 2014).

use crate::geometry::Vec3;
use crate::spectrum::Sampled;

/// A density always comes with its measure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Density {
    /// Per steradian.
    PerSolidAngle(f64),
    /// One of finitely many directions; no other technique can find it.
    Discrete,
}

/// The value of a BSDF for a pair of directions.
#[derive(Clone, Copy, Debug)]
pub struct Evaluation<const C: usize> {
    /// `f · |cos θ_light|`, sr⁻¹. Zero for a discrete lobe.
    pub f_cos: Sampled<C>,
    /// The density, per steradian, with which sampling would have chosen `toward_light` had that
    /// lane been the hero. Zero for a discrete lobe.
    pub density: Sampled<C>,
}

/// A sampled direction.
#[derive(Clone, Copy, Debug)]
pub struct Scatter<const C: usize> {
    pub toward_light: Vec3,
    /// `f · |cos θ_light| / density`, both the value's lane and the *hero's* density; for a discrete
    /// lobe the ratio of its coefficient to the hero's probability of choosing it.
    pub weight: Sampled<C>,
    /// The density of the hero.
    pub density: Density,
    /// Each lane's density of this direction over the hero's: 1 where the lane's sampling is the
    /// hero's, 0 where the lane could not have come this way (it refracts elsewhere).
    /// Lane 0 is always 1.
    pub ratio: Sampled<C>,
    /// Whether the ray goes through the surface rather than back from it.
    pub transmitted: bool,
}
