//! Light from beyond the scene.

use super::{EnvironmentMap, EnvironmentSamples, Sky};
use crate::geometry::Vec3;
use crate::lanes::{Mask, REGISTERS, Vec3Lanes, WIDTH, lanes_of, set};
use crate::sampling::quadrature::midpoints;
use crate::spectrum::{Sampled, Spectrum, Wavelengths};
use std::f64::consts::PI;

/// Radiance from beyond the scene, W·m⁻²·sr⁻¹·nm⁻¹. Directions have unit length and point away from the
/// scene.
#[derive(Clone, Debug)]
pub enum Environment {
    /// The same from everywhere. Scattering samples it best, so it is not sampled as a light.
    Constant(Spectrum),
    /// A picture.
    Map(Box<EnvironmentMap>),
    /// Sky and sun by a formula.
    Sky(Box<Sky>),
}

/// Strata, along each side of the unit square, of the directions that tell how even an environment is.
const STRATA: usize = 64;

impl Environment {
    /// Spectral radiance that comes from a direction (a unit vector toward the sky), W·m⁻²·sr⁻¹·nm⁻¹.
    pub fn radiance<const C: usize>(&self, direction: Vec3, nm: &[f64; C]) -> Sampled<C> {
        match self {
            Self::Constant(radiance) => radiance.sample(nm),
            Self::Map(map) => map.radiance(direction, nm),
            Self::Sky(sky) => sky.radiance(direction, nm),
        }
    }

    /// Whether directions toward it are sampled.
    pub fn is_sampled(&self) -> bool {
        !matches!(self, Self::Constant(_))
    }

    /// A direction toward the light and its density per steradian. `None` where it is not sampled.
    pub fn sample(&self, u: [f64; 2]) -> Option<(Vec3, f64)> {
        match self {
            Self::Constant(_) => None,
            Self::Map(map) => Some(map.sample(u)),
            Self::Sky(sky) => Some(sky.sample(u)),
        }
    }

    /// [`Self::sample`] with the radiance from there. `None` also where the direction is not on the side from
    /// which light counts, as [`super::Receiver::facing`] has it.
    pub fn sample_radiance<const C: usize>(
        &self,
        u: [f64; 2],
        facing: Vec3,
        nm: &[f64; C],
    ) -> Option<(Vec3, f64, Sampled<C>)> {
        if let Self::Map(map) = self {
            return map.sample_radiance(u, facing, nm);
        }
        let (direction, density) = self.sample(u)?;
        (direction.dot(facing) >= 0.0).then(|| (direction, density, self.radiance(direction, nm)))
    }

    /// [`Self::radiance`] and [`Self::density`] for directions of the lanes asked for, each with wavelengths
    /// of its own.
    pub fn seen_in_lanes<'w, const C: usize>(
        &self,
        directions: &[Vec3Lanes; REGISTERS],
        asked: Mask,
        wavelengths: impl Fn(usize) -> &'w Wavelengths<C>,
    ) -> EnvironmentSamples<C> {
        if let Self::Map(map) = self {
            return map.seen_in_lanes(directions, asked, wavelengths);
        }
        let mut seen = EnvironmentSamples { direction: *directions, ..EnvironmentSamples::NONE };
        for lane in lanes_of(asked) {
            let direction = directions[lane / WIDTH % REGISTERS].get(lane);
            seen.radiance.set(lane, &self.radiance(direction, &wavelengths(lane).nm));
            set(&mut seen.density, lane, self.density(direction));
        }
        seen
    }

    /// The density of [`Self::sample`] at a direction.
    pub fn density(&self, direction: Vec3) -> f64 {
        match self {
            Self::Constant(_) => 0.0,
            Self::Map(map) => map.density(direction),
            Self::Sky(sky) => sky.density(direction),
        }
    }

    /// The mean of the square of the brightness over the square of the mean: 1 where light comes alike from
    /// everywhere, and the larger the smaller the part of the sphere is that most of it comes from.
    /// Estimated by directions that follow the brightness.
    pub fn unevenness(&self) -> f64 {
        if !self.is_sampled() {
            return 1.0;
        }
        self.densities().sum::<f64>() / (STRATA * STRATA) as f64
    }

    /// About the greatest brightness over the mean, of all but spots from which next to no light comes.
    pub fn peak(&self) -> f64 {
        if !self.is_sampled() {
            return 1.0;
        }
        self.densities().fold(1.0, f64::max)
    }

    /// Densities over that of even light, of directions that follow the brightness.
    fn densities(&self) -> impl Iterator<Item = f64> {
        midpoints(STRATA).filter_map(|u| self.sample(u)).map(|(_, density)| 4.0 * PI * density)
    }

    /// Mean radiance over the sphere, above 0 at every wavelength at which there is any.
    pub fn mean(&self) -> &Spectrum {
        match self {
            Self::Constant(radiance) => radiance,
            Self::Map(map) => map.mean(),
            Self::Sky(sky) => sky.mean(),
        }
    }
}
