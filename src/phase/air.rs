//! How the molecules of air scatter.
//!
//! The cross-section is that of Bucholtz ("Rayleigh-scattering calculations for the terrestrial atmosphere",
//! Applied Optics 34(15), 1995, eq. 1), for dry air with 360 ppm of carbon dioxide. The refractive index is
//! that of Peck and Reeder (Journal of the Optical Society of America 62, 1972). The King factor, which says
//! how far the molecules are no spheres, is that of Bates ("Rayleigh scattering by air", Planetary and Space
//! Science 32, 1984), put together from the gases as Bodhaine, Wood, Dutton and Slusser do ("On Rayleigh
//! optical depth calculations", Journal of Atmospheric and Oceanic Technology 16, 1999, eqs. 5, 6 and 23).

use super::{Mixture, Phase};
use crate::spectrum::{Extrapolation, Spectrum, SpectrumError};
use crate::units::WavelengthRange;
use std::f64::consts::PI;

/// Molecules in a cubic metre of air at 288.15 K and 1013.25 hPa (Bucholtz 1995).
pub const NUMBER_DENSITY: f64 = 2.547_43e25;

/// n − 1 of dry air at 288.15 K and 1013.25 hPa.
fn refractivity(nm: f64) -> f64 {
    let wavenumber = 1e3 / nm;
    let square = wavenumber * wavenumber;
    1e-8 * (5_791_817.0 / (238.0185 - square) + 167_909.0 / (57.362 - square))
}

/// (6 + 3ρ) / (6 − 7ρ), for a depolarisation factor ρ.
pub fn king_factor(nm: f64) -> f64 {
    let square = 1e6 / (nm * nm);
    let nitrogen = 1.034 + 3.17e-4 * square;
    let oxygen = 1.096 + 1.385e-3 * square + 1.448e-4 * square * square;
    // Per cent of the volume, with argon and carbon dioxide.
    let gases = [(78.084, nitrogen), (20.946, oxygen), (0.934, 1.0), (0.036, 1.15)];
    let sum = |of: fn(&(f64, f64)) -> f64| gases.iter().map(of).sum::<f64>();
    sum(|(part, factor)| part * factor) / sum(|(part, _)| *part)
}

/// What a molecule scatters, m².
pub fn cross_section(nm: f64) -> f64 {
    let index = 1.0 + refractivity(nm);
    let ratio = (index * index - 1.0) / (index * index + 2.0);
    let metres = nm * 1e-9;
    let square = metres * metres * NUMBER_DENSITY;
    24.0 * PI.powi(3) * ratio * ratio / (square * square) * king_factor(nm)
}

/// The fraction of what air scatters that goes alike in all directions; the rest does as small spheres do.
///
/// The phase function is ∝ (1 + 3γ) + (1 − γ) cos² θ with γ = ρ / (2 − ρ) (Chandrasekhar, *Radiative
/// Transfer*, 1950, section 18).
fn isotropic_fraction(nm: f64) -> f64 {
    let king = king_factor(nm);
    let depolarisation = 6.0 * (king - 1.0) / (3.0 + 7.0 * king);
    let gamma = depolarisation / (2.0 - depolarisation);
    3.0 * gamma / (1.0 + 2.0 * gamma)
}

/// The scattering coefficient, m⁻¹, of air at 288.15 K and 1013.25 hPa, and its phase function.
///
/// # Errors
/// None over a range of wavelengths that has a width.
pub fn optics(range: WavelengthRange) -> Result<(Spectrum, Phase), SpectrumError> {
    const STEP: f64 = 2.0;
    let table = |at: &dyn Fn(f64) -> f64| Spectrum::tabulated(range, STEP, &[], Extrapolation::Hold, at);
    let parts = vec![
        (table(&isotropic_fraction)?, Phase::Isotropic),
        (table(&|nm| 1.0 - isotropic_fraction(nm))?, Phase::Rayleigh),
    ];
    Ok((table(&|nm| NUMBER_DENSITY * cross_section(nm))?, Phase::Mixture(Mixture(parts))))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bucholtz's fit to his table of cross-sections (eq. 8 and table 3); his King factors are a little
    /// older.
    #[test]
    fn cross_sections_are_those_of_bucholtz() {
        for nm in (360..=830).step_by(10).map(f64::from) {
            let um = nm / 1e3;
            let [a, b, c, d] = match nm < 500.0 {
                true => [3.015_77e-32, 3.552_12, 1.355_79, 0.115_63],
                false => [4.010_61e-32, 3.996_68, 1.102_98e-3, 2.713_93e-2],
            };
            let expected = a * um.powf(-(b + c * um + d / um));
            let found = cross_section(nm);
            assert!((found / expected - 1.0).abs() < 2e-3, "{nm} nm: {found:e}, not {expected:e}");
        }
    }

    /// The column of all air above the sea, by its weight.
    #[test]
    fn the_optical_depth_of_the_atmosphere_at_550_nm() {
        // Pressure over gravity, at 45° and at the height of the centre of mass (Bodhaine et al., eq. 30),
        // over the mass of a molecule of dry air.
        let molecules = 101_325.0 / 9.7836 / (28.9595e-3 / 6.022_140_76e23);
        let depth = molecules * cross_section(550.0);
        assert!((depth - 0.0972).abs() < 3e-4, "{depth}");
    }

    /// λ to the power −4, and a little more: the index falls toward the red (Bodhaine et al., figure 2).
    #[test]
    fn the_slope_is_near_minus_four() {
        let slope = |a: f64, b: f64| (cross_section(b) / cross_section(a)).ln() / (b / a).ln();
        assert!((slope(400.0, 410.0) + 4.16).abs() < 0.02, "{}", slope(400.0, 410.0));
        assert!((slope(690.0, 700.0) + 4.05).abs() < 0.02, "{}", slope(690.0, 700.0));
    }
}
