//! What is known of the noise of a side: of its pixels, and of means over some of them.
//!
//! A picture states the errors of its pixels, or several pictures show by their spread how uncertain they
//! are. Filters that splat each sample onto several pixels, and pixels that share light subpaths, give
//! neighbours noise in common: a file may state how much it makes of means over tiles and over the picture,
//! and the spread of several pictures needs no such statement.

use super::bias::TILE;
use super::pair::{Measurement, Pair};
use crate::output::error_bars;
use crate::output::exr::Channels;
use crate::stats::{Estimate, Moments};

/// Where the standard errors of a side come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Noise {
    /// One picture without errors: nothing is known but what storing its values may have changed.
    Unknown,
    /// Each picture states them.
    Stated,
    /// The spread of several pictures, not all of which state errors.
    Spread,
}

/// One channel as one picture has it.
#[derive(Clone, Debug)]
pub(super) struct Stored<'a> {
    values: &'a [f32],
    /// Standard error of each value.
    errors: Option<&'a [f32]>,
    /// Half a unit in the last place over the value: what storing it may have changed, at most.
    rounding: f64,
    /// Degrees of freedom of a pixel's error, and of what it lends to a mean over several: errors that were
    /// moderated by those of their neighbours are not independent, and what they have in common lends none.
    /// Infinite where the file does not say.
    degrees: [f64; 2],
    /// Columns of the picture.
    width: usize,
    /// For each tile how many times the variance of independent pixels its mean has, and the degrees of
    /// freedom of that. Empty where the file does not say.
    tiles: Vec<f64>,
    tile_degrees: f64,
    /// What the noise of pixels has in common: how many times the variance of independent pixels the mean
    /// over a tile has, and the mean over the picture. `None` where the file does not say.
    shared: [Option<f64>; 2],
}

/// What a picture is divided into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cell {
    Pixel,
    /// [`TILE`] × [`TILE`] pixels.
    Tile,
    Picture,
}

/// A division of a picture into square cells; those at the right and lower border may be smaller.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cells {
    width: usize,
    height: usize,
    cell: Cell,
}

/// A mean over the pixels of a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellMean {
    pub estimate: Estimate,
    /// Whether its error is above what storing the values may have changed.
    pub is_noisy: bool,
    /// Whether the error can only be that of the neighbours, by which it is moderated: all pictures are equal
    /// there, or it is black, as where no sample met anything.
    pub is_borrowed: bool,
}

impl Cells {
    pub fn new(pair: &Pair, cell: Cell) -> Self {
        Self { width: pair.width, height: pair.height, cell }
    }

    fn edge(&self) -> usize {
        match self.cell {
            Cell::Pixel => 1,
            Cell::Tile => TILE,
            Cell::Picture => self.width.max(self.height).max(1),
        }
    }

    fn across(&self) -> usize {
        self.width.div_ceil(self.edge())
    }

    fn down(&self) -> usize {
        self.height.div_ceil(self.edge())
    }

    /// The pixels of each cell, row by row.
    fn pixels(&self) -> impl Iterator<Item = impl Iterator<Item = usize>> {
        let (Self { width, height, .. }, edge) = (*self, self.edge());
        let corners =
            (0..height).step_by(edge).flat_map(move |y| (0..width).step_by(edge).map(move |x| (x, y)));
        corners.map(move |(left, top)| {
            let columns = left..(left + edge).min(width);
            (top..(top + edge).min(height)).flat_map(move |y| columns.clone().map(move |x| y * width + x))
        })
    }
}

impl<'a> Measurement<'a> {
    /// A channel of all pictures of a side; `None` if one lacks it.
    pub(super) fn of(pictures: &'a [Channels], name: &str) -> Option<Self> {
        let pictures =
            pictures.iter().map(|picture| Stored::of(picture, name)).collect::<Option<Vec<_>>>()?;
        let noise = match pictures.len() {
            _ if pictures.iter().all(|picture| picture.errors.is_some()) => Noise::Stated,
            1 => Noise::Unknown,
            _ => Noise::Spread,
        };
        let count = pictures.len() as f64;
        let pixels = pictures.first()?.values.len();
        let value = |pixel: usize| {
            pictures.iter().map(|picture| f64::from(picture.values[pixel])).sum::<f64>() / count
        };
        Some(Self { values: (0..pixels).map(value).collect(), noise, pictures })
    }

    /// Whether all pictures know a pixel: values, and errors where they are used, are finite.
    pub(super) fn is_good(&self, pixel: usize) -> bool {
        let is_known = |errors: &[f32]| self.noise != Noise::Stated || errors[pixel].is_finite();
        self.values[pixel].is_finite()
            && self.pictures.iter().all(|picture| picture.errors.is_none_or(is_known))
    }

    /// The mean of each cell over its pixels that are `good`; `None` for cells without any.
    pub(super) fn means(&self, cells: &Cells, good: &[bool]) -> Vec<Option<CellMean>> {
        let cells_pixels: Vec<Vec<usize>> =
            cells.pixels().map(|pixels| pixels.filter(|&pixel| good[pixel]).collect()).collect();
        let rounding = |pixels: &[usize]| {
            let count = (pixels.len() * self.pictures.len()) as f64;
            self.pictures.iter().map(|picture| picture.rounding(pixels)).sum::<f64>() / (count * count)
        };
        let measured = match self.noise {
            Noise::Spread => self.by_spread(cells, &cells_pixels),
            _ => {
                let mean = |pixels: &Vec<usize>| {
                    let pictures =
                        self.pictures.iter().filter_map(|picture| picture.mean(pixels, cells.cell));
                    let found = Estimate::mean_of(pictures)?;
                    Some((found, found.mean == 0.0))
                };
                cells_pixels.iter().map(mean).collect()
            }
        };
        let with_rounding = |(measured, pixels): (Option<(Estimate, bool)>, &Vec<usize>)| {
            let (measured, is_equal) = measured?;
            let rounding = rounding(pixels);
            let variance = measured.variance + rounding;
            let degrees = if measured.variance > 0.0 {
                measured.degrees * (variance / measured.variance).powi(2)
            } else {
                f64::INFINITY
            };
            let estimate = Estimate { variance, degrees, ..measured };
            let is_noisy = measured.variance > rounding;
            Some(CellMean { estimate, is_noisy, is_borrowed: is_noisy && is_equal })
        };
        measured.into_iter().zip(&cells_pixels).map(with_rounding).collect()
    }

    /// Each picture's mean of a cell is one value of it, whatever the noise of its pixels has in common. A
    /// few values leave open how uncertain they are, as a few replicates of one render do: the variances of
    /// cells are moderated in the same way.
    /// With each estimate, whether the pictures are equal there.
    fn by_spread(&self, cells: &Cells, cells_pixels: &[Vec<usize>]) -> Vec<Option<(Estimate, bool)>> {
        let moments = |pixels: &Vec<usize>| -> Moments {
            self.pictures.iter().filter_map(|picture| Some(picture.mean(pixels, Cell::Pixel)?.mean)).collect()
        };
        let found: Vec<Moments> = cells_pixels.iter().map(moments).collect();
        let variance = |found: &Moments| match found.count() {
            0 => f64::INFINITY,
            _ => found.estimate().variance,
        };
        let variances: Vec<f64> = found.iter().map(variance).collect();
        let size = [cells.across(), cells.down()].map(|count| count as u32);
        let moderated = error_bars::moderated(size, size, &variances);
        let degrees = error_bars::degrees(size, self.pictures.len() as u32);
        found
            .iter()
            .zip(moderated)
            .map(|(found, variance)| {
                let estimate = Estimate { mean: found.mean(), variance, degrees };
                (found.count() > 0).then_some((estimate, found.variance() == 0.0))
            })
            .collect()
    }
}

impl<'a> Stored<'a> {
    fn of(picture: &'a Channels, name: &str) -> Option<Self> {
        // 11 and 24 significant bits.
        let is_half = picture.half.iter().any(|half| half == name);
        let of_means =
            replicates(picture).map(|count| f64::from(count.saturating_sub(1))).filter(|&own| own > 0.0);
        let stated = picture.attribute("abbe.degreesOfFreedom").and_then(|text| text.parse().ok());
        let of_pixels = stated.filter(|&degrees: &f64| degrees > 0.0).or(of_means);
        let errors = picture.channel(&format!("error.{name}"));
        let across = [picture.width, picture.height].map(|size| size.div_ceil(TILE));
        let tiles = picture.tile_noises(name).filter(|tiles| tiles.len() == across[0] * across[1]);
        let tile_degrees = replicates(picture).map_or(f64::INFINITY, |replicates| {
            error_bars::degrees(across.map(|tiles| tiles as u32), replicates)
        });
        Some(Self {
            width: picture.width,
            tiles: tiles.unwrap_or_default(),
            tile_degrees,
            values: picture.channel(name)?,
            errors,
            shared: [picture.tile_noise(name), picture_noise(errors, picture.mean_error(name))],
            rounding: 2f64.powi(if is_half { -11 } else { -24 }),
            degrees: [of_pixels, of_means.or(of_pixels)].map(|degrees| degrees.unwrap_or(f64::INFINITY)),
        })
    }

    /// The mean over some pixels, which make up a cell or are what can be compared of it, with what is stated
    /// of its noise. `None` of no pixels.
    ///
    /// What the noise of pixels has in common is what the file says. The noise of pixels is taken to be
    /// independent where it says nothing.
    fn mean(&self, pixels: &[usize], cell: Cell) -> Option<Estimate> {
        let [of_pixel, lent] = self.degrees;
        let degrees = if cell == Cell::Pixel { of_pixel } else { lent };
        let independent = Estimate::mean_of(pixels.iter().map(|&pixel| Estimate {
            mean: f64::from(self.values[pixel]),
            variance: self.errors.map_or(0.0, |errors| f64::from(errors[pixel]).powi(2)),
            degrees,
        }))?;
        let [of_tile, of_picture] = self.shared;
        let scaled = |times: f64, degrees: f64| Estimate {
            variance: independent.variance * times,
            degrees,
            ..independent
        };
        let place = |pixel: usize| [pixel % self.width / TILE, pixel / self.width / TILE];
        let tile = pixels.first().map(|&pixel| place(pixel));
        let of_own = tile.and_then(|[x, y]| self.tiles.get(y * self.width.div_ceil(TILE) + x));
        // In a part of a tile, pixels that err against one another need not meet.
        let of_part = |times: f64| if pixels.len() < TILE * TILE { times.max(1.0) } else { times };
        Some(match (cell, of_tile, of_picture) {
            (Cell::Tile, ..) if let Some(&times) = of_own => scaled(of_part(times), self.tile_degrees),
            (Cell::Tile, Some(times), _) => {
                let times = of_part(times);
                // Pixels that err alike lend less to the variance, too: at most by as much, if all err alike.
                scaled(times, independent.degrees / times.max(1.0))
            }
            // It is one number in each replicate.
            (Cell::Picture, _, Some(times)) => scaled(times, lent),
            _ => independent,
        })
    }

    /// The variance that storing the values gives to the sum over some pixels: the deviation is uniform over
    /// two steps.
    fn rounding(&self, pixels: &[usize]) -> f64 {
        pixels.iter().map(|&pixel| (self.rounding * f64::from(self.values[pixel])).powi(2) / 3.0).sum()
    }
}

/// How many times the variance of independent pixels with these errors the mean over a picture has, whose own
/// error is stated. `None` without noise.
fn picture_noise(errors: Option<&[f32]>, mean_error: Option<f64>) -> Option<f64> {
    let (mut count, mut independent) = (0.0, 0.0);
    for &error in errors?.iter().filter(|error| error.is_finite()) {
        count += 1.0;
        independent += f64::from(error).powi(2);
    }
    let times = (mean_error? * count).powi(2) / independent;
    times.is_finite().then_some(times)
}

/// Replicates behind the errors of a picture, where it says so.
pub(super) fn replicates(picture: &Channels) -> Option<u32> {
    picture.attribute("abbe.replicates")?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::bias;

    /// The spread is that of the pictures' own means, so noise that neighbouring pixels share is not taken
    /// for that of many. How often pictures of one mean are told apart at the 5 % level, where blocks of
    /// pixels have one noise.
    #[test]
    fn noise_that_pixels_share_raises_no_alarms() {
        use rand_pcg::{Pcg64, rand_core::Rng};
        let mut generator = Pcg64::new(11, 0);
        let mut normal = || -> f64 {
            (0..12).map(|_| (generator.next_u64() >> 11) as f64 / (1u64 << 53) as f64).sum::<f64>() - 6.0
        };
        // 24 × 24 pixels in blocks of 4 × 4.
        let mut picture = || -> Channels {
            let blocks: Vec<f64> = (0..36).map(|_| 1.0 + 0.2 * normal()).collect();
            let values = (0..576).map(|i| blocks[i / 96 * 6 + i % 24 / 4] as f32).collect();
            let channels = vec![("Y".to_owned(), values)];
            Channels { width: 24, height: 24, channels, ..Channels::default() }
        };
        let trials = 200;
        let mut alarms = [0, 0];
        for _ in 0..trials {
            let sides = [0, 1].map(|_| (0..4).map(|_| picture()).collect::<Vec<_>>());
            let pair = Pair::new(&sides[0], &sides[1]).expect("files that can be compared");
            let tests = bias::test(&pair, &pair.channels[0], &[true; 576]);
            alarms[0] += u32::from(tests.p_mean < 0.05);
            alarms[1] += u32::from(tests.p_tiles < 0.05);
        }
        // Four standard errors of a fraction of 200 trials above 5 %: 11 %. Pixels taken as independent would
        // raise one in half of the trials.
        for count in alarms {
            assert!(f64::from(count) / f64::from(trials) < 0.11, "{alarms:?}");
        }
    }
}
