//! Transparent bodies that overlap or lie within one another, however many: under an even sky all of them
//! look like the sky.

use crate::common::folder::Folder;
use crate::common::{expose, found, made, mean_over_pixels, settings};
use abbe::render::WavelengthCount;
use abbe::scene::{CompileOptions, Features, ReadOptions, Scene, compile, read_str};
use std::path::Path;

fn scene(content: &str) -> Scene {
    made(content, &CompileOptions::default())
}

const SIDES: [&str; 4] = ["-7, 0, 0", "7, 0, 0", "0.5, 6, 2", "-0.5, -5, -4"];

fn camera(origin: &str) -> String {
    format!(
        r#"<sensor type="perspective"><float name="fov" value="22"/>
           <float name="shutter_close" value="1"/>
           <transform name="to_world"><lookat origin="{origin}" target="0.2, 0, 0" up="0, 0.2, 1"/></transform>
           <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/>
           <string name="pixel_format" value="xyz"/><rfilter type="box"/></film></sensor>
           <integrator type="path"/>"#
    )
}

const SKY: &str = r#"<emitter type="constant"><spectrum name="radiance" value="1"/></emitter>"#;

const SAMPLES: u32 = 128;

/// Standard errors that are allowed.
const BOUND: f64 = 4.0;

/// What a film has of a radiance of 1, and its standard error.
fn radiance(content: &str, origin: &str) -> (f64, f64) {
    let measure = |content: &str| {
        let scene = scene(&format!("{}{SKY}{content}", camera(origin)));
        let film = expose(&scene, &settings(SAMPLES, WavelengthCount::Four, 1));
        mean_over_pixels(&film, |x, y| film.combined(x, y, [0.0, 1.0, 0.0]))
    };
    let (one, _) = measure("");
    let (mean, error) = measure(content);
    (mean / one, error / one)
}

/// From all sides bodies under an even sky cannot be seen. From each side light that is made or lost is found
/// with a probability of 90 % where it is 3.5 % of the sky's, from the side that shows it best where it is
/// 1 %.
#[track_caller]
fn assert_invisible(name: &str, content: &str) {
    let mut least = f64::INFINITY;
    for origin in SIDES {
        let (mean, error) = radiance(content, origin);
        println!("{name} from ({origin}): {mean:.5} ± {error:.5}");
        assert!((mean - 1.0).abs() < BOUND * error + 1e-6, "{name} from ({origin}): {mean} ± {error}");
        let sees = found(BOUND) * error;
        assert!(sees < 0.035, "{name} from ({origin}): less than {sees} is not found");
        least = least.min(sees);
    }
    assert!(least < 0.01, "{name}: less than {least} is not found");
}

fn ball(x: f64, radius: f64, more: &str) -> String {
    format!(
        r#"<shape type="sphere"><point name="center" x="{x}" y="0" z="0"/>
           <float name="radius" value="{radius}"/>{more}</shape>"#
    )
}

fn glass(index: f64) -> String {
    format!(r#"<bsdf type="dielectric"><float name="int_ior" value="{index}"/></bsdf>"#)
}

/// Glass that says what is outside of it.
fn glass_in(index: f64, outside: &str) -> String {
    format!(
        r#"<bsdf type="dielectric"><float name="int_ior" value="{index}"/>
           <string name="ext_ior" value="{outside}"/></bsdf>"#
    )
}

fn pair(one: &str, other: &str) -> String {
    ball(-0.4, 1.0, one) + &ball(0.6, 0.9, other)
}

#[test]
fn overlapping_balls_neither_make_nor_lose_light() {
    assert_invisible("crown and flint", &pair(&glass(1.33), &glass(1.8)));
    assert_invisible("twice the same", &pair(&glass(1.5), &glass(1.5)));
    let rough = r#"<bsdf type="roughdielectric"><float name="int_ior" value="1.7"/>
                   <float name="alpha" value="1e-5"/></bsdf>"#;
    assert_invisible("smooth and hardly rough", &pair(&glass(1.33), rough));
}

/// Each surface of a body that says what is outside of it is what it says, as in Mitsuba 3.
#[test]
fn what_says_its_outside_conserves_energy_beside_what_leaves_it_open() {
    for outside in ["air", "water"] {
        let (open, said) = (glass(1.8), glass_in(1.5, outside));
        assert_invisible(outside, &pair(&said, &glass_in(1.8, outside)));
        if outside == "air" {
            assert_invisible("said, open", &pair(&said, &open));
            assert_invisible("open, said", &pair(&open, &said));
        }
    }
}

/// A solid and another shape are two bodies; the parts of one solid are one.
#[test]
fn a_drink_that_reaches_into_its_glass_neither_makes_nor_loses_light() {
    let tube = |radius: f64, from: f64, to: f64| {
        format!(
            r#"<shape type="cone"><point name="p0" x="0" y="0" z="{from}"/><point name="p1" x="0" y="0" z="{to}"/>
               <float name="radius" value="{radius}"/><float name="radius1" value="{radius}"/>"#
        )
    };
    let tumbler = format!(
        r#"<shape type="difference">{}{}</shape>{}</shape></shape>"#,
        glass(1.52),
        tube(0.8, -1.0, 1.0),
        tube(0.7, -0.9, 1.1)
    );
    let drink = format!("{}{}</shape>", tube(0.701, -0.901, 0.4), glass(1.33));
    assert_invisible("drink", &(tumbler + &drink));
}

#[test]
fn instances_that_overlap_are_bodies_of_their_own() {
    let group = format!(r#"<shape type="shapegroup" id="ball">{}</shape>"#, ball(0.0, 1.0, &glass(1.7)));
    let shown = |x: f64| {
        format!(
            r#"<shape type="instance"><ref id="ball"/>
               <transform name="to_world"><translate x="{x}"/></transform></shape>"#
        )
    };
    let water = ball(0.2, 0.8, &glass(1.33));
    assert_invisible("instances", &(group.clone() + &shown(-0.5) + &shown(0.5) + &water));
    let both = format!(r#"<shape type="shapegroup" id="ball">{}</shape>"#, pair(&glass(1.33), &glass(1.8)));
    assert_invisible("two in one group", &(both + &shown(0.1)));
}

#[test]
fn bodies_that_move_into_one_another_neither_make_nor_lose_light() {
    let moving = format!(
        r#"<shape type="sphere"><animation name="to_world">
             <transform time="0"><translate x="-2.5"/></transform>
             <transform time="1"><translate x="1.5"/></transform></animation>{}</shape>"#,
        glass(1.8)
    );
    assert_invisible("moving", &(moving + &ball(0.6, 0.9, &glass(1.33))));
}

/// Each ray begins in the body that counts where it begins: n² of the sky's radiance. Finds half a percent
/// of that, with a probability of 90 %.
#[test]
fn a_camera_where_bodies_overlap_is_in_both() {
    let bodies = pair(&glass(1.5), &glass(1.5)) + &ball(0.1, 0.2, &glass(1.33));
    for (origin, index) in [("0.1, 0.01, 0", 1.33), ("0.12, 0.5, 0", 1.5), ("-0.9, 0.1, 0.1", 1.5)] {
        let (mean, error) = radiance(&bodies, origin);
        let expected = f64::powi(index / 1.000_277, 2);
        println!("from ({origin}): {mean:.5} ± {error:.5}, expected {expected:.5}");
        assert!((mean - expected).abs() < BOUND * error + 1e-6, "from ({origin}): {mean} ± {error}");
        assert!(found(BOUND) * error < 0.005 * expected, "from ({origin}): {mean} ± {error}");
    }
}

/// However many.
#[test]
fn shells_within_shells_neither_make_nor_lose_light() {
    for count in [7, 20] {
        let shells: String = (0..count)
            .map(|i| {
                ball(0.0, 1.5 - f64::from(i) / f64::from(count), &glass([1.5, 1.33, 1.7][i as usize % 3]))
            })
            .collect();
        assert_invisible(&format!("{count} shells"), &shells);
    }
}

/// Light through the middle of shells of n absorbing media crosses each of them twice.
#[test]
fn shells_within_shells_absorb_what_they_should() {
    for count in [7, 9, 12, 20] {
        let width = 1.2 / f64::from(count);
        let absorption = |i: i32| 2.0 * f64::from(1 + i % 4) / f64::from(count);
        let shell = |i: i32| {
            let medium = format!(
                r#"<bsdf type="null"/><medium type="homogeneous" name="interior">
                   <float name="sigma_t" value="{}"/><float name="albedo" value="0"/></medium>"#,
                absorption(i)
            );
            ball(0.2, 1.5 - f64::from(i) * width, &medium)
        };
        let depth = |i: i32| if i + 1 < count { 2.0 * width } else { 2.0 * (1.5 - f64::from(i) * width) };
        let shells: String = (0..count).map(shell).collect();
        let expected = (-(0..count).map(|i| absorption(i) * depth(i)).sum::<f64>()).exp();
        let meter = format!(
            r#"<sensor type="radiancemeter"><point name="origin" x="-5" y="0" z="0"/>
               <vector name="direction" x="1" y="0" z="0"/>
               <film type="hdrfilm"><integer name="width" value="1"/><integer name="height" value="1"/>
               <string name="pixel_format" value="xyz"/><rfilter type="box"/></film></sensor>
               <integrator type="volpath"/>{SKY}"#
        );
        let measure = |content: &str| {
            let film = expose(&scene(&(meter.clone() + content)), &settings(16, WavelengthCount::Four, 1));
            film.combined(0, 0, [0.0, 1.0, 0.0]).mean
        };
        let share = measure(&shells) / measure("");
        println!("{count} shells let {share} through, expected {expected}");
        assert!((share / expected - 1.0).abs() < 1e-6, "{count} shells: {share}, expected {expected}");
    }
}

/// A wall that faces what is hollow, and walls of their own around a block.
#[test]
fn glass_made_of_several_surfaces_neither_makes_nor_loses_light() {
    let inner = format!(r#"{}<boolean name="flip_normals" value="true"/>"#, glass(1.5));
    assert_invisible("hollow ball", &(ball(0.0, 1.0, &glass(1.5)) + &ball(0.0, 0.8, &inner)));
    let turns =
        ["x=\"1\" angle=\"0\"", "x=\"1\" angle=\"90\"", "x=\"1\" angle=\"180\"", "x=\"1\" angle=\"270\""];
    let sides = ["y=\"1\" angle=\"90\"", "y=\"1\" angle=\"270\""];
    let pane = |turn: &str| {
        format!(
            r#"<shape type="rectangle"><transform name="to_world"><translate z="1"/><rotate {turn}/></transform>
               {}</shape>"#,
            glass(1.5)
        )
    };
    let block: String = turns.iter().chain(&sides).map(|turn| pane(turn)).collect();
    assert_invisible("block of panes", &block);
    assert_invisible("block in water", &(block + &ball(0.3, 1.2, &glass(1.33))));
}

/// Light that is in a body for good, since what counts depends on where it came from, neither divides paths
/// without end nor is sought from the side of the light. Finds a difference of 2 %, with a probability of
/// 90 %.
#[test]
fn overlapping_balls_under_a_lamp_are_what_a_random_walk_finds() {
    let lit = |integrator: &str| {
        scene(&format!(
            r#"<integrator type="{integrator}"/><sensor type="perspective"><float name="fov" value="50"/>
               <transform name="to_world"><lookat origin="0,-6,5" target="0,0,0.3" up="0,0,1"/></transform>
               <film type="hdrfilm"><integer name="width" value="4"/><integer name="height" value="4"/>
               <string name="pixel_format" value="xyz"/><rfilter type="box"/></film></sensor>{}
               <shape type="rectangle"><transform name="to_world"><translate z="-1.2"/><scale value="5"/></transform></shape>
               <shape type="sphere"><point name="center" x="3" y="0.5" z="3"/><float name="radius" value="2"/>
               <emitter type="area"><spectrum name="radiance" value="10"/></emitter></shape>"#,
            pair(&glass(1.33), &glass(1.8))
        ))
    };
    let measure = |integrator: &str, samples: u32| {
        let film = expose(&lit(integrator), &settings(samples, WavelengthCount::Four, 1));
        mean_over_pixels(&film, |x, y| film.combined(x, y, [0.0, 1.0, 0.0]))
    };
    let ((path, path_error), (walk, walk_error)) = (measure("path", 2048), measure("walk", 16384));
    println!("path {path} ± {path_error}, walk {walk} ± {walk_error}");
    let error = path_error.hypot(walk_error);
    assert!((path - walk).abs() < BOUND * error, "{path} {walk}");
    assert!(found(BOUND) * error < 0.02 * walk, "{error} of {walk}");
    assert!(!lit("path").features().caustics);
}

/// Closed glass whose normals point inward is told of, with what mends it; what is open or a cavity is not.
#[test]
fn closed_glass_that_faces_inward_is_told_of() {
    let folder = Folder::new("bodies");
    let vertices = "v 1 1 1\nv 1 -1 -1\nv -1 1 -1\nv -1 -1 1\n";
    let faces = [[1, 2, 3], [1, 4, 2], [1, 3, 4], [2, 4, 3]];
    let written = |name: &str, faces: &[[u32; 3]]| {
        let faces: String = faces.iter().map(|[a, b, c]| format!("f {a} {b} {c}\n")).collect();
        folder.write(&format!("{name}.obj"), format!("{vertices}{faces}"));
        let faces = faces.replace("f ", "3 ");
        let faces: String = faces
            .lines()
            .map(|line| {
                let indices: Vec<u32> =
                    line.split(' ').skip(1).map(|i| i.parse::<u32>().unwrap() - 1).collect();
                format!("3 {} {} {}\n", indices[0], indices[1], indices[2])
            })
            .collect();
        let count = faces.lines().count();
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
             element face {count}\nproperty list uchar int vertex_indices\nend_header\n{}{faces}",
            vertices.replace("v ", "")
        );
        folder.write(&format!("{name}.ply"), text);
    };
    written("outward", &faces);
    written("inward", &faces.map(|[a, b, c]| [a, c, b]));
    written("open", &faces.map(|[a, b, c]| [a, c, b])[..3]);
    let told = |content: &str| {
        let text = format!(r#"<scene version="3.0.0"><sensor type="perspective"/>{content}</scene>"#);
        let description = read_str(text, &folder.path("scene.xml"), &ReadOptions::default());
        let description = description.unwrap_or_else(|errors| panic!("{errors}"));
        let notes = description.assumptions.iter().filter(|note| note.text.contains("faces inward"));
        notes.map(|note| note.text.clone()).collect::<Vec<_>>()
    };
    let mesh = |name: &str, format: &str, more: &str| {
        let file = format!(r#"<string name="filename" value="{name}.{format}"/>"#);
        format!(r#"<shape type="{format}">{file}{more}</shape>"#)
    };
    let flip = r#"<boolean name="flip_normals" value="true"/>"#;
    let mirror = r#"<transform name="to_world"><scale x="-1"/></transform>"#;
    for format in ["obj", "ply"] {
        for material in [
            glass(1.5),
            glass_in(1.5, "air"),
            r#"<bsdf type="principled"><float name="spec_trans" value="1"/></bsdf>"#.to_owned(),
        ] {
            let told = |name: &str, more: &str| told(&mesh(name, format, &(material.clone() + more)));
            assert_eq!([told("outward", "").len(), told("open", "").len()], [0; 2], "{format} {material}");
            let found = told("inward", "");
            assert!(found.len() == 1 && found[0].contains("give it flip_normals"), "{format}: {found:?}");
            assert_eq!([told("inward", flip).len(), told("inward", mirror).len()], [0; 2], "{format}");
            let found = told("outward", flip);
            assert!(found.len() == 1 && found[0].contains("leave flip_normals out"), "{format}: {found:?}");
            assert_eq!(told("outward", mirror).len(), 1, "{format}");
        }
        assert_eq!(told(&mesh("inward", format, "")).len(), 0, "nothing gets into what is diffuse");
        assert_eq!(told(&mesh("inward", format, r#"<bsdf type="thindielectric"/>"#)).len(), 0);
    }
    let flipped = glass(1.5) + flip;
    assert_eq!(told(&ball(0.0, 1.0, &flipped)).len(), 1);
    assert_eq!(told(&(ball(0.0, 1.0, &glass(1.5)) + &ball(0.0, 0.8, &flipped))).len(), 0, "a cavity");
    assert_eq!(told(&(ball(0.0, 1.0, &glass(1.33)) + &ball(0.0, 0.8, &flipped))).len(), 1);
    let group = format!(r#"<shape type="shapegroup" id="g">{}</shape>"#, ball(0.0, 1.0, &flipped));
    assert_eq!(told(&(group + r#"<shape type="instance"><ref id="g"/></shape>"#)).len(), 1);
}

/// What surely lies apart is rendered as if nothing could overlap.
#[test]
fn bodies_that_lie_apart_need_no_precedence() {
    let features =
        |content: &str| -> Features { scene(&format!("{}{SKY}{content}", camera(SIDES[0]))).features() };
    let is_plain = |features: Features| !features.precedence && !features.contact && !features.medium_stack;
    assert!(is_plain(features(&ball(0.0, 1.0, &glass(1.5)))));
    assert!(is_plain(features(&(ball(0.0, 1.0, &glass(1.5)) + &ball(2.5, 1.0, &glass(1.5))))));
    assert!(features(&pair(&glass(1.5), &glass(1.5))).precedence);
}

/// A pane hides a lamp without extent from `path`, as in Mitsuba, and lights of some extent from neither.
#[test]
fn a_pane_hides_points_from_path_alone() {
    let floor =
        r#"<shape type="rectangle"><transform name="to_world"><scale value="9"/></transform></shape>"#;
    let pane = r#"<shape type="rectangle"><bsdf type="thindielectric"/><transform name="to_world"><scale value="99"/>
        <translate z="2"/></transform></shape>"#;
    let point = r#"<emitter type="point"><point name="position" x="0" y="0" z="4"/></emitter>"#;
    let lamp = r#"<shape type="sphere"><point name="center" x="0" y="0" z="4"/>
        <emitter type="area"><float name="radiance" value="1"/></emitter></shape>"#;
    let luminance = |integrator: &str, light: &str, samples: u32, seed: u64| {
        let camera = camera("2, 1, 1").replace("\"path\"", &format!("\"{integrator}\""));
        let film = expose(
            &scene(&format!("{camera}{floor}{pane}{light}")),
            &settings(samples, WavelengthCount::Four, seed),
        );
        mean_over_pixels(&film, |x, y| film.combined(x, y, [0.0, 1.0, 0.0]))
    };
    assert_eq!(luminance("path", point, SAMPLES, 1).0, 0.0);
    assert!(luminance("volpath", point, SAMPLES, 1).0 > 0.0);
    let (path, path_error) = luminance("path", lamp, 16 * SAMPLES, 1);
    let (volpath, volpath_error) = luminance("volpath", lamp, 4 * SAMPLES, 2);
    let error = path_error.hypot(volpath_error);
    let sees = found(BOUND) * error / volpath;
    assert!(sees < 0.02, "less than {sees} is not found");
    assert!((path - volpath).abs() < BOUND * error, "{path} {volpath} ± {error}");
}

/// Files for Mitsuba 3 have it so: an opaque wall in fog states the fog on both of its sides. By which way
/// rays get into the fog is said elsewhere. Where it is not, the file is wrong.
#[test]
fn opaque_shapes_may_state_a_medium_that_rays_get_into_elsewhere() {
    let fog = r#"<medium type="homogeneous" id="fog"/>"#;
    let wall = r#"<shape type="rectangle"><ref name="interior" id="fog"/><ref name="exterior" id="fog"/>
                  <bsdf type="diffuse"/></shape>"#;
    let film =
        r#"<film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/></film>"#;
    let told = |sensor: &str, more: &str| {
        let content = format!(
            r#"<scene version="3.0.0">{fog}<integrator type="volpath"/><sensor type="perspective">{sensor}{film}
               </sensor>{wall}{more}</scene>"#
        );
        let description =
            read_str(content, Path::new("scene.xml"), &ReadOptions::default()).expect("it is read");
        compile(&description, &CompileOptions::default()).map(|_| ()).map_err(|errors| errors.to_string())
    };
    assert_eq!(told(r#"<ref id="fog"/>"#, ""), Ok(()));
    let cloud = r#"<shape type="sphere"><bsdf type="null"/><ref name="interior" id="fog"/></shape>"#;
    assert_eq!(told("", cloud), Ok(()));
    let error = told("", "").unwrap_err();
    assert!(error.contains("no ray ever gets into this medium") && error.contains("`null`"), "{error}");
}

/// Two open sides of a slab, each with the fog in it, wherever the file states that.
#[test]
fn media_that_are_alike_are_one() {
    let fog = |name: &str| {
        format!(
            r#"<medium type="homogeneous" {name}><spectrum name="sigma_t" value="0.8"/>
            <spectrum name="albedo" value="0.5"/><phase type="hg"><float name="g" value="0.3"/></phase></medium>"#
        )
    };
    let slab = |inside: &str| {
        let side = |angle: f64, x: f64| {
            format!(
                r#"<shape type="rectangle"><transform name="to_world"><scale value="3"/>
                <rotate y="1" angle="{angle}"/><translate x="{x}"/></transform><bsdf type="null"/>{inside}</shape>"#
            )
        };
        side(90.0, 1.0) + &side(-90.0, -1.0)
    };
    let one = format!("{}{}", fog(r#"id="fog""#), slab(r#"<ref name="interior" id="fog"/>"#));
    let two = slab(&fog(r#"name="interior""#));
    let [one, two] = [one, two].map(|content| radiance(&content, SIDES[0]));
    assert!(one.0 < 0.9, "{one:?}");
    assert_eq!(one, two);
}
