//! Counts of what a render does, where somebody asks for them. A scene that does not count pays a branch for
//! each query of the tree; the queries themselves are the same code.

mod counts;

use super::scene::Scene;
use crate::accel::{Accel, Fan, Hits, Rays, Target, Tests};
use crate::geometry::Ray;
use crate::lanes::{LANES, Mask, lanes_of, mask_of};
use crate::shape::{Hit, MeshData, Shape};
use counts::Timing;
pub use counts::{Counts, PathEnd, RayCounts, RayKind};
use cpu_time::ThreadTime;
use std::cell::Cell;
use std::collections::HashSet;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Where threads count, each for itself.
#[derive(Debug)]
pub struct Counters {
    shards: Vec<Mutex<Counts>>,
    /// What it takes to look at the clock.
    clock: Duration,
}

thread_local! {
    /// See [`rays_of_this_thread`].
    static RAYS: Cell<u64> = const { Cell::new(0) };
}

/// Rays that this thread has looked for surfaces with, in all scenes. The difference of two of these tells
/// what lies between them costs, alike on all machines. Segments that a [`Fan`] answers are none.
pub fn rays_of_this_thread() -> u64 {
    RAYS.get()
}

#[inline(always)]
fn note_rays(count: u32) {
    RAYS.set(RAYS.get().wrapping_add(u64::from(count)));
}

/// Number of queries, one of which is timed.
const TIMED: u64 = 32;

/// Threads that a render may have.
const MOST_THREADS: usize = 1024;

impl Counters {
    fn new() -> Self {
        let shards = MOST_THREADS.max(rayon::current_num_threads()) + 1;
        let clock = (0..1000).map(|_| Instant::now().elapsed()).min().unwrap_or_default();
        Self { shards: (0..shards).map(|_| Mutex::default()).collect(), clock }
    }

    /// All that has been counted and not taken yet.
    pub fn take(&self) -> Counts {
        let mut sum = Counts::default();
        for shard in &self.shards {
            sum += std::mem::take(&mut *lock(shard));
        }
        sum
    }

    /// What this thread has counted and not handed over yet.
    pub fn of_this_thread(&self) -> Counts {
        *self.shard()
    }

    fn shard(&self) -> MutexGuard<'_, Counts> {
        // Whoever is no thread of a pool has the last one.
        let index = rayon::current_thread_index().unwrap_or(usize::MAX);
        lock(&self.shards[index.min(self.shards.len() - 1)])
    }

    /// A query of the tree: without counting, and the same with a count of its steps.
    fn query<R: PartialEq>(
        &self,
        query: Query,
        is_hit: impl Fn(&R) -> bool,
        plain: impl Fn() -> R,
        counting: impl Fn(&Cell<Tests>) -> R,
    ) -> R {
        let tests = Cell::new(Tests::default());
        let is_timed = self.shard().of(query.kind).queries.is_multiple_of(TIMED);
        let elapsed = |since: Instant| since.elapsed().saturating_sub(self.clock);
        let (found, timing) = if is_timed {
            let began = Instant::now();
            let found = plain();
            let plain = elapsed(began);
            let began = Instant::now();
            let same = counting(&tests);
            debug_assert!(same == found, "counting changes what a ray meets");
            let counted = elapsed(began);
            (found, Timing { queries: 1, stands_for: 1, plain, counted }.unless_interrupted())
        } else {
            (counting(&tests), Timing { stands_for: 1, ..Timing::default() })
        };
        let mut counts = self.shard();
        let of_kind = &mut counts.rays[query.kind as usize];
        of_kind.rays += u64::from(query.begins);
        of_kind.queries += 1;
        of_kind.hits += u64::from(is_hit(&found));
        of_kind.tests += tests.get();
        of_kind.timing += timing;
        found
    }

    #[cold]
    #[inline(never)]
    fn closest(&self, accel: &Accel, query: Query, ray: &Ray, time: f64) -> Option<Hit> {
        let plain = || accel.closest(ray, time);
        self.query(query, Option::is_some, plain, |tests| accel.closest_counting(ray, time, tests))
    }

    #[cold]
    #[inline(never)]
    fn occluded(&self, accel: &Accel, query: Query, ray: &Ray, time: f64) -> bool {
        let plain = || accel.occluded(ray, time);
        self.query(query, |&hit| hit, plain, |tests| accel.occluded_counting(ray, time, tests))
    }

    #[cold]
    #[inline(never)]
    fn blocked(&self, accel: &Accel, fan: &Fan, target: &Target, time: f64, asked: Mask) -> Mask {
        let segments = u64::from(asked.count_ones());
        let began = Instant::now();
        let blocked = fan.blocked(target, time, asked);
        let plain = began.elapsed().saturating_sub(self.clock);
        let tests = Cell::new(Tests::default());
        let began = Instant::now();
        if !fan.is_at_once() {
            for segment in lanes_of(asked).filter_map(|lane| fan.point(lane).segment_to(target.point)) {
                accel.occluded_counting(&segment, time, &tests);
            }
        }
        let counted = began.elapsed();
        let mut counts = self.shard();
        let of_kind = &mut counts.rays[RayKind::Shared as usize];
        of_kind.rays += segments;
        of_kind.queries += segments;
        of_kind.hits += u64::from(blocked.count_ones());
        of_kind.tests += tests.get();
        of_kind.segments_at_once += if fan.is_at_once() { segments } else { 0 };
        counts.others += Timing { queries: 1, stands_for: 1, plain, counted }.unless_interrupted();
        blocked
    }
}

/// A shard is whole between any two of its additions.
fn lock(shard: &Mutex<Counts>) -> MutexGuard<'_, Counts> {
    shard.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What a query of the tree is for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Query {
    pub kind: RayKind,
    /// Whether it is the first of its ray.
    pub begins: bool,
}

impl RayKind {
    /// Its first query.
    pub(super) fn begins(self) -> Query {
        Query { kind: self, begins: true }
    }
}

impl Scene {
    /// The same scene, which counts what a render does. The picture is the same, and takes longer.
    #[must_use]
    pub fn counting(self) -> Self {
        Self { counters: Some(Box::new(Counters::new())), ..self }
    }

    /// Bytes that the tree takes, and those of meshes.
    pub fn memory(&self) -> [usize; 2] {
        let mut known = HashSet::new();
        let meshes = self.shapes.iter().filter_map(|shape| match shape {
            Shape::Mesh(mesh) => Some(mesh.data()),
            _ => None,
        });
        let meshes = meshes.filter(|&data| known.insert(std::ptr::from_ref(data)));
        [self.accel.memory_with_groups(), meshes.map(MeshData::memory).sum()]
    }

    /// Where it counts.
    pub fn counters(&self) -> Option<&Counters> {
        self.counters.as_deref()
    }

    /// See [`Accel::closest`].
    #[inline(always)]
    pub(super) fn closest(&self, query: Query, ray: &Ray, time: f64) -> Option<Hit> {
        note_rays(1);
        match &self.counters {
            None => self.accel.closest(ray, time),
            Some(counters) => counters.closest(&self.accel, query, ray, time),
        }
    }

    /// See [`Accel::closest_of`].
    #[inline(always)]
    pub(super) fn closest_in_lanes(
        &self,
        query: Query,
        rays: &Rays,
        time: f64,
        asked: Mask,
        hits: &mut Hits,
    ) {
        note_rays(asked.count_ones());
        let Some(counters) = &self.counters else { return self.accel.closest_of(rays, time, asked, hits) };
        hits.clone_from(&Hits::NONE);
        for lane in lanes_of(asked) {
            if let Some(hit) = counters.closest(&self.accel, query, &rays.get(lane), time) {
                hits.set(lane, &hit);
            }
        }
    }

    /// The lanes asked for in which anything at all is in the way of a ray of a kind.
    #[inline(always)]
    pub fn occluded_in_lanes(&self, kind: RayKind, rays: &Rays, time: f64, asked: Mask) -> Mask {
        note_rays(asked.count_ones());
        let Some(counters) = &self.counters else { return self.accel.occluded_of(rays, time, asked) };
        let query = kind.begins();
        let occluded = |lane: &usize| counters.occluded(&self.accel, query, &rays.get(*lane), time);
        mask_of(lanes_of(asked).filter(occluded))
    }

    /// See [`Accel::occluded_together`].
    #[inline(always)]
    pub fn occluded_together(&self, kind: RayKind, rays: &[Ray; LANES], time: f64, asked: Mask) -> Mask {
        note_rays(asked.count_ones());
        let Some(counters) = &self.counters else { return self.accel.occluded_together(rays, time, asked) };
        let query = kind.begins();
        let occluded = |lane: &usize| counters.occluded(&self.accel, query, &rays[*lane], time);
        mask_of(lanes_of(asked).filter(occluded))
    }

    /// See [`Accel::occluded`].
    #[inline(always)]
    pub(super) fn occluded(&self, query: Query, ray: &Ray, time: f64) -> bool {
        note_rays(1);
        match &self.counters {
            None => self.accel.occluded(ray, time),
            Some(counters) => counters.occluded(&self.accel, query, ray, time),
        }
    }

    /// See [`Fan::blocked`].
    #[inline(always)]
    pub fn blocked(&self, fan: &Fan, target: &Target, time: f64, asked: Mask) -> Mask {
        match &self.counters {
            None => fan.blocked(target, time, asked),
            Some(counters) => counters.blocked(&self.accel, fan, target, time, asked),
        }
    }

    /// Every crossing of a range of a ray, see [`Accel::crossings`].
    #[inline(always)]
    pub(super) fn crossings(
        &self,
        ray: &Ray,
        time: f64,
        range: [f64; 2],
        report: &mut dyn FnMut(Hit, Option<f64>),
    ) {
        note_rays(1);
        match &self.counters {
            None => self.accel.crossings(ray, time, range, report),
            Some(counters) => counters.crossings(|| self.accel.crossings(ray, time, range, report)),
        }
    }

    /// A path of `segments` segments has ended.
    #[inline(always)]
    pub fn path_ended(&self, end: PathEnd, segments: u32) {
        if let Some(counters) = &self.counters {
            counters.ended(end, segments);
        }
    }

    /// The paths of some lanes, each of so many segments, have ended.
    #[inline(always)]
    pub fn paths_ended(&self, end: PathEnd, segments: u32, lanes: Mask) {
        if let Some(counters) = &self.counters {
            lanes_of(lanes).for_each(|_| counters.ended(end, segments));
        }
    }

    /// A piece of the picture, which is the work of one thread.
    pub fn piece<R>(&self, work: impl FnOnce() -> R) -> R {
        let Some(counters) = &self.counters else { return work() };
        let began = ThreadTime::now();
        let result = work();
        counters.shard().busy += began.elapsed();
        result
    }
}

impl Counters {
    #[cold]
    #[inline(never)]
    fn crossings(&self, query: impl FnOnce()) {
        let began = Instant::now();
        query();
        let plain = began.elapsed().saturating_sub(self.clock);
        let mut counts = self.shard();
        let of_kind = &mut counts.rays[RayKind::Contact as usize];
        of_kind.rays += 1;
        of_kind.queries += 1;
        counts.others +=
            Timing { queries: 1, stands_for: 1, plain, counted: Duration::ZERO }.unless_interrupted();
    }

    #[cold]
    #[inline(never)]
    fn ended(&self, end: PathEnd, segments: u32) {
        let mut counts = self.shard();
        counts.ends[end as usize] += 1;
        counts.segments += u64::from(segments);
    }
}
