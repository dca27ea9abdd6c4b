//! Profiles and implicit surfaces: what they have in common here, each against what it is by definition, in
//! numbers of 32 digits, in a file of its own.

mod blobs;
mod prisms;
mod revolutions;
mod superquadrics;

use super::doubled::Doubled;
use super::leaving::{Leaving, PLACES, leave, placed};
use super::oracle::any_ray;
use super::{close, direction};
use crate::geometry::{Ray, Transform, Vec3};
use crate::shape::{
    Blob, FillRule, Interpolation, Kernel, ProfileOrImplicit, ProfileOrImplicitKind, Shape, ShapeError,
};
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

fn superquadric(e1: f64, e2: f64) -> ProfileOrImplicitKind {
    ProfileOrImplicitKind::Superquadric { exponents: [e1, e2], semi_axes: Vec3::new(0.75, 0.5, 1.0) }
}

/// Three that flow together, one of which takes away, and one by itself.
fn blobs(kernel: Kernel) -> ProfileOrImplicitKind {
    let blob = |x, y, z, radius, strength| Blob { centre: Vec3::new(x, y, z), radius, strength };
    let blobs = vec![
        blob(-0.25, 0.0, 0.125, 0.75, 1.0),
        blob(0.375, 0.125, 0.0, 0.625, 1.25),
        blob(0.125, 0.25, 0.375, 0.5, -0.75),
        blob(-0.5, -0.625, -0.375, 0.5, 1.0),
    ];
    ProfileOrImplicitKind::Blobs { blobs, kernel, threshold: 0.375 }
}

fn turned(
    profile: &[[f64; 2]],
    interpolation: Interpolation,
    closed: bool,
    capped: bool,
) -> ProfileOrImplicitKind {
    ProfileOrImplicitKind::Revolution { profile: profile.to_vec(), interpolation, closed, capped }
}

/// From the axis out and up, with a neck; open at the top.
const VASE: &[[f64; 2]] =
    &[[0.0, -0.75], [0.5, -0.875], [0.875, -0.5], [0.5, 0.0], [0.25, 0.375], [0.25, 0.5], [0.5, 0.75]];
const BELL: &[[f64; 2]] =
    &[[0.5, 1.0], [0.125, 0.75], [0.25, 0.25], [0.5, 0.0], [0.375, -0.25], [0.875, -0.75]];
const WASHER: &[[f64; 2]] = &[[0.5, -0.25], [0.875, -0.125], [0.625, 0.0], [0.75, 0.375], [0.375, 0.25]];
const RING: &[[f64; 2]] = &[[0.5, -0.5], [1.0, -0.25], [0.625, 0.125], [0.875, 0.5], [0.25, 0.375]];

/// One of everything.
pub fn kinds() -> Vec<(&'static str, ProfileOrImplicitKind)> {
    let heights = [-0.25, 0.5];
    vec![
        ("polygon", ProfileOrImplicitKind::Polygon { contours: letter(), rule: FillRule::EvenOdd }),
        ("star", ProfileOrImplicitKind::Polygon { contours: pentagram(), rule: FillRule::Winding }),
        (
            "prism",
            ProfileOrImplicitKind::Extrusion {
                contours: letter(),
                rule: FillRule::EvenOdd,
                heights,
                capped: true,
            },
        ),
        (
            "open prism",
            ProfileOrImplicitKind::Extrusion {
                contours: letter(),
                rule: FillRule::EvenOdd,
                heights,
                capped: false,
            },
        ),
        (
            "star prism",
            ProfileOrImplicitKind::Extrusion {
                contours: pentagram(),
                rule: FillRule::EvenOdd,
                heights,
                capped: true,
            },
        ),
        (
            "star prism by winding",
            ProfileOrImplicitKind::Extrusion {
                contours: pentagram(),
                rule: FillRule::Winding,
                heights,
                capped: true,
            },
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

fn new_shape(to_world: &Transform, kind: &ProfileOrImplicitKind) -> Shape {
    Shape::ProfileOrImplicit(Box::new(ProfileOrImplicit::new(to_world, kind, false).unwrap()))
}

fn double(value: f64) -> Doubled {
    value.into()
}

/// Solid bodies are entered and left by turns, beginning with entering, by every line at all.
#[test]
fn closed_figures_are_entered_and_left_by_turns() {
    let mut random = Random::seed_from_u64(8);
    for (name, shape) in super::all_shapes() {
        let Shape::ProfileOrImplicit(inner) = &shape else { continue };
        if !inner.is_closed() {
            continue;
        }
        for _ in 0..crate::stress::count(200, 10_000) {
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

/// Every side of the box around a shape touches it: the shape's outermost point is climbed to from samples,
/// by lines along the axis. The search, not the box, is what a hundred-thousandth is left to.
#[test]
fn boxes_touch_figures_on_all_sides() {
    let mut random = Random::seed_from_u64(6);
    for (name, shape) in super::all_shapes() {
        let Shape::ProfileOrImplicit(inner) = &shape else { continue };
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
                let sample = inner.sample([random.random(), random.random()]);
                take(sample.map(|sample| sample.surface.point.position), &mut most);
            }
            // Lines along the axis near the best so far, nearer and nearer.
            let mut place = take(None, &mut most);
            let steps = if inner.is_curved() { 24_000 } else { 6_000 };
            for step in 0..steps {
                let spread = size * 10f64.powf(-1.0 - 7.0 * f64::from(step) / f64::from(steps));
                let offset = direction(&mut random) * spread;
                let ray = Ray::new(place + offset.reject_from(outwards) + outwards * size, -outwards);
                let met = shape.intersect(&ray).map(|hit| ray.at(hit.t));
                place = take(met, &mut most);
            }
            assert!(most <= side + 1e-13, "{name}: outside by {:e}", most - side);
            // The corners of flat pieces and the rims of open ones are hard to find.
            let near = if inner.is_curved() && inner.is_closed() { 1e-5 } else { 1e-4 };
            assert!(side - most < near * size, "{name}: axis {axis} loose by {:e}", (side - most) / size);
        }
    }
}

/// u and v run over the unit square, and tangents are the derivatives.
#[test]
fn coordinates_and_tangents() {
    let mut random = Random::seed_from_u64(2);
    for (name, shape) in super::all_shapes() {
        if !matches!(shape, Shape::ProfileOrImplicit(_)) {
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

/// Rays that leave a surface outwards don't meet it where they started, at all scales and far from the
/// origin; such as go into a solid leave it again.
#[test]
fn no_figure_is_met_where_it_is_left() {
    let mut random = Random::seed_from_u64(3);
    for (name, kind) in kinds() {
        for (scale, distance) in PLACES {
            let shape = new_shape(&placed([scale, distance], &mut random), &kind);
            let Shape::ProfileOrImplicit(made) = &shape else { unreachable!() };
            let (closed, curved) = (made.is_closed(), made.is_curved());
            for _ in 0..crate::stress::count(2_000, 50_000) {
                let Some(Leaving { point, angle, outward, inward }) = leave(&shape, &mut random) else {
                    continue;
                };
                let tiny = if curved { 1e-3 * angle } else { 1e-9 };
                if let Some(hit) = shape.intersect(&outward) {
                    let met = shape.surface(&hit, &outward).point;
                    // In a corner another piece may be as near as one likes.
                    let corner = met.normal.dot(point.normal) < 0.99;
                    assert!(hit.t > tiny * scale || corner, "{name} {scale} {angle:e}: {:e}", hit.t);
                }
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

#[test]
fn what_is_no_figure_is_refused() {
    let refused =
        |kind: &ProfileOrImplicitKind| ProfileOrImplicit::new(&Transform::IDENTITY, kind, false).err();
    let line = vec![vec![[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]];
    let rule = FillRule::EvenOdd;
    assert_eq!(refused(&ProfileOrImplicitKind::Polygon { contours: line, rule }), Some(ShapeError::Outline));
    for heights in [[1.0, 1.0], [1.0, 0.0], [0.0, f64::INFINITY], [f64::NAN, 1.0]] {
        let kind = ProfileOrImplicitKind::Extrusion { contours: letter(), rule, heights, capped: true };
        assert_eq!(refused(&kind), Some(ShapeError::Ends));
    }
}
