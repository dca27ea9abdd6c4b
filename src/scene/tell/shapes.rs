use super::super::description::{Medium, Shape, ShapeKind, SpectrumSource};
use super::super::info::hash_of_mesh;
use super::super::read::Class;
use super::{Teller, Told, Value, bsdfs};

pub(super) fn tell(teller: &mut Teller, shape: &Shape) -> Told {
    let told = |plugin| Told::new(Class::Shape, plugin, &shape.place).id(&shape.id);
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
        ShapeKind::Mesh { file, plugin, flip_tex_coords, mesh, compute_normals } => {
            let filename = Value::File {
                path: file.clone(),
                content: hash_of_mesh(mesh),
                summary: format!("{} triangles, {} vertices", mesh.indices.len(), mesh.positions.len()),
            };
            let told = told(plugin)
                .with("filename", filename)
                .boolean("face_normals", mesh.normals.is_none() && !compute_normals)
                .boolean("flip_tex_coords", *flip_tex_coords);
            match (&mesh.normals, compute_normals) {
                (Some(_), _) => told.remark("normals of the file"),
                (None, true) => told.remark("smooth normals, computed"),
                (None, false) => told,
            }
        }
    };
    let told = told
        .transform("to_world", &shape.to_world)
        .boolean("flip_normals", shape.flip_normals)
        .child(bsdfs::tell(teller, &shape.bsdf));
    let told = match &shape.emission {
        Some(radiance) => told.child(area(radiance)),
        None => told,
    };
    let told = match &shape.interior {
        Some(interior) => told.named("interior", medium(interior)),
        None => told,
    };
    match &shape.exterior {
        Some(exterior) => told.named("exterior", medium(exterior)),
        None => told,
    }
}

fn area(radiance: &SpectrumSource) -> Told {
    Told::new(Class::Emitter, "area", &radiance.place).spectrum("radiance", radiance)
}

pub(super) fn medium(medium: &Medium) -> Told {
    // The factor is told by itself: multiplied into the values it could round to others.
    let unscaled = SpectrumSource { scale: 1.0, ..medium.absorption.clone() };
    Told::new(Class::Medium, "homogeneous", &medium.place)
        .id(&medium.id)
        .spectrum("sigma_t", &unscaled)
        .float("scale", medium.absorption.scale)
        .float("albedo", 0.0)
}
