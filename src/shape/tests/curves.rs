//! Curves and swept spheres against a slow oracle: polynomials along the path in numbers of 32 digits.

use super::doubled::{Doubled, Polynomial};
use super::oracle::any_ray;
use super::{close, direction, near, placement};
use crate::geometry::{Bounds, Ray, Transform, Vec3};
use crate::shape::{ControlPoint, CurveKind, Curves, Shape, ShapeError, SweptSphere};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg as Random;
use std::f64::consts::{PI, TAU};

fn control(points: &[[f64; 4]]) -> Vec<ControlPoint> {
    points.iter().map(|&[x, y, z, radius]| ControlPoint { position: Vec3::new(x, y, z), radius }).collect()
}

/// Paths with what is hard: sharp bends, a ball within another, ends at rest, a straight piece, thin and thick ones.
fn paths() -> Vec<(&'static str, Vec<ControlPoint>)> {
    vec![
        (
            "bent",
            control(&[
                [0.0, 0.0, 0.0, 0.125],
                [1.0, 0.0, 0.0, 0.25],
                [2.0, 1.0, 0.0, 0.375],
                [3.0, 1.0, 1.0, 0.125],
                [4.0, 0.0, 0.0, 0.25],
                [5.0, 0.0, 0.25, 0.0625],
            ]),
        ),
        (
            "hair",
            control(&[
                [0.0, 0.0, 0.0, 0.0009765625],
                [0.25, 0.125, 1.0, 0.0009765625],
                [-0.125, 0.25, 2.0, 0.00048828125],
                [0.5, -0.25, 3.0, 0.0001220703125],
                [0.75, 0.5, 3.5, 0.0],
            ]),
        ),
        (
            "straight",
            control(&[
                [-1.0, 0.5, 0.25, 0.5],
                [0.0, 0.5, 0.25, 0.5],
                [1.0, 0.5, 0.25, 0.5],
                [2.0, 0.5, 0.25, 0.5],
            ]),
        ),
        (
            "at rest at both ends",
            control(&[
                [0.0, 0.0, 0.0, 0.25],
                [0.0, 0.0, 0.0, 0.25],
                [0.0, 0.0, 0.0, 0.25],
                [1.0, 0.5, 0.0, 0.125],
                [1.0, 1.0, 1.0, 0.25],
                [1.0, 1.0, 1.0, 0.25],
                [1.0, 1.0, 1.0, 0.25],
            ]),
        ),
        (
            "hairpin",
            control(&[
                [0.0, 0.0, 0.0, 0.5],
                [2.0, 0.0, 0.0, 0.25],
                [2.0, 0.25, 0.0, 0.125],
                [0.0, 0.25, 0.5, 0.375],
                [0.125, 0.25, 0.5, 0.125],
            ]),
        ),
    ]
}

/// A ball along a bend of a size of about 1.
pub fn swept(to_world: &Transform, kind: CurveKind) -> Shape {
    let path = control(&[
        [-0.75, -0.25, 0.0, 0.125],
        [-0.25, 0.5, 0.125, 0.25],
        [0.375, -0.375, -0.125, 0.1875],
        [0.5, 0.5, 0.375, 0.25],
        [0.75, 0.0, 0.5, 0.125],
    ]);
    Made::Swept(kind).shape(to_world, &path, false)
}

fn constant(value: Doubled) -> Polynomial {
    Polynomial(vec![value])
}

fn scaled(p: &Polynomial, factor: Doubled) -> Polynomial {
    Polynomial(p.0.iter().map(|&c| c * factor).collect())
}

/// x, y, z and radius of a segment as polynomials of u from 0 to 1.
fn segment(kind: CurveKind, points: &[ControlPoint]) -> [Polynomial; 4] {
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
struct Seen {
    /// Centre relative to the line's start, over the line and along it; times the line's speed.
    away: [Polynomial; 3],
    along: Polynomial,
    /// r² less the squared distance of the centre from the line, times the line's speed squared; its root is half of what of the
    /// line is within the ball.
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
struct Exact {
    t: Doubled,
    enters: bool,
}

impl Seen {
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

    /// Where across − (growth) ± s'√D changes its sign within a window, by looking at many places and bisecting.
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

    /// The stretches of the line within any of the balls.
    fn spans(&self, places: usize) -> Vec<[Doubled; 2]> {
        let less = |a: Doubled, b: Doubled| (a - b).high < 0.0;
        self.windows()
            .into_iter()
            .map(|window| {
                let mut all: Vec<Doubled> = window.map(Doubled::from).to_vec();
                all.extend([1.0, -1.0].iter().flat_map(|&side| self.roots(window, side, true, places)));
                let first = all.iter().map(|&u| self.t(u, 1.0)).reduce(|a, b| if less(a, b) { a } else { b });
                let last = all.iter().map(|&u| self.t(u, -1.0)).reduce(|a, b| if less(a, b) { b } else { a });
                [first.unwrap(), last.unwrap()]
            })
            .collect()
    }
}

/// Which surface a path is made into.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Made {
    Curves(CurveKind),
    Swept(CurveKind),
}

impl Made {
    const ALL: [Self; 4] = [
        Self::Curves(CurveKind::Linear),
        Self::Curves(CurveKind::BSpline),
        Self::Swept(CurveKind::Linear),
        Self::Swept(CurveKind::BSpline),
    ];

    fn kind(self) -> CurveKind {
        let (Self::Curves(kind) | Self::Swept(kind)) = self;
        kind
    }

    fn shape(self, to_world: &Transform, path: &[ControlPoint], flip: bool) -> Shape {
        let curves = [path.to_vec()];
        match self {
            Self::Curves(kind) => Shape::Curves(Curves::new(to_world, kind, &curves, flip).unwrap()),
            Self::Swept(kind) => {
                Shape::SweptSphere(Box::new(SweptSphere::new(to_world, kind, &curves, flip).unwrap()))
            }
        }
    }

    /// All crossings of a ray with the shape made of a path without a transform, or with one for swept spheres.
    fn exact(self, ray: &Ray, to_world: &Transform, path: &[ControlPoint], places: usize) -> Vec<Exact> {
        let line = Line::new(ray, to_world);
        let seen =
            path.windows(self.kind().order()).map(|points| Seen::new(&line, segment(self.kind(), points)));
        let before = |a: &Doubled, b: &Doubled| (*a - *b).high.total_cmp(&0.0);
        let mut found: Vec<Exact> = match self {
            Self::Curves(CurveKind::BSpline) => seen.flat_map(|seen| seen.tube(places)).collect(),
            Self::Curves(CurveKind::Linear) => {
                seen.flat_map(|seen| seen.spans(places)).map(|[t, _]| Exact { t, enters: true }).collect()
            }
            Self::Swept(_) => {
                let mut spans: Vec<_> = seen.flat_map(|seen| seen.spans(places)).collect();
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

/// Compares `rays` rays; returns how many were left undecided, because a ray hardly beside them has another number of crossings,
/// and the largest error of t relative to t and the shape's size.
fn check(
    name: &str,
    made: Made,
    to_world: &Transform,
    path: &[ControlPoint],
    rays: u32,
    seed: u64,
) -> (u32, f64) {
    let shape = made.shape(to_world, path, false);
    let (bounds, mut random) = (shape.bounds(), Random::seed_from_u64(seed));
    let (mut doubtful, mut hits, mut worst) = (0, 0, 0.0f64);
    for _ in 0..rays {
        let ray = aimed(made, &shape, path, to_world, bounds, &mut random);
        let found = shape.crossings(&ray);
        let told = |exact: &[Exact]| exact.iter().map(|e| (e.t.high, e.enters)).collect::<Vec<_>>();
        let agrees = |exact: &[Exact]| {
            found.len() == exact.len()
                && found.iter().zip(exact).all(|(crossing, exact)| {
                    let off = (Doubled::from(crossing.hit.t) - exact.t).high.abs();
                    crossing.enters == exact.enters && off <= crossing.error
                })
        };
        let mut exact = made.exact(&ray, to_world, path, 24);
        if !agrees(&exact) {
            exact = made.exact(&ray, to_world, path, 3000);
        }
        hits += exact.len();
        if agrees(&exact) {
            for (crossing, exact) in found.iter().zip(&exact) {
                let off = (Doubled::from(crossing.hit.t) - exact.t).high.abs();
                worst = worst.max(off / (exact.t.high.abs() + bounds.diameter()));
            }
            let nearest = shape.intersect(&ray).map(|hit| hit.t);
            let first = found.iter().map(|crossing| crossing.hit.t).find(|&t| t >= 0.0);
            assert!(nearest == first, "{name} {made:?}: {ray:?} {nearest:?} {first:?}");
            continue;
        }
        // As far beside it as coordinates are rounded, tenfold.
        let beside = 1e-13 * (bounds.diameter() + ray.origin.length());
        let (x, y) = ray.direction.any_orthonormal_pair();
        let changes = (0..8).any(|i| {
            let (sin, cos) = (TAU * f64::from(i) / 8.0).sin_cos();
            let moved = Ray::new(ray.origin + (x * cos + y * sin) * beside, ray.direction);
            made.exact(&moved, to_world, path, 3000).len() != exact.len()
        });
        assert!(changes, "{name} {made:?}: {ray:?}\n{found:?}\n{:?}", told(&exact));
        doubtful += 1;
    }
    assert!(hits as u32 > rays / 4, "{name} {made:?}: only {hits} crossings");
    (doubtful, worst)
}

/// Rays from near and far at the path: through it, past it, hardly touching, straight along it and across it.
fn aimed(
    made: Made,
    shape: &Shape,
    path: &[ControlPoint],
    to_world: &Transform,
    bounds: Bounds,
    random: &mut Random,
) -> Ray {
    if random.random_range(0..8) == 0 {
        return any_ray(shape, bounds, random);
    }
    let order = made.kind().order();
    let i = random.random_range(0..=path.len() - order);
    let [x, y, z, r] = segment(made.kind(), &path[i..i + order]);
    let u: Doubled = random.random::<f64>().into();
    let vector = |p: [&Polynomial; 3]| Vec3::from_array(p.map(|p| p.at(u).high));
    let middle = to_world.point(vector([&x, &y, &z]));
    let slopes = [&x, &y, &z].map(Polynomial::derivative);
    let ahead = to_world.vector(vector(slopes.each_ref())).try_normalize().unwrap_or(Vec3::X);
    let radius = r.at(u).high * to_world.vector(Vec3::X).length();
    let toward = match random.random_range(0..4) {
        0 => (ahead + direction(random) * 10f64.powf(random.random_range(-3.0..0.0))).normalize(),
        1 => direction(random).cross(ahead).try_normalize().unwrap_or(Vec3::Y),
        _ => direction(random),
    };
    let side = direction(random).reject_from_normalized(toward).try_normalize().unwrap_or(Vec3::ZERO);
    let off = match random.random_range(0..3) {
        0 => radius * (1.0 + 10f64.powf(random.random_range(-12.0..-1.0))),
        1 => radius * (1.0 - 10f64.powf(random.random_range(-12.0..-1.0))),
        _ => radius * random.random_range(0.0..1.5),
    };
    let distance = match random.random_range(0..6) {
        0 => 0.0,
        1 => 1e3,
        2 => 1e6,
        _ => random.random_range(-5.0..5.0),
    };
    Ray::new(middle + side * off - toward * distance, toward)
}

fn check_all(rays: u32) {
    let mut seed = 0;
    for made in Made::ALL {
        let (mut doubtful, mut worst) = (0, 0.0f64);
        let mut count = 0;
        for (name, path) in paths() {
            let skew = placement(Vec3::new(0.9, 0.5, 0.3));
            let places = if matches!(made, Made::Swept(_)) {
                vec![Transform::IDENTITY, skew]
            } else {
                // Radii do not follow.
                vec![Transform::IDENTITY]
            };
            for to_world in places.iter().chain(if places.len() == 1 { &places[..] } else { &[] }) {
                seed += 1;
                let (left, off) = check(name, made, to_world, &path, rays, seed);
                doubtful += left;
                worst = worst.max(off);
                count += rays;
            }
        }
        println!(
            "{made:?}: {doubtful} of {count} rays touch within rounding; t is off by {worst:.1e} of itself and the shape's size at most"
        );
        assert!(f64::from(doubtful) < 0.1 * f64::from(count));
    }
}

#[test]
fn curves_are_crossed_where_the_oracle_says() {
    check_all(400);
}

#[test]
#[ignore = "takes half an hour"]
fn curves_are_crossed_where_the_oracle_says_a_million_times() {
    check_all(100_000);
}

fn kinds() -> Vec<(String, Shape)> {
    let place = placement(Vec3::splat(0.7));
    let all = paths().into_iter().flat_map(|(name, path)| {
        Made::ALL.into_iter().map(move |made| (format!("{name} {made:?}"), made.shape(&place, &path, false)))
    });
    all.collect()
}

/// Points are on their surface within their error, boxes hold them, normals stand across both tangents, and rays that leave
/// outward don't meet the surface where they started.
#[test]
fn hits_are_on_the_surface_and_within_the_box() {
    let mut random = Random::seed_from_u64(21);
    for (name, shape) in kinds() {
        let bounds = shape.bounds();
        let mut seen = 0;
        for _ in 0..8_000 {
            if seen == 500 {
                break;
            }
            let ray = any_ray(&shape, bounds, &mut random);
            let Some(hit) = shape.intersect(&ray) else { continue };
            let point = shape.surface(&hit, &ray).point;
            assert!(
                near(point.position, ray.at(hit.t), 1e-9 * (1.0 + ray.origin.length())),
                "{name} {ray:?}"
            );
            assert!(close(point.normal.length(), 1.0, 1e-12) && point.error < 1e-13, "{name} {point:?}");
            let outside = (bounds.min - point.position).max(point.position - bounds.max).max_element();
            assert!(outside <= 2.0 * point.error, "{name}: {outside}");
            let here = shape.parametrisation(&hit, point.position);
            assert!(here.uv.iter().all(|c| (0.0..=1.0).contains(c)), "{name} {here:?}");
            for tangent in [here.tangent, here.bitangent] {
                let slope = tangent.dot(point.normal).abs();
                // On round ends the tangent along the path is none of the surface's.
                let along = !matches!(&shape, Shape::Curves(_))
                    || tangent == here.tangent
                    || name.contains("BSpline");
                // Of far rays that all but touch, not so much is known.
                let far = ray.origin.length() > 100.0;
                assert!(
                    !along || far || slope <= 1e-6 * (tangent.length() + 1e-3),
                    "{name} {here:?} {point:?}"
                );
            }
            let away = direction(&mut random);
            let away = if away.dot(point.normal) < 0.0 { -away } else { away };
            if let Some(again) = shape.intersect(&point.ray(away)) {
                assert!(
                    again.t > 1e-6 * away.dot(point.normal).abs().min(1e-3),
                    "{name} {point:?} {away} {again:?}"
                );
            }
            seen += 1;
        }
        assert!(seen > 1, "{name}: {seen}");
    }
}

/// A ball moved along a line is a capsule: 2πr(l + 2r); a straight tube has 2πrl.
#[test]
fn areas_are_those_of_closed_forms() {
    let straight = paths().swap_remove(2).1;
    let area = |made: Made| made.shape(&Transform::IDENTITY, &straight, false).area();
    assert!(close(area(Made::Curves(CurveKind::BSpline)), PI, 1e-12));
    assert!(close(area(Made::Curves(CurveKind::Linear)), 3.0 * 2.0 * PI * 0.5 * (1.0 + 2.0 * 0.5), 1e-12));
    for (kind, length) in [(CurveKind::Linear, 3.0), (CurveKind::BSpline, 1.0)] {
        let expected = 2.0 * PI * 0.5 * (length + 2.0 * 0.5);
        assert!(close(area(Made::Swept(kind)) / expected, 1.0, 1e-3));
    }
}

/// Sampling finds every part with its density: the mean of 1/density over all samples is the area.
#[test]
fn swept_spheres_are_sampled_by_their_density() {
    let mut random = Random::seed_from_u64(22);
    for (name, path) in paths() {
        if name != "bent" {
            continue;
        }
        for kind in [CurveKind::Linear, CurveKind::BSpline] {
            let shape = Made::Swept(kind).shape(&placement(Vec3::new(0.9, 0.5, 0.3)), &path, false);
            let (n, mut mean, mut square) = (5_000, 0.0, 0.0);
            for _ in 0..n {
                let Some(sample) = shape.sample([random.random(), random.random()]) else { continue };
                let again = shape.area_density(&sample.surface.point);
                assert!(close(again / sample.density, 1.0, 1e-6), "{name}: {again} {}", sample.density);
                mean += 1.0 / sample.density / f64::from(n);
                square += (1.0 / sample.density).powi(2) / f64::from(n);
            }
            let error = ((square - mean * mean) / f64::from(n)).sqrt() + 1e-3 * mean;
            assert!(close(mean, shape.area(), 4.0 * error), "{name}: {mean} ± {error}, {}", shape.area());
        }
    }
}

#[test]
fn what_is_no_curve_is_refused() {
    let (id, linear) = (Transform::IDENTITY, CurveKind::Linear);
    let two = control(&[[0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 1.0]]);
    let error = |kind, curve: Vec<ControlPoint>| Curves::new(&id, kind, &[curve], false).err();
    assert_eq!(error(linear, two.clone()), None);
    assert_eq!(
        error(CurveKind::BSpline, two.clone()),
        Some(ShapeError::ControlPoints { found: 2, least: 4 })
    );
    let mut bad = two.clone();
    bad[1].radius = -1.0;
    assert_eq!(error(linear, bad), Some(ShapeError::Radius(-1.0)));
    let points = control(&[[0.0; 4], [1.0, 0.0, 0.0, 0.0]]);
    assert_eq!(SweptSphere::new(&id, linear, &[points], false).err(), Some(ShapeError::Radius(0.0)));
}

/// What Mitsuba 3.9.1 (llvm_ad_rgb) answers to the same rays: (t, normal, uv).
#[test]
fn conventions_are_those_of_mitsuba() {
    let path = control(&[
        [0.0, 0.0, 0.0, 0.1],
        [1.0, 0.0, 0.0, 0.2],
        [2.0, 1.0, 0.0, 0.3],
        [3.0, 1.0, 1.0, 0.1],
        [4.0, 0.0, 0.0, 0.2],
        [5.0, 0.0, 0.0, 0.2],
    ]);
    let down = |x: f64, y: f64| Ray::new(Vec3::new(x, y, 5.0), -Vec3::Z);
    let across = Ray::new(Vec3::new(2.5, 5.0, 0.4), -Vec3::Y);
    let (linear, spline) = (CurveKind::Linear, CurveKind::BSpline);
    let cases = [
        (linear, down(1.5, 0.5), 4.74937, [-0.0499997, -0.05, 0.997497], [0.25, 0.302513]),
        (linear, across, 3.8, [0.333334, 0.933333, -0.133333], [0.945913, 0.485714]),
        (linear, down(-0.05, 0.0), 4.9134, [-0.499999, 0.0, 0.866026], [0.25, 0.0]),
        (linear, down(5.1, 0.0), 4.82679, [0.499999, 0.0, 0.866026], [0.25, 1.0]),
        (spline, down(1.5, 0.5), 4.7328, [-0.127062, -0.0952654, 0.987309], [0.250003, 0.173727]),
        (spline, across, 3.84956, [0.233373, 0.942731, -0.238319], [0.944108, 0.489435]),
    ];
    for (kind, ray, t, normal, uv) in cases {
        let shape = Made::Curves(kind).shape(&Transform::IDENTITY, &path, false);
        let hit = shape.intersect(&ray).unwrap();
        let found = shape.surface(&hit, &ray);
        let here = shape.parametrisation(&hit, found.point.position);
        assert!(close(hit.t, t, 1e-5), "{kind:?} {hit:?} {t}");
        assert!(near(found.point.normal, Vec3::from_array(normal), 1e-5), "{kind:?} {found:?}");
        assert!(close(here.uv[0], uv[0], 1e-5) && close(here.uv[1], uv[1], 1e-5), "{kind:?} {here:?} {uv:?}");
    }
    // From within nothing is seen, and through the open end neither.
    let tube = Made::Curves(spline).shape(&Transform::IDENTITY, &paths().swap_remove(2).1, false);
    assert_eq!(tube.intersect(&Ray::new(Vec3::new(0.5, 0.5, 0.25), Vec3::Y)), None);
    assert_eq!(tube.intersect(&Ray::new(Vec3::new(5.0, 0.5, 0.5), -Vec3::X)), None);
}
