//! Whether two estimated means differ.

use super::Estimate;
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};
use std::fmt;

/// Result of Welch's t-test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Welch {
    /// Difference of the means over its standard error.
    pub t: f64,
    /// Degrees of freedom (Welch and Satterthwaite).
    pub degrees: f64,
    /// Two-sided: how likely a difference this large is if the means are equal.
    pub p_value: f64,
}

/// Welch's t-test of two independent means with unequal variances (Welch 1947).
///
/// Means known exactly (variance 0) are equal (p = 1) or not (p = 0).
/// A NaN or infinite estimate gives p = 0: such a result agrees with nothing.
pub fn welch(a: &Estimate, b: &Estimate) -> Welch {
    let variance = a.variance + b.variance;
    if variance == 0.0 {
        let (t, p_value) = if a.mean == b.mean { (0.0, 1.0) } else { (f64::INFINITY, 0.0) };
        return Welch { t: t * (a.mean - b.mean).signum(), degrees: f64::INFINITY, p_value };
    }
    let t = (a.mean - b.mean) / variance.sqrt();
    let part = |e: &Estimate| if e.variance > 0.0 { e.variance * e.variance / e.degrees } else { 0.0 };
    let degrees = variance * variance / (part(a) + part(b));
    Welch { t, degrees, p_value: two_sided(t, degrees) }
}

fn two_sided(t: f64, degrees: f64) -> f64 {
    if !t.is_finite() {
        return 0.0;
    }
    // Beyond a million degrees Student's distribution is the normal one to all digits that matter.
    let tail = if degrees >= 1e6 {
        Normal::standard().sf(t.abs())
    } else {
        StudentsT::new(0.0, 1.0, degrees).map_or(f64::NAN, |distribution| distribution.sf(t.abs()))
    };
    if tail.is_nan() { 0.0 } else { 2.0 * tail }
}

/// The value below which Student's t with `degrees` degrees of freedom stays with probability `p`.
pub fn student_quantile(p: f64, degrees: f64) -> f64 {
    if degrees >= 1e6 {
        return Normal::standard().inverse_cdf(p);
    }
    StudentsT::new(0.0, 1.0, degrees).map_or(f64::NAN, |distribution| distribution.inverse_cdf(p))
}

impl fmt::Display for Welch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "t = {:.3}, {:.1} degrees of freedom, p = {:.3e}", self.t, self.degrees, self.p_value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::Moments;

    /// Values by `scipy.stats.ttest_ind(a, b, equal_var=False)`, SciPy 1.17.1.
    #[test]
    fn agrees_with_scipy() {
        let a: Moments = [27.5, 21.0, 19.0, 23.6, 17.0, 17.9, 16.9, 20.1].into_iter().collect();
        let b: Moments = [27.1, 22.0, 20.8, 23.4, 23.4, 23.5, 25.8, 22.0, 24.8, 20.2].into_iter().collect();
        let test = welch(&a.estimate(), &b.estimate());
        assert!((test.t + 2.003_189_172_375_865_5).abs() < 1e-12, "{test}");
        assert!((test.degrees - 10.837_764_672_147_461).abs() < 1e-10, "{test}");
        assert!((test.p_value - 0.070_804_058_624_660_2).abs() < 1e-12, "{test}");
    }

    /// Values by `scipy.stats.t.ppf`, SciPy 1.17.1. The normal law of a million degrees and more is off by
    /// 1e-9 at 10⁹.
    #[test]
    fn quantiles_agree_with_scipy() {
        for (p, degrees, expected) in [
            (0.975, 3.000000e+00, 3.182446305284),
            (0.975, 7.000000e+00, 2.364624251593),
            (0.9, 1.450000e+01, 1.342738156307),
            (0.999999, 7.000000e+00, 14.241469651921),
            (0.025, 1.000000e+04, -1.960201239891),
            (0.975, 1.000000e+09, 1.959963986912),
        ] {
            let found = student_quantile(p, degrees);
            assert!((found - expected).abs() < 1e-8 * expected.abs(), "{p}, {degrees}: {found}, {expected}");
        }
    }

    #[test]
    fn exact_means_and_nan() {
        let one = Estimate::exact(1.0);
        assert_eq!(welch(&one, &one).p_value, 1.0);
        assert_eq!(welch(&one, &Estimate::exact(1.5)).p_value, 0.0);
        let noisy = Estimate { mean: 1.0, variance: 0.01, degrees: 9.0 };
        // Against an exact number it is the one-sample test with the noisy side's degrees.
        let test = welch(&noisy, &Estimate::exact(1.2));
        assert!((test.degrees - 9.0).abs() < 1e-12 && (test.t + 2.0).abs() < 1e-12);
        assert!((test.p_value - 0.076_552_823_770_701_01).abs() < 1e-10, "{test}");
        assert_eq!(welch(&noisy, &Estimate::exact(f64::NAN)).p_value, 0.0);
        assert_eq!(welch(&noisy, &Estimate::exact(f64::INFINITY)).p_value, 0.0);
        assert_eq!(
            welch(&Estimate { degrees: f64::INFINITY, ..noisy }, &Estimate::exact(f64::NAN)).p_value,
            0.0
        );
    }
}
