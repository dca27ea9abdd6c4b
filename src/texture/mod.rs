//! Textures: functions of wavelength that may vary over a surface.

use crate::geometry::Vec3;
use crate::shape::Mesh;
use crate::spectrum::{Sampled, Spectrum};
use crate::units::WavelengthRange;

/// A quantity over wavelength and surface.
#[derive(Clone, Debug)]
pub enum Texture {
    /// The same everywhere.
    Uniform(Spectrum),
}

/// Where on a surface a texture is asked for.
#[derive(Clone, Copy, Debug)]
pub struct TexturePoint<'a> {
    pub uv: [f64; 2],
    /// In the coordinates of the compiled scene.
    pub position: Vec3,
    /// The place on a mesh, for what its vertices and faces carry.
    pub mesh: Option<MeshPoint<'a>>,
}

/// A place on a mesh.
#[derive(Clone, Copy, Debug)]
pub struct MeshPoint<'a> {
    pub mesh: &'a Mesh,
    pub triangle: u32,
    /// Weights of the triangle's second and third vertex.
    pub barycentric: [f64; 2],
}

impl Texture {
    /// The values at the wavelengths of a path.
    pub fn sample<const C: usize>(&self, _at: &TexturePoint, nm: &[f64; C]) -> Sampled<C> {
        match self {
            Self::Uniform(spectrum) => spectrum.sample(nm),
        }
    }

    /// The value of a texture without wavelength, such as a roughness, an opacity or a weight.
    pub fn value(&self, _at: &TexturePoint) -> f64 {
        match self {
            Self::Uniform(spectrum) => spectrum.at(SCALAR_NM),
        }
    }

    /// The three channels of an image as they are, for what is no colour.
    pub fn rgb(&self, at: &TexturePoint) -> [f64; 3] {
        [self.value(at); 3]
    }

    /// ∂/∂u and ∂/∂v of [`Self::value`].
    pub fn gradient(&self, _at: &TexturePoint) -> [f64; 2] {
        match self {
            Self::Uniform(_) => [0.0; 2],
        }
    }

    /// Whether the values depend on where they are asked for.
    pub fn varies(&self) -> bool {
        match self {
            Self::Uniform(_) => false,
        }
    }

    /// Whether it is zero everywhere at all wavelengths of a range.
    pub fn is_zero(&self, range: WavelengthRange) -> bool {
        match self {
            Self::Uniform(spectrum) => spectrum.is_zero(range),
        }
    }

    /// Columns and rows of a picture; 1 × 1 for what is none.
    pub fn resolution(&self) -> [u32; 2] {
        match self {
            Self::Uniform(_) => [1, 1],
        }
    }

    /// The spectrum of a texture that is the same everywhere.
    pub fn uniform(&self) -> Option<&Spectrum> {
        match self {
            Self::Uniform(spectrum) => Some(spectrum),
        }
    }
}

/// Where a constant that stands for no function of wavelength is looked up.
const SCALAR_NM: f64 = 550.0;
