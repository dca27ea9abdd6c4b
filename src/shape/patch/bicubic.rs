//! Bicubics in Bernstein form: their values never leave the hull of their coefficients.

use crate::geometry::bernstein::{Value, cubic, cubic_bend, cubic_slope, restricted};
use std::array::from_fn;

/// Coefficients over the unit square; the first index goes along u, the second along v.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bicubic<T>(pub [[T; 4]; 4]);

/// First and second derivatives.
#[derive(Clone, Copy, Debug)]
pub struct Jet<T> {
    pub u: T,
    pub v: T,
    pub uu: T,
    pub uv: T,
    pub vv: T,
}

impl<T: Value> Bicubic<T> {
    pub fn map<S>(&self, function: impl Fn(T) -> S) -> Bicubic<S> {
        Bicubic(self.0.map(|row| row.map(&function)))
    }

    pub fn all(&self) -> impl Iterator<Item = T> + '_ {
        self.0.iter().flatten().copied()
    }

    pub fn value(&self, [u, v]: [f64; 2]) -> T {
        cubic(&self.0.map(|row| cubic(&row, v)), u)
    }

    /// The derivatives along u and v.
    pub fn slopes(&self, [u, v]: [f64; 2]) -> [T; 2] {
        let along = self.0.map(|row| cubic(&row, v));
        let across = self.0.map(|row| cubic_slope(&row, v));
        [cubic_slope(&along, u), cubic(&across, u)]
    }

    pub fn jet(&self, [u, v]: [f64; 2]) -> Jet<T> {
        let values = self.0.map(|row| cubic(&row, v));
        let slopes = self.0.map(|row| cubic_slope(&row, v));
        let bends = self.0.map(|row| cubic_bend(&row, v));
        Jet {
            u: cubic_slope(&values, u),
            v: cubic(&slopes, u),
            uu: cubic_bend(&values, u),
            uv: cubic_slope(&slopes, u),
            vv: cubic(&bends, u),
        }
    }

    /// The net with u and v exchanged.
    pub fn transposed(&self) -> Self {
        Self(from_fn(|i| from_fn(|j| self.0[j][i])))
    }

    /// The same function over a part of the plane, as one over the unit square.
    pub fn part(&self, [u, v]: [[f64; 2]; 2]) -> Self {
        let along_v = Self(self.0.map(|row| restricted(&row, v))).transposed();
        Self(along_v.0.map(|column| restricted(&column, u))).transposed()
    }

    /// Both halves along u (axis 0) or v (axis 1).
    pub fn halves(&self, axis: usize) -> [Self; 2] {
        let halved = |bicubic: &Self| {
            let pairs = bicubic.0.map(halves);
            [Self(pairs.map(|pair| pair[0])), Self(pairs.map(|pair| pair[1]))]
        };
        if axis == 1 { halved(self) } else { halved(&self.transposed()).map(|half| half.transposed()) }
    }
}

/// A cubic's, by de Casteljau's algorithm.
fn halves<T: Value>([a, b, c, d]: [T; 4]) -> [[T; 4]; 2] {
    let mean = |a: T, b: T| (a + b) * 0.5;
    let (ab, bc, cd) = (mean(a, b), mean(b, c), mean(c, d));
    let (abc, bcd) = (mean(ab, bc), mean(bc, cd));
    let middle = mean(abc, bcd);
    [[a, ab, abc, middle], [middle, bcd, cd, d]]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bumpy() -> Bicubic<f64> {
        Bicubic(from_fn(|i| from_fn(|j| (1.7 * i as f64 + 0.3).sin() * (2.3 * j as f64 - i as f64).cos())))
    }

    /// Against the sum of Bernstein polynomials, and derivatives against differences.
    #[test]
    fn values_and_derivatives() {
        let bicubic = bumpy();
        let bernstein =
            |i: usize, u: f64| [1.0, 3.0, 3.0, 1.0][i] * u.powi(i as i32) * (1.0 - u).powi(3 - i as i32);
        for (u, v) in [(0.0, 0.0), (0.25, 0.75), (1.0, 0.5), (0.6, 1.0), (-0.2, 1.3)] {
            let mut sum = 0.0;
            for (i, row) in bicubic.0.iter().enumerate() {
                for (j, value) in row.iter().enumerate() {
                    sum += bernstein(i, u) * bernstein(j, v) * value;
                }
            }
            let near =
                |a: f64, b: f64, tolerance: f64| assert!((a - b).abs() < tolerance, "{u} {v}: {a} {b}");
            near(bicubic.value([u, v]), sum, 1e-13);
            let (jet, h) = (bicubic.jet([u, v]), 1e-4);
            let at = |a: f64, b: f64| bicubic.value([u + a * h, v + b * h]);
            near(bicubic.value([u, v]), sum, 1e-13);
            near(jet.u, (at(1.0, 0.0) - at(-1.0, 0.0)) / (2.0 * h), 1e-6);
            near(jet.v, (at(0.0, 1.0) - at(0.0, -1.0)) / (2.0 * h), 1e-6);
            near(jet.uu, (at(1.0, 0.0) + at(-1.0, 0.0) - 2.0 * sum) / (h * h), 1e-5);
            near(jet.vv, (at(0.0, 1.0) + at(0.0, -1.0) - 2.0 * sum) / (h * h), 1e-5);
            let mixed = at(1.0, 1.0) + at(-1.0, -1.0) - at(1.0, -1.0) - at(-1.0, 1.0);
            near(jet.uv, mixed / (4.0 * h * h), 1e-5);
            assert_eq!(bicubic.slopes([u, v]), [jet.u, jet.v]);
        }
    }

    #[test]
    fn parts_are_parts() {
        let bicubic = bumpy();
        let part = bicubic.part([[0.25, 0.5], [-0.5, 1.5]]);
        let [_, upper] = bicubic.halves(0);
        let [left, _] = bicubic.halves(1);
        for (u, v) in [(0.0, 0.0), (0.25, 0.75), (1.0, 0.5), (0.6, 1.0)] {
            let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-13, "{u} {v}: {a} {b}");
            near(part.value([u, v]), bicubic.value([0.25 + 0.25 * u, 2.0 * v - 0.5]));
            near(upper.value([u, v]), bicubic.value([0.5 + 0.5 * u, v]));
            near(left.value([u, v]), bicubic.value([u, 0.5 * v]));
            near(bicubic.transposed().value([u, v]), bicubic.value([v, u]));
        }
    }
}
