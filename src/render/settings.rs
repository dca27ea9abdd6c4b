//! How a scene is rendered.

use super::Schedule;
use crate::film::{Extras, SpectralBins};
use crate::integrator::Estimator;
use crate::sampling::SamplerKind;
use crate::scene::Scene;
use serde::{Deserialize, Serialize};
use std::fmt;

/// How a scene is rendered. None of it changes the expectation of the picture.
#[derive(Clone, Debug)]
pub struct Settings {
    /// How many samples there are, and how they are dealt.
    pub schedule: Schedule,
    /// Seed of the sample values.
    pub seed: u64,
    /// How samples are placed.
    pub sampler: SamplerKind,
    /// Wavelengths that a path carries; without, four or eight, as a pilot finds best.
    pub wavelengths: Option<WavelengthCount>,
    /// How light is estimated.
    pub estimator: Estimator,
    /// Spectral bins to measure beside X, Y, Z.
    pub bins: Option<SpectralBins>,
}

/// How many wavelengths a path carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "u32", try_from = "u32")]
pub enum WavelengthCount {
    /// The hero alone.
    One,
    /// The hero and three companions.
    Four,
    /// The hero and seven companions.
    Eight,
}

impl WavelengthCount {
    /// The number.
    pub fn get(self) -> usize {
        match self {
            Self::One => 1,
            Self::Four => 4,
            Self::Eight => 8,
        }
    }
}

/// An expression in which the number that a [`WavelengthCount`] stands for is a constant of that name.
macro_rules! with_count {
    ($count:expr, $name:ident => $value:expr) => {
        match $count {
            $crate::render::WavelengthCount::One => {
                const $name: usize = 1;
                $value
            }
            $crate::render::WavelengthCount::Four => {
                const $name: usize = 4;
                $value
            }
            $crate::render::WavelengthCount::Eight => {
                const $name: usize = 8;
                $value
            }
        }
    };
}
pub(super) use with_count;

impl From<WavelengthCount> for u32 {
    fn from(count: WavelengthCount) -> u32 {
        count.get() as u32
    }
}

impl TryFrom<u32> for WavelengthCount {
    type Error = &'static str;

    fn try_from(count: u32) -> Result<Self, Self::Error> {
        match count {
            1 => Ok(Self::One),
            4 => Ok(Self::Four),
            8 => Ok(Self::Eight),
            _ => Err("expected 1, 4 or 8"),
        }
    }
}

impl fmt::Display for WavelengthCount {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self.get().fmt(f)
    }
}

impl Settings {
    /// The schedule as the sampler allows it: replicates that are all the same would tell an error of zero.
    pub fn schedule(&self) -> Schedule {
        if self.sampler.is_random() {
            self.schedule
        } else {
            Schedule::of(self.sampler, u32::try_from(self.schedule.samples()).unwrap_or(u32::MAX))
        }
    }

    /// What a film of this scene measures beside X, Y and Z.
    pub fn extras(&self, scene: &Scene) -> Extras {
        Extras {
            alpha: scene.film.alpha,
            moments: scene.film.moments,
            responses: scene.film.channels.iter().map(|channel| channel.integral).collect(),
            bins: self.bins,
            light_paths: scene.light_tracing().is_some(),
        }
    }
}
