//! The channels of a picture, some rows at a time: what becomes of a film that is larger than memory.

use super::quantities;
use crate::film::{Extent, Film, Quantity, Region};
use crate::output::{Picture, error_bars};
use crate::render::Auxiliary;
use rayon::prelude::*;
use std::ops::Range;

/// What a channel of the file is.
#[derive(Clone, Copy, Debug)]
enum Source {
    /// A quantity of light, by its number.
    Mean(usize),
    Error(usize),
    Samples,
    /// An image beside the picture, by its number.
    Image(usize),
    ImageError(usize),
}

/// The channels of a file, and how their values come about.
pub(super) struct Bands<'a> {
    picture: &'a Picture<'a>,
    pub quantities: Vec<(String, Quantity)>,
    /// In the order of their names.
    channels: Vec<(String, Source)>,
}

/// What some pixels hold, channel by channel, with the squares of standard errors.
#[derive(Default)]
struct Values {
    means: Vec<f32>,
    variances: Vec<f64>,
    /// As nets tell them; empty where there are none.
    of_nets: Vec<f64>,
}

impl<'a> Bands<'a> {
    pub fn new(picture: &'a Picture<'a>) -> Self {
        let quantities = quantities(picture);
        let mut channels = vec![("samples".to_owned(), Source::Samples)];
        for (number, (name, _)) in quantities.iter().enumerate() {
            channels.push((name.clone(), Source::Mean(number)));
            if picture.has_errors() {
                channels.push((format!("error.{name}"), Source::Error(number)));
            }
        }
        for (number, Auxiliary { name, errors, .. }) in picture.auxiliary.iter().enumerate() {
            channels.push((name.clone(), Source::Image(number)));
            if errors.is_some() {
                channels.push((format!("error.{name}"), Source::ImageError(number)));
            }
        }
        channels.sort_by(|(a, _), (b, _)| a.cmp(b));
        Self { picture, quantities, channels }
    }

    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.channels.iter().map(|(name, _)| name.as_str())
    }

    /// The standard errors of each quantity in a row that was developed, by its number.
    pub fn errors<'b>(&'b self, row: &'b [f32]) -> impl Iterator<Item = (usize, &'b [f32])> {
        let width = self.picture.film.extent.shown.size[0] as usize;
        self.channels.iter().zip(row.chunks_exact(width)).filter_map(|(&(_, source), values)| match source {
            Source::Error(number) => Some((number, values)),
            _ => None,
        })
    }

    /// The rows of the film, as counted in what is measured, that are developed together: those of squares of
    /// error bars, as far as they are shown.
    pub fn rows(&self) -> impl Iterator<Item = Range<u32>> + use<> {
        let Extent { measured, shown, .. } = self.picture.film.extent;
        let (top, end) = (shown.offset[1], shown.offset[1] + shown.size[1]);
        let square = error_bars::SQUARE;
        let bands = (top / square..end.div_ceil(square)).map(move |band| band * square..(band + 1) * square);
        bands
            .map(move |rows| rows.start.max(top) - measured.offset[1]..rows.end.min(end) - measured.offset[1])
    }

    /// The values of some of these rows, as far as they are shown: row by row those of each channel, from the
    /// left.
    pub fn develop(&self, rows: Range<u32>) -> Vec<Vec<f32>> {
        let Extent { window, measured, shown, .. } = self.picture.film.extent;
        let width = measured.size[0] as usize;
        // The error bars of a row depend on its neighbours and on all of its squares.
        let own = Region {
            offset: [measured.offset[0], measured.offset[1] + rows.start],
            size: [measured.size[0], rows.end - rows.start],
        };
        let part = own.aligned(error_bars::SQUARE, measured).grown(error_bars::REACH, measured);
        let first = part.offset[1] - measured.offset[1];
        let all: Vec<Values> =
            (first..first + part.size[1]).into_par_iter().map(|y| self.values(y)).collect();
        let slice = |number: usize| number * width..(number + 1) * width;
        let errors = |variances: Vec<f64>| -> Vec<f32> {
            variances.into_iter().map(|variance| variance.sqrt() as f32).collect()
        };
        let of_quantity = |number: usize| -> Vec<f32> {
            let gathered = |of: fn(&Values) -> &[f64]| -> Vec<f64> {
                let rows: Vec<&[f64]> = all.iter().map(|values| &of(values)[slice(number)]).collect();
                rows.concat()
            };
            let of_nets = self.picture.film.nets().map(|_| gathered(|values| values.of_nets.as_slice()));
            let variances = gathered(|values| values.variances.as_slice());
            let means: Vec<f64> = all
                .iter()
                .flat_map(|values| values.means[slice(number)].iter().map(|&mean| f64::from(mean)))
                .collect();
            errors(error_bars::calibrated(window.size, part, Some(&means), &variances, of_nets.as_deref()))
        };
        let of_image = |number: usize| -> Vec<f32> {
            let first = first as usize * width;
            let all = self.picture.auxiliary[number].errors.as_deref().unwrap_or_default();
            let all = &all[first..first + part.pixel_count() as usize];
            let variances: Vec<f64> = all.iter().map(|&error| f64::from(error).powi(2)).collect();
            errors(error_bars::moderated(window.size, part.size, &variances))
        };
        let of_channels: Vec<Vec<f32>> = self
            .channels
            .par_iter()
            .map(|&(_, source)| match source {
                Source::Error(number) => of_quantity(number),
                Source::ImageError(number) => of_image(number),
                Source::Mean(_) | Source::Samples | Source::Image(_) => Vec::new(),
            })
            .collect();
        let left = (shown.offset[0] - measured.offset[0]) as usize;
        let columns = left..left + shown.size[0] as usize;
        let row = |y: u32| -> Vec<f32> {
            let in_part = (y - first) as usize;
            let mut row = Vec::with_capacity(columns.len() * self.channels.len());
            for ((_, source), errors) in self.channels.iter().zip(&of_channels) {
                let start = |row: usize| row * width + columns.start..row * width + columns.end;
                match *source {
                    Source::Mean(number) => row.extend(&all[in_part].means[start(number)]),
                    Source::Error(_) | Source::ImageError(_) => row.extend(&errors[start(in_part)]),
                    Source::Samples => {
                        row.extend(columns.clone().map(|x| self.picture.film.samples(x as u32, y) as f32));
                    }
                    Source::Image(number) => {
                        row.extend(&self.picture.auxiliary[number].values[start(y as usize)]);
                    }
                }
            }
            row
        };
        rows.into_par_iter().map(row).collect()
    }

    /// What a row of the film holds.
    fn values(&self, y: u32) -> Values {
        let film: &Film = self.picture.film;
        let width = film.width as usize;
        let cells = width * self.quantities.len();
        let cells_of = |is_there: bool| vec![0.0; if is_there { cells } else { 0 }];
        let mut values = Values {
            means: vec![0.0; cells],
            variances: cells_of(self.picture.has_errors()),
            of_nets: cells_of(film.nets().is_some()),
        };
        let parts = [film.replicates, film.nets().unwrap_or(film.replicates)];
        for x in 0..film.width {
            // Pixel by pixel: the bins of a pixel lie together.
            let pixel = film.pixel(x, y);
            for (number, (_, quantity)) in self.quantities.iter().enumerate() {
                let cell = number * width + x as usize;
                let [measured, by_nets] = pixel.measured_by(parts, *quantity);
                values.means[cell] = measured.mean as f32;
                for (variances, error) in
                    [(&mut values.variances, measured.error), (&mut values.of_nets, by_nets.error)]
                {
                    if let Some(variance) = variances.get_mut(cell) {
                        *variance = error.powi(2);
                    }
                }
            }
        }
        film.has_used_row();
        values
    }
}
