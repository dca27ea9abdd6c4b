//! Thermal radiation.

use super::error::SpectrumError;
use crate::units::{BOLTZMANN, PLANCK, SPEED_OF_LIGHT, WavelengthRange};

/// First radiation constant for spectral radiance per nanometre, `2 h c²`, W·m⁻²·sr⁻¹·nm⁴
/// (per-metre value in W·m²·sr⁻¹, times 10⁴⁵ for nm⁵, times 10⁻⁹ for per nanometre).
const RADIANCE: f64 = 2.0 * PLANCK * SPEED_OF_LIGHT * SPEED_OF_LIGHT * 1e36;

/// Second radiation constant `h c / k`, nm·K.
const SECOND: f64 = PLANCK * SPEED_OF_LIGHT / BOLTZMANN * 1e9;

/// Root of `x = 5 (1 − e⁻ˣ)`: the spectral radiance per wavelength peaks at `λ T = SECOND / x` (Wien).
const WIEN_ROOT: f64 = 4.965_114_231_744_276;

/// Spectral radiance of a black body in vacuum, W·m⁻²·sr⁻¹·nm⁻¹.
///
/// `L(λ, T) = 2 h c² / λ⁵ / (exp(h c / (λ k T)) − 1)`, here per nanometre (Planck 1901; CODATA 2018
/// constants). Zero at and below 0 K or 0 nm. Neither the long-wave limit (where `exp(x) − 1` would cancel)
/// nor the short-wave one (where it would overflow) loses accuracy.
pub fn blackbody_radiance(nm: f64, kelvin: f64) -> f64 {
    if !(nm > 0.0 && kelvin > 0.0) {
        return 0.0;
    }
    let x = SECOND / (nm * kelvin);
    // 1 / (eˣ − 1) = e⁻ˣ / (1 − e⁻ˣ): the right side goes to 0, never to infinity over infinity.
    // λ⁵ is multiplied out: `powi` may round differently from one call to the next.
    let square = nm * nm;
    RADIANCE / (square * square * nm) * ((-x).exp() / -(-x).exp_m1())
}

/// A black body of one temperature, times a factor (an emissivity, or 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blackbody {
    kelvin: f64,
    scale: f64,
}

impl Blackbody {
    pub(super) fn new(kelvin: f64) -> Result<Self, SpectrumError> {
        match kelvin.is_finite() && kelvin >= 0.0 {
            true => Ok(Self { kelvin, scale: 1.0 }),
            false => Err(SpectrumError::BadTemperature { kelvin }),
        }
    }

    /// Temperature, K.
    pub fn kelvin(&self) -> f64 {
        self.kelvin
    }

    /// The factor on the black body's radiance.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Radiance at `nm`, W·m⁻²·sr⁻¹·nm⁻¹.
    #[inline]
    pub fn at(&self, nm: f64) -> f64 {
        self.scale * blackbody_radiance(nm, self.kelvin)
    }

    /// Wavelength of the greatest radiance, nm (Wien's displacement law). Infinite at 0 K.
    pub fn peak(&self) -> f64 {
        SECOND / (WIEN_ROOT * self.kelvin)
    }

    pub(super) fn scaled(self, factor: f64) -> Self {
        Self { scale: self.scale * factor, ..self }
    }

    pub(super) fn is_dark(&self) -> bool {
        self.kelvin == 0.0 || self.scale == 0.0
    }

    pub(super) fn bounds(&self, range: WavelengthRange) -> (f64, f64) {
        let ends = [self.at(range.min), self.at(range.max)];
        let top = self.at(self.peak().clamp(range.min, range.max));
        let all = [ends[0], ends[1], top];
        (all.into_iter().fold(f64::INFINITY, f64::min), all.into_iter().fold(f64::NEG_INFINITY, f64::max))
    }

    /// Integral over `range` by five-point Gauss–Legendre panels of equal width in ln λ, narrow enough for
    /// the exponent `h c / (λ k T)` to change by less than one half across a panel.
    pub(super) fn integral(&self, range: WavelengthRange) -> f64 {
        if self.is_dark() {
            return 0.0;
        }
        // Below this wavelength the radiance is less than the smallest f64.
        let from = range.min.max(SECOND / (LARGEST_EXPONENT * self.kelvin));
        if from >= range.max {
            return 0.0;
        }
        let span = (range.max / from).ln();
        let panels = (span * (4.0 + 2.0 * SECOND / (from * self.kelvin))).ceil();
        let half = 0.5 * span / panels;
        let mut sum = 0.0;
        for panel in 0..panels as u64 {
            let middle = (2 * panel + 1) as f64 * half;
            for (place, weight) in GAUSS_LEGENDRE_5 {
                let nm = from * (middle + place * half).exp();
                sum += weight * half * nm * self.at(nm);
            }
        }
        sum
    }
}

/// `exp(-745)` is the smallest positive f64.
const LARGEST_EXPONENT: f64 = 745.0;

/// Places in [−1, 1] and weights of the five-point Gauss–Legendre rule (Abramowitz and Stegun, table 25.4).
const GAUSS_LEGENDRE_5: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// Stefan–Boltzmann: the radiance of all wavelengths is `σ T⁴ / π`, `σ = 2 π⁵ k⁴ / (15 h³ c²)`.
    #[test]
    fn total_radiance_follows_stefan_boltzmann() {
        let sigma = 2.0 * PI.powi(5) * BOLTZMANN.powi(4) / (15.0 * PLANCK.powi(3) * SPEED_OF_LIGHT.powi(2));
        assert!((sigma / 5.670_374_419e-8 - 1.0).abs() < 1e-9);
        for kelvin in [1.0, 300.0, 2856.0, 5772.0, 1e6] {
            let body = Blackbody::new(kelvin).unwrap();
            // The tail beyond λ T = 10¹³ nm·K is below 10⁻¹⁵ of the whole.
            let total = body.integral(WavelengthRange { min: 1e-3, max: 1e13 / kelvin });
            let expected = sigma * kelvin.powi(4) / PI;
            assert!((total / expected - 1.0).abs() < 1e-11, "{kelvin} K: {total} instead of {expected}");
        }
    }

    /// Wien: the peak lies at `2.897771955e6 nm·K / T` (CODATA 2018), and both neighbours are darker.
    #[test]
    fn peak_follows_wien() {
        for kelvin in [1.0, 300.0, 2856.0, 5772.0, 1e6] {
            let body = Blackbody::new(kelvin).unwrap();
            let peak = body.peak();
            assert!((peak * kelvin / 2.897_771_955e6 - 1.0).abs() < 1e-9);
            assert!(body.at(peak) > body.at(peak * 1.001) && body.at(peak) > body.at(peak * 0.999));
        }
    }

    /// Rayleigh–Jeans: for long waves `L = 2 c k T / λ⁴ (1 − x/2 + x²/12)`, to rounding.
    #[test]
    fn long_waves_follow_rayleigh_jeans() {
        for (nm, kelvin) in [(1e9, 1e6), (1e6, 1e6), (830.0, 1e12)] {
            let x: f64 = SECOND / (nm * kelvin);
            let classical = 2.0 * SPEED_OF_LIGHT * BOLTZMANN * kelvin * 1e27 / f64::powi(nm, 4);
            let expected = classical * (1.0 - x / 2.0 + x * x / 12.0);
            let found = blackbody_radiance(nm, kelvin);
            assert!((found / expected - 1.0).abs() < 1e-12, "{nm} nm, {kelvin} K: {found}, {expected}");
        }
    }

    #[test]
    fn no_temperature_gives_a_bad_number() {
        for exponent in -30..=60 {
            let kelvin = 10f64.powf(f64::from(exponent) / 10.0);
            for nm in [1e-3, 1.0, 360.0, 555.0, 830.0, 1e9] {
                let value = blackbody_radiance(nm, kelvin);
                assert!(value.is_finite() && value >= 0.0, "{nm} nm, {kelvin} K: {value}");
            }
        }
        assert_eq!(blackbody_radiance(555.0, 0.0), 0.0);
        assert!(matches!(Blackbody::new(-1.0), Err(SpectrumError::BadTemperature { .. })));
        assert!(matches!(Blackbody::new(f64::NAN), Err(SpectrumError::BadTemperature { .. })));
    }

    /// The radiance of the sun's effective temperature at 500 nm, worked out with 50 digits.
    #[test]
    fn unit_is_per_nanometre() {
        let found = blackbody_radiance(500.0, 5772.0);
        assert!((found / 26238.540568595831 - 1.0).abs() < 1e-13, "{found}");
    }
}
