//! Whether counts follow their expectation, and p-values their uniform law.

use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::fmt;

/// Cells with a smaller expected count are pooled: below it the statistic isn't chi-square
/// distributed (Cochran 1954).
const MIN_EXPECTED: f64 = 5.0;

/// Result of Pearson's chi-square test of goodness of fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChiSquare {
    /// The statistic χ².
    pub statistic: f64,
    /// Degrees of freedom.
    pub degrees: usize,
    /// How likely a fit this bad or worse is if the counts do follow the expectation.
    pub p_value: f64,
    /// How many cells were pooled because too little was expected in them.
    pub pooled: usize,
    /// Observed and expected count of the cell that fits worst.
    pub worst: (f64, f64),
}

/// Pearson's chi-square test of `observed` counts against `expected` ones, cell by cell.
///
/// Cells are pooled from the least expected up until each pool holds at least 5 expected counts.
/// The expected counts should sum to the number of observations: give what escaped the cells a cell
/// of its own. Counts where none can be (a pool that expects less than 1e-6 in all) give p = 0, and
/// so does an expectation that isn't finite or is negative. With a single cell left there is nothing
/// to judge and p = 1.
pub fn chi_square(observed: &[f64], expected: &[f64]) -> ChiSquare {
    let mut cells: Vec<(f64, f64)> = observed.iter().copied().zip(expected.iter().copied()).collect();
    let refused = ChiSquare {
        statistic: f64::INFINITY,
        degrees: 0,
        p_value: 0.0,
        pooled: 0,
        worst: (f64::NAN, f64::NAN),
    };
    if observed.len() != expected.len() || cells.iter().any(|cell| !(cell.1 >= 0.0 && cell.1.is_finite())) {
        return refused;
    }
    cells.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut pools: Vec<(f64, f64)> = Vec::new();
    let (mut pool, mut members, mut pooled) = ((0.0, 0.0), 0, 0);
    for (observed, expected) in cells {
        pool = (pool.0 + observed, pool.1 + expected);
        members += 1;
        if pool.1 >= MIN_EXPECTED {
            pooled += if members > 1 { members } else { 0 };
            pools.push(pool);
            (pool, members) = ((0.0, 0.0), 0);
        }
    }
    if members > 0 {
        // Every cell expects less than 5, and the last ones together too.
        pooled += members;
        let last = pools.pop().unwrap_or_default();
        pools.push((last.0 + pool.0, last.1 + pool.1));
    }
    let mut result = ChiSquare { degrees: pools.len().saturating_sub(1), pooled, ..refused };
    let mut worst_term = -1.0;
    result.statistic = 0.0;
    for (observed, expected) in pools {
        if expected < 1e-6 && observed > 0.0 {
            return ChiSquare { worst: (observed, expected), ..refused };
        }
        let difference = observed - expected;
        let term = if expected > 0.0 { difference * difference / expected } else { 0.0 };
        result.statistic += term;
        if term > worst_term {
            (worst_term, result.worst) = (term, (observed, expected));
        }
    }
    result.p_value = match ChiSquared::new(result.degrees as f64) {
        Ok(distribution) => distribution.sf(result.statistic),
        Err(_) => 1.0,
    };
    result
}

impl fmt::Display for ChiSquare {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "chi² = {:.1}, {} degrees of freedom, {} cells pooled, p = {:.3e}; worst cell: {} observed, {:.1} expected",
            self.statistic, self.degrees, self.pooled, self.p_value, self.worst.0, self.worst.1
        )
    }
}

/// The level at which to judge each of `tests` independent tests so that, with nothing wrong, any of
/// them fails with probability `level` (Šidák 1967).
pub fn sidak(level: f64, tests: usize) -> f64 {
    -f64::exp_m1(f64::ln_1p(-level) / tests.max(1) as f64)
}

/// How likely a p-value as small as `smallest` is among `tests` independent tests with nothing wrong: the
/// inverse of [`sidak`].
pub fn sidak_corrected(smallest: f64, tests: usize) -> f64 {
    -f64::exp_m1(tests.max(1) as f64 * f64::ln_1p(-smallest))
}

/// Result of a Kolmogorov–Smirnov test against the uniform distribution on [0, 1].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uniformity {
    /// Largest distance between the empirical distribution function and the diagonal.
    pub distance: f64,
    /// Probability of a distance at least as large if the values are uniform.
    pub p_value: f64,
}

/// Whether `values` (p-values of many tests, usually) are uniform on [0, 1].
///
/// Kolmogorov–Smirnov with Stephens' correction for finite counts (1970), good to about 1e-3 in p
/// from 5 values on. Values outside [0, 1] or NaN give p = 0, no values p = 1.
pub fn uniformity(values: &[f64]) -> Uniformity {
    if values.is_empty() {
        return Uniformity { distance: 0.0, p_value: 1.0 };
    }
    if values.iter().any(|value| !(0.0..=1.0).contains(value)) {
        return Uniformity { distance: 1.0, p_value: 0.0 };
    }
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let count = sorted.len() as f64;
    let distance = sorted.iter().enumerate().fold(0.0, |distance: f64, (i, value)| {
        distance.max((i + 1) as f64 / count - value).max(value - i as f64 / count)
    });
    let root = count.sqrt();
    Uniformity { distance, p_value: kolmogorov_tail((root + 0.12 + 0.11 / root) * distance) }
}

impl fmt::Display for Uniformity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "KS distance {:.4}, p = {:.3e}", self.distance, self.p_value)
    }
}

/// `Q(x) = 2 Σ (−1)^(j−1) exp(−2 j² x²)`, the limit law of the Kolmogorov–Smirnov statistic.
fn kolmogorov_tail(x: f64) -> f64 {
    // Below this Q is 1 to 15 digits and the alternating sum converges slowly.
    if x < 0.2 {
        return 1.0;
    }
    let sum: f64 = (1..=40)
        .map(|j| {
            let term = (-2.0 * f64::from(j * j) * x * x).exp();
            if j % 2 == 1 { term } else { -term }
        })
        .sum();
    (2.0 * sum).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// χ² of a die: closed form Σ (o − e)²/e, p by `scipy.stats.chisquare`.
    #[test]
    fn a_die_agrees_with_scipy() {
        let fit = chi_square(&[16.0, 18.0, 16.0, 14.0, 12.0, 12.0], &[88.0 / 6.0; 6]);
        assert!((fit.statistic - 2.0).abs() < 1e-12, "{fit}");
        assert_eq!((fit.degrees, fit.pooled), (5, 0));
        assert!((fit.p_value - 0.849_145_036_084_609_4).abs() < 1e-10, "{fit}");
    }

    #[test]
    fn small_cells_are_pooled() {
        let fit = chi_square(&[1.0, 3.0, 2.0, 50.0, 44.0], &[2.0, 2.0, 2.0, 47.0, 47.0]);
        assert_eq!((fit.degrees, fit.pooled), (2, 3));
        assert!(fit.p_value > 0.5);
    }

    #[test]
    fn the_impossible_is_refused() {
        assert_eq!(chi_square(&[0.0, 1.0], &[f64::NAN, 1.0]).p_value, 0.0);
        assert_eq!(chi_square(&[3.0], &[0.0]).p_value, 0.0);
        assert_eq!(
            chi_square(&[100.0, 100.0, 60.0], &[100.0, 100.0, 0.0]).p_value,
            chi_square(&[160.0, 100.0], &[100.0, 100.0]).p_value
        );
        assert!(chi_square(&[100.0, 100.0, 60.0], &[100.0, 100.0, 0.0]).p_value < 1e-6);
    }

    #[test]
    fn sidak_and_back() {
        for (level, tests) in [(0.01, 1), (0.05, 4096), (1e-9, 100)] {
            let back = sidak_corrected(sidak(level, tests), tests);
            assert!((back / level - 1.0).abs() < 1e-9, "{back}, expected {level}");
        }
        assert_eq!((sidak_corrected(0.0, 9), sidak_corrected(1.0, 9)), (0.0, 1.0));
    }

    #[test]
    fn sidak_closed_form() {
        assert!((sidak(0.05, 1) - 0.05).abs() < 1e-16);
        assert!((1.0 - (1.0 - sidak(0.01, 50)).powi(50) - 0.01).abs() < 1e-14);
    }

    /// Kolmogorov's tail at tabulated critical values, and samples that are and are not uniform.
    #[test]
    fn kolmogorov_smirnov() {
        assert!((kolmogorov_tail(1.358_098_8) - 0.05).abs() < 1e-6);
        assert!((kolmogorov_tail(1.627_623_6) - 0.01).abs() < 1e-6);
        let golden = |i: i32| (f64::from(i) * 0.618_033_988_749_894_9).fract();
        let even: Vec<f64> = (1..=200).map(golden).collect();
        assert!(uniformity(&even).p_value > 0.99);
        let squared: Vec<f64> = even.iter().map(|u| u * u).collect();
        assert!(uniformity(&squared).p_value < 1e-6);
        assert_eq!(uniformity(&[0.5, f64::NAN]).p_value, 0.0);
    }
}
