//! Scenes in several files and of several versions, as Mitsuba 3.9.1 reads them.

use super::{errors, scene};
use crate::common::described_file;
use abbe::scene::description::{Description, ShapeKind};

fn file(name: &str, defines: &[(&str, &str)]) -> Description {
    described_file(&format!("tests/scenes/grammar/{name}"), defines)
}

/// Mitsuba 3.9.1 renders both alike, to 2e-7.
#[test]
fn a_scene_in_many_files_means_what_it_means_in_one() {
    assert_eq!(file("files.xml", &[]).hash(), file("plain.xml", &[]).hash());
    // What the command line says reaches into included files.
    assert_ne!(file("files.xml", &[("size", "3")]).hash(), file("plain.xml", &[]).hash());
    let outline = abbe::scene::outline(&file("files.xml", &[]));
    assert!(outline.contains("room.xml:7)"), "{outline}");
}

#[test]
fn names_from_before_version_2_are_understood_only_there() {
    let old = |content: &str| {
        let text = format!("<scene version=\"0.6.0\"><sensor type=\"perspective\"/>{content}</scene>");
        super::read(&text)
    };
    let mirrored = r#"<shape type="sphere"><boolean name="flipNormals" value="true"/></shape>"#;
    assert!(old(mirrored).unwrap().shapes[0].flip_normals);
    errors(mirrored);
    assert!(old(&mirrored.replace("flipNormals", "flip_normals")).unwrap().shapes[0].flip_normals);
    for version in ["0.6.0", "1.9.9", "2.0.0", "3.9.1", "4.0.0", "100.0.0", " 3.0.0 "] {
        super::read(&format!("<scene version=\"{version}\"><sensor type=\"perspective\"/></scene>")).unwrap();
    }
    for version in ["3", "3.0", "3.0.0.0", "a.b.c", ""] {
        super::read(&format!("<scene version=\"{version}\"><sensor type=\"perspective\"/></scene>"))
            .unwrap_err();
    }
}

#[test]
fn an_alias_is_another_name_from_there_on() {
    let ball = r#"<shape type="sphere"><ref id="c"/></shape>"#;
    let chain = r#"<bsdf type="conductor" id="a"/><alias id="a" as="b"/><alias id="b" as="c"/>"#;
    let scene = scene(&format!("{chain}{ball}"));
    assert_eq!(scene.shapes[0].bsdf.id.as_deref(), Some("a"));
    errors(r#"<alias id="a" as="b"/><bsdf type="conductor" id="a"/>"#);
    errors(&format!(r#"{chain}<bsdf type="diffuse" id="c"/>"#));
}

#[test]
fn a_shape_may_be_referred_to_from_the_scene_itself() {
    let scene = scene(r#"<shape type="sphere" id="a"/><ref id="a"/>"#);
    assert_eq!(scene.shapes.len(), 2);
    assert!(scene.shapes.iter().all(|shape| matches!(shape.kind, ShapeKind::Sphere { .. })));
}
