//! Light tracing for caustics.
//!
//! A path from the camera finds the light that a smooth body focuses on a surface only if it runs into the
//! light by chance. A light subpath finds it at once. In a path
//!
//! camera → diffuse surface → … → diffuse surface → smooth surface → … → smooth surface → light,
//!
//! whose smooth surfaces scatter in single directions, as metal, glass and the coat of plastic do, all but
//! the first segment form a light subpath, which begins at the light and aims at the bodies. The surface next
//! to the light may also be polished metal, which scatters in nearly single directions. The light subpath
//! contributes each diffuse surface x that it meets to the camera with the weight
//!
//! Φ · f(ω, ω′) · cos θ′ / d² · dx/dω′,
//!
//! Φ the power of the path over the density of making it, ω′ the direction to the camera at the distance d,
//! and dx/dω′ the film's area for a solid angle there (Arvo, "Backward Ray Tracing", SIGGRAPH 1986 course
//! notes; Veach 1997, section 8.3).
//!
//! [`super::path`] may find the same path by chance. Each technique is weighed by the power heuristic (Veach
//! 1997, section 9.2.2), with the ratio of their densities
//!
//! r = N · p(xₙ) p(ω) / cos θₙ · cos θ₀ / (p(ω₀) ν(x₀)),
//!
//! N light subpaths for one sample of each pixel, xₙ and ω where the light subpath begins and in what
//! direction, ω₀ the direction in which a path from the camera leaves its first surface, x₀, and ν(x₀) pixels
//! per area of that. From an environment rays begin on disks across them: p(xₙ) / cos θₙ, which is a density
//! per area across the ray, is then given at once. This is exact where all but the first surface scatter with
//! the same density, per projected solid angle, forth and back, as smooth and diffuse ones do; elsewhere the
//! weights are worse, but still sum to one. So the camera finds near-mirror images of the light, and light
//! tracing finds what is scattered widely.
//!
//! Polished metal scatters with a density, so light samples there find the path, too. The weight of
//! scattering beside them is q = pᵤ² / (pᵤ² + pₗ²) with the densities of the two. By the power
//! heuristic over all three, light subpaths have the weight
//!
//! r² pᵤ² / (r² pᵤ² + pᵤ² + pₗ²) = r² q / (r² q + 1),
//!
//! which is that beside scattering alone with r √q for the ratio. What camera paths find by either
//! technique, weighed beside the other, is multiplied by the rest, 1 / (r² q + 1). Where pixels share the
//! second surface, as many camera paths may find the light as there are pixels, and r is divided by their
//! number.
//!
//! The camera also finds caustics that are seen through smooth surfaces or in them: a light subpath would
//! meet a point in view only by chance. There [`super::path`] splits at the diffuse surface.
//!
//! At clear glass a light subpath splits: the main of reflection and refraction is always followed, and the
//! lesser several times as often as by chance. What glass reflects within it falls into its shadow, where a
//! little light is much of what there is.
//!
//! Light subpaths scatter as camera paths do, but for two factors. Refraction scales radiance, but not power.
//! And where the shading normal is not the geometric one, beams of equal power differ in width on the two
//! sides (Veach 1997, section 5.3).

use super::contributions::receiver;
use super::light_subpaths::{Splat, Start, segment_to_lens};
use super::plan::Sharing;
use super::weights::{late_survival, power_heuristic, scattering_weight};
use crate::bsdf::Scatter;
use crate::geometry::{Ray, SurfacePoint, Vec3};
use crate::light::{Caustics, Emitted, Environment, LightHit, Origin};
use crate::material::Shading;
use crate::medium::Media;
use crate::sampling::{Density, Dimensions, Stream};
use crate::scene::{Intersection, RayKind, Scene};
use crate::spectrum::{Sampled, Wavelengths};
use smallvec::SmallVec;
use std::ops::Range;

/// How many times as often as by chance the lesser of reflection and refraction is followed at clear glass.
/// The cost of `validation/speed/scenes/caustic.xml` and `gallery/cbox.xml` is about the same with 3 to 8.
const LESSER: f64 = 4.0;

/// How a path from the camera goes on from the first surface that it meets.
#[derive(Clone, Copy, Debug)]
pub(super) struct FirstSurface {
    pub point: SurfacePoint,
    /// The direction in which it leaves.
    pub leaves: Vec3,
    /// With which that is chosen, sr⁻¹.
    pub density: f64,
}

impl Caustics {
    /// The camera's factor of the ratio of densities, that of light subpaths over that of camera paths. Zero
    /// where light subpaths do not come.
    fn camera_factor(&self, scene: &Scene, first: &FirstSurface, time: f64) -> f64 {
        let FirstSurface { point, leaves, density } = first;
        // Through the middle of the lens: any place will do where both techniques take the same.
        let Some(seen) = scene.camera.project(point.position, [0.5; 2], time) else { return 0.0 };
        let ratio = leaves.dot(point.normal).abs() / (density * seen.pixels_per_area(point.normal));
        if ratio.is_finite() { ratio } else { 0.0 }
    }

    /// The weight of a camera path beside light subpaths. `from_light` is the light's factor of the ratio.
    pub(super) fn weight_beside(
        &self,
        scene: &Scene,
        first: &FirstSurface,
        from_light: f64,
        time: f64,
    ) -> f64 {
        power_heuristic(1.0, from_light * self.camera_factor(scene, first, time))
    }
}

/// [`Caustics::light_factor`] of subpaths from a point of a lamp in a direction.
pub(super) fn factor_from_lamp(
    scene: &Scene,
    caustics: &Caustics,
    light: u32,
    point: &SurfacePoint,
    direction: Vec3,
    time: f64,
) -> f64 {
    caustics.light_factor(light, point, direction, scene.lights.area_ratio(light, point, time))
}

/// [`Caustics::environment_factor`] of subpaths that come along a ray from beyond the scene.
pub(super) fn factor_from_beyond(caustics: &Caustics, environment: &Environment, ray: &Ray) -> f64 {
    caustics.environment_factor(ray.direction, environment.density(ray.direction), ray.origin)
}

/// The light's factor of the ratio of densities for light that arrives along a ray, from where that leads to
/// at once.
pub(super) fn factor_along(scene: &Scene, caustics: &Caustics, ray: &Ray, time: f64, media: &Media) -> f64 {
    match scene.intersect(ray, time, RayKind::Shadow, &mut media.clone(), |_, _| ()) {
        Some(hit) => hit
            .light
            .map_or(0.0, |light| factor_from_lamp(scene, caustics, light, &hit.point, -ray.direction, time)),
        None => {
            let environment = scene.lights.environment();
            environment.map_or(0.0, |environment| factor_from_beyond(caustics, environment, ray))
        }
    }
}

/// Traces a light subpath over smooth surfaces to a diffuse one, and on. Each diffuse surface that it meets
/// makes a splat.
pub(super) fn light_subpath<'a, const C: usize>(
    scene: &'a Scene,
    caustics: &Caustics,
    sharing: Sharing,
    start: &Start<C>,
    stream: &Stream,
    splat: &mut impl FnMut(Splat<'a, C>),
) {
    let Some(subpath) = LightSubpath::begin(scene, caustics, sharing, start) else { return };
    let mut branches = SmallVec::new();
    subpath.follow(scene, caustics, stream, &mut branches, splat);
    while let Some(branch) = branches.pop() {
        branch.follow(scene, caustics, stream, &mut branches, splat);
    }
}

/// How a light subpath goes on at clear glass.
#[derive(Clone, Debug, PartialEq)]
struct Split {
    /// The values that choose the lesser of reflection and refraction, and the others.
    lesser: Range<f64>,
    main: Range<f64>,
    /// The probability with which the lesser is followed. The main always is.
    followed: f64,
}

impl Split {
    /// By the probability of reflection and what the subpath weighs as a branch. `None` where the lesser is
    /// to be followed no more often than by chance.
    fn new(reflection: f64, branch_weight: f64) -> Option<Self> {
        let (reflected, refracted) = (0.0..reflection, reflection..1.0);
        let (lesser, main) = if reflection < 0.5 { (reflected, refracted) } else { (refracted, reflected) };
        let chance = lesser.end - lesser.start;
        let followed = (LESSER * branch_weight * chance).min(1.0);
        (followed > chance).then_some(Self { lesser, main, followed })
    }
}

/// Connects the surface that a light subpath has met to the camera. `None` where the camera does not see it.
fn splat_from<'a, const C: usize>(
    scene: &'a Scene,
    caustics: &Caustics,
    subpath: &LightSubpath<C>,
    hit: &Intersection,
    lens: [f64; 2],
    choice: f64,
) -> Option<Splat<'a, C>> {
    let LightSubpath { ray, power, ratio, media, wavelengths, time, .. } = subpath;
    let seen = scene.camera.project(hit.point.position, lens, *time)?;
    // Before all that is only asked for where the surface is in view.
    let last = segment_to_lens(scene, &hit.point, &seen, *time)?;
    let mut shading = scene.shade(hit, seen.toward_lens, media, wavelengths, choice);
    // Paths from the camera follow a coat's mirror reflection apart, so their density is that of the base.
    shading.take_mirror();
    if shading.bsdf.transmits() {
        return None;
    }
    let leaves = -ray.direction;
    let value = shading.evaluate(leaves);
    if value.f_cos.is_zero() {
        return None;
    }
    let first = FirstSurface { point: hit.point, leaves, density: value.density.sum() / C as f64 };
    let by_camera = caustics.camera_factor(scene, &first, *time);
    // What single directions decide is not shared.
    let sharers = if subpath.last_discrete { 1 } else { subpath.sharing.pixels() };
    let from_light =
        subpath.origin.factor(scene, caustics, *time) * subpath.by_scattering.sqrt() / f64::from(sharers);
    let weight = power_heuristic(from_light * by_camera, 1.0);
    if weight == 0.0 {
        return None;
    }
    // What arrives is spread over the surface by its own normal, and weighed by the BSDF's.
    let arriving = leaves.dot(hit.point.normal).abs();
    let leaving = seen.toward_lens.dot(hit.point.normal).abs();
    let geometry = leaving / (arriving * seen.distance * seen.distance) * seen.pixels_per_steradian;
    let mut radiance = *power * value.f_cos * (weight * geometry / ratio.sum());
    if let Some(transmittance) = scene.transmittance(&media.here, &last, wavelengths) {
        radiance *= transmittance;
    }
    Some(Splat { film: seen.film, radiance, wavelengths: *wavelengths, response: seen.response })
}

/// A subpath from a light.
#[derive(Clone)]
struct LightSubpath<const C: usize> {
    time: f64,
    wavelengths: Wavelengths<C>,
    ray: Ray,
    /// Power of each wavelength, over the hero's density.
    power: Sampled<C>,
    /// Each wavelength's density of the path over the hero's, as in [`super::path`].
    ratio: Sampled<C>,
    media: Media,
    /// The largest power that it began with, times its weight as a branch.
    initial_power: f64,
    origin: Beginning,
    /// The weight of scattering beside light samples at the first surface, where it scatters in nearly single
    /// directions. 1 where no light sample can find the light.
    by_scattering: f64,
    /// How camera paths share.
    sharing: Sharing,
    /// Whether the last surface has scattered it in a single direction.
    last_discrete: bool,
    /// Number of surfaces before the next one.
    vertex: u32,
    /// The product of the weights of the branches that led to it.
    branch_weight: f64,
}

/// Where a light subpath begins.
#[derive(Clone, Copy)]
enum Beginning {
    /// At a light, where and in what direction.
    Surface { start: LightHit, toward: Vec3 },
    /// Beyond the scene, from a direction that has a density per steradian, on a ray through a place.
    Environment { direction: Vec3, density: f64, place: Vec3 },
}

impl Beginning {
    /// The light's factor of the ratio of densities.
    fn factor(self, scene: &Scene, caustics: &Caustics, time: f64) -> f64 {
        match self {
            Self::Surface { start: LightHit { light, point, .. }, toward } => {
                factor_from_lamp(scene, caustics, light, &point, toward, time)
            }
            Self::Environment { direction, density, place } => {
                caustics.environment_factor(direction, density, place)
            }
        }
    }
}

impl<const C: usize> LightSubpath<C> {
    fn begin(scene: &Scene, caustics: &Caustics, sharing: Sharing, start: &Start<C>) -> Option<Self> {
        let &Start { time, wavelengths, source, place, onward, body } = start;
        let (chosen, probability) = caustics.choose(source);
        let (ray, power, origin) = match chosen {
            Origin::Surface { light, .. } => {
                let Emitted { hit: start, radiance, density: at_point } =
                    scene.lights.emit(light, place, time, &wavelengths.nm)?;
                let (toward, density) = caustics.aim_from(&start.point)?.sample(body, onward)?;
                let cos = toward.dot(start.point.normal);
                let power = radiance * (cos / (probability * at_point * density));
                let origin = Beginning::Surface { start, toward };
                (cos > 0.0).then(|| (start.point.ray(toward), power, origin))?
            }
            Origin::Environment => {
                let environment = scene.lights.environment()?;
                let (direction, density, radiance) =
                    environment.sample_radiance(place, Vec3::ZERO, &wavelengths.nm)?;
                let (ray, per_area) = caustics.ray_along(-direction, body, onward)?;
                let power = radiance / (probability * density * per_area);
                (ray, power, Beginning::Environment { direction, density, place: ray.origin })
            }
        };
        Some(Self {
            time,
            wavelengths,
            ray,
            power,
            ratio: Sampled::ONE,
            media: Media::default(),
            initial_power: power.max(),
            origin,
            by_scattering: 1.0,
            sharing,
            last_discrete: false,
            vertex: 0,
            branch_weight: 1.0,
        })
    }

    /// To its end. What it splits into beside itself comes to the branches.
    fn follow<'a>(
        mut self,
        scene: &'a Scene,
        caustics: &Caustics,
        stream: &Stream,
        branches: &mut SmallVec<[Self; 2]>,
        splat: &mut impl FnMut(Splat<'a, C>),
    ) {
        loop {
            let Some(hit) = self.advance(scene) else { return };
            let vertex = self.vertex;
            let nearly_specular = scene.is_nearly_specular(&hit);
            if vertex == 0 && !scene.is_specular(&hit) && !nearly_specular {
                return;
            }
            let features = scene.features();
            // Nothing else asks for these values.
            let is_asked = features.lens || features.choices;
            let [lens_x, lens_y, _, choice] =
                if is_asked { stream.draw(Dimensions::Light(vertex)) } else { [0.5; 4] };
            let mut shading = scene.shade(&hit, -self.ray.direction, &self.media, &self.wavelengths, choice);
            if vertex > 0 && !shading.bsdf.is_discrete() {
                splat_from(scene, caustics, &self, &hit, [lens_x, lens_y], choice).map(&mut *splat);
            }
            // With another surface the path has two segments more than there are surfaces until here, and
            // that one.
            let segments = vertex + 3;
            if segments > scene.limits.max_depth {
                return;
            }
            let [u, v, lobe, survival] = stream.draw(Dimensions::Scattering(vertex));
            if vertex == 0 && nearly_specular {
                let toward_light = -self.ray.direction;
                if self.scatter(scene, &hit, &shading, 0.0..1.0, [u, v, lobe]).is_none()
                    || !self.survives(scene, segments, survival)
                {
                    return;
                }
                self.weigh_scattering(scene, &hit, toward_light, choice);
                if self.by_scattering == 0.0 {
                    return;
                }
                continue;
            }
            if vertex == 0 && !shading.bsdf.is_discrete() {
                // Light samples find what reaches the surface beneath a coat straight.
                let Some(mirror) = shading.take_mirror() else { return };
                if self.leave(scene, &hit, &shading, &mirror).is_none()
                    || !self.survives(scene, segments, survival)
                {
                    return;
                }
                continue;
            }
            let mut lobes = 0.0..1.0;
            if let Some(Split { lesser, main, followed }) = self.split(scene, &shading) {
                if lobe < followed {
                    let mut branch = self.clone();
                    branch.weigh(1.0 / followed);
                    if branch.scatter(scene, &hit, &shading, lesser, [u, v, lobe]).is_some()
                        && branch.survives(scene, segments, survival)
                    {
                        branches.push(branch);
                    }
                }
                lobes = main;
            }
            if self.scatter(scene, &hit, &shading, lobes, [u, v, lobe]).is_none()
                || !self.survives(scene, segments, survival)
            {
                return;
            }
        }
    }

    /// Finds the weight of scattering beside light samples for a camera path that comes the other way to the
    /// first surface, which has just scattered.
    fn weigh_scattering(&mut self, scene: &Scene, hit: &Intersection, toward_light: Vec3, choice: f64) {
        let Self { time, wavelengths, .. } = *self;
        let shading = scene.shade(hit, self.ray.direction, &self.media, &wavelengths, choice);
        let by_scattering = shading.evaluate(toward_light).density.sum() / C as f64;
        let from = receiver(hit, &shading);
        let by_light = || match self.origin {
            Beginning::Surface { start, .. } => scene.lights.density(&start, &from, time, &wavelengths),
            Beginning::Environment { .. } => {
                scene.lights.environment_density(&from, toward_light, time, &wavelengths)
            }
        };
        self.by_scattering = scattering_weight(scene, by_light, || by_scattering);
    }

    /// Whether it splits, and how.
    fn split(&self, scene: &Scene, shading: &Shading<C>) -> Option<Split> {
        // As camera paths: what roulette keeps grows in weight, and shall not split without end.
        let may_split = scene.limits.splits_at_glass && late_survival(self.vertex) == 1.0;
        let reflection = shading.reflection_probability().filter(|_| may_split)?;
        Split::new(reflection, self.branch_weight)
    }

    /// Takes account of the weight of a branch.
    fn weigh(&mut self, weight: f64) {
        self.power *= weight;
        self.initial_power *= weight;
        self.branch_weight *= weight;
    }

    /// To the next surface, attenuated by the media on the way.
    fn advance(&mut self, scene: &Scene) -> Option<Intersection> {
        let Self { ray, time, wavelengths, power, media, .. } = self;
        scene.intersect(ray, *time, RayKind::LightTracing, media, |media, segment| {
            if let Some(transmittance) = scene.transmittance(media, segment, wavelengths) {
                *power *= transmittance;
            }
        })
    }

    /// On from a surface, by values of the lobe from a range, which is the weight of the branch. `None` where
    /// the path ends, and where [`super::path`] alone follows it.
    fn scatter(
        &mut self,
        scene: &Scene,
        hit: &Intersection,
        shading: &Shading<C>,
        lobes: Range<f64>,
        [u, v, lobe]: [f64; 3],
    ) -> Option<()> {
        let weight = lobes.end - lobes.start;
        let scatter = shading.sample(lobes.start + weight * lobe, [u, v])?;
        if !may_follow(scene, hit, shading, scatter.density) {
            return None;
        }
        self.weigh(weight);
        self.leave(scene, hit, shading, &scatter)
    }

    /// On in a direction that was sampled. `None` where it grazes the surface.
    fn leave(
        &mut self,
        scene: &Scene,
        hit: &Intersection,
        shading: &Shading<C>,
        scatter: &Scatter<C>,
    ) -> Option<()> {
        let leaves = scatter.toward_light;
        self.power *= scatter.weight * spread(hit, -self.ray.direction, leaves)?;
        self.ratio *= scatter.ratio;
        if scatter.transmitted {
            // The BSDF's weight is for radiance.
            let far_over_near = shading.index_beyond().unwrap_or(1.0);
            self.power *= far_over_near * far_over_near;
            scene.pass_through(hit, leaves, &mut self.media);
        }
        self.ray = hit.point.ray(leaves);
        self.last_discrete = scatter.density == Density::Discrete;
        self.vertex += 1;
        Some(())
    }

    /// Russian roulette on what is left of the power, for a path that will have so many segments. The factor
    /// of [`super::weights::roulette_survival`] gains nothing here.
    fn survives(&mut self, scene: &Scene, segments: u32, u: f64) -> bool {
        if self.power.is_zero() {
            return false;
        }
        if segments < scene.limits.rr_depth {
            return true;
        }
        let kept = (self.power.max() / self.initial_power).min(late_survival(segments));
        self.power /= kept;
        u < kept
    }
}

/// Whether light subpaths follow the scattering that a surface has just made: that of smooth surfaces, and
/// the wide lobes of opaque ones without bumps, which scatter otherwise when seen from the other end.
pub(super) fn may_follow<const C: usize>(
    scene: &Scene,
    hit: &Intersection,
    shading: &Shading<C>,
    density: Density,
) -> bool {
    match density {
        Density::Discrete => scene.is_specular(hit),
        Density::PerSolidAngle(_) => !shading.bsdf.transmits() && !shading.turns_with_eye(),
    }
}

/// Factor by which a beam that arrives from one direction and leaves in another is wider on the surface than
/// the BSDF takes it to be. It is 1 where shading and geometric normal are the same. `None` where the beam
/// grazes the surface.
fn spread(hit: &Intersection, arrives: Vec3, leaves: Vec3) -> Option<f64> {
    let (own, shading) = (hit.point.normal, hit.shading_normal);
    if own == shading {
        return Some(1.0);
    }
    let factor = arrives.dot(shading) * leaves.dot(own) / (arrives.dot(own) * leaves.dot(shading));
    factor.is_finite().then(|| factor.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is followed of a split weighs 1 in the mean, and branches do not split on and on.
    #[test]
    fn the_lesser_of_reflection_and_refraction_is_followed_more_often() {
        let split = Split::new(0.04, 1.0).unwrap();
        assert_eq!(split, Split { lesser: 0.0..0.04, main: 0.04..1.0, followed: LESSER * 0.04 });
        assert_eq!(Split::new(0.9, 0.5).unwrap().main, 0.0..0.9);
        // By what a branch of the lesser weighs it is followed by chance alone.
        assert_eq!(Split::new(0.04, 1.0 / LESSER), None);
        for reflection in [0.01, 0.2, 0.3, 0.5, 0.7, 0.99] {
            for branch_weight in [0.26, 0.5, 1.0] {
                let Split { lesser, main, followed } = Split::new(reflection, branch_weight).unwrap();
                let [lesser, main] = [lesser, main].map(|lobes| lobes.end - lobes.start);
                assert!((lesser + main - 1.0).abs() < 1e-15 && lesser <= main);
                assert!(followed > lesser && followed <= 1.0);
            }
        }
        assert_eq!(Split::new(0.0, 1.0), None);
    }
}
