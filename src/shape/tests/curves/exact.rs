//! Where lines cross what curves make: polynomials along the path in numbers of 32 digits.

use super::Made;
use crate::geometry::{Ray, Transform, Vec3};
use crate::shape::tests::doubled::{Doubled, Polynomial};
use crate::shape::{ControlPoint, CurveKind};
use std::f64::consts::PI;

fn constant(value: Doubled) -> Polynomial {
    Polynomial(vec![value])
}

fn scaled(p: &Polynomial, factor: Doubled) -> Polynomial {
    Polynomial(p.0.iter().map(|&c| c * factor).collect())
}

/// x, y, z and radius of a segment as polynomials of u from 0 to 1.
pub fn segment(kind: CurveKind, points: &[ControlPoint]) -> [Polynomial; 4] {
    let rows = |basis: &[&[f64]], unit: f64| {
        [0, 1, 2, 3].map(|axis| {
            let mut sum = constant(0.0.into());
            for (weights, point) in basis.iter().zip(points) {
                let value = if axis < 3 { point.position[axis] } else { point.radius };
                let weights = Polynomial(weights.iter().map(|&w| Doubled::from(w) / unit.into()).collect());
                sum = &sum + &scaled(&weights, value.into());
            }
            sum
        })
    };
    match kind {
        CurveKind::Linear => rows(&[&[1.0, -1.0], &[0.0, 1.0]], 1.0),
        CurveKind::BSpline => rows(
            &[&[1.0, -3.0, 3.0, -1.0], &[4.0, 0.0, -6.0, 3.0], &[1.0, 3.0, 3.0, -3.0], &[0.0, 0.0, 0.0, 1.0]],
            6.0,
        ),
    }
}

/// A line in the coordinates of the control points, from a place near them, of any speed.
struct Line {
    start: [Doubled; 3],
    direction: [Doubled; 3],
    /// The ray's t of `start`.
    at: f64,
}

impl Line {
    /// With `to_world` undone, by Cramer's rule.
    fn new(ray: &Ray, to_world: &Transform) -> Self {
        let m = to_world.matrix();
        let [a, b, c] = [m.x_axis, m.y_axis, m.z_axis].map(|c| [c.x, c.y, c.z].map(Doubled::from));
        let determinant = |a: [Doubled; 3], b: [Doubled; 3], c: [Doubled; 3]| {
            a[0] * (b[1] * c[2] - b[2] * c[1]) - b[0] * (a[1] * c[2] - a[2] * c[1])
                + c[0] * (a[1] * b[2] - a[2] * b[1])
        };
        let volume = determinant(a, b, c);
        let local = |v: [Doubled; 3]| {
            [determinant(v, b, c), determinant(a, v, c), determinant(a, b, v)].map(|d| d / volume)
        };
        let at = -ray.origin.dot(ray.direction);
        let direction = local([0, 1, 2].map(|i| ray.direction[i].into()));
        let origin = [0, 1, 2].map(|i| {
            Doubled::from(ray.origin[i]) - Doubled::from(m.w_axis[i])
                + Doubled::from(ray.direction[i]) * at.into()
        });
        Self { start: local(origin), direction, at }
    }
}

fn dot(a: &[Polynomial; 3], b: &[Polynomial; 3]) -> Polynomial {
    &(&(&a[0] * &b[0]) + &(&a[1] * &b[1])) + &(&a[2] * &b[2])
}

fn value(p: &[Polynomial; 3], u: Doubled) -> [Doubled; 3] {
    [p[0].at(u), p[1].at(u), p[2].at(u)]
}

fn inner(a: [Doubled; 3], b: [Doubled; 3]) -> Doubled {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// A segment as seen along a line.
struct SplineAlongLine {
    /// Centre relative to the line's start, over the line and along it; times the line's speed.
    away: [Polynomial; 3],
    along: Polynomial,
    /// r² less the squared distance of the centre from the line, times the line's speed squared; its root is
    /// half of what of the line is within the ball.
    depth: Polynomial,
    /// Half the derivative of that squared distance, and of r².
    across: Polynomial,
    growth: Polynomial,
    radius: Polynomial,
    direction: [Doubled; 3],
    squared_speed: Doubled,
}

/// A crossing: t from the line's start on, and where on the path.
#[derive(Clone, Copy, Debug)]
pub struct Exact {
    pub t: Doubled,
    pub enters: bool,
}

impl SplineAlongLine {
    fn new(line: &Line, [x, y, z, radius]: [Polynomial; 4]) -> Self {
        let centre = [x, y, z];
        let away = [0, 1, 2].map(|i| &centre[i] - &constant(line.start[i]));
        let sum = [0, 1, 2].map(|i| scaled(&away[i], line.direction[i]));
        let along = &(&sum[0] + &sum[1]) + &sum[2];
        let squared_speed = inner(line.direction, line.direction);
        let distance = &scaled(&dot(&away, &away), squared_speed) - &(&along * &along);
        let square = scaled(&(&radius * &radius), squared_speed);
        let half = |p: &Polynomial| p.derivative().scaled(0.5);
        Self {
            depth: &square - &distance,
            across: half(&distance),
            growth: half(&square),
            direction: line.direction,
            away,
            along,
            radius,
            squared_speed,
        }
    }

    /// Where the line passes through the balls.
    fn windows(&self) -> Vec<[f64; 2]> {
        let mut edges = vec![0.0];
        edges.extend(self.depth.roots([0.0, 1.0]).iter().map(|u| u.high));
        edges.push(1.0);
        let inside = |pair: &&[f64]| self.depth.at((0.5 * (pair[0] + pair[1])).into()).high > 0.0;
        edges.windows(2).filter(inside).map(|pair| [pair[0], pair[1]]).collect()
    }

    /// Where across − (growth) ± s'√D changes its sign within a window, by looking at many places and
    /// bisecting.
    fn roots(&self, [from, to]: [f64; 2], side: f64, ball: bool, places: usize) -> Vec<Doubled> {
        let slope = self.along.derivative();
        let bend = if ball { &self.across - &self.growth } else { self.across.clone() };
        let negative =
            |u: Doubled| (bend.at(u) + slope.at(u) * self.depth.at(u).sqrt() * side.into()).high < 0.0;
        // Denser towards both ends, where the root of D is steep.
        let place = |i: usize| from + (to - from) * (0.5 - 0.5 * (PI * i as f64 / places as f64).cos());
        let mut found = Vec::new();
        let mut last = (place(0), negative(place(0).into()));
        for i in 1..=places {
            let next = (place(i), negative(place(i).into()));
            if next.1 != last.1 {
                let (mut low, mut high) = (Doubled::from(last.0), Doubled::from(next.0));
                for _ in 0..100 {
                    let middle = (low + high) * 0.5.into();
                    *if negative(middle) == last.1 { &mut low } else { &mut high } = middle;
                }
                found.push(low);
            }
            last = next;
        }
        found
    }

    fn t(&self, u: Doubled, side: f64) -> Doubled {
        (self.along.at(u) - self.depth.at(u).sqrt() * side.into()) / self.squared_speed
    }

    /// Where the line meets the tube, facing it.
    fn tube(&self, places: usize) -> Vec<Exact> {
        let mut found = Vec::new();
        for window in self.windows() {
            for side in [1.0, -1.0] {
                for u in self.roots(window, side, false, places) {
                    let t = self.t(u, side);
                    let double = [0, 1, 2].map(|i| self.direction[i] * t - self.away[i].at(u));
                    let velocity = self.away.clone().map(|p| p.derivative());
                    let vector = |p: [Doubled; 3]| Vec3::from_array(p.map(|c| c.high));
                    let (out, speed) = (vector(double), vector(value(&velocity, u)));
                    let bend = vector(value(&velocity.map(|p| p.derivative()), u));
                    let growth = self.radius.at(u).high * self.radius.derivative().at(u).high;
                    let normal = out * (speed.length_squared() - out.dot(bend)) - speed * growth;
                    // Where the path is at rest it has no direction, and no tube.
                    if speed.length() > 1e-9 && normal.dot(vector(self.direction)) < 0.0 {
                        found.push(Exact { t, enters: true });
                    }
                }
            }
        }
        found
    }

    /// The stretches of the line within any of the balls, and on which of them they begin.
    fn spans(&self, places: usize) -> Vec<([Doubled; 2], f64)> {
        let less = |a: Doubled, b: Doubled| (a - b).high < 0.0;
        self.windows()
            .into_iter()
            .map(|window| {
                let mut all: Vec<Doubled> = window.map(Doubled::from).to_vec();
                all.extend([1.0, -1.0].iter().flat_map(|&side| self.roots(window, side, true, places)));
                let entries = all.iter().map(|&u| (self.t(u, 1.0), u.high));
                let (first, u) = entries.reduce(|a, b| if less(a.0, b.0) { a } else { b }).unwrap();
                let last = all.iter().map(|&u| self.t(u, -1.0)).reduce(|a, b| if less(a, b) { b } else { a });
                ([first, last.unwrap()], u)
            })
            .collect()
    }
}

impl Made {
    /// All crossings of a ray with the shape made of a path without a transform, or with one for swept
    /// spheres.
    pub fn exact(self, ray: &Ray, to_world: &Transform, path: &[ControlPoint], places: usize) -> Vec<Exact> {
        let line = Line::new(ray, to_world);
        let seen = path
            .windows(self.kind().order())
            .map(|points| SplineAlongLine::new(&line, segment(self.kind(), points)));
        let before = |a: &Doubled, b: &Doubled| (*a - *b).high.total_cmp(&0.0);
        let mut found: Vec<Exact> = match self {
            Self::Curves(CurveKind::BSpline) => seen.flat_map(|seen| seen.tube(places)).collect(),
            Self::Curves(CurveKind::Linear) => {
                let place = |t: Doubled| [0, 1, 2].map(|i| (line.start[i] + line.direction[i] * t).high);
                let entries = |(n, seen): (usize, SplineAlongLine)| {
                    let is_met = |&(t, u): &(Doubled, f64)| {
                        let is_hidden = |end| is_within_next(place(t).into(), path, n, end);
                        !(u == 0.0 && is_hidden(0) || u == 1.0 && is_hidden(1))
                    };
                    let begins = seen.spans(places).into_iter().map(|([t, _], u)| (t, u));
                    begins.filter(is_met).collect::<Vec<_>>()
                };
                seen.enumerate().flat_map(entries).map(|(t, _)| Exact { t, enters: true }).collect()
            }
            Self::Swept(_) => {
                let mut spans: Vec<_> =
                    seen.flat_map(|seen| seen.spans(places)).map(|(span, _)| span).collect();
                spans.sort_by(|a, b| before(&a[0], &b[0]));
                let mut whole: Vec<[Doubled; 2]> = Vec::new();
                for span in spans {
                    match whole.last_mut() {
                        Some(last) if before(&span[0], &last[1]).is_le() => {
                            if before(&span[1], &last[1]).is_gt() {
                                last[1] = span[1];
                            }
                        }
                        _ => whole.push(span),
                    }
                }
                let ends = |[from, to]: [Doubled; 2]| [(from, true), (to, false)];
                whole.into_iter().flat_map(ends).map(|(t, enters)| Exact { t, enters }).collect()
            }
        };
        found.sort_by(|a, b| before(&a.t, &b.t));
        found.iter().map(|exact| Exact { t: exact.t + line.at.into(), ..*exact }).collect()
    }
}

/// Whether a point on the ball at the beginning (0) or the end (1) of the n-th segment of a linear curve is
/// within the segment that follows there: whether its balls grow around the point.
fn is_within_next(point: Vec3, path: &[ControlPoint], n: usize, end: usize) -> bool {
    let joint = &path[n + end];
    let is_elsewhere = |other: &&ControlPoint| other.position != joint.position;
    let is_point = path[n].position == path[n + 1].position;
    let before = path[..n].iter().rev().find(is_elsewhere).filter(|_| end == 0 || is_point);
    let after = path[n + 1..].iter().find(is_elsewhere).filter(|_| end == 1 || is_point);
    before.into_iter().chain(after).any(|other| {
        let outward = (point - joint.position).normalize();
        other.radius - joint.radius + outward.dot(other.position - joint.position) > 0.0
    })
}
