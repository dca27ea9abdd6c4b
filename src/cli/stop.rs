//! Signals that end a command before its end: Ctrl-C, SIGTERM, and SIGHUP, which a closed terminal sends.

use super::Failure;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

/// A second signal that comes sooner belongs to the first: who closes a terminal sends SIGHUP, and so may the
/// shell in it.
const ONE_EVENT: Duration = Duration::from_millis(500);

/// A flag that the first signal raises; a second ends the program.
pub fn stop_on_signal() -> Result<Arc<AtomicBool>, Failure> {
    let stop = Arc::new(AtomicBool::new(false));
    let (raised, first) = (stop.clone(), OnceLock::new());
    let hangups_are_ignored = hangups_are_ignored();
    ctrlc::set_handler(move || {
        if raised.swap(true, Ordering::Relaxed) && first.get_or_init(Instant::now).elapsed() > ONE_EVENT {
            std::process::exit(130);
        }
        first.get_or_init(Instant::now);
    })
    .map_err(|error| Failure::Other(format!("error: cannot watch for signals: {error}")))?;
    if hangups_are_ignored {
        ignore_hangups();
    }
    Ok(stop)
}

/// Whether the program was started to outlive its terminal, as by `nohup`.
#[cfg(unix)]
#[allow(unsafe_code, reason = "a call of the operating system")]
fn hangups_are_ignored() -> bool {
    let mut action = std::mem::MaybeUninit::<libc::sigaction>::zeroed();
    // SAFETY: without a new action nothing is changed; the old one is written where there is room for it,
    // which is initialised whatever happens.
    unsafe {
        libc::sigaction(libc::SIGHUP, std::ptr::null(), action.as_mut_ptr()) == 0
            && action.assume_init().sa_sigaction == libc::SIG_IGN
    }
}

#[cfg(unix)]
#[allow(unsafe_code, reason = "a call of the operating system")]
fn ignore_hangups() {
    // SAFETY: to ignore a signal runs nothing of ours.
    unsafe { libc::signal(libc::SIGHUP, libc::SIG_IGN) };
}

#[cfg(not(unix))]
fn hangups_are_ignored() -> bool {
    false
}

#[cfg(not(unix))]
fn ignore_hangups() {}
