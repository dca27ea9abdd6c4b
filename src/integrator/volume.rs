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
//!
//! Near a lamp in fog most of the light is scattered where flights seldom end. So a ray that begins in a
//! homogeneous medium and passes lamps takes one light sample more, from a place at a distance that is chosen
//! by them ([`crate::light::Aim`]). With the density P_a(t) of that distance, and P_f(t) = Σⱼ pⱼ(t) of the
//! flight, a light sample of either has the density (P_f + P_a) p_light: the balance heuristic over the two
//! ways to the place, beside the power heuristic over light samples and scattering.

use super::contributions::Prior;
use super::observe::{Observe, Step, axes, list};
use super::path::{Path, PreviousSample, ScatteredBy};
use crate::bsdf::Evaluation;
use crate::geometry::{Ray, SurfacePoint, Vec3};
use crate::light::{Aim, Receiver};
use crate::medium::{Extinction, Medium, MediumStack, Scattering};
use crate::sampling::{Density, Dimensions, Stream};
use crate::scene::{Collision, Event, FlightPlan, PathEnd, Scene, Techniques};
use crate::spectrum::{Sampled, Wavelengths};

/// A ray that passes lamps within a medium.
struct Aimed<'a> {
    lamps: Aim,
    medium: &'a Medium,
    scattering: &'a Scattering,
    around: MediumStack,
}

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
            let (event, by_aim) = self.fly(scene, &ray, wavelengths, stream, &mut arriving);
            // By reference: to move what is large costs as much as a shadow ray.
            let next = match &event {
                Event::Nothing => {
                    self.tell_of_escape(scene, &ray);
                    let light = self.escaped(scene, &ray, wavelengths);
                    arriving += self.found(light);
                    self.end(scene, PathEnd::Escaped);
                    None
                }
                Event::Medium(collision) => {
                    self.collide(scene, &ray, collision, by_aim, wavelengths, stream, &mut arriving)
                }
                Event::Surface(hit) => {
                    self.tell_of_surface(scene, &ray, hit, wavelengths, stream);
                    let light = self.emitted(scene, &ray, hit, wavelengths);
                    arriving += self.found(light);
                    let shading = self.shade(scene, &ray, hit, wavelengths, stream);
                    shading.and_then(|mut shading| {
                        arriving += self.mirrored(scene, hit, &mut shading, wavelengths, stream);
                        self.go_on(scene, &ray, hit, &shading, wavelengths, stream, &mut arriving)
                    })
                }
            };
            match next {
                Some(next) => ray = next,
                None => return arriving,
            }
        }
    }

    /// To the next surface or to where a medium ends the flight, with the light of the media on the way, and
    /// what they scatter into it near lamps. See [`Prior::by_aim`] for the number.
    #[inline(always)]
    fn fly<'a>(
        &mut self,
        scene: &'a Scene,
        ray: &Ray,
        wavelengths: &Wavelengths<C>,
        stream: &Stream,
        arriving: &mut Sampled<C>,
    ) -> (Event<'a>, f64) {
        let [u, place, aimed_place, aimed_light] = stream.draw(Dimensions::Flight(self.vertex));
        let aimed = self.aim(scene, ray, wavelengths);
        let plan = FlightPlan { target: -u.ln(), prior: self.ratio, place, looks_ahead: aimed.is_some() };
        let (event, flight) = scene.fly(ray, self.time, self.ray_kind(), &plan, &mut self.media, wavelengths);
        *arriving += self.found(self.throughput * flight.emitted);
        let mut by_aim = 0.0;
        if let Some(Aimed { lamps, medium, scattering, around }) = aimed
            && let Some(lamps) = lamps.within(flight.first)
        {
            let t = lamps.sample(aimed_place);
            let u = [aimed_light, stream.draw(Dimensions::Light(self.vertex))[2]];
            let nearby = Aimed { lamps, medium, scattering, around };
            *arriving += self.found(self.scattered_at(scene, ray, &nearby, t, u, wavelengths));
            if let Some([distance, density]) = flight.ended {
                by_aim = self.ratio.sum() * nearby.lamps.density(distance) / density;
            }
        }
        self.throughput *= flight.carried;
        self.ratio *= flight.ratio;
        if let PreviousSample::Scattered { by_scattering, .. } = &mut self.last {
            *by_scattering *= flight.flown;
        }
        (event, by_aim)
    }

    /// The lamps that a ray passes, if it begins in a medium that is the same everywhere and scatters, and
    /// they are not much farther away than light comes there.
    fn aim<'a>(&self, scene: &'a Scene, ray: &Ray, wavelengths: &Wavelengths<C>) -> Option<Aimed<'a>> {
        /// Mean free paths within which lamps count: farther on little light comes back, and where a ray
        /// keeps off a lamp by half of one, it is as bright wherever flights end.
        const REACH: f64 = 2.0;
        let limits = &scene.limits;
        if !limits.aims_at_lamps || limits.techniques == Techniques::Scattering || self.is_last(scene) {
            return None;
        }
        let medium = scene.medium(&self.media.here)?;
        let (Extinction::Homogeneous(_), Some(scattering)) = (&medium.extinction, &medium.scattering) else {
            return None;
        };
        // What hides light samples of one kind hides those of the other.
        if scattering.light_sample_probability < 1.0 {
            return None;
        }
        let extinction = medium.extinction_at(ray.origin, ray.direction, &wavelengths.nm).sum() / C as f64;
        let lamps = scene.lights.aim(ray, self.time, wavelengths, REACH / extinction)?;
        Some(Aimed { lamps, medium, scattering, around: self.media.here.clone() })
    }

    /// What a light sample brings along a ray from a place that was chosen near lamps.
    fn scattered_at(
        &self,
        scene: &Scene,
        ray: &Ray,
        aimed: &Aimed,
        t: f64,
        u: [f64; 2],
        wavelengths: &Wavelengths<C>,
    ) -> Sampled<C> {
        let nm = &wavelengths.nm;
        let Aimed { lamps, medium, scattering, around } = aimed;
        let position = ray.at(t);
        let depths = medium.optical_depths(&Ray { t_max: t, ..*ray }, nm);
        let flown = medium.extinction_at(position, ray.direction, nm) * (-depths).exp();
        let prior = Prior {
            throughput: self.throughput * flown * scattering.albedo(position, nm),
            ratio: self.ratio * flown,
            ..self.prior(self.ratio.sum() * lamps.density(t))
        };
        if prior.throughput.is_zero() {
            return Sampled::ZERO;
        }
        let from = free_place(position, ray);
        let Some(sample) = scene.lights.sample(&from, self.time, wavelengths, u) else {
            return Sampled::ZERO;
        };
        let value = scattering.phase.evaluate(ray.direction, sample.shadow_ray.direction, position, nm);
        let value = Evaluation { f_cos: value, density: value };
        self.light_from(scene, &sample, &value, around, &prior, wavelengths)
    }

    /// Light that a medium scatters straight from a light, and on by scattering. `None` where the path ends.
    #[expect(clippy::too_many_arguments, reason = "a step of the loop of a path")]
    fn collide(
        &mut self,
        scene: &Scene,
        ray: &Ray,
        collision: &Collision,
        by_aim: f64,
        wavelengths: &Wavelengths<C>,
        stream: &Stream,
        arriving: &mut Sampled<C>,
    ) -> Option<Ray> {
        self.alpha_hit = true;
        self.camera_visible = false;
        self.scattered_by = ScatteredBy::Any;
        let Collision { position, scattering } = *collision;
        self.seen.tell(self.vertex, || Step::Medium {
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
        let from = free_place(position, ray);
        let probability = scattering.light_sample_probability;
        if !scene.lights.is_empty() {
            let [u, v, choice, _] = stream.draw(Dimensions::Light(self.vertex));
            let sample = (choice < probability)
                .then(|| scene.lights.sample(&from, self.time, wavelengths, [u, v]))
                .flatten();
            if let Some(sample) = sample {
                let sample = sample.taken_with(probability);
                let goes = sample.shadow_ray.direction;
                let value = scattering.phase.evaluate(ray.direction, goes, position, &wavelengths.nm);
                let value = Evaluation { f_cos: value, density: value };
                let prior = self.prior(by_aim);
                let light = self.light_from(scene, &sample, &value, &self.media.here, &prior, wavelengths);
                self.tell_of_light(scene, &sample, light);
                *arriving += light;
            }
        }
        let [u, v, choice, survival] = stream.draw(Dimensions::Scattering(self.vertex));
        let sample = scattering.phase.sample(ray.direction, position, &wavelengths.nm, [u, v, choice]);
        let hero = sample.value.hero();
        let prior_over_density = probability * (self.ratio.sum() + by_aim) / hero;
        // The density with which a wavelength goes a way is what it is scattered with.
        let over_hero = sample.value.map(|value| value / hero);
        self.throughput *= over_hero;
        self.ratio *= over_hero;
        self.last = PreviousSample::Scattered { from, prior_over_density, by_scattering: self.ratio };
        self.depth += 1;
        self.vertex += 1;
        self.tell_of_scatter(sample.direction, false, Density::PerSolidAngle(hero));
        self.survives(scene, survival).then(|| Ray::new(position, sample.direction))
    }
}

/// A place between surfaces: there is none that a ray would have to leave.
fn free_place(position: Vec3, ray: &Ray) -> Receiver {
    let point = SurfacePoint { position, normal: -ray.direction, error: 0.0 };
    Receiver { point, facing: Vec3::ZERO }
}
