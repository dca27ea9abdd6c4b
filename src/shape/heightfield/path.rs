//! A ray through a height field.

use super::{BASE, HeightField, Patch, wall_normal};
use crate::geometry::Vec3;
use crate::geometry::roots::difference_of_products;
use crate::shape::crossing::Crossing;
use crate::shape::grid::{Change, Line, Signs, index};
use crate::shape::{Hit, NO_INSTANCE};
use smallvec::SmallVec;

/// A ray in a field's own coordinates; t is that of the ray less `shift`.
pub(super) struct Path<'a> {
    pub field: &'a HeightField,
    pub origin: Vec3,
    pub direction: Vec3,
    /// Bound on the error of coordinates.
    pub coordinate: f64,
    pub shift: f64,
}

impl Path<'_> {
    pub fn line(&self) -> Line<2> {
        let density = self.field.density();
        Line {
            origin: [0, 1].map(|axis| (self.origin[axis] + 1.0) * density[axis]),
            direction: [0, 1].map(|axis| self.direction[axis] * density[axis]),
        }
    }

    pub fn height(&self, t: f64) -> f64 {
        self.origin.z + self.direction.z * t
    }

    pub fn crossing(&self, cell: [usize; 2], t: f64, error: f64, enters: bool) -> Crossing {
        let part = index(self.field.size(), cell);
        self.of_part(part, t, error, enters)
    }

    fn of_part(&self, part: usize, t: f64, error: f64, enters: bool) -> Crossing {
        let error = error + 4.0 * f64::EPSILON * (self.shift.abs() + t.abs());
        let hit = Hit {
            t: self.shift + t,
            shape: 0,
            triangle: part as u32,
            instance: NO_INSTANCE,
            barycentric: [0.0; 2],
        };
        Crossing { hit, error, enters }
    }

    /// A crossing with one of the plane parts of a body.
    pub fn wall(&self, t: f64, enters: bool) -> Crossing {
        let at = self.origin + self.direction * t;
        let normals = [0, 1, 2, 3, BASE].map(|wall| if wall == BASE { -Vec3::Z } else { wall_normal(wall) });
        // Among those that it goes through in the right way, the one on whose plane it is.
        let off = |wall: &usize| {
            let against = normals[*wall].dot(self.direction) * if enters { -1.0 } else { 1.0 };
            if against > 0.0 { (1.0 - normals[*wall].dot(at)).abs() } else { f64::INFINITY }
        };
        let wall = (0..=BASE).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(BASE);
        let error = 2.0 * self.coordinate / normals[wall].dot(self.direction).abs();
        self.of_part(self.field.data.pyramid.cells() + wall, t, error, enters)
    }

    /// Crossings of one patch.
    pub fn in_cell(
        &self,
        line: &Line<2>,
        cell: [usize; 2],
        [from, to]: [f64; 2],
        through: Option<usize>,
        signs: &mut Signs,
    ) -> SmallVec<[Crossing; 2]> {
        let patch = self.field.patch(cell);
        let leaving = self.height(to) - patch.height(line.place(cell, to, through, true));
        let at = line.place(cell, from, None, true);
        let [dx, dy] = line.direction;
        let ([rise_x, rise_y], twist) = (patch.slopes(at), patch.twist());
        // The height over the patch is a s² + 2 half s + c.
        let (a, half) = (-twist * dx * dy, 0.5 * (self.direction.z - rise_x * dx - rise_y * dy));
        let c = self.height(from) - patch.height(at);
        let discriminant = difference_of_products(half, half, a, c);
        let mut found = SmallVec::new();
        let mut next = |s: f64, value: f64| {
            let Some(Change { between, from: sign }) = signs.next(from + s, value) else { return };
            // The root at which the height falls where it was positive, else the one at which it rises.
            let root = discriminant.max(0.0).sqrt() * -sign;
            let s = if half * root > 0.0 { -c / (half + root) } else { (root - half) / a };
            let [first, last] = between.map(|t| t - from);
            let s = if s.is_finite() { s.clamp(first, last) } else { first };
            let error = self.error(line, cell, &patch, [s, to - from], [a, 2.0 * (half + a * s)], from);
            found.push(self.crossing(cell, from + s, error, sign > 0.0));
        };
        let extreme = -half / a;
        if 0.0 < extreme && extreme < to - from {
            next(extreme, -discriminant / a);
        }
        next(to - from, leaving);
        found
    }

    /// Bound on the error of a root at s of `length`.
    fn error(
        &self,
        line: &Line<2>,
        cell: [usize; 2],
        patch: &Patch,
        [s, length]: [f64; 2],
        [a, slope]: [f64; 2],
        from: f64,
    ) -> f64 {
        let at = line.place(cell, from + s, None, true);
        let up = self.field.upward(patch, at);
        let height = self.coordinate * up.abs().element_sum() + 16.0 * f64::EPSILON;
        let error = 2.0 * height / slope.abs();
        // As long as the slope hardly changes over that distance; else the line all but touches.
        if slope * slope <= 8.0 * a.abs() * height || error.is_nan() {
            return f64::INFINITY;
        }
        if error < s && error < length - s {
            return error;
        }
        // Beyond the cell's side the slope is another.
        let (size, density) = (self.field.size(), self.field.density());
        let least = (0..4usize).fold(slope.abs(), |least, corner| {
            let (mut cell, mut at) = (cell, at);
            for axis in (0..2).filter(|axis| corner >> axis & 1 == 1) {
                let near = error * line.direction[axis].abs() + self.coordinate * density[axis];
                if at[axis] <= near && cell[axis] > 0 {
                    (cell[axis], at[axis]) = (cell[axis] - 1, 1.0);
                } else if at[axis] >= 1.0 - near && cell[axis] + 1 < size[axis] {
                    (cell[axis], at[axis]) = (cell[axis] + 1, 0.0);
                }
            }
            let [x, y] = self.field.patch(cell).slopes(at);
            let there = self.direction.z - x * line.direction[0] - y * line.direction[1];
            least.min(there * slope.signum())
        });
        if least > 0.0 { 2.0 * height / least } else { f64::INFINITY }
    }
}
