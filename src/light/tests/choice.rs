//! Which light is chosen.

use super::{Numbers, World, grey, per_steradian, placed, receiver, uniform_direction};
use crate::geometry::{Motion, Placed, Transform, Vec3};
use crate::light::{Light, Receiver};
use crate::shape::{Disk, Mesh, Shape, Sphere};
use crate::spectrum::Spectrum;
use crate::stats::{Moments, chi_square, sidak, welch};
use crate::texture::Texture;
use std::f64::consts::PI;

/// Lights of several kinds all around.
fn mixed(count: usize, seed: u128) -> (Vec<(Shape, Texture)>, Vec<Light>) {
    let mut numbers = Numbers::new(seed);
    let mut others = Vec::new();
    let mut areas = Vec::new();
    for i in 0..count {
        let position =
            Vec3::new(numbers.between(-4.0, 4.0), numbers.between(-4.0, 4.0), numbers.between(-2.0, 4.0));
        let place = placed(numbers.between(0.05, 0.3), position, numbers.between(0.0, 6.0));
        let brightness = [1.0, 0.1, 20.0][i % 3];
        match i % 5 {
            0 => areas.push((
                Shape::Sphere(Sphere::new(&place, Vec3::ZERO, 1.0, false).unwrap()),
                grey(brightness),
            )),
            1 => areas.push((Shape::Mesh(Mesh::cube(&place, false).unwrap()), grey(brightness))),
            2 => areas.push((Shape::Mesh(Mesh::rectangle(&place, false).unwrap()), grey(brightness))),
            3 => areas.push((Shape::Disk(Disk::new(&place, false).unwrap()), grey(brightness))),
            _ => others.push(Light::Point { position, intensity: Spectrum::Constant(brightness) }),
        }
    }
    for travels in [-Vec3::Z, Vec3::new(0.6, 0.0, 0.8)] {
        others.push(Light::Directional { travels, irradiance: Spectrum::Constant(0.5) });
    }
    (areas, others)
}

fn receivers() -> [Receiver; 3] {
    [
        receiver(Vec3::new(0.1, 0.2, 0.0), Vec3::Z),
        receiver(Vec3::new(30.0, -5.0, 2.0), Vec3::ZERO),
        receiver(Vec3::new(-2.0, 3.0, 1.0), Vec3::new(0.0, -0.6, 0.8)),
    ]
}

/// With few lights and with many: parts are met as often as their probability says, the probabilities sum to
/// one, and what is left of the sample value is uniform.
#[test]
fn parts_are_chosen_with_the_probability_that_they_have() {
    const CHOICES: usize = 200_000;
    let worlds = [6, 20, 300].map(|count| {
        let (areas, others) = mixed(count, count as u128);
        World::new(areas, others, None)
    });
    let level = sidak(0.01, 2 * worlds.len() * 3);
    for world in &worlds {
        let lights = &world.lights;
        let mut parts = Vec::new();
        for (light, own) in lights.lights.iter().enumerate() {
            parts.extend((0..own.parts()).map(|part| (light, part)));
        }
        let index = |light, part| parts.binary_search(&(light, part)).unwrap();
        for from in receivers() {
            let mut numbers = Numbers::new(1);
            let mut seen = vec![0.0; parts.len()];
            let mut left = vec![0.0; 64];
            let mut expected = vec![0.0; parts.len()];
            let mut lost = 0.0;
            for _ in 0..CHOICES {
                let mut u = numbers.next();
                let Some(chosen) = lights.choose(&from, 0.0, &world.wavelengths, &mut u) else {
                    lost += 1.0;
                    continue;
                };
                let place = index(chosen.light, chosen.part);
                seen[place] += 1.0;
                left[(u * 64.0) as usize] += 1.0;
                // Directional lights of many state what no one else asks for.
                expected[place] = chosen.probability * CHOICES as f64;
                let again = lights.probability(chosen.light, chosen.part, &from, 0.0, &world.wavelengths);
                let distant = matches!(lights.lights[chosen.light], Light::Directional { .. });
                assert!(distant || (again / chosen.probability - 1.0).abs() < 1e-9, "{again}");
            }
            for (place, &(light, part)) in parts.iter().enumerate() {
                if expected[place] == 0.0 {
                    expected[place] =
                        lights.probability(light, part, &from, 0.0, &world.wavelengths) * CHOICES as f64;
                }
            }
            // A node may bring light by its bound although none of those below it does.
            let missing = CHOICES as f64 - expected.iter().sum::<f64>();
            assert!(missing >= -1e-6 * CHOICES as f64 && missing < 0.5 * CHOICES as f64, "{missing}");
            seen.push(lost);
            expected.push(missing.max(0.0));
            let choice = chi_square(&seen, &expected);
            assert!(choice.p_value > level, "{choice:?}");
            let even = vec![left.iter().sum::<f64>() / 64.0; 64];
            let uniform = chi_square(&left, &even);
            assert!(uniform.p_value > level, "{uniform:?}");
        }
    }
}

/// The irradiance by light samples and by directions from anywhere, with the densities that rays find; and
/// the densities' integral.
#[test]
fn light_samples_of_many_lights_bring_all_their_light() {
    let (areas, _) = mixed(300, 300);
    let world = World::new(areas, Vec::new(), None);
    let level = sidak(0.01, 6);
    for from in receivers() {
        let cos = |direction: Vec3| {
            if from.facing == Vec3::ZERO { 1.0 } else { direction.dot(from.facing).max(0.0) }
        };
        let mut numbers = Numbers::new(2);
        let [mut light, mut plain, mut found, mut density] = [Moments::default(); 4];
        for _ in 0..60_000 {
            let sample = world.lights.sample(&from, 0.0, &world.wavelengths, numbers.pair());
            let seen = sample.filter(|sample| {
                let light_hit = world.meet(&from.point.ray(sample.shadow_ray.direction));
                light_hit.is_some_and(|(light_hit, _)| {
                    light_hit.point.position.distance(from.point.position) > sample.shadow_ray.t_max - 1e-6
                })
            });
            found.push(f64::from(seen.is_some()));
            light.push(seen.map_or(0.0, |sample| {
                sample.radiance.hero() * cos(sample.shadow_ray.direction) / per_steradian(sample.density)
            }));
            let direction = uniform_direction(numbers.pair());
            let light_hit = world.meet(&from.point.ray(direction));
            plain.push(light_hit.as_ref().map_or(0.0, |(_, radiance)| radiance * cos(direction) * 4.0 * PI));
            density.push(light_hit.map_or(0.0, |(light_hit, _)| {
                world.lights.density(&light_hit, &from, 0.0, &world.wavelengths) * 4.0 * PI
            }));
        }
        for (what, a, b) in [("light", &light, &plain), ("density", &found, &density)] {
            let test = welch(&a.estimate(), &b.estimate());
            assert!(test.p_value > level, "{what}: {test}");
        }
    }
}

/// Samples at equal steps of the first value go to as many lights that are alike, one to each.
#[test]
fn the_first_value_chooses_the_light_too() {
    let lamp = |i: usize| {
        let turn = f64::from(i as u32) * PI / 3.0;
        let place = placed(0.2, Vec3::new(2.0 * turn.cos(), 2.0 * turn.sin(), 3.0), 0.0);
        (Shape::Sphere(Sphere::new(&place, Vec3::ZERO, 1.0, false).unwrap()), grey(1.0))
    };
    let world = World::new((0..6).map(lamp).collect(), Vec::new(), None);
    let from = receiver(Vec3::ZERO, Vec3::Z);
    for u in [0.1, 0.5, 0.9] {
        let mut seen = [0; 6];
        for k in 0..6 {
            let u = [(f64::from(k) + u) / 6.0, 0.3];
            let sample = world.lights.sample(&from, 0.0, &world.wavelengths, u).unwrap();
            let (light_hit, _) = world.meet(&from.point.ray(sample.shadow_ray.direction)).unwrap();
            seen[light_hit.light as usize] += 1;
        }
        assert_eq!(seen, [1; 6]);
    }
}

/// What lies behind a surface that light does not pass is left out, whether lights are few or many.
#[test]
fn lights_behind_a_surface_are_not_chosen() {
    for count in [2, 40] {
        let lamp = |i: usize| {
            let height = if i.is_multiple_of(2) { 2.0 } else { -2.0 };
            let place = placed(0.1, Vec3::new(i as f64 * 0.1, 0.0, height), 0.0);
            (Shape::Sphere(Sphere::new(&place, Vec3::ZERO, 1.0, false).unwrap()), grey(1.0))
        };
        let world = World::new((0..count).map(lamp).collect(), Vec::new(), None);
        let chosen = |facing: Vec3| -> Vec<bool> {
            let of = |i: u32| {
                let mut u = (f64::from(i) + 0.5) / 1000.0;
                let from = receiver(Vec3::ZERO, facing);
                world
                    .lights
                    .choose(&from, 0.0, &world.wavelengths, &mut u)
                    .map(|chosen| chosen.light.is_multiple_of(2))
            };
            (0..1000).filter_map(of).collect()
        };
        assert!(chosen(Vec3::Z).into_iter().all(|above| above));
        let both = chosen(Vec3::ZERO);
        assert!(both.contains(&true) && both.contains(&false));
    }
}

/// The relative variance of the irradiance that one sample tells: no more than twice as much with 10,000
/// small lights as with 100 of the same area and place.
#[test]
fn many_lights_are_hardly_noisier_than_some() {
    let variance = |count: usize| {
        let mut numbers = Numbers::new(count as u128);
        let lamp = |i: usize| {
            let position =
                Vec3::new(numbers.between(-5.0, 5.0), numbers.between(-5.0, 5.0), numbers.between(2.0, 4.0));
            let place = placed(0.5 / (count as f64).sqrt(), position, 0.0);
            (
                Shape::Sphere(Sphere::new(&place, Vec3::ZERO, 1.0, false).unwrap()),
                grey([1.0, 5.0, 30.0][i % 3]),
            )
        };
        let areas: Vec<(Shape, Texture)> = (0..count).map(lamp).collect();
        let world = World::new(areas, Vec::new(), None);
        let places = (0..40).map(|_| Vec3::new(numbers.between(-4.0, 4.0), numbers.between(-4.0, 4.0), 0.0));
        let places: Vec<Vec3> = places.collect();
        let relative = |&position: &Vec3| {
            let from = receiver(position, Vec3::Z);
            let light: Moments = (0..2000)
                .map(|_| {
                    let sample = world.lights.sample(&from, 0.0, &world.wavelengths, numbers.pair());
                    sample.map_or(0.0, |sample| {
                        let cos = sample.shadow_ray.direction.z.max(0.0);
                        sample.radiance.hero() * cos / per_steradian(sample.density)
                    })
                })
                .collect();
            light.variance() / light.mean().powi(2)
        };
        places.iter().map(relative).sum::<f64>() / 40.0
    };
    let (some, many) = (variance(100), variance(10_000));
    assert!(many < 2.0 * some && some < 2.0, "{some} {many}");
}

/// A point light that moves is chosen among many wherever it is, and brings its irradiance.
#[test]
fn moving_lights_are_found_at_any_time() {
    let keys = [
        (0.0, placed(1.0, Vec3::new(-3.0, 0.0, 1.0), 0.0)),
        (1.0, placed(1.0, Vec3::new(3.0, 0.0, 1.0), 0.0)),
    ];
    let motion = Placed::moving(Motion::new(&keys).unwrap()).unwrap();
    let point = |position: Vec3| Light::Point { position, intensity: Spectrum::Constant(1.0) };
    let mut lights: Vec<Light> = (0..40).map(|i| point(Vec3::new(f64::from(i) - 20.0, 30.0, 1.0))).collect();
    lights.push(point(Vec3::ZERO));
    let still = lights.clone();
    let world = World::moving(Vec::new(), lights, None, vec![(40, motion)]);
    let mut numbers = Numbers::new(4);
    for time in [0.0, 0.3, 1.0] {
        let from = receiver(Vec3::new(0.5, 0.0, 0.0), Vec3::Z);
        let now = Vec3::new(-3.0 + 6.0 * time, 0.0, 1.0);
        let irradiance = |position: Vec3| {
            let toward = position - from.point.position;
            toward.z.max(0.0) / toward.length().powi(3)
        };
        let expected: f64 = still[..40]
            .iter()
            .map(|light| match light {
                Light::Point { position, .. } => irradiance(*position),
                _ => 0.0,
            })
            .sum::<f64>()
            + irradiance(now);
        let light: Moments = (0..40_000)
            .map(|_| {
                let sample = world.lights.sample(&from, time, &world.wavelengths, numbers.pair());
                sample.map_or(0.0, |sample| sample.radiance.hero() * sample.shadow_ray.direction.z.max(0.0))
            })
            .collect();
        let error = (light.variance() / 40_000.0).sqrt();
        assert!((light.mean() - expected).abs() < 4.0 * error + 1e-9, "{time}: {} {expected}", light.mean());
    }
}

/// An emissive mesh is sampled mostly on the side that is seen, a sixth of it.
#[test]
fn triangles_that_face_away_are_seldom_chosen() {
    let cube = Shape::Mesh(Mesh::cube(&Transform::IDENTITY, false).unwrap());
    let world = World::new(vec![(cube, grey(1.0))], Vec::new(), None);
    let from = receiver(Vec3::new(0.1, 0.2, 4.0), Vec3::ZERO);
    let mut numbers = Numbers::new(6);
    let found = (0..1000)
        .filter(|_| world.lights.sample(&from, 0.0, &world.wavelengths, numbers.pair()).is_some())
        .count();
    assert!(found > 700, "{found}");
}
