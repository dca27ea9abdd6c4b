//! The discrete Fourier transform.

use rustfft::algorithm::{BluesteinsAlgorithm, Radix4};
use rustfft::{Fft, FftDirection};
use std::sync::Arc;

/// A transform of so many numbers, without a factor: of each such stretch of a slice. A length that is no
/// power of two takes Bluestein's algorithm.
///
/// The planner of rustfft has algorithms for many more lengths. It is faster, and 3 % of the code that is
/// compiled with abbe.
pub fn fourier(length: usize, direction: FftDirection) -> Arc<dyn Fft<f64>> {
    if length.is_power_of_two() {
        return Arc::new(Radix4::new(length, direction));
    }
    let inner = (2 * length).next_power_of_two();
    Arc::new(BluesteinsAlgorithm::new(length, Arc::new(Radix4::new(inner, direction))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustfft::num_complex::Complex64;
    use std::f64::consts::TAU;

    #[test]
    fn transforms_are_the_sums_that_define_them() {
        for length in [1, 2, 3, 5, 8, 31, 48, 64, 100] {
            for (direction, sign) in [(FftDirection::Forward, -1.0), (FftDirection::Inverse, 1.0)] {
                let given = (0..2 * length).map(|i| Complex64::new((i * i % 7) as f64, (i * 5 % 11) as f64));
                let given: Vec<Complex64> = given.collect();
                let mut found = given.clone();
                fourier(length, direction).process(&mut found);
                for (stretch, found) in given.chunks(length).zip(found.chunks(length)) {
                    for (k, found) in found.iter().enumerate() {
                        let turn = |n: usize| sign * TAU * (k * n % length) as f64 / length as f64;
                        let terms = stretch.iter().enumerate().map(|(n, &x)| x * Complex64::cis(turn(n)));
                        let expected: Complex64 = terms.sum();
                        assert!((found - expected).norm() < 1e-11, "{length}, {k}: {found}, {expected}");
                    }
                }
            }
        }
    }
}
