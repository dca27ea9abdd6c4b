//! Functions of the unit square that depend on parameters: tables between whose points they are linear.

use super::bilinear::linear;
use smallvec::SmallVec;

/// Functions of the unit square, bilinear between the points of a grid. There is one grid for each
/// combination of the values at which N parameters were taken, and between these the functions are linear in
/// each.
#[derive(Clone, Debug)]
pub struct ParametricGrid<const N: usize> {
    /// The values of each parameter, ascending.
    axes: [Vec<f64>; N],
    /// Points along x and along y.
    size: [usize; 2],
    /// Along x, along y, then along the axes from the last to the first.
    values: Vec<f32>,
}

/// The grids around the values of some parameters: their numbers and weights, which sum up to 1.
pub struct Around(SmallVec<[(usize, f64); 8]>);

impl Around {
    /// The weighted mean of a number of each grid.
    fn mean(&self, of: impl Fn(usize) -> f64) -> f64 {
        self.0.iter().map(|&(grid, weight)| weight * of(grid)).sum()
    }
}

impl<const N: usize> ParametricGrid<N> {
    /// From the values at the points: along x, along y, then along the axes from the last to the first.
    /// `None` unless each axis ascends, a grid has two points or more along x and y, and there is a value for
    /// each point, finite and not negative.
    pub fn new(axes: [Vec<f64>; N], size: [usize; 2], values: Vec<f32>) -> Option<Self> {
        let ascends = |axis: &Vec<f64>| {
            !axis.is_empty()
                && axis.iter().all(|value| value.is_finite())
                && axis.windows(2).all(|pair| pair[0] < pair[1])
        };
        let points = axes.iter().map(Vec::len).chain(size).try_fold(1usize, usize::checked_mul)?;
        let valid = axes.iter().all(ascends)
            && size.iter().all(|&points| points >= 2)
            && values.len() == points
            && values.iter().all(|&value| value.is_finite() && value >= 0.0);
        valid.then_some(Self { axes, size, values })
    }

    /// How many values each parameter has.
    pub fn lengths(&self) -> [usize; N] {
        self.axes.each_ref().map(Vec::len)
    }

    /// Where a parameter has a value, as a number of its axis with a fraction. Beyond the ends of the axis it
    /// is the end.
    pub fn place(&self, axis: usize, value: f64) -> f64 {
        let axis = &self.axes[axis];
        let above = axis.partition_point(|&known| known <= value);
        match above {
            0 => 0.0,
            _ if above == axis.len() => (axis.len() - 1) as f64,
            _ => {
                let [low, high] = [axis[above - 1], axis[above]];
                (above - 1) as f64 + (value - low) / (high - low)
            }
        }
    }

    /// The grids around the places of the parameters.
    pub fn around(&self, places: [f64; N]) -> Around {
        let mut around: SmallVec<[(usize, f64); 8]> = SmallVec::from_slice(&[(0, 1.0)]);
        for (axis, place) in self.axes.iter().zip(places) {
            let low = (place as usize).min(axis.len() - 1);
            let fraction = place - low as f64;
            around = around
                .into_iter()
                .flat_map(|(grid, weight)| {
                    let grid = grid * axis.len() + low;
                    [(grid, weight * (1.0 - fraction)), (grid + 1, weight * fraction)]
                })
                .filter(|&(_, weight)| weight > 0.0)
                .collect();
        }
        Around(around)
    }

    /// The value at a place in the unit square.
    pub fn value(&self, around: &Around, [x, y]: [f64; 2]) -> f64 {
        let [columns, rows] = self.size;
        let ((column, x), (row, y)) = (cell(x, columns), cell(y, rows));
        around.mean(|grid| {
            let at = (grid * rows + row) * columns + column;
            let [a, b, c, d] =
                [at, at + 1, at + columns, at + columns + 1].map(|at| f64::from(self.values[at]));
            let (top, bottom) = (a + (b - a) * x, c + (d - c) * x);
            top + (bottom - top) * y
        })
    }
}

/// The part between two points of a line that a place in the unit interval is in, and where in that part.
fn cell(place: f64, points: usize) -> (usize, f64) {
    let place = place.clamp(0.0, 1.0) * (points - 1) as f64;
    let cell = (place as usize).min(points - 2);
    (cell, place - cell as f64)
}

/// A density over the unit square for each combination of parameters, in proportion to a [`ParametricGrid`]
/// whose every grid counts as much as the others.
#[derive(Clone, Debug)]
pub struct ParametricDensity<const N: usize> {
    /// The densities themselves.
    grid: ParametricGrid<N>,
    /// For each point of a grid, the integral of its row up to it.
    within_rows: Vec<f64>,
    /// For each row of a grid, the integral of all that lies above it.
    above: Vec<f64>,
}

/// How much of a density that is linear between the points of a line lies before each of them, and in all.
/// The distance from the first to the last is 1.
fn sums(densities: impl ExactSizeIterator<Item = f64>) -> Vec<f64> {
    let step = 1.0 / (densities.len() - 1) as f64;
    let mut before = None;
    let mut sum = 0.0;
    densities
        .map(|density| {
            sum += before.map_or(0.0, |before| 0.5 * step * (before + density));
            before = Some(density);
            sum
        })
        .collect()
}

impl<const N: usize> ParametricDensity<N> {
    /// In proportion to the values of a grid; even where a grid is zero all over.
    pub fn new(mut grid: ParametricGrid<N>) -> Self {
        let [columns, rows] = grid.size;
        let (mut within_rows, mut above) = (Vec::new(), Vec::new());
        for values in grid.values.chunks_mut(columns * rows) {
            let parts = |values: &[f32]| -> [Vec<f64>; 2] {
                let within: Vec<f64> =
                    values.chunks(columns).flat_map(|row| sums(row.iter().map(|&v| f64::from(v)))).collect();
                let of_rows: Vec<f64> = within.chunks(columns).map(|row| row[columns - 1]).collect();
                let above = sums(of_rows.into_iter());
                [within, above]
            };
            let [_, all] = parts(values);
            let total = all[rows - 1];
            for value in values.iter_mut() {
                *value = if total > 0.0 { (f64::from(*value) / total) as f32 } else { 1.0 };
            }
            let [within, all] = parts(values);
            within_rows.extend(within);
            above.extend(all);
        }
        Self { grid, within_rows, above }
    }

    /// The grids around the places of the parameters.
    pub fn around(&self, places: [f64; N]) -> Around {
        self.grid.around(places)
    }

    /// Where a parameter has a value; see [`ParametricGrid::place`].
    pub fn place(&self, axis: usize, value: f64) -> f64 {
        self.grid.place(axis, value)
    }

    /// The density at a place in the unit square.
    pub fn density(&self, around: &Around, place: [f64; 2]) -> f64 {
        self.grid.value(around, place)
    }

    /// The place up to which fractions `u` of the density lie: in rows before it `u[1]`, within its own
    /// `u[0]`.
    pub fn sample(&self, around: &Around, u: [f64; 2]) -> [f64; 2] {
        let [columns, rows] = self.grid.size;
        let above = |row: usize| self.above(around, row);
        let (row, y) = find(rows, u[1], above, |row| self.in_row(around, (row, 0.0), columns - 1));
        let (column, x) = find(
            columns,
            u[0],
            |column| self.in_row(around, (row, y), column),
            |column| self.at_point(around, (row, y), column),
        );
        [(column as f64 + x) / (columns - 1) as f64, (row as f64 + y) / (rows - 1) as f64]
    }

    /// The fractions by which [`Self::sample`] comes to a place, and the density there.
    pub fn invert(&self, around: &Around, place: [f64; 2]) -> ([f64; 2], f64) {
        let [columns, rows] = self.grid.size;
        let ((column, x), (row, y)) = (cell(place[0], columns), cell(place[1], rows));
        let in_row = |column: usize| self.in_row(around, (row, y), column);
        let at_point = |column: usize| self.at_point(around, (row, y), column);
        let density = between([column, column + 1].map(at_point), x);
        let across = up_to([column, column + 1].map(in_row), [column, column + 1].map(at_point), x);
        let of_rows = [row, row + 1].map(|row| self.in_row(around, (row, 0.0), columns - 1));
        let down = up_to([row, row + 1].map(|row| self.above(around, row)), of_rows, y);
        let part = |part: f64, all: f64| if all > 0.0 { (part / all).clamp(0.0, 1.0) } else { 0.5 };
        ([part(across, in_row(columns - 1)), part(down, self.above(around, rows - 1))], density)
    }

    /// The integral of all rows above one.
    fn above(&self, around: &Around, row: usize) -> f64 {
        around.mean(|grid| self.above[grid * self.grid.size[1] + row])
    }

    /// The integral along a line between two rows, up to a column.
    fn in_row(&self, around: &Around, line: (usize, f64), column: usize) -> f64 {
        self.on_line(around, line, |at| self.within_rows[at + column])
    }

    /// The density at a column of a line between two rows.
    fn at_point(&self, around: &Around, line: (usize, f64), column: usize) -> f64 {
        self.on_line(around, line, |at| f64::from(self.grid.values[at + column]))
    }

    /// What rows have, by where they begin, on a line between two of them.
    fn on_line(&self, around: &Around, (row, down): (usize, f64), of: impl Fn(usize) -> f64) -> f64 {
        let [columns, rows] = self.grid.size;
        around.mean(|grid| {
            let at = (grid * rows + row) * columns;
            // The last row has none below it, and needs none.
            if down == 0.0 { of(at) } else { between([of(at), of(at + columns)], down) }
        })
    }
}

fn between([from, to]: [f64; 2], fraction: f64) -> f64 {
    from + (to - from) * fraction
}

/// What lies before a place between two points, by what lies before each of them and the densities there.
fn up_to(sums: [f64; 2], densities: [f64; 2], fraction: f64) -> f64 {
    let [from, to] = densities;
    let all = from + to;
    let part = if all > 0.0 { fraction * (2.0 * from + (to - from) * fraction) / all } else { fraction };
    between(sums, part)
}

/// The part between two of some points up to which a fraction `u` of a linear density lies, and the place in
/// it, by what lies before each point and the density there.
fn find(points: usize, u: f64, sum: impl Fn(usize) -> f64, density: impl Fn(usize) -> f64) -> (usize, f64) {
    let wanted = u * sum(points - 1);
    let (mut low, mut high) = (0, points - 1);
    while high - low > 1 {
        let middle = (low + high) / 2;
        if sum(middle) <= wanted { low = middle } else { high = middle }
    }
    let (from, to) = (sum(low), sum(low + 1));
    let fraction = if to > from { ((wanted - from) / (to - from)).clamp(0.0, 1.0) } else { u };
    (low, linear(fraction, [low, low + 1].map(density)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::chi_square;

    /// Two grids of 4 × 3 points each, for two values of a parameter; one has a zero and a dark corner.
    fn grid() -> ParametricGrid<1> {
        let values = vec![
            1.0, 0.0, 2.0, 3.0, 0.5, 4.0, 0.0, 1.0, 2.0, 2.0, 0.0, 0.0, //
            3.0, 1.0, 1.0, 0.0, 1.0, 5.0, 2.0, 2.0, 0.0, 1.0, 3.0, 1.0,
        ];
        ParametricGrid::new([vec![10.0, 30.0]], [4, 3], values).unwrap()
    }

    #[test]
    fn values_are_linear_between_points_and_parameters() {
        let grid = grid();
        let value = |parameter: f64, place| {
            let around = grid.around([grid.place(0, parameter)]);
            grid.value(&around, place)
        };
        let third = 1.0 / 3.0;
        assert_eq!(value(10.0, [0.0, 0.0]), 1.0);
        assert_eq!(value(0.0, [1.0, 0.0]), 3.0);
        assert_eq!(value(99.0, [1.0, 1.0]), 1.0);
        assert!((value(30.0, [third, 0.5]) - 5.0).abs() < 1e-12);
        // A quarter of the way; the middle of a cell has the mean of its corners.
        let (first, second) = ((1.0 + 0.0 + 0.5 + 4.0) / 4.0, (3.0 + 1.0 + 1.0 + 5.0) / 4.0);
        assert!((value(15.0, [0.5 * third, 0.25]) - (0.75 * first + 0.25 * second)).abs() < 1e-12);
    }

    #[test]
    fn samples_follow_the_density_and_are_inverted() {
        const SAMPLES: usize = 300;
        const BINS: [usize; 2] = [12, 8];
        let density = ParametricDensity::new(grid());
        for parameter in [10.0, 16.0, 30.0] {
            let around = density.around([density.place(0, parameter)]);
            let mut seen = vec![0.0; BINS[0] * BINS[1]];
            let mut expected = seen.clone();
            for i in 0..SAMPLES {
                for j in 0..SAMPLES {
                    let u = [i, j].map(|k| (k as f64 + 0.5) / SAMPLES as f64);
                    let place = density.sample(&around, u);
                    let (back, here) = density.invert(&around, place);
                    assert!((here - density.density(&around, place)).abs() < 1e-9, "{place:?}");
                    assert!((0..2).all(|axis| (back[axis] - u[axis]).abs() < 1e-9), "{u:?}: {back:?}");
                    let [x, y] = [0, 1].map(|axis| (place[axis] * BINS[axis] as f64) as usize);
                    seen[y.min(BINS[1] - 1) * BINS[0] + x.min(BINS[0] - 1)] += 1.0;
                }
            }
            // The midpoint rule is exact, as no line of the grid lies within a bin.
            for (bin, expected) in expected.iter_mut().enumerate() {
                let middle = [bin % BINS[0], bin / BINS[0]];
                let middle = [0, 1].map(|axis| (middle[axis] as f64 + 0.5) / BINS[axis] as f64);
                *expected = density.density(&around, middle) * (SAMPLES * SAMPLES) as f64 / 96.0;
            }
            let total = expected.iter().sum::<f64>() / (SAMPLES * SAMPLES) as f64;
            assert!((total - 1.0).abs() < 1e-6, "{total}");
            // Samples of a grid are spread better than at random.
            let test = chi_square(&seen, &expected);
            assert!(test.p_value > 0.01, "{parameter}: {test:?}");
        }
    }

    #[test]
    fn a_grid_of_zeros_is_even() {
        let grid = ParametricGrid::new([vec![0.0]], [2, 2], vec![0.0; 4]).unwrap();
        let density = ParametricDensity::new(grid);
        let around = density.around([0.0]);
        assert_eq!(density.sample(&around, [0.3, 0.6]), [0.3, 0.6]);
        assert_eq!(density.density(&around, [0.3, 0.6]), 1.0);
    }

    #[test]
    fn what_is_no_table_is_refused() {
        let new = |axis: &[f64], size, values: &[f32]| {
            ParametricGrid::new([axis.to_vec()], size, values.to_vec()).is_some()
        };
        assert!(new(&[0.0], [2, 2], &[1.0; 4]));
        assert!(!new(&[], [2, 2], &[]));
        assert!(!new(&[1.0, 1.0], [2, 2], &[1.0; 8]));
        assert!(!new(&[0.0], [1, 4], &[1.0; 4]));
        assert!(!new(&[0.0], [2, 2], &[1.0; 5]));
        assert!(!new(&[0.0], [2, 2], &[1.0, 1.0, 1.0, -1.0]));
        assert!(!new(&[0.0], [usize::MAX, 2], &[1.0; 4]));
    }
}
