use crate::lanes::Real;
use std::ops::{Add, AddAssign, Div, DivAssign, Index, IndexMut, Mul, MulAssign, Neg, Sub};
use wide::f64x4;

/// The values of functions of wavelength at the `C` wavelengths of one path; lane 0 is the hero's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampled<const C: usize>(pub [f64; C]);

impl<const C: usize> Sampled<C> {
    /// 0 at all wavelengths.
    pub const ZERO: Self = Self([0.0; C]);
    /// 1 at all wavelengths.
    pub const ONE: Self = Self([1.0; C]);

    /// The same value at all wavelengths.
    pub fn splat(value: f64) -> Self {
        Self([value; C])
    }

    /// The hero's value and zero for every companion.
    pub fn hero_alone(value: f64) -> Self {
        let mut lanes = [0.0; C];
        lanes[0] = value;
        Self(lanes)
    }

    /// The value at the hero wavelength.
    pub fn hero(&self) -> f64 {
        self.0[0]
    }

    /// Lane by lane. A loop and not `array::from_fn` or `array::map`, which are not always inlined.
    #[inline]
    pub fn from_fn(f: impl Fn(usize) -> f64) -> Self {
        let mut lanes = [0.0; C];
        for (lane, value) in lanes.iter_mut().enumerate() {
            *value = f(lane);
        }
        Self(lanes)
    }

    /// A function of each value.
    #[inline]
    pub fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self::from_fn(|lane| f(self.0[lane]))
    }

    /// A function of each pair of values.
    #[inline]
    pub fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self::from_fn(|lane| f(self.0[lane], other.0[lane]))
    }

    /// e to the power of each value; see [`Real::exp`].
    #[inline]
    pub fn exp(mut self) -> Self {
        let (fours, rest) = self.0.as_chunks_mut::<4>();
        for four in fours {
            // Not `f64x4::exp`, whose bits depend on whether the processor fuses multiply-adds.
            *four = Real::exp(f64x4::new(*four)).to_array();
        }
        for value in rest {
            *value = Real::exp(*value);
        }
        self
    }

    /// The sum of the values.
    pub fn sum(self) -> f64 {
        self.0.iter().sum()
    }

    /// The greatest of the values.
    pub fn max(self) -> f64 {
        self.0.iter().fold(f64::NEG_INFINITY, |a, &b| if b > a { b } else { a })
    }

    /// Whether all values are 0.
    pub fn is_zero(&self) -> bool {
        self.0.iter().all(|&value| value == 0.0)
    }
}

macro_rules! lane_by_lane {
    ($trait:ident, $method:ident, $op:tt) => {
        impl<const C: usize> $trait for Sampled<C> {
            type Output = Self;
            #[inline]
            fn $method(self, other: Self) -> Self {
                self.zip(other, |a, b| a $op b)
            }
        }
        impl<const C: usize> $trait<f64> for Sampled<C> {
            type Output = Self;
            #[inline]
            fn $method(self, other: f64) -> Self {
                self.map(|a| a $op other)
            }
        }
    };
}
lane_by_lane!(Add, add, +);
lane_by_lane!(Sub, sub, -);
lane_by_lane!(Mul, mul, *);
lane_by_lane!(Div, div, /);

impl<const C: usize> Neg for Sampled<C> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}

impl<const C: usize> AddAssign for Sampled<C> {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const C: usize> MulAssign for Sampled<C> {
    #[inline]
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

impl<const C: usize> MulAssign<f64> for Sampled<C> {
    #[inline]
    fn mul_assign(&mut self, other: f64) {
        *self = *self * other;
    }
}

impl<const C: usize> DivAssign<f64> for Sampled<C> {
    #[inline]
    fn div_assign(&mut self, other: f64) {
        *self = *self / other;
    }
}

impl<const C: usize> Index<usize> for Sampled<C> {
    type Output = f64;
    #[inline]
    fn index(&self, lane: usize) -> &f64 {
        &self.0[lane]
    }
}

impl<const C: usize> IndexMut<usize> for Sampled<C> {
    #[inline]
    fn index_mut(&mut self, lane: usize) -> &mut f64 {
        &mut self.0[lane]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponentials_of_many_are_those_of_each() {
        fn check<const C: usize>() {
            for i in 0..1000 {
                let values = Sampled::<C>::from_fn(|lane| 3.7 - 0.113 * f64::from(i) * (lane + 1) as f64);
                assert_eq!(values.exp(), values.map(Real::exp));
            }
        }
        check::<1>();
        check::<4>();
        check::<8>();
    }
}
