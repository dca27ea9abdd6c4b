//! Numbers of about 32 digits, each the sum of two `f64`, and polynomials of them: what the shapes' oracles
//! compute with.

use std::ops::{Add, Div, Mul, Neg, Sub};

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Doubled {
    pub high: f64,
    low: f64,
}

fn two_sum(a: f64, b: f64) -> Doubled {
    let high = a + b;
    let back = high - a;
    Doubled { high, low: (a - (high - back)) + (b - back) }
}

fn quick_two_sum(a: f64, b: f64) -> Doubled {
    let high = a + b;
    Doubled { high, low: b - (high - a) }
}

impl From<f64> for Doubled {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

impl Add for Doubled {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let (high, low) = (two_sum(self.high, other.high), two_sum(self.low, other.low));
        let sum = quick_two_sum(high.high, high.low + low.high);
        quick_two_sum(sum.high, sum.low + low.low)
    }
}

impl Neg for Doubled {
    type Output = Self;
    fn neg(self) -> Self {
        Self { high: -self.high, low: -self.low }
    }
}

impl Sub for Doubled {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Doubled {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let high = self.high * other.high;
        let lost = self.high.mul_add(other.high, -high);
        quick_two_sum(high, lost + (self.high * other.low + self.low * other.high))
    }
}

impl Div for Doubled {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let first = Self::from(self.high / other.high);
        let second = Self::from((self - first * other).high / other.high);
        let rest = Self::from((self - (first + second) * other).high / other.high);
        first + second + rest
    }
}

impl Doubled {
    pub fn sqrt(self) -> Self {
        if self.high <= 0.0 {
            return Self::from(0.0);
        }
        let first = Self::from(self.high.sqrt());
        let second = first + (self - first * first) / (first + first);
        second + (self - second * second) / (second + second)
    }
}

/// Coefficients in ascending order.
#[derive(Clone, Debug)]
pub struct Polynomial(pub Vec<Doubled>);

impl Polynomial {
    pub fn constant(value: f64) -> Self {
        Self(vec![value.into()])
    }

    pub fn at(&self, t: Doubled) -> Doubled {
        self.0.iter().rev().fold(0.0.into(), |value: Doubled, &c| value * t + c)
    }

    pub fn derivative(&self) -> Self {
        Self(self.0.iter().enumerate().skip(1).map(|(i, &c)| c * Doubled::from(i as f64)).collect())
    }

    pub fn scaled(&self, factor: f64) -> Self {
        Self(self.0.iter().map(|&c| c * factor.into()).collect())
    }

    /// Simple roots of degree one or two.
    fn closed_form(&self) -> Vec<Doubled> {
        let (c, b) = (self.0[0], self.0[1]);
        match self.0.get(2) {
            Some(&a) if a.high != 0.0 => {
                let half = b * 0.5.into();
                let discriminant = half * half - a * c;
                if discriminant.high <= 0.0 {
                    return Vec::new();
                }
                let root = discriminant.sqrt();
                let q = if half.high > 0.0 { -(half + root) } else { root - half };
                let (first, second) = (q / a, c / q);
                if (second - first).high < 0.0 { vec![second, first] } else { vec![first, second] }
            }
            _ if b.high == 0.0 => Vec::new(),
            _ => vec![-c / b],
        }
    }

    /// Simple roots in a range, in ascending order, by bisection and Newton's method between those of the
    /// derivative.
    pub fn roots(&self, range: [f64; 2]) -> Vec<Doubled> {
        let degree = self.0.len().saturating_sub(1);
        if degree == 0 {
            return Vec::new();
        }
        if degree <= 2 {
            return self
                .closed_form()
                .into_iter()
                .filter(|t| range[0] <= t.high && t.high <= range[1])
                .collect();
        }
        let slope = self.derivative();
        let mut edges = vec![Doubled::from(range[0])];
        edges.extend(slope.roots(range));
        edges.push(range[1].into());
        let mut found = Vec::new();
        for pair in edges.windows(2) {
            let (mut low, mut high) = (pair[0], pair[1]);
            let sign = self.at(low).high;
            if sign * self.at(high).high >= 0.0 {
                continue;
            }
            let half = Doubled::from(0.5);
            let mut t = (low + high) * half;
            let mut moved = (high - low).high;
            for _ in 0..300 {
                let value = self.at(t);
                if value.high * sign > 0.0 {
                    low = t
                } else {
                    high = t
                }
                let newton = t - value / slope.at(t);
                let inside = (newton - low).high > 0.0 && (high - newton).high > 0.0;
                // A step that is no shorter than half the last one gives way to halving.
                let next = if inside && (newton - t).high.abs() < 0.5 * moved {
                    newton
                } else {
                    (low + high) * half
                };
                moved = (next - t).high.abs();
                t = next;
                if moved <= 1e-30 * t.high.abs() || (high - low).high <= 1e-31 * t.high.abs() {
                    break;
                }
            }
            found.push(t);
        }
        found
    }
}

impl Add for &Polynomial {
    type Output = Polynomial;
    fn add(self, other: Self) -> Polynomial {
        let at = |p: &Polynomial, i: usize| p.0.get(i).copied().unwrap_or(0.0.into());
        Polynomial((0..self.0.len().max(other.0.len())).map(|i| at(self, i) + at(other, i)).collect())
    }
}

impl Sub for &Polynomial {
    type Output = Polynomial;
    fn sub(self, other: Self) -> Polynomial {
        self + &other.scaled(-1.0)
    }
}

impl Mul for &Polynomial {
    type Output = Polynomial;
    fn mul(self, other: Self) -> Polynomial {
        let mut product = vec![Doubled::from(0.0); self.0.len() + other.0.len() - 1];
        for (i, &a) in self.0.iter().enumerate() {
            for (j, &b) in other.0.iter().enumerate() {
                product[i + j] = product[i + j] + a * b;
            }
        }
        Polynomial(product)
    }
}

#[test]
fn the_oracle_has_thirty_digits() {
    let third = Doubled::from(1.0) / 3.0.into();
    assert!((third * 3.0.into() - 1.0.into()).high.abs() < 1e-31);
    let root = Doubled::from(2.0).sqrt();
    assert!((root * root - 2.0.into()).high.abs() < 1e-31);
    // (t − 1)(t − 1 − 10⁻¹²)(t² − 2)
    let close = Polynomial(vec![Doubled::from(-1.0) - 1e-12.into(), 1.0.into()]);
    let one = Polynomial(vec![(-1.0).into(), 1.0.into()]);
    let two = Polynomial(vec![(-2.0).into(), 0.0.into(), 1.0.into()]);
    let roots = (&(&close * &one) * &two).roots([-10.0, 10.0]);
    assert_eq!(roots.len(), 4);
    assert!((roots[3] - root).high.abs() < 1e-29 && (roots[0] + root).high.abs() < 1e-29);
    assert!((roots[2] - roots[1] - 1e-12.into()).high.abs() < 1e-17);
}
