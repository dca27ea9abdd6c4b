//! Choosing points on meshes.

use super::{Mesh, to_f64};
use crate::geometry::UvTransform;
use crate::geometry::Vec3;
use crate::shape::areas::AreaDistribution;
use crate::shape::{AreaSample, ShapeSample};

impl Mesh {
    fn areas(&self) -> &AreaDistribution {
        self.areas.get_or_init(|| {
            AreaDistribution::new(self.data.indices.iter().map(|&indices| {
                let [a, b, c] = indices.map(|index| to_f64(self.data.positions[index as usize]));
                0.5 * (b - a).cross(c - a).length()
            }))
        })
    }

    /// Whether it is one rectangle of two triangles.
    pub fn is_rectangle(&self) -> bool {
        self.rectangle.is_some()
    }

    /// From fractions of the rectangle's edges to uv, where both triangles agree on one such map.
    pub fn rectangle_uv(&self) -> Option<UvTransform> {
        self.rectangle?;
        let uvs = self.data.uvs.as_ref()?;
        let corner = |index: usize| uvs[index].map(f64::from);
        let [origin, x, far, y] = [0, 1, 2, 3].map(corner);
        let rows = [0, 1].map(|i| [x[i] - origin[i], y[i] - origin[i], origin[i]]);
        let agrees = |i: usize| {
            let [a, b, c] = rows[i];
            (a + b + c - far[i]).abs() <= 1e-6 * (a.abs() + b.abs() + c.abs())
        };
        (agrees(0) && agrees(1)).then_some(UvTransform(rows))
    }

    /// Where on the unit square a point lies: of the rectangle, or of what [`Mesh::sample_triangle`] takes.
    pub fn chart_place(&self, triangle: u32, [v, w]: [f64; 2]) -> [f64; 2] {
        if self.rectangle.is_none() {
            return triangle_to_square([v, w]);
        }
        let [a, b, c] = self.data.indices[triangle as usize].map(|index| CORNERS[index as usize]);
        [0, 1].map(|i| (a[i] + v * (b[i] - a[i]) + w * (c[i] - a[i])).clamp(0.0, 1.0))
    }

    /// Total area of all triangles.
    pub fn area(&self) -> f64 {
        self.areas().total()
    }

    /// Area of a triangle.
    pub fn triangle_area(&self, triangle: u32) -> f64 {
        let [a, b, c] = self.triangle(triangle);
        0.5 * (b - a).cross(c - a).length()
    }

    /// Uniform over one triangle. `None` where that has no area.
    pub fn sample_triangle(&self, triangle: u32, u: [f64; 2]) -> Option<AreaSample> {
        let area = self.triangle_area(triangle);
        let barycentric = square_to_triangle(u);
        let surface = self.surface(triangle, barycentric);
        (area > 0.0).then_some(AreaSample { surface, triangle, barycentric, density: 1.0 / area })
    }

    /// Uniform in area. `None` for a mesh without area.
    pub fn sample(&self, u: [f64; 2]) -> Option<AreaSample> {
        let area = self.area();
        if area.is_nan() || area <= 0.0 {
            return None;
        }
        if self.rectangle.is_some() {
            let (triangle, barycentric) = self.rectangle_place(u);
            let surface = self.surface(triangle, barycentric);
            return Some(AreaSample { surface, triangle, barycentric, density: 1.0 / area });
        }
        let (triangle, fraction) = self.areas().choose(u[0]);
        let triangle = triangle as u32;
        // The square folded along its diagonal, and corrected for the fold (as in
        // Heitz, "A Low-Distortion Map Between Triangle and Square", 2019): continuous, area-preserving.
        let barycentric = square_to_triangle([fraction, u[1]]);
        let surface = self.surface(triangle, barycentric);
        Some(AreaSample { surface, triangle, barycentric, density: 1.0 / area })
    }

    /// Where Mitsuba 3 puts a point of the unit square: a rectangle keeps its coordinates; of any other mesh
    /// the second coordinate runs through the triangles by area, and the first and what is left of it over
    /// the triangle.
    pub fn point_at_uv(&self, u: [f64; 2]) -> Option<AreaSample> {
        let area = self.area();
        if area.is_nan() || area <= 0.0 {
            return None;
        }
        let (triangle, barycentric) = if self.rectangle.is_some() {
            self.rectangle_place(u)
        } else {
            let (triangle, fraction) = self.areas().choose(u[1]);
            let across = (1.0 - u[0]).sqrt();
            (triangle as u32, [1.0 - across, across * fraction])
        };
        let surface = self.surface(triangle, barycentric);
        Some(AreaSample { surface, density: 1.0 / area, triangle, barycentric })
    }

    /// Density per area of samples: one over the area.
    pub fn area_density(&self) -> f64 {
        let area = self.area();
        if area > 0.0 { 1.0 / area } else { 0.0 }
    }

    /// Uniform in solid angle, where the mesh is a rectangle that appears large enough.
    pub fn sample_rectangle(&self, reference: Vec3, u: [f64; 2]) -> Option<ShapeSample> {
        let seen = self.rectangle?.seen_from(reference)?;
        let (triangle, barycentric) = self.rectangle_place(seen.sample(u));
        Some(ShapeSample {
            surface: self.surface(triangle, barycentric),
            triangle,
            barycentric,
            density: 1.0 / seen.solid_angle(),
        })
    }

    /// Density of [`Mesh::sample_rectangle`], wherever it is defined.
    pub fn rectangle_density(&self, reference: Vec3) -> Option<f64> {
        Some(1.0 / self.rectangle?.seen_from(reference)?.solid_angle())
    }

    /// The triangle that holds the point at fractions of the first rectangle's edges, and where on it:
    /// rounded vertices needn't lie in one plane.
    fn rectangle_place(&self, [x, y]: [f64; 2]) -> (u32, [f64; 2]) {
        // Triangle 0 holds the corner (1, 0), triangle 1 the corner (0, 1).
        let triangle = u32::from(y > x);
        let fractions = self.data.indices[triangle as usize].map(|index| CORNERS[index as usize]);
        let [a, b, c] = fractions;
        let (ab, ac) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
        let determinant = ab[0] * ac[1] - ab[1] * ac[0];
        let (px, py) = (x - a[0], y - a[1]);
        let v = (px * ac[1] - py * ac[0]) / determinant;
        let w = (ab[0] * py - ab[1] * px) / determinant;
        (triangle, [v, w])
    }
}

/// Where the vertices of [`Mesh::rectangle`] lie on the unit square.
pub(super) const CORNERS: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

/// Weights of the second and third vertex, uniform over the triangle.
fn square_to_triangle([x, y]: [f64; 2]) -> [f64; 2] {
    if y > x {
        let b = 0.5 * x;
        [b, y - b]
    } else {
        let c = 0.5 * y;
        [x - c, c]
    }
}

/// [`square_to_triangle`] taken back.
fn triangle_to_square([b, c]: [f64; 2]) -> [f64; 2] {
    // Below the diagonal the first weight is y / 2 less than x, above it the second.
    if c > b { [2.0 * b, c + b] } else { [b + c, 2.0 * c] }.map(|x| x.clamp(0.0, 1.0))
}
