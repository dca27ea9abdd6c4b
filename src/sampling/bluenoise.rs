//! Owen-scrambled Sobol points dealt over the picture so that the error of neighbouring pixels differs in
//! sign: it is arranged as blue noise, which the eye and any blur forgive most.
//!
//! The pixels of a block share one sequence, each a run of it, in the order of a Morton curve whose quads are
//! shuffled at every level, differently in every set of dimensions (Ahmed and Wonka, "Screen-space blue-noise
//! diffusion of Monte Carlo sampling error via hierarchical ordering of pixels", ACM TOG 39(6), 2020; the
//! shuffling by a hash of the higher digits as in Pharr, Jakob, Humphreys, "Physically based rendering", 4th
//! ed., 8.7.4). Each pixel's run is as well stratified as any of a Sobol sequence; runs of neighbours
//! complete each other.

use super::sobol::Role;
use super::{mix, sobol};

/// Largest edge of a block that shares a sequence, as a power of two: pixels.
const LARGEST_BLOCK: u32 = 8;

/// The 24 orders of four things.
const ORDERS: [[u8; 4]; 24] = {
    let mut orders = [[0; 4]; 24];
    let mut found = 0;
    let mut code = 0u32;
    while code < 256 {
        let order = [code & 3, code >> 2 & 3, code >> 4 & 3, code >> 6];
        if 1 << order[0] | 1 << order[1] | 1 << order[2] | 1 << order[3] == 15 {
            orders[found] = [order[0] as u8, order[1] as u8, order[2] as u8, order[3] as u8];
            found += 1;
        }
        code += 1;
    }
    orders
};

/// How blocks of pixels and the samples of a pixel share the 32 bits of an index.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    /// Bits of the samples of a pixel, of which there are up to 2 to this power.
    sample_bits: u32,
    /// The edge of a block is 2 to this power, pixels.
    block_bits: u32,
}

impl Layout {
    pub(super) fn new(samples: u32) -> Self {
        let sample_bits = u32::BITS - samples.max(1).saturating_sub(1).leading_zeros();
        Self { sample_bits, block_bits: LARGEST_BLOCK.min((u32::BITS - sample_bits) / 2) }
    }

    /// Which block a pixel is in.
    pub(super) fn block(self, pixel: [u32; 2]) -> [u32; 2] {
        pixel.map(|p| p >> self.block_bits)
    }

    /// The index of a pixel's sample in its block's sequence, before any shuffling.
    pub(super) fn index(self, pixel: [u32; 2], sample: u32) -> u32 {
        let mask = (1 << self.block_bits) - 1;
        let [x, y] = pixel.map(|p| spread(p & mask));
        // A shift by all the 32 bits is that of a pixel alone in its block.
        (x | y << 1).checked_shl(self.sample_bits).unwrap_or(0) | sample
    }

    /// The sample of the set that `key` stands for.
    pub(super) fn sample(self, index: u32, order: u64, role: Role, key: u64) -> [u32; 4] {
        sobol::of_shuffled(self.shuffled(index, mix(order)).reverse_bits(), role, key)
    }

    /// Exchanges the quads at every level, at random but alike for all that a quad holds. The last digit is a
    /// binary one where the number of samples is an odd power of two.
    fn shuffled(self, index: u32, key: u64) -> u32 {
        let odd = self.sample_bits & 1;
        let digits = (self.sample_bits + 2 * self.block_bits) / 2;
        let mut shuffled = 0;
        for level in 0..digits {
            let shift = 2 * level + odd;
            let above = (u64::from(index) >> (shift + 2)) << 6 | u64::from(level);
            let choice = ((mix(key ^ above) >> 32) * 24) >> 32;
            let digit = index >> shift & 3;
            shuffled |= u32::from(ORDERS[choice as usize][digit as usize]) << shift;
        }
        if odd == 1 {
            let above = u64::from(index >> 1) << 6 | 63;
            shuffled |= (index ^ mix(key ^ above) as u32) & 1;
        }
        shuffled
    }
}

/// Puts a zero above each bit of a number of up to 16 bits.
fn spread(bits: u32) -> u32 {
    let bits = (bits | bits << 8) & 0x00FF_00FF;
    let bits = (bits | bits << 4) & 0x0F0F_0F0F;
    let bits = (bits | bits << 2) & 0x3333_3333;
    (bits | bits << 1) & 0x5555_5555
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a pixel takes, and what any aligned square of pixels takes together, is one whole aligned run.
    #[test]
    fn aligned_squares_of_pixels_take_whole_runs() {
        for samples in [1u32, 2, 4, 8, 32] {
            let layout = Layout::new(samples);
            for key in 0..10 {
                for edge in [1u32, 2, 4] {
                    let mut taken: Vec<u32> = (0..edge * edge)
                        .flat_map(|p| {
                            let pixel = [8 + p % edge, 12 + p / edge];
                            (0..samples)
                                .map(move |sample| layout.shuffled(layout.index(pixel, sample), mix(key)))
                        })
                        .collect();
                    taken.sort();
                    let first = taken[0];
                    assert_eq!(first % (edge * edge * samples), 0);
                    assert!(taken.into_iter().eq(first..first + edge * edge * samples));
                }
            }
        }
    }

    #[test]
    fn there_is_room_for_any_number_of_samples() {
        for samples in [0, 1, 3, 1 << 16, (1 << 16) + 1, 1 << 31, u32::MAX] {
            let layout = Layout::new(samples);
            assert!(layout.sample_bits + 2 * layout.block_bits <= 32, "{samples}");
            let last = samples.saturating_sub(1);
            layout.sample(layout.index([1000, 70_000], last), 5, Role::Lens, 6);
        }
    }
}
