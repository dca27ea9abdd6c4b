//! Where light subpaths begin, and where to. See `integrator::caustics` for what becomes of them.

use super::casters::Aim;
use super::{Caster, Casters};
use crate::geometry::{Ray, SurfacePoint, Vec3};
use crate::sampling::PiecewiseConstant;

/// Samples of a pixel for one light subpath a pixel, where nothing is known of what they cost and gain. The
/// weights of the two techniques take it for the number: they sum to 1 whatever it is.
pub const USUAL_SAMPLES_PER_PATH: u64 = 2;

/// Where light subpaths begin, and where to.
#[derive(Clone, Debug)]
pub struct Caustics {
    casters: Casters,
    /// A sphere around the scene.
    scene: Caster,
    /// Those with a surface in ascending order of their numbers, then the environment.
    sources: Vec<Source>,
    choice: PiecewiseConstant,
    pixels: u64,
}

/// What sends out light subpaths.
#[derive(Clone, Copy, Debug)]
pub struct Source {
    /// Where its light comes from.
    pub origin: Origin,
    /// What it weighs in the choice among them.
    pub power: f64,
}

/// Where light subpaths come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Origin {
    /// A surface.
    Surface {
        /// Among the scene's lights.
        light: u32,
        /// Its area, in squared scene units.
        area: f64,
    },
    /// Beyond the scene.
    Environment,
}

impl Caustics {
    /// With a sphere around the scene, sources in ascending order, the environment last, and the number of
    /// the film's pixels. `None` where there are no light subpaths.
    pub fn new(casters: Casters, scene: Caster, sources: Vec<Source>, pixels: u64) -> Option<Self> {
        if casters.is_empty() || sources.is_empty() {
            return None;
        }
        let edges = (0..=sources.len()).map(|i| i as f64).collect();
        let powers: Vec<f64> = sources.iter().map(|source| source.power).collect();
        Some(Self { casters, scene, choice: PiecewiseConstant::new(edges, &powers)?, sources, pixels })
    }

    /// How many light subpaths there are with so many samples of each pixel, if there is one a pixel for each
    /// `samples_per_path`.
    pub fn paths(&self, samples: u32, samples_per_path: u64) -> u64 {
        (self.pixels * u64::from(samples)).div_ceil(samples_per_path)
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

    /// A ray from beyond the scene along a direction, aimed at the bodies, with its density per area across
    /// it. `choice` and `u` in [0, 1). `None` where there is no density.
    pub fn ray_along(&self, direction: Vec3, choice: f64, u: [f64; 2]) -> Option<(Ray, f64)> {
        self.casters.ray_along(direction, &self.scene, choice, u)
    }

    /// The environment's factor of the ratio of densities, as [`Self::light_factor`] is that of a light:
    /// for subpaths from a direction through a place, of which `density` is the one per steradian.
    pub fn environment_factor(&self, direction: Vec3, density: f64, place: Vec3) -> f64 {
        let at = self.sources.len() - 1;
        if self.sources[at].origin != Origin::Environment {
            return 0.0;
        }
        let chosen = self.choice.density(at as f64 + 0.5) * density;
        self.paths_per_sample() * chosen * self.casters.density_along(-direction, place)
    }

    /// Light subpaths for one sample of each pixel, as the weights have it.
    fn paths_per_sample(&self) -> f64 {
        self.pixels as f64 / USUAL_SAMPLES_PER_PATH as f64
    }

    /// The light's factor of the ratio of densities, that of light subpaths over that of camera paths, for
    /// subpaths that begin at a point of a light in a direction. Zero where none do.
    pub fn light_factor(&self, light: u32, point: &SurfacePoint, direction: Vec3) -> f64 {
        // The environment's number is above all others.
        let number = |source: &Source| match source.origin {
            Origin::Surface { light, .. } => light,
            Origin::Environment => u32::MAX,
        };
        let Ok(at) = self.sources.binary_search_by_key(&light, number) else { return 0.0 };
        let Origin::Surface { area, .. } = self.sources[at].origin else { return 0.0 };
        let cos = direction.dot(point.normal);
        if cos <= 0.0 {
            return 0.0;
        }
        let Some(aim) = self.casters.seen_from(point) else { return 0.0 };
        let at_point = self.choice.density(at as f64 + 0.5) / area;
        self.paths_per_sample() * at_point * aim.density(direction) / cos
    }
}
