//! How far a surface reaches in a direction, by bisecting space where it might be.

use crate::geometry::{Bounds, Vec3};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Halvings of the whole box by which each side is known to 1/1024.
pub(super) const COARSE: u32 = 30;

/// And to 1/4,000,000, for surfaces of which little more than the farthest point is left by then.
pub(super) const FINE: u32 = 66;

/// Cells looked at before the answer is left as loose as it is.
const MOST_CELLS: usize = 20_000;

struct Cell {
    /// Upper bound on what a point of the cell reaches.
    reach: f64,
    bounds: Bounds,
    depth: u32,
}

impl Ord for Cell {
    /// The farthest first; of equally far ones the smallest, which ends the search soonest.
    fn cmp(&self, other: &Self) -> Ordering {
        self.reach.total_cmp(&other.reach).then(self.depth.cmp(&other.depth))
    }
}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Cell {}

/// An upper bound on direction · x over all points x of a surface that lies within `start`, above the least
/// one by what is left of the box after `halvings`. `None` where the surface is nowhere. `is_free` says of a
/// box that the farthest point of the surface is not in it, for instance because there is nothing of the
/// surface in it.
pub(super) fn support(
    direction: Vec3,
    start: Bounds,
    halvings: u32,
    is_free: impl Fn(Bounds) -> bool,
) -> Option<f64> {
    let cell = |bounds: Bounds, depth| Cell { reach: bounds.support(direction), bounds, depth };
    let mut waiting = BinaryHeap::from([cell(start, 0)]);
    let mut seen = 0;
    while let Some(Cell { reach, bounds, depth }) = waiting.pop() {
        if is_free(bounds) {
            continue;
        }
        seen += 1;
        if depth >= halvings || seen >= MOST_CELLS {
            return Some(reach);
        }
        let size = bounds.max - bounds.min;
        let axis = if size.x >= size.y.max(size.z) {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let middle = bounds.centre()[axis];
        let (mut low, mut high) = (bounds, bounds);
        low.max[axis] = middle;
        high.min[axis] = middle;
        waiting.push(cell(low, depth + 1));
        waiting.push(cell(high, depth + 1));
    }
    None
}
