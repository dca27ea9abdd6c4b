//! Sampling the solid angle that a rectangle fills
//! (Ureña, Fajardo and King, "An Area-Preserving Parametrization for Spherical Rectangles", EGSR 2013).

use crate::geometry::Vec3;
use crate::geometry::angle::{atan2, sin_cos};
use std::f64::consts::TAU;
use std::ops::Mul;

/// A parallelogram with perpendicular edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    corner: Vec3,
    /// Unit vectors along the edges.
    axes: [Vec3; 2],
    lengths: [f64; 2],
}

/// Below this solid angle (sr) the difference of angles that defines it has lost too many digits;
/// a rectangle that small is as well sampled by area.
const SMALLEST_SOLID_ANGLE: f64 = 1e-6;

/// From farther than this many diagonals away a rectangle is as well sampled by area: cos θ / r² hardly
/// changes over it, and the angles cost more than the little noise that they save.
const FAR: f64 = 2.0;

impl Rectangle {
    /// `None` where the edges aren't perpendicular (to 1e-5, as vertices may be rounded to `f32`) or vanish.
    pub fn new(corner: Vec3, edges: [Vec3; 2]) -> Option<Self> {
        let lengths = edges.map(Vec3::length);
        let x = edges[0].try_normalize()?;
        let y = edges[1].try_normalize()?;
        let skew = x.dot(y);
        let square = (y - x * skew).try_normalize()?;
        (skew.abs() < 1e-5).then_some(Self { corner, axes: [x, square], lengths })
    }

    /// The rectangle as seen from a point; `None` where it is far away, or its solid angle too small or too
    /// near to the half space's 2π to compute with.
    pub fn seen_from(&self, reference: Vec3) -> Option<SphericalRectangle> {
        let offset = self.corner - reference;
        let [x, y] = self.axes;
        let [width, height] = self.lengths;
        let centre = offset + x * (0.5 * width) + y * (0.5 * height);
        if centre.length_squared() > FAR * FAR * (width * width + height * height) {
            return None;
        }
        let normal = x.cross(y);
        let z = offset.dot(normal);
        // Seen from the other side nothing changes, so z is always negative.
        let z0 = -z.abs();
        let (x0, y0) = (offset.dot(x), offset.dot(y));
        let (x1, y1) = (x0 + self.lengths[0], y0 + self.lengths[1]);
        // Normals of the planes through the reference and the edges; z components of the unit normals.
        let unit = |side: f64| side / length(side, z0);
        let n = [unit(-y0), unit(x1), unit(y1), unit(-x0)];
        // The inner angles are acos(−n₀n₁), acos(−n₁n₂) and so on: turns that add up by being multiplied.
        let inner = |i: usize, j: usize| Turn::of_arc_cosine(-n[i] * n[j]);
        let others = inner(2, 3) * inner(3, 0);
        let solid_angle = (inner(0, 1) * inner(1, 2) * others).angle();
        let usable =
            z0 < 0.0 && solid_angle > SMALLEST_SOLID_ANGLE && solid_angle < TAU - SMALLEST_SOLID_ANGLE;
        usable.then_some(SphericalRectangle {
            solid_angle,
            k: others.back(),
            b0: n[0],
            b1: n[2],
            z0,
            x: [x0, x1],
            y: [y0, y1],
        })
    }
}

/// Like `hypot`, which guards against overflow that no scene comes near and costs as much as a ray query.
fn length(a: f64, b: f64) -> f64 {
    (a * a + b * b).sqrt()
}

/// An angle by its cosine and sine.
#[derive(Clone, Copy, Debug)]
struct Turn {
    cos: f64,
    sin: f64,
}

impl Turn {
    fn of(angle: f64) -> Self {
        let (sin, cos) = sin_cos(angle);
        Self { cos, sin }
    }

    fn of_arc_cosine(cos: f64) -> Self {
        Self { cos, sin: (1.0 - cos * cos).max(0.0).sqrt() }
    }

    /// The same turn the other way.
    fn back(self) -> Self {
        Self { sin: -self.sin, ..self }
    }

    /// Angle of the turn, from 0 to 2π.
    fn angle(self) -> f64 {
        let angle = atan2(self.sin, self.cos);
        if angle < 0.0 { angle + TAU } else { angle }
    }
}

/// Two turns one after the other.
impl Mul for Turn {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self {
            cos: self.cos * other.cos - self.sin * other.sin,
            sin: self.sin * other.cos + self.cos * other.sin,
        }
    }
}

/// A rectangle in the frame of a reference point, whose z axis is perpendicular to it.
#[derive(Clone, Copy, Debug)]
pub struct SphericalRectangle {
    solid_angle: f64,
    /// What the last two inner angles lack to a full turn.
    k: Turn,
    b0: f64,
    b1: f64,
    z0: f64,
    x: [f64; 2],
    y: [f64; 2],
}

impl SphericalRectangle {
    /// Steradians; the density of [`SphericalRectangle::sample`] is one over it.
    pub fn solid_angle(&self) -> f64 {
        self.solid_angle
    }

    /// Where on the rectangle, as fractions of its edges.
    pub fn sample(&self, u: [f64; 2]) -> [f64; 2] {
        // The part of the rectangle up to cu along x fills the fraction u[0] of the solid angle.
        let Turn { cos, sin } = Turn::of(u[0] * self.solid_angle) * self.k;
        let fu = (cos * self.b0 - self.b1) / sin;
        let cu = (1.0 / (fu * fu + self.b0 * self.b0).sqrt()).min(1.0).copysign(fu);
        let xu = (-cu * self.z0 / (1.0 - cu * cu).max(f64::MIN_POSITIVE).sqrt()).clamp(self.x[0], self.x[1]);
        // On that vertical line y / distance is uniform.
        let d = length(xu, self.z0);
        let (h0, h1) = (self.y[0] / length(d, self.y[0]), self.y[1] / length(d, self.y[1]));
        let hv = h0 + u[1] * (h1 - h0);
        let yv = (hv * d / (1.0 - hv * hv).max(f64::MIN_POSITIVE).sqrt()).clamp(self.y[0], self.y[1]);
        let along = |value: f64, [low, high]: [f64; 2]| ((value - low) / (high - low)).clamp(0.0, 1.0);
        [along(xu, self.x), along(yv, self.y)]
    }
}
