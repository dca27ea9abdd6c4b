//! All crossings of a line with a bicubic patch by elimination (Kajiya 1982): for two planes through the line
//! the patch's distances from them are two bicubics, cubics in u whose coefficients are cubics in v. They
//! have a root in common where their resultant vanishes, a polynomial of degree 18 in v. All in numbers of 32
//! digits.

use crate::geometry::Vec3;
use crate::shape::tests::doubled::{Doubled, Polynomial};

/// Control points; the first index goes along u.
pub type Points = [[[Doubled; 3]; 4]; 4];

/// A line by exact numbers.
#[derive(Clone, Copy)]
pub struct Line {
    pub origin: [Doubled; 3],
    pub direction: [f64; 3],
}

#[derive(Clone, Copy, Debug)]
pub struct Crossing {
    pub t: Doubled,
    pub u: Doubled,
    pub v: Doubled,
    /// Whether the line goes against ∂p/∂u × ∂p/∂v.
    pub against: bool,
}

fn number(value: f64) -> Doubled {
    Doubled::from(value)
}

impl Line {
    /// A line with its origin moved by `offset`.
    pub fn new(origin: Vec3, direction: Vec3, offset: Vec3) -> Self {
        Self {
            origin: [0, 1, 2].map(|i| number(origin[i]) + number(offset[i])),
            direction: direction.to_array(),
        }
    }
}

/// A bicubic by powers: `.0[i].0[j]` belongs to uⁱ vʲ.
struct Bicubic([Polynomial; 4]);

impl Bicubic {
    fn of(c: [[Doubled; 4]; 4]) -> Self {
        let powers = |[a, b, c, d]: [Doubled; 4]| {
            let three = number(3.0);
            [a, three * (b - a), three * ((c - b) - (b - a)), ((d - c) - (c - b)) - ((c - b) - (b - a))]
        };
        let rows = c.map(powers);
        let columns = [0, 1, 2, 3].map(|j| powers([0, 1, 2, 3].map(|i| rows[i][j])));
        Self(
            [0, 1, 2, 3]
                .map(|i| Polynomial(vec![columns[0][i], columns[1][i], columns[2][i], columns[3][i]])),
        )
    }

    /// As a polynomial of u.
    fn at_v(&self, v: Doubled) -> Polynomial {
        Polynomial(self.0.iter().map(|p| p.at(v)).collect())
    }

    /// Value and both derivatives.
    fn slopes(&self, u: Doubled, v: Doubled) -> [Doubled; 3] {
        let along_u = self.at_v(v);
        let along_v = Polynomial(self.0.iter().map(|p| p.derivative().at(v)).collect());
        [along_u.at(u), along_u.derivative().at(u), along_v.at(u)]
    }
}

/// Resultant of two cubics a and b by Bézout's matrix.
fn resultant(a: &[Polynomial; 4], b: &[Polynomial; 4]) -> Polynomial {
    let minor = |i: usize, j: usize| &(&a[i] * &b[j]) - &(&a[j] * &b[i]);
    let (m01, m02, m03, m12, m13, m23) =
        (minor(0, 1), minor(0, 2), minor(0, 3), minor(1, 2), minor(1, 3), minor(2, 3));
    // Rows (m01, m02, m03), (m02, m03 + m12, m13), (m03, m13, m23).
    let middle = &m03 + &m12;
    let first = &m01 * &(&(&middle * &m23) - &(&m13 * &m13));
    let second = &m02 * &(&(&m02 * &m23) - &(&m13 * &m03));
    let third = &m03 * &(&(&m02 * &m13) - &(&middle * &m03));
    &(&first - &second) + &third
}

/// The same by eliminating both u and v, and either from both ends: next to a border that is a point, where
/// there are as many roots as the degree, only that one keeps its digits for which it is at 0.
pub fn all_crossings(points: &Points, line: &Line) -> Vec<Crossing> {
    let mut found: Vec<Crossing> = Vec::new();
    for (exchange, reverse) in [(false, false), (false, true), (true, false), (true, true)] {
        let seen: Points = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let j = if reverse { 3 - j } else { j };
                if exchange { points[j][i] } else { points[i][j] }
            })
        });
        for mut crossing in crossings(&seen, line) {
            if reverse {
                crossing.v = number(1.0) - crossing.v;
            }
            if exchange {
                (crossing.u, crossing.v) = (crossing.v, crossing.u);
            }
            crossing.against ^= exchange != reverse;
            let beside = |a: Doubled, b: Doubled| (a - b).high.abs() < 1e-20;
            if !found.iter().any(|c| beside(c.u, crossing.u) && beside(c.v, crossing.v)) {
                found.push(crossing);
            }
        }
    }
    found.sort_by(|a, b| a.t.high.total_cmp(&b.t.high));
    found
}

/// In ascending order of t.
pub fn crossings(points: &Points, line: &Line) -> Vec<Crossing> {
    let d = line.direction;
    let main = (0..3).max_by(|&a, &b| d[a].abs().total_cmp(&d[b].abs())).unwrap();
    let others = [(main + 1) % 3, (main + 2) % 3];
    let away = points.map(|row| row.map(|p| [0, 1, 2].map(|i| p[i] - line.origin[i])));
    let plane = |axis: usize| {
        Bicubic::of(away.map(|row| row.map(|p| p[axis] * number(d[main]) - p[main] * number(d[axis]))))
    };
    let [f, g] = others.map(plane);
    let height = Bicubic::of(away.map(|row| row.map(|p| p[main])));
    let mut eliminated = resultant(&f.0, &g.0);
    // Where a border is a point, the lowest coefficients vanish.
    let zeros = eliminated.0.iter().take_while(|c| c.high == 0.0).count();
    eliminated.0.drain(..zeros.min(eliminated.0.len().saturating_sub(1)));
    let mut found: Vec<Crossing> = Vec::new();
    for v in eliminated.roots([-1e-9, 1.0 + 1e-9]) {
        // Each root of the one, moved to where both vanish.
        for u in f.at_v(v).roots([-1e-3, 1.001]).into_iter().chain(g.at_v(v).roots([-1e-3, 1.001])) {
            let (mut u, mut v) = (u, v);
            let mut settled = false;
            for _ in 0..60 {
                let ([a, au, av], [b, bu, bv]) = (f.slopes(u, v), g.slopes(u, v));
                let determinant = au * bv - av * bu;
                let (du, dv) = ((a * bv - av * b) / determinant, (au * b - a * bu) / determinant);
                (u, v) = (u - du, v - dv);
                let step = du.high.abs().max(dv.high.abs());
                if step.is_nan() || step >= 0.5 {
                    break;
                }
                if step < 1e-26 {
                    settled = true;
                    break;
                }
            }
            let inside = |c: Doubled| c.high >= 0.0 && (c - number(1.0)).high <= 0.0;
            let near = |a: Doubled, b: Doubled| (a - b).high.abs() < 1e-20;
            if !settled || !inside(u) || !inside(v) || found.iter().any(|c| near(c.u, u) && near(c.v, v)) {
                continue;
            }
            let ([_, au, av], [_, bu, bv]) = (f.slopes(u, v), g.slopes(u, v));
            // (f, g, the main axis) are right-handed; of f and g's scale d[main]² the sign is none, d[main]'s
            // remains.
            let determinant = (au * bv - av * bu).high * d[main];
            let t = height.slopes(u, v)[0] / number(d[main]);
            found.push(Crossing { t, u, v, against: determinant < 0.0 });
        }
    }
    found.sort_by(|a, b| a.t.high.total_cmp(&b.t.high));
    found
}
