//! Sensors: where the camera stands, what it sees, and with which film and sampler.

use super::super::description::{
    AngularMap, Animation, Aperture, DistantTarget, FieldOfView, Film, FilmContent, FovAxis, Lens, Medium,
    Sensor, SensorKind, Shape,
};
use super::super::source::{Place, SceneError};
use super::query::Query;
use super::spectra::{self, Use, required};
use super::tree::{Class, ObjectId, Value};
use super::{Reader, films, media, samplers, shapes, textures};
use crate::camera::{FisheyeProjection, Shutter, ShutterKind, Stop};
use crate::geometry::{Transform, Vec3};
use std::sync::Arc;

/// How far a camera's axes may be from orthonormal, as matrices written with few digits are.
const LOOSEST_FRAME: f64 = 1e-3;

/// A sensor where it stands: in the scene, in a batch, or in the shape on which it measures.
#[derive(Clone, Copy)]
struct Found {
    sensor: ObjectId,
    shape: Option<ObjectId>,
}

/// Shapes that are no meshes: their sensors come before those of meshes.
const ANALYTIC: [&str; 17] = [
    "sdfgrid",
    "heightfield",
    "sphere",
    "disk",
    "cylinder",
    "cone",
    "paraboloid",
    "hyperboloid",
    "quadric",
    "torus",
    "sweptsphere",
    "polygon",
    "extrusion",
    "revolution",
    "superquadric",
    "blobs",
    "bezierpatch",
];

/// The scene's sensors in Mitsuba 3's order, which numbers them; `None` for those that are wrong, which is reported.
pub(super) fn of_scene(query: &Query<'_>) -> Vec<(Place, Option<Sensor>)> {
    let (mut found, mut on_meshes) = (Vec::new(), Vec::new());
    for child in children(query) {
        let on_mesh = |shape| !ANALYTIC.contains(&query.reader.tree.get(shape).plugin.as_str());
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
        "perspective" => Some(perspective(&query, false, &mut motion)),
        "thinlens" => Some(perspective(&query, true, &mut motion)),
        "orthographic" => Some(orthographic(&query, &mut motion)),
        "fisheye" => Some(fisheye(&query, &mut motion)),
        "panorama" => Some(panorama(&query, &mut motion)),
        "sensorplane" => Some(plane(&query, &mut motion)),
        "radiancemeter" => radiance_meter(&query),
        "irradiancemeter" => irradiance_meter(&query, found.shape),
        "distant" => Some(distant(&query)),
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

fn perspective(query: &Query<'_>, thin_lens: bool, motion: &mut Motion) -> SensorKind {
    let to_world;
    (to_world, *motion) = camera_to_world(query);
    let [near_clip, far_clip] = clips(query);
    let principal_point = if thin_lens {
        [0.0; 2]
    } else {
        ["principal_point_offset_x", "principal_point_offset_y"].map(|name| query.float(name).unwrap_or(0.0))
    };
    let lens = if thin_lens { lens(query, far_clip) } else { None };
    if !thin_lens {
        without_focus(query);
    }
    SensorKind::Perspective {
        to_world,
        field_of_view: field_of_view(query),
        principal_point,
        near_clip,
        far_clip,
        lens,
    }
}

fn orthographic(query: &Query<'_>, motion: &mut Motion) -> SensorKind {
    let to_world;
    (to_world, *motion) = query.placement();
    let [near_clip, far_clip] = clips(query);
    without_focus(query);
    SensorKind::Orthographic { to_world, near_clip, far_clip }
}

fn fisheye(query: &Query<'_>, motion: &mut Motion) -> SensorKind {
    let text = "fisheye: a camera that sees a cone of any width on a circle";
    query.reader.extension(&query.object.place, text.to_owned());
    let projection = query.choice("projection", &FisheyeProjection::NAMES, false);
    let projection = projection.unwrap_or(FisheyeProjection::Equidistant);
    let (limit, included) = projection.limit();
    let most = (2.0 * limit).to_degrees();
    let fov = angle(query, "fov", 180.0, most, included);
    angular(query, AngularMap::Fisheye { projection, fov }, motion)
}

fn panorama(query: &Query<'_>, motion: &mut Motion) -> SensorKind {
    let text = "panorama: a camera that sees all around, longitude across and latitude up";
    query.reader.extension(&query.object.place, text.to_owned());
    let fov = [angle(query, "fov", 360.0, 360.0, true), angle(query, "fov_y", 180.0, 180.0, true)];
    angular(query, AngularMap::Panorama { fov }, motion)
}

fn angular(query: &Query<'_>, map: AngularMap, motion: &mut Motion) -> SensorKind {
    let to_world;
    (to_world, *motion) = camera_to_world(query);
    let [near_clip, far_clip] = clips(query);
    SensorKind::Angular { to_world, map, near_clip, far_clip }
}

fn plane(query: &Query<'_>, motion: &mut Motion) -> SensorKind {
    let text = "sensorplane: a film in the scene, which measures the irradiance through a stop";
    query.reader.extension(&query.object.place, text.to_owned());
    let to_world;
    (to_world, *motion) = camera_to_world(query);
    let stop = Stop {
        radius: query.positive("aperture_radius", 1.0),
        distance: query.positive("aperture_distance", 1.0),
    };
    SensorKind::Plane { to_world, width: query.positive("width", 1.0), stop }
}

/// Degrees above 0 and up to the most that can be shown.
fn angle(query: &Query<'_>, name: &'static str, default: f64, most: f64, included: bool) -> f64 {
    let angle = query.float(name).unwrap_or(default);
    if angle > 0.0 && (angle < most || included && angle == most) {
        return angle;
    }
    let expected = match included {
        true => format!("expected an angle above 0 and up to {most} degrees"),
        false => format!("expected an angle between 0 and {most} degrees"),
    };
    query.error(SceneError::at(
        &query.place(name),
        format!("The field of view is {angle} degrees"),
        expected,
    ));
    default
}

/// Mitsuba 3 reads and ignores where a camera without a lens focuses.
fn without_focus(query: &Query<'_>) {
    if query.float("focus_distance").is_some() {
        let text = "focus_distance changes nothing: there is no lens".to_owned();
        query.reader.remark(&query.place("focus_distance"), text);
    }
}

fn clips(query: &Query<'_>) -> [f64; 2] {
    let near_clip = query.positive("near_clip", 1e-2);
    let far_clip = query.positive("far_clip", 1e4);
    if near_clip >= far_clip {
        let problem = format!("The near plane ({near_clip}) is not before the far plane ({far_clip})");
        let place = query.place(if query.has("near_clip") { "near_clip" } else { "far_clip" });
        query.error(SceneError::at(&place, problem, "expected near_clip below far_clip"));
    }
    [near_clip, far_clip]
}

fn radiance_meter(query: &Query<'_>) -> Option<SensorKind> {
    let (origin, direction) = (query.vector("origin"), query.vector("direction"));
    let (given_origin, given_direction) = (query.has("origin"), query.has("direction"));
    if query.has("to_world") {
        let to_world = query.transform("to_world");
        if given_origin || given_direction {
            let place = query.place(if given_origin { "origin" } else { "direction" });
            query.reader.remark(&place, "to_world goes before origin and direction".to_owned());
        }
        let (origin, direction) = (to_world.point(Vec3::ZERO), to_world.vector(Vec3::Z));
        return Some(SensorKind::RadianceMeter { origin, direction });
    }
    if given_origin != given_direction {
        let (given, missing) = if given_origin { ("origin", "direction") } else { ("direction", "origin") };
        query.error(
            SceneError::at(
                &query.place(given),
                format!("The radiance meter has {given} but no {missing}"),
                "expected both or neither",
            )
            .with_remedy("a transform named to_world can stand for both"),
        );
        return None;
    }
    if !given_origin {
        return Some(SensorKind::RadianceMeter { origin: Vec3::ZERO, direction: Vec3::Z });
    }
    Some(SensorKind::RadianceMeter { origin: origin?, direction: some_way(query, direction?) })
}

/// A direction that has a length.
fn some_way(query: &Query<'_>, direction: Vec3) -> Vec3 {
    if direction.length() > 0.0 && direction.is_finite() {
        return direction;
    }
    query.error(SceneError::at(
        &query.place("direction"),
        "The sensor looks in no direction",
        "expected a vector that is not 0",
    ));
    Vec3::Z
}

fn irradiance_meter(query: &Query<'_>, shape: Option<ObjectId>) -> Option<SensorKind> {
    if query.entry("to_world").is_some() {
        query.error(
            SceneError::at(
                &query.place("to_world"),
                "An irradiance meter has no transform of its own",
                "its place is that of the shape around it",
            )
            .with_remedy("move the transform into the <shape>"),
        );
    }
    let Some(shape) = shape else {
        query.error(
            SceneError::at(
                &query.object.place,
                "The irradiance meter stands in no shape",
                "expected to measure on the surface of a shape",
            )
            .with_remedy("put it into a <shape>"),
        );
        return None;
    };
    surface(query.reader, shape).map(|surface| SensorKind::IrradianceMeter { surface })
}

fn surface(reader: &Reader, shape: ObjectId) -> Option<Arc<Shape>> {
    shapes::read(reader, shape).map(Arc::new)
}

fn distant(query: &Query<'_>) -> SensorKind {
    let direction = query.vector("direction").map(|direction| some_way(query, direction));
    if query.has("direction") && query.has("to_world") {
        query.error(SceneError::at(
            &query.place("to_world"),
            "The direction is given twice",
            "expected either direction or to_world",
        ));
    }
    let to_world = query.transform("to_world");
    SensorKind::Distant {
        direction: direction.unwrap_or_else(|| to_world.vector(Vec3::Z)),
        target: target(query).unwrap_or(DistantTarget::Scene),
    }
}

fn target(query: &Query<'_>) -> Option<DistantTarget> {
    let entry = query.entry("target")?;
    match entry.value {
        Value::Vector(point) => Some(DistantTarget::Point(point)),
        Value::Object(id) if query.reader.tree.get(id).class == Class::Shape => {
            surface(query.reader, id).map(DistantTarget::Surface)
        }
        _ => {
            query.error(query.wrong_type(entry, "target", "<point> or <shape>"));
            None
        }
    }
}

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
fn response(query: &Query<'_>) -> Option<super::super::description::SpectrumSource> {
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

fn camera_to_world(query: &Query<'_>) -> (Transform, Motion) {
    let (to_world, motion) = query.placement();
    let keys = motion.iter().flat_map(|motion| &motion.keys).map(|(_, to_world)| to_world);
    if keys.chain([&to_world]).any(|to_world| !to_world.is_rigid(LOOSEST_FRAME)) {
        query.error(
            SceneError::at(
                &query.place("to_world"),
                "The camera's transform scales",
                "expected a transform that only rotates and moves",
            )
            .with_remedy("leave out <scale>; a rotation axis must have length 1"),
        );
        return (Transform::IDENTITY, None);
    }
    (to_world, motion)
}

pub(super) fn field_of_view(query: &Query<'_>) -> FieldOfView {
    const AXES: [(&str, FovAxis); 5] = [
        ("x", FovAxis::X),
        ("y", FovAxis::Y),
        ("diagonal", FovAxis::Diagonal),
        ("smaller", FovAxis::Smaller),
        ("larger", FovAxis::Larger),
    ];
    let axis = query.choice("fov_axis", &AXES, true);
    let fov = query.float("fov");
    let focal_length = query.text("focal_length");
    match (fov, focal_length) {
        (Some(_), Some(_)) => {
            query.error(SceneError::at(
                &query.place("focal_length"),
                "The field of view is given twice",
                "expected either fov or focal_length",
            ));
            FieldOfView::FocalLength(50.0)
        }
        (Some(angle), None) => {
            if !(angle > 0.0 && angle < 180.0) {
                query.error(SceneError::at(
                    &query.place("fov"),
                    format!("The field of view is {angle} degrees"),
                    "expected an angle between 0 and 180 degrees",
                ));
            }
            FieldOfView::Degrees { angle, axis: axis.unwrap_or(FovAxis::X) }
        }
        (None, focal_length) => {
            if axis.is_some() && !query.has("fov") {
                query.error(
                    SceneError::at(
                        &query.place("fov_axis"),
                        "fov_axis says nothing without fov",
                        "expected a fov beside it",
                    )
                    .with_remedy("a focal length goes by the diagonal of a film of 36 × 24 mm"),
                );
            }
            FieldOfView::FocalLength(focal_length.map_or(50.0, |text| millimetres(query, text)))
        }
    }
}

/// `50`, `50mm` or `50 mm`.
fn millimetres(query: &Query<'_>, text: &str) -> f64 {
    match super::attributes::number(text.trim_end().trim_end_matches("mm")) {
        // Outside, not even the tangent of half the angle is a number that one can go on with.
        Some(length) if (1e-6..=1e12).contains(&length) => length,
        _ => {
            query.error(SceneError::at(
                &query.place("focal_length"),
                format!("\"{text}\" is not a focal length"),
                "expected millimetres above 0, such as 50mm",
            ));
            50.0
        }
    }
}

fn lens(query: &Query<'_>, far_clip: f64) -> Option<Lens> {
    let focus_distance = query.positive("focus_distance", far_clip);
    let (blades, rotation) = blades(query);
    let aperture = aperture(query)?;
    Some(Lens { aperture, blades, rotation, focus_distance })
}

fn aperture(query: &Query<'_>) -> Option<Aperture> {
    if query.has("f_stop") {
        let stop = query.positive("f_stop", 1.0);
        if query.has("aperture_radius") {
            query.float("aperture_radius");
            query.error(
                SceneError::at(
                    &query.place("f_stop"),
                    "The aperture is given twice",
                    "expected either aperture_radius or f_stop",
                )
                .with_remedy(
                    "the radius that an f_stop stands for is the focal length / (2 f_stop), in metres",
                ),
            );
        }
        query.reader.extension(&query.place("f_stop"), format!("f_stop: the aperture is f/{stop}"));
        return Some(Aperture::Stop(stop));
    }
    let radius = required(query, "aperture_radius", query.float("aperture_radius"))?;
    if radius < 0.0 {
        let problem = format!("The aperture has a radius of {radius}");
        query.error(SceneError::at(&query.place("aperture_radius"), problem, "expected at least 0"));
    }
    Some(Aperture::Radius(radius))
}

/// The number of an aperture's blades, 0 where it is round, and by how many degrees they are turned.
fn blades(query: &Query<'_>) -> (u32, f64) {
    const MOST: i64 = 1000;
    let (name, turned) = ("aperture_blades", "aperture_rotation");
    let rotation = query.float(turned);
    let blades = query.integer(name, 0, MOST).unwrap_or(0);
    if (1..3).contains(&blades) {
        query.error(SceneError::at(
            &query.place(name),
            format!("The aperture has {blades} {}", if blades == 1 { "blade" } else { "blades" }),
            format!("expected 0 for a round aperture, or an integer from 3 to {MOST}"),
        ));
    } else if blades > 0 {
        query.reader.extension(&query.place(name), format!("{name}: the aperture is a regular polygon"));
    } else if rotation.is_some() && !query.has(name) {
        query.error(
            SceneError::at(
                &query.place(turned),
                "A round aperture is not turned",
                "expected aperture_blades beside aperture_rotation",
            )
            .with_remedy("say how many blades there are, 3 or more"),
        );
    }
    // Nothing is left of the angle where it changes nothing.
    (blades as u32, rotation.filter(|_| blades > 0).unwrap_or(0.0))
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
    media::read(query.reader, id)
}

fn film(query: &Query<'_>) -> Film {
    match query.object(Class::Film) {
        Some((_, id)) => films::read(query.reader, id),
        None => films::default(&query.object.place),
    }
}
