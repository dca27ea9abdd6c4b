//! Where F (see [`super::intersection`]) vanishes in a part in which one of its coordinates does along one
//! curve.

use super::bicubic::Bicubic;
use super::intersection::NOISE;
use super::monotonicity::{Monotonicity, Turned};
use super::root::{Root, Subdomain};
use crate::geometry::roots::{Sample, bracketed};
use glam::DVec2;
use smallvec::SmallVec;

/// Residual of F at which the search ends.
const FINE: f64 = 0.0625 * NOISE;

/// By how much of itself a part is enlarged to see what is in it: roots at its border are not to be at an
/// end.
const MARGIN: f64 = 0.1;

/// The points of a subdomain and a little around it where x = 0, as a graph q = Q(p).
pub struct Curve<'a> {
    seen: &'a Bicubic<DVec2>,
    part: Subdomain,
    /// Which parameter q is: x increases along it.
    along: usize,
    /// The direction of x.
    axis: DVec2,
    /// The enlarged part, p first.
    around: [[f64; 2]; 2],
    /// Whether y is known to be monotonic along the curve; else it has one extreme at most.
    monotonic: bool,
}

/// Values and first derivatives at a point of the curve.
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

/// A coordinate as a function whose roots are asked for: what is less than rounding is 0, and there is no
/// need to go on.
fn known(value: f64, slope: f64) -> Sample {
    Sample { value: if value.abs() <= FINE { 0.0 } else { value }, slope, error: 0.0 }
}

impl<'a> Curve<'a> {
    /// `None` where the bounds are too wide to tell; `ways` are the sums of twelve steps between coefficients
    /// along both parameters.
    pub fn new(seen: &'a Bicubic<DVec2>, part: Subdomain, along: usize, ways: [DVec2; 2]) -> Option<Self> {
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
        let (monotonicity, steepest) = turned.monotonicity()?;
        if steepest * (1.0 + MARGIN) / (1.0 + 2.0 * MARGIN) > margins[1] / (1.0 + 2.0 * margins[1]) {
            return None;
        }
        let mut curve =
            Self { seen, part, along, axis, around, monotonic: monotonicity != Monotonicity::Bent };
        if let Monotonicity::Steady(most) = monotonicity {
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
    pub fn roots(&self) -> SmallVec<[Root; 2]> {
        if self.monotonic
            && let Some([p, q]) = self.nearby()
        {
            return self.root(p, q).into_iter().collect();
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
                found.extend(self.follow(p).and_then(|q| self.root(p, q)));
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

    /// The root of F, by Newton's method from the middle, where it is found at once. Since y is
    /// monotonic there is no other.
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
    fn root(&self, p: f64, q: f64) -> Option<Root> {
        let here = self.here(p, q);
        let determinant = here.determinant();
        // Error of the root from the rounding of F; it is less beside a point where the line touches.
        let spread = |way: DVec2, margin: [f64; 2]| {
            (NOISE * way.length() / determinant.abs()).min(0.25 * (margin[1] - margin[0]))
        };
        let spread = [spread(here.along_q, self.around[0]), spread(here.along_p, self.around[1])];
        let (across, along) = (1 - self.along, self.along);
        let within = |parameter: usize, at: f64, spread: f64| {
            let from = self.part.from[parameter];
            from - spread <= at && at <= from + self.part.size[parameter] + spread
        };
        (within(across, p, spread[0]) && within(along, q, spread[1])).then(|| Root {
            at: self.parameters(p, q),
            spread: self.parameters(spread[0], spread[1]),
            determinant: if along == 1 { determinant } else { -determinant },
            degenerate: None,
        })
    }
}
