//! The published coefficients of the model, for given turbidity, ground and sun.

use super::WAVELENGTHS;
use crate::spectrum::data;
use std::f64::consts::FRAC_PI_2;

/// Radiance over the dome at one wavelength.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Dome {
    pub radiance: f64,
    pub c: [f64; 9],
}

/// Columns of the sky's table: radiance and coefficients.
const SKY_COLUMNS: usize = 10;
/// Control points over the sun's elevation.
const CONTROLS: usize = 6;
/// Pieces of the sun's radiance over elevation.
const SEGMENTS: usize = 45;
/// Elevations at which the sun's irradiance is given: from 2° in steps of 3°.
const ELEVATIONS: usize = 30;

const SKY: &str = "sky/hosek_wilkie_sky";
const SUN: &str = "sky/hosek_wilkie_sun";
const LIMB: &str = "sky/hosek_wilkie_limb_darkening";
const IRRADIANCE: &str = "sky/mitsuba_sun_irradiance";

/// All numbers of a table, row by row.
fn numbers(name: &str) -> Vec<f64> {
    let rows = data::text(name).lines().filter(|line| !line.starts_with('#')).skip(1);
    rows.flat_map(|row| row.split(',').filter_map(|cell| cell.parse().ok())).collect()
}

/// The tables of the turbidities around one, and the fraction of the second.
fn around(turbidity: f64) -> [(usize, f64); 2] {
    let below = ((turbidity - 1.0) as usize).min(8);
    let fraction = turbidity - 1.0 - below as f64;
    [(below, 1.0 - fraction), (below + 1, fraction)]
}

/// The distribution over the dome at each wavelength: linear in turbidity and albedo, and in the cube root of
/// the sun's elevation a Bézier curve of degree 5.
pub(super) fn dome(turbidity: f64, albedo: &[f64; WAVELENGTHS], elevation: f64) -> [Dome; WAVELENGTHS] {
    let table = numbers(SKY);
    let x = (elevation / FRAC_PI_2).cbrt();
    let bernstein = |k: usize| {
        const BINOMIAL: [f64; CONTROLS] = [1.0, 5.0, 10.0, 10.0, 5.0, 1.0];
        BINOMIAL[k] * x.powi(k as i32) * (1.0 - x).powi((CONTROLS - 1 - k) as i32)
    };
    std::array::from_fn(|wavelength| {
        let mut sum = [0.0; SKY_COLUMNS];
        for (turbidity, fraction) in around(turbidity) {
            for (ground, reflected) in [1.0 - albedo[wavelength], albedo[wavelength]].into_iter().enumerate()
            {
                for control in 0..CONTROLS {
                    let weight = fraction * reflected * bernstein(control);
                    let row = ((turbidity * 2 + ground) * CONTROLS + control) * WAVELENGTHS + wavelength;
                    let cells = &table[row * SKY_COLUMNS..(row + 1) * SKY_COLUMNS];
                    sum.iter_mut().zip(cells).for_each(|(sum, cell)| *sum += weight * cell);
                }
            }
        }
        Dome { radiance: sum[0], c: std::array::from_fn(|k| sum[k + 1]) }
    })
}

/// Irradiance of the whole sun across its light, W·m⁻²·nm⁻¹. Held below 2° and above 89° of elevation, as in
/// Mitsuba 3.
pub(super) fn sun_irradiance(turbidity: f64, elevation: f64) -> [f64; WAVELENGTHS] {
    let table = numbers(IRRADIANCE);
    let x = ((elevation.to_degrees() - 2.0) / 3.0).clamp(0.0, (ELEVATIONS - 1) as f64);
    let below = (x as usize).min(ELEVATIONS - 2);
    let fraction = x - below as f64;
    std::array::from_fn(|wavelength| {
        let at =
            |turbidity: usize, row: usize| table[(turbidity * ELEVATIONS + row) * WAVELENGTHS + wavelength];
        let between =
            |turbidity| at(turbidity, below) * (1.0 - fraction) + at(turbidity, below + 1) * fraction;
        around(turbidity).into_iter().map(|(turbidity, fraction)| fraction * between(turbidity)).sum()
    })
}

/// Radiance over the sun's disc.
#[derive(Clone, Debug)]
pub(super) struct Disc {
    /// Cubics in elevation for each segment and wavelength.
    pieces: Vec<[f64; 4]>,
    /// Polynomials in the cosine at the sun's surface.
    limb: [[f64; 6]; WAVELENGTHS],
}

impl Disc {
    pub fn new(turbidity: f64) -> Self {
        let table = numbers(SUN);
        let limb = numbers(LIMB);
        let size = SEGMENTS * WAVELENGTHS;
        let piece = |piece: usize| {
            std::array::from_fn(|k| {
                let at = |turbidity: usize| table[(turbidity * size + piece) * 4 + k];
                around(turbidity).into_iter().map(|(turbidity, fraction)| fraction * at(turbidity)).sum()
            })
        };
        Self {
            pieces: (0..size).map(piece).collect(),
            limb: std::array::from_fn(|wavelength| std::array::from_fn(|k| limb[wavelength * 7 + 1 + k])),
        }
    }

    /// Radiance without limb darkening, at an elevation in radians.
    pub fn radiance(&self, wavelength: usize, elevation: f64) -> f64 {
        let segment = (((elevation / FRAC_PI_2).cbrt() * SEGMENTS as f64) as usize).min(SEGMENTS - 1);
        let x = elevation - FRAC_PI_2 * (segment as f64 / SEGMENTS as f64).powi(3);
        let [a, b, c, d] = self.pieces[segment * WAVELENGTHS + wavelength];
        a + x * (b + x * (c + x * d))
    }

    /// The fraction of the radiance that leaves the sun at an angle of this cosine.
    pub fn limb(&self, wavelength: usize, cos: f64) -> f64 {
        self.limb[wavelength].iter().rev().fold(0.0, |sum, c| sum * cos + c)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_whole() {
        assert_eq!(numbers(SKY).len(), 10 * 2 * CONTROLS * WAVELENGTHS * SKY_COLUMNS);
        assert_eq!(numbers(SUN).len(), 10 * SEGMENTS * WAVELENGTHS * 4);
        assert_eq!(numbers(LIMB).len(), WAVELENGTHS * 7);
        assert_eq!(numbers(IRRADIANCE).len(), 10 * ELEVATIONS * WAVELENGTHS);
    }
}
