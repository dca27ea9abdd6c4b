//! Signals by which the system tells that a file failed.

/// Takes note of them, as long as the program runs.
#[cfg(target_os = "linux")]
#[allow(unsafe_code, reason = "calls of the operating system")]
pub fn watch() {
    // SAFETY: to ignore a signal runs nothing of ours. A write beyond the largest file that is allowed then
    // fails as on a full disk, with an error that is told.
    unsafe { libc::signal(libc::SIGXFSZ, libc::SIG_IGN) };
    let handler: extern "C" fn(libc::c_int) = tell_and_end;
    // SAFETY: the handler only calls what a handler may call (signal-safety(7)), and does not return.
    unsafe { libc::signal(libc::SIGBUS, handler as libc::sighandler_t) };
}

/// For a page of a mapped file that can be neither read nor written: its disk has failed, or it is full after
/// all, as a disk that keeps old states of files may be. What asked for the page can't go on. Files that are
/// written are complete or not there, and the film's own has no name, so there is nothing to tidy up.
#[cfg(target_os = "linux")]
#[allow(unsafe_code, reason = "calls of the operating system")]
extern "C" fn tell_and_end(_: libc::c_int) {
    const MESSAGE: &str = "\nerror: a page of a file that is mapped into memory cannot be read or written: its \
                           disk is full or has failed\nhelp: go on from a checkpoint with --resume, or name an \
                           --output on another disk\n";
    // SAFETY: the message lives as long as the program; both calls are safe in handlers.
    unsafe {
        libc::write(libc::STDERR_FILENO, MESSAGE.as_ptr().cast(), MESSAGE.len());
        libc::_exit(1);
    }
}

#[cfg(not(target_os = "linux"))]
pub fn watch() {}
