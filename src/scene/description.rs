//! What a scene file says, as plain data: defaults filled in, references resolved, every value with
//! the place in the file that it came from. No behaviour, no file access, nothing to trace yet.

use super::source::{Place, Sources};
use crate::camera::{FisheyeProjection, Shutter, Stop};
use crate::film::FilterKind;
use crate::geometry::{Transform, Vec3};
use crate::integrator::Techniques;
use crate::raster::{Grid, Image};
use crate::sampling::SamplerKind;
use crate::shape::solid::Operation;
use crate::shape::{
    ControlNet, ControlPoint, CurveKind, FigureKind, HeightData, MeshData, QuadricKind, SdfData, Terrain,
};
use crate::spectrum::DispersionFormula;
use crate::texture::{Filter, Pattern, Wrap};
use std::path::PathBuf;
use std::sync::Arc;

#[derive(Clone, Debug)]
pub struct Description {
    pub sources: Sources,
    pub integrator: Integrator,
    pub sensor: Sensor,
    pub shapes: Vec<Shape>,
    pub solids: Vec<Solid>,
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

/// A remark tied to a place.
#[derive(Clone, Debug)]
pub struct Note {
    pub place: Place,
    pub text: String,
}

// ---------------------------------------------------------------------------------- spectra

/// A spectrum as the file gives it.
#[derive(Clone, Debug)]
pub struct SpectrumSource {
    pub place: Place,
    pub kind: SpectrumKind,
    /// Factor on all values.
    pub scale: f64,
}

#[derive(Clone, Debug)]
pub enum SpectrumKind {
    Constant(f64),
    /// Linear between the nodes (strictly ascending, nm), zero outside, as in Mitsuba 3:
    /// a `wavelength:value` list, `irregular`, or a `.spd` file.
    Irregular {
        nm: Vec<f64>,
        values: Vec<f64>,
        file: Option<PathBuf>,
    },
    /// Equally spaced values, linear between them, zero outside.
    Regular {
        min_nm: f64,
        max_nm: f64,
        values: Vec<f64>,
    },
    /// Mitsuba's `d65`: the CIE table over 98.9974.
    D65,
    /// Planck's law, W·m⁻²·sr⁻¹·nm⁻¹, zero outside the range.
    Blackbody {
        kelvin: f64,
        min_nm: f64,
        max_nm: f64,
    },
    /// One of the measured spectra compiled into the program (an extension).
    Named(String),
    /// A smooth spectrum that has a colour: linear values for the primaries of sRGB.
    Rgb {
        rgb: [f64; 3],
        role: RgbRole,
    },
    /// An image on the surface.
    Bitmap(Arc<BitmapSource>),
    /// Two textures in turn.
    Checkerboard(Arc<CheckerboardSource>),
    /// What the vertices or faces of a mesh carry under a name that begins with `vertex_` or `face_`.
    MeshAttribute {
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
    /// Values above 1 count as 1: what Mitsuba 3 makes of colours where it expects no reflectance.
    Clipped,
    /// A reflectance times D65, scaled to the brightness of the colour.
    Illuminant,
}

#[derive(Clone, Debug)]
pub struct BitmapSource {
    pub file: PathBuf,
    pub image: Arc<Image>,
    pub filter: Filter,
    pub wrap: Wrap,
    /// Whether values are taken as they stand in the file, not decoded and not made into spectra.
    pub raw: bool,
    /// Whether what is looked up is kept in half precision (`format` "fp16").
    pub half: bool,
    pub to_uv: Transform,
}

#[derive(Clone, Debug)]
pub struct CheckerboardSource {
    /// At the origin, and beside it.
    pub colours: [SpectrumSource; 2],
    pub to_uv: Transform,
}

/// `gridvolume`; a `constvolume` is the spectrum that it holds.
#[derive(Clone, Debug)]
pub struct VolumeSource {
    pub file: PathBuf,
    pub grid: Arc<Grid>,
    pub to_world: Transform,
    pub filter: Filter,
    pub wrap: Wrap,
    pub raw: bool,
    /// Whether the grid fills the box that its file states, and not the unit cube.
    pub use_grid_bbox: bool,
}

/// A pattern that selects between other textures or mixes them.
#[derive(Clone, Debug)]
pub struct ProceduralSource {
    pub pattern: Pattern,
    pub space: PatternSpace,
    /// The size of a cell of noise, and the distance between veins, rings, bands: in the file's units, or those of uv.
    pub period: f64,
    /// For values of the pattern from the least to the greatest.
    pub colours: Vec<SpectrumSource>,
    /// The values of the pattern that are the first and the last colour.
    pub range: [f64; 2],
    /// Whether colours are mixed, and not each the only one over its share of the values.
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
}

/// A refractive index, real.
#[derive(Clone, Debug)]
pub struct IndexSource {
    pub place: Place,
    pub kind: IndexKind,
}

#[derive(Clone, Debug)]
pub enum IndexKind {
    Constant(f64),
    /// A catalogue glass or other material with its dispersion (an extension).
    Named(String),
    /// Sellmeier or Cauchy coefficients (an extension).
    Formula(DispersionFormula),
    /// Tabulated n(λ), held constant beyond its ends (an extension).
    Tabulated(SpectrumSource),
    /// From the reflectance of one polished face at normal incidence, k = 0 (an extension;
    /// Glassner, *An Introduction to Ray Tracing*, ch. 4, eq. 18).
    NormalReflectance(SpectrumSource),
}

// -------------------------------------------------------------------------------- materials

#[derive(Clone, Debug)]
pub struct Bsdf {
    pub place: Place,
    /// The name under which the file defines it, if any.
    pub id: Option<String>,
    pub kind: BsdfKind,
}

#[derive(Clone, Debug)]
pub enum BsdfKind {
    Diffuse {
        reflectance: SpectrumSource,
    },
    /// Lambertian on both sides (an extension).
    DiffuseTransmitter {
        reflectance: SpectrumSource,
        transmittance: SpectrumSource,
    },
    /// `conductor` without and `roughconductor` with a roughness.
    Conductor {
        index: ConductorIndex,
        specular_reflectance: SpectrumSource,
        roughness: Option<Roughness>,
    },
    /// `dielectric` without and `roughdielectric` with a roughness.
    Dielectric {
        interior: IndexSource,
        /// `None` where the file leaves it out: then it is what surrounds the surface, air outside everything.
        exterior: Option<IndexSource>,
        specular_reflectance: SpectrumSource,
        specular_transmittance: SpectrumSource,
        roughness: Option<Roughness>,
    },
    /// `thindielectric`: a sheet of glass, in air where the file doesn't say otherwise.
    ThinDielectric {
        interior: IndexSource,
        exterior: Option<IndexSource>,
        specular_reflectance: SpectrumSource,
        specular_transmittance: SpectrumSource,
    },
    /// `plastic` without and `roughplastic` with a roughness: a coat on a matt base, in air where the file doesn't
    /// say otherwise.
    Plastic {
        interior: IndexSource,
        exterior: Option<IndexSource>,
        diffuse_reflectance: SpectrumSource,
        specular_reflectance: SpectrumSource,
        /// Whether light that is reflected inside is coloured each time.
        nonlinear: bool,
        coat: Option<CoatRoughness>,
    },
    Principled {
        base: PrincipledBase,
        metallic: SpectrumSource,
        clearcoat: SpectrumSource,
        clearcoat_gloss: SpectrumSource,
        /// The index below over that above.
        eta: f64,
    },
    PrincipledThin {
        base: PrincipledBase,
        /// 0–2.
        diff_trans: SpectrumSource,
        eta: SpectrumSource,
    },
    /// Lets everything pass, as if there were no surface.
    Null,
    /// A surface with holes: light passes through the share 1 − `opacity`.
    Mask {
        opacity: SpectrumSource,
        nested: Arc<Bsdf>,
    },
    /// The second BSDF by a share of `weight`, the first by the rest.
    Blend {
        weight: SpectrumSource,
        nested: [Arc<Bsdf>; 2],
    },
    /// `bumpmap`: shaded as if raised by a height.
    BumpMap {
        height: SpectrumSource,
        scale: f64,
        shading: ReliefShading,
        nested: Arc<Bsdf>,
    },
    /// `normalmap`: shaded with the normals of an image.
    NormalMap {
        normals: SpectrumSource,
        shading: ReliefShading,
        nested: Arc<Bsdf>,
    },
    /// The front BSDF on both sides, or another on the back.
    TwoSided {
        front: Arc<Bsdf>,
        back: Option<Arc<Bsdf>>,
        /// Whether light may get through: the far side then looks like the near one from behind.
        allow_transmission: bool,
    },
}

impl BsdfKind {
    /// Whether light may get to the other side.
    pub fn transmits(&self) -> bool {
        match self {
            Self::DiffuseTransmitter { .. }
            | Self::Dielectric { .. }
            | Self::ThinDielectric { .. }
            | Self::PrincipledThin { .. }
            | Self::Null
            | Self::Mask { .. } => true,
            Self::Principled { base, .. } => base.spec_trans.constant() != Some(0.0),
            Self::Diffuse { .. } | Self::Conductor { .. } | Self::Plastic { .. } => false,
            Self::Blend { nested, .. } => nested.iter().any(|nested| nested.kind.transmits()),
            Self::BumpMap { nested, .. } | Self::NormalMap { nested, .. } => nested.kind.transmits(),
            Self::TwoSided { front, back, .. } => {
                front.kind.transmits() || back.as_ref().is_some_and(|back| back.kind.transmits())
            }
        }
    }
}

/// How bump and normal maps deal with normals that are no surface's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReliefShading {
    pub flip_invalid_normals: bool,
    pub use_shadowing_function: bool,
}

#[derive(Clone, Debug)]
pub enum ConductorIndex {
    /// Mitsuba's `material="none"`: reflects everything.
    Mirror,
    Complex {
        n: SpectrumSource,
        k: SpectrumSource,
    },
    /// A metal of the catalogue, n and k together.
    Named {
        place: Place,
        name: String,
    },
    /// From the reflectance at normal incidence (an extension).
    NormalReflectance {
        reflectance: SpectrumSource,
        assumption: MetalAssumption,
    },
}

/// A reflectance leaves one unknown of two; this says how it is filled.
#[derive(Clone, Debug)]
pub enum MetalAssumption {
    /// k = 0, the book's.
    NoAbsorption,
    /// n = 1, so that k = 2·√(R/(1−R)).
    UnitIndex,
    /// n is known, k follows.
    KnownIndex(SpectrumSource),
}

#[derive(Clone, Debug)]
pub struct Roughness {
    pub distribution: Distribution,
    pub alpha: Alpha,
}

#[derive(Clone, Debug)]
pub enum Alpha {
    Isotropic(SpectrumSource),
    /// Along the tangent and the bitangent.
    Anisotropic([SpectrumSource; 2]),
}

/// The roughness of a coat, the same everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoatRoughness {
    pub distribution: Distribution,
    pub alpha: f64,
}

/// What `principled` and `principledthin` have in common, by Mitsuba's names.
#[derive(Clone, Debug)]
pub struct PrincipledBase {
    pub base_color: SpectrumSource,
    pub roughness: SpectrumSource,
    pub anisotropic: SpectrumSource,
    pub spec_trans: SpectrumSource,
    pub spec_tint: SpectrumSource,
    pub sheen: SpectrumSource,
    pub sheen_tint: SpectrumSource,
    pub flatness: SpectrumSource,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distribution {
    Beckmann,
    Ggx,
}

/// `homogeneous` without scattering: what it absorbs per unit of length.
#[derive(Clone, Debug)]
pub struct Medium {
    pub place: Place,
    pub id: Option<String>,
    pub absorption: SpectrumSource,
}

// ----------------------------------------------------------------------------------- shapes

#[derive(Clone, Debug)]
pub struct Shape {
    pub place: Place,
    pub id: Option<String>,
    pub kind: ShapeKind,
    /// Of a moving shape that at its first keyframe; likewise for all that moves.
    pub to_world: Transform,
    pub motion: Option<Arc<Animation>>,
    pub flip_normals: bool,
    pub bsdf: Arc<Bsdf>,
    /// Radiance of an area light on this surface.
    pub emission: Option<SpectrumSource>,
    pub interior: Option<Medium>,
    pub exterior: Option<Medium>,
    /// Which of several transparent bodies counts where they overlap: that of the highest (an extension). 0 where it is left out.
    pub priority: Option<Priority>,
}

#[derive(Clone, Debug)]
pub struct Priority {
    pub place: Place,
    pub value: i32,
}

#[derive(Clone, Debug)]
pub enum ShapeKind {
    Sphere {
        centre: Vec3,
        radius: f64,
    },
    Rectangle,
    Disk,
    Cube,
    Cylinder {
        from: Vec3,
        to: Vec3,
        radius: f64,
    },
    /// `cone`, `paraboloid`, `hyperboloid` and `quadric` (extensions).
    Quadric {
        kind: QuadricKind,
        /// Whether it is closed where it is cut off.
        capped: bool,
    },
    /// Around z (an extension).
    Torus {
        major_radius: f64,
        minor_radius: f64,
    },
    /// `polygon`, `extrusion`, `revolution`, `superquadric` and `blobs` (extensions).
    Figure(FigureKind),
    /// `sdfgrid`.
    Distances {
        file: PathBuf,
        data: Arc<SdfData>,
        /// Whether shading normals are smooth.
        smooth: bool,
    },
    /// `heightfield` (an extension).
    Heights {
        source: HeightSource,
        data: Arc<HeightData>,
        scale: f64,
        /// The height of the bottom of a body.
        base: Option<f64>,
        /// Whether shading normals are smooth.
        smooth: bool,
    },
    /// `linearcurve`, `bsplinecurve` and, `solid`, `sweptsphere` (an extension): in the file's own coordinates.
    Curves {
        file: PathBuf,
        kind: CurveKind,
        solid: bool,
        curves: Arc<Vec<Vec<ControlPoint>>>,
    },
    /// `bezierpatch` (an extension).
    Patches {
        /// Where they are from, unless they are written in the scene.
        file: Option<PathBuf>,
        patches: Arc<Vec<ControlNet>>,
    },
    /// `obj`, `ply` and `serialized`: in the file's own coordinates.
    Mesh {
        file: PathBuf,
        /// `obj`, `ply` or `serialized`.
        plugin: &'static str,
        /// Which mesh of a `serialized` file it is.
        shape_index: u32,
        /// Whether v was read as 1 − v.
        flip_tex_coords: bool,
        /// Deformed, if it is.
        mesh: Arc<MeshData>,
        /// What was done to it before, in the words of the scene file (an extension).
        deform: Option<String>,
        /// Whether vertex normals are to be computed once the mesh is placed: the file has none, and
        /// `face_normals` does not ask for flat triangles.
        compute_normals: bool,
    },
}

/// Where the heights of a `heightfield` are from.
#[derive(Clone, Debug)]
pub enum HeightSource {
    /// A channel of an image.
    Image {
        file: PathBuf,
        channel: usize,
    },
    /// Written in the scene.
    List,
    Terrain(Terrain),
}

/// A body joined or cut from closed shapes (an extension). What it says of its surface and media its leaves say too.
#[derive(Clone, Debug)]
pub struct Solid {
    pub place: Place,
    pub id: Option<String>,
    pub operation: Operation,
    /// In the order of the file: of a difference the first is what the others are cut from.
    pub parts: Vec<Part>,
    pub to_world: Transform,
    pub motion: Option<Arc<Animation>>,
}

/// What a solid is made of.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "nearly all are shapes")]
pub enum Part {
    Shape(Shape),
    Solid(Solid),
}

impl Solid {
    /// The shapes that it is made of, in the order of the file.
    pub fn leaves(&self) -> Vec<&Shape> {
        let of_parts = self.parts.iter().map(|part| match part {
            Part::Shape(shape) => vec![shape],
            Part::Solid(solid) => solid.leaves(),
        });
        of_parts.flatten().collect()
    }
}

/// Shapes that stand nowhere by themselves, in coordinates of their own.
#[derive(Clone, Debug)]
pub struct ShapeGroup {
    pub place: Place,
    pub id: Option<String>,
    pub shapes: Vec<Shape>,
    pub solids: Vec<Solid>,
}

/// A group of shapes where a transform puts it.
#[derive(Clone, Debug)]
pub struct Instance {
    pub place: Place,
    pub id: Option<String>,
    pub group: Arc<ShapeGroup>,
    pub to_world: Transform,
    pub motion: Option<Arc<Animation>>,
}

/// What `to_world` is at some times (an extension). See [`crate::geometry::Motion`].
#[derive(Clone, Debug)]
pub struct Animation {
    pub place: Place,
    pub keys: Vec<(f64, Transform)>,
}

// ----------------------------------------------------------------------------------- lights

#[derive(Clone, Debug)]
pub struct Light {
    pub place: Place,
    pub kind: LightKind,
    /// Never of light from all around.
    pub motion: Option<Arc<Animation>>,
}

#[derive(Clone, Debug)]
pub enum LightKind {
    /// Radiant intensity, W·sr⁻¹·nm⁻¹.
    Point { position: Vec3, intensity: SpectrumSource },
    /// A point that shines along its local +z. The angles, in degrees, are those between the axis and where the light ends,
    /// and where it begins to fall off.
    Spot {
        to_world: Transform,
        /// On the axis.
        intensity: SpectrumSource,
        cutoff_angle: f64,
        beam_width: f64,
        /// Between the light and what it lights.
        texture: Option<SpectrumSource>,
    },
    /// A picture thrown along the local +z.
    Projector { to_world: Transform, irradiance: SpectrumSource, scale: f64, field_of_view: FieldOfView },
    /// Irradiance on a surface across the light's direction of travel, W·m⁻²·nm⁻¹.
    /// `travels` has any length.
    Directional { travels: Vec3, irradiance: SpectrumSource },
    /// The same radiance from everywhere.
    Constant { radiance: SpectrumSource },
    /// A picture all around, in values for the primaries of sRGB under D65, with +y of the local frame at its top.
    EnvironmentMap { to_world: Transform, file: PathBuf, image: Arc<Image>, scale: f64 },
    /// Clear sky and sun, the zenith at the local +z.
    SunSky {
        to_world: Transform,
        turbidity: f64,
        /// Reflectance of the ground.
        albedo: SpectrumSource,
        /// In the world, of any length.
        sun_direction: Vec3,
        sky_scale: f64,
        sun_scale: f64,
        /// Angle across the sun, degrees.
        sun_aperture: f64,
        complex_sun: bool,
    },
}

impl LightKind {
    /// Whether the light comes from all around.
    pub fn is_environment(&self) -> bool {
        match self {
            Self::Constant { .. } | Self::EnvironmentMap { .. } | Self::SunSky { .. } => true,
            Self::Point { .. } | Self::Spot { .. } | Self::Projector { .. } | Self::Directional { .. } => {
                false
            }
        }
    }
}

// ----------------------------------------------------------------------------------- camera

#[derive(Clone, Debug)]
pub struct Sensor {
    pub place: Place,
    pub kind: SensorKind,
    /// `srf`: factor on what is measured, by wavelength. `None` is 1 everywhere.
    pub response: Option<SpectrumSource>,
    /// What the sensor is in.
    pub medium: Option<Medium>,
    pub film: Film,
    pub sampler: Sampler,
    /// Of a camera.
    pub motion: Option<Arc<Animation>>,
    /// Of a batch that of all its sensors.
    pub shutter: Shutter,
}

#[derive(Clone, Debug)]
pub enum SensorKind {
    /// `perspective` and `thinlens`.
    Perspective {
        /// The camera looks along its local +z, its local +x is the image's left, +y is up (Mitsuba 3).
        to_world: Transform,
        field_of_view: FieldOfView,
        /// Offset of the principal point as fractions of the film's width and height.
        principal_point: [f64; 2],
        near_clip: f64,
        far_clip: f64,
        /// `thinlens`; `None` is a pinhole.
        lens: Option<Lens>,
    },
    /// Sees local x from −1 to 1 across the whole film, along +z.
    Orthographic {
        to_world: Transform,
        near_clip: f64,
        far_clip: f64,
    },
    /// `fisheye` and `panorama` (extensions). The frame is that of a perspective camera.
    Angular {
        to_world: Transform,
        map: AngularMap,
        /// Distances from the camera.
        near_clip: f64,
        far_clip: f64,
    },
    /// `sensorplane`, a film in the scene itself (an extension): it lies across its local z, in the middle of which the origin is.
    Plane {
        to_world: Transform,
        width: f64,
        stop: Stop,
    },
    RadianceMeter {
        origin: Vec3,
        direction: Vec3,
    },
    /// Measures on a surface, which may be part of the scene.
    IrradianceMeter {
        surface: Arc<Shape>,
    },
    /// Looks along `direction` from infinity.
    Distant {
        direction: Vec3,
        target: DistantTarget,
    },
    /// Sensors side by side, from left to right. Their own films and samplers don't matter.
    Batch(Vec<Sensor>),
}

/// See [`crate::camera::DirectionMap`]; fields of view in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AngularMap {
    Fisheye {
        projection: FisheyeProjection,
        fov: f64,
    },
    /// Across and up.
    Panorama {
        fov: [f64; 2],
    },
}

/// What a distant sensor looks at.
#[derive(Clone, Debug)]
pub enum DistantTarget {
    /// The cross-section of a sphere around the scene's bounding box.
    Scene,
    Point(Vec3),
    /// A surface that need not be part of the scene.
    Surface(Arc<Shape>),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FieldOfView {
    Degrees {
        angle: f64,
        axis: FovAxis,
    },
    /// Focal length in mm of a lens over a 35 mm film (36 × 24), measured on the diagonal.
    FocalLength(f64),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FovAxis {
    X,
    Y,
    Diagonal,
    Smaller,
    Larger,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    pub aperture: Aperture,
    /// Straight blades that bound the aperture, 3 or more; 0 for a round one (an extension).
    pub blades: u32,
    /// By how many degrees the blades are turned, counter-clockwise for who stands behind the camera.
    pub rotation: f64,
    pub focus_distance: f64,
}

/// How wide a lens is open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aperture {
    /// Scene units.
    Radius(f64),
    /// Focal length over diameter, the focal length being that of the field of view on 36 mm × 24 mm and
    /// a scene unit a metre (an extension).
    Stop(f64),
}

#[derive(Clone, Debug)]
pub struct Film {
    pub place: Place,
    pub width: u32,
    pub height: u32,
    pub crop: Option<Crop>,
    pub filter: FilterKind,
    /// Whether pixels at the border see what lies outside the film.
    pub sample_border: bool,
    pub content: FilmContent,
}

/// What the pixels of a film hold.
#[derive(Clone, Debug)]
pub enum FilmContent {
    /// `hdrfilm`.
    Colour { format: PixelFormat, alpha: bool },
    /// `specfilm`: for each channel its name and the sensor's response, over which radiance is integrated.
    Responses(Vec<FilmChannel>),
}

#[derive(Clone, Debug)]
pub struct FilmChannel {
    pub name: String,
    pub response: SpectrumSource,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    pub x: u32,
    pub y: u32,
    pub width: u32,
    pub height: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelFormat {
    Rgb,
    Xyz,
    Luminance,
}

#[derive(Clone, Debug)]
pub struct Sampler {
    pub place: Place,
    pub kind: SamplerKind,
    pub sample_count: u32,
    pub seed: u64,
}

// ------------------------------------------------------------------------------- integrator

#[derive(Clone, Debug)]
pub struct Integrator {
    pub place: Place,
    pub kind: IntegratorKind,
    /// Most segments of a path, camera ray included; `None` is unlimited. 1 shows emission only.
    pub max_depth: Option<u32>,
    /// Number of segments from which Russian roulette may end a path.
    pub rr_depth: u32,
    pub hide_emitters: bool,
    /// `direct` may leave one out.
    pub techniques: Techniques,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IntegratorKind {
    /// To pass through a surface that is not there (a mask, `null`) is a segment of its own, and light samples are stopped
    /// there.
    Path,
    /// A path of at most two segments.
    Direct,
    /// `volpath`, `volpathmis`: paths and light samples go through such a surface as if there were none.
    VolPath,
    /// Scattering alone finds the lights: the slow oracle (an extension, `walk`).
    Walk,
}
