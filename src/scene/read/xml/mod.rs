//! From the text of a scene file to a [`Tree`]: elements, attributes, `$name`, numbers, transforms.

mod include;
mod lenient;
mod upgrade;

use super::super::source::{Place, SceneError, Sources};
use super::attributes::{self, Attributes, Defaults, start_tag};
use super::files::Search;
use super::parsed::Parsed;
use super::tree::{Class, DEEPEST, Entry, Keyframe, Object, ObjectId, Tree, Value};
use super::{names, spd, transforms};
use glam::DMat4;
use include::Includes;
use roxmltree::{Document, Node};
use std::path::Path;

/// Reads the text of `file`, which lies at `path`. Files that it names are sought in `search`.
pub(super) fn parse(
    text: &str,
    file: usize,
    path: &Path,
    search: Search,
    defines: &[(String, String)],
    sources: &mut Sources,
) -> Parsed {
    let mut parsed = Parsed::new(search);
    let accepted = lenient::accepted(text);
    let document = match Document::parse(&accepted) {
        Ok(document) => document,
        Err(error) => {
            parsed.errors.push(malformed(&error, text, file));
            return parsed;
        }
    };
    let includes = Includes::of(path);
    let defaults = Defaults::new(defines);
    let mut builder = Builder { file, old: false, includes, defaults, sources, parsed: &mut parsed };
    builder.root(document.root_element());
    let Builder { defaults, .. } = builder;
    if parsed.errors.is_empty() {
        parsed.errors.extend(defaults.unused());
    }
    parsed.tree.resolve(&mut parsed.errors);
    parsed
}

fn malformed(error: &roxmltree::Error, text: &str, file: usize) -> SceneError {
    let position = error.pos();
    let lines_before = position.row.saturating_sub(1) as usize;
    let line_start: usize = text.split_inclusive('\n').take(lines_before).map(str::len).sum();
    let line = text[line_start..].split('\n').next().unwrap_or("");
    let column = line.char_indices().nth(position.col.saturating_sub(1) as usize);
    let start = line_start + column.map_or(line.trim_end().len(), |(offset, _)| offset);
    let end = text[start..].chars().next().map_or(start, |c| start + c.len_utf8());
    let place = Place { file, span: start..end };
    match error {
        roxmltree::Error::DtdDetected => {
            let start = text.find("<!DOCTYPE").unwrap_or(0);
            let place = Place { file, span: start..(start + 9).min(text.len()) };
            SceneError::at(&place, "The file has a document type definition", "expected none")
                .with_remedy("remove <!DOCTYPE ...>: scenes do not need it")
        }
        roxmltree::Error::UnexpectedEndOfStream | roxmltree::Error::UnclosedRootNode => {
            let end = text.trim_end().len();
            let start = text[..end].char_indices().next_back().map_or(0, |(offset, _)| offset);
            SceneError::at(
                &Place { file, span: start..end },
                "The file ends too early",
                "expected the end tag of an open element after this",
            )
            .with_remedy("close every element, and the file with </scene>")
        }
        roxmltree::Error::NoRootNode => {
            SceneError::at(&place, "The file has no element", "expected <scene version=\"3.0.0\">")
        }
        roxmltree::Error::UnexpectedCloseTag(expected, found, _) => SceneError::at(
            &place,
            format!("</{found}> closes an element that is not open"),
            format!("expected </{expected}> first"),
        )
        .with_remedy(format!(
            "close <{expected}> before this place; an element without content ends with />"
        )),
        other => {
            // The crate ends its messages with the position, which is shown anyway.
            let text = other.to_string();
            let text = text.rsplit_once(" at ").map_or(text.as_str(), |(what, _)| what);
            SceneError::at(&place, "The file is not well-formed XML", text)
        }
    }
}

struct Builder<'a> {
    /// The file that is being read, and whether its names are those from before version 2.0.0.
    file: usize,
    old: bool,
    includes: Includes,
    defaults: Defaults,
    sources: &'a mut Sources,
    parsed: &'a mut Parsed,
}

/// What an element is to its parent.
enum Step {
    Entry(Box<Entry>),
    /// No entry, and nothing wrong.
    Nothing,
    /// Wrong in a way that has been said.
    Broken,
}

impl From<Option<Entry>> for Step {
    fn from(entry: Option<Entry>) -> Self {
        entry.map_or(Self::Broken, |entry| Self::Entry(Box::new(entry)))
    }
}

impl Builder<'_> {
    fn root(&mut self, node: Node<'_, '_>) {
        let place = start_tag(node, self.file);
        if node.tag_name().name() != "scene" {
            self.error(SceneError::at(
                &place,
                format!("The file describes <{}>, not a scene", node.tag_name().name()),
                "expected <scene version=\"3.0.0\"> as the outermost element",
            ));
            return;
        }
        let root = Object {
            class: Class::Scene,
            plugin: "scene".to_owned(),
            plugin_place: place.clone(),
            id: None,
            place,
            entries: Vec::new(),
        };
        self.parsed.tree.objects.push(root);
        self.root_attributes(node);
        self.entries(node, Tree::ROOT, 1, false);
    }

    /// The attributes of an outermost `<scene>`. Whether all is well with them.
    fn root_attributes(&mut self, node: Node<'_, '_>) -> bool {
        let before = self.parsed.errors.len();
        self.old = false;
        if node.namespaces().len() > 0 {
            self.error(SceneError::at(
                &start_tag(node, self.file),
                "The file has an XML namespace",
                "expected no xmlns: scenes do not need it",
            ));
        }
        if let Some(attributes) = self.attributes(node, &["version"], &["type", "id", "name"]) {
            self.version(&attributes);
        }
        self.parsed.errors.len() == before
    }

    fn version(&mut self, attributes: &Attributes) {
        if let Some(version) = attributes.get("version") {
            match upgrade::is_old(version) {
                Ok(old) => self.old = old,
                Err(error) => self.error(error),
            }
        }
    }

    /// What stands in `node` becomes entries of `owner`. `included` where the two stand in different files.
    fn entries(&mut self, node: Node<'_, '_>, owner: ObjectId, depth: usize, included: bool) {
        for child in node.children() {
            if child.is_text() {
                self.refuse_text(child);
            }
            if child.is_element() {
                self.add(child, owner, depth, included);
            }
        }
    }

    /// Adds what `node` is to the entries of `owner`.
    fn add(&mut self, node: Node<'_, '_>, owner: ObjectId, depth: usize, included: bool) {
        let entry = match self.entry(node, owner, depth) {
            Step::Entry(entry) => *entry,
            Step::Nothing => return,
            Step::Broken => self.broken(node),
        };
        if included && !matches!(entry.value, Value::Object(_) | Value::Reference(_) | Value::Broken) {
            self.error(
                SceneError::at(
                    &entry.place,
                    "A property outside of objects would be lost",
                    "expected objects only in an included file",
                )
                .with_remedy("put it into the object that it belongs to"),
            );
            return;
        }
        let entries = &self.parsed.tree.get(owner).entries;
        if let Some(name) = &entry.name
            && entries.iter().any(|earlier| earlier.name.as_ref() == Some(name))
        {
            let problem = format!("\"{name}\" is given twice");
            self.error(SceneError::at(&entry.name_place, problem, "expected each name once in an object"));
            return;
        }
        self.parsed.tree.objects[owner.0].entries.push(entry);
    }

    /// What stands for an entry that could not be read, so that nobody complains about its absence as well.
    fn broken(&self, node: Node<'_, '_>) -> Entry {
        let place = start_tag(node, self.file);
        Entry {
            name: node.attribute("name").map(|name| self.name(name)),
            name_place: place.clone(),
            value_place: place.clone(),
            place,
            value: Value::Broken,
        }
    }

    /// The name of a property as Mitsuba 3 calls it.
    fn name(&self, name: &str) -> String {
        if self.old { upgrade::snake_case(name) } else { name.to_owned() }
    }

    fn refuse_text(&mut self, node: Node<'_, '_>) {
        let range = node.range();
        let text = self.source(node, range.clone());
        let trimmed = text.trim();
        if trimmed.is_empty() {
            return;
        }
        let start = range.start + (text.len() - text.trim_start().len());
        let line = trimmed.lines().next().map_or(0, |line| line.trim_end().len());
        let place = Place { file: self.file, span: start..start + line };
        self.error(
            SceneError::at(&place, "Text between elements means nothing", "expected elements only")
                .with_remedy("put remarks into <!-- ... -->"),
        );
    }

    fn source<'d>(&self, node: Node<'d, '_>, range: std::ops::Range<usize>) -> &'d str {
        node.document().input_text().get(range).unwrap_or("")
    }

    fn entry(&mut self, node: Node<'_, '_>, owner: ObjectId, depth: usize) -> Step {
        if depth > DEEPEST {
            self.error(SceneError::at(
                &start_tag(node, self.file),
                format!("Elements are nested more than {DEEPEST} deep"),
                "expected a flatter scene",
            ));
            return Step::Broken;
        }
        match node.tag_name().name() {
            "default" => {
                if let Some(attributes) = self.attributes(node, &["name", "value"], &[]) {
                    self.no_children(node);
                    let name = attributes.text("name").unwrap_or_default();
                    self.defaults.set(&name, attributes.text("value").unwrap_or_default());
                }
                Step::Nothing
            }
            "include" => self.include(node, owner, depth),
            "alias" => self.alias(node),
            "path" => self.path(node, owner),
            _ => self.property_or_object(node, depth).into(),
        }
    }

    /// `<alias id="a" as="b"/>`: another name for an object that stands before it.
    fn alias(&mut self, node: Node<'_, '_>) -> Step {
        let Some(attributes) = self.attributes(node, &["id", "as"], &[]) else { return Step::Broken };
        self.no_children(node);
        let (Some(id), Some(alias)) = (attributes.get("id"), attributes.get("as")) else {
            return Step::Broken;
        };
        let tree = &mut self.parsed.tree;
        let named = match tree.ids.get(&id.text) {
            Some(&object) => tree.name(&alias.text, &alias.place, object, self.sources),
            None => {
                let error = super::tree::dangling(&id.text, &id.place, tree.ids.keys());
                Err(SceneError { expected: "expected the id of an object above".to_owned(), ..error })
            }
        };
        named.map_or_else(
            |error| {
                self.error(error);
                Step::Broken
            },
            |()| Step::Nothing,
        )
    }

    /// `<path value="folder"/>`: files are sought in that folder first.
    fn path(&mut self, node: Node<'_, '_>, owner: ObjectId) -> Step {
        let Some(attributes) = self.attributes(node, &["value"], &[]) else { return Step::Broken };
        self.no_children(node);
        let Some(value) = attributes.get("value") else { return Step::Broken };
        if owner != Tree::ROOT {
            let place = start_tag(node, self.file);
            let problem = "<path> stands within an object";
            self.error(SceneError::at(&place, problem, "expected it directly in the <scene>"));
            return Step::Broken;
        }
        if self.parsed.search.is_full() {
            let problem = "The scene has too many folders to seek files in";
            self.error(SceneError::at(&value.place, problem, "expected fewer <path>"));
            return Step::Broken;
        }
        let folder = self.parsed.search.find(&value.text);
        if !folder.is_dir() {
            let problem = format!("There is no folder {}", folder.display());
            let expected = "expected the path of a folder, relative to the scene file's folder";
            self.error(SceneError::at(&value.place, problem, expected));
            return Step::Broken;
        }
        self.parsed.search = self.parsed.search.after(&folder);
        Step::Nothing
    }

    /// `None` for an element that is wrong in a way that has been said.
    fn property_or_object(&mut self, node: Node<'_, '_>, depth: usize) -> Option<Entry> {
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
        self.error(match names::nearest(tag, &known) {
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

    fn object(&mut self, node: Node<'_, '_>, class: Class, depth: usize) -> Option<Entry> {
        let place = start_tag(node, self.file);
        // The outermost object of an included file has a version as well.
        let outermost = node.parent_element().is_none();
        let optional: &[&str] = if outermost { &["id", "name", "version"] } else { &["id", "name"] };
        let attributes = self.attributes(node, &["type"], optional)?;
        if outermost {
            self.version(&attributes);
        }
        let plugin = attributes.get("type")?;
        let id = ObjectId(self.parsed.tree.objects.len());
        self.parsed.tree.objects.push(Object {
            class,
            plugin: plugin.text.clone(),
            plugin_place: plugin.place.clone(),
            id: attributes.text("id"),
            place: place.clone(),
            entries: Vec::new(),
        });
        if let Some(name) = attributes.get("id") {
            let named = self.parsed.tree.name(&name.text, &name.place, id, self.sources);
            self.parsed.errors.extend(named.err());
        }
        self.entries(node, id, depth + 1, false);
        if self.old
            && let Err(error) = upgrade::properties(&mut self.parsed.tree.objects[id.0])
        {
            self.error(error);
        }
        Some(self.entry_of(node, &attributes, place, Value::Object(id)))
    }

    fn entry_of(
        &self,
        node: Node<'_, '_>,
        attributes: &Attributes,
        value_place: Place,
        value: Value,
    ) -> Entry {
        let place = start_tag(node, self.file);
        let name = attributes.get("name");
        Entry {
            name: name.map(|name| self.name(&name.text)),
            name_place: name.map_or_else(|| place.clone(), |name| name.place.clone()),
            place,
            value_place,
            value,
        }
    }

    fn no_children(&mut self, node: Node<'_, '_>) {
        let Some(child) = node.children().find(Node::is_element) else {
            for child in node.children().filter(Node::is_text) {
                self.refuse_text(child);
            }
            return;
        };
        let place = start_tag(child, self.file);
        let problem = format!("<{}> stands within a property", child.tag_name().name());
        let expected = format!("expected nothing inside <{}>", node.tag_name().name());
        self.error(SceneError::at(&place, problem, expected).with_remedy(format!(
            "close the property with />, or </{}>, before this place",
            node.tag_name().name()
        )));
    }

    fn attributes(&mut self, node: Node<'_, '_>, required: &[&str], optional: &[&str]) -> Option<Attributes> {
        Attributes::read(node, self.file, required, optional, &mut self.defaults, &mut self.parsed.errors)
    }

    fn or_broken(&mut self, value: Result<Value, SceneError>) -> Value {
        value.unwrap_or_else(|error| {
            self.error(error);
            Value::Broken
        })
    }

    fn error(&mut self, error: SceneError) {
        self.parsed.errors.push(error);
    }
}
