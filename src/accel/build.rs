//! From shapes to the tree: a binary tree by the crate obvhs (parallel locally-ordered clustering with
//! reinsertion), collapsed into nodes of eight.

use super::collapse::{Collapse, LeafCost};
use super::instance::Slice;
use super::memory::in_large_pages;
use super::node::{self, Child, Node, NodeSpace};
use super::packet::{Packet, WIDTH};
use super::{Accel, Instance, Other};
use crate::geometry::{Bounds, Vec3};
use crate::shape::solid::Solid;
use crate::shape::{Pieces, Shape};
use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::bvh2::node::Bvh2Node;
use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

/// One surface, or a group of them. Shapes are counted from the first of the list.
#[derive(Clone, Copy)]
enum Primitive {
    Triangle { shape: u32, triangle: u32 },
    Analytic { shape: u32 },
    Piece { shape: u32, piece: u32 },
    Instance { index: u32, during: [f64; 2] },
    Solid(u32),
}

/// What one slot of a node can become.
#[derive(Clone, Copy)]
enum Part {
    /// A node of the binary tree that has children.
    Inner(usize),
    /// Triangles or other primitives, as a range of `order`.
    Leaf { first: usize, count: usize, other: bool },
}

struct Builder<'a> {
    shapes: &'a [Shape],
    /// Index of the first shape, as hits are to carry it.
    first: u32,
    solids: &'a [Arc<Solid>],
    primitives: &'a [Primitive],
    boxes: &'a [Aabb],
    tree: &'a [Bvh2Node],
    /// Primitives in the order of the binary tree's leaves.
    order: Vec<u32>,
    accel: Accel,
}

/// All that a tree is built over.
struct Surfaces<'a> {
    shapes: &'a [Shape],
    instances: &'a [Instance],
    solids: &'a [Arc<Solid>],
    shutter: [f64; 2],
    /// The shapes, counted from the first of the list, and the instances that are met as parts of solids alone.
    parts: [BTreeSet<u32>; 2],
}

pub(super) fn build(
    shapes: &[Shape],
    first: u32,
    solids: &[Arc<Solid>],
    instances: Vec<Instance>,
    shutter: [f64; 2],
) -> Accel {
    let parts = || solids.iter().flat_map(|solid| solid.parts());
    let parts = [
        parts().map(|(shape, _)| shape - first).collect(),
        parts().filter_map(|(_, carried)| carried).collect(),
    ];
    let surfaces = Surfaces { shapes, instances: &instances, solids, shutter, parts };
    let scene = surfaces.bounds();
    let space = NodeSpace::new(if scene.is_empty() { Bounds::of([Vec3::ZERO]) } else { scene });
    let (primitives, boxes) = surfaces.primitives(&space);
    let accel = Accel {
        space,
        nodes: Vec::new(),
        packets: Vec::new(),
        others: Vec::new(),
        instances,
        bounds: scene,
        stack_size: 0,
    };
    if primitives.is_empty() {
        return accel;
    }
    // Builds in about half the time of the next slower preset. Four triangles are one packet.
    let parameters = BvhBuildParams { max_prims_per_leaf: 4, ..BvhBuildParams::fast_build() };
    let tree = build_bvh2(&boxes, parameters, &mut Duration::default());
    let order = tree.primitive_indices;
    let leaves = tree.nodes.len() / 2 + 1;
    let accel = Accel { packets: in_large_pages(leaves), ..accel };
    let mut builder = Builder {
        shapes,
        first,
        solids,
        primitives: &primitives,
        boxes: &boxes,
        tree: &tree.nodes,
        order,
        accel,
    };
    builder.collapse();
    builder.accel
}

impl Surfaces<'_> {
    /// The shapes that are met by themselves, with their places in the list.
    fn own_shapes(&self) -> impl Iterator<Item = (u32, &Shape)> {
        (0u32..).zip(self.shapes).filter(|(shape, _)| !self.parts[0].contains(shape))
    }

    /// Likewise.
    fn own_instances(&self) -> impl Iterator<Item = (u32, &Instance)> {
        (0u32..).zip(self.instances).filter(|(instance, _)| !self.parts[1].contains(instance))
    }

    fn bounds(&self) -> Bounds {
        let shapes = self.own_shapes().map(|(_, shape)| shape.bounds());
        let instances = self.own_instances().map(|(_, instance)| instance.bounds(self.shutter));
        let solids = self.solids.iter().map(|solid| solid.bounds());
        Bounds::of_all(shapes.chain(instances).chain(solids))
    }

    /// Everything that can be hit, with its box in node space.
    fn primitives(&self, space: &NodeSpace) -> (Vec<Primitive>, Vec<Aabb>) {
        let pieces = |shape: &Shape| match shape {
            Shape::Mesh(mesh) => mesh.triangle_count(),
            _ => Pieces::of(shape).map_or(1, |pieces| pieces.count()),
        };
        let count = self.own_shapes().map(|(_, shape)| pieces(shape)).sum::<usize>()
            + self.instances.len()
            + self.solids.len();
        let (mut primitives, mut boxes) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let mut add = |primitive: Primitive, bounds: Bounds| {
            let bounds = space.of(bounds);
            boxes.push(Aabb::new(Vec3A::from(bounds.min.as_vec3()), Vec3A::from(bounds.max.as_vec3())));
            primitives.push(primitive);
        };
        for (shape, surface) in self.own_shapes() {
            match surface {
                Shape::Mesh(mesh) => {
                    for triangle in 0..mesh.triangle_count() as u32 {
                        if !mesh.is_degenerate(triangle) {
                            add(Primitive::Triangle { shape, triangle }, Bounds::of(mesh.triangle(triangle)));
                        }
                    }
                }
                _ => match Pieces::of(surface) {
                    Some(pieces) => {
                        for piece in 0..pieces.count() as u32 {
                            add(Primitive::Piece { shape, piece }, pieces.bounds(piece));
                        }
                    }
                    None => add(Primitive::Analytic { shape }, surface.bounds()),
                },
            }
        }
        for (index, instance) in self.own_instances() {
            for Slice { during, bounds } in instance.slices(self.shutter) {
                if !bounds.is_empty() {
                    add(Primitive::Instance { index, during }, bounds);
                }
            }
        }
        for (index, solid) in (0u32..).zip(self.solids) {
            if !solid.bounds().is_empty() {
                add(Primitive::Solid(index), solid.bounds());
            }
        }
        (primitives, boxes)
    }
}

impl Builder<'_> {
    /// Turns the binary tree into nodes of eight, in depth-first order.
    fn collapse(&mut self) {
        let collapse = Collapse::new(self.tree, |leaf| self.leaf_cost(leaf));
        // Nodes of the binary tree that wait to become nodes, with the slots that will refer to them.
        let mut todo = vec![(0, None, 1)];
        let mut deepest = 0;
        while let Some((root, slot, depth)) = todo.pop() {
            deepest = deepest.max(depth);
            let index = self.accel.nodes.len();
            if let Some((parent, lane)) = slot {
                let parent: &mut Node = &mut self.accel.nodes[parent];
                parent.set_child(lane, Child::of_node(index));
            }
            let parts = self.parts(&collapse, root);
            let boxes: Vec<_> = parts.iter().map(|part| self.part_box(part)).collect();
            let mut node = Node::new(&boxes);
            for (lane, part) in parts.into_iter().enumerate() {
                match part {
                    Part::Inner(inner) => todo.push((inner, Some((index, lane)), depth + 1)),
                    Part::Leaf { first, count, other } => {
                        let leaf = self.leaf(first, count, other);
                        node.set_child(lane, leaf);
                    }
                }
            }
            self.accel.nodes.push(node);
        }
        // Every node on the way down leaves at most seven siblings waiting, the last one eight.
        self.accel.stack_size = 7 * deepest + 1;
        let mut nodes = in_large_pages(self.accel.nodes.len());
        nodes.append(&mut self.accel.nodes);
        self.accel.nodes = nodes;
    }

    /// At most eight parts of a node of the binary tree.
    fn parts(&mut self, collapse: &Collapse, root: usize) -> Vec<Part> {
        let mut parts = Vec::with_capacity(node::WIDTH);
        let tree = self.tree;
        let roots = if tree[root].prim_count > 0 { vec![root] } else { collapse.parts(root) };
        for part in roots {
            match tree[part] {
                Bvh2Node { prim_count: 0, .. } => parts.push(Part::Inner(part)),
                Bvh2Node { prim_count, first_index, .. } => {
                    parts.extend(self.leaves(first_index as usize, prim_count as usize));
                }
            }
        }
        parts
    }

    fn leaf_cost(&self, leaf: &Bvh2Node) -> LeafCost {
        let first = leaf.first_index as usize;
        let items = &self.order[first..first + leaf.prim_count as usize];
        let triangles = items.iter().filter(|&&item| self.is_triangle(item)).count();
        let others = items.len() - triangles;
        let packets = triangles.div_ceil(WIDTH);
        LeafCost { slots: packets.min(1) + others.min(1), visit: (packets + others) as f32 }
    }

    fn is_triangle(&self, item: u32) -> bool {
        matches!(self.primitives[item as usize], Primitive::Triangle { .. })
    }

    fn leaves(&mut self, first: usize, count: usize) -> Vec<Part> {
        let primitives = self.primitives;
        let other = |item: &u32| !matches!(primitives[*item as usize], Primitive::Triangle { .. });
        let items = &mut self.order[first..first + count];
        items.sort_by_key(other);
        let triangles = items.partition_point(|item| !other(item));
        let runs = [(first, triangles, false), (first + triangles, count - triangles, true)];
        let leaves = runs.into_iter().filter(|run| run.1 > 0);
        leaves.map(|(first, count, other)| Part::Leaf { first, count, other }).collect()
    }

    fn part_box(&self, part: &Part) -> Bounds {
        let aabb = match *part {
            Part::Inner(node) => *self.tree[node].aabb(),
            Part::Leaf { first, count, .. } => self.order[first..first + count]
                .iter()
                .fold(Aabb::INVALID, |union, &item| union.union(&self.boxes[item as usize])),
        };
        Bounds { min: aabb.min.as_dvec3(), max: aabb.max.as_dvec3() }
    }

    fn leaf(&mut self, first: usize, count: usize, other: bool) -> Child {
        let items = self.order[first..first + count].iter().map(|&item| self.primitives[item as usize]);
        let start = if other { self.accel.others.len() } else { self.accel.packets.len() };
        for (i, item) in items.enumerate() {
            match item {
                Primitive::Analytic { shape } => {
                    let surface = self.shapes[shape as usize].clone();
                    self.accel.others.push((self.first + shape, Other::Shape(surface)));
                }
                Primitive::Piece { shape, piece } => {
                    if let Some(pieces) = Pieces::of(&self.shapes[shape as usize]) {
                        self.accel.others.push((self.first + shape, Other::Piece { pieces, piece }));
                    }
                }
                Primitive::Instance { index, during } => {
                    self.accel.others.push((index, Other::Instance { during }));
                }
                Primitive::Solid(index) => {
                    let solid = self.solids[index as usize].clone();
                    self.accel.others.push((index, Other::Solid(solid)));
                }
                Primitive::Triangle { shape, triangle } => {
                    if i % WIDTH == 0 {
                        self.accel.packets.push(Packet::default());
                    }
                    if let (Shape::Mesh(mesh), Some(packet)) =
                        (&self.shapes[shape as usize], self.accel.packets.last_mut())
                    {
                        packet.set(i % WIDTH, mesh.triangle_f32(triangle), self.first + shape, triangle);
                    }
                }
            }
        }
        Child::leaf(start, if other { count } else { count.div_ceil(WIDTH) }, other)
    }
}
