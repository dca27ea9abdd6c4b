//! Lights: what they emit, and how a point on one is chosen for a place that it may light.
//!
//! One light is chosen for each vertex, in proportion to a cheap estimate of what it can contribute there at the path's
//! wavelengths. The estimate takes all of the path's wavelengths alike, so the choice is the same whichever of
//! them is the hero.

mod area;

pub use area::AreaGeometry;

use crate::bsdf::Density;
use crate::geometry::{Ray, SurfacePoint, Vec3};
use crate::sampling::PiecewiseConstant;
use crate::spectrum::{Sampled, Spectrum, Wavelengths};

/// A light that can be sampled. Light from everywhere at once is no such light: scattering samples it best.
#[derive(Clone, Debug)]
pub enum Light {
    /// Radiance of a surface's front, W·m⁻²·sr⁻¹·nm⁻¹.
    Area { geometry: Box<AreaGeometry>, radiance: Spectrum },
    /// Radiant intensity, W·sr⁻¹·nm⁻¹.
    Point { position: Vec3, intensity: Spectrum },
    /// Irradiance across the direction of travel, W·m⁻²·nm⁻¹.
    Directional { travels: Vec3, irradiance: Spectrum },
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

/// The lights of a scene.
#[derive(Clone, Debug, Default)]
pub struct Lights {
    lights: Vec<Light>,
    /// Choice by power alone, for scenes with so many lights that estimating each at each vertex would not pay.
    by_power: Option<PiecewiseConstant>,
}

/// Up to how many lights each is estimated at each vertex.
const ESTIMATED: usize = 32;

impl Lights {
    /// `powers` are the lights' shares of the whole, up to a factor.
    pub fn new(lights: Vec<Light>, powers: &[f64]) -> Self {
        let by_power = if lights.len() > ESTIMATED {
            let edges = (0..=lights.len()).map(|i| i as f64).collect();
            PiecewiseConstant::new(edges, powers)
        } else {
            None
        };
        Self { lights, by_power }
    }

    pub fn is_empty(&self) -> bool {
        self.lights.is_empty()
    }

    pub fn iter(&self) -> impl Iterator<Item = &Light> {
        self.lights.iter()
    }

    /// What an area light emits from its front.
    pub fn radiance<const C: usize>(&self, light: u32, nm: &[f64; C]) -> Sampled<C> {
        match &self.lights[light as usize] {
            Light::Area { radiance, .. } => radiance.sample(nm),
            Light::Point { .. } | Light::Directional { .. } => Sampled::ZERO,
        }
    }

    /// Chooses a light for a place and a point on it. `None` where no light can contribute.
    pub fn sample<const C: usize>(
        &self,
        from: &SurfacePoint,
        wavelengths: &Wavelengths<C>,
        choice: f64,
        u: [f64; 2],
    ) -> Option<LightSample<C>> {
        let (light, probability) = self.choose(from, wavelengths, choice)?;
        match light {
            Light::Area { geometry, radiance } => {
                let (point, density) = geometry.sample_toward(from, u)?;
                let shadow_ray = from.segment_to(&point)?;
                Some(LightSample {
                    shadow_ray,
                    radiance: radiance.sample(&wavelengths.nm),
                    density: Density::PerSolidAngle(density * probability),
                })
            }
            Light::Point { position, intensity } => {
                let target = SurfacePoint { position: *position, normal: Vec3::Z, error: 0.0 };
                let shadow_ray = from.segment_to(&target)?;
                let squared = from.position.distance_squared(*position);
                let irradiance = intensity.sample(&wavelengths.nm) / (squared * probability);
                Some(LightSample { shadow_ray, radiance: irradiance, density: Density::Discrete })
            }
            Light::Directional { travels, irradiance } => Some(LightSample {
                shadow_ray: from.ray(-*travels),
                radiance: irradiance.sample(&wavelengths.nm) / probability,
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
        wavelengths: &Wavelengths<C>,
    ) -> f64 {
        let chosen = &self.lights[light as usize];
        let Light::Area { geometry, .. } = chosen else { return 0.0 };
        let probability = match &self.by_power {
            Some(table) => table.density(f64::from(light)),
            None if self.lights.len() == 1 => 1.0,
            None => {
                let own = chosen.estimate(from, wavelengths);
                let all: f64 = self.lights.iter().map(|other| other.estimate(from, wavelengths)).sum();
                if own > 0.0 { own / all } else { 0.0 }
            }
        };
        if probability > 0.0 { probability * geometry.density_toward(from, point) } else { 0.0 }
    }

    fn choose<const C: usize>(
        &self,
        from: &SurfacePoint,
        wavelengths: &Wavelengths<C>,
        choice: f64,
    ) -> Option<(&Light, f64)> {
        if let Some(table) = &self.by_power {
            let (position, probability) = table.sample(choice);
            return Some((&self.lights[(position as usize).min(self.lights.len() - 1)], probability));
        }
        if let [only] = self.lights.as_slice() {
            return Some((only, 1.0));
        }
        let mut estimates = [0.0; ESTIMATED];
        let mut all = 0.0;
        for (light, estimate) in self.lights.iter().zip(&mut estimates) {
            *estimate = light.estimate(from, wavelengths);
            all += *estimate;
        }
        let mut remaining = choice * all;
        for (light, estimate) in self.lights.iter().zip(estimates) {
            // The last light that can contribute takes what rounding leaves over.
            if estimate > 0.0 && (remaining < estimate || remaining - estimate <= 1e-12 * all) {
                return Some((light, estimate / all));
            }
            remaining -= estimate;
        }
        None
    }
}

impl Light {
    /// Radiance, radiant intensity or irradiance.
    pub fn spectrum(&self) -> &Spectrum {
        match self {
            Self::Area { radiance, .. } => radiance,
            Self::Point { intensity, .. } => intensity,
            Self::Directional { irradiance, .. } => irradiance,
        }
    }

    /// About what the light brings to a place, up to a factor common to all lights: its spectrum there, its size and its
    /// distance. Zero only where it brings nothing.
    fn estimate<const C: usize>(&self, from: &SurfacePoint, wavelengths: &Wavelengths<C>) -> f64 {
        match self {
            Self::Area { geometry, radiance } => {
                let spectral = radiance.sample(&wavelengths.nm).sum();
                if spectral > 0.0 { spectral * geometry.estimate(from.position) } else { 0.0 }
            }
            Self::Point { position, intensity } => {
                let squared = from.position.distance_squared(*position);
                if squared > 0.0 { intensity.sample(&wavelengths.nm).sum() / squared } else { 0.0 }
            }
            Self::Directional { irradiance, .. } => irradiance.sample(&wavelengths.nm).sum(),
        }
    }
}
