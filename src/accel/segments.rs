//! Rays in lanes, and the exact test of a triangle against them: in each lane what
//! [`crate::shape::RaySpace`] does.

use super::few::FewSphere;
use crate::geometry::{Points, Segments, SurfacePoint, Vec3};
use crate::lanes::{Mask, Real, Register, Truth, Vec3Lanes};

/// Rays of one register as triangles ask for them.
pub(super) struct RayLanes {
    origin: Vec3Lanes,
    shear: [Register; 3],
    /// Lanes whose direction is largest along the last axis, and along the middle one.
    largest: [Register; 2],
}

/// Segments from each point to the same other one.
pub(super) struct FanSegments {
    rays: RayLanes,
    direction: Vec3Lanes,
    length: Register,
}

/// Where the lines of the rays meet a triangle.
pub(super) struct Crossings {
    /// The lanes whose line goes through it.
    pub inside: Truth,
    pub t: Register,
    /// Weights of the second and third vertex times the determinant, and that.
    pub v: Register,
    pub w: Register,
    pub determinant: Register,
}

impl FanSegments {
    #[inline(always)]
    pub fn new(points: &Points<Register>, target: &SurfacePoint) -> Self {
        let Segments { origin, direction, length } = points.segments_to(&Points::of(target));
        Self { rays: RayLanes::new(origin, direction), direction, length }
    }

    /// Which of those asked for meet a sphere.
    #[inline(always)]
    pub fn meet_sphere(&self, sphere: &FewSphere, asked: Mask) -> Mask {
        let found = sphere.distance(self.rays.origin, self.direction, self.length, asked);
        found.map_or(0, |(t, met)| (met & t.lt(self.length)).mask())
    }

    /// Which of them meet a triangle.
    #[inline(always)]
    pub fn meet(&self, triangle: &[Vec3; 3]) -> Mask {
        let Some(found) = self.rays.cross(triangle) else { return 0 };
        (found.inside & found.t.ge(Register::ZERO) & found.t.lt(self.length)).mask()
    }
}

/// A vector's components so that the largest of the direction comes last.
#[inline(always)]
fn in_order([x, y, z]: [Register; 3], [last, second]: [Register; 2]) -> [Register; 3] {
    [
        last.select(x, second.select(z, y)),
        last.select(y, second.select(x, z)),
        last.select(z, second.select(y, x)),
    ]
}

impl RayLanes {
    #[inline(always)]
    pub fn new(origin: Vec3Lanes, direction: Vec3Lanes) -> Self {
        let Vec3Lanes { x, y, z } = direction;
        let size = [x.abs(), y.abs(), z.abs()];
        let second = size[1].simd_ge(size[0]);
        let last = size[2].simd_ge(second.select(size[1], size[0]));
        let largest = [last, second];
        let d = in_order([x, y, z], largest);
        Self { origin, shear: [d[0] / d[2], d[1] / d[2], Register::ONE / d[2]], largest }
    }

    /// Where the lines of all lanes meet a triangle. `None` where none goes through it.
    #[inline(always)]
    pub fn cross(&self, triangle: &[Vec3; 3]) -> Option<Crossings> {
        let [a, b, c] = triangle.map(|vertex| self.sheared(vertex));
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        let determinant = u + v + w;
        let lowest = u.fast_min(v).fast_min(w);
        let highest = u.fast_max(v).fast_max(w);
        let zero = Register::ZERO;
        let inside = (lowest.ge(zero) | highest.le(zero)) & !determinant.eq(zero);
        if inside.mask() == 0 {
            return None;
        }
        let t = (u * a[2] + v * b[2] + w * c[2]) / determinant;
        Some(Crossings { inside, t, v, w, determinant })
    }

    #[inline(always)]
    fn sheared(&self, vertex: Vec3) -> [Register; 3] {
        let Vec3Lanes { x, y, z } = Vec3Lanes::of(vertex) - self.origin;
        let [x, y, z] = in_order([x, y, z], self.largest);
        [x - self.shear[0] * z, y - self.shear[1] * z, self.shear[2] * z]
    }
}
