//! Media that send out light, layers, and particles that scatter by wavelength, against closed forms: bin by
//! bin, and for every number of wavelengths per path.

use crate::common::{ALL_COUNTS, expose, made, mean_over_pixels, settings, stress};
use crate::media::{RANGE, assert_bins, beam, scene};
use abbe::phase::mie::{Optics, Population, Sizes};
use abbe::render::WavelengthCount;
use abbe::sampling::quadrature::gauss_legendre;
use abbe::scene::{CompileOptions, Scene};
use abbe::spectrum::{Spectrum, blackbody_radiance};
use abbe::stats::sidak;
use statrs::distribution::{ContinuousCDF, Normal};
use std::f64::consts::PI;

/// A slab 1 thick across the ray, with something in its medium.
fn slab(medium: &str) -> String {
    slab_to_depth(-1, medium)
}

/// It is so wide that light which grazes it does not come in by its sides.
fn slab_to_depth(max_depth: i32, medium: &str) -> String {
    format!(
        r#"<integrator type="volpath"><integer name="max_depth" value="{max_depth}"/></integrator>{}<shape type="cube"><bsdf type="null"/>
           <transform name="to_world"><scale x="500" y="500" z="0.5"/></transform>{medium}</shape>"#,
        beam(r#"origin="0.1, 0.2, 5" target="0.1, 0.2, 0" up="0, 1, 0""#, "")
    )
}

/// 0 at 400 nm, where nothing is absorbed.
const SIGMA: &str =
    r#"<spectrum name="sigma_t" value="400:0, 500:2, 700:0.5"/><float name="albedo" value="0"/>"#;

fn sigma(nm: f64) -> f64 {
    if nm < 500.0 { 2.0 * (nm - 400.0) / 100.0 } else { 2.0 - 1.5 * (nm - 500.0) / 200.0 }
}

/// What is sent out is absorbed again on the way: ε (1 − e^−σd) / σ.
#[test]
fn a_slab_that_glows_and_absorbs() {
    let medium = format!(
        r#"<medium name="interior" type="homogeneous">{SIGMA}<spectrum name="emission" value="400:1, 700:3"/></medium>"#
    );
    let expected = |nm: f64| {
        let emission = 1.0 + 2.0 * (nm - 400.0) / 300.0;
        emission * -(-sigma(nm)).exp_m1() / sigma(nm)
    };
    assert_bins("glow", &scene(&slab(&medium)), 768, 5e-3, expected);
}

/// A slab of one temperature sends out the part of a black body's light that it would have absorbed.
#[test]
fn a_hot_slab() {
    let medium = format!(
        r#"<medium name="interior" type="homogeneous">{SIGMA}<float name="temperature" value="3000"/></medium>"#
    );
    let expected = |nm: f64| blackbody_radiance(nm, 3000.0) * -(-sigma(nm)).exp_m1();
    assert_bins("hot slab", &scene(&slab(&medium)), 1024, 1e-2, expected);
}

/// What is as hot as everything around it cannot be told from that, whatever it scatters and wherever it is
/// thick.
#[test]
fn a_medium_as_hot_as_its_surroundings_vanishes() {
    let plain = r#"<spectrum name="sigma_t" value="400:0.3, 500:3, 700:1"/><spectrum name="albedo" value="400:0.9, 700:0.2"/>"#;
    let drops = r#"<phase type="mie"><float name="radius" value="0.4"/><float name="k" value="0.05"/>
                   <float name="fraction" value="1e-6"/></phase><phase type="air"><float name="amount" value="1e4"/></phase>"#;
    let height = |radius: &str| {
        format!(
            r#"<volume name="density" type="exponential"><float name="scale_height" value="0.4"/>{radius}
               <transform name="to_world"><translate z="-0.6"/></transform></volume>"#
        )
    };
    let (flat, round) = (height(""), height(r#"<float name="radius" value="0.3"/>"#));
    let flakes = r#"<phase type="sggx"><string name="S" value="1, 0.2, 0.5, 0.1, 0, 0.2"/></phase>"#;
    let cases = [
        ("homogeneous", "homogeneous", format!("{plain}<phase type=\"hg\"/>")),
        ("flakes", "homogeneous", format!("{plain}{flakes}")),
        ("layered", "heterogeneous", format!("{plain}{flat}")),
        ("drops above a ball", "suspension", format!("{drops}{round}")),
    ];
    for (name, plugin, content) in cases {
        let content = format!(
            r#"<integrator type="volpath"/>{}
               <emitter type="constant"><spectrum name="radiance" type="blackbody"><float name="temperature" value="3000"/></spectrum></emitter>
               <shape type="sphere"><bsdf type="null"/><medium name="interior" type="{plugin}">{content}
               <float name="temperature" value="3000"/></medium></shape>"#,
            beam(r#"origin="0.3, 0.1, 5" target="0.3, 0.1, 0" up="0, 1, 0""#, "")
        );
        assert_bins(name, &scene(&content), 512, 2e-2, |nm| blackbody_radiance(nm, 3000.0));
    }
}

/// Spheres of which each wavelength is scattered otherwise, and that absorb nothing, cannot be told from the
/// sky. What a companion carries has to follow its own phase function at every scattering.
#[test]
fn spheres_that_absorb_nothing_vanish_in_a_furnace() {
    let small = r#"<phase type="mie"><float name="radius" value="0.06"/><float name="int_ior" value="1.5"/>
                   <float name="ext_ior" value="1"/><float name="fraction" value="4e-6"/></phase>"#;
    let large = r#"<phase type="mie"><float name="radius" value="0.5"/><float name="int_ior" value="1.5"/>
                   <float name="ext_ior" value="1"/><float name="fraction" value="4e-7"/></phase>"#;
    let content = format!(
        r#"<integrator type="volpath"/>{}
           <emitter type="constant"><spectrum name="radiance" value="1"/></emitter>
           <shape type="sphere"><bsdf type="null"/><medium name="interior" type="suspension">{small}{large}</medium></shape>"#,
        beam(r#"origin="0.3, 0.1, 5" target="0.3, 0.1, 0" up="0, 1, 0""#, "")
    );
    assert_bins("spheres in a furnace", &scene(&content), 512, 1e-2, |_| 1.0);
}

/// A density that is a pattern in space is that of its cells: what a slab lets through is known from their
/// values.
#[test]
fn a_pattern_in_space_is_a_density() {
    // Waves along z with a period of 1, from 0 to 2, on four cells: 0.2929, 1.7071, 1.7071, 0.2929.
    let density = r#"<volume name="density" type="texturevolume">
        <texture name="texture" type="bands"><float name="color0" value="0"/><float name="color1" value="2"/><boolean name="interpolate" value="true"/>
        <transform name="to_world"><rotate y="1" angle="-90"/></transform></texture>
        <integer name="resolution" value="4"/>
        <transform name="to_world"><translate x="-0.5" y="-0.5"/><scale x="10" y="10"/></transform></volume>"#;
    let content = format!(
        r#"<integrator type="volpath"><integer name="max_depth" value="1"/></integrator>{}
           <shape type="cube"><bsdf type="null"/><transform name="to_world"><scale x="5" y="5" z="0.5"/><translate z="0.5"/></transform>
           <medium name="interior" type="heterogeneous"><spectrum name="sigma_t" value="400:0.5, 700:3"/>
           <float name="albedo" value="0"/>{density}</medium></shape>
           <emitter type="constant"><spectrum name="radiance" value="2"/></emitter>"#,
        beam(r#"origin="0.1, 0.2, 5" target="0.1, 0.2, 0" up="0, 1, 0""#, "")
    );
    // Linear between the centres of cells and the same beyond: the mean of the four.
    let expected = |nm: f64| 2.0 * (-(0.5 + 2.5 * (nm - 400.0) / 300.0)).exp();
    assert_bins("bands", &scene(&content), 256, 1e-2, expected);
}

/// A slab that scatters alike in all directions and absorbs nothing lets a fraction of diffuse light through.
/// Thin ones: Heaslet and Warming, "Radiative transport and wall temperature slip in an absorbing planar
/// medium", International Journal of Heat and Mass Transfer 8, 1965, table 1 (the flux between two black
/// walls is the same function; van de Hulst, *Multiple Light Scattering*, 1980, has it as UTU). Thick ones:
/// (4/3) / (τ + 2 · 0.710446). Sees a difference of five times 2 %.
#[test]
fn diffuse_light_through_a_slab() {
    let cases = [
        (0.5, 0.7040, 256),
        (1.0, 0.5532, 256),
        (2.0, 0.3900, 512),
        (3.0, 0.3016, 768),
        (20.0, 4.0 / 3.0 / 21.420_892, 6144),
    ];
    let tail = sidak(0.01, cases.len()) / 2.0;
    let bound = Normal::standard().inverse_cdf(1.0 - tail);
    let through = |depth: f64| {
        let content = format!(
            r#"<integrator type="volpath"/>
               <shape type="rectangle"><transform name="to_world"><scale value="0.5"/><rotate x="1" angle="180"/><translate z="0.01"/></transform>
               <bsdf type="diffuse"><float name="reflectance" value="0"/></bsdf>
               <sensor type="irradiancemeter"><film type="hdrfilm"><integer name="width" value="4"/><integer name="height" value="4"/>
               <rfilter type="box"/></film></sensor></shape>
               <shape type="rectangle"><transform name="to_world"><scale value="900"/><translate z="-1.01"/></transform>
               <bsdf type="diffuse"><float name="reflectance" value="0"/></bsdf>
               <emitter type="area"><spectrum name="radiance" value="{}"/></emitter></shape>
               <shape type="cube"><bsdf type="null"/><transform name="to_world"><scale x="800" y="800" z="0.5"/><translate z="-0.5"/></transform>
               <medium name="interior" type="homogeneous"><float name="sigma_t" value="{depth}"/><float name="albedo" value="1"/></medium></shape>"#,
            1.0 / PI
        );
        made(&content, &CompileOptions::default())
    };
    let luminance = |scene: &Scene, samples: u32, count: WavelengthCount| {
        let film = expose(scene, &settings(samples, count, 7));
        mean_over_pixels(&film, |x, y| film.combined(x, y, [0.0, 1.0, 0.0]))
    };
    // The medium is grey, so each depth has one number of wavelengths.
    let clear = through(0.0);
    let clear = ALL_COUNTS.map(|count| (count, luminance(&clear, 2048, count)));
    for ((depth, expected, samples), (count, (whole, error_of_whole))) in
        cases.into_iter().zip(clear.into_iter().cycle())
    {
        assert!(error_of_whole < 1e-3 * whole, "{whole} ± {error_of_whole}");
        let (mean, error) = luminance(&through(depth), samples * stress::count(1, 16), count);
        let (mean, error) = (mean / whole, error.hypot(error_of_whole) / whole);
        // The table has four digits.
        let z = ((mean - expected).abs() - 5e-5).max(0.0) / error;
        println!("τ = {depth}, {count}: {mean:.5} ± {error:.1e}, expected {expected:.5}");
        assert!(
            error < 0.02 * expected && z < bound,
            "τ = {depth}, {count}: {mean} ± {error} is not {expected}"
        );
    }
}

/// Small spheres scatter blue light back, large ones all light ahead. What a slab of both scatters once from
/// a white sheet behind the camera is the integral of the phase function over the half of all directions, and
/// over the depth.
#[test]
fn spheres_scatter_each_wavelength_by_itself() {
    const KINDS: [(f64, f64); 2] = [(0.04, 1.5e-6), (0.8, 3e-7)];
    let phases = KINDS.map(|(radius, fraction)| {
        format!(
            r#"<phase type="mie"><float name="radius" value="{radius}"/><float name="int_ior" value="1.5"/>
               <float name="ext_ior" value="1"/><float name="fraction" value="{fraction}"/></phase>"#
        )
    });
    let medium = format!(r#"<medium name="interior" type="suspension">{}</medium>"#, phases.concat());
    let content = slab_to_depth(2, &medium)
        + r#"<shape type="rectangle"><transform name="to_world"><scale value="20000"/><rotate x="1" angle="180"/>
             <translate z="20"/></transform><bsdf type="diffuse"><float name="reflectance" value="0"/></bsdf>
             <emitter type="area"><spectrum name="radiance" value="1"/></emitter></shape>"#;
    let optics = KINDS.map(|(radius, _)| {
        let index = [Spectrum::Constant(1.5), Spectrum::ZERO];
        let population = Population { sizes: Sizes::One(radius), index, host: Spectrum::Constant(1.0) };
        population.optics(RANGE).unwrap()
    });
    let sigma = |kind: usize, nm: f64| optics[kind].extinction.at(nm) * 1e6 * KINDS[kind].1;
    let density = |optics: &Optics, cos: f64, nm: f64| optics.phase.density(cos, &[nm])[0];
    let expected = |nm: f64| -> f64 {
        let all = sigma(0, nm) + sigma(1, nm);
        gauss_legendre(200)
            .map(|(x, weight)| {
                let mu = 0.5 + 0.5 * x;
                let phase: f64 =
                    (0..2).map(|kind| sigma(kind, nm) / all * density(&optics[kind], -mu, nm)).sum();
                0.5 * weight * phase * -(-all * (1.0 + 1.0 / mu)).exp_m1() * mu / (1.0 + mu)
            })
            .sum()
    };
    println!("blue {:.4}, red {:.4}", expected(410.0), expected(690.0));
    assert_bins("spheres", &scene(&content), 2048, 2e-2, expected);
}
