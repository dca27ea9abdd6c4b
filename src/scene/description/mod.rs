//! What a scene file says, as plain data: defaults filled in, references resolved, every value with
//! the place in the file that it came from. No behaviour, no file access, nothing to trace yet.

mod lights;
mod materials;
mod sensors;
mod shapes;
mod spectra;

pub use lights::{Light, LightKind};
pub use materials::{
    Alpha, Bsdf, BsdfKind, CoatRoughness, ConductorIndex, Distribution, Medium, MetalAssumption,
    PrincipledBase, ReliefShading, Roughness,
};
pub use sensors::{
    AngularMap, Aperture, Crop, DistantTarget, FieldOfView, Film, FilmChannel, FilmContent, FovAxis, Lens,
    PixelFormat, Sampler, Sensor, SensorKind,
};
pub use shapes::{Animation, HeightSource, Instance, Part, Priority, Shape, ShapeGroup, ShapeKind, Solid};
pub use spectra::{
    BitmapSource, CheckerboardSource, IndexKind, IndexSource, PatternSpace, ProceduralSource, RgbRole,
    SpectrumKind, SpectrumSource, VolumeSource,
};

use super::source::{Place, Sources};
use crate::integrator::Techniques;

#[derive(Clone, Debug)]
pub struct Description {
    pub sources: Sources,
    pub integrator: Integrator,
    pub sensor: Sensor,
    pub shapes: Vec<Shape>,
    pub solids: Vec<Solid>,
    pub instances: Vec<Instance>,
    /// Lights that are no shape's surface.
    pub lights: Vec<Light>,
    /// Words in the file that Mitsuba 3 would refuse, with what they mean.
    pub extensions: Vec<Note>,
    /// What was assumed in order to make physics out of what the file says.
    pub assumptions: Vec<Note>,
    /// What the file says that changes nothing here, such as the name of a sampler that Mitsuba 3 has.
    pub remarks: Vec<Note>,
}

/// A remark tied to a place.
#[derive(Clone, Debug)]
pub struct Note {
    pub place: Place,
    pub text: String,
}

#[derive(Clone, Debug)]
pub struct Integrator {
    pub place: Place,
    pub kind: IntegratorKind,
    /// Most segments of a path, camera ray included; `None` is unlimited. 1 shows emission only.
    pub max_depth: Option<u32>,
    /// Number of segments from which Russian roulette may end a path.
    pub rr_depth: u32,
    pub hide_emitters: bool,
    /// `direct` may leave one out.
    pub techniques: Techniques,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IntegratorKind {
    /// To pass through a surface that is not there (a mask, `null`) is a segment of its own, and light samples are stopped
    /// there.
    Path,
    /// A path of at most two segments.
    Direct,
    /// `volpath`, `volpathmis`: paths and light samples go through such a surface as if there were none.
    VolPath,
    /// Scattering alone finds the lights: the slow oracle (an extension, `walk`).
    Walk,
}
