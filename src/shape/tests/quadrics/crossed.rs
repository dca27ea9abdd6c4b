//! All crossings of quadrics and spheres against the oracle.

use crate::geometry::{Bounds, Ray, Transform, Vec3};
use crate::shape::tests::doubled::{Doubled, Polynomial};
use crate::shape::tests::oracle::{Functions, Line, Oracle, SURE_FROM, Tally, check, near};
use crate::shape::tests::{direction, placement};
use crate::shape::{Quadric, QuadricKind, Shape, Sheets, Sphere};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg as Random;

fn plane(coordinate: &Polynomial, low: f64, high: f64) -> [Polynomial; 2] {
    [&Polynomial::constant(low) - coordinate, coordinate - &Polynomial::constant(high)]
}

/// All kinds of quadrics with what they are by definition.
fn quadrics() -> Vec<(&'static str, QuadricKind, Functions)> {
    let (from, to) = (Vec3::new(-0.5, 0.1, 0.2), Vec3::new(0.4, 0.7, 0.9));
    let cone = |from: Vec3, to: Vec3, radii: [f64; 2]| -> Functions {
        Box::new(move |line| {
            let away = line.minus(from);
            let axis = [0, 1, 2].map(|i| Doubled::from(to[i]) - from[i].into());
            let squared = axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2];
            let scale =
                |p: &Polynomial, factor: Doubled| Polynomial(p.0.iter().map(|&c| c * factor).collect());
            let sum = [0, 1, 2].map(|i| scale(&away.0[i], axis[i] / squared));
            let height = &(&sum[0] + &sum[1]) + &sum[2];
            let radius =
                &Polynomial::constant(radii[0]) + &scale(&height, Doubled::from(radii[1]) - radii[0].into());
            let across = &away.dot(&away) - &scale(&(&height * &height), squared);
            let [low, high] = plane(&height, 0.0, 1.0);
            vec![&across - &(&radius * &radius), low, high]
        })
    };
    let hyperboloid = |sign: f64, radius: f64, semi_axis: f64, heights: [f64; 2]| -> Functions {
        Box::new(move |line| {
            let [x, y, z] = &line.0;
            let z_part = (z * z).scaled(radius * radius / (semi_axis * semi_axis));
            let form = &(&(x * x) + &(y * y)) - &(&z_part + &Polynomial::constant(sign * radius * radius));
            let [low, high] = plane(z, heights[0], heights[1]);
            vec![form, low, high]
        })
    };
    let general = |c: [f64; 10], low: Vec3, high: Vec3| -> Functions {
        Box::new(move |line| {
            let [x, y, z] = &line.0;
            let terms = [
                x * x,
                y * y,
                z * z,
                x * y,
                x * z,
                y * z,
                x.clone(),
                y.clone(),
                z.clone(),
                Polynomial::constant(1.0),
            ];
            let form =
                terms.iter().zip(c).fold(Polynomial::constant(0.0), |sum, (term, c)| &sum + &term.scaled(c));
            let mut functions = vec![form];
            for axis in 0..3 {
                if low[axis].is_finite() {
                    functions.extend(plane(&line.0[axis], low[axis], high[axis]));
                }
            }
            functions
        })
    };
    let clip = |min, max| Bounds { min, max };
    let everywhere = clip(Vec3::NEG_INFINITY, Vec3::INFINITY);
    let ellipsoid = [1.0, 2.0, 3.0, 0.5, -0.25, 0.75, 1.0, -2.0, 0.5, -1.0];
    let saddle = [1.0, -1.0, 0.0, 0.25, 0.0, 0.0, 0.0, 0.125, -1.0, 0.0];
    let tilted = [1.0, 0.5, -1.0, 0.5, 0.25, -1.0, 0.25, -0.5, 0.125, -0.25];
    let (low, high) = (Vec3::new(-1.0, -0.75, -0.5), Vec3::new(0.75, 1.0, 1.25));
    vec![
        ("cone", QuadricKind::Cone { from, to, radii: [0.5, 0.0] }, cone(from, to, [0.5, 0.0])),
        ("frustum", QuadricKind::Cone { from, to, radii: [0.2, 0.6] }, cone(from, to, [0.2, 0.6])),
        ("capped cylinder", QuadricKind::Cone { from, to, radii: [0.3; 2] }, cone(from, to, [0.3; 2])),
        (
            "paraboloid",
            QuadricKind::Paraboloid { from: Vec3::ZERO, to: Vec3::Z * 2.0, radius: 0.75 },
            Box::new(|line| {
                let [x, y, z] = &line.0;
                let [low, high] = plane(z, 0.0, 2.0);
                vec![&(&(x * x) + &(y * y)) - &z.scaled(0.75 * 0.75 / 2.0), low, high]
            }),
        ),
        (
            "hyperboloid of one sheet",
            QuadricKind::Hyperboloid {
                sheets: Sheets::One,
                radius: 0.25,
                semi_axis: 0.5,
                heights: [-1.0, 0.5],
            },
            hyperboloid(1.0, 0.25, 0.5, [-1.0, 0.5]),
        ),
        (
            "hyperboloid of two sheets",
            QuadricKind::Hyperboloid {
                sheets: Sheets::Two,
                radius: 0.25,
                semi_axis: 0.25,
                heights: [-1.0, 0.75],
            },
            hyperboloid(-1.0, 0.25, 0.25, [-1.0, 0.75]),
        ),
        (
            "ellipsoid",
            QuadricKind::General { coefficients: ellipsoid, clip: everywhere },
            general(ellipsoid, Vec3::NEG_INFINITY, Vec3::INFINITY),
        ),
        (
            "saddle",
            QuadricKind::General { coefficients: saddle, clip: clip(low, high) },
            general(saddle, low, high),
        ),
        (
            "tilted hyperboloid",
            QuadricKind::General { coefficients: tilted, clip: clip(low, high) },
            general(tilted, low, high),
        ),
    ]
}

fn check_quadrics(rays: u32) {
    let mut seed = 0;
    let mut tally = Tally::default();
    for (name, kind, _) in quadrics() {
        for solid in [false, true] {
            for to_world in [Transform::IDENTITY, placement(Vec3::new(0.9, 0.5, 0.3))] {
                let functions = quadrics().into_iter().find(|quadric| quadric.0 == name).unwrap().2;
                let shape =
                    Shape::Quadric(Box::new(Quadric::of_kind(&to_world, &kind, solid, false).unwrap()));
                seed += 1;
                tally += check(name, &shape, &Oracle { functions, solid }, &to_world, rays, seed);
            }
        }
    }
    tally.tell("quadrics", SURE_FROM);
}

#[test]
fn quadrics_are_crossed_where_the_oracle_says() {
    check_quadrics(crate::stress::count(12_000, 250_000));
}

fn ball(line: &Line) -> Vec<Polynomial> {
    vec![&line.dot(line) - &Polynomial::constant(1.0)]
}

/// Sphere and ellipsoid, and the unit sphere from 10⁶ with a relative error below 10⁻⁹ and within its own
/// bound.
#[test]
fn spheres_are_crossed_where_the_oracle_says() {
    for (i, to_world) in [Transform::IDENTITY, placement(Vec3::new(0.9, 0.5, 0.3))].into_iter().enumerate() {
        let shape = Shape::Sphere(Sphere::new(&to_world, Vec3::ZERO, 1.0, false).unwrap());
        let oracle = Oracle { functions: Box::new(ball), solid: true };
        check("sphere", &shape, &oracle, &to_world, 100_000, i as u64);
    }
    let shape = Shape::Sphere(Sphere::new(&Transform::IDENTITY, Vec3::ZERO, 1.0, false).unwrap());
    let mut random = Random::seed_from_u64(4);
    for _ in 0..10_000 {
        let (from, at) =
            (direction(&mut random) * 1e6, direction(&mut random) * random.random_range(0.0..0.999));
        let ray = Ray::new(from, (at - from).normalize());
        let found = shape.crossings(&ray);
        let line = Line::new(&ray, &Transform::IDENTITY);
        let exact = ball(&line)[0].roots([-1e9, 1e9]);
        assert_eq!((found.len(), exact.len()), (2, 2));
        for (crossing, exact) in found.iter().zip(exact) {
            let exact = exact + near(&ray).into();
            let off = (Doubled::from(crossing.hit.t) - exact).high.abs();
            assert!(off <= crossing.error && off / exact.high < 1e-9, "{off} {crossing:?}");
        }
    }
}
