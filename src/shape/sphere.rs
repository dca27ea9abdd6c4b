//! Spheres, and ellipsoids where the placement is not a similarity.

use super::crossing::{Crossing, Crossings};
use super::placement::Placement;
use super::{AreaSample, Parametrisation, ShapeError, ShapeSample, SurfaceHit};
use crate::geometry::{Bounds, Points, Ray, SurfacePoint, Transform, Vec3, angle, axes_around};
use crate::lanes::{Real, Vector};
use crate::sampling::quadrature::gauss_legendre;
use std::f64::consts::{PI, TAU};

/// A sphere, which a transform may stretch.
#[derive(Clone, Debug)]
pub struct Sphere {
    placement: Placement,
    inward: bool,
    area: f64,
    /// Only places farther than this from the centre are surely outside. One that lies on the sphere may seem
    /// to be outside by rounding: the cone from there would lead to nothing but the place itself. Infinite
    /// where no cone is asked for.
    outside: f64,
}

/// Height over a sphere, as a share of its radius, at which a place counts as lying on it. Places on one that
/// an instance shows are known less well than those of the world, by how far away that is.
const CLOSE: f64 = 1e-9;

impl Sphere {
    /// `to_world` applied to the sphere of the given centre and radius.
    /// Normals point outward unless `flip_normals`; a mirroring `to_world` turns them, as in Mitsuba 3.
    pub fn new(
        to_world: &Transform,
        centre: Vec3,
        radius: f64,
        flip_normals: bool,
    ) -> Result<Self, ShapeError> {
        if !(radius > 0.0 && radius.is_finite()) {
            return Err(ShapeError::Radius(radius));
        }
        if !centre.is_finite() {
            return Err(ShapeError::Placement);
        }
        let place = Transform::scale(radius).then(&Transform::translation(centre)).then(to_world);
        let placement = Placement::new(&place)?;
        let area = match placement.scale {
            Some(radius) => 4.0 * PI * radius * radius,
            None => ellipsoid_area(&placement),
        };
        let rounding = 64.0 * f64::EPSILON * placement.pose.origin.length();
        let inward = flip_normals != placement.mirrors;
        let outside = match placement.scale {
            Some(radius) if !inward => radius * (1.0 + CLOSE) + rounding,
            _ => f64::INFINITY,
        };
        Ok(Self { inward, placement, area, outside })
    }

    /// Nearest distance with 0 ≤ t < `ray.t_max`.
    pub fn intersect(&self, ray: &Ray) -> Option<f64> {
        let (t, met) = self.distance::<f64>(Vector::of(ray.origin), Vector::of(ray.direction));
        (met && t < ray.t_max).then_some(t)
    }

    /// The nearest distance along rays that is not negative, and whether there is one.
    #[inline(always)]
    pub fn distance<R: Real>(&self, origin: Vector<R>, direction: Vector<R>) -> (R, R::Truth) {
        let pose = &self.placement.pose;
        let direction = direction.mapped(&pose.inverse);
        let speed = direction.length();
        let origin = (origin - Vector::of(pose.origin)).mapped(&pose.inverse);
        let ([near, far], met) = unit_ball_roots(origin, direction / speed);
        let t = R::choose(near.ge(R::of(0.0)), near, far) / speed;
        (t, met & t.ge(R::of(0.0)))
    }

    /// Both crossings along the whole line.
    pub fn crossings(&self, ray: &Ray) -> Crossings {
        let origin = self.placement.pose.local_point(ray.origin);
        let direction = self.placement.pose.local_vector(ray.direction);
        let speed = direction.length();
        let Some((near, far)) = unit_ball_line(origin, direction / speed) else { return Crossings::new() };
        let error = ball_error(&self.placement, origin, [near, far], 1.0);
        let at = |t: f64, enters: bool| {
            let t = t / speed;
            Crossing::analytic(t, error / speed + 4.0 * f64::EPSILON * t.abs(), enters != self.inward, 0)
        };
        [at(near, true), at(far, false)].into_iter().collect()
    }

    /// See [`Shape::is_farther_than`](super::Shape::is_farther_than).
    pub fn is_farther_than(&self, ray: &Ray) -> bool {
        self.placement.ends_within(ray, |origin| (origin.length() - 1.0).abs())
    }

    /// The point of the surface nearest to `position`, in local space.
    pub fn surface(&self, position: Vec3) -> SurfaceHit {
        let local = self.placement.pose.local_point(position);
        self.surface_at(local.try_normalize().unwrap_or(Vec3::Z))
    }

    fn surface_at(&self, local: Vec3) -> SurfaceHit {
        let point = SurfacePoint::from(self.points_at::<f64>(Vector::of(local)));
        SurfaceHit { point, shading_normal: point.normal }
    }

    /// The points where these are in local space.
    #[inline(always)]
    fn points_at<R: Real>(&self, local: Vector<R>) -> Points<R> {
        let pose = &self.placement.pose;
        let position = Vector::of(pose.origin) + local.mapped(&pose.linear);
        let outward = local.mapped(&pose.inverse.transpose());
        let stretch = outward.length();
        let normal = outward / if self.inward { -stretch } else { stretch };
        Points { position, normal, error: self.placement.errors(position, local, stretch) }
    }

    /// u along the azimuth, v from the pole at local +z to the other.
    pub fn parametrisation(&self, position: Vec3) -> Parametrisation {
        let local = self.placement.pose.local_point(position);
        let azimuth = angle::atan2(local.y, local.x);
        let azimuth = if azimuth < 0.0 { azimuth + TAU } else { azimuth };
        let from_axis = local.x.hypot(local.y);
        let polar = angle::atan2(from_axis, local.z);
        let outward = if from_axis > 0.0 { Vec3::new(local.x, local.y, 0.0) / from_axis } else { Vec3::X };
        Parametrisation {
            uv: [azimuth / TAU, polar / PI],
            tangent: self.placement.pose.world_vector(TAU * Vec3::new(-local.y, local.x, 0.0)),
            bitangent: self.placement.pose.world_vector(PI * (outward * local.z - Vec3::Z * from_axis)),
        }
    }

    /// A box around it.
    pub fn bounds(&self) -> Bounds {
        let half = self.placement.half_extents(3);
        Bounds { min: self.placement.pose.origin - half, max: self.placement.pose.origin + half }
    }

    /// The most that direction · x is on it.
    pub fn reach(&self, direction: Vec3) -> f64 {
        let pose = &self.placement.pose;
        direction.dot(pose.origin) + (pose.linear.transpose() * direction).length()
    }

    /// `None` where it is drawn out to an ellipsoid.
    pub fn radius(&self) -> Option<f64> {
        self.placement.scale
    }

    /// Its centre and its radius, if it has one.
    pub fn ball(&self) -> Option<(Vec3, f64)> {
        self.radius().map(|radius| (self.placement.pose.origin, radius))
    }

    /// Area of its surface.
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Uniform over the unit sphere of local space.
    pub fn sample(&self, u: [f64; 2]) -> AreaSample {
        let z = 1.0 - 2.0 * u[0];
        let (sin, cos) = angle::sin_cos(TAU * u[1]);
        let r = (2.0 * (u[0] - u[0] * u[0]).max(0.0).sqrt()).min(1.0);
        let local = Vec3::new(r * cos, r * sin, z);
        AreaSample::analytic(self.surface_at(local.normalize()), self.local_area_density(local))
    }

    /// Density per area with which a sample is the point.
    pub fn area_density(&self, point: &SurfacePoint) -> f64 {
        self.local_area_density(self.placement.pose.local_point(point.position))
    }

    /// An area of the local sphere is |det L| |L⁻ᵀ n| times as large in world space.
    fn local_area_density(&self, local: Vec3) -> f64 {
        match self.placement.scale {
            Some(_) => 1.0 / self.area,
            None => {
                let stretch =
                    self.placement.volume * self.placement.pose.world_normal(local.normalize()).length();
                1.0 / (4.0 * PI * stretch)
            }
        }
    }

    /// Uniform in solid angle over the cone that the sphere fills. `None` from inside, where the placement
    /// isn't a similarity or where normals point inward.
    pub fn sample_cone(&self, reference: Vec3, u: [f64; 2]) -> Option<ShapeSample> {
        let (points, density, is_outside) = self.cone_points::<f64>(Vector::of(reference), u);
        let point = SurfacePoint::from(points);
        let surface = SurfaceHit { point, shading_normal: point.normal };
        is_outside.then_some(ShapeSample { surface, triangle: 0, barycentric: [0.0; 2], density })
    }

    /// Density per steradian of [`Sphere::sample_cone`], wherever it is defined.
    pub fn cone_density(&self, reference: Vec3) -> Option<f64> {
        let (density, is_outside) = self.cone_densities::<f64>(Vector::of(reference));
        is_outside.then_some(density)
    }

    /// The radius of one that fills a cone as seen from outside. From there, the front of one that is turned
    /// inside out is what lies beyond the cone's near side.
    pub fn cone_radius(&self) -> Option<f64> {
        self.placement.scale.filter(|_| !self.inward)
    }

    /// The points that [`Sphere::sample_cone`] finds from several places, with their densities and whether
    /// the places are outside. None is of a sphere without a [`Sphere::cone_radius`].
    #[inline(always)]
    pub fn cone_points<R: Real>(&self, reference: Vector<R>, u: [R; 2]) -> (Points<R>, R, R::Truth) {
        let one = R::of(1.0);
        let cone = self.cone(reference);
        // x = 1 - cos θ is kept, never cos θ: a distant sphere fills no more than x = 1e-20.
        let x = u[0] * cone.one_minus_cos;
        let (cos_theta, sin_squared) = (one - x, x * (R::of(2.0) - x));
        // β is the angle at the surface between its normal and the ray, α the one at the centre: α = β - θ.
        let sin_theta = sin_squared.sqrt();
        let sin_beta = (sin_theta / cone.sin).lesser(one);
        let cos_beta = (one - sin_beta * sin_beta).sqrt();
        let cos_alpha = cos_beta * cos_theta + sin_beta * sin_theta;
        let sin_alpha = sin_beta * cos_theta - cos_beta * sin_theta;
        let (sin_phi, cos_phi) = angle::sin_cos(R::of(TAU) * u[1]);
        let z = cone.toward_reference;
        let [x, y] = axes_around(z);
        let direction = x * (sin_alpha * cos_phi) + y * (sin_alpha * sin_phi) + z * cos_alpha;
        let local = direction.mapped(&self.placement.pose.inverse).normalize();
        (self.points_at(local), cone.density(), cone.is_outside)
    }

    /// Likewise [`Sphere::cone_density`].
    #[inline(always)]
    pub fn cone_densities<R: Real>(&self, reference: Vector<R>) -> (R, R::Truth) {
        let cone = self.cone(reference);
        (cone.density(), cone.is_outside)
    }

    #[inline(always)]
    fn cone<R: Real>(&self, reference: Vector<R>) -> Cone<R> {
        let radius = R::of(self.cone_radius().unwrap_or(f64::INFINITY));
        let from_centre = reference - Vector::of(self.placement.pose.origin);
        let distance = from_centre.length();
        let sin = radius / distance;
        // cos² = 1 - sin², without losing digits where the reference is close to the surface.
        let cos = ((distance - radius) * (distance + radius)).sqrt() / distance;
        Cone {
            sin,
            one_minus_cos: sin * sin / (R::of(1.0) + cos),
            toward_reference: from_centre / distance,
            is_outside: distance.gt(R::of(self.outside)),
        }
    }
}

/// The directions from a point in which it sees a sphere. Means nothing inside.
struct Cone<R: Real> {
    sin: R,
    one_minus_cos: R,
    toward_reference: Vector<R>,
    is_outside: R::Truth,
}

impl<R: Real> Cone<R> {
    #[inline(always)]
    fn density(&self) -> R {
        R::of(1.0) / (R::of(TAU) * self.one_minus_cos)
    }
}

/// Both parameters at which a line (its direction of unit length) crosses the unit sphere, the smaller
/// first. `None` for lines that miss or touch, and for rays that are outside and go away.
///
/// The discriminant is r² - |o + t_c d|² with t_c the parameter nearest to the centre, which is free of
/// the cancellation of b² - c far away. The root of smaller magnitude is c / q, so that its sign is that of
/// c = |o|² - 1: a ray that starts outside never finds itself inside, however flat it leaves.
#[inline(always)]
pub(super) fn unit_ball_roots<R: Real>(origin: Vector<R>, direction: Vector<R>) -> ([R; 2], R::Truth) {
    let zero = R::of(0.0);
    let c = origin.length_squared() - R::of(1.0);
    let closest = -origin.dot(direction);
    let leads_away = c.gt(zero) & closest.le(zero);
    let discriminant = R::of(1.0) - (origin + direction * closest).length_squared();
    let q = closest + discriminant.greater(zero).sqrt().copysign(closest);
    let other = c / q;
    ([q.lesser(other), q.greater(other)], discriminant.gt(zero) & !leads_away)
}

/// The same for the whole line: its ends are exchanged where it leads away.
pub(super) fn unit_ball_line(origin: Vec3, direction: Vec3) -> Option<(f64, f64)> {
    let roots = |direction: Vec3| {
        let ([near, far], met) = unit_ball_roots::<f64>(Vector::of(origin), Vector::of(direction));
        met.then_some((near, far))
    };
    if origin.dot(direction) <= 0.0 {
        return roots(direction);
    }
    roots(-direction).map(|(near, far)| (-far, -near))
}

/// Bound on the error of both roots: that of coordinates changes the discriminant D by no more than twice as
/// much, and √D, half the distance between the roots, by change / √D and by √change at most. `speed` is the
/// parameter's own.
pub(super) fn ball_error(placement: &Placement, origin: Vec3, [near, far]: [f64; 2], speed: f64) -> f64 {
    let coordinate = placement.coordinate_error(1.0 + origin.abs().max_element());
    let change = 2.0 * coordinate + 8.0 * f64::EPSILON;
    let half = 0.5 * (far - near);
    (change / half).min(change.sqrt()) / speed + coordinate / speed
}

/// ∫ |det L| |L⁻ᵀ n| dn over the unit sphere, by Gauss-Legendre quadrature in z and the trapezoid rule in
/// azimuth (exact to rounding for moderate axes ratios, to 1e-4 for needles of 1:1000).
fn ellipsoid_area(placement: &Placement) -> f64 {
    const RINGS: usize = 64;
    const SECTORS: usize = 128;
    let mut sum = 0.0;
    for (z, weight) in gauss_legendre(RINGS) {
        let r = (1.0 - z * z).sqrt();
        let ring: f64 = (0..SECTORS)
            .map(|i| {
                let (sin, cos) = (TAU * i as f64 / SECTORS as f64).sin_cos();
                placement.pose.world_normal(Vec3::new(r * cos, r * sin, z)).length()
            })
            .sum();
        sum += weight * ring * TAU / SECTORS as f64;
    }
    placement.volume * sum
}
