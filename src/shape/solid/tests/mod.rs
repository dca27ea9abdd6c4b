//! Solids against functions that are negative inside them.

mod kit;
mod laws;
mod meshes;

use super::{Boundary, Operation, Solid};
use crate::geometry::{Ray, Transform, Vec3};
use crate::shape::Crossing;
use kit::{Item, Model, turned};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg as Random;
use rayon::prelude::*;
use std::ops::ControlFlow;

const OPERATIONS: [Operation; 3] = [Operation::Union, Operation::Intersection, Operation::Difference];

fn in_cube(random: &mut Random) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| random.random_range(-1.0..1.0)))
}

fn direction(random: &mut Random) -> Vec3 {
    loop {
        let v = in_cube(random);
        if (1e-3..1.0).contains(&v.length_squared()) {
            return v.normalize();
        }
    }
}

fn faces(solid: &Solid, ray: &Ray) -> Vec<Boundary> {
    let mut found = Vec::new();
    solid.walk::<()>(ray, 0.0, |boundary| {
        found.push(boundary);
        ControlFlow::Continue(())
    });
    found
}

/// What a line was judged by.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    lines: u64,
    hits: u64,
    places: u64,
    /// Places too near to a surface for the functions to be sure.
    doubtful: u64,
    mismatches: u64,
    /// Short stretches that are there: beside the line where round and flat faces touch there is a gap as
    /// thin as one likes.
    thin: u64,
    /// All others, which can only be walls or skins.
    slivers: u64,
}

impl Tally {
    fn and(self, other: Self) -> Self {
        Self {
            lines: self.lines + other.lines,
            hits: self.hits + other.hits,
            places: self.places + other.places,
            doubtful: self.doubtful + other.doubtful,
            mismatches: self.mismatches + other.mismatches,
            thin: self.thin + other.thin,
            slivers: self.slivers + other.slivers,
        }
    }
}

/// Shorter stretches are met near edges, by one line in 10⁹ or so at most, and where faces touch along a
/// line: beside a cylinder of radius 1 in a cube the gap at a distance d from that line is d²/2, so a line in
/// 10⁵ or so crosses less than this.
const SLIVER: f64 = 1e-10;

/// How far rounding puts faces beside their places, as a fraction of the solid's size, with reserve.
const ROUNDING: f64 = 1e-14;

/// Follows random lines through a solid of about the size `scale` around `centre` and compares the stretches
/// within it with the functions: in the middle of each, between them, and anywhere.
fn judge(model: &Model, place: &Transform, lines: u64, seed: u64) -> Tally {
    let (solid, depth) = (model.solid(), model.depth());
    let scale = place.uniform_scale().unwrap();
    let mut random = Random::seed_from_u64(seed);
    let mut tally = Tally { lines, ..Tally::default() };
    for _ in 0..lines {
        let target = place.point(1.2 * in_cube(&mut random));
        let toward = direction(&mut random);
        let ray = Ray::new(target - toward * (scale * 6.0), toward);
        let found = faces(&solid, &ray);
        tally.hits += u64::from(!found.is_empty());
        let mut within = false;
        let mut from = 0.0;
        let look = |t: f64, within: bool, tally: &mut Tally| {
            let depth = depth(ray.at(t));
            tally.places += 1;
            if depth.abs() < 1e-12 {
                tally.doubtful += 1;
            } else if (depth < 0.0) != within {
                tally.mismatches += 1;
            }
        };
        for Boundary { crossing, .. } in &found {
            let Crossing { hit, enters, .. } = *crossing;
            assert_ne!(enters, within);
            let length = (hit.t - from) / scale;
            let middle = 0.5 * (from + hit.t);
            if length >= SLIVER {
                look(middle, within, &mut tally);
            } else if model
                .exact_depth(&ray, middle)
                .is_some_and(|depth| depth.abs() > ROUNDING && (depth < 0.0) == within)
            {
                tally.thin += 1;
            } else {
                tally.slivers += 1;
            }
            (within, from) = (enters, hit.t);
        }
        assert!(!within, "a line never leaves");
        for _ in 0..2 {
            let t = random.random_range(3.0..9.0) * scale;
            let passed = found.iter().rev().find(|face| face.crossing.hit.t <= t);
            look(t, passed.is_some_and(|face| face.crossing.enters), &mut tally);
        }
        // The nearest hit is the first face ahead.
        let start = random.random_range(3.0..9.0) * scale;
        let ahead = Ray::new(ray.at(start), toward);
        let expected = found.iter().find(|face| face.crossing.hit.t >= start + 1e-9 * scale);
        let first = solid.closest(&ahead, 0.0);
        let same = match (expected, first) {
            (None, None) => true,
            (Some(face), Some(hit)) => {
                (hit.t + start - face.crossing.hit.t).abs() < 1e-9 * scale
                    && hit.shape == face.crossing.hit.shape
            }
            _ => false,
        };
        tally.mismatches += u64::from(!same);
    }
    tally
}

fn report(what: &str, tally: Tally) {
    println!("{what}: {tally:?}");
    assert_eq!((tally.mismatches, tally.slivers), (0, 0), "{what}: {tally:?}");
    assert!(tally.hits * 50 > tally.lines, "{what}: hardly a line hits anything: {tally:?}");
    assert!(tally.doubtful * 1_000_000 <= tally.places, "{what}: {tally:?}");
}

fn pair(operation: Operation, a: &(Item, Transform), b: &(Item, Transform)) -> Model {
    let leaf = |(item, place): &(Item, Transform)| Model::Leaf(item.clone(), *place);
    Model::Node(operation, vec![leaf(a), leaf(b)])
}

/// All pairs of shapes, where they penetrate one another.
fn judge_pairs(lines: u64) {
    let items = kit::all();
    let first = turned(0.4, Vec3::new(1.0, 0.9, 1.1), Vec3::new(0.1, -0.2, 0.05));
    let second = turned(2.3, Vec3::new(0.8, 1.0, 0.9), Vec3::new(0.35, 0.2, -0.25));
    let pairs: Vec<(usize, usize)> =
        (0..items.len()).flat_map(|i| (0..items.len()).map(move |j| (i, j))).collect();
    let all = pairs
        .into_par_iter()
        .flat_map(|(i, j)| OPERATIONS.into_par_iter().map(move |operation| (i, j, operation)))
        .map(|(i, j, operation)| {
            let (a, b) = ((items[i].clone(), first), (items[j].clone(), second));
            let seed = (i * 100 + j) as u64;
            let tally = judge(&pair(operation, &a, &b), &Transform::IDENTITY, lines, seed);
            let what = format!("{} {operation:?} {}", a.0.name, b.0.name);
            assert_eq!((tally.mismatches, tally.slivers), (0, 0), "{what}: {tally:?}");
            tally
        })
        .reduce(Tally::default, Tally::and);
    report("pairs", all);
}

#[test]
fn pairs_are_what_their_parts_are() {
    judge_pairs(crate::stress::count(2_000, 1_000_000));
}

/// Parts whose faces coincide, in places where nothing is a round number.
fn coincident() -> Vec<(&'static str, Model)> {
    let at = |x: f64, y: f64, z: f64| Transform::translation(Vec3::new(x, y, z));
    let wide = Transform::new(glam::DMat4::from_scale(Vec3::new(0.5, 0.5, 1.0))).unwrap();
    let (cube, cylinder, sphere) = (kit::cube(), kit::cylinder(), kit::sphere());
    let all = kit::all();
    let named = |name: &str| all.iter().find(|item| item.name == name).unwrap().clone();
    let unmoved = Transform::IDENTITY;
    let mut models = Vec::new();
    let mut add = |what, a: (&Item, Transform), b: (&Item, Transform)| {
        let (a, b) = ((a.0.clone(), a.1), (b.0.clone(), b.1));
        for operation in OPERATIONS {
            models.push((what, pair(operation, &a, &b)));
            models.push((what, pair(operation, &b, &a)));
        }
    };
    add("abutting cubes", (&cube, unmoved), (&cube, at(2.0, 0.0, 0.0)));
    add("cubes flush on four sides", (&cube, unmoved), (&cube, at(1.0, 0.0, 0.0)));
    add("a cutter flush at both ends", (&cube, unmoved), (&cylinder, wide));
    add("a cylinder on a cube", (&cube, unmoved), (&cylinder, at(0.0, 0.0, 2.0)));
    add("a cylinder in a cube, touching", (&cube, unmoved), (&cylinder, unmoved));
    add("a cone and a cylinder on one base", (&named("cone"), unmoved), (&cylinder, unmoved));
    add("an angle iron in a cube", (&named("angle iron"), unmoved), (&cube, unmoved));
    add("an angle iron and what it lacks", (&named("angle iron"), unmoved), (&cube, at(1.0, 1.0, 0.0)));
    add("a sphere that touches", (&sphere, unmoved), (&cube, at(0.0, 0.0, 2.0)));
    for item in &all {
        add("the same twice", (item, unmoved), (item, unmoved));
    }
    models
}

fn placed(model: &Model, place: &Transform) -> Model {
    match model {
        Model::Leaf(item, own) => Model::Leaf(item.clone(), own.then(place)),
        Model::Node(operation, parts) => {
            Model::Node(*operation, parts.iter().map(|part| placed(part, place)).collect())
        }
    }
}

fn judge_coincident(lines: u64) {
    let places = [
        turned(0.7, Vec3::splat(1.0), Vec3::new(0.13, 0.27, -0.31)),
        turned(1.9, Vec3::splat(1.3e-6), Vec3::new(2.7e-6, 1e-6, 0.0)),
        turned(4.1, Vec3::splat(7.7e5), Vec3::new(-3.1e6, 1e6, 2e5)),
    ];
    let tally = coincident()
        .into_par_iter()
        .flat_map(|(what, model)| (0..places.len()).into_par_iter().map(move |i| (what, model.clone(), i)))
        .map(|(what, model, index)| {
            let place = &places[index];
            let tally = judge(&placed(&model, place), place, lines, index as u64);
            assert_eq!((tally.mismatches, tally.slivers), (0, 0), "{what} {index}: {tally:?}");
            let touches = what == "a cylinder in a cube, touching";
            assert!(tally.thin == 0 || touches, "{what} {index}: {tally:?}");
            tally
        })
        .reduce(Tally::default, Tally::and);
    // Many places are in doubt here: a chord from end to end of two boxes that abut has its middle in the
    // wall between them.
    println!("coincident faces: {tally:?}");
    assert!(tally.hits * 4 > tally.lines, "{tally:?}");
}

#[test]
fn faces_that_coincide_are_one_or_none() {
    judge_coincident(crate::stress::count(1_000, 350_000));
}

fn random_tree(items: &[Item], depth: u32, random: &mut Random) -> Model {
    if depth == 0 {
        let item = items[random.random_range(0..items.len())].clone();
        let place = turned(
            random.random_range(0.0..6.0),
            Vec3::splat(random.random_range(0.5..1.2)),
            0.6 * in_cube(random),
        );
        return Model::Leaf(item, place);
    }
    let operation = OPERATIONS[random.random_range(0..3)];
    let count = random.random_range(1..4);
    // At least one part goes all the way down.
    let parts = (0..count).map(|i| {
        let depth = if i == 0 { depth - 1 } else { random.random_range(0..depth) };
        random_tree(items, depth, random)
    });
    Model::Node(operation, parts.collect())
}

fn judge_nested(trees: u64, lines: u64) {
    let items = kit::all();
    let tally = (0..trees)
        .into_par_iter()
        .map(|seed| {
            let model = random_tree(&items, 5, &mut Random::seed_from_u64(seed));
            let tally = judge(&model, &Transform::IDENTITY, lines, seed);
            assert_eq!((tally.mismatches, tally.slivers), (0, 0), "tree {seed}: {tally:?}");
            tally
        })
        .reduce(Tally::default, Tally::and);
    report("trees of depth 5", tally);
}

#[test]
fn nested_trees_are_what_their_parts_are() {
    judge_nested(crate::stress::count(100, 1_000), 1_000);
}
