//! BSDFs as a scene file says them.

use super::spectra::{IndexSource, SpectrumSource};
use crate::bsdf::microfacet::Distribution;
use crate::scene::source::Place;
use std::sync::Arc;

/// How a surface scatters.
#[derive(Clone, Debug)]
pub struct Bsdf {
    pub place: Place,
    /// The name under which the file defines it, if any.
    pub id: Option<String>,
    pub kind: BsdfKind,
}

/// How a surface scatters, by Mitsuba's models.
#[derive(Clone, Debug)]
pub enum BsdfKind {
    Diffuse {
        reflectance: SpectrumSource,
    },
    /// Lambertian on both sides (an extension).
    DiffuseTransmitter {
        reflectance: SpectrumSource,
        transmittance: SpectrumSource,
    },
    /// `conductor` without and `roughconductor` with a roughness.
    Conductor {
        index: ConductorIndex,
        specular_reflectance: SpectrumSource,
        roughness: Option<Roughness>,
    },
    /// `dielectric` without and `roughdielectric` with a roughness.
    Dielectric {
        interior: IndexSource,
        /// `None` where the file leaves it out: then it is what surrounds the surface, air outside
        /// everything.
        exterior: Option<IndexSource>,
        specular_reflectance: SpectrumSource,
        specular_transmittance: SpectrumSource,
        roughness: Option<Roughness>,
    },
    /// `thindielectric`: a sheet of glass, in air where the file doesn't say otherwise.
    ThinDielectric {
        interior: IndexSource,
        exterior: Option<IndexSource>,
        specular_reflectance: SpectrumSource,
        specular_transmittance: SpectrumSource,
    },
    /// `plastic` without and `roughplastic` with a roughness: a coat on a diffuse base, in air where the file
    /// doesn't say otherwise.
    Plastic {
        interior: IndexSource,
        exterior: Option<IndexSource>,
        diffuse_reflectance: SpectrumSource,
        specular_reflectance: SpectrumSource,
        /// Whether light that is reflected inside is coloured each time.
        nonlinear: bool,
        coat: Option<CoatRoughness>,
    },
    Principled {
        base: PrincipledBase,
        metallic: SpectrumSource,
        clearcoat: SpectrumSource,
        clearcoat_gloss: SpectrumSource,
        /// The index below over that above.
        eta: f64,
        /// Whether it is kept from returning more than it gets (an extension).
        conserve_energy: bool,
    },
    PrincipledThin {
        base: PrincipledBase,
        /// 0–2.
        diff_trans: SpectrumSource,
        eta: SpectrumSource,
        /// As of the above.
        conserve_energy: bool,
    },
    /// Lets everything pass, as if there were no surface.
    Null,
    /// A surface with holes: light passes through the fraction 1 − `opacity`.
    Mask {
        opacity: SpectrumSource,
        nested: Arc<Bsdf>,
    },
    /// The second BSDF by a fraction of `weight`, the first by the rest.
    Blend {
        weight: SpectrumSource,
        nested: [Arc<Bsdf>; 2],
    },
    /// `bumpmap`: shaded as if raised by a height.
    BumpMap {
        height: SpectrumSource,
        scale: f64,
        shading: NormalMapShading,
        nested: Arc<Bsdf>,
    },
    /// `normalmap`: shaded with the normals of an image.
    NormalMap {
        normals: SpectrumSource,
        shading: NormalMapShading,
        nested: Arc<Bsdf>,
    },
    /// The front BSDF on both sides, or another on the back.
    TwoSided {
        front: Arc<Bsdf>,
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
            | Self::Null
            | Self::Mask { .. } => true,
            Self::Principled { base, .. } => base.spec_trans.constant() != Some(0.0),
            Self::Diffuse { .. } | Self::Conductor { .. } | Self::Plastic { .. } => false,
            Self::Blend { nested, .. } => nested.iter().any(|nested| nested.kind.transmits()),
            Self::BumpMap { nested, .. } | Self::NormalMap { nested, .. } => nested.kind.transmits(),
            Self::TwoSided { front, back, .. } => {
                front.kind.transmits() || back.as_ref().is_some_and(|back| back.kind.transmits())
            }
        }
    }
}

/// How bump and normal maps deal with normals that are no surface's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NormalMapShading {
    pub flip_invalid_normals: bool,
    pub use_shadowing_function: bool,
}

/// The complex index of refraction of a metal, n + i k.
#[derive(Clone, Debug)]
pub enum ConductorIndex {
    /// Mitsuba's `material="none"`: reflects everything.
    Mirror,
    Complex {
        n: SpectrumSource,
        k: SpectrumSource,
    },
    /// A metal of the catalogue, n and k together, by the name that the file has for it.
    Named {
        place: Place,
        name: String,
    },
    /// From the reflectance at normal incidence (an extension).
    NormalReflectance {
        reflectance: SpectrumSource,
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
    pub distribution: Distribution,
    pub alpha: Alpha,
}

/// Roughness along the tangents: the slope of the microfacets.
#[derive(Clone, Debug)]
pub enum Alpha {
    Isotropic(SpectrumSource),
    /// Along the tangent and the bitangent.
    Anisotropic([SpectrumSource; 2]),
}

/// The roughness of a coat, the same everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoatRoughness {
    pub distribution: Distribution,
    pub alpha: f64,
}

/// What `principled` and `principledthin` have in common, by Mitsuba's names.
#[derive(Clone, Debug)]
pub struct PrincipledBase {
    pub base_color: SpectrumSource,
    pub roughness: SpectrumSource,
    pub anisotropic: SpectrumSource,
    pub spec_trans: SpectrumSource,
    pub spec_tint: SpectrumSource,
    pub sheen: SpectrumSource,
    pub sheen_tint: SpectrumSource,
    pub flatness: SpectrumSource,
}
