//! Which nodes of a binary tree become nodes of eight: those that make the fewest visits to be expected.
//!
//! A ray that meets a box meets a smaller one within it with about the probability of the ratio of their surfaces. So the cost of
//! a tree is the sum over its nodes of surface times cost of a visit, and what is best for a subtree can be told from what is best
//! for its halves, for each number of slots that it may fill (Ylitie, Karras and Laine, "Efficient Incoherent Ray Traversal on
//! GPUs Through Compressed Wide BVHs", HPG 2017, section 3.1).

use super::node::WIDTH;
use obvhs::bvh2::node::Bvh2Node;

/// What a leaf asks for.
pub(super) struct LeafCost {
    /// How many slots it fills.
    pub slots: usize,
    /// Of a visit, where that of a node is 1.
    pub visit: f32,
}

/// The best division of each subtree.
pub(super) struct Collapse<'a> {
    tree: &'a [Bvh2Node],
    best: Vec<Best>,
}

#[derive(Clone, Copy)]
struct Best {
    /// With `i + 1` slots or less.
    cost: [f32; WIDTH - 1],
    /// How many of `i + 1` slots the first half gets; 0 where fewer slots are as good. The last one is for a node's own slots.
    first: [u8; WIDTH],
}

impl<'a> Collapse<'a> {
    pub fn new(tree: &'a [Bvh2Node], leaf: impl Fn(&Bvh2Node) -> LeafCost) -> Self {
        const NONE: Best = Best { cost: [f32::INFINITY; WIDTH - 1], first: [0; WIDTH] };
        let mut collapse = Self { tree, best: vec![NONE; tree.len()] };
        // Parents before children, then the other way round.
        let mut order = Vec::with_capacity(tree.len());
        let mut waiting = vec![0];
        while let Some(index) = waiting.pop() {
            order.push(index);
            let node = &tree[index as usize];
            if node.prim_count == 0 {
                waiting.extend([node.first_index, node.first_index + 1]);
            }
        }
        for index in order.into_iter().rev().map(|index| index as usize) {
            let node = &tree[index];
            let area = node.aabb().half_area();
            if node.prim_count > 0 {
                let LeafCost { slots, visit } = leaf(node);
                collapse.best[index].cost[slots - 1..].fill(area * visit);
            } else {
                collapse.best[index] = collapse.divide(node.first_index as usize, area);
            }
        }
        collapse
    }

    /// The best for the parent of `first` and its sibling.
    fn divide(&self, first: usize, area: f32) -> Best {
        let (left, right) = (self.best[first].cost, self.best[first + 1].cost);
        let mut best = Best { cost: [f32::INFINITY; WIDTH - 1], first: [0; WIDTH] };
        let shared = |slots: usize| {
            // Written out: this is the inner loop of all, and an iterator's minimum takes two to four times as long.
            let (mut best_share, mut best_cost) = (0, f32::INFINITY);
            for share in 1..slots {
                let cost = left[share - 1] + right[slots - share - 1];
                if cost < best_cost {
                    (best_share, best_cost) = (share, cost);
                }
            }
            (best_share, best_cost)
        };
        let (share, cost) = shared(WIDTH);
        best.first[WIDTH - 1] = share as u8;
        best.cost[0] = area + cost;
        for slots in 2..WIDTH {
            let (share, cost) = shared(slots);
            best.cost[slots - 1] = best.cost[slots - 2];
            if cost < best.cost[slots - 1] {
                best.cost[slots - 1] = cost;
                best.first[slots - 1] = share as u8;
            }
        }
        best
    }

    /// The nodes of the binary tree that share the slots of a node of eight which stands for `root`, an inner node.
    pub fn parts(&self, root: usize) -> Vec<usize> {
        let mut parts = Vec::with_capacity(WIDTH);
        self.open(root, WIDTH, &mut parts);
        parts
    }

    fn open(&self, index: usize, slots: usize, parts: &mut Vec<usize>) {
        let node = &self.tree[index];
        let best = self.best[index].first;
        let slots = (2..=slots).rev().find(|slots| best[slots - 1] > 0);
        match slots {
            Some(slots) if node.prim_count == 0 => {
                let first = node.first_index as usize;
                let share = usize::from(best[slots - 1]);
                self.open(first, share, parts);
                self.open(first + 1, slots - share, parts);
            }
            _ => parts.push(index),
        }
    }
}
