//! What holds for every environment that is sampled.

use super::{Numbers, uniform_direction};
use crate::geometry::{Transform, Vec3};
use crate::light::sky::{Sky, SkySettings};
use crate::light::{Environment, EnvironmentMap, Texel};
use crate::sampling::warp;
use crate::spectrum::Spectrum;
use crate::stats::{Moments, sidak, welch};
use rand_pcg::Pcg64;
use std::f64::consts::PI;

const NM: f64 = 560.0;

fn turned() -> Transform {
    Transform::new(glam::DMat4::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), 1.1)).unwrap()
}

/// Grey texels of different brightness, most of them black.
fn map(width: usize, height: usize) -> Environment {
    let texels = (0..width * height)
        .map(|i| match i * 7 % 11 {
            k @ 0..4 => Texel { coefficients: [0.0, 0.001 * k as f32, -0.6], factor: (1 + k * k * k) as f32 },
            _ => Texel::BLACK,
        })
        .collect();
    let map = EnvironmentMap::new([width, height], texels, Spectrum::ONE, turned()).unwrap();
    Environment::Map(Box::new(map))
}

fn sky(sun: Vec3, sun_aperture: f64, complex_sun: bool) -> Environment {
    let settings = SkySettings {
        turbidity: 3.0,
        albedo: [0.3; 11],
        sun_direction: sun.normalize(),
        sky_scale: 1.0,
        sun_scale: 0.01,
        sun_aperture,
        complex_sun,
    };
    Environment::Sky(Box::new(Sky::new(&settings, turned()).unwrap()))
}

fn environments() -> [Environment; 4] {
    [
        map(8, 4),
        map(300, 151),
        sky(Vec3::new(0.3, 0.2, 0.8), 30.0, false),
        sky(Vec3::new(1.0, 0.0, 0.05), 8.0, true),
    ]
}

/// The light from each of 24 parts of the sphere, by sampled and by uniform directions; and the density's
/// integral is 1, over the whole and as a histogram of what was sampled.
#[test]
fn sampled_directions_follow_the_density_and_bring_all_the_light() {
    const PARTS: usize = 24;
    const SAMPLES: usize = 400_000;
    let part = |d: Vec3| {
        let octant = usize::from(d.x > 0.0) + 2 * usize::from(d.y > 0.0) + 4 * usize::from(d.z > 0.0);
        let a = d.abs();
        octant * 3 + if a.x > a.y.max(a.z) { 0 } else { 1 + usize::from(a.z > a.y) }
    };
    let least = sidak(0.01, 2 * PARTS * environments().len());
    for (number, environment) in environments().into_iter().enumerate() {
        let mut numbers = Numbers(Pcg64::new(number as u128, 1));
        let [mut light, mut plain_light, mut seen, mut density] =
            std::array::from_fn(|_| vec![Moments::default(); PARTS]);
        for _ in 0..SAMPLES {
            let (sampled, p) = environment.sample(numbers.pair()).unwrap();
            assert!((sampled.length() - 1.0).abs() < 1e-9);
            let plain = uniform_direction(numbers.pair());
            let of_sampled = environment.radiance(sampled, &[NM]).hero() / p;
            let of_plain = environment.radiance(plain, &[NM]).hero();
            assert!(of_plain == 0.0 || environment.density(plain) > 0.0, "{number}: {plain}");
            for i in 0..PARTS {
                let [in_sampled, in_plain] = [sampled, plain].map(|d| f64::from(part(d) == i));
                light[i].push(of_sampled * in_sampled);
                plain_light[i].push(of_plain * 4.0 * PI * in_plain);
                seen[i].push(in_sampled);
                density[i].push(environment.density(plain) * 4.0 * PI * in_plain);
            }
        }
        for i in 0..PARTS {
            for (what, a, b) in [("light", &light, &plain_light), ("density", &seen, &density)] {
                let test = welch(&a[i].estimate(), &b[i].estimate());
                assert!(test.p_value > least, "environment {number}, part {i}, {what}: {test}");
            }
        }
    }
}

/// The light of a sun is spread over its disc, however small that is.
#[test]
fn suns_of_all_sizes_bring_the_same_light() {
    let light = |aperture: f64| {
        let settings = SkySettings {
            turbidity: 3.0,
            albedo: [0.3; 11],
            sun_direction: Vec3::new(0.3, 0.2, 0.8).normalize(),
            sky_scale: 0.01,
            sun_scale: 1.0,
            sun_aperture: aperture,
            complex_sun: false,
        };
        let environment = Environment::Sky(Box::new(Sky::new(&settings, turned()).unwrap()));
        let mut numbers = Numbers(Pcg64::new(3, 1));
        let mut found = Moments::default();
        for _ in 0..20_000 {
            let (direction, density) = environment.sample(numbers.pair()).unwrap();
            found.push(environment.radiance(direction, &[NM]).hero() / density);
        }
        found.estimate()
    };
    let expected = light(0.5358);
    for aperture in [0.001, 0.02, 0.1, 8.0] {
        let test = welch(&light(aperture), &expected);
        assert!(test.p_value > 1e-3, "{aperture}: {test}");
    }
}

/// The density that `sample` states is that of `density`, but where the two fall on different sides of an
/// edge by rounding.
#[test]
fn both_ways_to_ask_for_a_density_agree() {
    for environment in environments() {
        let mut numbers = Numbers(Pcg64::new(7, 1));
        let apart = (0..20_000)
            .filter(|_| {
                let (direction, p) = environment.sample(numbers.pair()).unwrap();
                (environment.density(direction) / p - 1.0).abs() > 1e-9
            })
            .count();
        assert!(apart < 20, "{apart}");
    }
}

/// A sample knows what comes from its direction, as if that were asked for.
#[test]
fn a_sample_has_the_radiance_of_its_direction() {
    for environment in environments() {
        let mut numbers = Numbers(Pcg64::new(8, 1));
        for _ in 0..20_000 {
            let u = numbers.pair();
            let (direction, density) = environment.sample(u).unwrap();
            let (same, p, radiance) = environment.sample_radiance(u, Vec3::ZERO, &[450.0, NM]).unwrap();
            assert_eq!((direction, density), (same, p));
            let expected = environment.radiance(direction, &[450.0, NM]);
            for (found, expected) in radiance.0.into_iter().zip(expected.0) {
                assert!(
                    (found - expected).abs() <= 1e-9 * (1.0 + expected),
                    "{direction}: {found} {expected}"
                );
            }
        }
    }
}

/// The irradiance of a plane, by directions to the light and by those that a diffuse surface scatters to.
#[test]
fn a_plane_receives_the_same_by_light_samples_and_by_scattering() {
    for (number, environment) in environments().into_iter().enumerate() {
        let mut numbers = Numbers(Pcg64::new(number as u128, 2));
        let [mut by_light, mut by_scattering] = [Moments::default(); 2];
        for _ in 0..300_000 {
            let (direction, p) = environment.sample(numbers.pair()).unwrap();
            by_light.push(environment.radiance(direction, &[NM]).hero() * direction.z.max(0.0) / p);
            let direction = Vec3::from(warp::cosine_hemisphere(numbers.pair()));
            by_scattering.push(environment.radiance(direction, &[NM]).hero() * PI);
        }
        let test = welch(&by_light.estimate(), &by_scattering.estimate());
        assert!(test.p_value > sidak(0.01, 4), "environment {number}: {test}");
    }
}

#[test]
fn the_mean_is_that_of_the_radiance() {
    for environment in environments() {
        let mut numbers = Numbers(Pcg64::new(3, 3));
        let mean: Moments = (0..200_000)
            .map(|_| environment.radiance(uniform_direction(numbers.pair()), &[NM]).hero())
            .collect();
        // It steers the choice of lights and wavelengths, nothing else: a few per cent do no harm.
        assert!((environment.mean().at(NM) / mean.mean() - 1.0).abs() < 0.05);
    }
}

/// A picture that is grey but for one texel, with most of the light in it: what a sample says of the
/// irradiance varies by no more than what the texels' interpolation, the square of the density's, asks for.
#[test]
fn a_small_sun_is_sampled_as_it_is_interpolated() {
    for (width, height) in [(64, 33), (512, 257)] {
        let dim = Texel { coefficients: [0.0; 3], factor: 1e-3 };
        let mut texels = vec![dim; width * height];
        texels[height / 3 * width + width / 5].factor = 1e4;
        let map = EnvironmentMap::new([width, height], texels, Spectrum::ONE, turned()).unwrap();
        let mut numbers = Numbers(Pcg64::new(5, 1));
        let light: Moments = (0..100_000)
            .map(|_| {
                let (direction, density) = map.sample(numbers.pair());
                map.radiance(direction, &[NM]).hero() / density
            })
            .collect();
        let relative = light.variance() / light.mean().powi(2);
        assert!(relative < 0.05, "{width}: {relative}");
    }
}
