use super::spectra::{self, index};
use super::{hair, plastic, principled};
use crate::bsdf::{
    AIR_INDEX, BsdfTextures, DielectricTextures, Metal, RoughnessTextures, Specular, ThinDielectricTextures,
};
use crate::geometry::Transform;
use crate::material::{Material, MaterialId, Materials, NormalMap, NormalMapping};
use crate::medium::{Body, Filling, Medium, Refraction};
use crate::scene::description::{
    self, Alpha, Bsdf, BsdfKind, ConductorIndex, IndexSource, MetalAssumption, NormalMapShading, Roughness,
    ShapeDescription, SpectrumKind, SpectrumSource,
};
use crate::scene::read::metals;
use crate::scene::scene::{Role, Surface};
use crate::scene::source::{Place, SceneError};
use crate::shape;
use crate::spectrum::{NormalReflectance, Spectrum, catalogue};
use crate::texture::Texture;
use crate::units::WavelengthRange;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The materials of a scene, each compiled once however many shapes have it, and what they enclose.
pub(super) struct MaterialCompiler {
    pub(super) range: WavelengthRange,
    /// From the coordinates of the file to those of the scene.
    pub(super) shift: Transform,
    pub materials: Materials,
    pub bodies: Vec<Body>,
    pub media: Vec<Option<Medium>>,
    /// By the address of the description, which outlives this.
    known: BTreeMap<*const Bsdf, MaterialId>,
    /// By place: a medium that several shapes refer to is one.
    pub(super) known_media: BTreeMap<(usize, usize), u32>,
    /// By hash: so are media that are alike. Rays enter and leave a slab by open surfaces of its own medium
    /// each.
    pub(super) media_by_hash: BTreeMap<u64, u32>,
    /// The media inside of shapes that let no light through.
    sealed: Vec<Place>,
}

impl MaterialCompiler {
    pub fn new(range: WavelengthRange, shift: Transform) -> Self {
        Self {
            range,
            shift,
            materials: Materials::default(),
            bodies: Vec::new(),
            media: Vec::new(),
            known: BTreeMap::new(),
            known_media: BTreeMap::new(),
            media_by_hash: BTreeMap::new(),
            sealed: Vec::new(),
        }
    }

    /// Media that the file states and that rays get into nowhere: those inside of opaque shapes, unless the
    /// sensor or a shape that lets light through is in the same.
    pub fn unreachable_media(&self) -> impl Iterator<Item = SceneError> {
        let unknown = |place: &&Place| !self.known_media.contains_key(&(place.file, place.span.start));
        self.sealed.iter().filter(unknown).map(|place| {
            SceneError::at(
                place,
                "no ray ever gets into this medium",
                "a medium inside a surface that lets light through",
            )
            .with_remedy(
                "give the shape a BSDF that lets light through, such as `dielectric` or `null`, or leave the \
                 medium out; a sensor in the medium has it, too",
            )
        })
    }

    /// What a shape's surface is, without the light that it may be.
    pub fn surface(
        &mut self,
        shape: &ShapeDescription,
        geometry: &shape::Shape,
        part: bool,
    ) -> Result<Surface, SceneError> {
        let material = self.material(&shape.bsdf)?;
        let body = self.body(shape, geometry, part, material)?;
        Ok(Surface {
            material,
            light: None,
            role: match self.materials.below_normal_map(material) {
                _ if shape.emission.is_some() => Role::Other,
                Material::Bsdf(BsdfTextures::Dielectric(_)) => Role::Interface,
                Material::Bsdf(BsdfTextures::Null) => Role::Null,
                _ => Role::Other,
            },
            part: false,
            body,
            parametrised: self.materials.is_parametrised(material),
            null_transmission: self.materials.has_null_transmission(material),
            specular: match geometry {
                // Curves are met from outside alone: light that goes back finds its way in where it got out.
                shape::Shape::Curves(_) if self.materials.transmits(material) => Specular::Nothing,
                _ => self.materials.specular(material),
            },
        })
    }

    /// What the surface encloses: an index where it refracts, and what the file says is on either side.
    fn body(
        &mut self,
        shape: &ShapeDescription,
        geometry: &shape::Shape,
        part: bool,
        material: MaterialId,
    ) -> Result<Option<u32>, SceneError> {
        let refuse_priority = |problem: &str, expected: &str| match &shape.priority {
            // That of a solid is not meant for all of its parts.
            Some(priority) if !part => Err(SceneError::at(&priority.place, problem, expected)),
            _ => Ok(None),
        };
        if !self.materials.transmits(material) {
            self.sealed.extend(shape.interior.as_ref().map(|medium| medium.place.clone()));
            return refuse_priority(
                "There is nothing inside this shape that could take precedence: no ray ever gets into it",
                "a priority of a shape that lets light through, such as one with a `dielectric`",
            );
        }
        let index = self.materials.interior_index(material).cloned();
        let (interior, exterior) = (self.filling(&shape.interior)?, self.filling(&shape.exterior)?);
        let (interior, exterior) = match (interior, exterior) {
            (None, None) => (Filling::Unspecified, Filling::Unspecified),
            // A surface that parts media has one on either side, even if it is nothing.
            (None, Some(outside)) => (Filling::Vacuum, outside),
            (Some(inside), outside) => (inside, outside.unwrap_or(Filling::Unspecified)),
        };
        if index.is_none() && interior == Filling::Unspecified {
            return refuse_priority(
                "There is nothing inside this shape that could take precedence: neither an index nor a medium",
                "a priority of a shape with a `dielectric` or an interior medium",
            );
        }
        // All faces of a solid together are closed.
        let closed = part || geometry.encloses();
        if !closed {
            refuse_priority(
                "The shape encloses nothing that could take precedence",
                "a priority of a closed shape whose normals point outward",
            )?;
        }
        let priority = shape.priority.as_ref().map_or(0, |priority| priority.value);
        let index_class = self.index_class(index.as_ref());
        let refraction = self.refraction(shape, material);
        self.bodies.push(Body { index, refraction, interior, exterior, priority, closed, index_class });
        Ok(Some(self.bodies.len() as u32 - 1))
    }

    /// A priority is as good as leaving the outside open.
    fn refraction(&self, shape: &ShapeDescription, material: MaterialId) -> Refraction {
        let states = |material: &Material| match material.bsdf() {
            Some(BsdfTextures::Dielectric(dielectric)) => {
                dielectric.exterior.is_some() && shape.priority.is_none()
            }
            Some(BsdfTextures::Principled(principled)) => principled.glass,
            _ => false,
        };
        if self.materials.any(material, &states) {
            return Refraction::Stated;
        }
        match self.materials.interior_index(material) {
            None => Refraction::None,
            Some(_) => Refraction::Surroundings,
        }
    }

    /// Whether two bodies are made of the same.
    pub fn same_inside(&self, a: u32, b: u32) -> bool {
        let (a, b) = (&self.bodies[a as usize], &self.bodies[b as usize]);
        // Two media that only absorb, and alike, are the same; any other is the same as itself alone.
        let known = |filling: Filling| match filling {
            Filling::Medium(medium) => match &self.media[medium as usize] {
                None => (Filling::Vacuum, None),
                Some(medium) => match medium.absorption() {
                    Some(absorption) => (Filling::Vacuum, Some(absorption)),
                    None => (filling, None),
                },
            },
            other => (other, None),
        };
        let same = |a: Filling, b: Filling| known(a) == known(b);
        a.index == b.index
            && a.priority == b.priority
            && same(a.interior, b.interior)
            && same(a.exterior, b.exterior)
    }

    fn index_class(&self, index: Option<&Spectrum>) -> u32 {
        let Some(index) = index.filter(|&index| *index != Spectrum::Constant(AIR_INDEX)) else { return 0 };
        let known = self.bodies.iter().find(|body| body.index.as_ref() == Some(index));
        known.map_or(self.bodies.len() as u32 + 1, |body| body.index_class)
    }

    fn filling(&mut self, medium: &Option<description::Medium>) -> Result<Option<Filling>, SceneError> {
        medium.as_ref().map(|medium| self.medium(medium).map(Filling::Medium)).transpose()
    }

    pub(super) fn material(&mut self, bsdf: &Arc<Bsdf>) -> Result<MaterialId, SceneError> {
        if let Some(&known) = self.known.get(&Arc::as_ptr(bsdf)) {
            return Ok(known);
        }
        let material = self.compiled(bsdf)?;
        let id = self.materials.add(material);
        self.known.insert(Arc::as_ptr(bsdf), id);
        Ok(id)
    }

    fn compiled(&mut self, bsdf: &Bsdf) -> Result<Material, SceneError> {
        let shift = self.shift;
        let texture = |source: &SpectrumSource| spectra::texture(source, &shift);
        let number = |source: &SpectrumSource| spectra::number(source, &shift);
        let textures = |roughness: &Roughness| roughness_textures(roughness, &shift);
        Ok(match &bsdf.kind {
            BsdfKind::Diffuse { reflectance } => {
                let reflectance = texture(reflectance)?;
                Material::Bsdf(if reflectance.is_zero(self.range) {
                    BsdfTextures::Black
                } else {
                    BsdfTextures::Diffuse { reflectance }
                })
            }
            BsdfKind::DiffuseTransmitter { reflectance, transmittance } => {
                Material::Bsdf(BsdfTextures::DiffuseTransmitter {
                    reflectance: texture(reflectance)?,
                    transmittance: texture(transmittance)?,
                })
            }
            BsdfKind::Conductor { index, specular_reflectance, roughness } => {
                Material::Bsdf(BsdfTextures::Conductor {
                    index: self.metal(index)?,
                    specular_reflectance: texture(specular_reflectance)?,
                    roughness: roughness.as_ref().map(textures).transpose()?,
                })
            }
            BsdfKind::Dielectric {
                interior,
                exterior,
                specular_reflectance,
                specular_transmittance,
                roughness,
            } => Material::Bsdf(BsdfTextures::Dielectric(DielectricTextures {
                interior: index(interior, self.range)?,
                exterior: exterior.as_ref().map(|source| index(source, self.range)).transpose()?,
                specular_reflectance: texture(specular_reflectance)?,
                specular_transmittance: texture(specular_transmittance)?,
                roughness: roughness.as_ref().map(textures).transpose()?,
            })),
            BsdfKind::ThinDielectric { interior, exterior, specular_reflectance, specular_transmittance } => {
                Material::Bsdf(BsdfTextures::ThinDielectric(ThinDielectricTextures {
                    interior: index(interior, self.range)?,
                    exterior: outside(exterior, self.range)?,
                    specular_reflectance: texture(specular_reflectance)?,
                    specular_transmittance: texture(specular_transmittance)?,
                }))
            }
            BsdfKind::Plastic { .. } => Material::Bsdf(plastic::compiled(&bsdf.kind, self.range, &shift)?),
            BsdfKind::Principled { .. } | BsdfKind::PrincipledThin { .. } => {
                Material::Bsdf(principled::compiled(&bsdf.kind, &shift)?)
            }
            BsdfKind::Hair { .. } => {
                Material::Bsdf(hair::compiled(&bsdf.place, &bsdf.kind, self.range, &shift)?)
            }
            BsdfKind::Measured(source) => Material::Bsdf(BsdfTextures::Measured(source.table)),
            BsdfKind::Null => Material::Bsdf(BsdfTextures::Null),
            BsdfKind::Mask { opacity, nested } => {
                Material::Mask { opacity: number(opacity)?, nested: self.material(nested)? }
            }
            BsdfKind::Blend { weight, nested: [first, second] } => Material::Blend {
                weight: number(weight)?,
                nested: [self.material(first)?, self.material(second)?],
            },
            BsdfKind::BumpMap { height, scale, shading, nested } => Material::NormalMapping {
                mapping: normal_mapping(
                    NormalMap::Height { height: number(height)?, scale: *scale },
                    *shading,
                ),
                nested: self.material(nested)?,
            },
            BsdfKind::NormalMap { normals, shading, nested } => Material::NormalMapping {
                mapping: normal_mapping(
                    match normals.kind {
                        SpectrumKind::Vector(stored) => NormalMap::Normal(stored),
                        _ => NormalMap::Normals(texture(normals)?),
                    },
                    *shading,
                ),
                nested: self.material(nested)?,
            },
            BsdfKind::TwoSided { front, back, .. } => {
                let front = self.material(front)?;
                let back = back.as_ref().map(|back| self.material(back)).transpose()?;
                Material::TwoSided { front, back: back.unwrap_or(front) }
            }
        })
    }

    fn metal(&self, metal: &ConductorIndex) -> Result<Metal, SceneError> {
        let (n, k) = match metal {
            // n = 0 reflects everything at every angle.
            ConductorIndex::Mirror => (Spectrum::ZERO, Spectrum::ONE),
            ConductorIndex::Complex { n, k } => {
                let [n, k] = [n, k].map(|source| spectra::texture(source, &self.shift));
                return Ok(Metal::Index { n: n?.held(), k: k?.held() });
            }
            ConductorIndex::Named { place, name } => catalogue::conductor(metals::in_catalogue(name))
                .map_err(|unknown| SceneError::at(place, unknown.to_string(), "the name of a conductor"))?,
            ConductorIndex::NormalReflectance { reflectance, assumption } => {
                let texture = spectra::texture(reflectance, &self.shift)?.held();
                if texture.varies() {
                    let unit_index = matches!(assumption, MetalAssumption::UnitIndex);
                    return Ok(Metal::NormalReflectance { reflectance: texture, unit_index });
                }
                self.metal_from_reflectance(reflectance, assumption)?
            }
        };
        Ok(Metal::Index { n: Texture::Uniform(n), k: Texture::Uniform(k) })
    }

    fn metal_from_reflectance(
        &self,
        source: &SpectrumSource,
        assumption: &MetalAssumption,
    ) -> Result<(Spectrum, Spectrum), SceneError> {
        let reflectance = spectra::held(source)?;
        let optics = match assumption {
            MetalAssumption::NoAbsorption => NormalReflectance::dielectric(reflectance, self.range),
            MetalAssumption::UnitIndex => {
                NormalReflectance::conductor(reflectance, Spectrum::ONE, self.range)
            }
            MetalAssumption::KnownIndex(n) => {
                NormalReflectance::conductor(reflectance, spectra::held(n)?, self.range)
            }
        };
        let optics = optics.map_err(|error| {
            SceneError::at(
                &source.place,
                error.to_string(),
                "a reflectance from 0 up to, but not, 1 that the given index can have",
            )
        })?;
        spectra::complex_index(&optics, self.range).map_err(|error| {
            SceneError::at(&source.place, error.to_string(), "a reflectance with a finite index")
        })
    }
}

fn normal_mapping(map: NormalMap, shading: NormalMapShading) -> NormalMapping {
    NormalMapping {
        map,
        flip_invalid_normals: shading.flip_invalid_normals,
        shadowing: shading.use_shadowing_function,
    }
}

fn roughness_textures(roughness: &Roughness, shift: &Transform) -> Result<RoughnessTextures, SceneError> {
    let number = |source: &SpectrumSource| spectra::number(source, shift);
    let alpha = match &roughness.alpha {
        Alpha::Isotropic(alpha) => [number(alpha)?, number(alpha)?],
        Alpha::Anisotropic([u, v]) => [number(u)?, number(v)?],
    };
    let isotropic = matches!(roughness.alpha, Alpha::Isotropic(_));
    Ok(RoughnessTextures { distribution: roughness.distribution, alpha, isotropic })
}

pub(super) fn outside(
    exterior: &Option<IndexSource>,
    range: WavelengthRange,
) -> Result<Spectrum, SceneError> {
    exterior.as_ref().map_or(Ok(Spectrum::Constant(AIR_INDEX)), |source| index(source, range))
}
