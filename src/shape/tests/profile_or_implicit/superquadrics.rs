//! Superquadrics whose powers are whole numbers.

use super::{new_shape, superquadric};
use crate::geometry::{Ray, Transform, Vec3};
use crate::shape::ProfileOrImplicitKind;
use crate::shape::tests::doubled::{Doubled, Polynomial};
use crate::shape::tests::oracle::{Exact, Line, SURE_FROM, check_against, near};
use crate::shape::tests::{close, placement};

/// The function's polynomials where the line is in one octant and their crossings there: for powers that are
/// whole numbers.
fn superellipsoid(line: &Line, [e1, e2]: [f64; 2], semi_axes: Vec3) -> (Vec<(Doubled, bool)>, f64) {
    let (power, outer) = ((2.0 / e2).round() as usize, (e2 / e1).round() as usize);
    let scaled =
        [0, 1, 2].map(|k| Polynomial(line.0[k].0.iter().map(|&c| c / semi_axes[k].into()).collect()));
    let mut ends: Vec<f64> =
        scaled.iter().map(|p| -(p.0[0] / p.0[1]).high).filter(|t| t.is_finite()).collect();
    ends.extend([-1e9, 1e9]);
    ends.sort_by(f64::total_cmp);
    let (mut found, mut doubt) = (Vec::new(), f64::INFINITY);
    let raised = |p: &Polynomial, power: usize| (1..power).fold(p.clone(), |product, _| &product * p);
    for pair in ends.windows(2) {
        let middle = Doubled::from(0.5 * (pair[0] + pair[1]));
        let size = scaled.each_ref().map(|p| p.scaled(if p.at(middle).high < 0.0 { -1.0 } else { 1.0 }));
        let across = &raised(&size[0], power) + &raised(&size[1], power);
        let along = raised(&size[2], power * outer);
        let function = &(&raised(&across, outer) + &along) - &Polynomial::constant(1.0);
        let slope = function.derivative();
        // Each octant to itself, where the function is convex.
        for t in function.roots([pair[0], pair[1]]) {
            found.push((t, slope.at(t).high < 0.0));
        }
        for t in slope.roots([pair[0], pair[1]]).into_iter().chain([pair[0].into()]) {
            doubt = doubt.min(function.at(t).high.abs());
        }
    }
    found.sort_by(|a, b| (a.0 - b.0).high.total_cmp(&0.0));
    (found, doubt)
}

fn check_superquadrics(rays: u32) {
    let shapes = [[1.0, 1.0], [0.5, 0.5], [0.5, 1.0], [2.0, 2.0], [1.0, 2.0], [0.25, 0.5], [0.2, 0.2]];
    for (i, exponents) in shapes.into_iter().enumerate() {
        for (j, to_world) in
            [Transform::IDENTITY, placement(Vec3::new(0.9, 0.5, 0.3))].into_iter().enumerate()
        {
            let kind = superquadric(exponents[0], exponents[1]);
            let ProfileOrImplicitKind::Superquadric { semi_axes, .. } = kind else { unreachable!() };
            let exact = |ray: &Ray| {
                let (found, _) = superellipsoid(&Line::new(ray, &to_world), exponents, semi_axes);
                found.into_iter().map(|(t, enters)| Exact { t: t + near(ray).into(), enters }).collect()
            };
            let doubt = |ray: &Ray| superellipsoid(&Line::new(ray, &to_world), exponents, semi_axes).1;
            let shape = new_shape(&to_world, &kind);
            let name = format!("superquadric {exponents:?}");
            check_against(&name, &shape, exact, doubt, rays, (10 * i + j) as u64).tell(&name, SURE_FROM);
        }
    }
}

#[test]
fn superquadrics_are_crossed_where_the_oracle_says() {
    check_superquadrics(crate::stress::count(2_500, 72_000));
}

/// Exponents of 2 make an octahedron, eight triangles: the edges run across a square grid by its diagonals.
#[test]
fn the_area_of_an_octahedron_is_that_of_its_triangles() {
    let kind = superquadric(2.0, 2.0);
    let ProfileOrImplicitKind::Superquadric { semi_axes: a, .. } = kind else { unreachable!() };
    let expected = 4.0 * (a.x * a.y).hypot(a.y * a.z).hypot(a.z * a.x);
    let area = new_shape(&Transform::IDENTITY, &kind).area();
    assert!(close(area / expected, 1.0, 5e-4), "{area} {expected}");
}
