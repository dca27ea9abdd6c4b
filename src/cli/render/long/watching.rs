use super::super::super::print_message;
use super::super::super::progress::{End, RenderProgress};
use super::super::super::tev::Tev;
use super::super::super::view::Page;
use super::kept::Kept;
use super::outcome::Outcome;
use super::{LongOptions, MOST_SAMPLES};
use abbe::film::Film;
use abbe::output::target::Target;
use abbe::render::{Progress, Work};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Largest fraction of the time that checkpoints take, as one over it.
const RARELY: u32 = 20;

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
        let is_open = options.ends_early() && samples.end >= u64::from(MOST_SAMPLES);
        let end = if is_open { End::Open { time: options.time } } else { End::Samples(total) };
        let watching = Self {
            progress: RenderProgress::new(end, before, quiet, stop.clone()),
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

    /// Ends the render where its error is small enough. Whether it was looked at, and told.
    fn decide(&self, film: &Film) -> bool {
        let samples = *film.samples_per_pixel().start();
        let decides = |_: &Target| Target::decides_at(samples / self.replicates);
        let Some(target) = self.options.until.filter(decides) else { return false };
        let estimate = target.estimate(film);
        if let Some(estimate) = estimate {
            self.progress.tells(format!(
                "{}, at most {}",
                target.told(estimate.value),
                target.told(estimate.at_most)
            ));
        }
        if target.is_met(estimate) {
            self.decided(|decision| decision.is_met = true);
        }
        estimate.is_some()
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
        if !self.decide(film) {
            self.progress.pass_done(film);
        }
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
