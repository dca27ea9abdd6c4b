//! OpenEXR images: the flat channels R G B, Y, or X Y Z of one layer, with or without A.

use super::{Image, ImageError, check_size};
use crate::spectrum::colour::{RgbSpace, xyz_to_rec709};
use ::exr::image::FlatSamples;
use ::exr::math::Vec2;
use ::exr::meta::attribute::Chromaticities;
use ::exr::prelude::{ReadChannels, ReadLayers, read};
use std::io::Cursor;

pub(super) const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

pub(super) fn decode(bytes: &[u8]) -> Result<Image, ImageError> {
    let damaged = |error: ::exr::error::Error| {
        ImageError::new(
            format!("The OpenEXR file cannot be decoded: {error}"),
            "expected a complete, undamaged file",
        )
    };
    let reader = ::exr::block::read(Cursor::new(bytes), false).map_err(damaged)?;
    let [header] = reader.headers() else {
        return Err(ImageError::new(
            format!("The OpenEXR file has {} parts", reader.headers().len()),
            "expected a file of one part",
        ));
    };
    let (width, height) = (header.layer_size.0, header.layer_size.1);
    check_size(width, height, header.channels.bytes_per_pixel, bytes.len())?;
    let space = header.shared_attributes.chromaticities.map(space).filter(differs);
    let names: Vec<String> = header.channels.list.iter().map(|channel| channel.name.to_string()).collect();
    let wanted = colour(&names)?;

    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_chunks(reader)
        .map_err(damaged)?;
    let channels = &image.layer_data.channel_data.list;
    let columns: Vec<Vec<f32>> = wanted
        .channels()
        .iter()
        .filter_map(|&channel| channels.get(channel))
        .map(|channel| match &channel.sample_data {
            FlatSamples::F16(values) => values.iter().map(|value| value.to_f32()).collect(),
            FlatSamples::F32(values) => values.clone(),
            FlatSamples::U32(values) => values.iter().map(|&value| value as f32).collect(),
        })
        .collect();
    let texels = width * height;
    if columns.iter().any(|column| column.len() != texels) {
        return Err(ImageError::new(
            "The channels of the OpenEXR file differ in resolution",
            "expected a value of each channel for every texel",
        ));
    }
    let of_file = space.filter(|_| matches!(wanted, Colour::Rgb(_)));
    let convert = of_file.map(|space| space.to_rec709().ok_or_else(no_colours)).transpose()?;
    let values: Vec<f32> = match (wanted, columns.as_slice()) {
        (Colour::Rgb(_), [r, g, b]) => (0..texels)
            .flat_map(|i| match &convert {
                Some(convert) => convert([r[i], g[i], b[i]].map(f64::from)).map(|value| value as f32),
                None => [r[i], g[i], b[i]],
            })
            .collect(),
        (Colour::Xyz(_), [x, y, z]) => (0..texels)
            .flat_map(|i| xyz_to_rec709([x[i], y[i], z[i]].map(f64::from).into()).map(|value| value as f32))
            .collect(),
        (_, [grey, ..]) => grey.clone(),
        (_, []) => Vec::new(),
    };
    let channels = if matches!(wanted, Colour::Grey(_)) { 1 } else { 3 };
    Ok(Image::new(width, height, channels, values, false))
}

/// What the file says of its primaries and white.
fn space(stated: Chromaticities) -> RgbSpace {
    let at = |place: Vec2<f32>| (f64::from(place.x()), f64::from(place.y()));
    RgbSpace { primaries: [stated.red, stated.green, stated.blue].map(at), white: at(stated.white) }
}

/// Whether the values are not those of BT.709. Programs write its chromaticities with three digits or more.
fn differs(space: &RgbSpace) -> bool {
    let pairs = |space: &RgbSpace| [space.primaries.as_slice(), &[space.white]].concat();
    let far = |((x, y), (known_x, known_y)): (&(f64, f64), &(f64, f64))| {
        (x - known_x).abs().max((y - known_y).abs()) > 5e-4
    };
    pairs(space).iter().zip(&pairs(&RgbSpace::REC709)).any(far)
}

fn no_colours() -> ImageError {
    ImageError::new(
        "The chromaticities of the OpenEXR file span no colours",
        "expected those of three primaries and of white that differ",
    )
}

/// Which channels make the colour, as indices into those of the file.
#[derive(Clone, Copy)]
enum Colour {
    Rgb([usize; 3]),
    Xyz([usize; 3]),
    Grey([usize; 1]),
}

impl Colour {
    fn channels(&self) -> &[usize] {
        match self {
            Self::Rgb(channels) | Self::Xyz(channels) => channels,
            Self::Grey(channels) => channels,
        }
    }
}

/// As in Mitsuba 3, the channels must be those of one colour and an opacity at most, whatever comes before
/// the last dot of their names, in capitals or not.
fn colour(names: &[String]) -> Result<Colour, ImageError> {
    let short: Vec<String> =
        names.iter().map(|name| name.rsplit('.').next().unwrap_or(name).to_lowercase()).collect();
    let others = short.iter().filter(|name| *name != "a").count();
    let find = |name: &str| short.iter().position(|other| other == name);
    let all = |wanted: [&str; 3]| match wanted.map(find) {
        [Some(a), Some(b), Some(c)] if others == 3 => Some([a, b, c]),
        _ => None,
    };
    if let Some(channels) = all(["r", "g", "b"]) {
        return Ok(Colour::Rgb(channels));
    }
    if let Some(channels) = all(["x", "y", "z"]) {
        return Ok(Colour::Xyz(channels));
    }
    match find("y") {
        Some(channel) if others == 1 => Ok(Colour::Grey([channel])),
        _ => Err(ImageError::new(
            format!("The OpenEXR file has the channels {}", names.join(", ")),
            "expected R G B, X Y Z or Y, with or without A, and no others",
        )),
    }
}
