//! Spectra, textures and refractive indices as a scene file says them.

use crate::geometry::Transform;
use crate::raster::{Grid, Image};
use crate::scene::source::Place;
use crate::spectrum::{DispersionFormula, catalogue};
use crate::texture::{Filter, Pattern, Wrap};
use crate::units::WavelengthRange;
use std::path::PathBuf;
use std::sync::Arc;

/// A spectrum as the file gives it.
#[derive(Clone, Debug)]
pub struct SpectrumSource {
    /// Where the file declares it.
    pub place: Place,
    /// Which spectrum or texture it is, with its parameters.
    pub kind: SpectrumKind,
    /// Factor on all values.
    pub scale: f64,
}

/// A function of wavelength, which may vary over a surface or in space.
#[derive(Clone, Debug)]
pub enum SpectrumKind {
    /// The same at all wavelengths.
    Constant(f64),
    /// Linear between the nodes (strictly ascending, nm), zero outside, as in Mitsuba 3:
    /// a `wavelength:value` list, `irregular`, or a `.spd` file.
    Irregular {
        /// Wavelengths, nm.
        nm: Vec<f64>,
        /// Values at them.
        values: Vec<f64>,
        /// The file that they come from; `None` where the scene has them.
        file: Option<PathBuf>,
    },
    /// Equally spaced values, linear between them, zero outside.
    Regular {
        /// Wavelength of the first value, nm.
        min_nm: f64,
        /// Wavelength of the last value, nm.
        max_nm: f64,
        /// The values, at least two.
        values: Vec<f64>,
    },
    /// Mitsuba's `d65`: the CIE table over 98.9974.
    D65,
    /// Planck's law, W·m⁻²·sr⁻¹·nm⁻¹, zero outside the range.
    Blackbody {
        /// Temperature, K.
        kelvin: f64,
        /// First wavelength, nm.
        min_nm: f64,
        /// Last wavelength, nm.
        max_nm: f64,
    },
    /// One of the measured spectra compiled into the program (an extension).
    Named(String),
    /// A smooth spectrum that has a colour: linear values for the primaries of sRGB.
    Rgb {
        /// Red, green and blue.
        rgb: [f64; 3],
        /// What the colour describes, which settles its spectrum.
        role: RgbRole,
    },
    /// Three numbers that are no colour: a normal that is the same everywhere.
    Vector([f64; 3]),
    /// An image on the surface.
    Bitmap(Arc<BitmapSource>),
    /// Two textures in turn.
    Checkerboard(Arc<CheckerboardSource>),
    /// What the vertices or faces of a mesh carry under a name that begins with `vertex_` or `face_`.
    MeshAttribute {
        /// The name of the attribute.
        name: String,
    },
    /// Values in space.
    Volume(Arc<VolumeSource>),
    /// A pattern that is computed (an extension).
    Procedural(Arc<ProceduralSource>),
    /// Another spectrum or texture times D65.
    Daylit(Arc<SpectrumSource>),
}

/// What a colour is made into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RgbRole {
    /// Values from 0 to 1.
    Reflectance,
    /// Values below 0 count as 0, and above 1 as 1: what Mitsuba 3 makes of colours where it expects no
    /// reflectance.
    Clipped,
    /// A reflectance times D65, scaled to the brightness of the colour.
    Illuminant,
}

/// An image on the coordinates u and v.
#[derive(Clone, Debug)]
pub struct BitmapSource {
    /// File of the image, relative to the scene's folder.
    pub file: PathBuf,
    /// Its pixels.
    pub image: Arc<Image>,
    /// What is between the middles of pixels.
    pub filter: Filter,
    /// What is beyond the edges.
    pub wrap: Wrap,
    /// Whether values are taken as they stand in the file, not decoded and not made into spectra.
    pub raw: bool,
    /// Whether what is looked up is kept in half precision (`format` "fp16").
    pub half: bool,
    /// From the shape's uv to the texture's.
    pub to_uv: Transform,
}

/// Two textures in turn.
#[derive(Clone, Debug)]
pub struct CheckerboardSource {
    /// Colours at the origin, and beside it.
    pub colours: [SpectrumSource; 2],
    /// From the shape's uv to the texture's, in which a pattern is 1 wide.
    pub to_uv: Transform,
}

/// `gridvolume`; a `constvolume` is the spectrum that it holds.
#[derive(Clone, Debug)]
pub struct VolumeSource {
    /// File of the grid, relative to the scene's folder.
    pub file: PathBuf,
    /// Its values.
    pub grid: Arc<Grid>,
    /// From the unit cube that the grid fills to the scene.
    pub to_world: Transform,
    /// What is between the middles of cells.
    pub filter: Filter,
    /// What is beyond the faces.
    pub wrap: Wrap,
    /// Whether values are taken as they are, not as colours.
    pub raw: bool,
    /// Whether the grid fills the box that its file states, and not the unit cube.
    pub use_grid_bbox: bool,
}

/// A pattern that selects between other textures or mixes them.
#[derive(Clone, Debug)]
pub struct ProceduralSource {
    /// The formula.
    pub pattern: Pattern,
    /// The coordinates that it is computed in.
    pub space: PatternSpace,
    /// The size of a cell of noise, and the distance between veins, rings, bands: in the file's units, or
    /// those of uv.
    pub period: f64,
    /// For values of the pattern from the least to the greatest.
    pub colours: Vec<SpectrumSource>,
    /// The values of the pattern that are the first and the last colour.
    pub range: [f64; 2],
    /// Whether colours are mixed, and not each the only one over its fraction of the values.
    pub mixed: bool,
}

/// What a pattern is computed from.
#[derive(Clone, Copy, Debug)]
pub enum PatternSpace {
    /// The surface's coordinates, with a transform to those of the pattern.
    Uv(Transform),
    /// The place where the surface is at rest, with a transform from the pattern's coordinates.
    World(Transform),
}

impl SpectrumSource {
    /// The one value that it has at all wavelengths, if it is given like that.
    pub fn constant(&self) -> Option<f64> {
        match self.kind {
            SpectrumKind::Constant(value) => Some(value * self.scale),
            _ => None,
        }
    }

    /// The spectra that it is made of.
    pub fn parts(&self) -> Vec<&Self> {
        match &self.kind {
            SpectrumKind::Checkerboard(board) => board.colours.iter().flat_map(Self::parts).collect(),
            SpectrumKind::Procedural(pattern) => pattern.colours.iter().flat_map(Self::parts).collect(),
            SpectrumKind::Daylit(nested) => nested.parts(),
            _ => vec![self],
        }
    }

    /// The wavelengths that a table of the file covers; `None` for what is no table.
    pub fn domain(&self) -> Option<WavelengthRange> {
        match &self.kind {
            SpectrumKind::Irregular { nm, .. } => {
                Some(WavelengthRange { min: *nm.first()?, max: *nm.last()? })
            }
            SpectrumKind::Regular { min_nm, max_nm, .. } => {
                Some(WavelengthRange { min: *min_nm, max: *max_nm })
            }
            SpectrumKind::Named(name) => catalogue::reflectance(name).ok()?.domain(),
            _ => None,
        }
    }
}

/// A refractive index, real.
#[derive(Clone, Debug)]
pub struct IndexSource {
    /// Where the file declares it.
    pub place: Place,
    /// Which index it is, with its parameters.
    pub kind: IndexKind,
}

/// How an index is given.
#[derive(Clone, Debug)]
pub enum IndexKind {
    /// The same at all wavelengths.
    Constant(f64),
    /// A catalogue glass or other material with its dispersion (an extension).
    Named(String),
    /// Sellmeier or Cauchy coefficients (an extension).
    Formula(DispersionFormula),
    /// Tabulated n(λ), held constant beyond its ends (an extension).
    Tabulated(SpectrumSource),
    /// From the reflectance at normal incidence, k = 0 (an extension; Glassner, *An Introduction to Ray
    /// Tracing*, ch. 4, eq. 18). Held constant beyond the ends of its table.
    NormalReflectance {
        /// Reflectance against air at normal incidence, from 0 to below 1.
        reflectance: SpectrumSource,
        /// Whether it is that of a polished, clear slab with its back face, and not that of one face.
        slab: bool,
    },
}
