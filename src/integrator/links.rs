//! Which first surfaces of a group see a next one, and what each of them gets of it. Each first surface has a
//! lane.

use super::bundle::{Bundle, Turn};
use super::caustics::FirstSurface;
use super::path::Contested;
use super::plan::Sharing;
use super::surfaces::{Evaluations, Surfaces};
use super::weights::scattering_weight;
use crate::accel::{Fan, Rays, Target};
use crate::bsdf::Evaluation;
use crate::geometry::{Ray, SurfacePoint, Vec3};
use crate::lanes::{
    self, ALL, LANES, Mask, REGISTERS, Register, Row, Truth, Vec3Lanes, WIDTH, lanes_of, mask_of, part,
};
use crate::light::{Lit, Receivers};
use crate::scene::{RayKind, Scene};
use crate::spectrum::{Sampled, SampledLanes, Wavelengths};
use std::f64::consts::FRAC_1_PI;

/// The first surfaces of a group.
pub(super) struct Firsts<'a, const C: usize> {
    pub scene: &'a Scene,
    pub turn: &'a Turn<'a, C>,
    /// The paths as they come to the surfaces.
    pub bundle: &'a Bundle<'a, C>,
    pub surfaces: &'a Surfaces<C>,
    /// Those that share.
    pub all: Mask,
    pub receivers: Receivers<'a>,
    sharing: Sharing,
    fan: Fan<'a>,
    /// Throughput · reflectance of diffuse ones: value and density are this / π and 1 / π, times the cosine
    /// at the normal.
    reflected: SampledLanes<C>,
}

/// A next surface, or a place beyond the scene, and how it was found.
#[derive(Clone, Copy)]
pub(super) struct Next {
    /// By which of the first surfaces.
    pub owner: usize,
    /// In which direction from there.
    pub direction: Vec3,
    pub point: SurfacePoint,
    /// The normal that it scatters by.
    pub shading_normal: Vec3,
    /// See [`Target::facet`].
    pub facet: f64,
}

/// Where links lead to.
#[derive(Clone, Copy)]
enum LinkEnd {
    /// A next surface, and its facet.
    At(SurfacePoint, f64),
    /// Out of the scene.
    Beyond(Vec3),
}

impl LinkEnd {
    /// The way there from a first surface.
    fn way_from(&self, point: &SurfacePoint) -> Option<Ray> {
        match self {
            Self::At(target, _) => point.segment_to(target),
            Self::Beyond(direction) => Some(point.ray(*direction)),
        }
    }
}

/// From the first surfaces to a next one that they see.
pub(super) struct Links<const C: usize> {
    /// The first surface that sampled the next one.
    owner: usize,
    end: LinkEnd,
    /// The first surfaces that see the next one and may get anything of it, or sample it.
    pub linked: Mask,
    /// Those of them that it is asked one by one what is on the way.
    unsure: Mask,
    /// The density of diffuse surfaces.
    share: Row,
    toward_first: [Vec3Lanes; REGISTERS],
    /// The solid angle of a unit of area of the next surface.
    geometry: Row,
    /// What of the radiance of the next surface the sensor gets per unit of its area: throughput · f · G ·
    /// transmittance.
    pub reach: SampledLanes<C>,
    /// Density with which the first surface samples the next one, per unit of its area, for each wavelength
    /// as the hero.
    pub density: SampledLanes<C>,
}

impl<const C: usize> Links<C> {
    pub const NONE: Self = Self {
        owner: 0,
        end: LinkEnd::Beyond(Vec3::ZERO),
        linked: 0,
        unsure: 0,
        share: lanes::ZERO,
        toward_first: [Vec3Lanes::ZERO; REGISTERS],
        geometry: lanes::ZERO,
        reach: SampledLanes::ZERO,
        density: SampledLanes::ZERO,
    };
}

/// How a next surface scatters light from a direction toward each of the first surfaces.
pub(super) enum Values<const C: usize> {
    /// It is diffuse.
    Same(Evaluation<C>),
    Each(Box<Evaluations<C>>),
}

/// Memory for values that are no longer needed: they are many, and asking for it takes time.
pub(super) type Spare<const C: usize> = Vec<Box<Evaluations<C>>>;

impl<'a, const C: usize> Firsts<'a, C> {
    pub fn new(
        scene: &'a Scene,
        turn: &'a Turn<'a, C>,
        bundle: &'a Bundle<'a, C>,
        surfaces: &'a Surfaces<C>,
        sharing: Sharing,
    ) -> Self {
        let mut reflected = surfaces.reflectance.clone();
        for (reflected, throughput) in reflected.0.iter_mut().zip(&bundle.throughput.0) {
            for register in 0..REGISTERS {
                reflected[register] *= throughput[register];
            }
        }
        let (all, receivers) = (bundle.alive, surfaces.receivers());
        let fan = scene.fan(&surfaces.hits.point, surfaces.hits.facet(), all);
        Self { scene, turn, bundle, surfaces, all, receivers, sharing, fan, reflected }
    }

    /// Those of the group.
    pub fn wavelengths(&self) -> &'a Wavelengths<C> {
        self.turn.wavelengths(0)
    }

    /// The first surfaces as they ask for light.
    pub fn lit(&self, asked: Mask) -> Lit<'_, impl Fn(usize) -> &'a Wavelengths<C> + use<'_, 'a, C>, C> {
        let (turn, wavelengths) = (self.turn, self.wavelengths());
        let wavelengths = move |_: usize| wavelengths;
        Lit { from: self.receivers, time: turn.time, wavelengths, light: &turn.lamp_light, asked }
    }

    /// Gives each first surface its part of light that light subpaths compete for.
    pub fn give(
        &self,
        links: &Links<C>,
        value: &Values<C>,
        contested: &Contested<C>,
        shared: &mut SampledLanes<C>,
    ) {
        let &Contested { light, from_light, by_light } = contested;
        for lane in lanes_of(links.linked) {
            let by_scattering = || value.density(lane).sum() / C as f64;
            let by_scattering = scattering_weight(self.scene, || by_light, by_scattering);
            let ratio = from_light * by_scattering.sqrt();
            let weight = self.weight_beside_light_subpaths(links, lane, ratio);
            let carried = links.reach.get(lane) * value.f_cos(lane) * light;
            shared.set(lane, &(shared.get(lane) + carried * weight));
        }
    }

    /// The weight, beside light subpaths that reach a first surface, of what it gets of a suffix.
    fn weight_beside_light_subpaths(&self, links: &Links<C>, lane: usize, from_light: f64) -> f64 {
        let Some(caustics) = self.scene.caustics() else { return 1.0 };
        let leaves = -links.toward_first(lane);
        let density = self.density_of_direction(lane, leaves) / C as f64;
        let first = FirstSurface { point: self.receivers.get(lane).point, leaves, density };
        // As many camera paths may find it as share.
        let ratio = from_light / f64::from(self.sharing.pixels());
        caustics.weight_beside(self.scene, &first, ratio, self.turn.time)
    }

    /// The weights of light that scattering found along the links, beside light samples that find it with a
    /// density per steradian.
    pub fn weights_beside_lights(&self, links: &Links<C>, by_light: &Row) -> Row {
        std::array::from_fn(|register| {
            let by_scattering = || {
                let mut sum = Register::ZERO;
                for density in &links.density.0 {
                    sum += density[register] / links.geometry[register];
                }
                sum
            };
            let by_light = || Register::splat(C as f64) * by_light[register];
            let weight = scattering_weight(self.scene, by_light, by_scattering);
            Truth::of(part(links.linked, register)).only(weight)
        })
    }

    /// The density with which a first surface scatters in a direction, over the wavelengths as the hero.
    fn density_of_direction(&self, lane: usize, direction: Vec3) -> f64 {
        let toward = [Vec3Lanes::of(direction); REGISTERS];
        self.surfaces.evaluate(&toward, 1 << lane).density.get(lane).sum()
    }

    /// The first surfaces that might see a next one.
    pub fn aim(&self, next: &Next, links: &mut Links<C>) {
        let target = &next.point;
        let (position, normal) = (Vec3Lanes::of(target.position), Vec3Lanes::of(target.normal));
        let side = Register::splat(next.direction.dot(target.normal));
        let shading_normal = Vec3Lanes::of(next.shading_normal);
        let shading_side = Register::splat(next.direction.dot(next.shading_normal));
        let mut toward_first = [Vec3Lanes::ZERO; REGISTERS];
        // Geometry factors |cos| / d² at the next surface, and for diffuse surfaces times cos / π.
        let (mut geometry, mut share): (Row, Row) = (lanes::ZERO, lanes::ZERO);
        let (mut facing, mut linked) = (0, 0);
        for register in 0..REGISTERS {
            let between = position - self.fan.positions(register);
            let squared = between.length_squared();
            let direction = between * (Register::ONE / squared.sqrt());
            let cos = direction.dot(normal);
            geometry[register] = cos.abs() / squared;
            // The other side of a surface is another one, by either normal: how it scatters is chosen by the
            // side of its shading normal.
            let faces = (cos * side).simd_gt(Register::ZERO)
                & (direction.dot(shading_normal) * shading_side).simd_gt(Register::ZERO)
                & geometry[register].simd_lt(Register::splat(f64::INFINITY));
            let near = direction.dot(self.surfaces.normal[register]);
            share[register] = near * Register::splat(FRAC_1_PI) * geometry[register];
            facing |= faces.to_bitmask() << (WIDTH * register);
            linked |= (faces & near.simd_gt(Register::ZERO)).to_bitmask() << (WIDTH * register);
            toward_first[register] = -direction;
        }
        (links.owner, links.end) = (next.owner, LinkEnd::At(*target, next.facet));
        (links.toward_first, links.geometry, links.share) = (toward_first, geometry, share);
        self.evaluate(facing, linked, links);
    }

    /// The first surfaces that might see the environment in a direction that one of them, the owner, has
    /// sampled. Densities and geometry are per steradian.
    pub fn aim_beyond(&self, owner: usize, direction: Vec3, links: &mut Links<C>) {
        let toward = Vec3Lanes::of(direction);
        let (mut share, mut linked) = (lanes::ZERO, 0);
        for (register, share) in share.iter_mut().enumerate() {
            let cos = toward.dot(self.surfaces.normal[register]);
            *share = cos * Register::splat(FRAC_1_PI);
            linked |= cos.simd_gt(Register::ZERO).to_bitmask() << (WIDTH * register);
        }
        (links.owner, links.end) = (owner, LinkEnd::Beyond(direction));
        (links.toward_first, links.geometry, links.share) =
            ([-toward; REGISTERS], [Register::ONE; REGISTERS], share);
        self.evaluate(ALL, linked, links);
    }

    /// Values and densities of rough first surfaces. `facing`: those on the right side of the place.
    /// `linked`: those for which it is on the right side, if they are diffuse.
    fn evaluate(&self, facing: Mask, linked: Mask, links: &mut Links<C>) {
        let partners = self.all & self.sharing.partners(links.owner);
        links.linked = linked & self.surfaces.diffuse & partners;
        let rough = facing & partners & self.surfaces.others;
        if rough == 0 {
            (links.reach, links.density) = (SampledLanes::ZERO, SampledLanes::ZERO);
            return;
        }
        let values = self.surfaces.evaluate(&links.toward_first.map(|direction| -direction), rough);
        links.linked |= rough & (values.f_cos.nonzero() | values.density.nonzero());
        for wavelength in 0..C {
            for register in 0..REGISTERS {
                let (f_cos, density) =
                    (values.f_cos.0[wavelength][register], values.density.0[wavelength][register]);
                let throughput = self.bundle.throughput.0[wavelength][register];
                links.reach.0[wavelength][register] = throughput * f_cos * links.geometry[register];
                links.density.0[wavelength][register] = density * links.geometry[register];
            }
        }
    }

    /// Takes those out of the links of some owners that an opaque surface surely hides. What sampled a place
    /// sees it.
    pub fn hide(&self, links: &mut [Links<C>], owners: Mask) {
        let features = self.scene.features();
        if features.interface_events() && features.absorption {
            lanes_of(owners).for_each(|owner| links[owner].unsure = ALL);
            return;
        }
        let mut hidden = [0; LANES];
        if !self.fan.is_at_once() && !features.absorption {
            self.hidden_from_each(links, owners, &mut hidden);
        } else {
            let (scene, time) = (self.scene, self.turn.time);
            for owner in lanes_of(owners) {
                let links = &links[owner];
                let asked = links.linked & !(1 << owner);
                hidden[owner] = match &links.end {
                    LinkEnd::At(point, facet) => {
                        scene.blocked(&self.fan, &Target { point, facet: *facet }, time, asked)
                    }
                    LinkEnd::Beyond(direction) => self.hidden_beyond(*direction, asked),
                };
            }
        }
        for owner in lanes_of(owners) {
            let links = &mut links[owner];
            if features.interface_events() {
                // What is in the way may be no surface.
                links.unsure = hidden[owner];
            } else {
                links.linked &= !hidden[owner];
                links.unsure = if features.absorption { ALL } else { 0 };
            }
        }
    }

    /// The first surfaces that surely do not see out of the scene.
    fn hidden_beyond(&self, direction: Vec3, asked: Mask) -> Mask {
        let (scene, time) = (self.scene, self.turn.time);
        if !scene.features().absorption {
            let toward = Vec3Lanes::of(direction);
            let mut rays = Rays::NONE;
            for (register, points) in self.surfaces.hits.point.iter().enumerate() {
                rays.origin[register] = points.leave(toward);
                rays.direction[register] = toward;
            }
            rays.leaves = *self.surfaces.hits.facet();
            return scene.occluded_in_lanes(RayKind::Shared, &rays, time, asked);
        }
        let sees = |lane: &usize| {
            let (ray, media) = (self.fan.point(*lane).ray(direction), self.bundle.media(*lane));
            !scene.transmittance_between_surfaces(&ray, time, &media.here, self.wavelengths()).is_zero()
        };
        asked & !mask_of(lanes_of(asked).filter(sees))
    }

    /// The same, with all rays of a first surface at once: the boxes around it are in the way of all of them.
    fn hidden_from_each(&self, links: &[Links<C>], owners: Mask, hidden: &mut [Mask; LANES]) {
        for lane in lanes_of(self.all) {
            let point = self.fan.point(lane);
            let (mut rays, mut asked) = ([Ray::NOWHERE; LANES], 0);
            for owner in lanes_of(owners & !(1 << lane)) {
                let links = &links[owner];
                if links.linked >> lane & 1 == 0 {
                    continue;
                }
                match links.end.way_from(&point) {
                    Some(ray) => (rays[owner], asked) = (ray, asked | 1 << owner),
                    None => hidden[owner] |= 1 << lane,
                }
            }
            let occluded = self.scene.occluded_together(RayKind::Shared, &rays, self.turn.time, asked);
            lanes_of(occluded).for_each(|owner| hidden[owner] |= 1 << lane);
        }
    }

    /// Values and densities of what is left.
    pub fn weigh(&self, links: &mut Links<C>) {
        for register in 0..REGISTERS {
            let diffuse = part(self.surfaces.diffuse, register);
            let share = Truth::of(part(links.linked, register) & diffuse).only(links.share[register]);
            let rough = Truth::of(part(links.linked, register) & !diffuse);
            for wavelength in 0..C {
                let reach = &mut links.reach.0[wavelength][register];
                *reach = rough.only(*reach) + self.reflected.0[wavelength][register] * share;
                let density = &mut links.density.0[wavelength][register];
                *density = rough.only(*density) + share;
            }
        }
        self.attenuate(links);
    }

    /// Takes account of what is on the way but for opaque surfaces.
    fn attenuate(&self, links: &mut Links<C>) {
        let (scene, time, wavelengths) = (self.scene, self.turn.time, self.wavelengths());
        let features = scene.features();
        for lane in lanes_of(links.linked & links.unsure) {
            let media = &self.bundle.media(lane).here;
            let point = self.fan.point(lane);
            let between = match links.end.way_from(&point) {
                Some(ray) if !features.interface_events() => {
                    scene.transmittance(media, &ray, wavelengths).unwrap_or(Sampled::ONE)
                }
                Some(ray) => scene.transmittance_between_surfaces(&ray, time, media, wavelengths),
                None => Sampled::ZERO,
            };
            if between != Sampled::ONE {
                links.reach.set(lane, &(links.reach.get(lane) * between));
            }
            if between.is_zero() && lane != links.owner {
                links.linked &= !(1 << lane);
                links.density.set(lane, &Sampled::ZERO);
            }
        }
    }
}

impl<const C: usize> Links<C> {
    /// From the next surface to a first one.
    pub fn toward_first(&self, lane: usize) -> Vec3 {
        self.toward_first[lane / WIDTH].get(lane)
    }
}

impl<const C: usize> Values<C> {
    /// How the surface that a lane has met scatters it. `spare`: what [`Self::Each`] may be written over.
    pub fn new(
        surfaces: &Surfaces<C>,
        lane: usize,
        links: &Links<C>,
        toward_light: Vec3,
        spare: &mut Spare<C>,
    ) -> Self {
        if surfaces.metals.lanes >> lane & 1 == 1 {
            let mut values = Self::empty(spare);
            let toward_light = [Vec3Lanes::of(toward_light); REGISTERS];
            let metal = surfaces.metals.of_lane(lane);
            metal.evaluate_from(&links.toward_first, &toward_light, links.linked, &mut values);
            return Self::Each(values);
        }
        let Some(shading) = surfaces.shading(lane) else {
            let cos = surfaces.normal[lane / WIDTH % REGISTERS].get(lane).dot(toward_light);
            if surfaces.diffuse >> lane & 1 == 0 || cos <= 0.0 {
                return Self::Same(Evaluation::ZERO);
            }
            let density = cos * FRAC_1_PI;
            let f_cos = surfaces.reflectance.get(lane) * density;
            return Self::Same(Evaluation { f_cos, density: Sampled::splat(density) });
        };
        if shading.is_diffuse() {
            return Self::Same(shading.evaluate(toward_light));
        }
        let mut values = Self::empty(spare);
        for lane in lanes_of(links.linked) {
            let value = shading.evaluate_from(links.toward_first(lane), toward_light);
            values.f_cos.set(lane, &value.f_cos);
            values.density.set(lane, &value.density);
        }
        Self::Each(values)
    }

    /// Zero everywhere, in memory that is no longer needed if there is any.
    fn empty(spare: &mut Spare<C>) -> Box<Evaluations<C>> {
        let mut values = spare.pop().unwrap_or_else(|| Box::new(Evaluations::ZERO));
        values.clear();
        values
    }

    /// Leaves its memory to others.
    pub fn end(self, spare: &mut Spare<C>) {
        if let Self::Each(values) = self {
            spare.push(values);
        }
    }

    /// What the sensor gets of the light, over all first surfaces.
    pub fn reach(&self, links: &Links<C>) -> Sampled<C> {
        match self {
            Self::Same(value) => links.reach.sum() * value.f_cos,
            Self::Each(values) => links.reach.dot(&values.f_cos),
        }
    }

    /// The density of the next surface together with that of the direction, over all first surfaces. `prior`:
    /// that of the next surface.
    pub fn joint(&self, links: &Links<C>, prior: Sampled<C>) -> Sampled<C> {
        match self {
            Self::Same(value) => prior * value.density,
            Self::Each(values) => links.density.dot(&values.density),
        }
    }

    /// Gives each first surface its part of some light.
    pub fn give(&self, links: &Links<C>, light: &Sampled<C>, shared: &mut SampledLanes<C>) {
        match self {
            Self::Same(value) => links.reach.add_times(&(value.f_cos * *light), shared),
            Self::Each(values) => links.reach.add_to(&values.f_cos, light, shared),
        }
    }

    pub fn density(&self, lane: usize) -> Sampled<C> {
        match self {
            Self::Same(value) => value.density,
            Self::Each(values) => values.density.get(lane),
        }
    }

    pub fn f_cos(&self, lane: usize) -> Sampled<C> {
        match self {
            Self::Same(value) => value.f_cos,
            Self::Each(values) => values.f_cos.get(lane),
        }
    }
}

#[cfg(test)]
mod tests;
