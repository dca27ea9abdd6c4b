//! What a scene has no need of is left out of its rendering. Doing it all the same changes no bit of the
//! picture.

use abbe::film::Film;
use abbe::integrator::Estimator;
use abbe::render::{Settings, WavelengthCount};
use abbe::scene::{CompileOptions, Features, Scene};
use abbe::units::WavelengthRange;

fn scene(file: &str) -> Scene {
    crate::common::scene(file, &[("size", "24")], WavelengthRange::VISIBLE)
}

fn picture(scene: &Scene) -> Vec<[u64; 3]> {
    picture_by(scene, &crate::common::settings(8, WavelengthCount::Four, 3))
}

fn picture_by(scene: &Scene, settings: &Settings) -> Vec<[u64; 3]> {
    let film = crate::common::expose(scene, settings);
    let xyz = |film: &Film, x, y| {
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|w| film.combined(x, y, w).mean.to_bits())
    };
    (0..film.height)
        .flat_map(|y| (0..film.width).map(move |x| (x, y)))
        .map(|(x, y)| xyz(&film, x, y))
        .collect()
}

/// Paths without a segment bring nothing, as in Mitsuba, not even a lamp in view.
#[test]
fn a_depth_of_0_is_black() {
    let content = |depth: u32| {
        format!(
            r#"<integrator type="path"><integer name="max_depth" value="{depth}"/></integrator>
            <sensor type="perspective"><film type="hdrfilm"><integer name="width" value="8"/>
            <integer name="height" value="8"/></film></sensor><emitter type="constant"/>"#
        )
    };
    for estimator in [Estimator::Plain, Estimator::Shared] {
        let settings = Settings { estimator, ..crate::common::settings(8, WavelengthCount::Four, 3) };
        let is_black = |depth| {
            let scene = crate::common::made(&content(depth), &CompileOptions::default());
            picture_by(&scene, &settings).iter().flatten().all(|&bits| f64::from_bits(bits) == 0.0)
        };
        assert!(is_black(0) && !is_black(1), "{estimator}");
    }
}

const CORNELL: &str = "validation/speed/scenes/cornell.xml";
const CAUSTIC: &str = "validation/speed/scenes/caustic.xml";
const ABSORBER: &str = "validation/speed/scenes/absorber.xml";

/// Each need that the loop asks for, together with the account of media that it relies on.
fn forced() -> [(&'static str, Features); 9] {
    let none = Features::default();
    let stack = Features { medium_stack: true, ..none };
    [
        ("medium stack", stack),
        ("absorption", Features { absorption: true, ..stack }),
        ("scattering media", Features { scattering: true, absorption: true, ..stack }),
        ("precedence", Features { precedence: true, ..stack }),
        ("surfaces in contact", Features { contact: true, ..stack }),
        ("sensor within a body", Features { sensor_within: true, ..stack }),
        ("lens", Features { lens: true, ..none }),
        ("mixed materials", Features { choices: true, ..none }),
        ("transparent shadows", Features { transparent_shadows: true, ..none }),
    ]
}

#[test]
fn what_is_left_out_changes_no_bit() {
    for file in [CORNELL, CAUSTIC, ABSORBER] {
        let own = scene(file);
        let expected = picture(&own);
        for (name, features) in forced() {
            let forced = scene(file).with_features(features);
            let found = picture(&forced);
            let differ = expected.iter().zip(&found).filter(|(a, b)| a != b).count();
            assert_eq!(differ, 0, "{file}: {name}: {differ} of {} pixels differ", expected.len());
        }
    }
}

/// Features are those that a scene asks for, and pictures that differ are told apart.
#[test]
fn scenes_need_what_they_use() {
    let features = scene(ABSORBER).features();
    assert!(features.absorption && features.medium_stack, "{features}");
    assert!(!scene(CAUSTIC).features().absorption);
    assert_ne!(picture(&scene(ABSORBER)), picture(&scene(CAUSTIC)));
}

/// Light subpaths are traced where a side of a surface sends light on in single directions, the same way
/// forth and back.
#[test]
fn light_subpaths_are_for_specular_surfaces() {
    let traces = |bsdf: &str| {
        let content = format!(
            r#"<sensor type="perspective"/>
            <shape type="sphere"><point name="center" x="0" y="0" z="4"/>{bsdf}</shape>
            <shape type="rectangle"><transform name="to_world"><translate z="8"/></transform>
            <emitter type="area"><spectrum name="radiance" value="1"/></emitter></shape>"#
        );
        crate::common::made(&content, &CompileOptions::default()).features().caustics
    };
    let bsdf = |kind: &str, nested: &str| format!(r#"<bsdf type="{kind}">{nested}</bsdf>"#);
    let of = |kind: &str| bsdf(kind, "");
    let bumps = r#"<texture type="noise"/>"#;
    let specular = [
        of("conductor"),
        of("dielectric"),
        of("plastic"),
        bsdf("twosided", &of("plastic")),
        bsdf("twosided", &(of("diffuse") + &of("plastic"))),
    ];
    for bsdf in &specular {
        assert!(traces(bsdf), "{bsdf}");
    }
    let others = [
        of("diffuse"),
        of("roughplastic"),
        of("thindielectric"),
        bsdf("bumpmap", &(bumps.to_owned() + &of("plastic"))),
        bsdf("mask", &of("plastic")),
    ];
    for bsdf in &others {
        assert!(!traces(bsdf), "{bsdf}");
    }
}

/// Clip planes end the rays of the camera alone: what the wall that it sees gets from farther away is there.
#[test]
fn clips_end_no_other_rays_than_the_cameras() {
    let picture = |far: &str, more: &str, estimator: Estimator| {
        let content = format!(
            r#"<sensor type="perspective"><float name="near_clip" value="1"/><float name="far_clip" value="{far}"/>
                <film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="16"/></film></sensor>
            <emitter type="constant"/>
            <shape type="rectangle"><transform name="to_world"><scale value="3"/><rotate y="1" angle="180"/>
                <translate z="2"/></transform><bsdf type="diffuse"/></shape>
            <shape type="rectangle"><transform name="to_world"><scale value="20"/><translate z="-10"/></transform>
                <bsdf type="diffuse"><spectrum name="reflectance" value="0.1"/></bsdf></shape>{more}"#
        );
        let scene = crate::common::made(&content, &CompileOptions::default());
        let settings = Settings { estimator, ..crate::common::settings(8, WavelengthCount::Four, 3) };
        picture_by(&scene, &settings)
    };
    let many: String = (0..40)
        .map(|i| format!(r#"<shape type="sphere"><point name="center" x="{i}" y="30" z="-9"/></shape>"#))
        .collect();
    let glass = r#"<shape type="sphere"><point name="center" x="0" y="0" z="1.5"/><float name="radius" value="0.2"/>
        <bsdf type="dielectric"/></shape>"#;
    for more in ["", &many, glass] {
        for estimator in [Estimator::Shared, Estimator::Plain] {
            assert!(
                picture("4", more, estimator) == picture("1000", more, estimator),
                "{estimator:?}: {more}"
            );
        }
    }
}

/// Light that goes back through bodies that cross sees them in another order. Of two of which one lies within
/// the other it sees the same.
#[test]
fn crossing_bodies_throw_no_traced_caustics() {
    let has_caustics = |inner: &str| {
        let content = format!(
            r#"<integrator type="path"/><sensor type="perspective"><film type="hdrfilm"/>
            <transform name="to_world"><translate z="-5"/></transform></sensor>
            <shape type="sphere"><bsdf type="dielectric"><float name="int_ior" value="1.3"/></bsdf></shape>
            {inner}
            <shape type="disk"><transform name="to_world"><translate z="5"/></transform>
            <emitter type="area"/></shape>"#
        );
        crate::common::made(&content, &CompileOptions::default()).features().caustics
    };
    let ball = |centre: &str, more: &str| {
        format!(
            r#"<shape type="sphere"><point name="center" value="{centre}"/><float name="radius" value="0.4"/>
            <bsdf type="dielectric"><float name="int_ior" value="1.7"/></bsdf>{more}</shape>"#
        )
    };
    // Its box lies within the box of the larger ball in all three cases.
    assert!(has_caustics(&ball("0.3, 0.3, 0.3", "")));
    assert!(!has_caustics(&ball("0.5, 0.5, 0.5", "")));
    assert!(has_caustics(&ball("0.5, 0.5, 0.5", r#"<integer name="priority" value="1"/>"#)));
}
