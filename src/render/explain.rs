//! One sample of a pixel, told step by step, from the sample values that the picture has.

use super::allocation::Share;
use super::exposure::{Aimed, Exposure, NetSample, Seen};
use super::groups::{Block, Pixel};
use super::settings::with_count;
use super::{Measures, NoProgress, Settings, with_exposure};
use crate::film::{Extent, Film, FixedPoint, Region};
use crate::integrator::{self, Plan, RecordedStep, Sight, Workspace};
use crate::scene::{Integrator, Scene};
use crate::spectrum::{Sampled, Wavelengths};
use serde::Serialize;
use smallvec::SmallVec;

/// Which of the samples that a pixel sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// The pixel's own of this number, from 0.
    Sample(u64),
    /// The one that brings the most to its Y, of its own and of those of its neighbours that the film's
    /// filter spreads over it.
    Brightest,
}

/// A sample and what it is made of. Places are in the coordinates of the file; radiances, in W·m⁻²·sr⁻¹·nm⁻¹,
/// are in the order of the wavelengths. A radiance over the number of them and over the density of its
/// wavelength is what the film sums.
#[derive(Clone, Debug, Serialize)]
pub struct Explained {
    /// Whose sample it is.
    pub pixel: [u32; 2],
    /// Its number among the pixel's samples.
    pub sample: u64,
    /// Samples of the pixel.
    pub samples: u64,
    /// The replicate of the picture that it is a part of.
    pub replicate: u32,
    /// Where on the film, in pixels from its corner.
    pub place: [f64; 2],
    /// Time at which the path is traced, in the scene's unit.
    pub time: f64,
    /// The hero's wavelength first, nm.
    pub wavelengths: Vec<f64>,
    /// Density with which each wavelength could have been chosen, nm⁻¹.
    pub wavelength_densities: Vec<f64>,
    /// Where the camera ray begins, and its direction.
    pub origin: [f64; 3],
    /// Unit vector along the camera ray.
    pub direction: [f64; 3],
    /// By what the sensor multiplies the radiance.
    pub sensor_weight: Vec<f64>,
    /// Radiance of the sample.
    pub radiance: Vec<f64>,
    /// Its Y, as it is in the film.
    pub luminance: f64,
    /// What it brings to the pixel that was asked for, over that pixel's Y.
    pub share_of_pixel: f64,
    /// Y of that pixel, of all samples that it sees. Light subpaths are not in it.
    pub pixel_luminance: f64,
    /// Where pixels share the suffixes of their paths: what comes from each of them.
    pub shared: Option<Shared>,
    /// The radiance of the path that is told, and its steps.
    pub path_radiance: Vec<f64>,
    /// What happened to the path, in order.
    pub steps: Vec<RecordedStep>,
}

/// The parts of the radiance of a sample that shares suffixes.
#[derive(Clone, Debug, Serialize)]
pub struct Shared {
    /// What is the pixel's own: emission of what it sees, light samples at its first surface, and all that
    /// comes by directions without a density.
    pub own: Vec<f64>,
    /// What the paths of the pixels of its group contribute, itself included, the largest first.
    pub parts: Vec<Contribution>,
    /// The pixel whose path is told: of which the most comes.
    pub told: [u32; 2],
}

/// What a sample gets of the path of a pixel.
#[derive(Clone, Debug, Serialize)]
pub struct Contribution {
    /// Column and row of the pixel.
    pub pixel: [u32; 2],
    /// What comes from its path.
    pub radiance: Vec<f64>,
}

/// Tells what a sample of the picture of these settings is made of. The error says what is wrong with the
/// question.
pub fn explain(
    scene: &Scene,
    settings: &Settings,
    pixel: [u32; 2],
    wanted: Wanted,
) -> Result<Explained, String> {
    if scene.integrator != Integrator::Path {
        return Err("the integrator is no path tracer: only paths are told".to_owned());
    }
    if scene.film.extent.window.within(pixel).is_none() {
        let [width, height] = scene.film.extent.whole;
        return Err(format!("the picture of {width}×{height} pixels has no pixel {},{}", pixel[0], pixel[1]));
    }
    // Only its scales are asked for, which are those of the whole film.
    let here = Region { offset: pixel, size: [1, 1] };
    let extent = Extent { measured: here, shown: here, ..scene.film.extent };
    let scale = FixedPoint::for_reference(scene.reference_radiance);
    let film = Film::part(extent, settings.schedule().replicates, settings.extras(scene), scale);
    let measures = Measures::of(&film);
    with_exposure(
        scene,
        settings,
        &measures,
        &NoProgress::new(),
        |exposure, count| with_count!(count, C => exposure.explain::<C>(pixel, wanted)),
    )
}

/// The numbers up to a distance from one, that one first.
fn from_middle(middle: i64, reach: i64) -> impl Iterator<Item = i64> {
    std::iter::once(middle).chain((middle - reach..=middle + reach).filter(move |&other| other != middle))
}

/// A sample among those that a pixel sees.
struct Candidate {
    pixel: [i64; 2],
    number: u64,
    samples: u64,
    net_sample: NetSample,
    group: SmallVec<[Pixel; 16]>,
    member: usize,
}

/// The samples of a pixel in one replicate.
struct Run {
    net: u32,
    replicate: u32,
    /// Index of the first within its net, and how many there are.
    first: u32,
    samples: u32,
    share: Share,
    group: SmallVec<[Pixel; 16]>,
    member: usize,
}

impl Run {
    fn net_sample(&self, index: u32) -> NetSample {
        let Self { net, replicate, first, share, .. } = *self;
        NetSample { net, index: first + index, replicate, share }
    }

    /// The number of a sample among all of the pixel's, which take turns: the first of each run comes before
    /// the second of any.
    fn number(&self, index: u32, all: &[Self]) -> u64 {
        let before = |run: &Self| {
            let next = u32::from(run.replicate < self.replicate);
            u64::from(run.samples.min(index + next))
        };
        all.iter().map(before).sum()
    }
}

impl Exposure<'_> {
    fn explain<const C: usize>(&self, pixel: [u32; 2], wanted: Wanted) -> Result<Explained, String> {
        let own = pixel.map(i64::from);
        let reach = i64::from(self.filter.reach());
        let (mut sum, mut weights) = (0.0, 0.0);
        let mut found: Option<(f64, Candidate)> = None;
        // The pixel itself comes first: of samples that bring the same, nothing above all, its own is told.
        for y in from_middle(own[1], reach) {
            for x in from_middle(own[0], reach) {
                let runs = self.runs([x, y]);
                let samples = runs.iter().map(|run| u64::from(run.samples)).sum();
                if let (Wanted::Sample(number), true) = (wanted, [x, y] == own)
                    && number >= samples
                {
                    return Err(format!("pixel {x},{y} has {samples} samples, from 0: there is no {number}"));
                }
                for (run, index) in runs.iter().flat_map(|run| (0..run.samples).map(move |i| (run, i))) {
                    let (luminance, weight) =
                        self.brings::<C>(&run.group, run.member, run.net_sample(index), own);
                    sum += luminance * weight;
                    weights += weight;
                    let is_wanted = match wanted {
                        Wanted::Sample(number) => [x, y] == own && run.number(index, &runs) == number,
                        Wanted::Brightest => {
                            found.as_ref().is_none_or(|&(most, _)| (luminance * weight).abs() > most)
                        }
                    };
                    if is_wanted {
                        let candidate = Candidate {
                            pixel: [x, y],
                            number: run.number(index, &runs),
                            samples,
                            net_sample: run.net_sample(index),
                            group: run.group.clone(),
                            member: run.member,
                        };
                        found = Some(((luminance * weight).abs(), candidate));
                    }
                }
            }
        }
        let Some((_, candidate)) = found else { return Err("the pixel has no samples".to_owned()) };
        let luminance = if weights == 0.0 { 0.0 } else { sum / weights };
        let (brings, weight) =
            self.brings::<C>(&candidate.group, candidate.member, candidate.net_sample, own);
        let share = if sum == 0.0 { 0.0 } else { brings * weight / sum };
        self.told::<C>(&candidate, [luminance, share])
    }

    /// The samples of a pixel, run by run.
    fn runs(&self, place: [i64; 2]) -> Vec<Run> {
        let per_net = self.schedule.per_net;
        let mut found = Vec::new();
        for net in 0..self.schedule.nets() {
            let pixels = [place[0]..place[0] + 1, place[1]..place[1] + 1];
            for block in self.groups.blocks(net, pixels) {
                let Some(group) = self.group_of(&block, place) else { continue };
                let Some(member) = group.iter().position(|pixel| pixel.place == place) else { continue };
                if !self.counts(&group[member]) {
                    continue;
                }
                let share = self.allocation.of(&block);
                let samples = share.indices(0..self.schedule.samples_per_replicate).len() as u32;
                found.extend((0..per_net).map(|run| Run {
                    net,
                    replicate: net * per_net + run,
                    first: run * samples,
                    samples,
                    share,
                    group: group.clone(),
                    member,
                }));
            }
        }
        found
    }

    fn group_of(&self, block: &Block, place: [i64; 2]) -> Option<SmallVec<[Pixel; 16]>> {
        self.groups
            .of(block)
            .map(|group| self.on_film(group))
            .find(|group| group.iter().any(|pixel| pixel.place == place))
    }

    /// The Y of a sample, and what it weighs in a pixel.
    fn brings<const C: usize>(
        &self,
        group: &[Pixel],
        member: usize,
        net_sample: NetSample,
        pixel: [i64; 2],
    ) -> (f64, f64) {
        let aimed = self.aimed::<C>(group, net_sample);
        let footprint = self.filter.footprint(aimed.samples[member].place);
        let weight = footprint.weight(pixel) * net_sample.share.weight();
        if weight == 0.0 {
            return (0.0, 0.0);
        }
        let measured = self.seen_by(&aimed)[member].radiance * aimed.samples[member].weight;
        (self.luminance(&measured, aimed.wavelengths_of(member)), weight)
    }

    fn aimed<const C: usize>(&self, group: &[Pixel], net_sample: NetSample) -> Aimed<'_, C> {
        let mut aimed = Aimed::default();
        self.aim(group, net_sample, &mut aimed);
        aimed
    }

    fn seen_by<const C: usize>(&self, aimed: &Aimed<C>) -> Seen<C> {
        let mut seen = Seen::new();
        let (samples, radiance) = (std::slice::from_ref(aimed), std::slice::from_mut(&mut seen));
        self.see(samples, &mut Workspace::default(), radiance);
        seen
    }

    fn luminance<const C: usize>(&self, measured: &Sampled<C>, wavelengths: &Wavelengths<C>) -> f64 {
        self.contributions(measured, wavelengths, &self.responses(wavelengths)).xyz[1]
    }

    fn told<const C: usize>(
        &self,
        candidate: &Candidate,
        [pixel_luminance, share_of_pixel]: [f64; 2],
    ) -> Result<Explained, String> {
        let Candidate { pixel, number, samples, net_sample, group, member } = candidate;
        let aimed = self.aimed::<C>(group, *net_sample);
        let sample = &aimed.samples[*member];
        let sight_of = |member: usize| aimed.sights.iter().find(|sight| sight.member == member);
        let Some(Sight { ray, .. }) = sight_of(*member) else {
            return Err("the sensor measures nothing at the sample's place".to_owned());
        };
        let radiance = self.seen_by(&aimed)[*member].radiance;
        let of_member = |member: usize| group[member].place.map(|place| place as u32);
        let (mut told, mut shared) = (*member, None);
        if self.plan != Plan::PLAIN {
            let (own, mut parts) =
                integrator::parts_of_group(self.scene, aimed.of_group(), self.plan, *member);
            parts.sort_by(|(_, a), (_, b)| b.sum().total_cmp(&a.sum()));
            if let Some((most, part)) = parts.first()
                && part.sum() > own.sum()
            {
                told = *most;
            }
            let parts = parts
                .into_iter()
                .map(|(member, part)| Contribution { pixel: of_member(member), radiance: part.0.to_vec() });
            shared = Some(Shared { own: own.0.to_vec(), parts: parts.collect(), told: of_member(told) });
        }
        let Some(sight) = sight_of(told) else {
            return Err("the sensor measures nothing at the sample's place".to_owned());
        };
        let (path, steps) = integrator::radiance_told(
            self.scene,
            sight.ray,
            sight.lit,
            aimed.time,
            aimed.wavelengths_of(told),
            &sight.stream,
        );
        let wavelengths = aimed.wavelengths_of(*member);
        Ok(Explained {
            pixel: pixel.map(|place| place as u32),
            sample: *number,
            samples: *samples,
            replicate: net_sample.replicate,
            place: sample.place,
            time: aimed.time,
            wavelengths: wavelengths.nm.to_vec(),
            wavelength_densities: wavelengths.density.0.to_vec(),
            origin: self.scene.in_file(ray.origin).to_array(),
            direction: ray.direction.to_array(),
            sensor_weight: sample.weight.0.to_vec(),
            radiance: radiance.0.to_vec(),
            luminance: self.luminance(&(radiance * sample.weight), wavelengths),
            share_of_pixel,
            pixel_luminance,
            shared,
            path_radiance: path.radiance.0.to_vec(),
            steps,
        })
    }
}
