//! Whether caustics are found on light subpaths, and from where to where these lead.

use super::contact;
use super::groups::Groups;
use crate::camera::Camera;
use crate::geometry::{Bounds, Transform};
use crate::light::{Caster, Casters, CausticSource, Caustics, Light, Lights, Origin};
use crate::medium::Body;
use crate::scene::Limits;
use crate::scene::scene::Surface;
use crate::shape::Shape;
use crate::units::WavelengthRange;
use std::f64::consts::PI;

/// The [`crate::light::Environment::unevenness`] from which on light subpaths begin beyond the scene.
const WORTH_TRACING: f64 = 4.0;

/// All that decides about light subpaths.
pub(super) struct Setting<'a> {
    pub groups: &'a Groups<'a>,
    pub shift: &'a Transform,
    pub shapes: &'a [Shape],
    /// Boxes around what is left of them.
    pub boxes: &'a [Bounds],
    pub bodies: &'a [Body],
    pub lights: &'a Lights,
    /// A box around all surfaces at all times.
    pub bounds: Bounds,
    pub camera: &'a Camera,
    pub camera_medium: Option<u32>,
    pub limits: Limits,
    pub range: WavelengthRange,
    /// Width and height of the whole film, pixels: a part of it has the light subpaths of the whole.
    pub film: [u32; 2],
}

impl Setting<'_> {
    /// Where light subpaths begin and where to. `None` where there are none: nothing is smooth, no light has
    /// a surface and the environment is even, the sensor does not say where a point is seen, or light goes
    /// other ways than from surface to surface.
    ///
    /// Smooth surfaces whose place is not known, of parts that move by themselves, are then no longer called
    /// so.
    pub fn caustics(&self, surfaces: &mut [Surface]) -> Option<Caustics> {
        let Limits { hide_emitters, null_is_a_segment, .. } = self.limits;
        let possible = self.limits.allow_caustics()
            && null_is_a_segment
            && !hide_emitters
            && self.camera_medium.is_none()
            && self.camera.projects();
        if !possible {
            return None;
        }
        let own = self.groups.own();
        for (i, surface) in surfaces[..own].iter_mut().enumerate() {
            surface.smooth &= !self.groups.moves(i);
        }
        let smooth = |shape: usize| surfaces[shape].smooth;
        let left = (0..own).filter(|&i| smooth(i) && !self.boxes[i].is_empty());
        let own = left.map(|i| Caster::of(&self.shapes[i], self.boxes[i]));
        let shown = self.groups.shown(&self.groups.contents(self.shapes), self.shift);
        let instances = shown.iter().filter(|shown| shown.shapes.iter().any(|&shape| smooth(shape)));
        let instances = instances.map(|shown| Caster::around(shown.bounds));
        let casters = Casters::new(own.chain(instances).collect());
        let [width, height] = self.film.map(u64::from);
        let mut sources = self.sources(surfaces);
        sources.extend(self.environment(&casters));
        Caustics::new(casters, Caster::around(self.bounds), sources, width * height)
    }

    /// The environment, where its light is so uneven that paths from the camera find much of it seldom.
    fn environment(&self, casters: &Casters) -> Option<CausticSource> {
        let environment = self.lights.environment()?;
        if environment.unevenness() < WORTH_TRACING {
            return None;
        }
        // What enters the bodies, over the solid angle by which that of lights with a surface is more than
        // their weights say.
        let entering = 4.0 * PI * casters.cross_section() * environment.mean().integral(self.range);
        let from = |light: &Light| match light {
            Light::Area { geometry, .. } => Some(casters.solid_angle_from(geometry.bounds().centre())),
            _ => None,
        };
        let angles: Vec<f64> = self.lights.iter().filter_map(from).collect();
        let angle = if angles.is_empty() { PI } else { angles.iter().sum::<f64>() / angles.len() as f64 };
        let power = entering / angle;
        (power > 0.0 && power.is_finite()).then_some(CausticSource { origin: Origin::Environment, power })
    }

    /// The lights that light subpaths begin at: those with a surface that is known to lie outside of all
    /// bodies.
    fn sources(&self, surfaces: &[Surface]) -> Vec<CausticSource> {
        let bodies: Vec<Bounds> =
            contact::body_boxes(self.groups, self.shift, self.shapes, self.boxes, surfaces, self.bodies)
                .collect();
        let begins = |(index, light): (u32, &Light)| {
            let Light::Area { geometry, mean, .. } = light else { return None };
            let outside =
                geometry.stands_alone() && !bodies.iter().any(|body| body.overlaps(geometry.bounds()));
            let area = geometry.area();
            let power = area * mean.integral(self.range);
            let origin = Origin::Surface { light: index, area };
            (outside && power > 0.0 && power.is_finite()).then_some(CausticSource { origin, power })
        };
        (0..).zip(self.lights.iter()).filter_map(begins).collect()
    }
}
