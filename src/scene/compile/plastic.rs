//! Plastic, smooth and rough.

use super::materials::outside;
use super::spectra::{self, index};
use crate::bsdf::{BsdfTextures, PlasticTextures, RoughCoat};
use crate::geometry::Transform;
use crate::scene::description::{BsdfKind, CoatRoughness, IndexSource, SpectrumSource};
use crate::scene::source::SceneError;
use crate::spectrum::Spectrum;
use crate::units::WavelengthRange;

/// The textures of a plastic BSDF; any other is black.
pub(super) fn compiled(
    kind: &BsdfKind,
    range: WavelengthRange,
    shift: &Transform,
) -> Result<BsdfTextures, SceneError> {
    let texture = |source: &SpectrumSource| spectra::texture(source, shift);
    Ok(match kind {
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
            BsdfTextures::Plastic(PlasticTextures {
                coat: roughness.map(|roughness| coat(roughness, interior, &inside, &outside)).transpose()?,
                interior: inside,
                exterior: outside,
                diffuse_reflectance: texture(diffuse_reflectance)?,
                specular_reflectance: texture(specular_reflectance)?,
                nonlinear: *nonlinear,
            })
        }
        _ => BsdfTextures::Black,
    })
}

/// The tables of rough coats, which are Mitsuba's, are too coarse for more, and no clear solid is denser.
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
    Ok(RoughCoat::shared(roughness.distribution, roughness.alpha, inside / outside))
}
