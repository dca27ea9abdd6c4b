//! The affine map that places an analytic shape, and the rounding errors that come with it.

use super::crossing::{Crossing, Crossings};
use super::random_lines::OnLine;
use crate::geometry::{Pose, Ray, Transform, Vec3};
use crate::lanes::{Real, Vector};
use crate::shape::ShapeError;
use smallvec::SmallVec;

/// A pose and what follows from it.
#[derive(Clone, Debug)]
pub(super) struct Placement {
    pub pose: Pose,
    /// |det| of the linear part: local to world volume.
    pub volume: f64,
    /// The one scale factor, where the map is a similarity.
    pub scale: Option<f64>,
    pub mirrors: bool,
    /// Bound on the rounding errors of local coordinates near the shape, in units of 2⁻⁵³; see
    /// [`Placement::error`].
    local_error: Vec3,
}

impl Placement {
    /// Where the linear part is so ill-conditioned that local coordinates mean little, an error.
    pub fn new(to_world: &Transform) -> Result<Self, ShapeError> {
        let pose = Pose::new(to_world);
        let spread = pose.spread() * Vec3::ONE;
        if !(spread.max_element() < 1e12 && pose.inverse.is_finite() && pose.origin.is_finite()) {
            return Err(ShapeError::Placement);
        }
        let determinant = pose.linear.determinant();
        Ok(Self {
            pose,
            volume: determinant.abs(),
            scale: to_world.uniform_scale(),
            mirrors: determinant < 0.0,
            local_error: 16.0 * spread,
        })
    }

    /// Nearest distance with 0 ≤ t < `ray.t_max`, and the part that is met there. `crossed` gives, in
    /// ascending order, where the line through a local point, its direction of unit length, crosses the
    /// shape.
    pub fn nearest(
        &self,
        ray: &Ray,
        crossed: impl FnOnce(Vec3, Vec3) -> SmallVec<[OnLine; 4]>,
    ) -> Option<(f64, u32)> {
        let (origin, direction, speed) = self.local_line(ray);
        let found = crossed(origin, direction);
        let mut hits = found.iter().map(|crossing| (crossing.t / speed, crossing.part));
        hits.find(|&(t, _)| t >= 0.0 && t < ray.t_max)
    }

    /// Whether a ray ends before it comes to the shape, as far as `is_clear` sees that from a local origin
    /// and the way from there to the end of the ray.
    pub fn ends_before(&self, ray: &Ray, is_clear: impl FnOnce(Vec3, Vec3) -> bool) -> bool {
        let pose = &self.pose;
        ray.t_max.is_finite()
            && is_clear(pose.local_point(ray.origin), pose.local_vector(ray.direction) * ray.t_max)
    }

    /// Whether it ends before, as the distance of its local origin from the shape tells.
    pub fn ends_within(&self, ray: &Ray, distance: impl FnOnce(Vec3) -> f64) -> bool {
        self.ends_before(ray, |origin, way| {
            let free = distance(origin) - self.margin(origin);
            free > 0.0 && way.length_squared() < free * free
        })
    }

    /// Bound, with much to spare, on the rounding errors of local coordinates near `origin`.
    pub fn margin(&self, origin: Vec3) -> f64 {
        let reach = 1.0 + origin.abs().max_element();
        1e-9 * reach + self.coordinate_error(reach)
    }

    /// All crossings along the whole line, by the same as in [`Self::nearest`]. `inward`: whether normals are
    /// flipped.
    pub fn crossings(
        &self,
        ray: &Ray,
        inward: bool,
        crossed: impl FnOnce(Vec3, Vec3) -> SmallVec<[OnLine; 4]>,
    ) -> Crossings {
        let (origin, direction, speed) = self.local_line(ray);
        let in_world = |&OnLine { t, error, enters, part }: &OnLine| {
            let t = t / speed;
            Crossing::analytic(t, error / speed + 4.0 * f64::EPSILON * t.abs(), enters != inward, part)
        };
        crossed(origin, direction).iter().map(in_world).collect()
    }

    /// The ray's line in local coordinates, and how much longer lengths along it are there.
    fn local_line(&self, ray: &Ray) -> (Vec3, Vec3, f64) {
        let direction = self.pose.local_vector(ray.direction);
        let speed = direction.length();
        (self.pose.local_point(ray.origin), direction / speed, speed)
    }

    /// Error bound for [`crate::geometry::SurfacePoint::error`] of a point whose local coordinates don't
    /// exceed 1. `outward` is the local normal and `stretch` the length of its [`Pose::world_normal`].
    ///
    /// With u = 2⁻⁵³, L the linear part, and |·| the matrix of absolute values:
    /// - A local point x becomes a world point with error 3u|L||x| for the product and u(|origin| + |p|) for
    ///   the sum and for the offset itself.
    /// - The intersection test takes it back with error u|L⁻¹||L||x| for the subtraction of the origin and 3u
    ///   of the same for the product; the computed L⁻¹ isn't quite the inverse of L, which adds a few
    ///   u(|L⁻¹||L|)²|x|; and |x|² - 1 or its like takes a few u more. In all less than 8u(|L⁻¹||L|)²|x|,
    ///   doubled for reserve.
    /// - A local distance s along the normal is s / |L⁻ᵀ n| in world space.
    pub fn error(&self, position: Vec3, outward: Vec3, stretch: f64) -> f64 {
        self.errors::<f64>(Vector::of(position), Vector::of(outward), stretch)
    }

    /// The same of several points.
    #[inline(always)]
    pub fn errors<R: Real>(&self, position: Vector<R>, outward: Vector<R>, stretch: R) -> R {
        let reach = position.abs().greatest() + R::of(self.pose.origin.abs().max_element());
        let local_error = Vector::of(self.local_error).dot(outward.abs());
        R::of(0.5 * f64::EPSILON) * (local_error / stretch + R::of(4.0) * reach)
    }

    /// Bound on the error of the local coordinates, along any axis, of points on a ray that starts up to
    /// `reach` away.
    pub fn coordinate_error(&self, reach: f64) -> f64 {
        0.5 * f64::EPSILON * self.local_error.max_element() * reach
    }

    /// World area per unit of local area across the unit vector `normal`: |det L| |L⁻ᵀ n|.
    pub fn area_stretch(&self, normal: Vec3) -> f64 {
        self.volume * self.pose.world_normal(normal).length()
    }

    /// Half extents of the world box of the unit ball restricted to the columns `0..columns` of the map.
    pub fn half_extents(&self, columns: usize) -> Vec3 {
        let squares = (0..columns).map(|i| self.pose.linear.col(i) * self.pose.linear.col(i));
        squares.sum::<Vec3>().map(f64::sqrt)
    }
}
