//! The EXR file: the picture, its standard errors, its spectral bins and how it was made. The only folder
//! that names the exr crate.
//!
//! Channels are 32-bit floats. `R G B` (linear Rec. 709) or `X Y Z` or `Y`, with `A` where the film has
//! alpha, or the responses of the film under their own names; `error.*` with one standard error of each (see
//! [`error_bars`]), `samples` per pixel; second moments and auxiliary images on request, under the names that
//! Mitsuba 3's `moment` and `aov` give them. Spectral bins follow Fichet, Pacanowski and Wilkie, "An OpenEXR
//! Layout for Spectral Images", JCGT 10(3), 2021: `S0.<nm>nm` with a decimal comma.

mod bands;
mod reading;
mod stored;
mod tile_noise;
mod writing;

use super::{Content, Picture, error_bars};
use crate::film::{PictureNoise, Quantity};
use exr::prelude::*;
pub use reading::{Channels, Layout, read};
use smallvec::SmallVec;
use std::collections::HashMap;
use std::io::Cursor;
use std::path::Path;
pub use stored::Stored;
use tile_noise::TileNoise;
pub use writing::write;

/// What the channels of light are, by name: colours or responses, and spectral bins.
fn light(picture: &Picture) -> Vec<(String, Quantity)> {
    let mut light: Vec<(String, Quantity)> = match &picture.content {
        Content::Colour(colour) => {
            let colours = colour.channels().iter();
            colours.map(|&(name, weights)| (name.to_owned(), Quantity::Combined(weights))).collect()
        }
        Content::Responses(names) => {
            names.iter().enumerate().map(|(index, name)| (name.clone(), Quantity::Response(index))).collect()
        }
    };
    if let Some(bins) = picture.film.extras.bins {
        let bin = |bin| (spectral_channel(bins.centre(bin)), Quantity::Bin(bin));
        light.extend((0..bins.count).map(bin));
    }
    light
}

/// What the film has measured, by the names of the channels: light, and what goes with it.
fn quantities(picture: &Picture) -> Vec<(String, Quantity)> {
    let mut quantities = light(picture);
    if let (Content::Colour(_), true) = (&picture.content, picture.film.extras.alpha) {
        quantities.push(("A".to_owned(), Quantity::Alpha));
    }
    if let Some([means, squares]) = &picture.moments {
        for (of, &(name, weights)) in super::Colour::Xyz.channels().iter().enumerate() {
            quantities.push((format!("{means}.{name}"), Quantity::Combined(weights)));
            quantities.push((format!("{squares}.{name}"), Quantity::SecondMoment(of)));
        }
    }
    quantities
}

const ENCODING: Encoding = Encoding {
    compression: Compression::ZIP16,
    blocks: Blocks::ScanLines,
    line_order: LineOrder::Increasing,
};

/// Writes named channels of `width` × `height` values each, row by row from the top: the whole file or none
/// of it.
pub fn write_channels(
    path: &Path,
    [width, height]: [usize; 2],
    channels: &[(String, Vec<f32>)],
) -> std::io::Result<()> {
    let named = |(name, values): &(String, Vec<f32>)| AnyChannel {
        name: utf8(name),
        ..AnyChannel::new("", FlatSamples::F32(values.clone()))
    };
    let channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = channels.iter().map(named).collect();
    let layer =
        Layer::new(Vec2(width, height), LayerAttributes::default(), ENCODING, AnyChannels::sort(channels));
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut bytes).map_err(std::io::Error::other)?;
    let mut bytes = bytes.into_inner();
    sort_attributes(&mut bytes);
    super::write_whole(path, &bytes)
}

/// The name of the channel of a spectral bin whose middle is at `nm`, such as `S0.550,000000nm`: unpolarised
/// radiance, a decimal comma, six decimals (Fichet et al. 2021).
pub fn spectral_channel(nm: f64) -> String {
    format!("S0.{nm:.6}nm").replacen('.', "\u{1}", 1).replace('.', ",").replace('\u{1}', ".")
}

/// Strings in EXR files are UTF-8. The crate's own conversion takes Latin-1 only, and writes bytes as they
/// are.
fn utf8(text: &str) -> Text {
    Text::from_slice_unchecked(text.as_bytes())
}

/// All that the file says of the picture. `noise` is that of each quantity, `tiles` what the file's errors
/// make of it.
fn attributes(
    picture: &Picture,
    quantities: &[(String, Quantity)],
    noise: &[PictureNoise],
    tiles: &TileNoise,
) -> HashMap<Text, AttributeValue> {
    let text = |value: &str| AttributeValue::Text(utf8(value));
    let mut attributes: HashMap<Text, AttributeValue> =
        picture.attributes.iter().map(|(name, value)| (Text::from(name.as_str()), text(value))).collect();
    let light: Vec<String> = light(picture).into_iter().map(|(name, _)| name).collect();
    attributes.insert(Text::from(LIGHT), text(&light.join("\n")));
    if picture.has_errors() {
        let film = picture.film;
        let degrees = error_bars::degrees(film.extent.window.size, film.replicates);
        attributes.insert(Text::from("abbe.degreesOfFreedom"), text(&format!("{degrees:.2}")));
        let (mut errors, mut of_tiles, mut of_each) = (Vec::new(), Vec::new(), Vec::new());
        for (number, ((name, _), noise)) in quantities.iter().zip(noise).enumerate() {
            of_each.push(format!("{name}={}", tiles.told(number, noise)));
            let share = error_bars::share_of_mean(&noise.squares);
            let error = noise.mean.error * share.sqrt();
            if error.is_finite() {
                errors.push(stated(name, error));
            }
            of_tiles.extend(noise.of_tiles.map(|times| stated(name, times)));
        }
        for (name, lines) in [(MEAN_ERROR, errors), (TILE_NOISE, of_tiles), (TILE_NOISES, of_each)] {
            if !lines.is_empty() {
                attributes.insert(Text::from(name), text(&lines.join("\n")));
            }
        }
    }
    if picture.film.extras.bins.is_some() {
        attributes.insert(Text::from("spectralLayoutVersion"), text("1.0"));
        // The layout's reader knows this string alone; what is stored is a density per nanometre.
        attributes.insert(Text::from("emissiveUnits"), text("W.m^-2.sr^-1"));
        attributes.insert(Text::from("abbe.emissiveUnits"), text("W.m^-2.sr^-1.nm^-1"));
    }
    attributes
}

/// Attribute with the names of the channels of light, a line for each. Other channels tell of the scene or of
/// the render.
const LIGHT: &str = "abbe.light";

/// Attribute with the standard error of the mean over all pixels, of each channel.
const MEAN_ERROR: &str = "abbe.meanError";

/// Attribute with the variance of the mean over a tile of 8 × 8 pixels over that of as many independent ones,
/// of each channel.
const TILE_NOISE: &str = "abbe.tileNoise";

/// Attribute with the same of each single tile: a line for each channel, whose characters [`tile_noise`]
/// explains.
const TILE_NOISES: &str = "abbe.tileNoises";

/// A line of an attribute that has one for each channel. A name may hold blanks.
fn stated(name: &str, value: f64) -> String {
    format!("{name}={value:.6e}")
}

/// Puts the header's attributes in the order of their names. The exr crate keeps them in a hash map and
/// writes them in another order each time; the order has no meaning, but equal pictures must give equal
/// bytes. Where the header ends; `None` where there is none.
fn sort_attributes(bytes: &mut [u8]) -> Option<usize> {
    let text_end =
        |from: usize, bytes: &[u8]| Some(from + bytes.get(from..)?.iter().position(|&b| b == 0)? + 1);
    let start = 8; // magic number and version
    let mut at = start;
    let mut entries: Vec<Vec<u8>> = Vec::new();
    while bytes.get(at).is_some_and(|&b| b != 0) {
        let kind = text_end(at, bytes)?;
        let size_at = text_end(kind, bytes)?;
        let size = i32::from_le_bytes(bytes.get(size_at..size_at + 4)?.try_into().ok()?);
        let end = size_at + 4 + usize::try_from(size).ok()?;
        entries.push(bytes.get(at..end)?.to_vec());
        at = end;
    }
    entries.sort();
    let sorted: Vec<u8> = entries.concat();
    bytes[start..start + sorted.len()].copy_from_slice(&sorted);
    // A zero ends it.
    Some(at + 1)
}

impl super::Colour {
    fn chromaticities(self) -> exr::meta::attribute::Chromaticities {
        let [red, green, blue, white] = self.primaries().map(|[x, y]| Vec2(x, y));
        exr::meta::attribute::Chromaticities { red, green, blue, white }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spectral_channels_are_named_as_the_layout_says() {
        assert_eq!(spectral_channel(550.0), "S0.550,000000nm");
        assert_eq!(spectral_channel(362.5), "S0.362,500000nm");
    }
}
