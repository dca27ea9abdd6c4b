//! What a render tells while it runs: a bar on a terminal, plain lines elsewhere.

use abbe::film::Film;
use abbe::render::{Schedule, Watch};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use std::fmt::Write;
use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

pub struct Progress {
    bar: ProgressBar,
    /// Lines instead of a bar.
    plain: bool,
    total: u64,
    done: AtomicU64,
    started: Instant,
    stop: Arc<AtomicBool>,
}

impl Progress {
    pub fn new(pixels: u64, schedule: Schedule, quiet: bool, stop: Arc<AtomicBool>) -> Self {
        let total = pixels * schedule.samples();
        let terminal = std::io::stderr().is_terminal();
        let bar = ProgressBar::new(total);
        bar.set_draw_target(if quiet || !terminal {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr_with_hz(5)
        });
        if let Ok(style) = ProgressStyle::with_template(
            "{bar:32} {percent:>3} %  {human_pos} of {human_len} samples  {rate}  {eta} left  {msg}",
        ) {
            let rate = |state: &ProgressState, out: &mut dyn Write| {
                // Where the bar cannot be drawn nothing is lost.
                let _ = write!(out, "{:.2} million/s", state.per_sec() / 1e6);
            };
            bar.set_style(style.with_key("rate", rate));
        }
        bar.enable_steady_tick(Duration::from_millis(250));
        Self {
            bar,
            plain: !quiet && !terminal,
            total,
            done: AtomicU64::new(0),
            started: Instant::now(),
            stop,
        }
    }

    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }

    pub fn elapsed(&self) -> Duration {
        self.started.elapsed()
    }
}

impl Watch for Progress {
    fn advanced(&self, samples: u64) {
        self.done.fetch_add(samples, Ordering::Relaxed);
        self.bar.inc(samples);
    }

    fn pass_done(&self, film: &Film) {
        let error = match film.relative_error() {
            Some(error) => format!("error {}", percent(error)),
            None => "error not known yet".to_owned(),
        };
        self.bar.set_message(error.clone());
        if self.plain {
            let done = self.done.load(Ordering::Relaxed);
            let seconds = self.started.elapsed().as_secs_f64().max(1e-9);
            let rate = done as f64 / seconds;
            eprintln!(
                "{:3.0} %  {done} of {} samples  {:.2} million/s  {:.0} s left  {error}",
                100.0 * done as f64 / self.total as f64,
                self.total,
                rate / 1e6,
                (self.total - done) as f64 / rate,
            );
        }
    }

    fn stop(&self) -> &AtomicBool {
        &self.stop
    }
}

/// Three significant digits.
pub fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    let digits = (2.0 - percent.abs().max(1e-9).log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{percent:.digits$} %")
}
