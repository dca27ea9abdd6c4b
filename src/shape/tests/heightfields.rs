//! What is particular to height fields.

use super::doubled::{Doubled, Polynomial};
use super::grid_shapes::{Known, Tally, add_roots};
use super::leaving::{Leaving, PLACES, leave, placed};
use super::oracle::Line;
use super::{Random, close, direction, near, placement};
use crate::geometry::{Ray, Transform, Vec3};
use crate::shape::{GridShape, HeightData, HeightField, Shape, ShapeError};
use rand::{RngExt, SeedableRng};
use std::sync::Arc;

fn data(points: [usize; 2], function: impl Fn(f64, f64) -> f64) -> Arc<HeightData> {
    let values = (0..points[0] * points[1]).map(|i| {
        let at = [i % points[0], i / points[0]];
        let [x, y] = [0, 1].map(|axis| 2.0 * at[axis] as f64 / (points[axis] - 1) as f64 - 1.0);
        function(x, y) as f32
    });
    Arc::new(HeightData::new(points, values.collect()).unwrap())
}

/// Smooth, from about −1 to 1.
pub fn hills(points: [usize; 2]) -> Arc<HeightData> {
    data(points, |x, y| (3.0 * x + 0.5).sin() * (2.0 * y + x).cos())
}

/// Without any order.
fn noise(points: [usize; 2], seed: u64) -> Arc<HeightData> {
    let random = std::cell::RefCell::new(Random::seed_from_u64(seed));
    data(points, |_, _| random.borrow_mut().random_range(-1.0..1.0))
}

fn shape(to_world: &Transform, data: &Arc<HeightData>, scale: f64, base: Option<f64>) -> Shape {
    let field = HeightField::new(to_world, data.clone(), scale, base, false, false);
    Shape::Grid(Box::new(GridShape::Heights(field.unwrap())))
}

/// All patches, one after the other.
fn known(data: &HeightData, scale: f64, to_world: &Transform, ray: &Ray) -> Known {
    let (points, values) = data.grid();
    let Line([x, y, z]) = Line::new(ray, to_world);
    let along = [(&x, points[0]), (&y, points[1])]
        .map(|(p, points)| (p + &Polynomial::constant(1.0)).scaled(0.5 * (points - 1) as f64));
    let mut known = Known { crossings: Vec::new(), doubt: f64::INFINITY };
    for i in 0..values.len() {
        let at = [i % points[0], i / points[0]];
        let mut ends = [Doubled::from(-1e9), Doubled::from(1e9)];
        for axis in 0..2 {
            let [start, rise] = [along[axis].0[0], along[axis].0[1]];
            let sides = [at[axis] as f64, (at[axis] + 1) as f64].map(|side| Doubled::from(side) - start);
            let beside = rise.high == 0.0 && !(sides[0].high <= 0.0 && sides[1].high > 0.0);
            if at[axis] + 1 == points[axis] || beside {
                ends = [Doubled::from(1.0), Doubled::from(0.0)];
            } else if rise.high != 0.0 {
                let mut t = sides.map(|side| side / rise);
                if rise.high < 0.0 {
                    t.reverse();
                }
                if (t[0] - ends[0]).high > 0.0 {
                    ends[0] = t[0];
                }
                if (ends[1] - t[1]).high > 0.0 {
                    ends[1] = t[1];
                }
            }
        }
        if (ends[1] - ends[0]).high <= 0.0 {
            continue;
        }
        let mut function = z.clone();
        for corner in 0..4usize {
            let bit = |axis: usize| corner >> axis & 1;
            let value = values[(at[1] + bit(1)) * points[0] + at[0] + bit(0)];
            let weight = |axis: usize| {
                let from = &along[axis] - &Polynomial::constant(at[axis] as f64);
                if bit(axis) == 1 { from } else { &Polynomial::constant(1.0) - &from }
            };
            function = &function - &(&weight(0) * &weight(1)).scaled(f64::from(value) * scale);
        }
        add_roots(&mut known, &function, ends, ray);
    }
    known
}

fn check_fields(rays: u32) {
    let mut tally = Tally::default();
    // Dyadic scales, whose products with the heights the oracle has exactly.
    let all =
        [("hills", hills([9, 7]), 0.5), ("noise", noise([6, 8], 1), 0.25), ("one", noise([2, 2], 2), 2.0)];
    for (i, (name, data, scale)) in all.into_iter().enumerate() {
        for (j, to_world) in
            [Transform::IDENTITY, placement(Vec3::new(0.9, 0.5, 0.3))].into_iter().enumerate()
        {
            let shape = shape(&to_world, &data, scale, None);
            tally.check(name, &shape, rays, (2 * i + j) as u64, |ray| known(&data, scale, &to_world, ray));
        }
    }
    tally.judge();
}

#[test]
fn fields_are_crossed_where_the_oracle_says() {
    check_fields(crate::stress::count(8_000, 170_000));
}

#[test]
fn no_crossing_is_lost_between_patches() {
    leaks(crate::stress::count(200_000, 10_000_000));
}

/// Lines cross bodies an even number of times, by turns in and out, also through the points and borders of
/// patches.
fn leaks(rays: u32) {
    let whole = |x: f64, y: f64| (2.0 * x).round() - (3.0 * y).round();
    let all = [hills([9, 9]), noise([17, 12], 2), data([8, 9], whole)];
    let places = [Transform::IDENTITY, placement(Vec3::new(0.9, 0.5, 0.3))];
    let shapes = places.map(|place| all.each_ref().map(|data| shape(&place, data, 0.25, Some(-2.0))));
    let mut random = Random::seed_from_u64(5);
    let mut crossed = 0;
    for i in 0..rays as usize {
        let (data, to_world, shape) = (&all[i % 3], &places[i % 2], &shapes[i % 2][i % 3]);
        let (points, values) = data.grid();
        // A point of the grid, or on the border between two.
        let corner = [0, 1].map(|axis| random.random_range(0..points[axis] - 1));
        let along: f64 = if random.random() { 0.0 } else { random.random() };
        let axis = random.random_range(0..2);
        let mut other = corner;
        other[axis] += 1;
        let point = |at: [usize; 2]| {
            let [x, y] = [0, 1].map(|axis| 2.0 * at[axis] as f64 / (points[axis] - 1) as f64 - 1.0);
            Vec3::new(x, y, 0.25 * f64::from(values[at[1] * points[0] + at[0]]))
        };
        let target = to_world.point(point(corner).lerp(point(other), along));
        let mut toward = direction(&mut random);
        match random.random_range(0..6) {
            0 => toward = to_world.vector(Vec3::AXES[random.random_range(0..3)]).normalize(),
            // Along the border, or from point to point.
            1 => toward = to_world.vector(point(other) - point(corner)).normalize(),
            2 => {
                let other = [0, 1].map(|axis| random.random_range(0..points[axis]));
                let way = to_world.vector(point(other) - point(corner));
                toward = way.try_normalize().unwrap_or(toward);
            }
            _ => {}
        }
        let found = shape.crossings(&Ray::new(target - toward * random.random_range(0.0..5.0), toward));
        let by_turns = found.iter().enumerate().all(|(i, crossing)| crossing.enters == (i % 2 == 0));
        assert!(found.len().is_multiple_of(2) && by_turns, "{i}: {target} {toward} {found:?}");
        crossed += found.len();
    }
    assert!(crossed > rays as usize);
}

/// Rays that leave the outside go away or on to another part; such as go in come out again. Points lie on the
/// patches.
#[test]
fn no_field_is_met_where_it_is_left() {
    let mut random = Random::seed_from_u64(3);
    let data = hills([24, 20]);
    for (scale, distance) in PLACES {
        let place = placed([scale, distance], &mut random);
        let shape = shape(&place, &data, 0.5, Some(-1.0));
        for _ in 0..20_000 {
            let Leaving { angle, outward, inward, .. } = leave(&shape, &mut random).unwrap();
            if let Some(hit) = shape.intersect(&outward) {
                assert!(hit.t > 1e-4 * angle * scale, "{scale} {angle:e}: {:e}", hit.t);
            }
            let ahead = shape.crossings(&inward).iter().filter(|crossing| crossing.hit.t >= 0.0).count();
            assert!(ahead % 2 == 1, "{scale} {angle:e}");
        }
    }
}

/// The volume of a body by the lengths of chords, whose share of the box is known by its standard error; each
/// hit on the heights has z = bilerp to 1e-9.
#[test]
fn a_body_has_its_volume_and_its_heights() {
    let data = noise([7, 6], 9);
    let shape = shape(&Transform::IDENTITY, &data, 0.5, Some(-1.0));
    let (points, values) = data.grid();
    let [width, depth] = points;
    let (mut volume, cells) = (0.0, ((width - 1) * (depth - 1)) as f64);
    for j in 0..depth - 1 {
        for i in 0..width - 1 {
            let corners = [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)];
            let mean: f64 = corners.iter().map(|&(i, j)| 0.25 * f64::from(values[j * width + i])).sum();
            volume += (0.5 * mean + 1.0) * 4.0 / cells;
        }
    }
    let mut random = Random::seed_from_u64(1);
    let count = 100_000;
    for axis in 0..3 {
        let (mut mean, mut square) = (0.0, 0.0);
        let size = Vec3::new(2.0, 2.0, 1.5);
        let face = size[(axis + 1) % 3] * size[(axis + 2) % 3];
        for _ in 0..count {
            let from: [f64; 3] = std::array::from_fn(|_| random.random());
            let mut origin = Vec3::from_array(from) * size - Vec3::ONE;
            origin[axis] = 3.0;
            let ray = Ray::new(origin, -Vec3::AXES[axis]);
            let found = shape.crossings(&ray);
            let chord: f64 = found.chunks(2).map(|pair| pair[1].hit.t - pair[0].hit.t).sum();
            mean += chord * face / f64::from(count);
            square += (chord * face).powi(2) / f64::from(count);
            for crossing in found.iter().filter(|crossing| crossing.hit.triangle < cells as u32) {
                let hit = ray.at(crossing.hit.t);
                let at = [(hit.x + 1.0) * 0.5 * (width - 1) as f64, (hit.y + 1.0) * 0.5 * (depth - 1) as f64];
                let (i, j) = ((at[0] as usize).min(width - 2), (at[1] as usize).min(depth - 2));
                let value = |i: usize, j: usize| 0.5 * f64::from(values[j * width + i]);
                let (u, v) = (at[0] - i as f64, at[1] - j as f64);
                let lower = value(i, j) * (1.0 - u) + value(i + 1, j) * u;
                let upper = value(i, j + 1) * (1.0 - u) + value(i + 1, j + 1) * u;
                assert!(close(lower * (1.0 - v) + upper * v, hit.z, 1e-9));
            }
        }
        let error = ((square - mean * mean) / f64::from(count)).sqrt();
        assert!(close(mean, volume, 4.0 * error), "{axis}: {mean} ± {error}, {volume}");
    }
}

/// In the limit a fine field is the paraboloid that it samples: normals, coordinates, and smooth normals
/// nearer to its own.
#[test]
fn a_fine_field_is_its_function() {
    let data = data([65, 65], |x, y| 0.5 * (x * x + y * y));
    let made = |smooth, flip| {
        let field = HeightField::new(&Transform::IDENTITY, data.clone(), 1.0, None, smooth, flip).unwrap();
        Shape::Grid(Box::new(GridShape::Heights(field)))
    };
    let [flat, round, flipped] = [made(false, false), made(true, false), made(true, true)];
    // ∫ √(1 + x² + y²) over the square, by the midpoint rule.
    let middle = |i: usize| (2.0 * i as f64 + 1.0) / 500.0 - 1.0;
    let element = |i: usize| (1.0 + middle(i % 500).powi(2) + middle(i / 500).powi(2)).sqrt();
    let area = (0..250_000).map(element).sum::<f64>() * 4.0 / 250_000.0;
    assert!(close(flat.area() / area, 1.0, 1e-4), "{} {area}", flat.area());
    let mut random = Random::seed_from_u64(1);
    let (mut analytic, mut smooth) = (0.0, 0.0);
    for _ in 0..2_000 {
        let (x, y) = (random.random_range(-0.9..0.9), random.random_range(-0.9..0.9));
        let ray = Ray::new(Vec3::new(x, y, 5.0), -Vec3::Z);
        let exact = Vec3::new(-x, -y, 1.0).normalize();
        let at = |shape: &Shape| {
            let hit = shape.intersect(&ray).unwrap();
            assert!(close(hit.t, 5.0 - 0.5 * (x * x + y * y), 3e-4));
            let found = shape.surface(&hit, &ray);
            let here = shape.parametrisation(&hit, found.point.position);
            assert!(close(here.uv[0], 0.5 * (x + 1.0), 1e-12) && close(here.uv[1], 0.5 * (y + 1.0), 1e-12));
            assert!(near(here.tangent, 2.0 * Vec3::new(1.0, 0.0, x), 0.05), "{here:?}");
            assert!(near(here.bitangent, 2.0 * Vec3::new(0.0, 1.0, y), 0.05), "{here:?}");
            assert!(here.tangent.dot(found.point.normal).abs() < 1e-12);
            found
        };
        let (flat, round) = (at(&flat), at(&round));
        assert_eq!(at(&flipped).point.normal, -round.point.normal);
        assert_eq!(at(&flipped).shading_normal, -round.shading_normal);
        analytic += (flat.shading_normal - exact).length_squared();
        smooth += (round.shading_normal - exact).length_squared();
    }
    assert!(smooth < 0.01 * analytic, "{smooth} {analytic}");
}

#[test]
fn what_is_no_field_is_refused() {
    let made = |points, values: Vec<f32>| HeightData::new(points, values).err();
    assert_eq!(made([2, 1], vec![1.0; 2]), Some(ShapeError::GridPoints));
    assert_eq!(made([2, 2], vec![1.0; 5]), Some(ShapeError::GridPoints));
    let expected = ShapeError::NotFinite { attribute: "height", vertex: 3 };
    assert_eq!(made([2, 2], vec![1.0, 0.0, 0.0, f32::NAN]), Some(expected));
    let flat = Arc::new(HeightData::new([2, 2], vec![1.0; 4]).unwrap());
    let with_base = |base| HeightField::new(&Transform::IDENTITY, flat.clone(), 2.0, base, false, false);
    assert_eq!(with_base(Some(2.0)).err(), Some(ShapeError::Base));
    assert!(with_base(Some(1.9)).is_ok());
    // A plane.
    let plane = Shape::Grid(Box::new(GridShape::Heights(with_base(None).unwrap())));
    let hit = plane.intersect(&Ray::new(Vec3::new(0.25, 0.5, 5.0), -Vec3::Z)).unwrap();
    assert!(close(hit.t, 3.0, 1e-15));
    assert!(plane.crossings(&Ray::new(Vec3::ZERO, Vec3::NAN)).is_empty());
}
