//! Paths through media that scatter.
//!
//! The free flight is one more choice that the hero makes: a path keeps for each wavelength j with what
//! density pⱼ(X) it would have flown as far, beside what [`super::path`] keeps of directions. So a
//! contribution has the weight Σᵢ fᵢ(X) / Σⱼ pⱼ(X), which is bounded where media are chromatic, too (Wilkie
//! et al., "Hero Wavelength Spectral Sampling", EGSR 2014; Miller, Georgiev, Jarosz, "A null-scattering path
//! integral formulation of light transport", ACM TOG 38(4), 2019). Phase functions that differ by wavelength
//! are one more such choice.
//!
//! A light sample passes media with their transmittance, and surfaces with null transmission. The same
//! light is found by scattering only if the path flies through all of that: the probability counts in the
//! weight of the two.

use super::observe::{Observe, Step, axes, list};
use super::path::{Path, PreviousSample, light_sample_weight};
use crate::bsdf::Evaluation;
use crate::geometry::{Ray, SurfacePoint, Vec3};
use crate::light::{LightSample, Receiver};
use crate::medium::MediumStack;
use crate::sampling::{Dimensions, Stream};
use crate::scene::{Collision, Event, FlightPlan, Passage, PathEnd, Scene};
use crate::spectrum::{Sampled, Wavelengths};

impl<const C: usize, O: Observe> Path<C, O> {
    /// [`Self::follow`] where media scatter.
    #[inline(never)]
    pub(super) fn follow_through_media(
        &mut self,
        scene: &Scene,
        mut ray: Ray,
        wavelengths: &Wavelengths<C>,
        stream: &Stream,
    ) -> Sampled<C> {
        let mut arriving = Sampled::ZERO;
        loop {
            let next = match self.fly(scene, &ray, wavelengths, stream, &mut arriving) {
                Event::Nothing => {
                    self.tell_of_escape(scene, &ray);
                    arriving += self.found(self.escaped(scene, &ray, wavelengths));
                    self.end(scene, PathEnd::Escaped);
                    None
                }
                Event::Medium(collision) => {
                    self.collide(scene, &ray, &collision, wavelengths, stream, &mut arriving)
                }
                Event::Surface(hit) => {
                    self.tell_of_surface(scene, &ray, &hit);
                    let light = self.emitted(scene, &ray, &hit, wavelengths);
                    arriving += self.found(light);
                    let shading = self.shade(scene, &ray, &hit, wavelengths, stream);
                    shading.and_then(|shading| {
                        self.go_on(scene, &ray, &hit, &shading, wavelengths, stream, &mut arriving)
                    })
                }
            };
            match next {
                Some(next) => ray = next,
                None => return arriving,
            }
        }
    }

    /// To the next surface or to where a medium ends the flight, with the light of the media on the way.
    fn fly<'a>(
        &mut self,
        scene: &'a Scene,
        ray: &Ray,
        wavelengths: &Wavelengths<C>,
        stream: &Stream,
        arriving: &mut Sampled<C>,
    ) -> Event<'a> {
        let [u, place, ..] = stream.draw(Dimensions::Flight(self.vertex));
        let plan = FlightPlan { target: -u.ln(), prior: self.ratio, place };
        let (event, flight) = scene.fly(ray, self.time, self.ray_kind(), &plan, &mut self.media, wavelengths);
        *arriving += self.found(self.throughput * flight.emitted);
        self.throughput *= flight.carried;
        self.ratio *= flight.ratio;
        if let PreviousSample::Scattered { by_scattering, .. } = &mut self.last {
            *by_scattering *= flight.flown;
        }
        event
    }

    /// Light that a medium scatters straight from a light, and on by scattering. `None` where the path ends.
    fn collide(
        &mut self,
        scene: &Scene,
        ray: &Ray,
        collision: &Collision,
        wavelengths: &Wavelengths<C>,
        stream: &Stream,
        arriving: &mut Sampled<C>,
    ) -> Option<Ray> {
        self.alpha_hit = true;
        self.camera_visible = false;
        let Collision { position, scattering } = *collision;
        self.seen().tell(self.vertex, || Step::Medium {
            place: axes(scene.in_file(position)),
            distance: (position - ray.origin).length(),
            medium: scene.medium_number(&self.media.here),
            throughput: list(self.throughput),
            ratio: list(self.ratio),
        });
        self.throughput *= scattering.albedo(position, &wavelengths.nm);
        if self.is_last(scene) || self.throughput.is_zero() {
            let absorbed = self.throughput.is_zero();
            self.end(scene, if absorbed { PathEnd::Absorbed } else { PathEnd::MaxDepth });
            return None;
        }
        // No surface that a ray would have to leave.
        let point = SurfacePoint { position, normal: -ray.direction, error: 0.0 };
        let from = Receiver { point, facing: Vec3::ZERO };
        if !scene.lights.is_empty() {
            let [u, v, ..] = stream.draw(Dimensions::Light(self.vertex));
            if let Some(sample) = scene.lights.sample(&from, self.time, wavelengths, [u, v]) {
                let goes = sample.shadow_ray.direction;
                let value = scattering.phase.evaluate(ray.direction, goes, position, &wavelengths.nm);
                let value = Evaluation { f_cos: value, density: value };
                *arriving += self.light_through_media(scene, &sample, &value, &self.media.here, wavelengths);
            }
        }
        let [u, v, choice, survival] = stream.draw(Dimensions::Scattering(self.vertex));
        let sample = scattering.phase.sample(ray.direction, position, &wavelengths.nm, [u, v, choice]);
        let hero = sample.value.hero();
        let prior_over_density = self.ratio.sum() / hero;
        // The density with which a wavelength goes a way is what it is scattered with.
        let over_hero = sample.value.map(|value| value / hero);
        self.throughput *= over_hero;
        self.ratio *= over_hero;
        self.last = PreviousSample::Scattered { from, prior_over_density, by_scattering: self.ratio };
        self.depth += 1;
        self.vertex += 1;
        self.seen().tell(self.vertex - 1, || Step::Scatter {
            direction: axes(sample.direction),
            transmitted: false,
            density: Some(hero),
            throughput: list(self.throughput),
            ratio: list(self.ratio),
        });
        let kept = self.survival(scene);
        if survival >= kept {
            self.end_before_next(scene, kept);
            return None;
        }
        self.tell_of_survival(kept);
        self.throughput /= kept;
        Some(Ray::new(position, sample.direction))
    }

    /// What a light sample brings to a place that scatters it, through what is between.
    pub(super) fn light_through_media(
        &self,
        scene: &Scene,
        sample: &LightSample<C>,
        value: &Evaluation<C>,
        media: &MediumStack,
        wavelengths: &Wavelengths<C>,
    ) -> Sampled<C> {
        let Passage { transmittance, flown } =
            scene.passage(&sample.shadow_ray, self.time, media, wavelengths);
        if transmittance.is_zero() {
            self.tell_of_light(scene, sample, Sampled::ZERO);
            return Sampled::ZERO;
        }
        let weight = light_sample_weight(scene, sample.density, self.ratio.sum(), || {
            (self.ratio * value.density * flown).sum()
        });
        let light = self.throughput * value.f_cos * sample.radiance * weight * transmittance;
        self.tell_of_light(scene, sample, light);
        light
    }
}
