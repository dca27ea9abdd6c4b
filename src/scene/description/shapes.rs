//! Shapes, solids, groups and motion as a scene file says them.

use super::materials::Bsdf;
use super::media::Medium;
use super::spectra::SpectrumSource;
use crate::geometry::{Transform, Vec3};
use crate::scene::source::Place;
use crate::shape::solid::Operation;
use crate::shape::{
    ControlNet, ControlPoint, CurveKind, HeightData, MeshData, ProfileOrImplicitKind, QuadricKind, SdfData,
    Terrain,
};
use std::path::PathBuf;
use std::sync::Arc;

/// A shape with its material, its media and the light that it sends out.
#[derive(Clone, Debug)]
pub struct ShapeDescription {
    /// Where the file declares it.
    pub place: Place,
    /// Its `id`, by which the file refers to it.
    pub id: Option<String>,
    /// Which shape it is, with its parameters.
    pub kind: ShapeKind,
    /// For a moving shape the transform at its first keyframe; likewise for all that moves.
    pub to_world: Transform,
    /// How it moves while the shutter is open; `None` at rest.
    pub motion: Option<Arc<Animation>>,
    /// Whether its front is its back.
    pub flip_normals: bool,
    /// How it scatters light.
    pub bsdf: Arc<Bsdf>,
    /// Radiance of an area light on this surface.
    pub emission: Option<SpectrumSource>,
    /// The medium on its back.
    pub interior: Option<Medium>,
    /// The medium on its front.
    pub exterior: Option<Medium>,
    /// Which of several transparent bodies counts where they overlap: that of the highest (an extension). 0
    /// where it is left out.
    pub priority: Option<Priority>,
}

/// Which of overlapping transparent bodies counts: the highest.
#[derive(Clone, Debug)]
pub struct Priority {
    /// Where the file states it.
    pub place: Place,
    /// The number: of bodies that overlap, the one with the highest counts.
    pub value: i32,
}

/// The geometry of a shape in its own coordinates.
#[derive(Clone, Debug)]
pub enum ShapeKind {
    /// `sphere`.
    Sphere {
        /// Centre, in its own coordinates.
        centre: Vec3,
        /// Radius, in its own coordinates. Above 0.
        radius: f64,
    },
    /// `rectangle`: x and y from −1 to 1 at z = 0, its front toward +z.
    Rectangle,
    /// `disk`: of radius 1 at z = 0, its front toward +z.
    Disk,
    /// `cube`: from −1 to 1 along each axis.
    Cube,
    /// `cylinder`: open at both ends.
    Cylinder {
        /// One end of the axis, in its own coordinates.
        from: Vec3,
        /// The other end.
        to: Vec3,
        /// Radius, in its own coordinates. Above 0.
        radius: f64,
    },
    /// `cone`, `paraboloid`, `hyperboloid` and `quadric` (extensions).
    Quadric {
        /// Which quadric it is, with its parameters.
        kind: QuadricKind,
        /// Whether it is closed where it is cut off.
        capped: bool,
    },
    /// A torus around z (an extension).
    Torus {
        /// From the centre to the middle of the tube. Above `minor_radius`.
        major_radius: f64,
        /// Radius of the tube. Above 0.
        minor_radius: f64,
    },
    /// `polygon`, `extrusion`, `revolution`, `superquadric` and `blobs` (extensions).
    ProfileOrImplicit(ProfileOrImplicitKind),
    /// `sdfgrid`.
    Distances {
        /// File of the grid, relative to the scene's folder.
        file: PathBuf,
        /// Its distances.
        data: Arc<SdfData>,
        /// Whether shading normals are smooth.
        smooth: bool,
    },
    /// `heightfield` (an extension).
    Heights {
        /// Where the heights come from.
        source: HeightSource,
        /// The heights.
        data: Arc<HeightData>,
        /// Factor on the heights.
        scale: f64,
        /// The height of the bottom of a body.
        base: Option<f64>,
        /// Whether shading normals are smooth.
        smooth: bool,
    },
    /// `linearcurve`, `bsplinecurve` and, `solid`, `sweptsphere` (an extension): in the file's own
    /// coordinates.
    Curves {
        /// File of the control points, relative to the scene's folder.
        file: PathBuf,
        /// How the points are joined.
        kind: CurveKind,
        /// Whether it is `sweptsphere`: a body with rounded ends.
        solid: bool,
        /// Control points of each curve.
        curves: Arc<Vec<Vec<ControlPoint>>>,
    },
    /// `bezierpatch` (an extension).
    Patches {
        /// Where they are from, unless they are written in the scene.
        file: Option<PathBuf>,
        /// Control points of each patch.
        patches: Arc<Vec<ControlNet>>,
    },
    /// `obj`, `ply` and `serialized`: in the file's own coordinates.
    Mesh {
        /// File of the mesh, relative to the scene's folder.
        file: PathBuf,
        /// Its format.
        format: MeshFormat,
        /// Deformed, if it is.
        mesh: Arc<MeshData>,
        /// What was done to it before, in the words of the scene file (an extension).
        deform: Option<String>,
        /// Whether vertex normals are to be computed once the mesh is placed: the file has none, and
        /// `face_normals` does not ask for flat triangles.
        compute_normals: bool,
    },
}

/// What a mesh file is written in, and how it is understood.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum MeshFormat {
    /// Wavefront OBJ.
    Obj {
        /// Whether v becomes 1 − v.
        flip_tex_coords: bool,
    },
    /// Stanford PLY.
    Ply {
        /// Whether v becomes 1 − v.
        flip_tex_coords: bool,
    },
    /// Mitsuba's own.
    Serialized {
        /// Which mesh of the file it is.
        shape_index: u32,
    },
}

/// Where the heights of a `heightfield` are from.
#[derive(Clone, Debug)]
pub enum HeightSource {
    /// A channel of an image.
    Image {
        /// File of the image, relative to the scene's folder.
        file: PathBuf,
        /// Which of its channels, counted from 0.
        channel: usize,
    },
    /// Written in the scene.
    List,
    /// Made by a formula.
    Terrain(Terrain),
}

/// A body joined or cut from closed shapes (an extension). What it says of its surface and media its leaves
/// say too.
#[derive(Clone, Debug)]
pub struct Solid {
    /// Where the file declares it.
    pub place: Place,
    /// Its `id`, by which the file refers to it.
    pub id: Option<String>,
    /// Union, intersection or difference.
    pub operation: Operation,
    /// In the order of the file: of a difference the first is what the others are cut from.
    pub parts: Vec<Part>,
    /// From its own coordinates to the scene's.
    pub to_world: Transform,
    /// How it moves while the shutter is open; `None` at rest.
    pub motion: Option<Arc<Animation>>,
}

/// What a solid is made of.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "nearly all are shapes")]
pub enum Part {
    /// A closed shape.
    Shape(ShapeDescription),
    /// Another solid.
    Solid(Solid),
}

impl Solid {
    /// The shapes that it is made of, in the order of the file.
    pub fn leaves(&self) -> Vec<&ShapeDescription> {
        let of_parts = self.parts.iter().map(|part| match part {
            Part::Shape(shape) => vec![shape],
            Part::Solid(solid) => solid.leaves(),
        });
        of_parts.flatten().collect()
    }
}

/// Shapes that stand nowhere by themselves, in coordinates of their own.
#[derive(Clone, Debug)]
pub struct ShapeGroup {
    /// Where the file declares it.
    pub place: Place,
    /// Its `id`, by which instances refer to it.
    pub id: Option<String>,
    /// Shapes that are no part of a solid.
    pub shapes: Vec<ShapeDescription>,
    /// Solids of the group.
    pub solids: Vec<Solid>,
    /// Other groups that this one shows (an extension). None of them shows this one.
    pub instances: Vec<Instance>,
}

/// A group of shapes where a transform puts it.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Where the file declares it.
    pub place: Place,
    /// Its `id`.
    pub id: Option<String>,
    /// What stands here.
    pub group: Arc<ShapeGroup>,
    /// From the group's coordinates to those around the instance.
    pub to_world: Transform,
    /// How it moves while the shutter is open; `None` at rest.
    pub motion: Option<Arc<Animation>>,
}

/// What `to_world` is at some times (an extension). See [`crate::geometry::Motion`].
#[derive(Clone, Debug)]
pub struct Animation {
    /// Where the file declares it.
    pub place: Place,
    /// Placements by time, in ascending order of time.
    pub keys: Vec<(f64, Transform)>,
}
