use super::BadValues;
use super::extras::{Extras, WEIGHT};
use super::filter::Footprint;
use super::fixed_point::{FixedPoint, TOO_LARGE};
use crate::lanes::{MOST_INTEGER, Real, add_to_integers};
use smallvec::SmallVec;
use std::ops::Range;
use wide::f64x4;

/// Sums over some samples of the pixels of a rectangle, for a run of replicates: work that a thread does by
/// itself before the film gets it.
#[derive(Clone, Debug)]
pub struct Tile {
    /// The upper left pixel, on the film.
    pub(super) corner: [u32; 2],
    pub(super) size: [u32; 2],
    pub(super) replicates: Range<u32>,
    pub(super) channels: usize,
    /// By replicate, pixel and channel: the samples of one replicate come one after another, and the sums of
    /// all replicates do not fit into the nearest cache.
    sums: Vec<i64>,
    /// By pixel.
    pub(super) samples: Vec<u32>,
    /// From -½ up to ½: added to the sample's contributions before they are rounded to the nearest integer.
    rounding: f64,
    /// Values that were left out.
    pub bad: BadValues,
}

/// X, Y and Z of a sample and 1, in quanta.
#[derive(Clone, Copy, Debug)]
pub struct Tristimulus(f64x4);

impl Tristimulus {
    /// What a sample measures that finds nothing.
    pub const BLACK: Self = Self(f64x4::new([0.0, 0.0, 0.0, FixedPoint::SHARE.per_quantum]));

    /// Takes finite X, Y and Z.
    pub fn new([x, y, z]: [f64; 3], scale: FixedPoint) -> Self {
        let [x, y, z] = [x, y, z].map(|value| value * scale.per_quantum);
        Self(f64x4::new([x, y, z, FixedPoint::SHARE.per_quantum]))
    }
}

/// What a sample brings to the pixels of its footprint.
#[derive(Clone, Copy, Debug)]
pub struct FilmSample {
    /// X, Y and Z.
    pub measured: Tristimulus,
    /// Which replicate it is part of.
    pub replicate: u32,
    /// What it counts beside other samples of its pixel.
    pub share: f64,
    /// Stands for the sample, and is as good as random.
    pub key: u64,
}

/// Steps from one column, and from one row, to the next, in 2⁻⁶⁴: 1/g and 1/g², where g³ = g + 1.
const PER_COLUMN: u64 = 0xc13f_a9a9_02a6_328f;
const PER_ROW: u64 = 0x91e1_0da5_c79e_7b1d;

/// Evenly distributed bits as a number from -½ up to ½.
#[inline(always)]
fn rounding_of(bits: u64) -> f64 {
    f64::from_bits(1.0_f64.to_bits() | bits >> 12) - 1.5
}

impl Tile {
    /// Begins what a sample brings to a pixel of the film, by column and row. `sample` stands for the sample,
    /// and is as good as random: contributions round alike in whatever order they come. The pixels of one
    /// sample have values that are spread evenly (Roberts, "The unreasonable effectiveness of quasirandom
    /// sequences", 2018).
    #[inline(always)]
    pub fn begin(&mut self, sample: u64, [column, row]: [i64; 2]) {
        let along = (column as u64).wrapping_mul(PER_COLUMN);
        let down = (row as u64).wrapping_mul(PER_ROW);
        self.rounding = rounding_of(sample.wrapping_add(down).wrapping_add(along));
    }

    /// The part of a footprint that lies in the tile: the ranges of its columns and of its rows, and the
    /// place of its first pixel, which may lie outside. `corner`: of the measured part, in the whole film.
    #[inline(always)]
    fn inside(&self, footprint: &Footprint, corner: [u32; 2]) -> ([Range<usize>; 2], i64) {
        let first: [i64; 2] = std::array::from_fn(|axis| {
            footprint.first[axis] - i64::from(corner[axis]) - i64::from(self.corner[axis])
        });
        let range = |axis: usize, weights: &[f64]| {
            let within = |number: i64| (number - first[axis]).clamp(0, weights.len() as i64) as usize;
            within(0)..within(i64::from(self.size[axis]))
        };
        let ranges = [range(0, &footprint.columns), range(1, &footprint.rows)];
        (ranges, first[1] * i64::from(self.size[0]) + first[0])
    }

    /// Adds a sample's X, Y and Z, and 1, to all pixels that its footprint reaches, times what it weighs them
    /// with: what [`Self::add`] does of each. `corner`: of the measured part, in the whole film.
    #[inline(always)]
    pub fn splat(&mut self, footprint: &Footprint, sample: &FilmSample, corner: [u32; 2]) {
        self.visit(footprint, sample, corner, |tile, place, weight| {
            tile.add_weighed(place, sample.replicate, &sample.measured, weight);
        });
    }

    /// Visits the places in the tile that a footprint reaches, each with the sample's weight there. `corner`:
    /// of the measured part, in the whole film.
    #[inline(always)]
    pub fn visit(
        &mut self,
        footprint: &Footprint,
        sample: &FilmSample,
        corner: [u32; 2],
        mut add: impl FnMut(&mut Self, usize, f64),
    ) {
        let ([columns, rows], first) = self.inside(footprint, corner);
        let width = i64::from(self.size[0]);
        for row in rows {
            for column in columns.clone() {
                let [x, y] = [column, row].map(|number| number as i64);
                self.begin(sample.key, [footprint.first[0] + x, footprint.first[1] + y]);
                let weight = footprint.columns[column] * (footprint.rows[row] * sample.share);
                add(self, (first + y * width + x) as usize, weight);
            }
        }
    }

    /// Where in the tile a pixel of the film is; `None` where it is outside.
    pub fn place(&self, x: u32, y: u32) -> Option<usize> {
        let [column, row] = [x.wrapping_sub(self.corner[0]), y.wrapping_sub(self.corner[1])];
        (column < self.size[0] && row < self.size[1]).then(|| (row * self.size[0] + column) as usize)
    }

    /// Where the sums of a place in a replicate begin.
    #[inline]
    fn first(&self, place: usize, replicate: u32) -> usize {
        let of_replicate = (replicate - self.replicates.start) as usize * self.samples.len();
        (of_replicate + place) * self.channels
    }

    /// The sums of all channels at a place in a replicate.
    #[inline]
    pub(super) fn of(&self, place: usize, replicate: u32) -> &[i64] {
        &self.sums[self.first(place, replicate)..][..self.channels]
    }

    /// Adds a sample's finite contribution to a channel of a replicate, at a place. One too large for the
    /// fixed point is counted and left out.
    #[inline]
    pub fn add(&mut self, place: usize, replicate: u32, channel: usize, value: f64, scale: FixedPoint) {
        self.add_quanta(place, replicate, channel, value * scale.per_quantum);
    }

    #[inline]
    fn add_quanta(&mut self, place: usize, replicate: u32, channel: usize, exact: f64) {
        let quanta = (exact + self.rounding).round_ties_even();
        let index = self.first(place, replicate) + channel;
        let sum = &mut self.sums[index];
        match sum.checked_add(quanta as i64).filter(|_| quanta.abs() < TOO_LARGE) {
            Some(next) => *sum = next,
            None => self.bad.overflow += 1,
        }
    }

    /// Adds a sample's finite X, Y and Z, times the weight that the filter gives the sample, and that weight:
    /// what [`Self::add`] does of each, all four at once.
    #[inline]
    pub fn add_weighed(&mut self, place: usize, replicate: u32, measured: &Tristimulus, weight: f64) {
        let exact = measured.0 * f64x4::splat(weight);
        let offset = exact + f64x4::splat(self.rounding);
        let fits = offset.abs().lt(f64x4::splat(MOST_INTEGER)).mask() == 0b1111;
        let first = self.first(place, replicate);
        let Some(sums) = self.sums[first..].first_chunk_mut::<4>() else { return };
        if fits && let Some(next) = add_to_integers(*sums, offset) {
            *sums = next;
            return;
        }
        let exact = exact.to_array();
        for (channel, exact) in exact.into_iter().enumerate() {
            self.add_quanta(place, replicate, channel, exact);
        }
    }

    /// Number of its pixels.
    pub fn pixel_count(&self) -> usize {
        self.samples.len()
    }

    /// The mean of Y at a place in a replicate, or of all responses where the sensor has its own. Zero
    /// without samples.
    pub fn brightness(&self, place: usize, replicate: u32, scale: FixedPoint, extras: &Extras) -> f64 {
        self.mean(place, replicate, scale, extras.of_brightness())
    }

    /// The sum of the means of some channels at a place in a replicate; X, Y and Z are the first three. Zero
    /// without samples.
    pub fn mean(&self, place: usize, replicate: u32, scale: FixedPoint, channels: Range<usize>) -> f64 {
        let sums = self.of(place, replicate);
        let weight = sums[WEIGHT] as f64 * FixedPoint::SHARE.quantum;
        let sum = sums[channels].iter().map(|&sum| sum as f64).sum::<f64>() * scale.quantum;
        if weight == 0.0 { 0.0 } else { sum / weight }
    }

    /// Whether samples of a pixel have been counted.
    pub fn is_sampled(&self, place: usize) -> bool {
        self.samples[place] > 0
    }

    /// Counts further samples of a pixel.
    pub fn count(&mut self, place: usize, samples: u32) {
        self.samples[place] += samples;
    }

    /// What was added since to channels of the only pixel and replicate; then they are empty again.
    pub fn take(&mut self) -> Taken {
        let sums = (0..).zip(&mut self.sums).filter(|(_, sum)| **sum != 0);
        sums.map(|(channel, sum)| (channel, std::mem::take(sum))).collect()
    }
}

/// Channels by their numbers, and what was added to them.
pub type Taken = SmallVec<[(u32, i64); 4]>;

impl Extras {
    /// The channel of Y, or those of all responses where the sensor has its own.
    fn of_brightness(&self) -> Range<usize> {
        match self.responses.len() {
            0 => 1..2,
            responses => self.response_channel(0)..self.response_channel(responses),
        }
    }

    /// Y of what was taken from a tile, or the sum of all responses where the sensor has its own.
    pub fn brightness(&self, taken: &Taken, scale: FixedPoint) -> f64 {
        let channels = self.of_brightness();
        let own = taken.iter().filter(|(channel, _)| channels.contains(&(*channel as usize)));
        own.map(|&(_, sum)| sum as f64).sum::<f64>() * scale.quantum
    }

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
