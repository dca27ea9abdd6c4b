//! Where a line meets a bicubic patch.
//!
//! Seen along the line the patch is a map F of the unit square to the plane, a bicubic in Bernstein form, and the line meets it
//! where F = 0: where two bicubics vanish at once (Kajiya, "Ray Tracing Parametric Patches", SIGGRAPH 1982; Glassner, *An
//! Introduction to Ray Tracing*, ch. 3, 3.2). The square is halved until of each part it is certain what is in it:
//! - nothing, where the hull of its coefficients leaves out 0 by more than rounding explains, seen along an axis of the plane
//!   or along the part's own;
//! - what is met along one curve. In axes x and y of the plane such that x increases all over the part along one of the
//!   parameters, say q, the places with x = 0 are a graph q = Q(p), and along it y has the derivative −D / x_q, with D the
//!   determinant of F's derivative. Where interval bounds say that D keeps its sign, y is monotonic: one place or none, as the signs
//!   at both ends say. Where they say that D x_q's own derivative keeps its sign, y has one extreme, which is found first: two places
//!   or none, as the sign there says. So it is one and the same sign that decides on both, and a line that hardly touches doesn't
//!   lose one of two (the same idea in one dimension: [`crate::geometry::roots`]). Near a cusp, where there may be three, D itself is
//!   followed along the curve, beside which it has both signs.
//!
//! Nothing is left out but by a proof, rounding included, and no two places are taken for one unless they turn the same way and are
//! no further apart than rounding. So a line through a point that two patches share meets at least one of them, whatever the
//! rounding, at the price of meeting both if it is that near. Where a border has shrunk to a point the parts about it become as
//! small as rounding; what is left of them then is met, as one where it lies together. Where F is flat over a longer part the line
//! runs in the surface or touches it, which is a miss.

use super::net::Net;
use crate::geometry::Vec3;
use crate::geometry::bernstein::Range;
use crate::geometry::roots::{Sample, bracketed};
use glam::DVec2;
use smallvec::SmallVec;

/// Bound on the rounding errors of F, whose coefficients are in units of the patch's reach: those of control points and the line's
/// start relative to the patch's middle, of two axes that are not quite across the line, of the projection, of halving
/// and of evaluation; in all below 20 units of 2⁻⁵², and a reserve.
const NOISE: f64 = 32.0 * f64::EPSILON;

/// To what F is made to vanish.
const FINE: f64 = 0.0625 * NOISE;

/// A part this much longer than [`NOISE`], and no wider, is touched.
const LONG: f64 = 1e3;

/// Parts are not halved more often; before that they are small as rounding in all directions.
const DEEPEST: u32 = 160;

/// By how much of itself a part is enlarged to see what is in it: places at its border are not to be at an end.
const MARGIN: f64 = 0.1;

/// A patch's control points relative to a place in its middle.
#[derive(Clone, Debug)]
pub struct Anchored {
    pub middle: Vec3,
    pub points: Net<Vec3>,
    /// The greatest distance of a control point from the middle.
    pub reach: f64,
}

/// Where a line meets a patch.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    /// The line's parameter.
    pub t: f64,
    /// Bound on its error.
    pub error: f64,
    /// u and v, from 0 to 1.
    pub at: [f64; 2],
    /// Whether the line goes against ∂p/∂u × ∂p/∂v.
    pub against: bool,
}

/// A line near a patch, relative to its middle.
struct Near {
    /// The line's parameter here, about where it is nearest.
    shift: f64,
    start: Vec3,
    direction: Vec3,
    /// Across the line, in units of the patch's reach, and right-handed with it.
    axes: [Vec3; 2],
}

impl Near {
    /// `None` where the line passes by all control points.
    fn new(origin: Vec3, direction: Vec3, patch: &Anchored) -> Option<Self> {
        let away = origin - patch.middle;
        let shift = -away.dot(direction) / direction.length_squared();
        // As it is rounded once: however far away a ray starts, the line is known as well as from nearby.
        let start = Vec3::from_array([0, 1, 2].map(|i| {
            let (away, lost) = two_sum(origin[i], -patch.middle[i]);
            let way = direction[i] * shift;
            let lost_way = direction[i].mul_add(shift, -way);
            let (sum, lost_sum) = two_sum(away, way);
            sum + (lost_sum + (lost + lost_way))
        }));
        let limit = patch.reach * (1.0 + 1e-9);
        let passes_near = start.length_squared() <= limit * limit;
        if !passes_near {
            return None;
        }
        let ahead = direction.normalize();
        let (first, second) = ahead.any_orthonormal_pair();
        Some(Self { shift, start, direction, axes: [first, second].map(|axis| axis / patch.reach) })
    }

    fn seen(&self, points: &Net<Vec3>) -> Net<DVec2> {
        points.map(|point| {
            let away = point - self.start;
            DVec2::new(away.dot(self.axes[0]), away.dot(self.axes[1]))
        })
    }
}

/// A sum and what rounding took from it.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let back = sum - a;
    (sum, (a - (sum - back)) + (b - back))
}

/// All places where the line meets the patch, in no order.
pub fn meetings(origin: Vec3, direction: Vec3, patch: &Anchored) -> SmallVec<[Meeting; 4]> {
    let mut found = SmallVec::new();
    let Some(line) = Near::new(origin, direction, patch) else { return found };
    let seen = line.seen(&patch.points);
    let mut search = Search { seen: &seen, places: SmallVec::new(), specks: SmallVec::new() };
    search.look(&seen, Part { from: [0.0; 2], size: [1.0; 2] }, 0);
    let specks = joined(&search.specks).into_iter().map(|part| Place::speck(&seen, part));
    let mut places = search.places;
    places.extend(specks);
    let along: SmallVec<[f64; 8]> =
        places.iter().map(|place| (patch.points.value(place.at) - line.start).dot(line.direction)).collect();
    for (i, place) in places.iter().enumerate() {
        // Of what is met within rounding of a border that is a point, what is known better is enough.
        let beside = 64.0 * NOISE * patch.reach + line.stretch(patch, place);
        let known = |(j, other): (usize, &Place)| {
            (other.speck.is_none() || j < i) && (along[i] - along[j]).abs() <= beside
        };
        if place.speck.is_some() && places.iter().enumerate().any(known) {
            continue;
        }
        found.push(line.meeting(patch, &seen, place));
    }
    found
}

/// Parts that lie together as one: what is as small as rounding can't be told from its neighbours.
fn joined(parts: &[Part]) -> SmallVec<[Part; 2]> {
    let mut found: SmallVec<[Part; 2]> = SmallVec::new();
    for &part in parts {
        let mut whole = part;
        loop {
            let apart = found.len();
            found.retain(|other| {
                let beside = whole.is_beside(other);
                if beside {
                    whole = whole.with(other);
                }
                !beside
            });
            // Larger by now, it may be beside others.
            if found.len() == apart {
                break;
            }
        }
        found.push(whole);
    }
    found
}

impl Near {
    /// How far along the line, as a product with its direction, a speck reaches from where it is told: 0 of other places.
    fn stretch(&self, patch: &Anchored, place: &Place) -> f64 {
        let Some(speck) = place.speck else { return 0.0 };
        let told = patch.points.value(place.at);
        let part = patch.points.part([0, 1].map(|axis| speck.sides(axis)));
        part.all().fold(0.0, |most: f64, point| most.max((point - told).dot(self.direction).abs()))
    }

    fn meeting(&self, patch: &Anchored, seen: &Net<DVec2>, place: &Place) -> Meeting {
        let point = patch.points.value(place.at) - self.start;
        let ahead = point.dot(self.direction) / self.direction.length_squared();
        let at = place.at.map(|parameter| parameter.clamp(0.0, 1.0));
        let [along_u, along_v] = patch.points.slopes(place.at);
        let normal = along_u.cross(along_v);
        let slant = normal.cross(self.direction).length() / normal.dot(self.direction).abs();
        let world = patch.middle.abs().max_element() + patch.reach;
        let noise = NOISE * patch.reach + 4.0 * f64::EPSILON * world;
        // As long as the slant hardly changes over what the place is off by; else the line all but touches.
        let jet = seen.jet(place.at);
        let change_u = jet.uu.perp_dot(jet.v) + jet.u.perp_dot(jet.uv);
        let change_v = jet.uv.perp_dot(jet.v) + jet.u.perp_dot(jet.vv);
        let share = noise / (NOISE * patch.reach);
        let change = share * (change_u.abs() * place.spread[0] + change_v.abs() * place.spread[1]);
        let settled = change <= 0.25 * place.determinant.abs();
        let t = self.shift + ahead;
        let rounding = 2.0 * f64::EPSILON * (t.abs() + ahead.abs());
        let off = if place.speck.is_some() {
            // Wherever it is met, it is met here.
            self.stretch(patch, place) / self.direction.length_squared() + 2.0 * noise
        } else {
            2.0 * noise * (1.0 + slant)
        };
        let error = if settled && off.is_finite() { off + rounding } else { f64::INFINITY };
        let against = if place.speck.is_some() {
            // Where a border is a point the normal is that of the patch beside it.
            super::normal(&patch.points, at).dot(self.direction) < 0.0
        } else {
            place.determinant < 0.0
        };
        Meeting { t, error, at, against }
    }
}

/// A rectangle of the square.
#[derive(Clone, Copy, Debug)]
struct Part {
    from: [f64; 2],
    size: [f64; 2],
}

impl Part {
    fn sides(&self, axis: usize) -> [f64; 2] {
        [self.from[axis], self.from[axis] + self.size[axis]]
    }

    fn middle(&self) -> [f64; 2] {
        [0, 1].map(|axis| self.from[axis] + 0.5 * self.size[axis])
    }

    /// Its end along an axis that is at the square's edge, unless both are.
    fn edge(&self, axis: usize) -> Option<f64> {
        match self.sides(axis).map(|side| side <= 0.0 || side >= 1.0) {
            [true, false] => Some(0.0),
            [false, true] => Some(1.0),
            _ => None,
        }
    }

    /// Whether nothing as large as either is between them.
    fn is_beside(&self, other: &Self) -> bool {
        (0..2).all(|axis| {
            let between = (self.from[axis] - other.from[axis] - other.size[axis])
                .max(other.from[axis] - self.from[axis] - self.size[axis]);
            between < self.size[axis].min(other.size[axis])
        })
    }

    /// The rectangle around both.
    fn with(&self, other: &Self) -> Self {
        let from = [0, 1].map(|axis| self.from[axis].min(other.from[axis]));
        let to =
            [0, 1].map(|axis| (self.from[axis] + self.size[axis]).max(other.from[axis] + other.size[axis]));
        Self { from, size: [to[0] - from[0], to[1] - from[1]] }
    }
}

/// Where F vanishes.
#[derive(Clone, Copy, Debug)]
struct Place {
    /// Beyond the square by no more than `spread`.
    at: [f64; 2],
    /// By how much u and v may be off.
    spread: [f64; 2],
    /// Of F's derivative.
    determinant: f64,
    /// The part of which F makes something as small as rounding, somewhere in which it may vanish, if it is no more than that.
    speck: Option<Part>,
}

impl Place {
    /// In the middle of the part, or on the square's border if it reaches that: the line may as well pass beside it.
    fn speck(seen: &Net<DVec2>, part: Part) -> Self {
        let mut at = part.middle();
        let [along_u, along_v] = seen.slopes(at);
        // If it can be, along the side that is shorter: of the other parameter the middle says more about the normal.
        let shorter = usize::from(part.size[1] < part.size[0]);
        let edge = [shorter, 1 - shorter].into_iter().find_map(|axis| Some((axis, part.edge(axis)?)));
        if let Some((axis, edge)) = edge {
            at[axis] = edge;
        }
        Self { at, spread: part.size, determinant: along_u.perp_dot(along_v), speck: Some(part) }
    }
}

struct Search<'a> {
    seen: &'a Net<DVec2>,
    places: SmallVec<[Place; 8]>,
    /// Parts as small as rounding.
    specks: SmallVec<[Part; 4]>,
}

fn range(values: impl Iterator<Item = f64>) -> Range {
    values.fold(Range(f64::INFINITY, f64::NEG_INFINITY), |Range(low, high), value| {
        Range(low.min(value), high.max(value))
    })
}

impl Search<'_> {
    /// What is in a part, over which the coefficients are `net`.
    fn look(&mut self, net: &Net<DVec2>, part: Part, depth: u32) {
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for point in net.all() {
            (low, high) = (low.min(point), high.max(point));
        }
        if low.max_element() > NOISE || high.min_element() < -NOISE {
            return;
        }
        if (high - low).max_element() <= 4.0 * NOISE {
            self.specks.push(part);
            return;
        }
        // The parameter along which there is more of it, and its own axis there.
        let mut lengths = [0.0; 2];
        let mut ways = [DVec2::ZERO; 2];
        for i in 0..4 {
            for j in 0..3 {
                let steps = [net.0[j + 1][i] - net.0[j][i], net.0[i][j + 1] - net.0[i][j]];
                for axis in 0..2 {
                    lengths[axis] += steps[axis].length();
                    ways[axis] += steps[axis];
                }
            }
        }
        let along = usize::from(lengths[1] > lengths[0]);
        let own = ways[along].try_normalize().unwrap_or(DVec2::X);
        let turned = Turned::of(net, own, along);
        let [x, y] = [&turned.x, &turned.y].map(|net| range(net.all()));
        if x.0 > NOISE || x.1 < -NOISE || y.0 > NOISE || y.1 < -NOISE {
            return;
        }
        let flat = y.0 >= -2.0 * NOISE && y.1 <= 2.0 * NOISE;
        if (flat && x.1 - x.0 > LONG * NOISE) || depth == DEEPEST {
            return;
        }
        if turned.course().is_some()
            && let Some(curve) = Curve::new(self.seen, part, along, ways)
        {
            curve.places().into_iter().for_each(|place| self.add(place));
            return;
        }
        for (half, net) in net.halves(along).iter().enumerate() {
            let mut part = part;
            part.size[along] *= 0.5;
            part.from[along] += half as f64 * part.size[along];
            self.look(net, part, depth + 1);
        }
    }

    fn add(&mut self, place: Place) {
        let same = |other: &Place| {
            let beside = |axis: usize| {
                (place.at[axis] - other.at[axis]).abs() <= place.spread[axis] + other.spread[axis]
            };
            place.determinant * other.determinant > 0.0 && beside(0) && beside(1)
        };
        if !self.places.iter().any(same) {
            self.places.push(place);
        }
    }
}

/// The places of a part and a little around it where x = 0, as a graph q = Q(p).
struct Curve<'a> {
    seen: &'a Net<DVec2>,
    part: Part,
    /// Which parameter q is: x increases along it.
    along: usize,
    /// The direction of x.
    axis: DVec2,
    /// The enlarged part, p first.
    around: [[f64; 2]; 2],
    /// Whether y is known to be monotonic along the curve; else it has one extreme at most.
    monotonic: bool,
}

/// Values and first derivatives at a place of the curve.
struct Here {
    x: f64,
    y: f64,
    along_p: DVec2,
    along_q: DVec2,
}

impl Here {
    fn determinant(&self) -> f64 {
        self.along_p.perp_dot(self.along_q)
    }
}

/// A coordinate as a function whose roots are asked for: what is less than rounding is 0, and there is no need to go on.
fn known(value: f64, slope: f64) -> Sample {
    Sample { value: if value.abs() <= FINE { 0.0 } else { value }, slope, error: 0.0 }
}

impl<'a> Curve<'a> {
    /// `None` where the bounds are too wide to tell; `ways` are the sums of twelve steps between coefficients along both parameters.
    fn new(seen: &'a Net<DVec2>, part: Part, along: usize, ways: [DVec2; 2]) -> Option<Self> {
        let across = 1 - along;
        let axis = ways[along].normalize();
        let slope = (ways[across].dot(axis) / ways[along].length()).abs();
        // So much that the curve, if it is in the part at all, doesn't leave what is around it along q.
        let margins = [MARGIN, MARGIN + 1.3 * slope];
        let around = [across, along].map(|parameter| {
            let margin = margins[usize::from(parameter == along)] * part.size[parameter];
            [part.from[parameter] - margin, part.from[parameter] + part.size[parameter] + margin]
        });
        let turned = Turned::of(&seen.part([around[1 - along], around[along]]), axis, along);
        let (course, steepest) = turned.course()?;
        if steepest * (1.0 + MARGIN) / (1.0 + 2.0 * MARGIN) > margins[1] / (1.0 + 2.0 * margins[1]) {
            return None;
        }
        let mut curve = Self { seen, part, along, axis, around, monotonic: course != Course::Bent };
        if let Course::Steady(most) = course {
            let [from, to] = around[0];
            let middle = 0.5 * (from + to);
            // A curve that isn't there never comes into the part.
            if let Some(q) = curve.follow(middle) {
                let there = curve.here(middle, q).determinant().abs() - 64.0 * NOISE;
                curve.monotonic = there * (to - from) * (around[1][1] - around[1][0]) > most;
                return curve.monotonic.then_some(curve);
            }
        }
        Some(curve)
    }

    /// u and v.
    fn parameters(&self, p: f64, q: f64) -> [f64; 2] {
        if self.along == 1 { [p, q] } else { [q, p] }
    }

    fn turned(&self, point: DVec2) -> DVec2 {
        DVec2::new(self.axis.dot(point), self.axis.perp_dot(point))
    }

    fn here(&self, p: f64, q: f64) -> Here {
        let at = self.parameters(p, q);
        let value = self.turned(self.seen.value(at));
        let slopes = self.seen.slopes(at);
        let [along_p, along_q] = [1 - self.along, self.along].map(|parameter| self.turned(slopes[parameter]));
        Here { x: value.x, y: value.y, along_p, along_q }
    }

    /// Q(p).
    fn follow(&self, p: f64) -> Option<f64> {
        let [low, high] = self.around[1];
        let x = |q: f64| {
            let here = self.here(p, q);
            known(here.x, here.along_q.x)
        };
        (x(low).value < 0.0 && x(high).value > 0.0).then(|| bracketed(low, high, -1.0, &x).t)
    }

    /// y along the curve.
    fn height(&self, p: f64) -> Sample {
        let Some(q) = self.follow(p) else { return Sample { value: f64::NAN, slope: f64::NAN, error: 0.0 } };
        let here = self.here(p, q);
        known(here.y, -here.determinant() / here.along_q.x)
    }

    /// The determinant along the curve, and its derivative.
    fn turning(&self, p: f64) -> Sample {
        let Some(q) = self.follow(p) else { return Sample { value: f64::NAN, slope: f64::NAN, error: 0.0 } };
        let jet = self.seen.jet(self.parameters(p, q));
        let along_p = self.turned(if self.along == 1 { jet.u } else { jet.v });
        let along_q = self.turned(if self.along == 1 { jet.v } else { jet.u });
        let [pp, qq] =
            if self.along == 1 { [jet.uu, jet.vv] } else { [jet.vv, jet.uu] }.map(|c| self.turned(c));
        let pq = self.turned(jet.uv);
        let change_p = pp.perp_dot(along_q) + along_p.perp_dot(pq);
        let change_q = pq.perp_dot(along_q) + along_p.perp_dot(qq);
        let (value, slope) = (along_p.perp_dot(along_q), change_p - change_q * along_p.x / along_q.x);
        // So near to the extreme y is off by less than it is known.
        let there = value * value <= 2.0 * FINE * (slope * along_q.x).abs();
        Sample { value: if there { 0.0 } else { value }, slope, error: 0.0 }
    }

    /// All in the part.
    fn places(&self) -> SmallVec<[Place; 2]> {
        if self.monotonic
            && let Some([p, q]) = self.nearby()
        {
            return self.place(p, q).into_iter().collect();
        }
        let mut found = SmallVec::new();
        let [from, to] = self.around[0];
        let (first, last) = (self.height(from), self.height(to));
        // A curve that isn't there at both ends never comes into the part.
        if first.value.is_nan() || last.value.is_nan() {
            return found;
        }
        let mut between = |from: (f64, f64), to: (f64, f64)| {
            if from.1 * to.1 < 0.0 {
                let p = bracketed(from.0, to.0, from.1.signum(), &|p| self.height(p)).t;
                found.extend(self.follow(p).and_then(|q| self.place(p, q)));
            }
        };
        let (first, last) = ((from, first), (to, last));
        let (first_turn, last_turn) = (first.1.slope, last.1.slope);
        if self.monotonic || first_turn * last_turn >= 0.0 {
            between((from, first.1.value), (to, last.1.value));
        } else {
            // The slope of y has the other sign than the determinant.
            let extreme = bracketed(from, to, -first_turn.signum(), &|p| self.turning(p)).t;
            let there = self.height(extreme).value;
            between((from, first.1.value), (extreme, there));
            between((extreme, there), (to, last.1.value));
        }
        found
    }

    /// The place where F vanishes, by Newton's method from the middle, where it is found at once. Since y is monotonic there is no
    /// other.
    fn nearby(&self) -> Option<[f64; 2]> {
        const MOST_STEPS: usize = 8;
        let [mut p, mut q] =
            [1 - self.along, self.along].map(|i| self.part.from[i] + 0.5 * self.part.size[i]);
        for _ in 0..MOST_STEPS {
            let here = self.here(p, q);
            let value = DVec2::new(here.x, here.y);
            let determinant = here.determinant();
            p -= value.perp_dot(here.along_q) / determinant;
            q -= here.along_p.perp_dot(value) / determinant;
            let inside = |[low, high]: [f64; 2], at: f64| low <= at && at <= high;
            if !(inside(self.around[0], p) && inside(self.around[1], q)) {
                return None;
            }
            if value.abs().max_element() <= FINE {
                return Some([p, q]);
            }
        }
        None
    }

    /// With its spread, if it is in the part or beyond by no more than that.
    fn place(&self, p: f64, q: f64) -> Option<Place> {
        let here = self.here(p, q);
        let determinant = here.determinant();
        // What rounding of F makes of the place; next to where it is touched less than that.
        let spread = |way: DVec2, margin: [f64; 2]| {
            (NOISE * way.length() / determinant.abs()).min(0.25 * (margin[1] - margin[0]))
        };
        let spread = [spread(here.along_q, self.around[0]), spread(here.along_p, self.around[1])];
        let (across, along) = (1 - self.along, self.along);
        let within = |parameter: usize, at: f64, spread: f64| {
            let from = self.part.from[parameter];
            from - spread <= at && at <= from + self.part.size[parameter] + spread
        };
        (within(across, p, spread[0]) && within(along, q, spread[1])).then(|| Place {
            at: self.parameters(p, q),
            spread: self.parameters(spread[0], spread[1]),
            determinant: if along == 1 { determinant } else { -determinant },
            speck: None,
        })
    }
}

/// What y does along the curve.
#[derive(Clone, Copy, PartialEq)]
enum Course {
    Monotonic,
    /// It has one extreme at most.
    Bent,
    /// All that is known is how much the determinant changes from the middle to an end.
    Steady(f64),
}

/// Coordinates along an axis of the plane and across it, over a part; the first index goes along p, the second along q.
struct Turned {
    x: Net<f64>,
    y: Net<f64>,
}

impl Turned {
    fn of(net: &Net<DVec2>, axis: DVec2, along: usize) -> Self {
        let turned = Self { x: net.map(|point| axis.dot(point)), y: net.map(|point| axis.perp_dot(point)) };
        if along == 1 { turned } else { Self { x: turned.x.transposed(), y: turned.y.transposed() } }
    }

    /// With the greatest slope of the curve; `None` where the bounds are too wide to tell.
    fn course(&self) -> Option<(Course, f64)> {
        let x = Slopes::of(&self.x);
        if x.q.0 <= 0.0 {
            return None;
        }
        let steepest = x.p.0.abs().max(x.p.1.abs()) / x.q.0;
        let y = Slopes::of(&self.y);
        let less = |a: Range, b: Range| a + b * -1.0;
        let determinant = less(x.p * y.q, y.p * x.q);
        if !determinant.has_zero() {
            return Some((Course::Monotonic, steepest));
        }
        let (bent_x, bent_y) = (Bends::of(&self.x), Bends::of(&self.y));
        let change_p = less(bent_x.pp * y.q + x.p * bent_y.pq, bent_y.pp * x.q + y.p * bent_x.pq);
        let change_q = less(bent_x.pq * y.q + x.p * bent_y.qq, bent_y.pq * x.q + y.p * bent_x.qq);
        let change = less(change_p * x.q, change_q * x.p);
        if !change.has_zero() {
            return Some((Course::Bent, steepest));
        }
        // Near a cusp, where three places come together, the determinant changes much less along the curve than across it.
        let most = 0.5 * change.0.abs().max(change.1.abs()) / x.q.0;
        (most < 0.1 * (determinant.1 - determinant.0)).then_some((Course::Steady(most), steepest))
    }
}

/// Bounds on a bicubic's derivatives along p and q, rounding included.
struct Slopes {
    p: Range,
    q: Range,
}

/// Likewise on the second ones.
struct Bends {
    pp: Range,
    pq: Range,
    qq: Range,
}

fn pairs(rows: usize, columns: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..rows).flat_map(move |i| (0..columns).map(move |j| (i, j)))
}

/// Around `factor` times differences of that many coefficients.
fn bound(factor: f64, coefficients: f64, differences: impl Iterator<Item = f64>) -> Range {
    let (differences, noise) = (range(differences), coefficients * NOISE);
    Range(factor * (differences.0 - noise), factor * (differences.1 + noise))
}

impl Slopes {
    fn of(Net(c): &Net<f64>) -> Self {
        Self {
            p: bound(3.0, 2.0, pairs(3, 4).map(|(i, j)| c[i + 1][j] - c[i][j])),
            q: bound(3.0, 2.0, pairs(4, 3).map(|(i, j)| c[i][j + 1] - c[i][j])),
        }
    }
}

impl Bends {
    fn of(Net(c): &Net<f64>) -> Self {
        let second = |a: f64, b: f64, c: f64| (c - b) - (b - a);
        let mixed = |i: usize, j: usize| (c[i + 1][j + 1] - c[i + 1][j]) - (c[i][j + 1] - c[i][j]);
        Self {
            pp: bound(6.0, 4.0, pairs(2, 4).map(|(i, j)| second(c[i][j], c[i + 1][j], c[i + 2][j]))),
            pq: bound(9.0, 4.0, pairs(3, 3).map(|(i, j)| mixed(i, j))),
            qq: bound(6.0, 4.0, pairs(4, 2).map(|(i, j)| second(c[i][j], c[i][j + 1], c[i][j + 2]))),
        }
    }
}
