use super::{any_placement, any_ray, direction, leaving, mixture, random, soup};
use crate::accel::watch::Unwatched;
use crate::accel::{Accel, Instance};
use crate::geometry::{Bounds, Motion, Placed, Ray, SurfacePoint, Transform, Vec3};
use crate::shape::{Cylinder, Disk, Hit, Mesh, MeshData, Shape, Sphere};
use glam::DMat4;
use rand::RngExt;
use std::sync::Arc;

/// One group, once.
fn instance_of(shapes: &[Shape], place: &Transform) -> Accel {
    let group = Arc::new(Accel::of_group(shapes, 0, &[]));
    Accel::with_instances(&[], &[], vec![Instance::new(group, Placed::still(place).unwrap())], [0.0; 2])
}

/// Whether two points found for the same ray are one within their error bounds and what a ray's parameter
/// rounds.
fn same(a: &SurfacePoint, b: &SurfacePoint, t: f64) -> bool {
    let apart = (a.position - b.position).dot(b.normal).abs();
    let scale = t + a.position.length();
    apart <= a.error + b.error && (a.position - b.position).length() <= 1e3 * f64::EPSILON * scale
}

#[test]
fn an_instance_where_it_was_made_changes_nothing() {
    let mut random = random(21);
    let shapes = mixture(60, 0.3, &mut random);
    let plain = Accel::build(&shapes);
    let instance = instance_of(&shapes, &Transform::IDENTITY);
    let mut hits = 0;
    for _ in 0..20_000 {
        let ray = any_ray(&mut random);
        let (expected, found) = (plain.closest(&ray, 0.0), instance.closest(&ray, 0.0));
        assert_eq!(found.is_some(), instance.occluded(&ray, 0.0));
        assert_eq!(found.map(|hit| hit.shape), expected.map(|hit| hit.shape));
        let (Some(expected), Some(found)) = (expected, found) else { continue };
        hits += 1;
        assert_eq!(found.instance, 0);
        // Where two segments of a curve meet it may be either, by rounding.
        let joined = u32::from(matches!(shapes[found.shape as usize], Shape::Curves(_)));
        assert!(found.triangle.abs_diff(expected.triangle) <= joined, "{found:?} {expected:?}");
        let (a, b) =
            (instance.surface(&shapes, &found, &ray, 0.0), plain.surface(&shapes, &expected, &ray, 0.0));
        assert!(same(&a.point, &b.point, expected.t), "{ray:?} {expected:?} {found:?}");
        assert!(expected.t > 100.0 || a.shading_normal.abs_diff_eq(b.shading_normal, 1e-9));
    }
    assert!(hits > 1000);
}

/// Affine maps under which vertices on a grid stay single precision, so that a transformed mesh is the very
/// one that an instance shows.
fn exact_placement(random: &mut impl rand::Rng) -> Transform {
    loop {
        let column = |random: &mut _| {
            let mut number = || f64::from(rand::RngExt::random_range(random, -3..4)) * 0.5;
            [number(), number(), number()]
        };
        let columns: [[f64; 3]; 4] = std::array::from_fn(|_| column(random));
        let columns: [[f64; 4]; 4] = std::array::from_fn(|i| {
            let [x, y, z] = columns[i];
            [x, y, z, if i == 3 { 1.0 } else { 0.0 }]
        });
        if let Some(place) = Transform::new(DMat4::from_cols_array_2d(&columns)) {
            return place;
        }
    }
}

#[test]
fn instances_show_what_transformed_meshes_show() {
    let mut random = random(22);
    let mut hits = 0;
    for _ in 0..40 {
        let mut data: MeshData = soup(60, 0.4, &mut random).data().clone();
        for position in &mut data.positions {
            *position = position.map(|x| (x * 1024.0).round() / 1024.0);
        }
        let place = exact_placement(&mut random);
        let group = [Shape::Mesh(Mesh::new(data.clone()).unwrap())];
        let instance = instance_of(&group, &place);
        let moved = [Shape::Mesh(Mesh::new(data.transformed(&place)).unwrap())];
        let plain = Accel::build(&moved);
        // Without vertex normals a mirror turns a transformed mesh inside out, but no instance (as in
        // Mitsuba).
        let side = if place.mirrors() { -1.0 } else { 1.0 };
        for _ in 0..1000 {
            let ray = any_ray(&mut random);
            let (expected, found) = (plain.closest(&ray, 0.0), instance.closest(&ray, 0.0));
            assert_eq!(found.map(|hit| hit.triangle), expected.map(|hit| hit.triangle), "{ray:?} {place:?}");
            let (Some(expected), Some(found)) = (expected, found) else { continue };
            hits += 1;
            let (a, b) =
                (instance.surface(&group, &found, &ray, 0.0), plain.surface(&moved, &expected, &ray, 0.0));
            assert!(
                (a.point.position - b.point.position).dot(b.point.normal).abs()
                    <= a.point.error + b.point.error
            );
            assert!(a.point.normal.abs_diff_eq(side * b.point.normal, 1e-9), "{:?} {:?}", a.point, b.point);
            let (a, b) = (
                instance.parametrisation(&group, &found, a.point.position, 0.0).0,
                plain.parametrisation(&moved, &expected, b.point.position, 0.0).0,
            );
            assert!(a.tangent.abs_diff_eq(b.tangent, 1e-9) && a.bitangent.abs_diff_eq(b.bitangent, 1e-9));
        }
    }
    assert!(hits > 1000);
}

#[test]
fn spheres_stay_outward_in_mirrored_instances() {
    // Seen in Mitsuba 3.9.1: the sphere under `scale x="1" y="2" z="3"`, from above; mirrored, it still faces
    // out.
    let sphere = [Shape::Sphere(Sphere::new(&Transform::IDENTITY, Vec3::ZERO, 1.0, false).unwrap())];
    let ray = Ray::new(Vec3::new(0.3, 0.2, 5.0), -Vec3::Z);
    for mirror in [1.0, -1.0] {
        let place = Transform::new(DMat4::from_scale(Vec3::new(1.0, 2.0, 3.0 * mirror))).unwrap();
        let accel = instance_of(&sphere, &place);
        let hit = accel.closest(&ray, 0.0).unwrap();
        assert!((hit.t - 2.15395).abs() < 5e-6);
        let surface = accel.surface(&sphere, &hit, &ray, 0.0);
        assert!(surface.point.normal.abs_diff_eq(Vec3::new(0.68376, 0.11396, 0.72075), 5e-6));
        let (parametrisation, _) = accel.parametrisation(&sphere, &hit, surface.point.position, 0.0);
        let v = if mirror > 0.0 { 0.10242 } else { 1.0 - 0.10242 };
        assert!((parametrisation.uv[0] - 0.05121).abs() < 5e-6 && (parametrisation.uv[1] - v).abs() < 5e-6);
        assert!(parametrisation.tangent.abs_diff_eq(Vec3::new(-0.62832, 3.76991, 0.0), 5e-6));
    }
}

/// A loop over shapes and instances.
fn brute_force(shapes: &[Shape], instances: &[Instance], ray: &Ray) -> Option<Hit> {
    let plain = (0u32..).zip(shapes).filter_map(|(i, shape)| Some(Hit { shape: i, ..shape.intersect(ray)? }));
    let placed = (0u32..)
        .zip(instances)
        .filter_map(|(i, placed)| Some(Hit { instance: i, ..placed.closest(ray, 0.0, Unwatched)? }));
    plain.chain(placed).filter(|hit| hit.t < ray.t_max).min_by(|a, b| a.t.total_cmp(&b.t))
}

#[test]
fn the_nearest_of_overlapping_instances_is_found() {
    let mut random = random(23);
    let mut met = [0; 2];
    for count in [1, 5, 100] {
        let mut shapes = mixture(3, 0.2, &mut random);
        let top = shapes.len();
        shapes.extend(mixture(5, 0.5, &mut random));
        let middle = shapes.len();
        shapes.push(Shape::Disk(Disk::new(&any_placement(0.5, &mut random), false).unwrap()));
        let groups = [(top, middle), (middle, shapes.len())]
            .map(|(from, to)| Arc::new(Accel::of_group(&shapes[from..to], from as u32, &[])));
        let instances: Vec<_> = (0..count)
            .map(|i| {
                Instance::new(groups[i % 2].clone(), Placed::still(&any_placement(0.7, &mut random)).unwrap())
            })
            .collect();
        let accel = Accel::with_instances(&shapes[..top], &[], instances.clone(), [0.0; 2]);
        for _ in 0..5000 {
            let ray = any_ray(&mut random);
            let expected = brute_force(&shapes[..top], &instances, &ray);
            assert_eq!(accel.closest(&ray, 0.0), expected, "{ray:?}");
            assert_eq!(accel.occluded(&ray, 0.0), expected.is_some(), "{ray:?}");
            if let Some(hit) = expected {
                assert_eq!((hit.shape as usize) < top, hit.instance == crate::shape::NO_INSTANCE);
                met[usize::from((hit.shape as usize) < top)] += 1;
            }
        }
    }
    assert!(met[0] > 500 && met[1] > 500, "{met:?}");
}

/// As for plain shapes: a convex surface is not met again from outside, a flat one from no side.
#[test]
fn rays_that_leave_an_instance_do_not_return() {
    let mut random = random(24);
    let mut rays = 0;
    for exponent in [-6, -3, 0, 3, 6] {
        let scale = 10f64.powi(exponent);
        for kind in 0..6 {
            // Some groups far from their own origin, some instances far from the world's, all of them skewed.
            let inner = Transform::translation(direction(&mut random) * [0.0, 1.0, 30.0][kind % 3]);
            let offset = direction(&mut random) * [0.0, 1.0, 100.0][random.random_range(0..3)] * scale;
            let stretch =
                Vec3::from_array(std::array::from_fn(|_| 10f64.powf(random.random_range(-1.5..0.5))));
            let turn = DMat4::from_axis_angle(direction(&mut random), random.random_range(0.0..6.0));
            let skewed = turn
                * DMat4::from_scale(stretch * scale)
                * DMat4::from_axis_angle(direction(&mut random), 1.0);
            let place = Transform::new(skewed).unwrap().then(&Transform::translation(offset));
            let shapes = [match kind {
                0 => Shape::Sphere(Sphere::new(&inner, Vec3::ZERO, 1.0, false).unwrap()),
                1 => Shape::Disk(Disk::new(&inner, false).unwrap()),
                2 => Shape::Cylinder(Cylinder::new(&inner, Vec3::ZERO, Vec3::Z, 1.0, false).unwrap()),
                3 => Shape::Mesh(Mesh::rectangle(&inner, false).unwrap()),
                4 => Shape::Mesh(Mesh::cube(&inner, false).unwrap()),
                _ => Shape::Sphere(
                    Sphere::new(&Transform::scale(1e-3).then(&inner), Vec3::ZERO, 1.0, false).unwrap(),
                ),
            }];
            let accel = instance_of(&shapes, &place);
            let flat = matches!(kind, 1 | 3);
            for _ in 0..10_000 {
                let local = shapes[0].sample([random.random(), random.random()]).unwrap().surface.point;
                let normal = place.normal(local.normal).normalize();
                let point = SurfacePoint { position: place.point(local.position), normal, error: 0.0 };
                let away = leaving(&point, &mut random);
                let distance = scale * 10f64.powf(random.random_range(-3.0..3.0));
                let ray = Ray::new(point.position + away * distance, -away);
                let Some(hit) = accel.closest(&ray, 0.0) else { continue };
                let point = accel.surface(&shapes, &hit, &ray, 0.0).point;
                let away = leaving(&point, &mut random);
                if flat || away.dot(point.normal) > 0.0 {
                    rays += 1;
                    let hit = accel.closest(&point.ray(away), 0.0);
                    assert_eq!(hit, None, "kind {kind}, scale {scale}, {place:?}, {point:?}, {away:?}");
                }
            }
        }
    }
    assert!(rays > 100_000, "{rays}");
}

#[test]
fn an_instance_costs_a_small_record() {
    let mut random = random(25);
    let group = Arc::new(Accel::of_group(&[Shape::Mesh(soup(20_000, 0.01, &mut random))], 0, &[]));
    let instances: Vec<_> = (0..1000)
        .map(|_| Instance::new(group.clone(), Placed::still(&any_placement(0.1, &mut random)).unwrap()))
        .collect();
    let accel = Accel::with_instances(&[], &[], instances, [0.0; 2]);
    assert!(
        accel.memory() < 1000 * 1200 && group.memory() > 500_000,
        "{} {}",
        accel.memory(),
        group.memory()
    );
}

/// The box around the turned box of a ball is up to 1.7 times as wide as the ball.
#[test]
fn turned_instances_have_boxes_that_hold_them_and_are_tight() {
    let mut random = random(82);
    let balls: Vec<Shape> = (0..2000)
        .map(|_| {
            Shape::Sphere(Sphere::new(&Transform::IDENTITY, direction(&mut random), 0.02, false).unwrap())
        })
        .collect();
    let group = Arc::new(Accel::of_group(&balls, 0, &[]));
    for _ in 0..100 {
        let turned = DMat4::from_axis_angle(direction(&mut random), random.random_range(0.0..6.0));
        let place = Transform::new(turned).unwrap();
        let instance = Instance::new(group.clone(), Placed::still(&place).unwrap());
        let bounds = instance.bounds([0.0; 2]);
        let size = bounds.max - bounds.min;
        assert!(size.max_element() < 1.1 * 2.04, "{size}");
        for ball in &balls {
            let centre = place.point(ball.bounds().centre());
            let around = Bounds { min: centre - Vec3::splat(0.02), max: centre + Vec3::splat(0.02) };
            assert!(bounds.contains(around), "{around:?} {bounds:?}");
        }
    }
}

/// A body on a bent way, turning: at each time it is hit just where a body that stands there is.
#[test]
fn moving_instances_are_hit_where_they_are_at_the_rays_time() {
    let mut random = random(81);
    let shapes = mixture(60, 0.5, &mut random);
    let group = Arc::new(Accel::of_group(&shapes, 0, &[]));
    let key = |time: f64, degrees: f64, x: f64, y: f64| {
        let turn = DMat4::from_axis_angle(Vec3::new(0.0, 0.6, 0.8), degrees.to_radians());
        (time, Transform::new(DMat4::from_translation(Vec3::new(x, y, 0.0)) * turn).unwrap())
    };
    let keys = [key(0.0, 0.0, -30.0, -30.0), key(0.5, 100.0, 0.0, 20.0), key(1.0, 250.0, 30.0, 30.0)];
    let motion = Motion::new(&keys).unwrap();
    let moving = Instance::new(group.clone(), Placed::moving(motion.clone()).unwrap());
    // It pays to know roughly when it is where.
    assert!(moving.slices([0.0, 1.0]).len() >= 16);
    let accel = Accel::with_instances(&[], &[], vec![moving], [0.0, 1.0]);
    let mut met = 0;
    for i in 0..4000 {
        let time = f64::from(i) / 3999.0;
        let pose = motion.at(time);
        let matrix = DMat4::from_translation(pose.origin) * DMat4::from_mat3(pose.linear);
        let still = instance_of(&shapes, &Transform::new(matrix).unwrap());
        let mut ray = any_ray(&mut random);
        ray.origin += pose.origin;
        let (expected, found) = (still.closest(&ray, time), accel.closest(&ray, time));
        assert_eq!(found.map(|hit| hit.shape), expected.map(|hit| hit.shape), "{time} {ray:?}");
        assert_eq!(accel.occluded(&ray, time), expected.is_some());
        let (Some(expected), Some(found)) = (expected, found) else { continue };
        met += 1;
        let a = accel.surface(&shapes, &found, &ray, time).point;
        let b = still.surface(&shapes, &expected, &ray, time).point;
        assert!(same(&a, &b, expected.t), "{time} {a:?} {b:?}");
    }
    assert!(met > 500, "{met}");
}

/// Something of a pixel's size that moves by 100 pixels both across and down: a box around all of its way is
/// met by the rays of 10,000 pixels (Glassner, *An Introduction to Ray Tracing*, ch. 5, sec. 6.4). Slices of
/// time ask for some 200 tests of boxes that are thrown away by their time, and for a handful of tests of the
/// thing itself.
#[test]
fn a_diagonal_mover_is_not_tested_along_all_of_its_box() {
    let pixel = Mesh::rectangle(&Transform::scale(0.5), false).unwrap();
    let group = Arc::new(Accel::of_group(&[Shape::Mesh(pixel)], 0, &[]));
    let end = Transform::translation(Vec3::new(100.0, 100.0, 0.0));
    let motion = Motion::new(&[(0.0, Transform::IDENTITY), (1.0, end)]).unwrap();
    let instance = Instance::new(group, Placed::moving(motion).unwrap());
    let pixels = |bounds: crate::geometry::Bounds| {
        let size = bounds.max - bounds.min;
        size.x * size.y
    };
    let slices = instance.slices([0.0, 1.0]);
    let boxes: f64 = slices.iter().map(|slice| pixels(slice.bounds)).sum();
    let tests: f64 = boxes / slices.len() as f64;
    assert!((pixels(instance.bounds([0.0, 1.0])) - 101.0 * 101.0).abs() < 1e-6);
    assert!(boxes < 500.0 && tests < 10.0, "{} slices: {boxes} boxes, {tests} tests", slices.len());
}
