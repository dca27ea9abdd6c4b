//! Real roots of polynomials up to the fourth degree, in order, each with a bound on its error.
//!
//! A polynomial is split at the roots of its derivative, which are found in the same way. Between two of them
//! it is monotonic: a change of sign means one root, and no change none. So no root can be missed or found
//! twice as long as signs are right, which they are to the square of the working precision: values come from
//! the compensated Horner scheme (Graillat, Langlois and Louvet, "Algorithms for Accurate, Validated and Fast
//! Polynomial Evaluation", JJIAM 26, 2009). Roots at which the sign doesn't change, those of a line that
//! touches, are none.

use smallvec::SmallVec;

/// A root of a polynomial or function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Root {
    /// The root.
    pub t: f64,
    /// Bound on the distance from the root of the polynomial as given, coefficients taken as exact.
    pub error: f64,
}

/// Roots in ascending order.
pub type Roots = SmallVec<[Root; 4]>;

/// A function's value and slope at a point, and a bound on the value's error.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// The value.
    pub value: f64,
    /// Derivative at the point.
    pub slope: f64,
    /// Bound on the error of the value.
    pub error: f64,
}

/// a·b − c·d with an error of 1.5 units in the last place (Kahan; Jeannerod, Louvet and Muller 2013).
pub fn difference_of_products(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let cd = c * d;
    let lost = (-c).mul_add(d, cd);
    a.mul_add(b, -cd) + lost
}

/// Simple roots of a·t² + b·t + c. A double root does not count; where all three vanish there is no root.
///
/// The root of larger magnitude has no cancellation; the other is c / (a · the larger). Nor has the
/// discriminant.
pub fn quadratic(a: f64, b: f64, c: f64) -> Roots {
    let half = 0.5 * b;
    let discriminant = difference_of_products(half, half, a, c);
    let mut roots = Roots::new();
    if discriminant.is_nan() || discriminant <= 0.0 {
        return roots;
    }
    let q = -(half + discriminant.sqrt().copysign(half));
    for t in [q / a, c / q] {
        // Where a vanishes, one root is far away or there is none.
        if t.is_finite() {
            roots.push(Root { t, error: 4.0 * f64::EPSILON * t.abs() });
        }
    }
    if let [first, second] = roots[..]
        && first.t > second.t
    {
        roots.swap(0, 1);
    }
    roots
}

/// All roots of a polynomial of degree 1 to 4, its coefficients in ascending order of powers.
pub fn polynomial(coefficients: &[f64]) -> Roots {
    let used = coefficients.iter().rposition(|&c| c != 0.0).map_or(0, |last| last + 1);
    let Some((&leading, rest)) = coefficients[..used].split_last() else { return Roots::new() };
    // Cauchy's bound on the magnitude of roots.
    let reach = 1.0 + rest.iter().fold(0.0f64, |most, c| most.max((c / leading).abs()));
    if reach.is_finite() { polynomial_within(&coefficients[..used], [-reach, reach]) } else { Roots::new() }
}

/// The roots of [`polynomial`] between two places.
pub fn polynomial_within(coefficients: &[f64], interval: [f64; 2]) -> Roots {
    assert!(coefficients.len() <= 5, "only up to the fourth degree");
    let [low, high] = interval;
    match *coefficients {
        [] | [_] => Roots::new(),
        [c, b] => within(quadratic(0.0, b, c), interval),
        [c, b, a] => within(quadratic(a, b, c), interval),
        _ => {
            let mut slope = [0.0; 4];
            for (power, &c) in coefficients.iter().enumerate().skip(1) {
                slope[power - 1] = c * power as f64;
            }
            let slope = &slope[..coefficients.len() - 1];
            let mut edges: SmallVec<[f64; 6]> = SmallVec::new();
            edges.push(low);
            edges.extend(polynomial_within(slope, interval).iter().map(|root| root.t));
            edges.push(high);
            sign_changes(&edges, |t| evaluate(coefficients, t))
        }
    }
}

fn within(mut roots: Roots, [low, high]: [f64; 2]) -> Roots {
    roots.retain(|root| low <= root.t && root.t <= high);
    roots
}

/// Bounds on a function's values and on its slopes over an interval.
#[derive(Clone, Copy, Debug)]
pub struct Enclosure {
    /// Least and greatest value.
    pub value: [f64; 2],
    /// Least and greatest slope.
    pub slope: [f64; 2],
}

/// Cuts an interval into pieces over each of which the function's value or its slope keeps its sign, so that
/// it changes its sign at most once; adds where it cuts to `edges`. The value is known from bounds on it, and
/// from that in the middle with bounds on the slope. A piece over which it is no more than `noise`, its own
/// rounding, is left as it is: there it touches zero.
pub fn isolate(
    interval: [f64; 2],
    noise: f64,
    function: &impl Fn(f64) -> Sample,
    enclose: &impl Fn([f64; 2]) -> Enclosure,
    edges: &mut SmallVec<[f64; 8]>,
) {
    // What is flatter than this many pieces can tell is taken to touch as well.
    const MOST_PIECES: usize = 4000;
    let mut waiting: SmallVec<[[f64; 2]; 32]> = SmallVec::from_slice(&[interval]);
    let mut pieces = 0;
    while let Some([low, high]) = waiting.pop() {
        pieces += 1;
        let Enclosure { value: [least, most], slope: [falling, rising] } = enclose([low, high]);
        let middle = 0.5 * (low + high);
        let change = 0.5 * (high - low) * rising.max(-falling);
        let there = function(middle).value;
        let (least, most) = (least.max(there - change - noise), most.min(there + change + noise));
        let keeps_sign = least > 0.0 || most < 0.0 || falling > 0.0 || rising < 0.0;
        let touches = -2.0 * noise <= least && most <= 2.0 * noise;
        if keeps_sign || touches || pieces > MOST_PIECES || !(low < middle && middle < high) {
            if high < interval[1] {
                edges.push(high);
            }
        } else {
            waiting.extend([[middle, high], [low, middle]]);
        }
    }
}

/// Roots of a continuous function that changes its sign at most once between neighbouring `edges`, which
/// ascend.
pub fn sign_changes(edges: &[f64], function: impl Fn(f64) -> Sample) -> Roots {
    let mut roots = Roots::new();
    // Where the value is exactly zero the function touches zero or passes through: the next edge tells.
    let mut last: Option<(f64, f64)> = None;
    for &edge in edges {
        let value = function(edge).value;
        if value.is_nan() || value == 0.0 {
            continue;
        }
        if let Some((before, sign)) = last
            && sign * value.signum() < 0.0
        {
            roots.push(bracketed(before, edge, sign, &function));
        }
        last = Some((edge, value.signum()));
    }
    roots
}

/// The root between `low`, where the function has the given sign, and `high`, where it has the other:
/// Newton's method, which halves the bracket where it would leave it or gains too little.
pub fn bracketed(low: f64, high: f64, sign: f64, function: &impl Fn(f64) -> Sample) -> Root {
    bracketed_from(0.5 * (low + high), [low, high], sign, function)
}

/// The same, from a first guess within the bracket.
pub fn bracketed_from(
    mut t: f64,
    [mut low, mut high]: [f64; 2],
    sign: f64,
    function: &impl Fn(f64) -> Sample,
) -> Root {
    const MOST_STEPS: usize = 200;
    let mut sample = function(t);
    let mut width = high - low;
    for _ in 0..MOST_STEPS {
        if sample.value * sign > 0.0 {
            low = t
        } else {
            high = t
        }
        let newton = t - sample.value / sample.slope;
        let inside = newton > low && newton < high;
        // Bisection takes over when the bracket doesn't shrink as fast as it would by itself and steps are
        // still large.
        let next = if inside && (newton - t).abs() < 0.5 * width { newton } else { 0.5 * (low + high) };
        width = (next - t).abs();
        if sample.value == 0.0 || next == t || !(low < next && next < high) {
            break;
        }
        t = next;
        sample = function(t);
        if width <= f64::EPSILON * t.abs() {
            break;
        }
    }
    // The slope changes hardly over a distance that is small beside that to the bracket's ends; twice covers
    // it.
    let near = 2.0 * (sample.value.abs() + sample.error) / sample.slope.abs() + f64::EPSILON * t.abs();
    Root { t, error: if near.is_finite() { near } else { width.max(high - low) } }
}

/// Value by the compensated Horner scheme, slope by the plain one.
fn evaluate(coefficients: &[f64], t: f64) -> Sample {
    let (mut value, mut lost, mut slope, mut size) = (0.0, 0.0, 0.0, 0.0);
    for &c in coefficients.iter().rev() {
        slope = slope * t + value;
        let product: f64 = value * t;
        let lost_by_product = f64::mul_add(value, t, -product);
        let sum = product + c;
        let back = sum - product;
        let lost_by_sum = (product - (sum - back)) + (c - back);
        lost = lost * t + (lost_by_product + lost_by_sum);
        value = sum;
        size = size * t.abs() + c.abs();
    }
    let value = value + lost;
    // u|p| + γ²₂ₙ Σ|c||t|ⁱ, with 2n at most 8.
    let unit = 0.5 * f64::EPSILON;
    Sample { value, slope, error: unit * value.abs() + 100.0 * unit * unit * size }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg as Random;

    fn times(a: &[f64], b: &[f64]) -> Vec<f64> {
        let mut product = vec![0.0; a.len() + b.len() - 1];
        for (i, x) in a.iter().enumerate() {
            for (j, y) in b.iter().enumerate() {
                product[i + j] += x * y;
            }
        }
        product
    }

    fn agree(found: &Roots, mut expected: Vec<f64>, what: &[f64]) {
        expected.sort_by(f64::total_cmp);
        assert_eq!(found.len(), expected.len(), "{what:?}: {found:?} {expected:?}");
        for (root, &exact) in found.iter().zip(&expected) {
            assert!((root.t - exact).abs() <= root.error, "{what:?}: {root:?} {exact}");
        }
    }

    /// The source's example: x² + 10⁸x + 1, of which the usual formula gets the small root wrong by a
    /// quarter.
    #[test]
    fn quadratics_do_not_lose_digits() {
        let roots = quadratic(1.0, 1e8, 1.0);
        assert_eq!(roots.len(), 2);
        assert!((roots[1].t / -1e-8 - 1.0).abs() < 1.1e-16 + 1e-15, "{roots:?}");
        assert!((roots[0].t / -1e8 - 1.0).abs() < 1e-15, "{roots:?}");
        // Both roots are near 1, and the discriminant 2⁻⁵² disappears in the rounding of b².
        let x = 1.0 + f64::EPSILON;
        let roots = quadratic(1.0, -2.0 * x, 1.0 + 2.0 * f64::EPSILON);
        let half = f64::EPSILON;
        agree(&roots, vec![x - half, x + half], &[]);
        assert!(quadratic(1.0, -2.0, 1.0).is_empty(), "a double root is none");
        assert!(quadratic(1.0, 0.0, 1.0).is_empty());
        assert!(quadratic(0.0, 0.0, 0.0).is_empty() && quadratic(0.0, 0.0, 1.0).is_empty());
        agree(&quadratic(0.0, 2.0, -3.0), vec![1.5], &[]);
        agree(&quadratic(0.0, -2.0, -3.0), vec![-1.5], &[]);
        agree(&quadratic(-4.0, 0.0, 1.0), vec![-0.5, 0.5], &[]);
    }

    /// Quartics whose coefficients are exact, so that their roots are known: four, two or no simple real
    /// roots.
    #[test]
    fn a_million_quartics_have_the_roots_they_were_made_of() {
        let mut random = Random::seed_from_u64(1);
        let mut largest_residual = 0.0f64;
        for _ in 0..1_000_000 {
            let mut polynomial_ = vec![1.0];
            let mut roots = Vec::new();
            let pairs = random.random_range(0..=2);
            for _ in 0..2 * pairs {
                let root = f64::from(random.random_range(-2048..=2048)) / 1024.0;
                polynomial_ = times(&polynomial_, &[-root, 1.0]);
                roots.push(root);
            }
            for _ in pairs..2 {
                // (t − m)² + h², h > 0.
                let m = f64::from(random.random_range(-2048..=2048)) / 1024.0;
                let h = f64::from(random.random_range(1..=2048)) / 1024.0;
                polynomial_ = times(&polynomial_, &[m * m + h * h, -2.0 * m, 1.0]);
            }
            roots.sort_by(f64::total_cmp);
            if roots.windows(2).any(|pair| pair[0] == pair[1]) {
                continue;
            }
            let found = polynomial(&polynomial_);
            for root in &found {
                largest_residual = largest_residual.max(evaluate(&polynomial_, root.t).value.abs());
            }
            agree(&found, roots, &polynomial_);
        }
        assert!(largest_residual < 1e-13, "{largest_residual}");
    }

    /// Two roots 2⁻²⁰ apart beside two others. Far closer pairs are told apart too, down to about 10⁻¹⁵.
    #[test]
    fn near_double_roots_are_told_apart() {
        let mut random = Random::seed_from_u64(2);
        let gap = 0.5f64.powi(20);
        for _ in 0..100_000 {
            let mut any = |grid: i32| f64::from(random.random_range(-2 * grid..=2 * grid)) / f64::from(grid);
            let (double, third, fourth) = (any(256), any(128), any(128));
            let roots = vec![double, double + gap, third, fourth];
            if double == third || third == fourth || double == fourth {
                continue;
            }
            let polynomial_ = roots.iter().fold(vec![1.0], |product, root| times(&product, &[-root, 1.0]));
            agree(&polynomial(&polynomial_), roots, &polynomial_);
        }
        // (t² − 2⁻⁹⁴)(t² − 4): a pair 1.4·10⁻¹⁴ apart.
        let close = 0.5f64.powi(94);
        let exact = vec![-2.0, -close.sqrt(), close.sqrt(), 2.0];
        agree(&polynomial(&[4.0 * close, 0.0, -4.0, 0.0, 1.0]), exact, &[]);
        // A double root is none, a triple one is one.
        assert_eq!(polynomial(&times(&[1.0, -2.0, 1.0], &[-6.0, 1.0, 1.0])).len(), 2);
        let triple = polynomial(&times(&times(&[-1.0, 1.0], &[1.0, -2.0, 1.0]), &[-2.0, 1.0]));
        assert_eq!(triple.len(), 2, "{triple:?}");
        assert!((triple[0].t - 1.0).abs() < 1e-4 && (triple[1].t - 2.0).abs() < 1e-14);
    }

    #[test]
    fn lower_degrees_and_odd_input() {
        agree(&polynomial(&[-6.0, 11.0, -6.0, 1.0]), vec![1.0, 2.0, 3.0], &[]);
        agree(&polynomial(&[-6.0, 11.0, -6.0, 1.0, 0.0]), vec![1.0, 2.0, 3.0], &[]);
        agree(&polynomial(&[3.0, -2.0]), vec![1.5], &[]);
        agree(&polynomial_within(&[-6.0, 11.0, -6.0, 1.0], [1.5, 2.5]), vec![2.0], &[]);
        assert!(
            polynomial(&[]).is_empty() && polynomial(&[1.0]).is_empty() && polynomial(&[0.0; 5]).is_empty()
        );
        assert!(polynomial(&[1.0, f64::NAN, 1.0]).is_empty());
        agree(&polynomial(&[-1e-12, 0.0, 0.0, 0.0, 1.0]), vec![-1e-3, 1e-3], &[]);
    }
}
