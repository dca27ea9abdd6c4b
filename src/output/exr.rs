//! The EXR file: the picture, its standard errors, its spectral bins and how it was made. The only file that
//! names the exr crate.
//!
//! Channels are 32-bit floats. `R G B` (linear Rec. 709) or `X Y Z` or `Y`, with `A` where the film has
//! alpha, or the responses of the film under their own names; `error.*` with one standard error of each (see
//! [`error_bars`]), `samples` per pixel; second moments and auxiliary images on request, under the names that
//! Mitsuba 3's `moment` and `aov` give them. Spectral bins follow Fichet, Pacanowski and Wilkie, "An OpenEXR
//! Layout for Spectral Images", JCGT 10(3), 2021: `S0.<nm>nm` with a decimal comma.

use super::{Content, Picture, error_bars};
use crate::film::{Extent, Film, Quantity, Region};
use crate::render::Auxiliary;
use exr::prelude::*;
use smallvec::SmallVec;
use std::collections::HashMap;
use std::io::Cursor;
use std::path::Path;

/// Writes the whole file or, where that fails, none of it: it is made beside its place and moved there.
///
/// Equal pictures give equal bytes.
pub fn write(path: &Path, picture: &Picture) -> std::io::Result<()> {
    let bytes = encode(picture).map_err(std::io::Error::other)?;
    super::write_whole(path, &bytes)
}

fn encode(picture: &Picture) -> std::result::Result<Vec<u8>, exr::error::Error> {
    let film = picture.film;
    let Extent { whole, window, measured, shown } = film.extent;
    let mut channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = SmallVec::new();
    let mut add = |name: &str, values: Vec<f32>| {
        channels.push(AnyChannel { name: utf8(name), ..AnyChannel::new("", FlatSamples::F32(values)) });
    };
    let nets = film.nets();
    let quantities = quantities(picture);
    for (name, quantity) in &quantities {
        add(name, pixels(film, |x, y| film.measured(x, y, *quantity).mean as f32));
        if picture.has_errors() {
            let variances = |film: &Film| -> Vec<f64> {
                let all = Region::whole(measured.size).pixels();
                all.map(|[x, y]| film.measured(x, y, *quantity).error.powi(2)).collect()
            };
            let of_nets = nets.as_ref().map(variances);
            let variances =
                error_bars::calibrated(window.size, measured, &variances(film), of_nets.as_deref());
            let error = |x, y| variances[y as usize * film.width as usize + x as usize].sqrt() as f32;
            add(&format!("error.{name}"), pixels(film, error));
        }
    }
    add("samples", pixels(film, |x, y| film.samples(x, y) as f32));
    for Auxiliary { name, values, errors } in &picture.auxiliary {
        let place = |x: u32, y: u32| y as usize * film.width as usize + x as usize;
        add(name, pixels(film, |x, y| values[place(x, y)]));
        if let Some(errors) = errors {
            let variances: Vec<f64> = errors.iter().map(|&error| f64::from(error).powi(2)).collect();
            let moderated = error_bars::moderated(window.size, measured.size, &variances);
            add(&format!("error.{name}"), pixels(film, |x, y| moderated[place(x, y)].sqrt() as f32));
        }
    }
    let size = Vec2(shown.size[0] as usize, shown.size[1] as usize);
    let mut layer = Layer::new(size, LayerAttributes::default(), ENCODING, AnyChannels::sort(channels));
    layer.attributes.layer_position = Vec2(shown.offset[0] as i32, shown.offset[1] as i32);
    layer.attributes.other = attributes(picture, &quantities);
    let mut image = Image::from_layer(layer);
    let full = Vec2(whole[0] as usize, whole[1] as usize);
    image.attributes.display_window = IntegerBounds::new((0, 0), full);
    if let Content::Colour(colour) = &picture.content {
        image.attributes.chromaticities = Some(colour.chromaticities());
    }
    encoded(image)
}

/// What the channels of light are, by name.
fn quantities(picture: &Picture) -> Vec<(String, Quantity)> {
    let extras = &picture.film.extras;
    let mut quantities: Vec<(String, Quantity)> = match &picture.content {
        Content::Colour(colour) => {
            let colours = colour.channels().iter();
            let alpha = extras.alpha.then(|| ("A".to_owned(), Quantity::Alpha));
            colours
                .map(|&(name, weights)| (name.to_owned(), Quantity::Combined(weights)))
                .chain(alpha)
                .collect()
        }
        Content::Responses(names) => {
            names.iter().enumerate().map(|(index, name)| (name.clone(), Quantity::Response(index))).collect()
        }
    };
    if let Some([means, squares]) = &picture.moments {
        for (of, &(name, weights)) in super::Colour::Xyz.channels().iter().enumerate() {
            quantities.push((format!("{means}.{name}"), Quantity::Combined(weights)));
            quantities.push((format!("{squares}.{name}"), Quantity::SecondMoment(of)));
        }
    }
    if let Some(bins) = extras.bins {
        let bin = |bin| (spectral_channel(bins.centre(bin)), Quantity::Bin(bin));
        quantities.extend((0..bins.count).map(bin));
    }
    quantities
}

const ENCODING: Encoding = Encoding {
    compression: Compression::ZIP16,
    blocks: Blocks::ScanLines,
    line_order: LineOrder::Increasing,
};

fn encoded(image: Image<Layer<AnyChannels<FlatSamples>>>) -> std::result::Result<Vec<u8>, exr::error::Error> {
    let mut bytes = Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes)?;
    let mut bytes = bytes.into_inner();
    sort_attributes(&mut bytes);
    Ok(bytes)
}

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
    let bytes = encoded(Image::from_layer(layer)).map_err(std::io::Error::other)?;
    super::write_whole(path, &bytes)
}

fn pixels(film: &Film, value: impl Fn(u32, u32) -> f32) -> Vec<f32> {
    film.shown().map(|(x, y)| value(x, y)).collect()
}

/// `S0.550,000000nm`: unpolarised radiance, a decimal comma, six decimals (Fichet et al. 2021).
fn spectral_channel(nm: f64) -> String {
    format!("S0.{nm:.6}nm").replacen('.', "\u{1}", 1).replace('.', ",").replace('\u{1}', ".")
}

/// Strings in EXR files are UTF-8. The crate's own conversion takes Latin-1 only, and writes bytes as they
/// are.
fn utf8(text: &str) -> Text {
    Text::from_slice_unchecked(text.as_bytes())
}

fn attributes(picture: &Picture, quantities: &[(String, Quantity)]) -> HashMap<Text, AttributeValue> {
    let text = |value: &str| AttributeValue::Text(utf8(value));
    let mut attributes: HashMap<Text, AttributeValue> =
        picture.attributes.iter().map(|(name, value)| (Text::from(name.as_str()), text(value))).collect();
    if picture.has_errors() {
        let film = picture.film;
        let degrees = error_bars::degrees(film.extent.window.size, film.replicates);
        attributes.insert(Text::from("abbe.degreesOfFreedom"), text(&format!("{degrees:.2}")));
        let (mut errors, mut of_tiles) = (Vec::new(), Vec::new());
        for (name, quantity) in quantities {
            let noise = film.noise(*quantity);
            if noise.mean.error.is_finite() {
                errors.push(stated(name, noise.mean.error));
            }
            of_tiles.extend(noise.of_tiles.map(|times| stated(name, times)));
        }
        for (name, lines) in [(MEAN_ERROR, errors), (TILE_NOISE, of_tiles)] {
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

/// Attribute with the standard error of the mean over all pixels, of each channel.
const MEAN_ERROR: &str = "abbe.meanError";

/// Attribute with the variance of the mean over a tile of 8 × 8 pixels over that of as many independent ones,
/// of each channel.
const TILE_NOISE: &str = "abbe.tileNoise";

/// A line of an attribute that has one for each channel. A name may hold blanks.
fn stated(name: &str, value: f64) -> String {
    format!("{name}={value:.6e}")
}

/// Puts the header's attributes in the order of their names. The exr crate keeps them in a hash map and
/// writes them in another order each time; the order has no meaning, but equal pictures must give equal
/// bytes.
fn sort_attributes(bytes: &mut [u8]) {
    let text_end =
        |from: usize, bytes: &[u8]| Some(from + bytes.get(from..)?.iter().position(|&b| b == 0)? + 1);
    let start = 8; // magic number and version
    let mut at = start;
    let mut entries: Vec<Vec<u8>> = Vec::new();
    while bytes.get(at).is_some_and(|&b| b != 0) {
        let Some((value_at, size)) = (|| {
            let kind = text_end(at, bytes)?;
            let size_at = text_end(kind, bytes)?;
            let size = i32::from_le_bytes(bytes.get(size_at..size_at + 4)?.try_into().ok()?);
            Some((size_at + 4, usize::try_from(size).ok()?))
        })() else {
            return;
        };
        let end = value_at + size;
        let Some(entry) = bytes.get(at..end) else { return };
        entries.push(entry.to_vec());
        at = end;
    }
    entries.sort();
    let sorted: Vec<u8> = entries.concat();
    bytes[start..start + sorted.len()].copy_from_slice(&sorted);
}

impl super::Colour {
    fn chromaticities(self) -> exr::meta::attribute::Chromaticities {
        let [red, green, blue, white] = self.primaries().map(|[x, y]| Vec2(x, y));
        exr::meta::attribute::Chromaticities { red, green, blue, white }
    }
}

/// What [`read()`] finds in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Channels {
    pub width: usize,
    pub height: usize,
    /// Name and values, row by row from the top, in the order of the names.
    pub channels: Vec<(String, Vec<f32>)>,
    /// Names of the channels that the file holds as 16-bit floats.
    pub half: Vec<String>,
    /// Name and value of the attributes that are text, in the order of the names.
    pub attributes: Vec<(String, String)>,
}

impl Channels {
    /// The values of a channel.
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        self.channels.iter().find(|(known, _)| known == name).map(|(_, values)| values.as_slice())
    }

    /// An attribute that is text.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(known, _)| known == name).map(|(_, value)| value.as_str())
    }

    /// The standard error of the mean of a channel over all pixels, where the file states it.
    pub fn mean_error(&self, channel: &str) -> Option<f64> {
        self.of_channel(MEAN_ERROR, channel)
    }

    /// How many times the variance of as many independent pixels the mean over a tile of
    /// [`NOISE_TILE`](crate::film::NOISE_TILE) × `NOISE_TILE` pixels has, where the file states it.
    pub fn tile_noise(&self, channel: &str) -> Option<f64> {
        self.of_channel(TILE_NOISE, channel)
    }

    /// The number, finite and not negative, that an attribute has for a channel.
    fn of_channel(&self, attribute: &str, channel: &str) -> Option<f64> {
        let lines = self.attribute(attribute)?.lines();
        let (_, value) = lines.filter_map(|line| line.rsplit_once('=')).find(|(name, _)| *name == channel)?;
        value.parse().ok().filter(|&value: &f64| value.is_finite() && value >= 0.0)
    }
}

/// Every channel of a file's first part with flat channels, as 32-bit floats, and its text attributes: for
/// tests and comparisons.
pub fn read(path: &Path) -> std::io::Result<Channels> {
    let bytes = std::fs::read(path)?;
    let damaged =
        |error: exr::error::Error| std::io::Error::other(format!("not a readable OpenEXR file: {error}"));
    let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(&bytes), false).map_err(damaged)?;
    for header in &meta.headers {
        let pixels = header.layer_size.area() as u64;
        // Compressed data are rarely smaller than this fraction of what they stand for; a damaged header asks
        // for anything.
        if pixels.saturating_mul(header.channels.bytes_per_pixel as u64) / MOST_COMPRESSED
            > bytes.len() as u64
        {
            return Err(std::io::Error::other("the file is far shorter than the picture that it announces"));
        }
    }
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(&bytes))
        .map_err(damaged)?;
    let size = image.layer_data.size;
    let list = image.layer_data.channel_data.list;
    if let Some(channel) = list.iter().find(|channel| channel.sampling != Vec2(1, 1)) {
        let name = decoded(&channel.name);
        return Err(std::io::Error::other(format!("channel {name} does not have a value for each pixel")));
    }
    let is_half = |channel: &&AnyChannel<FlatSamples>| matches!(channel.sample_data, FlatSamples::F16(_));
    let half = list.iter().filter(is_half).map(|channel| decoded(&channel.name)).collect();
    let own = image.layer_data.attributes.other.into_iter().chain(image.attributes.other);
    let text = |(name, value): (Text, AttributeValue)| match value {
        AttributeValue::Text(value) => Some((decoded(&name), decoded(&value))),
        _ => None,
    };
    let mut attributes: Vec<(String, String)> = own.filter_map(text).collect();
    attributes.sort();
    let named = list.into_iter().map(|c| (decoded(&c.name), c.sample_data.values_as_f32().collect()));
    Ok(Channels { width: size.0, height: size.1, channels: named.collect(), half, attributes })
}

/// How many times larger than its file a picture may be: what the compressions of the format reach on a
/// picture that is of one colour.
const MOST_COMPRESSED: u64 = 2048;

/// The inverse of [`utf8`].
fn decoded(text: &Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
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
