//! Where light subpaths begin, and where to. See `integrator::caustics` for what becomes of them.

use super::Casters;
use super::casters::Aim;
use crate::geometry::{SurfacePoint, Vec3};
use crate::sampling::PiecewiseConstant;

/// Samples of all pixels for one light subpath: so their cost is small beside the rest, and after few samples
/// there are as many as pixels.
const SAMPLES_PER_PATH: u64 = 4;

/// Where light subpaths begin, and where to.
#[derive(Clone, Debug)]
pub struct Caustics {
    casters: Casters,
    /// In ascending order of their numbers.
    sources: Vec<Source>,
    choice: PiecewiseConstant,
    pixels: u64,
}

/// A light that sends out light subpaths.
#[derive(Clone, Copy, Debug)]
pub struct Source {
    /// Among the scene's lights.
    pub light: u32,
    /// What it weighs in the choice among them.
    pub power: f64,
    /// Its area, in squared scene units.
    pub area: f64,
}

impl Caustics {
    /// With sources in ascending order, and the number of the film's pixels. `None` where there are no light
    /// paths.
    pub fn new(casters: Casters, sources: Vec<Source>, pixels: u64) -> Option<Self> {
        if casters.is_empty() || sources.is_empty() {
            return None;
        }
        let edges = (0..=sources.len()).map(|i| i as f64).collect();
        let powers: Vec<f64> = sources.iter().map(|source| source.power).collect();
        Some(Self { casters, choice: PiecewiseConstant::new(edges, &powers)?, sources, pixels })
    }

    /// How many light subpaths there are with so many samples of each pixel.
    pub fn paths(&self, samples: u32) -> u64 {
        (self.pixels * u64::from(samples)).div_ceil(SAMPLES_PER_PATH)
    }

    /// A light, and the probability of choosing it.
    pub fn choose(&self, u: f64) -> (&Source, f64) {
        let (place, probability) = self.choice.sample(u);
        (&self.sources[(place as usize).min(self.sources.len() - 1)], probability)
    }

    /// Where subpaths from a point of a light aim at. `None` where there is nothing to aim at.
    pub fn aim_from(&self, point: &SurfacePoint) -> Option<Aim> {
        self.casters.seen_from(point)
    }

    /// The light's factor of the ratio of densities, that of light subpaths over that of camera paths, for
    /// subpaths that begin at a point of a light in a direction. Zero where none do.
    pub fn light_factor(&self, light: u32, point: &SurfacePoint, direction: Vec3) -> f64 {
        let Ok(at) = self.sources.binary_search_by_key(&light, |source| source.light) else { return 0.0 };
        let cos = direction.dot(point.normal);
        if cos <= 0.0 {
            return 0.0;
        }
        let Some(aim) = self.casters.seen_from(point) else { return 0.0 };
        let at_point = self.choice.density(at as f64 + 0.5) / self.sources[at].area;
        let paths = self.pixels as f64 / SAMPLES_PER_PATH as f64;
        paths * at_point * aim.density(direction) / cos
    }
}
