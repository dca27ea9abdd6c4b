//! Which surface a ray meets first, and whether it meets any.

use crate::geometry::Ray;
use crate::shape::{Hit, Shape};

/// All shapes of a scene, ready for ray queries.
#[derive(Clone, Debug)]
pub struct Accel {
    shapes: Vec<Shape>,
}

impl Accel {
    pub fn build(shapes: &[Shape]) -> Self {
        Self { shapes: shapes.to_vec() }
    }

    /// The nearest hit with 0 ≤ t < `ray.t_max`; of equally near ones that of the first shape and triangle.
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        let hits = self.shapes.iter().enumerate().filter_map(|(shape, surface)| {
            surface.intersect(ray).map(|hit| Hit { shape: shape as u32, ..hit })
        });
        hits.min_by(|a, b| a.t.total_cmp(&b.t))
    }

    /// Whether anything is hit with 0 ≤ t < `ray.t_max`.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.shapes.iter().any(|shape| shape.intersect(ray).is_some())
    }
}
