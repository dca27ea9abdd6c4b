mod choice;
mod environments;
mod lanes;
mod textured;

use super::{AreaGeometry, Environment, Light, LightHit, Lights, Receiver, Setting};
use crate::geometry::{Placed, Ray, SurfacePoint, Transform, Vec3};
use crate::sampling::Density;
use crate::shape::Shape;
use crate::spectrum::{Spectrum, WavelengthDensity, Wavelengths};
use crate::texture::{Texture, TexturePoint};
use crate::units::WavelengthRange;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::Rng;

/// Lights with the shapes that they are the surfaces of, the first lights in the same order.
struct World {
    shapes: Vec<Shape>,
    /// Around each of them: a centre and the square of a radius.
    balls: Vec<(Vec3, f64)>,
    lights: Lights,
    wavelengths: Wavelengths<1>,
}

impl World {
    fn new(areas: Vec<(Shape, Texture)>, others: Vec<Light>, environment: Option<Environment>) -> Self {
        Self::moving(areas, others, environment, Vec::new())
    }

    fn moving(
        areas: Vec<(Shape, Texture)>,
        others: Vec<Light>,
        environment: Option<Environment>,
        moving: Vec<(usize, Placed)>,
    ) -> Self {
        let density = WavelengthDensity::new(WavelengthRange::VISIBLE, &[], &[]);
        let shapes: Vec<Shape> = areas.iter().map(|(shape, _)| shape.clone()).collect();
        let ball = |shape: &Shape| {
            let bounds = shape.bounds();
            (bounds.centre(), (0.5001 * bounds.diameter()).powi(2))
        };
        let balls = shapes.iter().map(ball).collect();
        let area = |(shape, radiance): (Shape, Texture)| Light::Area {
            geometry: Box::new(AreaGeometry::new(shape, radiance.varies())),
            mean: radiance.mean_spectrum(WavelengthRange::VISIBLE),
            radiance,
        };
        let lights = areas.into_iter().map(area).chain(others).collect();
        let setting = Setting { during: [0.0, 1.0], density: &density };
        let lights = Lights::new(lights, environment, moving, &setting);
        Self { shapes, balls, lights, wavelengths: density.sample(0.5) }
    }

    /// The light that a ray meets first on its front, and its radiance there.
    fn meet(&self, ray: &Ray) -> Option<(LightHit, f64)> {
        let passes = |&(centre, square): &(Vec3, f64)| {
            let toward = centre - ray.origin;
            let along = toward.dot(ray.direction);
            toward.length_squared() - along * along < square
        };
        let near = (0..).zip(&self.shapes).zip(&self.balls).filter(|(_, ball)| passes(ball));
        let hits = near.filter_map(|((i, shape), _)| Some((i, shape, shape.intersect(ray)?)));
        let (light, shape, hit) = hits.min_by(|a, b| a.2.t.total_cmp(&b.2.t))?;
        let point = shape.surface(&hit, ray).point;
        let light_hit = LightHit { light, point, triangle: hit.triangle, barycentric: hit.barycentric };
        let uv = shape.parametrisation(&hit, point.position).uv;
        let at_rest = crate::shape::AtRest { position: point.position, ..crate::shape::AtRest::NONE };
        let at = TexturePoint { uv, position: point.position, at_rest, mesh: None };
        let front = ray.direction.dot(point.normal) < 0.0;
        front.then(|| (light_hit, self.lights.radiance(light, &at, &self.wavelengths.nm).hero()))
    }
}

struct Numbers(Pcg64);

impl Numbers {
    fn new(seed: u128) -> Self {
        Self(Pcg64::new(seed, 1))
    }

    fn next(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    fn pair(&mut self) -> [f64; 2] {
        [self.next(), self.next()]
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}

fn uniform_direction(u: [f64; 2]) -> Vec3 {
    let z = 2.0 * u[0] - 1.0;
    let (sin, cos) = (std::f64::consts::TAU * u[1]).sin_cos();
    Vec3::new(cos, sin, 0.0) * (1.0 - z * z).sqrt() + Vec3::Z * z
}

fn receiver(position: Vec3, facing: Vec3) -> Receiver {
    Receiver { point: SurfacePoint { position, normal: Vec3::Z, error: 0.0 }, facing }
}

fn placed(scale: f64, position: Vec3, turn: f64) -> Transform {
    let axis = Vec3::new(0.6, 0.0, 0.8);
    let rotation = glam::DQuat::from_axis_angle(axis, turn);
    Transform::new(glam::DMat4::from_scale_rotation_translation(Vec3::splat(scale), rotation, position))
        .unwrap()
}

fn grey(radiance: f64) -> Texture {
    Texture::Uniform(Spectrum::Constant(radiance))
}

fn per_steradian(density: Density) -> f64 {
    match density {
        Density::PerSolidAngle(density) => density,
        Density::Discrete => panic!("no density"),
    }
}
