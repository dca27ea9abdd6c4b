use super::Vec3;
use crate::lanes::{Real, Vector};
use glam::{DMat3, DMat4};

/// An invertible affine map together with its inverse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    matrix: DMat4,
    inverse: DMat4,
}

impl Transform {
    /// The transform that changes nothing.
    pub const IDENTITY: Self = Self { matrix: DMat4::IDENTITY, inverse: DMat4::IDENTITY };

    /// `None` where the matrix is singular, not affine or not finite.
    pub fn new(matrix: DMat4) -> Option<Self> {
        let affine = matrix.row(3) == glam::DVec4::W;
        let linear = DMat3::from_mat4(matrix);
        // Relative to the lengths of its columns, so that a uniform scale of 1e-6 is not singular.
        let volume = linear.x_axis.length() * linear.y_axis.length() * linear.z_axis.length();
        let regular = linear.determinant().abs() > 1e-12 * volume && volume > 0.0;
        let inverse = matrix.inverse();
        (affine && regular && matrix.is_finite() && inverse.is_finite()).then_some(Self { matrix, inverse })
    }

    /// Moves by an offset.
    pub fn translation(offset: Vec3) -> Self {
        Self { matrix: DMat4::from_translation(offset), inverse: DMat4::from_translation(-offset) }
    }

    /// Scales by a factor around the origin.
    pub fn scale(factor: f64) -> Self {
        Self {
            matrix: DMat4::from_scale(Vec3::splat(factor)),
            inverse: DMat4::from_scale(Vec3::splat(1.0 / factor)),
        }
    }

    /// `self` applied first, then `next`.
    pub fn then(&self, next: &Self) -> Self {
        Self { matrix: next.matrix * self.matrix, inverse: self.inverse * next.inverse }
    }

    /// The transform that undoes it.
    pub fn inverse(&self) -> Self {
        Self { matrix: self.inverse, inverse: self.matrix }
    }

    /// Its matrix, for column vectors.
    pub fn matrix(&self) -> DMat4 {
        self.matrix
    }

    /// Takes a point to its place.
    pub fn point(&self, point: Vec3) -> Vec3 {
        self.matrix.transform_point3(point)
    }

    /// A displacement; its length changes with the map.
    pub fn vector(&self, vector: Vec3) -> Vec3 {
        self.matrix.transform_vector3(vector)
    }

    /// The same of one or of several.
    #[inline(always)]
    pub fn vectors<R: Real>(&self, vectors: Vector<R>) -> Vector<R> {
        let [x, y, z] = [self.matrix.x_axis, self.matrix.y_axis, self.matrix.z_axis]
            .map(|axis| Vector::of(axis.truncate()));
        x * vectors.x + y * vectors.y + z * vectors.z
    }

    /// A normal, by the inverse transpose. Not normalised.
    pub fn normal(&self, normal: Vec3) -> Vec3 {
        DMat3::from_mat4(self.inverse).transpose() * normal
    }

    /// Whether it changes the handedness.
    pub fn mirrors(&self) -> bool {
        DMat3::from_mat4(self.matrix).determinant() < 0.0
    }

    /// Whether it only rotates, mirrors and moves: whether the products of its axes are those of an
    /// orthonormal frame, each within a tolerance.
    pub fn is_rigid(&self, tolerance: f64) -> bool {
        let axes = DMat3::from_mat4(self.matrix);
        (axes.transpose() * axes).abs_diff_eq(DMat3::IDENTITY, tolerance)
    }

    /// The one scale factor of a map that keeps shapes similar; `None` for any other map.
    pub fn uniform_scale(&self) -> Option<f64> {
        let m = DMat3::from_mat4(self.matrix);
        let scale = m.x_axis.length();
        let gram = m.transpose() * m;
        let expected = DMat3::from_diagonal(Vec3::splat(scale * scale));
        gram.abs_diff_eq(expected, 1e-9 * scale * scale).then_some(scale)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_stay_perpendicular_and_inverses_undo() {
        let shear = DMat4::from_cols_array(&[
            1.0, 0.2, 0.0, 0.0, -0.5, 2.0, 0.1, 0.0, 0.0, 0.3, 0.7, 0.0, 4.0, -1.0, 9.0, 1.0,
        ]);
        let map = Transform::new(shear).unwrap();
        let (a, b) = (Vec3::new(1.0, 2.0, 3.0), Vec3::new(-2.0, 1.0, 0.5));
        assert!(map.normal(a.cross(b)).dot(map.vector(a)).abs() < 1e-14);
        assert!(map.normal(a.cross(b)).dot(map.vector(b)).abs() < 1e-14);
        assert!((map.then(&map.inverse()).point(a) - a).length() < 1e-13);
        assert!(!map.mirrors() && map.uniform_scale().is_none());
    }

    #[test]
    fn similarities_and_mirrors_are_known() {
        let turn = Transform::new(DMat4::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), 2.0)).unwrap();
        let small = turn.then(&Transform::scale(1e-6)).then(&Transform::translation(Vec3::ONE));
        assert!((small.uniform_scale().unwrap() / 1e-6 - 1.0).abs() < 1e-12);
        let mirror = Transform::new(DMat4::from_scale(Vec3::new(-1e-6, 1e-6, 1e-6))).unwrap();
        assert!(mirror.mirrors() && mirror.uniform_scale().is_some());
    }

    #[test]
    fn singular_maps_are_refused() {
        assert_eq!(Transform::new(DMat4::from_scale(Vec3::new(1.0, 0.0, 1.0))), None);
        assert_eq!(Transform::new(DMat4::NAN), None);
        let mut projective = DMat4::IDENTITY;
        projective.z_axis.w = 0.1;
        assert_eq!(Transform::new(projective), None);
    }
}
