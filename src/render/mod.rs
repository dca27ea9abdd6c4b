//! From a compiled scene to an exposed film: pixels, threads, progress, interruption.

mod auxiliary;
mod light;

pub use auxiliary::{Auxiliary, auxiliary};

use crate::film::{ALPHA, BadValues, Extras, Film, FilterSampler, FixedPoint, PixelSums, SpectralBins};
use crate::integrator::{self, Seen};
use crate::sampling::{Sampler, SamplerKind, Stream, mix};
use crate::scene::Scene;
use crate::spectrum::colour::MITSUBA_Y_INTEGRAL;
use crate::spectrum::{Sampled, Wavelengths};
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

/// How the samples of a pixel are dealt into replicates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Schedule {
    pub replicates: u32,
    pub samples_per_replicate: u32,
}

impl Schedule {
    /// Deals `samples` per pixel, or the next larger number that can be dealt, into replicates of equal length.
    ///
    /// More replicates tell the error more surely, longer ones are better stratified: about eight is a compromise. Where
    /// the number allows, replicates are powers of two long, as the Sobol sampler likes best.
    pub fn new(samples: u32) -> Self {
        let samples = samples.max(1);
        if samples < 8 {
            return Self { replicates: samples, samples_per_replicate: 1 };
        }
        (samples..=u32::MAX)
            .find_map(|total| {
                let fitting = (4..=16).filter(|replicates| total % replicates == 0);
                let best = fitting.min_by_key(|&replicates| {
                    let length = total / replicates;
                    (!length.is_power_of_two(), replicates.abs_diff(8), replicates)
                })?;
                Some(Self { replicates: best, samples_per_replicate: total / best })
            })
            .unwrap_or(Self { replicates: samples, samples_per_replicate: 1 })
    }

    /// Deals `samples` per pixel, or the next larger number that can be dealt, into so many replicates. One is best stratified
    /// and has no error bars.
    pub fn with_replicates(samples: u32, replicates: u32) -> Self {
        let replicates = replicates.max(1);
        Self { replicates, samples_per_replicate: samples.max(1).div_ceil(replicates) }
    }

    /// Deals `samples` per pixel as a sampler allows. Where nothing is random they are one sequence, and there are no error bars.
    pub fn of(sampler: SamplerKind, samples: u32) -> Self {
        if sampler.is_random() {
            Self::new(samples)
        } else {
            Self { replicates: 1, samples_per_replicate: samples.max(1) }
        }
    }

    pub fn samples(self) -> u64 {
        u64::from(self.replicates) * u64::from(self.samples_per_replicate)
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

/// Edge of a tile, pixels.
const TILE: u32 = 16;

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
    let [width, height] = scene.film.size;
    let schedule = settings.schedule();
    let film = Film::new(
        width,
        height,
        schedule.replicates,
        settings.extras(scene),
        FixedPoint::for_reference(scene.reference_radiance),
    );
    let exposure = Exposure {
        scene,
        schedule,
        sampler: Sampler::new(settings.sampler, settings.seed, schedule.samples_per_replicate),
        seed: settings.seed,
        filter: scene.filter_sampler(),
        scale: film.scale(),
        square_scale: film.square_scale(),
        empty: film.pixel_sums(),
        empty_light: film.light_sums(),
        light_scale: film.light_scale(),
        extras: film.extras.clone(),
    };
    let tiles: Vec<[u32; 2]> = (0..height.div_ceil(TILE))
        .flat_map(|y| (0..width.div_ceil(TILE)).map(move |x| [x * TILE, y * TILE]))
        .collect();
    let film = Mutex::new(film);
    let light = scene.caustics().map(|caustics| LightPass::new(caustics, &exposure, settings.sampler));
    for pass in passes(schedule.samples_per_replicate) {
        if let Some(light) = &light {
            light.expose::<C>(&pass, &film, watch);
        }
        // Tile by tile: what a thread has taken no other can take over, and tiles differ.
        tiles.par_iter().with_max_len(1).for_each(|&[left, top]| {
            if watch.stop().load(Ordering::Relaxed) {
                return;
            }
            let pixels = (top..(top + TILE).min(height))
                .flat_map(|y| (left..(left + TILE).min(width)).map(move |x| [x, y]));
            let mut bad = BadValues::default();
            let exposed: Vec<_> =
                pixels.map(|pixel| (pixel, exposure.pixel::<C>(pixel, pass.clone(), &mut bad))).collect();
            let mut film = lock(&film);
            for ([x, y], sums) in &exposed {
                film.add(*x, *y, sums);
            }
            film.bad.add(bad);
            drop(film);
            let samples = u64::from(schedule.replicates) * pass.len() as u64;
            watch.advanced(exposed.len() as u64 * samples);
        });
        if watch.stop().load(Ordering::Relaxed) {
            break;
        }
        watch.pass_done(&lock(&film));
    }
    film.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner)
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

struct Exposure<'a> {
    scene: &'a Scene,
    schedule: Schedule,
    sampler: Sampler,
    seed: u64,
    filter: FilterSampler,
    scale: FixedPoint,
    square_scale: FixedPoint,
    empty: PixelSums,
    /// Of one replicate.
    empty_light: PixelSums,
    light_scale: FixedPoint,
    extras: Extras,
}

impl Exposure<'_> {
    /// Some samples of every replicate of one pixel.
    fn pixel<const C: usize>(&self, pixel: [u32; 2], indices: Range<u32>, bad: &mut BadValues) -> PixelSums {
        let mut sums = self.empty.clone();
        let [x, y] = pixel.map(u64::from);
        let of_pixel = mix(self.seed ^ mix(x << 32 | y));
        for replicate in 0..self.schedule.replicates {
            for index in indices.clone() {
                sums.begin(of_pixel ^ (u64::from(replicate) << 32 | u64::from(index)));
                let stream = self.sampler.stream(pixel, replicate, index);
                self.sample::<C>(pixel, replicate, &stream, &mut sums, bad);
            }
        }
        sums.count(indices.len() as u32);
        sums
    }

    fn sample<const C: usize>(
        &self,
        pixel: [u32; 2],
        replicate: u32,
        stream: &Stream,
        sums: &mut PixelSums,
        bad: &mut BadValues,
    ) {
        let scene = self.scene;
        let Some(sample) = scene.camera_ray(&self.filter, pixel, stream) else { return };
        let wavelengths = scene.wavelengths.sample::<C>(sample.wavelength);
        let Seen { mut radiance, met } =
            integrator::radiance(scene, sample.sensor.ray, sample.time, &wavelengths, stream);
        if self.extras.alpha {
            let weight = sample.filter_weight;
            for (channel, weight) in ALPHA.into_iter().zip([if met { weight } else { 0.0 }, weight]) {
                sums.add(replicate, channel, weight, FixedPoint::SHARE, bad);
            }
        }
        if let Some(response) = sample.sensor.response {
            radiance *= response.sample(&wavelengths.nm);
        }
        admit(&mut radiance, bad);
        let weight = sample.filter_weight * sample.sensor.weight;
        let xyz = self.record(replicate, &(radiance * weight), &wavelengths, self.scale, sums, bad);
        if self.extras.moments {
            // The filter weighs the square as it weighs the sample itself, once.
            let factor = if sample.filter_weight == 0.0 { 0.0 } else { 1.0 / sample.filter_weight };
            for (of, value) in xyz.into_iter().enumerate() {
                let channel = self.extras.moment_channel(of);
                sums.add(replicate, channel, value * value * factor, self.square_scale, bad);
            }
        }
    }

    /// Adds what a path measured to all channels of a replicate. Its X, Y and Z.
    fn record<const C: usize>(
        &self,
        replicate: u32,
        measured: &Sampled<C>,
        wavelengths: &Wavelengths<C>,
        scale: FixedPoint,
        sums: &mut PixelSums,
        bad: &mut BadValues,
    ) -> [f64; 3] {
        let scene = self.scene;
        let mut xyz = [0.0; 3];
        for lane in 0..C {
            if measured[lane] == 0.0 {
                continue;
            }
            let nm = wavelengths.nm[lane];
            let weight = measured[lane] / wavelengths.density[lane];
            let response = scene.observer.at(nm);
            for channel in 0..3 {
                xyz[channel] += weight * response[channel];
            }
            for (index, channel) in scene.film.channels.iter().enumerate() {
                let value = weight * channel.response.at(nm) / channel.integral;
                sums.add(replicate, self.extras.response_channel(index), value, scale, bad);
            }
            if let Some(bins) = &self.extras.bins
                && let Some(bin) = bins.of(nm)
            {
                sums.add(replicate, self.extras.bin_channel(bin), weight / bins.width(), scale, bad);
            }
        }
        let xyz = xyz.map(|value| value / MITSUBA_Y_INTEGRAL);
        for (channel, value) in xyz.into_iter().enumerate() {
            sums.add(replicate, channel, value, scale, bad);
        }
        xyz
    }
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

    #[test]
    fn samples_are_dealt_into_replicates_of_equal_length() {
        let dealt = |samples| {
            let schedule = Schedule::new(samples);
            (schedule.replicates, schedule.samples_per_replicate)
        };
        assert_eq!(dealt(1), (1, 1));
        assert_eq!(dealt(4), (4, 1));
        assert_eq!(dealt(64), (8, 8));
        assert_eq!(dealt(1024), (8, 128));
        assert_eq!(dealt(96), (6, 16));
        assert_eq!(dealt(100), (10, 10));
        // No prime can be dealt: the next number that can.
        assert_eq!(dealt(101), (6, 17));
        // As many as are asked for, and the next number of samples that allows it.
        assert_eq!(Schedule::with_replicates(64, 1), Schedule { replicates: 1, samples_per_replicate: 64 });
        assert_eq!(Schedule::with_replicates(30, 4), Schedule { replicates: 4, samples_per_replicate: 8 });
        assert_eq!(Schedule::with_replicates(2, 8), Schedule { replicates: 8, samples_per_replicate: 1 });
        for samples in 8..2000 {
            assert!(Schedule::new(samples).samples() - u64::from(samples) < 8, "{samples}");
        }
    }
}
