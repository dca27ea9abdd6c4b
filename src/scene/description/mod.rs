//! What a scene file says, as plain data: defaults filled in, references resolved, every value with
//! the place in the file that it came from. No behaviour, no file access, nothing to trace yet.

mod integrators;
mod lights;
mod materials;
mod media;
mod sensors;
mod shapes;
mod spectra;

pub use integrators::{Aov, AovKind, Integrator, IntegratorKind, Moments};
pub use lights::{Light, LightKind};
pub use materials::{
    Alpha, Bsdf, BsdfKind, CoatRoughness, ConductorIndex, FibreAbsorption, MeasuredSource, MetalAssumption,
    NormalMapShading, PrincipledBase, Roughness,
};
pub use media::{
    DensitySource, EmissionSource, ExponentialSource, FlakeMatrix, Medium, MediumContent, MieSource, Phase,
    PhaseKind, SampledSource,
};
pub use sensors::{
    AngularMap, Aperture, Crop, DistantTarget, FieldOfView, Film, FilmChannel, FilmContent, FovAxis, Lens,
    PixelFormat, Sampler, Sensor, SensorKind,
};
pub use shapes::{
    Animation, HeightSource, Instance, MeshFormat, Part, Priority, ShapeDescription, ShapeGroup, ShapeKind,
    Solid,
};
pub use spectra::{
    BitmapSource, CheckerboardSource, IndexKind, IndexSource, PatternSpace, ProceduralSource, RgbRole,
    SpectrumKind, SpectrumSource, VolumeSource,
};

use super::source::{Place, Sources};
use crate::units::WavelengthRange;
use std::collections::BTreeSet;
use std::path::PathBuf;

/// What a scene file says.
#[derive(Clone, Debug)]
pub struct Description {
    /// The files that it was read from, for messages that point into them.
    pub sources: Sources,
    /// Where all is that it was read from: scene files, images, meshes, tables.
    pub files: BTreeSet<PathBuf>,
    /// How light is followed.
    pub integrator: Integrator,
    /// The sensor that is rendered, one of those that the file may have.
    pub sensor: Sensor,
    /// Shapes that are no part of a solid or a group.
    pub shapes: Vec<ShapeDescription>,
    /// Solids by union, intersection and difference.
    pub solids: Vec<Solid>,
    /// Groups where they stand.
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

impl Description {
    /// The same without the notes that are about wavelengths outside of a range alone.
    pub fn over(mut self, range: WavelengthRange) -> Self {
        for notes in [&mut self.assumptions, &mut self.remarks] {
            notes.retain(|note| note.concerns(range));
        }
        self
    }
}

/// A remark tied to a place.
#[derive(Clone, Debug)]
pub struct Note {
    /// What the note is about.
    pub place: Place,
    /// The sentence that is printed.
    pub text: String,
    /// Where it is about wavelengths outside of a range alone, that range: a render within has nothing to do
    /// with it.
    pub beyond: Option<WavelengthRange>,
}

impl Note {
    /// A remark at a place.
    pub fn new(place: &Place, text: String) -> Self {
        Self { place: place.clone(), text, beyond: None }
    }

    /// Whether it is about a render of these wavelengths.
    pub fn concerns(&self, range: WavelengthRange) -> bool {
        self.beyond.is_none_or(|known| range.min < known.min || range.max > known.max)
    }
}
