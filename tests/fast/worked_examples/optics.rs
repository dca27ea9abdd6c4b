//! Fresnel's equations, refraction, lenses and what lies before a lamp.

use super::{assert_near, assert_near_vector, scattered, seen_through};
use abbe::bsdf::fresnel;
use abbe::camera::{Aperture, Projection, Projective, ProjectiveSettings, ThinLens};
use abbe::geometry::{Frame, Placed, Transform, Vec3};

#[test]
fn n08_glass_reflects_four_percent_straight_on() {
    assert_near(fresnel::dielectric(1.0, 1.5).reflectance, 0.04, 1e-15);
    assert_near(fresnel::conductor(1.0, 1.5, 0.0), 0.04, 1e-15);
}

#[test]
fn n09_refraction_at_45_degrees() {
    let direction = Vec3::new(1.0, 0.0, -1.0) / 2f64.sqrt();
    let refracted = scattered(direction, Vec3::Z, 1.5, true).unwrap();
    assert_near_vector(refracted, [0.4714045208, 0.0, -0.8819171037], 1e-9);
    assert_near((-refracted.z).acos().to_degrees(), 28.1255057, 1e-7);
    assert_near_vector(
        scattered(direction, Vec3::Z, 1.5, false).unwrap(),
        [0.5f64.sqrt(), 0.0, 0.5f64.sqrt()],
        1e-15,
    );
    // From glass into air there is total reflection from 41.8103149° on.
    for (degrees, leaves) in [(41.8103, true), (41.8104, false)] {
        let (sin, cos) = f64::to_radians(degrees).sin_cos();
        let out = scattered(Vec3::new(sin, 0.0, -cos), Vec3::Z, 1.0 / 1.5, true);
        assert_eq!(out.is_some(), leaves, "{degrees}");
    }
}

#[test]
fn n10_fresnel_reflectances() {
    let table = [
        (1.5, [0.04, 0.0415226260, 0.0502399110, 0.0891867128, 0.2530605630, 0.6127996453]),
        (2.0, [0.1111111111, 0.1129538084, 0.1226507601, 0.1613765956, 0.3086509920, 0.6301540130]),
    ];
    for (eta, reflectances) in table {
        for (degrees, expected) in [0.0, 30.0, 45.0, 60.0, 75.0, 85.0].into_iter().zip(reflectances) {
            assert_near(
                fresnel::dielectric(f64::to_radians(degrees).cos(), eta).reflectance,
                expected,
                1e-10,
            );
        }
    }
    // The two polarisations at 60°, and Brewster's angle, where only one is reflected.
    let at_60 = fresnel::dielectric(0.5, 1.5).reflectance;
    assert_near(at_60, 0.5 * (0.1765714881 + 0.0018019375), 1e-10);
    let brewster = 1.5f64.atan();
    assert_near(brewster.to_degrees(), 56.309932, 1e-6);
    assert_near(fresnel::dielectric(brewster.cos(), 1.5).reflectance, 25.0 / 338.0, 1e-15);
}

/// A lens of 50 mm at f/2 that is focused on 2 m; all lengths in mm.
#[test]
fn n11_circles_of_confusion() {
    let (focal_length, focus) = (50.0, 2000.0);
    let image = |distance: f64| focal_length * distance / (distance - focal_length);
    assert_near(image(focus), 51.2820512821, 1e-9);
    assert_near(image(4000.0), 50.6329113924, 1e-9);
    assert_near(image(1000.0), 52.6315789474, 1e-9);
    // The film stands where the focused plane is sharp; its pixels are millimetres.
    let film = [36.0, 24.0];
    let radius = focal_length / (2.0 * 2.0);
    let lens = ThinLens { aperture: Aperture::Disk { radius }, focus_distance: focus };
    let camera = Projective::new(ProjectiveSettings {
        placed: Placed::still(&Transform::IDENTITY).unwrap(),
        projection: Projection::ThinLens(lens),
        film,
        half_width: 0.5 * film[0] / image(focus),
        principal_point: [0.0; 2],
        near_clip: 1.0,
        far_clip: 1e12,
    });
    // The two ends of a diameter of the lens.
    let ends = [[1.0 - 1e-15, 0.5], [1e-15, 0.5]];
    let circle = |depth: f64| {
        let at = |x: f64, u: [f64; 2]| {
            let ray = camera.ray([x, 12.0], u, 0.0);
            ray.at((depth - ray.origin.z) / ray.direction.z)
        };
        // At a depth the place is a linear function of the film's: the film position that sees the axis
        // there.
        let sees_axis = ends.map(|u| {
            let (left, right) = (at(0.0, u).x, at(36.0, u).x);
            36.0 * left / (left - right)
        });
        // The blur in the scene, whose radius is the lens's at twice the distance, and that on the film.
        ((at(18.0, ends[0]) - at(18.0, ends[1])).length(), (sees_axis[0] - sees_axis[1]).abs())
    };
    for (depth, in_scene, on_film) in
        [(4000.0, 25.0, 0.3205128205), (1000.0, 12.5, 0.6410256410), (1e12, f64::NAN, 0.6410256410)]
    {
        let (blur, confusion) = circle(depth);
        assert_near(confusion, on_film, 1e-8);
        assert!(in_scene.is_nan() || (blur - in_scene).abs() < 1e-9, "{blur} is not {in_scene}");
    }
    assert!(circle(focus).1 < 1e-12);
}

#[test]
fn n12_a_slab_reflects_and_absorbs() {
    let absorption = -(0.8f64.ln());
    assert_near(absorption, 0.2231435513, 1e-10);
    // By the reflectance of each face, all orders summed.
    let reflectance = fresnel::dielectric(1.0, 1.5).reflectance;
    let transmitted =
        |inside: f64| (1.0 - reflectance).powi(2) * inside / (1.0 - (reflectance * inside).powi(2));
    assert_near(transmitted((-absorption * 3.0).exp()), 0.4720571952, 1e-9);
    assert_near(transmitted(1.0), 12.0 / 13.0, 1e-12);
    // And by the renderer: three units thick, between faces that each path chooses to pass or not.
    for (sigma, expected) in [(absorption, 0.4720571952), (0.0, 12.0 / 13.0)] {
        let (mean, error) = seen_through(&format!(
            r#"<shape type="cube">
                <transform name="to_world"><scale x="50" y="50" z="1.5"/></transform>
                <bsdf type="dielectric"><float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/></bsdf>
                <medium type="homogeneous" name="interior">
                    <float name="albedo" value="0"/><float name="sigma_t" value="{sigma:.15}"/>
                </medium>
            </shape>"#
        ));
        assert!(error < 2e-3 && (mean - expected).abs() < 4.5 * error, "{mean} ± {error}, not {expected}");
    }
}

/// What is transmitted by 40 % and by 30 % arrives by 12 %.
#[test]
fn n16_a_rays_weight_in_the_tree() {
    let screen = |z: f64, opacity: f64| {
        format!(
            r#"<shape type="rectangle">
                <transform name="to_world"><scale value="10"/><translate z="{z}"/></transform>
                <bsdf type="mask"><float name="opacity" value="{opacity}"/>
                    <bsdf type="diffuse"><spectrum name="reflectance" value="0"/></bsdf></bsdf>
            </shape>"#
        )
    };
    let (mean, error) = seen_through(&(screen(1.0, 0.6) + &screen(0.0, 0.7)));
    assert!(error < 2e-3 && (mean - 0.12).abs() < 4.5 * error, "{mean} ± {error}");
}

/// Refraction by the formulas of Whitted, of Heckbert, and a third, from index 1 into 1.5 and back.
#[test]
fn n26_refraction_by_three_formulas() {
    for (n1, n2) in [(1.0, 1.5), (1.5, 1.0)] {
        for degrees in [0.0, 10.0, 25.0, 40.0] {
            let (sin, cos) = f64::to_radians(degrees).sin_cos();
            let frame = Frame::around(Vec3::new(2.0, 3.0, 6.0) / 7.0);
            let (i, n) = (frame.to_world(Vec3::new(sin, 0.0, -cos)), frame.z);
            let found = scattered(i, n, n2 / n1, true).unwrap();

            let scaled = i / -i.dot(n);
            let index: f64 = n2 / n1;
            let factor = 1.0 / (index * index * scaled.dot(scaled) - (scaled + n).length_squared()).sqrt();
            let whitted = ((scaled + n) * factor - n).normalize();
            assert_near_vector(found, whitted.to_array(), 1e-14);

            let (inverse, c1) = (n1 / n2, -i.dot(n));
            let c2 = (1.0 - inverse * inverse * (1.0 - c1 * c1)).sqrt();
            let heckbert = i * inverse + n * (inverse * c1 - c2);
            assert_near_vector(found, heckbert.to_array(), 1e-14);

            let third = (i + n * (c1 - (index * index - 1.0 + c1 * c1).sqrt())) / index;
            assert_near_vector(found, third.to_array(), 1e-14);
        }
    }
}
