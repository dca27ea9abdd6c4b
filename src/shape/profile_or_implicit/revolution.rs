//! Surfaces of revolution: a profile of straight or curved pieces turned around z.
//!
//! The plane along z that a line lies in cuts the surface in the curve (±√(r² − h²), z), h being the line's
//! distance from the axis. Which side of the line a point of this curve is on has no cancellation, whatever
//! the line's slope. The product of both branches is the polynomial a u² + b v² + c v + d of Glassner, *An
//! Introduction to Ray Tracing*, ch. 3, 3.3 (its coefficients corrected), of degree 6 for cubics. Each branch
//! is followed by itself: its roots are isolated by bounds on its values and slopes, and at the joints, where
//! neighbours have to agree, its sign is that of the joint alone.

use super::profile::{self, Interpolation, Piece};
use super::{Local, power_above};
use crate::geometry::roots::{Enclosure, Sample, isolate, sign_changes};
use crate::geometry::{Vec3, angle};
use crate::shape::ShapeError;
use crate::shape::random_lines::OnLine;
use glam::DVec2;
use smallvec::SmallVec;
use std::f64::consts::TAU;

#[derive(Clone, Debug)]
pub(super) struct Revolution {
    /// The caps come last. Part 2 i + 1 is piece i with the outside to the left of it, 2 i the same to the
    /// right.
    pieces: Vec<Piece>,
    closed: bool,
    /// Whether an open surface has its outside to the left of the profile.
    outside_left: bool,
}

/// A line seen in the plane along z that it lies in, with x along its horizontal direction.
struct InPlane {
    start: DVec2,
    direction: DVec2,
    /// Distance of the plane from the axis.
    off: f64,
    /// Bound on the errors of coordinates, those of the line included.
    height: f64,
}

/// What rounding adds to the side of a line that is taken as given. Two crossings are looked for until they
/// are as near to one as that; what the line itself is off by says only how sure they are.
const NOISE: f64 = 16.0 * f64::EPSILON;

impl InPlane {
    /// Half of the chord that the plane cuts from a circle around the axis.
    fn half_chord(&self, radius: f64) -> f64 {
        ((radius - self.off) * (radius + self.off)).max(0.0).sqrt()
    }

    /// Positive to one side of the line, and on it.
    fn side(&self, x: f64, z: f64) -> f64 {
        let side = self.direction.x * (z - self.start.y) - self.direction.y * (x - self.start.x);
        if side == 0.0 { f64::MIN_POSITIVE } else { side }
    }

    /// The same along one branch of a piece, x being `branch` times the half chord, with its slope.
    fn function(&self, piece: &Piece, branch: f64, s: f64) -> Sample {
        let (at, slope) = (piece.at(s), piece.slope(s));
        let half = self.half_chord(at.x);
        let by_radius = if half > 0.0 { at.x / half } else { f64::INFINITY };
        let slope = self.direction.x * slope.y - self.direction.y * branch * slope.x * by_radius;
        Sample { value: self.side(branch * half, at.y), slope, error: NOISE }
    }

    /// Over a part of a piece, where all of r, z and their derivatives only rise or only fall.
    fn enclose(&self, piece: &Piece, branch: f64, [low, high]: [f64; 2]) -> Enclosure {
        let ends = [low, high].map(|s| (piece.at(s), piece.slope(s)));
        let halves = ends.map(|(at, _)| self.half_chord(at.x));
        // Both parts of the value are monotonic.
        let by_z = ends.map(|(at, _)| self.direction.x * (at.y - self.start.y));
        let by_x = halves.map(|half| -self.direction.y * (branch * half - self.start.x));
        let least = |[a, b]: [f64; 2]| a.min(b);
        let most = |[a, b]: [f64; 2]| a.max(b);
        let slack = 4.0 * f64::EPSILON;
        let value = [least(by_z) + least(by_x) - slack, most(by_z) + most(by_x) + slack];
        let up = ends.map(|(_, slope)| self.direction.x * slope.y);
        // |r′| r/√(r² − h²), whose second factor falls with r.
        let factor = |i: usize| if halves[i] > 0.0 { ends[i].0.x / halves[i] } else { f64::INFINITY };
        let (inner, outer) = if ends[0].0.x < ends[1].0.x { (0, 1) } else { (1, 0) };
        let speeds = ends.map(|(_, slope)| slope.x.abs());
        let product = |a: f64, b: f64| if a == 0.0 { 0.0 } else { a * b };
        let change = [product(least(speeds), factor(outer)), product(most(speeds), factor(inner))];
        let rising = ends[1].0.x >= ends[0].0.x;
        let scale = -self.direction.y * branch * if rising { 1.0 } else { -1.0 };
        let out = change.map(|change| product(scale, change));
        let slack = 1e-14 * (most(up.map(f64::abs)) + least(change));
        Enclosure { value, slope: [least(up) + least(out) - slack, most(up) + most(out) + slack] }
    }
}

/// A crossing in the plane.
#[derive(Clone, Copy)]
struct Met {
    t: f64,
    error: f64,
    piece: u32,
    /// Whether the line goes from left to right through the profile, as seen in its own half-plane.
    rightwards: bool,
}

impl Revolution {
    /// With the length of its unit, a power of two as for polygons.
    pub fn new(
        points: &[[f64; 2]],
        interpolation: Interpolation,
        closed: bool,
        capped: bool,
    ) -> Result<(Self, f64), ShapeError> {
        let mut pieces = profile::pieces(points, interpolation, closed)?;
        let most =
            |piece: &Piece| piece.ends.map(|end| end.abs().max_element()).into_iter().fold(0.0, f64::max);
        let scale = power_above(pieces.iter().map(most).fold(0.0, f64::max));
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(ShapeError::Profile);
        }
        profile::scaled(&mut pieces, 1.0 / scale);
        let first = pieces[0].ends[0];
        let last = pieces[pieces.len() - 1].ends[1];
        let around = first == last;
        let open_ends = [first, last].map(|end| end.x > 0.0);
        let closed = around || capped || open_ends == [false; 2];
        // Twice the area between the profile and the axis, positive where the profile goes up.
        let area: f64 = pieces.iter().map(area).sum();
        if capped && !around {
            for (end, open) in [first, last].into_iter().zip(open_ends) {
                let on_axis = DVec2::new(0.0, end.y);
                if open {
                    let (from, to) = if end == first { (on_axis, end) } else { (end, on_axis) };
                    pieces.push(profile::cap(from, to));
                }
            }
        }
        Ok((Self { pieces, closed, outside_left: area < 0.0 }, scale))
    }

    fn piece(&self, part: u32) -> &Piece {
        &self.pieces[(part / 2) as usize]
    }

    /// Outwards at a point of a piece: along r, and along z.
    fn outward(&self, s: f64, part: u32) -> DVec2 {
        let left = self.piece(part).tangent(s).perp();
        if part % 2 == 1 { left } else { -left }
    }

    fn meet(&self, plane: &InPlane, index: usize, found: &mut SmallVec<[Met; 8]>) {
        let piece = &self.pieces[index];
        let [from, to] = piece.ends;
        // One that only touches the plane has both branches on the same side of the line.
        if from.x.max(to.x) <= plane.off {
            return;
        }
        let mut range = piece.range;
        let mut halves = piece.ends.map(|end| plane.half_chord(end.x));
        let mut heights = piece.ends.map(|end| end.y);
        for i in 0..2 {
            if piece.ends[i].x < plane.off {
                range[i] = piece.at_radius(plane.off);
                halves[i] = 0.0;
                heights[i] = piece.at(range[i]).y;
            }
        }
        for branch in [1.0, -1.0] {
            let sides = [0, 1].map(|i| plane.side(branch * halves[i], heights[i]));
            let up = plane.direction.x * (to.y - from.y);
            let out = -plane.direction.y * branch * (to.x - from.x);
            let differ = sides[0].signum() != sides[1].signum();
            let monotonic = up * out >= 0.0;
            if monotonic && !differ {
                continue;
            }
            let mut edges: SmallVec<[f64; 8]> = SmallVec::from_slice(&[range[0]]);
            if !monotonic {
                let along = |s: f64| plane.function(piece, branch, s);
                isolate(range, NOISE, &along, &|part| plane.enclose(piece, branch, part), &mut edges);
            }
            edges.push(range[1]);
            if edges.len() == 2 && !differ {
                continue;
            }
            // At the ends the sign is that of the joint, or of where both branches meet.
            let function = |s: f64| {
                let end = range.iter().position(|&end| end == s);
                let sample = plane.function(piece, branch, s);
                end.map_or(sample, |end| Sample { value: sides[end], ..sample })
            };
            for root in sign_changes(&edges, function) {
                found.push(self.met(plane, index, branch, root.t));
            }
        }
    }

    /// The better known of the two coordinates says how far along the line it is.
    fn met(&self, plane: &InPlane, index: usize, branch: f64, s: f64) -> Met {
        let piece = &self.pieces[index];
        let (at, slope) = (piece.at(s), piece.slope(s));
        let half = plane.half_chord(at.x);
        let InPlane { start, direction, height, .. } = *plane;
        let along_z = direction.x * slope.y * half;
        let along_r = direction.y * branch * slope.x * at.x;
        // The error of s, with numerator and denominator times the half chord.
        let of_s = (height * half + direction.y.abs() * at.x * height) / (along_z - along_r).abs();
        let of_z = (slope.y.abs() * of_s + height) / direction.y.abs();
        let of_radius = slope.x.abs() * of_s + height;
        let of_half = (at.x * of_radius / half).min((2.0 * of_radius * (at.x + of_radius)).sqrt());
        let of_x = (of_half + height) / direction.x.abs();
        let (t, error) = if of_z < of_x {
            ((at.y - start.y) / direction.y, of_z)
        } else {
            ((branch * half - start.x) / direction.x, of_x)
        };
        // How fast the line leaves the surface, whose sharper bend at a touching point is that along or
        // around it.
        let tangent = piece.tangent(s);
        let across = direction.x * branch * half / at.x.max(f64::MIN_POSITIVE);
        let rate = tangent.perp_dot(DVec2::new(across, direction.y));
        let bend = slope.perp_dot(piece.bend(s)).abs() / slope.length().powi(3) + tangent.y.abs() / at.x;
        let error = if rate * rate > 16.0 * bend * height { 2.0 * error } else { 4.0 };
        Met {
            t,
            error: if error.is_finite() { error } else { 4.0 },
            piece: index as u32,
            rightwards: rate < 0.0,
        }
    }
}

/// ∫ r dz along a piece.
fn area(piece: &Piece) -> f64 {
    const STEPS: usize = 16;
    let [from, to] = piece.range;
    let at = |i: usize| piece.at(if i == STEPS { to } else { from + (to - from) * i as f64 / STEPS as f64 });
    (0..STEPS).map(|i| 0.5 * (at(i).x + at(i + 1).x) * (at(i + 1).y - at(i).y)).sum()
}

impl Local for Revolution {
    fn crossed(&self, origin: Vec3, direction: Vec3, rounding: f64) -> SmallVec<[OnLine; 4]> {
        let shift = -origin.dot(direction);
        let start = origin + direction * shift;
        let (flat, across) = (direction.truncate(), start.truncate());
        let speed = flat.length();
        // Upright lines are seen in the plane through the axis.
        const UPRIGHT: f64 = 1e-150;
        let ahead = if speed > UPRIGHT { flat / speed } else { across.try_normalize().unwrap_or(DVec2::X) };
        if !start.is_finite() || !direction.is_finite() {
            return SmallVec::new();
        }
        let plane = InPlane {
            start: DVec2::new(across.dot(ahead), start.z),
            direction: DVec2::new(if speed > UPRIGHT { speed } else { 0.0 }, direction.z),
            off: if speed > UPRIGHT { ahead.perp_dot(across).abs() } else { 0.0 },
            height: 4.0 * rounding + NOISE,
        };
        let mut met: SmallVec<[Met; 8]> = SmallVec::new();
        for index in 0..self.pieces.len() {
            self.meet(&plane, index, &mut met);
        }
        met.sort_by(|a, b| a.t.total_cmp(&b.t));
        let mut inside = false;
        let crossing = |met: Met| {
            inside = !inside;
            // From left to right, a line enters what is outside on the left.
            let enters = if self.closed { inside } else { met.rightwards == self.outside_left };
            let outside_left = met.rightwards == enters;
            OnLine {
                t: shift + met.t,
                error: met.error + 4.0 * f64::EPSILON * (shift.abs() + met.t.abs()),
                enters,
                part: 2 * met.piece + u32::from(outside_left),
            }
        };
        met.into_iter().map(crossing).collect()
    }

    fn normal(&self, point: Vec3, part: u32) -> Vec3 {
        let radius = point.truncate().length();
        let s = self.piece(part).nearest(DVec2::new(radius, point.z));
        let outward = self.outward(s, part);
        let around = point.truncate().try_normalize().unwrap_or(DVec2::X);
        (around * outward.x).extend(outward.y)
    }

    fn project(&self, point: Vec3, part: u32) -> Vec3 {
        let across = point.truncate();
        let piece = self.piece(part);
        let at = piece.at(piece.nearest(DVec2::new(across.length(), point.z)));
        (across.try_normalize().unwrap_or(DVec2::X) * at.x).extend(at.y)
    }

    /// u goes around z and v along the profile, evenly in its parameter, each line or cubic as far as the
    /// others; on caps both go across, from edge to edge.
    fn parametrisation(&self, point: Vec3, part: u32) -> ([f64; 2], [Vec3; 2]) {
        let piece = self.piece(part);
        let across = point.truncate();
        let Some([begin, end]) = piece.along else {
            let radius = piece.ends[0].x.max(piece.ends[1].x);
            let uv = (across / radius + 1.0) * 0.5;
            return (uv.to_array(), [Vec3::X * (2.0 * radius), Vec3::Y * (2.0 * radius)]);
        };
        let s = piece.nearest(DVec2::new(across.length(), point.z));
        let [low, high] = piece.range;
        let rate = (high - low) / (end - begin);
        let u = (angle::atan2(across.y, across.x) / TAU).rem_euclid(1.0);
        let along = piece.slope(s) * rate;
        let around = across.try_normalize().unwrap_or(DVec2::X);
        let by_v = (around * along.x).extend(along.y);
        ([u, begin + (s - low) / rate], [across.perp().extend(0.0) * TAU, by_v])
    }

    fn reach(&self, direction: Vec3) -> f64 {
        let in_plane = DVec2::new(direction.truncate().length(), direction.z);
        self.pieces.iter().map(|piece| piece.reach(in_plane)).fold(f64::NEG_INFINITY, f64::max)
    }

    fn rounding(&self, _: Vec3) -> f64 {
        32.0 * f64::EPSILON
    }

    fn is_closed(&self) -> bool {
        self.closed
    }
}
