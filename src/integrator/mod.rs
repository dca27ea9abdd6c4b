//! Light transport: the radiance that arrives along a camera ray.

mod path;
mod walk;

use crate::geometry::Ray;
use crate::sampling::Stream;
use crate::scene::Scene;
use crate::spectrum::{Sampled, Wavelengths};

/// How the radiance along a camera ray is estimated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Integrator {
    /// Path tracing with next-event estimation.
    Path,
    /// Scattering alone: the oracle.
    Walk,
}

/// How light is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Techniques {
    /// By scattering and by light samples, each weighed against the other.
    Both,
    /// By scattering alone. Lights without extent are never found.
    Scattering,
    /// By light samples alone. Mirror images of lights are never found.
    LightSamples,
}

/// Where paths end and what they see.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Most segments of a path, the camera ray included.
    pub max_depth: u32,
    /// Segments from which Russian roulette may end a path.
    pub rr_depth: u32,
    /// Whether lights are invisible to camera rays.
    pub hide_emitters: bool,
    /// Whether passing a surface as if there were none makes a segment of its own; then such a surface is in the way of
    /// light samples, too.
    pub passing_counts: bool,
    pub techniques: Techniques,
}

/// Spectral radiance that arrives along a camera ray, W·m⁻²·sr⁻¹·nm⁻¹, one estimate for each wavelength of the path. They
/// share one unit of weight: summed over the lanes, each over its wavelength's density, they estimate an integral
/// over wavelength.
pub fn radiance<const C: usize>(
    scene: &Scene,
    ray: Ray,
    wavelengths: &Wavelengths<C>,
    stream: &Stream,
) -> Sampled<C> {
    match scene.integrator {
        Integrator::Path => path::radiance(scene, ray, wavelengths, stream),
        Integrator::Walk => walk::radiance(scene, ray, wavelengths, stream),
    }
}
