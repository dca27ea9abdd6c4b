use super::super::description::{
    HeightSource, Instance, Part, ShapeDescription, ShapeGroup, ShapeKind, Solid, SpectrumSource,
};
use super::super::info::{hash_of_curves, hash_of_mesh, hash_of_patches, hash_of_values};
use super::super::plugins::bsdfs;
use super::super::read::{Class, solids};
use super::{Node, Value, Writer, media};
use crate::shape::{
    Blob, CurveKind, FillRule, HeightData, Interpolation, Kernel, ProfileOrImplicitKind, QuadricKind, Sheets,
    Terrain,
};
use std::rc::Rc;
use std::sync::Arc;

pub(super) fn write(writer: &mut Writer, shape: &ShapeDescription) -> Node {
    let id = shape.id.clone().filter(|id| writer.shapes.insert(id.clone()));
    let node = |plugin| Node::new(Class::Shape, plugin, &shape.place).id(&id);
    let node = match &shape.kind {
        ShapeKind::Sphere { centre, radius } => {
            node("sphere").vector("center", *centre).float("radius", *radius)
        }
        ShapeKind::Rectangle => node("rectangle"),
        ShapeKind::Disk => node("disk"),
        ShapeKind::Cube => node("cube"),
        ShapeKind::Cylinder { from, to, radius } => {
            node("cylinder").vector("p0", *from).vector("p1", *to).float("radius", *radius)
        }
        ShapeKind::Quadric { kind, capped } => quadric(node, kind).boolean("capped", *capped),
        ShapeKind::Torus { major_radius, minor_radius } => {
            node("torus").float("major_radius", *major_radius).float("minor_radius", *minor_radius)
        }
        ShapeKind::ProfileOrImplicit(kind) => profile_or_implicit(node, kind),
        ShapeKind::Distances { file, data, smooth } => {
            let (points, values) = data.grid();
            let [x, y, z] = points;
            let filename = Value::File {
                path: file.clone(),
                content: hash_of_values(&[x, y, z, 1], values),
                summary: format!("{x} × {y} × {z} points"),
            };
            node("sdfgrid").with("filename", filename).text("normals", normals(*smooth))
        }
        ShapeKind::Heights { source, data, scale, base, smooth } => {
            let node = heights(node("heightfield"), source, data)
                .float("scale", *scale)
                .text("normals", normals(*smooth));
            match base {
                Some(base) => node.float("base", *base),
                None => node,
            }
        }
        ShapeKind::Curves { file, kind, solid, curves } => {
            let points = curves.iter().map(Vec::len).sum::<usize>();
            let filename = Value::File {
                path: file.clone(),
                content: hash_of_curves(curves),
                summary: format!("{} curves, {points} control points", curves.len()),
            };
            match (solid, kind) {
                (false, CurveKind::Linear) => node("linearcurve"),
                (false, CurveKind::BSpline) => node("bsplinecurve"),
                (true, CurveKind::Linear) => node("sweptsphere").text("interpolation", "linear"),
                (true, CurveKind::BSpline) => node("sweptsphere").text("interpolation", "bspline"),
            }
            .with("filename", filename)
        }
        ShapeKind::Patches { file: Some(file), patches } => {
            let filename = Value::File {
                path: file.clone(),
                content: hash_of_patches(patches),
                summary: format!("{} patches", patches.len()),
            };
            node("bezierpatch").with("filename", filename)
        }
        ShapeKind::Patches { file: None, patches } => {
            let all: Vec<[f64; 3]> = patches.iter().flatten().map(|point| point.to_array()).collect();
            node("bezierpatch").text("points", points(&all))
        }
        ShapeKind::Mesh { file, plugin, shape_index, flip_tex_coords, mesh, deform, compute_normals } => {
            let filename = Value::File {
                path: file.clone(),
                content: hash_of_mesh(mesh),
                summary: format!("{} triangles, {} vertices", mesh.indices.len(), mesh.positions.len()),
            };
            let node = node(plugin)
                .with("filename", filename)
                .boolean("face_normals", mesh.normals.is_none() && !compute_normals);
            let node = match *plugin {
                "serialized" => node.integer("shape_index", *shape_index),
                _ => node.boolean("flip_tex_coords", *flip_tex_coords),
            };
            let node = match deform {
                Some(deform) => node.text("deform", deform.clone()),
                None => node,
            };
            match (&mesh.normals, compute_normals) {
                (Some(_), _) => node.remark("normals of the file"),
                (None, true) => node.remark("smooth normals, computed"),
                (None, false) => node,
            }
        }
    };
    let node = node.placement(&shape.to_world, &shape.motion);
    // Mitsuba 3's curves don't know the word.
    let node = match shape.kind {
        ShapeKind::Curves { solid: false, .. } if !shape.flip_normals => node,
        _ => node.boolean("flip_normals", shape.flip_normals),
    };
    let node = node.child(bsdfs::node(&shape.bsdf, writer));
    let node = match &shape.emission {
        Some(radiance) => node.child(area(radiance)),
        None => node,
    };
    let node = match &shape.interior {
        Some(interior) => node.named("interior", media::write(interior)),
        None => node,
    };
    let node = match &shape.exterior {
        Some(exterior) => node.named("exterior", media::write(exterior)),
        None => node,
    };
    match &shape.priority {
        Some(priority) => node.integer("priority", priority.value),
        None => node,
    }
}

fn normals(smooth: bool) -> &'static str {
    if smooth { "smooth" } else { "analytic" }
}

fn heights(node: Node, source: &HeightSource, data: &HeightData) -> Node {
    let ([width, depth], values) = data.grid();
    match source {
        HeightSource::Image { file, channel } => {
            let filename = Value::File {
                path: file.clone(),
                content: hash_of_values(&[width, depth, 1], values),
                summary: format!("{width} × {depth} heights"),
            };
            node.with("filename", filename).integer("channel", *channel as i64)
        }
        HeightSource::List => {
            let values: Vec<f64> = values.iter().map(|&value| f64::from(value)).collect();
            node.numbers("heights", &values).integer("width", width as i64)
        }
        HeightSource::Terrain(Terrain { levels, hurst, seed }) => node
            .text("terrain", "spectral")
            .integer("levels", *levels)
            .float("hurst", *hurst)
            .integer("seed", *seed as i64),
    }
}

fn quadric(node: impl Fn(&'static str) -> Node, kind: &QuadricKind) -> Node {
    match kind {
        QuadricKind::Cone { from, to, radii: [radius, other] } => node("cone")
            .vector("p0", *from)
            .vector("p1", *to)
            .float("radius", *radius)
            .float("radius1", *other),
        QuadricKind::Paraboloid { from, to, radius } => {
            node("paraboloid").vector("p0", *from).vector("p1", *to).float("radius", *radius)
        }
        QuadricKind::Hyperboloid { sheets, radius, semi_axis, heights: [low, high] } => node("hyperboloid")
            .integer("sheets", if *sheets == Sheets::One { 1 } else { 2 })
            .float("radius", *radius)
            .float("semi_axis", *semi_axis)
            .float("zmin", *low)
            .float("zmax", *high),
        QuadricKind::General { coefficients, clip } => {
            let node = node("quadric").numbers("coefficients", coefficients);
            // Planes infinitely far away are left out: a file has no infinite numbers.
            [("min", "zmin", clip.min), ("max", "zmax", clip.max)].into_iter().fold(
                node,
                |node, (corner, plane, at)| match (at.x.is_finite(), at.z.is_finite()) {
                    (true, _) => node.vector(corner, at),
                    (false, true) => node.float(plane, at.z),
                    (false, false) => node,
                },
            )
        }
    }
}

fn profile_or_implicit(node: impl Fn(&'static str) -> Node, kind: &ProfileOrImplicitKind) -> Node {
    let outline = |node: Node, outline: &[Vec<[f64; 2]>], rule: &FillRule| {
        let contours: Vec<String> = outline.iter().map(|contour| points(contour)).collect();
        node.text("outline", contours.join("; ")).text(
            "rule",
            match rule {
                FillRule::EvenOdd => "evenodd",
                FillRule::Winding => "winding",
            },
        )
    };
    match kind {
        ProfileOrImplicitKind::Polygon { contours, rule } => outline(node("polygon"), contours, rule),
        ProfileOrImplicitKind::Extrusion { contours, rule, heights: [low, high], capped } => {
            outline(node("extrusion"), contours, rule)
                .float("zmin", *low)
                .float("zmax", *high)
                .boolean("capped", *capped)
        }
        ProfileOrImplicitKind::Revolution { profile, interpolation, closed, capped } => {
            let interpolation = match interpolation {
                Interpolation::Linear => "linear",
                Interpolation::Bezier => "bezier",
                Interpolation::BSpline => "bspline",
            };
            node("revolution")
                .text("profile", points(profile))
                .text("interpolation", interpolation)
                .boolean("closed", *closed)
                .boolean("capped", *capped)
        }
        ProfileOrImplicitKind::Blobs { blobs, kernel, threshold } => {
            let all = |number: fn(&Blob) -> f64| blobs.iter().map(number).collect::<Vec<f64>>();
            let centres: Vec<[f64; 3]> = blobs.iter().map(|blob| blob.centre.to_array()).collect();
            let kernel = match kernel {
                Kernel::Gaussian => "gaussian",
                Kernel::Metaball => "metaball",
                Kernel::Soft => "soft",
            };
            node("blobs")
                .text("centers", points(&centres))
                .numbers("radii", &all(|blob| blob.radius))
                .numbers("strengths", &all(|blob| blob.strength))
                .text("kernel", kernel)
                .float("threshold", *threshold)
        }
        ProfileOrImplicitKind::Superquadric { exponents: [e1, e2], semi_axes } => {
            node("superquadric").float("e1", *e1).float("e2", *e2).vector("semi_axes", *semi_axes)
        }
    }
}

/// As a file has them: the shortest numbers that read back as the same.
fn points<const N: usize>(points: &[[f64; N]]) -> String {
    let point = |point: &[f64; N]| point.map(|coordinate| coordinate.to_string()).join(" ");
    points.iter().map(point).collect::<Vec<_>>().join(", ")
}

pub(super) fn instance(writer: &mut Writer, instance: &Instance) -> Node {
    Node::new(Class::Shape, "instance", &instance.place)
        .id(&instance.id)
        .placement(&instance.to_world, &instance.motion)
        .child(group(writer, &instance.group))
}

pub(super) fn solid(writer: &mut Writer, solid: &Solid) -> Node {
    let node = Node::new(Class::Shape, solids::word(solid.operation), &solid.place)
        .id(&solid.id)
        .placement(&solid.to_world, &solid.motion);
    solid.parts.iter().fold(node, |node, part| match part {
        Part::Shape(shape) => node.child(write(writer, shape)),
        Part::Solid(part) => node.child(self::solid(writer, part)),
    })
}

fn group(writer: &mut Writer, group: &Arc<ShapeGroup>) -> Rc<Node> {
    if let Some(node) = writer.groups.get(&Arc::as_ptr(group)) {
        return node.clone();
    }
    let node = Node::new(Class::Shape, "shapegroup", &group.place).id(&group.id);
    let node = group.shapes.iter().fold(node, |node, shape| node.child(write(writer, shape)));
    let node = Rc::new(group.solids.iter().fold(node, |node, part| node.child(solid(writer, part))));
    writer.groups.insert(Arc::as_ptr(group), node.clone());
    node
}

fn area(radiance: &SpectrumSource) -> Node {
    Node::new(Class::Emitter, "area", &radiance.place).spectrum("radiance", radiance)
}
