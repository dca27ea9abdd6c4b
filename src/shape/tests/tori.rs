//! What is particular to tori.

use super::doubled::Polynomial;
use super::leaving::{Leaving, PLACES, leave, placed};
use super::oracle::{Functions, Line, Oracle, SURE_FROM, Tally, any_ray, check};
use super::{close, near, placement};
use crate::geometry::{Ray, Transform, Vec3};
use crate::shape::{Shape, ShapeError, Torus};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg as Random;
use std::f64::consts::PI;

fn torus(to_world: &Transform, major: f64, minor: f64) -> Shape {
    Shape::Torus(Box::new(Torus::new(to_world, major, minor, false).unwrap()))
}

/// (x² + y² + z² + major² − minor²)² − 4 major² (x² + y²)
fn quartic(major: f64, minor: f64) -> Functions {
    Box::new(move |Line([x, y, z])| {
        let across = &(x * x) + &(y * y);
        let radii = &Polynomial::constant(major * major) - &Polynomial::constant(minor * minor);
        let sum = &(&across + &(z * z)) + &radii;
        vec![&(&sum * &sum) - &across.scaled(4.0 * major * major)]
    })
}

fn check_tori(rays: u32) {
    let mut tally = Tally::default();
    // Dyadic radii, whose squares the oracle has exactly.
    for (i, (major, minor)) in [(0.75, 0.25), (1.0, 0.9375), (2.0, 0.015625)].into_iter().enumerate() {
        for (j, to_world) in
            [Transform::IDENTITY, placement(Vec3::new(0.9, 0.5, 0.3))].into_iter().enumerate()
        {
            let oracle = Oracle { functions: quartic(major, minor), solid: true };
            let shape = torus(&to_world, major, minor);
            tally += check("torus", &shape, &oracle, &to_world, rays, (2 * i + j) as u64);
        }
    }
    tally.tell("tori", SURE_FROM);
}

#[test]
fn tori_are_crossed_where_the_oracle_says() {
    check_tori(crate::stress::count(8_000, 170_000));
}

/// Four crossings in the plane of the ring, two down through the tube, none through the hole; the volume is
/// 2π² major minor².
#[test]
fn lines_cross_a_ring_up_to_four_times() {
    let (major, minor) = (1.0, 0.25);
    let shape = torus(&Transform::IDENTITY, major, minor);
    let along = |origin, direction| -> Vec<f64> {
        shape.crossings(&Ray::new(origin, direction)).iter().map(|crossing| crossing.hit.t).collect()
    };
    let found = along(Vec3::new(0.5, 0.0, 0.0), Vec3::X);
    for (t, expected) in found.iter().zip([-1.75, -1.25, 0.25, 0.75]) {
        assert!(close(*t, expected, 1e-14), "{found:?}");
    }
    assert_eq!(found.len(), 4);
    assert!(along(Vec3::new(0.0, 0.0, 3.0), -Vec3::Z).is_empty());
    assert_eq!(along(Vec3::new(1.0, 0.0, 3.0), -Vec3::Z).len(), 2);
    // The volume by the lengths of chords along y, whose share of the box is known by its standard error.
    let mut random = Random::seed_from_u64(1);
    let (count, mut mean, mut square) = (200_000, 0.0, 0.0);
    for _ in 0..count {
        let (x, z) = (random.random_range(-1.25..1.25), random.random_range(-0.25..0.25));
        let chord: f64 = along(Vec3::new(x, 0.0, z), Vec3::Y).chunks(2).map(|pair| pair[1] - pair[0]).sum();
        mean += chord * 2.5 * 0.5 / f64::from(count);
        square += (chord * 2.5 * 0.5).powi(2) / f64::from(count);
    }
    let error = ((square - mean * mean) / f64::from(count)).sqrt();
    let volume = 2.0 * PI * PI * major * minor * minor;
    assert!(close(mean, volume, 4.0 * error), "{mean} ± {error}, {volume}");
    assert!(close(shape.area(), 4.0 * PI * PI * major * minor, 1e-12));
}

#[test]
fn coordinates_and_tangents() {
    let shape = torus(&Transform::IDENTITY, 1.0, 0.25);
    let down = Ray::new(Vec3::new(0.0, 1.0, 2.0), -Vec3::Z);
    let hit = shape.intersect(&down).unwrap();
    let found = shape.surface(&hit, &down);
    assert!(
        near(found.point.position, Vec3::new(0.0, 1.0, 0.25), 1e-15)
            && near(found.point.normal, Vec3::Z, 1e-15)
    );
    let here = shape.parametrisation(&hit, found.point.position);
    assert!(close(here.uv[0], 0.25, 1e-14) && close(here.uv[1], 0.25, 1e-14), "{here:?}");
    assert!(
        near(here.tangent, -Vec3::X * 2.0 * PI, 1e-13) && near(here.bitangent, -Vec3::Y * 0.5 * PI, 1e-13)
    );
}

/// Rays that leave the outside of the tube don't meet it where they started; such as go in come out again.
#[test]
fn no_ring_is_met_where_it_is_left() {
    let mut random = Random::seed_from_u64(3);
    for minor in [0.25, 0.9, 0.01] {
        for (scale, distance) in PLACES {
            let shape = torus(&placed([scale, distance], &mut random), 1.0, minor);
            for _ in 0..20_000 {
                let Leaving { angle, outward, inward, .. } = leave(&shape, &mut random).unwrap();
                if let Some(hit) = shape.intersect(&outward) {
                    assert!(hit.t > 1e-3 * angle * scale * minor, "{minor} {scale} {angle:e}: {:e}", hit.t);
                }
                let ahead = shape.crossings(&inward).iter().filter(|crossing| crossing.hit.t >= 0.0).count();
                assert!(ahead % 2 == 1, "{minor} {scale} {angle:e}");
            }
        }
    }
}

#[test]
fn what_is_no_ring_is_refused() {
    let made = |major, minor| Torus::new(&Transform::IDENTITY, major, minor, false).err();
    assert_eq!(made(1.0, 1.0), Some(ShapeError::Tube { major: 1.0, minor: 1.0 }));
    assert_eq!(made(0.0, 1.0), Some(ShapeError::Radius(0.0)));
    assert!(matches!(made(1.0, f64::NAN), Some(ShapeError::Radius(_))));
    let mut random = Random::seed_from_u64(5);
    let shape = torus(&Transform::IDENTITY, 1.0, 0.5);
    let far = any_ray(&shape, shape.bounds(), &mut random);
    assert!(shape.crossings(&Ray { direction: Vec3::NAN, ..far }).is_empty());
}
