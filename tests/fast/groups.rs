//! Groups that show groups, and lights, motion and media in them: the picture is that of the same shapes put
//! directly into the scene.

use crate::common::folder::Folder;
use crate::common::{expose, made, settings};
use abbe::render::WavelengthCount;
use abbe::scene::{CompileOptions, ReadOptions, Scene, read_str};
use std::path::Path;

fn scene(content: &str) -> Scene {
    let head = r#"<sensor type="perspective"><float name="fov" value="40"/><float name="shutter_close" value="1"/>
        <transform name="to_world"><lookat origin="0, -9, 3" target="0, 0, 0.5" up="0, 0, 1"/></transform>
        <film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="18"/></film></sensor>
        <shape type="rectangle"><transform name="to_world"><scale value="6"/><translate z="-1"/></transform>
            <bsdf type="diffuse"/></shape>"#;
    made(&format!("{head}{content}"), &CompileOptions::default())
}

/// Operations, of which the first comes first.
fn placed(operations: &str) -> String {
    format!(r#"<transform name="to_world">{operations}</transform>"#)
}

fn by(x: f64, y: f64, z: f64) -> String {
    format!(r#"<translate x="{x}" y="{y}" z="{z}"/>"#)
}

fn moved(x: f64, y: f64, z: f64) -> String {
    placed(&by(x, y, z))
}

/// Turned and made smaller before it is moved: where transforms are put together in the wrong order, that
/// shows.
fn turned(x: f64, y: f64, z: f64) -> String {
    format!(r#"<scale value="0.8"/><rotate x="0.6" z="0.8" angle="50"/>{}"#, by(x, y, z))
}

/// The same of what shines: a ball that is turned has its light samples elsewhere.
fn smaller(x: f64, y: f64, z: f64) -> String {
    format!(r#"<scale value="0.8"/>{}"#, by(x, y, z))
}

fn instance(group: &str, place: &str) -> String {
    format!(r#"<shape type="instance"><ref id="{group}"/>{place}</shape>"#)
}

fn group(id: &str, content: &str) -> String {
    format!(r#"<shape type="shapegroup" id="{id}">{content}</shape>"#)
}

fn pixels(scene: &Scene) -> Vec<f64> {
    let film = expose(scene, &settings(32, WavelengthCount::Four, 5));
    let [width, height] = film.extent.shown.size;
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    places.map(|(x, y)| film.combined(x, y, [0.0, 1.0, 0.0]).mean).collect()
}

/// The same sample values meet the same surfaces, so that pictures differ by rounding alone; a few samples
/// may fall to the other side of an edge.
#[track_caller]
fn assert_same(nested: &str, flat: &str) {
    let [a, b] = [nested, flat].map(|content| pixels(&scene(content)));
    let mean = b.iter().sum::<f64>() / b.len() as f64;
    assert!(mean > 0.0);
    let differ: Vec<usize> = (0..b.len()).filter(|&i| (a[i] - b[i]).abs() > 1e-7 * (mean + b[i])).collect();
    assert!(differ.len() * 50 <= b.len(), "{} of {} pixels differ", differ.len(), b.len());
}

const SKY: &str = r#"<emitter type="constant"/>"#;

#[test]
fn groups_in_groups_look_like_their_shapes() {
    let ball = |place: &str| {
        format!(
            r#"<shape type="sphere"><float name="radius" value="0.25"/>{place}<bsdf type="plastic"/></shape>"#
        )
    };
    let two = |a: &str, b: &str| {
        format!("{}{}", instance(a, &moved(-0.5, 0.0, 0.0)), instance(b, &placed(&turned(0.5, 0.0, 0.25))))
    };
    let nested = format!(
        "{SKY}{}{}{}{}",
        group("one", &ball(&moved(0.125, 0.0, 0.0))),
        group("two", &format!("{}{}", two("one", "one"), ball(&moved(0.0, 0.0, 0.75)))),
        group(
            "four",
            &format!(
                "{}{}",
                instance("two", &placed(&turned(-1.0, 0.0, 0.0))),
                instance("two", &moved(1.0, 0.0, 0.0))
            )
        ),
        instance("four", &placed(&turned(0.0, 1.0, 0.0))),
    );
    let mut flat = SKY.to_owned();
    for pair in [turned(-1.0, 0.0, 0.0), by(1.0, 0.0, 0.0)] {
        let own = by(0.125, 0.0, 0.0);
        for place in [own.clone() + &by(-0.5, 0.0, 0.0), own + &turned(0.5, 0.0, 0.25), by(0.0, 0.0, 0.75)] {
            flat += &ball(&placed(&format!("{place}{pair}{}", turned(0.0, 1.0, 0.0))));
        }
    }
    assert_same(&nested, &flat);
}

#[test]
fn each_place_where_a_light_is_shown_is_a_light() {
    let lamp = |place: &str, power: f64| {
        format!(
            r#"<shape type="sphere"><float name="radius" value="0.25"/>{place}
               <emitter type="area"><spectrum name="radiance" value="{power}"/></emitter></shape>"#
        )
    };
    let shade = |place: &str| {
        format!(r#"<shape type="disk">{place}<bsdf type="twosided"><bsdf type="diffuse"/></bsdf></shape>"#)
    };
    let compare = |pair: &dyn Fn(f64, f64, f64) -> String, shade: &dyn Fn(&str) -> String| {
        let nested = format!(
            "{}{}{}{}",
            group("lamp", &(lamp("", 3.0) + &shade(&moved(0.0, 0.0, 0.5)))),
            group(
                "pair",
                &format!(
                    "{}{}",
                    instance("lamp", &placed(&pair(-1.5, 0.0, 0.0))),
                    instance("lamp", &moved(1.5, 0.0, 0.25))
                )
            ),
            instance("pair", &placed(&pair(0.0, 1.0, 0.0))),
            instance("lamp", &moved(0.0, -1.0, 0.0)),
        );
        let outer = pair(0.0, 1.0, 0.0);
        let places = [pair(-1.5, 0.0, 0.0) + &outer, by(1.5, 0.0, 0.25) + &outer, by(0.0, -1.0, 0.0)];
        let lamps: String = places.each_ref().map(|place| lamp(&placed(place), 3.0)).concat();
        let shades: String = places.map(|place| shade(&placed(&(by(0.0, 0.0, 0.5) + &place)))).concat();
        assert_same(&nested, &(lamps + &shades));
    };
    compare(&by, &shade);
    compare(&smaller, &|_| String::new());
}

#[test]
fn things_move_in_groups_and_groups_with_them() {
    let keys = |from: f64, to: f64| {
        format!(
            r#"<animation name="to_world"><transform time="0"><translate x="{from}"/></transform>
               <transform time="1"><translate x="{to}"/></transform></animation>"#
        )
    };
    let ball = |place: &str, more: &str| {
        format!(r#"<shape type="sphere"><float name="radius" value="0.5"/>{place}{more}</shape>"#)
    };
    let diffuse = r#"<bsdf type="diffuse"/>"#;
    let moving = |before: &str, after: &str, shine: &str| {
        let key = |time: u32, x: f64| {
            format!(r#"<transform time="{time}">{before}<translate x="{x}"/>{after}</transform>"#)
        };
        ball(&format!(r#"<animation name="to_world">{}{}</animation>"#, key(0, -1.0), key(1, 1.0)), shine)
    };
    let nested = format!(
        "{SKY}{}{}{}",
        group("ball", &ball(&keys(-1.0, 1.0), diffuse)),
        group("more", &instance("ball", &placed(&turned(0.0, 0.0, 1.0)))),
        instance("more", &moved(0.0, 1.0, 0.0)),
    );
    let flat = moving("", &(turned(0.0, 0.0, 1.0) + &by(0.0, 1.0, 0.0)), diffuse);
    assert_same(&nested, &format!("{SKY}{flat}"));
    // Two motions that add up, where neither is a light.
    let nested = format!(
        "{SKY}{}{}{}",
        group("ball", &ball(&keys(-1.0, 0.0), diffuse)),
        group("more", &instance("ball", &keys(0.0, 1.0))),
        instance("more", &moved(0.0, 1.0, 1.0)),
    );
    let straight = |shine: &str| moving("", &by(0.0, 1.0, 1.0), shine);
    assert_same(&nested, &format!("{SKY}{}", straight(diffuse)));
    // A lamp that moves in its group, and one that its instance moves.
    let shine = r#"<emitter type="area"><spectrum name="radiance" value="2"/></emitter>"#;
    let own = format!(
        "{}{}{}",
        group("lamp", &ball(&keys(-1.0, 1.0), shine)),
        group("more", &instance("lamp", &placed(&smaller(0.0, 0.0, 1.0)))),
        instance("more", &moved(0.0, 1.0, 0.0)),
    );
    assert_same(&own, &moving("", &(smaller(0.0, 0.0, 1.0) + &by(0.0, 1.0, 0.0)), shine));
    let carried = format!(
        "{}{}{}",
        group("lamp", &ball(&placed(&by(0.5, 0.0, 0.0)), shine)),
        group("more", &instance("lamp", &keys(-1.0, 1.0))),
        instance("more", &placed(&smaller(0.0, 1.0, 1.0))),
    );
    assert_same(&carried, &moving(&by(0.5, 0.0, 0.0), &smaller(0.0, 1.0, 1.0), shine));
    let within = format!(
        "{}{}{}",
        group("lamp", &ball(&placed(&by(0.5, 0.0, 0.0)), shine)),
        group("more", &instance("lamp", &placed(&smaller(0.0, 0.0, 1.0)))),
        instance("more", &keys(-1.0, 1.0)),
    );
    assert_same(&within, &moving(&(by(0.5, 0.0, 0.0) + &smaller(0.0, 0.0, 1.0)), "", shine));
}

#[test]
fn media_fill_bodies_in_groups_of_groups() {
    let medium = |name: &str| {
        format!(
            r#"<medium type="homogeneous" name="{name}"><spectrum name="sigma_t" value="400:0.5, 700:2"/>
               <spectrum name="albedo" value="0.6"/></medium>"#
        )
    };
    let fog = |place: &str| {
        format!(
            r#"<shape type="sphere">{place}<float name="radius" value="0.75"/><bsdf type="null"/>{}</shape>"#,
            medium("interior")
        )
    };
    let glass = |place: &str| {
        format!(
            r#"<shape type="sphere">{place}<float name="radius" value="0.5"/><bsdf type="dielectric"/></shape>"#
        )
    };
    for integrator in ["volpath", "path"] {
        let head = format!(
            r#"{SKY}<integrator type="{integrator}"><integer name="max_depth" value="12"/></integrator>"#
        );
        // Two bodies within one another, several times.
        let nested = format!(
            "{head}{}{}{}{}",
            group("fog", &fog("")),
            group("both", &format!("{}{}", instance("fog", ""), glass(""))),
            group(
                "pair",
                &format!(
                    "{}{}",
                    instance("both", &placed(&turned(-1.0, 0.0, 0.0))),
                    instance("both", &moved(1.0, 0.0, 0.5))
                )
            ),
            instance("pair", &placed(&turned(0.0, 1.0, 0.0))),
        );
        let mut flat = head.clone();
        for place in [turned(-1.0, 0.0, 0.0), by(1.0, 0.0, 0.5)] {
            let place = placed(&(place + &turned(0.0, 1.0, 0.0)));
            flat += &glass(&place);
            flat += &fog(&place);
        }
        assert_same(&nested, &flat);
        // Two of one body that overlap: which of them a ray is in is known by the instance.
        let row = format!(
            "{head}{}{}{}",
            group("fog", &fog("")),
            group(
                "row",
                &format!(
                    "{}{}",
                    instance("fog", &moved(-0.4, 0.0, 0.0)),
                    instance("fog", &moved(0.4, 0.0, 0.0))
                )
            ),
            instance("row", &moved(0.0, 1.0, 1.5)),
        );
        assert_same(&row, &format!("{head}{}{}", fog(&moved(-0.4, 1.0, 1.5)), fog(&moved(0.4, 1.0, 1.5))));
    }
}

/// A pattern lies in the coordinates of the group that its shape stands in, however many groups are around.
#[test]
fn patterns_stay_with_their_group() {
    let ball = r#"<shape type="sphere"><bsdf type="diffuse"><texture type="checkerboard" name="reflectance">
        <transform name="to_uv"><scale value="4"/></transform></texture></bsdf></shape>
        <shape type="sphere"><point name="center" x="2.5" y="0" z="0"/><bsdf type="diffuse">
        <texture type="noise" name="reflectance"/></bsdf></shape>"#;
    let inner = turned(-0.5, 0.0, 0.25);
    let nested = format!(
        "{SKY}{}{}{}",
        group("ball", ball),
        group("more", &instance("ball", &placed(&inner))),
        instance("more", &placed(&turned(0.0, 1.0, 0.0))),
    );
    let place = placed(&(inner + &turned(0.0, 1.0, 0.0)));
    assert_same(&nested, &format!("{SKY}{}{}", group("ball", ball), instance("ball", &place)));
}

/// What is wrong with a scene, all lines in one.
#[track_caller]
fn refused(content: &str, expected: &[&str]) {
    let whole = format!(
        r#"<scene version="3.0.0"><sensor type="perspective"><float name="shutter_close" value="1"/>
           </sensor>{SKY}{content}</scene>"#
    );
    let told = match read_str(whole, Path::new("scene.xml"), &ReadOptions::default()) {
        Err(errors) => errors.to_string(),
        Ok(description) => match abbe::scene::compile(&description, &CompileOptions::default()) {
            Err(errors) => errors.to_string(),
            Ok(_) => panic!("accepted: {content}"),
        },
    };
    for part in expected {
        assert!(told.contains(part), "{part:?} is not in\n{told}");
    }
}

#[test]
fn what_cannot_be_shown_is_refused_with_a_remedy() {
    let ball = r#"<shape type="sphere"/>"#;
    let itself = format!("{}{}", group("a", &instance("b", "")), group("b", &instance("a", "")));
    refused(
        &format!("{itself}{}", instance("a", "")),
        &["contains itself", "refer to an object defined outside"],
    );
    refused(&group("a", &group("b", ball)), &["A shapegroup within a shapegroup shows nothing", "around it"]);
    let lamp = r#"<shape type="sphere"><emitter type="area"/></shape>"#;
    let solid = format!(r#"<shape type="union">{lamp}{ball}</shape>"#);
    refused(&group("a", &solid), &["A light on a part of a solid within a shapegroup", "put the solid"]);
    let keys = r#"<animation name="to_world"><transform time="0"/><transform time="1"><translate x="1"/></transform></animation>"#;
    let part = format!(r#"<shape type="union"><shape type="sphere">{keys}</shape>{ball}</shape>"#);
    refused(&group("a", &part), &["A part of a solid that moves within a shapegroup"]);
    let twice = format!("{}{}{}", group("a", lamp), group("b", &instance("a", keys)), instance("b", keys));
    refused(&twice, &["A light that moves within an instance that moves", "let either"]);
    let stretched = r#"<transform name="to_world"><scale x="2"/></transform>"#;
    let within =
        format!("{}{}{}", group("a", lamp), group("b", &instance("a", keys)), instance("b", stretched));
    refused(
        &within,
        &["A light that moves within an instance that is stretched", "scale the instance alike"],
    );
    // Hits tell 2³² − 1 instances apart: more than 1.4·10⁹, fewer than 5.7·10⁹.
    let fourfold = |levels: usize| {
        let mut text = group("g0", ball);
        for level in 1..=levels {
            let inner = format!("g{}", level - 1);
            let places = [0.0, 1.0, 2.0, 3.0].map(|x| moved(x * 2.5 * 4f64.powi(level as i32 - 1), 0.0, 0.0));
            text += &group(&format!("g{level}"), &places.map(|place| instance(&inner, &place)).concat());
        }
        text + &instance(&format!("g{levels}"), "")
    };
    refused(&fourfold(16), &["more instances than hits can tell apart", "innermost group"]);
    assert!(scene(&format!("{SKY}{}", fourfold(15))).warnings.is_empty());
}

/// Each of three levels shows the one below a thousand times.
#[test]
#[cfg(target_os = "linux")]
fn a_thousand_million_balls_take_little_memory() {
    let grid = |id: &str, inner: &str, pitch: f64| {
        let places = (0..1000).map(|i| [i % 10, i / 10 % 10, i / 100].map(|i| f64::from(i) * pitch));
        let all: String = places.map(|[x, y, z]| instance(inner, &moved(x, y, z))).collect();
        group(id, &all)
    };
    let file = format!(
        r#"<scene version="3.0.0"><sensor type="perspective"><transform name="to_world">
           <lookat origin="-900, -1400, 1300" target="500, 500, 500" up="0, 0, 1"/></transform></sensor>{SKY}{}{}{}{}{}
           </scene>"#,
        group("ball", r#"<shape type="sphere"><float name="radius" value="0.3"/></shape>"#),
        grid("a", "ball", 1.0),
        grid("b", "a", 10.5),
        grid("c", "b", 108.0),
        instance("c", ""),
    );
    let folder = Folder::new("nested");
    folder.write("balls.xml", file);
    let options = ["--size=32x32", "--spp=2", "--no-png", "--quiet", "-o", "balls.exr"];
    let peak = folder.peak_memory(&[&["render", "balls.xml"], &options[..]].concat());
    assert!(peak < 64 << 20, "{} MiB", peak >> 20);
    let centre = folder.picture("balls.exr").channel("G").expect("a channel")[16 * 32 + 16];
    assert!(centre > 0.05 && centre < 0.8, "{centre}");
}
