//! Quadrics, which Mitsuba 3 does not have.

use super::super::description::ShapeKind;
use super::super::source::SceneError;
use super::query::Query;
use super::shapes::axis;
use super::spectra::numbers;
use crate::geometry::{Bounds, Transform, Vec3};
use crate::shape::{Quadric, QuadricKind, ShapeError, Sheets};

/// `None` where the shape is wrong, which is reported.
pub(super) fn read(query: &Query<'_>) -> Option<ShapeKind> {
    let plugin = query.object.plugin.as_str();
    query.reader.extension(&query.object.place, format!("{plugin}: a quadric surface"));
    let kind = match plugin {
        "cone" => {
            let [from, to] = axis(query);
            let radii = [radius(query, "radius", 1.0), radius(query, "radius1", 0.0)];
            if radii == [0.0; 2] {
                query.error(SceneError::at(
                    &query.place("radius"),
                    "The cone has no radius at either end",
                    "expected \"radius\" or \"radius1\" above 0",
                ));
            }
            QuadricKind::Cone { from, to, radii }
        }
        "paraboloid" => {
            let [from, to] = axis(query);
            QuadricKind::Paraboloid { from, to, radius: query.positive("radius", 1.0) }
        }
        "hyperboloid" => QuadricKind::Hyperboloid {
            sheets: match query.integer("sheets", 1, 2) {
                Some(2) => Sheets::Two,
                _ => Sheets::One,
            },
            radius: query.positive("radius", 1.0),
            semi_axis: query.positive("semi_axis", 1.0),
            heights: {
                let heights = [query.float("zmin").unwrap_or(-2.0), query.float("zmax").unwrap_or(2.0)];
                ascending(query, "zmax", heights[0], heights[1])?;
                heights
            },
        },
        _ => general(query)?,
    };
    let capped = query.boolean("capped", true);
    // Whether there is a surface, and an end to it, is not to be seen from single numbers.
    if let Err(error @ (ShapeError::Endless | ShapeError::Nothing)) =
        Quadric::of_kind(&Transform::IDENTITY, &kind, capped, false)
    {
        let problem = format!("The {plugin} cannot be made: {error}");
        let error = SceneError::at(&query.object.place, problem, "expected a surface of finite size");
        query.error(error.with_remedy(match kind {
            QuadricKind::General { .. } => "cut it off by min and max, or by zmin and zmax",
            _ => "zmin and zmax must reach beyond the semi_axis",
        }));
    }
    Some(ShapeKind::Quadric { kind, capped })
}

/// 0 or more.
fn radius(query: &Query<'_>, name: &'static str, default: f64) -> f64 {
    let radius = query.float(name).unwrap_or(default);
    if radius < 0.0 {
        let problem = format!("\"{name}\" of {} is {radius}", query.title());
        query.error(SceneError::at(&query.place(name), problem, "expected a number of at least 0"));
    }
    radius
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

fn general(query: &Query<'_>) -> Option<QuadricKind> {
    let coefficients = numbers(query, "coefficients");
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
        query.error(SceneError::at(&query.place("coefficients"), "A quadric has ten coefficients", expected));
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
    ascend.then_some(QuadricKind::General { coefficients, clip })
}
