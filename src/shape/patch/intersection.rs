//! Where a line meets a bicubic patch.
//!
//! Seen along the line the patch is a map F of the unit square to the plane, a bicubic in Bernstein form, and
//! the line meets it where F = 0: where two bicubics vanish at once (Kajiya, "Ray Tracing Parametric
//! Patches", SIGGRAPH 1982; Glassner, *An Introduction to Ray Tracing*, ch. 3, 3.2). The square is halved
//! until of each part it is certain what is in it:
//! - nothing, where the hull of its coefficients leaves out 0 by more than rounding explains, seen along an
//!   axis of the plane or along the part's own;
//! - what is met along one curve. In axes x and y of the plane such that x increases all over the part along
//!   one of the parameters, say q, the points with x = 0 are a graph q = Q(p), and along it y has the
//!   derivative −D / x_q, with D the determinant of F's derivative. Where interval bounds say that D keeps
//!   its sign, y is monotonic: one root or none, as the signs at both ends say. Where they say that D x_q's
//!   own derivative keeps its sign, y has one extreme, which is found first: two roots or none, as the sign
//!   there says. So it is one and the same sign that decides on both, and a line that hardly touches doesn't
//!   lose one of two (the same idea in one dimension: [`crate::geometry::roots`]). Near a cusp, where there
//!   may be three, D itself is followed along the curve, beside which it has both signs.
//!
//! Nothing is left out but by a proof, rounding included, and no two roots are taken for one unless they
//! turn the same way and are no further apart than rounding. So a line through a point that two patches share
//! meets at least one of them, whatever the rounding, at the price of meeting both if it is that near. Where
//! a border has shrunk to a point the parts about it become as small as rounding; what is left of them then
//! is met, as one where it lies together. Where F is flat over a longer part the line runs in the surface or
//! touches it, which is a miss.

use super::bicubic::Bicubic;
use super::curve::Curve;
use super::monotonicity::{Turned, range};
use super::root::{DEGENERATE, Root, Subdomain, hull, joined};
use crate::geometry::Vec3;
use glam::DVec2;
use smallvec::SmallVec;

/// Bound on the rounding errors of F, whose coefficients are in units of the patch's reach: those of control
/// points and the line's start relative to the patch's middle, of two axes that are not quite across the
/// line, of the projection, of halving and of evaluation; in all below 20 units of 2⁻⁵², and a reserve.
pub const NOISE: f64 = 32.0 * f64::EPSILON;

/// A part this much longer than [`NOISE`], and no wider, is touched.
const LONG: f64 = 1e3;

/// Parts are not halved more often; before that they are small as rounding in all directions.
const DEEPEST: u32 = 160;

/// A patch's control points relative to a point in its middle.
#[derive(Clone, Debug)]
pub struct Anchored {
    pub middle: Vec3,
    pub points: Bicubic<Vec3>,
    /// The greatest distance of a control point from the middle.
    pub reach: f64,
}

/// Where a line meets a patch.
#[derive(Clone, Copy, Debug)]
pub struct LineHit {
    /// The line's parameter.
    pub t: f64,
    /// Bound on its error.
    pub error: f64,
    /// u and v, from 0 to 1.
    pub at: [f64; 2],
    /// Whether the line goes against ∂p/∂u × ∂p/∂v.
    pub against: bool,
}

/// A line near a patch, relative to its middle.
struct Near {
    /// The line's parameter here, about where it is nearest.
    shift: f64,
    start: Vec3,
    direction: Vec3,
    /// Across the line, in units of the patch's reach, and right-handed with it.
    axes: [Vec3; 2],
}

impl Near {
    /// `None` where the line passes by all control points.
    fn new(origin: Vec3, direction: Vec3, patch: &Anchored) -> Option<Self> {
        let away = origin - patch.middle;
        let shift = -away.dot(direction) / direction.length_squared();
        // As it is rounded once: however far away a ray starts, the line is known as well as from nearby.
        let start = Vec3::from_array([0, 1, 2].map(|i| {
            let (away, lost) = two_sum(origin[i], -patch.middle[i]);
            let way = direction[i] * shift;
            let lost_way = direction[i].mul_add(shift, -way);
            let (sum, lost_sum) = two_sum(away, way);
            sum + (lost_sum + (lost + lost_way))
        }));
        let limit = patch.reach * (1.0 + 1e-9);
        let passes_near = start.length_squared() <= limit * limit;
        if !passes_near {
            return None;
        }
        let ahead = direction.normalize();
        let (first, second) = ahead.any_orthonormal_pair();
        Some(Self { shift, start, direction, axes: [first, second].map(|axis| axis / patch.reach) })
    }

    fn seen(&self, points: &Bicubic<Vec3>) -> Bicubic<DVec2> {
        points.map(|point| {
            let away = point - self.start;
            DVec2::new(away.dot(self.axes[0]), away.dot(self.axes[1]))
        })
    }
}

/// A sum and what rounding took from it.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let back = sum - a;
    (sum, (a - (sum - back)) + (b - back))
}

/// All hits of the line with the patch, in no order.
pub fn line_hits(origin: Vec3, direction: Vec3, patch: &Anchored) -> SmallVec<[LineHit; 4]> {
    let mut found = SmallVec::new();
    let Some(line) = Near::new(origin, direction, patch) else { return found };
    let seen = line.seen(&patch.points);
    let mut search = Search { seen: &seen, roots: SmallVec::new(), degenerate: SmallVec::new() };
    search.look(&seen, Subdomain { from: [0.0; 2], size: [1.0; 2] }, 0);
    let degenerate = joined(&search.degenerate).into_iter().map(|part| Root::degenerate(&seen, part));
    let mut roots = search.roots;
    roots.extend(degenerate);
    let along: SmallVec<[f64; 8]> =
        roots.iter().map(|root| (patch.points.value(root.at) - line.start).dot(line.direction)).collect();
    for (i, root) in roots.iter().enumerate() {
        // The better known hit suffices where several lie within rounding of a border that is a point.
        let beside = 64.0 * NOISE * patch.reach + line.extent(patch, root);
        let known = |(j, other): (usize, &Root)| {
            (other.degenerate.is_none() || j < i) && (along[i] - along[j]).abs() <= beside
        };
        if root.degenerate.is_some() && roots.iter().enumerate().any(known) {
            continue;
        }
        found.push(line.line_hit(patch, &seen, root));
    }
    found
}

impl Near {
    /// How far along the line, as a product with its direction, a degenerate region reaches from its point. 0
    /// for other roots.
    fn extent(&self, patch: &Anchored, root: &Root) -> f64 {
        let Some(degenerate) = root.degenerate else { return 0.0 };
        let middle = patch.points.value(root.at);
        let part = patch.points.part([0, 1].map(|axis| degenerate.sides(axis)));
        part.all().fold(0.0, |most: f64, point| most.max((point - middle).dot(self.direction).abs()))
    }

    fn line_hit(&self, patch: &Anchored, seen: &Bicubic<DVec2>, root: &Root) -> LineHit {
        let point = patch.points.value(root.at) - self.start;
        let ahead = point.dot(self.direction) / self.direction.length_squared();
        let at = root.at.map(|parameter| parameter.clamp(0.0, 1.0));
        let [along_u, along_v] = patch.points.slopes(root.at);
        let normal = along_u.cross(along_v);
        let slant = normal.cross(self.direction).length() / normal.dot(self.direction).abs();
        let world = patch.middle.abs().max_element() + patch.reach;
        let noise = NOISE * patch.reach + 4.0 * f64::EPSILON * world;
        // As long as the slant hardly changes over what the root is off by; else the line all but touches.
        let jet = seen.jet(root.at);
        let change_u = jet.uu.perp_dot(jet.v) + jet.u.perp_dot(jet.uv);
        let change_v = jet.uv.perp_dot(jet.v) + jet.u.perp_dot(jet.vv);
        let fraction = noise / (NOISE * patch.reach);
        let change = fraction * (change_u.abs() * root.spread[0] + change_v.abs() * root.spread[1]);
        let settled = change <= 0.25 * root.determinant.abs();
        let t = self.shift + ahead;
        let rounding = 2.0 * f64::EPSILON * (t.abs() + ahead.abs());
        let off = if root.degenerate.is_some() {
            // Wherever it is met, it is met here.
            self.extent(patch, root) / self.direction.length_squared() + 2.0 * noise
        } else {
            2.0 * noise * (1.0 + slant)
        };
        let error = if settled && off.is_finite() { off + rounding } else { f64::INFINITY };
        let against = if root.degenerate.is_some() {
            // Where a border is a point the normal is that of the patch beside it.
            super::normal(&patch.points, at).dot(self.direction) < 0.0
        } else {
            root.determinant < 0.0
        };
        LineHit { t, error, at, against }
    }
}

struct Search<'a> {
    seen: &'a Bicubic<DVec2>,
    roots: SmallVec<[Root; 8]>,
    /// Parts as small as rounding.
    degenerate: SmallVec<[Subdomain; 4]>,
}

impl Search<'_> {
    /// What is in a part, over which the coefficients are `net`.
    fn look(&mut self, bicubic: &Bicubic<DVec2>, part: Subdomain, depth: u32) {
        let (low, high) = hull(bicubic);
        if low.max_element() > NOISE || high.min_element() < -NOISE {
            return;
        }
        if (high - low).max_element() <= DEGENERATE {
            self.degenerate.push(part);
            return;
        }
        // The parameter along which there is more of it, and its own axis there.
        let mut lengths = [0.0; 2];
        let mut ways = [DVec2::ZERO; 2];
        for i in 0..4 {
            for j in 0..3 {
                let steps = [bicubic.0[j + 1][i] - bicubic.0[j][i], bicubic.0[i][j + 1] - bicubic.0[i][j]];
                for axis in 0..2 {
                    lengths[axis] += steps[axis].length();
                    ways[axis] += steps[axis];
                }
            }
        }
        let along = usize::from(lengths[1] > lengths[0]);
        let own = ways[along].try_normalize().unwrap_or(DVec2::X);
        let turned = Turned::of(bicubic, own, along);
        let [x, y] = [&turned.x, &turned.y].map(|bicubic| range(bicubic.all()));
        if x.0 > NOISE || x.1 < -NOISE || y.0 > NOISE || y.1 < -NOISE {
            return;
        }
        let flat = y.0 >= -2.0 * NOISE && y.1 <= 2.0 * NOISE;
        if (flat && x.1 - x.0 > LONG * NOISE) || depth == DEEPEST {
            return;
        }
        if turned.monotonicity().is_some()
            && let Some(curve) = Curve::new(self.seen, part, along, ways)
        {
            curve.roots().into_iter().for_each(|root| self.add(root));
            return;
        }
        for (half, bicubic) in bicubic.halves(along).iter().enumerate() {
            let mut part = part;
            part.size[along] *= 0.5;
            part.from[along] += half as f64 * part.size[along];
            self.look(bicubic, part, depth + 1);
        }
    }

    fn add(&mut self, root: Root) {
        let same = |other: &Root| {
            let beside = |axis: usize| {
                (root.at[axis] - other.at[axis]).abs() <= root.spread[axis] + other.spread[axis]
            };
            root.determinant * other.determinant > 0.0 && beside(0) && beside(1)
        };
        if !self.roots.iter().any(same) {
            self.roots.push(root);
        }
    }
}
