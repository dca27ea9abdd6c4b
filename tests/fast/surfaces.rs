//! Materials and lamps that must change nothing.

use crate::common::{expose, made, settings};
use abbe::render::WavelengthCount;
use abbe::scene::CompileOptions;

/// Y of each pixel, with one wavelength a path.
fn picture(integrator: &str, depth: u32, content: &str) -> Vec<f64> {
    let content = format!(
        r#"<integrator type="{integrator}"><integer name="max_depth" value="{depth}"/></integrator>
           <sensor type="perspective"><float name="fov" value="40"/>
           <transform name="to_world"><lookat origin="0.3, -4, 2" target="0, 0, 0" up="0, 0, 1"/></transform>
           <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/>
           <rfilter type="box"/></film></sensor>{content}"#
    );
    let scene = made(&content, &CompileOptions::default());
    let film = expose(&scene, &settings(64, WavelengthCount::One, 1));
    film.shown().map(|(x, y)| film.combined(x, y, [0.0, 1.0, 0.0]).mean).collect()
}

/// What a ball sends out never falls on the ball itself. Half of it is open, so that nothing stops a light
/// sample that leads from a point to the very same point, and whatever rounding makes of its direction.
#[test]
fn a_ball_of_light_does_not_light_itself() {
    let ball = r#"<shape type="sphere"><point name="center" x="0.2" y="-0.6" z="-0.3"/>
        <float name="radius" value="0.7"/>
        <bsdf type="mask"><float name="opacity" value="0.5"/>
            <bsdf type="diffuse"><float name="reflectance" value="0.8"/></bsdf></bsdf>
        <emitter type="area"><float name="radiance" value="1"/></emitter></shape>"#;
    for integrator in ["path", "volpath"] {
        let [seen, lit] = [1, 4].map(|depth| picture(integrator, depth, ball));
        assert!(seen.iter().any(|&y| y > 0.1), "{seen:?}");
        for (seen, lit) in seen.iter().zip(&lit) {
            assert!((seen - lit).abs() < 1e-6, "{integrator}: {seen} and {lit}");
        }
    }
}

/// A bump map without height is the surface that it is on, whatever map is around it.
#[test]
fn a_flat_bump_map_changes_nothing() {
    let normals = |nested: &str| {
        format!(
            r#"<bsdf type="normalmap"><texture name="normalmap" type="rawconstant">
               <vector name="value" value="0.75, 0.5, 0.93301"/></texture>{nested}</bsdf>"#
        )
    };
    let flat = |nested: &str| {
        format!(
            r#"<bsdf type="bumpmap"><float name="scale" value="0"/><texture type="noise"/>{nested}</bsdf>"#
        )
    };
    let diffuse = r#"<bsdf type="diffuse"/>"#;
    let floor = |bsdf: &str| {
        let content = format!(
            r#"<shape type="rectangle">{bsdf}</shape>
               <emitter type="directional"><vector name="direction" x="-0.5" y="0.2" z="-1"/></emitter>"#
        );
        picture("path", 2, &content)
    };
    let both = |bsdf: &str| format!(r#"<bsdf type="twosided">{bsdf}</bsdf>"#);
    let plain = floor(diffuse);
    let turned = floor(&normals(diffuse));
    assert!(plain.iter().zip(&turned).any(|(a, b)| (a - b).abs() > 0.1 * a), "the normal map shows");
    for (name, bsdf, expected) in [
        ("alone", flat(diffuse), &plain),
        ("in a normal map", normals(&flat(diffuse)), &turned),
        ("around a normal map", flat(&normals(diffuse)), &turned),
        ("in a normal map on both sides", normals(&both(&flat(diffuse))), &turned),
    ] {
        for (found, expected) in floor(&bsdf).iter().zip(expected) {
            assert!((found - expected).abs() < 1e-6, "{name}: {found} in place of {expected}");
        }
    }
}

/// A lamp that shines to both sides, made of two, lights the floor below it as the lower one alone does,
/// whichever comes first; and so does a lamp that is flush with a black ceiling.
#[test]
fn of_sheets_in_one_place_the_one_that_is_faced_is_met() {
    let floor = r#"<shape type="disk"><transform name="to_world"><scale value="4"/></transform></shape>"#;
    let sheet = |turn: u32, size: u32, content: &str| {
        format!(
            r#"<shape type="rectangle"><transform name="to_world"><scale value="{size}"/>
               <rotate x="1" angle="{turn}"/><translate x="0.1" z="3"/></transform>{content}</shape>"#
        )
    };
    let light = r#"<emitter type="area"><spectrum name="radiance" value="3"/></emitter>"#;
    let black = r#"<bsdf type="diffuse"><spectrum name="reflectance" value="0"/></bsdf>"#;
    let [down, up] = [180, 0].map(|turn| sheet(turn, 1, light));
    let ceiling = sheet(180, 3, black);
    for integrator in ["path", "walk"] {
        let lit = |sheets: [&str; 2]| picture(integrator, 2, &format!("{floor}{}", sheets.concat()));
        let alone = lit([&down, ""]);
        assert!(alone.iter().sum::<f64>() > 1.0, "{alone:?}");
        for (name, sheets) in [
            ("down and up", [&down, &up]),
            ("up and down", [&up, &down]),
            ("lamp and ceiling", [&down, &ceiling]),
            ("ceiling and lamp", [&ceiling, &down]),
        ] {
            for (found, alone) in lit(sheets.map(String::as_str)).iter().zip(&alone) {
                assert!((found - alone).abs() < 1e-6, "{integrator}, {name}: {found} in place of {alone}");
            }
        }
    }
}
