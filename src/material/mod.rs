//! Materials: what a surface is made of, a BSDF or several that nest.
//!
//! A material may choose between others (a mask, a blend), turn the surface (a bump or normal map)
//! or see which side is looked at. At a point all of that is gone through once, which leaves one BSDF in one
//! frame: [`Shading`]. Between nested materials one is chosen at random, with the probability that is its
//! weight.

mod even;
mod normal_map;
mod shading;

pub use even::Even;
pub use normal_map::{NormalMap, NormalMapping};
pub use shading::{RoughMetal, Shading, ShadingPoint};

use crate::bsdf::{BsdfTextures, Specular};
use crate::spectrum::Spectrum;
use crate::texture::Texture;
use std::collections::BTreeSet;

/// Index into [`Materials`].
pub type MaterialId = u32;

/// What a surface is made of.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "most materials are of the large variant, and are few")]
pub enum Material {
    /// Nests no other.
    Bsdf(BsdfTextures),
    /// One material in front, another or the same behind; each sees the surface from its own front.
    TwoSided {
        /// Material of the front.
        front: MaterialId,
        /// Material of the back.
        back: MaterialId,
    },
    /// Covers a fraction of the surface, the opacity; light passes the rest by null transmission.
    Mask {
        /// Fraction of the surface that is covered, from 0 to 1.
        opacity: Texture,
        /// What covers it.
        nested: MaterialId,
    },
    /// The second material with a probability, the first otherwise.
    Blend {
        /// Probability of the second, from 0 to 1.
        weight: Texture,
        /// The two materials.
        nested: [MaterialId; 2],
    },
    /// A material on a surface whose shading normal varies.
    NormalMapping {
        /// How the normal varies.
        mapping: NormalMapping,
        /// The material that is shaded so.
        nested: MaterialId,
    },
}

/// The materials of a scene. What nests comes after what it holds.
#[derive(Clone, Debug, Default)]
pub struct Materials(Vec<Material>);

impl Materials {
    /// Adds a material and returns its number.
    pub fn add(&mut self, material: Material) -> MaterialId {
        self.0.push(material);
        self.0.len() as MaterialId - 1
    }

    /// The material of a number that [`Self::add`] returned.
    pub fn get(&self, id: MaterialId) -> &Material {
        &self.0[id as usize]
    }

    /// All of them, in the order of their numbers.
    pub fn iter(&self) -> impl Iterator<Item = &Material> {
        self.0.iter()
    }

    /// A material and all within it, each once however often it is shared, the outermost first.
    fn within(&self, id: MaterialId) -> impl Iterator<Item = &Material> {
        let (mut waiting, mut met) = (vec![id], BTreeSet::from([id]));
        std::iter::from_fn(move || {
            let material = self.get(waiting.pop()?);
            let nested = material.nested().into_iter().flatten().rev();
            waiting.extend(nested.filter(|&nested| met.insert(nested)));
            Some(material)
        })
    }

    /// Whether a material or one within it has a property.
    pub fn any(&self, id: MaterialId, has: &impl Fn(&Material) -> bool) -> bool {
        self.within(id).any(has)
    }

    /// Whether light may pass by null transmission: straight on, as if there were no surface.
    pub fn has_null_transmission(&self, id: MaterialId) -> bool {
        self.any(id, &Material::itself_has_null_transmission)
    }

    /// Whether light may get to the other side.
    pub fn transmits(&self, id: MaterialId) -> bool {
        self.any(id, &Material::itself_transmits)
    }

    /// Whether it asks for the surface's coordinates.
    pub fn is_parametrised(&self, id: MaterialId) -> bool {
        self.any(id, &Material::itself_is_parametrised)
    }

    /// What it sends on in single directions: on the side that sends more, but nearly specular counts only if
    /// both sides are. Nothing counts where a side is chosen or turned, or where light may pass it by null
    /// transmission.
    pub fn specular(&self, id: MaterialId) -> Specular {
        let of_side = |id: MaterialId| match self.get(id) {
            Material::Bsdf(bsdf) if !bsdf.has_null_transmission() => Some(bsdf.specular()),
            _ => None,
        };
        let sides = match self.get(id) {
            Material::TwoSided { front, back } => of_side(*front).zip(of_side(*back)),
            _ => of_side(id).map(|side| (side, side)),
        };
        match sides {
            Some((Specular::Nothing, Specular::Nearly) | (Specular::Nearly, Specular::Nothing)) | None => {
                Specular::Nothing
            }
            Some((front, back)) => front.max(back),
        }
    }

    /// The attributes that textures of a material and those within it want of a mesh.
    pub fn attributes(&self, id: MaterialId) -> Vec<&str> {
        self.within(id).flat_map(Material::textures).flat_map(Texture::attributes).collect()
    }

    /// The material below what only turns the surface.
    pub fn below_normal_map(&self, id: MaterialId) -> &Material {
        match self.get(id) {
            Material::NormalMapping { nested, .. } => self.below_normal_map(*nested),
            material => material,
        }
    }

    /// The index on the inside of the first dielectric within a material.
    pub fn interior_index(&self, id: MaterialId) -> Option<&Spectrum> {
        self.within(id).find_map(|material| match material {
            Material::Bsdf(BsdfTextures::Dielectric(dielectric)) => Some(&dielectric.interior),
            _ => None,
        })
    }
}

impl Material {
    fn nested(&self) -> [Option<MaterialId>; 2] {
        match self {
            Self::Bsdf(_) => [None, None],
            Self::TwoSided { front, back } => [Some(*front), Some(*back)],
            Self::Blend { nested: [first, second], .. } => [Some(*first), Some(*second)],
            Self::Mask { nested, .. } | Self::NormalMapping { nested, .. } => [Some(*nested), None],
        }
    }

    /// The BSDF that it is, if it nests no other.
    pub fn bsdf(&self) -> Option<&BsdfTextures> {
        match self {
            Self::Bsdf(bsdf) => Some(bsdf),
            _ => None,
        }
    }

    /// Whether one of several BSDFs is chosen at random.
    pub fn chooses(&self) -> bool {
        matches!(self, Self::Mask { .. } | Self::Blend { .. })
    }

    /// Whether light may pass by null transmission of its own, not of what it nests.
    fn itself_has_null_transmission(&self) -> bool {
        match self {
            Self::Mask { .. } => true,
            _ => self.bsdf().is_some_and(BsdfTextures::has_null_transmission),
        }
    }

    /// Whether it lets light get to the other side itself, not by what it nests.
    fn itself_transmits(&self) -> bool {
        match self {
            Self::Mask { .. } => true,
            _ => self.bsdf().is_some_and(BsdfTextures::transmits),
        }
    }

    /// Whether directions are spread by a roughness of its own, not of what it nests.
    pub fn is_rough(&self) -> bool {
        self.bsdf().is_some_and(BsdfTextures::is_rough)
    }

    /// Whether it asks for the surface's coordinates itself, not for what it nests.
    fn itself_is_parametrised(&self) -> bool {
        matches!(self, Self::NormalMapping { .. })
            || self.bsdf().is_some_and(BsdfTextures::is_anisotropic)
            || self.textures().iter().any(|texture| texture.varies())
    }

    /// Whether wavelengths may part at it, not at what it nests.
    pub fn disperses(&self) -> bool {
        self.bsdf().is_some_and(BsdfTextures::disperses)
    }

    /// All textures but those of a bump or normal map.
    fn textures(&self) -> Vec<&Texture> {
        match self {
            Self::Bsdf(bsdf) => bsdf.textures(),
            Self::Mask { opacity: texture, .. } | Self::Blend { weight: texture, .. } => vec![texture],
            Self::TwoSided { .. } | Self::NormalMapping { .. } => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::microfacet::Distribution;
    use crate::bsdf::{Metal, RoughnessTextures};
    use crate::spectrum::Spectrum;

    /// What is nearly specular is so on both sides.
    #[test]
    fn a_polished_side_with_another_behind_it_counts_for_nothing() {
        let mut materials = Materials::default();
        let uniform = |value| Texture::Uniform(Spectrum::Constant(value));
        let metal = |alpha: Option<f64>| {
            Material::Bsdf(BsdfTextures::Conductor {
                index: Metal::Index { n: uniform(0.2), k: uniform(3.0) },
                specular_reflectance: uniform(1.0),
                roughness: alpha.map(|alpha| RoughnessTextures {
                    distribution: Distribution::Ggx,
                    alpha: [uniform(alpha), uniform(alpha)],
                    isotropic: true,
                }),
            })
        };
        let [smooth, polished, rough] = [None, Some(0.1), Some(0.5)].map(|alpha| materials.add(metal(alpha)));
        let white = materials.add(Material::Bsdf(BsdfTextures::Diffuse { reflectance: uniform(0.9) }));
        for (front, back, expected) in [
            (polished, polished, Specular::Nearly),
            (polished, white, Specular::Nothing),
            (white, polished, Specular::Nothing),
            (polished, rough, Specular::Nothing),
            (polished, smooth, Specular::All),
            (smooth, white, Specular::All),
        ] {
            let both = materials.add(Material::TwoSided { front, back });
            assert_eq!(materials.specular(both), expected, "{front} {back}");
        }
        assert_eq!(materials.specular(polished), Specular::Nearly);
    }
}
