//! Rays in lanes against the facets of a small scene.
//!
//! In node space the ray o + t d meets the plane of a facet at t = -h(o) / h(d), where v = v(o + t d); see
//! [`super::few`] for h, v and w. These are tested in `f32`, and what may be met is tested exactly.
//!
//! With u = 2⁻²⁴, origins up to [`FARTHEST`] away and a gradient of length g, a value at the origin errs by
//! less than 77 u g, and the change along the ray by less than 5 u g. So t, as far as it counts, errs by less
//! than 160 u / |h(d)|, and v by less than 320 u (1 + g) / |h(d)|: [`MARGIN`] is twice that. A line that
//! passes farther within a covered facet than that is sure to meet it. What the exact test finds is closer to
//! the facet than rounding here, and multiply-adds may be fused or not: candidates may differ, but not the
//! answer.

use super::few::{Few, FewSphere, MOST, Tested, halves, mask};
use super::rays::{Hits, NO_FACET, Rays};
use super::segments::RayLanes;
use crate::geometry::Vec3;
use crate::lanes::{LANES, Mask, REGISTERS, Real, Register, Row, Truth, WIDTH, part};
use smallvec::SmallVec;
use wide::f32x8;

/// By how much the tests err toward a hit, where the gradient is small and the ray perpendicular.
const MARGIN: f32 = 640.0 / (1 << 24) as f32;

/// The greatest coordinate of an origin, in node space, for which the bounds hold, and more than any distance
/// from there to a surface.
const FARTHEST: (f32, f32) = (8.0, 16.0);

/// Where a way leads less than one over this off the facet that it leaves, it runs along it, and on which
/// side is not sure.
pub(super) const ALONG: f32 = 1e5;

/// Stands for a facet that no ray counts as its own.
const NEVER_LEFT: f32 = -2.0;

/// What rays ask of a facet.
#[derive(Clone, Copy, Debug)]
pub(super) struct RayFacet {
    /// The gradients of height, v and w, each with the value at the origin of node space.
    functions: [[f32; 4]; 3],
    /// What t, v and w are uncertain by, times |h(d)|.
    slack: f32,
    /// Whether a ray that leaves one of its triangles cannot meet any of them: they are of one mesh, whose
    /// bound on errors is for all of it.
    is_left_whole: bool,
    is_covered: bool,
}

impl RayFacet {
    /// `functions`: gradient and value of height, v and w, where they are known.
    pub fn new(functions: Option<&[(Vec3, f64); 3]>, is_left_whole: bool, is_covered: bool) -> Self {
        let none = [(Vec3::ZERO, 0.0); 3];
        let functions = functions.unwrap_or(&none);
        let single = |(gradient, value): (Vec3, f64)| {
            [gradient.x as f32, gradient.y as f32, gradient.z as f32, value as f32]
        };
        let steepest = functions[1..].iter().fold(0.0f64, |most, (gradient, _)| most.max(gradient.length()));
        Self {
            functions: functions.map(single),
            slack: MARGIN * (1.0 + steepest as f32),
            is_left_whole,
            is_covered,
        }
    }

    /// Whether what leaves one of its triangles, or ends before it, cannot meet any of them.
    pub fn is_left_whole(&self) -> bool {
        self.is_left_whole
    }

    /// Whether every line that passes well within it meets one of its triangles.
    pub fn is_covered(&self) -> bool {
        self.is_covered
    }
}

/// Rays as facets ask for them, in two halves of the lanes.
struct Halves {
    /// In node space.
    origin: [[f32x8; 3]; 2],
    direction: [[f32x8; 3]; 2],
    /// How far they go.
    reach: [f32x8; 2],
    leaves: [f32x8; 2],
    arrives: [f32x8; 2],
    /// Lanes from so near that the bounds hold.
    sure: [f32x8; 2],
}

/// What is known of the rays at one facet.
struct AtFacet {
    /// Lanes that may meet it within their reach, and lanes that are sure to.
    near: [f32x8; 2],
    within: [f32x8; 2],
    /// Bounds of the distance, where it is met.
    low: [f32x8; 2],
    high: [f32x8; 2],
}

#[inline(always)]
fn single(row: &Row) -> [f32x8; 2] {
    let mut values = [0.0; LANES];
    for (register, numbers) in row.iter().enumerate() {
        for (lane, &number) in numbers.as_array().iter().enumerate() {
            values[WIDTH * register + lane] = number as f32;
        }
    }
    halves(&values)
}

impl Halves {
    #[inline(always)]
    fn new(few: &Few, rays: &Rays) -> Self {
        let places = rays.origin.map(|origin| few.space.place_lanes(origin));
        let of_axis = |of: fn(&crate::lanes::Vec3Lanes) -> Register, vectors: &[_; REGISTERS]| {
            single(&vectors.each_ref().map(of))
        };
        let axes = |vectors: &[_; REGISTERS]| {
            let [x, y, z] = [of_axis(|v| v.x, vectors), of_axis(|v| v.y, vectors), of_axis(|v| v.z, vectors)];
            [0, 1].map(|half| [x[half], y[half], z[half]])
        };
        let scale = Register::splat(few.space.scale());
        let farthest = f32x8::splat(FARTHEST.1);
        let origin = axes(&places);
        let bound = f32x8::splat(FARTHEST.0);
        let sure =
            origin.map(|[x, y, z]| x.abs().simd_le(bound) & y.abs().simd_le(bound) & z.abs().simd_le(bound));
        Self {
            origin,
            direction: axes(&rays.direction),
            reach: single(&rays.t_max.map(|t| t * scale)).map(|reach| reach.fast_min(farthest)),
            leaves: single(&rays.leaves),
            arrives: single(&rays.arrives),
            sure,
        }
    }

    #[inline(always)]
    fn at(&self, facet: &RayFacet, number: usize) -> AtFacet {
        let number = f32x8::splat(if facet.is_left_whole { number as f32 } else { NEVER_LEFT });
        let none = [f32x8::ZERO; 2];
        let mut at = AtFacet { near: none, within: none, low: none, high: none };
        for half in 0..2 {
            let dot = |function: usize, [x, y, z]: [f32x8; 3]| {
                let [a, b, c, _] = facet.functions[function].map(f32x8::splat);
                x.mul_add(a, y.mul_add(b, z * c))
            };
            let value = |function: usize, place: [f32x8; 3]| {
                let [a, b, c, constant] = facet.functions[function].map(f32x8::splat);
                place[0].mul_add(a, place[1].mul_add(b, place[2].mul_add(c, constant)))
            };
            let (origin, direction) = (self.origin[half], self.direction[half]);
            let inverse = f32x8::ONE / dot(0, direction);
            let t = -value(0, origin) * inverse;
            let slack = inverse.abs() * f32x8::splat(facet.slack);
            let [x, y, z] = [0, 1, 2].map(|axis: usize| direction[axis].mul_add(t, origin[axis]));
            // How far within the facet, in units of its edges.
            let within = [1, 2].map(|function| {
                let place = value(function, [x, y, z]);
                place.fast_min(f32x8::ONE - place)
            });
            let within = within[0].fast_min(within[1]);
            let (low, high) = (t - slack, t + slack);
            // Also what is no number may be met.
            let own = self.leaves[half].simd_eq(number) | self.arrives[half].simd_eq(number);
            let own = own & inverse.abs().simd_lt(self.reach[half] * f32x8::splat(ALONG));
            let missed =
                own | within.simd_lt(-slack) | high.simd_lt(f32x8::ZERO) | low.simd_gt(self.reach[half]);
            at.near[half] = !missed;
            at.within[half] = within.simd_gt(slack) & low.simd_gt(f32x8::ZERO) & !missed;
            at.within[half] &= high.simd_lt(self.reach[half]) & self.sure[half];
            (at.low[half], at.high[half]) = (low, high);
        }
        if !facet.is_covered {
            at.within = none;
        }
        at
    }
}

/// Lanes whose directions are near unit length: as for single rays, nothing else meets anything.
#[inline(always)]
fn sound(rays: &Rays) -> Mask {
    let mut sound = 0;
    for (register, direction) in rays.direction.iter().enumerate() {
        let is_sound = direction.length_squared().le(Register::splat(4.0));
        sound |= is_sound.mask() << (WIDTH * register);
    }
    sound
}

impl Few {
    /// The nearest hit of each ray that is asked for; see [`super::Accel::closest`].
    pub fn closest(&self, rays: &Rays, asked: Mask, hits: &mut Hits) {
        let asked = asked & sound(rays);
        let halves = Halves::new(self, rays);
        let unsure = asked & !mask(halves.sure);
        // Lanes that may meet each facet, and from what distance on.
        let mut found: SmallVec<[(Mask, [f32x8; 2]); MOST]> = SmallVec::new();
        // The nearest facet that is surely met.
        let mut high = [f32x8::splat(f32::INFINITY); 2];
        for (number, facet) in self.facets.iter().enumerate() {
            let at = halves.at(&facet.rays, number);
            found.push(match facet.always {
                true => (asked, [f32x8::ZERO; 2]),
                false => (asked & mask(at.near) | unsure, at.low),
            });
            for half in 0..2 {
                let bound = at.within[half].select(at.high[half], f32x8::splat(f32::INFINITY));
                high[half] = high[half].fast_min(bound);
            }
        }
        let mut nearest = Nearest::new(rays);
        let tested: [RayLanes; REGISTERS] =
            std::array::from_fn(|register| RayLanes::new(rays.origin[register], rays.direction[register]));
        for (number, (facet, (lanes, low))) in self.facets.iter().zip(&found).enumerate() {
            let nearer = mask([0, 1].map(|half| low[half].simd_le(high[half])));
            let lanes = lanes & (nearer | unsure);
            if lanes != 0 {
                nearest.test(facet, number, &tested, lanes);
            }
        }
        for sphere in &self.spheres {
            nearest.test_sphere(sphere, rays, asked);
        }
        for register in 0..REGISTERS {
            let met = nearest.number[register].ge(Register::ZERO).mask();
            hits.met |= met << (WIDTH * register);
        }
        hits.t = nearest.t;
        hits.known = nearest.number;
        hits.facet = nearest.facet;
        hits.barycentric = nearest.barycentric;
    }

    /// Which of the rays that are asked for meet anything; see [`super::Accel::occluded`].
    pub fn occluded(&self, rays: &Rays, asked: Mask) -> Mask {
        let asked = asked & sound(rays);
        let halves = Halves::new(self, rays);
        let unsure = asked & !mask(halves.sure);
        let mut candidates: SmallVec<[Mask; MOST]> = SmallVec::new();
        let mut occluded = 0;
        for (number, facet) in self.facets.iter().enumerate() {
            let at = halves.at(&facet.rays, number);
            candidates.push(if facet.always { asked } else { asked & mask(at.near) | unsure });
            occluded |= mask(at.within) & asked;
        }
        for (facet, &candidates) in self.facets.iter().zip(&candidates) {
            let lanes = candidates & !occluded;
            if lanes == 0 {
                continue;
            }
            for register in 0..REGISTERS {
                let lanes = part(lanes, register);
                if lanes == 0 {
                    continue;
                }
                let ray = RayLanes::new(rays.origin[register], rays.direction[register]);
                for triangle in &facet.triangles {
                    let Some(found) = ray.cross(triangle) else { continue };
                    let in_range = found.t.ge(Register::ZERO) & found.t.lt(rays.t_max[register]);
                    occluded |= ((found.inside & in_range).mask() & lanes) << (WIDTH * register);
                }
            }
        }
        for sphere in &self.spheres {
            for register in 0..REGISTERS {
                let open = part(asked & !occluded, register);
                let (origin, direction) = (rays.origin[register], rays.direction[register]);
                let Some((t, met)) = sphere.distance(origin, direction, rays.t_max[register], open) else {
                    continue;
                };
                let met = (met & t.lt(rays.t_max[register])).mask() & open;
                occluded |= met << (WIDTH * register);
            }
        }
        occluded
    }
}

/// The nearest hits so far.
struct Nearest {
    t: Row,
    /// Triangle and facet; -1 for none.
    number: Row,
    facet: Row,
    barycentric: [Row; 2],
}

impl Nearest {
    fn new(rays: &Rays) -> Self {
        let none = [Register::splat(-1.0); REGISTERS];
        Self { t: rays.t_max, number: none, facet: none, barycentric: [[Register::ZERO; REGISTERS]; 2] }
    }

    /// Tests the triangles of a facet against the rays of some lanes.
    #[inline(always)]
    fn test(&mut self, facet: &Tested, number: usize, rays: &[RayLanes; REGISTERS], lanes: Mask) {
        for register in 0..REGISTERS {
            let lanes = part(lanes, register);
            if lanes == 0 {
                continue;
            }
            for (triangle, &own) in facet.triangles.iter().zip(&facet.numbers) {
                let Some(found) = rays[register].cross(triangle) else { continue };
                let own = Register::splat(own);
                let (nearest, known) = (self.t[register], self.number[register]);
                // The order of the facets must not decide between hits at the same distance.
                let nearer = found.t.lt(nearest) | found.t.eq(nearest) & own.lt(known);
                let hit = Truth::of(lanes) & found.inside & found.t.ge(Register::ZERO) & nearer;
                if hit.mask() == 0 {
                    continue;
                }
                self.t[register] = Register::choose(hit, found.t, nearest);
                self.number[register] = Register::choose(hit, own, known);
                self.facet[register] =
                    Register::choose(hit, Register::splat(number as f64), self.facet[register]);
                for (row, part) in self.barycentric.iter_mut().zip([found.v, found.w]) {
                    row[register] = Register::choose(hit, part / found.determinant, row[register]);
                }
            }
        }
    }

    /// The same of a sphere.
    #[inline(always)]
    fn test_sphere(&mut self, sphere: &FewSphere, rays: &Rays, lanes: Mask) {
        let own = Register::splat(sphere.number);
        for register in 0..REGISTERS {
            let lanes = part(lanes, register);
            let (origin, direction) = (rays.origin[register], rays.direction[register]);
            let (nearest, known) = (self.t[register], self.number[register]);
            let Some((t, met)) = sphere.distance(origin, direction, nearest, lanes) else { continue };
            let hit = Truth::of(lanes) & met & (t.lt(nearest) | t.eq(nearest) & own.lt(known));
            if hit.mask() == 0 {
                continue;
            }
            self.t[register] = Register::choose(hit, t, nearest);
            self.number[register] = Register::choose(hit, own, known);
            self.facet[register] = Register::choose(hit, Register::splat(NO_FACET), self.facet[register]);
            for row in &mut self.barycentric {
                row[register] = (!hit).only(row[register]);
            }
        }
    }
}
