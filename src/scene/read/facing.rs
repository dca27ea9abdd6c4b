//! Closed surfaces of transparent bodies that face inward: by their normals their inside is all that lies
//! outside of them.

use super::super::compile::{bounds_of_shape, index_of_source, place_shape};
use super::super::description::{Bsdf, BsdfKind, IndexSource, ShapeDescription, ShapeKind};
use super::Reader;
use crate::geometry::Bounds;
use crate::shape::Mesh;
use crate::spectrum::Spectrum;
use crate::units::WavelengthRange;
use std::sync::Arc;

impl Reader {
    /// Says of which shapes, all in the same coordinates, the inside is on the outside. A cavity in a body of
    /// the same material is meant to be so. Parts of solids are turned as they must be.
    pub(super) fn inside_out(&self, shapes: &[ShapeDescription]) {
        let encloses = |shape: &&ShapeDescription| parts_media(&shape.bsdf.kind) || shape.interior.is_some();
        for shape in shapes.iter().filter(|shape| encloses(shape) && faces_inward(shape)) {
            let within = around(shape);
            let is_cavity = shapes.iter().any(|other| {
                !std::ptr::eq(shape, other)
                    && same_inside(&shape.bsdf, &other.bsdf)
                    && around(other).contains(within)
                    && !faces_inward(other)
            });
            if is_cavity {
                continue;
            }
            let remedy = match (shape.flip_normals, &shape.kind) {
                (true, _) => "leave flip_normals out",
                (false, ShapeKind::Mesh { .. }) => {
                    "give it flip_normals, or reverse the order of the vertices in each face"
                }
                (false, _) => "give it flip_normals",
            };
            let text = format!(
                "this closed shape faces inward, so that its glass or medium is taken to be all around it and none within: {remedy}"
            );
            self.assumption(&shape.place, text);
        }
    }
}

/// Whether a surface has different media on its two sides.
fn parts_media(kind: &BsdfKind) -> bool {
    match kind {
        BsdfKind::Principled { .. } => kind.transmits(),
        _ => interior_index(kind).is_some() || nested(kind).iter().any(|bsdf| parts_media(&bsdf.kind)),
    }
}

fn interior_index(kind: &BsdfKind) -> Option<&IndexSource> {
    match kind {
        BsdfKind::Dielectric { interior, .. } => Some(interior),
        _ => nested(kind).into_iter().find_map(|bsdf| interior_index(&bsdf.kind)),
    }
}

fn nested(kind: &BsdfKind) -> Vec<&Bsdf> {
    match kind {
        BsdfKind::Mask { nested, .. }
        | BsdfKind::BumpMap { nested, .. }
        | BsdfKind::NormalMap { nested, .. } => vec![nested],
        BsdfKind::Blend { nested, .. } => nested.iter().map(Arc::as_ref).collect(),
        BsdfKind::TwoSided { front, back, .. } => {
            std::iter::once(front).chain(back).map(Arc::as_ref).collect()
        }
        _ => Vec::new(),
    }
}

fn same_inside(a: &Arc<Bsdf>, b: &Arc<Bsdf>) -> bool {
    let index = |bsdf: &Bsdf| -> Option<Spectrum> {
        index_of_source(interior_index(&bsdf.kind)?, WavelengthRange::VISIBLE).ok()
    };
    Arc::ptr_eq(a, b) || index(a).is_some_and(|of_a| index(b) == Some(of_a))
}

/// Whether a surface is closed and its normals point to what it encloses.
fn faces_inward(shape: &ShapeDescription) -> bool {
    let mirrors = shape.to_world.mirrors();
    match &shape.kind {
        ShapeKind::Mesh { mesh, .. } => {
            // See `MeshData::transformed`.
            let turned = mirrors && mesh.normals.is_none();
            let flips = shape.flip_normals != mesh.flip_normals;
            let volume = mesh.volume() * if turned != flips { -1.0 } else { 1.0 };
            // Edges are looked at only where the volume, which is cheap, says that something is wrong.
            volume < 0.0 && Mesh::new((**mesh).clone()).is_ok_and(|mesh| mesh.open_edge().is_none())
        }
        _ => {
            let placed = || place_shape(shape, &shape.to_world, shape.flip_normals, false);
            (shape.flip_normals || mirrors)
                && placed().is_ok_and(|placed| placed.is_closed().is_ok() && !placed.encloses())
        }
    }
}

fn around(shape: &ShapeDescription) -> Bounds {
    bounds_of_shape(shape, &shape.to_world)
}
