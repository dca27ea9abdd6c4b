//! Points spread evenly over flat pieces.

use super::outline::Trapezoid;
use crate::geometry::Vec3;
use crate::shape::placement::Placement;
use glam::DVec2;

/// A flat piece in local coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) enum Facet {
    /// In a plane across z.
    Level { shape: Trapezoid, z: f64 },
    /// Upright, over a straight line.
    Wall { from: DVec2, to: DVec2, heights: [f64; 2] },
}

#[derive(Clone, Debug)]
pub(super) struct Facets {
    /// With the part that each belongs to and the world area of all up to its end.
    facets: Vec<(Facet, u32, f64)>,
}

impl Facets {
    pub fn new(placement: &Placement, facets: impl IntoIterator<Item = (Facet, u32)>) -> Self {
        let mut sum = 0.0;
        let with_sum = facets.into_iter().map(|(facet, part)| {
            sum += match facet {
                Facet::Level { shape, .. } => shape.area() * placement.area_stretch(Vec3::Z),
                Facet::Wall { from, to, heights: [low, high] } => {
                    let world = |vector: Vec3| placement.pose.world_vector(vector);
                    world((to - from).extend(0.0)).cross(world(Vec3::Z)).length() * (high - low)
                }
            };
            (facet, part, sum)
        });
        Self { facets: with_sum.collect() }
    }

    /// In the world.
    pub fn area(&self) -> f64 {
        self.facets.last().map_or(0.0, |last| last.2)
    }

    /// The point for `u` in [0, 1)² and its part.
    pub fn sample(&self, u: [f64; 2]) -> (Vec3, u32) {
        let at = u[0] * self.area();
        let index = self.facets.partition_point(|facet| facet.2 <= at).min(self.facets.len() - 1);
        let before = if index == 0 { 0.0 } else { self.facets[index - 1].2 };
        let (facet, part, end) = self.facets[index];
        let within = ((at - before) / (end - before)).clamp(0.0, 1.0);
        let point = match facet {
            Facet::Level { shape, z } => shape.point([within, u[1]]).extend(z),
            Facet::Wall { from, to, heights: [low, high] } => {
                from.lerp(to, within).extend(low + u[1] * (high - low))
            }
        };
        (point, part)
    }
}
