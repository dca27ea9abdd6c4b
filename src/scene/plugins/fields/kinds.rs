//! What one property can be: numbers, words, points.

use super::super::{Range, Takes};
use super::{Kind, Simple};
use crate::geometry::Vec3;
use crate::scene::read::{Query, spectra};
use crate::scene::source::SceneError;
use crate::scene::write::Value;

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
