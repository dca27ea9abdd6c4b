//! Maps from the unit square to the domains that are sampled, each with its density.

use crate::geometry::Vec3;
use std::f64::consts::FRAC_PI_4;

/// A point of the unit disk, uniform in area, neighbours staying neighbours
/// (Shirley and Chiu, "A low distortion map between disk and square", JGT 2(3), 1997).
pub fn disk(u: [f64; 2]) -> [f64; 2] {
    let (a, b) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    if a == 0.0 && b == 0.0 {
        return [0.0, 0.0];
    }
    if a.abs() > b.abs() {
        let (sin, cos) = eighth_turn(b / a);
        [a * cos, a * sin]
    } else {
        let (sin, cos) = eighth_turn(a / b);
        [b * sin, b * cos]
    }
}

/// Sine and cosine of x·π/4 for |x| ≤ 1, by their Taylor series: within 2e-15, without the range
/// reduction that makes up most of the library's functions, and the same on every machine.
fn eighth_turn(x: f64) -> (f64, f64) {
    let angle = FRAC_PI_4 * x;
    let t = angle * angle;
    // 1/n! with alternating signs, from the highest power down.
    let series = |coefficients: [f64; 8]| coefficients.into_iter().fold(0.0, |sum, c| sum * t + c);
    let sin = series([
        -1.0 / 1_307_674_368_000.0,
        1.0 / 6_227_020_800.0,
        -1.0 / 39_916_800.0,
        1.0 / 362_880.0,
        -1.0 / 5040.0,
        1.0 / 120.0,
        -1.0 / 6.0,
        1.0,
    ]);
    let cos = series([
        -1.0 / 87_178_291_200.0,
        1.0 / 479_001_600.0,
        -1.0 / 3_628_800.0,
        1.0 / 40_320.0,
        -1.0 / 720.0,
        1.0 / 24.0,
        -1.0 / 2.0,
        1.0,
    ]);
    (angle * sin, cos)
}

/// A direction around +z with density cos θ / π per steradian.
pub fn cosine_hemisphere(u: [f64; 2]) -> Vec3 {
    let [x, y] = disk(u);
    Vec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_are_those_of_the_library() {
        for i in -1000..=1000 {
            let x = f64::from(i) / 1000.0;
            let (sin, cos) = eighth_turn(x);
            let (expected_sin, expected_cos) = (FRAC_PI_4 * x).sin_cos();
            assert!((sin - expected_sin).abs() < 4e-16, "{x}: {sin} {expected_sin}");
            assert!((cos - expected_cos).abs() < 4e-15, "{x}: {cos} {expected_cos}");
        }
    }
}
