//! How far a group reaches in each direction, by which its turned instances are bounded.

use crate::geometry::{Bounds, Pose, Vec3};

/// Steps from one axis to another.
const STEPS: i32 = 12;

/// Bounds on the support function h(d) = max over a body's points x of d · x: known for the points of a
/// lattice on the octahedron |x| + |y| + |z| = [`STEPS`].
///
/// h is convex and h(s d) = s h(d) for s > 0. So a direction that is a sum of lattice points with weights of
/// at least 0 has no larger h than the sum of theirs. Lattice points are some 7° apart: that bounds a ball to
/// about 0.5 %, and a box that fits into it to about 6 % of the ball's radius.
#[derive(Clone, Debug)]
pub(super) struct Hull {
    /// See [`place`]; empty where there is no body.
    supports: Vec<f64>,
}

/// Where the support in the direction of a lattice point is kept: by its first two coordinates and the sign
/// of the third.
fn place([x, y, z]: [i32; 3]) -> usize {
    let row = (x + STEPS) * (2 * STEPS + 1) + y + STEPS;
    2 * row as usize + usize::from(z < 0)
}

impl Hull {
    /// The hull of boxes.
    pub fn of(boxes: &[Bounds]) -> Self {
        if boxes.is_empty() {
            return Self { supports: Vec::new() };
        }
        let mut supports = vec![0.0; place([STEPS, STEPS, -1]) + 1];
        for (x, y) in (-STEPS..=STEPS).flat_map(|x| (-STEPS..=STEPS).map(move |y| (x, y))) {
            let rest = STEPS - x.abs() - y.abs();
            for point in [[x, y, rest], [x, y, -rest]].into_iter().filter(|_| rest >= 0) {
                let direction = Vec3::from_array(point.map(f64::from));
                let reach = boxes.iter().map(|bounds| bounds.support(direction));
                supports[place(point)] = reach.fold(f64::NEG_INFINITY, f64::max);
            }
        }
        Self { supports }
    }

    /// An upper bound of the support in a direction of any length.
    fn support(&self, direction: Vec3) -> f64 {
        let length = direction.abs().element_sum();
        if length == 0.0 {
            return 0.0;
        }
        let scaled = direction.abs() * (f64::from(STEPS) / length);
        let (first, fraction) = (scaled.floor(), scaled.fract().to_array());
        let corner = first.to_array().map(|coordinate| coordinate as i32);
        let of_point = |up: [bool; 3]| {
            let point = std::array::from_fn(|axis| {
                let coordinate = corner[axis] + i32::from(up[axis]);
                if direction[axis] < 0.0 { -coordinate } else { coordinate }
            });
            self.supports[place(point)]
        };
        // The lattice point itself, or the triangle around the place, which points up or down.
        let sum = match STEPS - corner.iter().sum::<i32>() {
            0 => of_point([false; 3]),
            1 => (0..3).map(|axis| fraction[axis] * of_point([0, 1, 2].map(|up| up == axis))).sum(),
            2 => (0..3).map(|axis| (1.0 - fraction[axis]) * of_point([0, 1, 2].map(|up| up != axis))).sum(),
            _ => of_point([true; 3]),
        };
        sum * (length / f64::from(STEPS))
    }

    /// A box around the body at a pose, up to rounding; empty where there is no body.
    pub fn bounds(&self, pose: &Pose) -> Bounds {
        if self.supports.is_empty() {
            return Bounds::EMPTY;
        }
        let columns = Vec3::AXES.map(|axis| pose.world_vector(axis));
        let along = |axis: usize| Vec3::from_array(columns.map(|column| column[axis]));
        let origin = pose.world_point(Vec3::ZERO);
        let reach = |sign: f64| Vec3::from_array([0, 1, 2].map(|axis| self.support(sign * along(axis))));
        Bounds { min: origin - reach(-1.0), max: origin + reach(1.0) }
    }
}

/// Whether a pose turns boxes, so that those around them are larger.
pub(super) fn turns_boxes(pose: &Pose) -> bool {
    let turned =
        |axis: Vec3| pose.world_vector(axis).to_array().into_iter().filter(|&x| x != 0.0).count() > 1;
    Vec3::AXES.into_iter().any(turned)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Transform;

    /// The support of two boxes is known. That of the hull is at most 6 % of the body's radius above it.
    #[test]
    fn supports_are_bounded_closely_from_above() {
        let boxes = [
            Bounds { min: Vec3::new(-1.0, -0.5, 0.2), max: Vec3::new(0.3, 0.7, 0.9) },
            Bounds { min: Vec3::new(0.1, -0.9, -1.0), max: Vec3::new(0.8, 0.2, 0.4) },
        ];
        let hull = Hull::of(&boxes);
        let numbers = || (-4..=4).map(|i| f64::from(i) * 0.25);
        for (x, y) in numbers().flat_map(|x| numbers().map(move |y| (x, y))) {
            for z in [-1.0, -0.37, 0.0, 0.61, 1.0] {
                let direction = Vec3::new(x, y, z);
                let corners = boxes.iter().flat_map(|bounds| bounds.corners());
                let exact = corners.map(|corner| direction.dot(corner)).fold(f64::NEG_INFINITY, f64::max);
                let (found, length) = (hull.support(direction), direction.length());
                assert!(found >= exact - 1e-14, "{direction}: {found} {exact}");
                assert!(found <= exact + 0.08 * length, "{direction}: {found} {exact}");
            }
        }
        assert!(Hull::of(&[]).bounds(&Pose::new(&Transform::IDENTITY)).is_empty());
    }
}
