//! Where things are and which way they turn.

use super::{assert_near, assert_near_vector};
use abbe::accel::{Accel, Tests};
use abbe::geometry::{Motion, Ray, SurfacePoint, Transform, Vec3};
use abbe::shape::{Mesh, MeshData, Shape};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg as Random;
use std::cell::Cell;
use std::f64::consts::{PI, TAU};

/// A wheel that is seen six times a second seems to turn the shorter way from picture to picture, as what
/// moves between keyframes does here: once a second for one turn a second, once backwards for five, and
/// either way for three.
#[test]
fn n18_wheels_seen_six_times_a_second() {
    let seen = |turns_per_second: f64| {
        let keys: Vec<(f64, Transform)> = (0..7)
            .map(|frame| {
                let turned = glam::DMat4::from_rotation_z(TAU * turns_per_second * f64::from(frame) / 6.0);
                (f64::from(frame) / 6.0, Transform::new(turned).unwrap())
            })
            .collect();
        let motion = Motion::new(&keys).unwrap();
        let angle = |time: f64| {
            let spoke = motion.at(time).world_vector(Vec3::X);
            spoke.y.atan2(spoke.x)
        };
        // In the first sixth of a second, by steps of a hundredth of it.
        let steps = (0..100).map(|i| {
            let step = angle(f64::from(i + 1) / 600.0) - angle(f64::from(i) / 600.0);
            step - TAU * (step / TAU).round()
        });
        steps.sum::<f64>() / TAU * 6.0
    };
    assert_near(seen(1.0), 1.0, 1e-12);
    assert_near(seen(5.0), -1.0, 1e-12);
    assert_near(seen(3.0).abs(), 3.0, 1e-12);
}

/// Direction (1, 2, 4) leaves a cube through its +z face at (0.25, 0.5); each face fills a sixth of all
/// directions.
#[test]
fn n24_the_direction_cube() {
    let cube = Shape::Mesh(Mesh::cube(&Transform::IDENTITY, false).unwrap());
    let ray = Ray::new(Vec3::ZERO, Vec3::new(1.0, 2.0, 4.0).normalize());
    let hit = cube.intersect(&ray).unwrap();
    let point = cube.surface(&hit, &ray).point;
    assert_near_vector(point.position, [0.25, 0.5, 1.0], 1e-15);
    assert_near_vector(point.normal, [0.0, 0.0, 1.0], 0.0);
    let face = Shape::Mesh(Mesh::rectangle(&Transform::translation(Vec3::Z), false).unwrap());
    let front = SurfacePoint { position: Vec3::Z, normal: Vec3::Z, error: 0.0 };
    let solid_angle = 1.0 / face.density_toward(Vec3::ZERO, &front);
    assert_near(solid_angle, 2.0 * PI / 3.0, 1e-12);
    assert_near(solid_angle, 2.0944, 5e-5);
}

/// Ullner's machine (1983) tests each of 1000 polygons in a third of a microsecond for each ray: a ray for
/// each of 512 × 512 pixels takes 87.4 s, so his ten minutes are 6.9 rays for a pixel. The tree leaves it a
/// fiftieth of that.
#[test]
fn n25_the_time_of_a_machine_that_tests_every_polygon() {
    const POLYGONS: usize = 1000;
    let seconds = |tests_of_a_ray: f64| 512.0 * 512.0 * tests_of_a_ray / 3e6;
    assert_near(seconds(POLYGONS as f64), 87.4, 0.05);
    assert_near(600.0 / seconds(POLYGONS as f64), 6.9, 0.05);
    let mut random = Random::seed_from_u64(25);
    let mut place = |size: f64| [0, 1, 2].map(|_| random.random_range(-size..size));
    let mut data = MeshData::default();
    for polygon in 0..POLYGONS as u32 {
        let centre = place(1.0);
        for _ in 0..3 {
            let corner = place(0.1);
            data.positions.push([0, 1, 2].map(|axis| (centre[axis] + corner[axis]) as f32));
        }
        data.indices.push([0, 1, 2].map(|corner| 3 * polygon + corner));
    }
    let accel = Accel::build(&[Shape::Mesh(Mesh::new(data).unwrap())]);
    let tests = Cell::new(Tests::default());
    let (mut rays, mut hits) = (0, 0);
    for x in 0..64 {
        for y in 0..64 {
            let at = |pixel: i32| (f64::from(pixel) + 0.5) / 32.0 - 1.0;
            let ray = Ray::new(Vec3::new(at(x), at(y), 5.0), Vec3::NEG_Z);
            hits += u32::from(accel.closest_counting(&ray, 0.0, &tests).is_some());
            rays += 1;
        }
    }
    let tested = 4.0 * tests.get().packets as f64 / f64::from(rays);
    println!("{tested} polygons tested for a ray: {} s", seconds(tested));
    assert!(
        hits > rays / 2 && tested >= 1.0 && seconds(tested) < seconds(POLYGONS as f64) / 50.0,
        "{tested}"
    );
}
