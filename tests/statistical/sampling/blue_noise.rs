//! The error of a picture as blue noise.

use super::band;
use abbe::sampling::{Dimensions, Sampler, SamplerKind};
use std::f64::consts::TAU;

/// Edge of the picture, pixels.
const EDGE: u32 = 64;

/// The power of the error image of a smooth picture at every frequency, cycles per pixel. Each pixel
/// integrates a function of position and lens that changes slowly over the picture.
fn error_spectrum(kind: SamplerKind, samples: u32, set: Dimensions) -> Vec<(f64, f64)> {
    let sampler = Sampler::new(kind, 51, samples);
    let mut error = vec![0.0; (EDGE * EDGE) as usize];
    for (at, error) in (0..).zip(&mut error) {
        let [x, y] = [at % EDGE, at / EDGE];
        let tilt = f64::from(x + y) / f64::from(2 * EDGE);
        let value = |index| {
            let [u, v, w, _] = sampler.stream([x, y], 0, index).draw(set);
            u + tilt * u * v + 0.5 * w * w
        };
        let mean = (0..samples).map(value).sum::<f64>() / f64::from(samples);
        *error = mean - (0.5 + tilt / 4.0 + 0.5 / 3.0);
    }
    let mut power = Vec::new();
    for ky in 0..=EDGE / 2 {
        for kx in 0..EDGE {
            let [re, im] = (0..).zip(&error).fold([0.0; 2], |[re, im], (at, &error)| {
                let turns = f64::from(kx * (at % EDGE) + ky * (at / EDGE)) / f64::from(EDGE);
                let (sin, cos) = (TAU * turns.fract()).sin_cos();
                [re + error * cos, im + error * sin]
            });
            let wrapped = f64::from(kx.min(EDGE - kx));
            let frequency = wrapped.hypot(f64::from(ky)) / f64::from(EDGE);
            power.push((frequency, (re * re + im * im) / f64::from(EDGE * EDGE)));
        }
    }
    power
}

/// Low frequencies are suppressed against Sobol points of the same number, and the error as a whole is not
/// larger.
#[test]
fn errors_of_neighbours_cancel() {
    for (samples, set) in [(1, Dimensions::Camera), (4, Dimensions::Light(1)), (8, Dimensions::Lens)] {
        let [sobol, blue] =
            [SamplerKind::Sobol, SamplerKind::BlueNoise].map(|kind| error_spectrum(kind, samples, set));
        let low = |power: &[(f64, f64)]| band(power, 0.0, 0.125).mean;
        let all = |power: &[(f64, f64)]| band(power, 0.0, 1.0).mean;
        println!("{samples}: low {:.3}, all {:.3}", low(&blue) / low(&sobol), all(&blue) / all(&sobol));
        assert!(low(&blue) < 0.2 * low(&sobol), "{samples}: {} for {}", low(&blue), low(&sobol));
        assert!(all(&blue) < 1.2 * all(&sobol), "{samples}: {} for {}", all(&blue), all(&sobol));
    }
}
