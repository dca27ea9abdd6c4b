//! Which surface a ray meets first, and whether it meets any.
//!
//! A tree of boxes, eight to a node, over packets of four triangles, over analytic shapes, over solids and
//! over instances of other trees. The boxes are `f32` and only ever err towards visiting too much; what they
//! let through is tested in `f64`. So the answer is the very one of a loop over all surfaces, whatever the
//! tree looks like.

mod build;
mod collapse;
mod fan;
mod few;
mod few_rays;
mod grow;
mod hull;
mod instance;
mod line;
mod memory;
mod node;
mod numbering;
mod packet;
mod rays;
mod segments;
mod stack;
mod surfaces;
#[cfg(test)]
mod tests;
mod together;
mod watch;

use crate::geometry::{Bounds, Ray, Vec3};
use crate::shape::solid::Solid;
use crate::shape::{AtRest, Hit, NO_INSTANCE, Parametrisation, Pieces, RaySpace, Shape, SurfaceHit};
pub use fan::{Fan, Target};
use few::Few;
use hull::{Ball, Hull};
pub use instance::Instance;
use memory::prefetch;
use node::{Child, Node, NodeRay, NodeSpace};
use numbering::Numbering;
use packet::{Packet, PacketRay};
pub use rays::{Hits, NO_FACET, Primitive, Rays};
use stack::{Stack, Waiting};
use std::cell::Cell;
use std::collections::HashSet;
use std::hint::select_unpredictable;
use std::sync::{Arc, OnceLock};
pub use watch::Tests;
use watch::{Unwatched, Watch};

/// Room for what waits during a query, except for trees deeper than any reasonable one.
const ROOM: usize = 128;

/// About so many boxes tell how far everything in a tree reaches.
const HULL: usize = 512;

/// All shapes of a scene, ready for ray queries.
#[derive(Clone, Debug)]
pub struct Accel {
    space: NodeSpace,
    /// The first one is the root; none for an empty scene.
    nodes: Vec<Node>,
    packets: Vec<Packet>,
    /// The triangles and spheres once more, where they are few and all that there is.
    few: Option<Few>,
    /// With their indices in the lists that were built from; in the order of the leaves.
    others: Vec<(u32, Other)>,
    instances: Vec<Instance>,
    /// How hits tell instances within instances apart.
    numbering: Numbering,
    /// Around everything, in world space.
    bounds: Bounds,
    /// Filled where an instance shows the tree turned.
    hull: OnceLock<Hull>,
    ball: OnceLock<Ball>,
    /// The most entries that a traversal can have waiting.
    stack_size: usize,
}

/// What a leaf holds that is no triangle.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "a test of a shape waits for one load instead of two")]
enum Other {
    Shape(Shape),
    /// One of the pieces of a shape.
    Piece {
        pieces: Pieces,
        piece: u32,
    },
    /// Its index says which one; met only by rays of a time from one to another.
    Instance {
        during: [f64; 2],
    },
    /// Its hits carry their own indices.
    Solid(Arc<Solid>),
}

impl Accel {
    /// Hits carry a shape's index in `shapes`. Takes about half a second for a million triangles on two
    /// cores.
    pub fn build(shapes: &[Shape]) -> Self {
        build::build(shapes, 0, &[], Vec::new(), [0.0; 2])
    }

    /// A group's tree: its hits carry indices that begin with `first`. Shapes that are parts of solids are
    /// met with these alone.
    pub fn of_group(shapes: &[Shape], first: u32, solids: &[Arc<Solid>]) -> Self {
        Self::of_group_with_instances(shapes, first, solids, Vec::new(), [0.0; 2])
    }

    /// The same for a group that shows others, for rays of times while a shutter is open.
    pub fn of_group_with_instances(
        shapes: &[Shape],
        first: u32,
        solids: &[Arc<Solid>],
        instances: Vec<Instance>,
        shutter: [f64; 2],
    ) -> Self {
        build::build(shapes, first, solids, instances, shutter)
    }

    /// A tree of shapes, solids and instances of groups, for rays of times while a shutter is open. Shapes
    /// and instances that are parts of solids are met with these alone.
    pub fn with_instances(
        shapes: &[Shape],
        solids: &[Arc<Solid>],
        instances: Vec<Instance>,
        shutter: [f64; 2],
    ) -> Self {
        build::build(shapes, 0, solids, instances, shutter)
    }

    /// A box around all surfaces at all times, up to rounding; empty where there are none.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// How far everything reaches, found when first asked for.
    fn hull(&self) -> &Hull {
        self.hull.get_or_init(|| Hull::of(&self.boxes(HULL)))
    }

    /// A ball around everything, found when first asked for.
    fn ball(&self) -> Ball {
        *self.ball.get_or_init(|| Ball::around(&self.boxes(HULL)))
    }

    /// Boxes from one level of the tree that together hold everything, not many more than `most`.
    fn boxes(&self, most: usize) -> Vec<Bounds> {
        let Some(root) = self.nodes.first() else { return Vec::new() };
        let mut parts: Vec<(Child, Bounds)> = root.parts().collect();
        while parts.len() < most && parts.iter().any(|(child, _)| !child.is_leaf()) {
            let opened = |part: (Child, Bounds)| match part.0.node() {
                Some(node) => self.nodes[node].parts().collect(),
                None => vec![part],
            };
            parts = parts.into_iter().flat_map(opened).collect();
        }
        parts.into_iter().map(|(_, bounds)| self.space.in_world(bounds)).collect()
    }

    /// The surface where `ray` hit it. `shapes` are all to which hits refer, those of groups included.
    #[inline]
    pub fn surface(&self, shapes: &[Shape], hit: &Hit, ray: &Ray, time: f64) -> SurfaceHit {
        let shape = &shapes[hit.shape as usize];
        match hit.instance {
            NO_INSTANCE => shape.surface(hit, ray),
            _ => {
                let (instance, inner) = self.numbering.split(hit.instance);
                let hit = Hit { instance: inner, ..*hit };
                self.instances[instance as usize].surface(shapes, &hit, ray, time)
            }
        }
    }

    /// Which of this tree's own instances shows a hit that carries `instance`.
    pub fn own_instance(&self, instance: u32) -> u32 {
        match instance {
            NO_INSTANCE => NO_INSTANCE,
            _ => self.numbering.split(instance).0,
        }
    }

    /// How many instances there are if those within others are counted as often as they are shown.
    pub fn instance_count(&self) -> u64 {
        self.numbering.count
    }

    /// The coordinates of the point `position` that [`Accel::surface`] gave for a hit, and where that is at
    /// rest.
    pub fn parametrisation(
        &self,
        shapes: &[Shape],
        hit: &Hit,
        position: Vec3,
        time: f64,
    ) -> (Parametrisation, AtRest) {
        let shape = &shapes[hit.shape as usize];
        match hit.instance {
            NO_INSTANCE => {
                let here = shape.parametrisation(hit, position);
                (here, AtRest { position, tangents: [here.tangent, here.bitangent] })
            }
            _ => {
                let (instance, inner) = self.numbering.split(hit.instance);
                let hit = Hit { instance: inner, ..*hit };
                self.instances[instance as usize].parametrisation(shapes, &hit, position, time)
            }
        }
    }

    /// The nearest hit with 0 ≤ t < `ray.t_max` at a time while the shutter is open; of equally near ones
    /// that of the first shape, triangle and instance.
    pub fn closest(&self, ray: &Ray, time: f64) -> Option<Hit> {
        self.closest_watched(ray, time, Unwatched)
    }

    /// The same, and adds up what it takes.
    pub fn closest_counting(&self, ray: &Ray, time: f64, tests: &Cell<Tests>) -> Option<Hit> {
        self.closest_watched(ray, time, tests)
    }

    #[inline(always)]
    fn closest_watched(&self, ray: &Ray, time: f64, watch: impl Watch) -> Option<Hit> {
        self.with_stack(|stack| self.closest_with(ray, time, stack, watch))
    }

    /// Whether anything is hit with 0 ≤ t < `ray.t_max` at a time while the shutter is open.
    pub fn occluded(&self, ray: &Ray, time: f64) -> bool {
        self.occluded_watched(ray, time, Unwatched)
    }

    /// The same, and adds up what it takes.
    pub fn occluded_counting(&self, ray: &Ray, time: f64, tests: &Cell<Tests>) -> bool {
        self.occluded_watched(ray, time, tests)
    }

    #[inline(always)]
    fn occluded_watched(&self, ray: &Ray, time: f64, watch: impl Watch) -> bool {
        self.with_stack(|stack| self.occluded_with(ray, time, stack, watch))
    }

    /// Bytes held, without groups and what analytic shapes hold indirectly.
    pub fn memory(&self) -> usize {
        let tree = size_of_val(&self.nodes[..]) + size_of_val(&self.packets[..]);
        let few = self.few.as_ref().map_or(0, Few::memory);
        let instances = size_of_val(&self.instances[..]) + self.numbering.memory();
        tree + few + size_of_val(&self.others[..]) + instances
    }

    /// Bytes held with groups, each once.
    pub fn memory_with_groups(&self) -> usize {
        self.memory_beside(&mut HashSet::new())
    }

    /// The same, without groups that are known already.
    fn memory_beside(&self, known: &mut HashSet<*const Self>) -> usize {
        let groups: Vec<&Self> =
            self.instances.iter().map(Instance::group).filter(|&group| known.insert(group)).collect();
        self.memory() + groups.into_iter().map(|group| group.memory_beside(known)).sum::<usize>()
    }

    /// Lends a stack that is large enough: of fixed size, except for trees deeper than any reasonable one.
    #[inline(always)]
    fn with_stack<R: Default>(&self, query: impl FnOnce(Stack) -> R) -> R {
        match self.stack_size {
            0 => R::default(),
            1..=ROOM => query(Stack::new(&mut [Stack::UNUSED; ROOM])),
            size => query(Stack::new(&mut vec![Stack::UNUSED; size])),
        }
    }

    fn closest_with(&self, ray: &Ray, time: f64, mut stack: Stack, watch: impl Watch) -> Option<Hit> {
        let mut node_ray = NodeRay::new(&self.space, ray)?;
        let packet_ray = PacketRay::new(&RaySpace::new(ray));
        let mut nearest: Option<Hit> = None;
        let mut child = Child::of_node(0);
        loop {
            if let Some(index) = child.node() {
                let node = &self.nodes[index];
                let (mut mask, entries) = node.entered(&node_ray);
                watch.node(|| node.len(), mask.count_ones());
                if mask != 0 {
                    let mut take = || {
                        let lane = mask.trailing_zeros() as usize & 7;
                        mask &= mask - 1;
                        self.prefetch(node.child(lane));
                        (Waiting::new(entries[lane], node.child(lane)), mask)
                    };
                    let (mut next, mut more) = take();
                    let bottom = stack.len();
                    while more != 0 {
                        let (other, rest) = take();
                        more = rest;
                        stack.insert(bottom, next.max(other));
                        next = next.min(other);
                    }
                    child = next.child();
                    continue;
                }
            } else {
                let found = self.test_leaf(child, ray, time, &packet_ray, &mut nearest, watch);
                if let (true, Some(hit)) = (found, &nearest) {
                    node_ray.shorten(&self.space, hit.t);
                }
            }
            child = loop {
                let Some(next) = stack.pop() else { return nearest };
                if next.entry() <= node_ray.t_max() {
                    break next.child();
                }
            };
        }
    }

    /// Has what a slot holds brought near.
    #[inline(always)]
    fn prefetch(&self, child: Child) {
        let node = self.nodes.as_ptr().wrapping_add(child.index()).cast::<u8>();
        let packet = self.packets.as_ptr().wrapping_add(child.index()).cast::<u8>();
        // Not a branch: which it will be nothing can foresee.
        prefetch::<{ size_of::<Node>() }>(select_unpredictable(child.is_leaf(), packet, node));
    }

    /// Whether the leaf has a nearer hit, which it then puts into `nearest`.
    fn test_leaf(
        &self,
        leaf: Child,
        ray: &Ray,
        time: f64,
        packet_ray: &PacketRay,
        nearest: &mut Option<Hit>,
        watch: impl Watch,
    ) -> bool {
        let mut found = false;
        let range = leaf.items();
        if leaf.is_other() {
            for (index, other) in &self.others[range] {
                watch.surface();
                let hit = match other {
                    Other::Shape(shape) => shape.intersect(ray).map(|hit| Hit { shape: *index, ..hit }),
                    Other::Piece { pieces, piece } => {
                        pieces.intersect(*piece, ray).map(|hit| Hit { shape: *index, ..hit })
                    }
                    Other::Instance { during: [from, to] } if *from <= time && time <= *to => {
                        self.in_instance(*index, ray, time, nearest, watch)
                    }
                    Other::Instance { .. } => None,
                    Other::Solid(solid) => in_solid(solid, ray, time, nearest),
                };
                if let Some(hit) = hit {
                    found |= take_nearer(nearest, hit);
                }
            }
        } else {
            for packet in &self.packets[range] {
                watch.packet();
                let t_last = nearest.map_or(ray.t_max.next_down(), |hit| hit.t);
                packet.intersect(packet_ray, t_last, |hit| found |= take_nearer(nearest, hit));
            }
        }
        watch.leaf(found);
        found
    }

    /// The nearest hit with an instance, unless there is a nearer one already.
    fn in_instance(
        &self,
        index: u32,
        ray: &Ray,
        time: f64,
        nearest: &Option<Hit>,
        watch: impl Watch,
    ) -> Option<Hit> {
        // Up to and with the nearest: of equally near ones it is not the order of leaves that decides.
        let t_max = nearest.map_or(ray.t_max, |hit| hit.t.next_up());
        let hit = self.instances[index as usize].closest(&Ray { t_max, ..*ray }, time, watch)?;
        let instance = self.numbering.joined(index, hit.instance);
        (hit.t < ray.t_max).then_some(Hit { instance, ..hit })
    }

    fn occluded_with(&self, ray: &Ray, time: f64, mut stack: Stack, watch: impl Watch) -> bool {
        let Some(node_ray) = NodeRay::new(&self.space, ray) else { return false };
        let packet_ray = PacketRay::new(&RaySpace::new(ray));
        let t_last = ray.t_max.next_down();
        let mut child = Child::of_node(0);
        loop {
            if let Some(index) = child.node() {
                let node = &self.nodes[index];
                let (mut mask, _) = node.entered(&node_ray);
                watch.node(|| node.len(), mask.count_ones());
                if mask != 0 {
                    let mut take = || {
                        let lane = mask.trailing_zeros() as usize & 7;
                        mask &= mask - 1;
                        self.prefetch(node.child(lane));
                        (node.child(lane), mask)
                    };
                    let (first, mut more) = take();
                    while more != 0 {
                        let (other, rest) = take();
                        more = rest;
                        stack.push(Waiting::new(0.0, other));
                    }
                    child = first;
                    continue;
                }
            } else {
                let occludes = |packet: &Packet| {
                    watch.packet();
                    packet.occludes(&packet_ray, t_last)
                };
                let occluded = match child.is_other() {
                    true => self.others[child.items()]
                        .iter()
                        .any(|other| self.other_occludes(other, ray, time, watch)),
                    false => self.packets[child.items()].iter().any(occludes),
                };
                watch.leaf(occluded);
                if occluded {
                    return true;
                }
            }
            let Some(next) = stack.pop() else { return false };
            child = next.child();
        }
    }

    #[inline(always)]
    fn other_occludes(&self, (index, other): &(u32, Other), ray: &Ray, time: f64, watch: impl Watch) -> bool {
        watch.surface();
        match other {
            Other::Shape(shape) => shape.intersect(ray).is_some(),
            Other::Piece { pieces, piece } => pieces.intersect(*piece, ray).is_some(),
            Other::Instance { during: [from, to] } => {
                *from <= time && time <= *to && self.instances[*index as usize].occluded(ray, time, watch)
            }
            Other::Solid(solid) => solid.closest(ray, time).is_some(),
        }
    }
}

/// The nearest hit with a solid, unless there is a nearer one already.
#[inline(never)]
fn in_solid(solid: &Solid, ray: &Ray, time: f64, nearest: &Option<Hit>) -> Option<Hit> {
    // Up to and with the nearest: of equally near ones it is not the order of leaves that decides.
    let t_max = nearest.map_or(ray.t_max, |hit| hit.t.next_up());
    solid.closest(&Ray { t_max, ..*ray }, time).filter(|hit| hit.t < ray.t_max)
}

/// The order in which the tree is walked must not decide between hits at the same distance.
fn take_nearer(nearest: &mut Option<Hit>, hit: Hit) -> bool {
    let nearer = nearest.is_none_or(|old: Hit| {
        let place = |hit: Hit| (hit.shape, hit.triangle, hit.instance);
        hit.t < old.t || (hit.t == old.t && place(hit) < place(old))
    });
    if nearer {
        *nearest = Some(hit);
    }
    nearer
}
