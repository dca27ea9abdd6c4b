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
use super::bundle::{Bundle, Setting};
use super::caustics::FirstSurface;
use super::links::{Firsts, Links, Next, Values};
use super::path::{PreviousSample, light_sample_weight};
use super::surfaces::Surfaces;
use crate::bsdf::Scatter;
use crate::geometry::{Ray, Vec3};
use crate::lanes::{LANES, Mask, WIDTH, get, lanes_of, set};
use crate::light::{LightHit, Receiver};
use crate::sampling::{Dimensions, Stream};
use crate::scene::{PathEnd, Scene};
use crate::spectrum::{Sampled, SampledLanes, Wavelengths};
use smallvec::SmallVec;

/// The camera ray of a pixel of a group.
#[derive(Clone, Copy, Debug)]
pub struct Sight<'a> {
    /// Which pixel of the group it is.
    pub member: usize,
    pub ray: Ray,
    pub stream: Stream<'a>,
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
    share(scene, sights, time, wavelengths, light_samples, seen, |_, _| {});
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
    let (mut parts, mut before) = (Vec::<(usize, Sampled<C>)>::new(), Sampled::ZERO);
    let lane = sights.iter().position(|sight| sight.member == member);
    share(scene, sights, time, wavelengths, light_samples, &mut seen, |owner, shared| {
        let Some(lane) = lane else { return };
        let (owner, sum) = (sights[owner].member, shared.get(lane));
        let part = sum - before;
        before = sum;
        match parts.iter_mut().find(|(known, _)| *known == owner) {
            Some((_, known)) => *known += part,
            None => parts.push((owner, part)),
        }
    });
    (seen[member].radiance - before, parts)
}

/// `told` is called when something that the path of a lane has found was shared, with what all have got so
/// far.
#[inline(always)]
fn share<const C: usize>(
    scene: &Scene,
    sights: &[Sight],
    time: f64,
    wavelengths: &Wavelengths<C>,
    light_samples: u32,
    seen: &mut [RadianceSample<C>],
    told: impl FnMut(usize, &SampledLanes<C>),
) {
    debug_assert!(sights.len() <= LANES);
    let streams: SmallVec<[Stream; LANES]> = sights.iter().map(|sight| sight.stream).collect();
    let setting = Setting::new(scene, time, wavelengths, &streams);
    let mut bundle = setting.from_camera(sights.iter().map(|sight| &sight.ray));
    let mut own = SampledLanes::ZERO;
    let surfaces = first_surfaces(&setting, &mut bundle, light_samples, &mut own);
    for (lane, sight) in sights.iter().enumerate() {
        seen[sight.member].alpha_hit = surfaces.alpha_hit >> lane & 1 == 1;
    }
    let FirstSurfaces { surfaces, .. } = surfaces;
    let firsts = Firsts::new(&setting, &bundle, &surfaces, bundle.alive);
    let mut sharing =
        Sharing { setting: &setting, firsts: &firsts, own, shared: SampledLanes::ZERO, told };
    if bundle.alive != 0 {
        sharing.next_surfaces(bundle.clone());
    }
    for (lane, sight) in sights.iter().enumerate() {
        seen[sight.member].radiance += sharing.own.get(lane) + sharing.shared.get(lane);
    }
}

struct FirstSurfaces<const C: usize> {
    surfaces: Surfaces<C>,
    /// Lanes whose path has met what alpha counts.
    alpha_hit: Mask,
}

/// The first surfaces of the camera rays, with the light that reaches them straight. Where one does not share,
/// its path is followed to its end. Those that share stay alive.
fn first_surfaces<const C: usize>(
    setting: &Setting<C>,
    bundle: &mut Bundle<C>,
    light_samples: u32,
    own: &mut SampledLanes<C>,
) -> FirstSurfaces<C> {
    let Setting { scene, wavelengths, streams, .. } = *setting;
    let sky_covers = scene.limits.sky_covers(scene);
    let mut alpha_hit = if sky_covers { bundle.alive } else { 0 };
    let hits = bundle.advance(setting);
    let gone = bundle.alive & !hits.met;
    bundle.escaped(setting, gone, own);
    scene.paths_ended(PathEnd::Escaped, 1, gone);
    bundle.alive &= hits.met;
    bundle.emitted(setting, &hits, own);
    if bundle.is_last(scene) {
        // What little there is to do is done by each path for itself.
        for lane in lanes_of(bundle.alive) {
            let (hit, ray) = (hits.get(scene, lane), bundle.rays.get(lane));
            let mut path = bundle.path(setting, lane);
            let Some(shading) = path.shade(scene, &ray, &hit, wavelengths, &streams[lane]) else { continue };
            let mut light = Sampled::ZERO;
            if let Some(ray) = path.go_on(scene, &ray, &hit, &shading, wavelengths, &streams[lane], &mut light)
            {
                light += path.follow(scene, ray, wavelengths, &streams[lane]);
            }
            own.set(lane, &(own.get(lane) + light));
            alpha_hit |= Mask::from(path.alpha_hit) << lane;
        }
        bundle.alive = 0;
        return FirstSurfaces { surfaces: Surfaces::new(hits), alpha_hit };
    }
    let surfaces = bundle.shade(setting, hits);
    for lane in lanes_of(surfaces.others & bundle.alive) {
        if surfaces.shares(lane) {
            continue;
        }
        bundle.alive &= !(1 << lane);
        let (light, covers) = bundle.go_on_alone(setting, &surfaces, lane);
        own.set(lane, &(own.get(lane) + light));
        alpha_hit |= Mask::from(covers) << lane;
    }
    alpha_hit |= bundle.alive;
    scene.paths_ended(PathEnd::Absorbed, 1, bundle.alive & !surfaces.scattering());
    bundle.alive &= surfaces.scattering();
    let mut direct = SampledLanes::ZERO;
    for branch in 0..light_samples {
        let u = setting.draw_branch(Dimensions::Light(0), branch);
        direct.add(&bundle.direct_light(setting, &surfaces, &u, bundle.alive));
    }
    direct.add_times(&Sampled::splat(1.0 / f64::from(light_samples)), own);
    FirstSurfaces { surfaces, alpha_hit }
}

/// What a group shares.
struct Sharing<'a, const C: usize, T> {
    setting: &'a Setting<'a, C>,
    firsts: &'a Firsts<'a, C>,
    /// What each pixel has for itself.
    own: SampledLanes<C>,
    /// What it has got of the paths of all.
    shared: SampledLanes<C>,
    told: T,
}

/// A next surface whose suffix is shared, and the first surfaces that see it.
struct Served<const C: usize> {
    owner: usize,
    links: Links<C>,
    /// The density of the next surface, over all first surfaces.
    prior: Sampled<C>,
}

impl<const C: usize, T: FnMut(usize, &SampledLanes<C>)> Sharing<'_, C, T> {
    /// The next surfaces that scattering at the first ones leads to, and what they bring to all of them.
    fn next_surfaces(&mut self, mut bundle: Bundle<C>) {
        let Setting { scene, .. } = *self.setting;
        let surfaces = self.firsts.surfaces;
        let u = self.setting.draw(Dimensions::Scattering(0));
        let scatters = surfaces.sample(&u, bundle.alive);
        bundle.end_absorbed(scene, &scatters);
        for (lane, scatter) in &scatters.apart {
            let light = self.follow_single(&bundle, *lane, scatter);
            self.keep(*lane, light);
        }
        bundle.leave(surfaces, &scatters, scatters.spread);
        let hits = bundle.advance(self.setting);
        for lane in lanes_of(bundle.alive & !hits.met) {
            self.share_environment(lane, bundle.rays.get(lane).direction);
        }
        scene.paths_ended(PathEnd::Escaped, bundle.depth + 1, bundle.alive & !hits.met);
        bundle.alive &= hits.met;
        let mut links: [Option<Links<C>>; LANES] = [const { None }; LANES];
        for lane in lanes_of(hits.on_light & bundle.alive) {
            let (hit, ray) = (hits.get(scene, lane), bundle.rays.get(lane));
            if let Some(light_hit) = hit.on_light().filter(|_| ray.direction.dot(hit.point.normal) < 0.0) {
                let next = Next { owner: lane, direction: ray.direction, point: hit.point };
                let links = links[lane].insert(self.firsts.links(&next));
                let place = scene.texture_point(&hit);
                let nm = &self.setting.wavelengths.nm;
                let radiance = scene.lights.radiance(light_hit.light, &place, nm);
                share_emission(self.setting, self.firsts, &light_hit, links, &radiance, &mut self.shared);
                (self.told)(lane, &self.shared);
            }
        }
        let is_last = bundle.is_last(scene);
        if is_last && !scene.features().transparent_shadows {
            scene.paths_ended(PathEnd::MaxDepth, bundle.depth + 1, bundle.alive);
            return;
        }
        let surfaces = bundle.shade(self.setting, hits);
        for lane in lanes_of(surfaces.others & bundle.alive) {
            let is_turning = surfaces.shading(lane).is_some_and(|shading| shading.turns_with_eye());
            if is_last || is_turning || !surfaces.shares(lane) {
                bundle.alive &= !(1 << lane);
                let (light, _) = bundle.go_on_alone(self.setting, &surfaces, lane);
                self.keep(lane, light);
            }
        }
        if is_last {
            scene.paths_ended(PathEnd::MaxDepth, bundle.depth + 1, bundle.alive);
            return;
        }
        scene.paths_ended(PathEnd::Absorbed, bundle.depth + 1, bundle.alive & !surfaces.scattering());
        bundle.alive &= surfaces.scattering();
        let mut served: SmallVec<[Served<C>; LANES]> = SmallVec::new();
        for owner in lanes_of(bundle.alive) {
            let links = links[owner].take().unwrap_or_else(|| {
                let point = surfaces.hits.point[owner / WIDTH].get(owner);
                self.firsts.links(&Next { owner, direction: bundle.rays.get(owner).direction, point })
            });
            let prior = links.density.sum();
            if prior.hero() > 0.0 {
                served.push(Served { owner, links, prior });
            } else {
                bundle.alive &= !(1 << owner);
                bundle.end(scene, PathEnd::Absorbed, 1 << owner);
            }
        }
        self.light(&bundle, &surfaces, &served);
        self.suffixes(bundle, &surfaces, &served);
    }

    fn keep(&mut self, lane: usize, light: Sampled<C>) {
        self.own.set(lane, &(self.own.get(lane) + light));
    }

    /// Follows a path that leaves its first surface in a single direction.
    fn follow_single(&self, bundle: &Bundle<C>, lane: usize, scatter: &Scatter<C>) -> Sampled<C> {
        let Setting { scene, wavelengths, streams, .. } = *self.setting;
        let surfaces = self.firsts.surfaces;
        let Some(shading) = surfaces.shading(lane) else { return Sampled::ZERO };
        let mut path = bundle.path(self.setting, lane);
        let ray = path.leave(scene, &surfaces.hits.get(scene, lane), shading, scatter);
        path.follow(scene, ray, wavelengths, &streams[lane])
    }

    /// Gives each first surface what comes from beyond the scene in a direction in which one of them
    /// scatters.
    fn share_environment(&mut self, owner: usize, direction: Vec3) {
        let Setting { scene, time, wavelengths, .. } = *self.setting;
        let Some(environment) = scene.lights.environment() else { return };
        let radiance = environment.radiance(direction, &wavelengths.nm);
        if radiance.is_zero() {
            return;
        }
        let links = self.firsts.links_beyond(owner, direction);
        share_light(self.setting, self.firsts, &links, &radiance, &mut self.shared, |from| {
            scene.lights.environment_density(from, direction, time, wavelengths)
        });
        (self.told)(owner, &self.shared);
    }

    /// Gives each first surface the light that reaches the next ones straight from lights.
    fn light(&mut self, bundle: &Bundle<C>, surfaces: &Surfaces<C>, served: &[Served<C>]) {
        let Setting { scene, .. } = *self.setting;
        let u = self.setting.draw(Dimensions::Light(bundle.depth));
        let samples = bundle.light_samples(self.setting, surfaces, &u, bundle.alive);
        let mut arriving = SampledLanes::ZERO;
        let mut values: SmallVec<[(usize, Values<C>); LANES]> = SmallVec::new();
        for (number, Served { owner, links, prior }) in served.iter().enumerate() {
            if samples.found >> owner & 1 == 0 {
                continue;
            }
            let toward_light = samples.rays.direction[owner / WIDTH].get(*owner);
            let value = Values::new(surfaces, *owner, links, toward_light);
            if value.reach(links).is_zero() {
                continue;
            }
            let weight = light_sample_weight(scene, samples.density_of(*owner), prior.sum(), || {
                value.joint(links, *prior).sum()
            });
            if weight != 0.0 {
                arriving.set(*owner, &(samples.radiance.get(*owner) * weight));
                values.push((number, value));
            }
        }
        let wanted = arriving.nonzero();
        bundle.attenuate(self.setting, surfaces, &samples.rays, wanted, &mut arriving);
        for (number, value) in &values {
            let Served { owner, links, .. } = &served[*number];
            let light = arriving.get(*owner);
            if !light.is_zero() {
                value.give(links, &light, &mut self.shared);
                (self.told)(*owner, &self.shared);
            }
        }
    }

    /// Gives each first surface what comes to the next ones along the directions in which these scatter; to
    /// the owner alone what comes in single directions.
    fn suffixes(&mut self, mut bundle: Bundle<C>, surfaces: &Surfaces<C>, served: &[Served<C>]) {
        let Setting { scene, .. } = *self.setting;
        let u = self.setting.draw(Dimensions::Scattering(bundle.depth));
        let scatters = surfaces.sample(&u, bundle.alive);
        bundle.end_absorbed(scene, &scatters);
        for (lane, scatter) in &scatters.apart {
            let light = bundle.scatter_alone(self.setting, surfaces, *lane, scatter, get(&u[3], *lane));
            self.keep(*lane, light);
        }
        // Their paths are not shared: what light subpaths compete for, each has weighed for itself.
        debug_assert!(bundle.contested.is_empty());
        bundle.leave(surfaces, &scatters, scatters.spread);
        bundle.is_shared = true;
        bundle.throughput = SampledLanes::ONE;
        let mut values: SmallVec<[(usize, Values<C>, f64); LANES]> = SmallVec::new();
        for (number, Served { owner, links, prior }) in served.iter().enumerate() {
            let owner = *owner;
            if bundle.alive >> owner & 1 == 0 {
                continue;
            }
            let value = Values::new(surfaces, owner, links, bundle.rays.get(owner).direction);
            // The density of the next surface together with the direction in which the path goes on from it,
            // over all first surfaces.
            let joint = value.joint(links, *prior);
            let suffix = value.reach(links);
            if joint.hero() <= 0.0 || suffix.is_zero() {
                bundle.alive &= !(1 << owner);
                bundle.end_before_next(scene, PathEnd::Absorbed, 1 << owner);
                continue;
            }
            let alive = joint.0.iter().filter(|&&density| density > 0.0).count() as f64;
            set(&mut bundle.prior_throughput, owner, alive * suffix.max() / joint.sum());
            bundle.ratio.set(owner, &(joint / joint.hero()));
            set(&mut bundle.prior_over_density, owner, prior.sum() / joint.hero());
            values.push((number, value, joint.hero()));
        }
        bundle.survive(scene, &u[3]);
        let arriving = bundle.follow(self.setting);
        for (number, value, density) in &values {
            let Served { owner, links, .. } = &served[*number];
            let light = arriving.get(*owner);
            if !light.is_zero() {
                value.give(links, &(light / *density), &mut self.shared);
            }
            for (_, light, from_light) in bundle.contested.iter().filter(|(lane, ..)| lane == owner) {
                for lane in lanes_of(links.linked) {
                    let carried = links.reach.get(lane) * value.f_cos(lane) / *density;
                    let weight = self.weight_beside_light_subpaths(links, lane, *from_light);
                    self.shared.set(lane, &(self.shared.get(lane) + carried * *light * weight));
                }
            }
            (self.told)(*owner, &self.shared);
        }
    }

    /// The weight, beside light subpaths that reach a first surface, of what it gets of a suffix.
    fn weight_beside_light_subpaths(&self, links: &Links<C>, lane: usize, from_light: f64) -> f64 {
        let Setting { scene, time, .. } = *self.setting;
        let Some(caustics) = scene.caustics() else { return 1.0 };
        let leaves = -links.toward_first(lane);
        let density = self.firsts.density_of_direction(lane, leaves) / C as f64;
        let point = self.firsts.receivers.get(lane).point;
        caustics.weight_beside(scene, &FirstSurface { point, leaves, density }, from_light, time)
    }
}

/// Gives each first surface what a light emits toward it that one of them has met.
fn share_emission<const C: usize>(
    setting: &Setting<C>,
    firsts: &Firsts<C>,
    light_hit: &LightHit,
    links: &Links<C>,
    radiance: &Sampled<C>,
    shared: &mut SampledLanes<C>,
) {
    let Setting { scene, time, wavelengths, .. } = *setting;
    share_light(setting, firsts, links, radiance, shared, |from| {
        scene.lights.density(light_hit, from, time, wavelengths)
    });
}

/// Gives each first surface its part of some light that scattering found. It is weighed against light
/// samples, which find it with a density per steradian.
fn share_light<const C: usize>(
    setting: &Setting<C>,
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
        let from = firsts.receivers.get(lane);
        let by_light = by_light(&from);
        let weight = if by_light > 0.0 {
            let choice = PreviousSample::Scattered {
                from,
                prior_over_density: C as f64,
                by_scattering: links.density_of_direction(lane),
            };
            choice.weight_beside_lights(setting.scene, |_| by_light)
        } else {
            1.0
        };
        weights.set(lane, &Sampled::splat(weight));
    }
    links.reach.add_to(&weights, &(*radiance / density), shared);
}
