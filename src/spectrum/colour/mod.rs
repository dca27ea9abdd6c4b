//! Colour: from spectra to tristimulus values, chromaticities, colour differences and display values.
//!
//! After CIE 15:2018. Tristimulus values are as their observer gives them; [`Xyz`] carries no scale of its
//! own.

mod delta_e;
mod observer;
mod rgb;
mod white;

pub use delta_e::{Lab, delta_e_2000};
pub use observer::{MITSUBA_Y_INTEGRAL, Observer};
pub(crate) use rgb::inverse;
pub use rgb::{RgbSpace, XYZ_TO_REC709, rec709_to_xyz, srgb_decode, srgb_encode, srgb_hex, xyz_to_rec709};
pub use white::assumed_white;

use std::ops::{Add, Div, Mul};

/// Tristimulus values. Their unit is that of what was integrated; relative colours have Y = 1 for white.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Xyz {
    /// Tristimulus value X.
    pub x: f64,
    /// Tristimulus value Y: luminance, for radiance in the observer's unit.
    pub y: f64,
    /// Tristimulus value Z.
    pub z: f64,
}

impl Xyz {
    /// The colour with chromaticity (x, y) and luminance `luminance`; `y` must not be 0.
    pub fn from_chromaticity(x: f64, y: f64, luminance: f64) -> Self {
        Self { x: luminance * x / y, y: luminance, z: luminance * (1.0 - x - y) / y }
    }

    /// Chromaticity coordinates (x, y). `None` for black.
    pub fn chromaticity(self) -> Option<(f64, f64)> {
        let sum = self.x + self.y + self.z;
        (sum != 0.0).then(|| (self.x / sum, self.y / sum))
    }

    /// CIELAB coordinates relative to `white` (CIE 15:2018, section 8.2.1).
    pub fn to_lab(self, white: Xyz) -> Lab {
        Lab::from_xyz(self, white)
    }
}

impl From<[f64; 3]> for Xyz {
    fn from([x, y, z]: [f64; 3]) -> Self {
        Self { x, y, z }
    }
}

impl From<Xyz> for [f64; 3] {
    fn from(colour: Xyz) -> Self {
        [colour.x, colour.y, colour.z]
    }
}

impl Add for Xyz {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl Mul<f64> for Xyz {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }
}

impl Div<f64> for Xyz {
    type Output = Self;
    fn div(self, divisor: f64) -> Self {
        Self { x: self.x / divisor, y: self.y / divisor, z: self.z / divisor }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chromaticity_round_trip() {
        let colour = Xyz::from_chromaticity(0.3127, 0.3290, 0.7);
        let (x, y) = colour.chromaticity().unwrap();
        assert!((x - 0.3127).abs() < 1e-15 && (y - 0.3290).abs() < 1e-15 && colour.y == 0.7);
        assert_eq!(Xyz::default().chromaticity(), None);
    }
}
