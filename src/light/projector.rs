//! Projectors: a camera that sends out its picture, as Mitsuba 3's `projector`.

use crate::geometry::{Transform, Vec3};
use crate::shape::AtRest;
use crate::spectrum::{Sampled, Spectrum};
use crate::texture::{Texture, TexturePoint};
use std::f64::consts::PI;

/// A pinhole that throws a picture along its local +z.
#[derive(Clone, Debug)]
pub struct Projector {
    /// Where it stands, in scene units.
    pub position: Vec3,
    /// Radiant intensity along the axis, about the mean over the picture: above 0 at every wavelength at
    /// which any of it shines.
    pub mean: Spectrum,
    picture: Texture,
    scale: f64,
    from_world: Transform,
    /// +z of the local frame, with the length that the transform gives it.
    axis: Vec3,
    /// Tangents of half the field of view, across and upwards.
    tan_half: [f64; 2],
}

impl Projector {
    /// A projector of a picture, with the picture's approximate mean.
    pub fn new(
        to_world: &Transform,
        picture: Texture,
        mean: &Spectrum,
        scale: f64,
        tan_half: [f64; 2],
    ) -> Self {
        Self {
            position: to_world.point(Vec3::ZERO),
            mean: mean.scaled(PI * scale),
            picture,
            scale,
            from_world: to_world.inverse(),
            axis: to_world.vector(Vec3::Z),
            tan_half,
        }
    }

    /// The solid angle that the light fills, about, sr.
    pub fn solid_angle(&self) -> f64 {
        let [x, y] = self.tan_half;
        4.0 * (x * y / (1.0 + x * x + y * y).sqrt()).atan()
    }

    /// Radiant intensity in a direction (unit length) away from the light, W·sr⁻¹·nm⁻¹.
    ///
    /// A picture of value E makes a surface at distance 1 that faces the projector look as if it received
    /// π·E: I(ω) = π E / cos³θ, so that a flat screen is lit evenly.
    pub fn intensity<const C: usize>(&self, direction: Vec3, nm: &[f64; C]) -> Sampled<C> {
        let local = self.from_world.vector(direction);
        if local.z <= 0.0 {
            return Sampled::ZERO;
        }
        let [x, y] = [local.x / local.z / self.tan_half[0], local.y / local.z / self.tan_half[1]];
        if x.abs() > 1.0 || y.abs() > 1.0 {
            return Sampled::ZERO;
        }
        // The picture's left is local +x, its first row is at the top.
        let uv = [0.5 - 0.5 * x, 0.5 - 0.5 * y];
        let at = TexturePoint { uv, position: self.position, at_rest: AtRest::NONE, mesh: None };
        let strength = PI * self.scale / (local.z * local.z * self.axis.dot(direction));
        self.picture.sample(&at, nm) * strength
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mitsuba 3.9.1, `projector` with fov 60 and irradiance 1: the irradiance across the ray that
    /// `emitter.sample_direction` gives, over π, with several scales in `to_world`.
    #[test]
    fn the_irradiance_is_mitsubas() {
        let points = [[0.0, 0.0, 1.0], [0.2, 0.1, 1.0], [0.0, 0.0, 2.0], [0.5, 0.0, 1.0]];
        for (scale, expected) in [
            ([1.0, 1.0, 1.0], [1.0, 1.0247, 0.25, 1.11803]),
            ([2.0, 2.0, 2.0], [2.0, 2.04939, 0.5, 2.23607]),
            ([2.0, 1.0, 1.0], [1.0, 1.0247, 0.25, 1.11803]),
            ([1.0, 1.0, 2.0], [2.0, 2.04939, 0.5, 0.0]),
            ([-1.0, 1.0, 1.0], [1.0, 1.0247, 0.25, 1.11803]),
            ([1.0, 1.0, -1.0], [0.0, 0.0, 0.0, 0.0]),
        ] {
            let to_world = Transform::new(glam::DMat4::from_scale(Vec3::from(scale))).unwrap();
            let tan = 30f64.to_radians().tan();
            let projector =
                Projector::new(&to_world, Texture::Uniform(Spectrum::ONE), &Spectrum::ONE, 1.0, [tan; 2]);
            for (point, expected) in points.map(Vec3::from).into_iter().zip(expected) {
                let seen = projector.intensity(point.normalize(), &[550.0]).hero() / point.length_squared();
                assert!((seen / PI - expected).abs() < 1e-5, "{scale:?} {point}: {}", seen / PI);
            }
        }
    }
}
