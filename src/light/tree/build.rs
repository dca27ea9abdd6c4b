//! How emitters are divided among the parts of a node.
//!
//! They are cut across the axis and at the place where the sum over both sides of intensity × extent² ×
//! directions is least (Conty Estevez and Kulla 2018, section 4.4), out of some places on each axis; the
//! largest part first, until there are as many as a node has.

use super::bound::Bound;
use super::node::{Frame, LEAF, Node, PARTS};
use crate::geometry::{Bounds, Vec3};
use rayon::prelude::*;

/// An emitter on its way into the tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaf {
    pub bound: Bound,
    pub unit: u32,
}

/// Places for a cut on each axis, and one more.
const BINS: usize = 16;

/// More emitters than this are divided on several threads.
const PARALLEL: usize = 4096;

/// Adds the node of emitters, at least one, and those below it; returns the bound of all.
pub(super) fn build(leaves: &mut [Leaf], frame: &Frame, nodes: &mut Vec<Node>) -> Bound {
    let own = nodes.len();
    nodes.push(Node::default());
    let many = leaves.len() > PARALLEL;
    let parts = divide(leaves);
    let mut built = Vec::new();
    if many {
        let below = |part: &mut [Leaf]| {
            let mut nodes = Vec::new();
            let child = build_part(part, frame, &mut nodes);
            (child, nodes)
        };
        for (child, below) in parts.into_par_iter().map(below).collect::<Vec<_>>() {
            built.push((nodes.len(), child));
            nodes.extend(below);
        }
    } else {
        built.extend(parts.into_iter().map(|part| (nodes.len(), build_part(part, frame, nodes))));
    }
    for (part, (first, (bound, unit))) in built.iter().enumerate() {
        let child = unit.map_or((first - own) as u32, |unit| LEAF | unit);
        nodes[own].put(part, bound, child, frame);
    }
    built.into_iter().map(|(_, (bound, _))| bound).reduce(Bound::union).expect("there is an emitter")
}

/// The same for a part: one emitter has no node of its own, but its number.
fn build_part(leaves: &mut [Leaf], frame: &Frame, nodes: &mut Vec<Node>) -> (Bound, Option<u32>) {
    match leaves {
        [Leaf { bound, unit }] => (*bound, Some(*unit)),
        _ => (build(leaves, frame, nodes), None),
    }
}

/// The parts of a node.
fn divide(leaves: &mut [Leaf]) -> Vec<&mut [Leaf]> {
    let mut parts = vec![leaves];
    while parts.len() < PARTS {
        let largest = (0..parts.len()).rev().max_by_key(|&part| parts[part].len()).unwrap_or(0);
        if parts[largest].len() == 1 {
            break;
        }
        let whole = std::mem::take(&mut parts[largest]);
        let middle = cut(whole);
        let (low, high) = whole.split_at_mut(middle);
        parts[largest] = low;
        parts.insert(largest + 1, high);
    }
    parts
}

/// What is summed of the emitters of a bin.
#[derive(Clone, Copy)]
struct Bin {
    bounds: Bounds,
    intensity: f64,
    count: f64,
    /// Sum of the directions that they face, by intensity.
    facing: Vec3,
}

impl Bin {
    const EMPTY: Self = Self { bounds: Bounds::EMPTY, intensity: 0.0, count: 0.0, facing: Vec3::ZERO };

    fn of(bound: &Bound) -> Self {
        Self { bounds: bound.bounds, intensity: bound.intensity, count: 1.0, facing: bound.facing }
    }

    fn and(self, other: Self) -> Self {
        Self {
            bounds: self.bounds.union(other.bounds),
            intensity: self.intensity + other.intensity,
            count: self.count + other.count,
            facing: self.facing + other.facing,
        }
    }

    fn cost(&self) -> f64 {
        // From a half space to all directions.
        let directions = 4.0 - 3.0 * self.facing.length() / self.intensity;
        self.intensity * self.bounds.diameter().powi(2) * directions
    }
}

/// Orders emitters so that the first so many are on one side of the best cut. There are at least two, and one
/// on each side.
fn cut(leaves: &mut [Leaf]) -> usize {
    let middle = leaves.len() / 2;
    let centre = |leaf: &Leaf| leaf.bound.bounds.centre();
    let extent = Bounds::of(leaves.iter().map(centre));
    let size = extent.max - extent.min;
    let bin_of = |leaf: &Leaf, axis: usize| {
        let place = (centre(leaf)[axis] - extent.min[axis]) / size[axis];
        ((place * BINS as f64) as usize).min(BINS - 1)
    };
    let mut best: Option<(f64, usize, usize)> = None;
    for axis in (0..3).filter(|&axis| size[axis] > 0.0) {
        let mut bins = [Bin::EMPTY; BINS];
        for leaf in leaves.iter() {
            let bin = &mut bins[bin_of(leaf, axis)];
            *bin = bin.and(Bin::of(&leaf.bound));
        }
        let mut above = [Bin::EMPTY; BINS];
        for i in (1..BINS).rev() {
            above[i - 1] = bins[i].and(above[i]);
        }
        let mut below = Bin::EMPTY;
        // Long nodes are to be cut across.
        let slender = size.max_element() / size[axis];
        for i in 0..BINS - 1 {
            below = below.and(bins[i]);
            if below.count > 0.0 && above[i].count > 0.0 {
                let cost = slender * (below.cost() + above[i].cost());
                if best.is_none_or(|(least, ..)| cost < least) {
                    best = Some((cost, axis, i + 1));
                }
            }
        }
    }
    match best {
        Some((_, axis, edge)) => {
            // In an order of their own on each side, so that it is the same on any machine.
            let (mut low, mut high) = (0, leaves.len());
            while low < high {
                if bin_of(&leaves[low], axis) < edge {
                    low += 1;
                } else {
                    high -= 1;
                    leaves.swap(low, high);
                }
            }
            low
        }
        None => middle,
    }
}
