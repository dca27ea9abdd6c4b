//! Textured surfaces are sampled as their textures are bright.

use super::{Numbers, World, per_steradian, placed, receiver, uniform_direction};
use crate::geometry::{Transform, UvTransform, Vec3};
use crate::raster::Image;
use crate::shape::{Cylinder, Disk, Mesh, Shape, Sphere};
use crate::stats::{Moments, sidak, welch};
use crate::texture::{Bitmap, Filter, Placing, Texture, Wrap};

/// Texels of which most are dark.
fn bitmap(side: usize, filter: Filter, to_uv: UvTransform, value: impl Fn(usize) -> f32) -> Texture {
    let image = Image::new(side, side, 1, (0..side * side).map(value).collect(), false);
    let placing = Placing { to_uv, filter, wrap: Wrap::Repeat };
    Texture::Bitmap(Box::new(Bitmap::new(&image, placing, true, false)))
}

/// Most of the light is in one.
fn one_bright_texel(side: usize) -> Texture {
    let dim = 0.64 / (side * side) as f32;
    let bright = side * (side / 3) + side / 4;
    bitmap(side, Filter::Linear, UvTransform::IDENTITY, |i| if i == bright { 100.0 } else { dim })
}

fn textures() -> Vec<Texture> {
    let speckled = |i: usize| [0.0, 0.0, 0.1, 5.0, 0.5, 0.0, 1.0][i * i % 7];
    let turned = UvTransform([[1.3, 0.4, 0.1], [-0.3, 2.0, 0.3]]);
    let swapped = UvTransform([[0.0, 1.7, 0.2], [-1.0, 0.0, 0.4]]);
    vec![
        one_bright_texel(8),
        bitmap(5, Filter::Nearest, UvTransform::IDENTITY, speckled),
        bitmap(5, Filter::Linear, swapped, speckled),
        bitmap(4, Filter::Linear, turned, speckled),
    ]
}

fn shapes() -> Vec<(&'static str, Shape)> {
    let place = |turn: f64| placed(0.7, Vec3::new(0.1, -0.2, 2.0), turn);
    let downward = {
        let rotation = glam::DQuat::from_rotation_x(2.9) * glam::DQuat::from_rotation_z(0.4);
        let matrix = glam::DMat4::from_scale_rotation_translation(
            Vec3::splat(0.7),
            rotation,
            Vec3::new(0.1, -0.2, 2.0),
        );
        Transform::new(matrix).unwrap()
    };
    vec![
        ("rectangle", Shape::Mesh(Mesh::rectangle(&downward, false).unwrap())),
        ("disk", Shape::Disk(Disk::new(&downward, false).unwrap())),
        ("sphere", Shape::Sphere(Sphere::new(&place(4.3), Vec3::ZERO, 1.0, false).unwrap())),
        ("cube", Shape::Mesh(Mesh::cube(&place(0.8), false).unwrap())),
        ("cylinder", Shape::Cylinder(Cylinder::new(&place(4.5), Vec3::ZERO, Vec3::Z, 0.6, false).unwrap())),
    ]
}

/// The irradiance by light samples, each weighed by the density that the point met is given, and by
/// directions from anywhere; and the density's integral is the fraction of samples that succeed.
#[test]
fn light_samples_bring_all_the_light_with_the_density_that_a_ray_finds() {
    let (shapes, textures) = (shapes(), textures());
    let level = sidak(0.01, 2 * shapes.len() * textures.len());
    for (name, shape) in &shapes {
        for (number, texture) in textures.iter().enumerate() {
            let world = World::new(vec![(shape.clone(), texture.clone())], Vec::new(), None);
            let from = receiver(Vec3::new(0.3, 0.1, 0.2), Vec3::Z);
            let mut numbers = Numbers::new(7);
            let [mut light, mut plain, mut found, mut density] = [Moments::default(); 4];
            let (mut apart, mut looked) = (0, 0);
            for _ in 0..40_000 {
                let sample = world.lights.sample(&from, 0.0, &world.wavelengths, numbers.pair());
                // What lies behind another part of the surface brings nothing.
                let seen = sample.and_then(|sample| {
                    let ray = from.point.ray(sample.shadow_ray.direction);
                    let (light_hit, radiance) = world.meet(&ray)?;
                    let hidden = light_hit.point.position.distance(from.point.position)
                        < sample.shadow_ray.t_max - 1e-6;
                    (!hidden).then_some((sample, light_hit, radiance))
                });
                found.push(f64::from(seen.is_some()));
                light.push(seen.map_or(0.0, |(sample, light_hit, radiance)| {
                    let stated = per_steradian(sample.density);
                    let again = world.lights.density(&light_hit, &from, 0.0, &world.wavelengths);
                    looked += 1;
                    apart += usize::from(
                        (again / stated - 1.0).abs() > 1e-6
                            || (sample.radiance.hero() - radiance).abs() > 1e-6 * radiance.max(1.0),
                    );
                    sample.radiance.hero() * sample.shadow_ray.direction.z.max(0.0) / stated
                }));
                let direction = uniform_direction(numbers.pair());
                let light_hit = world.meet(&from.point.ray(direction));
                let whole = 4.0 * std::f64::consts::PI;
                plain.push(
                    light_hit.as_ref().map_or(0.0, |(_, radiance)| radiance * direction.z.max(0.0) * whole),
                );
                density.push(light_hit.map_or(0.0, |(light_hit, _)| {
                    world.lights.density(&light_hit, &from, 0.0, &world.wavelengths) * whole
                }));
            }
            // Beside the line between two cells, or two triangles, rounding may lead to the other.
            assert!(looked > 1000 && apart * 1000 <= looked, "{name} {number}: {apart} of {looked}");
            for (what, a, b) in [("light", &light, &plain), ("density", &found, &density)] {
                let test = welch(&a.estimate(), &b.estimate());
                assert!(test.p_value > level, "{name}, texture {number}, {what}: {test}");
            }
        }
    }
}

/// By area alone the relative variance would be that of the texture, 30 and more. Of a cube each face has the
/// texture, and which of them are seen is known but roughly.
#[test]
fn one_bright_texel_is_found_by_all_samples() {
    for (name, shape) in shapes() {
        let most = if name == "cube" { 4.0 } else { 0.25 };
        for side in [8, 64] {
            let world = World::new(vec![(shape.clone(), one_bright_texel(side))], Vec::new(), None);
            let mut numbers = Numbers::new(3);
            // Where the bright texel is seen well from.
            let bright = (0..20_000)
                .filter_map(|_| {
                    let u = numbers.pair();
                    let point = shape.sample(u)?;
                    let ray = crate::geometry::Ray::new(
                        point.surface.point.position + point.surface.point.normal,
                        -point.surface.point.normal,
                    );
                    world.meet(&ray)
                })
                .max_by(|a, b| a.1.total_cmp(&b.1))
                .unwrap()
                .0
                .point;
            let from = receiver(bright.position + 1.5 * bright.normal, -bright.normal);
            let light: Moments = (0..20_000)
                .map(|_| {
                    let sample = world.lights.sample(&from, 0.0, &world.wavelengths, numbers.pair());
                    sample.map_or(0.0, |sample| {
                        let cos = sample.shadow_ray.direction.dot(from.facing).max(0.0);
                        sample.radiance.hero() * cos / per_steradian(sample.density)
                    })
                })
                .collect();
            let relative = light.variance() / light.mean().powi(2);
            assert!(relative < most, "{name} {side}: {relative}");
        }
    }
}

/// A texture that hardly differs leaves the samples to the solid angle.
#[test]
fn what_is_nearly_even_is_sampled_as_if_it_were() {
    let even = bitmap(8, Filter::Linear, UvTransform::IDENTITY, |i| 1.0 + 0.1 * (i % 3) as f32);
    let shape = Shape::Mesh(Mesh::rectangle(&Transform::IDENTITY, false).unwrap());
    let from = receiver(Vec3::new(0.2, 0.1, 0.5), -Vec3::Z);
    let [plain, textured] = [super::grey(1.0), even].map(|texture| {
        let world = World::new(vec![(shape.clone(), texture)], Vec::new(), None);
        per_steradian(world.lights.sample(&from, 0.0, &world.wavelengths, [0.3, 0.6]).unwrap().density)
    });
    assert_eq!(plain, textured);
}
