//! The film: sums of integers per pixel, from which come means, standard errors and counts.
//!
//! Each sample's contribution is rounded once to fixed point and added as an integer. Integer addition is associative
//! and commutative, so any order of samples, any number of threads and any split over machines give the
//! same bits. The quantum is 2⁻⁶⁴ of a reference that the scene fixes before the first sample;
//! sums are 128 bits wide, so neither sunlight nor its darkest corner meets an end of the scale.
//!
//! Error bars come from the spread of *replicates*: independently scrambled sequences of samples of the same
//! length. The spread of single samples would overstate the error of stratified ones.

mod filter;

pub use filter::{FilterKind, FilterSampler};

/// Sums of one replicate of one pixel, channel by channel.
#[derive(Clone, Debug)]
pub struct ReplicateSum {
    channels: Vec<i128>,
}

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
}

/// log₂ of the largest sum of a replicate: leaves room for any number of replicates below 2³².
const SUM_BITS: i32 = 94;

/// log₂ of a quantum of products over the square of the quantum of sums: products are rounded so that they fit.
const PRODUCT_SHIFT: i32 = 64;

impl FixedPoint {
    /// For contributions of the order of `reference`, the radiance of the brightest light: from 2⁻⁶⁴ to 2³⁰ of it.
    pub fn for_reference(reference: f64) -> Self {
        let exponent = if reference.is_normal() { reference.abs().log2().ceil() as i32 } else { 0 };
        Self { quantum: 2f64.powi(exponent.clamp(-900, 900) - 64) }
    }

    fn round(self, value: f64) -> i128 {
        (value / self.quantum).round_ties_even() as i128
    }
}

impl ReplicateSum {
    pub fn new(channels: usize) -> Self {
        Self { channels: vec![0; channels] }
    }

    pub fn clear(&mut self) {
        self.channels.fill(0);
    }

    /// Adds one sample's contribution to a channel. It must be finite.
    pub fn add(&mut self, channel: usize, value: f64, scale: FixedPoint) {
        self.channels[channel] = self.channels[channel].saturating_add(scale.round(value));
    }
}

/// One pixel's sums over replicates.
#[derive(Clone, Debug, Default)]
struct Pixel {
    replicates: u32,
    /// X, Y, Z.
    sums: [i128; 3],
    /// XX, YY, ZZ, XY, XZ, YZ of the replicates' sums.
    products: [i128; 6],
}

const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

/// A rectangular film that measures X, Y, Z and optionally spectral bins.
#[derive(Clone, Debug)]
pub struct Film {
    pub width: u32,
    pub height: u32,
    /// Samples in each replicate.
    pub samples_per_replicate: u32,
    pub bins: Option<SpectralBins>,
    pub bad: BadValues,
    scale: FixedPoint,
    pixels: Vec<Pixel>,
    /// Per pixel and bin: sum, and sum of squares of the replicates' sums.
    bin_sums: Vec<[i128; 2]>,
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
    pub fn new(
        width: u32,
        height: u32,
        samples_per_replicate: u32,
        bins: Option<SpectralBins>,
        scale: FixedPoint,
    ) -> Self {
        let pixels = width as usize * height as usize;
        let bin_count = bins.map_or(0, |bins| bins.count);
        Self {
            width,
            height,
            samples_per_replicate,
            bins,
            bad: BadValues::default(),
            scale,
            pixels: vec![Pixel::default(); pixels],
            bin_sums: vec![[0; 2]; pixels * bin_count],
        }
    }

    pub fn scale(&self) -> FixedPoint {
        self.scale
    }

    /// X, Y, Z and the bins.
    pub fn channels(&self) -> usize {
        3 + self.bins.map_or(0, |bins| bins.count)
    }

    /// Adds one finished replicate of one pixel.
    pub fn add(&mut self, x: u32, y: u32, replicate: &ReplicateSum) {
        let index = self.index(x, y);
        let limit = 1i128 << SUM_BITS;
        let bad = &mut self.bad;
        let mut bounded = |sum: i128| {
            if sum.abs() > limit {
                bad.overflow += 1;
            }
            sum.clamp(-limit, limit)
        };
        // Rounding to f64 and back is a function of the integer alone: the order of replicates doesn't matter.
        let product = |a: i128, b: i128| {
            ((a as f64) * (b as f64) * 2f64.powi(-PRODUCT_SHIFT)).round_ties_even() as i128
        };
        let pixel = &mut self.pixels[index];
        pixel.replicates += 1;
        let xyz: [i128; 3] = std::array::from_fn(|channel| bounded(replicate.channels[channel]));
        for (sum, value) in pixel.sums.iter_mut().zip(xyz) {
            *sum += value;
        }
        for (slot, (a, b)) in PAIRS.into_iter().enumerate() {
            pixel.products[slot] = pixel.products[slot].saturating_add(product(xyz[a], xyz[b]));
        }
        let bins = replicate.channels.len() - 3;
        for (bin, &sum) in replicate.channels[3..].iter().enumerate() {
            let sum = bounded(sum);
            let slot = &mut self.bin_sums[index * bins + bin];
            slot[0] += sum;
            slot[1] = slot[1].saturating_add(product(sum, sum));
        }
    }

    /// How many replicates a pixel has.
    pub fn replicates(&self, x: u32, y: u32) -> u32 {
        self.pixels[self.index(x, y)].replicates
    }

    /// How many samples a pixel has.
    pub fn samples(&self, x: u32, y: u32) -> u64 {
        u64::from(self.replicates(x, y)) * u64::from(self.samples_per_replicate)
    }

    /// All samples of all pixels.
    pub fn total_samples(&self) -> u64 {
        self.pixels.iter().map(|p| u64::from(p.replicates)).sum::<u64>()
            * u64::from(self.samples_per_replicate)
    }

    /// The pixel's mean of Σ wᵢ·XYZᵢ for three weights, with its standard error, covariances included.
    pub fn combined(&self, x: u32, y: u32, weights: [f64; 3]) -> Measured {
        let pixel = &self.pixels[self.index(x, y)];
        let sum: f64 = (0..3).map(|i| weights[i] * pixel.sums[i] as f64).sum();
        let r = f64::from(pixel.replicates);
        // Σ (a − ā)(b − b̄) over replicates, in units of the quantum squared.
        let spread: f64 = PAIRS
            .into_iter()
            .enumerate()
            .map(|(slot, (a, b))| {
                let both = if a == b { 1.0 } else { 2.0 };
                both * weights[a]
                    * weights[b]
                    * centred(pixel.products[slot], pixel.sums[a], pixel.sums[b], pixel.replicates)
            })
            .sum();
        self.measured(sum, spread, r)
    }

    /// The pixel's mean spectral radiance within a bin, per nm, with its standard error.
    pub fn bin(&self, x: u32, y: u32, bin: usize) -> Measured {
        let index = self.index(x, y);
        let count = self.bins.map_or(0, |bins| bins.count);
        let [sum, squares] = self.bin_sums[index * count + bin];
        let replicates = self.pixels[index].replicates;
        self.measured(sum as f64, centred(squares, sum, sum, replicates), f64::from(replicates))
    }

    /// `sum` and `spread` are over `r` replicates, in quanta and squared quanta.
    fn measured(&self, sum: f64, spread: f64, r: f64) -> Measured {
        let n = f64::from(self.samples_per_replicate);
        let mean = if r > 0.0 { sum / (r * n) * self.scale.quantum } else { 0.0 };
        let error = if r > 1.0 {
            (spread.max(0.0) / (r * (r - 1.0))).sqrt() / n * self.scale.quantum
        } else {
            f64::INFINITY
        };
        Measured { mean, error }
    }

    /// Over all pixels, the mean standard error of Y over the mean of Y; `None` before any pixel has two replicates.
    pub fn relative_error(&self) -> Option<f64> {
        let (mut mean, mut error) = (0.0, 0.0);
        for y in 0..self.height {
            for x in 0..self.width {
                let luminance = self.combined(x, y, [0.0, 1.0, 0.0]);
                mean += luminance.mean;
                error += luminance.error;
            }
        }
        (error.is_finite() && mean > 0.0).then(|| error / mean)
    }

    fn index(&self, x: u32, y: u32) -> usize {
        y as usize * self.width as usize + x as usize
    }
}

/// Σ ab − Σa·Σb/r, in squared quanta. The two terms agree in many digits where a pixel is steady: a standard error
/// below 1e-8 of the mean is lost in rounding.
fn centred(products: i128, a: i128, b: i128, replicates: u32) -> f64 {
    if replicates == 0 {
        return 0.0;
    }
    let (a, b) = (a as f64, b as f64);
    products as f64 * 2f64.powi(PRODUCT_SHIFT) - a * b / f64::from(replicates)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::WavelengthRange;

    fn film(reference: f64, bins: Option<SpectralBins>) -> Film {
        Film::new(2, 1, 1, bins, FixedPoint::for_reference(reference))
    }

    fn expose(film: &mut Film, values: &[[f64; 3]]) {
        for xyz in values {
            let mut sum = ReplicateSum::new(film.channels());
            for (channel, &value) in xyz.iter().enumerate() {
                sum.add(channel, value, film.scale());
            }
            film.add(0, 0, &sum);
        }
    }

    #[test]
    fn mean_and_standard_error_are_those_of_the_replicates() {
        let mut film = film(1.0, None);
        expose(&mut film, &[[1.0, 2.0, 0.5], [3.0, 2.5, 0.25], [2.0, 1.0, 0.75], [2.0, 4.5, 0.0]]);
        let x = film.combined(0, 0, [1.0, 0.0, 0.0]);
        assert_eq!(x.mean, 2.0);
        assert!((x.error - (2.0f64 / 3.0 / 4.0).sqrt()).abs() < 1e-15);
        // X − Y has the values −1, 0.5, 1, −2.5: mean −0.5, sum of squared deviations 7.5.
        let difference = film.combined(0, 0, [1.0, -1.0, 0.0]);
        assert_eq!(difference.mean, -0.5);
        assert!((difference.error - (7.5f64 / 3.0 / 4.0).sqrt()).abs() < 1e-14);
        assert_eq!(film.samples(0, 0), 4);
        assert_eq!(film.combined(1, 0, [1.0, 0.0, 0.0]).mean, 0.0);
    }

    #[test]
    fn the_order_of_replicates_leaves_no_trace() {
        let values: Vec<[f64; 3]> =
            (0..64).map(|i| [1e-9, 1.0, 1e6].map(|s| s * (1.0 + (f64::from(i) * 0.7).sin()))).collect();
        let (mut forward, mut backward) = (film(100.0, None), film(100.0, None));
        expose(&mut forward, &values);
        expose(&mut backward, &values.iter().rev().copied().collect::<Vec<_>>());
        for weights in [[1.0, 0.0, 0.0], [0.3, 0.4, 0.1]] {
            assert_eq!(forward.combined(0, 0, weights), backward.combined(0, 0, weights));
        }
    }

    #[test]
    fn rounding_stays_below_the_noise_in_the_darkest_corner_of_a_sunlit_scene() {
        // The sun's disk is about 10⁹ times brighter than a wall in deep shade (2·10⁷ against 0.02 W·m⁻²·sr⁻¹).
        let mut film = film(2e7, None);
        let values: Vec<f64> = (0..16).map(|i| 0.02 * (1.0 + (f64::from(i) * 2.3).sin())).collect();
        expose(&mut film, &values.iter().map(|&v| [v, v, v]).collect::<Vec<_>>());
        let found = film.combined(0, 0, [0.0, 1.0, 0.0]);
        let mean = values.iter().sum::<f64>() / 16.0;
        let noise = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 15.0 / 16.0).sqrt();
        assert!((found.mean - mean).abs() < 1e-6 * noise, "{found:?}");
        assert!((found.error / noise - 1.0).abs() < 1e-3, "{found:?} {noise}");
    }

    #[test]
    fn bad_values_are_counted_not_hidden() {
        let mut bad = BadValues::default();
        let values = [1.0, f64::NAN, f64::INFINITY, -1e-300, 0.0];
        let admitted = values.into_iter().filter(|&v| bad.admits(v)).count();
        assert_eq!(admitted, 2);
        assert_eq!(bad, BadValues { not_a_number: 1, infinite: 1, negative: 1, overflow: 0 });
        let mut film = film(1.0, None);
        expose(&mut film, &[[1e30, 0.0, 0.0]]);
        assert_eq!(film.bad.overflow, 1);
    }

    #[test]
    fn a_narrow_line_falls_into_its_own_bin() {
        let bins = SpectralBins { range: WavelengthRange::VISIBLE, count: 47 };
        assert_eq!(bins.of(360.0), Some(0));
        assert_eq!(bins.of(830.0), Some(46));
        assert_eq!(bins.of(589.3), Some(22));
        assert!((bins.centre(22) - 585.0).abs() < 1e-9);
        assert_eq!(bins.of(359.9), None);
        let mut film = film(1.0, Some(bins));
        let mut sum = ReplicateSum::new(film.channels());
        sum.add(3 + 22, 7.0, film.scale());
        film.add(1, 0, &sum);
        assert_eq!(film.bin(1, 0, 22).mean, 7.0);
        assert_eq!(film.bin(1, 0, 21).mean, 0.0);
        assert_eq!(film.bin(0, 0, 22).mean, 0.0);
    }
}
