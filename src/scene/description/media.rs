//! Media and phase functions as a scene file says them.

use super::spectra::SpectrumSource;
use crate::scene::source::Place;

/// `homogeneous` or `heterogeneous`.
#[derive(Clone, Debug)]
pub struct Medium {
    pub place: Place,
    pub id: Option<String>,
    /// Whether it may vary from place to place: `heterogeneous`.
    pub varies: bool,
    /// What is absorbed and scattered per unit of length, `scale` included.
    pub extinction: SpectrumSource,
    /// The fraction of it that is scattered.
    pub albedo: SpectrumSource,
    pub phase: Phase,
}

/// In what directions a medium scatters.
#[derive(Clone, Debug)]
pub struct Phase {
    pub place: Place,
    pub kind: PhaseKind,
}

/// Phase functions.
#[derive(Clone, Debug)]
pub enum PhaseKind {
    Isotropic,
    /// With the mean cosine, between −1 and 1.
    HenyeyGreenstein {
        g: f64,
    },
    Rayleigh,
    /// Values at equal steps of the cosine from −1 (straight back) to 1 (straight ahead), up to a factor.
    Tabulated {
        values: Vec<f64>,
    },
    /// The first, and the second by its weight.
    Blend {
        weight: SpectrumSource,
        nested: Box<[Phase; 2]>,
    },
}
