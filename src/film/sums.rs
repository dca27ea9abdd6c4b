use super::bins::{Integers, Storage};
use super::extras::Extras;
use std::ops::Range;

/// The sums of a film. Spectral bins are apart from the other channels, which are needed more often.
#[derive(Debug)]
pub(super) struct Sums {
    /// Channels before the spectral bins.
    pub(super) first: usize,
    pub(super) bin_count: usize,
    /// By pixel, replicate and channel.
    pub(super) of_first: Vec<i64>,
    /// Likewise.
    pub(super) of_bins: Integers,
}

impl Sums {
    /// Zeros, for a number of replicates of pixels.
    pub(super) fn new(cells: usize, extras: &Extras, storage: Storage) -> std::io::Result<Self> {
        let (first, bin_count) = (extras.bin_channel(0), extras.bin_count());
        let of_bins = Integers::new(cells * bin_count, storage)?;
        Ok(Self { first, bin_count, of_first: vec![0; cells * first], of_bins })
    }

    /// That of a channel, in a cell: a replicate of a pixel.
    pub(super) fn of(&self, cell: usize, channel: usize) -> i64 {
        match channel.checked_sub(self.first) {
            None => self.of_first[cell * self.first + channel],
            Some(bin) => self.of_bins[cell * self.bin_count + bin],
        }
    }

    /// Those of all channels of some cells, one after another.
    pub(super) fn of_all(&self, cells: Range<usize>) -> Vec<i64> {
        self.of_bins.uses(cells.len() * self.bin_count);
        let of_cell = |cell: usize| {
            let bins = &self.of_bins[cell * self.bin_count..][..self.bin_count];
            self.of_first[cell * self.first..][..self.first].iter().chain(bins).copied()
        };
        cells.flat_map(of_cell).collect()
    }

    /// Adds to a channel of a cell. Whether the sum would have left the range: it stays.
    pub(super) fn add_to(&mut self, cell: usize, channel: usize, value: i64) -> bool {
        let own = match channel.checked_sub(self.first) {
            None => &mut self.of_first[cell * self.first + channel],
            Some(bin) => &mut self.of_bins[cell * self.bin_count + bin],
        };
        let (next, is_lost) = own.overflowing_add(value);
        if !is_lost {
            *own = next;
        }
        is_lost
    }

    /// Adds to all channels of cells from one on. How many sums would have left the range: they stay.
    pub(super) fn add(&mut self, cell: usize, sums: &[i64]) -> u64 {
        let mut overflow = 0;
        let mut add = |own: &mut [i64], more: &[i64]| {
            for (own, &more) in own.iter_mut().zip(more) {
                let (next, is_lost) = own.overflowing_add(more);
                *own = if is_lost { *own } else { next };
                overflow += u64::from(is_lost);
            }
        };
        for (cell, sums) in (cell..).zip(sums.chunks_exact(self.first + self.bin_count)) {
            let (first, bins) = sums.split_at(self.first);
            add(&mut self.of_first[cell * self.first..][..self.first], first);
            add(&mut self.of_bins[cell * self.bin_count..][..self.bin_count], bins);
        }
        overflow
    }
}
