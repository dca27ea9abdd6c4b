//! Small lamps in the picture.
//!
//! A lens spreads a small lamp out of focus over many pixels. Few samples of these meet it, and each that
//! does is bright. So it is with a lamp in focus that is smaller than a pixel. A light subpath begins at a
//! point x of the lamp and reaches a point of the lens at once. It brings
//!
//! Le · cos θ / d² · dx/dω / p(x)
//!
//! to the film, ω the direction to the lens at the distance d, and dx/dω the film's area for a solid angle
//! there: a path of one segment in bidirectional path tracing (Veach 1997, section 10.3).
//!
//! Camera rays find the same. The two techniques are weighed by the power heuristic, with the ratio of their
//! densities
//!
//! r = N · p(x) / ν(x),
//!
//! N light subpaths for one sample of each pixel, and ν(x) pixels per area of the lamp.

use super::light_subpaths::{Splat, Start, segment_to_lens};
use super::weights::power_heuristic;
use crate::geometry::SurfacePoint;
use crate::light::{Emitted, LightHit, VisibleLamps};
use crate::scene::Scene;

impl VisibleLamps {
    /// The weight, beside light subpaths, of a camera ray that meets a lamp at a point.
    pub(super) fn camera_weight(&self, scene: &Scene, light: u32, point: &SurfacePoint, time: f64) -> f64 {
        match self.per_area(light) {
            0.0 => 1.0,
            per_own_area => {
                let per_area = per_own_area / scene.lights.area_ratio(light, point, time);
                power_heuristic(pixels_per_area(scene, point, time), per_area)
            }
        }
    }
}

/// Pixels for an area of a lamp, as the weights have it: seen through the middle of the lens, since any place
/// will do where both techniques take the same.
fn pixels_per_area(scene: &Scene, point: &SurfacePoint, time: f64) -> f64 {
    scene
        .camera
        .project(point.position, [0.5; 2], time)
        .map_or(0.0, |seen| seen.pixels_per_area(point.normal))
}

/// What a light subpath brings that reaches the lens from a lamp. `None` where the lens does not see the
/// point at which it begins.
pub(super) fn splat<'a, const C: usize>(
    scene: &'a Scene,
    lamps: &VisibleLamps,
    start: &Start<C>,
) -> Option<Splat<'a, C>> {
    let &Start { time, wavelengths, source, place, onward, .. } = start;
    let (light, probability) = lamps.choose(source)?;
    let Emitted { hit: LightHit { point, .. }, radiance, density: at_point } =
        scene.lights.emit(light, place, time, &wavelengths.nm)?;
    let seen = scene.camera.project(point.position, onward, time)?;
    if seen.toward_lens.dot(point.normal) <= 0.0 {
        return None;
    }
    segment_to_lens(scene, &point, &seen, time)?;
    let weight = 1.0 - lamps.camera_weight(scene, light, &point, time);
    let density = probability * at_point;
    let scale = weight * seen.pixels_per_area(point.normal) / (density * C as f64);
    Some(Splat { film: seen.film, radiance: radiance * scale, wavelengths, response: seen.response })
}
