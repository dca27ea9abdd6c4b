//! Writes a description as a tree of nodes in the words of Mitsuba 3: the plugin and parameter names that a
//! scene file would have, with the defaults filled in. The outline, the JSON and the hash use this one tree.
//!
//! Plugins are written by their declarations ([`super::plugins`]); here are the scene itself, solids, groups
//! and instances. What is written has to read back as the same: the JSON is a scene file too.

mod shapes;
pub(super) mod spectra;

use super::description::{Animation, Bsdf, Description, ShapeGroup, SpectrumSource};
use super::plugins::{integrators, lights, sensors};
use super::read::Class;
use super::source::Place;
use crate::geometry::{Transform, Vec3};
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;

/// An object as a scene file could have it.
#[derive(Debug)]
pub(super) struct Node {
    pub class: Class,
    pub plugin: &'static str,
    pub id: Option<String>,
    pub place: Place,
    pub properties: Vec<Property>,
    /// What no property says, for readers of the outline.
    pub remarks: Vec<String>,
}

#[derive(Debug)]
pub(super) struct Property {
    /// `None` for an object that needs no name.
    pub name: Option<Cow<'static, str>>,
    pub value: Value,
    /// Where the file gives the value, as far as that is known.
    pub place: Option<Place>,
}

#[derive(Debug)]
pub(super) enum Value {
    Boolean(bool),
    Integer(i64),
    Float(f64),
    Text(String),
    /// Numbers in a string.
    Numbers(Vec<f64>),
    Vector(Vec3),
    Transform(Transform),
    /// `<animation>`: times and transforms.
    Animation(Arc<Animation>),
    /// `<rgb value="0.1 0.2 0.3">`.
    Rgb([f64; 3]),
    /// `<spectrum value="0.5">`.
    Flat(f64),
    /// `<spectrum value="400:1, 700:2">`; by value even where it came from a file.
    List {
        nm: Vec<f64>,
        values: Vec<f64>,
        file: Option<PathBuf>,
    },
    /// A file of data that is too large to be written out.
    File {
        path: PathBuf,
        /// Hash of what was read from it.
        content: u64,
        /// What is in it, in a few words.
        summary: String,
    },
    Object(Rc<Node>),
}

impl Node {
    pub fn new(class: Class, plugin: &'static str, place: &Place) -> Self {
        Self { class, plugin, id: None, place: place.clone(), properties: Vec::new(), remarks: Vec::new() }
    }

    pub fn id(mut self, id: &Option<String>) -> Self {
        self.id = id.clone();
        self
    }

    pub fn property(mut self, name: Option<Cow<'static, str>>, value: Value, place: Option<Place>) -> Self {
        self.properties.push(Property { name, value, place });
        self
    }

    pub fn with(self, name: &'static str, value: Value) -> Self {
        self.property(Some(name.into()), value, None)
    }

    pub fn boolean(self, name: &'static str, value: bool) -> Self {
        self.with(name, Value::Boolean(value))
    }

    pub fn integer(self, name: &'static str, value: impl Into<i64>) -> Self {
        self.with(name, Value::Integer(value.into()))
    }

    pub fn float(self, name: &'static str, value: f64) -> Self {
        self.with(name, Value::Float(value))
    }

    pub fn text(self, name: &'static str, value: impl Into<String>) -> Self {
        self.with(name, Value::Text(value.into()))
    }

    pub fn numbers(self, name: &'static str, values: &[f64]) -> Self {
        self.with(name, Value::Numbers(values.to_vec()))
    }

    pub fn vector(self, name: &'static str, value: Vec3) -> Self {
        self.with(name, Value::Vector(value))
    }

    /// A transform; nothing where it is the identity, which is the default everywhere.
    pub fn transform(self, name: &'static str, value: &Transform) -> Self {
        if *value == Transform::IDENTITY { self } else { self.with(name, Value::Transform(*value)) }
    }

    /// `to_world` of what may move.
    pub fn placement(self, to_world: &Transform, motion: &Option<Arc<Animation>>) -> Self {
        match motion {
            None => self.transform("to_world", to_world),
            Some(motion) => self.with("to_world", Value::Animation(motion.clone())),
        }
    }

    pub fn spectrum(self, name: impl Into<Cow<'static, str>>, source: &SpectrumSource) -> Self {
        self.property(Some(name.into()), spectra::write(source), Some(source.place.clone()))
    }

    /// An object that a name tells apart from others of its class.
    pub fn named(self, name: &'static str, object: Self) -> Self {
        self.with(name, Value::Object(Rc::new(object)))
    }

    /// An object whose class says what it is for.
    pub fn child(self, object: impl Into<Rc<Self>>) -> Self {
        self.property(None, Value::Object(object.into()), None)
    }

    pub fn remark(mut self, text: impl Into<String>) -> Self {
        self.remarks.push(text.into());
        self
    }
}

/// Writes each object that several others share once.
#[derive(Default)]
pub(super) struct Writer {
    pub bsdfs: BTreeMap<*const Bsdf, Rc<Node>>,
    /// Ids of shapes. A shape that is a part of several solids is written in full each time, for its
    /// surroundings may differ.
    pub shapes: BTreeSet<String>,
    groups: BTreeMap<*const ShapeGroup, Rc<Node>>,
}

/// The whole scene.
pub(super) fn scene(description: &Description) -> Node {
    let mut writer = Writer::default();
    let place = Place { file: description.sensor.place.file, span: 0..0 };
    let integrator = integrators::node(&description.integrator, &mut writer);
    let mut scene = Node::new(Class::Scene, "scene", &place).child(integrator);
    // An irradiance meter stands in its shape.
    let meter = sensors::surface(&description.sensor);
    let sensor = sensors::node(&description.sensor, &mut writer);
    let mut sensor = Some(sensor);
    if meter.is_none() {
        scene = sensor.take().into_iter().fold(scene, Node::child);
    }
    for light in &description.lights {
        scene = scene.child(lights::node(light, &mut writer));
    }
    for shape in &description.shapes {
        let node = super::plugins::shapes::node(shape, &mut writer);
        let own = sensor.take_if(|_| meter.is_some_and(|surface| surface.place == shape.place));
        scene = scene.child(own.into_iter().fold(node, Node::child));
    }
    for solid in &description.solids {
        scene = scene.child(shapes::solid(&mut writer, solid));
    }
    for instance in &description.instances {
        scene = scene.child(shapes::instance(&mut writer, instance));
    }
    scene
}
