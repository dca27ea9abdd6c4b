//! The study of noise: how the error of a picture falls with samples and with time, for each sampler.
//!
//! A *run* renders one scene with one sampler, one estimator, one number of samples per pixel and one number
//! of wavelengths per path, in R independent replicates. By the plain estimator each replicate has one
//! sequence of samples in each pixel; by the shared one it is a picture as `abbe render` makes it, pilots
//! included. The spread of the replicates tells how well the error itself is known. Every run has its own
//! seed: runs are independent of one another, whatever else is in the study.
//!
//! The error is relMSE of the luminance Y against a reference (see [`Reference`]), from which the reference's
//! own error has been subtracted. Slopes are fitted by least squares on logarithms (see [`fit`]).

pub mod fit;
mod folder;
mod measure;
/// The picture that runs are compared with.
pub mod reference;
pub mod report;
mod spectra;

pub use folder::{Folder, ForeignStudy};
pub use measure::measure;
pub use reference::{Reference, ReferenceError};
pub use spectra::{Radial, Spectrum};

use crate::integrator::Estimator;
use crate::render::WavelengthCount;
use crate::sampling::{SamplerKind, mix};
use crate::scene::Scene;
use serde::{Deserialize, Serialize};

/// A scene with values for its parameters.
pub struct Case {
    /// What it is called.
    pub id: CaseId,
    /// The compiled scene.
    pub scene: Scene,
}

/// What a case is called, and what tells it from others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CaseId {
    /// Name and value of each parameter that was given.
    pub parameters: Vec<(String, String)>,
    /// Hash of what the scene means.
    pub scene_hash: String,
}

impl CaseId {
    /// `radius = 0.2, depth = 4`, of the named parameters.
    pub fn label(&self, varied: &[String]) -> String {
        let told = self.parameters.iter().filter(|(name, _)| varied.contains(name));
        told.map(|(name, value)| format!("{name} = {value}")).collect::<Vec<_>>().join(", ")
    }
}

/// What a study is asked for: all that its numbers depend on, and the number of threads, on which CPU times
/// depend.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Request {
    /// Version of abbe.
    pub version: String,
    /// Scenes with their parameters.
    pub cases: Vec<CaseId>,
    /// The samplers that are compared.
    pub samplers: Vec<SamplerKind>,
    /// The estimators that each sampler is used with.
    pub estimators: Vec<Estimator>,
    /// Samples of a pixel, of each run.
    pub samples_per_pixel: Vec<u32>,
    /// Wavelengths that a path carries.
    pub wavelengths_per_path: Vec<WavelengthCount>,
    /// Independent renders of each run.
    pub replicates: u32,
    /// Pixels.
    pub size: [u32; 2],
    /// Where in the film the picture begins.
    pub offset: [u32; 2],
    /// Seed of the first replicate.
    pub seed: u64,
    /// Where the reference comes from.
    pub reference: ReferenceRequest,
    /// Threads to render with.
    pub threads: u32,
}

/// Where the reference comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ReferenceRequest {
    /// A file, with a hash of its values.
    File {
        /// Its path.
        path: String,
        /// Hash of its values, hexadecimal.
        hash: String,
    },
    /// The study's own, with so many samples per pixel in all.
    Rendered {
        /// Samples of each pixel.
        samples_per_pixel: u32,
    },
}

/// Which run of a study.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RunId {
    /// Counted from 0.
    pub case: usize,
    /// The sampler.
    pub sampler: SamplerKind,
    /// The estimator.
    pub estimator: Estimator,
    /// Samples of each pixel.
    pub samples_per_pixel: u32,
    /// Wavelengths that a path carries.
    pub wavelengths_per_path: WavelengthCount,
}

impl RunId {
    /// What plots and files call it.
    pub fn name(&self) -> String {
        let Self { case, sampler, estimator, samples_per_pixel, wavelengths_per_path } = self;
        format!("case{case}-{sampler}-{estimator}-c{wavelengths_per_path}-{samples_per_pixel}spp")
    }
}

/// What a run has found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Which run it is.
    pub id: RunId,
    /// relMSE of each replicate, less the error of the reference.
    pub relmse: Vec<f64>,
    /// CPU time of one replicate, s: user and system time of all threads over the number of replicates.
    pub cpu_seconds: f64,
    /// Not used, because not finite, negative or too large.
    pub bad_values: u64,
    /// Power spectrum of the image error.
    pub spectrum: Spectrum,
}

impl Run {
    /// Mean relMSE with its standard error.
    pub fn error(&self) -> crate::stats::Estimate {
        self.relmse.iter().copied().collect::<crate::stats::Moments>().estimate()
    }

    /// 1/(relMSE × CPU seconds), s⁻¹.
    pub fn efficiency(&self) -> f64 {
        1.0 / (self.error().mean * self.cpu_seconds)
    }
}

impl Request {
    /// All runs, the short ones first: an interrupted study has something of every sampler.
    pub fn runs(&self) -> Vec<RunId> {
        let mut runs = Vec::new();
        for &samples_per_pixel in &self.samples_per_pixel {
            for case in 0..self.cases.len() {
                for (estimator, wavelengths_per_path) in self.techniques() {
                    for &sampler in &self.samplers {
                        runs.push(RunId {
                            case,
                            sampler,
                            estimator,
                            samples_per_pixel,
                            wavelengths_per_path,
                        });
                    }
                }
            }
        }
        runs
    }

    /// What each sampler is used with: an estimator and a number of wavelengths.
    fn techniques(&self) -> impl Iterator<Item = (Estimator, WavelengthCount)> {
        let with =
            |&estimator| self.wavelengths_per_path.iter().map(move |&wavelengths| (estimator, wavelengths));
        self.estimators.iter().flat_map(with)
    }

    /// Replicates that a run has: a sampler without chance has but one.
    pub fn replicates_of(&self, sampler: SamplerKind) -> u32 {
        if sampler.is_random() { self.replicates } else { 1 }
    }

    /// The number of samples that pictures and spectra are shown for: that of the list which is nearest
    /// to 64.
    pub fn shown_samples(&self) -> u32 {
        let far = |samples: &&u32| (f64::from(**samples) / 64.0).ln().abs();
        self.samples_per_pixel.iter().min_by(|a, b| far(a).total_cmp(&far(b))).copied().unwrap_or(64)
    }

    /// Names of the parameters that differ between cases.
    pub fn varied(&self) -> Vec<String> {
        let first = self.cases.first().map_or(&[][..], |case| &case.parameters);
        let differs = |name: &str, value: &str| {
            self.cases.iter().any(|case| case.parameters.iter().any(|(n, v)| n == name && v != value))
        };
        first.iter().filter(|(name, value)| differs(name, value)).map(|(name, _)| name.clone()).collect()
    }
}

/// What a seed is used for: seeds of different purposes are independent.
#[derive(Clone, Copy)]
enum Purpose {
    Reference = 1,
    Run = 2,
    EqualTime = 3,
    Pattern = 4,
}

/// A seed of its own for each purpose and use, from the study's.
fn derived_seed(seed: u64, purpose: Purpose, words: impl IntoIterator<Item = u64>) -> u64 {
    words.into_iter().fold(mix(seed ^ mix(purpose as u64)), |hash, word| mix(hash ^ mix(word)))
}

/// Seed of a run and its batch of replicates.
fn seed_of_run(seed: u64, purpose: Purpose, id: &RunId, batch: u64) -> u64 {
    let names = id.sampler.name().bytes().chain(id.estimator.name().bytes()).map(u64::from);
    let numbers = [id.case as u64, id.samples_per_pixel.into(), id.wavelengths_per_path.get() as u64, batch];
    derived_seed(seed, purpose, names.chain(numbers))
}
