//! Extinction on a grid of cells.
//!
//! Between the planes through the centres of cells what is interpolated is a polynomial along any ray: of
//! degree 3 for numbers, of degree 6 for colours, whose shape and factor are interpolated apart. A
//! Gauss-Legendre rule of two or four points integrates it exactly, so that the optical depth of a stretch is
//! exact up to rounding, and so is the place where it reaches a value. No majorant is asked for, and shadow
//! rays bring no noise.

use super::FreeFlight;
use crate::geometry::{Ray, Vec3};
use crate::spectrum::Sampled;
use crate::texture::{Filter, Volume};
use std::ops::ControlFlow;

/// A grid times a factor; nothing outside of its box.
#[derive(Clone, Debug)]
pub struct GridExtinction {
    /// The values.
    pub volume: Volume,
    /// Factor on the values, at least 0.
    pub factor: f64,
}

/// Where in a piece an integral from its beginning reaches a value that it exceeds at the end. `on`: what is
/// integrated.
pub(super) fn invert(
    [from, to]: [f64; 2],
    target: f64,
    integral: impl Fn(f64) -> f64,
    on: impl Fn(f64) -> f64,
) -> f64 {
    const STEPS: u32 = 64;
    let (mut low, mut high) = (from, to);
    let whole = integral(to);
    let mut t = from + (to - from) * (target / whole).min(1.0);
    for _ in 0..STEPS {
        let excess = integral(t) - target;
        if excess > 0.0 {
            high = t;
        } else {
            low = t;
        }
        if excess.abs() <= 1e-12 * whole || high - low <= f64::EPSILON * high {
            break;
        }
        let newton = t - excess / on(t);
        t = if low < newton && newton < high { newton } else { 0.5 * (low + high) };
    }
    t
}

/// Points in [0, 1] and weights of the Gauss-Legendre rules of one, two and four points.
const ONE: [[f64; 2]; 1] = [[0.5, 1.0]];
const TWO: [[f64; 2]; 2] = [[0.211_324_865_405_187_13, 0.5], [0.788_675_134_594_812_9, 0.5]];
const FOUR: [[f64; 2]; 4] = [
    [0.069_431_844_202_973_71, 0.173_927_422_568_726_93],
    [0.330_009_478_207_571_87, 0.326_072_577_431_273_07],
    [0.669_990_521_792_428_1, 0.326_072_577_431_273_07],
    [0.930_568_155_797_026_3, 0.173_927_422_568_726_93],
];

impl GridExtinction {
    /// Whether it is 0 everywhere.
    pub fn is_zero(&self) -> bool {
        self.factor == 0.0 || self.volume.max_bound() == 0.0
    }

    /// No extinction is above it at any wavelength.
    pub fn max_bound(&self) -> f64 {
        self.factor * self.volume.max_bound()
    }

    /// Where a ray enters and leaves the grid's box. `None` where it misses it.
    pub fn span(&self, ray: &Ray) -> Option<[f64; 2]> {
        self.line(ray).span()
    }

    /// Zero outside of the grid's box.
    pub fn at<const C: usize>(&self, position: Vec3, nm: &[f64; C]) -> Sampled<C> {
        let place = self.volume.to_local().point(position);
        if place.cmplt(Vec3::ZERO).any() || place.cmpgt(Vec3::ONE).any() {
            return Sampled::ZERO;
        }
        self.volume.sample_at(place, nm) * self.factor
    }

    /// Optical depth of a ray from its beginning to its end, at the wavelengths `nm`.
    pub fn optical_depths<const C: usize>(&self, ray: &Ray, nm: &[f64; C]) -> Sampled<C> {
        let mut depths = Sampled::ZERO;
        let line = self.line(ray);
        line.pieces(|from, to| {
            depths += self.integral(&line, from, to, nm);
            ControlFlow::Continue(())
        });
        depths
    }

    /// See [`super::Medium::fly`].
    pub fn fly<const C: usize>(&self, ray: &Ray, target: f64, nm: &[f64; C]) -> FreeFlight<C> {
        let mut depths = Sampled::ZERO;
        let mut ended = None;
        let line = self.line(ray);
        line.pieces(|from, to| {
            let piece = self.integral(&line, from, to, nm);
            if depths.hero() + piece.hero() <= target {
                depths += piece;
                return ControlFlow::Continue(());
            }
            let hero = [nm[0]];
            let distance = invert(
                [from, to],
                target - depths.hero(),
                |t| self.integral(&line, from, t, &hero).hero(),
                |t| self.on(&line, t, &hero).hero(),
            );
            let depths = depths + self.integral(&line, from, distance, nm);
            let extinction = self.on(&line, distance, nm);
            ended = Some(FreeFlight::Ended { distance, depths, extinction });
            ControlFlow::Break(())
        });
        ended.unwrap_or(FreeFlight::Passed { depths })
    }

    fn on<const C: usize>(&self, line: &Line, t: f64, nm: &[f64; C]) -> Sampled<C> {
        self.volume.sample_at(line.at(t), nm) * self.factor
    }

    /// Over a piece, exactly.
    fn integral<const C: usize>(&self, line: &Line, from: f64, to: f64, nm: &[f64; C]) -> Sampled<C> {
        let rule: &[[f64; 2]] = match (self.volume.filter(), self.volume.is_coloured()) {
            (Filter::Nearest, _) => &ONE,
            (Filter::Linear, false) => &TWO,
            (Filter::Linear, true) => &FOUR,
        };
        let mut sum = Sampled::ZERO;
        for [place, weight] in rule {
            sum += self.volume.sample_at(line.at(from + (to - from) * place), nm) * *weight;
        }
        sum * (self.factor * (to - from))
    }

    fn line(&self, ray: &Ray) -> Line {
        Line::new(&self.volume, ray)
    }
}

/// A ray in coordinates in which the grid is the unit cube; distances stay those of the scene.
struct Line {
    origin: Vec3,
    direction: Vec3,
    t_max: f64,
    size: [usize; 3],
    /// Whether pieces end at the centres of cells, and not where cells do.
    centred: bool,
}

/// Where a ray enters and leaves the box of a grid. `None` where it misses it.
pub(super) fn span(volume: &Volume, ray: &Ray) -> Option<[f64; 2]> {
    Line::new(volume, ray).span()
}

impl Line {
    fn new(volume: &Volume, ray: &Ray) -> Self {
        let to_local = volume.to_local();
        Self {
            origin: to_local.point(ray.origin),
            direction: to_local.vector(ray.direction),
            t_max: ray.t_max,
            size: volume.size(),
            centred: volume.filter() == Filter::Linear,
        }
    }

    fn at(&self, t: f64) -> Vec3 {
        self.origin + self.direction * t
    }

    /// The planes across an axis, of which there are `size` + 1, or one more where they go through the
    /// centres.
    fn plane(&self, axis: usize, index: i64) -> f64 {
        let size = self.size[axis] as f64;
        let index = index as f64;
        if self.centred { ((index - 0.5) / size).clamp(0.0, 1.0) } else { index / size }
    }

    fn planes(&self, axis: usize) -> i64 {
        self.size[axis] as i64 + if self.centred { 2 } else { 1 }
    }

    /// The part of the ray within the cube.
    fn span(&self) -> Option<[f64; 2]> {
        let (mut start, mut end) = (0.0f64, self.t_max);
        for axis in 0..3 {
            let (origin, slope) = (self.origin[axis], self.direction[axis]);
            if slope == 0.0 {
                if !(0.0..=1.0).contains(&origin) {
                    return None;
                }
                continue;
            }
            let [a, b] = [-origin / slope, (1.0 - origin) / slope];
            (start, end) = (start.max(a.min(b)), end.min(a.max(b)));
        }
        (start < end && end.is_finite()).then_some([start, end])
    }

    /// Calls with the ends of each piece of the ray within the cube on which no plane is crossed, in order.
    fn pieces(&self, mut visit: impl FnMut(f64, f64) -> ControlFlow<()>) {
        let Some([start, end]) = self.span() else { return };
        // The next plane along each axis, and where it is crossed.
        let entry = self.at(start);
        let mut next = [0i64; 3];
        let crossing = |axis: usize, index: i64| match self.direction[axis] {
            slope if slope == 0.0 || !(0..self.planes(axis)).contains(&index) => f64::INFINITY,
            slope => (self.plane(axis, index) - self.origin[axis]) / slope,
        };
        for (axis, next) in next.iter_mut().enumerate() {
            let place = entry[axis] * self.size[axis] as f64 + if self.centred { 0.5 } else { 0.0 };
            let below = (place.floor() as i64).clamp(0, self.planes(axis) - 2);
            *next = if self.direction[axis] > 0.0 { below + 1 } else { below };
        }
        let mut t = start;
        loop {
            let ahead: [f64; 3] = std::array::from_fn(|axis| crossing(axis, next[axis]));
            let axis = (0..3).min_by(|&a, &b| ahead[a].total_cmp(&ahead[b])).unwrap_or(0);
            let to = ahead[axis].min(end);
            if to > t {
                if visit(t, to).is_break() {
                    return;
                }
                t = to;
            }
            if ahead[axis] >= end {
                return;
            }
            next[axis] += if self.direction[axis] > 0.0 { 1 } else { -1 };
        }
    }
}
