//! Boxes around groups that show groups: by them the scene is centred, bodies in contact are found, and light
//! subpaths are aimed.

use super::{Groups, centre};
use crate::geometry::{Bounds, Transform, Vec3};
use crate::scene::compile::shapes;
use crate::scene::description::Description;
use crate::scene::{ReadOptions, read_str};
use crate::shape::Shape;
use std::path::Path;

/// Turns by right angles, so that a box around boxes is no wider than what it is around.
///
/// In `a` a ball of radius 1 fills x 2 to 4. `b` shows it on y 2 to 4 and z 4 to 6, and once more, carried
/// from y −1 to 1 to y −11 to −9: its box is x −1 to 4, y −11 to 4, z −1 to 6. `c` shows `b` twice as large
/// at x 98 to 108, y −22 to 8, z −2 to 12, beside a ball around its origin. The scene shows `c` with y and z
/// turned, a thousand further along z.
const NESTED: &str = r#"<scene version="3.0.0">
<sensor type="perspective"><float name="shutter_close" value="1"/></sensor>
<shape type="shapegroup" id="a"><shape type="sphere"><point name="center" x="3" y="0" z="0"/></shape></shape>
<shape type="shapegroup" id="b">
  <shape type="instance"><ref id="a"/><transform name="to_world">
    <rotate z="1" angle="90"/><translate z="5"/></transform></shape>
  <shape type="instance"><ref id="a"/><animation name="to_world">
    <transform time="0"><translate y="0"/></transform>
    <transform time="1"><translate y="-10"/></transform></animation></shape>
</shape>
<shape type="shapegroup" id="c">
  <shape type="instance"><ref id="b"/><transform name="to_world">
    <scale value="2"/><translate x="100"/></transform></shape>
  <shape type="sphere"/>
</shape>
<shape type="instance"><ref id="c"/><transform name="to_world">
  <rotate x="1" angle="90"/><translate z="1000"/></transform></shape>
</scene>"#;

const EXPECTED: Bounds = Bounds { min: Vec3::new(-1.0, -12.0, 978.0), max: Vec3::new(108.0, 2.0, 1008.0) };

fn described() -> Description {
    read_str(NESTED.to_owned(), Path::new("scene.xml"), &ReadOptions::default())
        .unwrap_or_else(|errors| panic!("{errors}"))
}

#[track_caller]
fn assert_near(found: Bounds, expected: Bounds) {
    let off = (found.min - expected.min).abs().max((found.max - expected.max).abs()).max_element();
    assert!(off < 1e-9, "{found:?} is not {expected:?}");
}

#[test]
fn boxes_hold_what_groups_in_groups_show_and_no_more() {
    let description = described();
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
