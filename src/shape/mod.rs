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
mod error;
mod grid;
mod grid_shape;
mod heightfield;
mod hit;
mod mesh;
mod nesting;
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
pub(crate) mod tests;
mod torus;
mod triangle;

use crate::geometry::{Bounds, Ray, SurfacePoint, Vec3};
pub use chart::ChartAxes;
pub use crossing::{Crossing, Crossings};
pub use curves::{ControlPoint, CurveKind, Curves, SweptSphere};
pub use cylinder::Cylinder;
pub use disk::Disk;
pub use error::{FARTHEST, ShapeError};
pub use grid_shape::GridShape;
pub use heightfield::{HeightData, HeightField, Terrain};
pub use hit::{
    AreaSample, AtRest, Hit, NO_INSTANCE, Parametrisation, ShapeSample, SurfaceHit, per_steradian,
};
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
pub use torus::Torus;
pub use triangle::{RaySpace, TriangleHit};

/// A surface that rays can meet and light can leave.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A sphere.
    Sphere(Sphere),
    /// A disk.
    Disk(Disk),
    /// A cylinder without its ends.
    Cylinder(Cylinder),
    /// Boxed because it is rare and large: an enum is as large as its largest variant.
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

    /// Whether a ray ends before it comes to the surface, as most flights in a dense medium do. `false` where
    /// that is not seen quickly.
    pub fn is_farther_than(&self, ray: &Ray) -> bool {
        match self {
            Self::Sphere(sphere) => sphere.is_farther_than(ray),
            Self::Quadric(quadric) => quadric.is_farther_than(ray),
            Self::Torus(torus) => torus.is_farther_than(ray),
            _ => false,
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
