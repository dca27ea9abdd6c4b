//! How large the error of a picture is as a whole, how surely that is known, and whether it is as small as
//! was asked.

use super::error_bars;
use crate::film::{Extent, Film, NOISE_TILE, Quantity};
use crate::spectrum::colour::{Xyz, assumed_white, delta_e_2000, rec709_to_xyz};
use crate::stats::relmse_scale;
use rayon::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

/// The confidence of [`Estimate::at_most`].
pub const CONFIDENCE: f64 = 0.95;

/// Samples of each replicate below which nothing is decided: what few samples have missed does not show in
/// their spread.
pub const FEWEST: u64 = 4;

/// An error of a picture as a whole, of its luminance or of all responses of the sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorMeasure {
    /// The mean over the pixels of error²/(value² + 0.01·mean²), as `abbe compare` has it.
    RelMse,
    /// The mean standard error over the mean value.
    Error,
    /// The mean over tiles of 8 × 8 pixels of the root mean square colour difference CIEDE2000 that the noise
    /// makes, with the white of `abbe compare`.
    ColourDifference,
}

/// An error that a picture is to be below.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// What is to be small.
    pub measure: ErrorMeasure,
    /// Below which value. Above 0.
    pub bound: f64,
}

/// An error as it is estimated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The measure's value.
    pub value: f64,
    /// It is no larger than this with the [`CONFIDENCE`], as far as what the samples have met tells.
    pub at_most: f64,
}

/// Errors of pixels, added up.
#[derive(Default)]
struct Sum {
    errors: f64,
    /// The sum of the squares of the errors of tiles. What pixels share of their noise they share of its
    /// estimate, too: a tile is taken as one.
    squares: f64,
    /// What they are divided by to be those of the picture.
    divisor: f64,
}

impl Sum {
    /// An error of each pixel that is shown, from its variance.
    fn over(film: &Film, variances: &[f64], error: impl Fn(u32, u32, f64) -> f64) -> Self {
        let mut tiles: BTreeMap<[u32; 2], f64> = BTreeMap::new();
        for (x, y) in film.shown() {
            let variance = variances[y as usize * film.width as usize + x as usize];
            *tiles.entry(tile(film, x, y)).or_insert(0.0) += error(x, y, variance);
        }
        let squares = tiles.values().map(|error| error * error).sum();
        Self { errors: tiles.values().sum(), squares, divisor: 0.0 }
    }

    /// Root mean square colour differences, tile by tile. Where a few lit pixels stand in the dark, those
    /// that no sample has lit say nothing of their colour: their neighbours say it for them. Nothing is known
    /// of those of a black picture.
    fn of_colours(film: &Film) -> Self {
        let luminance = film.shown().map(|(x, y)| film.combined(x, y, [0.0, 1.0, 0.0]).mean.max(0.0));
        let luminance: Vec<f64> = luminance.collect();
        let is_black = luminance.iter().all(|&value| value == 0.0);
        let white = rec709_to_xyz([1.0; 3]) * assumed_white(luminance);
        let lightness_and_variance = |parts: u32, x: u32, y: u32| {
            film.colour_by(parts, x, y).map_or((0.0, f64::INFINITY), |(mean, deviations)| {
                // A replicate deviates by so many times the error of the mean of all, on average.
                let less = 1.0 / f64::from(parts.saturating_sub(1)).sqrt();
                let own = Xyz::from(mean).to_lab(white);
                let difference = |deviation: &[f64; 3]| {
                    let other = [0, 1, 2].map(|i| mean[i] + less * deviation[i]);
                    delta_e_2000(own, Xyz::from(other).to_lab(white)).powi(2)
                };
                (own.l, deviations.iter().map(difference).sum::<f64>() / f64::from(parts))
            })
        };
        let by = |parts: u32| -> (Vec<f64>, Vec<f64>) {
            of_pixels(film, |x, y| lightness_and_variance(parts, x, y)).into_iter().unzip()
        };
        let (lightness, of_runs) = by(film.replicates);
        let of_nets = film.nets().map(|nets| by(nets).1);
        let variances = calibrated(film, &lightness, &of_runs, of_nets.as_deref());
        let sum = Self::over(film, &of_tiles(film, &variances), |_, _, variance| variance.sqrt());
        let pixels = film.extent.shown.pixel_count() as f64;
        Self { divisor: if is_black { 0.0 } else { pixels }, ..sum }
    }
}

/// The tile of a pixel that is shown, counted from the corner of what is shown as those of
/// [`Film::noise`](crate::film::Film::noise) are.
fn tile(film: &Film, x: u32, y: u32) -> [u32; 2] {
    let Extent { measured, shown, .. } = film.extent;
    [0, 1].map(|axis| ([x, y][axis] + measured.offset[axis] - shown.offset[axis]) / NOISE_TILE)
}

/// For each pixel that is measured, row by row: the mean over its tile if it is shown, else 0.
fn of_tiles(film: &Film, values: &[f64]) -> Vec<f64> {
    let place = |x: u32, y: u32| y as usize * film.width as usize + x as usize;
    let mut sums: BTreeMap<[u32; 2], (f64, f64)> = BTreeMap::new();
    for (x, y) in film.shown() {
        let (sum, count) = sums.entry(tile(film, x, y)).or_default();
        *sum += values[place(x, y)];
        *count += 1.0;
    }
    let mut means = vec![0.0; values.len()];
    for (x, y) in film.shown() {
        means[place(x, y)] = sums.get(&tile(film, x, y)).map_or(0.0, |(sum, count)| sum / count);
    }
    means
}

/// What is found of each pixel that is measured, row by row.
fn of_pixels<T: Send>(film: &Film, of: impl Fn(u32, u32) -> T + Sync) -> Vec<T> {
    let [width, height] = film.extent.measured.size;
    let row = |y: u32| (0..width).map(|x| of(x, y)).collect::<Vec<T>>();
    (0..height).into_par_iter().flat_map_iter(row).collect()
}

/// The error bars of all pixels that are measured, squared, from their means, from what all replicates tell
/// of each, and what nets tell where there are any.
fn calibrated(film: &Film, means: &[f64], variances: &[f64], of_nets: Option<&[f64]>) -> Vec<f64> {
    error_bars::calibrated(film.extent.window.size, film.extent.measured, Some(means), variances, of_nets)
}

impl Target {
    /// The mean standard error of the luminance, or of all responses, over its mean, as the error bars of the
    /// picture's file have it. `None` where there is none to know.
    pub fn mean_error(film: &Film) -> Option<f64> {
        Self { measure: ErrorMeasure::Error, bound: 1.0 }.estimate(film).map(|estimate| estimate.value)
    }

    /// The error of what is shown. `None` where there is none to know: without replicates, or of a black
    /// picture.
    pub fn estimate(&self, film: &Film) -> Option<Estimate> {
        if film.replicates < 2 {
            return None;
        }
        let sum = match self.measure {
            ErrorMeasure::RelMse | ErrorMeasure::Error => self.of_channels(film),
            ErrorMeasure::ColourDifference => Sum::of_colours(film),
        };
        let value = sum.errors / sum.divisor;
        let estimate = Estimate { value, at_most: value * self.most_over_found(&sum, film.replicates) };
        (sum.divisor > 0.0 && estimate.at_most.is_finite()).then_some(estimate)
    }

    /// What the error is at most with the [`CONFIDENCE`], over what is found. A sum of variances is nearly
    /// distributed as χ² with as many degrees of freedom as give it its own variance (Satterthwaite, "An
    /// approximate distribution of estimates of variance components", Biometrics Bulletin 2(6), 1946): few
    /// where few tiles make up most of it.
    fn most_over_found(&self, sum: &Sum, replicates: u32) -> f64 {
        if sum.errors == 0.0 {
            return 1.0;
        }
        let tiles = sum.errors * sum.errors / sum.squares;
        let freedom = f64::from(replicates - 1) * tiles;
        let Ok(chi_squared) = ChiSquared::new(freedom) else { return f64::INFINITY };
        let of_variance = freedom / chi_squared.inverse_cdf(1.0 - CONFIDENCE);
        match self.measure {
            ErrorMeasure::RelMse => of_variance,
            ErrorMeasure::Error | ErrorMeasure::ColourDifference => of_variance.sqrt(),
        }
    }

    /// Errors of the luminance, or of all responses.
    fn of_channels(&self, film: &Film) -> Sum {
        let channels: Vec<Quantity> = match film.extras.responses.len() {
            0 => vec![Quantity::Combined([0.0, 1.0, 0.0])],
            responses => (0..responses).map(Quantity::Response).collect(),
        };
        let pixels = film.extent.shown.pixel_count() as f64;
        let mut all = Sum::default();
        for quantity in channels {
            let parts = [film.replicates, film.nets().unwrap_or(film.replicates)];
            let measured = of_pixels(film, |x, y| film.pixel(x, y).measured_by(parts, quantity));
            let squared =
                |by: usize| measured.iter().map(|pixel| pixel[by].error.powi(2)).collect::<Vec<f64>>();
            let of_nets = film.nets().map(|_| squared(1));
            let means: Vec<f64> = measured.iter().map(|pixel| pixel[0].mean).collect();
            let variances = calibrated(film, &means, &squared(0), of_nets.as_deref());
            let value = |x: u32, y: u32| measured[y as usize * film.width as usize + x as usize][0].mean;
            let total: f64 = film.shown().map(|(x, y)| value(x, y)).sum();
            let mean = total / pixels;
            // Errors of the mean are over the mean, of all channels together; those of relMSE are over it
            // already.
            let (sum, divisor) = match self.measure {
                ErrorMeasure::RelMse => {
                    let error = |x, y, variance: f64| match variance == 0.0 {
                        // Also where all is black.
                        true => 0.0,
                        false => variance / relmse_scale(value(x, y), mean),
                    };
                    (Sum::over(film, &variances, error), pixels)
                }
                _ => (Sum::over(film, &variances, |_, _, variance| variance.sqrt()), total),
            };
            all.errors += sum.errors;
            all.squares += sum.squares;
            all.divisor += divisor;
        }
        all
    }

    /// Whether it is time to decide whether the picture is good enough: when each replicate has 4, 6, 8, 10,
    /// 12, 14, 16, 20, 24, 28, 32, 40 … samples, four times for each doubling.
    ///
    /// Who looks after every sample stops when chance makes the error look small. Who looks when the samples
    /// have doubled takes twice as many where the error was just missed; and as pictures that end at N or at
    /// 2 N samples by chance weigh the same, their mean is then too small where it goes together with the
    /// error (`validation/noise/stopping`).
    pub fn decides_at(samples_per_replicate: u64) -> bool {
        samples_per_replicate >= FEWEST
            && samples_per_replicate.is_multiple_of(((1_u64 << samples_per_replicate.ilog2()) / 4).max(2))
    }

    /// Whether the error is below the bound with the [`CONFIDENCE`].
    pub fn is_met(&self, estimate: Option<Estimate>) -> bool {
        estimate.is_some_and(|estimate| estimate.at_most < self.bound)
    }

    /// An error in the unit of the target, with its name.
    pub fn told(&self, value: f64) -> String {
        match self.measure {
            ErrorMeasure::RelMse => format!("relmse {value:.2e}"),
            ErrorMeasure::Error => format!("error {:.3} %", 100.0 * value),
            ErrorMeasure::ColourDifference => format!("ΔE {value:.3}"),
        }
    }
}

/// A fraction as the number of per cent that it was read from: what rounding adds is left out.
fn in_percent(fraction: f64) -> f64 {
    let percent = 100.0 * fraction;
    format!("{percent:.12e}").parse().unwrap_or(percent)
}

impl FromStr for Target {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || {
            "expected relmse<BOUND, error<BOUND or de<BOUND, for example 'relmse<1e-3', 'error<1%' or 'de<0.5'"
                .to_owned()
        };
        let (name, bound) = text.split_once('<').ok_or_else(wrong)?;
        let measure = match name.trim() {
            "relmse" => ErrorMeasure::RelMse,
            "error" => ErrorMeasure::Error,
            "de" => ErrorMeasure::ColourDifference,
            _ => return Err(wrong()),
        };
        let bound = bound.trim();
        let (number, unit) = bound.strip_suffix('%').map_or((bound, 1.0), |number| (number, 0.01));
        let bound = unit * number.trim().parse::<f64>().map_err(|_| wrong())?;
        if bound > 0.0 && bound.is_finite() { Ok(Self { measure, bound }) } else { Err(wrong()) }
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self.measure {
            ErrorMeasure::RelMse => write!(f, "relmse<{:e}", self.bound),
            ErrorMeasure::Error => write!(f, "error<{}%", in_percent(self.bound)),
            ErrorMeasure::ColourDifference => write!(f, "de<{}", self.bound),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{Extras, FixedPoint, Tristimulus};

    #[test]
    fn targets_are_read_as_they_are_written() {
        let read = |text: &str| text.parse::<Target>();
        assert_eq!(read("relmse<1e-3"), Ok(Target { measure: ErrorMeasure::RelMse, bound: 1e-3 }));
        assert_eq!(read("error < 2 %"), Ok(Target { measure: ErrorMeasure::Error, bound: 0.02 }));
        for wrong in ["relmse>1e-3", "relmse<", "relmse<0", "noise<1", "error<nan", "error<-1%"] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
        assert_eq!(read("de<0.5"), Ok(Target { measure: ErrorMeasure::ColourDifference, bound: 0.5 }));
        for text in ["relmse<1e-3", "error<1%", "error<0.45%", "error<0.47%", "error<33.3%", "de<0.5"] {
            assert_eq!(read(text).map(|target| target.to_string()), Ok(text.to_owned()));
        }
    }

    #[test]
    fn decisions_are_few() {
        let at: Vec<u64> = (0..70).filter(|&samples| Target::decides_at(samples)).collect();
        assert_eq!(at, [4, 6, 8, 10, 12, 14, 16, 20, 24, 28, 32, 40, 48, 56, 64]);
    }

    /// Where many tiles err alike, the bound is that of a normal distribution. Where one errs more than all
    /// others, it has the degrees of freedom of its replicates alone.
    #[test]
    fn bounds_are_wide_where_few_tiles_err() {
        let target = Target { measure: ErrorMeasure::RelMse, bound: 1.0 };
        let sum = |errors, squares| Sum { errors, squares, divisor: 1.0 };
        for tiles in [1e4f64, 1e6, 1e9] {
            let normal = 1.0 + 1.644854 * (2.0 / 3.0 / tiles).sqrt();
            let found = target.most_over_found(&sum(tiles, tiles), 4);
            assert!((found - normal).abs() < 1e-3, "{tiles}: {found} for {normal}");
        }
        let lonely = target.most_over_found(&sum(1.0 + 1e-3, 1.0 + 1e-9), 4);
        assert!((lonely - 3.0 / 0.351846).abs() < 0.1, "{lonely}");
        assert_eq!(target.most_over_found(&sum(0.0, 0.0), 4), 1.0);
    }

    /// Pixels of the value 3, of which four replicates have 2, 2, 4 and 4: a variance of the mean of 1/3.
    #[test]
    fn errors_are_those_of_their_definition() {
        let mut film = Film::new(16, 8, 4, Extras::default(), FixedPoint::for_reference(1.0));
        let mut tile = film.extras.tile([0, 0], [16, 8], 0..4);
        for place in 0..tile.pixel_count() {
            for (replicate, value) in (0..).zip([2.0, 4.0, 2.0, 4.0]) {
                tile.add(place, replicate, 1, value, film.scale());
                tile.add_weighed(place, replicate, &Tristimulus::BLACK, 1.0);
            }
        }
        film.add(&tile);
        let of = |measure| Target { measure, bound: 0.05 }.estimate(&film).expect("it is known");
        let relmse = of(ErrorMeasure::RelMse);
        let expected = 1.0 / 3.0 / (9.0 + 0.09);
        assert!((relmse.value / expected - 1.0).abs() < 1e-9, "{relmse:?}");
        // Two tiles of three degrees of freedom: χ² with six is below 1.6354 in one of twenty cases.
        assert!((relmse.at_most / (expected * 6.0 / 1.635383) - 1.0).abs() < 1e-6, "{relmse:?}");
        assert!((of(ErrorMeasure::Error).value - (1.0f64 / 3.0).sqrt() / 3.0).abs() < 1e-9);
        // Two replicates are below the mean and two above it, by √3 times the error of the mean.
        let difference = |of: [f64; 3]| {
            // The mean of the picture is 18 % of its white.
            let white = rec709_to_xyz([1.0; 3]) * (3.0 / 0.18);
            delta_e_2000(Xyz::from([0.0, 3.0, 0.0]).to_lab(white), Xyz::from(of).to_lab(white))
        };
        let error = (1.0f64 / 3.0).sqrt();
        let both = [3.0 - error, 3.0 + error].map(|y| difference([0.0, y, 0.0]).powi(2));
        let expected = (0.5 * (both[0] + both[1])).sqrt();
        let found = of(ErrorMeasure::ColourDifference);
        assert!((found.value / expected - 1.0).abs() < 1e-9, "{found:?} for {expected}");
        let target = Target { measure: ErrorMeasure::RelMse, bound: 0.05 };
        assert!(relmse.value < 0.05 && relmse.at_most > 0.05 && !target.is_met(Some(relmse)));
        assert!(!target.is_met(None));
        let black = Film::new(16, 8, 4, Extras::default(), FixedPoint::for_reference(1.0));
        assert_eq!(target.estimate(&black), None);
        assert_eq!(Target { measure: ErrorMeasure::ColourDifference, ..target }.estimate(&black), None);
    }

    /// A response that sees only black has no error, and halves the mean over both.
    #[test]
    fn a_black_response_has_no_error() {
        let of = |responses: usize| {
            let extras = Extras { responses: vec![1.0; responses], ..Extras::default() };
            let mut film = Film::new(8, 8, 4, extras, FixedPoint::for_reference(1.0));
            let mut tile = film.extras.tile([0, 0], [8, 8], 0..4);
            for place in 0..tile.pixel_count() {
                for (replicate, value) in (0..).zip([2.0, 4.0, 2.0, 4.0]) {
                    tile.add(place, replicate, film.extras.response_channel(0), value, film.scale());
                    tile.add_weighed(place, replicate, &Tristimulus::BLACK, 1.0);
                }
            }
            film.add(&tile);
            Target { measure: ErrorMeasure::RelMse, bound: 0.05 }.estimate(&film).expect("it is known").value
        };
        assert!((of(1) / of(2) - 2.0).abs() < 1e-12, "{} {}", of(1), of(2));
    }
}
