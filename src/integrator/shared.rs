//! Path tracing for a group of pixels that share the suffixes of their paths.
//!
//! The camera ray of each pixel i leads to a first surface xᵢ, and scattering there on to a next one, yᵢ.
//! What yᵢ sends on, its light samples and all beyond, serves every pixel of the group that sees yᵢ. Pixel i
//! gets of what lies behind the points yⱼ of all pixels
//!
//! Σⱼ fᵢ(yⱼ) Gᵢⱼ Vᵢⱼ L(yⱼ → xᵢ) / Σₖ pₖ(yⱼ) Vₖⱼ,
//!
//! where pₖ is the density per unit of area with which pixel k samples yⱼ: the balance heuristic over the
//! whole group, visibility included, for a pixel samples only what it sees (Bekaert, Sbert, Halton,
//! "Accelerating path tracing by re-using paths", EGWR 2002). Where yⱼ scatters in dependence on the
//! direction to xᵢ, its BSDF is evaluated for each pixel, and the density of the direction in which the
//! suffix goes on joins each pₖ. The group shares the wavelengths of its paths and their time; each pₖ is
//! summed over the wavelengths, as in [`super::path`].
//!
//! What yᵢ emits is shared as well, and so is the environment where scattering leads out of the scene: as a
//! place at infinity, with densities per steradian. Each pixel weighs that against its own light samples.
//!
//! The pixel keeps for itself all that is decided by directions without a density. Which paths are shared is
//! told by what lies before yⱼ and by the kind of surface that yⱼ is, never by what the suffix finds. So the
//! sum over what is shared and what is not is that of the path tracer.

use super::RadianceSample;
use super::caustics::FirstSurface;
use super::links::{Firsts, Links, Values};
use super::path::{Beside, Path, PreviousSample, light_sample_weight, receiver};
use crate::geometry::{Ray, Vec3};
use crate::lanes::{LANES, SampledLanes, lanes_of};
use crate::light::{LightHit, Receiver};
use crate::material::Shading;
use crate::sampling::{Density, Dimensions, Stream};
use crate::scene::{Intersection, PathEnd, Scene};
use crate::spectrum::{Sampled, Wavelengths};
use smallvec::SmallVec;

/// The camera ray of a pixel of a group.
#[derive(Clone, Copy, Debug)]
pub struct Sight<'a> {
    /// Which pixel of the group it is.
    pub member: usize,
    pub ray: Ray,
    pub stream: Stream<'a>,
}

/// A first surface that shares.
pub(super) struct First<const C: usize> {
    /// Whose it is, among the sights.
    pub sight: usize,
    /// As it comes to the surface.
    pub path: Path<C>,
    pub hit: Intersection,
    pub shading: Shading<C>,
}

/// A next surface, and how it was found.
pub(super) struct Next<'a> {
    /// By which of the first surfaces.
    pub owner: usize,
    pub ray: &'a Ray,
    pub hit: &'a Intersection,
}

/// Adds to each pixel of a group the spectral radiance along its camera ray, as [`super::radiance`] gives it
/// for one alone. `seen` is by the members' numbers; `light_samples` says how many each first surface takes.
/// There are at most [`LANES`] sights.
pub fn radiance_of_group<const C: usize>(
    scene: &Scene,
    sights: &[Sight],
    time: f64,
    wavelengths: &Wavelengths<C>,
    light_samples: u32,
    seen: &mut [RadianceSample<C>],
) {
    share(scene, sights, time, wavelengths, light_samples, seen, |_, _, _| {});
}

/// The parts of what [`radiance_of_group`] gives a pixel: its own, and what comes of the path of each member.
pub fn parts_of_group<const C: usize>(
    scene: &Scene,
    sights: &[Sight],
    time: f64,
    wavelengths: &Wavelengths<C>,
    light_samples: u32,
    member: usize,
) -> (Sampled<C>, Vec<(usize, Sampled<C>)>) {
    let members = 1 + sights.iter().map(|sight| sight.member).max().unwrap_or(0);
    let mut seen = vec![RadianceSample::NOTHING; members.max(member + 1)];
    let (mut parts, mut before) = (Vec::new(), Sampled::ZERO);
    share(scene, sights, time, wavelengths, light_samples, &mut seen, |firsts, owner, shared| {
        let Some(lane) = firsts.iter().position(|first| sights[first.sight].member == member) else { return };
        let sum = shared.get(lane);
        parts.push((sights[firsts[owner].sight].member, sum - before));
        before = sum;
    });
    (seen[member].radiance - before, parts)
}

/// `told` is called after the path of each first surface, with what all of them have got so far.
#[inline(always)]
fn share<const C: usize>(
    scene: &Scene,
    sights: &[Sight],
    time: f64,
    wavelengths: &Wavelengths<C>,
    light_samples: u32,
    seen: &mut [RadianceSample<C>],
    mut told: impl FnMut(&[First<C>], usize, &SampledLanes<C>),
) {
    debug_assert!(sights.len() <= LANES);
    let group = Group { scene, sights, time, wavelengths, light_samples };
    let mut firsts: SmallVec<[First<C>; LANES]> = SmallVec::new();
    for sight in 0..sights.len() {
        group.first(sight, &mut firsts, seen);
    }
    let lanes = Firsts::new(scene, time, wavelengths, &firsts);
    let mut shared = SampledLanes::ZERO;
    for owner in 0..firsts.len() {
        group.next(&lanes, owner, &mut shared, seen);
        told(&firsts, owner, &shared);
    }
    for (lane, first) in firsts.iter().enumerate() {
        seen[sights[first.sight].member].radiance += shared.get(lane);
    }
}

struct Group<'a, const C: usize> {
    scene: &'a Scene,
    sights: &'a [Sight<'a>],
    time: f64,
    wavelengths: &'a Wavelengths<C>,
    light_samples: u32,
}

impl<const C: usize> Group<'_, C> {
    /// The first surface of a camera ray, with the light that reaches it straight. Where it does not share
    /// the path is followed to its end.
    fn first(&self, sight: usize, firsts: &mut SmallVec<[First<C>; LANES]>, seen: &mut [RadianceSample<C>]) {
        let Sight { member, ref ray, ref stream } = self.sights[sight];
        let RadianceSample { radiance, alpha_hit } = &mut seen[member];
        let mut path = Path::from_camera(self.scene, ray, self.time);
        *alpha_hit = path.alpha_hit;
        let Some(hit) = path.meet(self.scene, ray, self.wavelengths, radiance) else { return };
        let Some(shading) = path.shade(self.scene, ray, &hit, self.wavelengths, stream) else { return };
        if path.is_last(self.scene) || !shares(&shading) {
            self.go_on_alone(&mut path, ray, &hit, &shading, stream, radiance);
            *alpha_hit = path.alpha_hit;
            return;
        }
        *alpha_hit = true;
        let mut direct = path.direct_light(self.scene, ray, &hit, &shading, self.wavelengths, stream);
        for branch in 1..self.light_samples {
            let stream = &stream.branch(branch);
            direct += path.direct_light(self.scene, ray, &hit, &shading, self.wavelengths, stream);
        }
        *radiance += direct / f64::from(self.light_samples);
        firsts.push(First { sight, path, hit, shading });
    }

    /// Follows a path that is not shared from a surface to its end.
    fn go_on_alone(
        &self,
        path: &mut Path<C>,
        ray: &Ray,
        hit: &Intersection,
        shading: &Shading<C>,
        stream: &Stream,
        radiance: &mut Sampled<C>,
    ) {
        if let Some(ray) = path.go_on(self.scene, ray, hit, shading, self.wavelengths, stream, radiance) {
            *radiance += path.follow(self.scene, ray, self.wavelengths, stream);
        }
    }

    /// The next surface that scattering at a first one leads to, and what it brings to all of them. Where it
    /// does not share the path is followed to its end.
    fn next(
        &self,
        firsts: &Firsts<C>,
        owner: usize,
        shared: &mut SampledLanes<C>,
        seen: &mut [RadianceSample<C>],
    ) {
        let First { sight, hit, shading, path } = &firsts.surfaces[owner];
        let Sight { member, ref stream, .. } = self.sights[*sight];
        let radiance = &mut seen[member].radiance;
        let [u, v, lobe, _] = stream.draw(Dimensions::Scattering(path.vertex));
        let Some(scatter) = shading.sample(lobe, [u, v]) else {
            path.end(self.scene, PathEnd::Absorbed);
            return;
        };
        let mut path = path.clone();
        let ray = path.leave(self.scene, hit, shading, &scatter);
        if scatter.density == Density::Discrete {
            *radiance += path.follow(self.scene, ray, self.wavelengths, stream);
            return;
        }
        let Some(hit) = path.advance(self.scene, &ray, self.wavelengths) else {
            self.share_environment(firsts, owner, ray.direction, shared);
            path.end(self.scene, PathEnd::Escaped);
            return;
        };
        let next = Next { owner, ray: &ray, hit: &hit };
        let mut links = None;
        if let Some(light_hit) = hit.on_light().filter(|_| ray.direction.dot(hit.point.normal) < 0.0) {
            let links = links.insert(firsts.links(&next));
            self.share_emission(firsts, &light_hit, &hit, links, shared);
        }
        let Some(shading) = path.shade(self.scene, &ray, &hit, self.wavelengths, stream) else { return };
        if path.is_last(self.scene) || !shares(&shading) || shading.turns_with_eye() {
            self.go_on_alone(&mut path, &ray, &hit, &shading, stream, radiance);
            return;
        }
        let links = links.unwrap_or_else(|| firsts.links(&next));
        self.serve(firsts, &next, &shading, &links, &mut path, shared, radiance);
    }

    /// Gives each first surface what comes from beyond the scene in a direction in which one of them
    /// scatters.
    fn share_environment(
        &self,
        firsts: &Firsts<C>,
        owner: usize,
        direction: Vec3,
        shared: &mut SampledLanes<C>,
    ) {
        let Some(environment) = self.scene.lights.environment() else { return };
        let radiance = environment.radiance(direction, &self.wavelengths.nm);
        if !radiance.is_zero() {
            let links = firsts.links_beyond(owner, direction);
            self.share_light(firsts, &links, &radiance, shared, |from| {
                self.scene.lights.environment_density(from, direction, self.time, self.wavelengths)
            });
        }
    }

    /// Gives each first surface what a light emits toward it that one of them has met.
    fn share_emission(
        &self,
        firsts: &Firsts<C>,
        light_hit: &LightHit,
        hit: &Intersection,
        links: &Links<C>,
        shared: &mut SampledLanes<C>,
    ) {
        let place = self.scene.texture_point(hit);
        let radiance = self.scene.lights.radiance(light_hit.light, &place, &self.wavelengths.nm);
        self.share_light(firsts, links, &radiance, shared, |from| {
            self.scene.lights.density(light_hit, from, self.time, self.wavelengths)
        });
    }

    /// Gives each first surface its part of some light that scattering found. It is weighed against light
    /// samples, which find it with a density per steradian.
    fn share_light(
        &self,
        firsts: &Firsts<C>,
        links: &Links<C>,
        radiance: &Sampled<C>,
        shared: &mut SampledLanes<C>,
        by_light: impl Fn(&Receiver) -> f64,
    ) {
        let density = links.density.sum().sum();
        if density <= 0.0 {
            return;
        }
        let mut weights = SampledLanes::ZERO;
        for lane in lanes_of(links.linked) {
            let First { hit, shading, .. } = &firsts.surfaces[lane];
            let from = receiver(hit, shading);
            let by_light = by_light(&from);
            let weight = if by_light > 0.0 {
                let choice = PreviousSample::Scattered {
                    from,
                    prior_over_density: C as f64,
                    by_scattering: links.density_of_direction(lane),
                };
                choice.weight_beside_lights(self.scene, |_| by_light)
            } else {
                1.0
            };
            weights.set(lane, &Sampled::splat(weight));
        }
        links.reach.add_to(&weights, &(*radiance / density), shared);
    }

    /// Gives each first surface what a next one that it sees sends toward it; to the owner alone what has no
    /// density. `path` is the owner's as it comes to the next surface.
    #[expect(
        clippy::too_many_arguments,
        reason = "a step of the group's work, which borrows what the steps before made"
    )]
    fn serve(
        &self,
        firsts: &Firsts<C>,
        next: &Next,
        shading: &Shading<C>,
        links: &Links<C>,
        path: &mut Path<C>,
        shared: &mut SampledLanes<C>,
        own: &mut Sampled<C>,
    ) {
        let Next { owner, ray, hit } = *next;
        let prior = links.density.sum();
        if prior.hero() <= 0.0 {
            path.end(self.scene, PathEnd::Absorbed);
            return;
        }
        let stream = &self.sights[firsts.surfaces[owner].sight].stream;
        if let Some(sample) = path.light_sample(self.scene, hit, shading, self.wavelengths, stream) {
            let values = Values::new(shading, links, sample.shadow_ray.direction);
            if !links.reach.dot(&values.f_cos).is_zero() {
                let weight = light_sample_weight(self.scene, sample.density, prior.sum(), || {
                    links.density.dot(&values.density).sum()
                });
                let visibility = if weight == 0.0 {
                    Sampled::ZERO
                } else {
                    path.visibility(self.scene, ray, hit, &sample.shadow_ray, self.wavelengths)
                };
                let arriving = sample.radiance * visibility * weight;
                links.reach.add_to(&values.f_cos, &arriving, shared);
            }
        }
        let [u, v, lobe, survival] = stream.draw(Dimensions::Scattering(path.vertex));
        let Some(scatter) = shading.sample(lobe, [u, v]) else {
            path.end(self.scene, PathEnd::Absorbed);
            return;
        };
        if scatter.density == Density::Discrete {
            let ray = path.leave(self.scene, hit, shading, &scatter);
            let kept = path.survival(self.scene);
            if survival < kept {
                path.throughput /= kept;
                *own += path.follow(self.scene, ray, self.wavelengths, stream);
            } else {
                path.end_before_next(self.scene, kept);
            }
            return;
        }
        let values = Values::new(shading, links, scatter.toward_light);
        // The density of the next surface together with the direction in which the path goes on from it, over
        // all first surfaces.
        let joint = links.density.dot(&values.density);
        if joint.hero() <= 0.0 {
            path.end(self.scene, PathEnd::Absorbed);
            return;
        }
        let ray = path.leave(self.scene, hit, shading, &scatter);
        let suffix = links.reach.dot(&values.f_cos);
        if suffix.is_zero() {
            path.end_before_next(self.scene, 0.0);
            return;
        }
        let alive = joint.0.iter().filter(|&&density| density > 0.0).count() as f64;
        path.prior_throughput = alive * suffix.max() / joint.sum();
        path.throughput = Sampled::ONE;
        path.ratio = joint / joint.hero();
        path.last = PreviousSample::Scattered {
            from: receiver(hit, shading),
            prior_over_density: prior.sum() / joint.hero(),
            by_scattering: path.ratio,
        };
        if let Beside::First(_) = path.beside_light_subpaths {
            path.beside_light_subpaths = Beside::Shared;
        }
        let kept = path.survival(self.scene);
        if survival >= kept {
            path.end_before_next(self.scene, kept);
            return;
        }
        path.throughput /= kept;
        let arriving = path.follow(self.scene, ray, self.wavelengths, stream);
        links.reach.add_to(&values.f_cos, &(arriving / joint.hero()), shared);
        for (light, from_light) in std::mem::take(&mut path.contested) {
            for lane in lanes_of(links.linked) {
                let carried = links.reach.get(lane) * values.f_cos.get(lane) / joint.hero();
                let weight =
                    self.weight_beside_light_subpaths(&firsts.surfaces[lane], links, lane, from_light);
                shared.set(lane, &(shared.get(lane) + carried * light * weight));
            }
        }
    }

    /// The weight, beside light subpaths that reach a first surface, of what it gets of a suffix.
    fn weight_beside_light_subpaths(
        &self,
        first: &First<C>,
        links: &Links<C>,
        lane: usize,
        from_light: f64,
    ) -> f64 {
        let Some(caustics) = self.scene.caustics() else { return 1.0 };
        let leaves = -links.toward_first(lane);
        let density = first.shading.evaluate(leaves).density.sum() / C as f64;
        let surface = FirstSurface { point: first.hit.point, leaves, density };
        caustics.weight_beside(self.scene, &surface, from_light, self.time)
    }
}

/// Whether a surface may be one of those between which paths are shared: it scatters with a density, back to
/// the side that light comes from.
fn shares<const C: usize>(shading: &Shading<C>) -> bool {
    !shading.bsdf.is_discrete() && !shading.bsdf.transmits()
}
