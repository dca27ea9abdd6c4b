//! Meshes and images of a scene, decoded side by side before the scene is read, which is done in order.

use super::super::plugins::shapes::meshes as shapes;
use super::super::plugins::textures::images;
use super::super::source::Place;
use super::meshes::{MeshFile, MeshKey};
use super::tree::ObjectId;
use super::{Query, Reader, meshes, textures};
use crate::raster::Image;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// What was decoded and not asked for yet. A file that is wrong is not among it: whoever asks for it reads it
/// again and says what is wrong.
#[derive(Debug, Default)]
pub(in crate::scene) struct Ahead {
    pub(super) meshes: BTreeMap<MeshKey, MeshFile>,
    pub images: BTreeMap<PathBuf, Image>,
}

/// Decodes what the objects of a scene name.
pub(super) fn decode(reader: &Reader) -> Ahead {
    let (mut meshes, mut images) = (BTreeMap::new(), BTreeMap::new());
    for (index, object) in reader.tree.objects.iter().enumerate() {
        let plugin = object.plugin.as_str();
        let query = || Query::new(reader, ObjectId(index));
        let place = || query().place("filename");
        if shapes::FORMATS.contains(&plugin) {
            meshes.extend(reader.quietly(|| shapes::asked(&query())).map(|key| (key, place())));
        } else if images::PLUGINS.contains(&plugin) {
            images.extend(reader.quietly(|| query().file("filename")).map(|path| (path, place())));
        }
    }
    let (meshes, images) = rayon::join(
        || all(meshes, meshes::decode),
        || all(images, |path, place| textures::decoded_image(path, place)),
    );
    Ahead { meshes, images }
}

/// By their keys, what can be decoded.
fn all<K: Ord + Send, T: Send, E>(
    asked: BTreeMap<K, Place>,
    decode: impl Fn(&K, &Place) -> Result<T, E> + Sync,
) -> BTreeMap<K, T> {
    let asked: Vec<_> = asked.into_iter().collect();
    // One by one, for some are a thousand times as large as others.
    let decoded = asked.into_par_iter().with_max_len(1).filter_map(|(key, place)| {
        let made = decode(&key, &place).ok()?;
        Some((key, made))
    });
    decoded.collect()
}

#[cfg(test)]
mod tests {
    use super::super::files::Search;
    use super::super::{ReadOptions, xml};
    use super::*;
    use crate::scene::plugins::Field;
    use crate::scene::source::Sources;
    use std::path::Path;

    fn reader(text: &str) -> Reader {
        let mut sources = Sources::default();
        let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/scenes/ahead.xml"));
        let file = sources.add(path, text.to_owned());
        let search = Search::new(path.parent().unwrap());
        Reader::new(xml::parse(text, file, path, search, &[], &mut sources), &ReadOptions::default())
    }

    #[test]
    fn all_that_is_decoded_is_asked_for() {
        let reader = reader(
            r#"<scene version="3.0.0">
                <sensor type="perspective"/>
                <emitter type="envmap"><string name="filename" value="agreement/sky.pfm"/></emitter>
                <shape type="obj">
                    <string name="filename" value="agreement/ball.obj"/>
                    <boolean name="face_normals" value="true"/>
                    <bsdf type="diffuse">
                        <texture name="reflectance" type="bitmap">
                            <string name="filename" value="textures/colours.png"/>
                        </texture>
                    </bsdf>
                </shape>
                <shape type="obj"><string name="filename" value="agreement/ball.obj"/></shape>
                <shape type="ply">
                    <string name="filename" value="grammar/parts/deeper/tent.ply"/>
                    <boolean name="flip_tex_coords" value="true"/>
                </shape>
                <shape type="serialized"><string name="filename" value="broken/one.serialized"/></shape>
                <shape type="heightfield"><string name="filename" value="textures/heights.png"/></shape>
            </scene>"#,
        );
        let ahead = decode(&reader);
        assert_eq!((ahead.meshes.len(), ahead.images.len()), (4, 3));
        *reader.ahead.borrow_mut() = ahead;
        // As the plugins ask, for the whole reader would be compiled once more for this test.
        for (index, object) in reader.tree.objects.iter().enumerate() {
            let query = Query::new(&reader, ObjectId(index));
            let plugin = object.plugin.as_str();
            if shapes::FORMATS.contains(&plugin) {
                assert!(shapes::MeshFile.read(&query).is_some(), "{plugin}");
            } else if images::PLUGINS.contains(&plugin) {
                assert!(images::image(&query, "filename").is_some(), "{plugin}");
            }
        }
        let left = reader.ahead.borrow();
        assert!(left.meshes.is_empty() && left.images.is_empty(), "{left:?}");
    }
}
