//! Files of measured reflection.

use crate::bsdf::{MeasuredTable, Symmetry};
use crate::raster::{ImageError, Tensor, Tensors};
use crate::sampling::{ParametricDensity, ParametricGrid};
use crate::scene::description::MeasuredSource;
use crate::scene::info::hash_of_bytes;
use crate::scene::plugins::{Field, Parameter, Takes};
use crate::scene::read::Query;
use crate::scene::read::textures::decoded;
use crate::scene::write::{Node, Value, Writer};
use std::f64::consts::TAU;

/// The file of a measurement.
pub struct Measurement;

impl Field for Measurement {
    type Value = MeasuredSource;

    fn parameters(&self) -> Vec<Parameter> {
        let file = Parameter::new("filename", Takes::File);
        let doc = "a spectral measurement of the RGL database, <https://rgl.epfl.ch/materials>";
        vec![Parameter { is_required: true, doc, ..file }]
    }

    fn read(&self, query: &Query<'_>) -> Option<MeasuredSource> {
        let file = query.file("filename")?;
        let place = query.place("filename");
        let mut is_rgb = false;
        let table = decoded(&file, &place, |bytes| {
            let content = hash_of_bytes(bytes);
            let table = MeasuredTable::shared(content, || {
                let tensors = Tensors::decode(bytes)?;
                is_rgb = tensors.has("rgb") && !tensors.has("spectra");
                table(&tensors)
            });
            table.map(|table| (table, content))
        });
        match table {
            Ok((table, content)) => Some(MeasuredSource { file, table, content }),
            Err(error) => {
                let remedy = "the file is the colour version of a measurement: \
                              the same page has the spectral one, whose name ends with _spec";
                query.error(if is_rgb { error.with_remedy(remedy) } else { error });
                None
            }
        }
    }

    fn write(&self, node: Node, source: &MeasuredSource, _: &mut Writer) -> Node {
        let [azimuths, angles, wavelengths] = source.table.spectra.lengths();
        let summary = format!("{azimuths} × {angles} directions, {wavelengths} wavelengths");
        node.with("filename", Value::File { path: source.file.clone(), content: source.content, summary })
    }
}

/// The tables of a file, each checked for what the others say of its size.
fn table(tensors: &Tensors<'_>) -> Result<MeasuredTable, ImageError> {
    let axis = |name: &str| -> Result<Vec<f64>, ImageError> {
        let values: Vec<f64> = tensors.floats(name, 1)?.values.into_iter().map(f64::from).collect();
        let ascends = !values.is_empty() && values.windows(2).all(|pair| pair[0] < pair[1]);
        ascends.then_some(values).ok_or_else(|| ImageError {
            problem: format!("The values of the field {name} do not ascend"),
            expected: "expected one or more, each above the one before".to_owned(),
        })
    };
    // The field that a spectral file has is asked for first.
    let spectra = tensors.floats("spectra", 5)?;
    let (azimuths, angles, wavelengths) = (axis("phi_i")?, axis("theta_i")?, axis("wavelengths")?);
    let eye = [azimuths.clone(), angles.clone()];
    let is_isotropic = azimuths.len() <= 2;
    let symmetry = match TAU / (azimuths[azimuths.len() - 1] - azimuths[0]) {
        _ if is_isotropic => Symmetry::None,
        parts if parts.round() == 2.0 => Symmetry::HalfTurn,
        parts if parts.round() == 4.0 => Symmetry::Mirrored,
        _ => Symmetry::None,
    };
    let jacobian = tensors.bytes("jacobian")?;
    Ok(MeasuredTable {
        normals: grid("ndf", tensors.floats("ndf", 2)?, [])?,
        visible_area: grid("sigma", tensors.floats("sigma", 2)?, [])?,
        visible_normals: ParametricDensity::new(grid("vndf", tensors.floats("vndf", 4)?, eye.clone())?),
        luminance: ParametricDensity::new(grid("luminance", tensors.floats("luminance", 4)?, eye)?),
        spectra: grid("spectra", spectra, [azimuths, angles, wavelengths])?,
        is_relative: jacobian.first().is_some_and(|&flag| flag != 0),
        is_isotropic,
        symmetry,
    })
}

/// Values below 0, which noise makes of black, count as 0.
fn grid<const N: usize>(
    name: &str,
    Tensor { shape, mut values }: Tensor,
    axes: [Vec<f64>; N],
) -> Result<ParametricGrid<N>, ImageError> {
    values.iter_mut().for_each(|value| *value = value.max(0.0));
    let expected = axes.each_ref().map(Vec::len);
    let size = [shape[N + 1], shape[N]];
    let grid = if shape[..N] == expected { ParametricGrid::new(axes, size, values) } else { None };
    grid.ok_or_else(|| {
        let sizes = |shape: &[usize]| shape.iter().map(|size| format!("{size} × ")).collect::<String>();
        let found = sizes(&shape);
        ImageError {
            problem: format!("The field {name} has a size of {}", found.trim_end_matches(" × ")),
            expected: format!("expected {}rows × columns, two or more of each", sizes(&expected)),
        }
    })
}
