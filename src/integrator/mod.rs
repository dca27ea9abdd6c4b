//! Light transport: the radiance that arrives along a camera ray.

mod branches;
mod bundle;
mod caustics;
mod contributions;
mod light_subpaths;
mod links;
mod metals;
mod observe;
mod path;
mod plan;
mod shared;
mod surfaces;
mod visible_lamps;
mod volume;
mod walk;
mod weights;

use crate::camera::LitPoint;
use crate::geometry::Ray;
use crate::sampling::Stream;
use crate::scene::{Coverage, Integrator, Limits, RayKind, Scene};
use crate::spectrum::{Sampled, Wavelengths};
use serde::{Deserialize, Serialize};
use std::fmt;

pub use light_subpaths::{Splat, light_subpath};
use observe::Record;
pub use observe::{RecordedStep, Step};
pub use plan::{Plan, Sharing};
pub use shared::{GroupSample, Sight, TOGETHER, Workspace, parts_of_group, radiance_of_group};

impl Limits {
    /// Whether rays that meet no surface count as having met something.
    fn sky_covers(&self, scene: &Scene) -> bool {
        self.coverage == Coverage::Obstacle && scene.lights.environment().is_some() && !self.hide_emitters
    }

    /// Whether a surface that a ray meets counts. `passes`: whether the ray goes on as if there were none.
    fn surface_covers(&self, passes: bool) -> bool {
        self.coverage == Coverage::Surface || !passes
    }
}

/// How much work the pixels have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Estimator {
    /// As much as pays.
    Shared,
    /// None: each pixel pays for its own light.
    Plain,
}

impl Estimator {
    /// The estimators by the names that the command line has for them.
    pub const NAMES: [(&str, Self); 2] = [("shared", Self::Shared), ("plain", Self::Plain)];

    /// The estimator of that name, if there is one.
    pub fn named(name: &str) -> Option<Self> {
        Self::NAMES.iter().find(|(known, _)| *known == name).map(|&(_, estimator)| estimator)
    }

    /// The name that the command line has for it.
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|&&(_, estimator)| estimator == self).map_or("", |&(name, _)| name)
    }
}

impl fmt::Display for Estimator {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Why pixels cannot share the suffixes of their paths in a scene. `None` where they can.
pub fn why_nothing_is_shared(scene: &Scene) -> Option<&'static str> {
    if scene.integrator != Integrator::Path {
        Some("the integrator is no path tracer")
    } else if scene.limits.max_depth == 0 {
        Some("paths have no segment")
    } else if scene.camera.measures_irradiance() {
        Some("the sensor itself takes light samples")
    } else if scene.film.moments {
        Some("second moments are those of a path tracer's samples")
    } else if scene.features().scattering {
        // What a medium scatters on the way from one surface to the other would have to be weighed, too.
        Some("a medium scatters or sends out light between the surfaces")
    } else {
        None
    }
}

/// Whether paths of pixels that share nothing can be followed together by [`radiance_of_group`], each with
/// wavelengths of its own. What they have in common is the time.
pub fn takes_strangers(scene: &Scene) -> bool {
    let features = scene.features();
    scene.integrator == Integrator::Path
        && scene.limits.max_depth > 0
        && !features.scattering
        && !features.motion
        && !scene.camera.measures_irradiance()
}

/// What a sample's camera ray has led to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadianceSample<const C: usize> {
    /// Spectral radiance, W·m⁻²·sr⁻¹·nm⁻¹, one value for each wavelength.
    pub radiance: Sampled<C>,
    /// Whether the path has met what the film's alpha counts.
    pub alpha_hit: bool,
}

impl<const C: usize> RadianceSample<C> {
    /// Nothing was met, and no light found.
    pub const NOTHING: Self = Self { radiance: Sampled::ZERO, alpha_hit: false };
}

/// Spectral radiance that arrives along a camera ray at a time, W·m⁻²·sr⁻¹·nm⁻¹, one estimate for each
/// wavelength of the path. Where the ray measures the irradiance at a `lit` place, a light sample from there
/// stands for radiance that such a ray may have met. The estimates share one unit of weight: summed over the
/// lanes, each over its wavelength's density, they estimate an integral over wavelength.
pub fn radiance<const C: usize>(
    scene: &Scene,
    ray: Ray,
    lit: Option<LitPoint>,
    time: f64,
    wavelengths: &Wavelengths<C>,
    stream: &Stream,
) -> RadianceSample<C> {
    if scene.limits.max_depth == 0 {
        return RadianceSample::NOTHING;
    }
    match scene.integrator {
        Integrator::Path => path::radiance(scene, ray, lit, time, wavelengths, stream),
        Integrator::Walk => walk::radiance(scene, ray, time, wavelengths, stream),
        Integrator::Depth => depth(scene, &ray, time),
    }
}

/// The same of a path tracer, with the steps that the path takes.
pub fn radiance_told<const C: usize>(
    scene: &Scene,
    ray: Ray,
    lit: Option<LitPoint>,
    time: f64,
    wavelengths: &Wavelengths<C>,
    stream: &Stream,
) -> (RadianceSample<C>, Vec<RecordedStep>) {
    if scene.limits.max_depth == 0 {
        return (RadianceSample::NOTHING, Vec::new());
    }
    let record = Record::default();
    let sample = path::observed_radiance(scene, ray, lit, time, wavelengths, stream, record.clone());
    (sample, record.into_steps())
}

fn depth<const C: usize>(scene: &Scene, ray: &Ray, time: f64) -> RadianceSample<C> {
    let mut media = scene.media_at_sensor(ray, time);
    let hit = scene.intersect(ray, time, RayKind::Camera, &mut media, |_, _| {});
    // Any of the wavelengths would have met the same.
    let radiance = hit.map_or(Sampled::ZERO, |hit| Sampled::splat(hit.t / C as f64));
    RadianceSample { radiance, alpha_hit: hit.is_some() }
}
