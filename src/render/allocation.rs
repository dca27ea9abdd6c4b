//! How the samples of a picture are allocated: more of them where pixels err more.
//!
//! The film's window is divided into cells. A pilot estimates in each of them the variance of a sample and
//! what it costs, in rays. Each cell gets samples in proportion to the standard deviation over the root of
//! the cost, which is the least error for the cost of all samples. The shares are powers of two: each net
//! of a cell is then a whole Sobol net of its own length. A sample's weight is the inverse of its cell's
//! share, so that the film's filter sees the same picture however it is divided.
//!
//! Where the pilot does not show a clear gain the allocation is even.
//!
//! The pilot's sample values are its own, so the expectation of the picture is the same whatever it finds.

use super::Progress;
use super::Schedule;
use super::exposure::Exposure;
use super::groups::{BLOCK, Block};
use super::pilot::{self, BlockNoise, Chosen, Pilot, average};
use crate::film::Region;
use crate::sampling::{Sampler, SamplerKind, mix};
use crate::stats::relmse_scale;
use std::ops::Range;

/// Largest part of the picture's samples that the pilot takes.
const BUDGET: f64 = 0.02;

/// Most samples that it takes, per pixel of the picture: a render that ends at an error may need few.
const MOST: f64 = 0.6;

/// Least gain for which samples are allocated, as one half of the pilot predicts it for the other. Nets err
/// less than their samples alone, and most where there is little noise, so that fewer samples cost more there
/// than is predicted: of 1.1 may come anything from 0.74 to 1.05 (`validation/noise/stopping`).
const LEAST_GAIN: f64 = 1.25;

/// Nets of the pilot, and the samples of each.
const PILOT: (u32, u32) = (2, 1);

/// What a sample costs beside its rays, in rays.
const OVERHEAD: f64 = 1.0;

/// Tells the pilot's sample values from those of the picture and of other pilots.
const SEED: u64 = 0x616c_6c6f_6361;

/// Shortest and longest edge of a cell, pixels.
const EDGES: (u32, u32) = (16, 64);

/// Fewest cells for which it is worth while.
const FEWEST: usize = 8;

/// Longest replicate whose indices can be multiplied.
const LONGEST: u32 = 1 << 20;

/// The binary logarithm of a cell's number of samples over that of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Share(i32);

impl Share {
    pub const EVEN: Self = Self(0);

    const LEAST: i32 = -1;
    const MOST: i32 = 2;

    /// By what a sample's contribution is multiplied.
    pub fn weight(self) -> f64 {
        0.5f64.powi(self.0)
    }

    /// The cell's indices in place of those of a pixel of an even picture. Runs of indices that follow one
    /// another stay so, and the first index of all is in the first run.
    pub fn indices(self, even: Range<u32>) -> Range<u32> {
        let bound = |index: u32| match self.0 {
            up @ 0.. => index << up,
            down => index.div_ceil(1 << -down),
        };
        bound(even.start)..bound(even.end)
    }

    fn factor(self) -> f64 {
        2f64.powi(self.0)
    }
}

/// Shares of the cells of a window.
#[derive(Clone, Debug)]
pub(super) struct Allocation {
    window: Region,
    /// Edge of a cell, pixels.
    edge: u32,
    /// Row by row. One for all where the allocation is even.
    shares: Vec<Share>,
}

impl Allocation {
    pub fn even(window: Region) -> Self {
        Self { window, edge: u32::MAX, shares: vec![Share::EVEN] }
    }

    /// The share of a block, by where its middle is.
    pub fn of(&self, block: &Block) -> Share {
        let [column, row] = [0, 1].map(|axis| {
            let middle = block.corner[axis] + i64::from(BLOCK / 2) - i64::from(self.window.offset[axis]);
            middle.clamp(0, i64::from(self.window.size[axis]) - 1) as usize / self.edge as usize
        });
        self.shares[row * self.across() + column]
    }

    fn across(&self) -> usize {
        self.window.size[0].div_ceil(self.edge) as usize
    }

    /// The sample values of each share that there is.
    pub fn samplers(&self, kind: SamplerKind, seed: u64, schedule: Schedule, members: u32) -> Samplers {
        let sampler = |share: i32| {
            let share = Share(share);
            let is_used = self.shares.contains(&share);
            let length = schedule.per_net * share.indices(0..schedule.samples_per_replicate).len() as u32;
            is_used.then(|| Sampler::new(kind, seed, length).for_groups(members))
        };
        Samplers((Share::LEAST..=Share::MOST).map(sampler).collect())
    }

    /// What suits a picture that is rendered by the plan that it has. Even where the sampler has no nets of
    /// any length, where a pilot would cost too much, and when nobody waits for it.
    pub fn measured(picture: &Exposure, kind: SamplerKind, chosen: &Chosen, progress: &dyn Progress) -> Self {
        // Places are those of the whole picture: parts of it have the shares of the whole.
        let window = picture.extent.window;
        let even = Self::even(window);
        let schedule = picture.schedule;
        let is_netted = matches!(kind, SamplerKind::Sobol | SamplerKind::Independent);
        if !is_netted || schedule.samples_per_replicate > LONGEST {
            return even;
        }
        let of_pilot = Schedule::independent(PILOT.0, PILOT.1);
        let all = window.pixel_count() as f64;
        let budget = all * MOST.min(BUDGET * schedule.samples() as f64);
        let of_cell = f64::from(BLOCK * BLOCK) * of_pilot.samples() as f64;
        let cells = |edge: u32| window.size.map(|size| size.div_ceil(edge));
        let count = |edge: u32| cells(edge).into_iter().product::<u32>() as usize;
        let fits = |&edge: &u32| of_cell * count(edge) as f64 <= budget && count(edge) >= FEWEST;
        let edges = std::iter::successors(Some(EDGES.0), |edge| Some(2 * edge));
        let Some(edge) = edges.take_while(|&edge| edge <= EDGES.1).find(fits) else { return even };
        let seed = mix(picture.seed ^ SEED);
        let across = cells(edge)[0];
        let corner = |cell: usize| {
            let cell = [cell as u32 % across, cell as u32 / across];
            let random = mix(seed ^ u64::from(cell[0]) << 32 ^ u64::from(cell[1]));
            [0, 1].map(|axis| {
                let start = edge * cell[axis];
                let room = (window.size[axis] - start).min(edge).saturating_sub(BLOCK) + 1;
                let within = (random >> (32 * axis)) as u32 % room;
                i64::from(window.offset[axis]) + i64::from(start + within)
            })
        };
        let corners: Vec<[i64; 2]> = (0..count(edge)).map(corner).collect();
        let pilot = Pilot { sampler: kind, schedule: of_pilot, seed, plan: chosen.plan };
        let found = pilot::noise_of_blocks(picture, &pilot, chosen.wavelengths, &corners, progress);
        if predicted_gain(&found, schedule.samples_per_replicate) < LEAST_GAIN {
            return even;
        }
        Self { window, edge, shares: shares(&wanted(&found), schedule.samples_per_replicate) }
    }
}

/// The samplers of the shares that a picture has.
pub(super) struct Samplers(Vec<Option<Sampler>>);

impl Samplers {
    pub fn of(&self, share: Share) -> &Sampler {
        self.0[(share.0 - Share::LEAST) as usize].as_ref().expect("each share of a picture has its sampler")
    }
}

/// What a sample of a cell costs, in rays.
fn cost(cell: &BlockNoise) -> f64 {
    OVERHEAD + cell.rays
}

/// The relative standard deviation of the pixels of each cell. As the relative mean squared error does, it
/// takes 0.01 times the square of the picture's mean as the least square of a mean. That of a pixel is hardly
/// known, so the cell's own has half of the weight.
fn deviations(cells: &[BlockNoise]) -> Vec<f64> {
    let of_picture = average(cells.iter().flat_map(|cell| &cell.pixels).map(|&[mean, _]| mean));
    let of_cell = |BlockNoise { pixels, .. }: &BlockNoise| {
        let of_cell = average(pixels.iter().map(|&[mean, _]| mean));
        let relative = |&[mean, variance]: &[f64; 2]| {
            let square = 0.5 * (mean * mean + of_cell * of_cell) + relmse_scale(0.0, of_picture);
            if square > 0.0 { variance / square } else { 0.0 }
        };
        average(pixels.iter().map(relative)).sqrt()
    };
    cells.iter().map(of_cell).collect()
}

/// What the number of each cell's samples is to be in proportion to.
fn wanted(cells: &[BlockNoise]) -> Vec<f64> {
    deviations(cells).iter().zip(cells).map(|(deviation, cell)| deviation / cost(cell).sqrt()).collect()
}

/// By how much less the same error costs, by what a pilot found in each cell. A pilot finds differences where
/// there are none, so each half of every cell is judged with the shares that the other asks for, and the
/// lesser gain counts.
fn predicted_gain(cells: &[BlockNoise], samples_per_replicate: u32) -> f64 {
    let halves = cells.iter().map(|cell| {
        let (first, second) = cell.pixels.split_at(cell.pixels.len() / 2);
        let half = |pixels: &[[f64; 2]]| BlockNoise {
            pixels: pixels.to_vec(),
            rays: cell.rays,
            ..BlockNoise::default()
        };
        (half(first), half(second))
    });
    let [first, second]: [Vec<BlockNoise>; 2] = halves.unzip().into();
    let gain = |by: &[BlockNoise], of: &[BlockNoise]| {
        let shares = shares(&wanted(by), samples_per_replicate);
        let [mut even, mut allocated] = [[0.0; 2]; 2];
        for ((deviation, share), cell) in deviations(of).iter().zip(&shares).zip(of) {
            let variance = deviation * deviation;
            even = [even[0] + variance, even[1] + cost(cell)];
            allocated =
                [allocated[0] + variance * share.weight(), allocated[1] + cost(cell) * share.factor()];
        }
        let [even, allocated] = [even, allocated].map(|[variance, cost]| variance * cost);
        if allocated > 0.0 { even / allocated } else { 1.0 }
    };
    gain(&first, &second).min(gain(&second, &first))
}

/// The shares nearest to the proportion of what is wanted for which the mean share is at most 1.
fn shares(wanted: &[f64], samples_per_replicate: u32) -> Vec<Share> {
    // Fewer samples than one are none.
    let least = if samples_per_replicate.is_multiple_of(2) { Share::LEAST } else { 0 };
    let with = |scale: f64| -> Vec<Share> {
        let share = |&wanted: &f64| {
            let wanted = wanted * scale;
            let up = (least + 1..=Share::MOST).rev();
            // Halfway on the logarithmic scale.
            Share(up.clone().find(|&share| wanted >= Share(share).factor() * 0.5f64.sqrt()).unwrap_or(least))
        };
        wanted.iter().map(share).collect()
    };
    let total = |shares: &[Share]| shares.iter().map(|share| share.factor()).sum::<f64>();
    let most = wanted.iter().copied().fold(0.0, f64::max);
    if most <= 0.0 {
        return vec![Share::EVEN; wanted.len()];
    }
    // Between all cells at the least share and the cell that wants most at the greatest.
    let (mut low, mut high) = (0.0, f64::from(1 << 20) / most);
    if total(&with(low)) > wanted.len() as f64 {
        return vec![Share::EVEN; wanted.len()];
    }
    for _ in 0..48 {
        let middle = 0.5 * (low + high);
        if total(&with(middle)) <= wanted.len() as f64 {
            low = middle;
        } else {
            high = middle;
        }
    }
    with(low)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_that_vary_more_have_more_samples() {
        let of = |deviations: &[f64], samples: u32| -> Vec<i32> {
            shares(deviations, samples).iter().map(|share| share.0).collect()
        };
        assert_eq!(of(&[1.0, 1.0, 1.0, 1.0], 8), [0, 0, 0, 0]);
        assert_eq!(of(&[0.0; 3], 8), [0, 0, 0]);
        assert_eq!(of(&[1.0, 1.0, 1.0, 4.0], 8), [-1, -1, -1, 1]);
        assert_eq!(of(&[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], 8), [-1, -1, -1, -1, -1, -1, -1, 2]);
        // A single sample cannot be halved.
        assert_eq!(of(&[1.0, 1.0, 1.0, 4.0], 1), [0, 0, 0, 0]);
    }

    /// A gain that one half of a cell promises and the other does not keep is none.
    #[test]
    fn a_gain_is_predicted_by_what_both_halves_of_cells_say() {
        let cell = |first: f64, second: f64, cost: f64| {
            let pixels = vec![[1.0, first], [1.0, first], [1.0, second], [1.0, second]];
            BlockNoise { pixels, rays: cost - OVERHEAD, ..BlockNoise::default() }
        };
        let of = |cells: [BlockNoise; 4]| predicted_gain(&cells, 8);
        let (quiet, noisy) = (|| cell(0.0, 0.0, 1.0), |cost: f64| cell(1.0, 1.0, cost));
        // Twice the samples for one cell and half for the others, of which the pilot saw no error.
        let clear = of([quiet(), quiet(), quiet(), noisy(1.0)]);
        assert!((clear - 2.0 * 4.0 / 3.5).abs() < 1e-9, "{clear}");
        assert_eq!(of([(); 4].map(|()| noisy(1.0))), 1.0);
        assert_eq!(of([(); 4].map(|()| quiet())), 1.0);
        let apparent = of([cell(1.0, 0.0, 1.0), cell(0.0, 1.0, 1.0), quiet(), quiet()]);
        assert!(apparent < 1.0, "{apparent}");
        // What costs most of all gains little by having more samples.
        let dear = of([quiet(), quiet(), quiet(), noisy(9.0)]);
        assert!((dear - 2.0 * 12.0 / 19.5).abs() < 1e-9, "{dear}");
    }

    /// As many cells as err by 1 for 1 have twice the samples of those that err by 1 for 4.
    #[test]
    fn what_costs_more_has_fewer_samples() {
        let cell = |cost: f64| BlockNoise {
            pixels: vec![[1.0, 1.0]; 4],
            rays: cost - OVERHEAD,
            ..BlockNoise::default()
        };
        let of = shares(&wanted(&[cell(1.0), cell(4.0), cell(4.0), cell(4.0)]), 8);
        assert_eq!(of.iter().map(|share| share.0).collect::<Vec<_>>(), [0, -1, -1, -1]);
    }

    /// However a picture's indices are cut, each index of a cell is in one of the runs, and the first is in
    /// the first.
    #[test]
    fn indices_of_cells_make_up_their_nets() {
        for share in (Share::LEAST..=Share::MOST).map(Share) {
            let all: Vec<u32> =
                [0..1, 1..2, 2..3, 3..7, 7..16].into_iter().flat_map(|run| share.indices(run)).collect();
            let count = (16.0 * share.factor()) as u32;
            assert_eq!(all, (0..count).collect::<Vec<_>>());
            assert!(!share.indices(0..1).is_empty());
            assert_eq!(share.weight() * share.factor(), 1.0);
        }
    }
}
