//! Figures against what they are by definition, in numbers of 32 digits.

use super::doubled::{Doubled, Polynomial};
use super::oracle::{Exact, Line, Tally, any_ray, check_against, near};
use super::{close, direction, placement};
use crate::geometry::{Ray, Transform, Vec3};
use crate::shape::{Blob, Figure, FigureKind, FillRule, Interpolation, Kernel, Shape, ShapeError, Sphere};
use glam::DMat3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg as Random;

/// A concave letter with a hole, its edges neither straight nor even.
fn letter() -> Vec<Vec<[f64; 2]>> {
    vec![
        vec![[-0.75, -0.5], [0.5, -0.625], [0.875, -0.125], [0.0, 0.0], [0.125, 0.75], [-0.625, 0.875]],
        vec![[-0.5, -0.375], [-0.375, 0.125], [-0.125, -0.25]],
    ]
}

fn pentagram() -> Vec<Vec<[f64; 2]>> {
    let corner = |i: i32| (std::f64::consts::TAU * f64::from(2 * i) / 5.0).sin_cos();
    vec![(0..5).map(corner).map(|(y, x)| [x, y]).collect()]
}

fn superquadric(e1: f64, e2: f64) -> FigureKind {
    FigureKind::Superquadric { exponents: [e1, e2], semi_axes: Vec3::new(0.75, 0.5, 1.0) }
}

/// Three that flow together, one of which takes away, and one by itself.
fn blobs(kernel: Kernel) -> FigureKind {
    let blob = |x, y, z, radius, strength| Blob { centre: Vec3::new(x, y, z), radius, strength };
    let blobs = vec![
        blob(-0.25, 0.0, 0.125, 0.75, 1.0),
        blob(0.375, 0.125, 0.0, 0.625, 1.25),
        blob(0.125, 0.25, 0.375, 0.5, -0.75),
        blob(-0.5, -0.625, -0.375, 0.5, 1.0),
    ];
    FigureKind::Blobs { blobs, kernel, threshold: 0.375 }
}

fn turned(profile: &[[f64; 2]], interpolation: Interpolation, closed: bool, capped: bool) -> FigureKind {
    FigureKind::Revolution { profile: profile.to_vec(), interpolation, closed, capped }
}

/// From the axis out and up, with a neck; open at the top.
const VASE: &[[f64; 2]] =
    &[[0.0, -0.75], [0.5, -0.875], [0.875, -0.5], [0.5, 0.0], [0.25, 0.375], [0.25, 0.5], [0.5, 0.75]];
const BELL: &[[f64; 2]] =
    &[[0.5, 1.0], [0.125, 0.75], [0.25, 0.25], [0.5, 0.0], [0.375, -0.25], [0.875, -0.75]];
const WASHER: &[[f64; 2]] = &[[0.5, -0.25], [0.875, -0.125], [0.625, 0.0], [0.75, 0.375], [0.375, 0.25]];
const RING: &[[f64; 2]] = &[[0.5, -0.5], [1.0, -0.25], [0.625, 0.125], [0.875, 0.5], [0.25, 0.375]];

/// One of everything.
pub fn kinds() -> Vec<(&'static str, FigureKind)> {
    let heights = [-0.25, 0.5];
    vec![
        ("polygon", FigureKind::Polygon { contours: letter(), rule: FillRule::EvenOdd }),
        ("star", FigureKind::Polygon { contours: pentagram(), rule: FillRule::Winding }),
        (
            "prism",
            FigureKind::Extrusion { contours: letter(), rule: FillRule::EvenOdd, heights, capped: true },
        ),
        (
            "open prism",
            FigureKind::Extrusion { contours: letter(), rule: FillRule::EvenOdd, heights, capped: false },
        ),
        (
            "star prism",
            FigureKind::Extrusion { contours: pentagram(), rule: FillRule::EvenOdd, heights, capped: true },
        ),
        (
            "star prism by winding",
            FigureKind::Extrusion { contours: pentagram(), rule: FillRule::Winding, heights, capped: true },
        ),
        ("vase", turned(VASE, Interpolation::Bezier, false, true)),
        ("open bell", turned(BELL, Interpolation::BSpline, false, false)),
        ("washer", turned(WASHER, Interpolation::Linear, true, false)),
        ("ring of a spline", turned(RING, Interpolation::BSpline, true, false)),
        ("pillow", superquadric(0.5, 1.0)),
        ("octahedron", superquadric(2.0, 2.0)),
        ("soft blobs", blobs(Kernel::Soft)),
        ("metaballs", blobs(Kernel::Metaball)),
        ("gaussian blobs", blobs(Kernel::Gaussian)),
    ]
}

fn figure(to_world: &Transform, kind: &FigureKind) -> Shape {
    Shape::Figure(Box::new(Figure::new(to_world, kind, false).unwrap()))
}

fn double(value: f64) -> Doubled {
    value.into()
}

/// Where a line's projection crosses the boundary, and whether it enters; with how near it passes a corner.
fn across_outline(line: &Line, contours: &[Vec<[f64; 2]>], rule: FillRule) -> (Vec<(Doubled, bool)>, f64) {
    let Line([x, y, _]) = line;
    let across = [x.0[1], y.0[1]];
    let length = (across[0] * across[0] + across[1] * across[1]).sqrt();
    let side = |corner: [f64; 2]| {
        let away = [double(corner[0]) - x.0[0], double(corner[1]) - y.0[0]];
        across[0] * away[1] - across[1] * away[0]
    };
    let mut doubt = f64::INFINITY;
    let mut all: Vec<(Doubled, i32)> = Vec::new();
    for contour in contours {
        for (i, &from) in contour.iter().enumerate() {
            let to = contour[(i + 1) % contour.len()];
            let (a, b) = (side(from), side(to));
            doubt = doubt.min((a / length).high.abs());
            if (a.high > 0.0) == (b.high > 0.0) {
                continue;
            }
            let at = a / (a - b);
            let place = [0, 1].map(|k| double(from[k]) + (double(to[k]) - double(from[k])) * at);
            let t = ((place[0] - x.0[0]) * across[0] + (place[1] - y.0[0]) * across[1]) / (length * length);
            all.push((t, if b.high > a.high { 1 } else { -1 }));
        }
    }
    all.sort_by(|a, b| (a.0 - b.0).high.total_cmp(&0.0));
    let (mut winding, mut inside) = (0, false);
    let mut found = Vec::new();
    for (t, turn) in all {
        winding += turn;
        let now = if rule == FillRule::EvenOdd { winding & 1 != 0 } else { winding != 0 };
        if now != inside {
            inside = now;
            found.push((t, now));
        }
    }
    (found, doubt)
}

/// Whether a point is over the inside, by a line through it, and how near that passes a corner or the point an edge.
fn over_inside(point: [Doubled; 2], contours: &[Vec<[f64; 2]>], rule: FillRule) -> (bool, f64) {
    let coordinate = |k: usize, slope: f64| Polynomial(vec![point[k], double(slope)]);
    let line = Line([coordinate(0, 0.8), coordinate(1, 0.6), Polynomial::constant(0.0)]);
    let (walls, doubt) = across_outline(&line, contours, rule);
    let behind = walls.iter().filter(|(t, _)| t.high < 0.0).count();
    (behind % 2 == 1, walls.iter().fold(doubt, |doubt, (t, _)| doubt.min(t.high.abs())))
}

/// By intervals: where the line is over the inside, and where between the planes.
fn prism(line: &Line, kind: &FigureKind) -> (Vec<(Doubled, bool)>, f64) {
    let Line([x, y, z]) = line;
    let upright = x.0[1].high == 0.0 && y.0[1].high == 0.0;
    match kind {
        FigureKind::Polygon { contours, rule } => {
            let t = -z.0[0] / z.0[1];
            let (inside, doubt) = over_inside([x.at(t), y.at(t)], contours, *rule);
            let there = inside && z.0[1].high != 0.0;
            (if there { vec![(t, z.0[1].high < 0.0)] } else { Vec::new() }, doubt)
        }
        FigureKind::Extrusion { contours, rule, heights, capped } => {
            let (walls, mut doubt) = across_outline(line, contours, *rule);
            let mut planes = heights.map(|height| (double(height) - z.0[0]) / z.0[1]);
            if z.0[1].high < 0.0 {
                planes.swap(0, 1);
            } else if z.0[1].high == 0.0 {
                let [below, above] = heights.map(|height| (double(height) - z.0[0]).high);
                planes = if below < 0.0 && above > 0.0 {
                    [double(-1e30), double(1e30)]
                } else {
                    [double(1e30); 2]
                };
                doubt = doubt.min(below.abs()).min(above.abs());
            }
            for (wall, _) in &walls {
                for plane in planes {
                    doubt = doubt.min(((*wall - plane) * z.0[1]).high.abs());
                }
            }
            let [enter, leave] = planes;
            let mut found = Vec::new();
            if upright {
                let (inside, doubt) = over_inside([x.0[0], y.0[0]], contours, *rule);
                let ends = if inside && *capped { vec![(enter, true), (leave, false)] } else { Vec::new() };
                return (ends, doubt);
            }
            if !capped {
                found.extend(
                    walls.into_iter().filter(|(t, _)| (*t - enter).high > 0.0 && (leave - *t).high > 0.0),
                );
                return (found, doubt);
            }
            for pair in walls.chunks(2) {
                let later = if (pair[0].0 - enter).high > 0.0 { pair[0].0 } else { enter };
                let sooner = if (pair[1].0 - leave).high > 0.0 { leave } else { pair[1].0 };
                if (sooner - later).high > 0.0 {
                    found.extend([(later, true), (sooner, false)]);
                }
            }
            (found, doubt)
        }
        _ => unreachable!(),
    }
}

/// The function's polynomials where the line is in one octant and their crossings there: for powers that are whole numbers.
fn superellipsoid(line: &Line, [e1, e2]: [f64; 2], semi_axes: Vec3) -> (Vec<(Doubled, bool)>, f64) {
    let (power, outer) = ((2.0 / e2).round() as usize, (e2 / e1).round() as usize);
    let scaled =
        [0, 1, 2].map(|k| Polynomial(line.0[k].0.iter().map(|&c| c / semi_axes[k].into()).collect()));
    let mut ends: Vec<f64> =
        scaled.iter().map(|p| -(p.0[0] / p.0[1]).high).filter(|t| t.is_finite()).collect();
    ends.extend([-1e9, 1e9]);
    ends.sort_by(f64::total_cmp);
    let (mut found, mut doubt) = (Vec::new(), f64::INFINITY);
    let raised = |p: &Polynomial, power: usize| (1..power).fold(p.clone(), |product, _| &product * p);
    for pair in ends.windows(2) {
        let middle = Doubled::from(0.5 * (pair[0] + pair[1]));
        let size = scaled.each_ref().map(|p| p.scaled(if p.at(middle).high < 0.0 { -1.0 } else { 1.0 }));
        let across = &raised(&size[0], power) + &raised(&size[1], power);
        let along = raised(&size[2], power * outer);
        let function = &(&raised(&across, outer) + &along) - &Polynomial::constant(1.0);
        let slope = function.derivative();
        // Each octant to itself, where the function is convex.
        for t in function.roots([pair[0], pair[1]]) {
            found.push((t, slope.at(t).high < 0.0));
        }
        for t in slope.roots([pair[0], pair[1]]).into_iter().chain([pair[0].into()]) {
            doubt = doubt.min(function.at(t).high.abs());
        }
    }
    found.sort_by(|a, b| (a.0 - b.0).high.total_cmp(&0.0));
    (found, doubt)
}

fn check_superquadrics(rays: u32) {
    let shapes = [[1.0, 1.0], [0.5, 0.5], [0.5, 1.0], [2.0, 2.0], [1.0, 2.0], [0.25, 0.5], [0.2, 0.2]];
    for (i, exponents) in shapes.into_iter().enumerate() {
        for (j, to_world) in
            [Transform::IDENTITY, placement(Vec3::new(0.9, 0.5, 0.3))].into_iter().enumerate()
        {
            let kind = superquadric(exponents[0], exponents[1]);
            let FigureKind::Superquadric { semi_axes, .. } = kind else { unreachable!() };
            let exact = |ray: &Ray| {
                let (found, _) = superellipsoid(&Line::new(ray, &to_world), exponents, semi_axes);
                found.into_iter().map(|(t, enters)| Exact { t: t + near(ray).into(), enters }).collect()
            };
            let doubt = |ray: &Ray| superellipsoid(&Line::new(ray, &to_world), exponents, semi_axes).1;
            let shape = figure(&to_world, &kind);
            let name = format!("superquadric {exponents:?}");
            check_against(&name, &shape, exact, doubt, rays, (10 * i + j) as u64).tell(&name);
        }
    }
}

#[test]
fn superquadrics_are_crossed_where_the_oracle_says() {
    check_superquadrics(5_000);
}

#[test]
#[ignore = "takes a minute"]
fn superquadrics_are_crossed_where_the_oracle_says_a_million_times() {
    check_superquadrics(72_000);
}

/// r and z of a profile as cubics of a parameter from 0 to 1, with its caps.
fn cubics(kind: &FigureKind) -> Vec<[Polynomial; 2]> {
    let FigureKind::Revolution { profile, interpolation, closed, capped } = kind else { unreachable!() };
    let count = profile.len();
    let point = |i: usize| profile[i % count].map(double);
    let bezier = |p: [[Doubled; 2]; 4]| -> [Polynomial; 2] {
        [0, 1].map(|k| {
            let [a, b, c, d] = p.map(|point| point[k]);
            let three = double(3.0);
            Polynomial(vec![a, three * (b - a), three * (a - b - b + c), d - a + three * (b - c)])
        })
    };
    let line = |a: [Doubled; 2], b: [Doubled; 2]| [0, 1].map(|k| Polynomial(vec![a[k], b[k] - a[k]]));
    let mut found: Vec<[Polynomial; 2]> = match interpolation {
        Interpolation::Linear => {
            (0..count - usize::from(!closed)).map(|i| line(point(i), point(i + 1))).collect()
        }
        Interpolation::Bezier => (0..(count - usize::from(!closed)) / 3)
            .map(|i| bezier([0, 1, 2, 3].map(|k| point(3 * i + k))))
            .collect(),
        Interpolation::BSpline => (0..if *closed { count } else { count - 3 })
            .map(|i| {
                let mix = |weights: [f64; 4]| {
                    [0, 1].map(|k| {
                        let sum =
                            (0..4).fold(double(0.0), |sum, j| sum + point(i + j)[k] * weights[j].into());
                        sum / 6.0.into()
                    })
                };
                let inner = [[0.0, 4.0, 2.0, 0.0], [0.0, 2.0, 4.0, 0.0]].map(mix);
                bezier([mix([1.0, 4.0, 1.0, 0.0]), inner[0], inner[1], mix([0.0, 1.0, 4.0, 1.0])])
            })
            .collect(),
    };
    if *capped && !closed {
        let ends = [
            found[0].each_ref().map(|p| p.at(double(0.0))),
            found[found.len() - 1].each_ref().map(|p| p.at(double(1.0))),
        ];
        for end in ends.into_iter().filter(|end| end[0].high > 0.0) {
            found.push(line([double(0.0), end[1]], end));
        }
    }
    found
}

/// By the polynomial a r² + b z² + c z + d of each piece's parameter (Glassner ch. 3, 3.3, c and d corrected).
fn revolved(line: &Line, kind: &FigureKind) -> (Vec<Doubled>, f64) {
    let [[x0, x1], [y0, y1], [z0, z1]] = line.0.each_ref().map(|p| [p.0[0], p.0[1]]);
    let (b, rise) = (x1 * x1 + y1 * y1, z1 * z1);
    let cross = |a: Doubled, d: Doubled| (a * z1 - z0 * d) * (a * z1 - z0 * d);
    let (c, d) = ((z1 * (x0 * x1 + y0 * y1) - z0 * b) * 2.0.into(), cross(x0, x1) + cross(y0, y1));
    let times = |p: &Polynomial, factor: Doubled| Polynomial(p.0.iter().map(|&c| c * factor).collect());
    let (mut found, mut doubt) = (Vec::new(), f64::INFINITY);
    for [r, z] in cubics(kind) {
        let squared = &r * &r;
        if z1.high.abs() < 1e-14 {
            // In a level plane, to within rounding: circles. Slopes that are less level than that but not for the polynomial are
            // not among the rays.
            let level = &z - &Polynomial(vec![z0]);
            let trimmed = Polynomial(
                level
                    .0
                    .iter()
                    .copied()
                    .take(level.0.iter().rposition(|c| c.high != 0.0).unwrap_or(0) + 1)
                    .collect(),
            );
            for s in trimmed.roots([0.0, 1.0]) {
                let circle =
                    Polynomial(vec![x0 * x0 + y0 * y0 - squared.at(s), (x0 * x1 + y0 * y1) * 2.0.into(), b]);
                found.extend(circle.roots([-1e9, 1e9]));
                doubt = doubt.min(circle.at(-(circle.0[1] / circle.0[2]) * 0.5.into()).high.abs());
            }
            for s in trimmed.derivative().roots([0.0, 1.0]).into_iter().chain([double(0.0), double(1.0)]) {
                doubt = doubt.min(level.at(s).high.abs());
            }
            continue;
        }
        let both = &times(&(&z * &z), b) + &times(&z, c);
        let function = &(&both - &times(&squared, rise)) + &Polynomial(vec![d]);
        let degree = function.0.iter().rposition(|c| c.high.abs() > 1e-40).unwrap_or(0);
        let function = Polynomial(function.0[..=degree].to_vec());
        for s in function.roots([0.0, 1.0]) {
            found.push((z.at(s) - z0) / z1);
        }
        for s in function.derivative().roots([0.0, 1.0]).into_iter().chain([double(0.0), double(1.0)]) {
            doubt = doubt.min((function.at(s) / rise).high.abs());
        }
        // Level pieces: the plane's own place on the line.
        if z.0[1..].iter().all(|c| c.high == 0.0) && degree == 0 {
            doubt = 0.0;
        }
    }
    found.sort_by(|a, b| (*a - *b).high.total_cmp(&0.0));
    (found, doubt)
}

fn check_revolutions(rays: u32) {
    let mut tally = Tally::default();
    let turned = |kind: &FigureKind| matches!(kind, FigureKind::Revolution { .. });
    for (i, (name, kind)) in kinds().into_iter().filter(|kind| turned(&kind.1)).enumerate() {
        for (j, to_world) in
            [Transform::IDENTITY, placement(Vec3::new(0.9, 0.5, 0.3))].into_iter().enumerate()
        {
            let shape = figure(&to_world, &kind);
            // Which way it goes through is told by another test.
            let exact = |ray: &Ray| {
                let found = revolved(&Line::new(ray, &to_world), &kind).0;
                let ways = shape.crossings(ray);
                let way = |i: usize| ways.get(i).is_some_and(|crossing| crossing.enters);
                let in_world = |(i, t): (usize, Doubled)| Exact { t: t + near(ray).into(), enters: way(i) };
                found.into_iter().enumerate().map(in_world).collect()
            };
            // What is told in the shape's own coordinates is shorter in the world's, in which rays are rounded: by the least
            // stretch at most.
            let inverse = DMat3::from_mat4(to_world.matrix()).inverse();
            let longest = |m: DMat3| {
                m.to_cols_array_2d().map(|c| c.iter().map(|x| x.abs()).sum()).into_iter().fold(0.0, f64::max)
            };
            let least_stretch = 1.0 / f64::sqrt(longest(inverse) * longest(inverse.transpose()));
            let doubt = |ray: &Ray| revolved(&Line::new(ray, &to_world), &kind).1 * least_stretch;
            tally += check_against(name, &shape, exact, doubt, rays, (10 * i + j) as u64);
        }
    }
    tally.tell("revolutions");
}

/// The density less the threshold of all blobs in 32 digits, without the exponential's.
fn density(line: &Line, kind: &FigureKind, t: Doubled) -> Doubled {
    let FigureKind::Blobs { blobs, kernel, threshold } = kind else { unreachable!() };
    let mut sum = -double(*threshold);
    for blob in blobs {
        let away = [0, 1, 2].map(|k| line.0[k].at(t) - blob.centre[k].into());
        let squared = (away[0] * away[0] + away[1] * away[1] + away[2] * away[2])
            / (double(blob.radius) * blob.radius.into());
        let one = double(1.0);
        let value = match kernel {
            Kernel::Gaussian => {
                // exp x = exp(x / 1024)^1024
                let x = squared * double(-4.0 / 1024.0);
                let mut series = one;
                for k in (1..16).rev() {
                    series = one + series * x / double(f64::from(k));
                }
                (0..10).fold(series, |power, _| power * power)
            }
            _ if squared.high >= 1.0 => double(0.0),
            Kernel::Metaball if (squared * 9.0.into() - one).high <= 0.0 => one - squared * 3.0.into(),
            Kernel::Metaball => {
                let rest = one - squared.sqrt();
                double(1.5) * rest * rest
            }
            Kernel::Soft => {
                let nine = double(9.0);
                one - squared * (double(22.0) - squared * (double(17.0) - squared * 4.0.into())) / nine
            }
        };
        sum = sum + value * blob.strength.into();
    }
    sum
}

/// The same in `f64`, which away from zero tells the sign as well: of each blob the squared distance from it along a line, in
/// terms of its radius, as a quadratic of the line's parameter.
struct InDouble {
    quadratics: Vec<([f64; 3], f64)>,
    kernel: Kernel,
    threshold: f64,
}

impl InDouble {
    fn new(line: &Line, kind: &FigureKind) -> Self {
        let FigureKind::Blobs { blobs, kernel, threshold } = kind else { unreachable!() };
        let quadratics = blobs.iter().map(|blob| {
            let squares = [0, 1, 2].map(|k| {
                let away = &line.0[k] - &Polynomial::constant(blob.centre[k]);
                &away * &away
            });
            let sum = &(&squares[0] + &squares[1]) + &squares[2];
            let square = double(blob.radius) * blob.radius.into();
            ([0, 1, 2].map(|power| (sum.0[power] / square).high), blob.strength)
        });
        Self { quadratics: quadratics.collect(), kernel: *kernel, threshold: *threshold }
    }

    fn density(&self, t: f64) -> f64 {
        let of_blob = |&([c, b, a], strength): &([f64; 3], f64)| {
            let squared = (a * t + b) * t + c;
            let value = match self.kernel {
                Kernel::Gaussian => (-4.0 * squared).exp(),
                _ if squared >= 1.0 => 0.0,
                Kernel::Metaball if 9.0 * squared <= 1.0 => 1.0 - 3.0 * squared,
                Kernel::Metaball => 1.5 * (1.0 - squared.max(0.0).sqrt()).powi(2),
                Kernel::Soft => 1.0 - squared * (22.0 - squared * (17.0 - 4.0 * squared)) / 9.0,
            };
            strength * value
        };
        self.quadratics.iter().map(of_blob).sum::<f64>() - self.threshold
    }
}

/// By brute force: signs in many places along the line, and halving between them.
fn check_blobs(rays: u32) {
    const STEPS: u32 = 2_000;
    let (mut touching, mut hits) = (0, 0);
    for (i, kernel) in [Kernel::Soft, Kernel::Metaball, Kernel::Gaussian].into_iter().enumerate() {
        for (j, to_world) in
            [Transform::IDENTITY, placement(Vec3::new(0.9, 0.5, 0.3))].into_iter().enumerate()
        {
            let kind = blobs(kernel);
            let shape = figure(&to_world, &kind);
            let bounds = shape.bounds();
            let mut random = Random::seed_from_u64((10 * i + j) as u64);
            for _ in 0..rays {
                let ray = any_ray(&shape, bounds, &mut random);
                let line = Line::new(&ray, &to_world);
                let found = shape.crossings(&ray);
                hits += found.len();
                // Each crossing is where the sign changes, to within its bound.
                for (k, crossing) in found.iter().enumerate() {
                    let t = double(crossing.hit.t) - near(&ray).into();
                    let [before, after] =
                        [-crossing.error, crossing.error].map(|by| density(&line, &kind, t + by.into()).high);
                    assert!(crossing.enters == (k % 2 == 0));
                    let gap = |other: Option<&crate::shape::Crossing>| {
                        other.is_none_or(|other| {
                            (other.hit.t - crossing.hit.t).abs() > other.error + crossing.error
                        })
                    };
                    if gap(found.get(k + 1)) && (k == 0 || gap(found.get(k - 1))) {
                        assert!(
                            (after > 0.0) == crossing.enters && (before < 0.0) == crossing.enters,
                            "{kernel:?}: {ray:?} {crossing:?} {before:e} {after:e}"
                        );
                        assert!(
                            crossing.error < 1e-6 * (1.0 + crossing.hit.t.abs()),
                            "{kernel:?}: {crossing:?}"
                        );
                    } else {
                        touching += 1;
                    }
                }
                // No other change of sign.
                let along = InDouble::new(&line, &kind);
                let reach = bounds.diameter();
                let middle = -(ray.origin - bounds.centre()).dot(ray.direction);
                let mut inside = 0;
                for step in 0..=STEPS {
                    let t = middle + reach * (2.0 * f64::from(step) / f64::from(STEPS) - 1.0);
                    let passed = found.iter().filter(|crossing| crossing.hit.t < t).count();
                    let value = along.density(t - near(&ray));
                    let expected = passed % 2 == 1;
                    inside += u32::from(expected);
                    assert!(
                        (value > 0.0) == expected || value.abs() < 1e-9,
                        "{kernel:?}: {ray:?} {t} {value:?} {found:?}"
                    );
                }
                assert!(inside < STEPS);
            }
        }
    }
    println!("{touching} crossings of {hits} touch within rounding");
    assert!(hits as u32 > 2 * rays);
}

#[test]
fn blobs_are_crossed_where_their_density_passes_the_threshold() {
    check_blobs(60);
}

#[test]
#[ignore = "takes an hour"]
fn blobs_are_crossed_where_their_density_passes_the_threshold_a_million_times() {
    check_blobs(170_000);
}

#[test]
fn revolutions_are_crossed_where_the_oracle_says() {
    check_revolutions(3_000);
}

#[test]
#[ignore = "takes minutes"]
fn revolutions_are_crossed_where_the_oracle_says_a_million_times() {
    check_revolutions(125_000);
}

fn check_prisms(rays: u32) {
    let mut tally = Tally::default();
    let flat = |kind: &FigureKind| matches!(kind, FigureKind::Polygon { .. } | FigureKind::Extrusion { .. });
    for (i, (name, kind)) in kinds().into_iter().filter(|kind| flat(&kind.1)).enumerate() {
        for (j, (scale, distance)) in
            [(0.0, 0.0), (1.0, 0.0), (1e-6, 1e-3), (1e6, 1e8)].into_iter().enumerate()
        {
            let to_world = match scale {
                0.0 => Transform::IDENTITY,
                _ => placement(Vec3::new(0.9, 0.5, 0.3) * scale)
                    .then(&Transform::translation(Vec3::new(0.6, -0.8, 0.2) * distance)),
            };
            let shape = figure(&to_world, &kind);
            // The place of the line's parameter 0 moves with the shape.
            let exact = |ray: &Ray| {
                let (found, _) = prism(&Line::new(ray, &to_world), &kind);
                found.into_iter().map(|(t, enters)| Exact { t: t + near(ray).into(), enters }).collect()
            };
            let doubt = |ray: &Ray| {
                let origin = to_world.inverse().point(ray.origin).length();
                let there = distance / if scale == 0.0 { 1.0 } else { scale };
                prism(&Line::new(ray, &to_world), &kind).1 / (1.0 + origin + 10.0 * there)
                    * (1.0 + ray.origin.length())
            };
            tally += check_against(name, &shape, exact, doubt, rays, (10 * i + j) as u64);
        }
    }
    tally.tell("prisms");
}

#[test]
fn prisms_are_crossed_where_the_oracle_says() {
    check_prisms(4_000);
}

#[test]
#[ignore = "takes minutes"]
fn prisms_are_crossed_where_the_oracle_says_a_million_times() {
    check_prisms(250_000);
}

/// Solid bodies are entered and left by turns, beginning with entering, by every line at all.
#[test]
fn closed_figures_are_entered_and_left_by_turns() {
    let mut random = Random::seed_from_u64(8);
    for (name, shape) in super::all_shapes() {
        let Shape::Figure(figure) = &shape else { continue };
        if !figure.is_closed() {
            continue;
        }
        for _ in 0..1_000 {
            let ray = any_ray(&shape, shape.bounds(), &mut random);
            let found = shape.crossings(&ray);
            assert!(found.len() % 2 == 0, "{name}: {ray:?} {found:?}");
            for (i, crossing) in found.iter().enumerate() {
                assert!(crossing.enters == (i % 2 == 0), "{name}: {ray:?} {found:?}");
                assert!(i == 0 || found[i - 1].hit.t <= crossing.hit.t, "{name}: {ray:?} {found:?}");
                let normal = shape.surface(&crossing.hit, &ray).point.normal;
                let slope = normal.dot(ray.direction);
                assert!(slope.abs() < 1e-6 || (slope < 0.0) == crossing.enters, "{name}: {ray:?} {slope:e}");
            }
        }
    }
}

/// A half circle turned around z, in 64 cubics that are within 10⁻¹³ of it, is the sphere, and so is a superquadric with both
/// exponents 1: same hits, normals, u and area.
#[test]
fn a_half_circle_turned_is_a_sphere() {
    const ARCS: usize = 64;
    let angle = std::f64::consts::PI / ARCS as f64;
    let handle = 4.0 / 3.0 * (0.25 * angle).tan();
    let mut profile = vec![[0.0, -1.0]];
    for i in 0..ARCS {
        let ends = [i, i + 1].map(|k| (k as f64 * angle).sin_cos());
        let [(s0, c0), (s1, c1)] = ends;
        let end = if i + 1 == ARCS { [0.0, 1.0] } else { [s1, -c1] };
        profile.extend([[s0 + handle * c0, -c0 + handle * s0], [s1 - handle * c1, -c1 - handle * s1], end]);
    }
    let place = placement(Vec3::new(0.9, 0.5, 0.3));
    let turned = figure(&place, &turned(&profile, Interpolation::Bezier, false, true));
    let even = FigureKind::Superquadric { exponents: [1.0; 2], semi_axes: Vec3::ONE };
    let even = figure(&place, &even);
    let sphere = Shape::Sphere(Sphere::new(&place, Vec3::ZERO, 1.0, false).unwrap());
    let mut random = Random::seed_from_u64(5);
    let mut hits = 0;
    for _ in 0..5_000 {
        let ray = any_ray(&sphere, sphere.bounds(), &mut random);
        let exact = sphere.crossings(&ray);
        if exact.len() < 2 || exact[1].hit.t - exact[0].hit.t < 1e-3 {
            continue;
        }
        for shape in [&turned, &even] {
            let found = shape.crossings(&ray);
            assert_eq!(found.len(), 2, "{ray:?}");
            for (a, b) in found.iter().zip(&exact) {
                assert!((a.hit.t - b.hit.t).abs() < a.error + b.error + 1e-9, "{a:?} {b:?}");
                let (p, q) = (shape.surface(&a.hit, &ray).point, sphere.surface(&b.hit, &ray).point);
                assert!(p.normal.distance(q.normal) < 1e-6 * (1.0 + ray.origin.length() * 1e-3));
                let uv = shape.parametrisation(&a.hit, p.position).uv;
                let expected = sphere.parametrisation(&b.hit, p.position).uv;
                assert!(close(uv[0], expected[0], 1e-9) || (uv[0] - expected[0]).abs() > 1.0 - 1e-9);
                // The profile goes up, a sphere's v down.
                let v = if std::ptr::eq(shape, &turned) { 1.0 - uv[1] } else { uv[1] };
                assert!(close(v, expected[1], 1e-4), "{v} {}", expected[1]);
            }
        }
        hits += 1;
    }
    assert!(hits > 1_000);
    for shape in [&turned, &even] {
        assert!(close(shape.area() / sphere.area(), 1.0, 1e-3), "{} {}", shape.area(), sphere.area());
    }
}

/// Every side of the box around a figure touches it: the figure's outermost point is climbed to from samples, by lines along
/// the axis. The search, not the box, is what a hundred-thousandth is left to.
#[test]
fn boxes_touch_figures_on_all_sides() {
    let mut random = Random::seed_from_u64(6);
    for (name, shape) in super::all_shapes() {
        let Shape::Figure(figure) = &shape else { continue };
        let bounds = shape.bounds();
        let size = bounds.diameter();
        for axis in 0..6 {
            let outwards = if axis < 3 { Vec3::AXES[axis] } else { -Vec3::AXES[axis - 3] };
            let side = if axis < 3 { bounds.max[axis] } else { -bounds.min[axis - 3] };
            let mut most = f64::NEG_INFINITY;
            let mut at = Vec3::ZERO;
            let mut take = |found: Option<Vec3>, most: &mut f64| {
                if let Some(point) = found.filter(|point| point.dot(outwards) > *most) {
                    (*most, at) = (point.dot(outwards), point);
                }
                at
            };
            for _ in 0..4_000 {
                let sample = figure.sample([random.random(), random.random()]);
                take(sample.map(|sample| sample.surface.point.position), &mut most);
            }
            // Lines along the axis near the best so far, nearer and nearer.
            let mut place = take(None, &mut most);
            let steps = if figure.is_curved() { 24_000 } else { 6_000 };
            for step in 0..steps {
                let spread = size * 10f64.powf(-1.0 - 7.0 * f64::from(step) / f64::from(steps));
                let offset = direction(&mut random) * spread;
                let ray = Ray::new(place + offset.reject_from(outwards) + outwards * size, -outwards);
                let met = shape.intersect(&ray).map(|hit| ray.at(hit.t));
                place = take(met, &mut most);
            }
            assert!(most <= side + 1e-13, "{name}: outside by {:e}", most - side);
            // The corners of flat pieces and the rims of open ones are hard to find.
            let near = if figure.is_curved() && figure.is_closed() { 1e-5 } else { 1e-4 };
            assert!(side - most < near * size, "{name}: axis {axis} loose by {:e}", (side - most) / size);
        }
    }
}

/// u and v run over the unit square, and tangents are the derivatives.
#[test]
fn coordinates_and_tangents() {
    let mut random = Random::seed_from_u64(2);
    for (name, shape) in super::all_shapes() {
        if !matches!(shape, Shape::Figure(_)) {
            continue;
        }
        let mut seen = 0;
        for _ in 0..500 {
            let Some(sample) = shape.sample([random.random(), random.random()]) else { continue };
            let hit = crate::shape::Hit {
                t: 0.0,
                shape: 0,
                triangle: sample.triangle,
                instance: crate::shape::NO_INSTANCE,
                barycentric: [0.0; 2],
            };
            let point = sample.surface.point;
            let here = shape.parametrisation(&hit, point.position);
            let [u, v] = here.uv;
            assert!((-1e-9..1.0 + 1e-9).contains(&u) && (-1e-9..1.0 + 1e-9).contains(&v), "{name}: {u} {v}");
            for (along, moved) in [(here.tangent, [1.0, 0.0]), (here.bitangent, [0.0, 1.0])] {
                if along.length() < 0.1 || along.length() > 10.0 {
                    continue;
                }
                assert!(along.dot(point.normal).abs() < 1e-6 * along.length(), "{name}: not in the surface");
                let step = 1e-6;
                let [a, b] = shape.parametrisation(&hit, point.position + along * step).uv;
                let change = [(a - u + 0.5).rem_euclid(1.0) - 0.5, b - v].map(|d| d / step);
                let within = 1e-3 * (1.0 + 1.0 / along.length());
                assert!(
                    close(change[0], moved[0], within) && close(change[1], moved[1], within),
                    "{name}: {change:?} {moved:?} {along}"
                );
                seen += 1;
            }
        }
        assert!(seen > 100, "{name}: {seen}");
    }
}

/// Rays that leave a surface outwards don't meet it where they started, at all scales and far from the origin; such as go into a
/// solid leave it again.
#[test]
fn no_figure_is_met_where_it_is_left() {
    let mut random = Random::seed_from_u64(3);
    for (name, kind) in kinds() {
        for (scale, distance) in [(1.0, 0.0), (1e-6, 0.0), (1e6, 0.0), (1.0, 1e5), (1e-3, 1e2)] {
            let place = placement(Vec3::new(0.9, 0.5, 0.3) * scale)
                .then(&Transform::translation(direction(&mut random) * distance));
            let shape = figure(&place, &kind);
            let Shape::Figure(made) = &shape else { unreachable!() };
            let (closed, curved) = (made.is_closed(), made.is_curved());
            for _ in 0..5_000 {
                let Some(sample) = shape.sample([random.random(), random.random()]) else { continue };
                let point = sample.surface.point;
                let angle = 10f64.powf(random.random_range(-4.0..0.0));
                let across = direction(&mut random).cross(point.normal).normalize();
                let leaving = point.ray((across * angle.cos() + point.normal * angle.sin()).normalize());
                let tiny = if curved { 1e-3 * angle } else { 1e-9 };
                if let Some(hit) = shape.intersect(&leaving) {
                    let met = shape.surface(&hit, &leaving).point;
                    // In a corner another piece may be as near as one likes.
                    let corner = met.normal.dot(point.normal) < 0.99;
                    assert!(hit.t > tiny * scale || corner, "{name} {scale} {angle:e}: {:e}", hit.t);
                }
                let inward = point.ray((across * angle.cos() - point.normal * angle.sin()).normalize());
                let crossings = shape.crossings(&inward);
                let ahead = crossings.iter().filter(|crossing| crossing.hit.t >= 0.0).count();
                let edge =
                    crossings.iter().map(|crossing| crossing.hit.t.abs()).fold(f64::INFINITY, f64::min);
                assert!(
                    !closed || ahead % 2 == 1 || edge < 1e-9 * scale + 1e-12 * distance,
                    "{name} {scale} {angle:e}: {crossings:?}"
                );
            }
        }
    }
}

/// A ray meets exactly one of polygons that share an edge, whatever their sizes and wherever they are placed.
#[test]
fn neighbours_leave_no_gap_and_no_overlap() {
    let mut random = Random::seed_from_u64(4);
    for _ in 0..200 {
        let mut any = || [random.random_range(-1.0..1.0), random.random_range(-1.0..1.0)];
        let (a, b) = (any(), any());
        let place = placement(Vec3::new(0.9, 0.5, 0.3) * 10f64.powf(random.random_range(-6.0..6.0)));
        let polygon = |far: [f64; 2]| {
            let contours = vec![vec![a, far, b]];
            figure(&place, &FigureKind::Polygon { contours, rule: FillRule::EvenOdd })
        };
        // Far corners on both sides of the edge, one of them ten times as far away.
        let across = [a[1] - b[1], b[0] - a[0]];
        let corner = |side: f64| [0, 1].map(|k| 0.5 * (a[k] + b[k]) + side * across[k]);
        let sides = [polygon(corner(1.0)), polygon(corner(-10.0))];
        for _ in 0..500 {
            let at: f64 = random.random_range(0.01..0.99);
            let on_edge = [0, 1].map(|k| a[k] + at * (b[k] - a[k]));
            let target = place.point(Vec3::new(on_edge[0], on_edge[1], 0.0));
            let toward = direction(&mut random);
            let ray = Ray::new(target - toward * place.vector(Vec3::X).length(), toward);
            let met = sides.iter().filter(|side| side.intersect(&ray).is_some()).count();
            assert_eq!(met, 1, "{ray:?}");
        }
    }
}

#[test]
fn what_is_no_figure_is_refused() {
    let refused = |kind: &FigureKind| Figure::new(&Transform::IDENTITY, kind, false).err();
    let line = vec![vec![[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]];
    let rule = FillRule::EvenOdd;
    assert_eq!(refused(&FigureKind::Polygon { contours: line, rule }), Some(ShapeError::Outline));
    for heights in [[1.0, 1.0], [1.0, 0.0], [0.0, f64::INFINITY], [f64::NAN, 1.0]] {
        let kind = FigureKind::Extrusion { contours: letter(), rule, heights, capped: true };
        assert_eq!(refused(&kind), Some(ShapeError::Ends));
    }
}

/// Areas of the letter by the shoelace formula, of walls by their lengths.
#[test]
fn areas_are_those_of_closed_forms() {
    let shoelace = |contour: &[[f64; 2]]| -> f64 {
        let twice = |(i, a): (usize, &[f64; 2])| {
            let b = contour[(i + 1) % contour.len()];
            a[0] * b[1] - a[1] * b[0]
        };
        0.5 * contour.iter().enumerate().map(twice).sum::<f64>().abs()
    };
    let length = |contour: &[[f64; 2]]| -> f64 {
        let side = |(i, a): (usize, &[f64; 2])| {
            let b = contour[(i + 1) % contour.len()];
            (a[0] - b[0]).hypot(a[1] - b[1])
        };
        contour.iter().enumerate().map(side).sum()
    };
    let (inside, around) =
        (shoelace(&letter()[0]) - shoelace(&letter()[1]), length(&letter()[0]) + length(&letter()[1]));
    let made = |name: &str| kinds().into_iter().find(|kind| kind.0 == name).unwrap().1;
    let area = |name: &str| figure(&Transform::scale(3.0), &made(name)).area() / 9.0;
    assert!(close(area("polygon"), inside, 1e-14));
    assert!(close(area("open prism"), around * 0.75, 1e-14));
    assert!(close(area("prism"), 2.0 * inside + around * 0.75, 1e-14));
}
