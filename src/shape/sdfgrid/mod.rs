//! Surfaces where a function known on a grid of points is zero, as Mitsuba 3's `sdfgrid`.
//!
//! Between eight points the function is interpolated trilinearly, so along a line it is a cubic in each cell
//! (Hansson-Söderlund, Evans and Akenine-Möller, "Ray Tracing of Signed Distance Function Grids", JCGT 11(3),
//! 2022). It is followed from cell to cell by its sign ([`super::grid`]) and split at the extremes of its
//! cubics. Nothing asks for it to be a distance.

mod cell;
mod normals;

use super::crossing::{Crossing, Crossings};
use super::grid::{Change, GridSegment, Line, Pyramid, Signs, index, place};
use super::placement::Placement;
use super::{AreaSample, Hit, NO_INSTANCE, ShapeError, SurfaceHit};
use crate::geometry::{Bounds, Ray, SurfacePoint, Transform, Vec3};
use crate::sampling::quadrature::midpoints;
use cell::{InCell, Within, gradient, interpolate, on_line};
use std::sync::Arc;

/// Values at points that divide the unit cube evenly, first along x, then y, then z; shared by all shapes
/// made of them.
#[derive(Clone, Debug)]
pub struct SdfData {
    /// Points along each axis.
    points: [usize; 3],
    values: Vec<f32>,
    pyramid: Pyramid<3>,
    /// The cells through which the surface goes.
    crossed: Vec<u32>,
}

/// The surface of an [`SdfData`], where it stands.
#[derive(Clone, Debug)]
pub struct SdfGrid {
    data: Arc<SdfData>,
    placement: Placement,
    smooth: bool,
    inward: bool,
    bounds: Bounds,
}

impl SdfData {
    /// # Errors
    /// Fewer than two points along an axis, no value for each of them, or no place where the sign changes.
    pub fn new(points: [usize; 3], values: Vec<f32>) -> Result<Self, ShapeError> {
        let count = points.iter().try_fold(1usize, |count, &points| count.checked_mul(points));
        if points.iter().any(|&points| points < 2) || count != Some(values.len()) {
            return Err(ShapeError::GridPoints);
        }
        if u32::try_from(values.len()).is_err() {
            return Err(ShapeError::TooLarge);
        }
        let pyramid = Pyramid::new(points, &values);
        let cells = 0..pyramid.cells() as u32;
        // Zero counts as positive: of two cells whose common side is all zero one is crossed.
        let is_crossed = |&cell: &u32| {
            let [least, greatest] = pyramid.range(0, place(pyramid.size(), cell as usize));
            least < 0.0 && greatest >= 0.0
        };
        let crossed: Vec<u32> = cells.filter(is_crossed).collect();
        if crossed.is_empty() {
            return Err(ShapeError::Nothing);
        }
        Ok(Self { points, values, pyramid, crossed })
    }

    /// Points along each axis, and the values.
    pub fn grid(&self) -> ([usize; 3], &[f32]) {
        (self.points, &self.values)
    }

    /// Whether the surface ends nowhere: the values on the cube's faces have one sign.
    pub fn is_closed(&self) -> bool {
        let on_face = |i: usize| {
            let at = place(self.points, i);
            (0..3).any(|axis| at[axis] == 0 || at[axis] + 1 == self.points[axis])
        };
        let mut values = self.values.iter().enumerate().filter(|&(i, _)| on_face(i)).map(|(_, value)| value);
        values.clone().all(|&value| value > 0.0) || values.all(|&value| value < 0.0)
    }

    fn corners(&self, cell: [usize; 3]) -> [f64; 8] {
        std::array::from_fn(|corner| {
            let at = std::array::from_fn(|axis| cell[axis] + (corner >> axis & 1));
            f64::from(self.values[index(self.points, at)])
        })
    }
}

impl SdfGrid {
    /// The zeros of `data` on the unit cube, under `to_world`. Normals point to where the function is
    /// positive, unless `flip_normals`. With `smooth`, shading normals are continuous across the sides of
    /// cells.
    pub fn new(
        to_world: &Transform,
        data: Arc<SdfData>,
        smooth: bool,
        flip_normals: bool,
    ) -> Result<Self, ShapeError> {
        let placement = Placement::new(to_world)?;
        let bounds = bounds(&data, &placement);
        Ok(Self { data, placement, smooth, inward: flip_normals, bounds })
    }

    /// Cells along each axis.
    fn cells(&self) -> Vec3 {
        Vec3::from_array(self.data.pyramid.size().map(|cells| cells as f64))
    }

    /// Nearest hit with 0 ≤ t < `ray.t_max`.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let mut nearest = None;
        self.follow(ray, 0.0, |found| {
            if found.t < 0.0 {
                return true;
            }
            nearest = (found.t < ray.t_max).then_some(found);
            false
        });
        nearest.map(|InCell { cell, t, .. }| hit(t, cell))
    }

    /// All crossings along the whole line.
    pub fn crossings(&self, ray: &Ray) -> Crossings {
        let mut found = Crossings::new();
        self.follow(ray, f64::NEG_INFINITY, |InCell { cell, t, error, enters }| {
            found.push(Crossing { hit: hit(t, cell), error, enters: enters != self.inward });
            true
        });
        found
    }

    /// Crossings in ascending order from the cell at `start` on, until `take` says false.
    fn follow(&self, ray: &Ray, start: f64, mut take: impl FnMut(InCell) -> bool) {
        let cells = self.cells();
        let direction = self.placement.pose.local_vector(ray.direction);
        let origin = self.placement.pose.local_point(ray.origin);
        // From the point of the line that is nearest to the middle, where numbers are small.
        let shift = (Vec3::splat(0.5) - origin).dot(direction) / direction.length_squared();
        let line = Line {
            origin: ((origin + direction * shift) * cells).to_array(),
            direction: (direction * cells).to_array(),
        };
        let size = self.data.pyramid.size();
        let Some(limits) = line.within(size, [f64::NEG_INFINITY, f64::INFINITY]) else { return };
        // The error of the place in a cell, in cells.
        let reach = 1.0 + origin.abs().max_element();
        let coordinate = (self.placement.coordinate_error(reach) + 4.0 * f64::EPSILON) * cells.max_element();
        let signs = std::cell::Cell::new(Signs::default());
        let begin = |cell: [usize; 3], t: f64, across| {
            let value = interpolate(&self.data.corners(cell), line.place(cell, t, across, false));
            let mut first = Signs::default();
            first.next(t, value);
            signs.set(first);
            value != 0.0
        };
        let sign = |[least, greatest]: [f32; 2], _| match () {
            () if least > 0.0 => Some(1.0),
            () if greatest < 0.0 => Some(-1.0),
            () => None,
        };
        line.walk(&self.data.pyramid, limits, start - shift, begin, sign, |segment| {
            let mut now = signs.get();
            let goes_on = match segment {
                GridSegment::Free { sign, ends } => {
                    let change = now.next(ends[0], sign);
                    now.hold(ends[1]);
                    change.is_none_or(|Change { between, from }| {
                        // The two sides round differently: the surface is as near as that to this place.
                        let cell = line.cell(size, between[0]);
                        take(InCell {
                            cell: index(size, cell) as u32,
                            t: shift + between[0],
                            error: f64::INFINITY,
                            enters: from > 0.0,
                        })
                    })
                }
                GridSegment::Cell { cell, ends, through } => {
                    let within = Within { line: &line, cell, ends, through, coordinate };
                    let found = within.crossings(&self.data, &mut now);
                    found.into_iter().all(|found| {
                        let t = shift + found.t;
                        let rounding = 4.0 * f64::EPSILON * (shift.abs() + t.abs());
                        take(InCell { t, error: found.error + rounding, ..found })
                    })
                }
            };
            signs.set(now);
            goes_on
        });
    }

    /// The grid's coordinates of a world point, in a cell, and the cell.
    fn locate(&self, position: Vec3, cell: u32) -> ([usize; 3], [f64; 3]) {
        let cell = place(self.data.pyramid.size(), cell as usize);
        let at = self.placement.pose.local_point(position) * self.cells();
        (cell, std::array::from_fn(|axis| (at[axis] - cell[axis] as f64).clamp(0.0, 1.0)))
    }

    /// The surface in a cell near `position`.
    pub fn surface(&self, position: Vec3, cell: u32) -> SurfaceHit {
        let (cell, at) = self.locate(position, cell);
        self.surface_at(cell, at)
    }

    fn surface_at(&self, cell: [usize; 3], mut at: [f64; 3]) -> SurfaceHit {
        let corners = self.data.corners(cell);
        let cells = self.cells();
        // A step of Newton's along the gradient of the grid's own coordinates.
        let slope = gradient(&corners, at);
        let (value, squared) = (interpolate(&corners, at), slope.length_squared());
        if squared > 0.0 {
            let step = slope * (-value / squared);
            at = std::array::from_fn(|axis| (at[axis] + step[axis]).clamp(0.0, 1.0));
        }
        let corner = Vec3::from_array(cell.map(|i| i as f64));
        let local = (corner + Vec3::from_array(at)) / cells;
        let slope = gradient(&corners, at) * cells;
        let steepness = slope.length();
        let outward = slope.try_normalize().unwrap_or(Vec3::Z);
        let position = self.placement.pose.world_point(local);
        let image = self.placement.pose.world_normal(outward);
        let stretch = image.length();
        let side = if self.inward { -1.0 } else { 1.0 };
        let normal = image * (side / stretch);
        let greatest = corners.iter().fold(0.0f64, |most, value| most.max(value.abs()));
        // What is left after the step, and what interpolation rounds. Where there is no slope the surface may
        // be anywhere in the cell.
        let residual = 2.0 * interpolate(&corners, at).abs() + 16.0 * f64::EPSILON * greatest;
        let off = (residual / steepness).min(1.0 / cells.min_element());
        // Local coordinates come from those of the grid, which round by as much again.
        let error = self.placement.error(position, outward, stretch) + (off + 8.0 * f64::EPSILON) / stretch;
        let shading_normal = if self.smooth {
            let smooth = normals::smooth(&self.data, cell, at);
            let image = self.placement.pose.world_normal(smooth).try_normalize();
            image.map_or(normal, |image| image * side)
        } else {
            normal
        };
        SurfaceHit { point: SurfacePoint { position, normal, error }, shading_normal }
    }

    /// A box around it.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Whether the surface lies within the grid.
    pub fn is_closed(&self) -> bool {
        self.data.is_closed()
    }

    /// By the midpoint rule over lines through the cells that the surface goes through, along each axis, as
    /// `chords.rs` has it.
    pub fn area(&self) -> f64 {
        const LINES: usize = 8;
        let mut sum = 0.0;
        for &cell in &self.data.crossed {
            let cell = place(self.data.pyramid.size(), cell as usize);
            let corners = self.data.corners(cell);
            for axis in 0..3 {
                for across in midpoints(LINES) {
                    let Some(at) = on_line(&corners, axis, across) else { continue };
                    let normal = gradient(&corners, at).normalize_or_zero();
                    sum += normal[axis].abs() * self.area_stretch(normal) / (LINES * LINES) as f64;
                }
            }
        }
        sum
    }

    /// World area for an area of the grid's own coordinates across a unit normal in them.
    fn area_stretch(&self, normal: Vec3) -> f64 {
        // From the grid to the unit cube, then to the world.
        let cells = self.cells();
        let image = normal * cells;
        let length = image.length();
        length / (cells.x * cells.y * cells.z) * self.placement.area_stretch(image / length)
    }

    /// One of the cells that the surface goes through, an axis, a line along it through the cell, and where
    /// it meets the surface: along an axis the function is linear, so at most once. `None` where it doesn't.
    pub fn sample(&self, u: [f64; 2]) -> Option<AreaSample> {
        let crossed = &self.data.crossed;
        let at = u[0] * 3.0 * crossed.len() as f64;
        let choice = (at as usize).min(3 * crossed.len() - 1);
        let cell = crossed[choice / 3];
        let at_cell = place(self.data.pyramid.size(), cell as usize);
        let corners = self.data.corners(at_cell);
        let at = on_line(&corners, choice % 3, [(at - choice as f64).clamp(0.0, 1.0), u[1]])?;
        let surface = self.surface_at(at_cell, at);
        let density = self.area_density(&surface.point);
        Some(AreaSample { surface, triangle: cell, barycentric: [0.0; 2], density })
    }

    /// Density per area with which a sample is the point.
    pub fn area_density(&self, point: &SurfacePoint) -> f64 {
        let normal = self.placement.pose.local_normal(point.normal) / self.cells();
        let normal = normal.normalize_or_zero();
        let lines = 3.0 * self.data.crossed.len() as f64;
        normal.abs().element_sum() / (lines * self.area_stretch(normal))
    }
}

fn hit(t: f64, cell: u32) -> Hit {
    Hit { t, shape: 0, triangle: cell, instance: NO_INSTANCE, barycentric: [0.0; 2] }
}

/// The smallest box around the surface, to an eighth of a cell.
fn bounds(data: &SdfData, placement: &Placement) -> Bounds {
    const PARTS: usize = 8;
    let size = data.pyramid.size();
    let cells = Vec3::from_array(size.map(|cells| cells as f64));
    let corner = |cell: u32| Vec3::from_array(place(size, cell as usize).map(|i| i as f64));
    let reach = |direction: Vec3| {
        let beyond = direction.max(Vec3::ZERO).element_sum();
        let mut by_reach: Vec<(f64, u32)> =
            data.crossed.iter().map(|&cell| (direction.dot(corner(cell)) + beyond, cell)).collect();
        by_reach.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut best = f64::NEG_INFINITY;
        for (most, cell) in by_reach {
            if most <= best {
                break;
            }
            let values = data.corners(place(size, cell as usize));
            for part in 0..PARTS * PARTS * PARTS {
                let scale = 1.0 / PARTS as f64;
                let min = Vec3::from_array(place([PARTS; 3], part).map(|i| i as f64 * scale));
                let reach = direction.dot(corner(cell) + min) + beyond * scale;
                let part = Bounds { min, max: min + Vec3::splat(scale) };
                // Over a box the interpolation has its extremes at corners.
                let at_corner = |at: Vec3| interpolate(&values, at.to_array());
                if reach > best
                    && !part.corners().all(|at| at_corner(at) > 0.0)
                    && !part.corners().all(|at| at_corner(at) < 0.0)
                {
                    best = reach;
                }
            }
        }
        best
    };
    let ends = |sign: f64| {
        let along = |axis: Vec3| placement.pose.linear.transpose() * (axis * sign) / cells;
        placement.pose.origin + sign * Vec3::from_array(Vec3::AXES.map(|axis| reach(along(axis))))
    };
    Bounds { min: ends(-1.0), max: ends(1.0) }
}
