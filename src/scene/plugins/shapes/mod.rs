//! Shapes.

mod curves;
mod deform;
mod grids;
pub(in crate::scene) mod meshes;
mod patches;
mod profiles;
mod quadrics;

use super::fields::{Boolean, Integer};
use super::{
    Declaration, Field, Ignored, Parameter, Range, Simple, Takes, boolean, bsdfs, declare, float, ignored,
    integer, lights, media, optional, vector,
};
use crate::geometry::Vec3;
use crate::scene::description::{Medium, MeshFormat, Priority, ShapeDescription, ShapeKind};
use crate::scene::read::solids::{self, Inherited};
use crate::scene::read::{Class, ObjectId, Query, Reader};
use crate::scene::source::SceneError;
use crate::scene::write::{Node, Writer};
use crate::shape::{CurveKind, ProfileOrImplicitKind, QuadricKind};
use std::sync::Arc;

declare! {
    Class::Shape => ShapeKind, common common;

    "sphere", "a sphere" => ShapeKind::Sphere { centre, radius } {
        centre: vector("center", Vec3::ZERO, "its centre"),
        radius: float("radius", 1.0, "its radius").positive(),
    };
    "rectangle", "the square from -1 to 1 in x and y, facing +z" => ShapeKind::Rectangle {} {} ignoring [FLAT];
    "disk", "the disk of radius 1 around the origin, facing +z" => ShapeKind::Disk {} {};
    "cube", "the cube from -1 to 1 in x, y and z" => ShapeKind::Cube {} {} ignoring [FLAT];
    "cylinder", "an open cylinder" => ShapeKind::Cylinder { from, to, radius } {
        (from, to): Axis,
        radius: float("radius", 1.0, "its radius").positive(),
    };
    "cone" extension "a quadric surface", "a cone, cut off where both ends have a radius; u goes around its axis, v along it, on caps both go across"
        => ShapeKind::Quadric { kind: QuadricKind::Cone { from, to, radii: [radius, other] }, capped } {
        (from, to): Axis,
        radius: float("radius", 1.0, "radius at `p0`").not_negative(),
        other: float("radius1", 0.0, "radius at `p1`").not_negative(),
        capped: quadrics::CAPPED,
    } then quadrics::finite;
    "paraboloid" extension "a quadric surface", "a paraboloid with its tip at `p0`; uv as of a cone"
        => ShapeKind::Quadric { kind: QuadricKind::Paraboloid { from, to, radius }, capped } {
        (from, to): Axis,
        radius: float("radius", 1.0, "radius of the rim around `p1`").positive(),
        capped: quadrics::CAPPED,
    } then quadrics::finite;
    "hyperboloid" extension "a quadric surface", "x² + y² = `radius`² (z² / `semi_axis`² ± 1); u goes around z, v along it, on caps both go across"
        => ShapeKind::Quadric {
            kind: QuadricKind::Hyperboloid { sheets, radius, semi_axis, heights: [low, high] }, capped
        } {
        sheets: quadrics::NumberOfSheets,
        radius: float("radius", 1.0, "radius of the waist").positive(),
        semi_axis: float("semi_axis", 1.0, "length along z in which it opens").positive(),
        low: float("zmin", -2.0, "where it is cut off below"),
        high: float("zmax", 2.0, "where it is cut off above"),
        capped: quadrics::CAPPED,
    } then quadrics::finite;
    "quadric" extension "a quadric surface", "the zeros of a polynomial of degree 2, cut off where they have no end; uv as of a hyperboloid"
        => ShapeKind::Quadric { kind: QuadricKind::General { coefficients, clip }, capped } {
        (coefficients, clip): quadrics::General,
        capped: quadrics::CAPPED,
    } then quadrics::finite;
    "torus" extension "a ring with a round tube", "a ring with a round tube; u goes around z, v around the tube"
        => ShapeKind::Torus { major_radius, minor_radius } {
        major_radius: float("major_radius", 1.0, "radius around z to the middle of the tube").positive(),
        minor_radius: float("minor_radius", 0.25, "radius of the tube").positive(),
    } then hollow;
    "obj", "a mesh in a Wavefront OBJ file"
        => ShapeKind::Mesh { file, format: MeshFormat::Obj { flip_tex_coords }, mesh, deform, compute_normals } {
        (file, mesh, compute_normals): meshes::MeshFile,
        flip_tex_coords: meshes::flip_tex_coords(true),
        deform: optional(deform::DEFORM),
    } then deform::deformed;
    "ply", "a mesh in a Stanford PLY file"
        => ShapeKind::Mesh { file, format: MeshFormat::Ply { flip_tex_coords }, mesh, deform, compute_normals } {
        (file, mesh, compute_normals): meshes::MeshFile,
        flip_tex_coords: meshes::flip_tex_coords(false),
        deform: optional(deform::DEFORM),
    } then deform::deformed;
    "serialized", "a mesh in a file of Mitsuba's own format"
        => ShapeKind::Mesh { file, format: MeshFormat::Serialized { shape_index }, mesh, deform, compute_normals } {
        (file, mesh, compute_normals): meshes::MeshFile,
        shape_index: meshes::SHAPE_INDEX,
        deform: optional(deform::DEFORM),
    } then deform::deformed;
    "sdfgrid", "the zeros of distances on a grid over the unit cube"
        => ShapeKind::Distances { file, data, smooth } {
        (file, data): grids::DistanceFile,
        smooth: grids::normals(true),
    };
    "heightfield" extension "heights over a square", "bilinear patches over the square from -1 to 1 in x and y, from an image, a list or a fractal"
        => ShapeKind::Heights { source, data, scale, base, smooth } {
        (source, data): grids::Heights,
        scale: float("scale", 1.0, "factor on the heights"),
        smooth: grids::normals(false),
        base: optional(float("base", 0.0, "height of a bottom, which makes it a body")),
    } then grids::above_base;
    "linearcurve", "round fibres along straight segments"
        => ShapeKind::Curves { file, kind: CurveKind::Linear, solid: false, curves } {
        (file, curves): curves::CurveFile(CurveKind::Linear),
    };
    "bsplinecurve", "round fibres along cubic B-splines"
        => ShapeKind::Curves { file, kind: CurveKind::BSpline, solid: false, curves } {
        (file, curves): curves::CurveFile(CurveKind::BSpline),
    };
    "sweptsphere" extension "what a ball passes along curves", "the closed body that a ball of changing radius passes along curves, which `to_world` scales too; u goes around, v along"
        => ShapeKind::Curves { file, kind, solid: true, curves } {
        (kind, file, curves): curves::AnyCurves,
    };
    "polygon" extension "a flat shape with any outline", "a flat shape in z = 0 with any outline, holes included; uv go across its box"
        => ShapeKind::ProfileOrImplicit(ProfileOrImplicitKind::Polygon { contours, rule }) {
        contours: profiles::OUTLINE,
        rule: profiles::RULE,
    } then profiles::solid;
    "extrusion" extension "a polygon swept along z", "a polygon swept along z; u goes along the contour, v up"
        => ShapeKind::ProfileOrImplicit(
            ProfileOrImplicitKind::Extrusion { contours, rule, heights: [low, high], capped }
        ) {
        contours: profiles::OUTLINE,
        rule: profiles::RULE,
        low: float("zmin", 0.0, "where it begins"),
        high: float("zmax", 1.0, "where it ends"),
        capped: quadrics::CAPPED,
    } then profiles::solid;
    "revolution" extension "a profile turned around z", "a profile turned around z; u goes around z, v along the profile"
        => ShapeKind::ProfileOrImplicit(
            ProfileOrImplicitKind::Revolution { profile, interpolation, closed, capped }
        ) {
        profile: profiles::PROFILE,
        interpolation: profiles::INTERPOLATION,
        closed: boolean("closed", false, "whether the end of the profile is joined to its beginning"),
        capped: boolean("capped", true, "whether disks close both ends otherwise"),
    } then profiles::solid;
    "superquadric" extension "an ellipsoid between box and octahedron",
        "(|x/a|^(2/e2) + |y/b|^(2/e2))^(e2/e1) + |z/c|^(2/e1) = 1; uv are the angles of its signed powers"
        => ShapeKind::ProfileOrImplicit(
            ProfileOrImplicitKind::Superquadric { exponents: [e1, e2], semi_axes }
        ) {
        e1: float("e1", 1.0, "exponent along z, from 0.001, a box, to 2, an octahedron").positive(),
        e2: float("e2", 1.0, "the same around z").positive(),
        semi_axes: vector("semi_axes", Vec3::ONE, "a, b and c"),
    } then profiles::solid;
    "blobs" extension "soft balls that flow together", "soft balls that flow together; uv is the direction from the mean of the centres"
        => ShapeKind::ProfileOrImplicit(ProfileOrImplicitKind::Blobs { blobs, kernel, threshold }) {
        blobs: profiles::Balls,
        kernel: profiles::KERNEL,
        threshold: float("threshold", 0.5, "what the densities sum up to on the surface").positive(),
    } then profiles::solid;
    "bezierpatch" extension "bicubic Bézier patches", "bicubic Bézier patches, each with its own uv; no part of a solid"
        => ShapeKind::Patches { file, patches } {
        (file, patches): patches::PatchSource,
    };
}

/// Rectangles and cubes are flat anyway.
const FLAT: Ignored = ignored("face_normals", Takes::Boolean, "").silent();

/// Only derivatives depend on it.
const SILHOUETTE: Ignored = ignored("silhouette_sampling_weight", Takes::Float(Range::ALL), "").silent();

const FLIP_NORMALS: Simple<Boolean> =
    boolean("flip_normals", false, "whether its inside becomes its outside");

const PRIORITY: Simple<Integer<i32>> = integer(
    "priority",
    0,
    [i32::MIN as i64, i32::MAX as i64],
    "where transparent bodies overlap, the one with the highest alone counts",
)
.extension("where transparent bodies overlap, the highest alone counts");

/// `to_world` of what may move.
fn placement() -> Parameter {
    let doc = "where it stands; an `<animation>` moves it";
    Parameter { doc, ..Parameter::new("to_world", Takes::Placement) }
}

/// What every shape takes.
fn common() -> Vec<Parameter> {
    let held = |name, element, doc| Parameter { doc, ..Parameter::new(name, Takes::Object(element)) };
    [
        vec![placement()],
        FLIP_NORMALS.parameters(),
        vec![
            held("", "bsdf", "what its surface is made of; otherwise `diffuse`"),
            held("", "emitter", "an `area` light: what its surface sends out"),
            held("", "sensor", "an `irradiancemeter` that measures on it"),
            held("interior", "medium", "what is inside"),
            held("exterior", "medium", "what is outside"),
        ],
        PRIORITY.parameters(),
        vec![SILHOUETTE.parameter()],
    ]
    .concat()
}

/// The shapes that are made of shapes, which `read::solids` and `read::groups` read.
const STRUCTURES: [(&str, bool, &str, &str); 6] = [
    (
        "union",
        true,
        "the body that is in any of some closed shapes",
        "the shapes; `bsdf`, medium and priority of the union are theirs unless they have their own",
    ),
    ("intersection", true, "the body that is in all of some closed shapes", "the shapes"),
    ("difference", true, "the first of some closed shapes less all others", "the shapes"),
    ("merge", false, "shapes that are written together", "the shapes"),
    (
        "shapegroup",
        false,
        "shapes that are shown by instances",
        "the shapes; instances of other groups, lights and what moves too (extensions)",
    ),
    ("instance", false, "a shapegroup where a transform puts it", "the shapegroup"),
];

/// The names of all shapes, those made of shapes last.
pub fn names() -> Vec<&'static str> {
    NAMES.iter().copied().chain(STRUCTURES.map(|(name, ..)| name)).collect()
}

/// All shapes, those made of shapes last.
pub fn all() -> Vec<Declaration> {
    let structures = STRUCTURES.map(|(name, is_extension, doc, held)| {
        let shapes = Parameter { doc: held, is_required: true, ..Parameter::new("", Takes::Object("shape")) };
        let placed = !["merge", "shapegroup"].contains(&name);
        let parameters = placed.then(placement).into_iter().chain([shapes]).collect();
        Declaration { element: Class::Shape.word(), name, doc, is_extension, parameters, common: Vec::new() }
    });
    declarations().into_iter().chain(structures).collect()
}

/// Both ends of what has an axis.
struct Axis;

impl Field for Axis {
    type Value = (Vec3, Vec3);

    fn parameters(&self) -> Vec<Parameter> {
        [Self::FROM.parameters(), Self::TO.parameters()].concat()
    }

    fn read(&self, query: &Query<'_>) -> Option<(Vec3, Vec3)> {
        let (from, to) = (Self::FROM.read(query)?, Self::TO.read(query)?);
        if from == to {
            query.error(SceneError::at(
                &query.place("p1"),
                format!("The {} has no length", query.object.plugin),
                "expected p0 and p1 to differ",
            ));
        }
        Some((from, to))
    }

    fn write(&self, node: Node, (from, to): &(Vec3, Vec3), writer: &mut Writer) -> Node {
        Self::TO.write(Self::FROM.write(node, from, writer), to, writer)
    }
}

impl Axis {
    const FROM: Simple<super::fields::Vector> = vector("p0", Vec3::ZERO, "one end of its axis");
    const TO: Simple<super::fields::Vector> = vector("p1", Vec3::Z, "the other end");
}

/// Refuses a torus without a hole.
fn hollow(query: &Query<'_>, shape: ShapeKind) -> Option<ShapeKind> {
    if let ShapeKind::Torus { major_radius, minor_radius } = &shape
        && minor_radius >= major_radius
    {
        let problem = format!("The tube of the torus has the radius {minor_radius}, its ring {major_radius}");
        let error =
            SceneError::at(&query.place("minor_radius"), problem, "expected minor_radius below major_radius");
        query.error(error.with_remedy("major_radius is measured to the middle of the tube"));
    }
    Some(shape)
}

/// `None` where the shape is wrong, which is reported.
pub fn of_scene(reader: &Reader, id: ObjectId) -> Option<ShapeDescription> {
    let query = Query::new(reader, id);
    // It is read with the scene's other sensors.
    query.object(Class::Sensor);
    one(query, &Inherited::default())
}

/// A part of a solid.
pub fn of_solid(reader: &Reader, id: ObjectId, around: &Inherited) -> Option<ShapeDescription> {
    one(Query::new(reader, id), around)
}

fn one(query: Query<'_>, around: &Inherited) -> Option<ShapeDescription> {
    let reader = query.reader;
    let object = query.object;
    if solids::operation(&object.plugin).is_some() {
        solids::refuse_sensor(&query);
        return None;
    }
    let kind = read(&query);
    if !NAMES.contains(&object.plugin.as_str()) {
        return None;
    }
    let (to_world, motion) = query.placement();
    let flip_normals = FLIP_NORMALS.read(&query)?;
    SILHOUETTE.read(&query);
    let emitter = query.object(Class::Emitter);
    let emission = emitter.and_then(|(_, id)| lights::of_shape(reader, id));
    let bsdf = match (query.object(Class::Bsdf), &around.bsdf) {
        (Some((_, id)), _) => bsdfs::read_once(reader, id),
        (None, Some(inherited)) => Arc::clone(inherited),
        (None, None) => bsdfs::default(&object.place, emitter.is_some()),
    };
    let [interior, exterior] = media(&query);
    // Where light doesn't get in, it is not asked what is there.
    let [inside, outside] = if bsdf.kind.transmits() { around.media.clone() } else { [None, None] };
    let priority = priority(&query).or_else(|| around.priority.clone());
    query.finish();
    Some(ShapeDescription {
        place: object.place.clone(),
        id: object.id.clone(),
        kind: kind?,
        to_world,
        motion,
        flip_normals,
        bsdf,
        emission,
        interior: interior.or(inside),
        exterior: exterior.or(outside),
        priority,
    })
}

/// Writes a shape with all that stands in it.
pub fn node(shape: &ShapeDescription, writer: &mut Writer) -> Node {
    let id = shape.id.clone().filter(|id| writer.shapes.insert(id.clone()));
    let node = write(&shape.kind, &shape.place, writer).id(&id).placement(&shape.to_world, &shape.motion);
    // Mitsuba 3's curves and grids of distances don't know the word.
    let node = match shape.kind {
        ShapeKind::Curves { solid: false, .. } | ShapeKind::Distances { .. } if !shape.flip_normals => node,
        _ => FLIP_NORMALS.write(node, &shape.flip_normals, writer),
    };
    let node = node.child(bsdfs::node(&shape.bsdf, writer));
    let node = match &shape.emission {
        Some(radiance) => node.child(lights::surface_node(radiance, writer)),
        None => node,
    };
    let sides = [("interior", &shape.interior), ("exterior", &shape.exterior)];
    let node = sides.into_iter().fold(node, |node, (name, medium)| match medium {
        Some(medium) => node.named(name, media::node(medium, writer)),
        None => node,
    });
    optional(PRIORITY).write(node, &shape.priority.as_ref().map(|priority| priority.value), writer)
}

/// Which of several bodies counts.
pub fn priority(query: &Query<'_>) -> Option<Priority> {
    let value = optional(PRIORITY).read(query)??;
    Some(Priority { place: query.place("priority"), value })
}

/// The media inside and outside.
pub fn media(query: &Query<'_>) -> [Option<Medium>; 2] {
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
        sides[side] = media::of_object(query.reader, id);
    }
    sides
}
