use super::super::description::{
    BitmapSource, PatternSpace, ProceduralSource, RgbRole, SpectrumKind, SpectrumSource, VolumeSource,
};
use super::super::info::hash_of_values;
use super::super::read::{COLOURS, Class};
use super::super::source::Place;
use super::{Node, Value};
use crate::geometry::Vec3;
use crate::raster::{Grid, Image};
use crate::spectrum::{DispersionFormula, FormulaKind};
use crate::texture::{Filter, Octaves, Pattern, Veins, Wrap};
use std::path::Path;
use std::rc::Rc;

pub(in crate::scene) fn write(source: &SpectrumSource) -> Value {
    let SpectrumSource { place, kind, scale } = source;
    let node = |plugin| Node::new(Class::Spectrum, plugin, place);
    let scaled = |values: &[f64]| values.iter().map(|value| value * scale).collect::<Vec<_>>();
    let object = match kind {
        SpectrumKind::Constant(value) => return Value::Flat(value * scale),
        SpectrumKind::Irregular { nm, values, file } => {
            return Value::List { nm: nm.clone(), values: scaled(values), file: file.clone() };
        }
        SpectrumKind::Regular { min_nm, max_nm, values } => node("regular")
            .float("wavelength_min", *min_nm)
            .float("wavelength_max", *max_nm)
            .numbers("values", &scaled(values)),
        SpectrumKind::D65 => node("d65").float("scale", *scale),
        SpectrumKind::Blackbody { kelvin, min_nm, max_nm } => node("blackbody")
            .float("temperature", *kelvin)
            .float("wavelength_min", *min_nm)
            .float("wavelength_max", *max_nm),
        SpectrumKind::Named(name) => return measured(place, name, *scale),
        SpectrumKind::Rgb { rgb, role: RgbRole::Reflectance } => node("srgb").with("color", Value::Rgb(*rgb)),
        SpectrumKind::Rgb { rgb, role: RgbRole::Clipped } => {
            node("srgb").with("color", Value::Rgb(*rgb)).boolean("unbounded", true)
        }
        SpectrumKind::Rgb { rgb, role: RgbRole::Illuminant } => {
            node("d65").with("color", Value::Rgb(*rgb)).float("scale", *scale)
        }
        SpectrumKind::Vector(vector) => node("rawconstant").vector("value", Vec3::from_array(*vector)),
        SpectrumKind::Bitmap(source) => bitmap(node("bitmap"), source),
        SpectrumKind::Checkerboard(board) => node("checkerboard")
            .spectrum("color0", &board.colours[0])
            .spectrum("color1", &board.colours[1])
            .transform("to_uv", &board.to_uv),
        SpectrumKind::MeshAttribute { name } => {
            node("mesh_attribute").text("name", name).float("scale", *scale)
        }
        SpectrumKind::Volume(source) => node("volume").named("volume", volume(place, source)),
        SpectrumKind::Procedural(source) => procedural(place, source),
        SpectrumKind::Daylit(nested) => {
            let nested = match write(nested) {
                Value::Object(object) => object,
                // A value by itself cannot stand in there.
                value => Rc::new(plugin_of(&nested.place, value)),
            };
            node("d65").child(nested).float("scale", *scale)
        }
    };
    Value::Object(Rc::new(object))
}

/// The file of an image.
pub(in crate::scene) fn picture(file: &Path, image: &Image) -> Value {
    let Image { width, height, channels, values, .. } = image;
    Value::File {
        path: file.to_owned(),
        content: hash_of_values(&[*width, *height, *channels], values),
        summary: format!("{width} × {height} texels, {}", if *channels == 1 { "grey" } else { "in colour" }),
    }
}

fn bitmap(node: Node, source: &BitmapSource) -> Node {
    let node = node
        .with("filename", picture(&source.file, &source.image))
        .text("filter_type", if source.filter == Filter::Linear { "bilinear" } else { "nearest" })
        .text("wrap_mode", wrap_name(source.wrap))
        .boolean("raw", source.raw)
        .transform("to_uv", &source.to_uv);
    if source.half { node.text("format", "fp16") } else { node }
}

fn procedural(place: &Place, source: &ProceduralSource) -> Node {
    let node = |plugin| Node::new(Class::Spectrum, plugin, place);
    let noise = |node: Node, octaves: &Octaves| {
        node.integer("octaves", octaves.count)
            .float("gain", octaves.gain)
            .integer("seed", octaves.seed as i64)
    };
    let veins = |node: Node, veins: &Veins| noise(node, &veins.octaves).float("turbulence", veins.strength);
    let node = match &source.pattern {
        Pattern::Noise(octaves) => noise(node("noise"), octaves),
        Pattern::Turbulence(octaves) => noise(node("turbulence"), octaves),
        Pattern::Marble(marble) => veins(node("marble"), marble),
        Pattern::Wood(wood) => veins(node("wood"), wood),
        Pattern::Bands => node("bands"),
    };
    let node = node.float("period", source.period);
    let node = match &source.space {
        PatternSpace::World(to_world) => node.text("space", "world").transform("to_world", to_world),
        PatternSpace::Uv(to_uv) => node.text("space", "uv").transform("to_uv", to_uv),
    };
    let colours = COLOURS.into_iter().zip(&source.colours);
    colours
        .fold(node, |node, (name, colour)| node.spectrum(name, colour))
        .float("low", source.range[0])
        .float("high", source.range[1])
        .boolean("interpolate", source.mixed)
}

pub(in crate::scene) fn volume(place: &Place, source: &VolumeSource) -> Node {
    let Grid { size, channels, values, .. } = &*source.grid;
    let [x, y, z] = *size;
    Node::new(Class::Volume, "gridvolume", place)
        .with(
            "filename",
            Value::File {
                path: source.file.clone(),
                content: hash_of_values(&[x, y, z, *channels], values),
                summary: format!("{x} × {y} × {z} cells, {channels} values each"),
            },
        )
        .text("filter_type", if source.filter == Filter::Linear { "trilinear" } else { "nearest" })
        .text("wrap_mode", wrap_name(source.wrap))
        .boolean("raw", source.raw)
        .boolean("use_grid_bbox", source.use_grid_bbox)
        .transform("to_world", &source.to_world)
}

fn wrap_name(wrap: Wrap) -> &'static str {
    match wrap {
        Wrap::Repeat => "repeat",
        Wrap::Mirror => "mirror",
        Wrap::Clamp => "clamp",
    }
}

/// A value that is written without a plugin, as one.
fn plugin_of(place: &Place, value: Value) -> Node {
    let node = |plugin| Node::new(Class::Spectrum, plugin, place);
    match value {
        Value::List { nm, values, .. } => {
            node("irregular").numbers("wavelengths", &nm).numbers("values", &values)
        }
        Value::Rgb(rgb) => node("rgb").with("value", Value::Rgb(rgb)),
        Value::Flat(value) => node("uniform").float("value", value),
        other => node("uniform").with("value", other),
    }
}

/// One of the measured spectra or materials that come with the program.
pub(in crate::scene) fn measured(place: &Place, name: &str, scale: f64) -> Value {
    let node = Node::new(Class::Spectrum, "measured", place).text("name", name);
    Value::Object(Rc::new(if scale == 1.0 { node } else { node.float("scale", scale) }))
}

/// A refractive index by formula.
pub(in crate::scene) fn formula(place: &Place, formula: &DispersionFormula) -> Value {
    let coefficients = formula.coefficients();
    // The files' formulas have n² − 1 = Σ ..., and powers of 1/λ² that are not written.
    let odd = coefficients.iter().skip(1).step_by(2).copied().collect::<Vec<_>>();
    let node = |plugin| Node::new(Class::Spectrum, plugin, place);
    let node = if formula.kind() == FormulaKind::Cauchy {
        let terms: Vec<f64> = coefficients.first().copied().into_iter().chain(odd).collect();
        node("cauchy").numbers("coefficients", &terms)
    } else {
        let even = coefficients.iter().skip(2).step_by(2).copied().collect::<Vec<_>>();
        node("sellmeier").numbers("b", &odd).numbers("c", &even)
    };
    let range = formula.stated();
    let node = node.float("wavelength_min", range.min).float("wavelength_max", range.max);
    Value::Object(Rc::new(node))
}
