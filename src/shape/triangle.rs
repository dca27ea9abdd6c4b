//! One ray against one triangle: the watertight test of Woop, Benthin and Wald ("Watertight Ray/Triangle
//! Intersection", JCGT 2(1), 2013) in `f64`.
//!
//! Space is sheared so that the ray runs along +z from the origin. Three edge functions then say on which
//! side of each edge the ray passes. Two triangles that share an edge compute the very same
//! products for it, so one gets the negative of the other's result; and since rounding keeps order, the sign
//! of a difference of two rounded products is right or zero. Zero counts as inside: no ray slips through.

use crate::geometry::{Ray, Vec3};

/// The shear that takes a ray to the z axis.
#[derive(Clone, Copy, Debug)]
pub struct RaySpace {
    pub origin: Vec3,
    /// World axes in the order in which they become x, y and z; z is the direction's largest.
    pub axes: [usize; 3],
    pub shear: [f64; 3],
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    pub t: f64,
    /// Weights of the second and third vertex.
    pub barycentric: [f64; 2],
}

impl RaySpace {
    pub fn new(ray: &Ray) -> Self {
        let d = ray.direction.to_array();
        let size = d.map(f64::abs);
        let z = if size[0] > size[1] && size[0] > size[2] {
            0
        } else if size[1] > size[2] {
            1
        } else {
            2
        };
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        Self { origin: ray.origin, axes: [x, y, z], shear: [d[x] / d[z], d[y] / d[z], 1.0 / d[z]] }
    }

    /// The hit with 0 ≤ t < `t_max`, from either side. Degenerate triangles and those seen edge-on miss.
    pub fn intersect(&self, vertices: [Vec3; 3], t_max: f64) -> Option<TriangleHit> {
        self.cross(vertices).filter(|hit| hit.t >= 0.0 && hit.t < t_max)
    }

    /// The hit with the whole line.
    pub fn cross(&self, vertices: [Vec3; 3]) -> Option<TriangleHit> {
        let [a, b, c] = vertices.map(|vertex| self.sheared(vertex));
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let determinant = u + v + w;
        if determinant == 0.0 {
            return None;
        }
        let t = (u * a[2] + v * b[2] + w * c[2]) / determinant;
        Some(TriangleHit { t, barycentric: [v / determinant, w / determinant] })
    }

    fn sheared(&self, vertex: Vec3) -> [f64; 3] {
        let relative = vertex - self.origin;
        let [x, y, z] = self.axes.map(|axis| relative[axis]);
        [x - self.shear[0] * z, y - self.shear[1] * z, self.shear[2] * z]
    }
}
