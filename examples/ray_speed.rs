//! Rays per second of one thread on a million triangles and on a few dozen.
//!
//! `cargo run --release --example ray_speed [rays]`

use abbe::accel::Accel;
use abbe::geometry::{Frame, Ray, Transform, Vec3};
use abbe::shape::{Mesh, MeshData, Shape};
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::{PI, TAU};
use std::hint::black_box;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let rays: usize = std::env::args().nth(1).map_or(Ok(1_000_000), |count| count.parse())?;
    let room = Shape::Mesh(Mesh::cube(&Transform::scale(5.0), true)?);
    measure("displaced sphere in a room", &[room.clone(), displaced_sphere(1000, 500)?], rays);
    let block = |x: f64| Mesh::cube(&Transform::translation(Vec3::new(x, 0.3, -4.0)), false).map(Shape::Mesh);
    measure("room with two blocks", &[room, block(-2.0)?, block(1.5)?], rays);
    Ok(())
}

fn measure(name: &str, shapes: &[Shape], rays: usize) {
    let start = Instant::now();
    let accel = Accel::build(shapes);
    let build = start.elapsed().as_secs_f64();
    let triangles: usize =
        shapes.iter().map(|s| if let Shape::Mesh(mesh) = s { mesh.triangle_count() } else { 1 }).sum();
    println!(
        "{name}: {triangles} triangles, built in {build:.2} s, {:.1} bytes a triangle",
        accel.memory() as f64 / triangles as f64
    );
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let (bounces, shadows) = incoherent_rays(&accel, shapes, rays, &mut random);
    let report = |kind: &str, query: &dyn Fn() -> usize| {
        let best = (0..3).map(|_| {
            let start = Instant::now();
            let count = black_box(query());
            (start.elapsed().as_secs_f64(), count)
        });
        if let Some((seconds, count)) = best.min_by(|a, b| a.0.total_cmp(&b.0)) {
            println!("  {kind}: {:.2} Mray/s, {count} of {rays} hit", rays as f64 / seconds * 1e-6);
        }
    };
    report("closest ", &|| bounces.iter().filter(|ray| accel.closest(ray, 0.0).is_some()).count());
    report("occluded", &|| shadows.iter().filter(|ray| accel.occluded(ray, 0.0)).count());
}

/// Diffuse bounces from random places and shadow rays from there to a patch of the ceiling, in random order.
fn incoherent_rays(
    accel: &Accel,
    shapes: &[Shape],
    count: usize,
    random: &mut impl Rng,
) -> (Vec<Ray>, Vec<Ray>) {
    let (mut bounces, mut shadows) = (Vec::new(), Vec::new());
    while bounces.len() < count {
        let origin = Vec3::new(4.9, 4.9, 4.9)
            * Vec3::from_array(std::array::from_fn(|_| random.random_range(-1.0..1.0)));
        let ray = Ray::new(origin, direction(Vec3::Z, random));
        let Some(hit) = accel.closest(&ray, 0.0) else { continue };
        let mut point = shapes[hit.shape as usize].surface(&hit, &ray).point;
        if point.normal.dot(ray.direction) > 0.0 {
            point.normal = -point.normal;
        }
        bounces.push(point.ray(direction(point.normal, random)));
        let light = Vec3::new(random.random_range(-1.0..1.0), random.random_range(-1.0..1.0), 4.99);
        let origin = point.leave(light - point.position);
        let toward = light - origin;
        shadows.push(Ray { origin, direction: toward.normalize(), t_max: toward.length() });
    }
    (bounces, shadows)
}

/// Cosine-distributed.
fn direction(normal: Vec3, random: &mut impl Rng) -> Vec3 {
    let (r2, azimuth) = (random.random::<f64>(), random.random_range(0.0..TAU));
    let local = Vec3::new(r2.sqrt() * azimuth.cos(), r2.sqrt() * azimuth.sin(), (1.0 - r2).sqrt());
    Frame::around(normal).to_world(local)
}

/// A sphere with bumps of several sizes, of 2·columns·rows triangles.
fn displaced_sphere(columns: u32, rows: u32) -> Result<Shape, abbe::shape::ShapeError> {
    let mut data = MeshData::default();
    for row in 0..=rows {
        for column in 0..columns {
            let (azimuth, polar) =
                (TAU * f64::from(column) / f64::from(columns), PI * f64::from(row) / f64::from(rows));
            let n = Vec3::new(polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos());
            let bump = |f: f64| ((f * n.x).sin() * (f * n.y + 1.0).sin() * (f * n.z + 2.0).sin()) / f;
            let r = 3.0 + 2.0 * (bump(5.0) + bump(17.0) + bump(61.0) + bump(203.0));
            data.positions.push((n * r).as_vec3().to_array());
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let at = |r: u32, c: u32| r * columns + c % columns;
            let (a, b) = (at(row, column), at(row, column + 1));
            let (c, d) = (at(row + 1, column), at(row + 1, column + 1));
            data.indices.extend([[a, c, b], [b, c, d]]);
        }
    }
    Ok(Shape::Mesh(Mesh::new(data)?))
}
