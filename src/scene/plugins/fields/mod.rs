//! Fields of one parameter: numbers, words, and what else a property can be.

mod kinds;

use super::{Field, Parameter, Takes};
use crate::scene::info::text_of;
use crate::scene::read::Query;
use crate::scene::write::{Node, Value, Writer};
pub use kinds::{
    Boolean, Choices, Float, Integer, Numbers, Text, Vector, boolean, choice, float, integer, numbers, text,
    vector,
};

/// What one property can be, and how it is read and written.
pub trait Kind {
    type Value: Clone;

    fn takes(&self) -> Takes;

    /// `None` where it is absent or wrong, which is reported.
    fn read(&self, query: &Query<'_>, name: &'static str) -> Option<Self::Value>;

    fn value(&self, value: &Self::Value) -> Value;
}

/// A field of one property.
pub struct Simple<K: Kind> {
    name: &'static str,
    doc: &'static str,
    unit: &'static str,
    /// What to note where a file has it and Mitsuba 3 would refuse it.
    extension: Option<&'static str>,
    /// `None` where there is none, and the property has to be there.
    default: Option<K::Value>,
    /// Whether the default is not written.
    is_quiet: bool,
    kind: K,
}

impl<K: Kind> Simple<K> {
    pub const fn new(name: &'static str, default: Option<K::Value>, kind: K, doc: &'static str) -> Self {
        Self { name, doc, unit: "", extension: None, default, is_quiet: false, kind }
    }

    pub const fn unit(mut self, unit: &'static str) -> Self {
        self.unit = unit;
        self
    }

    pub const fn extension(mut self, note: &'static str) -> Self {
        self.extension = Some(note);
        self
    }

    /// Refuses objects without it.
    pub fn required(self) -> Self {
        Self { default: None, ..self }
    }

    /// Leaves the default unwritten.
    pub const fn quiet(mut self) -> Self {
        self.is_quiet = true;
        self
    }

    /// What it is where the file leaves it out.
    pub fn default(&self) -> K::Value
    where
        K::Value: Default,
    {
        self.default.clone().unwrap_or_default()
    }

    fn given(&self, query: &Query<'_>) -> Option<K::Value> {
        if let Some(note) = self.extension
            && query.has(self.name)
        {
            query.reader.extension(&query.place(self.name), format!("{}: {note}", self.name));
        }
        self.kind.read(query, self.name)
    }
}

impl<K: Kind<Value: PartialEq>> Field for Simple<K> {
    type Value = K::Value;

    fn parameters(&self) -> Vec<Parameter> {
        vec![Parameter {
            name: self.name,
            takes: self.kind.takes(),
            default: self.default.as_ref().map_or(String::new(), |value| text_of(&self.kind.value(value))),
            is_required: self.default.is_none(),
            unit: self.unit,
            doc: self.doc,
            is_extension: self.extension.is_some(),
        }]
    }

    fn read(&self, query: &Query<'_>) -> Option<K::Value> {
        match (self.given(query), &self.default) {
            (Some(value), _) => Some(value),
            (None, Some(default)) => Some(default.clone()),
            (None, None) => query.required(self.name, None),
        }
    }

    fn write(&self, node: Node, value: &K::Value, _: &mut Writer) -> Node {
        if self.is_quiet && self.default.as_ref() == Some(value) {
            return node;
        }
        node.with(self.name, self.kind.value(value))
    }
}

/// A property that may be left out.
pub struct Optional<K: Kind>(Simple<K>);

pub fn optional<K: Kind>(field: Simple<K>) -> Optional<K> {
    Optional(field)
}

impl<K: Kind<Value: PartialEq>> Field for Optional<K> {
    type Value = Option<K::Value>;

    fn parameters(&self) -> Vec<Parameter> {
        let all = self.0.parameters().into_iter();
        all.map(|parameter| Parameter { is_required: false, ..parameter }).collect()
    }

    fn read(&self, query: &Query<'_>) -> Option<Option<K::Value>> {
        Some(self.0.given(query))
    }

    fn write(&self, node: Node, value: &Option<K::Value>, writer: &mut Writer) -> Node {
        match value {
            Some(value) => self.0.write(node, value, writer),
            None => node,
        }
    }
}

/// A value of a plugin that no parameter of it changes.
pub struct Fixed<T>(pub T);

impl<T: Clone> Field for Fixed<T> {
    type Value = T;

    fn parameters(&self) -> Vec<Parameter> {
        Vec::new()
    }

    fn read(&self, _: &Query<'_>) -> Option<T> {
        Some(self.0.clone())
    }

    fn write(&self, node: Node, _: &T, _: &mut Writer) -> Node {
        node
    }
}

/// A parameter that Mitsuba 3 has and that changes nothing here.
pub struct Ignored {
    name: &'static str,
    takes: Takes,
    /// `None` where no user would expect that it changes anything.
    why: Option<&'static str>,
    /// Whether messages list it among what a plugin takes.
    is_listed: bool,
}

/// `why` may be empty.
pub const fn ignored(name: &'static str, takes: Takes, why: &'static str) -> Ignored {
    Ignored { name, takes, why: Some(why), is_listed: false }
}

impl Ignored {
    /// Says nothing of it.
    pub const fn silent(mut self) -> Self {
        self.why = None;
        self.listed()
    }

    /// Lists it in messages on mistyped names.
    pub const fn listed(mut self) -> Self {
        self.is_listed = true;
        self
    }

    /// Checks its type and remarks on it.
    pub fn read(&self, query: &Query<'_>) {
        let is_given = query.has(self.name);
        if !is_given && !self.is_listed {
            return;
        }
        match self.takes {
            Takes::Float(_) => drop(query.float(self.name)),
            Takes::Integer(least, most) => drop(query.integer(self.name, least, most)),
            Takes::Boolean => drop(query.boolean(self.name)),
            Takes::Transform => drop(query.transform(self.name)),
            _ => drop(query.text(self.name)),
        }
        let (true, Some(why)) = (is_given, self.why) else { return };
        let why = if why.is_empty() { String::new() } else { format!(": {why}") };
        query.reader.remark(&query.place(self.name), format!("{} changes nothing{why}", self.name));
    }

    pub fn parameter(&self) -> Parameter {
        Parameter { doc: "changes nothing", ..Parameter::new(self.name, self.takes.clone()) }
    }
}
