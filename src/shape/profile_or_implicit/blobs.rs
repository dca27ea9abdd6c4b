//! Blobs: the surface on which soft balls, each densest in its centre, add up to a threshold.
//!
//! Along a line each ball's density rises and falls once, with a slope that is bounded over any interval by
//! that at its ends. So the sum's values and slopes are bounded too, and all its roots can be isolated,
//! whatever the kernel (Glassner, *An Introduction to Ray Tracing*, ch. 3, blobs). The middle piece of a
//! metaball is no quadratic in t, so it has no closed form.

use super::Local;
use crate::geometry::roots::{Enclosure, Sample, isolate, sign_changes};
use crate::geometry::{Bounds, Vec3, angle};
use crate::shape::random_lines::OnLine;
use crate::shape::{ShapeError, support};
use smallvec::SmallVec;
use std::f64::consts::{PI, TAU};

/// How dense a ball is at the fraction r of its radius.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// exp(−4 r²), without end (Blinn 1982; there with a factor of choice, here 1/e at half the radius).
    Gaussian,
    /// 1 − 3 r² up to a third, 3/2 (1 − r)² up to 1 (Nishimura and others 1985; the source's second piece is
    /// misprinted).
    Metaball,
    /// 1 − 22/9 r² + 17/9 r⁴ − 4/9 r⁶ up to 1 (Wyvill, McPheeters and Wyvill 1986).
    Soft,
}

impl Kernel {
    /// Value and derivative by r², which rises nowhere and whose slope only flattens.
    fn at(self, squared: f64) -> [f64; 2] {
        match self {
            Self::Gaussian => {
                let value = (-4.0 * squared).exp();
                [value, -4.0 * value]
            }
            _ if squared >= 1.0 => [0.0; 2],
            Self::Metaball if squared <= 1.0 / 9.0 => [1.0 - 3.0 * squared, -3.0],
            Self::Metaball => {
                let r = squared.sqrt();
                [1.5 * (1.0 - r) * (1.0 - r), -1.5 * (1.0 - r) / r]
            }
            Self::Soft => {
                // (1 − r²)² (9 − 4 r²) / 9
                let (rest, last) = (1.0 - squared, 9.0 - 4.0 * squared);
                [rest * rest * last / 9.0, -rest * (2.0 * last + 4.0 * rest) / 9.0]
            }
        }
    }

    /// Where the value is at most this fraction of that in the centre, as a fraction of the radius.
    fn extent(self, fraction: f64) -> f64 {
        match self {
            Self::Gaussian => (-fraction.min(1.0).ln() / 4.0).sqrt(),
            Self::Metaball | Self::Soft => 1.0,
        }
    }
}

/// One of the balls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blob {
    /// Where its density is greatest, in the shape's own coordinates.
    pub centre: Vec3,
    /// The radius that its kernel is scaled by. Above 0.
    pub radius: f64,
    /// In its centre; a negative one takes away from the others.
    pub strength: f64,
}

#[derive(Clone, Debug)]
pub(super) struct Blobs {
    blobs: Vec<Blob>,
    kernel: Kernel,
    threshold: f64,
    around: Bounds,
    /// Mean of the balls' centres.
    middle: Vec3,
    /// Sum of the magnitudes of the strengths, and of the steepest slopes.
    size: f64,
    steepness: f64,
}

impl Blobs {
    /// The surface, with the length and the origin of its coordinates.
    pub fn new(blobs: &[Blob], kernel: Kernel, threshold: f64) -> Result<(Self, f64, Vec3), ShapeError> {
        for blob in blobs {
            if !(blob.radius > 0.0 && blob.radius.is_finite()) {
                return Err(ShapeError::Radius(blob.radius));
            }
        }
        let finite = blobs.iter().all(|blob| blob.centre.is_finite() && blob.strength.is_finite());
        if !(finite && threshold > 0.0 && threshold.is_finite()) {
            return Err(ShapeError::Threshold);
        }
        // Where each is below its fraction of the threshold there is nothing.
        let fraction = threshold / blobs.len() as f64;
        let mut around = Bounds::EMPTY;
        for blob in blobs.iter().filter(|blob| blob.strength > 0.0) {
            let reach = Vec3::splat(blob.radius * kernel.extent(fraction / blob.strength));
            around = around.including(blob.centre - reach).including(blob.centre + reach);
        }
        if around.is_empty() {
            return Err(ShapeError::Threshold);
        }
        let (origin, scale) = (around.centre(), 0.5 * (around.max - around.min).max_element());
        let local = |blob: &Blob| Blob {
            centre: (blob.centre - origin) / scale,
            radius: blob.radius / scale,
            strength: blob.strength / threshold,
        };
        let blobs: Vec<Blob> = blobs.iter().map(local).collect();
        let mut made = Self {
            kernel,
            threshold: 1.0,
            around: Bounds { min: (around.min - origin) / scale, max: (around.max - origin) / scale },
            middle: blobs.iter().map(|blob| blob.centre).sum::<Vec3>() / blobs.len() as f64,
            size: 1.0 + blobs.iter().map(|blob| blob.strength.abs()).sum::<f64>(),
            // No kernel is steeper than 2 per radius.
            steepness: blobs.iter().map(|blob| 2.0 * blob.strength.abs() / blob.radius).sum(),
            blobs,
        };
        let toward = |direction: Vec3| made.search(direction).ok_or(ShapeError::Threshold);
        let max = Vec3::new(toward(Vec3::X)?, toward(Vec3::Y)?, toward(Vec3::Z)?);
        let min = -Vec3::new(toward(-Vec3::X)?, toward(-Vec3::Y)?, toward(-Vec3::Z)?);
        made.around = Bounds { min: min.max(made.around.min), max: max.min(made.around.max) };
        Ok((made, scale, origin))
    }

    /// The density less the threshold, and its gradient.
    fn value(&self, point: Vec3) -> (f64, Vec3) {
        let (mut value, mut gradient) = (-self.threshold, Vec3::ZERO);
        for Blob { centre, radius, strength } in &self.blobs {
            let away = (point - centre) / radius;
            let [density, slope] = self.kernel.at(away.length_squared());
            value += strength * density;
            gradient += away * (2.0 * strength * slope / radius);
        }
        (value, gradient)
    }

    /// Bounds on the value within a box.
    fn range(&self, cell: Bounds) -> [f64; 2] {
        let (mut least, mut most) = (-self.threshold, -self.threshold);
        for Blob { centre, radius, strength } in &self.blobs {
            let near = (*centre - centre.clamp(cell.min, cell.max)).length_squared();
            let far = (*centre - cell.min).abs().max((*centre - cell.max).abs()).length_squared();
            let ends = [near, far].map(|squared| strength * self.kernel.at(squared / (radius * radius))[0]);
            least += ends[0].min(ends[1]);
            most += ends[0].max(ends[1]);
        }
        [least, most]
    }

    /// Bounds on the gradient within a box, component by component.
    fn gradients(&self, cell: Bounds) -> [Vec3; 2] {
        let (mut least, mut most) = (Vec3::ZERO, Vec3::ZERO);
        for Blob { centre, radius, strength } in &self.blobs {
            let near = (*centre - centre.clamp(cell.min, cell.max)).length_squared();
            let far = (*centre - cell.min).abs().max((*centre - cell.max).abs()).length_squared();
            let scale = 1.0 / (radius * radius);
            let slopes =
                [near, far].map(|squared| 2.0 * strength * scale * self.kernel.at(squared * scale)[1]);
            let away = [cell.min - centre, cell.max - centre];
            let products =
                [away[0] * slopes[0], away[0] * slopes[1], away[1] * slopes[0], away[1] * slopes[1]];
            least += products.into_iter().reduce(Vec3::min).unwrap_or(Vec3::ZERO);
            most += products.into_iter().reduce(Vec3::max).unwrap_or(Vec3::ZERO);
        }
        [least, most]
    }

    /// The largest direction · x. At the farthest point the gradient is along the direction.
    fn search(&self, direction: Vec3) -> Option<f64> {
        let (across, over) = direction.normalize().any_orthonormal_pair();
        support::support(direction, self.around, support::FINE, |cell| {
            let [least, most] = self.range(cell);
            if most < 0.0 || least > 0.0 {
                return true;
            }
            let [least, most] = self.gradients(cell);
            let (middle, half) = (0.5 * (least + most), 0.5 * (most - least));
            let slack = 1e-12 * self.steepness;
            [across, over].iter().any(|axis| middle.dot(*axis).abs() > half.dot(axis.abs()) + slack)
        })
    }
}

/// A ball as a line sees it.
struct Passed {
    /// Nearest to the centre.
    t: f64,
    /// Squared distance, in radii.
    off: f64,
    /// 1 / radius².
    scale: f64,
    strength: f64,
}

impl Passed {
    fn squared(&self, t: f64) -> f64 {
        self.off + (t - self.t) * (t - self.t) * self.scale
    }
}

impl Blobs {
    fn along(&self, kernels: &[Passed], t: f64) -> Sample {
        let (mut value, mut slope) = (-self.threshold, 0.0);
        for passed in kernels {
            let [density, by_squared] = self.kernel.at(passed.squared(t));
            value += passed.strength * density;
            slope += passed.strength * by_squared * 2.0 * (t - passed.t) * passed.scale;
        }
        Sample { value, slope, error: 8.0 * f64::EPSILON * self.size }
    }

    fn enclose(&self, kernels: &[Passed], [low, high]: [f64; 2]) -> Enclosure {
        let slack = 8.0 * f64::EPSILON * self.size;
        let mut value = [-self.threshold - slack, -self.threshold + slack];
        let mut slope = [-1e-14 * self.steepness, 1e-14 * self.steepness];
        for passed in kernels {
            let near = passed.squared(passed.t.clamp(low, high));
            let far = passed.squared(low).max(passed.squared(high));
            let [[most, steepest], [least, flattest]] = [near, far].map(|squared| self.kernel.at(squared));
            let ends = [passed.strength * least, passed.strength * most];
            value[0] += ends[0].min(ends[1]);
            value[1] += ends[0].max(ends[1]);
            let mut out = [f64::INFINITY, f64::NEG_INFINITY];
            for by_squared in [steepest, flattest] {
                for t in [low, high] {
                    let product = passed.strength * by_squared * 2.0 * (t - passed.t) * passed.scale;
                    out = [out[0].min(product), out[1].max(product)];
                }
            }
            slope = [slope[0] + out[0], slope[1] + out[1]];
        }
        Enclosure { value, slope }
    }
}

impl Local for Blobs {
    fn crossed(&self, origin: Vec3, direction: Vec3, rounding: f64) -> SmallVec<[OnLine; 4]> {
        let shift = -origin.dot(direction);
        let start = origin + direction * shift;
        // The box, a little enlarged: at both ends the line is outside.
        let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
        for axis in 0..3 {
            let planes = [self.around.min[axis] - 1e-9, self.around.max[axis] + 1e-9];
            let [a, b] = planes.map(|plane| (plane - start[axis]) / direction[axis]);
            if direction[axis] != 0.0 {
                (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
            } else if start[axis] < planes[0] || start[axis] > planes[1] {
                return SmallVec::new();
            }
        }
        if !(enter < leave && leave < f64::INFINITY) {
            return SmallVec::new();
        }
        let mut edges: SmallVec<[f64; 8]> = SmallVec::new();
        let mut kernels: SmallVec<[Passed; 8]> = SmallVec::new();
        for Blob { centre, radius, strength } in &self.blobs {
            let away = *centre - start;
            let t = away.dot(direction);
            let scale = 1.0 / (radius * radius);
            let passed = Passed {
                t,
                off: (away - direction * t).length_squared() * scale,
                scale,
                strength: *strength,
            };
            if self.kernel == Kernel::Gaussian || passed.off < 1.0 {
                kernels.push(passed);
            }
        }
        // On either side of its centre a kernel's slope keeps its sign: bounds are closest where pieces don't
        // cross that.
        let mut cuts: SmallVec<[f64; 16]> = SmallVec::from_slice(&[enter, leave]);
        cuts.extend(kernels.iter().map(|passed| passed.t).filter(|&t| enter < t && t < leave));
        cuts.sort_by(f64::total_cmp);
        let noise = 8.0 * f64::EPSILON * self.size;
        let along = |t: f64| self.along(&kernels, t);
        for pair in cuts.windows(2) {
            edges.push(pair[0]);
            isolate([pair[0], pair[1]], noise, &along, &|part| self.enclose(&kernels, part), &mut edges);
        }
        edges.push(leave);
        let function = |t: f64| {
            let sample = self.along(&kernels, t);
            // On the surface is outside, at each place for all.
            if sample.value == 0.0 { Sample { value: -f64::MIN_POSITIVE, ..sample } } else { sample }
        };
        let height = 2.0 * rounding * self.steepness + 8.0 * f64::EPSILON * self.size;
        // The sharpest bend of the density, below 12 per squared radius.
        let bend = 12.0 * kernels.iter().map(|passed| passed.strength.abs() * passed.scale).sum::<f64>();
        let roots = sign_changes(&edges, function);
        let crossing = |(i, root): (usize, &crate::geometry::roots::Root)| {
            let slope = function(root.t).slope;
            let error = if slope * slope > 4.0 * bend * height { 2.0 * height / slope.abs() } else { 4.0 };
            let along = 4.0 * f64::EPSILON * (shift.abs() + root.t.abs());
            OnLine { t: shift + root.t, error: error + along, enters: i % 2 == 0, part: 0 }
        };
        roots.iter().enumerate().map(crossing).collect()
    }

    fn normal(&self, point: Vec3, _: u32) -> Vec3 {
        (-self.value(point).1).try_normalize().unwrap_or(Vec3::Z)
    }

    fn project(&self, mut point: Vec3, _: u32) -> Vec3 {
        // Newton's method along the gradient. What a hit is off by shrinks to its square each time.
        for _ in 0..3 {
            let (value, gradient) = self.value(point);
            let step = gradient * (value / gradient.length_squared());
            if !step.is_finite() || step.length_squared() > 1e-6 {
                break;
            }
            point -= step;
        }
        point
    }

    /// Seen from the mean of the centres: u around z, v from +z to -z, as on a sphere. The tangents are those
    /// of the directions, laid into the surface.
    fn parametrisation(&self, point: Vec3, part: u32) -> ([f64; 2], [Vec3; 2]) {
        let away = point - self.middle;
        let across = away.truncate().length();
        let u = (angle::atan2(away.y, away.x) / TAU).rem_euclid(1.0);
        let v = angle::atan2(across, away.z) / PI;
        let normal = self.normal(point, part);
        // Both stay on the surface by giving way along the line from the middle.
        let inverse = 1.0 / away.dot(normal);
        let on_surface = |vector: Vec3| {
            let along = vector - away * (vector.dot(normal) * inverse);
            if along.is_finite() { along } else { Vec3::ZERO }
        };
        let by_u = Vec3::new(-away.y, away.x, 0.0) * TAU;
        let by_v = (away.truncate() * (away.z / across)).extend(-across) * PI;
        ([u, v], [on_surface(by_u), on_surface(by_v)])
    }

    /// Farthest extent along a direction, from above to a millionth of the size.
    fn reach(&self, direction: Vec3) -> f64 {
        let corner = self.around.corners().map(|corner| corner.dot(direction)).fold(f64::MIN, f64::max);
        self.search(direction).unwrap_or(corner).min(corner)
    }

    /// Where the gradient vanishes that is a matter of the second order.
    fn rounding(&self, point: Vec3) -> f64 {
        let height = 16.0 * f64::EPSILON * self.size;
        (height / self.value(point).1.length()).min(height.sqrt())
    }

    fn is_closed(&self) -> bool {
        true
    }
}
