use super::super::description::{
    HeightSource, Instance, Part, Shape, ShapeGroup, ShapeKind, Solid, SpectrumSource,
};
use super::super::info::{hash_of_curves, hash_of_mesh, hash_of_patches, hash_of_values};
use super::super::read::{Class, solids};
use super::{Teller, Told, Value, bsdfs, media};
use crate::shape::{
    Blob, CurveKind, FigureKind, FillRule, HeightData, Interpolation, Kernel, QuadricKind, Sheets, Terrain,
};
use std::rc::Rc;
use std::sync::Arc;

pub(super) fn tell(teller: &mut Teller, shape: &Shape) -> Told {
    let id = shape.id.clone().filter(|id| teller.shapes.insert(id.clone()));
    let told = |plugin| Told::new(Class::Shape, plugin, &shape.place).id(&id);
    let told = match &shape.kind {
        ShapeKind::Sphere { centre, radius } => {
            told("sphere").vector("center", *centre).float("radius", *radius)
        }
        ShapeKind::Rectangle => told("rectangle"),
        ShapeKind::Disk => told("disk"),
        ShapeKind::Cube => told("cube"),
        ShapeKind::Cylinder { from, to, radius } => {
            told("cylinder").vector("p0", *from).vector("p1", *to).float("radius", *radius)
        }
        ShapeKind::Quadric { kind, capped } => quadric(told, kind).boolean("capped", *capped),
        ShapeKind::Torus { major_radius, minor_radius } => {
            told("torus").float("major_radius", *major_radius).float("minor_radius", *minor_radius)
        }
        ShapeKind::Figure(kind) => figure(told, kind),
        ShapeKind::Distances { file, data, smooth } => {
            let (points, values) = data.grid();
            let [x, y, z] = points;
            let filename = Value::File {
                path: file.clone(),
                content: hash_of_values(&[x, y, z, 1], values),
                summary: format!("{x} × {y} × {z} points"),
            };
            told("sdfgrid").with("filename", filename).text("normals", normals(*smooth))
        }
        ShapeKind::Heights { source, data, scale, base, smooth } => {
            let told = heights(told("heightfield"), source, data)
                .float("scale", *scale)
                .text("normals", normals(*smooth));
            match base {
                Some(base) => told.float("base", *base),
                None => told,
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
                (false, CurveKind::Linear) => told("linearcurve"),
                (false, CurveKind::BSpline) => told("bsplinecurve"),
                (true, CurveKind::Linear) => told("sweptsphere").text("interpolation", "linear"),
                (true, CurveKind::BSpline) => told("sweptsphere").text("interpolation", "bspline"),
            }
            .with("filename", filename)
        }
        ShapeKind::Patches { file: Some(file), patches } => {
            let filename = Value::File {
                path: file.clone(),
                content: hash_of_patches(patches),
                summary: format!("{} patches", patches.len()),
            };
            told("bezierpatch").with("filename", filename)
        }
        ShapeKind::Patches { file: None, patches } => {
            let all: Vec<[f64; 3]> = patches.iter().flatten().map(|point| point.to_array()).collect();
            told("bezierpatch").text("points", points(&all))
        }
        ShapeKind::Mesh { file, plugin, shape_index, flip_tex_coords, mesh, deform, compute_normals } => {
            let filename = Value::File {
                path: file.clone(),
                content: hash_of_mesh(mesh),
                summary: format!("{} triangles, {} vertices", mesh.indices.len(), mesh.positions.len()),
            };
            let told = told(plugin)
                .with("filename", filename)
                .boolean("face_normals", mesh.normals.is_none() && !compute_normals);
            let told = match *plugin {
                "serialized" => told.integer("shape_index", *shape_index),
                _ => told.boolean("flip_tex_coords", *flip_tex_coords),
            };
            let told = match deform {
                Some(deform) => told.text("deform", deform.clone()),
                None => told,
            };
            match (&mesh.normals, compute_normals) {
                (Some(_), _) => told.remark("normals of the file"),
                (None, true) => told.remark("smooth normals, computed"),
                (None, false) => told,
            }
        }
    };
    let told = told.placement(&shape.to_world, &shape.motion);
    // Mitsuba 3's curves don't know the word.
    let told = match shape.kind {
        ShapeKind::Curves { solid: false, .. } if !shape.flip_normals => told,
        _ => told.boolean("flip_normals", shape.flip_normals),
    };
    let told = told.child(bsdfs::tell(teller, &shape.bsdf));
    let told = match &shape.emission {
        Some(radiance) => told.child(area(radiance)),
        None => told,
    };
    let told = match &shape.interior {
        Some(interior) => told.named("interior", media::tell(interior)),
        None => told,
    };
    let told = match &shape.exterior {
        Some(exterior) => told.named("exterior", media::tell(exterior)),
        None => told,
    };
    match &shape.priority {
        Some(priority) => told.integer("priority", priority.value),
        None => told,
    }
}

fn normals(smooth: bool) -> &'static str {
    if smooth { "smooth" } else { "analytic" }
}

fn heights(told: Told, source: &HeightSource, data: &HeightData) -> Told {
    let ([width, depth], values) = data.grid();
    match source {
        HeightSource::Image { file, channel } => {
            let filename = Value::File {
                path: file.clone(),
                content: hash_of_values(&[width, depth, 1], values),
                summary: format!("{width} × {depth} heights"),
            };
            told.with("filename", filename).integer("channel", *channel as i64)
        }
        HeightSource::List => {
            let values: Vec<f64> = values.iter().map(|&value| f64::from(value)).collect();
            told.numbers("heights", &values).integer("width", width as i64)
        }
        HeightSource::Terrain(Terrain { levels, hurst, seed }) => told
            .text("terrain", "spectral")
            .integer("levels", *levels)
            .float("hurst", *hurst)
            .integer("seed", *seed as i64),
    }
}

fn quadric(told: impl Fn(&'static str) -> Told, kind: &QuadricKind) -> Told {
    match kind {
        QuadricKind::Cone { from, to, radii: [radius, other] } => told("cone")
            .vector("p0", *from)
            .vector("p1", *to)
            .float("radius", *radius)
            .float("radius1", *other),
        QuadricKind::Paraboloid { from, to, radius } => {
            told("paraboloid").vector("p0", *from).vector("p1", *to).float("radius", *radius)
        }
        QuadricKind::Hyperboloid { sheets, radius, semi_axis, heights: [low, high] } => told("hyperboloid")
            .integer("sheets", if *sheets == Sheets::One { 1 } else { 2 })
            .float("radius", *radius)
            .float("semi_axis", *semi_axis)
            .float("zmin", *low)
            .float("zmax", *high),
        QuadricKind::General { coefficients, clip } => {
            let told = told("quadric").numbers("coefficients", coefficients);
            // Planes infinitely far away are left out: a file has no infinite numbers.
            [("min", "zmin", clip.min), ("max", "zmax", clip.max)].into_iter().fold(
                told,
                |told, (corner, plane, at)| match (at.x.is_finite(), at.z.is_finite()) {
                    (true, _) => told.vector(corner, at),
                    (false, true) => told.float(plane, at.z),
                    (false, false) => told,
                },
            )
        }
    }
}

fn figure(told: impl Fn(&'static str) -> Told, kind: &FigureKind) -> Told {
    let outline = |told: Told, outline: &[Vec<[f64; 2]>], rule: &FillRule| {
        let contours: Vec<String> = outline.iter().map(|contour| points(contour)).collect();
        told.text("outline", contours.join("; ")).text(
            "rule",
            match rule {
                FillRule::EvenOdd => "evenodd",
                FillRule::Winding => "winding",
            },
        )
    };
    match kind {
        FigureKind::Polygon { contours, rule } => outline(told("polygon"), contours, rule),
        FigureKind::Extrusion { contours, rule, heights: [low, high], capped } => {
            outline(told("extrusion"), contours, rule)
                .float("zmin", *low)
                .float("zmax", *high)
                .boolean("capped", *capped)
        }
        FigureKind::Revolution { profile, interpolation, closed, capped } => {
            let interpolation = match interpolation {
                Interpolation::Linear => "linear",
                Interpolation::Bezier => "bezier",
                Interpolation::BSpline => "bspline",
            };
            told("revolution")
                .text("profile", points(profile))
                .text("interpolation", interpolation)
                .boolean("closed", *closed)
                .boolean("capped", *capped)
        }
        FigureKind::Blobs { blobs, kernel, threshold } => {
            let all = |number: fn(&Blob) -> f64| blobs.iter().map(number).collect::<Vec<f64>>();
            let centres: Vec<[f64; 3]> = blobs.iter().map(|blob| blob.centre.to_array()).collect();
            let kernel = match kernel {
                Kernel::Gaussian => "gaussian",
                Kernel::Metaball => "metaball",
                Kernel::Soft => "soft",
            };
            told("blobs")
                .text("centers", points(&centres))
                .numbers("radii", &all(|blob| blob.radius))
                .numbers("strengths", &all(|blob| blob.strength))
                .text("kernel", kernel)
                .float("threshold", *threshold)
        }
        FigureKind::Superquadric { exponents: [e1, e2], semi_axes } => {
            told("superquadric").float("e1", *e1).float("e2", *e2).vector("semi_axes", *semi_axes)
        }
    }
}

/// As a file has them: the shortest numbers that read back as the same.
fn points<const N: usize>(points: &[[f64; N]]) -> String {
    let point = |point: &[f64; N]| point.map(|coordinate| coordinate.to_string()).join(" ");
    points.iter().map(point).collect::<Vec<_>>().join(", ")
}

pub(super) fn instance(teller: &mut Teller, instance: &Instance) -> Told {
    Told::new(Class::Shape, "instance", &instance.place)
        .id(&instance.id)
        .placement(&instance.to_world, &instance.motion)
        .child(group(teller, &instance.group))
}

pub(super) fn solid(teller: &mut Teller, solid: &Solid) -> Told {
    let told = Told::new(Class::Shape, solids::word(solid.operation), &solid.place)
        .id(&solid.id)
        .placement(&solid.to_world, &solid.motion);
    solid.parts.iter().fold(told, |told, part| match part {
        Part::Shape(shape) => told.child(tell(teller, shape)),
        Part::Solid(part) => told.child(self::solid(teller, part)),
    })
}

fn group(teller: &mut Teller, group: &Arc<ShapeGroup>) -> Rc<Told> {
    if let Some(told) = teller.groups.get(&Arc::as_ptr(group)) {
        return told.clone();
    }
    let told = Told::new(Class::Shape, "shapegroup", &group.place).id(&group.id);
    let told = group.shapes.iter().fold(told, |told, shape| told.child(tell(teller, shape)));
    let told = Rc::new(group.solids.iter().fold(told, |told, part| told.child(solid(teller, part))));
    teller.groups.insert(Arc::as_ptr(group), told.clone());
    told
}

fn area(radiance: &SpectrumSource) -> Told {
    Told::new(Class::Emitter, "area", &radiance.place).spectrum("radiance", radiance)
}
