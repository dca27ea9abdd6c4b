//! The worked examples of the source texts, their values recomputed and, where they were misprinted, corrected: A. Glassner (ed.),
//! *An Introduction to Ray Tracing*, 1989, by its chapters; G. Wyvill, *Practical Ray Tracing*, parts 1 and 2; G. Zachmann's
//! slides *Introduction to Ray Tracing and Physically-Based Rendering*.
//!
//! | example | where it is tested |
//! | --- | --- |
//! | N1 sphere, N2 its inverse mapping, N3 plane, N4 polygon, N5 quadrilateral, N6 box, N7 quadric (ch. 2) | `src/shape/tests/worked.rs`: `a_sphere`, `where_on_a_sphere`, `a_plane`, `a_polygon`, `a_quadrilateral`, `a_box`, `an_ellipsoid` and `a_quadric` |
//! | N8 to N10 Fresnel and refraction | `n08` to `n10`; to 60 digits in `src/bsdf/fresnel.rs` |
//! | N11 thin lens | `n11` |
//! | N12 absorbing slab | `n12` |
//! | N13, N14 jitter in space and in time | `n13`, `n14`; the noise too in `tests/sampling/jitter.rs` |
//! | N15 Heckbert's business card | `n15` |
//! | N16 weight of a ray in the tree, N17 mean of a pixel | `n16`, `n17` |
//! | N18 wheels that seem to turn backwards | `n18` |
//! | N19 visible range | `n19` |
//! | N20 weights of adaptive samples | `n20`: the formula alone, for nothing here samples in this way |
//! | N21 odds of a pixel that is all wrong, N22 aliases of a comb | `n21`, `n22` |
//! | N23 terms of an implicit surface | `n23` |
//! | N24 direction cube | `n24`: with a cube and its faces' solid angle, for nothing here sorts directions in this way |
//! | N25 time of Ullner's machine | `n25`: the sum alone, it is about a machine of 1983 |
//! | N26 counts of operations | `n26` in `counted.rs`: of the texts' formulas, whose results are those of this program |

mod counted;

use crate::common::{bins, expose, made, mean_over_pixels, settings};
use abbe::bsdf::fresnel;
use abbe::bsdf::{Bsdf, Dielectric};
use abbe::camera::{Aperture, Projection, Projective, ProjectiveSettings, Shutter, ShutterKind, ThinLens};
use abbe::film::{Extras, Film, FixedPoint};
use abbe::geometry::{Frame, Motion, Placed, Ray, SurfacePoint, Transform, Vec3};
use abbe::render::WavelengthCount;
use abbe::sampling::{Dimensions, Sampler, SamplerKind};
use abbe::scene::CompileOptions;
use abbe::shape::{Mesh, QuadricKind, Shape, Sphere};
use abbe::spectrum::Sampled;
use abbe::units::{SPEED_OF_LIGHT, WavelengthRange};
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;
use statrs::distribution::{ContinuousCDF, Normal};
use std::f64::consts::{PI, TAU};

fn assert_near(value: f64, expected: f64, tolerance: f64) {
    assert!((value - expected).abs() <= tolerance, "{value} is not {expected}");
}

fn assert_near_vector(value: Vec3, expected: [f64; 3], tolerance: f64) {
    let off = (value - Vec3::from_array(expected)).abs().max_element();
    assert!(off <= tolerance, "{value} is not {expected:?}");
}

/// Where a ray along `direction` goes on from a surface with a normal on its own side: reflected, or refracted into what has
/// `eta` times the index. `None` with total reflection.
fn scattered(direction: Vec3, normal: Vec3, eta: f64, refract: bool) -> Option<Vec3> {
    let (reflectance, transmittance) = if refract { (0.0, 1.0) } else { (1.0, 0.0) };
    let interface = Bsdf::Dielectric(Dielectric {
        eta: Sampled([eta]),
        specular_reflectance: Sampled([reflectance]),
        specular_transmittance: Sampled([transmittance]),
    });
    let frame = Frame::around(normal);
    let scatter = interface.sample(frame.to_local(-direction), 0.5, [0.5; 2])?;
    assert_eq!(scatter.transmitted, refract);
    Some(frame.to_world(scatter.toward_light))
}

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
        // At a depth the place is a linear function of the film's: the film position that sees the axis there.
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

/// The mean radiance seen through `shapes` in front of a lamp of radiance 1, looking down along z, with its standard error.
fn seen_through(shapes: &str) -> (f64, f64) {
    let text = format!(
        r#"
            <integrator type="path"/>
            <sensor type="perspective">
                <float name="fov" value="0.02"/>
                <transform name="to_world"><lookat origin="0, 0, 9" target="0, 0, 0" up="0, 1, 0"/></transform>
                <film type="hdrfilm">
                    <integer name="width" value="8"/><integer name="height" value="8"/><rfilter type="box"/>
                </film>
            </sensor>
            {shapes}
            <shape type="rectangle">
                <transform name="to_world"><scale value="10"/><translate z="-5"/></transform>
                <emitter type="area"><spectrum name="radiance" value="1"/></emitter>
            </shape>"#
    );
    let range = WavelengthRange::VISIBLE;
    let scene = made(&text, &CompileOptions { range, spectral: true, ..CompileOptions::default() });
    let mut settings = settings(4096, WavelengthCount::Four, 5);
    settings.sampler = SamplerKind::Independent;
    settings.bins = bins(range, 1);
    let film = expose(&scene, &settings);
    mean_over_pixels(&film, |x, y| film.bin(x, y, 0))
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

/// Cook's power gains of a jittered sine, white jitter over the whole cell and Gaussian jitter of σ = T/6.5: the squared mean
/// of cos(2πνζ) over the displacements ζ of the sampler, of which the standard error is known.
#[test]
fn n13_gains_of_jittered_sines() {
    let table = [
        (0.1, 0.96753, 0.99070),
        (0.25, 0.81057, 0.94327),
        (0.5, 0.40528, 0.79168),
        (0.75, 0.09006, 0.59120),
        (1.0, 0.0, 0.39282),
        (1.25, 0.03242, 0.23224),
        (1.5, 0.04503, 0.12216),
        (2.0, 0.0, 0.02381),
        (2.5, 0.01621, 0.00291),
        (3.0, 0.0, 0.00022),
    ];
    let normal = Normal::standard();
    let sampler = Sampler::new(SamplerKind::Jittered, 13, 1);
    let n = 200_000;
    let displacements: Vec<[f64; 2]> = (0..n)
        .map(|cell| {
            let [u, ..] = sampler.stream([cell, 0], 0, 0).draw(Dimensions::Camera);
            [u - 0.5, normal.inverse_cdf(u) / 6.5]
        })
        .collect();
    for (frequency, white, gaussian) in table {
        for (kind, gain) in [white, gaussian].into_iter().enumerate() {
            let (mut mean, mut square) = (0.0, 0.0);
            for displacement in &displacements {
                let kept = (TAU * frequency * displacement[kind]).cos();
                mean += kept / f64::from(n);
                square += kept * kept / f64::from(n);
            }
            let error = ((square - mean * mean) / f64::from(n)).sqrt();
            // Twenty tests; the table's last digit is half a unit off at most.
            let amplitude = [-1.0, 1.0].map(|digit: f64| (gain + 0.5e-5 * digit).max(0.0).sqrt());
            let off = (amplitude[0] - mean.abs()).max(mean.abs() - amplitude[1]).max(0.0);
            assert!(off < 4.0 * error, "νT = {frequency}, {kind}: {} is not {gain}", mean * mean);
        }
    }
}

/// Prototype 7 of 16 stands for the times from 6/16 to 7/16 of the shutter's.
#[test]
fn n14_times_by_slices() {
    let shutter = Shutter { open: 0.0, close: 1.0, kind: ShutterKind::Box };
    let sampler = Sampler::new(SamplerKind::Jittered, 14, 16);
    for pixel in 0..1000 {
        let mut times: Vec<f64> = (0..16)
            .map(|index| {
                let [.., time] = sampler.stream([pixel, 7], 0, index).draw(Dimensions::Camera);
                shutter.time(time)
            })
            .collect();
        times.sort_by(f64::total_cmp);
        assert_near(times[6], 0.40625, 1.0 / 32.0);
        for (slice, time) in times.iter().enumerate() {
            assert!((slice as f64..=slice as f64 + 1.0).contains(&(time * 16.0)), "{times:?}");
        }
    }
}

/// One of the five spheres on Heckbert's card: shares of diffuse, reflected, transmitted and emitted light, and the index
/// inside over that outside.
struct CardSphere {
    shape: Sphere,
    centre: Vec3,
    colour: Vec3,
    diffuse: f64,
    reflected: f64,
    transmitted: f64,
    emitted: f64,
    index: f64,
}

/// Its ray tracer in the style of Whitted, on this program's spheres, reflection and refraction.
struct Card(Vec<CardSphere>);

const CARD_AMBIENT: f64 = 0.02;

impl Card {
    /// `third` is the red of the third sphere, `radii` are those of the fourth and the fifth: what is misprinted in some copies.
    fn new(third: f64, radii: [f64; 2]) -> Self {
        let sphere = |centre: [f64; 3], colour: [f64; 3], radius: f64, shares: [f64; 4], index: f64| {
            let centre = Vec3::from_array(centre);
            CardSphere {
                shape: Sphere::new(&Transform::IDENTITY, centre, radius, false).unwrap(),
                centre,
                colour: Vec3::from_array(colour),
                diffuse: shares[0],
                reflected: shares[1],
                transmitted: shares[2],
                emitted: shares[3],
                index,
            }
        };
        Self(vec![
            sphere([0.0, 6.0, 0.5], [1.0, 1.0, 1.0], 0.9, [0.05, 0.2, 0.85, 0.0], 1.7),
            sphere([-1.0, 8.0, -0.5], [1.0, 0.5, 0.2], 1.0, [0.7, 0.3, 0.0, 0.05], 1.2),
            sphere([1.0, 8.0, -0.5], [third, 0.8, 0.8], 1.0, [0.3, 0.7, 0.0, 0.0], 1.2),
            sphere([3.0, -6.0, 15.0], [1.0, 0.8, 1.0], radii[0], [0.0, 0.0, 0.0, 0.6], 1.5),
            sphere([-3.0, -3.0, 12.0], [0.8, 1.0, 1.0], radii[1], [0.0, 0.0, 0.0, 0.5], 1.5),
        ])
    }

    fn nearest(&self, ray: &Ray) -> Option<(usize, f64)> {
        let hits =
            self.0.iter().enumerate().filter_map(|(i, sphere)| Some((i, sphere.shape.intersect(ray)?)));
        hits.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    fn trace(&self, level: u32, ray: &Ray) -> Vec3 {
        if level == 0 {
            return Vec3::ZERO;
        }
        let Some((index, t)) = self.nearest(ray) else { return Vec3::splat(CARD_AMBIENT) };
        let sphere = &self.0[index];
        let point: SurfacePoint = sphere.shape.surface(ray.at(t)).point;
        let inside = point.normal.dot(ray.direction) > 0.0;
        let normal = if inside { -point.normal } else { point.normal };
        let mut light = Vec3::splat(CARD_AMBIENT);
        for (other, lamp) in self.0.iter().enumerate() {
            let toward = (lamp.centre - point.position).normalize();
            let received = lamp.emitted * normal.dot(toward);
            let shadow = self.nearest(&point.ray(toward));
            if received > 0.0 && shadow.is_some_and(|(met, _)| met == other) {
                light += received * lamp.colour;
            }
        }
        let further = |direction: Option<Vec3>| {
            direction.map_or(Vec3::ZERO, |direction| self.trace(level - 1, &point.ray(direction)))
        };
        let eta = if inside { 1.0 / sphere.index } else { sphere.index };
        sphere.emitted * sphere.colour
            + sphere.diffuse * light * sphere.colour
            + sphere.reflected * further(scattered(ray.direction, normal, eta, false))
            + sphere.transmitted * further(scattered(ray.direction, normal, eta, true))
    }

    /// 32 × 32 pixels of 25°, red, green and blue up to 255.
    fn picture(&self) -> Vec<Vec3> {
        let distance = 16.0 / 12.5f64.to_radians().tan();
        (0..32 * 32)
            .map(|i| {
                let direction = Vec3::new(f64::from(i % 32) - 16.0, distance, 16.0 - f64::from(i / 32));
                (255.0 * self.trace(3, &Ray::new(Vec3::ZERO, direction.normalize()))).map(f64::round)
            })
            .collect()
    }
}

#[test]
fn n15_heckberts_card() {
    let mean = |picture: &[Vec3]| picture.iter().sum::<Vec3>() / picture.len() as f64;
    let card = Card::new(0.1, [7.0, 5.0]).picture();
    let pixels = [
        ([8, 20], [64.0, 38.0, 15.0]),
        ([24, 20], [4.0, 22.0, 27.0]),
        ([16, 12], [10.0; 3]),
        ([16, 16], [6.0; 3]),
        ([4, 4], [5.0; 3]),
    ];
    for ([column, row], expected) in pixels {
        assert_near_vector(card[32 * row + column], expected, 0.0);
    }
    assert_near_vector(mean(&card), [23.872, 19.420, 15.694], 5.1e-4);
    // As the course notes print it.
    let printed = Card::new(1.0, [0.7, 0.5]).picture();
    assert_near_vector(printed[32 * 20 + 24], [34.0, 22.0, 27.0], 0.0);
    assert_near_vector(mean(&printed), [27.569, 18.173, 14.255], 5.1e-4);
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

/// Nine rays of one pixel, six of which see green and three blue.
#[test]
fn n17_a_pixel_is_the_mean_of_its_rays() {
    let mut film = Film::new(1, 1, 1, Extras::default(), FixedPoint::for_reference(1.0));
    let mut tile = film.extras.tile([0, 0], [1, 1], 0..1);
    for ray in 0..9 {
        tile.add(0, 0, if ray < 6 { 1 } else { 2 }, 1.0, film.scale());
        tile.weigh(0, 0, 1.0);
    }
    film.add(&tile);
    assert_near(film.of_replicate(0, 0, 0, [0.0, 1.0, 0.0]), 2.0 / 3.0, 1e-9);
    assert_near(film.of_replicate(0, 0, 0, [0.0, 0.0, 1.0]), 1.0 / 3.0, 1e-9);
    assert_eq!((film.of_replicate(0, 0, 0, [1.0, 0.0, 0.0]), film.bad.total()), (0.0, 0));
}

/// A wheel that is seen six times a second seems to turn the shorter way from picture to picture, as what moves between
/// keyframes does here: once a second for one turn a second, once backwards for five, and either way for three.
#[test]
fn n18_wheels_seen_six_times_a_second() {
    let seen = |turns_per_second: f64| {
        let keys: Vec<(f64, Transform)> = (0..7)
            .map(|frame| {
                let turned = glam::DMat4::from_rotation_z(TAU * turns_per_second * f64::from(frame) / 6.0);
                (f64::from(frame) / 6.0, Transform::new(turned).unwrap())
            })
            .collect();
        let motion = Motion::new(&keys).unwrap();
        let angle = |time: f64| {
            let spoke = motion.at(time).world_vector(Vec3::X);
            spoke.y.atan2(spoke.x)
        };
        // In the first sixth of a second, by steps of a hundredth of it.
        let steps = (0..100).map(|i| {
            let step = angle(f64::from(i + 1) / 600.0) - angle(f64::from(i) / 600.0);
            step - TAU * (step / TAU).round()
        });
        steps.sum::<f64>() / TAU * 6.0
    };
    assert_near(seen(1.0), 1.0, 1e-12);
    assert_near(seen(5.0), -1.0, 1e-12);
    assert_near(seen(3.0).abs(), 3.0, 1e-12);
}

#[test]
fn n19_what_is_visible() {
    let terahertz = |nm: f64| SPEED_OF_LIGHT / (nm * 1e-9) * 1e-12;
    assert_near(terahertz(WavelengthRange::VISIBLE.min), 832.757, 5e-4);
    assert_near(terahertz(WavelengthRange::VISIBLE.max), 361.196, 5e-4);
}

/// A pixel with rays at its four corners and its middle, a quarter of which was divided again, and a quarter of that: each part
/// is the mean of its corner's ray and its middle's, or of its own four parts (ch. 1, fig. 19; there a bracket is misplaced).
#[test]
fn n20_weights_of_adaptive_samples() {
    type Weights = [f64; 18];
    let ray = |name: u8| {
        let mut weights: Weights = [0.0; 18];
        weights[(name - b'A') as usize] = 1.0;
        weights
    };
    let mean = |parts: &[Weights]| {
        let mut weights: Weights = [0.0; 18];
        for (i, weight) in weights.iter_mut().enumerate() {
            *weight = parts.iter().map(|part| part[i]).sum::<f64>() / parts.len() as f64;
        }
        weights
    };
    let pair = |a: u8, b: u8| mean(&[ray(a), ray(b)]);
    let around_k = mean(&[pair(b'E', b'K'), pair(b'G', b'K'), pair(b'L', b'K'), pair(b'J', b'K')]);
    let around_q = mean(&[pair(b'M', b'Q'), pair(b'P', b'Q'), pair(b'C', b'Q'), pair(b'R', b'Q')]);
    let around_g = mean(&[pair(b'F', b'G'), pair(b'B', b'G'), pair(b'H', b'G'), around_k]);
    let around_m = mean(&[pair(b'E', b'M'), pair(b'H', b'M'), pair(b'N', b'M'), around_q]);
    let pixel = mean(&[pair(b'A', b'E'), pair(b'D', b'E'), around_g, around_m]);
    let expected = [
        ("AD", 1.0 / 8.0),
        ("E", 37.0 / 128.0),
        ("GM", 13.0 / 128.0),
        ("H", 1.0 / 16.0),
        ("BFKNQ", 1.0 / 32.0),
        ("CJLPR", 1.0 / 128.0),
    ];
    for (names, weight) in expected {
        for name in names.bytes() {
            assert_eq!(pixel[(name - b'A') as usize], weight, "{}", name as char);
        }
    }
    assert_eq!(pixel.iter().sum::<f64>(), 1.0);
}

/// A pixel of which one half is white is black all over once in 2²⁰ when its 20 samples are independent; in jittered cells,
/// never.
#[test]
fn n21_odds_of_a_pixel_that_is_all_wrong() {
    let wrong = |kind: SamplerKind, samples: u32, pixels: u32| {
        let sampler = Sampler::new(kind, 21, samples);
        let all_black = |pixel: u32| {
            (0..samples).all(|index| {
                let [x, ..] = sampler.stream([pixel, 0], 0, index).draw(Dimensions::Camera);
                x < 0.5
            })
        };
        (0..pixels).filter(|&pixel| all_black(pixel)).count()
    };
    // 0.954 are expected in a million: more than 8 come once in four million times.
    assert_near(1e6 * 0.5f64.powi(20), 0.954, 5e-4);
    assert!(wrong(SamplerKind::Independent, 20, 1_000_000) <= 8);
    assert_eq!(wrong(SamplerKind::Jittered, 20, 1_000_000), 0);
    // With ten samples there are enough of them to be counted.
    let (seen, expected) = (wrong(SamplerKind::Independent, 10, 1_000_000) as f64, 1e6 / 1024.0);
    assert!((seen - expected).abs() < 4.0 * expected.sqrt(), "{seen}");
}

/// A comb of triangles 1.01 pixels apart: its teeth come back every 101 pixels with one sample in the middle of each pixel, and
/// every 25.25 with 4 × 4.
#[test]
fn n22_aliases_of_a_comb() {
    const PIXELS: usize = 1616;
    let period = |samples: u32| {
        let sampler = Sampler::new(SamplerKind::Regular, 22, samples);
        let mut power = vec![0.0; PIXELS / 2];
        for row in 20..30 {
            let mut line: Vec<Complex<f64>> = (0..PIXELS)
                .map(|column| {
                    let white = (0..samples).filter(|&index| {
                        let [x, y, ..] =
                            sampler.stream([column as u32, row], 0, index).draw(Dimensions::Camera);
                        let width = 1.0 - (f64::from(row) + y) / 50.0;
                        ((column as f64 + x) / 1.01).fract() < width
                    });
                    Complex::new(white.count() as f64 / f64::from(samples), 0.0)
                })
                .collect();
            FftPlanner::new().plan_fft_forward(PIXELS).process(&mut line);
            power.iter_mut().zip(&line).skip(1).for_each(|(sum, wave)| *sum += wave.norm_sqr());
        }
        let (most, _) = power.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).unwrap();
        PIXELS as f64 / most as f64
    };
    assert_eq!((period(1), period(16)), (101.0, 25.25));
}

/// (d + 1)(d + 2)(d + 3)/6 terms: ten coefficients make a quadric, 1330 would make a bicubic patch.
#[test]
fn n23_terms_of_implicit_surfaces() {
    let terms = |degree: usize| (degree + 1) * (degree + 2) * (degree + 3) / 6;
    let clip = abbe::geometry::Bounds { min: Vec3::NEG_INFINITY, max: Vec3::INFINITY };
    let QuadricKind::General { coefficients, .. } = (QuadricKind::General { coefficients: [1.0; 10], clip })
    else {
        unreachable!()
    };
    assert_eq!((terms(2), terms(18)), (coefficients.len(), 1330));
}

/// Direction (1, 2, 4) leaves a cube through its +z face at (0.25, 0.5); each face fills a sixth of all directions.
#[test]
fn n24_the_direction_cube() {
    let cube = Shape::Mesh(Mesh::cube(&Transform::IDENTITY, false).unwrap());
    let ray = Ray::new(Vec3::ZERO, Vec3::new(1.0, 2.0, 4.0).normalize());
    let hit = cube.intersect(&ray).unwrap();
    let point = cube.surface(&hit, &ray).point;
    assert_near_vector(point.position, [0.25, 0.5, 1.0], 1e-15);
    assert_near_vector(point.normal, [0.0, 0.0, 1.0], 0.0);
    let face = Shape::Mesh(Mesh::rectangle(&Transform::translation(Vec3::Z), false).unwrap());
    let front = SurfacePoint { position: Vec3::Z, normal: Vec3::Z, error: 0.0 };
    let solid_angle = 1.0 / face.density_toward(Vec3::ZERO, &front);
    assert_near(solid_angle, 2.0 * PI / 3.0, 1e-12);
    assert_near(solid_angle, 2.0944, 5e-5);
}

/// 512² pixels against 1000 polygons, each in a third of a microsecond.
#[test]
fn n25_the_time_of_ullners_machine() {
    let seconds_per_ray = 512.0 * 512.0 * 1000.0 / 3.0 * 1e-6;
    assert_near(seconds_per_ray, 87.4, 0.05);
    assert_near(600.0 / seconds_per_ray, 6.9, 0.05);
}
