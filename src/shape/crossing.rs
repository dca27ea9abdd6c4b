//! All places where a line meets a surface: what cutting bodies with one another asks for.

use super::{Hit, NO_INSTANCE};
use smallvec::SmallVec;

/// Where a line crosses a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The hit; t is negative behind the ray's origin.
    pub hit: Hit,
    /// Bound on the error of t. Of two neighbours that are no further apart than their bounds it isn't
    /// certain that they are there: the line all but touches.
    pub error: f64,
    /// Whether the line goes against the geometric normal: into a closed shape whose normals point outward.
    pub enters: bool,
}

/// In ascending order of t. Only meshes ever need more room than there is.
pub type Crossings = SmallVec<[Crossing; 4]>;

impl Crossing {
    /// A crossing with a part of a shape that is no mesh.
    pub(super) fn analytic(t: f64, error: f64, enters: bool, part: u32) -> Self {
        let hit = Hit { t, shape: 0, triangle: part, instance: NO_INSTANCE, barycentric: [0.0; 2] };
        Self { hit, error, enters }
    }
}
