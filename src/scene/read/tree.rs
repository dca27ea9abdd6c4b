//! A scene file as a tree of objects with typed properties, before anyone asks what the plugins mean.

use super::super::source::{Place, SceneError, Sources};
use crate::geometry::Vec3;
use glam::DMat4;
use std::collections::BTreeMap;

/// The kinds of object that the grammar knows, one for each element name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::scene) enum Class {
    Scene,
    Integrator,
    Sensor,
    Film,
    Sampler,
    Filter,
    Shape,
    Bsdf,
    Emitter,
    Medium,
    Phase,
    /// `spectrum` and `texture`: one class in Mitsuba 3, and either word may be used.
    Spectrum,
    Volume,
}

impl Class {
    pub const ELEMENTS: [(&'static str, Self); 13] = [
        ("scene", Self::Scene),
        ("integrator", Self::Integrator),
        ("sensor", Self::Sensor),
        ("film", Self::Film),
        ("sampler", Self::Sampler),
        ("rfilter", Self::Filter),
        ("shape", Self::Shape),
        ("bsdf", Self::Bsdf),
        ("emitter", Self::Emitter),
        ("medium", Self::Medium),
        ("phase", Self::Phase),
        ("spectrum", Self::Spectrum),
        ("volume", Self::Volume),
    ];

    pub fn of_element(element: &str) -> Option<Self> {
        let element = if element == "texture" { "spectrum" } else { element };
        Self::ELEMENTS.iter().find(|(word, _)| *word == element).map(|&(_, class)| class)
    }

    /// The element that writes it.
    pub fn word(self) -> &'static str {
        Self::ELEMENTS.iter().find(|(_, class)| *class == self).map_or("object", |&(word, _)| word)
    }
}

/// Elements and objects deeper than this are refused: no scene needs them, and they could exhaust the stack.
pub(in crate::scene) const DEEPEST: usize = 64;

/// Most objects in a BSDF, each counted as often as it is referred to: what walks through them must end.
const MOST_IN_BSDF: usize = 4096;

/// Index into [`Tree::objects`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::scene) struct ObjectId(pub usize);

/// An element with a `type`.
#[derive(Clone, Debug)]
pub(in crate::scene) struct Object {
    pub class: Class,
    /// The value of `type`.
    pub plugin: String,
    pub plugin_place: Place,
    pub id: Option<String>,
    /// The start tag.
    pub place: Place,
    pub entries: Vec<Entry>,
}

/// A property of an object, or an object within it.
#[derive(Clone, Debug)]
pub(in crate::scene) struct Entry {
    /// `None` for an object that needs no name.
    pub name: Option<String>,
    pub name_place: Place,
    /// The whole element.
    pub place: Place,
    /// The attribute that gives the value, or the whole element.
    pub value_place: Place,
    pub value: Value,
}

#[derive(Clone, Debug)]
pub(in crate::scene) enum Value {
    Boolean(bool),
    Integer(i64),
    Float(f64),
    Text(String),
    /// `point` and `vector`, which Mitsuba 3 takes for each other.
    Vector(Vec3),
    Transform(DMat4),
    /// What the transform is at each of some times, in the order of the file.
    Animation(Vec<Keyframe>),
    /// Linear values for the primaries of sRGB.
    Rgb([f64; 3]),
    /// `<spectrum value="0.5">`.
    Flat(f64),
    /// `<spectrum value="400:1, 700:2">` and `<spectrum filename="...">`.
    List {
        nm: Vec<f64>,
        values: Vec<f64>,
        file: Option<std::path::PathBuf>,
    },
    Object(ObjectId),
    /// A `<ref>` that [`Tree::resolve`] has not replaced yet.
    Reference(String),
    /// Reported already: asking for it gives a default without another message.
    Broken,
}

/// A transform at a time.
#[derive(Clone, Debug)]
pub(in crate::scene) struct Keyframe {
    pub place: Place,
    pub time: f64,
    pub to_world: DMat4,
}

impl Value {
    /// What a message calls it.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Boolean(_) => "a boolean",
            Self::Integer(_) => "an integer",
            Self::Float(_) => "a float",
            Self::Text(_) => "a string",
            Self::Vector(_) => "a vector",
            Self::Transform(_) => "a transform",
            Self::Animation(_) => "an animation",
            Self::Rgb(_) => "an rgb colour",
            Self::Flat(_) | Self::List { .. } => "a spectrum",
            Self::Object(_) | Self::Reference(_) | Self::Broken => "an object",
        }
    }
}

/// All objects of a scene file; the first is the scene itself.
#[derive(Debug, Default)]
pub(in crate::scene) struct Tree {
    pub objects: Vec<Object>,
    pub ids: BTreeMap<String, ObjectId>,
    /// Whether the file is JSON: messages then speak of its types, not of XML's tags.
    pub is_json: bool,
}

impl Tree {
    pub const ROOT: ObjectId = ObjectId(0);

    pub fn get(&self, id: ObjectId) -> &Object {
        &self.objects[id.0]
    }

    /// Gives an object a name by which others refer to it; refused where another has it.
    pub fn name(
        &mut self,
        name: &str,
        place: &Place,
        object: ObjectId,
        sources: &Sources,
    ) -> Result<(), SceneError> {
        let Some(&earlier) = self.ids.get(name) else {
            self.ids.insert(name.to_owned(), object);
            return Ok(());
        };
        let earlier = &self.get(earlier).place;
        let mut at = format!("line {}", sources.line(earlier));
        if earlier.file != place.file {
            at.push_str(&format!(" of {}", sources.name(earlier)));
        }
        let problem = format!("The id \"{name}\" is given twice");
        let expected = format!("expected an id of its own; {at} has this one already");
        let error = SceneError::at(place, problem, expected);
        let is_again = earlier.file != place.file && sources.name(earlier) == sources.name(place);
        Err(if is_again {
            error.with_remedy("a file that gives ids can be included once only")
        } else {
            error
        })
    }

    /// Puts objects in the place of references. Those that lead nowhere, in a circle or too deep are reported
    /// and become [`Value::Broken`].
    pub fn resolve(&mut self, errors: &mut Vec<SceneError>) {
        for object in &mut self.objects {
            for entry in &mut object.entries {
                let Value::Reference(id) = &entry.value else { continue };
                entry.value = match self.ids.get(id) {
                    Some(&target) => Value::Object(target),
                    None => {
                        errors.push(dangling(id, &entry.value_place, self.ids.keys()));
                        Value::Broken
                    }
                };
            }
        }
        let mut states = vec![State::New; self.objects.len()];
        for start in 0..self.objects.len() {
            self.check_nesting(ObjectId(start), &mut states, errors);
        }
    }

    /// Cuts entries that lead back to an object that they stand in, or to more than [`DEEPEST`] objects
    /// within one another. Walks depth first without recursion: a chain of references can be as long as the
    /// file.
    fn check_nesting(&mut self, start: ObjectId, states: &mut [State], errors: &mut Vec<SceneError>) {
        let mut path = vec![(start, 0)];
        while let Some((id, next)) = path.pop() {
            if next == 0 {
                if matches!(states[id.0], State::Done { .. }) {
                    continue;
                }
                states[id.0] = State::Open;
            }
            let Some(entry) = self.objects[id.0].entries.get(next) else {
                states[id.0] = self.finished(id, states, errors);
                continue;
            };
            path.push((id, next + 1));
            let Value::Object(target) = entry.value else { continue };
            match states[target.0] {
                State::New => path.push((target, 0)),
                State::Done { .. } => {}
                State::Open => {
                    let name = self.objects[target.0].id.clone().unwrap_or_default();
                    errors.push(
                        SceneError::at(
                            &entry.value_place,
                            format!("The object \"{name}\" contains itself"),
                            "this reference leads back to an object that it stands in",
                        )
                        .with_remedy("refer to an object defined outside, or copy what is meant"),
                    );
                    self.objects[id.0].entries[next].value = Value::Broken;
                }
            }
        }
    }

    /// How deep and how large `id` is, whose children are done.
    fn finished(&mut self, id: ObjectId, states: &[State], errors: &mut Vec<SceneError>) -> State {
        let (mut height, mut size) = (1, 1_usize);
        let is_bsdf = self.objects[id.0].class == Class::Bsdf;
        for entry in &mut self.objects[id.0].entries {
            let Value::Object(child) = entry.value else { continue };
            let State::Done { height: below, size: within } = states[child.0] else { continue };
            let problem = if below >= DEEPEST {
                format!("Objects are nested more than {DEEPEST} deep")
            } else if is_bsdf && size.saturating_add(within) > MOST_IN_BSDF {
                format!("A BSDF holds more than {MOST_IN_BSDF} objects, if each reference is followed")
            } else {
                height = height.max(below + 1);
                size = size.saturating_add(within);
                continue;
            };
            errors.push(SceneError::at(
                &entry.value_place,
                problem,
                "expected fewer references from object to object",
            ));
            entry.value = Value::Broken;
        }
        State::Done { height, size }
    }
}

#[derive(Clone, Copy, PartialEq)]
enum State {
    New,
    Open,
    /// `height` objects stand within one another below and with it, and `size` in all, each counted as often
    /// as something refers to it.
    Done {
        height: usize,
        size: usize,
    },
}

pub(in crate::scene) fn dangling<'a>(
    id: &str,
    place: &Place,
    known: impl Iterator<Item = &'a String>,
) -> SceneError {
    let known: Vec<&str> = known.map(String::as_str).collect();
    let error = SceneError::at(
        place,
        format!("No object has the id \"{id}\""),
        "expected the id of an object in this scene",
    );
    match super::hints::nearest(id, &known) {
        Some(near) => error.with_remedy(format!("did you mean \"{near}\"?")),
        None if known.is_empty() => error.with_remedy(format!("give an object the attribute id=\"{id}\"")),
        None => error.with_remedy(format!("ids in this scene: {}", super::hints::listing(&known))),
    }
}
