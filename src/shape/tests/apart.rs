//! How far surfaces keep apart.

use super::super::{Mesh, Shape, Sphere, Torus};
use super::{Random, all_shapes, direction, icosphere};
use crate::geometry::{Bounds, Ray, Transform, Vec3};
use glam::DMat4;
use rand::{RngExt, SeedableRng};
use std::f64::consts::FRAC_PI_4;

/// Points of both surfaces are no nearer to one another than is told, wherever the one lies within the other
/// or pokes through it; and it is told that they keep apart where the other is wide enough.
#[test]
fn surfaces_within_one_another_keep_their_clearance() {
    let mut random = Random::seed_from_u64(3);
    for (name, inner) in all_shapes() {
        let (centre, diameter) = (inner.bounds().centre(), inner.bounds().diameter());
        for (shift, is_within) in [(0.0, true), (0.4, false), (0.9, false)] {
            let around = Transform::scale(0.6 * diameter)
                .then(&Transform::translation(centre + shift * diameter * Vec3::new(0.6, -0.64, 0.48)));
            let outer = [
                Shape::Sphere(Sphere::new(&around, Vec3::ZERO, 1.0, false).unwrap()),
                Shape::Mesh(Mesh::cube(&around, false).unwrap()),
            ];
            for outer in outer {
                let clearance = inner.clearance(&outer);
                assert_eq!(clearance, outer.clearance(&inner), "{name}");
                assert!(!is_within || clearance > 0.05 * diameter, "{name}: {clearance}");
                let points = [&inner, &outer].map(|shape| {
                    let sample = |_| shape.sample([random.random(), random.random()]);
                    let points = (0..300).filter_map(sample).map(|sample| sample.surface.point.position);
                    points.collect::<Vec<_>>()
                });
                for p in &points[0] {
                    for q in &points[1] {
                        assert!(p.distance(*q) >= clearance, "{name}: {p} {q} {clearance}");
                    }
                }
            }
        }
    }
}

/// In a box or somewhat outside of it.
fn place_near(bounds: Bounds, random: &mut Random) -> Vec3 {
    let offset = random.random::<[f64; 3]>().map(|x| 2.0 * x - 1.0);
    bounds.centre() + 0.6 * bounds.diameter() * Vec3::from_array(offset)
}

/// No point of a surface is nearer to a place than is told; of balls and round rings some are hardly farther.
#[test]
fn places_are_no_nearer_than_is_told() {
    let mut random = Random::seed_from_u64(4);
    for (name, shape) in all_shapes() {
        let bounds = shape.bounds();
        let places = [(); 40].map(|()| place_near(bounds, &mut random));
        // That a place is no nearer than 0 needs no points.
        if places.iter().all(|&place| shape.distance_from(place) == 0.0) {
            continue;
        }
        let sample = |_| shape.sample([random.random(), random.random()]);
        let points: Vec<Vec3> =
            (0..20_000).filter_map(sample).map(|sample| sample.surface.point.position).collect();
        for place in places {
            let nearest = points.iter().map(|point| point.distance(place)).fold(f64::INFINITY, f64::min);
            let told = shape.distance_from(place);
            assert!(told <= nearest * (1.0 + 1e-12), "{name}: {place}, {told} told, {nearest} found");
            if told > 0.0 {
                assert!(
                    nearest - told < 0.03 * bounds.diameter(),
                    "{name}: {place}, {told} told, {nearest} found"
                );
            }
        }
    }
    let told = |shape: &Shape| shape.distance_from(Vec3::new(0.1, 0.2, 0.3)) > 0.0;
    let stretched = Transform::new(DMat4::from_scale(Vec3::new(1.0, 2.0, 3.0))).unwrap();
    let tori = [Transform::scale(2.0), stretched]
        .map(|place| Shape::Torus(Box::new(Torus::new(&place, 1.0, 0.1, false).unwrap())));
    assert_eq!(tori.each_ref().map(told), [true, false]);
}

/// A ray that is said to end before a surface does not cross it until then; and of balls, quadrics and rings
/// that is said of most short rays.
#[test]
fn rays_end_before_surfaces_that_are_farther() {
    let mut random = Random::seed_from_u64(5);
    for (name, shape) in all_shapes() {
        let bounds = shape.bounds();
        let diameter = bounds.diameter();
        let (mut short, mut seen) = (0, 0);
        for _ in 0..20_000 {
            let origin = place_near(bounds, &mut random);
            let length = diameter * 10f64.powf(random.random_range(-4.0..0.5));
            let endless = Ray::new(origin, direction(&mut random));
            let ray = Ray { t_max: length, ..endless };
            let is_farther = shape.is_farther_than(&ray);
            if is_farther {
                let crossings = shape.crossings(&ray);
                let first = crossings.iter().map(|crossing| crossing.hit.t).find(|&t| t >= 0.0);
                assert!(first.is_none_or(|t| t > length), "{name}: {ray:?} crosses at {first:?}");
            }
            if length < 1e-2 * diameter {
                short += 1;
                seen += u32::from(is_farther);
            }
            assert!(!shape.is_farther_than(&endless), "{name}");
        }
        let is_quick = matches!(shape, Shape::Sphere(_) | Shape::Quadric(_) | Shape::Torus(_));
        assert!(seen > short / 2 || !is_quick, "{name}: {seen} of {short}");
    }
}

/// What touches a surface from within, or crosses it, is not said to keep off it.
#[test]
fn surfaces_that_meet_have_no_clearance() {
    let ball = |radius: f64, x: f64| {
        Shape::Sphere(Sphere::new(&Transform::IDENTITY, Vec3::X * x, radius, false).unwrap())
    };
    let cube = Shape::Mesh(Mesh::cube(&Transform::IDENTITY, false).unwrap());
    for (inner, outer) in [
        (ball(0.5, 0.5), &ball(1.0, 0.0)),
        (ball(0.5, 0.7), &ball(1.0, 0.0)),
        (ball(0.5, 0.5), &cube),
        (ball(0.5, 0.7), &cube),
        (ball(0.5, 1.4), &cube),
    ] {
        assert!(inner.clearance(outer) <= 0.0, "{inner:?} in {outer:?}");
    }
    for (inner, outer) in
        [(ball(0.5, 0.4), &ball(1.0, 0.0)), (ball(0.5, 0.4), &cube), (ball(0.5, 1.6), &cube)]
    {
        assert!((inner.clearance(outer) - 0.1).abs() < 1e-12, "{inner:?} in {outer:?}");
    }
}

/// A round mesh of 1280 triangles, none of whose planes is tried by itself.
fn mesh_ball(centre: Vec3, radius: f64) -> Shape {
    let to_world = Transform::scale(radius).then(&Transform::translation(centre));
    Shape::Mesh(Mesh::new(icosphere(3).transformed(&to_world)).unwrap())
}

/// Whatever lies within a ball or apart from it does not cross it; what pokes through it does.
#[test]
fn closed_shapes_cross_where_one_pokes_through_the_other() {
    for (name, shape) in all_shapes() {
        if !shape.encloses() {
            continue;
        }
        let (centre, diameter) = (shape.bounds().centre(), shape.bounds().diameter());
        let point = shape.sample([0.3, 0.6]).or(shape.sample([0.6, 0.3])).unwrap().surface.point.position;
        for (place, radius, expected) in [
            (centre, 0.6 * diameter, false),
            (centre + 1.3 * diameter * Vec3::X, 0.6 * diameter, false),
            (point, 0.2 * diameter, true),
        ] {
            let sphere = Sphere::new(&Transform::IDENTITY, place, radius, false).unwrap();
            for ball in [Shape::Sphere(sphere), mesh_ball(place, radius)] {
                assert_eq!(shape.crosses(&ball), expected, "{name}: {place} {radius}");
                assert_eq!(ball.crosses(&shape), expected, "{name}: {place} {radius}");
            }
        }
    }
}

/// A hundredth of a ball's surface that pokes through another is seen; balls that touch from within, of one
/// place of their surfaces, do not cross.
#[test]
fn a_little_that_pokes_through_crosses() {
    let outer = mesh_ball(Vec3::ZERO, 1.0);
    let ball = |radius: f64, height: f64| {
        Shape::Sphere(Sphere::new(&Transform::IDENTITY, Vec3::Z * height, radius, false).unwrap())
    };
    // A cap of height h has h/2r of a ball's surface.
    for radius in [0.25, 0.5] {
        let cap = 0.02 * radius;
        assert!(ball(radius, 1.0 - radius + cap).crosses(&ball(1.0, 0.0)), "{radius}");
        assert!(!ball(radius, 1.0 - radius).crosses(&ball(1.0, 0.0)), "{radius}");
        // The triangles lie within the ball of their corners by up to 1.2 %.
        assert!(ball(radius, 1.0 - radius + 0.03).crosses(&outer), "{radius}");
        assert!(!ball(radius, 1.0 - radius - 0.02).crosses(&outer), "{radius}");
    }
}

/// Neither an axis nor the line between the middles parts these cubes: a face of either does.
#[test]
fn a_face_parts_bodies_that_no_axis_parts() {
    let turned = |size: f64, place: Vec3| {
        let to_world = Transform::scale(size)
            .then(&Transform::new(DMat4::from_rotation_z(FRAC_PI_4)).unwrap())
            .then(&Transform::translation(place));
        Shape::Mesh(Mesh::cube(&to_world, false).unwrap())
    };
    let (outward, along) = (Vec3::new(1.0, 1.0, 0.0).normalize(), Vec3::new(-1.0, 1.0, 0.0).normalize());
    let large = turned(1.0, Vec3::ZERO);
    for apart in [0.1, -0.1] {
        let small = turned(0.3, (1.3 + apart) * outward + 0.9 * along);
        assert!(large.bounds().gap(small.bounds()) < 0.0);
        for gap in [large.gap(&small), small.gap(&large)] {
            assert!((gap - apart).abs() < 1e-6, "{gap}, not {apart}");
        }
    }
}
