//! Emitters.

use super::super::description::{Light, LightKind, SpectrumSource};
use super::super::source::SceneError;
use super::Reader;
use super::query::Query;
use super::spectra;
use super::tree::ObjectId;
use crate::geometry::Vec3;

/// An emitter that stands by itself. `None` where it is wrong, which is reported.
pub(super) fn read(reader: &Reader, id: ObjectId) -> Option<Light> {
    let query = Query::new(reader, id);
    let object = query.object;
    let kind = match object.plugin.as_str() {
        "point" => point(&query),
        "directional" => directional(&query)?,
        "constant" => {
            if query.has("to_world") {
                query.transform("to_world");
                reader.remark(
                    &query.place("to_world"),
                    "to_world changes nothing: a constant light looks the same from everywhere".to_owned(),
                );
            }
            LightKind::Constant { radiance: spectra::emission(&query, "radiance") }
        }
        "area" => {
            query.error(
                SceneError::at(&object.place, "An area light needs a shape", "expected inside a <shape>")
                    .with_remedy("put it into the shape whose surface shines"),
            );
            return None;
        }
        _ => {
            reader.unknown_plugin(object);
            return None;
        }
    };
    sampling_weight(&query);
    query.finish();
    Some(Light { place: object.place.clone(), kind })
}

/// The radiance of an emitter that stands in a shape.
pub(super) fn area(reader: &Reader, id: ObjectId) -> Option<SpectrumSource> {
    let query = Query::new(reader, id);
    let object = query.object;
    match object.plugin.as_str() {
        "area" => {
            let radiance = spectra::emission(&query, "radiance");
            sampling_weight(&query);
            if query.has("to_world") {
                query.entry("to_world");
                query.error(
                    SceneError::at(
                        &query.place("to_world"),
                        "An area light has no place of its own",
                        "expected no to_world here",
                    )
                    .with_remedy("the shape's to_world moves the light as well"),
                );
            }
            query.finish();
            Some(radiance)
        }
        "point" | "directional" | "constant" => {
            let problem = format!("emitter \"{}\" cannot stand in a shape", object.plugin);
            reader.error(
                SceneError::at(&object.place, super::query::capital(&problem), "expected emitter \"area\"")
                    .with_remedy("move it out of the shape, directly into the <scene>"),
            );
            None
        }
        _ => {
            reader.unknown_plugin(object);
            None
        }
    }
}

/// Mitsuba 3 chooses lights in proportion to it. The picture does not depend on it, unless it is 0.
fn sampling_weight(query: &Query<'_>) {
    if !query.has("sampling_weight") {
        return;
    }
    query.positive("sampling_weight", 1.0);
    query.reader.remark(
        &query.place("sampling_weight"),
        "sampling_weight changes nothing: lights are chosen by what they can contribute".to_owned(),
    );
}

fn point(query: &Query<'_>) -> LightKind {
    let to_world = query.transform("to_world");
    let position = query.vector("position");
    if position.is_some() && query.has("to_world") {
        query.error(SceneError::at(
            &query.place("position"),
            "The position is given twice",
            "expected either position or to_world",
        ));
    }
    LightKind::Point {
        position: position.unwrap_or_else(|| to_world.point(Vec3::ZERO)),
        intensity: spectra::emission(query, "intensity"),
    }
}

fn directional(query: &Query<'_>) -> Option<LightKind> {
    let to_world = query.transform("to_world");
    let direction = query.vector("direction");
    let irradiance = spectra::emission(query, "irradiance");
    if direction.is_some() && query.has("to_world") {
        query.error(SceneError::at(
            &query.place("direction"),
            "The direction is given twice",
            "expected either direction or to_world",
        ));
    }
    let travels = direction.unwrap_or_else(|| to_world.vector(Vec3::Z));
    if travels.try_normalize().is_none() {
        query.error(SceneError::at(
            &query.place("direction"),
            "The light travels nowhere: its direction has no length",
            "expected a direction such as 0 0 -1",
        ));
        return None;
    }
    Some(LightKind::Directional { travels, irradiance })
}
