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
    pub place: Place,
    pub id: Option<String>,
    pub kind: ShapeKind,
    /// For a moving shape the transform at its first keyframe; likewise for all that moves.
    pub to_world: Transform,
    pub motion: Option<Arc<Animation>>,
    pub flip_normals: bool,
    pub bsdf: Arc<Bsdf>,
    /// Radiance of an area light on this surface.
    pub emission: Option<SpectrumSource>,
    pub interior: Option<Medium>,
    pub exterior: Option<Medium>,
    /// Which of several transparent bodies counts where they overlap: that of the highest (an extension). 0
    /// where it is left out.
    pub priority: Option<Priority>,
}

/// Which of overlapping transparent bodies counts: the highest.
#[derive(Clone, Debug)]
pub struct Priority {
    pub place: Place,
    pub value: i32,
}

/// The geometry of a shape in its own coordinates.
#[derive(Clone, Debug)]
pub enum ShapeKind {
    Sphere {
        centre: Vec3,
        radius: f64,
    },
    Rectangle,
    Disk,
    Cube,
    Cylinder {
        from: Vec3,
        to: Vec3,
        radius: f64,
    },
    /// `cone`, `paraboloid`, `hyperboloid` and `quadric` (extensions).
    Quadric {
        kind: QuadricKind,
        /// Whether it is closed where it is cut off.
        capped: bool,
    },
    /// A torus around z (an extension).
    Torus {
        major_radius: f64,
        minor_radius: f64,
    },
    /// `polygon`, `extrusion`, `revolution`, `superquadric` and `blobs` (extensions).
    ProfileOrImplicit(ProfileOrImplicitKind),
    /// `sdfgrid`.
    Distances {
        file: PathBuf,
        data: Arc<SdfData>,
        /// Whether shading normals are smooth.
        smooth: bool,
    },
    /// `heightfield` (an extension).
    Heights {
        source: HeightSource,
        data: Arc<HeightData>,
        scale: f64,
        /// The height of the bottom of a body.
        base: Option<f64>,
        /// Whether shading normals are smooth.
        smooth: bool,
    },
    /// `linearcurve`, `bsplinecurve` and, `solid`, `sweptsphere` (an extension): in the file's own
    /// coordinates.
    Curves {
        file: PathBuf,
        kind: CurveKind,
        solid: bool,
        curves: Arc<Vec<Vec<ControlPoint>>>,
    },
    /// `bezierpatch` (an extension).
    Patches {
        /// Where they are from, unless they are written in the scene.
        file: Option<PathBuf>,
        patches: Arc<Vec<ControlNet>>,
    },
    /// `obj`, `ply` and `serialized`: in the file's own coordinates.
    Mesh {
        file: PathBuf,
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
        file: PathBuf,
        channel: usize,
    },
    /// Written in the scene.
    List,
    Terrain(Terrain),
}

/// A body joined or cut from closed shapes (an extension). What it says of its surface and media its leaves
/// say too.
#[derive(Clone, Debug)]
pub struct Solid {
    pub place: Place,
    pub id: Option<String>,
    pub operation: Operation,
    /// In the order of the file: of a difference the first is what the others are cut from.
    pub parts: Vec<Part>,
    pub to_world: Transform,
    pub motion: Option<Arc<Animation>>,
}

/// What a solid is made of.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "nearly all are shapes")]
pub enum Part {
    Shape(ShapeDescription),
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
    pub place: Place,
    pub id: Option<String>,
    pub shapes: Vec<ShapeDescription>,
    pub solids: Vec<Solid>,
    /// Other groups that this one shows (an extension). None of them shows this one.
    pub instances: Vec<Instance>,
}

/// A group of shapes where a transform puts it.
#[derive(Clone, Debug)]
pub struct Instance {
    pub place: Place,
    pub id: Option<String>,
    pub group: Arc<ShapeGroup>,
    pub to_world: Transform,
    pub motion: Option<Arc<Animation>>,
}

/// What `to_world` is at some times (an extension). See [`crate::geometry::Motion`].
#[derive(Clone, Debug)]
pub struct Animation {
    pub place: Place,
    pub keys: Vec<(f64, Transform)>,
}
