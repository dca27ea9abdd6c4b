//! Functions of wavelength at the wavelengths of a path, for several paths that share them.

use super::Sampled;
use crate::lanes::{ALL, Mask, REGISTERS, Real, Register, Row, Truth, WIDTH, ZERO, get, part, set, sum};

/// Spectra, one for each lane.
#[derive(Clone, Debug)]
pub struct SampledLanes<const C: usize>(pub [Row; C]);

impl<const C: usize> SampledLanes<C> {
    /// 0 at all wavelengths in each lane.
    pub const ZERO: Self = Self([ZERO; C]);
    /// 1 at all wavelengths in each lane.
    pub const ONE: Self = Self([[Register::ONE; REGISTERS]; C]);

    /// The same for all lanes.
    #[inline(always)]
    pub fn splat(value: &Sampled<C>) -> Self {
        let mut all = Self::ZERO;
        for (row, &value) in all.0.iter_mut().zip(&value.0) {
            *row = [Register::splat(value); REGISTERS];
        }
        all
    }

    /// The values of one lane.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Sampled<C> {
        Sampled::from_fn(|wavelength| get(&self.0[wavelength], lane))
    }

    /// Puts values into one lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, value: &Sampled<C>) {
        for (row, &value) in self.0.iter_mut().zip(&value.0) {
            set(row, lane, value);
        }
    }

    /// Over the wavelengths, lane by lane.
    #[inline(always)]
    pub fn sum_of_each(&self) -> Row {
        let mut sums = ZERO;
        for row in &self.0 {
            for register in 0..REGISTERS {
                sums[register] += row[register];
            }
        }
        sums
    }

    /// Σ own · other over the wavelengths, lane by lane.
    #[inline(always)]
    pub fn dot_of_each(&self, other: &Self) -> Row {
        let mut sums = ZERO;
        for (own, other) in self.0.iter().zip(&other.0) {
            for register in 0..REGISTERS {
                sums[register] += own[register] * other[register];
            }
        }
        sums
    }

    /// The lanes with a value that is not zero.
    #[inline(always)]
    pub fn nonzero(&self) -> Mask {
        let mut mask = 0;
        for register in 0..REGISTERS {
            let zero =
                self.0.iter().fold(Truth::of(ALL), |zero, row| zero & row[register].eq(Register::ZERO));
            mask |= (!zero).mask() << (WIDTH * register);
        }
        mask
    }

    /// Makes all lanes zero but those of a mask.
    #[inline(always)]
    pub fn keep(&mut self, lanes: Mask) {
        for row in &mut self.0 {
            for (register, numbers) in row.iter_mut().enumerate() {
                *numbers = Truth::of(part(lanes, register)).only(*numbers);
            }
        }
    }

    /// Adds lane by lane.
    #[inline(always)]
    pub fn add(&mut self, other: &Self) {
        for (own, other) in self.0.iter_mut().zip(&other.0) {
            for register in 0..REGISTERS {
                own[register] += other[register];
            }
        }
    }

    /// Over all lanes.
    #[inline(always)]
    pub fn sum(&self) -> Sampled<C> {
        Sampled::from_fn(|wavelength| sum(&self.0[wavelength]))
    }

    /// Σ own · other over all lanes.
    #[inline(always)]
    pub fn dot(&self, other: &Self) -> Sampled<C> {
        Sampled::from_fn(|wavelength| {
            let (own, other) = (&self.0[wavelength], &other.0[wavelength]);
            let mut products = ZERO;
            for register in 0..REGISTERS {
                products[register] = own[register] * other[register];
            }
            sum(&products)
        })
    }

    /// Adds own · factor, lane by lane.
    #[inline(always)]
    pub fn add_times(&self, factor: &Sampled<C>, total: &mut Self) {
        for wavelength in 0..C {
            let factor = Register::splat(factor[wavelength]);
            for register in 0..REGISTERS {
                total.0[wavelength][register] += self.0[wavelength][register] * factor;
            }
        }
    }

    /// Adds own · weight · factor, with a weight for each lane.
    #[inline(always)]
    pub fn add_weighted(&self, weights: &Row, factor: &Sampled<C>, total: &mut Self) {
        for wavelength in 0..C {
            let factor = Register::splat(factor[wavelength]);
            for register in 0..REGISTERS {
                total.0[wavelength][register] += self.0[wavelength][register] * weights[register] * factor;
            }
        }
    }

    /// Adds own · other · factor, lane by lane.
    #[inline(always)]
    pub fn add_to(&self, other: &Self, factor: &Sampled<C>, total: &mut Self) {
        for wavelength in 0..C {
            let factor = Register::splat(factor[wavelength]);
            for register in 0..REGISTERS {
                total.0[wavelength][register] +=
                    self.0[wavelength][register] * other.0[wavelength][register] * factor;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::LANES;

    #[test]
    fn sums_take_each_lane_once() {
        let mut values = SampledLanes::<2>::ZERO;
        for lane in 0..LANES {
            values.set(lane, &Sampled([f64::from(1 << lane), 1.0]));
        }
        assert_eq!(values.sum(), Sampled([65535.0, 16.0]));
        assert_eq!(values.get(5), Sampled([32.0, 1.0]));
        let twos = SampledLanes::splat(&Sampled([2.0, 3.0]));
        assert_eq!(values.dot(&twos), Sampled([131_070.0, 48.0]));
        let mut total = SampledLanes::splat(&Sampled([1.0, 0.0]));
        values.add_to(&twos, &Sampled([10.0, 100.0]), &mut total);
        assert_eq!(total.get(3), Sampled([161.0, 300.0]));
    }
}
