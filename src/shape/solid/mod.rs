//! Bodies joined and cut from closed shapes: constructive solid geometry.
//!
//! Along a line each closed shape is a set of intervals, and so is what unions, intersections and differences
//! make of them (Roth, "Ray Casting for Modeling Solids", CGIP 18, 1982). A line is followed from one
//! crossing to the next, and after each it is asked whether the solid holds what comes: where the answer
//! changes there is a face of the solid.
//!
//! Crossings that may be at the same place, going by the bounds on their errors, are taken at once: only what
//! is before all of them and after all of them counts. So solids that abut have no wall between them, a
//! cutter flush with a face leaves no skin, and two faces that coincide are one, without any tolerance that
//! would know a scale.
//!
//! A shape that holds a place several times over, as a mesh may that penetrates itself, holds it: inside is
//! where the winding number is not 0.

mod cluster;
#[cfg(test)]
mod tests;

use super::{Crossing, Hit, NO_INSTANCE, Shape};
use crate::geometry::{Bounds, Placed, Ray, SurfacePoint};
use cluster::{Event, Events};
use smallvec::SmallVec;
use std::ops::ControlFlow;

/// How the parts of a solid are put together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// What is in any of the parts.
    Union,
    /// What is in all of them.
    Intersection,
    /// What is in the first and in no other.
    Difference,
}

/// What a solid is made from.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "a tree is small and taken apart at once")]
pub enum Tree {
    /// A shape.
    Leaf(Leaf),
    /// An operation on some solids, from the first on.
    Node(Operation, Vec<Tree>),
}

/// A closed shape as a part of a solid. On the subtracted side its normals must point inward.
#[derive(Clone, Debug)]
pub struct Leaf {
    /// The shape.
    pub shape: Shape,
    /// Which of the scene's shapes it is: hits carry it.
    pub index: u32,
    /// Where it is carried to, if it moves; `shape` is in coordinates of its own then.
    pub carried: Option<Carried>,
}

/// A leaf's motion.
#[derive(Clone, Debug)]
pub struct Carried {
    /// The solid where it is before it moves.
    pub placed: Placed,
    /// Index of the instance that hits carry.
    pub instance: u32,
}

/// A tree of closed shapes, in the order in which a walk from the root meets them.
#[derive(Clone, Debug)]
pub struct Solid {
    nodes: Vec<Node>,
    leaves: Vec<PlacedLeaf>,
    /// By how much boxes are enlarged where it is asked whether a ray meets them.
    slack: f64,
}

#[derive(Clone, Debug)]
struct Node {
    kind: Kind,
    /// Index past the last node below.
    end: usize,
    /// Box around everything below the node.
    bounds: Bounds,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    Leaf(usize),
    Operation(Operation),
}

/// A leaf with its place in the tree.
#[derive(Clone, Debug)]
struct PlacedLeaf {
    leaf: Leaf,
    /// Whether more of it is less of the solid.
    subtracted: bool,
}

/// A face of a solid, where a line meets it.
#[derive(Clone, Copy, Debug)]
pub struct Boundary {
    /// The crossing, with the index of the leaf whose face it is.
    pub crossing: Crossing,
    /// The place of that leaf in the order of the tree.
    leaf: usize,
}

/// Leaves around all that a node holds, and leaves of which it holds nothing.
#[derive(Default)]
struct Limits<'a> {
    around: Vec<&'a Shape>,
    outside: Vec<&'a Shape>,
}

/// How often the line's current place is within each leaf.
type Windings = SmallVec<[i32; 16]>;

impl Solid {
    /// `shutter`: from when to when its parts are asked for.
    pub fn new(tree: Tree, shutter: [f64; 2]) -> Self {
        let mut solid = Self { nodes: Vec::new(), leaves: Vec::new(), slack: 0.0 };
        solid.add(tree, false, shutter);
        let all = Bounds::of_all(solid.nodes.iter().map(|node| node.bounds));
        // Far above all errors of crossings, far below what would cost time.
        solid.slack = 1e-3 * all.diameter();
        solid
    }

    fn add(&mut self, tree: Tree, subtracted: bool, shutter: [f64; 2]) -> Bounds {
        let index = self.nodes.len();
        let (kind, parts) = match tree {
            Tree::Leaf(leaf) => {
                let own = leaf.shape.bounds();
                let bounds = leaf.carried.as_ref().map_or(own, |carried| carried.placed.bounds(own, shutter));
                self.leaves.push(PlacedLeaf { leaf, subtracted });
                let kind = Kind::Leaf(self.leaves.len() - 1);
                self.nodes.push(Node { kind, end: index + 1, bounds });
                return bounds;
            }
            Tree::Node(operation, parts) => (operation, parts),
        };
        self.nodes.push(Node { kind: Kind::Operation(kind), end: 0, bounds: Bounds::EMPTY });
        let mut bounds = Bounds::EMPTY;
        for (number, part) in parts.into_iter().enumerate() {
            let cuts = kind == Operation::Difference && number > 0;
            let own = self.add(part, subtracted != cuts, shutter);
            bounds = match kind {
                _ if number == 0 => own,
                Operation::Union => bounds.union(own),
                Operation::Intersection => bounds.common(own),
                Operation::Difference => bounds,
            };
        }
        self.nodes[index].end = self.nodes.len();
        self.nodes[index].bounds = bounds;
        bounds
    }

    /// A box around it at all times, up to rounding; empty where there cannot be anything.
    pub fn bounds(&self) -> Bounds {
        self.nodes[0].bounds
    }

    /// How far two solids at least stay apart, or −∞ where that is not seen. It is seen where one lies in
    /// a ball that is cut out of the other, as the glasses of an achromat do.
    pub fn gap(&self, other: &Self) -> f64 {
        let [own, others] = [self, other].map(|solid| {
            let mut limits = Limits::default();
            solid.limit(0, &mut limits);
            limits
        });
        let deepest = |inner: &Limits, outer: &Limits| {
            let within = |ball: &&Shape| {
                inner
                    .around
                    .iter()
                    .map(|shape| shape.depth_within_ball(ball))
                    .fold(f64::NEG_INFINITY, f64::max)
            };
            outer.outside.iter().map(within).fold(f64::NEG_INFINITY, f64::max)
        };
        let depth = deepest(&own, &others).max(deepest(&others, &own));
        if depth > 0.0 { depth } else { f64::NEG_INFINITY }
    }

    /// Adds the limits of what a node holds, as far as they stand still.
    fn limit<'a>(&'a self, node: usize, limits: &mut Limits<'a>) {
        let operation = match self.nodes[node].kind {
            Kind::Leaf(leaf) => return limits.around.extend(self.leaves[leaf].leaf.still()),
            Kind::Operation(operation) => operation,
        };
        let mut parts = self.parts_of(node);
        match operation {
            Operation::Intersection => parts.for_each(|part| self.limit(part, limits)),
            Operation::Difference => {
                parts.by_ref().take(1).for_each(|first| self.limit(first, limits));
                parts.for_each(|part| self.filled_by(part, &mut limits.outside));
            }
            Operation::Union => {}
        }
    }

    /// Leaves that a node holds whole.
    fn filled_by<'a>(&'a self, node: usize, leaves: &mut Vec<&'a Shape>) {
        match self.nodes[node].kind {
            Kind::Leaf(leaf) => leaves.extend(self.leaves[leaf].leaf.still()),
            Kind::Operation(Operation::Union) => {
                self.parts_of(node).for_each(|part| self.filled_by(part, leaves));
            }
            Kind::Operation(_) => {}
        }
    }

    /// The nodes right below a node.
    fn parts_of(&self, node: usize) -> impl Iterator<Item = usize> {
        let before_end = move |part: usize| Some(part).filter(|&part| part < self.nodes[node].end);
        std::iter::successors(before_end(node + 1), move |&part| before_end(self.nodes[part].end))
    }

    /// The scene's shapes that are its leaves, and the instances of those that move.
    pub fn parts(&self) -> impl Iterator<Item = (u32, Option<u32>)> {
        self.leaves
            .iter()
            .map(|part| (part.leaf.index, part.leaf.carried.as_ref().map(|carried| carried.instance)))
    }

    /// The nearest hit with 0 ≤ t < `ray.t_max`. It carries the leaf's index.
    pub fn closest(&self, ray: &Ray, time: f64) -> Option<Hit> {
        if self.is_farther_than(ray) {
            return None;
        }
        self.walk(ray, time, |boundary| {
            let hit = boundary.crossing.hit;
            match hit.t {
                t if t < 0.0 => ControlFlow::Continue(()),
                t if t < ray.t_max => ControlFlow::Break(Some(hit)),
                _ => ControlFlow::Break(None),
            }
        })
        .flatten()
    }

    /// Whether the surfaces of all leaves are; see [`Shape::is_farther_than`].
    fn is_farther_than(&self, ray: &Ray) -> bool {
        let mut shapes = self.leaves.iter().map(|part| part.leaf.still());
        shapes.all(|shape| shape.is_some_and(|shape| shape.is_farther_than(ray)))
    }

    /// Whether a point of a leaf's surface is one of the solid's: not cut away and not within another part.
    ///
    /// `shape` is the leaf's index among the scene's shapes; of faces that coincide, the first leaf's is the
    /// solid's.
    pub fn shows(&self, shape: u32, point: &SurfacePoint, time: f64) -> bool {
        let line = Ray { origin: point.position, direction: point.normal, t_max: 0.0 };
        let own = self.walk(&line, time, |Boundary { crossing, leaf }| {
            let near = crossing.hit.t.abs() <= crossing.error + point.error;
            if near && self.leaves[leaf].leaf.index == shape {
                return ControlFlow::Break(());
            }
            ControlFlow::Continue(())
        });
        own.is_some()
    }

    /// All faces along the whole line, in order. The solid is entered and left by turns.
    ///
    /// It leaves out parts that the ray does not come near between 0 and `ray.t_max`.
    pub fn walk<B>(
        &self,
        ray: &Ray,
        time: f64,
        mut report: impl FnMut(Boundary) -> ControlFlow<B>,
    ) -> Option<B> {
        let mut events = Events::new();
        if !self.gather(0, ray, time, &mut events) {
            return None;
        }
        events.sort_by(|a, b| a.crossing.hit.t.total_cmp(&b.crossing.hit.t));
        let mut windings: Windings = SmallVec::from_elem(0, self.leaves.len());
        let (mut rest, mut within) = (&mut events[..], false);
        while !rest.is_empty() {
            let (together, others) = rest.split_at_mut(cluster::first(rest));
            rest = others;
            let before = windings.clone();
            for event in together.iter() {
                windings[event.leaf] += event.turn;
            }
            let after = self.holds(0, &windings);
            if after == within {
                continue;
            }
            within = after;
            let changed = |leaf: usize| (before[leaf] != 0, windings[leaf] != 0);
            let Some(boundary) = self.owner(together, after, changed) else { continue };
            if let ControlFlow::Break(found) = report(boundary) {
                return Some(found);
            }
        }
        None
    }

    /// The crossing of the first leaf that changes as the solid does, among crossings at the same place.
    /// There is one: to be within more of the leaves, or within less of those that are subtracted, never
    /// leads out of the solid.
    fn owner(
        &self,
        together: &mut [Event],
        after: bool,
        changed: impl Fn(usize) -> (bool, bool),
    ) -> Option<Boundary> {
        let goes_along = |event: &&Event| {
            let (was, is) = changed(event.leaf);
            was != is && (is != self.leaves[event.leaf].subtracted) == after
        };
        // The leaf's crossing that is most certain.
        let key = |event: &&Event| (event.leaf, event.crossing.error);
        let first = together.iter().filter(goes_along).min_by(|a, b| {
            let ((a, error), (b, other)) = (key(a), key(b));
            a.cmp(&b).then(error.total_cmp(&other))
        })?;
        let crossing = Crossing { enters: after, ..first.crossing };
        Some(Boundary { crossing, leaf: first.leaf })
    }

    /// Whether a place is within what a node holds.
    fn holds(&self, node: usize, windings: &[i32]) -> bool {
        let operation = match self.nodes[node].kind {
            Kind::Leaf(leaf) => return windings[leaf] != 0,
            Kind::Operation(operation) => operation,
        };
        let (first, end) = (node + 1, self.nodes[node].end);
        let mut part = first;
        while part < end {
            let within = self.holds(part, windings);
            match operation {
                Operation::Union if within => return true,
                Operation::Intersection if !within => return false,
                Operation::Difference if within != (part == first) => return false,
                _ => part = self.nodes[part].end,
            }
        }
        operation != Operation::Union
    }

    /// The crossings of the line with all leaves that matter. Whether the ray may be within what the node
    /// holds anywhere.
    fn gather(&self, node: usize, ray: &Ray, time: f64, events: &mut Events) -> bool {
        let Node { kind, end, bounds } = &self.nodes[node];
        if !self.reached(bounds, ray) {
            return false;
        }
        let operation = match *kind {
            Kind::Leaf(leaf) => return self.leaves[leaf].leaf.add_crossings(leaf, ray, time, events),
            Kind::Operation(operation) => operation,
        };
        let known = events.len();
        let first = node + 1;
        let (mut part, mut any) = (first, false);
        while part < *end {
            let met = self.gather(part, ray, time, events);
            let needed =
                operation == Operation::Intersection || (operation == Operation::Difference && part == first);
            if needed && !met {
                events.truncate(known);
                return false;
            }
            any |= met;
            part = self.nodes[part].end;
        }
        any
    }

    /// Whether the ray comes near a box.
    fn reached(&self, bounds: &Bounds, ray: &Ray) -> bool {
        let slack = self.slack + 64.0 * f64::EPSILON * ray.origin.abs().max_element();
        let (mut enter, mut leave) = (0.0f64, ray.t_max);
        for axis in 0..3 {
            let low = bounds.min[axis] - slack - ray.origin[axis];
            let high = bounds.max[axis] + slack - ray.origin[axis];
            if ray.direction[axis] == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return false;
                }
                continue;
            }
            let (a, b) = (low / ray.direction[axis], high / ray.direction[axis]);
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        enter <= leave
    }
}

impl Leaf {
    /// Its shape, unless it moves.
    fn still(&self) -> Option<&Shape> {
        match self.carried {
            None => Some(&self.shape),
            Some(_) => None,
        }
    }

    /// Whether there are any crossings.
    fn add_crossings(&self, leaf: usize, ray: &Ray, time: f64, events: &mut Events) -> bool {
        let known = events.len();
        let is_mesh = matches!(self.shape, Shape::Mesh(_));
        let mut add = |crossing: Crossing, instance: u32| {
            // Analytic shapes are entered and left by turns, whatever rounding makes of a slope.
            let enters = if is_mesh { crossing.enters } else { (events.len() - known).is_multiple_of(2) };
            let hit = Hit { shape: self.index, instance, ..crossing.hit };
            let crossing = Crossing { hit, ..crossing };
            events.push(Event { leaf, turn: if enters { 1 } else { -1 }, crossing });
        };
        match &self.carried {
            None => self.shape.crossings(ray).into_iter().for_each(|crossing| add(crossing, NO_INSTANCE)),
            Some(Carried { placed, instance }) => {
                let pose = placed.at(time);
                let direction = pose.local_vector(ray.direction);
                let scale = direction.length();
                let local = Ray::new(pose.local_point(ray.origin), direction / scale);
                let reach = self.shape.bounds().diameter();
                for crossing in self.shape.crossings(&local) {
                    // What the way to the leaf's coordinates adds is a distance from its surface.
                    let own = self.shape.surface(&crossing.hit, &local).point;
                    let point = placed.surface_point(&pose, &own, reach);
                    let slope = point.normal.dot(ray.direction).abs();
                    let t = crossing.hit.t / scale;
                    let error = crossing.error / scale + point.error / slope + 4.0 * f64::EPSILON * t.abs();
                    add(Crossing { hit: Hit { t, ..crossing.hit }, error, ..crossing }, *instance);
                }
            }
        }
        cluster::without_touches(events, known);
        events.len() > known
    }
}
