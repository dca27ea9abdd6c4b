//! Independent random numbers: one PCG generator for each path, four numbers of it for each set.

use rand::Rng;
use rand_pcg::Pcg32;

/// The four words of set `set` for the path that `key` stands for.
///
/// Sets are stretches of one sequence. Streams of their own would not do: PCG's streams from one state
/// are visibly correlated (z = 14 in the test of dimensions).
pub(super) fn draw(key: u64, set: u32) -> [u32; 4] {
    let mut generator = Pcg32::new(key, 0);
    generator.advance(4 * u64::from(set));
    std::array::from_fn(|_| generator.next_u32())
}
