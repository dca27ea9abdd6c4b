//! CIELAB and the colour difference ΔE₀₀.

use super::Xyz;
use std::f64::consts::PI;

/// CIELAB coordinates: lightness 0 (black) to 100 (white), and two opponent coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lab {
    /// Lightness L*, from 0 (black) to 100 (white).
    pub l: f64,
    /// Coordinate a*, from green to red.
    pub a: f64,
    /// Coordinate b*, from blue to yellow.
    pub b: f64,
}

impl Lab {
    /// CIE 15:2018, section 8.2.1. `colour` and `white` must be in the same unit.
    pub fn from_xyz(colour: Xyz, white: Xyz) -> Self {
        let f = |ratio: f64| {
            const DELTA: f64 = 6.0 / 29.0;
            if ratio > DELTA * DELTA * DELTA {
                ratio.cbrt()
            } else {
                ratio / (3.0 * DELTA * DELTA) + 4.0 / 29.0
            }
        };
        let (x, y, z) = (f(colour.x / white.x), f(colour.y / white.y), f(colour.z / white.z));
        Self { l: 116.0 * y - 16.0, a: 500.0 * (x - y), b: 200.0 * (y - z) }
    }

    /// The inverse of [`Lab::from_xyz`].
    pub fn to_xyz(self, white: Xyz) -> Xyz {
        let cube = |f: f64| {
            const DELTA: f64 = 6.0 / 29.0;
            if f > DELTA { f * f * f } else { 3.0 * DELTA * DELTA * (f - 4.0 / 29.0) }
        };
        let y = (self.l + 16.0) / 116.0;
        Xyz {
            x: white.x * cube(y + self.a / 500.0),
            y: white.y * cube(y),
            z: white.z * cube(y - self.b / 200.0),
        }
    }
}

/// Colour difference CIEDE2000 with unit parametric factors (ISO/CIE 11664-6:2014), written after G. Sharma,
/// W. Wu and E. N. Dalal, *The CIEDE2000 color-difference formula: implementation notes* (2005), whose
/// treatment of hues near the wrap-around it follows.
pub fn delta_e_2000(first: Lab, second: Lab) -> f64 {
    let seventh = |chroma: f64| {
        let cube = chroma * chroma * chroma;
        let power = cube * cube * chroma;
        (power / (power + 25.0 * 25.0 * 25.0 * 25.0 * 25.0 * 25.0 * 25.0)).sqrt()
    };
    let mean_chroma = 0.5 * (first.a.hypot(first.b) + second.a.hypot(second.b));
    let stretch = 1.0 + 0.5 * (1.0 - seventh(mean_chroma));
    let polar = |colour: Lab| {
        let a = stretch * colour.a;
        let hue = if a == 0.0 && colour.b == 0.0 { 0.0 } else { colour.b.atan2(a).rem_euclid(2.0 * PI) };
        (a.hypot(colour.b), hue)
    };
    let ((chroma1, hue1), (chroma2, hue2)) = (polar(first), polar(second));
    let achromatic = chroma1 * chroma2 == 0.0;

    let lightness_difference = second.l - first.l;
    let chroma_difference = chroma2 - chroma1;
    let turn = match hue2 - hue1 {
        _ if achromatic => 0.0,
        angle if angle > PI => angle - 2.0 * PI,
        angle if angle < -PI => angle + 2.0 * PI,
        angle => angle,
    };
    let hue_difference = 2.0 * (chroma1 * chroma2).sqrt() * (0.5 * turn).sin();

    let lightness = 0.5 * (first.l + second.l);
    let chroma = 0.5 * (chroma1 + chroma2);
    let hue = match hue1 + hue2 {
        sum if achromatic => sum,
        sum if (hue1 - hue2).abs() <= PI => 0.5 * sum,
        sum if sum < 2.0 * PI => 0.5 * sum + PI,
        sum => 0.5 * sum - PI,
    };
    let degrees = hue.to_degrees();
    let weight = 1.0 - 0.17 * (hue - PI / 6.0).cos()
        + 0.24 * (2.0 * hue).cos()
        + 0.32 * (3.0 * hue + 6f64.to_radians()).cos()
        - 0.20 * (4.0 * hue - 63f64.to_radians()).cos();
    let off_middle = (lightness - 50.0) * (lightness - 50.0);
    let lightness_scale = 1.0 + 0.015 * off_middle / (20.0 + off_middle).sqrt();
    let chroma_scale = 1.0 + 0.045 * chroma;
    let hue_scale = 1.0 + 0.015 * chroma * weight;
    let blue = (degrees - 275.0) / 25.0;
    let rotation = -(2.0 * (30.0 * (-blue * blue).exp()).to_radians()).sin() * 2.0 * seventh(chroma);

    let l = lightness_difference / lightness_scale;
    let c = chroma_difference / chroma_scale;
    let h = hue_difference / hue_scale;
    (l * l + c * c + h * h + rotation * c * h).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::table_file::TableFile;

    /// The 34 test pairs of Sharma, Wu and Dalal, with differences from an independent implementation
    /// (`validation/colour/make_reference.py`); they probe every branch of the formula.
    #[test]
    fn sharmas_pairs() {
        let table = TableFile::parse(include_str!("../../../tests/data/delta_e_2000.csv")).unwrap();
        let column = |name: &str| table.numbers(name).unwrap();
        let [l1, a1, b1, l2, a2, b2] = ["L1", "a1", "b1", "L2", "a2", "b2"].map(column);
        let (expected, published) = (column("delta_e"), column("published"));
        assert_eq!(expected.len(), 34);
        for i in 0..expected.len() {
            let first = Lab { l: l1[i], a: a1[i], b: b1[i] };
            let second = Lab { l: l2[i], a: a2[i], b: b2[i] };
            let found = delta_e_2000(first, second);
            assert!((found - expected[i]).abs() < 1e-9, "pair {}: {found}, {}", i + 1, expected[i]);
            assert!((found - published[i]).abs() < 5.1e-5, "pair {}: {found}, {}", i + 1, published[i]);
            assert!((found - delta_e_2000(second, first)).abs() < 1e-12, "pair {} is not symmetric", i + 1);
        }
    }

    #[test]
    fn white_is_100_and_black_is_0() {
        let white = Xyz { x: 95.0, y: 100.0, z: 108.0 };
        assert_eq!(white.to_lab(white), Lab { l: 100.0, a: 0.0, b: 0.0 });
        for lab in [Lab { l: 60.0, a: 30.0, b: -70.0 }, Lab { l: 3.0, a: 1.0, b: 2.0 }] {
            let back = lab.to_xyz(white).to_lab(white);
            assert!(
                [back.l - lab.l, back.a - lab.a, back.b - lab.b].iter().all(|d| d.abs() < 1e-12),
                "{back:?}"
            );
        }
        let black = Xyz::default().to_lab(white);
        assert!(black.l.abs() < 1e-14 && black.a == 0.0 && black.b == 0.0);
    }
}
