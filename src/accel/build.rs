//! From surfaces to the tree: a binary one over their boxes, turned into nodes of eight.

use super::collapse::{LeafCost, open};
use super::few::Few;
use super::grow::{Tree, grow};
use super::memory::in_large_pages;
use super::node::{Child, Node, NodeSpace};
use super::numbering::Numbering;
use super::packet::WIDTH;
use super::surfaces::Surfaces;
use super::{Accel, Instance};
use crate::geometry::{Bounds, Vec3};
use crate::shape::Shape;
use crate::shape::solid::Solid;
use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::bvh2::node::Bvh2Node;
use rayon::prelude::*;
use smallvec::SmallVec;
use std::sync::{Arc, OnceLock};

pub(super) fn build(
    shapes: &[Shape],
    first: u32,
    solids: &[Arc<Solid>],
    instances: Vec<Instance>,
    shutter: [f64; 2],
) -> Accel {
    let surfaces = Surfaces::new(shapes, first, solids, &instances, shutter);
    let bounds = surfaces.bounds();
    let space = NodeSpace::new(if bounds.is_empty() { Bounds::of([Vec3::ZERO]) } else { bounds });
    let items = surfaces.items(&space);
    let mut accel = Accel {
        space,
        nodes: Vec::new(),
        packets: Vec::new(),
        few: None,
        others: Vec::new(),
        instances: Vec::new(),
        numbering: Numbering::new(&instances),
        bounds,
        hull: OnceLock::new(),
        ball: OnceLock::new(),
        stack_size: 0,
    };
    if !items.is_empty() {
        let tree = grow(items, |primitives| leaf_cost(&surfaces, primitives));
        let parts = Collapser { surfaces: &surfaces, space: &space, tree: &tree }.collapse();
        drop(tree);
        join(parts, &surfaces, &mut accel);
    }
    drop(surfaces);
    accel.instances = instances;
    accel.few = Few::new(&accel.packets, &accel.others, &accel.space);
    accel
}

fn leaf_cost(surfaces: &Surfaces, primitives: &[u32]) -> LeafCost {
    let triangles = primitives.iter().filter(|&&primitive| surfaces.is_triangle(primitive)).count();
    let others = primitives.len() - triangles;
    let packets = triangles.div_ceil(WIDTH);
    LeafCost { slots: packets.min(1) + others.min(1), visit: (packets + others) as f32 }
}

/// A group of nodes, and what is in their leaves. Indices count from the first of the same list.
#[derive(Default)]
struct NodeGroup {
    nodes: Vec<Node>,
    /// Triangles, packet for packet.
    packets: Vec<[u32; WIDTH]>,
    others: Vec<u32>,
    /// Nodes that slots of the group above refer to: the slot, and the index of the node.
    entries: Vec<(NodeSlot, usize)>,
    deepest: usize,
}

/// A node and one of its slots.
type NodeSlot = (usize, usize);

/// A node of the binary tree that is to become a node.
#[derive(Clone, Copy)]
struct Waiting {
    root: usize,
    /// What will refer to it.
    place: Option<NodeSlot>,
    depth: usize,
}

/// So many subtrees become one group.
const SUBTREES: usize = 64;

/// What one slot of a node becomes.
enum Slot {
    /// A node of the binary tree that has children.
    Inner(usize),
    Leaf {
        primitives: SmallVec<[u32; 4]>,
        bounds: Aabb,
        other: bool,
    },
}

/// Fills what is left of a packet.
const NONE: u32 = u32::MAX;

struct Collapser<'a> {
    surfaces: &'a Surfaces<'a>,
    space: &'a NodeSpace,
    tree: &'a Tree,
}

impl Collapser<'_> {
    /// The top of the tree, and what comes below.
    fn collapse(&self) -> Vec<NodeGroup> {
        let mut below = Vec::new();
        let mut whole = |waiting: Waiting| {
            let Bvh2Node { prim_count, first_index, .. } = self.tree.nodes[waiting.root];
            let in_cluster = prim_count == 0 && first_index as usize >= self.tree.top;
            if in_cluster {
                below.push(waiting);
            }
            in_cluster
        };
        let mut top = NodeGroup::default();
        self.fill(&mut top, Waiting { root: 0, place: None, depth: 1 }, &mut whole);
        let subtrees = |waiting: &[Waiting]| {
            let mut part = NodeGroup::default();
            for &Waiting { root, place, depth } in waiting {
                part.entries.extend(place.map(|place| (place, part.nodes.len())));
                self.fill(&mut part, Waiting { root, place: None, depth }, &mut |_| false);
            }
            part
        };
        let parts = below.par_chunks(SUBTREES).map(subtrees).collect::<Vec<_>>();
        std::iter::once(top).chain(parts).collect()
    }

    /// Adds nodes from one node of the binary tree downwards, in depth-first order, but for those that are
    /// left out.
    fn fill(&self, part: &mut NodeGroup, from: Waiting, leave_out: &mut impl FnMut(Waiting) -> bool) {
        let mut todo = vec![from];
        while let Some(waiting) = todo.pop() {
            if leave_out(waiting) {
                continue;
            }
            let Waiting { root, place, depth } = waiting;
            part.deepest = part.deepest.max(depth);
            let index = part.nodes.len();
            if let Some((parent, lane)) = place {
                part.nodes[parent].set_child(lane, Child::of_node(index));
            }
            let slots = self.slots(root);
            let boxes: SmallVec<[Bounds; 8]> = slots.iter().map(|slot| self.bounds(slot)).collect();
            let mut node = Node::new(&boxes);
            for (lane, slot) in slots.into_iter().enumerate() {
                match slot {
                    Slot::Inner(root) => {
                        todo.push(Waiting { root, place: Some((index, lane)), depth: depth + 1 })
                    }
                    Slot::Leaf { primitives, other: true, .. } => {
                        node.set_child(lane, Child::leaf(part.others.len(), primitives.len(), true));
                        part.others.extend(primitives);
                    }
                    Slot::Leaf { primitives, other: false, .. } => {
                        let count = primitives.len().div_ceil(WIDTH);
                        node.set_child(lane, Child::leaf(part.packets.len(), count, false));
                        let packet =
                            |own: &[u32]| std::array::from_fn(|i| own.get(i).copied().unwrap_or(NONE));
                        part.packets.extend(primitives.chunks(WIDTH).map(packet));
                    }
                }
            }
            part.nodes.push(node);
        }
    }

    /// At most eight, of a node of the binary tree.
    fn slots(&self, root: usize) -> SmallVec<[Slot; 8]> {
        let Tree { nodes, splits, order, .. } = self.tree;
        let parts = if nodes[root].prim_count > 0 {
            SmallVec::from_slice(&[root])
        } else {
            open(nodes, splits, root)
        };
        let mut slots = SmallVec::new();
        for part in parts {
            let node = &nodes[part];
            if node.prim_count == 0 {
                slots.push(Slot::Inner(part));
                continue;
            }
            let first = node.first_index as usize;
            let own = &order[first..first + node.prim_count as usize];
            let (triangles, others): (SmallVec<[u32; 4]>, SmallVec<[u32; 4]>) =
                own.iter().copied().partition(|&primitive| self.surfaces.is_triangle(primitive));
            let mixed = !triangles.is_empty() && !others.is_empty();
            for (primitives, other) in [(triangles, false), (others, true)] {
                if !primitives.is_empty() {
                    let bounds = if mixed { self.around(&primitives) } else { *node.aabb() };
                    slots.push(Slot::Leaf { primitives, bounds, other });
                }
            }
        }
        slots
    }

    /// The box around some primitives.
    fn around(&self, primitives: &[u32]) -> Aabb {
        let bounds = primitives.iter().filter_map(|&primitive| self.surfaces.bounds_of(primitive));
        let bounds = self.space.of(Bounds::of_all(bounds));
        Aabb::new(Vec3A::from(bounds.min.as_vec3()), Vec3A::from(bounds.max.as_vec3()))
    }

    fn bounds(&self, slot: &Slot) -> Bounds {
        let aabb = match slot {
            Slot::Inner(node) => self.tree.nodes[*node].aabb(),
            Slot::Leaf { bounds, .. } => bounds,
        };
        Bounds { min: aabb.min.as_dvec3(), max: aabb.max.as_dvec3() }
    }
}

/// Puts the parts of a tree one behind the other, the top first.
fn join(parts: Vec<NodeGroup>, surfaces: &Surfaces, accel: &mut Accel) {
    let sum = |count: fn(&NodeGroup) -> usize| parts.iter().map(count).sum::<usize>();
    let mut nodes: Vec<Node> = in_large_pages(sum(|part| part.nodes.len()));
    let mut triangles: Vec<[u32; WIDTH]> = Vec::with_capacity(sum(|part| part.packets.len()));
    let mut others = Vec::with_capacity(sum(|part| part.others.len()));
    let mut deepest = 0;
    for part in parts {
        let first = nodes.len();
        for ((parent, lane), index) in part.entries {
            nodes[parent].set_child(lane, Child::of_node(first + index));
        }
        nodes.extend(part.nodes.into_iter().map(|node| node.moved(first, triangles.len(), others.len())));
        triangles.extend(part.packets);
        others.extend(part.others.iter().filter_map(|&other| surfaces.other(other)));
        deepest = deepest.max(part.deepest);
    }
    let mut packets = in_large_pages(triangles.len());
    let packet = |triangles: &[u32; WIDTH]| surfaces.packet(triangles);
    triangles.par_iter().with_min_len(1 << 10).map(packet).collect_into_vec(&mut packets);
    // Every node on the way down leaves at most seven siblings waiting, the last one eight.
    accel.stack_size = 7 * deepest + 1;
    (accel.nodes, accel.packets, accel.others) = (nodes, packets, others);
}
