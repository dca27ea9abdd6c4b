//! Surfaces of revolution.

use super::{double, kinds, new_shape, turned};
use crate::geometry::{Ray, Transform, Vec3};
use crate::shape::tests::doubled::{Doubled, Polynomial};
use crate::shape::tests::oracle::{Exact, Line, Tally, any_ray, check_against, near};
use crate::shape::tests::{close, placement};
use crate::shape::{Interpolation, ProfileOrImplicitKind, Shape, Sphere};
use glam::DMat3;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg as Random;

/// r and z of a profile as cubics of a parameter from 0 to 1, with its caps.
fn cubics(kind: &ProfileOrImplicitKind) -> Vec<[Polynomial; 2]> {
    let ProfileOrImplicitKind::Revolution { profile, interpolation, closed, capped } = kind else {
        unreachable!()
    };
    let count = profile.len();
    let point = |i: usize| profile[i % count].map(double);
    let bezier = |p: [[Doubled; 2]; 4]| -> [Polynomial; 2] {
        [0, 1].map(|k| {
            let [a, b, c, d] = p.map(|point| point[k]);
            let three = double(3.0);
            Polynomial(vec![a, three * (b - a), three * (a - b - b + c), d - a + three * (b - c)])
        })
    };
    let line = |a: [Doubled; 2], b: [Doubled; 2]| [0, 1].map(|k| Polynomial(vec![a[k], b[k] - a[k]]));
    let mut found: Vec<[Polynomial; 2]> = match interpolation {
        Interpolation::Linear => {
            (0..count - usize::from(!closed)).map(|i| line(point(i), point(i + 1))).collect()
        }
        Interpolation::Bezier => (0..(count - usize::from(!closed)) / 3)
            .map(|i| bezier([0, 1, 2, 3].map(|k| point(3 * i + k))))
            .collect(),
        Interpolation::BSpline => (0..if *closed { count } else { count - 3 })
            .map(|i| {
                let mix = |weights: [f64; 4]| {
                    [0, 1].map(|k| {
                        let sum =
                            (0..4).fold(double(0.0), |sum, j| sum + point(i + j)[k] * weights[j].into());
                        sum / 6.0.into()
                    })
                };
                let inner = [[0.0, 4.0, 2.0, 0.0], [0.0, 2.0, 4.0, 0.0]].map(mix);
                bezier([mix([1.0, 4.0, 1.0, 0.0]), inner[0], inner[1], mix([0.0, 1.0, 4.0, 1.0])])
            })
            .collect(),
    };
    if *capped && !closed {
        let ends = [
            found[0].each_ref().map(|p| p.at(double(0.0))),
            found[found.len() - 1].each_ref().map(|p| p.at(double(1.0))),
        ];
        for end in ends.into_iter().filter(|end| end[0].high > 0.0) {
            found.push(line([double(0.0), end[1]], end));
        }
    }
    found
}

/// By the polynomial a r² + b z² + c z + d of each piece's parameter (Glassner ch. 3, 3.3, c and d
/// corrected).
fn revolved(line: &Line, kind: &ProfileOrImplicitKind) -> (Vec<Doubled>, f64) {
    let [[x0, x1], [y0, y1], [z0, z1]] = line.0.each_ref().map(|p| [p.0[0], p.0[1]]);
    let (b, rise) = (x1 * x1 + y1 * y1, z1 * z1);
    let cross = |a: Doubled, d: Doubled| (a * z1 - z0 * d) * (a * z1 - z0 * d);
    let (c, d) = ((z1 * (x0 * x1 + y0 * y1) - z0 * b) * 2.0.into(), cross(x0, x1) + cross(y0, y1));
    let times = |p: &Polynomial, factor: Doubled| Polynomial(p.0.iter().map(|&c| c * factor).collect());
    let (mut found, mut doubt) = (Vec::new(), f64::INFINITY);
    for [r, z] in cubics(kind) {
        let squared = &r * &r;
        if z1.high.abs() < 1e-14 {
            // In a level plane, to within rounding: circles. Slopes that are less level than that but not for
            // the polynomial are not among the rays.
            let level = &z - &Polynomial(vec![z0]);
            let trimmed = Polynomial(
                level
                    .0
                    .iter()
                    .copied()
                    .take(level.0.iter().rposition(|c| c.high != 0.0).unwrap_or(0) + 1)
                    .collect(),
            );
            for s in trimmed.roots([0.0, 1.0]) {
                let circle =
                    Polynomial(vec![x0 * x0 + y0 * y0 - squared.at(s), (x0 * x1 + y0 * y1) * 2.0.into(), b]);
                found.extend(circle.roots([-1e9, 1e9]));
                doubt = doubt.min(circle.at(-(circle.0[1] / circle.0[2]) * 0.5.into()).high.abs());
            }
            for s in trimmed.derivative().roots([0.0, 1.0]).into_iter().chain([double(0.0), double(1.0)]) {
                doubt = doubt.min(level.at(s).high.abs());
            }
            continue;
        }
        let both = &times(&(&z * &z), b) + &times(&z, c);
        let function = &(&both - &times(&squared, rise)) + &Polynomial(vec![d]);
        let degree = function.0.iter().rposition(|c| c.high.abs() > 1e-40).unwrap_or(0);
        let function = Polynomial(function.0[..=degree].to_vec());
        for s in function.roots([0.0, 1.0]) {
            found.push((z.at(s) - z0) / z1);
        }
        for s in function.derivative().roots([0.0, 1.0]).into_iter().chain([double(0.0), double(1.0)]) {
            doubt = doubt.min((function.at(s) / rise).high.abs());
        }
        // Level pieces: the plane's own place on the line.
        if z.0[1..].iter().all(|c| c.high == 0.0) && degree == 0 {
            doubt = 0.0;
        }
    }
    found.sort_by(|a, b| (*a - *b).high.total_cmp(&0.0));
    (found, doubt)
}

fn check_revolutions(rays: u32) {
    let mut tally = Tally::default();
    let turned = |kind: &ProfileOrImplicitKind| matches!(kind, ProfileOrImplicitKind::Revolution { .. });
    for (i, (name, kind)) in kinds().into_iter().filter(|kind| turned(&kind.1)).enumerate() {
        for (j, to_world) in
            [Transform::IDENTITY, placement(Vec3::new(0.9, 0.5, 0.3))].into_iter().enumerate()
        {
            let shape = new_shape(&to_world, &kind);
            // Which way it goes through is told by another test.
            let exact = |ray: &Ray| {
                let found = revolved(&Line::new(ray, &to_world), &kind).0;
                let ways = shape.crossings(ray);
                let way = |i: usize| ways.get(i).is_some_and(|crossing| crossing.enters);
                let in_world = |(i, t): (usize, Doubled)| Exact { t: t + near(ray).into(), enters: way(i) };
                found.into_iter().enumerate().map(in_world).collect()
            };
            // What is told in the shape's own coordinates is shorter in the world's, in which rays are
            // rounded: by the least stretch at most.
            let inverse = DMat3::from_mat4(to_world.matrix()).inverse();
            let longest = |m: DMat3| {
                m.to_cols_array_2d().map(|c| c.iter().map(|x| x.abs()).sum()).into_iter().fold(0.0, f64::max)
            };
            let least_stretch = 1.0 / f64::sqrt(longest(inverse) * longest(inverse.transpose()));
            let doubt = |ray: &Ray| revolved(&Line::new(ray, &to_world), &kind).1 * least_stretch;
            tally += check_against(name, &shape, exact, doubt, rays, (10 * i + j) as u64);
        }
    }
    // They judge by their sharpest bend, whichever way the line goes: where it runs almost along a cone they
    // are sure only later.
    tally.tell("revolutions", 1e-7);
}

#[test]
fn revolutions_are_crossed_where_the_oracle_says() {
    check_revolutions(crate::stress::count(3_000, 125_000));
}

/// A half circle turned around z, in 64 cubics that are within 10⁻¹³ of it, is the sphere, and so is a
/// superquadric with both exponents 1: same hits, normals, u and area.
#[test]
fn a_half_circle_turned_is_a_sphere() {
    const ARCS: usize = 64;
    let angle = std::f64::consts::PI / ARCS as f64;
    let handle = 4.0 / 3.0 * (0.25 * angle).tan();
    let mut profile = vec![[0.0, -1.0]];
    for i in 0..ARCS {
        let ends = [i, i + 1].map(|k| (k as f64 * angle).sin_cos());
        let [(s0, c0), (s1, c1)] = ends;
        let end = if i + 1 == ARCS { [0.0, 1.0] } else { [s1, -c1] };
        profile.extend([[s0 + handle * c0, -c0 + handle * s0], [s1 - handle * c1, -c1 - handle * s1], end]);
    }
    let place = placement(Vec3::new(0.9, 0.5, 0.3));
    let turned = new_shape(&place, &turned(&profile, Interpolation::Bezier, false, true));
    let even = ProfileOrImplicitKind::Superquadric { exponents: [1.0; 2], semi_axes: Vec3::ONE };
    let even = new_shape(&place, &even);
    let sphere = Shape::Sphere(Sphere::new(&place, Vec3::ZERO, 1.0, false).unwrap());
    let mut random = Random::seed_from_u64(5);
    let mut hits = 0;
    for _ in 0..5_000 {
        let ray = any_ray(&sphere, sphere.bounds(), &mut random);
        let exact = sphere.crossings(&ray);
        if exact.len() < 2 || exact[1].hit.t - exact[0].hit.t < 1e-3 {
            continue;
        }
        for shape in [&turned, &even] {
            let found = shape.crossings(&ray);
            assert_eq!(found.len(), 2, "{ray:?}");
            for (a, b) in found.iter().zip(&exact) {
                assert!((a.hit.t - b.hit.t).abs() < a.error + b.error + 1e-9, "{a:?} {b:?}");
                let (p, q) = (shape.surface(&a.hit, &ray).point, sphere.surface(&b.hit, &ray).point);
                assert!(p.normal.distance(q.normal) < 1e-6 * (1.0 + ray.origin.length() * 1e-3));
                let uv = shape.parametrisation(&a.hit, p.position).uv;
                let expected = sphere.parametrisation(&b.hit, p.position).uv;
                assert!(close(uv[0], expected[0], 1e-9) || (uv[0] - expected[0]).abs() > 1.0 - 1e-9);
                // The profile goes up, a sphere's v down.
                let v = if std::ptr::eq(shape, &turned) { 1.0 - uv[1] } else { uv[1] };
                assert!(close(v, expected[1], 1e-4), "{v} {}", expected[1]);
            }
        }
        hits += 1;
    }
    assert!(hits > 1_000);
    for shape in [&turned, &even] {
        assert!(close(shape.area() / sphere.area(), 1.0, 1e-3), "{} {}", shape.area(), sphere.area());
    }
}
