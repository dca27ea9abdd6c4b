//! Nodes of eight boxes, and the one-sided error of testing a ray against them in `f32`.

use crate::geometry::{Bounds, Ray, Vec3};
use crate::lanes::{Register, Vec3Lanes};
use std::hint::{black_box, select_unpredictable};
use std::ops::Range;
use wide::f32x8;

/// Half a unit in the last place of 1 in `f32`.
const U32: f64 = 1.0 / (1u32 << 24) as f64;

/// By how much exits are moved away; see [`NodeRay`].
const EXIT_SCALE: f32 = 1.0 + 32.0 * U32 as f32;

/// How many children a node has at most.
pub(super) const WIDTH: usize = 8;

/// The coordinates of nodes: those of the world moved and scaled (by a power of two), so that the scene
/// just fits into [-1, 1]³. Then one bound on rounding errors holds for all scenes.
#[derive(Clone, Copy, Debug)]
pub(super) struct NodeSpace {
    centre: Vec3,
    scale: f64,
    /// In node space.
    bounds: Bounds,
}

impl NodeSpace {
    pub fn new(scene: Bounds) -> Self {
        let centre = scene.centre();
        let half = (0.5 * (scene.max - scene.min)).max_element();
        // Also finite where all surfaces lie in one point.
        let scale = if half > 1e-300 { 0.5f64.powi(half.log2().ceil() as i32) } else { 1.0 };
        let mut space = Self { centre, scale, bounds: scene };
        space.bounds = space.of(scene);
        space
    }

    pub fn of(&self, world: Bounds) -> Bounds {
        Bounds { min: self.place(world.min), max: self.place(world.max) }
    }

    pub fn place(&self, world: Vec3) -> Vec3 {
        (world - self.centre) * self.scale
    }

    /// The box in world space, up to rounding.
    pub fn in_world(&self, bounds: Bounds) -> Bounds {
        let world = |place: Vec3| place / self.scale + self.centre;
        Bounds { min: world(bounds.min), max: world(bounds.max) }
    }

    pub fn place_lanes(&self, world: Vec3Lanes) -> Vec3Lanes {
        (world - Vec3Lanes::of(self.centre)) * Register::splat(self.scale)
    }

    pub fn scale(&self) -> f64 {
        self.scale
    }
}

/// A ray in node space, with all that the box test can precompute.
///
/// The slab test finds where the ray meets the planes x = b: t = b·i - o·i with i = 1/d. In `f32`, with
/// u = 2⁻²⁴, coordinates at most 1 and the origin within the scene's box:
/// - rounding o, o·i and b·i (where no fused multiply-add is at hand) moves the plane by at most 4u;
/// - rounding d and i scales t by at most 1 ± 2u, on every axis by another factor.
///
/// Entries are computed from an origin moved forward by 8u and exits from one moved back by as much and
/// scaled by 1 + 32u: whenever the true ray meets a box, the computed entry does not exceed the computed
/// exit.
pub(super) struct NodeRay {
    /// Which of a slab's two planes is entered first, for each axis.
    sign: [usize; 3],
    /// 1/d and -o/d, with o moved forward. One number each: to load it into all lanes takes no longer than to
    /// load eight.
    enter: [(f32, f32); 3],
    /// Likewise with o moved back, and scaled.
    leave: [(f32, f32); 3],
    t_max: f32,
    /// How far (in node space) the ray was advanced before it was rounded.
    advance: f64,
}

impl NodeRay {
    /// `None` for rays that miss the scene's box, and for those that are not numbers.
    #[inline(always)]
    pub fn new(space: &NodeSpace, ray: &Ray) -> Option<Self> {
        // Directions have unit length; this stops what isn't even near it before it can make NaN.
        if ray.direction.length_squared().is_nan() || ray.direction.length_squared() > 4.0 {
            return None;
        }
        let origin = (ray.origin - space.centre) * space.scale;
        let size = origin.abs().max_element();
        // Far away even f64 rounds noticeably: the boxes are then enlarged in proportion.
        let slack = 8.0 * U32 + 8.0 * f64::EPSILON * size;
        let mut advance = 0.0;
        let mut start = origin;
        if size > 1.0 {
            let (enter, leave) = slab(space.bounds, slack, origin, ray.direction);
            if !(enter <= leave && enter <= ray.t_max * space.scale) {
                return None;
            }
            advance = enter;
            start = origin + ray.direction * advance;
        } else if !(size <= 1.0 && ray.t_max > 0.0) {
            return None;
        }
        let mut sign = [0; 3];
        let (mut enter, mut leave) = ([(0.0, 0.0); 3], [(0.0, 0.0); 3]);
        for axis in 0..3 {
            let d = ray.direction[axis];
            // Along such a component a ray within the scene moves by far less than the slack.
            let d = if d.abs() < 1e-18 { 1e-18f64.copysign(d) } else { d };
            let inverse = 1.0 / d as f32;
            let slack = slack.copysign(d);
            sign[axis] = usize::from(d < 0.0);
            let plane = |inverse: f32, origin: f64| (inverse, -(origin as f32) * inverse);
            enter[axis] = plane(inverse, start[axis] + slack);
            leave[axis] = plane(inverse * EXIT_SCALE, start[axis] - slack);
        }
        let mut node_ray = Self { sign, enter, leave, t_max: 0.0, advance };
        node_ray.shorten(space, ray.t_max);
        Some(node_ray)
    }

    /// Ends the ray at the world distance `t`.
    #[inline(always)]
    pub fn shorten(&mut self, space: &NodeSpace, t: f64) {
        self.t_max = (t * space.scale - self.advance) as f32 * EXIT_SCALE;
    }

    /// In node space, measured from where the ray enters the scene's box.
    pub fn t_max(&self) -> f32 {
        self.t_max
    }
}

/// Where a ray is within an enlarged box: entry (not before 0) and exit.
#[inline(never)]
fn slab(bounds: Bounds, slack: f64, origin: Vec3, direction: Vec3) -> (f64, f64) {
    let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
    for axis in 0..3 {
        let (low, high) = (bounds.min[axis] - slack - origin[axis], bounds.max[axis] + slack - origin[axis]);
        if direction[axis] == 0.0 {
            if low > 0.0 || high < 0.0 {
                return (f64::INFINITY, 0.0);
            }
            continue;
        }
        let (a, b) = (low / direction[axis], high / direction[axis]);
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    (enter, leave)
}

/// What a node's slot holds: a node, some packets of triangles, or some other surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Child(u32);

impl Child {
    const LEAF: u32 = 1 << 31;
    const OTHER: u32 = 1 << 30;
    const COUNT_SHIFT: u32 = 27;
    const INDEX: u32 = (1 << Self::COUNT_SHIFT) - 1;
    /// What unused slots hold. Their boxes are empty, so it is never visited.
    pub const EMPTY: Self = Self(u32::MAX);

    pub fn of_node(index: usize) -> Self {
        Self(index as u32)
    }

    /// `first + count` must stay below 2²⁷ and 1 ≤ `count` ≤ 8.
    pub fn leaf(first: usize, count: usize, other: bool) -> Self {
        let kind = if other { Self::LEAF | Self::OTHER } else { Self::LEAF };
        Self(kind | ((count as u32 - 1) << Self::COUNT_SHIFT) | first as u32)
    }

    pub fn node(self) -> Option<usize> {
        (!self.is_leaf()).then_some(self.0 as usize)
    }

    pub fn is_leaf(self) -> bool {
        self.0 & Self::LEAF != 0
    }

    /// Index of the node, or of the first item of the leaf.
    pub fn index(self) -> usize {
        let of_node = self.0 & !Self::LEAF;
        select_unpredictable(self.is_leaf(), self.0 & Self::INDEX, of_node) as usize
    }

    pub fn to_bits(self) -> u32 {
        self.0
    }

    pub fn from_bits(bits: u32) -> Self {
        Self(bits)
    }

    /// The same where its lists come behind so many nodes, packets and others.
    fn moved(self, nodes: usize, packets: usize, others: usize) -> Self {
        let by = match self {
            Self::EMPTY => 0,
            _ if !self.is_leaf() => nodes,
            _ if self.is_other() => others,
            _ => packets,
        };
        Self(self.0 + by as u32)
    }

    pub fn is_other(self) -> bool {
        self.0 & Self::OTHER != 0
    }

    pub fn items(self) -> Range<usize> {
        let first = (self.0 & Self::INDEX) as usize;
        first..first + ((self.0 >> Self::COUNT_SHIFT) & 7) as usize + 1
    }
}

/// A number less than `x`, and none that is subnormal: with those processors compute a hundred times as long.
fn below(x: f64) -> f32 {
    let below = (x as f32).next_down();
    if below.is_subnormal() { -f32::MIN_POSITIVE } else { below }
}

/// Likewise greater.
fn above(x: f64) -> f32 {
    -below(-x)
}

/// Begins where a cache line does.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Node {
    /// Per axis the lower and the upper planes of the eight boxes.
    planes: [[f32x8; 2]; 3],
    children: [Child; 8],
}

impl Node {
    /// `boxes` are in node space and at most eight. The children are still to be set.
    pub fn new(boxes: &[Bounds]) -> Self {
        let plane = |axis: usize, side: usize| {
            f32x8::new(std::array::from_fn(|lane| match boxes.get(lane) {
                Some(bounds) if side == 0 => below(bounds.min[axis]),
                Some(bounds) => above(bounds.max[axis]),
                None if side == 0 => f32::INFINITY,
                None => f32::NEG_INFINITY,
            }))
        };
        Self {
            planes: std::array::from_fn(|axis| [plane(axis, 0), plane(axis, 1)]),
            children: [Child::EMPTY; 8],
        }
    }

    pub fn set_child(&mut self, lane: usize, child: Child) {
        self.children[lane] = child;
    }

    /// The same where what it refers to comes behind so many nodes, packets and others.
    pub fn moved(self, nodes: usize, packets: usize, others: usize) -> Self {
        Self { children: self.children.map(|child| child.moved(nodes, packets, others)), ..self }
    }

    /// How many children it has.
    pub fn len(&self) -> usize {
        self.children.iter().filter(|&&child| child != Child::EMPTY).count()
    }

    pub fn child(&self, lane: usize) -> Child {
        self.children[lane & 7]
    }

    /// Its children and their boxes in node space.
    pub fn parts(&self) -> impl Iterator<Item = (Child, Bounds)> {
        let planes = self.planes.map(|sides| sides.map(|planes| planes.to_array().map(f64::from)));
        let corner = move |lane: usize, side: usize| Vec3::from_array(planes.map(|sides| sides[side][lane]));
        let part = move |lane| (self.child(lane), Bounds { min: corner(lane, 0), max: corner(lane, 1) });
        (0..WIDTH).map(part).filter(|(child, _)| *child != Child::EMPTY)
    }

    /// A bit for every box that the ray may meet, and where it enters them.
    #[inline(always)]
    pub fn entered(&self, ray: &NodeRay) -> (u32, [f32; 8]) {
        // Else the compiler spreads the ray's numbers over eight lanes before the loop over nodes, and has no
        // registers for that: a ray that visits two nodes then takes longer for the preparation than for the
        // visits.
        let ray = black_box(ray);
        let plane = |axis: usize, side: usize, (inverse, start): (f32, f32)| {
            self.planes[axis][side & 1].mul_add(f32x8::splat(inverse), f32x8::splat(start))
        };
        let near = |axis: usize| plane(axis, ray.sign[axis], ray.enter[axis]);
        let far = |axis: usize| plane(axis, ray.sign[axis] ^ 1, ray.leave[axis]);
        let enter = near(0).fast_max(near(1)).fast_max(near(2).fast_max(f32x8::ZERO));
        let leave = far(0).fast_min(far(1)).fast_min(far(2).fast_min(f32x8::splat(ray.t_max)));
        (enter.simd_le(leave).to_bitmask(), enter.to_array())
    }
}
