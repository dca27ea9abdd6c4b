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
    /// Where the file declares it.
    pub place: Place,
    /// Which sensor it is, with its parameters.
    pub kind: SensorKind,
    /// `srf`: factor on what is measured, by wavelength. `None` is 1 everywhere.
    pub response: Option<SpectrumSource>,
    /// What the sensor is in.
    pub medium: Option<Medium>,
    /// The film that it exposes.
    pub film: Film,
    /// How samples are placed.
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
        /// Angle of view.
        field_of_view: FieldOfView,
        /// Offset of the principal point as fractions of the film's width and height.
        principal_point: [f64; 2],
        /// Distance along the axis before which it sees nothing, in scene units.
        near_clip: f64,
        /// Distance along the axis beyond which it sees nothing, in scene units.
        far_clip: f64,
        /// `thinlens`; `None` is a pinhole.
        lens: Option<Lens>,
    },
    /// Sees local x from −1 to 1 across the whole film, along +z.
    Orthographic {
        /// From the camera's coordinates to the scene's.
        to_world: Transform,
        /// Distance along the axis before which it sees nothing, in scene units.
        near_clip: f64,
        /// Distance along the axis beyond which it sees nothing, in scene units.
        far_clip: f64,
    },
    /// `fisheye` and `panorama` (extensions). The frame is that of a perspective camera.
    Angular {
        /// From the camera's coordinates to the scene's.
        to_world: Transform,
        /// Which direction each place on the film sees.
        map: AngularMap,
        /// Distances from the camera.
        near_clip: f64,
        /// Distance beyond which it sees nothing, in scene units.
        far_clip: f64,
    },
    /// `sensorplane`, a film in the scene itself (an extension): it lies across its local z, in the middle of
    /// which the origin is.
    Plane {
        /// From the film's coordinates to the scene's.
        to_world: Transform,
        /// Width of the film, in units of its own coordinates.
        width: f64,
        /// The disk toward which rays are sampled.
        stop: Stop,
    },
    /// `radiancemeter`: measures a single ray.
    RadianceMeter {
        /// Where the ray begins.
        origin: Vec3,
        /// Direction that it looks in.
        direction: Vec3,
    },
    /// Measures on a surface, which may be part of the scene.
    IrradianceMeter {
        /// The surface, with its placement.
        surface: Arc<ShapeDescription>,
    },
    /// Looks along `direction` from infinity.
    Distant {
        /// Direction that it looks in.
        direction: Vec3,
        /// The part of the scene that it sees.
        target: DistantTarget,
    },
    /// Sensors side by side, from left to right. Their own films and samplers don't matter.
    Batch(Vec<Sensor>),
}

/// See [`crate::camera::DirectionMap`]; fields of view in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AngularMap {
    /// A cone around the axis.
    Fisheye {
        /// How the angle from the axis becomes a distance on the film.
        projection: FisheyeProjection,
        /// Angle across the cone, degrees, above 0 and up to 360.
        fov: f64,
    },
    /// Angles across and up.
    Panorama {
        /// Degrees across (up to 360) and up (up to 180).
        fov: [f64; 2],
    },
}

/// What a distant sensor looks at.
#[derive(Clone, Debug)]
pub enum DistantTarget {
    /// The cross-section of a sphere around the scene's bounding box.
    Scene,
    /// The one ray through a point.
    Point(Vec3),
    /// A surface that need not be part of the scene.
    Surface(Arc<ShapeDescription>),
}

/// How wide a camera sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FieldOfView {
    /// By an angle.
    Degrees {
        /// Degrees, above 0 and below 180.
        angle: f64,
        /// The side of the film that it is measured across.
        axis: FovAxis,
    },
    /// Focal length in mm of a lens over a 35 mm film (36 × 24), measured on the diagonal.
    FocalLength(f64),
}

/// The side of the film that an angle of view goes by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FovAxis {
    /// Its width.
    X,
    /// Its height.
    Y,
    /// From corner to corner.
    Diagonal,
    /// The smaller one of width and height.
    Smaller,
    /// The larger one of width and height.
    Larger,
}

/// A thin lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Shape and size of the opening.
    pub aperture: Aperture,
    /// Straight blades that bound the aperture, 3 or more; 0 for a round one (an extension).
    pub blades: u32,
    /// By how many degrees the blades are turned, counter-clockwise for who stands behind the camera.
    pub rotation: f64,
    /// Distance along the axis of the plane that is in focus, in scene units. Above 0.
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
    /// Where the file declares it.
    pub place: Place,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// The window that alone is exposed; `None` for all of the film.
    pub crop: Option<Crop>,
    /// Reconstruction filter.
    pub filter: FilterKind,
    /// Whether pixels at the border see what lies outside the film.
    pub sample_border: bool,
    /// What the file holds.
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
    Colour {
        /// Primaries of the colour.
        format: PixelFormat,
        /// Whether there is an alpha channel.
        alpha: bool,
    },
    /// `specfilm`: for each channel its name and the sensor's response, over which radiance is integrated.
    Responses(Vec<FilmChannel>),
}

/// A channel of a film with responses of its own.
#[derive(Clone, Debug)]
pub struct FilmChannel {
    /// What the channel is called in the file.
    pub name: String,
    /// Response by wavelength, at least 0.
    pub response: SpectrumSource,
}

/// The part of a film that is exposed, pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    /// First column, in pixels from the film's left edge.
    pub x: u32,
    /// First row, in pixels from the film's upper edge.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

/// The channels of a film that measures colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelFormat {
    /// Linear, with the primaries of Rec. ITU-R BT.709.
    Rgb,
    /// CIE XYZ.
    Xyz,
    /// Y alone.
    Luminance,
}

/// Where sample values come from, and how many samples are taken.
#[derive(Clone, Debug)]
pub struct Sampler {
    /// Where the file declares it.
    pub place: Place,
    /// Which sampler it is.
    pub kind: SamplerKind,
    /// Whether the file forces it. A sampler of Mitsuba's does not, whichever it is.
    pub forced: bool,
    /// Samples of each pixel, at least 1.
    pub sample_count: u32,
    /// Seed of the sample values.
    pub seed: u64,
}
