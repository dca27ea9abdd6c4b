//! Rays that leave a surface meet it again where a closed form says so, and nowhere else.

use super::bodies::{Body, Form, Truth, bodies};
use super::table::{Table, count, seconds};
use super::{direction, in_parallel, placement, power, rising, trials};
use abbe::accel::{Accel, Instance};
use abbe::geometry::{Motion, Placed, Pose, Ray, SurfacePoint, Transform, Vec3};
use abbe::shape::{Hit, NO_INSTANCE, Shape};
use rand::RngExt;
use rand_pcg::Pcg64Mcg as Random;
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// All together, over all kinds of bodies. For a sixth of them there is no point to leave: not every sample
/// of a quadric is one.
const RAYS: u64 = 120_000_000;

/// Rays for one placement.
const RAYS_EACH: u64 = 4096;

/// Times are between 0 and 1.
const SHUTTER: [f64; 2] = [0.0, 1.0];

#[derive(Clone, Copy, Debug, PartialEq)]
enum Staging {
    /// The shape's own transform places it.
    Placed,
    Instance,
    Moving,
}

/// A body in the world.
struct Stage {
    shapes: Vec<Shape>,
    accel: Accel,
    form: Form,
    staging: Staging,
    motion: Option<Placed>,
    still: Pose,
}

impl Stage {
    fn new(body: &Body, staging: Staging, random: &mut Random) -> Self {
        let size = power(random, -6.0, 6.0);
        let stretch = match random.random_range(0..2) {
            0 => Vec3::ONE,
            _ => Vec3::from_array(std::array::from_fn(|_| random.random_range(0.2..1.0))),
        };
        // Vertices in single precision are themselves only that near to where they should be: see
        // `precision`.
        let farthest = if staging == Staging::Placed && body.is_mesh() { 10.0 } else { 1e5 };
        let to_world = placement(size, farthest, stretch, random);
        let placed = match staging {
            Staging::Placed => None,
            Staging::Instance => Some(Placed::still(&to_world).expect("a pose")),
            Staging::Moving => {
                let turn = Transform::new(glam::DMat4::from_axis_angle(direction(random), 1.0));
                let next = turn.expect("a rotation").then(&to_world);
                let next = next.then(&Transform::translation(size * direction(random)));
                let motion = Motion::new(&[(0.0, to_world), (1.0, next)]).expect("a motion");
                Some(Placed::moving(motion).expect("a pose"))
            }
        };
        let shape = body.at(if placed.is_some() { &Transform::IDENTITY } else { &to_world });
        let still = Pose::new(if body.is_mesh() { &Transform::IDENTITY } else { &to_world });
        let form = match &shape {
            Shape::Mesh(mesh) if !matches!(body.form, Form::Flat) => Form::of_mesh(mesh),
            _ => body.form.clone(),
        };
        let shapes = vec![shape];
        let accel = match placed.clone() {
            None => Accel::build(&shapes),
            Some(placed) => {
                let group = Arc::new(Accel::of_group(&shapes, 0, &[]));
                Accel::with_instances(&[], &[], vec![Instance::new(group, placed)], SHUTTER)
            }
        };
        Self { shapes, accel, form, staging, motion: placed, still }
    }

    /// From the coordinates of the form to the world.
    fn pose(&self, time: f64) -> Pose {
        self.motion.as_ref().map_or(self.still, |placed| placed.at(time))
    }

    /// A point of the surface: chosen on it, or where a ray from near or far met it.
    fn point(&self, pose: &Pose, time: f64, random: &mut Random) -> Option<(SurfacePoint, u32)> {
        let sample = self.shapes[0].sample([random.random(), random.random()])?;
        let point = sample.surface.point;
        if self.motion.is_none() && random.random() {
            return Some((point, sample.triangle));
        }
        let (position, normal) = match self.motion {
            None => (point.position, point.normal),
            Some(_) => (pose.world_point(point.position), pose.world_normal(point.normal).normalize()),
        };
        let from = rising(if random.random() { normal } else { -normal }, random);
        let distance = self.accel.bounds().diameter() * power(random, -3.0, 1.0);
        let ray = Ray::new(position + from * distance, -from);
        let hit = self.accel.closest(&ray, time)?;
        Some((self.accel.surface(&self.shapes, &hit, &ray, time).point, hit.triangle))
    }
}

/// What became of the rays of one kind of body.
#[derive(Default)]
struct Counts {
    rays: u64,
    unsure: u64,
    /// Something was met, or too near, where it should not.
    false_hits: u64,
    /// Nothing was met, or too far away, where something should.
    lost: u64,
    /// The largest offset from the surface in units of ε times the distance from the origin and the body's
    /// size.
    offset: f64,
}

impl Counts {
    fn add(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            unsure: self.unsure + other.unsure,
            false_hits: self.false_hits + other.false_hits,
            lost: self.lost + other.lost,
            offset: self.offset.max(other.offset),
        }
    }
}

/// The first few failures, for the message.
static EXAMPLES: Mutex<Vec<String>> = Mutex::new(Vec::new());

fn cast(stage: &Stage, name: &str, random: &mut Random, counts: &mut Counts) {
    let time = if stage.staging == Staging::Moving { random.random() } else { 0.0 };
    let pose = stage.pose(time);
    let Some((point, part)) = stage.point(&pose, time, random) else { return };
    let side = if random.random() { 1.0 } else { -1.0 };
    let away = rising(point.normal * side, random);
    let ray = point.ray(away);
    let hit = stage.accel.closest(&ray, time);
    counts.rays += 1;
    let reach = point.position.length() + stage.accel.bounds().diameter();
    counts.offset = counts.offset.max(point.error / (f64::EPSILON * reach));
    let truth = stage.form.leave(pose.local_point(point.position), part, pose.local_vector(away));
    let start = away.dot(point.normal).abs();
    let (false_hit, lost) = match (truth, hit) {
        (Truth::Unsure, _) => {
            counts.unsure += 1;
            return;
        }
        (Truth::Nothing, Some(_)) => (true, false),
        (Truth::Nothing, None) => (false, false),
        (Truth::At { t, normal, dent }, hit) => {
            let image = pose.world_normal(normal);
            let end = image.dot(away).abs() / image.length();
            // By as much as the offset, and the errors at the other end, can change the distance.
            let error = 4.0 * point.error + 2.0 * dent / image.length();
            let tolerance = error * (1.0 / start + 1.0 / end) + 1e-13 * t;
            if tolerance > 0.1 * t {
                counts.unsure += 1;
                return;
            }
            match hit {
                None => (false, true),
                Some(Hit { t: found, .. }) => (found < t - tolerance, found > t + tolerance),
            }
        }
    };
    counts.false_hits += u64::from(false_hit);
    counts.lost += u64::from(lost);
    if false_hit || lost {
        let mut examples = EXAMPLES.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if examples.len() < 12 {
            examples.push(format!(
                "{name} {:?}: {truth:?}, found {:?}, elevation {:e}, part {part}, {point:?}, {ray:?}",
                stage.staging,
                hit.map(|hit| (hit.t, hit.triangle, hit.instance == NO_INSTANCE)),
                away.dot(point.normal),
            ));
        }
    }
}

#[test]
fn rays_that_leave_do_not_return() {
    let bodies = bodies();
    let stagings = [Staging::Placed, Staging::Instance, Staging::Moving];
    let kinds = (bodies.len() * stagings.len()) as u64;
    let placements = trials(RAYS).div_ceil(kinds * RAYS_EACH);
    let mut table = Table::new(
        "Rays that leave a surface, at all angles down to 10⁻⁴ rad, 10⁻⁶ to 10⁶ units large, up to 10⁵ diameters from the origin",
        &["body", "rays", "false hits", "lost", "too near to tell", "offset / ε", "s"],
    );
    let mut total = Counts::default();
    for body in &bodies {
        for staging in stagings {
            let began = Instant::now();
            let trial = |_, random: &mut Random, counts: &mut Counts| {
                let stage = Stage::new(body, staging, random);
                for _ in 0..RAYS_EACH {
                    cast(&stage, body.name, random, counts);
                }
            };
            let found = in_parallel(placements, staging as u64, trial, Counts::add);
            let name = match staging {
                Staging::Placed => body.name.to_owned(),
                Staging::Instance => format!("{}, instance", body.name),
                Staging::Moving => format!("{}, moving", body.name),
            };
            table.row(&[
                name,
                count(found.rays),
                count(found.false_hits),
                count(found.lost),
                count(found.unsure),
                format!("{:.0}", found.offset),
                seconds(began),
            ]);
            total = total.add(found);
        }
    }
    table.row(&[
        "all".to_owned(),
        count(total.rays),
        count(total.false_hits),
        count(total.lost),
        count(total.unsure),
        format!("{:.0}", total.offset),
    ]);
    table.print();
    let examples = EXAMPLES.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    assert!(total.false_hits + total.lost == 0, "{}", examples.join("\n"));
    assert!(total.unsure * 20 < total.rays, "what cannot be told is no test");
}
