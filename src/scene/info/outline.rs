use super::super::description::{Description, Note};
use super::super::source::Place;
use super::super::write::{self, Node, Property, Value};
use crate::geometry::{Transform, Vec3};
use std::collections::BTreeSet;
use std::path::Path;
use std::rc::Rc;

/// The scene as it was understood: one line for each object and property, defaults filled in, extensions and
/// assumptions at the end.
pub fn outline(description: &Description) -> String {
    let mut outline = Outline { description, text: String::new(), depth: 0, node: BTreeSet::new() };
    outline.scene(&write::scene(description));
    outline.notes("extensions (Mitsuba 3 would refuse them)", &description.extensions);
    outline.notes("assumptions", &description.assumptions);
    outline.notes("remarks", &description.remarks);
    outline.text
}

struct Outline<'a> {
    description: &'a Description,
    text: String,
    depth: usize,
    /// Named objects that have been written: others that share them refer to them.
    node: BTreeSet<*const Node>,
}

impl Outline<'_> {
    fn line(&mut self, text: &str) {
        self.text.push_str(&"  ".repeat(self.depth));
        self.text.push_str(text);
        self.text.push('\n');
    }

    fn within(&mut self, content: impl FnOnce(&mut Self)) {
        self.depth += 1;
        content(self);
        self.depth -= 1;
    }

    fn scene(&mut self, scene: &Node) {
        self.line("scene");
        self.within(|o| o.content(scene));
    }

    fn content(&mut self, node: &Node) {
        for property in &node.properties {
            self.property(node, property);
        }
        for remark in &node.remarks {
            self.line(&format!("({remark})"));
        }
    }

    fn property(&mut self, owner: &Node, property: &Property) {
        let name = property.name.as_deref().unwrap_or("");
        // A default has its object's place, which says nothing of the default.
        let place = property.place.as_ref().filter(|&place| *place != owner.place);
        let mark = if place.is_some_and(|place| self.is_extension(place)) { " (extension)" } else { "" };
        match &property.value {
            Value::Object(object) => self.object(property.name.as_deref(), object),
            Value::Transform(transform) => self.transform(name, transform),
            Value::Animation(motion) => {
                self.line(&format!("{name}: {} keyframes{mark}", motion.keys.len()));
                self.within(|o| {
                    for (time, to_world) in &motion.keys {
                        o.transform(&format!("at {time}"), to_world);
                    }
                });
            }
            other => self.line(&format!("{name}: {}{mark}", text_of(other))),
        }
    }

    fn object(&mut self, name: Option<&str>, node: &Rc<Node>) {
        let id = node.id.as_ref().map_or(String::new(), |id| format!(" \"{id}\""));
        let mark = if self.is_extension(&node.place) { ", extension" } else { "" };
        let place = self.place(&node.place);
        let role = name.unwrap_or(node.class.word());
        let is_again = node.id.is_some() && !self.node.insert(Rc::as_ptr(node));
        let again = if is_again { ", as above" } else { "" };
        self.line(&format!("{role}: {}{id} ({place}{mark}{again})", node.plugin));
        if is_again {
            return;
        }
        self.within(|o| o.content(node));
    }

    /// The line, and the file where it is not the scene's own.
    fn place(&self, place: &Place) -> String {
        let sources = &self.description.sources;
        let line = sources.line(place);
        if place.file == 0 { format!("line {line}") } else { format!("{}:{line}", sources.name(place)) }
    }

    /// Whether an extension is noted within `place`.
    fn is_extension(&self, place: &Place) -> bool {
        self.description.extensions.iter().any(|note| {
            note.place.file == place.file
                && note.place.span.start >= place.span.start
                && note.place.span.end <= place.span.end
        })
    }

    fn notes(&mut self, title: &str, notes: &[Note]) {
        if notes.is_empty() {
            return;
        }
        self.line(title);
        self.within(|o| {
            for note in notes {
                let place = o.place(&note.place);
                o.line(&format!("{place}: {}", note.text));
            }
        });
    }

    fn transform(&mut self, name: &str, transform: &Transform) {
        let matrix = transform.matrix();
        let offset = matrix.w_axis.truncate();
        if *transform == Transform::translation(offset) {
            self.line(&format!("{name}: moved by {}", vector(offset)));
            return;
        }
        self.line(&format!("{name}:"));
        self.within(|o| {
            for row in 0..3 {
                let row = matrix.row(row).to_array();
                o.line(&row.map(|x| format!("{:>10}", short(x))).join(" "));
            }
        });
    }
}

/// A value in a line; nothing for one that takes several.
pub(in crate::scene) fn text_of(value: &Value) -> String {
    match value {
        Value::Boolean(value) => value.to_string(),
        Value::Integer(value) => value.to_string(),
        Value::Float(value) | Value::Flat(value) => value.to_string(),
        Value::Text(value) => value.clone(),
        Value::Numbers(values) => numbers(values),
        Value::Vector(value) => vector(*value),
        Value::Rgb(rgb) => format!("rgb {}", numbers(rgb)),
        Value::List { nm, values, file } => {
            let ends = (nm.first().copied().unwrap_or(0.0), nm.last().copied().unwrap_or(0.0));
            let file = file.as_ref().map_or(String::new(), |file| format!(", {}", file_name(file)));
            format!("{} values from {} to {} nm{file}", values.len(), ends.0, ends.1)
        }
        Value::File { path, summary, .. } => format!("{}: {summary}", file_name(path)),
        // Node over several lines.
        Value::Transform(_) | Value::Animation(_) | Value::Object(_) => String::new(),
    }
}

/// Numbers in a row, or how many there are.
fn numbers(values: &[f64]) -> String {
    const MOST: usize = 8;
    if values.len() > MOST {
        return format!("{} values", values.len());
    }
    values.iter().map(f64::to_string).collect::<Vec<_>>().join(", ")
}

fn vector(vector: Vec3) -> String {
    format!("({}, {}, {})", short(vector.x), short(vector.y), short(vector.z))
}

/// At most six significant digits, and no minus before a zero.
fn short(number: f64) -> String {
    if number == 0.0 {
        return "0".to_owned();
    }
    let decimals = (5 - number.abs().log10().floor() as i32).clamp(0, 9) as usize;
    let text = format!("{number:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}
