//! Scenes in several files and of several versions, as Mitsuba 3.9.1 reads them.

use super::{errors, scene};
use crate::common::described_file;
use crate::common::folder::Folder;
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

/// As editors on Windows write it.
#[test]
fn texts_that_a_scene_names_may_begin_with_a_byte_order_mark() {
    let folder = Folder::new("marks");
    folder.write("paint.spd", "\u{feff}400 0.1\n700 0.2\n");
    folder.write("mesh.obj", "\u{feff}v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.write(
        "mesh.ply",
        "\u{feff}ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
         property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
         0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
    );
    for kind in ["obj", "ply"] {
        let [paint, mesh] = ["paint.spd", &format!("mesh.{kind}")].map(|name| folder.path(name));
        let scene = scene(&format!(
            r#"<shape type="{kind}"><string name="filename" value="{}"/><bsdf type="diffuse">
               <spectrum name="reflectance" filename="{}"/></bsdf></shape>"#,
            mesh.display(),
            paint.display()
        ));
        assert!(matches!(scene.shapes[0].kind, ShapeKind::Mesh { .. }), "{:?}", scene.shapes[0].kind);
    }
}
