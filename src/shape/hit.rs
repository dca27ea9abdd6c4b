//! Points of surfaces: where rays meet them, and where they are sampled.

use crate::geometry::{SurfacePoint, Vec3};

/// Where a ray met a surface: all that is needed to compute the rest with [`super::Shape::surface`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance from the ray's origin.
    pub t: f64,
    /// Index of the shape in the list that the acceleration structure was built from.
    pub shape: u32,
    /// Index of the triangle within its mesh, of the segment of curves, of the patch, or of the part of an
    /// analytic shape; 0 where it has but one.
    pub triangle: u32,
    /// Index of the instance by which the shape was met; [`NO_INSTANCE`] where it stands for itself.
    pub instance: u32,
    /// Barycentric coordinates of the triangle's second and third vertex; for curves the
    /// place along the segment and 0, for patches u and v, [0, 0] for other analytic shapes.
    pub barycentric: [f64; 2],
}

impl Hit {
    /// Whether another hit is on the same triangle, segment, patch or part.
    pub fn is_on_part_of(&self, other: &Self) -> bool {
        (self.shape, self.instance, self.triangle) == (other.shape, other.instance, other.triangle)
    }
}

/// See [`Hit::instance`].
pub const NO_INSTANCE: u32 = u32::MAX;

/// A point on a surface with what shading always asks for.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceHit {
    /// Where it is, with its geometric normal.
    pub point: SurfacePoint,
    /// Unit shading normal; equals the geometric normal unless a mesh interpolates vertex normals.
    pub shading_normal: Vec3,
}

/// The coordinates of a point on a surface: what only some materials ask for.
#[derive(Clone, Copy, Debug)]
pub struct Parametrisation {
    /// Coordinates u and v.
    pub uv: [f64; 2],
    /// ∂p/∂u, not normalised; zero where the parametrisation is singular.
    pub tangent: Vec3,
    /// ∂p/∂v, likewise.
    pub bitangent: Vec3,
}

impl Parametrisation {
    /// Stands for coordinates that nothing asks for.
    pub const NONE: Self = Self { uv: [0.0; 2], tangent: Vec3::ZERO, bitangent: Vec3::ZERO };
}

/// A point of a surface where it is before instances and motion carry it anywhere: what is carved from a
/// block keeps its grain. In the coordinates of the compiled scene; of what is instanced in those that its
/// group would have in there.
#[derive(Clone, Copy, Debug)]
pub struct AtRest {
    /// The place.
    pub position: Vec3,
    /// ∂p/∂u and ∂p/∂v, as in [`Parametrisation`].
    pub tangents: [Vec3; 2],
}

impl AtRest {
    /// Stands for a place that nothing asks for.
    pub const NONE: Self = Self { position: Vec3::ZERO, tangents: [Vec3::ZERO; 2] };
}

/// A point chosen on a surface.
#[derive(Clone, Copy, Debug)]
pub struct AreaSample {
    /// The point of the surface.
    pub surface: SurfaceHit,
    /// Number of the triangle, as in [`Hit`].
    pub triangle: u32,
    /// Weights of the triangle's second and third vertex; 0 for other shapes.
    pub barycentric: [f64; 2],
    /// Per unit of world area.
    pub density: f64,
}

/// A point chosen on a surface for what it looks like from a reference point.
#[derive(Clone, Copy, Debug)]
pub struct ShapeSample {
    /// The point of the surface.
    pub surface: SurfaceHit,
    /// Number of the triangle, as in [`Hit`].
    pub triangle: u32,
    /// Weights of the triangle's second and third vertex; 0 for other shapes.
    pub barycentric: [f64; 2],
    /// Per steradian, as seen from the reference point.
    pub density: f64,
}

impl AreaSample {
    /// A sample on a shape that is no mesh.
    pub(super) fn analytic(surface: SurfaceHit, density: f64) -> Self {
        Self { surface, triangle: 0, barycentric: [0.0; 2], density }
    }

    /// `None` where no density per steradian exists (seen edge-on, or at no distance).
    pub fn seen_from(self, reference: Vec3) -> Option<ShapeSample> {
        let Self { surface, triangle, barycentric, density } = self;
        let density = density * steradians_to_area(reference, &surface.point)?;
        Some(ShapeSample { surface, triangle, barycentric, density })
    }
}

/// What a density per unit of area at `point` is per steradian at `reference`; zero where that is not finite.
pub fn per_steradian(reference: Vec3, point: &SurfacePoint, density: f64) -> f64 {
    steradians_to_area(reference, point).map_or(0.0, |factor| factor * density)
}

/// Area at `point` that is one steradian at `reference`: r² / |cos θ|. `None` where it is not finite.
fn steradians_to_area(reference: Vec3, point: &SurfacePoint) -> Option<f64> {
    let toward = point.position - reference;
    let squared = toward.length_squared();
    let factor = squared * squared.sqrt() / toward.dot(point.normal).abs();
    (factor.is_finite() && factor > 0.0).then_some(factor)
}
