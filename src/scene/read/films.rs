//! Films.

use super::super::description::{Crop, Film, FilmChannel, FilmContent, PixelFormat, SpectrumKind};
use super::super::source::{Place, SceneError};
use super::Reader;
use super::names;
use super::query::Query;
use super::spectra::{self, Use};
use super::tree::{Class, ObjectId};
use crate::scene::plugins::filters;

/// Mitsuba 3's default size in pixels.
const DEFAULT_SIZE: [u32; 2] = [768, 576];

/// Most pixels along one side.
const LONGEST_SIDE: i64 = 65_536;

/// Most pixels in all: some hundred bytes each have to fit into memory.
const MOST_PIXELS: u64 = 1 << 28;

pub(super) fn default(place: &Place) -> Film {
    Film {
        place: place.clone(),
        width: DEFAULT_SIZE[0],
        height: DEFAULT_SIZE[1],
        crop: None,
        filter: filters::DEFAULT,
        sample_border: false,
        content: FilmContent::Colour { format: PixelFormat::Rgb, alpha: false },
    }
}

pub(super) fn read(reader: &Reader, id: ObjectId) -> Film {
    let query = Query::new(reader, id);
    let object = query.object;
    if !names::plugins(Class::Film).contains(&object.plugin.as_str()) {
        reader.unknown_plugin(object);
        return default(&object.place);
    }
    let [width, height] = [("width", DEFAULT_SIZE[0]), ("height", DEFAULT_SIZE[1])]
        .map(|(name, default)| query.integer(name, 1, LONGEST_SIDE).map_or(default, |size| size as u32));
    if u64::from(width) * u64::from(height) > MOST_PIXELS {
        let problem = format!("The picture has {width} × {height} pixels");
        query.error(SceneError::at(
            &object.place,
            problem,
            format!("expected at most {MOST_PIXELS} pixels in all"),
        ));
    }
    let film = Film {
        place: object.place.clone(),
        width,
        height,
        crop: crop(&query, width, height),
        filter: filters::of_film(&query),
        sample_border: query.boolean("sample_border", false),
        content: if object.plugin == "specfilm" { responses(&query) } else { colour(&query) },
    };
    component_format(&query);
    without_effect(&query, "compensate");
    query.finish();
    film
}

fn crop(query: &Query<'_>, width: u32, height: u32) -> Option<Crop> {
    let side = |offset: &'static str, size: &'static str, full: u32| {
        let from = query.integer(offset, 0, i64::from(u32::MAX)).unwrap_or(0);
        let length = query.integer(size, 1, i64::from(u32::MAX)).unwrap_or(i64::from(full));
        if from + length > i64::from(full) {
            let name = if query.has(size) { size } else { offset };
            query.error(
                SceneError::at(
                    &query.place(name),
                    format!("The crop window ends at pixel {} of {full}", from + length),
                    format!("expected {offset} + {size} of at most {full}"),
                )
                .with_remedy(format!("{size} is {full} where it is not given")),
            );
        }
        (from as u32, length as u32)
    };
    let (x, crop_width) = side("crop_offset_x", "crop_width", width);
    let (y, crop_height) = side("crop_offset_y", "crop_height", height);
    let whole = (x, y, crop_width, crop_height) == (0, 0, width, height);
    (!whole).then_some(Crop { x, y, width: crop_width, height: crop_height })
}

/// What an `hdrfilm` holds.
fn colour(query: &Query<'_>) -> FilmContent {
    const FORMATS: [(&str, (PixelFormat, bool)); 6] = [
        ("rgb", (PixelFormat::Rgb, false)),
        ("xyz", (PixelFormat::Xyz, false)),
        ("luminance", (PixelFormat::Luminance, false)),
        ("rgba", (PixelFormat::Rgb, true)),
        ("xyza", (PixelFormat::Xyz, true)),
        ("luminance_alpha", (PixelFormat::Luminance, true)),
    ];
    /// What a file can hold beside OpenEXR: whether luminance alone is possible.
    const FILES: [(&str, Option<bool>); 4] =
        [("openexr", None), ("exr", None), ("pfm", Some(true)), ("rgbe", Some(false))];
    without_effect(query, "banner");
    let (mut format, mut alpha) =
        query.choice("pixel_format", &FORMATS, true).unwrap_or((PixelFormat::Rgb, false));
    if let Some(Some(luminance)) = query.choice("file_format", &FILES, true) {
        let place = query.place("file_format");
        query.reader.remark(&place, "the file is written as OpenEXR".to_owned());
        let kept = !alpha && (format == PixelFormat::Rgb || luminance && format == PixelFormat::Luminance);
        if !kept {
            (format, alpha) = (PixelFormat::Rgb, false);
            let text = "pixel_format is rgb with this file_format, as in Mitsuba 3".to_owned();
            query.reader.remark(&query.place("pixel_format"), text);
        }
    }
    FilmContent::Colour { format, alpha }
}

/// What a `specfilm` holds: every spectrum in it is a sensor's response, under the name of its channel.
fn responses(query: &Query<'_>) -> FilmContent {
    let mut channels: Vec<FilmChannel> = Vec::new();
    for entry in query.spectra() {
        let name = entry.name.clone().unwrap_or_else(|| query.unnamed(entry));
        if channels.iter().any(|channel| channel.name == name)
            || name == "samples"
            || name.starts_with("error.")
        {
            query.error(
                SceneError::at(
                    &entry.name_place,
                    format!("The film cannot have a channel \"{name}\""),
                    "the file has another channel of this name",
                )
                .with_remedy("give the response another name"),
            );
            continue;
        }
        let Some(response) = spectra::entry(query, entry, &name, Use::Response) else { continue };
        let is_table = matches!(
            response.kind,
            SpectrumKind::Irregular { .. }
                | SpectrumKind::Regular { .. }
                | SpectrumKind::D65
                | SpectrumKind::Named(_)
        );
        if !is_table {
            query.error(
                SceneError::at(
                    &entry.value_place,
                    format!("The response \"{name}\" is not a table"),
                    "expected values over a range of wavelengths, as Mitsuba 3 does",
                )
                .with_remedy("write for instance value=\"360:1, 830:1\""),
            );
            continue;
        }
        channels.push(FilmChannel { name, response });
    }
    if channels.is_empty() {
        query.error(
            SceneError::at(
                &query.object.place,
                "The film has no response",
                "expected at least one spectrum in it",
            )
            .with_remedy("add one a channel, for instance <spectrum name=\"band1\" value=\"400:1, 500:1\"/>"),
        );
    }
    FilmContent::Responses(channels)
}

/// What Mitsuba 3 says about the numbers that it writes; here they are always 32-bit floats.
fn component_format(query: &Query<'_>) {
    const COMPONENTS: [(&str, bool); 3] = [("float16", true), ("float32", false), ("uint32", true)];
    if query.choice("component_format", &COMPONENTS, true) == Some(true) {
        query.reader.remark(&query.place("component_format"), "channels are written as float32".to_owned());
    }
}

fn without_effect(query: &Query<'_>, name: &'static str) {
    if query.has(name) {
        query.boolean(name, false);
        query.reader.remark(&query.place(name), format!("{name} changes nothing"));
    }
}
