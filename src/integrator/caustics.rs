//! Light paths: caustics from the side of the light.
//!
//! Light that a smooth body focuses on a surface is found by a path from the camera only if it runs into the light by chance. From
//! the light it is found at once: of a path
//!
//! camera → matt surface → smooth surface → … → smooth surface → light,
//!
//! whose smooth surfaces scatter in single directions alone, all but the first segment is made beginning at the light, toward the
//! bodies. What arrives at the matt surface is seen by the camera with the weight
//!
//! Φ · f(ω, ω′) · cos θ′ / d² · dx/dω′,
//!
//! Φ the power of the path over the density of making it, ω′ the direction to the camera at the distance d, and dx/dω′ the film's
//! area for a solid angle there (Arvo, "Backward Ray Tracing", SIGGRAPH 1986 course notes; Veach 1997, section 8.3).
//! Paths of this form are no longer counted by [`super::path`], all others are: each is counted once, and nothing is weighed.
//!
//! A smooth surface sends light on as it does in the other direction, but for two factors. Refraction does not compress power, as it
//! does radiance. And where a surface is shaded with another normal than its own, beams of equal power differ on its two sides
//! (Veach 1997, section 5.3).

use super::path::late_survival;
use crate::geometry::{Ray, SurfacePoint, Vec3};
use crate::light::Casters;
use crate::medium::Media;
use crate::sampling::{Dimensions, PiecewiseConstant, Stream};
use crate::scene::{Intersection, Scene};
use crate::spectrum::{Sampled, Spectrum, Wavelengths};

/// Where light paths begin, and where to.
#[derive(Clone, Debug)]
pub struct Caustics {
    casters: Casters,
    /// Those of the scene's lights that send out light paths, in ascending order.
    lights: Vec<u32>,
    choice: PiecewiseConstant,
}

impl Caustics {
    /// Lights in ascending order with what each weighs in the choice among them. `None` where there are no light paths.
    pub fn new(casters: Casters, lights: &[(u32, f64)]) -> Option<Self> {
        if casters.is_empty() || lights.is_empty() {
            return None;
        }
        let (lights, weights): (Vec<u32>, Vec<f64>) = lights.iter().copied().unzip();
        let edges = (0..=lights.len()).map(|i| i as f64).collect();
        Some(Self { casters, choice: PiecewiseConstant::new(edges, &weights)?, lights })
    }

    /// Whether what a light emits reaches matt surfaces by way of smooth ones on light paths.
    pub fn begin_at(&self, light: u32) -> bool {
        self.lights.binary_search(&light).is_ok()
    }

    fn choose(&self, u: f64) -> (u32, f64) {
        let (place, probability) = self.choice.sample(u);
        (self.lights[(place as usize).min(self.lights.len() - 1)], probability)
    }
}

/// What a light path brings to the film.
#[derive(Clone, Copy, Debug)]
pub struct Splat<'a, const C: usize> {
    /// Where, in pixels from the corner of the whole film.
    pub film: [f64; 2],
    /// Spectral radiance × pixels, one estimate for each wavelength, as [`super::radiance`] gives them.
    pub radiance: Sampled<C>,
    pub wavelengths: Wavelengths<C>,
    /// The sensor's.
    pub response: Option<&'a Spectrum>,
}

/// A path from a light by way of smooth surfaces to a matt one and from there to the film. `None` where it does not get there.
pub fn splat<'a, const C: usize>(
    scene: &'a Scene,
    caustics: &Caustics,
    stream: &Stream,
) -> Option<Splat<'a, C>> {
    let [x, y, wavelength, time] = stream.draw(Dimensions::Camera);
    let [u, v, cone, light] = stream.draw(Dimensions::Lens);
    let time = scene.shutter.time(time);
    let wavelengths = scene.wavelengths.sample::<C>(wavelength);
    let (light, probability) = caustics.choose(light);
    let start = scene.lights.emit(light, [x, y], time, &wavelengths.nm)?;
    let (direction, density) = caustics.casters.seen_from(&start.point)?.sample(cone, [u, v])?;
    let cos = direction.dot(start.point.normal);
    if cos <= 0.0 {
        return None;
    }
    let mut beam = Beam {
        ray: start.point.ray(direction),
        power: start.radiance * (cos / (probability * start.density * density)),
        ratio: Sampled::ONE,
        media: Media::default(),
    };
    let (hit, vertex) = beam.follow(scene, time, &wavelengths, stream)?;
    let [lens_x, lens_y, _, choice] = stream.draw(Dimensions::Light(vertex));
    let seen = scene.camera.project(hit.point.position, [lens_x, lens_y], time)?;
    let shading = scene.shade(&hit, seen.toward_lens, &beam.media, &wavelengths, choice);
    if shading.bsdf.is_discrete() || shading.bsdf.transmits() {
        return None;
    }
    let f_cos = shading.evaluate(-beam.ray.direction).f_cos;
    if f_cos.is_zero() {
        return None;
    }
    let end = SurfacePoint { position: seen.begins, normal: seen.toward_lens, error: 0.0 };
    let last = hit.point.segment_to(&end)?;
    if scene.is_occluded(&last, time) {
        return None;
    }
    if let Some(transmittance) = scene.transmittance(&beam.media.here, last.t_max, &wavelengths) {
        beam.power *= transmittance;
    }
    // What arrives is spread over the surface by its own normal, and weighed by the BSDF's.
    let arriving = beam.ray.direction.dot(hit.point.normal).abs();
    let leaving = seen.toward_lens.dot(hit.point.normal).abs();
    let geometry = leaving / (arriving * seen.distance * seen.distance) * seen.pixels_per_steradian;
    let radiance = beam.power * f_cos * (geometry / beam.ratio.sum());
    Some(Splat { film: seen.film, radiance, wavelengths, response: seen.response })
}

/// Light on its way.
struct Beam<const C: usize> {
    ray: Ray,
    /// Of each wavelength, over the hero's density.
    power: Sampled<C>,
    /// Each wavelength's density of the path over the hero's, as in [`super::path`].
    ratio: Sampled<C>,
    media: Media,
}

impl<const C: usize> Beam<C> {
    /// To the first surface that is not smooth, by at least one that is: that, and how many were.
    fn follow(
        &mut self,
        scene: &Scene,
        time: f64,
        wavelengths: &Wavelengths<C>,
        stream: &Stream,
    ) -> Option<(Intersection, u32)> {
        let begun = self.power.max();
        for vertex in 0.. {
            let Self { power, media, .. } = self;
            let hit = scene.intersect(&self.ray, time, false, media, |media, distance| {
                if let Some(transmittance) = scene.transmittance(media, distance, wavelengths) {
                    *power *= transmittance;
                }
            })?;
            if !scene.is_smooth(&hit) {
                return (vertex > 0).then_some((hit, vertex));
            }
            // With this surface the path has two segments more than there are smooth surfaces.
            if vertex + 3 > scene.limits.max_depth {
                return None;
            }
            let [_, _, lobe, survival] = stream.draw(Dimensions::Scattering(vertex));
            self.pass(scene, &hit, wavelengths, lobe)?;
            let kept = (self.power.max() / begun).min(late_survival(vertex + 3));
            if self.power.is_zero() || vertex + 3 >= scene.limits.rr_depth && survival >= kept {
                return None;
            }
            if vertex + 3 >= scene.limits.rr_depth {
                self.power /= kept;
            }
        }
        None
    }

    /// On from a smooth surface.
    fn pass(
        &mut self,
        scene: &Scene,
        hit: &Intersection,
        wavelengths: &Wavelengths<C>,
        lobe: f64,
    ) -> Option<()> {
        let arrives = -self.ray.direction;
        let shading = scene.shade(hit, arrives, &self.media, wavelengths, 0.0);
        let scatter = shading.sample(lobe, [0.5; 2])?;
        let leaves = scatter.toward_light;
        self.power *= scatter.weight * spread(hit, arrives, leaves)?;
        self.ratio *= scatter.ratio;
        if scatter.transmitted {
            // The BSDF's weight is for radiance.
            let compression = shading.index_beyond().unwrap_or(1.0);
            self.power *= compression * compression;
            scene.pass_through(hit, leaves, &mut self.media);
        }
        self.ray = hit.point.ray(leaves);
        Some(())
    }
}

/// By how much a beam that arrives from one direction and leaves in another is wider on the surface than the BSDF takes it to be:
/// 1 where that is shaded with its own normal. `None` where the beam grazes it.
fn spread(hit: &Intersection, arrives: Vec3, leaves: Vec3) -> Option<f64> {
    let (own, shading) = (hit.point.normal, hit.shading_normal);
    if own == shading {
        return Some(1.0);
    }
    let factor = arrives.dot(shading) * leaves.dot(own) / (arrives.dot(own) * leaves.dot(shading));
    factor.is_finite().then(|| factor.abs())
}
