//! Poisson disk patterns: points as random as they can be with none nearer to another than a radius. On the
//! unit torus, so that a pattern may be shifted and repeated.

use super::cells::{Cells, Keys};
use super::permutation::permute;
use super::{inside, mix, warp};
use crate::geometry::Vec3;
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::{FRAC_1_SQRT_2, TAU};

/// Points of a pattern made at once, at most: longer sequences repeat it over the square.
const LARGEST: u32 = 256;

/// Patterns that the sequences of a render take turns with.
const PATTERNS: usize = 32;

/// Number of points times squared radius that boundary sampling reaches.
const DENSITY: f64 = 0.81;

/// Candidates on the boundary of a point's disc before it is given up.
const CANDIDATES: u32 = 30;

/// Points on the unit torus, none nearer to another than `radius`.
#[derive(Clone, Debug)]
pub struct Pattern {
    /// Least distance of two points.
    pub radius: f64,
    /// The points, in the unit square.
    pub points: Vec<[f64; 2]>,
    /// What it took: tries to extend the pattern, or darts thrown.
    pub iterations: u64,
}

/// The square of the distance on the unit torus.
pub fn distance_squared(a: [f64; 2], b: [f64; 2]) -> f64 {
    let along = |axis: usize| {
        let d = (a[axis] - b[axis]).abs();
        d.min(1.0 - d)
    };
    along(0).powi(2) + along(1).powi(2)
}

/// Boundary sampling (Dunbar and Humphreys, "A spatial data structure for fast Poisson-disk sample
/// generation", ACM TOG 25(3), 2006, with the cells of Bridson, "Fast Poisson disk sampling in arbitrary
/// dimensions", 2007): new points lie on the boundary of a point's disc, so the pattern is dense. Each
/// iteration adds a point or gives one up: 2N − 1 for N points.
pub fn boundary(radius: f64, random: &mut impl Rng) -> Pattern {
    let mut field = Field::new(radius);
    field.insert([random.random(), random.random()]);
    let mut active = vec![0];
    let mut iterations = 0;
    while !active.is_empty() {
        iterations += 1;
        let chosen = random.random_range(0..active.len());
        let [x, y] = field.points[active[chosen]];
        let found = (0..CANDIDATES).find_map(|_| {
            let (sin, cos) = (TAU * random.random::<f64>()).sin_cos();
            // Rounding must not bring the candidate into the disc that it lies on.
            let reach = radius * (1.0 + 1e-12);
            let candidate = [wrap(x + reach * cos), wrap(y + reach * sin)];
            field.is_free(candidate).then_some(candidate)
        });
        match found {
            Some(candidate) => {
                active.push(field.points.len());
                field.insert(candidate);
            }
            None => {
                active.swap_remove(chosen);
            }
        }
    }
    // The last point given up began as the first: one iteration fewer adds than removes.
    Pattern { radius, points: field.points, iterations }
}

/// Dart throwing: uniform points, kept where they are free, until `misses` in a row are not (Cook 1986,
/// section 3).
pub fn darts(radius: f64, misses: u32, random: &mut impl Rng) -> Pattern {
    let mut field = Field::new(radius);
    let (mut iterations, mut missed) = (0, 0);
    while missed < misses {
        iterations += 1;
        let candidate = [random.random(), random.random()];
        if field.is_free(candidate) {
            field.insert(candidate);
            missed = 0;
        } else {
            missed += 1;
        }
    }
    Pattern { radius, points: field.points, iterations }
}

/// Mitchell's best candidates ("Spectrally optimal sampling for distribution ray tracing", SIGGRAPH 1991):
/// each point is the one farthest from all before it among `per_point` random ones for each point there is
/// already.
pub fn best_candidates(count: usize, per_point: usize, random: &mut impl Rng) -> Vec<[f64; 2]> {
    let mut points: Vec<[f64; 2]> = Vec::with_capacity(count);
    while points.len() < count {
        let candidates = (0..1 + per_point * points.len()).map(|_| [random.random(), random.random()]);
        let gap = |candidate| points.iter().map(|&p| distance_squared(p, candidate)).fold(2.0, f64::min);
        let best = candidates.map(|c| (gap(c), c)).max_by(|a, b| a.0.total_cmp(&b.0));
        points.extend(best.map(|(_, candidate)| candidate));
    }
    points
}

/// Points on the unit sphere, each the farthest from all before it among `per_point` random ones for each
/// point there is already. By the straight distance: the great-circle distance orders the candidates alike.
pub fn best_on_sphere(count: usize, per_point: usize, random: &mut impl Rng) -> Vec<Vec3> {
    let mut points: Vec<Vec3> = Vec::with_capacity(count);
    while points.len() < count {
        let candidates = (0..1 + per_point * points.len())
            .map(|_| warp::around_z(random.random_range(-1.0..1.0), random.random()));
        let gap = |candidate: Vec3| {
            points.iter().map(|point| point.distance_squared(candidate)).fold(4.0, f64::min)
        };
        let best = candidates.map(|candidate| (gap(candidate), candidate)).max_by(|a, b| a.0.total_cmp(&b.0));
        points.extend(best.map(|(_, candidate)| candidate));
    }
    points
}

/// Points of a pattern so far, in cells too small for two of them.
struct Field {
    radius: f64,
    edge: usize,
    /// Number of the point in each cell, counted from 1.
    cells: Vec<u32>,
    points: Vec<[f64; 2]>,
}

impl Field {
    fn new(radius: f64) -> Self {
        let edge = (1.0 / (radius * FRAC_1_SQRT_2)).ceil() as usize;
        Self { radius, edge, cells: vec![0; edge * edge], points: Vec::new() }
    }

    fn cell(&self, point: [f64; 2]) -> [usize; 2] {
        point.map(|x| ((x * self.edge as f64) as usize).min(self.edge - 1))
    }

    fn insert(&mut self, point: [f64; 2]) {
        self.points.push(point);
        let [x, y] = self.cell(point);
        self.cells[y * self.edge + x] = self.points.len() as u32;
    }

    fn is_free(&self, point: [f64; 2]) -> bool {
        let [x, y] = self.cell(point);
        // Two cells either way hold whatever is nearer than the radius; few cells are all looked at.
        let around = |at: usize| {
            let (first, count) = if self.edge < 5 { (0, self.edge) } else { (at + self.edge - 2, 5) };
            (0..count).map(move |step| (first + step) % self.edge)
        };
        around(y).all(|row| {
            around(x).all(|column| match self.cells[row * self.edge + column] {
                0 => true,
                number => {
                    let near = distance_squared(self.points[number as usize - 1], point);
                    near >= self.radius * self.radius
                }
            })
        })
    }
}

/// Wraps a coordinate onto the unit torus.
fn wrap(x: f64) -> f64 {
    let wrapped = x - x.floor();
    if wrapped < 1.0 { wrapped } else { 0.0 }
}

/// The patterns of a render.
#[derive(Clone, Debug)]
pub(super) struct Patterns {
    /// Copies of a pattern along each side of the square.
    copies: u32,
    /// Points of each pattern. All copies together hold a sequence, or hardly more.
    size: u32,
    patterns: Vec<Vec<[f64; 2]>>,
}

impl Patterns {
    pub(super) fn new(samples: u32, seed: u64) -> Self {
        let samples = samples.max(1);
        let copies = f64::from(samples.div_ceil(LARGEST)).sqrt().ceil() as u32;
        let size = samples.div_ceil(copies * copies);
        let patterns = (0..PATTERNS)
            .map(|number| {
                let key = mix(seed ^ mix(u64::from(samples) << 32 | number as u64));
                exactly(size as usize, &mut Pcg64Mcg::seed_from_u64(key))
            })
            .collect();
        Self { copies, size, patterns }
    }

    /// Points of one of the patterns with a shift and an order of the set's own; the last two dimensions in
    /// slices.
    pub(super) fn sample(&self, cells: Cells, index: u32, key: u64) -> [f64; 4] {
        let keys = Keys::new(key);
        let chosen = mix(keys.pair);
        let shift = mix(chosen);
        let pattern = &self.patterns[chosen as usize % PATTERNS];
        let place = permute(index, self.size * self.copies * self.copies, keys.pair);
        let (copy, point) = (place / self.size, pattern[(place % self.size) as usize]);
        let copies = f64::from(self.copies);
        let axis = |axis: usize, copy: u32, shift: u32| {
            inside(wrap((f64::from(copy) + point[axis]) / copies + super::unit(shift)))
        };
        let x = axis(0, copy % self.copies, shift as u32);
        let y = axis(1, copy / self.copies, (shift >> 32) as u32);
        let [z, w] = cells.slices(index, &keys);
        [x, y, z, w]
    }
}

/// A pattern of just so many points.
fn exactly(count: usize, random: &mut impl Rng) -> Vec<[f64; 2]> {
    /// Patterns made in search of one of the right size: at the density of boundary sampling about one in ten
    /// is.
    const TRIES: usize = 100;
    if count < 2 {
        return vec![[0.5; 2]; count];
    }
    let mut radius = (DENSITY / count as f64).sqrt();
    for attempt in 0.. {
        let mut pattern = boundary(radius, random);
        let found = pattern.points.len();
        if found == count || (attempt >= TRIES && found > count) {
            // Where some are too many, those go that came last.
            pattern.points.truncate(count);
            return pattern.points;
        }
        // Few points fit the torus or don't: the radius follows what was found.
        let change: f64 = if found > count { 1.002 } else { 0.998 };
        radius *= change;
    }
    Vec::new()
}
