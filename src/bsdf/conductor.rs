//! Opaque metal, smooth and rough.

use super::microfacet::{Beckmann, Distribution, Facets, Ggx, Microfacets};
use super::{Evaluation, Scatter, flipped, fresnel};
use crate::geometry::Vec3;
use crate::lanes::{Real, Vector};
use crate::sampling::Density;
use crate::spectrum::Sampled;

/// A smooth metal: a mirror with the Fresnel reflectance of a complex index. Black from below.
/// Mitsuba's `conductor`.
#[derive(Clone, Copy, Debug)]
pub struct Conductor<const C: usize> {
    /// Real part of the index, relative to the medium outside.
    pub eta: Sampled<C>,
    /// Imaginary part of the index (extinction coefficient), relative to the medium outside.
    pub k: Sampled<C>,
    /// Multiplies the reflectance; 1 in nature.
    pub specular_reflectance: Sampled<C>,
}

impl<const C: usize> Conductor<C> {
    /// The Fresnel reflectance times `specular_reflectance`.
    fn reflectance(&self, cos_incident: f64) -> Sampled<C> {
        let lane =
            |i| self.specular_reflectance[i] * fresnel::conductor(cos_incident, self.eta[i], self.k[i]);
        Sampled(std::array::from_fn(lane))
    }

    pub(super) fn sample(&self, toward_eye: Vec3) -> Option<Scatter<C>> {
        (toward_eye.z > 0.0).then(|| Scatter {
            toward_light: -flipped(toward_eye),
            weight: self.reflectance(toward_eye.z.min(1.0)),
            density: Density::Discrete,
            ratio: Sampled::ONE,
            transmitted: false,
        })
    }
}

/// A metal whose surface is made of small mirrors: `f = F D G / (4 cos θ_eye cos θ_light)`
/// (Cook and Torrance 1982, normalised as by Walter et al. 2007). Black from below.
/// Mitsuba's `roughconductor`.
#[derive(Clone, Copy, Debug)]
pub struct RoughConductor<const C: usize> {
    /// What each facet is made of.
    pub facet: Conductor<C>,
    /// Distribution of the microfacets' normals.
    pub microfacets: Microfacets,
}

/// What facets reflect from one direction to another, but for the Fresnel reflectance.
#[derive(Clone, Copy, Debug)]
pub struct FacetReflection<R> {
    /// `D G / (4 cos θ_eye)`; zero where nothing is reflected.
    pub value: R,
    /// The density of sampling the direction, sr⁻¹.
    pub density: R,
    /// Between the facet's normal and the directions.
    pub cos: R,
}

impl<R: Real> FacetReflection<R> {
    /// From `eye` to `light`, in the local frame, by what facets of a normal reflect; see [`Self::about`].
    /// Both graze the surface from opposite sides where no facet can be told.
    #[inline(always)]
    pub fn between(eye: Vector<R>, light: Vector<R>, about: impl Fn(Vector<R>) -> Self) -> Self {
        let zero = R::of(0.0);
        let sum = eye + light;
        let length = sum.length();
        let found = about(sum * (R::of(1.0) / length));
        let reflects = eye.z.gt(zero) & light.z.gt(zero) & length.gt(zero);
        let only = |number: R| R::choose(reflects, number, zero);
        Self { value: only(found.value), density: only(found.density), ..found }
    }

    /// By way of the facets of normal `m`, from above.
    #[inline(always)]
    pub fn about(facets: &impl Facets<R>, eye: Vector<R>, light: Vector<R>, m: Vector<R>) -> Self {
        let (zero, one, four) = (R::of(0.0), R::of(1.0), R::of(4.0));
        let cos = eye.dot(m).greater(zero).lesser(one);
        let value = facets.d(m) * (facets.g1(eye, m) * facets.g1(light, m)) / (four * eye.z);
        // Reflection about m turns its steradians into 4 (v·m) of the reflected ray's.
        let density = facets.visible(eye, m) / (four * cos);
        Self { value, density: R::choose(cos.gt(zero), density, zero), cos }
    }

    /// `yes` where the truth holds, `no` elsewhere.
    #[inline(always)]
    pub fn choose(truth: R::Truth, yes: Self, no: Self) -> Self {
        Self {
            value: R::choose(truth, yes.value, no.value),
            density: R::choose(truth, yes.density, no.density),
            cos: R::choose(truth, yes.cos, no.cos),
        }
    }
}

impl<const C: usize> RoughConductor<C> {
    pub(super) fn evaluate(&self, toward_eye: Vec3, toward_light: Vec3) -> Evaluation<C> {
        if toward_eye.z <= 0.0 || toward_light.z <= 0.0 {
            return Evaluation::ZERO;
        }
        match (toward_eye + toward_light).try_normalize() {
            Some(m) => self.at(toward_eye, toward_light, m),
            // Both graze the surface from opposite sides: no facet can be told.
            None => Evaluation::ZERO,
        }
    }

    pub(super) fn sample(&self, toward_eye: Vec3, u: [f64; 2]) -> Option<Scatter<C>> {
        if toward_eye.z <= 0.0 {
            return None;
        }
        let m = self.microfacets.sample_visible(toward_eye, u);
        let toward_light = super::reflected(toward_eye, m);
        if toward_light.z <= 0.0 {
            return None;
        }
        let Evaluation { f_cos, density } = self.at(toward_eye, toward_light, m);
        let density = density.hero();
        (density > 0.0).then(|| Scatter {
            toward_light,
            weight: f_cos / density,
            density: Density::PerSolidAngle(density),
            ratio: Sampled::ONE,
            transmitted: false,
        })
    }

    /// Value and density of going from one direction to the other by way of the facet `m`.
    fn at(&self, toward_eye: Vec3, toward_light: Vec3, m: Vec3) -> Evaluation<C> {
        let [eye, light, m] = [toward_eye, toward_light, m].map(Vector::of);
        let alpha = self.microfacets.alpha();
        let FacetReflection { value, density, cos } = match self.microfacets.distribution() {
            Distribution::Beckmann => FacetReflection::about(&Beckmann { alpha }, eye, light, m),
            Distribution::Ggx => FacetReflection::about(&Ggx { alpha }, eye, light, m),
        };
        Evaluation { f_cos: self.facet.reflectance(cos) * value, density: Sampled::splat(density) }
    }
}
