//! Rays in lanes meet what one ray after the other does.

use super::fans::{any_point, placed, room, slivers};
use super::*;
use crate::accel::{Hits, NO_FACET, Rays};
use crate::lanes::{get, set};

/// Small scenes of all kinds, one with more triangles than are tested without a tree, and one of spheres.
fn scene(round: u32, random: &mut Random) -> Vec<Shape> {
    match round % 8 {
        0 => room(),
        1 => vec![Shape::Mesh(soup(random.random_range(1..60), 0.8, random))],
        2 => vec![Shape::Mesh(soup(60, 0.1, random)), Shape::Mesh(soup(3, 1e-5, random))],
        3 => vec![Shape::Mesh(slivers(random)), Shape::Mesh(soup(9, 0.8, random))],
        4 => vec![Shape::Mesh(Mesh::cube(&Transform::IDENTITY, false).unwrap())],
        // Several surfaces in one plane: which one is met is told by their order alone.
        5 => {
            let mut shapes = room();
            shapes.extend(room());
            shapes.truncate(12);
            shapes
        }
        6 => vec![Shape::Mesh(soup(200, 0.3, random))],
        _ => {
            let mut shapes = room();
            shapes.extend((0..3).map(|_| {
                let radius = random.random_range(0.1..0.6);
                Shape::Sphere(
                    Sphere::new(&Transform::IDENTITY, 0.5 * in_cube(random), radius, false).unwrap(),
                )
            }));
            shapes
        }
    }
}

#[test]
fn rays_in_lanes_meet_what_single_rays_meet() {
    let mut random = random(21);
    let (mut met, mut missed, mut open, mut blocked) = (0, 0, 0, 0);
    for round in 0..480 {
        let shapes = scene(round, &mut random);
        let scales =
            [(1.0, 0.0), (1e-30, 0.0), (1e-6, 0.0), (1e6, 0.0), (1e15, 0.0), (1.0, 1e3), (1e-3, 1.0)];
        let (scale, offset) = scales[random.random_range(0..7)];
        let offset = Vec3::new(offset, -0.5 * offset, 0.3 * offset);
        let place = Transform::scale(scale).then(&Transform::translation(offset));
        let shapes = placed(&shapes, &place);
        let accel = Accel::build(&shapes);
        assert_eq!(accel.few_primitives().is_empty(), round % 8 == 6, "round {round}");
        // The rays of the first turn come from anywhere, those of the others leave what was met.
        let mut hits = Hits::NONE;
        for turn in 0..40 {
            let mut rays = Rays::NONE;
            for lane in 0..LANES {
                let left = (turn % 8 > 0 && hits.met >> lane & 1 == 1).then(|| hits.get(lane));
                let direction = direction(&mut random);
                let from = match &left {
                    Some(hit) => {
                        shapes[hit.shape as usize].surface(hit, &Ray::new(Vec3::ZERO, direction)).point
                    }
                    None => any_point(&shapes, &place, scale, &mut random).0,
                };
                let far = if left.is_none() && random.random_range(0..8) == 0 { 100.0 * scale } else { 0.0 };
                let mut ray = from.ray(direction);
                ray.origin -= far * direction;
                let (target, _) = any_point(&shapes, &place, scale, &mut random);
                match random.random_range(0..4) {
                    0 => ray.t_max = scale * random.random_range(0.0..2.0),
                    1 => ray = from.segment_to(&target).unwrap_or(ray),
                    _ => {}
                }
                if random.random_range(0..200) == 0 {
                    ray.origin[random.random_range(0..3)] = f64::NAN;
                }
                rays.set(lane, &ray);
                if left.is_some() {
                    set(&mut rays.leaves, lane, get(&hits.facet, lane));
                }
            }
            let asked: Mask = random.random_range(0..1 << LANES);
            let mut found = hits.clone();
            accel.closest_of(&rays, 0.0, asked, &mut found);
            let occluded = accel.occluded_of(&rays, 0.0, asked);
            assert_eq!((found.met | occluded) & !asked, 0);
            for lane in (0..LANES).filter(|lane| asked >> lane & 1 == 1) {
                let ray = rays.get(lane);
                let expected = accel.closest(&ray, 0.0);
                let answer = (found.met >> lane & 1 == 1).then(|| found.get(lane));
                let leaves = get(&rays.leaves, lane);
                assert_eq!(answer, expected, "round {round}: {ray:?}, which leaves {leaves}");
                assert_eq!(occluded >> lane & 1 == 1, accel.occluded(&ray, 0.0), "round {round}: {ray:?}");
                *(if expected.is_some() { &mut met } else { &mut missed }) += 1;
                *(if occluded >> lane & 1 == 1 { &mut blocked } else { &mut open }) += 1;
                assert_eq!(
                    get(&found.facet, lane) == NO_FACET,
                    expected.is_none_or(|hit| !matches!(shapes[hit.shape as usize], Shape::Mesh(_)))
                        || round % 8 == 6
                );
            }
            hits = found;
        }
    }
    let counts = [met, missed, open, blocked];
    assert!(counts.iter().all(|&count| count > 20_000), "{counts:?}");
}
