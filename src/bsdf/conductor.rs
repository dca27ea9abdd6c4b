//! Opaque metal, smooth and rough.

use super::facets::FacetReflection;
use super::microfacet::Microfacets;
use super::{Evaluation, Scatter, flipped, fresnel};
use crate::geometry::Vec3;
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
        Scatter::with_density(toward_light, f_cos, density, false)
    }

    /// Value and density of going from one direction to the other by way of the facet `m`.
    fn at(&self, toward_eye: Vec3, toward_light: Vec3, m: Vec3) -> Evaluation<C> {
        let FacetReflection { value, density, cos } =
            self.microfacets.reflection(toward_eye, toward_light, m);
        Evaluation { f_cos: self.facet.reflectance(cos) * value, density: Sampled::splat(density) }
    }
}
