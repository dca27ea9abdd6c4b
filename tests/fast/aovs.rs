//! Images of what the camera sees first: what each of them shows, in scenes where that is known.

use crate::common::described;
use abbe::film::Film;
use abbe::render::{Auxiliary, NoProgress, Schedule, Settings, WavelengthCount, auxiliary, render};
use abbe::sampling::SamplerKind;
use abbe::scene::description::{Aov, AovKind};
use abbe::scene::{CompileOptions, Description, Scene, compile};
use abbe::units::WavelengthRange;

/// A camera at z = 5 that looks at the origin, through 16 × 16 pixels of a filter.
fn description(filter: &str, content: &str) -> Description {
    described(&format!(
        r#"<sensor type="perspective"><float name="fov" value="40"/><float name="near_clip" value="0.5"/>
           <transform name="to_world"><lookat origin="7, 0, 5" target="7, 0, 0" up="0, 1, 0"/></transform>
           <film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="16"/>
           <rfilter type="{filter}"/></film></sensor>{content}"#
    ))
}

fn compiled(filter: &str, content: &str) -> Scene {
    compile(&description(filter, content), &CompileOptions::default())
        .unwrap_or_else(|errors| panic!("{errors}"))
}

fn images(scene: &Scene, kinds: &[AovKind]) -> Vec<Auxiliary> {
    let aovs: Vec<Aov> = kinds.iter().map(|&kind| Aov { name: kind.name().to_owned(), kind }).collect();
    auxiliary(scene, &aovs, WavelengthRange::VISIBLE, Schedule::new(64), 3)
}

/// A wall in the plane z = 0 that fills the picture.
fn wall(bsdf: &str) -> String {
    format!(
        r#"<shape type="rectangle"><transform name="to_world"><scale value="9"/><translate x="7"/></transform>{bsdf}</shape>"#
    )
}

#[test]
fn the_albedo_of_white_is_white_and_has_no_noise_of_wavelengths() {
    let diffuse = |reflectance: &str| format!(r#"<bsdf type="diffuse">{reflectance}</bsdf>"#);
    let glass = r#"<bsdf type="dielectric"><spectrum name="int_ior" type="measured"><string name="name" value="N-SF11"/></spectrum></bsdf>"#.to_owned();
    for (bsdf, expected, tolerance) in [
        (diffuse(r#"<spectrum name="reflectance" value="1"/>"#), [1.0; 3], 1e-6),
        (diffuse(r#"<spectrum name="reflectance" value="0.25"/>"#), [0.25; 3], 1e-6),
        // What a colour is upsampled to gives it back under D65, but for 1/1000.
        (diffuse(r#"<rgb name="reflectance" value="0.2, 0.5, 0.8"/>"#), [0.2, 0.5, 0.8], 2e-3),
        // Light that is reflected and light that gets through, whose rays part by wavelength.
        (glass, [1.0; 3], 1e-6),
        (
            r#"<bsdf type="conductor"><string name="material" value="none"/></bsdf>"#.to_owned(),
            [1.0; 3],
            1e-6,
        ),
    ] {
        let scene = compiled("box", &wall(&bsdf));
        for (image, expected) in images(&scene, &[AovKind::Albedo]).iter().zip(expected) {
            let errors = image.errors.as_ref().expect("replicates");
            for (&value, &error) in image.values.iter().zip(errors) {
                assert!((value - expected).abs() < tolerance, "{bsdf} {}: {value}", image.name);
                assert!(error < 1e-6, "{bsdf} {}: {value} ± {error}", image.name);
            }
        }
    }
}

/// A coat on a diffuse base reflects by the one or the other: the error says how sure the mean is.
#[test]
fn the_albedo_of_a_coated_surface_has_error_bars_that_hold_it() {
    let bsdf = r#"<bsdf type="roughplastic"><spectrum name="diffuse_reflectance" value="0.5"/></bsdf>"#;
    let scene = compiled("box", &wall(bsdf));
    let means = |seed| -> (f64, f64) {
        let aovs = [Aov { name: "a".to_owned(), kind: AovKind::Albedo }];
        let images = auxiliary(&scene, &aovs, WavelengthRange::VISIBLE, Schedule::new(256), seed);
        let green = &images[1];
        let errors = green.errors.as_ref().expect("replicates");
        let count = green.values.len() as f64;
        let mean = green.values.iter().map(|&value| f64::from(value)).sum::<f64>() / count;
        let variance = errors.iter().map(|&error| f64::from(error).powi(2)).sum::<f64>();
        (mean, variance.sqrt() / count)
    };
    let ((a, of_a), (b, of_b)) = (means(1), means(2));
    assert!(of_a > 0.0 && of_a < 0.01, "{of_a}");
    assert!(((a - b) / of_a.hypot(of_b)).abs() < 4.0, "{a} ± {of_a}, {b} ± {of_b}");
    assert!(a > 0.3 && a < 0.7, "{a}");
}

#[test]
fn geometry_is_that_of_the_file_and_nothing_is_0() {
    // Far from the middle of the scene, and seen from behind what has two sides.
    let turned = r#"<shape type="rectangle"><transform name="to_world"><rotate y="1" angle="180"/><translate x="7" z="1"/></transform>
        <bsdf type="twosided"><bsdf type="diffuse"/></bsdf></shape>
        <shape type="sphere"><point name="center" x="-40" y="0" z="0"/></shape>"#;
    let scene = compiled("box", turned);
    let kinds = [
        AovKind::Depth,
        AovKind::Position,
        AovKind::GeometricNormal,
        AovKind::ShadingNormal,
        AovKind::Uv,
        AovKind::AlongU,
        AovKind::ShapeIndex,
    ];
    let images = images(&scene, &kinds);
    let value = |name: &str, pixel: usize| {
        let image = images.iter().find(|image| image.name == name).unwrap_or_else(|| panic!("no {name}"));
        image.values[pixel]
    };
    // In the middle and in the corner, where nothing is.
    let (middle, corner) = (8 * 16 + 8, 0);
    for image in &images {
        assert_eq!(image.values[corner], 0.0, "{}", image.name);
        assert!(image.values.iter().all(|value| value.is_finite()), "{}", image.name);
    }
    // Along the ray from the near plane, 0.5 before the camera.
    assert!((value("depth.T", middle) - 3.5).abs() < 0.05, "{}", value("depth.T", middle));
    assert!(
        (value("position.X", middle) - 7.0).abs() < 0.25 && (value("position.Z", middle) - 1.0).abs() < 1e-5
    );
    // As Mitsuba 3.9.1 has it: the side of the surface, whoever looks.
    assert!((value("geo_normal.Z", middle) + 1.0).abs() < 1e-6);
    assert!((value("sh_normal.Z", middle) + 1.0).abs() < 1e-6);
    assert!((value("uv.U", middle) - 0.5).abs() < 0.2 && (value("uv.V", middle) - 0.5).abs() < 0.2);
    assert!((value("dp_du.X", middle) + 2.0).abs() < 1e-5, "{}", value("dp_du.X", middle));
    assert_eq!(value("shape_index.I", middle), 1.0);
}

/// Under a filter with negative lobes as under any other.
#[test]
fn mean_normals_are_not_longer_than_1() {
    for filter in ["box", "gaussian", "mitchell", "lanczos"] {
        let scene =
            compiled(filter, r#"<shape type="sphere"><point name="center" x="7" y="0" z="0"/></shape>"#);
        let images = images(&scene, &[AovKind::ShadingNormal]);
        let length =
            |pixel: usize| images.iter().map(|image| image.values[pixel].powi(2)).sum::<f32>().sqrt();
        let longest = (0..256).map(length).fold(0.0, f32::max);
        assert!(longest <= 1.0 + 1e-6 && longest > 0.95, "{filter}: {longest}");
    }
}

#[test]
fn indices_tell_shapes_solids_and_instances_apart() {
    let at = |x: f64, content: &str, plugin: &str| {
        format!(
            r#"<shape type="{plugin}">{content}<transform name="to_world"><scale value="0.4"/><translate x="{x}"/></transform></shape>"#
        )
    };
    let moving = r#"<shape type="sphere"><ref id="paint"/><animation name="to_world">
        <transform time="0"><scale value="0.4"/><translate x="6.5"/></transform>
        <transform time="1"><scale value="0.4"/><translate x="6.5"/></transform></animation></shape>"#;
    let content = [
        r#"<bsdf type="diffuse" id="paint"/>"#.to_owned(),
        moving.to_owned(),
        at(5.5, "<bsdf type=\"conductor\"/>", "cube"),
        r#"<shape type="shapegroup" id="group"><shape type="sphere"/><shape type="disk"/></shape>"#
            .to_owned(),
        at(8.5, r#"<ref id="group"/>"#, "instance"),
        at(
            7.5,
            r#"<ref id="paint"/><shape type="cube"/><shape type="sphere"><point name="center" x="9" y="0" z="0"/></shape>"#,
            "union",
        ),
    ];
    let scene = compiled("gaussian", &content.concat());
    let images = images(&scene, &[AovKind::ShapeIndex, AovKind::MaterialIndex, AovKind::PrimitiveIndex]);
    assert!(images.iter().all(|image| image.errors.is_none()), "there is no mean of indices");
    // The camera sees x from 5.18 at the left to 8.82.
    let seen = |image: usize, x: f64| {
        let half = 5.0 * 20f64.to_radians().tan();
        let column = ((x - 7.0 + half) / (2.0 * half) * 16.0) as usize;
        images[image].values[8 * 16 + column]
    };
    // Shapes, then solids, then instances.
    assert_eq!([6.5, 5.5, 7.5, 8.5].map(|x| seen(0, x)), [1.0, 2.0, 3.0, 4.0]);
    assert!(images[0].values.iter().all(|value| value.fract() == 0.0));
    assert_eq!(seen(1, 6.5), seen(1, 7.5));
    assert_ne!(seen(1, 6.5), seen(1, 5.5));
    assert!(seen(1, 6.5) > 0.0);
}

fn film(scene: &Scene, samples: u32, seed: u64) -> Film {
    let settings = Settings {
        schedule: Schedule::with_replicates(samples, 16),
        seed,
        sampler: SamplerKind::Independent,
        wavelengths: Some(WavelengthCount::Four),
        estimator: abbe::integrator::Estimator::Plain,
        bins: None,
    };
    let film = render(scene, &settings, &NoProgress::new());
    assert_eq!(film.bad.total(), 0, "{:?}", film.bad);
    film
}

/// The variance of the mean that independent samples tell is that between replicates.
#[test]
fn second_moments_tell_the_variance_of_independent_samples() {
    let content = |integrator: &str| {
        format!(
            r#"{integrator}<shape type="sphere"><point name="center" x="7" y="0" z="0"/></shape>
               <emitter type="point"><point name="position" x="9" y="3" z="4"/><rgb name="intensity" value="9, 6, 3"/></emitter>
               <emitter type="constant"/>"#
        )
    };
    let moment = content(r#"<integrator type="moment"><integrator type="path"/></integrator>"#);
    // A filter that reaches several pixels would average over their samples too.
    let (samples, scene) = (1024, compiled("box", &moment));
    let film = film(&scene, samples, 5);
    let pixels: Vec<[u32; 2]> = (0..16).flat_map(|y| (0..16).map(move |x| [x, y])).collect();
    for (of, weights) in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].into_iter().enumerate() {
        let (mut from_moments, mut from_replicates) = (0.0, 0.0);
        for &[x, y] in &pixels {
            let mean = film.combined(x, y, weights);
            let square = film.second_moment(x, y, of);
            assert!(square.mean >= mean.mean * mean.mean * (1.0 - 1e-6), "{square:?} {mean:?}");
            from_moments += (square.mean - mean.mean * mean.mean) / f64::from(samples);
            from_replicates += mean.error * mean.error;
        }
        // A variance from 16 replicates has a relative error of √(2/15); the mean over the pixels one of a
        // sixteenth of that.
        let error = (2.0f64 / 15.0).sqrt() / 16.0;
        let ratio = from_replicates / from_moments;
        assert!((ratio - 1.0).abs() < 4.0 * error, "{ratio} ± {error}");
    }
    // The picture is the one without moments.
    let plain = compiled("box", &content(""));
    let plain = self::film(&plain, samples, 5);
    assert!(pixels.iter().all(|&[x, y]| {
        film.combined(x, y, [0.0, 1.0, 0.0]).mean == plain.combined(x, y, [0.0, 1.0, 0.0]).mean
    }));
}

/// The radiance of `depth` is the distance, whatever lamps there are.
#[test]
fn the_depth_integrator_shows_distances() {
    let lamp = r#"<emitter type="point"><spectrum name="intensity" value="588:0, 589:9, 590:0"/></emitter>"#;
    let scene = compiled("box", &format!("<integrator type=\"depth\"/>{lamp}{}", wall("")));
    let film = film(&scene, 256, 1);
    let [found, expected] = [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]].map(|weights| film.combined(8, 8, weights));
    // ∫ ȳ dλ / 106.75… is 1.0008 with the observer of 1 nm; x̄ likewise.
    for measured in [found, expected] {
        assert!((measured.mean - 4.5).abs() < 4.0 * measured.error + 0.05, "{measured:?}");
        assert!(measured.error < 0.2, "{measured:?}");
    }
}

/// A constant normal map turns the normal.
#[test]
fn a_raw_normal_is_the_normal() {
    let map = r#"<bsdf type="normalmap"><texture name="normalmap" type="rawconstant">
        <vector name="value" value="0.8, 0.5, 0.9"/></texture><bsdf type="diffuse"/></bsdf>"#;
    let scene = compiled("box", &wall(map));
    let found: Vec<f32> =
        images(&scene, &[AovKind::ShadingNormal]).iter().map(|image| image.values[136]).collect();
    for (found, expected) in found.iter().zip([0.6, 0.0, 0.8]) {
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
    }
}
