//! Lenses and a prism cut from balls, cylinders and boxes: where single rays of the lines F, d and C go,
//! against closed forms.

use crate::common::made;
use abbe::geometry::{Ray, Vec3};
use abbe::scene::{CompileOptions, RayKind, Scene};
use abbe::spectrum::{Sampled, Wavelengths};

/// The lines F and C of hydrogen and d of helium, in nm.
const F: f64 = 486.1327;
const D: f64 = 587.5618;
const C: f64 = 656.2725;

fn scene(content: &str) -> Scene {
    made(&format!(r#"{content}<sensor type="perspective"/>"#), &CompileOptions::default())
}

/// A glass by its Sellmeier coefficients (SCHOTT, in `data/dielectrics/dispersion_formulas.csv`), λ in nm.
fn sellmeier(terms: [(f64, f64); 3], nm: f64) -> f64 {
    let squared = (nm * 1e-3).powi(2);
    (1.0 + terms.iter().map(|(b, c)| b * squared / (squared - c)).sum::<f64>()).sqrt()
}

fn n_bk7(nm: f64) -> f64 {
    sellmeier([(1.03961212, 0.00600069867), (0.231792344, 0.0200179144), (1.01046945, 103.560653)], nm)
}

fn f2(nm: f64) -> f64 {
    sellmeier([(1.34533359, 0.00997743871), (0.209073176, 0.0470450767), (0.937357162, 111.886764)], nm)
}

fn n_sf66(nm: f64) -> f64 {
    sellmeier([(2.0245976, 0.0147053225), (0.470187196, 0.0692998276), (2.59970433, 161.817601)], nm)
}

fn glass(name: &str) -> String {
    format!(
        r#"<bsdf type="dielectric"><spectrum name="int_ior" type="measured"><string name="name" value="{name}"/></spectrum>
           <float name="ext_ior" value="1"/></bsdf>"#
    )
}

fn sphere(centre: f64, radius: f64) -> String {
    format!(
        r#"<shape type="sphere"><point name="center" x="0" y="0" z="{centre}"/><float name="radius" value="{radius}"/></shape>"#
    )
}

/// A cylinder of radius 10.
fn rim(from: f64, to: f64) -> String {
    format!(
        r#"<shape type="cone"><point name="p0" value="0, 0, {from}"/><point name="p1" value="0, 0, {to}"/>
           <float name="radius" value="10"/><float name="radius1" value="10"/></shape>"#
    )
}

/// Sends a ray through a number of faces, all of which transmit it, and says where it met the first.
fn through(scene: &Scene, faces: usize, mut ray: Ray, nm: f64) -> (Ray, Vec3) {
    let wavelengths = Wavelengths { nm: [nm], density: Sampled([1.0]) };
    let mut media = scene.media_at_sensor(&ray, 0.0);
    let mut first = Vec3::NAN;
    for face in 0..faces {
        let hit = scene.intersect(&ray, 0.0, RayKind::Scattered, &mut media, |_, _| {}).unwrap();
        if face == 0 {
            first = hit.point.position;
        }
        let shading = scene.shade(&hit, -ray.direction, &media, &wavelengths, 0.0);
        let scatter = shading.sample(1.0f64.next_down(), [0.5; 2]).unwrap();
        assert!(scatter.transmitted);
        scene.pass_through(&hit, scatter.toward_light, &mut media);
        ray = hit.point.ray(scatter.toward_light);
    }
    assert!(
        scene.intersect(&ray, 0.0, RayKind::Scattered, &mut media, |_, _| {}).is_none(),
        "there is another face"
    );
    (ray, first)
}

/// Where a ray at `height` along the axis crosses it behind the lens, which has `faces` faces: how far behind
/// the first.
fn focus(scene: &Scene, faces: usize, height: f64, nm: f64) -> f64 {
    let (ray, first) = through(scene, faces, Ray::new(Vec3::new(height, 0.0, -80.0), Vec3::Z), nm);
    ray.origin.z - ray.origin.x * ray.direction.z / ray.direction.x - first.z
}

/// CAM-14: blue light is focused nearer than red by what the lensmaker's equation says of a thin lens, f = R
/// / 2(n − 1).
#[test]
fn a_lens_of_glass_focuses_colours_apart() {
    const RADIUS: f64 = 50.0;
    let scene = scene(&format!(
        r#"<shape type="intersection">{}{}{}</shape>"#,
        sphere(-49.75, RADIUS),
        sphere(49.75, RADIUS),
        glass("N-BK7")
    ));
    // From its middle.
    let focus = |nm: f64| focus(&scene, 2, 0.01, nm) - 0.25;
    let thin = |nm: f64| 0.5 * RADIUS / (n_bk7(nm) - 1.0);
    let (found, expected) = (focus(C) - focus(F), thin(C) - thin(F));
    println!("{found} apart, expected {expected}; at d {} and {}", focus(D), thin(D));
    assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected}");
    assert!((focus(D) / thin(D) - 1.0).abs() < 0.01);
}

/// A doublet of focal length 107 after Fraunhofer: crown and flint cemented, with powers φ₁/V₁ + φ₂/V₂ = 0.
/// Radii of its faces, those that are hollow towards the light negative, and their places on the axis.
const RADII: [f64; 3] = [44.78, -44.78, -2000.0];
const VERTICES: [f64; 3] = [0.0, 6.0, 9.0];

/// Crown and flint are cut by one sphere, which is a face of both.
fn doublet(index_of_flint: &str) -> Scene {
    let [front, middle, back] = [0, 1, 2].map(|i| sphere(VERTICES[i] + RADII[i], RADII[i].abs()));
    scene(&format!(
        r#"<shape type="intersection">{front}{middle}{}{}</shape>
           <shape type="difference"><shape type="intersection">{}{back}</shape>{middle}{index_of_flint}</shape>"#,
        rim(-1.0, 12.0),
        glass("N-BK7"),
        rim(2.0, 12.0)
    ))
}

/// The same by paraxial optics: n′u′ = nu − h (n′ − n)/R at each face and h′ = h + u d between them.
fn paraxial(indices: [f64; 4]) -> f64 {
    let (mut height, mut slope) = (1.0, 0.0);
    for face in 0..3 {
        let [before, after] = [indices[face], indices[face + 1]];
        slope = (before * slope - height * (after - before) / RADII[face]) / after;
        if face < 2 {
            height += slope * (VERTICES[face + 1] - VERTICES[face]);
        }
    }
    VERTICES[2] - height / slope
}

/// The cemented face is one face, and single rays near the axis come together where paraxial optics says, for
/// each line; C and F a hundred times nearer to one another than without the flint.
#[test]
fn a_cemented_doublet_brings_colours_together() {
    let scene = doublet(&glass("F2"));
    let expected = |nm: f64| paraxial([1.0, n_bk7(nm), f2(nm), 1.0]);
    for nm in [F, D, C] {
        // The index is looked up in a table that is good to 10⁻⁷; spherical aberration at this height is far
        // below.
        let found = focus(&scene, 3, 1e-3, nm);
        println!("{nm}: {found}, expected {}", expected(nm));
        assert!((found / expected(nm) - 1.0).abs() < 1e-6, "{nm}: {found} {}", expected(nm));
    }
    let apart = (focus(&scene, 3, 1e-3, C) - focus(&scene, 3, 1e-3, F)).abs();
    // A single lens of crown has f/V between these lines.
    let single = expected(D) * (n_bk7(F) - n_bk7(C)) / (n_bk7(D) - 1.0);
    println!("C and F {apart} apart, by a single lens {single}");
    assert!(apart < 0.01 * single, "{apart} {single}");
    // Flint of another melt is noticed.
    let flint = r#"<bsdf type="dielectric"><float name="int_ior" value="1.6201"/><float name="ext_ior" value="1"/></bsdf>"#;
    let planted = focus(&doublet(flint), 3, 1e-3, D);
    assert!((planted / expected(D) - 1.0).abs() > 1e-5, "{planted}");
}

/// A prism is a box less a turned box. It deviates a ray by i + asin(n sin(A − asin(sin i / n))) − A.
#[test]
fn a_prism_cut_from_a_block_parts_colours() {
    let (apex, incidence) = (55f64.to_radians(), 65f64.to_radians());
    // The second face goes through the edge x = -2.5, z = -1; across it the cutter reaches 20 far.
    let (x, z) = (-2.5 - 10.0 * apex.sin(), -1.0 + 10.0 * apex.cos());
    let scene = scene(&format!(
        r#"<shape type="difference">{}
           <shape type="cube"><transform name="to_world"><scale x="2.5" y="2" z="1"/></transform></shape>
           <shape type="cube"><transform name="to_world">
               <scale value="10"/><rotate y="1" angle="-55"/><translate x="{x}" z="{z}"/></transform></shape></shape>"#,
        glass("N-SF66")
    ));
    let toward = Vec3::new(-incidence.sin(), 0.0, incidence.cos());
    let from = Vec3::new(-1.5, 0.0, -1.0) - toward * 4.0;
    for nm in [F, D, C] {
        let n = n_sf66(nm);
        let inside = apex - (incidence.sin() / n).asin();
        let expected = incidence + (n * inside.sin()).asin() - apex;
        let (ray, _) = through(&scene, 2, Ray::new(from, toward), nm);
        let found = ray.direction.angle_between(toward);
        println!("{nm}: {found}, expected {expected}");
        // As good as the table of the index.
        assert!((found - expected).abs() < 1e-6, "{nm}: {found} {expected}");
    }
}
