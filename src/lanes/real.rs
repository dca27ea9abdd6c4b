use super::{Mask, Register};
use std::f64::consts::LOG2_E;
use std::fmt::Debug;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};
use wide::{f64x4, f64x8, u64x4};

/// Real numbers that a formula is written for: one `f64`, or several side by side.
///
/// Every operation is that of `f64` in each lane, so a formula has the same bits for one number and for many.
pub trait Real:
    Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Whether something holds, lane by lane.
    type Truth: Copy + BitAnd<Output = Self::Truth> + BitOr<Output = Self::Truth> + Not<Output = Self::Truth>;

    /// The same number in all lanes.
    fn of(value: f64) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// The size of this number with the sign of another.
    fn copysign(self, sign: Self) -> Self;
    /// The nearest integer; the even one of two.
    fn round_ties_even(self) -> Self;
    /// The lesser of two numbers; the second where either is not a number.
    fn lesser(self, other: Self) -> Self;
    /// The greater of two numbers; the second where either is not a number.
    fn greater(self, other: Self) -> Self;
    /// Less than.
    fn lt(self, other: Self) -> Self::Truth;
    /// Less than or equal.
    fn le(self, other: Self) -> Self::Truth;
    /// Greater than.
    fn gt(self, other: Self) -> Self::Truth;
    /// Greater than or equal.
    fn ge(self, other: Self) -> Self::Truth;
    /// Equal.
    fn eq(self, other: Self) -> Self::Truth;
    /// `yes` where the truth holds, `no` elsewhere. Both are evaluated.
    fn choose(truth: Self::Truth, yes: Self, no: Self) -> Self;
    /// 2 to the power of this number, an integer from -1022 to 1023.
    fn power_of_two(self) -> Self;

    /// e to the power of this number, with an error below 1.6 ulp where the result is normal, and the same
    /// bits on every machine. Zero from -746 down, infinity from 710 on.
    #[inline(always)]
    fn exp(self) -> Self {
        // From there on the result is the same.
        let x = self.lesser(Self::of(710.0)).greater(Self::of(-746.0));
        let n = (x * Self::of(LOG2_E)).round_ties_even();
        // The upper part of ln 2 ends in zeros: its product is exact.
        let r = x - n * Self::of(LN_2_UPPER) - n * Self::of(LN_2_LOWER);
        // Taylor's series: the next term is below 2⁻⁵⁷ for |r| ≤ ½ ln 2.
        let mut sum = Self::of(1.0 / FACTORIALS[13]);
        for i in (2..13).rev() {
            sum = sum * r + Self::of(1.0 / FACTORIALS[i]);
        }
        let e = Self::of(1.0) + (r + r * r * sum);
        // In two steps: the power alone may be beyond what a number holds.
        let half = (n * Self::of(0.5)).round_ties_even();
        let e = e * half.power_of_two() * (n - half).power_of_two();
        // Comparisons lose what is no number.
        Self::choose(self.eq(self), e, self)
    }
}

/// ln 2 in two parts, the upper with 32 bits (as in FreeBSD's `e_exp.c`).
#[expect(clippy::excessive_precision, reason = "as published")]
const LN_2_UPPER: f64 = 6.931_471_803_691_238_164_90e-1;
#[expect(clippy::excessive_precision, reason = "as published")]
const LN_2_LOWER: f64 = 1.908_214_929_270_587_700_02e-10;

const FACTORIALS: [f64; 14] = {
    let mut factorials = [1.0; 14];
    let mut i = 1;
    while i < factorials.len() {
        factorials[i] = factorials[i - 1] * i as f64;
        i += 1;
    }
    factorials
};

impl Real for f64 {
    type Truth = bool;

    #[inline(always)]
    fn of(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        self.copysign(sign)
    }

    #[inline(always)]
    fn round_ties_even(self) -> Self {
        self.round_ties_even()
    }

    #[inline(always)]
    fn lesser(self, other: Self) -> Self {
        if self < other { self } else { other }
    }

    #[inline(always)]
    fn greater(self, other: Self) -> Self {
        if self > other { self } else { other }
    }

    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self < other
    }

    #[inline(always)]
    fn le(self, other: Self) -> bool {
        self <= other
    }

    #[inline(always)]
    fn gt(self, other: Self) -> bool {
        self > other
    }

    #[inline(always)]
    fn ge(self, other: Self) -> bool {
        self >= other
    }

    #[inline(always)]
    fn eq(self, other: Self) -> bool {
        self == other
    }

    #[inline(always)]
    fn choose(truth: bool, yes: Self, no: Self) -> Self {
        if truth { yes } else { no }
    }

    #[inline(always)]
    fn power_of_two(self) -> Self {
        Self::from_bits((self + (INTEGERS + EXPONENT_BIAS)).to_bits() << MANTISSA_BITS)
    }
}

/// 1.5 · 2⁵²: added to an integer of less than 2⁵¹, makes a number whose lowest bits are the integer's.
const INTEGERS: f64 = 6_755_399_441_055_744.0;

/// In the exponents of `f64`.
const EXPONENT_BIAS: f64 = 1023.0;

/// Four integers with four numbers added to them that are rounded to the nearest integers, ties to even. They
/// have to be less than [`MOST_INTEGER`]. `None` where a sum leaves the range.
#[inline(always)]
pub fn add_to_integers(integers: [i64; 4], numbers: f64x4) -> Option<[i64; 4]> {
    let bits = (numbers + f64x4::splat(INTEGERS)).to_bits();
    let more = bits - u64x4::splat(INTEGERS.to_bits());
    let own = u64x4::new(integers.map(i64::cast_unsigned));
    let sums = own + more;
    // A sum whose sign is that of neither part.
    let lost = (own ^ sums) & (more ^ sums);
    let fits = f64x4::from_bits(lost).to_bitmask() == 0;
    fits.then(|| sums.to_array().map(u64::cast_signed))
}

/// Where the numbers end that [`add_to_integers`] takes, 2⁵¹.
pub const MOST_INTEGER: f64 = 2_251_799_813_685_248.0;

/// The width of the fraction of an `f64`.
const MANTISSA_BITS: u32 = 52;

/// Whether something holds in each lane of a register: all bits of the lane, or none.
#[derive(Clone, Copy, Debug)]
pub struct Truth<N = Register>(N);

impl Truth {
    /// The lanes of a register that a mask of its own lanes names.
    #[inline(always)]
    pub fn of(mask: Mask) -> Self {
        let bits = |lane: usize| (u64::from(mask) >> lane & 1).wrapping_neg();
        Self(Register::new(std::array::from_fn(|lane| f64::from_bits(bits(lane)))))
    }
}

impl<N: BitAnd<Output = N>> Truth<N> {
    /// The numbers of these lanes, and 0 in the others.
    #[inline(always)]
    pub fn only(self, numbers: N) -> N {
        self.0 & numbers
    }
}

impl<N: BitAnd<Output = N>> BitAnd for Truth<N> {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl<N: BitOr<Output = N>> BitOr for Truth<N> {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl<N: Not<Output = N>> Not for Truth<N> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

/// Numbers side by side are real numbers, lane by lane.
macro_rules! side_by_side {
    ($numbers:ty) => {
        impl Real for $numbers {
            type Truth = Truth<Self>;

            #[inline(always)]
            fn of(value: f64) -> Self {
                Self::splat(value)
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                self.sqrt()
            }

            #[inline(always)]
            fn abs(self) -> Self {
                self.abs()
            }

            #[inline(always)]
            fn copysign(self, sign: Self) -> Self {
                let bit = Self::splat(-0.0);
                self.abs() | (sign & bit)
            }

            #[inline(always)]
            fn round_ties_even(self) -> Self {
                self.round_ties_even()
            }

            #[inline(always)]
            fn lesser(self, other: Self) -> Self {
                self.fast_min(other)
            }

            #[inline(always)]
            fn greater(self, other: Self) -> Self {
                self.fast_max(other)
            }

            #[inline(always)]
            fn lt(self, other: Self) -> Truth<Self> {
                Truth(self.simd_lt(other))
            }

            #[inline(always)]
            fn le(self, other: Self) -> Truth<Self> {
                Truth(self.simd_le(other))
            }

            #[inline(always)]
            fn gt(self, other: Self) -> Truth<Self> {
                Truth(self.simd_gt(other))
            }

            #[inline(always)]
            fn ge(self, other: Self) -> Truth<Self> {
                Truth(self.simd_ge(other))
            }

            #[inline(always)]
            fn eq(self, other: Self) -> Truth<Self> {
                Truth(self.simd_eq(other))
            }

            #[inline(always)]
            fn choose(truth: Truth<Self>, yes: Self, no: Self) -> Self {
                truth.0.select(yes, no)
            }

            #[inline(always)]
            fn power_of_two(self) -> Self {
                let biased = (self + Self::splat(INTEGERS + EXPONENT_BIAS)).to_array();
                Self::new(biased.map(|biased| f64::from_bits(biased.to_bits() << MANTISSA_BITS)))
            }
        }

        impl Truth<$numbers> {
            /// A bit for each lane.
            #[inline(always)]
            pub fn mask(self) -> Mask {
                self.0.to_bitmask()
            }
        }
    };
}

side_by_side!(f64x4);
side_by_side!(f64x8);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{ALL, WIDTH, part};

    /// Numbers of all kinds, in pairs.
    fn pairs() -> Vec<[f64; 2]> {
        let numbers = [0.0, -0.0, 1.0, -1.5, 2.5, 1e300, -1e-300, f64::INFINITY, f64::NEG_INFINITY, f64::NAN];
        numbers.iter().flat_map(|&a| numbers.iter().map(move |&b| [a, b])).collect()
    }

    #[test]
    fn each_lane_is_what_one_number_is() {
        type Of<R> = fn(R, R) -> R;
        fn all<R: Real>() -> [Of<R>; 10] {
            [
                |a, b| a.lesser(b),
                |a, b| a.greater(b),
                |a, b| a.copysign(b),
                |a, _| a.abs().sqrt(),
                |a, _| a.round_ties_even(),
                |a, b| R::choose(a.lt(b) & !a.eq(b), a, b),
                |a, b| R::choose(a.le(b) | a.gt(b), a, b),
                |a, b| R::choose(a.ge(b), a, b),
                |a, b| (a + b) * (a - b) / b,
                |a, b| a.exp() + b.exp(),
            ]
        }
        for ((one, four), eight) in all::<f64>().into_iter().zip(all::<f64x4>()).zip(all::<f64x8>()) {
            for [a, b] in pairs() {
                let expected = one(a, b);
                let four = four(f64x4::splat(a), f64x4::splat(b)).to_array();
                let eight = eight(f64x8::splat(a), f64x8::splat(b)).to_array();
                for value in four.into_iter().chain(eight) {
                    let same = value.to_bits() == expected.to_bits() || value.is_nan() && expected.is_nan();
                    assert!(same, "{a} {b}: {value} {expected}");
                }
            }
        }
    }

    /// Standard libraries err by little more than half an ulp: within one of theirs is within 1.6.
    #[test]
    fn exponentials_are_within_one_ulp_of_the_standard_library() {
        for i in -708 * 1024..709 * 1024 {
            let x = f64::from(i) / 1024.0 + 1e-4;
            let [found, expected] = [Real::exp(x), x.exp()].map(f64::to_bits);
            assert!(found.abs_diff(expected) <= 1, "{x}");
        }
        for (x, expected) in [(0.0, 1.0), (-800.0, 0.0), (800.0, f64::INFINITY)] {
            assert_eq!(Real::exp(x), expected);
        }
        // Below normal numbers the last bit is worth more.
        assert!((Real::exp(-740.0f64) - (-740.0f64).exp()).abs() <= f64::from_bits(1));
    }

    #[test]
    fn integers_are_those_of_the_numbers() {
        let least = 1.0 - MOST_INTEGER;
        let numbers = f64x4::new([0.0, -1.0, -least, least]);
        let sums = [0, 4, 5 - least as i64, least as i64 - 2];
        assert_eq!(add_to_integers([0, 5, 5, -2], numbers), Some(sums));
        let halves = f64x4::new([0.5, 1.5, -2.5, -0.75]);
        assert_eq!(add_to_integers([0, 0, 10, 0], halves), Some([0, 2, 8, -1]));
        assert_eq!(add_to_integers([0, 0, i64::MAX, 0], numbers), None);
        assert_eq!(add_to_integers([0, i64::MIN, 0, 0], numbers), None);
    }

    #[test]
    fn truths_are_masks() {
        let mut numbers = [1.0; WIDTH];
        numbers[2] = f64::NAN;
        let mut expected = [0.0; WIDTH];
        (expected[1], expected[3]) = (1.0, 1.0);
        assert_eq!(Truth::of(0b1010).only(Register::new(numbers)).to_array(), expected);
        assert_eq!((Truth::of(0b1010) & !Truth::of(0b0010) | Truth::of(1)).mask(), 0b1001);
        assert_eq!(Truth::of(ALL).mask(), part(ALL, 0));
    }
}
