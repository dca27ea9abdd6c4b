//! Spectra and textures as plugins.

mod colours;
mod formulas;
mod images;
mod patterns;
mod plugin;
mod tables;
pub mod volumes;

use super::fields::{Boolean, Choices, Float, Numbers};
use super::{
    Field, Ignored, Parameter, Range, Simple, Takes, boolean, choice, declare, float, ignored, numbers,
};
use crate::scene::description::{
    BitmapSource, CheckerboardSource, ProceduralSource, SpectrumKind, SpectrumSource,
};
use crate::scene::read::spectra::{self, Use};
use crate::scene::read::{Class, Query, Value};
use crate::scene::source::{Place, SceneError};
use crate::scene::write::{Node, Writer};
use crate::spectrum::{DispersionFormula, FormulaKind};
use crate::texture::{Filter, Pattern, Wrap};
use colours::{Colour, Raw, Shone};
use formulas::{CAUCHY, Formula, GREATEST_WAVELENGTH, LEAST_WAVELENGTH, SELLMEIER};
use images::Placed;
pub use images::{Picture, image};
pub use patterns::is_in_space;
use patterns::{Bent, Colours, Octaves, Space};
use plugin::Plugin;
use tables::{a_range, equally_spaced, everywhere, table};

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
