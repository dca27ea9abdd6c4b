//! Where things are and which way they turn.

use super::{assert_near, assert_near_vector};
use abbe::geometry::{Motion, Ray, SurfacePoint, Transform, Vec3};
use abbe::shape::{Mesh, Shape};
use std::f64::consts::{PI, TAU};

/// A wheel that is seen six times a second seems to turn the shorter way from picture to picture, as what moves between
/// keyframes does here: once a second for one turn a second, once backwards for five, and either way for three.
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

/// Direction (1, 2, 4) leaves a cube through its +z face at (0.25, 0.5); each face fills a sixth of all directions.
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
