use super::{Ray, SurfacePoint, Vec3};
use crate::lanes::{Real, Register, Vec3Lanes, Vector, WIDTH};

/// Surface points for formulas of one or of several; see [`SurfacePoint`].
#[derive(Clone, Copy, Debug)]
pub struct Points<R> {
    /// Where they are, in scene units.
    pub position: Vector<R>,
    /// Unit geometric normals.
    pub normal: Vector<R>,
    /// Bounds on the error of each coordinate of the positions.
    pub error: R,
}

/// From points to others.
#[derive(Clone, Copy, Debug)]
pub struct Segments<R> {
    /// Where they begin.
    pub origin: Vector<R>,
    /// The direction has unit length, where the segment has any.
    pub direction: Vector<R>,
    /// How long they are, in scene units.
    pub length: R,
}

impl<R: Real> Points<R> {
    /// The same point for all lanes.
    #[inline(always)]
    pub fn of(point: &SurfacePoint) -> Self {
        Self {
            position: Vector::of(point.position),
            normal: Vector::of(point.normal),
            error: R::of(point.error),
        }
    }

    /// See [`SurfacePoint::leave`].
    #[inline(always)]
    pub fn leave(&self, direction: Vector<R>) -> Vector<R> {
        self.position + self.normal * self.error.copysign(direction.dot(self.normal))
    }

    /// See [`SurfacePoint::segment_to`].
    #[inline(always)]
    pub fn segments_to(&self, target: &Self) -> Segments<R> {
        let toward = target.position - self.position;
        let origin = self.leave(toward);
        // A target's error bound is for rays that start on it. Seen from afar, the direction, the
        // differences and products of the intersection test and t round in proportion to the distance.
        let error = target.error + R::of(16.0 * f64::EPSILON) * toward.length();
        let between = Self { error, ..*target }.leave(-toward) - origin;
        let length = between.length();
        Segments { origin, direction: between / length, length }
    }
}

impl From<Points<f64>> for SurfacePoint {
    #[inline(always)]
    fn from(point: Points<f64>) -> Self {
        Self { position: point.position.into(), normal: point.normal.into(), error: point.error }
    }
}

impl Points<Register> {
    /// Points at the origin without a normal.
    pub const NONE: Self = Self { position: Vec3Lanes::ZERO, normal: Vec3Lanes::ZERO, error: Register::ZERO };

    /// The point of one lane.
    pub fn get(&self, lane: usize) -> SurfacePoint {
        SurfacePoint {
            position: self.position.get(lane),
            normal: self.normal.get(lane),
            error: self.error.as_array()[lane % WIDTH],
        }
    }

    /// Puts a point into one lane.
    pub fn set(&mut self, lane: usize, point: &SurfacePoint) {
        self.position.set(lane, point.position);
        self.normal.set(lane, point.normal);
        self.error.as_mut_array()[lane % WIDTH] = point.error;
    }
}

impl Segments<f64> {
    /// `None` where it has no length.
    #[inline(always)]
    pub fn ray(self) -> Option<Ray> {
        let ray = Ray {
            origin: Vec3::from(self.origin),
            direction: Vec3::from(self.direction),
            t_max: self.length,
        };
        (self.length > 0.0).then_some(ray)
    }
}
