//! Reading a whole EXR file.

use super::{LIGHT, MEAN_ERROR, TILE_NOISE, TILE_NOISES, tile_noise};
use exr::prelude::*;
use std::io::Cursor;
use std::path::Path;

/// What [`read()`] finds in a file.
#[derive(Clone, Debug, Default, PartialEq)]
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
    /// Which part of which picture they are.
    pub layout: Layout,
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

    /// The names of the channels of light, where the file states them.
    pub fn light(&self) -> Option<impl Iterator<Item = &str>> {
        Some(self.attribute(LIGHT)?.lines())
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
    let layout = layout(&reader.meta_data().headers)?;
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
    Ok(Channels { width: size.0, height: size.1, channels: named.collect(), half, attributes, layout })
}

/// Which part of which picture the channels are that [`read()`] finds.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Layout {
    /// Column and row of the first pixel (the corner of the data window).
    pub offset: [i32; 2],
    /// What the other parts of the file are called.
    pub other_parts: Vec<String>,
}

/// Where the picture of a file with these headers stands, and what else the file holds.
fn layout(headers: &[exr::meta::header::Header]) -> std::io::Result<Layout> {
    let Some(read) = headers.iter().position(|header| !header.deep) else {
        return Err(std::io::Error::other("the file has no flat channels"));
    };
    let Vec2(x, y) = headers[read].own_attributes.layer_position;
    let name = |(number, header): (usize, &exr::meta::header::Header)| {
        let name = header.own_attributes.layer_name.as_ref().map(decoded);
        name.unwrap_or_else(|| format!("part {}", number + 1))
    };
    let others = headers.iter().enumerate().filter(|(number, _)| *number != read);
    Ok(Layout { offset: [x, y], other_parts: others.map(name).collect() })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_part_is_read_and_the_others_are_named() {
        let part = |name: Option<&str>, value: f32| {
            let channel = AnyChannel::new("Y", FlatSamples::F32(vec![value; 4]));
            let mut attributes = LayerAttributes { layer_name: name.map(Text::from), ..Default::default() };
            attributes.layer_position = Vec2(8, 4);
            Layer::new(
                (2, 2),
                attributes,
                Encoding::UNCOMPRESSED,
                AnyChannels::sort(smallvec::smallvec![channel]),
            )
        };
        let layers = smallvec::smallvec![part(Some("beauty"), 1.0), part(Some("depth"), 2.0)];
        let image = Image::from_layers(ImageAttributes::new(IntegerBounds::new((0, 0), (16, 16))), layers);
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("parts.exr");
        image.write().to_file(&path).expect("a file can be written");
        let found = read(&path).expect("a picture");
        assert_eq!(found.channel("Y"), Some(&[1.0; 4][..]));
        assert_eq!(found.layout, Layout { offset: [8, 4], other_parts: vec!["depth".to_owned()] });
    }
}
