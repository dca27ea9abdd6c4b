//! The worked examples of the source texts (Glassner, *An Introduction to Ray Tracing*, ch. 2), their values
//! recomputed.

use super::{close, near, unit_sphere};
use crate::geometry::roots::quadratic;
use crate::geometry::{Bounds, Ray, Transform, Vec3};
use crate::shape::{Disk, Mesh, MeshData, Patches, Quadric, QuadricKind, Shape, Sphere};
use glam::{DMat4, DQuat};
use std::f64::consts::PI;

/// Book example (Glassner ch. 2, 2.1): exact values recomputed.
#[test]
fn a_sphere() {
    let sphere = Sphere::new(&Transform::IDENTITY, Vec3::new(3.0, 0.0, 5.0), 3.0, false).unwrap();
    let ray = Ray::new(Vec3::new(1.0, -2.0, -1.0), Vec3::new(1.0, 2.0, 4.0) / 21f64.sqrt());
    let t = sphere.intersect(&ray).unwrap();
    assert!(close(t, 3.7434771542, 1e-9), "{t}");
    let point = sphere.surface(ray.at(t)).point;
    assert!(near(point.position, Vec3::new(1.8168936867, -0.3662126265, 2.2675747469), 1e-9));
    assert!(near(point.normal, Vec3::new(-0.3943687711, -0.1220708755, -0.9108084177), 1e-9));
    // From within, the far root is what is left.
    let inside = Ray::new(ray.at(5.0), ray.direction);
    assert!(close(sphere.intersect(&inside).unwrap(), 9.3495962600 - 5.0, 1e-9));
}

/// Book example (Glassner ch. 2, 3.1): the plane x = 7, here a disk that faces -x.
#[test]
fn a_plane() {
    let turn = DMat4::from_rotation_y(-PI / 2.0);
    let place = DMat4::from_translation(Vec3::new(7.0, 8.0, 9.0)) * turn;
    let disk = Disk::new(&Transform::new(place).unwrap(), false).unwrap();
    let ray = Ray::new(Vec3::new(2.0, 3.0, 4.0), Vec3::ONE.normalize());
    let t = disk.intersect(&ray).unwrap();
    assert!(close(t, 5.0 * 3f64.sqrt(), 1e-14), "{t}");
    let point = disk.surface(ray.at(t)).point;
    assert!(near(point.position, Vec3::new(7.0, 8.0, 9.0), 1e-14));
    assert!(near(point.normal, -Vec3::X, 1e-15));
    assert_eq!(disk.intersect(&Ray::new(ray.origin, Vec3::Y)), None);
}

/// An ellipsoid is the image of a sphere: hits, points and normals fit its implicit equation.
#[test]
fn an_ellipsoid() {
    // Book example (Glassner ch. 2, 5.1): centre (6, 9, -2), semi-axes 12, 24, 8.
    let place = DMat4::from_scale_rotation_translation(
        Vec3::new(12.0, 24.0, 8.0),
        DQuat::IDENTITY,
        Vec3::new(6.0, 9.0, -2.0),
    );
    let ellipsoid = Sphere::new(&Transform::new(place).unwrap(), Vec3::ZERO, 1.0, false).unwrap();
    let ray = Ray::new(Vec3::new(4.0, 5.0, -3.0), Vec3::new(1.0, 1.0, -1.0) / 3f64.sqrt());
    let t = ellipsoid.intersect(&ray).unwrap();
    assert!(close(t, 11.0847251492, 1e-9), "{t}");
    let point = ellipsoid.surface(ray.at(t)).point;
    assert!(near(point.position, Vec3::new(10.3997690488, 11.3997690488, -9.3997690488), 1e-9));
    assert!(near(point.normal, Vec3::new(0.2553335, 0.0348167, -0.9662259), 1e-7));
}

/// The same by its ten coefficients (5.1): 4X² − 48X + Y² − 18Y + 9Z² + 36Z − 315 = 0.
#[test]
fn a_quadric() {
    let coefficients = [4.0, 1.0, 9.0, 0.0, 0.0, 0.0, -48.0, -18.0, 36.0, -315.0];
    let kind =
        QuadricKind::General { coefficients, clip: Bounds { min: Vec3::NEG_INFINITY, max: Vec3::INFINITY } };
    let shape =
        Shape::Quadric(Box::new(Quadric::of_kind(&Transform::IDENTITY, &kind, false, false).unwrap()));
    let ray = Ray::new(Vec3::new(4.0, 5.0, -3.0), Vec3::new(1.0, 1.0, -1.0) / 3f64.sqrt());
    let crossings = shape.crossings(&ray);
    let [behind, ahead] = crossings[..] else { panic!("{crossings:?}") };
    assert!(close(behind.hit.t, -10.3424176603, 1e-9) && behind.enters, "{behind:?}");
    assert!(close(ahead.hit.t, 11.0847251492, 1e-9) && !ahead.enters, "{ahead:?}");
    let point = shape.surface(&ahead.hit, &ray).point;
    assert!(near(point.position, Vec3::new(10.3997690488, 11.3997690488, -9.3997690488), 1e-9));
    assert!(near(point.normal, Vec3::new(0.2553335, 0.0348167, -0.9662259), 1e-7));
    assert!(close(point.normal.dot(ray.direction), 0.7253691, 1e-7));
    // Aq t² + Bq t + Cq, as the example computes it.
    let roots = quadratic(14.0 / 3.0, -2.0 * 3f64.sqrt(), -535.0);
    assert!(close(roots[0].t, behind.hit.t, 1e-9) && close(roots[1].t, ahead.hit.t, 1e-9));
    assert!(close(shape.bounds().min.y, 9.0 - 24.0, 1e-12) && close(shape.bounds().max.x, 18.0, 1e-12));
}

/// Inverse mapping of a sphere (2.5). There v grows from the south pole, here from the north.
#[test]
fn where_on_a_sphere() {
    let normal = Vec3::new(1.0, -1.0, 1.0) / 3f64.sqrt();
    let [u, v] = unit_sphere().parametrisation(normal).uv;
    assert!(close(u, 0.875, 1e-12) && close(v, 1.0 - 0.6959132760, 1e-9), "{u} {v}");
    assert!(close((1.0 - v) * PI, 2.1862760355, 1e-9));
}

/// The triangle that the point (-2, -2, 4) of its plane x + 2y + z + 2 = 0 lies outside of (3.2).
#[test]
fn a_polygon() {
    let corners = [[-3.0, -3.0, 7.0], [3.0, -4.0, 3.0], [4.0, -5.0, 4.0]];
    let plane = |p: Vec3| p.dot(Vec3::new(1.0, 2.0, 1.0)) + 2.0;
    assert!(
        corners.iter().all(|c| plane(Vec3::from_array(*c)) == 0.0)
            && plane(Vec3::new(-2.0, -2.0, 4.0)) == 0.0
    );
    let data = MeshData {
        positions: corners.iter().map(|c| c.map(|x| x as f32)).collect(),
        indices: vec![[0, 1, 2]],
        ..MeshData::default()
    };
    let triangle = Shape::Mesh(Mesh::new(data).unwrap());
    let normal = Vec3::new(1.0, 2.0, 1.0).normalize();
    let through = |point: Vec3| triangle.crossings(&Ray::new(point + normal * 3.0, -normal));
    assert!(through(Vec3::new(-2.0, -2.0, 4.0)).is_empty());
    let centre = corners.iter().fold(Vec3::ZERO, |sum, c| sum + Vec3::from_array(*c)) / 3.0;
    let [inside] = through(centre)[..] else { panic!("the centre is missed") };
    assert!(close(inside.hit.t, 3.0, 1e-12));
}

/// Where (-2, -1, 4) is on a quadrilateral (3.3): u = 7/11 (the other root is 3) and v = 3/13.
#[test]
fn a_quadrilateral() {
    let corner = |x: f64, y: f64, z: f64| Vec3::new(x, y, z);
    let (p00, p10) = (corner(-5.0, 1.0, 2.0), corner(-2.0, -3.0, 6.0));
    let (p11, p01) = (corner(2.0, -1.0, 4.0), corner(1.0, 4.0, -1.0));
    let (point, normal) = (corner(-2.0, -1.0, 4.0), corner(0.0, 1.0, 1.0));
    // The point is on the line across that begins at a + u b on one side and leads along d + u e to the
    // other: normal · ((point − a − u b) × (d + u e)) = 0.
    let place = |a: Vec3, b: Vec3, other: Vec3, other_b: Vec3| {
        let (p, d, e) = (point - a, other - a, other_b - b);
        let n = |x: Vec3, y: Vec3| normal.dot(x.cross(y));
        quadratic(-n(b, e), n(p, e) - n(b, d), n(p, d))
    };
    let u = place(p00, p10 - p00, p01, p11 - p01);
    let v = place(p00, p01 - p00, p10, p11 - p10);
    assert!(close(u[0].t, 7.0 / 11.0, 1e-14) && close(u[1].t, 3.0, 1e-13), "{u:?}");
    let v = v.iter().map(|root| root.t).find(|t| (0.0..=1.0).contains(t)).unwrap();
    assert!(close(v, 3.0 / 13.0, 1e-14), "{v}");
    let (low, high) = (p00.lerp(p10, u[0].t), p01.lerp(p11, u[0].t));
    assert!(near(low.lerp(high, v), point, 1e-13));
    // The same as a patch, whose control points lie at thirds of the way: a ray that comes along the normal
    // meets it there, and has these coordinates.
    let third = |i: usize| (i % 4) as f64 / 3.0;
    let net = std::array::from_fn(|i| p00.lerp(p10, third(i)).lerp(p01.lerp(p11, third(i)), third(i / 4)));
    let patch = Shape::Patches(Patches::new(&Transform::IDENTITY, &[net], false).unwrap());
    let ray = Ray::new(point + 3.0 * normal, -normal.normalize());
    let hit = patch.intersect(&ray).unwrap();
    let met = patch.surface(&hit, &ray).point;
    assert!(near(met.position, point, 1e-13), "{met:?}");
    let uv = patch.parametrisation(&hit, met.position).uv;
    assert!(close(uv[0], 7.0 / 11.0, 1e-12) && close(uv[1], 3.0 / 13.0, 1e-12), "{uv:?}");
}

/// A ray that passes a box by (4), though it passes all three pairs of planes.
#[test]
fn a_box() {
    let ray = Ray::new(Vec3::new(0.0, 4.0, 2.0), Vec3::new(1.0, -2.0, 4.0) / 21f64.sqrt());
    let (low, high) = (Vec3::new(-1.0, 2.0, 1.0), Vec3::new(3.0, 3.0, 3.0));
    let boxed = |half: Vec3| {
        let place = DMat4::from_scale_rotation_translation(half, DQuat::IDENTITY, 0.5 * (low + high));
        Shape::Mesh(Mesh::cube(&Transform::new(place).unwrap(), false).unwrap())
    };
    assert!(boxed(0.5 * (high - low)).crossings(&ray).is_empty());
    // One pair of planes at a time, so wide that the ray meets both.
    let printed = [[-4.582576, 13.747727], [2.291288, 4.582576], [-1.145644, 1.145644]];
    for (axis, [enter, leave]) in printed.into_iter().enumerate() {
        let mut half = Vec3::splat(1000.0);
        half[axis] = 0.5 * (high - low)[axis];
        let crossings = boxed(half).crossings(&ray);
        let [first, last] = crossings[..] else { panic!("{crossings:?}") };
        assert!(close(first.hit.t, enter, 1e-6) && close(last.hit.t, leave, 1e-6), "{crossings:?}");
        assert!(first.enters && !last.enters);
    }
}
