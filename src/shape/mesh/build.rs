//! Meshes from transforms: placed file data, rectangles and cubes with Mitsuba 3's conventions.

use super::{Mesh, MeshData, to_f64};
use crate::geometry::{Transform, Vec3};
use crate::shape::{Rectangle, ShapeError};
use rayon::prelude::*;

impl MeshData {
    /// The mesh under an affine map, rounded to `f32` once.
    ///
    /// Vertex normals go by the inverse transpose. Under a mirroring map the winding of a mesh with vertex
    /// normals is reversed, so that its geometric side stays the side of its shading normals, which is
    /// what Mitsuba shades and emits by. Without vertex normals the winding stays, as there: the mesh is
    /// turned inside out.
    pub fn transformed(&self, to_world: &Transform) -> Self {
        let mut placed = self.clone();
        placed.positions.par_iter_mut().with_min_len(1 << 12).for_each(|position| {
            *position = to_world.point(to_f64(*position)).as_vec3().to_array();
        });
        if let Some(normals) = &mut placed.normals {
            for normal in normals {
                let image = to_world.normal(to_f64(*normal)).try_normalize().unwrap_or(Vec3::ZERO);
                *normal = image.as_vec3().to_array();
            }
            if to_world.mirrors() {
                placed.indices.iter_mut().for_each(|indices| indices.swap(1, 2));
                placed.is_rewound ^= true;
            }
        }
        placed
    }
}

impl Mesh {
    /// The image of [-1, 1]² in z = 0 with normal +z and uv from (0, 0) at (-1, -1) to (1, 1).
    pub fn rectangle(to_world: &Transform, flip_normals: bool) -> Result<Self, ShapeError> {
        let data = MeshData {
            positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]],
            indices: vec![[0, 1, 2], [2, 3, 0]],
            normals: Some(vec![[0.0, 0.0, 1.0]; 4]),
            uvs: Some(vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]),
            flip_normals,
            ..MeshData::default()
        };
        let mut data = data.transformed(to_world);
        // Flat: the geometric normals are exact for the rounded vertices, the vertex normals are not.
        data.normals = None;
        let mut mesh = Self::new(data)?;
        let corner = |index: usize| to_f64(mesh.data.positions[index]);
        mesh.rectangle = Rectangle::new(corner(0), [corner(1) - corner(0), corner(3) - corner(0)]);
        Ok(mesh)
    }

    /// The image of [-1, 1]³ with outward normals, each face with its own vertices and uv.
    pub fn cube(to_world: &Transform, flip_normals: bool) -> Result<Self, ShapeError> {
        let mut data = MeshData::cube(flip_normals).transformed(to_world);
        data.normals = None;
        Self::new(data)
    }
}

impl MeshData {
    /// [-1, 1]³. Its normals only say which side is outside.
    pub fn cube(flip_normals: bool) -> Self {
        let mut data = Self { flip_normals, ..Self::default() };
        let (mut normals, mut uvs) = (Vec::new(), Vec::new());
        for [normal, u_axis, v_axis] in FACES {
            let first = data.positions.len() as u32;
            for uv in [[0.0f32, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]] {
                let [u, v] = uv.map(|x| 2.0 * x - 1.0);
                data.positions.push(std::array::from_fn(|i| normal[i] + u * u_axis[i] + v * v_axis[i]));
                normals.push(normal);
                uvs.push(uv);
            }
            data.indices.extend([[first, first + 1, first + 2], [first + 3, first, first + 2]]);
        }
        data.normals = Some(normals);
        data.uvs = Some(uvs);
        data
    }
}

/// Outward normal and the directions of growing u and v of the cube's faces.
const FACES: [[[f32; 3]; 3]; 6] = [
    [[0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]],
    [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]],
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]],
    [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]],
    [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    [[0.0, 0.0, -1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]],
];
