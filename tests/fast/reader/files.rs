//! Scenes in several files and of several versions, as Mitsuba 3.9.1 reads them.

use super::{errors, scene};
use crate::common::described_file;
use crate::common::folder::Folder;
use abbe::scene::description::{Description, ShapeKind};
use abbe::scene::{ReadOptions, outline, read_str};

fn file(name: &str, defines: &[(&str, &str)]) -> Description {
    described_file(&format!("tests/scenes/grammar/{name}"), defines)
}

/// Mitsuba 3.9.1 renders both alike, to 2e-7.
#[test]
fn a_scene_in_many_files_means_what_it_means_in_one() {
    assert_eq!(file("files.xml", &[]).hash(), file("plain.xml", &[]).hash());
    // What the command line says reaches into included files.
    assert_ne!(file("files.xml", &[("size", "3")]).hash(), file("plain.xml", &[]).hash());
    let text = outline(&file("files.xml", &[]));
    assert!(text.contains("room.xml:7)"), "{text}");
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

/// Text and bytes, where faces have a second list: coordinates of their corners, as some programs write them.
#[test]
fn faces_of_a_ply_may_have_further_lists() {
    let folder = Folder::new("lists");
    let header = |format: &str| {
        format!(
            "ply\nformat {format} 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
             element face 1\nproperty list uchar float texcoord\nproperty list uchar int vertex_indices\n\
             property list uchar uchar flags\nend_header\n"
        )
    };
    folder.write("text.ply", format!("{}0 0 0\n1 0 0\n0 1 0\n2 0.5 0.25 3 0 1 2 1 7\n", header("ascii")));
    let mut bytes = header("binary_little_endian").into_bytes();
    let place =
        |bytes: &mut Vec<u8>, values: &[f32]| values.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
    place(&mut bytes, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    bytes.push(2);
    place(&mut bytes, &[0.5, 0.25]);
    bytes.push(3);
    (0..3i32).for_each(|index| bytes.extend(index.to_le_bytes()));
    bytes.extend([1, 7]);
    std::fs::write(folder.path("bytes.ply"), bytes).unwrap();
    for name in ["text.ply", "bytes.ply"] {
        let file = folder.path(name);
        let scene = scene(&format!(
            r#"<shape type="ply"><string name="filename" value="{}"/></shape>"#,
            file.display()
        ));
        let ShapeKind::Mesh { mesh, .. } = &scene.shapes[0].kind else { panic!("{name}") };
        assert_eq!(mesh.indices, [[0, 1, 2]], "{name}");
    }
}

/// A file of measured reflection is read, and one that is damaged is refused by its place and with what is
/// wrong in it.
#[test]
fn measured_reflection_is_read_and_checked() {
    let folder = Folder::new("measured");
    let whole = std::fs::read("tests/data/measured/quarter.bsdf").unwrap();
    let said_of = |bytes: &[u8]| {
        std::fs::write(folder.path("a.bsdf"), bytes).unwrap();
        let scene = r#"<scene version="3.0.0"><sensor type="perspective"/><shape type="sphere">
            <bsdf type="measured"><string name="filename" value="a.bsdf"/></bsdf></shape></scene>"#;
        let read = read_str(scene, &folder.path("scene.xml"), &ReadOptions::default());
        read.map(|description| outline(&description)).map_err(|errors| errors.to_string())
    };
    let text = said_of(&whole).unwrap();
    assert!(text.contains("3 × 4 directions, 3 wavelengths"), "{text}");
    let renamed = |from: &str, to: &str| {
        let at = whole.windows(from.len()).position(|part| part == from.as_bytes()).unwrap();
        let mut bytes = whole.clone();
        bytes[at..at + to.len()].copy_from_slice(to.as_bytes());
        said_of(&bytes).unwrap_err()
    };
    for (error, parts) in [
        (said_of(b"no table").unwrap_err(), ["The file is no table of measurements", "a.bsdf"]),
        (said_of(&whole[..whole.len() / 2]).unwrap_err(), ["does not fit its file", "a.bsdf"]),
        (renamed("sigma", "sigmb"), ["no field sigma", "theta_i"]),
        (renamed("spectra", "spectrb"), ["no field spectra", "scene.xml:2"]),
    ] {
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
    }
    // An axis that does not ascend, and one of another length than the tables.
    let changed = |field: &str, at: usize, to: &[u8]| {
        let name = whole.windows(field.len()).position(|part| part == field.as_bytes()).unwrap();
        let header = name + field.len() + 3;
        let offset = u64::from_le_bytes(whole[header..header + 8].try_into().unwrap()) as usize;
        let mut bytes = whole.clone();
        let from = if at == usize::MAX { header + 8 } else { offset + at };
        bytes[from..from + to.len()].copy_from_slice(to);
        said_of(&bytes).unwrap_err()
    };
    let error = changed("wavelengths", 0, &900f32.to_le_bytes());
    assert!(error.contains("The values of the field wavelengths do not ascend"), "{error}");
    let error = changed("theta_i", usize::MAX, &3u64.to_le_bytes());
    assert!(error.contains("has a size of 3 × 4 × ") && error.contains("expected 3 × 3 × "), "{error}");
}
