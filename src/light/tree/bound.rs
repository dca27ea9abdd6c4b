//! What is known of some emitters together: where they are, whither they shine, how bright they are.

use crate::geometry::{Bounds, Vec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// A box that holds emitters, a cone that holds the directions that they face, and their intensity.
#[derive(Clone, Copy, Debug)]
pub struct Bound {
    pub bounds: Bounds,
    /// Axis of the cone, unit length; any direction where `spread` is π.
    pub axis: Vec3,
    /// Angle between the axis and the edge of the cone, radians.
    pub spread: f64,
    /// Angle up to which each emitter shines around the direction that it faces, radians.
    pub reach: f64,
    /// Radiant intensity in the direction that they face, up to a factor common to all.
    pub intensity: f64,
}

impl Bound {
    /// Bound of a surface that shines to one side.
    pub fn flat(bounds: Bounds, normal: Vec3, intensity: f64) -> Self {
        Self { bounds, axis: normal, spread: 0.0, reach: FRAC_PI_2, intensity }
    }

    /// Bound of what may shine in any direction.
    pub fn round(bounds: Bounds, intensity: f64) -> Self {
        Self { bounds, axis: Vec3::Z, spread: PI, reach: FRAC_PI_2, intensity }
    }

    pub fn union(self, other: Self) -> Self {
        let (axis, spread) = cone_of_both((self.axis, self.spread), (other.axis, other.spread));
        Self {
            bounds: self.bounds.union(other.bounds),
            axis,
            spread,
            reach: self.reach.max(other.reach),
            intensity: self.intensity + other.intensity,
        }
    }
}

/// The smallest cone around two.
fn cone_of_both((a, a_spread): (Vec3, f64), (b, b_spread): (Vec3, f64)) -> (Vec3, f64) {
    if a_spread < b_spread {
        return cone_of_both((b, b_spread), (a, a_spread));
    }
    // Half the chord is the sine of half the angle, and keeps its digits.
    let between = 2.0 * (0.5 * (a - b).length()).min(1.0).asin();
    if (between + b_spread).min(PI) <= a_spread {
        return (a, a_spread);
    }
    let spread = 0.5 * (a_spread + between + b_spread);
    let turn = spread - a_spread;
    match (b - a * a.dot(b)).try_normalize() {
        Some(across) if spread < PI => (a * turn.cos() + across * turn.sin(), spread),
        _ => (a, PI),
    }
}

/// Where light is received.
#[derive(Clone, Copy, Debug)]
pub struct Viewpoint {
    pub position: Vec3,
    /// The side from which light counts; zero where all does.
    pub facing: Vec3,
}

/// A [`Bound`] as the tree keeps it, with a sphere in place of the box.
#[derive(Clone, Copy, Debug, Default)]
pub struct Ball {
    centre: [f32; 3],
    radius: f32,
    axis: [f32; 3],
    cos_spread: f32,
    sin_spread: f32,
    cos_reach: f32,
    intensity: f32,
}

impl Ball {
    /// `whole`: the intensity that is kept as 1.
    pub fn new(bound: &Bound, whole: f64) -> Self {
        /// Least intensity kept: what emits at all stays above zero.
        const LEAST: f64 = 1e-30;
        /// Whatever rounding does, what can be seen has an importance.
        const RESERVE: f64 = 1e-4;
        let centre = bound.bounds.centre();
        let rounding = f64::from(f32::EPSILON) * centre.abs().max_element();
        let spread = (bound.spread + RESERVE).min(PI);
        Self {
            centre: centre.to_array().map(|c| c as f32),
            radius: (0.5 * bound.bounds.diameter() + rounding) as f32,
            axis: bound.axis.to_array().map(|c| c as f32),
            cos_spread: spread.cos() as f32,
            sin_spread: spread.sin() as f32,
            cos_reach: (bound.reach.cos() - RESERVE) as f32,
            intensity: (bound.intensity / whole).max(LEAST) as f32,
        }
    }

    /// About the irradiance that it brings to a place, over that of the whole tree's intensity: no emitter
    /// within the ball brings more per intensity, but for those that are nearer than its radius.
    #[inline]
    pub fn importance(&self, from: &Viewpoint) -> f64 {
        let away = Vec3::from(self.centre.map(f64::from)) - from.position;
        let (squared, radius) = (away.length_squared(), f64::from(self.radius));
        let radius_squared = radius * radius;
        let intensity = f64::from(self.intensity);
        if squared <= radius_squared {
            return intensity / radius_squared.max(f64::MIN_POSITIVE);
        }
        let direction = away / squared.sqrt();
        // The angle that the ball fills to each side.
        let sin2 = radius_squared / squared;
        let (sin, cos) = (sin2.sqrt(), (1.0 - sin2).sqrt());
        let received = if from.facing == Vec3::ZERO {
            1.0
        } else {
            cos_beyond(direction.dot(from.facing), [cos, sin]).max(0.0)
        };
        let [cos_spread, sin_spread] = [self.cos_spread, self.sin_spread].map(f64::from);
        // The cone's angle and the ball's together; beyond π there is no direction outside.
        let wide = [cos_spread * cos - sin_spread * sin, sin_spread * cos + cos_spread * sin];
        let leaving = if wide[1] < 0.0 {
            1.0
        } else {
            cos_beyond(-direction.dot(Vec3::from(self.axis.map(f64::from))), wide)
        };
        if leaving <= f64::from(self.cos_reach) {
            return 0.0;
        }
        // At the edge of the reach it may have fallen to less than nothing by the reserve.
        intensity * leaving.max(1e-4) * received / squared
    }
}

/// The cosine of how far an angle, given by its cosine, goes beyond another, given by its cosine and sine: 1
/// where it doesn't.
#[inline]
fn cos_beyond(cos: f64, [other_cos, other_sin]: [f64; 2]) -> f64 {
    if cos >= other_cos { 1.0 } else { cos * other_cos + (1.0 - cos * cos).max(0.0).sqrt() * other_sin }
}
