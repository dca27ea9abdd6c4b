//! Media and phase functions as a scene file says them.

use super::spectra::{IndexSource, SpectrumSource, VolumeSource};
use crate::geometry::Transform;
use crate::phase::mie::Sizes;
use crate::scene::source::Place;
use std::sync::Arc;

/// What fills a shape, or surrounds the sensor.
#[derive(Clone, Debug)]
pub struct Medium {
    /// Where the file declares it.
    pub place: Place,
    /// Its `id`, by which the file refers to it.
    pub id: Option<String>,
    /// What it consists of.
    pub content: MediumContent,
    /// Light that it sends out (an extension).
    pub emission: Option<EmissionSource>,
    /// How much there is of it from place to place (an extension).
    pub density: Option<DensitySource>,
}

/// What a medium consists of.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "a scene has few media")]
pub enum MediumContent {
    /// `homogeneous` or `heterogeneous`.
    Plain {
        /// Whether it may vary from place to place: `heterogeneous`.
        varies: bool,
        /// What is absorbed and scattered per unit of length, `scale` included.
        extinction: SpectrumSource,
        /// The fraction of it that is scattered.
        albedo: SpectrumSource,
        /// How it scatters.
        phase: Phase,
    },
    /// Particles and what they are in: extinction, albedo and phase function follow (an extension).
    Suspension {
        /// `mie` and `air`, with how much there is of each.
        particles: Vec<Phase>,
        /// Absorption of what they are in, per unit of length.
        absorption: SpectrumSource,
        /// Length of the file's unit, m.
        metres: f64,
    },
}

/// What a medium sends out.
#[derive(Clone, Debug)]
pub enum EmissionSource {
    /// Radiance per unit of length.
    Radiance(SpectrumSource),
    /// K: black bodies, as far as it absorbs.
    Temperature(SpectrumSource),
}

/// How the density of a medium varies.
#[derive(Clone, Debug)]
pub enum DensitySource {
    /// A grid of numbers.
    Grid(SpectrumSource),
    /// It falls off with height.
    Exponential(ExponentialSource),
    /// A pattern in space, sampled on a grid.
    Sampled(Box<SampledSource>),
}

/// A pattern in space, looked up at the centres of cells that fill the unit cube.
#[derive(Clone, Debug)]
pub struct SampledSource {
    /// A texture that is computed in space.
    pub pattern: SpectrumSource,
    /// Cells along each axis.
    pub resolution: u32,
    /// From the unit cube to the scene's coordinates.
    pub to_world: Transform,
}

/// The density of an atmosphere.
#[derive(Clone, Debug)]
pub struct ExponentialSource {
    /// From its own coordinates, in which +z is up, to the scene's.
    pub to_world: Transform,
    /// Radius of the ground; flat where there is none.
    pub radius: Option<f64>,
    /// Height over which the density falls by a factor of e, in units of its own coordinates. Above 0.
    pub scale_height: f64,
    /// Height above which there is nothing; otherwise 12 scale heights.
    pub top: Option<f64>,
}

/// In what directions a medium scatters.
#[derive(Clone, Debug)]
pub struct Phase {
    /// Where the file declares it.
    pub place: Place,
    /// Which phase function it is, with its parameters.
    pub kind: PhaseKind,
}

/// Phase functions.
#[derive(Clone, Debug)]
pub enum PhaseKind {
    /// The same in all directions.
    Isotropic,
    /// With the mean cosine, between −1 and 1.
    HenyeyGreenstein {
        /// Mean cosine of the scattering angle: positive where it scatters ahead.
        g: f64,
    },
    /// Rayleigh's, for particles much smaller than the wavelength.
    Rayleigh,
    /// Values at equal steps of the cosine from −1 (straight back) to 1 (straight ahead), up to a factor.
    Tabulated {
        /// Values from straight back to straight ahead, at least 0.
        values: Vec<f64>,
    },
    /// The first, and the second by its weight.
    Blend {
        /// Weight of the second, from 0 to 1.
        weight: SpectrumSource,
        /// The two phase functions.
        nested: Box<[Phase; 2]>,
    },
    /// S_xx, S_yy, S_zz, S_xy, S_xz and S_yz of the ellipsoid of flakes.
    Sggx {
        /// The elements, in this order, and where they come from.
        matrix: FlakeMatrix,
    },
    /// Spheres (an extension).
    Mie(Box<MieSource>),
    /// Molecules of air, so many times those at 288.15 K and 1013.25 hPa (an extension).
    Air {
        /// Number density over the standard one, at least 0.
        amount: f64,
    },
}

/// The matrix of `sggx`.
#[derive(Clone, Debug)]
pub struct FlakeMatrix {
    /// Its six elements.
    pub elements: [f64; 6],
    /// The grid that has them in all its cells, where the file states one.
    pub grid: Option<Arc<VolumeSource>>,
    /// Where the file states it.
    pub place: Place,
}

/// Spheres in a medium that absorbs nothing.
#[derive(Clone, Debug)]
pub struct MieSource {
    /// How large the spheres are.
    pub sizes: Sizes,
    /// n and k of the spheres.
    pub index: IndexSource,
    /// Imaginary part of the spheres' index, at least 0.
    pub k: SpectrumSource,
    /// n of the medium around them.
    pub host: IndexSource,
    /// The fraction of space that they fill; what only a phase function is has none.
    pub fraction: Option<f64>,
}
