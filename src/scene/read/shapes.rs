//! Shapes.

use super::super::description::{Medium, Shape, ShapeKind};
use super::super::source::SceneError;
use super::query::Query;
use super::spectra::required;
use super::tree::{Class, ObjectId};
use super::{Reader, bsdfs, files, lights, media, obj, ply};
use crate::geometry::Vec3;
use crate::shape::MeshData;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A larger mesh file would not fit the 32-bit indices of what is made from it.
const LARGEST_MESH_FILE: u64 = 16 << 30;

/// `None` where the shape is wrong, which is reported.
pub(super) fn read(reader: &Reader, id: ObjectId) -> Option<Shape> {
    let query = Query::new(reader, id);
    let object = query.object;
    let kind = match object.plugin.as_str() {
        "sphere" => Some(ShapeKind::Sphere {
            centre: query.vector("center").unwrap_or(Vec3::ZERO),
            radius: query.positive("radius", 1.0),
        }),
        "rectangle" => Some(ShapeKind::Rectangle),
        "disk" => Some(ShapeKind::Disk),
        "cube" => Some(ShapeKind::Cube),
        "cylinder" => Some(cylinder(&query)),
        "obj" | "ply" => mesh(&query),
        _ => {
            reader.unknown_plugin(object);
            return None;
        }
    };
    let to_world = query.transform("to_world");
    let flip_normals = query.boolean("flip_normals", false);
    let emitter = query.object(Class::Emitter);
    let emission = emitter.and_then(|(_, id)| lights::area(reader, id));
    let bsdf = match query.object(Class::Bsdf) {
        Some((_, id)) => bsdfs::read(reader, id),
        None => bsdfs::default(&object.place, emitter.is_some()),
    };
    let [interior, exterior] = media(&query);
    query.finish();
    Some(Shape {
        place: object.place.clone(),
        id: object.id.clone(),
        kind: kind?,
        to_world,
        flip_normals,
        bsdf,
        emission,
        interior,
        exterior,
    })
}

fn cylinder(query: &Query<'_>) -> ShapeKind {
    let from = query.vector("p0").unwrap_or(Vec3::ZERO);
    let to = query.vector("p1").unwrap_or(Vec3::Z);
    if from == to {
        query.error(SceneError::at(
            &query.place("p1"),
            "The cylinder has no length",
            "expected p0 and p1 to differ",
        ));
    }
    ShapeKind::Cylinder { from, to, radius: query.positive("radius", 1.0) }
}

/// The media inside and outside.
fn media(query: &Query<'_>) -> [Option<Medium>; 2] {
    let mut sides = [None, None];
    for (entry, id) in query.objects(Class::Medium) {
        let side = match entry.name.as_deref() {
            Some("interior") => 0,
            Some("exterior") => 1,
            name => {
                let problem = match name {
                    Some(name) => format!("The medium is named \"{name}\", which Mitsuba 3 would ignore"),
                    None => "The medium has no name, so that Mitsuba 3 would ignore it".to_owned(),
                };
                let expected = "expected name=\"interior\" or name=\"exterior\"";
                query.error(SceneError::at(&entry.place, problem, expected));
                continue;
            }
        };
        sides[side] = media::read(query.reader, id);
    }
    sides
}

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
pub(super) struct MeshKey {
    path: PathBuf,
    is_obj: bool,
    options: MeshOptions,
}

fn mesh(query: &Query<'_>) -> Option<ShapeKind> {
    let is_obj = query.object.plugin == "obj";
    let filename = required(query, "filename", query.text("filename"));
    let options = MeshOptions {
        face_normals: query.boolean("face_normals", false),
        flip_tex_coords: query.boolean("flip_tex_coords", is_obj),
    };
    let path = query.reader.search.find(filename?);
    let key = MeshKey { path: path.clone(), is_obj, options };
    let known = query.reader.meshes.borrow().get(&key).cloned();
    let mesh = known.unwrap_or_else(|| {
        let mesh = load(query, &path, is_obj, options).map(Arc::new);
        query.reader.meshes.borrow_mut().insert(key, mesh.clone());
        mesh
    })?;
    let compute_normals = mesh.normals.is_none() && !options.face_normals;
    Some(ShapeKind::Mesh {
        file: path,
        plugin: if is_obj { "obj" } else { "ply" },
        flip_tex_coords: options.flip_tex_coords,
        mesh,
        compute_normals,
    })
}

fn load(query: &Query<'_>, path: &Path, is_obj: bool, options: MeshOptions) -> Option<MeshData> {
    let place = query.place("filename");
    let bytes = match files::read(path, LARGEST_MESH_FILE, &place) {
        Ok(bytes) => bytes,
        Err(error) => {
            query.error(error);
            return None;
        }
    };
    let read = if is_obj { obj::read(&bytes, options) } else { ply::read(&bytes, options) };
    let made = read.and_then(|file| match file.mesh.indices.len() {
        0 => Err(MeshError::new("The mesh has no triangles", "expected at least one face")),
        _ => Ok(file),
    });
    match made {
        Ok(MeshFile { mesh, extension }) => {
            if let Some(extension) = extension {
                query.reader.extension(&place, extension.to_owned());
            }
            Some(mesh)
        }
        Err(error) => {
            query.error(error.at(path, &place));
            None
        }
    }
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

    fn at(self, path: &Path, place: &super::super::source::Place) -> SceneError {
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
    /// What of it Mitsuba 3 would refuse.
    pub extension: Option<&'static str>,
}

/// What the mesh readers return.
pub(super) type MeshResult = Result<MeshFile, MeshError>;
