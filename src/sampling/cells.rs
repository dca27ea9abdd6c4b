//! Equal parts of the unit square and of the unit interval: one sample in each, and all in random order.

use super::permutation::permute;
use super::{inside, mix, unit};

/// As many cells of equal area as a sequence has samples, in rows: as square as their number allows. Where it
/// isn't the product of two close numbers, the first rows have a cell more than the others and are higher.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cells {
    count: u32,
    /// Cells of each of the first `longer` rows; the others have one less.
    longest: u32,
    longer: u32,
}

impl Cells {
    pub(super) fn new(count: u32) -> Self {
        let count = count.max(1);
        let root = f64::from(count).sqrt();
        // Rows of equal length where that makes cells at most twice as high as wide.
        let most = (root.floor() as u32).max(1);
        let least = (f64::from(count) / 2.0).sqrt().ceil() as u32;
        let equal = (least..=most).rev().find(|&rows| count.is_multiple_of(rows));
        let rows = equal.unwrap_or((root.round() as u32).max(1));
        let shorter = count / rows;
        Self { count, longest: shorter + 1, longer: count - shorter * rows }
    }

    /// A point of the `cell`-th cell: its edges are at 0 and 1 of `within`.
    fn point(self, cell: u32, within: [f64; 2]) -> [f64; 2] {
        let in_longer = self.longer * self.longest;
        let (row_start, length) = if cell < in_longer {
            (cell - cell % self.longest, self.longest)
        } else {
            let length = self.longest - 1;
            (cell - (cell - in_longer) % length, length)
        };
        let count = f64::from(self.count);
        let [column, row_start, length] = [cell - row_start, row_start, length].map(f64::from);
        [inside((column + within[0]) / length), inside((row_start + length * within[1]) / count)]
    }

    /// A point of the `slice`-th of equal parts of the interval: its ends are at 0 and 1 of `within`.
    fn slice(self, slice: u32, within: f64) -> f64 {
        inside((f64::from(slice) + within) / f64::from(self.count))
    }

    /// The centres of cells and slices, in an order that `key` gives.
    pub(super) fn centres(self, index: u32, key: u64) -> [f64; 4] {
        let keys = Keys::new(key);
        let [x, y] = self.point(permute(index, self.count, keys.pair), [0.5; 2]);
        let [z, w] = keys.slices.map(|key| self.slice(permute(index, self.count, key), 0.5));
        [x, y, z, w]
    }

    /// Uniform in cells and slices, in an order that `key` gives: the prototype pattern of Cook (1986,
    /// section 6.1), drawn anew for each set of each pixel.
    pub(super) fn jittered(self, index: u32, key: u64) -> [f64; 4] {
        let keys = Keys::new(key);
        let position = keys.within(index, 0).map(unit);
        let [x, y] = self.point(permute(index, self.count, keys.pair), position);
        let [z, w] = self.slices(index, &keys);
        [x, y, z, w]
    }

    /// Uniform in a slice of each of the last two dimensions.
    pub(super) fn slices(self, index: u32, keys: &Keys) -> [f64; 2] {
        let [z, w] = keys.within(index, 1).map(unit);
        let [slice_z, slice_w] = keys.slices.map(|key| permute(index, self.count, key));
        [self.slice(slice_z, z), self.slice(slice_w, w)]
    }
}

/// What is random in a set of a sequence.
pub(super) struct Keys {
    within: u64,
    /// Order of the cells of the pair.
    pub(super) pair: u64,
    /// Order of the slices of the last two dimensions.
    slices: [u64; 2],
}

impl Keys {
    pub(super) fn new(key: u64) -> Self {
        let pair = mix(key);
        let third = mix(pair);
        Self { within: key, pair, slices: [third, mix(third)] }
    }

    /// Two random words of a sample.
    fn within(&self, index: u32, which: u64) -> [u32; 2] {
        let bits = mix(self.within ^ (u64::from(index) << 1 | which).wrapping_mul(0xD6E8_FEB8_6659_FD93));
        [bits as u32, (bits >> 32) as u32]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Any number of cells: each has the same area, they cover the square, and none is worse than 2:1 from
    /// four on.
    #[test]
    fn cells_have_equal_areas_and_cover_the_square() {
        for count in (1..300).chain([1000, 1009, 4096, 4097]) {
            let cells = Cells::new(count);
            let mut total = 0.0;
            for cell in 0..count {
                let [left, top] = cells.point(cell, [0.0; 2]);
                let [right, bottom] = cells.point(cell, [1.0; 2]);
                let (width, height) = (right - left, bottom - top);
                assert!((width * height * f64::from(count) - 1.0).abs() < 1e-10, "{cell} of {count}");
                let squareness = (width / height).max(height / width);
                assert!(count < 4 || squareness < 2.01, "{count}: {squareness}");
                total += width * height;
            }
            assert!((total - 1.0).abs() < 1e-10);
        }
        // Squares where the number is one.
        let [x, y] = Cells::new(16).point(5, [0.0; 2]);
        assert!((x - 0.25).abs() + (y - 0.25).abs() < 1e-15, "{x} {y}");
    }

    #[test]
    fn one_sample_falls_in_each_cell_and_each_slice() {
        for count in [1u32, 2, 5, 16, 17, 64, 100] {
            let cells = Cells::new(count);
            for key in 0..20 {
                let mut seen = [const { Vec::new() }; 3];
                for index in 0..count {
                    let sample = cells.jittered(index, mix(key));
                    let cell = (0..count)
                        .position(|cell| {
                            let [low, high] = [[0.0; 2], [1.0; 2]].map(|corner| cells.point(cell, corner));
                            (0..2).all(|axis| low[axis] <= sample[axis] && sample[axis] < high[axis])
                        })
                        .expect("the cells cover the square");
                    let slice = |value: f64| (value * f64::from(count)) as usize;
                    let cells = [cell, slice(sample[2]), slice(sample[3])];
                    seen.iter_mut().zip(cells).for_each(|(seen, cell)| seen.push(cell));
                }
                for mut seen in seen {
                    seen.sort();
                    assert!(seen.into_iter().eq(0..count as usize), "{count} samples, key {key}");
                }
            }
        }
    }
}
