//! How light subpaths begin, and what they bring to the film: what [`super::caustics`] and
//! [`super::visible_lamps`] have in common.

use super::plan::Plan;
use super::{caustics, visible_lamps};
use crate::camera::Projected;
use crate::geometry::{Ray, SurfacePoint};
use crate::light::LightTracing;
use crate::sampling::{Dimensions, Stream};
use crate::scene::{RayKind, Scene};
use crate::spectrum::{Sampled, Spectrum, Wavelengths};

/// What a light subpath brings to the film.
#[derive(Clone, Copy, Debug)]
pub struct Splat<'a, const C: usize> {
    /// Where, in pixels from the corner of the whole film.
    pub film: [f64; 2],
    /// Spectral radiance × pixels, one estimate for each wavelength, as [`super::radiance`] gives them.
    pub radiance: Sampled<C>,
    /// The wavelengths of the light subpath.
    pub wavelengths: Wavelengths<C>,
    /// The sensor's.
    pub response: Option<&'a Spectrum>,
}

/// What a light subpath begins with, whatever it is to find.
pub(super) struct Start<const C: usize> {
    pub time: f64,
    pub wavelengths: Wavelengths<C>,
    /// A value that chooses the source.
    pub source: f64,
    /// Two that choose the place on it.
    pub place: [f64; 2],
    /// Two that choose where it leads to from there, and one for the choice among bodies.
    pub onward: [f64; 2],
    pub body: f64,
}

impl<const C: usize> Start<C> {
    fn new(scene: &Scene, stream: &Stream) -> Self {
        let [x, y, wavelength, time] = stream.draw(Dimensions::Camera);
        let [u, v, body, source] = stream.draw(Dimensions::Lens);
        let wavelengths = scene.wavelengths.sample(wavelength);
        Self { time: scene.shutter.time(time), wavelengths, source, place: [x, y], onward: [u, v], body }
    }
}

/// Traces a light subpath beside camera paths of a plan, and tells of what it brings to the film.
pub fn light_subpath<'a, const C: usize>(
    scene: &'a Scene,
    light_tracing: &LightTracing,
    plan: Plan,
    stream: &Stream,
    splat: &mut impl FnMut(Splat<'a, C>),
) {
    let start = Start::new(scene, stream);
    if let Some(visible_lamps) = &light_tracing.visible_lamps {
        visible_lamps::splat(scene, visible_lamps, &start).map(&mut *splat);
    }
    if let Some(caustics) = &light_tracing.caustics {
        caustics::light_subpath(scene, caustics, plan.sharing, &start, stream, splat);
    }
}

/// From a point of a surface to where the lens sees it. `None` where something is in the way.
pub(super) fn segment_to_lens(
    scene: &Scene,
    point: &SurfacePoint,
    seen: &Projected<'_>,
    time: f64,
) -> Option<Ray> {
    let segment = point.segment_to(&seen.end())?;
    (!scene.is_occluded(&segment, time, RayKind::LightTracing)).then_some(segment)
}
