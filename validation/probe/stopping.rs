use abbe::integrator::Estimator;
use abbe::output::target::{ErrorMeasure, Target};
use abbe::render::{Chosen, Progress, Schedule, Settings, WavelengthCount, Work, go_on};
use abbe::sampling::SamplerKind;
use abbe::scene::{CompileOptions, ReadOptions, compile, read};
use cpu_time::ProcessTime;
use serde::Deserialize;
use serde_json::{Value, json};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// What a render of each seed looks like whenever `abbe render --until` would decide.
#[derive(Deserialize)]
pub struct Question {
    scene: PathBuf,
    size: [u32; 2],
    /// Samples of a pixel at which a render ends.
    samples: u64,
    seeds: Vec<u64>,
    /// As `--spp` says it: the most that a render may take. Beyond 2²³ samples are not allocated over the
    /// picture.
    most: u32,
    /// Where the pictures go: X, Y and Z of each pixel at each decision of each seed, as 32-bit floats.
    pictures: PathBuf,
}

/// Takes note of the film at each decision, and ends at the last.
struct Watch {
    replicates: u64,
    samples: u64,
    /// When the pilots were done.
    began: Mutex<ProcessTime>,
    seen: Mutex<(Vec<Value>, Vec<u8>)>,
    stop: AtomicBool,
}

impl Progress for Watch {
    fn advanced(&self, _: u64) {}

    fn pass_done(&self, work: &Work) {
        let Some(of_replicate) = work.samples_per_replicate().filter(|&count| Target::decides_at(count))
        else {
            return;
        };
        let (film, samples) = (work.film(), of_replicate * self.replicates);
        let seconds = locked(&self.began).elapsed().as_secs_f64();
        let at_most = |measure| Target { measure, bound: 1.0 }.estimate(film).map(|found| found.at_most);
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let values = film.shown().flat_map(|(x, y)| axes.map(|of| film.combined(x, y, of).mean as f32));
        let seen = json!({
            "samples": samples,
            "seconds": seconds,
            "relmse": at_most(ErrorMeasure::RelMse),
            "error": at_most(ErrorMeasure::Error),
            "de": at_most(ErrorMeasure::ColourDifference),
        });
        let mut all = locked(&self.seen);
        all.0.push(seen);
        all.1.extend(values.flat_map(f32::to_le_bytes));
        if samples >= self.samples {
            self.stop.store(true, Ordering::Relaxed);
        }
    }

    fn pilots_done(&self, _: &Chosen) {
        *locked(&self.began) = ProcessTime::now();
    }

    fn stop(&self) -> &AtomicBool {
        &self.stop
    }
}

fn locked<T>(value: &Mutex<T>) -> MutexGuard<'_, T> {
    value.lock().unwrap_or_else(PoisonError::into_inner)
}

pub fn answer(question: Question) -> Result<Value, Box<dyn std::error::Error>> {
    let Question { scene, size: [width, height], samples, seeds, most, pictures } = question;
    let mut description = read(&scene, &ReadOptions::default()).map_err(|errors| errors.to_string())?;
    let film = &mut description.sensor.film;
    (film.width, film.height, film.crop) = (width, height, None);
    let scene = compile(&description, &CompileOptions::default()).map_err(|errors| errors.to_string())?;
    let (mut told, mut bytes) = (Vec::new(), Vec::new());
    for seed in seeds {
        let settings = Settings {
            schedule: Schedule::new(most),
            seed,
            sampler: SamplerKind::Sobol,
            wavelengths: Some(WavelengthCount::Four),
            estimator: Estimator::Shared,
            bins: None,
        };
        let watch = Watch {
            replicates: u64::from(settings.schedule().replicates),
            samples,
            began: Mutex::new(ProcessTime::now()),
            seen: Mutex::default(),
            stop: AtomicBool::new(false),
        };
        go_on(&scene, &settings, Work::new(&scene, &settings, None), &watch);
        let (seen, values) = watch.seen.into_inner().unwrap_or_else(PoisonError::into_inner);
        told.push(seen);
        bytes.extend(values);
    }
    std::fs::write(pictures, bytes)?;
    Ok(json!(told))
}
