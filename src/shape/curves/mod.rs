//! Curves with a thickness: Mitsuba 3's `linearcurve` and `bsplinecurve`, made for hair, of which each
//! segment is a surface by itself for the acceleration structure; and the swept sphere, a body.

mod round_cone;
mod spline;
mod swept;

use super::crossing::{Crossing, Crossings};
use super::{Hit, NO_INSTANCE, Parametrisation, ShapeError, SurfaceHit};
use crate::geometry::{Bounds, Ray, SurfacePoint, Transform, Vec3, angle};
use round_cone::RoundCone;
use spline::SplineSegment;
use std::f64::consts::TAU;
use std::sync::Arc;
pub use swept::SweptSphere;

/// A place on a curve and the radius there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlPoint {
    /// Where it is, in the curve's own coordinates.
    pub position: Vec3,
    /// Radius of the curve there, at least 0.
    pub radius: f64,
}

/// How control points make a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveKind {
    /// Straight from each to the next.
    Linear,
    /// By uniform cubic B-splines, for each four neighbours a segment.
    BSpline,
}

impl CurveKind {
    /// Control points that a segment is made of.
    pub fn order(self) -> usize {
        match self {
            Self::Linear => 2,
            Self::BSpline => 4,
        }
    }
}

/// A line near a piece of a curve, in coordinates relative to it.
#[derive(Clone, Copy, Debug)]
struct Near {
    /// The line's point that is nearest to the piece's middle, or about.
    start: Vec3,
    /// Unit length.
    direction: Vec3,
    /// Bound on the rounding errors of coordinates.
    rounding: f64,
}

impl Near {
    /// `None` where a line passes a ball of radius `reach` around `middle`. With the distance from its origin
    /// to `start`.
    fn new(origin: Vec3, direction: Vec3, middle: Vec3, reach: f64) -> Option<(Self, f64)> {
        let away = origin - middle;
        let shift = -away.dot(direction);
        let start = away + direction * shift;
        let rounding = 4.0 * f64::EPSILON * (away.abs().max_element() + reach);
        let limit = reach + rounding;
        (start.length_squared() <= limit * limit).then_some((Self { start, direction, rounding }, shift))
    }

    /// How far the squared radius of a ball less the line's squared distance from its centre may be off.
    fn square_error(&self, radius: f64) -> f64 {
        4.0 * radius * (self.rounding + f64::EPSILON * radius)
    }

    /// Where the line meets the ball u of this radius, within which it is from `middle` − `half` to
    /// `middle` + `half`.
    ///
    /// A half² that is off by e is half off by e / (2 half), as long as e is much less than that; else it is
    /// not certain that the line enters at all, see [`Span::settled`].
    fn chord(&self, u: f64, middle: f64, half: f64, radius: f64) -> Span {
        let square = self.square_error(radius);
        let error = if half * half > 16.0 * square { square / half + self.rounding } else { f64::INFINITY };
        let spot = |t: f64| Spot { t, u, error };
        Span { enter: spot(middle - half), leave: spot(middle + half) }
    }
}

/// A place on a line and on a curve.
#[derive(Clone, Copy, Debug)]
struct Spot {
    /// Distance from the line's start.
    t: f64,
    /// Along the piece of the curve, from 0 to 1.
    u: f64,
    /// Bound on the error of t.
    error: f64,
}

/// An interval of a line within a piece of a curve.
#[derive(Clone, Copy, Debug)]
struct Span {
    enter: Spot,
    leave: Spot,
}

impl Span {
    /// The interval from the first entry of both to the last exit.
    fn around(self, other: Self) -> Self {
        Self {
            enter: if other.enter.t < self.enter.t { other.enter } else { self.enter },
            leave: if other.leave.t > self.leave.t { other.leave } else { self.leave },
        }
    }

    /// The line all but touches where an error has no bound yet: it may pass, or be within by what is between
    /// both ends, and a little more.
    fn settled(mut self, line: &Near, radius: f64) -> Self {
        let most = (self.leave.t - self.enter.t) + 2.0 * line.square_error(radius).sqrt() + line.rounding;
        self.enter.error = self.enter.error.min(most);
        self.leave.error = self.leave.error.min(most);
        self
    }
}

/// A piece of a curve in coordinates relative to its middle, so that nothing but the distance of who looks at
/// it costs digits.
#[derive(Clone, Copy, Debug)]
struct Anchored<T> {
    middle: Vec3,
    reach: f64,
    piece: T,
}

/// A segment of a linear curve.
#[derive(Clone, Copy, Debug)]
struct Link {
    cone: Anchored<RoundCone>,
    /// The balls at its ends, as its neighbours have them.
    ends: [ControlPoint; 2],
    /// Whether the segment before it, and the one after it, are of the same curve.
    is_joined: [bool; 2],
}

impl Link {
    fn is_point(&self) -> bool {
        self.ends[0].position == self.ends[1].position
    }
}

/// The segments of linear curves.
#[derive(Clone, Debug)]
struct Links(Arc<[Link]>);

impl Links {
    fn of(curves: &[Vec<ControlPoint>]) -> Self {
        let link = |curve: &[ControlPoint], i: usize| {
            let ends = [curve[i], curve[i + 1]];
            let middle = 0.5 * (ends[0].position + ends[1].position);
            let piece = cone(ends, middle);
            let cone = Anchored { middle, reach: piece.reach(), piece };
            Link { cone, ends, is_joined: [i > 0, i + 2 < curve.len()] }
        };
        Self(curves.iter().flat_map(|curve| (0..curve.len() - 1).map(|i| link(curve, i))).collect())
    }

    /// Where a ray enters a segment, and how far along the ray that is measured from.
    ///
    /// The ball at a joint is the end of one segment and the beginning of another. Both compute the entry
    /// into it from the same numbers, so that it is equally near on both, and the first of them has it
    /// everywhere. Neither has what is within the other one, as in Mitsuba 3.
    fn entry(&self, segment: usize, ray: &Ray) -> Option<(Spot, f64)> {
        let Link { cone: Anchored { middle, reach, piece }, ends, .. } = &self.0[segment];
        let (line, shift) = Near::new(ray.origin, ray.direction, *middle, *reach)?;
        let entry = piece.span(&line)?.enter;
        let end = match entry.u {
            0.0 => 0,
            1.0 => 1,
            _ => return Some((entry, shift)),
        };
        let (spot, from) = ball_entry(&ends[end], entry.u, ray).unwrap_or((entry, shift));
        let point = ray.origin + ray.direction * from - ends[end].position + ray.direction * spot.t;
        (!self.hides(segment, end, point)).then_some((spot, from))
    }

    /// Whether a point of the ball at an end of a segment, relative to the ball's middle, is within the
    /// segment that follows there.
    fn hides(&self, segment: usize, end: usize, point: Vec3) -> bool {
        let link = &self.0[segment];
        let ball = &link.ends[end];
        let is_within_next = |side: usize| {
            let (mut at, mut next) = (segment, link);
            while next.is_joined[side] {
                at = if side == 0 { at - 1 } else { at + 1 };
                next = &self.0[at];
                if next.ends[1 - side].radius != ball.radius {
                    return false;
                }
                if !next.is_point() {
                    // The hull of balls with radii r and s whose middles are a apart touches the first where
                    // p · a = −r (s − r). Where one holds the other, that is beyond all of its points p.
                    let other = &next.ends[side];
                    let touched = -ball.radius * (other.radius - ball.radius);
                    return point.dot(other.position - ball.position) > touched;
                }
            }
            false
        };
        if link.is_point() { is_within_next(0) || is_within_next(1) } else { is_within_next(end) }
    }
}

/// Where a ray enters a ball, which is the one of that u, likewise.
fn ball_entry(ball: &ControlPoint, u: f64, ray: &Ray) -> Option<(Spot, f64)> {
    let (line, shift) = Near::new(ray.origin, ray.direction, ball.position, ball.radius)?;
    let distance = line.start.length();
    let half =
        (ball.radius > distance).then(|| ((ball.radius - distance) * (ball.radius + distance)).sqrt())?;
    Some((line.chord(u, 0.0, half, ball.radius).settled(&line, ball.radius).enter, shift))
}

#[derive(Clone, Debug)]
enum Segments {
    Linear(Links),
    BSpline(Arc<[Anchored<SplineSegment>]>),
}

/// Mitsuba 3's curves.
///
/// Linear ones are round cones, the hulls of neighbouring balls; B-splines are tubes, open at both ends,
/// whose circle stands across the path. Only what faces the ray is met: from within they are invisible.
/// Segments that follow on one another have no ends within each other. Radii are those of the world, wherever
/// the control points are put. Hits carry the segment as their triangle and the place along it as first
/// barycentric coordinate.
#[derive(Clone, Debug)]
pub struct Curves {
    segments: Segments,
    inward: bool,
}

impl Curves {
    /// Every curve needs two control points, or four for B-splines. Normals point out of the tubes unless
    /// `flip_normals`.
    pub fn new(
        to_world: &Transform,
        kind: CurveKind,
        curves: &[Vec<ControlPoint>],
        flip_normals: bool,
    ) -> Result<Self, ShapeError> {
        let mut placed = Vec::new();
        for curve in curves {
            check(kind, curve)?;
            let moved = curve
                .iter()
                .map(|point| ControlPoint { position: to_world.point(point.position), ..*point })
                .collect::<Vec<_>>();
            if !moved.iter().all(can_be_squared) {
                return Err(ShapeError::Placement);
            }
            placed.push(moved);
        }
        let windows = || placed.iter().flat_map(|curve| curve.windows(kind.order()));
        if u32::try_from(windows().count()).is_err() {
            return Err(ShapeError::TooLarge);
        }
        let segments = match kind {
            CurveKind::Linear => Segments::Linear(Links::of(&placed)),
            CurveKind::BSpline => Segments::BSpline(
                windows()
                    .map(|four| {
                        let middle = 0.5 * (four[1].position + four[2].position);
                        let piece = spline_segment([four[0], four[1], four[2], four[3]], middle);
                        // Around its own middle, which is near.
                        let reach = piece.reach() + piece.middle().length();
                        Anchored { middle, reach, piece }
                    })
                    .collect(),
            ),
        };
        Ok(Self { segments, inward: flip_normals })
    }

    /// Number of segments of all curves.
    pub fn segment_count(&self) -> usize {
        match &self.segments {
            Segments::Linear(links) => links.0.len(),
            Segments::BSpline(segments) => segments.len(),
        }
    }

    /// The nearest hit of all segments, found one by one.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let hits =
            (0..self.segment_count() as u32).filter_map(|segment| self.intersect_segment(segment, ray));
        hits.reduce(|nearest, hit| if hit.t < nearest.t { hit } else { nearest })
    }

    /// The nearest hit of a segment.
    pub fn intersect_segment(&self, segment: u32, ray: &Ray) -> Option<Hit> {
        let mut nearest: Option<Hit> = None;
        self.each_entry(segment, ray, |crossing| {
            let t = crossing.hit.t;
            if t >= 0.0 && t < ray.t_max && nearest.is_none_or(|hit| t < hit.t) {
                nearest = Some(crossing.hit);
            }
        });
        nearest
    }

    /// Where the line meets a segment from outside, in ascending order over all of them.
    pub fn crossings(&self, ray: &Ray) -> Crossings {
        let mut found = Crossings::new();
        for segment in 0..self.segment_count() as u32 {
            found.extend(self.segment_crossings(segment, ray));
        }
        found.sort_by(|a, b| a.hit.t.total_cmp(&b.hit.t));
        found
    }

    /// Likewise of one segment.
    pub fn segment_crossings(&self, segment: u32, ray: &Ray) -> Crossings {
        let mut found = Crossings::new();
        self.each_entry(segment, ray, |crossing| found.push(crossing));
        found
    }

    fn each_entry(&self, segment: u32, ray: &Ray, mut found: impl FnMut(Crossing)) {
        let mut give = |spot: Spot, shift: f64| {
            let t = shift + spot.t;
            let hit =
                Hit { t, shape: 0, triangle: segment, instance: NO_INSTANCE, barycentric: [spot.u, 0.0] };
            let rounding = 4.0 * f64::EPSILON * (shift.abs() + spot.t.abs());
            found(Crossing { hit, error: spot.error + rounding, enters: !self.inward });
        };
        match &self.segments {
            Segments::Linear(links) => {
                links.entry(segment as usize, ray).into_iter().for_each(|(spot, shift)| give(spot, shift));
            }
            Segments::BSpline(segments) => {
                let Anchored { middle, reach, piece } = &segments[segment as usize];
                if let Some((line, shift)) = Near::new(ray.origin, ray.direction, *middle, *reach) {
                    piece.tube_entries(&line).into_iter().for_each(|spot| give(spot, shift));
                }
            }
        }
    }

    /// A place on a segment near `position`: relative to the segment's middle, from the path outward.
    fn tube_point(&self, segment: u32, u: f64, position: Vec3) -> TubePoint {
        match &self.segments {
            Segments::Linear(links) => {
                let Anchored { middle, reach, piece } = links.0[segment as usize].cone;
                let outward = position - middle - piece.centre(u);
                let normal = outward.try_normalize().unwrap_or(Vec3::Z);
                TubePoint {
                    middle,
                    reach,
                    centre: piece.centre(u),
                    outward: normal * piece.radius(u),
                    normal,
                    velocity: piece.along,
                    growth: piece.growth,
                    bend: Vec3::ZERO,
                }
            }
            Segments::BSpline(segments) => {
                let Anchored { middle, reach, piece } = segments[segment as usize];
                let (centre, velocity) = (piece.centre(u), piece.velocity(u));
                let across = (position - middle - centre).reject_from(velocity);
                let outward = across.try_normalize().unwrap_or(Vec3::Z) * piece.radius(u);
                let normal = piece.tube_normal(u, centre + outward).try_normalize().unwrap_or(Vec3::Z);
                let (growth, bend) = (piece.growth(u), piece.bend(u));
                TubePoint { middle, reach, centre, outward, normal, velocity, growth, bend }
            }
        }
    }

    /// The point of the surface at a hit near `position`.
    pub fn surface(&self, hit: &Hit, position: Vec3) -> SurfaceHit {
        let at = self.tube_point(hit.triangle, hit.barycentric[0], position);
        let position = at.middle + (at.centre + at.outward);
        let normal = if self.inward { -at.normal } else { at.normal };
        // The point's own rounding and that of a ray that starts there, and what both are off by in the
        // segment's coordinates.
        let error = f64::EPSILON * (2.0 * position.abs().max_element() + 24.0 * at.reach);
        SurfaceHit { point: SurfacePoint { position, normal, error }, shading_normal: normal }
    }

    /// u around the curve, from where a frame that keeps to the z axis has its first direction; v along all
    /// segments of all curves.
    pub fn parametrisation(&self, hit: &Hit, position: Vec3) -> Parametrisation {
        let TubePoint { outward, velocity, growth, bend, .. } =
            self.tube_point(hit.triangle, hit.barycentric[0], position);
        let (count, speed) = (self.segment_count() as f64, velocity.length());
        // A path that stands still leads nowhere; what it is turned around is as good as any.
        let ahead = velocity.try_normalize().unwrap_or(Vec3::Z);
        // Where the path runs along z there is no such frame, but one that is as good.
        let up = Vec3::Z.reject_from_normalized(ahead).try_normalize().unwrap_or(Vec3::Y);
        let side = up.cross(ahead);
        let turn = angle::atan2(outward.dot(up), outward.dot(side)) / TAU;
        let around = ahead.cross(outward);
        // How fast the frame turns along the path.
        let turning = bend.reject_from_normalized(ahead) / speed;
        let steepness = Vec3::Z.reject_from_normalized(ahead).length();
        let twist = if steepness > 0.0 { ahead.z * turning.dot(side) / steepness } else { 0.0 };
        let along = ahead * (speed - outward.dot(bend) / speed)
            + outward.normalize_or_zero() * growth
            + around * twist;
        let finite = |vector: Vec3| if vector.is_finite() { vector } else { Vec3::ZERO };
        Parametrisation {
            uv: [turn.rem_euclid(1.0), (hit.barycentric[0] + f64::from(hit.triangle)) / count],
            tangent: finite(around * TAU),
            bitangent: finite(along * count),
        }
    }

    /// A box around a segment.
    pub fn segment_bounds(&self, segment: u32) -> Bounds {
        let (middle, bounds) = match &self.segments {
            Segments::Linear(links) => {
                (links.0[segment as usize].cone.middle, links.0[segment as usize].cone.piece.bounds())
            }
            Segments::BSpline(segments) => {
                (segments[segment as usize].middle, segments[segment as usize].piece.bounds())
            }
        };
        Bounds { min: middle + bounds.min, max: middle + bounds.max }
    }

    /// A box around all of it.
    pub fn bounds(&self) -> Bounds {
        Bounds::of_all((0..self.segment_count() as u32).map(|segment| self.segment_bounds(segment)))
    }

    /// Area of all segments, parts inside other segments included.
    pub fn area(&self) -> f64 {
        match &self.segments {
            Segments::Linear(links) => links.0.iter().map(|link| link.cone.piece.area()).sum(),
            Segments::BSpline(segments) => segments.iter().map(|segment| segment.piece.tube_area()).sum(),
        }
    }
}

/// See [`Curves::tube_point`].
struct TubePoint {
    middle: Vec3,
    reach: f64,
    centre: Vec3,
    /// Vector from the centre to the surface.
    outward: Vec3,
    /// Unit length.
    normal: Vec3,
    velocity: Vec3,
    growth: f64,
    bend: Vec3,
}

fn check(kind: CurveKind, curve: &[ControlPoint]) -> Result<(), ShapeError> {
    if let Some(point) = curve.iter().find(|point| !(point.radius >= 0.0 && point.radius.is_finite())) {
        return Err(ShapeError::Radius(point.radius));
    }
    if curve.len() < kind.order() {
        return Err(ShapeError::ControlPoints { found: curve.len(), least: kind.order() });
    }
    if !curve.iter().all(can_be_squared) {
        return Err(ShapeError::Placement);
    }
    Ok(())
}

/// Whether nothing overflows that is computed from it.
fn can_be_squared(point: &ControlPoint) -> bool {
    point.position.abs().max_element().max(point.radius) < 1e75 && point.position.is_finite()
}

fn cone(points: [ControlPoint; 2], origin: Vec3) -> RoundCone {
    RoundCone::new(points.map(|point| point.position - origin), points.map(|point| point.radius))
}

fn spline_segment(points: [ControlPoint; 4], origin: Vec3) -> SplineSegment {
    SplineSegment::of_spline(points.map(|point| point.position - origin), points.map(|point| point.radius))
}
