//! Boxes around groups that show groups: by them the scene is centred, bodies in contact are found, and light
//! subpaths are aimed.

use super::{Groups, centre};
use crate::camera::{Shutter, ShutterKind};
use crate::geometry::{Bounds, Transform, Vec3};
use crate::scene::compile::shapes;
use crate::scene::description::{Animation, Description, Instance, ShapeDescription, ShapeGroup, ShapeKind};
use crate::scene::fixture::{self, PLACE, constant, diffuse, transform};
use crate::shape::Shape;
use glam::DMat4;
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

const EXPECTED: Bounds = Bounds { min: Vec3::new(-1.0, -12.0, 978.0), max: Vec3::new(108.0, 2.0, 1008.0) };

fn ball(centre: Vec3) -> ShapeDescription {
    fixture::shape(ShapeKind::Sphere { centre, radius: 1.0 }, DMat4::IDENTITY, diffuse(constant(0.5)))
}

fn group(shapes: Vec<ShapeDescription>, instances: Vec<Instance>) -> Arc<ShapeGroup> {
    Arc::new(ShapeGroup { place: PLACE, id: None, shapes, solids: Vec::new(), instances })
}

fn shown(group: &Arc<ShapeGroup>, to_world: DMat4) -> Instance {
    Instance { place: PLACE, id: None, group: group.clone(), to_world: transform(to_world), motion: None }
}

/// Turns by right angles, so that a box around boxes is no wider than what it is around.
///
/// In `a` a ball of radius 1 fills x 2 to 4. `b` shows it on y 2 to 4 and z 4 to 6, and once more, carried
/// from y −1 to 1 to y −11 to −9: its box is x −1 to 4, y −11 to 4, z −1 to 6. `c` shows `b` twice as large
/// at x 98 to 108, y −22 to 8, z −2 to 12, beside a ball around its origin. The scene shows `c` with y and z
/// turned, a thousand further along z.
fn nested() -> Description {
    let moved = |x, y, z| DMat4::from_translation(Vec3::new(x, y, z));
    let a = group(vec![ball(3.0 * Vec3::X)], Vec::new());
    let carried = shown(&a, DMat4::IDENTITY);
    let keys = [0.0, 1.0].map(|time| (time, transform(moved(0.0, -10.0 * time, 0.0)))).to_vec();
    let carried = Instance { motion: Some(Arc::new(Animation { place: PLACE, keys })), ..carried };
    let turned = shown(&a, moved(0.0, 0.0, 5.0) * DMat4::from_rotation_z(FRAC_PI_2));
    let b = group(Vec::new(), vec![turned, carried]);
    let enlarged = shown(&b, moved(100.0, 0.0, 0.0) * DMat4::from_scale(Vec3::splat(2.0)));
    let c = group(vec![ball(Vec3::ZERO)], vec![enlarged]);
    let mut scene = fixture::described(Vec::new(), Vec3::ZERO, Vec3::Z);
    scene.instances = vec![shown(&c, moved(0.0, 0.0, 1000.0) * DMat4::from_rotation_x(FRAC_PI_2))];
    scene.sensor.shutter = Shutter { open: 0.0, close: 1.0, kind: ShutterKind::Box };
    scene
}

#[track_caller]
fn assert_near(found: Bounds, expected: Bounds) {
    let off = (found.min - expected.min).abs().max((found.max - expected.max).abs()).max_element();
    assert!(off < 1e-9, "{found:?} is not {expected:?}");
}

#[test]
fn boxes_hold_what_groups_in_groups_show_and_no_more() {
    let description = nested();
    let groups = Groups::new(&description);
    assert_near(groups.scene_bounds(), EXPECTED);
    let middle = centre(EXPECTED);
    let shift = Transform::translation(-middle);
    let place = |traced: &super::Traced<'_>| {
        shapes::place(traced.shape, &traced.to_traced, false, traced.part).expect("a ball")
    };
    let all: Vec<Shape> = groups.shapes(&shift).iter().map(place).collect();
    let contents = groups.contents(&all);
    let sizes = [[2.0, 2.0, 2.0], [5.0, 15.0, 7.0], [109.0, 30.0, 14.0]];
    assert_eq!(contents.len(), sizes.len());
    for (content, size) in contents.iter().zip(sizes) {
        // Each group is traced around its middle, where coordinates are finest.
        let half = 0.5 * Vec3::from_array(size);
        assert_near(content.bounds, Bounds { min: -half, max: half });
    }
    let expected = Bounds { min: EXPECTED.min - middle, max: EXPECTED.max - middle };
    let shown = groups.shown(&contents, &shift);
    assert_near(Bounds::of_all(shown.iter().map(|shown| shown.bounds)), expected);
    let (accel, _) = groups.accel(&all, &shift).unwrap_or_else(|places| panic!("{places:?}"));
    assert_near(accel.bounds(), expected);
}
