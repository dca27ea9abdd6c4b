//! A group of shapes somewhere else, as often as one likes: the group has a tree of its own, in its own
//! coordinates, and a ray is taken there. What moves is such a group, and the ray is taken to where it is at
//! the ray's time. A group may show other groups: a ray is taken from one to the next.

use super::Accel;
use super::hull::{Ball, turns_boxes};
use super::watch::Watch;
use crate::geometry::{Bounds, Placed, Pose, Ray, Transform, Vec3};
use crate::shape::{AtRest, Hit, NO_INSTANCE, Parametrisation, Shape, SurfaceHit};
use std::sync::Arc;

/// A group where its transform puts it.
#[derive(Clone, Debug)]
pub struct Instance {
    group: Arc<Accel>,
    placed: Placed,
    /// Where the group is at rest, see [`AtRest`].
    rest: Pose,
    /// Length of the diagonal of the group's box.
    reach: f64,
    /// A ball around it in world space, where that is a smaller target than its box.
    ball: Option<Ball>,
}

/// Most boxes by which something that moves is bounded.
const MOST_SLICES: usize = 64;

/// What it costs to find that a slice is not the ray's, in tests of an instance.
const SLICE_COST: f64 = 0.05;

/// A part of the time during which something moves, and the box around it meanwhile.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slice {
    pub during: [f64; 2],
    pub bounds: Bounds,
}

impl Instance {
    /// At rest it is where it stands at first.
    pub fn new(group: Arc<Accel>, placed: Placed) -> Self {
        let reach = group.bounds().diameter();
        let rest = placed.at(f64::NEG_INFINITY);
        let mut instance = Self { group, placed, rest, reach, ball: None };
        if !instance.placed.is_moving() && !instance.group.bounds().is_empty() {
            let ball = instance.group.ball().at(&rest);
            let bounds = instance.bounds([0.0; 2]);
            instance.ball = Some(ball).filter(|ball| ball.is_smaller_than(bounds));
        }
        instance
    }

    /// The same with another place at rest.
    #[must_use]
    pub fn resting(self, rest: &Transform) -> Self {
        Self { rest: Pose::new(rest), ..self }
    }

    /// An instance for a shape that is a part of a solid, which alone finds it. `bounds` are the shape's, in
    /// its own coordinates.
    pub fn of_part(bounds: Bounds, placed: Placed) -> Self {
        Self { reach: bounds.diameter(), ..Self::new(Arc::new(Accel::build(&[])), placed) }
    }

    pub(super) fn group(&self) -> &Accel {
        &self.group
    }

    /// A box around it in world space, from one time to another; empty where the group has no surface.
    ///
    /// A turned box has a larger one around it. So what stands still and is turned is bounded by the group's
    /// hull, too.
    pub fn bounds(&self, during: [f64; 2]) -> Bounds {
        let around_box = self.placed.bounds(self.group.bounds(), during);
        if self.placed.is_moving() {
            return around_box;
        }
        let pose = self.placed.at(during[0]);
        match turns_boxes(&pose) {
            true => around_box.common(self.group.hull().bounds(&pose)),
            false => around_box,
        }
    }

    /// The boxes by which it is found while the shutter is open: as many slices of that time as make the
    /// expected cost of a ray least. That cost is, for each slice, the area of its box times the cost of
    /// finding out whether the ray's time is in it and, if so, of testing the group.
    pub(super) fn slices(&self, shutter: [f64; 2]) -> Vec<Slice> {
        let always = [f64::NEG_INFINITY, f64::INFINITY];
        let mut best = vec![Slice { during: always, bounds: self.bounds(shutter) }];
        if !self.placed.is_moving() || shutter[0] == shutter[1] {
            return best;
        }
        let cost = |slices: &[Slice]| {
            let area: f64 = slices.iter().map(|slice| slice.bounds.half_area()).sum();
            area * (SLICE_COST + 1.0 / slices.len() as f64)
        };
        let mut count = 2;
        while count <= MOST_SLICES {
            let edge = |i: usize| shutter[0] + (shutter[1] - shutter[0]) * i as f64 / count as f64;
            let slices: Vec<Slice> = (0..count)
                .map(|i| {
                    [
                        if i == 0 { always[0] } else { edge(i) },
                        if i + 1 == count { always[1] } else { edge(i + 1) },
                    ]
                })
                .map(|during| {
                    let bounds = self.bounds([during[0].max(shutter[0]), during[1].min(shutter[1])]);
                    Slice { during, bounds }
                })
                .collect();
            // Each doubling makes the tree larger too.
            if cost(&slices) < 0.9 * cost(&best) {
                best = slices;
            }
            count *= 2;
        }
        best
    }

    /// The ray in the group's coordinates at a pose, and how much longer distances are there.
    fn local(&self, pose: &Pose, ray: &Ray) -> (Ray, f64) {
        let direction = pose.local_vector(ray.direction);
        let scale = direction.length();
        let origin = pose.local_point(ray.origin);
        // A little further, so that rounding hides no hit: the caller compares world distances.
        let t_max = ray.t_max * scale * (1.0 + 4.0 * f64::EPSILON);
        (Ray { origin, direction: direction / scale, t_max }, scale)
    }

    /// Whether a ray surely misses it.
    #[inline(always)]
    fn misses(&self, ray: &Ray) -> bool {
        self.ball.is_some_and(|ball| ball.misses(ray))
    }

    /// The nearest hit with 0 ≤ t < about `ray.t_max`, without the instance's own index.
    ///
    /// Never inlined, like the next: the loop that calls it is for scenes without instances too.
    #[inline(never)]
    pub(super) fn closest(&self, ray: &Ray, time: f64, watch: impl Watch) -> Option<Hit> {
        if self.misses(ray) {
            return None;
        }
        let (local, scale) = self.local(&self.placed.at(time), ray);
        let hit = self.group.closest_watched(&local, time, watch)?;
        Some(Hit { t: hit.t / scale, ..hit })
    }

    #[inline(never)]
    pub(super) fn occluded(&self, ray: &Ray, time: f64, watch: impl Watch) -> bool {
        !self.misses(ray)
            && self.group.occluded_watched(&self.local(&self.placed.at(time), ray).0, time, watch)
    }

    /// See [`Accel::crossings`]; without the instance's own index.
    pub(super) fn crossings(
        &self,
        ray: &Ray,
        time: f64,
        range: [f64; 2],
        report: &mut dyn FnMut(Hit, Option<f64>),
    ) {
        let (local, scale) = self.local(&self.placed.at(time), ray);
        self.group.crossings(&local, time, range.map(|t| t * scale), &mut |hit, error| {
            report(Hit { t: hit.t / scale, ..hit }, error.map(|error| error / scale));
        });
    }

    /// The surface where `ray` hit it, of one of the group's shapes or of what the group shows: the hit
    /// carries what the group knows it by. `shapes` are all to which hits refer.
    #[inline(never)]
    pub(super) fn surface(&self, shapes: &[Shape], hit: &Hit, ray: &Ray, time: f64) -> SurfaceHit {
        let pose = self.placed.at(time);
        let (local_ray, scale) = self.local(&pose, ray);
        let local = self.group.surface(shapes, &Hit { t: hit.t * scale, ..*hit }, &local_ray, time);
        let point = self.placed.surface_point(&pose, &local.point, self.reach);
        let shading_normal = pose.world_normal(local.shading_normal).try_normalize().unwrap_or(point.normal);
        SurfaceHit { point, shading_normal }
    }

    /// The coordinates of a point of the group's, as in [`Self::surface`], and where it is at rest.
    #[inline(never)]
    pub(super) fn parametrisation(
        &self,
        shapes: &[Shape],
        hit: &Hit,
        position: Vec3,
        time: f64,
    ) -> (Parametrisation, AtRest) {
        let pose = self.placed.at(time);
        let position = pose.local_point(position);
        let (local, inner) = self.group.parametrisation(shapes, hit, position, time);
        let here = Parametrisation {
            uv: local.uv,
            tangent: pose.world_vector(local.tangent),
            bitangent: pose.world_vector(local.bitangent),
        };
        // The innermost instance says where it is at rest.
        let at_rest = match hit.instance {
            NO_INSTANCE => AtRest {
                position: self.rest.world_point(position),
                tangents: [local.tangent, local.bitangent].map(|tangent| self.rest.world_vector(tangent)),
            },
            _ => inner,
        };
        (here, at_rest)
    }
}
