//! Scenes as JSON in the shape of Mitsuba 3's dictionaries, as `abbe info --json` writes them, into the same
//! [`Tree`] as XML.
//!
//! An object has a `type`, and everything else by name. Objects directly in the scene are known by their
//! keys. Beside plugins a type may be `spectrum`, `rgb`, `ref`, `transform` or `animation`.

mod text;

use super::super::source::{Place, SceneError, Sources};
use super::attributes::{Attribute, Defaults};
use super::files::Search;
use super::parsed::Parsed;
use super::spd;
use super::tree::{Class, DEEPEST, Entry, Keyframe, Object, ObjectId, Tree, Value};
use super::{hints, names};
use crate::geometry::Vec3;
use glam::{DMat4, DVec4};
use text::{Kind, Member, Node};

/// What may stand beside the scene: notes that say nothing new.
const BESIDE: [&str; 6] = ["extensions", "assumptions", "remarks", "used", "skipped", "hash"];

/// Whether a text is meant to be JSON rather than XML.
pub(super) fn is_json(text: &str) -> bool {
    text.trim_start().starts_with('{')
}

/// Reads the text of `file`. Files that it names are sought in `search`.
pub(super) fn parse(
    text: &str,
    file: usize,
    search: Search,
    defines: &[(String, String)],
    sources: &mut Sources,
) -> Parsed {
    let mut parsed = Parsed::new(search);
    parsed.tree.is_json = true;
    match text::parse(text, file) {
        Ok(node) => {
            let mut builder = Builder { file, sources, parsed: &mut parsed };
            builder.root(&node);
        }
        Err(error) => parsed.errors.push(error),
    }
    if parsed.errors.is_empty() {
        parsed.errors.extend(Defaults::new(defines).unused());
    }
    parsed.tree.resolve(&mut parsed.errors);
    parsed
}

struct Builder<'a> {
    file: usize,
    sources: &'a mut Sources,
    parsed: &'a mut Parsed,
}

impl Builder<'_> {
    fn place(&self, span: std::ops::Range<usize>) -> Place {
        Place { file: self.file, span }
    }

    fn error(&mut self, error: SceneError) {
        self.parsed.errors.push(error);
    }

    fn root(&mut self, node: &Node) {
        let Kind::Object(members) = &node.kind else {
            self.not_a_scene(node);
            return;
        };
        let is_scene = members.iter().any(|member| member.key == "type");
        let Some(scene) = members.iter().find(|member| member.key == "scene").filter(|_| !is_scene) else {
            self.scene(node, members);
            return;
        };
        for member in members.iter().filter(|member| member.key != "scene") {
            if BESIDE.contains(&member.key.as_str()) {
                continue;
            }
            let place = self.place(member.key_span.clone());
            let error = SceneError::at(
                &place,
                format!("\"{}\" means nothing beside the scene", member.key),
                "expected it within \"scene\"",
            );
            self.error(error);
        }
        match &scene.value.kind {
            Kind::Object(members) => self.scene(&scene.value, members),
            _ => self.not_a_scene(&scene.value),
        }
    }

    fn not_a_scene(&mut self, node: &Node) {
        let end = node.span.end.min(node.span.start + 1).max(node.span.start);
        let problem = format!("The file describes {}, not a scene", node.word());
        let expected = "expected {\"type\": \"scene\", ...}";
        self.error(SceneError::at(&self.place(node.span.start..end), problem, expected));
    }

    fn scene(&mut self, node: &Node, members: &[Member]) {
        let Some((plugin, plugin_place, place)) = self.type_of(node, members) else { return };
        if plugin != "scene" {
            let problem = format!("The file describes \"{plugin}\", not a scene");
            self.error(SceneError::at(&plugin_place, problem, "expected \"scene\""));
            return;
        }
        let root = Object { class: Class::Scene, plugin, plugin_place, id: None, place, entries: Vec::new() };
        self.parsed.tree.objects.push(root);
        self.entries(members, Tree::ROOT, 1);
    }

    /// The `type` of an object, its place, and what stands for the object in messages.
    fn type_of(&mut self, node: &Node, members: &[Member]) -> Option<(String, Place, Place)> {
        let start = node.span.start..node.span.start + 1;
        let Some(member) = members.iter().find(|member| member.key == "type") else {
            let problem = "The object has no \"type\"";
            let error = SceneError::at(&self.place(start), problem, "expected \"type\": \"...\" in here");
            self.error(
                error.with_remedy(
                    "a scene is {\"type\": \"scene\", ...}, a sphere {\"type\": \"sphere\", ...}",
                ),
            );
            return None;
        };
        let value_place = self.place(member.value.span.clone());
        match &member.value.kind {
            Kind::Text(plugin) => Some((plugin.clone(), value_place, self.place(member.span()))),
            _ => {
                let problem = format!("The type is {}", member.value.word());
                self.error(SceneError::at(&value_place, problem, "expected the name of a plugin"));
                None
            }
        }
    }

    fn entries(&mut self, members: &[Member], owner: ObjectId, depth: usize) {
        for (index, member) in members.iter().enumerate() {
            if members[..index].iter().any(|earlier| earlier.key == member.key) {
                let place = self.place(member.key_span.clone());
                let problem = format!("\"{}\" is given twice", member.key);
                self.error(SceneError::at(&place, problem, "expected each name once in an object"));
                continue;
            }
            if matches!(member.key.as_str(), "type" | "id") {
                continue;
            }
            let entry = self.entry(member, owner, depth);
            self.parsed.tree.objects[owner.0].entries.push(entry);
        }
    }

    fn entry(&mut self, member: &Member, owner: ObjectId, depth: usize) -> Entry {
        let in_scene = owner == Tree::ROOT;
        let value = self.value(member, in_scene.then_some(member.key.as_str()), depth);
        let (place, value_place) = match value {
            Value::Object(id) => {
                let place = self.parsed.tree.get(id).place.clone();
                (place.clone(), place)
            }
            Value::Reference(_) => (self.place(member.span()), self.place(id_span(&member.value))),
            _ => (self.place(member.span()), self.place(member.value.span.clone())),
        };
        let is_object = matches!(value, Value::Object(_) | Value::Reference(_));
        Entry {
            // Directly in the scene, the key is the object's id.
            name: (!(in_scene && is_object)).then(|| member.key.clone()),
            name_place: self.place(member.key_span.clone()),
            place,
            value_place,
            value,
        }
    }

    /// `key` is the id of an object directly in the scene.
    fn value(&mut self, member: &Member, key: Option<&str>, depth: usize) -> Value {
        let node = &member.value;
        let place = self.place(node.span.clone());
        match &node.kind {
            Kind::Boolean(value) => Value::Boolean(*value),
            Kind::Integer(value) => Value::Integer(*value),
            Kind::Float(value) => Value::Float(*value),
            Kind::Text(text) => Value::Text(text.clone()),
            Kind::Array(_) => match node.numbers().as_deref() {
                Some(&[x, y, z]) => Value::Vector(Vec3::new(x, y, z)),
                _ => {
                    let error = SceneError::at(
                        &place,
                        format!("\"{}\" is an array that means nothing", member.key),
                        "expected 3 numbers, a point or a vector",
                    );
                    self.broken(error.with_remedy("each of several objects has a name of its own"))
                }
            },
            Kind::Null => self.broken(SceneError::at(
                &place,
                format!("\"{}\" has no value", member.key),
                "expected a value, or leave out the name",
            )),
            Kind::Object(members) => self.object(node, members, key, depth).unwrap_or(Value::Broken),
        }
    }

    fn broken(&mut self, error: SceneError) -> Value {
        self.error(error);
        Value::Broken
    }

    fn object(&mut self, node: &Node, members: &[Member], key: Option<&str>, depth: usize) -> Option<Value> {
        let (plugin, plugin_place, place) = self.type_of(node, members)?;
        if depth > DEEPEST {
            let problem = format!("Objects are nested more than {DEEPEST} deep");
            self.error(SceneError::at(&place, problem, "expected a flatter scene"));
            return None;
        }
        match plugin.as_str() {
            "spectrum" => return self.spectrum(members, &place),
            "rgb" => return self.rgb(members, &place),
            "transform" => return self.transform(members, &place).map(Value::Transform),
            "animation" => return self.animation(members),
            "ref" => {
                let [id] = self.only(members, ["id"])?;
                return match &id?.value.kind {
                    Kind::Text(id) => Some(Value::Reference(id.clone())),
                    _ => None,
                };
            }
            _ => {}
        }
        let Some(class) = names::class_of(&plugin, members.iter().map(|member| member.key.as_str())) else {
            self.error(hints::no_such_plugin(&plugin, &plugin_place));
            return None;
        };
        let id = ObjectId(self.parsed.tree.objects.len());
        let name = self.name(members, key, &plugin_place);
        self.parsed.tree.objects.push(Object {
            class,
            plugin,
            plugin_place,
            id: name.as_ref().map(|(name, _)| name.clone()),
            place,
            entries: Vec::new(),
        });
        if let Some((name, place)) = name {
            let known = self.parsed.tree.name(&name, &place, id, self.sources);
            self.parsed.errors.extend(known.err());
        }
        self.entries(members, id, depth + 1);
        Some(Value::Object(id))
    }

    /// The id of an object: given, or its key.
    fn name(&mut self, members: &[Member], key: Option<&str>, place: &Place) -> Option<(String, Place)> {
        let Some(member) = members.iter().find(|member| member.key == "id") else {
            return key.map(|key| (key.to_owned(), place.clone()));
        };
        let place = self.place(member.value.span.clone());
        let Kind::Text(id) = &member.value.kind else {
            self.error(SceneError::at(&place, "The id is no string", "expected \"id\": \"...\""));
            return None;
        };
        Some((id.clone(), place))
    }

    /// The members of these names; others are refused, except `type`.
    fn only<'m, const N: usize>(
        &mut self,
        members: &'m [Member],
        known: [&str; N],
    ) -> Option<[Option<&'m Member>; N]> {
        let before = self.parsed.errors.len();
        for member in members.iter().filter(|member| member.key != "type") {
            if !known.contains(&member.key.as_str()) {
                let place = self.place(member.key_span.clone());
                let problem = format!("\"{}\" means nothing here", member.key);
                self.error(SceneError::at(&place, problem, format!("expected {}", hints::either(&known))));
            }
        }
        let found = known.map(|name| members.iter().find(|member| member.key == name));
        if found.iter().all(Option::is_none) {
            let place = members.iter().find(|member| member.key == "type").map_or(0..0, Member::span);
            let problem = format!(
                "This has no {}",
                hints::either(&known.map(|name| format!("\"{name}\"")).each_ref().map(String::as_str))
            );
            self.error(SceneError::at(&self.place(place), problem, "expected it in here"));
        }
        (self.parsed.errors.len() == before).then_some(found)
    }

    fn spectrum(&mut self, members: &[Member], place: &Place) -> Option<Value> {
        let [value, filename] = self.only(members, ["value", "filename"])?;
        match (value, filename) {
            (Some(value), None) => {
                let place = self.place(value.value.span.clone());
                if let Some(flat) = value.value.number() {
                    return Some(Value::Flat(flat));
                }
                let Kind::Array(items) = &value.value.kind else {
                    self.error(not_a_spectrum(&place));
                    return None;
                };
                let mut pairs = (Vec::new(), Vec::new());
                for item in items {
                    let Some(&[nm, value]) = item.numbers().as_deref() else {
                        self.error(not_a_spectrum(&self.place(item.span.clone())));
                        return None;
                    };
                    pairs.0.push(nm);
                    pairs.1.push(value);
                }
                spd::list(pairs.0, pairs.1, &place).map_err(|error| self.error(error)).ok()
            }
            (None, Some(filename)) => {
                let place = self.place(filename.value.span.clone());
                let Kind::Text(name) = &filename.value.kind else {
                    self.error(SceneError::at(&place, "The filename is no string", "expected \"...\""));
                    return None;
                };
                let attribute = Attribute::new(name.clone(), place);
                let read = spd::file(&attribute, &self.parsed.search, self.sources);
                read.map_err(|error| self.error(error)).ok()
            }
            _ => {
                let problem = "A spectrum needs its values once";
                self.error(SceneError::at(place, problem, "expected either \"value\" or \"filename\""));
                None
            }
        }
    }

    fn rgb(&mut self, members: &[Member], place: &Place) -> Option<Value> {
        let [value] = self.only(members, ["value"])?;
        let node = &value?.value;
        match (node.numbers().as_deref(), node.number()) {
            (Some(&[r, g, b]), _) => Some(Value::Rgb([r, g, b])),
            (_, Some(grey)) => Some(Value::Rgb([grey; 3])),
            _ => {
                self.error(SceneError::at(place, "The colour is not clear", "expected \"value\": [r, g, b]"));
                None
            }
        }
    }

    /// `"keyframes": [[0, {"type": "transform", "matrix": ...}], ...]`.
    fn animation(&mut self, members: &[Member]) -> Option<Value> {
        let [keyframes] = self.only(members, ["keyframes"])?;
        let Kind::Array(items) = &keyframes?.value.kind else {
            self.error(not_keyframes(&self.place(keyframes?.value.span.clone())));
            return None;
        };
        let mut read = Vec::new();
        for item in items {
            let place = self.place(item.span.clone());
            let parts = match &item.kind {
                Kind::Array(parts) => match parts.as_slice() {
                    [time, Node { kind: Kind::Object(members), .. }] => time.number().zip(Some(members)),
                    _ => None,
                },
                _ => None,
            };
            let Some((time, members)) = parts else {
                self.error(not_keyframes(&place));
                return None;
            };
            let to_world = self.transform(members, &place)?;
            read.push(Keyframe { place, time, to_world });
        }
        Some(Value::Animation(read))
    }

    fn transform(&mut self, members: &[Member], place: &Place) -> Option<DMat4> {
        let [matrix] = self.only(members, ["matrix"])?;
        let node = &matrix?.value;
        let rows = match &node.kind {
            Kind::Array(rows) => rows.iter().map(Node::numbers).collect::<Option<Vec<_>>>(),
            _ => None,
        };
        let numbers = rows.filter(|rows| rows.iter().all(|row| row.len() == 4)).map(|rows| rows.concat());
        let Some(numbers) = numbers.and_then(|numbers| <[f64; 16]>::try_from(numbers).ok()) else {
            let expected = "expected 4 rows of 4 numbers, with the translation in the last column";
            self.error(SceneError::at(place, "The matrix of the transform is wrong", expected));
            return None;
        };
        let matrix = DMat4::from_cols_array(&numbers).transpose();
        if matrix.row(3) != DVec4::W {
            let place = self.place(node.span.clone());
            self.error(SceneError::at(
                &place,
                "The matrix is not affine",
                "expected 0, 0, 0, 1 in its last row",
            ));
            return None;
        }
        Some(matrix)
    }
}

/// Where a reference says what it refers to.
fn id_span(node: &Node) -> std::ops::Range<usize> {
    let Kind::Object(members) = &node.kind else { return node.span.clone() };
    let id = members.iter().find(|member| member.key == "id");
    id.map_or_else(|| node.span.clone(), |member| member.value.span.clone())
}

fn not_keyframes(place: &Place) -> SceneError {
    SceneError::at(
        place,
        "These are no keyframes",
        "expected pairs of a time and a transform, such as [[0, {\"type\": \"transform\", \"matrix\": [...]}]]",
    )
}

fn not_a_spectrum(place: &Place) -> SceneError {
    SceneError::at(
        place,
        "This is no spectrum",
        "expected one number, or pairs such as [[400, 0.1], [700, 0.9]]",
    )
}
