//! A group of shapes somewhere else, as often as one likes: the group has a tree of its own, in its own coordinates,
//! and a ray is taken there.

use super::Accel;
use crate::geometry::{Bounds, Ray, SurfacePoint, Transform, Vec3};
use crate::shape::{Hit, Parametrisation, Placement, Shape, ShapeError, SurfaceHit};
use glam::DMat3;
use std::sync::Arc;

/// A group where its transform puts it.
#[derive(Clone, Debug)]
pub struct Instance {
    group: Arc<Accel>,
    placement: Placement,
    /// See [`Placement::local_errors`].
    local_errors: DMat3,
    /// Length of the diagonal of the group's box.
    reach: f64,
}

impl Instance {
    /// # Errors
    /// Where the transform is too ill-conditioned to take rays through.
    pub fn new(group: Arc<Accel>, to_world: &Transform) -> Result<Self, ShapeError> {
        let placement = Placement::new(to_world)?;
        let reach = group.bounds().diameter();
        Ok(Self { local_errors: placement.local_errors(), reach, group, placement })
    }

    /// A box around it in world space; empty where the group has no surface.
    pub fn bounds(&self) -> Bounds {
        Bounds::of(self.group.bounds().corners().map(|corner| self.placement.world_point(corner)))
    }

    /// The ray in the group's coordinates, and how much longer distances are there.
    fn local(&self, ray: &Ray) -> (Ray, f64) {
        let direction = self.placement.local_vector(ray.direction);
        let scale = direction.length();
        let origin = self.placement.local_point(ray.origin);
        // A little further, so that rounding hides no hit: the caller compares world distances.
        let t_max = ray.t_max * scale * (1.0 + 4.0 * f64::EPSILON);
        (Ray { origin, direction: direction / scale, t_max }, scale)
    }

    /// The nearest hit with 0 ≤ t < about `ray.t_max`, without the instance's own index.
    ///
    /// Never inlined, like the next: the loop that calls it is for scenes without instances too.
    #[inline(never)]
    pub(super) fn closest(&self, ray: &Ray) -> Option<Hit> {
        let (local, scale) = self.local(ray);
        let hit = self.group.closest(&local)?;
        Some(Hit { t: hit.t / scale, ..hit })
    }

    #[inline(never)]
    pub(super) fn occluded(&self, ray: &Ray) -> bool {
        self.group.occluded(&self.local(ray).0)
    }

    /// The surface of `shape`, one of the group's, where `ray` hit it.
    ///
    /// The error bound is that of the group's surface, which covers its own intersection test, with what the way to the world
    /// and back adds: to the local coordinates of the origin, which don't exceed those of the point noticeably, and to the
    /// direction, which a ray within the group follows for no longer than the diagonal of the group's box.
    #[inline(never)]
    pub(super) fn surface(&self, shape: &Shape, hit: &Hit, ray: &Ray) -> SurfaceHit {
        let (local_ray, scale) = self.local(ray);
        let SurfaceHit { point, shading_normal } =
            shape.surface(&Hit { t: hit.t * scale, ..*hit }, &local_ray);
        let position = self.placement.world_point(point.position);
        let image = self.placement.world_normal(point.normal);
        let stretch = image.length();
        let reach = self.local_errors * (point.position.abs() + Vec3::splat(self.reach));
        let size = position.abs().max_element() + self.placement.origin.abs().max_element();
        let rounding = 0.5 * f64::EPSILON * (reach.dot(point.normal.abs()) / stretch + 4.0 * size);
        let error = point.error / stretch + rounding;
        let normal = image / stretch;
        let shading_normal = self.placement.world_normal(shading_normal).try_normalize().unwrap_or(normal);
        SurfaceHit { point: SurfacePoint { position, normal, error }, shading_normal }
    }

    /// The coordinates of a point of `shape`, one of the group's.
    #[inline(never)]
    pub(super) fn parametrisation(&self, shape: &Shape, hit: &Hit, position: Vec3) -> Parametrisation {
        let local = shape.parametrisation(hit, self.placement.local_point(position));
        Parametrisation {
            uv: local.uv,
            tangent: self.placement.world_vector(local.tangent),
            bitangent: self.placement.world_vector(local.bitangent),
        }
    }
}
