//! Shapes that are given by numbers on a grid.

use super::super::description::{HeightSource, ShapeKind};
use super::super::source::SceneError;
use super::query::Query;
use super::spectra::numbers;
use super::textures::image;
use crate::raster::Grid;
use crate::shape::{HeightData, SdfData, ShapeError, Terrain};
use std::sync::Arc;

/// A file can hold more, but none would be meant.
const MOST_LISTED: i64 = 1 << 16;

/// The words for shading normals, with whether they are smooth.
const NORMALS: [(&str, bool); 2] = [("analytic", false), ("smooth", true)];

/// `sdfgrid`, as in Mitsuba 3; `None` where it is wrong, which is reported.
pub(super) fn distances(query: &Query<'_>) -> Option<ShapeKind> {
    let reader = query.reader;
    let smooth = query.choice("normals", &NORMALS, false).unwrap_or(true);
    if query.has("flip_normals") {
        reader.extension(&query.place("flip_normals"), "flip_normals of an sdfgrid".to_owned());
    }
    let file = reader.search.find(query.required("filename", query.text("filename"))?);
    let place = query.place("filename");
    let grid = reader.grids.get(reader, &file, &place, Grid::decode)?;
    let refuse = |problem: String, expected: &str, remedy: &str| {
        query.error(SceneError::at(&place, problem, expected).with_remedy(remedy));
        None
    };
    if grid.channels != 1 {
        let problem = format!("The points of the grid have {} values", grid.channels);
        return refuse(problem, "expected one value, the distance", "take the grid of one channel");
    }
    match SdfData::new(grid.size, grid.values.clone()) {
        Ok(data) => Some(ShapeKind::Distances { file, data: Arc::new(data), smooth }),
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

/// `heightfield`; `None` where it is wrong, which is reported.
pub(super) fn heights(query: &Query<'_>) -> Option<ShapeKind> {
    query.reader.extension(&query.object.place, "heightfield: heights over a square".to_owned());
    let smooth = query.choice("normals", &NORMALS, false).unwrap_or(false);
    let scale = query.float("scale").unwrap_or(1.0);
    let base = query.float("base");
    let (source, data) = source(query)?;
    let lowest = data.range().map(|height| f64::from(height) * scale);
    let lowest = lowest[0].min(lowest[1]);
    if let Some(base) = base.filter(|&base| base >= lowest) {
        let problem = format!("The base of the height field is at {base}, and its lowest height at {lowest}");
        let error = SceneError::at(&query.place("base"), problem, "expected a base below all heights");
        query.error(error.with_remedy("heights are multiplied by \"scale\" before"));
        return None;
    }
    Some(ShapeKind::Heights { source, data: Arc::new(data), scale, base, smooth })
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
    let channel = query.integer("channel", 0, 3).unwrap_or(0) as usize;
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
    let values = numbers(query, "heights");
    let width = query.required("width", query.integer("width", 2, MOST_LISTED));
    let (values, width) = (values?, width? as usize);
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
    let hurst = query.float("hurst").unwrap_or(0.8);
    let levels = query.integer("levels", 1, i64::from(Terrain::MOST_LEVELS)).unwrap_or(8) as u32;
    let seed = query.integer("seed", 0, i64::from(u32::MAX)).unwrap_or(0) as u64;
    if !(0.0 < hurst && hurst < 1.0) {
        let problem = format!("\"hurst\" of {} is {hurst}", query.title());
        let error = SceneError::at(&query.place("hurst"), problem, "expected a number between 0 and 1");
        query.error(
            error.with_remedy("small numbers make rough terrain, large ones smooth; mountains have 0.8"),
        );
        return None;
    }
    let terrain = Terrain { levels, hurst, seed };
    let data = terrain.heights().map_err(|error| {
        let problem = format!("The terrain cannot be made: {error}");
        query.error(SceneError::at(&query.object.place, problem, "expected fewer levels"));
    });
    Some((HeightSource::Terrain(terrain), data.ok()?))
}
