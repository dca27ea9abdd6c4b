//! Textures and colours: the files that they name, and what fits where.

use super::super::description::{BitmapSource, RgbRole, SpectrumKind, SpectrumSource};
use super::super::source::{Place, SceneError};
use super::spectra::{self, Use};
use super::{Reader, files};
use crate::raster::{Image, ImageError};
use std::path::Path;

/// A larger file is refused.
const LARGEST_FILE: u64 = 2 << 30;

/// What a file holds that a scene names at `place`.
pub(in crate::scene) fn decoded<T>(
    path: &Path,
    place: &Place,
    decode: impl FnOnce(&[u8]) -> Result<T, ImageError>,
) -> Result<T, SceneError> {
    let bytes = files::read(path, LARGEST_FILE, place)?;
    decode(&bytes).map_err(|error| {
        SceneError::at(place, format!("{} ({})", error.problem, path.display()), error.expected)
    })
}

/// The image of a file that a scene names at `place`.
pub(in crate::scene) fn decoded_image(path: &Path, place: &Place) -> Result<Image, SceneError> {
    let extension = path.extension().and_then(|extension| extension.to_str());
    decoded(path, place, |bytes| Image::decode(bytes, extension))
}

/// Whether the values depend on the place on a surface.
pub(in crate::scene) fn varies(source: &SpectrumSource) -> bool {
    match &source.kind {
        SpectrumKind::Constant(_)
        | SpectrumKind::Irregular { .. }
        | SpectrumKind::Regular { .. }
        | SpectrumKind::D65
        | SpectrumKind::Blackbody { .. }
        | SpectrumKind::Named(_)
        | SpectrumKind::Rgb { .. }
        | SpectrumKind::Vector(_) => false,
        SpectrumKind::Daylit(nested) => varies(nested),
        _ => true,
    }
}

/// Whether a texture or colour gives what a use asks of it, within the bounds of that use; reports it where
/// not. `None` for what is neither.
pub(in crate::scene) fn check(
    reader: &Reader,
    source: &SpectrumSource,
    name: &str,
    purpose: Use,
) -> Option<bool> {
    let refuse = |problem: String, expected: &str, remedy: &str| {
        let error = SceneError::at(&source.place, problem, expected);
        reader.error(if remedy.is_empty() { error } else { error.with_remedy(remedy) });
        Some(false)
    };
    let title = purpose.title(name);
    if varies(source) && matches!(purpose, Use::Index | Use::Response) {
        return refuse(format!("{title} cannot vary over a surface"), "expected a spectrum", "");
    }
    if !purpose.is_spectral()
        && matches!(
            source.kind,
            SpectrumKind::Irregular { .. }
                | SpectrumKind::Regular { .. }
                | SpectrumKind::D65
                | SpectrumKind::Blackbody { .. }
                | SpectrumKind::Named(_)
                | SpectrumKind::Daylit(_)
        )
    {
        let expected = "expected a number, or a texture that gives one";
        return refuse(format!("{title} does not depend on the wavelength"), expected, "");
    }
    if purpose == Use::Height && !is_sloped(source) {
        let expected = "expected a bitmap, or a pattern whose colours are interpolated";
        return refuse(format!("{title} has no slope"), expected, "");
    }
    match &source.kind {
        SpectrumKind::Constant(_) | SpectrumKind::Rgb { .. } if purpose == Use::Normals => {
            let what =
                if matches!(source.kind, SpectrumKind::Rgb { .. }) { "a colour" } else { "one number" };
            refuse(
                format!("{title} is {what}, not a normal"),
                "expected a bitmap of three raw channels",
                "one normal for all of the surface is a texture of type rawconstant whose value is a <vector>",
            )
        }
        SpectrumKind::Rgb { rgb, role } => {
            let least = if *role == RgbRole::Clipped { 0.0 } else { f64::NEG_INFINITY };
            let most = if *role == RgbRole::Reflectance { 1.0 } else { f64::INFINITY };
            let is_wrong = |value: f64| !(0.0..=most).contains(&value) || !purpose.allows_colour(value);
            if let Some(value) = rgb.iter().find(|&&value| is_wrong(value.max(least))) {
                let expected =
                    if most == 1.0 { "expected components from 0 to 1" } else { purpose.expected() };
                return refuse(
                    format!("{title} has a colour component of {value}"),
                    expected,
                    purpose.remedy(*value),
                );
            }
            if *role == RgbRole::Clipped && rgb.iter().any(|value| !(0.0..=1.0).contains(value)) {
                reader.assumption(
                    &source.place,
                    "components of the colour below 0 count as 0 and above 1 as 1, as in Mitsuba 3; give a spectrum for other values"
                        .to_owned(),
                );
            }
            Some(true)
        }
        SpectrumKind::Bitmap(bitmap) => {
            // A colour gives its luminance where one number is asked.
            let is_number = !purpose.is_spectral() && purpose != Use::Normals;
            let channels = match bitmap.image.channels {
                channels if bitmap.raw => Some(channels),
                channels => (channels == 1 || is_number).then_some(1),
            };
            if let Some((problem, expected, remedy)) = unfit(purpose, channels) {
                return refuse(format!("{title} is {problem}"), expected, remedy);
            }
            let is_colour = bitmap.image.channels == 3 && !bitmap.raw;
            // Colours are made into reflectances, but of those no index may follow from the brightest.
            if is_colour && purpose.is_spectral() && purpose != Use::NormalReflectance {
                tell_of_clipping(reader, bitmap, &source.place);
                return Some(true);
            }
            let luminance = (is_colour && is_number).then(|| bitmap.image.luminance());
            let image = luminance.as_ref().unwrap_or(&bitmap.image);
            let value = |value: f32| if bitmap.raw { f64::from(value) } else { image.light(value) };
            let bad = image.values.iter().position(|&v| !purpose.allows(value(v) * source.scale));
            bad.map_or(Some(true), |at| {
                let texel = at / image.channels;
                let (x, y, found) =
                    (texel % image.width, texel / image.width, value(image.values[at]) * source.scale);
                refuse(
                    format!("{title} is {found} at the texel {x}, {y}"),
                    purpose.expected(),
                    purpose.remedy(found),
                )
            })
        }
        SpectrumKind::Checkerboard(board) => {
            Some(each(&board.colours, |colour| spectra::check(reader, colour, name, purpose)))
        }
        SpectrumKind::Procedural(_) if purpose == Use::Normals => refuse(
            format!("{title} is one number, not a normal"),
            "expected a bitmap of three raw channels",
            "",
        ),
        SpectrumKind::Procedural(procedural) => {
            let fits = |colour: &SpectrumSource| {
                let slopes = purpose != Use::Height || is_sloped(colour);
                // Between numbers there is a slope, though they have none.
                spectra::check(reader, colour, name, if slopes { purpose } else { Use::Weight })
            };
            Some(each(&procedural.colours, fits))
        }
        SpectrumKind::Vector(_) if purpose == Use::Normals => Some(true),
        SpectrumKind::Vector(_) => refuse(
            format!("{title} is three numbers"),
            "expected one number, or a colour",
            "write <rgb> for a colour: only a normal map takes three numbers as they are",
        ),
        SpectrumKind::MeshAttribute { .. } if purpose == Use::Normals => {
            refuse(format!("{title} cannot come from a mesh"), "expected a bitmap of three raw channels", "")
        }
        SpectrumKind::MeshAttribute { .. } => Some(true),
        SpectrumKind::Volume(volume) => {
            let grid = &volume.grid;
            if grid.channels == 6 {
                let expected = "expected a grid of one channel, or of three for a colour";
                return refuse(format!("{title} is six numbers"), expected, "");
            }
            let channels = if volume.raw { Some(grid.channels) } else { (grid.channels == 1).then_some(1) };
            if let Some((problem, expected, remedy)) = unfit(purpose, channels) {
                return refuse(format!("{title} is {problem}"), expected, remedy);
            }
            let mut values = grid.values.iter().map(|&value| f64::from(value) * source.scale);
            values.find(|&value| !purpose.allows(value)).map_or(Some(true), |value| {
                refuse(format!("{title} is {value} in a cell"), purpose.expected(), purpose.remedy(value))
            })
        }
        SpectrumKind::Daylit(nested) => Some(spectra::check(reader, nested, name, purpose)),
        _ => None,
    }
}

/// Whether all colours fit. Each is asked, so that each that is wrong is reported.
fn each(colours: &[SpectrumSource], fits: impl Fn(&SpectrumSource) -> bool) -> bool {
    colours.iter().filter(|colour| !fits(colour)).count() == 0
}

/// Tells of texels whose colour is beyond what a reflectance can be.
fn tell_of_clipping(reader: &Reader, bitmap: &BitmapSource, place: &Place) {
    let values = &bitmap.image.values;
    let bound = |start: f32, choose: fn(f32, f32) -> f32| values.iter().copied().fold(start, choose);
    let (least, greatest) = (bound(0.0, f32::min), bound(1.0, f32::max));
    if least < 0.0 || greatest > 1.0 {
        let found = match (least < 0.0, greatest > 1.0) {
            (true, true) => format!("from {least} to {greatest}"),
            (true, false) => format!("down to {least}"),
            _ => format!("up to {greatest}"),
        };
        reader.assumption(
            place,
            format!(
                "{} has values {found}: of its colours what is below 0 counts as 0 and what is above 1 as 1, as in Mitsuba 3",
                bitmap.file.display()
            ),
        );
    }
}

/// Whether the values change steadily over the surface.
fn is_sloped(source: &SpectrumSource) -> bool {
    match &source.kind {
        SpectrumKind::Bitmap(_) => true,
        SpectrumKind::Procedural(procedural) => {
            let is_number = |colour: &SpectrumSource| matches!(colour.kind, SpectrumKind::Constant(_));
            procedural.mixed && procedural.colours.iter().all(|colour| is_number(colour) || is_sloped(colour))
        }
        _ => false,
    }
}

/// Why an image or grid does not fit, what was expected, and what to do. `channels` are those of numbers; a
/// colour has none.
fn unfit(purpose: Use, channels: Option<usize>) -> Option<(&'static str, &'static str, &'static str)> {
    const RAW: &str = "<boolean name=\"raw\" value=\"true\"/> in the texture takes the values as they are";
    match channels {
        Some(3) if purpose.is_spectral() => {
            Some(("three numbers, not a colour", "expected a texture without raw", "leave out raw"))
        }
        None if !purpose.is_spectral() => {
            Some(("a colour, not a number", "expected a raw or a grey image", RAW))
        }
        Some(1) if purpose == Use::Normals => {
            Some(("one number, not a normal", "expected an image of three channels", ""))
        }
        _ => None,
    }
}
