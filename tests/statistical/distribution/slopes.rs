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
use abbe::study::fit::{Measurement, PowerLaw, student_95};
use abbe::units::WavelengthRange;

fn exposed(scene: &Scene, sampler: SamplerKind, replicates: u32, samples: u32, seed: u64) -> Film {
    let schedule = Schedule::independent(replicates, samples);
    common::expose(
        scene,
        &Settings {
            schedule,
            seed,
            sampler,
            wavelengths: Some(WavelengthCount::Four),
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

/// Whether the error falls faster than with a slope of −0.7, as far as the interval of the slope tells.
fn is_steep(law: &PowerLaw) -> bool {
    law.slope - law.slope_half_width < -0.7
}

/// `off` is the error of a reference that is noticed, relative to the values of its pixels.
fn falls(name: &str, off: f64) {
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
    assert!(is_steep(&sobol), "{name}: {sobol:?}");
    let slope_error = sobol.slope_half_width / student_95(5.0 * 7.0);
    let found = sobol.slope_half_width + common::found(0.0) * slope_error;
    assert!(-0.7 + found < -0.5, "{name}: a slope of −0.5 is not found, {sobol:?}");
    let own = reference.own_relmse.expect("its error is known");
    let least = of_sobol[4].relmse.mean;
    assert!(own < 0.5 * least, "{name}: the reference adds {own} to {least}");
    let misled = of_sobol.map(|Measurement { x, relmse }| Measurement {
        x,
        relmse: Estimate { mean: relmse.mean + off * off, ..relmse },
    });
    let misled = PowerLaw::fit(&misled).expect("errors that can be told");
    assert!(!is_steep(&misled), "{name}: a reference that is off by {off} is not noticed, {misled:?}");
    for (sobol, independent) in of_sobol.iter().zip(&independent) {
        let error = (sobol.relmse.variance + independent.relmse.variance).sqrt();
        assert!(
            sobol.relmse.mean < independent.relmse.mean + BOUND * error,
            "{name}: {sobol:?} {independent:?}"
        );
        let worse = common::found(BOUND) * (2.0 * independent.relmse.variance).sqrt();
        assert!(worse < 0.8 * independent.relmse.mean, "{name}: {worse} is not found, {independent:?}");
    }
}

/// Standard errors by which Sobol may be worse than independent samples.
const BOUND: f64 = 3.0;

/// Owen-scrambled Sobol is steeper than −0.7, as far as its interval tells, and never worse than independent
/// samples. With a probability of 90 % the test finds a slope of −0.5, that of independent samples, and an
/// error a third larger than theirs.
///
/// The reference takes 8 times as many samples as the largest picture. What its own error adds, less than
/// half of the least relMSE, is subtracted; were it not, the slopes would be flatter by 0.02, which is not
/// noticed. A reference that is off by the number beside a name is.
#[test]
fn smooth_effects_converge_fast() {
    let all = [("light", 0.004), ("gloss", 0.005), ("frosted", 0.035), ("lens", 0.004), ("motion", 0.004)];
    all.into_iter().for_each(|(name, off)| falls(name, off));
}
