//! What is known of some emitters together: where they are, whither they shine, how bright they are.

use crate::geometry::{Bounds, Vec3};
use std::f64::consts::PI;

/// A box that holds emitters, a cone that holds the directions that they face, and their intensity.
#[derive(Clone, Copy, Debug)]
pub struct Bound {
    pub bounds: Bounds,
    /// Radiant intensity in the direction that they face, up to a factor common to all.
    pub intensity: f64,
    /// The intensity of those that shine to one side; the others shine into all directions alike.
    pub one_sided: f64,
    /// Sum of the directions that these face, by intensity.
    pub facing: Vec3,
    /// Angle between that sum and the direction that differs most from it, radians; π where others shine too.
    pub spread: f64,
}

impl Bound {
    /// Bound of a surface that shines to one side.
    pub fn flat(bounds: Bounds, normal: Vec3, intensity: f64) -> Self {
        Self { bounds, intensity, one_sided: intensity, facing: normal * intensity, spread: 0.0 }
    }

    /// Bound of what may shine in any direction.
    pub fn round(bounds: Bounds, intensity: f64) -> Self {
        Self { bounds, intensity, one_sided: 0.0, facing: Vec3::ZERO, spread: PI }
    }

    pub fn union(self, other: Self) -> Self {
        let facing = self.facing + other.facing;
        let spread = match facing.try_normalize() {
            Some(axis) => self.spread_around(axis).max(other.spread_around(axis)),
            None => PI,
        };
        Self {
            bounds: self.bounds.union(other.bounds),
            intensity: self.intensity + other.intensity,
            one_sided: self.one_sided + other.one_sided,
            facing,
            spread,
        }
    }

    /// Angle between a unit vector and the direction of these that differs most from it, or more.
    fn spread_around(&self, axis: Vec3) -> f64 {
        let Some(own) = self.facing.try_normalize() else { return PI };
        // Half the chord is the sine of half the angle, and keeps its digits.
        let half_chord = 0.5 * (axis - own).length();
        (2.0 * half_chord.min(1.0).asin() + self.spread).min(PI)
    }
}
