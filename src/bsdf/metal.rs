//! The complex index of a metal, which may vary over its surface.

use crate::spectrum::Sampled;
use crate::spectrum::normal_reflectance::{dielectric_index, extinction};
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
        /// No finite index reflects everything, though a texture may come that near.
        const MOST: f64 = 1.0 - 1e-12;
        match self {
            Self::Index { n, k } => (n.sample(at, nm), k.sample(at, nm)),
            Self::NormalReflectance { reflectance, unit_index } => {
                let reflectance = reflectance.sample(at, nm).map(|value| value.clamp(0.0, MOST));
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
