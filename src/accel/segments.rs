//! Segments between surfaces in lanes, and the exact test of a triangle against them: in each lane what
//! [`SurfacePoint::segment_to`] and [`crate::shape::RaySpace`] do.

use crate::geometry::{SurfacePoint, Vec3};
use crate::lanes::{Mask, Vec3Lanes, WIDTH};
use wide::f64x4;

/// Surface points of one register.
#[derive(Clone, Copy, Debug)]
pub(super) struct Points {
    pub position: Vec3Lanes,
    pub normal: Vec3Lanes,
    pub error: f64x4,
}

/// From each point to the same other one.
pub(super) struct Segments {
    origin: Vec3Lanes,
    shear: [f64x4; 3],
    length: f64x4,
    /// Lanes whose direction is largest along the last axis, and along the middle one.
    largest: [f64x4; 2],
    /// Lanes whose segment has a length.
    pub exist: Mask,
    /// Lanes whose direction is near unit length, which that of the shortest may not be.
    pub sound: Mask,
}

impl Points {
    pub const NONE: Self = Self { position: Vec3Lanes::ZERO, normal: Vec3Lanes::ZERO, error: f64x4::ZERO };

    pub fn get(&self, lane: usize) -> SurfacePoint {
        SurfacePoint {
            position: self.position.get(lane),
            normal: self.normal.get(lane),
            error: self.error.as_array()[lane % WIDTH],
        }
    }

    pub fn set(&mut self, lane: usize, point: &SurfacePoint) {
        self.position.set(lane, point.position);
        self.normal.set(lane, point.normal);
        self.error.as_mut_array()[lane % WIDTH] = point.error;
    }

    /// See [`SurfacePoint::leave`].
    #[inline(always)]
    fn leave(&self, direction: Vec3Lanes) -> Vec3Lanes {
        let sign = f64x4::splat(-0.0);
        let side = direction.dot(self.normal) & sign;
        self.position + self.normal * (self.error.abs() | side)
    }

    #[inline(always)]
    pub fn segments_to(&self, target: &SurfacePoint) -> Segments {
        let end = Self {
            position: Vec3Lanes::splat(target.position),
            normal: Vec3Lanes::splat(target.normal),
            error: f64x4::splat(target.error),
        };
        let toward = end.position - self.position;
        let origin = self.leave(toward);
        let error = end.error + f64x4::splat(16.0 * f64::EPSILON) * toward.length();
        let between = Self { error, ..end }.leave(-toward) - origin;
        let length = between.length();
        let direction = Vec3Lanes { x: between.x / length, y: between.y / length, z: between.z / length };
        let Vec3Lanes { x, y, z } = direction;
        let size = [x.abs(), y.abs(), z.abs()];
        let second = size[1].simd_ge(size[0]);
        let last = size[2].simd_ge(second.select(size[1], size[0]));
        let largest = [last, second];
        let d = in_order([x, y, z], largest);
        Segments {
            origin,
            shear: [d[0] / d[2], d[1] / d[2], f64x4::ONE / d[2]],
            length,
            largest,
            exist: length.simd_gt(f64x4::ZERO).to_bitmask(),
            sound: direction.length_squared().simd_le(f64x4::splat(4.0)).to_bitmask(),
        }
    }
}

/// A vector's components so that the largest of the direction comes last.
#[inline(always)]
fn in_order([x, y, z]: [f64x4; 3], [last, second]: [f64x4; 2]) -> [f64x4; 3] {
    [
        last.select(x, second.select(z, y)),
        last.select(y, second.select(x, z)),
        last.select(z, second.select(y, x)),
    ]
}

impl Segments {
    /// Which of them meet a triangle.
    #[inline(always)]
    pub fn meet(&self, triangle: &[Vec3; 3]) -> Mask {
        let [a, b, c] = triangle.map(|vertex| self.sheared(vertex));
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        let determinant = u + v + w;
        let lowest = u.fast_min(v).fast_min(w);
        let highest = u.fast_max(v).fast_max(w);
        let inside =
            (lowest.simd_ge(f64x4::ZERO) | highest.simd_le(f64x4::ZERO)) & determinant.simd_ne(f64x4::ZERO);
        if inside.to_bitmask() == 0 {
            return 0;
        }
        let t = (u * a[2] + v * b[2] + w * c[2]) / determinant;
        (inside & t.simd_ge(f64x4::ZERO) & t.simd_lt(self.length)).to_bitmask()
    }

    #[inline(always)]
    fn sheared(&self, vertex: Vec3) -> [f64x4; 3] {
        let Vec3Lanes { x, y, z } = Vec3Lanes::splat(vertex) - self.origin;
        let [x, y, z] = in_order([x, y, z], self.largest);
        [x - self.shear[0] * z, y - self.shear[1] * z, self.shear[2] * z]
    }
}
