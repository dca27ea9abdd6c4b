//! The samples of a picture, from the sample values to the sums of the film.

use super::allocation::{Allocation, Samplers, Share};
use super::groups::{Block, Groups, Pixel};
use super::{Schedule, admit};
use crate::film::{Extent, Extras, FilmSample, FilterKind, FixedPoint, Footprint, Region, Tile, Tristimulus};
use crate::integrator::{self, GroupSample, Plan, RadianceSample, Sight, TOGETHER, Workspace};
use crate::sampling::{Dimensions, Member, mix};
use crate::scene::Scene;
use crate::spectrum::colour::MITSUBA_Y_INTEGRAL;
use crate::spectrum::{Sampled, Wavelengths};
use smallvec::SmallVec;
use std::ops::Range;

pub(super) struct Exposure<'a> {
    pub scene: &'a Scene,
    /// The parts of the film: what is measured need not be what the scene says.
    pub extent: Extent,
    pub schedule: Schedule,
    pub allocation: &'a Allocation,
    pub samplers: Samplers,
    pub seed: u64,
    pub groups: &'a Groups,
    pub plan: Plan,
    /// Samples of a pixel for one light subpath a pixel.
    pub samples_per_path: u64,
    pub filter: FilterKind,
    pub scale: FixedPoint,
    pub square_scale: FixedPoint,
    pub light_scale: FixedPoint,
    pub extras: Extras,
}

/// One sample of a net, the same of each pixel of a group.
#[derive(Clone, Copy)]
pub(super) struct NetSample {
    pub net: u32,
    /// In the net.
    pub index: u32,
    pub replicate: u32,
    pub share: Share,
}

/// The samples of a group as they begin.
#[derive(Default)]
pub(super) struct Aimed<'a, const C: usize> {
    /// Those of all members, or one for each, in their order.
    wavelengths: Vec<Wavelengths<C>>,
    pub time: f64,
    /// One for each member, in their order.
    pub samples: Vec<Sample<C>>,
    /// Camera rays of those at whose place the sensor measures something.
    pub sights: Vec<Sight<'a>>,
}

/// Memory for some samples of a group, filled anew each time and never moved.
#[derive(Default)]
struct SampleMemory<'a, const C: usize> {
    aimed: [Aimed<'a, C>; TOGETHER],
    seen: [Seen<C>; TOGETHER],
}

/// Where a sample of a pixel is, and what its radiance is multiplied by.
pub(super) struct Sample<const C: usize> {
    pub place: [f64; 2],
    /// By what the sensor multiplies the radiance; zero where it measures nothing.
    pub weight: Sampled<C>,
    /// Stands for the sample, and is as good as random.
    key: u64,
}

/// What a unit of radiance at each wavelength of a path adds to X, Y and Z.
type Responses<const C: usize> = [[f64; 3]; C];

/// What camera rays lead to, by the members' numbers.
pub(super) type Seen<const C: usize> = Vec<RadianceSample<C>>;

impl<const C: usize> Aimed<'_, C> {
    /// Those of a member.
    pub fn wavelengths_of(&self, member: usize) -> &Wavelengths<C> {
        self.wavelengths.get(member).unwrap_or(&self.wavelengths[0])
    }

    /// As the integrator takes them.
    pub fn of_group(&self) -> GroupSample<'_, C> {
        GroupSample { sights: &self.sights, time: self.time, wavelengths: &self.wavelengths }
    }
}

/// What is added to the film.
#[derive(Default)]
pub(super) struct Contributions {
    pub xyz: [f64; 3],
    /// To other channels, by their numbers.
    pub others: SmallVec<[(usize, f64); 4]>,
}

impl Exposure<'_> {
    /// An empty tile of all pixels that samples of a block may reach.
    pub fn tile(&self, block: &Block) -> Tile {
        let (reach, measured) = (i64::from(self.filter.reach()), self.extent.measured);
        let [columns, rows] = [0, 1].map(|axis| {
            let first = block.corner[axis] - i64::from(measured.offset[axis]);
            let clamped = |place: i64| place.clamp(0, i64::from(measured.size[axis])) as u32;
            clamped(first - reach)..clamped(first + i64::from(self.groups.extent_of_block()) + reach)
        });
        let first = block.net * self.schedule.per_net;
        self.extras.tile(
            [columns.start, rows.start],
            [columns.len() as u32, rows.len() as u32],
            first..first + self.schedule.per_net,
        )
    }

    /// The samples of these indices, told by replicate, of all pixels of a block. How many these are in a
    /// picture whose samples are allocated evenly.
    pub fn block<const C: usize>(
        &self,
        block: &Block,
        indices: &dyn Fn(u32) -> Range<u32>,
        workspace: &mut Workspace<C>,
        tile: &mut Tile,
    ) -> u64 {
        let first = block.net * self.schedule.per_net;
        let share = self.allocation.of(block);
        let run_length = share.indices(0..self.schedule.samples_per_replicate).len() as u32;
        let taken = |run: u32| share.indices(indices(first + run));
        let [even, each]: [u32; 2] = (0..self.schedule.per_net)
            .map(|run| [indices(first + run).len() as u32, taken(run).len() as u32])
            .fold([0; 2], |[even, each], [e, t]| [even + e, each + t]);
        let mut memory = SampleMemory::default();
        let mut samples = 0;
        for group in self.groups.of(block) {
            let group = self.on_film(group);
            if !group.iter().any(|pixel| self.counts(pixel)) {
                continue;
            }
            let of_run = |run: u32| taken(run).map(move |index| (run, run * run_length + index));
            let mut left = (0..self.schedule.per_net).flat_map(of_run).map(|(run, index)| NetSample {
                net: block.net,
                index,
                replicate: first + run,
                share,
            });
            loop {
                let some: SmallVec<[NetSample; TOGETHER]> = left.by_ref().take(TOGETHER).collect();
                if some.is_empty() {
                    break;
                }
                self.group(&group, &some, &mut memory, workspace, tile);
            }
            for pixel in &group {
                if let Some(place) = self.place_of(pixel.place, tile) {
                    tile.count(place, each);
                    samples += u64::from(even);
                }
            }
        }
        samples
    }

    /// The pixels of a group that have samples.
    pub fn on_film(&self, group: impl Iterator<Item = Pixel>) -> SmallVec<[Pixel; 16]> {
        group.filter(|pixel| self.is_within(Region::whole(self.extent.whole), pixel)).collect()
    }

    /// Whether a pixel is one of a region, or of the border around it in which there are samples too.
    fn is_within(&self, region: Region, pixel: &Pixel) -> bool {
        let film = &self.scene.film;
        let border = if film.sample_border { i64::from(self.filter.reach()) } else { 0 };
        (0..2).all(|axis| {
            let first = i64::from(region.offset[axis]) - border;
            (first..region.end()[axis] as i64 + border).contains(&pixel.place[axis])
        })
    }

    /// Whether a pixel's samples are part of what is measured. The others are there for their group alone.
    pub fn counts(&self, pixel: &Pixel) -> bool {
        let Extent { window, measured, .. } = self.extent;
        let reach = i64::from(self.filter.reach());
        let reaches = |axis: usize| {
            let first = i64::from(measured.offset[axis]) - reach;
            (first..measured.end()[axis] as i64 + reach).contains(&pixel.place[axis])
        };
        self.is_within(window, pixel) && reaches(0) && reaches(1)
    }

    /// Where in a tile a pixel of the whole film is.
    fn place_of(&self, place: [i64; 2], tile: &Tile) -> Option<usize> {
        let corner = self.extent.measured.offset;
        let [x, y] = [0, 1].map(|axis| u32::try_from(place[axis] - i64::from(corner[axis])).ok());
        tile.place(x?, y?)
    }

    /// Some samples of each pixel of a group.
    fn group<'a, const C: usize>(
        &'a self,
        group: &[Pixel],
        net_samples: &[NetSample],
        memory: &mut SampleMemory<'a, C>,
        workspace: &mut Workspace<C>,
        tile: &mut Tile,
    ) {
        let (aimed, seen) = (&mut memory.aimed[..net_samples.len()], &mut memory.seen[..net_samples.len()]);
        aimed.iter_mut().zip(net_samples).for_each(|(aimed, &net_sample)| self.aim(group, net_sample, aimed));
        self.see(aimed, workspace, seen);
        for (&net_sample, (aimed, seen)) in net_samples.iter().zip(aimed.iter().zip(seen)) {
            let samples = aimed.samples.iter().zip(seen).enumerate();
            let of_group = match &aimed.wavelengths[..] {
                [wavelengths] => Some(self.responses(wavelengths)),
                _ => None,
            };
            // All of them before any is splatted: none waits for another.
            let footprints: SmallVec<[Footprint; 16]> =
                aimed.samples.iter().map(|sample| self.filter.footprint(sample.place)).collect();
            for ((pixel, footprint), (member, (sample, seen))) in group.iter().zip(&footprints).zip(samples) {
                if self.counts(pixel) {
                    admit(&mut seen.radiance, &mut tile.bad);
                    let wavelengths = aimed.wavelengths_of(member);
                    let responses = of_group.unwrap_or_else(|| self.responses(wavelengths));
                    let measured = seen.radiance * sample.weight;
                    let contributions = self.contributions(&measured, wavelengths, &responses);
                    let sample = FilmSample {
                        measured: Tristimulus::new(contributions.xyz, self.scale),
                        replicate: net_sample.replicate,
                        share: net_sample.share.weight(),
                        key: sample.key,
                    };
                    self.splat(footprint, &sample, seen.alpha_hit, &contributions, tile);
                }
            }
        }
    }

    /// What the samples of a group begin with.
    #[inline(always)]
    pub fn aim<'a, const C: usize>(
        &'a self,
        group: &[Pixel],
        net_sample: NetSample,
        aimed: &mut Aimed<'a, C>,
    ) {
        let (scene, NetSample { net, index, share, .. }) = (self.scene, net_sample);
        let sampler = self.samplers.of(share);
        let stream_of = |pixel: &Pixel| {
            sampler.member_stream(pixel.member, pixel.place.map(|place| place as u32), net, index)
        };
        // The time is the group's, and so are the wavelengths if it shares sample values.
        let origin = group[0].member.origin;
        let leader = Pixel {
            place: origin.map(|place| i64::from(place as i32)),
            member: Member { origin, number: 0 },
        };
        let leading = stream_of(&leader);
        let [.., wavelength, time] = leading.draw(Dimensions::Camera);
        let shares = self.groups.sharers() > 1;
        let Aimed { wavelengths, samples, sights, .. } = aimed;
        wavelengths.clear();
        samples.clear();
        sights.clear();
        if shares {
            // Spread wavelengths make the runs of a net differ more than the net errs, and its error bars too
            // wide. Groups that share gain more by them than that.
            wavelengths.push(scene.wavelengths.sample::<C>(leading.spread(wavelength, C as u32)));
        }
        let time = scene.shutter.time(time);
        aimed.time = time;
        for (member, pixel) in group.iter().enumerate() {
            let stream = stream_of(pixel);
            let [x, y, wavelength, _] = stream.draw(Dimensions::Camera);
            if !shares {
                wavelengths.push(scene.wavelengths.sample::<C>(wavelength));
            }
            let wavelengths = wavelengths.get(member).unwrap_or(&wavelengths[0]);
            let place = [pixel.place[0] as f64 + x, pixel.place[1] as f64 + y];
            let [column, row] = pixel.place.map(|place| place as u64);
            let of_pixel = mix(self.seed ^ mix(column << 32 ^ row));
            let key = mix(of_pixel ^ (u64::from(net) << 32 | u64::from(index)));
            let mut weight = Sampled::ZERO;
            if let Some(sensor) = scene.sensor_ray(place, time, &stream) {
                weight = sensor.response.map_or(Sampled::ONE, |response| response.sample(&wavelengths.nm));
                weight *= sensor.weight;
                sights.push(Sight { member, ray: sensor.ray, lit: sensor.lit, stream });
            }
            samples.push(Sample { place, weight, key });
        }
    }

    /// What the camera rays of samples of a group lead to, each by the members' numbers.
    pub fn see<const C: usize>(
        &self,
        aimed: &[Aimed<C>],
        workspace: &mut Workspace<C>,
        seen: &mut [Seen<C>],
    ) {
        for (aimed, seen) in aimed.iter().zip(&mut *seen) {
            seen.clear();
            seen.resize(aimed.samples.len(), RadianceSample::NOTHING);
        }
        if self.plan == Plan::PLAIN && !integrator::takes_strangers(self.scene) {
            for (aimed, seen) in aimed.iter().zip(seen) {
                for Sight { member, ray, lit, stream } in &aimed.sights {
                    let wavelengths = aimed.wavelengths_of(*member);
                    seen[*member] =
                        integrator::radiance(self.scene, *ray, *lit, aimed.time, wavelengths, stream);
                }
            }
            return;
        }
        let samples: SmallVec<[GroupSample<C>; TOGETHER]> = aimed.iter().map(Aimed::of_group).collect();
        let mut of_samples: SmallVec<[&mut [RadianceSample<C>]; TOGETHER]> =
            seen.iter_mut().map(|seen| &mut seen[..]).collect();
        integrator::radiance_of_group(self.scene, &samples, self.plan, &mut of_samples, workspace);
    }

    /// Adds a sample to all pixels that its filter reaches.
    fn splat(
        &self,
        footprint: &Footprint,
        sample: &FilmSample,
        alpha_hit: bool,
        Contributions { xyz, others }: &Contributions,
        tile: &mut Tile,
    ) {
        let corner = self.extent.measured.offset;
        tile.splat(footprint, sample, corner);
        let alpha = self.extras.alpha && alpha_hit;
        if !alpha && !self.extras.moments && others.is_empty() {
            return;
        }
        tile.visit(footprint, sample, corner, |tile, place, weight| {
            let mut add = |channel, value, scale| {
                tile.add(place, sample.replicate, channel, value * weight, scale);
            };
            if alpha {
                add(self.extras.alpha_channel(), 1.0, FixedPoint::SHARE);
            }
            if self.extras.moments {
                for (channel, value) in xyz.iter().enumerate() {
                    add(self.extras.moment_channel(channel), value * value, self.square_scale);
                }
            }
            for &(channel, value) in others {
                add(channel, value, self.scale);
            }
        });
    }

    /// What a unit of radiance at each wavelength of a path adds to X, Y and Z.
    pub fn responses<const C: usize>(&self, wavelengths: &Wavelengths<C>) -> Responses<C> {
        std::array::from_fn(|lane| {
            let (nm, factor) = (wavelengths.nm[lane], counts_for(wavelengths, lane) / MITSUBA_Y_INTEGRAL);
            self.scene.observer.at(nm).map(|response| response * factor)
        })
    }

    /// What a path that measured this adds to the channels of the film. `responses`: to its wavelengths.
    pub fn contributions<const C: usize>(
        &self,
        measured: &Sampled<C>,
        wavelengths: &Wavelengths<C>,
        responses: &Responses<C>,
    ) -> Contributions {
        let scene = self.scene;
        let mut contributions = Contributions::default();
        for (measured, response) in measured.0.iter().zip(responses) {
            for channel in 0..3 {
                contributions.xyz[channel] += measured * response[channel];
            }
        }
        if scene.film.channels.is_empty() && self.extras.bins.is_none() {
            return contributions;
        }
        for lane in (0..C).filter(|&lane| measured[lane] != 0.0) {
            let (nm, weight) = (wavelengths.nm[lane], measured[lane] * counts_for(wavelengths, lane));
            for (index, channel) in scene.film.channels.iter().enumerate() {
                let value = weight * channel.response.at(nm) / channel.integral;
                contributions.others.push((self.extras.response_channel(index), value));
            }
            if let Some(bins) = &self.extras.bins
                && let Some(bin) = bins.of(nm)
            {
                contributions.others.push((self.extras.bin_channel(bin), weight / bins.width()));
            }
        }
        contributions
    }
}

/// The range of wavelengths, in nanometres, that a wavelength of a path stands for.
fn counts_for<const C: usize>(wavelengths: &Wavelengths<C>, lane: usize) -> f64 {
    let density = wavelengths.density[lane];
    if density > 0.0 { 1.0 / density } else { 0.0 }
}
