//! The PNG preview: something to look at, exposed so that it is neither black nor burnt. The only file that
//! names the image crate.

use super::Picture;
use crate::sampling::mix;
use crate::spectrum::colour;
use std::io::Cursor;
use std::path::Path;

/// Luminance of the picture's mean after exposure, as a fraction of white.
const MEAN: f64 = 0.25;

/// Share of the pixels, the brightest, that do not raise the mean further: lamps and glints.
const LAMPS: f64 = 0.01;

/// How bright a PNG is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// By the picture's own brightness, with a shoulder for what is brighter.
    Auto,
    /// Two to the power of this times what the picture holds, 1 becoming white: the same for all pictures.
    Stops(f64),
}

/// Writes the whole file or none of it.
///
/// Values between two codes become either, by a noise that belongs to the pixel: the mean is right, and slow
/// gradients show no bands.
pub fn write(path: &Path, picture: &Picture, exposure: Exposure) -> std::io::Result<()> {
    let film = picture.film;
    let tone = match exposure {
        Exposure::Auto => Tone::of(picture),
        Exposure::Stops(stops) => Tone { exposure: stops.exp2(), white: 1.0 },
    };
    let corner = film.extent.measured.offset;
    let colour = |(x, y)| {
        let xyz = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
            .map(|weights| film.combined(x, y, weights).mean);
        let noise = mix(u64::from(corner[0] + x) << 32 | u64::from(corner[1] + y));
        dithered(displayed(tone.of_colour(xyz)), noise)
    };
    let colours: Vec<[u8; 3]> = film.shown().map(colour).collect();
    write_colours(path, film.extent.shown.size[0] as usize, &colours)
}

/// Codes of 8 bits, rounded up or down as random bits say: up as often as the value is close to the code
/// above.
fn dithered(values: [f64; 3], noise: u64) -> [u8; 3] {
    [0, 1, 2].map(|i| {
        let threshold = f64::from((noise >> (20 * i)) as u32 & 0xf_ffff) / f64::from(1 << 20);
        (255.0 * values[i] + threshold) as u8
    })
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

/// sRGB code values of a colour. One outside the gamut keeps its luminance, as far as white goes, and its
/// hue: it is mixed with grey until no primary is negative or above 1.
fn displayed(xyz: [f64; 3]) -> [f64; 3] {
    let grey = xyz[1].clamp(0.0, 1.0);
    let rgb = colour::xyz_to_rec709(xyz.into());
    let fraction = rgb.into_iter().fold(1.0f64, |fraction, value| {
        if value < 0.0 {
            fraction.min(grey / (grey - value))
        } else if value > 1.0 {
            fraction.min((1.0 - grey) / (value - grey))
        } else {
            fraction
        }
    });
    rgb.map(|value| colour::srgb_encode((grey + fraction * (value - grey)).clamp(0.0, 1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean over many pixels is the value, black and white stay as they are, and no code is off by more
    /// than one.
    #[test]
    fn dithering_is_right_on_average() {
        let values = [0.0, 0.3217, 1.0];
        let n = 40_000;
        let codes: Vec<[u8; 3]> = (0..n).map(|i| dithered(values, mix(i))).collect();
        assert!(
            codes.iter().all(|&[black, grey, white]| black == 0 && (82..=83).contains(&grey) && white == 255)
        );
        let mean = codes.iter().map(|code| f64::from(code[1])).sum::<f64>() / n as f64;
        // A variance of at most a quarter each.
        assert!((mean - 255.0 * 0.3217).abs() < 4.5 * 0.5 / (n as f64).sqrt(), "{mean}");
    }
}
