//! Whether the difference of two pictures is more than their noise: Welch's t-test of each pixel, of each tile and of the
//! whole mean, and the smallest bias that these tests could have seen.

use super::pair::{Channel, Measurement, Pair};
use crate::stats::{Estimate, sidak_corrected, student_quantile, uniformity, welch};

/// Edge of a tile, pixels; those at the right and lower border may be smaller.
pub const TILE: usize = 8;

/// A bias of the detectable size would be found at this level with this power.
pub const LEVEL: f64 = 0.05;
pub const POWER: f64 = 0.9;

/// Cells of the histogram of p-values.
pub const CELLS: usize = 20;

/// What the tests say of one channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Tests {
    /// Standard error of the difference of the means.
    pub error: f64,
    /// Of the means of the whole picture.
    pub p_mean: f64,
    /// The smallest of all tiles and of all pixels, corrected for their number (Šidák 1967): how likely one as small is
    /// anywhere in pictures that differ by noise alone.
    pub p_tiles: f64,
    pub p_pixels: f64,
    /// Whether the p-values of the pixels that have noise are uniform, by Kolmogorov and Smirnov.
    pub p_uniform: f64,
    /// Their histogram over 0 to 1.
    pub histogram: [u64; CELLS],
    /// Pixels without noise in either file: left out of the histogram.
    pub noiseless: u64,
    /// The smallest difference of the means that would be found with [`POWER`] at [`LEVEL`], over the reference's mean.
    pub detectable: f64,
    /// The same for the median tile, at the level that is corrected for the number of tiles.
    pub detectable_tile: f64,
    /// For each pixel the difference over its standard error, and its p-value; NaN where it cannot be compared.
    pub z: Vec<f64>,
    pub p: Vec<f64>,
}

/// Tests a channel of which one file at least states errors. `good` says which pixels can be compared.
pub fn test(pair: &Pair, channel: &Channel, good: &[bool]) -> Tests {
    let [degrees_a, degrees_b] = pair.degrees;
    let mut z = vec![f64::NAN; good.len()];
    let mut p = z.clone();
    let (mut noisy, mut histogram, mut count) = (Vec::new(), [0; CELLS], 0);
    for pixel in (0..good.len()).filter(|&pixel| good[pixel]) {
        count += 1;
        let (a, a_is_noisy) = channel.a.estimate(pixel, degrees_a);
        let (b, b_is_noisy) = channel.b.estimate(pixel, degrees_b);
        let found = welch(&a, &b);
        (z[pixel], p[pixel]) = (found.t, found.p_value);
        if a_is_noisy || b_is_noisy {
            noisy.push(found.p_value);
            histogram[((found.p_value * CELLS as f64) as usize).min(CELLS - 1)] += 1;
        }
    }
    let smallest = |values: &mut dyn Iterator<Item = f64>| values.filter(|p| !p.is_nan()).fold(1.0, f64::min);

    let tiles: Vec<[Estimate; 2]> = tiles(pair)
        .filter_map(|pixels| means(channel, pixels.iter().copied().filter(|&pixel| good[pixel]), pair))
        .collect();
    let level = crate::stats::sidak(LEVEL, tiles.len());
    let mut seen: Vec<f64> =
        tiles.iter().map(|tile| detectable(tile, level)).filter(|share| share.is_finite()).collect();
    seen.sort_by(f64::total_cmp);
    let all = (0..good.len()).filter(|&pixel| good[pixel]);
    let nothing = [Estimate::exact(0.0); 2];
    let whole = means(channel, all, pair).unwrap_or(nothing);
    let pixels_p = smallest(&mut p.iter().copied());
    let tiles_p = smallest(&mut tiles.iter().map(|[a, b]| welch(a, b).p_value));
    Tests {
        error: (whole[0].variance + whole[1].variance).sqrt(),
        p_mean: welch(&whole[0], &whole[1]).p_value,
        p_tiles: sidak_corrected(tiles_p, tiles.len()),
        p_pixels: sidak_corrected(pixels_p, count),
        p_uniform: uniformity(&noisy).p_value,
        histogram,
        noiseless: (count - noisy.len()) as u64,
        detectable: detectable(&whole, LEVEL),
        detectable_tile: seen.get(seen.len() / 2).copied().unwrap_or(f64::NAN),
        z,
        p,
    }
}

impl Measurement<'_> {
    /// A pixel's mean, and whether it has noise: an error above what storing the value may have changed, which is all
    /// that is known of a file without errors. `own` are the degrees of freedom of the error.
    fn estimate(&self, pixel: usize, own: f64) -> (Estimate, bool) {
        let mean = f64::from(self.values[pixel]);
        // Rounding is uniform over two such steps.
        let rounding = (self.rounding * mean).powi(2) / 3.0;
        let measured = self.errors.map_or(0.0, |errors| f64::from(errors[pixel]).powi(2));
        let variance = measured + rounding;
        let degrees = if measured > 0.0 { own * (variance / measured).powi(2) } else { f64::INFINITY };
        (Estimate { mean, variance, degrees }, measured > rounding)
    }
}

/// The pixels of each tile.
fn tiles(pair: &Pair) -> impl Iterator<Item = Vec<usize>> {
    let (width, height) = (pair.width, pair.height);
    let corners = (0..height).step_by(TILE).flat_map(move |y| (0..width).step_by(TILE).map(move |x| (x, y)));
    corners.map(move |(left, top)| {
        let rows = top..(top + TILE).min(height);
        rows.flat_map(|y| (left..(left + TILE).min(width)).map(move |x| y * width + x)).collect()
    })
}

/// Means of both files over some pixels, whose noise is independent; `None` of no pixels.
fn means(
    channel: &Channel,
    pixels: impl Iterator<Item = usize> + Clone,
    pair: &Pair,
) -> Option<[Estimate; 2]> {
    let mean = |side: usize, measurement: &Measurement| {
        // Errors that were moderated by those of their neighbours are not independent: what they have in common
        // lends no degrees of freedom to a mean.
        let own = pair.replicates[side].map_or(pair.degrees[side], |count| f64::from(count.max(2) - 1));
        Estimate::mean_of(pixels.clone().map(|pixel| measurement.estimate(pixel, own).0))
    };
    Some([mean(0, &channel.a)?, mean(1, &channel.b)?])
}

/// The smallest relative difference that a two-sided test at `level` finds with [`POWER`]: (t(1 − level/2) + t(power))
/// standard errors over the reference's mean. The quantiles are Student's, which is close to the noncentral law.
fn detectable([a, b]: &[Estimate; 2], level: f64) -> f64 {
    let degrees = welch(a, b).degrees;
    let quantiles = student_quantile(1.0 - 0.5 * level, degrees) + student_quantile(POWER, degrees);
    quantiles * (a.variance + b.variance).sqrt() / b.mean.abs()
}
