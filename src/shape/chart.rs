//! Charts: the unit square laid over a surface, evenly by the measure of [`Shape::sample`].

use super::{AreaSample, Shape};
use crate::geometry::UvTransform;
use crate::geometry::{SurfacePoint, Vec3};
use std::f64::consts::PI;

/// A map of one coordinate.
pub type Along = fn(f64) -> f64;

/// How the coordinates of a chart make the surface's own: first one by one, then by an affine map.
#[derive(Clone, Copy, Debug)]
pub struct ChartAxes {
    /// Takes what the affine map takes back to the coordinates of the chart.
    pub to_chart: [Along; 2],
    /// From these coordinates to the texture's.
    pub to_uv: UvTransform,
}

impl Shape {
    /// The point at a place of the chart, with the density that spreading the square evenly gives it. Of a
    /// mesh that is no rectangle each `triangle` has a chart. `None` for surfaces without.
    pub fn chart(&self, triangle: u32, place: [f64; 2]) -> Option<AreaSample> {
        match self {
            Self::Sphere(_) | Self::Cylinder(_) => self.sample([place[1], place[0]]),
            Self::Disk(disk) => Some(disk.polar(place)),
            Self::Mesh(mesh) if mesh.is_rectangle() => mesh.point_at_uv(place),
            Self::Mesh(mesh) => mesh.sample_triangle(triangle, place),
            _ => None,
        }
    }

    /// Where in the chart a point of the surface lies: [`Shape::chart`] taken back.
    pub fn chart_place(&self, triangle: u32, barycentric: [f64; 2], position: Vec3) -> [f64; 2] {
        match self {
            Self::Sphere(sphere) => {
                let [around, down] = sphere.parametrisation(position).uv;
                [around, height_of_angle(down)]
            }
            Self::Cylinder(cylinder) => cylinder.parametrisation(position).uv,
            Self::Disk(disk) => {
                let [radius, around] = disk.parametrisation(position).uv;
                [radius * radius, around]
            }
            Self::Mesh(mesh) => mesh.chart_place(triangle, barycentric),
            _ => [0.0; 2],
        }
    }

    /// The density of [`Shape::chart`] with an even spread at a point of a triangle.
    pub fn chart_density(&self, triangle: u32, point: &SurfacePoint) -> f64 {
        match self {
            Self::Mesh(mesh) if !mesh.is_rectangle() => 1.0 / mesh.triangle_area(triangle),
            shape => shape.area_density(point),
        }
    }

    /// `None` where the two coordinates are not apart from one another.
    pub fn chart_axes(&self) -> Option<ChartAxes> {
        let (to_chart, to_uv): ([Along; 2], _) = match self {
            Self::Sphere(_) => ([|s| s, height_of_angle], UvTransform::IDENTITY),
            Self::Disk(_) => ([|s| s * s.abs(), |s| s], UvTransform::IDENTITY),
            Self::Cylinder(_) => ([|s| s; 2], UvTransform::IDENTITY),
            Self::Mesh(mesh) => ([|s| s; 2], mesh.rectangle_uv()?),
            _ => return None,
        };
        Some(ChartAxes { to_chart, to_uv })
    }
}

/// The fraction of a sphere's area that lies up to an angle from its pole, over π.
fn height_of_angle(down: f64) -> f64 {
    (0.5 * PI * down).sin().powi(2)
}
