use super::super::super::print_message;
use super::super::super::progress::RenderProgress;
use super::super::super::tev::Tev;
use super::super::super::view::Page;
use super::super::outcome::Outcome;
use super::super::until::Decision;
use super::LongOptions;
use super::kept::Kept;
use abbe::film::Film;
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
    /// Whether every pixel has a sample.
    is_begun: AtomicBool,
    decision: Decision,
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
        let end = options.until.end(samples.end, total);
        let watching = Self {
            progress: RenderProgress::new(end, before, quiet, stop.clone()),
            kept,
            options,
            started: Instant::now(),
            next: AtomicU64::new(millis(options.between_checkpoints())),
            is_begun: AtomicBool::new(*film.samples_per_pixel().start() > 0),
            decision: Decision::default(),
            viewer: Mutex::new(viewers.tev),
            page: viewers.page,
            total,
            stop,
        };
        // What goes on may have been good enough.
        watching.decide(work);
        watching
    }

    /// Ends what is told: what became of the render, and how long it took, s.
    pub fn finish(self, work: &Work) -> (Outcome, f64) {
        let outcome = self.decision.outcome(&self.options.until, work);
        let seconds = self.started.elapsed().as_secs_f64();
        self.show(work.film());
        self.progress.finish();
        (outcome, seconds)
    }

    /// Ends the render where its error is small enough. Whether it was looked at, and told.
    fn decide(&self, work: &Work) -> bool {
        let Some(look) = self.decision.at_error(&self.options.until, work) else { return false };
        self.progress.tells(look.told());
        if look.is_met() {
            self.stop.store(true, Ordering::Relaxed);
        }
        true
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
}

fn millis(time: Duration) -> u64 {
    u64::try_from(time.as_millis()).unwrap_or(u64::MAX)
}

impl Progress for Watching<'_> {
    fn advanced(&self, samples: u64) {
        self.progress.advanced(samples);
        if self.is_begun.load(Ordering::Relaxed)
            && !self.stop.load(Ordering::Relaxed)
            && self.decision.at_time(&self.options.until, self.started.elapsed())
        {
            self.stop.store(true, Ordering::Relaxed);
        }
    }

    fn pass_done(&self, work: &Work) {
        self.is_begun.store(true, Ordering::Relaxed);
        if !self.decide(work) {
            self.progress.pass_done(work);
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
        let pause = self.options.between_checkpoints().max(began.elapsed() * RARELY);
        self.next.store(millis(self.started.elapsed() + pause), Ordering::Relaxed);
    }

    fn stop(&self) -> &AtomicBool {
        &self.stop
    }
}
