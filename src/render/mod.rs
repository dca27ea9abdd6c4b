//! From a compiled scene to an exposed film: pixels, threads, progress, interruption.

mod auxiliary;

pub use auxiliary::{Auxiliary, AuxiliaryKind, auxiliary};

use crate::film::{BadValues, Film, FilterSampler, FixedPoint, ReplicateSum, SpectralBins};
use crate::integrator;
use crate::sampling::{SamplerKind, Stream};
use crate::scene::Scene;
use crate::spectrum::colour::MITSUBA_Y_INTEGRAL;
use rayon::prelude::*;
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
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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

    pub fn samples(self) -> u64 {
        u64::from(self.replicates) * u64::from(self.samples_per_replicate)
    }
}

/// Whoever watches a render: told of progress, and able to end it.
pub trait Watch: Sync {
    /// Called after each tile of each replicate with the number of samples done so far.
    fn advanced(&self, samples: u64);

    /// Called when every pixel has one replicate more.
    fn replicate_done(&self, film: &Film);

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

    fn replicate_done(&self, _: &Film) {}

    fn stop(&self) -> &AtomicBool {
        &self.0
    }
}

/// Edge of a tile, pixels.
const TILE: u32 = 16;

/// Exposes a film to the scene, on the current rayon thread pool. The result depends on scene and settings alone, unless
/// it is stopped: then each pixel has the replicates that were finished.
pub fn render(scene: &Scene, settings: &Settings, watch: &dyn Watch) -> Film {
    match settings.wavelengths {
        WavelengthCount::One => expose::<1>(scene, settings, watch),
        WavelengthCount::Four => expose::<4>(scene, settings, watch),
        WavelengthCount::Eight => expose::<8>(scene, settings, watch),
    }
}

fn expose<const C: usize>(scene: &Scene, settings: &Settings, watch: &dyn Watch) -> Film {
    let [width, height] = scene.film.size;
    let film = Film::new(
        width,
        height,
        settings.schedule.samples_per_replicate,
        settings.bins,
        FixedPoint::for_reference(scene.reference_radiance),
    );
    let exposure = Exposure {
        scene,
        settings,
        filter: FilterSampler::new(scene.film.filter, width, height),
        channels: film.channels(),
        scale: film.scale(),
    };
    let tiles: Vec<[u32; 2]> = (0..height.div_ceil(TILE))
        .flat_map(|y| (0..width.div_ceil(TILE)).map(move |x| [x * TILE, y * TILE]))
        .collect();
    let film = Mutex::new(film);
    for replicate in 0..settings.schedule.replicates {
        tiles.par_iter().for_each(|&[left, top]| {
            if watch.stop().load(Ordering::Relaxed) {
                return;
            }
            let pixels = (top..(top + TILE).min(height))
                .flat_map(|y| (left..(left + TILE).min(width)).map(move |x| [x, y]));
            let mut bad = BadValues::default();
            let exposed: Vec<_> =
                pixels.map(|pixel| (pixel, exposure.pixel::<C>(pixel, replicate, &mut bad))).collect();
            let mut film = lock(&film);
            for ([x, y], sum) in &exposed {
                film.add(*x, *y, sum);
            }
            film.bad.add(bad);
            drop(film);
            watch.advanced(exposed.len() as u64 * u64::from(settings.schedule.samples_per_replicate));
        });
        if watch.stop().load(Ordering::Relaxed) {
            break;
        }
        watch.replicate_done(&lock(&film));
    }
    film.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// A film is whole between any two of its additions, so a poisoned lock is no reason to stop.
fn lock(film: &Mutex<Film>) -> std::sync::MutexGuard<'_, Film> {
    film.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

struct Exposure<'a> {
    scene: &'a Scene,
    settings: &'a Settings,
    filter: FilterSampler,
    channels: usize,
    scale: FixedPoint,
}

impl Exposure<'_> {
    /// One replicate of one pixel.
    fn pixel<const C: usize>(&self, pixel: [u32; 2], replicate: u32, bad: &mut BadValues) -> ReplicateSum {
        let mut sum = ReplicateSum::new(self.channels);
        for index in 0..self.settings.schedule.samples_per_replicate {
            let stream = Stream::new(self.settings.sampler, self.settings.seed, pixel, replicate, index);
            self.sample::<C>(pixel, &stream, &mut sum, bad);
        }
        sum
    }

    fn sample<const C: usize>(
        &self,
        pixel: [u32; 2],
        stream: &Stream,
        sum: &mut ReplicateSum,
        bad: &mut BadValues,
    ) {
        let scene = self.scene;
        let (ray, filter_weight, wavelength_u) = scene.camera_ray(&self.filter, pixel, stream);
        let wavelengths = scene.wavelengths.sample::<C>(wavelength_u);
        let radiance = integrator::radiance(scene, ray, &wavelengths, stream);
        let mut xyz = [0.0; 3];
        for lane in 0..C {
            if radiance[lane] == 0.0 || !bad.admits(radiance[lane]) {
                continue;
            }
            let nm = wavelengths.nm[lane];
            let weight = filter_weight * radiance[lane] / wavelengths.density[lane];
            let response = scene.observer.at(nm);
            for channel in 0..3 {
                xyz[channel] += weight * response[channel];
            }
            if let Some(bins) = &self.settings.bins
                && let Some(bin) = bins.of(nm)
            {
                sum.add(3 + bin, weight / bins.width(), self.scale);
            }
        }
        for (channel, value) in xyz.into_iter().enumerate() {
            sum.add(channel, value / MITSUBA_Y_INTEGRAL, self.scale);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        for samples in 8..2000 {
            assert!(Schedule::new(samples).samples() - u64::from(samples) < 8, "{samples}");
        }
    }
}
