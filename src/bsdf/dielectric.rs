//! A smooth interface between two transparent media.

use super::Scatter;
use super::fresnel::{self, Interface};
use crate::geometry::Vec3;
use crate::sampling::Density;
use crate::spectrum::Sampled;

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
        let both = reflected + transmitted;
        if both > 0.0 {
            Choice { reflection: reflected / both, transmission: transmitted / both }
        } else {
            Choice { reflection: 0.0, transmission: 0.0 }
        }
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
