//! Elements that are no part of an object: other names, and folders to seek files in.

use super::super::super::source::SceneError;
use super::super::attributes::start_tag;
use super::super::tree::{ObjectId, Tree, dangling};
use super::{Builder, Step};
use roxmltree::Node;

impl Builder<'_> {
    /// `<alias id="a" as="b"/>`: another name for an object that stands before it.
    pub(super) fn alias(&mut self, node: Node<'_, '_>) -> Step {
        let Some(attributes) = self.attributes(node, &["id", "as"], &[]) else { return Step::Broken };
        self.no_children(node);
        let (Some(id), Some(alias)) = (attributes.get("id"), attributes.get("as")) else {
            return Step::Broken;
        };
        let tree = &mut self.parsed.tree;
        let named = match tree.ids.get(&id.text) {
            Some(&object) => tree.name(&alias.text, &alias.place, object, self.sources),
            None => {
                let error = dangling(&id.text, &id.place, tree.ids.keys());
                Err(SceneError { expected: "expected the id of an object above".to_owned(), ..error })
            }
        };
        named.map_or_else(
            |error| {
                self.error(error);
                Step::Broken
            },
            |()| Step::Nothing,
        )
    }

    /// `<path value="folder"/>`: files are sought in that folder first.
    pub(super) fn path(&mut self, node: Node<'_, '_>, owner: ObjectId) -> Step {
        let Some(attributes) = self.attributes(node, &["value"], &[]) else { return Step::Broken };
        self.no_children(node);
        let Some(value) = attributes.get("value") else { return Step::Broken };
        if owner != Tree::ROOT {
            let place = start_tag(node, self.file);
            let problem = "<path> stands within an object";
            self.error(SceneError::at(&place, problem, "expected it directly in the <scene>"));
            return Step::Broken;
        }
        if self.parsed.search.is_full() {
            let problem = "The scene has too many folders to seek files in";
            self.error(SceneError::at(&value.place, problem, "expected fewer <path>"));
            return Step::Broken;
        }
        let folder = self.parsed.search.find(&value.text);
        if !folder.is_dir() {
            let problem = format!("There is no folder {}", folder.display());
            let expected = "expected the path of a folder, relative to the scene file's folder";
            self.error(SceneError::at(&value.place, problem, expected));
            return Step::Broken;
        }
        self.parsed.search = self.parsed.search.after(&folder);
        Step::Nothing
    }
}
