//! Which plan suits a scene: a few blocks of pixels are rendered by each, and what they cost is set against
//! how much they scatter.
//!
//! The pilot's sample values are its own, so the choice is independent of the picture that it is for:
//! whatever it chooses, the picture's expectation is the same.

use super::allocation::Allocation;
use super::exposure::Exposure;
use super::groups::{BLOCK, Block, Groups, Members};
use super::{Progress, Schedule};
use crate::film::{Extent, FilterKind};
use crate::integrator::{Plan, Sharing};
use crate::sampling::{SamplerKind, mix};
use crate::scene::Scene;
use rayon::prelude::*;
use std::sync::atomic::Ordering;

/// How many pixels a suffix may serve.
const SHARINGS: [Sharing; 3] = [Sharing::Nothing, Sharing::Four, Sharing::Sixteen];

/// How many light samples a first surface may take: first some, and then fewer or more.
const LIGHT_SAMPLES: [u32; 3] = [4, 1, 16];

/// Plans that a pilot tries.
const TRIED: usize = SHARINGS.len() + LIGHT_SAMPLES.len() - 1;

/// What a sample costs, in samples of a path tracer: about what was measured on the scenes of
/// `validation/speed`. In scenes of few surfaces rays between pixels go in lanes, and cost little.
fn cost(scene: &Scene, plan: Plan) -> f64 {
    let ([four, sixteen], light_sample) = match scene.answers_lanes() {
        true => ([1.2, 1.4], 0.08),
        false => ([1.25, 1.9], 0.16),
    };
    let sharing = match plan.sharing {
        Sharing::Nothing => 1.0,
        Sharing::Four => four,
        Sharing::Sixteen => sixteen,
    };
    sharing + light_sample * f64::from(plan.light_samples - 1)
}

/// Nets of the pilot. The spread of two, over many pixels, tells their error.
const NETS: u32 = 2;

/// Most samples of a net. How much less a net errs than its samples alone depends on the plan: short nets
/// take what is shared for worse than it is, and light samples for better.
const LONGEST: u32 = 16;

/// Largest part of the picture's samples that a pilot takes.
const SHARE: f64 = 0.03;

/// Fewest and most blocks that it looks at.
const BLOCKS: (u64, u64) = (6, 32);

/// Tells the pilot's sample values from the picture's.
const SEED: u64 = 0x0070_696c_6f74;

/// The plan of least variance times cost, or the usual one where the picture is too small for a pilot.
/// Nobody waits for a pilot that is stopped.
pub(super) fn choose<const C: usize>(
    picture: &Exposure,
    sampler: SamplerKind,
    progress: &dyn Progress,
) -> Plan {
    // Places are those of the whole picture, whatever part of it is rendered: all parts have the same plan.
    let window = picture.extent.window;
    let schedule = Schedule::independent(NETS, picture.schedule.samples_per_net().min(LONGEST));
    let per_block = u64::from(BLOCK * BLOCK) * schedule.samples() * TRIED as u64;
    let budget = SHARE * (window.pixel_count() * picture.schedule.samples()) as f64;
    let count = ((budget / per_block as f64) as u64).min(BLOCKS.1);
    if count < BLOCKS.0 || !sampler.is_random() {
        return Plan::USUAL;
    }
    let seed = mix(picture.seed ^ SEED);
    let [across, down] = window.size.map(|size| u64::from(size.div_ceil(BLOCK)));
    let corners: Vec<[i64; 2]> = (0..count)
        .map(|i| {
            // Spread evenly over the rows and, by the golden ratio, over the columns.
            let row = i * down / count;
            let column = (i as f64 * 0.618_033_988_749_895).fract() * across as f64;
            [0, 1].map(|axis| {
                i64::from(window.offset[axis]) + i64::from(BLOCK) * [column as i64, row as i64][axis]
            })
        })
        .collect();
    let mut tried: Vec<(Plan, f64)> = Vec::with_capacity(TRIED);
    let mut brightness = None;
    // What is shared makes indirect light quieter, light samples the direct: each is chosen by itself.
    let mut best_of = |plans: &mut dyn Iterator<Item = Plan>| {
        for plan in plans {
            let pilot = Pilot { sampler, schedule, seed, plan };
            let found = scatter::<C>(picture, &pilot, &corners, progress).concat();
            // One scale for all plans.
            let mean = || found.iter().map(|&[mean, _]| mean).sum::<f64>() / found.len().max(1) as f64;
            let brightness = *brightness.get_or_insert_with(mean);
            let relative =
                |[mean, variance]: &[f64; 2]| variance / (mean * mean + 0.01 * brightness * brightness);
            tried.push((plan, found.iter().map(relative).sum::<f64>() * cost(picture.scene, plan)));
        }
        tried.iter().min_by(|(_, a), (_, b)| a.total_cmp(b)).map_or(Plan::USUAL, |&(plan, _)| plan)
    };
    let of_sharing =
        best_of(&mut SHARINGS.into_iter().map(|sharing| Plan { sharing, light_samples: LIGHT_SAMPLES[0] }));
    best_of(&mut LIGHT_SAMPLES[1..].iter().map(|&light_samples| Plan { light_samples, ..of_sharing }))
}

/// How a pilot renders: its sample values are its own.
pub(super) struct Pilot {
    pub sampler: SamplerKind,
    pub schedule: Schedule,
    pub seed: u64,
    pub plan: Plan,
}

/// For each pixel of some blocks, by their corners, what the nets of a pilot make of it, and the variance of
/// that. Blocks have no pixels once the pilot is cancelled.
pub(super) fn scatter<const C: usize>(
    picture: &Exposure,
    pilot: &Pilot,
    corners: &[[i64; 2]],
    progress: &dyn Progress,
) -> Vec<Vec<[f64; 2]>> {
    let &Pilot { sampler, schedule, seed, plan } = pilot;
    let window = picture.extent.window;
    let even = Allocation::even(window);
    let groups = Groups::new(Members::of(picture.scene, plan), schedule.nets(), seed);
    let exposure = Exposure {
        extent: Extent { measured: window, shown: window, ..picture.extent },
        schedule,
        allocation: &even,
        samplers: even.samplers(sampler, seed, schedule, groups.sharers()),
        seed,
        groups: &groups,
        plan,
        // Each pixel's own samples, whatever they are splatted onto.
        filter: FilterKind::Box,
        extras: picture.extras.clone(),
        ..*picture
    };
    let of_block = |corner: &[i64; 2]| {
        let is_stopped = progress.stop().load(Ordering::Relaxed);
        if is_stopped { Vec::new() } else { exposure.scatter_of_block::<C>(*corner) }
    };
    corners.par_iter().map(of_block).collect()
}

impl Exposure<'_> {
    /// For each pixel of a block that is measured, what its nets make of it, and the variance of that.
    fn scatter_of_block<const C: usize>(&self, corner: [i64; 2]) -> Vec<[f64; 2]> {
        let nets = self.schedule.nets();
        let tiles: Vec<_> = (0..nets)
            .map(|net| {
                let block = Block { net, corner };
                let mut tile = self.tile(&block);
                self.block::<C>(&block, &|_| 0..self.schedule.samples_per_replicate, &mut tile);
                tile
            })
            .collect();
        let n = f64::from(nets);
        let pixel = |place: usize| {
            let values = (0..nets)
                .zip(&tiles)
                .map(|(net, tile)| tile.brightness(place, net, self.scale, &self.extras));
            let mean = values.clone().sum::<f64>() / n;
            let variance = values.map(|value| (value - mean) * (value - mean)).sum::<f64>() / (n * (n - 1.0));
            [mean, variance]
        };
        (0..tiles[0].pixel_count()).map(pixel).collect()
    }
}
