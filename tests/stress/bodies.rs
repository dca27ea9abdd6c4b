//! Bodies of all kinds of shape, and where a line that leaves one meets it again by closed forms: not by
//! tracing a ray.

use abbe::geometry::{Bounds, Transform, Vec3};
use abbe::shape::{
    Cylinder, Disk, Mesh, MeshData, Quadric, QuadricKind, Shape, ShapeError, Sheets, Sphere, Torus,
};
use glam::DMat3;
use std::collections::BTreeMap;

/// What a ray that leaves a surface must find.
#[derive(Clone, Copy, Debug)]
pub enum Truth {
    /// The body is not in the way.
    Nothing,
    /// It is met at a distance, where its normal (of any length) is as given and it lies within `dent` of its
    /// plane.
    At { t: f64, normal: Vec3, dent: f64 },
    /// Too near an edge or a tangent for rounded numbers to say.
    Unsure,
}

/// A surface in its own coordinates, where it is of the size of 1.
#[derive(Clone)]
pub enum Form {
    /// xᵀ A x + 2 b·x + c = 0, cut off by the planes of a box; with caps where it is solid.
    Quadric {
        a: DMat3,
        b: Vec3,
        c: f64,
        clip: Bounds,
        solid: bool,
    },
    Torus {
        major: f64,
        minor: f64,
    },
    /// It is never met again.
    Flat,
    /// A convex mesh, by the planes of its triangles, n·x = d. `dent` is how far rounded vertices stand out
    /// of them.
    Convex {
        planes: Vec<(Vec3, f64)>,
        dent: f64,
    },
}

#[derive(Clone)]
pub struct Body {
    pub name: &'static str,
    pub form: Form,
    make: fn(&Transform) -> Result<Shape, ShapeError>,
}

impl Body {
    pub fn at(&self, to_world: &Transform) -> Shape {
        (self.make)(to_world).expect("a shape that can be placed")
    }

    pub fn is_mesh(&self) -> bool {
        ["rectangle", "cube", "icosphere"].contains(&self.name)
    }
}

/// x² + y² = p z² + 2 q z + r between two heights.
fn revolution(p: f64, q: f64, r: f64, [low, high]: [f64; 2], solid: bool) -> Form {
    let a = DMat3::from_diagonal(Vec3::new(1.0, 1.0, -p));
    let clip = Bounds { min: Vec3::NEG_INFINITY.with_z(low), max: Vec3::INFINITY.with_z(high) };
    Form::Quadric { a, b: Vec3::new(0.0, 0.0, -q), c: -r, clip, solid }
}

fn quadric(place: &Transform, kind: QuadricKind, solid: bool) -> Result<Shape, ShapeError> {
    Ok(Shape::Quadric(Box::new(Quadric::of_kind(place, &kind, solid, false)?)))
}

fn hyperboloid(sheets: Sheets) -> QuadricKind {
    QuadricKind::Hyperboloid { sheets, radius: 0.4, semi_axis: 0.3, heights: [-0.8, 0.9] }
}

/// z = x² − y².
const SADDLE: [f64; 10] = [1.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0];
const SADDLE_CLIP: Bounds = Bounds { min: Vec3::new(-1.0, -1.0, -0.5), max: Vec3::new(1.0, 1.0, 0.5) };

fn saddle(solid: bool) -> Form {
    let a = DMat3::from_diagonal(Vec3::new(1.0, -1.0, 0.0));
    Form::Quadric { a, b: Vec3::new(0.0, 0.0, -0.5), c: 0.0, clip: SADDLE_CLIP, solid }
}

pub fn bodies() -> Vec<Body> {
    const ALL: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];
    // The squared radius of a hyperboloid of one or two sheets: radius² (z² / semi_axis² ± 1).
    let slope = 0.4 / 0.3;
    let body = |name, form, make| Body { name, form, make };
    vec![
        body("sphere", revolution(-1.0, 0.0, 1.0, ALL, true), |place| {
            Ok(Shape::Sphere(Sphere::new(place, Vec3::ZERO, 1.0, false)?))
        }),
        body("disk", Form::Flat, |place| Ok(Shape::Disk(Disk::new(place, false)?))),
        body("rectangle", Form::Flat, |place| Ok(Shape::Mesh(Mesh::rectangle(place, false)?))),
        body("cylinder", revolution(0.0, 0.0, 1.0, [0.0, 1.0], false), |place| {
            Ok(Shape::Cylinder(Cylinder::new(place, Vec3::ZERO, Vec3::Z, 1.0, false)?))
        }),
        body("cone", revolution(0.25, 0.0, 0.0, [0.0, 1.0], true), |place| {
            quadric(place, QuadricKind::Cone { from: Vec3::ZERO, to: Vec3::Z, radii: [0.0, 0.5] }, true)
        }),
        body("open frustum", revolution(0.25, 0.15, 0.09, [0.0, 1.0], false), |place| {
            quadric(place, QuadricKind::Cone { from: Vec3::ZERO, to: Vec3::Z, radii: [0.3, 0.8] }, false)
        }),
        body("paraboloid", revolution(0.0, 0.32, 0.0, [0.0, 1.0], true), |place| {
            quadric(place, QuadricKind::Paraboloid { from: Vec3::ZERO, to: Vec3::Z, radius: 0.8 }, true)
        }),
        body("one sheet", revolution(slope * slope, 0.0, 0.16, [-0.8, 0.9], true), |place| {
            quadric(place, hyperboloid(Sheets::One), true)
        }),
        body("two sheets", revolution(slope * slope, 0.0, -0.16, [-0.8, 0.9], true), |place| {
            quadric(place, hyperboloid(Sheets::Two), true)
        }),
        body("saddle", saddle(true), |place| {
            quadric(place, QuadricKind::General { coefficients: SADDLE, clip: SADDLE_CLIP }, true)
        }),
        body("open saddle", saddle(false), |place| {
            quadric(place, QuadricKind::General { coefficients: SADDLE, clip: SADDLE_CLIP }, false)
        }),
        body("torus", Form::Torus { major: 0.7, minor: 0.3 }, |place| {
            Ok(Shape::Torus(Box::new(Torus::new(place, 0.7, 0.3, false)?)))
        }),
        body("thin torus", Form::Torus { major: 1.0, minor: 0.01 }, |place| {
            Ok(Shape::Torus(Box::new(Torus::new(place, 1.0, 0.01, false)?)))
        }),
        body("cube", NO_PLANES, |place| Ok(Shape::Mesh(Mesh::cube(place, false)?))),
        body("icosphere", NO_PLANES, |place| Ok(Shape::Mesh(Mesh::new(icosphere(2).transformed(place))?))),
    ]
}

/// Those of a mesh depend on where it is placed.
const NO_PLANES: Form = Form::Convex { planes: Vec::new(), dent: 0.0 };

/// An icosahedron whose triangles are split in four `levels` times.
pub fn icosphere(levels: u32) -> MeshData {
    let g = (1.0 + 5f64.sqrt()) / 2.0;
    let mut points: Vec<Vec3> = Vec::new();
    for (a, b) in [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)] {
        points
            .extend([Vec3::new(0.0, a, b), Vec3::new(a, b, 0.0), Vec3::new(b, 0.0, a)].map(Vec3::normalize));
    }
    let mut indices = Vec::new();
    let near = |x: Vec3, y: Vec3| x.distance(y) < 1.1;
    for i in 0..12u32 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                let [a, b, c] = [i, j, k].map(|n| points[n as usize]);
                if near(a, b) && near(b, c) && near(c, a) {
                    let outward = (b - a).cross(c - a).dot(a) > 0.0;
                    indices.push(if outward { [i, j, k] } else { [i, k, j] });
                }
            }
        }
    }
    for _ in 0..levels {
        let mut middles = BTreeMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push((points[a as usize] + points[b as usize]).normalize());
                points.len() as u32 - 1
            })
        };
        let quarters = |&[a, b, c]: &[u32; 3]| {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
        };
        indices = indices.iter().flat_map(quarters).collect();
    }
    let positions = points.iter().map(|point| point.as_vec3().to_array()).collect();
    MeshData { positions, indices, ..MeshData::default() }
}

/// Margin, relative to the body, within which an edge or a tangent is too near.
const MARGIN: f64 = 1e-5;

impl Form {
    /// The body of a mesh as it was placed, rounded vertices and all.
    pub fn of_mesh(mesh: &Mesh) -> Self {
        let triangles = (0..mesh.triangle_count() as u32).map(|triangle| mesh.triangle(triangle));
        let plane = |[a, b, c]: [Vec3; 3]| {
            let normal = (b - a).cross(c - a).normalize();
            (normal, normal.dot(a))
        };
        let planes: Vec<(Vec3, f64)> = triangles.clone().map(plane).collect();
        let heights = |vertex: Vec3| planes.iter().map(move |(normal, d)| normal.dot(vertex) - d);
        let dent = triangles.flatten().flat_map(heights).fold(0.0, f64::max);
        Self::Convex { planes, dent }
    }

    /// Where the line from a point of a part along `direction`, whose length is the speed, meets the surface
    /// again.
    pub fn leave(&self, point: Vec3, part: u32, direction: Vec3) -> Truth {
        match self {
            Self::Quadric { a, b, c, clip, solid } => {
                leave_quadric((*a, *b, *c), *clip, *solid, point, part, direction)
            }
            Self::Torus { major, minor } => leave_torus(*major, *minor, point, direction),
            Self::Flat => Truth::Nothing,
            Self::Convex { planes, dent } => leave_convex(planes, *dent, point, part, direction),
        }
    }
}

/// The axis along which a part is a cap, and on which side.
fn cap(part: u32) -> Option<(usize, f64)> {
    match part {
        1..=3 => Some((part as usize - 1, -1.0)),
        4..=6 => Some((part as usize - 4, 1.0)),
        _ => None,
    }
}

fn leave_quadric(
    (a, b, c): (DMat3, Vec3, f64),
    clip: Bounds,
    solid: bool,
    point: Vec3,
    part: u32,
    direction: Vec3,
) -> Truth {
    let speed = direction.length();
    let gradient = |x: Vec3| a * x + b;
    let bend = direction.dot(a * direction);
    let rate = gradient(point).dot(direction);
    let near_plane = |x: Vec3, but: Option<usize>| {
        let near = |axis: usize| {
            (x[axis] - clip.min[axis]).abs() < MARGIN || (x[axis] - clip.max[axis]).abs() < MARGIN
        };
        (0..3).any(|axis| but != Some(axis) && near(axis))
    };
    // At the tip of a cone there is no normal.
    let start = cap(part).map(|(axis, _)| axis);
    if near_plane(point, start) || start.is_none() && gradient(point).length() < 1e-3 {
        return Truth::Unsure;
    }
    // Where it gets out of the box, and by which plane.
    let plane = |axis: usize| {
        let end = if direction[axis] > 0.0 { clip.max[axis] } else { clip.min[axis] };
        let t = (end - point[axis]) / direction[axis];
        (if t.is_nan() || direction[axis] == 0.0 { f64::INFINITY } else { t }, axis)
    };
    let (out, axis) = (0..3).map(plane).min_by(|a, b| a.0.total_cmp(&b.0)).expect("three axes");
    let on_cap = Truth::At { t: out, normal: Vec3::AXES[axis], dent: 0.0 };
    let close = |s: f64, t: f64| ((s - t) * speed).abs() < MARGIN * (1.0 + t.abs() * speed);
    let curved = |t: f64| {
        let there = point + t * direction;
        let normal = gradient(there);
        // It all but touches there, or at an edge.
        let flat = normal.dot(direction).abs() < 3e-5 * normal.length() * speed;
        if flat || near_plane(there, None) || close(t, out) {
            Truth::Unsure
        } else if t < out {
            Truth::At { t, normal, dent: 0.0 }
        } else {
            Truth::Nothing
        }
    };
    if let Some((axis, sign)) = cap(part) {
        if direction[axis] * sign > 0.0 {
            return Truth::Nothing;
        }
        let value = point.dot(a * point + 2.0 * b) + c;
        if value > -1e-4 {
            return Truth::Unsure;
        }
        return match first_above(bend, rate, value).map_or(Truth::Nothing, curved) {
            Truth::Nothing => on_cap,
            truth => truth,
        };
    }
    // The other root of t (bend t + 2 rate).
    let other = -2.0 * rate / bend;
    let met = if other > 0.0 && other.is_finite() { curved(other) } else { Truth::Nothing };
    match met {
        // Inside, with no way out but a cap.
        Truth::Nothing if solid && rate < 0.0 => on_cap,
        truth => truth,
    }
}

/// Within all planes, a line gets out by the nearest of those that it goes towards.
fn leave_convex(planes: &[(Vec3, f64)], dent: f64, point: Vec3, part: u32, direction: Vec3) -> Truth {
    if planes[part as usize].0.dot(direction) > 0.0 {
        return Truth::Nothing;
    }
    let ahead = planes.iter().filter(|(normal, _)| normal.dot(direction) > 0.0);
    let met = ahead.map(|&(normal, d)| ((d - normal.dot(point)) / normal.dot(direction), normal));
    let (t, normal) = met.min_by(|a, b| a.0.total_cmp(&b.0)).expect("a closed mesh");
    Truth::At { t, normal, dent }
}

/// The first t > 0 at which bend t² + 2 rate t + value, which is negative at 0, is not any more.
fn first_above(bend: f64, rate: f64, value: f64) -> Option<f64> {
    let discriminant = rate * rate - bend * value;
    if discriminant < 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    let q = -(rate + root.copysign(rate));
    let roots = [q / bend, value / q];
    let positive = roots.into_iter().filter(|root| *root > 0.0 && root.is_finite());
    positive.min_by(f64::total_cmp)
}

/// With the root at the start divided out, (|x|² + R² − r²)² − 4 R² (x² + y²) leaves a cubic in t.
fn leave_torus(major: f64, minor: f64, point: Vec3, direction: Vec3) -> Truth {
    let speed = direction.length();
    let d = direction / speed;
    // Exactly onto the surface.
    let around = point.with_z(0.0).normalize();
    let from_line = (point - around * major).normalize();
    let p = around * major + from_line * minor;
    let four = 4.0 * major * major;
    let s = p.length_squared() + major * major - minor * minor;
    let b = p.dot(d);
    let coefficients = [
        4.0 * s * b - 2.0 * four * (p.x * d.x + p.y * d.y),
        4.0 * b * b + 2.0 * s - four * (d.x * d.x + d.y * d.y),
        4.0 * b,
        1.0,
    ];
    let value = |t: f64| coefficients.iter().rev().fold(0.0, |sum, c| sum * t + c);
    let [_, c2, c3, _] = coefficients;
    // The extrema of the cubic part the line into stretches with one root at most.
    let discriminant = 4.0 * c3 * c3 - 12.0 * c2;
    let mut edges = vec![0.0];
    if discriminant >= 0.0 {
        let extrema = [-1.0, 1.0].map(|sign| (-2.0 * c3 + sign * discriminant.sqrt()) / 6.0);
        // A line that all but touches.
        if extrema.iter().any(|&t| t > 0.0 && value(t).abs() < 1e-6 * minor) {
            return Truth::Unsure;
        }
        edges.extend(extrema.into_iter().filter(|&t| t > 0.0));
    }
    edges.push(8.0 * (major + minor));
    for pair in edges.windows(2) {
        let [mut low, mut high] = [pair[0], pair[1]];
        if (value(low) > 0.0) == (value(high) > 0.0) {
            continue;
        }
        let rising = value(high) > 0.0;
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if (value(middle) > 0.0) == rising { high = middle } else { low = middle }
        }
        if low < 1e-6 * minor {
            return Truth::Unsure;
        }
        let there = p + low * d;
        let normal = (there - there.with_z(0.0).normalize() * major).normalize();
        let flat = normal.dot(d).abs() < 1e-4;
        return if flat { Truth::Unsure } else { Truth::At { t: low / speed, normal, dent: 0.0 } };
    }
    Truth::Nothing
}
