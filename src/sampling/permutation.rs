//! Random permutations whose values are computed one at a time.

use super::mix;

/// Rounds of mixing. With fewer, the permutations of up to six elements are visibly unequally likely.
const ROUNDS: usize = 6;

/// Where the random permutation of 0..`count` that `key` stands for puts `index`, which must be below
/// `count`.
///
/// A bijection of the next power of two (additions, odd factors, shifted copies, some of them under a random
/// mask, without which few permutations of small sets could arise), repeated until it lands inside: the
/// construction of Kensler, "Correlated multi-jittered sampling" (Pixar technical memo 13-01, 2013).
pub(super) fn permute(index: u32, count: u32, key: u64) -> u32 {
    if count < 2 {
        return 0;
    }
    let mask = u32::MAX >> (count - 1).leading_zeros();
    let half = (mask.count_ones() / 2).max(1);
    let low = mix(key);
    let high = mix(low);
    let words = [low as u32, (low >> 32) as u32, high as u32, (high >> 32) as u32];
    let mut x = index;
    loop {
        for round in 0..ROUNDS {
            let term = words[round % 4].rotate_left(7 * (round as u32 / 4));
            let factor = words[(round + 1) % 4].rotate_left(13) | 1;
            x = x.wrapping_add(term).wrapping_mul(factor) & mask;
            x ^= (x >> 1) & (term >> 16);
            x ^= x >> half;
        }
        if x < count {
            return x;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::{chi_square, sidak};

    #[test]
    fn every_value_is_taken_once() {
        for count in [1, 2, 3, 7, 16, 100, 1000, 4097] {
            for key in 0..5 {
                let mut seen = vec![false; count as usize];
                (0..count).for_each(|index| seen[permute(index, count, key) as usize] = true);
                assert!(seen.iter().all(|&seen| seen), "{count}, key {key}");
            }
        }
        assert!(permute(u32::MAX - 1, u32::MAX, 1) < u32::MAX);
    }

    /// Where the first and the last element land together: every ordered pair is as likely as any other.
    #[test]
    fn pairs_are_equally_likely() {
        let counts = [2u32, 3, 4, 5, 6, 8, 9, 13, 16];
        for count in counts {
            let keys = 100_000u64;
            let mut observed = vec![0.0; (count * count) as usize];
            for key in 0..keys {
                let [first, last] = [0, count - 1].map(|index| permute(index, count, mix(key)));
                observed[(first * count + last) as usize] += 1.0;
            }
            let expected: Vec<f64> = (0..count * count)
                .map(|cell| if cell / count == cell % count { 0.0 } else { keys as f64 })
                .map(|keys| keys / f64::from(count * (count - 1)))
                .collect();
            let fit = chi_square(&observed, &expected);
            assert!(fit.p_value > sidak(1e-3, counts.len()), "{count}: {fit}");
        }
    }
}
