//! One sample to a stratum, where a sampler promises that.

use abbe::sampling::{Dimensions, Sampler, SamplerKind};

const SETS: [Dimensions; 4] =
    [Dimensions::Camera, Dimensions::Lens, Dimensions::Scattering(2), Dimensions::Light(0)];

fn each_once(cells: impl Iterator<Item = usize>, count: u32) -> bool {
    let mut cells: Vec<usize> = cells.collect();
    cells.sort();
    cells.into_iter().eq(0..count as usize)
}

#[test]
fn every_slice_and_every_square_has_one_sample() {
    for (name, kind) in SamplerKind::NAMES {
        let promised = kind != SamplerKind::Independent;
        for samples in [4u32, 16, 64] {
            let sampler = Sampler::new(kind, 3, samples);
            let side = f64::from(samples).sqrt();
            let (mut sliced, mut squared) = (true, true);
            for pixel in 0..30 {
                for set in SETS {
                    let values: Vec<[f64; 4]> = (0..samples)
                        .map(|index| sampler.stream([pixel, pixel / 3], 2, index).draw(set))
                        .collect();
                    for dimension in 2..4 {
                        let slices = values.iter().map(|v| (v[dimension] * f64::from(samples)) as usize);
                        sliced &= each_once(slices, samples);
                    }
                    // Film, lens and first light of a Sobol sequence share its pairs; only the film's has
                    // squares of its own.
                    let shared = matches!(kind, SamplerKind::Sobol | SamplerKind::BlueNoise)
                        && matches!(set, Dimensions::Lens | Dimensions::Light(0));
                    if shared {
                        continue;
                    }
                    let square =
                        |v: &[f64; 4]| (v[1] * side) as usize * side as usize + (v[0] * side) as usize;
                    squared &= each_once(values.iter().map(square), samples);
                }
            }
            assert_eq!(sliced, promised, "{name}, {samples} samples: slices");
            assert_eq!(
                squared,
                promised && kind != SamplerKind::Poisson,
                "{name}, {samples} samples: squares"
            );
        }
    }
}

/// The length of a sequence need not be a power of anything.
#[test]
fn any_number_of_samples_has_its_slices() {
    for kind in [SamplerKind::Regular, SamplerKind::Jittered, SamplerKind::Poisson] {
        for samples in [1u32, 3, 10, 50] {
            let sampler = Sampler::new(kind, 3, samples);
            for pixel in 0..20 {
                for dimension in 2..4 {
                    let slices = (0..samples).map(|index| {
                        let value = sampler.stream([pixel, 7], 0, index).draw(Dimensions::Camera)[dimension];
                        (value * f64::from(samples)) as usize
                    });
                    assert!(each_once(slices, samples), "{kind:?}, {samples} samples");
                }
            }
        }
    }
}

/// A linear function of time has the variance 1/(12 N) with random and 1/(12 N³) with jittered times.
#[test]
fn linear_motion_is_as_noisy_as_theory_says() {
    for (kind, power) in
        [(SamplerKind::Independent, 1), (SamplerKind::Jittered, 3), (SamplerKind::Poisson, 3)]
    {
        for n in [4u32, 16] {
            let sampler = Sampler::new(kind, 3, n);
            let pixels = 10_000;
            let mean_time = |pixel| {
                let times =
                    (0..n).map(|index| sampler.stream([pixel, 1], 0, index).draw(Dimensions::Camera)[3]);
                times.sum::<f64>() / f64::from(n)
            };
            let squares = (0..pixels).map(|pixel| (mean_time(pixel) - 0.5).powi(2)).sum::<f64>();
            let ratio = squares / f64::from(pixels) * 12.0 * f64::from(n).powi(power);
            assert!((ratio - 1.0).abs() < 0.1, "{kind:?}, {n}: {ratio}");
        }
    }
}
