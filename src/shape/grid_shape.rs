//! Surfaces that are given by values on a grid.

use super::crossing::Crossings;
use super::{AreaSample, HeightField, Hit, Parametrisation, SdfGrid, SurfaceHit};
use crate::geometry::{Bounds, Ray, SurfacePoint, Vec3};

/// Each with the contract of [`super::Shape`].
#[derive(Clone, Debug)]
pub enum GridShape {
    /// `sdfgrid`.
    Distances(SdfGrid),
    /// `heightfield`.
    Heights(HeightField),
}

impl GridShape {
    pub(super) fn intersect(&self, ray: &Ray) -> Option<Hit> {
        match self {
            Self::Distances(grid) => grid.intersect(ray),
            Self::Heights(heights) => heights.intersect(ray),
        }
    }

    pub(super) fn crossings(&self, ray: &Ray) -> Crossings {
        match self {
            Self::Distances(grid) => grid.crossings(ray),
            Self::Heights(heights) => heights.crossings(ray),
        }
    }

    pub(super) fn surface(&self, hit: &Hit, position: Vec3) -> SurfaceHit {
        match self {
            Self::Distances(grid) => grid.surface(position, hit.triangle),
            Self::Heights(heights) => heights.surface(position, hit.triangle),
        }
    }

    pub(super) fn parametrisation(&self, hit: &Hit, position: Vec3) -> Parametrisation {
        match self {
            Self::Distances(_) => Parametrisation::NONE,
            Self::Heights(heights) => heights.parametrisation(position, hit.triangle),
        }
    }

    pub(super) fn bounds(&self) -> Bounds {
        match self {
            Self::Distances(grid) => grid.bounds(),
            Self::Heights(heights) => heights.bounds(),
        }
    }

    pub(super) fn area(&self) -> f64 {
        match self {
            Self::Distances(grid) => grid.area(),
            Self::Heights(heights) => heights.area(),
        }
    }

    pub(super) fn sample(&self, u: [f64; 2]) -> Option<AreaSample> {
        match self {
            Self::Distances(grid) => grid.sample(u),
            Self::Heights(heights) => Some(heights.sample(u)),
        }
    }

    pub(super) fn area_density(&self, point: &SurfacePoint) -> f64 {
        match self {
            Self::Distances(grid) => grid.area_density(point),
            Self::Heights(heights) => heights.area_density(point),
        }
    }

    /// Whether it bounds a body.
    pub fn is_closed(&self) -> bool {
        match self {
            Self::Distances(grid) => grid.is_closed(),
            Self::Heights(heights) => heights.is_closed(),
        }
    }
}
