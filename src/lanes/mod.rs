//! Numbers side by side, of which a processor computes several at once.
//!
//! A formula is written once, for any [`Real`]: one number, or those of a register. No lane sees another, and
//! nothing is fused or approximated, so a lane has the bits that one number would have. Sums over lanes have
//! a fixed order.

mod real;
mod vector;

pub use real::{MOST_INTEGER, Real, Truth, integers};
pub use vector::{Vec3Lanes, Vector};

use wide::f64x4;

/// Numbers of one register.
pub const WIDTH: usize = 4;

/// Registers of a row.
pub const REGISTERS: usize = 4;

/// Lanes of a row: as many as a group of pixels has members.
pub const LANES: usize = WIDTH * REGISTERS;

/// One number for each lane.
pub type Row = [f64x4; REGISTERS];

/// Zero in each lane.
pub const ZERO: Row = [f64x4::ZERO; REGISTERS];

/// A bit for each lane.
pub type Mask = u32;

/// All lanes.
pub const ALL: Mask = (1 << LANES) - 1;

/// The mask of some lanes.
#[inline]
pub fn mask_of(lanes: impl Iterator<Item = usize>) -> Mask {
    lanes.fold(0, |mask, lane| mask | 1 << lane)
}

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

/// The number of one lane.
#[inline(always)]
pub fn get(row: &Row, lane: usize) -> f64 {
    row[lane / WIDTH % REGISTERS].as_array()[lane % WIDTH]
}

/// Puts a number into one lane.
#[inline(always)]
pub fn set(row: &mut Row, lane: usize, value: f64) {
    row[lane / WIDTH % REGISTERS].as_mut_array()[lane % WIDTH] = value;
}

/// Over all lanes, in an order that depends on nothing.
#[inline(always)]
pub fn sum(row: &Row) -> f64 {
    ((row[0] + row[1]) + (row[2] + row[3])).reduce_add()
}

/// The part of a mask that is a register's.
#[inline(always)]
pub fn part(mask: Mask, register: usize) -> Mask {
    mask >> (WIDTH * register) & ((1 << WIDTH) - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_are_what_masks_say() {
        assert_eq!(lanes_of(0b1000_0000_0001_0010).collect::<Vec<_>>(), [1, 4, 15]);
        assert_eq!(lanes_of(0).next(), None);
        assert_eq!(part(0b1000_0000_0001_0010, 1), 1);
    }
}
