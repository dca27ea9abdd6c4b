//! Owen-scrambled Sobol points in sets of four dimensions.
//!
//! Sets are padded: each takes the same four Sobol dimensions with its own scrambling and its own
//! shuffling of the index (Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4), 2020). Every aligned
//! run of 2ᵏ indices is therefore perfectly stratified in each dimension and in the pair (0, 1), for up
//! to 2³² points.

/// Primitive polynomials and initial direction numbers of the dimensions after the first as (degree, inner coefficients,
/// m₁ …): Joe and Kuo, "Constructing Sobol sequences with better two-dimensional projections", SIAM
/// J. Sci. Comput. 30, 2008 (file new-joe-kuo-6.21201). Dimension 1 is the van der Corput sequence.
const POLYNOMIALS: [(usize, u32, [u32; 7]); 31] = [
    (1, 0, [1, 0, 0, 0, 0, 0, 0]),
    (2, 1, [1, 3, 0, 0, 0, 0, 0]),
    (3, 1, [1, 3, 1, 0, 0, 0, 0]),
    (3, 2, [1, 1, 1, 0, 0, 0, 0]),
    (4, 1, [1, 1, 3, 3, 0, 0, 0]),
    (4, 4, [1, 3, 5, 13, 0, 0, 0]),
    (5, 2, [1, 1, 5, 5, 17, 0, 0]),
    (5, 4, [1, 1, 5, 5, 5, 0, 0]),
    (5, 7, [1, 1, 7, 11, 19, 0, 0]),
    (5, 11, [1, 1, 5, 1, 1, 0, 0]),
    (5, 13, [1, 1, 1, 3, 11, 0, 0]),
    (5, 14, [1, 3, 5, 5, 31, 0, 0]),
    (6, 1, [1, 3, 3, 9, 7, 49, 0]),
    (6, 13, [1, 1, 1, 15, 21, 21, 0]),
    (6, 16, [1, 3, 1, 13, 27, 49, 0]),
    (6, 19, [1, 1, 1, 15, 7, 5, 0]),
    (6, 22, [1, 3, 1, 15, 13, 25, 0]),
    (6, 25, [1, 1, 5, 5, 19, 61, 0]),
    (7, 1, [1, 3, 7, 11, 23, 15, 103]),
    (7, 4, [1, 3, 7, 13, 13, 15, 69]),
    (7, 7, [1, 1, 3, 13, 7, 35, 63]),
    (7, 8, [1, 3, 5, 9, 1, 25, 53]),
    (7, 14, [1, 3, 1, 13, 9, 35, 107]),
    (7, 19, [1, 3, 1, 5, 27, 61, 31]),
    (7, 21, [1, 1, 5, 11, 19, 41, 61]),
    (7, 28, [1, 3, 5, 3, 3, 13, 69]),
    (7, 31, [1, 1, 7, 13, 1, 19, 1]),
    (7, 32, [1, 3, 7, 5, 13, 19, 59]),
    (7, 37, [1, 1, 3, 9, 25, 29, 41]),
    (7, 41, [1, 3, 5, 13, 23, 1, 55]),
    (7, 42, [1, 3, 7, 3, 13, 59, 17]),
];

/// Sets of four dimensions that one sequence has.
pub(super) const SETS: usize = 8;

/// Which dimension of the sequence a set's value is: four sets share sixteen, of which the first eight, which are spread best
/// together, go to their first pairs (positions on the film, on lights and lenses, directions).
const fn dimension(set: usize, column: usize) -> usize {
    let (group, place) = (set / 4, set % 4);
    16 * group + if column < 2 { 2 * place + column } else { 6 + 2 * place + column }
}

/// The direction numbers of a set of four dimensions, most significant bit first.
const fn directions(set: usize) -> [[u32; 4]; 32] {
    let mut v = [[0u32; 4]; 32];
    let mut column = 0;
    while column < 4 {
        let dimension = dimension(set, column);
        let mut i = 0;
        while i < 32 {
            if dimension == 0 {
                v[i][column] = 1 << (31 - i);
            } else {
                let (degree, coefficients, initial) = POLYNOMIALS[dimension - 1];
                if i < degree {
                    v[i][column] = initial[i] << (31 - i);
                } else {
                    let mut next = v[i - degree][column] ^ (v[i - degree][column] >> degree);
                    let mut k = 1;
                    while k < degree {
                        if coefficients >> (degree - 1 - k) & 1 == 1 {
                            next ^= v[i - k][column];
                        }
                        k += 1;
                    }
                    v[i][column] = next;
                }
            }
            i += 1;
        }
        column += 1;
    }
    v
}

/// For each set and each byte of the index, the four dimensions' sum of direction numbers over its set bits.
static BY_BYTE: [[[[u32; 4]; 256]; 4]; SETS] = {
    let mut table = [[[[0u32; 4]; 256]; 4]; SETS];
    let mut set = 0;
    while set < SETS {
        let v = directions(set);
        let mut byte = 0;
        while byte < 4 {
            let mut value = 1;
            while value < 256 {
                // All but the lowest set bit, and that.
                let rest = table[set][byte][value & (value - 1)];
                let bit = (value as u32).trailing_zeros() as usize;
                let mut column = 0;
                while column < 4 {
                    table[set][byte][value][column] = rest[column] ^ v[8 * byte + bit][column];
                    column += 1;
                }
                value += 1;
            }
            byte += 1;
        }
        set += 1;
    }
    table
};

/// The `index`-th Sobol point's values in a set as binary fractions, unscrambled.
fn point(index: u32, set: usize) -> [u32; 4] {
    let table = &BY_BYTE[set];
    let mut bits = table[0][index as usize & 255];
    let (mut rest, mut byte) = (index >> 8, 1);
    // Few sequences are longer than 256 or 65,536 points.
    while rest != 0 {
        for (bits, row) in bits.iter_mut().zip(table[byte][rest as usize & 255]) {
            *bits ^= row;
        }
        rest >>= 8;
        byte += 1;
    }
    bits
}

/// Owen scrambling by a hash in which each bit depends on the bits above it alone (after Laine and Karras;
/// this form and its constants by Vegdahl, "Building a Better LK Hash", 2021). Flips each bit of a
/// binary fraction depending on the more significant ones, so strata stay strata.
fn owen(fraction: u32, seed: u32) -> u32 {
    let mut x = fraction.reverse_bits();
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x.reverse_bits()
}

/// The `index`-th point's values in a set, of a sequence of 2 to the power of `length` points.
///
/// The sets of a sequence have the order of its points in common, for which `order` stands, and each its own scrambling, for
/// which `key` stands.
pub(super) fn scrambled(index: u32, length: u32, order: u64, set: usize, key: u64) -> [u32; 4] {
    // What is above the sequence's own bits is the same for all of them: another aligned run, no better than the first.
    let within = u32::MAX.checked_shl(length).map_or(u32::MAX, |above| !above);
    of_shuffled(owen(index, order as u32) & within, set, key)
}

/// The point of that number in the scrambled sequence that `key` stands for, without shuffling.
pub(super) fn of_shuffled(index: u32, set: usize, key: u64) -> [u32; 4] {
    let mut bits = point(index, set);
    let seeds = [super::mix(key ^ 1), super::mix(key ^ 2)];
    let seeds = [seeds[0] as u32, (seeds[0] >> 32) as u32, seeds[1] as u32, (seeds[1] >> 32) as u32];
    for (bits, seed) in bits.iter_mut().zip(seeds) {
        *bits = owen(*bits, seed);
    }
    bits
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dimensions_begin_as_published() {
        // The first eight points of the Sobol sequence in eighths (Joe and Kuo's own example program).
        let eighths = |dimension: usize| (0..8).map(move |i| point(i)[dimension] >> 29).collect::<Vec<_>>();
        let sorted = |mut v: Vec<u32>| {
            v.sort();
            v
        };
        assert_eq!(eighths(0), [0, 4, 2, 6, 1, 5, 3, 7]);
        assert_eq!(eighths(1), [0, 4, 6, 2, 5, 1, 3, 7]);
        for dimension in 2..4 {
            assert_eq!(sorted(eighths(dimension)), [0, 1, 2, 3, 4, 5, 6, 7]);
        }
    }

    #[test]
    fn every_aligned_run_is_stratified_in_each_dimension_and_in_the_first_pair() {
        for key in 0..20u64 {
            for start in [0u32, 256, 1 << 20] {
                let points: Vec<_> =
                    (start..start + 256).map(|i| scrambled(i, super::super::mix(key))).collect();
                for dimension in 0..4 {
                    let mut seen = [false; 256];
                    points.iter().for_each(|p| seen[(p[dimension] >> 24) as usize] = true);
                    assert!(seen.iter().all(|&s| s), "dimension {dimension}");
                }
                for rows in 0..=8 {
                    let mut seen = [false; 256];
                    for p in &points {
                        let row = (u64::from(p[0]) >> (32 - rows)) as usize;
                        let column = (u64::from(p[1]) >> (24 + rows)) as usize;
                        seen[row << (8 - rows) | column] = true;
                    }
                    assert!(seen.iter().all(|&s| s), "{rows} bits of the first dimension");
                }
            }
        }
    }

    #[test]
    fn works_past_two_to_the_sixteen() {
        // The mean of a smooth function over 2^17 points is closer than independent points could make it.
        let n = 1u32 << 17;
        let mean: f64 = (0..n).map(|i| f64::from(scrambled(i, 77)[1]).powi(2)).sum::<f64>()
            / f64::from(n)
            / 4_294_967_296f64.powi(2);
        assert!((mean - 1.0 / 3.0).abs() < 1e-7, "{mean}");
    }
}
