//! The sums of spectral bins: in memory, or in a file where they are many.
//!
//! With 47 bins nine tenths of a film are bins, and they are needed a few rows at a time. Beyond a size they
//! are therefore in a file without a name, which is mapped into memory. The pages that were used are given
//! back every now and then, so that a process holds few of them, whatever the size of the film; the system
//! keeps as much of the file in its own cache as there is room for.

#![allow(unsafe_code, reason = "memory that is mapped to a file")]

use std::io::Result;
use std::ops::{Deref, DerefMut};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Largest sums that are kept in memory, bytes.
const IN_MEMORY: usize = 128 << 20;

/// Bytes of the file that may be used before its pages are given back.
const IN_USE: usize = 64 << 20;

/// Where the sums of spectral bins are.
#[derive(Clone, Copy, Debug)]
pub enum Storage<'a> {
    /// In main memory.
    Memory,
    /// In a file without a name in this folder, if they are more than 128 MiB.
    Folder(&'a Path),
}

/// Integers, all zero at first.
#[derive(Debug)]
pub(super) struct Integers {
    kept: Kept,
    /// Bytes used since pages were last given back.
    used: AtomicUsize,
}

#[derive(Debug)]
enum Kept {
    Memory(Vec<i64>),
    File(memmap2::MmapMut),
}

impl Integers {
    /// # Errors
    /// Where there is no room for them in the folder.
    pub fn new(count: usize, storage: Storage) -> Result<Self> {
        let kept = match storage {
            Storage::Folder(folder) if count * size_of::<i64>() > IN_MEMORY => {
                Kept::File(mapped(count * size_of::<i64>(), folder)?)
            }
            _ => return Ok(Self::in_memory(count)),
        };
        Ok(Self { kept, used: AtomicUsize::new(0) })
    }

    pub fn in_memory(count: usize) -> Self {
        Self { kept: Kept::Memory(vec![0; count]), used: AtomicUsize::new(0) }
    }

    /// Counts integers that were read or written, and gives pages back when there are many.
    pub fn uses(&self, count: usize) {
        if let Kept::File(map) = &self.kept
            && self.used.fetch_add(count * size_of::<i64>(), Ordering::Relaxed) > IN_USE
        {
            self.used.store(0, Ordering::Relaxed);
            give_back(map);
        }
    }
}

impl Deref for Integers {
    type Target = [i64];

    fn deref(&self) -> &[i64] {
        match &self.kept {
            Kept::Memory(integers) => integers,
            // SAFETY: a map begins at a page, so it is aligned; its length is a multiple of that of an
            // integer; and all bits are integers. Nobody else has the file, which has no name.
            Kept::File(map) => unsafe {
                std::slice::from_raw_parts(map.as_ptr().cast(), map.len() / size_of::<i64>())
            },
        }
    }
}

impl DerefMut for Integers {
    fn deref_mut(&mut self) -> &mut [i64] {
        match &mut self.kept {
            Kept::Memory(integers) => integers,
            // SAFETY: as above, and the map is borrowed mutably.
            Kept::File(map) => unsafe {
                std::slice::from_raw_parts_mut(map.as_mut_ptr().cast(), map.len() / size_of::<i64>())
            },
        }
    }
}

/// So many bytes of a file without a name.
fn mapped(bytes: usize, folder: &Path) -> Result<memmap2::MmapMut> {
    let file = tempfile::tempfile_in(folder)?;
    // Where there is no room the file is refused now: a page that finds none later ends the program.
    allocate(&file, bytes)?;
    // SAFETY: the file has no name, so nobody else changes it.
    unsafe { memmap2::MmapOptions::new().len(bytes).map_mut(&file) }
}

#[cfg(target_os = "linux")]
fn allocate(file: &std::fs::File, bytes: usize) -> Result<()> {
    use std::os::fd::AsRawFd;
    let length = libc::off_t::try_from(bytes).map_err(std::io::Error::other)?;
    // SAFETY: the descriptor is that of an open file.
    match unsafe { libc::posix_fallocate(file.as_raw_fd(), 0, length) } {
        0 => Ok(()),
        error => Err(std::io::Error::from_raw_os_error(error)),
    }
}

#[cfg(not(target_os = "linux"))]
fn allocate(file: &std::fs::File, bytes: usize) -> Result<()> {
    file.set_len(bytes as u64)
}

#[cfg(unix)]
fn give_back(map: &memmap2::MmapMut) {
    // SAFETY: the map is shared with its file, from which its pages come again, as they are, when they are
    // next used. That it cannot be done costs memory and nothing else.
    let _ = unsafe { map.unchecked_advise(memmap2::UncheckedAdvice::DontNeed) };
}

#[cfg(not(unix))]
fn give_back(_: &memmap2::MmapMut) {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_given_back_comes_again() {
        let folder = std::env::temp_dir();
        let count = IN_MEMORY / size_of::<i64>() + 1;
        let mut integers = Integers::new(count, Storage::Folder(&folder)).expect("there is room");
        assert!(matches!(integers.kept, Kept::File(_)));
        let number = |i: usize| (i as i64).wrapping_mul(0x1234_5678_9abc) - 5;
        for i in (0..count).step_by(4099) {
            assert_eq!(integers[i], 0);
            integers[i] = number(i);
            integers.uses(4099);
        }
        integers.uses(count);
        assert!((0..count).step_by(4099).all(|i| integers[i] == number(i)));
        let few = Integers::new(10, Storage::Folder(&folder)).expect("there is room");
        assert!(matches!(few.kept, Kept::Memory(_)));
        assert!(Integers::new(count, Storage::Folder(Path::new("/no/such/folder"))).is_err());
    }
}
