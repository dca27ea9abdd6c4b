//! What is traced from the lights beside the paths from the camera.

use super::{Caustics, VisibleLamps};
use crate::sampling::PiecewiseConstant;

/// Samples of a pixel for one light subpath a pixel, where nothing is known of what they cost and gain. The
/// weights of the two techniques take it for the number: they sum to 1 whatever it is.
pub const USUAL_SAMPLES_PER_PATH: u64 = 2;

/// Each light subpath begins once toward the bodies that cast caustics, and once from a lamp in the picture
/// toward the lens, as far as there are any.
#[derive(Clone, Debug)]
pub struct LightTracing {
    /// Where there are bodies that cast them.
    pub caustics: Option<Caustics>,
    /// Where there are lamps in the picture that few camera rays meet.
    pub visible_lamps: Option<VisibleLamps>,
    /// How many light subpaths there are.
    pub subpaths: Subpaths,
}

impl LightTracing {
    /// `None` where nothing is traced.
    pub fn new(
        caustics: Option<Caustics>,
        visible_lamps: Option<VisibleLamps>,
        subpaths: Subpaths,
    ) -> Option<Self> {
        (caustics.is_some() || visible_lamps.is_some()).then_some(Self { caustics, visible_lamps, subpaths })
    }
}

/// How many light subpaths there are.
#[derive(Clone, Copy, Debug)]
pub struct Subpaths {
    /// Those of the film, or of the window of it, that they are for.
    pub pixels: u64,
}

impl Subpaths {
    /// With so many samples of each pixel, if there is one a pixel for each `samples_per_path`.
    pub fn count(self, samples: u32, samples_per_path: u64) -> u64 {
        (self.pixels * u64::from(samples)).div_ceil(samples_per_path)
    }

    /// For one sample of each pixel, as the weights have it.
    pub fn per_sample(self) -> f64 {
        self.pixels as f64 / USUAL_SAMPLES_PER_PATH as f64
    }
}

/// What sends out light subpaths.
#[derive(Clone, Copy, Debug)]
pub struct Source {
    /// Where its light comes from.
    pub origin: Origin,
    /// What it weighs in the choice among them.
    pub power: f64,
}

/// Where light subpaths come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Origin {
    /// A surface.
    Surface {
        /// Among the scene's lights.
        light: u32,
        /// Its area in its own coordinates, in their squared unit.
        area: f64,
    },
    /// Beyond the scene.
    Environment,
}

/// Sources, of which each light subpath begins at one.
#[derive(Clone, Debug)]
pub struct Sources {
    /// Those with a surface in ascending order of their numbers, then the environment.
    sources: Vec<Source>,
    choice: PiecewiseConstant,
}

impl Sources {
    /// In ascending order, the environment last. `None` where there are none.
    pub fn new(sources: Vec<Source>) -> Option<Self> {
        if sources.is_empty() {
            return None;
        }
        let edges = (0..=sources.len()).map(|i| i as f64).collect();
        let powers: Vec<f64> = sources.iter().map(|source| source.power).collect();
        let choice = PiecewiseConstant::new(edges, &powers)?;
        Some(Self { sources, choice })
    }

    /// A source, and the probability of choosing it.
    pub fn choose(&self, u: f64) -> (Origin, f64) {
        let (place, probability) = self.choice.sample(u);
        (self.sources[(place as usize).min(self.sources.len() - 1)].origin, probability)
    }

    /// The density of beginning at a point of a light, per unit of area in its own coordinates. Zero where
    /// none begin there.
    pub fn density_on(&self, light: u32) -> f64 {
        // The environment's number is above all others.
        let number = |source: &Source| match source.origin {
            Origin::Surface { light, .. } => light,
            Origin::Environment => u32::MAX,
        };
        match self.sources.binary_search_by_key(&light, number) {
            Ok(at) => match self.sources[at].origin {
                Origin::Surface { area, .. } => self.choice.density(at as f64 + 0.5) / area,
                Origin::Environment => 0.0,
            },
            Err(_) => 0.0,
        }
    }

    /// The probability of beginning beyond the scene.
    pub fn environment_probability(&self) -> f64 {
        let last = self.sources.len() - 1;
        match self.sources[last].origin {
            Origin::Environment => self.choice.density(last as f64 + 0.5),
            Origin::Surface { .. } => 0.0,
        }
    }
}
