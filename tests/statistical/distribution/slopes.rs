//! How fast the error falls with the number of samples where one effect alone is distributed and its
//! integrand is smooth (`tests/scenes/smooth`): light from an extended lamp, gloss, translucency, a lens,
//! motion. `validation/noise/rates` makes the claim.

use crate::common;
use abbe::film::Film;
use abbe::integrator::Estimator;
use abbe::render::{Schedule, Settings, WavelengthCount};
use abbe::sampling::SamplerKind;
use abbe::scene::Scene;
use abbe::stats::{Estimate, Moments, student_quantile};
use abbe::study::Reference;
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

/// Exponent of log RMSE on log samples from the fewest samples to the most. Its error is that of noise alone:
/// the curves of smooth effects are no power laws, they steepen.
struct Slope {
    slope: f64,
    error: f64,
    /// Half of the 95 % confidence interval.
    half_width: f64,
}

impl Slope {
    fn between([few, many]: [(u32, Estimate); 2]) -> Self {
        let span = (f64::from(many.0) / f64::from(few.0)).ln();
        let relative = |of: Estimate| of.error() / of.mean;
        let error = 0.5 * relative(few.1).hypot(relative(many.1)) / span;
        let half_width = student_quantile(0.975, few.1.degrees + many.1.degrees) * error;
        Self { slope: 0.5 * (many.1.mean / few.1.mean).ln() / span, error, half_width }
    }

    /// Whether the error falls faster than with a slope of −0.7, as far as the interval tells.
    fn is_steep(&self) -> bool {
        self.slope - self.half_width < -0.7
    }
}

/// `off` is the error of a reference that is noticed, relative to the values of its pixels.
fn falls(name: &str, off: f64) {
    let scene = common::scene(&format!("tests/scenes/smooth/{name}.xml"), &[], WavelengthRange::VISIBLE);
    let reference = reference(&scene);
    let measure = |sampler, samples| relmse(&scene, &reference, sampler, samples);
    let of_sobol = SAMPLES.map(|samples| measure(SamplerKind::Sobol, samples));
    // With more samples the two are farther apart.
    let independent = [4, 16, 64, 256].map(|samples| measure(SamplerKind::Independent, samples));
    let slope = |reference_error: f64| {
        let misled = |of: Estimate| Estimate { mean: of.mean + reference_error * reference_error, ..of };
        Slope::between([0, 4].map(|i| (SAMPLES[i], misled(of_sobol[i]))))
    };
    let Slope { slope: found, error, half_width } = slope(0.0);
    println!("{name}: slope {found:.3} ± {half_width:.3}");
    assert!(slope(0.0).is_steep(), "{name}: {found} ± {half_width}");
    let told = half_width + common::found(0.0) * error;
    assert!(-0.7 + told < -0.5, "{name}: a slope of −0.5 is not found, ± {half_width}");
    let own = reference.own_relmse.expect("its error is known");
    let least = of_sobol[4].mean;
    assert!(own < 0.5 * least, "{name}: the reference adds {own} to {least}");
    let misled = slope(off);
    assert!(!misled.is_steep(), "{name}: a reference that is off by {off} is not noticed, {}", misled.slope);
    for (sobol, independent) in of_sobol.iter().zip(&independent) {
        let error = (sobol.variance + independent.variance).sqrt();
        assert!(sobol.mean < independent.mean + BOUND * error, "{name}: {sobol:?} {independent:?}");
        let worse = common::found(BOUND) * (2.0 * independent.variance).sqrt();
        assert!(worse < 0.8 * independent.mean, "{name}: {worse} is not found, {independent:?}");
    }
}

const SAMPLES: [u32; 5] = [4, 16, 64, 256, 1024];

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
