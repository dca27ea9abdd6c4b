//! Numbers side by side, of which a processor computes several at once.
//!
//! No lane sees another, and each does what the scalar code does, in the same order and without fused
//! multiply-adds: a lane's bits are those of the scalar code. Sums over lanes have a fixed order.

mod vector;

pub use vector::Vec3Lanes;

use crate::spectrum::Sampled;
use wide::f64x4;

/// Numbers of one register.
pub const WIDTH: usize = 4;

/// Registers of a row.
pub const REGISTERS: usize = 4;

/// Lanes of a row: as many as a group of pixels has members.
pub const LANES: usize = WIDTH * REGISTERS;

/// One number for each lane.
pub type Row = [f64x4; REGISTERS];

pub const ZERO: Row = [f64x4::ZERO; REGISTERS];

/// A bit for each lane.
pub type Mask = u32;

/// The lanes of a mask, the lowest first.
#[inline]
pub fn lanes_of(mut mask: Mask) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = mask.trailing_zeros() as usize;
        (mask != 0).then(|| {
            mask &= mask - 1;
            lane % LANES
        })
    })
}

#[inline(always)]
pub fn get(row: &Row, lane: usize) -> f64 {
    row[lane / WIDTH % REGISTERS].as_array()[lane % WIDTH]
}

#[inline(always)]
pub fn set(row: &mut Row, lane: usize, value: f64) {
    row[lane / WIDTH % REGISTERS].as_mut_array()[lane % WIDTH] = value;
}

/// Over all lanes, in an order that depends on nothing.
#[inline(always)]
pub fn sum(row: &Row) -> f64 {
    ((row[0] + row[1]) + (row[2] + row[3])).reduce_add()
}

/// The numbers of a register whose bits are set in a mask of its own lanes, and 0 for the others.
#[inline(always)]
pub fn only(mask: Mask, numbers: f64x4) -> f64x4 {
    f64x4::new(MASKS[mask as usize % MASKS.len()]) & numbers
}

/// All bits of the lanes that are set in the index.
const MASKS: [[f64; WIDTH]; 1 << WIDTH] = {
    let mut masks = [[0.0; WIDTH]; 1 << WIDTH];
    let mut mask = 0;
    while mask < masks.len() {
        let mut lane = 0;
        while lane < WIDTH {
            if mask >> lane & 1 == 1 {
                masks[mask][lane] = f64::from_bits(u64::MAX);
            }
            lane += 1;
        }
        mask += 1;
    }
    masks
};

/// The part of a mask that is a register's.
#[inline(always)]
pub fn part(mask: Mask, register: usize) -> Mask {
    mask >> (WIDTH * register) & ((1 << WIDTH) - 1)
}

/// Spectra, one for each lane.
#[derive(Clone, Debug)]
pub struct SampledLanes<const C: usize>(pub [Row; C]);

impl<const C: usize> SampledLanes<C> {
    pub const ZERO: Self = Self([ZERO; C]);

    /// The same for all lanes.
    #[inline(always)]
    pub fn splat(value: &Sampled<C>) -> Self {
        let mut all = Self::ZERO;
        for (row, &value) in all.0.iter_mut().zip(&value.0) {
            *row = [f64x4::splat(value); REGISTERS];
        }
        all
    }

    #[inline(always)]
    pub fn get(&self, lane: usize) -> Sampled<C> {
        Sampled::from_fn(|wavelength| get(&self.0[wavelength], lane))
    }

    #[inline(always)]
    pub fn set(&mut self, lane: usize, value: &Sampled<C>) {
        for (row, &value) in self.0.iter_mut().zip(&value.0) {
            set(row, lane, value);
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

    /// Adds own · other · factor, lane by lane.
    #[inline(always)]
    pub fn add_to(&self, other: &Self, factor: &Sampled<C>, total: &mut Self) {
        for wavelength in 0..C {
            let factor = f64x4::splat(factor[wavelength]);
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

    #[test]
    fn lanes_are_what_masks_say() {
        assert_eq!(lanes_of(0b1000_0000_0001_0010).collect::<Vec<_>>(), [1, 4, 15]);
        assert_eq!(lanes_of(0).next(), None);
        assert_eq!(part(0b1000_0000_0001_0010, 1), 1);
        assert_eq!(only(0b1010, f64x4::new([1.0, 2.0, f64::NAN, 4.0])).to_array(), [0.0, 2.0, 0.0, 4.0]);
    }

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
