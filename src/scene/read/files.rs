//! Files that a scene names: where they are sought, and reading them within limits.

use super::super::source::{Place, SceneError};
use super::{Reader, hints};
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// A larger scene file is refused: meshes belong into files of their own.
pub(in crate::scene) const LARGEST_SCENE_FILE: u64 = 256 << 20;

/// Folders in which files are sought, the first first, and what was found in them.
#[derive(Clone, Debug)]
pub(in crate::scene) struct Search {
    folders: Vec<PathBuf>,
    /// Shared with all searches that are made from this one.
    found: Arc<Mutex<BTreeSet<PathBuf>>>,
}

impl Search {
    pub fn new(folder: &Path) -> Self {
        Self { folders: vec![folder.to_owned()], found: Arc::default() }
    }

    /// The same, but with another folder before all others.
    pub fn after(&self, folder: &Path) -> Self {
        let folders = [&[folder.to_owned()], self.folders.as_slice()].concat();
        Self { folders, found: self.found.clone() }
    }

    /// Whether there is room for another folder: each file is sought in all of them.
    pub fn is_full(&self) -> bool {
        self.folders.len() >= 64
    }

    /// The path of the first that there is; in the first folder if there is none.
    pub fn find(&self, name: &str) -> PathBuf {
        let mut paths = self.folders.iter().map(|folder| folder.join(name));
        let Some(found) = paths.clone().find(|path| path.exists()) else {
            return paths.next().unwrap_or_else(|| name.into());
        };
        self.found.lock().unwrap_or_else(PoisonError::into_inner).insert(found.clone());
        found
    }

    /// All paths that [`Self::find`] has found.
    pub fn found(&self) -> BTreeSet<PathBuf> {
        self.found.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// Files that were read already; `None` for one that is wrong, which was reported.
#[derive(Debug)]
pub(in crate::scene) struct Loaded<K, T>(RefCell<BTreeMap<K, Option<Arc<T>>>>);

impl<K, T> Default for Loaded<K, T> {
    fn default() -> Self {
        Self(RefCell::default())
    }
}

impl<K: Ord + Clone, T> Loaded<K, T> {
    /// What is read from a file, the first time it is asked for.
    pub fn get(
        &self,
        reader: &Reader,
        key: &K,
        read: impl FnOnce() -> Result<T, SceneError>,
    ) -> Option<Arc<T>> {
        if let Some(known) = self.0.borrow().get(key) {
            return known.clone();
        }
        let loaded = read().map_err(|error| reader.error(error)).ok().map(Arc::new);
        self.0.borrow_mut().insert(key.clone(), loaded.clone());
        loaded
    }
}

/// The text of a scene file.
///
/// # Errors
/// What is wrong with it, in one sentence.
pub(in crate::scene) fn scene_text(path: &Path) -> Result<String, String> {
    let unreadable = |error: std::io::Error| format!("The file {} cannot be read: {error}", path.display());
    let metadata = std::fs::metadata(path).map_err(unreadable)?;
    if !metadata.is_file() {
        return Err(format!("The path {} is not a file", path.display()));
    }
    if metadata.len() > LARGEST_SCENE_FILE {
        return Err(format!("The file {} is too large ({} bytes)", path.display(), metadata.len()));
    }
    let bytes = std::fs::read(path).map_err(unreadable)?;
    let text = String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let bytes = error.as_bytes();
        let is_utf16 = [[0xff, 0xfe], [0xfe, 0xff]].iter().any(|mark| bytes.starts_with(mark));
        let begins = String::from_utf8_lossy(&bytes[..at]).trim_start().starts_with(['<', '{']);
        match is_utf16 || begins {
            true => format!(
                "The file {} is not text in UTF-8 (at byte {at}): save it in that encoding",
                path.display()
            ),
            false => format!("The file {} is not a scene", path.display()),
        }
    })?;
    Ok(without_mark(text))
}

/// Editors on Windows may begin a text with a byte order mark.
pub(in crate::scene) fn without_mark(text: String) -> String {
    text.strip_prefix(MARK).map(str::to_owned).unwrap_or(text)
}

const MARK: char = '\u{feff}';

/// How a file begins that stands in for one in Git's Large File Storage (its specification, version 1).
const LFS_POINTER: &[u8] = b"version https://git-lfs.github.com/spec/";

/// The content of a file that a scene names at `place`, if it is there and not larger than `most` bytes; that
/// of a text without a byte order mark, with which no other file begins.
pub(in crate::scene) fn read(path: &Path, most: u64, place: &Place) -> Result<Vec<u8>, SceneError> {
    let unreadable = |error: &std::io::Error| {
        let problem = match error.kind() {
            std::io::ErrorKind::NotFound => format!("There is no file {}", path.display()),
            _ => format!("The file {} cannot be read: {error}", path.display()),
        };
        let error = SceneError::at(
            place,
            problem,
            "expected the path of a file, relative to the scene file's folder",
        );
        match neighbour(path) {
            _ if path.to_string_lossy().contains(char::is_control) => error
                .with_remedy("the name has a control character: JSON writes a backslash as \\\\, or use /"),
            Some(near) => error.with_remedy(format!("did you mean \"{near}\"?")),
            None => error,
        }
    };
    let metadata = std::fs::metadata(path).map_err(|error| unreadable(&error))?;
    if !metadata.is_file() {
        return Err(SceneError::at(
            place,
            format!("The path {} is not a file", path.display()),
            "expected the path of a file",
        ));
    }
    if metadata.len() > most {
        let problem = format!("The file {} is too large ({} bytes)", path.display(), metadata.len());
        return Err(SceneError::at(place, problem, format!("expected at most {most} bytes")));
    }
    let mut bytes = std::fs::read(path).map_err(|error| unreadable(&error))?;
    if bytes.starts_with(MARK.encode_utf8(&mut [0; 4]).as_bytes()) {
        bytes.drain(..MARK.len_utf8());
    }
    if bytes.starts_with(LFS_POINTER) {
        let problem = format!("The file {} only tells Git LFS what belongs here", path.display());
        return Err(SceneError::at(place, problem, "expected the file itself")
            .with_remedy("git lfs pull, in the repository of the scene, fetches it"));
    }
    Ok(bytes)
}

/// A file in the same folder whose name is like that of `path`.
fn neighbour(path: &Path) -> Option<String> {
    let wanted = path.file_name()?.to_str()?;
    let entries = std::fs::read_dir(path.parent()?).ok()?;
    let mut names: Vec<String> =
        entries.take(10_000).filter_map(|entry| entry.ok()?.file_name().into_string().ok()).collect();
    names.sort();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    hints::nearest(wanted, &names).map(str::to_owned)
}
