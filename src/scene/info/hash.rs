use super::super::description::{Description, Medium};
use super::super::plugins::media;
use super::super::write::{self, Node, Value, Writer};
use crate::geometry::Transform;
use crate::sampling::digest;
use crate::shape::{ControlNet, ControlPoint, MeshAttribute, MeshData};
use std::collections::BTreeMap;
use std::rc::Rc;

impl Description {
    /// A hash of what the scene means, the content of its tables and meshes included. It does not depend on
    /// how the file is laid out, on comments, names or paths.
    pub fn hash(&self) -> u64 {
        Hasher::default().object(&write::scene(self))
    }
}

impl Medium {
    /// The same of a medium: media that are alike have one hash, wherever the file states them.
    pub(in crate::scene) fn hash(&self) -> u64 {
        Hasher::default().object(&media::node(self, &mut Writer::default()))
    }
}

/// Remembers what several objects share.
#[derive(Default)]
struct Hasher {
    known: BTreeMap<*const Node, u64>,
}

impl Hasher {
    fn object(&mut self, node: &Node) -> u64 {
        let mut words = vec![text(node.plugin)];
        for property in &node.properties {
            // Names such as `bsdf` and `bsdf_2` say nothing; the order does.
            words.push(text(property.name.as_deref().unwrap_or("")));
            words.push(self.value(&property.value));
        }
        digest(words.into_iter())
    }

    fn value(&mut self, value: &Value) -> u64 {
        let tagged = |tag: u64, words: &[u64]| digest(std::iter::once(tag).chain(words.iter().copied()));
        match value {
            Value::Boolean(value) => tagged(1, &[u64::from(*value)]),
            Value::Integer(value) => tagged(2, &[*value as u64]),
            Value::Float(value) => tagged(3, &[bits(*value)]),
            Value::Text(value) => tagged(4, &[text(value)]),
            Value::Numbers(values) => tagged(5, &[floats(values)]),
            Value::Vector(value) => tagged(6, &[floats(&value.to_array())]),
            Value::Transform(value) => tagged(7, &[floats(&value.matrix().to_cols_array())]),
            Value::Animation(motion) => {
                let key = |(time, to_world): &(f64, Transform)| {
                    [bits(*time), floats(&to_world.matrix().to_cols_array())]
                };
                tagged(13, &motion.keys.iter().flat_map(key).collect::<Vec<_>>())
            }
            Value::Flat(value) => tagged(8, &[bits(*value)]),
            Value::List { nm, values, .. } => tagged(9, &[floats(nm), floats(values)]),
            Value::File { content, .. } => tagged(10, &[*content]),
            Value::Rgb(rgb) => tagged(12, &[floats(rgb)]),
            Value::Object(object) => tagged(11, &[self.shared(object)]),
        }
    }

    fn shared(&mut self, object: &Rc<Node>) -> u64 {
        let key = Rc::as_ptr(object);
        if let Some(&known) = self.known.get(&key) {
            return known;
        }
        let hash = self.object(object);
        self.known.insert(key, hash);
        hash
    }
}

/// Equal numbers have equal bits.
fn bits(number: f64) -> u64 {
    if number == 0.0 { 0 } else { number.to_bits() }
}

fn floats(values: &[f64]) -> u64 {
    digest(values.iter().map(|&value| bits(value)))
}

fn text(text: &str) -> u64 {
    digest(text.bytes().map(u64::from))
}

/// Hash of the content of a file of curves.
pub(in crate::scene) fn hash_of_curves(curves: &[Vec<ControlPoint>]) -> u64 {
    let of_curve = |curve: &Vec<ControlPoint>| {
        let numbers = curve.iter().flat_map(|point| [point.position.to_array().to_vec(), vec![point.radius]]);
        digest(numbers.flatten().map(f64::to_bits))
    };
    digest(curves.iter().map(of_curve))
}

/// Hash of the content of a file of patches.
pub(in crate::scene) fn hash_of_patches(patches: &[ControlNet]) -> u64 {
    digest(patches.iter().flatten().flat_map(|point| point.to_array()).map(f64::to_bits))
}

/// Hash of the bytes of a file.
pub(in crate::scene) fn hash_of_bytes(bytes: &[u8]) -> u64 {
    let word = |chunk: &[u8]| chunk.iter().fold(0u64, |word, &byte| word << 8 | u64::from(byte));
    digest(std::iter::once(bytes.len() as u64).chain(bytes.chunks(8).map(word)))
}

/// Hash of the content of a file of texels or cells.
pub(in crate::scene) fn hash_of_values(shape: &[usize], values: &[f32]) -> u64 {
    let shape = shape.iter().map(|&size| size as u64);
    digest(shape.chain(values.iter().map(|value| u64::from(value.to_bits()))))
}

pub(in crate::scene) fn hash_of_mesh(mesh: &MeshData) -> u64 {
    let floats =
        |values: &[[f32; 3]]| -> u64 { digest(values.iter().flatten().map(|x| u64::from(x.to_bits()))) };
    let parts = [
        floats(&mesh.positions),
        digest(mesh.indices.iter().flatten().map(|&index| u64::from(index))),
        mesh.normals.as_ref().map_or(0, |normals| floats(normals)),
        mesh.uvs.as_ref().map_or(0, |uvs| digest(uvs.iter().flatten().map(|x| u64::from(x.to_bits())))),
        u64::from(mesh.flip_normals),
    ];
    let attributes = mesh.attributes.iter().map(|MeshAttribute { name, per_face, channels, values }| {
        let name = name.bytes().map(u64::from);
        let kind = [u64::from(*per_face), *channels as u64];
        digest(name.chain(kind).chain(values.iter().map(|x| u64::from(x.to_bits()))))
    });
    digest(parts.into_iter().chain(attributes))
}
