//! Images of what the camera sees first, beside the picture: for denoisers and for understanding a scene.

use super::Schedule;
use crate::accel::Tests;
use crate::camera::SensorRay;
use crate::film::FilterSampler;
use crate::geometry::Vec3;
use crate::integrator;
use crate::medium::Media;
use crate::sampling::{Dimensions, Sampler, SamplerKind, Stream};
use crate::scene::description::{Aov, AovKind};
use crate::scene::{CameraSample, Intersection, RayKind, Scene};
use crate::spectrum::catalogue;
use crate::spectrum::colour::{Observer, Xyz, rec709_to_xyz, xyz_to_rec709};
use crate::spectrum::{Sampled, Spectrum, Wavelengths};
use crate::units::WavelengthRange;
use rayon::prelude::*;

/// A channel of an image beside the picture, such as depth: one value for each pixel that is
/// measured, row by row from the top.
#[derive(Clone, Debug)]
pub struct Auxiliary {
    /// Name of the channel.
    pub name: String,
    /// A value for each pixel, by rows.
    pub values: Vec<f32>,
    /// One standard error of each. `None` where there are no replicates, and for numbers that are no means.
    pub errors: Option<Vec<f32>>,
}

/// Camera rays of a pixel, however many samples the picture has: these images have little noise, and
/// replicates need some to be alike.
const FEWEST: u32 = 16;
const MOST: u32 = 256;

/// The last of the sequences of sample values; the picture's replicates are the first.
const LAST_SEQUENCE: u32 = u32::MAX;

/// Renders images beside a picture of some schedule, on the current rayon thread pool.
///
/// Values are means over the pixel's part of the reconstruction filter, whose negative lobes count as
/// positive ones: a mean of unit normals is no longer than 1 then, and shorter where they differ. Of indices
/// it is the one that is met most often.
pub fn auxiliary(
    scene: &Scene,
    aovs: &[Aov],
    range: WavelengthRange,
    schedule: Schedule,
    seed: u64,
) -> Vec<Auxiliary> {
    let replicates = schedule.replicates.max(1);
    let [fewest, most] = [FEWEST.div_ceil(replicates), (MOST / replicates).max(1)];
    let samples = schedule.samples_per_replicate.clamp(fewest, most);
    let images = Images {
        scene,
        aovs,
        filter: scene.filter_sampler(),
        white: White::new(scene.observer, range),
        sampler: Sampler::new(SamplerKind::Sobol, seed, samples),
        schedule: Schedule::independent(replicates, samples),
    };
    let names: Vec<(String, AovKind)> =
        aovs.iter().flat_map(|aov| aov.channels().map(|name| (name, aov.kind))).collect();
    let measured: Vec<[u32; 2]> = scene.film.extent.measured.pixels().collect();
    let pixels: Vec<Vec<[f32; 2]>> = match aovs {
        [] => Vec::new(),
        _ => measured.par_iter().map(|&pixel| images.pixel(pixel)).collect(),
    };
    let channel = |(channel, (name, kind)): (usize, (String, AovKind))| Auxiliary {
        name,
        values: pixels.iter().map(|pixel| pixel[channel][0]).collect(),
        errors: (replicates > 1 && !kind.is_index())
            .then(|| pixels.iter().map(|pixel| pixel[channel][1]).collect()),
    };
    names.into_iter().enumerate().map(channel).collect()
}

struct Images<'a> {
    scene: &'a Scene,
    aovs: &'a [Aov],
    filter: FilterSampler,
    white: White,
    sampler: Sampler,
    schedule: Schedule,
}

impl Images<'_> {
    /// For each channel its value and one standard error.
    fn pixel(&self, pixel: [u32; 2]) -> Vec<[f32; 2]> {
        let Schedule { replicates, samples_per_replicate, .. } = self.schedule;
        let channels: Vec<AovKind> =
            self.aovs.iter().flat_map(|aov| aov.kind.channels().iter().map(|_| aov.kind)).collect();
        let mut means = vec![vec![0.0; replicates as usize]; channels.len()];
        let mut indices: Vec<Vec<f64>> = vec![Vec::new(); channels.len()];
        let mut values = Vec::new();
        for replicate in 0..replicates {
            for index in 0..samples_per_replicate {
                let stream = self.sampler.stream(pixel, LAST_SEQUENCE - replicate, index);
                values.clear();
                self.sample(pixel, &stream, &mut values);
                values.resize(channels.len(), 0.0);
                for (channel, &value) in values.iter().enumerate() {
                    match channels[channel].is_index() {
                        true => indices[channel].push(value),
                        false => {
                            means[channel][replicate as usize] += value / f64::from(samples_per_replicate);
                        }
                    }
                }
            }
        }
        let of_channel = |(means, indices): (Vec<f64>, Vec<f64>)| match indices[..] {
            [] => mean_and_error(&means).map(|value| value as f32),
            _ => [most_frequent(indices) as f32, 0.0],
        };
        means.into_iter().zip(indices).map(of_channel).collect()
    }

    /// Puts what one ray sees into `values`, channel by channel; nothing where it sees nothing.
    fn sample(&self, pixel: [u32; 2], stream: &Stream, values: &mut Vec<f64>) {
        let scene = self.scene;
        let Some(sample) = scene.camera_ray(&self.filter, pixel, stream) else { return };
        let (ray, time) = (sample.sensor.ray, sample.time);
        // First, for it is known where the ray meets nothing, too.
        let wants_cost = self.aovs.iter().any(|aov| aov.kind == AovKind::Cost);
        let cost = if wants_cost { self.cost(&sample, stream) } else { 0.0 };
        let mut media = scene.media_at_sensor(&ray, time);
        let Some(hit) = scene.intersect(&ray, time, RayKind::Camera, &mut media, |_, _| {}) else {
            for aov in self.aovs {
                let value = if aov.kind == AovKind::Cost { cost } else { 0.0 };
                values.extend(aov.kind.channels().iter().map(|_| value));
            }
            return;
        };
        let first = FirstHit { scene, hit: &hit, toward_eye: -ray.direction, media: &media, stream };
        for aov in self.aovs {
            match aov.kind {
                // Where wavelengths part at a surface they are asked one by one.
                AovKind::Albedo if scene.features().dispersion => {
                    values.extend(first.albedo::<1>(&self.white))
                }
                AovKind::Albedo => values.extend(first.albedo::<8>(&self.white)),
                AovKind::Depth => values.push(hit.t),
                AovKind::Position => values.extend(scene.in_file(hit.point.position).to_array()),
                AovKind::Uv => values.extend(scene.coordinates(&hit).uv),
                AovKind::GeometricNormal => values.extend(hit.point.normal.to_array()),
                AovKind::ShadingNormal => values.extend(first.normal().to_array()),
                AovKind::AlongU => values.extend(scene.coordinates(&hit).tangent.to_array()),
                AovKind::AlongV => values.extend(scene.coordinates(&hit).bitangent.to_array()),
                AovKind::PrimitiveIndex => values.push(f64::from(scene.primitive_number(&hit))),
                AovKind::ShapeIndex => values.push(f64::from(scene.shape_number(&hit))),
                AovKind::MaterialIndex => values.push(f64::from(scene.material_number(&hit))),
                AovKind::Cost => values.push(cost),
            }
        }
    }
}

impl Images<'_> {
    /// See [`AovKind::Cost`]. Zero in a scene that does not count.
    fn cost(&self, sample: &CameraSample, stream: &Stream) -> f64 {
        let Some(counters) = self.scene.counters() else { return 0.0 };
        let counted = || {
            let Tests { nodes, packets, surfaces, .. } = counters.of_this_thread().tests();
            nodes + packets + surfaces
        };
        let before = counted();
        let wavelengths = self.scene.wavelengths.sample::<4>(sample.wavelength);
        let SensorRay { ray, lit, .. } = sample.sensor;
        integrator::radiance(self.scene, ray, lit, sample.time, &wavelengths, stream);
        (counted() - before) as f64
    }
}

/// The mean of the replicates and its standard error, infinite for a single one.
fn mean_and_error(means: &[f64]) -> [f64; 2] {
    let count = means.len() as f64;
    let mean = means.iter().sum::<f64>() / count;
    let spread: f64 = means.iter().map(|of_one| (of_one - mean).powi(2)).sum();
    [mean, if means.len() < 2 { f64::INFINITY } else { (spread / (count * (count - 1.0))).sqrt() }]
}

/// The most frequent value; the least among equally frequent ones.
fn most_frequent(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let runs = values.chunk_by(|a, b| a == b);
    runs.fold((0, 0.0), |best, run| if run.len() > best.0 { (run.len(), run[0]) } else { best }).1
}

/// First hit of a camera ray.
struct FirstHit<'a> {
    scene: &'a Scene,
    hit: &'a Intersection,
    toward_eye: Vec3,
    media: &'a Media,
    stream: &'a Stream<'a>,
}

impl FirstHit<'_> {
    /// What chooses between the materials of the surface.
    fn choice(&self) -> f64 {
        let [.., choice] = self.stream.draw(Dimensions::Light(0));
        choice
    }

    /// The normal that the material is seen with.
    fn normal(&self) -> Vec3 {
        let wavelengths = Wavelengths::<1> { nm: [550.0], density: Sampled::ONE };
        self.scene.shade(self.hit, self.toward_eye, self.media, &wavelengths, self.choice()).normal()
    }

    /// The colour of the fraction of light from all around that is sent toward the eye, `C` wavelengths at a
    /// time, of which each is the hero in its turn.
    fn albedo<const C: usize>(&self, white: &White) -> [f64; 3] {
        let [u, v, lobe, turn] = self.stream.draw(Dimensions::Scattering(0));
        let turn = (turn * C as f64) as usize;
        let mut colour = [0.0; 3];
        for nodes in white.0.chunks_exact(C) {
            let node = |lane: usize| &nodes[(lane + turn) % C];
            let nm = std::array::from_fn(|lane| node(lane).nm);
            let wavelengths = Wavelengths::<C> { nm, density: Sampled::ONE };
            let shading =
                self.scene.shade(self.hit, self.toward_eye, self.media, &wavelengths, self.choice());
            let Some(scatter) = shading.sample(lobe, [u, v]) else { continue };
            // Radiance is compressed on its way into glass; of light nothing is lost.
            let index = shading.index_beyond().filter(|_| scatter.transmitted).unwrap_or(1.0);
            let fraction = scatter.weight * (index * index * C as f64 / scatter.ratio.sum());
            for lane in 0..C {
                for (sum, weight) in colour.iter_mut().zip(node(lane).weight) {
                    *sum += weight * fraction[lane];
                }
            }
        }
        colour
    }
}

/// Wavelengths of a quadrature that makes a colour out of a reflectance: linear Rec. 709 of what it makes of
/// D65. It is scaled so that a reflectance of 1 is 1, 1, 1 for any observer.
struct White(Vec<Node>);

struct Node {
    nm: f64,
    weight: [f64; 3],
}

impl White {
    /// 10 nm apart over what the eye sees, which is what reflectances are tabulated at.
    const NODES: usize = 40;
    const SEEN: WavelengthRange = WavelengthRange { min: 380.0, max: 780.0 };

    /// Over that part of `range` that is seen. Where it leaves too little of a colour, all wavelengths of the
    /// range weigh alike.
    fn new(observer: &Observer, range: WavelengthRange) -> Self {
        let daylight = catalogue::illuminant("D65").unwrap_or(Spectrum::ONE);
        let stimulus = |bin: WavelengthRange| -> [f64; 3] {
            const STEPS: usize = 10;
            let step = bin.width() / STEPS as f64;
            let mut sum = [0.0; 3];
            for nm in (0..STEPS).map(|i| bin.min + (i as f64 + 0.5) * step) {
                for (sum, response) in sum.iter_mut().zip(observer.at(nm)) {
                    *sum += response * daylight.at(nm) * step;
                }
            }
            sum
        };
        let bins = |range: WavelengthRange| {
            let edge = move |i: usize| range.min + range.width() * i as f64 / Self::NODES as f64;
            (0..Self::NODES).map(move |i| WavelengthRange { min: edge(i), max: edge(i + 1) })
        };
        let total = |range| {
            bins(range).map(stimulus).fold([0.0; 3], |sum, bin| std::array::from_fn(|i| sum[i] + bin[i]))
        };
        let seen = range.common(Self::SEEN);
        let (whole, part) = (total(Self::SEEN), if seen.min < seen.max { total(seen) } else { [0.0; 3] });
        let middle = |bin: WavelengthRange| 0.5 * (bin.min + bin.max);
        if part.iter().zip(whole).any(|(part, whole)| *part < 0.5 * whole) {
            let weight = [1.0 / Self::NODES as f64; 3];
            return Self(bins(range).map(|bin| Node { nm: middle(bin), weight }).collect());
        }
        let Xyz { x, y, z } = rec709_to_xyz([1.0; 3]);
        let node = |bin: WavelengthRange| {
            let of_bin = stimulus(bin);
            let xyz: [f64; 3] = std::array::from_fn(|i| of_bin[i] / part[i] * [x, y, z][i]);
            Node { nm: middle(bin), weight: xyz_to_rec709(Xyz::from(xyz)) }
        };
        Self(bins(seen).map(node).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn colour(white: &White, reflectance: impl Fn(f64) -> f64) -> [f64; 3] {
        std::array::from_fn(|i| white.0.iter().map(|node| node.weight[i] * reflectance(node.nm)).sum())
    }

    #[test]
    fn white_is_white_and_colours_are_those_of_daylight() {
        let range = WavelengthRange::VISIBLE;
        for observer in [Observer::cie1931(), Observer::cie1964()] {
            for part in [range, WavelengthRange { min: 400.0, max: 700.0 }] {
                for component in colour(&White::new(observer, part), |_| 1.0) {
                    assert!((component - 1.0).abs() < 1e-9, "{component}");
                }
            }
        }
        // Against the integrals in steps of 1 nm.
        let (white, observer) = (White::new(Observer::cie1931(), range), Observer::cie1931());
        let daylight = catalogue::illuminant("D65").unwrap();
        for name in ["colorchecker/red", "colorchecker/cyan", "colorchecker/yellow"] {
            let paint = catalogue::reflectance(name).unwrap();
            let exact = xyz_to_rec709(observer.reflected(&daylight, &paint, range));
            let found = colour(&white, |nm| paint.at(nm));
            for (found, exact) in found.into_iter().zip(exact) {
                assert!((found - exact).abs() < 2e-3, "{name}: {found} for {exact}");
            }
        }
        // Where nothing is seen there are no colours.
        let infrared = White::new(observer, WavelengthRange { min: 900.0, max: 1000.0 });
        assert!(colour(&infrared, |_| 0.25).iter().all(|value| (value - 0.25).abs() < 1e-12));
        assert!(infrared.0.iter().all(|node| node.nm > 900.0 && node.nm < 1000.0));
    }

    #[test]
    fn an_index_is_one_that_was_met() {
        assert_eq!(most_frequent(vec![3.0, 1.0, 3.0, 2.0]), 3.0);
        assert_eq!(most_frequent(vec![2.0, 7.0, 7.0, 2.0]), 2.0);
        assert_eq!(most_frequent(Vec::new()), 0.0);
        assert_eq!(mean_and_error(&[1.0, 3.0]), [2.0, 1.0]);
    }
}
