//! What is estimated, and where paths end.

/// How the radiance along a camera ray is estimated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Integrator {
    /// Path tracing with next-event estimation.
    Path,
    /// Scattering alone: the oracle.
    Walk,
    /// No light at all: the distance of what is seen first takes the place of the radiance, at all
    /// wavelengths.
    Depth,
}

/// How light is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Techniques {
    /// By scattering and by light samples, each weighed against the other.
    Both,
    /// By scattering alone. Lights without extent are never found.
    Scattering,
    /// By light samples alone. Mirror images of lights are never found.
    LightSamples,
}

/// Where paths end and what they see.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Most segments of a path, the camera ray included.
    pub max_depth: u32,
    /// Segments from which Russian roulette may end a path.
    pub rr_depth: u32,
    /// Whether lights are invisible to camera rays.
    pub hide_emitters: bool,
    /// Whether null transmission makes a segment of its own. Then such a surface also hides lights without
    /// extent.
    pub null_is_a_segment: bool,
    /// How light is found.
    pub techniques: Techniques,
    /// Whether distances in media are chosen near lamps, too. The expectation is the same without.
    pub aims_at_lamps: bool,
    /// Whether paths split at clear glass. The expectation is the same without.
    pub splits_at_glass: bool,
    /// What alpha counts as something.
    pub coverage: Coverage,
}

impl Limits {
    /// Whether light may reach a surface by way of another and be found by scattering.
    pub fn allow_caustics(&self) -> bool {
        self.max_depth >= 3 && self.techniques != Techniques::LightSamples
    }
}

/// What alpha counts as something (Mitsuba 3.9.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coverage {
    /// A surface of any kind (`direct`).
    Surface,
    /// Light from beyond the scene, if there is any and the camera sees it, or a surface that the ray does
    /// not pass as if there were none.
    Obstacle,
}
