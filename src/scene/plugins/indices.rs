//! Refractive indices of dielectrics: a number, one of Mitsuba 3's names, or (extensions) a function of
//! wavelength.

use super::{Field, Parameter, Takes};
use crate::scene::description::{IndexKind, IndexSource, SpectrumKind, SpectrumSource};
use crate::scene::read::spectra::{self, Use};
use crate::scene::read::{Class, ObjectId, Query, Reader, Value, attributes, hints, textures};
use crate::scene::source::{Place, SceneError};
use crate::scene::write::{self, Node, Writer};
use crate::spectrum::DispersionFormula;
use crate::spectrum::catalogue::Kind;
use std::rc::Rc;

/// The index of Mitsuba 3's default for `int_ior`, `bk7`.
const BK7: f64 = 1.5046;

/// The names that Mitsuba 3 has for single numbers. Source: measured from Mitsuba 3.9.1, with `ext_ior` 1.
const NUMBERS: [(&str, f64); 23] = [
    ("vacuum", 1.0),
    ("helium", 1.000_036),
    ("hydrogen", 1.000_132),
    ("air", 1.000_277),
    ("carbon dioxide", 1.000_45),
    ("water", 1.333),
    ("acetone", 1.36),
    ("ethanol", 1.361),
    ("carbon tetrachloride", 1.461),
    ("glycerol", 1.4729),
    ("benzene", 1.501),
    ("silicone oil", 1.520_45),
    ("bromine", 1.661),
    ("water ice", 1.31),
    ("fused quartz", 1.458),
    ("pyrex", 1.47),
    ("acrylic glass", 1.49),
    ("polypropylene", 1.49),
    ("bk7", BK7),
    ("sodium chloride", 1.544),
    ("amber", 1.55),
    ("pet", 1.575),
    ("diamond", 2.419),
];

fn parameter(name: &'static str, default: &str, doc: &'static str) -> Parameter {
    Parameter { default: default.to_owned(), doc, ..Parameter::new(name, Takes::Index) }
}

fn constant(place: &Place, value: f64) -> IndexSource {
    IndexSource { place: place.clone(), kind: IndexKind::Constant(value) }
}

fn write(node: Node, name: &'static str, index: &IndexSource, writer: &mut Writer) -> Node {
    let object = |node| write::Value::Object(Rc::new(node));
    let value = match &index.kind {
        IndexKind::Constant(value) => write::Value::Float(*value),
        IndexKind::Named(material) => object(super::textures::measured_node(&index.place, material, writer)),
        IndexKind::Formula(formula) => object(super::textures::formula_node(&index.place, formula, writer)),
        IndexKind::Tabulated(table) => write::spectra::write(table),
        IndexKind::NormalReflectance { reflectance, slab } => {
            let node = node.spectrum("normal_reflectance", reflectance);
            return if *slab { node.text("specimen", "slab") } else { node };
        }
    };
    node.property(Some(name.into()), value, Some(index.place.clone()))
}

/// An index that has a default.
pub struct Index {
    pub name: &'static str,
    pub default: f64,
    /// Mitsuba 3's name for the default.
    pub default_name: &'static str,
    pub doc: &'static str,
}

impl Field for Index {
    type Value = IndexSource;

    fn parameters(&self) -> Vec<Parameter> {
        vec![parameter(self.name, self.default_name, self.doc)]
    }

    fn read(&self, query: &Query<'_>) -> Option<IndexSource> {
        Some(read(query, self.name).unwrap_or_else(|| constant(&query.object.place, self.default)))
    }

    fn write(&self, node: Node, index: &IndexSource, writer: &mut Writer) -> Node {
        write(node, self.name, index, writer)
    }
}

/// `int_ior`, or `normal_reflectance` instead.
pub struct Interior;

impl Field for Interior {
    type Value = IndexSource;

    fn parameters(&self) -> Vec<Parameter> {
        let normal = Parameter::new("normal_reflectance", Takes::Spectrum(Use::NormalReflectance));
        let specimen = Parameter::new("specimen", Takes::Choice(vec!["face", "slab"]));
        let assume = Parameter::new("assume", Takes::Choice(vec!["k=0"]));
        let extension = |parameter: Parameter, default: &str, doc| Parameter {
            default: default.to_owned(),
            doc,
            is_extension: true,
            ..parameter
        };
        vec![
            parameter("int_ior", "bk7", "index of the body"),
            extension(normal, "", "instead of `int_ior`, the reflectance at normal incidence"),
            extension(specimen, "face", "whether that was measured on one face or on a clear slab with two"),
            extension(assume, "k=0", "what closes the gap that `normal_reflectance` leaves"),
        ]
    }

    fn read(&self, query: &Query<'_>) -> Option<IndexSource> {
        Some(interior(query))
    }

    fn write(&self, node: Node, index: &IndexSource, writer: &mut Writer) -> Node {
        write(node, "int_ior", index, writer)
    }
}

/// `ext_ior`, with what is meant where it is left out.
pub struct Exterior(&'static str);

impl Exterior {
    pub const SURROUNDINGS: Self = Self("outside is whatever surrounds it, air outside everything");
    pub const AIR: Self = Self("outside is air");
}

impl Field for Exterior {
    type Value = Option<IndexSource>;

    fn parameters(&self) -> Vec<Parameter> {
        vec![parameter("ext_ior", "", "index outside; without it, that of the surroundings, or air")]
    }

    fn read(&self, query: &Query<'_>) -> Option<Option<IndexSource>> {
        Some(read(query, "ext_ior"))
    }

    fn write(&self, node: Node, index: &Option<IndexSource>, writer: &mut Writer) -> Node {
        match index {
            Some(index) => write(node, "ext_ior", index, writer),
            None => node.remark(self.0),
        }
    }
}

/// The index that the property `name` gives; `None` where it is absent or wrong.
fn read(query: &Query<'_>, name: &'static str) -> Option<IndexSource> {
    let entry = query.entry(name)?;
    let place = entry.value_place.clone();
    let constant = |value: f64| positive(query, &place, name, value).then_some(IndexKind::Constant(value));
    let kind = match &entry.value {
        Value::Float(value) => constant(*value),
        Value::Integer(value) => constant(*value as f64),
        Value::Text(text) => named_number(query, &place, name, text),
        Value::Flat(value) => {
            extend(query, &place, name, "a spectrum of one value");
            constant(*value)
        }
        Value::List { file, .. } => {
            let what = match file {
                Some(file) => format!("a table over wavelength from {}", file.display()),
                None => "a table over wavelength".to_owned(),
            };
            extend(query, &place, name, &what);
            let table = spectra::read(query, name, Use::Index)?;
            query.reader.held(name, &table);
            Some(IndexKind::Tabulated(table))
        }
        Value::Object(id) if query.reader.tree.get(*id).class == Class::Spectrum => {
            of_plugin(query, name, *id, &place)
        }
        _ => {
            query.error(query.wrong_type(
                entry,
                name,
                "<float>, <string> with a material's name, or <spectrum>",
            ));
            None
        }
    };
    kind.map(|kind| IndexSource { place, kind })
}

fn positive(query: &Query<'_>, place: &Place, name: &str, value: f64) -> bool {
    if value > 0.0 {
        return true;
    }
    query.error(
        SceneError::at(
            place,
            format!("The refractive index \"{name}\" is {value}"),
            "expected a number above 0",
        )
        .with_remedy("the index of vacuum is 1, that of glass about 1.5"),
    );
    false
}

fn named_number(query: &Query<'_>, place: &Place, name: &str, text: &str) -> Option<IndexKind> {
    if let Some((_, value)) = NUMBERS.iter().find(|(known, _)| known.eq_ignore_ascii_case(text)) {
        return Some(IndexKind::Constant(*value));
    }
    let known: Vec<&str> = NUMBERS.iter().map(|(known, _)| *known).collect();
    let problem = format!("\"{text}\" is not a material with a known single index");
    let error =
        SceneError::at(place, problem, "expected one of the names that Mitsuba 3 has, such as bk7 or water");
    query.error(if attributes::number(text).is_some() {
        error.with_remedy(format!("for a number write <float name=\"{name}\" value=\"{text}\"/>"))
    } else if let Some(near) = hints::nearest(text, &known) {
        error.with_remedy(format!("did you mean \"{near}\"?"))
    } else {
        error.with_remedy(format!(
            "a glass with its dispersion is written <spectrum name=\"{name}\" type=\"measured\"><string name=\"name\" value=\"N-SF11\"/></spectrum>"
        ))
    });
    None
}

fn extend(query: &Query<'_>, place: &Place, name: &str, what: &str) {
    query.reader.extension(place, format!("{name} is {what}; Mitsuba 3 takes a number or a name only"));
}

fn of_plugin(query: &Query<'_>, name: &'static str, id: ObjectId, place: &Place) -> Option<IndexKind> {
    let reader = query.reader;
    let object = reader.tree.get(id);
    match object.plugin.as_str() {
        "measured" => {
            let inner = Query::new(reader, id);
            let material = super::textures::Known.read(&inner);
            inner.finish();
            let material = material?;
            spectra::lookup(reader, place, Kind::Dielectric, &material)?;
            Some(IndexKind::Named(material))
        }
        "sellmeier" | "cauchy" => {
            extend(query, place, name, &format!("a {} formula", object.plugin));
            formula(reader, id).map(IndexKind::Formula)
        }
        "uniform" | "regular" | "irregular" => {
            extend(query, place, name, "a function of wavelength");
            let source = spectra::read(query, name, Use::Index)?;
            Some(match source.kind {
                SpectrumKind::Constant(value) => IndexKind::Constant(value * source.scale),
                _ => {
                    reader.held(name, &source);
                    IndexKind::Tabulated(source)
                }
            })
        }
        "d65" | "blackbody" => {
            let problem = format!("\"{}\" is the spectrum of a light, not a refractive index", object.plugin);
            query.error(SceneError::at(
                &object.plugin_place,
                problem,
                "expected a table, measured, sellmeier or cauchy",
            ));
            None
        }
        _ => {
            reader.unknown_plugin(object);
            None
        }
    }
}

/// The formula of a plugin.
fn formula(reader: &Reader, id: ObjectId) -> Option<DispersionFormula> {
    let query = Query::new(reader, id);
    let formula = super::textures::index(&query)?;
    query.finish();
    Some(formula)
}

/// `normal_reflectance` beside or instead of `int_ior`.
fn interior(query: &Query<'_>) -> IndexSource {
    let given = read(query, "int_ior");
    let reflectance = normal_reflectance(query);
    let slab = query.has("normal_reflectance") && specimen(query);
    if given.is_some()
        && let Some(reflectance) = &reflectance
    {
        query.error(SceneError::at(
            &reflectance.place,
            "The index is given twice",
            "expected either int_ior or normal_reflectance",
        ));
    }
    if let Some(reflectance) = reflectance {
        if textures::varies(&reflectance) {
            query.error(
                SceneError::at(
                    &reflectance.place,
                    "The index of a body cannot vary over its surface",
                    "expected a normal_reflectance that is the same everywhere",
                )
                .with_remedy(
                    "a conductor's can vary; here specular_reflectance can, which weighs what is reflected",
                ),
            );
        }
        if let Some(assume) = query.text("assume")
            && assume != "k=0"
        {
            query.error(SceneError::at(
                &query.place("assume"),
                format!("\"{assume}\" is no assumption about a dielectric"),
                "expected k=0, which is the default",
            ));
        }
        let text = if slab {
            "normal_reflectance is that of both faces of a polished, clear slab in vacuum, and k = 0: of one face F = R / (2 − R), n = (1 + √F) / (1 − √F)"
        } else {
            "normal_reflectance is that of one polished face in vacuum, and k = 0: n = (1 + √R) / (1 − √R)"
        };
        query.reader.assumption(&reflectance.place, text.to_owned());
        query.reader.held("normal_reflectance", &reflectance);
        let place = reflectance.place.clone();
        return IndexSource { place, kind: IndexKind::NormalReflectance { reflectance, slab } };
    }
    given.unwrap_or_else(|| constant(&query.object.place, BK7))
}

/// What the reflectance of a dielectric was measured on: whether it is a slab, of which the back face
/// reflects too.
fn specimen(query: &Query<'_>) -> bool {
    query.choice("specimen", &[("face", false), ("slab", true)], false).unwrap_or(false)
}

/// The reflectance from which an index follows, with the note that it is an extension.
pub fn normal_reflectance(query: &Query<'_>) -> Option<SpectrumSource> {
    let reflectance = spectra::read(query, "normal_reflectance", Use::NormalReflectance)?;
    query.reader.extension(
        &reflectance.place,
        "normal_reflectance: the index follows from the reflectance at normal incidence".to_owned(),
    );
    Some(reflectance)
}
