//! Rough surfaces that become smooth.

use super::{assert_agree, compiled, expose, film, pixels, radiance, smallest_p};
use abbe::film::Film;
use abbe::stats::Estimate;
use statrs::function::erf::erf;

/// A lit chart in a mirror or behind a pane, seen at a slant.
fn chart(material: &str, behind: bool, seed: u64) -> Film {
    let turned = if behind { 0.0 } else { 180.0 };
    let scene = compiled(&format!(
        r#"<integrator type="path"><integer name="max_depth" value="6"/></integrator>
           <sensor type="perspective"><float name="fov" value="30"/>
           <transform name="to_world"><lookat origin="0, 1, 3" target="0, 0, 0" up="0, 1, 0"/></transform>{}</sensor>
           <shape type="cube"><transform name="to_world"><scale x="1.5" y="1.5" z="0.05"/></transform>{material}</shape>
           <shape type="rectangle"><transform name="to_world"><scale value="12"/><translate z="-4"/><rotate y="1" angle="{turned}"/></transform>
           <bsdf type="diffuse"><spectrum name="reflectance" value="0"/></bsdf>
           <emitter type="area"><texture name="radiance" type="checkerboard"><float name="color0" value="0.2"/>
           <float name="color1" value="1"/><transform name="to_uv"><scale x="16" y="16"/></transform></texture></emitter></shape>"#,
        film(12, 12),
    ));
    expose(&scene, 16, 40, seed)
}

/// What is the same to within the noise at 1e-4 and 1e-3, and clearly not at 0.3.
fn converges(smooth: &str, rough: impl Fn(f64) -> String, behind: bool) {
    let reference = chart(smooth, behind, 1);
    let mut apart = Vec::new();
    for (alpha, seed) in [(1e-4, 2), (1e-3, 3), (1e-2, 4), (0.3, 5)] {
        let film = chart(&rough(alpha), behind, seed);
        let pairs = || pixels(&film).map(|(x, y)| (radiance(&film, x, y), radiance(&reference, x, y)));
        // The mean square beyond that of the noise.
        let square = |(a, b): (Estimate, Estimate)| (a.mean - b.mean).powi(2) - a.variance - b.variance;
        apart.push(pairs().map(square).sum::<f64>() / 144.0);
        if alpha <= 1e-3 {
            assert_agree(&format!("{alpha}"), pairs());
        } else {
            println!("{alpha}: p {:.4}, mean square {:e}", smallest_p(pairs()), apart[apart.len() - 1]);
        }
    }
    assert!(apart[3] > 1e-3 && apart[2] < 0.1 * apart[3], "{apart:?}");
}

/// A rough material of this plugin and distribution, by its roughness.
fn rough(plugin: &str, distribution: &str) -> impl Fn(f64) -> String {
    move |alpha| {
        format!(
            r#"<bsdf type="{plugin}"><float name="alpha" value="{alpha}"/>
               <string name="distribution" value="{distribution}"/></bsdf>"#
        )
    }
}

#[test]
fn gloss_becomes_a_mirror() {
    for distribution in ["beckmann", "ggx"] {
        converges(r#"<bsdf type="conductor"/>"#, rough("roughconductor", distribution), false);
    }
}

#[test]
fn frosted_glass_becomes_clear() {
    for distribution in ["beckmann", "ggx"] {
        converges(r#"<bsdf type="dielectric"/>"#, rough("roughdielectric", distribution), true);
    }
}

/// At the roughness of 1e-2 the difference is known: facets tilted by a slope s send light off by 2s.
/// Beckmann's slopes along one axis are normal with variance α²/2, and so an edge at a distance d is seen as
/// ½ + ½ erf(x / (2 α d)).
#[test]
fn an_edge_in_a_slightly_rough_mirror_is_an_error_function() {
    const ALPHA: f64 = 1e-2;
    const DISTANCE: f64 = 2.0;
    const WIDTH: u32 = 40;
    const HALF: f64 = 0.08;
    // From behind the light, which is seen from its front only.
    let scene = compiled(&format!(
        r#"<integrator type="path"><integer name="max_depth" value="2"/></integrator>
           <sensor type="orthographic"><float name="far_clip" value="5"/><transform name="to_world">
           <scale x="{HALF}" y="{HALF}"/>
           <lookat origin="0, 0, {}" target="0, 0, 0" up="0, 1, 0"/></transform>{}</sensor>
           <shape type="rectangle"><bsdf type="roughconductor"><float name="alpha" value="{ALPHA}"/>
           <string name="material" value="none"/></bsdf></shape>
           <shape type="rectangle"><transform name="to_world"><scale value="5"/><rotate x="1" angle="180"/>
           <translate x="5" z="{DISTANCE}"/></transform>
           <emitter type="area"><spectrum name="radiance" value="1"/></emitter></shape>"#,
        DISTANCE - 0.1,
        film(WIDTH, 1),
    ));
    let film = expose(&scene, 16, 1024, 6);
    let pixel = 2.0 * HALF / f64::from(WIDTH);
    // The integral of the profile, for the mean over a pixel.
    let profile = |x: f64| 0.5 + 0.5 * erf(x / (2.0 * ALPHA * DISTANCE));
    let expected = |i: u32| {
        let at = |k: u32| profile((f64::from(i) + (f64::from(k) + 0.5) / 16.0) * pixel - HALF);
        (0..16).map(at).sum::<f64>() / 16.0
    };
    assert_agree("edge", (0..WIDTH).map(|i| (radiance(&film, i, 0), Estimate::exact(expected(i)))));
}
