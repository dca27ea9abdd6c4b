//! Why a shape cannot be made.

use std::fmt;

/// How far shapes may reach from the middle of the scene. Trees are built and searched in single precision,
/// where the area of a box has to be a number.
pub const FARTHEST: f64 = 1e18;

/// Why a shape cannot be made.
#[derive(Clone, Debug, PartialEq)]
pub enum ShapeError {
    /// A radius must be positive and finite.
    Radius(f64),
    /// The two ends of an axis coincide or are not finite.
    Ends,
    /// The tube of a torus is as thick as its ring or thicker.
    Tube {
        /// From the centre to the middle of the tube.
        major: f64,
        /// Radius of the tube.
        minor: f64,
    },
    /// A curve has too few control points.
    ControlPoints {
        /// How many it has.
        found: usize,
        /// How many it needs.
        least: usize,
    },
    /// All coefficients of a quadric vanish, or some are not finite.
    Coefficients,
    /// A quadric goes on without end.
    Endless,
    /// There is no real surface where it is asked for.
    Nothing,
    /// A grid has fewer than two points along an axis, or not a value for each of its points.
    GridPoints,
    /// The base of a height field isn't below all of it.
    Base,
    /// Contours are not finite or enclose no area.
    Outline,
    /// A profile is not finite, has too few points, or reaches over the axis.
    Profile,
    /// The threshold of blobs is not above 0, or something of them is not finite.
    Threshold,
    /// An exponent of a superquadric is out of range.
    Exponent(f64),
    /// The placement makes the shape too thin or too large to compute with.
    Placement,
    /// It reaches farther than [`FARTHEST`] from the middle of the scene.
    Far,
    /// A triangle refers to a vertex that does not exist.
    VertexIndex {
        /// Number of the triangle.
        triangle: usize,
        /// Number of the vertex that it names.
        index: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A coordinate of a position, normal or uv is infinite or not a number.
    NotFinite {
        /// Name of the attribute, such as `normal`.
        attribute: &'static str,
        /// Number of the vertex.
        vertex: usize,
    },
    /// There must be as many normals and uvs as positions.
    AttributeCount {
        /// Name of the attribute, such as `normal`.
        attribute: &'static str,
        /// How many there are.
        found: usize,
        /// How many vertices there are.
        vertices: usize,
    },
    /// An attribute must have one or three numbers for each vertex or triangle.
    AttributeValues {
        /// How many numbers there are.
        found: usize,
        /// How many there should be.
        expected: usize,
    },
    /// A deformation turns a mesh inside out at a vertex.
    Folded {
        /// Number of the vertex.
        vertex: usize,
    },
    /// Subdivision would make more triangles of a mesh than it may.
    TooFine {
        /// How many triangles it may have.
        most: usize,
    },
    /// More triangles or vertices than 32-bit indices can name.
    TooLarge,
}

impl fmt::Display for ShapeError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Radius(radius) => write!(f, "a radius must be positive and finite, not {radius}"),
            Self::Ends => write!(f, "the ends of an axis must be finite and differ"),
            Self::Tube { major, minor } => {
                write!(f, "the radius of a torus's tube, {minor}, must be below that of its ring, {major}")
            }
            Self::ControlPoints { found, least } => {
                write!(f, "a curve has {found} control points and needs at least {least}")
            }
            Self::Coefficients => write!(f, "the coefficients must be finite and not all zero"),
            Self::Endless => write!(f, "it goes on without end unless it is cut off by planes on all sides"),
            Self::Nothing => write!(f, "there is no such surface, or none between the planes"),
            Self::Base => write!(f, "the base must be below all heights"),
            Self::GridPoints => {
                write!(f, "a grid needs two points along each axis and a value for each point")
            }
            Self::Exponent(exponent) => write!(f, "its exponents must be from 0.001 to 2, not {exponent}"),
            Self::Profile => write!(f, "its profile must be finite, long enough and on one side of the axis"),
            Self::Threshold => {
                write!(f, "all numbers must be finite, and its threshold above 0 and reached somewhere")
            }
            Self::Outline => write!(f, "its outline must be finite and enclose an area"),
            Self::Placement => {
                write!(f, "the transform makes the shape too thin or too large to compute with")
            }
            Self::Far => write!(f, "it reaches farther than {FARTHEST:e} from the middle of the scene"),
            Self::VertexIndex { triangle, index, vertices } => {
                write!(f, "triangle {triangle} refers to vertex {index}, but there are {vertices} vertices")
            }
            Self::NotFinite { attribute, vertex } => {
                write!(f, "the {attribute} of vertex {vertex} is not finite")
            }
            Self::AttributeCount { attribute, found, vertices } => {
                write!(f, "there are {found} {attribute}s for {vertices} vertices")
            }
            Self::AttributeValues { found, expected } => {
                write!(f, "an attribute has {found} numbers instead of {expected}")
            }
            Self::Folded { vertex } => write!(f, "vertex {vertex} is folded over"),
            Self::TooFine { most } => write!(f, "subdivided, it would have more than {most} triangles"),
            Self::TooLarge => write!(f, "a mesh has at most 2^32 - 1 triangles and vertices"),
        }
    }
}

impl std::error::Error for ShapeError {}
