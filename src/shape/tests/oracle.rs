//! All crossings of lines with shapes against a slow oracle: polynomials along the line in numbers of 32
//! digits, made from the parameters that the shapes were made of.

use super::direction;
use super::doubled::{Doubled, Polynomial};
use crate::geometry::{Bounds, Ray, Transform, Vec3};
use crate::shape::{Crossing, Crossings, Shape};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg as Random;
use std::f64::consts::TAU;
use std::ops::AddAssign;

/// How near a line may be to having other crossings where shape and oracle don't find the same, in terms of
/// 1 + the origin's distance and as values of the oracle's functions: what is rounded a few times in `f64`.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// How far from touching most shapes are sure of what they find, in the same terms.
pub const SURE_FROM: f64 = 1e-10;

/// A line's x, y and z in a shape's own coordinates, as functions of t − [`near`].
pub struct Line(pub [Polynomial; 3]);

/// A place on a ray not far from the origin: powers of greater distances would cost even the oracle its
/// digits.
pub fn near(ray: &Ray) -> f64 {
    -ray.origin.dot(ray.direction)
}

impl Line {
    /// In coordinates that `to_world` takes to the world's, by Cramer's rule.
    pub fn new(ray: &Ray, to_world: &Transform) -> Self {
        let m = to_world.matrix();
        let columns = [m.x_axis, m.y_axis, m.z_axis].map(|c| [c.x, c.y, c.z].map(Doubled::from));
        let determinant = |a: [Doubled; 3], b: [Doubled; 3], c: [Doubled; 3]| {
            a[0] * (b[1] * c[2] - b[2] * c[1]) - b[0] * (a[1] * c[2] - a[2] * c[1])
                + c[0] * (a[1] * b[2] - a[2] * b[1])
        };
        let [a, b, c] = columns;
        let volume = determinant(a, b, c);
        let local = |v: [Doubled; 3]| {
            [determinant(v, b, c), determinant(a, v, c), determinant(a, b, v)].map(|d| d / volume)
        };
        let axes = [0, 1, 2];
        let origin = local(axes.map(|i| Doubled::from(ray.origin[i]) - Doubled::from(m.w_axis[i])));
        let direction = local(axes.map(|i| ray.direction[i].into()));
        let start = Doubled::from(near(ray));
        Self(axes.map(|i| Polynomial(vec![origin[i] + direction[i] * start, direction[i]])))
    }

    pub fn minus(&self, point: Vec3) -> Self {
        Self([0, 1, 2].map(|i| &self.0[i] - &Polynomial::constant(point[i])))
    }

    pub fn dot(&self, other: &Self) -> Polynomial {
        let products = [0, 1, 2].map(|i| &self.0[i] * &other.0[i]);
        &(&products[0] + &products[1]) + &products[2]
    }
}

/// Functions along a line.
pub type Functions = Box<dyn Fn(&Line) -> Vec<Polynomial>>;

/// A shape as functions along a line that are negative inside: the first is curved, the others planes that
/// cut it off.
pub struct Oracle {
    pub functions: Functions,
    pub solid: bool,
}

#[derive(Clone, Copy, Debug)]
pub struct Exact {
    pub t: Doubled,
    pub enters: bool,
}

impl Oracle {
    fn crossings(&self, ray: &Ray, to_world: &Transform) -> Vec<Exact> {
        let functions = (self.functions)(&Line::new(ray, to_world));
        let mut found = Vec::new();
        let cutters = if self.solid { functions.len() } else { 1 };
        for (i, function) in functions[..cutters].iter().enumerate() {
            let slope = function.derivative();
            for t in function.roots([-1e9, 1e9]) {
                let others = functions.iter().enumerate().filter(|&(j, _)| j != i);
                if others.map(|(_, other)| other.at(t).high).all(|value| value <= 0.0) {
                    let t_of_ray = t + near(ray).into();
                    found.push(Exact { t: t_of_ray, enters: slope.at(t).high < 0.0 });
                }
            }
        }
        found.sort_by(|a, b| a.t.high.total_cmp(&b.t.high));
        found
    }

    /// How near, along the line, the shape is to having other crossings: the distance from a touching point
    /// or a rim, as the smallest magnitude of a function at the extremes of its own or at the roots of
    /// another.
    fn doubt(&self, ray: &Ray, to_world: &Transform) -> f64 {
        let functions = (self.functions)(&Line::new(ray, to_world));
        let mut least = f64::INFINITY;
        for (i, function) in functions.iter().enumerate() {
            for t in function.derivative().roots([-1e9, 1e9]) {
                least = least.min(function.at(t).high.abs());
            }
            for t in function.roots([-1e9, 1e9]) {
                let others = functions.iter().enumerate().filter(|&(j, _)| j != i);
                least = others.map(|(_, other)| other.at(t).high.abs()).fold(least, f64::min);
            }
            if i > 0 {
                // A line in a plane.
                least = least.min(function.0.iter().map(|c| c.high.abs()).fold(0.0, f64::max));
            }
        }
        least
    }
}

/// Rays from near and far, from within, and such that almost touch.
pub fn any_ray(shape: &Shape, bounds: Bounds, random: &mut Random) -> Ray {
    let size = bounds.max - bounds.min;
    let unit = size.max_element();
    // A flat shape gets a box with some depth.
    let size = size.max(Vec3::splat(0.1 * unit));
    let corner = bounds.centre() - 0.5 * size;
    let mut in_box =
        || corner + size * Vec3::from_array(std::array::from_fn(|_| random.random_range(-0.05..1.05)));
    let (mut target, inside) = (in_box(), in_box());
    let mut toward = (target - inside).try_normalize().unwrap_or(Vec3::X);
    let kind = random.random_range(0..4);
    if kind < 2
        && let Some(sample) = shape.sample([random.random(), random.random()])
    {
        let point = sample.surface.point;
        target = point.position;
        if kind == 0 {
            // Across the normal, hardly off the surface.
            let side = if random.random() { point.normal } else { -point.normal };
            toward = direction(random).cross(point.normal).try_normalize().unwrap_or(Vec3::X);
            target += side * unit * 10f64.powf(random.random_range(-14.0..-1.0));
        }
    }
    if random.random_range(0..10) == 0 {
        toward = Vec3::AXES[random.random_range(0..3)];
    }
    let distance = match random.random_range(0..5) {
        0 => 0.0,
        1 => 1e3,
        2 => 1e6,
        _ => random.random_range(-5.0..5.0),
    };
    Ray::new(target - toward * unit * distance, toward)
}

/// What was compared.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    rays: u32,
    /// Those among them that touch or pass a rim within rounding.
    doubtful: u32,
    /// How far beside a line that touches, at most, the shape says that it can't tell, in terms of 1 + the
    /// origin's distance.
    unsure: f64,
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.doubtful += other.doubtful;
        self.unsure = self.unsure.max(other.unsure);
    }
}

impl Tally {
    /// Prints it; hardly any rays may be doubtful, and so far from touching all have to be sure.
    pub fn tell(&self, name: &str, sure_from: f64) {
        let Self { rays, doubtful, unsure } = *self;
        println!(
            "{name}: {doubtful} of {rays} rays touch or pass a rim within rounding; shapes are sure from {unsure:.1e} on"
        );
        assert!(doubtful < rays / 10 && unsure <= sure_from);
    }
}

/// Compares; returns what was left undecided because a touching point or a rim was as near as rounding.
pub fn check(
    name: &str,
    shape: &Shape,
    oracle: &Oracle,
    to_world: &Transform,
    rays: u32,
    seed: u64,
) -> Tally {
    let doubt = |ray: &Ray| oracle.doubt(ray, to_world);
    check_against(name, shape, |ray| oracle.crossings(ray, to_world), doubt, rays, seed)
}

/// The less known of the first two crossings that the shape itself calls uncertain.
fn undecided(found: &Crossings) -> Option<&Crossing> {
    let pair =
        found.windows(2).find(|pair| pair[1].hit.t - pair[0].hit.t <= pair[0].error + pair[1].error)?;
    Some(if pair[0].error < pair[1].error { &pair[1] } else { &pair[0] })
}

/// How far to both sides of a line, by steps of two, the shape is sure again, in terms of 1 + the origin's
/// distance. The line touches so nearly that shape and oracle don't find the same crossings. `None` unless
/// the shape says so:
/// - the line has crossings that the shape itself doesn't certify, or if it has too few of them, the
///   nearest line beside it that has more;
/// - as far to the sides as shape and oracle agree again, on other crossings here than there, the shape still
///   doesn't certify them: the line is nearer to touching than what it says that it can't tell.
fn unsure_within(shape: &Shape, ray: &Ray, oracle: impl Fn(&Ray) -> usize) -> Option<f64> {
    const FARTHEST: f64 = 1e-6;
    let unit = 1.0 + ray.origin.length();
    let moved = |way: Vec3, by: f64| Ray::new(ray.origin + way * (by * unit), ray.direction);
    let distances = || (-56..).map(|power| 2f64.powi(power)).take_while(|&by| by < FARTHEST);
    let (x, y) = ray.direction.any_orthonormal_pair();
    let around: [Vec3; 8] = std::array::from_fn(|i| {
        let (sin, cos) = (TAU * i as f64 / 8.0).sin_cos();
        x * cos + y * sin
    });
    let found = shape.crossings(ray);
    let touching = if undecided(&found).is_some() {
        *ray
    } else {
        let mut beside = distances().flat_map(|by| around.map(|way| moved(way, by)));
        beside.find(|ray| shape.crossings(ray).len() > found.len())?
    };
    let hit = undecided(&shape.crossings(&touching))?.hit;
    let normal = shape.surface(&hit, &touching).point.normal;
    let aside = normal.reject_from_normalized(ray.direction).try_normalize()?;
    let sides = |by: f64| [aside, -aside].map(|way| moved(way, by));
    let certifies = |&by: &f64| sides(by).iter().all(|side| undecided(&shape.crossings(side)).is_none());
    let agree = |&by: &f64| {
        let [one, other] = sides(by).map(|side| (shape.crossings(&side).len(), oracle(&side)));
        one.0 == one.1 && other.0 == other.1 && one != other
    };
    let settled = distances().find(agree).filter(|by| !certifies(by))?;
    distances().skip_while(|&by| by < settled).find(certifies)
}

/// The same with any oracle, in ascending order, and its doubt: how near the line is to having other
/// crossings.
pub fn check_against(
    name: &str,
    shape: &Shape,
    oracle: impl Fn(&Ray) -> Vec<Exact>,
    doubt: impl Fn(&Ray) -> f64,
    rays: u32,
    seed: u64,
) -> Tally {
    let mut random = Random::seed_from_u64(seed);
    let bounds = shape.bounds();
    let (mut tally, mut hits) = (Tally { rays, ..Tally::default() }, 0);
    for _ in 0..rays {
        let ray = any_ray(shape, bounds, &mut random);
        let found: Crossings = shape.crossings(&ray);
        let exact = oracle(&ray);
        hits += exact.len();
        let agrees = found.len() == exact.len()
            && found.iter().zip(&exact).all(|(crossing, exact)| {
                let off = (Doubled::from(crossing.hit.t) - exact.t).high.abs();
                crossing.enters == exact.enters && off <= crossing.error
            });
        if agrees {
            // What is nearest is what ordinary rays find.
            let nearest = shape.intersect(&ray).map(|hit| hit.t);
            let first = found.iter().map(|crossing| crossing.hit.t).find(|&t| t >= 0.0);
            assert!(nearest == first, "{name}: {ray:?} {nearest:?} {first:?}");
            continue;
        }
        let seen: Vec<_> = exact.iter().map(|exact| (exact.t.high, exact.enters)).collect();
        // Within the rounding of coordinates as far away as the ray starts.
        let doubt = doubt(&ray);
        let rounding = ROUNDING * (1.0 + ray.origin.length());
        assert!(doubt <= rounding, "{name}: {ray:?}\n{found:?}\n{seen:?}\ndoubt {doubt:e} of {rounding:e}");
        tally.doubtful += 1;
        if matches!(shape, Shape::ProfileOrImplicit(inner) if !inner.is_curved()) {
            continue;
        }
        // Two crossings close to each other come and go where a line touches; others where it passes a rim or
        // lies in a plane.
        let times: Vec<f64> = if found.len() > exact.len() {
            found.iter().map(|crossing| crossing.hit.t).collect()
        } else {
            seen.iter().map(|exact| exact.0).collect()
        };
        let gap = times.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
        if found.len().abs_diff(exact.len()) != 2 || gap > 1e-3 * bounds.diameter() {
            continue;
        }
        // Where a surface bends to both sides three crossings come together, at a place that is known to a
        // cube root.
        let known = (SURE_FROM * (1.0 + ray.origin.length())).cbrt();
        let same = |crossing: &Crossing, exact: &(f64, bool)| {
            (crossing.hit.t - exact.0).abs() <= crossing.error.min(known)
        };
        let as_one = seen.iter().all(|exact| found.iter().any(|crossing| same(crossing, exact)))
            && found.iter().all(|crossing| seen.iter().any(|exact| same(crossing, exact)));
        if !as_one {
            let unsure = unsure_within(shape, &ray, |ray| oracle(ray).len());
            let Some(unsure) = unsure else { panic!("{name}: sure of {ray:?}\n{found:?}\n{seen:?}") };
            tally.unsure = tally.unsure.max(unsure);
        }
    }
    assert!(hits as u32 > rays / 4, "{name}: only {hits} crossings");
    tally
}
