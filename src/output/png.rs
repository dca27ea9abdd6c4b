//! The PNG preview: something to look at, exposed so that it is neither black nor burnt. The only file that names the
//! image crate.

use super::Picture;
use crate::spectrum::colour;
use std::io::Cursor;
use std::path::Path;

/// Share of the pixels that may be brighter than white.
const BURNT: f64 = 0.01;

/// Luminance of the brightest pixel that is not burnt, as a share of white.
const BRIGHT: f64 = 0.9;

/// Writes the whole file or none of it.
pub fn write(path: &Path, picture: &Picture) -> std::io::Result<()> {
    let film = picture.film;
    let exposure = exposure(picture);
    let preview = image::RgbImage::from_fn(film.width, film.height, |x, y| {
        let xyz = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
            .map(|weights| exposure * film.combined(x, y, weights).mean);
        image::Rgb(displayed(xyz).map(|value| (255.0 * value + 0.5) as u8))
    });
    let mut bytes = Cursor::new(Vec::new());
    preview.write_to(&mut bytes, image::ImageFormat::Png).map_err(std::io::Error::other)?;
    super::write_whole(path, &bytes.into_inner())
}

/// The factor that takes the brightest pixel that may not burn to [`BRIGHT`].
fn exposure(picture: &Picture) -> f64 {
    let film = picture.film;
    let mut luminance: Vec<f64> = (0..film.height)
        .flat_map(|y| (0..film.width).map(move |x| film.combined(x, y, [0.0, 1.0, 0.0]).mean))
        .filter(|&value| value > 0.0)
        .collect();
    luminance.sort_by(f64::total_cmp);
    let index = ((luminance.len() as f64 * (1.0 - BURNT)) as usize).min(luminance.len().saturating_sub(1));
    luminance.get(index).map_or(1.0, |&bright| BRIGHT / bright)
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
