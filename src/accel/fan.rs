//! Segments from several surface points to one other, all at once.

use super::Accel;
use super::few::{Clear, Crossing, Few, MOST, Sides, Tested};
use super::segments::FanSegments;
use crate::geometry::{Points, Ray, SurfacePoint};
use crate::lanes::{
    ALL, LANES, Mask, REGISTERS, Real, Register, Row, Vec3Lanes, WIDTH, get, lanes_of, mask_of, part,
};
use smallvec::SmallVec;

/// Surface points, one for each lane, and what is known of them before it is asked what they see.
pub struct Fan<'a> {
    accel: &'a Accel,
    points: [Points<Register>; REGISTERS],
    few: Option<FewSides<'a>>,
}

/// Where the points lie for the triangles of a small scene.
struct FewSides<'a> {
    few: &'a Few,
    facets: Vec<FacetSides>,
    /// Those that nothing is known of.
    unsure: Mask,
}

/// Where the points lie for a facet.
struct FacetSides {
    sides: Sides,
    /// Those that lie in it.
    own: Mask,
    clear: Clear,
}

/// A surface point that is to be seen from others.
#[derive(Clone, Copy, Debug)]
pub struct Target<'p> {
    /// The point that is looked at.
    pub point: &'p SurfacePoint,
    /// The facet of a small scene that it lies in, as [`super::Hits::facet`] says it.
    pub facet: f64,
}

impl Accel {
    /// Points of some lanes that are to be asked, a time for each lane, what they see. `facets` are those of
    /// a small scene that they lie in.
    pub fn fan(&self, points: &[Points<Register>; REGISTERS], facets: &Row, lanes: Mask) -> Fan<'_> {
        let few = self.few.as_ref().map(|few| {
            let mut owns: SmallVec<[Mask; MOST]> = SmallVec::from_elem(0, few.facets.len());
            for lane in 0..LANES {
                // None is less than all.
                if let Some(own) = owns.get_mut(get(facets, lane) as isize as usize) {
                    *own |= 1 << lane;
                }
            }
            let sides = few.sides(&points.each_ref().map(|points| points.position));
            let is_unsure = |&lane: &usize| !few.is_sure(&points[lane / WIDTH].get(lane));
            let of_facet = |((facet, sides), own): ((&Tested, Sides), Mask)| {
                let own = if facet.rays.is_left_whole() { own } else { 0 };
                FacetSides { clear: sides.clear(lanes, own), sides, own }
            };
            FewSides {
                few,
                facets: few.facets.iter().zip(sides).zip(owns).map(of_facet).collect(),
                unsure: mask_of(lanes_of(lanes).filter(is_unsure)),
            }
        });
        Fan { accel: self, points: *points, few }
    }
}

impl Fan<'_> {
    /// The points of a register.
    #[inline(always)]
    pub fn positions(&self, register: usize) -> Vec3Lanes {
        self.points[register].position
    }

    /// Whether segments are tested against all triangles at once, without a tree.
    pub fn is_at_once(&self) -> bool {
        self.few.is_some()
    }

    /// The point of one lane.
    pub fn point(&self, lane: usize) -> SurfacePoint {
        self.points[lane / WIDTH].get(lane)
    }

    /// The lanes among those asked for whose segment to a target is occluded or does not exist. Segments are
    /// those of [`SurfacePoint::segment_to`], and the answers those of [`Accel::occluded`].
    pub fn blocked(&self, target: &Target, time: f64, asked: Mask) -> Mask {
        match &self.few {
            Some(few) => self.blocked_by_few(few, target, time, asked),
            None => self.blocked_in_tree(target.point, time, asked),
        }
    }

    fn blocked_in_tree(&self, target: &SurfacePoint, time: f64, asked: Mask) -> Mask {
        let (mut missing, mut segments) = (0, [Ray::NOWHERE; LANES]);
        for lane in lanes_of(asked) {
            match self.point(lane).segment_to(target) {
                Some(segment) => segments[lane] = segment,
                None => missing |= 1 << lane,
            }
        }
        missing | self.accel.occluded_together(&segments, time, asked & !missing)
    }

    fn blocked_by_few(&self, known: &FewSides, target: &Target, time: f64, asked: Mask) -> Mask {
        let few = known.few;
        let position = Vec3Lanes::of(target.point.position);
        let mut far = 0;
        for (register, points) in self.points.iter().enumerate() {
            // Offsets and rounding make no difference to whether such a segment exists.
            let least = (points.error + Register::splat(target.point.error)) * Register::splat(100.0);
            let squared = (position - points.position).length_squared();
            let is_far = squared.gt(least * least) & squared.gt(Register::splat(f64::MIN_POSITIVE));
            far |= is_far.mask() << (WIDTH * register);
        }
        let mut blocked = self.blocked_in_tree(target.point, time, asked & !far);
        let open = asked & far;
        let unsure = if few.is_sure(target.point) { known.unsure } else { ALL };
        let ends = few.seen(target.point.position);
        let mut candidates: SmallVec<[(&Tested, Mask); MOST]> = SmallVec::new();
        for (index, (facet, FacetSides { sides, own, clear })) in
            few.facets.iter().zip(&known.facets).enumerate()
        {
            let end = &ends[index / WIDTH];
            let end = [0, 1, 2].map(|function| end[WIDTH * function + index % WIDTH]);
            // What a segment leaves, and what it ends before, it does not cross.
            let is_end = facet.rays.is_left_whole() && target.facet == index as f64;
            if unsure == 0 && (end[0] < clear.below || end[0] > clear.above || is_end && clear.within) {
                continue;
            }
            let Crossing { near, within, slanted } = sides.crossing(end, facet.slack);
            let near = near & !(slanted & if is_end { ALL } else { *own });
            let met = if facet.always { open } else { open & (near | unsure) };
            if met != 0 {
                candidates.push((facet, met));
            }
            if facet.rays.is_covered() {
                blocked |= open & within & near & !unsure;
            }
        }
        let tested = candidates.iter().fold(0, |all, (_, lanes)| all | lanes) & !blocked;
        let tested = if few.spheres.is_empty() { tested } else { open & !blocked };
        if tested == 0 {
            return blocked;
        }
        for (register, points) in self.points.iter().enumerate() {
            let mut open = part(tested, register);
            if open == 0 {
                continue;
            }
            let segments = FanSegments::new(points, target.point);
            for (facet, lanes) in &candidates {
                let candidates = part(*lanes, register) & open;
                if candidates != 0 {
                    for triangle in &facet.triangles {
                        open &= !(segments.meet(triangle) & candidates);
                    }
                }
            }
            for sphere in &few.spheres {
                open &= !segments.meet_sphere(sphere, open);
            }
            blocked |= (part(tested, register) & !open) << (WIDTH * register);
        }
        blocked
    }
}
