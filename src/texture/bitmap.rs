//! Images on surfaces. The first row is at v = 0.

use super::{Lines, TexturePoint, Wrap};
use crate::geometry::UvTransform;
use crate::raster::{Image, luminance};
use crate::spectrum::{Sampled, Sigmoid, Spectrum, upsample};
use std::sync::Arc;

/// How values between the centres of texels come about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// There are none: a texel is a rectangle of its colour.
    Nearest,
    /// Linear in both directions (in all three, for a grid).
    Linear,
}

/// How an image lies on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placing {
    /// From the shape's uv to the texture's.
    pub to_uv: UvTransform,
    /// What is between the middles of pixels.
    pub filter: Filter,
    /// What is beyond the edges.
    pub wrap: Wrap,
}

/// An image that gives a colour or a number for each place.
#[derive(Clone, Debug)]
pub struct Bitmap {
    size: [usize; 2],
    texels: Texels,
    placing: Placing,
    /// Over all texels, of red, green and blue or of the one channel.
    mean: [f64; 3],
    least: f64,
    greatest: f64,
}

#[derive(Clone, Debug)]
enum Texels {
    /// One number each, which is the value at every wavelength.
    Grey(Arc<[f32]>),
    /// Three numbers each that are no colour.
    Raw(Arc<[f32]>),
    /// Coefficients of a [`Sigmoid`].
    Spectra(Arc<[[f32; 3]]>),
}

impl Bitmap {
    /// With `raw`, values are taken as they stand in the file: not decoded, and not made into spectra.
    /// With `half`, colours and what is looked up are rounded to half precision.
    pub fn new(image: &Image, placing: Placing, raw: bool, half: bool) -> Self {
        let value = |value: f32| if raw { f64::from(value) } else { image.light(value) };
        let texels = (image.width * image.height) as f64;
        let (mut mean, mut least, mut greatest) = ([0.0; 3], f64::INFINITY, f64::NEG_INFINITY);
        let spectral = !raw && image.channels == 3;
        for texel in image.values.chunks_exact(image.channels) {
            for (channel, sum) in mean.iter_mut().enumerate() {
                let value = value(texel[channel.min(image.channels - 1)]);
                let value = if spectral { value.clamp(0.0, 1.0) } else { value };
                *sum += value / texels;
                least = least.min(value);
                greatest = greatest.max(value);
            }
        }
        let round = |value: f32| if half { ::half::f16::from_f32(value).to_f32() } else { value };
        let numbers = || image.values.iter().map(|&v| round(value(v) as f32)).collect();
        let texels = match image.channels {
            1 => Texels::Grey(numbers()),
            _ if raw => Texels::Raw(numbers()),
            _ if half => {
                let spectrum = |texel: &[f32]| {
                    let rgb = [0, 1, 2].map(|channel| f64::from(round(value(texel[channel]) as f32)));
                    upsample(rgb).coefficients.map(|coefficient| round(coefficient as f32))
                };
                Texels::Spectra(image.values.chunks_exact(3).map(spectrum).collect())
            }
            _ => Texels::Spectra(image.spectra()),
        };
        Self { size: [image.width, image.height], texels, placing, mean, least, greatest }
    }

    /// The texels around a place and their weights, along u first.
    #[inline]
    fn around(&self, at: &TexturePoint) -> [(usize, f64); 4] {
        let [width, height] = self.size;
        let [u, v] = self.placing.to_uv.apply(at.uv);
        let wrap = self.placing.wrap;
        match self.placing.filter {
            Filter::Nearest => {
                let texel = wrap.nearest(v, height) * width + wrap.nearest(u, width);
                [(texel, 1.0), (texel, 0.0), (texel, 0.0), (texel, 0.0)]
            }
            Filter::Linear => {
                let ([left, right], x) = wrap.between(u, width);
                let ([upper, lower], y) = wrap.between(v, height);
                [
                    (upper * width + left, (1.0 - x) * (1.0 - y)),
                    (upper * width + right, x * (1.0 - y)),
                    (lower * width + left, (1.0 - x) * y),
                    (lower * width + right, x * y),
                ]
            }
        }
    }

    #[inline]
    fn interpolated(&self, at: &TexturePoint, of_texel: impl Fn(usize) -> f64) -> f64 {
        self.around(at)
            .iter()
            .map(|&(texel, weight)| if weight == 0.0 { 0.0 } else { weight * of_texel(texel) })
            .sum()
    }

    /// Colours are interpolated as spectra.
    #[inline]
    pub fn sample<const C: usize>(&self, at: &TexturePoint, nm: &[f64; C]) -> Sampled<C> {
        let Texels::Spectra(spectra) = &self.texels else { return Sampled::splat(self.value(at)) };
        let mut sum = Sampled::ZERO;
        for (texel, weight) in self.around(at) {
            if weight > 0.0 {
                let sigmoid = Sigmoid { coefficients: spectra[texel].map(f64::from) };
                sum += Sampled::from_fn(|lane| weight * sigmoid.at(nm[lane]));
            }
        }
        sum
    }

    /// One number for all wavelengths: of what is no colour but has three channels, the luminance.
    pub fn value(&self, at: &TexturePoint) -> f64 {
        self.interpolated(at, |texel| self.texel_value(texel))
    }

    #[inline]
    fn texel_value(&self, texel: usize) -> f64 {
        match &self.texels {
            Texels::Grey(values) => f64::from(values[texel]),
            Texels::Raw(values) => luminance([0, 1, 2].map(|channel| f64::from(values[3 * texel + channel]))),
            Texels::Spectra(spectra) => Sigmoid { coefficients: spectra[texel].map(f64::from) }.mean(),
        }
    }

    /// The three channels at a point as they are.
    pub fn rgb(&self, at: &TexturePoint) -> [f64; 3] {
        match &self.texels {
            Texels::Raw(values) => {
                [0, 1, 2].map(|channel| self.interpolated(at, |texel| f64::from(values[3 * texel + channel])))
            }
            Texels::Grey(_) | Texels::Spectra(_) => [self.value(at); 3],
        }
    }

    /// Gradient of [`Self::value`], between the centres of texels. As in Mitsuba 3 it is turned by `to_uv`
    /// before it is scaled by the size of the image: where `to_uv` rotates an image that is not square, this
    /// is not the derivative.
    pub fn gradient(&self, at: &TexturePoint) -> [f64; 2] {
        if self.placing.filter == Filter::Nearest {
            return [0.0; 2];
        }
        let [width, height] = self.size;
        let [u, v] = self.placing.to_uv.apply(at.uv);
        let (_, x) = self.placing.wrap.between(u, width);
        let (_, y) = self.placing.wrap.between(v, height);
        let [a, b, c, d] = self.around(at).map(|(texel, _)| self.texel_value(texel));
        let by_texel = [(b - a) * (1.0 - y) + (d - c) * y, (c - a) * (1.0 - x) + (d - b) * x];
        let [by_u, by_v] = self.placing.to_uv.pull_back(by_texel);
        [by_u * width as f64, by_v * height as f64]
    }

    /// Between which it is interpolated, or has the value of one texel.
    pub fn lines(&self) -> Lines {
        let bilinear = self.placing.filter == Filter::Linear;
        let offset = if bilinear { 0.5 } else { 0.0 };
        Lines { to_uv: self.placing.to_uv, per_unit: self.resolution(), offset, bilinear }
    }

    /// Columns and rows.
    pub fn resolution(&self) -> [u32; 2] {
        self.size.map(|side| side as u32)
    }

    /// Whether all texels are 0.
    pub fn is_zero(&self) -> bool {
        self.least == 0.0 && self.greatest == 0.0
    }

    /// About the mean over the image: the spectrum of the mean colour.
    pub fn mean_spectrum(&self) -> Spectrum {
        match &self.texels {
            Texels::Spectra(_) => Spectrum::Sigmoid { shape: upsample(self.mean), factor: 1.0 },
            Texels::Grey(_) => Spectrum::Constant(self.mean[0]),
            Texels::Raw(_) => Spectrum::Constant(luminance(self.mean)),
        }
    }

    /// No value is above it.
    pub fn max_bound(&self) -> f64 {
        match &self.texels {
            // The spectrum of a colour is somewhere above its largest component.
            Texels::Spectra(_) if self.greatest > 0.0 => 1.0,
            _ => self.greatest,
        }
    }
}
