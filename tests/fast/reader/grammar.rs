use super::{errors, read, scene, shape};
use crate::common::described;
use abbe::scene::description::{BsdfKind, ShapeKind, SpectrumKind};
use abbe::scene::{ReadOptions, read_str};
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

/// Transforms and the matrices that Mitsuba 3.9.1 made of them (single precision).
#[test]
fn transforms_compose_as_in_mitsuba() {
    let cases: [(&str, [[f64; 4]; 3]); 9] = [
        (
            // Without up.
            r#"<lookat origin="1,2,3" target="4,-3,5"/>"#,
            [
                [-0.29804, 0.821176, 0.486664, 1.0],
                [-0.503267, 0.29804, -0.811107, 2.0],
                [-0.811107, -0.486664, 0.324443, 3.0],
            ],
        ),
        (
            r#"<rotate y="1" angle="30"/><translate x="1" y="2" z="3"/>"#,
            [[0.866025, 0.0, 0.5, 1.0], [0.0, 1.0, 0.0, 2.0], [-0.5, 0.0, 0.866025, 3.0]],
        ),
        (
            r#"<translate x="1" y="2" z="3"/><rotate y="1" angle="30"/>"#,
            [[0.866025, 0.0, 0.5, 2.36603], [0.0, 1.0, 0.0, 2.0], [-0.5, 0.0, 0.866025, 2.09808]],
        ),
        (
            r#"<scale x="2" y="3" z="0.5"/><rotate x="1" angle="-40"/><rotate z="1" angle="65"/><translate value="-1, 0.5, 4"/>"#,
            [
                [0.845237, -2.08282, -0.291282, -1.0],
                [1.81262, 0.971233, 0.135827, 0.5],
                [0.0, -1.92836, 0.383022, 4.0],
            ],
        ),
        (
            r#"<rotate x="1" y="2" angle="50"/>"#,
            [
                [1.0, 0.714425, 1.53209, 0.0],
                [0.714425, 2.07164, -0.766044, 0.0],
                [-1.53209, 0.766044, 0.642788, 0.0],
            ],
        ),
        (
            r#"<translate z="1"/><lookat origin="1, 2, 3" target="4 0 1" up="0, 1, 0"/>"#,
            [
                [-0.5547, 0.403604, 0.727607, 1.72761],
                [0.0, 0.874475, -0.485071, 1.51493],
                [-0.83205, -0.269069, -0.485071, 2.51493],
            ],
        ),
        (
            r#"<matrix value="1 2 3 4 0 1 5 6 1 0 1 7 0 0 0 1"/><scale value="2"/>"#,
            [[2.0, 4.0, 6.0, 8.0], [0.0, 2.0, 10.0, 12.0], [2.0, 0.0, 2.0, 14.0]],
        ),
        (
            r#"<matrix value="1 2 3 0 1 5 1 0 1"/>"#,
            [[1.0, 2.0, 3.0, 0.0], [0.0, 1.0, 5.0, 0.0], [1.0, 0.0, 1.0, 0.0]],
        ),
        (
            // As exporters write what turns nothing; Mitsuba 3.9 refuses it.
            r#"<rotate x="0" y="0" z="0" angle="0"/><translate x="1"/>"#,
            [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
        ),
    ];
    for (steps, expected) in cases {
        let shape = shape(&format!(
            r#"<shape type="rectangle"><transform name="to_world">{steps}</transform></shape>"#
        ));
        for (row, expected) in expected.into_iter().enumerate() {
            let found = shape.to_world.matrix().row(row).to_array();
            for (found, expected) in found.into_iter().zip(expected) {
                assert!(
                    (found - expected).abs() < 1e-5 * (1.0 + expected.abs()),
                    "{steps}: row {row} {found} {expected}"
                );
            }
        }
    }
}

#[test]
fn a_rotation_axis_that_is_no_unit_vector_is_told() {
    let scene = scene(
        r#"<shape type="sphere"><transform name="to_world"><rotate y="2" angle="9"/></transform></shape>"#,
    );
    assert_eq!(scene.assumptions.len(), 1);
    assert!(scene.assumptions[0].text.contains("length 2.0"), "{}", scene.assumptions[0].text);
}

#[test]
fn parameters_are_replaced_anywhere_and_the_first_value_counts() {
    let text = r#"<scene version="3.0.0"><sensor type="perspective"/>
        <default name="r" value="2"/><default name="r" value="9"/><default name="rr" value="1$r"/>
        <default name="kind" value="sphere"/><default name="property" value="radius"/>
        <shape type="$kind" id="a$r"><float name="$property" value="$rr.5"/></shape></scene>"#;
    let radius = |defines: &[(&str, &str)]| {
        let defines = defines.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect();
        let scene =
            read_str(text, Path::new("s.xml"), &ReadOptions { defines, ..ReadOptions::default() }).unwrap();
        match scene.shapes[0].kind {
            ShapeKind::Sphere { radius, .. } => radius,
            _ => panic!("not a sphere"),
        }
    };
    assert_eq!(radius(&[]), 12.5);
    assert_eq!(radius(&[("r", "3")]), 13.5);
    assert_eq!(radius(&[("rr", "7"), ("r", "3")]), 7.5);
}

#[test]
fn references_may_point_forward_and_inward_and_share_what_they_name() {
    let scene = scene(
        r#"<shape type="sphere"><ref id="late"/></shape>
           <shape type="sphere"><bsdf type="conductor" id="inner"/></shape>
           <shape type="sphere"><ref id="inner"/></shape>
           <shape type="sphere"><emitter type="area"><ref id="light" name="radiance"/></emitter></shape>
           <spectrum type="uniform" id="light"><float name="value" value="3"/></spectrum>
           <bsdf type="diffuse" id="late"/>"#,
    );
    assert_eq!(scene.shapes[0].bsdf.id.as_deref(), Some("late"));
    assert!(Arc::ptr_eq(&scene.shapes[1].bsdf, &scene.shapes[2].bsdf));
    let emission = scene.shapes[3].emission.as_ref().unwrap();
    assert!(matches!(emission.kind, SpectrumKind::Constant(3.0)));
}

#[test]
fn spectra_have_the_forms_of_mitsuba() {
    let kind = |spectrum: &str| {
        let shape = shape(&format!(r#"<shape type="sphere"><bsdf type="diffuse">{spectrum}</bsdf></shape>"#));
        match &shape.bsdf.kind {
            BsdfKind::Diffuse { reflectance } => format!("{:?}", reflectance.kind),
            _ => panic!("not diffuse"),
        }
    };
    assert_eq!(kind(r#"<float name="reflectance" value="0.3"/>"#), "Constant(0.3)");
    assert_eq!(kind(r#"<integer name="reflectance" value="1"/>"#), "Constant(1.0)");
    assert_eq!(kind(r#"<spectrum name="reflectance" value=" 0.3 "/>"#), "Constant(0.3)");
    let list = "Irregular { nm: [400.0, 700.0], values: [0.5, 0.6], file: None }";
    assert_eq!(kind(r#"<spectrum name="reflectance" value="400:0.5 700:0.6"/>"#), list);
    assert_eq!(kind(r#"<spectrum name="reflectance" value="400:0.5,, 700:0.6,"/>"#), list);
    let nested = r#"<texture name="reflectance" type="irregular"><string name="wavelengths" value="400, 700"/><string name="values" value="0.5 0.6"/></texture>"#;
    assert_eq!(kind(nested), list);
    let regular = r#"<spectrum name="reflectance" type="regular"><integer name="wavelength_min" value="400"/><float name="wavelength_max" value="700"/><string name="values" value="0.5, 0.6"/></spectrum>"#;
    assert_eq!(kind(regular), "Regular { min_nm: 400.0, max_nm: 700.0, values: [0.5, 0.6] }");
    let file = kind(r#"<spectrum name="reflectance" filename="tests/scenes/broken/wall.spd"/>"#);
    assert!(file.contains("[400.0, 500.0], values: [0.5, 0.6]"), "{file}");
}

#[test]
fn numbers_are_written_as_mitsuba_reads_them() {
    for (text, value) in [("1", 1.0), (" 1.5 ", 1.5), ("1e0", 1.0), ("+1", 1.0), (".5", 0.5), ("5.", 5.0)] {
        let shape = shape(&format!(r#"<shape type="sphere"><float name="radius" value="{text}"/></shape>"#));
        assert!(matches!(shape.kind, ShapeKind::Sphere { radius, .. } if radius == value), "{text}");
    }
    for text in ["0x10", "1f", "1_0", "1;", "inf", "nan", ""] {
        errors(&format!(r#"<shape type="sphere"><float name="radius" value="{text}"/></shape>"#));
    }
    for text in ["true", "True", "FALSE"] {
        shape(&format!(r#"<shape type="sphere"><boolean name="flip_normals" value="{text}"/></shape>"#));
    }
    for text in ["1", "yes", " true"] {
        errors(&format!(r#"<shape type="sphere"><boolean name="flip_normals" value="{text}"/></shape>"#));
    }
}

#[test]
fn independent_errors_come_together_in_the_order_of_the_file() {
    let message =
        errors(r#"<shape type="sphere"><float name="radius" value="0"/></shape><shape type="spher"/>"#);
    let (first, second) = (message.find("\"radius\"").unwrap(), message.find("spher\"").unwrap());
    assert!(first < second, "{message}");
    assert_eq!(message.matches("error:").count(), 2, "{message}");
    // Used twice, wrong once.
    let message = errors(
        r#"<bsdf type="diffuse" id="a"><float name="reflectance" value="2"/></bsdf>
           <shape type="sphere"><ref id="a"/></shape><shape type="sphere"><ref id="a"/></shape>"#,
    );
    assert_eq!(message.matches("error:").count(), 1, "{message}");
    // A value that is wrong is not called missing as well.
    let message = errors(r#"<shape type="ply"><string name="filename" value="$nothing"/></shape>"#);
    assert_eq!(message.matches("error:").count(), 1, "{message}");
}

#[test]
fn a_byte_order_mark_comments_and_declarations_are_fine() {
    let text = "\u{feff}<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<!-- é -->\n<scene version=\"3.9.1\"><!-- x --><sensor type=\"perspective\"/></scene>\n";
    read(text).unwrap();
}

#[test]
fn the_outline_tells_defaults_extensions_and_assumptions() {
    let scene = scene(
        r#"<shape type="sphere" id="ball"><bsdf type="roughconductor"><spectrum name="normal_reflectance" value="0.9"/></bsdf></shape>
           <shape type="cube"><bsdf type="dielectric"><spectrum name="int_ior" type="measured"><string name="name" value="BK7"/></spectrum></bsdf></shape>"#,
    );
    let outline = abbe::scene::outline(&scene);
    for part in [
        "width: 768",
        "rfilter: gaussian (line 1)\n        stddev: 0.5",
        "shape: sphere \"ball\"",
        "distribution: beckmann",
        "assume: k=0",
        "int_ior: measured (line 2, extension)\n        name: BK7",
        "extensions",
        "assumptions",
    ] {
        assert!(outline.contains(part), "{part} is not in\n{outline}");
    }
}

#[test]
fn the_hash_depends_on_meaning_not_on_layout() {
    let hash = |text: &str| scene(text).hash();
    let ball = hash(r#"<shape type="sphere"/>"#);
    assert_eq!(
        ball,
        hash(
            "\n\n<!-- a ball -->  <shape type=\"sphere\" id=\"b\"><float name=\"radius\" value=\"1.0\"/></shape>"
        )
    );
    assert_ne!(ball, hash(r#"<shape type="sphere"><float name="radius" value="1.0000000001"/></shape>"#));
    let listed = |value: &str| {
        hash(&format!(
            r#"<shape type="sphere"><bsdf type="diffuse"><spectrum name="reflectance" value="400:0.1, {value}"/></bsdf></shape>"#
        ))
    };
    assert_eq!(listed("700:0.5"), listed("700:.5"));
    assert_ne!(listed("700:0.5"), listed("700:0.50001"));
}

/// Round numbers differ in few bits, the highest. The probability that two of 2400 hashes are the same by
/// chance is 10⁻¹³.
#[test]
fn scenes_of_round_numbers_have_hashes_of_their_own() {
    let hash = |radius: f64, fov: u32| {
        let scene = format!(
            r#"<sensor type="perspective"><float name="fov" value="{fov}"/></sensor>
               <shape type="sphere"><float name="radius" value="{radius}"/></shape>"#
        );
        described(&scene).hash()
    };
    let numbers = (1..=60).flat_map(|quarters| (10..50).map(move |fov| (0.25 * f64::from(quarters), fov)));
    let hashes: Vec<u64> = numbers.map(|(radius, fov)| hash(radius, fov)).collect();
    let different: BTreeSet<&u64> = hashes.iter().collect();
    assert_eq!(different.len(), hashes.len());
}
