//! Maps from the unit square to the domains that are sampled, each with its density.

use crate::geometry::Vec3;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

/// A point of the unit disk, uniform in area, neighbours staying neighbours
/// (Shirley and Chiu, "A low distortion map between disk and square", JGT 2(3), 1997).
pub fn disk(u: [f64; 2]) -> [f64; 2] {
    let [a, b] = u.map(|value| 2.0 * value - 1.0);
    if a == 0.0 && b == 0.0 {
        return [0.0, 0.0];
    }
    let (radius, angle) =
        if a.abs() > b.abs() { (a, FRAC_PI_4 * (b / a)) } else { (b, FRAC_PI_2 - FRAC_PI_4 * (a / b)) };
    let (sin, cos) = angle.sin_cos();
    [radius * cos, radius * sin]
}

/// A direction around +z with density cos θ / π per steradian.
pub fn cosine_hemisphere(u: [f64; 2]) -> Vec3 {
    let [x, y] = disk(u);
    Vec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt())
}

pub fn cosine_hemisphere_density(cos: f64) -> f64 {
    cos.max(0.0) / PI
}

/// A direction with density [`SPHERE_DENSITY`].
pub fn sphere(u: [f64; 2]) -> Vec3 {
    let z = 1.0 - 2.0 * u[0];
    let radius = (4.0 * u[0] * (1.0 - u[0])).max(0.0).sqrt();
    let (sin, cos) = (TAU * u[1]).sin_cos();
    Vec3::new(radius * cos, radius * sin, z)
}

/// Per steradian, over all directions.
pub const SPHERE_DENSITY: f64 = 0.25 / PI;
