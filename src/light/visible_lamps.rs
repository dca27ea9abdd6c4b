//! Lamps in the picture that few camera rays meet. See `integrator::visible_lamps` for how they come to the
//! film.

use super::tracing::{Origin, Source, Sources, Subpaths};

/// Such lamps, and the choice among them.
#[derive(Clone, Debug)]
pub struct VisibleLamps {
    lamps: Sources,
    subpaths: Subpaths,
}

impl VisibleLamps {
    /// Lamps with a surface, in ascending order. `None` where there are none.
    pub fn new(lamps: Vec<Source>, subpaths: Subpaths) -> Option<Self> {
        Some(Self { lamps: Sources::new(lamps)?, subpaths })
    }

    /// A lamp's number among the lights, and the probability of choosing it.
    pub fn choose(&self, u: f64) -> Option<(u32, f64)> {
        match self.lamps.choose(u) {
            (Origin::Surface { light, .. }, probability) => Some((light, probability)),
            (Origin::Environment, _) => None,
        }
    }

    /// Light subpaths that begin on a unit of area of a lamp in its own coordinates, for one sample of each
    /// pixel. Zero where none do.
    pub fn per_area(&self, light: u32) -> f64 {
        self.subpaths.per_sample() * self.lamps.density_on(light)
    }
}
