//! Whether sampled directions follow the density they claim.

use super::{ChiSquare, chi_square};
use crate::geometry::Vec3;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::Rng;
use std::f64::consts::TAU;

/// The sphere of directions cut into cells of equal solid angle: `rows` in z, `columns` in azimuth.
/// An even number of rows keeps the horizon on an edge, where densities are often discontinuous.
#[derive(Clone, Copy, Debug)]
pub struct SphereCells {
    /// Bands of equal height along the axis.
    pub rows: usize,
    /// Cells of equal width around it.
    pub columns: usize,
}

impl Default for SphereCells {
    fn default() -> Self {
        Self { rows: 20, columns: 40 }
    }
}

/// Draws `samples` directions and tests them against a density by chi-square.
///
/// `sample` turns three uniform numbers in [0, 1) into a direction (unit length), or `None` where
/// sampling fails: what the density lacks to 1 is expected to fail, and one that integrates to more
/// than 1 is refused (p = 0). `density` is per steradian and is
/// integrated over each cell by adaptive cubature, to about 1e-7 of the whole or 3e-5 of the cell. The
/// uniform numbers come from a generator with a fixed seed, so a result can be repeated.
pub fn sphere_chi_square(
    cells: SphereCells,
    samples: u64,
    sample: impl FnMut([f64; 3]) -> Option<Vec3>,
    density: impl Fn(Vec3) -> f64,
) -> ChiSquare {
    seeded(cells, samples, 0, sample, density)
}

fn seeded(
    cells: SphereCells,
    samples: u64,
    seed: u128,
    mut sample: impl FnMut([f64; 3]) -> Option<Vec3>,
    density: impl Fn(Vec3) -> f64,
) -> ChiSquare {
    let SphereCells { rows, columns } = cells;
    let mut observed = vec![0.0; rows * columns + 1];
    let mut generator = Pcg64::new(seed, 0);
    let mut uniform = || (generator.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
    for _ in 0..samples {
        let u = [uniform(), uniform(), uniform()];
        let cell = match sample(u) {
            Some(direction) => cells.cell_of(direction),
            None => rows * columns,
        };
        observed[cell] += 1.0;
    }
    let count = samples as f64;
    let expect = |cell: usize| {
        let expected = count * cells.integral(cell, &density, 1);
        // A lobe so narrow that it falls between the nodes is looked for where samples say it is.
        let surprising = (observed[cell] - expected).powi(2) > 25.0 * expected.max(1.0);
        if surprising { count * cells.integral(cell, &density, 6) } else { expected }
    };
    let mut expected: Vec<f64> = (0..rows * columns).map(expect).collect();
    // The cubature's own error must not look like an expected failure.
    let failures = count - expected.iter().sum::<f64>();
    expected.push(if failures.abs() < 1e-5 * count { 0.0 } else { failures });
    chi_square(&observed, &expected)
}

impl SphereCells {
    fn cell_of(&self, direction: Vec3) -> usize {
        let row = 0.5 * (direction.z + 1.0) * self.rows as f64;
        let azimuth = (direction.y.atan2(direction.x) / TAU).rem_euclid(1.0);
        let index = |position: f64, count: usize| (position.max(0.0) as usize).min(count - 1);
        index(row, self.rows) * self.columns + index(azimuth * self.columns as f64, self.columns)
    }

    /// The integral of `density` over one cell, whose sides are halved `halvings` times at least.
    fn integral(&self, cell: usize, density: &impl Fn(Vec3) -> f64, halvings: u32) -> f64 {
        let (row, column) = (cell / self.columns, cell % self.columns);
        let polar = |row: usize| (2.0 * row as f64 / self.rows as f64 - 1.0).clamp(-1.0, 1.0).acos();
        let azimuth = |column: usize| TAU * column as f64 / self.columns as f64;
        // Over polar angle rather than z, in which a lobe at the pole is smooth.
        let f = |theta: f64, phi: f64| {
            let (sin, cos) = theta.sin_cos();
            sin * density(Vec3::new(sin * phi.cos(), sin * phi.sin(), cos))
        };
        let patch = Patch { x: [polar(row + 1), polar(row)], y: [azimuth(column), azimuth(column + 1)] };
        patch.adaptive(&f, patch.gauss(&f), 1e-7, halvings, MAX_HALVINGS)
    }
}

/// How often a cell's sides are halved at most: down to 1/1024 of a cell.
const MAX_HALVINGS: u32 = 10;

/// Error allowed in a patch's integral, relative to it: far below what any count could tell.
const RELATIVE: f64 = 3e-5;

/// A rectangle to integrate over.
#[derive(Clone, Copy)]
struct Patch {
    x: [f64; 2],
    y: [f64; 2],
}

impl Patch {
    /// The integral of `f`, given its estimate over the whole patch, by halving both sides at least
    /// `least` and at most `most` times until the estimates agree to `tolerance`.
    fn adaptive(
        &self,
        f: &impl Fn(f64, f64) -> f64,
        whole: f64,
        tolerance: f64,
        least: u32,
        most: u32,
    ) -> f64 {
        let quarters = self.quarters();
        let parts = quarters.map(|quarter| quarter.gauss(f));
        let sum: f64 = parts.iter().sum();
        let difference = (sum - whole).abs();
        if most <= 1 || !difference.is_finite() || (least <= 1 && difference <= tolerance + RELATIVE * sum) {
            return sum;
        }
        let refine = |(quarter, part): (Patch, f64)| {
            quarter.adaptive(f, part, 0.5 * tolerance, least.saturating_sub(1), most - 1)
        };
        quarters.into_iter().zip(parts).map(refine).sum()
    }

    fn quarters(&self) -> [Patch; 4] {
        let ([x0, x2], [y0, y2]) = (self.x, self.y);
        let (x1, y1) = (0.5 * (x0 + x2), 0.5 * (y0 + y2));
        [
            Patch { x: [x0, x1], y: [y0, y1] },
            Patch { x: [x1, x2], y: [y0, y1] },
            Patch { x: [x0, x1], y: [y1, y2] },
            Patch { x: [x1, x2], y: [y1, y2] },
        ]
    }

    /// Gauss–Legendre cubature with 5 × 5 nodes (closed forms of the quadrature's nodes and weights).
    fn gauss(&self, f: &impl Fn(f64, f64) -> f64) -> f64 {
        let spread = 2.0 * (10.0f64 / 7.0).sqrt();
        let (inner, outer) = ((5.0 - spread).sqrt() / 3.0, (5.0 + spread).sqrt() / 3.0);
        let (heavy, light) = ((322.0 + 13.0 * 70f64.sqrt()) / 900.0, (322.0 - 13.0 * 70f64.sqrt()) / 900.0);
        let rule = [(-outer, light), (-inner, heavy), (0.0, 128.0 / 225.0), (inner, heavy), (outer, light)];
        let (width, height) = (0.5 * (self.x[1] - self.x[0]), 0.5 * (self.y[1] - self.y[0]));
        let (x, y) = (self.x[0] + width, self.y[0] + height);
        let mut sum = 0.0;
        for (a, weight_a) in rule {
            for (b, weight_b) in rule {
                sum += weight_a * weight_b * f(x + a * width, y + b * height);
            }
        }
        sum * width * height
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn cosine_hemisphere(u: [f64; 3]) -> Vec3 {
        let radius = u[0].sqrt();
        let (sin, cos) = (TAU * u[1]).sin_cos();
        Vec3::new(radius * cos, radius * sin, (1.0 - u[0]).sqrt())
    }

    fn uniform_sphere(u: [f64; 3]) -> Vec3 {
        let z = 1.0 - 2.0 * u[0];
        let radius = (1.0 - z * z).sqrt();
        let (sin, cos) = (TAU * u[1]).sin_cos();
        Vec3::new(radius * cos, radius * sin, z)
    }

    #[test]
    fn right_densities_pass() {
        let cells = SphereCells::default();
        let fit = sphere_chi_square(cells, 200_000, |u| Some(uniform_sphere(u)), |_| 0.25 / PI);
        assert!(fit.p_value > 0.01, "{fit}");
        let fit = sphere_chi_square(cells, 200_000, |u| Some(cosine_hemisphere(u)), |w| w.z.max(0.0) / PI);
        assert!(fit.p_value > 0.01, "{fit}");
    }

    /// Samples that fail count against the density's missing mass.
    #[test]
    fn failures_are_a_cell() {
        let thinned = |u: [f64; 3]| (u[2] < 0.7).then(|| cosine_hemisphere(u));
        let fit = sphere_chi_square(SphereCells::default(), 200_000, thinned, |w| 0.7 * w.z.max(0.0) / PI);
        assert!(fit.p_value > 0.01, "{fit}");
        let fit = sphere_chi_square(SphereCells::default(), 200_000, thinned, |w| w.z.max(0.0) / PI);
        assert!(fit.p_value < 1e-9, "{fit}");
    }

    /// The harness can fail: a uniform hemisphere, a slightly steeper cosine, a density too large by
    /// 2 %, and an infinite one are all refused for cosine samples.
    #[test]
    fn wrong_densities_fail() {
        let refuses = |name: &str, density: fn(Vec3) -> f64| {
            let sample = |u: [f64; 3]| Some(cosine_hemisphere(u));
            let fit = sphere_chi_square(SphereCells::default(), 200_000, sample, density);
            assert!(fit.p_value < 1e-6, "{name}: {fit}");
        };
        refuses("uniform", |w| if w.z > 0.0 { 0.5 / PI } else { 0.0 });
        refuses("steeper", |w| 2.1 / TAU * w.z.max(0.0).powf(1.1));
        refuses("too large", |w| 1.02 * w.z.max(0.0) / PI);
        refuses("infinite", |w| if w.z > 0.0 { f64::INFINITY } else { 0.0 });
    }

    /// Over many draws the p-values of a right density are uniform.
    #[test]
    fn p_values_are_uniform() {
        let cells = SphereCells { rows: 4, columns: 8 };
        let p_value =
            |seed| seeded(cells, 2000, seed, |u| Some(cosine_hemisphere(u)), |w| w.z.max(0.0) / PI).p_value;
        let p_values: Vec<f64> = (0..200).map(p_value).collect();
        let law = crate::stats::uniformity(&p_values);
        assert!(law.p_value > 1e-3, "{law}");
    }
}
