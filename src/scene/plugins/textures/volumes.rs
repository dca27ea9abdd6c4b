//! Volumes: values in space.

use super::{ACCEL, Placed, RAW, TextureColor, wrap_mode};
use crate::geometry::Vec3;
use crate::raster::Grid;
use crate::scene::description::{
    DensitySource, ExponentialSource, PatternSpace, SampledSource, SpectrumKind, SpectrumSource, VolumeSource,
};
use crate::scene::info::hash_of_values;
use crate::scene::plugins::{
    Field, Parameter, Takes, boolean, choice, declare, float, ignored, integer, optional,
};
use crate::scene::read::spectra::{self, Use};
use crate::scene::read::textures::{decoded, varies};
use crate::scene::read::{Class, ObjectId, Query, Reader};
use crate::scene::source::{Place, SceneError};
use crate::scene::write::{Node, Value, Writer};
use crate::texture::{Filter, Wrap};
use std::path::PathBuf;
use std::sync::Arc;

/// A volume. One that is the same everywhere is a spectrum.
pub enum Volume {
    Constant(SpectrumSource),
    Grid(VolumeSource),
    Exponential(ExponentialSource),
    Sampled(SampledSource),
}

declare! {
    Class::Volume => Volume;

    "constvolume", "the same everywhere" => Volume::Constant(value) {
        value: TextureColor("value", 1.0, "value"),
    } ignoring [ignored("to_world", Takes::Transform, "").silent()];
    "gridvolume", "values on a grid over the unit cube"
        => Volume::Grid(VolumeSource { file, grid, to_world, filter, wrap, raw, use_grid_bbox }) {
        (file, grid): GridFile,
        filter: choice(
            "filter_type", Filter::Linear, &[("trilinear", Filter::Linear), ("nearest", Filter::Nearest)],
            "how cells are interpolated",
        ),
        wrap: wrap_mode(Wrap::Clamp),
        raw: RAW,
        use_grid_bbox: boolean(
            "use_grid_bbox", false, "whether it fills the box that its file states, and not the unit cube",
        ),
        to_world: Placed("to_world", "where it stands"),
    } ignoring [ACCEL] then thick;
    "exponential" extension "the density of an atmosphere: 1 on the ground, falling exponentially with height"
        => Volume::Exponential(ExponentialSource { to_world, radius, scale_height, top }) {
        scale_height: float("scale_height", 1.0, "height over which it falls by a factor of e").positive(),
        radius: optional(float("radius", 1.0, "of the ground, a sphere around the origin; otherwise it is z = 0").positive()),
        top: optional(float("top", 1.0, "height above which there is nothing; otherwise 12 `scale_height`").positive()),
        to_world: Placed("to_world", "where it stands; it may not stretch"),
    } then rigid;
    "texturevolume" extension "a pattern in space, looked up at the centres of cells that fill the unit cube"
        => Volume::Sampled(SampledSource { pattern, resolution, to_world }) {
        pattern: PatternInSpace,
        resolution: integer("resolution", 64, [2, 256], "cells along each axis, between which it is linear"),
        to_world: Placed("to_world", "where the cube stands"),
    };
}

/// A `<volume>`, wherever it stands.
pub fn of_object(reader: &Reader, id: ObjectId) -> Option<SpectrumSource> {
    let query = Query::new(reader, id);
    let volume = read(&query);
    if !NAMES.contains(&query.object.plugin.as_str()) {
        return None;
    }
    let place = query.object.place.clone();
    if let Some(Volume::Exponential(_) | Volume::Sampled(_)) = &volume {
        let expected = "expected it as the \"density\" of a `heterogeneous` medium or a `suspension`";
        query.error(SceneError::at(&query.object.plugin_place, "This volume is a density alone", expected));
    }
    query.finish();
    Some(match volume? {
        Volume::Exponential(_) | Volume::Sampled(_) => return None,
        Volume::Constant(source) => source,
        Volume::Grid(source) => {
            SpectrumSource { place, kind: SpectrumKind::Volume(Arc::new(source)), scale: 1.0 }
        }
    })
}

/// A volume that is a density alone: `None` for another one, and within it for one that is wrong, which is
/// reported.
pub fn density(reader: &Reader, id: ObjectId) -> Option<Option<DensitySource>> {
    let object = reader.tree.get(id);
    if object.class != Class::Volume || !["exponential", "texturevolume"].contains(&object.plugin.as_str()) {
        return None;
    }
    let query = Query::new(reader, id);
    let volume = read(&query);
    query.finish();
    Some(match volume {
        Some(Volume::Exponential(source)) => Some(DensitySource::Exponential(source)),
        Some(Volume::Sampled(source)) => Some(DensitySource::Sampled(Box::new(source))),
        _ => None,
    })
}

pub fn sampled_node(source: &SampledSource, place: &Place, writer: &mut Writer) -> Node {
    write(&Volume::Sampled(source.clone()), place, writer)
}

pub fn exponential_node(source: &ExponentialSource, place: &Place, writer: &mut Writer) -> Node {
    write(&Volume::Exponential(source.clone()), place, writer)
}

/// Refuses a transform under which heights would be others.
fn rigid(query: &Query<'_>, volume: Volume) -> Option<Volume> {
    if let Volume::Exponential(source) = &volume {
        let axes = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| source.to_world.vector(axis));
        let pairs = [(0, 0, 1.0), (1, 1, 1.0), (2, 2, 1.0), (0, 1, 0.0), (0, 2, 0.0), (1, 2, 0.0)];
        if pairs.iter().any(|&(i, j, expected)| (axes[i].dot(axes[j]) - expected).abs() > 1e-6) {
            query.error(SceneError::at(
                &query.place("to_world"),
                "The transform changes lengths or angles",
                "expected one that turns and moves",
            ));
            return None;
        }
    }
    Some(volume)
}

pub fn node(source: &VolumeSource, place: &Place, writer: &mut Writer) -> Node {
    write(&Volume::Grid(source.clone()), place, writer)
}

/// A texture that is computed from places in space.
struct PatternInSpace;

impl PatternInSpace {
    const NAME: &'static str = "texture";

    fn is_one(source: &SpectrumSource) -> bool {
        let SpectrumKind::Procedural(pattern) = &source.kind else { return false };
        let solid = matches!(pattern.space, PatternSpace::World(_));
        solid && pattern.colours.iter().all(|colour| !varies(colour) || Self::is_one(colour))
    }
}

impl Field for PatternInSpace {
    type Value = SpectrumSource;

    fn parameters(&self) -> Vec<Parameter> {
        let pattern = Parameter::new(Self::NAME, Takes::Spectrum(Use::Amount));
        let doc = "`noise`, `turbulence`, `bands`, `marble` or `wood` in space";
        vec![Parameter { is_required: true, doc, ..pattern }]
    }

    fn read(&self, query: &Query<'_>) -> Option<SpectrumSource> {
        query.required(Self::NAME, query.entry(Self::NAME))?;
        let source = spectra::read(query, Self::NAME, Use::Amount)?;
        if !Self::is_one(&source) {
            let problem = "This texture is no pattern in space";
            let expected = "expected a `noise`, `turbulence`, `bands`, `marble` or `wood`, not on u and v";
            query.error(SceneError::at(&query.place(Self::NAME), problem, expected));
            return None;
        }
        Some(source)
    }

    fn write(&self, node: Node, source: &SpectrumSource, _: &mut Writer) -> Node {
        node.spectrum(Self::NAME, source)
    }
}

/// A file of values on a grid.
struct GridFile;

impl Field for GridFile {
    type Value = (PathBuf, Arc<Grid>);

    fn parameters(&self) -> Vec<Parameter> {
        let file = Parameter::new("filename", Takes::File);
        vec![Parameter { is_required: true, doc: "file of Mitsuba's format of volumes", ..file }]
    }

    fn read(&self, query: &Query<'_>) -> Option<Self::Value> {
        let reader = query.reader;
        let file = query.file("filename")?;
        let place = query.place("filename");
        let grid = reader.grids.get(reader, &file, || decoded(&file, &place, Grid::decode))?;
        Some((file, grid))
    }

    fn write(&self, node: Node, (file, grid): &Self::Value, _: &mut Writer) -> Node {
        let Grid { size, channels, values, .. } = &**grid;
        let [x, y, z] = *size;
        let content = hash_of_values(&[x, y, z, *channels], values);
        let summary = format!("{x} × {y} × {z} cells, {channels} values each");
        node.with("filename", Value::File { path: file.clone(), content, summary })
    }
}

/// Refuses a grid whose own box is to be filled and has no volume.
fn thick(query: &Query<'_>, volume: Volume) -> Option<Volume> {
    if let Volume::Grid(source) = &volume
        && source.use_grid_bbox
        && crate::texture::from_box(source.grid.corners).is_none()
    {
        query.error(SceneError::at(
            &query.place("filename"),
            "The box of the grid is flat",
            "expected a box that has a volume",
        ));
        return None;
    }
    Some(volume)
}
