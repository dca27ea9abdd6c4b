//! Film and reconstruction filter.

use super::super::description::{Crop, Film, PixelFormat};
use super::super::source::{Place, SceneError};
use super::Reader;
use super::query::Query;
use super::tree::{Class, ObjectId};
use crate::film::FilterKind;

/// Mitsuba 3's default size in pixels.
const DEFAULT_SIZE: [u32; 2] = [768, 576];

/// Most pixels along one side.
const LONGEST_SIDE: i64 = 65_536;

/// Most pixels in all: some hundred bytes each have to fit into memory.
const MOST_PIXELS: u64 = 1 << 28;

/// Mitsuba 3's default filter.
const DEFAULT_FILTER: FilterKind = FilterKind::Gaussian { stddev: 0.5 };

pub(super) fn default(place: &Place) -> Film {
    Film {
        place: place.clone(),
        width: DEFAULT_SIZE[0],
        height: DEFAULT_SIZE[1],
        crop: None,
        filter: DEFAULT_FILTER,
        pixel_format: PixelFormat::Rgb,
    }
}

pub(super) fn read(reader: &Reader, id: ObjectId) -> Film {
    let query = Query::new(reader, id);
    let object = query.object;
    if object.plugin != "hdrfilm" {
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
        filter: filter(&query),
        pixel_format: pixel_format(&query),
    };
    formats(&query);
    sample_border(&query, film.filter);
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

fn pixel_format(query: &Query<'_>) -> PixelFormat {
    const FORMATS: [(&str, (PixelFormat, bool)); 6] = [
        ("rgb", (PixelFormat::Rgb, false)),
        ("xyz", (PixelFormat::Xyz, false)),
        ("luminance", (PixelFormat::Luminance, false)),
        ("rgba", (PixelFormat::Rgb, true)),
        ("xyza", (PixelFormat::Xyz, true)),
        ("luminance_alpha", (PixelFormat::Luminance, true)),
    ];
    let (format, alpha) = query.choice("pixel_format", &FORMATS, true).unwrap_or((PixelFormat::Rgb, false));
    if alpha {
        query.reader.remark(&query.place("pixel_format"), "no alpha channel is written".to_owned());
    }
    format
}

/// What Mitsuba 3 says about the file that it writes; pixels here are always 32-bit floats in OpenEXR.
fn formats(query: &Query<'_>) {
    const COMPONENTS: [(&str, bool); 3] = [("float16", true), ("float32", false), ("uint32", true)];
    if query.choice("component_format", &COMPONENTS, true) == Some(true) {
        query.reader.remark(&query.place("component_format"), "channels are written as float32".to_owned());
    }
    if let Some(format) = query.text("file_format")
        && !format.eq_ignore_ascii_case("openexr")
    {
        query.error(
            SceneError::at(
                &query.place("file_format"),
                format!("The file format \"{format}\" is not written"),
                "expected openexr",
            )
            .with_remedy("a PNG preview is written beside the OpenEXR file"),
        );
    }
    for name in ["banner", "compensate"] {
        if query.has(name) {
            query.boolean(name, false);
            query.reader.remark(&query.place(name), format!("{name} changes nothing"));
        }
    }
}

/// Samples beyond the edge matter only to filters that reach over it.
fn sample_border(query: &Query<'_>, filter: FilterKind) {
    if !query.boolean("sample_border", false) {
        return;
    }
    let place = query.place("sample_border");
    if filter == FilterKind::Box {
        query.reader.remark(&place, "sample_border changes nothing with the box filter".to_owned());
        return;
    }
    query.error(
        SceneError::at(
            &place,
            "Samples outside the picture are not supported yet",
            "expected false, or the box filter",
        )
        .with_remedy("render a larger picture and crop it"),
    );
}

fn filter(query: &Query<'_>) -> FilterKind {
    let Some((_, id)) = query.object(Class::Filter) else { return DEFAULT_FILTER };
    let query = Query::new(query.reader, id);
    let third = |name| query.float(name).unwrap_or(1.0 / 3.0);
    let filter = match query.object.plugin.as_str() {
        "box" => FilterKind::Box,
        "tent" => FilterKind::Tent { radius: query.positive("radius", 1.0) },
        "gaussian" => FilterKind::Gaussian { stddev: query.positive("stddev", 0.5) },
        "mitchell" => FilterKind::Mitchell { b: third("B"), c: third("C") },
        "catmullrom" => FilterKind::CatmullRom,
        "lanczos" => {
            FilterKind::Lanczos { lobes: query.integer("lobes", 1, 32).map_or(3, |lobes| lobes as u32) }
        }
        _ => {
            query.reader.unknown_plugin(query.object);
            return DEFAULT_FILTER;
        }
    };
    query.finish();
    filter
}
