//! Materials, media, lights and paths at the ends of their ranges: every value is finite and not negative,
//! and where a closed form says what the radiance is, it is that within its error.

use super::common::stress;
use super::renders::{compiled, description, expose, mean, radiances};
use super::table::{Table, count, seconds};
use abbe::geometry::Vec3;
use abbe::scene::Description;
use abbe::scene::description::LightKind;
use abbe::stats::{Estimate, welch};
use std::f64::consts::{PI, TAU};
use std::time::Instant;

/// False alarms of one case.
const LEVEL: f64 = 1e-5;

/// What is known of a case's mean radiance.
#[derive(Clone, Copy)]
enum Known {
    Is(f64),
    /// It is that, with a standard error of less than a twentieth.
    IsQuietly(f64),
    /// Single scattering at rough surfaces loses energy, but never makes any.
    AtMost(f64),
}

/// A camera at (0, 0, 4) that looks down at little around the origin.
const CAMERA: &str = r#"<sensor type="perspective"><float name="fov" value="8"/>
    <transform name="to_world"><lookat origin="0, 0, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="4"/><integer name="height" value="4"/><rfilter type="box"/></film></sensor>"#;

/// A ball under light of radiance 1 from all around.
fn furnace(bsdf: &str, more: &str) -> String {
    format!(
        r#"{CAMERA}<emitter type="constant"><spectrum name="radiance" value="1"/></emitter>
           <shape type="sphere">{bsdf}{more}</shape>"#
    )
}

fn glass(index: f64) -> String {
    format!(
        r#"<bsdf type="dielectric"><float name="int_ior" value="{index:?}"/><float name="ext_ior" value="1"/></bsdf>"#
    )
}

fn rough(plugin: &str, alpha: f64, distribution: &str) -> String {
    format!(
        r#"<bsdf type="{plugin}"><float name="alpha" value="{alpha:?}"/><string name="distribution" value="{distribution}"/></bsdf>"#
    )
}

fn medium(absorption: f64) -> String {
    format!(
        r#"<medium type="homogeneous" name="interior"><spectrum name="sigma_t" value="{absorption:?}"/><float name="albedo" value="0"/></medium>"#
    )
}

/// A white floor, seen by a camera close to it, and what lights it.
fn floor(light: &str) -> String {
    format!(
        r#"<sensor type="perspective"><float name="fov" value="0.01"/>
           <float name="near_clip" value="1e-9"/>
           <transform name="to_world"><lookat origin="0.1, 0, 0.01" target="0, 0, 0" up="0, 1, 0"/></transform>
           <film type="hdrfilm"><integer name="width" value="4"/><integer name="height" value="4"/><rfilter type="box"/></film></sensor>
           <integrator type="path"><integer name="max_depth" value="2"/></integrator>
           <shape type="disk"><bsdf type="diffuse"><spectrum name="reflectance" value="1"/></bsdf></shape>{light}"#
    )
}

/// Seen from the point below its centre at a distance, a ball of radiance L makes the irradiance π L (radius
/// / distance)².
fn lamp(radius: f64, distance: f64, radiance: f64) -> String {
    floor(&format!(
        r#"<shape type="sphere"><float name="radius" value="{radius:?}"/><point name="center" x="0" y="0" z="{distance:?}"/>
           <emitter type="area"><spectrum name="radiance" value="{radiance:?}"/></emitter></shape>"#
    ))
}

/// A closed box that reflects and shines, with the camera inside: Σ reflectanceⁱ for i below the depth.
fn closed_box(reflectance: f64, depth: u32) -> String {
    format!(
        r#"{}<integrator type="path"><integer name="max_depth" value="{depth}"/><integer name="rr_depth" value="1000"/></integrator>
           <shape type="cube"><boolean name="flip_normals" value="true"/>
           <bsdf type="diffuse"><spectrum name="reflectance" value="{reflectance:?}"/></bsdf>
           <emitter type="area"><spectrum name="radiance" value="1"/></emitter></shape>"#,
        CAMERA.replace("0, 0, 4", "0.2, 0.1, 0.7").replace("target=\"0, 0, 0\"", "target=\"0, 0, -1\"")
    )
}

/// A ball that moves, while the shutter is open for no time.
fn instant(bsdf: &str) -> String {
    furnace(bsdf, r#"<animation name="to_world"><transform time="0"><translate x="-0.2"/></transform><transform time="1"><translate x="0.2"/></transform></animation>"#)
        .replace(r#"<float name="fov""#, r#"<float name="shutter_open" value="0.5"/><float name="shutter_close" value="0.5"/><float name="fov""#)
}

/// So many points of light in a ring over the floor, together of the given irradiance.
fn many_points(number: u32) -> Description {
    let mut description = description(&floor(
        r#"<emitter type="point"><spectrum name="intensity" value="1"/><point name="position" x="0" y="0" z="1"/></emitter>"#,
    ));
    let first = description.lights.pop().expect("a light");
    let LightKind::Point { intensity, .. } = &first.kind else { unreachable!("it is a point") };
    let intensity = abbe::scene::description::SpectrumSource {
        // At a distance of √2 the cosine is 1 / √2.
        scale: PI * 2.0 * 2f64.sqrt() / f64::from(number),
        ..intensity.clone()
    };
    description.lights = (0..number)
        .map(|i| {
            let (sin, cos) = (TAU * f64::from(i) / f64::from(number)).sin_cos();
            let kind = LightKind::Point {
                position: Vec3::new(cos, sin, 1.0),
                motion: None,
                intensity: intensity.clone(),
            };
            abbe::scene::description::Light { kind, ..first.clone() }
        })
        .collect();
    description
}

/// So many balls of light in a ring over the floor.
fn many_balls(number: u32) -> Description {
    // 10⁵ of them don't touch.
    const RADIUS: f64 = 1e-5;
    // Each makes L (radius / distance)² cos.
    let radiance = 2.0 * 2f64.sqrt() / (RADIUS * RADIUS * f64::from(number));
    let mut description = description(&floor(&format!(
        r#"<shape type="sphere"><float name="radius" value="{RADIUS}"/>
           <emitter type="area"><spectrum name="radiance" value="{radiance:?}"/></emitter></shape>"#
    )));
    let first = description.shapes.pop().expect("a lamp");
    let lamps = (0..number).map(|i| {
        let (sin, cos) = (TAU * f64::from(i) / f64::from(number)).sin_cos();
        let to_world = abbe::geometry::Transform::translation(Vec3::new(cos, sin, 1.0));
        abbe::scene::description::ShapeDescription { to_world, ..first.clone() }
    });
    description.shapes.extend(lamps);
    description
}

fn cases() -> Vec<(String, Description, Known)> {
    let mut all: Vec<(String, Description, Known)> = Vec::new();
    let mut add = |name: String, content: String, known: Known| {
        let described = description(&content);
        all.push((name, described, known));
    };
    for index in [1.0, 1.0 + 1e-7, 1.0 - 1e-7, 0.05, 10.0] {
        add(format!("ball of index {index:?}"), furnace(&glass(index), ""), Known::Is(1.0));
    }
    for reflectance in [0.0, 1e-9, 0.999, 0.999999] {
        let spectrum = format!(r#"<spectrum name="normal_reflectance" value="{reflectance:?}"/>"#);
        let glass = format!(r#"<bsdf type="dielectric">{spectrum}</bsdf>"#);
        add(format!("glass of R = {reflectance:?}"), furnace(&glass, ""), Known::Is(1.0));
        let metal = format!(r#"<bsdf type="conductor">{spectrum}</bsdf>"#);
        add(format!("metal of R = {reflectance:?}"), furnace(&metal, ""), Known::AtMost(1.0));
    }
    for distribution in ["beckmann", "ggx"] {
        for alpha in [1e-4, 1e-2, 1.0] {
            for plugin in ["roughconductor", "roughdielectric", "roughplastic"] {
                let name = format!("{plugin}, {distribution}, alpha {alpha:?}");
                add(name, furnace(&rough(plugin, alpha, distribution), ""), Known::AtMost(1.0));
            }
        }
    }
    add("no absorption".to_owned(), furnace(&glass(1.5), &medium(0.0)), Known::Is(1.0));
    add("absorption of 1e6, no reflection".to_owned(), furnace(&glass(1.0), &medium(1e6)), Known::Is(0.0));
    add("absorption of 1e6 in glass".to_owned(), furnace(&glass(1.5), &medium(1e6)), Known::AtMost(0.1));
    for (radius, distance) in
        [(1e-8, 1.0), (1e-7, 1.0), (1e-6, 1.0), (1e-3, 1.0), (0.5, 1.0), (1e3, 1e3 + 1.0), (1e3, 2e3)]
    {
        let radiance = distance * distance / (radius * radius);
        let name = format!("lamp of radius {radius:?} at {distance:?}");
        add(name, lamp(radius, distance, radiance), Known::IsQuietly(1.0));
    }
    for (reflectance, depth) in [(1.0f64, 128), (0.99, 128), (0.5, 1)] {
        let sum = (0..depth).map(|i| reflectance.powi(i as i32)).sum();
        let name = format!("closed box of {reflectance:?}, depth {depth}");
        add(name, closed_box(reflectance, depth), Known::Is(sum));
    }
    add("shutter of no time".to_owned(), instant(&glass(1.5)), Known::Is(1.0));
    for radiance in [1e-30, 1e-12, 1e12, 1e30] {
        let content = furnace(&glass(1.5), "")
            .replace(r#"value="1"/></emitter>"#, &format!(r#"value="{radiance:?}"/></emitter>"#));
        add(format!("radiance {radiance:?}"), content, Known::Is(radiance));
    }
    let lights = stress::count(10_000, 1_000_000);
    all.push((format!("{} points of light", count(lights)), many_points(lights as u32), Known::Is(1.0)));
    let lights = lights / 10;
    all.push((format!("{} balls of light", count(lights)), many_balls(lights as u32), Known::Is(1.0)));
    all
}

#[test]
fn nothing_is_too_extreme() {
    let samples = stress::count(64, 4096);
    let mut table = Table::new(
        "Ends of ranges: mean radiance where it is known",
        &["case", "samples", "bad", "known", "found", "error", "z", "s"],
    );
    let mut failures = Vec::new();
    for (seed, (name, description, known)) in (1u64..).zip(cases()) {
        let began = Instant::now();
        let film = expose(&compiled(&description), samples, seed);
        let found = mean(&radiances(&film));
        let (text, expected) = match known {
            Known::Is(expected) | Known::IsQuietly(expected) => (format!("{expected:.6e}"), expected),
            Known::AtMost(most) => (format!("≤ {most}"), most),
        };
        // Sums are rounded to a unit that the scene's brightest radiance decides.
        let rounding = 1e-9 * expected;
        let apart = found.mean - expected;
        let p = if apart.abs() <= rounding { 1.0 } else { welch(&found, &Estimate::exact(expected)).p_value };
        let is_well = match known {
            Known::Is(_) => p > LEVEL,
            Known::IsQuietly(_) => p > LEVEL && found.error() < expected / 20.0,
            Known::AtMost(_) => found.mean >= 0.0 && (apart <= rounding || p > LEVEL),
        };
        let error = found.variance.sqrt();
        table.row(&[
            name.clone(),
            count(film.total_samples()),
            film.bad.total().to_string(),
            text,
            format!("{:.6e}", found.mean),
            format!("{error:.1e}"),
            if error > 0.0 { format!("{:.1}", apart / error) } else { "-".to_owned() },
            seconds(began),
        ]);
        if film.bad.total() > 0 || !is_well {
            failures.push(format!(
                "{name}: {:?}, {} ± {error}, known {known}",
                film.bad,
                found.mean,
                known = expected
            ));
        }
    }
    table.print();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
