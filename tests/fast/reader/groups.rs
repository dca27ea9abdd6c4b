use super::{errors, scene, shape};
use abbe::geometry::Vec3;
use abbe::scene::description::ShapeKind;
use std::sync::Arc;

const GROUP: &str = r#"<shape type="shapegroup" id="g"><shape type="sphere"/><shape type="merge"><shape type="cube"/>
    <shape type="disk"><bsdf type="conductor"/></shape></shape></shape>"#;

#[test]
fn instances_share_their_group_and_merged_shapes_are_shapes() {
    let scene = scene(&format!(
        r#"<shape type="instance"><ref id="g"/></shape>{GROUP}<shape type="merge"><shape type="instance"><ref id="g"/>
        <transform name="to_world"><translate x="2"/></transform></shape><shape type="rectangle"/></shape>"#
    ));
    let [first, second] = &scene.instances[..] else { panic!("{:?}", scene.instances) };
    assert!(Arc::ptr_eq(&first.group, &second.group));
    assert_eq!(first.group.shapes.len(), 3);
    assert_eq!(second.to_world.point(Vec3::ZERO), Vec3::X * 2.0);
    assert!(matches!(
        scene.shapes[..],
        [abbe::scene::description::ShapeDescription { kind: ShapeKind::Rectangle, .. }]
    ));
    assert_eq!(self::scene(GROUP).instances.len(), 0);
}

#[test]
fn what_mitsuba_refuses_in_groups_is_refused() {
    // Seen in Mitsuba 3.9.1: all of these are refused but the transform, which is ignored.
    for content in [
        r#"<shape type="instance"/>"#.to_owned(),
        format!(r#"{GROUP}<shape type="instance"><ref id="g"/><ref id="g"/></shape>"#),
        format!(r#"{GROUP}<shape type="instance"><ref id="g"/><bsdf type="diffuse"/></shape>"#),
        format!(r#"{GROUP}<shape type="instance"><ref id="g"/><emitter type="area"/></shape>"#),
        format!(
            r#"{GROUP}<shape type="instance"><ref id="g"/><boolean name="flip_normals" value="true"/></shape>"#
        ),
        r#"<shape type="sphere" id="s"/><shape type="instance"><ref id="s"/></shape>"#.to_owned(),
        r#"<shape type="shapegroup"><shape type="shapegroup"/></shape>"#.to_owned(),
        r#"<shape type="shapegroup"><shape type="rectangle"><sensor type="irradiancemeter"/></shape></shape>"#
            .to_owned(),
        r#"<shape type="shapegroup"><shape type="sphere"/><emitter type="point"/></shape>"#.to_owned(),
        r#"<shape type="shapegroup"><transform name="to_world"/></shape>"#.to_owned(),
        r#"<shape type="merge"><transform name="to_world"/></shape>"#.to_owned(),
        r#"<shape type="merge"><boolean name="flip_normals" value="true"/></shape>"#.to_owned(),
    ] {
        errors(&content);
    }
}

/// Mitsuba 3.9.1 refuses these: "Nested instancing is not permitted", "Instancing of emitters is not
/// supported".
#[test]
fn groups_in_groups_and_lights_in_groups_are_extensions() {
    let scene = scene(&format!(
        r#"{GROUP}<shape type="shapegroup" id="h"><shape type="instance"><ref id="g"/></shape>
        <shape type="instance"><ref id="g"/></shape><shape type="sphere"><emitter type="area"/></shape></shape>
        <shape type="instance"><ref id="h"/></shape>"#
    ));
    let [shown] = &scene.instances[..] else { panic!("{:?}", scene.instances) };
    let [first, second] = &shown.group.instances[..] else { panic!("{:?}", shown.group) };
    assert!(Arc::ptr_eq(&first.group, &second.group) && first.group.shapes.len() == 3);
    let told: Vec<&str> = scene.extensions.iter().map(|note| note.text.as_str()).collect();
    assert_eq!(
        told.iter().filter(|text| text.contains("an instance within a shapegroup")).count(),
        2,
        "{told:?}"
    );
    assert_eq!(
        told.iter().filter(|text| text.contains("a light within a shapegroup")).count(),
        1,
        "{told:?}"
    );
}

#[test]
fn properties_without_effect_are_accepted_where_mitsuba_does() {
    for plugin in ["sphere", "rectangle", "disk", "cylinder", "cube"] {
        shape(&format!(
            r#"<shape type="{plugin}"><float name="silhouette_sampling_weight" value="2"/></shape>"#
        ));
        let flat = format!(r#"<shape type="{plugin}"><boolean name="face_normals" value="true"/></shape>"#);
        if matches!(plugin, "rectangle" | "cube") {
            shape(&flat);
        } else {
            errors(&flat);
        }
    }
}
