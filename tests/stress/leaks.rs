//! Rays at the edges and vertices of closed meshes, where one could slip through between two triangles.

use super::bodies::icosphere;
use super::table::{Table, count, seconds};
use super::{direction, in_cube, in_parallel, placement, power, trials};
use abbe::accel::{Accel, Instance};
use abbe::geometry::{Placed, Pose, Ray, Transform, Vec3};
use abbe::shape::{Mesh, MeshData, Shape};
use rand::RngExt;
use rand_pcg::Pcg64Mcg as Random;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// All together, over all meshes.
const RAYS: u64 = 100_000_000;

/// A mesh is placed anew for so many rays of the full number.
const RAYS_EACH: u64 = 200_000;

/// Two cones of triangles over a polygon of `sides` corners, one upwards and one downwards.
fn fans(sides: u32) -> MeshData {
    let mut positions: Vec<[f32; 3]> = (0..sides)
        .map(|i| {
            let (sin, cos) = (TAU * f64::from(i) / f64::from(sides)).sin_cos();
            [cos as f32, sin as f32, 0.0]
        })
        .collect();
    positions.extend([[0.0, 0.0, 0.4], [0.0, 0.0, -0.4]]);
    let side = |i: u32| {
        let next = (i + 1) % sides;
        [[i, next, sides], [next, i, sides + 1]]
    };
    MeshData { positions, indices: (0..sides).flat_map(side).collect(), ..MeshData::default() }
}

/// A drum as long as wide whose wall is made of strips a million times as long as wide, but for three wide
/// ones; the ends are fans around their middles.
fn slivers() -> MeshData {
    const STRIPS: u32 = 200;
    let mut angles: Vec<f64> = Vec::new();
    for third in 0..3 {
        let first = TAU * f64::from(third) / 3.0;
        angles.extend((0..STRIPS).map(|i| first + 2e-6 * f64::from(i)));
    }
    let count = angles.len() as u32;
    let mut positions: Vec<[f32; 3]> = Vec::new();
    for z in [-1.0, 1.0] {
        positions.extend(angles.iter().map(|angle| [angle.cos() as f32, angle.sin() as f32, z]));
        positions.push([0.0, 0.0, z]);
    }
    let top = count + 1;
    let side = |i: u32| {
        let next = (i + 1) % count;
        [
            [i, next, top + next],
            [i, top + next, top + i],
            [next, i, count],
            [top + i, top + next, top + count],
        ]
    };
    MeshData { positions, indices: (0..count).flat_map(side).collect(), ..MeshData::default() }
}

/// Its two vertices, among the welded ones and among those of the mesh.
type Edge = [(u32, u32); 2];

/// A closed mesh, convex but for the rounding of its vertices, with room around the middle of its box.
struct Closed {
    shapes: Vec<Shape>,
    accel: Accel,
    /// Normals of the triangles that have an area, in the mesh's coordinates.
    normals: Vec<Option<Vec3>>,
    /// With the triangles that meet there.
    vertices: Vec<(u32, Vec<u32>)>,
    edges: Vec<(Edge, Vec<u32>)>,
    pose: Pose,
    middle: Vec3,
    size: f64,
}

impl Closed {
    fn new(data: &MeshData, random: &mut Random) -> Self {
        let to_world = placement(power(random, -6.0, 6.0), 3.0, Vec3::ONE, random);
        let as_instance = random.random_range(0..3) == 0;
        let place = if as_instance { &Transform::IDENTITY } else { &to_world };
        let mesh = Mesh::new(data.transformed(place)).expect("a mesh");
        let pose = Pose::new(if as_instance { &to_world } else { &Transform::IDENTITY });
        let normals = (0..mesh.triangle_count() as u32)
            .map(|triangle| {
                let [a, b, c] = mesh.triangle(triangle);
                (b - a).cross(c - a).try_normalize()
            })
            .collect();
        // Vertices in the same place are one.
        let mut places = BTreeMap::new();
        let corner = |index: &u32| {
            let next = places.len() as u32;
            *places.entry(data.positions[*index as usize].map(f32::to_bits)).or_insert(next)
        };
        let welded: Vec<u32> = data.indices.iter().flatten().map(corner).collect();
        let mut vertices = vec![(0, Vec::new()); places.len()];
        let mut at_edge = BTreeMap::<[u32; 2], (Edge, Vec<u32>)>::new();
        for (triangle, (corners, names)) in (0u32..).zip(data.indices.iter().zip(welded.chunks(3))) {
            for i in 0..3 {
                let j = (i + 1) % 3;
                vertices[names[i] as usize].0 = corners[i];
                vertices[names[i] as usize].1.push(triangle);
                let [a, b] = [names[i], names[j]];
                let edge = at_edge
                    .entry([a.min(b), a.max(b)])
                    .or_insert(([(names[i], corners[i]), (names[j], corners[j])], Vec::new()));
                edge.1.push(triangle);
            }
        }
        let (middle, size) = (mesh.bounds().centre(), mesh.bounds().diameter());
        let shapes = vec![Shape::Mesh(mesh)];
        let accel = if as_instance {
            let group = Arc::new(Accel::of_group(&shapes, 0, &[]));
            let placed = Placed::still(&to_world).expect("a pose");
            Accel::with_instances(&[], &[], vec![Instance::new(group, placed)], [0.0; 2])
        } else {
            Accel::build(&shapes)
        };
        let edges = at_edge.into_values().collect();
        Self { shapes, accel, normals, vertices, edges, pose, middle, size }
    }

    fn vertex(&self, index: u32) -> Vec3 {
        let Shape::Mesh(mesh) = &self.shapes[0] else { unreachable!("it is a mesh") };
        Vec3::from_array(mesh.data().positions[index as usize].map(f64::from))
    }
}

#[derive(Default)]
struct Counts {
    inside: u64,
    outside: u64,
    leaks: u64,
}

impl Counts {
    fn add(self, other: Self) -> Self {
        Self {
            inside: self.inside + other.inside,
            outside: self.outside + other.outside,
            leaks: self.leaks + other.leaks,
        }
    }
}

static EXAMPLES: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// A number a few units in the last place away.
fn nudged(x: f64, random: &mut Random) -> f64 {
    let mut x = x;
    for _ in 0..random.random_range(0..4) {
        x = if random.random() { x.next_up() } else { x.next_down() };
    }
    x
}

/// One ray at an edge or a vertex, from inside or from outside.
fn cast(closed: &Closed, name: &str, random: &mut Random, counts: &mut Counts) {
    let mut around: Vec<&[u32]> = Vec::new();
    let target = if random.random_range(0..3) == 0 {
        let (vertex, triangles) = &closed.vertices[random.random_range(0..closed.vertices.len())];
        around.push(triangles);
        closed.vertex(*vertex)
    } else {
        let (ends, triangles) = &closed.edges[random.random_range(0..closed.edges.len())];
        let along = match random.random_range(0..4) {
            0 => 0.5,
            1 => power(random, -12.0, 0.0),
            _ => random.random(),
        };
        around.push(triangles);
        // What is so near to a vertex is as good as at it, seen from afar.
        if along < 1e-3 {
            around.push(&closed.vertices[ends[0].0 as usize].1);
        } else if along > 1.0 - 1e-3 {
            around.push(&closed.vertices[ends[1].0 as usize].1);
        }
        closed.vertex(ends[0].1).lerp(closed.vertex(ends[1].1), along)
    };
    let from_inside: bool = random.random();
    let origin = if from_inside {
        match random.random_range(0..4) {
            0 => closed.middle,
            // Beside the target, so that the ray runs along the edge's triangles.
            1 => target.lerp(closed.middle + 0.02 * closed.size * in_cube(random), power(random, -6.0, 0.0)),
            _ => closed.middle + 0.03 * closed.size * in_cube(random),
        }
    } else {
        closed.middle + direction(random) * closed.size * (0.6 + power(random, -2.0, 4.0))
    };
    let toward = target - origin;
    let Some(unit) = toward.try_normalize() else { return };
    // From outside, only where all surfaces around are seen from the front.
    let facing = |triangle: &u32| closed.normals[*triangle as usize].is_none_or(|n| n.dot(unit) < -1e-6);
    if !from_inside && !around.into_iter().flatten().all(facing) {
        return;
    }
    let (origin, end) = (closed.pose.world_point(origin), closed.pose.world_point(target));
    let mut ray = Ray::new(origin, (end - origin).normalize());
    if random.random() {
        ray.direction = Vec3::from_array(ray.direction.to_array().map(|x| nudged(x, random)));
    }
    let hit = closed.accel.closest(&ray, 0.0);
    let distance = (end - origin).length();
    // A hit on the other side of the mesh is a leak too. Close to grazing the distance is less certain, but
    // never doubles.
    let met = hit
        .is_some_and(|hit| if from_inside { true } else { hit.t < distance + 0.01 * closed.size_in_world() });
    let leaks = !met || !closed.accel.occluded(&ray, 0.0);
    if from_inside {
        counts.inside += 1
    } else {
        counts.outside += 1
    }
    if leaks {
        counts.leaks += 1;
        let mut examples = EXAMPLES.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if examples.len() < 12 {
            examples.push(format!(
                "{name}, from {}: aimed at {distance}, found {hit:?}, {ray:?}",
                if from_inside { "inside" } else { "outside" }
            ));
        }
    }
}

impl Closed {
    fn size_in_world(&self) -> f64 {
        self.accel.bounds().diameter()
    }
}

#[test]
fn no_ray_slips_through() {
    // With the share of the rays. Boxes around the triangles of a fan overlap, so that a ray takes long.
    let cube = Mesh::cube(&Transform::IDENTITY, false).expect("a cube").data().clone();
    let meshes = [
        ("cube", cube, 0.2),
        ("icosphere, 80 triangles", icosphere(1), 0.4),
        ("icosphere, 81 920 triangles", icosphere(6), 0.15),
        ("slivers of 1 : 1 000 000", slivers(), 0.23),
        ("fans of 10 000 triangles", fans(10_000), 0.02),
    ];
    let mut table = Table::new(
        "Rays at the edges and vertices of closed meshes, 10⁻⁶ to 10⁶ units large",
        &["mesh", "from inside", "from outside", "leaks", "s"],
    );
    let mut total = Counts::default();
    for (name, data, share) in &meshes {
        let rays = (trials(RAYS) as f64 * share).ceil() as u64;
        let placements = rays.div_ceil(RAYS_EACH).max(2);
        let began = Instant::now();
        let trial = |_, random: &mut Random, counts: &mut Counts| {
            let closed = Closed::new(data, random);
            let mut aimed = Counts::default();
            while aimed.inside + aimed.outside < rays.div_ceil(placements) {
                cast(&closed, name, random, &mut aimed);
            }
            *counts = aimed;
        };
        let found = in_parallel(placements, 1, trial, Counts::add);
        table.row(&[
            (*name).to_owned(),
            count(found.inside),
            count(found.outside),
            count(found.leaks),
            seconds(began),
        ]);
        total = total.add(found);
    }
    table.row(&["all".to_owned(), count(total.inside), count(total.outside), count(total.leaks)]);
    table.print();
    let examples = EXAMPLES.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    assert!(total.leaks == 0, "{}", examples.join("\n"));
}
