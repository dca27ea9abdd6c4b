//! Lines for whoever reads a log: at least one every ten seconds.

use super::print_message;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Longest silence.
const PERIOD: Duration = Duration::from_secs(10);

/// Breaks the silence until it is dropped.
pub struct Pulse {
    last: Arc<Mutex<Instant>>,
    /// Dropped to end the thread.
    end: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Pulse {
    /// `line` says how far things are.
    pub fn new(line: impl Fn() -> String + Send + 'static) -> Self {
        Self::with_period(PERIOD, move || print_message(&line()))
    }

    fn with_period(period: Duration, beat: impl Fn() + Send + 'static) -> Self {
        let last = Arc::new(Mutex::new(Instant::now()));
        let (end, ended) = channel();
        let heard = last.clone();
        let thread = std::thread::Builder::new()
            .name("progress".to_owned())
            .spawn(move || beat_on(&heard, period, &ended, beat))
            // Without it the lines between are missing and nothing else.
            .ok();
        Self { last, end: Some(end), thread }
    }

    /// Says another line. The silence begins anew.
    pub fn says(&self, line: &str) {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        print_message(line);
        *last = Instant::now();
    }
}

fn beat_on(last: &Mutex<Instant>, period: Duration, ended: &Receiver<()>, beat: impl Fn()) {
    let mut wait = period;
    while ended.recv_timeout(wait) == Err(RecvTimeoutError::Timeout) {
        let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
        if last.elapsed() >= period {
            beat();
            *last = Instant::now();
        }
        wait = period.saturating_sub(last.elapsed());
    }
}

impl Drop for Pulse {
    fn drop(&mut self) {
        self.end = None;
        if let Some(thread) = self.thread.take() {
            // It has nothing to hand over.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU32, Ordering};

    #[test]
    fn a_pulse_breaks_silence_alone() {
        let beats = Arc::new(AtomicU32::new(0));
        let counted = beats.clone();
        let pulse = Pulse::with_period(Duration::from_millis(200), move || {
            counted.fetch_add(1, Ordering::Relaxed);
        });
        // Others speak more often than the period.
        for _ in 0..40 {
            std::thread::sleep(Duration::from_millis(10));
            *pulse.last.lock().unwrap() = Instant::now();
        }
        assert_eq!(beats.load(Ordering::Relaxed), 0);
        std::thread::sleep(Duration::from_millis(700));
        let heard = beats.load(Ordering::Relaxed);
        assert!((1..=3).contains(&heard), "{heard}");
        drop(pulse);
        let at_end = beats.load(Ordering::Relaxed);
        std::thread::sleep(Duration::from_millis(300));
        assert_eq!(beats.load(Ordering::Relaxed), at_end);
    }
}
