//! A smooth interface between two transparent media.

use super::fresnel::{self, Interface};
use super::{Bsdf, RoughDielectric, RoughnessTextures, Scatter, share};
use crate::geometry::Vec3;
use crate::sampling::Density;
use crate::spectrum::{Sampled, Spectrum};
use crate::texture::{Texture, TexturePoint};

/// A smooth interface between two dielectrics: a mirror and a window at once, from both sides.
/// Mitsuba's `dielectric`, with an index for each wavelength.
///
/// A companion wavelength follows a reflection always, but a refraction only if its index is the
/// hero's: otherwise it goes elsewhere and its weight and ratio are 0.
#[derive(Clone, Copy, Debug)]
pub struct Dielectric<const C: usize> {
    /// Index of the medium below (z < 0) over that of the medium above.
    pub eta: Sampled<C>,
    /// Multiplies the reflected part; 1 in nature.
    pub specular_reflectance: Sampled<C>,
    /// Multiplies the transmitted part; 1 in nature.
    pub specular_transmittance: Sampled<C>,
}

impl<const C: usize> Dielectric<C> {
    pub(super) fn sample(&self, toward_eye: Vec3, lobe: f64) -> Option<Scatter<C>> {
        if toward_eye.z == 0.0 {
            return None;
        }
        let eta = self.eta_toward(toward_eye.z > 0.0);
        let interfaces = interfaces(toward_eye.z.abs().min(1.0), eta);
        let choice = |lane: usize| self.choice(lane, interfaces[lane].reflectance);
        let reflection = Sampled(std::array::from_fn(|lane| choice(lane).reflection));
        if lobe < reflection.hero() {
            let reflected = |lane| self.specular_reflectance[lane] * interfaces[lane].reflectance;
            return Some(Scatter {
                toward_light: Vec3::new(-toward_eye.x, -toward_eye.y, toward_eye.z),
                weight: Sampled(std::array::from_fn(reflected)) / reflection.hero(),
                density: Density::Discrete,
                ratio: reflection / reflection.hero(),
                transmitted: false,
            });
        }
        let follows = |lane: usize| eta[lane] == eta.hero();
        let transmission =
            Sampled(std::array::from_fn(|lane| if follows(lane) { choice(lane).transmission } else { 0.0 }));
        if transmission.hero() <= 0.0 {
            return None;
        }
        let hero = interfaces[0];
        let compressed = (1.0 - hero.reflectance) / (eta.hero() * eta.hero());
        let transmitted =
            |lane| if follows(lane) { self.specular_transmittance[lane] * compressed } else { 0.0 };
        Some(Scatter {
            toward_light: Vec3::new(
                -toward_eye.x / eta.hero(),
                -toward_eye.y / eta.hero(),
                -hero.cos_refracted.copysign(toward_eye.z),
            ),
            weight: Sampled(std::array::from_fn(transmitted)) / transmission.hero(),
            density: Density::Discrete,
            ratio: transmission / transmission.hero(),
            transmitted: true,
        })
    }

    /// The hero's probability of reflecting, exactly as [`Self::sample`] takes it.
    pub(super) fn reflection_probability(&self, toward_eye: Vec3) -> f64 {
        let eta = self.eta_toward(toward_eye.z > 0.0).hero();
        self.choice(0, fresnel::dielectric(toward_eye.z.abs().min(1.0), eta).reflectance).reflection
    }

    /// Index of the far side over that of the near side, for a ray that comes from above or not.
    pub(super) fn eta_toward(&self, from_above: bool) -> Sampled<C> {
        if from_above { self.eta } else { self.eta.map(f64::recip) }
    }

    /// With which probabilities a lane, were it the hero, would choose to reflect or to transmit:
    /// in proportion to what either carries.
    pub(super) fn choice(&self, lane: usize, reflectance: f64) -> Choice {
        let reflected = self.specular_reflectance[lane] * reflectance;
        let transmitted = self.specular_transmittance[lane] * (1.0 - reflectance);
        Choice { reflection: share(reflected, transmitted), transmission: share(transmitted, reflected) }
    }
}

/// The probabilities of the two ways to go. Both are 0 where neither carries anything.
#[derive(Clone, Copy)]
pub(super) struct Choice {
    pub reflection: f64,
    pub transmission: f64,
}

/// Fresnel's equations for every lane; worked out once where all indices are the same.
pub(super) fn interfaces<const C: usize>(cos: f64, eta: Sampled<C>) -> [Interface; C] {
    let hero = fresnel::dielectric(cos, eta.hero());
    eta.0.map(|eta_lane| if eta_lane == eta.hero() { hero } else { fresnel::dielectric(cos, eta_lane) })
}

/// A transparent body's surface.
#[derive(Clone, Debug)]
pub struct DielectricTextures {
    /// Index on the inside.
    pub interior: Spectrum,
    /// Index on the outside; `None` where it is that of whatever surrounds the body.
    pub exterior: Option<Spectrum>,
    /// Factor on the reflectance, from 0 to 1; 1 is physical.
    pub specular_reflectance: Texture,
    /// Factor on the transmittance, from 0 to 1; 1 is physical.
    pub specular_transmittance: Texture,
    /// Roughness; `None` for a polished surface.
    pub roughness: Option<RoughnessTextures>,
}

impl DielectricTextures {
    pub(super) fn bsdf<const C: usize>(
        &self,
        at: &TexturePoint,
        nm: &[f64; C],
        exterior: Exterior<'_>,
    ) -> Bsdf<C> {
        let outside = match self.exterior.as_ref().filter(|_| !exterior.coincident).or(exterior.index) {
            Some(index) => index.sample(nm),
            None => Sampled::splat(AIR_INDEX),
        };
        let facet = Dielectric {
            eta: self.interior.sample(nm) / outside,
            specular_reflectance: self.specular_reflectance.sample(at, nm),
            specular_transmittance: self.specular_transmittance.sample(at, nm),
        };
        match &self.roughness {
            None => Bsdf::Dielectric(facet),
            Some(roughness) => {
                Bsdf::RoughDielectric(RoughDielectric { facet, microfacets: roughness.microfacets(at) })
            }
        }
    }
}

/// What is on the other side of a body's surface.
#[derive(Clone, Copy, Debug)]
pub struct Exterior<'a> {
    /// The index there; `None` in air.
    pub index: Option<&'a Spectrum>,
    /// Whether another body ends or begins there, so that what the surface's own material says of its outside
    /// does not count.
    pub coincident: bool,
}

impl Exterior<'_> {
    /// For materials that are evaluated without knowledge of what is around.
    pub const UNKNOWN: Self = Self { index: None, coincident: false };
}

/// Index of air at standard conditions as Mitsuba 3 has it: what surrounds a body in nothing else.
pub const AIR_INDEX: f64 = 1.000_277;
