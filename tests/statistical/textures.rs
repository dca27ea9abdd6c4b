//! Textures in whole renders: patterns stick to what moves and to what is instanced, and reliefs make no
//! energy.

use crate::common::{bins, bound, expose, found, made, mean_over_pixels, settings, stress};
use abbe::render::{Settings, WavelengthCount};
use abbe::scene::{CompileOptions, Scene};
use abbe::units::WavelengthRange;

fn compiled(content: &str) -> Scene {
    made(content, &CompileOptions { spectral: true, ..CompileOptions::default() })
}

const SIZE: u32 = 24;

/// What a camera sees of something that shines by its texture.
fn picture(camera: &str, content: &str) -> Vec<f64> {
    let scene = compiled(&format!(
        r#"<integrator type="path"><integer name="max_depth" value="1"/></integrator>
           <sensor type="perspective"><float name="fov" value="30"/>{camera}
           <float name="shutter_open" value="0.5"/><float name="shutter_close" value="0.5"/>
           <film type="hdrfilm"><integer name="width" value="{SIZE}"/><integer name="height" value="{SIZE}"/>
           <rfilter type="box"/></film></sensor>{content}"#
    ));
    let film = expose(&scene, &settings(8, WavelengthCount::Four, 1));
    let pixels = (0..SIZE).flat_map(|y| (0..SIZE).map(move |x| (x, y)));
    pixels.map(|(x, y)| film.combined(x, y, [0.0, 1.0, 0.0]).mean).collect()
}

const LOOK: &str = r#"<lookat origin="1, -6, 2" target="0.2, 0.1, 0" up="0, 0, 1"/>"#;
const AWAY: &str = r#"<rotate x="0.6" z="0.8" angle="70"/><translate x="3" y="-4" z="40"/>"#;

fn placed(steps: &str) -> String {
    format!(r#"<transform name="to_world">{steps}</transform>"#)
}

/// A ball that reflects everything at once, by a pattern: under light from everywhere its radiance is the
/// pattern's value.
fn ball(pattern: &str, place: &str) -> String {
    format!(
        r#"<bsdf type="conductor"><texture type="{pattern}" name="specular_reflectance">
           <float name="period" value="0.3"/>{place}</texture></bsdf>"#
    )
}

const PATTERNS: [&str; 4] = ["noise", "marble", "wood", "bands"];
const DAY: &str = r#"<emitter type="constant"><spectrum name="radiance" value="1"/></emitter>"#;
const TURNED: &str = r#"<rotate y="1" angle="30"/><translate x="0.3" y="0.2"/>"#;

fn assert_same(what: &str, found: &[f64], expected: &[f64]) {
    let largest = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let most = expected.iter().copied().fold(0.0, f64::max);
    assert!(largest < 1e-6 * most, "{what}: {largest} of {most}");
}

/// A ball of a pattern, seen by a camera.
fn see(pattern: &str, to_world: &str, place: &str, camera: &str) -> Vec<f64> {
    let shape = format!(r#"<shape type="sphere">{to_world}{}</shape>"#, ball(pattern, place));
    picture(&placed(camera), &format!("{shape}{DAY}"))
}

/// Whether the pattern can be seen at all.
fn assert_varied(pattern: &str, pixels: &[f64]) {
    let (least, most) = pixels.iter().fold((f64::INFINITY, 0.0f64), |(a, b), &y| (a.min(y), b.max(y)));
    assert!(least < 0.7 * most, "{pattern} cannot be seen: {least} to {most}");
}

/// In the middle of its way a ball has turned by half of the angle: so has its pattern.
#[test]
fn patterns_stick_to_what_moves() {
    for pattern in PATTERNS {
        let key = |time: f64| {
            let (angle, way) = (90.0 * time, 1.6 * time - 0.8);
            format!(r#"<rotate x="0.6" z="0.8" angle="{angle}"/><translate x="{way}" y="0.5"/>"#)
        };
        let keys = [0.0, 1.0].map(|time| format!(r#"<transform time="{time}">{}</transform>"#, key(time)));
        let moving =
            see(pattern, &format!(r#"<animation name="to_world">{}</animation>"#, keys.concat()), "", LOOK);
        // From where it stands at first to where it is then, which takes the pattern along.
        let carried =
            r#"<translate x="0.8" y="-0.5"/><rotate x="0.6" z="0.8" angle="45"/><translate y="0.5"/>"#;
        let still = see(pattern, &placed(&key(0.5)), &placed(carried), LOOK);
        assert_varied(pattern, &still);
        assert_same(&format!("{pattern} moves"), &moving, &still);
    }
}

#[test]
fn patterns_stick_to_instances() {
    for pattern in PATTERNS {
        let shape = format!(r#"<shape type="sphere">{}{}</shape>"#, placed(TURNED), ball(pattern, ""));
        let group = format!(r#"<shape type="shapegroup" id="group">{shape}</shape>"#);
        let instance = format!(r#"<shape type="instance"><ref id="group"/>{}</shape>"#, placed(AWAY));
        let camera = placed(&format!("{LOOK}{AWAY}"));
        let found = picture(&camera, &format!("{group}{instance}{DAY}"));
        assert_same(&format!("{pattern} instanced"), &found, &see(pattern, &placed(TURNED), "", LOOK));
    }
}

/// The transform of a pattern in space takes it along like a body's own.
#[test]
fn a_pattern_is_placed_by_its_own_transform() {
    let camera = format!("{LOOK}{AWAY}");
    let found = see("wood", &placed(&format!("{TURNED}{AWAY}")), &placed(AWAY), &camera);
    assert_same("both carried", &found, &see("wood", &placed(TURNED), "", LOOK));
}

/// A white or clear ball with a bumpy surface in a furnace of radiance 1 never returns more than an even
/// surface, 1: what a relief's normals would send to the wrong side is lost, not gained. What is lost, by
/// rough facets too, hides a gain as large. So the gain that is found, with a probability of 90 %, stands
/// beside each BSDF for the relief that hides least of it. On the steepest relief a gain below most of the
/// light is not found.
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
        (r#"<bsdf type="diffuse"><spectrum name="reflectance" value="1"/></bsdf>"#, 0.005),
        (r#"<bsdf type="conductor"/>"#, 0.005),
        (
            r#"<bsdf type="roughconductor"><float name="alpha" value="0.3"/><string name="distribution" value="ggx"/></bsdf>"#,
            0.16,
        ),
        (r#"<bsdf type="dielectric"/>"#, 0.015),
        (r#"<bsdf type="roughdielectric"><float name="alpha" value="0.3"/></bsdf>"#, 0.1),
        (r#"<bsdf type="plastic"><spectrum name="diffuse_reflectance" value="1"/></bsdf>"#, 0.01),
    ];
    let bound = bound(heights.len() * bsdfs.len() * 4);
    let samples = stress::count(256, 4096);
    for (bsdf, sees) in bsdfs {
        let mut least = f64::INFINITY;
        for (i, height) in heights.iter().enumerate() {
            for (scale, shadowing) in [(0.05, true), (0.05, false), (0.5, true), (0.5, false)] {
                let scene = compiled(&format!(
                    r#"<integrator type="path"/><sensor type="perspective"><float name="fov" value="20"/>
                       <transform name="to_world"><lookat origin="0, 0, 5" target="0, 0, 0" up="0, 1, 0"/></transform>
                       <film type="hdrfilm"><integer name="width" value="4"/><integer name="height" value="4"/><rfilter type="box"/></film></sensor>
                       <shape type="sphere"><bsdf type="bumpmap"><float name="scale" value="{scale}"/>
                       <boolean name="use_shadowing_function" value="{shadowing}"/>{height}{bsdf}</bsdf></shape>{DAY}"#
                ));
                let one_bin = bins(WavelengthRange::VISIBLE, 1);
                let film = expose(
                    &scene,
                    &Settings { bins: one_bin, ..settings(samples, WavelengthCount::Four, 5) },
                );
                let (mean, error) = mean_over_pixels(&film, |x, y| film.bin(x, y, 0));
                println!("height {i}, scale {scale}, {shadowing}, {bsdf}: {mean:.4} ± {error:.1e}");
                assert!(mean <= 1.0 + bound * error, "{height}, {scale}, {bsdf}: {mean} ± {error}");
                assert!(mean > 0.1, "{height}, {scale}, {bsdf}: {mean} ± {error} is nearly black");
                least = least.min(1.0 - mean + found(bound) * error);
            }
        }
        assert!(least < sees, "{bsdf}: a gain of less than {least} is not found");
    }
}
