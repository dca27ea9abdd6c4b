//! Where light subpaths begin, and where to. See `integrator::caustics` for what becomes of them.

use super::casters::TowardCasters;
use super::tracing::{Origin, Source, Sources, Subpaths};
use super::{Caster, Casters};
use crate::geometry::{Ray, SurfacePoint, Vec3};

/// Where light subpaths begin, and where to.
#[derive(Clone, Debug)]
pub struct Caustics {
    casters: Casters,
    /// A sphere around the scene.
    scene: Caster,
    sources: Sources,
    subpaths: Subpaths,
}

impl Caustics {
    /// With a sphere around the scene, and sources in ascending order, the environment last. `None` where
    /// there are no light subpaths.
    pub fn new(casters: Casters, scene: Caster, sources: Vec<Source>, subpaths: Subpaths) -> Option<Self> {
        let sources = Sources::new(sources).filter(|_| !casters.is_empty())?;
        Some(Self { casters, scene, sources, subpaths })
    }

    /// Where one begins, and the probability of choosing that.
    pub fn choose(&self, u: f64) -> (Origin, f64) {
        self.sources.choose(u)
    }

    /// Directions of subpaths from a point of a light. `None` where there is nothing to aim at.
    pub fn aim_from(&self, point: &SurfacePoint) -> Option<TowardCasters> {
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
        let probability = self.sources.environment_probability();
        if probability == 0.0 {
            return 0.0;
        }
        let chosen = probability * density;
        self.subpaths.per_sample() * chosen * self.casters.density_along(-direction, place)
    }

    /// The light's factor of the ratio of densities, that of light subpaths over that of camera paths, for
    /// subpaths that begin at a point of a light in a direction. `area_ratio`: [`super::Lights::area_ratio`].
    /// Zero where none do.
    pub fn light_factor(&self, light: u32, point: &SurfacePoint, direction: Vec3, area_ratio: f64) -> f64 {
        let at_point = self.sources.density_on(light) / area_ratio;
        let cos = direction.dot(point.normal);
        if at_point == 0.0 || cos <= 0.0 {
            return 0.0;
        }
        let Some(aim) = self.casters.seen_from(point) else { return 0.0 };
        self.subpaths.per_sample() * at_point * aim.density(direction) / cos
    }
}
