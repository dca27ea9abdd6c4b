//! Spectra and textures as plugins.

mod colours;
mod formulas;
pub(in crate::scene) mod images;
mod parts;
mod patterns;
mod tables;
pub mod volumes;

use super::fields::{Boolean, Choices, Float, Numbers};
use super::{Ignored, Range, Simple, Takes, boolean, choice, declare, float, ignored, numbers};
use crate::scene::description::{
    BitmapSource, CheckerboardSource, ProceduralSource, RgbRole, SpectrumKind, SpectrumSource,
};
use crate::scene::read::{Class, Query};
use crate::scene::source::Place;
use crate::scene::write::{Node, Writer};
use crate::spectrum::{DispersionFormula, FormulaKind};
use crate::texture::{Filter, Pattern, Wrap};
use colours::{Colour, Lit, Raw, Shone};
use formulas::{CAUCHY, Formula, GREATEST_WAVELENGTH, LEAST_WAVELENGTH, SELLMEIER};
use images::Placed;
pub use images::{Picture, image};
pub use parts::Known;
use parts::{InSpace, TextureColor, of_a_mesh, spread};
pub use patterns::is_in_space;
use patterns::{Bent, Colours, Octaves, Space};
use std::sync::Arc;
use tables::{a_range, equally_spaced, everywhere, table};

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
        unbounded: boolean("unbounded", false, "whether components outside of 0 to 1 count as the nearer of the two and are not refused").quiet(),
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
        first: TextureColor("color0", 0.4, "at the origin"),
        second: TextureColor("color1", 0.2, "beside it"),
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

impl Plugin {
    /// The plugin that stands for a spectrum.
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
