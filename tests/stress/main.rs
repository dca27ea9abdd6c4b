//! Geometry and renderer under stress: what happens at edges and vertices, at grazing angles, near contact,
//! from 10⁻⁶ to 10⁶ units, far from the origin, and with materials and lights at the ends of their ranges.
//! Each part prints a table of what was tried and what went wrong.
//!
//! By default a share of the rays is cast. `ABBE_STRESS=full` casts all of them; CONTRIBUTING.md has the
//! command and what it found last.

mod bodies;
#[path = "../common/mod.rs"]
mod common;
mod contact;
mod extremes;
mod fuzz;
mod leaks;
mod precision;
mod renders;
mod scales;
mod self_hits;
mod table;

use abbe::geometry::{Transform, Vec3};
use common::stress::count;
use glam::{DMat4, DQuat};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg as Random;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use std::f64::consts::TAU;

/// How many of `full` trials are made: by default one in a hundred.
fn trials(full: u64) -> u64 {
    count(full.div_ceil(100), full)
}

/// Runs numbered trials on all cores, each with random numbers of its own, and adds up what they count.
fn in_parallel<T: Default + Send>(
    trials: u64,
    seed: u64,
    trial: impl Fn(u64, &mut Random, &mut T) + Sync,
    add: impl Fn(T, T) -> T + Sync + Send,
) -> T {
    let one = |number: u64| {
        let mut random = Random::seed_from_u64(number.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ seed);
        let mut counts = T::default();
        trial(number, &mut random, &mut counts);
        counts
    };
    (0..trials).into_par_iter().map(one).reduce(T::default, add)
}

fn direction(random: &mut Random) -> Vec3 {
    let z: f64 = random.random_range(-1.0..1.0);
    let (sin, cos) = random.random_range(0.0..TAU).sin_cos();
    let r = (1.0 - z * z).sqrt();
    Vec3::new(r * cos, r * sin, z)
}

fn in_cube(random: &mut Random) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| random.random_range(-1.0..1.0)))
}

/// 10 to a power between two.
fn power(random: &mut Random, low: f64, high: f64) -> f64 {
    10f64.powf(random.random_range(low..high))
}

/// A unit vector that rises over the plane under the unit vector `normal` by an angle between 10⁻⁴ rad and a
/// right angle, small ones as often as large ones.
fn rising(normal: Vec3, random: &mut Random) -> Vec3 {
    let across = loop {
        if let Some(across) = direction(random).reject_from(normal).try_normalize() {
            break across;
        }
    };
    let (sin, cos) = power(random, -4.0, 0.196).sin_cos();
    across * cos + normal * sin
}

/// Turned anyhow, stretched, scaled to `size` and moved by up to `farthest` times that.
fn placement(size: f64, farthest: f64, stretch: Vec3, random: &mut Random) -> Transform {
    let rotation = DQuat::from_axis_angle(direction(random), random.random_range(0.0..TAU));
    let offset = match random.random_range(0..3) {
        0 => Vec3::ZERO,
        1 => direction(random) * (size * farthest),
        _ => direction(random) * (size * power(random, -1.0, farthest.log10())),
    };
    let place = DMat4::from_scale_rotation_translation(stretch * size, rotation, offset);
    Transform::new(place).expect("an invertible map")
}
