//! Hints to the processor and the operating system about memory. They change no result.

/// Prefetches a number of bytes while something else is done. The address may be any.
#[inline(always)]
#[allow(unsafe_code, reason = "the instruction has no safe name in the standard library")]
pub(super) fn prefetch<const BYTES: usize>(address: *const u8) {
    #[cfg(target_arch = "x86_64")]
    for line in (0..BYTES).step_by(64) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: a prefetch neither reads nor faults, whatever the address.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(address.wrapping_add(line).cast()) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = address;
}

/// A list with room for so many items, in large pages where the system has them: a ray that goes through a
/// large tree needs another page for nearly every node, and to find out where each of them is takes about as
/// long as to fetch the node.
#[allow(unsafe_code, reason = "a call of the operating system")]
pub(super) fn in_large_pages<T>(capacity: usize) -> Vec<T> {
    let list = Vec::with_capacity(capacity);
    #[cfg(target_os = "linux")]
    {
        const PAGE: usize = 4096;
        const LARGE_PAGE: usize = 1 << 21;
        let start = (list.as_ptr() as usize).next_multiple_of(PAGE);
        let end = (list.as_ptr() as usize + capacity * size_of::<T>()) / PAGE * PAGE;
        if start + 2 * LARGE_PAGE < end {
            // SAFETY: whole pages that belong to the list; the advice does not change what is in them.
            // Failure means small pages.
            unsafe { libc::madvise(start as *mut libc::c_void, end - start, libc::MADV_HUGEPAGE) };
        }
    }
    list
}
