//! Points spread evenly over flat pieces.

use super::outline::Trapezoid;
use crate::geometry::Vec3;
use crate::shape::areas::AreaDistribution;
use crate::shape::placement::Placement;
use glam::DVec2;

/// A flat piece in local coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) enum Facet {
    /// A trapezoid in a plane across z.
    Level { shape: Trapezoid, z: f64 },
    /// Upright, over a straight line.
    Wall { from: DVec2, to: DVec2, heights: [f64; 2] },
}

#[derive(Clone, Debug)]
pub(super) struct Facets {
    /// Each facet with the part that it belongs to.
    facets: Vec<(Facet, u32)>,
    /// Areas in the world.
    areas: AreaDistribution,
}

impl Facets {
    pub fn new(placement: &Placement, facets: impl IntoIterator<Item = (Facet, u32)>) -> Self {
        let facets: Vec<(Facet, u32)> = facets.into_iter().collect();
        let area = |(facet, _): &(Facet, u32)| match *facet {
            Facet::Level { shape, .. } => shape.area() * placement.area_stretch(Vec3::Z),
            Facet::Wall { from, to, heights: [low, high] } => {
                let world = |vector: Vec3| placement.pose.world_vector(vector);
                world((to - from).extend(0.0)).cross(world(Vec3::Z)).length() * (high - low)
            }
        };
        let areas = AreaDistribution::new(facets.iter().map(area));
        Self { facets, areas }
    }

    /// Area in the world.
    pub fn area(&self) -> f64 {
        self.areas.total()
    }

    /// The point for `u` in [0, 1)² and its part.
    pub fn sample(&self, u: [f64; 2]) -> (Vec3, u32) {
        let (index, within) = self.areas.choose(u[0]);
        let (facet, part) = self.facets[index];
        let point = match facet {
            Facet::Level { shape, z } => shape.point([within, u[1]]).extend(z),
            Facet::Wall { from, to, heights: [low, high] } => {
                from.lerp(to, within).extend(low + u[1] * (high - low))
            }
        };
        (point, part)
    }
}
