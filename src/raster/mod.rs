//! Images that a scene names: what stands in a file, as numbers.
//!
//! PNG, JPEG, BMP, TGA, PNM, Radiance HDR, PFM and OpenEXR, as Mitsuba 3 reads them. Sizes are checked
//! against the length of the file before anything is allocated for them.

mod exr;
mod grid;
mod pfm;
mod tensors;

pub use grid::Grid;
pub use tensors::{Tensor, Tensors};

use crate::spectrum::colour::srgb_decode;
use crate::spectrum::upsample;
use ::image::codecs::hdr::HdrDecoder;
use ::image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader};
use rayon::prelude::*;
use std::io::Cursor;
use std::sync::{Arc, LazyLock, OnceLock};

/// Rows of texels from the top, each from the left.
#[derive(Clone, Debug)]
pub struct Image {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Values a texel has: 1 (grey) or 3 (red, green, blue with the primaries of sRGB). Opacity is left out.
    pub channels: usize,
    /// `width · height · channels` finite numbers. Integers of the file are divided by the largest of their
    /// type.
    pub values: Vec<f32>,
    /// Whether the values follow the transfer function of sRGB, as integers of 8 and 16 bits do.
    pub encoded: bool,
    /// Made when first asked for, so that textures which share an image share it too.
    spectra: OnceLock<Arc<[[f32; 3]]>>,
}

/// Luminance of linear values for the primaries of sRGB, with the weights that Mitsuba 3 has.
pub fn luminance([r, g, b]: [f64; 3]) -> f64 {
    0.212_671 * r + 0.715_16 * g + 0.072_169 * b
}

/// Why a file is no image.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageError {
    /// What is wrong, as a sentence.
    pub problem: String,
    /// What would be right.
    pub expected: String,
}

impl ImageError {
    fn new(problem: impl Into<String>, expected: impl Into<String>) -> Self {
        Self { problem: problem.into(), expected: expected.into() }
    }
}

/// Most texels of an image.
const MOST_TEXELS: usize = 1 << 27;

/// No compression of these formats makes a file shorter than its values by more than this: deflate's 1032.
const HIGHEST_COMPRESSION: usize = 1100;

impl Image {
    /// An image of `values`, which must be `width · height · channels` finite numbers.
    pub fn new(width: usize, height: usize, channels: usize, values: Vec<f32>, encoded: bool) -> Self {
        Self { width, height, channels, values, encoded, spectra: OnceLock::new() }
    }

    /// Decodes the content of a file. `extension` (without the dot) decides where the content does not say
    /// what it is.
    ///
    /// # Errors
    /// An unknown format, damaged content, a size that the content cannot have, values that are not finite.
    pub fn decode(bytes: &[u8], extension: Option<&str>) -> Result<Self, ImageError> {
        let image = if bytes.starts_with(&exr::MAGIC) {
            exr::decode(bytes)?
        } else if pfm::is_pfm(bytes) {
            pfm::decode(bytes)?
        } else if bytes.starts_with(b"#?") {
            // Radiance's own files say RADIANCE here, those of other programs RGBE.
            decoded(HdrDecoder::new_nonstrict(Cursor::new(bytes)).map_err(damaged)?, bytes.len())?
        } else {
            let tga = extension.is_some_and(|extension| extension.eq_ignore_ascii_case("tga"));
            let format = ::image::guess_format(bytes).ok().or(tga.then_some(ImageFormat::Tga));
            match format {
                Some(
                    format @ (ImageFormat::Png
                    | ImageFormat::Jpeg
                    | ImageFormat::Bmp
                    | ImageFormat::Tga
                    | ImageFormat::Pnm),
                ) => {
                    let reader = ImageReader::with_format(Cursor::new(bytes), format);
                    decoded(reader.into_decoder().map_err(damaged)?, bytes.len())?
                }
                _ => {
                    return Err(ImageError::new(
                        "The file is no image of a known format",
                        "expected PNG, JPEG, OpenEXR, Radiance HDR, PFM, PNM, TGA or BMP",
                    ));
                }
            }
        };
        match image.values.iter().position(|value| !value.is_finite()) {
            None => Ok(image),
            Some(at) => {
                let texel = at / image.channels;
                Err(ImageError::new(
                    format!(
                        "The texel at {}, {} is {}",
                        texel % image.width,
                        texel / image.width,
                        image.values[at]
                    ),
                    "expected finite values",
                ))
            }
        }
    }

    /// The values of a texel.
    #[inline]
    pub fn texel(&self, x: usize, y: usize) -> &[f32] {
        let at = (y * self.width + x) * self.channels;
        &self.values[at..at + self.channels]
    }

    /// A value as a measure of light.
    pub fn light(&self, value: f32) -> f64 {
        /// Each level of 8 bits, which most files have, and its light.
        static LEVELS: LazyLock<[(f32, f64); 256]> = LazyLock::new(|| {
            std::array::from_fn(|level| {
                let value = level as f32 / 255.0;
                (value, srgb_decode(f64::from(value)))
            })
        });
        if !self.encoded {
            return f64::from(value);
        }
        let (level, light) = LEVELS[((value * 255.0 + 0.5) as usize).min(255)];
        if level == value { light } else { srgb_decode(f64::from(value)) }
    }

    /// The same image in values proportional to light.
    pub fn linear(mut self) -> Self {
        if self.encoded {
            let light: Vec<f32> = self.values.par_iter().map(|&value| self.light(value) as f32).collect();
            (self.values, self.encoded) = (light, false);
        }
        self
    }

    /// The luminance of each texel, of an image of three channels.
    pub fn luminance(&self) -> Self {
        let of_texel = |texel: &[f32]| luminance([0, 1, 2].map(|channel| self.light(texel[channel]))) as f32;
        let values = self.values.par_chunks_exact(3).map(of_texel).collect();
        Self::new(self.width, self.height, 1, values, false)
    }

    /// For an image of three channels, the coefficients of the [`Sigmoid`](crate::spectrum::Sigmoid) of each
    /// texel.
    pub fn spectra(&self) -> Arc<[[f32; 3]]> {
        let make = || {
            let texels = self.values.par_chunks_exact(3);
            let spectra = texels.map(|texel| {
                let rgb = [0, 1, 2].map(|channel| self.light(texel[channel]));
                upsample(rgb).coefficients.map(|coefficient| coefficient as f32)
            });
            spectra.collect::<Vec<_>>().into()
        };
        self.spectra.get_or_init(make).clone()
    }
}

/// Checks a size before anything is allocated. `bytes_a_texel` are those of the decoded content.
fn check_size(width: usize, height: usize, bytes_a_texel: usize, length: usize) -> Result<(), ImageError> {
    if width == 0 || height == 0 {
        return Err(ImageError::new("The image has no texels", "expected a width and height above 0"));
    }
    let texels = width.saturating_mul(height);
    if texels > MOST_TEXELS {
        return Err(ImageError::new(
            format!("An image of {width} × {height} texels is too large"),
            format!("expected at most {MOST_TEXELS} texels"),
        ));
    }
    if texels.saturating_mul(bytes_a_texel) > length.saturating_mul(HIGHEST_COMPRESSION) {
        return Err(ImageError::new(
            format!("The file says that it has {width} × {height} texels, but it is too short for them"),
            "expected a complete file",
        ));
    }
    Ok(())
}

fn damaged(error: ::image::ImageError) -> ImageError {
    ImageError::new(format!("The image cannot be decoded: {error}"), "expected a complete, undamaged file")
}

/// What the image crate decodes from a file of `length` bytes.
fn decoded(decoder: impl ImageDecoder, length: usize) -> Result<Image, ImageError> {
    let (width, height) = decoder.dimensions();
    let (width, height) = (width as usize, height as usize);
    check_size(width, height, usize::from(decoder.color_type().bytes_per_pixel()), length)?;
    let pixels = DynamicImage::from_decoder(decoder).map_err(damaged)?;
    let image = |channels, encoded, values| Image::new(width, height, channels, values, encoded);
    let byte = |value: u8| f32::from(value) / 255.0;
    let word = |value: u16| f32::from(value) / 65535.0;
    Ok(match pixels {
        DynamicImage::ImageLuma8(pixels) => image(1, true, pixels.iter().copied().map(byte).collect()),
        DynamicImage::ImageLumaA8(pixels) => image(1, true, pixels.pixels().map(|p| byte(p.0[0])).collect()),
        DynamicImage::ImageRgb8(pixels) => image(3, true, pixels.iter().copied().map(byte).collect()),
        DynamicImage::ImageRgba8(pixels) => {
            image(3, true, pixels.pixels().flat_map(|p| [p.0[0], p.0[1], p.0[2]]).map(byte).collect())
        }
        DynamicImage::ImageLuma16(pixels) => image(1, true, pixels.iter().copied().map(word).collect()),
        DynamicImage::ImageLumaA16(pixels) => image(1, true, pixels.pixels().map(|p| word(p.0[0])).collect()),
        DynamicImage::ImageRgb16(pixels) => image(3, true, pixels.iter().copied().map(word).collect()),
        DynamicImage::ImageRgba16(pixels) => {
            image(3, true, pixels.pixels().flat_map(|p| [p.0[0], p.0[1], p.0[2]]).map(word).collect())
        }
        // What is left is in floats.
        other => image(3, false, other.to_rgb32f().into_raw()),
    })
}
