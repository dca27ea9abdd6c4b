//! How fast errors fall with the number of samples.

use super::points;
use abbe::sampling::{Dimensions, Sampler, SamplerKind};

/// The squared L² star discrepancy in two dimensions (Warnock's formula).
fn discrepancy_squared(points: &[[f64; 2]]) -> f64 {
    let n = points.len() as f64;
    let single: f64 = points.iter().map(|[x, y]| (1.0 - x * x) * (1.0 - y * y)).sum();
    let pairs: f64 = points
        .iter()
        .flat_map(|a| points.iter().map(move |b| (1.0 - a[0].max(b[0])) * (1.0 - a[1].max(b[1]))))
        .sum();
    1.0 / 9.0 - single / (2.0 * n) + pairs / (n * n)
}

#[test]
fn stratified_points_have_less_discrepancy_than_random_ones() {
    let n = 64;
    let mean = |kind| {
        let sampler = Sampler::new(kind, 31, n);
        let pixels = 300;
        let all = (0..pixels)
            .map(|pixel| discrepancy_squared(&points(&sampler, [pixel, 0], Dimensions::Lens, n)))
            .sum::<f64>();
        all / f64::from(pixels)
    };
    let [regular, independent, jittered, poisson, sobol, blue] =
        SamplerKind::NAMES.map(|(_, kind)| mean(kind));
    println!("{regular:.2e} {independent:.2e} {jittered:.2e} {poisson:.2e} {sobol:.2e} {blue:.2e}");
    // The expectation for independent points: (2⁻² − 3⁻²)/N.
    let expected = (1.0 / 4.0 - 1.0 / 9.0) / f64::from(n);
    assert!((independent / expected - 1.0).abs() < 0.2, "{independent} for {expected}");
    for (name, discrepancy) in [("regular", regular), ("jittered", jittered), ("poisson", poisson)] {
        assert!(discrepancy < 0.5 * independent, "{name}: {discrepancy}");
    }
    for (name, discrepancy) in [("sobol", sobol), ("bluenoise", blue)] {
        assert!(discrepancy < 0.5 * jittered, "{name}: {discrepancy} for {jittered}");
    }
}

/// The slope of log RMSE on log N for a smooth function of two values, 16 to 1024 samples.
fn slope(kind: SamplerKind) -> f64 {
    // exp(−x) (1 + sin 2y) has no symmetry that a pattern could profit from.
    let exact = (1.0 - (-1f64).exp()) * (1.0 + 1f64.sin().powi(2));
    let counts = [16u32, 64, 256, 1024];
    let logs = counts.map(|n| {
        let (sampler, sequences) = (Sampler::new(kind, 41, n), 300);
        let squared = |pixel| {
            let values = points(&sampler, [pixel, 3], Dimensions::Light(1), n);
            let sum: f64 = values.iter().map(|[x, y]| (-x).exp() * (1.0 + (2.0 * y).sin())).sum();
            (sum / f64::from(n) - exact).powi(2)
        };
        let mean = (0..sequences).map(squared).sum::<f64>() / f64::from(sequences);
        (f64::from(n).ln(), 0.5 * mean.ln())
    });
    let mean = |f: fn(&(f64, f64)) -> f64| logs.iter().map(f).sum::<f64>() / logs.len() as f64;
    let (x, y) = (mean(|l| l.0), mean(|l| l.1));
    let cross: f64 = logs.iter().map(|l| (l.0 - x) * (l.1 - y)).sum();
    cross / logs.iter().map(|l| (l.0 - x).powi(2)).sum::<f64>()
}

/// Independent −1/2; jittered −1 (Haber 1966, two dimensions); a scrambled net −3/2 (Owen 1997). Poisson disk
/// patterns start lower than random points and are hardly steeper: the power that is left at low frequencies
/// is a constant share (Pilleboue et al., "Variance analysis for Monte Carlo integration", ACM TOG 34(4),
/// 2015).
#[test]
fn errors_of_smooth_functions_fall_as_theory_says() {
    for (name, kind) in SamplerKind::NAMES {
        let slope = slope(kind);
        println!("{name}: {slope:.3}");
        let range = match kind {
            SamplerKind::Independent => -0.55..-0.45,
            SamplerKind::Jittered => -1.05..-0.95,
            SamplerKind::Poisson => -0.7..-0.5,
            SamplerKind::Sobol | SamplerKind::BlueNoise => -1.65..-1.35,
            SamplerKind::Regular => -1.1..-0.9,
        };
        assert!(range.contains(&slope), "{name}: {slope}");
    }
}
