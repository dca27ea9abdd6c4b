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
    /// Where the file declares it.
    pub place: Place,
    /// Which light it is, with its parameters.
    pub kind: LightKind,
}

/// What a light sends out, and from where.
#[derive(Clone, Debug)]
pub enum LightKind {
    /// Radiant intensity, W·sr⁻¹·nm⁻¹.
    Point {
        /// Where it stands, in scene units.
        position: Vec3,
        /// How it moves while the shutter is open; `None` at rest.
        motion: Option<Arc<Animation>>,
        /// Radiant intensity, W·sr⁻¹·nm⁻¹.
        intensity: SpectrumSource,
    },
    /// A point that shines along its local +z. The angles, in degrees, are those between the axis and where
    /// the light ends, and where it begins to fall off.
    Spot {
        /// From its own coordinates to the scene's.
        to_world: Transform,
        /// How it moves while the shutter is open; `None` at rest.
        motion: Option<Arc<Animation>>,
        /// Intensity on the axis.
        intensity: SpectrumSource,
        /// Half-angle of the cone beyond which it is dark, degrees, above 0 and up to 180.
        cutoff_angle: f64,
        /// Half-angle within which it has its full intensity, degrees, from 0 to `cutoff_angle`.
        beam_width: f64,
        /// Transmittance of a slide between the light and what it lights.
        texture: Option<SpectrumSource>,
    },
    /// A picture thrown along the local +z.
    Projector {
        /// From its own coordinates to the scene's.
        to_world: Transform,
        /// How it moves while the shutter is open; `None` at rest.
        motion: Option<Arc<Animation>>,
        /// The picture, as irradiance at a distance of 1, W·m⁻²·nm⁻¹.
        irradiance: SpectrumSource,
        /// Factor on the irradiance, at least 0.
        scale: f64,
        /// Angle of the picture.
        field_of_view: FieldOfView,
    },
    /// Irradiance on a surface across the light's direction of travel, W·m⁻²·nm⁻¹.
    /// `travels` has any length.
    Directional {
        /// Direction in which the light goes.
        travels: Vec3,
        /// How it turns while the shutter is open; `None` at rest.
        motion: Option<Arc<Animation>>,
        /// Irradiance across the direction, W·m⁻²·nm⁻¹.
        irradiance: SpectrumSource,
    },
    /// The same radiance from everywhere.
    Constant {
        /// Radiance from all directions, W·m⁻²·sr⁻¹·nm⁻¹.
        radiance: SpectrumSource,
    },
    /// A picture all around, in values for the primaries of sRGB under D65, with +y of the local frame at its
    /// top.
    EnvironmentMap {
        /// From the map's coordinates, +y at its top, to the scene's.
        to_world: Transform,
        /// File of the image, relative to the scene's folder.
        file: PathBuf,
        /// Its pixels.
        image: Arc<Image>,
        /// Factor on the radiance, at least 0.
        scale: f64,
    },
    /// Clear sky and sun, the zenith at the local +z.
    SunSky {
        /// From the sky's coordinates, +z to the zenith, to the scene's.
        to_world: Transform,
        /// Haze, from 1 (clear air) to 10.
        turbidity: f64,
        /// Reflectance of the ground.
        albedo: SpectrumSource,
        /// Direction in the world, of any length.
        sun_direction: Vec3,
        /// Factor on the radiance of the sky, at least 0.
        sky_scale: f64,
        /// Factor on the radiance of the sun, at least 0.
        sun_scale: f64,
        /// Angle across the sun, degrees.
        sun_aperture: f64,
        /// Whether the sun is darker at its limb, by wavelength.
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
