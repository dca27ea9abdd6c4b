use crate::lanes::{LANES, Mask, Row, ZERO, get, lanes_of, set};

/// A density that is constant within each cell of a grid, sampled by inversion: first the row, then the
/// column.
#[derive(Clone, Debug)]
pub struct PiecewiseConstantGrid {
    inversion: GridInversion,
}

/// Finds cells of a grid by their probabilities.
#[derive(Clone, Debug)]
pub(super) struct GridInversion {
    columns: usize,
    /// Row by row.
    cells: Vec<Cell>,
    rows: super::PiecewiseConstant,
    /// The probability of each row.
    of_rows: Vec<f64>,
    /// Row by row, for each of equal parts of the unit interval, the first column that reaches into it.
    guide: Vec<u32>,
    /// Parts of a row.
    parts: usize,
}

/// All that is asked of a cell, in one word: tables are larger than a processor's caches, and a sample waits
/// for each line of them. The upper half is the sum of probabilities up to and including the cell, in units
/// of 1 / [`UNITS`] of its row's. The lower half has a byte for each corner: what the density is there over
/// the most that it is at a corner of this cell.
type Cell = u64;

/// The probability of a row. All cells that have any probability have at least 1.
const UNITS: f64 = u32::MAX as f64;

/// What the density is at the corners of a cell, in any unit: a byte for each.
pub(super) type Corners = [u8; 4];

/// A cell that was found, in one row.
#[derive(Clone, Copy)]
pub(super) struct InRow {
    /// Columns with a fraction.
    pub x: f64,
    pub column: usize,
    /// The probability of the cell within the row.
    pub share: f64,
    pub corners: Corners,
}

/// What several lanes have found; see [`GridInversion::sample`].
pub(super) struct InLanes {
    /// Rows with fractions.
    pub y: Row,
    pub rows: [usize; LANES],
    pub in_rows: [InRow; LANES],
    /// The probability of the row.
    pub of_row: Row,
}

/// Columns for each part of the unit interval.
const COLUMNS_PER_PART: usize = 4;

/// Cells that a search looks at together: a cache line.
const TOGETHER: usize = 8;

impl GridInversion {
    /// From the integral over each cell, row by row, up to a common factor, and what is known of their
    /// corners. `None` unless they fill whole rows, none is negative or not finite, and their sum is positive
    /// and finite.
    pub(super) fn new(columns: usize, integrals: &[f64], corners: impl Fn(usize) -> Corners) -> Option<Self> {
        if columns == 0 || !integrals.len().is_multiple_of(columns) {
            return None;
        }
        let valid = integrals.iter().all(|&value| value >= 0.0 && value.is_finite());
        let sums: Vec<f64> = integrals.chunks(columns).map(|row| row.iter().sum()).collect();
        let edges = (0..=sums.len()).map(|edge| edge as f64).collect();
        let rows = super::PiecewiseConstant::new(edges, &sums).filter(|_| valid)?;
        let of_rows = (0..sums.len()).map(|row| rows.density(row as f64 + 0.5)).collect();
        let parts = columns.div_ceil(COLUMNS_PER_PART);
        let mut cells = Vec::with_capacity(integrals.len());
        let mut guide = Vec::with_capacity(sums.len() * parts);
        for (row, total) in integrals.chunks(columns).zip(sums) {
            let cumulative = in_units(row, total);
            let start = cells.len();
            cells.extend(
                (start..)
                    .zip(&cumulative)
                    .map(|(cell, &sum)| u64::from(sum) << 32 | u64::from(u32::from_le_bytes(corners(cell)))),
            );
            let mut column = 0;
            for part in 0..parts {
                let from = part as f64 / parts as f64 * UNITS;
                while column < columns && f64::from(cumulative[column]) <= from {
                    column += 1;
                }
                guide.push(column as u32);
            }
        }
        Some(Self { columns, cells, rows, of_rows, guide, parts })
    }

    /// The place up to which a fraction of the probability lies, for `u` in [0, 1)²: rows with a fraction,
    /// the row, its probability, and what was found in it.
    #[inline]
    pub(super) fn sample(&self, u: [f64; 2]) -> (f64, usize, f64, InRow) {
        let (y, row, probability) = self.row(u[1]);
        (y, row, probability, self.in_row(row, self.guess(row, u[0]), u[0]))
    }

    /// [`Self::sample`] for the lanes asked for. Each step is taken for all lanes, so that they wait for
    /// memory at the same time.
    #[inline]
    pub(super) fn sample_in_lanes(&self, u: &[Row; 2], asked: Mask) -> InLanes {
        let nothing = InRow { x: 0.0, column: 0, share: 0.0, corners: [0; 4] };
        let mut found = InLanes { y: ZERO, rows: [0; LANES], in_rows: [nothing; LANES], of_row: ZERO };
        let mut guesses = [0; LANES];
        for lane in lanes_of(asked) {
            let (y, row, probability) = self.row(get(&u[1], lane));
            set(&mut found.y, lane, y);
            set(&mut found.of_row, lane, probability);
            found.rows[lane] = row;
        }
        for lane in lanes_of(asked) {
            guesses[lane] = self.guess(found.rows[lane], get(&u[0], lane));
        }
        for lane in lanes_of(asked) {
            found.in_rows[lane] = self.in_row(found.rows[lane], guesses[lane], get(&u[0], lane));
        }
        found
    }

    /// The place up to which a fraction of the rows' probability lies, the row and its probability.
    #[inline(always)]
    fn row(&self, u: f64) -> (f64, usize, f64) {
        let (y, probability) = self.rows.sample(u);
        (y, (y as usize).min(self.of_rows.len() - 1), probability)
    }

    /// About the column up to which a fraction of a row's probability lies.
    #[inline(always)]
    fn guess(&self, row: usize, u: f64) -> usize {
        let part = ((u * self.parts as f64) as usize).min(self.parts - 1);
        self.guide[row * self.parts + part] as usize
    }

    /// The cell up to which a fraction of a row's probability lies. The search begins at a column.
    #[inline(always)]
    fn in_row(&self, row: usize, mut column: usize, u: f64) -> InRow {
        let cells = &self.cells[row * self.columns..(row + 1) * self.columns];
        let units = u * UNITS;
        // Cells up to this one end at `u` or before, whatever their corners are.
        let last = u64::from(units as u32) << 32 | u64::from(u32::MAX);
        // Rounding may lead into the part behind that of `u`.
        while column > 0 && cells[column - 1] > last {
            column -= 1;
        }
        // Without a branch for each cell, which would be mispredicted as often as not.
        while let Some(next) = cells.get(column..column + TOGETHER) {
            let passed = next.iter().map(|&cell| usize::from(cell <= last)).sum::<usize>();
            column += passed;
            if passed < TOGETHER {
                break;
            }
        }
        while column < self.columns && cells[column] <= last {
            column += 1;
        }
        let column = column.min(self.columns - 1);
        let (low, width) = span(cells, column);
        let fraction = if width > 0.0 { ((units - low) / width).clamp(0.0, 1.0) } else { 0.0 };
        InRow {
            x: column as f64 + fraction,
            column,
            share: width / UNITS,
            corners: corners_of(cells[column]),
        }
    }

    /// The probability of a cell within its row, and its corners.
    #[inline(always)]
    pub(super) fn cell(&self, column: usize, row: usize) -> (f64, Corners) {
        let cells = &self.cells[row * self.columns..(row + 1) * self.columns];
        (span(cells, column).1 / UNITS, corners_of(cells[column]))
    }

    /// The probability of a row.
    #[inline]
    pub(super) fn of_row(&self, row: usize) -> f64 {
        self.of_rows[row]
    }

    /// Columns and rows.
    #[inline]
    pub(super) fn size(&self) -> [usize; 2] {
        [self.columns, self.of_rows.len()]
    }
}

/// Sums of a row's integrals up to and with each, rounded to units that the row has [`UNITS`] of. Each
/// positive one gets at least one unit. All are zero where the row has nothing.
fn in_units(row: &[f64], total: f64) -> Vec<u32> {
    let mut left = row.iter().filter(|&&value| value > 0.0).count() as u32;
    let (mut sum, mut before) = (0.0, 0);
    let unit = |&value: &f64| {
        if value > 0.0 {
            sum += value;
            left -= 1;
            let rounded = (sum / total * UNITS).round() as u32;
            // What is left needs its units, too.
            before = if left == 0 { u32::MAX } else { rounded.max(before + 1).min(u32::MAX - left) };
        }
        before
    };
    row.iter().map(unit).collect()
}

/// Where a cell of a row begins, and its width, in units of the row.
#[inline(always)]
fn span(row: &[Cell], column: usize) -> (f64, f64) {
    let sum = |column: usize| (row[column] >> 32) as u32;
    let low = if column == 0 { 0 } else { sum(column - 1) };
    (f64::from(low), f64::from(sum(column) - low))
}

#[inline(always)]
fn corners_of(cell: Cell) -> Corners {
    (cell as u32).to_le_bytes()
}

impl PiecewiseConstantGrid {
    /// From the integral over each cell, row by row, up to a common factor. `None` unless they fill whole
    /// rows, none is negative or not finite, and their sum is positive and finite.
    pub fn new(columns: usize, integrals: &[f64]) -> Option<Self> {
        Some(Self { inversion: GridInversion::new(columns, integrals, |_| [1; 4])? })
    }

    /// The place up to which a fraction of the probability lies, as (column, row) with fractions, for `u` in
    /// [0, 1)², and the probability of the cell that it is in.
    pub fn sample(&self, u: [f64; 2]) -> ([f64; 2], f64) {
        let (y, _, of_row, found) = self.inversion.sample(u);
        ([found.x, y], of_row * found.share)
    }

    /// The probability of a cell.
    pub fn probability(&self, column: usize, row: usize) -> f64 {
        self.inversion.cell(column, row).0 * self.inversion.of_row(row)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::quadrature::midpoints;

    #[test]
    fn cells_are_met_as_often_as_their_probability_says() {
        const N: usize = 200;
        let weights = [0.0, 3.0, 1.0, 0.0, 0.0, 0.0, 4.0, 0.0, 2.0];
        let grid = PiecewiseConstantGrid::new(3, &weights).unwrap();
        let mut seen = [0.0; 9];
        for u in midpoints(N) {
            let ([x, y], probability) = grid.sample(u);
            let cell = (x.min(2.999) as usize, y.min(2.999) as usize);
            assert_eq!(probability, grid.probability(cell.0, cell.1));
            seen[cell.1 * 3 + cell.0] += 1.0 / (N * N) as f64;
        }
        for (seen, weight) in seen.into_iter().zip(weights) {
            assert!((seen - weight / 10.0).abs() < 0.01, "{seen} {weight}");
            assert_eq!(seen == 0.0, weight == 0.0);
        }
    }

    /// Inversion finds the column that a search over all of them finds, also where few cells have nearly all
    /// of the probability, where they have none, and where rounding leads to the wrong part of the guide.
    #[test]
    fn the_guide_leads_to_the_column_of_the_sample_value() {
        let uneven = |i: usize| match i % 7 {
            0 | 3 => 0.0,
            1 => 1e9,
            k => ((i * 31 + k) % 17) as f64 * 1e-3 + f64::from(i % 5 == 4),
        };
        for columns in [1usize, 3, 4, 5, 37, 196, 256] {
            for weights in [(0..3 * columns).map(uneven).collect(), vec![1.0; 3 * columns]] {
                let grid = GridInversion::new(columns, &weights, |cell| [cell as u8; 4]).unwrap();
                let sums: Vec<u32> = grid.cells.iter().map(|cell| (cell >> 32) as u32).collect();
                let edges = sums.iter().map(|&sum| f64::from(sum) / UNITS);
                let edges = edges.flat_map(|edge| [edge.next_down(), edge, edge.next_up()]);
                for u in edges.chain((0..500).map(|i| f64::from(i) / 500.0)) {
                    let u = u.clamp(0.0, 1f64.next_down());
                    for v in [0.01, 0.4, 0.99] {
                        let (_, row, _, InRow { x, column, corners, .. }) = grid.sample([u, v]);
                        let of_row = &sums[row * columns..(row + 1) * columns];
                        let passed = |&sum: &u32| sum <= (u * UNITS) as u32;
                        let expected = of_row.partition_point(passed).min(columns - 1);
                        assert_eq!(corners, [(row * columns + expected) as u8; 4]);
                        assert_eq!(column, expected, "{columns} columns, row {row}, {u}");
                        assert!((column as f64..=column as f64 + 1.0).contains(&x), "{x}");
                    }
                }
            }
        }
    }

    #[test]
    fn what_is_no_density_is_refused() {
        assert!(PiecewiseConstantGrid::new(2, &[0.0; 4]).is_none());
        assert!(PiecewiseConstantGrid::new(2, &[1.0; 3]).is_none());
        assert!(PiecewiseConstantGrid::new(2, &[1.0, -1.0]).is_none());
        // A cell however dark next to one however bright keeps a density.
        let uneven = PiecewiseConstantGrid::new(2, &[1e-60, 1.0]).unwrap();
        assert!(uneven.probability(0, 0) > 0.0);
    }
}
