//! Closed meshes along lines that go for their edges and vertices.

use super::{direction, kit};
use crate::geometry::{Ray, Vec3};
use crate::shape::{Mesh, MeshData, Opening, Shape};
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

/// A line that is within the mesh has entered it once more than it has left it, and no line ends within.
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
        let (mut depth, mut within) = (0, 0.0);
        for (index, crossing) in crossings.iter().enumerate() {
            depth += if crossing.enters { 1 } else { -1 };
            // Out of turn only where it isn't certain which comes first.
            if !(0..=1).contains(&depth) {
                let next = crossings.get(index + 1).expect("a line that has left leaves no more");
                within += 1.0;
                assert!(next.hit.t - crossing.hit.t <= crossing.error + next.error, "{crossings:?}");
            }
        }
        assert_eq!(depth, 0, "{origin} {toward} {within} {crossings:?}");
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
fn closed_meshes_do_not_leak() {
    seal(20_000);
}

#[test]
#[ignore = "takes minutes"]
fn closed_meshes_do_not_leak_on_millions_of_lines() {
    seal(15_000_000);
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
