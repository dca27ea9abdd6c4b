//! Hints to the processor and the operating system about memory. They change no result.

/// Asks for a value to be brought near while something else is done.
#[inline(always)]
pub(super) fn prefetch<T>(value: &T) {
    #[cfg(target_arch = "x86_64")]
    for line in (0..size_of::<T>()).step_by(64) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let start = std::ptr::from_ref(value).cast::<i8>();
        // SAFETY: the address is one within `value`, and a prefetch neither reads nor faults.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(start.add(line)) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = value;
}

/// A list with room for so many items, in large pages where the system has them: a ray that goes through a large tree needs another
/// page for nearly every node, and to find out where each of them is takes about as long as to fetch the node.
pub(super) fn in_large_pages<T>(capacity: usize) -> Vec<T> {
    let list = Vec::with_capacity(capacity);
    #[cfg(target_os = "linux")]
    {
        const PAGE: usize = 4096;
        let start = (list.as_ptr() as usize).next_multiple_of(PAGE);
        let end = (list.as_ptr() as usize + capacity * size_of::<T>()) / PAGE * PAGE;
        if start < end {
            // SAFETY: whole pages that belong to the list; the advice does not change what is in them. Failure means small pages.
            unsafe { libc::madvise(start as *mut libc::c_void, end - start, libc::MADV_HUGEPAGE) };
        }
    }
    list
}
