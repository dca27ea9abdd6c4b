//! Integrals without chance.

use std::f64::consts::PI;

/// Nodes and weights of Gauss and Legendre's rule for integrals over [-1, 1], by Newton's method on the
/// Legendre polynomial of degree `count`, at least 1.
pub fn gauss_legendre(count: usize) -> impl Iterator<Item = (f64, f64)> {
    (0..count).map(move |i| {
        let mut x = (PI * (i as f64 + 0.75) / (count as f64 + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..10 {
            let (mut previous, mut value) = (1.0, x);
            for k in 2..=count {
                let k = k as f64;
                (previous, value) = (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * previous) / k);
            }
            slope = count as f64 * (x * value - previous) / (x * x - 1.0);
            x -= value / slope;
        }
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    })
}

/// The centres of `side`² equal squares of the unit square, row by row: the nodes of the midpoint rule.
pub fn midpoints(side: usize) -> impl Iterator<Item = [f64; 2]> {
    let place = move |i: usize| [i % side, i / side].map(|k| (k as f64 + 0.5) / side as f64);
    (0..side * side).map(place)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Exact for polynomials up to degree 2 n − 1.
    #[test]
    fn exact_for_polynomials() {
        for count in [1, 2, 5, 32, 64] {
            for power in 0..2 * count as i32 {
                let sum: f64 =
                    gauss_legendre(count).map(|(x, weight)| weight * (0.5 + 0.5 * x).powi(power)).sum();
                let expected = 2.0 / f64::from(power + 1);
                assert!((sum - expected).abs() < 1e-13, "{count} nodes, power {power}: {sum}");
            }
        }
    }

    #[test]
    fn midpoints_go_row_by_row() {
        let expected = [[0.25, 0.25], [0.75, 0.25], [0.25, 0.75], [0.75, 0.75]];
        assert_eq!(midpoints(2).collect::<Vec<_>>(), expected);
    }
}
