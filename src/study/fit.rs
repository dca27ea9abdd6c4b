//! Power laws fitted to errors that are known with an error.

use crate::stats::{Estimate, student_quantile};
use serde::Serialize;

/// A point of an error curve: at `x` (samples or seconds, above 0) the relMSE.
#[derive(Clone, Copy, Debug)]
pub struct Measurement {
    /// Samples or seconds.
    pub x: f64,
    /// The relMSE, with the variance of its mean.
    pub relmse: Estimate,
}

/// The line log RMSE = level + slope·log x, with what is needed for its intervals.
///
/// Least squares on logarithms: the variance of log RMSE = ½ log relMSE is, to first order, (σ/relMSE)²/4
/// with the standard error σ of the mean over replicates. The logarithm of a mean is too low on average, by
/// (σ/relMSE)²/2 to second order. That is added, and is most where samples are few. No mean of values of at
/// least 0 has σ/relMSE above 1. All points weigh the same, by the mean of their variances: noise is skewed,
/// so that a point which is too low by chance claims too small an error, and would weigh too much. Intervals
/// use Student's t with as many degrees as all the replicates have. Where the points scatter about the line
/// by more than that, as they do about every curve that is not quite a power law, the errors of the fit are
/// enlarged by √(χ²/(n−2)) (Birge 1932), with n − 2 degrees. Where a point has no error, the scatter alone
/// tells it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PowerLaw {
    /// Exponent of the power law: −½ for independent samples.
    pub slope: f64,
    /// Half of the 95 % confidence interval of the slope.
    pub slope_half_width: f64,
    /// Log RMSE in the middle of the points, and where that is.
    level: f64,
    centre: f64,
    /// Half of the 95 % confidence interval of `level`.
    level_half_width: f64,
    /// χ² over its degrees of freedom: about 1 for a true power law.
    pub reduced_chi_square: f64,
    /// Points that the line is fitted to, at least 3.
    pub points: usize,
}

/// Half of a 95 % interval, in standard errors.
pub fn student_95(degrees: f64) -> f64 {
    student_quantile(0.975, degrees)
}

impl PowerLaw {
    /// `None` for fewer than three points whose error can be told from 0.
    pub fn fit(points: &[Measurement]) -> Option<Self> {
        let usable = |p: &&Measurement| p.x > 0.0 && p.relmse.mean > 0.0 && p.relmse.mean.is_finite();
        let points: Vec<&Measurement> = points.iter().filter(usable).collect();
        if points.len() < 3 {
            return None;
        }
        let known = points.iter().all(|p| p.relmse.variance > 0.0);
        let relative = |p: &&Measurement| p.relmse.variance / (p.relmse.mean * p.relmse.mean);
        let pooled = points.iter().map(relative).sum::<f64>() / points.len() as f64;
        let weight = if known { 4.0 / pooled } else { 1.0 };
        let x = |p: &Measurement| p.x.ln();
        let y = |p: &Measurement| 0.5 * (p.relmse.mean.ln() + 0.5 * relative(&p).min(1.0));
        let sum =
            |value: &dyn Fn(&Measurement) -> f64| points.iter().map(|&p| weight * value(p)).sum::<f64>();
        let total = sum(&|_| 1.0);
        let (centre, level) = (sum(&x) / total, sum(&y) / total);
        let spread = sum(&|p| (x(p) - centre).powi(2));
        if spread <= 0.0 {
            return None;
        }
        let slope = sum(&|p| (x(p) - centre) * (y(p) - level)) / spread;
        let chi_square = sum(&|p| (y(p) - level - slope * (x(p) - centre)).powi(2));
        let free = (points.len() - 2) as f64;
        let scatter = chi_square / free;
        let (enlarged, degrees) = match known && scatter <= 1.0 {
            true => (1.0, points.iter().map(|p| p.relmse.degrees).sum()),
            false => (scatter, free),
        };
        let t = student_95(degrees);
        Some(Self {
            slope,
            slope_half_width: t * (enlarged / spread).sqrt(),
            level,
            centre,
            level_half_width: t * (enlarged / total).sqrt(),
            reduced_chi_square: scatter,
            points: points.len(),
        })
    }

    /// RMSE on the line.
    pub fn at(&self, x: f64) -> f64 {
        (self.level + self.slope * (x.ln() - self.centre)).exp()
    }

    /// Where the line reaches an RMSE: the place, and the factor that its 95 % interval reaches up and down
    /// from it (to first order). `None` where the slope cannot be told from 0 or rises.
    pub fn reaches(&self, rmse: f64) -> Option<(f64, f64)> {
        if self.slope + self.slope_half_width >= 0.0 {
            return None;
        }
        let distance = (rmse.ln() - self.level) / self.slope;
        let half_width = self.level_half_width.hypot(distance * self.slope_half_width) / self.slope.abs();
        Some(((self.centre + distance).exp(), half_width.exp()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::mix;
    use crate::stats::Moments;

    fn measurement(x: f64, mean: f64, relative_error: f64) -> Measurement {
        Measurement { x, relmse: Estimate { mean, variance: (relative_error * mean).powi(2), degrees: 15.0 } }
    }

    #[test]
    fn an_exact_power_law_is_found() {
        let points: Vec<Measurement> =
            (0..6).map(|i| 4f64.powi(i)).map(|n| measurement(n, 0.3 * n.powf(-1.5), 0.05)).collect();
        let law = PowerLaw::fit(&points).expect("there are enough points");
        assert!((law.slope + 0.75).abs() < 1e-12 && law.reduced_chi_square < 1e-20, "{law:?}");
        // Errors of 5 % make the logarithm of a mean too low by 0.05²/2.
        let expected = (0.3f64 * 16f64.powf(-1.5) * (0.5f64 * 0.05 * 0.05).exp()).sqrt();
        assert!((law.at(16.0) - expected).abs() < 1e-12);
        let (place, factor) = law.reaches(law.at(100.0)).expect("it falls");
        assert!((place - 100.0).abs() < 1e-9 && factor > 1.0 && factor < 1.2, "{place} {factor}");
        assert!(PowerLaw::fit(&points[..2]).is_none());
    }

    /// 95 % of many studies with known noise have the true slope in their interval.
    #[test]
    fn intervals_hold_what_they_promise() {
        let (studies, mut covered) = (2000u64, 0);
        for study in 0..studies {
            let points: Vec<Measurement> = (0..5u64)
                .map(|i| {
                    // About normal: the sum of twelve uniform numbers.
                    let uniform = |k| mix(mix(study * 5 + i) ^ k) as f64 / u64::MAX as f64;
                    let normal = (0..12).map(uniform).sum::<f64>() - 6.0;
                    let n = 4f64.powi(i as i32);
                    let (mean, relative) = (n.recip(), 0.04);
                    let found = mean * (1.0 + relative * normal);
                    Measurement {
                        x: n,
                        relmse: Estimate { mean: found, variance: (relative * mean).powi(2), degrees: 200.0 },
                    }
                })
                .collect();
            let law = PowerLaw::fit(&points).expect("there are enough points");
            covered += u64::from((law.slope + 0.5).abs() < law.slope_half_width);
        }
        // Enlarging by the scatter covers a little more than 95 %: of the binomial 95 %, three standard
        // errors are 1.5 %.
        let fraction = covered as f64 / studies as f64;
        assert!((0.935..0.99).contains(&fraction), "{fraction}");
    }

    /// The same where eight skewed replicates tell each point and its error: exponential noise, the more of
    /// it averaged the more samples there are. Points weighed by their own errors would cover 92 %.
    #[test]
    fn intervals_hold_where_errors_are_estimated() {
        let (studies, mut covered) = (2000u64, 0);
        for study in 0..studies {
            let mut counter = study << 32;
            let mut exponential = || {
                counter += 1;
                -((mix(counter) >> 11) as f64 + 1.0).ln() + 53.0 * 2f64.ln()
            };
            let points: Vec<Measurement> = (0..7u32)
                .map(|i| {
                    let n = 2u32.pow(i);
                    let averaged = n.clamp(2, 16);
                    let mut replicate = || {
                        let sum: f64 = (0..averaged).map(|_| exponential()).sum();
                        sum / f64::from(averaged) / f64::from(n)
                    };
                    let found: Moments = (0..8).map(|_| replicate()).collect();
                    Measurement { x: f64::from(n), relmse: found.estimate() }
                })
                .collect();
            let law = PowerLaw::fit(&points).expect("there are enough points");
            covered += u64::from((law.slope + 0.5).abs() < law.slope_half_width);
        }
        let fraction = covered as f64 / studies as f64;
        assert!((0.94..0.985).contains(&fraction), "{fraction}");
    }

    /// The mean of many slopes is the true one, where four replicates with exponential noise tell each point
    /// and more samples average it. The bare logarithms of their means fall as n^−0.485.
    #[test]
    fn slopes_of_few_replicates_are_right_on_average() {
        let slopes: Moments = (0..4000u64)
            .map(|study| {
                let mut counter = study << 32;
                let mut exponential = || {
                    counter += 1;
                    -((mix(counter) >> 11) as f64 + 1.0).ln() + 53.0 * 2f64.ln()
                };
                let mut replicate = |n: u32| {
                    let sum: f64 = (0..n).map(|_| exponential()).sum();
                    sum / f64::from(n).powi(2)
                };
                let points: Vec<Measurement> = (0..4u32)
                    .map(|i| {
                        let n = 4u32.pow(i);
                        let found: Moments = (0..4).map(|_| replicate(n)).collect();
                        Measurement { x: f64::from(n), relmse: found.estimate() }
                    })
                    .collect();
                PowerLaw::fit(&points).expect("there are enough points").slope
            })
            .collect();
        assert!((slopes.mean() + 0.5).abs() < 0.005, "{} ± {}", slopes.mean(), slopes.estimate().error());
    }

    #[test]
    fn without_errors_the_scatter_tells() {
        let points: Vec<Measurement> = [(1.0, 1.0), (4.0, 0.3), (16.0, 0.05), (64.0, 0.02)]
            .map(|(x, y)| measurement(x, y, 0.0))
            .to_vec();
        let law = PowerLaw::fit(&points).expect("there are enough points");
        assert!(law.slope_half_width > 0.05 && law.slope_half_width < 0.5, "{law:?}");
    }

    #[test]
    fn student_quantiles_are_those_of_tables() {
        assert!((student_95(10.0) - 2.228).abs() < 1e-3 && (student_95(1.0) - 12.706).abs() < 1e-3);
    }
}
