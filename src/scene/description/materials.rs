//! BSDFs as a scene file says them.

use super::spectra::{IndexSource, SpectrumSource};
use crate::bsdf::MeasuredTable;
use crate::bsdf::microfacet::Distribution;
use crate::scene::source::Place;
use std::path::PathBuf;
use std::sync::Arc;

/// How a surface scatters.
#[derive(Clone, Debug)]
pub struct Bsdf {
    /// Where the file declares it.
    pub place: Place,
    /// The name under which the file defines it, if any.
    pub id: Option<String>,
    /// Which BSDF it is, with its parameters.
    pub kind: BsdfKind,
}

/// How a surface scatters, by Mitsuba's models.
#[derive(Clone, Debug)]
pub enum BsdfKind {
    /// `diffuse`: Lambertian, black on its back.
    Diffuse {
        /// Fraction of the light that is reflected, from 0 to 1.
        reflectance: SpectrumSource,
    },
    /// Lambertian on both sides (an extension).
    DiffuseTransmitter {
        /// Fraction of the light that is reflected, from 0 to 1.
        reflectance: SpectrumSource,
        /// Fraction of the light that is transmitted, from 0 to 1.
        transmittance: SpectrumSource,
    },
    /// `conductor` without and `roughconductor` with a roughness.
    Conductor {
        /// Index n and k of the metal.
        index: ConductorIndex,
        /// Factor on the reflectance, from 0 to 1; 1 is physical.
        specular_reflectance: SpectrumSource,
        /// Roughness; `None` for a polished surface.
        roughness: Option<Roughness>,
    },
    /// `dielectric` without and `roughdielectric` with a roughness.
    Dielectric {
        /// Refractive index inside.
        interior: IndexSource,
        /// `None` where the file leaves it out: then it is what surrounds the surface, air outside
        /// everything.
        exterior: Option<IndexSource>,
        /// Factor on the reflectance, from 0 to 1; 1 is physical.
        specular_reflectance: SpectrumSource,
        /// Factor on the transmittance, from 0 to 1; 1 is physical.
        specular_transmittance: SpectrumSource,
        /// Roughness; `None` for a polished surface.
        roughness: Option<Roughness>,
    },
    /// `thindielectric`: a sheet of glass, in air where the file doesn't say otherwise.
    ThinDielectric {
        /// Refractive index of the sheet.
        interior: IndexSource,
        /// Refractive index around it; `None` for air.
        exterior: Option<IndexSource>,
        /// Factor on the reflectance, from 0 to 1; 1 is physical.
        specular_reflectance: SpectrumSource,
        /// Factor on the transmittance, from 0 to 1; 1 is physical.
        specular_transmittance: SpectrumSource,
    },
    /// `plastic` without and `roughplastic` with a roughness: a coat on a diffuse base, in air where the file
    /// doesn't say otherwise.
    Plastic {
        /// Refractive index of the coat.
        interior: IndexSource,
        /// Refractive index around it; `None` for air.
        exterior: Option<IndexSource>,
        /// Reflectance of the diffuse base, from 0 to 1.
        diffuse_reflectance: SpectrumSource,
        /// Factor on the coat's reflectance, from 0 to 1; 1 is physical.
        specular_reflectance: SpectrumSource,
        /// Whether light that is reflected inside is coloured each time.
        nonlinear: bool,
        /// Roughness of the coat; `None` for a polished one.
        coat: Option<CoatRoughness>,
    },
    /// `principled`: Disney's BSDF for solids (Burley 2012, 2015).
    Principled {
        /// What it has in common with `principledthin`.
        base: PrincipledBase,
        /// Weight of the metallic lobe, from 0 (dielectric) to 1 (metal).
        metallic: SpectrumSource,
        /// Strength of the clear coat, from 0 to 1.
        clearcoat: SpectrumSource,
        /// Gloss of the clear coat, from 0 (satin) to 1 (glossy).
        clearcoat_gloss: SpectrumSource,
        /// The index below over that above.
        eta: f64,
        /// Whether it is kept from returning more than it gets (an extension).
        conserve_energy: bool,
    },
    /// `principledthin`: Disney's BSDF for thin sheets (Burley 2015).
    PrincipledThin {
        /// What it has in common with `principled`.
        base: PrincipledBase,
        /// 0–2.
        diff_trans: SpectrumSource,
        /// Refractive index over that of air.
        eta: SpectrumSource,
        /// As of the above.
        conserve_energy: bool,
    },
    /// `hair`: a fibre of hair or fur (Chiang et al. 2016).
    Hair {
        /// What its inside absorbs.
        absorption: FibreAbsorption,
        /// Refractive index of the fibre.
        interior: IndexSource,
        /// Refractive index around it; `None` for air.
        exterior: Option<IndexSource>,
        /// Roughness along and around the fibre, above 0 and at most 1.
        roughness: [f64; 2],
        /// Angle of the scales to the surface, degrees.
        scale_tilt: f64,
    },
    /// `measured`: reflects as it was measured (Dupuy and Jakob 2018).
    Measured(MeasuredSource),
    /// Lets everything pass, as if there were no surface.
    Null,
    /// A surface with holes: light passes through the fraction 1 − `opacity`.
    Mask {
        /// Fraction of the surface that is covered, from 0 to 1.
        opacity: SpectrumSource,
        /// What covers it.
        nested: Arc<Bsdf>,
    },
    /// The second BSDF by a fraction of `weight`, the first by the rest.
    Blend {
        /// Fraction of the second BSDF, from 0 to 1.
        weight: SpectrumSource,
        /// The two BSDFs.
        nested: [Arc<Bsdf>; 2],
    },
    /// `bumpmap`: shaded as if raised by a height.
    BumpMap {
        /// Height over the surface, in scene units.
        height: SpectrumSource,
        /// Factor on the height.
        scale: f64,
        /// How the varied normal is used.
        shading: NormalMapShading,
        /// The BSDF that is shaded so.
        nested: Arc<Bsdf>,
    },
    /// `normalmap`: shaded with the normals of an image.
    NormalMap {
        /// Normals in the tangent frame, each component c stored as (c + 1)/2.
        normals: SpectrumSource,
        /// How the varied normal is used.
        shading: NormalMapShading,
        /// The BSDF that is shaded so.
        nested: Arc<Bsdf>,
    },
    /// The front BSDF on both sides, or another on the back.
    TwoSided {
        /// BSDF of the front.
        front: Arc<Bsdf>,
        /// BSDF of the back; `None` for that of the front.
        back: Option<Arc<Bsdf>>,
        /// Whether light may get through: the far side then looks like the near one from behind.
        allow_transmission: bool,
    },
}

impl BsdfKind {
    /// Whether it or one within it has a property.
    pub fn any(&self, has: &impl Fn(&Self) -> bool) -> bool {
        let within = |bsdf: &Arc<Bsdf>| bsdf.kind.any(has);
        has(self)
            || match self {
                Self::Mask { nested, .. } | Self::BumpMap { nested, .. } | Self::NormalMap { nested, .. } => {
                    within(nested)
                }
                Self::Blend { nested, .. } => nested.iter().any(within),
                Self::TwoSided { front, back, .. } => within(front) || back.as_ref().is_some_and(within),
                Self::Diffuse { .. }
                | Self::DiffuseTransmitter { .. }
                | Self::Conductor { .. }
                | Self::Dielectric { .. }
                | Self::ThinDielectric { .. }
                | Self::Plastic { .. }
                | Self::Principled { .. }
                | Self::PrincipledThin { .. }
                | Self::Hair { .. }
                | Self::Measured(_)
                | Self::Null => false,
            }
    }

    /// Whether light may get to the other side.
    pub fn transmits(&self) -> bool {
        match self {
            Self::DiffuseTransmitter { .. }
            | Self::Dielectric { .. }
            | Self::ThinDielectric { .. }
            | Self::PrincipledThin { .. }
            | Self::Hair { .. }
            | Self::Null
            | Self::Mask { .. } => true,
            Self::Principled { base, .. } => base.spec_trans.constant() != Some(0.0),
            Self::Diffuse { .. } | Self::Conductor { .. } | Self::Plastic { .. } | Self::Measured(_) => false,
            Self::Blend { nested, .. } => nested.iter().any(|nested| nested.kind.transmits()),
            Self::BumpMap { nested, .. } | Self::NormalMap { nested, .. } => nested.kind.transmits(),
            Self::TwoSided { front, back, .. } => {
                front.kind.transmits() || back.as_ref().is_some_and(|back| back.kind.transmits())
            }
        }
    }
}

/// A file of measured reflection.
#[derive(Clone, Debug)]
pub struct MeasuredSource {
    /// The file.
    pub file: PathBuf,
    /// What it holds.
    pub table: &'static MeasuredTable,
    /// Hash of its bytes.
    pub content: u64,
}

/// What the inside of a fibre absorbs, per radius of the fibre.
#[derive(Clone, Debug)]
pub enum FibreAbsorption {
    /// Concentrations, at least 0.
    Pigments {
        /// That of the pigment of brown and black hair.
        eumelanin: f64,
        /// That of the pigment of red hair.
        pheomelanin: f64,
    },
    /// The coefficient itself, at least 0.
    Coefficient(SpectrumSource),
}

/// How bump and normal maps deal with normals that are no surface's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NormalMapShading {
    /// Whether a normal that faces away from the viewer is turned half around the surface's own.
    pub flip_invalid_normals: bool,
    /// Whether light is weakened where it reaches the varied surface but not the true one.
    pub use_shadowing_function: bool,
}

/// The complex index of refraction of a metal, n + i k.
#[derive(Clone, Debug)]
pub enum ConductorIndex {
    /// Mitsuba's `material="none"`: reflects everything.
    Mirror,
    /// Both parts, as spectra.
    Complex {
        /// Real part of the refractive index.
        n: SpectrumSource,
        /// Imaginary part of the refractive index, at least 0.
        k: SpectrumSource,
    },
    /// A metal of the catalogue, n and k together, by the name that the file has for it.
    Named {
        /// Where the file has the name.
        place: Place,
        /// The name, such as `Au`.
        name: String,
    },
    /// From the reflectance at normal incidence (an extension).
    NormalReflectance {
        /// Reflectance at normal incidence, from 0 to below 1.
        reflectance: SpectrumSource,
        /// What settles the open one of n and k.
        assumption: MetalAssumption,
    },
}

/// A reflectance leaves one unknown of two; this says how it is filled.
#[derive(Clone, Debug)]
pub enum MetalAssumption {
    /// k = 0, the book's.
    NoAbsorption,
    /// n = 1, so that k = 2·√(R/(1−R)).
    UnitIndex,
    /// n is known, k follows.
    KnownIndex(SpectrumSource),
}

/// Roughness of a surface of microfacets.
#[derive(Clone, Debug)]
pub struct Roughness {
    /// Distribution of the microfacets' normals.
    pub distribution: Distribution,
    /// Width α of the distribution.
    pub alpha: Alpha,
}

/// Roughness along the tangents: the slope of the microfacets.
#[derive(Clone, Debug)]
pub enum Alpha {
    /// The same along both tangents.
    Isotropic(SpectrumSource),
    /// Along the tangent and the bitangent.
    Anisotropic([SpectrumSource; 2]),
}

/// The roughness of a coat, the same everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoatRoughness {
    /// Distribution of the microfacets' normals.
    pub distribution: Distribution,
    /// Width α of the distribution, above 0; for Beckmann √2 times the root mean square slope.
    pub alpha: f64,
}

/// What `principled` and `principledthin` have in common, by Mitsuba's names.
#[derive(Clone, Debug)]
pub struct PrincipledBase {
    /// Colour of the base, from 0 to 1.
    pub base_color: SpectrumSource,
    /// Roughness, from 0 to 1; its square is the width α of the microfacets.
    pub roughness: SpectrumSource,
    /// Stretch of the highlight along the tangent, from 0 (round) to 1.
    pub anisotropic: SpectrumSource,
    /// Weight of specular transmission, from 0 to 1.
    pub spec_trans: SpectrumSource,
    /// Tint of the dielectric reflection toward the base's hue, from 0 to 1.
    pub spec_tint: SpectrumSource,
    /// Strength of the sheen at grazing angles, from 0 to 1.
    pub sheen: SpectrumSource,
    /// Tint of the sheen toward the base's hue, from 0 to 1.
    pub sheen_tint: SpectrumSource,
    /// Weight of the flattened diffuse lobe that stands for subsurface scattering, from 0 to 1.
    pub flatness: SpectrumSource,
}
