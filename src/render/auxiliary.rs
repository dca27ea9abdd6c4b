//! Images of what the camera sees first, beside the picture: for denoisers and for understanding a scene.

use crate::film::FilterSampler;
use crate::sampling::{Dimensions, Sampler, SamplerKind};
use crate::scene::Scene;
use crate::spectrum::colour::{MITSUBA_Y_INTEGRAL, Xyz, xyz_to_rec709};
use crate::spectrum::{Response, Sampled, WavelengthDensity};
use crate::units::WavelengthRange;
use rayon::prelude::*;

/// What an auxiliary image shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AuxiliaryKind {
    /// What the surface would scatter of light from everywhere, linear Rec. 709 under equal-energy light.
    Albedo,
    /// Shading normal in world space.
    Normal,
    /// Distance from the camera's near plane along the ray, in scene units; infinite where there is nothing.
    Depth,
}

impl AuxiliaryKind {
    pub const NAMES: [(&str, Self); 3] =
        [("albedo", Self::Albedo), ("normal", Self::Normal), ("depth", Self::Depth)];

    pub fn named(name: &str) -> Option<Self> {
        Self::NAMES.iter().find(|(known, _)| *known == name).map(|&(_, kind)| kind)
    }

    fn channels(self) -> &'static [&'static str] {
        match self {
            Self::Albedo => &["albedo.R", "albedo.G", "albedo.B"],
            Self::Normal => &["normal.X", "normal.Y", "normal.Z"],
            Self::Depth => &["depth"],
        }
    }
}

/// An image beside the picture, such as depth: one value a pixel.
#[derive(Clone, Debug)]
pub struct Auxiliary {
    pub name: &'static str,
    pub values: Vec<f32>,
}

/// Camera rays a pixel: these images need no more.
const SAMPLES: u32 = 16;

/// A sequence of sample values that no replicate of the picture uses.
const SEQUENCE: u32 = u32::MAX;

/// Renders auxiliary images, on the current rayon thread pool.
pub fn auxiliary(
    scene: &Scene,
    kinds: &[AuxiliaryKind],
    range: WavelengthRange,
    seed: u64,
) -> Vec<Auxiliary> {
    let shown: Vec<[u32; 2]> = scene.film.extent.shown.pixels().collect();
    let filter = scene.filter_sampler();
    let wavelengths = WavelengthDensity::new(
        range,
        &scene.observer.spectra().each_ref().map(|spectrum| Response { spectrum, weight: 1.0 }),
        &[],
    );
    let sampler = Sampler::new(SamplerKind::Sobol, seed, SAMPLES);
    let mut images = Vec::new();
    for &kind in kinds {
        let pixels: Vec<[f64; 3]> =
            shown.par_iter().map(|&at| pixel(scene, kind, &filter, &wavelengths, at, &sampler)).collect();
        for (channel, name) in kind.channels().iter().enumerate() {
            images.push(Auxiliary { name, values: pixels.iter().map(|p| p[channel] as f32).collect() });
        }
    }
    images
}

fn pixel(
    scene: &Scene,
    kind: AuxiliaryKind,
    filter: &FilterSampler,
    wavelengths: &WavelengthDensity,
    pixel: [u32; 2],
    sampler: &Sampler,
) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for index in 0..SAMPLES {
        let stream = sampler.stream(pixel, SEQUENCE, index);
        let Some(sample) = scene.camera_ray(filter, pixel, &stream) else { continue };
        let (ray, weight) = (sample.sensor.ray, sample.filter_weight);
        let path = wavelengths.sample::<8>(sample.wavelength);
        let mut media = scene.media_at_sensor(&ray, sample.time);
        let hit = scene.intersect(&ray, sample.time, true, &mut media, |_, _| {});
        let value = match (kind, hit) {
            (AuxiliaryKind::Depth, hit) => [hit.map_or(f64::INFINITY, |hit| hit.t), 0.0, 0.0],
            (_, None) => [0.0; 3],
            (AuxiliaryKind::Normal, Some(hit)) => {
                let [.., choice] = stream.draw(Dimensions::Light(0));
                scene.shade(&hit, -ray.direction, &media, &path, choice).frame.z.into()
            }
            (AuxiliaryKind::Albedo, Some(hit)) => {
                let [.., choice] = stream.draw(Dimensions::Light(0));
                let shading = scene.shade(&hit, -ray.direction, &media, &path, choice);
                let [u, v, lobe, _] = stream.draw(Dimensions::Scattering(0));
                let scattered = shading.sample(lobe, [u, v]);
                let albedo = scattered.map_or(Sampled::ZERO, |s| s.weight / s.ratio.sum());
                let mut xyz = [0.0; 3];
                for lane in 0..8 {
                    let response = scene.observer.at(path.nm[lane]);
                    for (sum, response) in xyz.iter_mut().zip(response) {
                        *sum += response * albedo[lane] / path.density[lane] / MITSUBA_Y_INTEGRAL;
                    }
                }
                xyz_to_rec709(Xyz::from(xyz))
            }
        };
        for (sum, value) in sum.iter_mut().zip(value) {
            *sum += weight * value / f64::from(SAMPLES);
        }
    }
    sum
}
