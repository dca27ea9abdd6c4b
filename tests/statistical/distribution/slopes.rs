//! How fast the error falls with the number of samples where one effect alone is distributed and its
//! integrand is smooth (`tests/scenes/smooth`): light from an extended lamp, gloss, translucency, a lens,
//! motion. `validation/noise/rates` makes the claim.

use crate::common;
use abbe::film::Film;
use abbe::integrator::Estimator;
use abbe::render::{Schedule, Settings, WavelengthCount};
use abbe::sampling::SamplerKind;
use abbe::scene::Scene;
use abbe::stats::{Estimate, Moments};
use abbe::study::Reference;
use abbe::study::fit::{Measurement, PowerLaw};
use abbe::units::WavelengthRange;

fn exposed(scene: &Scene, sampler: SamplerKind, replicates: u32, samples: u32, seed: u64) -> Film {
    let schedule = Schedule::independent(replicates, samples);
    common::expose(
        scene,
        &Settings {
            schedule,
            seed,
            sampler,
            wavelengths: WavelengthCount::Four,
            estimator: Estimator::Plain,
            bins: None,
        },
    )
}

fn reference(scene: &Scene) -> Reference {
    let film = exposed(scene, SamplerKind::Sobol, 16, 512, 1);
    let y = super::pixels(&film).map(|(x, y)| film.combined(x, y, [0.0, 1.0, 0.0]));
    let (mean, error): (Vec<f64>, Vec<f64>) = y.map(|y| (y.mean, y.error)).unzip();
    Reference::new(film.width as usize, mean, Some(&error)).expect("it is lit")
}

/// The error of pictures with so many samples, one sequence in each pixel.
fn relmse(scene: &Scene, reference: &Reference, sampler: SamplerKind, samples: u32) -> Estimate {
    let film = exposed(scene, sampler, 8, samples, u64::from(samples));
    let of_replicate = |replicate| {
        let image: Vec<f64> =
            super::pixels(&film).map(|(x, y)| film.of_replicate(x, y, replicate, [0.0, 1.0, 0.0])).collect();
        reference.relmse(&image)
    };
    (0..film.replicates).map(of_replicate).collect::<Moments>().estimate()
}

fn falls(name: &str) {
    let scene = common::scene(&format!("tests/scenes/smooth/{name}.xml"), &[], WavelengthRange::VISIBLE);
    let reference = reference(&scene);
    let measure = |sampler, samples| Measurement {
        x: f64::from(samples),
        relmse: relmse(&scene, &reference, sampler, samples),
    };
    let of_sobol = [4, 16, 64, 256, 1024].map(|samples| measure(SamplerKind::Sobol, samples));
    let sobol = PowerLaw::fit(&of_sobol).expect("errors that can be told");
    // With more samples the two are farther apart.
    let independent = [4, 16, 64, 256].map(|samples| measure(SamplerKind::Independent, samples));
    println!("{name}: slope {:.3} ± {:.3}", sobol.slope, sobol.slope_half_width);
    assert!(sobol.slope - sobol.slope_half_width < -0.7, "{name}: {sobol:?}");
    for (sobol, independent) in of_sobol.iter().zip(&independent) {
        let error = (sobol.relmse.variance + independent.relmse.variance).sqrt();
        assert!(
            sobol.relmse.mean < independent.relmse.mean + 3.0 * error,
            "{name}: {sobol:?} {independent:?}"
        );
    }
}

/// Owen-scrambled Sobol is steeper than −0.7, as far as its interval tells, and never worse than independent
/// samples.
#[test]
fn smooth_effects_converge_fast() {
    ["light", "gloss", "frosted", "lens", "motion"].into_iter().for_each(falls);
}
