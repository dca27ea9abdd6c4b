//! The time and the memory that one thread takes.

use cpu_time::ThreadTime;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::time::Duration;

/// Counts what each thread allocates, and the most that it had.
struct Counting;

thread_local! {
    /// Below 0 where a thread frees what another has allocated.
    static ALLOCATED: Cell<isize> = const { Cell::new(0) };
    static PEAK: Cell<isize> = const { Cell::new(0) };
}

#[allow(unsafe_code, reason = "an allocator is unsafe by its nature")]
// SAFETY: every call goes to the system's allocator as it is. The counters allocate nothing and have no
// destructor.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let now = ALLOCATED.get() + layout.size() as isize;
        ALLOCATED.set(now);
        PEAK.set(PEAK.get().max(now));
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        ALLOCATED.set(ALLOCATED.get() - layout.size() as isize);
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// What comes of something, the CPU time that it takes, and the most memory that it has beyond what there
/// was.
pub fn measured<T>(run: impl FnOnce() -> T) -> (T, Duration, usize) {
    let before = ALLOCATED.get();
    PEAK.set(before);
    let began = ThreadTime::now();
    let outcome = run();
    (outcome, began.elapsed(), PEAK.get().saturating_sub(before) as usize)
}
