//! What holds for all solids: the table of operations, sizes, motion, and that nothing is met twice.

use super::super::cluster::{self, Event};
use super::super::{Carried, Leaf, Operation, Solid, Tree};
use super::{OPERATIONS, direction, faces, in_cube, kit};
use crate::accel::{Accel, Instance};
use crate::geometry::{Motion, Placed, Ray, Transform, Vec3};
use crate::shape::{Crossing, Hit, NO_INSTANCE, Shape, Sphere};
use kit::{Model, turned};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg as Random;
use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::sync::Arc;

fn leaf(item: &kit::Item, place: Transform) -> Model {
    Model::Leaf(item.clone(), place)
}

/// A ball that a line along x enters at `from` and leaves at `to`.
fn ball(from: f64, to: f64) -> Model {
    leaf(&kit::sphere(), turned(0.0, Vec3::splat(0.5 * (to - from)), Vec3::X * (0.5 * (from + to))))
}

/// Roth's table, for all orders of the four ends, equal ones included, where they can't be told apart.
#[test]
fn the_table_of_operations_holds_for_all_orders() {
    let ray = Ray::new(Vec3::X * -10.0, Vec3::X);
    let ends = [0.0, 1.0, 2.0, 3.0];
    let intervals: Vec<(f64, f64)> =
        ends.iter().flat_map(|&a| ends.iter().filter(move |&&b| a < b).map(move |&b| (a, b))).collect();
    let mut checked = 0;
    for &(a, b) in &intervals {
        for &(c, d) in &intervals {
            for operation in OPERATIONS {
                let solid = Model::Node(operation, vec![ball(a, b), ball(c, d)]).solid();
                let found: Vec<f64> =
                    faces(&solid, &ray).iter().map(|face| face.crossing.hit.t - 10.0).collect();
                // Which of the three stretches between the ends belong to it.
                let holds = |t: f64| {
                    let (first, second) = (a < t && t < b, c < t && t < d);
                    match operation {
                        Operation::Union => first || second,
                        Operation::Intersection => first && second,
                        Operation::Difference => first && !second,
                    }
                };
                let expected: Vec<f64> =
                    ends.into_iter().filter(|end| holds(end - 0.5) != holds(end + 0.5)).collect();
                assert_eq!(found.len(), expected.len(), "{operation:?} {a}-{b} {c}-{d}: {found:?}");
                assert!(found.iter().zip(&expected).all(|(t, end)| (t - end).abs() < 1e-12));
                checked += 1;
            }
        }
    }
    assert_eq!(checked, 6 * 6 * 3);
}

fn event(leaf: usize, turn: i32, t: f64, error: f64) -> Event {
    let hit = Hit { t, shape: 0, triangle: 0, instance: NO_INSTANCE, barycentric: [0.0; 2] };
    Event { leaf, turn, crossing: Crossing { hit, error, enters: turn > 0 } }
}

#[test]
fn what_is_uncertain_draws_in_nothing_else() {
    // Three in a row, each within the errors of the next, but not all in one place.
    let row = [event(0, 1, 0.0, 1.0), event(1, 1, 1.5, 1.0), event(2, 1, 3.0, 1.0)];
    assert_eq!(cluster::first(&row), 2);
    // One that may be anywhere goes with the first that it meets.
    let wide = [event(0, 1, 0.0, 1e-9), event(1, 1, 0.1, 5.0), event(2, 1, 0.2, 1e-9)];
    assert_eq!(cluster::first(&wide), 2);
    // A line that all but touches does not touch; what is certain stays.
    let mut pair: super::super::Events =
        [event(0, 1, 0.0, 1e-9), event(0, -1, 1.0, 2.0), event(0, 1, 1.1, 2.0), event(0, -1, 3.0, 1e-9)]
            .into_iter()
            .collect();
    cluster::without_touches(&mut pair, 0);
    assert_eq!(pair.iter().map(|event| event.crossing.hit.t).collect::<Vec<_>>(), [0.0, 3.0]);
}

/// A ray meets the first part's face where faces coincide, whatever rounding makes of it.
#[test]
fn the_first_of_coincident_faces_is_met() {
    let place = turned(0.8, Vec3::splat(0.7), Vec3::new(0.3, 0.1, -0.2));
    let beside = |z: f64| Transform::translation(Vec3::Z * z).then(&place);
    let (cube, cylinder) = (kit::cube(), kit::cylinder());
    let mut random = Random::seed_from_u64(8);
    let mut met = 0;
    for operation in OPERATIONS {
        // Both end at z = 1; the cylinder, seen from above, covers the cube's top but for its corners.
        let second = if operation == Operation::Difference { beside(2.0) } else { place };
        let solid = Model::Node(operation, vec![leaf(&cube, place), leaf(&cylinder, second)]).solid();
        for _ in 0..20_000 {
            let (x, y) = (random.random_range(-0.7..0.7), random.random_range(-0.7..0.7));
            let target = place.point(Vec3::new(x, y, 1.0));
            let up = place.vector(Vec3::Z).normalize();
            let toward = direction(&mut random);
            let toward = if toward.dot(up) > 0.0 { -toward } else { toward };
            let origin = target - toward * 5.0;
            let line = faces(&solid, &Ray::new(origin, toward));
            let Some(face) = line.iter().find(|face| (face.crossing.hit.t - 5.0).abs() < 1e-9) else {
                continue;
            };
            assert_eq!(face.crossing.hit.shape, 0, "{operation:?} {face:?}");
            met += 1;
        }
    }
    assert!(met > 40_000, "{met}");
}

/// Lengths of chords add up as volumes do, and a lens has the volume that it should.
#[test]
fn volumes_are_those_of_inclusion_and_exclusion() {
    let length = |solid: &Solid, ray: &Ray| -> f64 {
        faces(solid, ray)
            .iter()
            .map(|f| if f.crossing.enters { -f.crossing.hit.t } else { f.crossing.hit.t })
            .sum()
    };
    let items = kit::all();
    let mut random = Random::seed_from_u64(3);
    for (i, a) in items.iter().enumerate() {
        let b = &items[(i * 5 + 3) % items.len()];
        let (first, second) =
            (turned(0.4, Vec3::ONE, Vec3::ZERO), turned(2.0, Vec3::splat(0.9), Vec3::splat(0.3)));
        let both = || vec![leaf(a, first), leaf(b, second)];
        let [union, intersection, difference] =
            OPERATIONS.map(|operation| Model::Node(operation, both()).solid());
        let alone: Vec<Solid> = both().iter().map(Model::solid).collect();
        for _ in 0..500 {
            let toward = direction(&mut random);
            let ray = Ray::new(in_cube(&mut random) - toward * 5.0, toward);
            let [a, b] = [&alone[0], &alone[1]].map(|solid| length(solid, &ray));
            let [joined, shared, cut] = [&union, &intersection, &difference].map(|solid| length(solid, &ray));
            assert!((joined + shared - a - b).abs() < 1e-9 && (cut + shared - a).abs() < 1e-9);
        }
    }
    // Two unit balls at the distance d share π (4 + d)(2 − d)² / 12.
    let d = 0.7;
    let unit = |x: f64| leaf(&kit::sphere(), Transform::translation(Vec3::X * x));
    let lens = Model::Node(Operation::Intersection, vec![unit(0.0), unit(d)]).solid();
    let lines = 100_000;
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..lines {
        let [y, z] = [random.random_range(-1.0..1.0), random.random_range(-1.0..1.0)];
        let value = 4.0 * length(&lens, &Ray::new(Vec3::new(-3.0, y, z), Vec3::X));
        sum += value;
        squares += value * value;
    }
    let mean = sum / f64::from(lines);
    let error = ((squares / f64::from(lines) - mean * mean) / f64::from(lines)).sqrt();
    let expected = PI * (4.0 + d) * (2.0 - d) * (2.0 - d) / 12.0;
    assert!((mean - expected).abs() < 4.0 * error && error < 0.01 * expected, "{mean} {expected} {error}");
}

/// A sphere cut in two and put together again is the sphere, to the last bit of its distances.
#[test]
fn two_halves_are_a_whole() {
    let place = turned(0.6, Vec3::splat(0.8), Vec3::new(1.3, -0.4, 0.2));
    let half = |z: f64| {
        let cube = leaf(&kit::cube(), Transform::translation(Vec3::Z * z).then(&place));
        Model::Node(Operation::Intersection, vec![leaf(&kit::sphere(), place), cube])
    };
    let whole = Shape::Sphere(Sphere::new(&place, Vec3::ZERO, 1.0, false).unwrap());
    let joined = Model::Node(Operation::Union, vec![half(1.0), half(-1.0)]).solid();
    let mut random = Random::seed_from_u64(5);
    let mut hits = 0;
    for _ in 0..50_000 {
        let ray = Ray::new(place.point(3.0 * in_cube(&mut random)), direction(&mut random));
        let (found, expected) = (joined.closest(&ray, 0.0), whole.intersect(&ray));
        let Some(expected) = expected else {
            assert_eq!(found, None);
            continue;
        };
        let t = found.expect("a hit").t;
        assert!((t - expected.t).abs() <= 1e-14 * (1.0 + ray.origin.length()), "{t} {}", expected.t);
        hits += 1;
    }
    assert!(hits > 1_000, "{hits}");
}

/// A ray that leaves a face never meets it again, nor another that coincides with it.
#[test]
fn no_face_is_met_where_it_is_left() {
    let place = turned(1.1, Vec3::splat(1.0), Vec3::new(0.3, -0.1, 0.2));
    let at = |z: f64| Transform::translation(Vec3::Z * z).then(&place);
    let parts = [leaf(&kit::cube(), place), leaf(&kit::cylinder(), place), leaf(&kit::cube(), at(2.0))];
    let narrow = Transform::new(glam::DMat4::from_scale(Vec3::new(0.6, 0.6, 1.0))).unwrap();
    let cut =
        vec![Model::Node(Operation::Union, parts.to_vec()), leaf(&kit::cylinder(), narrow.then(&at(2.0)))];
    let model = Model::Node(Operation::Difference, cut);
    let (solid, depth) = (model.solid(), model.depth());
    let shapes: Vec<Shape> = solid.leaves.iter().map(|part| part.leaf.shape.clone()).collect();
    let mut random = Random::seed_from_u64(9);
    let mut left = 0;
    while left < 50_000 {
        let toward = direction(&mut random);
        let ray = Ray::new(place.point(1.5 * in_cube(&mut random)) - toward * 6.0, toward);
        let Some(hit) = solid.closest(&ray, 0.0) else { continue };
        let point = shapes[hit.shape as usize].surface(&hit, &ray).point;
        assert!(point.normal.dot(toward) < 0.0, "a face is met from behind: {hit:?}");
        assert!(solid.shows(hit.shape, &point, 0.0));
        let away = direction(&mut random);
        let away = if random.random() {
            away
        } else {
            (away.reject_from(point.normal) + point.normal * 1e-4).normalize()
        };
        if away.dot(point.normal).abs() < 1e-5 {
            continue;
        }
        let next = solid.closest(&point.ray(away), 0.0);
        let inward = away.dot(point.normal) < 0.0;
        // Up to the next face there is what the functions say.
        let length = next.map_or(1.0, |next| next.t);
        assert!(length > 1e-9, "{hit:?} {next:?}");
        assert_eq!(depth(point.position + away * (0.5 * length)) < 0.0, inward, "{hit:?} {next:?}");
        if let Some(next) = next {
            let normal = shapes[next.shape as usize].surface(&next, &point.ray(away)).point.normal;
            assert_eq!(normal.dot(away) > 0.0, inward, "{hit:?} {next:?}");
        }
        left += 1;
    }
}

/// A cutter that moves cuts at each moment where it then is, within the tree of a scene too.
#[test]
fn a_moving_cutter_cuts_where_it_is() {
    let keys = [
        (0.0, turned(0.2, Vec3::splat(0.6), Vec3::X * -0.8)),
        (1.0, turned(1.7, Vec3::splat(0.9), Vec3::X * 0.7)),
    ];
    let motion = Motion::new(&keys).unwrap();
    let (cube, base) = (kit::cube(), (kit::sphere().make)(&Transform::IDENTITY, false));
    let cutter = (cube.make)(&Transform::IDENTITY, true);
    let of = |index, shape: &Shape, carried| Tree::Leaf(Leaf { shape: shape.clone(), index, carried });
    let placed = Placed::moving(motion.clone()).unwrap();
    let carried = Carried { placed: placed.clone(), instance: 0 };
    let parts = vec![of(0, &base, None), of(1, &cutter, Some(carried))];
    let moving = Arc::new(Solid::new(Tree::Node(Operation::Difference, parts), [0.0, 1.0]));
    let shapes = [base.clone(), cutter.clone()];
    let instance = Instance::of_part(cutter.bounds(), placed);
    let accel = Accel::with_instances(&shapes, std::slice::from_ref(&moving), vec![instance], [0.0, 1.0]);
    let mut random = Random::seed_from_u64(6);
    let mut on_cutter = 0;
    for i in 0..100 {
        let time = f64::from(i) / 99.0;
        let pose = motion.at(time);
        let matrix = glam::DMat4::from_mat3_translation(pose.linear, pose.origin);
        let there = (cube.make)(&Transform::new(matrix).unwrap(), true);
        let parts = vec![of(0, &base, None), of(1, &there, None)];
        let still = Solid::new(Tree::Node(Operation::Difference, parts), [0.0; 2]);
        for _ in 0..200 {
            let toward = direction(&mut random);
            let ray = Ray::new(in_cube(&mut random) - toward * 3.0, toward);
            let (found, expected) = (moving.closest(&ray, time), still.closest(&ray, 0.0));
            assert_eq!(accel.closest(&ray, time), found);
            assert_eq!(accel.occluded(&ray, time), found.is_some());
            let same = match (found, expected) {
                (Some(a), Some(b)) => (a.t - b.t).abs() < 1e-12 && a.shape == b.shape,
                (a, b) => a.is_none() && b.is_none(),
            };
            assert!(same, "{found:?} {expected:?}");
            let Some(hit) = found.filter(|hit| hit.shape == 1) else { continue };
            assert_eq!(hit.instance, 0);
            let met = accel.surface(&shapes, &hit, &ray, time);
            let direct = there.surface(&expected.unwrap(), &ray);
            assert!((met.point.position - direct.point.position).length() < 1e-12);
            assert!((met.point.normal - direct.point.normal).length() < 1e-12);
            on_cutter += 1;
        }
    }
    assert!(on_cutter > 1_000, "{on_cutter}");
}

/// A part of the surface that is cut away or within another part is none of the solid's.
#[test]
fn only_what_is_left_of_a_surface_shows() {
    let items = kit::all();
    let mut random = Random::seed_from_u64(11);
    let [mut shown, mut hidden] = [0; 2];
    for (i, a) in items.iter().enumerate() {
        let b = &items[(i * 3 + 1) % items.len()];
        let places = [turned(0.4, Vec3::ONE, Vec3::ZERO), turned(2.0, Vec3::splat(0.9), Vec3::splat(0.3))];
        for operation in OPERATIONS {
            let models = [leaf(a, places[0]), leaf(b, places[1])];
            let solid = Model::Node(operation, models.to_vec()).solid();
            for (index, other) in [(0, 1), (1, 0)] {
                let (shape, depth) = (&solid.leaves[index].leaf.shape, models[other].depth());
                for _ in 0..200 {
                    let Some(sample) = shape.sample([random.random(), random.random()]) else { continue };
                    let point = sample.surface.point;
                    let beyond = depth(point.position);
                    if beyond.abs() < 1e-9 {
                        continue;
                    }
                    // What is left: outside of the other for a union, inside otherwise, but for what a
                    // difference is cut from.
                    let left = match (operation, index) {
                        (Operation::Union, _) | (Operation::Difference, 0) => beyond > 0.0,
                        _ => beyond < 0.0,
                    };
                    assert_eq!(
                        solid.shows(index as u32, &point, 0.0),
                        left,
                        "{} {operation:?} {}",
                        a.name,
                        b.name
                    );
                    if left { shown += 1 } else { hidden += 1 }
                }
            }
        }
    }
    assert!(shown > 2_000 && hidden > 2_000, "{shown} {hidden}");
}

/// Nothing is asked of parts that the ray does not come near, and the answer is the same.
#[test]
fn boxes_hold_what_they_should() {
    let items = kit::all();
    for (i, a) in items.iter().enumerate() {
        let b = &items[(i + 4) % items.len()];
        let places = [turned(0.4, Vec3::ONE, Vec3::ZERO), turned(2.0, Vec3::splat(0.9), Vec3::splat(0.3))];
        for operation in OPERATIONS {
            let solid = Model::Node(operation, vec![leaf(a, places[0]), leaf(b, places[1])]).solid();
            let bounds = solid.bounds();
            let mut random = Random::seed_from_u64(i as u64);
            for _ in 0..300 {
                let toward = direction(&mut random);
                let ray = Ray::new(in_cube(&mut random) - toward * 5.0, toward);
                solid.walk::<()>(&ray, 0.0, |face| {
                    let at = ray.at(face.crossing.hit.t);
                    assert!(at.cmpge(bounds.min - 1e-12).all() && at.cmple(bounds.max + 1e-12).all());
                    ControlFlow::Continue(())
                });
            }
        }
    }
}
