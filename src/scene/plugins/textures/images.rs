//! Images that a scene names, and how they lie on a surface.

use super::super::{Field, Parameter, Takes};
use crate::geometry::Transform;
use crate::raster::Image;
use crate::scene::info::hash_of_values;
use crate::scene::read::Query;
use crate::scene::read::textures::decoded_image;
use crate::scene::write::{self, Node, Writer};
use std::path::PathBuf;
use std::sync::Arc;

/// Plugins whose "filename" is an image.
pub const PLUGINS: [&str; 3] = ["bitmap", "envmap", "heightfield"];

/// The image that a property names, with its path.
pub fn image(query: &Query<'_>, name: &'static str) -> Option<(PathBuf, Arc<Image>)> {
    let reader = query.reader;
    let path = query.file(name)?;
    let image = reader.images.get(reader, &path, || {
        let ahead = reader.ahead.borrow_mut().images.remove(&path);
        ahead.map_or_else(|| decoded_image(&path, &query.place(name)), Ok)
    })?;
    Some((path, image))
}

/// An image, with what it shows.
pub struct Picture(pub &'static str);

impl Field for Picture {
    type Value = (PathBuf, Arc<Image>);

    fn parameters(&self) -> Vec<Parameter> {
        vec![Parameter { is_required: true, doc: self.0, ..Parameter::new("filename", Takes::File) }]
    }

    fn read(&self, query: &Query<'_>) -> Option<Self::Value> {
        image(query, "filename")
    }

    fn write(&self, node: Node, (file, image): &Self::Value, _: &mut Writer) -> Node {
        let Image { width, height, channels, values, .. } = &**image;
        let kind = if *channels == 1 { "grey" } else { "in colour" };
        let content = hash_of_values(&[*width, *height, *channels], values);
        let summary = format!("{width} × {height} texels, {kind}");
        node.with("filename", write::Value::File { path: file.clone(), content, summary })
    }
}

/// A transform that is not written where it is the identity.
pub struct Placed(pub &'static str, pub &'static str);

impl Field for Placed {
    type Value = Transform;

    fn parameters(&self) -> Vec<Parameter> {
        vec![Parameter { doc: self.1, ..Parameter::new(self.0, Takes::Transform) }]
    }

    fn read(&self, query: &Query<'_>) -> Option<Transform> {
        Some(query.transform(self.0))
    }

    fn write(&self, node: Node, transform: &Transform, _: &mut Writer) -> Node {
        node.transform(self.0, transform)
    }
}
