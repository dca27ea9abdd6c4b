//! A binary tree over boxes, by the crate obvhs (parallel locally-ordered clustering with reinsertion).
//!
//! Many boxes are clustered twice: at first those that lie near each other by themselves, up to small
//! clusters, then these. So there is work for several threads, clustering needs its memory for a part of the
//! boxes at a time and finds that part near at hand; and only the small clusters know where the parts ended.

use super::collapse::{Costs, LeafCost, SlotSplit, divide, leaf, preorder};
use super::node::WIDTH;
use super::surfaces::Item;
use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::{Boundable, BvhBuildParams};
use rayon::prelude::*;
use std::time::Duration;

/// Most boxes that are clustered at once.
const MOST_OF_PART: usize = 1 << 14;

/// Most boxes of a cluster where there are more than these.
const MOST_OF_CLUSTER: u32 = 64;

/// The fraction of the nodes that are put where they do better, where a tree is made in one go: more would
/// take as long as all else.
const REINSERTED: f32 = 0.1;

/// Likewise of those above the clusters, which are few.
const REINSERTED_ABOVE: f32 = 1.0;

/// Full packets of triangles make the best leaves. All rounds of clustering are equally thorough: with hasty
/// first ones rays of some meshes make 5 % more visits.
const PARAMETERS: BvhBuildParams = BvhBuildParams {
    max_prims_per_leaf: 4,
    search_depth_threshold: 0,
    reinsertion_batch_ratio: 0.0,
    ..BvhBuildParams::fast_build()
};

/// A binary tree, and how its nodes are best divided among nodes of eight.
#[derive(Default)]
pub(super) struct Tree {
    /// The first is the root. Children stand side by side.
    pub nodes: Vec<Bvh2Node>,
    pub splits: Vec<SlotSplit>,
    /// Primitives in the order of the leaves.
    pub order: Vec<u32>,
    /// How many nodes are above the clusters, their roots included. All others are below one of these roots.
    pub top: usize,
}

/// Clusters of a part of the boxes.
#[derive(Default)]
struct Clusters {
    roots: Vec<Root>,
    /// What is below the roots.
    nodes: Vec<Bvh2Node>,
    splits: Vec<SlotSplit>,
    order: Vec<u32>,
}

#[derive(Clone, Copy)]
struct Root {
    node: Bvh2Node,
    splits: SlotSplit,
    costs: Costs,
}

impl Boundable for Root {
    fn aabb(&self) -> Aabb {
        *self.node.aabb()
    }
}

/// The tree over some boxes; there must be any. `cost` is that of a leaf with these primitives.
pub(super) fn grow(mut items: Vec<Item>, cost: impl Fn(&[u32]) -> LeafCost + Sync) -> Tree {
    if items.len() <= MOST_OF_PART {
        return join(vec![cluster(&items, u32::MAX, REINSERTED, &cost)]);
    }
    let parts = parts(&mut items).into_par_iter().with_max_len(1);
    let parts = parts.map(|items| cluster(items, MOST_OF_CLUSTER, 0.0, &cost)).collect();
    drop(items);
    join(parts)
}

/// Boxes that lie near each other, few enough to be clustered at once.
fn parts(items: &mut [Item]) -> Vec<&mut [Item]> {
    if items.len() <= MOST_OF_PART {
        return vec![items];
    }
    let middle = halve(items);
    let (left, right) = items.split_at_mut(middle);
    let (mut left, right) = rayon::join(|| parts(left), || parts(right));
    left.extend(right);
    left
}

/// Twice of a box.
fn centre(item: &Item) -> Vec3A {
    Vec3A::from(item.min) + Vec3A::from(item.max)
}

/// Sorts boxes into two groups, which are of different halves of the space or of nearly equal size. Returns
/// the size of the first.
fn halve(items: &mut [Item]) -> usize {
    let around = |items: &[Item]| {
        items.iter().fold(Aabb::INVALID, |all, item| all.union(&Aabb::from_point(centre(item))))
    };
    let centres =
        items.par_chunks(MOST_OF_PART).map(around).reduce(|| Aabb::INVALID, |all, other| all.union(&other));
    let size = centres.max - centres.min;
    let axis = (0..3).fold(0, |longest, axis| if size[axis] > size[longest] { axis } else { longest });
    let plane = centres.min[axis] + 0.5 * size[axis];
    let (mut middle, mut end) = (0, items.len());
    while middle < end {
        if centre(&items[middle])[axis] <= plane {
            middle += 1;
        } else {
            end -= 1;
            items.swap(middle, end);
        }
    }
    // Or else it could take as many steps as there are boxes.
    let few = items.len() / 8;
    if middle < few || middle > items.len() - few {
        middle = items.len() / 2;
        items.select_nth_unstable_by(middle, |a, b| centre(a)[axis].total_cmp(&centre(b)[axis]));
    }
    middle
}

/// Clusters of at most this number of boxes.
fn cluster(items: &[Item], most: u32, reinserted: f32, cost: &impl Fn(&[u32]) -> LeafCost) -> Clusters {
    let parameters = BvhBuildParams { reinsertion_batch_ratio: reinserted, ..PARAMETERS };
    let tree = build_bvh2(items, parameters, &mut Duration::default());
    let order: Vec<u32> = tree.primitive_indices.iter().map(|&item| items[item as usize].primitive).collect();
    let mut splits = vec![[0; WIDTH]; tree.nodes.len()];
    // Nodes whose parents are still to come: the index, the number of boxes, unless too many, and the costs.
    let mut done: Vec<(usize, Option<(u32, Costs)>)> = Vec::new();
    let mut roots = Vec::new();
    for index in preorder(&tree.nodes).into_iter().rev().map(|index| index as usize) {
        let node = &tree.nodes[index];
        let area = node.aabb().half_area();
        let own = match done[..] {
            [.., right, left] if node.prim_count == 0 => {
                done.truncate(done.len() - 2);
                match (left.1, right.1) {
                    (Some((first, left)), Some((second, right))) if first + second <= most => {
                        Some((first + second, divide(&left, &right, area)))
                    }
                    _ => {
                        let found = |(index, own): (usize, Option<(u32, Costs)>)| Some((index, own?.1));
                        roots.extend([right, left].into_iter().filter_map(found));
                        None
                    }
                }
            }
            _ => {
                let first = node.first_index as usize;
                let cost = cost(&order[first..first + node.prim_count as usize]);
                Some((node.prim_count, leaf(area, cost)))
            }
        };
        done.push((
            index,
            own.map(|(count, (own, costs))| {
                splits[index] = own;
                (count, costs)
            }),
        ));
    }
    roots.extend(done.into_iter().filter_map(|(index, own)| Some((index, own?.1))));
    let mut clusters = Clusters::default();
    for (index, costs) in roots.into_iter().rev() {
        let node = clusters.lay(tree.nodes[index], &tree.nodes, &splits, &order);
        clusters.roots.push(Root { node, splits: splits[index], costs });
    }
    clusters
}

impl Clusters {
    /// Takes over what is below a node of a tree; returns the node that this is below of here.
    fn lay(
        &mut self,
        mut root: Bvh2Node,
        nodes: &[Bvh2Node],
        splits: &[SlotSplit],
        order: &[u32],
    ) -> Bvh2Node {
        let mut waiting = vec![None];
        while let Some(place) = waiting.pop() {
            let next = self.nodes.len();
            let node = match place {
                None => &mut root,
                Some(index) => &mut self.nodes[index],
            };
            let first = node.first_index as usize;
            if node.prim_count > 0 {
                node.first_index = self.order.len() as u32;
                self.order.extend(&order[first..first + node.prim_count as usize]);
            } else {
                node.first_index = next as u32;
                self.nodes.extend(&nodes[first..first + 2]);
                self.splits.extend(&splits[first..first + 2]);
                waiting.extend([Some(next + 1), Some(next)]);
            }
        }
        root
    }
}

/// The tree over all clusters.
fn join(parts: Vec<Clusters>) -> Tree {
    let mut roots: Vec<Root> = parts.iter().flat_map(|part| &part.roots).copied().collect();
    let parameters =
        BvhBuildParams { max_prims_per_leaf: 1, reinsertion_batch_ratio: REINSERTED_ABOVE, ..PARAMETERS };
    let above = build_bvh2(&roots, parameters, &mut Duration::default());
    let mut tree = Tree { top: above.nodes.len(), ..Tree::default() };
    let below: usize = parts.iter().map(|part| part.nodes.len()).sum();
    tree.nodes.reserve_exact(tree.top + below);
    tree.splits.reserve_exact(tree.top + below);
    tree.order.reserve_exact(parts.iter().map(|part| part.order.len()).sum());
    tree.nodes.extend(&above.nodes);
    tree.splits.resize(tree.top, [0; WIDTH]);
    let mut joined = 0;
    for part in parts {
        let (base, start) = (tree.nodes.len() as u32, tree.order.len() as u32);
        let moved = |node: Bvh2Node| {
            let by = if node.prim_count == 0 { base } else { start };
            Bvh2Node { first_index: node.first_index + by, ..node }
        };
        for root in &mut roots[joined..][..part.roots.len()] {
            root.node = moved(root.node);
        }
        joined += part.roots.len();
        tree.nodes.extend(part.nodes.into_iter().map(moved));
        tree.splits.extend(part.splits);
        tree.order.extend(part.order);
    }
    let mut done: Vec<Costs> = Vec::new();
    for index in preorder(&above.nodes).into_iter().rev().map(|index| index as usize) {
        let node = &above.nodes[index];
        let (splits, costs) = match done[..] {
            [.., right, left] if node.prim_count == 0 => {
                done.truncate(done.len() - 2);
                divide(&left, &right, node.aabb().half_area())
            }
            _ => {
                let root = &roots[above.primitive_indices[node.first_index as usize] as usize];
                tree.nodes[index] = root.node;
                (root.splits, root.costs)
            }
        };
        tree.splits[index] = splits;
        done.push(costs);
    }
    tree
}
