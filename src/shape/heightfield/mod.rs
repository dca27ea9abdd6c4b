//! Heights over a square: bilinear patches between the points of a grid, open or as a body on a base.
//!
//! Along a line the height over a patch is a quadratic (*The Method*, "Ray-Tracing Height Fields"; Glassner,
//! *An Introduction to Ray Tracing*, ch. 3, 3.3), solved in closed form. Which of its roots count is decided
//! by the signs on the cell's border, which two cells share ([`super::grid`]).

mod path;
mod sampling;
mod terrain;

use super::areas::AreaDistribution;
use super::crossing::{Crossing, Crossings};
use super::grid::{Change, GridSegment, Pyramid, Signs, index, place};
use super::placement::Placement;
use super::{Hit, Parametrisation, ShapeError, SurfaceHit};
use crate::geometry::{Bounds, Ray, SurfacePoint, Transform, Vec3};
use glam::DMat4;
use path::Path;
use smallvec::SmallVec;
use std::sync::Arc;
pub use terrain::Terrain;

/// Heights at points that divide a square evenly, first along x, then y; shared by all shapes made of them.
#[derive(Clone, Debug)]
pub struct HeightData {
    /// Points along both axes.
    points: [usize; 2],
    values: Vec<f32>,
    pyramid: Pyramid<2>,
}

/// Heights over [−1, 1]², where they stand.
///
/// In coordinates of its own z is from −1, at the lowest point or the base, to 1, at the highest.
#[derive(Clone, Debug)]
pub struct HeightField {
    data: Arc<HeightData>,
    placement: Placement,
    /// In its own coordinates the z of the middle above height 0, and that of a unit of height.
    middle: f64,
    per_height: f64,
    /// Whether it is a body that goes down to z = −1.
    solid: bool,
    smooth: bool,
    inward: bool,
    areas: AreaDistribution,
}

/// The part of the body's surface that is no height, after the cells: the sides at x = −1, x = 1, y = −1, y =
/// 1, and the base.
const BASE: usize = 4;

impl HeightData {
    /// # Errors
    /// Fewer than two points along an axis, no height for each of them, or heights that are not finite.
    pub fn new(points: [usize; 2], values: Vec<f32>) -> Result<Self, ShapeError> {
        let count = points[0].checked_mul(points[1]);
        if points.iter().any(|&points| points < 2) || count != Some(values.len()) {
            return Err(ShapeError::GridPoints);
        }
        if values.len() >= u32::MAX as usize - 8 {
            return Err(ShapeError::TooLarge);
        }
        if let Some(vertex) = values.iter().position(|value| !value.is_finite()) {
            return Err(ShapeError::NotFinite { attribute: "height", vertex });
        }
        let pyramid = Pyramid::new(points, &values);
        Ok(Self { points, values, pyramid })
    }

    /// Points along both axes, and the heights.
    pub fn grid(&self) -> ([usize; 2], &[f32]) {
        (self.points, &self.values)
    }

    /// The least and the greatest height.
    pub fn range(&self) -> [f32; 2] {
        self.pyramid.whole()
    }
}

/// A patch over the unit square: its corner's height, what it rises along x and y, and its twist.
#[derive(Clone, Copy, Debug)]
struct Patch {
    corners: [f64; 4],
}

impl Patch {
    fn height(&self, [x, y]: [f64; 2]) -> f64 {
        // Exact at both ends, and never beyond the two values.
        let mix = |a: f64, b: f64, u: f64| a * (1.0 - u) + b * u;
        let [a, b, c, d] = self.corners;
        mix(mix(a, b, x), mix(c, d, x), y)
    }

    /// Along x and y, per cell.
    fn slopes(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [a, b, c, d] = self.corners;
        [(b - a) * (1.0 - y) + (d - c) * y, (c - a) * (1.0 - x) + (d - b) * x]
    }

    fn twist(&self) -> f64 {
        let [a, b, c, d] = self.corners;
        (d - c) - (b - a)
    }
}

impl HeightField {
    /// z = `scale` times the height over [−1, 1]² under `to_world`; a body down to z = `base` if there is
    /// one, which must be below all of it. Normals point up and out of the body unless `flip_normals`. With
    /// `smooth`, shading normals are interpolated between those of the grid's points.
    pub fn new(
        to_world: &Transform,
        data: Arc<HeightData>,
        scale: f64,
        base: Option<f64>,
        smooth: bool,
        flip_normals: bool,
    ) -> Result<Self, ShapeError> {
        let [low, high] = data.range().map(|height| f64::from(height) * scale);
        let (low, high) = (low.min(high), low.max(high));
        if base.is_some_and(|base| base >= low) {
            return Err(ShapeError::Base);
        }
        let floor = base.unwrap_or(low);
        // A plane has no height: any will do.
        let half = if high > floor { 0.5 * (high - floor) } else { 1.0 };
        let middle = if high > floor { 0.5 * (high + floor) } else { floor };
        let upright =
            DMat4::from_translation(Vec3::Z * middle) * DMat4::from_scale(Vec3::new(1.0, 1.0, half));
        let upright = Transform::new(upright).ok_or(ShapeError::Placement)?;
        let mut field = Self {
            data,
            placement: Placement::new(&upright.then(to_world))?,
            middle: middle / half,
            per_height: scale / half,
            solid: base.is_some(),
            smooth,
            inward: flip_normals,
            areas: AreaDistribution::default(),
        };
        field.areas = sampling::areas(&field);
        Ok(field)
    }

    fn size(&self) -> [usize; 2] {
        self.data.pyramid.size()
    }

    /// Half the number of cells along both axes: cells per unit of length.
    fn density(&self) -> [f64; 2] {
        self.size().map(|cells| 0.5 * cells as f64)
    }

    fn local_height(&self, height: f32) -> f64 {
        f64::from(height) * self.per_height - self.middle
    }

    fn at_point(&self, point: [usize; 2]) -> f64 {
        self.local_height(self.data.values[index(self.data.points, point)])
    }

    fn patch(&self, [i, j]: [usize; 2]) -> Patch {
        let corners = [[i, j], [i + 1, j], [i, j + 1], [i + 1, j + 1]];
        Patch { corners: corners.map(|point| self.at_point(point)) }
    }

    /// Nearest hit with 0 ≤ t < `ray.t_max`.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let mut nearest = None;
        self.follow(ray, 0.0, |found| {
            if found.hit.t < 0.0 {
                return true;
            }
            nearest = (found.hit.t < ray.t_max).then_some(found.hit);
            false
        });
        nearest
    }

    /// All crossings along the whole line.
    pub fn crossings(&self, ray: &Ray) -> Crossings {
        let mut found = Crossings::new();
        self.follow(ray, f64::NEG_INFINITY, |crossing| {
            found.push(Crossing { enters: crossing.enters != self.inward, ..crossing });
            true
        });
        found
    }

    /// Crossings in ascending order from the cell at `start` on, until `take` says false.
    fn follow(&self, ray: &Ray, start: f64, mut take: impl FnMut(Crossing) -> bool) {
        let direction = self.placement.pose.local_vector(ray.direction);
        let far = self.placement.pose.local_point(ray.origin);
        // From the point of the line that is nearest to the middle, where numbers are small.
        let shift = -far.dot(direction) / direction.length_squared();
        let origin = far + direction * shift;
        let coordinate = self.placement.coordinate_error(1.0 + far.abs().max_element()) + 4.0 * f64::EPSILON;
        let path = Path { field: self, origin, direction, coordinate, shift };
        let line = path.line();
        // A little beyond the heights, but no deeper than the base.
        let (floor, ceiling) = (if self.solid { -1.0 } else { -1.0 - 1e-6 }, 1.0 + 1e-6);
        let mut limits = [f64::NEG_INFINITY, f64::INFINITY];
        if direction.z != 0.0 {
            let ends = [floor, ceiling].map(|z| (z - origin.z) / direction.z);
            limits = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        } else if !(floor..=ceiling).contains(&origin.z) {
            return;
        }
        let Some(limits) = line.within(self.size(), limits) else { return };
        let signs = std::cell::Cell::new(Signs::default());
        let walls: std::cell::RefCell<SmallVec<[Crossing; 2]>> = Default::default();
        let begin = |cell: [usize; 2], t: f64, across| {
            let patch = self.patch(cell);
            let value = path.height(t) - patch.height(line.place(cell, t, across, false));
            let mut first = Signs::default();
            if self.solid && t <= limits[0] {
                // Outside until here.
                first.next(t, 1.0);
            }
            let change = first.next(t, value);
            walls.borrow_mut().extend(change.map(|_| path.wall(t, true)));
            signs.set(first);
            value != 0.0
        };
        let sign = |range: [f32; 2], ends: [f64; 2]| {
            let [a, b] = range.map(|height| self.local_height(height));
            let [c, d] = ends.map(|t| path.height(t));
            // More than signs on a cell's border are off by rounding.
            const MARGIN: f64 = 1e-14;
            match () {
                () if c.min(d) > a.max(b) + MARGIN => Some(1.0),
                () if c.max(d) < a.min(b) - MARGIN => Some(-1.0),
                () => None,
            }
        };
        let mut goes_on = true;
        line.walk(&self.data.pyramid, limits, start - shift, begin, sign, |segment| {
            for wall in walls.borrow_mut().drain(..) {
                goes_on = goes_on && take(wall);
            }
            let mut now = signs.get();
            match segment {
                GridSegment::Free { sign, ends } => {
                    if let Some(Change { between: [t, _], from }) = now.next(ends[0], sign) {
                        // The two sides round differently: the surface is as near as that to this place.
                        let cell = line.cell(self.size(), t);
                        goes_on = goes_on && take(path.crossing(cell, t, f64::INFINITY, from > 0.0));
                    }
                    now.hold(ends[1]);
                }
                GridSegment::Cell { cell, ends, through } => {
                    for found in path.in_cell(&line, cell, ends, through, &mut now) {
                        goes_on = goes_on && take(found);
                    }
                }
            }
            signs.set(now);
            goes_on
        });
        if goes_on && self.solid && signs.get().sign() < 0.0 {
            take(path.wall(limits[1], false));
        }
    }

    /// The surface near `position`, of a cell or another part.
    pub fn surface(&self, position: Vec3, part: u32) -> SurfaceHit {
        let local = self.placement.pose.local_point(position);
        self.surface_at(local, part as usize)
    }

    fn surface_at(&self, mut local: Vec3, part: usize) -> SurfaceHit {
        let cells = self.data.pyramid.cells();
        let side = if self.inward { -1.0 } else { 1.0 };
        let mut shading = None;
        let outward = if part < cells {
            let (cell, at) = self.locate(local, part);
            let patch = self.patch(cell);
            local.z = patch.height(at);
            if self.smooth {
                shading = Some(self.smooth_normal(cell, at));
            }
            self.upward(&patch, at)
        } else {
            let wall = (part - cells).min(BASE);
            let outward = if wall == BASE { -Vec3::Z } else { wall_normal(wall) };
            let off = 1.0 - local.dot(outward);
            local += outward * off;
            outward
        };
        let outward = outward.normalize();
        let position = self.placement.pose.world_point(local);
        let image = self.placement.pose.world_normal(outward);
        let stretch = image.length();
        let normal = image * (side / stretch);
        // Heights are of rounded numbers up to 1, and the place between them is by some units less exact.
        let error = self.placement.error(position, outward, stretch) + 16.0 * f64::EPSILON / stretch;
        let shading_normal = shading
            .and_then(|shading| self.placement.pose.world_normal(shading).try_normalize())
            .map_or(normal, |shading| shading * side);
        SurfaceHit { point: SurfacePoint { position, normal, error }, shading_normal }
    }

    /// A cell's indices, and the place in it.
    fn locate(&self, local: Vec3, cell: usize) -> ([usize; 2], [f64; 2]) {
        let cell = place(self.size(), cell);
        let density = self.density();
        let at = [0, 1].map(|axis| ((local[axis] + 1.0) * density[axis] - cell[axis] as f64).clamp(0.0, 1.0));
        (cell, at)
    }

    /// The normal of any length whose z is 1.
    fn upward(&self, patch: &Patch, at: [f64; 2]) -> Vec3 {
        let ([x, y], density) = (patch.slopes(at), self.density());
        Vec3::new(-x * density[0], -y * density[1], 1.0)
    }

    /// Bilinear between the normals of the grid's points, each by the heights of its neighbours.
    fn smooth_normal(&self, [i, j]: [usize; 2], [x, y]: [f64; 2]) -> Vec3 {
        let density = self.density();
        let at = |point: [usize; 2]| {
            Vec3::from_array([0, 1, 2].map(|axis| {
                if axis == 2 {
                    return 1.0;
                }
                let (mut low, mut high) = (point, point);
                low[axis] = point[axis].saturating_sub(1);
                high[axis] = (point[axis] + 1).min(self.data.points[axis] - 1);
                let steps = (high[axis] - low[axis]) as f64;
                (self.at_point(low) - self.at_point(high)) / steps * density[axis]
            }))
        };
        at([i, j]).lerp(at([i + 1, j]), x).lerp(at([i, j + 1]).lerp(at([i + 1, j + 1]), x), y)
    }

    /// u along x and v along y, as on a rectangle; on the sides v is along z, and u along the other axis.
    pub fn parametrisation(&self, position: Vec3, part: u32) -> Parametrisation {
        let local = self.placement.pose.local_point(position);
        let (part, cells) = (part as usize, self.data.pyramid.cells());
        let (tangent, bitangent) = if part < cells {
            let (cell, at) = self.locate(local, part);
            let up = self.upward(&self.patch(cell), at);
            (Vec3::new(1.0, 0.0, -up.x), Vec3::new(0.0, 1.0, -up.y))
        } else {
            match part - cells {
                0 | 1 => (Vec3::Y, Vec3::Z),
                2 | 3 => (Vec3::X, Vec3::Z),
                _ => (Vec3::X, Vec3::Y),
            }
        };
        let along = |axis: Vec3| 0.5 * (local.dot(axis) + 1.0);
        // The heights' coordinates are x and y alone.
        let flat = |tangent: Vec3| if part < cells { tangent.with_z(0.0) } else { tangent };
        Parametrisation {
            uv: [along(flat(tangent)), along(flat(bitangent))],
            tangent: self.placement.pose.world_vector(2.0 * tangent),
            bitangent: self.placement.pose.world_vector(2.0 * bitangent),
        }
    }

    /// A bilinear patch lies in the hull of its corners, so the smallest box is that of all points.
    pub fn bounds(&self) -> Bounds {
        let density = self.density();
        let mut bounds = Bounds::EMPTY;
        for i in 0..self.data.values.len() {
            let point = place(self.data.points, i);
            let [x, y] = [0, 1].map(|axis| point[axis] as f64 / density[axis] - 1.0);
            bounds = bounds.including(self.placement.pose.world_point(Vec3::new(x, y, self.at_point(point))));
        }
        if self.solid {
            for corner in 0..4 {
                let side = |bit: usize| if corner >> bit & 1 == 0 { -1.0 } else { 1.0 };
                let corner = Vec3::new(side(0), side(1), -1.0);
                bounds = bounds.including(self.placement.pose.world_point(corner));
            }
        }
        bounds
    }

    /// Whether it is a body: whether it has a bottom.
    pub fn is_closed(&self) -> bool {
        self.solid
    }
}

/// The outward normal of one of the four sides.
fn wall_normal(wall: usize) -> Vec3 {
    let axis = if wall < 2 { Vec3::X } else { Vec3::Y };
    if wall.is_multiple_of(2) { -axis } else { axis }
}
