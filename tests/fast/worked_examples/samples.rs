//! Samples in space and in time, and what a pixel makes of them.

use super::assert_near;
use abbe::camera::{Shutter, ShutterKind};
use abbe::film::{Extras, Film, FixedPoint, Tristimulus};
use abbe::sampling::{Dimensions, Sampler, SamplerKind};
use abbe::stats::fourier;
use rustfft::FftDirection;
use rustfft::num_complex::Complex;
use statrs::distribution::{ContinuousCDF, Normal};
use std::f64::consts::TAU;

/// Cook's power gains of a jittered sine, white jitter over the whole cell and Gaussian jitter of σ = T/6.5:
/// the squared mean of cos(2πνζ) over the displacements ζ of the sampler, of which the standard error is
/// known.
#[test]
fn n13_gains_of_jittered_sines() {
    let table = [
        (0.1, 0.96753, 0.99070),
        (0.25, 0.81057, 0.94327),
        (0.5, 0.40528, 0.79168),
        (0.75, 0.09006, 0.59120),
        (1.0, 0.0, 0.39282),
        (1.25, 0.03242, 0.23224),
        (1.5, 0.04503, 0.12216),
        (2.0, 0.0, 0.02381),
        (2.5, 0.01621, 0.00291),
        (3.0, 0.0, 0.00022),
    ];
    let normal = Normal::standard();
    let sampler = Sampler::new(SamplerKind::Jittered, 13, 1);
    let n = 200_000;
    let displacements: Vec<[f64; 2]> = (0..n)
        .map(|cell| {
            let [u, ..] = sampler.stream([cell, 0], 0, 0).draw(Dimensions::Camera);
            [u - 0.5, normal.inverse_cdf(u) / 6.5]
        })
        .collect();
    for (frequency, white, gaussian) in table {
        for (kind, gain) in [white, gaussian].into_iter().enumerate() {
            let (mut mean, mut square) = (0.0, 0.0);
            for displacement in &displacements {
                let kept = (TAU * frequency * displacement[kind]).cos();
                mean += kept / f64::from(n);
                square += kept * kept / f64::from(n);
            }
            let error = ((square - mean * mean) / f64::from(n)).sqrt();
            // Twenty tests; the table's last digit is half a unit off at most.
            let amplitude = [-1.0, 1.0].map(|digit: f64| (gain + 0.5e-5 * digit).max(0.0).sqrt());
            let off = (amplitude[0] - mean.abs()).max(mean.abs() - amplitude[1]).max(0.0);
            assert!(off < 4.0 * error, "νT = {frequency}, {kind}: {} is not {gain}", mean * mean);
        }
    }
}

/// Prototype 7 of 16 stands for the times from 6/16 to 7/16 of the shutter's.
#[test]
fn n14_times_by_slices() {
    let shutter = Shutter { open: 0.0, close: 1.0, kind: ShutterKind::Box };
    let sampler = Sampler::new(SamplerKind::Jittered, 14, 16);
    for pixel in 0..1000 {
        let mut times: Vec<f64> = (0..16)
            .map(|index| {
                let [.., time] = sampler.stream([pixel, 7], 0, index).draw(Dimensions::Camera);
                shutter.time(time)
            })
            .collect();
        times.sort_by(f64::total_cmp);
        assert_near(times[6], 0.40625, 1.0 / 32.0);
        for (slice, time) in times.iter().enumerate() {
            assert!((slice as f64..=slice as f64 + 1.0).contains(&(time * 16.0)), "{times:?}");
        }
    }
}

/// Nine rays of one pixel, six of which see green and three blue.
#[test]
fn n17_a_pixel_is_the_mean_of_its_rays() {
    let mut film = Film::new(1, 1, 1, Extras::default(), FixedPoint::for_reference(1.0));
    let mut tile = film.extras.tile([0, 0], [1, 1], 0..1);
    for ray in 0..9 {
        tile.add(0, 0, if ray < 6 { 1 } else { 2 }, 1.0, film.scale());
        tile.add_weighed(0, 0, &Tristimulus::BLACK, 1.0);
    }
    film.add(&tile);
    assert_near(film.of_replicate(0, 0, 0, [0.0, 1.0, 0.0]), 2.0 / 3.0, 1e-9);
    assert_near(film.of_replicate(0, 0, 0, [0.0, 0.0, 1.0]), 1.0 / 3.0, 1e-9);
    assert_eq!((film.of_replicate(0, 0, 0, [1.0, 0.0, 0.0]), film.bad.total()), (0.0, 0));
}

/// The rays of a pixel that was divided where its corners differed, each with the part of the pixel that it
/// stands for. The printed formula has a bracket misplaced, and its weights add up to 1.75: a film divides by
/// their sum, so that a factor of all of them changes nothing.
#[test]
fn n20_weights_of_the_rays_of_a_divided_pixel() {
    let weights = [
        ('A', 16.0),
        ('B', 4.0),
        ('C', 1.0),
        ('D', 16.0),
        ('E', 37.0),
        ('F', 4.0),
        ('G', 13.0),
        ('H', 8.0),
        ('J', 1.0),
        ('K', 4.0),
        ('L', 1.0),
        ('M', 13.0),
        ('N', 4.0),
        ('P', 1.0),
        ('Q', 4.0),
        ('R', 1.0),
    ]
    .map(|(ray, of_128)| (ray, of_128 / 128.0));
    assert_near(weights.iter().map(|(_, weight)| weight).sum(), 1.0, 0.0);
    // What one ray sees alone arrives by its weight.
    let pixel = |lit: char, factor: f64| {
        let mut film = Film::new(1, 1, 1, Extras::default(), FixedPoint::for_reference(1.0));
        let mut tile = film.extras.tile([0, 0], [1, 1], 0..1);
        for (ray, weight) in weights {
            let value = if ray == lit { 1.0 } else { 0.0 };
            tile.add(0, 0, 1, factor * weight * value, film.scale());
            tile.add_weighed(0, 0, &Tristimulus::BLACK, factor * weight);
        }
        film.add(&tile);
        film.of_replicate(0, 0, 0, [0.0, 1.0, 0.0])
    };
    for (ray, weight) in weights {
        assert_near(pixel(ray, 1.0), weight, 1e-9);
        assert_near(pixel(ray, 1.75), weight, 1e-9);
    }
}

/// A pixel of which one half is white is black all over once in 2²⁰ when its 20 samples are independent; in
/// jittered cells, never.
#[test]
fn n21_odds_of_a_pixel_that_is_all_wrong() {
    let wrong = |kind: SamplerKind, samples: u32, pixels: u32| {
        let sampler = Sampler::new(kind, 21, samples);
        let all_black = |pixel: u32| {
            (0..samples).all(|index| {
                let [x, ..] = sampler.stream([pixel, 0], 0, index).draw(Dimensions::Camera);
                x < 0.5
            })
        };
        (0..pixels).filter(|&pixel| all_black(pixel)).count()
    };
    // 0.954 are expected in a million: more than 8 come once in four million times.
    assert_near(1e6 * 0.5f64.powi(20), 0.954, 5e-4);
    assert!(wrong(SamplerKind::Independent, 20, 1_000_000) <= 8);
    assert_eq!(wrong(SamplerKind::Jittered, 20, 1_000_000), 0);
    // With ten samples there are enough of them to be counted.
    let (seen, expected) = (wrong(SamplerKind::Independent, 10, 1_000_000) as f64, 1e6 / 1024.0);
    assert!((seen - expected).abs() < 4.0 * expected.sqrt(), "{seen}");
}

/// A comb of triangles 1.01 pixels apart: its teeth come back every 101 pixels with one sample in the middle
/// of each pixel, and every 25.25 with 4 × 4.
#[test]
fn n22_aliases_of_a_comb() {
    const PIXELS: usize = 1616;
    let period = |samples: u32| {
        let sampler = Sampler::new(SamplerKind::Regular, 22, samples);
        let transform = fourier(PIXELS, FftDirection::Forward);
        let mut power = vec![0.0; PIXELS / 2];
        for row in 20..30 {
            let mut line: Vec<Complex<f64>> = (0..PIXELS)
                .map(|column| {
                    let white = (0..samples).filter(|&index| {
                        let [x, y, ..] =
                            sampler.stream([column as u32, row], 0, index).draw(Dimensions::Camera);
                        let width = 1.0 - (f64::from(row) + y) / 50.0;
                        ((column as f64 + x) / 1.01).fract() < width
                    });
                    Complex::new(white.count() as f64 / f64::from(samples), 0.0)
                })
                .collect();
            transform.process(&mut line);
            power.iter_mut().zip(&line).skip(1).for_each(|(sum, wave)| *sum += wave.norm_sqr());
        }
        let (most, _) = power.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).unwrap();
        PIXELS as f64 / most as f64
    };
    assert_eq!((period(1), period(16)), (101.0, 25.25));
}
