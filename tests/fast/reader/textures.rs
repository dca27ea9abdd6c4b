//! What colours and textures mean depends on where they stand, as seen in Mitsuba 3.9.1.

use super::{errors, scene, shape};
use crate::common::folder::Folder;
use abbe::scene::description::{
    BsdfKind, ConductorIndex, LightKind, PatternSpace, RgbRole, SpectrumKind, SpectrumSource,
};
use abbe::texture::{Filter, Octaves, Pattern, Veins, Wrap};

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
        r#"<shape type="sphere"><bsdf type="conductor"><rgb name="eta" value="-0.5 2 3"/></bsdf></shape>"#,
    );
    let BsdfKind::Conductor { index: ConductorIndex::Complex { n, .. }, .. } = &scene.shapes[0].bsdf.kind
    else {
        panic!("{:?}", scene.shapes[0].bsdf)
    };
    assert!(is_colour(n, [-0.5, 2.0, 3.0], RgbRole::Clipped));
    assert!(scene.assumptions.iter().any(|note| note.text.contains("below 0 count as 0 and above 1 as 1")));
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
    assert!(errors(&medium).contains("varies from place to place"));
}

#[test]
fn patterns_have_their_defaults() {
    let read = |plugin: &str, content: &str| {
        let source =
            reflectance(&format!(r#"<texture type="{plugin}" name="reflectance">{content}</texture>"#));
        let SpectrumKind::Procedural(source) = &source.kind else { panic!("{source:?}") };
        source.clone()
    };
    let noise = read("noise", "");
    let one = Octaves { count: 1, gain: 0.5, seed: 0 };
    assert_eq!(
        (noise.pattern, noise.period, noise.range, noise.mixed),
        (Pattern::Noise(one), 1.0, [0.0, 1.0], true)
    );
    assert!(matches!(noise.space, PatternSpace::World(_)));
    let colours: Vec<f64> = noise.colours.iter().map(|colour| colour.constant().unwrap()).collect();
    assert_eq!(colours, [0.0, 1.0]);
    let more = Octaves { count: 6, ..one };
    assert_eq!(read("turbulence", "").pattern, Pattern::Turbulence(more));
    assert_eq!(read("marble", "").pattern, Pattern::Marble(Veins { octaves: more, strength: 2.0 }));
    let bands = read(
        "bands",
        r#"<string name="space" value="uv"/><float name="period" value="0.2"/><float name="color0" value="0.5"/>
           <rgb name="color2" value="1 0 0"/><spectrum name="color1" value="400:0.5, 700:0.6"/>"#,
    );
    assert_eq!((bands.pattern, bands.mixed, bands.period), (Pattern::Bands, false, 0.2));
    assert!(matches!(bands.space, PatternSpace::Uv(_)) && bands.colours.len() == 3);
    let text = errors(
        r#"<shape type="sphere"><bsdf type="diffuse"><texture type="bands" name="reflectance"><float name="color1" value="1.5"/></texture></bsdf></shape>"#,
    );
    assert!(text.contains("reflectance is 1.5"), "{text}");
}

/// A metal's reflectance at normal incidence may vary, a body's index not.
#[test]
fn normal_reflectance_varies_on_metals_alone() {
    let of = |bsdf: &str, content: &str| {
        format!(
            r#"<shape type="sphere"><bsdf type="{bsdf}"><texture type="marble" name="normal_reflectance">
               <float name="color0" value="0.3"/><float name="color1" value="0.8"/></texture>{content}</bsdf></shape>"#
        )
    };
    assert!(matches!(shape(&of("conductor", "")).bsdf.kind, BsdfKind::Conductor { .. }));
    let known = r#"<float name="eta" value="0.2"/>"#;
    assert!(errors(&of("conductor", known)).contains("known eta"));
    assert!(errors(&of("dielectric", "")).contains("cannot vary over its surface"));
    assert!(
        errors(&of("conductor", "").replace("0.8", "1")).contains("reflectance \"normal_reflectance\" is 1")
    );
}

/// Files made for Mitsuba's RGB variants have masks and bump maps that are images in colour.
#[test]
fn an_image_in_colour_may_stand_where_a_number_is_asked() {
    let image = |name: &str| {
        format!(
            r#"<texture name="{name}" type="bitmap"><string name="filename" value="tests/scenes/broken/two.ppm"/></texture>"#
        )
    };
    let diffuse = r#"<bsdf type="diffuse"/>"#;
    for bsdf in [
        format!(r#"<bsdf type="mask">{}{diffuse}</bsdf>"#, image("opacity")),
        format!(r#"<bsdf type="bumpmap">{}{diffuse}</bsdf>"#, image("map")),
        format!(r#"<bsdf type="roughconductor">{}</bsdf>"#, image("alpha")),
        format!(r#"<bsdf type="blendbsdf">{}{diffuse}{diffuse}</bsdf>"#, image("weight")),
    ] {
        shape(&format!(r#"<shape type="sphere">{bsdf}</shape>"#));
    }
    let normals = format!(r#"<bsdf type="normalmap">{}{diffuse}</bsdf>"#, image("normalmap"));
    assert!(errors(&format!(r#"<shape type="sphere">{normals}</shape>"#)).contains("colour"));
}

/// A picture in floats with equal texels but for one.
fn picture(folder: &Folder, name: &str, texel: [f32; 3]) -> String {
    let mut values = [0.5; 3 * 2 * 3];
    values[3..6].copy_from_slice(&texel);
    let bytes: Vec<u8> = values.iter().flat_map(|value: &f32| value.to_le_bytes()).collect();
    folder.write(name, [b"PF\n2 3\n-1.0\n", bytes.as_slice()].concat());
    folder.path(name).display().to_string()
}

#[test]
fn colours_of_a_picture_beyond_a_reflectance_are_told() {
    let folder = Folder::new("beyond");
    let painted = |texel| {
        let file = picture(&folder, "paint.pfm", texel);
        let texture = format!(
            r#"<texture type="bitmap" name="NAME"><string name="filename" value="{file}"/></texture>"#
        );
        move |bsdf: &str, name: &str| {
            let texture = texture.replace("NAME", name);
            format!(r#"<shape type="sphere"><bsdf type="{bsdf}">{texture}</bsdf></shape>"#)
        }
    };
    let told = |texel| {
        let scene = scene(&painted(texel)("diffuse", "reflectance"));
        scene.assumptions.iter().map(|note| note.text.clone()).collect::<String>()
    };
    assert!(told([5.0, 0.5, 0.5]).contains("paint.pfm has values up to 5: "), "{}", told([5.0, 0.5, 0.5]));
    assert!(told([-2.0, 0.5, 5.0]).contains("from -2 to 5"));
    assert!(told([-2.0, 0.5, 1.0]).contains("down to -2"));
    assert!(!told([0.0, 1.0, 0.5]).contains("paint.pfm"));
    // A number is not clamped: it is the luminance of the colour.
    scene(&painted([1.0; 3])("principled", "metallic"));
    let wrong = errors(&painted([5.0; 3])("principled", "metallic"));
    assert!(wrong.contains("at the texel 1, 2") && wrong.contains("from 0 to 1"), "{wrong}");
}

#[test]
fn a_texel_that_no_sum_holds_is_refused() {
    let folder = Folder::new("bright");
    let sky = |texel| {
        let file = picture(&folder, "sky.pfm", texel);
        format!(r#"<emitter type="envmap"><string name="filename" value="{file}"/></emitter>"#)
    };
    scene(&sky([1e36, 0.5, 0.5]));
    let wrong = errors(&sky([0.5, 3e38, 0.5]));
    assert!(wrong.contains("The texel at 1, 2 of the picture is 3e38") && wrong.contains("1e36"), "{wrong}");
}
