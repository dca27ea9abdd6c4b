//! Rings with a round tube.
//!
//! Along a line a torus is a quartic (Glassner, *An Introduction to Ray Tracing*, ch. 3, 3.1, its
//! coefficients corrected). Only the roots of its derivative are taken from the coefficients: between them
//! the distance from the tube's centre line, which has the quartic's sign and no cancellation, is followed to
//! where it is the tube's radius. So a thin ring is as exact as a thick one.

use super::crossing::Crossings;
use super::placement::Placement;
use super::random_lines::OnLine;
use super::{AreaSample, Parametrisation, ShapeError, SurfaceHit};
use crate::geometry::roots::{Sample, polynomial_within, sign_changes};
use crate::geometry::{Bounds, Ray, SurfacePoint, Transform, Vec3, angle};
use smallvec::SmallVec;
use std::f64::consts::{PI, TAU};

/// A torus around the local z axis, with an outer radius of 1.
#[derive(Clone, Debug)]
pub struct Torus {
    placement: Placement,
    /// Radius of the circle in the middle of the tube; `minor` is that of the tube.
    major: f64,
    minor: f64,
    inward: bool,
}

impl Torus {
    /// `to_world` applied to the torus around the z axis, whose tube has the radius `minor`, less than the
    /// `major` of its centre line. Normals point out of the tube unless `flip_normals`.
    pub fn new(to_world: &Transform, major: f64, minor: f64, flip_normals: bool) -> Result<Self, ShapeError> {
        for radius in [major, minor] {
            if !(radius > 0.0 && radius.is_finite()) {
                return Err(ShapeError::Radius(radius));
            }
        }
        if minor >= major {
            return Err(ShapeError::Tube { major, minor });
        }
        let outer = major + minor;
        let placement = Placement::new(&Transform::scale(outer).then(to_world))?;
        Ok(Self { placement, major: major / outer, minor: minor / outer, inward: flip_normals })
    }

    /// Nearest distance with 0 ≤ t < `ray.t_max`.
    pub fn intersect(&self, ray: &Ray) -> Option<f64> {
        if self.is_farther_than(ray) {
            return None;
        }
        let nearest = self.placement.nearest(ray, |origin, direction| self.crossed(origin, direction));
        nearest.map(|(t, _)| t)
    }

    /// All crossings along the whole line.
    pub fn crossings(&self, ray: &Ray) -> Crossings {
        self.placement.crossings(ray, self.inward, |origin, direction| self.crossed(origin, direction))
    }

    /// How far a place is from the surface, unless the torus is stretched.
    pub fn distance_from(&self, place: Vec3) -> Option<f64> {
        let local = self.placement.pose.local_point(place);
        self.placement.scale.map(|scale| self.distance(local, Vec3::ZERO).value.abs() * scale)
    }

    /// See [`Shape::is_farther_than`](super::Shape::is_farther_than).
    pub fn is_farther_than(&self, ray: &Ray) -> bool {
        self.placement.ends_within(ray, |origin| self.distance(origin, Vec3::ZERO).value.abs())
    }

    /// From the nearest point of the tube's centre line to a local point.
    fn off_centre_line(&self, local: Vec3) -> Vec3 {
        let around = local.with_z(0.0).try_normalize().unwrap_or(Vec3::X);
        local - around * self.major
    }

    /// Distance from the surface, negative inside, and its derivative along a direction.
    fn distance(&self, local: Vec3, direction: Vec3) -> Sample {
        let from_axis = (local.x * local.x + local.y * local.y).sqrt();
        let from_circle = from_axis - self.major;
        let from_line = (from_circle * from_circle + local.z * local.z).sqrt();
        let along_radius = (local.x * direction.x + local.y * direction.y) / from_axis;
        let slope = (from_circle * along_radius + local.z * direction.z) / from_line;
        Sample { value: from_line - self.minor, slope, error: 4.0 * f64::EPSILON }
    }

    /// The point of the surface nearest to `position`, in local space.
    pub fn surface(&self, position: Vec3) -> SurfaceHit {
        let local = self.placement.pose.local_point(position);
        let outward = self.off_centre_line(local);
        let circle = local - outward;
        self.surface_at(circle, outward.try_normalize().unwrap_or(Vec3::Z))
    }

    /// At the end of `outward` from a point of the centre line.
    fn surface_at(&self, circle: Vec3, outward: Vec3) -> SurfaceHit {
        let position = self.placement.pose.world_point(circle + outward * self.minor);
        let image = self.placement.pose.world_normal(outward);
        let stretch = image.length();
        let normal = image / if self.inward { -stretch } else { stretch };
        let error = self.placement.error(position, outward, stretch) + 8.0 * f64::EPSILON / stretch;
        SurfaceHit { point: SurfacePoint { position, normal, error }, shading_normal: normal }
    }

    /// u around the axis, v around the tube, from the outside upwards.
    pub fn parametrisation(&self, position: Vec3) -> Parametrisation {
        let local = self.placement.pose.local_point(position);
        let outward = self.off_centre_line(local);
        let around = (local - outward) / self.major;
        let from_circle = outward.dot(around);
        let turns = |y: f64, x: f64| (angle::atan2(y, x) / TAU).rem_euclid(1.0);
        Parametrisation {
            uv: [turns(local.y, local.x), turns(local.z, from_circle)],
            tangent: self.placement.pose.world_vector(TAU * Vec3::new(-local.y, local.x, 0.0)),
            bitangent: self.placement.pose.world_vector(TAU * (Vec3::Z * from_circle - around * local.z)),
        }
    }

    /// A ball rolled around the centre line reaches as far as the circle and the ball together.
    pub fn bounds(&self) -> Bounds {
        let ball = self.placement.half_extents(3) * self.minor;
        let half = self.placement.half_extents(2) * self.major + ball;
        Bounds { min: self.placement.pose.origin - half, max: self.placement.pose.origin + half }
    }

    /// Exact under a similarity, else by the trapezoid rule in both angles.
    pub fn area(&self) -> f64 {
        if let Some(scale) = self.placement.scale {
            return 4.0 * PI * PI * self.major * self.minor * scale * scale;
        }
        const STEPS: usize = 256;
        let mut sum = 0.0;
        for i in 0..STEPS * STEPS {
            let (radius, outward) = self.at_angles(i, STEPS);
            sum += radius * self.minor * self.placement.area_stretch(outward);
        }
        sum * (TAU / STEPS as f64).powi(2)
    }

    /// Distance from the axis, and normal, at one of a number of equal steps in both angles.
    fn at_angles(&self, index: usize, steps: usize) -> (f64, Vec3) {
        let angle = |step: usize| TAU * step as f64 / steps as f64;
        let ((sin_u, cos_u), (sin_v, cos_v)) =
            (angle(index % steps).sin_cos(), angle(index / steps).sin_cos());
        (self.major + self.minor * cos_v, Vec3::new(cos_u * cos_v, sin_u * cos_v, sin_v))
    }

    /// Uniform over the local surface, whose area at the angle v around the tube is in proportion to major +
    /// minor cos v: v + (minor / major) sin v is uniform, Kepler's equation for the outside as aphelion.
    pub fn sample(&self, u: [f64; 2]) -> AreaSample {
        let (sin_u, cos_u) = angle::sin_cos(TAU * u[0]);
        let mean = TAU * u[1] - PI;
        let eccentricity = self.minor / self.major;
        let equation = |v: f64| Sample {
            value: v + eccentricity * v.sin() - mean,
            slope: 1.0 + eccentricity * v.cos(),
            error: 4.0 * f64::EPSILON,
        };
        // Beyond both ends the sign is certain.
        let v = sign_changes(&[-PI - 1.0, PI + 1.0], equation).first().map_or(0.0, |root| root.t);
        let (sin_v, cos_v) = v.sin_cos();
        let around = Vec3::new(cos_u, sin_u, 0.0);
        let outward = around * cos_v + Vec3::Z * sin_v;
        AreaSample::analytic(self.surface_at(around * self.major, outward), self.local_density(outward))
    }

    /// Density per area with which a sample is the point.
    pub fn area_density(&self, point: &SurfacePoint) -> f64 {
        self.local_density(self.placement.pose.local_normal(point.normal).normalize_or_zero())
    }

    /// Either sign of the normal.
    fn local_density(&self, normal: Vec3) -> f64 {
        1.0 / (4.0 * PI * PI * self.major * self.minor * self.placement.area_stretch(normal))
    }

    /// Where a line may be in the torus, as distances from its point nearest to the centre: in the ball of
    /// radius 1, in the slab as thick as the tube and not in the cylinder through the hole, all a little
    /// enlarged. From both ends it goes on as far as the torus is away.
    fn reached(&self, start: Vec3, direction: Vec3) -> Option<[f64; 2]> {
        const MARGIN: f64 = 1e-9;
        const STEPS: usize = 2;
        let half = (1.0 + MARGIN - start.length_squared()).sqrt();
        if half.is_nan() {
            return None;
        }
        let slab = [-1.0, 1.0].map(|side| (side * (self.minor + MARGIN) - start.z) / direction.z);
        // `f64::max` and `f64::min` drop the NaN of a line that lies in a face of the slab.
        let mut low = slab[0].min(slab[1]).max(-half);
        let mut high = slab[0].max(slab[1]).min(half);
        let from_axis = |t: f64| (start + direction * t).with_z(0.0).length();
        if low > high || from_axis(low).max(from_axis(high)) < self.major - self.minor - MARGIN {
            return None;
        }
        for _ in 0..STEPS {
            let away = |t: f64| self.distance(start + direction * t, direction).value - MARGIN;
            low += away(low).max(0.0);
            high -= away(high).max(0.0);
            if low > high {
                return None;
            }
        }
        Some([low, high])
    }

    /// Up to four crossings of the line through a local point, its direction of unit length.
    fn crossed(&self, origin: Vec3, direction: Vec3) -> SmallVec<[OnLine; 4]> {
        let (major, minor) = (self.major, self.minor);
        let shift = -origin.dot(direction);
        let start = origin + direction * shift;
        let mut found = SmallVec::new();
        let Some([low, high]) = self.reached(start, direction) else { return found };
        // The quartic has the coefficients, with A = 1, B = start·direction, C = start·start − (major² +
        // minor²): [C² − 4 major² (minor² − z₀²), 4 B C + 8 major² z₀ z₁, 2 C + 4 B² + 4 major² z₁², 4 B, 1].
        let (b, c) = (start.dot(direction), start.length_squared() - (major * major + minor * minor));
        let (z0, z1) = (start.z, direction.z);
        let squared = 4.0 * major * major;
        let derivative = [
            4.0 * b * c + 2.0 * squared * z0 * z1,
            2.0 * (2.0 * c + 4.0 * b * b + squared * z1 * z1),
            12.0 * b,
            4.0,
        ];
        let mut edges: SmallVec<[f64; 5]> = SmallVec::new();
        edges.push(low);
        edges.extend(polynomial_within(&derivative, [low, high]).iter().map(|root| root.t));
        edges.push(high);
        let function = |t: f64| self.distance(start + direction * t, direction);
        let roots = sign_changes(&edges, function);
        let coordinate = self.placement.coordinate_error(1.0 + origin.abs().max_element());
        // The sharpest bend of the distance near the surface.
        let bend = 2.0 / minor + 2.0 / (major - minor);
        found.extend(roots.iter().map(|root| {
            let slope = function(root.t).slope;
            let height = 2.0 * coordinate + 8.0 * f64::EPSILON;
            // As long as the slope hardly changes over that distance. Else the line all but touches, or it
            // clings to the surface as it passes: then it certainly has where it is further off than rounding
            // could place it.
            let error = if slope * slope > 4.0 * bend * height {
                2.0 * height / slope.abs()
            } else {
                let passed = |reach: f64| {
                    let [before, after] = [-reach, reach].map(|step| function(root.t + step).value);
                    before.abs().min(after.abs()) > height && (before < 0.0) != (after < 0.0)
                };
                let reaches = std::iter::successors(Some(1e-7), |reach| Some(2.0 * reach));
                reaches.take_while(|&reach| reach < 2.0).find(|&reach| passed(reach)).unwrap_or(2.0)
            };
            let rounding = 4.0 * f64::EPSILON * (shift.abs() + root.t.abs());
            OnLine { t: shift + root.t, error: error + rounding, enters: slope < 0.0, part: 0 }
        }));
        found
    }
}
