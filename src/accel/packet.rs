//! Four triangles, tested at once; see [`crate::shape::RaySpace`] for the test.

use crate::shape::{Hit, RaySpace};
use wide::f64x4;

pub(super) const WIDTH: usize = 4;

/// Unused lanes hold a triangle without area, which nothing hits.
#[derive(Clone, Debug, Default)]
pub(super) struct Packet {
    /// `[vertex][axis][lane]`, world space.
    vertices: [[[f32; WIDTH]; 3]; 3],
    shape: [u32; WIDTH],
    triangle: [u32; WIDTH],
}

struct Distances {
    hit: u32,
    t: f64x4,
    v: f64x4,
    w: f64x4,
}

impl Packet {
    pub fn set(&mut self, lane: usize, vertices: [[f32; 3]; 3], shape: u32, triangle: u32) {
        for (vertex, coordinates) in vertices.iter().enumerate() {
            for (axis, &coordinate) in coordinates.iter().enumerate() {
                self.vertices[vertex][axis][lane] = coordinate;
            }
        }
        self.shape[lane] = shape;
        self.triangle[lane] = triangle;
    }

    /// Reports every triangle hit with 0 ≤ t < `t_max`.
    #[inline(always)]
    pub fn intersect(&self, space: &RaySpace, t_max: f64, mut report: impl FnMut(Hit)) {
        let Some(distances) = self.distances(space, t_max) else { return };
        let (t, v, w) = (distances.t.to_array(), distances.v.to_array(), distances.w.to_array());
        let mut mask = distances.hit;
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize & 3;
            mask &= mask - 1;
            report(Hit {
                t: t[lane],
                shape: self.shape[lane],
                triangle: self.triangle[lane],
                barycentric: [v[lane], w[lane]],
            });
        }
    }

    #[inline(always)]
    pub fn occludes(&self, space: &RaySpace, t_max: f64) -> bool {
        self.distances(space, t_max).is_some()
    }

    /// The scalar test's operations in the scalar test's order, so that the bits agree. No fused
    /// multiply-add: it would round the two products of an edge function differently.
    #[inline(always)]
    fn distances(&self, space: &RaySpace, t_max: f64) -> Option<Distances> {
        let [a, b, c] = [0, 1, 2].map(|vertex| self.sheared(vertex, space));
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        let zero = f64x4::ZERO;
        let negative = u.simd_lt(zero) | v.simd_lt(zero) | w.simd_lt(zero);
        let positive = u.simd_gt(zero) | v.simd_gt(zero) | w.simd_gt(zero);
        let outside = (negative & positive).to_bitmask();
        if outside == 0b1111 {
            return None;
        }
        let determinant = u + v + w;
        let t = (u * a[2] + v * b[2] + w * c[2]) / determinant;
        let range = t.simd_ge(zero) & t.simd_lt(f64x4::splat(t_max)) & determinant.simd_ne(zero);
        let hit = range.to_bitmask() & !outside;
        (hit != 0).then(|| Distances { hit, t, v: v / determinant, w: w / determinant })
    }

    #[inline(always)]
    fn sheared(&self, vertex: usize, space: &RaySpace) -> [f64x4; 3] {
        let [x, y, z] = space.axes.map(|axis| {
            let lanes = self.vertices[vertex][axis % 3];
            f64x4::new(lanes.map(f64::from)) - f64x4::splat(space.origin[axis])
        });
        let shear = space.shear.map(f64x4::splat);
        [x - shear[0] * z, y - shear[1] * z, shear[2] * z]
    }
}
