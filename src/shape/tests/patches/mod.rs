//! Bézier patches against elimination in numbers of 32 digits, and bodies of patches that share their
//! borders.

mod crossed;
mod resultant;

use super::leaving::{Leaving, PLACES, leave, placed};
use super::oracle::any_ray;
use super::{Random, close, direction, near, placement};
use crate::accel::Accel;
use crate::geometry::{Ray, Transform, Vec3};
use crate::shape::{ControlNet, Patches, Shape, ShapeError};
use rand::{RngExt, SeedableRng};
use std::array::from_fn;
use std::f64::consts::FRAC_PI_2;

fn shape(to_world: &Transform, patches: &[ControlNet], flip: bool) -> Shape {
    Shape::Patches(Patches::new(to_world, patches, flip).unwrap())
}

/// Patches with what is hard: without any order, with borders that are points, cusped, thin.
pub fn kinds() -> Vec<(&'static str, ControlNet)> {
    let mut random = Random::seed_from_u64(31);
    let mut any = move |low: f64, high: f64| random.random_range(low..high);
    let grid = |k: usize| [k % 4, k / 4].map(|i| i as f64 / 3.0);
    let sail = from_fn(|k| Vec3::new(grid(k)[0], grid(k)[1], any(-0.3, 0.3)));
    let folded = from_fn(|k| {
        let [x, y] = grid(k);
        Vec3::new(x + any(-0.2, 0.2), y + any(-0.2, 0.2), any(-0.6, 0.6))
    });
    let tangled = from_fn(|_| Vec3::new(any(-1.0, 1.0), any(-1.0, 1.0), any(-1.0, 1.0)));
    let other = from_fn(|_| Vec3::new(any(-1.0, 1.0), any(-1.0, 1.0), any(-1.0, 1.0)));
    // A quarter of a lid: its border at v = 0 is a point.
    let lid = from_fn(|k| {
        let ([u, v], row) = (grid(k), (k / 4) as f64);
        let (sin, cos) = (u * FRAC_PI_2).sin_cos();
        let bulge = if row == 1.0 { 0.0 } else { -0.1 * row * row };
        Vec3::new(v * cos, v * sin, 1.0 + bulge)
    });
    // Two borders that are points.
    let lens = from_fn(|k| {
        let ([u, v], column) = (grid(k), k % 4);
        let y = if column == 0 || column == 3 { 0.5 } else { v };
        Vec3::new(u, y, 0.4 * u * (1.0 - u) + any(0.0, 0.1) * f64::from(column == 1 || column == 2))
    });
    let needle = from_fn(|k| {
        let [u, v] = grid(k);
        Vec3::new(u, 1e-4 * v + 0.2 * u * u, 1e-4 * any(-1.0, 1.0))
    });
    vec![
        ("sail", sail),
        ("folded", folded),
        ("tangled", tangled),
        ("tangled otherwise", other),
        ("lid", lid),
        ("lens", lens),
        ("needle", needle),
    ]
}

/// Cubics around a quarter of a circle, as good as they can be.
const ROUND: f64 = 0.552_284_749_830_793_4;

/// A closed body of four quarters around z, each of as many patches as there are pieces of the profile, at
/// both ends of which it is on the axis: control points r z of cubics, each third one on the curve. With
/// `waves` it is no longer round.
pub fn turned(profile: &[[f64; 2]], waves: f64) -> Vec<ControlNet> {
    let around = |quarter: usize, i: usize| {
        // The same numbers at the end of a quarter and the beginning of the next.
        let at = (3 * quarter + i) % 12;
        let (side, place) = (at / 3, at % 3);
        let [x, y] = [[1.0, 0.0], [1.0, ROUND], [ROUND, 1.0]][place];
        [[x, y], [-y, x], [-x, -y], [y, -x]][side]
    };
    let mut patches = Vec::new();
    for quarter in 0..4 {
        for piece in profile.windows(4).step_by(3) {
            patches.push(from_fn(|k| {
                let [x, y] = around(quarter, k % 4);
                let [r, z] = piece[k / 4];
                Vec3::new(r * x, r * y * (1.0 + waves), z + waves * r * (3.0 * x).sin() * (2.0 * y).cos())
            }));
        }
    }
    patches
}

/// From the lower pole to the upper: a body with a belly, a neck and a knob.
const POT: [[f64; 2]; 13] = [
    [0.0, -1.0],
    [0.4, -1.0],
    [0.9, -0.9],
    [1.0, -0.4],
    [1.1, 0.1],
    [0.7, 0.5],
    [0.3, 0.55],
    [0.2, 0.57],
    [0.1, 0.6],
    [0.15, 0.7],
    [0.2, 0.8],
    [0.15, 0.9],
    [0.0, 0.9],
];

/// Lines at the borders and corners of the patches of closed bodies cross them at least once on each side of
/// a place within.
fn leaks(rays: u32) -> [u32; 2] {
    let bodies = [turned(&POT, 0.0), turned(&POT, 0.2)];
    let places = [Transform::IDENTITY, placement(Vec3::new(0.9, 0.5, 0.3))];
    let shapes: Vec<(Shape, Accel, &Transform, &Vec<ControlNet>)> = bodies
        .iter()
        .flat_map(|body| places.iter().map(move |place| (body, place)))
        .map(|(body, place)| {
            let shape = shape(place, body, false);
            let accel = Accel::build(std::slice::from_ref(&shape));
            (shape, accel, place, body)
        })
        .collect();
    let mut random = Random::seed_from_u64(33);
    let (mut lost, mut twice) = (0, 0);
    for i in 0..rays as usize {
        let (shape, accel, place, body) = &shapes[i % shapes.len()];
        // From within, at a border or a corner of a patch, or right beside it.
        let patch = random.random_range(0..body.len());
        let along: f64 = if random.random_range(0..4) == 0 { 0.0 } else { random.random() };
        let at = [[0.0, along], [1.0, along], [along, 0.0], [along, 1.0]][random.random_range(0..4)];
        let hit = crate::shape::Hit {
            t: 0.0,
            shape: 0,
            triangle: patch as u32,
            instance: crate::shape::NO_INSTANCE,
            barycentric: at,
        };
        let border = shape.surface(&hit, &Ray::new(Vec3::ZERO, Vec3::Z)).point.position;
        let off = match random.random_range(0..3) {
            0 => 0.0,
            _ => 10f64.powf(random.random_range(-17.0..-5.0)),
        };
        let target = border + direction(&mut random) * off;
        // The belly is convex about its middle.
        let inside = place.point(0.3 * Vec3::from_array(from_fn(|_| random.random_range(-1.0..1.0))));
        let ray = Ray::new(inside, (target - inside).normalize());
        if accel.closest(&ray, 0.0).is_none() {
            lost += 1;
        }
        // Back from outside onto the very same place.
        let far = [3.0, 1e3, 3e6][random.random_range(0..3)];
        let back = Ray::new(target + (target - inside).normalize() * far, (inside - target).normalize());
        match accel.closest(&back, 0.0) {
            Some(hit) if hit.t < far + (target - inside).length() => {}
            _ => lost += 1,
        }
        let found = shape.crossings(&back);
        twice += u32::from(!found.len().is_multiple_of(2));
    }
    [lost, twice]
}

#[test]
fn nothing_gets_through_between_patches() {
    let lines = crate::stress::count(40_000, 1_000_000);
    let [lost, twice] = leaks(lines);
    println!("{twice} of {lines} lines meet a border twice");
    assert_eq!(lost, 0);
}

/// Points are on their surface within their error, and rays that leave don't meet it where they started.
#[test]
fn hits_are_on_the_surface_and_left_behind() {
    let mut random = Random::seed_from_u64(34);
    for (scale, distance) in PLACES {
        let place = placed([scale, distance], &mut random);
        let body = turned(&POT, 0.0);
        let shape = shape(&place, &body, false);
        let unit = shape.bounds().diameter();
        for _ in 0..5_000 {
            let Some(Leaving { angle, outward, inward, .. }) = leave(&shape, &mut random) else { continue };
            if let Some(hit) = shape.intersect(&outward) {
                assert!(hit.t > 1e-4 * angle * unit, "{scale} {distance} {angle:e}: {:e}", hit.t);
            }
            assert!(shape.intersect(&inward).is_some(), "{scale} {distance} {angle:e}: {inward:?}");
        }
    }
}

/// The tree finds what a loop over all patches finds.
#[test]
fn the_tree_finds_the_nearest() {
    let shape = shape(&placement(Vec3::new(0.9, 0.5, 0.3)), &turned(&POT, 0.2), false);
    let accel = Accel::build(std::slice::from_ref(&shape));
    let mut random = Random::seed_from_u64(35);
    let mut hits = 0;
    for _ in 0..5_000 {
        let ray = any_ray(&shape, shape.bounds(), &mut random);
        let (found, expected) = (accel.closest(&ray, 0.0), shape.intersect(&ray));
        assert_eq!(found.map(|hit| hit.t), expected.map(|hit| hit.t), "{ray:?}");
        assert_eq!(accel.occluded(&ray, 0.0), expected.is_some());
        let mut crossed = Vec::new();
        accel.crossings(&ray, 0.0, [0.0, f64::INFINITY], &mut |hit, error| crossed.push((hit.t, error)));
        crossed.sort_by(|a, b| a.0.total_cmp(&b.0));
        let all = shape.crossings(&ray);
        let ahead: Vec<_> = all.iter().filter(|c| c.hit.t >= 0.0).map(|c| (c.hit.t, Some(c.error))).collect();
        assert_eq!(crossed, ahead);
        hits += u32::from(found.is_some());
    }
    assert!(hits > 1_000);
}

/// A patch whose control points lie evenly in a plane is the rectangle; raised to the third degree, a
/// bilinear one has its normals.
#[test]
fn simple_patches_are_what_they_should_be() {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(1.0, 1.0, 0.5)];
    let bilinear = |u: f64, v: f64| corners[0].lerp(corners[1], u).lerp(corners[2].lerp(corners[3], u), v);
    let patch: ControlNet = from_fn(|k| bilinear((k % 4) as f64 / 3.0, (k / 4) as f64 / 3.0));
    let [made, flipped] = [false, true].map(|flip| shape(&Transform::IDENTITY, &[patch], flip));
    let mut random = Random::seed_from_u64(36);
    for _ in 0..1_000 {
        let (u, v): (f64, f64) = (random.random(), random.random());
        let ray = Ray::new(Vec3::new(u, v, 5.0), -Vec3::Z);
        let hit = made.intersect(&ray).unwrap();
        assert!(close(hit.t, 5.0 - 0.5 * u * v, 1e-14), "{hit:?}");
        let found = made.surface(&hit, &ray);
        let normal = Vec3::new(-0.5 * v, -0.5 * u, 1.0).normalize();
        assert!(near(found.point.normal, normal, 1e-13) && near(found.shading_normal, normal, 1e-13));
        assert!(near(flipped.surface(&hit, &ray).point.normal, -normal, 1e-13));
        let here = made.parametrisation(&hit, found.point.position);
        assert!(close(here.uv[0], u, 1e-13) && close(here.uv[1], v, 1e-13));
        assert!(near(here.tangent, Vec3::new(1.0, 0.0, 0.5 * v), 1e-13));
        assert!(near(here.bitangent, Vec3::new(0.0, 1.0, 0.5 * u), 1e-13));
    }
    // ∫ √(1 + (u² + v²) / 4), by the midpoint rule.
    let at = |i: usize| ((i as f64) + 0.5) / 500.0;
    let element = |i: usize| (1.0 + 0.25 * (at(i % 500).powi(2) + at(i / 500).powi(2))).sqrt();
    let area = (0..250_000).map(element).sum::<f64>() / 250_000.0;
    assert!(close(made.area(), area, 1e-6), "{} {area}", made.area());
    // In its plane, past it and along it: nothing is met.
    let flat: ControlNet = from_fn(|k| Vec3::new((k % 4) as f64, (k / 4) as f64, 0.0));
    let flat = shape(&Transform::IDENTITY, &[flat], false);
    assert!(flat.crossings(&Ray::new(Vec3::new(-1.0, 1.5, 0.0), Vec3::X)).is_empty());
    assert!(flat.crossings(&Ray::new(Vec3::ZERO, Vec3::NAN)).is_empty());
    assert_eq!(flat.crossings(&Ray::new(Vec3::new(1.5, 1.5, 1.0), Vec3::Z)).len(), 1);
}

/// A normal is there also where a border is a point, and it is that of the lid's neighbours.
#[test]
fn poles_have_normals() {
    let lid = kinds().into_iter().find(|kind| kind.0 == "lid").unwrap().1;
    let shape = shape(&Transform::IDENTITY, &[lid], false);
    for (x, y) in [(0.0, 0.0), (1e-14, 1e-14), (1e-9, 1e-10), (1e-6, 1e-6)] {
        let ray = Ray::new(Vec3::new(x, y, 3.0), -Vec3::Z);
        let hit = shape.intersect(&ray).unwrap();
        let normal = shape.surface(&hit, &ray).point.normal;
        assert!(near(normal.abs(), Vec3::Z, 1e-4), "{x} {y}: {normal}");
    }
}

#[test]
fn what_is_no_patch_is_refused() {
    let made = |patches: &[ControlNet]| Patches::new(&Transform::IDENTITY, patches, false).err();
    assert_eq!(made(&[]), Some(ShapeError::Nothing));
    assert_eq!(made(&[[Vec3::splat(f64::NAN); 16]]), Some(ShapeError::Placement));
    // All in one point: nothing is met.
    let point = shape(&Transform::IDENTITY, &[[Vec3::ONE; 16]], false);
    assert!(point.crossings(&Ray::new(Vec3::ZERO, Vec3::ONE.normalize())).is_empty());
    assert!(point.sample([0.5; 2]).is_none());
}
