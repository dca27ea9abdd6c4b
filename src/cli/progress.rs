//! What a render tells while it runs: a bar on a terminal, plain lines elsewhere.

use super::pulse::Pulse;
use abbe::output::target::Target;
use abbe::render::{Progress, Work};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use std::fmt::Write;
use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

pub struct RenderProgress {
    bar: ProgressBar,
    /// Lines instead of a bar.
    lines: Option<(Pulse, Arc<Counted>)>,
    stop: Arc<AtomicBool>,
}

/// When a render ends, as far as that is known.
#[derive(Clone, Copy)]
pub enum End {
    /// After so many samples in all.
    Samples(u64),
    /// After a time, or at an error: nobody knows which, and after how many samples.
    Open { time: Option<Duration> },
}

/// How far a render is.
struct Counted {
    end: End,
    /// Done before it began.
    before: u64,
    done: AtomicU64,
    started: Instant,
    /// As the last pass told it.
    error: Mutex<String>,
}

impl Counted {
    fn line(&self) -> String {
        let done = self.done.load(Ordering::Relaxed);
        let rate = (done - self.before) as f64 / self.started.elapsed().as_secs_f64().max(1e-9);
        let speed = rate / 1e6;
        let error = self.error.lock().unwrap_or_else(PoisonError::into_inner);
        let total = match self.end {
            End::Samples(total) => total,
            End::Open { time } => {
                let left = time_to(time, self.started);
                return format!("{done} samples  {speed:.2} million/s  {left}{error}");
            }
        };
        let left = match done {
            _ if rate == 0.0 => "time left not known".to_owned(),
            _ => format!("{:.0} s left", total.saturating_sub(done) as f64 / rate),
        };
        let percent = 100.0 * done as f64 / total.max(1) as f64;
        format!("{percent:3.0} %  {done} of {total} samples  {speed:.2} million/s  {left}  {error}")
    }
}

const NO_ERROR_YET: &str = "error not known yet";

/// What is left of a time, where there is one.
fn time_to(time: Option<Duration>, started: Instant) -> String {
    time.map_or_else(String::new, |time| {
        format!("at most {:.0} s left  ", time.saturating_sub(started.elapsed()).as_secs_f64())
    })
}

impl RenderProgress {
    /// Progress of a render until its end; so many samples are done before it begins.
    pub fn new(end: End, before: u64, quiet: bool, stop: Arc<AtomicBool>) -> Self {
        let terminal = std::io::stderr().is_terminal();
        let started = Instant::now();
        let bar = match end {
            End::Samples(total) => ProgressBar::new(total),
            End::Open { .. } => ProgressBar::no_length(),
        };
        let bar = bar.with_position(before);
        bar.reset_eta();
        bar.set_draw_target(if quiet || !terminal {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr_with_hz(5)
        });
        let template = match end {
            End::Samples(_) => {
                "{bar:32} {percent:>3} %  {human_pos} of {human_len} samples  {rate}  {eta} left  {msg}"
            }
            End::Open { .. } => "{spinner} {human_pos} samples  {rate}  {limit}{msg}",
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            let limit = move |_: &ProgressState, out: &mut dyn Write| {
                if let End::Open { time } = end {
                    let _ = write!(out, "{}", time_to(time, started));
                }
            };
            let rate = |state: &ProgressState, out: &mut dyn Write| {
                // Where the bar cannot be drawn nothing is lost.
                let _ = write!(out, "{:.2} million/s", state.per_sec() / 1e6);
            };
            bar.set_style(style.with_key("rate", rate).with_key("limit", limit));
        }
        bar.enable_steady_tick(Duration::from_millis(250));
        let lines = (!quiet && !terminal).then(|| {
            let counted = Arc::new(Counted {
                end,
                before,
                done: AtomicU64::new(before),
                started,
                error: Mutex::new(NO_ERROR_YET.to_owned()),
            });
            let told = counted.clone();
            (Pulse::new(move || told.line()), counted)
        });
        Self { bar, lines, stop }
    }

    /// Tells what the error is now.
    pub fn tells(&self, error: String) {
        self.bar.set_message(error.clone());
        if let Some((pulse, counted)) = &self.lines {
            *counted.error.lock().unwrap_or_else(PoisonError::into_inner) = error;
            pulse.says(&counted.line());
        }
    }

    /// Ends what is told of the render.
    pub fn finish(self) {
        self.bar.finish_and_clear();
    }
}

impl Progress for RenderProgress {
    fn advanced(&self, samples: u64) {
        if let Some((_, counted)) = &self.lines {
            counted.done.fetch_add(samples, Ordering::Relaxed);
        }
        self.bar.inc(samples);
    }

    fn pass_done(&self, work: &Work) {
        if self.bar.is_hidden() && self.lines.is_none() {
            return;
        }
        self.tells(match Target::mean_error(work.film()) {
            Some(error) => format!("error {}", percent(error)),
            None => NO_ERROR_YET.to_owned(),
        });
    }

    fn stop(&self) -> &AtomicBool {
        &self.stop
    }
}

/// What a study tells while it runs.
pub struct StudyProgress {
    bar: ProgressBar,
    /// Lines instead of a bar.
    lines: Option<Pulse>,
    started: Instant,
    /// Never raised: a run under way is finished.
    never: AtomicBool,
    /// Raised by a signal.
    stop: Arc<AtomicBool>,
    /// That the study ends has been told.
    told: AtomicBool,
}

impl StudyProgress {
    pub fn new(quiet: bool, stop: Arc<AtomicBool>) -> Self {
        let terminal = std::io::stderr().is_terminal();
        let bar = ProgressBar::new(0);
        bar.set_draw_target(if quiet || !terminal {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr_with_hz(5)
        });
        if let Ok(style) =
            ProgressStyle::with_template("{bar:32} {percent:>3} %  {eta} left  {prefix}  {msg}")
        {
            bar.set_style(style);
        }
        let started = Instant::now();
        let lines = (!quiet && !terminal).then(|| {
            let bar = bar.clone();
            Pulse::new(move || {
                let fraction = bar.position() as f64 / bar.length().unwrap_or(0).max(1) as f64;
                let under_way = bar.message();
                format!("{:3.0} %  {under_way}  {}", 100.0 * fraction, time_left(&bar, started))
            })
        });
        Self { bar, lines, started, never: AtomicBool::new(false), stop, told: AtomicBool::new(false) }
    }

    /// With so many samples to do, of what is named.
    pub fn begin(&self, samples: u64, what: &str) {
        self.bar.set_length(samples);
        self.bar.set_prefix(what.to_owned());
        self.bar.enable_steady_tick(Duration::from_millis(250));
    }

    /// What is under way.
    pub fn says(&self, what: &str) {
        self.bar.set_message(what.to_owned());
    }

    /// The `index`-th run of all is done, with this relative RMSE.
    pub fn run_done(&self, index: usize, all: usize, name: &str, error: f64) {
        if let Some(pulse) = &self.lines {
            let (error, left) = (percent(error), time_left(&self.bar, self.started));
            pulse.says(&format!("{index} of {all}  {name}  relative RMSE {error}  {left}"));
        }
    }

    /// Ends what is told of the study.
    pub fn finish(&mut self) {
        self.bar.finish_and_clear();
        self.lines = None;
    }
}

/// By the time that what is done has taken.
fn time_left(bar: &ProgressBar, started: Instant) -> String {
    match (bar.position(), bar.length()) {
        (done, Some(total)) if done > 0 => {
            let seconds = started.elapsed().as_secs_f64();
            format!("{:.0} s left", seconds * total.saturating_sub(done) as f64 / done as f64)
        }
        _ => "time left not known".to_owned(),
    }
}

impl Progress for StudyProgress {
    fn advanced(&self, samples: u64) {
        self.bar.inc(samples);
        if self.stop.load(Ordering::Relaxed) && !self.told.swap(true, Ordering::Relaxed) {
            let text = "finishing the run under way; Ctrl-C again gives it up";
            match &self.lines {
                Some(pulse) => pulse.says(text),
                None => self.bar.println(text),
            }
        }
    }

    fn pass_done(&self, _: &Work) {}

    fn stop(&self) -> &AtomicBool {
        &self.never
    }
}

/// Three significant digits.
pub fn percent(fraction: f64) -> String {
    let percent = 100.0 * fraction;
    let digits = (2.0 - percent.abs().max(1e-9).log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{percent:.digits$} %")
}
