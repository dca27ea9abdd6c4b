//! What is counted.

use crate::accel::Tests;
use std::ops::AddAssign;
use std::time::Duration;

/// No query takes so long: something else ran meanwhile.
const INTERRUPTED: Duration = Duration::from_millis(1);

/// What a ray is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayKind {
    /// From the sensor.
    Camera,
    /// On from where a surface or a medium has scattered a path.
    Scattered,
    /// To a light sample.
    Shadow,
    /// From a light, and on from where it has been scattered; to the camera.
    LightTracing,
    /// Between the first surfaces of a group of pixels and the next surface that they share.
    Shared,
    /// To find what touches a surface, and what is around the camera.
    Contact,
}

impl RayKind {
    /// All kinds.
    pub const ALL: [Self; 6] =
        [Self::Camera, Self::Scattered, Self::Shadow, Self::LightTracing, Self::Shared, Self::Contact];

    /// What `--stats` calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Scattered => "scattered",
            Self::Shadow => "shadow",
            Self::LightTracing => "light tracing",
            Self::Shared => "shared",
            Self::Contact => "contact",
        }
    }
}

/// Why a path ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathEnd {
    /// It leaves the scene.
    Escaped,
    /// Nothing is left of it: a surface or a medium absorbs it.
    Absorbed,
    /// Russian roulette.
    Roulette,
    /// It has as many segments as it may.
    MaxDepth,
}

impl PathEnd {
    /// All ends.
    pub const ALL: [Self; 4] = [Self::Escaped, Self::Absorbed, Self::Roulette, Self::MaxDepth];

    /// What `--stats` calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Escaped => "escaped",
            Self::Absorbed => "absorbed",
            Self::Roulette => "roulette",
            Self::MaxDepth => "max depth",
        }
    }
}

/// Rays of a kind, and what they took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RayCounts {
    /// Rays of this kind.
    pub rays: u64,
    /// Queries of the tree. A ray makes more than one where it passes hidden lights, surfaces with null
    /// transmission, or surfaces in contact.
    pub queries: u64,
    /// Queries that hit something.
    pub hits: u64,
    /// What the queries took. Of segments that all of a small scene's triangles are tested against at once
    /// (`segments_at_once`) it is not known.
    pub tests: Tests,
    /// Segments that were tested against all of a small scene's triangles at once.
    pub segments_at_once: u64,
    pub(super) timing: Timing,
}

/// Times of some queries, which stand for more of them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Timing {
    pub queries: u64,
    pub stands_for: u64,
    /// The time of the query without counting, and that of the same query with all that is counted.
    pub plain: Duration,
    pub counted: Duration,
}

impl Timing {
    /// The same, or nothing timed where something else ran meanwhile.
    pub fn unless_interrupted(self) -> Self {
        match self.plain.max(self.counted) < INTERRUPTED {
            true => self,
            false => Self { stands_for: self.stands_for, ..Self::default() },
        }
    }

    /// Seconds that the queries take where nobody counts, and that counting takes beside them.
    fn seconds(&self) -> [f64; 2] {
        if self.queries == 0 {
            return [0.0; 2];
        }
        let [timed, all] = [self.queries, self.stands_for].map(|count| count as f64);
        let [plain, counted] = [self.plain, self.counted].map(|time| time.as_secs_f64() / timed);
        // Those that are timed are made twice.
        [all * plain, all * (counted - plain) + timed * plain]
    }
}

impl AddAssign for Timing {
    fn add_assign(&mut self, other: Self) {
        self.queries += other.queries;
        self.stands_for += other.stands_for;
        self.plain += other.plain;
        self.counted += other.counted;
    }
}

/// Everything that is counted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counts {
    pub(super) rays: [RayCounts; RayKind::ALL.len()],
    pub(super) ends: [u64; PathEnd::ALL.len()],
    /// Segments of all paths that have ended.
    pub segments: u64,
    /// Times of queries that are made in other ways than by one ray for one hit.
    pub(super) others: Timing,
    /// Processor time of all threads in pieces of the picture.
    pub(super) busy: Duration,
}

impl Counts {
    /// The counts of rays of a kind.
    pub fn of(&self, kind: RayKind) -> &RayCounts {
        &self.rays[kind as usize]
    }

    /// Number of paths that ended so.
    pub fn ended(&self, end: PathEnd) -> u64 {
        self.ends[end as usize]
    }

    /// Rays of all kinds.
    pub fn rays(&self) -> u64 {
        self.rays.iter().map(|of_kind| of_kind.rays).sum()
    }

    /// Paths that have ended. Branches into which a path splits count each.
    pub fn paths(&self) -> u64 {
        self.ends.iter().sum()
    }

    /// What all queries took.
    pub fn tests(&self) -> Tests {
        self.rays.iter().fold(Tests::default(), |mut sum, of_kind| {
            sum += of_kind.tests;
            sum
        })
    }

    /// Seconds of ray queries and of counting them, estimated from the times of some of them.
    fn seconds_of_queries(&self) -> [f64; 2] {
        let timings = self.rays.iter().map(|of_kind| of_kind.timing).chain([self.others]);
        timings.fold([0.0; 2], |[queries, counting], timing| {
            let [plain, beside] = timing.seconds();
            [queries + plain, counting + beside]
        })
    }

    /// Processor time of all threads, s, less what counting is estimated to take.
    pub fn processor_seconds(&self) -> f64 {
        let [_, counting] = self.seconds_of_queries();
        (self.busy.as_secs_f64() - counting).max(0.0)
    }

    /// The share of the time that goes into ray queries, as it is where nobody counts. It is an upper bound:
    /// what is timed does not overlap with what is before and after it. `None` where nothing was timed.
    pub fn share_of_queries(&self) -> Option<f64> {
        let [queries, _] = self.seconds_of_queries();
        let whole = self.processor_seconds();
        (queries > 0.0 && whole > 0.0).then(|| (queries / whole).min(1.0))
    }
}

impl AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        for (sum, more) in self.rays.iter_mut().zip(other.rays) {
            sum.rays += more.rays;
            sum.queries += more.queries;
            sum.hits += more.hits;
            sum.tests += more.tests;
            sum.segments_at_once += more.segments_at_once;
            sum.timing += more.timing;
        }
        for (sum, more) in self.ends.iter_mut().zip(other.ends) {
            *sum += more;
        }
        self.segments += other.segments;
        self.others += other.others;
        self.busy += other.busy;
    }
}
