//! Rays that leave a surface, at all angles down to 10⁻⁴ rad, at all scales and far from the origin.

use super::{direction, placement};
use crate::geometry::{Ray, SurfacePoint, Transform, Vec3};
use crate::shape::Shape;
use rand::RngExt;
use rand_pcg::Pcg64Mcg as Random;

/// Scales, and distances from the origin.
pub const PLACES: [(f64, f64); 5] = [(1.0, 0.0), (1e-6, 0.0), (1e6, 0.0), (1.0, 1e5), (1e-3, 1e2)];

/// A skewed one at a scale and a distance.
pub fn placed([scale, distance]: [f64; 2], random: &mut Random) -> Transform {
    placement(Vec3::new(0.9, 0.5, 0.3) * scale).then(&Transform::translation(direction(random) * distance))
}

/// A point and two rays that leave it at an angle to the surface.
pub struct Leaving {
    pub point: SurfacePoint,
    pub angle: f64,
    pub outward: Ray,
    pub inward: Ray,
}

/// `None` where there is no sample.
pub fn leave(shape: &Shape, random: &mut Random) -> Option<Leaving> {
    let point = shape.sample([random.random(), random.random()])?.surface.point;
    let angle = 10f64.powf(random.random_range(-4.0..0.0));
    let across = direction(random).cross(point.normal).normalize();
    let [outward, inward] = [1.0, -1.0]
        .map(|side| point.ray((across * angle.cos() + point.normal * (side * angle.sin())).normalize()));
    Some(Leaving { point, angle, outward, inward })
}
