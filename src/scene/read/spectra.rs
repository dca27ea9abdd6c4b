//! Spectra of reflectance, emission and absorption, with the checks that each use asks for.

use super::super::description::{RgbRole, SpectrumKind, SpectrumSource};
use super::super::plugins;
use super::super::source::{Place, SceneError};
use super::query::Query;
use super::tree::{Class, Entry, ObjectId, Value};
use super::{Reader, hints, textures};
use crate::spectrum::catalogue::{self, Kind, Quantity};
use crate::spectrum::{Extrapolation, Spectrum, upsample};
use crate::units::WavelengthRange;

/// What a spectrum is for: which values make sense, and what a bare number means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// From 0 to 1.
    Reflectance,
    /// The fraction of a medium's extinction that is scattered, from 0 to 1.
    Albedo,
    /// At least 0 and below 1, where an index follows from it.
    NormalReflectance,
    /// At least 0; a bare number is that many times D65.
    Emission,
    /// At least 0, per unit of length.
    Absorption,
    /// At least 0: n and k of a conductor.
    ConductorIndex,
    /// Above 0.
    Index,
    /// A weight or an opacity: clamped to 0 and 1 where it is used, as in Mitsuba 3.
    Weight,
    /// A parameter of a model, from 0 to 1.
    Fraction,
    /// A strength or a roughness, at least 0.
    Amount,
    /// What a sensor makes of each wavelength, at least 0.
    Response,
    /// A part of a texture: any number, until it is known what the texture is for.
    Part,
    /// A height, whose slope matters.
    Height,
    /// Normals, in three channels.
    Normals,
}

impl Use {
    /// What messages call the property `name`.
    pub fn title(self, name: &str) -> String {
        let word = match self {
            Self::Reflectance => "reflectance",
            Self::Albedo => "albedo",
            Self::NormalReflectance => "normal-incidence reflectance",
            Self::Emission => "emission",
            Self::Absorption => "absorption",
            Self::ConductorIndex | Self::Index => "refractive index",
            Self::Weight => "share",
            Self::Fraction | Self::Amount | Self::Part => "value",
            Self::Response => "response",
            Self::Height => "height",
            Self::Normals => "normal",
        };
        if word == name { format!("The {word}") } else { format!("The {word} \"{name}\"") }
    }

    /// The kind of measured spectrum that fits.
    fn kind(self) -> Option<Kind> {
        match self {
            Self::Reflectance | Self::NormalReflectance | Self::Albedo => Some(Kind::Reflectance),
            Self::Emission => Some(Kind::Illuminant),
            Self::Absorption => Some(Kind::Absorption),
            Self::Index => Some(Kind::Dielectric),
            Self::Response => Some(Kind::Sensitivity),
            // A metal has n and k together.
            Self::ConductorIndex
            | Self::Weight
            | Self::Fraction
            | Self::Amount
            | Self::Part
            | Self::Height
            | Self::Normals => None,
        }
    }

    /// What messages expect.
    pub fn expected(self) -> &'static str {
        match self {
            Self::Reflectance | Self::Albedo | Self::Fraction => "expected values from 0 to 1",
            Self::NormalReflectance => "expected values of at least 0 and below 1",
            Self::Emission | Self::Absorption | Self::ConductorIndex | Self::Amount | Self::Response => {
                "expected values of at least 0"
            }
            Self::Index => "expected values above 0",
            Self::Weight | Self::Part | Self::Height | Self::Normals => "expected finite values",
        }
    }

    /// Whether a value is possible.
    pub fn allows(self, value: f64) -> bool {
        match self {
            Self::Reflectance | Self::Albedo | Self::Fraction => (0.0..=1.0).contains(&value),
            Self::NormalReflectance => (0.0..1.0).contains(&value),
            Self::Emission | Self::Absorption | Self::ConductorIndex | Self::Amount | Self::Response => {
                value >= 0.0
            }
            Self::Index => value > 0.0,
            Self::Weight | Self::Part | Self::Height | Self::Normals => value.is_finite(),
        }
    }

    /// Whether a spectrum is looked up, and not a number.
    pub fn is_spectral(self) -> bool {
        match self {
            Self::Reflectance
            | Self::Albedo
            | Self::NormalReflectance
            | Self::Emission
            | Self::Absorption
            | Self::ConductorIndex
            | Self::Index
            | Self::Response
            | Self::Part => true,
            Self::Weight | Self::Fraction | Self::Amount | Self::Height | Self::Normals => false,
        }
    }

    /// Whether a colour may have such a component.
    pub fn allows_colour(self, value: f64) -> bool {
        match self {
            // No colour says what an index is.
            Self::Index => false,
            _ => self.allows(value),
        }
    }

    /// What to do about a value that is not allowed.
    pub fn remedy(self, value: f64) -> &'static str {
        match self {
            Self::Reflectance if (2.0..=100.0).contains(&value) => {
                "a surface cannot reflect more than it receives; per cent must be divided by 100"
            }
            Self::Reflectance if value > 1.0 => "a surface cannot reflect more than it receives",
            Self::NormalReflectance if value >= 1.0 => "no finite index reflects everything",
            Self::Albedo => "a medium cannot scatter more than it takes out of the light",
            Self::Emission => "light cannot be taken away",
            Self::Absorption => "a medium that amplifies cannot be rendered",
            Self::Index => "the index of vacuum is 1",
            Self::Fraction => "it is a share of the whole",
            Self::Amount | Self::Response => "0 leaves it out",
            Self::Weight | Self::Part | Self::Height | Self::Normals => {
                "check the table for what is no number"
            }
            Self::Reflectance | Self::NormalReflectance | Self::ConductorIndex => {
                "check the table for a sign that should not be there"
            }
        }
    }
}

/// A constant that the file leaves to the default.
pub(in crate::scene) fn constant(place: &Place, value: f64) -> SpectrumSource {
    SpectrumSource { place: place.clone(), kind: SpectrumKind::Constant(value), scale: 1.0 }
}

/// The spectrum `name`. `None` where it is absent or wrong.
pub(in crate::scene) fn read(query: &Query<'_>, name: &'static str, purpose: Use) -> Option<SpectrumSource> {
    let entry = query.entry(name)?;
    let source = written(query, entry, name, purpose)?;
    check(query.reader, &source, name, purpose).then_some(source)
}

/// The spectrum in an entry that the query found by other means than its name. `None` where it is wrong.
pub(in crate::scene) fn entry(
    query: &Query<'_>,
    entry: &Entry,
    name: &str,
    purpose: Use,
) -> Option<SpectrumSource> {
    let source = written(query, entry, name, purpose)?;
    check(query.reader, &source, name, purpose).then_some(source)
}

/// What an emitter sends out everywhere: Mitsuba 3's D65 where the file says nothing.
pub(in crate::scene) fn emission(query: &Query<'_>, name: &'static str) -> SpectrumSource {
    let source = radiance(query, name);
    if textures::varies(&source) {
        let problem = format!("{} cannot vary", Use::Emission.title(name));
        query.error(
            SceneError::at(&source.place, problem, "expected a spectrum, a colour or a number")
                .with_remedy("emitters with a texture are area, directionalarea, envmap, projector and spot"),
        );
    }
    source
}

/// What a surface sends out, which may vary: D65 where the file says nothing.
pub(in crate::scene) fn radiance(query: &Query<'_>, name: &'static str) -> SpectrumSource {
    read(query, name, Use::Emission).unwrap_or_else(|| SpectrumSource {
        place: query.object.place.clone(),
        kind: SpectrumKind::D65,
        scale: 1.0,
    })
}

/// A part of a texture. What it is worth is checked where the texture is used. `None` where it is wrong.
pub(in crate::scene) fn part(query: &Query<'_>, name: &'static str, default: f64) -> Option<SpectrumSource> {
    match query.entry(name) {
        Some(entry) => written(query, entry, name, Use::Part),
        None if query.has(name) => None,
        None => Some(constant(&query.object.place, default)),
    }
}

fn written(query: &Query<'_>, entry: &Entry, name: &str, purpose: Use) -> Option<SpectrumSource> {
    let place = entry.value_place.clone();
    let bare = |value: f64| match purpose {
        Use::Emission => SpectrumSource { place: place.clone(), kind: SpectrumKind::D65, scale: value },
        _ => constant(&place, value),
    };
    match &entry.value {
        Value::Float(value) => Some(bare(*value)),
        Value::Integer(value) => Some(bare(*value as f64)),
        Value::Flat(value) => Some(constant(&place, *value)),
        Value::List { values, .. } if values.iter().all(|&value| value == 0.0) => {
            query.error(all_zero(&place));
            None
        }
        Value::List { nm, values, file } => {
            let kind = SpectrumKind::Irregular { nm: nm.clone(), values: values.clone(), file: file.clone() };
            Some(SpectrumSource { place, kind, scale: 1.0 })
        }
        Value::Object(id) if query.reader.tree.get(*id).class == Class::Spectrum => {
            let source = plugin(query.reader, *id)?;
            // The place where it is used says more than the one where it is defined.
            Some(SpectrumSource { place, ..source })
        }
        Value::Object(id)
            if matches!((query.object.class, purpose), (Class::Medium, _) | (Class::Phase, Use::Weight))
                && query.reader.tree.get(*id).class == Class::Volume =>
        {
            let source = plugins::textures::volumes::of_object(query.reader, *id)?;
            Some(SpectrumSource { place, ..source })
        }
        Value::Rgb(rgb) => {
            let role = match purpose {
                Use::Emission => RgbRole::Illuminant,
                Use::ConductorIndex => RgbRole::Clipped,
                Use::Absorption if query.object.class == Class::Bsdf => RgbRole::Clipped,
                _ if query.object.class == Class::Volume => RgbRole::Clipped,
                _ => RgbRole::Reflectance,
            };
            Some(SpectrumSource { place, kind: SpectrumKind::Rgb { rgb: *rgb, role }, scale: 1.0 })
        }
        _ => {
            query.error(query.wrong_type(entry, name, "<spectrum>, <rgb>, <texture>, <float> or <integer>"));
            None
        }
    }
}

/// A reflectance as a function; `None` for what is no reflectance or is reported elsewhere.
fn function(source: &SpectrumSource) -> Option<Spectrum> {
    let spectrum = match &source.kind {
        SpectrumKind::Constant(value) => Spectrum::Constant(*value),
        SpectrumKind::Irregular { nm, values, .. } => {
            Spectrum::irregular(nm, values, Extrapolation::Zero).ok()?
        }
        SpectrumKind::Regular { min_nm, max_nm, values } => {
            Spectrum::regular(*min_nm, *max_nm, values, Extrapolation::Zero).ok()?
        }
        SpectrumKind::Named(name) => catalogue::reflectance(name).ok()?,
        SpectrumKind::Rgb { rgb, role: RgbRole::Reflectance } => {
            Spectrum::Sigmoid { shape: upsample(*rgb), factor: 1.0 }
        }
        _ => return None,
    };
    Some(spectrum.scaled(source.scale))
}

/// The wavelength (nm) and value where two reflectances sum up to most: at a node of one of them, since both
/// are linear between.
pub(in crate::scene) fn greatest_sum(a: &SpectrumSource, b: &SpectrumSource) -> Option<(f64, f64)> {
    let (a, b) = (function(a)?, function(b)?);
    let range = WavelengthRange::VISIBLE;
    let nodes = a.nodes().into_iter().chain(b.nodes()).chain([range.min, range.max]);
    nodes.map(|nm| (nm, a.at(nm) + b.at(nm))).max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Refuses values that the use does not allow, and lists without any light.
pub(in crate::scene) fn check(reader: &Reader, source: &SpectrumSource, name: &str, purpose: Use) -> bool {
    if source.scale < 0.0 || !source.scale.is_finite() {
        let problem = format!("{} is scaled by {}", purpose.title(name), source.scale);
        reader.error(SceneError::at(&source.place, problem, "expected a factor of at least 0"));
        return false;
    }
    if let Some(fits) = textures::check(reader, source, name, purpose) {
        return fits;
    }
    let Some(values) = extremes(reader, source, name, purpose) else { return false };
    for (nm, value) in values {
        let value = value * source.scale;
        if purpose.allows(value) {
            continue;
        }
        let at = nm.map_or(String::new(), |nm| format!(" at {nm} nm"));
        let problem = format!("{} is {value}{at}", purpose.title(name));
        reader.error(
            SceneError::at(&source.place, problem, purpose.expected()).with_remedy(purpose.remedy(value)),
        );
        return false;
    }
    if matches!(purpose, Use::Reflectance | Use::Albedo) {
        reader.ends(&purpose.title(name), source);
    }
    true
}

/// Least and greatest value with their wavelengths, where they have any. `None` where a name is unknown,
/// which is reported.
fn extremes(
    reader: &Reader,
    source: &SpectrumSource,
    name: &str,
    purpose: Use,
) -> Option<Vec<(Option<f64>, f64)>> {
    /// Greatest value of CIE D65 (117.812 at 460 nm) over 98.9974.
    const BRIGHTEST_D65: f64 = 117.812 / 98.9974;
    let nodes = |pairs: &mut dyn Iterator<Item = (f64, f64)>| {
        let mut bounds: Option<[(f64, f64); 2]> = None;
        for (nm, value) in pairs {
            let [least, greatest] = bounds.unwrap_or([(nm, value); 2]);
            bounds = Some([
                if value < least.1 { (nm, value) } else { least },
                if value > greatest.1 { (nm, value) } else { greatest },
            ]);
        }
        bounds.map(|bounds| bounds.map(|(nm, value)| (Some(nm), value)).to_vec())
    };
    match &source.kind {
        SpectrumKind::Constant(value) => Some(vec![(None, *value)]),
        SpectrumKind::Irregular { nm, values, .. } => {
            nodes(&mut nm.iter().copied().zip(values.iter().copied()))
        }
        SpectrumKind::Regular { min_nm, max_nm, values } => {
            let step = (max_nm - min_nm) / (values.len().max(2) - 1) as f64;
            nodes(&mut values.iter().enumerate().map(|(i, &value)| (min_nm + step * i as f64, value)))
        }
        SpectrumKind::D65 => Some(vec![(Some(460.0), BRIGHTEST_D65)]),
        SpectrumKind::Blackbody { kelvin, min_nm, max_nm } => {
            let (least, greatest) =
                Spectrum::blackbody(*kelvin).ok()?.bounds(WavelengthRange { min: *min_nm, max: *max_nm });
            Some(vec![(None, least), (None, greatest)])
        }
        SpectrumKind::Named(measured) => {
            let Some(kind) = purpose.kind() else {
                let problem = format!("\"{name}\" cannot be measured by itself");
                let error = SceneError::at(&source.place, problem, "expected a table of numbers");
                reader.error(match purpose {
                    Use::ConductorIndex => error.with_remedy(
                        "a metal has n and k together: <string name=\"material\" value=\"Au\"/>",
                    ),
                    _ => error,
                });
                return None;
            };
            let entry = lookup(reader, &source.place, kind, measured)?;
            let Quantity::Spectrum(spectrum) = entry.quantity else { return Some(Vec::new()) };
            let (least, greatest) = spectrum.bounds(WavelengthRange::VISIBLE);
            Some(vec![(None, least), (None, greatest)])
        }
        // Colours and textures are checked by themselves.
        _ => Some(Vec::new()),
    }
}

/// The entry of the catalogue, or a message with the nearest name.
pub(in crate::scene) fn lookup(
    reader: &Reader,
    place: &Place,
    kind: Kind,
    name: &str,
) -> Option<catalogue::Entry> {
    match catalogue::lookup(kind, name) {
        Ok(entry) => Some(entry),
        Err(unknown) => {
            let expected = format!("expected the name of a measured {kind}");
            let error = SceneError::at(place, format!("There is no measured {kind} \"{name}\""), expected);
            let other = Kind::ALL.into_iter().find(|&other| catalogue::lookup(other, name).is_ok());
            reader.error(match (other, unknown.nearest) {
                (Some(other), _) => error.with_remedy(format!("\"{name}\" is a measured {other}")),
                (None, Some(near)) => error.with_remedy(format!("did you mean \"{near}\"?")),
                (None, None) => {
                    error.with_remedy(format!("there are {}", hints::listing(&catalogue::names(kind))))
                }
            });
            None
        }
    }
}

/// A `<spectrum type="...">` or `<texture type="...">` as such, whatever it is used for.
pub(in crate::scene) fn plugin(reader: &Reader, id: ObjectId) -> Option<SpectrumSource> {
    if let Some(known) = reader.spectra.borrow().get(&id) {
        return known.clone();
    }
    let object = reader.tree.get(id);
    let result = if !plugins::textures::NAMES.contains(&object.plugin.as_str()) {
        reader.unknown_plugin(object);
        None
    } else if plugins::textures::FORMULAS.contains(&object.plugin.as_str()) {
        reader.error(SceneError::at(
            &object.plugin_place,
            format!("\"{}\" is a formula of refractive index", object.plugin),
            "expected a spectrum of other values; this one fits int_ior and ext_ior",
        ));
        None
    } else {
        let query = Query::new(reader, id);
        let kind = plugins::textures::spectrum(&query);
        query.finish();
        kind.map(|(kind, scale)| SpectrumSource { place: object.place.clone(), kind, scale })
    };
    reader.spectra.borrow_mut().insert(id, result.clone());
    result
}

/// Numbers in a string, separated by commas or blanks.
pub(in crate::scene) fn numbers(query: &Query<'_>, name: &'static str) -> Option<Vec<f64>> {
    let text = query.text(name)?;
    let separates = |c: char| c == ',' || c.is_whitespace();
    let mut numbers = Vec::new();
    for word in text.split(separates).filter(|word| !word.is_empty()) {
        match super::attributes::number(word) {
            Some(number) => numbers.push(number),
            None => {
                let problem = format!("\"{word}\" is not a number");
                query.error(SceneError::at(
                    &query.place(name),
                    problem,
                    "expected finite numbers separated by commas or blanks",
                ));
                return None;
            }
        }
    }
    Some(numbers)
}

pub(in crate::scene) fn all_zero(place: &Place) -> SceneError {
    SceneError::at(place, "The spectrum is 0 everywhere", "expected at least one value other than 0")
        .with_remedy("for a constant 0 write <spectrum ... value=\"0\"/>")
}
