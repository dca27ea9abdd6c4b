//! What a film says of one pixel and of means over several, each with its standard error.
//!
//! A sample that is splatted onto several pixels, light subpaths, and groups of pixels that share work give
//! neighbouring pixels noise in common. The error of a mean over pixels is therefore that of the replicates'
//! means over them, not what the pixels' own errors would add up to.

use super::{Extent, Film, FixedPoint, Measured, Region, Sums, WEIGHT};
use rayon::prelude::*;
use smallvec::{SmallVec, smallvec};

/// A linear function of the channels of a film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Quantity {
    /// Σ wᵢ·XYZᵢ for three weights.
    Combined([f64; 3]),
    /// The fraction of the samples that meet something.
    Alpha,
    /// The integral of the spectral radiance over a response of the sensor.
    Response(usize),
    /// The mean spectral radiance within a bin, per nm.
    Bin(usize),
    /// The mean over the samples of the square of X, Y or Z.
    SecondMoment(usize),
}

/// Edge of the tiles of [`PictureNoise`], pixels.
pub const NOISE_TILE: u32 = 8;

/// What the pixels that are shown have in common in their noise.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureNoise {
    /// The mean over all of them.
    pub mean: Measured,
    /// The variance of the mean over a tile of [`NOISE_TILE`] × [`NOISE_TILE`] pixels, over what it would be
    /// if its pixels were independent: 1 if they are, above where neighbours err alike. Pooled over all whole
    /// tiles; `None` where there is no such tile, or no noise.
    pub of_tiles: Option<f64>,
    /// The variance of the sum over each tile, row by row, also of those that are smaller at the border.
    pub tiles: Vec<f64>,
    /// The same as nets tell them (see [`Film::nets`]); empty where there are none.
    pub tiles_of_nets: Vec<f64>,
    /// What runs and nets tell of the sums over squares of 1, 2, 4 and 8 pixels; 0 where there are no nets.
    pub squares: [Told; SIZES],
}

/// Sizes of squares within a tile: its pixels, and squares of twice the edge each, up to the tile.
const SIZES: usize = NOISE_TILE.ilog2() as usize + 1;

/// The variances of sums over squares of one size, added up: as runs of replicates tell them, and as nets do.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Told {
    /// The variances that runs tell.
    pub runs: f64,
    /// Their squares.
    pub squares: f64,
    /// The variances that nets tell.
    pub nets: f64,
}

impl Told {
    /// Adds a square. One whose variance is not known says nothing.
    fn add(&mut self, runs: f64, nets: f64) {
        if runs.is_finite() && nets.is_finite() {
            self.runs += runs;
            self.squares += runs * runs;
            self.nets += nets;
        }
    }

    fn merge(&mut self, other: Self) {
        self.runs += other.runs;
        self.squares += other.squares;
        self.nets += other.nets;
    }
}

/// What [`Film::noise`] is made of, for several quantities at once and some rows at a time.
#[derive(Debug)]
pub struct NoiseSums {
    of_quantities: Vec<(Quantity, NoiseSum)>,
    replicates: u32,
    nets: Option<u32>,
    /// Rows of tiles that are in it.
    tile_rows: u32,
}

#[derive(Debug)]
struct NoiseSum {
    all: Sum,
    /// The variances of the sums over whole tiles, and what they would be if pixels were independent.
    found: f64,
    independent: f64,
    /// As in [`PictureNoise`].
    tiles: Vec<f64>,
    tiles_of_nets: Vec<f64>,
    squares: [Told; SIZES],
}

impl NoiseSums {
    /// Sums for some quantities of a film.
    pub fn new(film: &Film, quantities: impl IntoIterator<Item = Quantity>) -> Self {
        let replicates = film.replicates;
        let empty = |quantity| {
            let (tiles, tiles_of_nets) = (Vec::new(), Vec::new());
            let (all, squares) = (Sum::new(replicates), Default::default());
            (quantity, NoiseSum { all, found: 0.0, independent: 0.0, tiles, tiles_of_nets, squares })
        };
        let of_quantities = quantities.into_iter().map(empty).collect();
        Self { of_quantities, replicates, nets: film.nets(), tile_rows: 0 }
    }

    /// Adds the tiles that end before a row of what is shown, and are not in it yet. With the last row, all
    /// of them.
    pub fn add_up_to(&mut self, film: &Film, row: u32) {
        let Extent { shown, .. } = film.extent;
        let is_last = row >= shown.size[1];
        let end = if is_last { shown.size[1].div_ceil(NOISE_TILE) } else { row / NOISE_TILE };
        let quantities: Vec<Quantity> = self.of_quantities.iter().map(|&(quantity, _)| quantity).collect();
        let rows = self.tile_rows..end;
        self.tile_rows = end.max(self.tile_rows);
        let found: Vec<Vec<(Region, Vec<TileSum>)>> =
            rows.into_par_iter().map(|row| tiles_of_row(film, &quantities, row)).collect();
        for (tile, sums) in found.iter().flatten() {
            let is_whole = tile.pixel_count() == Region::whole([NOISE_TILE; 2]).pixel_count();
            for ((_, noise), TileSum { sum, squares }) in self.of_quantities.iter_mut().zip(sums) {
                if is_whole && sum.independent.is_finite() {
                    noise.found += sum.variance(self.replicates);
                    noise.independent += sum.independent;
                }
                noise.tiles.push(sum.variance(self.replicates));
                noise.tiles_of_nets.extend(self.nets.map(|nets| sum.variance(nets)));
                noise.squares.iter_mut().zip(squares).for_each(|(all, &own)| all.merge(own));
                noise.all.merge(sum);
            }
        }
    }

    /// For each quantity, in their order.
    pub fn told(self) -> Vec<PictureNoise> {
        let told = |(_, noise): (Quantity, NoiseSum)| PictureNoise {
            mean: noise.all.mean(self.replicates),
            of_tiles: (noise.independent > 0.0).then(|| noise.found / noise.independent),
            tiles: noise.tiles,
            tiles_of_nets: noise.tiles_of_nets,
            squares: noise.squares,
        };
        self.of_quantities.into_iter().map(told).collect()
    }
}

/// The tiles of a row of them, each with the sums of its pixels.
fn tiles_of_row(film: &Film, quantities: &[Quantity], row: u32) -> Vec<(Region, Vec<TileSum>)> {
    let Extent { shown, .. } = film.extent;
    let top = row * NOISE_TILE;
    let row = Region {
        offset: [shown.offset[0], shown.offset[1] + top],
        size: [shown.size[0], NOISE_TILE.min(shown.size[1] - top)],
    };
    row.tiles(NOISE_TILE).map(|tile| (tile, TileSum::of(film, quantities, tile, SIZES - 1))).collect()
}

/// The sum over a tile or over a square within it, and what is told of it and of all squares within it.
#[derive(Debug)]
struct TileSum {
    sum: Sum,
    squares: [Told; SIZES],
}

impl TileSum {
    /// For each quantity, over a square with an edge of 2^`size` pixels, or what there is of it at a border.
    fn of(film: &Film, quantities: &[Quantity], square: Region, size: usize) -> Vec<Self> {
        let empty = || Self { sum: Sum::new(film.replicates), squares: Default::default() };
        let mut found: Vec<Self> = quantities.iter().map(|_| empty()).collect();
        if size == 0 {
            for [x, y] in square.pixels().filter_map(|pixel| film.extent.measured.within(pixel)) {
                // Pixel by pixel: the bins of a pixel lie together.
                let pixel = film.pixel(x, y);
                for (own, &quantity) in found.iter_mut().zip(quantities) {
                    own.sum.add(&pixel, quantity);
                }
            }
        } else {
            for quarter in square.tiles(1 << (size - 1)) {
                for (own, part) in found.iter_mut().zip(Self::of(film, quantities, quarter, size - 1)) {
                    own.sum.merge(&part.sum);
                    own.squares.iter_mut().zip(part.squares).for_each(|(all, part)| all.merge(part));
                }
            }
        }
        if let Some(nets) = film.nets() {
            for Self { sum, squares } in &mut found {
                squares[size].add(sum.variance(film.replicates), sum.variance(nets));
            }
        }
        found
    }
}

/// The sum over some pixels of a quantity.
#[derive(Debug)]
struct Sum {
    pixels: f64,
    sum: f64,
    /// By replicate: by how much it is above the others, to first order.
    deviations: Replicates,
    /// By replicate: the weights of the samples.
    weights: Replicates,
    /// What the pixels' own variances add up to.
    independent: f64,
}

impl Sum {
    fn new(replicates: u32) -> Self {
        let zeros = smallvec![0.0; replicates as usize];
        Self { pixels: 0.0, sum: 0.0, deviations: zeros.clone(), weights: zeros, independent: 0.0 }
    }

    /// Adds a pixel. One without samples makes the error infinite.
    fn add(&mut self, pixel: &Pixel, quantity: Quantity) {
        self.pixels += 1.0;
        let Some((mean, deviations)) = pixel.linearised(quantity) else {
            self.independent = f64::INFINITY;
            return;
        };
        add_each(&mut self.deviations, &deviations);
        add_each(&mut self.weights, &pixel.weights);
        self.sum += mean;
        self.independent += variance(pixel.film.replicates, &deviations, &pixel.weights);
    }

    fn merge(&mut self, other: &Self) {
        self.pixels += other.pixels;
        self.sum += other.sum;
        self.independent += other.independent;
        add_each(&mut self.deviations, &other.deviations);
        add_each(&mut self.weights, &other.weights);
    }

    /// The variance of the sum, as so many equal runs of replicates tell it.
    fn variance(&self, parts: u32) -> f64 {
        match self.independent.is_finite() {
            true => variance(parts, &self.deviations, &self.weights),
            false => f64::INFINITY,
        }
    }

    fn mean(&self, replicates: u32) -> Measured {
        if self.pixels == 0.0 {
            return Measured { mean: 0.0, error: f64::INFINITY };
        }
        Measured { mean: self.sum / self.pixels, error: self.variance(replicates).sqrt() / self.pixels }
    }
}

impl Film {
    /// A pixel, for several quantities of it.
    pub fn pixel(&self, x: u32, y: u32) -> Pixel<'_> {
        let replicates = self.replicates as usize;
        let first = self.index(x, y) * replicates;
        let weight = |cell: usize| self.sums.of(cell, WEIGHT) as f64 * FixedPoint::SHARE.quantum;
        let weights: Replicates = (first..first + replicates).map(weight).collect();
        Pixel { film: self, first, weights }
    }

    /// A quantity of a pixel.
    pub fn measured(&self, x: u32, y: u32, quantity: Quantity) -> Measured {
        self.measured_by(self.replicates, x, y, quantity)
    }

    /// The same with the error that equal runs of replicates tell, which are `parts` in number: see
    /// [`Self::nets`].
    pub fn measured_by(&self, parts: u32, x: u32, y: u32, quantity: Quantity) -> Measured {
        let [measured] = self.pixel(x, y).measured_by([parts], quantity);
        measured
    }

    /// X, Y and Z of a pixel, and by how much each of `parts` equal runs of replicates is above them, to
    /// first order. `None` without samples.
    pub fn colour_by(&self, parts: u32, x: u32, y: u32) -> Option<([f64; 3], Vec<[f64; 3]>)> {
        let (mut mean, mut deviations) = ([0.0; 3], vec![[0.0; 3]; parts as usize]);
        let pixel = self.pixel(x, y);
        for of in 0..3 {
            let mut weights = [0.0; 3];
            weights[of] = 1.0;
            let (own, of_replicates) = pixel.linearised(Quantity::Combined(weights))?;
            mean[of] = own;
            for (part, deviation) in
                deviations.iter_mut().zip(of_parts(parts, &of_replicates, &pixel.weights))
            {
                part[of] = deviation;
            }
        }
        Some((mean, deviations))
    }

    /// The mean of a quantity over some pixels. Its error is known with one degree of freedom less than there
    /// are replicates, however many pixels there are. Infinite with a pixel that has no samples, and for no
    /// pixels.
    pub fn mean_over(&self, pixels: impl IntoIterator<Item = (u32, u32)>, quantity: Quantity) -> Measured {
        let mut sum = Sum::new(self.replicates);
        for (x, y) in pixels {
            sum.add(&self.pixel(x, y), quantity);
        }
        sum.mean(self.replicates)
    }

    /// What the noise of the pixels that are shown has in common.
    pub fn noise(&self, quantity: Quantity) -> PictureNoise {
        let mut sums = NoiseSums::new(self, [quantity]);
        sums.add_up_to(self, self.extent.shown.size[1]);
        sums.told().remove(0)
    }

    /// A quantity, in the unit of its sums, from the sum of each channel.
    #[inline]
    fn value(&self, quantity: Quantity, sum: impl Fn(usize) -> i64) -> f64 {
        let extras = &self.extras;
        match quantity {
            Quantity::Combined(weights) => (0..3).map(|i| weights[i] * sum(i) as f64).sum::<f64>(),
            Quantity::Alpha => sum(extras.alpha_channel()) as f64,
            Quantity::Response(index) => extras.responses[index] * sum(extras.response_channel(index)) as f64,
            Quantity::Bin(bin) => sum(extras.bin_channel(bin)) as f64,
            Quantity::SecondMoment(of) => sum(extras.moment_channel(of)) as f64,
        }
    }

    fn scale_of(&self, quantity: Quantity) -> FixedPoint {
        match quantity {
            Quantity::Alpha => FixedPoint::SHARE,
            Quantity::SecondMoment(_) => self.square_scale(),
            _ => self.scale,
        }
    }
}

/// A value for each replicate.
type Replicates = SmallVec<[f64; 16]>;

/// A pixel of a film: what all its quantities have in common.
#[derive(Debug)]
pub struct Pixel<'a> {
    film: &'a Film,
    /// The cell of its first replicate.
    first: usize,
    /// By replicate: the sum of the weights of its samples.
    weights: Replicates,
}

impl Pixel<'_> {
    /// A quantity, with the errors that equal runs of replicates tell, for each of these numbers of runs.
    pub fn measured_by<const N: usize>(&self, parts: [u32; N], quantity: Quantity) -> [Measured; N] {
        let Some((mean, deviations)) = self.linearised(quantity) else {
            return [Measured { mean: 0.0, error: f64::INFINITY }; N];
        };
        parts.map(|parts| Measured { mean, error: variance(parts, &deviations, &self.weights).sqrt() })
    }

    /// The mean and the replicates' deviations from it, of the pixel's samples and of light subpaths
    /// together. `None` without samples.
    fn linearised(&self, quantity: Quantity) -> Option<(f64, Replicates)> {
        let film = self.film;
        let of = |sums: &Sums, quantum: f64, weights: &[f64]| {
            let cells = self.first..self.first + weights.len();
            let value = |cell| film.value(quantity, |channel| sums.of(cell, channel)) * quantum;
            linearised(cells.map(value).collect(), weights)
        };
        let own = of(&film.sums, film.scale_of(quantity).quantum, &self.weights)?;
        if film.light.is_empty() {
            return Some(own);
        }
        let counts: Replicates = film.light.count.iter().map(|&count| count as f64).collect();
        let Some((light, of_light)) = of(&film.light.sums, film.light.scale.quantum, &counts) else {
            return Some(own);
        };
        let (own, mut deviations) = own;
        add_each(&mut deviations, &of_light);
        Some((own + light, deviations))
    }
}

/// The sum of the replicates' values over that of their weights. Also, for each replicate, how far it lies
/// above that mean: what it adds to the ratio, to first order. `None` without weight.
fn linearised(mut values: Replicates, weights: &[f64]) -> Option<(f64, Replicates)> {
    let weight: f64 = weights.iter().sum();
    if weight == 0.0 {
        return None;
    }
    let (ratio, share) = (values.iter().sum::<f64>() / weight, values.len() as f64 / weight);
    for (value, weight) in values.iter_mut().zip(weights) {
        *value = (*value - ratio * weight) * share;
    }
    Some((ratio, values))
}

fn add_each(own: &mut [f64], more: &[f64]) {
    own.iter_mut().zip(more).for_each(|(own, more)| *own += more);
}

/// How far each of so many equal runs of replicates lies above the mean, where replicates of these weights
/// lie so far above it. Runs without samples say nothing: the others stand for them.
fn of_parts(parts: u32, deviations: &[f64], weights: &[f64]) -> impl Iterator<Item = f64> {
    let run = (deviations.len() / parts.max(1) as usize).max(1);
    let is_met = |run: &&[f64]| run.iter().any(|&weight| weight != 0.0);
    let with_samples = weights.chunks_exact(run).filter(is_met).count();
    let (all, some) = (f64::from(parts), with_samples as f64);
    let factor = match parts >= 2 && some < all {
        true => (some / (some - 1.0) * (all - 1.0) / all).sqrt(),
        false => 1.0,
    };
    deviations.chunks_exact(run).map(move |run| match factor.is_finite() {
        true => factor * run.iter().sum::<f64>() / run.len() as f64,
        false => f64::INFINITY,
    })
}

/// The variance of the mean, as so many equal runs of replicates of these weights and deviations tell it.
/// Infinite for fewer than two.
fn variance(parts: u32, deviations: &[f64], weights: &[f64]) -> f64 {
    let spread: f64 = of_parts(parts, deviations, weights).map(|deviation| deviation * deviation).sum();
    let r = f64::from(parts);
    if parts < 2 { f64::INFINITY } else { spread / (r * (r - 1.0)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{Extras, Tristimulus};

    const Y: Quantity = Quantity::Combined([0.0, 1.0, 0.0]);

    /// A film whose samples have these values of Y and weights, by pixel and replicate.
    fn film([width, height]: [u32; 2], replicates: u32, sample: impl Fn(u32, u32, u32) -> [f64; 2]) -> Film {
        let mut film =
            Film::new(width, height, replicates, Extras::default(), FixedPoint::for_reference(1.0));
        let mut tile = film.extras.tile([0, 0], [width, height], 0..replicates);
        for [x, y] in Region::whole([width, height]).pixels() {
            let place = tile.place(x, y).expect("it is in the tile");
            for replicate in 0..replicates {
                let [value, weight] = sample(x, y, replicate);
                tile.add(place, replicate, 1, value * weight, film.scale());
                tile.add_weighed(place, replicate, &Tristimulus::BLACK, weight);
            }
        }
        film.add(&tile);
        film
    }

    /// The values of four replicates: mean 3, variance of the mean (4 + 0 + 1 + 9) / (4·3).
    const VALUES: [f64; 4] = [1.0, 3.0, 2.0, 6.0];

    #[test]
    fn pixels_that_err_alike_have_the_error_of_one() {
        let error = (14.0f64 / 12.0).sqrt();
        let alike = film([4, 2], 4, |x, _, replicate| [VALUES[replicate as usize] + f64::from(x), 1.0]);
        let found = alike.mean_over(alike.shown(), Y);
        assert!((found.mean - 4.5).abs() < 1e-12 && (found.error - error).abs() < 1e-12, "{found:?}");
        // Errors of two pixels that err against one another cancel.
        let against = film([2, 1], 4, |x, _, replicate| {
            let value = VALUES[replicate as usize];
            [if x == 0 { value } else { 8.0 - value }, 1.0]
        });
        let found = against.mean_over(against.shown(), Y);
        assert!((found.mean - 4.0).abs() < 1e-12 && found.error < 1e-12, "{found:?}");
        assert!((against.measured(1, 0, Y).error - error).abs() < 1e-12);
        // Some of the pixels, and none.
        assert_eq!(alike.mean_over([(3, 1)], Y), alike.measured(3, 1, Y));
        assert_eq!(alike.mean_over([], Y).error, f64::INFINITY);
    }

    /// With weights w and values v, each replicate is above the mean m by w (v − m) over the mean weight.
    #[test]
    fn weights_of_replicates_differ() {
        let weights = [1.0, 2.0, 0.5, 0.5];
        let film = film([3, 1], 4, |x, _, replicate| {
            let replicate = replicate as usize;
            [VALUES[replicate] * f64::from(x + 1), weights[replicate]]
        });
        // (1 + 6 + 1 + 3) / 4 for the first pixel, and twice that on average.
        let mean = 2.75;
        let squares: f64 = (0..4).map(|i| (weights[i] * (VALUES[i] - mean)).powi(2)).sum();
        let found = film.mean_over(film.shown(), Y);
        assert!((found.mean - 2.0 * mean).abs() < 1e-11, "{found:?}");
        assert!((found.error - 2.0 * (squares / 12.0).sqrt()).abs() < 1e-11, "{found:?}");
    }

    /// A render that was stopped: what its light subpaths brought is divided by those that there were.
    #[test]
    fn replicates_without_samples_say_nothing() {
        let extras = Extras { light_paths: true, ..Extras::default() };
        let mut film = Film::new(1, 1, 4, extras, FixedPoint::for_reference(1.0));
        let mut tile = film.extras.tile([0, 0], [1, 1], 0..4);
        for replicate in 0..2 {
            tile.add(0, replicate, 1, VALUES[replicate as usize], film.scale());
            tile.add_weighed(0, replicate, &Tristimulus::BLACK, 1.0);
        }
        film.add(&tile);
        let mut light = film.extras.tile([0, 0], [1, 1], 0..1);
        for replicate in 0..2 {
            light.add(0, 0, 1, 20.0 * VALUES[replicate as usize], film.light_scale());
            film.add_light([0, 0], replicate, &light.take());
            film.count_light(replicate, 10);
        }
        // 1 and 3 of the pixel's own, and twice that of light subpaths.
        for found in [film.measured(0, 0, Y), film.mean_over([(0, 0)], Y), film.noise(Y).mean] {
            assert!((found.mean - 6.0).abs() < 1e-9 && (found.error - 3.0).abs() < 1e-9, "{found:?}");
        }
    }

    #[test]
    fn tiles_tell_what_their_pixels_share() {
        // Noise that four columns share, of a picture with two whole tiles and a border.
        let shared = film([18, 9], 4, |x, y, replicate| {
            let value = VALUES[(replicate as usize + (x / 4 % 2) as usize) % 4];
            [if x < 16 && y < 8 { value } else { 5.0 }, 1.0]
        });
        // A tile's sum in each replicate is 32 times that of two values that follow one another: 4, 5, 8, 7.
        let variance = 32.0 * 32.0 * (4.0 + 1.0 + 4.0 + 1.0) / 12.0;
        let noise = shared.noise(Y);
        let of_tiles = noise.of_tiles.expect("tiles with noise");
        assert!((of_tiles / (variance / (64.0 * 14.0 / 12.0)) - 1.0).abs() < 1e-12, "{of_tiles}");
        let all = shared.mean_over(shared.shown(), Y);
        assert!((noise.mean.mean - all.mean).abs() < 1e-12 && (noise.mean.error - all.error).abs() < 1e-12);
        assert!((all.error - 2.0 * variance.sqrt() / 162.0).abs() < 1e-12, "{all:?}");
        // No whole tile; no noise; a single replicate.
        assert_eq!(film([7, 9], 4, |_, _, r| [VALUES[r as usize], 1.0]).noise(Y).of_tiles, None);
        assert_eq!(film([8, 8], 4, |_, _, _| [2.0, 1.0]).noise(Y).of_tiles, None);
        let single = film([8, 8], 1, |_, _, _| [2.0, 1.0]).noise(Y);
        assert_eq!(
            single,
            PictureNoise {
                mean: Measured { mean: 2.0, error: f64::INFINITY },
                of_tiles: None,
                tiles: vec![f64::INFINITY],
                tiles_of_nets: Vec::new(),
                squares: Default::default(),
            }
        );
    }
}
