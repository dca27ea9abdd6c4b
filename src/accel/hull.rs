//! How far a group reaches in each direction, by which its turned instances are bounded, and a ball around
//! it, by which rays are found to miss them.

use crate::geometry::{Bounds, Pose, Ray, Vec3};
use std::f64::consts::PI;

/// Steps from one axis to another.
const STEPS: i32 = 12;

/// Bounds on the support function h(d) = max over a body's points x of d · x: known for the points of a
/// lattice on the octahedron |x| + |y| + |z| = [`STEPS`].
///
/// h is convex and h(s d) = s h(d) for s > 0. So a direction that is a sum of lattice points with weights of
/// at least 0 has no larger h than the sum of theirs. Lattice points are some 7° apart. That bounds a ball
/// to about 0.5 %, and a box that fits into it to about 6 % of the ball's radius.
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

/// A ball around a group. A ray that meets the box around a roundish body misses the body as often as not.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ball {
    centre: Vec3,
    radius: f64,
}

impl Ball {
    /// Around boxes.
    pub fn around(boxes: &[Bounds]) -> Self {
        let centre = Bounds::of_all(boxes.iter().copied()).centre();
        let corners = boxes.iter().flat_map(|bounds| bounds.corners());
        let radius = corners.map(|corner| corner.distance(centre)).fold(0.0, f64::max);
        Self { centre, radius }
    }

    /// Around the same at a pose.
    pub fn at(self, pose: &Pose) -> Self {
        let centre = pose.world_point(self.centre);
        let squared = pose.linear.transpose() * pose.linear;
        // No eigenvalue is larger than the largest sum of moduli in a row.
        let sums = squared.x_axis.abs() + squared.y_axis.abs() + squared.z_axis.abs();
        let rounding = 16.0 * f64::EPSILON * (centre.abs().max_element() + pose.origin.abs().max_element());
        Self { centre, radius: self.radius * sums.max_element().sqrt() * (1.0 + 1e-12) + rounding }
    }

    /// Whether fewer rays meet it than a box.
    pub fn is_smaller_than(&self, bounds: Bounds) -> bool {
        // The area of a convex body's shadow is a quarter of its surface on average.
        PI * self.radius * self.radius < 0.5 * bounds.half_area()
    }

    /// Whether a ray surely misses it.
    #[inline(always)]
    pub fn misses(&self, ray: &Ray) -> bool {
        let toward = self.centre - ray.origin;
        let along = toward.dot(ray.direction);
        let (squared, radius2) = (toward.length_squared(), self.radius * self.radius);
        let outside = squared - radius2;
        // Differences of squares lose digits with the distance.
        let rounding = 64.0 * f64::EPSILON * (squared + radius2);
        outside > rounding && (along < 0.0 || outside - along * along > rounding)
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
    use glam::DMat4;
    use rand::RngExt;
    use rand_pcg::Pcg64;

    /// Rays toward points of a stretched and turned body never miss the ball around it, near and far. Most of
    /// those that pass at twice its radius do.
    #[test]
    fn rays_to_a_body_do_not_miss_the_ball_around_it() {
        let bounds = Bounds { min: Vec3::new(-1.0, -0.5, 0.2), max: Vec3::new(0.3, 0.7, 0.9) };
        let mut random = Pcg64::new(7, 0);
        let mut number = |most: f64| random.random_range(-most..most);
        for far in [0.0, 10.0, 1e6, 1e9] {
            let turned = DMat4::from_rotation_x(0.7) * DMat4::from_scale(Vec3::new(1.0, 2.0, 0.3));
            let shift = Vec3::new(far, -0.3 * far, 0.1);
            let pose = Pose::new(&Transform::new(DMat4::from_translation(shift) * turned).unwrap());
            let ball = Ball::around(&[bounds]).at(&pose);
            let mut passing = 0;
            for corner in (0..500).flat_map(|_| bounds.corners()) {
                let target = pose.world_point(corner);
                let origin =
                    target + Vec3::from_array([0; 3].map(|_| number(3.0))) + 0.3 * number(1.0) * shift;
                let direction = (target - origin).normalize();
                let ray = Ray { origin, direction, t_max: f64::INFINITY };
                assert!(!ball.misses(&ray), "{ray:?} {ball:?}");
                let aside = direction.any_orthonormal_vector() * 2.0 * ball.radius;
                passing +=
                    i32::from(ball.misses(&Ray { origin: ball.centre + aside - 5.0 * direction, ..ray }));
            }
            assert!(passing > 3600 || far > 1e6, "{far}: {passing}");
        }
    }

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
