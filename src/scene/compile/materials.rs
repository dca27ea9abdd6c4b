use super::spectra::{index, spectrum};
use crate::bsdf::{Microfacets, microfacet};
use crate::material::{DielectricMaterial, Material};
use crate::scene::description::{
    Bsdf, BsdfKind, ConductorIndex, Distribution, MetalAssumption, Roughness, Shape, SpectrumSource,
};
use crate::scene::source::SceneError;
use crate::scene::traceable::{Body, Surface};
use crate::spectrum::{NormalReflectance, Spectrum, catalogue};
use crate::units::WavelengthRange;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The materials of a scene, each compiled once however many shapes have it.
pub(super) struct Materials {
    range: WavelengthRange,
    pub materials: Vec<Material>,
    pub bodies: Vec<Body>,
    /// By the address of the description, which outlives this.
    known: BTreeMap<*const Bsdf, u32>,
}

impl Materials {
    pub fn new(range: WavelengthRange) -> Self {
        Self { range, materials: Vec::new(), bodies: Vec::new(), known: BTreeMap::new() }
    }

    /// What a shape's surface is, without the light that it may be.
    pub fn surface(&mut self, shape: &Shape) -> Result<Surface, SceneError> {
        let (front, back) = match &shape.bsdf.kind {
            BsdfKind::TwoSided { front, back } => {
                let front = self.material(front)?;
                let back = back.as_ref().map(|back| self.material(back)).transpose()?;
                (front, Some(back.unwrap_or(front)))
            }
            _ => (self.material(&shape.bsdf)?, None),
        };
        let body = match &self.materials[front as usize] {
            Material::Dielectric(dielectric) => {
                let absorption =
                    shape.interior.as_ref().map(|medium| spectrum(&medium.absorption)).transpose()?;
                let absorption = absorption.filter(|spectrum| !spectrum.is_zero(self.range));
                self.bodies.push(Body { index: dielectric.interior.clone(), absorption });
                Some(self.bodies.len() as u32 - 1)
            }
            _ => {
                match &shape.interior {
                    None => None,
                    Some(medium) => {
                        return Err(SceneError::at(
                        &medium.place,
                        "no ray ever gets into this medium",
                        "a medium inside a surface that lets light through",
                    )
                    .with_remedy("give the shape a `dielectric` or `roughdielectric` BSDF, or leave the medium out"));
                    }
                }
            }
        };
        let anisotropic =
            [Some(front), back].into_iter().flatten().any(|id| self.materials[id as usize].is_anisotropic());
        Ok(Surface { front, back, light: None, body, anisotropic })
    }

    fn material(&mut self, bsdf: &Arc<Bsdf>) -> Result<u32, SceneError> {
        if let Some(&known) = self.known.get(&Arc::as_ptr(bsdf)) {
            return Ok(known);
        }
        let material = self.compiled(bsdf)?;
        self.materials.push(material);
        let id = self.materials.len() as u32 - 1;
        self.known.insert(Arc::as_ptr(bsdf), id);
        Ok(id)
    }

    fn compiled(&self, bsdf: &Bsdf) -> Result<Material, SceneError> {
        Ok(match &bsdf.kind {
            BsdfKind::Diffuse { reflectance } => {
                let reflectance = spectrum(reflectance)?;
                if reflectance.is_zero(self.range) {
                    Material::Black
                } else {
                    Material::Diffuse { reflectance }
                }
            }
            BsdfKind::DiffuseTransmitter { reflectance, transmittance } => Material::DiffuseTransmitter {
                reflectance: spectrum(reflectance)?,
                transmittance: spectrum(transmittance)?,
            },
            BsdfKind::Conductor { index, specular_reflectance, roughness } => {
                let (n, k) = self.metal(index)?;
                Material::Conductor {
                    n,
                    k,
                    specular_reflectance: spectrum(specular_reflectance)?,
                    microfacets: roughness.map(microfacets),
                }
            }
            BsdfKind::Dielectric {
                interior,
                exterior,
                specular_reflectance,
                specular_transmittance,
                roughness,
            } => Material::Dielectric(DielectricMaterial {
                interior: index(interior, self.range)?,
                exterior: exterior.as_ref().map(|source| index(source, self.range)).transpose()?,
                specular_reflectance: spectrum(specular_reflectance)?,
                specular_transmittance: spectrum(specular_transmittance)?,
                microfacets: roughness.map(microfacets),
            }),
            BsdfKind::TwoSided { .. } => {
                return Err(SceneError::at(
                    &bsdf.place,
                    "a `twosided` inside a `twosided`",
                    "a BSDF that scatters on one side",
                ));
            }
        })
    }

    /// n and k of a metal.
    fn metal(&self, metal: &ConductorIndex) -> Result<(Spectrum, Spectrum), SceneError> {
        match metal {
            // n = 0 reflects everything at every angle.
            ConductorIndex::Mirror => Ok((Spectrum::ZERO, Spectrum::ONE)),
            ConductorIndex::Complex { n, k } => Ok((spectrum(n)?, spectrum(k)?)),
            ConductorIndex::Named { place, name } => catalogue::conductor(name)
                .map_err(|unknown| SceneError::at(place, unknown.to_string(), "the name of a conductor")),
            ConductorIndex::NormalReflectance { reflectance, assumption } => {
                self.metal_from_reflectance(reflectance, assumption)
            }
        }
    }

    fn metal_from_reflectance(
        &self,
        source: &SpectrumSource,
        assumption: &MetalAssumption,
    ) -> Result<(Spectrum, Spectrum), SceneError> {
        let reflectance = spectrum(source)?;
        let optics = match assumption {
            MetalAssumption::NoAbsorption => NormalReflectance::dielectric(reflectance, self.range),
            MetalAssumption::UnitIndex => {
                NormalReflectance::conductor(reflectance, Spectrum::ONE, self.range)
            }
            MetalAssumption::KnownIndex(n) => {
                NormalReflectance::conductor(reflectance, spectrum(n)?, self.range)
            }
        };
        let optics = optics.map_err(|error| {
            SceneError::at(
                &source.place,
                error.to_string(),
                "a reflectance from 0 up to, but not, 1 that the given index can have",
            )
        })?;
        super::spectra::complex_index(&optics, self.range).map_err(|error| {
            SceneError::at(&source.place, error.to_string(), "a reflectance with a finite index")
        })
    }
}

fn microfacets(roughness: Roughness) -> Microfacets {
    let shape = match roughness.distribution {
        Distribution::Beckmann => microfacet::Shape::Beckmann,
        Distribution::Ggx => microfacet::Shape::Ggx,
    };
    Microfacets::new(shape, roughness.alpha[0], roughness.alpha[1])
}
