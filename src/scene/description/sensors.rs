//! Sensors, films and samplers as a scene file says them.

use super::media::Medium;
use super::shapes::{Animation, ShapeDescription};
use super::spectra::SpectrumSource;
use crate::camera::{FisheyeProjection, Shutter, Stop};
use crate::film::{FilterKind, Region};
use crate::geometry::{Transform, Vec3};
use crate::sampling::SamplerKind;
use crate::scene::source::Place;
use std::sync::Arc;

/// What measures, with its film and sampler.
#[derive(Clone, Debug)]
pub struct Sensor {
    pub place: Place,
    pub kind: SensorKind,
    /// `srf`: factor on what is measured, by wavelength. `None` is 1 everywhere.
    pub response: Option<SpectrumSource>,
    /// What the sensor is in.
    pub medium: Option<Medium>,
    pub film: Film,
    pub sampler: Sampler,
    /// Motion of a camera.
    pub motion: Option<Arc<Animation>>,
    /// A batch has one shutter for all its sensors.
    pub shutter: Shutter,
}

/// What a sensor measures, and from where.
#[derive(Clone, Debug)]
pub enum SensorKind {
    /// `perspective` and `thinlens`.
    Perspective {
        /// The camera looks along its local +z, its local +x is the image's left, +y is up (Mitsuba 3).
        to_world: Transform,
        field_of_view: FieldOfView,
        /// Offset of the principal point as fractions of the film's width and height.
        principal_point: [f64; 2],
        near_clip: f64,
        far_clip: f64,
        /// `thinlens`; `None` is a pinhole.
        lens: Option<Lens>,
    },
    /// Sees local x from −1 to 1 across the whole film, along +z.
    Orthographic {
        to_world: Transform,
        near_clip: f64,
        far_clip: f64,
    },
    /// `fisheye` and `panorama` (extensions). The frame is that of a perspective camera.
    Angular {
        to_world: Transform,
        map: AngularMap,
        /// Distances from the camera.
        near_clip: f64,
        far_clip: f64,
    },
    /// `sensorplane`, a film in the scene itself (an extension): it lies across its local z, in the middle of
    /// which the origin is.
    Plane {
        to_world: Transform,
        width: f64,
        stop: Stop,
    },
    RadianceMeter {
        origin: Vec3,
        direction: Vec3,
    },
    /// Measures on a surface, which may be part of the scene.
    IrradianceMeter {
        surface: Arc<ShapeDescription>,
    },
    /// Looks along `direction` from infinity.
    Distant {
        direction: Vec3,
        target: DistantTarget,
    },
    /// Sensors side by side, from left to right. Their own films and samplers don't matter.
    Batch(Vec<Sensor>),
}

/// See [`crate::camera::DirectionMap`]; fields of view in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AngularMap {
    Fisheye {
        projection: FisheyeProjection,
        fov: f64,
    },
    /// Angles across and up.
    Panorama {
        fov: [f64; 2],
    },
}

/// What a distant sensor looks at.
#[derive(Clone, Debug)]
pub enum DistantTarget {
    /// The cross-section of a sphere around the scene's bounding box.
    Scene,
    Point(Vec3),
    /// A surface that need not be part of the scene.
    Surface(Arc<ShapeDescription>),
}

/// How wide a camera sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FieldOfView {
    Degrees {
        angle: f64,
        axis: FovAxis,
    },
    /// Focal length in mm of a lens over a 35 mm film (36 × 24), measured on the diagonal.
    FocalLength(f64),
}

/// The side of the film that an angle of view goes by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FovAxis {
    X,
    Y,
    Diagonal,
    Smaller,
    Larger,
}

/// A thin lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    pub aperture: Aperture,
    /// Straight blades that bound the aperture, 3 or more; 0 for a round one (an extension).
    pub blades: u32,
    /// By how many degrees the blades are turned, counter-clockwise for who stands behind the camera.
    pub rotation: f64,
    pub focus_distance: f64,
}

/// How wide a lens is open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aperture {
    /// Scene units.
    Radius(f64),
    /// Focal length over diameter, the focal length being that of the field of view on 36 mm × 24 mm and
    /// a scene unit a metre (an extension).
    Stop(f64),
}

/// What is exposed.
#[derive(Clone, Debug)]
pub struct Film {
    pub place: Place,
    pub width: u32,
    pub height: u32,
    pub crop: Option<Crop>,
    pub filter: FilterKind,
    /// Whether pixels at the border see what lies outside the film.
    pub sample_border: bool,
    pub content: FilmContent,
}

impl Film {
    /// What is exposed of it.
    pub fn window(&self) -> Region {
        match self.crop {
            Some(Crop { x, y, width, height }) => Region { offset: [x, y], size: [width, height] },
            None => Region::whole([self.width, self.height]),
        }
    }
}

/// What the pixels of a film hold.
#[derive(Clone, Debug)]
pub enum FilmContent {
    /// `hdrfilm`.
    Colour { format: PixelFormat, alpha: bool },
    /// `specfilm`: for each channel its name and the sensor's response, over which radiance is integrated.
    Responses(Vec<FilmChannel>),
}

/// A channel of a film with responses of its own.
#[derive(Clone, Debug)]
pub struct FilmChannel {
    pub name: String,
    pub response: SpectrumSource,
}

/// The part of a film that is exposed, pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    pub x: u32,
    pub y: u32,
    pub width: u32,
    pub height: u32,
}

/// The channels of a film that measures colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelFormat {
    Rgb,
    Xyz,
    Luminance,
}

/// Where sample values come from, and how many samples are taken.
#[derive(Clone, Debug)]
pub struct Sampler {
    pub place: Place,
    pub kind: SamplerKind,
    /// Whether the file forces it. A sampler of Mitsuba's does not, whichever it is.
    pub forced: bool,
    pub sample_count: u32,
    pub seed: u64,
}
