//! Light samples for the surfaces of several paths at once.

use super::choice::Head;
use super::{Light, Lights, Receiver};
use crate::accel::Rays;
use crate::geometry::Points;
use crate::lanes::{Mask, REGISTERS, Real, Row, Vec3Lanes, WIDTH, ZERO, get, lanes_of, part, set};
use crate::sampling::Density;
use crate::shape::{RectangleSurface, Shape};
use crate::spectrum::{SampledLanes, Spectrum, Wavelengths};
use wide::f64x4;

/// Places that lights may light, one for each lane; see [`Receiver`].
#[derive(Clone, Debug)]
pub struct Receivers {
    pub point: [Points<f64x4>; REGISTERS],
    pub facing: [Vec3Lanes; REGISTERS],
}

/// Light samples of the lanes that found one; see [`super::LightSample`].
#[derive(Clone, Debug)]
pub struct LightSamples<const C: usize> {
    pub found: Mask,
    pub rays: Rays,
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
    light: usize,
}

impl Receivers {
    pub const NONE: Self = Self { point: [Points::NONE; REGISTERS], facing: [Vec3Lanes::ZERO; REGISTERS] };

    pub fn get(&self, lane: usize) -> Receiver {
        let register = lane / WIDTH % REGISTERS;
        Receiver { point: self.point[register].get(lane), facing: self.facing[register].get(lane) }
    }
}

impl<const C: usize> LightSamples<C> {
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
        Some(Self { surface: mesh.rectangle_surface().filter(|_| is_plain)?, light })
    }

    fn radiance<'a>(&self, lights: &'a Lights) -> Option<&'a Spectrum> {
        match &lights.lights[self.light] {
            Light::Area { radiance, .. } => radiance.uniform(),
            _ => None,
        }
    }

    /// Samples by solid angle. The lanes that the rectangle is too far from for that.
    fn sample<const C: usize>(
        &self,
        from: &Receivers,
        asked: Mask,
        u: &[Row; 2],
        samples: &mut LightSamples<C>,
    ) -> Mask {
        let mut left = 0;
        for register in 0..REGISTERS {
            let wanted = part(asked, register);
            if wanted == 0 {
                continue;
            }
            let points = &from.point[register];
            let rectangle = self.surface.rectangle();
            let (seen, usable) = rectangle.project(points.position);
            let usable = usable & rectangle.is_near(points.position);
            let target = self.surface.points(seen.sample([u[0][register], u[1][register]]));
            let front = target.normal.dot(points.position - target.position).gt(f64x4::ZERO);
            let segment = points.segments_to(&target);
            let found = (usable & front & segment.length.gt(f64x4::ZERO)).mask() & wanted;
            samples.found |= found << (WIDTH * register);
            samples.rays.origin[register] = segment.origin;
            samples.rays.direction[register] = segment.direction;
            samples.rays.t_max[register] = segment.length;
            samples.density[register] = f64x4::ONE / seen.solid_angle();
            left |= (wanted & !usable.mask()) << (WIDTH * register);
        }
        left
    }
}

impl Lights {
    /// [`Lights::sample`] for the lanes asked for.
    pub fn sample_in_lanes<const C: usize>(
        &self,
        from: &Receivers,
        time: f64,
        wavelengths: &Wavelengths<C>,
        asked: Mask,
        u: &[Row; 2],
    ) -> LightSamples<C> {
        let mut samples = LightSamples {
            found: 0,
            rays: Rays::NONE,
            radiance: SampledLanes::ZERO,
            density: ZERO,
            discrete: 0,
        };
        let mut left = asked;
        if let Some(only) = &self.only_rectangle
            && let Some(spectrum) = only.radiance(self)
        {
            left = only.sample(from, asked, u, &mut samples);
            samples.radiance = SampledLanes::splat(&spectrum.sample(&wavelengths.nm));
        }
        for lane in lanes_of(left) {
            let u = u.each_ref().map(|row| get(row, lane));
            let Some(sample) = self.sample(&from.get(lane), time, wavelengths, u) else { continue };
            samples.found |= 1 << lane;
            samples.rays.set(lane, &sample.shadow_ray);
            samples.radiance.set(lane, &sample.radiance);
            match sample.density {
                Density::PerSolidAngle(density) => set(&mut samples.density, lane, density),
                Density::Discrete => samples.discrete |= 1 << lane,
            }
        }
        samples
    }
}
