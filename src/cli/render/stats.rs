//! What a render did and how long it took, for `--stats`.

use abbe::accel::Tests;
use abbe::film::Film;
use abbe::render::{Chosen, Progress, Settings, Work};
use abbe::scene::{Counts, PathEnd, RayCounts, RayKind, Scene};
use serde_json::{Map, Value, json};
use std::fmt::Write;
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Takes counts and times while a render goes on, and passes on all that it is told.
pub struct Statistics<'a> {
    scene: &'a Scene,
    progress: &'a dyn Progress,
    started: Instant,
    taken: Mutex<Taken>,
}

#[derive(Default)]
struct Taken {
    pilots: Option<(Counts, Duration)>,
    chosen: Option<Chosen>,
    /// When the first samples of the picture were done.
    first: Option<Duration>,
    /// Samples of the film after each pass, and when that was.
    passes: Vec<(u64, Duration)>,
}

impl<'a> Statistics<'a> {
    pub fn new(scene: &'a Scene, progress: &'a dyn Progress) -> Self {
        Self { scene, progress, started: Instant::now(), taken: Mutex::default() }
    }

    /// All that is known in the end. `before`: how long it took to read the scene, and to compile it.
    pub fn report(self, film: &Film, settings: &Settings, before: [Duration; 2]) -> Report {
        let taken = self.taken.into_inner().unwrap_or_else(PoisonError::into_inner);
        let (pilots, of_pilots) = taken.pilots.unwrap_or_default();
        let [tree, meshes] = self.scene.memory();
        let [width, height] = film.extent.measured.size;
        Report {
            counts: self.scene.counters().map(abbe::scene::Counters::take).unwrap_or_default(),
            pilots,
            chosen: taken.chosen,
            samples: film.measured_samples(),
            pixels: film.extent.measured.pixel_count(),
            bad: film.bad.total(),
            light_paths: film.extras.light_paths,
            before,
            of_pilots,
            first: taken.first,
            passes: taken.passes,
            tree,
            meshes,
            film: Film::bytes(width, height, film.replicates, &settings.extras(self.scene)).iter().sum(),
            peak: peak_memory(),
        }
    }
}

impl Progress for Statistics<'_> {
    fn pilots_done(&self, chosen: &Chosen) {
        let counts = self.scene.counters().map(abbe::scene::Counters::take).unwrap_or_default();
        let mut taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        taken.pilots = Some((counts, self.started.elapsed()));
        taken.chosen = Some(*chosen);
        self.progress.pilots_done(chosen);
    }

    fn advanced(&self, samples: u64) {
        // Blocks around the picture, which a filter reaches, may have none.
        if samples > 0 {
            let mut taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
            taken.first.get_or_insert_with(|| self.started.elapsed());
        }
        self.progress.advanced(samples);
    }

    fn pass_done(&self, work: &Work) {
        let mut taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        taken.passes.push((work.film().measured_samples(), self.started.elapsed()));
        drop(taken);
        self.progress.pass_done(work);
    }

    fn wants_to_keep(&self) -> bool {
        self.progress.wants_to_keep()
    }

    fn keep(&self, work: &Work) {
        self.progress.keep(work);
    }

    fn stop(&self) -> &AtomicBool {
        self.progress.stop()
    }
}

/// What a render did and how long it took.
pub struct Report {
    counts: Counts,
    pilots: Counts,
    /// How the picture was rendered; `None` where nothing was left to render.
    chosen: Option<Chosen>,
    samples: u64,
    pixels: u64,
    bad: u64,
    light_paths: bool,
    before: [Duration; 2],
    of_pilots: Duration,
    first: Option<Duration>,
    passes: Vec<(u64, Duration)>,
    /// Bytes.
    tree: usize,
    meshes: usize,
    film: u128,
    peak: Option<u64>,
}

/// The most memory that the process has had so far, bytes, where the system tells.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? * 1024)
}

/// The entries of an object of JSON.
fn object(value: Value) -> Map<String, Value> {
    match value {
        Value::Object(entries) => entries,
        _ => Map::new(),
    }
}

/// One number over another; zero over zero is zero.
fn over(part: u64, whole: u64) -> f64 {
    if whole == 0 { 0.0 } else { part as f64 / whole as f64 }
}

impl Report {
    /// Rays of all kinds of the picture.
    fn rays(&self) -> impl Iterator<Item = (RayKind, &RayCounts)> {
        RayKind::ALL
            .into_iter()
            .map(|kind| (kind, self.counts.of(kind)))
            .filter(|(kind, counts)| counts.rays > 0 || *kind == RayKind::Camera)
    }

    pub fn text(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = self.write_rays(&mut text);
        let _ = self.write_rest(&mut text);
        text
    }

    fn write_rays(&self, text: &mut String) -> std::fmt::Result {
        writeln!(
            text,
            "{:14} {:>12} {:>6} {:>9} {:>8} {:>6} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8}",
            "rays",
            "number",
            "of all",
            "per pixel",
            "/sample",
            "hit",
            "nodes",
            "missed",
            "entered",
            "empty",
            "packets",
            "surfaces"
        )?;
        let mut line = |name: &str, rays: u64, hits: u64, queries: u64, at_once: u64, tests: &Tests| {
            write!(
                text,
                "{name:14} {rays:12} {:5.1}% {:9.2} {:8.3} {:5.1}%",
                100.0 * over(rays, self.counts.rays()),
                over(rays, self.pixels),
                over(rays, self.samples),
                100.0 * over(hits, queries),
            )?;
            let known = queries - at_once;
            if known == 0 && queries > 0 {
                return writeln!(text, "  all triangles of the small scene at once");
            }
            for count in [
                tests.nodes,
                tests.boxes - tests.entered,
                tests.entered,
                tests.empty,
                tests.packets,
                tests.surfaces,
            ] {
                write!(text, " {:8.3}", over(count, known))?;
            }
            writeln!(text)
        };
        for (kind, counts) in self.rays() {
            let RayCounts { rays, hits, queries, segments_at_once, ref tests, .. } = *counts;
            line(kind.name(), rays, hits, queries, segments_at_once, tests)?;
        }
        let sum = |of: fn(&RayCounts) -> u64| self.rays().map(|(_, counts)| of(counts)).sum::<u64>();
        let at_once = sum(|counts| counts.segments_at_once);
        let (hits, queries) = (sum(|counts| counts.hits), sum(|counts| counts.queries));
        line("all", self.counts.rays(), hits, queries, at_once, &self.counts.tests())?;
        writeln!(
            text,
            "  per query of the tree: nodes visited; boxes missed, entered, visited with nothing nearer in them;\n  \
             packets of four triangles and other surfaces tested"
        )
    }

    fn write_rest(&self, text: &mut String) -> std::fmt::Result {
        let counts = &self.counts;
        write!(
            text,
            "paths          {:12} {:.3} a sample, of {:.2} segments:",
            counts.paths(),
            over(counts.paths(), self.samples),
            self.mean_length()
        )?;
        for end in PathEnd::ALL {
            write!(text, " {} {:.1}%", end.name(), 100.0 * over(counts.ended(end), counts.paths()))?;
        }
        writeln!(text)?;
        writeln!(text, "pilots         {:12} rays, which are not counted above", self.pilots.rays())?;
        if let Some(chosen) = &self.chosen {
            self.write_plan(text, chosen)?;
        }
        write!(
            text,
            "processor time {:12.3} s, {:.3} µs a ray",
            counts.processor_seconds(),
            self.microseconds()
        )?;
        match counts.share_of_queries() {
            Some(share) => writeln!(text, ", at most {:.1}% of it in ray queries", 100.0 * share)?,
            None => writeln!(text)?,
        }
        writeln!(text, "bad values     {:12}", self.bad)?;
        let mib = |bytes: f64| bytes / f64::from(1 << 20);
        write!(
            text,
            "memory, MiB    tree {:.1}, meshes {:.1}, film {:.1}",
            mib(self.tree as f64),
            mib(self.meshes as f64),
            mib(self.film as f64)
        )?;
        match self.peak {
            Some(peak) => writeln!(text, ", of the process at most {:.1}", mib(peak as f64))?,
            None => writeln!(text)?,
        }
        let [read, build] = self.before.map(|time| time.as_secs_f64());
        write!(
            text,
            "time, s        read {read:.3}, build {build:.3}, pilots {:.3}",
            self.of_pilots.as_secs_f64()
        )?;
        if let Some(first) = self.first_samples() {
            write!(text, ", first samples {first:.4}")?;
        }
        for (samples, seconds) in self.times_of_passes() {
            write!(text, ", to {:.4} samples per pixel {seconds:.3}", over(samples, self.pixels))?;
        }
        writeln!(text)
    }

    /// What the pilots have chosen, or the settings.
    fn write_plan(&self, text: &mut String, chosen: &Chosen) -> std::fmt::Result {
        let Chosen { plan, wavelengths, samples_per_path } = chosen;
        write!(
            text,
            "plan           wavelengths a path {}, pixels a suffix {}, light samples at the first surface {}",
            wavelengths.get(),
            plan.sharing.pixels(),
            plan.light_samples
        )?;
        match self.light_paths {
            true => writeln!(text, ", samples a light subpath {samples_per_path}"),
            false => writeln!(text),
        }
    }

    /// The samples after each pass, and how long the pass took, s.
    fn times_of_passes(&self) -> impl Iterator<Item = (u64, f64)> {
        let ends = self.passes.iter().map(|(_, end)| *end);
        let begins = std::iter::once(self.of_pilots).chain(ends.clone());
        let samples = self.passes.iter().map(|(samples, _)| *samples);
        samples
            .zip(ends.zip(begins))
            .map(|(samples, (end, begin))| (samples, end.saturating_sub(begin).as_secs_f64()))
    }

    fn mean_length(&self) -> f64 {
        over(self.counts.segments, self.counts.paths())
    }

    /// Processor time of a ray and all that belongs to it.
    fn microseconds(&self) -> f64 {
        1e6 * self.counts.processor_seconds() / self.counts.rays().max(1) as f64
    }

    /// How long it took from the end of the pilots to the first samples of the picture, s.
    fn first_samples(&self) -> Option<f64> {
        self.first.map(|first| first.saturating_sub(self.of_pilots).as_secs_f64())
    }

    pub fn json(&self) -> String {
        let mut report = self.counted();
        report.append(&mut self.measured());
        format!("{:#}\n", Value::Object(report))
    }

    /// Times and memory, which are others for each run.
    fn measured(&self) -> Map<String, Value> {
        let [read, build] = self.before.map(|time| time.as_secs_f64());
        let passes: Vec<Value> = self
            .times_of_passes()
            .map(|(samples, seconds)| json!({ "samples": samples, "seconds": seconds }))
            .collect();
        object(json!({
            "share_of_ray_queries": self.counts.share_of_queries(),
            "processor_seconds": self.counts.processor_seconds(),
            "microseconds_per_ray": self.microseconds(),
            "memory": { "tree": self.tree, "meshes": self.meshes, "film": self.film as u64, "peak": self.peak },
            "seconds": {
                "read": read,
                "build": build,
                "pilots": self.of_pilots.as_secs_f64(),
                "first_samples": self.first_samples(),
                "passes": passes,
            },
        }))
    }

    /// What is the same for equal renders.
    fn counted(&self) -> Map<String, Value> {
        let rays: Map<String, Value> = self
            .rays()
            .map(|(kind, counts)| {
                let RayCounts { rays, queries, hits, tests, segments_at_once, .. } = counts;
                let value = json!({
                    "rays": rays,
                    "share": over(*rays, self.counts.rays()),
                    "per_pixel": over(*rays, self.pixels),
                    "per_sample": over(*rays, self.samples),
                    "queries": queries,
                    "hits": hits,
                    "segments_at_once": segments_at_once,
                    "nodes": tests.nodes,
                    "boxes_missed": tests.boxes - tests.entered,
                    "boxes_entered": tests.entered,
                    "boxes_empty": tests.empty,
                    "leaves": tests.leaves,
                    "packets": tests.packets,
                    "surfaces": tests.surfaces,
                });
                (kind.name().replace(' ', "_"), value)
            })
            .collect();
        let ends: Map<String, Value> = PathEnd::ALL
            .into_iter()
            .map(|end| (end.name().replace(' ', "_"), json!(self.counts.ended(end))))
            .collect();
        object(json!({
            "samples": self.samples,
            "pixels": self.pixels,
            "rays": rays,
            "all_rays": self.counts.rays(),
            "rays_of_pilots": self.pilots.rays(),
            "plan": self.chosen.map(|chosen| json!({
                "wavelengths": chosen.wavelengths.get(),
                "pixels_per_suffix": chosen.plan.sharing.pixels(),
                "light_samples": chosen.plan.light_samples,
                "samples_per_light_subpath": self.light_paths.then_some(chosen.samples_per_path),
            })),
            "light_tracing": self.light_paths,
            "paths": {
                "number": self.counts.paths(),
                "per_sample": over(self.counts.paths(), self.samples),
                "mean_segments": self.mean_length(),
                "ends": ends,
            },
            "bad_values": self.bad,
        }))
    }

    /// For the file: what is the same for equal renders, and by itself what is not.
    pub fn attributes(&self) -> Vec<(String, String)> {
        let attribute = |name: &str, told| (name.to_owned(), Value::Object(told).to_string());
        vec![attribute("abbe.stats", self.counted()), attribute("abbe.stats.run", self.measured())]
    }
}
