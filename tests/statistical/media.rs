//! Media that scatter, against closed forms: bin by bin, and for every number of wavelengths per path.

use crate::common::{ALL_COUNTS, bins, expose, made, mean_over_pixels, settings, stress};
use abbe::film::Film;
use abbe::render::{Settings, WavelengthCount};
use abbe::sampling::SamplerKind;
use abbe::sampling::quadrature::gauss_legendre;
use abbe::scene::{CompileOptions, Scene};
use abbe::stats::sidak;
use abbe::units::WavelengthRange;
use statrs::distribution::{ContinuousCDF, Normal};
use std::f64::consts::{FRAC_PI_2, PI};

pub const BINS: usize = 6;
pub const RANGE: WavelengthRange = WavelengthRange { min: 400.0, max: 700.0 };

pub fn scene(content: &str) -> Scene {
    made(content, &CompileOptions { range: RANGE, spectral: true, ..CompileOptions::default() })
}

/// A camera whose pixels all look along one ray, with something in it.
pub fn beam(lookat: &str, inside: &str) -> String {
    format!(
        r#"<sensor type="perspective"><float name="fov" value="1e-5"/><float name="near_clip" value="1e-9"/>
           <transform name="to_world"><lookat {lookat}/></transform>
           <film type="hdrfilm"><integer name="width" value="6"/><integer name="height" value="6"/>
           <rfilter type="box"/></film>{inside}</sensor>"#
    )
}

pub fn measure(scene: &Scene, samples: u32, count: WavelengthCount) -> Film {
    let settings = settings(samples, count, 5 + count.get() as u64);
    expose(scene, &Settings { bins: bins(RANGE, BINS), ..settings })
}

/// The mean of a function of wavelength over each bin. Tables of it may have a corner every 2.5 nm.
pub fn over_bins(f: impl Fn(f64) -> f64) -> Vec<f64> {
    let width = RANGE.width() / BINS as f64;
    let mean = |bin: usize| {
        let middle = RANGE.min + width * (bin as f64 + 0.5);
        gauss_legendre(100).map(|(x, weight)| 0.5 * weight * f(middle + 0.5 * width * x)).sum()
    };
    (0..BINS).map(mean).collect()
}

/// Every bin, with a probability of 1 % that any differs by chance. The largest standard error may be
/// `precision` of what is expected: a difference of five times that is seen. `ABBE_STRESS=full` sees a
/// quarter of it.
#[track_caller]
pub fn assert_bins(name: &str, scene: &Scene, samples: u32, precision: f64, expected: impl Fn(f64) -> f64) {
    let expected = over_bins(expected);
    let tail = sidak(0.01, BINS * ALL_COUNTS.len()) / 2.0;
    let bound = Normal::standard().inverse_cdf(1.0 - tail);
    for count in ALL_COUNTS {
        let film = measure(scene, samples * stress::count(1, 16), count);
        for (bin, expected) in expected.iter().enumerate() {
            let (mean, error) = mean_over_pixels(&film, |x, y| film.bin(x, y, bin));
            let z = (mean - expected) / error.max(1e-9 * expected);
            println!("{name}, {count}, bin {bin}: {mean:.6} ± {error:.1e}, expected {expected:.6}, {z:+.2}");
            assert!(error <= precision * expected, "{name}, {count}, bin {bin}: the error is {error}");
            assert!(z.abs() < bound, "{name}, {count}, bin {bin}: {mean} ± {error} is not {expected}");
        }
    }
}

const WHITE_SKY: &str = r#"<emitter type="constant"><spectrum name="radiance" value="1"/></emitter>"#;

/// What absorbs nothing cannot be told from the sky: at any density, in a boundary or none, where it has none
/// at some wavelengths.
#[test]
fn a_medium_of_albedo_1_vanishes_in_a_furnace() {
    let null = r#"<bsdf type="null"/>"#;
    let glass = r#"<bsdf type="dielectric"><float name="int_ior" value="1.33"/></bsdf>"#;
    let cases = [
        ("thin", "1e-9", null, 1024, 2e-3),
        ("even", "1", null, 1024, 2e-3),
        ("chromatic", "400:0.1, 500:10, 700:1", null, 2048, 5e-3),
        ("nothing in some bins", "400:0, 500:0, 510:5, 600:5, 610:0, 700:0", null, 512, 5e-3),
        ("in glass", "400:0.3, 700:3", glass, 1536, 5e-3),
        // Thicker ones hold some of their light in walks so long that few samples end them.
        ("thick", "30", null, 1024, 2e-3),
    ];
    for (name, sigma_t, bsdf, samples, precision) in cases {
        let content = format!(
            r#"<integrator type="volpath"/>{}{WHITE_SKY}<shape type="sphere">{bsdf}
               <medium name="interior" type="homogeneous"><spectrum name="sigma_t" value="{sigma_t}"/>
               <float name="albedo" value="1"/><phase type="hg"><float name="g" value="0.4"/></phase></medium></shape>"#,
            beam(r#"origin="0.3, 0.1, 5" target="0.3, 0.1, 0" up="0, 1, 0""#, "")
        );
        assert_bins(name, &scene(&content), samples, precision, |_| 1.0);
    }
}

/// Whatever the albedo, over all densities that numbers can say: no value that is none, and no energy that
/// was not there.
#[test]
fn no_density_makes_what_is_no_number() {
    for exponent in (-9..=9).step_by(3) {
        let opposite = -exponent;
        for albedo in ["0.5", "400:0, 550:0, 551:1, 700:1"] {
            let content = format!(
                r#"<integrator type="volpath"/>{}{WHITE_SKY}<shape type="sphere"><bsdf type="null"/>
                   <medium name="interior" type="homogeneous">
                   <spectrum name="sigma_t" value="400:1e{exponent}, 550:0, 560:1, 700:1e{opposite}"/>
                   <spectrum name="albedo" value="{albedo}"/><phase type="rayleigh"/></medium></shape>
                   <shape type="sphere"><float name="radius" value="0.1"/>
                   <emitter type="area"><spectrum name="radiance" value="1"/></emitter></shape>"#,
                beam(r#"origin="0.3, 0.1, 5" target="0.3, 0.1, 0" up="0, 1, 0""#, "")
            );
            let scene = scene(&content);
            for count in ALL_COUNTS {
                let film = measure(&scene, stress::count(32, 256), count);
                for bin in 0..BINS {
                    let (mean, error) = mean_over_pixels(&film, |x, y| film.bin(x, y, bin));
                    let within = mean >= 0.0 && mean <= 1.0 + 6.0 * error + 1e-9;
                    assert!(within, "1e{exponent}, {albedo}, {count}, bin {bin}: {mean} ± {error}");
                }
            }
        }
    }
}

fn henyey_greenstein(g: f64, cos: f64) -> f64 {
    (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cos).powf(1.5))
}

/// The integral along the ray of light that is scattered once is known. The lamp stands ahead, beside the
/// ray.
#[test]
fn airlight_of_a_point_light() {
    let [ahead, beside, g, albedo]: [f64; 4] = [2.0, 1.0, 0.5, 0.8];
    let sigma_t = |nm: f64| 0.1 + 0.9 * (nm - 400.0) / 300.0;
    let content = format!(
        r#"<integrator type="volpath"><integer name="max_depth" value="2"/></integrator>{}
           <emitter type="point"><point name="position" x="{beside}" y="0" z="{ahead}"/>
           <spectrum name="intensity" value="3"/></emitter>"#,
        beam(
            r#"origin="0, 0, 0" target="0, 0, 1" up="0, 1, 0""#,
            &format!(
                r#"<medium type="homogeneous"><spectrum name="sigma_t" value="400:0.1, 700:1"/>
                   <float name="albedo" value="{albedo}"/><phase type="hg"><float name="g" value="{g}"/></phase></medium>"#
            )
        )
    );
    // Over the angle at which the lamp is seen from the ray, which makes the integrand smooth (Sun et al., "A
    // practical analytic single scattering model for real time rendering", 2005).
    let expected = |nm: f64| {
        let sigma = sigma_t(nm);
        let (low, high) = ((-ahead / beside).atan(), FRAC_PI_2);
        let at = |angle: f64| {
            let (t, distance) = (ahead + beside * angle.tan(), beside / angle.cos());
            // Straight ahead where the lamp is far behind the place: from where its light comes, toward the
            // camera.
            let cos = -angle.sin();
            albedo * sigma * 3.0 * henyey_greenstein(g, cos) * (-sigma * (t + distance)).exp() / beside
        };
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        gauss_legendre(96).map(|(x, weight)| weight * half * at(middle + half * x)).sum()
    };
    assert_bins("airlight", &scene(&content), 2048, 1e-2, expected);
}

/// A lamp behind a slab is weakened as Beer and Lambert say where nothing that is scattered counts.
#[test]
fn transmittance_of_a_slab() {
    let content = format!(
        r#"<integrator type="volpath"><integer name="max_depth" value="1"/></integrator>{}
           <shape type="cube"><bsdf type="null"/><transform name="to_world"><scale x="5" y="5" z="0.5"/></transform>
           <medium name="interior" type="homogeneous"><spectrum name="sigma_t" value="400:0, 500:2, 700:0.5"/></medium></shape>
           <shape type="rectangle"><transform name="to_world"><scale value="5"/><translate z="-3"/></transform>
           <emitter type="area"><spectrum name="radiance" value="2"/></emitter></shape>"#,
        beam(r#"origin="0.1, 0.2, 5" target="0.1, 0.2, 0" up="0, 1, 0""#, "")
    );
    let expected = |nm: f64| {
        let sigma = if nm < 500.0 { 2.0 * (nm - 400.0) / 100.0 } else { 2.0 - 1.5 * (nm - 500.0) / 200.0 };
        2.0 * (-sigma).exp()
    };
    assert_bins("slab", &scene(&content), 4096, 2e-2, expected);
}

/// Chandrasekhar's H function for isotropic scattering, at the nodes of a rule over the cosine and anywhere
/// (*Radiative Transfer*, 1950, chapter V): 1 / H(μ) = √(1 − ϖ) + ϖ/2 ∫ μ′ H(μ′) / (μ + μ′) dμ′.
struct H {
    nodes: Vec<(f64, f64)>,
    values: Vec<f64>,
    albedo: f64,
}

impl H {
    fn new(albedo: f64) -> Self {
        let nodes: Vec<(f64, f64)> =
            gauss_legendre(48).map(|(x, weight)| (0.5 + 0.5 * x, 0.5 * weight)).collect();
        let mut h = Self { values: vec![1.0; nodes.len()], nodes, albedo };
        for _ in 0..1000 {
            // Halfway, by their logarithms: values that are too large by a factor lead to ones that are too
            // small by it.
            let next = h.nodes.iter().zip(&h.values).map(|(&(mu, _), own)| (own * h.at(mu)).sqrt());
            h.values = next.collect();
        }
        h
    }

    fn at(&self, mu: f64) -> f64 {
        let pairs = self.nodes.iter().zip(&self.values);
        let integral: f64 = pairs.map(|(&(nu, weight), h)| weight * nu * h / (mu + nu)).sum();
        1.0 / ((1.0 - self.albedo).sqrt() + 0.5 * self.albedo * integral)
    }
}

/// Table XI of Chandrasekhar's book, where nothing is absorbed.
#[test]
fn the_h_function_is_that_of_the_table() {
    let h = H::new(1.0);
    for (mu, expected) in [(0.0, 1.0), (0.1, 1.2474), (0.5, 2.0128), (1.0, 2.9078)] {
        assert!((h.at(mu) - expected).abs() < 1e-4, "{mu}: {}, not {expected}", h.at(mu));
    }
}

/// What a medium that fills half of space reflects of a parallel beam.
#[test]
fn half_of_space_reflects_what_chandrasekhar_says() {
    let (sun, view) = (0.6f64, 0.8f64);
    let content = format!(
        r#"<integrator type="volpath"/>{}
           <emitter type="directional"><vector name="direction" x="{}" y="0" z="{}"/><spectrum name="irradiance" value="2"/></emitter>
           <shape type="cube"><bsdf type="null"/>
           <transform name="to_world"><scale value="400"/><translate z="-400"/></transform>
           <medium name="interior" type="homogeneous"><spectrum name="sigma_t" value="400:0.7, 700:4"/>
           <spectrum name="albedo" value="400:0.3, 700:0.96"/></medium></shape>"#,
        beam(r#"origin="0, 6, 8" target="0, 0, 0" up="0, 0, 1""#, ""),
        (1.0 - sun * sun).sqrt(),
        -sun
    );
    let expected = |nm: f64| {
        let h = H::new(0.3 + 0.66 * (nm - 400.0) / 300.0);
        h.albedo / (4.0 * PI) * 2.0 * sun / (sun + view) * h.at(sun) * h.at(view)
    };
    assert_bins("half of space", &scene(&content), 1024, 2e-2, expected);
}

/// Companions bring most of what they could bring where wavelengths fly differently far, too. The wavelengths
/// of samples are independent: where they are spread evenly, they make little of the noise.
#[test]
fn companions_reduce_noise_in_a_chromatic_medium() {
    let content = r#"<integrator type="volpath"><integer name="max_depth" value="60"/></integrator>
        <sensor type="perspective"><float name="fov" value="30"/>
        <transform name="to_world"><lookat origin="0, 1, 5" target="0, 0, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="12"/><integer name="height" value="12"/><rfilter type="box"/></film>
        </sensor>
        <emitter type="constant"><spectrum name="radiance" value="0.3"/></emitter>
        <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="90"/><translate y="2"/></transform>
        <emitter type="area"><spectrum name="radiance" value="5"/></emitter></shape>
        <shape type="cube"><bsdf type="null"/><medium name="interior" type="homogeneous">
        <spectrum name="sigma_t" value="400:0.1, 700:10"/><spectrum name="albedo" value="0.95"/></medium></shape>"#;
    let scene = scene(content);
    let noise = |count: WavelengthCount| -> f64 {
        let settings = settings(stress::count(128, 512), count, 3);
        let film = expose(&scene, &Settings { sampler: SamplerKind::Independent, ..settings });
        let pixels = (0..film.height).flat_map(|y| (0..film.width).map(move |x| (x, y)));
        let of_pixel = |(x, y): (u32, u32)| -> f64 {
            let weights = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            weights
                .iter()
                .map(|&weights| {
                    let measured = film.combined(x, y, weights);
                    (measured.error / measured.mean).powi(2)
                })
                .sum()
        };
        pixels.map(of_pixel).sum()
    };
    let [one, four, eight] = ALL_COUNTS.map(noise);
    println!("squared relative error: {one:.4}, {four:.4} with four, {eight:.4} with eight");
    assert!(four < 0.65 * one && eight < four, "{one}, {four} with four, {eight} with eight");
}
