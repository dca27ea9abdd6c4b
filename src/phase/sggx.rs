//! Small flakes that mirror, with the distribution of normals of an ellipsoid (Heitz, Dupuy, Crassin,
//! Dachsbacher, "The SGGX microflake distribution", ACM TOG 34(4), 2015).
//!
//! The value depends on both directions and not on the angle between them alone, and the extinction on the
//! direction of the ray: it is the medium's times the flakes' projected area.

use crate::geometry::{Frame, Vec3};
use glam::DMat3;
use std::f64::consts::{PI, TAU};

/// The symmetric positive definite matrix S of the ellipsoid, in the coordinates of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Sggx {
    matrix: DMat3,
    inverse: DMat3,
    /// √|S|.
    root: f64,
}

impl Sggx {
    /// From S_xx, S_yy, S_zz, S_xy, S_xz and S_yz. `None` unless the matrix is positive definite.
    pub fn new([xx, yy, zz, xy, xz, yz]: [f64; 6]) -> Option<Self> {
        let matrix = DMat3::from_cols(Vec3::new(xx, xy, xz), Vec3::new(xy, yy, yz), Vec3::new(xz, yz, zz));
        let determinant = matrix.determinant();
        // Sylvester's criterion.
        let positive = xx > 0.0 && xx * yy - xy * xy > 0.0 && determinant > 0.0;
        let inverse = matrix.inverse();
        (positive && matrix.is_finite() && inverse.is_finite()).then(|| Self {
            matrix,
            inverse,
            root: determinant.sqrt(),
        })
    }

    /// The flakes' area seen along a direction, over that of all of them.
    pub fn projected_area(&self, direction: Vec3) -> f64 {
        direction.dot(self.matrix * direction).sqrt()
    }

    /// The projected area along any direction is at most this: no eigenvalue of S is above its trace.
    pub fn max_projected_area(&self) -> f64 {
        (self.matrix.x_axis.x + self.matrix.y_axis.y + self.matrix.z_axis.z).sqrt()
    }

    /// The density of normals.
    fn normals(&self, normal: Vec3) -> f64 {
        let form = normal.dot(self.inverse * normal);
        1.0 / (PI * self.root * form * form)
    }

    /// Value and density of scattering from one way of travel into another, sr⁻¹.
    pub fn evaluate(&self, comes: Vec3, goes: Vec3) -> f64 {
        let half = goes - comes;
        let length = half.length();
        // Straight ahead lights only what mirrors at grazing angles, of which none is more likely.
        let half = if length > 0.0 { half / length } else { Frame::around(comes).to_world(Vec3::X) };
        0.25 * self.normals(half) / self.projected_area(comes)
    }

    /// The way on from a mirror whose normal is chosen among those that are seen (section 4 of the paper).
    pub fn sample(&self, comes: Vec3, [u, v]: [f64; 2]) -> Vec3 {
        let eye = -comes;
        let frame = Frame::around(eye);
        let axes = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| frame.to_world(axis));
        let s = |a: usize, b: usize| axes[a].dot(self.matrix * axes[b]);
        let (k, j, i) = (0, 1, 2);
        let over_root = 1.0 / s(i, i).sqrt();
        let minor = (s(j, j) * s(i, i) - s(j, i) * s(j, i)).max(f64::MIN_POSITIVE).sqrt();
        let along_k = Vec3::new(self.root / minor, 0.0, 0.0);
        let skew = s(k, i) * s(j, i) - s(k, j) * s(i, i);
        let along_j = Vec3::new(-over_root * skew / minor, over_root * minor, 0.0);
        let along_i = Vec3::new(s(k, i), s(j, i), s(i, i)) * over_root;
        let (radius, angle) = (u.sqrt(), TAU * v);
        let disk = [radius * angle.cos(), radius * angle.sin()];
        let normal = along_k * disk[0] + along_j * disk[1] + along_i * (1.0 - u).max(0.0).sqrt();
        let normal = frame.to_world(normal.normalize());
        (comes + normal * (2.0 * eye.dot(normal))).normalize()
    }
}
