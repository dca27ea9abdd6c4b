//! Textures in whole renders: patterns stick to what moves and to what is instanced, and reliefs make no energy.

mod common;

use abbe::render::{Settings, WavelengthCount};
use abbe::scene::{CompileOptions, ReadOptions, Scene, compile, read_str};
use abbe::stats::sidak;
use abbe::units::WavelengthRange;
use common::{bins, expose, mean_over_pixels, settings};
use statrs::distribution::{ContinuousCDF, Normal};
use std::path::Path;

fn compiled(content: &str) -> Scene {
    let text = format!("<scene version=\"3.0.0\">{content}</scene>");
    let description = read_str(text, Path::new("scene.xml"), &ReadOptions::default())
        .unwrap_or_else(|errors| panic!("{errors}"));
    let options = CompileOptions { spectral: true, ..CompileOptions::default() };
    compile(&description, &options).unwrap_or_else(|errors| panic!("{errors}"))
}

const SIZE: u32 = 24;

/// What a camera sees of something that shines by its texture.
fn picture(camera: &str, content: &str) -> Vec<f64> {
    let scene = compiled(&format!(
        r#"<integrator type="path"><integer name="max_depth" value="1"/></integrator>
           <sensor type="perspective"><float name="fov" value="30"/>{camera}
           <float name="shutter_open" value="0"/><float name="shutter_close" value="1"/>
           <film type="hdrfilm"><integer name="width" value="{SIZE}"/><integer name="height" value="{SIZE}"/>
           <rfilter type="box"/></film></sensor>{content}"#
    ));
    let film = expose(&scene, &settings(8, WavelengthCount::Four, 1));
    let pixels = (0..SIZE).flat_map(|y| (0..SIZE).map(move |x| (x, y)));
    pixels.map(|(x, y)| film.combined(x, y, [0.0, 1.0, 0.0]).mean).collect()
}

const LOOK: &str = r#"<lookat origin="1, -6, 2" target="0.2, 0.1, 0" up="0, 0, 1"/>"#;
const AWAY: &str = r#"<rotate x="1" y="2" z="-0.5" angle="70"/><translate x="3" y="-4" z="40"/>"#;

/// `to_world` of something that stands still, or is carried away in the course of the exposure.
fn placed(steps: &str, carried: bool) -> String {
    match carried {
        false => format!(r#"<transform name="to_world">{steps}</transform>"#),
        true => format!(
            r#"<animation name="to_world"><transform time="0">{steps}</transform>
               <transform time="1">{steps}{AWAY}</transform></animation>"#
        ),
    }
}

/// A ball that reflects everything at once, by a pattern: under light from everywhere its radiance is the pattern's value.
fn ball(pattern: &str) -> String {
    format!(
        r#"<bsdf type="conductor"><texture type="{pattern}" name="specular_reflectance">
           <float name="period" value="0.3"/></texture></bsdf>"#
    )
}

const DAY: &str = r#"<emitter type="constant"><spectrum name="radiance" value="1"/></emitter>"#;
const TURNED: &str = r#"<rotate y="1" angle="30"/><translate x="0.3" y="0.2"/>"#;

fn assert_same(what: &str, found: &[f64], expected: &[f64]) {
    let largest = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let most = expected.iter().copied().fold(0.0, f64::max);
    assert!(largest < 1e-6 * most, "{what}: {largest} of {most}");
}

/// The camera is carried along with what it looks at, through 70 degrees and 40 units, and by what an instance is moved.
#[test]
fn patterns_stick_to_what_moves_and_to_instances() {
    let see = |pattern: &str, moves: bool| {
        let shape = format!(r#"<shape type="sphere">{}{}</shape>"#, placed(TURNED, moves), ball(pattern));
        picture(&placed(LOOK, moves), &format!("{shape}{DAY}"))
    };
    let instanced = |pattern: &str| {
        let shape = format!(r#"<shape type="sphere">{}{}</shape>"#, placed(TURNED, false), ball(pattern));
        let group = format!(r#"<shape type="shapegroup" id="group">{shape}</shape>"#);
        let instance = format!(
            r#"<shape type="instance"><ref id="group"/><transform name="to_world">{AWAY}</transform></shape>"#
        );
        picture(&placed(&format!("{LOOK}{AWAY}"), false), &format!("{group}{instance}{DAY}"))
    };
    for pattern in ["noise", "marble", "wood", "bands"] {
        let still = see(pattern, false);
        let (least, most) = still.iter().fold((f64::INFINITY, 0.0f64), |(a, b), &y| (a.min(y), b.max(y)));
        assert!(least < 0.7 * most, "{pattern} cannot be seen: {least} to {most}");
        assert_same(&format!("{pattern} moves"), &see(pattern, true), &still);
        assert_same(&format!("{pattern} instanced"), &instanced(pattern), &still);
    }
}

/// The transform of a pattern in space takes it along like a body's own.
#[test]
fn a_pattern_is_placed_by_its_own_transform() {
    let see = |steps: &str, place: &str, camera: &str| {
        let texture = format!(
            r#"<bsdf type="conductor"><texture type="wood" name="specular_reflectance">
               <float name="period" value="0.3"/>{place}</texture></bsdf>"#
        );
        let shape = format!(r#"<shape type="sphere">{}{texture}</shape>"#, placed(steps, false));
        picture(&placed(camera, false), &format!("{shape}{DAY}"))
    };
    let carried = format!("{TURNED}{AWAY}");
    let expected = see(TURNED, "", LOOK);
    let camera = format!("{LOOK}{AWAY}");
    assert_same("both carried", &see(&carried, &placed(AWAY, false), &camera), &expected);
}

/// Standard errors within which all of `tests` results lie with 99 % probability if nothing is wrong. Never less than 3.
fn bound(tests: usize) -> f64 {
    Normal::standard().inverse_cdf(1.0 - sidak(0.01, tests) / 2.0).max(3.0)
}

/// A white or clear ball with a bumpy surface in a furnace of radiance 1 never returns more than 1: what a relief's normals would send
/// to the wrong side is lost, not gained.
#[test]
fn reliefs_make_no_energy() {
    let heights = [
        r#"<texture type="noise"><float name="period" value="0.3"/><integer name="octaves" value="3"/></texture>"#,
        r#"<texture type="turbulence"><float name="period" value="0.5"/></texture>"#,
        r#"<texture type="bands"><string name="space" value="uv"/><float name="period" value="0.1"/>
           <boolean name="interpolate" value="true"/></texture>"#,
        r#"<texture type="bitmap"><string name="filename" value="tests/scenes/textures/heights.png"/>
           <boolean name="raw" value="true"/></texture>"#,
    ];
    let bsdfs = [
        r#"<bsdf type="diffuse"><spectrum name="reflectance" value="1"/></bsdf>"#,
        r#"<bsdf type="conductor"/>"#,
        r#"<bsdf type="roughconductor"><float name="alpha" value="0.3"/><string name="distribution" value="ggx"/></bsdf>"#,
        r#"<bsdf type="dielectric"/>"#,
        r#"<bsdf type="roughdielectric"><float name="alpha" value="0.3"/></bsdf>"#,
        r#"<bsdf type="plastic"><spectrum name="diffuse_reflectance" value="1"/></bsdf>"#,
    ];
    let bound = bound(heights.len() * bsdfs.len() * 4);
    for (i, height) in heights.iter().enumerate() {
        for bsdf in bsdfs {
            for (scale, shadowing) in [(0.05, true), (0.05, false), (0.5, true), (0.5, false)] {
                let scene = compiled(&format!(
                    r#"<integrator type="path"/><sensor type="perspective"><float name="fov" value="20"/>
                       <transform name="to_world"><lookat origin="0, 0, 5" target="0, 0, 0" up="0, 1, 0"/></transform>
                       <film type="hdrfilm"><integer name="width" value="4"/><integer name="height" value="4"/><rfilter type="box"/></film></sensor>
                       <shape type="sphere"><bsdf type="bumpmap"><float name="scale" value="{scale}"/>
                       <boolean name="use_shadowing_function" value="{shadowing}"/>{height}{bsdf}</bsdf></shape>{DAY}"#
                ));
                let one_bin = bins(WavelengthRange::VISIBLE, 1);
                let film =
                    expose(&scene, &Settings { bins: one_bin, ..settings(2048, WavelengthCount::Four, 5) });
                let (mean, error) = mean_over_pixels(&film, |x, y| film.bin(x, y, 0));
                println!("height {i}, scale {scale}, {shadowing}, {bsdf}: {mean:.4} ± {error:.1e}");
                assert!(mean <= 1.0 + bound * error, "{height}, {scale}, {bsdf}: {mean} ± {error}");
                assert!(mean > 0.2, "{height}, {scale}, {bsdf}: {mean} ± {error} is nearly black");
            }
        }
    }
}
