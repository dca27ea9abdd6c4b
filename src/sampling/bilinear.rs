//! Densities over grids that are bilinear in each cell.

use super::grid::{Corners, GridInversion, InLanes};
use crate::lanes::{Mask, Real, Row, ZERO, get, lanes_of, registers_of, set};

/// A density over a grid that chooses cells by their own integrals, and within each follows the values at its
/// corners.
#[derive(Clone, Debug)]
pub struct PiecewiseBilinearGrid {
    /// With the corners of each cell: upper left, upper right, lower left and lower right.
    inversion: GridInversion,
}

impl PiecewiseBilinearGrid {
    /// From the integral over each cell, row by row, up to a common factor, and the values at the crossings
    /// of the grid's lines, up to another. `None` unless there are as many as fill whole rows, none is
    /// negative or not finite, and the integrals' sum is positive and finite.
    pub fn new(columns: usize, integrals: &[f64], corners: &[f32]) -> Option<Self> {
        let rows = integrals.len() / columns.max(1);
        let valid = corners.iter().all(|&value| value >= 0.0 && value.is_finite());
        if !valid || corners.len() != (columns + 1) * (rows + 1) {
            return None;
        }
        let of_cell = |index: usize| {
            let upper = index / columns * (columns + 1) + index % columns;
            let lower = upper + columns + 1;
            in_bytes([upper, upper + 1, lower, lower + 1].map(|corner| corners[corner]))
        };
        Some(Self { inversion: GridInversion::new(columns, integrals, of_cell)? })
    }

    /// The place at the sample values `u` in [0, 1)², as (column, row) with fractions, and the density there,
    /// per cell.
    pub fn sample(&self, u: [f64; 2]) -> ([f64; 2], f64) {
        let (y, row, of_row, found) = self.inversion.sample(u);
        let values = densities(found.share, found.corners);
        let (place, density) = follow(values, [found.x, y], [found.column, row].map(|index| index as f64));
        (place, of_row * density)
    }

    /// [`Self::sample`] for the lanes asked for: the places, and the densities there.
    #[inline]
    pub fn sample_in_lanes(&self, u: &[Row; 2], asked: Mask) -> ([Row; 2], Row) {
        let InLanes { y, rows, in_rows, of_row } = self.inversion.sample_in_lanes(u, asked);
        let (mut place, mut corners, mut indices, mut densities) = ([ZERO, y], [ZERO; 4], [ZERO; 2], ZERO);
        for lane in lanes_of(asked) {
            let found = &in_rows[lane];
            set(&mut place[0], lane, found.x);
            for (corner, value) in corners.iter_mut().zip(self::densities(found.share, found.corners)) {
                set(corner, lane, value);
            }
            for (index, value) in indices.iter_mut().zip([found.column, rows[lane]]) {
                set(index, lane, value as f64);
            }
        }
        for register in registers_of(asked) {
            let of_register = |row: &Row| row[register];
            let values = corners.each_ref().map(of_register);
            let found = place.each_ref().map(of_register);
            let ([x, y], density) = follow(values, found, indices.each_ref().map(of_register));
            (place[0][register], place[1][register]) = (x, y);
            densities[register] = of_row[register] * density;
        }
        (place, densities)
    }

    /// The density of [`Self::sample`] at a place.
    pub fn density(&self, place: [f64; 2]) -> f64 {
        let [column, row] = self.cell_at(place);
        let part = part_of(place, [column as f64, row as f64]);
        self.inversion.of_row(row) * within(self.cell(column, row), part)
    }

    /// [`Self::density`] for the lanes asked for.
    #[inline]
    pub fn density_in_lanes(&self, place: &[Row; 2], asked: Mask) -> Row {
        let (mut corners, mut cells, mut of_row) = ([ZERO; 4], [ZERO; 2], ZERO);
        for lane in lanes_of(asked) {
            let [column, row] = self.cell_at(place.each_ref().map(|row| get(row, lane)));
            for (corner, value) in corners.iter_mut().zip(self.cell(column, row)) {
                set(corner, lane, value);
            }
            for (cell, value) in cells.iter_mut().zip([column, row]) {
                set(cell, lane, value as f64);
            }
            set(&mut of_row, lane, self.inversion.of_row(row));
        }
        let mut densities = ZERO;
        for register in registers_of(asked) {
            let of_register = |row: &Row| row[register];
            let cell = cells.each_ref().map(of_register);
            let part = part_of(place.each_ref().map(of_register), cell);
            densities[register] = of_row[register] * within(corners.each_ref().map(of_register), part);
        }
        densities
    }

    /// Column and row of the cell at a place.
    fn cell_at(&self, [x, y]: [f64; 2]) -> [usize; 2] {
        let [columns, rows] = self.inversion.size();
        [(x as usize).min(columns - 1), (y as usize).min(rows - 1)]
    }

    /// The density at the corners of a cell, with that of its row as unit.
    fn cell(&self, column: usize, row: usize) -> [f64; 4] {
        let (share, corners) = self.inversion.cell(column, row);
        densities(share, corners)
    }
}

/// Values at the corners of a cell over the largest of them, as bytes: only zero is 0. All are the same where
/// none is above zero.
fn in_bytes(values: [f32; 4]) -> Corners {
    let most = values.into_iter().fold(0.0, f32::max);
    if most == 0.0 {
        return [1; 4];
    }
    // The quotient of what is too small for single precision is 0.
    values.map(|value| if value > 0.0 { (value / most * 255.0).ceil().max(1.0) as u8 } else { 0 })
}

/// The density at the corners of a cell, whose mean is the probability of the cell.
#[inline(always)]
fn densities(probability: f64, corners: Corners) -> [f64; 4] {
    let sum: u32 = corners.iter().map(|&corner| u32::from(corner)).sum();
    let unit = 4.0 * probability / f64::from(sum);
    corners.map(|corner| unit * f64::from(corner))
}

/// From a place that is spread evenly over a cell, by the cell's column and row, to one that follows the
/// values at its corners, and the value there.
#[inline(always)]
fn follow<R: Real>(values: [R; 4], place: [R; 2], cell: [R; 2]) -> ([R; 2], R) {
    let [x, y] = part_of(place, cell);
    let [a, b, c, d] = values;
    let down = linear(y, [a + b, c + d]);
    let across = linear(x, [a + (c - a) * down, b + (d - b) * down]);
    ([cell[0] + across, cell[1] + down], within(values, [across, down]))
}

/// Where in a cell, by its column and row, a place is.
#[inline(always)]
fn part_of<R: Real>(place: [R; 2], cell: [R; 2]) -> [R; 2] {
    [0, 1].map(|axis| (place[axis] - cell[axis]).greater(R::of(0.0)).lesser(R::of(1.0)))
}

/// Between the values at the corners of a cell.
#[inline(always)]
fn within<R: Real>([a, b, c, d]: [R; 4], [x, y]: [R; 2]) -> R {
    let (top, bottom) = (a + (b - a) * x, c + (d - c) * x);
    top + (bottom - top) * y
}

/// The place in [0, 1] up to which a fraction `u` of a linear density lies, by its values at both ends.
#[inline(always)]
pub(super) fn linear<R: Real>(u: R, [from, to]: [R; 2]) -> R {
    let (zero, all) = (R::of(0.0), from + to);
    let root = (from * from + u * (to - from) * all).greater(zero).sqrt();
    let below = from + root;
    // Without cancellation, whichever end is higher.
    let place = R::choose(below.gt(zero), (u * all / below).lesser(R::of(1.0)), zero);
    R::choose(all.eq(zero), u, place)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::quadrature::midpoints;
    use crate::stats::chi_square;

    fn grid() -> PiecewiseBilinearGrid {
        let corners = vec![0.0, 1.0, 0.0, 5.0, 0.0, 0.0, 2.0, 2.0, 2.0, 0.0, 3.0, 0.0];
        // The last cell is one whose integral the corners do not tell.
        PiecewiseBilinearGrid::new(3, &[1.0, 2.0, 4.0, 0.0, 3.0, 7.0], &corners).unwrap()
    }

    #[test]
    fn samples_follow_the_density() {
        const SIDE: usize = 30;
        const SAMPLES: usize = 300;
        let grid = grid();
        let mut seen = vec![0.0; 2 * SIDE * 3 * SIDE / 9];
        let mut expected = seen.clone();
        let bin = |[x, y]: [f64; 2]| {
            let [x, y] = [x / 3.0, y / 2.0].map(|part| part.min(0.999_999));
            (y * (2 * SIDE / 3) as f64) as usize * SIDE + (x * SIDE as f64) as usize
        };
        for u in midpoints(SAMPLES) {
            let (place, density) = grid.sample(u);
            assert!((density - grid.density(place)).abs() < 1e-9 * density, "{place:?}");
            seen[bin(place)] += 1.0;
        }
        // The midpoint rule is exact for what is bilinear, as no line of the grid lies within a bin.
        for row in 0..2 * SIDE / 3 {
            for column in 0..SIDE {
                let middle = [
                    3.0 * (column as f64 + 0.5) / SIDE as f64,
                    2.0 * (row as f64 + 0.5) / (2 * SIDE / 3) as f64,
                ];
                let area = 6.0 / (SIDE * (2 * SIDE / 3)) as f64;
                expected[row * SIDE + column] = grid.density(middle) * area * (SAMPLES * SAMPLES) as f64;
            }
        }
        let total: f64 = expected.iter().sum();
        assert!((total / (SAMPLES * SAMPLES) as f64 - 1.0).abs() < 1e-6, "{total}");
        // Samples of a grid are spread better than at random.
        let test = chi_square(&seen, &expected);
        assert!(test.p_value > 0.01, "{test:?}");
    }

    #[test]
    fn what_is_no_density_is_refused() {
        assert!(PiecewiseBilinearGrid::new(1, &[1.0], &[1.0; 3]).is_none());
        assert!(PiecewiseBilinearGrid::new(1, &[1.0], &[1.0, 1.0, -1.0, 1.0]).is_none());
        assert!(PiecewiseBilinearGrid::new(1, &[0.0], &[1.0; 4]).is_none());
    }
}
