//! On which side of a line a point of the plane is, exactly.

use glam::DVec2;

/// Positive where `p` is to the left of the line from `a` to `b`, negative to the right of it, and zero only
/// on it: twice the triangle's area, whose sign is exact (Shewchuk, "Adaptive Precision Floating-Point
/// Arithmetic", 1997) unless products underflow.
pub fn orientation(a: DVec2, b: DVec2, p: DVec2) -> f64 {
    let (left, right) = ((a.x - p.x) * (b.y - p.y), (a.y - p.y) * (b.x - p.x));
    let area = left - right;
    // Shewchuk's bound A on what rounding can have done, (3 + 16u) u.
    if area.abs() > 3.330_669_073_875_471_6e-16 * (left.abs() + right.abs()) {
        return area;
    }
    let mut sum = [0.0; 13];
    let products = [(a.x, b.y), (-a.y, b.x), (b.x, p.y), (-b.y, p.x), (p.x, a.y), (-p.y, a.x)];
    for (x, y) in products {
        let product = x * y;
        add(&mut sum, x.mul_add(y, -product));
        add(&mut sum, product);
    }
    // The components don't overlap: the last that isn't zero is the largest and has the sign.
    sum.into_iter().rfind(|&component| component != 0.0).unwrap_or(0.0)
}

/// Adds to a sum of components that don't overlap, in ascending order of magnitude (Shewchuk's
/// GROW-EXPANSION).
fn add(sum: &mut [f64; 13], mut carried: f64) {
    for component in sum.iter_mut() {
        let total = carried + *component;
        let back = total - carried;
        *component = (carried - (total - back)) + (*component - back);
        carried = total;
    }
    // Twelve numbers are added to thirteen places: what is carried out goes into the last, which is free.
    sum.rotate_left(1);
    sum[12] = carried;
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Around a point of a line whose coordinates have few digits, the sign is that of integers.
    #[test]
    fn signs_are_exact() {
        let unit = 0.5f64.powi(50);
        let point = |x: i64, y: i64| DVec2::new(0.5 + x as f64 * unit, 0.5 + y as f64 * unit);
        let (a, b) = (DVec2::splat(12.0), DVec2::splat(24.0));
        for x in -20..20 {
            for y in -20..20 {
                let sign = orientation(a, b, point(x, y));
                assert_eq!(sign.partial_cmp(&0.0), Some((y - x).cmp(&0)), "{x} {y}: {sign:e}");
                assert_eq!(orientation(b, a, point(x, y)).partial_cmp(&0.0), Some((x - y).cmp(&0)));
            }
        }
        assert_eq!(orientation(a, a, point(1, 2)), 0.0);
    }
}
