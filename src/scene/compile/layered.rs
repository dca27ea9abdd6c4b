//! Panes, plastic and "principled" surfaces.

use super::materials::facet_shape;
use super::spectra::{self, index};
use crate::bsdf::{Albedo, Extent, RoughCoat};
use crate::geometry::Transform;
use crate::material::{
    AIR_INDEX, LEAST_INDEX, Material, PlasticMaterial, PrincipledMaterial, PrincipledTextures,
    PrincipledThinMaterial, ThinDielectricMaterial,
};
use crate::scene::description::{BsdfKind, CoatRoughness, IndexSource, PrincipledBase, SpectrumSource};
use crate::scene::source::SceneError;
use crate::spectrum::Spectrum;
use crate::units::WavelengthRange;

/// A BSDF of one of these kinds; any other is black.
pub(super) fn compiled(
    kind: &BsdfKind,
    range: WavelengthRange,
    shift: &Transform,
) -> Result<Material, SceneError> {
    let texture = |source: &SpectrumSource| spectra::texture(source, shift);
    Ok(match kind {
        BsdfKind::ThinDielectric { interior, exterior, specular_reflectance, specular_transmittance } => {
            Material::ThinDielectric(ThinDielectricMaterial {
                interior: index(interior, range)?,
                exterior: outside(exterior, range)?,
                specular_reflectance: texture(specular_reflectance)?,
                specular_transmittance: texture(specular_transmittance)?,
            })
        }
        BsdfKind::Plastic {
            interior,
            exterior,
            diffuse_reflectance,
            specular_reflectance,
            nonlinear,
            coat: roughness,
        } => {
            let (inside, outside) = (index(interior, range)?, outside(exterior, range)?);
            refuse_dense(interior, &inside, &outside, range)?;
            Material::Plastic(PlasticMaterial {
                coat: roughness.map(|roughness| coat(roughness, interior, &inside, &outside)).transpose()?,
                interior: inside,
                exterior: outside,
                diffuse_reflectance: texture(diffuse_reflectance)?,
                specular_reflectance: texture(specular_reflectance)?,
                nonlinear: *nonlinear,
            })
        }
        BsdfKind::Principled { base, metallic, clearcoat, clearcoat_gloss, eta, conserve_energy } => {
            let extent = Extent { gloss: share(clearcoat_gloss), ..extent(base, false, *eta) };
            Material::Principled(Box::new(PrincipledMaterial {
                textures: textures(base, shift)?,
                metallic: texture(metallic)?,
                clearcoat: texture(clearcoat)?,
                clearcoat_gloss: texture(clearcoat_gloss)?,
                eta: *eta,
                glass: base.spec_trans.constant() != Some(0.0),
                albedo: conserve_energy.then(|| Albedo::shared(extent)),
            }))
        }
        BsdfKind::PrincipledThin { base, diff_trans, eta, conserve_energy } => {
            // The reader sees to it that one that conserves energy has one index.
            let extent = extent(base, true, eta.constant().unwrap_or(1.0).max(LEAST_INDEX));
            Material::PrincipledThin(Box::new(PrincipledThinMaterial {
                textures: textures(base, shift)?,
                diff_trans: texture(diff_trans)?,
                eta: texture(eta)?,
                albedo: conserve_energy.then(|| Albedo::shared(extent)),
            }))
        }
        _ => Material::Black,
    })
}

/// What the albedos of a principled surface are asked for; its clear coat, if any, has no gloss.
fn extent(base: &PrincipledBase, thin: bool, eta: f64) -> Extent {
    let (roughness, anisotropic) = (share(&base.roughness), share(&base.anisotropic));
    Extent { thin, eta, roughness, anisotropic, gloss: Some(0.0) }
}

/// A share that is the same all over a surface.
fn share(source: &SpectrumSource) -> Option<f64> {
    source.constant().map(|share| share.clamp(0.0, 1.0))
}

fn textures(base: &PrincipledBase, shift: &Transform) -> Result<PrincipledTextures, SceneError> {
    let texture = |source: &SpectrumSource| spectra::texture(source, shift);
    Ok(PrincipledTextures {
        base_color: texture(&base.base_color)?,
        roughness: texture(&base.roughness)?,
        anisotropic: texture(&base.anisotropic)?,
        spec_trans: texture(&base.spec_trans)?,
        spec_tint: texture(&base.spec_tint)?,
        sheen: texture(&base.sheen)?,
        sheen_tint: texture(&base.sheen_tint)?,
        flatness: texture(&base.flatness)?,
    })
}

fn outside(exterior: &Option<IndexSource>, range: WavelengthRange) -> Result<Spectrum, SceneError> {
    exterior.as_ref().map_or(Ok(Spectrum::Constant(AIR_INDEX)), |source| index(source, range))
}

/// The formula for what a coat reflects inside, which is Mitsuba's, is made for indices of solids.
fn refuse_dense(
    source: &IndexSource,
    inside: &Spectrum,
    outside: &Spectrum,
    range: WavelengthRange,
) -> Result<(), SceneError> {
    const DENSEST: f64 = 3.5;
    let ratio = inside.bounds(range).1 / outside.bounds(range).0;
    if ratio <= DENSEST {
        return Ok(());
    }
    Err(SceneError::at(
        &source.place,
        format!("the index of the coat is {ratio:.4} times that outside"),
        format!("at most {DENSEST} times"),
    )
    .with_remedy("that of plastic is about 1.5; for a dense, opaque surface use `roughconductor`"))
}

fn coat(
    roughness: CoatRoughness,
    source: &IndexSource,
    inside: &Spectrum,
    outside: &Spectrum,
) -> Result<&'static RoughCoat, SceneError> {
    let (Spectrum::Constant(inside), Spectrum::Constant(outside)) = (inside, outside) else {
        return Err(SceneError::at(
            &source.place,
            "the index of a rough coat varies with wavelength",
            "a number, inside and outside",
        )
        .with_remedy("`plastic` and `roughdielectric` take a function of wavelength"));
    };
    if inside == outside {
        return Err(SceneError::at(
            &source.place,
            "the coat has the index of what is outside",
            "two indices that differ",
        )
        .with_remedy("a surface without a coat is `diffuse`"));
    }
    Ok(RoughCoat::shared(facet_shape(roughness.distribution), roughness.alpha, inside / outside))
}
