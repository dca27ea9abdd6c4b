//! `<include>`: the objects of another file in the place of the element.
//!
//! As in Mitsuba 3.9.1: the file is a `<scene>` with a version of its own, or a single object with a version.
//! Files to include are sought in the folder of the including file first; everything else is sought from the
//! main scene's folder. `$name` is shared in both directions.

use super::super::super::source::{Place, SceneError};
use super::super::attributes::{Attribute, start_tag};
use super::super::files;
use super::super::tree::{DEEPEST, ObjectId};
use super::malformed::malformed;
use super::{Builder, Step, lenient};
use roxmltree::{Document, Node};
use std::path::{Path, PathBuf};

/// Most files that a scene includes, again and again counted.
const MOST_INCLUDES: usize = 1000;

/// Most bytes of all included files together.
const MOST_BYTES: usize = files::LARGEST_SCENE_FILE as usize;

/// The files that are being read, the main scene first.
#[derive(Debug)]
pub(super) struct Includes {
    open: Vec<PathBuf>,
    files: usize,
    bytes: usize,
}

impl Includes {
    pub fn of(main: &Path) -> Self {
        Self { open: vec![main.to_owned()], files: 0, bytes: 0 }
    }
}

impl Builder<'_> {
    pub(super) fn include(&mut self, node: Node<'_, '_>, owner: ObjectId, depth: usize) -> Step {
        let Some(attributes) = self.attributes(node, &["filename"], &["name"]) else { return Step::Broken };
        self.no_children(node);
        let Some(filename) = attributes.get("filename") else { return Step::Broken };
        match self.included_text(filename, depth) {
            Ok((path, text)) => {
                let file = self.sources.add(&path, text.clone());
                let outer = (self.file, self.old);
                self.file = file;
                let search = self.parsed.search.clone();
                self.includes.open.push(path);
                match Document::parse(&lenient::accepted(&text)) {
                    Ok(document) => self.included(document.root_element(), owner, depth),
                    Err(error) => self.error(malformed(&error, &text, file)),
                }
                self.includes.open.pop();
                // A <path> in an included file ends with it.
                self.parsed.search = search;
                (self.file, self.old) = outer;
                Step::Nothing
            }
            Err(error) => {
                self.error(error);
                Step::Broken
            }
        }
    }

    /// The path and the text of a file to include.
    fn included_text(&mut self, filename: &Attribute, depth: usize) -> Result<(PathBuf, String), SceneError> {
        let place: &Place = &filename.place;
        let here = self.includes.open.last().and_then(|path| path.parent());
        let path = here.map_or_else(
            || self.parsed.search.find(&filename.text),
            |folder| self.parsed.search.after(folder).find(&filename.text),
        );
        let canonical = |path: &PathBuf| path.canonicalize().unwrap_or_else(|_| path.clone());
        if self.includes.open.iter().any(|open| canonical(open) == canonical(&path)) {
            return Err(SceneError::at(
                place,
                format!("The file {} includes itself", path.display()),
                "this leads back to a file that is being read",
            ));
        }
        if depth >= DEEPEST || self.includes.open.len() >= DEEPEST || self.includes.files >= MOST_INCLUDES {
            let problem = format!("The scene includes more than {MOST_INCLUDES} files, or too deep");
            let expected =
                format!("expected at most {MOST_INCLUDES} files, not more than {DEEPEST} within one another");
            return Err(SceneError::at(place, problem, expected));
        }
        if !path.is_file() {
            // The message with the nearest name.
            files::read(&path, files::LARGEST_SCENE_FILE, place)?;
        }
        let text = files::scene_text(&path)
            .map_err(|problem| SceneError::at(place, problem, "expected a scene file in XML"))?;
        self.includes.files += 1;
        self.includes.bytes += text.len();
        if self.includes.bytes > MOST_BYTES {
            let expected = format!("expected at most {MOST_BYTES} bytes");
            return Err(SceneError::at(place, "All included files together are too large", expected));
        }
        Ok((path, text))
    }

    /// The outermost element of an included file.
    fn included(&mut self, node: Node<'_, '_>, owner: ObjectId, depth: usize) {
        if node.tag_name().name() == "scene" {
            if self.root_attributes(node) {
                self.entries(node, owner, depth, true);
            }
            return;
        }
        if !node.has_attribute("version") {
            let error = SceneError::at(
                &start_tag(node, self.file),
                format!("The outermost <{}> has no attribute \"version\"", node.tag_name().name()),
                "expected version=\"3.0.0\" here",
            );
            self.error(error);
            return;
        }
        self.add(node, owner, depth, true);
    }
}
