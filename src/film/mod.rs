//! The film: sums of integers per pixel, from which come means, standard errors and counts.
//!
//! Each sample's contribution is rounded once to fixed point and added as an integer. Integer addition is
//! associative and commutative, so any order of samples, any number of threads and any split over machines
//! give the same bits. The quantum is 2⁻⁴⁰ of a reference that the scene fixes before the first sample: the
//! sun's disk does not meet the end of the scale, and what does is counted. What is so much darker than the
//! reference that rounding would show is rounded up or down at random, by its fraction: the mean is right
//! however small it is.
//!
//! Error bars come from the spread of *replicates*: independently scrambled sequences of samples of the same
//! length. The spread of single samples would overstate the error of stratified ones.

mod bins;
mod filter;
mod fixed_point;
mod light;
mod means;
mod parts;
mod region;

use crate::sampling::mix;
use crate::units::WavelengthRange;
use bins::Integers;
pub use bins::Place;
pub use filter::{FilterKind, FilterSampler, Footprint};
pub use fixed_point::FixedPoint;
use fixed_point::{SMALL, TOO_LARGE};
use light::LightPaths;
pub use means::{NOISE_TILE, NoiseSums, PictureNoise, Quantity};
pub use parts::Row;
pub use region::{Extent, Region};
use serde::{Deserialize, Serialize};
use std::ops::{Range, RangeInclusive};

/// How many values could not be used, over a whole render. All zero when nothing is wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BadValues {
    pub not_a_number: u64,
    pub infinite: u64,
    pub negative: u64,
    /// Too large for the fixed point.
    pub overflow: u64,
}

impl BadValues {
    pub fn total(self) -> u64 {
        self.not_a_number + self.infinite + self.negative + self.overflow
    }

    pub fn add(&mut self, other: Self) {
        self.not_a_number += other.not_a_number;
        self.infinite += other.infinite;
        self.negative += other.negative;
        self.overflow += other.overflow;
    }

    /// Whether a radiance is one; counts it if it is not.
    pub fn admits(&mut self, radiance: f64) -> bool {
        if radiance.is_nan() {
            self.not_a_number += 1;
        } else if radiance.is_infinite() {
            self.infinite += 1;
        } else if radiance < 0.0 {
            self.negative += 1;
        } else {
            return true;
        }
        false
    }
}

/// The channel of the filter's weights: X, Y and Z are before it.
const WEIGHT: usize = 3;

/// What a film measures beside X, Y and Z.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Extras {
    /// The fraction of the samples that meet something.
    pub alpha: bool,
    /// The second moments of X, Y and Z over the samples.
    pub moments: bool,
    /// For each further channel of the sensor the integral of its response, nm: what is added to the channel
    /// is over it.
    pub responses: Vec<f64>,
    pub bins: Option<SpectralBins>,
    /// Whether light subpaths bring something, too.
    pub light_paths: bool,
}

impl Extras {
    /// Channels in all: X, Y and Z and the filter's weights included. Spectral bins are the last.
    pub fn channels(&self) -> usize {
        self.bin_channel(0) + self.bin_count()
    }

    fn bin_count(&self) -> usize {
        self.bins.map_or(0, |bins| bins.count)
    }

    /// The channel of the weights of those samples that meet something, in a film with alpha.
    pub fn alpha_channel(&self) -> usize {
        WEIGHT + 1
    }

    /// The channel of the second moment of X, Y or Z, in a film that measures them.
    pub fn moment_channel(&self, of: usize) -> usize {
        WEIGHT + 1 + usize::from(self.alpha) + of
    }

    pub fn response_channel(&self, response: usize) -> usize {
        self.moment_channel(if self.moments { 3 } else { 0 }) + response
    }

    pub fn bin_channel(&self, bin: usize) -> usize {
        self.response_channel(self.responses.len()) + bin
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

/// Sums over some samples of the pixels of a rectangle, for a run of replicates: work that a thread does by
/// itself before the film gets it.
#[derive(Clone, Debug)]
pub struct Tile {
    /// The upper left pixel, on the film.
    corner: [u32; 2],
    size: [u32; 2],
    replicates: Range<u32>,
    channels: usize,
    /// By pixel, replicate and channel.
    sums: Vec<i64>,
    /// By pixel.
    samples: Vec<u32>,
    /// In [0, 1): decides how small contributions of the sample are rounded.
    rounding: f64,
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

    /// Says that a pixel has had so many samples more.
    pub fn count(&mut self, place: usize, samples: u32) {
        self.samples[place] += samples;
    }

    /// What was added since to channels of the only pixel and replicate; then they are empty again.
    pub fn take(&mut self) -> Vec<(u32, i64)> {
        let sums = (0..).zip(&mut self.sums).filter(|(_, sum)| **sum != 0);
        sums.map(|(channel, sum)| (channel, std::mem::take(sum))).collect()
    }
}

/// A rectangular film that measures X, Y, Z and what else it is asked for. Its pixels are those of the part
/// that is measured, counted from that part's corner.
///
/// A pixel is the mean of all samples that its filter reaches, each weighed by it: the sum of the weighed
/// contributions over the sum of the weights, as in Mitsuba 3. What is even comes out even after a single
/// sample. The ratio's bias is of the order of its variance, which is far below its error.
#[derive(Debug)]
pub struct Film {
    pub width: u32,
    pub height: u32,
    pub extent: Extent,
    /// Parts of the samples that each pixel is measured by, whose spread tells its error.
    pub replicates: u32,
    /// Replicates of each net, a sequence of samples that is well spread as a whole: see [`Self::nets`].
    pub per_net: u32,
    pub extras: Extras,
    pub bad: BadValues,
    scale: FixedPoint,
    sums: Sums,
    /// By pixel: samples taken within it.
    samples: Vec<u32>,
    light: LightPaths,
}

/// The sums of a film. Spectral bins are apart from the other channels, which are needed more often.
#[derive(Debug)]
struct Sums {
    /// Channels before the spectral bins.
    first: usize,
    bin_count: usize,
    /// By pixel, replicate and channel.
    of_first: Vec<i64>,
    /// Likewise.
    of_bins: Integers,
}

impl Sums {
    /// Zeros, for so many replicates of pixels.
    fn new(cells: usize, extras: &Extras, place: Place) -> std::io::Result<Self> {
        let (first, bin_count) = (extras.bin_channel(0), extras.bin_count());
        let of_bins = Integers::new(cells * bin_count, place)?;
        Ok(Self { first, bin_count, of_first: vec![0; cells * first], of_bins })
    }

    /// That of a channel, in a cell: a replicate of a pixel.
    fn of(&self, cell: usize, channel: usize) -> i64 {
        match channel.checked_sub(self.first) {
            None => self.of_first[cell * self.first + channel],
            Some(bin) => self.of_bins[cell * self.bin_count + bin],
        }
    }

    /// Those of all channels of some cells, one after another.
    fn of_all(&self, cells: Range<usize>) -> Vec<i64> {
        self.of_bins.uses(cells.len() * self.bin_count);
        let of_cell = |cell: usize| {
            let bins = &self.of_bins[cell * self.bin_count..][..self.bin_count];
            self.of_first[cell * self.first..][..self.first].iter().chain(bins).copied()
        };
        cells.flat_map(of_cell).collect()
    }

    /// Adds to a channel of a cell. Whether the sum would have left the range: it stays.
    fn add_to(&mut self, cell: usize, channel: usize, value: i64) -> bool {
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
    fn add(&mut self, cell: usize, sums: &[i64]) -> u64 {
        let mut overflow = 0;
        let mut add = |own: &mut [i64], more: &[i64]| {
            for (own, &more) in own.iter_mut().zip(more) {
                match own.checked_add(more) {
                    Some(next) => *own = next,
                    None => overflow += 1,
                }
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

/// Equal bins over a range of wavelengths, each measuring the mean spectral radiance within it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpectralBins {
    pub range: WavelengthRange,
    pub count: usize,
}

impl SpectralBins {
    /// nm.
    pub fn width(&self) -> f64 {
        self.range.width() / self.count as f64
    }

    /// The middle of a bin, nm.
    pub fn centre(&self, bin: usize) -> f64 {
        self.range.min + (bin as f64 + 0.5) * self.width()
    }

    /// The bin of a wavelength; the upper end of the range belongs to the last.
    pub fn of(&self, nm: f64) -> Option<usize> {
        let bin = ((nm - self.range.min) / self.width()).floor();
        let inside = self.range.contains(nm);
        inside.then(|| (bin as usize).min(self.count - 1))
    }
}

/// A mean and its standard error; the error is infinite where fewer than two replicates were taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    pub mean: f64,
    pub error: f64,
}

impl Film {
    pub fn new(width: u32, height: u32, replicates: u32, extras: Extras, scale: FixedPoint) -> Self {
        Self::part(Extent::whole([width, height]), replicates, extras, scale)
    }

    /// The measured part of a film. It rounds as the whole does.
    pub fn part(extent: Extent, replicates: u32, extras: Extras, scale: FixedPoint) -> Self {
        Self::part_at(Place::Memory, extent, replicates, extras, scale)
            .expect("what is kept in memory needs no file")
    }

    /// The same with the sums of its spectral bins at a place.
    ///
    /// # Errors
    /// Where there is no room for them.
    pub fn part_at(
        place: Place,
        extent: Extent,
        replicates: u32,
        extras: Extras,
        scale: FixedPoint,
    ) -> std::io::Result<Self> {
        let [width, height] = extent.measured.size;
        let pixels = width as usize * height as usize;
        let cells = pixels * replicates as usize;
        let light = LightPaths {
            sums: Sums::new(if extras.light_paths { cells } else { 0 }, &extras, place)?,
            count: vec![0; replicates as usize],
            scale: scale.coarser(Region::whole(extent.whole).pixel_count()),
        };
        Ok(Self {
            width,
            height,
            extent,
            replicates,
            per_net: 1,
            bad: BadValues::default(),
            scale,
            sums: Sums::new(cells, &extras, place)?,
            samples: vec![0; pixels],
            light,
            extras,
        })
    }

    /// Room that a film takes, bytes: that of its spectral bins, which may be in a file, and all other.
    pub fn bytes(width: u32, height: u32, replicates: u32, extras: &Extras) -> [u128; 2] {
        let kinds = if extras.light_paths { 2 } else { 1 };
        let pixels = u128::from(width) * u128::from(height);
        let channel = pixels * u128::from(replicates) * kinds * size_of::<i64>() as u128;
        let samples = pixels * size_of::<u32>() as u128;
        [extras.bin_count() as u128 * channel, extras.bin_channel(0) as u128 * channel + samples]
    }

    pub fn scale(&self) -> FixedPoint {
        self.scale
    }

    /// Scale of the sums of squares.
    pub fn square_scale(&self) -> FixedPoint {
        self.scale.squared()
    }

    /// Scale of the sums of light subpaths.
    pub fn light_scale(&self) -> FixedPoint {
        self.light.scale
    }

    /// Adds a tile.
    pub fn add(&mut self, tile: &Tile) {
        self.bad.add(tile.bad);
        let of_pixel = tile.replicates.len() * tile.channels;
        let rows = tile.sums.chunks_exact((tile.size[0] as usize * of_pixel).max(1));
        for ((row, sums), samples) in (0..).zip(rows).zip(tile.samples.chunks_exact(tile.size[0] as usize)) {
            for ((column, sums), samples) in (0..).zip(sums.chunks_exact(of_pixel)).zip(samples) {
                let index = self.index(tile.corner[0] + column, tile.corner[1] + row);
                self.samples[index] += samples;
                let cell = index * self.replicates as usize + tile.replicates.start as usize;
                self.bad.overflow += self.sums.add(cell, sums);
            }
        }
        self.sums.of_bins.uses(tile.sums.len());
    }

    /// How many nets tell the variance by themselves. `None` where each replicate is one already, and where
    /// there is but one.
    ///
    /// Replicates that are runs of one net complete each other: they tell an error that is too large. That of
    /// independent nets is right on average, but they are few.
    pub fn nets(&self) -> Option<u32> {
        let nets = self.replicates / self.per_net;
        (self.per_net > 1 && nets >= 2).then_some(nets)
    }

    /// Says that the spectral bins of a row were read, which need not stay in memory.
    pub fn has_used_row(&self) {
        let row = self.width as usize * self.replicates as usize * self.extras.bin_count();
        self.sums.of_bins.uses(row);
        self.light.sums.of_bins.uses(row);
    }

    /// How many samples a pixel has.
    pub fn samples(&self, x: u32, y: u32) -> u64 {
        u64::from(self.samples[self.index(x, y)])
    }

    /// The fewest and the most samples that a pixel has, of all that are measured. They differ in a render
    /// that was stopped.
    pub fn samples_per_pixel(&self) -> RangeInclusive<u64> {
        let (fewest, most) = (self.samples.iter().min(), self.samples.iter().max());
        let of_all = |samples: Option<&u32>| u64::from(samples.copied().unwrap_or(0));
        of_all(fewest)..=of_all(most)
    }

    /// The pixels that are shown, row by row from the top.
    pub fn shown(&self) -> impl Iterator<Item = (u32, u32)> {
        let Extent { measured, shown, .. } = self.extent;
        shown.pixels().filter_map(move |pixel| measured.within(pixel)).map(|[x, y]| (x, y))
    }

    /// All samples of all pixels that are shown.
    pub fn total_samples(&self) -> u64 {
        self.shown().map(|(x, y)| self.samples(x, y)).sum()
    }

    /// The pixel's mean of Σ wᵢ·XYZᵢ for three weights, with its standard error.
    pub fn combined(&self, x: u32, y: u32, weights: [f64; 3]) -> Measured {
        self.measured(x, y, Quantity::Combined(weights))
    }

    /// The same in one replicate alone: what a render of those samples would have shown.
    pub fn of_replicate(&self, x: u32, y: u32, replicate: u32, weights: [f64; 3]) -> f64 {
        let (index, replicate) = (self.index(x, y), replicate as usize);
        let cell = index * self.replicates as usize + replicate;
        let weight = self.sums.of(cell, WEIGHT) as f64 * FixedPoint::SHARE.quantum;
        if weight == 0.0 {
            return 0.0;
        }
        let weighed = |sums: &Sums| (0..3).map(|i| weights[i] * sums.of(cell, i) as f64).sum::<f64>();
        let light = self.light.mean(replicate..replicate + 1, weighed);
        weighed(&self.sums) * self.scale.quantum / weight + light
    }

    /// The fraction of the pixel's samples that meet something, weighed by the filter. Only for a film that
    /// measures it. Exactly 1 where every sample meets something.
    pub fn alpha(&self, x: u32, y: u32) -> Measured {
        self.measured(x, y, Quantity::Alpha)
    }

    /// The mean over the pixel's samples of the square of X, Y or Z. Only for a film that measures it.
    pub fn second_moment(&self, x: u32, y: u32, of: usize) -> Measured {
        self.measured(x, y, Quantity::SecondMoment(of))
    }

    /// The integral of the pixel's mean spectral radiance over a response of the sensor, with its standard
    /// error.
    pub fn response(&self, x: u32, y: u32, response: usize) -> Measured {
        self.measured(x, y, Quantity::Response(response))
    }

    /// The pixel's mean spectral radiance within a bin, per nm, with its standard error.
    pub fn bin(&self, x: u32, y: u32, bin: usize) -> Measured {
        self.measured(x, y, Quantity::Bin(bin))
    }

    /// Over all pixels that are shown, the mean standard error of Y over the mean of Y; of all responses
    /// instead of Y where the sensor has its own. `None` where it is not known.
    pub fn relative_error(&self) -> Option<f64> {
        let (mut mean, mut error) = (0.0, 0.0);
        let mut add = |measured: Measured| {
            mean += measured.mean;
            error += measured.error;
        };
        for (x, y) in self.shown() {
            match self.extras.responses.len() {
                0 => add(self.combined(x, y, [0.0, 1.0, 0.0])),
                responses => (0..responses).for_each(|response| add(self.response(x, y, response))),
            }
        }
        (error.is_finite() && mean > 0.0).then(|| error / mean)
    }

    fn index(&self, x: u32, y: u32) -> usize {
        y as usize * self.width as usize + x as usize
    }
}

#[cfg(test)]
mod tests;
