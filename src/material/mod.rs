//! Materials: functions of wavelength that become a [`Bsdf`] of numbers at the wavelengths of a path.

use crate::bsdf::{
    Bsdf, Conductor, Dielectric, DiffuseTransmitter, Lambert, Microfacets, RoughConductor, RoughDielectric,
};
use crate::spectrum::{Sampled, Spectrum};

/// What a surface is made of, seen from its front.
#[derive(Clone, Debug)]
pub enum Material {
    /// Absorbs everything.
    Black,
    Diffuse {
        reflectance: Spectrum,
    },
    DiffuseTransmitter {
        reflectance: Spectrum,
        transmittance: Spectrum,
    },
    /// A metal: complex index n + i·k against vacuum.
    Conductor {
        n: Spectrum,
        k: Spectrum,
        specular_reflectance: Spectrum,
        microfacets: Option<Microfacets>,
    },
    Dielectric(DielectricMaterial),
}

/// A transparent body's surface.
#[derive(Clone, Debug)]
pub struct DielectricMaterial {
    /// Index on the inside.
    pub interior: Spectrum,
    /// Index on the outside; `None` where it is that of whatever surrounds the body.
    pub exterior: Option<Spectrum>,
    pub specular_reflectance: Spectrum,
    pub specular_transmittance: Spectrum,
    pub microfacets: Option<Microfacets>,
}

/// Index of air at standard conditions as Mitsuba 3 has it: what surrounds a body in nothing else.
pub const AIR_INDEX: f64 = 1.000_277;

impl Material {
    /// The numbers at the wavelengths of a path. `around` is the index of what surrounds the surface, for bodies
    /// that leave it open.
    pub fn bsdf<const C: usize>(&self, nm: &[f64; C], around: Option<&Spectrum>) -> Bsdf<C> {
        match self {
            Self::Black => Bsdf::Black,
            Self::Diffuse { reflectance } => Bsdf::Lambert(Lambert { reflectance: reflectance.sample(nm) }),
            Self::DiffuseTransmitter { reflectance, transmittance } => {
                Bsdf::DiffuseTransmitter(DiffuseTransmitter {
                    reflectance: reflectance.sample(nm),
                    transmittance: transmittance.sample(nm),
                })
            }
            Self::Conductor { n, k, specular_reflectance, microfacets } => {
                let facet = Conductor {
                    eta: n.sample(nm),
                    k: k.sample(nm),
                    specular_reflectance: specular_reflectance.sample(nm),
                };
                match microfacets {
                    None => Bsdf::Conductor(facet),
                    Some(microfacets) => {
                        Bsdf::RoughConductor(RoughConductor { facet, microfacets: *microfacets })
                    }
                }
            }
            Self::Dielectric(dielectric) => dielectric.bsdf(nm, around),
        }
    }

    /// Whether directions are spread by a roughness.
    pub fn is_rough(&self) -> bool {
        match self {
            Self::Conductor { microfacets, .. } => microfacets.is_some(),
            Self::Dielectric(dielectric) => dielectric.microfacets.is_some(),
            Self::Black | Self::Diffuse { .. } | Self::DiffuseTransmitter { .. } => false,
        }
    }

    /// Whether it matters which way the surface's coordinates run.
    pub fn is_anisotropic(&self) -> bool {
        let microfacets = match self {
            Self::Conductor { microfacets, .. } => microfacets,
            Self::Dielectric(dielectric) => &dielectric.microfacets,
            Self::Black | Self::Diffuse { .. } | Self::DiffuseTransmitter { .. } => &None,
        };
        microfacets.is_some_and(|microfacets| microfacets.is_anisotropic())
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
}

impl DielectricMaterial {
    fn bsdf<const C: usize>(&self, nm: &[f64; C], around: Option<&Spectrum>) -> Bsdf<C> {
        let outside = match self.exterior.as_ref().or(around) {
            Some(index) => index.sample(nm),
            None => Sampled::splat(AIR_INDEX),
        };
        let facet = Dielectric {
            eta: self.interior.sample(nm) / outside,
            specular_reflectance: self.specular_reflectance.sample(nm),
            specular_transmittance: self.specular_transmittance.sample(nm),
        };
        match self.microfacets {
            None => Bsdf::Dielectric(facet),
            Some(microfacets) => Bsdf::RoughDielectric(RoughDielectric { facet, microfacets }),
        }
    }
}
