//! Values in space, looked up where the surface is.

use super::{Filter, TexturePoint, Wrap};
use crate::geometry::{Transform, Vec3};
use crate::raster::{Grid, luminance};
use crate::spectrum::{Sampled, Sigmoid, upsample};
use std::sync::Arc;

/// A grid of cells that fill the unit cube.
#[derive(Clone, Debug)]
pub struct Volume {
    size: [usize; 3],
    cells: Cells,
    /// From the coordinates of the scene to those in which the grid is the unit cube.
    to_local: Transform,
    filter: Filter,
    wrap: Wrap,
    mean: [f64; 3],
    greatest: f64,
}

#[derive(Clone, Debug)]
enum Cells {
    Grey(Arc<[f32]>),
    Raw(Arc<[f32]>),
    /// Coefficients of a [`Sigmoid`] and a factor.
    Spectra(Arc<[[f32; 4]]>),
}

impl Volume {
    /// With `raw`, three channels are no colour.
    pub fn new(grid: &Grid, to_local: Transform, filter: Filter, wrap: Wrap, raw: bool) -> Self {
        let cells = grid.values.len() / grid.channels;
        let mut mean = [0.0; 3];
        for cell in grid.values.chunks_exact(grid.channels) {
            for (channel, mean) in mean.iter_mut().enumerate() {
                *mean += f64::from(cell[channel.min(grid.channels - 1)]) / cells as f64;
            }
        }
        let greatest = grid.values.iter().fold(0.0, |greatest: f32, &value| greatest.max(value.abs()));
        let cells = match grid.channels {
            1 => Cells::Grey(grid.values.as_slice().into()),
            _ if raw => Cells::Raw(grid.values.as_slice().into()),
            _ => Cells::Spectra(grid.values.chunks_exact(3).map(unbounded).collect()),
        };
        // The spectrum of a colour is at most twice its largest component.
        let greatest = f64::from(greatest) * if matches!(cells, Cells::Spectra(_)) { 2.0 } else { 1.0 };
        Self { size: grid.size, cells, to_local, filter, wrap, mean, greatest }
    }

    /// Cells along x, y and z.
    pub fn size(&self) -> [usize; 3] {
        self.size
    }

    /// Whether a place lies in the grid's box.
    pub fn holds(&self, position: Vec3) -> bool {
        let place = self.to_local.point(position);
        place.cmpge(Vec3::ZERO).all() && place.cmple(Vec3::ONE).all()
    }

    /// From the coordinates of the scene to those in which the grid is the unit cube.
    pub fn to_local(&self) -> &Transform {
        &self.to_local
    }

    /// How values between cells are found.
    pub fn filter(&self) -> Filter {
        self.filter
    }

    /// Whether its values are spectra that were made of colours.
    pub fn is_coloured(&self) -> bool {
        matches!(self.cells, Cells::Spectra(_))
    }

    /// The cells around a place, in coordinates in which the grid is the unit cube, and their weights.
    fn around(&self, place: Vec3) -> [(usize, f64); 8] {
        let along = |coordinate: f64, size: usize| match self.filter {
            Filter::Nearest => ([self.wrap.nearest(coordinate, size); 2], 0.0),
            Filter::Linear => self.wrap.between(coordinate, size),
        };
        let [width, height, depth] = self.size;
        let (x, y, z) = (along(place.x, width), along(place.y, height), along(place.z, depth));
        let pick = |(cells, weight): ([usize; 2], f64), second: bool| match second {
            false => (cells[0], 1.0 - weight),
            true => (cells[1], weight),
        };
        std::array::from_fn(|corner| {
            let (i, a) = pick(x, corner & 1 != 0);
            let (j, b) = pick(y, corner & 2 != 0);
            let (k, c) = pick(z, corner & 4 != 0);
            ((k * height + j) * width + i, a * b * c)
        })
    }

    /// Colours are interpolated as spectra between 0 and 1, and their factors apart from these, as in
    /// Mitsuba 3.
    pub fn sample<const C: usize>(&self, at: &TexturePoint, nm: &[f64; C]) -> Sampled<C> {
        self.sample_at(self.to_local.point(at.position), nm)
    }

    /// The same at a place in coordinates in which the grid is the unit cube.
    pub fn sample_at<const C: usize>(&self, place: Vec3, nm: &[f64; C]) -> Sampled<C> {
        let Cells::Spectra(cells) = &self.cells else { return Sampled::splat(self.value_at(place)) };
        let (mut shape, mut factor) = (Sampled::ZERO, 0.0);
        for (cell, weight) in self.around(place) {
            let [a, b, c, scale] = cells[cell].map(f64::from);
            let sigmoid = Sigmoid { coefficients: [a, b, c] };
            shape += Sampled::from_fn(|lane| weight * sigmoid.at(nm[lane]));
            factor += weight * scale;
        }
        shape * factor
    }

    /// One number for all wavelengths: the luminance of three raw channels, the mean of a spectrum over
    /// wavelength.
    pub fn value(&self, at: &TexturePoint) -> f64 {
        self.value_at(self.to_local.point(at.position))
    }

    fn value_at(&self, place: Vec3) -> f64 {
        match &self.cells {
            Cells::Grey(values) => {
                self.around(place).iter().map(|&(i, weight)| weight * f64::from(values[i])).sum()
            }
            Cells::Raw(_) => luminance(self.rgb_at(place)),
            Cells::Spectra(cells) => {
                let brightness = |cell: usize| {
                    let [a, b, c, scale] = cells[cell].map(f64::from);
                    scale * Sigmoid { coefficients: [a, b, c] }.mean()
                };
                self.around(place).iter().map(|&(cell, weight)| weight * brightness(cell)).sum()
            }
        }
    }

    /// The three numbers at a point as they are.
    pub fn rgb(&self, at: &TexturePoint) -> [f64; 3] {
        self.rgb_at(self.to_local.point(at.position))
    }

    fn rgb_at(&self, place: Vec3) -> [f64; 3] {
        let Cells::Raw(values) = &self.cells else { return [self.value_at(place); 3] };
        let around = self.around(place);
        [0, 1, 2].map(|channel| {
            around.iter().map(|&(i, weight)| weight * f64::from(values[3 * i + channel])).sum()
        })
    }

    /// The mean of each channel over the grid.
    pub fn mean(&self) -> [f64; 3] {
        self.mean
    }

    /// No value is above it.
    pub fn max_bound(&self) -> f64 {
        self.greatest
    }
}

/// The spectrum of half the brightness that the family has at most, and the factor that makes up for it.
fn unbounded(rgb: &[f32]) -> [f32; 4] {
    let rgb = [rgb[0], rgb[1], rgb[2]].map(|value| f64::from(value.max(0.0)));
    let scale = 2.0 * rgb.into_iter().fold(0.0, f64::max);
    if scale == 0.0 {
        return [0.0; 4];
    }
    let [a, b, c] = upsample(rgb.map(|value| value / scale)).coefficients;
    [a, b, c, scale].map(|number| number as f32)
}

/// From a box to the unit cube; `None` where the box is flat.
pub fn from_box([low, high]: [Vec3; 2]) -> Option<Transform> {
    let to_box = glam::DMat4::from_translation(low) * glam::DMat4::from_scale(high - low);
    Transform::new(to_box).map(|to_box| to_box.inverse())
}
