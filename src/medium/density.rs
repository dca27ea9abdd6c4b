//! One spectrum of extinction, thinned from place to place.

use super::{Exponential, FreeFlight, GridExtinction};
use crate::geometry::{Ray, Vec3};
use crate::spectrum::{Sampled, Spectrum};

/// How much there is of a medium at each place, over what its spectrum is for. The same for all wavelengths.
#[derive(Clone, Debug)]
pub enum Density {
    /// Values on a grid.
    Grid(GridExtinction),
    /// It falls off with height.
    Exponential(Exponential),
}

/// An extinction that is a density times a spectrum: one integral along a ray serves all wavelengths.
#[derive(Clone, Debug)]
pub struct Diluted {
    /// How much there is, by place.
    pub density: Density,
    /// What it is multiplied with, by wavelength.
    pub spectrum: Spectrum,
}

/// Where a density that has no wavelength is looked up.
const ANY: [f64; 1] = [550.0];

impl Density {
    /// Density at a place, at least 0.
    pub fn at(&self, position: Vec3) -> f64 {
        match self {
            Self::Grid(grid) => grid.at(position, &ANY).hero(),
            Self::Exponential(air) => air.at(position),
        }
    }

    /// No density is above it.
    pub fn max_bound(&self) -> f64 {
        match self {
            Self::Grid(grid) => grid.max_bound(),
            Self::Exponential(_) => 1.0,
        }
    }

    /// Whether it is 0 everywhere.
    pub fn is_zero(&self) -> bool {
        match self {
            Self::Grid(grid) => grid.is_zero(),
            Self::Exponential(_) => false,
        }
    }

    /// The part of a ray outside of which there is nothing. `None` where there is nothing at all.
    pub fn span(&self, ray: &Ray) -> Option<[f64; 2]> {
        match self {
            Self::Grid(grid) => grid.span(ray),
            Self::Exponential(_) => Some([0.0, ray.t_max]),
        }
    }

    fn depth(&self, ray: &Ray) -> f64 {
        match self {
            Self::Grid(grid) => grid.optical_depths(ray, &ANY).hero(),
            Self::Exponential(air) => air.depth(ray),
        }
    }

    fn fly(&self, ray: &Ray, target: f64) -> FreeFlight<1> {
        match self {
            Self::Grid(grid) => grid.fly(ray, target, &ANY),
            Self::Exponential(air) => air.fly(ray, target),
        }
    }
}

impl Diluted {
    /// Value at a place, at the wavelengths `nm`.
    pub fn at<const C: usize>(&self, position: Vec3, nm: &[f64; C]) -> Sampled<C> {
        self.spectrum.sample(nm) * self.density.at(position)
    }

    /// Optical depth of a ray from its beginning to its end, at the wavelengths `nm`.
    pub fn optical_depths<const C: usize>(&self, ray: &Ray, nm: &[f64; C]) -> Sampled<C> {
        let depth = self.density.depth(ray);
        self.spectrum.sample(nm).map(|sigma| if sigma > 0.0 { sigma * depth } else { 0.0 })
    }

    /// See [`super::Medium::fly`].
    pub fn fly<const C: usize>(&self, ray: &Ray, target: f64, nm: &[f64; C]) -> FreeFlight<C> {
        let sigma = self.spectrum.sample(nm);
        let over = |depth: f64| sigma.map(|sigma| if sigma > 0.0 { sigma * depth } else { 0.0 });
        match self.density.fly(ray, target / sigma.hero()) {
            FreeFlight::Passed { depths } => FreeFlight::Passed { depths: over(depths.hero()) },
            FreeFlight::Ended { distance, depths, extinction } => FreeFlight::Ended {
                distance,
                depths: over(depths.hero()),
                extinction: sigma * extinction.hero(),
            },
        }
    }
}
