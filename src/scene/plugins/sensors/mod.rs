//! Sensors: what they see, and with which film, sampler and shutter.

mod batch;
mod cameras;
mod lens;
mod meters;
mod shutter;

use super::fields::Fixed;
use super::view::View;
use super::{Field, Parameter, Takes, Use, declare, films, float, media, samplers};
use crate::camera::{Shutter, Stop};
use crate::scene::description::{
    AngularMap, Animation, FilmContent, Medium, Sensor, SensorKind, ShapeDescription, SpectrumSource,
};
use crate::scene::read::{Class, ObjectId, Query, Reader, Value, spectra, textures};
use crate::scene::source::{Place, SceneError};
use crate::scene::write::{Node, Writer};
use batch::Sensors;
use cameras::{ANGLE_ACROSS, ANGLE_UP, Circle, Clips, NO_FOCUS, Placed, Rigid};
use lens::LensAndClips;
use meters::{ItsShape, Line, Target, Toward};
use shutter::Exposure;
use std::sync::Arc;

/// What a sensor is, and what moves it.
pub enum Content {
    Of(SensorKind, Motion),
}

/// What moves a camera, if anything does.
type Motion = Option<Arc<Animation>>;

declare! {
    Class::Sensor => Content, common common;

    "perspective", "a pinhole camera" => Content::Of(
        SensorKind::Perspective { to_world, field_of_view, principal_point: [x, y], near_clip, far_clip, lens: None },
        motion
    ) {
        (to_world, motion): Rigid,
        field_of_view: View,
        x: float("principal_point_offset_x", 0.0, "offset of the principal point").unit("film widths"),
        y: float("principal_point_offset_y", 0.0, "the same down").unit("film heights"),
        (near_clip, far_clip): Clips,
    } ignoring [NO_FOCUS];
    "thinlens", "a camera with a thin lens, which is in focus at one distance" => Content::Of(
        SensorKind::Perspective { to_world, field_of_view, principal_point, near_clip, far_clip, lens: Some(lens) },
        motion
    ) {
        (to_world, motion): Rigid,
        field_of_view: View,
        principal_point: Fixed([0.0; 2]),
        (lens, near_clip, far_clip): LensAndClips,
    };
    "orthographic", "parallel rays along +z, from -1 to 1 in x"
        => Content::Of(SensorKind::Orthographic { to_world, near_clip, far_clip }, motion) {
        (to_world, motion): Placed,
        (near_clip, far_clip): Clips,
    } ignoring [NO_FOCUS];
    "fisheye" extension "a camera that sees a cone of any width on a circle" => Content::Of(
        SensorKind::Angular { to_world, map: AngularMap::Fisheye { projection, fov }, near_clip, far_clip },
        motion
    ) {
        (projection, fov): Circle,
        (to_world, motion): Rigid,
        (near_clip, far_clip): Clips,
    };
    "panorama" extension "a camera that sees all around, longitude across and latitude up" => Content::Of(
        SensorKind::Angular { to_world, map: AngularMap::Panorama { fov: [across, up] }, near_clip, far_clip },
        motion
    ) {
        across: ANGLE_ACROSS,
        up: ANGLE_UP,
        (to_world, motion): Rigid,
        (near_clip, far_clip): Clips,
    };
    "sensorplane" extension "a film in the scene, which measures the irradiance through a stop"
        => Content::Of(SensorKind::Plane { to_world, width, stop: Stop { radius, distance } }, motion) {
        (to_world, motion): Rigid,
        width: float("width", 1.0, "width of the film").positive(),
        radius: float("aperture_radius", 1.0, "radius of the stop").positive(),
        distance: float("aperture_distance", 1.0, "how far before the film the stop is").positive(),
    };
    "radiancemeter", "radiance along a ray"
        => Content::Of(SensorKind::RadianceMeter { origin, direction }, motion) {
        (origin, direction): Line,
        motion: STILL,
    };
    "irradiancemeter", "irradiance on the shape that it stands in"
        => Content::Of(SensorKind::IrradianceMeter { surface }, motion) {
        surface: ItsShape,
        motion: STILL,
    };
    "distant", "radiance that leaves toward a distant sensor"
        => Content::Of(SensorKind::Distant { direction, target }, motion) {
        direction: Toward,
        target: Target,
        motion: STILL,
    };
    "batch", "sensors side by side on one film" => Content::Of(SensorKind::Batch(sensors), motion) {
        sensors: Sensors,
        motion: STILL,
    };
}

/// What cannot move, or holds what can.
const STILL: Fixed<Motion> = Fixed(None);

fn common() -> Vec<Parameter> {
    let response = Parameter::new("srf", Takes::Spectrum(Use::Response));
    let held = |element, doc| Parameter { doc, ..Parameter::new("", Takes::Object(element)) };
    [
        vec![
            Parameter { doc: "factor on what is measured, by wavelength", ..response },
            held("medium", "what the sensor is in"),
        ],
        Exposure.parameters(),
        vec![
            held("film", "what its picture is; otherwise `hdrfilm`"),
            held("sampler", "how many samples it takes; otherwise `independent`"),
        ],
    ]
    .concat()
}

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
pub fn of_scene(scene: &Query<'_>) -> Vec<(Place, Option<Sensor>)> {
    let (mut found, mut on_meshes) = (Vec::new(), Vec::new());
    for child in children(scene) {
        let on_mesh = |shape| MESHES.contains(&scene.reader.tree.get(shape).plugin.as_str());
        if child.shape.is_some_and(on_mesh) { &mut on_meshes } else { &mut found }.push(child);
    }
    found.extend(on_meshes.into_iter().rev());
    let read_one = |child: Found| {
        let place = scene.reader.tree.get(child.sensor).place.clone();
        (place, one(scene.reader, child, false))
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

fn one(reader: &Reader, found: Found, in_batch: bool) -> Option<Sensor> {
    let query = Query::new(reader, found.sensor).within(found.shape);
    let object = query.object;
    if in_batch && object.plugin == "batch" {
        query.error(
            SceneError::at(&object.place, "A batch stands in a batch", "expected sensors of other kinds")
                .with_remedy("list all sensors in the outer one"),
        );
        return None;
    }
    let content = read(&query);
    if !NAMES.contains(&object.plugin.as_str()) {
        return None;
    }
    let response = response(&query);
    let medium = medium(&query);
    let film = films::of_sensor(&query);
    let sampler = samplers::of_sensor(&query);
    let shutter = Exposure.read(&query).unwrap_or(Shutter::INSTANT);
    query.finish();
    let Content::Of(kind, motion) = content?;
    let place = object.place.clone();
    let sensor = Sensor { place, kind, response, medium, film, sampler, motion, shutter };
    check_film(reader, &sensor);
    check_response(reader, &sensor);
    Some(sensor)
}

/// The sensor as such. One that measures on a surface is to be put into the shape that [`surface`] gives.
pub fn node(sensor: &Sensor, writer: &mut Writer) -> Node {
    let content = Content::Of(sensor.kind.clone(), sensor.motion.clone());
    let node = write(&content, &sensor.place, writer);
    let node = match &sensor.response {
        Some(response) => node.spectrum("srf", response),
        None => node,
    };
    let node = match &sensor.medium {
        Some(medium) => node.child(media::node(medium, writer)),
        None => node,
    };
    Exposure
        .write(node, &sensor.shutter, writer)
        .child(films::node(&sensor.film, writer))
        .child(samplers::node(&sensor.sampler, writer))
}

/// What a sensor measures on.
pub fn surface(sensor: &Sensor) -> Option<&ShapeDescription> {
    match &sensor.kind {
        SensorKind::IrradianceMeter { surface } => Some(surface),
        _ => None,
    }
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
        SensorKind::Batch(sensors) => batch::check_film(reader, film, sensors),
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

/// What the sensor is in. Mitsuba 3 takes it under any name.
fn medium(query: &Query<'_>) -> Option<Medium> {
    let (_, id) = query.object(Class::Medium)?;
    media::of_object(query.reader, id)
}
