//! Curves in the half-plane of r ≥ 0 and z: straight lines, Bézier curves and B-splines, in pieces along
//! which neither r nor z turns back and neither derivative does.

use crate::geometry::roots::{Sample, polynomial_within, sign_changes};
use crate::shape::ShapeError;
use glam::DVec2;
use smallvec::SmallVec;

/// How a profile follows its points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Straight from one to the next.
    Linear,
    /// Cubic Bézier curves: each third point is on the curve.
    Bezier,
    /// A uniform cubic B-spline, which begins and ends near the second point and the last but one.
    BSpline,
}

/// A monotonic piece of a cubic.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    /// (r, z) in ascending powers of a parameter.
    coefficients: [DVec2; 4],
    /// Range of the parameter.
    pub range: [f64; 2],
    /// (r, z) at both ends, exactly those of the neighbours.
    pub ends: [DVec2; 2],
    /// Along the whole profile, from 0 to 1; `None` for a cap.
    pub along: Option<[f64; 2]>,
}

impl Piece {
    pub fn at(&self, s: f64) -> DVec2 {
        if s == self.range[0] {
            return self.ends[0];
        }
        if s == self.range[1] {
            return self.ends[1];
        }
        let [a, b, c, d] = self.coefficients;
        (((d * s) + c) * s + b) * s + a
    }

    pub fn slope(&self, s: f64) -> DVec2 {
        let [_, b, c, d] = self.coefficients;
        ((3.0 * d * s) + 2.0 * c) * s + b
    }

    pub fn bend(&self, s: f64) -> DVec2 {
        let [_, _, c, d] = self.coefficients;
        6.0 * d * s + 2.0 * c
    }

    /// Along the curve; where that stands still, from one end to the other.
    pub fn tangent(&self, s: f64) -> DVec2 {
        let slope = self.slope(s);
        let chord = self.ends[1] - self.ends[0];
        if slope.length() > 1e-12 * chord.length() / (self.range[1] - self.range[0]) {
            slope.normalize()
        } else {
            chord.normalize()
        }
    }

    /// Where r has a value between those of the ends.
    pub fn at_radius(&self, radius: f64) -> f64 {
        let function = |s: f64| Sample {
            value: self.at(s).x - radius,
            slope: self.slope(s).x,
            error: 4.0 * f64::EPSILON,
        };
        let middle = 0.5 * (self.range[0] + self.range[1]);
        sign_changes(&self.range, function).first().map_or(middle, |root| root.t)
    }

    /// The parameter of the point nearest to one that is almost on the curve.
    pub fn nearest(&self, point: DVec2) -> f64 {
        let size = (self.ends[1] - self.ends[0]).abs();
        let axis = if size.x > size.y { 0 } else { 1 };
        let wanted = point[axis]
            .clamp(self.ends[0][axis].min(self.ends[1][axis]), self.ends[0][axis].max(self.ends[1][axis]));
        let function = |s: f64| Sample {
            value: self.at(s)[axis] - wanted,
            slope: self.slope(s)[axis],
            error: 4.0 * f64::EPSILON,
        };
        let ends = self.range.map(|s| function(s).value);
        let mut s = if ends[0] == 0.0 {
            self.range[0]
        } else if ends[1] == 0.0 {
            self.range[1]
        } else {
            sign_changes(&self.range, function).first().map_or(self.range[0], |root| root.t)
        };
        for _ in 0..2 {
            let slope = self.slope(s);
            let step = (point - self.at(s)).dot(slope) / slope.length_squared();
            if step.is_finite() {
                s = (s + step).clamp(self.range[0], self.range[1]);
            }
        }
        s
    }

    /// The largest direction · (r, z).
    pub fn reach(&self, direction: DVec2) -> f64 {
        let [_, b, c, d] = self.coefficients.map(|coefficient| coefficient.dot(direction));
        let turning = polynomial_within(&[b, 2.0 * c, 3.0 * d], self.range);
        let inner = turning.iter().map(|root| self.at(root.t).dot(direction));
        inner.chain(self.ends.map(|end| end.dot(direction))).fold(f64::NEG_INFINITY, f64::max)
    }

    fn straight(from: DVec2, to: DVec2, along: Option<[f64; 2]>) -> Self {
        let coefficients = [from, to - from, DVec2::ZERO, DVec2::ZERO];
        Self { coefficients, range: [0.0, 1.0], ends: [from, to], along }
    }
}

/// The pieces of a curve through or near points (r, z), in order. `closed`: from its end back to its
/// beginning, as one more line, or as a B-spline without ends; a Bézier curve then comes back to its first
/// point.
pub(super) fn pieces(
    points: &[[f64; 2]],
    interpolation: Interpolation,
    closed: bool,
) -> Result<Vec<Piece>, ShapeError> {
    let points: Vec<DVec2> = points.iter().map(|&point| DVec2::from(point)).collect();
    let count = points.len();
    if points.iter().any(|point| !point.is_finite()) {
        return Err(ShapeError::Profile);
    }
    let point = |i: usize| points[i % count];
    let mut cubics: Vec<[DVec2; 4]> = Vec::new();
    match interpolation {
        Interpolation::Linear => {
            let lines = if closed { count } else { count.saturating_sub(1) };
            let line = |i: usize| (point(i), point(i + 1));
            let lines: Vec<_> = (0..lines).map(line).filter(|(from, to)| from != to).collect();
            let total = lines.len() as f64;
            let pieces = lines.iter().enumerate().map(|(i, &(from, to))| {
                Piece::straight(from, to, Some([i as f64 / total, (i + 1) as f64 / total]))
            });
            return checked(pieces.collect());
        }
        Interpolation::Bezier => {
            let used = if closed { count } else { count.saturating_sub(1) };
            if used % 3 != 0 {
                return Err(ShapeError::Profile);
            }
            cubics.extend((0..used / 3).map(|i| [0, 1, 2, 3].map(|k| point(3 * i + k))));
        }
        Interpolation::BSpline => {
            let used = if closed && count >= 3 { count } else { count.saturating_sub(3) };
            let joint = |i: usize| (point(i) + 4.0 * point(i + 1) + point(i + 2)) / 6.0;
            cubics.extend((0..used).map(|i| {
                let (b, c) = (point(i + 1), point(i + 2));
                [joint(i), (2.0 * b + c) / 3.0, (b + 2.0 * c) / 3.0, joint(i + 1)]
            }));
        }
    }
    let mut pieces = Vec::new();
    let total = cubics.len() as f64;
    for (i, [p, q, r, s]) in cubics.into_iter().enumerate() {
        let coefficients = [p, 3.0 * (q - p), 3.0 * (p - 2.0 * q + r), s - p + 3.0 * (q - r)];
        let [_, b, c, d] = coefficients;
        let mut cuts: SmallVec<[f64; 8]> = SmallVec::from_slice(&[0.0, 1.0]);
        for axis in 0..2 {
            let turning = [b[axis], 2.0 * c[axis], 3.0 * d[axis]];
            cuts.extend(polynomial_within(&turning, [0.0, 1.0]).iter().map(|root| root.t));
            cuts.extend(polynomial_within(&[c[axis], 3.0 * d[axis]], [0.0, 1.0]).iter().map(|root| root.t));
        }
        cuts.sort_by(f64::total_cmp);
        cuts.dedup();
        let whole = Piece { coefficients, range: [0.0, 1.0], ends: [p, s], along: None };
        for pair in cuts.windows(2) {
            let ends = [whole.at(pair[0]), whole.at(pair[1])];
            if ends[0] == ends[1] {
                continue;
            }
            let along = [pair[0], pair[1]].map(|s| (i as f64 + s) / total);
            pieces.push(Piece { range: [pair[0], pair[1]], ends, along: Some(along), ..whole.clone() });
        }
    }
    checked(pieces)
}

/// Nothing is nearer to the axis than the axis itself; what lies on it is no surface.
fn checked(mut pieces: Vec<Piece>) -> Result<Vec<Piece>, ShapeError> {
    if pieces.is_empty() || pieces.iter().flat_map(|piece| piece.ends).any(|end| end.x < 0.0) {
        return Err(ShapeError::Profile);
    }
    pieces.retain(|piece| piece.ends[0].x > 0.0 || piece.ends[1].x > 0.0);
    if pieces.is_empty() { Err(ShapeError::Profile) } else { Ok(pieces) }
}

/// Piece from the axis to an end of the profile.
pub(super) fn cap(from: DVec2, to: DVec2) -> Piece {
    Piece::straight(from, to, None)
}

pub(super) fn scaled(pieces: &mut [Piece], factor: f64) {
    for piece in pieces {
        piece.coefficients = piece.coefficients.map(|coefficient| coefficient * factor);
        piece.ends = piece.ends.map(|end| end * factor);
    }
}
