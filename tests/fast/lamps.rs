//! Lights without a surface, where a scene gives little to go by: in the plane of a surface, far away and in
//! motion, over nothing.

use crate::common::{expose, made, mean_over_pixels, settings};
use abbe::film::Film;
use abbe::render::WavelengthCount;
use abbe::scene::CompileOptions;

/// Looks down upon a floor.
const CAMERA: &str = r#"<integrator type="path"><integer name="max_depth" value="2"/></integrator>
    <sensor type="perspective"><float name="fov" value="30"/><transform name="to_world">
    <lookat origin="0, 1, 3" target="0, 0, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/>
    <string name="pixel_format" value="xyz"/><rfilter type="box"/></film></sensor>"#;

const FLOOR: &str = r#"<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/>
    <scale value="3"/></transform><bsdf type="diffuse"/></shape>"#;

fn film(content: &str) -> Film {
    let scene = made(&format!("{CAMERA}{content}"), &CompileOptions::default());
    expose(&scene, &settings(64, WavelengthCount::Four, 1))
}

/// The mean of Y, and its standard error.
fn mean(content: &str) -> (f64, f64) {
    let film = film(content);
    mean_over_pixels(&film, |x, y| film.combined(x, y, [0.0, 1.0, 0.0]))
}

/// A lamp at the height of the ceiling lights the room as if there were none.
#[test]
fn a_surface_through_a_lamp_is_in_the_way_of_nothing() {
    let place = r#"<translate x="0.3" y="1.7" z="-0.2"/>"#;
    let down = format!(r#"<transform name="to_world"><rotate x="1" angle="90"/>{place}</transform>"#);
    let spot = format!(r#"<emitter type="spot"><float name="cutoff_angle" value="60"/>{down}</emitter>"#);
    let point = r#"<emitter type="point"><point name="position" x="0.3" y="1.7" z="-0.2"/></emitter>"#;
    let ceiling = |plugin: &str, operations: &str| {
        format!(
            r#"<shape type="{plugin}"><transform name="to_world">{operations}{place}</transform>
            <bsdf type="diffuse"><spectrum name="reflectance" value="0"/></bsdf></shape>"#
        )
    };
    let level = r#"<rotate x="1" angle="90"/><scale value="3"/>"#;
    for lamp in [point, &spot] {
        let (alone, error) = mean(&format!("{FLOOR}{lamp}"));
        assert!(alone > 100.0 * error, "{alone} ± {error}");
        let check = |name: &str, ceiling: &str| {
            // The same sample values make the same picture.
            let (found, _) = mean(&format!("{FLOOR}{lamp}{ceiling}"));
            assert!((found / alone - 1.0).abs() < 1e-4, "{name}: {found} for {alone}");
        };
        for (plugin, operations) in [
            ("rectangle", level),
            ("disk", level),
            ("cube", r#"<translate y="1"/><scale x="2" y="0.5" z="2"/>"#),
            ("sphere", r#"<translate y="1"/><scale value="2"/>"#),
        ] {
            check(plugin, &ceiling(plugin, operations));
        }
        for angle in [-6.5, -3.1, 2.3, 5.9] {
            let operations = format!(r#"{level}<rotate x="0.8" z="0.6" angle="{angle}"/>"#);
            check(&format!("tilted by {angle}°"), &ceiling("rectangle", &operations));
        }
    }
}

/// What the film is made for does not depend on how the file says where a lamp stands.
#[test]
fn a_lamp_that_moves_is_measured_from_where_it_stands() {
    let reference = |lamp: &str| {
        let ball = r#"<shape type="sphere"><float name="radius" value="0.2"/></shape>"#;
        made(&format!("{CAMERA}{FLOOR}{ball}{lamp}"), &CompileOptions::default()).reference_radiance
    };
    let slide = r#"<texture type="checkerboard" name="irradiance"/>"#;
    for (plugin, more) in [("point", ""), ("spot", ""), ("projector", slide)] {
        for height in [0.3, 1.0, 1e3, 1e6] {
            let place = format!(r#"<rotate x="1" angle="90"/><translate x="0.1" y="{height}"/>"#);
            let lamp = |to_world: &str| {
                reference(&format!(r#"<emitter type="{plugin}">{to_world}{more}</emitter>"#))
            };
            let still = match plugin {
                "point" => lamp(&format!(r#"<point name="position" x="0.1" y="{height}" z="0"/>"#)),
                _ => lamp(&format!(r#"<transform name="to_world">{place}</transform>"#)),
            };
            let keyframes = [0, 1].map(|time| format!(r#"<transform time="{time}">{place}</transform>"#));
            let moving = lamp(&format!(r#"<animation name="to_world">{}</animation>"#, keyframes.concat()));
            assert!((moving / still - 1.0).abs() < 1e-6, "{plugin} at {height}: {moving} for {still}");
        }
    }
}

/// A sky that lights nothing is seen, at its wavelengths.
#[test]
fn a_sky_over_nothing_is_seen() {
    let sky = r#"<emitter type="constant"><spectrum name="radiance" type="d65"/></emitter>"#;
    let (alone, error) = mean(sky);
    let sodium =
        r#"<emitter type="point"><spectrum name="intensity" value="588:0, 589:1, 590:0"/></emitter>"#;
    let (beside, error_beside) = mean(&format!("{sky}{sodium}"));
    println!("{alone} ± {error}, {beside} ± {error_beside}");
    assert!((beside - alone).abs() < 4.0 * error.hypot(error_beside) && error_beside < 0.01 * alone);
    // Only wavelengths at which it shines are sampled: each brings the same.
    let (line, error) =
        mean(r#"<emitter type="constant"><spectrum name="radiance" value="588:0, 589:1, 590:0"/></emitter>"#);
    assert!(error < 1e-3 * line, "{line} ± {error}");
}
