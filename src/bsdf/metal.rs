//! The complex index of a metal, which may vary over its surface.

use super::{BsdfTextures, Conductor, Microfacets, RoughConductor};
use crate::spectrum::normal_reflectance::{dielectric_index, extinction};
use crate::spectrum::{Sampled, Spectrum};
use crate::texture::{Texture, TexturePoint};

/// Where n and k of a metal come from.
#[derive(Clone, Debug)]
pub enum Metal {
    /// By its complex index.
    Index {
        /// Real part of the index.
        n: Texture,
        /// Imaginary part of the index, at least 0.
        k: Texture,
    },
    /// The reflectance at normal incidence, which leaves one of the two open: with `unit_index` n = 1, else
    /// k = 0.
    NormalReflectance {
        /// Reflectance at normal incidence, from 0 to below 1.
        reflectance: Texture,
        /// Whether n is 1; k is 0 otherwise.
        unit_index: bool,
    },
}

impl Metal {
    /// n and k at a point and the wavelengths (nm) of a path.
    pub fn sample<const C: usize>(&self, at: &TexturePoint, nm: &[f64; C]) -> (Sampled<C>, Sampled<C>) {
        self.by(|texture| texture.sample(at, nm))
    }

    /// n and k by what the textures have.
    fn by<const C: usize>(&self, sample: impl Fn(&Texture) -> Sampled<C>) -> (Sampled<C>, Sampled<C>) {
        /// No finite index reflects everything, though a texture may come that near.
        const MOST: f64 = 1.0 - 1e-12;
        match self {
            Self::Index { n, k } => (sample(n), sample(k)),
            Self::NormalReflectance { reflectance, unit_index } => {
                let reflectance = sample(reflectance).map(|value| value.clamp(0.0, MOST));
                match unit_index {
                    true => (Sampled::ONE, reflectance.map(|value| extinction(value, 1.0))),
                    false => (reflectance.map(dielectric_index), Sampled::ZERO),
                }
            }
        }
    }

    pub(super) fn textures(&self) -> Vec<&Texture> {
        match self {
            Self::Index { n, k } => vec![n, k],
            Self::NormalReflectance { reflectance, .. } => vec![reflectance],
        }
    }
}

/// A rough metal that is the same all over a surface.
#[derive(Clone, Debug)]
pub struct EvenRoughMetal {
    index: Metal,
    specular_reflectance: Spectrum,
    microfacets: Microfacets,
}

impl EvenRoughMetal {
    /// `None` for all else.
    pub fn of(bsdf: &BsdfTextures) -> Option<Self> {
        let BsdfTextures::Conductor { index, specular_reflectance, roughness: Some(roughness) } = bsdf else {
            return None;
        };
        let is_even = index.textures().iter().all(|texture| texture.uniform().is_some());
        let specular_reflectance = specular_reflectance.uniform().filter(|_| is_even)?.clone();
        Some(Self { index: index.clone(), specular_reflectance, microfacets: roughness.even()? })
    }

    /// At the wavelengths (nm) of a path.
    pub fn sample<const C: usize>(&self, nm: &[f64; C]) -> RoughConductor<C> {
        let of = |texture: &Texture| texture.uniform().map_or(Sampled::ZERO, |spectrum| spectrum.sample(nm));
        let (eta, k) = self.index.by(of);
        let facet = Conductor { eta, k, specular_reflectance: self.specular_reflectance.sample(nm) };
        RoughConductor { facet, microfacets: self.microfacets }
    }
}
