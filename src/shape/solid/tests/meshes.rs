//! Closed meshes along lines that go for their edges and vertices.

use super::{direction, kit};
use crate::geometry::{Ray, Vec3};
use crate::shape::{Crossing, Hit, Mesh, MeshData, NO_INSTANCE, Opening, Shape};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg as Random;

/// Two fans over a polygon: thousands of slivers that meet in two vertices.
fn double_fan(sides: u32) -> MeshData {
    let mut positions = vec![[0.0, 0.0, 0.5], [0.0, 0.0, -0.4]];
    for i in 0..sides {
        let (sin, cos) = (std::f32::consts::TAU * i as f32 / sides as f32).sin_cos();
        positions.push([cos, sin, 0.01 * (7.0 * cos).sin()]);
    }
    let sectors = (0..sides).map(|i| (2 + i, 2 + (i + 1) % sides));
    let indices = sectors.flat_map(|(a, b)| [[0, a, b], [1, b, a]]).collect();
    MeshData { positions, indices, ..MeshData::default() }
}

/// Whether each crossing may be somewhere within its bounds such that the line enters and leaves by turns,
/// beginning with entering: nowhere has it certainly entered more than once oftener than it may have left,
/// nor certainly left oftener than it may have entered.
fn in_turn(crossings: &[Crossing]) -> bool {
    let until = |place: f64, enters: bool, side: f64| {
        let passed = |crossing: &&Crossing| {
            crossing.enters == enters && crossing.hit.t + side * crossing.error <= place
        };
        crossings.iter().filter(passed).count()
    };
    let fits = |place: f64| {
        until(place, true, 1.0) <= until(place, false, -1.0) + 1
            && until(place, false, 1.0) <= until(place, true, -1.0)
    };
    let balanced = until(f64::INFINITY, true, 0.0) == until(f64::INFINITY, false, 0.0);
    balanced && crossings.iter().all(|crossing| fits(crossing.hit.t + crossing.error))
}

/// A line enters the mesh and leaves it by turns, as often the one as the other: out of turn only where it
/// isn't certain which comes first. Of a face that the line runs in that may be any place of it, beyond
/// others that are certain.
fn assert_sealed(mesh: &Shape, rays: u32, seed: u64) -> u64 {
    let Shape::Mesh(triangles) = mesh else { panic!("no mesh") };
    let mut random = Random::seed_from_u64(seed);
    let mut hits = 0;
    for i in 0..rays {
        let triangle = random.random_range(0..triangles.triangle_count() as u32);
        let [a, b, c] = triangles.triangle(triangle);
        let target = match i % 3 {
            0 => a,
            1 => a + (b - a) * random.random::<f64>(),
            _ => a + (b - a) * 0.5 * random.random::<f64>() + (c - a) * 0.5 * random.random::<f64>(),
        };
        // Also along the mesh's own edges, through two vertices at once, and along axes.
        let origin = match i % 5 {
            0 => b,
            1 => target + Vec3::AXES[random.random_range(0..3)] * 3.0,
            _ => target + direction(&mut random) * 3.0,
        };
        let Some(toward) = (target - origin).try_normalize() else { continue };
        let crossings = mesh.crossings(&Ray::new(origin, toward));
        assert!(in_turn(&crossings), "{origin} {toward} {crossings:?}");
        hits += u64::from(!crossings.is_empty());
    }
    hits
}

fn seal(rays: u32) {
    let place = kit::turned(0.9, Vec3::new(1.0, 0.7, 1.3), Vec3::new(0.3, -0.1, 0.2));
    let fan = double_fan(2_000);
    let fan = Shape::Mesh(Mesh::part(&fan, &place, fan.transformed(&place)).unwrap());
    assert_eq!(fan.is_closed(), Ok(()));
    assert!(assert_sealed(&fan, rays, 1) > u64::from(rays / 2));
    for item in
        kit::all().into_iter().filter(|item| ["cube", "angle iron", "icosahedron"].contains(&item.name))
    {
        for place in [place, crate::geometry::Transform::IDENTITY] {
            let shape = (item.make)(&place, false);
            assert!(assert_sealed(&shape, rays, 2) > u64::from(rays / 2), "{}", item.name);
        }
    }
}

#[test]
fn turns_are_told_within_their_bounds() {
    let crossing = |t: f64, error: f64, enters: bool| {
        let hit = Hit { t, shape: 0, triangle: 0, instance: NO_INSTANCE, barycentric: [0.0; 2] };
        Crossing { hit, error, enters }
    };
    let [a, b, c, d] = [(0.0, true), (1.0, true), (2.0, false), (3.0, false)];
    let all = |errors: [f64; 4]| {
        [a, b, c, d].iter().zip(errors).map(|(&(t, enters), e)| crossing(t, e, enters)).collect::<Vec<_>>()
    };
    assert!(!in_turn(&all([0.4; 4])) && in_turn(&all([0.6; 4])));
    // One that may be anywhere comes between those that are certain.
    assert!(in_turn(&all([0.1, 0.1, 0.1, 2.5])) && in_turn(&all([2.5, 0.1, 0.1, 0.1])));
    assert!(!in_turn(&all([0.1, 0.1, 0.1, 1.5])));
    assert!(
        !in_turn(&all([9.0; 4])[..3]) && !in_turn(&[crossing(0.0, 0.1, false), crossing(1.0, 0.1, true)])
    );
}

#[test]
fn closed_meshes_do_not_leak() {
    seal(crate::stress::count(20_000, 15_000_000));
}

#[test]
fn a_missing_triangle_is_an_open_edge() {
    let mut fan = double_fan(5);
    assert_eq!(Mesh::new(fan.clone()).unwrap().open_edge(), None);
    let missing = fan.indices.pop().unwrap();
    let Err(Opening::Edge([a, b])) = Shape::Mesh(Mesh::new(fan.clone()).unwrap()).is_closed() else {
        panic!("it is closed")
    };
    assert!(missing.contains(&a) && missing.contains(&b));
    // Turned round, it doesn't close it either.
    fan.indices.push([missing[1], missing[0], missing[2]]);
    assert!(Mesh::new(fan).unwrap().open_edge().is_some());
}
