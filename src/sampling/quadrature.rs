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

/// The i-th of places that fill the unit cube of N ≤ 4 dimensions evenly, however many there are: the
/// fractions of i φ⁻¹, i φ⁻², …, with the generalised golden ratio φᴺ⁺¹ = φ + 1 (Roberts, "The
/// Unreasonable Effectiveness of Quasirandom Sequences", 2018).
pub fn even_place<const N: usize>(i: u32) -> [f64; N] {
    const RATIOS: [f64; 4] =
        [1.618_033_988_749_895, 1.324_717_957_244_746, 1.220_744_084_605_759_5, 1.167_303_978_261_418_7];
    std::array::from_fn(|axis| (f64::from(i) * RATIOS[N - 1].powi(-1 - axis as i32)).fract())
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

    /// Every slab along every axis holds its share of the first places. Random places would miss it by 10 in
    /// the root mean square.
    #[test]
    fn places_are_even() {
        fn check<const N: usize>() {
            const SLABS: usize = 50;
            const EACH: u32 = 100;
            let mut counts = [[0; SLABS]; N];
            for i in 0..SLABS as u32 * EACH {
                let place = even_place::<N>(i);
                for (counts, x) in counts.iter_mut().zip(place) {
                    counts[(x * SLABS as f64) as usize] += 1;
                }
            }
            for count in counts.as_flattened() {
                assert!((90..=110).contains(count), "{N} dimensions: {count} of {EACH}");
            }
        }
        check::<1>();
        check::<2>();
        check::<3>();
        check::<4>();
    }

    #[test]
    fn midpoints_go_row_by_row() {
        let expected = [[0.25, 0.25], [0.75, 0.25], [0.25, 0.75], [0.75, 0.75]];
        assert_eq!(midpoints(2).collect::<Vec<_>>(), expected);
    }
}
