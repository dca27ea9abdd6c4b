//! The box around a patch, which is smaller than that around its control points.

use super::bicubic::Bicubic;
use crate::geometry::{Bounds, Vec3};

/// How much larger than needed a box may be, relative to its size.
const TOLERANCE: f64 = 1e-6;

/// The box around a patch whose control points are no further than `reach` from the origin.
pub fn of(points: &Bicubic<Vec3>, reach: f64) -> Bounds {
    let mut bounds = Bounds { min: Vec3::ZERO, max: Vec3::ZERO };
    for axis in 0..3 {
        let coordinate = points.map(|point| point[axis]);
        bounds.max[axis] = greatest(coordinate, TOLERANCE * reach);
        bounds.min[axis] = -greatest(coordinate.map(|value| -value), TOLERANCE * reach);
    }
    bounds
}

/// At least the greatest value over the square, at most `tolerance` more: parts whose coefficients all are
/// below what is reached elsewhere are left.
fn greatest(bicubic: Bicubic<f64>, tolerance: f64) -> f64 {
    let corners = |Bicubic(c): &Bicubic<f64>| c[0][0].max(c[0][3]).max(c[3][0]).max(c[3][3]);
    let most = |bicubic: &Bicubic<f64>| bicubic.all().fold(f64::NEG_INFINITY, f64::max);
    let mut reached = corners(&bicubic);
    let mut waiting = vec![bicubic];
    while let Some(bicubic) = waiting.pop() {
        if most(&bicubic) <= reached + tolerance {
            continue;
        }
        let change = |bicubic: &Bicubic<f64>| {
            let steps = bicubic.0.iter().flat_map(|row| row.windows(2).map(|pair| (pair[1] - pair[0]).abs()));
            steps.fold(0.0, f64::max)
        };
        let axis = usize::from(change(&bicubic) >= change(&bicubic.transposed()));
        let halves = bicubic.halves(axis);
        reached = halves.iter().map(corners).fold(reached, f64::max);
        waiting.extend(halves);
    }
    // No less than any coefficient is needed where the patch is flat.
    reached + tolerance
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::array::from_fn;

    #[test]
    fn boxes_hold_and_are_tight() {
        let bicubic = Bicubic(from_fn(|i| {
            from_fn(|j| Vec3::new(i as f64, (5.0 * i as f64).sin(), (3.0 * j as f64 + i as f64).cos()))
        }));
        let bounds = of(&bicubic, 4.0);
        let mut seen = Bounds::EMPTY;
        for k in 0..=200 * 201 {
            seen = seen.including(bicubic.value([k % 201, k / 201].map(|k| f64::from(k) / 200.0)));
        }
        assert!((seen.min - bounds.min).min_element() > 0.0 && (bounds.max - seen.max).min_element() > 0.0);
        assert!((seen.min - bounds.min).max_element() < 1e-3 && (bounds.max - seen.max).max_element() < 1e-3);
    }
}
