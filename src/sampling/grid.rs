/// A density that is constant within each cell of a grid, sampled by inversion: first the row, then the
/// column.
#[derive(Clone, Debug)]
pub struct PiecewiseConstantGrid {
    columns: usize,
    /// Row by row, the probability of each cell within its row.
    probabilities: Vec<f32>,
    /// Row by row, the sum of probabilities up to and including each column.
    cumulative: Vec<f64>,
    rows: super::PiecewiseConstant,
}

impl PiecewiseConstantGrid {
    /// From the integral over each cell, row by row, up to a common factor. `None` unless they fill whole
    /// rows, none is negative or not finite, and their sum is positive and finite.
    pub fn new(columns: usize, integrals: &[f64]) -> Option<Self> {
        if columns == 0 || !integrals.len().is_multiple_of(columns) {
            return None;
        }
        let valid = integrals.iter().all(|&value| value >= 0.0 && value.is_finite());
        let sums: Vec<f64> = integrals.chunks(columns).map(|row| row.iter().sum()).collect();
        let edges = (0..=sums.len()).map(|edge| edge as f64).collect();
        let rows = super::PiecewiseConstant::new(edges, &sums).filter(|_| valid)?;
        let mut cumulative = Vec::with_capacity(integrals.len());
        let mut probabilities = Vec::with_capacity(integrals.len());
        for (row, total) in integrals.chunks(columns).zip(sums) {
            let mut sum = 0.0;
            for value in row {
                sum += value;
                cumulative.push(if total > 0.0 { sum / total } else { 0.0 });
                probabilities.push(if total > 0.0 { smallest_positive(value / total) } else { 0.0 });
            }
        }
        Some(Self { columns, probabilities, cumulative, rows })
    }

    /// The place up to which a fraction of the probability lies, as (column, row) with fractions, for `u` in
    /// [0, 1)², and the probability of the cell that it is in.
    pub fn sample(&self, u: [f64; 2]) -> ([f64; 2], f64) {
        let (y, probability) = self.rows.sample(u[1]);
        let row = (y as usize).min(self.probabilities.len() / self.columns - 1);
        let cells = row * self.columns..(row + 1) * self.columns;
        let cumulative = &self.cumulative[cells.clone()];
        let column = cumulative.partition_point(|&sum| sum <= u[0]).min(self.columns - 1);
        let low = if column == 0 { 0.0 } else { cumulative[column - 1] };
        let width = cumulative[column] - low;
        let fraction = if width > 0.0 { ((u[0] - low) / width).clamp(0.0, 1.0) } else { 0.0 };
        ([column as f64 + fraction, y], probability * f64::from(self.probabilities[cells][column]))
    }

    /// The probability of a cell.
    pub fn probability(&self, column: usize, row: usize) -> f64 {
        let fraction = f64::from(self.probabilities[row * self.columns + column]);
        fraction * self.rows.density(row as f64 + 0.5)
    }
}

/// The value in single precision, but zero only for zero.
fn smallest_positive(value: f64) -> f32 {
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
