//! Profiles and implicit surfaces, which Mitsuba 3 does not have.

use crate::geometry::Transform;
use crate::scene::description::ShapeKind;
use crate::scene::plugins::fields::{Choices, Kind};
use crate::scene::plugins::{Field, Parameter, Simple, Takes, choice};
use crate::scene::read::{Query, attributes, spectra};
use crate::scene::source::SceneError;
use crate::scene::write::{Node, Value, Writer};
use crate::shape::{
    Blob, FillRule, Interpolation, Kernel, ProfileOrImplicit, ProfileOrImplicitKind, ShapeError,
};

pub const RULE: Simple<Choices<FillRule>> = choice(
    "rule",
    FillRule::EvenOdd,
    &[("evenodd", FillRule::EvenOdd), ("winding", FillRule::Winding)],
    "what is inside: what an odd number of contours goes around, or what has a winding number other than 0",
);

pub const INTERPOLATION: Simple<Choices<Interpolation>> = choice(
    "interpolation",
    Interpolation::Linear,
    &[
        ("linear", Interpolation::Linear),
        ("bezier", Interpolation::Bezier),
        ("bspline", Interpolation::BSpline),
    ],
    "the curve that the points make; of Bézier cubics each third point lies on the curve",
);

pub const KERNEL: Simple<Choices<Kernel>> = choice(
    "kernel",
    Kernel::Soft,
    &[("gaussian", Kernel::Gaussian), ("metaball", Kernel::Metaball), ("soft", Kernel::Soft)],
    "how the density of a ball falls",
);

/// Contours of points: "x y, x y, …; …".
pub struct Contours;

impl Kind for Contours {
    type Value = Vec<Vec<[f64; 2]>>;

    fn takes(&self) -> Takes {
        Takes::Points(2)
    }

    fn read(&self, query: &Query<'_>, name: &'static str) -> Option<Self::Value> {
        contours(query, name)
    }

    fn value(&self, contours: &Self::Value) -> Value {
        Value::Text(contours.iter().map(|contour| text_of(contour)).collect::<Vec<_>>().join("; "))
    }
}

pub const OUTLINE: Simple<Contours> = Simple::new(
    "outline",
    None,
    Contours,
    "points of the contours: \"x y, x y, …; x y, …\", contours apart by semicolons",
);

/// Points: "r z, r z, …".
pub struct Profile;

impl Kind for Profile {
    type Value = Vec<[f64; 2]>;

    fn takes(&self) -> Takes {
        Takes::Points(2)
    }

    fn read(&self, query: &Query<'_>, name: &'static str) -> Option<Self::Value> {
        points(query, name, query.text(name)?)
    }

    fn value(&self, points: &Self::Value) -> Value {
        Value::Text(text_of(points))
    }
}

pub const PROFILE: Simple<Profile> =
    Simple::new("profile", None, Profile, "points of the profile, \"r z, r z, …\", r from the axis");

/// As a file has them: the shortest numbers that read back as the same.
pub fn text_of<const N: usize>(points: &[[f64; N]]) -> String {
    let point = |point: &[f64; N]| point.map(|coordinate| coordinate.to_string()).join(" ");
    points.iter().map(point).collect::<Vec<_>>().join(", ")
}

/// Balls with their centres, radii and strengths.
pub struct Balls;

impl Field for Balls {
    type Value = Vec<Blob>;

    fn parameters(&self) -> Vec<Parameter> {
        let list = |name, default: &str, doc| Parameter {
            default: default.to_owned(),
            doc,
            ..Parameter::new(name, Takes::Numbers)
        };
        let centres = Parameter::new("centers", Takes::Points(3));
        vec![
            Parameter { is_required: true, doc: "centres, \"x y z, x y z, …\"", ..centres },
            list("radii", "1", "one radius for all, or one for each"),
            list("strengths", "1", "one strength for all, or one for each; it may be negative"),
        ]
    }

    fn read(&self, query: &Query<'_>) -> Option<Vec<Blob>> {
        let (radii, strengths) = (query.has("radii"), query.has("strengths"));
        let radii = if radii { spectra::numbers(query, "radii") } else { Some(vec![1.0]) };
        let strengths = if strengths { spectra::numbers(query, "strengths") } else { Some(vec![1.0]) };
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
        Some(centres.into_iter().zip(radii).zip(strengths).map(blob).collect())
    }

    fn write(&self, node: Node, blobs: &Vec<Blob>, _: &mut Writer) -> Node {
        let all = |number: fn(&Blob) -> f64| blobs.iter().map(number).collect::<Vec<f64>>();
        let centres: Vec<[f64; 3]> = blobs.iter().map(|blob| blob.centre.to_array()).collect();
        node.text("centers", text_of(&centres))
            .numbers("radii", &all(|blob| blob.radius))
            .numbers("strengths", &all(|blob| blob.strength))
    }
}

/// Refuses what is no surface.
pub fn solid(query: &Query<'_>, shape: ShapeKind) -> Option<ShapeKind> {
    let ShapeKind::ProfileOrImplicit(kind) = &shape else { return Some(shape) };
    if let ProfileOrImplicitKind::Extrusion { heights: [low, high], .. } = kind
        && low >= high
    {
        let problem = format!("The {} reaches from {low} to {high}", query.object.plugin);
        query.error(SceneError::at(&query.place("zmax"), problem, "expected zmin below zmax"));
        return None;
    }
    // Whether there is a surface is not to be seen from single numbers.
    if let Err(error) = ProfileOrImplicit::new(&Transform::IDENTITY, kind, false) {
        let problem = format!("The {} cannot be made: {error}", query.object.plugin);
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
    Some(shape)
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

/// Points "x y" separated by commas, contours by semicolons. `None` where it is wrong, which is reported.
fn contours(query: &Query<'_>, name: &'static str) -> Option<Vec<Vec<[f64; 2]>>> {
    let text = query.text(name)?;
    let mut contours = Vec::new();
    for contour in text.split(';').filter(|contour| !contour.trim().is_empty()) {
        let mut points = points::<2>(query, name, contour)?;
        // A contour that says that it is closed.
        if points.len() > 1 && points.first() == points.last() {
            points.pop();
        }
        if points.len() < 3 {
            let problem = format!("A contour of \"{name}\" has {} different points", points.len());
            let expected = "expected three or more, as \"x y, x y, x y\"";
            let error = SceneError::at(&query.place(name), problem, expected);
            query.error(error.with_remedy("points are separated by commas, contours by semicolons"));
            return None;
        }
        contours.push(points);
    }
    Some(contours)
}

/// Points of some coordinates each, separated by commas. `None` where it is wrong, which is reported.
pub fn points<const N: usize>(query: &Query<'_>, name: &'static str, text: &str) -> Option<Vec<[f64; N]>> {
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
