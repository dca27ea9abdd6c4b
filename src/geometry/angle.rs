//! Angles and their sines. The same on every machine, which the functions of the system's library are not,
//! and in about a third of their time: nothing is asked here of angles of many turns, nor the last bit.

use crate::lanes::Real;
use std::f64::consts::{FRAC_2_PI, FRAC_PI_2, FRAC_PI_4, PI};

/// Sine and cosine of x·π/4 for |x| ≤ 1, by their Taylor series: within 2e-15.
#[inline(always)]
pub fn sin_cos_of_eighth<R: Real>(x: R) -> (R, R) {
    series(R::of(FRAC_PI_4) * x)
}

/// Sine and cosine of an angle (radians) of up to a thousand turns: within 2e-15 and the rounding of the
/// angle.
#[inline(always)]
pub fn sin_cos<R: Real>(angle: R) -> (R, R) {
    /// What π/2 is beyond its `f64`.
    const REST: f64 = 6.123_233_995_736_766e-17;
    let quarters = (angle * R::of(FRAC_2_PI)).round_ties_even();
    let (sin, cos) = series((angle - quarters * R::of(FRAC_PI_2)) - quarters * R::of(REST));
    // The half of an odd number is rounded to an even one, which is not that half.
    let is_odd = |n: R| !((n * R::of(0.5)).round_ties_even() * R::of(2.0)).eq(n);
    let odd = is_odd(quarters);
    let below = R::choose(odd, quarters - R::of(1.0), quarters);
    let (sin, cos) = (R::choose(odd, cos, sin), R::choose(odd, -sin, cos));
    let turned = is_odd(below * R::of(0.5));
    (R::choose(turned, -sin, sin), R::choose(turned, -cos, cos))
}

/// Sine and cosine of an angle up to π/4, and a little beyond.
#[inline(always)]
fn series<R: Real>(angle: R) -> (R, R) {
    let t = angle * angle;
    // 1/n! with alternating signs, from the highest power down.
    let sin = polynomial(
        t,
        [
            -1.0 / 1_307_674_368_000.0,
            1.0 / 6_227_020_800.0,
            -1.0 / 39_916_800.0,
            1.0 / 362_880.0,
            -1.0 / 5040.0,
            1.0 / 120.0,
            -1.0 / 6.0,
            1.0,
        ],
    );
    let cos = polynomial(
        t,
        [
            -1.0 / 87_178_291_200.0,
            1.0 / 479_001_600.0,
            -1.0 / 3_628_800.0,
            1.0 / 40_320.0,
            -1.0 / 720.0,
            1.0 / 24.0,
            -1.0 / 2.0,
            1.0,
        ],
    );
    (angle * sin, cos)
}

/// The polynomial in `x` with these coefficients, that of the highest power first (Horner).
#[inline(always)]
fn polynomial<R: Real, const N: usize>(x: R, coefficients: [f64; N]) -> R {
    let mut sum = R::of(coefficients[0]);
    for &coefficient in &coefficients[1..] {
        sum = sum * x + R::of(coefficient);
    }
    sum
}

/// The angle from +x to (x, y), radians from -π to π; 0 for (0, 0). Within 4e-16 of its size.
///
/// Arcus tangens up to π/8 by the polynomial in t² that errs least there (Chebyshev's interpolation, 3e-17 of
/// t³); beyond by that of π/4 less an angle.
#[inline(always)]
pub fn atan2<R: Real>(y: R, x: R) -> R {
    const TAN_EIGHTH: f64 = 0.414_213_562_373_095_05;
    const COEFFICIENTS: [f64; 11] = [
        -0.019_176_887_119_062_26,
        0.039_231_658_295_587_19,
        -0.050_854_497_379_402_6,
        0.058_581_489_128_022_1,
        -0.066_645_114_473_819_48,
        0.076_921_831_908_260_87,
        -0.090_909_045_781_239_03,
        0.111_111_110_152_563_61,
        -0.142_857_142_846_665_42,
        0.199_999_999_999_955_2,
        -0.333_333_333_333_333_3,
    ];
    let zero = R::of(0.0);
    let (wide, high) = (x.abs(), y.abs());
    let is_high = high.gt(wide);
    let (large, small) = (R::choose(is_high, high, wide), R::choose(is_high, wide, high));
    let steep = small.gt(R::of(TAN_EIGHTH) * large);
    let above = R::choose(steep, small - large, small);
    let below = R::choose(steep, small + large, large);
    let t = above / below;
    let square = t * t;
    let angle = t + t * square * polynomial(square, COEFFICIENTS);
    let angle = R::choose(steep, angle + R::of(FRAC_PI_4), angle);
    let angle = R::choose(is_high, R::of(FRAC_PI_2) - angle, angle);
    let angle = R::choose(x.lt(zero), R::of(PI) - angle, angle);
    R::choose(large.eq(zero), zero, angle.copysign(y))
}

/// Arcus cosine of a number from -1 to 1, radians; what rounding led beyond counts as the end.
#[inline(always)]
pub fn acos<R: Real>(x: R) -> R {
    let one = R::of(1.0);
    atan2(((one - x) * (one + x)).greater(R::of(0.0)).sqrt(), x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_are_those_of_the_library() {
        for i in -1000..=1000 {
            let x = f64::from(i) / 1000.0;
            let (sin, cos) = sin_cos_of_eighth(x);
            let (expected_sin, expected_cos) = (FRAC_PI_4 * x).sin_cos();
            assert!((sin - expected_sin).abs() < 4e-16, "{x}: {sin} {expected_sin}");
            assert!((cos - expected_cos).abs() < 4e-15, "{x}: {cos} {expected_cos}");
        }
        for i in -100_000..=100_000 {
            let angle = f64::from(i) * 1e-2;
            let ((sin, cos), (expected_sin, expected_cos)) = (sin_cos(angle), angle.sin_cos());
            let reserve = 4e-15 + f64::EPSILON * angle.abs();
            let off = (sin - expected_sin).abs().max((cos - expected_cos).abs());
            assert!(off < reserve, "{angle}: {sin} {cos}, not {expected_sin} {expected_cos}");
        }
    }

    #[test]
    fn angles_are_those_of_the_library() {
        let ends = [0.0, -0.0, 1.0, -1.0, 1e-300, -1e-300, 1e300, FRAC_PI_4.tan(), 0.5 * FRAC_PI_4.tan()];
        let ends = ends.into_iter().flat_map(|y| ends.map(|x| (y, x)));
        let turned = (0..100_000).map(|i| {
            let (sin, cos) = (f64::from(i) * 1e-4).sin_cos();
            // Sine and cosine of all sizes.
            let squeeze = 10f64.powi(i % 40 - 20);
            (sin * squeeze, cos)
        });
        for (y, x) in ends.chain(turned) {
            let (angle, expected) = (atan2(y, x), y.atan2(x));
            if (y, x) == (0.0, 0.0) {
                assert_eq!(angle, 0.0);
                continue;
            }
            assert!((angle - expected).abs() <= 4e-16 * expected.abs(), "{y} {x}: {angle} {expected}");
            assert_eq!(angle.is_sign_negative(), expected.is_sign_negative(), "{y} {x}");
        }
        for i in -1000..=1000 {
            let x = f64::from(i) / 1000.0;
            assert!((acos(x) - x.acos()).abs() < 1e-15, "{x}");
        }
        assert_eq!((acos(1.0 + 1e-15), acos(-1.0 - 1e-15)), (0.0, PI));
    }
}
