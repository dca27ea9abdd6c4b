//! Triangle meshes: `f32` vertices, everything computed from them in `f64`.

mod build;
mod deform;
mod exact;
mod line_tree;
mod normals;
mod rectangle_surface;
mod sampling;

use super::areas::AreaDistribution;
use super::crossing::{Crossing, Crossings};
use super::rectangle::Rectangle;
use super::triangle::{RaySpace, TriangleHit};
use super::{Hit, NO_INSTANCE, Parametrisation, ShapeError, SurfaceHit};
use crate::geometry::{Bounds, Frame, Ray, SurfacePoint, Vec3};
pub use deform::Deformation;
use line_tree::LineTree;
pub use normals::compute_vertex_normals;
use rayon::prelude::*;
pub use rectangle_surface::RectangleSurface;
use std::sync::{Arc, OnceLock};

/// What a mesh is made from. Positions and normals are in world space.
#[derive(Clone, Debug, Default)]
pub struct MeshData {
    /// Positions of the vertices, in the mesh's own coordinates.
    pub positions: Vec<[f32; 3]>,
    /// Three vertices a triangle, counter-clockwise seen from the side that the normal points to.
    pub indices: Vec<[u32; 3]>,
    /// Vertex normals of any length; without them the mesh is flat-shaded.
    pub normals: Option<Vec<[f32; 3]>>,
    /// Texture coordinates of the vertices; `None` where the file has none.
    pub uvs: Option<Vec<[f32; 2]>>,
    /// Further values that textures can ask for by name.
    pub attributes: Vec<MeshAttribute>,
    /// Turns geometric and shading normals.
    pub flip_normals: bool,
    /// Whether the second and the third vertex of each triangle have changed places, so that it winds around
    /// its normals although a transform mirrors it.
    pub is_rewound: bool,
}

/// Values of the vertices or the triangles of a mesh, as its file names them.
///
/// Three channels are a colour (linear sRGB, made into spectra where they stand, which are interpolated). In
/// Mitsuba 3, which interpolates the coefficients, they are so only if the name contains "color".
#[derive(Clone, Debug, PartialEq)]
pub struct MeshAttribute {
    /// With Mitsuba 3's prefix: `vertex_color`, `face_density`.
    pub name: String,
    /// Whether there is a value for each triangle; otherwise for each vertex, interpolated between them.
    pub per_face: bool,
    /// Numbers to a value: 1 or 3.
    pub channels: usize,
    /// `channels` numbers for each vertex or triangle, in their order.
    pub values: Vec<f32>,
}

impl MeshData {
    /// Bytes held.
    pub fn memory(&self) -> usize {
        let values: usize = self.attributes.iter().map(|attribute| size_of_val(&attribute.values[..])).sum();
        let normals = self.normals.as_ref().map_or(0, |normals| size_of_val(&normals[..]));
        let uvs = self.uvs.as_ref().map_or(0, |uvs| size_of_val(&uvs[..]));
        size_of_val(&self.positions[..]) + size_of_val(&self.indices[..]) + normals + uvs + values
    }

    /// The volume that it encloses if it is closed, negative where its faces wind inward; `flip_normals` is
    /// left aside.
    pub fn volume(&self) -> f64 {
        let at =
            |index: u32| self.positions.get(index as usize).map_or(Vec3::ZERO, |&position| to_f64(position));
        // From one of its own places, lest differences of large numbers be left.
        let origin = self.indices.first().map_or(Vec3::ZERO, |&[index, ..]| at(index));
        let of_triangle = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|index| at(index) - origin);
            a.dot(b.cross(c))
        };
        self.indices.iter().map(of_triangle).sum::<f64>() / 6.0
    }
}

/// A validated mesh. Degenerate triangles are kept but neither hit nor sampled.
#[derive(Clone, Debug)]
pub struct Mesh {
    data: Arc<MeshData>,
    /// Its vertices as they were before they were rounded, if it is part of a solid.
    exact: Option<Arc<Vec<Vec3>>>,
    bounds: Bounds,
    /// Error bound of a point on it and of the test against it; see [`Mesh::error_bound`].
    error: f64,
    /// Areas of triangles. Made when they are first asked for: few meshes are lights.
    areas: OnceLock<AreaDistribution>,
    /// Likewise for [`Mesh::crossings`].
    lines: OnceLock<LineTree>,
    /// The rectangle, if the mesh is one of two triangles.
    rectangle: Option<Rectangle>,
}

impl Mesh {
    /// A mesh of these triangles.
    ///
    /// # Errors
    /// Where its indices, normals or coordinates do not fit its vertices.
    pub fn new(data: MeshData) -> Result<Self, ShapeError> {
        validate(&data)?;
        let used =
            |indices: &[u32; 3]| Bounds::of(indices.map(|index| to_f64(data.positions[index as usize])));
        let bounds = data.indices.par_iter().with_min_len(1 << 12).map(used);
        let bounds = bounds.reduce(|| Bounds::EMPTY, Bounds::union);
        let data = Arc::new(data);
        Ok(Self {
            error: error_bound(bounds),
            bounds,
            areas: OnceLock::new(),
            lines: OnceLock::new(),
            data,
            exact: None,
            rectangle: None,
        })
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.data.indices.len()
    }

    /// What it was made of.
    pub fn data(&self) -> &MeshData {
        &self.data
    }

    /// The vertices of a triangle as stored.
    pub fn triangle_f32(&self, triangle: u32) -> [[f32; 3]; 3] {
        let [a, b, c] = self.data.indices[triangle as usize];
        let at = |index: u32| self.data.positions[index as usize];
        [at(a), at(b), at(c)]
    }

    /// The corners of a triangle.
    #[inline]
    pub fn triangle(&self, triangle: u32) -> [Vec3; 3] {
        if let Some(exact) = &self.exact {
            return self.data.indices[triangle as usize].map(|index| exact[index as usize]);
        }
        let [a, b, c] = self.triangle_f32(triangle);
        [to_f64(a), to_f64(b), to_f64(c)]
    }

    /// Whether a triangle has no area, so that it has no normal and cannot be hit.
    pub fn is_degenerate(&self, triangle: u32) -> bool {
        let [a, b, c] = self.triangle(triangle);
        (b - a).cross(c - a) == Vec3::ZERO
    }

    /// Nearest hit by a loop over all triangles.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let space = RaySpace::new(ray);
        let mut nearest: Option<Hit> = None;
        for triangle in 0..self.triangle_count() as u32 {
            let t_max = nearest.map_or(ray.t_max, |hit| hit.t);
            if self.is_degenerate(triangle) {
                continue;
            }
            if let Some(hit) = space.intersect(self.triangle(triangle), t_max) {
                let TriangleHit { t, barycentric } = hit;
                nearest = Some(Hit { t, shape: 0, triangle, instance: NO_INSTANCE, barycentric });
            }
        }
        nearest
    }

    /// All crossings along the whole line: of a closed mesh as many inwards as outwards, also through edges
    /// and vertices.
    pub fn crossings(&self, ray: &Ray) -> Crossings {
        let space = RaySpace::new(ray);
        let mut found = Crossings::new();
        // Seen from its other end, the z axis turns everything round.
        let facing = if space.shear[2] > 0.0 { 1 } else { -1 };
        let test = |triangle: u32| {
            let sheared = self.triangle(triangle).map(|vertex| space.sheared(vertex));
            let Some(side) = RaySpace::passes(sheared) else { return };
            let (TriangleHit { t, barycentric }, extent) = RaySpace::place(sheared);
            let slope = self.surface(triangle, barycentric).point.normal.dot(ray.direction).abs();
            // Seen from afar, differences and products round in proportion to the distance.
            let height = self.error + 16.0 * f64::EPSILON * t.abs();
            let hit = Hit { t, shape: 0, triangle, instance: NO_INSTANCE, barycentric };
            let enters = (side == facing) != self.data.flip_normals;
            found.push(Crossing { hit, error: (height / slope).min(extent + height), enters });
        };
        let boxes = || (0..self.triangle_count() as u32).map(|i| Bounds::of(self.triangle(i)));
        let tree = self.lines.get_or_init(|| LineTree::new(&Vec::from_iter(boxes())));
        tree.near_line(ray, test);
        found.sort_by(|a, b| a.hit.t.total_cmp(&b.hit.t));
        found
    }

    /// The point of a triangle with the given weights of its second and third vertex.
    #[inline]
    pub fn surface(&self, triangle: u32, barycentric: [f64; 2]) -> SurfaceHit {
        let [a, b, c] = self.triangle(triangle);
        let [v, w] = barycentric;
        let (ab, ac) = (b - a, c - a);
        let position = a + ab * v + ac * w;
        // Differences of f32 are exact in f64 for all but absurd meshes, so slivers have good normals too.
        let side = if self.data.flip_normals { -1.0 } else { 1.0 };
        let normal = ab.cross(ac).try_normalize().unwrap_or(Vec3::Z) * side;
        let point = SurfacePoint { position, normal, error: self.error };
        // Written out: `array::map` is not always inlined.
        let [ia, ib, ic] = self.data.indices[triangle as usize];
        let (ia, ib, ic) = (ia as usize, ib as usize, ic as usize);
        let shading_normal = self.data.normals.as_ref().and_then(|normals| {
            let [a, b, c] = [to_f64(normals[ia]), to_f64(normals[ib]), to_f64(normals[ic])];
            (a * (1.0 - v - w) + b * v + c * w).try_normalize()
        });
        let shading_normal = shading_normal.map_or(normal, |shading| shading * side);
        SurfaceHit { point, shading_normal }
    }

    /// uv and its tangent, by the vertices' coordinates; without them the barycentric ones of the second and
    /// the third vertex, as the file orders them.
    pub fn parametrisation(&self, triangle: u32, barycentric: [f64; 2]) -> Parametrisation {
        let [a, b, c] = self.triangle(triangle);
        let [v, w] = barycentric;
        let (ab, ac) = (b - a, c - a);
        let Some(uvs) = &self.data.uvs else {
            if self.data.is_rewound {
                return Parametrisation { uv: [w, v], tangent: ac, bitangent: ab };
            }
            return Parametrisation { uv: barycentric, tangent: ab, bitangent: ac };
        };
        let [uv_a, uv_b, uv_c] =
            self.data.indices[triangle as usize].map(|index| uvs[index as usize].map(f64::from));
        let ([u1, v1], [u2, v2]) = (difference(uv_b, uv_a), difference(uv_c, uv_a));
        let determinant = u1 * v2 - v1 * u2;
        let (tangent, bitangent) = if determinant == 0.0 {
            let frame = Frame::around(ab.cross(ac).try_normalize().unwrap_or(Vec3::Z));
            (frame.x, frame.y)
        } else {
            ((ab * v2 - ac * v1) / determinant, (ac * u1 - ab * u2) / determinant)
        };
        let uv = [uv_a[0] + u1 * v + u2 * w, uv_a[1] + v1 * v + v2 * w];
        Parametrisation { uv, tangent, bitangent }
    }

    /// The place of an attribute in [`MeshData::attributes`].
    pub fn attribute(&self, name: &str) -> Option<usize> {
        self.data.attributes.iter().position(|attribute| attribute.name == name)
    }

    /// An attribute's value at a point of a triangle; one of a single channel is repeated.
    pub fn attribute_at(&self, attribute: usize, triangle: u32, barycentric: [f64; 2]) -> [f64; 3] {
        let MeshAttribute { per_face, channels, values, .. } = &self.data.attributes[attribute];
        let value = |index: u32, channel: usize| {
            f64::from(values[index as usize * channels + channel.min(channels - 1)])
        };
        if *per_face {
            return std::array::from_fn(|channel| value(triangle, channel));
        }
        let [a, b, c] = self.data.indices[triangle as usize];
        let [v, w] = barycentric;
        std::array::from_fn(|channel| {
            value(a, channel) * (1.0 - v - w) + value(b, channel) * v + value(c, channel) * w
        })
    }

    /// The box of all vertices that triangles use; empty for a mesh without triangles.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }
}

/// Bound on the distance from plane to interpolated point, together with what the intersection test may
/// err for a ray that starts there.
///
/// With u = 2⁻⁵³, M the largest coordinate of the mesh and D the diameter of its box: interpolation and the
/// offset err by 4u(M + D); the test subtracts the origin (u per coordinate), shears (4u) and weighs (6u)
/// coordinates that are no larger than D, which for a grazing ray displaces the hit along the ray but its
/// height over the plane by no more than that: 12u√3D. D is that of the mesh, not of the triangle, so that
/// leaving a sliver beside a large coplanar triangle is safe as well. In all 8u(M + 4D) with some reserve.
fn error_bound(bounds: Bounds) -> f64 {
    if bounds.is_empty() {
        return 0.0;
    }
    let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
    4.0 * f64::EPSILON * (reach + 4.0 * bounds.diameter())
}

fn validate(data: &MeshData) -> Result<(), ShapeError> {
    let vertices = data.positions.len();
    if vertices >= u32::MAX as usize || data.indices.len() >= u32::MAX as usize {
        return Err(ShapeError::TooLarge);
    }
    for (triangle, indices) in data.indices.iter().enumerate() {
        if let Some(&index) = indices.iter().find(|&&index| index as usize >= vertices) {
            return Err(ShapeError::VertexIndex { triangle, index, vertices });
        }
    }
    finite("position", &data.positions)?;
    if let Some(normals) = &data.normals {
        one_each("normal", normals.len(), vertices)?;
        finite("normal", normals)?;
    }
    if let Some(uvs) = &data.uvs {
        one_each("uv", uvs.len(), vertices)?;
        finite("uv", uvs)?;
    }
    for MeshAttribute { per_face, channels, values, .. } in &data.attributes {
        let expected = channels * if *per_face { data.indices.len() } else { vertices };
        if !matches!(channels, 1 | 3) || values.len() != expected {
            return Err(ShapeError::AttributeValues { found: values.len(), expected });
        }
        if let Some(at) = values.iter().position(|value| !value.is_finite()) {
            return Err(ShapeError::NotFinite { attribute: "attribute", vertex: at / channels });
        }
    }
    Ok(())
}

fn one_each(attribute: &'static str, found: usize, vertices: usize) -> Result<(), ShapeError> {
    if found == vertices { Ok(()) } else { Err(ShapeError::AttributeCount { attribute, found, vertices }) }
}

fn finite<const N: usize>(attribute: &'static str, values: &[[f32; N]]) -> Result<(), ShapeError> {
    match values.iter().position(|value| !value.iter().all(|x| x.is_finite())) {
        Some(vertex) => Err(ShapeError::NotFinite { attribute, vertex }),
        None => Ok(()),
    }
}

fn to_f64(value: [f32; 3]) -> Vec3 {
    Vec3::from_array(value.map(f64::from))
}

fn difference(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}
