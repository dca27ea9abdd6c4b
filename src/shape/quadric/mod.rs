//! Quadrics: where a polynomial of the second degree vanishes, between planes, as open surfaces or as solids
//! with caps.
//!
//! Glassner, *An Introduction to Ray Tracing*, ch. 2, 5 and ch. 3, 3.1; with caps and bounds after ch. 7,
//! 2.1.

mod extent;
mod form;
mod kinds;

use super::crossing::Crossings;
use super::placement::Placement;
use super::random_lines::{self, Crossed, OnLine};
use super::{AreaSample, Parametrisation, ShapeError, SurfaceHit};
use crate::geometry::roots::{difference_of_products, quadratic};
use crate::geometry::{Bounds, Ray, SurfacePoint, Transform, Vec3, angle};
pub use form::QuadraticForm;
pub use kinds::{QuadricKind, Sheets};
use smallvec::SmallVec;
use std::f64::consts::TAU;

/// The curved surface. Part 1 + axis is the cap at the lower plane across an axis, 4 + axis that at the upper
/// one.
const CURVED: u32 = 0;

/// A quadric, cut off where it has no end, with or without caps.
#[derive(Clone, Debug)]
pub struct Quadric {
    /// Below zero inside.
    form: QuadraticForm,
    /// From coordinates in which the surface fits into [-1, 1]³.
    placement: Placement,
    /// The planes that cut the surface off; infinite where there are none.
    clip: Bounds,
    solid: bool,
    inward: bool,
    /// A box around the surface, the smallest or close to it.
    around: Bounds,
    /// v is 0 at the first and 1 at the second.
    heights: [f64; 2],
    /// Bound on the gradient near the surface.
    steepness: f64,
    /// Sum of the magnitudes of the form's terms near the surface.
    size: f64,
}

impl Quadric {
    /// `to_world` applied to the part of `form` = 0 within `clip`, whose planes may be infinitely far away.
    /// Where it is solid, the planes are closed by caps wherever `form` is negative. Normals point to where
    /// it is positive, unless `flip_normals`.
    pub fn new(
        to_world: &Transform,
        form: &QuadraticForm,
        clip: Bounds,
        solid: bool,
        flip_normals: bool,
    ) -> Result<Self, ShapeError> {
        let size = form.size(Vec3::ONE);
        if !(size.is_finite() && size > 0.0) {
            return Err(ShapeError::Coefficients);
        }
        let reach = extent::reach(form, clip, solid).ok_or(ShapeError::Endless)?;
        if (reach.max - reach.min).min_element() <= 0.0 {
            return Err(ShapeError::Nothing);
        }
        // Where the gradient vanishes coordinates have to be exact, unless that is somewhere else.
        let near = |centre: &Vec3| centre.distance(reach.centre()) <= 4.0 * reach.diameter();
        let origin = form.centre().filter(near).unwrap_or(reach.centre());
        let scale = (reach.min - origin).abs().max((reach.max - origin).abs()).max_element();
        let place = Transform::scale(scale).then(&Transform::translation(origin)).then(to_world);
        let placement = Placement::new(&place)?;
        let local = |bounds: Bounds| Bounds {
            min: (bounds.min - origin) / scale,
            max: (bounds.max - origin) / scale,
        };
        let (form, clip, reach) = (form.rescaled(origin, scale), local(clip), local(reach));
        let mut quadric = Self {
            steepness: 2.0 * (form.size(Vec3::ONE) - form.c.abs()) * 3f64.sqrt(),
            size: form.size(Vec3::splat(3f64.sqrt())),
            heights: [reach.min.z, reach.max.z],
            around: reach,
            form,
            placement,
            clip,
            solid,
            inward: flip_normals,
        };
        let toward = |direction| quadric.reach_toward(direction).ok_or(ShapeError::Nothing);
        let max = Vec3::new(toward(Vec3::X)?, toward(Vec3::Y)?, toward(Vec3::Z)?);
        let min = -Vec3::new(toward(-Vec3::X)?, toward(-Vec3::Y)?, toward(-Vec3::Z)?);
        quadric.around = Bounds { min: min.max(reach.min), max: max.min(reach.max) };
        Ok(quadric)
    }

    /// The largest direction · x in local coordinates.
    fn reach_toward(&self, direction: Vec3) -> Option<f64> {
        let planes = [self.clip.min.x, self.clip.min.y, self.clip.max.x, self.clip.max.y];
        let clipped_across = planes.iter().any(|plane| plane.is_finite());
        extent::reach_toward(&self.form, self.around, clipped_across, self.solid, direction)
    }

    /// Whether it encloses a volume: whether it has caps or needs none.
    pub fn is_closed(&self) -> bool {
        let cut = |axis: usize| self.clip.min[axis].is_finite() || self.clip.max[axis].is_finite();
        self.solid || !(0..3).any(cut)
    }

    /// Nearest distance with 0 ≤ t < `ray.t_max`, and the part that is met.
    pub fn intersect(&self, ray: &Ray) -> Option<(f64, u32)> {
        self.placement.nearest(ray, |origin, direction| self.crossed(origin, direction))
    }

    /// All crossings along the whole line.
    pub fn crossings(&self, ray: &Ray) -> Crossings {
        self.placement.crossings(ray, self.inward, |origin, direction| self.crossed(origin, direction))
    }

    /// See [`Shape::is_farther_than`](super::Shape::is_farther_than).
    pub fn is_farther_than(&self, ray: &Ray) -> bool {
        self.placement.ends_before(ray, |origin, way| {
            // Only short ways matter, on which rounding is that of the form at the origin.
            if way.length_squared() > 1.0 {
                return false;
            }
            let margin = self.placement.margin(origin);
            // The form grows with the square of coordinates, its gradient with them.
            let change = (self.steepness + self.size) * (1.0 + origin.abs().max_element()) * margin;
            let [c, b, a] = self.form.along(origin, way);
            let is_free = |plane: Vec3| {
                let free = (origin - plane).abs() - way.abs();
                !self.solid || free.min_element() > margin
            };
            c.abs() - b.abs() - a.abs() > change && is_free(self.clip.min) && is_free(self.clip.max)
        })
    }

    /// The point of a part nearest to `position` in local space, to first order.
    pub fn surface(&self, position: Vec3, part: u32) -> SurfaceHit {
        self.surface_at(self.project(self.placement.pose.local_point(position), part), part)
    }

    fn project(&self, mut local: Vec3, part: u32) -> Vec3 {
        if let Some((axis, plane)) = self.plane(part) {
            local[axis] = plane;
            return local;
        }
        // Newton's method along the gradient. What a hit is off by shrinks to its square each time.
        for _ in 0..3 {
            let gradient = self.form.gradient(local);
            let step = gradient * (self.form.value(local) / gradient.length_squared());
            if !step.is_finite() || step.length_squared() > 1e-6 {
                break;
            }
            local -= step;
        }
        local
    }

    fn surface_at(&self, local: Vec3, part: u32) -> SurfaceHit {
        let position = self.placement.pose.world_point(local);
        let outward = self.normal(local, part);
        let image = self.placement.pose.world_normal(outward);
        let stretch = image.length();
        let mut error = self.placement.error(position, outward, stretch);
        if part == CURVED {
            error += self.rounding(local) / stretch;
        }
        let normal = image / if self.inward { -stretch } else { stretch };
        SurfaceHit { point: SurfacePoint { position, normal, error }, shading_normal: normal }
    }

    /// How far off the surface the rounding of the form's value may place a point. Where the gradient
    /// vanishes that is a matter of the second order.
    fn rounding(&self, local: Vec3) -> f64 {
        let value = 8.0 * f64::EPSILON * self.form.size(local);
        let bend = self.form.size(Vec3::ONE) - self.form.c.abs();
        (value / self.form.gradient(local).length()).min((value / bend).sqrt())
    }

    /// Axis and place of a cap.
    fn plane(&self, part: u32) -> Option<(usize, f64)> {
        match part {
            1..=3 => Some((part as usize - 1, self.clip.min[part as usize - 1])),
            4..=6 => Some((part as usize - 4, self.clip.max[part as usize - 4])),
            _ => None,
        }
    }

    /// On the curved part u goes around the local z axis and v up along it; on caps both go across, from edge
    /// to edge.
    pub fn parametrisation(&self, position: Vec3, part: u32) -> Parametrisation {
        let local = self.placement.pose.local_point(position);
        let world = |vector: Vec3| self.placement.pose.world_vector(vector);
        if let Some((axis, _)) = self.plane(part) {
            let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
            let (from, size) = (self.around.min, self.around.max - self.around.min);
            return Parametrisation {
                uv: [(local[i] - from[i]) / size[i], (local[j] - from[j]) / size[j]],
                tangent: world(Vec3::AXES[i] * size[i]),
                bitangent: world(Vec3::AXES[j] * size[j]),
            };
        }
        let azimuth = angle::atan2(local.y, local.x);
        let azimuth = if azimuth < 0.0 { azimuth + TAU } else { azimuth };
        let [low, high] = self.heights;
        let gradient = self.form.gradient(local);
        // Both directions stay on the surface by giving way along the radius.
        let radius = local.with_z(0.0);
        let inverse = 1.0 / radius.dot(gradient);
        let on_surface = |vector: Vec3, length: f64| {
            let along = (vector - radius * (vector.dot(gradient) * inverse)) * length;
            if along.is_finite() { world(along) } else { Vec3::ZERO }
        };
        Parametrisation {
            uv: [azimuth / TAU, (local.z - low) / (high - low)],
            tangent: on_surface(Vec3::new(-local.y, local.x, 0.0), TAU),
            bitangent: on_surface(Vec3::Z, high - low),
        }
    }

    /// A box around it.
    pub fn bounds(&self) -> Bounds {
        let linear = self.placement.pose.linear;
        let (mut min, mut max) = (Vec3::ZERO, Vec3::ZERO);
        for axis in 0..3 {
            let row = linear.row(axis);
            let within = |direction: Vec3| {
                let corner = self.around.corners().map(|corner| corner.dot(direction));
                self.reach_toward(direction).unwrap_or(f64::INFINITY).min(corner.fold(f64::MIN, f64::max))
            };
            (min[axis], max[axis]) = (-within(-row), within(row));
        }
        Bounds { min: self.placement.pose.origin + min, max: self.placement.pose.origin + max }
    }

    /// Area, to a relative error of about 10⁻⁴.
    pub fn area(&self) -> f64 {
        random_lines::integral(self, |normal| self.placement.area_stretch(normal))
    }

    /// See `random_lines`: for some `u` there is no point.
    pub fn sample(&self, u: [f64; 2]) -> Option<AreaSample> {
        let (local, part) = random_lines::sample(self, u)?;
        let local = self.project(local, part);
        let density = self.local_area_density(local, self.normal(local, part));
        Some(AreaSample { triangle: part, ..AreaSample::analytic(self.surface_at(local, part), density) })
    }

    /// Density per area with which a sample is the point.
    pub fn area_density(&self, point: &SurfacePoint) -> f64 {
        let normal = self.placement.pose.local_normal(point.normal).normalize_or_zero();
        self.local_area_density(self.placement.pose.local_point(point.position), normal)
    }

    fn local_area_density(&self, local: Vec3, normal: Vec3) -> f64 {
        random_lines::density(self, local, normal) / self.placement.area_stretch(normal)
    }
}

/// Where a line passes a plane of the clip.
#[derive(Clone, Copy)]
struct Gate {
    t: f64,
    /// How fast the line goes through it.
    rate: f64,
    part: u32,
}

impl Quadric {
    /// Where a line passes into the clip and out of it again; `None` where it never does.
    fn gates(&self, start: Vec3, direction: Vec3) -> Option<[Gate; 2]> {
        let mut enter = Gate { t: f64::NEG_INFINITY, rate: 1.0, part: CURVED };
        let mut leave = Gate { t: f64::INFINITY, ..enter };
        for axis in 0..3 {
            let lower = (start[axis] - self.clip.min[axis], direction[axis], 1 + axis as u32);
            let upper = (self.clip.max[axis] - start[axis], -direction[axis], 4 + axis as u32);
            for (depth, rate, part) in [lower, upper] {
                if depth.is_infinite() {
                    continue;
                }
                let gate = Gate { t: -depth / rate, rate: rate.abs(), part };
                if rate == 0.0 {
                    // Within the plane of a cap, a line misses.
                    if depth < 0.0 || (depth == 0.0 && self.solid) {
                        return None;
                    }
                } else if rate > 0.0 && gate.t > enter.t {
                    enter = gate;
                } else if rate < 0.0 && gate.t < leave.t {
                    leave = gate;
                }
            }
        }
        (enter.t < leave.t).then_some([enter, leave])
    }
}

impl Crossed for Quadric {
    fn around(&self) -> Bounds {
        self.around
    }

    fn normal(&self, point: Vec3, part: u32) -> Vec3 {
        match self.plane(part) {
            Some((axis, _)) if part < 4 => -Vec3::AXES[axis],
            Some((axis, _)) => Vec3::AXES[axis],
            None => self.form.gradient(point).try_normalize().unwrap_or(Vec3::Z),
        }
    }

    /// The line is followed from its point nearest to the local origin, where coordinates are as small as the
    /// surface's and no distance to it costs digits. There rounding changes the form's values by no more than
    /// `change`, and its roots by
    /// |√D − √(D ± |a|·change)| / |a| ≤ change / √D, and ≤ √(change / |a|).
    fn crossed(&self, origin: Vec3, direction: Vec3) -> SmallVec<[OnLine; 4]> {
        let mut found = SmallVec::new();
        let shift = -origin.dot(direction);
        let start = origin + direction * shift;
        // Local coordinates don't exceed 1.
        if start.length_squared().is_nan() || start.length_squared() > 3.0 + 1e-9 {
            return found;
        }
        let Some([enter, leave]) = self.gates(start, direction) else { return found };
        let [c, b, a] = self.form.along(start, direction);
        let roots = quadratic(a, b, c);
        let coordinate = self.placement.coordinate_error(1.0 + origin.abs().max_element());
        let change = self.steepness * coordinate + 8.0 * f64::EPSILON * self.size;
        let discriminant = difference_of_products(0.5 * b, 0.5 * b, a, c);
        let slack = (change / discriminant.sqrt()).min((change / a.abs()).sqrt());
        let rounding = |t: f64| 4.0 * f64::EPSILON * (shift.abs() + t.abs());
        let curved =
            |t: f64, enters: bool| OnLine { t: shift + t, error: slack + rounding(t), enters, part: CURVED };
        let cap = |gate: Gate, enters: bool| OnLine {
            t: shift + gate.t,
            error: coordinate / gate.rate + rounding(gate.t),
            enters,
            part: gate.part,
        };
        let enters = |t: f64| a * t + 0.5 * b < 0.0;
        if !self.solid {
            let within = roots.iter().filter(|root| enter.t <= root.t && root.t <= leave.t);
            found.extend(within.map(|root| curved(root.t, enters(root.t))));
            return found;
        }
        // Stretches within the quadric, cut to what is between the planes.
        let mut add = |from: f64, to: f64| {
            let begin = if from < enter.t { (enter.t, cap(enter, true)) } else { (from, curved(from, true)) };
            let end = if to > leave.t { (leave.t, cap(leave, false)) } else { (to, curved(to, false)) };
            if begin.0 < end.0 && begin.0.is_finite() && end.0.is_finite() {
                found.extend([begin.1, end.1]);
            }
        };
        let outside_first = match roots.first() {
            Some(first) => enters(first.t),
            None => c > 0.0 || (c == 0.0 && a > 0.0),
        };
        let mut from = if outside_first { None } else { Some(f64::NEG_INFINITY) };
        for root in &roots {
            match from.take() {
                None => from = Some(root.t),
                Some(begin) => add(begin, root.t),
            }
        }
        if let Some(begin) = from {
            add(begin, f64::INFINITY);
        }
        found
    }
}
