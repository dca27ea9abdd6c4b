//! Fans answer what one ray after the other does.

use super::*;
use crate::accel::{Hits, NO_FACET, Target};
use crate::geometry::Points;
use crate::lanes::{LANES, REGISTERS, WIDTH, set};
use crate::shape::RaySpace;

/// A room with two blocks and a lamp.
pub(super) fn room() -> Vec<Shape> {
    let square = |turn: DQuat, at: Vec3, size: f64| {
        let place = DMat4::from_scale_rotation_translation(Vec3::splat(size), turn, at);
        Shape::Mesh(Mesh::rectangle(&Transform::new(place).unwrap(), false).unwrap())
    };
    let quarter = std::f64::consts::FRAC_PI_2;
    let mut shapes = vec![
        square(DQuat::from_rotation_x(-quarter), Vec3::NEG_Y, 1.0),
        square(DQuat::from_rotation_x(quarter), Vec3::Y, 1.0),
        square(DQuat::IDENTITY, Vec3::NEG_Z, 1.0),
        square(DQuat::from_rotation_y(quarter), Vec3::NEG_X, 1.0),
        square(DQuat::from_rotation_y(-quarter), Vec3::X, 1.0),
        square(DQuat::from_rotation_x(quarter), Vec3::Y * 0.99, 0.3),
    ];
    for (size, angle, at) in [
        (Vec3::new(0.3, 0.6, 0.3), 0.3, Vec3::new(-0.35, -0.4, -0.3)),
        (Vec3::splat(0.3), -0.3, Vec3::new(0.4, -0.7, 0.3)),
    ] {
        let place = DMat4::from_scale_rotation_translation(size, DQuat::from_rotation_y(angle), at);
        shapes.push(Shape::Mesh(Mesh::cube(&Transform::new(place).unwrap(), false).unwrap()));
    }
    shapes
}

/// Needles of many widths.
pub(super) fn slivers(random: &mut Random) -> Mesh {
    let mut data = MeshData::default();
    for i in 0..20u32 {
        let width = 10f64.powi(random.random_range(-9..0));
        let (a, b) = (in_cube(random), in_cube(random));
        let c = if random.random() { a } else { a.lerp(b, 0.4) } + width * in_cube(random);
        data.positions.extend([a, b, c].map(|vertex| vertex.as_vec3().to_array()));
        data.indices.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    Mesh::new(data).unwrap()
}

pub(super) fn placed(shapes: &[Shape], place: &Transform) -> Vec<Shape> {
    let moved = |shape: &Shape| match shape {
        Shape::Mesh(mesh) => Shape::Mesh(Mesh::new(mesh.data().transformed(place)).unwrap()),
        Shape::Sphere(sphere) => {
            let (centre, radius) = (sphere.bounds().centre(), sphere.radius().unwrap());
            Shape::Sphere(Sphere::new(place, centre, radius, false).unwrap())
        }
        _ => unreachable!("meshes and spheres alone"),
    };
    shapes.iter().map(moved).collect()
}

/// On a surface, at its edges and vertices, or anywhere with any bound on its error; and the shape and
/// triangle that it is on.
pub(super) fn any_point(
    shapes: &[Shape],
    place: &Transform,
    scale: f64,
    random: &mut Random,
) -> (SurfacePoint, Option<[u32; 2]>) {
    let meshes = shapes.iter().filter(|shape| matches!(shape, Shape::Mesh(_))).count();
    let shape = random.random_range(0..meshes);
    let Shape::Mesh(mesh) = &shapes[shape] else { unreachable!("meshes first") };
    let triangle = random.random_range(0..mesh.triangle_count() as u32);
    let barycentric = match random.random_range(0..4) {
        0 => [0.0, 1.0],
        1 => [random.random(), 0.0],
        _ => {
            let v: f64 = random.random();
            [v, (1.0 - v) * random.random::<f64>()]
        }
    };
    let on_it = mesh.surface(triangle, barycentric).point;
    match random.random_range(0..8) {
        0 => {
            let error = [0.0, 1e-12, 1e-3][random.random_range(0..3)] * scale;
            let position = place.point(2.0 * in_cube(random));
            (SurfacePoint { position, normal: direction(random), error }, None)
        }
        1 => (SurfacePoint { normal: -on_it.normal, ..on_it }, Some([shape as u32, triangle])),
        _ => (on_it, Some([shape as u32, triangle])),
    }
}

#[test]
fn fans_see_what_single_rays_see() {
    let mut random = random(11);
    let (mut open, mut blocked) = (0, 0);
    for round in 0..300 {
        let mut shapes = match round % 6 {
            0 => room(),
            1 => vec![Shape::Mesh(soup(random.random_range(1..60), 0.8, &mut random))],
            2 => vec![Shape::Mesh(soup(60, 0.1, &mut random)), Shape::Mesh(soup(3, 1e-5, &mut random))],
            3 => vec![Shape::Mesh(slivers(&mut random)), Shape::Mesh(soup(9, 0.8, &mut random))],
            4 => vec![Shape::Mesh(Mesh::cube(&Transform::IDENTITY, false).unwrap())],
            _ => vec![Shape::Mesh(soup(200, 0.3, &mut random))],
        };
        if round % 4 == 1 {
            let sphere = Sphere::new(&Transform::IDENTITY, 0.4 * in_cube(&mut random), 0.3, false);
            shapes.push(Shape::Sphere(sphere.unwrap()));
        }
        let (scale, offset) =
            [(1.0, 0.0), (1e-30, 0.0), (1e-6, 0.0), (1e6, 0.0), (1e15, 0.0), (1.0, 1e3), (1e-3, 1.0)]
                [random.random_range(0..7)];
        let offset = Vec3::new(offset, -0.5 * offset, 0.3 * offset);
        let place = Transform::scale(scale).then(&Transform::translation(offset));
        let shapes = placed(&shapes, &place);
        let accel = Accel::build(&shapes);
        assert_eq!(accel.few.is_some(), round % 6 != 5, "round {round}");
        for _ in 0..30 {
            // Now and then all on one surface, as those of neighbouring pixels are.
            let near = shapes.len() - random.random_range(0..shapes.len());
            let mut points: Vec<_> =
                (0..LANES).map(|_| any_point(&shapes[..near], &place, scale, &mut random)).collect();
            if random.random_range(0..20) == 0 {
                points[3].0.position.x = f64::NAN;
            }
            let knows_facets = random.random::<bool>();
            let facet = |on: Option<[u32; 2]>| match on.filter(|_| knows_facets) {
                Some([shape, triangle]) => accel.facet_of(shape, triangle),
                None => NO_FACET,
            };
            let (mut lanes, mut facets) = ([Points::NONE; REGISTERS], Hits::NONE.facet);
            for (lane, (point, on)) in points.iter().enumerate() {
                lanes[lane / WIDTH].set(lane, point);
                set(&mut facets, lane, facet(*on));
            }
            let all = random.random_range(0..1 << LANES);
            let fan = accel.fan(&lanes, &facets, all);
            for _ in 0..10 {
                let (target, on) = match random.random_range(0..10) {
                    0 => points[random.random_range(0..LANES)],
                    _ => any_point(&shapes, &place, scale, &mut random),
                };
                let asked = all & random.random_range(0..1 << LANES);
                let answer = fan.blocked(&Target { point: &target, facet: facet(on) }, 0.0, asked);
                for (lane, (point, _)) in points.iter().enumerate() {
                    let segment = point.segment_to(&target);
                    let expected = segment.is_none_or(|segment| accel.occluded(&segment, 0.0));
                    let expected = expected && asked >> lane & 1 == 1;
                    assert_eq!(answer >> lane & 1 == 1, expected, "{round}: {point:?} to {target:?}");
                    *(if expected { &mut blocked } else { &mut open }) += 1;
                }
            }
        }
    }
    assert!(open > 100_000 && blocked > 100_000, "{open} open, {blocked} blocked");
}

/// A room of walls and blocks is tested as rectangles.
#[test]
fn pairs_of_triangles_are_facets() {
    let accel = Accel::build(&room());
    let few = accel.few.unwrap();
    assert_eq!(few.facets.len(), 18);
    assert!(few.facets.iter().all(|facet| facet.triangles.len() == 2 && !facet.always));
}

/// The first tests leave what is hit and next to nothing else.
#[test]
fn few_facets_are_candidates_in_vain() {
    let mut random = random(12);
    let accel = Accel::build(&room());
    let few = accel.few.as_ref().unwrap();
    let mut anywhere = || SurfacePoint { position: in_cube(&mut random), normal: Vec3::Z, error: 0.0 };
    let points: [SurfacePoint; LANES] = std::array::from_fn(|_| anywhere());
    let mut lanes = [Points::NONE; REGISTERS];
    points.iter().enumerate().for_each(|(lane, point)| lanes[lane / WIDTH].set(lane, point));
    let sides = few.sides(&lanes.map(|points| points.position));
    let (mut candidates, mut hits) = (0, 0);
    for _ in 0..10_000 {
        let target = anywhere();
        let seen = few.seen(target.position);
        for (index, (facet, sides)) in few.facets.iter().zip(&sides).enumerate() {
            let end = [0, 1, 2].map(|f| seen[index / WIDTH][WIDTH * f + index % WIDTH]);
            let mask = sides.crossing(end, facet.slack).near;
            candidates += (mask & ((1 << LANES) - 1)).count_ones();
            for point in &points {
                let ray = RaySpace::new(&point.segment_to(&target).unwrap());
                let length = point.position.distance(target.position);
                let hit = |triangle: &[Vec3; 3]| ray.intersect(*triangle, length).is_some();
                hits += u32::from(facet.triangles.iter().any(hit));
            }
        }
    }
    assert!(hits > 10_000 && candidates >= hits, "{candidates} candidates, {hits} hits");
    assert!(f64::from(candidates - hits) < 1e-3 * f64::from(hits), "{candidates} candidates, {hits} hits");
}
