//! Elements that are properties of the object that they stand in.

use super::super::super::source::{Place, SceneError};
use super::super::attributes::{self, start_tag};
use super::super::tree::{Class, Entry, Keyframe, Value};
use super::super::{hints, spd, transforms};
use super::Builder;
use glam::DMat4;
use roxmltree::Node;

impl Builder<'_> {
    /// `None` for an element that is wrong in a way that has been said.
    pub(super) fn property_or_object(&mut self, node: Node<'_, '_>, depth: usize) -> Option<Entry> {
        let place = start_tag(node, self.file);
        let tag = node.tag_name().name();
        match tag {
            "scene" => {
                self.error(SceneError::at(
                    &place,
                    "A scene within a scene",
                    "expected <scene> outermost only",
                ));
                None
            }
            "ref" => {
                let attributes = self.attributes(node, &["id"], &["name"])?;
                self.no_children(node);
                let id = attributes.get("id")?;
                Some(self.entry_of(node, &attributes, id.place.clone(), Value::Reference(id.text.clone())))
            }
            "boolean" | "integer" | "float" | "string" => {
                let attributes = self.attributes(node, &["name", "value"], &[])?;
                self.no_children(node);
                let value = attributes.get("value")?;
                let read = match tag {
                    "boolean" => attributes::boolean(value).map(Value::Boolean),
                    "integer" => attributes::integer(value).map(Value::Integer),
                    "float" => attributes::float(value).map(Value::Float),
                    _ => Ok(Value::Text(value.text.clone())),
                };
                let read = self.or_broken(read);
                Some(self.entry_of(node, &attributes, value.place.clone(), read))
            }
            "point" | "vector" => {
                let attributes = self.attributes(node, &["name"], &["x", "y", "z", "value"])?;
                self.no_children(node);
                let read = attributes::vector(&attributes, &place, None).map(Value::Vector);
                let value_place = attributes.get("value").map_or(place, |value| value.place.clone());
                let read = self.or_broken(read);
                Some(self.entry_of(node, &attributes, value_place, read))
            }
            "rgb" => {
                let attributes = self.attributes(node, &["name", "value"], &[])?;
                self.no_children(node);
                let value = attributes.get("value")?;
                let read = attributes::rgb(value).map(Value::Rgb);
                let read = self.or_broken(read);
                Some(self.entry_of(node, &attributes, value.place.clone(), read))
            }
            "transform" => {
                let attributes = self.attributes(node, &["name"], &[])?;
                let value = self.transform(node).map_or(Value::Broken, Value::Transform);
                Some(self.entry_of(node, &attributes, place, value))
            }
            "animation" => {
                let attributes = self.attributes(node, &["name"], &[])?;
                let value = self.animation(node).map_or(Value::Broken, Value::Animation);
                Some(self.entry_of(node, &attributes, place, value))
            }
            "spectrum" if !node.has_attribute("type") => self.spectrum(node),
            _ => match Class::of_element(tag) {
                Some(class) => self.object(node, class, depth),
                None => {
                    self.unknown_element(tag, &place);
                    None
                }
            },
        }
    }

    /// Transforms, each with its time; `None` where one of them is wrong.
    fn animation(&mut self, node: Node<'_, '_>) -> Option<Vec<Keyframe>> {
        let before = self.parsed.errors.len();
        let mut keyframes = Vec::new();
        for child in node.children().filter(Node::is_element) {
            let place = start_tag(child, self.file);
            if child.tag_name().name() != "transform" {
                let problem = format!("<{}> is not part of an animation", child.tag_name().name());
                self.error(SceneError::at(&place, problem, "expected <transform time=\"...\">"));
                continue;
            }
            let Some(attributes) = self.attributes(child, &["time"], &[]) else { continue };
            let time = attributes.get("time").map(attributes::float);
            let to_world = self.transform(child);
            match (time, to_world) {
                (Some(Ok(time)), Some(to_world)) => keyframes.push(Keyframe { place, time, to_world }),
                (Some(Err(error)), _) => self.error(error),
                _ => {}
            }
        }
        (self.parsed.errors.len() == before).then_some(keyframes)
    }

    fn transform(&mut self, node: Node<'_, '_>) -> Option<DMat4> {
        let mut context = transforms::Context {
            file: self.file,
            defaults: &mut self.defaults,
            errors: &mut self.parsed.errors,
            assumptions: &mut self.parsed.assumptions,
        };
        context.read(node)
    }

    fn unknown_element(&mut self, tag: &str, place: &Place) {
        const OTHERS: [&str; 15] = [
            "default",
            "ref",
            "boolean",
            "integer",
            "float",
            "string",
            "point",
            "vector",
            "animation",
            "transform",
            "texture",
            "rgb",
            "include",
            "alias",
            "path",
        ];
        let known: Vec<&str> = Class::ELEMENTS.iter().skip(1).map(|&(word, _)| word).chain(OTHERS).collect();
        let error = SceneError::at(
            place,
            format!("<{tag}> is not a known element"),
            "expected an object or a property",
        );
        self.error(match hints::nearest(tag, &known) {
            Some(near) => error.with_remedy(format!("did you mean <{near}>?")),
            None => error.with_remedy("objects are shape, bsdf, emitter, sensor, integrator and others; properties are float, string, spectrum and others"),
        });
    }

    fn spectrum(&mut self, node: Node<'_, '_>) -> Option<Entry> {
        let attributes = self.attributes(node, &["name"], &["value", "filename"])?;
        self.no_children(node);
        let place = start_tag(node, self.file);
        let (value_place, read) = match (attributes.get("value"), attributes.get("filename")) {
            (Some(value), None) => (value.place.clone(), spd::value(value)),
            (None, Some(filename)) => {
                (filename.place.clone(), spd::file(filename, &self.parsed.search, self.sources))
            }
            _ => {
                let error = SceneError::at(
                    &place,
                    "A spectrum needs its values once",
                    "expected either value=\"...\" or filename=\"...\"",
                )
                .with_remedy("a plugin is named by type: <spectrum type=\"d65\" .../>");
                (place, Err(error))
            }
        };
        let read = self.or_broken(read);
        Some(self.entry_of(node, &attributes, value_place, read))
    }
}
