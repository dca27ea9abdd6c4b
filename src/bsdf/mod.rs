//! How a surface scatters light at one point.
//!
//! A [`Bsdf`] holds only numbers: its textures and spectra, [`BsdfTextures`], are looked up once at the point
//! and the wavelengths of the path. Evaluation, sampling and density therefore agree by construction.
//!
//! Conventions, for every variant:
//! - Directions are in the local frame whose z axis is the shading normal, point away from the
//!   surface and have unit length. `toward_eye` is where the path came from.
//! - Everything is unpolarised and for radiance carried from light to eye: a refracted ray's weight
//!   includes the factor (η_eye/η_light)² by which radiance is compressed.
//! - A direction is sampled for the hero wavelength alone. Each companion reports with what density
//!   it would have gone the same way, so that the path can weigh all of them by the balance heuristic
//!   (Wilkie et al., "Hero Wavelength Spectral Sampling", EGSR 2014).

mod conductor;
mod dielectric;
mod facets;
pub mod fresnel;
mod hair;
mod kept;
mod lambert;
mod measured;
mod metal;
pub mod microfacet;
mod plastic;
mod principled;
mod rough_dielectric;
mod rough_plastic;
mod roughness;
mod thin_dielectric;

pub use conductor::{Conductor, RoughConductor};
pub use dielectric::{AIR_INDEX, Dielectric, DielectricTextures, Exterior};
pub use facets::FacetReflection;
pub use hair::{Fibre, Hair, HairTextures};
pub use lambert::{DiffuseTransmitter, Lambert};
pub use measured::{Measured, MeasuredTable, Symmetry};
pub use metal::{EvenRoughMetal, Metal};
pub use microfacet::{Beckmann, Ggx, Microfacets};
pub use plastic::{DiffuseBase, Plastic, PlasticTextures};
pub(crate) use principled::LEAST_INDEX;
pub use principled::{
    Albedo, Extent, Principled, PrincipledBase, PrincipledBaseTextures, PrincipledTextures, PrincipledThin,
    PrincipledThinTextures,
};
pub use rough_dielectric::RoughDielectric;
pub use rough_plastic::{RoughCoat, RoughPlastic};
pub use roughness::RoughnessTextures;
pub use thin_dielectric::{ThinDielectric, ThinDielectricTextures};

use crate::geometry::Vec3;
use crate::sampling::Density;
use crate::spectrum::Sampled;
use crate::texture::{Texture, TexturePoint};
use fresnel::Interface;

/// How a surface scatters at one point, at the wavelengths of one path.
#[derive(Clone, Copy, Debug)]
pub enum Bsdf<const C: usize> {
    /// Absorbs everything.
    Black,
    /// No surface at all.
    Null,
    /// Diffuse reflection.
    Lambert(Lambert<C>),
    /// Diffuse reflection and transmission.
    DiffuseTransmitter(DiffuseTransmitter<C>),
    /// A polished metal.
    Conductor(Conductor<C>),
    /// A rough metal.
    RoughConductor(RoughConductor<C>),
    /// The polished surface of a transparent body.
    Dielectric(Dielectric<C>),
    /// The rough surface of a transparent body.
    RoughDielectric(RoughDielectric<C>),
    /// A polished transparent sheet.
    ThinDielectric(ThinDielectric<C>),
    /// A polished coat on a diffuse base.
    Plastic(Plastic<C>),
    /// A rough coat on a diffuse base.
    RoughPlastic(RoughPlastic<C>),
    /// Disney's BSDF for solids.
    Principled(Principled<C>),
    /// Disney's BSDF for thin sheets.
    PrincipledThin(PrincipledThin<C>),
    /// A fibre of hair or fur.
    Hair(Hair<C>),
    /// A surface whose reflection was measured.
    Measured(Measured<C>),
}

impl<const C: usize> Bsdf<C> {
    /// The value for a pair of directions, and the density of sampling the second from the first.
    /// Zero where the variant's lobes are all discrete.
    pub fn evaluate(&self, toward_eye: Vec3, toward_light: Vec3) -> Evaluation<C> {
        match self {
            Bsdf::Black | Bsdf::Null | Bsdf::Conductor(_) | Bsdf::Dielectric(_) | Bsdf::ThinDielectric(_) => {
                Evaluation::ZERO
            }
            Bsdf::Lambert(bsdf) => bsdf.evaluate(toward_eye, toward_light),
            Bsdf::DiffuseTransmitter(bsdf) => bsdf.evaluate(toward_eye, toward_light),
            Bsdf::RoughConductor(bsdf) => bsdf.evaluate(toward_eye, toward_light),
            Bsdf::RoughDielectric(bsdf) => bsdf.evaluate(toward_eye, toward_light),
            Bsdf::Plastic(bsdf) => bsdf.evaluate(toward_eye, toward_light),
            Bsdf::RoughPlastic(bsdf) => bsdf.evaluate(toward_eye, toward_light),
            Bsdf::Principled(bsdf) => bsdf.evaluate(toward_eye, toward_light),
            Bsdf::PrincipledThin(bsdf) => bsdf.evaluate(toward_eye, toward_light),
            Bsdf::Hair(bsdf) => bsdf.evaluate(toward_eye, toward_light),
            Bsdf::Measured(bsdf) => bsdf.evaluate(toward_eye, toward_light),
        }
    }

    /// A direction toward the light, from uniform numbers in [0, 1): `lobe` chooses between
    /// reflection and transmission, `u` the direction.
    /// `None` where nothing is scattered: seen from a black side, absorbed, or lost between facets.
    pub fn sample(&self, toward_eye: Vec3, lobe: f64, u: [f64; 2]) -> Option<Scatter<C>> {
        match self {
            Bsdf::Black => None,
            Bsdf::Null => Some(Scatter::straight_on(toward_eye)),
            Bsdf::Lambert(bsdf) => bsdf.sample(toward_eye, u),
            Bsdf::DiffuseTransmitter(bsdf) => bsdf.sample(toward_eye, lobe, u),
            Bsdf::Conductor(bsdf) => bsdf.sample(toward_eye),
            Bsdf::RoughConductor(bsdf) => bsdf.sample(toward_eye, u),
            Bsdf::Dielectric(bsdf) => bsdf.sample(toward_eye, lobe),
            Bsdf::RoughDielectric(bsdf) => bsdf.sample(toward_eye, lobe, u),
            Bsdf::ThinDielectric(bsdf) => bsdf.sample(toward_eye, lobe),
            Bsdf::Plastic(bsdf) => bsdf.sample(toward_eye, lobe, u),
            Bsdf::RoughPlastic(bsdf) => bsdf.sample(toward_eye, lobe, u),
            Bsdf::Principled(bsdf) => bsdf.sample(toward_eye, lobe, u),
            Bsdf::PrincipledThin(bsdf) => bsdf.sample(toward_eye, lobe, u),
            Bsdf::Hair(bsdf) => bsdf.sample(toward_eye, lobe, u),
            Bsdf::Measured(bsdf) => bsdf.sample(toward_eye, u),
        }
    }

    /// The value of `lobe` below which [`Self::sample`] reflects at a smooth interface, and above which it
    /// transmits. `None` for all that has more than these two directions.
    pub fn reflection_probability(&self, toward_eye: Vec3) -> Option<f64> {
        match self {
            Bsdf::Dielectric(bsdf) => Some(bsdf.reflection_probability(toward_eye)),
            _ => None,
        }
    }

    /// The two parts of a smooth coat over something else: its mirror reflection, which takes no sample
    /// values, and the rest. `None` for all others.
    pub fn mirror_apart(&self, toward_eye: Vec3) -> Option<(Scatter<C>, Self)> {
        match self {
            Bsdf::Plastic(bsdf) => {
                let (mirror, rest) = bsdf.mirror_apart(toward_eye)?;
                Some((mirror, Bsdf::Plastic(rest)))
            }
            _ => None,
        }
    }

    /// Whether `evaluate` is zero everywhere, so that light can only be found by sampling the BSDF.
    pub fn is_discrete(&self) -> bool {
        match self {
            Bsdf::Black | Bsdf::Null | Bsdf::Conductor(_) | Bsdf::Dielectric(_) | Bsdf::ThinDielectric(_) => {
                true
            }
            Bsdf::Lambert(_)
            | Bsdf::DiffuseTransmitter(_)
            | Bsdf::RoughConductor(_)
            | Bsdf::RoughDielectric(_)
            | Bsdf::Plastic(_)
            | Bsdf::RoughPlastic(_)
            | Bsdf::Principled(_)
            | Bsdf::PrincipledThin(_)
            | Bsdf::Hair(_)
            | Bsdf::Measured(_) => false,
        }
    }

    /// For an interface, the hero's index below over that above.
    pub fn relative_index(&self) -> Option<f64> {
        match self {
            Bsdf::Dielectric(bsdf) => Some(bsdf.eta.hero()),
            Bsdf::RoughDielectric(bsdf) => Some(bsdf.facet.eta.hero()),
            Bsdf::Principled(bsdf) => Some(bsdf.eta),
            Bsdf::Black
            | Bsdf::Null
            | Bsdf::Lambert(_)
            | Bsdf::DiffuseTransmitter(_)
            | Bsdf::Conductor(_)
            | Bsdf::RoughConductor(_)
            | Bsdf::ThinDielectric(_)
            | Bsdf::Plastic(_)
            | Bsdf::RoughPlastic(_)
            | Bsdf::PrincipledThin(_)
            | Bsdf::Hair(_)
            | Bsdf::Measured(_) => None,
        }
    }

    /// Whether light can pass from one side to the other.
    pub fn transmits(&self) -> bool {
        match self {
            Bsdf::Black
            | Bsdf::Lambert(_)
            | Bsdf::Conductor(_)
            | Bsdf::RoughConductor(_)
            | Bsdf::Plastic(_)
            | Bsdf::RoughPlastic(_)
            | Bsdf::Measured(_) => false,
            Bsdf::Null
            | Bsdf::DiffuseTransmitter(_)
            | Bsdf::Dielectric(_)
            | Bsdf::RoughDielectric(_)
            | Bsdf::ThinDielectric(_)
            | Bsdf::PrincipledThin(_)
            | Bsdf::Hair(_) => true,
            Bsdf::Principled(bsdf) => bsdf.transmits(),
        }
    }

    /// Whether what is transmitted goes straight on, as if there were no surface (null transmission).
    pub fn has_null_transmission(&self) -> bool {
        matches!(self, Bsdf::Null | Bsdf::ThinDielectric(_))
    }

    /// Null transmittance: the fraction that goes straight on, as if there were no surface.
    pub fn null_transmittance(&self, toward_eye: Vec3) -> Sampled<C> {
        match self {
            Bsdf::Null => Sampled::ONE,
            Bsdf::ThinDielectric(bsdf) => bsdf.null_transmittance(toward_eye),
            _ => Sampled::ZERO,
        }
    }
}

/// How a surface scatters all over: the textures and spectra that a [`Bsdf`] of numbers is looked up in.
#[derive(Clone, Debug)]
pub enum BsdfTextures {
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
    Dielectric(DielectricTextures),
    /// A transparent sheet.
    ThinDielectric(ThinDielectricTextures),
    /// A coat on a diffuse base.
    Plastic(PlasticTextures),
    /// Disney's BSDF for solids.
    Principled(Box<PrincipledTextures>),
    /// Disney's BSDF for thin sheets.
    PrincipledThin(Box<PrincipledThinTextures>),
    /// Hair or fur.
    Hair(HairTextures),
    /// What was measured.
    Measured(&'static MeasuredTable),
}

/// What a surface sends on in single directions, or nearly, the same way forth and back. More is greater.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Specular {
    /// Nothing, or not the same way forth and back.
    Nothing,
    /// All that it sends on, in narrow lobes: it is polished metal, of little roughness.
    Nearly,
    /// The mirror reflection of a smooth coat.
    Coat,
    /// All that it sends on: it is smooth metal or glass.
    All,
}

/// The largest roughness of metal whose caustics are looked for from the light. Under small lamps relMSE ×
/// CPU time is 0.01 to 1.1 of what it is by chance alone with a roughness of 0.02, and 0.1 to 0.8 with 0.2.
const POLISHED: f64 = 0.25;

impl BsdfTextures {
    /// The numbers at a point and the wavelengths of a path. `exterior` is the index of what surrounds the
    /// surface, for bodies that leave it open.
    pub fn sample<const C: usize>(
        &self,
        at: &TexturePoint,
        nm: &[f64; C],
        exterior: Exterior<'_>,
    ) -> Bsdf<C> {
        match self {
            Self::Black => Bsdf::Black,
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
            Self::Hair(hair) => hair.bsdf(at, nm),
            Self::Measured(table) => {
                let wavelengths = Sampled(*nm).map(|nm| table.wavelength(nm));
                Bsdf::Measured(Measured { table, wavelengths })
            }
        }
    }

    /// All of its textures.
    pub fn textures(&self) -> Vec<&Texture> {
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
            Self::Hair(hair) => vec![&hair.absorption],
            Self::Black | Self::Null | Self::Measured(_) => Vec::new(),
        }
    }

    /// What it sends on in single directions.
    pub fn specular(&self) -> Specular {
        match self {
            Self::Conductor { roughness: None, .. } => Specular::All,
            Self::Conductor { roughness: Some(roughness), .. } if roughness.is_at_most(POLISHED) => {
                Specular::Nearly
            }
            Self::Dielectric(dielectric) if dielectric.roughness.is_none() => Specular::All,
            Self::Plastic(plastic) if plastic.coat.is_none() => Specular::Coat,
            _ => Specular::Nothing,
        }
    }

    /// Whether light may pass by null transmission: straight on, as if there were no surface.
    pub fn has_null_transmission(&self) -> bool {
        matches!(self, Self::Null | Self::ThinDielectric(_))
    }

    /// Whether light may get to the other side.
    pub fn transmits(&self) -> bool {
        match self {
            Self::Null
            | Self::Dielectric(_)
            | Self::DiffuseTransmitter { .. }
            | Self::ThinDielectric(_)
            | Self::PrincipledThin(_)
            | Self::Hair(_) => true,
            Self::Principled(principled) => principled.glass,
            _ => false,
        }
    }

    /// Whether directions are spread by a roughness.
    pub fn is_rough(&self) -> bool {
        match self {
            Self::Plastic(plastic) => plastic.coat.is_some(),
            Self::Principled(_) | Self::PrincipledThin(_) | Self::Hair(_) | Self::Measured(_) => true,
            _ => self.roughness().is_some(),
        }
    }

    /// Whether it matters which way the surface's coordinates run.
    pub fn is_anisotropic(&self) -> bool {
        match self {
            Self::Principled(principled) => principled.base.is_anisotropic(),
            Self::PrincipledThin(thin) => thin.base.is_anisotropic(),
            Self::Hair(_) => true,
            Self::Measured(table) => !table.is_isotropic,
            _ => self.roughness().is_some_and(RoughnessTextures::is_anisotropic),
        }
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
}

/// The direction seen from the other side of the surface.
fn flipped(direction: Vec3) -> Vec3 {
    Vec3::new(direction.x, direction.y, -direction.z)
}

/// Mirror direction of `v` about `m`.
fn reflected(v: Vec3, m: Vec3) -> Vec3 {
    m * (2.0 * v.dot(m)) - v
}

/// Refracted direction of `v` by a facet `m` that it sees. `eta` is the index of the far side over that of
/// the near side, and `interface` is that of the cosine v·m.
#[inline]
fn refracted(v: Vec3, m: Vec3, eta: f64, interface: Interface) -> Vec3 {
    m * (v.dot(m) / eta - interface.cos_refracted) - v / eta
}

/// The probability of one of two lobes, in proportion to what they carry; 0 where neither carries anything.
#[inline]
fn share(part: f64, rest: f64) -> f64 {
    let both = part + rest;
    if both > 0.0 { part / both } else { 0.0 }
}

/// The value of a BSDF for a pair of directions.
#[derive(Clone, Copy, Debug)]
pub struct Evaluation<const C: usize> {
    /// `f · |cos θ_light|`, sr⁻¹. Zero for a discrete lobe.
    pub f_cos: Sampled<C>,
    /// The density, per steradian, with which sampling would have chosen `toward_light` had that
    /// lane been the hero. Zero for a discrete lobe.
    pub density: Sampled<C>,
}

impl<const C: usize> Evaluation<C> {
    /// Where nothing is scattered.
    pub const ZERO: Self = Self { f_cos: Sampled::ZERO, density: Sampled::ZERO };
}

/// A sampled direction.
#[derive(Clone, Copy, Debug)]
pub struct Scatter<const C: usize> {
    /// Unit vector along which light arrives, pointing away from the surface.
    pub toward_light: Vec3,
    /// `f · |cos θ_light| / density`, both the value's lane and the *hero's* density; for a discrete
    /// lobe the ratio of its coefficient to the hero's probability of choosing it.
    pub weight: Sampled<C>,
    /// The density of the hero.
    pub density: Density,
    /// Each lane's density of this direction over the hero's: 1 where the lane's sampling is the
    /// hero's, 0 where the lane could not have come this way (it refracts elsewhere).
    /// Lane 0 is always 1.
    pub ratio: Sampled<C>,
    /// Whether the ray goes through the surface rather than back from it.
    pub transmitted: bool,
}

impl<const C: usize> Scatter<C> {
    /// From the value and the density of each lane at a sampled direction. `None` where the hero has no
    /// density.
    fn with_density(
        toward_light: Vec3,
        f_cos: Sampled<C>,
        density: Sampled<C>,
        transmitted: bool,
    ) -> Option<Self> {
        (density.hero() > 0.0).then(|| Self {
            toward_light,
            weight: f_cos / density.hero(),
            density: Density::PerSolidAngle(density.hero()),
            ratio: density / density.hero(),
            transmitted,
        })
    }

    /// Null transmission: the direction straight on, with weight 1.
    fn straight_on(toward_eye: Vec3) -> Self {
        Self {
            toward_light: -toward_eye,
            weight: Sampled::ONE,
            density: Density::Discrete,
            ratio: Sampled::ONE,
            transmitted: true,
        }
    }
}
