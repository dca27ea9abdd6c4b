//! Lights: what is sampled, and what their emission asks of the wavelengths and of the film.

use super::Compiler;
use super::spectra;
use crate::accel::Accel;
use crate::geometry::{Bounds, Motion, Placed, Ray, SurfacePoint, Transform, Vec3};
use crate::light::sky::{self, Sky, SkySettings};
use crate::light::{AreaGeometry, Environment, EnvironmentMap, Light, Lights, Projector, Spot, Texel};
use crate::medium;
use crate::raster::Image;
use crate::scene::FilmPlan;
use crate::scene::description::{LightKind, SpectrumKind, SpectrumSource};
use crate::scene::source::{Place, SceneError};
use crate::shape::{NO_INSTANCE, Shape};
use crate::spectrum::colour::MITSUBA_Y_INTEGRAL;
use crate::spectrum::{Emission, Response, Spectrum, WavelengthDensity};
use crate::texture::Texture;
use glam::{DMat3, DMat4};
use rayon::prelude::*;
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

impl Compiler<'_> {
    /// `carried`: where the shape is carried to, if it moves.
    pub(super) fn area_light(
        &mut self,
        shape: &Shape,
        carried: Option<Placed>,
        radiance: &SpectrumSource,
    ) -> Light {
        let radiance = self.texture(radiance);
        let geometry = Box::new(match carried {
            None => AreaGeometry::new(shape.clone(), radiance.varies()),
            Some(placed) => AreaGeometry::carried(shape.clone(), radiance.varies(), placed),
        });
        Light::Area { geometry, mean: radiance.mean_spectrum(self.options.range), radiance }
    }

    /// Lights that are no shape's surface; returns that from beyond the scene, and where those stand that
    /// move.
    pub(super) fn other_lights(
        &mut self,
        lights: &mut Vec<Light>,
        shift: &Transform,
    ) -> (Option<Environment>, Vec<(usize, Placed)>) {
        let (mut environment, mut moving) = (None, Vec::new());
        for light in &self.description.lights {
            let motion = light.kind.motion().and_then(|motion| Motion::new(&motion.keys).ok());
            let placed =
                motion.and_then(|m| Placed::moving(m.recentred(Vec3::ZERO, shift.point(Vec3::ZERO))));
            // What moves has coordinates of its own, which its motion takes to the scene's.
            let carried = placed.is_some();
            moving.extend(placed.map(|placed| (lights.len(), placed)));
            let stand = |to_world: &Transform| {
                if carried { Transform::IDENTITY } else { to_world.then(shift) }
            };
            lights.push(match &light.kind {
                LightKind::Point { position, intensity, .. } => {
                    let intensity = self.spectrum(intensity);
                    let position = if carried { Vec3::ZERO } else { shift.point(*position) };
                    Light::Point { position, intensity }
                }
                LightKind::Spot { to_world, intensity, cutoff_angle, beam_width, texture, .. } => {
                    let intensity = self.spectrum(intensity);
                    let [cutoff, beam] = [cutoff_angle, beam_width].map(|angle| angle.to_radians());
                    let spot = Spot::new(&stand(to_world), intensity, cutoff, beam);
                    Light::Spot(Box::new(match texture {
                        Some(slide) => spot.with_slide(self.texture(slide)),
                        None => spot,
                    }))
                }
                LightKind::Projector { to_world, irradiance, scale, field_of_view, .. } => {
                    let picture = self.texture(irradiance);
                    let size = picture.resolution().map(f64::from);
                    let across = super::sensors::tan_half_width(*field_of_view, size);
                    let tan_half = [across, across * size[1] / size[0]];
                    let mean = picture.mean_spectrum(self.options.range);
                    let projector = Projector::new(&stand(to_world), picture, &mean, *scale, tan_half);
                    Light::Projector(Box::new(projector))
                }
                LightKind::Directional { travels, irradiance, .. } => {
                    let travels = if carried { Vec3::Z } else { travels.normalize() };
                    Light::Directional { travels, irradiance: self.spectrum(irradiance) }
                }
                LightKind::Constant { radiance } => {
                    environment = Some(Environment::Constant(self.spectrum(radiance)));
                    continue;
                }
                LightKind::EnvironmentMap { to_world, image, scale, .. } => {
                    environment = Some(self.environment_map(&light.place, to_world, image, *scale));
                    continue;
                }
                sky @ LightKind::SunSky { .. } => {
                    environment = Some(self.sky(sky));
                    continue;
                }
            });
        }
        (environment, moving)
    }

    /// A picture is seen under D65.
    fn environment_map(
        &mut self,
        place: &Place,
        to_world: &Transform,
        image: &Image,
        scale: f64,
    ) -> Environment {
        let illuminant =
            self.spectrum(&SpectrumSource { place: place.clone(), kind: SpectrumKind::D65, scale });
        let texel = |values: &[f32]| {
            let light = |channel: usize| image.light(values[channel % image.channels]).max(0.0);
            Texel::from_rgb([light(0), light(1), light(2)])
        };
        let texels: Vec<Texel> = image.values.par_chunks_exact(image.channels).map(texel).collect();
        let (size, texels) = match texels.as_slice() {
            // The same from everywhere.
            [only] => ([2, 2], vec![*only; 4]),
            _ => ([image.width, image.height], texels),
        };
        match EnvironmentMap::new(size, texels, illuminant, rotation(to_world)) {
            Some(map) if scale > 0.0 => Environment::Map(Box::new(map)),
            _ => Environment::Constant(Spectrum::ZERO),
        }
    }

    fn sky(&mut self, kind: &LightKind) -> Environment {
        let LightKind::SunSky {
            to_world,
            turbidity,
            albedo,
            sun_direction,
            sky_scale,
            sun_scale,
            sun_aperture,
            complex_sun,
        } = kind
        else {
            return Environment::Constant(Spectrum::ZERO);
        };
        let albedo = self.spectrum(albedo);
        let to_world = rotation(to_world);
        let settings = SkySettings {
            turbidity: *turbidity,
            albedo: sky::wavelengths().map(|nm| albedo.at(nm)),
            sun_direction: to_world.inverse().vector(*sun_direction).normalize(),
            sky_scale: *sky_scale,
            sun_scale: *sun_scale,
            sun_aperture: *sun_aperture,
            complex_sun: *complex_sun,
        };
        match Sky::new(&settings, to_world) {
            Some(sky) => Environment::Sky(Box::new(sky)),
            None => Environment::Constant(Spectrum::ZERO),
        }
    }

    pub(super) fn refuse_lights_that_a_walk_misses(&mut self) {
        for light in &self.description.lights {
            if !light.kind.is_environment() {
                self.errors.push(
                    SceneError::at(
                        &light.place,
                        "the integrator `walk` cannot find a light without extent",
                        "no ray ever meets this light",
                    )
                    .with_remedy("use the integrator `path`, or an area light"),
                );
            }
        }
    }

    /// What sensor and lights make of the wavelengths.
    pub(super) fn wavelengths(
        &self,
        responses: &[(Spectrum, f64)],
        lights: &[Light],
        environment: Option<&Environment>,
        media: &[&medium::Emission],
        scene_radius: f64,
    ) -> WavelengthDensity {
        let own = lights.iter().map(|light| (light.spectrum(), power(light, scene_radius)));
        let around = environment.map(|environment| surroundings(environment, scene_radius));
        let depth = depth_of_media(scene_radius);
        let glowing = media.iter().map(|emission| emission.typical(self.options.range, depth));
        let glowing: Vec<Spectrum> = glowing.collect();
        let between = glowing.iter().map(|spectrum| (spectrum, PI * 4.0 * PI * depth * depth));
        let all = own.chain(around).chain(between);
        let emissions: Vec<Emission> = all.map(|(spectrum, weight)| Emission { spectrum, weight }).collect();
        let sensor: Vec<Response> =
            responses.iter().map(|(spectrum, weight)| Response { spectrum, weight: *weight }).collect();
        WavelengthDensity::new(self.options.range, &sensor, &emissions)
    }

    /// The value whose order of magnitude the film's sums are made for: the brightest of what the camera can
    /// see, in luminance, or in the mean over a response or over the wavelengths. What is brighter than 2²²
    /// times that does not fit; what is darker than 2⁻⁴⁰ times that is rounded at random.
    pub(super) fn reference(
        &self,
        film: &FilmPlan,
        lights: &Lights,
        media: &[&medium::Emission],
        lit: &Lit,
    ) -> f64 {
        let &Lit { accel, bounds, eyes, time, .. } = lit;
        let scene_radius = radius(bounds);
        /// Spots that are so many times as bright as the whole fit beside it.
        const HEAD: f64 = 256.0;
        /// Rays for all lights that need them.
        const MOST_RAYS: usize = 1 << 20;
        /// A path's wavelength may bring all of its light to one of many bins.
        const BINS: f64 = 64.0;
        /// A lamp that fills less than this share of all directions, from wherever it is seen, is all but
        /// never met by chance: what it lights is so much darker than itself that the film keeps to that.
        const TINY: f64 = 1.0 / (1u64 << 30) as f64;
        /// A few samples that meet a lamp nevertheless fit.
        const LEAST: f64 = 1.0 / (1u64 << 20) as f64;
        let luminance = |spectrum: &Spectrum| {
            let y = self.options.observer.xyz_of(spectrum, self.options.range).y / MITSUBA_Y_INTEGRAL;
            let responses = film.channels.iter().map(|channel| {
                self.product(spectrum, &channel.response).integral(self.options.range) / channel.integral
            });
            // Few wavelengths hold little luminance, while their bins measure no less.
            let in_bins = BINS * spectrum.integral(self.options.range) / self.options.range.width();
            responses.fold(if self.options.spectral { y.max(in_bins) } else { y }, f64::max)
        };
        // The share of all directions that it fills from so far away.
        let share = |geometry: &AreaGeometry, distance: f64| {
            geometry.world_area(time) / (4.0 * PI * distance * distance)
        };
        let is_tiny =
            |geometry: &AreaGeometry| share(geometry, 2.0 * scene_radius) < TINY && !eyes.is_empty();
        let needs_rays = |light: &&Light| match light {
            Light::Area { geometry, .. } => is_tiny(geometry),
            Light::Point { .. } | Light::Spot(_) | Light::Projector(_) => true,
            Light::Directional { .. } => false,
        };
        let rays = (MOST_RAYS / lights.iter().filter(needs_rays).count().max(1)).clamp(1, 256) as u32;
        let spread = |light: usize| {
            let Some(position) = lights.place(light, time) else { return PI };
            // A floor may reach far, and what a light shines upon be near it, but no nearer than the scene.
            let far = (scene_radius / 64.0).max(bounds.gap(Bounds::of([position])));
            // Next to the lamp, a surface that it lies in is lit edge-on.
            let beyond = if lights.flush(light).is_empty() { 0.0 } else { scene_radius / 4096.0 };
            let near = nearest(accel, position, beyond, time, rays).clamp(far / 4096.0, far);
            4.0 * PI * (near * near).max(f64::MIN_POSITIVE)
        };
        let darker = |geometry: &AreaGeometry| {
            if !is_tiny(geometry) {
                return 1.0;
            }
            let (centre, radius) = geometry.ball(time);
            let eye = Bounds::of([centre]).gap(eyes).max(0.0);
            let near = nearest(accel, centre, 2.0 * radius, time, rays).min(scene_radius / 4.0);
            (share(geometry, eye.min(near)) / TINY).clamp(LEAST, 1.0)
        };
        // There may be very many lights, and few that differ in their spectra.
        let mut known = HashMap::new();
        let mut luminance_of = |spectrum: &Spectrum| match spectrum.identity() {
            Some(key) => *known.entry(key).or_insert_with(|| luminance(spectrum)),
            None => luminance(spectrum),
        };
        let seen = lights.iter().enumerate().map(|(index, light)| {
            luminance_of(light.spectrum())
                * match light {
                    Light::Area { geometry, radiance, mean } => {
                        let range = self.options.range;
                        let peak = match radiance {
                            Texture::Uniform(_) => 1.0,
                            _ => radiance.max_bound(range) / mean.bounds(range).1,
                        };
                        let peak = if peak.is_finite() { (peak / HEAD).max(1.0) } else { 1.0 };
                        peak * darker(geometry)
                    }
                    Light::Point { .. }
                    | Light::Spot(_)
                    | Light::Projector(_)
                    | Light::Directional { .. } => 1.0 / spread(index),
                }
        });
        let around = lights
            .environment()
            .map(|environment| luminance(environment.mean()) * (environment.peak() / HEAD).max(1.0));
        let depth = depth_of_media(scene_radius);
        let between = media.iter().map(|emission| luminance(&emission.typical(self.options.range, depth)));
        seen.chain(around).chain(between).fold(0.0, f64::max)
    }

    fn texture(&mut self, source: &SpectrumSource) -> Texture {
        let key = match &source.kind {
            SpectrumKind::Rgb { rgb: [r, g, b], role } => {
                Some(([*r, *g, *b, source.scale].map(f64::to_bits), *role as u8))
            }
            _ => None,
        };
        if let Some(known) = key.and_then(|key| self.colours.get(&key)) {
            return known.clone();
        }
        match spectra::texture(source, &self.shift) {
            Ok(texture) => {
                self.colours.extend(key.map(|key| (key, texture.clone())));
                texture
            }
            Err(error) => {
                self.errors.push(error);
                Texture::Uniform(Spectrum::ZERO)
            }
        }
    }
}

/// The rotation (and mirroring) that a transform written with few digits stands for.
fn rotation(to_world: &Transform) -> Transform {
    let DMat3 { x_axis, y_axis, z_axis } = DMat3::from_mat4(to_world.matrix());
    let x = x_axis.normalize();
    let y = (y_axis - x * x.dot(y_axis)).normalize();
    let z = (z_axis - x * x.dot(z_axis) - y * y.dot(z_axis)).normalize();
    Transform::new(DMat4::from_mat3(DMat3::from_cols(x, y, z))).unwrap_or(Transform::IDENTITY)
}

/// Order of magnitude of the power that a light sends into the scene, over its spectrum's values.
fn power(light: &Light, scene_radius: f64) -> f64 {
    match light {
        Light::Area { geometry, .. } => PI * geometry.area(),
        Light::Point { .. } => 4.0 * PI,
        Light::Spot(spot) => spot.solid_angle(),
        Light::Projector(projector) => projector.solid_angle(),
        Light::Directional { .. } => PI * scene_radius * scene_radius,
    }
}

/// About how far one sees into a medium that sends out light.
fn depth_of_media(scene_radius: f64) -> f64 {
    0.25 * scene_radius
}

/// That of a sphere around a scene. Where nothing has a size, a unit stands for it: a sky over nothing is
/// seen all the same.
pub(super) fn radius(bounds: Bounds) -> f64 {
    let radius = 0.5 * bounds.diameter();
    if radius > 0.0 { radius } else { 1.0 }
}

/// A box around the lights without a surface that have a place, of which some move.
pub(super) fn places(lights: &[Light], moving: &[(usize, Placed)], during: [f64; 2]) -> Bounds {
    let placed: HashMap<usize, &Placed> = moving.iter().map(|(light, placed)| (*light, placed)).collect();
    Bounds::of_all(lights.iter().enumerate().filter_map(|(index, light)| {
        let place = Bounds::of([light.place()?]);
        Some(placed.get(&index).map_or(place, |placed| placed.bounds(place, during)))
    }))
}

/// The same for light from all around.
fn surroundings(environment: &Environment, scene_radius: f64) -> (&Spectrum, f64) {
    (environment.mean(), PI * 4.0 * PI * scene_radius * scene_radius)
}

/// What lights shine upon.
pub(super) struct Lit<'a> {
    /// Says what lights without extent, and small ones, may be near.
    pub accel: &'a Accel,
    pub shapes: &'a [Shape],
    /// Around all that they may shine upon.
    pub bounds: Bounds,
    /// Where camera rays begin.
    pub eyes: Bounds,
    /// When it is looked at.
    pub time: f64,
}

impl Lit<'_> {
    /// The surfaces through a place, to within what they are rounded by, each with twice as much for its
    /// error.
    pub fn surfaces_through(&self, place: Vec3) -> Vec<SurfacePoint> {
        /// Vertices of meshes have single precision: each coordinate is off by at most so large a part of it.
        const ROUNDED: f64 = 1.0 / (1u64 << 24) as f64;
        let of_meshes = 4.0 * ROUNDED * radius(self.bounds);
        let mut found: Vec<SurfacePoint> = Vec::new();
        // A plane so near to the place crosses one of the axes near it.
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            let ray = Ray { origin: place - 2.0 * of_meshes * axis, direction: axis, t_max: 4.0 * of_meshes };
            let Some(hit) = self.accel.closest(&ray, self.time) else { continue };
            let SurfacePoint { position, normal, error } =
                self.accel.surface(self.shapes, &hit, &ray, self.time).point;
            let of_vertices = match &self.shapes[hit.shape as usize] {
                Shape::Mesh(_) if hit.instance != NO_INSTANCE => of_meshes,
                Shape::Mesh(mesh) => {
                    let corners = mesh.triangle(hit.triangle).map(Vec3::abs);
                    let largest = corners.into_iter().fold(Vec3::ZERO, Vec3::max);
                    ROUNDED * largest.dot(normal.abs())
                }
                _ => 0.0,
            };
            let rounded = of_vertices + 8.0 * error;
            let is_known = found.iter().any(|known| known.normal.dot(normal).abs() > 1.0 - 1e-9);
            if !is_known && (place - position).dot(normal).abs() <= rounded {
                found.push(SurfacePoint { position, normal, error: 2.0 * rounded });
            }
        }
        found
    }
}

/// About how far the nearest surface is from a place, leaving out those within a distance, by so many rays in
/// directions that are spread evenly (a Fibonacci lattice on the sphere).
fn nearest(accel: &Accel, place: Vec3, beyond: f64, time: f64, rays: u32) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let distance = |i: u32| {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(rays);
        let (sin, cos) = (TAU * (f64::from(i) * GOLDEN).fract()).sin_cos();
        let across = (1.0 - z * z).sqrt();
        let direction = Vec3::new(across * cos, across * sin, z);
        let hit = accel.closest(&Ray::new(place + beyond * direction, direction), time);
        hit.map_or(f64::INFINITY, |hit| beyond + hit.t)
    };
    (0..rays).map(distance).fold(f64::INFINITY, f64::min)
}
