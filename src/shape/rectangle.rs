//! Sampling the solid angle that a rectangle fills
//! (Ureña, Fajardo and King, "An Area-Preserving Parametrization for Spherical Rectangles", EGSR 2013).

use crate::geometry::Vec3;
use crate::geometry::angle::{atan2, sin_cos};
use crate::lanes::{Mask, Real, Register, Truth, Vec3Lanes, Vector};
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
    pub fn seen_from(&self, reference: Vec3) -> Option<SphericalRectangle<f64>> {
        let reference = Vector::<f64>::of(reference);
        if !self.is_near(reference) {
            return None;
        }
        let (seen, usable) = self.project(reference);
        usable.then_some(seen)
    }

    /// The same from several points, and for which of them it holds. `None` where the rectangle is far from
    /// all the lanes that are wanted.
    #[inline(always)]
    pub fn seen_in_lanes(
        &self,
        reference: Vec3Lanes,
        wanted: Mask,
    ) -> Option<(SphericalRectangle<Register>, Truth)> {
        let near = self.is_near(reference);
        if near.mask() & wanted == 0 {
            return None;
        }
        let (seen, usable) = self.project(reference);
        Some((seen, near & usable))
    }

    /// Whether it is so near that its solid angle pays.
    #[inline(always)]
    pub fn is_near<R: Real>(&self, reference: Vector<R>) -> R::Truth {
        let ([x, y], [width, height]) = (self.axes, self.lengths);
        let centre = Vector::of(self.corner + x * (0.5 * width) + y * (0.5 * height)) - reference;
        centre.length_squared().le(R::of(FAR * FAR * (width * width + height * height)))
    }

    /// The rectangle as seen from a point, and whether its solid angle can be computed with.
    #[inline(always)]
    pub fn project<R: Real>(&self, reference: Vector<R>) -> (SphericalRectangle<R>, R::Truth) {
        let offset = Vector::of(self.corner) - reference;
        let [x, y] = self.axes.map(Vector::of);
        let normal = Vector::of(self.axes[0].cross(self.axes[1]));
        let z = offset.dot(normal);
        // Seen from the other side nothing changes, so z is always negative.
        let z0 = -z.abs();
        let (x0, y0) = (offset.dot(x), offset.dot(y));
        let (x1, y1) = (x0 + R::of(self.lengths[0]), y0 + R::of(self.lengths[1]));
        // Normals of the planes through the reference and the edges; z components of the unit normals.
        let unit = |side: R| side / length(side, z0);
        let n = [unit(-y0), unit(x1), unit(y1), unit(-x0)];
        // The inner angles are acos(−n₀n₁), acos(−n₁n₂) and so on: turns that add up by being multiplied.
        let inner = |i: usize, j: usize| Turn::of_arc_cosine(-n[i] * n[j]);
        let others = inner(2, 3) * inner(3, 0);
        let solid_angle = (inner(0, 1) * inner(1, 2) * others).angle();
        let usable = z0.lt(R::of(0.0))
            & solid_angle.gt(R::of(SMALLEST_SOLID_ANGLE))
            & solid_angle.lt(R::of(TAU - SMALLEST_SOLID_ANGLE));
        let seen = SphericalRectangle {
            solid_angle,
            k: others.back(),
            b0: n[0],
            b1: n[2],
            z0,
            x: [x0, x1],
            y: [y0, y1],
        };
        (seen, usable)
    }
}

/// Like `hypot`, which guards against overflow that no scene comes near and costs as much as a ray query.
#[inline(always)]
fn length<R: Real>(a: R, b: R) -> R {
    (a * a + b * b).sqrt()
}

/// An angle by its cosine and sine.
#[derive(Clone, Copy, Debug)]
struct Turn<R> {
    cos: R,
    sin: R,
}

impl<R: Real> Turn<R> {
    #[inline(always)]
    fn of(angle: R) -> Self {
        let (sin, cos) = sin_cos(angle);
        Self { cos, sin }
    }

    #[inline(always)]
    fn of_arc_cosine(cos: R) -> Self {
        Self { cos, sin: (R::of(1.0) - cos * cos).greater(R::of(0.0)).sqrt() }
    }

    /// The same turn the other way.
    #[inline(always)]
    fn back(self) -> Self {
        Self { sin: -self.sin, ..self }
    }

    /// Angle of the turn, from 0 to 2π.
    #[inline(always)]
    fn angle(self) -> R {
        let angle = atan2(self.sin, self.cos);
        R::choose(angle.lt(R::of(0.0)), angle + R::of(TAU), angle)
    }
}

/// Two turns one after the other.
impl<R: Real> Mul for Turn<R> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self {
            cos: self.cos * other.cos - self.sin * other.sin,
            sin: self.sin * other.cos + self.cos * other.sin,
        }
    }
}

/// A rectangle in the frame of a reference point, whose z axis is perpendicular to it.
#[derive(Clone, Copy, Debug)]
pub struct SphericalRectangle<R> {
    solid_angle: R,
    /// What the last two inner angles lack to a full turn.
    k: Turn<R>,
    b0: R,
    b1: R,
    z0: R,
    x: [R; 2],
    y: [R; 2],
}

impl<R: Real> SphericalRectangle<R> {
    /// Steradians; the density of [`SphericalRectangle::sample`] is one over it.
    #[inline(always)]
    pub fn solid_angle(&self) -> R {
        self.solid_angle
    }

    /// Where on the rectangle, as fractions of its edges.
    #[inline(always)]
    pub fn sample(&self, u: [R; 2]) -> [R; 2] {
        let (one, least) = (R::of(1.0), R::of(f64::MIN_POSITIVE));
        let clamp = |value: R, [low, high]: [R; 2]| value.greater(low).lesser(high);
        // The part of the rectangle up to cu along x fills the fraction u[0] of the solid angle.
        let Turn { cos, sin } = Turn::of(u[0] * self.solid_angle) * self.k;
        let fu = (cos * self.b0 - self.b1) / sin;
        let cu = (one / (fu * fu + self.b0 * self.b0).sqrt()).lesser(one).copysign(fu);
        let xu = clamp(-cu * self.z0 / (one - cu * cu).greater(least).sqrt(), self.x);
        // On that vertical line y / distance is uniform.
        let d = length(xu, self.z0);
        let (h0, h1) = (self.y[0] / length(d, self.y[0]), self.y[1] / length(d, self.y[1]));
        let hv = h0 + u[1] * (h1 - h0);
        let yv = clamp(hv * d / (one - hv * hv).greater(least).sqrt(), self.y);
        let along = |value: R, [low, high]: [R; 2]| clamp((value - low) / (high - low), [R::of(0.0), one]);
        [along(xu, self.x), along(yv, self.y)]
    }
}
