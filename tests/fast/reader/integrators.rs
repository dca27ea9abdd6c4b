//! Integrators that stand for others or write more than a picture, and what goes with them in the files of
//! Mitsuba 3.

use super::{errors, scene};
use abbe::scene::description::{Aov, AovKind, BsdfKind, IntegratorKind, SpectrumKind};
use abbe::scene::{CompileOptions, ReadOptions, compile, json, read_str};
use std::path::Path;

/// What the remarks, extensions and assumptions of a scene say.
fn notes(content: &str) -> String {
    let scene = scene(content);
    let all = [scene.remarks, scene.extensions, scene.assumptions].concat();
    all.into_iter().map(|note| note.text).collect::<Vec<_>>().join("\n")
}

/// As the official Cornell box has it.
#[test]
fn an_area_light_may_stand_in_the_scene_where_shapes_refer_to_it() {
    let emitter = r#"<emitter type="area" id="lamp"><rgb name="radiance" value="18, 11, 3"/></emitter>"#;
    for order in [
        "<shape type=\"rectangle\"><ref id=\"lamp\"/></shape>EMITTER",
        "EMITTER<shape type=\"rectangle\"><ref id=\"lamp\"/></shape>",
    ] {
        let scene = scene(&order.replace("EMITTER", emitter));
        assert!(scene.lights.is_empty());
        assert!(scene.shapes[0].emission.is_some());
        assert!(scene.extensions.is_empty(), "{:?}", scene.extensions);
    }
    // Mitsuba 3 refuses the second.
    let two = format!(
        "{emitter}<shape type=\"sphere\"><ref id=\"lamp\"/></shape><shape type=\"disk\"><ref id=\"lamp\"/></shape>"
    );
    assert!(scene(&two).shapes.iter().all(|shape| shape.emission.is_some()));
    assert!(notes(&two).contains("of several shapes"), "{}", notes(&two));
    // What no shape refers to would be dark.
    assert!(errors(emitter).contains("An area light needs a shape"));
    let broken = r#"<emitter type="area" id="a"><float name="radiance" value="-1"/></emitter><shape type="disk"><ref id="a"/></shape>"#;
    assert_eq!(errors(broken).matches("error").count(), 1);
}

#[test]
fn an_aov_integrator_lists_images_and_holds_the_picture() {
    let content = r#"<integrator type="aov"><string name="aovs" value="nn:sh_normal, position:position,depth.y:depth"/>
        <integrator type="volpath" name="image"><integer name="max_depth" value="3"/></integrator></integrator>"#;
    let integrator = scene(content).integrator;
    assert_eq!((integrator.kind, integrator.max_depth), (IntegratorKind::VolPath, Some(3)));
    let channels: Vec<String> = integrator.aovs.iter().flat_map(Aov::channels).collect();
    // As Mitsuba 3.9.1 names them.
    assert_eq!(channels, ["nn.X", "nn.Y", "nn.Z", "position.X", "position.Y", "position.Z", "depth.y.T"]);
    for (name, kind) in AovKind::NAMES {
        let text = format!(r#"<integrator type="aov"><string name="aovs" value="a:{name}"/></integrator>"#);
        assert_eq!(scene(&text).integrator.aovs, [Aov { name: "a".to_owned(), kind }]);
        assert!(notes(&text).contains("the picture is black"));
    }
    for (aovs, expected) in [
        ("depth", "write for instance depth:depth"),
        ("a:normal", "sh_normal or geo_normal"),
        ("a:detph", "did you mean \"depth\"?"),
        ("a:duv_dx", "not supported"),
        ("a:uv, a:uv", "\"a.U\""),
        ("error:albedo", "\"error\""),
    ] {
        let text = format!(r#"<integrator type="aov"><string name="aovs" value="{aovs}"/></integrator>"#);
        assert!(errors(&text).contains(expected), "{aovs}: {}", errors(&text));
    }
    let several = r#"<integrator type="aov"><string name="aovs" value="a:uv"/><integrator type="path"/><integrator type="direct"/></integrator>"#;
    assert!(errors(several).contains("several integrators"));
    assert!(
        errors(r#"<integrator type="aov"><integrator type="path"/></integrator>"#)
            .contains("lists no images")
    );
}

#[test]
fn moments_have_the_names_that_mitsuba_gives_them() {
    let stems = |content: &str| scene(content).integrator.moments.expect("moments").stems();
    let unnamed = r#"<integrator type="moment"><integrator type="direct"/></integrator>"#;
    assert_eq!(scene(unnamed).integrator.kind, IntegratorKind::Direct);
    assert_eq!(stems(unnamed), ["_arg_0", "m2__arg_0"]);
    let named = r#"<integrator type="moment"><integrator type="path" name="inner"/></integrator>"#;
    assert_eq!(stems(named), ["inner", "m2_inner"]);
    let within = r#"<integrator type="aov"><string name="aovs" value="dd:depth"/><integrator type="moment" name="a"><integrator type="path" name="q"/></integrator></integrator>"#;
    assert_eq!(stems(within), ["a.q", "a.m2_q"]);
    for content in [unnamed, named, within] {
        let text = format!("<scene version=\"3.0.0\"><sensor type=\"perspective\"/>{content}</scene>");
        let first = read_str(text, Path::new("scene.xml"), &ReadOptions::default()).unwrap();
        let compiled = compile(&first, &CompileOptions::default()).unwrap();
        let copy = json(&first, &compiled.features(), None);
        let again = read_str(copy, Path::new("scene.json"), &ReadOptions::default()).unwrap();
        assert_eq!(again.integrator.moments, first.integrator.moments);
        assert_eq!(again.integrator.aovs, first.integrator.aovs);
        assert_eq!(again.integrator.kind, first.integrator.kind);
        assert_eq!(again.hash(), first.hash());
    }
    assert!(errors(r#"<integrator type="moment"/>"#).contains("holds none"));
    let swapped = r#"<integrator type="moment"><integrator type="aov"><string name="aovs" value="dd:depth"/></integrator></integrator>"#;
    assert!(errors(swapped).contains("put the \"moment\" into the \"aov\""));
}

#[test]
fn integrators_with_the_same_picture_stand_for_one_another() {
    // Maximal depths where the file gives none are those of Mitsuba 3.9.1.
    for (plugin, kind, depth) in [
        ("ptracer", IntegratorKind::Path, None),
        ("prb", IntegratorKind::Path, Some(6)),
        ("prb_basic", IntegratorKind::Path, Some(6)),
        ("prb_projective", IntegratorKind::Path, Some(6)),
        ("prbvolpath", IntegratorKind::VolPath, Some(6)),
        ("direct_projective", IntegratorKind::Direct, Some(2)),
    ] {
        let text = format!(r#"<integrator type="{plugin}"/>"#);
        let integrator = scene(&text).integrator;
        assert_eq!((integrator.kind, integrator.max_depth), (kind, depth), "{plugin}");
        assert!(notes(&text).contains("stands for"), "{plugin}");
    }
    let deep = r#"<integrator type="prb"><integer name="max_depth" value="-1"/></integrator>"#;
    assert_eq!(scene(deep).integrator.max_depth, None);
    assert_eq!(scene(r#"<integrator type="depth"/>"#).integrator.kind, IntegratorKind::Depth);
    assert!(
        errors(r#"<integrator type="depth"><integer name="max_depth" value="1"/></integrator>"#)
            .contains("max_depth")
    );
    // What a light subpath never finds is said.
    let glass = r#"<integrator type="ptracer"/><shape type="sphere"><bsdf type="mask"><bsdf type="dielectric"/></bsdf></shape>"#;
    assert!(notes(glass).contains("would leave it dark"), "{}", notes(glass));
    assert!(!notes(r#"<integrator type="ptracer"/><shape type="sphere"/>"#).contains("dark"));
    let parallel =
        r#"<integrator type="ptracer"/><shape type="disk"><emitter type="directionalarea"/></shape>"#;
    assert!(errors(parallel).contains("no path from the camera"));
}

#[test]
fn three_raw_numbers_are_a_normal() {
    let map = r#"<texture name="normalmap" type="rawconstant"><vector name="value" value="0.5, 0.25, 1.0"/></texture>"#;
    let shape = scene(&format!(
        r#"<shape type="sphere"><bsdf type="normalmap">{map}<bsdf type="diffuse"/></bsdf></shape>"#
    ))
    .shapes
    .remove(0);
    let BsdfKind::NormalMap { normals, .. } = &shape.bsdf.kind else { panic!("{shape:?}") };
    assert!(matches!(normals.kind, SpectrumKind::Vector([0.5, 0.25, 1.0])), "{normals:?}");
    let paint = map.replace("normalmap", "reflectance");
    let wrong = errors(&format!(r#"<shape type="sphere"><bsdf type="diffuse">{paint}</bsdf></shape>"#));
    assert!(wrong.contains("is three numbers"), "{wrong}");
}
