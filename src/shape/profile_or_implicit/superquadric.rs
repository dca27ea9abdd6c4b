//! Superellipsoids: (|x|^(2/e₂) + |y|^(2/e₂))^(e₂/e₁) + |z|^(2/e₁) = 1 (Glassner, *An Introduction to Ray
//! Tracing*, ch. 3, superquadrics, with the absolute values that are missing there).
//!
//! As long as neither exponent exceeds 2, what is on the left, taken to the power e₁/2, is a norm: it grows
//! in proportion along rays from the centre and is convex along every line. So a line crosses the surface
//! twice or not at all, and Newton's method, begun outside, comes nearer from the same side until it is
//! there, or finds the slope turned, which proves a miss.

use super::Local;
use crate::geometry::Vec3;
use crate::shape::ShapeError;
use crate::shape::random_lines::OnLine;
use smallvec::SmallVec;
use std::f64::consts::{PI, TAU};

/// A superellipsoid with semi-axes of 1.
#[derive(Clone, Debug)]
pub(super) struct Superquadric {
    /// e₁, from pole to pole, and e₂, around z.
    exponents: [f64; 2],
    /// 2/e₂ and 2/e₁: the powers across and along z.
    powers: [f64; 2],
}

/// (aᵖ + bᵖ)^(1/p) for numbers that are not negative, and its derivatives by both.
fn norm(a: f64, b: f64, power: f64) -> (f64, [f64; 2]) {
    let (small, large) = if a < b { (a, b) } else { (b, a) };
    if large == 0.0 {
        return (0.0, [0.0; 2]);
    }
    let value = large * (1.0 + (small / large).powf(power)).powf(1.0 / power);
    (value, [a, b].map(|x| (x / value).powf(power - 1.0)))
}

impl Superquadric {
    /// Both exponents from [`Superquadric::LEAST`] to 2.
    pub fn new(exponents: [f64; 2]) -> Result<Self, ShapeError> {
        for exponent in exponents {
            if !(Self::LEAST..=2.0).contains(&exponent) {
                return Err(ShapeError::Exponent(exponent));
            }
        }
        Ok(Self { exponents, powers: [2.0 / exponents[1], 2.0 / exponents[0]] })
    }

    /// A box whose edges are rounded by less than a thousandth.
    const LEAST: f64 = 0.001;

    /// 1 on the surface, and the gradient, either of those at a crease.
    fn value(&self, x: Vec3) -> (f64, Vec3) {
        let size = x.abs();
        let (across, [by_x, by_y]) = norm(size.x, size.y, self.powers[0]);
        let (value, [by_across, by_z]) = norm(across, size.z, self.powers[1]);
        (value, Vec3::new(by_across * by_x, by_across * by_y, by_z) * x.map(f64::signum))
    }

    /// The first crossing after `from`, where the line is outside, with the slope there.
    fn first(&self, start: Vec3, direction: Vec3, from: f64, to: f64) -> Option<(f64, f64)> {
        const MOST_STEPS: usize = 200;
        let mut t = from;
        let mut last = 0.0;
        for _ in 0..MOST_STEPS {
            let (value, gradient) = self.value(start + direction * t);
            let slope = gradient.dot(direction);
            if value <= 1.0 {
                return Some((t, if slope < 0.0 { slope } else { last }));
            }
            let next = t - (value - 1.0) / slope;
            if slope >= 0.0 || next > to {
                return None;
            }
            if next == t {
                return Some((t, slope));
            }
            (t, last) = (next, slope);
        }
        Some((t, last))
    }
}

impl Local for Superquadric {
    fn crossed(&self, origin: Vec3, direction: Vec3, rounding: f64) -> SmallVec<[OnLine; 4]> {
        let mut found = SmallVec::new();
        let shift = -origin.dot(direction);
        let start = origin + direction * shift;
        // Within the ball around the box [-1, 1]³, a little enlarged: the norm is at least the largest
        // coordinate.
        let half = (3.0 + 1e-9 - start.length_squared()).sqrt();
        if half.is_nan() {
            return found;
        }
        let Some((enter, falling)) = self.first(start, direction, -half, half) else { return found };
        let Some((leave, rising)) = self.first(start, -direction, -half, -enter) else { return found };
        let leave = -leave;
        // The gradient's components are at most 1. Values are off by that of the coordinates, and by their
        // own rounding.
        let height = 3.0 * rounding + 16.0 * f64::EPSILON;
        // Outwards a convex function rises at least as steeply as here; inwards, a chord to a point of some
        // depth bounds where it is `height` below. Where there is no such depth the line all but touches.
        let depth = 1.0 - self.value(start + direction * (0.5 * (enter + leave))).0;
        let inwards = if depth > height { 0.5 * (leave - enter) * height / depth } else { leave - enter };
        let error = |t: f64, slope: f64| {
            let along = 4.0 * f64::EPSILON * (shift.abs() + t.abs());
            inwards.max(height / slope.abs()).min(2.0 * half) + along
        };
        if enter < leave {
            found.extend([
                OnLine { t: shift + enter, error: error(enter, falling), enters: true, part: 0 },
                OnLine { t: shift + leave, error: error(leave, rising), enters: false, part: 0 },
            ]);
        }
        found
    }

    fn normal(&self, point: Vec3, _: u32) -> Vec3 {
        self.value(point).1.try_normalize().unwrap_or(Vec3::Z)
    }

    /// Along the ray from the centre.
    fn project(&self, point: Vec3, _: u32) -> Vec3 {
        point / self.value(point).0
    }

    /// By the inverse of x = cosᵉ¹η cosᵉ²ω, y = cosᵉ¹η sinᵉ²ω, z = sinᵉ¹η (signed powers): u is ω, once
    /// around z, and v is η, from the pole at +z to that at -z, as on a sphere.
    fn parametrisation(&self, point: Vec3, _: u32) -> ([f64; 2], [Vec3; 2]) {
        let [e1, e2] = self.exponents;
        let size = point.abs();
        // The angle whose sine and cosine are in proportion to the roots of two numbers.
        let angle = |a: f64, b: f64, exponent: f64| {
            if a > b {
                0.5 * PI - (b / a).powf(1.0 / exponent).atan()
            } else {
                (a / b.max(f64::MIN_POSITIVE)).powf(1.0 / exponent).atan()
            }
        };
        let (across, _) = norm(size.x, size.y, self.powers[0]);
        let (around, up) = (angle(size.y, size.x, e2), angle(size.z, across, e1));
        let u = match (point.x < 0.0, point.y < 0.0) {
            (false, false) => around,
            (true, false) => PI - around,
            (true, true) => PI + around,
            (false, true) => TAU - around,
        };
        let ((sin_u, cos_u), (sin_v, cos_v)) = (around.sin_cos(), up.sin_cos());
        // d cosᵉ = −e cosᵉ tan, d sinᵉ = e sinᵉ / tan, of either sign.
        let turned = point.y.signum() * point.x.signum();
        let by_u = Vec3::new(-point.x * sin_u / cos_u, point.y * cos_u / sin_u, 0.0) * (e2 * TAU * turned);
        let (tan, side) = (sin_v / cos_v, point.z.signum());
        let by_v = Vec3::new(point.x * tan, point.y * tan, -point.z / tan) * (e1 * PI * side);
        let finite = |vector: Vec3| if vector.is_finite() { vector } else { Vec3::ZERO };
        ([u / TAU, 0.5 - side * up / PI], [finite(by_u), finite(by_v)])
    }

    /// The dual norm, whose powers q are those with 1/p + 1/q = 1.
    fn reach(&self, direction: Vec3) -> f64 {
        let dual = |a: f64, b: f64, power: f64| {
            if power == 1.0 { a.max(b) } else { norm(a, b, power / (power - 1.0)).0 }
        };
        let size = direction.abs();
        dual(dual(size.x, size.y, self.powers[0]), size.z, self.powers[1])
    }

    fn rounding(&self, _: Vec3) -> f64 {
        16.0 * f64::EPSILON
    }

    fn is_closed(&self) -> bool {
        true
    }
}
