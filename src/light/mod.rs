//! Lights: what they emit, and how a point on one is chosen for a place that it may light.
//!
//! One light is chosen for each vertex, in proportion to a cheap estimate of what it can contribute there at the path's
//! wavelengths. The estimate takes all of the path's wavelengths alike, so the choice is the same whichever of
//! them is the hero.

mod area;
mod casters;
mod environment;
mod environment_map;
mod projector;
pub mod sky;
mod spot;
#[cfg(test)]
mod tests;

pub use area::AreaGeometry;
pub use casters::{Caster, Casters};
pub use environment::Environment;
pub use environment_map::{EnvironmentMap, Texel};
pub use projector::Projector;
pub use sky::Sky;
pub use spot::Spot;

use crate::bsdf::Density;
use crate::geometry::{Placed, Ray, SurfacePoint, Vec3};
use crate::sampling::PiecewiseConstant;
use crate::spectrum::{Sampled, Spectrum, Wavelengths};
use crate::texture::{Texture, TexturePoint};
use std::f64::consts::PI;

/// A light within the scene, or one whose light comes from one direction.
#[derive(Clone, Debug)]
pub enum Light {
    /// Radiance of a surface's front, W·m⁻²·sr⁻¹·nm⁻¹, and about the mean of it over the surface: above 0 at every wavelength
    /// at which any of it shines.
    Area {
        geometry: Box<AreaGeometry>,
        radiance: Texture,
        mean: Spectrum,
    },
    /// Radiant intensity, W·sr⁻¹·nm⁻¹.
    Point {
        position: Vec3,
        intensity: Spectrum,
    },
    Spot(Box<Spot>),
    Projector(Box<Projector>),
    /// Irradiance across the direction of travel, W·m⁻²·nm⁻¹.
    Directional {
        travels: Vec3,
        irradiance: Spectrum,
    },
}

/// A point on a light and what comes from there.
#[derive(Clone, Copy, Debug)]
pub struct LightSample<const C: usize> {
    /// From the lit surface to just before the light.
    pub shadow_ray: Ray,
    /// Radiance, or irradiance across the ray for a light without extent. For the latter it is divided by the probability
    /// of the choice already.
    pub radiance: Sampled<C>,
    pub density: Density,
}

/// A point of a light's surface and what it emits.
#[derive(Clone, Copy, Debug)]
pub struct Emitted<const C: usize> {
    pub point: SurfacePoint,
    pub radiance: Sampled<C>,
    /// Of the point, per unit of area.
    pub density: f64,
}

/// The lights of a scene.
#[derive(Clone, Debug, Default)]
pub struct Lights {
    lights: Vec<Light>,
    /// Where lights without a surface stand over time, by light, as far as there is one that moves. What the light says is
    /// then in coordinates of its own.
    placed: Vec<Option<Placed>>,
    environment: Option<Environment>,
    /// Choice by power alone, for scenes with so many lights that estimating each at each vertex would not pay.
    by_power: Option<PiecewiseConstant>,
}

/// Up to how many lights each is estimated at each vertex.
const ESTIMATED: usize = 32;

impl Lights {
    /// `powers` are the shares of the whole, up to a factor, of each light and last of the environment, if there is one.
    pub fn new(lights: Vec<Light>, environment: Option<Environment>, powers: &[f64]) -> Self {
        let mut all = Self { lights, environment, by_power: None, placed: Vec::new() };
        let count = all.count();
        if count > ESTIMATED {
            let edges = (0..=count).map(|i| i as f64).collect();
            all.by_power = PiecewiseConstant::new(edges, &powers[..count]);
        }
        all
    }

    /// Lights without a surface that move, by their indices. They must not scale.
    #[must_use]
    pub fn with_motion(mut self, moving: Vec<(usize, Placed)>) -> Self {
        for (light, placed) in moving {
            self.placed.resize(self.lights.len(), None);
            self.placed[light] = Some(placed);
        }
        self
    }

    fn placed(&self, light: usize) -> Option<&Placed> {
        self.placed.get(light)?.as_ref()
    }

    /// Whether there is nothing to sample.
    pub fn is_empty(&self) -> bool {
        self.count() == 0
    }

    /// The lights but for the environment.
    pub fn iter(&self) -> impl Iterator<Item = &Light> {
        self.lights.iter()
    }

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

    /// A point of an area light's front and what it emits at the wavelengths (nm) of a path. `None` for other lights.
    pub fn emit<const C: usize>(
        &self,
        light: u32,
        u: [f64; 2],
        time: f64,
        nm: &[f64; C],
    ) -> Option<Emitted<C>> {
        let Light::Area { geometry, radiance, .. } = &self.lights[light as usize] else { return None };
        let sample = geometry.sample(u)?;
        let radiance = match radiance.uniform() {
            Some(spectrum) => spectrum.sample(nm),
            None => radiance.sample(&geometry.texture_point(&sample, time), nm),
        };
        Some(Emitted { point: sample.surface.point, radiance, density: sample.density })
    }

    /// Chooses a light for a place and a point on it. `None` where no light can contribute.
    pub fn sample<const C: usize>(
        &self,
        from: &SurfacePoint,
        time: f64,
        wavelengths: &Wavelengths<C>,
        choice: f64,
        u: [f64; 2],
    ) -> Option<LightSample<C>> {
        let (chosen, probability) = self.choose(from, time, wavelengths, choice)?;
        let nm = &wavelengths.nm;
        let Some(light) = self.lights.get(chosen) else {
            let environment = self.environment.as_ref()?;
            let (direction, density) = environment.sample(u)?;
            return Some(LightSample {
                shadow_ray: from.ray(direction),
                radiance: environment.radiance(direction, nm),
                density: Density::PerSolidAngle(density * probability),
            });
        };
        let pose = self.placed(chosen).map(|placed| placed.at(time));
        let without_extent = |position: Vec3, intensity: &dyn Fn(Vec3) -> Sampled<C>| {
            let position = pose.map_or(position, |pose| pose.world_point(position));
            let target = SurfacePoint { position, normal: Vec3::Z, error: 0.0 };
            let shadow_ray = from.segment_to(&target)?;
            let squared = from.position.distance_squared(position);
            let away = -shadow_ray.direction;
            let away = pose.map_or(away, |pose| pose.local_vector(away));
            let irradiance = intensity(away) / (squared * probability);
            Some(LightSample { shadow_ray, radiance: irradiance, density: Density::Discrete })
        };
        match light {
            Light::Area { geometry, radiance, .. } => {
                let sample = geometry.sample_toward(from, time, u)?;
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

    /// Per steradian, the density with which [`Self::sample`] would have found the direction from `from` to a point on an
    /// area light.
    pub fn density<const C: usize>(
        &self,
        light: u32,
        from: &SurfacePoint,
        point: &SurfacePoint,
        time: f64,
        wavelengths: &Wavelengths<C>,
    ) -> f64 {
        let Light::Area { geometry, .. } = &self.lights[light as usize] else { return 0.0 };
        let probability = self.probability(light as usize, from, time, wavelengths);
        if probability > 0.0 { probability * geometry.density_toward(from, point, time) } else { 0.0 }
    }

    /// Per steradian, the density with which [`Self::sample`] would have found a direction that leads out of the scene.
    pub fn environment_density<const C: usize>(
        &self,
        from: &SurfacePoint,
        direction: Vec3,
        time: f64,
        wavelengths: &Wavelengths<C>,
    ) -> f64 {
        match self.sampled_environment() {
            Some(environment) => {
                self.probability(self.lights.len(), from, time, wavelengths) * environment.density(direction)
            }
            None => 0.0,
        }
    }

    fn sampled_environment(&self) -> Option<&Environment> {
        self.environment.as_ref().filter(|environment| environment.is_sampled())
    }

    /// Of what is sampled. The environment, if it is, comes after all lights.
    fn count(&self) -> usize {
        self.lights.len() + usize::from(self.sampled_environment().is_some())
    }

    fn probability<const C: usize>(
        &self,
        light: usize,
        from: &SurfacePoint,
        time: f64,
        wavelengths: &Wavelengths<C>,
    ) -> f64 {
        match &self.by_power {
            Some(table) => table.density(light as f64),
            None if self.count() == 1 => 1.0,
            None => {
                let estimate = |light| self.estimate(light, from, time, wavelengths);
                let own = estimate(light);
                let all: f64 = (0..self.count()).map(estimate).sum();
                if own > 0.0 { own / all } else { 0.0 }
            }
        }
    }

    /// A light's index, or their number for the environment, and the probability of the choice.
    fn choose<const C: usize>(
        &self,
        from: &SurfacePoint,
        time: f64,
        wavelengths: &Wavelengths<C>,
        choice: f64,
    ) -> Option<(usize, f64)> {
        let count = self.count();
        if let Some(table) = &self.by_power {
            let (position, probability) = table.sample(choice);
            return Some(((position as usize).min(count - 1), probability));
        }
        if count == 1 {
            return Some((0, 1.0));
        }
        let mut estimates = [0.0; ESTIMATED];
        let mut all = 0.0;
        for (light, estimate) in estimates.iter_mut().enumerate().take(count) {
            *estimate = self.estimate(light, from, time, wavelengths);
            all += *estimate;
        }
        let mut remaining = choice * all;
        for (light, estimate) in estimates.into_iter().enumerate().take(count) {
            // The last light that can contribute takes what rounding leaves over.
            if estimate > 0.0 && (remaining < estimate || remaining - estimate <= 1e-12 * all) {
                return Some((light, estimate / all));
            }
            remaining -= estimate;
        }
        None
    }

    fn estimate<const C: usize>(
        &self,
        light: usize,
        from: &SurfacePoint,
        time: f64,
        wavelengths: &Wavelengths<C>,
    ) -> f64 {
        match (self.lights.get(light), &self.environment) {
            (Some(own), _) => own.estimate(from, time, self.placed(light), wavelengths),
            // Half of it is above a surface, at a slant.
            (None, Some(environment)) => PI * environment.mean().sample(&wavelengths.nm).sum(),
            (None, None) => 0.0,
        }
    }
}

impl Light {
    /// Radiance, radiant intensity or irradiance; where that differs from place to place, about the mean of it. Above 0 at
    /// every wavelength at which there is any light.
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

    /// About what the light brings to a place, up to a factor common to all lights: its spectrum there, its size and its
    /// distance. Zero only where it brings nothing.
    ///
    /// `placed`: where a light without a surface that moves stands.
    fn estimate<const C: usize>(
        &self,
        from: &SurfacePoint,
        time: f64,
        placed: Option<&Placed>,
        wavelengths: &Wavelengths<C>,
    ) -> f64 {
        let nm = &wavelengths.nm;
        let without_extent = |position: Vec3, intensity: &dyn Fn(Vec3) -> Sampled<C>| {
            let from = placed.map_or(from.position, |placed| placed.at(time).local_point(from.position));
            let away = from - position;
            let squared = away.length_squared();
            if squared > 0.0 { intensity(away / squared.sqrt()).sum() / squared } else { 0.0 }
        };
        match self {
            Self::Area { geometry, mean, .. } => {
                let spectral = mean.sample(nm).sum();
                if spectral > 0.0 { spectral * geometry.estimate(from.position, time) } else { 0.0 }
            }
            Self::Point { position, intensity } => without_extent(*position, &|_| intensity.sample(nm)),
            Self::Spot(spot) => without_extent(spot.position, &|direction| spot.intensity(direction, nm)),
            Self::Projector(projector) => {
                without_extent(projector.position, &|direction| projector.intensity(direction, nm))
            }
            Self::Directional { irradiance, .. } => irradiance.sample(nm).sum(),
        }
    }
}
