//! What microfacets make of light: reflection and transmission from one direction to another.
//!
//! Reference: Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007.

use super::microfacet::Facets;
use crate::geometry::Vec3;
use crate::lanes::{Real, Vector};

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

/// What facets transmit from one direction to another, but for the Fresnel transmittance.
#[derive(Clone, Copy, Debug)]
pub struct FacetTransmission {
    /// `f · |cos θ_light|` of facets that transmit everything.
    pub value: f64,
    /// The density of sampling the direction, sr⁻¹.
    pub density: f64,
    /// Between the facet's normal and the eye.
    pub cos: f64,
}

impl FacetTransmission {
    /// See [`Microfacets::transmission`].
    #[inline(always)]
    pub(super) fn about(
        facets: &impl Facets<f64>,
        eye: Vec3,
        light: Vec3,
        m: Vec3,
        eta: f64,
    ) -> Option<Self> {
        let (cos, cos_light) = (eye.dot(m).min(1.0), -light.dot(m));
        if cos <= 0.0 || cos_light <= 0.0 {
            return None;
        }
        let root = cos - eta * cos_light;
        // Steradians of facets per steradian of the refracted ray, but for a factor η² (Walter et al., eq.
        // 17), which is the inverse of the compression of radiance: the value has neither.
        let jacobian = cos_light / (root * root);
        // The facets hide light below just as they hide its mirror image above.
        let [eye, opposite, m] = [eye, -light, m].map(Vector::of);
        let shadowing = facets.g1(eye, m) * facets.g1(opposite, m);
        Some(Self {
            value: facets.d(m) * shadowing * jacobian * cos / eye.z,
            density: facets.visible(eye, m) * jacobian * eta * eta,
            cos,
        })
    }
}
