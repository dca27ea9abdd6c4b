//! Meshes as parts of solids: with vertices that are not rounded to `f32`, so that their faces coincide with
//! those of other shapes where a file says so.

use super::{Mesh, MeshData, error_bound, to_f64};
use crate::geometry::{Bounds, Transform};
use crate::shape::ShapeError;
use std::collections::HashMap;
use std::sync::Arc;

impl Mesh {
    /// A mesh in its file's coordinates where a transform puts it, as a part of a solid. `placed` is the
    /// same, rounded.
    pub fn part(data: &MeshData, to_world: &Transform, placed: MeshData) -> Result<Self, ShapeError> {
        let mut mesh = Self::new(placed)?;
        let positions = data.positions.iter().map(|&position| to_world.point(to_f64(position))).collect();
        mesh.exact = Some(Arc::new(positions));
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
                    Some(exact) => exact[index as usize],
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
