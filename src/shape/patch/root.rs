//! Subdomains of the unit square, and the roots of F (see [`super::intersection`]).

use super::bicubic::Bicubic;
use super::intersection::NOISE;
use glam::DVec2;
use smallvec::SmallVec;

/// A subdomain is degenerate if F maps it to no more than this in both directions of the plane.
pub const DEGENERATE: f64 = 4.0 * NOISE;

/// The corners of the box around the coefficients.
pub fn hull(bicubic: &Bicubic<DVec2>) -> (DVec2, DVec2) {
    bicubic
        .all()
        .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), point| (low.min(point), high.max(point)))
}

/// A rectangle of the unit square.
#[derive(Clone, Copy, Debug)]
pub struct Subdomain {
    pub from: [f64; 2],
    pub size: [f64; 2],
}

impl Subdomain {
    pub fn sides(&self, axis: usize) -> [f64; 2] {
        [self.from[axis], self.from[axis] + self.size[axis]]
    }

    fn middle(&self) -> [f64; 2] {
        [0, 1].map(|axis| self.from[axis] + 0.5 * self.size[axis])
    }

    /// The part with what is between it and the square's nearer edge along an axis, and that edge.
    fn up_to_edge(mut self, axis: usize) -> (Self, f64) {
        let [from, to] = self.sides(axis);
        let edge = if from <= 1.0 - to { 0.0 } else { 1.0 };
        if edge == 0.0 {
            self.from[axis] = 0.0;
            self.size[axis] = to;
        } else {
            self.size[axis] = 1.0 - from;
        }
        (self, edge)
    }

    /// Whether nothing as large as either is between them.
    fn is_beside(&self, other: &Self) -> bool {
        (0..2).all(|axis| {
            let between = (self.from[axis] - other.from[axis] - other.size[axis])
                .max(other.from[axis] - self.from[axis] - self.size[axis]);
            between < self.size[axis].min(other.size[axis])
        })
    }

    /// The rectangle around both.
    fn with(&self, other: &Self) -> Self {
        let from = [0, 1].map(|axis| self.from[axis].min(other.from[axis]));
        let to =
            [0, 1].map(|axis| (self.from[axis] + self.size[axis]).max(other.from[axis] + other.size[axis]));
        Self { from, size: [to[0] - from[0], to[1] - from[1]] }
    }
}

/// Parts that lie together as one: what is as small as rounding can't be told from its neighbours.
pub fn joined(parts: &[Subdomain]) -> SmallVec<[Subdomain; 2]> {
    let mut found: SmallVec<[Subdomain; 2]> = SmallVec::new();
    for &part in parts {
        let mut whole = part;
        loop {
            let apart = found.len();
            found.retain(|other| {
                let beside = whole.is_beside(other);
                if beside {
                    whole = whole.with(other);
                }
                !beside
            });
            // Larger by now, it may be beside others.
            if found.len() == apart {
                break;
            }
        }
        found.push(whole);
    }
    found
}

/// A root of F.
#[derive(Clone, Copy, Debug)]
pub struct Root {
    /// Parameters u and v, outside the unit square by no more than `spread`.
    pub at: [f64; 2],
    /// By how much u and v may be off.
    pub spread: [f64; 2],
    /// Determinant of F's derivative.
    pub determinant: f64,
    /// The degenerate region that holds the root, if it lies in one: F maps all of it to as little as
    /// rounding.
    pub degenerate: Option<Subdomain>,
}

impl Root {
    /// In the middle of the part, or on the square's border if what is between is as small: the line may as
    /// well pass beside it.
    pub fn degenerate(seen: &Bicubic<DVec2>, mut part: Subdomain) -> Self {
        let mut at = part.middle();
        let [along_u, along_v] = seen.slopes(at);
        // If it can be, along the side that is shorter: of the other parameter the middle says more about the
        // normal.
        let shorter = usize::from(part.size[1] < part.size[0]);
        for axis in [shorter, 1 - shorter] {
            let (wider, edge) = part.up_to_edge(axis);
            let (low, high) = hull(&seen.part([0, 1].map(|axis| wider.sides(axis))));
            if part.sides(axis).contains(&edge) || (high - low).max_element() <= 2.0 * DEGENERATE {
                part = wider;
                at[axis] = edge;
                break;
            }
        }
        Self { at, spread: part.size, determinant: along_u.perp_dot(along_v), degenerate: Some(part) }
    }
}
