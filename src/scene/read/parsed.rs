//! What both grammars, XML and JSON, make of a scene file.

use super::super::description::Note;
use super::super::source::SceneError;
use super::files::Search;
use super::tree::Tree;

#[derive(Debug)]
pub(super) struct Parsed {
    pub tree: Tree,
    pub errors: Vec<SceneError>,
    pub assumptions: Vec<Note>,
    /// Where the files that the scene names are sought.
    pub search: Search,
}

impl Parsed {
    pub fn new(search: Search) -> Self {
        Self { tree: Tree::default(), errors: Vec::new(), assumptions: Vec::new(), search }
    }
}
