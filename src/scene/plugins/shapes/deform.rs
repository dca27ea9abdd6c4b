//! What is done to a mesh before it is placed: "subdivide 4; twist 90; taper -0.3; bend 60 -1 1".

use crate::scene::description::ShapeKind;
use crate::scene::plugins::fields::Text;
use crate::scene::plugins::{Simple, text};
use crate::scene::read::{Query, attributes};
use crate::scene::source::SceneError;
use crate::shape::{Deformation, ShapeError};
use std::sync::Arc;

/// What is done to a mesh.
pub const DEFORM: Simple<Text> = text("deform", "\"subdivide n; twist degrees; taper slope; bend degrees zmin zmax\", one after another, along z and per unit of it")
    .extension("a mesh twisted, tapered or bent");

/// The mesh after what "deform" asks for. `None` where it is wrong, which is reported.
pub fn deformed(query: &Query<'_>, mut shape: ShapeKind) -> Option<ShapeKind> {
    let ShapeKind::Mesh { mesh, deform: Some(text), .. } = &mut shape else { return Some(shape) };
    let place = query.place("deform");
    let words = text.split(';').map(str::trim).filter(|word| !word.is_empty());
    let all = words.map(|word| one(query, word)).collect::<Option<Vec<Deformation>>>()?;
    match mesh.deformed(&all) {
        Ok(made) => {
            *mesh = Arc::new(made);
            *text = text.trim().to_owned();
            Some(shape)
        }
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
