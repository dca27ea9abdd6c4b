//! Light samples for the surfaces of several paths at once.

use super::choice::Chosen;
use super::lamps::{Choices, Lamp, Lamps};
use super::{Environment, EnvironmentMap, LampLight, LightHit, LightSample, Lights, Receiver};
use crate::accel::{NO_FACET, Rays};
use crate::geometry::Points;
use crate::lanes::{Mask, REGISTERS, Real, Row, Truth, Vec3Lanes, WIDTH, ZERO, get, lanes_of, part, set};
use crate::sampling::Density;
use crate::spectrum::{SampledLanes, Wavelengths};
use wide::f64x4;

/// Places that lights may light, one for each lane; see [`Receiver`].
#[derive(Clone, Debug)]
pub struct Receivers {
    /// The lit points.
    pub point: [Points<f64x4>; REGISTERS],
    /// The sides from which light counts, as [`Receiver::facing`] has them.
    pub facing: [Vec3Lanes; REGISTERS],
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

impl Receivers {
    /// Points at the origin that light from anywhere reaches.
    pub const NONE: Self = Self { point: [Points::NONE; REGISTERS], facing: [Vec3Lanes::ZERO; REGISTERS] };

    /// The receiver of one lane.
    pub fn get(&self, lane: usize) -> Receiver {
        let register = lane / WIDTH % REGISTERS;
        Receiver { point: self.point[register].get(lane), facing: self.facing[register].get(lane) }
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
        from: &Receivers,
        asked: Mask,
        u: &[Row; 2],
        probability: &Row,
        wavelengths: impl Fn(usize) -> &'w Wavelengths<C>,
    ) {
        let samples = map.sample_in_lanes(u, asked, wavelengths);
        self.found |= asked;
        for register in 0..REGISTERS {
            let wanted = Truth::of(part(asked, register));
            let direction = samples.direction[register];
            let origin = from.point[register].leave(direction);
            let rays = &mut self.rays;
            rays.origin[register] = Vec3Lanes::choose(wanted, origin, rays.origin[register]);
            rays.direction[register] = Vec3Lanes::choose(wanted, direction, rays.direction[register]);
            rays.t_max[register] = f64x4::choose(wanted, f64x4::splat(f64::INFINITY), rays.t_max[register]);
            self.density[register] = f64x4::choose(
                wanted,
                samples.density[register] * probability[register],
                self.density[register],
            );
            for (own, radiance) in self.radiance.0.iter_mut().zip(&samples.radiance.0) {
                own[register] = f64x4::choose(wanted, radiance[register], own[register]);
            }
        }
    }

    /// Samples of the lanes that have chosen a lamp. The lanes that it means nothing for.
    #[inline(always)]
    fn toward_lamp(
        &mut self,
        lamp: &Lamp,
        from: &Receivers,
        asked: Mask,
        u: &[Row; 2],
        probability: &Row,
    ) -> Mask {
        let mut unknown = 0;
        for register in 0..REGISTERS {
            let wanted = part(asked, register);
            if wanted == 0 {
                continue;
            }
            let points = &from.point[register];
            let target = lamp.sample(points.position, [u[0][register], u[1][register]], wanted);
            unknown |= target.unknown << (WIDTH * register);
            let facing = (target.points.position - points.position).dot(target.points.normal);
            let segment = points.segments_to(&target.points);
            let found = facing.lt(f64x4::ZERO)
                & target.density.gt(f64x4::ZERO)
                & target.density.lt(f64x4::splat(f64::INFINITY))
                & segment.length.gt(f64x4::ZERO);
            self.found |= (found.mask() & wanted & !target.unknown) << (WIDTH * register);
            let wanted = Truth::of(wanted);
            let rays = &mut self.rays;
            rays.origin[register] = Vec3Lanes::choose(wanted, segment.origin, rays.origin[register]);
            rays.direction[register] = Vec3Lanes::choose(wanted, segment.direction, rays.direction[register]);
            rays.t_max[register] = f64x4::choose(wanted, segment.length, rays.t_max[register]);
            let facet = f64x4::splat(lamp.facet);
            rays.arrives[register] = f64x4::choose(wanted, facet, rays.arrives[register]);
            let density = target.density * probability[register];
            self.density[register] = f64x4::choose(wanted, density, self.density[register]);
        }
        unknown
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
        for lamp in self.lamps.iter_mut().flat_map(|lamps| lamps.all_mut()) {
            lamp.facet = facet_of(lamp.light);
        }
    }

    /// [`Self::environment_probability`] of the lanes asked for.
    pub fn environment_probabilities<'w, const C: usize>(
        &self,
        from: &Receivers,
        time: f64,
        wavelengths: impl Fn(usize) -> &'w Wavelengths<C>,
        light: &LampLight<C>,
        asked: Mask,
    ) -> Row {
        if self.choice.heads().len() == 1 {
            return [f64x4::ONE; REGISTERS];
        }
        if let Some(lamps) = &self.lamps {
            return lamps.probabilities_of_environment(from, light, asked);
        }
        let mut probabilities = ZERO;
        for lane in lanes_of(asked) {
            let probability = self.environment_probability(&from.get(lane), time, wavelengths(lane));
            set(&mut probabilities, lane, probability);
        }
        probabilities
    }

    /// [`Self::density`] for the lanes asked for.
    pub fn densities<'w, const C: usize>(
        &self,
        hit: &LightHit,
        from: &Receivers,
        time: f64,
        wavelengths: impl Fn(usize) -> &'w Wavelengths<C>,
        light: &LampLight<C>,
        asked: Mask,
    ) -> Row {
        if let Some(lamps) = &self.lamps
            && let Some(number) = lamps.number_of(hit.light as usize)
        {
            return lamps.densities(number, hit, from, light, asked);
        }
        let mut densities = ZERO;
        for lane in lanes_of(asked) {
            set(&mut densities, lane, self.density(hit, &from.get(lane), time, wavelengths(lane)));
        }
        densities
    }

    /// [`Lights::sample`] for the lanes asked for, with what lamps emit in each.
    #[expect(clippy::too_many_arguments, reason = "all that a light sample depends on, by lane")]
    pub fn sample_in_lanes<'w, const C: usize>(
        &self,
        from: &Receivers,
        time: f64,
        wavelengths: impl Fn(usize) -> &'w Wavelengths<C>,
        light: &LampLight<C>,
        asked: Mask,
        u: &[Row; 2],
        samples: &mut LightSamples<C>,
    ) {
        (samples.found, samples.discrete) = (0, 0);
        if let Some(lamps) = &self.lamps {
            return self.sample_lamps(lamps, from, time, wavelengths, light, asked, u, samples);
        }
        let (mut beyond, mut of_map, mut probability) = (0, *u, ZERO);
        for lane in lanes_of(asked) {
            let (receiver, wavelengths) = (from.get(lane), wavelengths(lane));
            let mut u = u.each_ref().map(|row| get(row, lane));
            let Some(chosen) = self.choose(&receiver, time, wavelengths, &mut u[0]) else { continue };
            if self.map().is_some() && chosen.light == self.lights.len() {
                beyond |= 1 << lane;
                set(&mut of_map[0], lane, u[0]);
                set(&mut probability, lane, chosen.probability);
                continue;
            }
            samples.put(lane, self.sample_chosen(&chosen, &receiver.point, time, &wavelengths.nm, u));
        }
        if let Some(map) = self.map().filter(|_| beyond != 0) {
            samples.toward_map(map, from, beyond, &of_map, &probability, wavelengths);
        }
    }

    /// The same where all lights are lamps, but for the environment.
    #[expect(clippy::too_many_arguments, reason = "all that a light sample depends on, by lane")]
    #[inline(always)]
    fn sample_lamps<'w, const C: usize>(
        &self,
        lamps: &Lamps,
        from: &Receivers,
        time: f64,
        wavelengths: impl Fn(usize) -> &'w Wavelengths<C>,
        light: &LampLight<C>,
        asked: Mask,
        u: &[Row; 2],
        samples: &mut LightSamples<C>,
    ) {
        let chosen = lamps.choose(from, light, asked, &u[0]);
        let u = [chosen.u, u[1]];
        samples.rays.arrives = [f64x4::splat(NO_FACET); REGISTERS];
        for (number, (lamp, &lanes)) in lamps.all().iter().zip(&chosen.lanes).enumerate() {
            let unknown = samples.toward_lamp(lamp, from, lanes, &u, &chosen.probability);
            for (own, radiance) in samples.radiance.0.iter_mut().zip(&light.radiance[number].0) {
                for register in 0..REGISTERS {
                    let wanted = Truth::of(part(lanes, register));
                    own[register] = f64x4::choose(wanted, radiance[register], own[register]);
                }
            }
            self.sample_each(lamp.light, from, time, &wavelengths, &chosen, unknown, &u, samples);
        }
        let beyond = chosen.lanes[lamps.environment()];
        match self.map().filter(|_| beyond != 0) {
            Some(map) => samples.toward_map(map, from, beyond, &u, &chosen.probability, wavelengths),
            None => {
                let number = self.lights.len();
                self.sample_each(number, from, time, &wavelengths, &chosen, beyond, &u, samples);
            }
        }
    }

    /// Samples of a light that some lanes have chosen, one by one.
    #[expect(clippy::too_many_arguments, reason = "all that a light sample depends on, by lane")]
    fn sample_each<'w, const C: usize>(
        &self,
        light: usize,
        from: &Receivers,
        time: f64,
        wavelengths: &impl Fn(usize) -> &'w Wavelengths<C>,
        choices: &Choices,
        lanes: Mask,
        u: &[Row; 2],
        samples: &mut LightSamples<C>,
    ) {
        for lane in lanes_of(lanes) {
            let chosen = Chosen { light, part: 0, probability: get(&choices.probability, lane) };
            let u = u.each_ref().map(|row| get(row, lane));
            let point = from.get(lane).point;
            samples.put(lane, self.sample_chosen(&chosen, &point, time, &wavelengths(lane).nm, u));
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
