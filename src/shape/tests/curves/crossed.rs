//! All crossings against the oracle.

use super::exact::{Exact, segment};
use super::{Made, paths};
use crate::geometry::{Bounds, Ray, Transform, Vec3};
use crate::shape::tests::doubled::{Doubled, Polynomial};
use crate::shape::tests::oracle::any_ray;
use crate::shape::tests::{direction, placement};
use crate::shape::{ControlPoint, Shape};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg as Random;
use std::f64::consts::TAU;

/// Compares `rays` rays; returns how many were left undecided, because a ray hardly beside them has another
/// number of crossings, and the largest error of t relative to t and the shape's size.
fn check(
    name: &str,
    made: Made,
    to_world: &Transform,
    path: &[ControlPoint],
    rays: u32,
    seed: u64,
) -> (u32, f64) {
    let shape = made.shape(to_world, path, false);
    let (bounds, mut random) = (shape.bounds(), Random::seed_from_u64(seed));
    let (mut doubtful, mut hits, mut worst) = (0, 0, 0.0f64);
    for _ in 0..rays {
        let ray = aimed(made, &shape, path, to_world, bounds, &mut random);
        let found = shape.crossings(&ray);
        let told = |exact: &[Exact]| exact.iter().map(|e| (e.t.high, e.enters)).collect::<Vec<_>>();
        let agrees = |exact: &[Exact]| {
            found.len() == exact.len()
                && found.iter().zip(exact).all(|(crossing, exact)| {
                    let off = (Doubled::from(crossing.hit.t) - exact.t).high.abs();
                    crossing.enters == exact.enters && off <= crossing.error
                })
        };
        let mut exact = made.exact(&ray, to_world, path, 24);
        if !agrees(&exact) {
            exact = made.exact(&ray, to_world, path, 3000);
        }
        hits += exact.len();
        if agrees(&exact) {
            for (crossing, exact) in found.iter().zip(&exact) {
                let off = (Doubled::from(crossing.hit.t) - exact.t).high.abs();
                worst = worst.max(off / (exact.t.high.abs() + bounds.diameter()));
            }
            let nearest = shape.intersect(&ray).map(|hit| hit.t);
            let first = found.iter().map(|crossing| crossing.hit.t).find(|&t| t >= 0.0);
            assert!(nearest == first, "{name} {made:?}: {ray:?} {nearest:?} {first:?}");
            continue;
        }
        // As far beside it as coordinates are rounded, tenfold.
        let beside = 1e-13 * (bounds.diameter() + ray.origin.length());
        let (x, y) = ray.direction.any_orthonormal_pair();
        let changes = (0..8).any(|i| {
            let (sin, cos) = (TAU * f64::from(i) / 8.0).sin_cos();
            let moved = Ray::new(ray.origin + (x * cos + y * sin) * beside, ray.direction);
            made.exact(&moved, to_world, path, 3000).len() != exact.len()
        });
        assert!(changes, "{name} {made:?}: {ray:?}\n{found:?}\n{:?}", told(&exact));
        doubtful += 1;
    }
    assert!(hits as u32 > rays / 4, "{name} {made:?}: only {hits} crossings");
    (doubtful, worst)
}

/// Rays from near and far at the path: through it, past it, hardly touching, straight along it and across it.
fn aimed(
    made: Made,
    shape: &Shape,
    path: &[ControlPoint],
    to_world: &Transform,
    bounds: Bounds,
    random: &mut Random,
) -> Ray {
    if random.random_range(0..8) == 0 {
        return any_ray(shape, bounds, random);
    }
    let order = made.kind().order();
    let i = random.random_range(0..=path.len() - order);
    let [x, y, z, r] = segment(made.kind(), &path[i..i + order]);
    let u: Doubled = random.random::<f64>().into();
    let vector = |p: [&Polynomial; 3]| Vec3::from_array(p.map(|p| p.at(u).high));
    let middle = to_world.point(vector([&x, &y, &z]));
    let slopes = [&x, &y, &z].map(Polynomial::derivative);
    let ahead = to_world.vector(vector(slopes.each_ref())).try_normalize().unwrap_or(Vec3::X);
    let radius = r.at(u).high * to_world.vector(Vec3::X).length();
    let toward = match random.random_range(0..4) {
        0 => (ahead + direction(random) * 10f64.powf(random.random_range(-3.0..0.0))).normalize(),
        1 => direction(random).cross(ahead).try_normalize().unwrap_or(Vec3::Y),
        _ => direction(random),
    };
    let side = direction(random).reject_from_normalized(toward).try_normalize().unwrap_or(Vec3::ZERO);
    let off = match random.random_range(0..3) {
        0 => radius * (1.0 + 10f64.powf(random.random_range(-12.0..-1.0))),
        1 => radius * (1.0 - 10f64.powf(random.random_range(-12.0..-1.0))),
        _ => radius * random.random_range(0.0..1.5),
    };
    let distance = match random.random_range(0..6) {
        0 => 0.0,
        1 => 1e3,
        2 => 1e6,
        _ => random.random_range(-5.0..5.0),
    };
    Ray::new(middle + side * off - toward * distance, toward)
}

fn check_all(rays: u32) {
    let mut seed = 0;
    for made in Made::ALL {
        let (mut doubtful, mut worst) = (0, 0.0f64);
        let mut count = 0;
        for (name, path) in paths() {
            let skew = placement(Vec3::new(0.9, 0.5, 0.3));
            let places = if matches!(made, Made::Swept(_)) {
                vec![Transform::IDENTITY, skew]
            } else {
                // Radii do not follow.
                vec![Transform::IDENTITY]
            };
            for to_world in places.iter().chain(if places.len() == 1 { &places[..] } else { &[] }) {
                seed += 1;
                let (left, off) = check(name, made, to_world, &path, rays, seed);
                doubtful += left;
                worst = worst.max(off);
                count += rays;
            }
        }
        println!(
            "{made:?}: {doubtful} of {count} rays touch within rounding; t is off by {worst:.1e} of itself and the shape's size at most"
        );
        assert!(f64::from(doubtful) < 0.005 * f64::from(count), "{made:?}: {doubtful} of {count}");
    }
}

/// A wrong crossing is found wherever it is met, but for one ray in 200 at most, which touches within
/// rounding. So a fault is found with a probability of 95 % where one in 1300 rays at a kind of surface shows
/// it, or one in 130 at one path in one place: 3 over the number of rays. That a reported error of t is
/// larger than it has to be is not found; the largest true error is printed.
#[test]
fn curves_are_crossed_where_the_oracle_says() {
    check_all(crate::stress::count(200, 100_000));
}
