//! Groups that show groups: the same as all of their shapes where the chains of transforms put them.

use super::{Random, any_placement, any_ray, direction, leaving, mixture, random};
use crate::accel::{Accel, Instance};
use crate::geometry::{Motion, Placed, Pose, SurfacePoint, Transform, Vec3};
use crate::shape::{Cylinder, Disk, Mesh, NO_INSTANCE, Shape, Sphere};
use glam::{DMat3, DMat4};
use rand::RngExt;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A group with shapes of its own, and others where they stand in it.
struct Group {
    /// Its range of the list of shapes.
    own: std::ops::Range<usize>,
    inner: Vec<(usize, Placement)>,
}

#[derive(Clone)]
enum Placement {
    Still(Box<Transform>),
    Moving(Motion),
}

impl Placement {
    fn at(&self, time: f64) -> DMat4 {
        let Pose { origin, linear, .. } = match self {
            Self::Still(place) => Pose::new(place),
            Self::Moving(motion) => motion.at(time),
        };
        DMat4::from_translation(origin) * DMat4::from_mat3(linear)
    }

    fn placed(&self) -> Placed {
        match self {
            Self::Still(place) => Placed::still(place).unwrap(),
            Self::Moving(motion) => Placed::moving(motion.clone()).unwrap(),
        }
    }
}

const SHUTTER: [f64; 2] = [0.0, 1.0];

/// The tree of the last group, in which each of those before may be shown.
fn nested(shapes: &[Shape], groups: &[Group]) -> Accel {
    let mut trees: Vec<Arc<Accel>> = Vec::new();
    let last = groups.len() - 1;
    for Group { own, inner } in &groups[..last] {
        let shown =
            inner.iter().map(|(group, place)| Instance::new(trees[*group].clone(), place.placed())).collect();
        let own_shapes = &shapes[own.clone()];
        trees.push(Arc::new(Accel::of_group_with_instances(
            own_shapes,
            own.start as u32,
            &[],
            shown,
            SHUTTER,
        )));
    }
    let Group { own, inner } = &groups[last];
    assert_eq!(own.start, 0);
    let shown =
        inner.iter().map(|(group, place)| Instance::new(trees[*group].clone(), place.placed())).collect();
    Accel::with_instances(&shapes[own.clone()], &[], shown, SHUTTER)
}

/// All that a group shows at a time: ranges of shapes and where they stand.
fn chains(groups: &[Group], group: usize, at: DMat4, time: f64, found: &mut Vec<(usize, DMat4)>) {
    for (inner, place) in &groups[group].inner {
        let at = at * place.at(time);
        found.push((*inner, at));
        chains(groups, *inner, at, time, found);
    }
}

/// Three levels, with shapes at each of them, and motion at two.
fn mixed(random: &mut Random) -> (Vec<Shape>, Vec<Group>) {
    let mut shapes = mixture(2, 0.2, random);
    let mut ranges = Vec::new();
    ranges.push(0..shapes.len());
    for _ in 0..3 {
        let from = shapes.len();
        shapes.extend(mixture(4, 0.4, random));
        ranges.push(from..shapes.len());
    }
    let mut still = |inner: usize| (inner, Placement::Still(Box::new(any_placement(0.8, random))));
    let (ab, ac, bc, bd, cd, ad) = (still(0), still(0), still(1), still(1), still(2), still(0));
    let (more_ab, more_cd) = (still(0), still(2));
    let turned = |x: f64, degrees: f64| {
        let turn = DMat4::from_rotation_y(degrees.to_radians());
        Transform::new(DMat4::from_translation(Vec3::new(x, 0.2, 0.0)) * turn).unwrap()
    };
    let motion = |from: f64, to: f64| {
        Placement::Moving(Motion::new(&[(0.0, turned(-0.5, from)), (1.0, turned(0.5, to))]).unwrap())
    };
    let groups = vec![
        Group { own: ranges[1].clone(), inner: Vec::new() },
        Group { own: ranges[2].clone(), inner: vec![ab, more_ab, (0, motion(0.0, 70.0))] },
        Group { own: ranges[3].clone(), inner: vec![bc, ac] },
        Group { own: ranges[0].clone(), inner: vec![bd, cd, more_cd, ad, (2, motion(10.0, 150.0))] },
    ];
    (shapes, groups)
}

#[test]
fn groups_in_groups_show_what_their_chains_of_transforms_show() {
    let mut random = random(91);
    let mut met = [0; 4];
    for _ in 0..4 {
        let (shapes, groups) = mixed(&mut random);
        let accel = nested(&shapes, &groups);
        let mut known: BTreeMap<u32, usize> = BTreeMap::new();
        for step in 0..10 {
            let time = f64::from(step) / 9.0;
            let mut shown = Vec::new();
            chains(&groups, 3, DMat4::IDENTITY, time, &mut shown);
            assert_eq!(accel.instance_count(), shown.len() as u64);
            let trees: Vec<Arc<Accel>> = groups
                .iter()
                .map(|group| {
                    Arc::new(Accel::of_group(&shapes[group.own.clone()], group.own.start as u32, &[]))
                })
                .collect();
            let instances = shown
                .iter()
                .map(|(group, at)| {
                    Instance::new(
                        trees[*group].clone(),
                        Placed::still(&Transform::new(*at).unwrap()).unwrap(),
                    )
                })
                .collect();
            let flat = Accel::with_instances(&shapes[groups[3].own.clone()], &[], instances, [0.0; 2]);
            for _ in 0..1500 {
                let ray = any_ray(&mut random);
                let (expected, found) = (flat.closest(&ray, time), accel.closest(&ray, time));
                assert_eq!(found.is_some(), accel.occluded(&ray, time));
                assert_eq!(found.map(|hit| hit.shape), expected.map(|hit| hit.shape), "{ray:?}");
                let (Some(expected), Some(found)) = (expected, found) else { continue };
                let outermost = accel.own_instance(found.instance);
                assert_eq!(found.instance == NO_INSTANCE, outermost == NO_INSTANCE);
                if found.instance != NO_INSTANCE {
                    // Both number the chains in the same order.
                    assert_eq!(found.instance, expected.instance);
                    known.insert(found.instance, shown[found.instance as usize].0);
                    assert!((outermost as usize) < groups[3].inner.len());
                }
                let depth = (0..4).rev().find(|&g| groups[g].own.contains(&(found.shape as usize)));
                met[depth.unwrap()] += 1;
                let (a, b) = (
                    accel.surface(&shapes, &found, &ray, time),
                    flat.surface(&shapes, &expected, &ray, time),
                );
                let scale = 1.0 + expected.t + b.point.position.length();
                let apart = (a.point.position - b.point.position).dot(b.point.normal).abs();
                assert!(apart <= a.point.error + b.point.error, "{apart:e} {a:?} {b:?}");
                assert!((a.point.position - b.point.position).length() < 1e-11 * scale, "{a:?} {b:?}");
                if expected.t < 100.0 {
                    assert!(a.shading_normal.abs_diff_eq(b.shading_normal, 1e-7), "{a:?} {b:?}");
                    let (a, rest) = accel.parametrisation(&shapes, &found, a.point.position, time);
                    let (b, _) = flat.parametrisation(&shapes, &expected, b.point.position, time);
                    let size = 1.0 + b.tangent.length() + b.bitangent.length();
                    assert!(a.tangent.abs_diff_eq(b.tangent, 1e-6 * size), "{a:?} {b:?}");
                    assert!(a.bitangent.abs_diff_eq(b.bitangent, 1e-6 * size), "{a:?} {b:?}");
                    assert!(rest.position.is_finite());
                }
            }
        }
        assert!(known.len() > 10, "{known:?}");
    }
    assert!(met.iter().all(|&count| count > 500), "{met:?}");
}

/// Every crossing along a line, as often as the flat list has it.
#[test]
fn all_crossings_of_groups_in_groups_are_found() {
    let mut random = random(92);
    let (shapes, groups) = mixed(&mut random);
    let accel = nested(&shapes, &groups);
    let mut shown = Vec::new();
    chains(&groups, 3, DMat4::IDENTITY, 0.5, &mut shown);
    let instances = shown
        .iter()
        .map(|(group, at)| {
            let own = groups[*group].own.clone();
            let tree = Arc::new(Accel::of_group(&shapes[own.clone()], own.start as u32, &[]));
            Instance::new(tree, Placed::still(&Transform::new(*at).unwrap()).unwrap())
        })
        .collect();
    let flat = Accel::with_instances(&shapes[groups[3].own.clone()], &[], instances, [0.0; 2]);
    let mut several = 0;
    for _ in 0..2000 {
        let ray = any_ray(&mut random);
        let all = |accel: &Accel| {
            let mut found: Vec<(u32, u32, u32)> = Vec::new();
            accel.crossings(&ray, 0.5, [0.0, 1e3], &mut |hit, _| {
                found.push((hit.instance, hit.shape, hit.triangle));
            });
            found.sort_unstable();
            found.dedup();
            found
        };
        let (expected, found) = (all(&flat), all(&accel));
        // A line that all but touches a surface may do so in one of the two alone.
        assert!(expected.len().abs_diff(found.len()) <= 2, "{ray:?}");
        let lost = expected.iter().filter(|place| !found.contains(place)).count();
        assert!(lost <= 2, "{lost} {ray:?}");
        several += usize::from(expected.len() > 3);
    }
    assert!(several > 300, "{several}");
}

/// The error bounds of all the levels add up: a convex surface is not met again from outside.
#[test]
fn rays_that_leave_a_nest_do_not_return() {
    let mut random = random(93);
    let mut rays = 0;
    for depth in [2, 5, 20] {
        for kind in 0..5 {
            let shapes = [match kind {
                0 => Shape::Sphere(Sphere::new(&Transform::IDENTITY, Vec3::ZERO, 1.0, false).unwrap()),
                1 => Shape::Disk(Disk::new(&Transform::IDENTITY, false).unwrap()),
                2 => Shape::Cylinder(
                    Cylinder::new(&Transform::IDENTITY, Vec3::ZERO, Vec3::Z, 1.0, false).unwrap(),
                ),
                3 => Shape::Mesh(Mesh::rectangle(&Transform::IDENTITY, false).unwrap()),
                _ => Shape::Mesh(Mesh::cube(&Transform::IDENTITY, false).unwrap()),
            }];
            let mut tree = Accel::of_group(&shapes, 0, &[]);
            let mut whole = DMat4::IDENTITY;
            for _ in 0..depth {
                let turn = DMat3::from_axis_angle(direction(&mut random), random.random_range(0.0..6.0));
                let stretch: [f64; 3] = std::array::from_fn(|_| random.random_range(0.7..1.4));
                let offset = direction(&mut random) * random.random_range(0.0..10.0);
                let place = DMat4::from_translation(offset)
                    * DMat4::from_mat3(turn)
                    * DMat4::from_scale(Vec3::from_array(stretch));
                whole = place * whole;
                let placed = Placed::still(&Transform::new(place).unwrap()).unwrap();
                let shown = vec![Instance::new(Arc::new(tree), placed)];
                tree = Accel::of_group_with_instances(&[], 1, &[], shown, [0.0; 2]);
            }
            assert_eq!(tree.instance_count(), depth);
            let place = Transform::new(whole).unwrap();
            for _ in 0..4000 {
                let local = shapes[0].sample([random.random(), random.random()]).unwrap().surface.point;
                let normal = place.normal(local.normal).normalize();
                let point = SurfacePoint { position: place.point(local.position), normal, error: 0.0 };
                let away = leaving(&point, &mut random);
                let ray = crate::geometry::Ray::new(
                    point.position + away * 10f64.powf(random.random_range(-3.0..2.0)),
                    -away,
                );
                let Some(hit) = tree.closest(&ray, 0.0) else { continue };
                let point = tree.surface(&shapes, &hit, &ray, 0.0).point;
                let away = leaving(&point, &mut random);
                if matches!(kind, 1 | 3) || away.dot(point.normal) > 0.0 {
                    rays += 1;
                    let again = tree.closest(&point.ray(away), 0.0);
                    assert_eq!(again, None, "depth {depth}, kind {kind}, {point:?}, {away:?}");
                }
            }
        }
    }
    assert!(rays > 30_000, "{rays}");
}

/// A ray along a wide disk, from near the origin of its group where coordinates have no errors: what it takes
/// to get it through the groups turns it by some rounding, which tells far away. It stays on its side within
/// the group's box, which the groups within it count for.
#[test]
fn rays_along_what_a_nest_shows_stay_on_their_side() {
    const REACH: f64 = 1e3;
    let mut random = random(94);
    let mut rays = 0;
    for _ in 0..200 {
        let shapes = [Shape::Disk(Disk::new(&Transform::scale(REACH), false).unwrap())];
        let mut tree = Accel::of_group(&shapes, 0, &[]);
        for _ in 0..3 {
            let turn = DMat3::from_axis_angle(direction(&mut random), random.random_range(0.0..6.0));
            let placed = Placed::still(&Transform::new(DMat4::from_mat3(turn)).unwrap()).unwrap();
            tree = Accel::of_group_with_instances(
                &[],
                1,
                &[],
                vec![Instance::new(Arc::new(tree), placed)],
                [0.0; 2],
            );
        }
        for _ in 0..100 {
            let toward = direction(&mut random);
            let ray = crate::geometry::Ray::new(toward * -10f64.powf(random.random_range(-6.0..0.0)), toward);
            let Some(hit) = tree.closest(&ray, 0.0) else { continue };
            let point = tree.surface(&shapes, &hit, &ray, 0.0).point;
            let Some(along) = direction(&mut random).reject_from(point.normal).try_normalize() else {
                continue;
            };
            // Higher than the direction's own rounding.
            let side = if random.random() { 1.0 } else { -1.0 };
            let rise = 10f64.powf(random.random_range(-15.5..-14.0));
            let away = (along + point.normal * side * rise).normalize();
            if (away.dot(point.normal) * side) < 0.5 * rise {
                continue;
            }
            rays += 1;
            let again = tree.closest(&point.ray(away), 0.0);
            assert_eq!(again, None, "{point:?}, {away:?}");
        }
    }
    assert!(rays > 5000, "{rays}");
}
