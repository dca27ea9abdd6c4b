//! Colours, what daylight shines on, and numbers that are no colours.

use super::super::{Field, Parameter, Takes};
use crate::scene::description::{SpectrumKind, SpectrumSource};
use crate::scene::read::{Class, Query, Value, spectra};
use crate::scene::write::{self, Node, Writer};
use std::sync::Arc;

/// What D65 shines on.
#[derive(Clone)]
pub enum Lit {
    Nothing,
    Colour([f64; 3]),
    Texture(Arc<SpectrumSource>),
}

/// Linear values for the primaries of sRGB.
pub struct Colour(pub &'static str);

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
pub struct Shone;

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
            Lit::Texture(nested) => node.child(super::node(nested, writer)),
        }
    }
}

/// One number, or three that are no colour.
pub struct Raw;

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
