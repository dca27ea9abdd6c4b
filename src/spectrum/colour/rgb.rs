//! Display values: linear RGB with the primaries of ITU-R BT.709 (those of sRGB), and the sRGB transfer
//! function.

use super::Xyz;

/// What linear red, green and blue stand for: chromaticities (x, y).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RgbSpace {
    /// Red, green and blue.
    pub primaries: [(f64, f64); 3],
    /// Equal parts of all three.
    pub white: (f64, f64),
}

impl RgbSpace {
    /// ITU-R BT.709-6, table 1, with D65; that of sRGB too (IEC 61966-2-1).
    pub const REC709: Self =
        Self { primaries: [(0.64, 0.33), (0.30, 0.60), (0.15, 0.06)], white: (0.3127, 0.3290) };

    /// To XYZ with Y = 1 for white: the columns are the primaries, scaled so that they add up to white.
    const fn to_xyz(self) -> Matrix {
        let mut primaries = [[0.0; 3]; 3];
        let mut i = 0;
        while i < 3 {
            let (x, y) = self.primaries[i];
            primaries[0][i] = x / y;
            primaries[1][i] = 1.0;
            primaries[2][i] = (1.0 - x - y) / y;
            i += 1;
        }
        let (x, y) = self.white;
        let scale = product(&inverse(&primaries), [x / y, 1.0, (1.0 - x - y) / y]);
        let mut row = 0;
        while row < 3 {
            let mut i = 0;
            while i < 3 {
                primaries[row][i] *= scale[i];
                i += 1;
            }
            row += 1;
        }
        primaries
    }

    /// From its values to those of BT.709 for the same XYZ: white is not adapted. `None` where the primaries
    /// span no colours.
    pub fn to_rec709(self) -> Option<impl Fn([f64; 3]) -> [f64; 3]> {
        let to_xyz = self.to_xyz();
        let is_finite = to_xyz.iter().flatten().all(|value| value.is_finite());
        is_finite.then_some(move |rgb| product(&XYZ_TO_REC709, product(&to_xyz, rgb)))
    }
}

type Matrix = [[f64; 3]; 3];

const TO_XYZ: Matrix = RgbSpace::REC709.to_xyz();

/// From XYZ, with Y = 1 for white, to linear BT.709.
pub const XYZ_TO_REC709: Matrix = inverse(&TO_XYZ);

const fn product(m: &Matrix, v: [f64; 3]) -> [f64; 3] {
    [
        m[0][0] * v[0] + m[0][1] * v[1] + m[0][2] * v[2],
        m[1][0] * v[0] + m[1][1] * v[1] + m[1][2] * v[2],
        m[2][0] * v[0] + m[2][1] * v[1] + m[2][2] * v[2],
    ]
}

/// Inverse by cofactors.
pub(crate) const fn inverse(m: &Matrix) -> Matrix {
    let mut cofactors = [[0.0; 3]; 3];
    let mut row = 0;
    while row < 3 {
        let (a, b) = ((row + 1) % 3, (row + 2) % 3);
        let mut column = 0;
        while column < 3 {
            let (c, d) = ((column + 1) % 3, (column + 2) % 3);
            cofactors[column][row] = m[a][c] * m[b][d] - m[a][d] * m[b][c];
            column += 1;
        }
        row += 1;
    }
    let determinant = m[0][0] * cofactors[0][0] + m[0][1] * cofactors[1][0] + m[0][2] * cofactors[2][0];
    let mut row = 0;
    while row < 3 {
        let mut column = 0;
        while column < 3 {
            cofactors[row][column] /= determinant;
            column += 1;
        }
        row += 1;
    }
    cofactors
}

/// Linear BT.709 values of a colour; (1, 1, 1) for D65 with Y = 1. Outside [0, 1] for colours out of gamut.
///
/// The matrix follows from primaries and white with full precision; the rounded one of IEC 61966-2-1 and
/// Mitsuba's (which has an older white) differ from it by less than 5e-4.
pub fn xyz_to_rec709(colour: Xyz) -> [f64; 3] {
    product(&XYZ_TO_REC709, colour.into())
}

/// The colour of linear BT.709 values.
pub fn rec709_to_xyz(rgb: [f64; 3]) -> Xyz {
    product(&TO_XYZ, rgb).into()
}

/// The sRGB transfer function: linear to encoded, both 0 to 1 (IEC 61966-2-1). Odd, so that values below 0
/// survive.
pub fn srgb_encode(linear: f64) -> f64 {
    let magnitude = linear.abs();
    let encoded = match magnitude <= 0.003_130_8 {
        true => 12.92 * magnitude,
        false => 1.055 * magnitude.powf(1.0 / 2.4) - 0.055,
    };
    encoded.copysign(linear)
}

/// The inverse of [`srgb_encode`].
pub fn srgb_decode(encoded: f64) -> f64 {
    let magnitude = encoded.abs();
    let linear = match magnitude <= 0.040_45 {
        true => magnitude / 12.92,
        false => ((magnitude + 0.055) / 1.055).powf(2.4),
    };
    linear.copysign(encoded)
}

/// A colour as `#rrggbb`, clipped to the gamut; white is D65 with Y = 1.
pub fn srgb_hex(colour: Xyz) -> String {
    let [r, g, b] =
        xyz_to_rec709(colour).map(|linear| (srgb_encode(linear.clamp(0.0, 1.0)) * 255.0).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The matrix that W3C's CSS Color Module Level 4 states for the same primaries and white, and white to
    /// rounding.
    #[test]
    fn matrix_is_the_standard_one() {
        let standard = [
            [3.240_969_94, -1.537_383_18, -0.498_610_76],
            [-0.969_243_64, 1.875_967_50, 0.041_555_06],
            [0.055_630_08, -0.203_976_96, 1.056_971_51],
        ];
        for (row, expected) in XYZ_TO_REC709.iter().zip(standard) {
            for (found, expected) in row.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-8, "{found} {expected}");
            }
        }
        for value in xyz_to_rec709(Xyz::from_chromaticity(0.3127, 0.3290, 1.0)) {
            assert!((value - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn conversions_have_inverses() {
        for rgb in [[0.2, 0.5, 0.9], [1.0, 0.0, 0.0], [-0.1, 0.3, 2.0]] {
            let back = xyz_to_rec709(rec709_to_xyz(rgb));
            assert!(rgb.iter().zip(back).all(|(a, b)| (a - b).abs() < 1e-14), "{rgb:?} {back:?}");
        }
        for step in -300..=300 {
            let linear = f64::from(step) / 200.0;
            assert!((srgb_decode(srgb_encode(linear)) - linear).abs() < 1e-6);
        }
    }

    #[test]
    fn known_display_values() {
        assert_eq!(srgb_hex(rec709_to_xyz([1.0, 0.0, 0.5])), "#ff00bc");
        assert!((srgb_encode(0.5) - 0.735_356_983_052_449).abs() < 1e-12);
    }
}
