//! The reader against what Mitsuba 3.9.1 was seen to do, and against files that mean harm.

mod declarations;
mod defaults;
mod files;
mod grammar;
mod groups;
mod harm;
mod indices;
mod integrators;
mod media;
mod metals;
mod names;
mod sensors;
mod solids;
mod textures;

use crate::common::described;
use abbe::scene::description::{Description, ShapeDescription};
use abbe::scene::{ReadOptions, read_str};
use std::path::Path;

fn read(text: &str) -> Result<Description, String> {
    read_str(text, Path::new("scene.xml"), &ReadOptions::default()).map_err(|errors| errors.to_string())
}

/// A scene with a sensor and `content`.
fn scene(content: &str) -> Description {
    described(&format!(r#"<sensor type="perspective"/>{content}"#))
}

fn shape(content: &str) -> ShapeDescription {
    scene(content).shapes.remove(0)
}

/// What is wrong with a scene that has a sensor and `content`.
fn errors(content: &str) -> String {
    read(&format!("<scene version=\"3.0.0\"><sensor type=\"perspective\"/>{content}</scene>")).unwrap_err()
}
