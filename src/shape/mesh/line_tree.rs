//! A tree of a mesh's triangles for all that a line crosses.

use crate::geometry::{Bounds, Ray};

#[derive(Clone, Debug)]
pub(super) struct LineTree {
    nodes: Vec<Node>,
    /// Triangles in the order of the leaves.
    order: Vec<u32>,
}

#[derive(Clone, Debug)]
struct Node {
    bounds: Bounds,
    /// Triangles of a leaf as a range of `order`. An inner node has none: its first child comes next.
    leaf: Option<[u32; 2]>,
    /// Index past the last node below.
    end: u32,
}

/// Most triangles of a leaf.
const LEAF: usize = 4;

impl LineTree {
    /// The tree of triangles with these boxes.
    pub fn new(boxes: &[Bounds]) -> Self {
        let mut tree = Self { nodes: Vec::new(), order: (0..boxes.len() as u32).collect() };
        tree.split(boxes, 0, boxes.len());
        tree
    }

    /// A node of a part of `order`, halved across the longest side of its box.
    fn split(&mut self, boxes: &[Bounds], first: usize, last: usize) {
        let index = self.nodes.len();
        let own = &mut self.order[first..last];
        let bounds = Bounds::of_all(own.iter().map(|&triangle| boxes[triangle as usize]));
        let leaf = (own.len() <= LEAF).then_some([first as u32, last as u32]);
        self.nodes.push(Node { bounds, leaf, end: 0 });
        if leaf.is_none() {
            let size = bounds.max - bounds.min;
            let axis =
                (0..3).fold(0, |longest, axis| if size[axis] > size[longest] { axis } else { longest });
            let middle = own.len() / 2;
            let place = |triangle: &u32| boxes[*triangle as usize].centre()[axis];
            own.select_nth_unstable_by(middle, |a, b| place(a).total_cmp(&place(b)).then(a.cmp(b)));
            self.split(boxes, first, first + middle);
            self.split(boxes, first + middle, last);
        }
        self.nodes[index].end = self.nodes.len() as u32;
    }

    /// Visits all triangles that the whole line may cross, and some others.
    pub fn near_line(&self, ray: &Ray, mut visit: impl FnMut(u32)) {
        let inverse = ray.direction.map(|d| 1.0 / d);
        let mut node = 0;
        while let Some(Node { bounds, leaf, end }) = self.nodes.get(node) {
            // More than the exact test can be off by what it rounds before it becomes exact.
            let reach = bounds.min.abs().max(bounds.max.abs()) + ray.origin.abs();
            let slack = 64.0 * f64::EPSILON * reach.max_element();
            let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
            for axis in 0..3 {
                let low = bounds.min[axis] - slack - ray.origin[axis];
                let high = bounds.max[axis] + slack - ray.origin[axis];
                if inverse[axis].is_finite() {
                    let (a, b) = (low * inverse[axis], high * inverse[axis]);
                    (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
                } else if low > 0.0 || high < 0.0 {
                    leave = f64::NEG_INFINITY;
                }
            }
            if enter > leave {
                node = *end as usize;
                continue;
            }
            if let Some([first, last]) = *leaf {
                self.order[first as usize..last as usize].iter().for_each(|&triangle| visit(triangle));
            }
            node += 1;
        }
    }
}
