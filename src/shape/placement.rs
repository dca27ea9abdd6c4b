//! The affine map that places an analytic shape, and the rounding errors that come with it.

use crate::geometry::{Transform, Vec3};
use crate::shape::ShapeError;
use glam::DMat3;

/// Local coordinates are relative to `origin`, which is subtracted first: a small shape far from the
/// world's origin loses nothing but the digits of the positions themselves.
#[derive(Clone, Debug)]
pub(crate) struct Placement {
    pub origin: Vec3,
    pub linear: DMat3,
    pub inverse: DMat3,
    /// |det| of the linear part: local to world volume.
    pub volume: f64,
    /// The one scale factor, where the map is a similarity.
    pub scale: Option<f64>,
    pub mirrors: bool,
    /// Bound on the rounding errors of local coordinates near the shape, in units of 2⁻⁵³; see
    /// [`Placement::error`].
    local_error: Vec3,
}

/// (|L⁻¹||L|)²: how rounding errors of local coordinates spread on the way to the world and back.
fn spread(linear: DMat3, inverse: DMat3) -> DMat3 {
    let absolute = |m: DMat3| DMat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs());
    let round_trip = absolute(inverse) * absolute(linear);
    round_trip * round_trip
}

impl Placement {
    /// Where the linear part is so ill-conditioned that local coordinates mean little, an error.
    pub fn new(to_world: &Transform) -> Result<Self, ShapeError> {
        let matrix = to_world.matrix();
        let linear = DMat3::from_mat4(matrix);
        let inverse = linear.inverse();
        let spread = spread(linear, inverse) * Vec3::ONE;
        let origin = matrix.w_axis.truncate();
        if !(spread.max_element() < 1e12 && inverse.is_finite() && origin.is_finite()) {
            return Err(ShapeError::Placement);
        }
        Ok(Self {
            origin,
            linear,
            inverse,
            volume: linear.determinant().abs(),
            scale: to_world.uniform_scale(),
            mirrors: linear.determinant() < 0.0,
            local_error: 16.0 * spread,
        })
    }

    pub fn local_point(&self, world: Vec3) -> Vec3 {
        self.inverse * (world - self.origin)
    }

    pub fn local_vector(&self, world: Vec3) -> Vec3 {
        self.inverse * world
    }

    pub fn world_point(&self, local: Vec3) -> Vec3 {
        self.origin + self.linear * local
    }

    pub fn world_vector(&self, local: Vec3) -> Vec3 {
        self.linear * local
    }

    /// The world normal's direction, whose length is the distance between the images of two local planes
    /// at unit distance, inverted: |L⁻ᵀ n|.
    pub fn world_normal(&self, local: Vec3) -> Vec3 {
        self.inverse.transpose() * local
    }

    /// Error bound for [`crate::geometry::SurfacePoint::error`] of a point whose local coordinates don't
    /// exceed 1. `outward` is the local normal and `stretch` the length of its [`Placement::world_normal`].
    ///
    /// With u = 2⁻⁵³, L the linear part, and |·| the matrix of absolute values:
    /// - A local point x becomes a world point with error 3u|L||x| for the product and u(|origin| + |p|) for
    ///   the sum and for the offset itself.
    /// - The intersection test takes it back with error u|L⁻¹||L||x| for the subtraction of the origin and 3u of
    ///   the same for the product; the computed L⁻¹ isn't quite the inverse of L, which adds a few
    ///   u(|L⁻¹||L|)²|x|; and |x|² - 1 or its like takes a few u more. In all less than 8u(|L⁻¹||L|)²|x|,
    ///   doubled for reserve.
    /// - A local distance s along the normal is s / |L⁻ᵀ n| in world space.
    pub fn error(&self, position: Vec3, outward: Vec3, stretch: f64) -> f64 {
        let reach = position.abs().max_element() + self.origin.abs().max_element();
        0.5 * f64::EPSILON * (self.local_error.dot(outward.abs()) / stretch + 4.0 * reach)
    }

    /// Twice what [`Placement::error`] counts in local coordinates up to 1, for coordinates of any size: times them
    /// it bounds the errors of local coordinates in units of 2⁻⁵³.
    pub fn local_errors(&self) -> DMat3 {
        spread(self.linear, self.inverse) * 16.0
    }

    /// Half extents of the world box of the unit ball restricted to the columns `0..columns` of the map.
    pub fn half_extents(&self, columns: usize) -> Vec3 {
        let squares = (0..columns).map(|i| self.linear.col(i) * self.linear.col(i));
        squares.sum::<Vec3>().map(f64::sqrt)
    }
}
