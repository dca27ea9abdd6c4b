//! Samplers against the theory of stochastic sampling.

mod blue_noise;
mod convergence;
mod independence;
mod jitter;
mod poisson;
mod strata;
mod warps;

use abbe::sampling::{Dimensions, Sampler, SamplerKind};

/// All samplers that have replicates.
fn random_kinds() -> impl Iterator<Item = (&'static str, SamplerKind)> {
    SamplerKind::NAMES.into_iter().filter(|(_, kind)| kind.is_random())
}

/// The first two values of a set, for a whole sequence of a pixel.
fn points(sampler: &Sampler, pixel: [u32; 2], set: Dimensions, samples: u32) -> Vec<[f64; 2]> {
    (0..samples)
        .map(|index| {
            let [x, y, ..] = sampler.stream(pixel, 0, index).draw(set);
            [x, y]
        })
        .collect()
}

/// |Σ exp(−2πi k·x)|²/N for all frequencies k with 0 ≤ k₁ ≤ `most` and |k₀| ≤ `most`, cycles per unit. Independent
/// points have 1 everywhere but at 0. Given with the frequency's length; 0 itself is left out.
fn spectrum(points: &[[f64; 2]], most: usize) -> Vec<(f64, f64)> {
    let width = 2 * most + 1;
    let mut sums = vec![[0.0; 2]; width * (most + 1)];
    let times = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a * c - b * d, a * d + b * c];
    for &[x, y] in points {
        let turn = |t: f64| [(std::f64::consts::TAU * t).cos(), -(std::f64::consts::TAU * t).sin()];
        let (step, row_step) = (turn(x), turn(y));
        let mut row = turn(-(most as f64) * x);
        for line in sums.chunks_exact_mut(width) {
            let mut term = row;
            for sum in line {
                *sum = [sum[0] + term[0], sum[1] + term[1]];
                term = times(term, step);
            }
            row = times(row, row_step);
        }
    }
    let power = |[re, im]: [f64; 2]| (re * re + im * im) / points.len() as f64;
    let frequency = |at: usize| ((at % width) as f64 - most as f64).hypot((at / width) as f64);
    let all = sums.into_iter().enumerate().map(|(at, sum)| (frequency(at), power(sum)));
    all.filter(|(frequency, _)| *frequency > 0.0).collect()
}

/// Mean and its standard error over the values whose frequency lies in the band.
fn band(spectrum: &[(f64, f64)], from: f64, to: f64) -> abbe::stats::Estimate {
    let mut moments = abbe::stats::Moments::default();
    spectrum.iter().filter(|(f, _)| (from..to).contains(f)).for_each(|&(_, power)| moments.push(power));
    moments.estimate()
}
