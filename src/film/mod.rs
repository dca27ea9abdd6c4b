//! The film: sums of integers per pixel, from which come means, standard errors and counts.
//!
//! Each sample's contribution is rounded once to fixed point and added as an integer. Integer addition is
//! associative and commutative, so any order of samples, any number of threads and any split over machines
//! give the same bits. The quantum is 2⁻⁴⁰ of a reference that the scene fixes before the first sample: the
//! sun's disk does not meet the end of the scale, and what does is counted. Contributions are rounded up or
//! down at random, by their fractions: the mean is right however small they are.
//!
//! Error bars come from the spread of *replicates*: independently scrambled sequences of samples of the same
//! length. The spread of single samples would overstate the error of stratified ones.

mod bins;
mod extras;
mod filter;
mod fixed_point;
mod light;
mod means;
mod parts;
mod region;
mod sums;
mod tile;

pub use bins::Storage;
use extras::WEIGHT;
pub use extras::{Extras, SpectralBins};
pub use filter::{FilterKind, FilterSampler, Footprint};
pub use fixed_point::FixedPoint;
use light::LightPaths;
pub use means::{NOISE_TILE, NoiseSums, PictureNoise, Pixel, Quantity, Told};
pub use parts::Row;
pub use region::{Extent, Region};
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;
use sums::Sums;
pub use tile::{FilmSample, Taken, Tile, Tristimulus};

/// How many values could not be used, over a whole render. All zero when nothing is wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BadValues {
    /// Values that are not a number.
    pub not_a_number: u64,
    /// Values that are infinite.
    pub infinite: u64,
    /// Values below 0.
    pub negative: u64,
    /// Too large for the fixed point.
    pub overflow: u64,
}

impl BadValues {
    /// Values of all kinds.
    pub fn total(self) -> u64 {
        self.not_a_number + self.infinite + self.negative + self.overflow
    }

    /// Adds the counts of another render or thread.
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

/// A rectangular film that measures X, Y, Z and what else it is asked for. Its pixels are those of the part
/// that is measured, counted from that part's corner.
///
/// A pixel is the mean of all samples that its filter reaches, each weighed by it: the sum of the weighed
/// contributions over the sum of the weights, as in Mitsuba 3. What is even comes out even after a single
/// sample. The ratio's bias is of the order of its variance, which is far below its error.
#[derive(Debug)]
pub struct Film {
    /// Columns that are exposed.
    pub width: u32,
    /// Rows that are exposed.
    pub height: u32,
    /// Where they lie in the whole film, and how far samples reach.
    pub extent: Extent,
    /// Parts of the samples that each pixel is measured by, whose spread tells its error.
    pub replicates: u32,
    /// Replicates of each net, a sequence of samples that is well spread as a whole: see [`Self::nets`].
    pub per_net: u32,
    /// What is measured beside X, Y and Z.
    pub extras: Extras,
    /// Values that were left out.
    pub bad: BadValues,
    scale: FixedPoint,
    sums: Sums,
    /// By pixel: samples taken within it.
    samples: Vec<u32>,
    light: LightPaths,
}

/// A mean and its standard error; the error is infinite where fewer than two replicates were taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// The mean, in the unit of what is measured.
    pub mean: f64,
    /// Its standard error, in the same unit.
    pub error: f64,
}

impl Film {
    /// An empty film of this size in pixels.
    pub fn new(width: u32, height: u32, replicates: u32, extras: Extras, scale: FixedPoint) -> Self {
        Self::part(Extent::whole([width, height]), replicates, extras, scale)
    }

    /// The measured part of a film. It rounds as the whole does.
    pub fn part(extent: Extent, replicates: u32, extras: Extras, scale: FixedPoint) -> Self {
        Self::part_at(Storage::Memory, extent, replicates, extras, scale)
            .expect("what is kept in memory needs no file")
    }

    /// The same with the sums of its spectral bins in a storage.
    ///
    /// # Errors
    /// Where there is no room for them.
    pub fn part_at(
        storage: Storage,
        extent: Extent,
        replicates: u32,
        extras: Extras,
        scale: FixedPoint,
    ) -> std::io::Result<Self> {
        let [width, height] = extent.measured.size;
        let pixels = width as usize * height as usize;
        let cells = pixels * replicates as usize;
        let light = LightPaths {
            sums: Sums::new(if extras.light_paths { cells } else { 0 }, &extras, storage)?,
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
            sums: Sums::new(cells, &extras, storage)?,
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

    /// Scale of the sums.
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
        for (place, samples) in tile.samples.iter().enumerate() {
            let [column, row] = [place as u32 % tile.size[0], place as u32 / tile.size[0]];
            let index = self.index(tile.corner[0] + column, tile.corner[1] + row);
            self.samples[index] += samples;
            for replicate in tile.replicates.clone() {
                let cell = index * self.replicates as usize + replicate as usize;
                self.bad.overflow += self.sums.add(cell, tile.of(place, replicate));
            }
        }
        self.sums.of_bins.uses(tile.samples.len() * tile.replicates.len() * tile.channels);
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
        let light = self.light.mean(replicate, weighed);
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

    fn index(&self, x: u32, y: u32) -> usize {
        y as usize * self.width as usize + x as usize
    }
}

#[cfg(test)]
mod tests;
