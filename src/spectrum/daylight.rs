//! CIE daylight of any correlated colour temperature (CIE 15:2018, section 4.1.2).

use super::table_file::TableFile;
use super::{Extrapolation, Spectrum, SpectrumError, data};

/// The second radiation constant's change since 1964, by which nominal temperatures are to be multiplied: D65
/// is at 6504 K.
const RESCALED: f64 = 1.4388 / 1.4380;

/// Chromaticity of daylight of a correlated colour temperature (K).
///
/// # Errors
/// A temperature outside 4000–25000 K.
pub fn daylight_chromaticity(kelvin: f64) -> Result<(f64, f64), SpectrumError> {
    if !(4000.0..=25000.0).contains(&kelvin) {
        return Err(SpectrumError::NotDaylight { kelvin });
    }
    let t = 1e3 / kelvin;
    let x = match kelvin <= 7000.0 {
        true => 0.244063 + t * (0.09911 + t * (2.9678 - t * 4.6070)),
        false => 0.237040 + t * (0.24748 + t * (1.9018 - t * 2.0064)),
    };
    Ok((x, -0.275 + x * (2.870 - x * 3.000)))
}

/// Relative spectral power of daylight of a correlated colour temperature (K), 100 at 560 nm:
/// `S₀ + M₁ S₁ + M₂ S₂` from 300 to 830 nm in steps of 5 nm, linear between, zero outside. M₁ and M₂ are
/// rounded to three decimals, as the CIE prescribes.
///
/// # Errors
/// A temperature outside 4000–25000 K.
pub fn daylight(kelvin: f64) -> Result<Spectrum, SpectrumError> {
    let (nodes, values) = daylight_columns(kelvin)?;
    Spectrum::irregular(&nodes, &values, Extrapolation::Zero)
}

/// Wavelengths (nm) and values of [`daylight`].
fn daylight_columns(kelvin: f64) -> Result<(Vec<f64>, Vec<f64>), SpectrumError> {
    let (x, y) = daylight_chromaticity(kelvin)?;
    let divisor = 0.0241 + 0.2562 * x - 0.7341 * y;
    let rounded = |m: f64| (m * 1e3).round() / 1e3;
    let m1 = rounded((-1.3515 - 1.7703 * x + 5.9114 * y) / divisor);
    let m2 = rounded((0.0300 - 31.4424 * x + 30.0717 * y) / divisor);
    let table = TableFile::parse(data::text("illuminants/cie_daylight_basis_s0_s1_s2_5nm"));
    let column = |name: &str| {
        let numbers = table.as_ref().ok().and_then(|table| table.numbers(name).ok());
        numbers.expect("the built-in basis is well formed, which a test checks")
    };
    let [nodes, s0, s1, s2] = ["wavelength_nm", "S0", "S1", "S2"].map(column);
    let values = s0.iter().zip(&s1).zip(&s2).map(|((s0, s1), s2)| s0 + m1 * s1 + m2 * s2).collect();
    Ok((nodes, values))
}

/// Continues a published daylight table (which end at 780 nm) to 830 nm by the CIE's formula.
pub(super) fn completed(
    nodes: &mut Vec<f64>,
    values: &mut Vec<f64>,
    nominal: f64,
) -> Result<(), SpectrumError> {
    let (basis, formula) = daylight_columns(nominal * RESCALED)?;
    let end = nodes.last().copied().unwrap_or(0.0);
    for (nm, value) in basis.into_iter().zip(formula).filter(|&(nm, _)| nm > end) {
        nodes.push(nm);
        values.push(value);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::catalogue;

    /// The formula against the published table up to 780 nm, and against values of the CIE's longer table
    /// beyond.
    #[test]
    fn formula_gives_the_published_d65() {
        let formula = daylight(6500.0 * RESCALED).unwrap();
        let published = catalogue::illuminant("D65").unwrap();
        for step in 0..=106 {
            let nm = 300.0 + 5.0 * f64::from(step);
            assert!((formula.at(nm) - published.at(nm)).abs() < 0.02, "{nm} nm");
        }
        for (nm, value) in [(785.0, 63.8434), (790.0, 64.3040), (830.0, 60.3125)] {
            assert!((formula.at(nm) - value).abs() < 2e-3, "{nm} nm: {}", formula.at(nm));
        }
        assert!((formula.at(560.0) - 100.0).abs() < 1e-12);
    }

    #[test]
    fn chromaticity_is_defined_from_4000_to_25000_kelvin() {
        let (x, y) = daylight_chromaticity(6504.0).unwrap();
        assert!((x - 0.3127).abs() < 1e-4 && (y - 0.3291).abs() < 1e-4);
        let (below, above) =
            (daylight_chromaticity(7000.0).unwrap(), daylight_chromaticity(7000.001).unwrap());
        assert!((below.0 - above.0).abs() < 1e-4);
        assert!(matches!(daylight(3999.0), Err(SpectrumError::NotDaylight { .. })));
        assert!(matches!(daylight(f64::NAN), Err(SpectrumError::NotDaylight { .. })));
    }
}
