//! Mean and variance of a stream of numbers.

/// Running mean and variance (Welford 1962), mergeable (Chan, Golub and LeVeque 1979).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    count: u64,
    mean: f64,
    /// Sum of squared deviations from the mean.
    deviations: f64,
}

impl Moments {
    /// Adds a value.
    pub fn push(&mut self, value: f64) {
        self.count += 1;
        let before = value - self.mean;
        self.mean += before / self.count as f64;
        self.deviations += before * (value - self.mean);
    }

    /// The moments of both streams together.
    pub fn merged(self, other: Self) -> Self {
        if self.count == 0 || other.count == 0 {
            return if self.count == 0 { other } else { self };
        }
        let count = self.count + other.count;
        let (own, others) = (self.count as f64, other.count as f64);
        let apart = other.mean - self.mean;
        let fraction = others / count as f64;
        Self {
            count,
            mean: self.mean + apart * fraction,
            deviations: self.deviations + other.deviations + apart * apart * own * fraction,
        }
    }

    /// Number of values.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// 0 for an empty stream.
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// Unbiased variance of the values; 0 for fewer than two.
    pub fn variance(&self) -> f64 {
        if self.count < 2 { 0.0 } else { self.deviations / (self.count - 1) as f64 }
    }

    /// The mean with its standard error, for independent values.
    pub fn estimate(&self) -> Estimate {
        Estimate {
            mean: self.mean,
            variance: self.variance() / self.count.max(1) as f64,
            degrees: self.count.saturating_sub(1) as f64,
        }
    }
}

impl FromIterator<f64> for Moments {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        let mut moments = Self::default();
        for value in values {
            moments.push(value);
        }
        moments
    }
}

/// A mean and how well it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// Variance of the mean, not of the values it was made from.
    pub variance: f64,
    /// Degrees of freedom of `variance`; infinite where it is known exactly.
    pub degrees: f64,
}

impl Estimate {
    /// A number known exactly.
    pub fn exact(mean: f64) -> Self {
        Self { mean, variance: 0.0, degrees: f64::INFINITY }
    }

    /// The mean of independent estimates, with the degrees of freedom of Welch and Satterthwaite. `None` of
    /// none.
    pub fn mean_of(estimates: impl IntoIterator<Item = Self>) -> Option<Self> {
        let (mut count, mut mean, mut variance, mut part) = (0.0, 0.0, 0.0, 0.0);
        for estimate in estimates {
            count += 1.0;
            mean += estimate.mean;
            variance += estimate.variance;
            part += estimate.variance * estimate.variance / estimate.degrees;
        }
        let degrees = if part > 0.0 { variance * variance / part } else { f64::INFINITY };
        (count > 0.0).then(|| Self { mean: mean / count, variance: variance / (count * count), degrees })
    }

    /// Standard error of the mean.
    pub fn error(&self) -> f64 {
        self.variance.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_those_of_the_definition() {
        let values = [2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0];
        let moments: Moments = values.into_iter().collect();
        assert_eq!(moments.count(), 8);
        assert!((moments.mean() - 5.0).abs() < 1e-15);
        // Σ(x − 5)² = 32.
        assert!((moments.variance() - 32.0 / 7.0).abs() < 1e-14);
        assert!((moments.estimate().variance - 4.0 / 7.0).abs() < 1e-14);
    }

    #[test]
    fn a_large_offset_does_not_cancel() {
        let moments: Moments = (0..1000).map(|i| 1e9 + f64::from(i % 2)).collect();
        assert!((moments.variance() - 0.25 * 1000.0 / 999.0).abs() < 1e-6);
    }

    #[test]
    fn merging_equals_pushing() {
        let value = |i: i32| f64::from(i * i % 97);
        let whole: Moments = (0..100).map(value).collect();
        for split in [0, 1, 37, 99, 100] {
            let left: Moments = (0..split).map(value).collect();
            let right: Moments = (split..100).map(value).collect();
            let merged = left.merged(right);
            assert_eq!(merged.count(), whole.count());
            assert!((merged.mean() - whole.mean()).abs() < 1e-12);
            assert!((merged.variance() - whole.variance()).abs() < 1e-10 * whole.variance());
        }
    }
}
