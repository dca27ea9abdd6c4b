//! Closed shapes with functions that are negative inside them: what tells membership apart from any crossing.

use super::super::{Leaf, Operation, Solid, Tree};
use crate::geometry::{Ray, Transform, Vec3};
use crate::shape::tests::doubled::{Doubled, Polynomial};
use crate::shape::tests::oracle::{Line, near};
use crate::shape::{Mesh, MeshData, Quadric, QuadricKind, Shape, Sheets, Sphere, Torus};
use glam::{DMat4, DQuat};
use std::sync::Arc;

/// A shape where a transform puts it, its normals flipped or not.
pub type Make = Arc<dyn Fn(&Transform, bool) -> Shape + Send + Sync>;

/// A function of a place in the world, negative inside and 0 on the surface.
pub type Depth = Arc<dyn Fn(Vec3) -> f64 + Send + Sync>;

/// A closed shape of a size of about 1 around the origin.
#[derive(Clone)]
pub struct Item {
    pub name: &'static str,
    pub make: Make,
    pub depth: Depth,
    /// Functions along a line that are all negative inside, for what is so thin that only 32 digits can tell.
    pub exact: Option<fn(&Line) -> Vec<Polynomial>>,
}

pub fn turned(angle: f64, stretch: Vec3, position: Vec3) -> Transform {
    let rotation = DQuat::from_axis_angle(Vec3::new(2.0, 1.0, -2.0) / 3.0, angle);
    Transform::new(DMat4::from_scale_rotation_translation(stretch, rotation, position)).unwrap()
}

fn item(
    name: &'static str,
    make: impl Fn(&Transform, bool) -> Shape + Send + Sync + 'static,
    depth: impl Fn(Vec3) -> f64 + Send + Sync + 'static,
) -> Item {
    Item { name, make: Arc::new(make), depth: Arc::new(depth), exact: None }
}

fn quadric(name: &'static str, kind: QuadricKind, depth: fn(Vec3) -> f64) -> Item {
    let make = move |place: &Transform, flip| {
        Shape::Quadric(Box::new(Quadric::of_kind(place, &kind, true, flip).unwrap()))
    };
    item(name, make, depth)
}

fn mesh(data: &MeshData, place: &Transform, flip: bool) -> Shape {
    let placed = MeshData { normals: None, flip_normals: flip, ..data.transformed(place) };
    Shape::Mesh(Mesh::part(data, place, placed).unwrap())
}

fn box_depth(p: Vec3, low: Vec3, high: Vec3) -> f64 {
    (low - p).max(p - high).max_element()
}

/// Negative where a coordinate is between -1 and 1.
fn between_ones(coordinate: &Polynomial) -> [Polynomial; 2] {
    let one = Polynomial::constant(1.0);
    [&Polynomial::constant(-1.0) - coordinate, coordinate - &one]
}

/// A prism of height 2 along z over an L.
fn angle_iron() -> MeshData {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 0.0], [0.0, 0.0], [0.0, 1.0], [-1.0, 1.0]];
    let at = |z: f32| corners.map(|[x, y]: [f32; 2]| [x, y, z]);
    let mut indices = vec![[6, 7, 8], [6, 8, 9], [6, 9, 10], [6, 10, 11]];
    indices.extend([[2, 1, 0], [3, 2, 0], [4, 3, 0], [5, 4, 0]]);
    for i in 0..6 {
        let next = (i + 1) % 6;
        indices.extend([[i, next, next + 6], [i, next + 6, i + 6]]);
    }
    MeshData { positions: [at(-1.0), at(1.0)].concat(), indices, ..MeshData::default() }
}

fn icosahedron() -> MeshData {
    let g = 0.5 * (1.0 + 5f32.sqrt());
    let mut positions = Vec::new();
    for [a, b] in [[1.0, g], [-1.0, g], [1.0, -g], [-1.0, -g]] {
        positions.extend([[0.0, a, b], [b, 0.0, a], [a, b, 0.0]].map(|p: [f32; 3]| p.map(|x| 0.6 * x)));
    }
    let at = |i: usize| Vec3::from_array(positions[i].map(f64::from));
    // The faces are all triples at the shortest distance from one another.
    let edge = 1.2001;
    let mut indices = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if [(a, b), (b, c), (c, a)].iter().all(|&(i, j)| at(i).distance(at(j)) < edge) {
                    let outward = (at(b) - at(a)).cross(at(c) - at(a)).dot(at(a)) > 0.0;
                    let face = if outward { [a, b, c] } else { [a, c, b] };
                    indices.push(face.map(|i| i as u32));
                }
            }
        }
    }
    assert_eq!(indices.len(), 20);
    MeshData { positions, indices, ..MeshData::default() }
}

/// The largest distance from the plane of any face.
fn convex_depth(data: &MeshData) -> impl Fn(Vec3) -> f64 + use<> {
    let at = |i: u32| Vec3::from_array(data.positions[i as usize].map(f64::from));
    let planes: Vec<(Vec3, f64)> = data
        .indices
        .iter()
        .map(|face| {
            let [a, b, c] = face.map(at);
            let normal = (b - a).cross(c - a).normalize();
            (normal, normal.dot(a))
        })
        .collect();
    move |p| planes.iter().map(|(normal, offset)| normal.dot(p) - offset).fold(f64::MIN, f64::max)
}

pub fn cube() -> Item {
    let make = |place: &Transform, flip| {
        let cube = MeshData { normals: None, ..MeshData::cube(false) };
        mesh(&cube, place, flip)
    };
    let exact = |line: &Line| line.0.iter().flat_map(between_ones).collect();
    Item { exact: Some(exact), ..item("cube", make, |p| box_depth(p, -Vec3::ONE, Vec3::ONE)) }
}

/// From z = -1 to z = 1, of radius 1.
pub fn cylinder() -> Item {
    let kind = QuadricKind::Cone { from: -Vec3::Z, to: Vec3::Z, radii: [1.0; 2] };
    let exact = |line: &Line| {
        let [x, y, z] = &line.0;
        let [bottom, top] = between_ones(z);
        vec![&(&(x * x) + &(y * y)) - &Polynomial::constant(1.0), bottom, top]
    };
    let depth = |p: Vec3| (p.x * p.x + p.y * p.y - 1.0).max(p.z.abs() - 1.0);
    Item { exact: Some(exact), ..quadric("cylinder", kind, depth) }
}

pub fn sphere() -> Item {
    let make = |place: &Transform, flip| Shape::Sphere(Sphere::new(place, Vec3::ZERO, 1.0, flip).unwrap());
    item("sphere", make, |p| p.length_squared() - 1.0)
}

pub fn all() -> Vec<Item> {
    let cone = QuadricKind::Cone { from: -Vec3::Z, to: Vec3::Z, radii: [1.0, 0.0] };
    let frustum = QuadricKind::Cone { from: -Vec3::Z, to: Vec3::Z, radii: [0.4, 1.0] };
    let waist =
        QuadricKind::Hyperboloid { sheets: Sheets::One, radius: 0.5, semi_axis: 0.6, heights: [-1.0, 0.9] };
    let sheets =
        QuadricKind::Hyperboloid { sheets: Sheets::Two, radius: 0.4, semi_axis: 0.3, heights: [-1.0, 0.9] };
    let saddle = QuadricKind::General {
        coefficients: [1.0, -1.0, 0.0, 0.25, 0.0, 0.125, 0.0, 0.125, -1.0, 0.0],
        clip: crate::geometry::Bounds { min: Vec3::new(-1.0, -0.75, -0.5), max: Vec3::new(0.75, 1.0, 0.75) },
    };
    let iron = angle_iron();
    let ball = icosahedron();
    let ball_depth = convex_depth(&ball);
    vec![
        sphere(),
        cylinder(),
        quadric("cone", cone, |p| {
            let radius = 0.5 * (1.0 - p.z);
            (p.x * p.x + p.y * p.y - radius * radius).max(p.z.abs() - 1.0)
        }),
        quadric("frustum", frustum, |p| {
            let radius = 0.7 + 0.3 * p.z;
            (p.x * p.x + p.y * p.y - radius * radius).max(p.z.abs() - 1.0)
        }),
        quadric("waist", waist, |p| {
            let value = (p.x * p.x + p.y * p.y) / 0.25 - p.z * p.z / 0.36 - 1.0;
            value.max(box_depth(p.with_x(0.0).with_y(0.0), -Vec3::ONE, Vec3::new(1.0, 1.0, 0.9)))
        }),
        quadric("two sheets", sheets, |p| {
            let value = (p.x * p.x + p.y * p.y) / 0.16 - p.z * p.z / 0.09 + 1.0;
            value.max(box_depth(p.with_x(0.0).with_y(0.0), -Vec3::ONE, Vec3::new(1.0, 1.0, 0.9)))
        }),
        quadric("saddle", saddle, |p| {
            let value = p.x * p.x - p.y * p.y + 0.25 * p.x * p.y + 0.125 * p.y * p.z + 0.125 * p.y - p.z;
            value.max(box_depth(p, Vec3::new(-1.0, -0.75, -0.5), Vec3::new(0.75, 1.0, 0.75)))
        }),
        item(
            "torus",
            |place, flip| Shape::Torus(Box::new(Torus::new(place, 0.75, 0.25, flip).unwrap())),
            |p| (p.x.hypot(p.y) - 0.75).hypot(p.z) - 0.25,
        ),
        cube(),
        item(
            "angle iron",
            move |place, flip| mesh(&iron, place, flip),
            |p| {
                let long = box_depth(p, -Vec3::ONE, Vec3::new(1.0, 0.0, 1.0));
                long.min(box_depth(p, -Vec3::ONE, Vec3::new(0.0, 1.0, 1.0)))
            },
        ),
        item("icosahedron", move |place, flip| mesh(&ball, place, flip), ball_depth),
    ]
}

impl Operation {
    /// Combines functions that are negative inside: union is their minimum, intersection their maximum.
    fn put_together(self, first: f64, others: impl Iterator<Item = f64>) -> f64 {
        match self {
            Self::Union => others.fold(first, f64::min),
            Self::Intersection => others.fold(first, f64::max),
            Self::Difference => others.fold(first, |depth, other| depth.max(-other)),
        }
    }
}

/// A tree of shapes and the same of functions.
#[derive(Clone)]
#[expect(clippy::large_enum_variant, reason = "a tree is small")]
pub enum Model {
    Leaf(Item, Transform),
    Node(Operation, Vec<Model>),
}

impl Model {
    pub fn solid(&self) -> Solid {
        Solid::new(self.tree(false, &mut 0), [0.0; 2])
    }

    fn tree(&self, subtracted: bool, count: &mut u32) -> Tree {
        match self {
            Self::Leaf(item, place) => {
                let (shape, index) = ((item.make)(place, subtracted), *count);
                assert_eq!(shape.is_closed(), Ok(()), "{}", item.name);
                *count += 1;
                Tree::Leaf(Leaf { shape, index, carried: None })
            }
            Self::Node(operation, parts) => {
                let part = |(number, part): (usize, &Self)| {
                    let cuts = *operation == Operation::Difference && number > 0;
                    part.tree(subtracted != cuts, count)
                };
                Tree::Node(*operation, parts.iter().enumerate().map(part).collect())
            }
        }
    }

    /// What the functions are at a place on a line, by 32 digits, where all parts have them.
    pub fn exact_depth(&self, ray: &Ray, t: f64) -> Option<f64> {
        match self {
            Self::Leaf(item, place) => {
                let at = Doubled::from(t) - near(ray).into();
                let functions = (item.exact?)(&Line::new(ray, place));
                functions.iter().map(|function| function.at(at).high).reduce(f64::max)
            }
            Self::Node(operation, parts) => {
                let parts: Option<Vec<f64>> = parts.iter().map(|part| part.exact_depth(ray, t)).collect();
                let parts = parts?;
                Some(operation.put_together(parts[0], parts[1..].iter().copied()))
            }
        }
    }

    /// The functions put together.
    pub fn depth(&self) -> Depth {
        match self {
            Self::Leaf(item, place) => {
                let (depth, to_local) = (item.depth.clone(), place.inverse());
                Arc::new(move |p| depth(to_local.point(p)))
            }
            Self::Node(operation, parts) => {
                let (operation, parts) = (*operation, parts.iter().map(Self::depth).collect::<Vec<_>>());
                Arc::new(move |p| {
                    let first = parts[0](p);
                    operation.put_together(first, parts[1..].iter().map(|part| part(p)))
                })
            }
        }
    }
}
