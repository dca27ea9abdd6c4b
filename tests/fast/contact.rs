//! Bodies with faces in common, bodies that overlap, and sensors within bodies: which surfaces a ray meets,
//! one by one, and what a picture shows.

use crate::common::{compiled, expose, made, mean_over_pixels, settings, stress, text_of};
use abbe::geometry::{Ray, Vec3};
use abbe::medium::Media;
use abbe::render::WavelengthCount;
use abbe::scene::{CompileOptions, RayKind, ReadOptions, Scene, read_str};
use abbe::spectrum::{Sampled, Wavelengths};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::TAU;
use std::path::Path;

const NM: Wavelengths<1> = Wavelengths { nm: [550.0], density: Sampled([1.0]) };

/// What Mitsuba 3 takes for the index of air.
const AIR: f64 = 1.000277;

fn scene(content: &str) -> Scene {
    let sensor = if content.contains("<sensor") { "" } else { r#"<sensor type="perspective"/>"# };
    made(&format!("{content}{sensor}"), &CompileOptions::default())
}

/// Indices seen one after the other by a ray that is always transmitted, until it meets what does not
/// transmit or nothing, and the share that Fresnel's equations let through.
fn straight_through(scene: &Scene, mut ray: Ray) -> (Vec<f64>, f64) {
    let mut media = scene.media_at_sensor(&ray, 0.0);
    let (mut indices, mut share) = (Vec::new(), 1.0);
    while let Some(hit) = scene.intersect(&ray, 0.0, RayKind::Scattered, &mut media, |_, _| {}) {
        let shading = scene.shade(&hit, -ray.direction, &media, &NM, 0.0);
        let Some(ratio) = shading.index_beyond() else { break };
        indices.push(ratio);
        let Some(scatter) = shading.sample(1.0f64.next_down(), [0.5; 2]) else { break };
        assert!(scatter.transmitted);
        share *= 1.0 - fresnel(ratio, ray.direction.dot(hit.point.normal).abs());
        scene.pass_through(&hit, scatter.toward_light, &mut media);
        ray = hit.point.ray(scatter.toward_light);
        assert!(indices.len() < 20, "{indices:?}");
    }
    (indices, share)
}

/// Unpolarised reflectance.
fn fresnel(ratio: f64, cos: f64) -> f64 {
    let cos_t = (1.0 - (1.0 - cos * cos) / (ratio * ratio)).sqrt();
    let s = (cos - ratio * cos_t) / (cos + ratio * cos_t);
    let p = (ratio * cos - cos_t) / (ratio * cos + cos_t);
    0.5 * (s * s + p * p)
}

const PLACES: [&str; 4] = [
    "",
    r#"<rotate x="0.36" y="0.48" z="0.8" angle="37"/>"#,
    r#"<rotate x="0.36" y="0.48" z="0.8" angle="37"/><translate x="1e5" y="-3e4" z="2e4"/>"#,
    r#"<translate x="12345.678" y="-0.1" z="1e5"/>"#,
];
const SCALES: [&str; 5] = ["1e-6", "1e-3", "1", "1e3", "1e6"];

/// A layer of a body from z to z, 8 thick around the axis.
fn layer(shape: &str, index: &str, [from, to]: [f64; 2], place: &str, more: &str) -> String {
    let geometry = match shape {
        "cube" => {
            format!(r#"<scale x="8" y="8" z="{}"/><translate z="{}"/>"#, 0.5 * (to - from), 0.5 * (from + to))
        }
        _ => format!(r#"<scale x="8" y="8" z="{}"/><translate z="{from}"/>"#, to - from),
    };
    let plugin = if shape == "cube" { "cube" } else { "cone" };
    let radii = if shape == "cube" { "" } else { r#"<float name="radius1" value="1"/>"# };
    format!(
        r#"<shape type="{plugin}">{radii}<transform name="to_world">{geometry}{place}</transform>
           <bsdf type="dielectric"><float name="int_ior" value="{index}"/></bsdf>{more}</shape>"#
    )
}

/// Every ray through a stack of layers meets the same indices one after the other and loses what Fresnel
/// says.
#[track_caller]
fn assert_indices(stacks: &[&dyn Fn(&str) -> String], expected: &[f64], rays: usize) {
    let mut random = Pcg64Mcg::seed_from_u64(5);
    let (mut misses, mut all) = (0, 0);
    for stack in stacks {
        for place in PLACES {
            for scale in SCALES {
                let to_world = format!(r#"{place}<scale value="{scale}"/>"#);
                let scene = scene(&(stack(&to_world) + &marker(&to_world)));
                let scale: f64 = scale.parse().unwrap();
                let (centre, axes) = frame_of(&scene, place);
                for _ in 0..rays / (stacks.len() * PLACES.len() * SCALES.len()) {
                    let cos: f64 = random.random_range(0.02..1.0);
                    let (sin, turn) = ((1.0 - cos * cos).sqrt(), random.random_range(0.0..TAU));
                    let local = Vec3::new(sin * turn.cos(), sin * turn.sin(), cos);
                    let direction = (axes[0] * local.x + axes[1] * local.y + axes[2] * local.z).normalize();
                    let [x, y] = [(); 2].map(|()| random.random_range(-2.0..2.0));
                    let at = centre + (axes[0] * x + axes[1] * y) * scale;
                    // From nearly on the first face to far before it.
                    let before = scale * 10f64.powf(random.random_range(-2.0..1.0));
                    let ray = Ray::new(at - direction * before, direction);
                    let (indices, share) = straight_through(&scene, ray);
                    all += 1;
                    let same = indices.len() == expected.len()
                        && indices.iter().zip(expected).all(|(a, b)| (a / b - 1.0).abs() < 1e-12);
                    let (mut sin, mut product) = (sin, 1.0);
                    for ratio in expected {
                        product *= 1.0 - fresnel(*ratio, (1.0 - sin * sin).sqrt());
                        sin /= ratio;
                    }
                    if !same || (share / product - 1.0).abs() > 1e-4 {
                        misses += 1;
                        if misses < 10 {
                            println!("{place} {scale} {cos}: {indices:?} {share} {product}");
                        }
                    }
                }
            }
        }
    }
    println!("{misses} of {all} rays");
    assert!(misses == 0, "{misses} of {all} rays");
}

/// A sensor in the middle of the first face.
fn marker(to_world: &str) -> String {
    format!(
        r#"<sensor type="radiancemeter"><transform name="to_world">{to_world}</transform>
           <film type="hdrfilm"><integer name="width" value="1"/><integer name="height" value="1"/></film></sensor>"#
    )
}

/// The middle of the first face and the axes of the layers, in the scene's own coordinates.
fn frame_of(scene: &Scene, place: &str) -> (Vec3, [Vec3; 3]) {
    let centre = scene.camera.ray([0.5; 2], [0.5; 2], 0.0).unwrap().ray.origin;
    if !place.contains("rotate") {
        return (centre, Vec3::AXES);
    }
    let turn = turned(Vec3::new(0.36, 0.48, 0.8), 37f64.to_radians());
    (centre, Vec3::AXES.map(turn))
}

/// Rodrigues' rotation.
fn turned(axis: Vec3, angle: f64) -> impl Fn(Vec3) -> Vec3 {
    move |v| v * angle.cos() + axis.cross(v) * angle.sin() + axis * axis.dot(v) * (1.0 - angle.cos())
}

const THREE: [f64; 4] = [1.5 / AIR, 1.33 / 1.5, 1.5 / 1.33, AIR / 1.5];

fn three(shapes: [&'static str; 3]) -> impl Fn(&str) -> String {
    move |place: &str| {
        layer(shapes[0], "1.5", [0.0, 1.0], place, "")
            + &layer(shapes[1], "1.33", [1.0, 2.0], place, "")
            + &layer(shapes[2], "1.5", [2.0, 3.0], place, "")
    }
}

/// OPT-27: glass, water and glass with touching walls.
#[test]
fn touching_walls_are_one_interface() {
    let stacks = [three(["cube"; 3]), three(["cone"; 3]), three(["cone", "cube", "cone"])];
    let backward = |place: &str| {
        layer("cube", "1.5", [2.0, 3.0], place, "")
            + &layer("cube", "1.33", [1.0, 2.0], place, "")
            + &layer("cube", "1.5", [0.0, 1.0], place, "")
    };
    let stacks: [&dyn Fn(&str) -> String; 4] = [&stacks[0], &stacks[1], &stacks[2], &backward];
    assert_indices(&stacks, &THREE, rays());
}

fn rays() -> usize {
    stress::count(200_000, 10_000_000)
}

/// Blocks of the same glass in contact are one block.
#[test]
fn glass_on_the_same_glass_has_no_surface_between() {
    let stack = |place: &str| {
        layer("cube", "1.5", [0.0, 1.0], place, "")
            + &layer("cone", "1.5", [1.0, 2.0], place, "")
            + &layer("cube", "1.5", [2.0, 3.0], place, "")
    };
    assert_indices(&[&stack], &[1.5 / AIR, AIR / 1.5], rays() / 2);
}

/// What overlaps by priorities is the same as what touches.
#[test]
fn overlapping_bodies_are_cut_by_their_priorities() {
    let high = r#"<integer name="priority" value="1"/>"#;
    let stack = |place: &str| {
        layer("cube", "1.5", [0.0, 1.0], place, high)
            + &layer("cone", "1.33", [0.7, 2.3], place, "")
            + &layer("cube", "1.5", [2.0, 3.0], place, high)
    };
    // Beneath the glass from one end to the other.
    let within = |place: &str| {
        layer("cube", "1.33", [0.0, 3.0], place, "") + &layer("cube", "1.5", [0.0, 3.0], place, high)
    };
    let low = r#"<integer name="priority" value="-3"/>"#;
    let lower = |place: &str| {
        layer("cube", "1.5", [0.0, 3.0], place, "") + &layer("cone", "1.33", [0.5, 2.0], place, low)
    };
    assert_indices(&[&stack], &THREE, rays() / 2);
    assert_indices(&[&within, &lower], &[1.5 / AIR, AIR / 1.5], rays() / 2);
}

/// Rays that leave a floor under a block of glass are in the glass, and leave it through another face.
#[test]
fn a_floor_in_contact_scatters_into_the_glass() {
    let mut random = Pcg64Mcg::seed_from_u64(8);
    for place in PLACES {
        for scale in SCALES {
            let to_world = format!(r#"{place}<scale value="{scale}"/>"#);
            let floor = format!(
                r#"<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="180"/><scale value="8"/>
                   <translate z="3"/>{to_world}</transform></shape>"#
            );
            let scene = scene(&format!(
                "{}{floor}{}",
                layer("cube", "1.5", [0.0, 3.0], &to_world, ""),
                marker(&to_world)
            ));
            let scale: f64 = scale.parse().unwrap();
            let (centre, axes) = frame_of(&scene, place);
            for _ in 0..rays() / 200 {
                let [x, y] = [(); 2].map(|()| random.random_range(-7.9..7.9));
                let from = centre + (axes[0] * x + axes[1] * y - axes[2]) * scale;
                let mut ray = Ray::new(from, axes[2]);
                let mut media = scene.media_at_sensor(&ray, 0.0);
                let glass = scene.intersect(&ray, 0.0, RayKind::Scattered, &mut media, |_, _| {}).unwrap();
                scene.pass_through(&glass, ray.direction, &mut media);
                ray = glass.point.ray(ray.direction);
                let floor = scene.intersect(&ray, 0.0, RayKind::Scattered, &mut media, |_, _| {}).unwrap();
                assert!(scene.shade(&floor, -ray.direction, &media, &NM, 0.0).index_beyond().is_none());
                // Down to grazing.
                let cos: f64 = 10f64.powf(random.random_range(-4.0..0.0));
                let turn = random.random_range(0.0..TAU);
                let sin = (1.0 - cos * cos).sqrt();
                let up = axes[0] * (sin * turn.cos()) + axes[1] * (sin * turn.sin()) - axes[2] * cos;
                ray = floor.point.ray(up.normalize());
                let out = scene.intersect(&ray, 0.0, RayKind::Scattered, &mut media, |_, _| {}).unwrap();
                let ratio = scene.shade(&out, -ray.direction, &media, &NM, 0.0).index_beyond().unwrap();
                assert!((ratio * 1.5 / AIR - 1.0).abs() < 1e-12, "{place} {scale} {x} {y} {cos}: {ratio}");
                assert!(out.point.normal.dot(ray.direction) > 0.0);
            }
        }
    }
}

/// A sensor within a ball of absorbing glass sees the sky through its surface, straight or after 1, 2, …
/// reflections there: n² T exp(−a r) / (1 − R exp(−2 a r)) of the sky's radiance from the middle.
#[test]
fn a_sensor_in_glass_sees_what_glass_lets_through() {
    let (blank, error_of_blank) = one();
    for (index, absorption) in [(1.5, 0.4), (1.33, 1.5)] {
        let scene = scene(&format!(
            r#"<integrator type="path"><integer name="max_depth" value="64"/></integrator>
            <sensor type="perspective"><float name="near_clip" value="1e-9"/><float name="fov" value="90"/>
                <film type="hdrfilm"><integer name="width" value="4"/><integer name="height" value="4"/>
                <string name="pixel_format" value="xyz"/><rfilter type="box"/></film></sensor>
            <shape type="sphere"><bsdf type="dielectric"><float name="int_ior" value="{index}"/>
                <float name="ext_ior" value="1"/></bsdf>
                <medium type="homogeneous" name="interior"><float name="sigma_t" value="{absorption}"/>
                <float name="albedo" value="0"/></medium></shape>
            <emitter type="constant"><spectrum name="radiance" value="1"/></emitter>"#
        ));
        assert!(scene.features().sensor_within);
        let reflectance = f64::powi((index - 1.0) / (index + 1.0), 2);
        let through = f64::exp(-absorption);
        let expected =
            index * index * (1.0 - reflectance) * through / (1.0 - reflectance * through * through);
        let film = expose(&scene, &settings(4096, WavelengthCount::Four, 1));
        let (mean, error) = mean_over_pixels(&film, |x, y| film.combined(x, y, [0.0, 1.0, 0.0]));
        let error = error.hypot(expected * error_of_blank);
        println!("{index}: {mean} ± {error}, expected {}", expected * blank);
        assert!((mean - expected * blank).abs() < 4.0 * error + 1e-6 * mean, "{index}: {mean} ± {error}");
    }
}

/// What a film has for a radiance of 1 at all wavelengths, and the standard error of that.
fn one() -> (f64, f64) {
    let scene = scene(
        r#"<sensor type="perspective"><film type="hdrfilm"><integer name="width" value="4"/>
           <integer name="height" value="4"/><string name="pixel_format" value="xyz"/><rfilter type="box"/></film></sensor>
           <emitter type="constant"><spectrum name="radiance" value="1"/></emitter>"#,
    );
    let film = expose(&scene, &settings(4096, WavelengthCount::Four, 2));
    mean_over_pixels(&film, |x, y| film.combined(x, y, [0.0, 1.0, 0.0]))
}

/// Before a sensor that moves out of glass there is glass for a part of the time.
#[test]
fn what_a_sensor_is_in_is_found_for_each_ray() {
    let scene = scene(
        r#"<sensor type="perspective"><float name="near_clip" value="1e-9"/></sensor>
           <shape type="sphere"><bsdf type="dielectric"/><medium type="homogeneous" name="interior">
           <float name="sigma_t" value="1"/><float name="albedo" value="0"/></medium></shape>
           <shape type="sphere"><float name="radius" value="0.5"/><bsdf type="dielectric"/></shape>"#,
    );
    let depth = |x: f64| {
        let media: Media = scene.media_at_sensor(&Ray::new(Vec3::X * x, Vec3::Y), 0.0);
        [0, 1].map(|body| media.here.contains(abbe::medium::Entered { body, instance: u32::MAX }))
    };
    assert_eq!([0.0, 0.7, 1.1].map(depth), [[true, true], [true, false], [false, false]]);
}

#[test]
fn scenes_that_touch_nothing_need_nothing() {
    let ball = |x: f64| {
        format!(
            r#"<shape type="sphere"><point name="center" x="{x}" y="0" z="0"/><bsdf type="dielectric"/></shape>"#
        )
    };
    let features = |content: &str| {
        let features = scene(&format!(r#"<sensor type="perspective"><transform name="to_world"><translate z="-9"/></transform></sensor>{content}"#)).features();
        [features.contact, features.precedence, features.sensor_within, features.medium_stack]
    };
    assert_eq!(features(&(ball(0.0) + &ball(2.5))), [false; 4]);
    assert_eq!(features(&(ball(0.0) + &ball(2.0))), [true, false, false, true]);
    assert_eq!(features(&(ball(0.0) + r#"<shape type="rectangle"/>"#)), [true, false, false, true]);
    let within = |x: f64| {
        format!(
            r#"<shape type="sphere"><point name="center" x="{x}" y="0" z="0"/><float name="radius" value="0.5"/></shape>"#
        )
    };
    assert_eq!(features(&(ball(0.0) + &within(0.25))), [false; 4]);
    assert_eq!(features(&(ball(0.0) + &within(0.5))), [true, false, false, true]);
}

/// A lens is no larger than what is left of the large balls that it is ground from: sensor, lamp and another
/// body lie within these, and outside of the lens.
#[test]
fn a_lens_is_not_the_balls_that_it_is_ground_from() {
    let scene = scene(
        r#"<integrator type="path"/>
        <sensor type="perspective"><transform name="to_world"><translate z="-9"/></transform></sensor>
        <shape type="intersection"><bsdf type="dielectric"/>
            <shape type="sphere"><point name="center" x="0" y="0" z="19.5"/><float name="radius" value="20"/></shape>
            <shape type="sphere"><point name="center" x="0" y="0" z="-19.5"/><float name="radius" value="20"/></shape>
        </shape>
        <shape type="sphere"><point name="center" x="0" y="0" z="4"/><bsdf type="dielectric"/></shape>
        <shape type="rectangle"><transform name="to_world"><translate z="-12"/></transform>
            <emitter type="area"><spectrum name="radiance" value="1"/></emitter></shape>"#,
    );
    let features = scene.features();
    let asked = [features.contact, features.precedence, features.sensor_within, features.medium_stack];
    assert_eq!((asked, features.caustics), ([false; 4], true));
}

/// The glasses of an achromat lie in one another's hollow, where no plane parts them; they touch where the
/// hollow is as deep as the other glass.
#[test]
fn a_glass_in_the_hollow_of_another_one_does_not_touch_it() {
    let asked = |radius: f64| {
        let scene = scene(&format!(
            r#"<integrator type="path"/>
            <sensor type="perspective"><transform name="to_world"><translate z="-9"/></transform></sensor>
            <shape type="intersection"><bsdf type="dielectric"><float name="int_ior" value="1.5"/></bsdf>
                <shape type="sphere"><point name="center" x="0" y="0" z="0.7"/></shape>
                <shape type="sphere"><point name="center" x="0" y="0" z="-0.7"/></shape>
            </shape>
            <shape type="difference"><bsdf type="dielectric"><float name="int_ior" value="1.6"/></bsdf>
                <shape type="cone"><point name="p0" x="0" y="0" z="-0.4"/><point name="p1" x="0" y="0" z="0"/>
                    <float name="radius" value="0.5"/><float name="radius1" value="0.5"/></shape>
                <shape type="union">
                    <shape type="sphere"><point name="center" x="0" y="0" z="0.7"/>
                        <float name="radius" value="{radius}"/></shape>
                    <shape type="sphere"><point name="center" x="9" y="0" z="0"/></shape>
                </shape>
            </shape>
            <shape type="rectangle"><transform name="to_world"><translate z="-12"/></transform>
                <emitter type="area"><spectrum name="radiance" value="1"/></emitter></shape>"#
        ));
        let features = scene.features();
        [features.contact, features.precedence, features.medium_stack]
    };
    assert_eq!(asked(1.01), [false; 3]);
    assert_eq!(asked(1.0), [true; 3]);
    assert_eq!(asked(0.99), [true; 3]);
}

/// A ball that only groups in groups show, whole or carried there, is found to touch what it touches.
#[test]
fn what_touches_is_found_in_groups_of_groups() {
    let features = |place: &str| {
        let features = scene(&format!(
            r#"<sensor type="perspective"><float name="shutter_close" value="1"/>
                <transform name="to_world"><translate z="-99"/></transform></sensor>
            <shape type="shapegroup" id="ball"><shape type="sphere"><bsdf type="dielectric"/></shape></shape>
            <shape type="shapegroup" id="moved"><shape type="instance"><ref id="ball"/>{place}</shape></shape>
            <shape type="shapegroup" id="more"><shape type="instance"><ref id="moved"/>
                <transform name="to_world"><scale value="2"/><translate x="7"/></transform></shape></shape>
            <shape type="instance"><ref id="more"/>
                <transform name="to_world"><rotate z="1" angle="90"/></transform></shape>
            <shape type="sphere"><bsdf type="dielectric"/></shape>"#
        ))
        .features();
        [features.contact, features.precedence, features.medium_stack]
    };
    let still = |x: f64| features(&format!(r#"<transform name="to_world"><translate x="{x}"/></transform>"#));
    let carried = |from: f64, to: f64| {
        let key = |time: u32, x: f64| format!(r#"<transform time="{time}"><translate x="{x}"/></transform>"#);
        features(&format!(r#"<animation name="to_world">{}{}</animation>"#, key(0, from), key(1, to)))
    };
    // Its radius is 2, its middle at y = 7 + 2 x: it reaches down to y = 1 for x = −2, and to 0.8 for
    // x = −2.1.
    assert_eq!(still(-1.5), [false; 3]);
    assert_eq!(still(-2.0), [true, false, true]);
    assert_eq!(still(-2.1), [true, true, true]);
    assert_eq!(carried(0.0, -1.5), [false; 3]);
    assert!(carried(0.0, -2.1)[0] && carried(-2.1, 0.0)[0], "the ball comes near while the shutter is open");
}

/// The same walls, each in a group in a group: one turns and moves it, one makes it larger or smaller.
/// Between the two it is far from the origin of its group, which costs digits that the bounds account for.
#[test]
fn touching_walls_of_groups_in_groups_are_one_interface() {
    let nested = |[there, back]: [&str; 2], to_world: &str| {
        let (place, scale) = to_world.split_at(to_world.rfind("<scale").expect("it is the last"));
        let one = |(number, index, range): (u32, &str, [f64; 2])| {
            let wall = layer("cube", index, range, "", "");
            format!(
                r#"<shape type="shapegroup" id="wall{number}">{wall}</shape>
                <shape type="shapegroup" id="placed{number}"><shape type="instance"><ref id="wall{number}"/>
                    <transform name="to_world">{place}{there}</transform></shape></shape>
                <shape type="instance"><ref id="placed{number}"/>
                    <transform name="to_world">{back}{scale}</transform></shape>"#
            )
        };
        [(0, "1.5", [0.0, 1.0]), (1, "1.33", [1.0, 2.0]), (2, "1.5", [2.0, 3.0])].map(one).concat()
    };
    let near = |to_world: &str| nested([""; 2], to_world);
    let far = |to_world: &str| {
        let [there, back] = [r#"x="54321.9" y="1e6" z="-777.7""#, r#"x="-54321.9" y="-1e6" z="777.7""#]
            .map(|offset| format!("<translate {offset}/>"));
        nested([&there, &back], to_world)
    };
    assert_indices(&[&near], &THREE, rays() / 2);
    assert_indices(&[&far], &THREE, rays() / 2);
}

/// A body that is thinner than the distances along a ray are exact is met and left behind. Such a hollow in
/// a bowl once held light subpaths for ever.
#[test]
fn a_body_thinner_than_its_errors_holds_no_ray() {
    let mut text = text_of(Path::new("scenes/fishbowl/scene.xml"));
    let hollow = r#"value="1, 1, 1, 0, 0, 0, 0, 0, 0, -0.8836""#;
    let thin = hollow.replacen('1', "4294967295", 1);
    for [from, to] in
        [[hollow, &thin], [r#"value="320""#, r#"value="8""#], [r#"value="240""#, r#"value="6""#]]
    {
        assert!(text.contains(from), "{from}");
        text = text.replacen(from, to, 1);
    }
    let description =
        read_str(&text, Path::new("scenes/fishbowl/scene.xml"), &ReadOptions::default()).unwrap();
    let scene = compiled(&description, &CompileOptions::default());
    let film = expose(&scene, &settings(32, WavelengthCount::Four, 1));
    let (mean, _) = mean_over_pixels(&film, |x, y| film.combined(x, y, [0.0, 1.0, 0.0]));
    assert!(mean > 0.1 && mean.is_finite(), "{mean}");
}
