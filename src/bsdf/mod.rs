//! How a surface scatters light at one point.
//!
//! A [`Bsdf`] holds only numbers: the material has looked up its spectra at the wavelengths of the
//! path already. Evaluation, sampling and density therefore agree by construction.
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
pub mod fresnel;
mod lambert;
pub mod microfacet;
mod plastic;
mod principled;
mod rough_dielectric;
mod rough_plastic;
mod thin_dielectric;

pub use conductor::{Conductor, FacetReflection, RoughConductor};
pub use dielectric::Dielectric;
pub use lambert::{DiffuseTransmitter, Lambert};
pub use microfacet::{Ggx, Microfacets};
pub use plastic::{DiffuseBase, Plastic};
pub use principled::{Albedo, Extent, Principled, PrincipledBase, PrincipledThin};
pub use rough_dielectric::RoughDielectric;
pub use rough_plastic::{RoughCoat, RoughPlastic};
pub use thin_dielectric::ThinDielectric;

use crate::geometry::Vec3;
use crate::sampling::Density;
use crate::spectrum::Sampled;

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
            | Bsdf::PrincipledThin(_) => false,
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
            | Bsdf::PrincipledThin(_) => None,
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
            | Bsdf::RoughPlastic(_) => false,
            Bsdf::Null
            | Bsdf::DiffuseTransmitter(_)
            | Bsdf::Dielectric(_)
            | Bsdf::RoughDielectric(_)
            | Bsdf::ThinDielectric(_)
            | Bsdf::PrincipledThin(_) => true,
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

/// The direction seen from the other side of the surface.
fn flipped(direction: Vec3) -> Vec3 {
    Vec3::new(direction.x, direction.y, -direction.z)
}

/// Mirror direction of `v` about `m`.
fn reflected(v: Vec3, m: Vec3) -> Vec3 {
    m * (2.0 * v.dot(m)) - v
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
