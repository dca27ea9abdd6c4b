//! How precisely surfaces are met from near and far: the distance to a known point of them.

use super::bodies::{Form, Truth, bodies};
use super::table::{Table, count, seconds};
use super::{direction, in_parallel, power, trials};
use abbe::accel::Accel;
use abbe::geometry::{Ray, Transform};
use abbe::shape::Shape;
use rand::RngExt;
use rand_pcg::Pcg64Mcg as Random;
use std::time::Instant;

/// All together.
const RAYS: u64 = 20_000_000;

/// Bounds on relative errors: seen from 10⁶ away, from anywhere in double precision, and rounded to single precision.
const FROM_FAR: f64 = 1e-9;
const IN_DOUBLE: f64 = 1e-9;
const IN_SINGLE: f64 = 1e-6;

#[derive(Default)]
struct Counts {
    rays: u64,
    lost: u64,
    from_far: f64,
    in_double: f64,
    in_single: f64,
}

impl Counts {
    fn add(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            lost: self.lost + other.lost,
            from_far: self.from_far.max(other.from_far),
            in_double: self.in_double.max(other.in_double),
            in_single: self.in_single.max(other.in_single),
        }
    }
}

/// A ray from a thousandth of the body's size to a million times that away, towards a point of the surface, steeply enough
/// that the point's own rounding does not count.
fn cast(form: &Form, shape: &Shape, accel: &Accel, random: &mut Random, counts: &mut Counts) {
    let Some(sample) = shape.sample([random.random(), random.random()]) else { return };
    let point = sample.surface.point;
    let normal = if random.random() { point.normal } else { -point.normal };
    let away = loop {
        let away = direction(random);
        if away.dot(normal) > 0.02 {
            break away;
        }
    };
    let distance = if random.random_range(0..4) == 0 { 1e6 } else { power(random, -3.0, 6.0) };
    let origin = point.position + away * distance;
    match form.leave(point.position, sample.triangle, away) {
        Truth::Nothing => {}
        Truth::At { t, .. } if t > 1.001 * distance => {}
        _ => return,
    }
    counts.rays += 1;
    let expected = (point.position - origin).length();
    let Some(hit) = accel.closest(&Ray::new(origin, -away), 0.0) else {
        counts.lost += 1;
        return;
    };
    let error = (hit.t / expected - 1.0).abs();
    counts.in_double = counts.in_double.max(error);
    counts.in_single = counts.in_single.max((f64::from(hit.t as f32) / expected - 1.0).abs());
    if distance == 1e6 {
        counts.from_far = counts.from_far.max(error);
    }
}

#[test]
fn distances_are_precise() {
    let bodies = bodies();
    let each = trials(RAYS).div_ceil(bodies.len() as u64);
    let mut table = Table::new(
        "Largest relative errors of the distance to a body of the size of 1, from 10⁻³ to 10⁶ away",
        &["body", "rays", "lost", "from 10⁶", "from anywhere", "in single precision", "s"],
    );
    let mut total = Counts::default();
    for body in &bodies {
        let began = Instant::now();
        let shape = body.at(&Transform::IDENTITY);
        let form = match &shape {
            Shape::Mesh(mesh) if !matches!(body.form, Form::Flat) => Form::of_mesh(mesh),
            _ => body.form.clone(),
        };
        let accel = Accel::build(std::slice::from_ref(&shape));
        let trial = |_, random: &mut Random, counts: &mut Counts| {
            for _ in 0..1024 {
                cast(&form, &shape, &accel, random, counts);
            }
        };
        let found = in_parallel(each.div_ceil(1024), 3, trial, Counts::add);
        table.row(&[
            body.name.to_owned(),
            count(found.rays),
            count(found.lost),
            format!("{:.1e}", found.from_far),
            format!("{:.1e}", found.in_double),
            format!("{:.1e}", found.in_single),
            seconds(began),
        ]);
        total = total.add(found);
    }
    table.print();
    assert_eq!(total.lost, 0);
    assert!(total.from_far < FROM_FAR, "{:e}", total.from_far);
    assert!(total.in_double < IN_DOUBLE, "{:e}", total.in_double);
    assert!(total.in_single < IN_SINGLE, "{:e}", total.in_single);
}
