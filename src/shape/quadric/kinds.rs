//! Quadrics by their names, around the axis from one point to another or around z.

use super::{QuadraticForm, Quadric};
use crate::geometry::{Bounds, Frame, Transform, Vec3};
use crate::shape::ShapeError;
use glam::DMat4;

/// How many sheets a hyperboloid has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sheets {
    /// A single sheet, which narrows to a waist.
    One,
    /// Two sheets, apart from each other.
    Two,
}

/// Which quadric, in its own coordinates.
#[derive(Clone, Debug, PartialEq)]
pub enum QuadricKind {
    /// A radius that changes steadily from `radii[0]` at `from` to `radii[1]` at `to`: a cone, a part of one,
    /// or a cylinder.
    Cone {
        /// One end of the axis.
        from: Vec3,
        /// The other end.
        to: Vec3,
        /// Radius at either end, at least 0.
        radii: [f64; 2],
    },
    /// The tip is `from`; around `to` there is a rim of the given radius.
    Paraboloid {
        /// The tip.
        from: Vec3,
        /// Middle of the rim.
        to: Vec3,
        /// Radius of the rim. Above 0.
        radius: f64,
    },
    /// x² + y² = radius² (z²/semi_axis² ± 1), from one z to another.
    Hyperboloid {
        /// One sheet or two.
        sheets: Sheets,
        /// Radius of the waist of a single sheet; above 0.
        radius: f64,
        /// Half the distance between the tips of two sheets; above 0.
        semi_axis: f64,
        /// Where it is cut off: least and greatest z.
        heights: [f64; 2],
    },
    /// A x² + B y² + C z² + D xy + E xz + F yz + G x + H y + I z + J = 0 within a box, which may be infinite.
    General {
        /// Coefficients of the polynomial.
        coefficients: [f64; 10],
        /// The box beyond which there is nothing.
        clip: Bounds,
    },
}

impl Quadric {
    /// See [`Quadric::new`].
    pub fn of_kind(
        to_world: &Transform,
        kind: &QuadricKind,
        solid: bool,
        flip_normals: bool,
    ) -> Result<Self, ShapeError> {
        let between = |low: f64, high: f64| Bounds {
            min: Vec3::NEG_INFINITY.with_z(low),
            max: Vec3::INFINITY.with_z(high),
        };
        let make = |to_world: &Transform, form: &QuadraticForm, clip: Bounds| {
            Self::new(to_world, form, clip, solid, flip_normals)
        };
        match *kind {
            QuadricKind::Cone { from, to, radii } => {
                if let Some(&radius) = radii.iter().find(|radius| !(**radius >= 0.0 && radius.is_finite())) {
                    return Err(ShapeError::Radius(radius));
                }
                if radii == [0.0; 2] {
                    return Err(ShapeError::Radius(0.0));
                }
                let length = length(from, to)?;
                // From the narrower end all terms of the radius have one sign, and the tip of a cone is the
                // origin.
                let (origin, narrow, slope, heights) = if radii[0] <= radii[1] {
                    (from, radii[0], (radii[1] - radii[0]) / length, [0.0, length])
                } else {
                    (to, radii[1], (radii[1] - radii[0]) / length, [-length, 0.0])
                };
                let form = QuadraticForm::revolution(slope * slope, slope * narrow, narrow * narrow);
                let [low, high] = heights;
                make(&axis_at(origin, from, to)?.then(to_world), &form, between(low, high))
            }
            QuadricKind::Paraboloid { from, to, radius } => {
                if !(radius > 0.0 && radius.is_finite()) {
                    return Err(ShapeError::Radius(radius));
                }
                let length = length(from, to)?;
                let form = QuadraticForm::revolution(0.0, 0.5 * radius * radius / length, 0.0);
                make(&axis_at(from, from, to)?.then(to_world), &form, between(0.0, length))
            }
            QuadricKind::Hyperboloid { sheets, radius, semi_axis, heights: [low, high] } => {
                if let Some(&size) =
                    [radius, semi_axis].iter().find(|size| !(**size > 0.0 && size.is_finite()))
                {
                    return Err(ShapeError::Radius(size));
                }
                let slope = radius / semi_axis;
                let waist = if sheets == Sheets::One { radius * radius } else { -radius * radius };
                make(to_world, &QuadraticForm::revolution(slope * slope, 0.0, waist), between(low, high))
            }
            QuadricKind::General { coefficients, clip } => {
                make(to_world, &QuadraticForm::new(coefficients), clip)
            }
        }
    }
}

fn length(from: Vec3, to: Vec3) -> Result<f64, ShapeError> {
    let length = (to - from).length();
    if length > 0.0 && length.is_finite() && from.is_finite() { Ok(length) } else { Err(ShapeError::Ends) }
}

/// z along the axis from one point to another, seen from `origin`.
fn axis_at(origin: Vec3, from: Vec3, to: Vec3) -> Result<Transform, ShapeError> {
    let Frame { x, y, z } = Frame::around((to - from) / length(from, to)?);
    let matrix = DMat4::from_cols(x.extend(0.0), y.extend(0.0), z.extend(0.0), origin.extend(1.0));
    Transform::new(matrix).ok_or(ShapeError::Placement)
}
