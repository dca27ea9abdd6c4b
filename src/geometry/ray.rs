use super::{Points, Vec3};

/// A half line. A hit counts at 0 ≤ t < `t_max`: rays start from origins that are already off
/// their surface (see [`SurfacePoint::leave`]), so there is no minimum distance.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Where it begins, in scene units.
    pub origin: Vec3,
    /// Unit length, so that t is a distance.
    pub direction: Vec3,
    /// Distance at which it ends, in units of the direction's length; may be infinite.
    pub t_max: f64,
}

impl Ray {
    /// A ray without length: what is left where there is none.
    pub const NOWHERE: Self = Self { origin: Vec3::ZERO, direction: Vec3::Z, t_max: 0.0 };

    /// A ray without end.
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, t_max: f64::INFINITY }
    }

    /// The point at a distance from the origin.
    pub fn at(&self, t: f64) -> Vec3 {
        self.origin + self.direction * t
    }
}

/// A computed point on a surface and how far it may lie from the true surface.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// Where it is, in scene units.
    pub position: Vec3,
    /// Unit geometric normal; its side is that of the surface's orientation, not of any ray.
    pub normal: Vec3,
    /// Bound on the distance between `position` and the surface along the normal, together with
    /// the error that the same surface's intersection test makes for a ray starting here.
    pub error: f64,
}

impl SurfacePoint {
    /// The origin of a ray that leaves along `direction`: moved off the surface to the side that
    /// it leaves to, by just as much as the error bounds ask for, so that it neither meets the
    /// surface it leaves nor misses a neighbour in contact.
    pub fn leave(&self, direction: Vec3) -> Vec3 {
        self.position + self.normal * self.error.copysign(direction.dot(self.normal))
    }

    /// The ray that leaves the point in a direction, from beyond its error.
    pub fn ray(&self, direction: Vec3) -> Ray {
        Ray::new(self.leave(direction), direction)
    }

    /// What is left of a ray that passes through this surface, to the very same end.
    pub fn rest_of(&self, ray: &Ray) -> Ray {
        let origin = self.leave(ray.direction);
        if ray.t_max.is_infinite() {
            return Ray { origin, ..*ray };
        }
        let rest = ray.at(ray.t_max) - origin;
        let length = rest.length();
        // A surface so near to the end leaves nothing that could be met.
        if rest.dot(ray.direction) <= 0.0 {
            return Ray { origin, direction: ray.direction, t_max: 0.0 };
        }
        Ray { origin, direction: rest / length, t_max: length }
    }

    /// The segment from this surface to `target`, ending just before the surface there.
    /// Directions and lengths are those of the segment between the two offset points, so nothing
    /// behind either surface is crossed. `None` when the two coincide.
    pub fn segment_to(&self, target: &SurfacePoint) -> Option<Ray> {
        Points::<f64>::of(self).segments_to(&Points::of(target)).ray()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(x: f64, normal: Vec3) -> SurfacePoint {
        SurfacePoint { position: Vec3::X * x, normal, error: 1e-3 }
    }

    #[test]
    fn rays_leave_on_their_own_side() {
        let point = point(0.0, Vec3::Z);
        assert_eq!(point.leave(Vec3::new(0.6, 0.0, 0.8)), Vec3::Z * 1e-3);
        assert_eq!(point.leave(Vec3::new(0.6, 0.0, -0.8)), Vec3::Z * -1e-3);
    }

    #[test]
    fn segments_end_before_both_surfaces() {
        let (from, to) = (point(0.0, Vec3::X), point(2.0, Vec3::X));
        let segment = from.segment_to(&to).unwrap();
        assert_eq!(segment.origin.x, 1e-3);
        assert!((segment.at(segment.t_max).x - (2.0 - 1e-3)).abs() < 1e-14);
        assert!(from.segment_to(&SurfacePoint { error: 0.0, ..from }).is_some());
        assert!(
            SurfacePoint { error: 0.0, ..from }.segment_to(&SurfacePoint { error: 0.0, ..from }).is_none()
        );
    }
}
