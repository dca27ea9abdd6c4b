//! Functions of wavelength, the wavelengths of a path, and colour.
//!
//! A [`Spectrum`] is a function of vacuum wavelength; its unit belongs to its use (radiance for an emitter,
//! none for a reflectance or an index, 1/m for an absorption). A [`Sampled`] holds its values at the
//! wavelengths of one path. Tables are kept as published: linear between their nodes, and outside them
//! either zero or the end value, as [`Extrapolation`] says.

mod blackbody;
pub mod catalogue;
pub mod colour;
pub(crate) mod data;
pub mod daylight;
pub mod dispersion;
mod error;
pub mod normal_reflectance;
mod sampled;
mod sampled_lanes;
mod table;
pub mod table_file;
mod tabulated;
pub mod text;
mod upsampling;
mod wavelengths;

use crate::units::WavelengthRange;

pub use blackbody::{Blackbody, blackbody_radiance};
pub use dispersion::{DispersionFormula, FormulaKind};
pub use error::SpectrumError;
pub use normal_reflectance::NormalReflectance;
pub use sampled::Sampled;
pub use sampled_lanes::SampledLanes;
pub use table::{Extrapolation, Irregular, Table, Uniform};
pub use upsampling::{Sigmoid, upsample};
pub use wavelengths::{Emission, Response, WavelengthDensity, Wavelengths};

/// A function of vacuum wavelength (nm). Its unit belongs to its use.
#[derive(Clone, Debug, PartialEq)]
pub enum Spectrum {
    /// The same value at every wavelength.
    Constant(f64),
    /// A table whose nodes lie on a regular grid: one index and one interpolation a look-up.
    Uniform(Uniform),
    /// A table with arbitrary nodes, found through a guide table.
    Irregular(Irregular),
    /// Thermal radiation, evaluated exactly.
    Blackbody(Blackbody),
    /// A smooth reflectance made for a colour, times a factor.
    Sigmoid {
        /// The curve, from 0 to 1.
        shape: Sigmoid,
        /// Factor on the curve.
        factor: f64,
    },
}

impl Spectrum {
    /// 0 at all wavelengths.
    pub const ZERO: Self = Self::Constant(0.0);
    /// 1 at all wavelengths.
    pub const ONE: Self = Self::Constant(1.0);

    /// A table of `values` at equal steps from `min` to `max` nm, both included.
    ///
    /// # Errors
    /// Fewer than two values, a value that is not finite, or `min` not below `max`.
    pub fn regular(
        min: f64,
        max: f64,
        values: &[f64],
        outside: Extrapolation,
    ) -> Result<Self, SpectrumError> {
        Uniform::new(min, max, values, outside).map(Self::Uniform)
    }

    /// A table of `values` at the wavelengths `nodes` (nm, strictly increasing), linear between them.
    ///
    /// Nodes that lie on a common step (5, 2, 1, 0.5, 0.2 or 0.1 nm, or any step of their own) are stored
    /// on that grid, which changes no value; others keep their nodes and are found through a guide table.
    ///
    /// # Errors
    /// Fewer than two nodes, as many values as nodes not given, wavelengths that are not finite, not
    /// positive or not strictly increasing, values that are not finite.
    pub fn irregular(nodes: &[f64], values: &[f64], outside: Extrapolation) -> Result<Self, SpectrumError> {
        let table = Table::new(nodes, values, outside)?;
        Ok(match Uniform::from_table(&table) {
            Some(uniform) => Self::Uniform(uniform),
            None => Self::Irregular(Irregular::from_table(table)),
        })
    }

    /// Radiance of a black body, W·m⁻²·sr⁻¹·nm⁻¹.
    ///
    /// # Errors
    /// A temperature that is negative or not finite.
    pub fn blackbody(kelvin: f64) -> Result<Self, SpectrumError> {
        Blackbody::new(kelvin).map(Self::Blackbody)
    }

    /// The value at one wavelength (nm).
    #[inline]
    pub fn at(&self, nm: f64) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Uniform(table) => table.at(nm),
            Self::Irregular(table) => table.at(nm),
            Self::Blackbody(body) => body.at(nm),
            Self::Sigmoid { shape, factor } => factor * shape.at(nm),
        }
    }

    /// The values at the wavelengths (nm) of one path.
    #[inline]
    pub fn sample<const C: usize>(&self, nm: &[f64; C]) -> Sampled<C> {
        match self {
            Self::Constant(value) => Sampled::splat(*value),
            Self::Uniform(table) => table.sample(nm),
            Self::Irregular(table) => Sampled::from_fn(|lane| table.at(nm[lane])),
            Self::Blackbody(body) => Sampled::from_fn(|lane| body.at(nm[lane])),
            Self::Sigmoid { shape, factor } => Sampled::from_fn(|lane| factor * shape.at(nm[lane])),
        }
    }

    /// The same function times `factor`.
    pub fn scaled(&self, factor: f64) -> Self {
        match self {
            Self::Constant(value) => Self::Constant(value * factor),
            Self::Uniform(table) => Self::Uniform(table.scaled(factor)),
            Self::Irregular(table) => Self::Irregular(table.scaled(factor)),
            Self::Blackbody(body) => Self::Blackbody(body.scaled(factor)),
            Self::Sigmoid { shape, factor: own } => Self::Sigmoid { shape: *shape, factor: own * factor },
        }
    }

    /// The published table behind this function, where there is one.
    pub fn table(&self) -> Option<&Table> {
        match self {
            Self::Constant(_) | Self::Blackbody(_) | Self::Sigmoid { .. } => None,
            Self::Uniform(table) => Some(table.source()),
            Self::Irregular(table) => Some(table.source()),
        }
    }

    /// What stands for the table behind this function, as long as that lives: clones share it. `None` where
    /// there is no table.
    pub fn identity(&self) -> Option<(*const f64, bool)> {
        let table = self.table()?;
        Some((table.values().as_ptr(), table.outside() == Extrapolation::Hold))
    }

    /// Wavelengths (nm, increasing) at which the slope may break. Empty where the function is smooth.
    pub fn nodes(&self) -> Vec<f64> {
        self.table().map_or_else(Vec::new, |table| table.nodes().to_vec())
    }

    /// The wavelengths that the table covers; `None` where the function is known everywhere.
    pub fn domain(&self) -> Option<WavelengthRange> {
        self.table().map(Table::domain)
    }

    /// Whether `range` asks for values that no table states and that are held from its ends.
    pub fn is_held_within(&self, range: WavelengthRange) -> bool {
        self.table().is_some_and(|table| {
            let known = table.domain();
            table.outside() == Extrapolation::Hold && (range.min < known.min || range.max > known.max)
        })
    }

    /// Least and greatest value over `range`.
    pub fn bounds(&self, range: WavelengthRange) -> (f64, f64) {
        match self {
            Self::Constant(value) => (*value, *value),
            Self::Uniform(table) => table.source().bounds(range),
            Self::Irregular(table) => table.source().bounds(range),
            Self::Blackbody(body) => body.bounds(range),
            Self::Sigmoid { shape, factor } => {
                let (a, b) = shape.bounds(range);
                ((a * factor).min(b * factor), (a * factor).max(b * factor))
            }
        }
    }

    /// Integral over `range`, in the function's unit times nm.
    ///
    /// Exact for constants and tables (up to rounding), to about 1e-13 of its value for black bodies, 1e-9
    /// for sigmoids.
    pub fn integral(&self, range: WavelengthRange) -> f64 {
        match self {
            Self::Constant(value) => value * range.width(),
            Self::Uniform(table) => table.source().integral(range),
            Self::Irregular(table) => table.source().integral(range),
            Self::Blackbody(body) => body.integral(range),
            Self::Sigmoid { shape, factor } => factor * shape.integral(range),
        }
    }

    /// Whether the function has one value at every wavelength (a table of equal values that are held
    /// outside counts too).
    pub fn is_constant(&self) -> bool {
        match self {
            Self::Constant(_) => true,
            Self::Uniform(table) => table.source().is_constant(),
            Self::Irregular(table) => table.source().is_constant(),
            Self::Blackbody(body) => body.is_dark(),
            Self::Sigmoid { shape, factor } => *factor == 0.0 || shape.is_constant(),
        }
    }

    /// Whether the function is zero at every wavelength of `range`.
    pub fn is_zero(&self, range: WavelengthRange) -> bool {
        self.bounds(range) == (0.0, 0.0)
    }

    /// The same table with another rule for what lies outside it; other functions are unchanged.
    pub fn with_extrapolation(&self, outside: Extrapolation) -> Self {
        match self {
            Self::Constant(_) | Self::Blackbody(_) | Self::Sigmoid { .. } => self.clone(),
            Self::Uniform(table) => Self::Uniform(table.with_extrapolation(outside)),
            Self::Irregular(table) => Self::Irregular(table.with_extrapolation(outside)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Extrapolation::{Hold, Zero};

    fn examples() -> Vec<(&'static str, Spectrum)> {
        let saw: Vec<f64> = (0..95).map(|i| f64::from(i % 7) + 0.1).collect();
        let uneven = [360.25, 400.0, 401.7, 523.111, 523.112, 700.0];
        let heights = [0.0, 1.0, 0.3, 0.2, 5.0, 0.5];
        vec![
            ("constant", Spectrum::Constant(0.7)),
            ("regular, zero outside", Spectrum::regular(360.0, 830.0, &saw, Zero).unwrap()),
            ("regular, held", Spectrum::regular(400.0, 700.0, &saw, Hold).unwrap()),
            ("irregular, zero outside", Spectrum::irregular(&uneven, &heights, Zero).unwrap()),
            ("irregular, held", Spectrum::irregular(&uneven, &heights, Hold).unwrap()),
            ("common step", Spectrum::irregular(&[380.0, 390.5, 395.0, 780.0], &heights[..4], Zero).unwrap()),
            ("blackbody", Spectrum::blackbody(3000.0).unwrap()),
            ("sigmoid", Spectrum::Sigmoid { shape: upsample([0.1, 0.7, 0.3]), factor: 2.0 }),
        ]
    }

    #[test]
    fn lanes_agree_with_single_values() {
        for (name, spectrum) in examples() {
            for i in 0..2000 {
                let nm = [330.0, 330.0 + 0.3 * f64::from(i), 523.1115, 829.999];
                assert_eq!(spectrum.sample(&nm).0, nm.map(|nm| spectrum.at(nm)), "{name} at {nm:?}");
            }
        }
    }

    #[test]
    fn lookups_agree_with_the_published_table() {
        for (name, spectrum) in examples() {
            let Some(table) = spectrum.table() else { continue };
            for i in 0..60_000 {
                let nm = 340.0 + 0.01 * f64::from(i);
                let (fast, exact) = (spectrum.at(nm), table.at(nm));
                assert!((fast - exact).abs() < 1e-9, "{name} at {nm} nm: {fast}, the table says {exact}");
            }
            for (&nm, &value) in table.nodes().iter().zip(table.values()) {
                assert!((spectrum.at(nm) - value).abs() < 1e-12, "{name} at node {nm} nm");
            }
        }
    }

    #[test]
    fn outside_is_zero_or_held() {
        let at = |outside| {
            let s = Spectrum::irregular(&[400.0, 500.1234, 600.0], &[2.0, 3.0, 4.0], outside).unwrap();
            [399.999, 400.0, 600.0, 600.001].map(|nm| s.at(nm))
        };
        assert_eq!(at(Zero), [0.0, 2.0, 4.0, 0.0]);
        assert_eq!(at(Hold), [2.0, 2.0, 4.0, 4.0]);
        let regular = |outside| {
            let s = Spectrum::regular(380.1, 779.9, &[2.0, 3.0, 4.0], outside).unwrap();
            [-f64::INFINITY, 380.0, 380.1, 779.9, 780.0, f64::INFINITY].map(|nm| s.at(nm))
        };
        assert_eq!(regular(Zero), [0.0, 0.0, 2.0, 4.0, 0.0, 0.0]);
        assert_eq!(regular(Hold), [2.0, 2.0, 2.0, 4.0, 4.0, 4.0]);
    }

    /// Against a midpoint sum fine enough for its own error (jumps included) to stay below 1e-4.
    #[test]
    fn integrals_agree_with_a_fine_sum() {
        let ranges = [(360.0, 830.0), (395.3, 701.9), (523.1113, 523.1118), (300.0, 350.0)];
        for (name, spectrum) in examples() {
            for (min, max) in ranges {
                let range = WavelengthRange { min, max };
                let cells = 1_000_000;
                let width = range.width() / f64::from(cells);
                let sum: f64 =
                    (0..cells).map(|i| spectrum.at(min + (f64::from(i) + 0.5) * width) * width).sum();
                let exact = spectrum.integral(range);
                assert!(
                    (sum - exact).abs() <= 1e-5 * exact.abs() + 1e-9,
                    "{name} over {range:?}: {exact}, sum {sum}"
                );
            }
        }
    }

    #[test]
    fn bounds_enclose_and_are_reached() {
        let range = WavelengthRange { min: 397.0, max: 720.0 };
        for (name, spectrum) in examples() {
            let (least, greatest) = spectrum.bounds(range);
            let seen: Vec<f64> =
                (0..=323_000).map(|i| spectrum.at(range.min + 0.001 * f64::from(i))).collect();
            let low = seen.iter().copied().fold(f64::INFINITY, f64::min);
            let high = seen.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let slack = 1e-12 * greatest;
            assert!(
                least <= low + slack && greatest >= high - slack,
                "{name}: {least}..{greatest}, saw {low}..{high}"
            );
            let near = 0.01 * (greatest - least) + slack;
            assert!(low - least <= near && greatest - high <= near, "{name}: bounds are not reached");
        }
    }

    #[test]
    fn scaling_scales_values_bounds_and_integrals() {
        let range = WavelengthRange::VISIBLE;
        for (name, spectrum) in examples() {
            let doubled = spectrum.scaled(2.0);
            assert_eq!(doubled.at(523.1), 2.0 * spectrum.at(523.1), "{name}");
            assert_eq!(doubled.bounds(range).1, 2.0 * spectrum.bounds(range).1, "{name}");
            let (a, b) = (doubled.integral(range), 2.0 * spectrum.integral(range));
            assert!((a - b).abs() <= 1e-12 * b.abs(), "{name}");
        }
    }

    #[test]
    fn nodes_on_a_common_step_become_uniform() {
        let uniform = |nodes: &[f64]| {
            let values: Vec<f64> = nodes.iter().map(|nm| nm.sin()).collect();
            matches!(Spectrum::irregular(nodes, &values, Zero).unwrap(), Spectrum::Uniform(_))
        };
        assert!(uniform(&[334.0, 350.0, 365.0, 370.0, 2500.0]));
        assert!(uniform(&[380.1, 380.4, 401.0, 500.7]));
        assert!(uniform(&[300.0, 830.0]));
        assert!(uniform(&[400.0, 403.7, 407.4]));
        assert!(!uniform(&[190.74, 193.73, 2066.4]));
        assert!(!uniform(&[400.0, 400.000_001, 401.0]));
    }

    #[test]
    fn wrong_tables_are_refused_with_the_reason() {
        use SpectrumError::*;
        let make = |nodes: &[f64], values: &[f64]| Spectrum::irregular(nodes, values, Zero).unwrap_err();
        assert_eq!(make(&[400.0], &[1.0]), TooFewNodes { found: 1 });
        assert_eq!(make(&[400.0, 500.0], &[1.0]), LengthsDiffer { wavelengths: 2, values: 1 });
        assert_eq!(
            make(&[400.0, 400.0], &[1.0, 1.0]),
            NotIncreasing { index: 1, previous_nm: 400.0, nm: 400.0 }
        );
        assert_eq!(
            make(&[500.0, 400.0], &[1.0, 1.0]),
            NotIncreasing { index: 1, previous_nm: 500.0, nm: 400.0 }
        );
        assert!(matches!(make(&[f64::NAN, 400.0], &[1.0, 1.0]), BadWavelength { index: 0, .. }));
        assert!(matches!(make(&[-3.0, 400.0], &[1.0, 1.0]), BadWavelength { index: 0, .. }));
        assert!(matches!(make(&[300.0, 400.0], &[1.0, f64::NAN]), BadValue { nm: 400.0, .. }));
        assert!(Spectrum::regular(500.0, 400.0, &[1.0, 2.0], Zero).is_err());
        assert!(Spectrum::regular(400.0, 500.0, &[1.0], Zero).is_err());
    }

    #[test]
    fn a_wavelength_that_is_not_a_number_does_not_panic() {
        for (_, spectrum) in examples() {
            spectrum.at(f64::NAN);
        }
    }
}
