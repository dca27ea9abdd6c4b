//! Polygons swept along z: prisms and open walls.
//!
//! A line meets them where its projection meets the outline (Glassner, *An Introduction to Ray Tracing*, ch.
//! 3, 3.3, translational sweeps).

use super::facets::Facet;
use super::outline::{BoundarySegment, EdgeCrossing, FillRule, Outline};
use super::polygon::{across_box, reach};
use super::{Local, power_above};
use crate::geometry::Vec3;
use crate::shape::ShapeError;
use crate::shape::random_lines::OnLine;
use smallvec::SmallVec;

/// Parts: the lower and the upper cap, then two for each edge, the second of them with the outside to the
/// left of it.
const LOWER: u32 = 0;
const UPPER: u32 = 1;

#[derive(Clone, Debug)]
pub(super) struct Extrusion {
    outline: Outline,
    heights: [f64; 2],
    capped: bool,
}

fn wall(edge: u32, outside_left: bool) -> u32 {
    2 + 2 * edge + u32::from(outside_left)
}

impl Extrusion {
    /// With the length of its unit, a power of two as for polygons.
    pub fn new(
        contours: &[Vec<[f64; 2]>],
        rule: FillRule,
        heights: [f64; 2],
        capped: bool,
    ) -> Result<(Self, f64), ShapeError> {
        if !(heights[0] < heights[1] && heights[0].is_finite() && heights[1].is_finite()) {
            return Err(ShapeError::Ends);
        }
        let outline = Outline::new(contours, rule)?;
        let most = outline.min.abs().max(outline.max.abs()).max_element();
        let scale = power_above(heights.iter().fold(most, |most, height| most.max(height.abs())));
        let heights = heights.map(|height| height / scale);
        Ok((Self { outline: outline.scaled(1.0 / scale), heights, capped }, scale))
    }

    pub fn facets(&self) -> impl Iterator<Item = (Facet, u32)> {
        let heights = self.heights;
        let walls = self.outline.boundary().into_iter();
        let walls = walls.map(move |BoundarySegment { edge, from, to, outside_left }| {
            (Facet::Wall { from, to, heights }, wall(edge, outside_left))
        });
        let caps = if self.capped { self.outline.trapezoids() } else { Vec::new() };
        let caps = caps.into_iter().flat_map(move |shape| {
            [(LOWER, heights[0]), (UPPER, heights[1])].map(|(part, z)| (Facet::Level { shape, z }, part))
        });
        walls.chain(caps)
    }

    fn outward(&self, part: u32) -> Vec3 {
        match part {
            LOWER => -Vec3::Z,
            UPPER => Vec3::Z,
            _ => {
                let edge = &self.outline.edges[((part - 2) / 2) as usize];
                let left = (edge.to - edge.from).perp().normalize();
                if part % 2 == 1 { left.extend(0.0) } else { -left.extend(0.0) }
            }
        }
    }
}

impl Local for Extrusion {
    fn crossed(&self, origin: Vec3, direction: Vec3, rounding: f64) -> SmallVec<[OnLine; 4]> {
        let mut found = SmallVec::new();
        // From near the origin, where no distance costs digits.
        let shift = -origin.dot(direction);
        let start = origin + direction * shift;
        let [low, high] = self.heights;
        // Where the line is between the two planes. Within one of them it is in none.
        let (mut enter, mut leave) = ((low - start.z) / direction.z, (high - start.z) / direction.z);
        let (mut first, mut last) = (LOWER, UPPER);
        if direction.z < 0.0 {
            (enter, leave, first, last) = (leave, enter, last, first);
        } else if direction.z == 0.0 {
            if !(low < start.z && start.z < high) {
                return found;
            }
            (enter, leave) = (f64::NEG_INFINITY, f64::INFINITY);
        }
        let along = |t: f64| 4.0 * f64::EPSILON * (shift.abs() + t.abs());
        let height = 2.0 * rounding + 8.0 * f64::EPSILON;
        let cap = |t: f64, part: u32, enters: bool| OnLine {
            t: shift + t,
            error: height / direction.z.abs() + along(t),
            enters,
            part,
        };
        let side = |crossing: &EdgeCrossing| OnLine {
            t: shift + crossing.t,
            error: height / crossing.rate + along(crossing.t),
            enters: crossing.enters,
            part: wall(crossing.edge, crossing.outside_left),
        };
        // Moving less than this across z takes a line nowhere on its way from one plane to the other.
        const UPRIGHT: f64 = 1e-150;
        let across = direction.truncate();
        if across.abs().max_element() < UPRIGHT {
            if self.capped && enter < leave && self.outline.contains(start.truncate()) {
                found.extend([cap(enter, first, true), cap(leave, last, false)]);
            }
            return found;
        }
        let walls = self.outline.crossed(start.truncate(), across);
        if !self.capped {
            found.extend(walls.iter().filter(|wall| enter <= wall.t && wall.t <= leave).map(side));
            return found;
        }
        for pair in walls.chunks_exact(2) {
            let begin = if pair[0].t < enter { cap(enter, first, true) } else { side(&pair[0]) };
            let end = if pair[1].t > leave { cap(leave, last, false) } else { side(&pair[1]) };
            if pair[0].t.max(enter) < pair[1].t.min(leave) {
                found.extend([begin, end]);
            }
        }
        found
    }

    fn normal(&self, _: Vec3, part: u32) -> Vec3 {
        self.outward(part)
    }

    fn project(&self, point: Vec3, part: u32) -> Vec3 {
        match part {
            LOWER => point.with_z(self.heights[0]),
            UPPER => point.with_z(self.heights[1]),
            _ => {
                let edge = &self.outline.edges[((part - 2) / 2) as usize];
                let outward = self.outward(part);
                point - outward * outward.dot(point - edge.from.extend(point.z))
            }
        }
    }

    /// On walls u goes along the contour, from its first corner back to it, and v up; on caps both go across
    /// the outline's box.
    fn parametrisation(&self, point: Vec3, part: u32) -> ([f64; 2], [Vec3; 2]) {
        if part == LOWER || part == UPPER {
            return across_box(&self.outline, point);
        }
        let edge = &self.outline.edges[((part - 2) / 2) as usize];
        let [low, high] = self.heights;
        let [begin, end] = edge.along;
        let along = edge.to - edge.from;
        let at = (point.truncate() - edge.from).dot(along) / along.length_squared();
        let uv = [begin + at * (end - begin), (point.z - low) / (high - low)];
        (uv, [(along / (end - begin)).extend(0.0), Vec3::Z * (high - low)])
    }

    fn reach(&self, direction: Vec3) -> f64 {
        let [low, high] = self.heights;
        reach(&self.outline, direction) + (direction.z * low).max(direction.z * high)
    }

    fn rounding(&self, _: Vec3) -> f64 {
        8.0 * f64::EPSILON
    }

    fn is_closed(&self) -> bool {
        self.capped
    }
}
