//! `<transform>`: children in the order written, the first nearest to the object.

use super::super::description::Note;
use super::super::source::{Place, SceneError};
use super::attributes::{self, Attributes, Defaults, GREATEST, start_tag};
use super::hints;
use crate::geometry::{Frame, Vec3};
use glam::{DMat3, DMat4, DVec4};
use roxmltree::Node;

const ELEMENTS: [&str; 5] = ["translate", "rotate", "scale", "lookat", "matrix"];

/// Where the pieces of a transform are read from and what is said about them.
pub(super) struct Context<'a> {
    pub file: usize,
    pub defaults: &'a mut Defaults,
    pub errors: &'a mut Vec<SceneError>,
    pub assumptions: &'a mut Vec<Note>,
}

impl Context<'_> {
    /// The map that the children of `node` describe together; `None` where one of them is wrong.
    pub fn read(&mut self, node: Node<'_, '_>) -> Option<DMat4> {
        let before = self.errors.len();
        let mut matrix = DMat4::IDENTITY;
        for child in node.children().filter(Node::is_element) {
            if let Some(next) = self.step(child) {
                matrix = next * matrix;
            }
        }
        let most = matrix.to_cols_array().iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        if !(matrix.is_finite() && most <= GREATEST) && self.errors.len() == before {
            self.errors.push(SceneError::at(
                &start_tag(node, self.file),
                "The transform is too large for numbers",
                "its parts multiply to more than 3.4e38",
            ));
        }
        (self.errors.len() == before).then_some(matrix)
    }

    fn step(&mut self, node: Node<'_, '_>) -> Option<DMat4> {
        let place = start_tag(node, self.file);
        let result = match node.tag_name().name() {
            "translate" => {
                let a = self.attributes(node, &[], &["x", "y", "z", "value"])?;
                attributes::vector(&a, &place, Some(0.0)).map(DMat4::from_translation)
            }
            "scale" => {
                let a = self.attributes(node, &[], &["x", "y", "z", "value"])?;
                attributes::vector(&a, &place, Some(1.0)).map(DMat4::from_scale)
            }
            "rotate" => {
                let a = self.attributes(node, &["angle"], &["x", "y", "z", "value"])?;
                let angle = a.get("angle").map(attributes::float)?;
                attributes::vector(&a, &place, Some(0.0)).and_then(|axis| self.rotation(axis, angle?, &place))
            }
            "lookat" => {
                let a = self.attributes(node, &["origin", "target"], &["up"])?;
                let [origin, target, up] =
                    ["origin", "target", "up"].map(|name| a.get(name).map(|a| attributes::triple(a, false)));
                match (origin?, target?, up.transpose()) {
                    (Ok(origin), Ok(target), Ok(up)) => look_at(origin, target, up, &place),
                    (Err(error), ..) | (_, Err(error), _) | (.., Err(error)) => Err(error),
                }
            }
            "matrix" => {
                let a = self.attributes(node, &["value"], &[])?;
                matrix(a.get("value")?)
            }
            other => {
                let error = SceneError::at(
                    &place,
                    format!("<{other}> is not part of a transform"),
                    format!("expected {}", hints::either(&ELEMENTS)),
                );
                Err(match hints::nearest(other, &ELEMENTS) {
                    Some(near) => error.with_remedy(format!("did you mean <{near}>?")),
                    None => error,
                })
            }
        };
        result.map_err(|error| self.errors.push(error)).ok()
    }

    fn attributes(&mut self, node: Node<'_, '_>, required: &[&str], optional: &[&str]) -> Option<Attributes> {
        Attributes::read(node, self.file, required, optional, self.defaults, self.errors)
    }

    fn rotation(&mut self, axis: Vec3, degrees: f64, place: &Place) -> Result<DMat4, SceneError> {
        if axis == Vec3::ZERO {
            // Exporters write a rotation that turns nothing so.
            if degrees == 0.0 {
                return Ok(DMat4::IDENTITY);
            }
            return Err(SceneError::at(
                place,
                "A rotation about no axis",
                "expected an axis, for instance y=\"1\"",
            ));
        }
        if (axis.length() - 1.0).abs() > 1e-6 {
            let text = format!(
                "the rotation axis has length {:.6}: it is used as it is, as Mitsuba 3 does, and so also stretches and \
                 shears; write an axis of length 1",
                axis.length()
            );
            self.assumptions.push(Note::new(place, text));
        }
        Ok(rotation(axis, degrees))
    }
}

/// Rodrigues' formula with the axis as given, not normalised: that is what Mitsuba 3 does.
fn rotation(axis: Vec3, degrees: f64) -> DMat4 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let cross = DMat3::from_cols(
        Vec3::new(0.0, axis.z, -axis.y),
        Vec3::new(-axis.z, 0.0, axis.x),
        Vec3::new(axis.y, -axis.x, 0.0),
    );
    let outer = DMat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z);
    DMat4::from_mat3(DMat3::IDENTITY * cos + cross * sin + outer * (1.0 - cos))
}

/// Local +z looks from `origin` to `target`, local +y is as near to `up` as it can be, local +x is `up` ×
/// view. Without `up`, +y is what Mitsuba 3 takes, which follows Duff et al. too.
fn look_at(origin: Vec3, target: Vec3, up: Option<Vec3>, place: &Place) -> Result<DMat4, SceneError> {
    let forward = (target - origin).try_normalize();
    let up = up.unwrap_or_else(|| forward.map_or(Vec3::Y, |forward| Frame::around(forward).x));
    let left = forward.and_then(|forward| up.normalize_or_zero().cross(forward).try_normalize());
    let (Some(forward), Some(left)) = (forward, left) else {
        let problem = if forward.is_none() {
            "The camera looks nowhere: origin and target are the same"
        } else {
            "The up vector is parallel to the direction of view"
        };
        return Err(SceneError::at(
            place,
            problem,
            "expected origin, target and an up vector across the view",
        ));
    };
    let up = forward.cross(left);
    Ok(DMat4::from_cols(left.extend(0.0), up.extend(0.0), forward.extend(0.0), origin.extend(1.0)))
}

/// 16 numbers row by row, or 9 of a linear map.
fn matrix(attribute: &attributes::Attribute) -> Result<DMat4, SceneError> {
    let found = attributes::numbers(attribute)?;
    if let Ok(rows) = <[f64; 16]>::try_from(found.as_slice()) {
        let matrix = DMat4::from_cols_array(&rows).transpose();
        if matrix.row(3) != DVec4::W {
            return Err(SceneError::at(
                &attribute.place,
                "The matrix is not affine",
                "expected 0 0 0 1 in its last row",
            )
            .with_remedy("write the matrix row by row, with the translation in the last column"));
        }
        return Ok(matrix);
    }
    match <[f64; 9]>::try_from(found.as_slice()) {
        Ok(rows) => Ok(DMat4::from_mat3(DMat3::from_cols_array(&rows).transpose())),
        Err(_) => Err(SceneError::at(
            &attribute.place,
            format!("A matrix has 16 or 9 numbers, not {}", found.len()),
            "expected 16 numbers row by row, or 9 for a map without translation",
        )),
    }
}
