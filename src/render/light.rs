//! The light subpaths of a render: what they bring to the film beside the pixels' own samples.

use super::exposure::Contributions;
use super::work::Pass;
use super::{Exposure, Progress, admit};
use crate::film::{BadValues, Film, FilterSampler, Taken};
use crate::integrator::{self, Splat};
use crate::light::LightTracing;
use crate::sampling::{Sampler, SamplerKind, mix};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::Ordering;

/// Light subpaths that are made in one go.
const CHUNK: u64 = 4096;

/// Stands for a pixel in the sample values of light subpaths. No film is that large.
const NO_PIXEL: u32 = u32::MAX;

/// Takes what a piece of a pass, by its number, brings to the film.
type Add<'a> = dyn Fn(usize, &dyn Fn(&mut Film)) + Sync + 'a;

/// A pixel, and what came to which of its channels.
type Splatted = ([u32; 2], Taken);

pub(super) struct LightPass<'a> {
    light_tracing: &'a LightTracing,
    exposure: &'a Exposure<'a>,
    sampler: Sampler,
    filter: FilterSampler,
}

impl<'a> LightPass<'a> {
    pub fn new(light_tracing: &'a LightTracing, exposure: &'a Exposure<'a>, kind: SamplerKind) -> Self {
        // Light subpaths belong to no pixel: what only the others have to do with pixels, or with few
        // samples, is nothing for them.
        let (kind, seed) = match kind {
            SamplerKind::Independent => (kind, exposure.seed),
            // Nothing of it is to be random.
            SamplerKind::Regular => (SamplerKind::Sobol, 0),
            _ => (SamplerKind::Sobol, exposure.seed),
        };
        let schedule = exposure.schedule;
        let of_replicate =
            light_tracing.subpaths.count(schedule.samples_per_replicate, exposure.samples_per_path);
        let of_net = of_replicate * u64::from(schedule.per_net);
        let sampler = Sampler::new(kind, seed, u32::try_from(of_net).unwrap_or(u32::MAX));
        let Exposure { extent, filter, .. } = exposure;
        let filter = FilterSampler::new(*filter, extent.window, exposure.scene.film.sample_border);
        Self { light_tracing, exposure, sampler, filter }
    }

    fn paths(&self, samples: u32) -> u64 {
        self.light_tracing.subpaths.count(samples, self.exposure.samples_per_path)
    }

    /// The light subpaths that belong to the samples of a pass. They come to the film in pieces, of which
    /// `add` is told the number: how many there are in all.
    pub fn expose<const C: usize>(&self, pass: &Pass, add: &Add, progress: &dyn Progress) -> usize {
        let of_replicate = |replicate: u32| {
            let indices = pass.indices(replicate);
            let [first, end] = [indices.start, indices.end].map(|samples| self.paths(samples));
            let chunk = move |start: u64| (replicate, start..(start + CHUNK).min(end));
            (first..end).step_by(CHUNK as usize).map(chunk)
        };
        let chunks: Vec<(u32, Range<u64>)> =
            (0..self.exposure.schedule.replicates).flat_map(of_replicate).collect();
        // One by one, as tiles are.
        chunks.par_iter().enumerate().with_max_len(1).for_each(|(piece, (replicate, range))| {
            if pass.is_done(piece) || progress.stop().load(Ordering::Relaxed) {
                return;
            }
            let mut bad = BadValues::default();
            let scene = self.exposure.scene;
            let exposed = scene.piece(|| self.chunk::<C>(*replicate, range.clone(), &mut bad));
            add(piece, &|film| {
                for (pixel, sums) in &exposed {
                    film.add_light(*pixel, *replicate, sums);
                }
                film.count_light(*replicate, range.end - range.start);
                film.bad.add(bad);
            });
        });
        chunks.len()
    }

    /// By pixel, the squares of what some light subpaths bring, each to the brightness of one pixel.
    pub fn squares<const C: usize>(&self, paths: u64, progress: &dyn Progress) -> Vec<([u32; 2], f64)> {
        let chunks: Vec<u64> = (0..paths).step_by(CHUNK as usize).collect();
        let Exposure { scene, extras, light_scale, .. } = self.exposure;
        let of_chunk = |&start: &u64| {
            if progress.stop().load(Ordering::Relaxed) {
                return Vec::new();
            }
            let range = start..(start + CHUNK).min(paths);
            let splats = scene.piece(|| self.chunk::<C>(0, range, &mut BadValues::default()));
            let square = |(pixel, sums): Splatted| (pixel, extras.brightness(&sums, *light_scale).powi(2));
            splats.into_iter().map(square).collect()
        };
        chunks.par_iter().with_max_len(1).flat_map_iter(of_chunk).collect()
    }

    fn chunk<const C: usize>(&self, replicate: u32, range: Range<u64>, bad: &mut BadValues) -> Vec<Splatted> {
        let Exposure { scene, seed, light_scale, plan, .. } = *self.exposure;
        let Self { filter, .. } = self;
        let mut sums = self.exposure.extras.tile([0, 0], [1, 1], 0..1);
        let mut exposed = Vec::new();
        let schedule = self.exposure.schedule;
        let (net, run) = (replicate / schedule.per_net, replicate % schedule.per_net);
        let first = u64::from(run) * self.paths(schedule.samples_per_replicate);
        for index in range.start + first..range.end + first {
            // Beyond what a sequence holds another begins.
            let (sequence, within) = ((index >> 32) as u32, index as u32);
            let stream = self.sampler.stream([NO_PIXEL, sequence], net, within);
            let mut of_path = mix(seed ^ mix(index ^ u64::from(net) << 48));
            integrator::light_subpath::<C>(scene, self.light_tracing, plan, &stream, &mut |splat| {
                let Splat { film: place, mut radiance, wavelengths, response } = splat;
                if let Some(response) = response {
                    radiance *= response.sample(&wavelengths.nm);
                }
                admit(&mut radiance, bad);
                let Contributions { xyz, others } = self.exposure.contributions(
                    &radiance,
                    &wavelengths,
                    &self.exposure.responses(&wavelengths),
                );
                filter.footprint(place).for_each(|[column, row], fraction| {
                    let (Ok(x), Ok(y)) = (u32::try_from(column), u32::try_from(row)) else { return };
                    if let Some(measured) = self.exposure.extent.measured.within([x, y])
                        && fraction != 0.0
                    {
                        sums.begin(of_path, [column, row]);
                        for (channel, value) in (0..).zip(xyz).chain(others.iter().copied()) {
                            sums.add(0, 0, channel, value * fraction, light_scale);
                        }
                        exposed.push((measured, sums.take()));
                    }
                });
                // The next surface of the path rounds for itself.
                of_path = mix(of_path);
            });
        }
        bad.add(sums.bad);
        exposed
    }
}
