//! What is particular to grids of distances.

use super::doubled::{Doubled, Polynomial};
use super::grid_shapes::{Known, Tally, add_roots};
use super::leaving::{Leaving, PLACES, leave, placed};
use super::oracle::Line;
use super::{Random, close, direction, near, placement};
use crate::geometry::{Ray, Transform, Vec3};
use crate::shape::{GridShape, SdfData, SdfGrid, Shape, ShapeError};
use rand::{RngExt, SeedableRng};
use std::sync::Arc;

/// The grid of a function on the unit cube.
fn data(points: [usize; 3], function: impl Fn(Vec3) -> f64) -> Arc<SdfData> {
    let [width, height, depth] = points;
    let values = (0..width * height * depth).map(|i| {
        let at = [i % width, i / width % height, i / (width * height)];
        function(Vec3::from_array([0, 1, 2].map(|axis| at[axis] as f64 / (points[axis] - 1) as f64))) as f32
    });
    Arc::new(SdfData::new(points, values.collect()).unwrap())
}

/// The distance from a ball in the middle of the cube.
pub fn ball(points: usize) -> Arc<SdfData> {
    data([points; 3], |at| (at - Vec3::splat(0.5)).length() - 0.375)
}

/// Values of either sign without any order.
fn noise(points: [usize; 3], seed: u64) -> Arc<SdfData> {
    let random = std::cell::RefCell::new(Random::seed_from_u64(seed));
    data(points, |_| random.borrow_mut().random_range(-1.0..1.0))
}

/// Whole numbers, many of them zero: a surface that goes along the sides of cells.
fn box_on_sides() -> Arc<SdfData> {
    data([7, 7, 5], |at| {
        let away = (at - Vec3::splat(0.5)).abs() * Vec3::new(6.0, 6.0, 4.0) - Vec3::new(2.0, 2.0, 1.0);
        away.max_element()
    })
}

fn shape(to_world: &Transform, data: &Arc<SdfData>) -> Shape {
    Shape::Grid(Box::new(GridShape::Distances(SdfGrid::new(to_world, data.clone(), false, false).unwrap())))
}

/// All cells, one after the other.
fn known(data: &SdfData, to_world: &Transform, ray: &Ray) -> Known {
    let (points, values) = data.grid();
    let line = Line::new(ray, to_world);
    let along = [0, 1, 2].map(|axis| line.0[axis].scaled((points[axis] - 1) as f64));
    let mut known = Known { crossings: Vec::new(), doubt: f64::INFINITY };
    for i in 0..values.len() {
        let at = [i % points[0], i / points[0] % points[1], i / (points[0] * points[1])];
        let mut ends = [Doubled::from(-1e9), Doubled::from(1e9)];
        for axis in 0..3 {
            let [start, rise] = [along[axis].0[0], along[axis].0[1]];
            let sides = [at[axis] as f64, (at[axis] + 1) as f64].map(|side| Doubled::from(side) - start);
            if at[axis] + 1 == points[axis]
                || rise.high == 0.0 && !(sides[0].high <= 0.0 && sides[1].high > 0.0)
            {
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
        let mut function = Polynomial::constant(0.0);
        for corner in 0..8usize {
            let bit = |axis: usize| corner >> axis & 1;
            let value = values[((at[2] + bit(2)) * points[1] + at[1] + bit(1)) * points[0] + at[0] + bit(0)];
            let weight = |axis: usize| {
                let from = &along[axis] - &Polynomial::constant(at[axis] as f64);
                if bit(axis) == 1 { from } else { &Polynomial::constant(1.0) - &from }
            };
            let product = &(&weight(0) * &weight(1)) * &weight(2);
            function = &function + &product.scaled(f64::from(value));
        }
        add_roots(&mut known, &function, ends, ray);
    }
    known
}

fn check_grids(rays: u32) {
    let mut tally = Tally::default();
    let all = [("ball", ball(8)), ("noise", noise([5, 6, 7], 1)), ("one cell or two", noise([2, 2, 3], 3))];
    for (i, (name, data)) in all.into_iter().enumerate() {
        for (j, to_world) in
            [Transform::IDENTITY, placement(Vec3::new(0.9, 0.5, 0.3))].into_iter().enumerate()
        {
            let shape = shape(&to_world, &data);
            tally.check(name, &shape, rays, (2 * i + j) as u64, |ray| known(&data, &to_world, ray));
        }
    }
    tally.judge();
}

#[test]
fn grids_are_crossed_where_the_oracle_says() {
    check_grids(crate::stress::count(4_000, 170_000));
}

/// From outside to outside, a line crosses a closed surface an even number of times, by turns in and out:
/// also where it goes through corners, edges and sides of cells.
#[test]
fn no_crossing_is_lost_between_cells() {
    leaks(crate::stress::count(100_000, 10_000_000));
}

fn leaks(rays: u32) {
    let closed = |data: Arc<SdfData>| {
        let (points, values) = data.grid();
        let values = values.iter().enumerate().map(|(i, &value)| {
            let at = [i % points[0], i / points[0] % points[1], i / (points[0] * points[1])];
            if (0..3).any(|axis| at[axis] == 0 || at[axis] + 1 == points[axis]) { 0.5 } else { value }
        });
        Arc::new(SdfData::new(points, values.collect()).unwrap())
    };
    let all = [ball(9), closed(noise([9, 9, 9], 2)), box_on_sides()];
    let places = [Transform::IDENTITY, placement(Vec3::new(0.9, 0.5, 0.3))];
    let shapes = places.map(|to_world| all.each_ref().map(|data| shape(&to_world, data)));
    let mut random = Random::seed_from_u64(5);
    let mut crossed = 0;
    for i in 0..rays {
        let data = &all[i as usize % 3];
        assert!(data.is_closed());
        let (points, _) = data.grid();
        let to_world = places[i as usize % 2];
        let shape = &shapes[i as usize % 2][i as usize % 3];
        // A corner of a cell, or a point of an edge or side.
        let free = random.random_range(0..3);
        let mut local = |axis: usize| {
            let cells = (points[axis] - 1) as f64;
            let at = f64::from(random.random_range(0..points[axis] as u32));
            if axis < free { random.random() } else { at / cells }
        };
        let target = to_world.point(Vec3::new(local(0), local(1), local(2)));
        let mut toward = direction(&mut random);
        if random.random_range(0..4) == 0 {
            toward = to_world.vector(Vec3::AXES[random.random_range(0..3)]).normalize();
        } else if random.random_range(0..4) == 0 {
            // Along a diagonal: through many edges or corners.
            let step = |random: &mut Random| f64::from(random.random_range(-1..=1i32));
            let local = Vec3::new(step(&mut random), step(&mut random), step(&mut random));
            toward = to_world.vector(local).try_normalize().unwrap_or(Vec3::X);
        }
        let found = shape.crossings(&Ray::new(target - toward * random.random_range(0.0..5.0), toward));
        let by_turns = found.iter().enumerate().all(|(i, crossing)| crossing.enters == (i % 2 == 0));
        assert!(
            found.len().is_multiple_of(2) && by_turns,
            "{i}: {target} {toward} {:?} {found:?}",
            to_world.inverse().point(target)
        );
        crossed += found.len();
    }
    assert!(crossed > rays as usize / 2);
}

/// Rays that leave the outside go away or on to another part; such as go in come out again.
#[test]
fn no_grid_is_met_where_it_is_left() {
    let mut random = Random::seed_from_u64(3);
    let data = ball(12);
    for (scale, distance) in PLACES {
        let place = placed([scale, distance], &mut random);
        let shape = shape(&place, &data);
        for _ in 0..20_000 {
            let Some(Leaving { point, angle, outward, inward }) = leave(&shape, &mut random) else {
                continue;
            };
            assert!(point.error < 1e-9 * scale.max(distance));
            if let Some(hit) = shape.intersect(&outward) {
                assert!(hit.t > 1e-4 * angle * scale, "{scale} {angle:e}: {:e}", hit.t);
            }
            let ahead = shape.crossings(&inward).iter().filter(|crossing| crossing.hit.t >= 0.0).count();
            assert!(ahead % 2 == 1, "{scale} {angle:e}");
        }
    }
}

/// A fine grid of a ball has its area and volume, and normals that point outward; smooth ones are nearer to
/// the ball's.
#[test]
fn a_ball_of_distances_is_a_ball() {
    let data = ball(48);
    let made = |smooth, flip| {
        Shape::Grid(Box::new(GridShape::Distances(
            SdfGrid::new(&Transform::IDENTITY, data.clone(), smooth, flip).unwrap(),
        )))
    };
    let [flat, round, flipped] = [made(false, false), made(true, false), made(true, true)];
    let area = 4.0 * std::f64::consts::PI * 0.375 * 0.375;
    assert!(close(round.area() / area, 1.0, 1e-3), "{}", round.area());
    let mut random = Random::seed_from_u64(1);
    let (mut analytic, mut smooth) = (0.0, 0.0);
    for _ in 0..2_000 {
        let ray = Ray::new(Vec3::splat(0.5), direction(&mut random));
        let outward = |shape: &Shape| {
            let hit = shape.intersect(&ray).unwrap();
            assert!(close(hit.t, 0.375, 5e-4));
            shape.surface(&hit, &ray)
        };
        let (with, without) = (outward(&round), outward(&flat));
        assert!(
            near(without.point.normal, ray.direction, 0.1) && without.shading_normal == without.point.normal
        );
        assert_eq!(outward(&flipped).point.normal, -with.point.normal);
        assert_eq!(outward(&flipped).shading_normal, -with.shading_normal);
        analytic += (without.shading_normal - ray.direction).length_squared();
        smooth += (with.shading_normal - ray.direction).length_squared();
    }
    assert!(smooth < 0.1 * analytic, "{smooth} {analytic}");
}

/// What Mitsuba 3.9.1 (scalar_rgb) answers to the same rays for the distance from a ball, 8 points along each
/// axis.
#[test]
fn normals_are_those_of_mitsuba() {
    let data = data([8; 3], |at| (at - Vec3::new(0.45, 0.5, 0.55)).length() - 0.3);
    let shape = |smooth| {
        Shape::Grid(Box::new(GridShape::Distances(
            SdfGrid::new(&Transform::IDENTITY, data.clone(), smooth, false).unwrap(),
        )))
    };
    let down = Ray::new(Vec3::new(0.5, 0.45, 5.0), -Vec3::Z);
    let slanted = Ray::new(Vec3::new(0.52, 0.53, 0.51), Vec3::new(0.6, 0.0, 0.8));
    for (ray, t, geometric, shading) in [
        (
            down,
            4.172_844_9,
            Vec3::new(0.189_515, 0.0, 0.981_878),
            Vec3::new(0.184_086, -0.153_458, 0.970_857),
        ),
        (
            slanted,
            0.265_774_3,
            Vec3::new(0.713_554, 0.0, 0.700_601),
            Vec3::new(0.810_64, 0.092_372_3, 0.578_213),
        ),
    ] {
        let hit = shape(true).intersect(&ray).unwrap();
        assert!(close(hit.t, t, 1e-6), "{hit:?}");
        let found = shape(true).surface(&hit, &ray);
        assert!(near(found.point.normal, geometric, 1e-5), "{found:?}");
        assert!(near(found.shading_normal, shading, 1e-5), "{found:?}");
        assert_eq!(shape(false).surface(&hit, &ray).shading_normal, found.point.normal);
    }
}

#[test]
fn what_has_no_surface_is_refused() {
    let made = |points, values: Vec<f32>| SdfData::new(points, values).err();
    assert_eq!(made([2, 2, 1], vec![1.0; 4]), Some(ShapeError::GridPoints));
    assert_eq!(made([2, 2, 2], vec![-1.0; 7]), Some(ShapeError::GridPoints));
    assert_eq!(made([2, 2, 2], vec![1.0; 8]), Some(ShapeError::Nothing));
    assert_eq!(made([2, 2, 2], vec![-1.0; 8]), Some(ShapeError::Nothing));
    let shape = shape(&Transform::IDENTITY, &ball(4));
    assert!(shape.crossings(&Ray::new(Vec3::ZERO, Vec3::NAN)).is_empty());
}
