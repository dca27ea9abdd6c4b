//! A tree over many emitters, by which one is chosen for a place that it may light
//! (Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting", PACMCGIT
//! 1(2), 2018).
//!
//! Each node bounds what its emitters can bring to a place. From the root down the choice falls on one of two
//! nodes in proportion to these bounds, all by one sample value, what is left of which is as good as new. The
//! density of the choice is found from the emitter up.

mod bound;
mod build;

pub use bound::{Bound, Viewpoint};

use bound::Ball;
use build::{Leaf, build};

/// Emitters are told by their numbers, from 0.
#[derive(Clone, Debug)]
pub struct Tree {
    root: Ball,
    /// Intensity of all emitters.
    whole: f64,
    /// Child of the root.
    child: u32,
    pairs: Vec<[Node; 2]>,
    /// By pair, the node above it: twice the number of its pair, and 1 more for the second. That of the first
    /// pair means nothing.
    parents: Vec<u32>,
    /// By emitter, its node, counted likewise; [`NONE`] for those that are not in the tree.
    leaves: Vec<u32>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Node {
    ball: Ball,
    /// The pair below it, or the emitter, marked with [`LEAF`].
    child: u32,
}

const LEAF: u32 = 1 << 31;

const NONE: u32 = u32::MAX;

impl Tree {
    /// Tree of fewer than 2³⁰ emitters. An emitter without intensity, `None`, is never chosen. `None` if all
    /// are.
    pub fn new(bounds: Vec<Option<Bound>>) -> Option<Self> {
        let count = bounds.len();
        let emits = |bound: &Bound| bound.intensity > 0.0 && bound.intensity.is_finite();
        let mut leaves: Vec<Leaf> = (0..)
            .zip(bounds)
            .filter_map(|(unit, bound)| Some(Leaf { bound: bound.filter(emits)?, unit }))
            .collect();
        let whole: f64 = leaves.iter().map(|leaf| leaf.bound.intensity).sum();
        if leaves.is_empty() || !whole.is_finite() {
            return None;
        }
        let mut pairs = vec![[Node::default(); 2]; leaves.len() - 1];
        let mut parents = vec![NONE; pairs.len()];
        let (child, bound) = build(&mut leaves, whole, NONE, 0, &mut pairs, &mut parents);
        let mut nodes = vec![NONE; count];
        for (node, Node { child, .. }) in (0..).zip(pairs.as_flattened()) {
            if child & LEAF != 0 {
                nodes[(child & !LEAF) as usize] = node;
            }
        }
        Some(Self { root: Ball::new(&bound, whole), whole, child, pairs, parents, leaves: nodes })
    }

    /// How many choices one emitter takes, about.
    pub fn levels(&self) -> f64 {
        ((self.pairs.len() + 1) as f64).log2()
    }

    /// About the irradiance that all emitters together bring to a place, up to the factor of their
    /// intensities.
    pub fn estimate(&self, from: &Viewpoint) -> f64 {
        self.whole * self.root.importance(from)
    }

    /// An emitter and the probability of its choice. What is left of the sample value `u` is uniform again.
    pub fn choose(&self, from: &Viewpoint, u: &mut f64) -> Option<(u32, f64)> {
        let (mut child, mut probability) = (self.child, 1.0);
        while child & LEAF == 0 {
            let [low, high] = &self.pairs[child as usize];
            let [a, b] = [low, high].map(|node| node.ball.importance(from));
            let all = a + b;
            if all == 0.0 {
                return None;
            }
            let low_probability = a / all;
            let part;
            if *u < low_probability {
                (child, part) = (low.child, low_probability);
                *u /= low_probability;
            } else {
                (child, part) = (high.child, b / all);
                *u = (*u - low_probability) / (1.0 - low_probability);
            }
            *u = u.clamp(0.0, 1f64.next_down());
            probability *= part;
        }
        (probability > 0.0).then_some((child & !LEAF, probability))
    }

    /// The probability with which [`Self::choose`] takes an emitter.
    pub fn probability(&self, from: &Viewpoint, unit: u32) -> f64 {
        let mut node = self.leaves[unit as usize];
        if node == NONE {
            // An emitter that is alone is the root.
            return if self.child == LEAF | unit { 1.0 } else { 0.0 };
        }
        let mut probability = 1.0;
        loop {
            let pair = (node >> 1) as usize;
            let both = &self.pairs[pair];
            let own = both[(node & 1) as usize].ball.importance(from);
            if own == 0.0 {
                return 0.0;
            }
            let other = both[(node & 1 ^ 1) as usize].ball.importance(from);
            probability *= own / (own + other);
            if pair == 0 {
                return probability;
            }
            node = self.parents[pair];
        }
    }
}
