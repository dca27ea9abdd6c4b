//! The same motion told in different ways gives the same picture.

use super::{assert_agree, compiled, expose, mean, pixels, radiance};
use abbe::film::Film;
use abbe::stats::Estimate;

const SHUTTER: &str = r#"<float name="shutter_open" value="0"/><float name="shutter_close" value="1"/>"#;
const SIZE: u32 = 20;

fn film() -> String {
    super::film(SIZE, SIZE)
}

/// `to_world` of something that moves by `by` along x.
fn placed(steps: &str, by: f64) -> String {
    if by == 0.0 {
        return format!(r#"<transform name="to_world">{steps}</transform>"#);
    }
    let keys = [0.0, 1.0]
        .map(|time| format!(r#"<transform time="{time}">{steps}<translate x="{}"/></transform>"#, by * time));
    format!(r#"<animation name="to_world">{}</animation>"#, keys.concat())
}

/// A ball over a floor under a lamp, each of which moves by so much along x, and so does the camera.
fn ball(camera: f64, ball: f64, floor: f64, lamp: f64, seed: u64) -> Film {
    let scene = compiled(&format!(
        r#"<integrator type="path"><integer name="max_depth" value="3"/></integrator>
           <sensor type="perspective"><float name="fov" value="40"/>{SHUTTER}{}{}</sensor>
           <shape type="sphere">{}<bsdf type="roughconductor"><float name="alpha" value="0.3"/></bsdf></shape>
           <shape type="rectangle">{}<bsdf type="diffuse">
           <texture name="reflectance" type="checkerboard"/></bsdf></shape>
           <shape type="disk">{}<emitter type="area"><spectrum name="radiance" value="5"/></emitter></shape>
           <emitter type="constant"><spectrum name="radiance" value="0.1"/></emitter>"#,
        placed(r#"<lookat origin="0, 3, 6" target="0, 0.5, 0" up="0, 1, 0"/>"#, camera),
        film(),
        placed(r#"<translate y="1"/>"#, ball),
        placed(r#"<rotate x="1" angle="-90"/><scale value="6"/>"#, floor),
        placed(r#"<lookat origin="-3, 4, 1" target="0, 0, 0" up="0, 1, 0"/>"#, lamp),
    ));
    expose(&scene, 16, 32, seed)
}

fn assert_same(what: &str, a: &Film, b: &Film) {
    assert_agree(what, pixels(a).map(|(x, y)| (radiance(a, x, y), radiance(b, x, y))));
    // All of the picture at once is the sharpest.
    let whole = |film: &Film| mean(pixels(film).map(|(x, y)| radiance(film, x, y)));
    assert_agree(what, std::iter::once((whole(a), whole(b))));
}

#[test]
fn only_relative_motion_is_seen() {
    assert_same("a ball moves, or all else", &ball(0.0, 0.7, 0.0, 0.0, 1), &ball(-0.7, 0.0, -0.7, -0.7, 2));
    assert_same("the lamp moves, or all else", &ball(0.0, 0.0, 0.0, 2.0, 3), &ball(-2.0, -2.0, -2.0, 0.0, 4));
    assert_same(
        "the camera moves, or all else",
        &ball(0.5, 0.0, 0.0, 0.0, 5),
        &ball(0.0, -0.5, -0.5, -0.5, 6),
    );
}

/// A bar between a floor and a lamp at one time, or turning while the shutter is open.
fn bar(during: [f64; 2], replicates: u32, samples: u32, seed: u64) -> Film {
    let keys = [0.0, 1.0].map(|time| {
        format!(
            r#"<transform time="{time}"><scale x="0.15" y="0.9"/><rotate z="1" angle="{}"/><translate z="1"/></transform>"#,
            70.0 * time
        )
    });
    // From below a floor that lets light through, so that the bar itself is not seen.
    let scene = compiled(&format!(
        r#"<integrator type="path"><integer name="max_depth" value="2"/></integrator>
           <sensor type="orthographic"><float name="shutter_open" value="{}"/><float name="shutter_close" value="{}"/>
           <transform name="to_world"><scale x="1.5" y="1.5"/>
           <lookat origin="0, 0, -10" target="0, 0, 0" up="0, 1, 0"/></transform>{}</sensor>
           <shape type="rectangle"><transform name="to_world"><scale value="5"/></transform>
           <bsdf type="diffusetransmitter"/></shape>
           <shape type="rectangle"><animation name="to_world">{}</animation></shape>
           <shape type="disk"><transform name="to_world"><scale value="0.3"/><rotate x="1" angle="180"/>
           <translate z="5"/></transform><emitter type="area"><spectrum name="radiance" value="1"/></emitter></shape>"#,
        during[0],
        during[1],
        film(),
        keys.concat(),
    ));
    expose(&scene, replicates, samples, seed)
}

#[test]
fn a_moving_shadow_is_the_average_of_still_ones() {
    const INSTANTS: u32 = 64;
    let moving = bar([0.0, 1.0], 16, 64, 1);
    let still: Vec<Film> = (0..INSTANTS)
        .map(|i| {
            let time = (f64::from(i) + 0.5) / f64::from(INSTANTS);
            bar([time, time], 4, 6, 100 + u64::from(i))
        })
        .collect();
    let average = |x: u32, y: u32| -> Estimate { mean(still.iter().map(|film| radiance(film, x, y))) };
    assert_agree("shadow", pixels(&moving).map(|(x, y)| (radiance(&moving, x, y), average(x, y))));
    // And it is blurred: not what the middle of the time shows.
    let frozen = bar([0.5, 0.5], 16, 32, 3);
    let p =
        super::smallest_p(pixels(&moving).map(|(x, y)| (radiance(&moving, x, y), radiance(&frozen, x, y))));
    assert!(p < super::LEVEL, "the shadow stands still");
}

/// A ball that turns about its axis by so many degrees.
fn top(material: &str, degrees: f64, seed: u64) -> Film {
    let keys = [0.0, 1.0].map(|time| {
        format!(r#"<transform time="{time}"><rotate z="1" angle="{}"/></transform>"#, degrees * time)
    });
    let scene = compiled(&format!(
        r#"<integrator type="path"><integer name="max_depth" value="2"/></integrator>
           <sensor type="perspective"><float name="fov" value="25"/>{SHUTTER}
           <transform name="to_world"><lookat origin="0, -6, 1" target="0, 0, 0" up="0, 0, 1"/></transform>{}</sensor>
           <shape type="sphere"><animation name="to_world">{}</animation>{material}</shape>
           <shape type="disk"><transform name="to_world"><scale value="0.5"/>
           <lookat origin="-3, -5, 4" target="0, 0, 0" up="0, 0, 1"/></transform>
           <emitter type="area"><spectrum name="radiance" value="10"/></emitter></shape>"#,
        film(),
        keys.concat(),
    ));
    expose(&scene, 16, 40, seed)
}

#[test]
fn a_spinning_top_keeps_its_highlight_and_loses_its_pattern() {
    let metal = r#"<bsdf type="roughconductor"><float name="alpha" value="0.15"/></bsdf>"#;
    assert_same("highlight", &top(metal, 0.0, 1), &top(metal, 75.0, 2));
    // Six pairs of fields round the equator: a turn by one pair mixes them evenly. The coat's highlight lies
    // above both.
    let coated = |diffuse: &str| {
        format!(
            r#"<bsdf type="roughplastic"><float name="alpha" value="0.15"/>
            <boolean name="nonlinear" value="false"/>{diffuse}</bsdf>"#
        )
    };
    let fields = coated(
        r#"<texture name="diffuse_reflectance" type="checkerboard"><float name="color0" value="0.1"/>
           <float name="color1" value="0.7"/><transform name="to_uv"><scale x="6" y="4"/></transform></texture>"#,
    );
    let even = coated(r#"<spectrum name="diffuse_reflectance" value="0.4"/>"#);
    assert_same("pattern", &top(&fields, 60.0, 3), &top(&even, 0.0, 4));
    let (still, turned) = (top(&fields, 0.0, 5), top(&fields, 60.0, 6));
    let p = super::smallest_p(pixels(&still).map(|(x, y)| (radiance(&still, x, y), radiance(&turned, x, y))));
    assert!(p < super::LEVEL, "the pattern is not blurred");
}
