mod fans;
mod instances;
mod nested;
mod rays;

use super::{Accel, Tests};
use crate::geometry::{Bounds, Frame, Ray, SurfacePoint, Transform, Vec3};
use crate::lanes::{LANES, Mask};
use crate::shape::tests::icosphere;
use crate::shape::{ControlPoint, CurveKind, Curves, Cylinder, Disk, Hit, Mesh, MeshData, Shape, Sphere};
use crate::stress;
use glam::{DMat4, DQuat};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg as Random;
use std::cell::Cell;
use std::f64::consts::{FRAC_PI_6, PI, TAU};

fn random(seed: u64) -> Random {
    Random::seed_from_u64(seed)
}

fn in_cube(random: &mut Random) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| random.random_range(-1.0..1.0)))
}

fn direction(random: &mut Random) -> Vec3 {
    loop {
        let v = in_cube(random);
        if (1e-3..1.0).contains(&v.length_squared()) {
            return v.normalize();
        }
    }
}

/// The definition of what `closest` answers.
fn brute_force(shapes: &[Shape], ray: &Ray) -> Option<Hit> {
    let hits =
        (0u32..).zip(shapes).filter_map(|(shape, surface)| Some(Hit { shape, ..surface.intersect(ray)? }));
    hits.min_by(|a, b| a.t.total_cmp(&b.t))
}

fn soup(count: usize, size: f64, random: &mut Random) -> Mesh {
    let mut data = MeshData::default();
    for i in 0..count as u32 {
        let centre = in_cube(random);
        data.positions.extend((0..3).map(|_| (centre + size * in_cube(random)).as_vec3().to_array()));
        data.indices.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    Mesh::new(data).unwrap()
}

fn any_placement(size: f64, random: &mut Random) -> Transform {
    let stretch = Vec3::from_array(std::array::from_fn(|_| random.random_range(0.3..1.0))) * size;
    let rotation = DQuat::from_axis_angle(direction(random), random.random_range(0.0..6.0));
    let place = DMat4::from_scale_rotation_translation(stretch, rotation, in_cube(random));
    let mut shear = DMat4::IDENTITY;
    shear.y_axis.x = random.random_range(-0.5..0.5);
    Transform::new(place * shear).unwrap()
}

/// Analytic shapes of all kinds and some triangles.
fn mixture(count: usize, size: f64, random: &mut Random) -> Vec<Shape> {
    let mut shapes = vec![Shape::Mesh(soup(count, size, random))];
    for _ in 0..count {
        let place = any_placement(size, random);
        shapes.push(Shape::Sphere(Sphere::new(&place, Vec3::ZERO, 1.0, false).unwrap()));
        shapes.push(Shape::Disk(Disk::new(&any_placement(size, random), false).unwrap()));
        let place = any_placement(size, random);
        shapes.push(Shape::Cylinder(Cylinder::new(&place, Vec3::ZERO, Vec3::Z, 1.0, false).unwrap()));
    }
    for kind in [CurveKind::Linear, CurveKind::BSpline] {
        let mut control = || ControlPoint { position: in_cube(random), radius: 0.1 * size };
        let curve = (0..count + 4).map(|_| control()).collect();
        shapes.push(Shape::Curves(Curves::new(&Transform::IDENTITY, kind, &[curve], false).unwrap()));
    }
    shapes.push(Shape::Mesh(soup(count, 0.1 * size, random)));
    shapes
}

/// Rays of many kinds: from inside and outside, near and far, along axes, short and endless.
fn any_ray(random: &mut Random) -> Ray {
    let target = in_cube(random);
    let mut origin = in_cube(random);
    match random.random_range(0..8) {
        0 => origin *= 10.0,
        1 => origin *= 1e6,
        _ => {}
    }
    let mut toward = (target - origin).normalize();
    if random.random_range(0..8) == 0 {
        let axis = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::new(-0.0, 0.6, -0.8)][random.random_range(0..4)];
        toward = if random.random() { axis } else { -axis };
        origin = target - toward * random.random_range(0.0..3.0);
    }
    let t_max = if random.random_range(0..3) == 0 { random.random_range(0.0..2.0) } else { f64::INFINITY };
    Ray { origin, direction: toward, t_max }
}

fn agrees_with_brute_force(
    shapes: &[Shape],
    rays: usize,
    random: &mut Random,
    mut change: impl FnMut(&mut Ray),
) -> usize {
    let accel = Accel::build(shapes);
    let mut hits = 0;
    for _ in 0..rays {
        let mut ray = any_ray(random);
        change(&mut ray);
        let expected = brute_force(shapes, &ray);
        assert_eq!(accel.closest(&ray, 0.0), expected, "{ray:?}");
        assert_eq!(accel.occluded(&ray, 0.0), expected.is_some(), "{ray:?}");
        hits += usize::from(expected.is_some());
    }
    hits
}

#[test]
fn finds_what_a_loop_finds() {
    let mut random = random(1);
    for (count, size) in [(1, 0.8), (3, 0.5), (60, 0.3), (200, 0.05)] {
        let shapes = mixture(count, size, &mut random);
        let hits = agrees_with_brute_force(&shapes, 10_000, &mut random, |_| {});
        assert!(hits > 500, "only {hits} rays hit anything");
    }
    let large = [Shape::Mesh(soup(3000, 0.05, &mut random))];
    agrees_with_brute_force(&large, stress::count(3_000, 10_000), &mut random, |_| {});
    // So many that they are clustered in parts; triangles without area among them, and some in one place.
    let mut many = mixture(200, 0.05, &mut random);
    many.push(Shape::Mesh(soup(30_000, 0.01, &mut random)));
    many.push(Shape::Mesh(soup(500, 0.0, &mut random)));
    let one = soup(1, 0.1, &mut random).data().clone();
    let indices = vec![one.indices[0]; 100];
    many.push(Shape::Mesh(Mesh::new(MeshData { indices, ..one }).unwrap()));
    let hits = agrees_with_brute_force(&many, 300, &mut random, |_| {});
    assert!(hits > 50, "only {hits} rays hit anything");
}

#[test]
fn finds_it_at_all_scales_and_places() {
    let mut random = random(2);
    for (scale, offset) in [(1e-30, 0.0), (1e-6, 0.0), (1e6, 0.0), (1e15, 0.0), (1.0, 1e3), (1e-3, 1.0)] {
        let offset = Vec3::new(offset, -0.5 * offset, 0.3 * offset);
        let place = Transform::scale(scale).then(&Transform::translation(offset));
        let unit = soup(200, 0.3, &mut random);
        let mesh = Shape::Mesh(Mesh::new(unit.data().transformed(&place)).unwrap());
        let ball = place.then(&Transform::translation(Vec3::X * 0.1 * scale));
        let ball = Shape::Sphere(Sphere::new(&ball, Vec3::ZERO, 0.3, false).unwrap());
        let hits = agrees_with_brute_force(&[mesh, ball], 4_000, &mut random, |ray| {
            ray.origin = place.point(ray.origin);
            ray.t_max *= scale;
        });
        assert!(hits > 500, "scale {scale}: only {hits} rays hit anything");
    }
}

#[test]
fn equal_distances_go_to_the_first() {
    let square = Shape::Mesh(Mesh::rectangle(&Transform::IDENTITY, false).unwrap());
    let shapes = vec![square; 20];
    agrees_with_brute_force(&shapes, 5_000, &mut random(3), |_| {});
}

#[test]
fn nothing_and_nonsense() {
    let empty = Accel::build(&[]);
    let ray = Ray::new(Vec3::ZERO, Vec3::X);
    assert_eq!(empty.closest(&ray, 0.0), None);
    assert!(!empty.occluded(&ray, 0.0));
    // Only degenerate triangles.
    let data = MeshData { positions: vec![[1.0; 3]; 3], indices: vec![[0, 1, 2]; 2], ..MeshData::default() };
    let accel = Accel::build(&[Shape::Mesh(Mesh::new(data).unwrap())]);
    assert_eq!(accel.closest(&ray, 0.0), None);
    let sphere = [Shape::Sphere(Sphere::new(&Transform::IDENTITY, Vec3::ZERO, 1.0, false).unwrap())];
    let accel = Accel::build(&sphere);
    for bad in [Vec3::NAN, Vec3::INFINITY, Vec3::new(0.0, f64::NAN, 0.0)] {
        assert_eq!(accel.closest(&Ray::new(bad, Vec3::X), 0.0), None);
        assert_eq!(accel.closest(&Ray::new(Vec3::ZERO, bad), 0.0), None);
    }
    for t_max in [0.0, -1.0, f64::NAN, 0.5] {
        assert!(!accel.occluded(&Ray { t_max, ..ray }, 0.0));
    }
    assert!(accel.occluded(&Ray { t_max: 1.5, ..ray }, 0.0));
}

/// Book example: the box [-1, 2, 1]-[3, 3, 3] is missed, though the ray crosses all three of its slabs.
#[test]
fn book_example_of_a_box() {
    let bounds = Bounds { min: Vec3::new(-1.0, 2.0, 1.0), max: Vec3::new(3.0, 3.0, 3.0) };
    let half = 0.5 * (bounds.max - bounds.min);
    let place = DMat4::from_scale_rotation_translation(half, DQuat::IDENTITY, bounds.centre());
    let shapes = [Shape::Mesh(Mesh::cube(&Transform::new(place).unwrap(), false).unwrap())];
    let accel = Accel::build(&shapes);
    let direction = Vec3::new(1.0, -2.0, 4.0) / 21f64.sqrt();
    assert_eq!(accel.closest(&Ray::new(Vec3::new(0.0, 4.0, 2.0), direction), 0.0), None);
    // From 2 lower in z the slabs overlap: entered where y = 3, left where z = 3.
    let hit = accel.closest(&Ray::new(Vec3::new(0.0, 4.0, 0.0), direction), 0.0).unwrap();
    assert!((hit.t - 0.5 * 21f64.sqrt()).abs() < 1e-12, "{hit:?}");
}

/// No ray from inside a closed mesh gets out, least of all through its edges and vertices.
#[test]
fn closed_meshes_never_leak() {
    let mut random = random(4);
    let cube = Mesh::cube(&Transform::IDENTITY, false).unwrap().data().clone();
    for data in [cube, icosphere(3)] {
        for (scale, offset) in [(1e-6, 0.0), (1.0, 0.0), (1e6, 0.0), (1.0, 1000.0), (1e-3, 10.0)] {
            let place = Transform::scale(scale).then(&Transform::translation(Vec3::new(
                offset,
                0.7 * offset,
                -offset,
            )));
            let mesh = Mesh::new(data.transformed(&place)).unwrap();
            let accel = Accel::build(&[Shape::Mesh(mesh.clone())]);
            let mut leaks = 0;
            for _ in 0..100_000 {
                let triangle = mesh.triangle(random.random_range(0..mesh.triangle_count() as u32));
                let along = random.random_range(0.0..1.0);
                let target = match random.random_range(0..4) {
                    0 => triangle[0],
                    1 => 0.5 * (triangle[0] + triangle[1]),
                    2 => triangle[1].lerp(triangle[2], along),
                    _ => {
                        triangle[0].lerp(triangle[1], along).lerp(triangle[2], random.random_range(0.0..1.0))
                    }
                };
                let origin = match random.random_range(0..4) {
                    0 => place.point(Vec3::ZERO),
                    _ => place.point(0.5 * in_cube(&mut random)),
                };
                let ray = Ray::new(origin, (target - origin).normalize());
                leaks += usize::from(accel.closest(&ray, 0.0).is_none() || !accel.occluded(&ray, 0.0));
            }
            assert_eq!(leaks, 0, "scale {scale}, offset {offset}, {} triangles", mesh.triangle_count());
        }
    }
}

/// Unit vectors that rise over the surface by up to a right angle and down to 1e-4 rad, on either side.
fn leaving(point: &SurfacePoint, random: &mut Random) -> Vec3 {
    let across = loop {
        if let Some(across) = direction(random).reject_from(point.normal).try_normalize() {
            break across;
        }
    };
    let elevation = 10f64.powf(random.random_range(-4.0..0.19));
    let side = if random.random() { 1.0 } else { -1.0 };
    (across * elevation.cos() + point.normal * elevation.sin() * side).normalize()
}

/// A convex surface is not met again from outside, nor a flat one from any side, and from inside a convex
/// one only at the distance that geometry says.
#[test]
fn rays_that_leave_do_not_return() {
    let mut random = random(5);
    for exponent in [-6, -3, 0, 3, 6] {
        let scale = 10f64.powi(exponent);
        for kind in 0..7 {
            let offset = [0.0, 0.0, 1.0, 100.0][random.random_range(0..4)] * scale;
            let turn = DMat4::from_axis_angle(direction(&mut random), 1.0);
            let place = Transform::new(turn).unwrap().then(&Transform::scale(scale));
            let stretched = Transform::new(DMat4::from_scale(Vec3::new(3.0, 1.0, 0.2))).unwrap().then(&place);
            let shift = Transform::translation(offset * Vec3::new(1.0, -0.4, 0.2));
            let (place, stretched) = (place.then(&shift), stretched.then(&shift));
            let shape = match kind {
                0 => Shape::Sphere(Sphere::new(&place, Vec3::ZERO, 1.0, false).unwrap()),
                1 => Shape::Sphere(Sphere::new(&stretched, Vec3::ZERO, 1.0, false).unwrap()),
                2 => Shape::Disk(Disk::new(&stretched, false).unwrap()),
                3 => Shape::Cylinder(Cylinder::new(&place, Vec3::ZERO, Vec3::Z, 1.0, false).unwrap()),
                4 => {
                    Shape::Cylinder(Cylinder::new(&stretched, -40.0 * Vec3::X, Vec3::X, 0.1, false).unwrap())
                }
                5 => Shape::Mesh(Mesh::rectangle(&stretched, false).unwrap()),
                _ => Shape::Mesh(Mesh::cube(&place, false).unwrap()),
            };
            let accel = Accel::build(std::slice::from_ref(&shape));
            let flat = matches!(kind, 2 | 5);
            for _ in 0..20_000 {
                // Half of the points from sampling, half from rays that arrive from far and near.
                let mut point = shape.sample([random.random(), random.random()]).unwrap().surface.point;
                if random.random() {
                    let away = leaving(&point, &mut random);
                    let distance = scale * 10f64.powf(random.random_range(-3.0..3.0));
                    let ray = Ray::new(point.position + away * distance, -away);
                    let Some(hit) = accel.closest(&ray, 0.0) else { continue };
                    point = shape.surface(&hit, &ray).point;
                }
                let away = leaving(&point, &mut random);
                let hit = accel.closest(&point.ray(away), 0.0);
                if flat || away.dot(point.normal) > 0.0 {
                    assert_eq!(hit, None, "kind {kind}, scale {scale}, offset {offset}, {point:?}, {away:?}");
                } else if let (Some(hit), 0) = (hit, kind) {
                    let chord = 2.0 * scale * -away.dot(point.normal);
                    assert!((hit.t - chord).abs() < 1e-5 * chord, "chord {chord}, found {hit:?}");
                } else {
                    assert!(kind != 0, "a ray inside a sphere got lost");
                }
            }
        }
    }
}

/// What touches a surface, or nearly so, is met by rays that leave it.
#[test]
fn neighbours_in_contact_are_not_missed() {
    let mut random = random(6);
    for scale in [1e-6, 1.0, 1e6] {
        let place = |height: f64| Transform::translation(Vec3::Z * height).then(&Transform::scale(scale));
        let floor = Shape::Mesh(Mesh::rectangle(&place(0.0), false).unwrap());
        let lid = Shape::Disk(Disk::new(&place(1e-9), false).unwrap());
        let ball = Shape::Sphere(Sphere::new(&place(0.0), Vec3::Z * 1e-3, 1e-3, false).unwrap());
        let covered = [floor.clone(), lid];
        let accel = Accel::build(&covered);
        for _ in 0..20_000 {
            let [x, y] = std::array::from_fn(|_| 0.5 + random.random_range(-0.2..0.2));
            let point = floor.sample([x, y]).unwrap().surface.point;
            if point.position.truncate().length() > 0.9 * scale {
                continue;
            }
            let up =
                Vec3::new(random.random_range(-1.0..1.0), random.random_range(-1.0..1.0), 0.2).normalize();
            let hit = accel.closest(&point.ray(up), 0.0).unwrap();
            assert_eq!(hit.shape, 1);
            assert!((hit.t - 1e-9 * scale / up.z).abs() < 1e-12 * scale, "{hit:?}");
        }
        // A sphere that rests on the floor hides the sky from the place where it touches.
        let accel = Accel::build(&[floor.clone(), ball.clone()]);
        for _ in 0..20_000 {
            let radius = 1e-3 * scale * 10f64.powf(random.random_range(-4.0..-2.0));
            let (sin, cos) = random.random_range(0.0f64..6.3).sin_cos();
            let down = Ray::new(Vec3::new(radius * cos, radius * sin, -scale), Vec3::Z);
            let hit = accel.closest(&down, 0.0).unwrap();
            assert_eq!(hit.shape, 0);
            let above = floor.surface(&hit, &down).point.ray(Vec3::Z);
            let hit = accel.closest(&above, 0.0).unwrap();
            assert_eq!(hit.shape, 1, "radius {radius}");
        }
    }
}

/// The probability that a random line through a convex body meets one within is the ratio of their areas: π/6
/// for a ball in its box (Stone 1975).
#[test]
fn lines_through_a_box_meet_the_ball_in_it_as_its_area_says() {
    const LINES: u32 = 200_000;
    let ball = Shape::Sphere(Sphere::new(&Transform::IDENTITY, Vec3::ZERO, 1.0, false).unwrap());
    let (accel, mut random) = (Accel::build(&[ball]), random(9));
    let tests = Cell::new(Tests::default());
    let mut hits = 0;
    for _ in 0..LINES {
        // Uniform over lines that come near: a direction, and a place of the disk across it.
        let direction = direction(&mut random);
        let frame = Frame::around(direction);
        let (radius, angle) = (2.0 * random.random::<f64>().sqrt(), random.random_range(0.0..TAU));
        let across = frame.to_world(Vec3::new(radius * angle.cos(), radius * angle.sin(), -5.0));
        hits += u64::from(accel.closest_counting(&Ray::new(across, direction), 0.0, &tests).is_some());
    }
    let Tests { nodes, boxes, entered, surfaces, leaves, empty, packets } = tests.get();
    assert_eq!((nodes, packets), (boxes, 0), "each node has one box");
    assert_eq!([surfaces, leaves, empty + hits], [entered, entered, nodes]);
    let met = hits as f64 / entered as f64;
    let error = (FRAC_PI_6 * (1.0 - FRAC_PI_6) / entered as f64).sqrt();
    assert!((met - FRAC_PI_6).abs() < 4.0 * error, "{met} ± {error}");
    // The box's own mean shadow is a quarter of its area, 24, of a disk of area 4π.
    let entered = entered as f64 / f64::from(LINES);
    let expected = 6.0 / (4.0 * PI);
    assert!((entered - expected).abs() < 4.0 * (expected / f64::from(LINES)).sqrt(), "{entered}");
}

/// Through trees over all kinds of surfaces, from one place or from many.
#[test]
fn rays_that_go_together_are_occluded_as_they_are_alone() {
    let mut random = random(31);
    let mut counts = [0; 2];
    for round in 0..stress::count(16, 40) {
        let shapes = mixture(300, 0.1, &mut random);
        let accel = Accel::build(&shapes);
        for _ in 0..50 {
            let one = any_ray(&mut random);
            let rays: [Ray; LANES] = std::array::from_fn(|_| match round % 2 {
                0 => Ray { direction: direction(&mut random), ..one },
                _ => any_ray(&mut random),
            });
            let asked: Mask = random.random_range(0..1 << LANES);
            let together = accel.occluded_together(&rays, 0.0, asked);
            for (lane, ray) in rays.iter().enumerate() {
                let alone = asked >> lane & 1 == 1 && accel.occluded(ray, 0.0);
                assert_eq!(together >> lane & 1 == 1, alone, "{ray:?}");
                counts[usize::from(alone)] += 1;
            }
        }
    }
    assert!(counts.iter().all(|&count| count > 1000), "{counts:?}");
}

/// Counting changes no answer, nor does it stop sooner.
#[test]
fn queries_that_are_counted_answer_the_same() {
    let mut random = random(4);
    let shapes = mixture(40, 0.3, &mut random);
    let accel = Accel::build(&shapes);
    let tests = Cell::new(Tests::default());
    for _ in 0..2000 {
        let ray = Ray::new(2.0 * in_cube(&mut random), direction(&mut random));
        let before = tests.get();
        assert_eq!(accel.closest_counting(&ray, 0.0, &tests), accel.closest(&ray, 0.0));
        let closest = tests.get();
        assert_eq!(accel.occluded_counting(&ray, 0.0, &tests), accel.occluded(&ray, 0.0));
        let occluded = tests.get().nodes - closest.nodes;
        assert!(closest.nodes - before.nodes > 0 || occluded == 0);
    }
    let Tests { nodes, boxes, entered, leaves, empty, packets, surfaces } = tests.get();
    assert!(boxes > nodes && boxes <= 8 * nodes && entered <= boxes && empty <= nodes + leaves);
    assert!(packets + surfaces >= leaves);
}
