//! The function in one cell, and where a line meets its zero there.

use super::SdfData;
use crate::geometry::Vec3;
use crate::geometry::roots::{Sample, bracketed, quadratic};
use crate::shape::grid::{Change, Line, Signs, index};
use smallvec::SmallVec;

/// Corners of a cell, whose bits are x, y and z, at a place in it.
pub(super) fn interpolate(corners: &[f64; 8], [x, y, z]: [f64; 3]) -> f64 {
    // Exact at both ends, and never beyond the two values.
    let mix = |a: f64, b: f64, u: f64| a * (1.0 - u) + b * u;
    let [a, b, c, d] = [0, 2, 4, 6].map(|i| mix(corners[i], corners[i + 1], x));
    mix(mix(a, b, y), mix(c, d, y), z)
}

/// Derivatives along the cell's edges.
pub(super) fn gradient(corners: &[f64; 8], at: [f64; 3]) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|axis| {
        let mut ends = [at; 2];
        (ends[0][axis], ends[1][axis]) = (0.0, 1.0);
        interpolate(corners, ends[1]) - interpolate(corners, ends[0])
    }))
}

/// Coefficients of the cubic along a line through a place in the cell, in ascending order.
pub(super) fn cubic(corners: &[f64; 8], at: [f64; 3], direction: [f64; 3]) -> [f64; 4] {
    // a + (b − a)(x + dx s), for polynomials in s.
    let mix = |a: [f64; 4], b: [f64; 4], axis: usize| -> [f64; 4] {
        let rise: [f64; 4] = std::array::from_fn(|power| b[power] - a[power]);
        let lower = |power: usize| if power == 0 { 0.0 } else { rise[power - 1] };
        std::array::from_fn(|power| a[power] + rise[power] * at[axis] + lower(power) * direction[axis])
    };
    let constant = |corner: usize| [corners[corner], 0.0, 0.0, 0.0];
    let [a, b, c, d] = [0, 2, 4, 6].map(|corner| mix(constant(corner), constant(corner + 1), 0));
    mix(mix(a, b, 1), mix(c, d, 1), 2)
}

pub(super) fn evaluate([a, b, c, d]: [f64; 4], s: f64) -> f64 {
    a + s * (b + s * (c + s * d))
}

/// A crossing in a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct InCell {
    pub cell: u32,
    pub t: f64,
    pub error: f64,
    pub enters: bool,
}

/// Where the line along an axis through a place on the cell's side across it meets the surface.
pub(super) fn on_line(corners: &[f64; 8], axis: usize, across: [f64; 2]) -> Option<[f64; 3]> {
    let mut at = [0.0; 3];
    at[(axis + 1) % 3] = across[0];
    at[(axis + 2) % 3] = across[1];
    let first = interpolate(corners, at);
    at[axis] = 1.0;
    let last = interpolate(corners, at);
    at[axis] = first / (first - last);
    ((first < 0.0) != (last < 0.0)).then_some(at)
}

/// The part of a line in a cell.
pub(super) struct Within<'a> {
    pub line: &'a Line<3>,
    pub cell: [usize; 3],
    pub ends: [f64; 2],
    pub through: Option<usize>,
    /// Bound on the error of the place in the cell, along any axis.
    pub coordinate: f64,
}

impl Within<'_> {
    pub fn crossings(&self, data: &SdfData, signs: &mut Signs) -> SmallVec<[InCell; 3]> {
        let [from, to] = self.ends;
        let corners = data.corners(self.cell);
        let leaving = interpolate(&corners, self.line.place(self.cell, to, self.through, true));
        let at = self.line.place(self.cell, from, None, true);
        let coefficients = cubic(&corners, at, self.line.direction);
        let [_, b, c, d] = coefficients;
        let mut found = SmallVec::new();
        let mut next = |s: f64, value: f64| {
            let Some(Change { between, from: sign }) = signs.next(from + s, value) else { return };
            let root = bracketed(between[0] - from, between[1] - from, sign, &|s| Sample {
                value: evaluate(coefficients, s),
                slope: b + s * (2.0 * c + s * 3.0 * d),
                error: 0.0,
            });
            let error = self.error(data, &corners, coefficients, root.t) + root.error;
            let cell = index(data.pyramid.size(), self.cell) as u32;
            found.push(InCell { cell, t: from + root.t, error, enters: sign > 0.0 });
        };
        for extreme in quadratic(3.0 * d, 2.0 * c, b) {
            if 0.0 < extreme.t && extreme.t < to - from {
                next(extreme.t, evaluate(coefficients, extreme.t));
            }
        }
        next(to - from, leaving);
        found
    }

    /// Bound on the error of a root.
    fn error(&self, data: &SdfData, corners: &[f64; 8], [_, b, c, d]: [f64; 4], s: f64) -> f64 {
        let length = self.ends[1] - self.ends[0];
        let greatest = corners.iter().fold(0.0f64, |most, value| most.max(value.abs()));
        let at = self.line.place(self.cell, self.ends[0] + s, None, true);
        let height =
            gradient(corners, at).abs().element_sum() * self.coordinate + 32.0 * f64::EPSILON * greatest;
        let slope = b + s * (2.0 * c + s * 3.0 * d);
        let bend = 2.0 * c.abs() + 6.0 * d.abs() * length;
        let error = 2.0 * height / slope.abs();
        // As long as the slope hardly changes over that distance; else the line all but touches.
        if slope * slope <= 4.0 * bend * height || error.is_nan() {
            return f64::INFINITY;
        }
        if error < s && error < length - s {
            return error;
        }
        // Beyond the cell's side the slope is another.
        let direction = Vec3::from_array(self.line.direction);
        let size = data.pyramid.size();
        let least = (0..8usize).fold(slope.abs(), |least, corner| {
            let (mut cell, mut at) = (self.cell, at);
            for axis in (0..3).filter(|axis| corner >> axis & 1 == 1) {
                let near = error * direction[axis].abs() + self.coordinate;
                if at[axis] <= near && cell[axis] > 0 {
                    (cell[axis], at[axis]) = (cell[axis] - 1, 1.0);
                } else if at[axis] >= 1.0 - near && cell[axis] + 1 < size[axis] {
                    (cell[axis], at[axis]) = (cell[axis] + 1, 0.0);
                }
            }
            let there = gradient(&data.corners(cell), at).dot(direction);
            least.min(there * slope.signum())
        });
        if least > 0.0 { 2.0 * height / least } else { f64::INFINITY }
    }
}
