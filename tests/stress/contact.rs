//! Where two bodies touch, rays that leave one of them meet the other, however narrow the gap, as long as it
//! is wider than what rounding may do to both surfaces.

use super::table::{Table, count, seconds};
use super::{direction, in_parallel, placement, power, trials};
use abbe::accel::{Accel, Instance};
use abbe::geometry::{Placed, Ray, SurfacePoint, Transform, Vec3};
use abbe::shape::{Cylinder, Disk, Mesh, Quadric, QuadricKind, Shape, ShapeError, Sphere, Torus};
use rand::RngExt;
use rand_pcg::Pcg64Mcg as Random;
use std::f64::consts::TAU;
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// All together.
const RAYS: u64 = 20_000_000;

/// Rays for one placement.
const RAYS_EACH: u64 = 4096;

type Shapes = Result<[Shape; 2], ShapeError>;

/// Two bodies, one above the other, that touch in z = 0 (or leave a gap between them).
struct Pair {
    name: &'static str,
    /// The lower and the upper, placed, of which the upper has this size.
    make: fn(&Transform, f64) -> Shapes,
    /// A place where they touch, and the way along which the gap widens from there.
    touch: fn(f64, &mut Random) -> [Vec3; 2],
    /// Whether meshes are among them: these are then instances, whose vertices are exact.
    exact: bool,
}

fn any_way(random: &mut Random) -> Vec3 {
    let (sin, cos) = random.random_range(0.0..TAU).sin_cos();
    Vec3::new(cos, sin, 0.0)
}

fn in_a_point(_: f64, random: &mut Random) -> [Vec3; 2] {
    [Vec3::ZERO, any_way(random)]
}

fn disk(place: &Transform) -> Result<Shape, ShapeError> {
    Ok(Shape::Disk(Disk::new(place, false)?))
}

fn ball(place: &Transform, centre: f64, radius: f64) -> Result<Shape, ShapeError> {
    Ok(Shape::Sphere(Sphere::new(place, Vec3::Z * centre, radius, false)?))
}

fn quadric(place: &Transform, kind: &QuadricKind) -> Result<Shape, ShapeError> {
    Ok(Shape::Quadric(Box::new(Quadric::of_kind(place, kind, true, false)?)))
}

fn pairs() -> Vec<Pair> {
    vec![
        Pair {
            name: "ball on a disk",
            make: |place, r| Ok([disk(place)?, ball(place, r, r)?]),
            touch: in_a_point,
            exact: false,
        },
        Pair {
            name: "ball on a rectangle",
            make: |place, r| Ok([Shape::Mesh(Mesh::rectangle(place, false)?), ball(place, r, r)?]),
            touch: in_a_point,
            exact: true,
        },
        Pair {
            name: "ball on a ball",
            make: |place, r| Ok([ball(place, -0.5, 0.5)?, ball(place, r, r)?]),
            touch: in_a_point,
            exact: false,
        },
        Pair {
            name: "cylinder lying on a disk",
            make: |place, r| {
                let ends = [-1.0, 1.0].map(|x| Vec3::new(x, 0.0, r));
                Ok([disk(place)?, Shape::Cylinder(Cylinder::new(place, ends[0], ends[1], r, false)?)])
            },
            touch: |_, random| {
                let side = if random.random() { Vec3::Y } else { -Vec3::Y };
                [Vec3::X * random.random_range(-0.5..0.5), side]
            },
            exact: false,
        },
        Pair {
            name: "torus lying on a disk",
            make: |place, r| {
                let place = Transform::translation(Vec3::Z * r).then(place);
                let below = Transform::translation(-Vec3::Z * r).then(&place);
                Ok([disk(&below)?, Shape::Torus(Box::new(Torus::new(&place, 0.5, r, false)?))])
            },
            touch: |_, random| {
                let out = any_way(random);
                [0.5 * out, if random.random() { out } else { -out }]
            },
            exact: false,
        },
        Pair {
            name: "cone on its tip",
            make: |place, r| {
                let kind = QuadricKind::Cone { from: Vec3::ZERO, to: Vec3::Z * r, radii: [0.0, r] };
                Ok([disk(place)?, quadric(place, &kind)?])
            },
            touch: in_a_point,
            exact: false,
        },
        Pair {
            name: "paraboloid on its tip",
            make: |place, r| {
                let kind = QuadricKind::Paraboloid { from: Vec3::ZERO, to: Vec3::Z * r, radius: r };
                Ok([disk(place)?, quadric(place, &kind)?])
            },
            touch: in_a_point,
            exact: false,
        },
        Pair {
            name: "box over a rectangle",
            make: |place, r| {
                // The gap is 10⁻¹¹ to 10⁻⁴. Vertices so near to 0 are as exact as they need be.
                let gap = Transform::translation(Vec3::Z * (0.5 + 1e-12 / (r * r * r)));
                let cube = Mesh::cube(&Transform::scale(0.5).then(&gap).then(place), false)?;
                Ok([Shape::Mesh(Mesh::rectangle(place, false)?), Shape::Mesh(cube)])
            },
            touch: |_, random| [any_way(random) * random.random_range(0.0..0.2), any_way(random)],
            exact: true,
        },
    ]
}

/// The pair in the world: each alone, and both.
struct Stage {
    shapes: Vec<Shape>,
    lower: Accel,
    upper: Accel,
    both: Accel,
    to_world: Transform,
    size: f64,
}

impl Stage {
    fn new(pair: &Pair, random: &mut Random) -> Self {
        let to_world = placement(power(random, -6.0, 6.0), 1e5, Vec3::ONE, random);
        let size = power(random, -2.5, -0.5);
        let as_instance = pair.exact || random.random();
        let place = if as_instance { &Transform::IDENTITY } else { &to_world };
        let shapes = Vec::from((pair.make)(place, size).expect("shapes that can be placed"));
        let tree = |from: usize, to: usize| {
            let group = Accel::of_group(&shapes[from..to], from as u32, &[]);
            if !as_instance {
                return group;
            }
            let placed = Placed::still(&to_world).expect("a pose");
            Accel::with_instances(&[], &[], vec![Instance::new(Arc::new(group), placed)], [0.0; 2])
        };
        let [lower, upper, both] = [tree(0, 1), tree(1, 2), tree(0, 2)];
        Self { shapes, lower, upper, both, to_world, size }
    }

    /// Where a vertical line meets one of them, coming from the side of the gap.
    fn point(&self, accel: &Accel, at: Vec3, from: f64) -> Option<SurfacePoint> {
        let origin = self.to_world.point(at.with_z(from));
        let down = self.to_world.vector(Vec3::NEG_Z * from.signum()).normalize();
        let ray = Ray::new(origin, down);
        let hit = accel.closest(&ray, 0.0)?;
        Some(accel.surface(&self.shapes, &hit, &ray, 0.0).point)
    }
}

struct Counts {
    rays: u64,
    narrow: u64,
    missed: u64,
    narrowest: f64,
}

impl Default for Counts {
    fn default() -> Self {
        Self { rays: 0, narrow: 0, missed: 0, narrowest: f64::INFINITY }
    }
}

impl Counts {
    fn add(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            narrow: self.narrow + other.narrow,
            missed: self.missed + other.missed,
            narrowest: self.narrowest.min(other.narrowest),
        }
    }
}

static EXAMPLES: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// A ray from each of two points near the contact to the other.
fn cast(pair: &Pair, stage: &Stage, random: &mut Random, counts: &mut Counts) {
    let [touch, way] = (pair.touch)(stage.size, random);
    let away = stage.size * power(random, -7.0, -0.3);
    let above = touch + way * away;
    let Some(upper) = stage.point(&stage.upper, above, -1.0) else { return };
    // The other side of a torus may be in the way of what is further off.
    let aside = away * power(random, -3.0, if pair.name.starts_with("torus") { -0.3 } else { 0.5 });
    let beside = above + direction(random).with_z(0.0).normalize_or_zero() * aside;
    let Some(lower) = stage.point(&stage.lower, beside, 1.0) else { return };
    let (gap, distance) = (upper.position - lower.position, (upper.position - lower.position).length());
    let sines = [lower, upper].map(|point| point.normal.dot(gap).abs() / distance);
    // Seen from one another, and not along the surface.
    if !(lower.normal.dot(gap) > 0.0 && upper.normal.dot(gap) < 0.0) {
        return;
    }
    let errors = lower.error / sines[0] + upper.error / sines[1];
    if distance < 4.0 * errors || !distance.is_finite() {
        counts.narrow += 1;
        return;
    }
    counts.narrowest = counts.narrowest.min(distance / errors);
    for (from, to, shape) in [(&lower, &upper, 1), (&upper, &lower, 0)] {
        counts.rays += 1;
        let ray = from.ray((to.position - from.position) / distance);
        let hit = stage.both.closest(&ray, 0.0);
        if hit.is_some_and(|hit| hit.shape == shape && hit.t <= distance + errors) {
            continue;
        }
        counts.missed += 1;
        let mut examples = EXAMPLES.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if examples.len() < 12 {
            examples.push(format!(
                "{}, size {:e}: {distance:e} to shape {shape}, found {hit:?}, errors {errors:e}, sines {sines:?}, {from:?}, {to:?}",
                pair.name, stage.size
            ));
        }
    }
}

#[test]
fn neighbours_in_contact_are_met() {
    let mut table = Table::new(
        "Rays from body to body near their contact, 10⁻⁶ to 10⁶ units large, up to 10⁵ times that from the origin",
        &["bodies", "rays", "missed", "narrowest gap / error", "narrower gaps", "s"],
    );
    let pairs = pairs();
    let placements = trials(RAYS).div_ceil(pairs.len() as u64 * RAYS_EACH);
    let mut total = Counts::default();
    for pair in &pairs {
        let began = Instant::now();
        let trial = |_, random: &mut Random, counts: &mut Counts| {
            let stage = Stage::new(pair, random);
            for _ in 0..RAYS_EACH / 2 {
                cast(pair, &stage, random, counts);
            }
        };
        let found = in_parallel(placements, 2, trial, Counts::add);
        let cells = |counts: &Counts| {
            let narrowest = format!("{:.1}", counts.narrowest);
            [count(counts.rays), count(counts.missed), narrowest, count(counts.narrow)]
        };
        table.row(&[&[pair.name.to_owned()], &cells(&found)[..], &[seconds(began)]].concat());
        total = total.add(found);
    }
    table.row(&["all".to_owned(), count(total.rays), count(total.missed)]);
    table.print();
    let examples = EXAMPLES.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    assert!(total.missed == 0, "{}", examples.join("\n"));
    assert!(total.rays > trials(RAYS) / 4, "only {} rays", total.rays);
}
