//! Shapes where their transforms put them.

use crate::geometry::{Bounds, Transform};
use crate::scene::description::{ShapeDescription, ShapeKind};
use crate::shape::{
    self, Curves, Cylinder, Disk, FARTHEST, GridShape, HeightField, Mesh, MeshData, Patches,
    ProfileOrImplicit, Quadric, SdfGrid, ShapeError, Sphere, SweptSphere, Torus, compute_vertex_normals,
};
use glam::DMat3;

/// A shape in coordinates to which a transform takes its own. As a part of a solid it is not rounded to
/// single precision.
pub(in crate::scene) fn place(
    shape: &ShapeDescription,
    to_world: &Transform,
    flip_normals: bool,
    part: bool,
) -> Result<shape::Shape, ShapeError> {
    let flip = flip_normals;
    Ok(match &shape.kind {
        ShapeKind::Sphere { centre, radius } => {
            shape::Shape::Sphere(Sphere::new(to_world, *centre, *radius, flip)?)
        }
        ShapeKind::Disk => shape::Shape::Disk(Disk::new(to_world, flip)?),
        ShapeKind::Cylinder { from, to, radius } => {
            shape::Shape::Cylinder(Cylinder::new(to_world, *from, *to, *radius, flip)?)
        }
        ShapeKind::Quadric { kind, capped } => {
            shape::Shape::Quadric(Box::new(Quadric::of_kind(to_world, kind, *capped, flip)?))
        }
        ShapeKind::Torus { major_radius, minor_radius } => {
            shape::Shape::Torus(Box::new(Torus::new(to_world, *major_radius, *minor_radius, flip)?))
        }
        ShapeKind::Distances { data, smooth, .. } => {
            let grid = SdfGrid::new(to_world, data.clone(), *smooth, flip)?;
            shape::Shape::Grid(Box::new(GridShape::Distances(grid)))
        }
        ShapeKind::Heights { data, scale, base, smooth, .. } => {
            let field = HeightField::new(to_world, data.clone(), *scale, *base, *smooth, flip)?;
            shape::Shape::Grid(Box::new(GridShape::Heights(field)))
        }
        ShapeKind::ProfileOrImplicit(kind) => {
            shape::Shape::ProfileOrImplicit(Box::new(ProfileOrImplicit::new(to_world, kind, flip)?))
        }
        ShapeKind::Curves { kind, solid: false, curves, .. } => {
            shape::Shape::Curves(Curves::new(to_world, *kind, curves, flip)?)
        }
        ShapeKind::Curves { kind, solid: true, curves, .. } => {
            shape::Shape::SweptSphere(Box::new(SweptSphere::new(to_world, *kind, curves, flip)?))
        }
        ShapeKind::Patches { patches, .. } => shape::Shape::Patches(Patches::new(to_world, patches, flip)?),
        ShapeKind::Rectangle => shape::Shape::Mesh(Mesh::rectangle(to_world, flip)?),
        ShapeKind::Cube if part => {
            let cube = MeshData::cube(flip);
            let placed = MeshData { normals: None, ..cube.transformed(to_world) };
            shape::Shape::Mesh(Mesh::part(&cube, to_world, placed)?)
        }
        ShapeKind::Cube => shape::Shape::Mesh(Mesh::cube(to_world, flip)?),
        ShapeKind::Mesh { mesh, compute_normals, .. } => {
            let mut placed = mesh.transformed(to_world);
            if *compute_normals {
                placed.normals = Some(compute_vertex_normals(&placed.positions, &placed.indices));
            }
            placed.flip_normals ^= flip;
            shape::Shape::Mesh(if part { Mesh::part(mesh, to_world, placed)? } else { Mesh::new(placed)? })
        }
    })
}

/// Which way the normals of a shape point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Facing {
    /// As the file has it.
    AsGiven,
    /// Out of what is closed, whatever the file says: a part of a solid, whose inside is told by its surface.
    Outward,
    /// Likewise into it: a part that is cut away.
    Inward,
}

/// The same with normals that point a certain way.
pub(super) fn place_facing(
    shape: &ShapeDescription,
    to_world: &Transform,
    facing: Facing,
    part: bool,
) -> Result<shape::Shape, ShapeError> {
    let flip = shape.flip_normals != (facing == Facing::Inward);
    let placed = place(shape, to_world, flip, part)?;
    let is_turned = match facing {
        Facing::AsGiven => false,
        Facing::Outward => !placed.faces_outward(),
        Facing::Inward => placed.faces_outward(),
    };
    // Edges are looked at only where something is wrong.
    if is_turned && placed.is_closed().is_ok() { place(shape, to_world, !flip, part) } else { Ok(placed) }
}

/// The same, unless no tree could hold it.
pub(super) fn within_reach(shape: shape::Shape) -> Result<shape::Shape, ShapeError> {
    if shape.bounds().reach() <= FARTHEST { Ok(shape) } else { Err(ShapeError::Far) }
}

/// Whether it is not the same to place a shape by a transform and to carry a placed shape by it: whether
/// [`place`] makes more of the transform than images of points.
pub(super) fn depends_on(shape: &ShapeDescription, transform: &Transform) -> bool {
    match &shape.kind {
        // Turned inside out.
        ShapeKind::Sphere { .. } => transform.mirrors(),
        // So is a mesh without normals. Computed normals weigh triangles by their angles.
        ShapeKind::Mesh { mesh, compute_normals, .. } => {
            let stretches = || *compute_normals && transform.uniform_scale().is_none();
            mesh.normals.is_none() && (transform.mirrors() || stretches())
        }
        // Radii stay, and u begins where it is up.
        ShapeKind::Curves { solid: false, .. } => DMat3::from_mat4(transform.matrix()) != DMat3::IDENTITY,
        ShapeKind::Curves { solid: true, .. }
        | ShapeKind::Disk
        | ShapeKind::Cylinder { .. }
        | ShapeKind::Quadric { .. }
        | ShapeKind::Torus { .. }
        | ShapeKind::Distances { .. }
        | ShapeKind::Heights { .. }
        | ShapeKind::ProfileOrImplicit(_)
        | ShapeKind::Patches { .. }
        | ShapeKind::Rectangle
        | ShapeKind::Cube => false,
    }
}

/// The box around a shape; empty where it cannot be made.
pub(in crate::scene) fn bounds(shape: &ShapeDescription, to_world: &Transform) -> Bounds {
    match &shape.kind {
        ShapeKind::Mesh { mesh, .. } => {
            Bounds::of(mesh.positions.iter().map(|p| to_world.point(p.map(f64::from).into())))
        }
        _ => place(shape, to_world, false, true).map_or(Bounds::EMPTY, |placed| placed.bounds()),
    }
}
