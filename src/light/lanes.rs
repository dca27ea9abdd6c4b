//! Light samples for the surfaces of several paths at once.

use super::choice::Chosen;
use super::lamps::{Choices, Lamp, Lamps};
use super::{Environment, EnvironmentMap, LampLight, LightHit, LightSample, Lights, Receiver};
use crate::accel::{NO_FACET, Rays};
use crate::geometry::{Points, Segments};
use crate::lanes::{
    Mask, REGISTERS, Real, Register, Row, Truth, Vec3Lanes, WIDTH, ZERO, get, lanes_of, part, registers_of,
    set,
};
use crate::sampling::Density;
use crate::spectrum::{SampledLanes, Wavelengths};

/// Places that lights may light, one for each lane; see [`Receiver`].
#[derive(Clone, Copy, Debug)]
pub struct Receivers<'a> {
    /// The lit points.
    pub point: &'a [Points<Register>; REGISTERS],
    /// The sides from which light counts, as [`Receiver::facing`] has them.
    pub facing: &'a [Vec3Lanes; REGISTERS],
}

/// The places of some lanes, and what else light samples for them depend on.
#[derive(Clone, Copy, Debug)]
pub struct Lit<'a, F, const C: usize> {
    /// The places.
    pub from: Receivers<'a>,
    /// When they are lit.
    pub time: f64,
    /// The wavelengths of a lane.
    pub wavelengths: F,
    /// What lamps emit at these.
    pub light: &'a LampLight<C>,
    /// The lanes that ask.
    pub asked: Mask,
}

/// Light samples of the lanes that found one; see [`super::LightSample`].
#[derive(Clone, Debug)]
pub struct LightSamples<const C: usize> {
    /// The lanes that have a sample.
    pub found: Mask,
    /// Shadow rays, from the lit points to just before the lamp.
    pub rays: Rays,
    /// What arrives if nothing is in the way, over the density.
    pub radiance: SampledLanes<C>,
    /// Per steradian; of a light without extent there is none.
    pub density: Row,
    /// The lanes whose light has no extent.
    pub discrete: Mask,
}

impl Receivers<'_> {
    /// The receiver of one lane.
    pub fn get(&self, lane: usize) -> Receiver {
        let register = lane / WIDTH % REGISTERS;
        Receiver { point: self.point[register].get(lane), facing: self.facing[register].get(lane) }
    }
}

impl<'w, F: Fn(usize) -> &'w Wavelengths<C>, const C: usize> Lit<'_, F, C> {
    /// A number for each of the lanes.
    fn each(&self, of: impl Fn(&Receiver, &Wavelengths<C>) -> f64) -> Row {
        let mut row = ZERO;
        for lane in lanes_of(self.asked) {
            set(&mut row, lane, of(&self.from.get(lane), (self.wavelengths)(lane)));
        }
        row
    }
}

impl<const C: usize> LightSamples<C> {
    /// No lane has a sample.
    pub const NONE: Self =
        Self { found: 0, rays: Rays::NONE, radiance: SampledLanes::ZERO, density: ZERO, discrete: 0 };

    /// Samples of the lanes that have chosen the environment, by the probability of that.
    fn toward_map<'w>(
        &mut self,
        map: &EnvironmentMap,
        lit: &Lit<'_, impl Fn(usize) -> &'w Wavelengths<C>, C>,
        lanes: Mask,
        u: &[Row; 2],
        probability: &Row,
    ) {
        let (samples, lanes) = map.sample_in_lanes(u, lanes, lit.from.facing, &lit.wavelengths);
        self.found |= lanes;
        for register in registers_of(lanes) {
            let direction = samples.direction[register];
            let origin = lit.from.point[register].leave(direction);
            let ray = Segments { origin, direction, length: Register::splat(f64::INFINITY) };
            let density = samples.density[register] * probability[register];
            self.put_in_lanes(register, part(lanes, register), &ray, density, &samples.radiance);
        }
    }

    /// Samples of the lanes that have chosen a lamp, which has this radiance. The lanes that go one by one.
    #[inline(always)]
    fn toward_lamp(
        &mut self,
        lamp: &Lamp,
        radiance: &SampledLanes<C>,
        from: Receivers,
        lanes: Mask,
        choices: &Choices,
    ) -> Mask {
        let mut unknown = 0;
        for register in registers_of(lanes) {
            let wanted = part(lanes, register);
            let points = &from.point[register];
            let target = lamp.sample(points.position, choices.u.map(|row| row[register]), wanted);
            unknown |= target.unknown << (WIDTH * register);
            let facing = (target.points.position - points.position).dot(target.points.normal);
            let segment = points.segments_to(&target.points);
            let found = facing.lt(Register::ZERO)
                & target.density.gt(Register::ZERO)
                & target.density.lt(Register::splat(f64::INFINITY))
                & segment.length.gt(Register::ZERO);
            self.found |= (found.mask() & wanted & !target.unknown) << (WIDTH * register);
            let density = target.density * choices.probability[register];
            self.put_in_lanes(register, wanted, &segment, density, radiance);
            let arrives = &mut self.rays.arrives[register];
            *arrives = Register::choose(Truth::of(wanted), Register::splat(lamp.facet), *arrives);
        }
        unknown
    }

    /// Samples of some lanes of a register.
    #[inline(always)]
    fn put_in_lanes(
        &mut self,
        register: usize,
        wanted: Mask,
        ray: &Segments<Register>,
        density: Register,
        radiance: &SampledLanes<C>,
    ) {
        let wanted = Truth::of(wanted);
        let rays = &mut self.rays;
        rays.origin[register] = Vec3Lanes::choose(wanted, ray.origin, rays.origin[register]);
        rays.direction[register] = Vec3Lanes::choose(wanted, ray.direction, rays.direction[register]);
        rays.t_max[register] = Register::choose(wanted, ray.length, rays.t_max[register]);
        self.density[register] = Register::choose(wanted, density, self.density[register]);
        for (own, radiance) in self.radiance.0.iter_mut().zip(&radiance.0) {
            own[register] = Register::choose(wanted, radiance[register], own[register]);
        }
    }

    /// The sample of a lane, if it has found one.
    fn put(&mut self, lane: usize, sample: Option<LightSample<C>>) {
        let Some(sample) = sample else { return };
        self.found |= 1 << lane;
        self.rays.set(lane, &sample.shadow_ray);
        self.radiance.set(lane, &sample.radiance);
        match sample.density {
            Density::PerSolidAngle(density) => set(&mut self.density, lane, density),
            Density::Discrete => self.discrete |= 1 << lane,
        }
    }

    /// That of a lane.
    pub fn density_of(&self, lane: usize) -> Density {
        match self.discrete >> lane & 1 {
            0 => Density::PerSolidAngle(get(&self.density, lane)),
            _ => Density::Discrete,
        }
    }
}

impl Lights {
    /// Says which facet of a small scene each lamp is whose light samples are taken in lanes, by `facet_of` a
    /// light.
    pub fn set_facets(&mut self, facet_of: impl Fn(usize) -> f64) {
        for lamp in self.lamps.iter_mut().flat_map(|lamps| &mut lamps.lamps) {
            lamp.facet = facet_of(lamp.light);
        }
    }

    /// [`Self::environment_probability`] of the lanes.
    pub fn environment_probabilities<'w, const C: usize>(
        &self,
        lit: &Lit<'_, impl Fn(usize) -> &'w Wavelengths<C>, C>,
    ) -> Row {
        if self.choice.heads().len() == 1 {
            return [Register::ONE; REGISTERS];
        }
        match &self.lamps {
            Some(lamps) => lamps.probabilities_of_environment(lit),
            None => lit.each(|from, wavelengths| self.environment_probability(from, lit.time, wavelengths)),
        }
    }

    /// [`Self::density`] for the lanes.
    pub fn densities<'w, const C: usize>(
        &self,
        hit: &LightHit,
        lit: &Lit<'_, impl Fn(usize) -> &'w Wavelengths<C>, C>,
    ) -> Row {
        let lamps = self.lamps.as_ref();
        match lamps.and_then(|lamps| Some((lamps, lamps.number_of(hit.light as usize)?))) {
            Some((lamps, number)) => lamps.densities(number, hit, lit),
            None => lit.each(|from, wavelengths| self.density(hit, from, lit.time, wavelengths)),
        }
    }

    /// [`Lights::sample`] for the lanes.
    pub fn sample_in_lanes<'w, const C: usize>(
        &self,
        lit: &Lit<'_, impl Fn(usize) -> &'w Wavelengths<C>, C>,
        u: &[Row; 2],
        samples: &mut LightSamples<C>,
    ) {
        (samples.found, samples.discrete) = (0, 0);
        if let Some(lamps) = &self.lamps {
            return self.sample_lamps(lamps, lit, u, samples);
        }
        let (mut beyond, mut of_map, mut probability) = (0, *u, ZERO);
        for lane in lanes_of(lit.asked) {
            let (receiver, wavelengths) = (lit.from.get(lane), (lit.wavelengths)(lane));
            let mut u = u.each_ref().map(|row| get(row, lane));
            let Some(chosen) = self.choose(&receiver, lit.time, wavelengths, &mut u[0]) else { continue };
            if self.map().is_some() && chosen.light == self.lights.len() {
                beyond |= 1 << lane;
                set(&mut of_map[0], lane, u[0]);
                set(&mut probability, lane, chosen.probability);
                continue;
            }
            samples.put(lane, self.sample_chosen(&chosen, &receiver, lit.time, &wavelengths.nm, u));
        }
        if let Some(map) = self.map().filter(|_| beyond != 0) {
            samples.toward_map(map, lit, beyond, &of_map, &probability);
        }
    }

    /// The same where all lights are lamps, but for the environment.
    #[inline(always)]
    fn sample_lamps<'w, const C: usize>(
        &self,
        lamps: &Lamps,
        lit: &Lit<'_, impl Fn(usize) -> &'w Wavelengths<C>, C>,
        u: &[Row; 2],
        samples: &mut LightSamples<C>,
    ) {
        let chosen = lamps.choose(lit, u);
        samples.rays.arrives = [Register::splat(NO_FACET); REGISTERS];
        for ((lamp, radiance), &lanes) in lamps.lamps.iter().zip(&lit.light.radiance).zip(&chosen.lanes) {
            let unknown = samples.toward_lamp(lamp, radiance, lit.from, lanes, &chosen);
            self.sample_each(lamp.light, lit, unknown, &chosen, samples);
        }
        let beyond = chosen.lanes[lamps.environment()];
        match self.map().filter(|_| beyond != 0) {
            Some(map) => samples.toward_map(map, lit, beyond, &chosen.u, &chosen.probability),
            None => self.sample_each(self.lights.len(), lit, beyond, &chosen, samples),
        }
    }

    /// Samples of a light that some lanes have chosen, one by one.
    fn sample_each<'w, const C: usize>(
        &self,
        light: usize,
        lit: &Lit<'_, impl Fn(usize) -> &'w Wavelengths<C>, C>,
        lanes: Mask,
        choices: &Choices,
        samples: &mut LightSamples<C>,
    ) {
        for lane in lanes_of(lanes) {
            let chosen = Chosen { light, part: 0, probability: get(&choices.probability, lane) };
            let u = choices.u.each_ref().map(|row| get(row, lane));
            let (receiver, nm) = (lit.from.get(lane), &(lit.wavelengths)(lane).nm);
            samples.put(lane, self.sample_chosen(&chosen, &receiver, lit.time, nm, u));
        }
    }

    /// The environment, if it is a map.
    fn map(&self) -> Option<&EnvironmentMap> {
        match &self.environment {
            Some(Environment::Map(map)) => Some(map),
            _ => None,
        }
    }
}
