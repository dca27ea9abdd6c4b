//! Indices beyond the ends of what the file says of them.

use super::{errors, scene as described};
use crate::common::compiled;
use abbe::bsdf::{AIR_INDEX, Bsdf, RoughConductor};
use abbe::geometry::{Ray, Vec3};
use abbe::material::Shading;
use abbe::scene::description::Description;
use abbe::scene::{CompileOptions, RayKind, ReadOptions, Scene, compile, json, read_str};
use abbe::spectrum::normal_reflectance::reflectance_of_index;
use abbe::spectrum::{Sampled, Wavelengths};
use abbe::units::WavelengthRange;
use std::path::Path;

fn scene(bsdf: &str) -> Description {
    described(&format!(r#"<shape type="sphere">{bsdf}</shape>"#))
}

/// How the surface of a scene scatters where a ray meets it.
fn shading(scene: &Scene, ray: &Ray, nm: f64) -> Shading<1> {
    let wavelengths = Wavelengths { nm: [nm], density: Sampled([1.0]) };
    let mut media = scene.media_at_sensor(ray, 0.0);
    let hit = scene.intersect(ray, 0.0, RayKind::Scattered, &mut media, |_, _| {}).expect("a surface");
    scene.shade(&hit, -ray.direction, &media, &wavelengths, 0.0)
}

/// The index of a ball of glass, which stands in air.
fn glass(description: &Description, nm: f64) -> f64 {
    let scene = compiled(description, &CompileOptions::default());
    let ray = Ray::new(Vec3::new(0.0, 0.0, 3.0), Vec3::NEG_Z);
    AIR_INDEX * shading(&scene, &ray, nm).index_beyond().expect("glass")
}

/// n and k of a square of metal at a place of its surface.
fn metal(description: &Description, uv: [f64; 2], nm: f64) -> (f64, f64) {
    let scene = compiled(description, &CompileOptions::default());
    let [x, y] = uv.map(|u| 2.0 * u - 1.0);
    match shading(&scene, &Ray::new(Vec3::new(x, y, 1.0), Vec3::NEG_Z), nm).bsdf {
        Bsdf::Conductor(facet) | Bsdf::RoughConductor(RoughConductor { facet, .. }) => {
            (facet.eta.hero(), facet.k.hero())
        }
        other => panic!("no metal but {other:?}"),
    }
}

/// The example of docs/scene-format.md: a glass known from 400 to 700 nm stays glass at 360 and at 830 nm.
#[test]
fn a_glass_known_by_its_reflectance_is_held_beyond_the_table() {
    let scene = scene(
        r#"<bsdf type="dielectric"><spectrum name="normal_reflectance" value="400:0.05, 700:0.04"/></bsdf>"#,
    );
    let reflectance = |nm: f64| reflectance_of_index(glass(&scene, nm), 0.0);
    for (nm, expected) in [(360.0, 0.05), (399.0, 0.05), (550.0, 0.045), (701.0, 0.04), (830.0, 0.04)] {
        assert!((reflectance(nm) - expected).abs() < 1e-6, "{nm} nm: {}", reflectance(nm));
    }
    let told = |note: &&abbe::scene::description::Note| note.text.contains("400–700 nm");
    assert_eq!(scene.assumptions.iter().filter(told).count(), 1, "{:?}", scene.assumptions);
}

/// Metals, whatever is assumed of them, beside a known index whose table is shorter yet, and with indices
/// from tables.
#[test]
fn a_metal_is_held_beyond_its_tables() {
    const R: &str = r#"<spectrum name="normal_reflectance" value="400:0.5, 700:0.9"/>"#;
    let of = |content: &str| {
        described(&format!(r#"<shape type="rectangle"><bsdf type="conductor">{content}</bsdf></shape>"#))
    };
    let n_is_1 = r#"<string name="assume" value="n=1"/>"#;
    let known = r#"<spectrum name="eta" value="450:0.5, 600:0.3"/>"#;
    for beside in ["", n_is_1, known] {
        let scene = of(&format!("{R}{beside}"));
        for (nm, expected) in [(360.0, 0.5), (830.0, 0.9)] {
            let (n, k) = metal(&scene, [0.5; 2], nm);
            let found = reflectance_of_index(n, k);
            assert!((found - expected).abs() < 1e-6, "{beside} at {nm} nm: {found}");
        }
        for table in if beside == known { &["400–700 nm", "450–600 nm"][..] } else { &["400–700 nm"] } {
            assert!(
                scene.assumptions.iter().any(|note| note.text.contains(table)),
                "{:?}",
                scene.assumptions
            );
        }
    }
    let measured =
        of(r#"<spectrum name="eta" value="400:0.5, 700:0.3"/><spectrum name="k" value="400:2, 700:4"/>"#);
    assert_eq!(metal(&measured, [0.5; 2], 360.0), (0.5, 2.0));
    assert_eq!(metal(&measured, [0.5; 2], 830.0), (0.3, 4.0));
}

/// A checkerboard of two tables, one of them within another texture.
#[test]
fn a_metal_that_varies_is_held_beyond_its_tables() {
    let scene = described(
        r#"<shape type="rectangle"><bsdf type="roughconductor"><texture type="checkerboard" name="normal_reflectance">
           <spectrum name="color0" value="400:0.5, 700:0.9"/>
           <texture type="bands" name="color1"><string name="space" value="uv"/>
               <spectrum name="color0" value="500:0.2, 600:0.3"/><spectrum name="color1" value="500:0.2, 600:0.3"/></texture>
           </texture></bsdf></shape>"#,
    );
    for (uv, ends) in [([0.25; 2], [0.5, 0.9]), ([0.25, 0.75], [0.2, 0.3])] {
        for (nm, expected) in [360.0, 830.0].into_iter().zip(ends) {
            let (n, k) = metal(&scene, uv, nm);
            let found = reflectance_of_index(n, k);
            assert!((found - expected).abs() < 1e-6, "{uv:?} at {nm} nm: {found}");
        }
    }
    for table in ["400–700 nm", "500–600 nm"] {
        assert!(scene.assumptions.iter().any(|note| note.text.contains(table)), "{:?}", scene.assumptions);
    }
}

/// A slab's back face reflects too: what is left is the index of its glass. A metal has no back face.
#[test]
fn the_back_face_of_a_slab_is_taken_away() {
    let face = reflectance_of_index(1.5168, 0.0);
    let both = 2.0 * face / (1.0 + face);
    let of = |plugin: &str, content: &str| {
        format!(
            r#"<bsdf type="{plugin}"><spectrum name="normal_reflectance" value="{both}"/>{content}</bsdf>"#
        )
    };
    let slab = r#"<string name="specimen" value="slab"/>"#;
    let known = scene(&of("dielectric", slab));
    assert!((glass(&known, 550.0) - 1.5168).abs() < 1e-12, "{}", glass(&known, 550.0));
    assert!(known.assumptions.iter().any(|note| note.text.contains("both faces")), "{:?}", known.assumptions);
    let features = compile(&known, &CompileOptions::default()).unwrap().features();
    let again =
        read_str(json(&known, &features, None), Path::new("scene.json"), &ReadOptions::default()).unwrap();
    assert_eq!(again.hash(), known.hash());
    let one_face = scene(&of("dielectric", r#"<string name="specimen" value="face"/>"#));
    assert_eq!(one_face.hash(), scene(&of("dielectric", "")).hash());
    assert_ne!(one_face.hash(), known.hash());
    let refused = |bsdf: &str| errors(&format!(r#"<shape type="sphere">{bsdf}</shape>"#));
    assert!(refused(&of("conductor", slab)).contains("no back face"));
    let lonely = refused(&format!(r#"<bsdf type="dielectric">{slab}</bsdf>"#));
    assert!(lonely.contains("specimen"), "{lonely}");
    assert!(refused(&of("dielectric", &slab.replace("slab", "slap"))).contains("did you mean \"slab\"?"));
}

/// The range of a render decides whether a table is long enough.
#[test]
fn what_is_held_is_told_of_renders_that_ask_for_it() {
    let scene = scene(
        r#"<bsdf type="dielectric"><spectrum name="normal_reflectance" value="400:0.05, 700:0.04"/></bsdf>"#,
    );
    let held = |range| {
        let scene = scene.clone().over(range);
        scene.assumptions.iter().filter(|note| note.text.contains("held beyond")).count()
    };
    assert_eq!(held(WavelengthRange::VISIBLE), 1);
    assert_eq!(held(WavelengthRange { min: 400.0, max: 700.0 }), 0);
}
