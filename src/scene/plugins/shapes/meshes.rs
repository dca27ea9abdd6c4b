//! Meshes from files.

use crate::scene::description::MeshFormat;
use crate::scene::info::hash_of_mesh;
use crate::scene::plugins::fields::{Boolean, Integer};
use crate::scene::plugins::{Field, Parameter, Simple, Takes, boolean, integer};
use crate::scene::read::Query;
use crate::scene::read::meshes::{self, MeshKey};
use crate::scene::write::{Node, Value, Writer};
use crate::shape::MeshData;
use std::path::PathBuf;
use std::sync::Arc;

pub const fn flip_tex_coords(default: bool) -> Simple<Boolean> {
    boolean("flip_tex_coords", default, "whether v becomes 1 − v")
}

pub const SHAPE_INDEX: Simple<Integer<u32>> =
    integer("shape_index", 0, [0, u32::MAX as i64], "which mesh of the file it is");

/// Shapes that are meshes in files.
pub const FORMATS: [&str; 3] = ["obj", "ply", "serialized"];

const FACE_NORMALS: Simple<Boolean> = boolean("face_normals", false, "whether triangles are flat");

/// The mesh that a shape of one of [`FORMATS`] asks for.
pub fn asked(query: &Query<'_>) -> Option<MeshKey> {
    let path = query.file("filename");
    let format = match query.object.plugin.as_str() {
        "obj" => MeshFormat::Obj { flip_tex_coords: flip_tex_coords(true).read(query)? },
        "ply" => MeshFormat::Ply { flip_tex_coords: flip_tex_coords(false).read(query)? },
        _ => MeshFormat::Serialized { shape_index: SHAPE_INDEX.read(query)? },
    };
    let face_normals = FACE_NORMALS.read(query)?;
    Some(MeshKey { path: path?, format, face_normals })
}

/// The file of a mesh, what is in it, and whether its vertices get normals that the file does not have.
pub struct MeshFile;

impl Field for MeshFile {
    type Value = (PathBuf, Arc<MeshData>, bool);

    fn parameters(&self) -> Vec<Parameter> {
        let file = Parameter::new("filename", Takes::File);
        let file = Parameter { is_required: true, doc: "file of the mesh", ..file };
        [vec![file], FACE_NORMALS.parameters()].concat()
    }

    fn read(&self, query: &Query<'_>) -> Option<Self::Value> {
        let asked = asked(query)?;
        let mesh = meshes::read_once(query, &asked)?;
        let compute_normals = mesh.normals.is_none() && !asked.face_normals;
        Some((asked.path, mesh, compute_normals))
    }

    fn write(&self, node: Node, (file, mesh, compute_normals): &Self::Value, _: &mut Writer) -> Node {
        let summary = format!("{} triangles, {} vertices", mesh.indices.len(), mesh.positions.len());
        let filename = Value::File { path: file.clone(), content: hash_of_mesh(mesh), summary };
        let node = node
            .with("filename", filename)
            .boolean("face_normals", mesh.normals.is_none() && !compute_normals);
        match (&mesh.normals, compute_normals) {
            (Some(_), _) => node.remark("normals of the file"),
            (None, true) => node.remark("smooth normals, computed"),
            (None, false) => node,
        }
    }
}
