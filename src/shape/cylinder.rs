//! Cylinders without caps, elliptic or sheared where the placement is not a similarity.

use super::crossing::{Crossing, Crossings};
use super::placement::Placement;
use super::sphere::{ball_error, unit_ball_line, unit_ball_roots};
use super::{AreaSample, Parametrisation, ShapeError, SurfaceHit};
use crate::geometry::{Bounds, Frame, Ray, SurfacePoint, Transform, Vec3, angle};
use crate::lanes::Vector;
use glam::{DMat4, DVec4};
use std::f64::consts::TAU;

/// The image of x² + y² = 1, 0 ≤ z ≤ 1.
#[derive(Clone, Debug)]
pub struct Cylinder {
    placement: Placement,
    inward: bool,
    area: f64,
}

impl Cylinder {
    /// `to_world` applied to the cylinder around the axis from `p0` to `p1`.
    /// Normals point outward unless `flip_normals`, also where `to_world` mirrors, as in Mitsuba 3.
    pub fn new(
        to_world: &Transform,
        p0: Vec3,
        p1: Vec3,
        radius: f64,
        flip_normals: bool,
    ) -> Result<Self, ShapeError> {
        if !(radius > 0.0 && radius.is_finite()) {
            return Err(ShapeError::Radius(radius));
        }
        let length = (p1 - p0).length();
        if !(length > 0.0 && length.is_finite() && p0.is_finite()) {
            return Err(ShapeError::Ends);
        }
        let frame = Frame::around((p1 - p0) / length);
        let column = |axis: Vec3, scale: f64| (axis * scale).extend(0.0);
        let place = DMat4::from_cols(
            column(frame.x, radius),
            column(frame.y, radius),
            column(frame.z, length),
            DVec4::new(p0.x, p0.y, p0.z, 1.0),
        );
        let place = Transform::new(to_world.matrix() * place).ok_or(ShapeError::Placement)?;
        let placement = Placement::new(&place)?;
        const SECTORS: usize = 256;
        let stretch: f64 = (0..SECTORS)
            .map(|i| {
                let (sin, cos) = (TAU * i as f64 / SECTORS as f64).sin_cos();
                placement.area_stretch(Vec3::new(cos, sin, 0.0))
            })
            .sum();
        Ok(Self { placement, inward: flip_normals, area: TAU * stretch / SECTORS as f64 })
    }

    /// Nearest distance with 0 ≤ t < `ray.t_max`. A ray parallel to the axis misses.
    pub fn intersect(&self, ray: &Ray) -> Option<f64> {
        let origin = self.placement.pose.local_point(ray.origin);
        let direction = self.placement.pose.local_vector(ray.direction);
        let across = direction.with_z(0.0);
        let speed = across.length();
        if speed == 0.0 {
            return None;
        }
        let (start, along) = (Vector::of(origin.with_z(0.0)), Vector::of(across / speed));
        let ([near, far], met) = unit_ball_roots::<f64>(start, along);
        if !met {
            return None;
        }
        [near / speed, far / speed].into_iter().find(|&t| {
            let z = origin.z + t * direction.z;
            t >= 0.0 && t < ray.t_max && (0.0..=1.0).contains(&z)
        })
    }

    /// All crossings along the whole line.
    pub fn crossings(&self, ray: &Ray) -> Crossings {
        let origin = self.placement.pose.local_point(ray.origin);
        let direction = self.placement.pose.local_vector(ray.direction);
        let across = direction.with_z(0.0);
        let speed = across.length();
        let mut found = Crossings::new();
        if speed == 0.0 {
            return found;
        }
        let Some((near, far)) = unit_ball_line(origin.with_z(0.0), across / speed) else { return found };
        // Along a ray at a slant an error of its direction counts for as much longer.
        let error = ball_error(&self.placement, origin, [near, far], speed / direction.length().max(speed));
        for (t, enters) in [(near, true), (far, false)] {
            let t = t / speed;
            if (0.0..=1.0).contains(&(origin.z + t * direction.z)) {
                let error = error / speed + 4.0 * f64::EPSILON * t.abs();
                found.push(Crossing::analytic(t, error, enters != self.inward, 0));
            }
        }
        found
    }

    /// The point of the surface nearest to `position` in local space, at the same local z.
    pub fn surface(&self, position: Vec3) -> SurfaceHit {
        let local = self.placement.pose.local_point(position);
        self.surface_at(local.with_z(0.0).try_normalize().unwrap_or(Vec3::X), local.z.clamp(0.0, 1.0))
    }

    fn surface_at(&self, outward: Vec3, z: f64) -> SurfaceHit {
        let position = self.placement.pose.world_point(outward.with_z(z));
        let world_outward = self.placement.pose.world_normal(outward);
        let stretch = world_outward.length();
        let normal = world_outward / if self.inward { -stretch } else { stretch };
        SurfaceHit {
            point: SurfacePoint { position, normal, error: self.placement.error(position, outward, stretch) },
            shading_normal: normal,
        }
    }

    /// u around the axis, v along it.
    pub fn parametrisation(&self, position: Vec3) -> Parametrisation {
        let local = self.placement.pose.local_point(position);
        let azimuth = angle::atan2(local.y, local.x);
        let azimuth = if azimuth < 0.0 { azimuth + TAU } else { azimuth };
        Parametrisation {
            uv: [azimuth / TAU, local.z],
            tangent: self.placement.pose.world_vector(TAU * Vec3::new(-local.y, local.x, 0.0)),
            bitangent: self.placement.pose.world_vector(Vec3::Z),
        }
    }

    /// A box around it.
    pub fn bounds(&self) -> Bounds {
        let half = self.placement.half_extents(2);
        let (bottom, top) = (self.placement.pose.origin, self.placement.pose.world_point(Vec3::Z));
        Bounds { min: bottom.min(top) - half, max: bottom.max(top) + half }
    }

    /// Area of its surface.
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Uniform in local azimuth and height.
    pub fn sample(&self, u: [f64; 2]) -> AreaSample {
        let (sin, cos) = angle::sin_cos(TAU * u[1]);
        let outward = Vec3::new(cos, sin, 0.0);
        AreaSample::analytic(self.surface_at(outward, u[0]), self.local_area_density(outward))
    }

    /// Density per area with which a sample is the point.
    pub fn area_density(&self, point: &SurfacePoint) -> f64 {
        let local = self.placement.pose.local_point(point.position).with_z(0.0);
        self.local_area_density(local.try_normalize().unwrap_or(Vec3::X))
    }

    fn local_area_density(&self, outward: Vec3) -> f64 {
        1.0 / (TAU * self.placement.area_stretch(outward))
    }
}
