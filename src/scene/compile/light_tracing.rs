//! Whether caustics and visible lamps are found on light subpaths, and from where to where these lead.

use super::contact;
use super::groups::Groups;
use crate::bsdf::Specular;
use crate::camera::Camera;
use crate::film::Extent;
use crate::geometry::{Bounds, Transform};
use crate::light::{
    Caster, Casters, CastersByKind, Caustics, Light, LightTracing, Lights, Origin, Source, Subpaths,
    VisibleLamps,
};
use crate::medium::{Body, Filling};
use crate::scene::scene::Surface;
use crate::scene::{Features, Limits};
use crate::shape::Shape;
use crate::units::WavelengthRange;
use std::f64::consts::PI;

/// The [`crate::light::Environment::unevenness`] from which on light subpaths begin beyond the scene.
const WORTH_TRACING: f64 = 4.0;

/// The solid angle up to which a source of light is small, in steradians. Chance seldom finds its image in
/// polished metal. With light subpaths to its metals `validation/speed/scenes/metals.xml`, whose lamp fills
/// 0.2 sr, costs 1.7 times what it costs without.
const SMALL: f64 = 0.1;

/// The part of all light that must come from small sources for their images in polished metal to be looked
/// for.
const MUCH: f64 = 0.25;

/// A lamp is found on light subpaths where it covers so many times as many pixels as in focus: one in so many
/// camera rays of these pixels meets it.
const SELDOM_MET: f64 = 4.0;

/// How far a point in focus reaches on the film, in pixels: as far as usual filters do.
const PIXEL: f64 = 1.0;

/// A light with a surface, halfway through the exposure.
struct Lamp {
    origin: Origin,
    /// In the world.
    area: f64,
    /// The mean over the surface, over all wavelengths.
    radiance: f64,
    /// In the world.
    bounds: Bounds,
}

impl Lamp {
    fn source(&self) -> Source {
        Source { origin: self.origin, power: self.area * self.radiance }
    }

    /// About the solid angle that it fills for a caster.
    fn solid_angle_at(&self, caster: &Caster) -> f64 {
        self.area / self.bounds.centre().distance_squared(caster.centre())
    }
}

/// How a lamp is seen.
struct View {
    origin: Origin,
    /// Pixels of its image in focus.
    in_focus: f64,
    /// Pixels that it covers.
    covered: f64,
    /// Radiance × pixels.
    brightness: f64,
}

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
    /// When the shutter opens and closes.
    pub during: [f64; 2],
    /// At which lamps are looked at.
    pub time: f64,
    pub limits: Limits,
    pub features: Features,
    pub range: WavelengthRange,
    pub film: Extent,
}

impl Setting<'_> {
    /// What is traced from the lights, if anything is. Surfaces whose place is not known, of parts that move
    /// by themselves, are then no longer called specular.
    pub fn light_tracing(&self, surfaces: &mut [Surface]) -> Option<LightTracing> {
        let Limits { max_depth, hide_emitters, null_is_a_segment, .. } = self.limits;
        let possible = max_depth > 0
            && null_is_a_segment
            && !hide_emitters
            && self.camera_medium.is_none()
            && self.camera.projects()
            && !self.begins_unknown()
            && !self.is_seen_through_events();
        if !possible {
            return None;
        }
        let lamps = self.lamps(surfaces);
        // Where a caustic falls is not known: a window of the film has the light subpaths of the whole. Lamps
        // are seen in the window alone.
        let [width, height] = self.film.whole.map(u64::from);
        let of_whole = Subpaths { pixels: width * height };
        let caustics =
            self.limits.allow_caustics().then(|| self.caustics(surfaces, &lamps, of_whole)).flatten();
        let subpaths = match caustics {
            Some(_) => of_whole,
            None => Subpaths { pixels: self.film.window.pixel_count() },
        };
        LightTracing::new(caustics, self.visible_lamps(&lamps, subpaths), subpaths)
    }

    /// Where light subpaths for caustics begin and where to. `None` where there are none: nothing is
    /// specular, or no light has a surface and the environment is even.
    fn caustics(&self, surfaces: &mut [Surface], lamps: &[Lamp], subpaths: Subpaths) -> Option<Caustics> {
        let own = self.groups.own();
        for (i, surface) in surfaces[..own].iter_mut().enumerate() {
            if self.groups.moves(i) {
                surface.specular = Specular::Nothing;
            }
        }
        let left =
            (0..own).filter(|&i| surfaces[i].specular != Specular::Nothing && !self.boxes[i].is_empty());
        let own = left.map(|i| (surfaces[i].specular, Caster::of(&self.shapes[i], self.boxes[i])));
        let shown = self.groups.shown(&self.groups.contents(self.shapes), self.shift);
        let instances = shown.iter().filter_map(|shown| {
            let most = shown.shapes.iter().map(|&shape| surfaces[shape].specular).max()?;
            Some((most, Caster::around(shown.bounds)))
        });
        let mut found = CastersByKind::default();
        for (specular, caster) in own.chain(instances) {
            match specular {
                Specular::All => found.bodies.push(caster),
                Specular::Coat => found.coats.push(caster),
                Specular::Nearly => found.polished.push(caster),
                Specular::Nothing => {}
            }
        }
        if !found.polished.is_empty() && !self.much_is_from_small_sources(lamps, &found.polished) {
            found.polished.clear();
            for surface in surfaces.iter_mut().filter(|surface| surface.specular == Specular::Nearly) {
                surface.specular = Specular::Nothing;
            }
        }
        let casters = Casters::new(found);
        let mut sources: Vec<Source> = lamps.iter().map(Lamp::source).collect();
        sources.extend(self.environment(&casters));
        Caustics::new(casters, Caster::around(self.bounds), sources, subpaths)
    }

    /// Whether so much light is from small sources that their images in polished metals are looked for.
    fn much_is_from_small_sources(&self, lamps: &[Lamp], polished: &[Caster]) -> bool {
        let of_lamp = |lamp: &Lamp| {
            let angles: f64 = polished.iter().map(|caster| lamp.solid_angle_at(caster)).sum();
            (lamp.source().power, angles / polished.len() as f64)
        };
        let casters = Casters::new(CastersByKind { polished: polished.to_vec(), ..Default::default() });
        let of_environment =
            self.environment(&casters).zip(self.lights.environment()).map(|(source, light)| {
                let angle = 4.0 * PI / light.unevenness();
                (source.power, angle)
            });
        let (mut of_small, mut all) = (0.0, 0.0);
        for (power, angle) in lamps.iter().map(of_lamp).chain(of_environment) {
            all += power;
            if angle < SMALL {
                of_small += power;
            }
        }
        of_small > MUCH * all
    }

    /// The lamps in the picture that cover many more pixels than their image in focus does, as far as light
    /// subpaths reach them more often than camera rays.
    fn visible_lamps(&self, lamps: &[Lamp], subpaths: Subpaths) -> Option<VisibleLamps> {
        let seen: Vec<View> = lamps.iter().filter_map(|lamp| self.view_of(lamp)).collect();
        // Their light, if it were spread over the picture.
        let even =
            seen.iter().map(|view| view.brightness).sum::<f64>() / self.film.window.pixel_count() as f64;
        // Relative errors of pixels, in which there may be other light, are the least by these weights.
        let weight = |view: &View| view.brightness / (view.brightness / view.covered + even);
        let all: f64 = seen.iter().map(weight).sum();
        let worth = |view: &&View| subpaths.per_sample() * weight(view) / all > view.in_focus;
        let power = |view: &View| Source { power: weight(view), origin: view.origin };
        VisibleLamps::new(seen.iter().filter(worth).map(power).collect(), subpaths)
    }

    /// How a lamp is seen. `None` where it is not in the picture, or where many of the camera rays that might
    /// meet it do.
    fn view_of(&self, lamp: &Lamp) -> Option<View> {
        let &Lamp { origin, area, radiance, bounds } = lamp;
        let project = |point| self.camera.project(point, [0.5; 2], self.time);
        let centre = project(bounds.centre())?;
        let (mut min, mut max) = (centre.film, centre.film);
        for corner in bounds.corners() {
            let [x, y] = project(corner)?.film;
            (min, max) = ([min[0].min(x), min[1].min(y)], [max[0].max(x), max[1].max(y)]);
        }
        let circle = self.camera.circle_of_confusion_radius(bounds.centre(), self.time).unwrap_or(0.0);
        let window = self.film.window;
        let is_shown = (0..2).all(|axis| {
            let begins = f64::from(window.offset[axis]);
            max[axis] + circle > begins && min[axis] - circle < begins + f64::from(window.size[axis])
        });
        let [width, height] = [0, 1].map(|axis| max[axis] - min[axis]);
        let per_area = centre.pixels_per_area(centre.toward_lens);
        let in_focus = (width * height).min(area * per_area);
        // A disk along the border makes the image larger. The border is at least there and back.
        let radius = circle.hypot(PIXEL);
        let covered = in_focus + radius * (2.0 * width.hypot(height) + PI * radius);
        let brightness = radiance * in_focus;
        let worth = is_shown && covered > SELDOM_MET * in_focus && brightness > 0.0;
        worth.then_some(View { origin, in_focus, covered, brightness })
    }

    /// The environment, where its light is so uneven that paths from the camera find much of it seldom.
    fn environment(&self, casters: &Casters) -> Option<Source> {
        let environment = self.lights.environment()?;
        if environment.unevenness() < WORTH_TRACING {
            return None;
        }
        // What enters the bodies, over the solid angle by which that of lights with a surface is more than
        // their weights say.
        let entering = 4.0 * PI * casters.cross_section() * environment.mean().integral(self.range);
        let from = |light: &Light| match light {
            Light::Area { geometry, .. } => {
                Some(casters.solid_angle_from(geometry.bounds([self.time; 2]).centre()))
            }
            _ => None,
        };
        let angles: Vec<f64> = self.lights.iter().filter_map(from).collect();
        let angle = if angles.is_empty() { PI } else { angles.iter().sum::<f64>() / angles.len() as f64 };
        let power = entering / angle;
        (power > 0.0 && power.is_finite()).then_some(Source { origin: Origin::Environment, power })
    }

    /// Whether it is not known within what a light subpath begins: what is behind an open surface that states
    /// a medium, or whose index others take account of, has no bounds.
    fn begins_unknown(&self) -> bool {
        let parts = |body: &Body| {
            let states = |filling| matches!(filling, Filling::Medium(_));
            states(body.interior)
                || states(body.exterior)
                || self.features.medium_stack && body.index.is_some()
        };
        self.bodies.iter().any(|body| !body.closed && parts(body))
    }

    /// Whether camera rays may pass surfaces to which others give precedence on their way to the first one
    /// that they meet: light subpaths would take these for opaque.
    fn is_seen_through_events(&self) -> bool {
        let is_air = |body: &Body| body.index_class == 0;
        self.features.interface_events() && (self.features.sensor_within || self.bodies.iter().any(is_air))
    }

    /// The lights that light subpaths begin at: those with a surface that is known to lie outside of all
    /// bodies.
    fn lamps(&self, surfaces: &[Surface]) -> Vec<Lamp> {
        let bodies: Vec<Bounds> =
            contact::body_boxes(self.groups, self.shift, self.shapes, self.boxes, surfaces, self.bodies)
                .collect();
        let begins = |(index, light): (u32, &Light)| {
            let Light::Area { geometry, mean, .. } = light else { return None };
            let around = geometry.bounds(self.during);
            let outside = geometry.is_whole() && !bodies.iter().any(|body| body.overlaps(around));
            let lamp = Lamp {
                origin: Origin::Surface { light: index, area: geometry.area() },
                area: geometry.world_area(self.time),
                radiance: mean.integral(self.range),
                bounds: geometry.bounds([self.time; 2]),
            };
            let power = lamp.source().power;
            (outside && power > 0.0 && power.is_finite()).then_some(lamp)
        };
        (0..).zip(self.lights.iter()).filter_map(begins).collect()
    }
}
