//! Bounds on the derivatives of F (see [`super::intersection`]) over a part, and what they say of its curve.

use super::bicubic::Bicubic;
use super::intersection::NOISE;
use crate::geometry::bernstein::Range;
use glam::DVec2;

/// How y varies along the curve.
#[derive(Clone, Copy, PartialEq)]
pub enum Monotonicity {
    Monotonic,
    /// It has one extreme at most.
    Bent,
    /// All that is known is how much the determinant changes from the middle to an end.
    Steady(f64),
}

/// Coordinates along an axis of the plane and across it, over a part; the first index goes along p, the
/// second along q.
pub struct Turned {
    pub x: Bicubic<f64>,
    pub y: Bicubic<f64>,
}

impl Turned {
    pub fn of(bicubic: &Bicubic<DVec2>, axis: DVec2, along: usize) -> Self {
        let turned =
            Self { x: bicubic.map(|point| axis.dot(point)), y: bicubic.map(|point| axis.perp_dot(point)) };
        if along == 1 { turned } else { Self { x: turned.x.transposed(), y: turned.y.transposed() } }
    }

    /// With the greatest slope of the curve; `None` where the bounds are too wide to tell.
    pub fn monotonicity(&self) -> Option<(Monotonicity, f64)> {
        let x = Slopes::of(&self.x);
        if x.q.0 <= 0.0 {
            return None;
        }
        let steepest = x.p.0.abs().max(x.p.1.abs()) / x.q.0;
        let y = Slopes::of(&self.y);
        let less = |a: Range, b: Range| a + b * -1.0;
        let determinant = less(x.p * y.q, y.p * x.q);
        if !determinant.has_zero() {
            return Some((Monotonicity::Monotonic, steepest));
        }
        let (bent_x, bent_y) = (Bends::of(&self.x), Bends::of(&self.y));
        let change_p = less(bent_x.pp * y.q + x.p * bent_y.pq, bent_y.pp * x.q + y.p * bent_x.pq);
        let change_q = less(bent_x.pq * y.q + x.p * bent_y.qq, bent_y.pq * x.q + y.p * bent_x.qq);
        let change = less(change_p * x.q, change_q * x.p);
        if !change.has_zero() {
            return Some((Monotonicity::Bent, steepest));
        }
        // Near a cusp, where three roots come together, the determinant changes much less along the curve
        // than across it.
        let most = 0.5 * change.0.abs().max(change.1.abs()) / x.q.0;
        (most < 0.1 * (determinant.1 - determinant.0)).then_some((Monotonicity::Steady(most), steepest))
    }
}

/// Bounds on a bicubic's derivatives along p and q, rounding included.
struct Slopes {
    p: Range,
    q: Range,
}

/// Likewise on the second ones.
struct Bends {
    pp: Range,
    pq: Range,
    qq: Range,
}

/// The range of all values.
pub fn range(values: impl Iterator<Item = f64>) -> Range {
    values.fold(Range(f64::INFINITY, f64::NEG_INFINITY), |Range(low, high), value| {
        Range(low.min(value), high.max(value))
    })
}

fn pairs(rows: usize, columns: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..rows).flat_map(move |i| (0..columns).map(move |j| (i, j)))
}

/// Around `factor` times differences of that many coefficients.
fn bound(factor: f64, coefficients: f64, differences: impl Iterator<Item = f64>) -> Range {
    let (differences, noise) = (range(differences), coefficients * NOISE);
    Range(factor * (differences.0 - noise), factor * (differences.1 + noise))
}

impl Slopes {
    fn of(Bicubic(c): &Bicubic<f64>) -> Self {
        Self {
            p: bound(3.0, 2.0, pairs(3, 4).map(|(i, j)| c[i + 1][j] - c[i][j])),
            q: bound(3.0, 2.0, pairs(4, 3).map(|(i, j)| c[i][j + 1] - c[i][j])),
        }
    }
}

impl Bends {
    fn of(Bicubic(c): &Bicubic<f64>) -> Self {
        let second = |a: f64, b: f64, c: f64| (c - b) - (b - a);
        let mixed = |i: usize, j: usize| (c[i + 1][j + 1] - c[i + 1][j]) - (c[i][j + 1] - c[i][j]);
        Self {
            pp: bound(6.0, 4.0, pairs(2, 4).map(|(i, j)| second(c[i][j], c[i + 1][j], c[i + 2][j]))),
            pq: bound(9.0, 4.0, pairs(3, 3).map(|(i, j)| mixed(i, j))),
            qq: bound(6.0, 4.0, pairs(4, 2).map(|(i, j)| second(c[i][j], c[i][j + 1], c[i][j + 2]))),
        }
    }
}
