use super::{SurfacePoint, Transform, Vec3};
use glam::DMat3;

/// Where a body stands at one moment: the affine map from its coordinates to the world's, with its inverse.
///
/// Local coordinates are relative to `origin`, which is subtracted first: a small body far from the world's
/// origin loses nothing but the digits of the positions themselves.
#[derive(Clone, Copy, Debug)]
pub struct Pose {
    /// Where the origin of the moving coordinates is.
    pub origin: Vec3,
    /// Linear part, from the moving coordinates to those around them.
    pub linear: DMat3,
    /// Inverse of the linear part.
    pub inverse: DMat3,
}

impl Pose {
    /// The pose of what a transform places.
    pub fn new(to_world: &Transform) -> Self {
        let matrix = to_world.matrix();
        let linear = DMat3::from_mat4(matrix);
        Self { origin: matrix.w_axis.truncate(), linear, inverse: linear.inverse() }
    }

    /// A point of the world in local coordinates.
    pub fn local_point(&self, world: Vec3) -> Vec3 {
        self.inverse * (world - self.origin)
    }

    /// A vector of the world in local coordinates.
    pub fn local_vector(&self, world: Vec3) -> Vec3 {
        self.inverse * world
    }

    /// A local point in the world.
    pub fn world_point(&self, local: Vec3) -> Vec3 {
        self.origin + self.linear * local
    }

    /// A local vector in the world.
    pub fn world_vector(&self, local: Vec3) -> Vec3 {
        self.linear * local
    }

    /// The world normal's direction, whose length is the distance between the images of two local planes
    /// at unit distance, inverted: |L⁻ᵀ n|.
    pub fn world_normal(&self, local: Vec3) -> Vec3 {
        self.inverse.transpose() * local
    }

    /// The local direction of a world normal, of any length.
    pub fn local_normal(&self, world: Vec3) -> Vec3 {
        self.linear.transpose() * world
    }

    /// Local over world solid angle around a world direction of unit length: |det L⁻¹| / |L⁻¹ d|³, by which a
    /// density per local steradian becomes one per steradian of the world.
    pub fn solid_angle_ratio(&self, direction: Vec3) -> f64 {
        let stretch = self.local_vector(direction).length();
        self.inverse.determinant().abs() / (stretch * stretch * stretch)
    }

    /// World over local area of a surface with a local normal of unit length: |det L| · |L⁻ᵀ n|.
    pub fn area_ratio(&self, normal: Vec3) -> f64 {
        self.linear.determinant().abs() * self.world_normal(normal).length()
    }

    /// About the mean of that over all normals.
    pub fn mean_area_ratio(&self) -> f64 {
        self.linear.determinant().abs().cbrt().powi(2)
    }

    /// (|L⁻¹||L|)²: how rounding errors of local coordinates spread on the way to the world and back.
    pub fn spread(&self) -> DMat3 {
        let absolute = |m: DMat3| DMat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs());
        let round_trip = absolute(self.inverse) * absolute(self.linear);
        round_trip * round_trip
    }

    /// A surface point of the body in the world.
    ///
    /// `local_errors` times local coordinates bounds their rounding errors in units of 2⁻⁵³. The error bound
    /// is that of the local point, which covers its own intersection test, with what the way to the world and
    /// back adds: to the local coordinates of a ray's origin, which don't exceed those of the point
    /// noticeably, and to its direction, which a ray follows within the body for no longer than `reach`.
    pub fn surface_point(&self, local: &SurfacePoint, local_errors: &DMat3, reach: f64) -> SurfacePoint {
        let position = self.world_point(local.position);
        let image = self.world_normal(local.normal);
        let stretch = image.length();
        let errors = *local_errors * (local.position.abs() + Vec3::splat(reach));
        let size = position.abs().max_element() + self.origin.abs().max_element();
        let rounding = 0.5 * f64::EPSILON * (errors.dot(local.normal.abs()) / stretch + 4.0 * size);
        SurfacePoint { position, normal: image / stretch, error: local.error / stretch + rounding }
    }
}
