//! What a tree is built over: every triangle, piece, shape, instance and solid that a ray can meet by itself,
//! by a number.

use super::Instance;
use super::Other;
use super::instance::Slice;
use super::node::NodeSpace;
use super::packet::{Packet, WIDTH};
use crate::geometry::Bounds;
use crate::shape::solid::Solid;
use crate::shape::{Mesh, Pieces, Shape};
use glam::Vec3;
use obvhs::Boundable;
use obvhs::aabb::Aabb;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::sync::Arc;

/// One surface and its box in node space.
#[derive(Clone, Copy)]
pub(super) struct Item {
    pub min: Vec3,
    pub max: Vec3,
    pub primitive: u32,
}

impl Boundable for Item {
    fn aabb(&self) -> Aabb {
        Aabb::new(self.min.into(), self.max.into())
    }
}

/// Consecutive primitives.
struct Run<'a> {
    /// The number of the first.
    first: u32,
    kind: Kind<'a>,
}

/// Shapes are counted from the first of the list.
enum Kind<'a> {
    /// Its triangles.
    Mesh {
        shape: u32,
        mesh: &'a Mesh,
    },
    /// Its pieces.
    Pieces {
        shape: u32,
        pieces: Pieces,
    },
    /// The shape alone.
    Shape {
        shape: u32,
    },
    /// An instance during a part of the time.
    Slice {
        instance: u32,
        slice: Slice,
    },
    Solid {
        index: u32,
    },
}

/// All that a tree is built over. Triangles have the lowest numbers.
pub(super) struct Surfaces<'a> {
    shapes: &'a [Shape],
    /// Index of the first shape, as hits are to carry it.
    first: u32,
    solids: &'a [Arc<Solid>],
    /// In ascending order.
    runs: Vec<Run<'a>>,
    triangles: u32,
    count: u32,
    bounds: Bounds,
}

/// Shapes, counted from the first of the list, and instances that are met as parts of solids alone.
struct Parts {
    shapes: BTreeSet<u32>,
    instances: BTreeSet<u32>,
}

impl<'a> Surfaces<'a> {
    pub fn new(
        shapes: &'a [Shape],
        first: u32,
        solids: &'a [Arc<Solid>],
        instances: &[Instance],
        shutter: [f64; 2],
    ) -> Self {
        let parts = || solids.iter().flat_map(|solid| solid.parts());
        let parts = Parts {
            shapes: parts().map(|(shape, _)| shape - first).collect(),
            instances: parts().filter_map(|(_, carried)| carried).collect(),
        };
        let (mut meshes, mut others) = (Vec::new(), Vec::new());
        let mut bounds = Bounds::EMPTY;
        for (shape, surface) in (0..).zip(shapes).filter(|(shape, _)| !parts.shapes.contains(shape)) {
            bounds = bounds.union(surface.bounds());
            match (surface, Pieces::of(surface)) {
                (Shape::Mesh(mesh), _) => meshes.push((Kind::Mesh { shape, mesh }, mesh.triangle_count())),
                (_, Some(pieces)) => {
                    let count = pieces.count();
                    others.push((Kind::Pieces { shape, pieces }, count));
                }
                (_, None) => others.push((Kind::Shape { shape }, 1)),
            }
        }
        let own_instances = (0..).zip(instances).filter(|(instance, _)| !parts.instances.contains(instance));
        for (instance, placed) in own_instances {
            bounds = bounds.union(placed.bounds(shutter));
            let slices = placed.slices(shutter).into_iter().filter(|slice| !slice.bounds.is_empty());
            others.extend(slices.map(|slice| (Kind::Slice { instance, slice }, 1)));
        }
        for (index, solid) in (0..).zip(solids).filter(|(_, solid)| !solid.bounds().is_empty()) {
            bounds = bounds.union(solid.bounds());
            others.push((Kind::Solid { index }, 1));
        }
        let triangles = meshes.iter().map(|(_, count)| *count as u32).sum();
        let mut count = 0;
        let run = |(kind, length): (Kind<'a>, usize)| {
            let first = count;
            count += length as u32;
            Run { first, kind }
        };
        let runs = meshes.into_iter().chain(others).map(run).collect();
        Self { shapes, first, solids, runs, triangles, count, bounds }
    }

    /// Around all of them, in world space.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    pub fn is_triangle(&self, primitive: u32) -> bool {
        primitive < self.triangles
    }

    /// Everything that can be hit, with its box in node space.
    pub fn items(&self, space: &NodeSpace) -> Vec<Item> {
        const NONE: u32 = u32::MAX;
        let item = |primitive| {
            let bounds = self.bounds_of(primitive);
            let own = space.of(bounds.unwrap_or(Bounds::EMPTY));
            let primitive = if bounds.is_some() { primitive } else { NONE };
            Item { min: own.min.as_vec3(), max: own.max.as_vec3(), primitive }
        };
        let mut items: Vec<Item> = (0..self.count).into_par_iter().with_min_len(1 << 12).map(item).collect();
        items.retain(|item| item.primitive != NONE);
        items
    }

    /// The box of a primitive in world space; `None` of what cannot be hit.
    pub fn bounds_of(&self, primitive: u32) -> Option<Bounds> {
        let (kind, place) = self.kind(primitive);
        match kind {
            Kind::Mesh { mesh, .. } if mesh.is_degenerate(place) => None,
            Kind::Mesh { mesh, .. } => Some(Bounds::of(mesh.triangle(place))),
            Kind::Pieces { pieces, .. } => Some(pieces.bounds(place)),
            Kind::Shape { shape } => Some(self.shapes[*shape as usize].bounds()),
            Kind::Slice { slice, .. } => Some(slice.bounds),
            Kind::Solid { index } => Some(self.solids[*index as usize].bounds()),
        }
    }

    /// The kind of a primitive, and its number in its run.
    fn kind(&self, primitive: u32) -> (&Kind<'a>, u32) {
        let run = &self.runs[self.runs.partition_point(|run| run.first <= primitive) - 1];
        (&run.kind, primitive - run.first)
    }

    /// Up to four triangles; what is none leaves its lane unused.
    pub fn packet(&self, triangles: &[u32; WIDTH]) -> Packet {
        let mut packet = Packet::default();
        let triangles = triangles.iter().enumerate().filter(|(_, triangle)| self.is_triangle(**triangle));
        for (lane, &triangle) in triangles {
            if let (Kind::Mesh { shape, mesh }, place) = self.kind(triangle) {
                packet.set(lane, mesh.triangle_f32(place), self.first + shape, place);
            }
        }
        packet
    }

    /// What is no triangle.
    pub fn other(&self, primitive: u32) -> Option<(u32, Other)> {
        Some(match self.kind(primitive) {
            (Kind::Mesh { .. }, _) => return None,
            (Kind::Pieces { shape, pieces }, piece) => {
                (self.first + shape, Other::Piece { pieces: pieces.clone(), piece })
            }
            (Kind::Shape { shape }, _) => {
                (self.first + shape, Other::Shape(self.shapes[*shape as usize].clone()))
            }
            (Kind::Slice { instance, slice }, _) => (*instance, Other::Instance { during: slice.during }),
            (Kind::Solid { index }, _) => (*index, Other::Solid(self.solids[*index as usize].clone())),
        })
    }
}
