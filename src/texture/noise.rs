//! Noise: smooth functions of space that look random and are the same each time.
//!
//! Perlin's improved gradient noise (Perlin, "Improving Noise", SIGGRAPH 2002): each corner of a lattice of
//! unit cubes has one of twelve directions g, toward the middles of a cube's edges, and the noise is the
//! blend of g·(p − corner) over the eight corners of a point's cube by quintics. It is zero at all corners,
//! has continuous second derivatives, mean 0, and its features are about one unit in size.
//!
//! The directions come from a hash of the corner instead of a table of 256 numbers, so that nothing repeats.

use crate::geometry::Vec3;
use crate::sampling::mix;

/// A number and its derivatives by the coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Field {
    pub value: f64,
    pub slope: Vec3,
}

impl Field {
    pub const ZERO: Self = Self { value: 0.0, slope: Vec3::ZERO };
}

/// Noise on ever smaller scales, each half as large as the one before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Octaves {
    /// From 1 to [`Octaves::MOST`].
    pub count: u32,
    /// The strength of each scale over that of the one before, from 0 to 1.
    pub gain: f64,
    /// Each has its own noise.
    pub seed: u64,
}

/// No |noise| is above it: with directions as they fit best, the largest value is 1.036354, near (0.3553,
/// 0.4815, 0.5) of the cube.
const BOUND: f64 = 1.0366;

/// Where the lattice of the next scale has its origin, so that their zeros do not meet.
const SHIFT: Vec3 = Vec3::new(0.367_879, 0.618_034, 0.207_107);

impl Octaves {
    /// The last one is a millionth of the first in size, below which there is nothing to see.
    pub const MOST: u32 = 20;

    /// Fractional Brownian motion: the sum of noise over the scales, from −1 to 1. Mean 0.
    pub fn fractal(&self, p: Vec3) -> Field {
        self.sum(p, |noise| noise)
    }

    /// The sum of |noise| over the scales (Perlin, "An Image Synthesizer", SIGGRAPH 1985), from 0 to 1. Its
    /// slope jumps where the noise is zero.
    pub fn turbulence(&self, p: Vec3) -> Field {
        self.sum(p, |noise| {
            if noise.value < 0.0 { Field { value: -noise.value, slope: -noise.slope } } else { noise }
        })
    }

    fn sum(&self, p: Vec3, of: impl Fn(Field) -> Field) -> Field {
        let (mut sum, mut most) = (Field::ZERO, 0.0);
        let (mut place, mut frequency, mut amplitude) = (p, 1.0, 1.0);
        for octave in 0..self.count {
            let noise = of(noise(place, mix(self.seed ^ u64::from(octave) << 48)));
            sum.value += amplitude * noise.value;
            sum.slope += noise.slope * (amplitude * frequency);
            most += amplitude * BOUND;
            place = place * 2.0 + SHIFT;
            frequency *= 2.0;
            amplitude *= self.gain;
        }
        Field { value: sum.value / most, slope: sum.slope / most }
    }
}

/// Gradient noise, within ±[`BOUND`]. Zero too far away for a place within a cube, and for what is no number.
fn noise(p: Vec3, seed: u64) -> Field {
    const FARTHEST: f64 = (1u64 << 52) as f64;
    if !p.is_finite() || p.abs().max_element() >= FARTHEST {
        return Field::ZERO;
    }
    let floor = p.floor();
    let within = p - floor;
    let corner = floor.to_array().map(|x| x as i64);
    // For each axis the weights of the lower and the upper corner, and the derivative of the latter.
    let upper = within.map(|x| x * x * x * (x * (x * 6.0 - 15.0) + 10.0));
    let steep = within.map(|x| 30.0 * x * x * (x - 1.0) * (x - 1.0));
    let weights = [Vec3::ONE - upper, upper];
    let slopes = [-steep, steep];
    let hashed_x = [0, 1].map(|i| mix(seed ^ (corner[0] + i) as u64));
    let mut sum = Field::ZERO;
    for index in 0..8usize {
        let [i, j, k] = [index & 1, index >> 1 & 1, index >> 2];
        let hashed_xy = mix(hashed_x[i] ^ (corner[1] + j as i64) as u64);
        let direction = direction(mix(hashed_xy ^ (corner[2] + k as i64) as u64));
        let height = direction.dot(within - Vec3::new(i as f64, j as f64, k as f64));
        let (x, y, z) = (weights[i].x, weights[j].y, weights[k].z);
        let weight = x * y * z;
        sum.value += weight * height;
        sum.slope += direction * weight;
        sum.slope += Vec3::new(slopes[i].x * y * z, x * slopes[j].y * z, x * y * slopes[k].z) * height;
    }
    sum
}

/// One of (±1, ±1, 0), (±1, 0, ±1) and (0, ±1, ±1), all equally likely.
fn direction(hash: u64) -> Vec3 {
    let sign = |bit: u32| if hash >> bit & 1 == 0 { 1.0 } else { -1.0 };
    let (a, b) = (sign(0), sign(1));
    match ((hash >> 32) * 3) >> 32 {
        0 => Vec3::new(0.0, a, b),
        1 => Vec3::new(a, 0.0, b),
        _ => Vec3::new(a, b, 0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::Moments;

    /// Places far enough from one another that their noise has nothing in common.
    fn places(count: u64) -> impl Iterator<Item = Vec3> {
        let number = |i: u64| (mix(i) >> 11) as f64 / (1u64 << 53) as f64;
        (0..count).map(move |i| Vec3::new(number(3 * i), number(3 * i + 1), number(3 * i + 2)) * 1e5 - 5e4)
    }

    /// The sum of the definition with the blend written out anew, corner by corner.
    #[test]
    fn it_is_perlins_sum_over_the_corners() {
        let blend = |x: f64| if x < 1.0 { 1.0 - x.powi(3) * (6.0 * x * x - 15.0 * x + 10.0) } else { 0.0 };
        let corner_direction = |c: [i64; 3]| direction(c.iter().fold(9, |hash, &x| mix(hash ^ x as u64)));
        for p in places(1000) {
            let mut sum = 0.0;
            // Corners farther away than 1 along some axis have no weight.
            for index in 0..64 {
                let offset = [index % 4 - 1, index / 4 % 4 - 1, index / 16 - 1];
                let floor = p.floor().to_array();
                let corner = [0, 1, 2].map(|axis| floor[axis] as i64 + offset[axis]);
                let from = p - Vec3::from(corner.map(|x| x as f64));
                let weight: f64 = from.abs().to_array().into_iter().map(blend).product();
                sum += weight * corner_direction(corner).dot(from);
            }
            assert!((noise(p, 9).value - sum).abs() < 1e-9, "{p}");
        }
    }

    /// With the best direction at each corner the noise is Σ weight · (sum of the two largest of |p
    /// − corner|).
    fn envelope(p: Vec3) -> f64 {
        let upper = p.map(|x| x * x * x * (x * (x * 6.0 - 15.0) + 10.0));
        (0..8)
            .map(|index: u32| {
                let bit = |axis: u32| index >> axis & 1 == 1;
                let pick = |axis: u32, x: f64, s: f64| if bit(axis) { (1.0 - x, s) } else { (x, 1.0 - s) };
                let [x, y, z] = [pick(0, p.x, upper.x), pick(1, p.y, upper.y), pick(2, p.z, upper.z)];
                x.1 * y.1 * z.1 * (x.0 + y.0 + z.0 - x.0.min(y.0).min(z.0))
            })
            .sum()
    }

    /// By symmetry the largest value has 0 ≤ z ≤ y ≤ x ≤ ½, where the envelope is one polynomial. A place at
    /// distance r from another has at most the value there + |slope| r + ½ · 100 r²: the weights of two
    /// corners along an axis have first and second derivatives below 1.9 and 5.8, m ≤ 2 and |∂m| ≤ 1, so that
    /// no second derivative is above 2 · 5.8 · 2 + 4 · 1.9 < 31, nor an eigenvalue above three times that.
    #[test]
    fn the_bound_holds_and_is_nearly_reached() {
        const CELLS: usize = 300;
        let cell = 0.5 / CELLS as f64;
        let (mut most, mut bound) = (0.0f64, 0.0f64);
        for i in 0..CELLS {
            for j in 0..=i {
                for k in 0..=j {
                    // Within the ordering even in cells on its border.
                    let place = Vec3::new(i as f64 + 0.7, j as f64 + 0.5, k as f64 + 0.3) * cell;
                    let reach = Vec3::new(0.7, 0.5, 0.7).length() * cell;
                    let value = envelope(place);
                    let by =
                        |axis: Vec3| (envelope(place + axis * 1e-6) - envelope(place - axis * 1e-6)) / 2e-6;
                    let slope = Vec3::new(by(Vec3::X), by(Vec3::Y), by(Vec3::Z)).length();
                    most = most.max(value);
                    bound = bound.max(value + slope * reach + 50.0 * reach * reach);
                }
            }
        }
        assert!(most > 1.0363 && bound < BOUND, "from {most} to {bound}");
    }

    #[test]
    fn slopes_are_those_of_the_values() {
        let octaves = Octaves { count: 4, gain: 0.6, seed: 1 };
        let step = 1e-5;
        for p in places(2000) {
            for field in [|o: Octaves, p| o.fractal(p), |o: Octaves, p| o.turbulence(p)] {
                let here = field(octaves, p);
                for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
                    let [before, after] = [-step, step].map(|step| field(octaves, p + axis * step));
                    let found = (after.value - before.value) / (2.0 * step);
                    // Where |noise| has its crease in between, the slopes on both sides differ.
                    let crease = (after.slope - before.slope).dot(axis).abs() > 1e-2;
                    assert!(
                        crease || (found - here.slope.dot(axis)).abs() < 1e-4,
                        "{p}: {found}, not {here:?}"
                    );
                }
            }
        }
    }

    /// Values and slopes go on through the faces of cubes, and the noise is zero at their corners.
    #[test]
    fn cubes_fit_together() {
        for p in places(1000) {
            for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
                let face = p - axis * (p.dot(axis) - p.dot(axis).floor());
                let [before, after] = [-1e-9, 1e-9].map(|step| noise(face + axis * step, 5));
                assert!((before.value - after.value).abs() < 1e-7, "{face}");
                assert!((before.slope - after.slope).length() < 1e-6, "{face}");
            }
            assert_eq!(noise(p.floor(), 5).value, 0.0);
        }
    }

    /// A corner's share is odd about it, so the mean is 0. With independent directions, in which a
    /// component's mean square is 2/3, the mean square over a cube is 8 · 3 · ⅔ · ∫w²x² (∫w²)², w(x) being
    /// the weight of the corner.
    #[test]
    fn mean_and_variance_are_known() {
        let weight = |x: f64| 1.0 - x * x * x * (x * (x * 6.0 - 15.0) + 10.0);
        let integral = |f: &dyn Fn(f64) -> f64| {
            (0..1000).map(|i| f((f64::from(i) + 0.5) / 1000.0)).sum::<f64>() / 1000.0
        };
        let square = integral(&|x| weight(x).powi(2));
        let variance = 16.0 * integral(&|x| (weight(x) * x).powi(2)) * square * square;
        let (mut first, mut second) = (Moments::default(), Moments::default());
        for p in places(400_000) {
            let value = noise(p, 0).value;
            first.push(value);
            second.push(value * value);
        }
        for (moments, expected) in [(first, 0.0), (second, variance)] {
            let found = moments.estimate();
            let deviation = (found.mean - expected) / found.error();
            assert!(deviation.abs() < 4.0, "{} ± {}, not {expected}", found.mean, found.error());
        }
    }

    #[test]
    fn sums_stay_in_their_bounds_and_use_them() {
        for (count, gain) in [(1, 0.5), (3, 1.0), (8, 0.5), (Octaves::MOST, 0.0)] {
            let octaves = Octaves { count, gain, seed: 7 };
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for p in places(100_000) {
                let (fractal, turbulence) = (octaves.fractal(p).value, octaves.turbulence(p).value);
                assert!((-1.0..=1.0).contains(&fractal) && (0.0..=1.0).contains(&turbulence));
                (low, high) = (low.min(fractal), high.max(fractal));
            }
            assert!(low < -0.5 && high > 0.5, "{count}: {low} to {high}");
        }
    }

    #[test]
    fn seeds_and_octaves_have_noise_of_their_own() {
        let one = Octaves { count: 1, gain: 0.5, seed: 1 };
        let other = Octaves { seed: 2, ..one };
        let mut product = Moments::default();
        for p in places(20_000) {
            product.push(one.fractal(p).value * other.fractal(p).value);
        }
        let found = product.estimate();
        assert!((found.mean / found.error()).abs() < 4.0, "{} ± {}", found.mean, found.error());
    }

    #[test]
    fn places_that_are_no_numbers_or_too_far_away_do_no_harm() {
        let octaves = Octaves { count: Octaves::MOST, gain: 0.5, seed: 1 };
        for x in [f64::NAN, f64::INFINITY, -1e300, 1e16, (1u64 << 52) as f64 - 1.0, 1e-300] {
            for p in [Vec3::splat(x), Vec3::new(0.3, x, 0.7)] {
                for field in [octaves.fractal(p), octaves.turbulence(p)] {
                    assert!(field.value.abs() <= 1.0 && field.slope.is_finite(), "{p}: {field:?}");
                }
            }
        }
    }
}
