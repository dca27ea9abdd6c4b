//! Path tracing with next-event estimation.
//!
//! Estimated is, for each wavelength λ of the path, the radiance along the camera ray,
//!
//! L(λ) = Σₙ ∫ Le(xₙ, λ) · Πᵢ fᵢ(λ) |cos θᵢ| exp(−αᵢ(λ) sᵢ) dω₁…dωₙ₋₁.
//!
//! The same path X could have been made by any of the C wavelengths as the hero, with density pⱼ(X), by
//! scattering alone (technique u) or with its last direction chosen toward a light (technique l). A
//! contribution is weighed over all of them:
//!
//! ⟨L(λᵢ)⟩ = Le · fᵢ(X) / Σⱼ pⱼ(X) of its own technique · w,   w = P² / (Pᵤ² + Pₗ²),   P = Σⱼ pⱼ(X),
//!
//! the balance heuristic over wavelengths and the power heuristic over the two techniques. A path keeps fᵢ
//! and pⱼ relative to the hero's density, so with one wavelength nothing of this remains. [`super::volume`]
//! adds media that scatter.

use super::RadianceSample;
use super::caustics::{self, FirstSurface};
use super::contributions::receiver;
use super::observe::{Observe, Step, Unseen};
use super::weights::{late_survival, late_survival_in_media, roulette_survival, scattering_weight};
use crate::bsdf::Scatter;
use crate::camera::LitPoint;
use crate::geometry::Ray;
use crate::light::Receiver;
use crate::material::Shading;
use crate::medium::{Media, MediumStack};
use crate::sampling::{Density, Dimensions, Stream};
use crate::scene::{Intersection, PathEnd, RayKind, Scene, Techniques};
use crate::spectrum::{Sampled, Wavelengths};
use smallvec::SmallVec;
use std::ops::Range;

/// What has become of a path so far.
#[derive(Clone)]
pub(super) struct Path<const C: usize, O = Unseen> {
    /// When all of it happens.
    pub(super) time: f64,
    /// Number of segments before the next surface. Null transmission may not count.
    pub(super) depth: u32,
    /// Number of surface interactions and of scattering events in media.
    pub(super) vertex: u32,
    /// fᵢ(X) / p₀(X): what each wavelength carries over the hero's density.
    pub(super) throughput: Sampled<C>,
    /// pⱼ(X) / p₀(X). The hero's is 1; a companion's is 0 once it has gone another way.
    pub(super) ratio: Sampled<C>,
    /// How the last ray was sampled, which the weight of the light that it finds depends on.
    pub(super) last: PreviousSample<C>,
    pub(super) media: Media,
    /// Product of the factors by which refraction scales radiance. Russian roulette divides by it: that
    /// scaling is no loss, so no reason to end a path.
    eta_scale: f64,
    /// What light subpaths that come this way compete with.
    pub(super) beside_light_subpaths: Beside,
    /// Whether light subpaths may come from the last surface, too, though that scatters with a density.
    pub(super) competing: Competing,
    /// What the path has found while it is [`Beside::Shared`].
    pub(super) contested: SmallVec<[Contested<C>; 1]>,
    pub(super) scattered_by: ScatteredBy,
    /// Whether all surfaces that have scattered it have no other directions: it is all of its sample, or a
    /// branch at glass.
    pub(super) through_discrete: bool,
    /// Its weight in the sample: the product of the weights of the branches that led to it.
    pub(super) branch_weight: f64,
    /// Whether the camera sees along the path: it has met nothing that alpha counts. Such a ray does not see
    /// what is hidden from the camera.
    pub(super) camera_visible: bool,
    /// Whether the path has met anything that alpha counts.
    pub(super) alpha_hit: bool,
    /// The roulette throughput of a shared suffix at its beginning, where `throughput` is 1. 1 for others.
    pub(super) prior_throughput: f64,
    /// Whether it is the lesser part of its sample, so that roulette may end it however short it is.
    pub(super) is_lesser: bool,
    /// Who is told of its steps.
    pub(super) seen: O,
}

/// What light subpaths that come the same way are weighed against.
#[derive(Clone, Copy)]
pub(super) enum Beside {
    /// None come this way.
    Nothing,
    /// They reach the surface that the camera sees first.
    First(FirstSurface),
    /// They reach several surfaces that share this path. What it finds is kept apart: each surface weighs it
    /// by itself.
    Shared,
}

/// Whether light subpaths may come from a surface that scatters with a density.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Competing {
    /// It is not polished enough.
    No,
    Yes,
    /// They may, and several first surfaces share it: each scatters there with a density of its own.
    Shared,
}

/// Light that a path has found which several surfaces share, and that light subpaths compete for: each
/// surface weighs it by itself.
#[derive(Clone, Copy)]
pub(super) struct Contested<const C: usize> {
    pub light: Sampled<C>,
    /// The light's factor of the ratio of densities.
    pub from_light: f64,
    /// Per steradian, the density with which light samples find it from the surface that is shared, where
    /// that is [`Competing::Shared`]. 0 for all else.
    pub by_light: f64,
}

/// What has scattered a path so far, but for null transmission.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum ScatteredBy {
    Nothing,
    /// Surfaces, in single directions alone.
    Specular,
    /// Something with a density. Or the path is a branch that begins at a diffuse surface.
    Any,
}

/// How a ray came to be.
#[derive(Clone)]
pub(super) enum PreviousSample<const C: usize> {
    /// By the camera.
    Camera,
    /// By a discrete lobe: no light sample could have found it.
    Discrete,
    /// With a density, from a place where lights were sampled too.
    Scattered {
        from: Receiver,
        /// Σⱼ pⱼ / p₀ before the scattering, over the hero's density of the direction, sr.
        prior_over_density: f64,
        /// pⱼ / p₀ after it, times the probability of having passed the media on the way. Surfaces that are
        /// passed as if there were none don't count here: the light sample that is weighed against doesn't
        /// choose at them either.
        by_scattering: Sampled<C>,
    },
}

impl<const C: usize> PreviousSample<C> {
    /// The weight of light that scattering found, if light samples from the last vertex found it with a
    /// density, per steradian.
    pub(super) fn weight_beside_lights(&self, scene: &Scene, density: impl Fn(&Receiver) -> f64) -> f64 {
        match self {
            Self::Discrete if scene.limits.techniques == Techniques::LightSamples => 0.0,
            Self::Camera | Self::Discrete => 1.0,
            Self::Scattered { from, prior_over_density, by_scattering } => {
                scattering_weight(scene, || prior_over_density * density(from), || by_scattering.sum())
            }
        }
    }
}

/// See [`super::radiance`].
pub fn radiance<const C: usize>(
    scene: &Scene,
    ray: Ray,
    lit: Option<LitPoint>,
    time: f64,
    wavelengths: &Wavelengths<C>,
    stream: &Stream,
) -> RadianceSample<C> {
    observed_radiance(scene, ray, lit, time, wavelengths, stream, Unseen)
}

/// The same, with an observer of the path's steps.
#[inline(always)]
pub(super) fn observed_radiance<const C: usize, O: Observe>(
    scene: &Scene,
    ray: Ray,
    lit: Option<LitPoint>,
    time: f64,
    wavelengths: &Wavelengths<C>,
    stream: &Stream,
    seen: O,
) -> RadianceSample<C> {
    let mut path = Path::<C, O>::seen_by(seen, scene, &ray, time);
    let mut radiance = Sampled::ZERO;
    if let Some(lit) = lit {
        radiance += path.light_on_sensor(scene, &lit, ray.direction, wavelengths, stream);
    }
    radiance += path.follow(scene, ray, wavelengths, stream);
    RadianceSample { radiance, alpha_hit: path.alpha_hit }
}

/// A path that was one of several until now; see [`super::bundle`].
pub(super) struct Parted<const C: usize> {
    pub time: f64,
    pub depth: u32,
    pub throughput: Sampled<C>,
    pub ratio: Sampled<C>,
    pub last: PreviousSample<C>,
    pub media: Media,
    pub beside_light_subpaths: Beside,
    pub competing: Competing,
    pub prior_throughput: f64,
}

impl<const C: usize> Path<C> {
    /// All surfaces that it has met have scattered it with a density.
    pub(super) fn parted(parted: Parted<C>) -> Self {
        let Parted { time, depth, throughput, ratio, last, media, .. } = parted;
        let Parted { beside_light_subpaths, competing, prior_throughput, .. } = parted;
        Self {
            time,
            depth,
            vertex: depth,
            throughput,
            ratio,
            last,
            media,
            eta_scale: 1.0,
            beside_light_subpaths,
            competing,
            contested: SmallVec::new(),
            scattered_by: ScatteredBy::Any,
            through_discrete: false,
            branch_weight: 1.0,
            camera_visible: false,
            alpha_hit: true,
            prior_throughput,
            is_lesser: false,
            seen: Unseen,
        }
    }

    pub(super) fn from_camera(scene: &Scene, ray: &Ray, time: f64) -> Self {
        Self::seen_by(Unseen, scene, ray, time)
    }
}

impl<const C: usize, O: Observe> Path<C, O> {
    fn seen_by(seen: O, scene: &Scene, ray: &Ray, time: f64) -> Self {
        Self {
            seen,
            time,
            depth: 0,
            vertex: 0,
            throughput: Sampled::ONE,
            ratio: Sampled::ONE,
            last: PreviousSample::Camera,
            media: scene.media_at_sensor(ray, time),
            eta_scale: 1.0,
            beside_light_subpaths: Beside::Nothing,
            competing: Competing::No,
            contested: SmallVec::new(),
            scattered_by: ScatteredBy::Nothing,
            through_discrete: true,
            branch_weight: 1.0,
            camera_visible: true,
            alpha_hit: scene.limits.sky_covers(scene),
            prior_throughput: 1.0,
            is_lesser: false,
        }
    }

    /// Goes on along a ray to the path's end. Light that comes along it, weighed by all that was before.
    pub(super) fn follow(
        &mut self,
        scene: &Scene,
        mut ray: Ray,
        wavelengths: &Wavelengths<C>,
        stream: &Stream,
    ) -> Sampled<C> {
        if scene.features().scattering {
            return self.follow_through_media(scene, ray, wavelengths, stream);
        }
        let mut arriving = Sampled::ZERO;
        loop {
            // By reference: to move it costs as much as a shadow ray.
            let Some(hit) = &self.meet(scene, &ray, wavelengths, stream, &mut arriving) else {
                return arriving;
            };
            let Some(mut shading) = self.shade(scene, &ray, hit, wavelengths, stream) else {
                return arriving;
            };
            let shading = &mut shading;
            arriving += self.mirrored(scene, hit, shading, wavelengths, stream);
            match self.go_on(scene, &ray, hit, shading, wavelengths, stream, &mut arriving) {
                Some(next) => ray = next,
                None => return arriving,
            }
        }
    }

    /// To the next surface, with the light that comes from there or from beyond the scene. `None` where there
    /// is no surface.
    #[inline(always)]
    pub(super) fn meet(
        &mut self,
        scene: &Scene,
        ray: &Ray,
        wavelengths: &Wavelengths<C>,
        stream: &Stream,
        arriving: &mut Sampled<C>,
    ) -> Option<Intersection> {
        let hit = self.advance(scene, ray, wavelengths);
        match &hit {
            Some(hit) => {
                self.tell_of_surface(scene, ray, hit, wavelengths, stream);
                let light = self.emitted(scene, ray, hit, wavelengths);
                *arriving += self.found(light);
            }
            None => {
                self.tell_of_escape(scene, ray);
                let light = self.escaped(scene, ray, wavelengths);
                *arriving += self.found(light);
                self.end(scene, PathEnd::Escaped);
            }
        }
        hit
    }

    /// How the surface scatters. `None` where the path ends at it and nothing asks.
    #[inline(always)]
    pub(super) fn shade(
        &self,
        scene: &Scene,
        ray: &Ray,
        hit: &Intersection,
        wavelengths: &Wavelengths<C>,
        stream: &Stream,
    ) -> Option<Shading<C>> {
        // Past the last segment only alpha asks whether this surface is in the way, and light that may pass
        // it as if there were none: a light sample passes it too.
        if self.is_last(scene) && !scene.goes_on_past_last() && (self.alpha_hit || !scene.film.alpha) {
            self.end(scene, PathEnd::MaxDepth);
            return None;
        }
        Some(self.shading(scene, ray, hit, wavelengths, stream))
    }

    /// How the surface scatters, wherever the path ends.
    #[inline(always)]
    pub(super) fn shading(
        &self,
        scene: &Scene,
        ray: &Ray,
        hit: &Intersection,
        wavelengths: &Wavelengths<C>,
        stream: &Stream,
    ) -> Shading<C> {
        let choice = scene.material_choice(stream, self.vertex);
        scene.shade(hit, -ray.direction, &self.media, wavelengths, choice)
    }

    /// Light that reaches the surface straight from a light, and on by scattering. `None` where the path
    /// ends; branches are followed to their ends.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "the loop of a path, whose parts others call too")]
    pub(super) fn go_on(
        &mut self,
        scene: &Scene,
        ray: &Ray,
        hit: &Intersection,
        shading: &Shading<C>,
        wavelengths: &Wavelengths<C>,
        stream: &Stream,
        arriving: &mut Sampled<C>,
    ) -> Option<Ray> {
        *arriving += self.direct_light(scene, ray, hit, shading, wavelengths, stream);
        if let Some(ends) = self.split(scene, shading) {
            *arriving += self.follow_branches(scene, hit, shading, wavelengths, stream, &ends);
            return None;
        }
        self.scatter(scene, hit, shading, stream, 0.0..1.0)
    }

    /// Whether the path has as many segments as it may.
    pub(super) fn is_last(&self, scene: &Scene) -> bool {
        self.depth + 1 >= scene.limits.max_depth
    }

    /// On from a surface, with a lobe that one of these values chooses. `None` where the path ends.
    #[inline(always)]
    pub(super) fn scatter(
        &mut self,
        scene: &Scene,
        hit: &Intersection,
        shading: &Shading<C>,
        stream: &Stream,
        lobes: Range<f64>,
    ) -> Option<Ray> {
        let [u, v, lobe, survival] = stream.draw(Dimensions::Scattering(self.vertex));
        let scatter = shading.sample(lobes.start + (lobes.end - lobes.start) * lobe, [u, v]);
        let passes = scatter.as_ref().is_some_and(|scatter| shading.passes(scatter));
        self.alpha_hit |= scene.limits.surface_covers(passes);
        let goes_on = !self.is_last(scene) || (passes && !scene.limits.null_is_a_segment);
        let Some(scatter) = scatter.filter(|_| goes_on) else {
            self.end(scene, if goes_on { PathEnd::Absorbed } else { PathEnd::MaxDepth });
            return None;
        };
        let ray = self.leave(scene, hit, shading, &scatter);
        self.tell_of_scatter(scatter.toward_light, scatter.transmitted, scatter.density);
        self.survives(scene, survival).then_some(ray)
    }

    /// Leaves a surface in a direction that was sampled there.
    #[inline(always)]
    pub(super) fn leave(
        &mut self,
        scene: &Scene,
        hit: &Intersection,
        shading: &Shading<C>,
        scatter: &Scatter<C>,
    ) -> Ray {
        let passes = shading.passes(scatter);
        let prior = self.ratio.sum();
        self.through_discrete &= shading.bsdf.is_discrete();
        self.throughput *= scatter.weight;
        self.ratio *= scatter.ratio;
        self.camera_visible &= !scene.limits.surface_covers(passes);
        self.scattered_by = match (scatter.density, self.scattered_by) {
            (Density::PerSolidAngle(_), _) => ScatteredBy::Any,
            (Density::Discrete, ScatteredBy::Nothing) if !passes => ScatteredBy::Specular,
            (Density::Discrete, before) => before,
        };
        // Light samples of the last vertex pass the surface, too.
        let is_passed = passes
            && match self.last {
                PreviousSample::Scattered { .. } => scene.features().transparent_shadows,
                PreviousSample::Camera | PreviousSample::Discrete => !scene.limits.null_is_a_segment,
            };
        if !is_passed {
            self.last = match scatter.density {
                Density::Discrete => PreviousSample::Discrete,
                Density::PerSolidAngle(density) => {
                    let prior_over_density = prior / density;
                    PreviousSample::Scattered {
                        from: receiver(hit, shading),
                        prior_over_density,
                        by_scattering: self.ratio,
                    }
                }
            };
        }
        if !passes || scene.limits.null_is_a_segment {
            self.depth += 1;
        }
        if scene.features().caustics {
            self.track_light_subpaths(scene, hit, shading, scatter);
        }
        if scatter.transmitted {
            self.refract(shading);
            scene.pass_through(hit, scatter.toward_light, &mut self.media);
        }
        self.vertex += 1;
        hit.point.ray(scatter.toward_light)
    }

    /// What its next ray is.
    pub(super) fn ray_kind(&self) -> RayKind {
        if self.depth == 0 { RayKind::Camera } else { RayKind::Scattered }
    }

    /// The path ends before it leaves the surface that it has met, or where it has met none.
    pub(super) fn end(&self, scene: &Scene, end: PathEnd) {
        self.seen.tell(self.vertex, || Step::End { why: end.name() });
        scene.path_ended(end, self.depth + 1);
    }

    /// It ends when it would go on along a new segment.
    fn end_before_next(&self, scene: &Scene, kept: f64) {
        let end = if kept > 0.0 { PathEnd::Roulette } else { PathEnd::Absorbed };
        self.seen.tell(self.vertex - 1, || Step::End { why: end.name() });
        scene.path_ended(end, self.depth);
    }

    /// To the next surface, attenuated by the media on the way (Beer and Lambert).
    pub(super) fn advance(
        &mut self,
        scene: &Scene,
        ray: &Ray,
        wavelengths: &Wavelengths<C>,
    ) -> Option<Intersection> {
        let kind = self.ray_kind();
        let Self { throughput, media, time, .. } = self;
        scene.intersect(ray, *time, kind, media, |media: &MediumStack, segment| {
            if let Some(transmittance) = scene.transmittance(media, segment, wavelengths) {
                *throughput *= transmittance;
            }
        })
    }

    /// Records whether light subpaths may come the way that this path has just been scattered.
    fn track_light_subpaths(
        &mut self,
        scene: &Scene,
        hit: &Intersection,
        shading: &Shading<C>,
        scatter: &Scatter<C>,
    ) {
        self.competing = match self.competes_from(scene, hit, shading) {
            true => Competing::Yes,
            false => Competing::No,
        };
        match scatter.density {
            // Light subpaths end there, and are seen from the camera as the path is.
            Density::PerSolidAngle(hero) if self.vertex == 0 && !shading.bsdf.transmits() => {
                let density = hero * scatter.ratio.sum() / C as f64;
                let first = FirstSurface { point: hit.point, leaves: scatter.toward_light, density };
                self.beside_light_subpaths = Beside::First(first);
            }
            density if caustics::may_follow(scene, hit, shading, density) => {}
            _ => self.beside_light_subpaths = Beside::Nothing,
        }
    }

    /// Takes account of the radiance scaling of a refraction.
    fn refract(&mut self, shading: &Shading<C>) {
        if let Some(far_over_near) = shading.index_beyond() {
            self.eta_scale /= far_over_near * far_over_near;
        }
    }

    /// Throughput for Russian roulette: the most that the path can still bring, but for its branch weight. It
    /// does not depend on which wavelength is the hero.
    pub(super) fn roulette_throughput(&self) -> f64 {
        let alive = self.ratio.0.iter().filter(|&&ratio| ratio > 0.0).count() as f64;
        alive * self.throughput.max() / self.ratio.sum() / self.eta_scale * self.prior_throughput
    }

    /// Whether Russian roulette lets it go on along a new segment, as this value in [0, 1) decides. Its
    /// throughput grows by what the ended paths would have brought.
    #[inline(always)]
    pub(super) fn survives(&mut self, scene: &Scene, u: f64) -> bool {
        let kept = self.survival(scene);
        let survives = u < kept;
        if survives {
            self.tell_of_survival(kept);
            self.throughput /= kept;
        } else {
            self.end_before_next(scene, kept);
        }
        survives
    }

    /// Survival probability of Russian roulette. All of the path's densities change by this one factor, and
    /// their ratios stay.
    fn survival(&self, scene: &Scene) -> f64 {
        if self.throughput.is_zero() {
            0.0
        } else if self.depth < scene.limits.rr_depth && !self.is_lesser {
            1.0
        } else {
            let late = match scene.features().scattering {
                true => late_survival_in_media(self.depth),
                false => late_survival(self.depth),
            };
            roulette_survival(self.roulette_throughput(), late)
        }
    }
}
