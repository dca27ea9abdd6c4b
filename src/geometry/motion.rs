//! Bodies that stand or move.

use super::{Bounds, Pose, SurfacePoint, Transform, Vec3};
use glam::{DMat3, DQuat};
use std::f64::consts::PI;
use std::fmt;

/// A way through keyframes. Between two of them position and stretch change linearly and the rotation
/// steadily about one axis, the shorter way round; before the first and after the last the body stands still.
///
/// A key's linear part is taken apart into rotation and stretch by polar decomposition (Shoemake and Duff,
/// "Matrix animation and polar decomposition", Graphics Interface 1992).
#[derive(Clone, Debug)]
pub struct Motion {
    /// Intervals between keyframes: at least one, in the order of time.
    intervals: Vec<KeyframeInterval>,
    /// What is done to local coordinates first, if anything.
    before: Option<DMat3>,
    /// What local coordinates are then relative to, in those of the keys.
    pivot: Vec3,
}

/// The motion between two neighbouring keyframes.
#[derive(Clone, Debug)]
struct KeyframeInterval {
    start: f64,
    /// 1 / duration; 0 for a body that stands still.
    rate: f64,
    position: Vec3,
    way: Vec3,
    rotation: DQuat,
    axis: Vec3,
    /// Angle of the turn, radians in [0, π].
    angle: f64,
    scale: DMat3,
    growth: DMat3,
}

/// Why keyframes make no motion. Keys are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionError {
    /// There is no placement at all.
    NoKeys,
    /// The time of a key is not after that of the one before, or not finite.
    Order(usize),
    /// A body would turn inside out on its way to this key.
    Mirrors(usize),
}

impl fmt::Display for MotionError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::NoKeys => write!(f, "there is no keyframe"),
            Self::Order(key) => write!(f, "keyframe {} is not after the one before it", key + 1),
            Self::Mirrors(key) => write!(f, "keyframe {} is a mirror image of the one before it", key + 1),
        }
    }
}

/// A map taken apart: `to_world` = translation · rotation · scale.
struct Parts {
    position: Vec3,
    rotation: DQuat,
    scale: DMat3,
}

impl Parts {
    fn of(to_world: &Transform) -> Self {
        let Pose { origin, linear, .. } = Pose::new(to_world);
        // Newton's iteration for the nearest orthogonal matrix converges quadratically, at first by halving.
        let mut rotation = linear;
        for _ in 0..100 {
            let next = (rotation + rotation.inverse().transpose()) * 0.5;
            let done = next.abs_diff_eq(rotation, 1e-15);
            rotation = next;
            if done {
                break;
            }
        }
        if rotation.determinant() < 0.0 {
            rotation = -rotation;
        }
        let rotation = DQuat::from_mat3(&rotation).normalize();
        let scale = DMat3::from_quat(rotation).transpose() * linear;
        Self { position: origin, rotation, scale }
    }
}

impl Motion {
    /// Keys are times and what the body's `to_world` is then.
    ///
    /// # Errors
    /// See [`MotionError`].
    pub fn new(keys: &[(f64, Transform)]) -> Result<Self, MotionError> {
        let mut intervals = Vec::new();
        let (start, first) = keys.first().ok_or(MotionError::NoKeys)?;
        if !start.is_finite() {
            return Err(MotionError::Order(0));
        }
        let mut last = (*start, Parts::of(first));
        for (index, (time, to_world)) in keys.iter().enumerate().skip(1) {
            if !(*time > last.0 && time.is_finite()) {
                return Err(MotionError::Order(index));
            }
            let next = Parts::of(to_world);
            if (next.scale.determinant() < 0.0) != (last.1.scale.determinant() < 0.0) {
                return Err(MotionError::Mirrors(index));
            }
            intervals.push(KeyframeInterval::between(&last.1, &next, last.0, 1.0 / (time - last.0)));
            last = (*time, next);
        }
        if intervals.is_empty() {
            intervals.push(KeyframeInterval::between(&last.1, &last.1, last.0, 0.0));
        }
        Ok(Self { intervals, before: None, pivot: Vec3::ZERO })
    }

    /// The same motion of a body whose coordinates `to_keys` takes to those that it had. The way between two
    /// keys stays the same, which a motion by keys that hold `to_keys` would not have.
    #[must_use]
    pub fn carrying(mut self, to_keys: &Transform) -> Self {
        if *to_keys == Transform::IDENTITY {
            return self;
        }
        let Pose { origin, linear, .. } = Pose::new(to_keys);
        self.pivot += self.done_before(origin);
        self.before = Some(self.before.map_or(linear, |before| before * linear));
        self
    }

    fn done_before(&self, local: Vec3) -> Vec3 {
        self.before.map_or(local, |before| before * local)
    }

    /// The same motion of a body whose coordinates are relative to `pivot`, in a world that is moved by
    /// `shift`.
    #[must_use]
    pub fn recentred(mut self, pivot: Vec3, shift: Vec3) -> Self {
        self.pivot += self.done_before(pivot);
        self.intervals.iter_mut().for_each(|interval| interval.position += shift);
        self
    }

    /// Where the body stands.
    pub fn at(&self, time: f64) -> Pose {
        let after = self.intervals.partition_point(|interval| interval.start <= time);
        let interval = &self.intervals[after.saturating_sub(1)];
        self.pose(interval, ((time - interval.start) * interval.rate).clamp(0.0, 1.0))
    }

    /// A box around all of a body that fills a box in its own coordinates, from one time to another.
    pub fn bounds(&self, body: Bounds, during: [f64; 2]) -> Bounds {
        if body.is_empty() {
            return body;
        }
        let last = self.intervals.len() - 1;
        let parts = self.intervals.iter().enumerate().filter_map(|(index, interval)| {
            let fraction = |time: f64| ((time - interval.start) * interval.rate).clamp(0.0, 1.0);
            let from = if index == 0 { f64::NEG_INFINITY } else { interval.start };
            let end = if index == last { f64::INFINITY } else { self.intervals[index + 1].start };
            let overlaps = during[0] <= end && during[1] >= from;
            overlaps.then(|| self.bounds_within(interval, body, [fraction(during[0]), fraction(during[1])]))
        });
        Bounds::of_all(parts)
    }

    /// The pose at a fraction of an interval.
    fn pose(&self, interval: &KeyframeInterval, fraction: f64) -> Pose {
        let pose = interval.at(fraction, self.pivot);
        let Some(before) = self.before else { return pose };
        let linear = pose.linear * before;
        Pose { linear, inverse: linear.inverse(), ..pose }
    }

    /// Without rotation each point moves on a straight line. With it, a point strays from the chord of a
    /// piece of h of the way by at most h²/8 times its greatest acceleration, θ²|S c| + 2θ|S' c|.
    fn bounds_within(&self, interval: &KeyframeInterval, body: Bounds, [from, to]: [f64; 2]) -> Bounds {
        let KeyframeInterval { scale, growth, angle, .. } = *interval;
        let pieces = ((to - from) * angle / (PI / 32.0)).ceil().max(1.0) as usize;
        let piece = (to - from) / pieces as f64;
        let stray = |corner: Vec3| {
            let corner = self.done_before(corner) + self.pivot;
            let reach = (scale * corner).length().max(((scale + growth) * corner).length());
            let acceleration = angle * (angle * reach + 2.0 * (growth * corner).length());
            Vec3::splat(piece * piece / 8.0 * acceleration)
        };
        let poses: Vec<Pose> = (0..=pieces).map(|i| self.pose(interval, from + piece * i as f64)).collect();
        Bounds::of_all(body.corners().map(|corner| {
            let path = Bounds::of(poses.iter().map(|pose| pose.world_point(corner)));
            Bounds { min: path.min - stray(corner), max: path.max + stray(corner) }
        }))
    }

    /// The linear parts of the map at both ends of an interval, but for the rotation.
    fn stretches(&self, interval: &KeyframeInterval) -> [DMat3; 2] {
        let ends = [interval.scale, interval.scale + interval.growth];
        self.before.map_or(ends, |before| ends.map(|end| end * before))
    }

    /// See [`Pose::spread`]: a bound on it at any time.
    ///
    /// An element of |L| is at most the largest stretch σ, one of |L⁻¹| at most 1 over the smallest; three of
    /// them add up in each of the products. The largest stretch between two keys is not above the larger of
    /// theirs. The smallest is not below the smaller of theirs where their stretches are symmetric, or
    /// multiples of one another. Where something is done before, it is not below the product of its smallest
    /// and theirs.
    fn spread(&self) -> DMat3 {
        let least =
            |ends: [DMat3; 2]| ends.map(|end| frobenius(end.inverse())).into_iter().fold(0.0, f64::max);
        let (mut stretch, mut squeeze) = (0.0_f64, 0.0_f64);
        for interval in &self.intervals {
            let ends = self.stretches(interval);
            stretch = ends.map(frobenius).into_iter().fold(stretch, f64::max);
            squeeze = squeeze.max(match self.before {
                Some(before) if !interval.grows_alike() => {
                    frobenius(before.inverse()) * least([interval.scale, interval.scale + interval.growth])
                }
                _ => least(ends),
            });
        }
        let element = 27.0 * (stretch * squeeze).powi(2);
        DMat3::from_cols_array(&[element; 9])
    }
}

/// The root of the sum of the squares of all elements: at least the largest stretch.
fn frobenius(m: DMat3) -> f64 {
    m.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt()
}

impl KeyframeInterval {
    fn between(from: &Parts, to: &Parts, start: f64, rate: f64) -> Self {
        let turn = from.rotation.inverse() * to.rotation;
        // A quaternion and its negative are the same rotation; one of them is the shorter way.
        let (axis, angle) = if turn.w < 0.0 { -turn } else { turn }.normalize().to_axis_angle();
        Self {
            start,
            rate,
            position: from.position,
            way: to.position - from.position,
            rotation: from.rotation,
            axis,
            angle,
            scale: from.scale,
            growth: to.scale - from.scale,
        }
    }

    /// The pose at a fraction of the way.
    fn at(&self, fraction: f64, pivot: Vec3) -> Pose {
        let turn = match self.angle {
            0.0 => self.rotation,
            angle => self.rotation * DQuat::from_axis_angle(self.axis, fraction * angle),
        };
        let linear = DMat3::from_quat(turn) * (self.scale + self.growth * fraction);
        let origin = self.position + self.way * fraction + linear * pivot;
        Pose { origin, linear, inverse: linear.inverse() }
    }

    /// Whether the stretches of both keys are multiples of one another, as far as that makes a difference.
    fn grows_alike(&self) -> bool {
        let factor = frobenius(self.scale + self.growth) / frobenius(self.scale);
        let off = self.scale + self.growth - self.scale * factor;
        frobenius(off) * frobenius(self.scale.inverse()) < 1e-3 * factor
    }
}

/// Where a body stands over time, and how exactly rays can be taken to it.
#[derive(Clone, Debug)]
pub struct Placed {
    place: PoseOverTime,
    /// Times local coordinates it bounds their rounding errors in units of 2⁻⁵³, like the bound of an
    /// analytic shape.
    local_errors: DMat3,
}

/// A pose that is fixed or moves.
#[derive(Clone, Debug)]
enum PoseOverTime {
    Still(Pose),
    Moving(Box<Motion>),
}

impl Placed {
    /// `None` where the map is so ill-conditioned that local coordinates mean little.
    pub fn still(to_world: &Transform) -> Option<Self> {
        let pose = Pose::new(to_world);
        let regular = pose.inverse.is_finite() && pose.origin.is_finite();
        if regular { Self::with_spread(PoseOverTime::Still(pose), pose.spread()) } else { None }
    }

    /// The same for a body in motion, at any time.
    pub fn moving(motion: Motion) -> Option<Self> {
        let spread = motion.spread();
        Self::with_spread(PoseOverTime::Moving(Box::new(motion)), spread)
    }

    fn with_spread(place: PoseOverTime, spread: DMat3) -> Option<Self> {
        let largest = (spread * Vec3::ONE).max_element();
        (largest < 1e12).then(|| Self { place, local_errors: spread * 16.0 })
    }

    /// By how much lengths are stretched at most: a bound, at any time.
    pub fn largest_stretch(&self) -> f64 {
        match &self.place {
            PoseOverTime::Still(pose) => frobenius(pose.linear),
            PoseOverTime::Moving(motion) => {
                let ends = motion.intervals.iter().flat_map(|interval| motion.stretches(interval));
                ends.map(frobenius).fold(0.0, f64::max)
            }
        }
    }

    /// Whether its pose changes over time.
    pub fn is_moving(&self) -> bool {
        matches!(self.place, PoseOverTime::Moving(_))
    }

    /// The pose at a time; that of the nearest keyframe before the first and after the last.
    pub fn at(&self, time: f64) -> Pose {
        match &self.place {
            PoseOverTime::Still(pose) => *pose,
            PoseOverTime::Moving(motion) => motion.at(time),
        }
    }

    /// A box around all of a body that fills a box in its own coordinates, from one time to another.
    pub fn bounds(&self, body: Bounds, during: [f64; 2]) -> Bounds {
        match &self.place {
            PoseOverTime::Still(pose) => Bounds::of(body.corners().map(|corner| pose.world_point(corner))),
            PoseOverTime::Moving(motion) => motion.bounds(body, during),
        }
    }

    /// A surface point of the body, where it stands at the time of `pose`, in the world. See
    /// [`Pose::surface_point`].
    pub fn surface_point(&self, pose: &Pose, local: &SurfacePoint, reach: f64) -> SurfacePoint {
        pose.surface_point(local, &self.local_errors, reach)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat4;

    fn transform(matrix: DMat4) -> Transform {
        Transform::new(matrix).unwrap()
    }

    fn turned(degrees: f64, scale: Vec3, position: Vec3) -> Transform {
        transform(DMat4::from_scale_rotation_translation(
            scale,
            DQuat::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), degrees.to_radians()),
            position,
        ))
    }

    #[test]
    fn keys_are_met_and_between_them_everything_changes_steadily() {
        let scale = Vec3::new(1.0, 2.0, -0.5);
        let (a, b) = (turned(10.0, scale, Vec3::X), turned(130.0, 3.0 * scale, Vec3::new(1.0, 4.0, 0.0)));
        let motion = Motion::new(&[(1.0, a), (3.0, b)]).unwrap().recentred(Vec3::Y, Vec3::Z);
        let point = Vec3::new(0.3, -0.7, 2.0);
        for (time, expected) in [
            (-5.0, a),
            (1.0, a),
            (1.5, turned(40.0, 1.5 * scale, Vec3::new(1.0, 1.0, 0.0))),
            (3.0, b),
            (9.0, b),
        ] {
            let pose = motion.at(time);
            let world = expected.point(point + Vec3::Y) + Vec3::Z;
            assert!((pose.world_point(point) - world).length() < 1e-13, "{time}");
            assert!((pose.local_point(world) - point).length() < 1e-12, "{time}");
        }
    }

    /// What is done first leaves the way between keys as it is, and is bounded with it.
    #[test]
    fn what_is_done_before_is_carried_along() {
        let scale = Vec3::new(1.0, 2.0, -0.5);
        let keys = [
            (0.0, turned(10.0, scale, Vec3::X)),
            (1.0, turned(130.0, Vec3::new(3.0, 1.0, -2.0), Vec3::new(1.0, 4.0, 0.0))),
        ];
        let before = turned(70.0, Vec3::new(2.0, 0.5, -1.0), Vec3::new(0.3, 0.1, -7.0));
        let (plain, middle, shift) = (Motion::new(&keys).unwrap(), Vec3::new(5.0, 1.0, 2.0), Vec3::Z);
        let motion = plain.clone().carrying(&before).recentred(middle, shift);
        let body = Bounds { min: Vec3::new(-1.0, -0.5, 0.0), max: Vec3::new(2.0, 0.5, 0.1) };
        let (bounds, placed) = (motion.bounds(body, [0.2, 0.9]), Placed::moving(motion.clone()).unwrap());
        let largest = placed.largest_stretch();
        for time in (0..=70).map(|i| 0.2 + 0.01 * f64::from(i)) {
            let (pose, expected) = (motion.at(time), plain.at(time));
            for corner in body.corners() {
                let world = expected.world_point(before.point(corner + middle)) + shift;
                assert!((pose.world_point(corner) - world).length() < 1e-12, "{time}");
                assert!((pose.local_point(world) - corner).length() < 1e-11, "{time}");
                assert!((world.clamp(bounds.min - 1e-12, bounds.max + 1e-12) - world).length() == 0.0);
            }
            assert!(Vec3::AXES.iter().all(|&axis| pose.world_vector(axis).length() <= largest));
            let spread = pose.spread();
            let bound = motion.spread().x_axis.x;
            assert!(spread.to_cols_array().iter().all(|&element| element <= bound), "{spread} over {bound}");
        }
        // Undone, it leaves no more than rounding, however far it stretched.
        let far = turned(33.0, Vec3::new(1e-5, 1.0, 1e5), Vec3::splat(1e6));
        let motion = Motion::new(&[(0.0, far), (1.0, far)]).unwrap();
        let linear = transform(DMat4::from_mat3(motion.at(0.0).linear));
        let motion = motion.carrying(&linear.inverse());
        assert!((motion.at(0.5).linear - DMat3::IDENTITY).to_cols_array().iter().all(|x| x.abs() < 1e-5));
        assert!(motion.spread().x_axis.x < 300.0, "{}", motion.spread());
    }

    #[test]
    fn the_shorter_way_round_is_taken() {
        let motion = Motion::new(&[
            (0.0, turned(170.0, Vec3::ONE, Vec3::ZERO)),
            (1.0, turned(-170.0, Vec3::ONE, Vec3::ZERO)),
        ]);
        let middle = turned(180.0, Vec3::ONE, Vec3::ZERO).vector(Vec3::Y);
        assert!((motion.unwrap().at(0.5).world_vector(Vec3::Y) - middle).length() < 1e-13);
    }

    #[test]
    fn what_is_no_motion_is_refused() {
        let (unit, mirror) = (Transform::IDENTITY, transform(DMat4::from_scale(Vec3::new(1.0, 1.0, -1.0))));
        assert_eq!(Motion::new(&[]).unwrap_err(), MotionError::NoKeys);
        assert_eq!(Motion::new(&[(1.0, unit), (1.0, unit)]).unwrap_err(), MotionError::Order(1));
        assert_eq!(Motion::new(&[(f64::NAN, unit)]).unwrap_err(), MotionError::Order(0));
        assert_eq!(Motion::new(&[(0.0, unit), (1.0, mirror)]).unwrap_err(), MotionError::Mirrors(1));
        assert!(Motion::new(&[(0.0, mirror), (1.0, mirror)]).is_ok());
    }

    /// Boxes over a part of the time hold every moment of it, and hardly more than that.
    #[test]
    fn bounds_hold_rotating_bodies_and_are_tight() {
        let keys = [
            (0.0, turned(0.0, Vec3::ONE, Vec3::ZERO)),
            (1.0, turned(170.0, Vec3::new(1.0, 2.0, 1.0), Vec3::new(3.0, 0.0, 0.0))),
            (2.0, turned(300.0, Vec3::ONE, Vec3::new(3.0, 9.0, 0.0))),
        ];
        let motion = Motion::new(&keys).unwrap().recentred(Vec3::new(0.5, 0.0, 1.0), Vec3::ZERO);
        let body = Bounds { min: Vec3::new(-1.0, -0.5, 0.0), max: Vec3::new(2.0, 0.5, 0.1) };
        for during in [[0.0, 2.0], [0.3, 0.31], [0.9, 1.2], [-3.0, 0.1], [1.9, 7.0], [5.0, 6.0]] {
            let bounds = motion.bounds(body, during);
            let mut seen = Bounds::EMPTY;
            for i in 0..=2000 {
                let pose = motion.at(during[0] + (during[1] - during[0]) * f64::from(i) / 2000.0);
                seen = seen.union(Bounds::of(body.corners().map(|corner| pose.world_point(corner))));
            }
            assert!(bounds.min.cmple(seen.min + 1e-12).all() && bounds.max.cmpge(seen.max - 1e-12).all());
            let excess = (bounds.max - bounds.min) - (seen.max - seen.min);
            assert!(excess.max_element() < 0.02 * (seen.max - seen.min).max_element(), "{during:?} {excess}");
        }
    }

    #[test]
    fn the_ratio_of_solid_angles_integrates_to_the_sphere() {
        let pose = Pose::new(&turned(33.0, Vec3::new(1.0, 3.0, 0.4), Vec3::X));
        // Equal areas: z and longitude on a midpoint grid.
        let n = 400;
        let mut sum = 0.0;
        for i in 0..n {
            for j in 0..n {
                let z = -1.0 + 2.0 * (f64::from(i) + 0.5) / f64::from(n);
                let (sin, cos) = (2.0 * PI * (f64::from(j) + 0.5) / f64::from(n)).sin_cos();
                let r = (1.0 - z * z).sqrt();
                sum += pose.solid_angle_ratio(Vec3::new(r * cos, r * sin, z));
            }
        }
        assert!((sum / f64::from(n * n) - 1.0).abs() < 1e-4, "{sum}");
    }
}
