//! A diffuse surface, and a diffuse sheet that also transmits light.

use super::{Evaluation, Scatter, share};
use crate::geometry::Vec3;
use crate::sampling::{Density, warp};
use crate::spectrum::Sampled;
use std::f64::consts::FRAC_1_PI;

/// A diffuse opaque surface: `f = ρ/π` above, black from below. Mitsuba's `diffuse`.
#[derive(Clone, Copy, Debug)]
pub struct Lambert<const C: usize> {
    /// ρ, 0–1.
    pub reflectance: Sampled<C>,
}

impl<const C: usize> Lambert<C> {
    pub(super) fn evaluate(&self, toward_eye: Vec3, toward_light: Vec3) -> Evaluation<C> {
        if toward_eye.z <= 0.0 || toward_light.z <= 0.0 {
            return Evaluation::ZERO;
        }
        let density = toward_light.z * FRAC_1_PI;
        Evaluation { f_cos: self.reflectance * density, density: Sampled::splat(density) }
    }

    pub(super) fn sample(&self, toward_eye: Vec3, u: [f64; 2]) -> Option<Scatter<C>> {
        let toward_light = Vec3::from(warp::cosine_hemisphere(u));
        if toward_eye.z <= 0.0 || toward_light.z <= 0.0 {
            return None;
        }
        Some(Scatter {
            toward_light,
            weight: self.reflectance,
            density: Density::PerSolidAngle(toward_light.z * FRAC_1_PI),
            ratio: Sampled::ONE,
            transmitted: false,
        })
    }
}

/// A thin diffuse sheet, the same from both sides. It scatters the fraction `reflectance` evenly to the side
/// of incidence and the fraction `transmittance` evenly to the other side.
#[derive(Clone, Copy, Debug)]
pub struct DiffuseTransmitter<const C: usize> {
    /// Fraction of the light that is reflected, from 0 to 1.
    pub reflectance: Sampled<C>,
    /// Fraction transmitted; at most 1 together with the reflectance.
    pub transmittance: Sampled<C>,
}

impl<const C: usize> DiffuseTransmitter<C> {
    pub(super) fn evaluate(&self, toward_eye: Vec3, toward_light: Vec3) -> Evaluation<C> {
        let side = toward_eye.z * toward_light.z;
        if side == 0.0 {
            return Evaluation::ZERO;
        }
        let (fraction, probability) = self.lobe(side < 0.0);
        let cosine = toward_light.z.abs() * FRAC_1_PI;
        Evaluation { f_cos: fraction * cosine, density: probability * cosine }
    }

    pub(super) fn sample(&self, toward_eye: Vec3, lobe: f64, u: [f64; 2]) -> Option<Scatter<C>> {
        let up = Vec3::from(warp::cosine_hemisphere(u));
        let transmitted = lobe >= share(self.reflectance.hero(), self.transmittance.hero());
        let (fraction, probability) = self.lobe(transmitted);
        if toward_eye.z == 0.0 || up.z <= 0.0 || probability.hero() <= 0.0 {
            return None;
        }
        let above = (toward_eye.z > 0.0) != transmitted;
        Some(Scatter {
            toward_light: if above { up } else { super::flipped(up) },
            weight: fraction / probability.hero(),
            density: Density::PerSolidAngle(probability.hero() * up.z * FRAC_1_PI),
            ratio: probability / probability.hero(),
            transmitted,
        })
    }

    /// The fraction that a lobe carries, and each lane's probability of choosing it.
    fn lobe(&self, transmitted: bool) -> (Sampled<C>, Sampled<C>) {
        let (fraction, rest) = if transmitted {
            (self.transmittance, self.reflectance)
        } else {
            (self.reflectance, self.transmittance)
        };
        (fraction, fraction.zip(rest, share))
    }
}
