//! Bodies that a ball sweeps: closed, with round ends, of one piece or several.
//!
//! A line is within such a body where it is within any of the balls: the union of intervals, one or more for
//! each piece of the path. So what lies inside is never met, and every line is entered and left by turns.

use super::round_cone::RoundCone;
use super::spline::SplineSegment;
use super::{ControlPoint, CurveKind, Near, Span, check, cone, spline_segment};
use crate::geometry::{Bounds, Ray, SurfacePoint, Transform, Vec3, angle};
use crate::shape::crossing::Crossings;
use crate::shape::placement::Placement;
use crate::shape::random_lines::{self, Crossed, OnLine};
use crate::shape::{AreaSample, Parametrisation, ShapeError, SurfaceHit};
use smallvec::SmallVec;
use std::f64::consts::TAU;

#[derive(Clone, Debug)]
enum Piece {
    Straight(RoundCone),
    Curved(SplineSegment),
}

impl Piece {
    fn spans(&self, line: &Near) -> SmallVec<[Span; 2]> {
        match self {
            Self::Straight(cone) => cone.span(line).into_iter().collect(),
            Self::Curved(segment) => segment.ball_spans(line),
        }
    }

    /// Centre, its derivative, and the radius.
    fn ball(&self, u: f64) -> (Vec3, Vec3, f64) {
        match self {
            Self::Straight(cone) => (cone.centre(u), cone.along, cone.radius(u)),
            Self::Curved(segment) => (segment.centre(u), segment.velocity(u), segment.radius(u)),
        }
    }

    fn ball_at(&self, point: Vec3) -> f64 {
        match self {
            Self::Straight(cone) => cone.ball_at(point),
            Self::Curved(segment) => segment.ball_at(point),
        }
    }

    fn middle(&self) -> Vec3 {
        match self {
            Self::Straight(cone) => cone.middle(),
            Self::Curved(segment) => segment.middle(),
        }
    }

    fn reach(&self) -> f64 {
        match self {
            Self::Straight(cone) => cone.reach(),
            Self::Curved(segment) => segment.reach(),
        }
    }

    fn bounds(&self) -> Bounds {
        match self {
            Self::Straight(cone) => cone.bounds(),
            Self::Curved(segment) => segment.bounds(),
        }
    }

    /// The greatest direction · c(u) + `stretch` r(u).
    fn farthest(&self, direction: Vec3, stretch: f64) -> f64 {
        match self {
            Self::Straight(cone) => {
                let at = |u: f64| direction.dot(cone.centre(u)) + stretch * cone.radius(u);
                at(0.0).max(at(1.0))
            }
            Self::Curved(curved) => curved.farthest(direction, stretch),
        }
    }
}

/// A ball that changes its radius while it moves along curves, and all that it passes.
#[derive(Clone, Debug)]
pub struct SweptSphere {
    /// Transform from coordinates in which it fits into the unit ball.
    placement: Placement,
    pieces: Vec<Piece>,
    /// Middles and reaches of the pieces.
    balls: Vec<(Vec3, f64)>,
    /// For each piece, whether it goes on from the one before.
    continues: Vec<bool>,
    around: Bounds,
    inward: bool,
}

impl SweptSphere {
    /// `to_world` applied to the whole, radii included. Every curve needs two control points, or four for
    /// B-splines. Normals point outward unless `flip_normals`.
    pub fn new(
        to_world: &Transform,
        kind: CurveKind,
        curves: &[Vec<ControlPoint>],
        flip_normals: bool,
    ) -> Result<Self, ShapeError> {
        curves.iter().try_for_each(|curve| check(kind, curve))?;
        let made = |origin: Vec3, scale: f64| -> Vec<Piece> {
            let local = |point: &ControlPoint| ControlPoint {
                position: (point.position - origin) / scale,
                radius: point.radius / scale,
            };
            let windows = curves.iter().flat_map(|curve| curve.windows(kind.order()));
            let piece = |points: &[ControlPoint]| match *points {
                [a, b] => Piece::Straight(cone([a, b].map(|p| local(&p)), Vec3::ZERO)),
                [a, b, c, d] => Piece::Curved(spline_segment([a, b, c, d].map(|p| local(&p)), Vec3::ZERO)),
                _ => unreachable!("windows of two or of four"),
            };
            windows.map(piece).collect()
        };
        let around = |pieces: &[Piece]| Bounds::of_all(pieces.iter().map(Piece::bounds));
        let whole = around(&made(Vec3::ZERO, 1.0));
        let (origin, scale) = (whole.centre(), 0.5 * whole.diameter());
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(ShapeError::Nothing);
        }
        let pieces = made(origin, scale);
        if curves.iter().flatten().all(|point| point.radius == 0.0) {
            return Err(ShapeError::Radius(0.0));
        }
        let place = Transform::scale(scale).then(&Transform::translation(origin)).then(to_world);
        Ok(Self {
            placement: Placement::new(&place)?,
            balls: pieces.iter().map(|piece| (piece.middle(), piece.reach())).collect(),
            continues: curves
                .iter()
                .flat_map(|curve| (0..=curve.len() - kind.order()).map(|i| i > 0))
                .collect(),
            around: around(&pieces),
            pieces,
            inward: flip_normals,
        })
    }

    /// Nearest distance with 0 ≤ t < `ray.t_max`, and the piece that is met.
    pub fn intersect(&self, ray: &Ray) -> Option<(f64, u32)> {
        self.placement.nearest(ray, |origin, direction| self.crossed(origin, direction))
    }

    /// All crossings along the whole line.
    pub fn crossings(&self, ray: &Ray) -> Crossings {
        self.placement.crossings(ray, self.inward, |origin, direction| self.crossed(origin, direction))
    }

    /// The point of a piece's surface nearest to `position`, in local space.
    pub fn surface(&self, position: Vec3, part: u32) -> SurfaceHit {
        self.surface_at(self.placement.pose.local_point(position), part)
    }

    fn surface_at(&self, local: Vec3, part: u32) -> SurfaceHit {
        let piece = &self.pieces[part as usize];
        let (centre, _, radius) = piece.ball(piece.ball_at(local));
        let outward = (local - centre).try_normalize().unwrap_or(Vec3::Z);
        let position = self.placement.pose.world_point(centre + outward * radius);
        let image = self.placement.pose.world_normal(outward);
        let stretch = image.length();
        let error = self.placement.error(position, outward, stretch) + 32.0 * f64::EPSILON / stretch;
        let normal = image / if self.inward { -stretch } else { stretch };
        SurfaceHit { point: SurfacePoint { position, normal, error }, shading_normal: normal }
    }

    /// u around the path as on `Curves`, v along all pieces of all curves; on the round ends v stands still.
    pub fn parametrisation(&self, position: Vec3, part: u32) -> Parametrisation {
        let local = self.placement.pose.local_point(position);
        let part = self.owner(local, part);
        let (piece, count) = (&self.pieces[part as usize], self.pieces.len() as f64);
        let u = piece.ball_at(local);
        let (centre, velocity, _) = piece.ball(u);
        let outward = local - centre;
        let ahead = velocity.try_normalize().unwrap_or(Vec3::Z);
        let up = Vec3::Z.reject_from_normalized(ahead).try_normalize().unwrap_or(Vec3::Y);
        let side = up.cross(ahead);
        let turn = angle::atan2(outward.dot(up), outward.dot(side)) / TAU;
        let around = ahead.cross(outward);
        // Along the surface, across the way around; as long as the path's step.
        let along = velocity.reject_from(outward);
        let along = if along.is_finite() { along } else { Vec3::ZERO };
        Parametrisation {
            uv: [turn.rem_euclid(1.0), (u + f64::from(part)) / count],
            tangent: self.placement.pose.world_vector(around * TAU),
            bitangent: self.placement.pose.world_vector(along * count),
        }
    }

    /// The piece that a point met on a piece belongs to: the ball at a joint, on which either may have been
    /// met, to the one that ends there, as in [`super::Curves`].
    fn owner(&self, local: Vec3, part: u32) -> u32 {
        let at_its_begin = self.continues[part as usize] && self.pieces[part as usize].ball_at(local) == 0.0;
        if at_its_begin && self.pieces[part as usize - 1].ball_at(local) == 1.0 { part - 1 } else { part }
    }

    /// The smallest box.
    pub fn bounds(&self) -> Bounds {
        let linear = self.placement.pose.linear;
        let (mut min, mut max) = (Vec3::ZERO, Vec3::ZERO);
        for axis in 0..3 {
            let row = linear.row(axis);
            let toward = |direction: Vec3| {
                let reach = self.pieces.iter().map(|piece| piece.farthest(direction, direction.length()));
                reach.fold(f64::NEG_INFINITY, f64::max)
            };
            (min[axis], max[axis]) = (-toward(-row), toward(row));
        }
        Bounds { min: self.placement.pose.origin + min, max: self.placement.pose.origin + max }
    }

    /// Area, to a relative error of about 10⁻³.
    pub fn area(&self) -> f64 {
        random_lines::integral(self, |normal| self.placement.area_stretch(normal))
    }

    /// See `random_lines`: for some `u` there is no point.
    pub fn sample(&self, u: [f64; 2]) -> Option<AreaSample> {
        let (local, part) = random_lines::sample(self, u)?;
        let density = self.local_area_density(local, self.normal(local, part));
        Some(AreaSample { triangle: part, ..AreaSample::analytic(self.surface_at(local, part), density) })
    }

    /// Density per area with which a sample is the point.
    pub fn area_density(&self, point: &SurfacePoint) -> f64 {
        let normal = self.placement.pose.local_normal(point.normal).normalize_or_zero();
        self.local_area_density(self.placement.pose.local_point(point.position), normal)
    }

    fn local_area_density(&self, local: Vec3, normal: Vec3) -> f64 {
        random_lines::density(self, local, normal) / self.placement.area_stretch(normal)
    }
}

impl Crossed for SweptSphere {
    fn around(&self) -> Bounds {
        self.around
    }

    fn normal(&self, point: Vec3, part: u32) -> Vec3 {
        let piece = &self.pieces[part as usize];
        let (centre, ..) = piece.ball(piece.ball_at(point));
        (point - centre).try_normalize().unwrap_or(Vec3::Z)
    }

    fn crossed(&self, origin: Vec3, direction: Vec3) -> SmallVec<[OnLine; 4]> {
        let coordinate = self.placement.coordinate_error(1.0 + origin.abs().max_element());
        let mut spans: SmallVec<[(Span, u32); 8]> = SmallVec::new();
        let Some((line, shift)) = Near::new(origin, direction, Vec3::ZERO, 1.0 + 1e-9) else {
            return SmallVec::new();
        };
        let line = Near { rounding: line.rounding + coordinate, ..line };
        for ((part, piece), (middle, reach)) in (0..).zip(&self.pieces).zip(&self.balls) {
            let off = (middle - line.start).reject_from_normalized(direction).length_squared();
            let limit = reach + line.rounding;
            if off <= limit * limit {
                spans.extend(piece.spans(&line).into_iter().map(|span| (span, part)));
            }
        }
        spans.sort_by(|a, b| a.0.enter.t.total_cmp(&b.0.enter.t));
        let mut found: SmallVec<[OnLine; 4]> = SmallVec::new();
        for (span, part) in spans {
            let on_line = |spot: super::Spot, enters: bool| {
                let rounding = 4.0 * f64::EPSILON * (shift.abs() + spot.t.abs());
                OnLine { t: shift + spot.t, error: spot.error + rounding, enters, part }
            };
            let (enter, leave) = (on_line(span.enter, true), on_line(span.leave, false));
            match found.last_mut() {
                // It goes on where another has not ended yet.
                Some(last) if enter.t <= last.t => {
                    if leave.t > last.t {
                        *last = leave;
                    }
                }
                _ => found.extend([enter, leave]),
            }
        }
        found
    }
}
