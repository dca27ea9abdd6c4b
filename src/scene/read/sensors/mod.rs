//! Sensors: what there are, and with which film, sampler and shutter.

mod cameras;
mod meters;

use super::query::Query;
use super::spectra::{self, Use};
use super::tree::{Class, ObjectId, Value};
use super::{Reader, films, textures};
use crate::camera::{Shutter, ShutterKind};
use crate::scene::description::{Animation, Film, FilmContent, Medium, Sensor, SensorKind, SpectrumSource};
use crate::scene::plugins::{media, samplers};
use crate::scene::source::{Place, SceneError};
use std::sync::Arc;

/// A sensor where it stands: in the scene, in a batch, or in the shape on which it measures.
#[derive(Clone, Copy)]
struct Found {
    sensor: ObjectId,
    shape: Option<ObjectId>,
}

/// Shapes that are meshes: their sensors come after those of others.
const MESHES: [&str; 5] = ["rectangle", "cube", "obj", "ply", "serialized"];

/// The scene's sensors in Mitsuba 3's order, which numbers them; `None` for those that are wrong, which is
/// reported.
pub(super) fn of_scene(query: &Query<'_>) -> Vec<(Place, Option<Sensor>)> {
    let (mut found, mut on_meshes) = (Vec::new(), Vec::new());
    for child in children(query) {
        let on_mesh = |shape| MESHES.contains(&query.reader.tree.get(shape).plugin.as_str());
        if child.shape.is_some_and(on_mesh) { &mut on_meshes } else { &mut found }.push(child);
    }
    found.extend(on_meshes.into_iter().rev());
    let read_one = |child: Found| {
        let place = query.reader.tree.get(child.sensor).place.clone();
        (place, read(query.reader, child, false))
    };
    found.into_iter().map(read_one).collect()
}

/// The sensors that stand in an object or in a shape within it, in the order of the file.
fn children(query: &Query<'_>) -> Vec<Found> {
    let tree = &query.reader.tree;
    let mut found = Vec::new();
    for entry in &query.object.entries {
        let Value::Object(id) = entry.value else { continue };
        match tree.get(id).class {
            Class::Sensor => found.push(Found { sensor: id, shape: None }),
            Class::Shape => {
                let within = tree.get(id).entries.iter().find_map(|entry| match entry.value {
                    Value::Object(sensor) if tree.get(sensor).class == Class::Sensor => Some(sensor),
                    _ => None,
                });
                found.extend(within.map(|sensor| Found { sensor, shape: Some(id) }));
            }
            _ => {}
        }
    }
    found
}

fn read(reader: &Reader, found: Found, in_batch: bool) -> Option<Sensor> {
    let query = Query::new(reader, found.sensor);
    let object = query.object;
    let mut motion = None;
    let kind = match object.plugin.as_str() {
        "perspective" => cameras::perspective(&query, false, &mut motion),
        "thinlens" => cameras::perspective(&query, true, &mut motion),
        "orthographic" => Some(cameras::orthographic(&query, &mut motion)),
        "fisheye" => Some(cameras::fisheye(&query, &mut motion)),
        "panorama" => Some(cameras::panorama(&query, &mut motion)),
        "sensorplane" => Some(cameras::plane(&query, &mut motion)),
        "radiancemeter" => meters::radiance_meter(&query),
        "irradiancemeter" => meters::irradiance_meter(&query, found.shape),
        "distant" => Some(meters::distant(&query)),
        "batch" if !in_batch => batch(&query),
        "batch" => {
            query.error(
                SceneError::at(&object.place, "A batch stands in a batch", "expected sensors of other kinds")
                    .with_remedy("list all sensors in the outer one"),
            );
            return None;
        }
        _ => {
            reader.unknown_plugin(object);
            return None;
        }
    };
    let response = response(&query);
    let medium = medium(&query);
    let film = film(&query);
    let sampler = samplers::of_sensor(&query);
    let shutter = shutter(&query);
    query.finish();
    let kind = kind?;
    let sensor =
        Sensor { place: object.place.clone(), kind, response, medium, film, sampler, motion, shutter };
    check_film(reader, &sensor);
    check_response(reader, &sensor);
    Some(sensor)
}

/// What moves a camera, if anything does.
type Motion = Option<Arc<Animation>>;

fn batch(query: &Query<'_>) -> Option<SensorKind> {
    let found = children(query);
    query.objects(Class::Sensor);
    for (entry, shape) in query.objects(Class::Shape) {
        if !found.iter().any(|child| child.shape == Some(shape)) {
            query.error(
                SceneError::at(&entry.place, "A shape in a batch holds no sensor", "expected a sensor in it")
                    .with_remedy("a shape that is to be seen belongs directly into the <scene>"),
            );
        }
    }
    if query.has("to_world") {
        query.transform("to_world");
        let text = "to_world of a batch changes nothing: each of its sensors has its own".to_owned();
        query.reader.remark(&query.place("to_world"), text);
    }
    if found.is_empty() {
        query.error(
            SceneError::at(
                &query.object.place,
                "The batch has no sensors",
                "expected at least one <sensor> in it",
            )
            .with_remedy("each of them is shown in a column of the film"),
        );
        return None;
    }
    let read: Vec<_> = found.into_iter().map(|child| read(query.reader, child, true)).collect();
    read.into_iter().collect::<Option<_>>().map(SensorKind::Batch)
}

/// What only some films can show.
fn check_film(reader: &Reader, sensor: &Sensor) {
    let film = &sensor.film;
    match &sensor.kind {
        SensorKind::RadianceMeter { .. } | SensorKind::Distant { .. }
            if film.width != 1 && film.height != 1 =>
        {
            reader.error(
                SceneError::at(
                    &film.place,
                    format!("The film of this sensor has {} × {} pixels", film.width, film.height),
                    "expected a single pixel, as in Mitsuba 3",
                )
                .with_remedy("give it a film with width and height 1 and the filter box"),
            );
        }
        SensorKind::Batch(sensors) => {
            if let FilmContent::Responses(_) = film.content {
                reader.error(
                    SceneError::at(
                        &film.place,
                        "A batch cannot have a specfilm",
                        "expected an hdrfilm: in a batch Mitsuba 3 weighs responses wrongly",
                    )
                    .with_remedy(
                        "give each sensor its own specfilm outside of a batch; -s chooses one of them",
                    ),
                );
            }
            if !(film.width as usize).is_multiple_of(sensors.len()) {
                let problem = format!(
                    "A film {} pixels wide cannot be shared by {} sensors",
                    film.width,
                    sensors.len()
                );
                reader.error(SceneError::at(
                    &film.place,
                    problem,
                    "expected a width that the number of sensors divides",
                ));
            }
            for medium in sensors.iter().filter_map(|sensor| sensor.medium.as_ref()) {
                let text = "this medium changes nothing: that of the batch counts".to_owned();
                reader.remark(&medium.place, text);
            }
        }
        _ => {}
    }
}

/// Mitsuba 3 takes a response from the sensor or from its film.
fn check_response(reader: &Reader, sensor: &Sensor) {
    if let (Some(response), FilmContent::Responses(_)) = (&sensor.response, &sensor.film.content) {
        reader.error(
            SceneError::at(
                &response.place,
                "Both the sensor and its film have spectral responses",
                "expected none in the sensor where the film is a specfilm",
            )
            .with_remedy("multiply the film's responses by this one"),
        );
    }
}

/// `srf`. A batch leaves wavelengths to its sensors.
fn response(query: &Query<'_>) -> Option<SpectrumSource> {
    let response = spectra::read(query, "srf", Use::Response)?;
    if textures::varies(&response) {
        let expected = "expected a spectrum, a colour or a number";
        query.error(SceneError::at(&response.place, "The response of a sensor cannot vary", expected));
        return None;
    }
    if query.object.plugin == "batch" {
        let text = "srf of a batch changes nothing: each of its sensors has its own".to_owned();
        query.reader.remark(&query.place("srf"), text);
        return None;
    }
    Some(response)
}

fn shutter(query: &Query<'_>) -> Shutter {
    let open = query.float("shutter_open").unwrap_or(0.0);
    let close = query.float("shutter_close").unwrap_or(0.0);
    if open > close {
        let problem = format!("The shutter closes ({close}) before it opens ({open})");
        let place = query.place(if query.has("shutter_open") { "shutter_open" } else { "shutter_close" });
        query.error(SceneError::at(&place, problem, "expected shutter_open not after shutter_close"));
    }
    const KINDS: [(&str, ShutterKind); 3] = [
        ("box", ShutterKind::Box),
        ("triangle", ShutterKind::Triangle),
        ("strobe", ShutterKind::Strobe { flashes: 2 }),
    ];
    let mut kind = ShutterKind::Box;
    if query.has("shutter") {
        kind = query.choice("shutter", &KINDS, false).unwrap_or(kind);
        query.reader.extension(&query.place("shutter"), "shutter: light let in over time".to_owned());
    }
    if let ShutterKind::Strobe { flashes } = &mut kind
        && let Some(count) = query.integer("strobe_flashes", 1, 65_536)
    {
        *flashes = count as u32;
    }
    if !query.reader.anything_moves() {
        for name in ["shutter_open", "shutter_close", "shutter"].into_iter().filter(|name| query.has(name)) {
            query.reader.remark(&query.place(name), format!("{name} changes nothing: nothing moves"));
        }
    } else if open == close {
        let text = "the shutter opens and closes at the same time: what moves is seen where it is then";
        query.reader.remark(&query.object.place, text.to_owned());
    }
    Shutter { open, close, kind }
}

/// What the sensor is in. Mitsuba 3 takes it under any name.
fn medium(query: &Query<'_>) -> Option<Medium> {
    let (_, id) = query.object(Class::Medium)?;
    media::of_object(query.reader, id)
}

fn film(query: &Query<'_>) -> Film {
    match query.object(Class::Film) {
        Some((_, id)) => films::read(query.reader, id),
        None => films::default(&query.object.place),
    }
}
