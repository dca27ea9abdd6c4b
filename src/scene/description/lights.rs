//! Lights as a scene file says them.

use super::sensors::FieldOfView;
use super::shapes::Animation;
use super::spectra::SpectrumSource;
use crate::geometry::{Transform, Vec3};
use crate::raster::Image;
use crate::scene::source::Place;
use std::path::PathBuf;
use std::sync::Arc;

/// A light that is no shape's surface.
#[derive(Clone, Debug)]
pub struct Light {
    pub place: Place,
    pub kind: LightKind,
}

/// What a light sends out, and from where.
#[derive(Clone, Debug)]
pub enum LightKind {
    /// Radiant intensity, W·sr⁻¹·nm⁻¹.
    Point { position: Vec3, motion: Option<Arc<Animation>>, intensity: SpectrumSource },
    /// A point that shines along its local +z. The angles, in degrees, are those between the axis and where
    /// the light ends, and where it begins to fall off.
    Spot {
        to_world: Transform,
        motion: Option<Arc<Animation>>,
        /// Intensity on the axis.
        intensity: SpectrumSource,
        cutoff_angle: f64,
        beam_width: f64,
        /// Transmittance of a slide between the light and what it lights.
        texture: Option<SpectrumSource>,
    },
    /// A picture thrown along the local +z.
    Projector {
        to_world: Transform,
        motion: Option<Arc<Animation>>,
        irradiance: SpectrumSource,
        scale: f64,
        field_of_view: FieldOfView,
    },
    /// Irradiance on a surface across the light's direction of travel, W·m⁻²·nm⁻¹.
    /// `travels` has any length.
    Directional { travels: Vec3, motion: Option<Arc<Animation>>, irradiance: SpectrumSource },
    /// The same radiance from everywhere.
    Constant { radiance: SpectrumSource },
    /// A picture all around, in values for the primaries of sRGB under D65, with +y of the local frame at its
    /// top.
    EnvironmentMap { to_world: Transform, file: PathBuf, image: Arc<Image>, scale: f64 },
    /// Clear sky and sun, the zenith at the local +z.
    SunSky {
        to_world: Transform,
        turbidity: f64,
        /// Reflectance of the ground.
        albedo: SpectrumSource,
        /// Direction in the world, of any length.
        sun_direction: Vec3,
        sky_scale: f64,
        sun_scale: f64,
        /// Angle across the sun, degrees.
        sun_aperture: f64,
        complex_sun: bool,
    },
}

impl LightKind {
    /// What moves it; nothing moves light from all around.
    pub fn motion(&self) -> Option<&Animation> {
        match self {
            Self::Point { motion, .. }
            | Self::Spot { motion, .. }
            | Self::Projector { motion, .. }
            | Self::Directional { motion, .. } => motion.as_deref(),
            Self::Constant { .. } | Self::EnvironmentMap { .. } | Self::SunSky { .. } => None,
        }
    }

    /// Whether the light comes from all around.
    pub fn is_environment(&self) -> bool {
        match self {
            Self::Constant { .. } | Self::EnvironmentMap { .. } | Self::SunSky { .. } => true,
            Self::Point { .. } | Self::Spot { .. } | Self::Projector { .. } | Self::Directional { .. } => {
                false
            }
        }
    }
}
