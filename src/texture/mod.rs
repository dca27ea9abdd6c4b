//! Textures: functions of wavelength that may vary over a surface.
//!
//! What a texture gives depends on who asks, as in Mitsuba 3: a spectrum ([`Texture::sample`]), one number
//! ([`Texture::value`]), three numbers that are no colour ([`Texture::rgb`]), a slope
//! ([`Texture::gradient`]). The reader of scene files refuses textures that cannot give what they are asked
//! for.

mod attribute;
mod bitmap;
mod checkerboard;
mod noise;
mod pattern;
mod procedural;
#[cfg(test)]
mod tests;
mod uv;
mod volume;

pub use attribute::Attribute;
pub use bitmap::{Bitmap, Filter, Placing};
pub use checkerboard::Checkerboard;
pub use noise::Octaves;
pub use pattern::{Pattern, Veins};
pub use procedural::{Ground, Procedural};
pub use uv::{Lines, Wrap};
pub use volume::{Volume, from_box};

use crate::geometry::Vec3;
use crate::shape::{AtRest, Mesh};
use crate::spectrum::{Extrapolation, Sampled, Spectrum, upsample};
use crate::units::WavelengthRange;

/// A quantity over wavelength and surface.
#[derive(Clone, Debug)]
pub enum Texture {
    /// The same everywhere.
    Uniform(Spectrum),
    /// An image.
    Bitmap(Box<Bitmap>),
    /// Two textures in turn.
    Checkerboard(Box<Checkerboard>),
    /// What a mesh carries at its vertices or faces.
    Attribute(Attribute),
    /// Values on a grid in space.
    Volume(Box<Volume>),
    /// A formula.
    Procedural(Box<Procedural>),
    /// Another texture times a spectrum.
    Filtered {
        /// The texture.
        texture: Box<Texture>,
        /// The spectrum.
        by: Spectrum,
    },
}

/// Where on a surface a texture is asked for.
#[derive(Clone, Copy, Debug)]
pub struct TexturePoint<'a> {
    /// Coordinates u and v of the surface.
    pub uv: [f64; 2],
    /// Position in the coordinates of the compiled scene.
    pub position: Vec3,
    /// The same point before instances and motion, for what sticks to a body.
    pub at_rest: AtRest,
    /// The place on a mesh, for what its vertices and faces carry.
    pub mesh: Option<MeshPoint<'a>>,
}

impl TexturePoint<'_> {
    /// A place that is on no surface.
    pub fn in_space(position: Vec3) -> Self {
        Self { uv: [0.0; 2], position, at_rest: AtRest { position, ..AtRest::NONE }, mesh: None }
    }
}

/// A place on a mesh.
#[derive(Clone, Copy, Debug)]
pub struct MeshPoint<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// Number of the triangle.
    pub triangle: u32,
    /// Weights of the triangle's second and third vertex.
    pub barycentric: [f64; 2],
}

impl Texture {
    /// The values at the wavelengths of a path.
    #[inline]
    pub fn sample<const C: usize>(&self, at: &TexturePoint, nm: &[f64; C]) -> Sampled<C> {
        match self {
            Self::Uniform(spectrum) => spectrum.sample(nm),
            Self::Bitmap(bitmap) => bitmap.sample(at, nm),
            Self::Checkerboard(board) => board.sample(at, nm),
            Self::Attribute(attribute) => attribute.sample(at, nm),
            Self::Volume(volume) => volume.sample(at, nm),
            Self::Procedural(procedural) => procedural.sample(at, nm),
            Self::Filtered { texture, by } => texture.sample(at, nm) * by.sample(nm),
        }
    }

    /// The value of a texture without wavelength, such as a roughness, an opacity or a weight.
    #[inline]
    pub fn value(&self, at: &TexturePoint) -> f64 {
        match self {
            Self::Uniform(spectrum) => scalar(spectrum),
            Self::Bitmap(bitmap) => bitmap.value(at),
            Self::Checkerboard(board) => board.value(at),
            Self::Attribute(attribute) => attribute.value(at),
            Self::Volume(volume) => volume.value(at),
            Self::Procedural(procedural) => procedural.value(at),
            Self::Filtered { texture, by } => texture.value(at) * scalar(by),
        }
    }

    /// The three channels of an image as they are, for what is no colour.
    pub fn rgb(&self, at: &TexturePoint) -> [f64; 3] {
        match self {
            Self::Bitmap(bitmap) => bitmap.rgb(at),
            Self::Attribute(attribute) => attribute.rgb(at),
            Self::Volume(volume) => volume.rgb(at),
            Self::Uniform(_) | Self::Checkerboard(_) | Self::Procedural(_) | Self::Filtered { .. } => {
                [self.value(at); 3]
            }
        }
    }

    /// ∂/∂u and ∂/∂v of [`Self::value`].
    pub fn gradient(&self, at: &TexturePoint) -> [f64; 2] {
        match self {
            Self::Bitmap(bitmap) => bitmap.gradient(at),
            Self::Procedural(procedural) => procedural.gradient(at),
            Self::Filtered { texture, by } => texture.gradient(at).map(|slope| slope * scalar(by)),
            // What only the reader of a scene could ask of the others, and does not.
            Self::Uniform(_) | Self::Checkerboard(_) | Self::Attribute(_) | Self::Volume(_) => [0.0; 2],
        }
    }

    /// Whether the values depend on where they are asked for.
    pub fn varies(&self) -> bool {
        match self {
            Self::Uniform(_) => false,
            Self::Filtered { texture, .. } => texture.varies(),
            Self::Bitmap(_)
            | Self::Checkerboard(_)
            | Self::Attribute(_)
            | Self::Volume(_)
            | Self::Procedural(_) => true,
        }
    }

    /// The same with all tables held beyond their ends, as those of an index are.
    pub fn held(self) -> Self {
        let hold = |spectrum: Spectrum| spectrum.with_extrapolation(Extrapolation::Hold);
        match self {
            Self::Uniform(spectrum) => Self::Uniform(hold(spectrum)),
            Self::Checkerboard(board) => Self::Checkerboard(Box::new(Checkerboard {
                colours: board.colours.map(Self::held),
                ..*board
            })),
            Self::Procedural(pattern) => Self::Procedural(Box::new(Procedural {
                colours: pattern.colours.into_iter().map(Self::held).collect(),
                ..*pattern
            })),
            Self::Filtered { texture, by } => {
                Self::Filtered { texture: Box::new(texture.held()), by: hold(by) }
            }
            Self::Bitmap(_) | Self::Attribute(_) | Self::Volume(_) => self,
        }
    }

    /// Whether it is zero everywhere at all wavelengths of a range.
    pub fn is_zero(&self, range: WavelengthRange) -> bool {
        match self {
            Self::Uniform(spectrum) => spectrum.is_zero(range),
            Self::Bitmap(bitmap) => bitmap.is_zero(),
            Self::Checkerboard(board) => board.colours.iter().all(|colour| colour.is_zero(range)),
            Self::Attribute(attribute) => attribute.scale == 0.0,
            Self::Volume(volume) => volume.max_bound() == 0.0,
            Self::Procedural(procedural) => procedural.colours.iter().all(|colour| colour.is_zero(range)),
            Self::Filtered { texture, by } => texture.is_zero(range) || by.is_zero(range),
        }
    }

    /// About the mean over the surface: above zero wherever a value is, for the choice of wavelengths and
    /// lights.
    pub fn mean_spectrum(&self, range: WavelengthRange) -> Spectrum {
        match self {
            Self::Uniform(spectrum) => spectrum.clone(),
            Self::Bitmap(bitmap) => bitmap.mean_spectrum(),
            Self::Checkerboard(board) => {
                let [a, b] = [0, 1].map(|i| board.colours[i].mean_spectrum(range));
                tabulated(range, &[&a, &b], |nm| 0.5 * (a.at(nm) + b.at(nm)))
            }
            // Known only to the meshes.
            Self::Attribute(attribute) => Spectrum::Constant(0.5 * attribute.scale),
            Self::Volume(volume) => {
                let mean = volume.mean().map(|value| value.max(0.0));
                let scale = 2.0 * mean.into_iter().fold(f64::MIN_POSITIVE, f64::max);
                Spectrum::Sigmoid { shape: upsample(mean.map(|value| value / scale)), factor: scale }
            }
            Self::Procedural(procedural) => procedural.mean_spectrum(range),
            Self::Filtered { texture, by } => {
                let within = texture.mean_spectrum(range);
                tabulated(range, &[by, &within], |nm| within.at(nm) * by.at(nm))
            }
        }
    }

    /// No value over the range is above it, as far as that can be known.
    pub fn max_bound(&self, range: WavelengthRange) -> f64 {
        match self {
            Self::Uniform(spectrum) => spectrum.bounds(range).1,
            Self::Bitmap(bitmap) => bitmap.max_bound(),
            Self::Checkerboard(board) => greatest(&board.colours, range),
            Self::Procedural(procedural) => greatest(&procedural.colours, range),
            Self::Attribute(attribute) => attribute.scale,
            Self::Volume(volume) => volume.max_bound(),
            Self::Filtered { texture, by } => texture.max_bound(range) * by.bounds(range).1,
        }
    }

    /// Columns and rows of a picture; 1 × 1 for what is none.
    pub fn resolution(&self) -> [u32; 2] {
        match self {
            Self::Bitmap(bitmap) => bitmap.resolution(),
            Self::Filtered { texture, .. } => texture.resolution(),
            Self::Uniform(_)
            | Self::Checkerboard(_)
            | Self::Attribute(_)
            | Self::Volume(_)
            | Self::Procedural(_) => [1, 1],
        }
    }

    /// The lines of uv between which its spectra are bilinear, or the same. `None` where there are none, or
    /// they are not known.
    pub fn lines(&self) -> Option<Lines> {
        match self {
            Self::Bitmap(bitmap) => Some(bitmap.lines()),
            Self::Checkerboard(board) if !board.colours.iter().any(Self::varies) => Some(board.lines()),
            Self::Filtered { texture, .. } => texture.lines(),
            Self::Uniform(_)
            | Self::Checkerboard(_)
            | Self::Attribute(_)
            | Self::Volume(_)
            | Self::Procedural(_) => None,
        }
    }

    /// The spectrum of a texture that is the same everywhere.
    pub fn uniform(&self) -> Option<&Spectrum> {
        match self {
            Self::Uniform(spectrum) => Some(spectrum),
            _ => None,
        }
    }

    /// [`Self::value`] of a texture that is the same everywhere.
    pub fn uniform_value(&self) -> Option<f64> {
        self.uniform().map(scalar)
    }

    /// The names of the attributes that a mesh must have.
    pub fn attributes(&self) -> Vec<&str> {
        match self {
            Self::Attribute(attribute) => vec![&attribute.name],
            Self::Checkerboard(board) => board.colours.iter().flat_map(Self::attributes).collect(),
            Self::Procedural(procedural) => procedural.colours.iter().flat_map(Self::attributes).collect(),
            Self::Filtered { texture, .. } => texture.attributes(),
            Self::Uniform(_) | Self::Bitmap(_) | Self::Volume(_) => Vec::new(),
        }
    }
}

/// The greatest bound of several textures.
fn greatest(textures: &[Texture], range: WavelengthRange) -> f64 {
    textures.iter().map(|texture| texture.max_bound(range)).fold(f64::NEG_INFINITY, f64::max)
}

/// A spectrum as one number: a colour's is its mean, as in Mitsuba 3.
fn scalar(spectrum: &Spectrum) -> f64 {
    /// Where a spectrum that is no constant, which the reader refuses as a number, is looked up.
    const NM: f64 = 550.0;
    match spectrum {
        Spectrum::Constant(value) => *value,
        Spectrum::Sigmoid { shape, factor } => factor * shape.mean(),
        other => other.at(NM),
    }
}

/// A function of spectra as a table over a range; the first of them where the range is empty.
fn tabulated(range: WavelengthRange, of: &[&Spectrum], at: impl Fn(f64) -> f64) -> Spectrum {
    Spectrum::tabulated(range, 1.0, of, Extrapolation::Zero, at).unwrap_or_else(|_| of[0].clone())
}
