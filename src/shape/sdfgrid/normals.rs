//! Shading normals that are continuous where the gradient is not.

use super::SdfData;
use crate::geometry::Vec3;
use crate::shape::grid::index;

/// Normal of any length, in the coordinates of the unit cube, at a place of a cell.
///
/// The unit gradients of the eight cells around the nearest grid point are blended by where the place is
/// between the cells' centres (Hansson-Söderlund, Evans and Akenine-Möller 2022, section 4.1). As in Mitsuba
/// 3 a cell's derivative along an axis is the difference between its two sides of the function as it is at
/// the place's other two coordinates.
pub(super) fn smooth(data: &SdfData, cell: [usize; 3], at: [f64; 3]) -> Vec3 {
    let points = data.points;
    // The function at the place's other two coordinates, at a point of the grid along an axis.
    let side = |axis: usize, point: usize| {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        let value = |i: usize, j: usize| {
            let mut corner = [0; 3];
            (corner[axis], corner[b], corner[c]) = (point, cell[b] + i, cell[c] + j);
            f64::from(data.values[index(points, corner)])
        };
        let mix = |a: f64, b: f64, u: f64| a * (1.0 - u) + b * u;
        mix(mix(value(0, 0), value(1, 0), at[b]), mix(value(0, 1), value(1, 1), at[b]), at[c])
    };
    // For each axis the derivatives of the lower and the upper of the two cells, and the fraction of the
    // upper.
    let mut slopes = [[0.0; 2]; 3];
    let mut areas = [0.0; 3];
    for axis in 0..3 {
        let cells = points[axis] - 1;
        let slope = |cell: usize| (side(axis, cell + 1) - side(axis, cell)) * cells as f64;
        let here = cell[axis];
        let lower = if at[axis] < 0.5 { here.checked_sub(1) } else { Some(here) };
        let upper = lower.map_or(0, |lower| lower + 1);
        slopes[axis] = [slope(lower.unwrap_or(0)), slope(upper.min(cells - 1))];
        areas[axis] = match lower {
            // Cells that do not exist have no weight.
            None => 1.0,
            Some(_) if upper == cells => 0.0,
            Some(_) if at[axis] < 0.5 => at[axis] + 0.5,
            Some(_) => at[axis] - 0.5,
        };
    }
    (0..8usize).fold(Vec3::ZERO, |sum, corner| {
        let upper = |axis: usize| corner >> axis & 1;
        let slope = Vec3::from_array([0, 1, 2].map(|axis| slopes[axis][upper(axis)]));
        let weight: f64 =
            (0..3).map(|axis| if upper(axis) == 1 { areas[axis] } else { 1.0 - areas[axis] }).product();
        sum + slope.normalize_or_zero() * weight
    })
}
