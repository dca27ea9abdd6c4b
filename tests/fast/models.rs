//! The models of the older texts under `scenes/`: what the files hold is what their pages say, and the
//! scripts that wrote them write them again.

use crate::common::described_file;
use crate::common::folder::{Folder, of_repository};
use abbe::geometry::Vec3;
use abbe::scene::description::ShapeKind;
use std::process::Command;

/// E. Haines's flake: nine balls of a third of the radius touch each ball, and none runs into another.
#[test]
fn balls_of_the_sphereflake_touch() {
    let description = described_file("scenes/sphereflake/scene.xml", &[]);
    let balls: Vec<(Vec3, f64)> = description
        .shapes
        .iter()
        .filter_map(|shape| match &shape.kind {
            ShapeKind::Sphere { centre, radius } => Some((*centre, *radius)),
            _ => None,
        })
        .collect();
    // Places and radii have six digits behind the point.
    let near = |a: f64, b: f64| (a - b).abs() < 3e-6;
    let level = |radius: f64| (0..4).find(|&level| near(radius, 0.75 / 3f64.powi(level)));
    let of_level = |wanted: i32| balls.iter().filter(|ball| level(ball.1) == Some(wanted)).count();
    assert_eq!([0, 1, 2, 3].map(of_level), [1, 9, 81, 729]);
    assert_eq!(balls.len(), 820);
    for &(place, radius) in &balls {
        let touched = balls.iter().filter(|(other, larger)| {
            near(*larger, 3.0 * radius) && near(place.distance(*other), radius + larger)
        });
        assert_eq!(touched.count(), usize::from(level(radius) != Some(0)), "{place} {radius}");
        let into = balls.iter().filter(|(other, size)| place.distance(*other) < radius + size - 3e-6);
        assert_eq!(into.count(), 1, "the ball at {place} runs into others than itself");
    }
}

/// G. Wyvill's ladders: each stands 17° further and is smaller by 6 % than the one before, as is its distance
/// from the axis.
#[test]
fn ladders_stand_on_a_logarithmic_spiral() {
    let description = described_file("scenes/ladders/scene.xml", &[]);
    let feet: Vec<(Vec3, f64)> = description
        .instances
        .iter()
        .map(|ladder| (ladder.to_world.point(Vec3::ZERO), ladder.to_world.vector(Vec3::Y).length()))
        .collect();
    assert_eq!((feet.len(), description.instances[0].group.shapes.len()), (40, 13));
    for pair in feet.windows(2) {
        let [(before, large), (after, small)] = [pair[0], pair[1]];
        // The file has five digits of the last and smallest ladder.
        assert!((small / large - 0.94).abs() < 2e-5, "{pair:?}");
        assert!((after.length() / before.length() - 0.94).abs() < 2e-5, "{pair:?}");
        assert!((before.angle_between(after).to_degrees() - 17.0).abs() < 1e-3, "{pair:?}");
        assert!(before.y == 0.0 && before.cross(after).y > 0.0, "{pair:?}");
    }
}

/// Where there is Python; it is no part of what abbe needs.
#[test]
fn scripts_write_the_scenes_that_are_here() {
    if Command::new("python3").arg("--version").output().is_err() {
        return;
    }
    for name in ["sphereflake", "ladders"] {
        let folder = Folder::new(&format!("models-{name}"));
        let here =
            |file: &str| std::fs::read(of_repository(&format!("scenes/{name}/{file}"))).expect("a file");
        folder.write("make_scene.py", here("make_scene.py"));
        let status = Command::new("python3").arg(folder.path("make_scene.py")).status().expect("it starts");
        assert!(status.success(), "{name}");
        assert!(
            folder.bytes("scene.xml") == here("scene.xml"),
            "make_scene.py of {name} writes another scene"
        );
    }
}
