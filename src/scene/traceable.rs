//! A compiled scene: immutable, with only what is needed to trace it.

use crate::accel::Accel;
use crate::bsdf::Bsdf;
use crate::camera::{Camera, SensorRay};
use crate::film::{FilterKind, FilterSampler};
use crate::geometry::{Frame, Ray, SurfacePoint, Vec3};
use crate::integrator::{Integrator, Limits};
use crate::light::Lights;
use crate::material::Material;
use crate::medium::MediumStack;
use crate::sampling::{Dimensions, Stream};
use crate::shape::{Hit, Shape};
use crate::spectrum::colour::Observer;
use crate::spectrum::{Sampled, Spectrum, WavelengthDensity, Wavelengths};

/// Everything that rendering reads.
#[derive(Debug)]
pub struct Scene {
    pub camera: Camera,
    pub film: FilmPlan,
    pub observer: &'static Observer,
    pub integrator: Integrator,
    pub limits: Limits,
    pub wavelengths: WavelengthDensity,
    pub lights: Lights,
    /// Radiance from beyond the scene, the same from everywhere.
    pub environment: Option<Spectrum>,
    /// Of the order of the brightest light's contribution to Y: fixes the film's quantum.
    pub reference_radiance: f64,
    pub(super) needs: Needs,
    pub(super) accel: Accel,
    pub(super) shapes: Vec<Shape>,
    pub(super) surfaces: Vec<Surface>,
    pub(super) materials: Vec<Material>,
    pub(super) bodies: Vec<Body>,
}

/// The part of the film that is rendered.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmPlan {
    pub size: [u32; 2],
    /// Where the crop begins within the whole film.
    pub offset: [u32; 2],
    pub full_size: [u32; 2],
    pub filter: FilterKind,
    pub sample_border: bool,
    pub alpha: bool,
    /// The sensor's own channels, if it has any.
    pub channels: Vec<FilmChannel>,
}

/// A channel of the sensor: what it measures is the integral of spectral radiance over its response.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmChannel {
    pub name: String,
    pub response: Spectrum,
    /// Of the response over the range of wavelengths, nm. Above 0.
    pub integral: f64,
}

/// What begins a path.
#[derive(Clone, Copy, Debug)]
pub struct CameraSample<'a> {
    pub sensor: SensorRay<'a>,
    /// Weight of the film position by the filter: 1 on average.
    pub filter_weight: f64,
    /// The sample value that chooses the wavelengths.
    pub wavelength: f64,
}

/// What one shape's surface is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface {
    pub front: u32,
    /// The material seen from behind, for two-sided surfaces.
    pub back: Option<u32>,
    pub light: Option<u32>,
    /// What the surface encloses, if it is that of a transparent body.
    pub body: Option<u32>,
    /// Whether a material asks which way the surface's coordinates run.
    pub anisotropic: bool,
}

/// A transparent body.
#[derive(Clone, Debug)]
pub(super) struct Body {
    pub index: Spectrum,
    /// Per unit of length.
    pub absorption: Option<Spectrum>,
}

/// What the scene asks of the renderer. What it does not ask for is not done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Needs {
    /// Some surface parts wavelengths.
    pub dispersion: bool,
    /// Some body absorbs.
    pub absorption: bool,
    /// Some body may lie within another, or absorbs: paths keep account of what they are inside of.
    pub medium_stack: bool,
    pub lens: bool,
    /// Lights that are sampled at each vertex.
    pub light_samples: bool,
    pub rough_surfaces: bool,
}

impl std::fmt::Display for Needs {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let all = [
            ("dispersion", self.dispersion),
            ("absorption", self.absorption),
            ("medium stack", self.medium_stack),
            ("lens", self.lens),
            ("light samples", self.light_samples),
            ("rough surfaces", self.rough_surfaces),
        ];
        let list = |needed: bool| {
            let names: Vec<_> = all.iter().filter(|(_, n)| *n == needed).map(|(name, _)| *name).collect();
            if names.is_empty() { "nothing".to_owned() } else { names.join(", ") }
        };
        write!(f, "used: {}; skipped: {}", list(true), list(false))
    }
}

/// Where a ray meets a surface.
#[derive(Clone, Copy, Debug)]
pub struct Intersection {
    pub t: f64,
    pub point: SurfacePoint,
    /// Around the shading normal, which for the back of a two-sided surface is turned toward the viewer.
    pub frame: Frame,
    /// The light that the surface is, if it is one.
    pub light: Option<u32>,
    material: u32,
    body: Option<u32>,
}

impl Scene {
    pub fn needs(&self) -> Needs {
        self.needs
    }

    /// Where a pixel's samples fall on the film.
    pub fn filter_sampler(&self) -> FilterSampler {
        FilterSampler::new(self.film.filter, self.film.size, self.film.sample_border)
    }

    /// The ray of a pixel's sample. `None` where the sensor has nothing to measure at.
    pub fn camera_ray(
        &self,
        filter: &FilterSampler,
        pixel: [u32; 2],
        stream: &Stream,
    ) -> Option<CameraSample<'_>> {
        let [film_x, film_y, wavelength, _time] = stream.draw(Dimensions::Camera);
        let ([x, y], filter_weight) = filter.sample(pixel, [film_x, film_y]);
        let lens = if self.needs.lens {
            let [u, v, ..] = stream.draw(Dimensions::Lens);
            [u, v]
        } else {
            [0.5; 2]
        };
        let [left, top] = self.film.offset.map(f64::from);
        let sensor = self.camera.ray([x + left, y + top], lens)?;
        Some(CameraSample { sensor, filter_weight, wavelength })
    }

    /// Where a ray first meets a surface. Camera rays pass through hidden lights.
    pub fn intersect(&self, ray: &Ray, from_camera: bool) -> Option<Intersection> {
        let mut ray = *ray;
        let mut passed = 0.0;
        loop {
            let hit = self.meet(&ray)?;
            if !(from_camera && self.limits.hide_emitters && hit.light.is_some()) {
                return Some(Intersection { t: hit.t + passed, ..hit });
            }
            passed += hit.t;
            let origin = hit.point.leave(ray.direction);
            ray = Ray { origin, direction: ray.direction, t_max: ray.t_max - hit.t };
        }
    }

    fn meet(&self, ray: &Ray) -> Option<Intersection> {
        let hit: Hit = self.accel.closest(ray)?;
        let surface = self.surfaces[hit.shape as usize];
        let met = self.shapes[hit.shape as usize].surface(&hit, ray);
        let from_behind = ray.direction.dot(met.shading_normal) > 0.0;
        let (material, normal) = match surface.back {
            Some(back) if from_behind => (back, -met.shading_normal),
            _ => (surface.front, met.shading_normal),
        };
        let frame = if surface.anisotropic {
            let parametrisation = self.shapes[hit.shape as usize].parametrisation(&hit, met.point.position);
            Frame::with_tangent(normal, parametrisation.tangent)
        } else {
            Frame::around(normal)
        };
        Some(Intersection {
            t: hit.t,
            point: met.point,
            frame,
            light: surface.light,
            material,
            body: surface.body,
        })
    }

    /// Whether anything lies on a ray before its end.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.accel.occluded(ray)
    }

    /// The numbers of the surface's material at a path's wavelengths.
    pub fn bsdf<const C: usize>(
        &self,
        hit: &Intersection,
        media: &MediumStack,
        wavelengths: &Wavelengths<C>,
    ) -> Bsdf<C> {
        let around = match hit.body {
            Some(body) if self.needs.medium_stack => {
                media.around(body).map(|outer| &self.bodies[outer as usize].index)
            }
            _ => None,
        };
        self.materials[hit.material as usize].bsdf(&wavelengths.nm, around)
    }

    /// Keeps account of the body that a ray enters or leaves by passing through a surface.
    pub fn pass_through(&self, hit: &Intersection, direction: Vec3, media: &mut MediumStack) {
        let Some(body) = hit.body.filter(|_| self.needs.medium_stack) else { return };
        if direction.dot(hit.point.normal) < 0.0 {
            media.enter(body);
        } else {
            media.leave(body);
        }
    }

    /// The share that a stretch of what surrounds the ray lets through; `None` where nothing absorbs.
    pub fn transmittance<const C: usize>(
        &self,
        media: &MediumStack,
        distance: f64,
        wavelengths: &Wavelengths<C>,
    ) -> Option<Sampled<C>> {
        if !self.needs.absorption {
            return None;
        }
        let absorption = self.bodies[media.innermost()? as usize].absorption.as_ref()?;
        // What absorbs nothing lets everything through, over any distance.
        let share = |alpha: f64| if alpha > 0.0 { (-alpha * distance).exp() } else { 1.0 };
        Some(absorption.sample(&wavelengths.nm).map(share))
    }
}
