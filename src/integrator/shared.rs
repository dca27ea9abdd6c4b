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
use super::bundle::{Bundle, Each, Found, Scratch, Turn, follow};
use super::links::{Firsts, Links, Next, Spare, Values};
use super::path::Contested;
use super::plan::{Plan, Sharing};
use super::surfaces::Surfaces;
use super::weights::light_sample_weight;
use crate::accel::Rays;
use crate::camera::LitPoint;
use crate::geometry::Ray;
use crate::lanes::{LANES, Mask, Register, Row, WIDTH, ZERO, get, lanes_of, mask_of, set};
use crate::light::{Environment, LightSamples};
use crate::sampling::{Dimensions, Stream};
use crate::scene::{PathEnd, Scene};
use crate::spectrum::{Sampled, SampledLanes, Wavelengths};
use smallvec::SmallVec;

/// The camera ray of a pixel of a group.
#[derive(Clone, Copy, Debug)]
pub struct Sight<'a> {
    /// Which pixel of the group it is.
    pub member: usize,
    /// The ray, from the sensor into the scene.
    pub ray: Ray,
    /// The place at which it measures irradiance; see [`super::radiance`]. Such rays share nothing.
    pub lit: Option<LitPoint>,
    /// Sample values of the path.
    pub stream: Stream<'a>,
}

/// One sample of each pixel of a group: the camera rays, at most [`LANES`], with what they share.
#[derive(Clone, Copy, Debug)]
pub struct GroupSample<'a, const C: usize> {
    /// The members' camera rays.
    pub sights: &'a [Sight<'a>],
    /// Time, in the scene's unit.
    pub time: f64,
    /// Those of all of them, or where nothing is shared those of each, by the members' numbers.
    pub wavelengths: &'a [Wavelengths<C>],
}

/// Adds to each pixel of a group the spectral radiance along its camera rays, as [`super::radiance`] gives it
/// for one alone: for each sample, by the members' numbers. That several samples are asked for at once makes
/// no difference but in time.
pub fn radiance_of_group<const C: usize>(
    scene: &Scene,
    samples: &[GroupSample<C>],
    plan: Plan,
    seen: &mut [&mut [RadianceSample<C>]],
    workspace: &mut Workspace<C>,
) {
    share(scene, samples, plan, seen, workspace, |_, _| {});
}

/// The parts of what [`radiance_of_group`] gives a pixel: its own, and what comes of the path of each member.
pub fn parts_of_group<const C: usize>(
    scene: &Scene,
    sample: GroupSample<C>,
    plan: Plan,
    member: usize,
) -> (Sampled<C>, Vec<(usize, Sampled<C>)>) {
    let sights = sample.sights;
    let members = 1 + sights.iter().map(|sight| sight.member).max().unwrap_or(0);
    let mut seen = vec![RadianceSample::NOTHING; members.max(member + 1)];
    let (mut parts, mut before) = (Vec::<(usize, Sampled<C>)>::new(), Sampled::ZERO);
    let lane = sights.iter().position(|sight| sight.member == member);
    share(scene, &[sample], plan, &mut [&mut seen], &mut Workspace::default(), |owner, shared| {
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
fn share<'s, const C: usize>(
    scene: &Scene,
    samples: &[GroupSample<'s, C>],
    plan: Plan,
    seen: &mut [&mut [RadianceSample<C>]],
    workspace: &mut Workspace<C>,
    mut told: impl FnMut(usize, &SampledLanes<C>),
) {
    let begun: SmallVec<[usize; TOGETHER]> =
        (0..samples.len()).filter(|&number| !samples[number].sights.is_empty()).collect();
    let turn = |&number: &usize| {
        let GroupSample { sights, time, wavelengths } = samples[number];
        debug_assert!(sights.len() <= LANES);
        // Lanes without a path have the last one's.
        let of_lane = |lane: usize| &sights[lane.min(sights.len() - 1)];
        let streams = std::array::from_fn(|lane| of_lane(lane).stream);
        let wavelengths = match wavelengths {
            [wavelengths] => Each::Same(wavelengths),
            each => Each::Own(std::array::from_fn(|lane| &each[of_lane(lane).member])),
        };
        Turn::new(scene, time, wavelengths, streams)
    };
    // Turns, bundles and what is shared are large, and collecting them copies them once less than pushing.
    let turns: Vec<Turn<C>> = begun.iter().map(turn).collect();
    let Workspace { scratch, surfaces, links, spare } = workspace;
    surfaces.resize_with(turns.len(), Surfaces::new);
    links.resize_with(turns.len(), Vec::new);
    let from_camera = |(turn, &number): (_, &usize)| {
        let rays = samples[number].sights.iter().map(|sight| &sight.ray);
        Bundle::from_camera(scene, turn, number, rays)
    };
    let mut bundles: Vec<Bundle<C>> = turns.iter().zip(&begun).map(from_camera).collect();
    for ((bundle, surfaces), &number) in bundles.iter_mut().zip(surfaces.iter_mut()).zip(&begun) {
        let alpha_hit = first_surfaces(bundle, plan, surfaces, scratch);
        for (lane, sight) in samples[number].sights.iter().enumerate() {
            seen[number][sight.member].alpha_hit = alpha_hit >> lane & 1 == 1;
        }
    }
    let mut give = |number: usize, light: &SampledLanes<C>| {
        for (lane, sight) in samples[number].sights.iter().enumerate() {
            seen[number][sight.member].radiance += light.get(lane);
        }
    };
    if plan.sharing == Sharing::Nothing {
        for (bundle, surfaces) in bundles.iter_mut().zip(surfaces.iter()) {
            bundle.scatter(surfaces);
        }
        let found = follow(bundles, scratch, samples.len());
        begun.iter().for_each(|&number| give(number, &found.arriving[number]));
        return;
    }
    begun.iter().zip(&bundles).for_each(|(&number, bundle)| give(number, &bundle.arriving));
    let sharing: SmallVec<[usize; TOGETHER]> =
        (0..bundles.len()).filter(|&turn| bundles[turn].alive != 0).collect();
    let firsts =
        |&turn: &usize| Firsts::new(scene, &turns[turn], &bundles[turn], &surfaces[turn], plan.sharing);
    let firsts: Vec<Firsts<C>> = sharing.iter().map(firsts).collect();
    let with_links = firsts.iter().zip(links).map(|(firsts, links)| SharedSample::new(firsts, links));
    let mut groups: Vec<SharedSample<C>> = with_links.collect();
    let mut suffixes = Vec::with_capacity(groups.len());
    for group in &mut groups {
        group.next_surfaces(scratch, spare, &mut suffixes, &mut told);
    }
    let found = follow(suffixes, scratch, samples.len());
    for (group, &turn) in groups.iter_mut().zip(&sharing) {
        group.share_suffixes(begun[turn], &found, spare, &mut told);
        give(begun[turn], &group.own);
        give(begun[turn], &group.shared);
    }
}

/// What is filled anew for each group, and too large to ask for memory each time.
pub struct Workspace<const C: usize> {
    scratch: Scratch<C>,
    /// First surfaces, and links to next ones, by sample.
    surfaces: Vec<Surfaces<C>>,
    links: Vec<Vec<Links<C>>>,
    spare: Spare<C>,
}

impl<const C: usize> Default for Workspace<C> {
    fn default() -> Self {
        Self { scratch: Scratch::new(), surfaces: Vec::new(), links: Vec::new(), spare: Vec::new() }
    }
}

/// Samples of a group that are usually worked on together.
pub const TOGETHER: usize = 4;

/// The first surfaces of the camera rays, with the light that reaches them straight. Where one does not
/// share, its path is followed to its end. Those that share stay alive. The lanes whose path has met what
/// alpha counts.
fn first_surfaces<const C: usize>(
    bundle: &mut Bundle<C>,
    plan: Plan,
    surfaces: &mut Surfaces<C>,
    scratch: &mut Scratch<C>,
) -> Mask {
    let scene = bundle.scene();
    let mut alpha_hit = if scene.limits.sky_covers(scene) { bundle.alive } else { 0 };
    bundle.advance(&mut surfaces.hits);
    bundle.escape(&surfaces.hits);
    bundle.emit(&surfaces.hits);
    if bundle.alive == 0 {
        return alpha_hit;
    }
    if bundle.is_last() {
        // What little there is to do is done by each path for itself.
        for lane in lanes_of(bundle.alive) {
            let (light, covers) = bundle.end_alone(&surfaces.hits, lane);
            bundle.arrives(lane, light);
            alpha_hit |= Mask::from(covers) << lane;
        }
        bundle.alive = 0;
        return alpha_hit;
    }
    alpha_hit |= bundle.alive;
    bundle.shade(surfaces);
    let light_tracing = scene.features().caustics;
    for lane in lanes_of(surfaces.others & bundle.alive) {
        if let Some(mirror) = surfaces.take_mirror(lane) {
            let light = bundle.follow_mirror(surfaces, lane, &mirror);
            bundle.arrives(lane, light);
        }
        let stays = match plan.sharing {
            Sharing::Nothing => surfaces.goes_along(lane, light_tracing),
            _ => surfaces.shares(lane),
        };
        if !stays {
            let (light, covers) = bundle.go_on_alone(surfaces, lane);
            bundle.arrives(lane, light);
            alpha_hit &= !(Mask::from(!covers) << lane);
        }
    }
    for branch in 0..plan.light_samples {
        let u = bundle.draw_branch(Dimensions::Light(0), branch);
        bundle.direct_light(surfaces, &u, 1.0 / f64::from(plan.light_samples), &mut scratch.samples);
    }
    alpha_hit
}

/// What comes from beyond the scene in the direction in which an owner scatters: its number, the radiance,
/// and the density with which light samples look there.
type Beyond<const C: usize> = (usize, Sampled<C>, f64);

/// What scattering at first surfaces has led to.
struct NextMet {
    /// The rays to the next surfaces.
    rays: Rays,
    /// Those that meet none.
    gone: Mask,
    /// Those that meet a light from its front.
    lit: Mask,
}

/// Scatters paths at their first surfaces, and follows them to the next ones. Those that do not share there
/// are followed to their ends.
fn meet_next<'a, const C: usize>(
    firsts: &Firsts<'a, C>,
    bundle: &mut Bundle<'a, C>,
    surfaces: &mut Surfaces<C>,
) -> NextMet {
    let scene = firsts.scene;
    bundle.arriving = SampledLanes::ZERO;
    let scatters = firsts.surfaces.sample(&bundle.draw(Dimensions::Scattering(0)), bundle.alive);
    bundle.end_absorbed(&scatters);
    for (lane, scatter) in &scatters.apart {
        let light = bundle.follow_single(firsts.surfaces, *lane, scatter);
        bundle.arrives(*lane, light);
    }
    bundle.leave(firsts.surfaces, &scatters);
    bundle.advance(&mut surfaces.hits);
    let (rays, gone) = (bundle.rays.clone(), bundle.alive & !surfaces.hits.met);
    bundle.end(PathEnd::Escaped, gone);
    bundle.alive &= !gone;
    let faces = |&lane: &usize| {
        let normal = surfaces.hits.point[lane / WIDTH].get(lane).normal;
        rays.direction[lane / WIDTH].get(lane).dot(normal) < 0.0
    };
    let on_light = lanes_of(surfaces.hits.on_light & bundle.alive);
    let lit = mask_of(on_light.filter(faces));
    let is_last = bundle.is_last();
    if !is_last || scene.goes_on_past_last() {
        bundle.shade(surfaces);
        for lane in lanes_of(surfaces.others & bundle.alive) {
            let is_turning = surfaces.shading(lane).is_some_and(|shading| shading.turns_with_eye());
            if is_last || is_turning || !surfaces.shares(lane) {
                let (light, _) = bundle.go_on_alone(surfaces, lane);
                bundle.arrives(lane, light);
            }
        }
    }
    if is_last {
        bundle.stop();
    }
    NextMet { rays, gone, lit }
}

/// What a group shares of one sample.
struct SharedSample<'a, const C: usize> {
    firsts: &'a Firsts<'a, C>,
    /// What each pixel has for itself of what it has met after its first surface.
    own: SampledLanes<C>,
    /// What it has got of the paths of all.
    shared: SampledLanes<C>,
    /// The first surfaces that see each next one, by its owner.
    links: &'a mut [Links<C>],
    /// Suffixes that are shared, by their owners: how the next surface scatters toward the first ones, and
    /// the density of the hero.
    suffixes: SmallVec<[(usize, Values<C>, f64); LANES]>,
}

impl<'a, const C: usize> SharedSample<'a, C> {
    fn new(firsts: &'a Firsts<'a, C>, links: &'a mut Vec<Links<C>>) -> Self {
        links.resize_with(LANES, || Links::NONE);
        Self { firsts, own: SampledLanes::ZERO, shared: SampledLanes::ZERO, links, suffixes: SmallVec::new() }
    }

    /// The next surfaces that scattering at the first ones leads to, and what they bring to all of them but
    /// for their suffixes, which go on from there.
    fn next_surfaces(
        &mut self,
        scratch: &mut Scratch<C>,
        spare: &mut Spare<C>,
        suffixes: &mut Vec<Bundle<'a, C>>,
        told: &mut impl FnMut(usize, &SampledLanes<C>),
    ) {
        suffixes.extend_from_slice(std::slice::from_ref(self.firsts.bundle));
        let Some(bundle) = suffixes.last_mut() else { return };
        let Scratch { surfaces, samples } = scratch;
        let NextMet { rays, gone, lit } = meet_next(self.firsts, bundle, surfaces);
        let beyond = self.beyond(gone, &rays);
        self.link(&beyond, lit | bundle.alive, &rays, surfaces);
        self.share_emission(&beyond, lit, surfaces, told);
        if bundle.is_last() {
            self.own.add(&bundle.arriving);
            suffixes.truncate(suffixes.len() - 1);
            return;
        }
        let priors = self.priors(bundle);
        self.light(bundle, surfaces, &priors, samples, spare, told);
        self.begin_suffixes(bundle, surfaces, &priors, spare);
        self.own.add(&bundle.arriving);
        bundle.arriving = SampledLanes::ZERO;
    }

    /// Finds which first surfaces see which next ones, by the owners of these, and which see out of the scene
    /// along which rays.
    fn link(&mut self, beyond: &[Beyond<C>], next: Mask, rays: &Rays, surfaces: &Surfaces<C>) {
        let firsts = self.firsts;
        for &(owner, ..) in beyond {
            firsts.aim_beyond(owner, rays.get(owner).direction, &mut self.links[owner]);
        }
        for owner in lanes_of(next) {
            let point = surfaces.hits.point[owner / WIDTH].get(owner);
            let direction = rays.direction[owner / WIDTH].get(owner);
            let shading_normal = surfaces.hits.shading_normal[owner / WIDTH].get(owner);
            let facet = get(surfaces.hits.facet(), owner);
            firsts.aim(&Next { owner, direction, point, shading_normal, facet }, &mut self.links[owner]);
        }
        let owners = next | mask_of(beyond.iter().map(|&(owner, ..)| owner));
        firsts.hide(self.links, owners);
        lanes_of(owners).for_each(|owner| firsts.weigh(&mut self.links[owner]));
    }

    /// Gives each first surface what comes along the links from beyond the scene, and from the next surfaces
    /// that are lit: those that emit toward the path that met them.
    fn share_emission(
        &mut self,
        beyond: &[Beyond<C>],
        lit: Mask,
        surfaces: &Surfaces<C>,
        told: &mut impl FnMut(usize, &SampledLanes<C>),
    ) {
        let firsts = self.firsts;
        let scene = firsts.scene;
        let probability = if beyond.is_empty() { ZERO } else { self.environment_probabilities() };
        for (owner, radiance, density) in beyond {
            let by_light = probability.map(|probability| Register::splat(*density) * probability);
            self.share_environment(*owner, radiance, &by_light);
            told(*owner, &self.shared);
        }
        for owner in lanes_of(lit) {
            let hit = surfaces.hits.get(scene, owner);
            let Some(light_hit) = hit.on_light() else { continue };
            let (lights, links, nm) = (&scene.lights, &self.links[owner], &firsts.wavelengths().nm);
            let radiance = lights.radiance(light_hit.light, &scene.texture_point(&hit), nm);
            let by_light = lights.densities(&light_hit, &firsts.lit(links.linked));
            share_light(firsts, links, &radiance, &mut self.shared, &by_light);
            told(owner, &self.shared);
        }
    }

    /// The next surfaces by their owners, with their densities over all first surfaces. Paths end at those
    /// that have none.
    fn priors(&self, bundle: &mut Bundle<C>) -> SmallVec<[(usize, Sampled<C>); LANES]> {
        let mut priors = SmallVec::new();
        for owner in lanes_of(bundle.alive) {
            let prior = self.links[owner].density.sum();
            if prior.hero() > 0.0 {
                priors.push((owner, prior));
            } else {
                bundle.end(PathEnd::Absorbed, 1 << owner);
                bundle.alive &= !(1 << owner);
            }
        }
        priors
    }

    /// What comes from beyond the scene along the rays that meet no surface, where anything does, with the
    /// density of light samples there.
    fn beyond(&self, gone: Mask, rays: &Rays) -> SmallVec<[Beyond<C>; LANES]> {
        let Some(environment) = self.firsts.scene.lights.environment() else { return SmallVec::new() };
        let seen = environment.seen_in_lanes(&rays.direction, gone, |_| self.firsts.wavelengths());
        let of_owner = |owner: usize| (owner, seen.radiance.get(owner), get(&seen.density, owner));
        lanes_of(gone).map(of_owner).filter(|(_, radiance, _)| !radiance.is_zero()).collect()
    }

    /// Gives each first surface what comes from beyond the scene in a direction in which one of them, the
    /// owner, scatters. `by_light`: density of light samples that go there.
    fn share_environment(&mut self, owner: usize, radiance: &Sampled<C>, by_light: &Row) {
        let (firsts, links) = (self.firsts, &self.links[owner]);
        if let Some(Environment::Constant(_)) = firsts.scene.lights.environment() {
            // No light sample looks for it.
            let density = links.density.sum().sum();
            if density > 0.0 {
                links.reach.add_times(&(*radiance / density), &mut self.shared);
            }
            return;
        }
        share_light(firsts, links, radiance, &mut self.shared, by_light);
    }

    /// The probabilities with which light samples of the first surfaces go to the environment.
    fn environment_probabilities(&self) -> Row {
        let lights = &self.firsts.scene.lights;
        match lights.environment() {
            Some(environment) if environment.is_sampled() => {
                lights.environment_probabilities(&self.firsts.lit(self.firsts.all))
            }
            _ => ZERO,
        }
    }

    /// Gives each first surface the light that reaches the next ones straight from lights. `priors`: the next
    /// ones, by their owners, with their densities.
    fn light(
        &mut self,
        bundle: &Bundle<C>,
        surfaces: &Surfaces<C>,
        priors: &[(usize, Sampled<C>)],
        samples: &mut LightSamples<C>,
        spare: &mut Spare<C>,
        told: &mut impl FnMut(usize, &SampledLanes<C>),
    ) {
        bundle.sample_lights(surfaces, &bundle.draw(Dimensions::Light(bundle.depth)), samples);
        let mut arriving = SampledLanes::ZERO;
        let mut values: SmallVec<[(usize, Values<C>); LANES]> = SmallVec::new();
        for &(owner, prior) in priors {
            if samples.found >> owner & 1 == 0 {
                continue;
            }
            let links = &self.links[owner];
            let toward_light = samples.rays.direction[owner / WIDTH].get(owner);
            let value = Values::new(surfaces, owner, links, toward_light, spare);
            if value.reach(links).is_zero() {
                value.end(spare);
                continue;
            }
            let density = samples.density_of(owner);
            let weight = light_sample_weight(self.firsts.scene, density, prior.sum(), || {
                value.joint(links, prior).sum()
            });
            if weight != 0.0 {
                arriving.set(owner, &(samples.radiance.get(owner) * weight));
                values.push((owner, value));
            } else {
                value.end(spare);
            }
        }
        let wanted = arriving.nonzero();
        bundle.attenuate(surfaces, samples, wanted, &mut arriving);
        for (owner, value) in values {
            let light = arriving.get(owner);
            if !light.is_zero() {
                match bundle.contest_of_sample(surfaces, owner, samples) {
                    Some((from_light, by_light)) => {
                        let contested = Contested { light, from_light, by_light };
                        self.firsts.give(&self.links[owner], &value, &contested, &mut self.shared);
                    }
                    None => value.give(&self.links[owner], &light, &mut self.shared),
                }
                told(owner, &self.shared);
            }
            value.end(spare);
        }
    }

    /// Begins what comes to the next ones along the directions in which these scatter. What comes in single
    /// directions is the owner's alone.
    fn begin_suffixes(
        &mut self,
        bundle: &mut Bundle<C>,
        surfaces: &Surfaces<C>,
        priors: &[(usize, Sampled<C>)],
        spare: &mut Spare<C>,
    ) {
        let u = bundle.draw(Dimensions::Scattering(bundle.depth));
        let competes = |&owner: &usize| bundle.competes_from(&surfaces.hits, owner);
        let competing = mask_of(lanes_of(bundle.alive).filter(competes));
        let scatters = surfaces.sample(&u, bundle.alive);
        bundle.end_absorbed(&scatters);
        for (lane, scatter) in &scatters.apart {
            let light = bundle.scatter_alone(surfaces, *lane, scatter, get(&u[3], *lane));
            bundle.arrives(*lane, light);
        }
        bundle.leave(surfaces, &scatters);
        bundle.is_shared = true;
        bundle.competing = competing;
        bundle.throughput = SampledLanes::ONE;
        for &(owner, prior) in priors.iter().filter(|(owner, _)| scatters.spread >> owner & 1 == 1) {
            let links = &self.links[owner];
            let value = Values::new(surfaces, owner, links, bundle.rays.get(owner).direction, spare);
            // The density of the next surface together with the direction in which the path goes on from it,
            // over all first surfaces.
            let joint = value.joint(links, prior);
            let suffix = value.reach(links);
            if joint.hero() <= 0.0 || suffix.is_zero() {
                bundle.end_before_next(PathEnd::Absorbed, 1 << owner);
                bundle.alive &= !(1 << owner);
                value.end(spare);
                continue;
            }
            let alive = joint.0.iter().filter(|&&density| density > 0.0).count() as f64;
            set(&mut bundle.prior_throughput, owner, alive * suffix.max() / joint.sum());
            bundle.ratio.set(owner, &(joint / joint.hero()));
            set(&mut bundle.prior_over_density, owner, prior.sum() / joint.hero());
            self.suffixes.push((owner, value, joint.hero()));
        }
        bundle.survive(&u[3]);
    }

    /// Gives each first surface what the suffixes have found. `number`: of the sample.
    fn share_suffixes(
        &mut self,
        number: usize,
        found: &Found<C>,
        spare: &mut Spare<C>,
        told: &mut impl FnMut(usize, &SampledLanes<C>),
    ) {
        for (owner, value, density) in self.suffixes.drain(..) {
            let links = &self.links[owner];
            let light = found.arriving[number].get(owner);
            if !light.is_zero() {
                value.give(links, &(light / density), &mut self.shared);
            }
            let is_own =
                |contested: &&(usize, usize, Contested<C>)| (contested.0, contested.1) == (number, owner);
            for (_, _, contested) in found.contested.iter().filter(is_own) {
                let light = contested.light / density;
                let contested = Contested { light, ..*contested };
                self.firsts.give(links, &value, &contested, &mut self.shared);
            }
            told(owner, &self.shared);
            value.end(spare);
        }
    }
}

/// Gives each first surface its part of some light that scattering found. It is weighed against light
/// samples, which find it with a density per steradian.
fn share_light<const C: usize>(
    firsts: &Firsts<C>,
    links: &Links<C>,
    radiance: &Sampled<C>,
    shared: &mut SampledLanes<C>,
    by_light: &Row,
) {
    let density = links.density.sum().sum();
    if density <= 0.0 {
        return;
    }
    let weights = firsts.weights_beside_lights(links, by_light);
    links.reach.add_weighted(&weights, &(*radiance / density), shared);
}
