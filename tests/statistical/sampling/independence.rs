//! No two dimensions of a pixel's sequence know of each other: an object that moves left and one that moves
//! right are met equally often.

use super::random_kinds;
use abbe::sampling::{Dimensions, Sampler};
use abbe::stats::Moments;

/// Cook's printed prototype pattern (1986, Figure 9a).
const COOK: [[u32; 4]; 4] = [[7, 11, 3, 14], [4, 15, 13, 9], [16, 1, 8, 12], [6, 10, 5, 2]];

const SAMPLES: u32 = 16;

/// Film position, time and point on the lens of the samples of one pixel.
type Pixel = Vec<[f64; 5]>;

fn pixels(sampler: &Sampler) -> impl Iterator<Item = Pixel> {
    (0..4000).map(|pixel| {
        let sample = |index| {
            let stream = sampler.stream([pixel % 64, pixel / 64], 1, index);
            let [x, y, _, time] = stream.draw(Dimensions::Camera);
            let [u, v, ..] = stream.draw(Dimensions::Lens);
            [x, y, time, u, v]
        };
        (0..SAMPLES).map(sample).collect()
    })
}

/// The same pattern in every pixel: jittered in its cells and slices, the lens left independent.
fn cooks(sampler: &Sampler) -> impl Iterator<Item = Pixel> {
    pixels(sampler).map(|pixel| {
        let place = |(i, [x, y, t, u, v]): (usize, [f64; 5])| {
            let (row, column) = (i / 4, i % 4);
            let time = (f64::from(COOK[row][column]) - 1.0 + t) / 16.0;
            [(column as f64 + x) / 4.0, (row as f64 + y) / 4.0, time, u, v]
        };
        pixel.into_iter().enumerate().map(place).collect()
    })
}

/// The largest deviation of the tests below, in standard errors: z of the mean over pixels of each pair's
/// covariance within a pixel, and of the difference of coverage by movers in opposite directions.
fn worst(pixels: impl Iterator<Item = Pixel>) -> (f64, f64) {
    let mut covariances = [[Moments::default(); 5]; 5];
    let mut movers = [Moments::default(); 2];
    for pixel in pixels {
        let mean = |f: &dyn Fn(&[f64; 5]) -> f64| pixel.iter().map(f).sum::<f64>() / pixel.len() as f64;
        for (a, row) in covariances.iter_mut().enumerate() {
            for (b, moments) in row.iter_mut().enumerate().take(a) {
                moments.push(mean(&|sample| (sample[a] - 0.5) * (sample[b] - 0.5)));
            }
        }
        // Bars a quarter of the pixel wide that cross it while the shutter is open, along x and along y.
        for (axis, moments) in movers.iter_mut().enumerate() {
            let covered = |sample: &[f64; 5], time: f64| f64::from((sample[axis] - time).abs() < 0.125);
            moments.push(mean(&|sample| covered(sample, sample[2]) - covered(sample, 1.0 - sample[2])));
        }
    }
    let z = |moments: &Moments| (moments.mean() / moments.estimate().error()).abs();
    let pairs = (0..5).flat_map(|a| (0..a).map(move |b| (a, b)));
    (pairs.map(|(a, b)| z(&covariances[a][b])).fold(0.0, f64::max), movers.iter().map(z).fold(0.0, f64::max))
}

#[test]
fn opposite_movers_are_equally_covered() {
    for (name, kind) in random_kinds() {
        let (correlation, movers) = worst(pixels(&Sampler::new(kind, 12, SAMPLES)));
        println!("{name}: {correlation:.2} {movers:.2}");
        // Ten pairs and two movers for each of five samplers: both levels below 1 %.
        assert!(correlation < 4.0, "{name}: correlation within a pixel, z = {correlation}");
        assert!(movers < 4.0, "{name}: coverage by opposite movers, z = {movers}");
    }
}

/// One pattern for all pixels correlates time with the row: the tests above see it.
#[test]
fn cooks_printed_pattern_fails() {
    let mut seen: Vec<u32> = COOK.concat();
    seen.sort();
    assert!(seen.into_iter().eq(1..=16));
    let (correlation, movers) = worst(cooks(&Sampler::new(abbe::sampling::SamplerKind::Independent, 12, 16)));
    assert!(correlation > 50.0 && movers > 10.0, "{correlation} {movers}");
}
