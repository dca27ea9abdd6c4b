//! Reflectances from colours: a smooth spectrum for every triple of sRGB's primaries.
//!
//! After W. Jakob and J. Hanika, "A Low-Dimensional Function Space for Efficient Spectral Upsampling",
//! Computer Graphics Forum 38(2), 2019: the spectrum is a sigmoid of a quadratic in wavelength, whose three
//! coefficients are such that under D65 the CIE 1931 observer sees the colour. They are found by Newton's
//! method on a grid of colours and interpolated in between. The grid is the paper's, which Mitsuba 3 has as a
//! file, so that both programs see the same spectrum; here its nodes are computed when a colour first asks
//! for them.

use super::colour::Observer;
use super::{Spectrum, catalogue};
use crate::lanes::Real;
use crate::units::WavelengthRange;
use std::sync::OnceLock;
use wide::f64x4;

/// A smooth spectrum between 0 and 1: S(a·λ² + b·λ + c) with S(x) = ½ + x / (2·√(1 + x²)) and λ in nm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sigmoid {
    /// a, b and c. An infinite c stands for black or white.
    pub coefficients: [f64; 3],
}

impl Sigmoid {
    /// The value at a wavelength (nm).
    #[inline]
    pub fn at(&self, nm: f64) -> f64 {
        Self::value(self.coefficients, nm)
    }

    /// That of coefficients, of one or of several.
    #[inline(always)]
    pub fn value<R: Real>([a, b, c]: [R; 3], nm: R) -> R {
        sigmoid((a * nm + b) * nm + c)
    }

    /// What Mitsuba 3 takes for the mean over wavelength: that of 16 values from 360 to 830 nm.
    pub fn mean(&self) -> f64 {
        let WavelengthRange { min, max } = WavelengthRange::VISIBLE;
        (0..16).map(|i| self.at(min + (max - min) * f64::from(i) / 15.0)).sum::<f64>() / 16.0
    }

    /// Least and greatest value over a range.
    pub fn bounds(&self, range: WavelengthRange) -> (f64, f64) {
        let [a, b, _] = self.coefficients;
        let (from, to) = (self.at(range.min), self.at(range.max));
        let turn = -b / (2.0 * a);
        let extreme = if turn > range.min && turn < range.max { self.at(turn) } else { from };
        (from.min(to).min(extreme), from.max(to).max(extreme))
    }

    /// Integral over a range, in nm.
    pub fn integral(&self, range: WavelengthRange) -> f64 {
        let cells = range.width().ceil().max(1.0);
        let half = 0.5 * range.width() / cells;
        let cell = |i: usize| {
            let middle = range.min + half * (2 * i + 1) as f64;
            GAUSS.iter().map(|(offset, weight)| weight * self.at(middle + half * offset)).sum::<f64>()
        };
        2.0 * half * (0..cells as usize).map(cell).sum::<f64>()
    }

    /// Whether it is the same at all wavelengths.
    pub fn is_constant(&self) -> bool {
        let [a, b, _] = self.coefficients;
        a == 0.0 && b == 0.0
    }
}

/// Three points of Gauss on [−1, 1] and the fraction of the interval that each stands for.
const GAUSS: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.774_596_669_241_483_4, 5.0 / 18.0)];

#[inline(always)]
fn sigmoid<R: Real>(x: R) -> R {
    // Beyond this the square overflows nothing yet and the value has long been 0 or 1.
    const FAR: f64 = 1e100;
    let (half, one) = (R::of(0.5), R::of(1.0));
    let x = x.greater(R::of(-FAR)).lesser(R::of(FAR));
    half + half * x / (one + x * x).sqrt()
}

/// The reflectance of a colour: linear values for sRGB's primaries; what lies outside [0, 1] is clipped, as
/// Mitsuba 3 does.
pub fn upsample(rgb: [f64; 3]) -> Sigmoid {
    let rgb = rgb.map(|value| value.clamp(0.0, 1.0));
    let [r, g, b] = rgb;
    if r == g && g == b {
        // S is undone in closed form: flat spectra are exactly grey.
        let c = (r - 0.5) / (r * (1.0 - r)).sqrt();
        return Sigmoid { coefficients: [0.0, 0.0, c] };
    }
    Grid::shared().coefficients(rgb)
}

/// Nodes along each side of the grid.
const SIDE: usize = 64;

/// The node of a column from which its others are found one after the other: dark enough that every hue is a
/// smooth spectrum, not so dark that the sigmoid is flat.
const FIRST_NODE: usize = SIDE / 5;

/// Every so many nodes across, a column is solved from one end to the other; its nodes are where others
/// begin.
const COARSE: usize = 9;

type Coefficients = [f64; 3];

/// Nodes over z, each solved when first asked for.
type Column = Box<[OnceLock<Coefficients>; SIDE]>;

/// Coefficients at the nodes. A colour's largest component z chooses one of three cubes; within it, the other
/// two divided by z are the first coordinates, and z itself, on a scale that is finer at both ends, is the
/// third.
///
/// Whoever asks first, a node is found from the same start, so that it always has the same bits.
struct Grid {
    observer: Quadrature,
    /// The place of each node on the scale of z.
    scale: [f64; SIDE],
    /// For each cube and pair of the other coordinates.
    columns: Vec<OnceLock<Column>>,
    /// Whole columns at every [`COARSE`]th pair.
    coarse: Vec<OnceLock<Box<[Coefficients; SIDE]>>>,
}

impl Grid {
    fn shared() -> &'static Self {
        static GRID: OnceLock<Grid> = OnceLock::new();
        GRID.get_or_init(|| {
            let smooth = |x: f64| x * x * (3.0 - 2.0 * x);
            let across = (SIDE - 1) / COARSE + 1;
            Self {
                observer: Quadrature::new(),
                scale: std::array::from_fn(|k| smooth(smooth(k as f64 / (SIDE - 1) as f64))),
                columns: (0..3 * SIDE * SIDE).map(|_| OnceLock::new()).collect(),
                coarse: (0..3 * across * across).map(|_| OnceLock::new()).collect(),
            }
        })
    }

    fn coefficients(&self, rgb: [f64; 3]) -> Sigmoid {
        let largest = if rgb[0] > rgb[1] {
            if rgb[0] > rgb[2] { 0 } else { 2 }
        } else if rgb[1] > rgb[2] {
            1
        } else {
            2
        };
        let z = rgb[largest];
        let along = |component: f64| {
            let place = component / z * (SIDE - 1) as f64;
            let cell = (place as usize).min(SIDE - 2);
            (cell, place - cell as f64)
        };
        let (i, x) = along(rgb[(largest + 1) % 3]);
        let (j, y) = along(rgb[(largest + 2) % 3]);
        let k = self.scale.partition_point(|&node| node <= z).clamp(1, SIDE - 1) - 1;
        let height = (z - self.scale[k]) / (self.scale[k + 1] - self.scale[k]);
        let mut coefficients = [0.0; 3];
        for corner in 0..8 {
            let [di, dj, dk] = [corner & 1, corner >> 1 & 1, corner >> 2];
            let along = |second: usize, place: f64| if second == 0 { 1.0 - place } else { place };
            let weight = along(di, x) * along(dj, y) * along(dk, height);
            if weight != 0.0 {
                let node = self.node(largest, [i + di, j + dj, k + dk]);
                for (sum, coefficient) in coefficients.iter_mut().zip(node) {
                    *sum += weight * coefficient;
                }
            }
        }
        Sigmoid { coefficients: in_nanometres(coefficients) }
    }

    fn node(&self, largest: usize, [i, j, k]: [usize; 3]) -> Coefficients {
        let column = self.columns[(largest * SIDE + j) * SIDE + i]
            .get_or_init(|| Box::new([const { OnceLock::new() }; SIDE]));
        *column[k].get_or_init(|| {
            let [mut near_i, mut near_j] = [i, j].map(|place| (place + COARSE / 2) / COARSE);
            let start = self.coarse(largest, near_i, near_j)[k];
            if [near_i * COARSE, near_j * COARSE] == [i, j] {
                return start;
            }
            // White has no finite coefficients, and from spectra as flat as its column ends in there is no
            // way back to a tint: those near it begin a column further away.
            if [near_i, near_j] == [(SIDE - 1) / COARSE; 2] {
                *if i < j { &mut near_i } else { &mut near_j } -= 1;
            }
            let start = self.coarse(largest, near_i, near_j)[k];
            self.observer.fit(self.colour(largest, [i, j, k]), start)
        })
    }

    fn colour(&self, largest: usize, [i, j, k]: [usize; 3]) -> [f64; 3] {
        let z = self.scale[k];
        let mut rgb = [z; 3];
        rgb[(largest + 1) % 3] = z * i as f64 / (SIDE - 1) as f64;
        rgb[(largest + 2) % 3] = z * j as f64 / (SIDE - 1) as f64;
        rgb
    }

    fn coarse(&self, largest: usize, i: usize, j: usize) -> &[Coefficients; SIDE] {
        let across = (SIDE - 1) / COARSE + 1;
        self.coarse[(largest * across + j) * across + i].get_or_init(|| {
            let fit = |k: usize, start: Coefficients| {
                self.observer.fit(self.colour(largest, [i * COARSE, j * COARSE, k]), start)
            };
            let mut column = Box::new([[0.0; 3]; SIDE]);
            column[FIRST_NODE] = fit(FIRST_NODE, [0.0; 3]);
            for k in FIRST_NODE + 1..SIDE {
                column[k] = fit(k, column[k - 1]);
            }
            for k in (0..FIRST_NODE).rev() {
                column[k] = fit(k, column[k + 1]);
            }
            column
        })
    }
}

/// The coefficients for t ∈ [−1, 1] over the visible range, as coefficients for nanometres.
fn in_nanometres([a, b, c]: Coefficients) -> Coefficients {
    let range = WavelengthRange::VISIBLE;
    let (middle, half) = (0.5 * (range.min + range.max), 0.5 * range.width());
    let (a, b) = (a / (half * half), b / half);
    [a, b - 2.0 * a * middle, c + (a * middle - b) * middle]
}

/// A reflectance's colour as a weighted sum of its values.
struct Quadrature {
    /// Wavelengths, from −1 to 1 over the visible range.
    t: Vec<f64x4>,
    /// The weight of each value in red, green and blue.
    weights: [Vec<f64x4>; 3],
}

/// From XYZ to the primaries of Rec. 709, with the white (0.950456, 1, 1.088754) that Mitsuba 3 has for D65:
/// the matrix in C. Poynton, "Frequently Asked Questions about Color".
const XYZ_TO_RGB: [[f64; 3]; 3] = [
    [3.240_479, -1.537_150, -0.498_535],
    [-0.969_256, 1.875_991, 0.041_556],
    [0.055_648, -0.204_043, 1.057_311],
];

impl Quadrature {
    fn new() -> Self {
        let observer = Observer::cie1931_5nm();
        let daylight = catalogue::illuminant("D65").unwrap_or(Spectrum::ONE);
        let range = WavelengthRange::VISIBLE;
        let cells = (range.width() / 5.0) as usize;
        // Between the nodes of both tables, 5 nm apart.
        let points = (0..cells).flat_map(|cell| {
            let middle = range.min + 5.0 * cell as f64 + 2.5;
            GAUSS.iter().map(move |(offset, weight)| (middle + 2.5 * offset, 5.0 * weight))
        });
        let (mut t, mut weights) = (Vec::new(), [Vec::new(), Vec::new(), Vec::new()]);
        let mut white = 0.0;
        for (nm, width) in points {
            let light = daylight.at(nm) * width;
            let xyz = observer.at(nm).map(|matching| matching * light);
            white += xyz[1];
            t.push((nm - range.min) / range.width() * 2.0 - 1.0);
            for (weights, row) in weights.iter_mut().zip(&XYZ_TO_RGB) {
                weights.push(row[0] * xyz[0] + row[1] * xyz[1] + row[2] * xyz[2]);
            }
        }
        // The last group is filled up with points that do not count.
        let grouped = |values: &[f64]| {
            let group =
                |values: &[f64]| f64x4::from(std::array::from_fn(|i| values.get(i).copied().unwrap_or(0.0)));
            values.chunks(4).map(group).collect::<Vec<_>>()
        };
        let weights =
            weights.map(|weights| grouped(&weights.iter().map(|weight| weight / white).collect::<Vec<_>>()));
        Self { t: grouped(&t), weights }
    }

    /// Coefficients whose spectrum has a colour, by Newton's method from a start near by. Where no spectrum
    /// of the family has it (black, white), the nearest that the method comes to.
    fn fit(&self, rgb: [f64; 3], start: Coefficients) -> Coefficients {
        const MOST_STEPS: usize = 30;
        const TOLERANCE: f64 = 1e-9;
        let mut best = start;
        let (mut residual, mut jacobian) = self.residual(rgb, best);
        let mut error = norm(residual);
        for _ in 0..MOST_STEPS {
            if error < TOLERANCE {
                break;
            }
            let Some(step) = solve(&jacobian, residual) else { break };
            // The whole step, or as much of it as makes things better.
            let mut fraction = 1.0;
            let improved = loop {
                let next = bounded([0, 1, 2].map(|i| best[i] - fraction * step[i]));
                let (next_residual, next_jacobian) = self.residual(rgb, next);
                let next_error = norm(next_residual);
                if next_error < error {
                    (best, residual, jacobian, error) = (next, next_residual, next_jacobian, next_error);
                    break true;
                }
                fraction *= 0.5;
                if fraction < 1e-3 {
                    break false;
                }
            };
            if !improved {
                break;
            }
        }
        best
    }

    /// By how much the colour of some coefficients misses the one that is wanted, and the derivatives of
    /// that.
    fn residual(&self, rgb: [f64; 3], coefficients: Coefficients) -> ([f64; 3], [[f64; 3]; 3]) {
        let [a, b, c] = coefficients.map(f64x4::splat);
        let (one, half) = (f64x4::splat(1.0), f64x4::splat(0.5));
        let mut colour = [f64x4::splat(0.0); 3];
        let mut jacobian = [[f64x4::splat(0.0); 3]; 3];
        let [red, green, blue] = &self.weights;
        for (((&t, &r), &g), &b_weight) in self.t.iter().zip(red).zip(green).zip(blue) {
            let x = (a * t + b) * t + c;
            let inverse = one / (one + x * x).sqrt();
            let value = half + half * x * inverse;
            let slope = half * inverse * inverse * inverse;
            for (channel, weight) in [r, g, b_weight].into_iter().enumerate() {
                colour[channel] += weight * value;
                let change = weight * slope;
                jacobian[channel][2] += change;
                jacobian[channel][1] += change * t;
                jacobian[channel][0] += change * t * t;
            }
        }
        let residual = [0, 1, 2].map(|i| colour[i].reduce_add() - rgb[i]);
        (residual, jacobian.map(|row| row.map(|sum| sum.reduce_add())))
    }
}

/// As Jakob and Hanika do, none of the coefficients is let above 200 (a spectrum within 10⁻⁵ of 1): towards
/// white they grow without end, and what is interpolated between such a node and the next would be white as
/// well.
fn bounded(coefficients: Coefficients) -> Coefficients {
    const MOST: f64 = 200.0;
    let largest = coefficients.into_iter().fold(MOST, f64::max);
    coefficients.map(|value| value * (MOST / largest))
}

fn norm([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt()
}

/// Cramer's rule.
fn solve(m: &[[f64; 3]; 3], v: [f64; 3]) -> Option<[f64; 3]> {
    let columns = [0, 1, 2].map(|i| glam::DVec3::new(m[0][i], m[1][i], m[2][i]));
    let v = glam::DVec3::from_array(v);
    let [a, b, c] = columns;
    let determinant = a.dot(b.cross(c));
    let solution = glam::DVec3::new(v.dot(b.cross(c)), a.dot(v.cross(c)), a.dot(b.cross(v))) / determinant;
    solution.is_finite().then(|| solution.to_array())
}

#[cfg(test)]
mod tests {
    use super::super::colour::srgb_decode;
    use super::*;

    fn observed(sigmoid: Sigmoid) -> [f64; 3] {
        let quadrature = &Grid::shared().observer;
        let range = WavelengthRange::VISIBLE;
        let nm = |t: f64| range.min + 0.5 * (t + 1.0) * range.width();
        [0, 1, 2].map(|channel| {
            let weights = quadrature.t.iter().zip(&quadrature.weights[channel]);
            let lanes = weights.flat_map(|(t, weight)| t.to_array().into_iter().zip(weight.to_array()));
            lanes.map(|(t, weight)| weight * sigmoid.at(nm(t))).sum()
        })
    }

    /// `srgb_model_fetch` of Mitsuba 3.9.1 (scalar_spectral): coefficients of its table, in single precision.
    #[test]
    fn coefficients_are_mitsubas() {
        let seen = [
            ([0.2, 0.3, 0.4], [-3.98299e-06, 0.0016502, -0.159272]),
            ([0.1, 0.2, 0.3], [-1.14464e-05, 0.00820301, -1.83264]),
            ([1.0, 0.0, 0.0], [0.000666365, -0.660716, 157.618]),
            ([0.1, 1.0, 0.3], [-0.000399089, 0.423434, -110.482]),
            ([0.5, 1.0, 1.0], [-9.93215e-05, 0.0741465, -7.7795]),
            ([0.01, 0.02, 0.03], [-3.40564438e-05, 2.68731937e-02, -8.01426888]),
            ([0.8, 0.79, 0.78], [1.47694038e-07, 2.05346587e-04, 5.58596790e-01]),
            ([1.0, 0.9375, 1.0], [8.20361252e-04, -8.90693307e-01, 2.43285995e+02]),
            ([0.9375, 1.0, 0.9375], [-2.94264202e-04, 3.17954630e-01, -8.08608932e+01]),
            ([1.0, 0.96, 0.97], [2.23141367e-04, -2.26572424e-01, 5.96695976e+01]),
        ];
        for (rgb, coefficients) in seen {
            let (ours, theirs) = (upsample(rgb), Sigmoid { coefficients });
            let differences =
                (0..=470).map(|i| f64::from(i) + 360.0).map(|nm| (ours.at(nm) - theirs.at(nm)).abs());
            let worst = differences.fold(0.0, f64::max);
            // Its entries meet their colours to about 1e-6, which leaves that much room to pure red.
            assert!(worst < 2e-4, "{rgb:?}: {:?}, differs by {worst:e}", ours.coefficients);
        }
    }

    #[test]
    fn colours_at_the_nodes_are_met() {
        let grid = Grid::shared();
        for (largest, i, j, k) in
            [(0, 0, 0, 63), (1, 63, 0, 40), (2, 10, 50, 20), (0, 30, 62, 55), (1, 1, 1, 10)]
        {
            let z = grid.scale[k];
            let mut rgb = [z; 3];
            rgb[(largest + 1) % 3] = z * i as f64 / 63.0;
            rgb[(largest + 2) % 3] = z * j as f64 / 63.0;
            let found = observed(upsample(rgb));
            assert!(rgb.iter().zip(found).all(|(a, b)| (a - b).abs() < 1e-8), "{rgb:?} {found:?}");
        }
    }

    /// Display values near white, where coefficients grow without end: the tints of paper and of clouds.
    #[test]
    fn bright_tints_keep_their_colour() {
        let levels = [230, 240, 245, 250, 253, 254, 255].map(|level| srgb_decode(f64::from(level) / 255.0));
        for (r, g, b) in
            levels.iter().flat_map(|r| levels.iter().flat_map(move |g| levels.map(|b| (*r, *g, b))))
        {
            let found = observed(upsample([r, g, b]));
            let error = [r, g, b].iter().zip(found).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            // Interpolation leaves 0.0153 (Mitsuba's table 0.0146); white in place of these tints would be
            // 0.04 and more.
            assert!(error < 0.02, "{r} {g} {b}: {found:?}");
        }
    }

    #[test]
    fn greys_are_flat_and_values_outside_are_clipped() {
        for grey in [0.0, 1e-9, 0.25, 0.5, 1.0 - 1e-12, 1.0] {
            let sigmoid = upsample([grey; 3]);
            assert!(sigmoid.is_constant());
            for nm in [360.0, 555.0, 830.0] {
                assert!((sigmoid.at(nm) - grey).abs() < 1e-15, "{grey}: {}", sigmoid.at(nm));
            }
        }
        assert_eq!(upsample([1.5, -0.2, 0.3]), upsample([1.0, 0.0, 0.3]));
    }

    #[test]
    fn every_colour_has_a_spectrum() {
        for step in 0..2000 {
            let digit = |power: i32| f64::from(step / 13i32.pow(power as u32) % 13) / 12.0;
            let rgb = [digit(0), digit(1), digit(2)].map(|x| x * x * x);
            let sigmoid = upsample(rgb);
            let (least, greatest) = sigmoid.bounds(WavelengthRange::VISIBLE);
            assert!(0.0 <= least && least <= greatest && greatest <= 1.0, "{rgb:?} {sigmoid:?}");
            let found = observed(sigmoid);
            let error = rgb.iter().zip(found).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            // What interpolation between the nodes leaves.
            assert!(error < 3e-3, "{rgb:?} {found:?}");
        }
    }
}
