//! Tests over all shapes.

mod apart;
mod curves;
pub(super) mod doubled;
mod grid_shapes;
mod heightfields;
mod leaving;
pub(super) mod oracle;
mod patches;
mod profile_or_implicit;
mod quadrics;
mod sampling;
mod sdfgrids;
mod tori;
mod worked;

use super::{
    CurveKind, Cylinder, Disk, GridShape, HeightField, Mesh, MeshData, Parametrisation, Patches,
    ProfileOrImplicit, Quadric, QuadricKind, SdfGrid, Shape, ShapeError, Sheets, Sphere, Torus,
};
use crate::geometry::{Bounds, Ray, SurfacePoint, Transform, Vec3};
use glam::{DMat4, DQuat};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg as Random;
use std::collections::BTreeMap;
use std::f64::consts::PI;

fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance
}

fn near(a: Vec3, b: Vec3, tolerance: f64) -> bool {
    (a - b).abs().max_element() <= tolerance
}

fn unit_sphere() -> Sphere {
    Sphere::new(&Transform::IDENTITY, Vec3::ZERO, 1.0, false).unwrap()
}

fn direction(random: &mut Random) -> Vec3 {
    let z: f64 = random.random_range(-1.0..1.0);
    let (sin, cos) = random.random_range(0.0..2.0 * PI).sin_cos();
    let r = (1.0 - z * z).sqrt();
    Vec3::new(r * cos, r * sin, z)
}

fn placement(stretch: Vec3) -> Transform {
    let rotation = DQuat::from_axis_angle(Vec3::new(1.0, 2.0, 2.0) / 3.0, 0.7);
    let mut shear = DMat4::IDENTITY;
    if stretch.x != stretch.y {
        shear.y_axis.x = 0.4;
    }
    let place = DMat4::from_scale_rotation_translation(stretch, rotation, Vec3::new(0.2, -0.4, 0.3));
    Transform::new(place * shear).unwrap()
}

/// An icosahedron whose triangles are split in four `levels` times.
pub(crate) fn icosphere(levels: u32) -> MeshData {
    let g = (1.0 + 5f64.sqrt()) / 2.0;
    let mut points: Vec<Vec3> = Vec::new();
    for (a, b) in [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)] {
        points
            .extend([Vec3::new(0.0, a, b), Vec3::new(a, b, 0.0), Vec3::new(b, 0.0, a)].map(Vec3::normalize));
    }
    let mut indices = Vec::new();
    for i in 0..12u32 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                let [a, b, c] = [i, j, k].map(|n| points[n as usize]);
                let edge = |x: Vec3, y: Vec3| x.distance(y) < 1.1;
                if edge(a, b) && edge(b, c) && edge(c, a) {
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
        indices = indices
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    let positions = points.iter().map(|point| point.as_vec3().to_array()).collect();
    MeshData { positions, indices, ..MeshData::default() }
}

/// One of everything, with a name for messages.
fn all_shapes() -> Vec<(&'static str, Shape)> {
    let (similar, skew) = (placement(Vec3::splat(0.7)), placement(Vec3::new(0.9, 0.5, 0.3)));
    let sphere = |place| Shape::Sphere(Sphere::new(place, Vec3::new(0.1, 0.0, 0.2), 0.8, false).unwrap());
    let cylinder = |place| {
        Shape::Cylinder(
            Cylinder::new(place, Vec3::new(-0.5, 0.1, 0.0), Vec3::new(0.4, 0.3, 0.6), 0.4, false).unwrap(),
        )
    };
    let torus = |place: &Transform, major, minor| {
        Shape::Torus(Box::new(Torus::new(place, major, minor, false).unwrap()))
    };
    let quadric = |place: &Transform, kind: &QuadricKind, solid| {
        Shape::Quadric(Box::new(Quadric::of_kind(place, kind, solid, false).unwrap()))
    };
    let cone = |place: &Transform, radii, solid| {
        let (from, to) = (Vec3::new(-0.5, 0.1, 0.0), Vec3::new(0.4, 0.3, 0.6));
        quadric(place, &QuadricKind::Cone { from, to, radii }, solid)
    };
    let two_sheets =
        QuadricKind::Hyperboloid { sheets: Sheets::Two, radius: 0.3, semi_axis: 0.25, heights: [-0.7, 0.8] };
    // z = x² − y², tilted and cut off on all sides.
    let saddle = QuadricKind::General {
        coefficients: [1.0, -1.0, 0.0, 0.25, 0.0, 0.125, 0.0, 0.125, -1.0, 0.0],
        clip: Bounds { min: Vec3::new(-1.0, -0.75, -0.5), max: Vec3::new(0.75, 1.0, 0.75) },
    };
    let rectangle = placement(Vec3::new(0.8, 0.8, 1.0)).then(&Transform::IDENTITY);
    let uneven = MeshData {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.1], [1.0, 1.1, 0.3], [5.0, 0.2, 0.1]],
        indices: vec![[0, 1, 2], [2, 1, 3], [0, 0, 1], [1, 4, 3]],
        ..MeshData::default()
    };
    let distances = |place: &Transform, smooth| {
        Shape::Grid(Box::new(GridShape::Distances(
            SdfGrid::new(place, sdfgrids::ball(8), smooth, false).unwrap(),
        )))
    };
    let heights = |place: &Transform, base| {
        Shape::Grid(Box::new(GridShape::Heights(
            HeightField::new(place, heightfields::hills([9, 7]), 0.5, base, false, false).unwrap(),
        )))
    };
    let patch = |place: &Transform, wanted| {
        let found = patches::kinds().into_iter().find(|(name, _)| *name == wanted);
        Shape::Patches(Patches::new(place, &[found.unwrap().1], false).unwrap())
    };
    let shapes_of_kinds = profile_or_implicit::kinds().into_iter().enumerate().map(|(i, (name, kind))| {
        let place = if i % 2 == 0 { &similar } else { &skew };
        (name, Shape::ProfileOrImplicit(Box::new(ProfileOrImplicit::new(place, &kind, false).unwrap())))
    });
    let mut shapes: Vec<(&'static str, Shape)> = shapes_of_kinds.collect();
    shapes.extend([
        ("sphere", sphere(&similar)),
        ("ellipsoid", sphere(&skew)),
        ("disk", Shape::Disk(Disk::new(&similar, false).unwrap())),
        ("ellipse", Shape::Disk(Disk::new(&skew, false).unwrap())),
        ("cylinder", cylinder(&similar)),
        ("sheared cylinder", cylinder(&skew)),
        ("cone", cone(&similar, [0.8, 0.0], true)),
        ("sheared open frustum", cone(&skew, [0.3, 0.7], false)),
        ("two sheets", quadric(&similar, &two_sheets, true)),
        ("sheared saddle", quadric(&skew, &saddle, true)),
        ("sheared open saddle", quadric(&skew, &saddle, false)),
        ("torus", torus(&similar, 0.6, 0.25)),
        ("sheared torus", torus(&skew, 0.7, 0.3)),
        ("distances", distances(&similar, true)),
        ("sheared distances", distances(&skew, false)),
        ("swept sphere", curves::swept(&similar, CurveKind::Linear)),
        ("sheared swept sphere", curves::swept(&skew, CurveKind::BSpline)),
        ("heights", heights(&skew, None)),
        ("solid heights", heights(&similar, Some(-0.75))),
        ("patch", patch(&similar, "sail")),
        ("sheared patch", patch(&skew, "lid")),
        ("rectangle", Shape::Mesh(Mesh::rectangle(&rectangle, false).unwrap())),
        ("parallelogram", Shape::Mesh(Mesh::rectangle(&skew, false).unwrap())),
        ("cube", Shape::Mesh(Mesh::cube(&skew, false).unwrap())),
        ("uneven mesh", Shape::Mesh(Mesh::new(uneven).unwrap())),
    ]);
    shapes
}

/// Whether its points are those of chords, or are chosen among others, so that some `u` have none.
fn by_random_lines(shape: &Shape) -> bool {
    match shape {
        Shape::Quadric(_) | Shape::Patches(_) | Shape::SweptSphere(_) => true,
        Shape::ProfileOrImplicit(inner) => inner.is_curved(),
        Shape::Grid(sampled) => matches!(**sampled, GridShape::Distances(_)),
        _ => false,
    }
}

/// The distance is right to 1e-9 of the radius, not only of itself.
#[test]
fn distant_sphere_is_hit_precisely() {
    let mut random = Random::seed_from_u64(1);
    for _ in 0..100_000 {
        let axis = direction(&mut random);
        let across = axis.any_orthonormal_vector();
        let height = random.random_range(-0.999..0.999);
        // Offset and direction chosen so that the exact distance is known.
        let ray = Ray::new(axis * 1e6 + across * height, -axis);
        let t = unit_sphere().intersect(&ray).unwrap();
        // The computed origin's own height and distance, by exact differences.
        let along = ray.origin.dot(axis);
        let off = ray.origin.reject_from(axis).length();
        let expected = along - (1.0 - off * off).sqrt();
        assert!(close(t, expected, 4e-9), "{t} {expected}");
        assert!(close(t / expected, 1.0, 1e-9));
        let position = unit_sphere().surface(ray.at(t)).point.position;
        assert!(close(position.length(), 1.0, 1e-15));
    }
}

#[test]
fn tangents_and_parallels_miss() {
    let sphere = unit_sphere();
    assert_eq!(sphere.intersect(&Ray::new(Vec3::new(-2.0, 1.0, 0.0), Vec3::X)), None);
    let tube = Cylinder::new(&Transform::IDENTITY, Vec3::ZERO, Vec3::Z, 1.0, false).unwrap();
    for origin in [Vec3::ZERO, Vec3::X, Vec3::new(0.3, 0.2, -5.0)] {
        assert_eq!(tube.intersect(&Ray::new(origin, Vec3::Z)), None);
        assert_eq!(tube.intersect(&Ray::new(origin, -Vec3::Z)), None);
    }
    // Over the rim, onto the far wall from within.
    let hit = tube.intersect(&Ray::new(Vec3::new(-2.0, 0.0, 1.5), Vec3::new(3.0, 0.0, -1.0).normalize()));
    assert!(close(hit.unwrap(), 10f64.sqrt(), 1e-14));
}

/// What Mitsuba 3.9.1 (scalar_rgb) answers to the same rays.
#[test]
fn conventions_are_those_of_mitsuba() {
    let mirror = Transform::new(DMat4::from_scale(Vec3::new(-1.0, 1.0, 1.0))).unwrap();
    let down = Ray::new(Vec3::new(0.3, 0.2, 5.0), -Vec3::Z);
    let sideways = Ray::new(Vec3::new(0.3, 5.0, 0.4), -Vec3::Y);
    let sphere = |place, flip| Shape::Sphere(Sphere::new(place, Vec3::ZERO, 1.0, flip).unwrap());
    let disk = |place, flip| Shape::Disk(Disk::new(place, flip).unwrap());
    let tube = |place, flip| Shape::Cylinder(Cylinder::new(place, Vec3::ZERO, Vec3::Z, 1.0, flip).unwrap());
    let square = |place, flip| Shape::Mesh(Mesh::rectangle(place, flip).unwrap());
    let cube = |place, flip| Shape::Mesh(Mesh::cube(place, flip).unwrap());
    let id = Transform::IDENTITY;
    let (out, side) = (Vec3::new(0.3, 0.2, 0.9327), Vec3::new(0.3, 0.9539, 0.0));
    let cases = [
        (sphere(&id, false), &down, out, [0.0936, 0.1174], [-1.2566, 1.885, 0.0]),
        (sphere(&id, true), &down, -out, [0.0936, 0.1174], [-1.2566, 1.885, 0.0]),
        (sphere(&mirror, false), &down, -out, [0.4064, 0.1174], [1.2566, -1.885, 0.0]),
        (sphere(&mirror, true), &down, out, [0.4064, 0.1174], [1.2566, -1.885, 0.0]),
        (disk(&id, false), &down, Vec3::Z, [0.3606, 0.0936], [0.8321, 0.5547, 0.0]),
        (disk(&id, true), &down, -Vec3::Z, [0.3606, 0.0936], [0.8321, 0.5547, 0.0]),
        (disk(&mirror, false), &down, Vec3::Z, [0.3606, 0.4064], [0.8321, 0.5547, 0.0]),
        (tube(&id, false), &sideways, side, [0.2015, 0.4], [-5.9938, 1.885, 0.0]),
        (tube(&id, true), &sideways, -side, [0.2015, 0.4], [-5.9938, 1.885, 0.0]),
        (tube(&mirror, false), &sideways, side, [0.2985, 0.4], [5.9938, -1.885, 0.0]),
        (square(&id, false), &down, Vec3::Z, [0.65, 0.6], [2.0, 0.0, 0.0]),
        (square(&id, true), &down, -Vec3::Z, [0.65, 0.6], [2.0, 0.0, 0.0]),
        (square(&mirror, false), &down, Vec3::Z, [0.35, 0.6], [-2.0, 0.0, 0.0]),
        (cube(&id, false), &down, Vec3::Z, [0.6, 0.65], [0.0, 2.0, 0.0]),
        (cube(&id, true), &down, -Vec3::Z, [0.6, 0.65], [0.0, 2.0, 0.0]),
        (cube(&mirror, false), &down, Vec3::Z, [0.6, 0.35], [0.0, 2.0, 0.0]),
    ];
    for (i, (shape, ray, normal, uv, tangent)) in cases.into_iter().enumerate() {
        let hit = shape.intersect(ray).unwrap();
        let found = shape.surface(&hit, ray);
        let coordinates = shape.parametrisation(&hit, found.point.position);
        assert!(near(found.point.normal, normal, 1e-4), "case {i}: {found:?}");
        assert!(near(found.shading_normal, normal, 1e-4), "case {i}: {found:?}");
        let [u, v] = coordinates.uv;
        assert!(close(u, uv[0], 1e-4) && close(v, uv[1], 1e-4), "case {i}: {coordinates:?}");
        assert!(near(coordinates.tangent, Vec3::from_array(tangent), 1e-4), "case {i}: {coordinates:?}");
    }
    // A triangle with normals and no coordinates: these are where its vertices are, mirrored or not.
    let data = MeshData {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        indices: vec![[0, 1, 2]],
        normals: Some(vec![[0.0, 0.0, 1.0]; 3]),
        ..MeshData::default()
    };
    for (place, x) in [(id, 1.0), (mirror, -1.0)] {
        let mesh = Shape::Mesh(Mesh::new(data.transformed(&place)).unwrap());
        let ray = Ray::new(Vec3::new(0.3 * x, 0.2, 5.0), -Vec3::Z);
        let hit = mesh.intersect(&ray).unwrap();
        let found = mesh.surface(&hit, &ray).point;
        let Parametrisation { uv: [u, v], tangent, bitangent } = mesh.parametrisation(&hit, found.position);
        assert!(close(u, 0.3, 1e-7) && close(v, 0.2, 1e-7), "{u} {v}");
        assert_eq!([found.normal, tangent, bitangent], [Vec3::Z, Vec3::X * x, Vec3::Y]);
    }
    // A tetrahedron without normals: smooth, and inside out when mirrored.
    let data = MeshData {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        indices: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        ..MeshData::default()
    };
    for (place, x, shading) in
        [(id, 0.1, Vec3::new(-0.2666, -0.0618, 0.9618)), (mirror, -0.1, Vec3::new(-0.2666, 0.0618, -0.9618))]
    {
        let mut data = data.transformed(&place);
        data.normals = Some(super::compute_vertex_normals(&data.positions, &data.indices));
        let mesh = Shape::Mesh(Mesh::new(data).unwrap());
        let ray = Ray::new(Vec3::new(x, 0.2, 5.0), -Vec3::Z);
        let hit = mesh.intersect(&ray).unwrap();
        let found = mesh.surface(&hit, &ray);
        let [u, v] = mesh.parametrisation(&hit, found.point.position).uv;
        let face =
            Vec3::splat(1.0 / 3f64.sqrt()) * if place == id { Vec3::ONE } else { Vec3::new(1.0, -1.0, -1.0) };
        assert!(near(found.point.normal, face, 1e-7), "{found:?}");
        assert!(near(found.shading_normal, shading, 1e-4), "{found:?}");
        assert!(close(u, 0.2, 1e-7) && close(v, 0.7, 1e-7), "{u} {v}");
    }
}

/// The reported error covers how far points lie off the surface, and grows with nothing else.
#[test]
fn points_lie_within_their_error() {
    let mut random = Random::seed_from_u64(2);
    for (name, shape) in all_shapes() {
        for _ in 0..2_000 {
            let Some(sample) = shape.sample([random.random(), random.random()]) else { continue };
            let SurfacePoint { position, normal, error } = sample.surface.point;
            assert!(error > 0.0 && error < 1e-12, "{name}: {error}");
            // A ray along the normal from close by finds the surface where the point is.
            let start = position + normal * 1e-3;
            let ray = Ray::new(start, -normal);
            let Some(hit) = shape.intersect(&ray) else { continue };
            // In a corner another piece may be nearer.
            if shape.surface(&hit, &ray).point.normal.dot(normal) < 0.9 {
                continue;
            }
            assert!((hit.t - 1e-3).abs() <= error, "{name}: off by {}, error {error}", hit.t - 1e-3);
        }
    }
}

#[test]
fn bounds_are_tight_and_hold() {
    let mut random = Random::seed_from_u64(3);
    for (name, shape) in all_shapes() {
        let bounds = shape.bounds();
        let mut seen = crate::geometry::Bounds::EMPTY;
        for _ in 0..20_000 {
            if let Some(sample) = shape.sample([random.random(), random.random()]) {
                seen = seen.including(sample.surface.point.position);
            }
        }
        let slack = 1e-14;
        assert!((seen.min - bounds.min).min_element() > -slack, "{name}");
        assert!((bounds.max - seen.max).min_element() > -slack, "{name}");
        let gap = (seen.min - bounds.min).max_element().max((bounds.max - seen.max).max_element());
        assert!(gap < 0.05 * bounds.diameter(), "{name}: loose by {gap}");
    }
}

#[test]
fn bad_input_is_an_error() {
    let id = Transform::IDENTITY;
    for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(Sphere::new(&id, Vec3::ZERO, radius, false), Err(ShapeError::Radius(_))));
        assert!(matches!(Cylinder::new(&id, Vec3::ZERO, Vec3::Z, radius, false), Err(ShapeError::Radius(_))));
    }
    assert_eq!(Cylinder::new(&id, Vec3::X, Vec3::X, 1.0, false).err(), Some(ShapeError::Ends));
    let good = MeshData { positions: vec![[0.0; 3]; 3], indices: vec![[0, 1, 2]], ..MeshData::default() };
    assert!(Mesh::new(good.clone()).is_ok());
    let mut bad = good.clone();
    bad.indices[0][1] = 3;
    assert_eq!(Mesh::new(bad).err(), Some(ShapeError::VertexIndex { triangle: 0, index: 3, vertices: 3 }));
    let mut bad = good.clone();
    bad.positions[2][0] = f32::NAN;
    assert_eq!(Mesh::new(bad).err(), Some(ShapeError::NotFinite { attribute: "position", vertex: 2 }));
    let bad = MeshData { uvs: Some(vec![[0.0; 2]]), ..good };
    let expected = ShapeError::AttributeCount { attribute: "uv", found: 1, vertices: 3 };
    assert_eq!(Mesh::new(bad).err(), Some(expected));
    assert!(Mesh::new(MeshData::default()).unwrap().sample([0.5; 2]).is_none());
}
