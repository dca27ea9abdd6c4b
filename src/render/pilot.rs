//! Which plan suits a scene: a few blocks of pixels are rendered by each, and what they cost is set against
//! how much they scatter.
//!
//! The pilot's sample values are its own, so the choice is independent of the picture that it is for:
//! whatever it chooses, the picture's expectation is the same.

use super::allocation::Allocation;
use super::exposure::Exposure;
use super::groups::{BLOCK, Block, Groups, Members};
use super::light::LightPass;
use super::settings::{WavelengthCount, with_count};
use super::{Progress, Schedule};
use crate::film::{Extent, FilterKind, Region, Tile};
use crate::integrator::{Plan, Sharing, Workspace};
use crate::light::{LightTracing, USUAL_SAMPLES_PER_PATH};
use crate::sampling::{SamplerKind, mix};
use crate::scene::{Scene, rays_of_this_thread};
use crate::spectrum::colour::xyz_to_rec709;
use crate::stats::relmse_scale;
use rayon::prelude::*;
use std::sync::atomic::Ordering;

/// How many pixels a suffix may serve.
const SHARINGS: [Sharing; 3] = [Sharing::Nothing, Sharing::Four, Sharing::Sixteen];

/// How many light samples a first surface may take: first some, then fewer, and more where fewer are worse.
/// The variance of k of them is a + b / k and their cost c + d k, so their product has one minimum.
/// On eight scenes of `validation/speed` the same error cost with eight 0.79 to 1.01 of what it cost with
/// sixteen.
const LIGHT_SAMPLES: [u32; 3] = [4, 1, 8];

/// Plans that a pilot tries, but for wider sharing beside many light samples.
const TRIED: usize = SHARINGS.len() + LIGHT_SAMPLES.len() - 1;

/// What a sample costs, in samples of a path tracer: about what was measured on the scenes of
/// `validation/speed`. In scenes of few surfaces rays between pixels go in lanes, and cost little.
fn cost(scene: &Scene, plan: Plan) -> f64 {
    let ([four, sixteen], light_sample) = match scene.answers_lanes() {
        true => ([1.3, 1.5], 0.07),
        false => ([1.3, 1.65], 0.1),
    };
    let light_sample = light_sample + LEVEL * scene.lights.tree_levels();
    let sharing = match plan.sharing {
        Sharing::Nothing => 1.0,
        Sharing::Four => four,
        Sharing::Sixteen => sixteen,
    };
    sharing + light_sample * f64::from(plan.light_samples - 1)
}

/// What a light sample costs more each time that the number of emitters in a tree doubles: 0.015, 0.015 and
/// 0.008 were measured with 10², 10⁴ and 10⁶ of them, when nodes had two parts.
const LEVEL: f64 = 0.012;

/// What a sample of eight wavelengths costs, in samples of four: 1.03 to 1.2 where surfaces are diffuse, 1.3
/// to 1.5 where they are rough metals.
const COST_OF_EIGHT: f64 = 1.15;

/// Nets of the pilot. The spread of two, over many pixels, tells their error.
const NETS: u32 = 2;

/// Fewest and most samples of a net, where the picture's have as many. How much less a net errs than its
/// samples alone depends on the plan: short nets take what is shared for worse than it is, and light samples
/// for better.
const LENGTHS: (u32, u32) = (4, 16);

/// Part of the picture's samples that the plans of a pilot take, and the largest part that the fewest blocks
/// may. Eight wavelengths take a fifth of that.
const SHARES: (f64, f64) = (0.03, 0.08);

/// Fewest and most blocks that it looks at.
const BLOCKS: (u64, u64) = (6, 32);

/// Tells the pilot's sample values from the picture's.
const SEED: u64 = 0x0070_696c_6f74;

/// What a light subpath costs, in the same unit.
const LIGHT_SUBPATH: f64 = 1.0;

/// How many samples of a pixel there may be for one light subpath a pixel: the usual number, or more where
/// light subpaths make little of the noise.
const SAMPLES_PER_PATH: [u64; 4] = [USUAL_SAMPLES_PER_PATH, 4, 8, 16];

/// Most light subpaths of a pilot.
const MOST_SUBPATHS: u64 = 1 << 17;

/// How a picture is rendered.
#[derive(Clone, Copy, Debug)]
pub struct Chosen {
    /// What its samples have in common.
    pub plan: Plan,
    /// How many wavelengths a path carries.
    pub wavelengths: WavelengthCount,
    /// How many samples of a pixel there are for one light subpath a pixel, where there is light tracing.
    pub samples_per_path: u64,
}

impl Chosen {
    /// A plan with the usual number of light subpaths, and of wavelengths where none is asked for.
    pub(super) fn usual(plan: Plan, wavelengths: Option<WavelengthCount>) -> Self {
        let wavelengths = wavelengths.unwrap_or(WavelengthCount::Four);
        Self { plan, wavelengths, samples_per_path: USUAL_SAMPLES_PER_PATH }
    }
}

/// What has least variance times cost, or the usual where the picture is too small for a pilot. Nobody waits
/// for a pilot that is stopped. `asked`: the number of wavelengths, where it is no choice.
pub(super) fn choose(
    picture: &Exposure,
    sampler: SamplerKind,
    asked: Option<WavelengthCount>,
    progress: &dyn Progress,
) -> Chosen {
    // Places are those of the whole picture, whatever part of it is rendered: all parts have the same plan.
    let window = picture.extent.window;
    let Some((schedule, count)) = affordable(picture).filter(|_| sampler.is_random()) else {
        return Chosen::usual(Plan::USUAL, asked);
    };
    let seed = mix(picture.seed ^ SEED);
    let corners = corners(window, count);
    let first = asked.unwrap_or(WavelengthCount::Four);
    let mut tried: Vec<(Plan, Relative)> = Vec::new();
    let mut known: Option<Brightness> = None;
    let mut relative = |plan: Plan, wavelengths: WavelengthCount| {
        let pilot = Pilot { sampler, schedule, seed, plan };
        let found = noise_of_blocks(picture, &pilot, wavelengths, &corners, progress);
        // One scale for all.
        let known = known.get_or_insert_with(|| Brightness::new(&corners, &found));
        Relative::new(&found, schedule.samples() as f64, known)
    };
    // What is shared makes indirect light quieter, light samples the direct: each is chosen by itself. But
    // sharing pays the more, the less noise there is of direct light, and the more a sample costs anyway.
    let mut best_with = |plans: &[Plan]| {
        for &plan in plans {
            tried.push((plan, relative(plan, first)));
        }
        let total = |(plan, found): &(Plan, Relative)| found.typical * cost(picture.scene, *plan);
        let usual = (Plan::USUAL, Relative::default());
        tried.iter().min_by(|a, b| total(a).total_cmp(&total(b))).copied().unwrap_or(usual)
    };
    let [some, fewer, more] = LIGHT_SAMPLES;
    let (of_sharing, _) = best_with(&SHARINGS.map(|sharing| Plan { sharing, light_samples: some }));
    let (mut plan, mut variance) = best_with(&[Plan { light_samples: fewer, ..of_sharing }]);
    if plan.light_samples == some {
        (plan, variance) = best_with(&[Plan { light_samples: more, ..of_sharing }]);
        if plan.light_samples == more {
            let wider = SHARINGS.into_iter().filter(|sharing| sharing.pixels() > plan.sharing.pixels());
            let wider: Vec<Plan> = wider.map(|sharing| Plan { sharing, ..plan }).collect();
            (plan, variance) = best_with(&wider);
        }
    }
    let mut wavelengths = first;
    if asked.is_none() {
        // Companions tell of colour. Pictures are looked at in red, green and blue, where colour noise weighs
        // more than in X, Y and Z.
        let of_eight = relative(plan, WavelengthCount::Eight);
        if of_eight.colour * COST_OF_EIGHT < variance.colour {
            (wavelengths, variance) = (WavelengthCount::Eight, of_eight);
        }
    }
    let light = picture.scene.light_tracing().zip(known).map(|(tracing, known)| {
        let paths =
            tracing.subpaths.count(1, USUAL_SAMPLES_PER_PATH) as f64 * picture.schedule.samples() as f64;
        let paths = ((SHARES.0 * paths) as u64).clamp(1, MOST_SUBPATHS);
        let pilot = Pilot { sampler, schedule, seed, plan };
        with_count!(wavelengths, C => light_variance::<C>(picture, &pilot, tracing, paths, &known, progress))
    });
    let samples_per_path = light.map_or(USUAL_SAMPLES_PER_PATH, |light| {
        samples_per_path([variance.brightness, light], [cost(picture.scene, plan), LIGHT_SUBPATH])
    });
    Chosen { plan, wavelengths, samples_per_path }
}

/// Samples and number of blocks of the pilot with the longest nets for which the picture is large enough.
fn affordable(picture: &Exposure) -> Option<(Schedule, u64)> {
    let samples = (picture.extent.window.pixel_count() * picture.schedule.samples()) as f64;
    let longest = picture.schedule.samples_per_net().min(LENGTHS.1);
    let lengths = std::iter::successors(Some(longest), |length| Some(length / 2));
    let mut lengths = lengths.take_while(|&length| length >= LENGTHS.0.min(longest));
    lengths.find_map(|length| {
        let schedule = Schedule::independent(NETS, length);
        let per_block = u64::from(BLOCK * BLOCK) * schedule.samples() * TRIED as u64;
        let blocks = samples / per_block as f64;
        let count = ((SHARES.0 * blocks) as u64).clamp(BLOCKS.0, BLOCKS.1);
        (count as f64 <= SHARES.1 * blocks).then_some((schedule, count))
    })
}

/// The number with least variance times cost, by those of a sample and of a light subpath.
fn samples_per_path(variance: [f64; 2], cost: [f64; 2]) -> u64 {
    let total = |&samples: &u64| {
        let samples = samples as f64;
        (variance[0] + variance[1] * samples) * (cost[0] + cost[1] / samples)
    };
    let best = SAMPLES_PER_PATH.into_iter().min_by(|a, b| total(a).total_cmp(&total(b)));
    best.unwrap_or(USUAL_SAMPLES_PER_PATH)
}

/// The relative variance of a sample, the mean over the pixels of a pilot.
#[derive(Clone, Copy, Debug, Default)]
struct Relative {
    brightness: f64,
    /// The same, and the mean of that of red, green and blue, without the pixels that err most: one bright
    /// path would else decide between plans.
    typical: f64,
    colour: f64,
}

/// The part of the pixels that is left out there.
const LEFT_OUT: f64 = 0.02;

impl Relative {
    /// By what blocks with so many samples of a pixel have found.
    fn new(found: &[BlockNoise], samples: f64, known: &Brightness) -> Self {
        let sorted = |variance: fn(&[f64; 2], f64) -> f64| {
            let pixels = found.iter().flat_map(|block| block.pixels.iter().zip(&block.colour));
            let relative = pixels.map(|(pixel, &colour)| {
                let scale = samples * known.per_square(pixel[0]);
                scale * variance(pixel, colour)
            });
            let mut relative: Vec<f64> = relative.collect();
            relative.sort_by(f64::total_cmp);
            relative
        };
        let mean = |values: &[f64]| average(values.iter().copied());
        let most = |values: &[f64]| mean(&values[..values.len() - (LEFT_OUT * values.len() as f64) as usize]);
        let brightness = sorted(|&[_, variance], _| variance);
        let colour = sorted(|_, colour| colour);
        Self { brightness: mean(&brightness), typical: most(&brightness), colour: most(&colour) }
    }
}

/// Where some blocks of a window are.
fn corners(window: Region, count: u64) -> Vec<[i64; 2]> {
    let [across, down] = window.size.map(|size| u64::from(size.div_ceil(BLOCK)));
    let corner = |i: u64| {
        // Spread evenly over the rows and, by the golden ratio, over the columns.
        let row = i * down / count;
        let column = (i as f64 * 0.618_033_988_749_895).fract() * across as f64;
        [0, 1]
            .map(|axis| i64::from(window.offset[axis]) + i64::from(BLOCK) * [column as i64, row as i64][axis])
    };
    (0..count).map(corner).collect()
}

/// How bright a picture is, as far as a pilot knows.
struct Brightness {
    /// 1 % of the square of the mean.
    least: f64,
    /// The corner of each block, and the mean of [`Self::per_square`] over its pixels.
    blocks: Vec<([i64; 2], f64)>,
}

impl Brightness {
    /// By the means and variances of the pixels of blocks at some corners.
    fn new(corners: &[[i64; 2]], found: &[BlockNoise]) -> Self {
        let mean = average(found.iter().flat_map(|block| &block.pixels).map(|&[mean, _]| mean));
        let mut known = Self { least: relmse_scale(0.0, mean), blocks: Vec::new() };
        let of_block =
            |block: &BlockNoise| average(block.pixels.iter().map(|&[mean, _]| known.per_square(mean)));
        known.blocks = corners.iter().copied().zip(found.iter().map(of_block)).collect();
        known
    }

    /// What turns the variance of a pixel into a relative one.
    fn per_square(&self, mean: f64) -> f64 {
        let square = mean * mean + self.least;
        if square > 0.0 { 1.0 / square } else { 0.0 }
    }

    /// The same of a pixel of the whole film that nothing else is known of: as in the nearest block.
    fn near(&self, pixel: [i64; 2]) -> f64 {
        let distance = |corner: &[i64; 2]| {
            let [x, y] = [0, 1].map(|axis| pixel[axis] - corner[axis] - i64::from(BLOCK / 2));
            x * x + y * y
        };
        let nearest = self.blocks.iter().min_by_key(|(corner, _)| distance(corner));
        nearest.map_or(0.0, |&(_, per_square)| per_square)
    }
}

/// 0 of none.
pub(super) fn average(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for value in values {
        sum += value;
        count += 1.0;
    }
    if count == 0.0 { 0.0 } else { sum / count }
}

/// The relative variance of a pixel by light subpaths, one a pixel: the mean over the pixels of the picture.
///
/// An upper bound. Light subpaths that were independent, each to few pixels, would have about the mean of the
/// squares for their variance; theirs are stratified, and have less. Few bright ones may make most of that:
/// what is found is as uncertain as the root of the sum of the squares of its terms, which is added to it.
fn light_variance<const C: usize>(
    picture: &Exposure,
    pilot: &Pilot,
    tracing: &LightTracing,
    paths: u64,
    known: &Brightness,
    progress: &dyn Progress,
) -> f64 {
    let window = picture.extent.window;
    let pixels = window.pixel_count() as f64;
    let exposure = pilot.exposure(picture, picture.allocation, picture.groups);
    let light = LightPass::new(tracing, &exposure, pilot.sampler);
    let (mut sum, mut of_squares) = (0.0, 0.0);
    for (pixel, square) in light.squares::<C>(paths, progress) {
        let pixel = [0, 1].map(|axis| i64::from(pixel[axis]) + i64::from(window.offset[axis]));
        let relative = square * known.near(pixel);
        sum += relative;
        of_squares += relative * relative;
    }
    (sum + f64::sqrt(of_squares)) / (paths as f64 * pixels * pixels)
}

/// How a pilot renders: its sample values are its own.
pub(super) struct Pilot {
    pub sampler: SamplerKind,
    pub schedule: Schedule,
    pub seed: u64,
    pub plan: Plan,
}

impl Pilot {
    /// As the picture is exposed, by the pilot's samples. `even`: samples are allocated evenly.
    fn exposure<'a>(&self, picture: &Exposure<'a>, even: &'a Allocation, groups: &'a Groups) -> Exposure<'a> {
        let &Self { sampler, schedule, seed, plan } = self;
        let window = picture.extent.window;
        Exposure {
            extent: Extent { measured: window, shown: window, ..picture.extent },
            schedule,
            allocation: even,
            samplers: even.samplers(sampler, seed, schedule, groups.sharers()),
            seed,
            groups,
            plan,
            // Each pixel's own samples, whatever they are splatted onto.
            filter: FilterKind::Box,
            extras: picture.extras.clone(),
            ..*picture
        }
    }
}

/// What a pilot finds of a block.
#[derive(Clone, Debug, Default)]
pub(super) struct BlockNoise {
    /// For each pixel that has samples and is measured, what the nets make of it, and the variance of that.
    pub pixels: Vec<[f64; 2]>,
    /// For each of them the mean of the variances of red, green and blue.
    pub colour: Vec<f64>,
    /// Rays that a sample took on the average.
    pub rays: f64,
}

/// What a pilot finds of some blocks, by their corners. Blocks have no pixels once the pilot is cancelled.
pub(super) fn noise_of_blocks(
    picture: &Exposure,
    pilot: &Pilot,
    wavelengths: WavelengthCount,
    corners: &[[i64; 2]],
    progress: &dyn Progress,
) -> Vec<BlockNoise> {
    let even = Allocation::even(picture.extent.window);
    let members = Members::of(picture.scene, pilot.plan);
    let groups = Groups::new(members, pilot.schedule.nets(), pilot.seed);
    let exposure = pilot.exposure(picture, &even, &groups);
    with_count!(wavelengths, C => exposure.noise_of_blocks::<C>(corners, progress))
}

impl Exposure<'_> {
    fn noise_of_blocks<const C: usize>(
        &self,
        corners: &[[i64; 2]],
        progress: &dyn Progress,
    ) -> Vec<BlockNoise> {
        let of_block = |workspace: &mut Workspace<C>, corner: &[i64; 2]| {
            let is_stopped = progress.stop().load(Ordering::Relaxed);
            if is_stopped { BlockNoise::default() } else { self.noise_of_block(*corner, workspace) }
        };
        corners.par_iter().map_init(Workspace::default, of_block).collect()
    }

    fn noise_of_block<const C: usize>(&self, corner: [i64; 2], workspace: &mut Workspace<C>) -> BlockNoise {
        let before = rays_of_this_thread();
        let nets = self.schedule.nets();
        let tiles: Vec<_> = (0..nets)
            .map(|net| {
                let block = Block { net, corner };
                let mut tile = self.tile(&block);
                let indices = |_| 0..self.schedule.samples_per_replicate;
                self.block(&block, &indices, workspace, &mut tile);
                tile
            })
            .collect();
        let rays = rays_of_this_thread() - before;
        let n = f64::from(nets);
        let of_nets = |value: &dyn Fn(u32, &Tile) -> f64| {
            let values = (0..nets).zip(&tiles).map(|(net, tile)| value(net, tile));
            let mean = values.clone().sum::<f64>() / n;
            let variance = values.map(|value| (value - mean) * (value - mean)).sum::<f64>() / (n * (n - 1.0));
            [mean, variance]
        };
        let pixel =
            |&place: &usize| of_nets(&|net, tile| tile.brightness(place, net, self.scale, &self.extras));
        let rec709 = |place, net, tile: &Tile| {
            let xyz = [0, 1, 2].map(|channel| tile.mean(place, net, self.scale, channel..channel + 1));
            xyz_to_rec709(xyz.into())
        };
        let colour = |&place: &usize| {
            average((0..3).map(|channel| of_nets(&|net, tile| rec709(place, net, tile)[channel])[1]))
        };
        let is_sampled = |place: &usize| tiles.iter().all(|tile| tile.is_sampled(*place));
        let places: Vec<_> = (0..tiles[0].pixel_count()).filter(is_sampled).collect();
        let samples = (places.len() as u64 * self.schedule.samples()).max(1);
        BlockNoise {
            pixels: places.iter().map(pixel).collect(),
            colour: places.iter().map(colour).collect(),
            rays: rays as f64 / samples as f64,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where light subpaths make half of the noise there are as many as usual, and few where they make none.
    #[test]
    fn light_subpaths_are_as_many_as_pays() {
        assert_eq!(samples_per_path([1.0, 0.5], [1.0, 1.0]), 2);
        assert_eq!(samples_per_path([1.0, 1.0 / 16.0], [1.0, 1.0]), 4);
        assert_eq!(samples_per_path([1.0, 1e-4], [1.0, 1.0]), 16);
        assert_eq!(samples_per_path([0.0, 1.0], [1.0, 1.0]), 2);
    }
}
