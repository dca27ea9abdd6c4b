//! Meshes from files, whatever they are written in.

use super::super::description::MeshFormat;
use super::super::source::{Place, SceneError};
use super::query::Query;
use super::{files, obj, ply, serialized};
use crate::shape::MeshData;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A larger mesh file would not fit the 32-bit indices of what is made from it.
const LARGEST_MESH_FILE: u64 = 16 << 30;

/// How a mesh file is to be understood.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct MeshOptions {
    /// Whether normals of the file are to be left out, for flat triangles.
    pub face_normals: bool,
    /// Whether v becomes 1 − v.
    pub flip_tex_coords: bool,
}

/// What makes two mesh shapes share one mesh.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::scene) struct MeshKey {
    pub path: PathBuf,
    pub format: MeshFormat,
    pub face_normals: bool,
}

/// The mesh of a file, however many shapes show it; `None` where it is wrong, which is reported.
pub(in crate::scene) fn read_once(query: &Query<'_>, key: &MeshKey) -> Option<Arc<MeshData>> {
    let reader = query.reader;
    reader.meshes.get(reader, key, || {
        let place = query.place("filename");
        let ahead = reader.ahead.borrow_mut().meshes.remove(key);
        let MeshFile { mesh, extension } = ahead.map_or_else(|| decode(key, &place), Ok)?;
        if let Some(extension) = extension {
            reader.extension(&place, extension.to_owned());
        }
        Ok(mesh)
    })
}

/// The mesh of a file that a scene names at `place`.
pub(super) fn decode(key: &MeshKey, place: &Place) -> Result<MeshFile, SceneError> {
    let bytes = files::read(&key.path, LARGEST_MESH_FILE, place)?;
    let options = |flip_tex_coords| MeshOptions { face_normals: key.face_normals, flip_tex_coords };
    let file = match key.format {
        MeshFormat::Obj { flip_tex_coords } => obj::read(&bytes, options(flip_tex_coords)),
        MeshFormat::Ply { flip_tex_coords } => ply::read(&bytes, options(flip_tex_coords)),
        MeshFormat::Serialized { shape_index } => serialized::read(&bytes, shape_index, options(false)),
    };
    let made = file.and_then(|file| match file.mesh.indices.len() {
        0 => Err(MeshError::new("The mesh has no triangles", "expected at least one face")),
        _ => Ok(file),
    });
    made.map_err(|error| error.at(&key.path, place))
}

/// What is wrong with a mesh file, where in it, and what was expected.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MeshError {
    problem: String,
    expected: String,
    position: Option<Position>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Position {
    Line(usize),
    Byte(usize),
}

impl MeshError {
    pub fn new(problem: impl Into<String>, expected: impl Into<String>) -> Self {
        Self { problem: problem.into(), expected: expected.into(), position: None }
    }

    pub fn on(mut self, position: Position) -> Self {
        self.position.get_or_insert(position);
        self
    }

    fn at(self, path: &Path, place: &Place) -> SceneError {
        let position = match self.position {
            Some(Position::Line(line)) => format!(":{line}"),
            Some(Position::Byte(byte)) => format!(" at byte {byte}"),
            None => String::new(),
        };
        SceneError::at(
            place,
            format!("{} ({}{position})", self.problem, path.display()),
            "this mesh file is wrong",
        )
        .with_remedy(self.expected)
    }
}

/// What a mesh file holds.
#[derive(Debug)]
pub(super) struct MeshFile {
    pub mesh: MeshData,
    /// The part of it that Mitsuba 3 would refuse.
    pub extension: Option<&'static str>,
}

/// What the mesh readers return.
pub(super) type MeshResult = Result<MeshFile, MeshError>;

#[cfg(test)]
mod tests;
