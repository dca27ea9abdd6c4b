//! Which surface a ray meets first, and whether it meets any.
//!
//! A tree of boxes, eight to a node, over packets of four triangles and over analytic shapes. The boxes
//! are `f32` and only ever err towards visiting too much; what they let through is tested in `f64`. So
//! the answer is the very one of a loop over all surfaces, whatever the tree looks like.

mod build;
mod node;
mod packet;
#[cfg(test)]
mod tests;

use crate::geometry::Ray;
use crate::shape::{Hit, RaySpace, Shape};
use node::{Child, Node, NodeRay, NodeSpace};
use packet::{Packet, PacketRay};

/// All shapes of a scene, ready for ray queries.
#[derive(Clone, Debug)]
pub struct Accel {
    space: NodeSpace,
    /// The first one is the root; none for an empty scene.
    nodes: Vec<Node>,
    packets: Vec<Packet>,
    /// With their indices in the list that was built from; in the order of the leaves.
    analytic: Vec<(u32, Shape)>,
    /// The most entries that a traversal can have waiting.
    stack_size: usize,
}

/// A subtree that waits to be visited, and where the ray enters it.
#[derive(Clone, Copy)]
struct Waiting {
    entry: f32,
    child: Child,
}

impl Accel {
    /// Hits carry a shape's index in `shapes`. Takes about a second for a million triangles on two cores.
    pub fn build(shapes: &[Shape]) -> Self {
        build::build(shapes)
    }

    /// The nearest hit with 0 ≤ t < `ray.t_max`; of equally near ones that of the first shape and triangle.
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        self.with_stack(|stack| self.closest_with(ray, stack))
    }

    /// Whether anything is hit with 0 ≤ t < `ray.t_max`.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.with_stack(|stack| self.occluded_with(ray, stack))
    }

    /// Bytes held, without what analytic shapes hold indirectly.
    pub fn memory(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.packets[..]) + size_of_val(&self.analytic[..])
    }

    /// Lends a stack that is large enough: of fixed size, except for trees deeper than any reasonable one.
    fn with_stack<R: Default>(&self, query: impl FnOnce(&mut [Waiting]) -> R) -> R {
        const NONE: Waiting = Waiting { entry: 0.0, child: Child::EMPTY };
        match self.stack_size {
            0 => R::default(),
            1..=16 => query(&mut [NONE; 16]),
            17..=64 => query(&mut [NONE; 64]),
            65..=256 => query(&mut [NONE; 256]),
            size => query(&mut vec![NONE; size]),
        }
    }

    fn closest_with(&self, ray: &Ray, stack: &mut [Waiting]) -> Option<Hit> {
        let mut node_ray = NodeRay::new(&self.space, ray)?;
        let packet_ray = PacketRay::new(&RaySpace::new(ray));
        let mut nearest: Option<Hit> = None;
        let mut child = Child::of_node(0);
        let mut waiting = 0;
        loop {
            if let Some(index) = child.node() {
                let node = &self.nodes[index];
                let (mut mask, entries) = node.entered(&node_ray);
                if mask != 0 {
                    let first = mask.trailing_zeros() as usize;
                    child = node.child(first);
                    mask &= mask - 1;
                    if mask != 0 {
                        let mut next = Waiting { entry: entries[first], child };
                        let bottom = waiting;
                        while mask != 0 {
                            let lane = mask.trailing_zeros() as usize;
                            mask &= mask - 1;
                            let mut other = Waiting { entry: entries[lane & 7], child: node.child(lane) };
                            if other.entry < next.entry {
                                std::mem::swap(&mut other, &mut next);
                            }
                            insert(stack, bottom, waiting, other);
                            waiting += 1;
                        }
                        child = next.child;
                    }
                    continue;
                }
            } else {
                let found = self.test_leaf(child, ray, &packet_ray, &mut nearest);
                if let (true, Some(hit)) = (found, &nearest) {
                    node_ray.shorten(&self.space, hit.t);
                }
            }
            loop {
                if waiting == 0 {
                    return nearest;
                }
                waiting -= 1;
                if stack[waiting].entry <= node_ray.t_max() {
                    child = stack[waiting].child;
                    break;
                }
            }
        }
    }

    /// Whether the leaf has a nearer hit, which it then puts into `nearest`.
    fn test_leaf(&self, leaf: Child, ray: &Ray, packet_ray: &PacketRay, nearest: &mut Option<Hit>) -> bool {
        let mut found = false;
        let range = leaf.items();
        if leaf.is_analytic() {
            for (index, shape) in &self.analytic[range] {
                if let Some(hit) = shape.intersect(ray) {
                    found |= take_nearer(nearest, Hit { shape: *index, ..hit });
                }
            }
        } else {
            for packet in &self.packets[range] {
                let t_last = nearest.map_or(ray.t_max.next_down(), |hit| hit.t);
                packet.intersect(packet_ray, t_last, |hit| found |= take_nearer(nearest, hit));
            }
        }
        found
    }

    fn occluded_with(&self, ray: &Ray, stack: &mut [Waiting]) -> bool {
        let Some(node_ray) = NodeRay::new(&self.space, ray) else { return false };
        let packet_ray = PacketRay::new(&RaySpace::new(ray));
        let t_last = ray.t_max.next_down();
        let mut child = Child::of_node(0);
        let mut waiting = 0;
        loop {
            if let Some(index) = child.node() {
                let node = &self.nodes[index];
                let (mut mask, _) = node.entered(&node_ray);
                while mask != 0 {
                    let lane = mask.trailing_zeros() as usize;
                    mask &= mask - 1;
                    stack[waiting].child = node.child(lane);
                    waiting += 1;
                }
            } else if child.is_analytic() {
                if self.analytic[child.items()].iter().any(|(_, shape)| shape.intersect(ray).is_some()) {
                    return true;
                }
            } else if self.packets[child.items()].iter().any(|packet| packet.occludes(&packet_ray, t_last)) {
                return true;
            }
            if waiting == 0 {
                return false;
            }
            waiting -= 1;
            child = stack[waiting].child;
        }
    }
}

/// Inserts into `stack[bottom..top]`, which is sorted so that the nearest is on top.
fn insert(stack: &mut [Waiting], bottom: usize, top: usize, item: Waiting) {
    let mut place = top;
    while place > bottom && stack[place - 1].entry < item.entry {
        stack[place] = stack[place - 1];
        place -= 1;
    }
    stack[place] = item;
}

/// The order in which the tree is walked must not decide between hits at the same distance.
fn take_nearer(nearest: &mut Option<Hit>, hit: Hit) -> bool {
    let nearer = nearest.is_none_or(|old| {
        hit.t < old.t || (hit.t == old.t && (hit.shape, hit.triangle) < (old.shape, old.triangle))
    });
    if nearer {
        *nearest = Some(hit);
    }
    nearer
}
