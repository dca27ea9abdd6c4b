//! Lights: what they emit, and how a point on one is chosen for a place that it may light.
//!
//! A light sample chooses an emitter, in proportion to a cheap estimate of what it can contribute to the
//! place, and a point on it (`choice`). Both by the same two sample values, so that samples that are well
//! spread are so over all of the lights.

mod aim;
mod area;
mod casters;
mod caustics;
mod choice;
mod environment;
mod environment_map;
mod guide;
mod lamps;
mod lanes;
mod projector;
pub mod sky;
mod spot;
#[cfg(test)]
mod tests;
mod tracing;
mod tree;
mod visible_lamps;

pub use aim::Aim;
pub use area::AreaGeometry;
pub use casters::{Caster, Casters, CastersByKind};
pub use caustics::Caustics;
pub use choice::Setting;
pub use environment::Environment;
pub use environment_map::{EnvironmentMap, EnvironmentSamples, Texel};
pub use lamps::LampLight;
pub use lanes::{LightSamples, Lit, Receivers};
pub use projector::Projector;
pub use sky::Sky;
pub use spot::Spot;
pub use tracing::{LightTracing, Origin, Source, Subpaths, USUAL_SAMPLES_PER_PATH};
pub use visible_lamps::VisibleLamps;

use crate::geometry::{Bounds, Placed, Ray, SurfacePoint, Vec3};
use crate::lanes::{Real, Vector};
use crate::sampling::Density;
use crate::spectrum::{Sampled, Spectrum, Wavelengths};
use crate::texture::{Texture, TexturePoint};
use choice::{Choice, Chosen};
use guide::Guides;
use lamps::Lamps;
use rayon::prelude::*;
use std::collections::BTreeMap;
use tree::Bound;

/// A light within the scene, or one whose light comes from one direction.
#[derive(Clone, Debug)]
pub enum Light {
    /// Radiance of a surface's front, W·m⁻²·sr⁻¹·nm⁻¹, and about the mean of it over the surface: above 0 at
    /// every wavelength at which any of it shines.
    Area {
        /// The surface.
        geometry: Box<AreaGeometry>,
        /// Radiance by place.
        radiance: Texture,
        /// About the mean of the radiance over the surface.
        mean: Spectrum,
    },
    /// Radiant intensity, W·sr⁻¹·nm⁻¹.
    Point {
        /// Where it is, in scene units.
        position: Vec3,
        /// Radiant intensity by wavelength.
        intensity: Spectrum,
    },
    /// A point that shines into a cone.
    Spot(Box<Spot>),
    /// A picture thrown from a point.
    Projector(Box<Projector>),
    /// Irradiance across the direction of travel, W·m⁻²·nm⁻¹.
    Directional {
        /// Unit vector along which the light goes.
        travels: Vec3,
        /// Irradiance by wavelength.
        irradiance: Spectrum,
    },
}

/// A point on a light and what comes from there.
#[derive(Clone, Copy, Debug)]
pub struct LightSample<const C: usize> {
    /// Ray from the lit surface to just before the light.
    pub shadow_ray: Ray,
    /// Radiance, or irradiance across the ray for a light without extent. For the latter it is divided by the
    /// probability of the choice already.
    pub radiance: Sampled<C>,
    /// Density of the sample per steradian, or that it is one of finitely many.
    pub density: Density,
}

impl<const C: usize> LightSample<C> {
    /// The same where it is taken with some probability alone.
    pub fn taken_with(self, probability: f64) -> Self {
        match self.density {
            Density::PerSolidAngle(density) => {
                Self { density: Density::PerSolidAngle(probability * density), ..self }
            }
            Density::Discrete => Self { radiance: self.radiance / probability, ..self },
        }
    }
}

/// A point of a light's surface and what it emits.
#[derive(Clone, Copy, Debug)]
pub struct Emitted<const C: usize> {
    /// The point of the light, as what arrives there would meet it.
    pub hit: LightHit,
    /// Radiance of the point toward the receiver, W·m⁻²·sr⁻¹·nm⁻¹.
    pub radiance: Sampled<C>,
    /// Density of the point, per unit of area.
    pub density: f64,
}

/// A place that lights may light.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    /// The lit point.
    pub point: SurfacePoint,
    /// The side from which light counts, of unit length; zero where light from anywhere does.
    pub facing: Vec3,
}

/// A point of a light that a ray has met.
#[derive(Clone, Copy, Debug)]
pub struct LightHit {
    /// Index among the scene's lights.
    pub light: u32,
    /// The point that was met.
    pub point: SurfacePoint,
    /// Number of the triangle, as in [`crate::shape::Hit`].
    pub triangle: u32,
    /// Weights of the triangle's second and third vertex; 0 for other shapes.
    pub barycentric: [f64; 2],
}

/// Wavelengths at which textures are looked at to guide light samples.
const GUIDED: usize = 8;

/// The lights of a scene.
#[derive(Clone, Debug, Default)]
pub struct Lights {
    lights: Vec<Light>,
    /// Where lights without a surface stand over time, by light, as far as there is one that moves. What the
    /// light says is then in coordinates of its own.
    placed: Vec<Option<Placed>>,
    /// See [`Self::flush`]; those without are left out.
    flush: BTreeMap<usize, Vec<SurfacePoint>>,
    environment: Option<Environment>,
    choice: Choice,
    /// Where there are few lights, of kinds that are sampled for several surfaces at once.
    lamps: Option<Lamps>,
}

impl Lights {
    /// `moving`: lights without a surface that move, by their indices. They must not scale.
    pub fn new(
        mut lights: Vec<Light>,
        environment: Option<Environment>,
        moving: Vec<(usize, Placed)>,
        setting: &Setting,
    ) -> Self {
        let mut placed = Vec::new();
        for (light, place) in moving {
            placed.resize(lights.len(), None);
            placed[light] = Some(place);
        }
        let nm = setting.nm::<GUIDED>();
        for light in &mut lights {
            if let Light::Area { geometry, radiance, .. } = light
                && radiance.varies()
            {
                geometry.follow(radiance, &nm, setting.during[0]);
            }
        }
        let mut all = Self { lights, placed, environment, ..Self::default() };
        all.choice = Choice::new(&all, setting);
        all.lamps = Lamps::new(&all);
        all
    }

    fn placed(&self, light: usize) -> Option<&Placed> {
        self.placed.get(light)?.as_ref()
    }

    /// Says which surfaces lie through lights without extent that do not move: by place.
    pub fn set_flush(&mut self, surfaces: impl Fn(Vec3) -> Vec<SurfacePoint> + Sync) {
        let of = |light: usize| {
            let place = self.lights[light].place().filter(|_| self.placed(light).is_none())?;
            Some((light, surfaces(place))).filter(|(_, found)| !found.is_empty())
        };
        self.flush = (0..self.lights.len()).into_par_iter().filter_map(of).collect();
    }

    /// The surfaces that lie through a light without extent, each with how far from it the light is to be
    /// taken to stand: on the side of what it lights. Rounding would decide on which side it stands, and a
    /// lamp at the height of the ceiling light nothing.
    pub fn flush(&self, light: usize) -> &[SurfacePoint] {
        self.flush.get(&light).map_or(&[], Vec::as_slice)
    }

    /// Where a light without a surface stands at a time. `None` for others, and those that are far away.
    pub fn place(&self, light: usize, time: f64) -> Option<Vec3> {
        let own = self.lights[light].place()?;
        Some(self.placed(light).map_or(own, |placed| placed.at(time).world_point(own)))
    }

    /// Whether there is nothing to sample.
    pub fn is_empty(&self) -> bool {
        self.choice.is_empty()
    }

    /// The lights but for the environment.
    pub fn iter(&self) -> impl Iterator<Item = &Light> {
        self.lights.iter()
    }

    /// The light that comes from beyond the scene, if there is any.
    pub fn environment(&self) -> Option<&Environment> {
        self.environment.as_ref()
    }

    /// What an area light emits from its front, at a point of it.
    pub fn radiance<const C: usize>(&self, light: u32, at: &TexturePoint, nm: &[f64; C]) -> Sampled<C> {
        match &self.lights[light as usize] {
            Light::Area { radiance, .. } => radiance.sample(at, nm),
            Light::Point { .. } | Light::Spot(_) | Light::Projector(_) | Light::Directional { .. } => {
                Sampled::ZERO
            }
        }
    }

    /// A point of an area light's front and what it emits at the wavelengths (nm) of a path. `None` for other
    /// lights.
    pub fn emit<const C: usize>(
        &self,
        light: u32,
        u: [f64; 2],
        time: f64,
        nm: &[f64; C],
    ) -> Option<Emitted<C>> {
        let Light::Area { geometry, radiance, .. } = &self.lights[light as usize] else { return None };
        let sample = geometry.sample(u, time)?;
        let radiance = match radiance.uniform() {
            Some(spectrum) => spectrum.sample(nm),
            None => radiance.sample(&geometry.texture_point(&sample, time), nm),
        };
        let (point, triangle, barycentric) = (sample.surface.point, sample.triangle, sample.barycentric);
        let hit = LightHit { light, point, triangle, barycentric };
        Some(Emitted { hit, radiance, density: sample.density })
    }

    /// What the density of [`Self::emit`] is divided by at a point of a light: world over own area there.
    pub fn area_ratio(&self, light: u32, point: &SurfacePoint, time: f64) -> f64 {
        match &self.lights[light as usize] {
            Light::Area { geometry, .. } => geometry.area_ratio(point.normal, time),
            Light::Point { .. } | Light::Spot(_) | Light::Projector(_) | Light::Directional { .. } => 1.0,
        }
    }

    /// Chooses a light for a place and a point on it. `None` where none is found that can contribute.
    ///
    /// The first of the two values chooses among the lights too, each of which has a part of the unit
    /// interval. So `n` samples whose first values lie in equal parts of it, (k + u) / n, take one of each of
    /// n lights that are alike.
    pub fn sample<const C: usize>(
        &self,
        from: &Receiver,
        time: f64,
        wavelengths: &Wavelengths<C>,
        mut u: [f64; 2],
    ) -> Option<LightSample<C>> {
        let chosen = self.choose(from, time, wavelengths, &mut u[0])?;
        self.sample_chosen(&chosen, from, time, &wavelengths.nm, u)
    }

    /// A point on a light that has been chosen.
    fn sample_chosen<const C: usize>(
        &self,
        &Chosen { light, part, probability }: &Chosen,
        &Receiver { point: ref from, facing }: &Receiver,
        time: f64,
        nm: &[f64; C],
        u: [f64; 2],
    ) -> Option<LightSample<C>> {
        let Some(light_chosen) = self.lights.get(light) else {
            let environment = self.environment.as_ref()?;
            let (direction, density, radiance) = environment.sample_radiance(u, facing, nm)?;
            return Some(LightSample {
                shadow_ray: from.ray(direction),
                radiance,
                density: Density::PerSolidAngle(density * probability),
            });
        };
        let pose = self.placed(light).map(|placed| placed.at(time));
        let without_extent = |position: Vec3, intensity: &dyn Fn(Vec3) -> Sampled<C>| {
            let position = pose.map_or(position, |pose| pose.world_point(position));
            let toward = from.position - position;
            let squared = toward.length_squared();
            let off = |surface: &SurfacePoint| surface.leave(toward) - surface.position;
            let end = position + self.flush(light).iter().map(off).sum::<Vec3>();
            let target = SurfacePoint { position: end, normal: toward / squared.sqrt(), error: 0.0 };
            let shadow_ray = from.segment_to(&target)?;
            let away = -shadow_ray.direction;
            let away = pose.map_or(away, |pose| pose.local_vector(away));
            let irradiance = intensity(away) / (squared * probability);
            Some(LightSample { shadow_ray, radiance: irradiance, density: Density::Discrete })
        };
        match light_chosen {
            Light::Area { geometry, radiance, .. } => {
                let sample = geometry.sample_toward(part, from, time, u)?;
                let shadow_ray = from.segment_to(&sample.surface.point)?;
                let radiance = match radiance.uniform() {
                    Some(spectrum) => spectrum.sample(nm),
                    None => radiance.sample(&geometry.texture_point(&sample, time), nm),
                };
                let density = Density::PerSolidAngle(sample.density * probability);
                Some(LightSample { shadow_ray, radiance, density })
            }
            Light::Point { position, intensity } => without_extent(*position, &|_| intensity.sample(nm)),
            Light::Spot(spot) => without_extent(spot.position, &|direction| spot.intensity(direction, nm)),
            Light::Projector(projector) => {
                without_extent(projector.position, &|direction| projector.intensity(direction, nm))
            }
            Light::Directional { travels, irradiance } => Some(LightSample {
                shadow_ray: from.ray(-pose.map_or(*travels, |pose| pose.world_vector(*travels).normalize())),
                radiance: irradiance.sample(nm) / probability,
                density: Density::Discrete,
            }),
        }
    }

    /// Per steradian, the density with which [`Self::sample`] would have found the direction from `from` to a
    /// point on an area light.
    pub fn density<const C: usize>(
        &self,
        light_hit: &LightHit,
        from: &Receiver,
        time: f64,
        wavelengths: &Wavelengths<C>,
    ) -> f64 {
        let Light::Area { geometry, .. } = &self.lights[light_hit.light as usize] else { return 0.0 };
        let part = geometry.part_of(light_hit.triangle);
        let probability = self.probability(light_hit.light as usize, part, from, time, wavelengths);
        if probability > 0.0 {
            probability * geometry.density_toward(&from.point, light_hit, time)
        } else {
            0.0
        }
    }

    /// Per steradian, the density with which [`Self::sample`] would have found a direction that leads out of
    /// the scene.
    pub fn environment_density<const C: usize>(
        &self,
        from: &Receiver,
        direction: Vec3,
        time: f64,
        wavelengths: &Wavelengths<C>,
    ) -> f64 {
        let density = self.sampled_environment().map_or(0.0, |environment| environment.density(direction));
        if density == 0.0 { 0.0 } else { density * self.environment_probability(from, time, wavelengths) }
    }

    /// The probability with which a light sample goes to the environment.
    pub fn environment_probability<const C: usize>(
        &self,
        from: &Receiver,
        time: f64,
        wavelengths: &Wavelengths<C>,
    ) -> f64 {
        self.probability(self.lights.len(), 0, from, time, wavelengths)
    }

    /// What is known of a part of a light. `brightness`: what its spectrum amounts to. `None` for what has no
    /// place, and for what emits nothing.
    fn bound(&self, light: u32, part: u32, brightness: f64, during: [f64; 2]) -> Option<Bound> {
        let at = |position: Vec3| {
            let point = Bounds::of([position]);
            match self.placed(light as usize) {
                None => point,
                Some(placed) => placed.bounds(point, during),
            }
        };
        match &self.lights[light as usize] {
            Light::Area { geometry, .. } => geometry.bound(part, brightness, during),
            Light::Point { position, .. } => Some(Bound::round(at(*position), brightness)),
            Light::Spot(spot) => Some(Bound::round(at(spot.position), brightness)),
            Light::Projector(projector) => Some(Bound::round(at(projector.position), brightness)),
            Light::Directional { .. } => None,
        }
    }

    fn sampled_environment(&self) -> Option<&Environment> {
        self.environment.as_ref().filter(|environment| environment.is_sampled())
    }
}

impl Light {
    /// Where a light without a surface stands, in its own coordinates. `None` for others, and those that are
    /// far away.
    pub fn place(&self) -> Option<Vec3> {
        match self {
            Self::Point { position, .. } => Some(*position),
            Self::Spot(spot) => Some(spot.position),
            Self::Projector(projector) => Some(projector.position),
            Self::Area { .. } | Self::Directional { .. } => None,
        }
    }

    /// Radiance, radiant intensity or irradiance; where that differs from place to place, about the mean of
    /// it. Above 0 at every wavelength at which there is any light.
    pub fn spectrum(&self) -> &Spectrum {
        match self {
            Self::Area { mean, .. } => mean,
            Self::Point { intensity, .. } => intensity,
            Self::Spot(spot) => &spot.intensity,
            Self::Projector(projector) => &projector.mean,
            Self::Directional { irradiance, .. } => irradiance,
        }
    }

    /// Whether what it emits asks for a surface's coordinates.
    pub fn is_textured(&self) -> bool {
        matches!(self, Self::Area { radiance, .. } if radiance.varies())
    }

    /// The parts that can be chosen apart.
    fn parts(&self) -> u32 {
        match self {
            Self::Area { geometry, .. } => geometry.parts(),
            Self::Point { .. } | Self::Spot(_) | Self::Projector(_) | Self::Directional { .. } => 1,
        }
    }

    /// About what the light brings to a place, up to a factor common to all lights: its spectrum there, its
    /// size and its distance. Zero only where it brings nothing.
    ///
    /// `placed`: where a light without a surface that moves stands.
    fn estimate<const C: usize>(
        &self,
        from: &Receiver,
        time: f64,
        placed: Option<&Placed>,
        wavelengths: &Wavelengths<C>,
    ) -> f64 {
        let nm = &wavelengths.nm;
        let without_extent = |position: Vec3, intensity: &dyn Fn(Vec3) -> Sampled<C>| {
            let pose = placed.map(|placed| placed.at(time));
            let position = pose.map_or(position, |pose| pose.world_point(position));
            let away = from.point.position - position;
            let squared = away.length_squared();
            let [place, facing] = [from.point.position, from.facing].map(Vector::of);
            if squared == 0.0 || sees_none_of::<f64>(place, facing, position, 0.0) {
                return 0.0;
            }
            let direction = away / squared.sqrt();
            intensity(pose.map_or(direction, |pose| pose.local_vector(direction))).sum() / squared
        };
        match self {
            Self::Area { geometry, mean, .. } => {
                let spectral = mean.sample(nm).sum();
                if spectral > 0.0 { spectral * geometry.estimate(from, time) } else { 0.0 }
            }
            Self::Point { position, intensity } => without_extent(*position, &|_| intensity.sample(nm)),
            Self::Spot(spot) => without_extent(spot.position, &|direction| spot.intensity(direction, nm)),
            Self::Projector(projector) => {
                without_extent(projector.position, &|direction| projector.intensity(direction, nm))
            }
            Self::Directional { travels, irradiance } => {
                let pose = placed.map(|placed| placed.at(time));
                let travels = pose.map_or(*travels, |pose| pose.world_vector(*travels));
                if travels.dot(from.facing) > 0.0 { 0.0 } else { irradiance.sample(nm).sum() }
            }
        }
    }
}

/// Whether all of a ball lies on the side from which no light counts at a place.
#[inline(always)]
fn sees_none_of<R: Real>(position: Vector<R>, facing: Vector<R>, centre: Vec3, radius: f64) -> R::Truth {
    (Vector::of(centre) - position).dot(facing).lt(R::of(-radius))
}
