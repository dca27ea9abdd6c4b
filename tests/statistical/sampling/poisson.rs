//! Poisson disk patterns.

use super::{band, points, spectrum};
use abbe::geometry::Vec3;
use abbe::sampling::poisson::{best_candidates, best_on_sphere, boundary, darts, distance_squared};
use abbe::sampling::{Dimensions, Sampler, SamplerKind};
use abbe::stats::Moments;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg as Random;

fn least_distance(points: &[[f64; 2]]) -> f64 {
    let pairs = points.iter().enumerate().flat_map(|(i, &a)| points[..i].iter().map(move |&b| (a, b)));
    pairs.map(|(a, b)| distance_squared(a, b)).fold(2.0, f64::min).sqrt()
}

/// Number of points times squared radius: 0.81 by boundary sampling, 0.66 by darts that stop after 20 000
/// misses.
#[test]
fn patterns_are_as_dense_as_their_making_allows() {
    let mut random = Random::seed_from_u64(5);
    let (mut by_boundary, mut by_darts) = (Moments::default(), Moments::default());
    for _ in 0..10 {
        let pattern = boundary(0.03, &mut random);
        assert_eq!(pattern.iterations, 2 * pattern.points.len() as u64 - 1);
        assert!(least_distance(&pattern.points) >= 0.03);
        by_boundary.push(pattern.points.len() as f64 * 0.03 * 0.03);
        let pattern = darts(0.03, 20_000, &mut random);
        assert!(least_distance(&pattern.points) >= 0.03);
        by_darts.push(pattern.points.len() as f64 * 0.03 * 0.03);
    }
    println!("boundary {:?}, darts {:?}", by_boundary.estimate(), by_darts.estimate());
    assert!((by_boundary.mean() - 0.81).abs() < 0.01, "{:?}", by_boundary.estimate());
    assert!((by_darts.mean() - 0.66).abs() < 0.01, "{:?}", by_darts.estimate());
}

/// Nearly nothing below half a cycle per mean spacing, and a peak at one.
#[test]
fn spectra_are_empty_up_to_the_spacing() {
    let mut random = Random::seed_from_u64(6);
    let mut patterns: [Vec<(f64, f64)>; 2] = Default::default();
    for _ in 0..6 {
        let made = [boundary(0.03, &mut random), darts(0.03, 5000, &mut random)];
        for (all, pattern) in patterns.iter_mut().zip(made) {
            let spacing = (1.0 / pattern.points.len() as f64).sqrt();
            all.extend(spectrum(&pattern.points, 40).into_iter().map(|(f, power)| (f * spacing, power)));
        }
    }
    for (name, power) in ["boundary", "darts"].into_iter().zip(&patterns) {
        let bands = [(0.0, 0.25), (0.25, 0.5), (1.0, 1.25)].map(|(from, to)| band(power, from, to).mean);
        println!("{name}: {bands:?}");
        assert!(bands[0] < 0.1 && bands[1] < 0.1, "{name}: {bands:?}");
        assert!((1.6..2.0).contains(&bands[2]), "{name}: {bands:?}");
    }
}

#[test]
fn best_candidates_keep_farther_apart_than_chance_at_every_prefix() {
    let mut random = Random::seed_from_u64(7);
    let apart = best_candidates(200, 10, &mut random);
    let chance: Vec<[f64; 2]> = (0..200).map(|_| [random.random(), random.random()]).collect();
    for prefix in [10, 20, 50, 100, 200] {
        assert!(least_distance(&apart[..prefix]) > least_distance(&chance[..prefix]), "{prefix}");
    }
}

/// Every prefix keeps at least half of the distance of the densest packing, √(8π/√3N), which random points do
/// not; and the points are nowhere denser than elsewhere.
#[test]
fn points_on_the_sphere_keep_apart_and_cover_it() {
    let mut random = Random::seed_from_u64(8);
    let least = |points: &[Vec3]| {
        let pairs =
            points.iter().enumerate().flat_map(|(i, a)| points[..i].iter().map(move |b| a.distance(*b)));
        pairs.fold(2.0, f64::min)
    };
    let points = best_on_sphere(300, 10, &mut random);
    assert!(points.iter().all(|point| (point.length() - 1.0).abs() < 1e-12));
    for prefix in [10, 30, 100, 300] {
        let densest = (8.0 * std::f64::consts::PI / (3f64.sqrt() * prefix as f64)).sqrt();
        let ratio = least(&points[..prefix]) / densest;
        println!("{prefix}: {ratio}");
        assert!(ratio > 0.5 && ratio <= 1.0, "{prefix}: {ratio}");
    }
    // Candidates: one random point at a time, the first of them all.
    let chance: Vec<Vec3> = (0..300).flat_map(|_| best_on_sphere(1, 0, &mut random)).collect();
    assert!(least(&chance) < 0.25 * least(&points));
    // Random points err by √(1/3N) in the mean of a coordinate, well spread ones by much less.
    let mean = points.iter().sum::<Vec3>() / 300.0;
    assert!(mean.abs().max_element() < 0.5 * (1.0f64 / 900.0).sqrt(), "{mean}");
    let squares = points.iter().map(|point| *point * *point).sum::<Vec3>() / 300.0;
    assert!((squares - Vec3::splat(1.0 / 3.0)).abs().max_element() < 0.02, "{squares}");
}

/// Every sequence has all its points, none too near another, wherever it was shifted to; long ones repeat a
/// pattern.
#[test]
fn every_sequence_of_the_sampler_keeps_its_distance() {
    for (samples, density) in
        [(2u32, 0.5), (3, 0.4), (7, 0.6), (16, 0.7), (100, 0.75), (256, 0.77), (1000, 0.77)]
    {
        let sampler = Sampler::new(SamplerKind::Poisson, 9, samples);
        for pixel in 0..5 {
            for set in [Dimensions::Camera, Dimensions::Light(2)] {
                let points = points(&sampler, [pixel, 4], set, samples);
                let reached = f64::from(samples) * least_distance(&points).powi(2);
                assert!(reached > density, "{samples} samples: N r² = {reached}");
            }
        }
    }
}
