//! Numbers side by side, of which a processor computes several at once.
//!
//! A formula is written once, for any [`Real`]: one number, or those of a register. No lane sees another, and
//! nothing is fused or approximated, so a lane has the bits that one number would have. Sums over lanes have
//! a fixed order.

mod real;
mod vector;

pub use real::{MOST_INTEGER, Real, Truth, add_to_integers};
pub use vector::{Vec3Lanes, Vector};

/// The numbers of one register: eight where abbe is compiled for AVX-512, else four.
#[cfg(target_feature = "avx512f")]
pub type Register = wide::f64x8;
/// The numbers of one register: eight where abbe is compiled for AVX-512, else four.
#[cfg(not(target_feature = "avx512f"))]
pub type Register = wide::f64x4;

/// Lanes of a row: as many as a group of pixels has members.
pub const LANES: usize = 16;

/// Numbers of one register.
pub const WIDTH: usize = size_of::<Register>() / size_of::<f64>();

/// Registers of a row.
pub const REGISTERS: usize = LANES / WIDTH;

/// One number for each lane.
pub type Row = [Register; REGISTERS];

/// Zero in each lane.
pub const ZERO: Row = [Register::ZERO; REGISTERS];

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
    let mut numbers: [f64; LANES] = std::array::from_fn(|lane| get(row, lane));
    for half in [8, 4, 2, 1] {
        for lane in 0..half {
            numbers[lane] += numbers[lane + half];
        }
    }
    numbers[0]
}

/// The part of a mask that is a register's.
#[inline(always)]
pub fn part(mask: Mask, register: usize) -> Mask {
    mask >> (WIDTH * register) & ((1 << WIDTH) - 1)
}

/// The registers that hold a lane of a mask. Few of the paths that went along are left in the end.
#[inline(always)]
pub fn registers_of(mask: Mask) -> impl Iterator<Item = usize> {
    (0..REGISTERS).filter(move |&register| part(mask, register) != 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_are_what_masks_say() {
        assert_eq!(lanes_of(0b1000_0000_0001_0010).collect::<Vec<_>>(), [1, 4, 15]);
        assert_eq!(lanes_of(0).next(), None);
        let parts =
            (0..REGISTERS).map(|register| part(0b1000_0000_0001_0010, register) << (WIDTH * register));
        assert_eq!(parts.sum::<Mask>(), 0b1000_0000_0001_0010);
    }

    #[test]
    fn sums_are_those_of_halves() {
        let mut row = ZERO;
        (0..LANES).for_each(|lane| set(&mut row, lane, 0.1 * lane as f64));
        let value = |lane: usize| 0.1 * lane as f64;
        let quarter = |lane: usize| (value(lane) + value(lane + 8)) + (value(lane + 4) + value(lane + 12));
        assert_eq!(sum(&row), (quarter(0) + quarter(2)) + (quarter(1) + quarter(3)));
    }
}
