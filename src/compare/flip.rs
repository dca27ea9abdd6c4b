//! ꟻLIP, the difference that an observer sees who flips between two pictures: 0 (none) to 1.
//!
//! P. Andersson et al., "ꟻLIP: A Difference Evaluator for Alternating Images", HPG 2020 (equation numbers
//! below), and for high dynamic range P. Andersson et al., "Visualizing Errors in Rendered High Dynamic Range
//! Images", Eurographics Short Papers 2021: the largest ꟻLIP over all exposures at which something can be
//! seen.
//!
//! Colours are blurred as the eye blurs them at the assumed distance, and compared in a CIELAB whose
//! colourfulness follows the luminance; where edges and points differ, the difference is raised.

use rayon::prelude::*;
use std::f64::consts::PI;

/// Linear Rec. 709 values of a pixel.
pub type Rgb = [f64; 3];

/// Pixels per degree of visual angle at which the papers evaluate: a monitor 0.7 m wide with 3840 pixels, 0.7
/// m away.
pub const PIXELS_PER_DEGREE: f64 = 0.7 * 3840.0 / 0.7 * (PI / 180.0);

/// The primaries of sRGB as both papers' authors use them, from linear RGB to XYZ (IEC 61966-2-1, more
/// digits).
const TO_XYZ: [[f64; 3]; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];

/// Exponent of colour differences, and the fraction of the largest one that is spread over most of the range
/// (section 3.2.3).
const COLOUR_EXPONENT: f64 = 0.7;
const COMPRESSED_FROM: f64 = 0.4;
const COMPRESSED_TO: f64 = 0.95;

/// Width of the lines that the eye finds, degrees, and the exponent of feature differences (section 3.3).
const FEATURE_WIDTH: f64 = 0.082;
const FEATURE_EXPONENT: f64 = 0.5;

/// ꟻLIP of each pixel of two pictures of low dynamic range. `test` and `reference` are linear, row by row;
/// values outside 0 to 1 are clipped.
pub fn flip(reference: &[Rgb], test: &[Rgb], width: usize, pixels_per_degree: f64) -> Vec<f64> {
    let sides = [reference, test].map(|side| {
        let opponent =
            Picture::from_pixels(width, side.iter().map(|rgb| opponent(rgb.map(|v| v.clamp(0.0, 1.0)))));
        (opponent.features(pixels_per_degree), opponent.filtered(pixels_per_degree))
    });
    let [(reference_features, reference), (test_features, test)] = sides;
    // The greatest difference within the gamut is that of green and blue.
    let greatest = hyab(hunt([0.0, 1.0, 0.0]), hunt([0.0, 0.0, 1.0])).powf(COLOUR_EXPONENT);
    let knee = COMPRESSED_FROM * greatest;
    let colour = |i: usize| {
        let [a, b] =
            [&reference, &test].map(|picture| hunt(linear(picture.pixel(i)).map(|v| v.clamp(0.0, 1.0))));
        let difference = hyab(a, b).powf(COLOUR_EXPONENT);
        if difference < knee {
            COMPRESSED_TO / knee * difference
        } else {
            COMPRESSED_TO + (difference - knee) / (greatest - knee) * (1.0 - COMPRESSED_TO)
        }
    };
    let feature = |i: usize| {
        let [edge, point] = [0, 1].map(|kind| (reference_features[i][kind] - test_features[i][kind]).abs());
        (edge.max(point) / 2f64.sqrt()).powf(FEATURE_EXPONENT)
    };
    (0..width * reference.height()).into_par_iter().map(|i| colour(i).powf(1.0 - feature(i))).collect()
}

/// Exposures of HDR-ꟻLIP: from the one that just shows the brightest pixel to that which shows the median.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposures {
    /// Binary logarithms of the factors on linear values.
    pub start: f64,
    /// The binary logarithm of the last.
    pub stop: f64,
    /// How many there are, the first and the last included. At least 2.
    pub count: usize,
}

impl Exposures {
    /// Those of a reference (section 3.2 of the paper of 2021). Luminances that are all alike give two equal
    /// exposures.
    pub fn of(reference: &[Rgb]) -> Self {
        let mut luminance: Vec<f64> = reference.iter().map(|&rgb| row(TO_XYZ[1], rgb).max(0.0)).collect();
        luminance.sort_by(f64::total_cmp);
        let brightest = luminance.last().copied().unwrap_or(0.0);
        let middle = luminance.get(luminance.len() / 2).copied().unwrap_or(0.0);
        let [a, b, c, d, e, f] = ACES;
        // The value that is mapped to 0.85: x²(a − 0.85 d) + x(b − 0.85 e) + c − 0.85 f = 0.
        let [p, q, r] = [a - SHOWN * d, b - SHOWN * e, c - SHOWN * f];
        let shown = (-q + (q * q - 4.0 * p * r).sqrt()) / (2.0 * p);
        // A black picture, or one that is mostly black, has no exposure of its own.
        let exposure = |luminance: f64| (shown / luminance.max(f64::from(f32::EPSILON))).log2();
        let (start, stop) = (exposure(brightest), exposure(middle));
        Self { start, stop, count: ((stop - start).ceil() as usize).max(2) }
    }

    fn factors(self) -> impl Iterator<Item = f64> {
        let step = (self.stop - self.start) / (self.count - 1) as f64;
        (0..self.count).map(move |i| (self.start + i as f64 * step).exp2())
    }
}

/// The tone curve `(a x² + b x + c) / (d x² + e x + f)`: Narkowicz's fit of ACES (2015), preceded by a factor
/// of 0.6.
const ACES: [f64; 6] = [0.36 * 2.51, 0.6 * 0.03, 0.0, 0.36 * 2.43, 0.6 * 0.59, 0.14];

/// What the tone curve makes of the luminance that sets an exposure.
const SHOWN: f64 = 0.85;

/// HDR-ꟻLIP of each pixel: the largest over the exposures.
pub fn hdr_flip(
    reference: &[Rgb],
    test: &[Rgb],
    width: usize,
    pixels_per_degree: f64,
    exposures: Exposures,
) -> Vec<f64> {
    let [a, b, c, d, e, f] = ACES;
    let mapped = |picture: &[Rgb], factor: f64| -> Vec<Rgb> {
        let curve = |value: f64| {
            let x = factor * value.max(0.0);
            ((a * x * x + b * x + c) / (d * x * x + e * x + f)).min(1.0)
        };
        picture.iter().map(|rgb| rgb.map(curve)).collect()
    };
    let mut largest = vec![0.0f64; reference.len()];
    for factor in exposures.factors() {
        let seen = flip(&mapped(reference, factor), &mapped(test, factor), width, pixels_per_degree);
        largest.iter_mut().zip(seen).for_each(|(largest, seen)| *largest = largest.max(seen));
    }
    largest
}

fn row(row: [f64; 3], colour: [f64; 3]) -> f64 {
    row[0] * colour[0] + row[1] * colour[1] + row[2] * colour[2]
}

/// XYZ over that of white (1, 1, 1).
fn over_white(rgb: Rgb) -> [f64; 3] {
    TO_XYZ.map(|weights| row(weights, rgb) / weights.iter().sum::<f64>())
}

/// The opponent space YyCxCz, CIELAB without its cube root: achromatic, red–green and blue–yellow.
fn opponent(rgb: Rgb) -> [f64; 3] {
    let [x, y, z] = over_white(rgb);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// The inverse of [`opponent`].
fn linear([y, x, z]: [f64; 3]) -> Rgb {
    let y = (y + 16.0) / 116.0;
    let xyz = [y + x / 500.0, y, y - z / 200.0];
    let white = TO_XYZ.map(|weights| weights.iter().sum::<f64>());
    FROM_XYZ.map(|weights| row(weights, [xyz[0] * white[0], xyz[1] * white[1], xyz[2] * white[2]]))
}

/// The inverse of [`TO_XYZ`].
const FROM_XYZ: [[f64; 3]; 3] = crate::spectrum::colour::inverse(&TO_XYZ);

/// CIELAB whose a and b grow with the lightness, after Hunt.
fn hunt(rgb: Rgb) -> [f64; 3] {
    const DELTA: f64 = 6.0 / 29.0;
    let root = |t: f64| {
        if t > DELTA * DELTA * DELTA { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    };
    let [x, y, z] = over_white(rgb).map(root);
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

/// The distance HyAB: city block between lightnesses, Euclidean between the rest.
fn hyab(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

/// Weight and width of the Gaussians of the contrast sensitivity of an opponent channel (table 1):
/// `a √(π/b) exp(−π² x²/b)`.
const SENSITIVITY: [&[(f64, f64)]; 3] = [&[(1.0, 0.0047)], &[(1.0, 0.0053)], &[(34.1, 0.04), (13.5, 0.025)]];

/// Three planes in the opponent space.
struct Picture {
    width: usize,
    planes: [Vec<f64>; 3],
}

impl Picture {
    fn from_pixels(width: usize, pixels: impl Iterator<Item = [f64; 3]>) -> Self {
        let mut planes = [const { Vec::new() }; 3];
        for pixel in pixels {
            planes.iter_mut().zip(pixel).for_each(|(plane, value)| plane.push(value));
        }
        Self { width, planes }
    }

    fn height(&self) -> usize {
        self.planes[0].len() / self.width
    }

    fn pixel(&self, i: usize) -> [f64; 3] {
        [self.planes[0][i], self.planes[1][i], self.planes[2][i]]
    }

    /// What the eye's contrast sensitivity leaves (section 3.2.1).
    fn filtered(&self, pixels_per_degree: f64) -> Self {
        // Three standard deviations of the widest Gaussian, for all channels.
        let radius = (3.0 * (0.04f64 / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i64;
        let planes = std::array::from_fn(|channel| {
            let gaussians = SENSITIVITY[channel].iter().map(|&(weight, width)| {
                let kernel: Vec<f64> = (-radius..=radius)
                    .map(|i| (-(PI * i as f64 / pixels_per_degree).powi(2) / width).exp())
                    .collect();
                let sum: f64 = kernel.iter().sum();
                // Weight of the whole Gaussian in two dimensions.
                let whole = weight * (PI / width).sqrt() * sum * sum;
                (whole, kernel.into_iter().map(|value| value / sum).collect::<Vec<f64>>())
            });
            let total: f64 = gaussians.clone().map(|(whole, _)| whole).sum();
            let mut plane = vec![0.0; self.planes[channel].len()];
            for (whole, kernel) in gaussians {
                let blurred = self.convolved(channel, &kernel, &kernel);
                plane.iter_mut().zip(blurred).for_each(|(sum, value)| *sum += whole / total * value);
            }
            plane
        });
        Self { width: self.width, planes }
    }

    /// Lengths of the gradient and of the second derivatives of the achromatic channel at the scale of lines
    /// that the eye finds: edges and points (section 3.3).
    fn features(&self, pixels_per_degree: f64) -> Vec<[f64; 2]> {
        let deviation = 0.5 * FEATURE_WIDTH * pixels_per_degree;
        let radius = (3.0 * deviation).ceil() as i64;
        let offsets = || (-radius..=radius).map(|i| i as f64);
        let gaussian: Vec<f64> = offsets().map(|x| (-0.5 * (x / deviation).powi(2)).exp()).collect();
        let sum: f64 = gaussian.iter().sum();
        let smooth: Vec<f64> = gaussian.iter().map(|value| value / sum).collect();
        // Positive weights sum to 1 and negative ones to −1, so that the filters answer to contrast, not to
        // scale.
        let balanced = |weight: &dyn Fn(f64) -> f64| -> Vec<f64> {
            let raw: Vec<f64> = offsets().zip(&gaussian).map(|(x, g)| weight(x) * g).collect();
            let positive: f64 = raw.iter().filter(|&&v| v > 0.0).sum();
            let negative: f64 = -raw.iter().filter(|&&v| v < 0.0).sum::<f64>();
            raw.iter().map(|&v| if v > 0.0 { v / positive } else { v / negative }).collect()
        };
        let first = balanced(&|x| -x);
        let second = balanced(&|x| (x / deviation).powi(2) - 1.0);
        let lengths = |kernel: &[f64]| -> Vec<f64> {
            let across = self.convolved(0, kernel, &smooth);
            let down = self.convolved(0, &smooth, kernel);
            // The channel's values reach from −16 to 100.
            across.into_iter().zip(down).map(|(x, y)| x.hypot(y) / 116.0).collect()
        };
        lengths(&first).into_iter().zip(lengths(&second)).map(|(edge, point)| [edge, point]).collect()
    }

    /// A plane convolved with a kernel along its rows and another along its columns; beyond the border the
    /// outermost pixels go on.
    fn convolved(&self, channel: usize, along: &[f64], across: &[f64]) -> Vec<f64> {
        let (width, height, plane) = (self.width, self.height(), &self.planes[channel]);
        let pass = |source: &[f64], kernel: &[f64], length: usize, stride: usize, i: usize| -> f64 {
            let position = i / stride % length;
            let base = i - position * stride;
            let radius = kernel.len() / 2;
            let at = |k: usize| source[base + (position + k).saturating_sub(radius).min(length - 1) * stride];
            kernel.iter().enumerate().map(|(k, weight)| weight * at(k)).sum()
        };
        let rows: Vec<f64> =
            (0..plane.len()).into_par_iter().map(|i| pass(plane, along, width, 1, i)).collect();
        (0..plane.len()).into_par_iter().map(|i| pass(&rows, across, height, width, i)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 48;

    /// A smooth picture, and it with a weave and a red square, both times a glow.
    fn pictures(bright: f64) -> [Vec<Rgb>; 2] {
        let pixels = (0..40).flat_map(|y| (0..WIDTH).map(move |x| (x as f64, f64::from(y))));
        let reference = |(x, y): (f64, f64)| {
            [0.31 * x + 0.17 * y, 0.23 * x - 0.29 * y + 1.0, 0.11 * x * y / 9.0 + 2.0]
                .map(|a| 0.5 + 0.45 * a.sin())
        };
        let test = |(x, y): (f64, f64)| {
            if (12.0..20.0).contains(&y) && (30.0..38.0).contains(&x) {
                return [0.9, 0.1, 0.1];
            }
            let (rgb, weave) = (reference((x, y)), 0.08 * (1.3 * x + 0.7 * y).sin());
            [rgb[0] + weave, rgb[1] - 0.5 * weave, rgb[2] + 0.7 * weave].map(|v| v.clamp(0.0, 1.0))
        };
        let glow = |(x, y): (f64, f64)| {
            1.0 + (bright - 1.0) * (-((x - 20.0).powi(2) + (y - 15.0).powi(2)) / 30.0).exp()
        };
        [
            pixels.clone().map(|at| reference(at).map(|v| v * glow(at))).collect(),
            pixels.map(|at| test(at).map(|v| v * glow(at))).collect(),
        ]
    }

    /// Mean and four pixels by the authors' own program, PyPI `flip-evaluator` 1.7, which works in single
    /// precision (`validation/flip/make_reference.py`).
    #[test]
    fn agrees_with_the_authors_program() {
        let places = [0, 15 * WIDTH + 33, 15 * WIDTH + 20, 39 * WIDTH + 47];
        let check = |map: Vec<f64>, mean: f64, pixels: [f64; 4]| {
            let found = map.iter().sum::<f64>() / map.len() as f64;
            assert!((found - mean).abs() < 2e-5, "mean {found}, expected {mean}");
            for (place, expected) in places.into_iter().zip(pixels) {
                assert!((map[place] - expected).abs() < 2e-4, "{place}: {}, expected {expected}", map[place]);
            }
        };
        let [a, b] = pictures(1.0);
        check(
            flip(&a, &b, WIDTH, PIXELS_PER_DEGREE),
            0.118_550_055,
            [0.129_915_5, 0.735_674_2, 0.094_673_3, 0.063_124_0],
        );
        check(flip(&a, &b, WIDTH, 20.0), 0.223_804_146, [0.074_475_3, 0.952_238_3, 0.261_290_2, 0.131_931_3]);
        let [a, b] = pictures(40.0);
        let exposures = Exposures::of(&a);
        assert_eq!(exposures.count, 6);
        assert!(
            (exposures.start + 3.998_047_352).abs() < 1e-4 && (exposures.stop - 1.777_691_245).abs() < 1e-4,
            "{exposures:?}"
        );
        check(
            hdr_flip(&a, &b, WIDTH, PIXELS_PER_DEGREE, exposures),
            0.153_256_759,
            [0.083_838_3, 0.702_793_4, 0.091_509_6, 0.116_420_3],
        );
        check(
            hdr_flip(&a, &b, WIDTH, 20.0, exposures),
            0.297_842_115,
            [0.039_705_1, 0.882_865_1, 0.200_900_4, 0.142_118_4],
        );
    }

    #[test]
    fn equal_pictures_do_not_flip_and_green_to_blue_flips_most() {
        let [a, _] = pictures(40.0);
        assert!(hdr_flip(&a, &a, WIDTH, PIXELS_PER_DEGREE, Exposures::of(&a)).iter().all(|&v| v == 0.0));
        let whole = |rgb: Rgb| vec![rgb; 100];
        let largest = flip(&whole([0.0, 1.0, 0.0]), &whole([0.0, 0.0, 1.0]), 10, 67.0);
        assert!(largest.iter().all(|v| (v - 1.0).abs() < 1e-12), "{largest:?}");
        // Black pictures have no exposure of their own, and no difference.
        let black = whole([0.0; 3]);
        assert!(hdr_flip(&black, &black, 10, 67.0, Exposures::of(&black)).iter().all(|&v| v == 0.0));
    }
}
