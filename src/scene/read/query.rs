//! Asking an object for its properties: each question names its type and marks what it used, so that in the
//! end whatever nobody asked for is known to be a mistake.

use super::super::source::{Place, SceneError};
use super::Reader;
use super::attributes::beyond_integers;
use super::tree::{Class, Entry, Keyframe, Object, ObjectId, Value};
use super::{hints, names};
use crate::geometry::{Motion, MotionError, Transform, Vec3};
use crate::scene::description::Animation;
use glam::DMat4;
use std::cell::RefCell;
use std::path::PathBuf;
use std::sync::Arc;

/// Questions to one object. Call [`Query::finish`] after the last.
pub(in crate::scene) struct Query<'a> {
    pub reader: &'a Reader,
    pub object: &'a Object,
    /// The shape that a sensor stands in.
    pub shape: Option<ObjectId>,
    used: RefCell<Vec<bool>>,
    asked: RefCell<Vec<&'static str>>,
}

impl<'a> Query<'a> {
    pub fn new(reader: &'a Reader, id: ObjectId) -> Self {
        let object = reader.tree.get(id);
        let used = RefCell::new(vec![false; object.entries.len()]);
        Self { reader, object, shape: None, used, asked: RefCell::default() }
    }

    /// The same for a sensor in a shape.
    pub fn within(self, shape: Option<ObjectId>) -> Self {
        Self { shape, ..self }
    }

    /// The property of this name, whatever its type. `None` where it is absent or reported already.
    pub fn entry(&self, name: &'static str) -> Option<&'a Entry> {
        self.asked.borrow_mut().push(name);
        let index = self.object.entries.iter().position(|entry| entry.name.as_deref() == Some(name))?;
        self.used.borrow_mut()[index] = true;
        let entry = &self.object.entries[index];
        (!matches!(entry.value, Value::Broken)).then_some(entry)
    }

    pub fn has(&self, name: &'static str) -> bool {
        self.object.entries.iter().any(|entry| entry.name.as_deref() == Some(name))
    }

    /// Where the value of a property stands; the object's own place where it is absent.
    pub fn place(&self, name: &str) -> Place {
        let entry = self.object.entries.iter().find(|entry| entry.name.as_deref() == Some(name));
        entry.map_or_else(|| self.object.place.clone(), |entry| entry.value_place.clone())
    }

    pub fn error(&self, error: SceneError) {
        self.reader.error(error);
    }

    fn typed<T>(
        &self,
        name: &'static str,
        expected: &str,
        read: impl Fn(&'a Value) -> Option<T>,
    ) -> Option<T> {
        let entry = self.entry(name)?;
        let value = read(&entry.value);
        if value.is_none() {
            self.error(self.wrong_type(entry, name, expected));
        }
        value
    }

    /// `expected`: the tags of XML that may stand there.
    pub fn wrong_type(&self, entry: &Entry, name: &str, expected: &str) -> SceneError {
        let expected = match self.reader.tree.is_json {
            true => json_types(expected),
            false => expected.to_owned(),
        };
        SceneError::at(
            &entry.place,
            format!("\"{name}\" of {} has the wrong type: {}", self.title(), entry.value.word()),
            format!("expected {expected}"),
        )
    }

    /// The object as messages call it: `sphere`, or `bsdf "glass"`.
    pub fn title(&self) -> String {
        match self.object.class {
            Class::Scene => "the scene".to_owned(),
            Class::Spectrum if names::is_texture(&self.object.plugin) => {
                format!("texture \"{}\"", self.object.plugin)
            }
            class => format!("{} \"{}\"", class.word(), self.object.plugin),
        }
    }

    pub fn float(&self, name: &'static str) -> Option<f64> {
        self.typed(name, "<float> or <integer>", |value| match value {
            Value::Float(number) => Some(*number),
            Value::Integer(number) => Some(*number as f64),
            _ => None,
        })
    }

    /// A number in (0, ∞).
    pub fn positive(&self, name: &'static str, default: f64) -> f64 {
        match self.float(name) {
            Some(number) if number > 0.0 => number,
            Some(number) => {
                let problem = format!("\"{name}\" of {} is {number}", self.title());
                self.error(SceneError::at(&self.place(name), problem, "expected a number above 0"));
                default
            }
            None => default,
        }
    }

    /// An integer in `least..=most`.
    pub fn integer(&self, name: &'static str, least: i64, most: i64) -> Option<i64> {
        // A whole number with too many digits is read as a float, which it may be elsewhere.
        let is_too_large = |entry: &&Entry| match entry.value {
            Value::Float(number) => self.reader.tree.is_json && number.abs() >= -(i64::MIN as f64),
            _ => false,
        };
        if let Some(entry) = self.entry(name).filter(is_too_large) {
            let what = format!("\"{name}\" of {}", self.title());
            self.error(beyond_integers(&entry.value_place, &what));
            return None;
        }
        let number = self.typed(name, "<integer>", |value| match value {
            Value::Integer(number) => Some(*number),
            _ => None,
        })?;
        if (least..=most).contains(&number) {
            return Some(number);
        }
        let problem = format!("\"{name}\" of {} is {number}", self.title());
        let expected = match most {
            // Limits of the program's own types would say nothing to anybody.
            _ if most >= i64::from(u32::MAX) && number < least => {
                format!("expected an integer of at least {least}")
            }
            _ => format!("expected an integer from {least} to {most}"),
        };
        self.error(SceneError::at(&self.place(name), problem, expected));
        None
    }

    pub fn boolean(&self, name: &'static str) -> Option<bool> {
        self.typed(name, "<boolean>", |value| match value {
            Value::Boolean(value) => Some(*value),
            _ => None,
        })
    }

    pub fn text(&self, name: &'static str) -> Option<&'a str> {
        self.typed(name, "<string>", |value| match value {
            Value::Text(text) => Some(text.as_str()),
            _ => None,
        })
    }

    pub fn vector(&self, name: &'static str) -> Option<Vec3> {
        self.typed(name, "<point> or <vector>", |value| match value {
            Value::Vector(vector) => Some(*vector),
            _ => None,
        })
    }

    /// A transform that can be undone; the identity where it is absent.
    pub fn transform(&self, name: &'static str) -> Transform {
        let matrix = self.typed(name, "<transform>", |value| match value {
            Value::Transform(matrix) => Some(*matrix),
            _ => None,
        });
        let Some(matrix) = matrix else { return Transform::IDENTITY };
        self.regular(matrix, &self.place(name))
    }

    fn regular(&self, matrix: DMat4, place: &Place) -> Transform {
        Transform::new(matrix).unwrap_or_else(|| {
            let problem = "The transform is singular";
            let error = SceneError::at(place, problem, "expected a transform that can be undone");
            self.error(
                error.with_remedy("no scale factor may be 0, and the rows of a matrix must be independent"),
            );
            Transform::IDENTITY
        })
    }

    /// `to_world` of what may move: a transform or an animation.
    pub fn placement(&self) -> (Transform, Option<Arc<Animation>>) {
        let Some(entry) = self.entry("to_world") else { return (Transform::IDENTITY, None) };
        let keyframes = match &entry.value {
            Value::Transform(matrix) => return (self.regular(*matrix, &entry.value_place), None),
            Value::Animation(keyframes) => keyframes,
            _ => {
                self.error(self.wrong_type(entry, "to_world", "<transform> or <animation>"));
                return (Transform::IDENTITY, None);
            }
        };
        let place = entry.value_place.clone();
        self.reader.extension(&place, "animation: motion while the shutter is open".to_owned());
        let keys: Vec<_> =
            keyframes.iter().map(|key| (key.time, self.regular(key.to_world, &key.place))).collect();
        if let Err(wrong) = Motion::new(&keys) {
            self.error(wrong_motion(wrong, &place, keyframes));
            return (Transform::IDENTITY, None);
        }
        (keys[0].1, Some(Arc::new(Animation { place, keys })))
    }

    /// One of some words. `None` where it is absent or none of them.
    pub fn choice<T: Copy>(&self, name: &'static str, choices: &[(&str, T)], any_case: bool) -> Option<T> {
        let text = self.text(name)?;
        let same = |word: &str| word == text || any_case && word.eq_ignore_ascii_case(text);
        if let Some((_, value)) = choices.iter().find(|(word, _)| same(word)) {
            return Some(*value);
        }
        let words: Vec<&str> = choices.iter().map(|(word, _)| *word).collect();
        let problem = format!("\"{text}\" is not a value of \"{name}\"");
        let error = SceneError::at(&self.place(name), problem, format!("expected {}", hints::either(&words)));
        self.error(match hints::nearest(text, &words) {
            Some(near) => error.with_remedy(format!("did you mean \"{near}\"?")),
            None => error,
        });
        None
    }

    /// Reports a property that has to be there and is not.
    pub fn required<T>(&self, name: &'static str, value: Option<T>) -> Option<T> {
        if value.is_none() && !self.has(name) {
            let problem = format!("{} has no \"{name}\"", capital(&self.title()));
            let expected = format!("expected a property named \"{name}\" in here");
            self.error(SceneError::at(&self.object.place, problem, expected));
        }
        value
    }

    /// The path of the file that a property must name.
    pub fn file(&self, name: &'static str) -> Option<PathBuf> {
        self.required(name, self.text(name)).map(|file| self.reader.search.find(file))
    }

    /// The objects of a class that stand in this one, and mark them as used. Their names do not matter unless
    /// `named` is given.
    pub fn objects(&self, class: Class) -> Vec<(&'a Entry, ObjectId)> {
        let mut found = Vec::new();
        for (index, entry) in self.object.entries.iter().enumerate() {
            let Value::Object(id) = entry.value else { continue };
            if self.reader.tree.get(id).class == class && !self.used.borrow()[index] {
                self.used.borrow_mut()[index] = true;
                found.push((entry, id));
            }
        }
        found
    }

    /// What is left of spectra, whatever their names, and marks them as used.
    pub fn spectra(&self) -> Vec<&'a Entry> {
        let mut found = Vec::new();
        for (index, entry) in self.object.entries.iter().enumerate() {
            let is_spectrum = match &entry.value {
                Value::Flat(_) | Value::List { .. } => true,
                Value::Object(id) => self.reader.tree.get(*id).class == Class::Spectrum,
                _ => false,
            };
            if is_spectrum && !self.used.borrow()[index] {
                self.used.borrow_mut()[index] = true;
                found.push(entry);
            }
        }
        found
    }

    /// The name that Mitsuba 3 makes up for an object without one: objects without names are numbered.
    pub fn unnamed(&self, entry: &Entry) -> String {
        let unnamed = self.object.entries.iter().filter(|entry| entry.name.is_none());
        let before = unnamed.take_while(|other| !std::ptr::eq(*other, entry)).count();
        format!("_arg_{before}")
    }

    /// At most one object of a class; further ones are refused.
    pub fn object(&self, class: Class) -> Option<(&'a Entry, ObjectId)> {
        let found = self.objects(class);
        if let Some((second, _)) = found.get(1) {
            let word = class.word();
            let problem = format!("{} has more than one {word}", capital(&self.title()));
            self.error(SceneError::at(&second.place, problem, format!("expected one {word} at most")));
        }
        found.into_iter().next()
    }

    /// Whether an object within it is wrong, which is reported already.
    pub fn has_broken(&self) -> bool {
        self.object.entries.iter().any(|entry| matches!(entry.value, Value::Broken))
    }

    /// Reports the properties that no reader asked for.
    pub fn finish(self) {
        // A child that was wrong itself may be what was asked for.
        for (entry, used) in self.object.entries.iter().zip(self.used.borrow().iter()) {
            if *used || matches!(entry.value, Value::Broken) {
                continue;
            }
            self.error(match (&entry.name, &entry.value) {
                (_, Value::Object(id)) => self.misplaced(entry, *id),
                (Some(name), _) => self.unknown(entry, name),
                (None, _) => SceneError::at(&entry.place, "A property has no name", "expected name=\"...\""),
            });
        }
    }

    fn unknown(&self, entry: &Entry, name: &str) -> SceneError {
        let mut known: Vec<&str> = self.asked.borrow().clone();
        known.sort_unstable();
        known.dedup();
        let problem = format!("{} has no property \"{name}\"", capital(&self.title()));
        let expected = match known.len() {
            0 => "expected no property".to_owned(),
            1..=7 => format!("expected {}", hints::either(&known)),
            _ => "not a name that this plugin knows".to_owned(),
        };
        let error = SceneError::at(&entry.name_place, problem, expected);
        if let Some(remedy) = hints::formerly_property(self.object.class, name) {
            return error.with_remedy(remedy);
        }
        match hints::nearest(name, &known) {
            Some(near) => error.with_remedy(format!("did you mean \"{near}\"?")),
            None if known.len() > 7 => error.with_remedy(format!("it knows {}", hints::listing(&known))),
            None => error,
        }
    }

    fn misplaced(&self, entry: &Entry, id: ObjectId) -> SceneError {
        let child = self.reader.tree.get(id);
        let word = child.class.word();
        if child.class == Class::Spectrum
            && let Some(name) = &entry.name
        {
            return self.unknown(entry, name);
        }
        let problem = format!("{} cannot hold a {word}", capital(&self.title()));
        let error = SceneError::at(&entry.place, problem, "this object has no meaning here");
        match child.class {
            Class::Spectrum => {
                error.with_remedy("a spectrum needs a name here, for instance name=\"reflectance\"")
            }
            Class::Film | Class::Sampler => error.with_remedy(format!("a {word} belongs into a <sensor>")),
            Class::Filter => error.with_remedy("an rfilter belongs into a <film>"),
            Class::Medium => error.with_remedy("a medium belongs into a <shape>, with name=\"interior\""),
            Class::Phase => error.with_remedy("a phase function belongs into a <medium>"),
            Class::Bsdf => error.with_remedy("a bsdf belongs into a <shape>"),
            Class::Shape | Class::Sensor | Class::Integrator | Class::Emitter => {
                error.with_remedy(format!("a {word} belongs directly into the <scene>"))
            }
            Class::Scene | Class::Volume => error,
        }
    }
}

/// What tags of XML are in JSON.
fn json_types(tags: &str) -> String {
    let types = [
        ("<float> or <integer>", "a number"),
        ("<float>, <integer>", "a number"),
        ("<point> or <vector>", "3 numbers"),
        ("<vector>", "3 numbers"),
        ("<point>", "3 numbers"),
        ("<integer>", "an integer"),
        ("<animation>", "an animation"),
        ("<rgb>", "an rgb"),
        ("<", "a "),
        (">", ""),
    ];
    types.into_iter().fold(tags.to_owned(), |text, (tag, word)| text.replace(tag, word))
}

fn wrong_motion(error: MotionError, place: &Place, keyframes: &[Keyframe]) -> SceneError {
    let key = |index: usize| keyframes.get(index).map_or(place, |key| &key.place);
    match error {
        MotionError::NoKeys => SceneError::at(
            place,
            "The animation has no keyframe",
            "expected transforms in it, each with its time",
        ),
        MotionError::Order(index) => SceneError::at(
            key(index),
            "The time of this keyframe is not after that of the one before it",
            "expected keyframes in the order of time",
        ),
        MotionError::Mirrors(index) => SceneError::at(
            key(index),
            "This keyframe is a mirror image of the one before it",
            "expected the same handedness in all keyframes",
        )
        .with_remedy(
            "nothing can be turned inside out while it moves: give all or none of them a mirroring scale",
        ),
    }
}

/// With a capital first letter, to begin a sentence; an abbreviation is all capitals.
pub(in crate::scene) fn capital(text: &str) -> String {
    if let Some(rest) = text.strip_prefix("bsdf ") {
        return format!("BSDF {rest}");
    }
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |first| first.to_uppercase().chain(chars).collect())
}
