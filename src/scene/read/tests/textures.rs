//! What colours and textures mean depends on where they stand, as seen in Mitsuba 3.9.1.

use super::{errors, scene, shape};
use crate::scene::description::{BsdfKind, ConductorIndex, LightKind, RgbRole, SpectrumKind, SpectrumSource};
use crate::texture::{Filter, Wrap};

fn reflectance(content: &str) -> SpectrumSource {
    let shape = shape(&format!(r#"<shape type="sphere"><bsdf type="diffuse">{content}</bsdf></shape>"#));
    let BsdfKind::Diffuse { reflectance } = &shape.bsdf.kind else { panic!("{:?}", shape.bsdf) };
    reflectance.clone()
}

fn is_colour(source: &SpectrumSource, expected: [f64; 3], meant: RgbRole) -> bool {
    matches!(source.kind, SpectrumKind::Rgb { rgb, role } if rgb == expected && role == meant)
}

#[test]
fn colours_are_made_into_what_their_place_asks_for() {
    let one = [0.1, 0.2, 0.3];
    for content in [
        r#"<rgb name="reflectance" value="0.1, 0.2 0.3"/>"#,
        r#"<texture type="rgb" name="reflectance"><rgb name="value" value="0.1 0.2 0.3"/></texture>"#,
        r#"<spectrum type="srgb" name="reflectance"><rgb name="color" value="0.1 0.2 0.3"/></spectrum>"#,
        r#"<spectrum type="srgb" name="reflectance"><vector name="color" value="0.1 0.2 0.3"/></spectrum>"#,
    ] {
        assert!(is_colour(&reflectance(content), one, RgbRole::Reflectance), "{content}");
    }
    assert!(is_colour(
        &reflectance(r#"<rgb name="reflectance" value="0.5"/>"#),
        [0.5; 3],
        RgbRole::Reflectance
    ));
    let light = |content: &str| match &scene(content).lights[0].kind {
        LightKind::Constant { radiance } => radiance.clone(),
        other => panic!("{other:?}"),
    };
    let lit = light(r#"<emitter type="constant"><rgb name="radiance" value="1 2 3"/></emitter>"#);
    assert!(is_colour(&lit, [1.0, 2.0, 3.0], RgbRole::Illuminant));
    // A plugin is the same everywhere, unlike the element.
    let plugin = r#"<emitter type="constant"><spectrum type="rgb" name="radiance"><rgb name="value" value="0.1 0.2 0.3"/></spectrum></emitter>"#;
    assert!(is_colour(&light(plugin), one, RgbRole::Reflectance));

    let scene = scene(
        r#"<shape type="sphere"><bsdf type="conductor"><rgb name="eta" value="1.5 2 3"/></bsdf></shape>"#,
    );
    let BsdfKind::Conductor { index: ConductorIndex::Complex { n, .. }, .. } = &scene.shapes[0].bsdf.kind
    else {
        panic!("{:?}", scene.shapes[0].bsdf)
    };
    assert!(is_colour(n, [1.5, 2.0, 3.0], RgbRole::Clipped));
    assert!(scene.assumptions.iter().any(|note| note.text.contains("count as 1")));
}

#[test]
fn textures_have_mitsubas_defaults() {
    let board = reflectance(r#"<texture type="checkerboard" name="reflectance"/>"#);
    let SpectrumKind::Checkerboard(board) = &board.kind else { panic!("{board:?}") };
    let values = board.colours.each_ref().map(|colour| match colour.kind {
        SpectrumKind::Constant(value) => value,
        ref other => panic!("{other:?}"),
    });
    assert_eq!(values, [0.4, 0.2]);
    let bitmap = reflectance(
        r#"<texture type="bitmap" name="reflectance"><string name="filename" value="tests/scenes/textures/colours.png"/></texture>"#,
    );
    let SpectrumKind::Bitmap(bitmap) = &bitmap.kind else { panic!("{bitmap:?}") };
    assert_eq!(
        (bitmap.filter, bitmap.wrap, bitmap.raw, bitmap.half),
        (Filter::Linear, Wrap::Repeat, false, false)
    );
    assert_eq!((bitmap.image.width, bitmap.image.height, bitmap.image.channels), (4, 3, 3));
}

#[test]
fn a_constant_volume_is_its_value() {
    let source = reflectance(
        r#"<texture type="volume" name="reflectance"><volume type="constvolume" name="volume"><float name="value" value="0.3"/></volume></texture>"#,
    );
    assert!(matches!(source.kind, SpectrumKind::Constant(0.3)), "{source:?}");
}

#[test]
fn textures_stand_only_where_they_can_be_looked_up() {
    let board = |name: &str| format!(r#"<texture type="checkerboard" name="{name}"/>"#);
    for emitter in [("constant", "radiance"), ("point", "intensity"), ("directional", "irradiance")] {
        let text = errors(&format!(r#"<emitter type="{}">{}</emitter>"#, emitter.0, board(emitter.1)));
        assert!(text.contains("cannot vary"), "{text}");
    }
    let area =
        format!(r#"<shape type="sphere"><emitter type="area">{}</emitter></shape>"#, board("radiance"));
    assert!(shape(&area).emission.is_some());
    let medium = format!(
        r#"<medium type="homogeneous" id="m">{}<float name="albedo" value="0"/></medium>"#,
        board("sigma_t")
    );
    assert!(errors(&medium).contains("cannot vary over a surface"));
}
