//! Reading a whole EXR file.

use super::{MEAN_ERROR, TILE_NOISE, TILE_NOISES, tile_noise};
use exr::prelude::*;
use std::io::Cursor;
use std::path::Path;

/// What [`read()`] finds in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Channels {
    /// Columns.
    pub width: usize,
    /// Rows.
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

    /// The same of each tile, row by row.
    pub fn tile_noises(&self, channel: &str) -> Option<Vec<f64>> {
        let prefix = format!("{channel}=");
        self.attribute(TILE_NOISES)?.lines().find_map(|line| line.strip_prefix(&prefix)).map(tile_noise::read)
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
    let reader = exr::block::read(Cursor::new(bytes.as_slice()), false).map_err(damaged)?;
    checked(reader.meta_data(), bytes.len() as u64)?;
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_chunks(reader)
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

pub(super) fn damaged(error: exr::error::Error) -> std::io::Error {
    std::io::Error::new(std::io::ErrorKind::InvalidData, format!("not a readable OpenEXR file: {error}"))
}

/// Refuses a header that announces a picture larger than its file can hold.
pub(super) fn checked(meta: &exr::meta::MetaData, bytes: u64) -> std::io::Result<()> {
    for header in &meta.headers {
        let pixels = header.layer_size.area() as u64;
        // Compressed data are rarely smaller than this fraction of what they stand for; a damaged header asks
        // for anything.
        if pixels.saturating_mul(header.channels.bytes_per_pixel as u64) / MOST_COMPRESSED > bytes {
            return Err(std::io::Error::other("the file is far shorter than the picture that it announces"));
        }
    }
    Ok(())
}

/// How many times larger than its file a picture may be: what the compressions of the format reach on a
/// picture that is of one colour.
const MOST_COMPRESSED: u64 = 2048;

/// The inverse of [`utf8`].
pub(super) fn decoded(text: &Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}
