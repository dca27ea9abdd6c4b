//! Whole renders of solids: energy, halves that are a whole, and what is refused.

use crate::common::{described, expose, mean_over_pixels, settings};
use abbe::film::{Film, Measured};
use abbe::render::WavelengthCount;
use abbe::scene::{CompileOptions, Scene, compile};
use abbe::stats::{Estimate, sidak, welch};

fn compiled(content: &str) -> Result<Scene, String> {
    with_integrator(content, r#"<integer name="max_depth" value="64"/>"#)
}

fn with_integrator(content: &str, depths: &str) -> Result<Scene, String> {
    let description = described(&format!(
        r#"<integrator type="path">{depths}</integrator>
        <sensor type="perspective">
            <float name="fov" value="40"/>
            <transform name="to_world"><lookat origin="1, 1.5, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
            <film type="hdrfilm">
                <integer name="width" value="12"/><integer name="height" value="12"/>
                <string name="pixel_format" value="xyz"/><rfilter type="box"/>
            </film>
        </sensor>{content}"#
    ));
    compile(&description, &CompileOptions::default()).map_err(|errors| errors.to_string())
}

fn scene(content: &str) -> Scene {
    compiled(content).unwrap_or_else(|errors| panic!("{errors}"))
}

const LUMINANCE: [f64; 3] = [0.0, 1.0, 0.0];

fn luminance(film: &Film) -> (f64, f64) {
    mean_over_pixels(film, |x, y| film.combined(x, y, LUMINANCE))
}

const SKY: &str = r#"<emitter type="constant"><spectrum name="radiance" value="1"/></emitter>"#;

/// Under an even sky glass that absorbs nothing is invisible, however it is cut: a lens, a bubble, a flush
/// bore, a union of abutting parts.
#[test]
fn glass_that_is_cut_neither_gains_nor_loses_light() {
    let glass = r#"<bsdf type="dielectric"><float name="int_ior" value="1.6"/></bsdf>"#;
    let bodies = [
        format!(
            r#"<shape type="intersection">{glass}
                <shape type="sphere"><point name="center" x="0" y="0" z="0.6"/></shape>
                <shape type="sphere"><point name="center" x="0" y="0" z="-0.6"/></shape>
            </shape>"#
        ),
        format!(
            r#"<shape type="difference">{glass}
                <shape type="union">
                    <shape type="cube"><transform name="to_world"><scale value="0.5"/></transform></shape>
                    <shape type="cube"><transform name="to_world"><scale value="0.5"/><translate x="1"/></transform></shape>
                    <shape type="torus"/>
                </shape>
                <shape type="sphere"><float name="radius" value="0.4"/></shape>
                <shape type="cone">
                    <point name="p0" value="0.8, -0.5, 0"/><point name="p1" value="0.8, 0.5, 0"/>
                    <float name="radius" value="0.2"/><float name="radius1" value="0.2"/>
                </shape>
            </shape>"#
        ),
    ];
    let (empty, own) = luminance(&expose(&scene(SKY), &settings(1024, WavelengthCount::Four, 1)));
    for body in bodies {
        let film = expose(&scene(&format!("{body}{SKY}")), &settings(256, WavelengthCount::Four, 2));
        let (mean, error) = luminance(&film);
        println!("{mean} of {empty}, standard error {error}");
        // What paths of more than 64 segments carry is lost.
        assert!((mean - empty).abs() < 4.0 * error.hypot(own) + 1e-3 * empty, "{mean} {empty} {error}");
    }
}

/// Glass in contact with glass and with liquids, in all ways in which a face is that of two bodies: a cup
/// with water, a doublet with one sphere between crown and flint, a bore filled flush at both ends beside
/// another block, balls that touch in a point.
fn touching(glass: &str) -> [String; 4] {
    let dielectric = |index: f64| {
        format!(
            r#"<bsdf type="dielectric"><float name="int_ior" value="{index}"/><float name="ext_ior" value="1"/></bsdf>"#
        )
    };
    let cylinder = |radius: f64, from: f64, to: f64, inner: &str| {
        format!(
            r#"<shape type="cone"><point name="p0" value="0, {from}, 0"/><point name="p1" value="0, {to}, 0"/>
               <float name="radius" value="{radius}"/><float name="radius1" value="{radius}"/>{inner}</shape>"#
        )
    };
    let sphere = |centre: f64, radius: f64, inner: &str| {
        format!(
            r#"<shape type="sphere"><point name="center" x="0" y="0" z="{centre}"/><float name="radius" value="{radius}"/>{inner}</shape>"#
        )
    };
    let cube = |x: f64, inner: &str| {
        format!(
            r#"<shape type="cube"><transform name="to_world"><scale value="0.6"/><translate x="{x}"/></transform>{inner}</shape>"#
        )
    };
    let solid = |operation: &str, content: &str| format!(r#"<shape type="{operation}">{content}</shape>"#);
    let [water, crown, flint] = [1.33, 1.52, 1.75].map(dielectric);
    [
        solid("difference", &(cylinder(0.9, -1.0, 0.8, "") + &cylinder(0.7, -0.8, 0.8, "") + glass))
            + &cylinder(0.7, -0.8, 0.3, &water),
        solid("intersection", &(sphere(1.2, 1.5, "") + &sphere(-1.2, 1.5, "") + glass))
            + &solid(
                "difference",
                &(solid("intersection", &(cylinder(0.8, -0.8, 0.8, "") + &sphere(1.2, 1.8, "")))
                    + &sphere(1.2, 1.5, "")
                    + &flint),
            ),
        solid("difference", &(cube(-0.6, "") + &cylinder(0.4, -0.6, 0.6, "") + glass))
            + &solid("intersection", &(cylinder(0.4, -0.6, 0.6, "") + &cube(-0.6, "") + &water))
            + &cube(0.6, &crown),
        sphere(-0.5, 0.5, glass) + &sphere(0.5, 0.5, &flint) + &sphere(1.3, 0.3, &water),
    ]
}

/// Under an even sky clear bodies can't be seen, whatever they touch. No path is ended by chance here and
/// none is long enough to be cut off, so each carries exactly the sky's radiance, and all pixels are those of
/// the empty sky, to rounding: one lost path of a pixel's 64 would show, and so does a glass that keeps a
/// millionth of the light.
#[test]
fn bodies_that_touch_cannot_be_seen_under_an_even_sky() {
    let seen = |content: &str| {
        let long = r#"<integer name="max_depth" value="2000"/><integer name="rr_depth" value="2000"/>"#;
        let scene =
            with_integrator(&format!("{content}{SKY}"), long).unwrap_or_else(|errors| panic!("{errors}"));
        let film = expose(&scene, &settings(64, WavelengthCount::Four, 7));
        let pixels = (0..film.height).flat_map(|y| (0..film.width).map(move |x| (x, y)));
        pixels.map(|(x, y)| film.combined(x, y, LUMINANCE).mean).collect::<Vec<_>>()
    };
    let empty = seen("");
    let off = |content: &str| {
        let pixels = seen(content);
        pixels.iter().zip(&empty).map(|(pixel, sky)| (pixel / sky - 1.0).abs()).fold(0.0, f64::max)
    };
    let clear = |more: &str| {
        format!(
            r#"<bsdf type="dielectric"><float name="int_ior" value="1.6"/><float name="ext_ior" value="1"/>{more}</bsdf>"#
        )
    };
    let grey = r#"<spectrum name="specular_transmittance" value="0.999999"/>"#;
    for (i, (bodies, planted)) in touching(&clear("")).into_iter().zip(touching(&clear(grey))).enumerate() {
        let (off, planted) = (off(&bodies), off(&planted));
        println!("{i}: off by {off:e}, with planted absorption by {planted:e}");
        assert!(off < 1e-9, "{i}: {off:e}");
        assert!(planted > 1e-8, "{i}: {planted:e}");
    }
}

/// A ball of glass cut in two and put together again is the ball, by Welch's t-test per pixel.
#[test]
fn a_ball_in_two_halves_is_a_ball() {
    let room = r#"<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="3"/><translate y="-1"/></transform></shape>
        <shape type="sphere"><point name="center" x="-2" y="3" z="1"/><float name="radius" value="0.7"/>
            <emitter type="area"><spectrum name="radiance" value="5"/></emitter></shape>"#;
    let glass = r#"<bsdf type="dielectric"><float name="int_ior" value="1.5"/></bsdf>
        <medium name="interior" type="homogeneous"><spectrum name="sigma_t" value="400:0.1, 700:1.5"/><float name="albedo" value="0"/></medium>"#;
    let half = |y: f64| {
        format!(
            r#"<shape type="intersection"><shape type="sphere"/>
                <shape type="cube"><transform name="to_world"><translate y="{y}"/></transform></shape></shape>"#
        )
    };
    let tilt = r#"<transform name="to_world"><rotate x="1" y="2" angle="35"/></transform>"#;
    let halves = format!(r#"{room}<shape type="union">{glass}{tilt}{}{}</shape>"#, half(1.0), half(-1.0));
    let ball = format!(r#"{room}<shape type="sphere">{glass}{tilt}</shape>"#);
    let films = [(halves, 3), (ball, 4)]
        .map(|(text, seed)| expose(&scene(&text), &settings(1024, WavelengthCount::Four, seed)));
    let estimate = |film: &Film, m: Measured| Estimate {
        mean: m.mean,
        variance: m.error * m.error,
        degrees: f64::from(film.replicates) - 1.0,
    };
    let mut smallest = 1.0f64;
    let [a, b] = &films;
    for y in 0..a.height {
        for x in 0..a.width {
            let (p, q) = (a.combined(x, y, LUMINANCE), b.combined(x, y, LUMINANCE));
            if p.error.max(q.error) > 1e-7 * p.mean.abs() {
                smallest = smallest.min(welch(&estimate(a, p), &estimate(b, q)).p_value);
            }
        }
    }
    let ((mean_a, error_a), (mean_b, error_b)) = (luminance(a), luminance(b));
    println!("smallest p {smallest:e}, means {mean_a} {mean_b}, errors {error_a} {error_b}");
    assert!(smallest > sidak(0.01, 144), "{smallest:e}");
    assert!((mean_a - mean_b).abs() < 4.0 * error_a.hypot(error_b), "{mean_a} {mean_b}");
}

/// What is told of the insides of parts makes no difference to what is outside of a solid: mirrored, and with
/// parts that say they are turned inside out, it is the same.
#[test]
fn parts_face_out_of_their_solid() {
    for (kind, bsdf) in [("union", "diffuse"), ("difference", "diffuse"), ("intersection", "dielectric")] {
        // Dark on its back, glass that encloses all that is outside.
        let body = |scale: &str, turned: bool| {
            let turned = format!(r#"<boolean name="flip_normals" value="{turned}"/>"#);
            scene(&format!(
                r#"<shape type="{kind}"><bsdf type="{bsdf}"/>
                    <transform name="to_world"><scale x="{scale}"/></transform>
                    <shape type="cube">{turned}</shape>
                    <shape type="sphere"><float name="radius" value="1.25"/>{turned}</shape>
                </shape>{SKY}"#
            ))
        };
        let picture =
            |scene: &Scene, seed| luminance(&expose(scene, &settings(64, WavelengthCount::One, seed)));
        let (mean, error) = picture(&body("1", false), 1);
        for (i, (scale, turned)) in [("-1", false), ("1", true), ("-1", true)].into_iter().enumerate() {
            let (other, its) = picture(&body(scale, turned), 2 + i as u64);
            let difference = (mean - other).abs();
            assert!(
                difference < 4.0 * error.hypot(its),
                "{kind} {scale} {turned}: {mean} ± {error}, {other} ± {its}"
            );
        }
        assert!(error < 0.01 * mean, "{kind}: {mean} ± {error}");
    }
}

fn refused(content: &str) -> String {
    compiled(content).expect_err("it is refused")
}

#[test]
fn parts_must_be_closed() {
    for (part, says) in [
        (r#"<shape type="cylinder"/>"#, "use a `cone` with radius1 equal to radius"),
        (r#"<shape type="rectangle"/>"#, "this surface encloses nothing"),
        (r#"<shape type="disk"/>"#, "this surface encloses nothing"),
        (r#"<shape type="cone"><boolean name="capped" value="false"/></shape>"#, r#"give it capped="true""#),
    ] {
        let message = refused(&format!(r#"<shape type="difference"><shape type="cube"/>{part}</shape>"#));
        assert!(message.contains(says), "{message}");
    }
}

/// What light gets into is one body; what it doesn't get into is of any kind.
#[test]
fn a_solid_is_one_body() {
    let glass =
        |index: f64| format!(r#"<bsdf type="dielectric"><float name="int_ior" value="{index}"/></bsdf>"#);
    let pair = |a: &str, b: &str| {
        format!(
            r#"<shape type="difference"><shape type="cube">{a}</shape><shape type="sphere">{b}</shape></shape>"#
        )
    };
    let message = refused(&pair(&glass(1.5), &glass(1.6)));
    assert!(message.contains("encloses something else"), "{message}");
    scene(&pair(&glass(1.5), &glass(1.5)));
    scene(&pair(&glass(1.5), r#"<bsdf type="diffuse"/>"#));
}

/// What a union shows, and what it shows as one part of an intersection with all that is around. A share of
/// the light that is missing or too much is found.
#[track_caller]
fn assert_as_a_part(name: &str, around: &str, union: &str, samples: u32, found: f64) {
    let everything = r#"<shape type="sphere"><float name="radius" value="50"/></shape>"#;
    let part = format!(r#"{around}<shape type="intersection">{union}{everything}</shape>"#);
    let [(mean, error), (expected, error_expected)] = [format!("{around}{union}"), part]
        .map(|content| luminance(&expose(&scene(&content), &settings(samples, WavelengthCount::Four, 1))));
    let bound = 4.0 * error.hypot(error_expected);
    assert!(bound < found * expected, "{name}: {expected} ± {error_expected}");
    assert!((mean - expected).abs() < bound, "{name}: {mean} ± {error} for {expected} ± {error_expected}");
}

/// A room of two balls that reach into each other, of which the camera is in one and the lamp in the other.
#[test]
fn who_is_within_a_union_sees_no_inner_faces() {
    let ball = |center: &str| {
        format!(
            r#"<shape type="sphere"><point name="center" {center}/><float name="radius" value="1.6"/>
            <bsdf type="twosided"><bsdf type="diffuse"/></bsdf></shape>"#
        )
    };
    let union = format!(
        r#"<shape type="union">{}{}</shape>"#,
        ball(r#"x="0.9" y="1.3" z="3.6""#),
        ball(r#"x="0.3" y="0.4" z="1.4""#)
    );
    let lamp = r#"<shape type="sphere"><point name="center" x="0.3" y="1" z="1"/><float name="radius" value="0.3"/>
        <emitter type="area"><spectrum name="radiance" value="5"/></emitter></shape>"#;
    assert_as_a_part("a room", lamp, &union, 256, 0.05);
}

#[test]
fn faces_of_lamps_that_coincide_in_a_union_shine_once() {
    let half = |z: f64| {
        format!(
            r#"<shape type="cube"><transform name="to_world"><scale x="0.5" y="0.5" z="0.3"/><translate z="{z}"/></transform>
            <emitter type="area"><spectrum name="radiance" value="1"/></emitter></shape>"#
        )
    };
    let floor = r#"<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="3"/>
        <translate y="-0.6"/></transform></shape>"#;
    let union = format!(r#"<shape type="union">{}{}</shape>"#, half(-0.2), half(0.2));
    // Where both shine, the floor has 1.1 % more of the picture's light.
    assert_as_a_part("a lamp", floor, &union, 2048, 0.005);
}

#[test]
fn nothing_measures_on_a_curve() {
    let folder = crate::common::folder::Folder::new("curve-meter");
    folder.write("curve.txt", "0 0 0 0.1\n1 0 0 0.1\n");
    folder.write(
        "scene.xml",
        r#"<scene version="3.0.0"><shape type="linearcurve"><string name="filename" value="curve.txt"/>
        <sensor type="irradiancemeter"><film type="hdrfilm"><integer name="width" value="1"/><integer name="height" value="1"/>
        <rfilter type="box"/></film></sensor></shape><emitter type="constant"/></scene>"#,
    );
    let told = folder.ends(2, &["render", "scene.xml"]);
    assert!(told.contains("A sensor cannot measure on curves"), "{told}");
}
