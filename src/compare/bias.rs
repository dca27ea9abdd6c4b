//! Whether the difference of two pictures is more than their noise: Welch's t-test of each pixel, of each
//! tile and of the whole mean, and the smallest bias that these tests could have seen.

use super::noise::{Cell, CellMean, Cells};
use super::pair::{Channel, Pair};
use crate::output::error_bars;
use crate::stats::{Estimate, sidak_corrected, student_quantile, uniformity, welch};

/// Edge of a tile, pixels; those at the right and lower border may be smaller.
pub const TILE: usize = crate::film::NOISE_TILE as usize;

/// A bias of the detectable size would be found at this level with this power.
pub const LEVEL: f64 = 0.05;
/// Probability with which a bias of the detectable size is found.
pub const POWER: f64 = 0.9;

/// Cells of the histogram of p-values.
pub const CELLS: usize = 20;

/// What the tests say of one channel. Pixels and tiles of which both sides are certain and that are equal
/// tell nothing: no test counts them.
#[derive(Clone, Debug, PartialEq)]
pub struct Tests {
    /// Standard error of the difference of the means.
    pub error: f64,
    /// p-value of the means of the whole picture.
    pub p_mean: f64,
    /// The smallest of all tiles and of all pixels, corrected for their number (Šidák 1967): how likely one
    /// as small is anywhere in pictures that differ by noise alone.
    pub p_tiles: f64,
    /// The smallest of all pixels, likewise.
    pub p_pixels: f64,
    /// Whether the p-values of the pixels that have noise of their own are uniform, by Kolmogorov and
    /// Smirnov.
    pub p_uniform: f64,
    /// Their histogram over 0 to 1.
    pub histogram: [u64; CELLS],
    /// Pixels without noise on either side: left out of the histogram.
    pub noiseless: u64,
    /// Pixels whose error is that of their neighbours alone: equal on both sides, or without noise of their
    /// own on one, such as black ones beside a body. Left out of the histogram, in which they would be a peak
    /// at 1.
    pub borrowed: u64,
    /// The smallest difference of the means that would be found with [`POWER`] at [`LEVEL`], over the
    /// reference's mean.
    pub detectable: f64,
    /// The same for the median tile, at the level that is corrected for the number of tiles.
    pub detectable_tile: f64,
    /// For each pixel the difference over its standard error, and its p-value; NaN where it cannot be
    /// compared.
    pub z: Vec<f64>,
    /// p-value of each pixel, from 0 to 1; NaN likewise.
    pub p: Vec<f64>,
}

/// Tests a channel of which one side at least knows its noise. `good` says which pixels can be compared.
pub fn test(pair: &Pair, channel: &Channel, good: &[bool]) -> Tests {
    let mut z = vec![f64::NAN; good.len()];
    let mut p = z.clone();
    let (mut own, mut histogram, mut tested, mut noiseless, mut borrowed) = (Vec::new(), [0; CELLS], 0, 0, 0);
    let pixels = means(channel, &Cells::new(pair, Cell::Pixel), good);
    let around = around(&pixels, pair);
    let mut pixels_p = 1.0f64;
    for (pixel, means) in pixels.into_iter().enumerate() {
        let Some([a, b]) = means else { continue };
        let found = welch(&a.estimate, &b.estimate);
        (z[pixel], p[pixel]) = (found.t, found.p_value);
        let differs = a.estimate.mean != b.estimate.mean;
        let is_noisy = a.is_noisy || b.is_noisy;
        tested += usize::from(is_noisy || differs);
        pixels_p = pixels_p.min(p_of_worst(&a.estimate, &b.estimate, around[pixel]));
        noiseless += u64::from(!is_noisy);
        let is_borrowed = is_noisy && (!differs || a.is_borrowed || b.is_borrowed);
        borrowed += u64::from(is_borrowed);
        if is_noisy && !is_borrowed {
            own.push(found.p_value);
            histogram[((found.p_value * CELLS as f64) as usize).min(CELLS - 1)] += 1;
        }
    }

    let tells = |[a, b]: &[CellMean; 2]| a.is_noisy || b.is_noisy || a.estimate.mean != b.estimate.mean;
    let tiles: Vec<[Estimate; 2]> = means(channel, &Cells::new(pair, Cell::Tile), good)
        .into_iter()
        .flatten()
        .filter(tells)
        .map(|both| both.map(|mean| mean.estimate))
        .collect();
    let level = crate::stats::sidak(LEVEL, tiles.len());
    let mut seen: Vec<f64> =
        tiles.iter().map(|tile| detectable(tile, level)).filter(|fraction| fraction.is_finite()).collect();
    seen.sort_by(f64::total_cmp);
    let whole = means(channel, &Cells::new(pair, Cell::Picture), good).into_iter().flatten().next();
    let whole = whole.map_or([Estimate::exact(0.0); 2], |both| both.map(|mean| mean.estimate));
    let tiles_p = tiles.iter().map(|[a, b]| welch(a, b).p_value).fold(1.0, f64::min);
    Tests {
        error: (whole[0].variance + whole[1].variance).sqrt(),
        p_mean: welch(&whole[0], &whole[1]).p_value,
        p_tiles: sidak_corrected(tiles_p, tiles.len()),
        p_pixels: sidak_corrected(pixels_p, tested),
        p_uniform: uniformity(&own).p_value,
        histogram,
        noiseless,
        borrowed,
        detectable: detectable(&whole, LEVEL),
        detectable_tile: seen.get(seen.len() / 2).copied().unwrap_or(f64::NAN),
        z,
        p,
    }
}

/// The mean, over a pixel and its neighbours, of the variance of the difference of both sides.
fn around(pixels: &[Option<[CellMean; 2]>], pair: &Pair) -> Vec<f64> {
    let variance = |[a, b]: &[CellMean; 2]| a.estimate.variance + b.estimate.variance;
    let around = |pixel: usize| {
        let place = [pixel % pair.width, pixel / pair.width];
        let near = error_bars::near([pair.width, pair.height], place);
        let known = near.filter_map(|near| pixels[near].as_ref().map(variance));
        error_bars::finite_sum(known).map_or(0.0, |[sum, count]| sum / count)
    };
    (0..pixels.len()).map(around).collect()
}

/// The p-value of a pixel as one of many of which the smallest counts. Tails decide there, and those of few
/// skewed samples are long: on the edge of a body some pixel has an error that is a quarter of what it should
/// be, in any picture. So the variance is at least twice that of the pixels around, and what these lend is no
/// degree of freedom. Pictures of one scene then pass, whose edges are sharp
/// (`tests/statistical/shared_noise.rs`).
fn p_of_worst(a: &Estimate, b: &Estimate, around: f64) -> f64 {
    let times = (2.0 * around / (a.variance + b.variance)).max(1.0);
    let [a, b] = [a, b].map(|estimate| Estimate {
        variance: estimate.variance * if times.is_finite() { times } else { 1.0 },
        degrees: estimate.degrees / error_bars::LENT,
        ..*estimate
    });
    welch(&a, &b).p_value
}

/// Both sides' means of each cell; `None` for cells without pixels that can be compared.
fn means(channel: &Channel, cells: &Cells, good: &[bool]) -> Vec<Option<[CellMean; 2]>> {
    let both = channel.a.means(cells, good).into_iter().zip(channel.b.means(cells, good));
    both.map(|(a, b)| Some([a?, b?])).collect()
}

/// The smallest relative difference that a two-sided test at `level` finds with [`POWER`]: (t(1 − level/2) +
/// t(power)) standard errors over the reference's mean. The quantiles are Student's, which is close to the
/// noncentral law.
fn detectable([a, b]: &[Estimate; 2], level: f64) -> f64 {
    let degrees = welch(a, b).degrees;
    let quantiles = student_quantile(1.0 - 0.5 * level, degrees) + student_quantile(POWER, degrees);
    quantiles * (a.variance + b.variance).sqrt() / b.mean.abs()
}
