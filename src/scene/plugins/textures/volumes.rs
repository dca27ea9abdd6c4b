//! Volumes: values in space.

use super::{ACCEL, Part, Placed, RAW, wrap_mode};
use crate::raster::Grid;
use crate::scene::description::{SpectrumKind, SpectrumSource, VolumeSource};
use crate::scene::info::hash_of_values;
use crate::scene::plugins::{Field, Parameter, Takes, boolean, choice, declare, ignored};
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
}

declare! {
    Class::Volume => Volume;

    "constvolume", "the same everywhere" => Volume::Constant(value) {
        value: Part("value", 1.0, "value"),
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
}

/// A `<volume>`, wherever it stands.
pub fn of_object(reader: &Reader, id: ObjectId) -> Option<SpectrumSource> {
    let query = Query::new(reader, id);
    let volume = read(&query);
    if !NAMES.contains(&query.object.plugin.as_str()) {
        return None;
    }
    let place = query.object.place.clone();
    query.finish();
    Some(match volume? {
        Volume::Constant(source) => source,
        Volume::Grid(source) => {
            SpectrumSource { place, kind: SpectrumKind::Volume(Arc::new(source)), scale: 1.0 }
        }
    })
}

pub fn node(source: &VolumeSource, place: &Place, writer: &mut Writer) -> Node {
    write(&Volume::Grid(source.clone()), place, writer)
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
        let file = reader.search.find(query.required("filename", query.text("filename"))?);
        let grid = reader.grids.get(reader, &file, &query.place("filename"), Grid::decode)?;
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
