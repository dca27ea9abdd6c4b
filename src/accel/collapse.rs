//! Which nodes of a binary tree become nodes of eight: those that make the fewest visits to be expected.
//!
//! A ray that meets a box meets a smaller one within it with about the probability of the ratio of their
//! surfaces. So the cost of a tree is the sum over its nodes of surface times cost of a visit, and what is
//! best for a subtree can be told from what is best for its halves, for each number of slots that it may fill
//! (Ylitie, Karras and Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", HPG
//! 2017, section 3.1).

use super::node::WIDTH;
use obvhs::bvh2::node::Bvh2Node;
use smallvec::SmallVec;

/// What a leaf asks for.
pub(super) struct LeafCost {
    /// How many slots it fills.
    pub slots: usize,
    /// Cost of a visit, where that of a node is 1.
    pub visit: f32,
}

/// What the best division of a subtree costs with `i + 1` slots or less.
pub(super) type Costs = [f32; WIDTH - 1];

/// The best split of a subtree's slots: how many of `i + 1` slots the left half gets; 0 where fewer slots are
/// as good. The last one is for a node's own slots.
pub(super) type SlotSplit = [u8; WIDTH];

/// The best division of a leaf.
pub(super) fn leaf(area: f32, LeafCost { slots, visit }: LeafCost) -> (SlotSplit, Costs) {
    let mut costs = [f32::INFINITY; WIDTH - 1];
    costs[slots - 1..].fill(area * visit);
    ([0; WIDTH], costs)
}

/// The best division of a node by those of its children.
pub(super) fn divide(left: &Costs, right: &Costs, area: f32) -> (SlotSplit, Costs) {
    let shared = |slots: usize| {
        // Written out: this is the inner loop of all, and an iterator's minimum takes two to four times as
        // long.
        let (mut best_left, mut best_cost) = (0, f32::INFINITY);
        for left_slots in 1..slots {
            let cost = left[left_slots - 1] + right[slots - left_slots - 1];
            if cost < best_cost {
                (best_left, best_cost) = (left_slots, cost);
            }
        }
        (best_left, best_cost)
    };
    let (mut splits, mut costs) = ([0; WIDTH], [f32::INFINITY; WIDTH - 1]);
    let (left_slots, cost) = shared(WIDTH);
    splits[WIDTH - 1] = left_slots as u8;
    costs[0] = area + cost;
    for slots in 2..WIDTH {
        let (left_slots, cost) = shared(slots);
        costs[slots - 1] = costs[slots - 2];
        if cost < costs[slots - 1] {
            costs[slots - 1] = cost;
            splits[slots - 1] = left_slots as u8;
        }
    }
    (splits, costs)
}

/// The indices of all nodes of a binary tree: parents before children, what is below the first child before
/// what is below the second.
pub(super) fn preorder(tree: &[Bvh2Node]) -> Vec<u32> {
    let mut order = Vec::with_capacity(tree.len());
    let mut waiting = vec![0];
    while let Some(index) = waiting.pop() {
        order.push(index);
        let node = &tree[index as usize];
        if node.prim_count == 0 {
            waiting.extend([node.first_index + 1, node.first_index]);
        }
    }
    order
}

/// The nodes of a binary tree that fill the slots of a node of eight which stands for `root`, an inner node.
pub(super) fn open(tree: &[Bvh2Node], splits: &[SlotSplit], root: usize) -> SmallVec<[usize; WIDTH]> {
    let mut parts = SmallVec::new();
    open_some(tree, splits, root, WIDTH, &mut parts);
    parts
}

fn open_some(
    tree: &[Bvh2Node],
    splits: &[SlotSplit],
    index: usize,
    slots: usize,
    parts: &mut SmallVec<[usize; WIDTH]>,
) {
    let node = &tree[index];
    let of_first = &splits[index];
    match (2..=slots).rev().find(|slots| of_first[slots - 1] > 0) {
        Some(slots) if node.prim_count == 0 => {
            let first = node.first_index as usize;
            let left_slots = usize::from(of_first[slots - 1]);
            open_some(tree, splits, first, left_slots, parts);
            open_some(tree, splits, first + 1, slots - left_slots, parts);
        }
        _ => parts.push(index),
    }
}
