//! From the text of a scene file to a [`Tree`]: elements, attributes, `$name`, numbers, transforms.

mod commands;
mod include;
mod lenient;
mod malformed;
mod properties;
mod upgrade;

use super::super::source::{Place, SceneError, Sources};
use super::attributes::{Attributes, Defaults, start_tag};
use super::files::Search;
use super::parsed::Parsed;
use super::tree::{Class, DEEPEST, Entry, Object, ObjectId, Tree, Value};
use include::Includes;
use malformed::malformed;
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

    /// Stands for an entry that could not be read, so that its absence is not reported as well.
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
        // Blanks and marks without width, which pages on the web leave in what is copied from them.
        let unseen =
            |c: char| c.is_whitespace() || matches!(c, '\u{200b}'..='\u{200d}' | '\u{2060}' | '\u{feff}');
        let trimmed = text.trim_matches(unseen);
        if trimmed.is_empty() {
            return;
        }
        let start = range.start + (text.len() - text.trim_start_matches(unseen).len());
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
