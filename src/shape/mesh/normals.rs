//! Smooth normals for meshes that come without.

use super::to_f64;
use crate::geometry::Vec3;

/// Vertex normals as means of the adjoining triangles' normals, weighted by the angle at the vertex
/// (Thürmer and Wüthrich, "Computing Vertex Normals from Polygonal Facets", JGT 3(1), 1998).
/// Mitsuba 3 does this for files without normals unless `face_normals` is set. Vertices of which nothing can
/// be said get [0, 0, 0], where shading falls back to the geometric normal. Indices must be valid.
pub fn compute_vertex_normals(positions: &[[f32; 3]], indices: &[[u32; 3]]) -> Vec<[f32; 3]> {
    let mut sums = vec![Vec3::ZERO; positions.len()];
    for corners in indices {
        let vertices = corners.map(|index| to_f64(positions[index as usize]));
        let [a, b, c] = vertices;
        let Some(normal) = (b - a).cross(c - a).try_normalize() else { continue };
        for i in 0..3 {
            let (next, last) = (vertices[(i + 1) % 3] - vertices[i], vertices[(i + 2) % 3] - vertices[i]);
            // atan2 keeps the digits of small and flat angles, which acos would lose.
            let angle = next.cross(last).length().atan2(next.dot(last));
            sums[corners[i] as usize] += normal * angle;
        }
    }
    sums.iter().map(|sum| sum.try_normalize().unwrap_or(Vec3::ZERO).as_vec3().to_array()).collect()
}
