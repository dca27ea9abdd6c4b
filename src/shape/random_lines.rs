//! Random-line sampling: points on any surface whose crossings with lines are known, with an exact density.
//!
//! An axis is chosen in proportion to the face of a box around the surface, then uniformly a line along it
//! through the box, then one of the k crossings of the line with the surface. The point x with normal n has
//! the density Σᵢ |nᵢ| / kᵢ(x) per area, over the sum of the three faces, where kᵢ is the number of crossings
//! of the line through x along axis i. A line may miss the surface: then there is no point.

use crate::geometry::{Bounds, Vec3};
use smallvec::SmallVec;

/// A surface in coordinates of its own.
pub(super) trait Crossed {
    /// A box around it.
    fn around(&self) -> Bounds;
    /// Where the line through a point, its direction of unit length, crosses the surface.
    fn crossed(&self, origin: Vec3, direction: Vec3) -> SmallVec<[OnLine; 4]>;
    /// Unit normal, of either sign, at a point of a part.
    fn normal(&self, point: Vec3, part: u32) -> Vec3;
}

/// A crossing in a surface's own coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct OnLine {
    pub t: f64,
    /// Bound on the error of t.
    pub error: f64,
    pub enters: bool,
    pub part: u32,
}

const AXES: [Vec3; 3] = Vec3::AXES;

/// The areas of a box's faces across the three axes.
fn faces(around: Bounds) -> Vec3 {
    let size = around.max - around.min;
    Vec3::new(size.y * size.z, size.z * size.x, size.x * size.y)
}

/// The line along an axis through fractions of the face across it.
fn line_through(around: Bounds, axis: usize, [a, b]: [f64; 2]) -> Vec3 {
    let size = around.max - around.min;
    let mut origin = around.min;
    origin[(axis + 1) % 3] += a * size[(axis + 1) % 3];
    origin[(axis + 2) % 3] += b * size[(axis + 2) % 3];
    origin
}

/// The point for `u` in [0, 1)² and the part that it is on.
pub(super) fn sample(surface: &impl Crossed, u: [f64; 2]) -> Option<(Vec3, u32)> {
    let around = surface.around();
    let faces = faces(around);
    let mut at = u[0] * faces.element_sum();
    let mut axis = 0;
    while axis < 2 && at >= faces[axis] {
        at -= faces[axis];
        axis += 1;
    }
    // What is left of u chooses a twelfth of k crossings, which for k up to 4 is enough, then a place, and by
    // the place's last digits, on which nothing else depends, where in the twelfth.
    const CHOICES: f64 = 12.0;
    const STRIPS: f64 = 65536.0;
    let scaled = (at / faces[axis]).clamp(0.0, 1.0 - f64::EPSILON) * CHOICES;
    let choice = scaled.floor();
    let place = scaled - choice;
    let origin = line_through(around, axis, [place, u[1]]);
    let crossings = surface.crossed(origin, AXES[axis]);
    let rank = (choice + (place * STRIPS).fract()) / CHOICES;
    let chosen = crossings.get((rank * crossings.len() as f64) as usize)?;
    Some((origin + AXES[axis] * chosen.t, chosen.part))
}

/// Per unit of the surface's own area, at a point with unit normal of either sign.
pub(super) fn density(surface: &impl Crossed, point: Vec3, normal: Vec3) -> f64 {
    let of_axis = |axis: usize| {
        let crossings = surface.crossed(point, AXES[axis]).len();
        normal[axis].abs() / crossings.max(1) as f64
    };
    (of_axis(0) + of_axis(1) + of_axis(2)) / faces(surface.around()).element_sum()
}

/// ∫ weight(normal) over the surface, to some 10⁻⁴ of it, over lines that are spread evenly:
/// ∫ Σ |nᵢ| over the lines along axis i is ∫ nᵢ² over the surface, and the squares of the three add up
/// to one.
pub(super) fn integral(surface: &impl Crossed, weight: impl Fn(Vec3) -> f64) -> f64 {
    // A lattice whose rows follow no diagonal: the step is to the number of lines, a prime, as 1 to the
    // plastic number, 1.3247. In a square grid a whole row of lines may lie on one edge of a figure.
    const LINES: usize = 40_009;
    const STEP: usize = 30_201;
    let around = surface.around();
    let faces = faces(around);
    let mut sum = 0.0;
    for (axis, &direction) in AXES.iter().enumerate() {
        for i in 0..LINES {
            let at = [i, i * STEP % LINES].map(|k| (k as f64 + 0.5) / LINES as f64);
            let origin = line_through(around, axis, at);
            for crossing in surface.crossed(origin, direction) {
                let normal = surface.normal(origin + direction * crossing.t, crossing.part);
                sum += normal[axis].abs() * weight(normal) * faces[axis] / LINES as f64;
            }
        }
    }
    sum
}
