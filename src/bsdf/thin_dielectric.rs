//! A thin sheet of glass.

use super::{Bsdf, Scatter, flipped, fresnel, share};
use crate::geometry::Vec3;
use crate::sampling::Density;
use crate::spectrum::{Sampled, Spectrum};
use crate::texture::{Texture, TexturePoint};

/// A window pane: two parallel smooth interfaces, too close to be told apart. Light is mirrored, or goes
/// straight on as if there were no surface. All orders of reflection between the two faces are summed
/// (interference and absorption are left out): from one face's reflectance R follow `2R/(1 + R)` for
/// both. Mitsuba's `thindielectric`, with an index for each wavelength.
///
/// As there, R is that of unpolarised light at the first face, for every order.
#[derive(Clone, Copy, Debug)]
pub struct ThinDielectric<const C: usize> {
    /// Index of the sheet over that of what surrounds it.
    pub eta: Sampled<C>,
    /// Multiplies the reflected part; 1 in nature.
    pub specular_reflectance: Sampled<C>,
    /// Multiplies the transmitted part; 1 in nature.
    pub specular_transmittance: Sampled<C>,
}

impl<const C: usize> ThinDielectric<C> {
    pub(super) fn sample(&self, toward_eye: Vec3, lobe: f64) -> Option<Scatter<C>> {
        if toward_eye.z == 0.0 {
            return None;
        }
        let reflected = self.reflected(toward_eye);
        let passed = self.null_transmittance(toward_eye);
        let reflection = reflected.zip(passed, share);
        let transmitted = lobe >= reflection.hero();
        let (carried, probability) =
            if transmitted { (passed, passed.zip(reflected, share)) } else { (reflected, reflection) };
        (probability.hero() > 0.0).then(|| Scatter {
            toward_light: if transmitted { -toward_eye } else { -flipped(toward_eye) },
            weight: carried / probability.hero(),
            density: Density::Discrete,
            ratio: probability / probability.hero(),
            transmitted,
        })
    }

    /// The fraction that goes straight on.
    pub(super) fn null_transmittance(&self, toward_eye: Vec3) -> Sampled<C> {
        self.specular_transmittance * self.reflectance(toward_eye).map(|reflectance| 1.0 - reflectance)
    }

    fn reflected(&self, toward_eye: Vec3) -> Sampled<C> {
        self.specular_reflectance * self.reflectance(toward_eye)
    }

    fn reflectance(&self, toward_eye: Vec3) -> Sampled<C> {
        self.eta.map(|eta| {
            let face = fresnel::dielectric(toward_eye.z.abs().min(1.0), eta).reflectance;
            2.0 * face / (1.0 + face)
        })
    }
}

/// A sheet of glass.
#[derive(Clone, Debug)]
pub struct ThinDielectricTextures {
    /// Refractive index of the sheet.
    pub interior: Spectrum,
    /// Refractive index around it.
    pub exterior: Spectrum,
    /// Factor on the reflectance, from 0 to 1; 1 is physical.
    pub specular_reflectance: Texture,
    /// Factor on the transmittance, from 0 to 1; 1 is physical.
    pub specular_transmittance: Texture,
}

impl ThinDielectricTextures {
    pub(super) fn bsdf<const C: usize>(&self, at: &TexturePoint, nm: &[f64; C]) -> Bsdf<C> {
        Bsdf::ThinDielectric(ThinDielectric {
            eta: self.interior.sample(nm) / self.exterior.sample(nm),
            specular_reflectance: self.specular_reflectance.sample(at, nm),
            specular_transmittance: self.specular_transmittance.sample(at, nm),
        })
    }
}
