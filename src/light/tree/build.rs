//! How emitters are divided among the nodes of a tree.
//!
//! A node is cut across the axis and at the place where the sum over both sides of intensity × extent² ×
//! directions is least (Conty Estevez and Kulla 2018, section 4.4), out of some places on each axis.

use super::bound::{Ball, Bound};
use super::{LEAF, Node};
use crate::geometry::{Bounds, Vec3};

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

/// Fills the pairs of nodes below one that holds all `leaves`, at least one, one pair fewer than there are
/// leaves; returns that node's child and bound.
///
/// `first` is the index of the first pair; `parents` gets the index of the node above each pair.
pub(super) fn build(
    leaves: &mut [Leaf],
    whole: f64,
    above: u32,
    first: u32,
    pairs: &mut [[Node; 2]],
    parents: &mut [u32],
) -> (u32, Bound) {
    let ([pair, pairs @ ..], [parent, parents @ ..]) = (pairs, parents) else {
        return (LEAF | leaves[0].unit, leaves[0].bound);
    };
    *parent = above;
    let many = leaves.len() > PARALLEL;
    let middle = cut(leaves);
    let (low, high) = leaves.split_at_mut(middle);
    let (low_pairs, high_pairs) = pairs.split_at_mut(low.len() - 1);
    let (low_parents, high_parents) = parents.split_at_mut(low.len() - 1);
    let second = first + low.len() as u32;
    let mut build_low = || build(low, whole, 2 * first, first + 1, low_pairs, low_parents);
    let mut build_high = || build(high, whole, 2 * first + 1, second, high_pairs, high_parents);
    let sides = if many { rayon::join(build_low, build_high) } else { (build_low(), build_high()) };
    let ((low_child, low_bound), (high_child, high_bound)) = sides;
    *pair = [(low_child, low_bound), (high_child, high_bound)]
        .map(|(child, bound)| Node { ball: Ball::new(&bound, whole), child });
    (first, low_bound.union(high_bound))
}

/// What is summed of the emitters of a bin.
#[derive(Clone, Copy)]
struct Bin {
    bounds: Bounds,
    intensity: f64,
    count: f64,
    /// Sum of the directions that they face; those that face all directions add none.
    facing: Vec3,
}

impl Bin {
    const EMPTY: Self = Self { bounds: Bounds::EMPTY, intensity: 0.0, count: 0.0, facing: Vec3::ZERO };

    fn of(bound: &Bound) -> Self {
        Self {
            bounds: bound.bounds,
            intensity: bound.intensity,
            count: 1.0,
            facing: bound.axis * bound.spread.cos().max(0.0),
        }
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
        let directions = 4.0 - 3.0 * self.facing.length() / self.count;
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
