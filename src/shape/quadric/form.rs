//! Polynomials of the second degree in x, y and z.

use crate::geometry::Vec3;
use glam::DMat3;

/// xᵀ A x + 2 b·x + c with symmetric A.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadraticForm {
    pub a: DMat3,
    pub b: Vec3,
    pub c: f64,
}

impl QuadraticForm {
    /// From the ten coefficients of A x² + B y² + C z² + D xy + E xz + F yz + G x + H y + I z + J.
    pub fn new([xx, yy, zz, xy, xz, yz, x, y, z, one]: [f64; 10]) -> Self {
        let [xy, xz, yz] = [xy, xz, yz].map(|c| 0.5 * c);
        Self {
            a: DMat3::from_cols(Vec3::new(xx, xy, xz), Vec3::new(xy, yy, yz), Vec3::new(xz, yz, zz)),
            b: 0.5 * Vec3::new(x, y, z),
            c: one,
        }
    }

    /// x² + y² − (p z² + 2 q z + r): the surface of revolution whose squared radius is p z² + 2 q z + r.
    pub fn revolution(p: f64, q: f64, r: f64) -> Self {
        Self { a: DMat3::from_diagonal(Vec3::new(1.0, 1.0, -p)), b: Vec3::new(0.0, 0.0, -q), c: -r }
    }

    pub fn value(&self, x: Vec3) -> f64 {
        x.dot(self.a * x + 2.0 * self.b) + self.c
    }

    pub fn gradient(&self, x: Vec3) -> Vec3 {
        2.0 * (self.a * x + self.b)
    }

    /// The sum of the magnitudes of all terms where no coordinate exceeds those of `x`: rounding errors of
    /// values are in proportion to it.
    pub fn size(&self, x: Vec3) -> f64 {
        let x = x.abs();
        let absolute = DMat3::from_cols(self.a.x_axis.abs(), self.a.y_axis.abs(), self.a.z_axis.abs());
        x.dot(absolute * x + 2.0 * self.b.abs()) + self.c.abs()
    }

    /// The same surface in coordinates y with x = origin + scale·y, its coefficients of the order of 1.
    pub fn rescaled(&self, origin: Vec3, scale: f64) -> Self {
        let form = Self {
            a: self.a * (scale * scale),
            b: (self.a * origin + self.b) * scale,
            c: self.value(origin),
        };
        let unit = 1.0 / form.size(Vec3::ONE);
        Self { a: form.a * unit, b: form.b * unit, c: form.c * unit }
    }

    /// [c₀, c₁, c₂] of the value at origin + t·direction, c₀ + c₁ t + c₂ t².
    pub fn along(&self, origin: Vec3, direction: Vec3) -> [f64; 3] {
        [self.value(origin), 2.0 * direction.dot(self.a * origin + self.b), direction.dot(self.a * direction)]
    }

    /// Where the gradient vanishes, if there is one such point.
    pub fn centre(&self) -> Option<Vec3> {
        let size = self.a.x_axis.length() * self.a.y_axis.length() * self.a.z_axis.length();
        let regular = self.a.determinant().abs() > 1e-9 * size && size > 0.0;
        let centre = -(self.a.inverse() * self.b);
        (regular && centre.is_finite()).then_some(centre)
    }
}
