//! What is done to a mesh before it is placed: "subdivide 4; twist 90; taper -0.3; bend 60 -1 1".

use super::super::source::SceneError;
use super::attributes;
use super::query::Query;
use crate::shape::{Deformation, MeshData, ShapeError};
use std::sync::Arc;

/// The mesh after what "deform" asks for, and that as it is told. `None` where it is wrong, which is
/// reported.
pub(super) fn deformed(query: &Query<'_>, mesh: Arc<MeshData>) -> Option<(Arc<MeshData>, Option<String>)> {
    let Some(text) = query.text("deform") else { return Some((mesh, None)) };
    let place = query.place("deform");
    query.reader.extension(&place, "deform: a mesh twisted, tapered or bent".to_owned());
    let words = text.split(';').map(str::trim).filter(|word| !word.is_empty());
    let all = words.map(|word| one(query, word)).collect::<Option<Vec<Deformation>>>()?;
    match mesh.deformed(&all) {
        Ok(made) => Some((Arc::new(made), Some(text.trim().to_owned()))),
        Err(error) => {
            let (expected, remedy) = match error {
                ShapeError::Folded { .. } => (
                    "expected a deformation that turns nothing inside out",
                    "a taper must leave 1 + slope z above 0, and a bend what is nearer to its axis than 180 / (π rate)",
                ),
                _ => ("expected fewer triangles", "subdivide less"),
            };
            let problem = format!("The mesh cannot be deformed: {error}");
            query.error(SceneError::at(&place, problem, expected).with_remedy(remedy));
            None
        }
    }
}

fn one(query: &Query<'_>, text: &str) -> Option<Deformation> {
    let mut words = text.split_whitespace();
    let name = words.next().unwrap_or_default();
    let numbers: Option<Vec<f64>> = words.map(attributes::number).collect();
    let found = match (name, numbers.as_deref()) {
        ("subdivide", Some(&[times]))
            if (0.0..=f64::from(u32::MAX)).contains(&times) && times.fract() == 0.0 =>
        {
            Some(Deformation::Subdivide(times as u32))
        }
        ("twist", Some(&[degrees])) => Some(Deformation::Twist(degrees.to_radians())),
        ("taper", Some(&[slope])) => Some(Deformation::Taper(slope)),
        ("bend", Some(&[degrees, from, to])) if from < to => {
            Some(Deformation::Bend { rate: degrees.to_radians(), from, to })
        }
        _ => None,
    };
    if found.is_none() {
        let problem = format!("\"{text}\" is no deformation");
        let expected = "expected \"twist degrees\", \"taper slope\", \"bend degrees zmin zmax\" or \"subdivide n\", n a whole number";
        let error = SceneError::at(&query.place("deform"), problem, expected);
        query.error(
            error.with_remedy("degrees and slopes are per unit of z; semicolons separate deformations"),
        );
    }
    found
}
