//! Profiles and implicit surfaces, which Mitsuba 3 does not have.

use super::super::description::ShapeKind;
use super::super::source::SceneError;
use super::attributes;
use super::query::Query;
use super::spectra::numbers;
use crate::geometry::{Transform, Vec3};
use crate::shape::{
    Blob, FillRule, Interpolation, Kernel, ProfileOrImplicit, ProfileOrImplicitKind, ShapeError,
};

/// `None` where the shape is wrong, which is reported.
pub(super) fn read(query: &Query<'_>) -> Option<ShapeKind> {
    let plugin = query.object.plugin.as_str();
    let what = match plugin {
        "polygon" => "a flat shape with any outline",
        "extrusion" => "a polygon swept along z",
        "revolution" => "a profile turned around z",
        "blobs" => "soft balls that flow together",
        _ => "an ellipsoid between box and octahedron",
    };
    query.reader.extension(&query.object.place, format!("{plugin}: {what}"));
    let kind = match plugin {
        "polygon" => {
            let contours = contours(query);
            let rule = rule(query);
            ProfileOrImplicitKind::Polygon { contours: contours?, rule }
        }
        "revolution" => revolution(query)?,
        "blobs" => blobs(query)?,
        "superquadric" => ProfileOrImplicitKind::Superquadric {
            exponents: [query.positive("e1", 1.0), query.positive("e2", 1.0)],
            semi_axes: query.vector("semi_axes").unwrap_or(Vec3::ONE),
        },
        _ => {
            let contours = contours(query);
            let rule = rule(query);
            let heights = heights(query);
            let capped = query.boolean("capped", true);
            ProfileOrImplicitKind::Extrusion { contours: contours?, rule, heights: heights?, capped }
        }
    };
    // Whether there is a surface is not to be seen from single numbers.
    if let Err(error) = ProfileOrImplicit::new(&Transform::IDENTITY, &kind, false) {
        let problem = format!("The {plugin} cannot be made: {error}");
        let (name, expected, remedy) = match kind {
            ProfileOrImplicitKind::Revolution { interpolation, .. } => (
                "profile",
                match interpolation {
                    Interpolation::Linear => "expected two or more points \"r z\", no r below 0",
                    Interpolation::Bezier => {
                        "expected a number of points that is 1 more than a multiple of 3, no r below 0"
                    }
                    Interpolation::BSpline => {
                        "expected four or more points \"r z\", no r of the curve below 0"
                    }
                },
                match interpolation {
                    Interpolation::Bezier => {
                        "a closed one comes back to its first point, which is not given again"
                    }
                    _ => "r is the distance from the z axis",
                },
            ),
            ProfileOrImplicitKind::Blobs { .. } => (
                "threshold",
                "expected a threshold that the densities reach somewhere",
                "in its centre the density of a ball alone is its strength, 1 unless given",
            ),
            ProfileOrImplicitKind::Superquadric { exponents, .. } => (
                match error {
                    ShapeError::Exponent(wrong) if wrong == exponents[0] => "e1",
                    ShapeError::Exponent(_) => "e2",
                    _ => "semi_axes",
                },
                "expected exponents from 0.001 to 2 and semi-axes above 0",
                "exponents near 0 make a box, 1 an ellipsoid and 2 an octahedron",
            ),
            ProfileOrImplicitKind::Polygon { .. } | ProfileOrImplicitKind::Extrusion { .. } => (
                "outline",
                "expected contours with an inside",
                "what an even number of contours goes around is outside, unless the rule is \"winding\"",
            ),
        };
        query.error(SceneError::at(&query.place(name), problem, expected).with_remedy(remedy));
        return None;
    }
    Some(ShapeKind::ProfileOrImplicit(kind))
}

fn revolution(query: &Query<'_>) -> Option<ProfileOrImplicitKind> {
    let interpolations = [
        ("linear", Interpolation::Linear),
        ("bezier", Interpolation::Bezier),
        ("bspline", Interpolation::BSpline),
    ];
    let interpolation =
        query.choice("interpolation", &interpolations, false).unwrap_or(Interpolation::Linear);
    let (closed, capped) = (query.boolean("closed", false), query.boolean("capped", true));
    let text = query.text("profile");
    let text = query.required("profile", text)?;
    let profile = points::<2>(query, "profile", text)?;
    Some(ProfileOrImplicitKind::Revolution { profile, interpolation, closed, capped })
}

fn blobs(query: &Query<'_>) -> Option<ProfileOrImplicitKind> {
    let kernels = [("gaussian", Kernel::Gaussian), ("metaball", Kernel::Metaball), ("soft", Kernel::Soft)];
    let kernel = query.choice("kernel", &kernels, false).unwrap_or(Kernel::Soft);
    let threshold = query.positive("threshold", 0.5);
    let (radii, strengths) = (query.has("radii"), query.has("strengths"));
    let radii = if radii { numbers(query, "radii") } else { Some(vec![1.0]) };
    let strengths = if strengths { numbers(query, "strengths") } else { Some(vec![1.0]) };
    let text = query.text("centers");
    let text = query.required("centers", text)?;
    let centres = points::<3>(query, "centers", text)?;
    let count = centres.len();
    let (radii, strengths) =
        (each(query, "radii", radii?, count)?, each(query, "strengths", strengths?, count)?);
    if let Some(wrong) = radii.iter().find(|radius| **radius <= 0.0) {
        let problem = format!("A radius of the blobs is {wrong}");
        query.error(SceneError::at(&query.place("radii"), problem, "expected numbers above 0"));
        return None;
    }
    let blob = |((centre, radius), strength): (([f64; 3], f64), f64)| Blob {
        centre: centre.into(),
        radius,
        strength,
    };
    let blobs = centres.into_iter().zip(radii).zip(strengths).map(blob).collect();
    Some(ProfileOrImplicitKind::Blobs { blobs, kernel, threshold })
}

/// One number for all of them, or one for each. `None` where it is reported that there are others.
fn each(query: &Query<'_>, name: &'static str, numbers: Vec<f64>, count: usize) -> Option<Vec<f64>> {
    match numbers[..] {
        [one] => Some(vec![one; count]),
        _ if numbers.len() == count => Some(numbers),
        _ => {
            let problem = format!("There are {} {name} for {count} centers", numbers.len());
            query.error(SceneError::at(&query.place(name), problem, "expected one, or one for each center"));
            None
        }
    }
}

fn rule(query: &Query<'_>) -> FillRule {
    let rules = [("evenodd", FillRule::EvenOdd), ("winding", FillRule::Winding)];
    query.choice("rule", &rules, false).unwrap_or(FillRule::EvenOdd)
}

/// `None` where it is reported that they are not in order.
fn heights(query: &Query<'_>) -> Option<[f64; 2]> {
    let heights = [query.float("zmin").unwrap_or(0.0), query.float("zmax").unwrap_or(1.0)];
    if heights[0] >= heights[1] {
        let problem = format!("The {} reaches from {} to {}", query.object.plugin, heights[0], heights[1]);
        query.error(SceneError::at(&query.place("zmax"), problem, "expected zmin below zmax"));
        return None;
    }
    Some(heights)
}

/// Points "x y" separated by commas, contours by semicolons. `None` where it is wrong, which is reported.
fn contours(query: &Query<'_>) -> Option<Vec<Vec<[f64; 2]>>> {
    let text = query.text("outline");
    let text = query.required("outline", text)?;
    let mut contours = Vec::new();
    for contour in text.split(';').filter(|contour| !contour.trim().is_empty()) {
        let mut points = points::<2>(query, "outline", contour)?;
        // A contour that says that it is closed.
        if points.len() > 1 && points.first() == points.last() {
            points.pop();
        }
        if points.len() < 3 {
            let problem = format!("A contour of \"outline\" has {} different points", points.len());
            let expected = "expected three or more, as \"x y, x y, x y\"";
            let error = SceneError::at(&query.place("outline"), problem, expected);
            query.error(error.with_remedy("points are separated by commas, contours by semicolons"));
            return None;
        }
        contours.push(points);
    }
    Some(contours)
}

/// Points of some coordinates each, separated by commas. `None` where it is wrong, which is reported.
pub(super) fn points<const N: usize>(
    query: &Query<'_>,
    name: &'static str,
    text: &str,
) -> Option<Vec<[f64; N]>> {
    let mut points = Vec::new();
    for point in text.split(',').filter(|point| !point.trim().is_empty()) {
        let coordinates: Option<Vec<f64>> = point.split_whitespace().map(attributes::number).collect();
        let point_ = coordinates.and_then(|coordinates| <[f64; N]>::try_from(coordinates).ok());
        let Some(coordinates) = point_ else {
            let problem = format!("\"{}\" in \"{name}\" is not a point", point.trim());
            let expected = format!("expected {N} finite numbers, as \"{}\"", &"x y z"[..2 * N - 1]);
            let error = SceneError::at(&query.place(name), problem, expected);
            query.error(error.with_remedy("points are separated by commas, their coordinates by blanks"));
            return None;
        };
        points.push(coordinates);
    }
    Some(points)
}
