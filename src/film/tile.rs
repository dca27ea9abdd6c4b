use super::BadValues;
use super::extras::{Extras, WEIGHT};
use super::fixed_point::{FixedPoint, SMALL, TOO_LARGE};
use crate::sampling::mix;
use std::ops::Range;

/// Sums over some samples of the pixels of a rectangle, for a run of replicates: work that a thread does by
/// itself before the film gets it.
#[derive(Clone, Debug)]
pub struct Tile {
    /// The upper left pixel, on the film.
    pub(super) corner: [u32; 2],
    pub(super) size: [u32; 2],
    pub(super) replicates: Range<u32>,
    pub(super) channels: usize,
    /// By pixel, replicate and channel.
    pub(super) sums: Vec<i64>,
    /// By pixel.
    pub(super) samples: Vec<u32>,
    /// In [0, 1): decides how small contributions of the sample are rounded.
    rounding: f64,
    /// Values that were left out.
    pub bad: BadValues,
}

impl Tile {
    /// Begins what a sample brings to a pixel. What `key` is made from says which sample and which pixel:
    /// contributions round alike in whatever order they come.
    pub fn begin(&mut self, key: u64) {
        self.rounding = (mix(key) >> 11) as f64 * (0.5 * f64::EPSILON);
    }

    /// Where in the tile a pixel of the film is; `None` where it is outside.
    pub fn place(&self, x: u32, y: u32) -> Option<usize> {
        let [column, row] = [x.wrapping_sub(self.corner[0]), y.wrapping_sub(self.corner[1])];
        (column < self.size[0] && row < self.size[1]).then(|| (row * self.size[0] + column) as usize)
    }

    /// Adds a sample's finite contribution to a channel of a replicate, at a place. One too large for the
    /// fixed point is counted and left out.
    #[inline]
    pub fn add(&mut self, place: usize, replicate: u32, channel: usize, value: f64, scale: FixedPoint) {
        let exact = value * scale.per_quantum;
        let quanta = if exact.abs() >= SMALL || exact == 0.0 {
            exact.round_ties_even()
        } else {
            (exact + self.rounding).floor()
        };
        let of_replicate = place * self.replicates.len() + (replicate - self.replicates.start) as usize;
        let sum = &mut self.sums[of_replicate * self.channels + channel];
        match sum.checked_add(quanta as i64).filter(|_| quanta.abs() < TOO_LARGE) {
            Some(next) => *sum = next,
            None => self.bad.overflow += 1,
        }
    }

    /// Adds the weight that the filter gives a sample.
    #[inline]
    pub fn weigh(&mut self, place: usize, replicate: u32, weight: f64) {
        self.add(place, replicate, WEIGHT, weight, FixedPoint::SHARE);
    }

    /// Number of its pixels.
    pub fn pixel_count(&self) -> usize {
        self.samples.len()
    }

    /// The mean of Y at a place in a replicate, or of all responses where the sensor has its own. Zero
    /// without samples.
    pub fn brightness(&self, place: usize, replicate: u32, scale: FixedPoint, extras: &Extras) -> f64 {
        let of_replicate = place * self.replicates.len() + (replicate - self.replicates.start) as usize;
        let sums = &self.sums[of_replicate * self.channels..][..self.channels];
        let channels = match extras.responses.len() {
            0 => 1..2,
            responses => extras.response_channel(0)..extras.response_channel(responses),
        };
        let weight = sums[WEIGHT] as f64 * FixedPoint::SHARE.quantum;
        let sum = sums[channels].iter().map(|&sum| sum as f64).sum::<f64>() * scale.quantum;
        if weight == 0.0 { 0.0 } else { sum / weight }
    }

    /// Counts further samples of a pixel.
    pub fn count(&mut self, place: usize, samples: u32) {
        self.samples[place] += samples;
    }

    /// What was added since to channels of the only pixel and replicate; then they are empty again.
    pub fn take(&mut self) -> Vec<(u32, i64)> {
        let sums = (0..).zip(&mut self.sums).filter(|(_, sum)| **sum != 0);
        sums.map(|(channel, sum)| (channel, std::mem::take(sum))).collect()
    }
}

impl Extras {
    /// Empty sums for some pixels of a film that measures this, of a run of replicates.
    pub fn tile(&self, corner: [u32; 2], size: [u32; 2], replicates: Range<u32>) -> Tile {
        let (channels, pixels) = (self.channels(), size[0] as usize * size[1] as usize);
        Tile {
            corner,
            size,
            channels,
            sums: vec![0; pixels * replicates.len() * channels],
            replicates,
            samples: vec![0; pixels],
            rounding: 0.0,
            bad: BadValues::default(),
        }
    }
}
