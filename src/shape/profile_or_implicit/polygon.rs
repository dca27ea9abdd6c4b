//! Flat polygons, concave and with holes.

use super::facets::Facet;
use super::outline::{FillRule, Outline};
use super::{Local, power_above};
use crate::geometry::Vec3;
use crate::shape::ShapeError;
use crate::shape::random_lines::OnLine;
use smallvec::SmallVec;

/// A polygon in the plane z = 0.
#[derive(Clone, Debug)]
pub(super) struct Polygon {
    outline: Outline,
}

impl Polygon {
    /// With the length of its unit. Nothing but powers of two is divided by, nor is it moved: a ray meets
    /// exactly one of two polygons of the same placement that share an edge, whatever their sizes.
    pub fn new(contours: &[Vec<[f64; 2]>], rule: FillRule) -> Result<(Self, f64), ShapeError> {
        let outline = Outline::new(contours, rule)?;
        let scale = power_above(outline.min.abs().max(outline.max.abs()).max_element());
        Ok((Self { outline: outline.scaled(1.0 / scale) }, scale))
    }

    pub fn facets(&self) -> impl Iterator<Item = (Facet, u32)> {
        self.outline.trapezoids().into_iter().map(|shape| (Facet::Level { shape, z: 0.0 }, 0))
    }
}

impl Local for Polygon {
    /// A line within the plane misses.
    fn crossed(&self, origin: Vec3, direction: Vec3, rounding: f64) -> SmallVec<[OnLine; 4]> {
        let t = -origin.z / direction.z;
        let at = origin + t * direction;
        if direction.z == 0.0 || !self.outline.contains(at.truncate()) {
            return SmallVec::new();
        }
        let error = rounding / direction.z.abs() + 4.0 * f64::EPSILON * t.abs();
        SmallVec::from_slice(&[OnLine { t, error, enters: direction.z < 0.0, part: 0 }])
    }

    fn normal(&self, _: Vec3, _: u32) -> Vec3 {
        Vec3::Z
    }

    fn project(&self, point: Vec3, _: u32) -> Vec3 {
        point.with_z(0.0)
    }

    /// From the lower left to the upper right corner of the outline's box.
    fn parametrisation(&self, point: Vec3, _: u32) -> ([f64; 2], [Vec3; 2]) {
        across_box(&self.outline, point)
    }

    fn reach(&self, direction: Vec3) -> f64 {
        reach(&self.outline, direction)
    }

    fn rounding(&self, _: Vec3) -> f64 {
        0.0
    }

    fn is_closed(&self) -> bool {
        false
    }
}

/// uv across the box around an outline.
pub(super) fn across_box(outline: &Outline, point: Vec3) -> ([f64; 2], [Vec3; 2]) {
    let size = outline.max - outline.min;
    let uv = (point.truncate() - outline.min) / size;
    (uv.to_array(), [Vec3::X * size.x, Vec3::Y * size.y])
}

/// The largest direction · x over the corners.
pub(super) fn reach(outline: &Outline, direction: Vec3) -> f64 {
    outline.edges.iter().map(|edge| edge.from.dot(direction.truncate())).fold(f64::NEG_INFINITY, f64::max)
}
