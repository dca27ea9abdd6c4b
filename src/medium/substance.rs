//! What a medium does to light on its way: how it weakens it and how it scatters it.
//!
//! A ray is scattered where the hero's optical depth reaches a value τ that is distributed as e^−τ. A
//! wavelength of extinction σⱼ and optical depth τⱼ up to a place would have been scattered there with
//! density σⱼ e^−τⱼ, and would have passed it by with probability e^−τⱼ. Both are known for all wavelengths
//! of the path, so each companion says what it would have done (Wilkie et al., "Hero Wavelength Spectral
//! Sampling", EGSR 2014, section 4.2).

use super::{Diluted, Emission, GridExtinction};
use crate::geometry::{Ray, Vec3};
use crate::phase::Phase;
use crate::spectrum::{Sampled, Spectrum};
use crate::texture::{Texture, TexturePoint};
use crate::units::WavelengthRange;

/// What fills a body, or surrounds the camera.
#[derive(Clone, Debug)]
pub struct Medium {
    /// What it absorbs and scatters, per scene unit.
    pub extinction: Extinction,
    /// `None` where the medium only absorbs.
    pub scattering: Option<Scattering>,
    /// `None` where it sends out no light.
    pub emission: Option<Emission>,
}

/// What a medium takes from a ray of light per unit of length: absorbed and scattered.
#[derive(Clone, Debug)]
pub enum Extinction {
    /// The same everywhere.
    Homogeneous(Spectrum),
    /// Values on a grid, the same at all wavelengths.
    Grid(Box<GridExtinction>),
    /// A spectrum times a density.
    Diluted(Box<Diluted>),
}

/// How a medium scatters.
#[derive(Clone, Debug)]
pub struct Scattering {
    /// The fraction of the extinction that is scattered, from 0 to 1.
    pub albedo: Texture,
    /// Where it scatters to.
    pub phase: Phase,
    /// The probability with which a place where it scatters takes a light sample, above 0.
    pub light_sample_probability: f64,
}

/// Where a ray that flies through a medium collides, if it does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FreeFlight<const C: usize> {
    /// It passes all of it, through these optical depths.
    Passed {
        /// Optical depth of the whole segment, by wavelength.
        depths: Sampled<C>,
    },
    /// It is scattered or absorbed at a distance from where it begins, behind these optical depths and where
    /// the extinction is this.
    Ended {
        /// Distance to the collision, in scene units.
        distance: f64,
        /// Optical depth up to the collision, by wavelength.
        depths: Sampled<C>,
        /// Extinction there, per scene unit, by wavelength.
        extinction: Sampled<C>,
    },
}

impl Medium {
    /// Whether it does nothing at all to light of a range of wavelengths, and sends out none.
    pub fn is_clear(&self, range: WavelengthRange) -> bool {
        let takes_nothing = match &self.extinction {
            Extinction::Homogeneous(spectrum) => spectrum.is_zero(range),
            Extinction::Grid(grid) => grid.is_zero(),
            Extinction::Diluted(diluted) => diluted.density.is_zero() || diluted.spectrum.is_zero(range),
        };
        takes_nothing && self.emission.as_ref().is_none_or(|emission| emission.is_zero(range))
    }

    /// The spectrum of a homogeneous medium that absorbs and nothing else.
    pub fn absorption(&self) -> Option<&Spectrum> {
        match &self.extinction {
            Extinction::Homogeneous(spectrum) if self.scattering.is_none() && self.emission.is_none() => {
                Some(spectrum)
            }
            _ => None,
        }
    }

    /// What the extinction along a direction is multiplied by: flakes look larger from some sides.
    pub fn projected_area(&self, direction: Vec3) -> f64 {
        self.scattering.as_ref().map_or(1.0, |scattering| scattering.phase.projected_area(direction))
    }

    /// The extinction at a place, per unit of length along a direction.
    pub fn extinction_at<const C: usize>(
        &self,
        position: Vec3,
        direction: Vec3,
        nm: &[f64; C],
    ) -> Sampled<C> {
        let whole = match &self.extinction {
            Extinction::Homogeneous(spectrum) => spectrum.sample(nm),
            Extinction::Grid(grid) => grid.at(position, nm),
            Extinction::Diluted(diluted) => diluted.at(position, nm),
        };
        whole * self.projected_area(direction)
    }

    /// The optical depths from the beginning of a ray to its end, which may be infinitely far.
    pub fn optical_depths<const C: usize>(&self, ray: &Ray, nm: &[f64; C]) -> Sampled<C> {
        let whole = match &self.extinction {
            Extinction::Homogeneous(spectrum) => depths(spectrum.sample(nm), ray.t_max),
            Extinction::Grid(grid) => grid.optical_depths(ray, nm),
            Extinction::Diluted(diluted) => diluted.optical_depths(ray, nm),
        };
        whole * self.projected_area(ray.direction)
    }

    /// What a ray does that ends where the hero's optical depth is `target`.
    pub fn fly<const C: usize>(&self, ray: &Ray, target: f64, nm: &[f64; C]) -> FreeFlight<C> {
        let area = self.projected_area(ray.direction);
        let target = target / area;
        let flight = match &self.extinction {
            Extinction::Homogeneous(spectrum) => {
                let extinction = spectrum.sample(nm);
                let distance = target / extinction.hero();
                if distance < ray.t_max {
                    FreeFlight::Ended { distance, depths: depths(extinction, distance), extinction }
                } else {
                    FreeFlight::Passed { depths: depths(extinction, ray.t_max) }
                }
            }
            Extinction::Grid(grid) => grid.fly(ray, target, nm),
            Extinction::Diluted(diluted) => diluted.fly(ray, target, nm),
        };
        match flight {
            FreeFlight::Passed { depths } => FreeFlight::Passed { depths: depths * area },
            FreeFlight::Ended { distance, depths, extinction } => {
                FreeFlight::Ended { distance, depths: depths * area, extinction: extinction * area }
            }
        }
    }
}

/// What absorbs nothing has no depth, over any distance.
fn depths<const C: usize>(extinction: Sampled<C>, distance: f64) -> Sampled<C> {
    extinction.map(|sigma| if sigma > 0.0 { sigma * distance } else { 0.0 })
}

impl Scattering {
    /// Fraction of the extinction that is scattered at a place, from 0 to 1, at the wavelengths `nm`.
    pub fn albedo<const C: usize>(&self, position: Vec3, nm: &[f64; C]) -> Sampled<C> {
        match self.albedo.uniform() {
            Some(spectrum) => spectrum.sample(nm),
            None => self.albedo.sample(&TexturePoint::in_space(position), nm),
        }
    }
}
