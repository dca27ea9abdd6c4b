//! The PNG preview: something to look at, exposed so that it is neither black nor burnt. The only file that names the
//! image crate.

use super::Picture;
use crate::spectrum::colour;
use std::io::Cursor;
use std::path::Path;

/// Luminance of the picture's mean after exposure, as a share of white.
const MEAN: f64 = 0.25;

/// Share of the pixels, the brightest, that do not raise the mean further: lamps and glints.
const LAMPS: f64 = 0.01;

/// Writes the whole file or none of it.
pub fn write(path: &Path, picture: &Picture) -> std::io::Result<()> {
    let film = picture.film;
    let tone = Tone::of(picture);
    let colour = |(x, y)| {
        let xyz = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
            .map(|weights| film.combined(x, y, weights).mean);
        displayed(tone.of_colour(xyz)).map(|value| (255.0 * value + 0.5) as u8)
    };
    let colours: Vec<[u8; 3]> = film.shown().map(colour).collect();
    write_colours(path, film.extent.shown.size[0] as usize, &colours)
}

/// Writes sRGB code values, row by row from the top: the whole file or none of it.
pub fn write_colours(path: &Path, width: usize, colours: &[[u8; 3]]) -> std::io::Result<()> {
    let height = colours.len() / width.max(1);
    let whole = image::RgbImage::from_raw(width as u32, height as u32, colours.as_flattened().to_vec());
    write_image(path, &whole.ok_or_else(|| std::io::Error::other("the picture is not a rectangle"))?)
}

fn write_image(path: &Path, image: &image::RgbImage) -> std::io::Result<()> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).map_err(std::io::Error::other)?;
    super::write_whole(path, &bytes.into_inner())
}

/// Exposure and a shoulder that takes the brightest pixel to white instead of burning it
/// (Reinhard et al., "Photographic Tone Reproduction for Digital Images", SIGGRAPH 2002, eq. 4).
struct Tone {
    exposure: f64,
    /// Luminance after exposure that becomes white.
    white: f64,
}

impl Tone {
    fn of(picture: &Picture) -> Self {
        let film = picture.film;
        let mut luminance: Vec<f64> =
            film.shown().map(|(x, y)| film.combined(x, y, [0.0, 1.0, 0.0]).mean.max(0.0)).collect();
        luminance.sort_by(f64::total_cmp);
        let last = luminance.len() - 1;
        let lamp = luminance[last - (LAMPS * last as f64) as usize];
        let mean = luminance.iter().map(|&value| value.min(lamp)).sum::<f64>() / luminance.len() as f64;
        let exposure = if mean > 0.0 { MEAN / mean } else { 1.0 };
        Self { exposure, white: (exposure * luminance[last]).max(1.0) }
    }

    fn of_colour(&self, xyz: [f64; 3]) -> [f64; 3] {
        let luminance = self.exposure * xyz[1].max(0.0);
        let shoulder = (1.0 + luminance / (self.white * self.white)) / (1.0 + luminance);
        xyz.map(|value| value * self.exposure * shoulder)
    }
}

/// sRGB code values of a colour. One outside the gamut keeps its luminance, as far as white goes, and its hue: it is
/// mixed with grey until no primary is negative or above 1.
fn displayed(xyz: [f64; 3]) -> [f64; 3] {
    let grey = xyz[1].clamp(0.0, 1.0);
    let rgb = colour::xyz_to_rec709(xyz.into());
    let share = rgb.into_iter().fold(1.0f64, |share, value| {
        if value < 0.0 {
            share.min(grey / (grey - value))
        } else if value > 1.0 {
            share.min((1.0 - grey) / (value - grey))
        } else {
            share
        }
    });
    rgb.map(|value| colour::srgb_encode((grey + share * (value - grey)).clamp(0.0, 1.0)))
}
