//! Bicubic Bézier patches (Newell's teapot is made of them), each a surface by itself for the acceleration
//! structure.

mod bicubic;
mod curve;
mod extent;
mod intersection;
mod monotonicity;
mod root;
mod sampling;

use super::crossing::{Crossing, Crossings};
use super::{Hit, NO_INSTANCE, Parametrisation, ShapeError, SurfaceHit};
use crate::geometry::{Bounds, Ray, SurfacePoint, Transform, Vec3};
use bicubic::Bicubic;
use glam::DMat3;
use intersection::{Anchored, LineHit, line_hits};
use sampling::Table;
use std::array::from_fn;
use std::sync::{Arc, OnceLock};

/// Control points of a patch, row by row: the first four lie along u, where v is 0.
pub type ControlNet = [Vec3; 16];

/// Bicubic Bézier patches.
///
/// The normal is that of ∂p/∂u × ∂p/∂v and stays on its side of the surface wherever a transform takes it.
/// Each patch has uv of its own. Hits carry the patch as their triangle and uv as barycentric coordinates.
/// Borders that two patches share by the same control points are met by at least one of them, and a border
/// may be a single point.
#[derive(Clone, Debug)]
pub struct Patches {
    shared: Arc<Shared>,
    inward: bool,
}

#[derive(Debug)]
struct Shared {
    patches: Vec<Placed>,
    /// Only lights ask for it.
    table: OnceLock<Table>,
}

/// A patch in world space.
#[derive(Debug)]
struct Placed {
    anchored: Anchored,
    bounds: Bounds,
}

/// A vector across the patch, of any length: ∂p/∂u × ∂p/∂v, or where that vanishes what it is beside there.
fn normal(points: &Bicubic<Vec3>, at: [f64; 2]) -> Vec3 {
    /// Step toward the middle: far above rounding, far below the distance over which normals change.
    const BESIDE: f64 = 1e-6;
    let normal_at = |at: [f64; 2]| {
        let [along_u, along_v] = points.slopes(at);
        along_u.cross(along_v)
    };
    let largest = points.all().fold(0.0, |most: f64, point| most.max(point.length_squared()));
    let here = normal_at(at);
    if here.length() > 1e-12 * largest { here } else { normal_at(at.map(|a| a + (0.5 - a) * BESIDE)) }
}

impl Placed {
    fn new(to_world: &Transform, control: &ControlNet) -> Self {
        let world = control.map(|point| to_world.point(point));
        let middle = Bounds::of(world).centre();
        let points = Bicubic(from_fn(|i| from_fn(|j| world[4 * j + i] - middle)));
        let reach = points.all().fold(0.0, |most: f64, point| most.max(point.length()));
        let extent = extent::of(&points, reach);
        let bounds = Bounds { min: middle + extent.min, max: middle + extent.max };
        Self { anchored: Anchored { middle, points, reach }, bounds }
    }
}

impl Patches {
    /// Under `to_world`; normals are turned around by `flip_normals`.
    ///
    /// # Errors
    /// No patch, too many, or control points that are not finite or too far away to compute with.
    pub fn new(to_world: &Transform, patches: &[ControlNet], flip_normals: bool) -> Result<Self, ShapeError> {
        if patches.is_empty() {
            return Err(ShapeError::Nothing);
        }
        if u32::try_from(patches.len()).is_err() {
            return Err(ShapeError::TooLarge);
        }
        // Nothing overflows that is computed from them.
        let far = |point: &Vec3| {
            let place = to_world.point(*point).abs().max_element();
            !place.is_finite() || place > 1e70
        };
        if patches.iter().flatten().any(far) {
            return Err(ShapeError::Placement);
        }
        let mirrors = DMat3::from_mat4(to_world.matrix()).determinant() < 0.0;
        let patches = patches.iter().map(|control| Placed::new(to_world, control)).collect();
        let shared = Arc::new(Shared { patches, table: OnceLock::new() });
        Ok(Self { shared, inward: flip_normals != mirrors })
    }

    /// Number of patches.
    pub fn count(&self) -> usize {
        self.shared.patches.len()
    }

    fn patch(&self, patch: u32) -> &Anchored {
        &self.shared.patches[patch as usize].anchored
    }

    /// The nearest hit of all patches, found one by one.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let hits = (0..self.count() as u32).filter_map(|patch| self.intersect_patch(patch, ray));
        hits.reduce(|nearest, hit| if hit.t < nearest.t { hit } else { nearest })
    }

    /// The nearest hit of a patch.
    pub fn intersect_patch(&self, patch: u32, ray: &Ray) -> Option<Hit> {
        let found = line_hits(ray.origin, ray.direction, self.patch(patch));
        let ahead = found.iter().filter(|line_hit| line_hit.t >= 0.0 && line_hit.t < ray.t_max);
        ahead.min_by(|a, b| a.t.total_cmp(&b.t)).map(|line_hit| hit(patch, line_hit))
    }

    /// All crossings along the whole line.
    pub fn crossings(&self, ray: &Ray) -> Crossings {
        let all = (0..self.count() as u32).flat_map(|patch| self.patch_crossings(patch, ray));
        let mut found: Crossings = all.collect();
        found.sort_by(|a, b| a.hit.t.total_cmp(&b.hit.t));
        found
    }

    /// Likewise of one patch.
    pub fn patch_crossings(&self, patch: u32, ray: &Ray) -> Crossings {
        let found = line_hits(ray.origin, ray.direction, self.patch(patch));
        let crossing = |line_hit: &LineHit| Crossing {
            hit: hit(patch, line_hit),
            error: line_hit.error,
            enters: line_hit.against != self.inward,
        };
        let mut crossings: Crossings = found.iter().map(crossing).collect();
        crossings.sort_by(|a, b| a.hit.t.total_cmp(&b.hit.t));
        crossings
    }

    /// The point of the surface at a hit.
    pub fn surface(&self, hit: &Hit) -> SurfaceHit {
        self.surface_at(hit.triangle, hit.barycentric)
    }

    fn surface_at(&self, patch: u32, at: [f64; 2]) -> SurfaceHit {
        let Anchored { middle, points, reach } = self.patch(patch);
        let position = *middle + points.value(at);
        let outward = normal(points, at).try_normalize().unwrap_or(Vec3::Z);
        let normal = if self.inward { -outward } else { outward };
        // The point's own rounding and that of a ray that starts there, and what both are off by in the
        // patch's coordinates.
        let error = f64::EPSILON * (4.0 * position.abs().max_element() + 96.0 * reach);
        SurfaceHit { point: SurfacePoint { position, normal, error }, shading_normal: normal }
    }

    /// Each patch's own.
    pub fn parametrisation(&self, hit: &Hit) -> Parametrisation {
        let [tangent, bitangent] = self.patch(hit.triangle).points.slopes(hit.barycentric);
        Parametrisation { uv: hit.barycentric, tangent, bitangent }
    }

    /// A box around a patch.
    pub fn patch_bounds(&self, patch: u32) -> Bounds {
        self.shared.patches[patch as usize].bounds
    }

    /// A box around all patches.
    pub fn bounds(&self) -> Bounds {
        Bounds::of_all(self.shared.patches.iter().map(|patch| patch.bounds))
    }
}

fn hit(patch: u32, line_hit: &LineHit) -> Hit {
    Hit { t: line_hit.t, shape: 0, triangle: patch, instance: NO_INSTANCE, barycentric: line_hit.at }
}
