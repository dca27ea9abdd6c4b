//! What textures are made of, and the names of what they take from elsewhere.

use super::super::{Field, Parameter, Takes};
use super::patterns;
use super::{Plugin, volumes};
use crate::scene::description::{SpectrumKind, SpectrumSource};
use crate::scene::read::spectra::{self, Use};
use crate::scene::read::{Class, Query, Value};
use crate::scene::source::SceneError;
use crate::scene::write::{Node, Writer};

/// A part of a texture, with its name, default and documentation.
pub struct TextureColor(pub &'static str, pub f64, pub &'static str);

impl Field for TextureColor {
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
pub struct InSpace;

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

pub fn of_a_mesh(query: &Query<'_>, plugin: Plugin) -> Option<Plugin> {
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

pub fn spread(query: &Query<'_>, plugin: Plugin) -> Option<Plugin> {
    if let Plugin::Procedural(source) = &plugin {
        patterns::ascending(query, source.range);
    }
    Some(plugin)
}
