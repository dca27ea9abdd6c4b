//! Materials: textures that become a [`Bsdf`] of numbers at one point and the wavelengths of one path.
//!
//! Materials nest: one may choose between others (a mask, a blend), turn the surface (a bump or normal map)
//! or see which side is looked at. At a point all of that is gone through once, which leaves one BSDF in one
//! frame: [`Shading`]. Between nested materials one is chosen at random, with the probability that is its
//! weight.

mod even;
mod metal;
mod normal_map;
mod plastic;
mod principled;
mod roughness;
mod shading;

pub use even::Even;
pub use metal::Metal;
pub use normal_map::{NormalMap, NormalMapping};
pub use plastic::PlasticMaterial;
pub(crate) use principled::LEAST_INDEX;
pub use principled::{PrincipledMaterial, PrincipledTextures, PrincipledThinMaterial};
pub use roughness::RoughnessTextures;
pub use shading::{RoughMetal, Shading, ShadingPoint};

use crate::bsdf::{
    Bsdf, Conductor, Dielectric, DiffuseTransmitter, Lambert, RoughConductor, RoughDielectric, ThinDielectric,
};
use crate::spectrum::{Sampled, Spectrum};
use crate::texture::{Texture, TexturePoint};
use std::collections::BTreeSet;

/// Index into [`Materials`].
pub type MaterialId = u32;

/// What a surface is made of.
#[derive(Clone, Debug)]
pub enum Material {
    /// Absorbs everything.
    Black,
    /// Nothing: light passes as if there were no surface.
    Null,
    /// A Lambertian surface, black on its back.
    Diffuse {
        /// Fraction of the light that is reflected, from 0 to 1.
        reflectance: Texture,
    },
    /// A sheet that reflects and transmits diffusely.
    DiffuseTransmitter {
        /// Fraction of the light that is reflected, from 0 to 1.
        reflectance: Texture,
        /// Fraction of the light that is transmitted, from 0 to 1.
        transmittance: Texture,
    },
    /// A metal against vacuum.
    Conductor {
        /// What its index comes from.
        index: Metal,
        /// Factor on the reflectance, from 0 to 1; 1 is physical.
        specular_reflectance: Texture,
        /// Roughness; `None` for a polished surface.
        roughness: Option<RoughnessTextures>,
    },
    /// The surface of a transparent body.
    Dielectric(DielectricMaterial),
    /// A transparent sheet.
    ThinDielectric(ThinDielectricMaterial),
    /// A coat on a diffuse base.
    Plastic(PlasticMaterial),
    /// Disney's material for solids.
    Principled(Box<PrincipledMaterial>),
    /// Disney's material for thin sheets.
    PrincipledThin(Box<PrincipledThinMaterial>),
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

/// A transparent body's surface.
#[derive(Clone, Debug)]
pub struct DielectricMaterial {
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

/// A sheet of glass.
#[derive(Clone, Debug)]
pub struct ThinDielectricMaterial {
    /// Refractive index of the sheet.
    pub interior: Spectrum,
    /// Refractive index around it.
    pub exterior: Spectrum,
    /// Factor on the reflectance, from 0 to 1; 1 is physical.
    pub specular_reflectance: Texture,
    /// Factor on the transmittance, from 0 to 1; 1 is physical.
    pub specular_transmittance: Texture,
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

    /// Whether it is smooth whatever is chosen: it sends light on in single directions alone, the same way
    /// forth and back.
    pub fn is_smooth(&self, id: MaterialId) -> bool {
        match self.get(id) {
            Material::TwoSided { front, back } => self.is_smooth(*front) && self.is_smooth(*back),
            Material::Conductor { roughness, .. } => roughness.is_none(),
            Material::Dielectric(dielectric) => dielectric.roughness.is_none(),
            _ => false,
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
            Material::Dielectric(dielectric) => Some(&dielectric.interior),
            _ => None,
        })
    }
}

impl Material {
    fn nested(&self) -> [Option<MaterialId>; 2] {
        match self {
            Self::TwoSided { front, back } => [Some(*front), Some(*back)],
            Self::Blend { nested: [first, second], .. } => [Some(*first), Some(*second)],
            Self::Mask { nested, .. } | Self::NormalMapping { nested, .. } => [Some(*nested), None],
            Self::Black
            | Self::Null
            | Self::Diffuse { .. }
            | Self::DiffuseTransmitter { .. }
            | Self::Conductor { .. }
            | Self::Dielectric(_)
            | Self::ThinDielectric(_)
            | Self::Plastic(_)
            | Self::Principled(_)
            | Self::PrincipledThin(_) => [None, None],
        }
    }

    /// Whether one of several BSDFs is chosen at random.
    pub fn chooses(&self) -> bool {
        matches!(self, Self::Mask { .. } | Self::Blend { .. })
    }

    /// Whether light may pass by null transmission: straight on, as if there were no surface.
    pub fn has_null_transmission(&self) -> bool {
        matches!(self, Self::Null | Self::Mask { .. } | Self::ThinDielectric(_))
    }

    /// Whether light may get to the other side.
    pub fn transmits(&self) -> bool {
        match self {
            Self::Null
            | Self::Mask { .. }
            | Self::Dielectric(_)
            | Self::DiffuseTransmitter { .. }
            | Self::ThinDielectric(_)
            | Self::PrincipledThin(_) => true,
            Self::Principled(principled) => principled.glass,
            _ => false,
        }
    }

    /// Whether directions are spread by a roughness.
    pub fn is_rough(&self) -> bool {
        match self {
            Self::Plastic(plastic) => plastic.coat.is_some(),
            Self::Principled(_) | Self::PrincipledThin(_) => true,
            _ => self.roughness().is_some(),
        }
    }

    /// Whether it asks for the surface's coordinates.
    pub fn is_parametrised(&self) -> bool {
        let anisotropic = match self {
            Self::Principled(principled) => principled.textures.is_anisotropic(),
            Self::PrincipledThin(thin) => thin.textures.is_anisotropic(),
            _ => self.roughness().is_some_and(RoughnessTextures::is_anisotropic),
        };
        anisotropic
            || matches!(self, Self::NormalMapping { .. })
            || self.textures().iter().any(|t| t.varies())
    }

    /// Whether wavelengths may part at this surface.
    pub fn disperses(&self) -> bool {
        match self {
            Self::Dielectric(d) => {
                !d.interior.is_constant()
                    || d.exterior.as_ref().is_some_and(|exterior| !exterior.is_constant())
            }
            _ => false,
        }
    }

    fn roughness(&self) -> Option<&RoughnessTextures> {
        match self {
            Self::Conductor { roughness, .. } => roughness.as_ref(),
            Self::Dielectric(dielectric) => dielectric.roughness.as_ref(),
            _ => None,
        }
    }

    /// All textures but those of a bump or normal map.
    fn textures(&self) -> Vec<&Texture> {
        match self {
            Self::Diffuse { reflectance } => vec![reflectance],
            Self::DiffuseTransmitter { reflectance, transmittance } => vec![reflectance, transmittance],
            Self::Conductor { index, specular_reflectance, roughness } => {
                let roughness = roughness.iter().flat_map(RoughnessTextures::textures);
                roughness.chain(index.textures()).chain([specular_reflectance]).collect()
            }
            Self::Dielectric(dielectric) => {
                let factors = [&dielectric.specular_reflectance, &dielectric.specular_transmittance];
                dielectric.roughness.iter().flat_map(RoughnessTextures::textures).chain(factors).collect()
            }
            Self::ThinDielectric(pane) => vec![&pane.specular_reflectance, &pane.specular_transmittance],
            Self::Plastic(plastic) => vec![&plastic.diffuse_reflectance, &plastic.specular_reflectance],
            Self::Principled(principled) => principled.all_textures(),
            Self::PrincipledThin(thin) => thin.all_textures(),
            Self::Mask { opacity: texture, .. } | Self::Blend { weight: texture, .. } => vec![texture],
            Self::Black | Self::Null | Self::TwoSided { .. } | Self::NormalMapping { .. } => Vec::new(),
        }
    }

    /// The numbers at a point and the wavelengths of a path. `exterior` is the index of what surrounds the
    /// surface, for bodies that leave it open. A material that nests is [`Bsdf::Black`]: it is gone through
    /// before.
    fn bsdf<const C: usize>(&self, at: &TexturePoint, nm: &[f64; C], exterior: Exterior<'_>) -> Bsdf<C> {
        match self {
            Self::Black
            | Self::TwoSided { .. }
            | Self::Mask { .. }
            | Self::Blend { .. }
            | Self::NormalMapping { .. } => Bsdf::Black,
            Self::Null => Bsdf::Null,
            Self::Diffuse { reflectance } => {
                Bsdf::Lambert(Lambert { reflectance: reflectance.sample(at, nm) })
            }
            Self::DiffuseTransmitter { reflectance, transmittance } => {
                Bsdf::DiffuseTransmitter(DiffuseTransmitter {
                    reflectance: reflectance.sample(at, nm),
                    transmittance: transmittance.sample(at, nm),
                })
            }
            Self::Conductor { index, specular_reflectance, roughness } => {
                let (eta, k) = index.sample(at, nm);
                let specular_reflectance = specular_reflectance.sample(at, nm);
                let facet = Conductor { eta, k, specular_reflectance };
                match roughness {
                    None => Bsdf::Conductor(facet),
                    Some(roughness) => {
                        Bsdf::RoughConductor(RoughConductor { facet, microfacets: roughness.microfacets(at) })
                    }
                }
            }
            Self::Dielectric(dielectric) => dielectric.bsdf(at, nm, exterior),
            Self::ThinDielectric(pane) => pane.bsdf(at, nm),
            Self::Plastic(plastic) => plastic.bsdf(at, nm),
            Self::Principled(principled) => principled.bsdf(at, nm),
            Self::PrincipledThin(thin) => thin.bsdf(at, nm),
        }
    }
}

impl DielectricMaterial {
    fn bsdf<const C: usize>(&self, at: &TexturePoint, nm: &[f64; C], exterior: Exterior<'_>) -> Bsdf<C> {
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

impl ThinDielectricMaterial {
    fn bsdf<const C: usize>(&self, at: &TexturePoint, nm: &[f64; C]) -> Bsdf<C> {
        Bsdf::ThinDielectric(ThinDielectric {
            eta: self.interior.sample(nm) / self.exterior.sample(nm),
            specular_reflectance: self.specular_reflectance.sample(at, nm),
            specular_transmittance: self.specular_transmittance.sample(at, nm),
        })
    }
}
