use super::{errors, scene};
use abbe::scene::description::{Part, ShapeDescription, Solid};
use abbe::shape::solid::Operation;

fn solid(content: &str) -> Solid {
    scene(content).solids.remove(0)
}

fn leaf(part: &Part) -> &ShapeDescription {
    match part {
        Part::Shape(shape) => shape,
        Part::Solid(solid) => panic!("a {:?}", solid.operation),
    }
}

#[test]
fn parts_have_what_the_solids_around_them_say() {
    let outer = solid(
        r#"<shape type="difference">
            <bsdf type="dielectric" id="glass"/>
            <medium name="interior" type="homogeneous" id="ink"><spectrum name="sigma_t" value="1"/><float name="albedo" value="0"/></medium>
            <shape type="sphere"/>
            <shape type="union">
                <bsdf type="null" id="air"/>
                <shape type="cube"/>
                <shape type="torus"><bsdf type="diffuse" id="own"/></shape>
            </shape>
        </shape>"#,
    );
    assert_eq!(outer.operation, Operation::Difference);
    let id = |shape: &ShapeDescription| shape.bsdf.id.clone().unwrap();
    let Part::Solid(inner) = &outer.parts[1] else { panic!("no union") };
    assert_eq!(id(leaf(&outer.parts[0])), "glass");
    assert_eq!([id(leaf(&inner.parts[0])), id(leaf(&inner.parts[1]))], ["air", "own"]);
    let leaves = outer.leaves();
    assert_eq!(leaves.len(), 3);
    // Light never gets into the last.
    let interior = leaves.iter().map(|shape| shape.interior.as_ref().and_then(|medium| medium.id.as_deref()));
    assert!(interior.eq([Some("ink"), Some("ink"), None]));
    assert!(leaves.iter().all(|shape| shape.exterior.is_none()));
}

#[test]
fn solids_stand_in_groups_and_merges() {
    let text = r#"
        <shape type="merge"><shape type="union"><shape type="sphere"/></shape></shape>
        <shape type="shapegroup" id="g"><shape type="intersection"><shape type="sphere"/><shape type="cube"/></shape></shape>
        <shape type="instance"><ref id="g"/></shape>"#;
    let scene = scene(text);
    assert_eq!((scene.solids.len(), scene.shapes.len()), (1, 0));
    assert_eq!(scene.instances[0].group.solids[0].operation, Operation::Intersection);
    assert_eq!(scene.extensions.len(), 2);
}

/// A part may stand in as many solids as it likes: it is no larger than the references to it.
#[test]
fn shapes_are_shared_and_solids_are_not() {
    let shared = r#"<shape type="sphere" id="cutter"/>
        <shape type="difference"><shape type="cube"/><ref id="cutter"/></shape>
        <shape type="difference"><shape type="torus"/><ref id="cutter"/></shape>"#;
    assert_eq!(scene(shared).solids.len(), 2);
    let mut doubling = r#"<shape type="union" id="u0"><shape type="sphere"/></shape>"#.to_owned();
    for i in 0..40 {
        let next = i + 1;
        doubling += &format!(r#"<shape type="union" id="u{next}"><ref id="u{i}"/><ref id="u{i}"/></shape>"#);
    }
    assert!(errors(&doubling).contains("is used in two places"));
}
