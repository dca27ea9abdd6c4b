//! The rays of sensors.

use crate::common::made;
use abbe::scene::{CompileOptions, Scene};

fn scene(content: &str) -> Scene {
    made(content, &CompileOptions::default())
}

const FILM: &str =
    r#"<film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="4"/></film>"#;
const PIXEL: &str =
    r#"<film type="hdrfilm"><integer name="width" value="1"/><integer name="height" value="1"/></film>"#;

/// Origin, direction and weight of the ray at a place of the exposed film, and its length.
fn ray(scene: &Scene, place: [f64; 2], second: [f64; 2]) -> ([f64; 3], [f64; 3], f64, f64) {
    let window = scene.film.extent.window;
    let film = [0, 1].map(|i| f64::from(window.offset[i]) + place[i] * f64::from(window.size[i]));
    let seen = scene.camera.ray(film, second, scene.shutter.open).unwrap();
    (seen.ray.origin.into(), seen.ray.direction.into(), seen.weight, seen.ray.t_max)
}

/// Plugin, content of the sensor, and origin, direction and length of a ray.
type Case = (&'static str, String, [f64; 3], [f64; 3], f64);

#[track_caller]
fn assert_near(found: [f64; 3], seen: [f64; 3], tolerance: f64) {
    assert!(found.iter().zip(seen).all(|(a, b)| (a - b).abs() < tolerance), "{found:?} {seen:?}");
}

#[test]
fn cameras_have_mitsubas_rays() {
    // `sensor.sample_ray` of Mitsuba 3.9.1 (scalar_spectral) for the place (.25, .25) of the film and
    // (.3, .9) of the lens.
    let crop = r#"<film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="4"/>
        <integer name="crop_width" value="4"/><integer name="crop_height" value="2"/>
        <integer name="crop_offset_x" value="1"/><integer name="crop_offset_y" value="2"/></film>"#;
    let fov = r#"<float name="fov" value="40"/>"#;
    let principal = r#"<float name="principal_point_offset_x" value=".25"/>
        <float name="principal_point_offset_y" value=".125"/>"#;
    let lens = r#"<float name="aperture_radius" value="1"/><float name="focus_distance" value="3"/>"#;
    let stretched = r#"<transform name="to_world"><scale x="2" y="3" z="4"/></transform>"#;
    let cases: [Case; 8] = [
        (
            "perspective",
            format!("{fov}{FILM}"),
            [0.00181985, 0.00090993, 0.01],
            [0.17833126, 0.08916563, 0.9799222],
            10204.8818359375,
        ),
        (
            "perspective",
            format!(r#"<float name="near_clip" value="1"/><float name="far_clip" value="5"/>{FILM}"#),
            [0.19349422, 0.09674711, 1.0],
            [0.18911943, 0.09455971, 0.9773906],
            4.092529773712158,
        ),
        (
            "perspective",
            format!("{fov}{crop}"),
            [0.00181985, -0.00045496, 0.01],
            [0.17886531, -0.04471631, 0.9828568],
            10174.412109375,
        ),
        (
            "perspective",
            format!(r#"{fov}<string name="fov_axis" value="y"/>{crop}"#),
            [0.0036397, -0.00090993, 0.01],
            [0.34077668, -0.08519413, 0.9362762],
            10680.59765625,
        ),
        (
            "perspective",
            format!("{principal}{crop}"),
            [0.0, -0.00096747, 0.01],
            [0.0, -0.09629744, 0.99535263],
            10046.6806640625,
        ),
        (
            "thinlens",
            format!("{lens}{FILM}"),
            [-0.30319133, 0.73760736, 0.01],
            [0.28055096, -0.14203086, 0.9492725],
            10534.3720703125,
        ),
        ("orthographic", FILM.to_owned(), [0.5, 0.25, 0.01], [0.0, 0.0, 1.0], 9999.990234375),
        ("orthographic", format!("{stretched}{FILM}"), [1.0, 0.75, 0.04], [0.0, 0.0, 1.0], 9999.990234375),
    ];
    for (plugin, content, origin, direction, length) in cases {
        let scene = scene(&format!(r#"<sensor type="{plugin}">{content}</sensor>"#));
        let found = ray(&scene, [0.25, 0.25], [0.3, 0.9]);
        assert_near(found.0, origin, 1e-6);
        assert_near(found.1, direction, 1e-6);
        assert!((found.3 / length - 1.0).abs() < 1e-6 && found.2 == 1.0, "{plugin} {content} {found:?}");
    }
}

#[test]
fn an_f_stop_is_the_focal_length_over_the_diameter_in_metres() {
    let widest = |content: &str| {
        let scene = scene(&format!(
            r#"<sensor type="thinlens"><float name="near_clip" value="1e-12"/>
               <float name="f_stop" value="2"/>{content}{FILM}</sensor>"#
        ));
        let (origin, ..) = ray(&scene, [0.5, 0.5], [0.5, 1.0]);
        origin
    };
    assert_near(widest(""), [0.0, 0.0125, 0.0], 1e-9);
    assert_near(widest(r#"<string name="focal_length" value="85mm"/>"#), [0.0, 0.02125, 0.0], 1e-9);
    // The vertical angle of 8 × 4 pixels, whose diagonal is that of 36 mm × 24 mm: 19.349 mm high, so
    // that f = 19.349 / 2.
    let fov = r#"<float name="fov" value="90"/><string name="fov_axis" value="y"/>"#;
    assert_near(widest(fov), [0.0, 0.25e-3 * 36f64.hypot(24.0) / 5f64.sqrt() / 2.0, 0.0], 1e-9);
    let blades = r#"<integer name="aperture_blades" value="4"/>"#;
    assert_near(widest(blades), [0.0, 0.0125, 0.0], 1e-9);
    let turned = format!(r#"{blades}<float name="aperture_rotation" value="90"/>"#);
    assert_near(widest(&turned), [0.0125, 0.0, 0.0], 1e-9);
}

#[test]
fn irradiance_is_measured_where_mitsuba_puts_a_film_on_a_shape() {
    // Places of four points of the film on five shapes, for directions along the normal (Mitsuba 3.9.1).
    let places = [[0.1, 0.2], [0.3, 0.4], [0.8, 0.35], [0.45, 0.95]];
    let shapes: [(&str, [[f64; 3]; 4]); 5] = [
        (
            "sphere",
            [
                [0.647272, 0.47027, 0.600054],
                [-0.302801, 0.931925, 0.200018],
                [0.29481, -0.907331, 0.300027],
                [-0.414593, 0.134709, -0.90008],
            ],
        ),
        (
            "cylinder",
            [
                [0.309045, 0.951142, 0.1],
                [-0.809089, 0.587838, 0.3],
                [-0.587838, 0.809089, 0.8],
                [0.951142, -0.309045, 0.45],
            ],
        ),
        (
            "disk",
            [
                [-0.665176, -0.444456, 0.0],
                [-0.369552, -0.153073, 0.0],
                [0.554328, -0.22961, 0.0],
                [-0.07844, 0.896575, 0.0],
            ],
        ),
        ("rectangle", [[-0.8, -0.6, 0.0], [-0.4, -0.2, 0.0], [0.6, -0.3, 0.0], [-0.1, 0.9, 0.0]]),
        (
            "cube",
            [
                [0.13842, 1.0, -0.241053],
                [1.0, 0.665336, 0.338656],
                [1.0, 0.284458, -0.821115],
                [-0.48324, 0.406705, -1.0],
            ],
        ),
    ];
    for (shape, seen) in shapes {
        let scene = scene(&format!(
            r#"<shape type="{shape}"><sensor type="irradiancemeter">{PIXEL}</sensor></shape>"#
        ));
        let centre = if shape == "cylinder" { 0.5 } else { 0.0 };
        for (place, [x, y, z]) in places.into_iter().zip(seen) {
            let (origin, _, weight, _) = ray(&scene, place, [0.5, 0.5]);
            // There, rays start 1e-4 above the surface.
            assert_near(origin, [x, y, z - centre], 1.2e-4);
            assert!((weight / std::f64::consts::PI - 1.0).abs() < 1e-12, "{shape} {weight}");
        }
    }
}

#[test]
fn distant_sensors_look_at_a_sphere_a_point_or_a_surface() {
    // A sphere of radius 2 has a bounding box of half diagonal √12, which Mitsuba 3.9.1 enlarges to
    // 3.464411.
    let rays = |content: &str, second: [f64; 2]| {
        let scene = scene(&format!(
            r#"<shape type="sphere"><float name="radius" value="2"/></shape>
               <sensor type="distant"><vector name="direction" value="0 0 -3"/>{content}{PIXEL}</sensor>"#
        ));
        ray(&scene, [0.1, 0.2], second)
    };
    let (origin, direction, weight, _) = rays("", [0.5, 0.5]);
    assert_near(origin, [0.0, 0.0, 3.464411], 1e-6);
    assert_eq!((direction, weight), ([0.0, 0.0, -1.0], 1.0));
    let (origin, ..) = rays("", [0.9, 0.5]);
    // 0.8 of the radius from the axis; around the axis it may lie anywhere.
    assert!((origin[0].hypot(origin[1]) - 2.771529).abs() < 1e-6 && (origin[2] - 3.464411).abs() < 1e-6);
    let (origin, ..) = rays(r#"<point name="target" value=".5 .25 0"/>"#, [0.3, 0.7]);
    assert_near(origin, [0.5, 0.25, 6.928823], 1e-6);
    let target = r#"<shape type="rectangle" name="target"><transform name="to_world"><scale x="3"/>
        <rotate y="1" angle="60"/></transform></shape>"#;
    let (origin, _, weight, _) = rays(target, [0.9, 0.2]);
    // Evenly over the surface, whatever its slope.
    assert!(weight == 1.0 && origin[0].abs() <= 1.5 && origin[1].abs() <= 1.0);
}

#[test]
fn a_batch_shows_each_sensor_in_its_column() {
    let lookat = |from: &str| {
        format!(
            r#"<transform name="to_world"><lookat origin="{from}" target="0 0 0" up="0 1 0"/></transform>"#
        )
    };
    let first = format!(r#"<sensor type="perspective"><float name="fov" value="40"/>{}"#, lookat("0 0 -5"));
    let second = format!(r#"<sensor type="orthographic">{}"#, lookat("5 0 0"));
    let film = |width: u32, height: u32, crop: &str| {
        format!(
            r#"<film type="hdrfilm"><integer name="width" value="{width}"/><integer name="height" value="{height}"/>{crop}</film>"#
        )
    };
    let batch = |film: &str| {
        scene(&format!(r#"<sensor type="batch">{first}</sensor>{second}</sensor>{film}</sensor>"#))
    };
    let alone = |sensor: &str| scene(&format!("{sensor}{}</sensor>", film(4, 4, "")));
    let both = batch(&film(8, 4, ""));
    // A crop window takes all of both, squeezed (Mitsuba 3.9.1).
    let squeezed = batch(&film(
        8,
        4,
        r#"<integer name="crop_width" value="3"/><integer name="crop_offset_x" value="2"/>"#,
    ));
    for place in [[0.1, 0.3], [0.49, 0.9], [0.51, 0.0], [1.0, 1.0]] {
        let column = if place[0] < 0.5 { 0.0 } else { 1.0 };
        let single = alone(if column == 0.0 { &first } else { &second });
        let (origin, direction, ..) = ray(&single, [2.0 * place[0] - column, place[1]], [0.5; 2]);
        for batch in [&both, &squeezed] {
            let found = ray(batch, place, [0.5; 2]);
            assert_near(found.0, origin, 1e-12);
            assert_near(found.1, direction, 1e-12);
        }
    }
}
