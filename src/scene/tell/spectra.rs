use super::super::description::{SpectrumKind, SpectrumSource};
use super::super::read::Class;
use super::super::source::Place;
use super::{Told, Value};
use crate::spectrum::{DispersionFormula, FormulaKind};
use std::rc::Rc;

pub(super) fn tell(source: &SpectrumSource) -> Value {
    let SpectrumSource { place, kind, scale } = source;
    let told = |plugin| Told::new(Class::Spectrum, plugin, place);
    let scaled = |values: &[f64]| values.iter().map(|value| value * scale).collect::<Vec<_>>();
    let object = match kind {
        SpectrumKind::Constant(value) => return Value::Flat(value * scale),
        SpectrumKind::Irregular { nm, values, file } => {
            return Value::List { nm: nm.clone(), values: scaled(values), file: file.clone() };
        }
        SpectrumKind::Regular { min_nm, max_nm, values } => told("regular")
            .float("wavelength_min", *min_nm)
            .float("wavelength_max", *max_nm)
            .numbers("values", &scaled(values)),
        SpectrumKind::D65 => told("d65").float("scale", *scale),
        SpectrumKind::Blackbody { kelvin, min_nm, max_nm } => told("blackbody")
            .float("temperature", *kelvin)
            .float("wavelength_min", *min_nm)
            .float("wavelength_max", *max_nm),
        SpectrumKind::Named(name) => return measured(place, name, *scale),
    };
    Value::Object(Rc::new(object))
}

/// One of the measured spectra or materials that come with the program.
pub(super) fn measured(place: &Place, name: &str, scale: f64) -> Value {
    let told = Told::new(Class::Spectrum, "measured", place).text("name", name);
    Value::Object(Rc::new(if scale == 1.0 { told } else { told.float("scale", scale) }))
}

/// A refractive index by formula.
pub(super) fn formula(place: &Place, formula: &DispersionFormula) -> Value {
    let coefficients = formula.coefficients();
    // The files' formulas have n² − 1 = Σ ..., and powers of 1/λ² that are not written.
    let odd = coefficients.iter().skip(1).step_by(2).copied().collect::<Vec<_>>();
    let told = |plugin| Told::new(Class::Spectrum, plugin, place);
    let told = if formula.kind() == FormulaKind::Cauchy {
        let terms: Vec<f64> = coefficients.first().copied().into_iter().chain(odd).collect();
        told("cauchy").numbers("coefficients", &terms)
    } else {
        let even = coefficients.iter().skip(2).step_by(2).copied().collect::<Vec<_>>();
        told("sellmeier").numbers("b", &odd).numbers("c", &even)
    };
    let range = formula.stated();
    let told = told.float("wavelength_min", range.min).float("wavelength_max", range.max);
    Value::Object(Rc::new(told))
}
