//! A description told as an indented text, and its hash.

use super::description::{
    Bsdf, BsdfKind, ConductorIndex, Crop, Description, Distribution, FieldOfView, FovAxis, IndexKind,
    IndexSource, Integrator, IntegratorKind, Light, LightKind, MetalAssumption, Note, PixelFormat, Roughness,
    Sensor, Shape, ShapeKind, SpectrumKind, SpectrumSource,
};
use super::source::Place;
use crate::film::FilterKind;
use crate::geometry::{Transform, Vec3};
use crate::sampling::SamplerKind;
use crate::shape::MeshData;
use std::path::Path;

/// The scene as it was understood: one line for each object and property, defaults filled in, extensions and
/// assumptions at the end.
pub fn outline(description: &Description) -> String {
    let mut outline = Outline { description, text: String::new(), depth: 0, detail: Detail::Readable };
    outline.scene();
    outline.notes("extensions (Mitsuba 3 would refuse them)", &description.extensions);
    outline.notes("assumptions", &description.assumptions);
    outline.notes("remarks", &description.remarks);
    outline.text
}

impl Description {
    /// A hash of what the scene means, the content of its tables and meshes included. It does not depend on how the
    /// file is laid out, on comments, names or paths.
    pub fn hash(&self) -> u64 {
        let mut outline =
            Outline { description: self, text: String::new(), depth: 0, detail: Detail::Complete };
        outline.scene();
        fnv1a(outline.text.bytes().map(u64::from))
    }
}

/// Fowler, Noll and Vo's hash 1a of 64 bits, over words instead of bytes.
/// Source: G. Fowler, L. C. Noll, K.-P. Vo, D. Eastlake, "The FNV Non-Cryptographic Hash Algorithm".
fn fnv1a(words: impl Iterator<Item = u64>) -> u64 {
    words.fold(0xcbf2_9ce4_8422_2325, |hash, word| (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3))
}

fn hash_of_mesh(mesh: &MeshData) -> u64 {
    let floats =
        |values: &[[f32; 3]]| -> u64 { fnv1a(values.iter().flatten().map(|x| u64::from(x.to_bits()))) };
    let parts = [
        floats(&mesh.positions),
        fnv1a(mesh.indices.iter().flatten().map(|&index| u64::from(index))),
        mesh.normals.as_ref().map_or(0, |normals| floats(normals)),
        mesh.uvs.as_ref().map_or(0, |uvs| fnv1a(uvs.iter().flatten().map(|x| u64::from(x.to_bits())))),
        u64::from(mesh.flip_normals),
    ];
    fnv1a(parts.into_iter())
}

#[derive(Clone, Copy, PartialEq)]
enum Detail {
    /// Long tables are summed up, places are named.
    Readable,
    /// Every number, but nothing that does not change the picture.
    Complete,
}

struct Outline<'a> {
    description: &'a Description,
    text: String,
    depth: usize,
    detail: Detail,
}

impl Outline<'_> {
    fn line(&mut self, text: &str) {
        self.text.push_str(&"  ".repeat(self.depth));
        self.text.push_str(text);
        self.text.push('\n');
    }

    fn within(&mut self, content: impl FnOnce(&mut Self)) {
        self.depth += 1;
        content(self);
        self.depth -= 1;
    }

    /// An object with its name and the line where it stands.
    fn object(&mut self, what: &str, id: Option<&String>, place: &Place) {
        let text = match self.detail {
            Detail::Complete => what.to_owned(),
            Detail::Readable => {
                let id = id.map_or(String::new(), |id| format!(" \"{id}\""));
                format!("{what}{id} (line {})", self.description.sources.line(place))
            }
        };
        self.line(&text);
    }

    fn scene(&mut self) {
        self.line("scene");
        self.within(|o| {
            o.integrator(&o.description.integrator);
            o.sensor(&o.description.sensor);
            for light in &o.description.lights {
                o.light(light);
            }
            for shape in &o.description.shapes {
                o.shape(shape);
            }
        });
    }

    fn notes(&mut self, title: &str, notes: &[Note]) {
        if notes.is_empty() {
            return;
        }
        self.line(title);
        self.within(|o| {
            for note in notes {
                let line = o.description.sources.line(&note.place);
                o.line(&format!("line {line}: {}", note.text));
            }
        });
    }

    fn integrator(&mut self, integrator: &Integrator) {
        let kind = match integrator.kind {
            IntegratorKind::Path => "path tracing",
            IntegratorKind::VolPath => "path tracing through volumes",
            IntegratorKind::Walk => "random walk",
        };
        self.object(&format!("integrator: {kind}"), None, &integrator.place);
        self.within(|o| {
            let depth = integrator.max_depth.map_or("unlimited".to_owned(), |depth| depth.to_string());
            o.line(&format!("max_depth {depth}, rr_depth {}", integrator.rr_depth));
            if integrator.hide_emitters {
                o.line("lights are hidden from the camera");
            }
        });
    }

    fn sensor(&mut self, sensor: &Sensor) {
        let kind = if sensor.lens.is_some() { "thin lens" } else { "pinhole" };
        self.object(&format!("sensor: {kind}"), None, &sensor.place);
        self.within(|o| {
            o.line(&match sensor.field_of_view {
                FieldOfView::Degrees { angle, axis } => {
                    format!("field of view {angle}° along {}", axis_name(axis))
                }
                FieldOfView::FocalLength(mm) => format!("focal length {mm} mm over a film of 36 × 24 mm"),
            });
            if let Some(lens) = sensor.lens {
                o.line(&format!(
                    "aperture radius {}, focus distance {}",
                    lens.aperture_radius, lens.focus_distance
                ));
            }
            if sensor.principal_point != [0.0; 2] {
                let [x, y] = sensor.principal_point;
                o.line(&format!("principal point moved by {x}, {y} of the film"));
            }
            o.line(&format!("sees depths from {} to {}", sensor.near_clip, sensor.far_clip));
            o.transform(&sensor.to_world);
            if let Some(medium) = &sensor.medium {
                o.spectrum("absorption around it", &medium.absorption);
            }
            let film = &sensor.film;
            let format = match film.pixel_format {
                PixelFormat::Rgb => "linear Rec. 709",
                PixelFormat::Xyz => "CIE XYZ",
                PixelFormat::Luminance => "luminance",
            };
            o.object(&format!("film: {} × {} pixels, {format}", film.width, film.height), None, &film.place);
            o.within(|o| {
                o.line(&format!("filter {}", filter_name(film.filter)));
                if let Some(Crop { x, y, width, height }) = film.crop {
                    o.line(&format!("crop window of {width} × {height} pixels at {x}, {y}"));
                }
            });
            let sampler = &sensor.sampler;
            let kind = match sampler.kind {
                SamplerKind::Sobol => "Owen-scrambled Sobol",
                SamplerKind::Independent => "independent",
            };
            o.object(&format!("sampler: {kind}"), None, &sampler.place);
            o.within(|o| o.line(&format!("{} samples a pixel, seed {}", sampler.sample_count, sampler.seed)));
        });
    }

    fn light(&mut self, light: &Light) {
        match &light.kind {
            LightKind::Point { position, intensity } => {
                self.object("emitter: point", None, &light.place);
                self.within(|o| {
                    o.line(&format!("at {}", vector(*position)));
                    o.spectrum("intensity", intensity);
                });
            }
            LightKind::Spot { to_world, intensity, cutoff_angle, beam_width, texture } => {
                self.object("emitter: spot", None, &light.place);
                self.within(|o| {
                    o.transform(to_world);
                    o.line(&format!("falls off from {beam_width}° to {cutoff_angle}° off its axis"));
                    o.spectrum("intensity", intensity);
                    if let Some(texture) = texture {
                        o.spectrum("texture", texture);
                    }
                });
            }
            LightKind::Projector { to_world, irradiance, scale, field_of_view: _ } => {
                self.object("emitter: projector", None, &light.place);
                self.within(|o| {
                    o.transform(to_world);
                    o.spectrum("irradiance", irradiance);
                    o.line(&format!("scale {scale}"));
                });
            }
            LightKind::Directional { travels, irradiance } => {
                self.object("emitter: directional", None, &light.place);
                self.within(|o| {
                    o.line(&format!("travels along {}", vector(*travels)));
                    o.spectrum("irradiance", irradiance);
                });
            }
            LightKind::SunSky { to_world, turbidity, albedo, sun_direction, .. } => {
                self.object("emitter: sunsky", None, &light.place);
                self.within(|o| {
                    o.transform(to_world);
                    o.line(&format!("turbidity {turbidity}, sun at {}", vector(*sun_direction)));
                    o.spectrum("albedo", albedo);
                });
            }
            LightKind::Constant { radiance } => {
                self.object("emitter: constant", None, &light.place);
                self.within(|o| o.spectrum("radiance", radiance));
            }
        }
    }

    fn shape(&mut self, shape: &Shape) {
        let kind = match &shape.kind {
            ShapeKind::Sphere { .. } => "sphere",
            ShapeKind::Rectangle => "rectangle",
            ShapeKind::Disk => "disk",
            ShapeKind::Cube => "cube",
            ShapeKind::Cylinder { .. } => "cylinder",
            ShapeKind::Mesh { .. } => "mesh",
        };
        self.object(&format!("shape: {kind}"), shape.id.as_ref(), &shape.place);
        self.within(|o| {
            o.geometry(&shape.kind);
            o.transform(&shape.to_world);
            if shape.flip_normals {
                o.line("normals turned");
            }
            o.bsdf("bsdf", &shape.bsdf);
            if let Some(radiance) = &shape.emission {
                o.spectrum("emits radiance", radiance);
            }
            if let Some(medium) = &shape.interior {
                o.spectrum("interior absorption", &medium.absorption);
            }
            if let Some(medium) = &shape.exterior {
                o.spectrum("exterior absorption", &medium.absorption);
            }
        });
    }

    fn geometry(&mut self, kind: &ShapeKind) {
        match kind {
            ShapeKind::Sphere { centre, radius } => {
                self.line(&format!("centre {}, radius {radius}", vector(*centre)))
            }
            ShapeKind::Cylinder { from, to, radius } => {
                self.line(&format!("from {} to {}, radius {radius}", vector(*from), vector(*to)));
            }
            ShapeKind::Mesh { file, mesh, compute_normals } => {
                let normals = match (&mesh.normals, compute_normals) {
                    (Some(_), _) => "normals of the file",
                    (None, true) => "smooth normals",
                    (None, false) => "flat triangles",
                };
                let what = match self.detail {
                    Detail::Readable => format!(
                        "{}: {} triangles, {} vertices, ",
                        file_name(file),
                        mesh.indices.len(),
                        mesh.positions.len()
                    ),
                    Detail::Complete => format!("{:016x}, ", hash_of_mesh(mesh)),
                };
                self.line(&format!("{what}{normals}"));
            }
            ShapeKind::Rectangle | ShapeKind::Disk | ShapeKind::Cube => {}
        }
    }

    fn bsdf(&mut self, role: &str, bsdf: &Bsdf) {
        let id = bsdf.id.as_ref();
        match &bsdf.kind {
            BsdfKind::Diffuse { reflectance } => {
                self.object(&format!("{role}: diffuse"), id, &bsdf.place);
                self.within(|o| o.spectrum("reflectance", reflectance));
            }
            BsdfKind::DiffuseTransmitter { reflectance, transmittance } => {
                self.object(&format!("{role}: diffuse transmitter"), id, &bsdf.place);
                self.within(|o| {
                    o.spectrum("reflectance", reflectance);
                    o.spectrum("transmittance", transmittance);
                });
            }
            BsdfKind::Conductor { index, specular_reflectance, roughness } => {
                self.object(&format!("{role}: {}conductor", rough(roughness)), id, &bsdf.place);
                self.within(|o| {
                    o.conductor_index(index);
                    o.factor("specular_reflectance", specular_reflectance);
                    o.roughness(roughness);
                });
            }
            BsdfKind::Dielectric {
                interior,
                exterior,
                specular_reflectance,
                specular_transmittance,
                roughness,
            } => {
                self.object(&format!("{role}: {}dielectric", rough(roughness)), id, &bsdf.place);
                self.within(|o| {
                    o.index("inside", interior);
                    match exterior {
                        Some(exterior) => o.index("outside", exterior),
                        None => o.line("outside: whatever surrounds it (air outside everything)"),
                    }
                    o.factor("specular_reflectance", specular_reflectance);
                    o.factor("specular_transmittance", specular_transmittance);
                    o.roughness(roughness);
                });
            }
            BsdfKind::Null => self.object(&format!("{role}: null"), id, &bsdf.place),
            BsdfKind::Mask { opacity, nested } => {
                self.object(&format!("{role}: mask"), id, &bsdf.place);
                self.within(|o| {
                    o.spectrum("opacity", opacity);
                    o.bsdf("covered by", nested);
                });
            }
            BsdfKind::Blend { weight, nested: [first, second] } => {
                self.object(&format!("{role}: blend"), id, &bsdf.place);
                self.within(|o| {
                    o.spectrum("weight of the second", weight);
                    o.bsdf("first", first);
                    o.bsdf("second", second);
                });
            }
            BsdfKind::BumpMap { height, scale, shading, nested } => {
                self.object(&format!("{role}: bump map"), id, &bsdf.place);
                self.within(|o| {
                    o.spectrum(&format!("height × {scale}"), height);
                    o.line(&format!("{shading:?}"));
                    o.bsdf("on", nested);
                });
            }
            BsdfKind::NormalMap { normals, shading, nested } => {
                self.object(&format!("{role}: normal map"), id, &bsdf.place);
                self.within(|o| {
                    o.spectrum("normals", normals);
                    o.line(&format!("{shading:?}"));
                    o.bsdf("on", nested);
                });
            }
            BsdfKind::TwoSided { front, back } => {
                self.object(&format!("{role}: two-sided"), id, &bsdf.place);
                self.within(|o| match back {
                    None => o.bsdf("both sides", front),
                    Some(back) => {
                        o.bsdf("front", front);
                        o.bsdf("back", back);
                    }
                });
            }
        }
    }

    fn conductor_index(&mut self, index: &ConductorIndex) {
        match index {
            ConductorIndex::Mirror => self.line("perfect mirror"),
            ConductorIndex::Complex { n, k } => {
                self.spectrum("n", n);
                self.spectrum("k", k);
            }
            ConductorIndex::Named { name, .. } => self.line(&format!("n and k of {name}, measured")),
            ConductorIndex::NormalReflectance { reflectance, assumption } => {
                self.spectrum("index from the normal-incidence reflectance", reflectance);
                match assumption {
                    MetalAssumption::NoAbsorption => self.line("assuming k = 0"),
                    MetalAssumption::UnitIndex => self.line("assuming n = 1"),
                    MetalAssumption::KnownIndex(n) => self.spectrum("known n", n),
                }
            }
        }
    }

    fn index(&mut self, role: &str, index: &IndexSource) {
        match &index.kind {
            IndexKind::Constant(value) => self.line(&format!("{role}: index {value}")),
            IndexKind::Named(name) => self.line(&format!("{role}: {name}, measured")),
            IndexKind::Formula(formula) => {
                self.line(&format!(
                    "{role}: {:?} formula, coefficients {:?}",
                    formula.kind(),
                    formula.coefficients()
                ));
            }
            IndexKind::Tabulated(table) => self.spectrum(&format!("{role}: index"), table),
            IndexKind::NormalReflectance(reflectance) => {
                self.spectrum(&format!("{role}: index from the normal-incidence reflectance"), reflectance);
            }
        }
    }

    fn roughness(&mut self, roughness: &Option<Roughness>) {
        let Some(Roughness { distribution, alpha: [u, v] }) = roughness else { return };
        let distribution = match distribution {
            Distribution::Beckmann => "Beckmann",
            Distribution::Ggx => "GGX",
        };
        let alpha = if u == v { u.to_string() } else { format!("{u} along u, {v} along v") };
        self.line(&format!("{distribution} roughness {alpha}"));
    }

    /// A factor that is 1 in nature, told only where it is something else.
    fn factor(&mut self, name: &str, source: &SpectrumSource) {
        if !matches!(source.kind, SpectrumKind::Constant(1.0)) || source.scale != 1.0 {
            self.spectrum(name, source);
        }
    }

    fn spectrum(&mut self, name: &str, source: &SpectrumSource) {
        let scale = if source.scale == 1.0 { String::new() } else { format!("{} × ", source.scale) };
        let table = |min: f64, max: f64, nm: Option<&[f64]>, values: &[f64]| match self.detail {
            Detail::Readable => format!("{} values from {min} to {max} nm", values.len()),
            Detail::Complete => format!("{min} {max} {nm:?} {values:?}"),
        };
        let kind = match &source.kind {
            SpectrumKind::Constant(value) => value.to_string(),
            SpectrumKind::Irregular { nm, values, file } => {
                let ends = (nm.first().copied().unwrap_or(0.0), nm.last().copied().unwrap_or(0.0));
                let text = table(ends.0, ends.1, Some(nm), values);
                match file {
                    Some(file) if self.detail == Detail::Readable => format!("{text}, {}", file_name(file)),
                    _ => text,
                }
            }
            SpectrumKind::Regular { min_nm, max_nm, values } => table(*min_nm, *max_nm, None, values),
            SpectrumKind::D65 => "D65".to_owned(),
            SpectrumKind::Blackbody { kelvin, min_nm, max_nm } => {
                format!("black body of {kelvin} K from {min_nm} to {max_nm} nm")
            }
            SpectrumKind::Named(name) => format!("{name}, measured"),
        };
        self.line(&format!("{name}: {scale}{kind}"));
    }

    fn transform(&mut self, to_world: &Transform) {
        if *to_world == Transform::IDENTITY {
            return;
        }
        let matrix = to_world.matrix();
        if self.detail == Detail::Readable && *to_world == Transform::translation(matrix.w_axis.truncate()) {
            self.line(&format!("moved by {}", vector(matrix.w_axis.truncate())));
            return;
        }
        self.line("to_world");
        self.within(|o| {
            for row in 0..3 {
                let row = matrix.row(row).to_array();
                let readable = row.map(|x| format!("{:>10}", short(x))).join(" ");
                o.line(&if o.detail == Detail::Readable { readable } else { format!("{row:?}") });
            }
        });
    }
}

fn rough(roughness: &Option<Roughness>) -> &'static str {
    if roughness.is_some() { "rough " } else { "" }
}

fn axis_name(axis: FovAxis) -> &'static str {
    match axis {
        FovAxis::X => "the width",
        FovAxis::Y => "the height",
        FovAxis::Diagonal => "the diagonal",
        FovAxis::Smaller => "the smaller side",
        FovAxis::Larger => "the larger side",
    }
}

fn filter_name(filter: FilterKind) -> String {
    match filter {
        FilterKind::Box => "box".to_owned(),
        FilterKind::Tent { radius } => format!("tent, radius {radius}"),
        FilterKind::Gaussian { stddev } => format!("gaussian, standard deviation {stddev}"),
        FilterKind::Mitchell { b, c } => format!("mitchell, B {b}, C {c}"),
        FilterKind::CatmullRom => "catmullrom".to_owned(),
        FilterKind::Lanczos { lobes } => format!("lanczos, {lobes} lobes"),
    }
}

fn vector(vector: Vec3) -> String {
    format!("({}, {}, {})", vector.x, vector.y, vector.z)
}

/// At most six significant digits, and no minus before a zero.
fn short(number: f64) -> String {
    if number == 0.0 {
        return "0".to_owned();
    }
    let decimals = (5 - number.abs().log10().floor() as i32).clamp(0, 9) as usize;
    let text = format!("{number:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}
