//! Burley's "principled" surfaces, as Mitsuba 3 means them.
//!
//! A surface is a blend of a metal, a diffuse base and (in [`Principled`]) rough glass, under sheen and a
//! clear coat. Its parameters, from 0 to 1, are meant for artists and not for physics: a surface may reflect
//! more light than it receives, unless [`Albedo`] bounds it. The microfacet distribution is GGX with
//! separable masking.
//!
//! References: Burley, "Physically-Based Shading at Disney", SIGGRAPH 2012 course (base, sheen, clear
//! coat); Burley, "Extending the Disney BRDF to a BSDF with Integrated Subsurface Scattering", SIGGRAPH
//! 2015 course (glass, thin surfaces, flatness). Details in which the two leave a choice were taken from
//! values of Mitsuba 3.9.

mod albedo;
mod clear_coat;
mod solid;
mod textures;
mod thin;

pub use albedo::{Albedo, Extent};
pub use solid::Principled;
pub(crate) use textures::LEAST_INDEX;
pub use textures::{PrincipledBaseTextures, PrincipledTextures, PrincipledThinTextures};
pub use thin::PrincipledThin;

use super::fresnel::{self, Interface};
use super::microfacet::{Distribution, Microfacets};
use crate::spectrum::Sampled;
use std::f64::consts::FRAC_1_PI;

/// What both kinds of surface have. All but the colours are from 0 to 1 if not said otherwise.
#[derive(Clone, Copy, Debug)]
pub struct PrincipledBase<const C: usize> {
    /// 0–1.
    pub color: Sampled<C>,
    /// The colour over its luminance, which is what sheen and reflection are tinted with: about 1.
    pub tint: Sampled<C>,
    /// The square root of the facets' α.
    pub roughness: f64,
    /// How much longer highlights are along the frame's x axis.
    pub anisotropic: f64,
    /// Weight of glass in what is not metal.
    pub spec_trans: f64,
    /// How much the specular reflection of what is not metal is tinted.
    pub spec_tint: f64,
    /// Strength of the sheen, at least 0.
    pub sheen: f64,
    /// How much the sheen is tinted.
    pub sheen_tint: f64,
    /// Weight of the approximation to subsurface scattering in the diffuse base.
    pub flatness: f64,
}

impl<const C: usize> PrincipledBase<C> {
    /// White, smooth and diffuse.
    const WHITE: Self = Self {
        color: Sampled::ONE,
        tint: Sampled::ONE,
        roughness: 0.0,
        anisotropic: 0.0,
        spec_trans: 0.0,
        spec_tint: 0.0,
        sheen: 0.0,
        sheen_tint: 0.0,
        flatness: 0.0,
    };

    /// Facets whose roughness is `factor` times the surface's.
    fn microfacets(&self, factor: f64) -> Microfacets {
        const LEAST_ALPHA: f64 = 1e-3;
        let alpha = (factor * self.roughness).powi(2);
        let aspect = (1.0 - 0.9 * self.anisotropic).sqrt();
        Microfacets::new(
            Distribution::Ggx,
            (alpha / aspect).max(LEAST_ALPHA),
            (alpha * aspect).max(LEAST_ALPHA),
        )
    }

    /// BRDF of the diffuse base over ρ/π: diffuse and retro-reflection, blended with their flat counterpart
    /// (Hanrahan and Krueger's). The cosines are those of eye and light with the normal, and of either with
    /// the half vector.
    fn diffuse(&self, cos_eye: f64, cos_light: f64, cos_half: f64) -> f64 {
        let (eye, light) = (schlick_weight(cos_eye), schlick_weight(cos_light));
        let retro = 2.0 * self.roughness * cos_half * cos_half;
        let rough =
            (1.0 - 0.5 * eye) * (1.0 - 0.5 * light) + retro * (eye + light + eye * light * (retro - 1.0));
        if self.flatness == 0.0 {
            return rough;
        }
        let grazing = |weight: f64| mix(1.0, 0.5 * retro, weight);
        let flat = 1.25 * (grazing(eye) * grazing(light) * (1.0 / (cos_eye + cos_light) - 0.5) + 0.5);
        mix(rough, flat, self.flatness)
    }

    /// BRDF of the sheen.
    fn sheen(&self, lane: usize, cos_half: f64) -> f64 {
        if self.sheen == 0.0 {
            return 0.0;
        }
        schlick_weight(cos_half) * self.sheen_scale(lane)
    }

    fn sheen_scale(&self, lane: usize) -> f64 {
        self.sheen * mix(1.0, self.tint[lane], self.sheen_tint)
    }

    /// The tinted reflectance of an interface, which is white at grazing angles.
    fn tinted(&self, lane: usize, cos: f64, eta: f64, interface: Interface) -> f64 {
        let normal = ((eta - 1.0) / (eta + 1.0)).powi(2);
        mix(self.tint[lane] * normal, 1.0, schlick_weight(schlick_cosine(cos, eta, interface)))
    }
}

/// Reflectance of the clear coat at normal incidence.
const COAT_REFLECTANCE: f64 = 0.04;

/// Approximate albedo of sheen for all directions, for the probabilities of the lobes.
const MEAN_SHEEN: f64 = 0.1;

/// Schlick's `(1 − cos θ)⁵`.
fn schlick_weight(cos: f64) -> f64 {
    let rest = (1.0 - cos).clamp(0.0, 1.0);
    let square = rest * rest;
    square * square * rest
}

/// The angle that Schlick's weight goes by: on the side where light is faster, so that it becomes 1 at the
/// critical angle.
fn schlick_cosine(cos: f64, eta: f64, interface: Interface) -> f64 {
    if eta > 1.0 { cos } else { interface.cos_refracted }
}

fn mix(a: f64, b: f64, weight: f64) -> f64 {
    a + (b - a) * weight
}

/// Density of a cosine-weighted direction.
fn cosine_density(z: f64) -> f64 {
    z.abs() * FRAC_1_PI
}

/// The probabilities of N lobes in proportion to their weights; all 0 where nothing has any.
fn probabilities<const N: usize>(weights: [f64; N]) -> [f64; N] {
    let sum: f64 = weights.iter().sum();
    if sum > 0.0 { weights.map(|weight| weight / sum) } else { [0.0; N] }
}

/// The lobe that a uniform number in [0, 1) chooses, and the number rescaled for reuse.
fn choose<const N: usize>(probabilities: [f64; N], u: f64) -> Option<(usize, f64)> {
    let mut below = 0.0;
    let mut last = None;
    for (lobe, probability) in probabilities.into_iter().enumerate() {
        if probability > 0.0 {
            let rest = ((u - below) / probability).clamp(0.0, 1f64.next_down());
            last = Some((lobe, rest));
            below += probability;
            if u < below {
                break;
            }
        }
    }
    last
}

fn interface(cos: f64, eta: f64) -> Interface {
    fresnel::dielectric(cos.clamp(0.0, 1.0), eta)
}
