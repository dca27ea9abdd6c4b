//! Path tracing with next-event estimation.
//!
//! Estimated is, for each wavelength λ of the path, the radiance along the camera ray,
//!
//! L(λ) = Σₙ ∫ Le(xₙ, λ) · Πᵢ fᵢ(λ) |cos θᵢ| exp(−αᵢ(λ) sᵢ) dω₁…dωₙ₋₁.
//!
//! The same path X could have been made by any of the C wavelengths as the hero, with density pⱼ(X), by scattering
//! alone (technique u) or with its last direction chosen toward a light (technique l). A contribution is weighed
//! over all of them:
//!
//! ⟨L(λᵢ)⟩ = Le · fᵢ(X) / Σⱼ pⱼ(X) of its own technique · w,   w = P² / (Pᵤ² + Pₗ²),   P = Σⱼ pⱼ(X),
//!
//! the balance heuristic over wavelengths and the power heuristic over the two techniques. A path keeps fᵢ and pⱼ relative
//! to the hero's density, so with one wavelength nothing of this remains.

use super::caustics::{self, FirstSurface};
use super::{Seen, Techniques};
use crate::bsdf::{Density, Scatter};
use crate::geometry::Ray;
use crate::light::Receiver;
use crate::material::Shading;
use crate::medium::{Media, MediumStack};
use crate::sampling::{Dimensions, Stream};
use crate::scene::{Intersection, Scene};
use crate::spectrum::{Sampled, Wavelengths};
use smallvec::{SmallVec, smallvec};
use std::ops::Range;

/// Into so many a path divides at the first matt surface that it comes to by way of smooth ones, in a scene with light paths. What smooth
/// bodies focus there no light path brings to the camera, and chance finds it seldom but bright; what came before is a small part
/// of the work.
const BRANCHES: u32 = 4;

/// Where a path has met smooth surfaces alone, and both ways on from one of them may bring at least this part of the sample's value, it
/// divides into both, in the same scenes. At the rim of a glass body, and in what it mirrors of a lamp, chance between the two
/// is most of the noise. Less than what glass reflects that is seen from the front, 4 %.
const WORTH_FOLLOWING: f64 = 1.0 / 32.0;

/// What has become of a path so far.
#[derive(Clone)]
struct Path<const C: usize> {
    /// When all of it happens.
    time: f64,
    /// Segments behind the surface that is next. One that the path passes as if there were none may leave it as it is.
    depth: u32,
    /// Surfaces met.
    vertex: u32,
    /// fᵢ(X) / p₀(X): what each wavelength carries over the hero's density.
    throughput: Sampled<C>,
    /// pⱼ(X) / p₀(X). The hero's is 1; a companion's is 0 once it has gone another way.
    ratio: Sampled<C>,
    /// How the last ray was chosen: the weight of light found by it asks for that.
    last: LastChoice,
    media: Media,
    /// Product of the factors by which refraction compressed radiance: no loss, so no reason to end a path.
    compression: f64,
    /// Where light paths that come this way reach what the camera sees; `None` where none do.
    beside_light_paths: Option<FirstSurface>,
    /// Whether it may divide yet.
    divisible: bool,
    /// Its part of the sample: the branches that led to it have shares, and this is their product.
    share: f64,
    /// Whether nothing has been met that alpha counts: such rays do not see what is hidden from the camera.
    straight: bool,
    /// Whether anything has that alpha counts.
    met: bool,
}

/// How a ray came to be.
#[derive(Clone)]
enum LastChoice {
    /// By the camera.
    Camera,
    /// By a discrete lobe: no light sample could have found it.
    Discrete,
    /// With a density, from a surface where lights were sampled too.
    Scattered {
        from: Receiver,
        /// Σⱼ pⱼ / p₀ before the scattering, over the hero's density of the direction, sr.
        prior_over_density: f64,
        /// Σⱼ pⱼ / p₀ after it. Surfaces that are passed as if there were none don't count here: the light sample that
        /// is weighed against doesn't choose at them either.
        by_scattering: f64,
    },
}

/// See [`super::radiance`].
pub fn radiance<const C: usize>(
    scene: &Scene,
    ray: Ray,
    time: f64,
    wavelengths: &Wavelengths<C>,
    stream: &Stream,
) -> Seen<C> {
    let mut path = Path::<C>::from_camera(scene, &ray, time);
    let radiance = path.follow(scene, ray, wavelengths, stream);
    Seen { radiance, met: path.met }
}

impl<const C: usize> Path<C> {
    fn from_camera(scene: &Scene, ray: &Ray, time: f64) -> Self {
        Self {
            time,
            depth: 0,
            vertex: 0,
            throughput: Sampled::ONE,
            ratio: Sampled::ONE,
            last: LastChoice::Camera,
            media: scene.media_at_sensor(ray, time),
            compression: 1.0,
            beside_light_paths: None,
            divisible: scene.needs().light_paths,
            share: 1.0,
            straight: true,
            met: scene.limits.sky_covers(scene),
        }
    }

    /// Goes on along a ray to the path's end. Light that comes along it, weighed by all that was before.
    fn follow(
        &mut self,
        scene: &Scene,
        mut ray: Ray,
        wavelengths: &Wavelengths<C>,
        stream: &Stream,
    ) -> Sampled<C> {
        let mut arriving = Sampled::ZERO;
        loop {
            // By reference: to move it costs as much as a shadow ray.
            let Some(hit) = &self.advance(scene, &ray, wavelengths) else {
                arriving += self.escaped(scene, &ray, wavelengths);
                return arriving;
            };
            arriving += self.emitted(scene, &ray, hit, wavelengths);
            let last = self.is_last(scene);
            // Past the last segment only alpha asks whether this surface is in the way, and light that may pass it as if there
            // were none: a light sample passes it too.
            if last && !scene.needs().clear_shadows && (self.met || !scene.film.alpha) {
                return arriving;
            }
            let light_values = Dimensions::Light(self.vertex);
            let choice = if scene.needs().choices { stream.draw(light_values)[3] } else { 0.0 };
            let shading = scene.shade(hit, -ray.direction, &self.media, wavelengths, choice);
            if !last && !shading.bsdf.is_discrete() && !scene.lights.is_empty() {
                let values = stream.draw(light_values);
                arriving += self.direct_light(scene, &ray, hit, &shading, wavelengths, values);
            }
            if self.divisible
                && let Some(ends) = self.division(&shading)
            {
                return arriving + self.follow_branches(scene, hit, &shading, wavelengths, stream, &ends);
            }
            match self.scatter(scene, hit, &shading, stream, 0.0..1.0) {
                Some(next) => ray = next,
                None => return arriving,
            }
        }
    }

    /// Whether the path has as many segments as it may.
    fn is_last(&self, scene: &Scene) -> bool {
        self.depth + 1 >= scene.limits.max_depth
    }

    /// Where the path divides, how: the values that choose a lobe are dealt to the branches, to each those from where the branch before ends
    /// to where it does itself. So nothing is counted twice, and the branches' shares sum to 1.
    fn division(&self, shading: &Shading<C>) -> Option<SmallVec<[f64; BRANCHES as usize]>> {
        if let Some(reflection) = shading.chance_of_reflection() {
            let lesser = reflection.min(1.0 - reflection) * self.share * self.strength();
            return (lesser > WORTH_FOLLOWING).then(|| smallvec![reflection, 1.0]);
        }
        // The first matt surface, and not the first surface.
        (self.vertex > 0 && !shading.bsdf.is_discrete() && !shading.bsdf.transmits())
            .then(|| (1..=BRANCHES).map(|branch| f64::from(branch) / f64::from(BRANCHES)).collect())
    }

    /// What the branches find together, each weighed by its share. Apart, so that the paths of other scenes stay small.
    #[inline(never)]
    fn follow_branches(
        &mut self,
        scene: &Scene,
        hit: &Intersection,
        shading: &Shading<C>,
        wavelengths: &Wavelengths<C>,
        stream: &Stream,
        ends: &[f64],
    ) -> Sampled<C> {
        // From what is matt light paths lead on.
        self.divisible &= shading.bsdf.is_discrete();
        // No surface that is passed as if there were none divides a path.
        self.met = true;
        let mut arriving = Sampled::ZERO;
        let mut start = 0.0;
        for (branch, &end) in (0..).zip(ends) {
            let (mut path, stream) = (self.clone(), stream.branch(branch));
            let share = end - start;
            path.share *= share;
            if let Some(ray) = path.scatter(scene, hit, shading, &stream, start..end) {
                // The share is no reason to end it by roulette: it divided to be followed.
                arriving += path.follow(scene, ray, wavelengths, &stream) * share;
            }
            start = end;
        }
        arriving
    }

    /// On from a surface, with a lobe that one of these values chooses. `None` where the path ends.
    #[inline(always)]
    fn scatter(
        &mut self,
        scene: &Scene,
        hit: &Intersection,
        shading: &Shading<C>,
        stream: &Stream,
        lobes: Range<f64>,
    ) -> Option<Ray> {
        let [u, v, lobe, survival] = stream.draw(Dimensions::Scattering(self.vertex));
        let scatter = shading.sample(lobes.start + (lobes.end - lobes.start) * lobe, [u, v]);
        let passes =
            scatter.as_ref().is_some_and(|scatter| scatter.transmitted) && shading.bsdf.passes_straight();
        self.met |= scene.limits.surface_covers(passes);
        let goes_on = !self.is_last(scene) || (passes && !scene.limits.passing_counts);
        let scatter = scatter.filter(|_| goes_on)?;
        let prior = self.ratio.sum();
        self.throughput *= scatter.weight;
        self.ratio *= scatter.ratio;
        self.straight &= !scene.limits.surface_covers(passes);
        if !passes || scene.limits.passing_counts {
            self.last = match scatter.density {
                Density::Discrete => LastChoice::Discrete,
                Density::PerSolidAngle(density) => {
                    self.divisible = false;
                    let by_scattering = self.ratio.sum();
                    let prior_over_density = prior / density;
                    LastChoice::Scattered { from: receiver(hit, shading), prior_over_density, by_scattering }
                }
            };
            self.depth += 1;
        }
        if scene.needs().light_paths {
            self.meet_light_paths(scene, hit, shading, &scatter);
        }
        if scatter.transmitted {
            self.refract(shading);
            scene.pass_through(hit, scatter.toward_light, &mut self.media);
        }
        self.vertex += 1;
        self.survives(scene, survival).then(|| hit.point.ray(scatter.toward_light))
    }

    /// To the next surface, attenuated by the media on the way (Beer and Lambert).
    fn advance(&mut self, scene: &Scene, ray: &Ray, wavelengths: &Wavelengths<C>) -> Option<Intersection> {
        let Self { throughput, media, time, depth, .. } = self;
        scene.intersect(ray, *time, *depth == 0, media, |media: &MediumStack, distance| {
            if let Some(transmittance) = scene.transmittance(media, distance, wavelengths) {
                *throughput *= transmittance;
            }
        })
    }

    /// Light from beyond the scene, weighed against having been sampled.
    fn escaped(&self, scene: &Scene, ray: &Ray, wavelengths: &Wavelengths<C>) -> Sampled<C> {
        let hidden = self.straight && scene.limits.hide_emitters;
        let Some(environment) = scene.lights.environment().filter(|_| !hidden) else { return Sampled::ZERO };
        let weight = self.weight_beside_lights(scene, |from| {
            scene.lights.environment_density(from, ray.direction, self.time, wavelengths)
        });
        if weight == 0.0 {
            return Sampled::ZERO;
        }
        self.throughput * environment.radiance(ray.direction, &wavelengths.nm) * (weight / self.ratio.sum())
    }

    /// The weight of light that scattering found, if light samples from the last vertex found it with a density, per
    /// steradian.
    fn weight_beside_lights(&self, scene: &Scene, density: impl Fn(&Receiver) -> f64) -> f64 {
        match (&self.last, scene.limits.techniques) {
            (LastChoice::Camera, _) | (_, Techniques::Scattering) => 1.0,
            (LastChoice::Discrete, Techniques::Both) => 1.0,
            (LastChoice::Discrete, Techniques::LightSamples) => 0.0,
            (LastChoice::Scattered { from, prior_over_density, by_scattering }, Techniques::Both) => {
                power_heuristic(*by_scattering, prior_over_density * density(from))
            }
            // What light samples leave to scattering, such as a constant environment, is found by it all the same.
            (LastChoice::Scattered { from, .. }, Techniques::LightSamples) => {
                if density(from) > 0.0 {
                    0.0
                } else {
                    1.0
                }
            }
        }
    }

    /// Light that the surface just met emits toward the path, weighed against having been sampled.
    fn emitted(
        &self,
        scene: &Scene,
        ray: &Ray,
        hit: &Intersection,
        wavelengths: &Wavelengths<C>,
    ) -> Sampled<C> {
        let Some(met) = hit.on_light() else { return Sampled::ZERO };
        if ray.direction.dot(hit.point.normal) >= 0.0 {
            return Sampled::ZERO;
        }
        let mut weight =
            self.weight_beside_lights(scene, |from| scene.lights.density(&met, from, self.time, wavelengths));
        if let (Some(first), LastChoice::Discrete, Some(caustics)) =
            (&self.beside_light_paths, &self.last, scene.caustics())
        {
            let from_light = caustics.from_light(met.light, &hit.point, -ray.direction);
            let from_camera = caustics.from_camera(scene, first, self.time);
            weight *= power_heuristic(1.0, from_light * from_camera);
        }
        if weight == 0.0 {
            return Sampled::ZERO;
        }
        let radiance = scene.lights.radiance(met.light, &scene.texture_point(hit), &wavelengths.nm);
        self.throughput * radiance * (weight / self.ratio.sum())
    }

    /// Light that reaches the surface straight from one light, chosen and sampled for this place.
    fn direct_light(
        &self,
        scene: &Scene,
        ray: &Ray,
        hit: &Intersection,
        shading: &Shading<C>,
        wavelengths: &Wavelengths<C>,
        [u, v, ..]: [f64; 4],
    ) -> Sampled<C> {
        let receiver = receiver(hit, shading);
        let Some(sample) = scene.lights.sample(&receiver, self.time, wavelengths, [u, v]) else {
            return Sampled::ZERO;
        };
        let toward_light = sample.shadow_ray.direction;
        let value = shading.evaluate(toward_light);
        if value.f_cos.is_zero() {
            return Sampled::ZERO;
        }
        let weight = match (sample.density, scene.limits.techniques) {
            (_, Techniques::Scattering) => 0.0,
            (Density::Discrete, _) => 1.0 / self.ratio.sum(),
            (Density::PerSolidAngle(density), Techniques::LightSamples) => 1.0 / (self.ratio.sum() * density),
            (Density::PerSolidAngle(density), Techniques::Both) => {
                let by_light = self.ratio.sum() * density;
                let by_scattering = (self.ratio * value.density).sum();
                power_heuristic(by_light, by_scattering) / by_light
            }
        };
        if weight == 0.0 {
            return Sampled::ZERO;
        }
        let beyond = ray.direction.dot(hit.point.normal) * toward_light.dot(hit.point.normal) > 0.0;
        let passed;
        let media = if beyond && scene.needs().medium_stack {
            let mut media = self.media;
            scene.pass_through(hit, toward_light, &mut media);
            passed = media.here;
            &passed
        } else {
            &self.media.here
        };
        let visibility = scene.visibility(&sample.shadow_ray, self.time, media, wavelengths);
        self.throughput * value.f_cos * sample.radiance * weight * visibility
    }

    /// Keeps account of whether light paths may come the way that a surface, the first or a later one, has just sent this one.
    fn meet_light_paths(
        &mut self,
        scene: &Scene,
        hit: &Intersection,
        shading: &Shading<C>,
        scatter: &Scatter<C>,
    ) {
        if !caustics::may_follow(scene, hit, &shading.bsdf, scatter.density) {
            self.beside_light_paths = None;
        } else if let (0, Density::PerSolidAngle(hero)) = (self.vertex, scatter.density) {
            let density = hero * scatter.ratio.sum() / C as f64;
            self.beside_light_paths =
                Some(FirstSurface { point: hit.point, leaves: scatter.toward_light, density });
        }
    }

    /// Refraction compresses radiance.
    fn refract(&mut self, shading: &Shading<C>) {
        if let Some(far_over_near) = shading.index_beyond() {
            self.compression /= far_over_near * far_over_near;
        }
    }

    /// The most that the path can still bring, but for its share. The measure is the same whichever wavelength is the hero.
    fn strength(&self) -> f64 {
        let alive = self.ratio.0.iter().filter(|&&ratio| ratio > 0.0).count() as f64;
        alive * self.throughput.max() / self.ratio.sum() / self.compression
    }

    /// Russian roulette on what the path can still bring. All of the path's densities change by one factor and their ratios stay.
    fn survives(&mut self, scene: &Scene, u: f64) -> bool {
        if self.throughput.is_zero() {
            return false;
        }
        if self.depth < scene.limits.rr_depth {
            return true;
        }
        let survival = self.strength().min(late_survival(self.depth));
        if u >= survival {
            return false;
        }
        self.throughput /= survival;
        true
    }
}

/// A surface as lights are chosen for it.
fn receiver<const C: usize>(hit: &Intersection, shading: &Shading<C>) -> Receiver {
    Receiver { point: hit.point, facing: shading.receiving_side() }
}

/// Most probability with which a path of so many segments goes on: between perfect mirrors nothing is ever lost.
///
/// The share of the paths that are still under way falls with the square of their length, so that their mean length is
/// finite. Were it to fall as a power, the weights of those that are left would grow as one, and light that leaves a body only after
/// many reflections would be estimated with infinite variance.
pub(super) fn late_survival(depth: u32) -> f64 {
    /// Segments after which a path without loss may end too.
    const LATE: u32 = 64;
    if depth <= LATE {
        return 1.0;
    }
    let kept = 1.0 - 1.0 / f64::from(depth);
    kept * kept
}

/// Weight of a technique of density `own` beside one of density `other`, with exponent 2 (Veach, *Robust Monte Carlo
/// Methods for Light Transport Simulation*, 1997, sec. 9.2.2).
pub(super) fn power_heuristic(own: f64, other: f64) -> f64 {
    if own == 0.0 {
        return 0.0;
    }
    let ratio = other / own;
    1.0 / (1.0 + ratio * ratio)
}
