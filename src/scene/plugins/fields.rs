//! Fields of one parameter: numbers, words, and what else a property can be.

use super::{Field, Parameter, Range, Takes};
use crate::geometry::Vec3;
use crate::scene::info::text_of;
use crate::scene::read::{Query, spectra};
use crate::scene::source::SceneError;
use crate::scene::write::{Node, Value, Writer};

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

/// A number.
pub struct Float {
    range: Range,
    /// What messages say of a number beyond the range, with `{}` for it.
    problem: &'static str,
    /// What they expect; empty for what the range says by itself.
    expected: &'static str,
    remedy: &'static str,
}

pub const fn float(name: &'static str, default: f64, doc: &'static str) -> Simple<Float> {
    let kind = Float { range: Range::ALL, problem: "", expected: "", remedy: "" };
    Simple::new(name, Some(default), kind, doc)
}

impl Simple<Float> {
    pub const fn within(mut self, range: Range) -> Self {
        self.kind.range = range;
        self
    }

    /// What messages say of a number beyond the range, with `{}` for it.
    pub const fn said(mut self, problem: &'static str, expected: &'static str) -> Self {
        (self.kind.problem, self.kind.expected) = (problem, expected);
        self
    }

    /// What to do about a number beyond the range.
    pub const fn remedy(mut self, remedy: &'static str) -> Self {
        self.kind.remedy = remedy;
        self
    }

    pub const fn positive(self) -> Self {
        self.within(Range::POSITIVE)
    }

    pub const fn not_negative(self) -> Self {
        self.within(Range::NOT_NEGATIVE)
    }
}

impl Kind for Float {
    type Value = f64;

    fn takes(&self) -> Takes {
        Takes::Float(self.range)
    }

    fn read(&self, query: &Query<'_>, name: &'static str) -> Option<f64> {
        let number = query.float(name)?;
        if self.range.contains(number) {
            return Some(number);
        }
        let problem = match self.problem {
            "" => format!("\"{name}\" of {} is {number}", query.title()),
            problem => problem.replace("{}", &number.to_string()),
        };
        let expected = match self.expected {
            "" => format!("expected a number {}", self.range),
            expected => expected.to_owned(),
        };
        let error = SceneError::at(&query.place(name), problem, expected);
        query.error(if self.remedy.is_empty() { error } else { error.with_remedy(self.remedy) });
        None
    }

    fn value(&self, value: &f64) -> Value {
        Value::Float(*value)
    }
}

/// An integer from the first to the last of these.
pub struct Integer<T>(i64, i64, std::marker::PhantomData<T>);

/// Integers that fit into their type as far as they lie in their range.
pub const fn integer<T: Copy + PartialEq + TryFrom<i64> + TryInto<i64>>(
    name: &'static str,
    default: T,
    [least, most]: [i64; 2],
    doc: &'static str,
) -> Simple<Integer<T>> {
    Simple::new(name, Some(default), Integer(least, most, std::marker::PhantomData), doc)
}

impl<T: Copy + PartialEq + TryFrom<i64> + TryInto<i64>> Kind for Integer<T> {
    type Value = T;

    fn takes(&self) -> Takes {
        Takes::Integer(self.0, self.1)
    }

    fn read(&self, query: &Query<'_>, name: &'static str) -> Option<T> {
        T::try_from(query.integer(name, self.0, self.1)?).ok()
    }

    fn value(&self, value: &T) -> Value {
        Value::Integer((*value).try_into().unwrap_or(i64::MAX))
    }
}

/// True or false.
pub struct Boolean;

pub const fn boolean(name: &'static str, default: bool, doc: &'static str) -> Simple<Boolean> {
    Simple::new(name, Some(default), Boolean, doc)
}

impl Kind for Boolean {
    type Value = bool;

    fn takes(&self) -> Takes {
        Takes::Boolean
    }

    fn read(&self, query: &Query<'_>, name: &'static str) -> Option<bool> {
        query.boolean(name)
    }

    fn value(&self, value: &bool) -> Value {
        Value::Boolean(*value)
    }
}

/// One of some words, each with what it means.
pub struct Choices<T: 'static> {
    words: &'static [(&'static str, T)],
    /// Whether small and capital letters are the same.
    any_case: bool,
}

pub const fn choice<T: Copy + PartialEq>(
    name: &'static str,
    default: T,
    words: &'static [(&'static str, T)],
    doc: &'static str,
) -> Simple<Choices<T>> {
    Simple::new(name, Some(default), Choices { words, any_case: false }, doc)
}

impl<T: Copy + PartialEq> Simple<Choices<T>> {
    pub const fn in_any_case(mut self) -> Self {
        self.kind.any_case = true;
        self
    }
}

impl<T: Copy + PartialEq> Kind for Choices<T> {
    type Value = T;

    fn takes(&self) -> Takes {
        Takes::Choice(self.words.iter().map(|(word, _)| *word).collect())
    }

    fn read(&self, query: &Query<'_>, name: &'static str) -> Option<T> {
        query.choice(name, self.words, self.any_case)
    }

    fn value(&self, value: &T) -> Value {
        let word = self.words.iter().find(|(_, known)| known == value);
        Value::Text(word.map_or(String::new(), |(word, _)| (*word).to_owned()))
    }
}

/// A point or a direction.
pub struct Vector;

pub const fn vector(name: &'static str, default: Vec3, doc: &'static str) -> Simple<Vector> {
    Simple::new(name, Some(default), Vector, doc)
}

impl Kind for Vector {
    type Value = Vec3;

    fn takes(&self) -> Takes {
        Takes::Vector
    }

    fn read(&self, query: &Query<'_>, name: &'static str) -> Option<Vec3> {
        query.vector(name)
    }

    fn value(&self, value: &Vec3) -> Value {
        Value::Vector(*value)
    }
}

/// A string.
pub struct Text;

pub const fn text(name: &'static str, doc: &'static str) -> Simple<Text> {
    Simple::new(name, None, Text, doc)
}

impl Kind for Text {
    type Value = String;

    fn takes(&self) -> Takes {
        Takes::Text
    }

    fn read(&self, query: &Query<'_>, name: &'static str) -> Option<String> {
        query.text(name).map(str::to_owned)
    }

    fn value(&self, value: &String) -> Value {
        Value::Text(value.clone())
    }
}

/// Numbers in a string.
pub struct Numbers;

pub const fn numbers(name: &'static str, doc: &'static str) -> Simple<Numbers> {
    Simple::new(name, None, Numbers, doc)
}

impl Kind for Numbers {
    type Value = Vec<f64>;

    fn takes(&self) -> Takes {
        Takes::Numbers
    }

    fn read(&self, query: &Query<'_>, name: &'static str) -> Option<Vec<f64>> {
        spectra::numbers(query, name)
    }

    fn value(&self, value: &Vec<f64>) -> Value {
        Value::Numbers(value.clone())
    }
}

/// A parameter that Mitsuba 3 has and that changes nothing here.
pub struct Ignored {
    name: &'static str,
    takes: Takes,
    /// `None` where nobody would expect that it changed anything.
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
