//! From a compiled scene to an exposed film: pixels, threads, progress, interruption.

mod allocation;
mod auxiliary;
mod explain;
mod exposure;
mod groups;
mod light;
mod pilot;
mod progress;
mod schedule;
mod settings;
mod work;

pub use auxiliary::{Auxiliary, auxiliary};
pub use explain::{Contribution, Explained, Shared, Wanted, explain};
pub use pilot::Chosen;
pub use progress::{NoProgress, Progress};
pub use schedule::Schedule;
pub use settings::{Settings, WavelengthCount};
pub use work::{Position, Work};

use crate::film::{BadValues, Extras, Film, FixedPoint};
use crate::integrator::{self, Estimator, Plan, Workspace};
use crate::light::USUAL_SAMPLES_PER_PATH;
use crate::scene::Scene;
use crate::spectrum::Sampled;
use allocation::Allocation;
use exposure::Exposure;
use groups::{BLOCK, Groups, Members};
use light::LightPass;
use rayon::prelude::*;
use settings::with_count;
use std::sync::atomic::Ordering;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Exposes a film to the scene, on the current rayon thread pool. The result depends on scene and settings
/// alone, unless it is stopped: then each pixel has the samples that were finished.
pub fn render(scene: &Scene, settings: &Settings, progress: &dyn Progress) -> Film {
    go_on(scene, settings, Work::new(scene, settings, None), progress).into_film()
}

/// The same from wherever a work of that scene and these settings is. However often it is stopped and goes
/// on, the film is the same in the end, bit by bit.
pub fn go_on(scene: &Scene, settings: &Settings, work: Work, progress: &dyn Progress) -> Work {
    if work.pass().is_none() {
        return work;
    }
    let measures = Measures::of(work.film());
    with_exposure(
        scene,
        settings,
        &measures,
        progress,
        |exposure, count| with_count!(count, C => fill::<C>(exposure, settings, work, progress)),
    )
}

/// What a film measures, and in which quanta.
struct Measures {
    scale: FixedPoint,
    square_scale: FixedPoint,
    light_scale: FixedPoint,
    extras: Extras,
}

impl Measures {
    fn of(film: &Film) -> Self {
        Self {
            scale: film.scale(),
            square_scale: film.square_scale(),
            light_scale: film.light_scale(),
            extras: film.extras.clone(),
        }
    }
}

/// All that decides what the samples of a picture are, by pilots where the settings ask for them. The last of
/// it is the number of wavelengths that a path carries.
fn with_exposure<R>(
    scene: &Scene,
    settings: &Settings,
    measures: &Measures,
    progress: &dyn Progress,
    then: impl FnOnce(&Exposure, WavelengthCount) -> R,
) -> R {
    let schedule = settings.schedule();
    let (alone, even) = (
        Groups::new(Members::of(scene, Plan::PLAIN), schedule.nets(), settings.seed),
        Allocation::even(scene.film.extent.window),
    );
    let exposure = Exposure {
        scene,
        extent: scene.film.extent,
        schedule,
        allocation: &even,
        samplers: even.samplers(settings.sampler, settings.seed, schedule, alone.sharers()),
        seed: settings.seed,
        groups: &alone,
        plan: Plan::PLAIN,
        samples_per_path: USUAL_SAMPLES_PER_PATH,
        filter: scene.film.filter,
        scale: measures.scale,
        square_scale: measures.square_scale,
        light_scale: measures.light_scale,
        extras: measures.extras.clone(),
    };
    let is_shared =
        settings.estimator == Estimator::Shared && integrator::why_nothing_is_shared(scene).is_none();
    let (chosen, allocation) = if is_shared {
        let chosen = pilot::choose(&exposure, settings.sampler, settings.wavelengths, progress);
        let allocation = Allocation::measured(&exposure, settings.sampler, &chosen, progress);
        (chosen, allocation)
    } else {
        (Chosen::usual(Plan::PLAIN, settings.wavelengths), even.clone())
    };
    let Chosen { plan, wavelengths, samples_per_path } = chosen;
    progress.pilots_done(&chosen);
    let groups = Groups::new(Members::of(scene, plan), schedule.nets(), settings.seed);
    let exposure = Exposure {
        samplers: allocation.samplers(settings.sampler, settings.seed, schedule, groups.sharers()),
        allocation: &allocation,
        groups: &groups,
        plan,
        samples_per_path,
        extras: measures.extras.clone(),
        ..exposure
    };
    then(&exposure, wavelengths)
}

/// Takes the samples that are still to be taken.
fn fill<const C: usize>(
    exposure: &Exposure,
    settings: &Settings,
    work: Work,
    progress: &dyn Progress,
) -> Work {
    let Exposure { scene, schedule, groups, .. } = *exposure;
    let measured = scene.film.extent.measured;
    let reach = i64::from(scene.film.filter.reach());
    let reached =
        [0, 1].map(|axis| i64::from(measured.offset[axis]) - reach..measured.end()[axis] as i64 + reach);
    let mut blocks: Vec<_> =
        (0..schedule.nets()).flat_map(|net| groups.blocks(net, reached.clone())).collect();
    // Those of all nets side by side, from the top: what the film keeps in a file is gone through once.
    blocks.sort_by_key(|block| (block.corner[1].div_euclid(i64::from(BLOCK)), block.net));
    let light = scene.light_tracing().map(|tracing| LightPass::new(tracing, exposure, settings.sampler));
    let work = Mutex::new(work);
    let add = |piece: usize, add: &dyn Fn(&mut Film)| {
        let mut work = lock(&work);
        work.add(piece, add);
        if progress.wants_to_keep() {
            progress.keep(&work);
        }
    };
    let next_pass = || lock(&work).pass();
    while let Some(pass) = next_pass() {
        // The pieces of a pass: light subpaths, and then blocks of pixels.
        let light_pieces = light.as_ref().map_or(0, |light| light.expose::<C>(&pass, &add, progress));
        // Block by block, in their order: what a thread has taken no other can take over, and blocks differ.
        blocks.iter().enumerate().par_bridge().for_each_init(
            Workspace::default,
            |workspace, (number, block)| {
                let piece = light_pieces + number;
                if pass.is_done(piece) || progress.stop().load(Ordering::Relaxed) {
                    return;
                }
                let mut tile = exposure.tile(block);
                let indices = |replicate| pass.indices(replicate);
                let samples = scene.piece(|| exposure.block::<C>(block, &indices, workspace, &mut tile));
                add(piece, &|film| film.add(&tile));
                progress.advanced(samples);
            },
        );
        let mut work = lock(&work);
        if work.pieces_done() == light_pieces + blocks.len() {
            work.end_pass();
            progress.pass_done(&work);
        }
        if progress.stop().load(Ordering::Relaxed) {
            break;
        }
    }
    work.into_inner().unwrap_or_else(PoisonError::into_inner)
}

/// Counts values that are no radiance and leaves them out.
fn admit<const C: usize>(radiance: &mut Sampled<C>, bad: &mut BadValues) {
    for lane in 0..C {
        if radiance[lane] != 0.0 && !bad.admits(radiance[lane]) {
            radiance[lane] = 0.0;
        }
    }
}

/// A work is whole between any two of its additions, so a poisoned lock is no reason to stop.
fn lock(work: &Mutex<Work>) -> MutexGuard<'_, Work> {
    work.lock().unwrap_or_else(PoisonError::into_inner)
}
