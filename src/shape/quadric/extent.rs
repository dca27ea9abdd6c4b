//! How far quadrics reach.

use super::form::QuadraticForm;
use crate::geometry::{Bounds, Vec3};
use crate::shape::support;
use glam::{DMat2, DVec2};

/// A box around the surface within the planes of `clip`, or around what it encloses where it is `solid`,
/// though not the smallest. `None` where it has no end.
pub(super) fn reach(form: &QuadraticForm, clip: Bounds, solid: bool) -> Option<Bounds> {
    let mut within = clip;
    if let Some(ellipsoid) = ellipsoid(form, solid) {
        within = intersection(within, ellipsoid);
    }
    for axis in 0..3 {
        if clip.min[axis].is_finite()
            && clip.max[axis].is_finite()
            && let Some(sections) = sections(form, axis, [clip.min[axis], clip.max[axis]], solid)
        {
            within = intersection(within, sections);
        }
    }
    (within.min.is_finite() && within.max.is_finite()).then_some(within)
}

fn intersection(a: Bounds, b: Bounds) -> Bounds {
    Bounds { min: a.min.max(b.min), max: a.max.min(b.max) }
}

/// The box of an ellipsoid; `None` for other quadrics.
fn ellipsoid(form: &QuadraticForm, solid: bool) -> Option<Bounds> {
    let a = &form.a;
    let minor = a.x_axis.x * a.y_axis.y - a.x_axis.y * a.x_axis.y;
    let sign = a.x_axis.x.signum();
    let definite = minor > 0.0 && a.determinant() * sign > 0.0 && (sign > 0.0 || !solid);
    let centre = form.centre().filter(|_| definite)?;
    let inverse = a.inverse();
    let level = -form.value(centre);
    let diagonal = Vec3::new(inverse.x_axis.x, inverse.y_axis.y, inverse.z_axis.z);
    let half = (level * diagonal).max(Vec3::ZERO).map(f64::sqrt);
    Some(Bounds { min: centre - half, max: centre + half })
}

/// A box around the ellipses that planes across an axis, from one to another, cut from the surface; `None`
/// where they cut other curves.
fn sections(form: &QuadraticForm, axis: usize, range: [f64; 2], solid: bool) -> Option<Bounds> {
    let (i, j, k) = ((axis + 1) % 3, (axis + 2) % 3, axis);
    let a = |row: usize, column: usize| form.a.col(column)[row];
    let block = DMat2::from_cols(DVec2::new(a(i, i), a(i, j)), DVec2::new(a(i, j), a(j, j)));
    let size = block.x_axis.length() * block.y_axis.length();
    if block.determinant() <= 1e-12 * size || (solid && a(i, i) < 0.0) {
        return None;
    }
    let inverse = block.inverse();
    // At z the ellipse is around m + n z, where the form has the value p z² + 2 q z + r.
    let (b, across) = (DVec2::new(form.b[i], form.b[j]), DVec2::new(a(i, k), a(j, k)));
    let (m, n) = (-(inverse * b), -(inverse * across));
    let (p, q, r) = (a(k, k) + across.dot(n), form.b[k] + across.dot(m), form.c + b.dot(m));
    let value = |z: f64| z * (p * z + 2.0 * q) + r;
    let vertex = (-q / p).clamp(range[0], range[1]);
    let places = [range[0], range[1], if vertex.is_finite() { vertex } else { range[0] }];
    // The block can have either sign: the one in which value · inverse is negative counts.
    let sign = a(i, i).signum();
    let level = places.map(|z| -value(z) * sign).into_iter().fold(0.0, f64::max);
    let half =
        (level * sign * DVec2::new(inverse.x_axis.x, inverse.y_axis.y)).max(DVec2::ZERO).map(f64::sqrt);
    let (low, high) = (m + n * range[0], m + n * range[1]);
    let mut bounds = Bounds { min: Vec3::splat(range[0]), max: Vec3::splat(range[1]) };
    (bounds.min[i], bounds.max[i]) = (low.x.min(high.x) - half.x, low.x.max(high.x) + half.x);
    (bounds.min[j], bounds.max[j]) = (low.y.min(high.y) - half.y, low.y.max(high.y) + half.y);
    Some(bounds)
}

/// The largest direction · x over the surface (or what it encloses) within a box; `None` where there is no
/// surface.
pub(super) fn reach_toward(
    form: &QuadraticForm,
    within: Bounds,
    clipped_across: bool,
    solid: bool,
    direction: Vec3,
) -> Option<f64> {
    if !clipped_across && let Some(reach) = of_revolution(form, [within.min.z, within.max.z], direction) {
        return reach;
    }
    support::support(direction, within, support::COARSE, |cell| {
        let half = 0.5 * (cell.max - cell.min);
        let centre = cell.centre();
        let value = form.value(centre);
        // What the value can change by within the cell: the form's own size, less its value at the centre.
        let quadratic = QuadraticForm { b: Vec3::ZERO, c: 0.0, ..*form }.size(half);
        let change = form.gradient(centre).abs().dot(half) + quadratic;
        value > change || (!solid && value < -change)
    })
}

/// The same for a surface of revolution around z; `None` for other quadrics. Solid or not makes no
/// difference.
fn of_revolution(form: &QuadraticForm, [low, high]: [f64; 2], direction: Vec3) -> Option<Option<f64>> {
    let scale = form.a.x_axis.x;
    let round = form.a.x_axis == Vec3::X * scale
        && form.a.y_axis == Vec3::Y * scale
        && form.a.z_axis.truncate() == DVec2::ZERO
        && form.b.truncate() == DVec2::ZERO
        && scale > 0.0;
    if !round {
        return None;
    }
    // r² = p z² + 2 q z + s
    let [p, q, s] = [-form.a.z_axis.z / scale, -form.b.z / scale, -form.c / scale];
    let (across, along) = (direction.truncate().length(), direction.z);
    let squared = |z: f64| z * (p * z + 2.0 * q) + s;
    let mut places = [low, high, f64::NAN, f64::NAN, f64::NAN, f64::NAN];
    // Where the surface meets its axis.
    for (place, root) in places[2..4].iter_mut().zip(crate::geometry::roots::quadratic(p, 2.0 * q, s)) {
        *place = root.t;
    }
    // Where its tangent lies across the direction: (p z + q) across = ∓ along · r.
    let discriminant = q * q - p * s;
    let bend = along * along - p * across * across;
    if p == 0.0 {
        places[4] = ((across * q / along).powi(2) - s) / (2.0 * q);
    } else if discriminant * bend > 0.0 {
        let m = along.abs() * (discriminant / bend).sqrt();
        (places[4], places[5]) = ((m - q) / p, (-m - q) / p);
    }
    let there = places.into_iter().filter(|&z| {
        let rounding = 8.0 * f64::EPSILON * ((p * z * z).abs() + 2.0 * (q * z).abs() + s.abs());
        low <= z && z <= high && squared(z) >= -rounding
    });
    Some(there.map(|z| along * z + across * squared(z).max(0.0).sqrt()).reduce(f64::max))
}
