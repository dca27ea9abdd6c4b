//! Pictures that surround a scene, and those that lights throw.

use super::super::textures::{self, is_in_space};
use super::super::{Field, Parameter, Takes};
use super::Emitter;
use crate::raster::Image;
use crate::scene::description::{LightKind, SpectrumKind, SpectrumSource};
use crate::scene::read::{Query, textures::varies};
use crate::scene::source::SceneError;
use crate::scene::write::{Node, Writer};
use std::path::PathBuf;
use std::sync::Arc;

/// Most that a value of an environment map may be: sums over texels stay within single precision.
const BRIGHTEST: f32 = 1e36;

/// The picture of an environment map.
pub struct Picture;

impl Field for Picture {
    type Value = (PathBuf, Arc<Image>);

    fn parameters(&self) -> Vec<Parameter> {
        let doc = "image of directions, longitude across and latitude up";
        vec![Parameter { is_required: true, doc, ..Parameter::new("filename", Takes::File) }]
    }

    fn read(&self, query: &Query<'_>) -> Option<Self::Value> {
        let (file, image) = textures::image(query, "filename")?;
        let [width, height] = [image.width, image.height];
        if (width < 2 || height < 3) && (width, height) != (1, 1) {
            query.error(
                SceneError::at(
                    &query.place("filename"),
                    format!("A picture of {width} × {height} pixels cannot surround a scene"),
                    "expected at least 2 columns and 3 rows, or a single pixel",
                )
                .with_remedy("the first and the last row are the poles"),
            );
            return None;
        }
        if let Some(at) = image.values.iter().position(|&value| value > BRIGHTEST) {
            let (texel, value) = (at / image.channels, image.values[at]);
            query.error(
                SceneError::at(
                    &query.place("filename"),
                    format!(
                        "The texel at {}, {} of the picture is {value:e} ({})",
                        texel % width,
                        texel / width,
                        file.display()
                    ),
                    format!("expected values of at most {BRIGHTEST:e}"),
                )
                .with_remedy("sums of such values overflow; such a texel is as a rule a fault of the file"),
            );
            return None;
        }
        if image.values.iter().any(|&value| value < 0.0) {
            let text = "negative values of the picture count as 0, as in Mitsuba 3";
            query.reader.assumption(&query.place("filename"), text.to_owned());
        }
        Some((file, image))
    }

    fn write(&self, node: Node, (file, image): &Self::Value, writer: &mut Writer) -> Node {
        textures::Picture("").write(node, &(file.clone(), image.clone()), writer)
    }
}

/// Refuses a slide that is the same everywhere, or that needs a surface.
pub fn slide_varies(query: &Query<'_>, emitter: Emitter) -> Option<Emitter> {
    let Emitter::Alone(LightKind::Spot { texture, .. }) = &emitter else { return Some(emitter) };
    let slide = |source: &SpectrumSource| {
        let nowhere = matches!(source.kind, SpectrumKind::MeshAttribute { .. }) || is_in_space(source);
        varies(source) && !nowhere
    };
    if let Some(texture) = texture.as_ref().filter(|texture| !slide(texture)) {
        query.error(
            SceneError::at(
                &texture.place,
                "The texture of a spot must vary",
                "expected a texture such as a bitmap",
            )
            .with_remedy("what is the same everywhere is the intensity"),
        );
    }
    Some(emitter)
}

/// Refuses a picture that needs a surface.
pub fn looked_up_in_uv(query: &Query<'_>, emitter: Emitter) -> Option<Emitter> {
    let Emitter::Alone(LightKind::Projector { irradiance, .. }) = &emitter else { return Some(emitter) };
    if matches!(irradiance.kind, SpectrumKind::MeshAttribute { .. } | SpectrumKind::Volume(_))
        || is_in_space(irradiance)
    {
        query.error(SceneError::at(
            &irradiance.place,
            "A projector has no surface and no place to look its picture up at",
            "expected a bitmap, a checkerboard, or what is the same everywhere",
        ));
    }
    Some(emitter)
}
