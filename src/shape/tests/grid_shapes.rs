//! What the tests of sampled surfaces share.

use super::doubled::{Doubled, Polynomial};
use super::oracle::{Exact, any_ray, near};
use super::{Random, Shape};
use crate::geometry::Ray;
use rand::SeedableRng;

/// What a slow oracle knows of a line: its crossings in any order, and how near it is to having others or
/// fewer, as the smallest magnitude of the surface's function where it is extreme or goes from one polynomial
/// to the next.
pub struct Known {
    pub crossings: Vec<Exact>,
    pub doubt: f64,
}

/// How rays fared.
#[derive(Debug, Default)]
pub struct Tally {
    pub rays: u32,
    pub hits: usize,
    /// A touching point, or an edge that is one, was as near as rounding.
    pub doubtful: u32,
    /// Crossings without a bound on their error.
    pub unbounded: usize,
    /// The largest error over its bound, and over t.
    pub fraction: f64,
    pub relative: f64,
}

impl Tally {
    /// Compares crossings and nearest hits with the oracle's on rays of all kinds.
    pub fn check(&mut self, name: &str, shape: &Shape, rays: u32, seed: u64, known: impl Fn(&Ray) -> Known) {
        let mut random = Random::seed_from_u64(seed);
        let bounds = shape.bounds();
        for _ in 0..rays {
            let ray = any_ray(shape, bounds, &mut random);
            let found = shape.crossings(&ray);
            let Known { mut crossings, doubt } = known(&ray);
            crossings.sort_by(|a, b| (a.t - b.t).high.total_cmp(&0.0));
            self.rays += 1;
            self.hits += crossings.len();
            assert!(found.is_sorted_by(|a, b| a.hit.t <= b.hit.t), "{name}: {ray:?}\n{found:?}");
            let nearest = shape.intersect(&ray).map(|hit| hit.t);
            let first = found.iter().map(|crossing| crossing.hit.t).find(|&t| t >= 0.0);
            // The walk may begin in either of two cells.
            let same = match (nearest, first) {
                (Some(a), Some(b)) => (a - b).abs() <= 1e-14 * (1.0 + ray.origin.length()),
                _ => nearest == first,
            };
            assert!(same, "{name}: {ray:?} {nearest:?} {first:?}");
            let agrees = found.len() == crossings.len()
                && found.iter().zip(&crossings).all(|(crossing, exact)| {
                    let off = (Doubled::from(crossing.hit.t) - exact.t).high.abs();
                    crossing.enters == exact.enters && off <= crossing.error
                });
            if agrees {
                for (crossing, exact) in found.iter().zip(&crossings) {
                    let off = (Doubled::from(crossing.hit.t) - exact.t).high.abs();
                    self.unbounded += usize::from(crossing.error.is_infinite());
                    self.fraction = self.fraction.max(off / crossing.error);
                    if crossing.error < 1e-9 * crossing.hit.t.abs() {
                        self.relative = self.relative.max(off / crossing.hit.t.abs());
                    }
                }
                continue;
            }
            // Rounding of coordinates as far away as the ray starts.
            let rounding = 1e-13 * (1.0 + ray.origin.length());
            let exact: Vec<_> = crossings.iter().map(|exact| (exact.t.high, exact.enters)).collect();
            assert!(doubt <= rounding, "{name}: {ray:?}\n{found:?}\n{exact:?}\ndoubt {doubt}");
            self.doubtful += 1;
        }
    }

    /// That most was decided.
    pub fn judge(&self) {
        println!("{self:?}");
        assert!(self.hits as u32 > self.rays / 2 && self.doubtful < self.rays / 10, "{self:?}");
        assert!(self.unbounded < self.hits / 10, "{self:?}");
    }
}

/// Adds to what is known the roots of a function between two places; `exits` says that another polynomial
/// follows there.
pub fn add_roots(known: &mut Known, function: &Polynomial, ends: [Doubled; 2], ray: &Ray) {
    let range = ends.map(|end| end.high);
    for end in ends {
        known.doubt = known.doubt.min(function.at(end).high.abs());
    }
    let slope = function.derivative();
    for t in slope.roots(range) {
        known.doubt = known.doubt.min(function.at(t).high.abs());
    }
    for t in function.roots([range[0] - 1e-9, range[1] + 1e-9]) {
        if (t - ends[0]).high >= 0.0 && (ends[1] - t).high > 0.0 {
            let enters = slope.at(t).high < 0.0;
            known.crossings.push(Exact { t: t + near(ray).into(), enters });
        }
    }
}
