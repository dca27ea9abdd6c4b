//! A compiled scene: immutable, with only what is needed to trace it.

use super::coincident::{Contacts, InterfaceEvent, Onward};
use super::counting::{Counters, Query, RayKind};
use super::description::Note;
use super::features::Features;
use super::film_plan::{CameraSample, FilmPlan};
use super::intersection::Intersection;
use super::lanes::{EvenSurfaces, KnownSurface};
use super::{Integrator, Limits};
use crate::accel::{Accel, Fan};
use crate::bsdf::{Exterior, Specular};
use crate::camera::{Camera, SensorRay, Shutter};
use crate::film::FilterSampler;
use crate::geometry::{Frame, Points, Ray, Vec3};
use crate::lanes::{Mask, REGISTERS, Register, Row};
use crate::light::{Caustics, LightTracing, Lights, VisibleLamps};
use crate::material::{MaterialId, Materials, Shading, ShadingPoint};
use crate::medium::{Body, Media, Medium, MediumStack, Refraction};
use crate::sampling::{Dimensions, Stream};
use crate::shape::{AtRest, Hit, Parametrisation, Shape};
use crate::spectrum::colour::Observer;
use crate::spectrum::{WavelengthDensity, Wavelengths};
use crate::texture::{MeshPoint, TexturePoint};

/// Everything that rendering reads.
#[derive(Debug)]
pub struct Scene {
    /// Which rays the sensor measures.
    pub camera: Camera,
    /// When they are traced.
    pub shutter: Shutter,
    /// The film that is exposed.
    pub film: FilmPlan,
    /// The colour matching functions.
    pub observer: &'static Observer,
    /// How light is followed.
    pub integrator: Integrator,
    /// How far paths go.
    pub limits: Limits,
    /// Density by which wavelengths are chosen, nm⁻¹.
    pub wavelengths: WavelengthDensity,
    /// The lights, and the choice among them.
    pub lights: Lights,
    pub(super) light_tracing: Option<LightTracing>,
    /// About the brightest light's contribution to Y: fixes the film's quantum.
    pub reference_radiance: f64,
    pub(super) features: Features,
    /// What makes a picture of no use, as far as it is known before the first ray.
    pub warnings: Vec<Note>,
    pub(super) accel: Accel,
    /// Where a scene that counts does so.
    pub(super) counters: Option<Box<Counters>>,
    /// The scene's own shapes and then those of groups, which only instances show.
    pub(super) shapes: Vec<Shape>,
    pub(super) surfaces: Vec<Surface>,
    pub(super) materials: Materials,
    /// The triangles of a scene that consists of few, and what sides of surfaces look like all over.
    pub(super) known: Vec<KnownSurface>,
    pub(super) even: EvenSurfaces,
    pub(super) bodies: Vec<Body>,
    pub(super) contacts: Contacts,
    /// `None` where a medium does nothing.
    pub(super) media: Vec<Option<Medium>>,
    /// What the file says that is around the camera.
    pub(super) camera_medium: Option<u32>,
    pub(super) numbers: ShapeNumbers,
    /// Where the origin of the file's coordinates is.
    pub(super) shift: Vec3,
}

/// By which numbers images tell shapes apart.
#[derive(Clone, Debug, Default)]
pub(super) struct ShapeNumbers {
    /// Number of each surface.
    pub surfaces: Vec<u32>,
    /// Number of each instance; 0, or none at all, where the surface has one of its own.
    pub instances: Vec<u32>,
}

/// What one shape's surface is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface {
    pub material: MaterialId,
    pub light: Option<u32>,
    pub role: Role,
    /// Whether it is a part of a solid of the scene's own: which instance a moving part is says nothing of
    /// the body then.
    pub part: bool,
    /// What the surface encloses, if it is that of a transparent body.
    pub body: Option<u32>,
    /// Whether material or light ask for the surface's coordinates.
    pub parametrised: bool,
    /// Whether light may pass it by null transmission.
    pub null_transmission: bool,
    /// What light subpaths may follow in single directions.
    pub specular: Specular,
}

/// What a surface is among coincident ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// The boundary of what refracts, and nothing else.
    Interface,
    /// Null transmission: light passes as if there were no surface.
    Null,
    /// A surface that scatters, absorbs or emits.
    Other,
}

impl Scene {
    /// What the scene needs, and so what the renderer skips.
    pub fn features(&self) -> Features {
        self.features
    }

    /// Whether light passes surfaces by null transmission past the last segment of a path.
    pub fn goes_on_past_last(&self) -> bool {
        self.features.transparent_shadows && !self.limits.null_is_a_segment
    }

    /// The same scene, for which the renderer also does what `more` says and the scene has no need of. The
    /// picture is the same and takes longer: by how much is what leaving it out is worth.
    #[must_use]
    pub fn with_features(mut self, more: Features) -> Self {
        self.features = self.features.or(more);
        self
    }

    /// Where a pixel's samples fall on the film.
    pub fn filter_sampler(&self) -> FilterSampler {
        FilterSampler::new(self.film.filter, self.film.extent.window, self.film.sample_border)
    }

    /// The ray of a sample of a pixel of the whole film. `None` where the sensor has nothing to measure at.
    pub fn camera_ray(
        &self,
        filter: &FilterSampler,
        pixel: [u32; 2],
        stream: &Stream,
    ) -> Option<CameraSample<'_>> {
        let [film_x, film_y, wavelength, time] = stream.draw(Dimensions::Camera);
        let (place, _) = filter.sample(pixel, [film_x, film_y]);
        let time = self.shutter.time(time);
        let sensor = self.sensor_ray(place, time, stream)?;
        Some(CameraSample { sensor, wavelength, time })
    }

    /// The sample value that chooses between the materials of a path's n-th surface. 0 where no surface has
    /// several: then none is drawn.
    #[inline(always)]
    pub fn material_choice(&self, stream: &Stream, vertex: u32) -> f64 {
        if self.features.choices { stream.draw(Dimensions::Light(vertex))[3] } else { 0.0 }
    }

    /// The ray from a place on the film, in pixels from the whole film's corner, at a time. `None` where the
    /// sensor has nothing to measure at.
    pub fn sensor_ray(&self, place: [f64; 2], time: f64, stream: &Stream) -> Option<SensorRay<'_>> {
        let lens = if self.features.lens {
            let [u, v, ..] = stream.draw(Dimensions::Lens);
            [u, v]
        } else {
            [0.5; 2]
        };
        self.camera.ray(place, lens, time)
    }

    /// Where a ray first meets a surface. Camera rays pass through hidden lights. `cross` is told of each
    /// segment of the way, a ray that ends where it does, with what it leads through.
    #[inline]
    pub fn intersect(
        &self,
        ray: &Ray,
        time: f64,
        kind: RayKind,
        media: &mut Media,
        cross: impl FnMut(&MediumStack, &Ray),
    ) -> Option<Intersection> {
        self.intersect_within(ray, ray.t_max, time, kind, media, cross)
    }

    /// The same of a ray that need not be followed beyond `reach` if it comes there without meeting anything.
    #[inline]
    pub(super) fn intersect_within(
        &self,
        ray: &Ray,
        reach: f64,
        time: f64,
        kind: RayKind,
        media: &mut Media,
        mut cross: impl FnMut(&MediumStack, &Ray),
    ) -> Option<Intersection> {
        let hides = kind == RayKind::Camera && self.limits.hide_emitters;
        if !hides && !self.features.interface_events() {
            // What is large is made last, in the place where it stays: to move it costs as much as a shadow
            // ray.
            let hit = self.closest(kind.begins(), &Ray { t_max: reach, ..*ray }, time);
            cross(&media.here, &Ray { t_max: hit.as_ref().map_or(f64::INFINITY, |hit| hit.t), ..*ray });
            return hit.map(|hit| self.intersection(&hit, ray, time));
        }
        let mut ray = *ray;
        // Length of the way, and that of the part of it that leads through what the ray is in now, with where
        // that begins.
        let (mut passed, mut within, mut start) = (0.0, 0.0, ray);
        let (mut query, mut reach) = (kind.begins(), reach);
        let mut onward = Onward::default();
        loop {
            let found = self.meet(query, &Ray { t_max: reach.min(ray.t_max), ..ray }, time);
            query.begins = false;
            reach = f64::INFINITY;
            let Some(mut hit) = found else {
                cross(&media.here, &start);
                return None;
            };
            if !(hides && hit.light.is_some()) {
                let event = match self.features.interface_events() {
                    true => self.interface_event(&ray, time, &mut hit, media),
                    false => InterfaceEvent::Surface,
                };
                match event {
                    InterfaceEvent::Surface if !(hides && hit.light.is_some()) => {
                        cross(&media.here, &Ray { t_max: within + hit.t, ..start });
                        return Some(Intersection { t: hit.t + passed, ..hit });
                    }
                    InterfaceEvent::Surface | InterfaceEvent::Handled => {}
                    InterfaceEvent::NullTransmission => {
                        cross(&media.here, &Ray { t_max: within + hit.t, ..start });
                        media.cross();
                        passed += hit.t;
                        ray = onward.rest(&hit, &ray);
                        (within, start) = (0.0, ray);
                        continue;
                    }
                }
            }
            passed += hit.t;
            within += hit.t;
            ray = onward.rest(&hit, &ray);
        }
    }

    pub(super) fn meet(&self, query: Query, ray: &Ray, time: f64) -> Option<Intersection> {
        self.closest(query, ray, time).map(|hit| self.intersection(&hit, ray, time))
    }

    /// All about a hit.
    #[inline]
    pub(super) fn intersection(&self, hit: &Hit, ray: &Ray, time: f64) -> Intersection {
        let surface = &self.surfaces[hit.shape as usize];
        let found = self.accel.surface(&self.shapes, hit, ray, time);
        Intersection {
            t: hit.t,
            point: found.point,
            shading_normal: found.shading_normal,
            light: surface.light,
            hit: *hit,
            time,
            from_front: ray.direction.dot(found.point.normal) < 0.0,
            coincident: false,
        }
    }

    /// How the surface scatters at a path's wavelengths. `choice` in [0, 1) chooses between the materials of
    /// a surface that has several.
    pub fn shade<const C: usize>(
        &self,
        hit: &Intersection,
        toward_eye: Vec3,
        media: &Media,
        wavelengths: &Wavelengths<C>,
        choice: f64,
    ) -> Shading<C> {
        let surface = self.surface(hit);
        let exterior = self.exterior(hit, media);
        let at = self.shading_point(hit);
        self.materials.shade(surface.material, &at, toward_eye, &wavelengths.nm, exterior, choice)
    }

    /// A place in the coordinates of the file.
    pub fn in_file(&self, position: Vec3) -> Vec3 {
        position - self.shift
    }

    /// The surface's coordinates at a hit and its tangents along them, whether or not anything asks for them.
    pub fn coordinates(&self, hit: &Intersection) -> Parametrisation {
        self.accel.parametrisation(&self.shapes, &hit.hit, hit.point.position, hit.time).0
    }

    /// The number of the shape that was met, from 1: that of the instance that shows it, if one does.
    pub fn shape_number(&self, hit: &Intersection) -> u32 {
        let instance = self.accel.own_instance(hit.hit.instance);
        let instance = self.numbers.instances.get(instance as usize).copied().unwrap_or(0);
        if instance > 0 { instance } else { self.numbers.surfaces[hit.hit.shape as usize] }
    }

    /// Which triangle, segment, patch or part of its shape was met, from 0.
    pub fn primitive_number(&self, hit: &Intersection) -> u32 {
        hit.hit.triangle
    }

    /// What tells the material that was met from others, from 1.
    pub fn material_number(&self, hit: &Intersection) -> u32 {
        self.surface(hit).material + 1
    }

    /// What is traced from the lights, where anything is.
    pub fn light_tracing(&self) -> Option<&LightTracing> {
        self.light_tracing.as_ref()
    }

    /// The part of it that finds caustics.
    pub fn caustics(&self) -> Option<&Caustics> {
        self.light_tracing.as_ref()?.caustics.as_ref()
    }

    /// The part of it that finds lamps in the picture.
    pub fn visible_lamps(&self) -> Option<&VisibleLamps> {
        self.light_tracing.as_ref()?.visible_lamps.as_ref()
    }

    /// Whether light subpaths go on from a surface in single directions.
    pub fn is_specular(&self, hit: &Intersection) -> bool {
        matches!(self.surface(hit).specular, Specular::Coat | Specular::All)
    }

    /// Whether light subpaths go on from a surface in nearly single directions.
    pub fn is_nearly_specular(&self, hit: &Intersection) -> bool {
        self.surface(hit).specular == Specular::Nearly
    }

    /// Whether anything at all is in the way of a ray.
    pub fn is_occluded(&self, ray: &Ray, time: f64, kind: RayKind) -> bool {
        self.occluded(kind.begins(), ray, time)
    }

    /// Surface points of some lanes that are to be asked what they see of others.
    pub fn fan(&self, points: &[Points<Register>; REGISTERS], facets: &Row, lanes: Mask) -> Fan<'_> {
        self.accel.fan(points, facets, lanes)
    }

    /// Keeps account of the body that a ray enters or leaves by passing through a surface.
    pub fn pass_through(&self, hit: &Intersection, direction: Vec3, media: &mut Media) {
        if !self.features.medium_stack {
            return;
        }
        let enters = direction.dot(hit.point.normal) < 0.0;
        if self.features.interface_events() {
            if enters == hit.from_front {
                media.cross();
            }
            return;
        }
        let Some(body) = self.body_of(&hit.hit) else { return };
        if enters {
            media.here.enter(body, &self.bodies);
        } else {
            media.here.leave(body, &self.bodies);
        }
    }

    /// What a sensor's ray begins in.
    pub fn media_at_sensor(&self, ray: &Ray, time: f64) -> Media {
        let mut here = MediumStack::outside(self.camera_medium);
        if self.features.sensor_within {
            let mut within = MediumStack::default();
            self.bodies_around(ray, time, &mut within);
            // What the file says of the medium there is believed.
            if self.camera_medium.is_none_or(|medium| within.medium(&self.bodies) == Some(medium)) {
                here = within;
            }
        }
        Media::of(here)
    }

    pub(super) fn surface(&self, hit: &Intersection) -> &Surface {
        &self.surfaces[hit.hit.shape as usize]
    }

    /// What the surface at a hit has on its other side, for bodies that leave it open.
    pub(super) fn exterior(&self, hit: &Intersection, media: &Media) -> Exterior<'_> {
        let Some(body) = self.body_of(&hit.hit).filter(|_| self.features.medium_stack) else {
            return Exterior::UNKNOWN;
        };
        let index = match self.features.interface_events() {
            true => media.index_outside(hit.from_front, &self.bodies),
            false => media.here.index_around(body, !hit.from_front, &self.bodies),
        };
        // What a body of a priority says of its outside holds where nothing else is.
        let counts = self.bodies[body.body as usize].refraction == Refraction::Surroundings;
        Exterior { index, coincident: hit.coincident || counts && index.is_some() }
    }

    pub(super) fn shading_point(&self, hit: &Intersection) -> ShadingPoint<'_> {
        let normal = hit.shading_normal;
        let (parametrisation, at_rest) = self.parametrisation(hit);
        let Parametrisation { uv, tangent, bitangent } = parametrisation;
        let parametrised = self.surface(hit).parametrised;
        ShadingPoint {
            frame: if parametrised { Frame::with_tangent(normal, tangent) } else { Frame::around(normal) },
            geometric_normal: hit.point.normal,
            tangents: [tangent, bitangent],
            texture: self.texture_point_with(hit, uv, at_rest),
        }
    }

    /// Where a texture of the surface is looked up.
    pub fn texture_point(&self, hit: &Intersection) -> TexturePoint<'_> {
        let (Parametrisation { uv, .. }, at_rest) = self.parametrisation(hit);
        self.texture_point_with(hit, uv, at_rest)
    }

    fn texture_point_with(&self, hit: &Intersection, uv: [f64; 2], at_rest: AtRest) -> TexturePoint<'_> {
        let mesh = match &self.shapes[hit.hit.shape as usize] {
            Shape::Mesh(mesh) => {
                Some(MeshPoint { mesh, triangle: hit.hit.triangle, barycentric: hit.hit.barycentric })
            }
            _ => None,
        };
        TexturePoint { uv, position: hit.point.position, at_rest, mesh }
    }

    /// All zero where nothing asks for it.
    fn parametrisation(&self, hit: &Intersection) -> (Parametrisation, AtRest) {
        if !self.surface(hit).parametrised {
            return (Parametrisation::NONE, AtRest::NONE);
        }
        self.accel.parametrisation(&self.shapes, &hit.hit, hit.point.position, hit.time)
    }
}
