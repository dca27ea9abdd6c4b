use abbe::film::Film;
use abbe::integrator::Estimator;
use abbe::output::target::{ErrorMeasure, Target};
use abbe::render::{Progress, Schedule, Settings, WavelengthCount, Work, go_on};
use abbe::sampling::SamplerKind;
use abbe::scene::{CompileOptions, ReadOptions, compile, read};
use serde::Deserialize;
use serde_json::{Value, json};
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::AtomicBool;

/// What a render of each seed looks like whenever `abbe render --until` would decide.
#[derive(Deserialize)]
pub struct Question {
    scene: PathBuf,
    size: [u32; 2],
    samples: u32,
    seeds: Vec<u64>,
}

/// Takes note of the film at each decision, and never ends.
struct Watch {
    replicates: u64,
    seen: Mutex<Vec<Value>>,
    stop: AtomicBool,
}

impl Progress for Watch {
    fn advanced(&self, _: u64) {}

    fn pass_done(&self, film: &Film) {
        let samples = *film.samples_per_pixel().start();
        if !Target::decides_at(samples / self.replicates) {
            return;
        }
        let at_most = |measure| Target { measure, bound: 1.0 }.estimate(film).map(|found| found.at_most);
        let values = film.shown().map(|(x, y)| film.combined(x, y, [0.0, 1.0, 0.0]).mean);
        let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
        let seen = json!({
            "samples": samples,
            "mean": sum / count,
            "relmse": at_most(ErrorMeasure::RelMse),
            "error": at_most(ErrorMeasure::Error),
            "de": at_most(ErrorMeasure::ColourDifference),
        });
        self.seen.lock().unwrap_or_else(std::sync::PoisonError::into_inner).push(seen);
    }

    fn stop(&self) -> &AtomicBool {
        &self.stop
    }
}

pub fn answer(question: Question) -> Result<Value, Box<dyn std::error::Error>> {
    let Question { scene, size: [width, height], samples, seeds } = question;
    let mut description = read(&scene, &ReadOptions::default()).map_err(|errors| errors.to_string())?;
    let film = &mut description.sensor.film;
    (film.width, film.height, film.crop) = (width, height, None);
    let scene = compile(&description, &CompileOptions::default()).map_err(|errors| errors.to_string())?;
    let renders = seeds.into_iter().map(|seed| {
        let settings = Settings {
            schedule: Schedule::new(samples),
            seed,
            sampler: SamplerKind::Sobol,
            wavelengths: WavelengthCount::Four,
            estimator: Estimator::Shared,
            bins: None,
        };
        let replicates = u64::from(settings.schedule().replicates);
        let watch = Watch { replicates, seen: Mutex::default(), stop: AtomicBool::new(false) };
        go_on(&scene, &settings, Work::new(&scene, &settings, None), &watch);
        watch.seen.into_inner().unwrap_or_default()
    });
    Ok(json!(renders.collect::<Vec<Vec<Value>>>()))
}
