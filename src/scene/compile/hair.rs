//! Hair and fur.

use super::materials::outside;
use super::media::tabulated;
use super::spectra::{self, index};
use crate::bsdf::{BsdfTextures, Fibre, HairTextures};
use crate::geometry::Transform;
use crate::scene::description::{BsdfKind, FibreAbsorption, IndexSource};
use crate::scene::source::{Place, SceneError};
use crate::spectrum::Spectrum;
use crate::texture::Texture;
use crate::units::WavelengthRange;

/// What a pigment of concentration 1 absorbs per radius of a fibre at 550 nm, and the power of the wavelength
/// by which it falls.
///
/// The powers are those of melanin (Donner and Jensen, "A Spectral BSSRDF for Shading Human Skin", EGSR 2006,
/// after Jacques). The curves pass through the colours that d'Eon et al. have for fibres ("An
/// Energy-Conserving Hair Reflectance Model", EGSR 2011) at 640, 550 and 450 nm, within 0.013: 0.419, 0.697,
/// 1.37 and 0.187, 0.4, 1.05.
const EUMELANIN: [f64; 2] = [0.697, 3.33];
const PHEOMELANIN: [f64; 2] = [0.4, 4.75];

fn pigment([green, power]: [f64; 2], nm: f64) -> f64 {
    green * (550.0 / nm).powf(power)
}

/// The textures of a fibre; any other BSDF is black.
pub(super) fn compiled(
    place: &Place,
    kind: &BsdfKind,
    range: WavelengthRange,
    shift: &Transform,
) -> Result<BsdfTextures, SceneError> {
    let BsdfKind::Hair { absorption, interior, exterior, roughness, scale_tilt } = kind else {
        return Ok(BsdfTextures::Black);
    };
    let eta = relative_index(interior, &outside(exterior, range)?, range)?;
    let absorption = match absorption {
        FibreAbsorption::Pigments { eumelanin, pheomelanin } => {
            let at = |nm: f64| eumelanin * pigment(EUMELANIN, nm) + pheomelanin * pigment(PHEOMELANIN, nm);
            Texture::Uniform(tabulated(range, place, &[], &at)?)
        }
        FibreAbsorption::Coefficient(source) => spectra::texture(source, shift)?,
    };
    Ok(BsdfTextures::Hair(HairTextures {
        absorption,
        fibre: Fibre::new(eta, *roughness, scale_tilt.to_radians()),
    }))
}

fn relative_index(
    interior: &IndexSource,
    outside: &Spectrum,
    range: WavelengthRange,
) -> Result<f64, SceneError> {
    let error = |problem, expected, remedy| {
        Err(SceneError::at(&interior.place, problem, expected).with_remedy(remedy))
    };
    let (Spectrum::Constant(inside), Spectrum::Constant(outside)) = (index(interior, range)?, outside) else {
        let remedy = "that of hair is 1.55";
        return error("the index of a fibre varies with wavelength", "a number, inside and outside", remedy);
    };
    if inside == *outside {
        let remedy = "that of hair is 1.55";
        return error("the fibre has the index of what is outside", "two indices that differ", remedy);
    }
    Ok(inside / outside)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pigments_have_the_colours_of_deon() {
        let colours = [(EUMELANIN, [0.419, 0.697, 1.37]), (PHEOMELANIN, [0.187, 0.4, 1.05])];
        for (curve, colour) in colours {
            for (nm, expected) in [640.0, 550.0, 450.0].into_iter().zip(colour) {
                let found = pigment(curve, nm);
                assert!((found - expected).abs() < 0.013, "{nm} nm: {found}, not {expected}");
            }
        }
    }
}
