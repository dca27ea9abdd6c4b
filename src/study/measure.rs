use super::spectra::ImageSpectrum;
use super::{Case, Purpose, Reference, Request, Run, RunId, seed_of_run};
use crate::film::{BadValues, Film};
use crate::integrator::Estimator;
use crate::render::{Progress, Schedule, Settings, render};
use cpu_time::ProcessTime;

/// Most memory that the film of a run takes, bytes: more replicates are rendered one batch after the other,
/// each with a seed of its own.
const LARGEST_FILM: u128 = 1 << 30;

impl Request {
    /// How a batch of a run's replicates is rendered.
    fn settings(&self, id: &RunId, purpose: Purpose, batch: u64, replicates: u32) -> Settings {
        Settings {
            schedule: match id.estimator {
                Estimator::Plain => Schedule::independent(replicates, id.samples_per_pixel),
                Estimator::Shared => Schedule::of(id.sampler, id.samples_per_pixel),
            },
            seed: seed_of_run(self.seed, purpose, id, batch),
            sampler: id.sampler,
            wavelengths: Some(id.wavelengths_per_path),
            estimator: id.estimator,
            bins: None,
        }
    }

    /// Replicates that are rendered together. By the shared estimator each is a picture with pilots of its
    /// own.
    fn batch(&self, scene: &crate::scene::Scene, id: &RunId) -> u32 {
        if id.estimator == Estimator::Shared {
            return 1;
        }
        let settings = self.settings(id, Purpose::Run, 0, 1);
        let [width, height] = scene.film.extent.measured.size;
        let one = Film::bytes(width, height, 1, &settings.extras(scene)).iter().sum::<u128>().max(1);
        u32::try_from(LARGEST_FILM / one).unwrap_or(u32::MAX).max(1)
    }

    /// The seed of each replicate's batch.
    pub fn seeds(&self, case: &Case, id: &RunId) -> Vec<u64> {
        let batch = self.batch(&case.scene, id);
        let replicates = self.replicates_of(id.sampler);
        (0..replicates).map(|r| seed_of_run(self.seed, Purpose::Run, id, u64::from(r / batch))).collect()
    }
}

/// Y of every pixel in each replicate of a run that a film holds.
fn luminances(film: &Film, estimator: Estimator) -> Vec<Vec<f64>> {
    const Y: [f64; 3] = [0.0, 1.0, 0.0];
    match estimator {
        Estimator::Plain => {
            let of = |replicate| film.shown().map(|(x, y)| film.of_replicate(x, y, replicate, Y)).collect();
            (0..film.replicates).map(of).collect()
        }
        Estimator::Shared => vec![film.shown().map(|(x, y)| film.combined(x, y, Y).mean).collect()],
    }
}

/// Renders a run and compares it with the reference of its case, on the current rayon thread pool.
pub fn measure(
    request: &Request,
    case: &Case,
    id: RunId,
    reference: &Reference,
    progress: &dyn Progress,
) -> Run {
    let replicates = request.replicates_of(id.sampler);
    let largest = request.batch(&case.scene, &id);
    let [width, height] = case.scene.film.extent.shown.size;
    let (mut relmse, mut bad, mut cpu_seconds) = (Vec::new(), BadValues::default(), 0.0);
    let mut spectrum = ImageSpectrum::new(width as usize, height as usize);
    for batch in 0..replicates.div_ceil(largest) {
        let count = largest.min(replicates - batch * largest);
        let settings = request.settings(&id, Purpose::Run, u64::from(batch), count);
        let started = ProcessTime::now();
        let film = render(&case.scene, &settings, progress);
        cpu_seconds += started.elapsed().as_secs_f64();
        bad.add(film.bad);
        for image in luminances(&film, id.estimator) {
            relmse.push(reference.relmse(&image));
            spectrum.add(&reference.relative_errors(&image));
        }
    }
    let with_picture = id.samples_per_pixel == request.shown_samples();
    Run {
        relmse,
        cpu_seconds: cpu_seconds / f64::from(replicates.max(1)),
        bad_values: bad.total(),
        spectrum: spectrum.finish(with_picture),
        id,
    }
}

/// One picture that a sampler makes in about a given time.
pub(super) struct EqualTime {
    pub id: RunId,
    pub cpu_seconds: f64,
    pub relmse: f64,
    pub width: usize,
    /// (A − B)/√(B² + 0.01·mean(B)²) of each pixel.
    pub errors: Vec<f64>,
}

/// One replicate with so many samples, and what it took.
pub(super) fn equal_time(
    request: &Request,
    case: &Case,
    id: RunId,
    reference: &Reference,
    progress: &dyn Progress,
) -> EqualTime {
    let settings = request.settings(&id, Purpose::EqualTime, 0, 1);
    let started = ProcessTime::now();
    let film = render(&case.scene, &settings, progress);
    let cpu_seconds = started.elapsed().as_secs_f64();
    let width = film.extent.shown.size[0] as usize;
    let images = luminances(&film, id.estimator);
    let image = images.first().map_or(&[][..], Vec::as_slice);
    EqualTime {
        id,
        cpu_seconds,
        relmse: reference.relmse(image),
        width,
        errors: reference.relative_errors(image),
    }
}
