//! The worked examples of the source texts, their values recomputed and, where they were misprinted,
//! corrected: A. Glassner (ed.), *An Introduction to Ray Tracing*, 1989, by its chapters; G. Wyvill,
//! *Practical Ray Tracing*, parts 1 and 2; G. Zachmann's slides *Introduction to Ray Tracing and
//! Physically-Based Rendering*.
//!
//! | example | where it is tested |
//! | --- | --- |
//! | N1 sphere, N2 its inverse mapping, N3 plane, N4 polygon, N5 quadrilateral, N6 box, N7 quadric (ch. 2) | `src/shape/tests/worked.rs`: `a_sphere`, `where_on_a_sphere`, `a_plane`, `a_polygon`, `a_quadrilateral`, `a_box`, `an_ellipsoid` and `a_quadric` |
//! | N8 to N10 Fresnel and refraction | `n08` to `n10` in `optics.rs`; to 60 digits in `src/bsdf/fresnel.rs` |
//! | N11 thin lens | `n11` in `optics.rs` |
//! | N12 absorbing slab | `n12` in `optics.rs` |
//! | N13, N14 jitter in space and in time | `n13`, `n14` in `samples.rs`; the noise too in `tests/statistical/sampling/jitter.rs` |
//! | N15 Heckbert's business card | `n15` in `card.rs` |
//! | N16 weight of a ray in the tree, N17 mean of a pixel | `n16` in `optics.rs`, `n17` in `samples.rs` |
//! | N18 wheels that seem to turn backwards | `n18` in `places.rs` |
//! | N20 weights of the rays of a divided pixel | `n20` in `samples.rs`: by the film, which divides by the weights |
//! | N21 odds of a pixel that is all wrong, N22 aliases of a comb | `n21`, `n22` in `samples.rs` |
//! | N24 direction cube | `n24` in `places.rs`: with a cube and its faces' solid angle, for nothing here sorts directions in this way |
//! | N25 the time of a machine that tests every polygon | `n25` in `places.rs`: with the tests that the tree leaves |
//! | N26 formulas whose operations are counted | `n26` in `optics.rs`: those of refraction, whose results are those of this program |
//!
//! N19 (the visible range) and N23 (terms of an implicit surface) are sums that say nothing of this program.

mod card;
mod optics;
mod places;
mod samples;

use crate::common::{bins, expose, made, mean_over_pixels, settings};
use abbe::bsdf::{Bsdf, Dielectric};
use abbe::geometry::{Frame, Vec3};
use abbe::render::WavelengthCount;
use abbe::sampling::SamplerKind;
use abbe::scene::CompileOptions;
use abbe::spectrum::Sampled;
use abbe::units::WavelengthRange;

fn assert_near(value: f64, expected: f64, tolerance: f64) {
    assert!((value - expected).abs() <= tolerance, "{value} is not {expected}");
}

fn assert_near_vector(value: Vec3, expected: [f64; 3], tolerance: f64) {
    let off = (value - Vec3::from_array(expected)).abs().max_element();
    assert!(off <= tolerance, "{value} is not {expected:?}");
}

/// Where a ray along `direction` goes on from a surface with a normal on its own side: reflected, or
/// refracted into what has `eta` times the index. `None` with total reflection.
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

/// The mean radiance seen through `shapes` in front of a lamp of radiance 1, looking down along z, with its
/// standard error.
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
