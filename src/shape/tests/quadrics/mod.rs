//! What is particular to quadrics.

mod crossed;

use super::leaving::{Leaving, PLACES, leave, placed};
use super::{close, near, placement};
use crate::geometry::{Bounds, Ray, Transform, Vec3};
use crate::shape::{Quadric, QuadricKind, Shape, ShapeError, Sheets, Sphere};
use glam::DMat4;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg as Random;
use std::f64::consts::PI;

fn make(kind: &QuadricKind, solid: bool) -> Result<Quadric, ShapeError> {
    Quadric::of_kind(&Transform::IDENTITY, kind, solid, false)
}

fn cone(radii: [f64; 2]) -> QuadricKind {
    QuadricKind::Cone { from: Vec3::ZERO, to: Vec3::Z, radii }
}

fn general(coefficients: [f64; 10], min: Vec3, max: Vec3) -> QuadricKind {
    QuadricKind::General { coefficients, clip: Bounds { min, max } }
}

const ENDLESS: [Vec3; 2] = [Vec3::NEG_INFINITY, Vec3::INFINITY];

/// Closed forms: the mantle of a cone π r s, its base π r², of a paraboloid π r/(6h²)·((r² + 4h²)^1.5 − r³).
#[test]
fn areas_are_those_of_closed_forms() {
    let slant = 2f64.sqrt();
    let paraboloid = QuadricKind::Paraboloid { from: Vec3::ZERO, to: Vec3::Z * 2.0, radius: 1.0 };
    let (r, h) = (1.0, 2.0f64);
    let bowl = PI * r / (6.0 * h * h) * ((r * r + 4.0 * h * h).powf(1.5) - r * r * r);
    let cases = [
        (make(&cone([1.0, 0.0]), false), PI * slant),
        (make(&cone([1.0, 0.0]), true), PI * (slant + 1.0)),
        (make(&cone([0.5, 0.5]), true), PI * 1.5),
        (make(&paraboloid, false), bowl),
        (make(&paraboloid, true), bowl + PI),
    ];
    for (i, (quadric, expected)) in cases.into_iter().enumerate() {
        let area = quadric.unwrap().area();
        assert!(close(area / expected, 1.0, 5e-4), "case {i}: {area} {expected}");
    }
}

/// The mean of 1 / density over the unit square is the area, by its own standard error, which is below 2 % of
/// it; and the density at a point is that with which it was sampled.
#[test]
fn densities_are_those_of_the_samples() {
    let mut random = Random::seed_from_u64(5);
    for (name, shape) in super::all_shapes() {
        if !super::by_random_lines(&shape) {
            continue;
        }
        let count = crate::stress::count(12_000, 400_000);
        let (mut mean, mut square) = (0.0, 0.0);
        for _ in 0..count {
            let Some(sample) = shape.sample([random.random(), random.random()]) else { continue };
            let reported = shape.area_density(&sample.surface.point);
            assert!(close(reported / sample.density, 1.0, 1e-9), "{name}: {reported} {}", sample.density);
            mean += 1.0 / (sample.density * f64::from(count));
            square += (1.0 / sample.density).powi(2) / f64::from(count);
        }
        let error = ((square - mean * mean) / f64::from(count)).sqrt();
        let area = shape.area();
        assert!(error < 0.02 * area, "{name}: {mean} ± {error}");
        assert!(close(mean, area, 4.0 * error + 5e-4 * area), "{name}: {mean} ± {error}, {area}");
    }
}

/// An ellipsoid by its coefficients is the image of a sphere: same hits, normals, bounds.
#[test]
fn an_ellipsoid_is_an_ellipsoid() {
    let kind = general([1.0, 4.0, 0.25, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0], ENDLESS[0], ENDLESS[1]);
    let place = placement(Vec3::new(0.9, 0.5, 0.3));
    let quadric = Shape::Quadric(Box::new(Quadric::of_kind(&place, &kind, false, false).unwrap()));
    let scale = Transform::new(DMat4::from_scale(Vec3::new(1.0, 0.5, 2.0))).unwrap();
    let ball = Shape::Sphere(Sphere::new(&scale.then(&place), Vec3::ZERO, 1.0, false).unwrap());
    let (a, around) = (quadric.bounds(), ball.bounds());
    assert!(
        (a.min - around.min).abs().max((a.max - around.max).abs()).max_element() < 2e-3 * around.diameter(),
        "{a:?} {around:?}"
    );
    let mut random = Random::seed_from_u64(1);
    let mut hits = 0;
    for _ in 0..20_000 {
        let ray = super::oracle::any_ray(&ball, around, &mut random);
        let (a, b) = (quadric.crossings(&ray), ball.crossings(&ray));
        let Some(apart) = b.last().map(|last| last.hit.t - b[0].hit.t).filter(|&apart| apart > 1e-3) else {
            continue;
        };
        assert_eq!(a.len(), 2, "{apart}");
        for (a, b) in a.iter().zip(&b) {
            assert!((a.hit.t - b.hit.t).abs() <= a.error + b.error && a.enters == b.enters);
            let (p, q) = (quadric.surface(&a.hit, &ray), ball.surface(&b.hit, &ray));
            assert!(near(p.point.normal, q.point.normal, 1e-7 * (1.0 + ray.origin.length() * 1e-3)));
        }
        hits += 1;
    }
    assert!(hits > 5_000);
}

/// u goes once around and v from the first end to the second; tangents are the derivatives.
#[test]
fn coordinates_and_tangents() {
    let mut random = Random::seed_from_u64(2);
    for (name, shape) in super::all_shapes() {
        if !matches!(shape, Shape::Quadric(_)) {
            continue;
        }
        let mut seen = 0;
        for _ in 0..500 {
            let Some(sample) = shape.sample([random.random(), random.random()]) else { continue };
            let hit = crate::shape::Hit {
                t: 0.0,
                shape: 0,
                triangle: sample.triangle,
                instance: crate::shape::NO_INSTANCE,
                barycentric: [0.0; 2],
            };
            let point = sample.surface.point;
            let here = shape.parametrisation(&hit, point.position);
            let [u, v] = here.uv;
            assert!((-1e-3..1.001).contains(&u) && (-1e-3..1.001).contains(&v), "{name}: {u} {v}");
            for (along, moved) in [(here.tangent, [1.0, 0.0]), (here.bitangent, [0.0, 1.0])] {
                if along.length() < 0.1 || along.length() > 10.0 {
                    continue;
                }
                assert!(along.dot(point.normal).abs() < 1e-9 * along.length(), "{name}: not in the surface");
                let step = 1e-6;
                let [a, b] = shape.parametrisation(&hit, point.position + along * step).uv;
                let change = [(a - u + 0.5).rem_euclid(1.0) - 0.5, b - v].map(|d| d / step);
                assert!(
                    close(change[0], moved[0], 1e-3) && close(change[1], moved[1], 1e-3),
                    "{name}: {change:?}"
                );
                seen += 1;
            }
        }
        assert!(seen > 100, "{name}");
    }
    let down = Ray::new(Vec3::new(0.3, 0.0, 5.0), -Vec3::Z);
    let shape = Shape::Quadric(Box::new(make(&cone([1.0, 0.0]), true).unwrap()));
    let crossings = shape.crossings(&down);
    assert_eq!(crossings.len(), 2);
    let hit = crossings[0].hit;
    assert!(near(
        shape.surface(&hit, &down).point.normal,
        Vec3::new(0.5f64.sqrt(), 0.0, 0.5f64.sqrt()),
        1e-14
    ));
    assert!(close(shape.parametrisation(&hit, down.at(hit.t)).uv[1], 0.7, 1e-14));
    assert_eq!(shape.surface(&crossings[1].hit, &down).point.normal, -Vec3::Z);
}

/// Rays that leave a surface don't meet it where they started, at all angles down to 10⁻⁴ rad, at all scales
/// and far from the origin; those that go into a solid leave it again.
#[test]
fn no_surface_is_met_where_it_is_left() {
    let mut random = Random::seed_from_u64(3);
    let kinds = [
        cone([0.7, 0.0]),
        cone([0.3, 0.5]),
        QuadricKind::Paraboloid { from: Vec3::ZERO, to: Vec3::Z, radius: 0.75 },
        QuadricKind::Hyperboloid { sheets: Sheets::One, radius: 0.25, semi_axis: 0.5, heights: [-1.0, 0.5] },
        QuadricKind::Hyperboloid {
            sheets: Sheets::Two,
            radius: 0.25,
            semi_axis: 0.25,
            heights: [-1.0, 0.75],
        },
        general([1.0, 2.0, 3.0, 0.5, -0.25, 0.75, 1.0, -2.0, 0.5, -1.0], ENDLESS[0], ENDLESS[1]),
    ];
    for kind in &kinds {
        for (scale, distance) in PLACES {
            let place = placed([scale, distance], &mut random);
            let shape = Shape::Quadric(Box::new(Quadric::of_kind(&place, kind, true, false).unwrap()));
            for _ in 0..20_000 {
                let Some(Leaving { angle, outward, inward, .. }) = leave(&shape, &mut random) else {
                    continue;
                };
                // What curves towards the ray is met again, but never at once.
                if let Some(hit) = shape.intersect(&outward) {
                    assert!(
                        hit.t > 1e-3 * angle * scale,
                        "{kind:?} {scale} {angle:e}: met again at {:e}",
                        hit.t
                    );
                }
                let crossings = shape.crossings(&inward);
                let ahead = crossings.iter().filter(|crossing| crossing.hit.t >= 0.0).count();
                // At the rim's very edge there may be nothing to go into.
                let behind = crossings.iter().rfind(|crossing| crossing.hit.t < 0.0);
                let near_rim = behind.is_none_or(|behind| behind.hit.t.abs() > 1e-6 * scale);
                assert!(ahead % 2 == 1 || near_rim, "{kind:?} {scale} {angle:e}: {crossings:?}");
            }
        }
    }
}

#[test]
fn what_is_no_quadric_is_refused() {
    let refused = |kind: &QuadricKind| make(kind, true).err();
    assert_eq!(refused(&cone([0.0, 0.0])), Some(ShapeError::Radius(0.0)));
    assert_eq!(refused(&cone([1.0, -1.0])), Some(ShapeError::Radius(-1.0)));
    let point = QuadricKind::Paraboloid { from: Vec3::X, to: Vec3::X, radius: 1.0 };
    assert_eq!(refused(&point), Some(ShapeError::Ends));
    assert_eq!(refused(&general([0.0; 10], ENDLESS[0], ENDLESS[1])), Some(ShapeError::Coefficients));
    let tube = [1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0];
    assert_eq!(refused(&general(tube, ENDLESS[0], ENDLESS[1])), Some(ShapeError::Endless));
    assert!(make(&general(tube, ENDLESS[0].with_z(0.0), ENDLESS[1].with_z(2.0)), true).is_ok());
    let imaginary = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    assert_eq!(refused(&general(imaginary, -Vec3::ONE, Vec3::ONE)), Some(ShapeError::Nothing));
    let sphere = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0];
    assert_eq!(refused(&general(sphere, Vec3::splat(2.0), Vec3::splat(3.0))), Some(ShapeError::Nothing));
    // Outside of a sphere there is no end.
    assert_eq!(refused(&general(sphere.map(|c| -c), ENDLESS[0], ENDLESS[1])), Some(ShapeError::Endless));
}
