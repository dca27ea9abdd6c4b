//! Rough metals of several lanes; see [`crate::bsdf::RoughConductor`].

use super::surfaces::Evaluations;
use crate::bsdf::microfacet::Distribution;
use crate::bsdf::{Beckmann, FacetReflection, Ggx, Microfacets, RoughConductor, fresnel};
use crate::geometry::axes_around;
use crate::lanes::{
    ALL, Mask, REGISTERS, Real, Register, Row, Truth, Vec3Lanes, Vector, WIDTH, ZERO, get, lanes_of, part,
    registers_of, set,
};
use crate::material::RoughMetal;
use crate::spectrum::SampledLanes;

/// Rough metals, one for each lane that is one.
pub(super) struct Metals<const C: usize> {
    pub lanes: Mask,
    /// Those whose facets have Beckmann's distribution, not GGX's.
    beckmann: Mask,
    eta: SampledLanes<C>,
    k: SampledLanes<C>,
    specular_reflectance: SampledLanes<C>,
    alpha: [Row; 2],
    /// The axes of their frames.
    axes: [[Vec3Lanes; 3]; REGISTERS],
    /// In the frames.
    toward_eye: [Vec3Lanes; REGISTERS],
}

/// A direction that metals scatter in, in the world, with its value and density.
pub(super) struct Reflected<const C: usize> {
    pub lanes: Mask,
    pub toward_light: Vec3Lanes,
    pub density: Register,
    pub weight: [Register; C],
}

impl<const C: usize> Metals<C> {
    pub fn new() -> Self {
        Self {
            lanes: 0,
            beckmann: 0,
            eta: SampledLanes::ZERO,
            k: SampledLanes::ZERO,
            specular_reflectance: SampledLanes::ZERO,
            alpha: [ZERO; 2],
            axes: [[Vec3Lanes::ZERO; 3]; REGISTERS],
            toward_eye: [Vec3Lanes::ZERO; REGISTERS],
        }
    }

    /// The metal of a lane for all lanes.
    pub fn of_lane(&self, lane: usize) -> Self {
        let all = |row: &Row| [Register::splat(get(row, lane)); REGISTERS];
        let spectrum = |lanes: &SampledLanes<C>| SampledLanes::splat(&lanes.get(lane));
        let register = lane / WIDTH % REGISTERS;
        Self {
            lanes: ALL,
            beckmann: if self.beckmann >> lane & 1 == 1 { ALL } else { 0 },
            eta: spectrum(&self.eta),
            k: spectrum(&self.k),
            specular_reflectance: spectrum(&self.specular_reflectance),
            alpha: self.alpha.each_ref().map(all),
            axes: [self.axes[register].map(|axis| Vector::of(axis.get(lane))); REGISTERS],
            toward_eye: [Vector::of(self.toward_eye[register].get(lane)); REGISTERS],
        }
    }

    pub fn set(&mut self, lane: usize, metal: &RoughMetal<C>) {
        let RoughMetal { bsdf, frame, toward_eye } = metal;
        self.set_bsdf(lane, bsdf);
        let register = lane / WIDTH % REGISTERS;
        for (lanes, axis) in self.axes[register].iter_mut().zip([frame.x, frame.y, frame.z]) {
            lanes.set(lane, axis);
        }
        self.toward_eye[register].set(lane, *toward_eye);
    }

    /// Puts in a metal for which it makes no difference which way the axes are; see [`Self::turn`].
    pub fn set_bsdf(&mut self, lane: usize, bsdf: &RoughConductor<C>) {
        let RoughConductor { facet, microfacets } = bsdf;
        self.lanes |= 1 << lane;
        self.beckmann = self.beckmann & !(1 << lane) | Mask::from(has_beckmanns(microfacets)) << lane;
        self.eta.set(lane, &facet.eta);
        self.k.set(lane, &facet.k);
        self.specular_reflectance.set(lane, &facet.specular_reflectance);
        for (row, alpha) in self.alpha.iter_mut().zip(microfacets.alpha()) {
            set(row, lane, alpha);
        }
    }

    /// Gives some lanes frames around the normals, by the directions toward the eye in the world.
    pub fn turn(
        &mut self,
        lanes: Mask,
        normals: &[Vec3Lanes; REGISTERS],
        toward_eye: impl Fn(usize) -> Vec3Lanes,
    ) {
        for register in registers_of(lanes) {
            let (turned, normal) = (Truth::of(part(lanes, register)), normals[register]);
            let [x, y] = axes_around(normal);
            for (own, axis) in self.axes[register].iter_mut().zip([x, y, normal]) {
                *own = Vec3Lanes::choose(turned, axis, *own);
            }
            let local = self.to_local(register, toward_eye(register));
            let own = &mut self.toward_eye[register];
            *own = Vec3Lanes::choose(turned, local, *own);
        }
    }

    #[inline(always)]
    fn to_local(&self, register: usize, world: Vec3Lanes) -> Vec3Lanes {
        let [x, y, z] = self.axes[register];
        Vector::new(x.dot(world), y.dot(world), z.dot(world))
    }

    /// What facets of normal `m` reflect, by both distributions where lanes of both are wanted.
    #[inline(always)]
    fn about(
        &self,
        register: usize,
        wanted: Mask,
        [eye, light, m]: [Vec3Lanes; 3],
    ) -> FacetReflection<Register> {
        let alpha = [self.alpha[0][register], self.alpha[1][register]];
        let of_beckmann = || FacetReflection::about(&Beckmann { alpha }, eye, light, m);
        let of_ggx = || FacetReflection::about(&Ggx { alpha }, eye, light, m);
        let beckmann = part(self.beckmann, register);
        if wanted & beckmann == 0 {
            of_ggx()
        } else if wanted & !beckmann == 0 {
            of_beckmann()
        } else {
            FacetReflection::choose(Truth::of(beckmann), of_beckmann(), of_ggx())
        }
    }

    #[inline(always)]
    fn reflectance(&self, register: usize, wavelength: usize, cos: Register) -> Register {
        let [eta, k] = [&self.eta, &self.k].map(|index| index.0[wavelength][register]);
        self.specular_reflectance.0[wavelength][register] * fresnel::conductor(cos, eta, k)
    }

    /// Puts in the values for light from a direction for each lane, and the densities, of those that are
    /// asked for.
    #[inline(always)]
    pub fn evaluate(&self, toward_light: &[Vec3Lanes; REGISTERS], asked: Mask, values: &mut Evaluations<C>) {
        let eye = |register: usize| self.toward_eye[register];
        self.evaluate_with(eye, toward_light, asked, values);
    }

    /// The same where each lane's eye is in another direction.
    #[inline(always)]
    pub fn evaluate_from(
        &self,
        toward_eye: &[Vec3Lanes; REGISTERS],
        toward_light: &[Vec3Lanes; REGISTERS],
        asked: Mask,
        values: &mut Evaluations<C>,
    ) {
        let eye = |register: usize| self.to_local(register, toward_eye[register]);
        self.evaluate_with(eye, toward_light, asked, values);
    }

    #[inline(always)]
    fn evaluate_with(
        &self,
        eye: impl Fn(usize) -> Vec3Lanes,
        toward_light: &[Vec3Lanes; REGISTERS],
        asked: Mask,
        values: &mut Evaluations<C>,
    ) {
        for register in registers_of(asked & self.lanes) {
            let wanted = part(asked & self.lanes, register);
            let light = self.to_local(register, toward_light[register]);
            let eye = eye(register);
            let about = |m| self.about(register, wanted, [eye, light, m]);
            let found = FacetReflection::between(eye, light, about);
            let wanted = Truth::of(wanted);
            for wavelength in 0..C {
                let f_cos = self.reflectance(register, wavelength, found.cos) * found.value;
                let own = &mut values.f_cos.0[wavelength][register];
                *own = Register::choose(wanted, f_cos, *own);
                let own = &mut values.density.0[wavelength][register];
                *own = Register::choose(wanted, found.density, *own);
            }
        }
    }

    /// A direction for each lane of a register that is asked for.
    #[inline(always)]
    pub fn sample(&self, register: usize, u: [Register; 2], asked: Mask) -> Reflected<C> {
        let eye = self.toward_eye[register];
        let m = self.sample_visible(register, u, asked);
        let light = m * (Register::splat(2.0) * eye.dot(m)) - eye;
        let found = self.about(register, asked, [eye, light, m]);
        let above = eye.z.gt(Register::ZERO) & light.z.gt(Register::ZERO);
        let scattered = above & found.density.gt(Register::ZERO);
        let [x, y, z] = self.axes[register];
        let mut weight = [Register::ZERO; C];
        for (wavelength, weight) in weight.iter_mut().enumerate() {
            *weight = self.reflectance(register, wavelength, found.cos) * found.value / found.density;
        }
        Reflected {
            lanes: scattered.mask() & asked,
            toward_light: (x * light.x + y * light.y + z * light.z).normalize(),
            density: found.density,
            weight,
        }
    }

    /// A normal of the facets that the eye sees, for each lane of a register that is asked for. Those of
    /// Beckmann's distribution take steps until they are there, so they go one by one.
    #[inline(always)]
    fn sample_visible(&self, register: usize, u: [Register; 2], asked: Mask) -> Vec3Lanes {
        let (eye, alpha) = (self.toward_eye[register], [self.alpha[0][register], self.alpha[1][register]]);
        let beckmann = part(self.beckmann, register) & asked;
        let mut m = match asked & !beckmann {
            0 => Vec3Lanes::ZERO,
            _ => Ggx { alpha }.sample_visible(eye, u),
        };
        for lane in lanes_of(beckmann) {
            let [alpha_u, alpha_v, x, y] =
                [alpha[0], alpha[1], u[0], u[1]].map(|numbers| numbers.as_array()[lane % WIDTH]);
            let facets = Microfacets::new(Distribution::Beckmann, alpha_u, alpha_v);
            m.set(lane, facets.sample_visible(eye.get(lane), [x, y]));
        }
        m
    }
}

fn has_beckmanns(microfacets: &Microfacets) -> bool {
    microfacets.distribution() == Distribution::Beckmann
}
