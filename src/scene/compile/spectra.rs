use crate::scene::description::{IndexKind, IndexSource, SpectrumKind, SpectrumSource};
use crate::scene::source::{Place, SceneError};
use crate::spectrum::{Extrapolation, NormalReflectance, Spectrum, SpectrumError, catalogue};
use crate::texture::Texture;
use crate::units::WavelengthRange;

/// A spectrum that can be looked up. Tables of a file are zero beyond their ends, as in Mitsuba 3; measured ones of the
/// catalogue follow their own rule.
pub(super) fn spectrum(source: &SpectrumSource) -> Result<Spectrum, SceneError> {
    let wrong = |error: &dyn std::fmt::Display| {
        SceneError::at(
            &source.place,
            error.to_string(),
            "a spectrum of finite values over ascending wavelengths",
        )
    };
    let unscaled = match &source.kind {
        SpectrumKind::Constant(value) => Spectrum::Constant(*value),
        SpectrumKind::Irregular { nm, values, .. } => {
            Spectrum::irregular(nm, values, Extrapolation::Zero).map_err(|error| wrong(&error))?
        }
        SpectrumKind::Regular { min_nm, max_nm, values } => {
            Spectrum::regular(*min_nm, *max_nm, values, Extrapolation::Zero).map_err(|error| wrong(&error))?
        }
        SpectrumKind::D65 => {
            let published = named(&source.place, "D65")?;
            published.scaled(1.0 / MITSUBA_D65_SCALE)
        }
        SpectrumKind::Blackbody { kelvin, min_nm, max_nm } => {
            thermal(*kelvin, WavelengthRange { min: *min_nm, max: *max_nm }).map_err(|error| wrong(&error))?
        }
        SpectrumKind::Named(name) => named(&source.place, name)?,
    };
    Ok(if source.scale == 1.0 { unscaled } else { unscaled.scaled(source.scale) })
}

/// A quantity that may vary over a surface.
pub(super) fn texture(source: &SpectrumSource) -> Result<Texture, SceneError> {
    spectrum(source).map(Texture::Uniform)
}

/// Planck's law, cut off at the ends of a range unless that holds all that can be seen.
fn thermal(kelvin: f64, range: WavelengthRange) -> Result<Spectrum, SpectrumError> {
    let whole = Spectrum::blackbody(kelvin)?;
    if range.min <= WavelengthRange::VISIBLE.min && range.max >= WavelengthRange::VISIBLE.max {
        return Ok(whole);
    }
    let nm = steps(range);
    let values: Vec<f64> = nm.iter().map(|&nm| whole.at(nm)).collect();
    Spectrum::regular(range.min, range.max, &values, Extrapolation::Zero)
}

/// A refractive index over the range.
pub(super) fn index(source: &IndexSource, range: WavelengthRange) -> Result<Spectrum, SceneError> {
    let wrong = |error: &dyn std::fmt::Display| {
        SceneError::at(&source.place, error.to_string(), "a finite, positive refractive index")
    };
    match &source.kind {
        IndexKind::Constant(value) => Ok(Spectrum::Constant(*value)),
        IndexKind::Named(name) => match catalogue::dielectric(name) {
            Ok(index) => index.to_spectrum(range).map_err(|error| wrong(&error)),
            Err(unknown) => Err(SceneError::at(
                &source.place,
                unknown.to_string(),
                "the name of a dielectric in the catalogue",
            )),
        },
        IndexKind::Formula(formula) => formula.to_spectrum(range).map_err(|error| wrong(&error)),
        IndexKind::Tabulated(table) => Ok(spectrum(table)?.with_extrapolation(Extrapolation::Hold)),
        IndexKind::NormalReflectance(reflectance) => {
            let optics = NormalReflectance::dielectric(spectrum(reflectance)?, range)
                .map_err(|error| wrong(&error))?;
            let (n, _) = complex_index(&optics, range).map_err(|error| wrong(&error))?;
            Ok(n)
        }
    }
}

/// Equal steps over a range, so fine that to interpolate what was computed there makes no difference to a render.
fn steps(range: WavelengthRange) -> Vec<f64> {
    const STEP_NM: f64 = 0.5;
    let steps = (range.width() / STEP_NM).ceil().max(1.0) as usize;
    (0..=steps).map(|i| range.min + range.width() * i as f64 / steps as f64).collect()
}

/// n and k as tables over the range.
pub(super) fn complex_index(
    optics: &NormalReflectance,
    range: WavelengthRange,
) -> Result<(Spectrum, Spectrum), SpectrumError> {
    let (n, k): (Vec<f64>, Vec<f64>) = steps(range).iter().map(|&nm| optics.at(nm)).unzip();
    let table = |values: &[f64]| Spectrum::regular(range.min, range.max, values, Extrapolation::Hold);
    Ok((table(&n)?, table(&k)?))
}

/// What Mitsuba 3 divides the CIE's table of D65 by.
const MITSUBA_D65_SCALE: f64 = 98.9974;

/// A measured reflectance, illuminant or absorption: no name stands for two of them.
fn named(place: &Place, name: &str) -> Result<Spectrum, SceneError> {
    catalogue::reflectance(name)
        .or_else(|_| catalogue::illuminant(name))
        .or_else(|_| catalogue::absorption(name))
        .map_err(|unknown| SceneError::at(place, unknown.to_string(), "the name of a measured spectrum"))
}
