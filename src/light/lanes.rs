//! Light samples for the surfaces of several paths at once.

use super::choice::Head;
use super::{Environment, EnvironmentMap, Light, Lights, Receiver};
use crate::accel::{NO_FACET, Rays};
use crate::geometry::Points;
use crate::lanes::{Mask, REGISTERS, Real, Row, Truth, Vec3Lanes, WIDTH, ZERO, get, lanes_of, part, set};
use crate::sampling::Density;
use crate::shape::{RectangleSurface, Shape};
use crate::spectrum::{Sampled, SampledLanes, Spectrum, Wavelengths};
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

/// A lamp that all light samples go to: a rectangle that emits evenly and stays where it is.
#[derive(Clone, Debug)]
pub(super) struct OnlyRectangle {
    surface: RectangleSurface,
    area: f64,
    light: usize,
    /// The facet that it is, where the scene consists of few; see [`Rays::arrives`].
    facet: f64,
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

    /// That of a lane.
    pub fn density_of(&self, lane: usize) -> Density {
        match self.discrete >> lane & 1 {
            0 => Density::PerSolidAngle(get(&self.density, lane)),
            _ => Density::Discrete,
        }
    }
}

impl OnlyRectangle {
    /// `None` where there are other lights, too, or another one.
    pub fn new(lights: &Lights) -> Option<Self> {
        let [Head::Light(light)] = lights.choice.heads() else { return None };
        let light = *light as usize;
        let Light::Area { geometry, radiance, .. } = &lights.lights[light] else { return None };
        let Shape::Mesh(mesh) = &geometry.shape else { return None };
        let is_plain = geometry.stands_alone() && geometry.guides.is_none() && radiance.uniform().is_some();
        let surface = mesh.rectangle_surface().filter(|_| is_plain && geometry.area() > 0.0)?;
        Some(Self { surface, area: geometry.area(), light, facet: NO_FACET })
    }

    fn radiance<'a>(&self, lights: &'a Lights) -> Option<&'a Spectrum> {
        match &lights.lights[self.light] {
            Light::Area { radiance, .. } => radiance.uniform(),
            _ => None,
        }
    }

    /// Samples by solid angle where that pays, and else by area.
    fn sample<const C: usize>(
        &self,
        from: &Receivers,
        asked: Mask,
        u: &[Row; 2],
        samples: &mut LightSamples<C>,
    ) {
        let rectangle = self.surface.rectangle();
        for register in 0..REGISTERS {
            let wanted = part(asked, register);
            if wanted == 0 {
                continue;
            }
            let points = &from.point[register];
            let u = [u[0][register], u[1][register]];
            let near = rectangle.is_near(points.position);
            let (mut place, mut density, mut by_angle) = (u, f64x4::ZERO, near);
            if near.mask() & wanted != 0 {
                let (seen, usable) = rectangle.project(points.position);
                by_angle = by_angle & usable;
                let of_angle = seen.sample(u);
                place = [0, 1].map(|axis| f64x4::choose(by_angle, of_angle[axis], u[axis]));
                density = f64x4::ONE / seen.solid_angle();
            }
            let target = self.surface.points(place);
            let toward = target.position - points.position;
            let squared = toward.length_squared();
            let facing = toward.dot(target.normal);
            let of_area = squared * squared.sqrt() / facing.abs() * f64x4::splat(1.0 / self.area);
            density = f64x4::choose(by_angle, density, of_area);
            let segment = points.segments_to(&target);
            let found = facing.lt(f64x4::ZERO)
                & density.gt(f64x4::ZERO)
                & density.lt(f64x4::splat(f64::INFINITY))
                & segment.length.gt(f64x4::ZERO);
            samples.found |= (found.mask() & wanted) << (WIDTH * register);
            samples.rays.origin[register] = segment.origin;
            samples.rays.direction[register] = segment.direction;
            samples.rays.t_max[register] = segment.length;
            samples.density[register] = density;
            samples.rays.arrives[register] = f64x4::splat(self.facet);
        }
    }
}

impl Lights {
    /// Says which facet of a small scene the lamp is that all light samples go to, by `facet_of` a light.
    pub fn set_facet(&mut self, facet_of: impl Fn(usize) -> f64) {
        if let Some(only) = &mut self.only_rectangle {
            only.facet = facet_of(only.light);
        }
    }

    /// What the lamp emits that all light samples go to, at the wavelengths (nm) of a path: the same from all
    /// over it. Zero where there is no such lamp.
    pub fn only_radiance<const C: usize>(&self, nm: &[f64; C]) -> Sampled<C> {
        let only = self.only_rectangle.as_ref().and_then(|only| only.radiance(self));
        only.map_or(Sampled::ZERO, |spectrum| spectrum.sample(nm))
    }

    /// [`Self::environment_probability`] of the lanes asked for.
    pub fn environment_probabilities<'w, const C: usize>(
        &self,
        from: &Receivers,
        time: f64,
        wavelengths: impl Fn(usize) -> &'w Wavelengths<C>,
        asked: Mask,
    ) -> Row {
        if self.choice.heads().len() == 1 {
            return [f64x4::ONE; REGISTERS];
        }
        let mut probabilities = ZERO;
        for lane in lanes_of(asked) {
            let probability = self.environment_probability(&from.get(lane), time, wavelengths(lane));
            set(&mut probabilities, lane, probability);
        }
        probabilities
    }

    /// [`Lights::sample`] for the lanes asked for. `only_radiance` is [`Self::only_radiance`] for each lane.
    #[expect(clippy::too_many_arguments, reason = "all that a light sample depends on, by lane")]
    pub fn sample_in_lanes<'w, const C: usize>(
        &self,
        from: &Receivers,
        time: f64,
        wavelengths: impl Fn(usize) -> &'w Wavelengths<C>,
        only_radiance: &SampledLanes<C>,
        asked: Mask,
        u: &[Row; 2],
        samples: &mut LightSamples<C>,
    ) {
        (samples.found, samples.discrete) = (0, 0);
        if let Some(only) = &self.only_rectangle {
            only.sample(from, asked, u, samples);
            samples.radiance.clone_from(only_radiance);
            return;
        }
        let map = match &self.environment {
            Some(Environment::Map(map)) => Some(map),
            _ => None,
        };
        let (mut beyond, mut of_map, mut probability) = (0, *u, ZERO);
        for lane in lanes_of(asked) {
            let (receiver, wavelengths) = (from.get(lane), wavelengths(lane));
            let mut u = u.each_ref().map(|row| get(row, lane));
            let Some(chosen) = self.choose(&receiver, time, wavelengths, &mut u[0]) else { continue };
            if map.is_some() && chosen.light == self.lights.len() {
                beyond |= 1 << lane;
                set(&mut of_map[0], lane, u[0]);
                set(&mut probability, lane, chosen.probability);
                continue;
            }
            let Some(sample) = self.sample_chosen(&chosen, &receiver.point, time, &wavelengths.nm, u) else {
                continue;
            };
            samples.found |= 1 << lane;
            samples.rays.set(lane, &sample.shadow_ray);
            samples.radiance.set(lane, &sample.radiance);
            match sample.density {
                Density::PerSolidAngle(density) => set(&mut samples.density, lane, density),
                Density::Discrete => samples.discrete |= 1 << lane,
            }
        }
        if let Some(map) = map.filter(|_| beyond != 0) {
            samples.toward_map(map, from, beyond, &of_map, &probability, wavelengths);
        }
    }
}
