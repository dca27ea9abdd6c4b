//! Quadrics, which Mitsuba 3 does not have.

use crate::geometry::{Bounds, Transform, Vec3};
use crate::scene::description::ShapeKind;
use crate::scene::plugins::fields::{Boolean, Integer};
use crate::scene::plugins::{Field, Parameter, Range, Simple, Takes, boolean, integer, numbers};
use crate::scene::read::{Query, spectra};
use crate::scene::source::SceneError;
use crate::scene::write::{Node, Writer};
use crate::shape::{Quadric, QuadricKind, ShapeError, Sheets};

pub const CAPPED: Simple<Boolean> = boolean("capped", true, "whether it is closed where it is cut off");

/// Whether a hyperboloid has one sheet or two.
pub struct NumberOfSheets;

impl NumberOfSheets {
    fn field() -> Simple<Integer<u32>> {
        integer(
            "sheets",
            1,
            [1, 2],
            "number of sheets: 1, where radius² is added, or 2, where it is subtracted",
        )
    }
}

impl Field for NumberOfSheets {
    type Value = Sheets;

    fn parameters(&self) -> Vec<Parameter> {
        Self::field().parameters()
    }

    fn read(&self, query: &Query<'_>) -> Option<Sheets> {
        Some(if Self::field().read(query)? == 2 { Sheets::Two } else { Sheets::One })
    }

    fn write(&self, node: Node, sheets: &Sheets, _: &mut Writer) -> Node {
        node.integer("sheets", if *sheets == Sheets::One { 1 } else { 2 })
    }
}

/// The coefficients of a general quadric, and the box that cuts it off.
pub struct General;

impl Field for General {
    type Value = ([f64; 10], Bounds);

    fn parameters(&self) -> Vec<Parameter> {
        let corner = |name, doc| Parameter { doc, ..Parameter::new(name, Takes::Vector) };
        let plane = |name, doc| Parameter { doc, ..Parameter::new(name, Takes::Float(Range::ALL)) };
        let coefficients = numbers(
            "coefficients",
            "A to J of A x² + B y² + C z² + D xy + E xz + F yz + G x + H y + I z + J = 0, negative inside",
        );
        let clip = vec![
            corner("min", "least corner of a box that cuts it off"),
            corner("max", "greatest corner of it"),
            plane("zmin", "instead of `min`, where it is cut off below"),
            plane("zmax", "instead of `max`, where it is cut off above"),
        ];
        [coefficients.parameters(), clip].concat()
    }

    fn read(&self, query: &Query<'_>) -> Option<([f64; 10], Bounds)> {
        let coefficients = spectra::numbers(query, "coefficients");
        let mut clip = Bounds {
            min: query.vector("min").unwrap_or(Vec3::NEG_INFINITY),
            max: query.vector("max").unwrap_or(Vec3::INFINITY),
        };
        for (name, other, plane) in [("zmin", "min", &mut clip.min.z), ("zmax", "max", &mut clip.max.z)] {
            let Some(height) = query.float(name) else { continue };
            if plane.is_finite() {
                let problem = format!("The quadric is cut off by \"{name}\" and by \"{other}\"");
                query.error(SceneError::at(&query.place(name), problem, "expected one of them"));
            }
            *plane = height;
        }
        let ascend = (0..3).map(|axis| ascending(query, "max", clip.min[axis], clip.max[axis]));
        let ascend = ascend.collect::<Vec<_>>().into_iter().all(|fine| fine.is_some());
        let coefficients = query.required("coefficients", coefficients)?;
        let Ok(coefficients) = <[f64; 10]>::try_from(coefficients) else {
            let expected = "expected the ten numbers A to J of A x² + B y² + C z² + D xy + E xz + F yz + G x + H y + I z + J = 0";
            query.error(SceneError::at(
                &query.place("coefficients"),
                "A quadric has ten coefficients",
                expected,
            ));
            return None;
        };
        if coefficients[..9].iter().all(|&c| c == 0.0) {
            query.error(SceneError::at(
                &query.place("coefficients"),
                "The polynomial is the same everywhere",
                "expected one of the first nine coefficients to differ from 0",
            ));
            return None;
        }
        ascend.then_some((coefficients, clip))
    }

    fn write(&self, node: Node, (coefficients, clip): &Self::Value, _: &mut Writer) -> Node {
        let node = node.numbers("coefficients", coefficients);
        // Planes infinitely far away are left out: a file has no infinite numbers.
        [("min", "zmin", clip.min), ("max", "zmax", clip.max)].into_iter().fold(
            node,
            |node, (corner, plane, at)| match (at.x.is_finite(), at.z.is_finite()) {
                (true, _) => node.vector(corner, at),
                (false, true) => node.float(plane, at.z),
                (false, false) => node,
            },
        )
    }
}

/// `None` where it is reported that they are not.
fn ascending(query: &Query<'_>, name: &'static str, low: f64, high: f64) -> Option<()> {
    if low >= high {
        let problem = format!("The {} is cut off from {low} to {high}", query.object.plugin);
        query.error(SceneError::at(
            &query.place(name),
            problem,
            "expected the lower plane below the upper one",
        ));
        return None;
    }
    Some(())
}

/// Refuses a surface that is empty or unbounded.
pub fn finite(query: &Query<'_>, shape: ShapeKind) -> Option<ShapeKind> {
    let ShapeKind::Quadric { kind, capped } = &shape else { return Some(shape) };
    match kind {
        QuadricKind::Cone { radii: [0.0, 0.0], .. } => query.error(SceneError::at(
            &query.place("radius"),
            "The cone has no radius at either end",
            "expected \"radius\" or \"radius1\" above 0",
        )),
        QuadricKind::Hyperboloid { heights: [low, high], .. } => ascending(query, "zmax", *low, *high)?,
        _ => {}
    }
    // Whether there is a surface, and an end to it, is not to be seen from single numbers.
    if let Err(error @ (ShapeError::Endless | ShapeError::Nothing)) =
        Quadric::of_kind(&Transform::IDENTITY, kind, *capped, false)
    {
        let problem = format!("The {} cannot be made: {error}", query.object.plugin);
        let error = SceneError::at(&query.object.place, problem, "expected a surface of finite size");
        query.error(error.with_remedy(match kind {
            QuadricKind::General { .. } => "cut it off by min and max, or by zmin and zmax",
            _ => "zmin and zmax must reach beyond the semi_axis",
        }));
    }
    Some(shape)
}
