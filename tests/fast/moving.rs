//! Shapes that keyframes move: where the keyframes agree, or at any one moment, they look as they do where a
//! transform puts them.

use crate::common::folder::Folder;
use crate::common::{compiled, expose, settings};
use abbe::render::WavelengthCount;
use abbe::scene::{CompileOptions, ReadOptions, read_str};

/// Bent, and of radii that differ.
const CURVE: &str = "-0.9 -0.3 0 0.1\n-0.4 0.4 0.5 0.2\n0.1 -0.4 0.1 0.15\n0.5 0.5 -0.2 0.1\n0.9 0 0.3 0.1\n";

/// An octahedron without vertex normals.
const OCTAHEDRON: &str = "v 1 0 0\nv -1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nv 0 0 -1\n\
    f 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n";

const DIFFUSE: &str = r#"<bsdf type="diffuse"/>"#;
const METAL: &str = r#"<bsdf type="roughconductor"><float name="alpha" value="0.2"/></bsdf>"#;
const LIT: &str =
    r#"<bsdf type="diffuse"/><emitter type="area"><spectrum name="radiance" value="0.7"/></emitter>"#;
const ONLY_SEEN: &str = r#"<integrator type="path"><integer name="max_depth" value="1"/></integrator>"#;
const CHECKED: &str = r#"<bsdf type="diffuse"><texture type="checkerboard" name="reflectance"><transform name="to_uv">
    <scale x="4" y="6"/></transform></texture></bsdf>"#;
const MIRRORED: &str = r#"<scale x="-0.8" y="0.8" z="0.8"/><rotate x="0.6" z="0.8" angle="50"/>"#;
const STRETCHED: &str = r#"<scale x="1.2" y="0.4" z="0.7"/><rotate x="0.6" z="0.8" angle="50"/>"#;
const ENLARGED: &str = r#"<scale value="1.5"/>"#;

fn pixels(content: &str, shutter: [f64; 2]) -> Vec<f64> {
    let folder = Folder::new("moving");
    folder.write("curve.txt", CURVE);
    folder.write("octahedron.obj", OCTAHEDRON);
    let text = format!(
        r#"<scene version="3.0.0"><sensor type="perspective"><float name="fov" value="40"/>
        <float name="shutter_open" value="{}"/><float name="shutter_close" value="{}"/>
        <transform name="to_world"><lookat origin="0, -6, 2" target="0, 0, 0" up="0, 0, 1"/></transform>
        <film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="18"/>
        <rfilter type="box"/></film></sensor>
        <shape type="rectangle"><transform name="to_world"><scale value="6"/><translate z="-2"/></transform>{DIFFUSE}</shape>
        <emitter type="constant"><spectrum name="radiance" value="0.3"/></emitter>
        <emitter type="directional"><vector name="direction" x="1" y="1" z="-2"/></emitter>{content}</scene>"#,
        shutter[0], shutter[1]
    );
    let described = read_str(text, &folder.path("scene.xml"), &ReadOptions::default())
        .unwrap_or_else(|errors| panic!("{errors}"));
    let film =
        expose(&compiled(&described, &CompileOptions::default()), &settings(32, WavelengthCount::Four, 5));
    let [width, height] = film.extent.shown.size;
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    places.map(|(x, y)| film.combined(x, y, [0.0, 1.0, 0.0]).mean).collect()
}

/// The same sample values meet the same surfaces, so that pictures differ by rounding alone; a few samples
/// may fall to the other side of an edge.
#[track_caller]
fn assert_same(name: &str, a: &[f64], b: &[f64]) {
    let mean = b.iter().sum::<f64>() / b.len() as f64;
    assert!(mean > 0.0);
    // Meshes are rounded to single precision, elsewhere where they move.
    let differ = (0..b.len()).filter(|&i| (a[i] - b[i]).abs() > 1e-5 * (mean + b[i])).count();
    assert!(differ * 50 <= b.len(), "{name}: {differ} of {} pixels differ", b.len());
}

#[track_caller]
fn assert_other(name: &str, a: &[f64], b: &[f64]) {
    let mean = b.iter().sum::<f64>() / b.len() as f64;
    let differ = (0..b.len()).filter(|&i| (a[i] - b[i]).abs() > 1e-3 * mean).count();
    assert!(differ * 50 > b.len(), "{name}: only {differ} of {} pixels differ", b.len());
}

fn still(operations: &str) -> String {
    format!(r#"<transform name="to_world">{operations}</transform>"#)
}

/// From time 0 to time 1.
fn animated(from: &str, to: &str) -> String {
    format!(
        r#"<animation name="to_world"><transform time="0">{from}</transform><transform time="1">{to}</transform></animation>"#
    )
}

fn by(x: f64) -> String {
    format!(r#"<translate x="{x}"/>"#)
}

fn shape(plugin: &str, more: &str, place: &str) -> String {
    let file = match plugin {
        "obj" => "octahedron.obj",
        "linearcurve" | "bsplinecurve" | "sweptsphere" => "curve.txt",
        _ => return format!(r#"<shape type="{plugin}">{place}{more}</shape>"#),
    };
    format!(r#"<shape type="{plugin}"><string name="filename" value="{file}"/>{place}{more}</shape>"#)
}

/// A shape that moves as its transform says, in three ways: by keyframes that agree, at one moment of a way
/// from `from` to `to`, and as it moves along while the shutter is open, beside an instance that does.
#[track_caller]
fn check(name: &str, shape: &dyn Fn(&str) -> String, here: &str, [from, to]: [&str; 2]) {
    let at_rest = pixels(&shape(&still(here)), [0.5; 2]);
    let agreeing = pixels(&shape(&animated(here, here)), [0.5; 2]);
    assert_same(&format!("{name}, keyframes"), &agreeing, &at_rest);
    let moment = pixels(&shape(&animated(from, to)), [0.5; 2]);
    assert_same(&format!("{name}, a moment"), &moment, &at_rest);
    let moving = shape(&animated(&format!("{here}{}", by(-0.4)), &format!("{here}{}", by(0.4))));
    let carried = format!(
        r#"<shape type="shapegroup" id="it">{}</shape><shape type="instance"><ref id="it"/>{}</shape>"#,
        shape(&still(here)),
        animated(&by(-0.4), &by(0.4))
    );
    let moving = pixels(&moving, [0.0, 1.0]);
    assert_same(&format!("{name}, in motion"), &moving, &pixels(&carried, [0.0, 1.0]));
    assert_other(&format!("{name}, in motion"), &moving, &at_rest);
}

fn turned(operations: &str, angle: f64) -> String {
    format!(r#"{operations}<rotate z="1" angle="{angle}"/>"#)
}

/// What is turned to both sides of what stands here.
fn around(here: &str) -> [String; 2] {
    [-30.0, 30.0].map(|angle| turned(here, angle))
}

#[test]
fn curves_keep_their_radii() {
    for plugin in ["linearcurve", "bsplinecurve"] {
        let curve = |place: &str| shape(plugin, CHECKED, place);
        for here in [ENLARGED, STRETCHED, MIRRORED, r#"<rotate x="1" angle="90"/>"#] {
            check(plugin, &curve, here, around(here).each_ref().map(String::as_str));
        }
        let grows = [r#"<scale value="0.5"/>"#, r#"<scale value="2.5"/>"#];
        check(plugin, &curve, ENLARGED, grows);
        // So a curve that is stretched is no stretched curve.
        let stretched = format!(
            r#"<shape type="shapegroup" id="it">{}</shape><shape type="instance"><ref id="it"/>{}</shape>"#,
            curve(""),
            still(ENLARGED)
        );
        assert_other(
            plugin,
            &pixels(&stretched, [0.0; 2]),
            &pixels(&curve(&animated(ENLARGED, ENLARGED)), [0.0; 2]),
        );
    }
}

#[test]
fn mirrors_turn_the_same_shapes_inside_out() {
    let flat = format!(r#"<boolean name="face_normals" value="true"/>{DIFFUSE}"#);
    let ball = format!(r#"<point name="center" x="0.1" y="0.2" z="-0.1"/>{DIFFUSE}"#);
    let shrinks = [0.6, 1.0]
        .map(|s| format!(r#"<scale x="-{s}" y="{s}" z="{s}"/><rotate x="0.6" z="0.8" angle="50"/>"#));
    for (plugin, more) in [("sphere", &*ball), ("obj", DIFFUSE), ("obj", &flat)] {
        let made = |place: &str| shape(plugin, more, place);
        check(plugin, &made, MIRRORED, around(MIRRORED).each_ref().map(String::as_str));
        check(plugin, &made, MIRRORED, shrinks.each_ref().map(String::as_str));
    }
}

#[test]
fn computed_normals_weigh_triangles_as_they_are_stretched() {
    let mesh = |place: &str| shape("obj", METAL, place);
    check("stretched", &mesh, STRETCHED, around(STRETCHED).each_ref().map(String::as_str));
    let grows = [0.2, 0.6]
        .map(|y| format!(r#"<scale x="1.2" y="{y}" z="0.7"/><rotate x="0.6" z="0.8" angle="50"/>"#));
    check("growing", &mesh, STRETCHED, grows.each_ref().map(String::as_str));
}

/// The others keep their outside, and are stretched as a whole.
#[test]
fn all_shapes_move_as_they_stand() {
    let smooth = format!(r#"<string name="interpolation" value="bspline"/>{METAL}"#);
    for (plugin, more) in [
        ("disk", DIFFUSE),
        ("cylinder", DIFFUSE),
        ("cube", DIFFUSE),
        ("rectangle", DIFFUSE),
        ("torus", METAL),
        ("cone", DIFFUSE),
        ("sweptsphere", METAL),
        ("sweptsphere", &smooth),
    ] {
        let made = |place: &str| shape(plugin, more, place);
        for here in [MIRRORED, STRETCHED] {
            check(plugin, &made, here, around(here).each_ref().map(String::as_str));
        }
    }
}

/// What moves in a group, and solids that move or whose parts do.
#[test]
fn so_do_shapes_in_groups_and_in_solids() {
    let grouped = |content: &str| {
        format!(
            r#"<shape type="shapegroup" id="group">{content}</shape><shape type="instance"><ref id="group"/>
               <transform name="to_world"><scale value="0.9"/><rotate y="1" angle="20"/></transform></shape>"#
        )
    };
    let marble = r#"<bsdf type="diffuse"><texture type="marble" name="reflectance"/></bsdf>"#;
    let places = [
        ("sphere", DIFFUSE, MIRRORED),
        ("sphere", LIT, MIRRORED),
        ("sphere", marble, MIRRORED),
        ("obj", LIT, MIRRORED),
        ("obj", METAL, STRETCHED),
        ("linearcurve", DIFFUSE, ENLARGED),
        ("bsplinecurve", marble, STRETCHED),
    ];
    for (plugin, more, here) in places {
        let name = format!("{plugin} in a group");
        let [from, to] = around(here);
        // Light samples of a lamp that moves go elsewhere.
        let depth = if more == LIT { ONLY_SEEN } else { "" };
        let at = |place: &str, time: f64| {
            pixels(&format!("{depth}{}", grouped(&shape(plugin, more, place))), [time; 2])
        };
        assert_same(&name, &at(&animated(here, here), 0.3), &at(&still(here), 0.3));
        // A texture lies where the shape was at first.
        if more != marble {
            assert_same(&name, &at(&animated(&from, &to), 0.5), &at(&still(here), 0.5));
        }
    }
    let parts = [("sphere", "sphere", MIRRORED), ("obj", "obj", MIRRORED), ("obj", "sphere", STRETCHED)];
    for (first, second, here) in parts {
        for solid in ["union", "intersection", "difference"] {
            let name = format!("{solid} of {first} and {second}");
            let second = |place: &str| shape(second, "", place);
            let whole = |place: &str| {
                let parts = shape(first, "", "") + &second(&still(&by(0.5)));
                format!(r#"<shape type="{solid}">{place}{DIFFUSE}{parts}</shape>"#)
            };
            let part = |place: &str| {
                let parts = shape(first, "", &still(&by(0.5))) + &second(place);
                format!(r#"<shape type="{solid}">{DIFFUSE}{parts}</shape>"#)
            };
            let [from, to] = around(here);
            for made in [&whole as &dyn Fn(&str) -> String, &part] {
                let at = |place: &str, time: f64| pixels(&made(place), [time; 2]);
                let at_rest = at(&still(here), 0.5);
                assert_same(&name, &at(&animated(here, here), 0.5), &at_rest);
                assert_same(&name, &at(&animated(&from, &to), 0.5), &at_rest);
            }
        }
    }
}

/// A lamp that stands in its group, whose instance a group shows that moves.
#[test]
fn lamps_within_instances_are_not_placed_by_these() {
    for (plugin, here) in [("sphere", MIRRORED), ("obj", MIRRORED), ("obj", STRETCHED)] {
        let made = |place: &str| {
            format!(
                r#"{ONLY_SEEN}<shape type="shapegroup" id="lamp">{}</shape>
                   <shape type="shapegroup" id="group"><shape type="instance"><ref id="lamp"/>{}</shape></shape>
                   <shape type="instance"><ref id="group"/>{place}</shape>"#,
                shape(plugin, LIT, &still(r#"<scale x="0.9" y="0.5" z="0.7"/>"#)),
                still(here),
            )
        };
        let place = r#"<rotate y="1" angle="20"/>"#;
        let moving = pixels(&made(&animated(place, place)), [0.5; 2]);
        assert_same(plugin, &moving, &pixels(&made(&still(place)), [0.5; 2]));
    }
}
