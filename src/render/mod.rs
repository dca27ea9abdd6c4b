//! From a compiled scene to an exposed film: pixels, threads, progress, interruption.

mod auxiliary;
mod exposure;
mod groups;
mod light;
mod pilot;
mod schedule;

pub use auxiliary::{Auxiliary, auxiliary};
pub use schedule::Schedule;

use crate::film::{BadValues, Extras, Film, FixedPoint, SpectralBins};
use crate::integrator::{Estimator, Integrator};
use crate::sampling::{Sampler, SamplerKind};
use crate::scene::Scene;
use crate::spectrum::Sampled;
use exposure::Exposure;
use groups::{Groups, Members};
use light::LightPass;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

/// How a scene is rendered. None of it changes the expectation of the picture.
#[derive(Clone, Debug)]
pub struct Settings {
    pub schedule: Schedule,
    pub seed: u64,
    pub sampler: SamplerKind,
    pub wavelengths: WavelengthCount,
    pub estimator: Estimator,
    /// Spectral bins to measure beside X, Y, Z.
    pub bins: Option<SpectralBins>,
}

/// How many wavelengths a path carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "u32", try_from = "u32")]
pub enum WavelengthCount {
    One,
    Four,
    Eight,
}

impl WavelengthCount {
    pub fn get(self) -> usize {
        match self {
            Self::One => 1,
            Self::Four => 4,
            Self::Eight => 8,
        }
    }
}

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
            light_paths: scene.caustics().is_some(),
        }
    }
}

/// Whoever watches a render: told of progress, and able to end it.
pub trait Watch: Sync {
    /// Called after each piece of work with the number of its samples.
    fn advanced(&self, samples: u64);

    /// Called when every pixel has the same number of samples again.
    fn pass_done(&self, film: &Film);

    /// Once true, the tiles under way are finished and no others begun.
    fn stop(&self) -> &AtomicBool;
}

/// Watches nothing and never stops.
pub struct Unwatched(AtomicBool);

impl Unwatched {
    pub const fn new() -> Self {
        Self(AtomicBool::new(false))
    }
}

impl Default for Unwatched {
    fn default() -> Self {
        Self::new()
    }
}

impl Watch for Unwatched {
    fn advanced(&self, _: u64) {}

    fn pass_done(&self, _: &Film) {}

    fn stop(&self) -> &AtomicBool {
        &self.0
    }
}

/// Most samples of each replicate that a tile takes at once: bounds how long an interruption has to wait.
const LONGEST_PASS: u32 = 256;

/// The indices of each pass over the picture. Passes double what is there, as far as [`LONGEST_PASS`] allows: what a Sobol
/// sequence has after any of them is well spread, and there is a picture with error bars after the first.
fn passes(samples_per_replicate: u32) -> impl Iterator<Item = Range<u32>> {
    let after = move |done: u32| {
        let step = done.clamp(1, LONGEST_PASS).min(samples_per_replicate - done);
        (step > 0).then_some(done..done + step)
    };
    std::iter::successors(after(0), move |pass| after(pass.end))
}

/// Exposes a film to the scene, on the current rayon thread pool. The result depends on scene and settings alone, unless
/// it is stopped: then each pixel has the samples that were finished.
pub fn render(scene: &Scene, settings: &Settings, watch: &dyn Watch) -> Film {
    match settings.wavelengths {
        WavelengthCount::One => expose::<1>(scene, settings, watch),
        WavelengthCount::Four => expose::<4>(scene, settings, watch),
        WavelengthCount::Eight => expose::<8>(scene, settings, watch),
    }
}

fn expose<const C: usize>(scene: &Scene, settings: &Settings, watch: &dyn Watch) -> Film {
    let schedule = settings.schedule();
    let measured = scene.film.extent.measured;
    let mut film = Film::part(
        scene.film.extent,
        schedule.replicates,
        settings.extras(scene),
        FixedPoint::for_reference(scene.reference_radiance),
    );
    film.per_net = schedule.per_net;
    let alone = Groups::new(Members::One, schedule.nets(), settings.seed);
    let exposure = Exposure {
        scene,
        schedule,
        sampler: Sampler::new(settings.sampler, settings.seed, schedule.samples_per_net()),
        seed: settings.seed,
        groups: &alone,
        plan: Plan::PLAIN,
        filter: scene.film.filter,
        scale: film.scale(),
        square_scale: film.square_scale(),
        light_scale: film.light_scale(),
        extras: film.extras.clone(),
    };
    let plan = match (settings.estimator, scene.integrator) {
        // Second moments are those of samples of a path tracer. Suffixes are shared between surfaces alone: what a medium scatters on the way
        // from one to the other would have to be weighed, too.
        (Estimator::Shared, Integrator::Path) if !scene.film.moments && !scene.needs().scattering => {
            pilot::choose::<C>(&exposure, settings.sampler, watch)
        }
        _ => Plan::PLAIN,
    };
    let groups = Groups::new(plan.members, schedule.nets(), settings.seed);
    let exposure = Exposure {
        sampler: exposure.sampler.clone().for_groups(groups.members()),
        groups: &groups,
        plan,
        extras: film.extras.clone(),
        ..exposure
    };
    let reach = i64::from(scene.film.filter.reach());
    let reached =
        [0, 1].map(|axis| i64::from(measured.offset[axis]) - reach..measured.end()[axis] as i64 + reach);
    let blocks: Vec<_> = (0..schedule.nets()).flat_map(|net| groups.blocks(net, reached.clone())).collect();
    let film = Mutex::new(film);
    let light = scene.caustics().map(|caustics| LightPass::new(caustics, &exposure, settings.sampler));
    for pass in passes(schedule.samples_per_replicate) {
        if let Some(light) = &light {
            light.expose::<C>(&pass, &film, watch);
        }
        // Block by block: what a thread has taken no other can take over, and blocks differ.
        blocks.par_iter().with_max_len(1).for_each(|block| {
            if watch.stop().load(Ordering::Relaxed) {
                return;
            }
            let mut tile = exposure.tile(block);
            let samples = exposure.block::<C>(block, &pass, &mut tile);
            lock(&film).add(&tile);
            watch.advanced(samples);
        });
        if watch.stop().load(Ordering::Relaxed) {
            break;
        }
        watch.pass_done(&lock(&film));
    }
    film.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// What the samples of a picture have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    members: Members,
    /// Light samples at the first surface of a path.
    light_samples: u32,
}

impl Plan {
    /// Nothing: each pixel pays for its own light.
    const PLAIN: Self = Self { members: Members::One, light_samples: 1 };

    /// What pays in most scenes.
    const USUAL: Self = Self { members: Members::Sixteen, light_samples: 1 };
}

/// Counts values that are no radiance and leaves them out.
fn admit<const C: usize>(radiance: &mut Sampled<C>, bad: &mut BadValues) {
    for lane in 0..C {
        if radiance[lane] != 0.0 && !bad.admits(radiance[lane]) {
            radiance[lane] = 0.0;
        }
    }
}

/// A film is whole between any two of its additions, so a poisoned lock is no reason to stop.
fn lock(film: &Mutex<Film>) -> std::sync::MutexGuard<'_, Film> {
    film.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_double_and_cover_every_index_once() {
        let ends = |samples| passes(samples).map(|pass| pass.end).collect::<Vec<_>>();
        assert_eq!(ends(1), [1]);
        assert_eq!(ends(10), [1, 2, 4, 8, 10]);
        assert_eq!(ends(800), [1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 768, 800]);
        assert!(ends(0).is_empty());
    }
}
