//! Cubics in Bernstein form, whose values never leave the range of their coefficients: bounds of whole
//! stretches for nothing.

use super::roots::{Sample, bracketed};
use smallvec::SmallVec;
use std::ops::{Add, Mul, Sub};

/// What a cubic may be a function to.
pub trait Value: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<f64, Output = Self> {}

impl<T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f64, Output = T>> Value for T {}

/// A cubic's value.
pub fn cubic<T: Value>(c: &[T; 4], u: f64) -> T {
    blossom(c, [u; 3])
}

/// Its first derivative.
pub fn cubic_slope<T: Value>(c: &[T; 4], u: f64) -> T {
    let v = 1.0 - u;
    ((c[1] - c[0]) * (v * v) + (c[2] - c[1]) * (2.0 * u * v) + (c[3] - c[2]) * (u * u)) * 3.0
}

/// Its second derivative.
pub fn cubic_bend<T: Value>(c: &[T; 4], u: f64) -> T {
    let [first, second] = [(c[2] - c[1]) - (c[1] - c[0]), (c[3] - c[2]) - (c[2] - c[1])];
    (first * (1.0 - u) + second * u) * 6.0
}

/// The function of three parameters, linear in each and the same in any order of them, that is the cubic
/// where all are equal.
fn blossom<T: Value>(c: &[T; 4], [u, v, w]: [f64; 3]) -> T {
    // Both ends come out as they are.
    let mix = |a: T, b: T, u: f64| a * (1.0 - u) + b * u;
    let [a, b, d] = [mix(c[0], c[1], u), mix(c[1], c[2], u), mix(c[2], c[3], u)];
    mix(mix(a, b, v), mix(b, d, v), w)
}

/// The same cubic from `from` to `to`, as one on [0, 1].
pub fn restricted<T: Value>(c: &[T; 4], [from, to]: [f64; 2]) -> [T; 4] {
    [[from; 3], [from, from, to], [from, to, to], [to; 3]].map(|place| blossom(c, place))
}

/// Both halves of a cubic, each as one on [0, 1].
pub fn split<T: Value>(c: &[T; 4]) -> [[T; 4]; 2] {
    let middle = |a: T, b: T| (a + b) * 0.5;
    let [a, b, d] = [middle(c[0], c[1]), middle(c[1], c[2]), middle(c[2], c[3])];
    let (left, right) = (middle(a, b), middle(b, d));
    let centre = middle(left, right);
    [[c[0], a, left, centre], [centre, right, d, c[3]]]
}

/// The square of a cubic; of one to vectors, component by component.
pub fn squared<T: Value + Mul<Output = T>>(c: &[T; 4]) -> [T; 7] {
    let [a, b, d, e] = *c;
    [
        a * a,
        a * b,
        (a * d * 2.0 + b * b * 3.0) * 0.2,
        (a * e + b * d * 9.0) * 0.1,
        (b * e * 2.0 + d * d * 3.0) * 0.2,
        d * e,
        e * e,
    ]
}

/// The derivative of a polynomial of degree `M`.
pub fn derivative<const N: usize, const M: usize>(c: &[f64; N]) -> [f64; M] {
    const { assert!(N == M + 1) };
    std::array::from_fn(|i| (c[i + 1] - c[i]) * M as f64)
}

/// Both halves, each as a polynomial on [0, 1].
pub fn halves<const N: usize>(c: &[f64; N]) -> [[f64; N]; 2] {
    let (mut left, mut right) = (*c, *c);
    for last in (0..N).rev() {
        left[N - 1 - last] = right[0];
        for i in 0..last {
            right[i] = 0.5 * (right[i] + right[i + 1]);
        }
    }
    [left, right]
}

/// How often neighbouring coefficients differ in sign: at least as many roots as the polynomial has between 0
/// and 1 (Descartes), and as many where it is none or one.
pub fn variations(c: &[f64]) -> usize {
    let mut signs = c.iter().filter(|&&c| c != 0.0).map(|&c| c > 0.0);
    let Some(mut last) = signs.next() else { return 0 };
    signs.filter(|&sign| std::mem::replace(&mut last, sign) != sign).count()
}

/// Where the polynomial with coefficients `c` over `place` changes its sign there, in ascending order:
/// `function` is the same polynomial over the whole, evaluated with less rounding.
pub fn sign_changes<const N: usize>(
    c: &[f64; N],
    place: [f64; 2],
    function: &impl Fn(f64) -> Sample,
) -> SmallVec<[f64; 8]> {
    let mut found = SmallVec::new();
    search(c, place, function, 0, &mut found);
    found
}

fn search<const N: usize>(
    c: &[f64; N],
    [from, to]: [f64; 2],
    function: &impl Fn(f64) -> Sample,
    depth: u32,
    found: &mut SmallVec<[f64; 8]>,
) {
    /// What has not come apart by then is a touch.
    const DEEPEST: u32 = 46;
    let count = variations(c);
    if count == 0 || (count > 1 && depth == DEEPEST) {
        return;
    }
    if count == 1 {
        let (first, last) = (function(from).value, function(to).value);
        // Where an end is a root, as where a path comes to rest, there may be another within.
        let apart = first * last != 0.0 || depth == DEEPEST;
        if first * last < 0.0 {
            found.push(bracketed(from, to, first.signum(), function).t);
        } else if apart {
            // Within rounding it is at one of the ends.
            found.push(if first.abs() < last.abs() { from } else { to });
        }
        if apart {
            return;
        }
    }
    let ([left, right], middle) = (halves(c), 0.5 * (from + to));
    search(&left, [from, middle], function, depth + 1, found);
    search(&right, [middle, to], function, depth + 1, found);
}

/// A range of values, lower end first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range(pub f64, pub f64);

impl Range {
    /// Range of a polynomial on [0, 1].
    pub fn of(c: &[f64]) -> Self {
        c.iter()
            .fold(Self(f64::INFINITY, f64::NEG_INFINITY), |range, &c| Self(range.0.min(c), range.1.max(c)))
    }

    /// Whether 0 lies between its ends, which are included.
    pub fn has_zero(self) -> bool {
        self.0 <= 0.0 && self.1 >= 0.0
    }

    /// Range of the square roots; the negative part counts as 0.
    pub fn sqrt(self) -> Self {
        Self(self.0.max(0.0).sqrt(), self.1.max(0.0).sqrt())
    }
}

impl Add for Range {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0, self.1 + other.1)
    }
}

impl Mul for Range {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self::of(&[self.0 * other.0, self.0 * other.1, self.1 * other.0, self.1 * other.1])
    }
}

impl Mul<f64> for Range {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        self * Self(factor, factor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CUBIC: [f64; 4] = [1.0, -2.0, 0.5, 3.0];

    /// Against the power basis: 1 − 9 u + 16.5 u² − 5.5 u³.
    #[test]
    fn cubics_and_their_derivatives() {
        for i in 0..=10 {
            let u = f64::from(i) / 10.0;
            let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-14, "{u}: {a} {b}");
            near(cubic(&CUBIC, u), 1.0 - 9.0 * u + 16.5 * u * u - 5.5 * u * u * u);
            near(cubic_slope(&CUBIC, u), -9.0 + 33.0 * u - 16.5 * u * u);
            near(cubic_bend(&CUBIC, u), 33.0 - 33.0 * u);
            let part = restricted(&CUBIC, [0.25, 0.75]);
            near(cubic(&part, u), cubic(&CUBIC, 0.25 + 0.5 * u));
        }
        assert_eq!((cubic(&CUBIC, 0.0), cubic(&CUBIC, 1.0)), (1.0, 3.0));
    }

    fn value(c: &[f64], u: f64) -> f64 {
        let mut c = c.to_vec();
        while c.len() > 1 {
            c = c.windows(2).map(|pair| pair[0] * (1.0 - u) + pair[1] * u).collect();
        }
        c[0]
    }

    /// A root at an end hides none within: (u − 3/10) (1 − u).
    #[test]
    fn roots_beside_one_at_an_end() {
        let function = |u: f64| Sample { value: (u - 0.3) * (1.0 - u), slope: 1.3 - 2.0 * u, error: 0.0 };
        for last in [0.0, -1e-17, 1e-17] {
            let found = sign_changes(&[-0.3, 0.35, last], [0.0, 1.0], &function);
            assert!((found[0] - 0.3).abs() < 1e-15, "{found:?}");
        }
    }

    #[test]
    fn squares_halves_and_ranges() {
        let square: [f64; 7] = squared(&CUBIC);
        let slope: [f64; 6] = derivative(&square);
        let [left, right] = halves(&square);
        let parts = split(&CUBIC);
        let range = Range::of(&square);
        for i in 0..=10 {
            let u = f64::from(i) / 10.0;
            let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-13, "{u}: {a} {b}");
            near(value(&square, u), cubic(&CUBIC, u).powi(2));
            near(value(&slope, u), 2.0 * cubic(&CUBIC, u) * cubic_slope(&CUBIC, u));
            near(value(&left, u), value(&square, 0.5 * u));
            near(value(&right, u), value(&square, 0.5 + 0.5 * u));
            near(cubic(&parts[0], u), cubic(&CUBIC, 0.5 * u));
            near(cubic(&parts[1], u), cubic(&CUBIC, 0.5 + 0.5 * u));
            assert!((range.0..=range.1).contains(&value(&square, u)));
        }
        let sample = |u: f64| Sample { value: cubic(&CUBIC, u), slope: cubic_slope(&CUBIC, u), error: 0.0 };
        let roots = sign_changes(&CUBIC, [0.0, 1.0], &sample);
        assert!(roots.len() == 2 && roots.iter().all(|&u| sample(u).value.abs() < 1e-14), "{roots:?}");
        assert_eq!(variations(&CUBIC), 2);
        assert_eq!(variations(&[0.0, -1.0, 0.0, 2.0]), 1);
        assert_eq!(Range(-1.0, 2.0) * Range(-3.0, 1.0), Range(-6.0, 3.0));
        assert_eq!((Range(-1.0, 4.0)).sqrt(), Range(0.0, 2.0));
    }
}
