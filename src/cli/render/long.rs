//! Renders that take long: what is kept of them on the way, where they go on, and when they are good enough.

use super::super::progress::RenderProgress;
use super::super::tev::Tev;
use super::super::view::Page;
use super::super::{Failure, print_message};
use super::{cannot_write, has_extension, report};
use abbe::film::Film;
use abbe::output::checkpoint::{self, Description, Header};
use abbe::output::target::{self, Estimate, Target};
use abbe::output::{self};
use abbe::render::{Auxiliary, Progress, Schedule, Work};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Samples of each pixel at which a render ends that is to end at an error or a time, and is not told
/// otherwise.
pub const MOST_SAMPLES: u32 = 1 << 20;

/// Largest fraction of the time that checkpoints take, as one over it.
const RARELY: u32 = 20;

/// Options of renders that take long.
#[derive(clap::Args)]
#[command(next_help_heading = "Long renders")]
pub struct LongOptions {
    /// Keep what is done in OUT.checkpoint, every minute and when the render is stopped. --resume goes on
    /// from it, to the same bits as without a break; abbe merge puts several of them together. It stays
    /// beside the picture
    #[arg(long)]
    checkpoint: bool,

    /// Go on from OUT.checkpoint, if there is one. Implies --checkpoint
    #[arg(long)]
    resume: bool,

    /// Time between checkpoints, such as 30s, 10m or 2h. They take a twentieth of the time at most
    #[arg(long, value_name = "TIME", default_value = "1m", value_parser = parse_time)]
    checkpoint_every: Duration,

    /// Render samples A to B − 1 of each pixel alone, counted from 0, of all that --spp says: a part for abbe
    /// merge. Implies --checkpoint
    #[arg(long, value_name = "A..B", value_parser = parse_samples, conflicts_with_all = ["until", "time"])]
    samples: Option<Range<u64>>,

    /// End when the error of the luminance (or of all responses of a specfilm) is below a bound with 95 %
    /// confidence: 'relmse<1e-3' (as abbe compare has it), 'error<1%' (mean standard error over mean) or, of
    /// the colours, 'de<0.5' (the mean of each pixel's root mean square CIEDE2000, with the white of abbe
    /// compare). It is looked at whenever the samples have doubled. --spp is then the most samples that are
    /// taken [default then: 1048576]
    #[arg(long, value_name = "TARGET")]
    until: Option<Target>,

    /// End after this time, such as 90s, 10m or 2h, but not before each pixel has a sample. --spp is then the
    /// most samples that are taken [default then: 1048576]
    #[arg(long, value_name = "TIME", value_parser = parse_time)]
    time: Option<Duration>,

    /// Show the picture in the making in tev, an image viewer that listens at this address, such as
    /// 127.0.0.1:14158
    #[arg(long, value_name = "HOST:PORT")]
    tev: Option<String>,
}

/// Where the files go.
pub struct Places {
    pub picture: Option<PathBuf>,
    pub png: Option<PathBuf>,
    pub checkpoint: Option<PathBuf>,
}

impl Places {
    /// Refused before the render rather than after it.
    pub fn refuse_unwritable(&self) -> Result<(), Failure> {
        for path in [&self.picture, &self.png, &self.checkpoint].into_iter().flatten() {
            output::refuse_unwritable(path).map_err(|error| cannot_write(path, &error))?;
        }
        Ok(())
    }
}

impl LongOptions {
    /// Whether a render may end before it has the samples that are asked for.
    pub fn ends_early(&self) -> bool {
        self.until.is_some() || self.time.is_some()
    }

    pub fn resumes(&self) -> bool {
        self.resume
    }

    /// The viewer that is asked for.
    pub fn viewer(&self, name: &str) -> Result<Option<Tev>, Failure> {
        let connect = |address: &String| {
            Tev::new(address, name).map_err(|error| {
                Failure::Input(format!(
                    "error: --tev {address}: {error}\nhelp: start tev there; by default it listens at 127.0.0.1:14158"
                ))
            })
        };
        self.tev.as_ref().map(connect).transpose()
    }

    /// Where the files go, by the name of one. Frames of an animation are always kept on the way.
    pub fn places(&self, output: &Path, with_png: bool, is_frame: bool) -> Places {
        if has_extension(output, checkpoint::EXTENSION) {
            return Places { picture: None, png: None, checkpoint: Some(output.to_owned()) };
        }
        let is_kept = self.checkpoint || self.resume || self.samples.is_some() || is_frame;
        Places {
            picture: Some(output.to_owned()),
            png: with_png.then(|| output.with_extension("png")),
            checkpoint: is_kept.then(|| output.with_extension(checkpoint::EXTENSION)),
        }
    }

    /// The samples of each pixel that are asked for, where not all are.
    pub fn samples(&self, schedule: Schedule) -> Result<Option<Range<u64>>, Failure> {
        let all = schedule.samples();
        match &self.samples {
            Some(samples) if samples.end > all => Err(Failure::Input(format!(
                "error: --samples {}..{}: a pixel has {all} samples\nhelp: --spp says how many there are in all parts together",
                samples.start, samples.end
            ))),
            samples => Ok(samples.clone()),
        }
    }
}

/// What is kept of a render on the way.
pub struct Kept {
    /// `None` where nothing is.
    pub path: Option<PathBuf>,
    pub identity: Vec<(String, String)>,
    pub picture: Description,
    pub samples_per_pixel: u64,
    pub threads: usize,
}

impl Kept {
    /// Where the render begins: at the checkpoint that it is to go on from, or with nothing done.
    pub fn begin(&self, work: Work, options: &LongOptions, quiet: bool) -> Result<Work, Failure> {
        let Some(path) = self.path.as_ref().filter(|_| options.resume) else {
            return match &self.path {
                Some(path) if path.exists() => Err(Failure::Input(format!(
                    "error: {} is there already\nhelp: --resume goes on from it; remove it to begin anew",
                    path.display()
                ))),
                _ => Ok(work),
            };
        };
        if !path.exists() {
            if !quiet {
                print_message(&format!("there is no {}: beginning anew", path.display()));
            }
            return Ok(work);
        }
        let failed = |error| cannot_read(path, &error);
        let opened = checkpoint::open(path).map_err(failed)?;
        let wrong = |what: &str, [there, here]: [&str; 2]| {
            Failure::Input(format!(
                "error: {} is of another picture: {what} is {there} there and {here} here\n\
                 help: resume it as it was begun, or give another -o",
                path.display()
            ))
        };
        if let Some([what, there, here]) = opened.header.mismatch(&self.identity) {
            return Err(wrong(&what, [&there, &here]));
        }
        let own = Header::of(&work, &self.identity, &self.picture, self.samples_per_pixel, &[]).render;
        let (Some((there, _)), Some((here, _))) = (&opened.header.render, &own) else {
            return Err(Failure::Input(format!(
                "error: {} was put together from parts: no render goes on from it",
                path.display()
            )));
        };
        if there != here {
            return Err(wrong("the part", [&there.to_string(), &here.to_string()]));
        }
        let resumed = opened.resumed(work).map_err(failed)?;
        Ok(resumed)
    }

    /// Keeps what is done.
    pub fn write(&self, work: &Work, images: &[Auxiliary]) -> Result<(), Failure> {
        let Some(path) = &self.path else { return Ok(()) };
        self.try_to_write(path, work, images).map_err(|error| cannot_write(path, &error))
    }

    fn try_to_write(&self, path: &Path, work: &Work, images: &[Auxiliary]) -> std::io::Result<()> {
        let header = Header::of(work, &self.identity, &self.picture, self.samples_per_pixel, images);
        checkpoint::write(path, &header, work.film(), images, self.threads)
    }
}

/// A checkpoint that cannot be read.
pub fn cannot_read(path: &Path, error: &std::io::Error) -> Failure {
    Failure::Input(format!("error: cannot read {}: {error}", path.display()))
}

/// Watches a render that takes long: tells how far it is, keeps what is done, and ends it when it is good
/// enough.
pub struct Watching<'a> {
    progress: RenderProgress,
    kept: &'a Kept,
    options: &'a LongOptions,
    started: Instant,
    /// Milliseconds from the start to the next checkpoint.
    next: AtomicU64,
    replicates: u64,
    /// Whether every pixel has a sample.
    is_begun: AtomicBool,
    decision: Mutex<Decision>,
    /// `None` where there is no viewer, and where it has gone.
    viewer: Mutex<Option<Tev>>,
    page: Option<&'a Page>,
    /// Samples of the whole render.
    total: u64,
    stop: Arc<AtomicBool>,
}

/// Who is shown the picture in the making.
pub struct Viewers<'a> {
    pub tev: Option<Tev>,
    pub page: Option<&'a Page>,
}

/// Why a render ended, if it was not for a signal or its last sample.
#[derive(Clone, Copy, Debug, Default)]
struct Decision {
    is_met: bool,
    is_out_of_time: bool,
}

impl<'a> Watching<'a> {
    pub fn new(
        kept: &'a Kept,
        options: &'a LongOptions,
        work: &Work,
        quiet: bool,
        viewers: Viewers<'a>,
        stop: Arc<AtomicBool>,
    ) -> Self {
        let film = work.film();
        let samples = work.samples();
        let total = film.extent.measured.pixel_count() * (samples.end - samples.start);
        let before = film.measured_samples();
        let watching = Self {
            progress: RenderProgress::new(total, before, quiet, stop.clone()),
            kept,
            options,
            started: Instant::now(),
            next: AtomicU64::new(millis(options.checkpoint_every)),
            replicates: u64::from(film.replicates),
            is_begun: AtomicBool::new(*film.samples_per_pixel().start() > 0),
            decision: Mutex::default(),
            viewer: Mutex::new(viewers.tev),
            page: viewers.page,
            total,
            stop,
        };
        // What goes on may have been good enough.
        if work.finished().is_some() {
            watching.decide(film);
        }
        watching
    }

    /// Ends what is told: what became of the render, and how long it took, s.
    pub fn finish(self, work: &Work) -> (Outcome, f64) {
        let (outcome, seconds) = (self.outcome(work), self.started.elapsed().as_secs_f64());
        self.show(work.film());
        self.progress.finish();
        (outcome, seconds)
    }

    /// Ends the render where its error is small enough.
    fn decide(&self, film: &Film) {
        let Some(target) = self.options.until else { return };
        let samples = *film.samples_per_pixel().start();
        if Target::decides_at(samples / self.replicates) && target.is_met(target.estimate(film)) {
            self.decided(|decision| decision.is_met = true);
        }
    }

    /// Shows the film to whoever watches. A viewer that does not take it is left alone from then on.
    fn show(&self, film: &Film) {
        let mut viewer = self.viewer.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(Err(error)) = viewer.as_mut().map(|viewer| viewer.show(film)) {
            print_message(&format!("warning: tev shows no more of it: {error}"));
            *viewer = None;
        }
    }

    fn is_to_be_shown(&self) -> bool {
        let viewer = self.viewer.lock().unwrap_or_else(PoisonError::into_inner);
        viewer.as_ref().is_some_and(Tev::is_due)
    }

    fn is_to_be_kept(&self) -> bool {
        self.kept.path.is_some() && millis(self.started.elapsed()) >= self.next.load(Ordering::Relaxed)
    }

    fn decided(&self, change: impl FnOnce(&mut Decision)) {
        change(&mut self.decision.lock().unwrap_or_else(PoisonError::into_inner));
        self.stop.store(true, Ordering::Relaxed);
    }

    fn outcome(&self, work: &Work) -> Outcome {
        let decision = *self.decision.lock().unwrap_or_else(PoisonError::into_inner);
        let estimate = self.options.until.and_then(|target| target.estimate(work.film()));
        let is_met = decision.is_met
            || work.is_finished() && self.options.until.is_some_and(|target| target.is_met(estimate));
        Outcome { target: self.options.until, estimate, is_met, is_out_of_time: decision.is_out_of_time }
    }
}

fn millis(time: Duration) -> u64 {
    u64::try_from(time.as_millis()).unwrap_or(u64::MAX)
}

impl Progress for Watching<'_> {
    fn advanced(&self, samples: u64) {
        self.progress.advanced(samples);
        let is_over = self.options.time.is_some_and(|time| self.started.elapsed() >= time);
        if is_over && self.is_begun.load(Ordering::Relaxed) && !self.stop.load(Ordering::Relaxed) {
            self.decided(|decision| decision.is_out_of_time = true);
        }
    }

    fn pass_done(&self, film: &Film) {
        self.is_begun.store(true, Ordering::Relaxed);
        self.progress.pass_done(film);
        self.decide(film);
    }

    fn wants_to_keep(&self) -> bool {
        self.is_to_be_kept() || self.is_to_be_shown() || self.page.is_some_and(Page::is_due)
    }

    fn keep(&self, work: &Work) {
        if let Some(page) = self.page.filter(|page| page.is_due()) {
            page.show(work, work.film().measured_samples() as f64 / self.total.max(1) as f64);
        }
        if self.is_to_be_shown() {
            self.show(work.film());
        }
        let Some(path) = self.kept.path.as_ref().filter(|_| self.is_to_be_kept()) else { return };
        let began = Instant::now();
        if let Err(error) = self.kept.try_to_write(path, work, &[]) {
            // The render is worth more than the checkpoint, and there may be room for the next one.
            print_message(&format!(
                "warning: cannot write {}: {error}. What was kept before stays; the render goes on and tries again",
                path.display()
            ));
        }
        let pause = self.options.checkpoint_every.max(began.elapsed() * RARELY);
        self.next.store(millis(self.started.elapsed() + pause), Ordering::Relaxed);
    }

    fn stop(&self) -> &AtomicBool {
        &self.stop
    }
}

/// What became of a render that may have ended before its last sample.
pub struct Outcome {
    target: Option<Target>,
    estimate: Option<Estimate>,
    is_met: bool,
    is_out_of_time: bool,
}

impl Outcome {
    /// What was asked for and reached, where an error was asked for.
    pub fn attributes(&self) -> Vec<(String, String)> {
        let Some(target) = self.target else { return Vec::new() };
        let reached = |value: fn(Estimate) -> f64| {
            self.estimate.map_or_else(String::new, |estimate| target.told(value(estimate)))
        };
        report::named([
            ("asked", target.to_string()),
            ("reached", reached(|estimate| estimate.value)),
            ("reachedAtMost", reached(|estimate| estimate.at_most)),
            ("confidence", target::CONFIDENCE.to_string()),
        ])
    }

    /// Whether it ended because it was good enough or out of time, and not for a signal.
    pub fn has_decided(&self) -> bool {
        self.is_met || self.is_out_of_time
    }

    /// Whether no signal ended the render.
    pub fn is_by_itself(&self, work: &Work) -> bool {
        self.has_decided() || work.is_finished()
    }

    /// Says whether what was asked for is reached.
    pub fn print(&self, checkpoint: Option<&Path>) {
        if let Some(target) = self.target {
            print_message(&format!(
                "{target} is {}reached: {}",
                if self.is_met { "" } else { "not " },
                self.told(target)
            ));
        }
        if let Some(path) = checkpoint {
            print_message(&format!("{}: all that is done, for --resume and abbe merge", path.display()));
        }
    }

    fn told(&self, target: Target) -> String {
        match self.estimate {
            Some(Estimate { value, at_most }) => {
                let percent = 100.0 * target::CONFIDENCE;
                format!(
                    "{}, at most {} with {percent} % confidence",
                    target.told(value),
                    target.told(at_most)
                )
            }
            None => "its error is not known".to_owned(),
        }
    }

    /// Whether the render is what was asked for.
    pub fn end(&self, work: &Work, is_shown: bool, checkpoint: Option<&Path>) -> Result<(), Failure> {
        let asked = work.samples().end - work.samples().start;
        let goes_on = checkpoint.map_or("", |_| "; --resume goes on");
        match self.target {
            Some(target) if !self.is_met && (work.is_finished() || self.is_out_of_time) => {
                let limit = if self.is_out_of_time { "--time" } else { "--spp" };
                Err(Failure::Stopped(format!(
                    "{target} is not reached within {limit}: what is done is written"
                )))
            }
            _ if self.is_met || self.is_out_of_time || work.is_finished() => Ok(()),
            _ if is_shown || checkpoint.is_some() => Err(Failure::Stopped(format!(
                "stopped: {} of {asked} samples per pixel were done, and are written{goes_on}",
                report::sample_count(&work.film().samples_per_pixel())
            ))),
            _ => Err(Failure::Stopped(
                "stopped: not every pixel had a sample yet, so nothing is written".to_owned(),
            )),
        }
    }
}

fn parse_samples(text: &str) -> Result<Range<u64>, String> {
    let ends =
        text.split_once("..").and_then(|(a, b)| Some((a.trim().parse().ok()?, b.trim().parse().ok()?)));
    match ends {
        Some((start, end)) if start < end => Ok(start..end),
        _ => Err("expected A..B, samples A to B − 1, for example 0..64 and 64..128".to_owned()),
    }
}

/// A time with its unit: s, m or h.
fn parse_time(text: &str) -> Result<Duration, String> {
    let wrong = || "expected a time such as 90s, 10m or 1.5h".to_owned();
    let (number, unit) = match text.trim().char_indices().last() {
        Some((at, 's')) => (&text[..at], 1.0),
        Some((at, 'm')) => (&text[..at], 60.0),
        Some((at, 'h')) => (&text[..at], 3600.0),
        _ => (text, 1.0),
    };
    let seconds = unit * number.trim().parse::<f64>().map_err(|_| wrong())?;
    Duration::try_from_secs_f64(seconds).ok().filter(|time| !time.is_zero()).ok_or_else(wrong)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_ranges_are_read() {
        let seconds = |text| parse_time(text).map(|time| time.as_secs_f64());
        assert_eq!([seconds("90"), seconds("90s"), seconds("1.5m")], [const { Ok(90.0) }; 3]);
        assert_eq!(seconds("2h"), Ok(7200.0));
        for wrong in ["", "m", "-1s", "0", "1d", "nan", "1e400s"] {
            assert!(parse_time(wrong).is_err(), "{wrong}");
        }
        assert_eq!(parse_samples("64..128"), Ok(64..128));
        for wrong in ["64", "4..4", "5..4", "..4", "a..b"] {
            assert!(parse_samples(wrong).is_err(), "{wrong}");
        }
    }
}
