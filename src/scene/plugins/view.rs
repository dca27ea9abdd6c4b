//! How wide cameras and projectors see.

use super::fields::Choices;
use super::{Field, Parameter, Range, Simple, Takes, choice, optional};
use crate::scene::description::{FieldOfView, FovAxis};
use crate::scene::read::{Query, attributes};
use crate::scene::source::SceneError;
use crate::scene::write::{Node, Writer};

const AXIS: Simple<Choices<FovAxis>> = choice(
    "fov_axis",
    FovAxis::X,
    &[
        ("x", FovAxis::X),
        ("y", FovAxis::Y),
        ("diagonal", FovAxis::Diagonal),
        ("smaller", FovAxis::Smaller),
        ("larger", FovAxis::Larger),
    ],
    "side of the picture that `fov` goes by",
)
.in_any_case();

/// `fov`, or `focal_length`.
pub struct View;

impl Field for View {
    type Value = FieldOfView;

    fn parameters(&self) -> Vec<Parameter> {
        let range = Range { low: 0.0, with_low: false, high: 180.0, with_high: false };
        let fov = Parameter::new("fov", Takes::Float(range));
        let focal_length = Parameter::new("focal_length", Takes::Text);
        let doc = "instead of `fov`, that of a lens over a film of 36 mm × 24 mm, by its diagonal";
        [
            vec![Parameter { unit: "degrees", doc: "angle across the picture", ..fov }],
            AXIS.parameters(),
            vec![Parameter { default: "50mm".to_owned(), doc, ..focal_length }],
        ]
        .concat()
    }

    fn read(&self, query: &Query<'_>) -> Option<FieldOfView> {
        let axis = optional(AXIS).read(query)?;
        let fov = query.float("fov");
        let focal_length = query.text("focal_length");
        Some(match (fov, focal_length) {
            (Some(_), Some(_)) => {
                query.error(SceneError::at(
                    &query.place("focal_length"),
                    "The field of view is given twice",
                    "expected either fov or focal_length",
                ));
                FieldOfView::FocalLength(50.0)
            }
            (Some(angle), None) => {
                if !(angle > 0.0 && angle < 180.0) {
                    query.error(SceneError::at(
                        &query.place("fov"),
                        format!("The field of view is {angle} degrees"),
                        "expected an angle between 0 and 180 degrees",
                    ));
                }
                FieldOfView::Degrees { angle, axis: axis.unwrap_or(FovAxis::X) }
            }
            (None, focal_length) => {
                if axis.is_some() && !query.has("fov") {
                    query.error(
                        SceneError::at(
                            &query.place("fov_axis"),
                            "fov_axis says nothing without fov",
                            "expected a fov beside it",
                        )
                        .with_remedy("a focal length goes by the diagonal of a film of 36 × 24 mm"),
                    );
                }
                FieldOfView::FocalLength(focal_length.map_or(50.0, |text| millimetres(query, text)))
            }
        })
    }

    fn write(&self, node: Node, value: &FieldOfView, writer: &mut Writer) -> Node {
        match value {
            FieldOfView::Degrees { angle, axis } => AXIS.write(node.float("fov", *angle), axis, writer),
            FieldOfView::FocalLength(mm) => node.text("focal_length", format!("{mm}mm")),
        }
    }
}

/// `50`, `50mm` or `50 mm`.
fn millimetres(query: &Query<'_>, text: &str) -> f64 {
    match attributes::number(text.trim_end().trim_end_matches("mm")) {
        // Outside, not even the tangent of half the angle is a number that one can go on with.
        Some(length) if (1e-6..=1e12).contains(&length) => length,
        _ => {
            query.error(SceneError::at(
                &query.place("focal_length"),
                format!("\"{text}\" is not a focal length"),
                "expected millimetres above 0, such as 50mm",
            ));
            50.0
        }
    }
}
