//! How precisely surfaces are met from near and far: the distance to a known point of them.

use super::bodies::{Form, Truth, bodies};
use super::renders::{compiled, description};
use super::table::{Table, count, seconds};
use super::{direction, in_parallel, power, trials};
use abbe::accel::Accel;
use abbe::geometry::{Ray, Transform};
use abbe::render::{Schedule, auxiliary};
use abbe::scene::description::{Aov, AovKind};
use abbe::shape::Shape;
use abbe::units::WavelengthRange;
use rand::RngExt;
use rand_pcg::Pcg64Mcg as Random;
use std::time::Instant;

/// All together.
const RAYS: u64 = 20_000_000;

/// Bounds on relative errors: seen from 10⁶ away, from anywhere in double precision, and rounded to single
/// precision.
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

/// A ray from a thousandth of the body's size to a million times that away, towards a point of the surface,
/// steeply enough that the point's own rounding does not count.
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

/// A thing far away makes the scene large. The faces of a small cube do not turn for that, though vertices
/// are stored in single precision.
#[test]
fn what_is_far_away_tilts_no_face() {
    let scene = |more: &str| {
        format!(
            r#"<sensor type="orthographic"><transform name="to_world"><lookat origin="0.3, -0.4, 5" target="0, 0, 0" up="0, 1, 0"/>
               </transform><film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="24"/>
               <rfilter type="box"/></film></sensor>
               <shape type="cube"><transform name="to_world"><scale value="0.5"/><rotate x="1" y="2" z="3" angle="50"/>
               <translate x="0.1" y="0.2"/></transform></shape>{more}"#
        )
    };
    let normals = |content: &str| {
        let scene = compiled(&description(content));
        let aovs =
            [AovKind::ShadingNormal, AovKind::Depth].map(|kind| Aov { name: kind.name().to_owned(), kind });
        let images = auxiliary(&scene, &aovs, WavelengthRange::VISIBLE, Schedule::new(16), 1);
        images.into_iter().map(|image| image.values).collect::<Vec<_>>()
    };
    let alone = normals(&scene(""));
    let mut table = Table::new(
        "What a thing far away does to a cube of the size of 1",
        &["how far", "largest change of normals", "of depths"],
    );
    let mut largest = 0.0f32;
    for far in [1e3, 1e6, 1e9] {
        let lamp = format!(
            r#"<shape type="sphere"><point name="center" x="{far:e}" y="{:e}" z="0"/></shape>"#,
            0.3 * far
        );
        let beside = normals(&scene(&lamp));
        // But for one pixel in a hundred: where two faces meet, a sample or another falls on the other one.
        let apart = |images: std::ops::Range<usize>| {
            let pairs = images.flat_map(|image| alone[image].iter().zip(&beside[image]));
            let mut changes: Vec<f32> = pairs.map(|(a, b)| (a - b).abs()).collect();
            changes.sort_by(f32::total_cmp);
            changes[changes.len() * 99 / 100]
        };
        table.row(&[format!("{far:.0e}"), format!("{:.1e}", apart(0..3)), format!("{:.1e}", apart(3..4))]);
        largest = largest.max(apart(0..4));
    }
    table.print();
    assert!(alone[2].iter().any(|&z| z != 0.0), "the cube is not in the picture");
    // 10³ away the cube still shares the coordinates of the scene.
    assert!(largest < 1e-4, "{largest}");
}
