//! Refractive index as a formula of wavelength, and how strongly it disperses.
//!
//! A catalogue states a formula with a range, often narrower than what is rendered (390–2500 nm). Outside its
//! range a formula is extended as long as it stays plausible, and held at the last plausible value beyond;
//! [`DispersionFormula::reach`] says which of the two a run depends on, so that it can be shown.
//!
//! Glass catalogues give the index relative to air at air wavelengths. Taking both as vacuum values, as is
//! done here, is right for scenes whose surroundings have index 1 (the ratio across the surface is what
//! refracts). In air of index 1.000277, which surrounds what states no other, a prism of 60° bends light by
//! 0.04° (N-BK7) to 0.07° (N-SF11) less. The 0.03 % between the two wavelength scales changes the index of a
//! dense flint by less than 4e-5.

use super::error::SpectrumError;
use super::{Extrapolation, Spectrum};
use crate::units::{FRAUNHOFER_C, FRAUNHOFER_D, FRAUNHOFER_F, WavelengthRange};
use std::fmt;

/// The shapes of dispersion formula that catalogues use; λ is in µm throughout.
///
/// Numbered ones are those of the refractiveindex.info database, with its coefficients `c[0], c[1], ...`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FormulaKind {
    /// Formula 1: `n² − 1 = c₀ + Σ cᵢ λ² / (λ² − cᵢ₊₁²)`, i = 1, 3, 5...
    SellmeierSquared,
    /// Formula 2: `n² − 1 = c₀ + Σ cᵢ λ² / (λ² − cᵢ₊₁)`. With `c₀ = 0` the Sellmeier equation of glass
    /// catalogues.
    Sellmeier,
    /// Formula 3: `n² = c₀ + Σ cᵢ λ^cᵢ₊₁`.
    Polynomial,
    /// Formula 4: `n² = c₀ + c₁ λ^c₂ / (λ² − c₃^c₄) + c₅ λ^c₆ / (λ² − c₇^c₈) + Σ cᵢ λ^cᵢ₊₁`, i = 9, 11...
    Rational,
    /// Formula 5: `n = c₀ + Σ cᵢ λ^cᵢ₊₁`.
    Cauchy,
    /// Formula 6: `n − 1 = c₀ + Σ cᵢ / (cᵢ₊₁ − λ⁻²)`.
    Gas,
}

impl FormulaKind {
    /// The kind with this number in the refractiveindex.info database (1 to 6).
    pub fn from_number(number: u32) -> Option<Self> {
        use FormulaKind::*;
        [SellmeierSquared, Sellmeier, Polynomial, Rational, Cauchy, Gas]
            .get(number.checked_sub(1)? as usize)
            .copied()
    }

    /// The index itself, wherever the formula has one (may be NaN or infinite near a pole).
    fn evaluate(self, c: &[f64], um: f64) -> f64 {
        let squared = um * um;
        let coefficient = |i: usize| c.get(i).copied().unwrap_or(0.0);
        let sum_from = |first: usize, term: &dyn Fn(f64, f64) -> f64| -> f64 {
            c.get(first..).unwrap_or_default().chunks_exact(2).map(|pair| term(pair[0], pair[1])).sum()
        };
        let power = |factor: f64, exponent: f64| factor * um.powf(exponent);
        match self {
            Self::SellmeierSquared => {
                (1.0 + coefficient(0) + sum_from(1, &|b, root| b * squared / (squared - root * root))).sqrt()
            }
            Self::Sellmeier => {
                (1.0 + coefficient(0) + sum_from(1, &|b, c| b * squared / (squared - c))).sqrt()
            }
            Self::Polynomial => (coefficient(0) + sum_from(1, &power)).sqrt(),
            Self::Rational => {
                let pole = |i: usize| {
                    let factor = coefficient(i);
                    let place = coefficient(i + 2).powf(coefficient(i + 3));
                    if factor == 0.0 { 0.0 } else { power(factor, coefficient(i + 1)) / (squared - place) }
                };
                (coefficient(0) + pole(1) + pole(5) + sum_from(9, &power)).sqrt()
            }
            Self::Cauchy => coefficient(0) + sum_from(1, &power),
            Self::Gas => 1.0 + coefficient(0) + sum_from(1, &|b, c| b / (c - 1.0 / squared)),
        }
    }
}

/// Why a formula was refused.
#[derive(Clone, Debug, PartialEq)]
pub enum DispersionError {
    /// Coefficients are finite, and come in pairs after the first.
    BadCoefficients {
        /// The coefficients.
        found: Vec<f64>,
    },
    /// A range of positive wavelengths, least first.
    BadRange {
        /// Where it begins, nm.
        min_nm: f64,
        /// Where it ends, nm.
        max_nm: f64,
    },
    /// The formula gives no index above zero at this wavelength, within the range it claims.
    NoIndex {
        /// Wavelength, nm.
        nm: f64,
        /// What the formula gives there for n.
        value: f64,
    },
}

impl fmt::Display for DispersionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BadCoefficients { found } => {
                write!(f, "expected a finite coefficient and then finite pairs, found {found:?}")
            }
            Self::BadRange { min_nm, max_nm } => {
                write!(f, "expected a range of positive wavelengths, found {min_nm} to {max_nm} nm")
            }
            Self::NoIndex { nm, value } => {
                write!(f, "expected a positive refractive index, the formula gives {value} at {nm} nm")
            }
        }
    }
}

impl std::error::Error for DispersionError {}

/// A refractive index as a function of wavelength.
#[derive(Clone, Debug, PartialEq)]
pub struct DispersionFormula {
    kind: FormulaKind,
    coefficients: Box<[f64]>,
    stated: WavelengthRange,
    usable: WavelengthRange,
}

/// How a wavelength range relates to the one that a formula is stated for: what a run assumes beyond its
/// data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// The range that the source states.
    pub stated: WavelengthRange,
    /// The range in which the formula is evaluated; beyond it the index is held.
    pub usable: WavelengthRange,
    /// The range that was asked for.
    pub wanted: WavelengthRange,
}

impl Reach {
    /// Whether wavelengths outside the stated range are wanted.
    pub fn is_extended(&self) -> bool {
        self.wanted.min < self.stated.min || self.wanted.max > self.stated.max
    }

    /// Whether wavelengths are wanted at which the index is held constant.
    pub fn is_held(&self) -> bool {
        self.wanted.min < self.usable.min || self.wanted.max > self.usable.max
    }
}

impl fmt::Display for Reach {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { stated, usable, wanted } = self;
        if !self.is_extended() {
            return write!(f, "the dispersion formula covers {}–{} nm", wanted.min, wanted.max);
        }
        write!(
            f,
            "the dispersion formula is stated for {}–{} nm and extended to {}–{} nm",
            stated.min,
            stated.max,
            wanted.min.max(usable.min).min(stated.min),
            wanted.max.min(usable.max).max(stated.max)
        )?;
        match self.is_held() {
            true => write!(f, "; the index is held constant beyond"),
            false => Ok(()),
        }
    }
}

/// Outside its stated range a formula may change the index by this factor before it is held.
const PLAUSIBLE: f64 = 1.25;

/// How far from its stated range a formula is tried, nm.
const FARTHEST: f64 = 1000.0;

impl DispersionFormula {
    /// A formula of the given kind, stated for `range`.
    ///
    /// # Errors
    /// Coefficients that do not fit the kind, a range that is none, or no index above zero within it.
    pub fn new(
        kind: FormulaKind,
        coefficients: &[f64],
        stated: WavelengthRange,
    ) -> Result<Self, DispersionError> {
        if coefficients.len().is_multiple_of(2) || coefficients.iter().any(|c| !c.is_finite()) {
            return Err(DispersionError::BadCoefficients { found: coefficients.to_vec() });
        }
        if !(stated.min > 0.0 && stated.min <= stated.max && stated.max.is_finite()) {
            return Err(DispersionError::BadRange { min_nm: stated.min, max_nm: stated.max });
        }
        let index = |nm: f64| kind.evaluate(coefficients, nm * 1e-3);
        for step in 0..=256 {
            let nm = stated.min + stated.width() * f64::from(step) / 256.0;
            let value = index(nm);
            if !(value > 0.0 && value.is_finite()) {
                return Err(DispersionError::NoIndex { nm, value });
            }
        }
        // Walks outwards in steps of 1 nm until the index leaves [edge / PLAUSIBLE, edge · PLAUSIBLE].
        let reach = |edge: f64, direction: f64| {
            let at_edge = index(edge);
            let plausible = |nm: f64| {
                let value = index(nm);
                value >= 1f64.min(at_edge) && (at_edge / PLAUSIBLE..=at_edge * PLAUSIBLE).contains(&value)
            };
            let steps = (1..=FARTHEST as u32).map(|step| edge + direction * f64::from(step));
            steps.take_while(|&nm| nm > 0.0 && plausible(nm)).last().unwrap_or(edge)
        };
        let usable = WavelengthRange { min: reach(stated.min, -1.0), max: reach(stated.max, 1.0) };
        Ok(Self { kind, coefficients: coefficients.into(), stated, usable })
    }

    /// The Sellmeier equation `n² − 1 = Σ Bᵢ λ² / (λ² − Cᵢ)`, λ in µm, Cᵢ in µm², from pairs (Bᵢ, Cᵢ).
    ///
    /// # Errors
    /// As [`DispersionFormula::new`].
    pub fn sellmeier(terms: &[(f64, f64)], stated: WavelengthRange) -> Result<Self, DispersionError> {
        let pairs = terms.iter().flat_map(|&(b, c)| [b, c]);
        Self::new(FormulaKind::Sellmeier, &std::iter::once(0.0).chain(pairs).collect::<Vec<_>>(), stated)
    }

    /// Cauchy's equation `n = A + B / λ² + C / λ⁴ + ...`, λ in µm, from A, B, C...
    ///
    /// # Errors
    /// As [`DispersionFormula::new`].
    pub fn cauchy(terms: &[f64], stated: WavelengthRange) -> Result<Self, DispersionError> {
        let mut coefficients = vec![terms.first().copied().unwrap_or(f64::NAN)];
        for (power, &term) in terms.iter().enumerate().skip(1) {
            coefficients.extend([term, -2.0 * power as f64]);
        }
        Self::new(FormulaKind::Cauchy, &coefficients, stated)
    }

    /// Which formula it is.
    pub fn kind(&self) -> FormulaKind {
        self.kind
    }

    /// The coefficients, for wavelengths in µm.
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// The range that the source states.
    pub fn stated(&self) -> WavelengthRange {
        self.stated
    }

    /// Refractive index at a vacuum wavelength (nm): finite and positive everywhere, see the module.
    pub fn index(&self, nm: f64) -> f64 {
        self.kind.evaluate(&self.coefficients, nm.clamp(self.usable.min, self.usable.max) * 1e-3)
    }

    /// What rendering over `wanted` assumes beyond the stated range.
    pub fn reach(&self, wanted: WavelengthRange) -> Reach {
        Reach { stated: self.stated, usable: self.usable, wanted }
    }

    /// Abbe number, see [`abbe_number`].
    pub fn abbe_number(&self) -> f64 {
        abbe_number(|nm| self.index(nm))
    }

    /// The index over `range` as a table, held outside it.
    ///
    /// The step is halved from 1 nm until linear interpolation errs by less than 1e-7 (in n) at every
    /// midpoint, or down to 1/8 nm, which only happens beside a resonance.
    ///
    /// # Errors
    /// A range without width.
    pub fn to_spectrum(&self, range: WavelengthRange) -> Result<Spectrum, SpectrumError> {
        let values = |step: f64| -> Vec<f64> {
            let cells = (range.width() / step).ceil().max(1.0);
            (0..=cells as usize).map(|i| self.index(range.min + range.width() * (i as f64 / cells))).collect()
        };
        let mut step = 1.0;
        // The odd values of a table of half the step are the midpoints of this one.
        while step > 0.125
            && values(0.5 * step).windows(3).step_by(2).any(|v| (v[1] - 0.5 * (v[0] + v[2])).abs() > 1e-7)
        {
            step *= 0.5;
        }
        Spectrum::regular(range.min, range.max, &values(step), Extrapolation::Hold)
    }
}

/// Abbe number `V_d = (n_d − 1) / (n_F − n_C)` of an index: small for strong dispersion. Infinite for none.
pub fn abbe_number(index: impl Fn(f64) -> f64) -> f64 {
    (index(FRAUNHOFER_D) - 1.0) / (index(FRAUNHOFER_F) - index(FRAUNHOFER_C))
}

#[cfg(test)]
mod tests {
    use super::*;

    const RANGE: WavelengthRange = WavelengthRange { min: 300.0, max: 2500.0 };

    fn bk7() -> DispersionFormula {
        // N-BK7, SCHOTT catalogue.
        let terms = [(1.03961212, 0.00600069867), (0.231792344, 0.0200179144), (1.01046945, 103.560653)];
        DispersionFormula::sellmeier(&terms, RANGE).unwrap()
    }

    #[test]
    fn each_kind_follows_its_equation() {
        // Worked out by hand at λ = 0.5 µm.
        let at = |number, c: &[f64]| {
            let kind = FormulaKind::from_number(number).unwrap();
            DispersionFormula::new(kind, c, WavelengthRange { min: 490.0, max: 510.0 }).unwrap().index(500.0)
        };
        let close =
            |found: f64, expected: f64| assert!((found - expected).abs() < 1e-14, "{found} {expected}");
        close(at(1, &[0.1, 1.0, 0.2]), (1.1f64 + 0.25 / 0.21).sqrt());
        close(at(2, &[0.1, 1.0, 0.04]), (1.1f64 + 0.25 / 0.21).sqrt());
        close(at(3, &[2.0, 0.3, 2.0, 0.01, -4.0]), (2.0f64 + 0.075 + 0.16).sqrt());
        close(
            at(4, &[5.0, 0.2, 2.0, 0.3, 2.0, 0.1, 0.0, 0.05, 1.0, 0.01, -2.0]),
            (5.0f64 + 0.05 / 0.16 + 0.1 / 0.2 + 0.04).sqrt(),
        );
        close(at(5, &[1.5, 0.01, -2.0]), 1.54);
        close(at(6, &[0.0, 0.06, 240.0]), 1.0 + 0.06 / 236.0);
        assert_eq!(FormulaKind::from_number(0), None);
        assert_eq!(FormulaKind::from_number(7), None);
    }

    #[test]
    fn cauchy_is_a_series_in_inverse_squares() {
        let formula = DispersionFormula::cauchy(&[1.5, 0.004, 1e-5], RANGE).unwrap();
        assert!((formula.index(500.0) - (1.5 + 0.016 + 1.6e-4)).abs() < 1e-15);
    }

    /// Values of the SCHOTT data sheet of N-BK7: n at the lines F, d, C and the Abbe number 64.17.
    #[test]
    fn bk7_matches_its_data_sheet() {
        let glass = bk7();
        for (nm, n) in [(FRAUNHOFER_F, 1.52238), (FRAUNHOFER_D, 1.51680), (FRAUNHOFER_C, 1.51432)] {
            assert!((glass.index(nm) - n).abs() < 5e-6, "{nm} nm: {}", glass.index(nm));
        }
        assert!((glass.abbe_number() - 64.17).abs() < 0.01);
    }

    #[test]
    fn a_table_of_the_formula_errs_below_1e_7() {
        let flint = DispersionFormula::sellmeier(
            &[(1.73848403, 0.0136068604), (0.311168974, 0.0615960463), (1.17490871, 121.922711)],
            WavelengthRange { min: 390.0, max: 2500.0 },
        )
        .unwrap();
        for formula in [bk7(), flint] {
            let table = formula.to_spectrum(WavelengthRange::VISIBLE).unwrap();
            for i in 0..47_000 {
                let nm = 360.0 + 0.01 * f64::from(i);
                assert!((table.at(nm) - formula.index(nm)).abs() < 1.01e-7, "{nm} nm");
            }
        }
    }

    /// Zinc selenide has a resonance at 391 nm, inside the visible range but outside its stated one.
    #[test]
    fn beyond_its_range_a_formula_stays_finite_and_says_so() {
        let stated = WavelengthRange { min: 540.0, max: 18200.0 };
        let c = [0.0, 4.45813734, 0.200859853, 0.467216334, 0.391371166, 2.8956629, 47.1362108];
        let formula = DispersionFormula::new(FormulaKind::SellmeierSquared, &c, stated).unwrap();
        for nm in 1..2000 {
            let n = formula.index(f64::from(nm));
            assert!((2.0..3.4).contains(&n), "{nm} nm: {n}");
        }
        let reach = formula.reach(WavelengthRange::VISIBLE);
        assert!(reach.is_extended() && reach.is_held());
        assert!(reach.usable.min > 391.0 && reach.usable.min < 450.0, "{reach:?}");
        let inside = bk7().reach(WavelengthRange::VISIBLE);
        assert!(!inside.is_extended() && !inside.is_held());
        let message = formula.reach(WavelengthRange::VISIBLE).to_string();
        assert!(message.starts_with("the dispersion formula is stated for 540–18200 nm and extended to"));
    }

    #[test]
    fn wrong_formulas_are_refused() {
        use DispersionError::*;
        let make = |c: &[f64], min, max| {
            DispersionFormula::new(FormulaKind::Sellmeier, c, WavelengthRange { min, max }).unwrap_err()
        };
        assert!(matches!(make(&[0.0, 1.0], 300.0, 800.0), BadCoefficients { .. }));
        assert!(matches!(make(&[0.0, f64::NAN, 0.1], 300.0, 800.0), BadCoefficients { .. }));
        assert!(matches!(make(&[0.0, 1.0, 0.01], 800.0, 300.0), BadRange { .. }));
        assert!(matches!(make(&[-3.0, 1.0, 0.01], 300.0, 800.0), NoIndex { .. }));
        assert!(DispersionFormula::cauchy(&[], RANGE).is_err());
    }
}
