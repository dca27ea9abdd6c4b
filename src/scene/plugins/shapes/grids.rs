//! Shapes that are given by numbers on a grid.

use crate::raster::Grid;
use crate::scene::description::{HeightSource, ShapeKind};
use crate::scene::info::hash_of_values;
use crate::scene::plugins::fields::{Choices, Float, Integer};
use crate::scene::plugins::textures::image;
use crate::scene::plugins::{Field, Parameter, Range, Simple, Takes, choice, float, integer, optional};
use crate::scene::read::textures::decoded;
use crate::scene::read::{Query, spectra};
use crate::scene::source::SceneError;
use crate::scene::write::{Node, Value, Writer};
use crate::shape::{HeightData, SdfData, ShapeError, Terrain};
use std::path::PathBuf;
use std::sync::Arc;

/// A file can hold more, but none would be meant.
const MOST_LISTED: i64 = 1 << 16;

/// The words for shading normals, with whether they are smooth.
const NORMALS: [(&str, bool); 2] = [("analytic", false), ("smooth", true)];

pub const fn normals(smooth: bool) -> Simple<Choices<bool>> {
    choice("normals", smooth, &NORMALS, "shading normals: those of the surface, or smooth ones")
}

/// A file of distances.
pub struct DistanceFile;

impl Field for DistanceFile {
    type Value = (PathBuf, Arc<SdfData>);

    fn parameters(&self) -> Vec<Parameter> {
        let file = Parameter::new("filename", Takes::File);
        vec![Parameter { is_required: true, doc: "grid of signed distances, negative inside", ..file }]
    }

    fn read(&self, query: &Query<'_>) -> Option<Self::Value> {
        let reader = query.reader;
        if query.has("flip_normals") {
            reader.extension(&query.place("flip_normals"), "flip_normals of an sdfgrid".to_owned());
        }
        let file = query.file("filename")?;
        let place = query.place("filename");
        let grid = reader.grids.get(reader, &file, || decoded(&file, &place, Grid::decode))?;
        let refuse = |problem: String, expected: &str, remedy: &str| {
            query.error(SceneError::at(&place, problem, expected).with_remedy(remedy));
            None
        };
        if grid.channels != 1 {
            let problem = format!("The points of the grid have {} values", grid.channels);
            return refuse(problem, "expected one value, the distance", "take the grid of one channel");
        }
        match SdfData::new(grid.size, grid.values.clone()) {
            Ok(data) => Some((file, Arc::new(data))),
            Err(ShapeError::Nothing) => refuse(
                "The values of the grid all have the same sign: there is no surface".to_owned(),
                "expected values below 0 inside and above 0 outside",
                "distances are positive outside of a shape, in units of the grid's cube",
            ),
            Err(error) => {
                let [x, y, z] = grid.size;
                let problem = format!("The grid of {x} × {y} × {z} points makes no shape: {error}");
                refuse(
                    problem,
                    "expected at least 2 points along each axis",
                    "values are at the corners of cells",
                )
            }
        }
    }

    fn write(&self, node: Node, (file, data): &Self::Value, _: &mut Writer) -> Node {
        let (points, values) = data.grid();
        let [x, y, z] = points;
        let filename = Value::File {
            path: file.clone(),
            content: hash_of_values(&[x, y, z, 1], values),
            summary: format!("{x} × {y} × {z} points"),
        };
        node.with("filename", filename)
    }
}

/// Heights from an image, a list, or made up.
pub struct Heights;

impl Field for Heights {
    type Value = (HeightSource, Arc<HeightData>);

    fn parameters(&self) -> Vec<Parameter> {
        let list = Parameter::new("heights", Takes::Numbers);
        let file = Parameter::new("filename", Takes::File);
        let terrain = Parameter::new("terrain", Takes::Choice(vec!["spectral"]));
        [
            vec![Parameter { doc: "image of heights", ..file }],
            CHANNEL.parameters(),
            vec![Parameter { doc: "instead of an image, heights row by row", ..list }],
            optional(WIDTH).parameters(),
            vec![Parameter { doc: "instead of an image, a fractal", ..terrain }],
            LEVELS.parameters(),
            HURST.parameters(),
            SEED.parameters(),
        ]
        .concat()
    }

    fn read(&self, query: &Query<'_>) -> Option<Self::Value> {
        source(query).map(|(source, data)| (source, Arc::new(data)))
    }

    fn write(&self, node: Node, (source, data): &Self::Value, writer: &mut Writer) -> Node {
        let ([width, depth], values) = data.grid();
        match source {
            HeightSource::Image { file, channel } => {
                let filename = Value::File {
                    path: file.clone(),
                    content: hash_of_values(&[width, depth, 1], values),
                    summary: format!("{width} × {depth} heights"),
                };
                CHANNEL.write(node.with("filename", filename), channel, writer)
            }
            HeightSource::List => {
                let values: Vec<f64> = values.iter().map(|&value| f64::from(value)).collect();
                WIDTH.write(node.numbers("heights", &values), &width, writer)
            }
            HeightSource::Terrain(Terrain { levels, hurst, seed }) => {
                let node = LEVELS.write(node.text("terrain", "spectral"), levels, writer);
                SEED.write(HURST.write(node, hurst, writer), seed, writer)
            }
        }
    }
}

const CHANNEL: Simple<Integer<usize>> = integer("channel", 0, [0, 3], "channel of the image");
const WIDTH: Simple<Integer<usize>> = integer("width", 0, [2, MOST_LISTED], "length of a row of `heights`");
const LEVELS: Simple<Integer<u32>> =
    integer("levels", 8, [1, Terrain::MOST_LEVELS as i64], "of the fractal: it has 2^levels cells a side");
const HURST: Simple<Float> = float("hurst", 0.8, "of the fractal: from rough, near 0, to smooth, near 1")
    .within(Range { low: 0.0, with_low: false, high: 1.0, with_high: false })
    .remedy("small numbers make rough terrain, large ones smooth; mountains have 0.8");
const SEED: Simple<Integer<u64>> =
    integer("seed", 0, [0, u32::MAX as i64], "of the fractal: what it follows from");

/// Refuses a bottom that is above the heights.
pub fn above_base(query: &Query<'_>, shape: ShapeKind) -> Option<ShapeKind> {
    let ShapeKind::Heights { data, scale, base, .. } = &shape else { return Some(shape) };
    let lowest = data.range().map(|height| f64::from(height) * scale);
    let lowest = lowest[0].min(lowest[1]);
    if let Some(base) = base.filter(|&base| base >= lowest) {
        let problem = format!("The base of the height field is at {base}, and its lowest height at {lowest}");
        let error = SceneError::at(&query.place("base"), problem, "expected a base below all heights");
        query.error(error.with_remedy("heights are multiplied by \"scale\" before"));
        return None;
    }
    Some(shape)
}

/// Heights from one of three places.
fn source(query: &Query<'_>) -> Option<(HeightSource, HeightData)> {
    let given: Vec<&'static str> =
        ["filename", "heights", "terrain"].into_iter().filter(|name| query.has(name)).collect();
    let [name] = given[..] else {
        let problem = match given[..] {
            [] => "The height field has no heights".to_owned(),
            _ => format!("The height field has its heights from {}", given.join(" and ")),
        };
        let expected = "expected one of \"filename\" (an image), \"heights\" (a list) and \"terrain\"";
        query.error(SceneError::at(&query.object.place, problem, expected));
        return None;
    };
    let (source, points, values) = match name {
        "filename" => from_image(query)?,
        "heights" => from_list(query)?,
        _ => return terrain(query),
    };
    match HeightData::new(points, values) {
        Ok(data) => Some((source, data)),
        Err(error) => {
            let [width, depth] = points;
            let problem = format!("{width} × {depth} heights make no shape: {error}");
            let expected = "expected finite heights at 2 × 2 points at least";
            query.error(SceneError::at(&query.place(name), problem, expected));
            None
        }
    }
}

/// One channel as it is stored, the first row at y = −1, where v is 0.
fn from_image(query: &Query<'_>) -> Option<(HeightSource, [usize; 2], Vec<f32>)> {
    let found = image(query, "filename");
    let channel = CHANNEL.read(query)?;
    let (file, image) = found?;
    if channel >= image.channels {
        let problem = format!("The image has no channel {channel}");
        let expected = match image.channels {
            1 => "expected 0, the only one".to_owned(),
            count => format!("expected a channel from 0 to {}", count - 1),
        };
        query.error(SceneError::at(&query.place("channel"), problem, expected));
        return None;
    }
    let values = image.values.chunks_exact(image.channels).map(|texel| texel[channel]).collect();
    Some((HeightSource::Image { file, channel }, [image.width, image.height], values))
}

/// Row by row, the first at y = −1.
fn from_list(query: &Query<'_>) -> Option<(HeightSource, [usize; 2], Vec<f32>)> {
    let values = spectra::numbers(query, "heights");
    let width = WIDTH.required().read(query);
    let (values, width) = (values?, width?);
    if values.len() % width != 0 {
        let problem = format!("{} heights make no rows of {width}", values.len());
        let expected = "expected as many heights as \"width\", or a multiple of it";
        query.error(SceneError::at(&query.place("heights"), problem, expected));
        return None;
    }
    let depth = values.len() / width;
    Some((HeightSource::List, [width, depth], values.into_iter().map(|value| value as f32).collect()))
}

fn terrain(query: &Query<'_>) -> Option<(HeightSource, HeightData)> {
    query.choice("terrain", &[("spectral", ())], false)?;
    let (hurst, levels, seed) = (HURST.read(query)?, LEVELS.read(query)?, SEED.read(query)?);
    let terrain = Terrain { levels, hurst, seed };
    let data = terrain.heights().map_err(|error| {
        let problem = format!("The terrain cannot be made: {error}");
        query.error(SceneError::at(&query.object.place, problem, "expected fewer levels"));
    });
    Some((HeightSource::Terrain(terrain), data.ok()?))
}
