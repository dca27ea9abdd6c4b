//! Media that light comes into by refraction alone: their surface hides light samples from within.

use crate::geometry::Bounds;
use crate::medium::{Body, Filling, Medium};
use crate::scene::scene::Surface;
use std::cell::LazyCell;

/// With what probability a place takes a light sample in a medium that light comes into by refraction alone.
const SECLUDED: f64 = 1.0 / 16.0;

/// What decides which media light samples reach.
pub(super) struct Seclusion<'a, B, L> {
    pub bodies: &'a [Body],
    pub surfaces: &'a [Surface],
    /// The medium that the sensor is in.
    pub camera_medium: Option<u32>,
    /// Boxes around the shapes that are meant.
    pub boxes_of: B,
    /// Boxes around the lights that have a place, which are looked for where a medium may hide them.
    pub lamps: LazyCell<Vec<Bounds>, L>,
}

impl<B: Fn(&dyn Fn(usize) -> bool) -> Vec<Bounds>, L: FnOnce() -> Vec<Bounds>> Seclusion<'_, B, L> {
    /// Takes few light samples where a medium lies behind surfaces that let no shadow ray through, and no
    /// lamp is among it. Some are taken all the same: a surface may have a hole.
    pub fn apply(&self, media: &mut [Option<Medium>]) {
        for (medium, number) in media.iter_mut().zip(0..) {
            let Some(Medium { scattering: Some(scattering), .. }) = medium else { continue };
            let own = Filling::Medium(number);
            let holds = |shape: usize| {
                self.surfaces[shape].body.is_some_and(|body| self.bodies[body as usize].interior == own)
            };
            let lets_through = |surface: &Surface| {
                surface.body.is_some_and(|body| {
                    let body = &self.bodies[body as usize];
                    body.exterior == own || body.interior == own && surface.null_transmission
                })
            };
            let overlaps_lamp = |around: &Bounds| self.lamps.iter().any(|lamp| around.overlaps(*lamp));
            let holds_lamp = || (self.boxes_of)(&holds).iter().any(overlaps_lamp);
            if self.camera_medium != Some(number) && !self.surfaces.iter().any(lets_through) && !holds_lamp()
            {
                scattering.light_sample_probability = SECLUDED;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vec3;
    use crate::scene::description::{Bsdf, BsdfKind, Medium, ShapeDescription, ShapeKind};
    use crate::scene::fixture::{self, bsdf, constant, diffuse, glass, shape};
    use glam::DMat4;
    use std::sync::Arc;

    fn ball(x: f64, radius: f64, bsdf: Arc<Bsdf>) -> ShapeDescription {
        let kind = ShapeKind::Sphere { centre: Vec3::new(x, 0.0, 0.0), radius };
        shape(kind, DMat4::IDENTITY, bsdf)
    }

    fn milk() -> Medium {
        fixture::medium(constant(2.0), 0.9)
    }

    #[test]
    fn light_samples_are_few_where_they_are_hidden() {
        let glass = glass(1.5, None);
        let lamp = |x: f64| ShapeDescription {
            emission: Some(constant(1.0)),
            ..ball(x, 0.1, diffuse(constant(0.0)))
        };
        let filled =
            |bsdf: &Arc<Bsdf>| ShapeDescription { interior: Some(milk()), ..ball(0.0, 1.0, bsdf.clone()) };
        // What lies within the milk says that it does.
        let bubble = ShapeDescription { exterior: Some(milk()), ..ball(0.0, 0.2, glass.clone()) };
        let cases = [
            ("glass", vec![filled(&glass), lamp(3.0)], SECLUDED),
            ("no surface", vec![filled(&bsdf(BsdfKind::Null)), lamp(3.0)], 1.0),
            ("one way through", vec![filled(&glass), filled(&bsdf(BsdfKind::Null)), lamp(3.0)], 1.0),
            ("a lamp within", vec![filled(&glass), lamp(0.5)], 1.0),
            ("around a bubble", vec![filled(&glass), bubble, lamp(3.0)], 1.0),
        ];
        for (name, shapes, expected) in cases {
            let scene = fixture::compiled(&fixture::described(shapes, Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO));
            let [Some(medium)] = &scene.media[..] else { panic!("{name}: one medium") };
            let scattering = medium.scattering.as_ref().expect("it scatters");
            assert_eq!(scattering.light_sample_probability, expected, "{name}");
        }
    }
}
