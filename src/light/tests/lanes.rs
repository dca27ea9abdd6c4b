//! Light samples in lanes are those of one surface after the other.

use super::*;
use crate::geometry::Points;
use crate::lanes::{LANES, REGISTERS, Row, Vec3Lanes, WIDTH, ZERO, get, set};
use crate::light::{EnvironmentMap, LampLight, LightSamples, Lit, Receivers, Texel};
use crate::shape::{Mesh, Sphere};
use crate::spectrum::Extrapolation;

/// Colours of different brightness, most of them black.
fn map() -> Environment {
    let texel = |i: usize| match i * 7 % 11 {
        k @ 0..4 => Texel { coefficients: [1e-5 * k as f32, -0.01, 2.0], factor: (1 + k * k) as f32 },
        _ => Texel::BLACK,
    };
    let texels = (0..20 * 11).map(texel).collect();
    let turned = Transform::new(glam::DMat4::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), 1.1)).unwrap();
    let illuminant = Spectrum::regular(300.0, 900.0, &[1.0, 3.0], Extrapolation::Zero).unwrap();
    Environment::Map(Box::new(EnvironmentMap::new([20, 11], texels, illuminant, turned).unwrap()))
}

#[test]
fn light_samples_in_lanes_are_those_of_each_surface() {
    let mut numbers = Numbers::new(5);
    let rectangle = |turn: f64| {
        let place = placed(0.7, Vec3::new(0.1, 0.2, 1.0), turn);
        (Shape::Mesh(Mesh::rectangle(&place, false).unwrap()), grey(2.0))
    };
    let ball = |x: f64, radius: f64, radiance: f64| {
        let centre = Vec3::new(x, 0.4, -0.2);
        (
            Shape::Sphere(Sphere::new(&placed(1.0, Vec3::ZERO, 0.4), centre, radius, false).unwrap()),
            grey(radiance),
        )
    };
    let point = Light::Point { position: Vec3::new(0.3, -1.0, 1.0), intensity: Spectrum::Constant(3.0) };
    let worlds = [
        World::new(vec![rectangle(0.3)], Vec::new(), None),
        World::new(vec![rectangle(2.9)], vec![point.clone()], None),
        World::new(Vec::new(), vec![point], None),
        World::new(Vec::new(), Vec::new(), Some(Environment::Constant(Spectrum::ONE))),
        World::new(Vec::new(), Vec::new(), Some(map())),
        World::new(vec![rectangle(1.3)], Vec::new(), Some(map())),
        World::new(vec![ball(0.5, 1.0, 2.0)], Vec::new(), None),
        World::new(vec![ball(0.5, 1.0, 2.0), rectangle(0.8), ball(-2.0, 0.3, 5.0)], Vec::new(), None),
        World::new(vec![rectangle(2.0), ball(1.0, 0.2, 3.0)], Vec::new(), Some(map())),
    ];
    let density = WavelengthDensity::new(WavelengthRange::VISIBLE, &[], &[]);
    let wavelengths: [Wavelengths<2>; LANES] =
        std::array::from_fn(|lane| density.sample(lane as f64 / LANES as f64));
    let (mut found, mut none, mut far) = (0, 0, 0);
    for (number, world) in worlds.iter().enumerate() {
        for round in 0..200 {
            let reach = if round % 4 == 0 { 20.0 } else { 1.5 };
            let mut points = [Points::NONE; REGISTERS];
            let mut facing = [Vec3Lanes::ZERO; REGISTERS];
            let mut u: [Row; 2] = [ZERO; 2];
            for lane in 0..LANES {
                let position = Vec3::from_array(std::array::from_fn(|_| numbers.between(-reach, reach)));
                let normal = uniform_direction(numbers.pair());
                let error = 1e-12 * numbers.next();
                points[lane / WIDTH].set(lane, &SurfacePoint { position, normal, error });
                facing[lane / WIDTH].set(lane, normal);
                set(&mut u[0], lane, numbers.next());
                set(&mut u[1], lane, numbers.next());
            }
            let asked = 0b1110_1111_1111_0111;
            let mut samples = LightSamples::NONE;
            let of = |lane: usize| &wavelengths[lane];
            let light = LampLight::new(&world.lights, of, false);
            let receivers = Receivers { point: &points, facing: &facing };
            let lit = Lit { from: receivers, time: 0.0, wavelengths: of, light: &light, asked };
            world.lights.sample_in_lanes(&lit, &u, &mut samples);
            assert_eq!(samples.found & !asked, 0);
            let lights = &world.lights;
            let is_sampled = lights.environment().is_some_and(Environment::is_sampled);
            let beyond = is_sampled.then(|| lights.environment_probabilities(&lit));
            let hits = (0..lights.iter().count() as u32).filter_map(|light| {
                let point = lights.emit(light, numbers.pair(), 0.0, &[550.0])?.hit.point;
                Some(LightHit { light, point, triangle: 0, barycentric: [0.0; 2] })
            });
            let hits: Vec<_> = hits.collect();
            let each_hit = hits.iter().map(|hit| lights.densities(hit, &lit));
            let densities: Vec<Row> = each_hit.collect();
            for lane in (0..LANES).filter(|lane| asked >> lane & 1 == 1) {
                let receiver = receivers.get(lane);
                for (hit, densities) in hits.iter().zip(&densities) {
                    let expected = lights.density(hit, &receiver, 0.0, &wavelengths[lane]);
                    assert_eq!(get(densities, lane), expected, "world {number}");
                }
                if let Some(beyond) = &beyond {
                    let expected = lights.environment_probability(&receiver, 0.0, &wavelengths[lane]);
                    assert_eq!(get(beyond, lane), expected, "world {number}");
                }
                let values = u.each_ref().map(|row| get(row, lane));
                let expected = world.lights.sample(&receivers.get(lane), 0.0, &wavelengths[lane], values);
                assert_eq!(samples.found >> lane & 1 == 1, expected.is_some(), "world {number}");
                let Some(expected) = expected else {
                    none += 1;
                    continue;
                };
                let ray = samples.rays.get(lane);
                assert_eq!(ray.origin, expected.shadow_ray.origin, "world {number}");
                assert_eq!(ray.direction, expected.shadow_ray.direction, "world {number}");
                assert_eq!(ray.t_max, expected.shadow_ray.t_max, "world {number}");
                assert_eq!(samples.radiance.get(lane), expected.radiance);
                assert_eq!(samples.density_of(lane), expected.density);
                found += 1;
                far += u32::from(number == 0 && round % 4 == 0);
            }
        }
    }
    assert!(found > 4000 && none > 1000 && far > 200, "{found} found, {none} not, {far} from afar");
}

#[test]
fn environments_in_lanes_are_those_of_each_direction() {
    let mut numbers = Numbers::new(6);
    let density = WavelengthDensity::new(WavelengthRange::VISIBLE, &[], &[]);
    let wavelengths: [Wavelengths<4>; LANES] =
        std::array::from_fn(|lane| density.sample(lane as f64 / LANES as f64));
    let constant =
        Environment::Constant(Spectrum::regular(300.0, 900.0, &[1.0, 3.0], Extrapolation::Zero).unwrap());
    let mut lit = 0;
    for environment in [map(), constant] {
        for _ in 0..200 {
            let mut directions = [Vec3Lanes::ZERO; REGISTERS];
            let mut each = [Vec3::ZERO; LANES];
            for (lane, direction) in each.iter_mut().enumerate() {
                *direction = uniform_direction(numbers.pair());
                directions[lane / WIDTH].set(lane, *direction);
            }
            let asked = 0b0111_1011_1111_1110;
            let seen = environment.seen_in_lanes(&directions, asked, |lane| &wavelengths[lane]);
            for (lane, direction) in each.iter().enumerate().filter(|(lane, _)| asked >> lane & 1 == 1) {
                let radiance = environment.radiance(*direction, &wavelengths[lane].nm);
                assert_eq!(seen.radiance.get(lane), radiance);
                assert_eq!(get(&seen.density, lane), environment.density(*direction));
                lit += u32::from(!radiance.is_zero());
            }
        }
    }
    assert!(lit > 3000, "{lit}");
}
