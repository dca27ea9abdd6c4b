//! Spectra and textures as plugins.

mod patterns;
pub mod volumes;

use super::fields::{Boolean, Choices, Float, Numbers};
use super::{
    Field, Ignored, Parameter, Range, Simple, Takes, boolean, choice, declare, float, ignored, numbers,
};
use crate::geometry::Transform;
use crate::raster::Image;
use crate::scene::description::{
    BitmapSource, CheckerboardSource, ProceduralSource, RgbRole, SpectrumKind, SpectrumSource,
};
use crate::scene::info::hash_of_values;
use crate::scene::read::spectra::{self, Use};
use crate::scene::read::{Class, Query, Value};
use crate::scene::source::{Place, SceneError};
use crate::scene::write::{self, Node, Writer};
use crate::spectrum::{DispersionFormula, Extrapolation, FormulaKind, Spectrum};
use crate::texture::{Filter, Pattern, Wrap};
use crate::units::WavelengthRange;
pub use patterns::is_in_space;
use patterns::{Bent, Colours, Octaves, Space};
use std::path::PathBuf;
use std::sync::Arc;

/// A spectrum as its plugin has it.
pub enum Plugin {
    Uniform(f64),
    Regular { min_nm: f64, max_nm: f64, values: Vec<f64> },
    Irregular { nm: Vec<f64>, values: Vec<f64> },
    D65 { lit: Lit, scale: f64 },
    Blackbody { kelvin: f64, min_nm: f64, max_nm: f64 },
    Rgb([f64; 3]),
    Srgb { rgb: [f64; 3], unbounded: bool },
    RawConstant(SpectrumKind),
    Bitmap(BitmapSource),
    Checkerboard(CheckerboardSource),
    MeshAttribute { name: String, scale: f64 },
    Volume(SpectrumKind),
    Procedural(ProceduralSource),
    Measured { name: String, scale: f64 },
    Sellmeier(DispersionFormula),
    Cauchy(DispersionFormula),
}

/// What D65 shines on.
#[derive(Clone)]
pub enum Lit {
    Nothing,
    Colour([f64; 3]),
    Texture(Arc<SpectrumSource>),
}

declare! {
    Class::Spectrum => Plugin;

    "uniform", "the same at all wavelengths" => Plugin::Uniform(value) {
        value: float("value", 0.0, "value").required(),
    } ignoring [
        ignored("wavelength_min", Takes::Float(Range::ALL), "").silent(),
        ignored("wavelength_max", Takes::Float(Range::ALL), "").silent(),
    ] then everywhere;
    "regular", "linear between equally spaced values, 0 outside"
        => Plugin::Regular { min_nm, max_nm, values } {
        min_nm: float("wavelength_min", 0.0, "wavelength of the first value").required().unit("nm"),
        max_nm: float("wavelength_max", 0.0, "wavelength of the last value").required().unit("nm"),
        values: VALUES,
    } then equally_spaced;
    "irregular", "linear between values, 0 outside; `<spectrum value=\"400:1, 700:2\"/>` is short for it"
        => Plugin::Irregular { nm, values } {
        nm: numbers("wavelengths", "ascending wavelengths in nm"),
        values: VALUES,
    } then table;
    "d65", "daylight, the CIE table over 98.9974, or a colour or texture under it" => Plugin::D65 { lit, scale } {
        lit: Shone,
        scale: SCALE,
    };
    "blackbody", "Planck's law, W·m⁻²·sr⁻¹·nm⁻¹" => Plugin::Blackbody { kelvin, min_nm, max_nm } {
        kelvin: float("temperature", 0.0, "temperature").required().positive().unit("K")
            .said("A black body at {} K", "expected a temperature above 0 K"),
        min_nm: LEAST_WAVELENGTH,
        max_nm: GREATEST_WAVELENGTH,
    } then a_range;
    "rgb", "a smooth spectrum that has a colour" => Plugin::Rgb(rgb) { rgb: Colour("value") };
    "srgb", "the same" => Plugin::Srgb { rgb, unbounded } {
        rgb: Colour("color"),
        unbounded: boolean("unbounded", false, "whether components above 1 count as 1 and are not refused").quiet(),
    };
    "rawconstant", "a number, or three that are no colour" => Plugin::RawConstant(value) { value: Raw };
    "bitmap", "an image on u and v"
        => Plugin::Bitmap(BitmapSource { file, image, filter, wrap, raw, half, to_uv }) {
        (file, image): Picture("image"),
        filter: choice(
            "filter_type", Filter::Linear, &[("bilinear", Filter::Linear), ("nearest", Filter::Nearest)],
            "how texels are interpolated",
        ),
        wrap: wrap_mode(Wrap::Repeat),
        raw: RAW,
        to_uv: Placed("to_uv", "where it lies on u and v"),
        half: choice(
            "format", false, &[("auto", false), ("variant", false), ("fp16", true), ("float16", true)],
            "whether what is looked up is rounded to half precision",
        ).quiet(),
    } ignoring [ACCEL];
    "checkerboard", "two spectra or textures in turn"
        => Plugin::Checkerboard(CheckerboardSource { colours: [first, second], to_uv }) {
        first: Part("color0", 0.4, "at the origin"),
        second: Part("color1", 0.2, "beside it"),
        to_uv: Placed("to_uv", "where it lies on u and v"),
    };
    "mesh_attribute", "what the vertices or faces of a mesh carry" => Plugin::MeshAttribute { name, scale } {
        name: super::text("name", "its name, which begins with `vertex_` or `face_`"),
        scale: SCALE,
    } then of_a_mesh;
    "volume", "values in space, on a surface" => Plugin::Volume(kind) { kind: InSpace };
    "noise" extension "a pattern that is computed", "noise"
        => Plugin::Procedural(ProceduralSource {
            pattern: Pattern::Noise(octaves), space, period, colours, range: [low, high], mixed
        }) {
        octaves: Octaves(1),
        period: spacing("size of its cells"),
        space: Space,
        colours: Colours,
        low: LOW,
        high: HIGH,
        mixed: mixing(true),
    } then spread;
    "turbulence" extension "a pattern that is computed", "sums of the magnitudes of noise"
        => Plugin::Procedural(ProceduralSource {
            pattern: Pattern::Turbulence(octaves), space, period, colours, range: [low, high], mixed
        }) {
        octaves: Octaves(6),
        period: spacing("size of its largest cells"),
        space: Space,
        colours: Colours,
        low: LOW,
        high: HIGH,
        mixed: mixing(true),
    } then spread;
    "marble" extension "a pattern that is computed", "veins across x"
        => Plugin::Procedural(ProceduralSource {
            pattern: Pattern::Marble(veins), space, period, colours, range: [low, high], mixed
        }) {
        veins: Bent(6),
        period: spacing("distance of veins"),
        space: Space,
        colours: Colours,
        low: LOW,
        high: HIGH,
        mixed: mixing(true),
    } then spread;
    "wood" extension "a pattern that is computed", "rings around z"
        => Plugin::Procedural(ProceduralSource {
            pattern: Pattern::Wood(veins), space, period, colours, range: [low, high], mixed
        }) {
        veins: Bent(3),
        period: spacing("distance of rings"),
        space: Space,
        colours: Colours,
        low: LOW,
        high: HIGH,
        mixed: mixing(true),
    } then spread;
    "bands" extension "a pattern that is computed", "bands across x"
        => Plugin::Procedural(ProceduralSource {
            pattern: Pattern::Bands, space, period, colours, range: [low, high], mixed
        }) {
        period: spacing("distance of bands"),
        space: Space,
        colours: Colours,
        low: LOW,
        high: HIGH,
        mixed: mixing(false),
    } then spread;
    "measured", "one of the measured spectra that come with abbe *(extension)*" => Plugin::Measured { name, scale } {
        name: Known,
        scale: SCALE.quiet(),
    };
    "sellmeier", "an index of refraction, n² = 1 + Σ b λ² / (λ² − c), λ in µm *(extension)*"
        => Plugin::Sellmeier(formula) { formula: Formula(&SELLMEIER) };
    "cauchy", "an index of refraction, n = A + B / λ² + C / λ⁴ + …, λ in µm *(extension)*"
        => Plugin::Cauchy(formula) { formula: Formula(&CAUCHY) };
}

/// Plugins that vary over surfaces.
pub const TEXTURES: [&str; 9] =
    ["bitmap", "checkerboard", "mesh_attribute", "volume", "noise", "turbulence", "marble", "wood", "bands"];

/// Plugins that only make sense as a refractive index.
pub const FORMULAS: [&str; 2] = ["sellmeier", "cauchy"];

const VALUES: Simple<Numbers> = numbers("values", "values");
const SCALE: Simple<Float> = float("scale", 1.0, "factor on the values");
const RAW: Simple<Boolean> =
    boolean("raw", false, "whether values are taken as they stand, not decoded and no colours");
const ACCEL: Ignored = ignored("accel", Takes::Boolean, "").silent();
const LEAST_WAVELENGTH: Simple<Float> =
    float("wavelength_min", WavelengthRange::VISIBLE.min, "where it begins").positive().unit("nm");
const GREATEST_WAVELENGTH: Simple<Float> =
    float("wavelength_max", WavelengthRange::VISIBLE.max, "where it ends").positive().unit("nm");
const LOW: Simple<Float> = float("low", 0.0, "value of the pattern that is the first colour");
const HIGH: Simple<Float> = float("high", 1.0, "value of the pattern that is the last colour");

const fn wrap_mode(default: Wrap) -> Simple<Choices<Wrap>> {
    const MODES: &[(&str, Wrap)] =
        &[("repeat", Wrap::Repeat), ("mirror", Wrap::Mirror), ("clamp", Wrap::Clamp)];
    choice("wrap_mode", default, MODES, "what is beyond the border")
}

const fn spacing(doc: &'static str) -> Simple<Float> {
    float("period", 1.0, doc).positive()
}

const fn mixing(default: bool) -> Simple<Boolean> {
    boolean("interpolate", default, "whether colours are mixed, and not each the only one over its part")
}

impl Plugin {
    fn of(source: &SpectrumSource) -> Self {
        let SpectrumSource { kind, scale, .. } = source;
        let scale = *scale;
        let scaled = |values: &[f64]| values.iter().map(|value| value * scale).collect::<Vec<_>>();
        match kind {
            SpectrumKind::Constant(value) => Self::Uniform(value * scale),
            SpectrumKind::Irregular { nm, values, .. } => {
                Self::Irregular { nm: nm.clone(), values: scaled(values) }
            }
            SpectrumKind::Regular { min_nm, max_nm, values } => {
                Self::Regular { min_nm: *min_nm, max_nm: *max_nm, values: scaled(values) }
            }
            SpectrumKind::D65 => Self::D65 { lit: Lit::Nothing, scale },
            SpectrumKind::Rgb { rgb, role: RgbRole::Illuminant } => {
                Self::D65 { lit: Lit::Colour(*rgb), scale }
            }
            SpectrumKind::Daylit(nested) => Self::D65 { lit: Lit::Texture(nested.clone()), scale },
            SpectrumKind::Blackbody { kelvin, min_nm, max_nm } => {
                Self::Blackbody { kelvin: *kelvin, min_nm: *min_nm, max_nm: *max_nm }
            }
            SpectrumKind::Rgb { rgb, role } => Self::Srgb { rgb: *rgb, unbounded: *role == RgbRole::Clipped },
            SpectrumKind::Vector(_) => Self::RawConstant(kind.clone()),
            SpectrumKind::Bitmap(source) => Self::Bitmap((**source).clone()),
            SpectrumKind::Checkerboard(source) => Self::Checkerboard((**source).clone()),
            SpectrumKind::MeshAttribute { name } => Self::MeshAttribute { name: name.clone(), scale },
            SpectrumKind::Volume(_) => Self::Volume(kind.clone()),
            SpectrumKind::Procedural(source) => Self::Procedural((**source).clone()),
            SpectrumKind::Named(name) => Self::Measured { name: name.clone(), scale },
        }
    }

    /// The spectrum with a factor on it; `None` for a formula of an index.
    fn spectrum(self) -> Option<(SpectrumKind, f64)> {
        let kind = match self {
            Self::Uniform(value) => SpectrumKind::Constant(value),
            Self::Regular { min_nm, max_nm, values } => SpectrumKind::Regular { min_nm, max_nm, values },
            Self::Irregular { nm, values } => SpectrumKind::Irregular { nm, values, file: None },
            Self::D65 { lit, scale } => {
                let kind = match lit {
                    Lit::Nothing => SpectrumKind::D65,
                    Lit::Colour(rgb) => SpectrumKind::Rgb { rgb, role: RgbRole::Illuminant },
                    Lit::Texture(nested) => SpectrumKind::Daylit(nested),
                };
                return Some((kind, scale));
            }
            Self::Blackbody { kelvin, min_nm, max_nm } => SpectrumKind::Blackbody { kelvin, min_nm, max_nm },
            Self::Rgb(rgb) => SpectrumKind::Rgb { rgb, role: RgbRole::Reflectance },
            Self::Srgb { rgb, unbounded } => {
                let role = if unbounded { RgbRole::Clipped } else { RgbRole::Reflectance };
                SpectrumKind::Rgb { rgb, role }
            }
            Self::RawConstant(kind) | Self::Volume(kind) => kind,
            Self::Bitmap(source) => SpectrumKind::Bitmap(Arc::new(source)),
            Self::Checkerboard(source) => SpectrumKind::Checkerboard(Arc::new(source)),
            Self::MeshAttribute { name, scale } => {
                return Some((SpectrumKind::MeshAttribute { name }, scale));
            }
            Self::Procedural(source) => SpectrumKind::Procedural(Arc::new(source)),
            Self::Measured { name, scale } => return Some((SpectrumKind::Named(name), scale)),
            Self::Sellmeier(_) | Self::Cauchy(_) => return None,
        };
        Some((kind, 1.0))
    }
}

/// What the plugin that is asked describes, with a factor; `None` where it is wrong, which is reported.
pub fn spectrum(query: &Query<'_>) -> Option<(SpectrumKind, f64)> {
    read(query)?.spectrum()
}

/// The refractive index of a formula.
pub fn index(query: &Query<'_>) -> Option<DispersionFormula> {
    match read(query)? {
        Plugin::Sellmeier(formula) | Plugin::Cauchy(formula) => Some(formula),
        _ => None,
    }
}

/// A spectrum as a plugin, even where a value would do.
pub fn node(source: &SpectrumSource, writer: &mut Writer) -> Node {
    write(&Plugin::of(source), &source.place, writer)
}

/// A formula of an index.
pub fn formula_node(place: &Place, formula: &DispersionFormula, writer: &mut Writer) -> Node {
    let plugin = match formula.kind() {
        FormulaKind::Cauchy => Plugin::Cauchy(formula.clone()),
        _ => Plugin::Sellmeier(formula.clone()),
    };
    write(&plugin, place, writer)
}

/// A material of the catalogue.
pub fn measured_node(place: &Place, name: &str, writer: &mut Writer) -> Node {
    write(&Plugin::Measured { name: name.to_owned(), scale: 1.0 }, place, writer)
}

/// The image that a property names, with its path.
pub fn image(query: &Query<'_>, name: &'static str) -> Option<(PathBuf, Arc<Image>)> {
    let reader = query.reader;
    let path = reader.search.find(query.required(name, query.text(name))?);
    let extension = path.extension().and_then(|extension| extension.to_str());
    let decode = |bytes: &[u8]| Image::decode(bytes, extension);
    let image = reader.images.get(reader, &path, &query.place(name), decode)?;
    Some((path, image))
}

/// Linear values for the primaries of sRGB.
struct Colour(&'static str);

impl Field for Colour {
    type Value = [f64; 3];

    fn parameters(&self) -> Vec<Parameter> {
        let doc = "linear values for the primaries of sRGB";
        vec![Parameter { is_required: true, doc, ..Parameter::new(self.0, Takes::Rgb) }]
    }

    fn read(&self, query: &Query<'_>) -> Option<[f64; 3]> {
        query.required(self.0, colour(query, self.0))
    }

    fn write(&self, node: Node, rgb: &[f64; 3], _: &mut Writer) -> Node {
        node.with(self.0, write::Value::Rgb(*rgb))
    }
}

/// Linear values for the primaries of sRGB, which Mitsuba 3 also takes from a vector.
fn colour(query: &Query<'_>, name: &'static str) -> Option<[f64; 3]> {
    let entry = query.entry(name)?;
    match &entry.value {
        Value::Rgb(rgb) => Some(*rgb),
        Value::Vector(vector) if query.object.plugin != "rgb" => Some(vector.to_array()),
        _ => {
            query.error(query.wrong_type(entry, name, "<rgb>"));
            None
        }
    }
}

/// What `d65` illuminates, if anything: a colour, or another texture of any name.
struct Shone;

impl Field for Shone {
    type Value = Lit;

    fn parameters(&self) -> Vec<Parameter> {
        let colour = Parameter::new("color", Takes::Rgb);
        let nested = Parameter::new("", Takes::Object("texture"));
        vec![
            Parameter { doc: "colour that it shines on", ..colour },
            Parameter { doc: "texture that it shines on, under any name", ..nested },
        ]
    }

    fn read(&self, query: &Query<'_>) -> Option<Lit> {
        if query.has("color") {
            return colour(query, "color").map(Lit::Colour);
        }
        match query.object(Class::Spectrum) {
            Some((_, id)) => spectra::plugin(query.reader, id).map(|nested| Lit::Texture(Arc::new(nested))),
            None => Some(Lit::Nothing),
        }
    }

    fn write(&self, node: Node, lit: &Lit, writer: &mut Writer) -> Node {
        match lit {
            Lit::Nothing => node,
            Lit::Colour(rgb) => node.with("color", write::Value::Rgb(*rgb)),
            Lit::Texture(nested) => node.child(self::node(nested, writer)),
        }
    }
}

/// One number, or three that are no colour.
struct Raw;

impl Field for Raw {
    type Value = SpectrumKind;

    fn parameters(&self) -> Vec<Parameter> {
        let doc = "a number, or a vector such as a normal";
        vec![Parameter { is_required: true, doc, ..Parameter::new("value", Takes::Vector) }]
    }

    fn read(&self, query: &Query<'_>) -> Option<SpectrumKind> {
        query.required("value", raw_constant(query))
    }

    fn write(&self, node: Node, kind: &SpectrumKind, _: &mut Writer) -> Node {
        match kind {
            SpectrumKind::Vector(vector) => node.vector("value", (*vector).into()),
            SpectrumKind::Constant(value) => node.float("value", *value),
            _ => node,
        }
    }
}

fn raw_constant(query: &Query<'_>) -> Option<SpectrumKind> {
    let entry = query.entry("value")?;
    match &entry.value {
        Value::Vector(vector) => Some(SpectrumKind::Vector(vector.to_array())),
        Value::Float(number) => Some(SpectrumKind::Constant(*number)),
        Value::Integer(number) => Some(SpectrumKind::Constant(*number as f64)),
        _ => {
            query.error(query.wrong_type(entry, "value", "<float>, <integer> or <vector>"));
            None
        }
    }
}

/// An image, with what it shows.
pub struct Picture(pub &'static str);

impl Field for Picture {
    type Value = (PathBuf, Arc<Image>);

    fn parameters(&self) -> Vec<Parameter> {
        vec![Parameter { is_required: true, doc: self.0, ..Parameter::new("filename", Takes::File) }]
    }

    fn read(&self, query: &Query<'_>) -> Option<Self::Value> {
        image(query, "filename")
    }

    fn write(&self, node: Node, (file, image): &Self::Value, _: &mut Writer) -> Node {
        let Image { width, height, channels, values, .. } = &**image;
        let kind = if *channels == 1 { "grey" } else { "in colour" };
        let content = hash_of_values(&[*width, *height, *channels], values);
        let summary = format!("{width} × {height} texels, {kind}");
        node.with("filename", write::Value::File { path: file.clone(), content, summary })
    }
}

/// A transform that is not written where it is the identity.
struct Placed(&'static str, &'static str);

impl Field for Placed {
    type Value = Transform;

    fn parameters(&self) -> Vec<Parameter> {
        vec![Parameter { doc: self.1, ..Parameter::new(self.0, Takes::Transform) }]
    }

    fn read(&self, query: &Query<'_>) -> Option<Transform> {
        Some(query.transform(self.0))
    }

    fn write(&self, node: Node, transform: &Transform, _: &mut Writer) -> Node {
        node.transform(self.0, transform)
    }
}

/// A part of a texture, with its name, default and documentation.
struct Part(&'static str, f64, &'static str);

impl Field for Part {
    type Value = SpectrumSource;

    fn parameters(&self) -> Vec<Parameter> {
        let part = Parameter::new(self.0, Takes::Spectrum(Use::Part));
        vec![Parameter { default: self.1.to_string(), doc: self.2, ..part }]
    }

    fn read(&self, query: &Query<'_>) -> Option<SpectrumSource> {
        spectra::part(query, self.0, self.1)
    }

    fn write(&self, node: Node, part: &SpectrumSource, _: &mut Writer) -> Node {
        node.spectrum(self.0, part)
    }
}

/// The volume that a texture shows.
struct InSpace;

impl Field for InSpace {
    type Value = SpectrumKind;

    fn parameters(&self) -> Vec<Parameter> {
        let volume = Parameter::new("volume", Takes::Object("volume"));
        vec![Parameter { is_required: true, doc: "the values", ..volume }]
    }

    fn read(&self, query: &Query<'_>) -> Option<SpectrumKind> {
        let entry = query.required("volume", query.entry("volume"))?;
        match entry.value {
            Value::Object(id) if query.reader.tree.get(id).class == Class::Volume => {
                volumes::of_object(query.reader, id).map(|source| source.kind)
            }
            _ => {
                query.error(query.wrong_type(entry, "volume", "<volume>"));
                None
            }
        }
    }

    fn write(&self, node: Node, kind: &SpectrumKind, writer: &mut Writer) -> Node {
        let SpectrumKind::Volume(source) = kind else { return node };
        let volume = volumes::node(source, &node.place, writer);
        node.named("volume", volume)
    }
}

/// The name of a measured spectrum or material.
pub struct Known;

impl Field for Known {
    type Value = String;

    fn parameters(&self) -> Vec<Parameter> {
        let doc = "its name, of those that `abbe spectrum --list` shows";
        vec![Parameter { is_required: true, doc, ..Parameter::new("name", Takes::Text) }]
    }

    fn read(&self, query: &Query<'_>) -> Option<String> {
        let name = query.required("name", query.text("name"))?;
        query.reader.extension(
            &query.object.place,
            format!("type=\"measured\": \"{name}\", one of the measured spectra that come with abbe"),
        );
        Some(name.to_owned())
    }

    fn write(&self, node: Node, name: &String, _: &mut Writer) -> Node {
        node.text("name", name.clone())
    }
}

/// The coefficients of a formula, by its lists of numbers, and the range that it is for.
struct Formula(&'static [Simple<Numbers>]);

static SELLMEIER: [Simple<Numbers>; 2] =
    [numbers("b", "factors of the terms"), numbers("c", "squares of their wavelengths, µm²")];
static CAUCHY: [Simple<Numbers>; 1] = [numbers("coefficients", "A, B, C …")];

impl Field for Formula {
    type Value = DispersionFormula;

    fn parameters(&self) -> Vec<Parameter> {
        let range = [LEAST_WAVELENGTH, GREATEST_WAVELENGTH];
        self.0.iter().flat_map(Field::parameters).chain(range.iter().flat_map(Field::parameters)).collect()
    }

    fn read(&self, query: &Query<'_>) -> Option<DispersionFormula> {
        let range =
            WavelengthRange { min: LEAST_WAVELENGTH.read(query)?, max: GREATEST_WAVELENGTH.read(query)? };
        let result = if query.object.plugin == "sellmeier" {
            let b = self.0[0].read(query);
            let c = self.0[1].read(query);
            match (b, c) {
                (Some(b), Some(c)) if b.len() == c.len() && !b.is_empty() => {
                    let terms: Vec<(f64, f64)> = b.into_iter().zip(c).collect();
                    Some(DispersionFormula::sellmeier(&terms, range))
                }
                (Some(b), Some(c)) => {
                    let problem = format!("\"b\" has {} numbers and \"c\" has {}", b.len(), c.len());
                    query.error(SceneError::at(
                        &query.place("c"),
                        problem,
                        "expected as many of one as of the other, at least 1",
                    ));
                    None
                }
                _ => None,
            }
        } else {
            let terms = self.0[0].read(query);
            terms.map(|terms| DispersionFormula::cauchy(&terms, range))
        };
        match result? {
            Ok(formula) => Some(formula),
            Err(error) => {
                query.error(
                    SceneError::at(
                        &query.object.place,
                        "The formula gives no refractive index",
                        error.to_string(),
                    )
                    .with_remedy("coefficients are for wavelengths in micrometres"),
                );
                None
            }
        }
    }

    fn write(&self, node: Node, formula: &DispersionFormula, writer: &mut Writer) -> Node {
        let coefficients = formula.coefficients();
        // The files' formulas have n² − 1 = Σ ..., and powers of 1/λ² that are not written.
        let odd = coefficients.iter().skip(1).step_by(2).copied().collect::<Vec<_>>();
        let node = if formula.kind() == FormulaKind::Cauchy {
            let terms: Vec<f64> = coefficients.first().copied().into_iter().chain(odd).collect();
            node.numbers("coefficients", &terms)
        } else {
            let even = coefficients.iter().skip(2).step_by(2).copied().collect::<Vec<_>>();
            node.numbers("b", &odd).numbers("c", &even)
        };
        let range = formula.stated();
        GREATEST_WAVELENGTH.write(LEAST_WAVELENGTH.write(node, &range.min, writer), &range.max, writer)
    }
}

/// Mitsuba 3 reads and ignores the range.
fn everywhere(query: &Query<'_>, plugin: Plugin) -> Option<Plugin> {
    for name in ["wavelength_min", "wavelength_max"] {
        if query.has(name) {
            let text = format!("{name} of \"uniform\" changes nothing, as in Mitsuba 3");
            query.reader.remark(&query.place(name), text);
        }
    }
    Some(plugin)
}

fn equally_spaced(query: &Query<'_>, plugin: Plugin) -> Option<Plugin> {
    let Plugin::Regular { min_nm, max_nm, values } = &plugin else { return Some(plugin) };
    match Spectrum::regular(*min_nm, *max_nm, values, Extrapolation::Zero) {
        Ok(_) => lit(query, "values", values).then_some(plugin),
        Err(error) => refuse_table(query, "values", &error.to_string()),
    }
}

fn table(query: &Query<'_>, plugin: Plugin) -> Option<Plugin> {
    let Plugin::Irregular { nm, values } = &plugin else { return Some(plugin) };
    match Spectrum::irregular(nm, values, Extrapolation::Zero) {
        Ok(_) => lit(query, "values", values).then_some(plugin),
        Err(error) => refuse_table(query, "wavelengths", &error.to_string()),
    }
}

fn refuse_table<T>(query: &Query<'_>, name: &'static str, expected: &str) -> Option<T> {
    query.error(SceneError::at(&query.place(name), "The table of the spectrum is wrong", expected));
    None
}

/// Refuses a table of zeros, as Mitsuba 3 does.
fn lit(query: &Query<'_>, name: &'static str, values: &[f64]) -> bool {
    let dark = values.iter().all(|&value| value == 0.0);
    if dark {
        query.error(spectra::all_zero(&query.place(name)));
    }
    !dark
}

fn a_range(query: &Query<'_>, plugin: Plugin) -> Option<Plugin> {
    let Plugin::Blackbody { min_nm, max_nm, .. } = &plugin else { return Some(plugin) };
    if min_nm >= max_nm {
        let problem = format!("The range from {min_nm} to {max_nm} nm is empty");
        query.error(SceneError::at(
            &query.object.place,
            problem,
            "expected wavelength_min below wavelength_max",
        ));
        return None;
    }
    Some(plugin)
}

fn of_a_mesh(query: &Query<'_>, plugin: Plugin) -> Option<Plugin> {
    let Plugin::MeshAttribute { name, .. } = &plugin else { return Some(plugin) };
    if !name.starts_with("vertex_") && !name.starts_with("face_") {
        query.error(
            SceneError::at(
                &query.place("name"),
                format!("\"{name}\" is not the name of an attribute"),
                "expected a name that begins with vertex_ or face_",
            )
            .with_remedy(format!(
                "write vertex_{name} for values of the vertices, face_{name} for those of the faces"
            )),
        );
        return None;
    }
    Some(plugin)
}

fn spread(query: &Query<'_>, plugin: Plugin) -> Option<Plugin> {
    if let Plugin::Procedural(source) = &plugin {
        patterns::ascending(query, source.range);
    }
    Some(plugin)
}
