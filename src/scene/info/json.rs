use super::super::description::{Description, Note};
use super::super::features::Features;
use super::super::write::{self, Node, Value};
use crate::geometry::Transform;
use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};
use std::rc::Rc;

/// The scene as it was understood, in the shape of Mitsuba's dictionaries: nested objects with a `type`,
/// parameters by name, ids as keys. It is a scene file too, and means the same to the last bit.
///
/// Data files are named relative to `folder`, or by their whole path where that is `None`.
pub fn json(description: &Description, features: &Features, folder: Option<&Path>) -> String {
    let folder = folder.map(absolute);
    let mut ids = BTreeSet::new();
    let scene = write::scene(description);
    collect_ids(&scene, &mut ids);
    let mut writer = Writer { folder, ids, written: BTreeSet::new(), text: String::new(), depth: 0 };
    writer.open('{');
    writer.key("scene");
    writer.object(&scene, None);
    let notes = [
        ("extensions", &description.extensions),
        ("assumptions", &description.assumptions),
        ("remarks", &description.remarks),
    ];
    for (title, notes) in notes {
        writer.comma();
        writer.key(title);
        writer.notes(description, notes);
    }
    for (title, names) in [("used", features.used()), ("skipped", features.skipped())] {
        writer.comma();
        writer.key(title);
        let names: Vec<String> = names.iter().map(|name| quoted(name)).collect();
        writer.text.push_str(&format!("[{}]", names.join(", ")));
    }
    writer.comma();
    writer.key("hash");
    writer.text.push_str(&quoted(&format!("{:016x}", description.hash())));
    writer.close('}');
    writer.text.push('\n');
    writer.text
}

fn collect_ids(node: &Node, ids: &mut BTreeSet<String>) {
    // Whoever has the same id is the same object.
    if node.id.as_ref().is_some_and(|id| !ids.insert(id.clone())) {
        return;
    }
    for property in &node.properties {
        if let Value::Object(object) = &property.value {
            collect_ids(object, ids);
        }
    }
}

struct Writer {
    folder: Option<PathBuf>,
    /// All ids of the scene, and keys that were made up: both are names that a reference could mean.
    ids: BTreeSet<String>,
    /// Ids of objects that are written already.
    written: BTreeSet<String>,
    text: String,
    depth: usize,
}

impl Writer {
    fn line(&mut self) {
        self.text.push('\n');
        self.text.push_str(&"  ".repeat(self.depth));
    }

    fn open(&mut self, bracket: char) {
        self.text.push(bracket);
        self.depth += 1;
        self.line();
    }

    fn close(&mut self, bracket: char) {
        self.depth -= 1;
        self.line();
        self.text.push(bracket);
    }

    fn comma(&mut self) {
        self.text.push(',');
        self.line();
    }

    fn key(&mut self, key: &str) {
        self.text.push_str(&quoted(key));
        self.text.push_str(": ");
    }

    /// `key` is what the object stands under.
    fn object(&mut self, node: &Node, key: Option<&str>) {
        if let Some(id) = &node.id {
            if self.written.contains(id) {
                self.text.push_str(&format!("{{\"type\": \"ref\", \"id\": {}}}", quoted(id)));
                return;
            }
            self.written.insert(id.clone());
        }
        self.open('{');
        self.key("type");
        self.text.push_str(&quoted(node.plugin));
        if let Some(id) = node.id.as_ref().filter(|id| Some(id.as_str()) != key) {
            self.comma();
            self.key("id");
            self.text.push_str(&quoted(id));
        }
        let is_scene = key.is_none();
        let mut used: BTreeSet<String> = ["type".to_owned(), "id".to_owned()].into();
        used.extend(
            node.properties.iter().filter_map(|property| property.name.as_deref().map(str::to_owned)),
        );
        for property in &node.properties {
            if is_scene && let Value::Object(object) = &property.value {
                self.groups_of(object, &mut used);
            }
            let key = match (property.name.as_deref(), &property.value) {
                (Some(name), _) => name.to_owned(),
                (None, Value::Object(object)) => self.key_of(object, is_scene, &mut used),
                (None, _) => continue,
            };
            self.comma();
            self.key(&key);
            self.value(&property.value, &key);
        }
        self.close('}');
    }

    /// Writes the shape groups that an instance shows, as far as they are not written already: Mitsuba 3
    /// looks for them in the scene itself.
    fn groups_of(&mut self, instance: &Node, used: &mut BTreeSet<String>) {
        for property in &instance.properties {
            let Value::Object(group) = &property.value else { continue };
            let is_new = group.id.as_ref().is_some_and(|id| !self.written.contains(id));
            if group.plugin == "shapegroup" && is_new {
                let key = self.key_of(group, true, used);
                self.comma();
                self.key(&key);
                self.object(group, Some(&key));
            }
        }
    }

    /// The key of an object without name: its id, or its class, numbered where others have it already.
    fn key_of(&mut self, object: &Rc<Node>, in_scene: bool, used: &mut BTreeSet<String>) -> String {
        if let Some(id) = &object.id
            && in_scene
            // Mitsuba 3 keeps dots for paths of keys.
            && !id.contains('.')
            && !self.written.contains(id)
            && used.insert(id.clone())
        {
            return id.clone();
        }
        let word = object.class.word();
        let mut number = 1;
        loop {
            let key = if number == 1 { word.to_owned() } else { format!("{word}_{number}") };
            number += 1;
            if used.contains(&key) || in_scene && !self.ids.insert(key.clone()) {
                continue;
            }
            used.insert(key.clone());
            return key;
        }
    }

    fn value(&mut self, value: &Value, key: &str) {
        let text = match value {
            Value::Boolean(value) => value.to_string(),
            Value::Integer(value) => value.to_string(),
            Value::Float(value) => number(*value),
            Value::Text(value) => quoted(value),
            Value::Numbers(values) => {
                quoted(&values.iter().map(|&value| number(value)).collect::<Vec<_>>().join(", "))
            }
            Value::Vector(value) => row(&value.to_array()),
            Value::Transform(transform) => matrix(transform),
            Value::Animation(motion) => {
                let key = |(time, to_world): &(f64, Transform)| {
                    format!("[{}, {}]", number(*time), matrix(to_world))
                };
                let keys: Vec<String> = motion.keys.iter().map(key).collect();
                format!("{{\"type\": \"animation\", \"keyframes\": [{}]}}", keys.join(", "))
            }
            Value::Rgb(rgb) => format!("{{\"type\": \"rgb\", \"value\": {}}}", row(rgb)),
            Value::Flat(value) => format!("{{\"type\": \"spectrum\", \"value\": {}}}", number(*value)),
            Value::List { nm, values, .. } => {
                let pairs: Vec<String> =
                    nm.iter().zip(values).map(|(&nm, &value)| row(&[nm, value])).collect();
                format!("{{\"type\": \"spectrum\", \"value\": [{}]}}", pairs.join(", "))
            }
            Value::File { path, .. } => quoted(&self.path(path)),
            Value::Object(object) => {
                self.object(object, Some(key));
                return;
            }
        };
        self.text.push_str(&text);
    }

    /// How a file is named from where the JSON is.
    fn path(&self, path: &Path) -> String {
        let path = absolute(path);
        let Some(folder) = &self.folder else { return path.to_string_lossy().into_owned() };
        let common = path.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
        if !path.components().take(common).any(|part| matches!(part, Component::Normal(_))) {
            return path.to_string_lossy().into_owned();
        }
        let up = std::iter::repeat_n("..".into(), folder.components().count() - common);
        let down = path.components().skip(common).map(|part| part.as_os_str().to_string_lossy().into_owned());
        up.chain(down).collect::<Vec<String>>().join("/")
    }

    fn notes(&mut self, description: &Description, notes: &[Note]) {
        if notes.is_empty() {
            self.text.push_str("[]");
            return;
        }
        self.open('[');
        for (index, note) in notes.iter().enumerate() {
            if index > 0 {
                self.comma();
            }
            let file = quoted(description.sources.name(&note.place));
            let line = description.sources.line(&note.place);
            let text = quoted(&note.text);
            self.text.push_str(&format!("{{\"file\": {file}, \"line\": {line}, \"text\": {text}}}"));
        }
        self.close(']');
    }
}

/// The path from the root, without links and dots as far as it exists.
fn absolute(path: &Path) -> PathBuf {
    path.canonicalize().or_else(|_| std::path::absolute(path)).unwrap_or_else(|_| path.to_owned())
}

/// The shortest text that reads back as the same number.
fn number(number: f64) -> String {
    format!("{number:?}")
}

fn row(numbers: &[f64]) -> String {
    format!("[{}]", numbers.iter().map(|&x| number(x)).collect::<Vec<_>>().join(", "))
}

fn matrix(transform: &Transform) -> String {
    let matrix = transform.matrix();
    let rows: Vec<String> = (0..4).map(|i| row(&matrix.row(i).to_array())).collect();
    format!("{{\"type\": \"transform\", \"matrix\": [{}]}}", rows.join(", "))
}

fn quoted(text: &str) -> String {
    let mut quoted = String::from('"');
    for c in text.chars() {
        match c {
            '"' => quoted.push_str("\\\""),
            '\\' => quoted.push_str("\\\\"),
            c if (c as u32) < 0x20 => quoted.push_str(&format!("\\u{:04x}", c as u32)),
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}
