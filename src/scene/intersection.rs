//! Where a ray meets a surface.

use crate::geometry::{SurfacePoint, Vec3};
use crate::light::LightHit;
use crate::shape::Hit;

/// Where a ray meets a surface.
#[derive(Clone, Copy, Debug)]
pub struct Intersection {
    /// Distance along the ray, in scene units.
    pub t: f64,
    /// The point of the surface.
    pub point: SurfacePoint,
    /// Shading normal of the front.
    pub shading_normal: Vec3,
    /// The light that the surface is, if it is one.
    pub light: Option<u32>,
    pub(super) hit: Hit,
    pub(super) time: f64,
    /// Whether the ray comes from the side that the normal points to.
    pub(super) from_front: bool,
    /// Whether several bodies end or begin here.
    pub(super) coincident: bool,
}

impl Intersection {
    /// The hit as one of a light, if the surface is one.
    pub fn on_light(&self) -> Option<LightHit> {
        let Hit { triangle, barycentric, .. } = self.hit;
        Some(LightHit { light: self.light?, point: self.point, triangle, barycentric })
    }
}
