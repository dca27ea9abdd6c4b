//! What a path finds: light that surfaces emit, light from beyond the scene, and light samples.

use super::caustics;
use super::observe::{Observe, Step, list};
use super::path::{Beside, Competing, Contested, Path, PreviousSample};
use super::weights::{light_sample_weight, scattering_weight};
use crate::bsdf::Evaluation;
use crate::camera::LitPoint;
use crate::geometry::{Ray, Vec3};
use crate::light::{Caustics, LightSample, Receiver};
use crate::material::Shading;
use crate::medium::{Media, MediumStack};
use crate::sampling::{Density, Dimensions, Stream};
use crate::scene::{Intersection, Passage, Scene, Techniques};
use crate::spectrum::{Sampled, Wavelengths};
use std::borrow::Cow;

/// The throughput and the densities by which light samples on a path are weighed.
#[derive(Clone, Copy)]
pub(super) struct Prior<const C: usize> {
    pub throughput: Sampled<C>,
    pub ratio: Sampled<C>,
    /// The density of having come here by way of lamps that are near, over the hero's of having come
    /// otherwise.
    pub by_aim: f64,
    /// How many segments the path has with that of the light sample.
    pub segments: u32,
}

/// How light is contested; see [`Contested`].
struct Contest {
    from_light: f64,
    by_light: f64,
}

impl<const C: usize, O: Observe> Path<C, O> {
    /// Light from beyond the scene, weighed against having been sampled.
    pub(super) fn escaped(&mut self, scene: &Scene, ray: &Ray, wavelengths: &Wavelengths<C>) -> Sampled<C> {
        let hidden = self.camera_visible && scene.limits.hide_emitters;
        let Some(environment) = scene.lights.environment().filter(|_| !hidden) else { return Sampled::ZERO };
        let by_light =
            |from: &Receiver| scene.lights.environment_density(from, ray.direction, self.time, wavelengths);
        let mut weight = self.weight_beside_lights(scene, by_light);
        let shared = self.weigh_beside_light_subpaths(scene, &mut weight, by_light, |caustics| {
            caustics::factor_from_beyond(caustics, environment, ray)
        });
        if weight == 0.0 {
            return Sampled::ZERO;
        }
        let radiance = environment.radiance(ray.direction, &wavelengths.nm) * (weight / self.ratio.sum());
        self.contest(self.throughput * radiance, shared)
    }

    /// [`PreviousSample::weight_beside_lights`] of the path.
    fn weight_beside_lights(&self, scene: &Scene, density: impl Fn(&Receiver) -> f64) -> f64 {
        self.last.weight_beside_lights(scene, density)
    }

    /// Light that the surface just met emits toward the path, weighed against having been sampled.
    pub(super) fn emitted(
        &mut self,
        scene: &Scene,
        ray: &Ray,
        hit: &Intersection,
        wavelengths: &Wavelengths<C>,
    ) -> Sampled<C> {
        let Some(light_hit) = hit.on_light() else { return Sampled::ZERO };
        if ray.direction.dot(hit.point.normal) >= 0.0 {
            return Sampled::ZERO;
        }
        let by_light = |from: &Receiver| scene.lights.density(&light_hit, from, self.time, wavelengths);
        let mut weight = self.weight_beside_lights(scene, by_light);
        let shared = self.weigh_beside_light_subpaths(scene, &mut weight, by_light, |caustics| {
            let toward = -ray.direction;
            caustics::factor_from_lamp(scene, caustics, light_hit.light, &hit.point, toward, self.time)
        });
        if let (PreviousSample::Camera, Some(visible_lamps)) = (&self.last, scene.visible_lamps()) {
            weight *= visible_lamps.camera_weight(scene, light_hit.light, &hit.point, self.time);
        }
        if weight == 0.0 {
            return Sampled::ZERO;
        }
        let radiance = scene.lights.radiance(light_hit.light, &scene.texture_point(hit), &wavelengths.nm);
        self.contest(self.throughput * radiance * (weight / self.ratio.sum()), shared)
    }

    /// Weighs light that the path has found against light subpaths that come the same way, by the light's
    /// factor of the ratio of densities. `by_light`: the density with which light samples find it. Returns
    /// how it is contested where several surfaces share the path.
    #[inline(always)]
    fn weigh_beside_light_subpaths(
        &self,
        scene: &Scene,
        weight: &mut f64,
        by_light: impl FnOnce(&Receiver) -> f64,
        from_light: impl FnOnce(&Caustics) -> f64,
    ) -> Option<Contest> {
        let caustics = scene.caustics()?;
        let by_scattering = match (&self.last, self.competing) {
            (PreviousSample::Discrete, _) => 1.0,
            (PreviousSample::Scattered { .. }, Competing::Yes) => *weight,
            (PreviousSample::Scattered { from, .. }, Competing::Shared) => {
                return Some(Contest { from_light: from_light(caustics), by_light: by_light(from) });
            }
            _ => return None,
        };
        self.weigh_beside_caustics(scene, caustics, weight, || from_light(caustics) * by_scattering.sqrt())
    }

    /// The same, by the ratio of the densities but for the camera's factor.
    #[inline(always)]
    fn weigh_beside_caustics(
        &self,
        scene: &Scene,
        caustics: &Caustics,
        weight: &mut f64,
        ratio: impl FnOnce() -> f64,
    ) -> Option<Contest> {
        match &self.beside_light_subpaths {
            Beside::Nothing => None,
            Beside::First(first) => {
                *weight *= caustics.weight_beside(scene, first, ratio(), self.time);
                None
            }
            Beside::Shared => Some(Contest { from_light: ratio(), by_light: 0.0 }),
        }
    }

    /// Whether light that a surface scatters toward the path may be found by light subpaths too, though
    /// the surface scatters with a density.
    #[inline(always)]
    pub(super) fn competes_from(&self, scene: &Scene, hit: &Intersection, shading: &Shading<C>) -> bool {
        scene.features().caustics
            && self.vertex > 0
            && scene.is_nearly_specular(hit)
            && !shading.bsdf.is_discrete()
            && caustics::may_follow(scene, hit, shading, Density::PerSolidAngle(1.0))
    }

    /// What the path has found, unless that is kept apart; see [`Beside::Shared`].
    #[inline(always)]
    fn contest(&mut self, light: Sampled<C>, shared: Option<Contest>) -> Sampled<C> {
        match shared {
            Some(Contest { from_light, by_light }) if from_light > 0.0 => {
                self.contested.push(Contested { light, from_light, by_light });
                Sampled::ZERO
            }
            _ => light,
        }
    }

    /// Light that reaches the surface straight from one light, chosen and sampled for this place.
    #[inline(always)]
    pub(super) fn direct_light(
        &mut self,
        scene: &Scene,
        ray: &Ray,
        hit: &Intersection,
        shading: &Shading<C>,
        wavelengths: &Wavelengths<C>,
        stream: &Stream,
    ) -> Sampled<C> {
        if shading.bsdf.is_discrete() {
            return Sampled::ZERO;
        }
        let Some(sample) = self.light_sample(scene, hit, shading, wavelengths, stream) else {
            return Sampled::ZERO;
        };
        let value = shading.evaluate(sample.shadow_ray.direction);
        if value.f_cos.is_zero() {
            return Sampled::ZERO;
        }
        let around = media_beyond(scene, &self.media, ray, hit, &sample.shadow_ray);
        let prior = self.prior(0.0);
        let light = self.light_from(scene, &sample, &value, &around, &prior, wavelengths);
        if !light.is_zero() && self.competes_from(scene, hit, shading) {
            return self.beside_subpaths_of_sample(scene, hit, &sample, &value, light);
        }
        self.tell_of_light(scene, &sample, light);
        light
    }

    /// What a light sample brings to a surface from which light subpaths go on in nearly single directions,
    /// weighed against these.
    #[inline(never)]
    fn beside_subpaths_of_sample(
        &mut self,
        scene: &Scene,
        hit: &Intersection,
        sample: &LightSample<C>,
        value: &Evaluation<C>,
        light: Sampled<C>,
    ) -> Sampled<C> {
        let mut weight = 1.0;
        let mut shared = None;
        if let (Some(caustics), Density::PerSolidAngle(density)) = (scene.caustics(), sample.density) {
            let by_scattering = scattering_weight(
                scene,
                || self.ratio.sum() * density,
                || (self.ratio * value.density).sum(),
            );
            let ratio = || {
                let ray = hit.point.ray(sample.shadow_ray.direction);
                caustics::factor_along(scene, caustics, &ray, self.time, &self.media) * by_scattering.sqrt()
            };
            shared = self.weigh_beside_caustics(scene, caustics, &mut weight, ratio);
        }
        let light = light * weight;
        self.tell_of_light(scene, sample, light);
        self.contest(light, shared)
    }

    /// A light sample from the place at which a camera ray begins, where that measures irradiance: as if the
    /// sensor had scattered the light into the ray. What the ray itself meets is weighed against it.
    pub(super) fn light_on_sensor(
        &mut self,
        scene: &Scene,
        lit: &LitPoint,
        direction: Vec3,
        wavelengths: &Wavelengths<C>,
        stream: &Stream,
    ) -> Sampled<C> {
        // A sensor does not see lights that are hidden from it.
        if scene.lights.is_empty() || scene.limits.hide_emitters {
            return Sampled::ZERO;
        }
        let from = Receiver { point: lit.point, facing: lit.facing };
        let density = lit.density(direction);
        if density > 0.0 {
            let prior_over_density = self.ratio.sum() / density;
            self.last = PreviousSample::Scattered { from, prior_over_density, by_scattering: self.ratio };
        }
        let [.., u, v] = stream.draw(Dimensions::Lens);
        let may_contribute = scene.limits.techniques != Techniques::Scattering;
        let sample = may_contribute.then(|| scene.lights.sample(&from, self.time, wavelengths, [u, v]));
        let Some(sample) = sample.flatten() else { return Sampled::ZERO };
        let density = Sampled::splat(lit.density(sample.shadow_ray.direction));
        let value = Evaluation { f_cos: density, density };
        let prior = Prior { segments: 1, ..self.prior(0.0) };
        let light = self.light_from(scene, &sample, &value, &self.media.here, &prior, wavelengths);
        self.tell_of_light(scene, &sample, light);
        light
    }

    /// What a light sample at the place that the path has come to is weighed by.
    pub(super) fn prior(&self, by_aim: f64) -> Prior<C> {
        Prior { throughput: self.throughput, ratio: self.ratio, by_aim, segments: self.depth + 2 }
    }

    /// What a light sample brings to a place that scatters it, through what is between. `media`: those that
    /// the shadow ray begins in.
    #[inline(always)]
    pub(super) fn light_from(
        &self,
        scene: &Scene,
        sample: &LightSample<C>,
        value: &Evaluation<C>,
        media: &MediumStack,
        prior: &Prior<C>,
        wavelengths: &Wavelengths<C>,
    ) -> Sampled<C> {
        let Passage { transmittance, flown } = scene.passage(
            &sample.shadow_ray,
            self.time,
            media,
            wavelengths,
            crossings(scene, prior.segments, sample.density),
        );
        if transmittance.is_zero() {
            return Sampled::ZERO;
        }
        let Prior { throughput, ratio, by_aim, .. } = *prior;
        let weight = light_sample_weight(scene, sample.density, ratio.sum() + by_aim, || {
            (ratio * value.density * flown).sum()
        });
        throughput * value.f_cos * sample.radiance * weight * transmittance
    }

    /// Light that the path has found, as it is.
    #[inline(always)]
    pub(super) fn found(&self, light: Sampled<C>) -> Sampled<C> {
        if !light.is_zero() {
            self.seen.tell(self.vertex, || Step::Found { contribution: list(light * self.branch_weight) });
        }
        light
    }

    /// A light sample for a surface that scatters. `None` past the last segment, and where no light can
    /// contribute.
    #[inline(always)]
    fn light_sample(
        &self,
        scene: &Scene,
        hit: &Intersection,
        shading: &Shading<C>,
        wavelengths: &Wavelengths<C>,
        stream: &Stream,
    ) -> Option<LightSample<C>> {
        let may_contribute = !scene.lights.is_empty() && scene.limits.techniques != Techniques::Scattering;
        if self.is_last(scene) || !may_contribute {
            return None;
        }
        let [u, v, ..] = stream.draw(Dimensions::Light(self.vertex));
        scene.lights.sample(&receiver(hit, shading), self.time, wavelengths, [u, v])
    }
}

/// How many surfaces a light sample may pass by null transmission, at most. `segments`: those of the path
/// with its own.
pub(super) fn crossings(scene: &Scene, segments: u32, density: Density) -> u32 {
    if !scene.features().transparent_shadows {
        0
    } else if !scene.limits.null_is_a_segment {
        u32::MAX
    } else if density == Density::Discrete {
        // Mitsuba's `path` never finds such a light behind a surface, and no scattered ray meets it.
        0
    } else {
        scene.limits.max_depth.saturating_sub(segments)
    }
}

/// What is around a shadow ray that leaves a surface. `media`: what is around the ray that met it.
pub(super) fn media_beyond<'a>(
    scene: &Scene,
    media: &'a Media,
    ray: &Ray,
    hit: &Intersection,
    shadow_ray: &Ray,
) -> Cow<'a, MediumStack> {
    let toward_light = shadow_ray.direction;
    let beyond = ray.direction.dot(hit.point.normal) * toward_light.dot(hit.point.normal) > 0.0;
    if !beyond || !scene.features().medium_stack {
        return Cow::Borrowed(&media.here);
    }
    let mut media = media.clone();
    scene.pass_through(hit, toward_light, &mut media);
    Cow::Owned(media.here)
}

/// A surface as lights are chosen for it.
pub(super) fn receiver<const C: usize>(hit: &Intersection, shading: &Shading<C>) -> Receiver {
    Receiver { point: hit.point, facing: shading.receiving_side() }
}
