//! Plastic: a diffuse base under a smooth or rough coat.

use crate::bsdf::{Bsdf, DiffuseBase, Plastic, RoughCoat, RoughPlastic};
use crate::spectrum::Spectrum;
use crate::texture::{Texture, TexturePoint};

/// A diffuse base under a coat.
#[derive(Clone, Debug)]
pub struct PlasticMaterial {
    /// Refractive index of the coat.
    pub interior: Spectrum,
    /// Refractive index around it.
    pub exterior: Spectrum,
    /// Reflectance of the diffuse base, from 0 to 1.
    pub diffuse_reflectance: Texture,
    /// Factor on the coat's reflectance, from 0 to 1; 1 is physical.
    pub specular_reflectance: Texture,
    /// Whether light that is reflected inside is coloured each time.
    pub nonlinear: bool,
    /// A rough coat; its indices are those above.
    pub coat: Option<&'static RoughCoat>,
}

impl PlasticMaterial {
    pub(super) fn bsdf<const C: usize>(&self, at: &TexturePoint, nm: &[f64; C]) -> Bsdf<C> {
        let base =
            DiffuseBase { reflectance: self.diffuse_reflectance.sample(at, nm), nonlinear: self.nonlinear };
        let specular_reflectance = self.specular_reflectance.sample(at, nm);
        match self.coat {
            Some(coat) => Bsdf::RoughPlastic(RoughPlastic { coat, base, specular_reflectance }),
            None => Bsdf::Plastic(Plastic {
                eta: self.interior.sample(nm) / self.exterior.sample(nm),
                base,
                specular_reflectance,
            }),
        }
    }
}
