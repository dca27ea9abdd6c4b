//! "Principled" surfaces, with and without a body.

use super::spectra;
use crate::bsdf::{
    Albedo, BsdfTextures, Extent, LEAST_INDEX, PrincipledBaseTextures, PrincipledTextures,
    PrincipledThinTextures,
};
use crate::geometry::Transform;
use crate::scene::description::{BsdfKind, PrincipledBase, SpectrumSource};
use crate::scene::source::SceneError;

/// The textures of a principled BSDF; any other is black.
pub(super) fn compiled(kind: &BsdfKind, shift: &Transform) -> Result<BsdfTextures, SceneError> {
    let number = |source: &SpectrumSource| spectra::number(source, shift);
    Ok(match kind {
        BsdfKind::Principled { base, metallic, clearcoat, clearcoat_gloss, eta, conserve_energy } => {
            let extent = Extent { gloss: fraction(clearcoat_gloss), ..extent(base, false, *eta) };
            BsdfTextures::Principled(Box::new(PrincipledTextures {
                base: textures(base, shift)?,
                metallic: number(metallic)?,
                clearcoat: number(clearcoat)?,
                clearcoat_gloss: number(clearcoat_gloss)?,
                eta: *eta,
                glass: base.spec_trans.constant() != Some(0.0),
                albedo: conserve_energy.then(|| Albedo::shared(extent)),
            }))
        }
        BsdfKind::PrincipledThin { base, diff_trans, eta, conserve_energy } => {
            // The reader sees to it that one that conserves energy has one index.
            let extent = extent(base, true, eta.constant().unwrap_or(1.0).max(LEAST_INDEX));
            BsdfTextures::PrincipledThin(Box::new(PrincipledThinTextures {
                base: textures(base, shift)?,
                diff_trans: number(diff_trans)?,
                eta: number(eta)?,
                albedo: conserve_energy.then(|| Albedo::shared(extent)),
            }))
        }
        _ => BsdfTextures::Black,
    })
}

/// What the albedos of a principled surface are asked for; its clear coat, if any, has no gloss.
fn extent(base: &PrincipledBase, thin: bool, eta: f64) -> Extent {
    let (roughness, anisotropic) = (fraction(&base.roughness), fraction(&base.anisotropic));
    Extent { thin, eta, roughness, anisotropic, gloss: Some(0.0) }
}

/// A parameter that is the same all over a surface.
fn fraction(source: &SpectrumSource) -> Option<f64> {
    source.constant().map(|fraction| fraction.clamp(0.0, 1.0))
}

fn textures(base: &PrincipledBase, shift: &Transform) -> Result<PrincipledBaseTextures, SceneError> {
    let number = |source: &SpectrumSource| spectra::number(source, shift);
    Ok(PrincipledBaseTextures {
        base_color: spectra::texture(&base.base_color, shift)?,
        roughness: number(&base.roughness)?,
        anisotropic: number(&base.anisotropic)?,
        spec_trans: number(&base.spec_trans)?,
        spec_tint: number(&base.spec_tint)?,
        sheen: number(&base.sheen)?,
        sheen_tint: number(&base.sheen_tint)?,
        flatness: number(&base.flatness)?,
    })
}
