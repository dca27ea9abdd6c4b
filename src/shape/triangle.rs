//! One ray against one triangle: the watertight test of Woop, Benthin and Wald ("Watertight Ray/Triangle
//! Intersection", JCGT 2(1), 2013) in `f64`.
//!
//! Space is sheared so that the ray runs along +z from the origin. Three edge functions then say on which
//! side of each edge the ray passes. Two triangles that share an edge compute the very same
//! products for it, so one gets the negative of the other's result; and since rounding keeps order, the sign
//! of a difference of two rounded products is right or zero. Zero counts as inside: no ray slips through.

use crate::geometry::{Ray, Vec3};
use std::hint::select_unpredictable;

/// The shear that takes a ray to the z axis.
#[derive(Clone, Copy, Debug)]
pub struct RaySpace {
    /// Where the ray begins.
    pub origin: Vec3,
    /// World axes in the order in which they become x, y and z; z is the direction's largest.
    pub axes: [usize; 3],
    /// Shear and scale that turn the ray to +z (Woop, Benthin and Wald 2013).
    pub shear: [f64; 3],
}

/// 1 or -1: on which side of an edge, or of a triangle, a line passes.
type Side = i32;

/// The sign of q × p as seen from the z axis, exactly, and as seen from a place beside it, (ε, ε²) from
/// there, where it is 0. 0 only where p and q coincide there.
fn side_of_edge(q: [f64; 3], p: [f64; 3]) -> Side {
    let (first, second) = (q[0] * p[1], q[1] * p[0]);
    let order = |a: f64, b: f64| a.partial_cmp(&b).map_or(0, |order| order as Side);
    // Rounding keeps order: products that differ when rounded differ like that.
    let mut side = order(first, second);
    if side == 0 {
        // What each lost in rounding is known exactly.
        side = order(q[0].mul_add(p[1], -first), q[1].mul_add(p[0], -second));
    }
    if side == 0 {
        side = order(q[1], p[1]);
    }
    if side == 0 { order(p[0], q[0]) } else { side }
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// Distance along the ray.
    pub t: f64,
    /// Weights of the second and third vertex.
    pub barycentric: [f64; 2],
}

impl RaySpace {
    /// The space in which a ray runs along z from the origin.
    #[inline]
    pub fn new(ray: &Ray) -> Self {
        let d = ray.direction.to_array();
        let size = d.map(f64::abs);
        // No branches: which axis it will be nothing can foresee.
        let of_two = usize::from(size[1] >= size[0]);
        let z = select_unpredictable(size[2] >= size[of_two], 2, of_two);
        let (x, y) = ([1, 2, 0][z], [2, 0, 1][z]);
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

    /// Whether the line goes through a triangle, told by exact signs, so that it crosses a closed mesh as
    /// often inwards as outwards wherever it goes. `vertices` are sheared.
    ///
    /// A line through an edge or a vertex is taken as moved aside by an infinitely small step (Edelsbrunner
    /// and Mücke, "Simulation of Simplicity", ACM Transactions on Graphics 9(1), 1990), the same for all
    /// triangles: then it never is on one.
    pub fn passes(vertices: [[f64; 3]; 3]) -> Option<Side> {
        let [a, b, c] = vertices;
        let side = side_of_edge(c, b);
        (side != 0 && side_of_edge(a, c) == side && side_of_edge(b, a) == side).then_some(side)
    }

    /// Where a line that passes a triangle of sheared vertices does so. The second number bounds how far off
    /// that may be, however flat the line comes in.
    pub fn place([a, b, c]: [[f64; 3]; 3]) -> (TriangleHit, f64) {
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        let determinant = u + v + w;
        let (low, high) = (a[2].min(b[2]).min(c[2]), a[2].max(b[2]).max(c[2]));
        // Seen edge-on, the line is in the triangle's plane: any place of it will do.
        let fraction =
            |part: f64| if determinant == 0.0 { 1.0 / 3.0 } else { (part / determinant).clamp(0.0, 1.0) };
        let barycentric = [fraction(v), fraction(w)];
        let [v, w] = barycentric;
        let t = a[2] + (b[2] - a[2]) * v + (c[2] - a[2]) * w;
        (TriangleHit { t: t.clamp(low, high), barycentric }, high - low)
    }

    /// A vertex in coordinates in which the line is the z axis.
    pub fn sheared(&self, vertex: Vec3) -> [f64; 3] {
        // An array: a vector's component by a computed axis would be a branch.
        let relative = (vertex - self.origin).to_array();
        let [x, y, z] = self.axes.map(|axis| relative[axis]);
        [x - self.shear[0] * z, y - self.shear[1] * z, self.shear[2] * z]
    }
}
