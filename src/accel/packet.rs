//! Four triangles, tested at once; see [`crate::shape::RaySpace`] for the test.

use super::Primitive;
use super::few::FewTriangle;
use crate::geometry::Vec3;
use crate::shape::{Hit, NO_INSTANCE, RaySpace};
use std::hint::black_box;
use wide::f64x4;

pub(super) const WIDTH: usize = 4;

/// Unused lanes hold a triangle without area, which nothing hits. Begins where a cache line does.
#[derive(Clone, Debug, Default)]
#[repr(align(64))]
pub(super) struct Packet {
    /// `[vertex][axis][lane]`, world space.
    vertices: [[[f32; WIDTH]; 3]; 3],
    shape: [u32; WIDTH],
    triangle: [u32; WIDTH],
}

/// [`RaySpace`] as packets ask for it.
pub(super) struct PacketRay {
    axes: [usize; 3],
    /// In the order of the axes.
    origin: [f64; 3],
    shear: [f64; 3],
}

impl PacketRay {
    #[inline(always)]
    pub fn new(space: &RaySpace) -> Self {
        // An array: a vector's component by a computed axis would be a branch.
        let origin = space.origin.to_array();
        let [x, y, z] = space.axes;
        Self { axes: space.axes, origin: [origin[x % 3], origin[y % 3], origin[z % 3]], shear: space.shear }
    }
}

/// Edge functions and distances of four triangles, and a bit for every one that is hit.
struct Test {
    hit: u32,
    t: f64x4,
    v: f64x4,
    w: f64x4,
    determinant: f64x4,
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

    /// Its triangles, those of unused lanes among them.
    pub fn triangles(&self) -> impl Iterator<Item = FewTriangle> {
        (0..WIDTH).map(|lane| FewTriangle {
            vertices: self
                .vertices
                .map(|vertex| Vec3::from_array(vertex.map(|coordinates| f64::from(coordinates[lane])))),
            primitive: Primitive { shape: self.shape[lane], triangle: self.triangle[lane] },
        })
    }

    /// Reports every triangle hit with 0 ≤ t ≤ `t_last`.
    #[inline(always)]
    pub fn intersect(&self, ray: &PacketRay, t_last: f64, mut report: impl FnMut(Hit)) {
        let test = self.test(ray, t_last);
        let mut mask = test.hit;
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize & 3;
            mask &= mask - 1;
            let determinant = test.determinant.as_array()[lane];
            report(Hit {
                t: test.t.as_array()[lane],
                shape: self.shape[lane],
                triangle: self.triangle[lane],
                instance: NO_INSTANCE,
                barycentric: [test.v.as_array()[lane] / determinant, test.w.as_array()[lane] / determinant],
            });
        }
    }

    #[inline(always)]
    pub fn occludes(&self, ray: &PacketRay, t_last: f64) -> bool {
        self.test(ray, t_last).hit != 0
    }

    /// The scalar test's operations in the scalar test's order, so that the bits agree. No fused
    /// multiply-add: it would round the two products of an edge function differently.
    #[inline(always)]
    fn test(&self, ray: &PacketRay, t_last: f64) -> Test {
        // As in [`super::node::Node::entered`].
        let ray = black_box(ray);
        let (a, b, c) = (self.sheared(0, ray), self.sheared(1, ray), self.sheared(2, ray));
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        let zero = f64x4::ZERO;
        let determinant = u + v + w;
        let lowest = u.fast_min(v).fast_min(w);
        let highest = u.fast_max(v).fast_max(w);
        let inside = (lowest.simd_ge(zero) | highest.simd_le(zero)) & determinant.simd_ne(zero);
        if inside.to_bitmask() == 0 {
            return Test { hit: 0, t: zero, v, w, determinant };
        }
        let t = (u * a[2] + v * b[2] + w * c[2]) / determinant;
        let range = t.simd_ge(zero) & t.simd_le(f64x4::splat(t_last));
        Test { hit: (inside & range).to_bitmask(), t, v, w, determinant }
    }

    #[inline(always)]
    fn sheared(&self, vertex: usize, ray: &PacketRay) -> [f64x4; 3] {
        let relative = |i: usize| {
            let [a, b, c, d] = self.vertices[vertex][ray.axes[i] % 3];
            f64x4::new([f64::from(a), f64::from(b), f64::from(c), f64::from(d)]) - f64x4::splat(ray.origin[i])
        };
        let [shear_x, shear_y, shear_z] = ray.shear.map(f64x4::splat);
        let (x, y, z) = (relative(0), relative(1), relative(2));
        [x - shear_x * z, y - shear_y * z, shear_z * z]
    }
}
