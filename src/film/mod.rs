//! The film: sums of integers per pixel, from which come means, standard errors and counts.
//!
//! Each sample's contribution is rounded once to fixed point and added as an integer. Integer addition is associative
//! and commutative, so any order of samples, any number of threads and any split over machines give the
//! same bits. The quantum is 2⁻⁴⁰ of a reference that the scene fixes before the first sample: the sun's disk does not meet
//! the end of the scale, and what does is counted. What is so much darker than the reference that rounding would show is
//! rounded up or down at random, by its fraction: the mean is right however small it is.
//!
//! Error bars come from the spread of *replicates*: independently scrambled sequences of samples of the same
//! length. The spread of single samples would overstate the error of stratified ones.

mod filter;
mod means;
mod region;

use crate::sampling::mix;
pub use filter::{FilterKind, FilterSampler, Footprint};
pub use means::{NOISE_TILE, PictureNoise, Quantity};
pub use region::{Extent, Region};
use std::ops::{Range, RangeInclusive};

/// How many values could not be used, over a whole render. All zero when nothing is wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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

/// Between contributions and integers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedPoint {
    /// A power of two.
    quantum: f64,
    per_quantum: f64,
}

/// Contributions from here on do not fit beside others, in quanta.
const TOO_LARGE: f64 = 4_611_686_018_427_387_904.0;

/// Below so many quanta contributions are rounded at random. Above, rounding to the nearest errs by less than 3·10⁻⁸ of one.
const SMALL: f64 = 16_777_216.0;

impl FixedPoint {
    /// For shares: numbers of the order of 1.
    pub const SHARE: Self = Self { quantum: 1.0 / (1u64 << 40) as f64, per_quantum: (1u64 << 40) as f64 };

    /// For contributions of the order of `reference`, the radiance of the brightest light.
    pub fn for_reference(reference: f64) -> Self {
        let exponent = if reference.is_normal() { reference.abs().log2().ceil() as i32 } else { 0 };
        let quantum = 2f64.powi(exponent.clamp(-900, 900) - 40);
        Self { quantum, per_quantum: 1.0 / quantum }
    }

    /// For the squares of such contributions.
    fn squared(self) -> Self {
        let quantum = self.quantum * self.quantum * (1u64 << 40) as f64;
        Self { quantum, per_quantum: 1.0 / quantum }
    }

    /// For contributions that are larger by about so many times.
    fn coarser(self, times: u64) -> Self {
        let factor = times.next_power_of_two() as f64;
        Self { quantum: self.quantum * factor, per_quantum: self.per_quantum / factor }
    }
}

/// The channel of the filter's weights: X, Y and Z are before it.
const WEIGHT: usize = 3;

/// What a film measures beside X, Y and Z.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Extras {
    /// The share of the samples that meet something.
    pub alpha: bool,
    /// The second moments of X, Y and Z over the samples.
    pub moments: bool,
    /// For each further channel of the sensor the integral of its response, nm: what is added to the channel is over it.
    pub responses: Vec<f64>,
    pub bins: Option<SpectralBins>,
    /// Whether light paths bring something, too.
    pub light_paths: bool,
}

impl Extras {
    /// Channels in all: X, Y and Z and the filter's weights included.
    pub fn channels(&self) -> usize {
        self.bin_channel(0) + self.bins.map_or(0, |bins| bins.count)
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

/// Sums over some samples of the pixels of a rectangle, for a run of replicates: work that a thread does by itself before the
/// film gets it.
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
    /// Begins what a sample brings to a pixel. What `key` is made from says which sample and which pixel: contributions round
    /// alike in whatever order they come.
    pub fn begin(&mut self, key: u64) {
        self.rounding = (mix(key) >> 11) as f64 * (0.5 * f64::EPSILON);
    }

    /// Where in the tile a pixel of the film is; `None` where it is outside.
    pub fn place(&self, x: u32, y: u32) -> Option<usize> {
        let [column, row] = [x.wrapping_sub(self.corner[0]), y.wrapping_sub(self.corner[1])];
        (column < self.size[0] && row < self.size[1]).then(|| (row * self.size[0] + column) as usize)
    }

    /// Adds a sample's finite contribution to a channel of a replicate, at a place. One too large for the fixed point is counted
    /// and left out.
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

    /// The mean of Y at a place in a replicate, or of all responses where the sensor has its own. Zero without samples.
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

    /// What was added since, by channel, of the only pixel and replicate; then they are empty again.
    pub fn take(&mut self) -> Vec<i64> {
        let empty = vec![0; self.sums.len()];
        std::mem::replace(&mut self.sums, empty)
    }
}

/// A rectangular film that measures X, Y, Z and what else it is asked for. Its pixels are those of the part that is measured,
/// counted from that part's corner.
///
/// A pixel is the mean of all samples that its filter reaches, each weighed by it: the sum of the weighed contributions over the
/// sum of the weights, as in Mitsuba 3. What is even comes out even after a single sample. The ratio's bias is of the
/// order of its variance, which is far below its error.
#[derive(Clone, Debug)]
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
    /// By pixel, replicate and channel.
    sums: Vec<i64>,
    /// By pixel: samples taken within it.
    samples: Vec<u32>,
    light: LightPaths,
}

/// What light paths brought. Any of them may have come to any pixel, so it is their number that their sums are divided by.
#[derive(Clone, Debug)]
struct LightPaths {
    /// Like the film's own; empty where there are none.
    sums: Vec<i64>,
    /// By replicate: how many there were.
    count: Vec<u64>,
    /// A path may bring to one pixel what comes to all of them.
    scale: FixedPoint,
}

impl LightPaths {
    /// What they brought to a replicate of a pixel, per path: a linear function of the channels, in the unit of contributions.
    fn mean(&self, index: usize, replicate: usize, channels: usize, of_sums: impl Fn(&[i64]) -> f64) -> f64 {
        let count = self.count[replicate];
        if self.sums.is_empty() || count == 0 {
            return 0.0;
        }
        let sums = &self.sums[(index * self.count.len() + replicate) * channels..][..channels];
        of_sums(sums) * self.scale.quantum / count as f64
    }
}

/// Equal bins over a range of wavelengths, each measuring the mean spectral radiance within it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectralBins {
    pub range: crate::units::WavelengthRange,
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
        let [width, height] = extent.measured.size;
        let pixels = width as usize * height as usize;
        let sums = vec![0; pixels * replicates as usize * extras.channels()];
        let light = LightPaths {
            sums: if extras.light_paths { sums.clone() } else { Vec::new() },
            count: vec![0; replicates as usize],
            scale: scale.coarser(Region::whole(extent.whole).pixel_count()),
        };
        Self {
            width,
            height,
            extent,
            replicates,
            per_net: 1,
            extras,
            bad: BadValues::default(),
            scale,
            sums,
            samples: vec![0; pixels],
            light,
        }
    }

    /// Memory that a film takes, bytes.
    pub fn bytes(width: u32, height: u32, replicates: u32, extras: &Extras) -> u128 {
        let kinds = if extras.light_paths { 2 } else { 1 };
        let pixel = u128::from(replicates) * extras.channels() as u128 * kinds * size_of::<i64>() as u128;
        u128::from(width) * u128::from(height) * (pixel + size_of::<u32>() as u128)
    }

    pub fn scale(&self) -> FixedPoint {
        self.scale
    }

    /// Of squares.
    pub fn square_scale(&self) -> FixedPoint {
        self.scale.squared()
    }

    /// Of what light paths bring.
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
                let first = index * self.replicates as usize + tile.replicates.start as usize;
                let own = &mut self.sums[first * tile.channels..][..of_pixel];
                for (sum, &value) in own.iter_mut().zip(sums) {
                    match sum.checked_add(value) {
                        Some(next) => *sum = next,
                        None => self.bad.overflow += 1,
                    }
                }
            }
        }
    }

    /// The same film with a replicate for each net. `None` where each is one already, and where there is but one.
    ///
    /// Replicates that are runs of one net complete each other: they tell an error that is too large. That of independent
    /// nets is right on average, but they are few.
    pub fn nets(&self) -> Option<Self> {
        let nets = self.replicates / self.per_net;
        if self.per_net == 1 || nets < 2 {
            return None;
        }
        let channels = self.extras.channels();
        let merged = |sums: &[i64]| -> Vec<i64> {
            let of_net = |runs: &[i64]| -> Vec<i64> {
                (0..channels).map(|c| runs.iter().skip(c).step_by(channels).sum()).collect()
            };
            sums.chunks_exact(channels * self.per_net as usize).flat_map(of_net).collect()
        };
        let counts = self.light.count.chunks_exact(self.per_net as usize).map(|runs| runs.iter().sum());
        Some(Self {
            replicates: nets,
            per_net: 1,
            sums: merged(&self.sums),
            light: LightPaths {
                sums: merged(&self.light.sums),
                count: counts.collect(),
                scale: self.light.scale,
            },
            extras: self.extras.clone(),
            samples: self.samples.clone(),
            ..*self
        })
    }

    /// Adds what one light path brought to a replicate of a pixel. `sums` are those of one replicate.
    pub fn add_light(&mut self, [x, y]: [u32; 2], replicate: u32, sums: &[i64]) {
        let channels = self.extras.channels();
        let first = (self.index(x, y) * self.replicates as usize + replicate as usize) * channels;
        for (sum, &value) in self.light.sums[first..first + channels].iter_mut().zip(sums) {
            match sum.checked_add(value) {
                Some(next) => *sum = next,
                None => self.bad.overflow += 1,
            }
        }
    }

    /// Says that a replicate has had so many light paths more.
    pub fn count_light(&mut self, replicate: u32, paths: u64) {
        self.light.count[replicate as usize] += paths;
    }

    /// How many samples a pixel has.
    pub fn samples(&self, x: u32, y: u32) -> u64 {
        u64::from(self.samples[self.index(x, y)])
    }

    /// The fewest and the most samples that a pixel has, of all that are measured. They differ in a render that was stopped.
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
        let index = self.index(x, y);
        let first = (index * self.replicates as usize + replicate as usize) * self.extras.channels();
        let weight = self.sums[first + WEIGHT] as f64 * FixedPoint::SHARE.quantum;
        if weight == 0.0 {
            return 0.0;
        }
        let weighed = |sums: &[i64]| (0..3).map(|i| weights[i] * sums[i] as f64).sum::<f64>();
        let light = self.light.mean(index, replicate as usize, self.extras.channels(), weighed);
        weighed(&self.sums[first..first + 3]) * self.scale.quantum / weight + light
    }

    /// The share of the pixel's samples that meet something, weighed by the filter. Only for a film that measures it. Exactly 1
    /// where every sample meets something.
    pub fn alpha(&self, x: u32, y: u32) -> Measured {
        self.measured(x, y, Quantity::Alpha)
    }

    /// The mean over the pixel's samples of the square of X, Y or Z. Only for a film that measures it.
    pub fn second_moment(&self, x: u32, y: u32, of: usize) -> Measured {
        self.measured(x, y, Quantity::SecondMoment(of))
    }

    /// The integral of the pixel's mean spectral radiance over a response of the sensor, with its standard error.
    pub fn response(&self, x: u32, y: u32, response: usize) -> Measured {
        self.measured(x, y, Quantity::Response(response))
    }

    /// The pixel's mean spectral radiance within a bin, per nm, with its standard error.
    pub fn bin(&self, x: u32, y: u32, bin: usize) -> Measured {
        self.measured(x, y, Quantity::Bin(bin))
    }

    /// Over all pixels that are shown, the mean standard error of Y over the mean of Y; of all responses instead of Y where the sensor has
    /// its own. `None` where it is not known.
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
mod tests {
    use super::*;
    use crate::units::WavelengthRange;

    fn film(reference: f64, replicates: usize, bins: Option<SpectralBins>) -> Film {
        let extras = Extras { bins, ..Extras::default() };
        Film::new(2, 1, replicates as u32, extras, FixedPoint::for_reference(reference))
    }

    /// A film whose first pixel has had one sample in each replicate.
    fn exposed(reference: f64, values: &[[f64; 3]]) -> Film {
        let mut film = film(reference, values.len(), None);
        let mut tile = film.extras.tile([0, 0], [1, 1], 0..values.len() as u32);
        for (replicate, xyz) in (0..).zip(values) {
            tile.begin(u64::from(replicate));
            for (channel, &value) in xyz.iter().enumerate() {
                tile.add(0, replicate, channel, value, film.scale());
            }
            tile.weigh(0, replicate, 1.0);
            tile.count(0, 1);
        }
        film.add(&tile);
        film
    }

    #[test]
    fn mean_and_standard_error_are_those_of_the_replicates() {
        let film = exposed(1.0, &[[1.0, 2.0, 0.5], [3.0, 2.5, 0.25], [2.0, 1.0, 0.75], [2.0, 4.5, 0.0]]);
        let x = film.combined(0, 0, [1.0, 0.0, 0.0]);
        assert_eq!(x.mean, 2.0);
        assert!((x.error - (2.0f64 / 3.0 / 4.0).sqrt()).abs() < 1e-15);
        // X − Y has the values −1, 0.5, 1, −2.5: mean −0.5, sum of squared deviations 7.5.
        let difference = film.combined(0, 0, [1.0, -1.0, 0.0]);
        assert_eq!(difference.mean, -0.5);
        assert!((difference.error - (7.5f64 / 3.0 / 4.0).sqrt()).abs() < 1e-14);
        assert_eq!(film.samples(0, 0), 4);
        let of_each = (0..4).map(|replicate| film.of_replicate(0, 0, replicate, [1.0, -1.0, 0.0]));
        assert_eq!(of_each.collect::<Vec<_>>(), [-1.0, 0.5, 1.0, -2.5]);
        assert_eq!(film.of_replicate(1, 0, 2, [1.0, 0.0, 0.0]), 0.0);
        assert_eq!(film.combined(1, 0, [1.0, 0.0, 0.0]).mean, 0.0);
    }

    /// Each replicate's light is divided by the number of its own paths.
    #[test]
    fn light_paths_count_for_all_pixels() {
        let extras = Extras { light_paths: true, ..Extras::default() };
        let mut film = Film::new(2, 1, 2, extras, FixedPoint::for_reference(1.0));
        let mut tile = film.extras.tile([0, 0], [2, 1], 0..2);
        for (place, replicate) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            tile.add(place, replicate, 1, 1.0, film.scale());
            tile.weigh(place, replicate, 1.0);
        }
        film.add(&tile);
        let mut light = film.extras.tile([0, 0], [1, 1], 0..1);
        for (replicate, value, paths) in [(0, 6.0, 3), (1, 16.0, 4)] {
            light.add(0, 0, 1, value, film.light_scale());
            film.add_light([1, 0], replicate, &light.take());
            film.count_light(replicate, paths);
        }
        let y = [0.0, 1.0, 0.0];
        assert_eq!(film.combined(0, 0, y), Measured { mean: 1.0, error: 0.0 });
        assert_eq!([0, 1].map(|replicate| film.of_replicate(1, 0, replicate, y)), [3.0, 5.0]);
        assert_eq!(film.combined(1, 0, y), Measured { mean: 4.0, error: 1.0 });
    }

    #[test]
    fn nets_are_the_sums_of_their_runs() {
        let mut film = exposed(1.0, &[[1.0; 3], [3.0; 3], [2.0; 3], [4.0; 3]]);
        assert!(film.nets().is_none());
        film.per_net = 2;
        let nets = film.nets().unwrap();
        let y = [0.0, 1.0, 0.0];
        assert_eq!([0, 1].map(|net| nets.of_replicate(0, 0, net, y)), [2.0, 3.0]);
        assert_eq!(nets.combined(0, 0, y), Measured { mean: 2.5, error: 0.5 });
        assert_eq!(film.combined(0, 0, y).mean, 2.5);
        film.per_net = 4;
        assert!(film.nets().is_none());
    }

    #[test]
    fn the_order_of_samples_leaves_no_trace() {
        let values: Vec<f64> = (0..64).map(|i| 1e-9 + 1e3 * (1.0 + (f64::from(i) * 0.7).sin())).collect();
        let exposed_in = |order: &mut dyn Iterator<Item = &f64>| {
            let mut film = film(100.0, 2, None);
            for (i, &value) in order.enumerate() {
                let mut tile = film.extras.tile([0, 0], [1, 1], 0..2);
                tile.add(0, 0, 1, value, film.scale());
                tile.weigh(0, 0, 1.0);
                tile.count(0, u32::from(i % 2 == 0));
                film.add(&tile);
            }
            film.combined(0, 0, [0.3, 0.4, 0.1])
        };
        assert_eq!(exposed_in(&mut values.iter()), exposed_in(&mut values.iter().rev()));
    }

    #[test]
    fn rounding_stays_below_the_noise_in_the_darkest_corner_of_a_sunlit_scene() {
        // The sun's disk is about 10⁹ times brighter than a wall in deep shade (2·10⁷ against 0.02 W·m⁻²·sr⁻¹).
        let values: Vec<f64> = (0..16).map(|i| 0.02 * (1.0 + (f64::from(i) * 2.3).sin())).collect();
        let film = exposed(2e7, &values.iter().map(|&v| [v, v, v]).collect::<Vec<_>>());
        let found = film.combined(0, 0, [0.0, 1.0, 0.0]);
        let mean = values.iter().sum::<f64>() / 16.0;
        let noise = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 15.0 / 16.0).sqrt();
        assert!((found.mean - mean).abs() < 3e-3 * noise, "{found:?}");
        assert!((found.error / noise - 1.0).abs() < 3e-3, "{found:?} {noise}");
    }

    /// A lamp of 10⁻⁶ units that lights a floor as brightly as the sun does is 10¹² times brighter than it.
    #[test]
    fn what_is_smaller_than_the_quantum_is_right_on_average() {
        for value in [1e-12, 0.3e-12, 1.7e-12, 7.3e-9] {
            let mut film = film(1.0, 1, None);
            let count = 1 << 20;
            let mut tile = film.extras.tile([0, 0], [1, 1], 0..1);
            for key in 0..count {
                tile.begin(key);
                tile.add(0, 0, 1, value, film.scale());
                tile.weigh(0, 0, 1.0);
            }
            film.add(&tile);
            let found = film.combined(0, 0, [0.0, 1.0, 0.0]).mean;
            // Rounding one up or down has a variance of a quarter of a quantum's square at most.
            let error = 0.5 * film.scale().quantum / (count as f64).sqrt();
            assert!((found - value).abs() < 4.5 * error, "{found:e}, {value:e} ± {error:e}");
        }
    }

    #[test]
    fn bad_values_are_counted_not_hidden() {
        let mut bad = BadValues::default();
        let values = [1.0, f64::NAN, f64::INFINITY, -1e-300, 0.0];
        let admitted = values.into_iter().filter(|&v| bad.admits(v)).count();
        assert_eq!(admitted, 2);
        assert_eq!(bad, BadValues { not_a_number: 1, infinite: 1, negative: 1, overflow: 0 });
        let film = exposed(1.0, &[[1e30, 0.0, 0.0], [1.0, 0.0, 0.0]]);
        assert_eq!(film.bad.overflow, 1);
        assert_eq!(film.combined(0, 0, [1.0, 0.0, 0.0]).mean, 0.5);
    }

    #[test]
    fn a_narrow_line_falls_into_its_own_bin() {
        let bins = SpectralBins { range: WavelengthRange::VISIBLE, count: 47 };
        assert_eq!(bins.of(360.0), Some(0));
        assert_eq!(bins.of(830.0), Some(46));
        assert_eq!(bins.of(589.3), Some(22));
        assert!((bins.centre(22) - 585.0).abs() < 1e-9);
        assert_eq!(bins.of(359.9), None);
        let mut film = film(1.0, 1, Some(bins));
        let mut tile = film.extras.tile([1, 0], [1, 1], 0..1);
        tile.add(0, 0, film.extras.bin_channel(22), 7.0, film.scale());
        tile.weigh(0, 0, 1.0);
        film.add(&tile);
        assert_eq!(film.bin(1, 0, 22).mean, 7.0);
        assert_eq!(film.bin(1, 0, 21).mean, 0.0);
        assert_eq!(film.bin(0, 0, 22).mean, 0.0);
    }
}
