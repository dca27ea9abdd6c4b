//! Maps from the unit square to the domains that are sampled, each with its density.

use crate::geometry::Vec3;
use crate::geometry::angle::{sin_cos, sin_cos_of_eighth};
use crate::lanes::{Real, Vector};
use std::f64::consts::TAU;

/// A point of the unit disk, uniform in area, neighbours staying neighbours
/// (Shirley and Chiu, "A low distortion map between disk and square", JGT 2(3), 1997).
#[inline(always)]
pub fn disk<R: Real>(u: [R; 2]) -> [R; 2] {
    let [a, b] = u.map(|u| R::of(2.0) * u - R::of(1.0));
    let is_wide = a.abs().gt(b.abs());
    let (radius, turn) = (R::choose(is_wide, a, b), R::choose(is_wide, b / a, a / b));
    let (sin, cos) = sin_cos_of_eighth(turn);
    // The centre alone has no angle.
    let is_centre = radius.eq(R::of(0.0));
    let (along, across) = (radius * cos, radius * sin);
    let point = [R::choose(is_wide, along, across), R::choose(is_wide, across, along)];
    point.map(|c| R::choose(is_centre, R::of(0.0), c))
}

/// A point of a regular polygon with its corners on the unit circle, uniform in area, neighbours staying
/// neighbours: the map to the disk, each circle of which is bent into a polygon. The first corner lies
/// `rotation` radians from +y towards +x.
pub fn polygon(u: [f64; 2], corners: u32, rotation: f64) -> [f64; 2] {
    let (a, b) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    if a == 0.0 && b == 0.0 {
        return [0.0, 0.0];
    }
    // Polar coordinates of the disk's point, turns counted from +y towards +x, a negative radius meaning the
    // other side.
    let (radius, turns) = if a.abs() > b.abs() { (a, 0.25 - 0.125 * b / a) } else { (b, 0.125 * a / b) };
    let turns = if radius < 0.0 { turns + 0.5 } else { turns };
    // Along a side of the polygon of this radius: evenly, as the triangle between the centre and a side asks
    // for.
    let place = f64::from(corners) * turns;
    let side = place.floor();
    let corner = |i: f64| sin_cos(rotation + TAU * i / f64::from(corners));
    let (from, to, part) = (corner(side), corner(side + 1.0), place - side);
    [from.0 + part * (to.0 - from.0), from.1 + part * (to.1 - from.1)].map(|c| radius.abs() * c)
}

/// A direction around +z with density cos θ / π per steradian.
#[inline(always)]
pub fn cosine_hemisphere<R: Real>(u: [R; 2]) -> Vector<R> {
    let [x, y] = disk(u);
    Vector::new(x, y, (R::of(1.0) - x * x - y * y).greater(R::of(0.0)).sqrt())
}

/// The unit vector at an angle of this cosine to +z, `v` of a turn around it.
pub fn around_z(cos: f64, v: f64) -> Vec3 {
    let sin = ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
    let (y, x) = sin_cos(TAU * v);
    Vec3::new(sin * x, sin * y, cos)
}

/// One of several by their weights, of which `all` is the sum, and its share. What is left of the sample
/// value `u` is uniform again. `None` where none weighs anything.
#[inline]
pub fn pick(weights: &[f64], all: f64, u: &mut f64) -> Option<(usize, f64)> {
    let mut remaining = *u * all;
    for (index, &weight) in weights.iter().enumerate() {
        // The last that weighs anything takes what rounding leaves over.
        if weight > 0.0 && (remaining < weight || remaining - weight <= 1e-12 * all) {
            *u = below_one(remaining / weight);
            return Some((index, weight / all));
        }
        remaining -= weight;
    }
    None
}

/// A sample value that rounding may have moved out of the half-open unit interval, within it again.
#[inline(always)]
pub fn below_one<R: Real>(u: R) -> R {
    u.greater(R::of(0.0)).lesser(R::of(1f64.next_down()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::{chi_square, sidak};
    use rand::Rng;
    use rand_pcg::Pcg64Mcg;

    /// The square's point that a map of (turns, r²) would have taken to this point of a polygon.
    fn flattened([x, y]: [f64; 2], corners: u32, rotation: f64) -> [f64; 2] {
        let n = f64::from(corners);
        let turns = ((x.atan2(y) - rotation) / TAU).rem_euclid(1.0);
        // The triangle between the centre and a side, its axis in the middle of the side.
        let (half, side) = (0.5 * TAU / n, (turns * n).floor());
        let angle = turns * TAU - (2.0 * side + 1.0) * half;
        let apothem = x.hypot(y) * angle.cos() / half.cos();
        let along = 0.5 + 0.5 * angle.tan() / half.tan();
        [(side + along) / n, apothem * apothem]
    }

    #[test]
    fn polygons_are_filled_uniformly_to_the_corners() {
        let cases = [(3, 0.0), (5, 0.4), (6, 0.0), (7, -2.0)];
        let level = sidak(0.01, cases.len());
        for (corners, rotation) in cases {
            const SIDE: usize = 20;
            const POINTS: usize = 400_000;
            let mut counts = vec![0.0; SIDE * SIDE];
            let mut generator = Pcg64Mcg::new(u128::from(corners));
            let mut next = || (generator.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
            for _ in 0..POINTS {
                let u = [next(), next()];
                let v = flattened(polygon(u, corners, rotation), corners, rotation);
                assert!(v[1] <= 1.0 + 1e-12, "{u:?} lies outside: {v:?}");
                let [i, j] = v.map(|c| ((c * SIDE as f64) as usize).min(SIDE - 1));
                counts[j * SIDE + i] += 1.0;
            }
            let expected = [POINTS as f64 / (SIDE * SIDE) as f64; SIDE * SIDE];
            let p_value = chi_square(&counts, &expected).p_value;
            assert!(p_value > level, "{corners} corners: p = {p_value}");
        }
    }

    #[test]
    fn polygons_keep_neighbours_and_their_corners_are_where_they_should_be() {
        // A step of 1e-4 in the square never leads further than a few times that.
        let step = 1e-4;
        for i in 0..=500 {
            for j in 0..=500 {
                let u = [f64::from(i) / 500.0, f64::from(j) / 500.0 * (1.0 - step)];
                let (p, q) = (polygon(u, 5, 0.3), polygon([u[0], u[1] + step], 5, 0.3));
                assert!((p[0] - q[0]).hypot(p[1] - q[1]) < 5.0 * step, "{u:?} {p:?} {q:?}");
            }
        }
        let furthest = (0..100_000)
            .map(|i| polygon([f64::from(i) / 1e5, 1.0], 4, 0.0))
            .fold([0.0; 2], |a, b| if b[1] > a[1] { b } else { a });
        assert!(furthest[0].abs() < 1e-4 && (furthest[1] - 1.0).abs() < 1e-4, "{furthest:?}");
    }
}
