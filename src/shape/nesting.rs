//! Whether two closed shapes cross: whether some line leaves the one that it entered first before the other.

use super::{Crossing, Crossings, Shape};
use crate::geometry::Ray;
use crate::sampling::quadrature::even_place;

impl Shape {
    /// Whether the surfaces of two closed shapes cross, so that light that goes one way enters and leaves
    /// them in another order than light that goes the other way. `false` where the shapes lie apart or within
    /// one another.
    ///
    /// What [`Shape::clearance`] does not tell is looked for on lines, each through a point of either
    /// surface: less than some thousandth of the surfaces that crosses may go unseen.
    pub fn crosses(&self, other: &Self) -> bool {
        if self.clearance(other) > 0.0 {
            return false;
        }
        let mut lines = (0..LINES).filter_map(|i| {
            // Not the corner, where surfaces may have an edge.
            let [a, b, c, d] = even_place(i).map(|u| (u + 0.5).fract());
            let ends = [self.sample([a, b])?, other.sample([c, d])?].map(|end| end.surface.point.position);
            Some(Ray::new(ends[0], (ends[1] - ends[0]).try_normalize()?))
        });
        let mut seen = false;
        let found = lines.any(|line| {
            seen = true;
            !nest(&self.crossings(&line), &other.crossings(&line))
        });
        // Where no point is known, nothing is.
        found || !seen
    }
}

const LINES: u32 = 1024;

/// Whether what a line passes through of two closed shapes is nested: it leaves first what it enters last.
fn nest(one: &Crossings, other: &Crossings) -> bool {
    // Surfaces that touch cross by rounding.
    let before = |a: &Crossing, b: &Crossing| b.hit.t - a.hit.t > a.error + b.error;
    passages(one).all(|[a_in, a_out]| {
        passages(other).all(|[b_in, b_out]| {
            let meet = before(b_in, a_out) && before(a_in, b_out);
            let a_first = before(a_in, b_in) && before(a_out, b_out);
            let b_first = before(b_in, a_in) && before(b_out, a_out);
            !(meet && (a_first || b_first))
        })
    })
}

/// Where a line is within a closed shape.
fn passages(crossings: &Crossings) -> impl Iterator<Item = [&Crossing; 2]> {
    let pairs = crossings.iter().zip(crossings.iter().skip(1));
    pairs.filter(|(a, b)| a.enters && !b.enters).map(|(a, b)| [a, b])
}
