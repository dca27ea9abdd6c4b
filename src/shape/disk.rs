//! Flat disks, and flat ellipses.

use super::crossing::{Crossing, Crossings};
use super::placement::Placement;
use super::{AreaSample, Parametrisation, ShapeError, SurfaceHit};
use crate::geometry::{Bounds, Ray, SurfacePoint, Transform, Vec3, angle};
use crate::sampling::warp;
use std::f64::consts::{PI, TAU};

/// The image of the disk of radius 1 in z = 0.
#[derive(Clone, Debug)]
pub struct Disk {
    placement: Placement,
    normal: Vec3,
    /// Length of the image of the local normal.
    stretch: f64,
    area: f64,
}

impl Disk {
    /// The normal is the image of +z, or of -z where `flip_normals`.
    pub fn new(to_world: &Transform, flip_normals: bool) -> Result<Self, ShapeError> {
        let placement = Placement::new(to_world)?;
        let image = placement.pose.world_normal(Vec3::Z);
        let normal = image / if flip_normals { -image.length() } else { image.length() };
        let area = PI * placement.pose.linear.x_axis.cross(placement.pose.linear.y_axis).length();
        Ok(Self { stretch: image.length(), placement, normal, area })
    }

    /// Distance with 0 ≤ t < `ray.t_max`. A ray within the plane misses.
    pub fn intersect(&self, ray: &Ray) -> Option<f64> {
        let origin = self.placement.pose.local_point(ray.origin);
        let direction = self.placement.pose.local_vector(ray.direction);
        if direction.z == 0.0 {
            return None;
        }
        let t = -origin.z / direction.z;
        let (x, y) = (origin.x + t * direction.x, origin.y + t * direction.y);
        (t >= 0.0 && t < ray.t_max && x * x + y * y <= 1.0).then_some(t)
    }

    /// The crossing with the whole line, if there is one.
    pub fn crossings(&self, ray: &Ray) -> Crossings {
        let origin = self.placement.pose.local_point(ray.origin);
        let direction = self.placement.pose.local_vector(ray.direction);
        let t = -origin.z / direction.z;
        let (x, y) = (origin.x + t * direction.x, origin.y + t * direction.y);
        let mut found = Crossings::new();
        if direction.z != 0.0 && x * x + y * y <= 1.0 {
            let coordinate = self.placement.coordinate_error(1.0 + origin.abs().max_element());
            let error = coordinate / direction.z.abs() + 4.0 * f64::EPSILON * t.abs();
            found.push(Crossing::analytic(t, error, ray.direction.dot(self.normal) < 0.0, 0));
        }
        found
    }

    /// The point of the disk's plane under `position`, along the local z axis.
    pub fn surface(&self, position: Vec3) -> SurfaceHit {
        let local = self.placement.pose.local_point(position);
        self.surface_at(local.x, local.y)
    }

    fn surface_at(&self, x: f64, y: f64) -> SurfaceHit {
        let position = self.placement.pose.world_point(Vec3::new(x, y, 0.0));
        let error = self.placement.error(position, Vec3::Z, self.stretch);
        SurfaceHit {
            point: SurfacePoint { position, normal: self.normal, error },
            shading_normal: self.normal,
        }
    }

    /// u along the radius, v around the centre.
    pub fn parametrisation(&self, position: Vec3) -> Parametrisation {
        let Vec3 { x, y, .. } = self.placement.pose.local_point(position);
        let r = x.hypot(y);
        let azimuth = angle::atan2(y, x);
        let azimuth = if azimuth < 0.0 { azimuth + TAU } else { azimuth };
        let outward = if r > 0.0 { Vec3::new(x / r, y / r, 0.0) } else { Vec3::X };
        Parametrisation {
            uv: [r, azimuth / TAU],
            tangent: self.placement.pose.world_vector(outward),
            bitangent: self.placement.pose.world_vector(TAU * Vec3::new(-y, x, 0.0)),
        }
    }

    /// A box around it.
    pub fn bounds(&self) -> Bounds {
        let half = self.placement.half_extents(2);
        Bounds { min: self.placement.pose.origin - half, max: self.placement.pose.origin + half }
    }

    /// Area of its surface.
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Uniform in world area: an affine map scales all areas of a plane alike.
    pub fn sample(&self, u: [f64; 2]) -> AreaSample {
        let [x, y] = warp::disk(u);
        AreaSample::analytic(self.surface_at(x, y), self.area_density())
    }

    /// The same with the first coordinate the square of the radius, the second around the centre.
    pub fn polar(&self, [squared, around]: [f64; 2]) -> AreaSample {
        let (sin, cos) = angle::sin_cos(TAU * around);
        let radius = squared.sqrt();
        AreaSample::analytic(self.surface_at(radius * cos, radius * sin), self.area_density())
    }

    /// Density per area of samples: one over the area.
    pub fn area_density(&self) -> f64 {
        1.0 / self.area
    }
}
