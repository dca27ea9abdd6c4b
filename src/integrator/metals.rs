//! Rough metals of several lanes; see [`crate::bsdf::RoughConductor`].

use super::surfaces::Evaluations;
use crate::bsdf::{FacetReflection, Ggx, fresnel};
use crate::lanes::{
    ALL, Mask, REGISTERS, Real, Register, Row, Truth, Vec3Lanes, Vector, WIDTH, ZERO, part, set,
};
use crate::material::RoughMetal;
use crate::spectrum::SampledLanes;

/// Rough metals, one for each lane that is one.
pub(super) struct Metals<const C: usize> {
    pub lanes: Mask,
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
            eta: SampledLanes::ZERO,
            k: SampledLanes::ZERO,
            specular_reflectance: SampledLanes::ZERO,
            alpha: [ZERO; 2],
            axes: [[Vec3Lanes::ZERO; 3]; REGISTERS],
            toward_eye: [Vec3Lanes::ZERO; REGISTERS],
        }
    }

    /// The same metal for all lanes.
    pub fn splat(metal: &RoughMetal<C>) -> Self {
        let RoughMetal { facet, facets, frame, toward_eye } = metal;
        Self {
            lanes: ALL,
            eta: SampledLanes::splat(&facet.eta),
            k: SampledLanes::splat(&facet.k),
            specular_reflectance: SampledLanes::splat(&facet.specular_reflectance),
            alpha: facets.alpha.map(|alpha| [Register::splat(alpha); REGISTERS]),
            axes: [[frame.x, frame.y, frame.z].map(Vector::of); REGISTERS],
            toward_eye: [Vector::of(*toward_eye); REGISTERS],
        }
    }

    pub fn set(&mut self, lane: usize, metal: &RoughMetal<C>) {
        let RoughMetal { facet, facets, frame, toward_eye } = metal;
        let register = lane / WIDTH % REGISTERS;
        self.lanes |= 1 << lane;
        self.eta.set(lane, &facet.eta);
        self.k.set(lane, &facet.k);
        self.specular_reflectance.set(lane, &facet.specular_reflectance);
        for (row, alpha) in self.alpha.iter_mut().zip(facets.alpha) {
            set(row, lane, alpha);
        }
        for (lanes, axis) in self.axes[register].iter_mut().zip([frame.x, frame.y, frame.z]) {
            lanes.set(lane, axis);
        }
        self.toward_eye[register].set(lane, *toward_eye);
    }

    #[inline(always)]
    fn to_local(&self, register: usize, world: Vec3Lanes) -> Vec3Lanes {
        let [x, y, z] = self.axes[register];
        Vector::new(x.dot(world), y.dot(world), z.dot(world))
    }

    #[inline(always)]
    fn facets(&self, register: usize) -> Ggx<Register> {
        Ggx { alpha: [self.alpha[0][register], self.alpha[1][register]] }
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
        for register in 0..REGISTERS {
            let wanted = part(asked & self.lanes, register);
            if wanted == 0 {
                continue;
            }
            let light = self.to_local(register, toward_light[register]);
            let found = FacetReflection::between(&self.facets(register), eye(register), light);
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
        let (eye, facets) = (self.toward_eye[register], self.facets(register));
        let m = facets.sample_visible(eye, u);
        let light = m * (Register::splat(2.0) * eye.dot(m)) - eye;
        let found = FacetReflection::about(&facets, eye, light, m);
        let scattered = light.z.gt(Register::ZERO) & found.density.gt(Register::ZERO);
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
}
