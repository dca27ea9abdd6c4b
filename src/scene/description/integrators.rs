//! Integrators as a scene file says them, and the images that they write beside the picture.

use crate::scene::Techniques;
use crate::scene::source::Place;

/// What is computed, and by which method.
#[derive(Clone, Debug)]
pub struct Integrator {
    /// Where the file declares it.
    pub place: Place,
    /// Which integrator it is, with the parameters of its own.
    pub kind: IntegratorKind,
    /// Most segments of a path, camera ray included; `None` is unlimited. 1 shows emission only.
    pub max_depth: Option<u32>,
    /// Number of segments from which Russian roulette may end a path.
    pub rr_depth: u32,
    /// Whether lights and the environment are invisible to the camera; they still illuminate.
    pub hide_emitters: bool,
    /// `direct` may leave one out.
    pub techniques: Techniques,
    /// `aov`: images of what the camera sees first, beside the picture.
    pub aovs: Vec<Aov>,
    /// `moment`: the second moments of the picture's samples are written, too.
    pub moments: Option<Moments>,
}

/// How light is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IntegratorKind {
    /// To pass through a surface that is not there (a mask, `null`) is a segment of its own, and light
    /// samples are stopped there.
    Path,
    /// A path of at most two segments.
    Direct,
    /// `volpath`, `volpathmis`: paths and light samples go through such a surface as if there were none.
    VolPath,
    /// Scattering alone finds the lights: the slow oracle (an extension, `walk`).
    Walk,
    /// The distance of what is seen first, as if it were a radiance that is the same at all wavelengths.
    Depth,
}

/// Where Mitsuba 3's `moment` stands and what it holds, which makes the names of its channels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Moments {
    /// Its own name in the `aov` that it stands in.
    pub within: Option<String>,
    /// The name of the integrator in it.
    pub of: String,
}

impl Moments {
    /// What the names of the channels begin with: those of the means, and those of the second moments.
    pub fn stems(&self) -> [String; 2] {
        let within = self.within.as_ref().map_or(String::new(), |name| format!("{name}."));
        [format!("{within}{}", self.of), format!("{within}m2_{}", self.of)]
    }
}

/// An image of what the camera sees first, under a name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Aov {
    /// What the names of its channels begin with.
    pub name: String,
    /// What the image shows.
    pub kind: AovKind,
}

/// What such an image shows. Where the camera sees nothing it is 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AovKind {
    /// The colour, linear Rec. 709, of the fraction of the light from all around that the surface sends on,
    /// reflected or transmitted: 1, 1, 1 where that is all of it.
    Albedo,
    /// Distance along the ray from where it begins: from the near plane of a perspective camera. Scene units.
    Depth,
    /// The place in the coordinates of the file.
    Position,
    /// Texture coordinates (u, v).
    Uv,
    /// Unit normal of the surface itself, on the side that its orientation says.
    GeometricNormal,
    /// Unit normal that the material is seen with: interpolated, and turned by bump and normal maps.
    ShadingNormal,
    /// ∂p/∂u.
    AlongU,
    /// ∂p/∂v.
    AlongV,
    /// The triangle of the mesh, the segment of the curve, the part of the shape, from 0.
    PrimitiveIndex,
    /// Which of the shapes, solids and instances of the scene it is, from 1, in the order of `abbe info`.
    ShapeIndex,
    /// A number above 0 that is another one for each material (an extension).
    MaterialIndex,
    /// What a path from the pixel takes, whatever it shares with others: nodes that its rays visit, packets
    /// of four triangles and other surfaces that they are tested against (an extension).
    Cost,
}

impl AovKind {
    /// All of them, by the names that Mitsuba 3's `aov` has for them.
    pub const NAMES: [(&'static str, Self); 12] = [
        ("albedo", Self::Albedo),
        ("depth", Self::Depth),
        ("position", Self::Position),
        ("uv", Self::Uv),
        ("geo_normal", Self::GeometricNormal),
        ("sh_normal", Self::ShadingNormal),
        ("dp_du", Self::AlongU),
        ("dp_dv", Self::AlongV),
        ("prim_index", Self::PrimitiveIndex),
        ("shape_index", Self::ShapeIndex),
        ("material_index", Self::MaterialIndex),
        ("cost", Self::Cost),
    ];

    /// The kind of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::NAMES.iter().find(|(known, _)| *known == name).map(|&(_, kind)| kind)
    }

    /// The name that files and the command line have for it.
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, kind)| *kind == self).map_or("", |&(name, _)| name)
    }

    /// What the names of its channels end in, as Mitsuba 3 writes them.
    pub fn channels(self) -> &'static [&'static str] {
        match self {
            Self::Albedo => &["R", "G", "B"],
            Self::Depth => &["T"],
            Self::Uv => &["U", "V"],
            Self::Position | Self::GeometricNormal | Self::ShadingNormal | Self::AlongU | Self::AlongV => {
                &["X", "Y", "Z"]
            }
            Self::PrimitiveIndex | Self::ShapeIndex | Self::MaterialIndex => &["I"],
            Self::Cost => &["T"],
        }
    }

    /// Whether it is a number of which there is no mean.
    pub fn is_index(self) -> bool {
        matches!(self, Self::PrimitiveIndex | Self::ShapeIndex | Self::MaterialIndex)
    }
}

impl Aov {
    /// The names of its channels.
    pub fn channels(&self) -> impl Iterator<Item = String> + '_ {
        self.kind.channels().iter().map(|ending| format!("{}.{ending}", self.name))
    }
}
