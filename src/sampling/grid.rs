use crate::lanes::{LANES, Mask, Row, ZERO, get, lanes_of, set};

/// A density that is constant within each cell of a grid, sampled by inversion: first the row, then the
/// column.
#[derive(Clone, Debug)]
pub struct PiecewiseConstantGrid {
    inversion: GridInversion,
    /// Row by row, the probability of each cell within its row.
    probabilities: Vec<f32>,
}

/// Finds cells of a grid by their probabilities.
#[derive(Clone, Debug)]
pub(super) struct GridInversion {
    columns: usize,
    /// Row by row, the sum of probabilities up to and including each column.
    cumulative: Vec<f64>,
    rows: super::PiecewiseConstant,
    /// The probability of each row.
    of_rows: Vec<f64>,
    /// Row by row, for each of equal parts of the unit interval, the first column that reaches into it.
    guide: Vec<u32>,
    /// Parts of a row.
    parts: usize,
}

/// What several lanes have found; see [`GridInversion::sample`].
pub(super) struct InLanes {
    /// Columns and rows with fractions.
    pub place: [Row; 2],
    /// Column and row of each lane.
    pub cells: [[usize; 2]; LANES],
    /// The probability of the row.
    pub of_row: Row,
}

/// Columns for each part of the unit interval. Their sums fill half a cache line.
const COLUMNS_PER_PART: usize = 4;

impl GridInversion {
    /// From the integral over each cell, row by row, up to a common factor, with the probability of each cell
    /// within its row. `None` unless they fill whole rows, none is negative or not finite, and their sum is
    /// positive and finite.
    pub(super) fn new(columns: usize, integrals: &[f64]) -> Option<(Self, Vec<f32>)> {
        if columns == 0 || !integrals.len().is_multiple_of(columns) {
            return None;
        }
        let valid = integrals.iter().all(|&value| value >= 0.0 && value.is_finite());
        let sums: Vec<f64> = integrals.chunks(columns).map(|row| row.iter().sum()).collect();
        let edges = (0..=sums.len()).map(|edge| edge as f64).collect();
        let rows = super::PiecewiseConstant::new(edges, &sums).filter(|_| valid)?;
        let of_rows = (0..sums.len()).map(|row| rows.density(row as f64 + 0.5)).collect();
        let parts = columns.div_ceil(COLUMNS_PER_PART);
        let mut cumulative = Vec::with_capacity(integrals.len());
        let mut probabilities = Vec::with_capacity(integrals.len());
        let mut guide = Vec::with_capacity(sums.len() * parts);
        for (row, total) in integrals.chunks(columns).zip(sums) {
            let mut sum = 0.0;
            let start = cumulative.len();
            for value in row {
                sum += value;
                cumulative.push(if total > 0.0 { sum / total } else { 0.0 });
                probabilities.push(if total > 0.0 { smallest_positive(value / total) } else { 0.0 });
            }
            let mut column = 0;
            for part in 0..parts {
                while column < columns && cumulative[start + column] <= part as f64 / parts as f64 {
                    column += 1;
                }
                guide.push(column as u32);
            }
        }
        Some((Self { columns, cumulative, rows, of_rows, guide, parts }, probabilities))
    }

    /// The place up to which a fraction of the probability lies, as (column, row) with fractions, for `u` in
    /// [0, 1)², the cell that it is in, and the probability of its row.
    #[inline]
    pub(super) fn sample(&self, u: [f64; 2]) -> ([f64; 2], [usize; 2], f64) {
        let (y, row, probability) = self.row(u[1]);
        let (x, column) = self.column(row, self.guess(row, u[0]), u[0]);
        ([x, y], [column, row], probability)
    }

    /// [`Self::sample`] for the lanes asked for. The tables are larger than a processor's caches: each step is
    /// taken for all lanes, so that they wait for memory at the same time.
    #[inline]
    pub(super) fn sample_in_lanes(&self, u: &[Row; 2], asked: Mask) -> InLanes {
        let mut found = InLanes { place: [ZERO; 2], cells: [[0; 2]; LANES], of_row: ZERO };
        let mut guesses = [0; LANES];
        for lane in lanes_of(asked) {
            let (y, row, probability) = self.row(get(&u[1], lane));
            set(&mut found.place[1], lane, y);
            set(&mut found.of_row, lane, probability);
            found.cells[lane][1] = row;
        }
        for lane in lanes_of(asked) {
            guesses[lane] = self.guess(found.cells[lane][1], get(&u[0], lane));
        }
        for lane in lanes_of(asked) {
            let (x, column) = self.column(found.cells[lane][1], guesses[lane], get(&u[0], lane));
            set(&mut found.place[0], lane, x);
            found.cells[lane][0] = column;
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

    /// The place up to which a fraction of a row's probability lies, and the column. The search begins at a
    /// column.
    #[inline(always)]
    fn column(&self, row: usize, mut column: usize, u: f64) -> (f64, usize) {
        let cumulative = &self.cumulative[row * self.columns..(row + 1) * self.columns];
        // Rounding may lead into the part behind that of `u`.
        while column > 0 && cumulative[column - 1] > u {
            column -= 1;
        }
        while column < self.columns && cumulative[column] <= u {
            column += 1;
        }
        let column = column.min(self.columns - 1);
        let low = if column == 0 { 0.0 } else { cumulative[column - 1] };
        let width = cumulative[column] - low;
        let fraction = if width > 0.0 { ((u - low) / width).clamp(0.0, 1.0) } else { 0.0 };
        (column as f64 + fraction, column)
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

impl PiecewiseConstantGrid {
    /// From the integral over each cell, row by row, up to a common factor. `None` unless they fill whole
    /// rows, none is negative or not finite, and their sum is positive and finite.
    pub fn new(columns: usize, integrals: &[f64]) -> Option<Self> {
        let (inversion, probabilities) = GridInversion::new(columns, integrals)?;
        Some(Self { inversion, probabilities })
    }

    /// The place up to which a fraction of the probability lies, as (column, row) with fractions, for `u` in
    /// [0, 1)², and the probability of the cell that it is in.
    pub fn sample(&self, u: [f64; 2]) -> ([f64; 2], f64) {
        let (place, [column, row], of_row) = self.inversion.sample(u);
        (place, of_row * self.within_row(column, row))
    }

    /// The probability of a cell.
    pub fn probability(&self, column: usize, row: usize) -> f64 {
        self.within_row(column, row) * self.inversion.of_row(row)
    }

    fn within_row(&self, column: usize, row: usize) -> f64 {
        f64::from(self.probabilities[row * self.inversion.size()[0] + column])
    }
}

/// The value in single precision, but zero only for zero.
pub(super) fn smallest_positive(value: f64) -> f32 {
    if value > 0.0 { (value as f32).max(f32::MIN_POSITIVE) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_met_as_often_as_their_probability_says() {
        let weights = [0.0, 3.0, 1.0, 0.0, 0.0, 0.0, 4.0, 0.0, 2.0];
        let grid = PiecewiseConstantGrid::new(3, &weights).unwrap();
        let n = 200;
        let mut seen = [0.0; 9];
        for i in 0..n {
            for j in 0..n {
                let u = [i, j].map(|k| (f64::from(k) + 0.5) / f64::from(n));
                let ([x, y], probability) = grid.sample(u);
                let cell = (x.min(2.999) as usize, y.min(2.999) as usize);
                assert_eq!(probability, grid.probability(cell.0, cell.1));
                seen[cell.1 * 3 + cell.0] += 1.0 / f64::from(n * n);
            }
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
                let (grid, _) = GridInversion::new(columns, &weights).unwrap();
                let edges = grid.cumulative.iter().flat_map(|&edge| [edge.next_down(), edge, edge.next_up()]);
                for u in edges.chain((0..500).map(|i| f64::from(i) / 500.0)) {
                    let u = u.clamp(0.0, 1f64.next_down());
                    for v in [0.01, 0.4, 0.99] {
                        let ([x, _], [column, row], _) = grid.sample([u, v]);
                        let sums = &grid.cumulative[row * columns..(row + 1) * columns];
                        let expected = sums.partition_point(|&sum| sum <= u).min(columns - 1);
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
