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

use crate::sampling::mix;
pub use filter::{FilterKind, FilterSampler};

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

/// The channels of alpha in a film that has it: the filter's weights of the samples that meet something, and of all.
pub const ALPHA: [usize; 2] = [3, 4];

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
    /// Channels in all, X, Y and Z included.
    fn channels(&self) -> usize {
        self.bin_channel(0) + self.bins.map_or(0, |bins| bins.count)
    }

    /// The channel of the second moment of X, Y or Z, in a film that measures them.
    pub fn moment_channel(&self, of: usize) -> usize {
        3 + if self.alpha { ALPHA.len() } else { 0 } + of
    }

    pub fn response_channel(&self, response: usize) -> usize {
        self.moment_channel(if self.moments { 3 } else { 0 }) + response
    }

    pub fn bin_channel(&self, bin: usize) -> usize {
        self.response_channel(self.responses.len()) + bin
    }
}

/// Sums of some samples of one pixel: for each replicate, the film's channels.
#[derive(Clone, Debug)]
pub struct PixelSums {
    channels: usize,
    sums: Vec<i64>,
    /// Of each replicate.
    samples: u32,
    /// Decides how small contributions are rounded.
    rounding: u64,
}

impl PixelSums {
    /// Begins a sample. What `key` is made from says which one it is: a sample rounds alike in whatever order they come.
    pub fn begin(&mut self, key: u64) {
        self.rounding = key;
    }

    /// Adds one sample's finite contribution to a channel of a replicate. One too large for the fixed point is counted
    /// and left out.
    pub fn add(
        &mut self,
        replicate: u32,
        channel: usize,
        value: f64,
        scale: FixedPoint,
        bad: &mut BadValues,
    ) {
        let exact = value * scale.per_quantum;
        let quanta = if exact.abs() >= SMALL || exact == 0.0 {
            exact.round_ties_even()
        } else {
            self.rounding = mix(self.rounding);
            (exact + (self.rounding >> 11) as f64 * (0.5 * f64::EPSILON)).floor()
        };
        let sum = &mut self.sums[replicate as usize * self.channels + channel];
        match sum.checked_add(quanta as i64).filter(|_| quanta.abs() < TOO_LARGE) {
            Some(next) => *sum = next,
            None => bad.overflow += 1,
        }
    }

    /// What was added since, by channel, of a single replicate; then they are empty again.
    pub fn take(&mut self) -> Vec<i64> {
        let empty = vec![0; self.sums.len()];
        std::mem::replace(&mut self.sums, empty)
    }

    /// Says that every replicate has had so many samples more.
    pub fn count(&mut self, samples: u32) {
        self.samples += samples;
    }
}

/// A rectangular film that measures X, Y, Z and what else it is asked for.
#[derive(Clone, Debug)]
pub struct Film {
    pub width: u32,
    pub height: u32,
    /// Independent sequences of samples that each pixel is measured by.
    pub replicates: u32,
    pub extras: Extras,
    pub bad: BadValues,
    scale: FixedPoint,
    /// By pixel, replicate and channel.
    sums: Vec<i64>,
    /// By pixel: samples of each replicate.
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
        let pixels = width as usize * height as usize;
        let sums = vec![0; pixels * replicates as usize * extras.channels()];
        let light = LightPaths {
            sums: if extras.light_paths { sums.clone() } else { Vec::new() },
            count: vec![0; replicates as usize],
            scale: scale.coarser(pixels as u64),
        };
        Self {
            width,
            height,
            replicates,
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

    /// Empty sums for what one replicate of a pixel gets.
    pub fn light_sums(&self) -> PixelSums {
        let channels = self.extras.channels();
        PixelSums { channels, sums: vec![0; channels], samples: 0, rounding: 0 }
    }

    /// Empty sums for a pixel of this film.
    pub fn pixel_sums(&self) -> PixelSums {
        let channels = self.extras.channels();
        PixelSums { channels, sums: vec![0; self.replicates as usize * channels], samples: 0, rounding: 0 }
    }

    /// Adds samples of one pixel.
    pub fn add(&mut self, x: u32, y: u32, pixel: &PixelSums) {
        let index = self.index(x, y);
        self.samples[index] += pixel.samples;
        let length = pixel.sums.len();
        for (sum, &value) in self.sums[index * length..][..length].iter_mut().zip(&pixel.sums) {
            match sum.checked_add(value) {
                Some(next) => *sum = next,
                None => self.bad.overflow += 1,
            }
        }
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
        u64::from(self.samples[self.index(x, y)]) * u64::from(self.replicates)
    }

    /// All samples of all pixels.
    pub fn total_samples(&self) -> u64 {
        self.samples.iter().map(|&samples| u64::from(samples)).sum::<u64>() * u64::from(self.replicates)
    }

    /// The pixel's mean of Σ wᵢ·XYZᵢ for three weights, with its standard error.
    pub fn combined(&self, x: u32, y: u32, weights: [f64; 3]) -> Measured {
        self.measured(x, y, self.scale, |sums| (0..3).map(|i| weights[i] * sums[i] as f64).sum())
    }

    /// The same in one replicate alone: what a render of that one sequence of samples would have shown.
    pub fn of_replicate(&self, x: u32, y: u32, replicate: u32, weights: [f64; 3]) -> f64 {
        let index = self.index(x, y);
        let first = (index * self.replicates as usize + replicate as usize) * self.extras.channels();
        let samples = f64::from(self.samples[index]);
        if samples == 0.0 {
            return 0.0;
        }
        let weighed = |sums: &[i64]| (0..3).map(|i| weights[i] * sums[i] as f64).sum::<f64>();
        let light = self.light.mean(index, replicate as usize, self.extras.channels(), weighed);
        weighed(&self.sums[first..first + 3]) * self.scale.quantum / samples + light
    }

    /// The share of the pixel's samples that meet something, weighed by the filter. Only for a film that measures it.
    ///
    /// It is divided by the sum of all weights, so that it is exactly 1 where every sample meets something. Where only some
    /// do, that biases it by less than its error.
    pub fn alpha(&self, x: u32, y: u32) -> Measured {
        let weight = |sums: &[i64], channel: usize| sums[channel] as f64;
        let [met, all] =
            ALPHA.map(|channel| self.measured(x, y, FixedPoint::SHARE, |sums| weight(sums, channel)));
        let mean = if all.mean == 0.0 { 0.0 } else { met.mean / all.mean };
        // The spread of what each replicate adds to the ratio, to first order.
        let rest = self.measured(x, y, FixedPoint::SHARE, |sums| {
            (weight(sums, ALPHA[0]) - mean * weight(sums, ALPHA[1])) / all.mean
        });
        Measured { mean, error: rest.error }
    }

    /// The mean over the pixel's samples of the square of X, Y or Z. Only for a film that measures it.
    pub fn second_moment(&self, x: u32, y: u32, of: usize) -> Measured {
        let channel = self.extras.moment_channel(of);
        self.measured(x, y, self.square_scale(), |sums| sums[channel] as f64)
    }

    /// The integral of the pixel's mean spectral radiance over a response of the sensor, with its standard error.
    pub fn response(&self, x: u32, y: u32, response: usize) -> Measured {
        let (channel, integral) = (self.extras.response_channel(response), self.extras.responses[response]);
        self.measured(x, y, self.scale, |sums| integral * sums[channel] as f64)
    }

    /// The pixel's mean spectral radiance within a bin, per nm, with its standard error.
    pub fn bin(&self, x: u32, y: u32, bin: usize) -> Measured {
        let channel = self.extras.bin_channel(bin);
        self.measured(x, y, self.scale, |sums| sums[channel] as f64)
    }

    /// Mean over replicates and its standard error, of a linear function of a replicate's channels.
    fn measured(&self, x: u32, y: u32, scale: FixedPoint, of_replicate: impl Fn(&[i64]) -> f64) -> Measured {
        let index = self.index(x, y);
        let (channels, replicates) = (self.extras.channels(), self.replicates as usize);
        let sums = self.sums[index * replicates * channels..][..replicates * channels].chunks_exact(channels);
        let (samples, r) = (f64::from(self.samples[index]), f64::from(self.replicates));
        if samples == 0.0 {
            return Measured { mean: 0.0, error: f64::INFINITY };
        }
        let means = sums.enumerate().map(|(replicate, sums)| {
            let light = self.light.mean(index, replicate, channels, &of_replicate);
            of_replicate(sums) * scale.quantum / samples + light
        });
        let mean = means.clone().sum::<f64>() / r;
        let error = if self.replicates < 2 {
            f64::INFINITY
        } else {
            let spread: f64 = means.map(|of_one| (of_one - mean) * (of_one - mean)).sum();
            (spread / (r * (r - 1.0))).sqrt()
        };
        Measured { mean, error }
    }

    /// Over all pixels, the mean standard error of Y over the mean of Y; of all responses instead of Y where the sensor has
    /// its own. `None` where it is not known.
    pub fn relative_error(&self) -> Option<f64> {
        let (mut mean, mut error) = (0.0, 0.0);
        let mut add = |measured: Measured| {
            mean += measured.mean;
            error += measured.error;
        };
        for y in 0..self.height {
            for x in 0..self.width {
                match self.extras.responses.len() {
                    0 => add(self.combined(x, y, [0.0, 1.0, 0.0])),
                    responses => (0..responses).for_each(|response| add(self.response(x, y, response))),
                }
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
        let mut sums = film.pixel_sums();
        for (replicate, xyz) in values.iter().enumerate() {
            for (channel, &value) in xyz.iter().enumerate() {
                sums.add(replicate as u32, channel, value, film.scale(), &mut film.bad);
            }
        }
        sums.count(1);
        film.add(0, 0, &sums);
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
        let mut sums = film.pixel_sums();
        (0..2).for_each(|replicate| sums.add(replicate, 1, 1.0, film.scale(), &mut film.bad));
        sums.count(1);
        film.add(0, 0, &sums);
        film.add(1, 0, &sums);
        let mut light = film.light_sums();
        for (replicate, value, paths) in [(0, 6.0, 3), (1, 16.0, 4)] {
            light.add(0, 1, value, film.light_scale(), &mut film.bad);
            film.add_light([1, 0], replicate, &light.take());
            film.count_light(replicate, paths);
        }
        let y = [0.0, 1.0, 0.0];
        assert_eq!(film.combined(0, 0, y), Measured { mean: 1.0, error: 0.0 });
        assert_eq!([0, 1].map(|replicate| film.of_replicate(1, 0, replicate, y)), [3.0, 5.0]);
        assert_eq!(film.combined(1, 0, y), Measured { mean: 4.0, error: 1.0 });
    }

    #[test]
    fn the_order_of_samples_leaves_no_trace() {
        let values: Vec<f64> = (0..64).map(|i| 1e-9 + 1e3 * (1.0 + (f64::from(i) * 0.7).sin())).collect();
        let exposed_in = |order: &mut dyn Iterator<Item = &f64>| {
            let mut film = film(100.0, 2, None);
            for (i, &value) in order.enumerate() {
                let mut sums = film.pixel_sums();
                sums.add(0, 1, value, film.scale(), &mut film.bad);
                sums.count(u32::from(i % 2 == 0));
                film.add(0, 0, &sums);
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
            let mut sums = film.pixel_sums();
            for key in 0..count {
                sums.begin(mix(key));
                sums.add(0, 1, value, film.scale(), &mut film.bad);
                sums.count(1);
            }
            film.add(0, 0, &sums);
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
        let mut sums = film.pixel_sums();
        sums.add(0, 3 + 22, 7.0, film.scale(), &mut film.bad);
        sums.count(1);
        film.add(1, 0, &sums);
        assert_eq!(film.bin(1, 0, 22).mean, 7.0);
        assert_eq!(film.bin(1, 0, 21).mean, 0.0);
        assert_eq!(film.bin(0, 0, 22).mean, 0.0);
    }
}
