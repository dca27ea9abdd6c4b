//! Films.

use super::fields::{Boolean, Choices};
use super::{Field, Ignored, Parameter, Simple, Takes, Use, boolean, choice, declare, filters, ignored};
use crate::scene::description::{Crop, Film, FilmChannel, FilmContent, PixelFormat, SpectrumKind};
use crate::scene::read::{Class, Query, spectra};
use crate::scene::source::{Place, SceneError};
use crate::scene::write::{Node, Writer};

declare! {
    Class::Film => FilmContent, common common;

    "hdrfilm", "colours" => FilmContent::Colour { format, alpha } {
        (format, alpha): Colours,
    } ignoring [ignored("banner", Takes::Boolean, "")];
    "specfilm", "a channel for each of some spectral responses, over which radiance is integrated"
        => FilmContent::Responses(channels) { channels: Responses };
}

/// Mitsuba 3's default size in pixels.
const DEFAULT_SIZE: [u32; 2] = [768, 576];

/// Most pixels along one side.
const LONGEST_SIDE: i64 = 65_536;

/// Most pixels in all: some hundred bytes each have to fit into memory.
const MOST_PIXELS: u64 = 1 << 28;

const SAMPLE_BORDER: Simple<Boolean> =
    boolean("sample_border", false, "whether pixels at the border see what lies outside the film");

const COMPENSATE: Ignored = ignored("compensate", Takes::Boolean, "");

/// What Mitsuba 3 says about the numbers that it writes, and whether they are others here.
const COMPONENTS: Simple<Choices<bool>> = choice(
    "component_format",
    false,
    &[("float16", true), ("float32", false), ("uint32", true)],
    "numbers of the file, which are `float32` whatever it says",
)
.in_any_case();

fn common() -> Vec<Parameter> {
    let filter = Parameter::new("", Takes::Object("rfilter"));
    [
        size_parameters(),
        crop_parameters(),
        COMPONENTS.parameters(),
        SAMPLE_BORDER.parameters(),
        vec![
            Parameter { doc: "the reconstruction filter; otherwise `gaussian`", ..filter },
            COMPENSATE.parameter(),
        ],
    ]
    .concat()
}

/// What a sensor without film has.
fn default(place: &Place) -> Film {
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

/// The film of the sensor that is asked.
pub fn of_sensor(sensor: &Query<'_>) -> Film {
    let Some((_, id)) = sensor.object(Class::Film) else { return default(&sensor.object.place) };
    let query = Query::new(sensor.reader, id);
    let place = &query.object.place;
    let default = default(place);
    if !NAMES.contains(&query.object.plugin.as_str()) {
        query.reader.unknown_plugin(query.object);
        return default;
    }
    let [width, height] = size(&query);
    let film = Film {
        place: place.clone(),
        width,
        height,
        crop: crop(&query, width, height),
        filter: filters::of_film(&query),
        sample_border: SAMPLE_BORDER.read(&query).unwrap_or(default.sample_border),
        content: read(&query).unwrap_or(default.content),
    };
    if COMPONENTS.read(&query) == Some(true) {
        query.reader.remark(&query.place("component_format"), "channels are written as float32".to_owned());
    }
    COMPENSATE.read(&query);
    query.finish();
    film
}

pub fn node(film: &Film, writer: &mut Writer) -> Node {
    let content = write(&film.content, &film.place, writer);
    let node = Node::new(Class::Film, content.plugin, &film.place)
        .integer("width", film.width)
        .integer("height", film.height);
    let mut node = match film.crop {
        Some(Crop { x, y, width, height }) => node
            .integer("crop_offset_x", x)
            .integer("crop_offset_y", y)
            .integer("crop_width", width)
            .integer("crop_height", height),
        None => node,
    };
    node.properties.extend(content.properties);
    let node = COMPONENTS.write(node, &false, writer);
    let node = SAMPLE_BORDER.write(node, &film.sample_border, writer);
    node.child(filters::write(&film.filter, &film.place, writer))
}

fn size_parameters() -> Vec<Parameter> {
    let side = |name, default: u32, doc| Parameter {
        default: default.to_string(),
        doc,
        ..Parameter::new(name, Takes::Integer(1, LONGEST_SIDE))
    };
    vec![side("width", DEFAULT_SIZE[0], "pixels across"), side("height", DEFAULT_SIZE[1], "pixels down")]
}

/// Width and height.
fn size(query: &Query<'_>) -> [u32; 2] {
    let [width, height] = [("width", DEFAULT_SIZE[0]), ("height", DEFAULT_SIZE[1])]
        .map(|(name, default)| query.integer(name, 1, LONGEST_SIDE).map_or(default, |size| size as u32));
    if u64::from(width) * u64::from(height) > MOST_PIXELS {
        let problem = format!("The picture has {width} × {height} pixels");
        let expected = format!("expected at most {MOST_PIXELS} pixels in all");
        query.error(SceneError::at(&query.object.place, problem, expected));
    }
    [width, height]
}

fn crop_parameters() -> Vec<Parameter> {
    let from = |name, doc| Parameter {
        default: "0".to_owned(),
        doc,
        ..Parameter::new(name, Takes::Integer(0, i64::from(u32::MAX)))
    };
    let length =
        |name, doc| Parameter { doc, ..Parameter::new(name, Takes::Integer(1, i64::from(u32::MAX))) };
    vec![
        from("crop_offset_x", "first column that is exposed"),
        from("crop_offset_y", "first row that is exposed"),
        length("crop_width", "number of columns that are exposed; otherwise `width`"),
        length("crop_height", "number of rows that are exposed; otherwise `height`"),
    ]
}

/// What is exposed of a film of this size; `None` where that is all of it.
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

/// What an `hdrfilm` holds, and whether alpha beside it.
#[derive(Clone, Copy)]
struct Colours;

impl Colours {
    const FORMAT: Simple<Choices<(PixelFormat, bool)>> = choice(
        "pixel_format",
        (PixelFormat::Rgb, false),
        &[
            ("rgb", (PixelFormat::Rgb, false)),
            ("xyz", (PixelFormat::Xyz, false)),
            ("luminance", (PixelFormat::Luminance, false)),
            ("rgba", (PixelFormat::Rgb, true)),
            ("xyza", (PixelFormat::Xyz, true)),
            ("luminance_alpha", (PixelFormat::Luminance, true)),
        ],
        "its channels",
    )
    .in_any_case();

    /// What a file can hold beside OpenEXR: whether luminance alone is possible.
    const FILE: Simple<Choices<Option<bool>>> = choice(
        "file_format",
        None,
        &[("openexr", None), ("exr", None), ("pfm", Some(true)), ("rgbe", Some(false))],
        "the file is OpenEXR whatever it says; with `pfm` and `rgbe` it has those channels that they can hold",
    )
    .in_any_case();
}

impl Field for Colours {
    type Value = (PixelFormat, bool);

    fn parameters(&self) -> Vec<Parameter> {
        [Self::FORMAT.parameters(), Self::FILE.parameters()].concat()
    }

    fn read(&self, query: &Query<'_>) -> Option<Self::Value> {
        let (format, alpha) = Self::FORMAT.read(query)?;
        let Some(luminance) = Self::FILE.read(query)? else { return Some((format, alpha)) };
        let place = query.place("file_format");
        query.reader.remark(&place, "the file is written as OpenEXR".to_owned());
        let kept = !alpha && (format == PixelFormat::Rgb || luminance && format == PixelFormat::Luminance);
        if kept {
            return Some((format, alpha));
        }
        let text = "pixel_format is rgb with this file_format, as in Mitsuba 3".to_owned();
        query.reader.remark(&query.place("pixel_format"), text);
        Some((PixelFormat::Rgb, false))
    }

    fn write(&self, node: Node, value: &Self::Value, writer: &mut Writer) -> Node {
        Self::FORMAT.write(node, value, writer)
    }
}

/// What a `specfilm` holds: every spectrum in it is a sensor's response, under the name of its channel.
struct Responses;

impl Field for Responses {
    type Value = Vec<FilmChannel>;

    fn parameters(&self) -> Vec<Parameter> {
        let response = Parameter::new("", Takes::Spectrum(Use::Response));
        let doc = "a response, under the name of its channel; a table";
        vec![Parameter { is_required: true, doc, ..response }]
    }

    fn read(&self, query: &Query<'_>) -> Option<Self::Value> {
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
            if !is_table(&response.kind) {
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
            let place = &query.object.place;
            let error =
                SceneError::at(place, "The film has no response", "expected at least one spectrum in it");
            query.error(error.with_remedy(
                "add one a channel, for instance <spectrum name=\"band1\" value=\"400:1, 500:1\"/>",
            ));
        }
        Some(channels)
    }

    fn write(&self, node: Node, channels: &Self::Value, _: &mut Writer) -> Node {
        channels.iter().fold(node, |node, channel| node.spectrum(channel.name.clone(), &channel.response))
    }
}

fn is_table(kind: &SpectrumKind) -> bool {
    matches!(
        kind,
        SpectrumKind::Irregular { .. }
            | SpectrumKind::Regular { .. }
            | SpectrumKind::D65
            | SpectrumKind::Named(_)
    )
}
