//! Meshes as parts of solids: with vertices that are not rounded to `f32`, so that their faces coincide with
//! those of other shapes where a file says so, and with a tree for all that a line crosses.

use super::{Mesh, MeshData, error_bound, to_f64};
use crate::geometry::{Bounds, Ray, Transform, Vec3};
use crate::shape::ShapeError;
use std::collections::HashMap;
use std::sync::Arc;

/// What a mesh keeps when it is part of a solid.
#[derive(Clone, Debug)]
pub(super) struct Exact {
    pub positions: Vec<Vec3>,
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

impl Mesh {
    /// A mesh in its file's coordinates where a transform puts it, as a part of a solid. `placed` is the
    /// same, rounded.
    pub fn part(data: &MeshData, to_world: &Transform, placed: MeshData) -> Result<Self, ShapeError> {
        let mut mesh = Self::new(placed)?;
        let positions = data.positions.iter().map(|&position| to_world.point(to_f64(position))).collect();
        mesh.exact = Some(Arc::new(Exact::new(positions, &mesh.data.indices)));
        mesh.bounds = Bounds::of((0..mesh.triangle_count() as u32).flat_map(|i| mesh.triangle(i)));
        // To place a vertex rounds as often again.
        mesh.error = 2.0 * error_bound(mesh.bounds);
        Ok(mesh)
    }

    /// An edge, by the indices of its vertices, that is not passed as often in one direction as in the other;
    /// `None` where the mesh is closed. Vertices at the same place are one.
    pub fn open_edge(&self) -> Option<[u32; 2]> {
        let mut places: HashMap<[u64; 3], u32> = HashMap::new();
        let one_of_place: Vec<u32> = (0..self.data.positions.len() as u32)
            .map(|index| {
                let position = match &self.exact {
                    Some(exact) => exact.positions[index as usize],
                    None => to_f64(self.data.positions[index as usize]),
                };
                // With -0 as 0.
                *places.entry(position.to_array().map(|x| (x + 0.0).to_bits())).or_insert(index)
            })
            .collect();
        let mut balance: HashMap<[u32; 2], i64> = HashMap::new();
        let edges = self.data.indices.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let edges = edges.map(|edge| edge.map(|index| one_of_place[index as usize]));
        for [a, b] in edges.clone() {
            *balance.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
        }
        edges.into_iter().find(|&[a, b]| a != b && balance[&[a.min(b), a.max(b)]] != 0)
    }
}

impl Exact {
    fn new(positions: Vec<Vec3>, indices: &[[u32; 3]]) -> Self {
        let boxes: Vec<Bounds> = indices
            .iter()
            .map(|triangle| Bounds::of(triangle.map(|index| positions[index as usize])))
            .collect();
        let mut exact = Self { positions, nodes: Vec::new(), order: (0..indices.len() as u32).collect() };
        exact.split(&boxes, 0, indices.len());
        exact
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
