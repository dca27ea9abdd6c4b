//! Surfaces: intersection, bounds, and sampling for light sources.
//!
//! Conventions, for every variant:
//! - A ray's parameter is a world-space distance; everything is solved in `f64`.
//! - The geometric normal follows the shape's orientation, never the ray: outward for spheres and
//!   cylinders, +z of the local frame for disks, counter-clockwise winding for triangles;
//!   `flip_normals` turns it. Mirrored placements behave as they do in Mitsuba 3.
//! - uv and ∂p/∂u are those of Mitsuba 3.
//! - Tangent rays count as misses.

mod areas;
mod chart;
mod closed;
mod crossing;
mod curves;
mod cylinder;
mod disk;
mod grid;
mod grid_shape;
mod heightfield;
mod mesh;
mod patch;
mod pieces;
mod placement;
mod profile_or_implicit;
mod quadric;
mod random_lines;
mod rectangle;
mod sdfgrid;
pub mod solid;
mod sphere;
mod support;
#[cfg(test)]
mod tests;
mod torus;
mod triangle;

use crate::geometry::{Bounds, Ray, SurfacePoint, Vec3};
pub use chart::ChartAxes;
pub use crossing::{Crossing, Crossings};
pub use curves::{ControlPoint, CurveKind, Curves, SweptSphere};
pub use cylinder::Cylinder;
pub use disk::Disk;
pub use grid_shape::GridShape;
pub use heightfield::{HeightData, HeightField, Terrain};
pub use mesh::{Deformation, Mesh, MeshAttribute, MeshData, RectangleSurface, compute_vertex_normals};
pub use patch::{ControlNet, Patches};
pub use pieces::Pieces;
pub use profile_or_implicit::{
    Blob, FillRule, Interpolation, Kernel, ProfileOrImplicit, ProfileOrImplicitKind,
};
pub use quadric::{Quadric, QuadricKind, Sheets};
pub use rectangle::Rectangle;
pub use sdfgrid::{SdfData, SdfGrid};
pub use sphere::Sphere;
use std::fmt;
pub use torus::Torus;
pub use triangle::{RaySpace, TriangleHit};

/// A surface that rays can meet and light can leave.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A sphere.
    Sphere(Sphere),
    /// A disk, or a ring.
    Disk(Disk),
    /// A cylinder without its ends.
    Cylinder(Cylinder),
    /// Rare and large: the others are not to grow by it.
    Quadric(Box<Quadric>),
    /// A torus.
    Torus(Box<Torus>),
    /// Curves with a radius, open at their ends.
    Curves(Curves),
    /// Curves with a radius, closed by round ends.
    SweptSphere(Box<SweptSphere>),
    /// A height field or a grid of distances.
    Grid(Box<GridShape>),
    /// A polygon, a swept or turned profile, or a surface by an equation.
    ProfileOrImplicit(Box<ProfileOrImplicit>),
    /// Bézier patches.
    Patches(Patches),
    /// Triangles.
    Mesh(Mesh),
}

/// Where a ray met a surface: all that is needed to compute the rest with [`Shape::surface`].
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
    fn analytic(surface: SurfaceHit, density: f64) -> Self {
        Self { surface, triangle: 0, barycentric: [0.0; 2], density }
    }

    /// `None` where no density per steradian exists (seen edge-on, or at no distance).
    pub fn seen_from(self, reference: Vec3) -> Option<ShapeSample> {
        let Self { surface, triangle, barycentric, density } = self;
        let density = density * steradians_to_area(reference, &surface.point)?;
        Some(ShapeSample { surface, triangle, barycentric, density })
    }
}

/// Where a surface is open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Opening {
    /// It is one by nature.
    Surface,
    /// It has no caps.
    Caps,
    /// An edge of a mesh, by its vertices, to which triangles of one side are missing.
    Edge([u32; 2]),
}

/// Why a shape cannot be made.
#[derive(Clone, Debug, PartialEq)]
pub enum ShapeError {
    /// A radius must be positive and finite.
    Radius(f64),
    /// The two ends of an axis coincide or are not finite.
    Ends,
    /// The tube of a torus is as thick as its ring or thicker.
    Tube {
        /// From the centre to the middle of the tube.
        major: f64,
        /// Radius of the tube.
        minor: f64,
    },
    /// A curve has too few control points.
    ControlPoints {
        /// How many it has.
        found: usize,
        /// How many it needs.
        least: usize,
    },
    /// All coefficients of a quadric vanish, or some are not finite.
    Coefficients,
    /// A quadric goes on without end.
    Endless,
    /// There is no real surface where it is asked for.
    Nothing,
    /// A grid has fewer than two points along an axis, or not a value for each of its points.
    GridPoints,
    /// The base of a height field isn't below all of it.
    Base,
    /// Contours are not finite or enclose no area.
    Outline,
    /// A profile is not finite, has too few points, or reaches over the axis.
    Profile,
    /// The threshold of blobs is not above 0, or something of them is not finite.
    Threshold,
    /// An exponent of a superquadric is out of range.
    Exponent(f64),
    /// The placement makes the shape too thin or too large to compute with.
    Placement,
    /// A triangle refers to a vertex that does not exist.
    VertexIndex {
        /// Number of the triangle.
        triangle: usize,
        /// Number of the vertex that it names.
        index: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A coordinate of a position, normal or uv is infinite or not a number.
    NotFinite {
        /// Name of the attribute, such as `normal`.
        attribute: &'static str,
        /// Number of the vertex.
        vertex: usize,
    },
    /// There must be as many normals and uvs as positions.
    AttributeCount {
        /// Name of the attribute, such as `normal`.
        attribute: &'static str,
        /// How many there are.
        found: usize,
        /// How many vertices there are.
        vertices: usize,
    },
    /// An attribute must have one or three numbers for each vertex or triangle.
    AttributeValues {
        /// How many numbers there are.
        found: usize,
        /// How many there should be.
        expected: usize,
    },
    /// A deformation turns a mesh inside out at a vertex.
    Folded {
        /// Number of the vertex.
        vertex: usize,
    },
    /// Subdivision would make more triangles of a mesh than it may.
    TooFine {
        /// How many triangles it may have.
        most: usize,
    },
    /// More triangles or vertices than 32-bit indices can name.
    TooLarge,
}

impl fmt::Display for ShapeError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Radius(radius) => write!(f, "a radius must be positive and finite, not {radius}"),
            Self::Ends => write!(f, "the ends of an axis must be finite and differ"),
            Self::Tube { major, minor } => {
                write!(f, "the radius of a torus's tube, {minor}, must be below that of its ring, {major}")
            }
            Self::ControlPoints { found, least } => {
                write!(f, "a curve has {found} control points and needs at least {least}")
            }
            Self::Coefficients => write!(f, "the coefficients must be finite and not all zero"),
            Self::Endless => write!(f, "it goes on without end unless it is cut off by planes on all sides"),
            Self::Nothing => write!(f, "there is no such surface, or none between the planes"),
            Self::Base => write!(f, "the base must be below all heights"),
            Self::GridPoints => {
                write!(f, "a grid needs two points along each axis and a value for each point")
            }
            Self::Exponent(exponent) => write!(f, "its exponents must be from 0.001 to 2, not {exponent}"),
            Self::Profile => write!(f, "its profile must be finite, long enough and on one side of the axis"),
            Self::Threshold => {
                write!(f, "all numbers must be finite, and its threshold above 0 and reached somewhere")
            }
            Self::Outline => write!(f, "its outline must be finite and enclose an area"),
            Self::Placement => {
                write!(f, "the transform makes the shape too thin or too large to compute with")
            }
            Self::VertexIndex { triangle, index, vertices } => {
                write!(f, "triangle {triangle} refers to vertex {index}, but there are {vertices} vertices")
            }
            Self::NotFinite { attribute, vertex } => {
                write!(f, "the {attribute} of vertex {vertex} is not finite")
            }
            Self::AttributeCount { attribute, found, vertices } => {
                write!(f, "there are {found} {attribute}s for {vertices} vertices")
            }
            Self::AttributeValues { found, expected } => {
                write!(f, "an attribute has {found} numbers instead of {expected}")
            }
            Self::Folded { vertex } => write!(f, "vertex {vertex} is folded over"),
            Self::TooFine { most } => write!(f, "subdivided, it would have more than {most} triangles"),
            Self::TooLarge => write!(f, "a mesh has at most 2^32 - 1 triangles and vertices"),
        }
    }
}

impl std::error::Error for ShapeError {}

impl Shape {
    /// The nearest hit with 0 ≤ t < `ray.t_max`, with shape index 0.
    /// Meshes are searched triangle by triangle: this is the oracle for [`crate::accel`].
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let analytic = |t| Hit { t, shape: 0, triangle: 0, instance: NO_INSTANCE, barycentric: [0.0; 2] };
        match self {
            Self::Sphere(sphere) => sphere.intersect(ray).map(analytic),
            Self::Disk(disk) => disk.intersect(ray).map(analytic),
            Self::Cylinder(cylinder) => cylinder.intersect(ray).map(analytic),
            Self::Quadric(quadric) => {
                quadric.intersect(ray).map(|(t, part)| Hit { triangle: part, ..analytic(t) })
            }
            Self::Torus(torus) => torus.intersect(ray).map(analytic),
            Self::Curves(curves) => curves.intersect(ray),
            Self::SweptSphere(swept) => {
                swept.intersect(ray).map(|(t, part)| Hit { triangle: part, ..analytic(t) })
            }
            Self::Grid(sampled) => sampled.intersect(ray),
            Self::ProfileOrImplicit(shape) => {
                shape.intersect(ray).map(|(t, part)| Hit { triangle: part, ..analytic(t) })
            }
            Self::Patches(patches) => patches.intersect(ray),
            Self::Mesh(mesh) => mesh.intersect(ray),
        }
    }

    /// All crossings along the whole line, also behind the ray's origin and beyond its end, in ascending
    /// order. Solid bodies are entered and left by turns.
    pub fn crossings(&self, ray: &Ray) -> Crossings {
        match self {
            Self::Sphere(sphere) => sphere.crossings(ray),
            Self::Disk(disk) => disk.crossings(ray),
            Self::Cylinder(cylinder) => cylinder.crossings(ray),
            Self::Quadric(quadric) => quadric.crossings(ray),
            Self::Torus(torus) => torus.crossings(ray),
            Self::Curves(curves) => curves.crossings(ray),
            Self::SweptSphere(swept) => swept.crossings(ray),
            Self::Grid(sampled) => sampled.crossings(ray),
            Self::ProfileOrImplicit(shape) => shape.crossings(ray),
            Self::Patches(patches) => patches.crossings(ray),
            Self::Mesh(mesh) => mesh.crossings(ray),
        }
    }

    /// Whether it encloses a volume, so that a solid can be made of it.
    ///
    /// # Errors
    /// Where it is open.
    pub fn is_closed(&self) -> Result<(), Opening> {
        match self {
            Self::Sphere(_) | Self::Torus(_) | Self::SweptSphere(_) => Ok(()),
            Self::Disk(_) | Self::Cylinder(_) | Self::Curves(_) | Self::Patches(_) => Err(Opening::Surface),
            Self::Quadric(quadric) if quadric.is_closed() => Ok(()),
            Self::Quadric(_) => Err(Opening::Caps),
            Self::Grid(sampled) if sampled.is_closed() => Ok(()),
            Self::ProfileOrImplicit(shape) if shape.is_closed() => Ok(()),
            Self::ProfileOrImplicit(shape) if !shape.is_flat() => Err(Opening::Caps),
            Self::Grid(_) | Self::ProfileOrImplicit(_) => Err(Opening::Surface),
            Self::Mesh(mesh) => mesh.open_edge().map_or(Ok(()), |edge| Err(Opening::Edge(edge))),
        }
    }

    /// The surface at a hit that `ray` made with this shape.
    pub fn surface(&self, hit: &Hit, ray: &Ray) -> SurfaceHit {
        match self {
            Self::Sphere(sphere) => sphere.surface(ray.at(hit.t)),
            Self::Disk(disk) => disk.surface(ray.at(hit.t)),
            Self::Cylinder(cylinder) => cylinder.surface(ray.at(hit.t)),
            Self::Quadric(quadric) => quadric.surface(ray.at(hit.t), hit.triangle),
            Self::Torus(torus) => torus.surface(ray.at(hit.t)),
            Self::Curves(curves) => curves.surface(hit, ray.at(hit.t)),
            Self::SweptSphere(swept) => swept.surface(ray.at(hit.t), hit.triangle),
            Self::Grid(sampled) => sampled.surface(hit, ray.at(hit.t)),
            Self::ProfileOrImplicit(shape) => shape.surface(ray.at(hit.t), hit.triangle),
            Self::Patches(patches) => patches.surface(hit),
            Self::Mesh(mesh) => mesh.surface(hit.triangle, hit.barycentric),
        }
    }

    /// The coordinates of the point `position` of the surface that `hit` gave.
    pub fn parametrisation(&self, hit: &Hit, position: Vec3) -> Parametrisation {
        match self {
            Self::Sphere(sphere) => sphere.parametrisation(position),
            Self::Disk(disk) => disk.parametrisation(position),
            Self::Cylinder(cylinder) => cylinder.parametrisation(position),
            Self::Quadric(quadric) => quadric.parametrisation(position, hit.triangle),
            Self::Torus(torus) => torus.parametrisation(position),
            Self::Curves(curves) => curves.parametrisation(hit, position),
            Self::SweptSphere(swept) => swept.parametrisation(position, hit.triangle),
            Self::Grid(sampled) => sampled.parametrisation(hit, position),
            Self::ProfileOrImplicit(shape) => shape.parametrisation(position, hit.triangle),
            Self::Patches(patches) => patches.parametrisation(hit),
            Self::Mesh(mesh) => mesh.parametrisation(hit.triangle, hit.barycentric),
        }
    }

    /// The smallest axis-aligned box in world space, up to rounding.
    pub fn bounds(&self) -> Bounds {
        match self {
            Self::Sphere(sphere) => sphere.bounds(),
            Self::Disk(disk) => disk.bounds(),
            Self::Cylinder(cylinder) => cylinder.bounds(),
            Self::Quadric(quadric) => quadric.bounds(),
            Self::Torus(torus) => torus.bounds(),
            Self::Curves(curves) => curves.bounds(),
            Self::SweptSphere(swept) => swept.bounds(),
            Self::Grid(sampled) => sampled.bounds(),
            Self::ProfileOrImplicit(shape) => shape.bounds(),
            Self::Patches(patches) => patches.bounds(),
            Self::Mesh(mesh) => mesh.bounds(),
        }
    }

    /// World-space area of one side.
    pub fn area(&self) -> f64 {
        match self {
            Self::Sphere(sphere) => sphere.area(),
            Self::Disk(disk) => disk.area(),
            Self::Cylinder(cylinder) => cylinder.area(),
            Self::Quadric(quadric) => quadric.area(),
            Self::Torus(torus) => torus.area(),
            Self::Curves(curves) => curves.area(),
            Self::SweptSphere(swept) => swept.area(),
            Self::Grid(sampled) => sampled.area(),
            Self::ProfileOrImplicit(shape) => shape.area(),
            Self::Patches(patches) => patches.area(),
            Self::Mesh(mesh) => mesh.area(),
        }
    }

    /// A point on the surface from `u` in [0, 1)². Its density is uniform in world area except on ellipsoids,
    /// elliptic or sheared cylinders and rings, quadrics, curved profiles and implicit surfaces, swept
    /// spheres and what is sampled. `None` for a mesh without area, for curves, which are no lights, and, for
    /// some `u`, on quadrics, curved profiles and implicit surfaces, swept spheres, patches and grids of
    /// distances.
    pub fn sample(&self, u: [f64; 2]) -> Option<AreaSample> {
        match self {
            Self::Sphere(sphere) => Some(sphere.sample(u)),
            Self::Disk(disk) => Some(disk.sample(u)),
            Self::Cylinder(cylinder) => Some(cylinder.sample(u)),
            Self::Quadric(quadric) => quadric.sample(u),
            Self::Torus(torus) => Some(torus.sample(u)),
            Self::Curves(_) => None,
            Self::SweptSphere(swept) => swept.sample(u),
            Self::Grid(sampled) => sampled.sample(u),
            Self::ProfileOrImplicit(shape) => shape.sample(u),
            Self::Patches(patches) => patches.sample(u),
            Self::Mesh(mesh) => mesh.sample(u),
        }
    }

    /// The point where Mitsuba 3 puts the point `u` of the unit square, with the density that spreading the
    /// square evenly gives it. Unlike [`Shape::sample`] it promises which point that is.
    pub fn point_at_uv(&self, u: [f64; 2]) -> Option<AreaSample> {
        match self {
            Self::Sphere(sphere) => Some(sphere.sample([u[1], u[0]])),
            Self::Disk(disk) => Some(disk.sample(u)),
            Self::Cylinder(cylinder) => Some(cylinder.sample(u)),
            Self::Quadric(quadric) => quadric.sample(u),
            Self::Torus(torus) => Some(torus.sample(u)),
            Self::Curves(_) => None,
            Self::SweptSphere(swept) => swept.sample(u),
            Self::Grid(sampled) => sampled.sample(u),
            Self::ProfileOrImplicit(shape) => shape.sample(u),
            Self::Patches(patches) => patches.sample(u),
            Self::Mesh(mesh) => mesh.point_at_uv(u),
        }
    }

    /// Density per unit area with which [`Shape::sample`] chooses `point` of this shape.
    pub fn area_density(&self, point: &SurfacePoint) -> f64 {
        match self {
            Self::Sphere(sphere) => sphere.area_density(point),
            Self::Disk(disk) => disk.area_density(),
            Self::Cylinder(cylinder) => cylinder.area_density(point),
            Self::Quadric(quadric) => quadric.area_density(point),
            Self::Torus(torus) => torus.area_density(point),
            Self::Curves(_) => 0.0,
            Self::SweptSphere(swept) => swept.area_density(point),
            Self::Grid(sampled) => sampled.area_density(point),
            Self::ProfileOrImplicit(shape) => shape.area_density(point),
            Self::Patches(patches) => patches.area_density(),
            Self::Mesh(mesh) => mesh.area_density(),
        }
    }

    /// A point for illuminating `reference`: by solid angle for spheres (under a similarity, seen from
    /// outside) and rectangles, by area otherwise. It may face away from `reference` or be hidden.
    /// `None` where no density per steradian exists (seen edge-on, or at no distance).
    pub fn sample_toward(&self, reference: Vec3, u: [f64; 2]) -> Option<ShapeSample> {
        let by_solid_angle = match self {
            Self::Sphere(sphere) => sphere.sample_cone(reference, u),
            Self::Mesh(mesh) => mesh.sample_rectangle(reference, u),
            Self::Disk(_)
            | Self::Cylinder(_)
            | Self::Quadric(_)
            | Self::Torus(_)
            | Self::Curves(_)
            | Self::SweptSphere(_)
            | Self::ProfileOrImplicit(_)
            | Self::Patches(_)
            | Self::Grid(_) => None,
        };
        if by_solid_angle.is_some() {
            return by_solid_angle;
        }
        self.sample(u)?.seen_from(reference)
    }

    /// Density per steradian with which [`Shape::sample_toward`] chooses `point` of this shape, which
    /// is visible from `reference`. Zero where it never would.
    pub fn density_toward(&self, reference: Vec3, point: &SurfacePoint) -> f64 {
        let by_solid_angle = match self {
            Self::Sphere(sphere) => sphere.cone_density(reference),
            Self::Mesh(mesh) => mesh.rectangle_density(reference),
            Self::Disk(_)
            | Self::Cylinder(_)
            | Self::Quadric(_)
            | Self::Torus(_)
            | Self::Curves(_)
            | Self::SweptSphere(_)
            | Self::ProfileOrImplicit(_)
            | Self::Patches(_)
            | Self::Grid(_) => None,
        };
        by_solid_angle.unwrap_or_else(|| per_steradian(reference, point, self.area_density(point)))
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
