//! Sensors that measure light rather than make pictures.

use super::Window;
use crate::geometry::{Bounds, Frame, Ray, SurfacePoint, Vec3};
use crate::sampling::warp;
use crate::shape::Shape;
use std::f64::consts::{FRAC_1_PI, PI};

/// Measures the radiance along one ray, whatever the film position.
#[derive(Clone, Copy, Debug)]
pub struct RadianceMeter {
    origin: Vec3,
    direction: Vec3,
}

impl RadianceMeter {
    /// `direction` of any length, in which the meter looks.
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction: direction.normalize() }
    }

    /// The ray along which it measures.
    pub fn ray(&self) -> Ray {
        Ray::new(self.origin, self.direction)
    }
}

/// Measures the irradiance on a surface, W·m⁻²·nm⁻¹. The film is spread over the surface as Mitsuba 3 does
/// it, so that a single pixel measures the mean over all of it.
#[derive(Clone, Debug)]
pub struct IrradianceMeter {
    surface: Shape,
    window: Window,
    /// 1 / world area.
    per_area: f64,
}

/// A place at which irradiance is measured.
#[derive(Clone, Copy, Debug)]
pub struct LitPoint {
    /// Where it is on its surface.
    pub point: SurfacePoint,
    /// The side from which light counts: the shading normal, of unit length.
    pub facing: Vec3,
}

impl LitPoint {
    /// The density, per steradian, with which a meter chooses the direction of its ray: cos θ / π.
    pub fn density(&self, direction: Vec3) -> f64 {
        direction.dot(self.facing).max(0.0) * FRAC_1_PI
    }
}

impl IrradianceMeter {
    /// `window` is the exposed part of the film.
    pub fn new(surface: Shape, window: Window) -> Self {
        let per_area = 1.0 / surface.area();
        Self { surface, window, per_area }
    }

    /// A box around where its rays begin.
    pub fn origins(&self) -> Bounds {
        let Bounds { min, max } = self.surface.bounds();
        // By less than this do they begin off the surface.
        let margin = Vec3::splat(1e-6 * (max - min).length());
        Bounds { min: min - margin, max: max + margin }
    }

    /// A ray toward the hemisphere around the shading normal, with density cos θ / π, so that its weight is
    /// π, and where it begins.
    pub fn ray(&self, film: [f64; 2], direction_u: [f64; 2]) -> Option<(Ray, f64, LitPoint)> {
        let place = self.window.fractions(film).map(|x| x.clamp(0.0, 1.0 - f64::EPSILON));
        let at = self.surface.point_at_uv(place)?;
        let lit = LitPoint { point: at.surface.point, facing: at.surface.shading_normal };
        let frame = Frame::around(lit.facing);
        let direction = frame.to_world(Vec3::from(warp::cosine_hemisphere(direction_u))).normalize();
        Some((lit.point.ray(direction), PI * self.per_area / at.density, lit))
    }
}

/// Measures what a scene sends into one direction, as seen from afar.
#[derive(Clone, Debug)]
pub struct Distant {
    /// Direction in which the sensor looks.
    direction: Vec3,
    target: Target,
}

/// Where a distant sensor's rays lead.
#[derive(Clone, Debug)]
enum Target {
    /// Evenly through the cross-section of a sphere.
    Sphere { centre: Vec3, radius: f64, across: Frame },
    /// Rays start so far before their target.
    Point { point: Vec3, before: f64 },
    /// Evenly over a surface.
    Surface { surface: Box<Shape>, before: f64, per_area: f64 },
}

impl Distant {
    /// Looks along `direction` (of any length) at the whole of a sphere, starting on it.
    pub fn at_sphere(direction: Vec3, centre: Vec3, radius: f64) -> Self {
        let direction = direction.normalize();
        Self { direction, target: Target::Sphere { centre, radius, across: Frame::around(direction) } }
    }

    /// Looks along `direction` at one point from `before` it.
    pub fn at_point(direction: Vec3, point: Vec3, before: f64) -> Self {
        Self { direction: direction.normalize(), target: Target::Point { point, before } }
    }

    /// Looks along `direction` at points all over a surface, which need not be part of the scene, from
    /// `before` them.
    pub fn at_surface(direction: Vec3, surface: Shape, before: f64) -> Self {
        let per_area = 1.0 / surface.area();
        let surface = Box::new(surface);
        Self { direction: direction.normalize(), target: Target::Surface { surface, before, per_area } }
    }

    /// The ray toward the target point that `target_u` chooses.
    pub fn ray(&self, target_u: [f64; 2]) -> Option<(Ray, f64)> {
        let (origin, weight) = match &self.target {
            Target::Sphere { centre, radius, across } => {
                let [x, y] = warp::disk(target_u);
                (*centre + across.to_world(Vec3::new(x, y, -1.0)) * *radius, 1.0)
            }
            Target::Point { point, before } => (*point - self.direction * *before, 1.0),
            Target::Surface { surface, before, per_area } => {
                let at = surface.sample(target_u)?;
                (at.surface.point.position - self.direction * *before, per_area / at.density)
            }
        };
        Some((Ray::new(origin, self.direction), weight))
    }
}
