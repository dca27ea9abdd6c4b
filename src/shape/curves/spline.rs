//! Stretches of a cubic path along which the radius is cubic, too: the tube around one, and what a ball
//! sweeps along it.
//!
//! As seen along a line, the path's point u is at s(u) along it and at q(u) across it. The ball of
//! radius r(u) around it is crossed at s ± √D with D = r² − |q|², so only where D isn't negative can there be
//! anything; those are the *windows*. Within one
//! - the tube, a circle of that radius across the path, is met at s − √D where (t − s) s' = q·q', that is P +
//!   s'√D = 0 with P = q·q', and at s + √D where P − s'√D = 0;
//! - what the ball sweeps begins at the least s − √D and ends at the greatest s + √D. Both are at an end of
//!   the segment or where the derivative vanishes, which is the same equation with P = q·q' − r r' (Glassner,
//!   *An Introduction to Ray Tracing*, ch. 3, 3.3, where the two conditions f = |x − c|² − r² = 0 and ∂f/∂u =
//!   0 are joined into one of the tenth degree; the radius is to be squared there).
//!
//! The root of D is kept: without it both signs would be one polynomial, with double roots where a line
//! crosses a straight tube at right angles. Roots are isolated by bounds of the Bernstein form, so that none
//! is missed: a part of a window is left when the function can't vanish in it, and searched when the function
//! is monotonic.

use super::{Near, Span, Spot};
use crate::geometry::bernstein::{
    self, Range, cubic, cubic_bend, cubic_slope, derivative, restricted, sign_changes, split, squared,
};
use crate::geometry::roots::{Sample, bracketed, bracketed_from};
use crate::geometry::{Bounds, Frame, Vec3};
use crate::sampling::quadrature::gauss_legendre;
use smallvec::SmallVec;
use std::f64::consts::TAU;
use wide::f64x4;

/// Parts of a segment are not halved more often: what is left is a touch.
const DEEPEST: u32 = 46;

/// Which equation's roots are asked for: P + side·s'√D = 0.
#[derive(Clone, Copy, PartialEq)]
enum Branch {
    /// s − √D
    First,
    /// s + √D
    Second,
}

impl Branch {
    fn side(self) -> f64 {
        if self == Self::First { 1.0 } else { -1.0 }
    }
}

/// What moves along the path.
#[derive(Clone, Copy, PartialEq)]
enum Sweep {
    Circle,
    Ball,
}

/// Centre and radius as cubics of u from 0 to 1, in Bézier form.
#[derive(Clone, Copy, Debug)]
pub struct SplineSegment {
    pub points: [Vec3; 4],
    pub radii: [f64; 4],
}

impl SplineSegment {
    /// The segment of a uniform cubic B-spline that four neighbouring control points make.
    pub fn of_spline(points: [Vec3; 4], radii: [f64; 4]) -> Self {
        fn bezier<T: bernstein::Value>([a, b, c, d]: [T; 4]) -> [T; 4] {
            let end = |a: T, b: T, c: T| b + ((a - b) + (c - b)) * (1.0 / 6.0);
            [end(a, b, c), b + (c - b) * (1.0 / 3.0), c + (b - c) * (1.0 / 3.0), end(d, c, b)]
        }
        Self { points: bezier(points), radii: bezier(radii) }
    }

    pub fn centre(&self, u: f64) -> Vec3 {
        cubic(&self.points, u)
    }

    pub fn radius(&self, u: f64) -> f64 {
        cubic(&self.radii, u)
    }

    pub fn velocity(&self, u: f64) -> Vec3 {
        cubic_slope(&self.points, u)
    }

    pub fn growth(&self, u: f64) -> f64 {
        cubic_slope(&self.radii, u)
    }

    pub fn bend(&self, u: f64) -> Vec3 {
        cubic_bend(&self.points, u)
    }

    /// Where its middle is.
    pub fn middle(&self) -> Vec3 {
        Bounds::of(self.points).centre()
    }

    /// The largest distance of a point of it from its middle.
    pub fn reach(&self) -> f64 {
        let middle = self.middle();
        let away = |i: usize| middle.distance(self.points[i]) + self.radii[i];
        away(0).max(away(1)).max(away(2)).max(away(3))
    }

    /// The smallest box around its balls.
    pub fn bounds(&self) -> Bounds {
        let mut bounds = Bounds::EMPTY;
        for axis in 0..3 {
            bounds.max[axis] = self.farthest(Vec3::AXES[axis], 1.0);
            bounds.min[axis] = -self.farthest(-Vec3::AXES[axis], 1.0);
        }
        bounds
    }

    /// The greatest direction · c(u) + `stretch` r(u).
    pub fn farthest(&self, direction: Vec3, stretch: f64) -> f64 {
        let along: [f64; 4] =
            std::array::from_fn(|i| direction.dot(self.points[i]) + stretch * self.radii[i]);
        let mut most = along[0].max(along[3]);
        let [a, b, c] = [along[1] - along[0], along[2] - along[1], along[3] - along[2]];
        for root in crate::geometry::roots::quadratic(a - 2.0 * b + c, 2.0 * (b - a), a) {
            if root.t > 0.0 && root.t < 1.0 {
                most = most.max(cubic(&along, root.t));
            }
        }
        most
    }

    /// The u of the ball that reaches farthest over a point: of one on the surface of what the ball sweeps,
    /// the one that touches.
    pub fn ball_at(&self, point: Vec3) -> f64 {
        let away = self.points.map(|c| c - point);
        let squares = [0, 1, 2].map(|axis| squared(&away.map(|c| c[axis])));
        let radii = squared(&self.radii);
        let depth: [f64; 7] =
            std::array::from_fn(|i| radii[i] - squares[0][i] - squares[1][i] - squares[2][i]);
        let over = |u: f64| self.radius(u).powi(2) - cubic(&away, u).length_squared();
        let slope = |u: f64| {
            let (radius, growth, away, velocity) =
                (self.radius(u), self.growth(u), cubic(&away, u), self.velocity(u));
            Sample {
                value: 2.0 * (radius * growth - away.dot(velocity)),
                slope: 2.0
                    * (growth * growth + radius * cubic_bend(&self.radii, u)
                        - velocity.length_squared()
                        - away.dot(self.bend(u))),
                error: 0.0,
            }
        };
        let extremes = sign_changes(&derivative::<7, 6>(&depth), [0.0, 1.0], &slope);
        let all = extremes.into_iter().chain([0.0, 1.0]);
        all.max_by(|a, b| over(*a).total_cmp(&over(*b))).unwrap_or(0.0)
    }

    /// The normal of the tube at `point` of the circle u, of any length.
    pub fn tube_normal(&self, u: f64, point: Vec3) -> Vec3 {
        let (velocity, radius) = (self.velocity(u), self.radius(u));
        let outward = point - self.centre(u);
        // Where the path bends the surface is stretched outside and compressed inside.
        outward * (velocity.length_squared() - outward.dot(self.bend(u)))
            - velocity * (radius * self.growth(u))
    }

    /// Area of the tube: ∫∫ |∂p/∂u × ∂p/∂θ| dθ du, by Gauss's rule along and the trapezoid rule around.
    pub fn tube_area(&self) -> f64 {
        const AROUND: usize = 32;
        let circle = |u: f64| {
            let (velocity, radius, growth) = (self.velocity(u), self.radius(u), self.growth(u));
            let speed = velocity.length();
            let Some(ahead) = velocity.try_normalize() else { return 0.0 };
            let Frame { x, y, .. } = Frame::around(ahead);
            let width = |i: usize| {
                let (sin, cos) = (TAU * i as f64 / AROUND as f64).sin_cos();
                let outward = (x * cos + y * sin) * radius;
                (speed - outward.dot(self.bend(u)) / speed).hypot(growth)
            };
            radius * TAU / AROUND as f64 * (0..AROUND).map(width).sum::<f64>()
        };
        gauss_legendre(16).map(|(x, weight)| 0.5 * weight * circle(0.5 + 0.5 * x)).sum()
    }

    /// Where a line enters the tube, in no order: only where it faces the line.
    pub fn tube_entries(&self, line: &Near) -> SmallVec<[Spot; 4]> {
        let mut spots = SmallVec::new();
        let Some(seen) = SegmentAlongLine::new(self, line) else { return spots };
        let peak = seen.peak();
        if peak.as_ref().is_some_and(|peak| peak.value <= 0.0) {
            return spots;
        }
        let branches: &[Branch] =
            if seen.hides_second() { &[Branch::First] } else { &[Branch::First, Branch::Second] };
        for &branch in branches {
            for u in seen.circles(branch, peak.as_ref()) {
                let t = seen.on_circle(u, branch);
                let point = line.start + line.direction * t;
                let Some(normal) = self.tube_normal(u, point).try_normalize() else { continue };
                let facing = normal.dot(line.direction);
                if facing < 0.0 {
                    let radius = self.radius(u);
                    // A surface that is off by a height is met that height over the cosine away, as long as
                    // its own bend over that distance doesn't matter; else the line all but touches.
                    let height = 16.0 * line.rounding + 32.0 * f64::EPSILON * radius;
                    let touch = (8.0 * radius * height).sqrt();
                    let error =
                        if facing * facing * radius > 16.0 * height { height / -facing } else { touch };
                    spots.push(Spot { t, u, error: 2.0 * error });
                }
            }
        }
        spots
    }

    /// Where a line is within what the ball sweeps, in no order; the intervals may overlap.
    pub fn ball_spans(&self, line: &Near) -> SmallVec<[Span; 2]> {
        let mut spans = SmallVec::new();
        let Some(seen) = SegmentAlongLine::new(self, line) else { return spans };
        for window in seen.windows() {
            let mut span: Option<Span> = None;
            let mut consider = |u: f64| {
                let half = seen.half(u);
                let here = line.chord(u, seen.along(u), half, self.radius(u));
                span = Some(span.map_or(here, |span| span.around(here)));
            };
            window.into_iter().for_each(&mut consider);
            for branch in [Branch::First, Branch::Second] {
                seen.roots(window, branch, Sweep::Ball).into_iter().for_each(&mut consider);
            }
            let most = self.radii.into_iter().fold(0.0, f64::max);
            spans.extend(span.map(|span| span.settled(line, most)));
        }
        spans
    }
}

/// A segment as seen along a line. Across it are x and y, along it is s.
struct SegmentAlongLine {
    /// x, y, s and the radius, side by side.
    points: [f64x4; 4],
    /// Where on the path: a path that begins or ends at rest has no direction at that very end.
    ends: [f64; 2],
    /// Bounds over all of it, of circles.
    whole: PartBounds,
}

/// The functions over a part of a segment, by the coefficients that bound them.
struct PartBounds {
    /// D
    squared: [f64; 7],
    /// s'
    slope: [f64; 3],
    /// P
    bend: [f64; 6],
    /// Bound on the rounding of P's coefficients.
    rounding: f64,
}

/// Where D is greatest, or about.
struct Peak {
    u: f64,
    /// D
    value: f64,
    /// D'/2
    slope: f64,
    /// D''/2
    bend: f64,
    /// P
    across: f64,
    /// s'
    speed: f64,
}

impl PartBounds {
    /// The bounds over a part that has these control points.
    fn new(points: &[f64x4; 4], sweep: Sweep) -> Self {
        let squares = squared(points).map(f64x4::to_array);
        let across = squares.map(|[x, y, ..]| x + y);
        let radii = squares.map(|[.., r]| r);
        let squared: [f64; 7] = std::array::from_fn(|i| radii[i] - across[i]);
        // q·q' is half the derivative of |q|², and r r' that of r².
        let bend = match sweep {
            Sweep::Circle => derivative::<7, 6>(&across).map(|c| 0.5 * c),
            Sweep::Ball => derivative::<7, 6>(&squared).map(|c| -0.5 * c),
        };
        let size = across.iter().chain(&radii).fold(0.0f64, |size, c| size.max(c.abs()));
        let slope = derivative(&points.map(|point| point.to_array()[2]));
        Self { squared, slope, bend, rounding: 64.0 * f64::EPSILON * size }
    }
}

impl SegmentAlongLine {
    /// `None` where the line passes all balls.
    fn new(segment: &SplineSegment, line: &Near) -> Option<Self> {
        let Frame { x, y, z } = Frame::around(line.direction);
        let points: [f64x4; 4] = std::array::from_fn(|i| {
            let away = segment.points[i] - line.start;
            f64x4::new([away.dot(x), away.dot(y), away.dot(z), segment.radii[i]])
        });
        if passes(&points.map(f64x4::to_array)) {
            return None;
        }
        let whole = PartBounds::new(&points, Sweep::Circle);
        if Range::of(&whole.squared).1 <= 0.0 {
            return None;
        }
        // At rest where two control points are one, or three. How far the path gets in that little is below
        // rounding.
        let rest = |[a, b, c]: [Vec3; 3]| match () {
            () if a != b => 0.0,
            () if b != c => 1e-8,
            () => 1e-5,
        };
        let [a, b, c, d] = segment.points;
        Some(Self { points, ends: [rest([a, b, c]), 1.0 - rest([d, c, b])], whole })
    }

    fn along(&self, u: f64) -> f64 {
        cubic(&self.points, u).to_array()[2]
    }

    /// Where the line passes the circle u, in one of the two places that its ball has: s ∓ √D, or what is the
    /// same at a root, s + q·q'/s'. The one is worth little where D vanishes, the other where the line goes
    /// across the path.
    fn on_circle(&self, u: f64, branch: Branch) -> f64 {
        let [x, y, along, radius] = cubic(&self.points, u).to_array();
        let [dx, dy, speed, _] = cubic_slope(&self.points, u).to_array();
        let half = half(x, y, radius);
        let velocity = dx * dx + dy * dy + speed * speed;
        let from_centre = if half * half * velocity < radius * radius * speed * speed {
            (x * dx + y * dy) / speed
        } else {
            -branch.side() * half
        };
        along + from_centre
    }

    /// √D; 0 where there is none.
    fn half(&self, u: f64) -> f64 {
        let [x, y, _, radius] = cubic(&self.points, u).to_array();
        half(x, y, radius)
    }

    /// D and its derivative.
    fn squared(&self, u: f64) -> Sample {
        let [x, y, _, radius] = cubic(&self.points, u).to_array();
        let [dx, dy, _, growth] = cubic_slope(&self.points, u).to_array();
        let slope = 2.0 * (radius * growth - (x * dx + y * dy));
        Sample { value: radius * radius - (x * x + y * y), slope, error: 0.0 }
    }

    /// P + side·s'√D and its derivative.
    fn function(&self, u: f64, branch: Branch, sweep: Sweep) -> Sample {
        let [x, y, _, radius] = cubic(&self.points, u).to_array();
        let [dx, dy, speed, growth] = cubic_slope(&self.points, u).to_array();
        let [ddx, ddy, change, turn] = cubic_bend(&self.points, u).to_array();
        let (mut value, mut bend) = (x * dx + y * dy, dx * dx + x * ddx + dy * dy + y * ddy);
        // Half the derivative of D.
        let widening = radius * growth - value;
        if sweep == Sweep::Ball {
            value -= radius * growth;
            bend -= growth * growth + radius * turn;
        }
        let (half, side) = (half(x, y, radius), branch.side());
        let slope = bend + side * (change * half + speed * widening / half);
        Sample { value: value + side * speed * half, slope, error: 0.0 }
    }

    /// Whether the tube never faces the line behind its path, at s + √D. The normal · line is A√D − r r' s'
    /// there, where A = |c'|² − (p − c)·c'' is at least |c'|² − r |c''|.
    fn hides_second(&self) -> bool {
        let [a, b, c, d] = self.points;
        let slopes = [b - a, c - b, d - c].map(|slope| (slope * 3.0).to_array());
        let vectors = slopes.map(|[x, y, s, _]| Vec3::new(x, y, s));
        let chord = vectors[0] + vectors[1] + vectors[2];
        let ahead = vectors.map(|slope| slope.dot(chord)).into_iter().fold(f64::INFINITY, f64::min);
        let bend = (vectors[1] - vectors[0]).length_squared().max((vectors[2] - vectors[1]).length_squared());
        let radius = self.points.iter().fold(0.0f64, |most, point| most.max(point.to_array()[3]));
        let keeps_up = ahead > 0.0 && ahead * ahead >= 2.0 * radius * bend.sqrt() * chord.length_squared();
        let (speed, growth) =
            (Range::of(&slopes.map(|slope| slope[2])), Range::of(&slopes.map(|slope| slope[3])));
        keeps_up && (speed.0 >= 0.0 && growth.1 <= 0.0 || speed.1 <= 0.0 && growth.0 >= 0.0)
    }

    /// The only maximum of D, or what is greatest at an end. `None` where there may be several.
    fn peak(&self) -> Option<Peak> {
        /// D' is nearly straight: the secant is off by some per cent, and each step squares that.
        const STEPS: usize = 8;
        let slopes: [f64; 6] = derivative(&self.whole.squared);
        let narrowing = -Range::of(&derivative::<6, 5>(&slopes)).1;
        if narrowing <= 0.0 {
            return None;
        }
        let [from, to] = self.ends;
        if slopes[0] <= 0.0 {
            return Some(self.at(from));
        }
        if slopes[5] >= 0.0 {
            return Some(self.at(to));
        }
        let mut peak = self.at(slopes[0] / (slopes[0] - slopes[5]));
        for _ in 0..STEPS {
            // D is at most D'²/(2 |D''|) greater elsewhere.
            if 2.0 * peak.slope * peak.slope <= narrowing * self.whole.rounding {
                return Some(peak);
            }
            peak = self.at((peak.u - peak.slope / peak.bend).clamp(from, to));
        }
        None
    }

    /// D at a place, as a peak.
    fn at(&self, u: f64) -> Peak {
        let [x, y, _, radius] = cubic(&self.points, u).to_array();
        let [dx, dy, speed, growth] = cubic_slope(&self.points, u).to_array();
        let [ddx, ddy, _, turn] = cubic_bend(&self.points, u).to_array();
        let across = x * dx + y * dy;
        Peak {
            u,
            value: radius * radius - (x * x + y * y),
            slope: radius * growth - across,
            bend: growth * growth + radius * turn - (dx * dx + x * ddx + dy * dy + y * ddy),
            across,
            speed,
        }
    }

    /// The circles that a line passes on a branch.
    fn circles(&self, branch: Branch, peak: Option<&Peak>) -> SmallVec<[f64; 4]> {
        if let Some(certain) = peak.and_then(|peak| self.only_root(branch, peak)) {
            return certain.into_iter().collect();
        }
        self.searched(branch)
    }

    /// The same by the search that misses none.
    fn searched(&self, branch: Branch) -> SmallVec<[f64; 4]> {
        let windows = self.windows();
        windows.into_iter().flat_map(|window| self.roots(window, branch, Sweep::Circle)).collect()
    }

    /// The root of F = P + side·s'√D where there is at most one, as on most lines that cross a thin tube.
    /// `None` where there may be several.
    ///
    /// Where D has one peak, P grows, and side·s' is above 0,
    /// - F grows before the peak: F' = P' + side (s''√D + s'D'/(2√D)), and P' is greater than |s''√D|;
    /// - F is above 0 behind it, where P is; until P is, if it is not at the peak, s'√D outweighs it.
    ///
    /// Where side·s' is below 0, the same holds with both sides of the peak and of 0 exchanged.
    fn only_root(&self, branch: Branch, peak: &Peak) -> Option<Option<f64>> {
        let PartBounds { squared, slope, bend, rounding } = &self.whole;
        let side = branch.side();
        let speed = Range::of(slope) * side;
        let growth = Range::of(&derivative::<6, 5>(bend)).0 - rounding;
        let Range(least, most) = Range::of(&derivative::<3, 2>(slope));
        if speed.has_zero() || growth <= most.max(-least) * Range::of(squared).1.sqrt() {
            return None;
        }
        let is_ahead = speed.0 > 0.0;
        if (peak.across < 0.0) == is_ahead {
            let vanished = (peak.u - peak.across / growth).clamp(self.ends[0], self.ends[1]);
            let depth = peak.value.min(self.squared(vanished).value);
            let speed = speed.0.abs().min(speed.1.abs());
            if depth <= 0.0 || speed * speed * depth <= peak.across * peak.across {
                return None;
            }
        }
        // A root beyond the end belongs to the next segment, if to any.
        let (end, last) = if is_ahead { (self.ends[0], 0) } else { (self.ends[1], 1) };
        let value = bend[5 * last] + side * slope[2 * last] * squared[6 * last].max(0.0).sqrt();
        if (value >= 0.0) == is_ahead {
            return Some(None);
        }
        // Where D is a parabola and s' is constant.
        let (narrowing, speed) = (-peak.bend, peak.speed * peak.speed);
        let away = (peak.value * speed / (narrowing * (narrowing + speed))).sqrt();
        let (bracket, guess) =
            if is_ahead { ([end, peak.u], peak.u - away) } else { ([peak.u, end], peak.u + away) };
        let guess = guess.clamp(bracket[0], bracket[1]);
        let root = bracketed_from(guess, bracket, -1.0, &|u| self.function(u, branch, Sweep::Circle)).t;
        Some((self.squared(root).value >= 0.0).then_some(root))
    }

    /// The root between two places where the function grows or falls all the way.
    fn crossing(&self, [from, to]: [f64; 2], branch: Branch, sweep: Sweep) -> Option<f64> {
        // Zero counts as positive, so that a root on the edge of two parts is one of the one or of the other.
        let sign = |u: f64| if self.function(u, branch, sweep).value < 0.0 { -1.0 } else { 1.0 };
        let (first, last) = (sign(from), sign(to));
        (first != last).then(|| bracketed(from, to, first, &|u| self.function(u, branch, sweep)).t)
    }

    /// The intervals of u over which the line passes through the balls.
    fn windows(&self) -> SmallVec<[[f64; 2]; 3]> {
        let mut edges: SmallVec<[f64; 10]> = SmallVec::new();
        edges.push(self.ends[0]);
        edges.extend(sign_changes(&self.whole.squared, [0.0, 1.0], &|u| self.squared(u)));
        edges.push(self.ends[1]);
        edges
            .windows(2)
            .map(|edge| [edge[0], edge[1]])
            .filter(|&[from, to]| from < to && self.squared(0.5 * (from + to)).value > 0.0)
            .collect()
    }

    /// The roots of a branch within a window.
    fn roots(&self, window: [f64; 2], branch: Branch, sweep: Sweep) -> SmallVec<[f64; 4]> {
        let mut found = SmallVec::new();
        self.search(window, &restricted(&self.points, window), branch, sweep, 0, &mut found);
        found
    }

    /// `points`: control points of the part.
    fn search(
        &self,
        [from, to]: [f64; 2],
        points: &[f64x4; 4],
        branch: Branch,
        sweep: Sweep,
        depth: u32,
        found: &mut SmallVec<[f64; 4]>,
    ) {
        let PartBounds { squared, slope, bend, rounding } = PartBounds::new(points, sweep);
        let half = Range::of(&squared).sqrt();
        let (speed, side) = (Range::of(&slope), branch.side());
        let Range(least, most) = Range::of(&bend) + speed * half * side;
        if least > rounding || most < -rounding {
            return;
        }
        // Nothing but rounding is left of it.
        let vanishes = most.max(-least) <= 2.0 * rounding;
        // √D times the derivative: √D P' ± (s'' D + s' D'/2).
        let change = Range::of(&derivative::<3, 2>(&slope)) * (half * half)
            + speed * (Range::of(&derivative::<7, 6>(&squared)) * 0.5);
        let monotonic = !(half * Range::of(&derivative::<6, 5>(&bend)) + change * side).has_zero();
        if monotonic || vanishes || depth == DEEPEST {
            found.extend(self.crossing([from, to], branch, sweep));
            return;
        }
        let ([left, right], middle) = (split(points), 0.5 * (from + to));
        self.search([from, middle], &left, branch, sweep, depth + 1, found);
        self.search([middle, to], &right, branch, sweep, depth + 1, found);
    }
}

/// √D; 0 where there is none.
fn half(x: f64, y: f64, radius: f64) -> f64 {
    (radius * radius - (x * x + y * y)).max(0.0).sqrt()
}

/// Whether all control points lie on one side of the line, farther than the greatest radius: left or right of
/// it, above or below, or across the chord.
fn passes(points: &[[f64; 4]; 4]) -> bool {
    let radius = points.iter().fold(0.0f64, |most, [.., r]| most.max(*r));
    let [dx, dy] = [points[3][0] - points[0][0], points[3][1] - points[0][1]];
    let beyond = |far: [f64; 4], limit: f64| {
        let (least, most) = far
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), c| (c.min(least), c.max(most)));
        least > limit || most < -limit
    };
    beyond(points.map(|[x, ..]| x), radius)
        || beyond(points.map(|[_, y, ..]| y), radius)
        || beyond(points.map(|[x, y, ..]| x * dy - y * dx), radius * (dx * dx + dy * dy).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg as Random;

    /// Where one root is said to be the only one, the search that misses none finds that one.
    #[test]
    fn the_only_root_is_all_that_the_search_finds() {
        let mut random = Random::seed_from_u64(31);
        let mut any = |size: f64| size * (2.0 * random.random::<f64>() - 1.0);
        let (mut judged, mut met) = (0, 0);
        for _ in 0..20_000 {
            let mut next = |size: f64| Vec3::new(any(size), any(size), any(size));
            let step = next(1.0);
            let points = [-1.5, -0.5, 0.5, 1.5].map(|i| step * i + next(0.3));
            let (start, direction) = (next(0.2), next(1.0).normalize());
            let thickness = 0.03 * (1.2 + any(1.0));
            let radii = [0.0; 4].map(|_| thickness * (1.2 + any(1.0)));
            let line = Near { start: start.reject_from_normalized(direction), direction, rounding: 1e-15 };
            let Some(seen) = SegmentAlongLine::new(&SplineSegment::of_spline(points, radii), &line) else {
                continue;
            };
            let Some(peak) = seen.peak().filter(|peak| peak.value > 0.0) else { continue };
            for branch in [Branch::First, Branch::Second] {
                let Some(certain) = seen.only_root(branch, &peak) else { continue };
                let all = seen.searched(branch);
                let certain: Vec<f64> = certain.into_iter().collect();
                let same =
                    certain.len() == all.len() && certain.iter().zip(&all).all(|(a, b)| (a - b).abs() < 1e-9);
                assert!(same, "{points:?} {radii:?} {line:?}: {certain:?}, {all:?}");
                judged += 1;
                met += all.len();
            }
        }
        assert!(judged > 3000 && met > 1000, "{judged} judged, {met} met");
    }
}
