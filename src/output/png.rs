//! The PNG preview: something to look at, exposed so that it is neither black nor burnt. The only file that
//! names the image crate.

use super::Picture;
use crate::sampling::mix;
use crate::spectrum::colour;
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

/// How luminances after exposure become those of the PNG, in which 1 is white. Hues stay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToneCurve {
    /// As they are, up to white.
    Linear,
    /// Where pixels are beyond white, a shoulder that takes the brightest to white instead of burning it
    /// (Reinhard et al., "Photographic Tone Reproduction for Digital Images", SIGGRAPH 2002, eq. 4); else
    /// as they are.
    Reinhard,
    /// An S that darkens shadows, for more contrast: Narkowicz's fit of the ACES reference curve (2015),
    /// after a factor of 0.6.
    Aces,
}

impl ToneCurve {
    /// All curves by their names.
    pub const NAMES: [(&'static str, Self); 3] =
        [("linear", Self::Linear), ("reinhard", Self::Reinhard), ("aces", Self::Aces)];

    /// The curve of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::NAMES.iter().find(|(known, _)| *known == name).map(|&(_, curve)| curve)
    }

    /// What becomes of a luminance, where `white` is the one that the shoulder takes to white.
    fn of(self, luminance: f64, white: f64) -> f64 {
        match self {
            Self::Linear => luminance,
            Self::Reinhard => luminance * (1.0 + luminance / (white * white)) / (1.0 + luminance),
            Self::Aces => {
                let x = 0.6 * luminance;
                (x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)).min(1.0)
            }
        }
    }
}

/// Writes the whole file or none of it. The curve is Reinhard's for an automatic exposure and linear for
/// stops where none is given.
///
/// Values between two codes become either, by a noise that belongs to the pixel: the mean is right, and slow
/// gradients show no bands.
pub fn write(
    path: &Path,
    picture: &Picture,
    exposure: Exposure,
    curve: Option<ToneCurve>,
) -> std::io::Result<()> {
    let film = picture.film;
    let tone = Tone::of(picture, exposure, curve);
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
    if width * height != colours.len() {
        return Err(std::io::Error::other("the picture is not a rectangle"));
    }
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width as u32, height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    let written = encoder.write_header().and_then(|mut writer| {
        writer.write_image_data(colours.as_flattened())?;
        writer.finish()
    });
    written.map_err(std::io::Error::other)?;
    super::write_whole(path, &bytes)
}

/// From what a picture holds to what its PNG shows.
struct Tone {
    exposure: f64,
    curve: ToneCurve,
    /// Luminance after exposure that becomes white.
    white: f64,
}

impl Tone {
    fn of(picture: &Picture, exposure: Exposure, curve: Option<ToneCurve>) -> Self {
        let film = picture.film;
        let mut luminance: Vec<f64> =
            film.shown().map(|(x, y)| film.combined(x, y, [0.0, 1.0, 0.0]).mean.max(0.0)).collect();
        luminance.sort_by(f64::total_cmp);
        let last = luminance.len() - 1;
        let lamp = luminance[last - (LAMPS * last as f64) as usize];
        let mean = luminance.iter().map(|&value| value.min(lamp)).sum::<f64>() / luminance.len() as f64;
        let (exposure, usual) = match exposure {
            Exposure::Auto => (if mean > 0.0 { MEAN / mean } else { 1.0 }, ToneCurve::Reinhard),
            Exposure::Stops(stops) => (stops.exp2(), ToneCurve::Linear),
        };
        let white = (exposure * luminance[last]).max(1.0);
        Self { exposure, curve: curve.unwrap_or(usual), white }
    }

    fn of_colour(&self, xyz: [f64; 3]) -> [f64; 3] {
        let luminance = self.exposure * xyz[1].max(0.0);
        let factor = if luminance > 0.0 { self.curve.of(luminance, self.white) / luminance } else { 1.0 };
        xyz.map(|value| value * self.exposure * factor)
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

    /// Black stays black, curves rise, and the shoulder ends at white.
    #[test]
    fn tone_curves_are_those_of_their_sources() {
        assert_eq!(ToneCurve::named("aces"), Some(ToneCurve::Aces));
        assert_eq!(ToneCurve::named("filmic"), None);
        for (name, curve) in ToneCurve::NAMES {
            assert_eq!(curve.of(0.0, 8.0), 0.0, "{name}");
            let values: Vec<f64> = (0..100).map(|i| curve.of(0.1 * f64::from(i), 8.0)).collect();
            assert!(values.is_sorted(), "{name}: {values:?}");
        }
        assert_eq!(ToneCurve::Linear.of(0.7, 8.0), 0.7);
        assert!((ToneCurve::Reinhard.of(8.0, 8.0) - 1.0).abs() < 1e-15);
        assert!((ToneCurve::Reinhard.of(1.0, 8.0) - 0.5 * (1.0 + 1.0 / 64.0)).abs() < 1e-15);
        // 0.6 · 0.3 = 0.18: (0.18 · 0.4818) / (0.18 · 1.0274 + 0.14).
        assert!((ToneCurve::Aces.of(0.3, 8.0) - 0.086_724 / 0.324_932).abs() < 1e-12);
    }

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
