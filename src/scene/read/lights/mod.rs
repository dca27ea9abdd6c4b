//! Emitters.

mod sunsky;

use super::Reader;
use super::patterns;
use super::query::Query;
use super::sensors;
use super::spectra::{self, Use};
use super::textures;
use super::tree::{Class, Entry, ObjectId, Value};
use crate::geometry::{Transform, Vec3};
use crate::scene::description::{Animation, Light, LightKind, SpectrumKind, SpectrumSource};
use crate::scene::source::SceneError;
use std::sync::Arc;

/// By how much the length of a transformed axis may differ from 1: transforms are often written with few
/// digits.
const LOOSEST_LENGTH: f64 = 1e-3;

/// An emitter that stands by itself. `None` where it is wrong, which is reported.
pub(super) fn read(reader: &Reader, id: ObjectId) -> Option<Light> {
    let query = Query::new(reader, id);
    let object = query.object;
    let mut motion = None;
    let kind = match object.plugin.as_str() {
        "point" => Some(point(&query, &mut motion)),
        "spot" => Some(spot(&query, &mut motion)),
        "projector" => Some(projector(&query, &mut motion)),
        "directional" => directional(&query, &mut motion),
        "constant" => {
            if query.has("to_world") {
                query.transform("to_world");
                reader.remark(
                    &query.place("to_world"),
                    "to_world changes nothing: a constant light looks the same from everywhere".to_owned(),
                );
            }
            Some(LightKind::Constant { radiance: spectra::emission(&query, "radiance") })
        }
        "envmap" => environment_map(&query),
        "sunsky" => sunsky::read(&query),
        name @ ("area" | "directionalarea") => {
            let problem = match name {
                "area" => "An area light needs a shape",
                _ => "A directional area light needs a shape",
            };
            query.error(
                SceneError::at(
                    &object.place,
                    problem,
                    "expected inside a <shape>, or an id that a shape refers to",
                )
                .with_remedy("put it into the shape whose surface shines"),
            );
            return None;
        }
        _ => {
            reader.unknown_plugin(object);
            return None;
        }
    };
    let weight = sampling_weight(&query);
    for (entry, _) in query.objects(Class::Medium) {
        let text = "the medium of a light changes nothing: rays know what they are in".to_owned();
        reader.remark(&entry.place, text);
    }
    let weight_place = query.place("sampling_weight");
    query.finish();
    let kind = kind?;
    if weight == Some(0.0) && !kind.is_environment() {
        reader.remark(
            &weight_place,
            "the light is dark: with a sampling_weight of 0 nothing in Mitsuba 3 finds a light without extent".to_owned(),
        );
        return None;
    }
    Some(Light { place: object.place.clone(), kind, motion })
}

/// Whether a light that stands in the scene is the surface of shapes that refer to it: then these read it.
pub(super) fn belongs_to_shapes(reader: &Reader, entry: &Entry, id: ObjectId) -> bool {
    if !["area", "directionalarea"].contains(&reader.tree.get(id).plugin.as_str()) {
        return false;
    }
    let shapes = reader.tree.objects.iter().filter(|object| object.class == Class::Shape);
    let refers = |entry: &&Entry| matches!(entry.value, Value::Object(target) if target == id);
    let uses = shapes.flat_map(|shape| &shape.entries).filter(refers).count();
    if uses > 1 {
        let text = "an area light of several shapes: each of them shines like this".to_owned();
        reader.extension(&entry.place, text);
    }
    uses > 0
}

/// The radiance of an emitter that stands in a shape.
pub(super) fn area(reader: &Reader, id: ObjectId) -> Option<SpectrumSource> {
    let query = Query::new(reader, id);
    let object = query.object;
    match object.plugin.as_str() {
        name @ ("area" | "directionalarea") => {
            let radiance = spectra::radiance(&query, "radiance");
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
            if name == "directionalarea" {
                reader.remark(
                    &object.place,
                    "the surface stays dark: as in Mitsuba 3, no path from the camera finds light that leaves along the normal alone"
                        .to_owned(),
                );
                return None;
            }
            Some(radiance)
        }
        "point" | "spot" | "projector" | "directional" | "constant" | "envmap" | "sunsky" => {
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

/// Mitsuba 3 chooses lights in proportion to it. The picture does not depend on it; only at 0 a light that
/// nothing but light samples finds is not found.
fn sampling_weight(query: &Query<'_>) -> Option<f64> {
    let weight = query.float("sampling_weight")?;
    if weight < 0.0 {
        let problem = format!("\"sampling_weight\" of {} is {weight}", query.title());
        let place = query.place("sampling_weight");
        query.error(SceneError::at(&place, problem, "expected a number of at least 0"));
        return None;
    }
    if weight > 0.0 {
        query.reader.remark(
            &query.place("sampling_weight"),
            "sampling_weight changes nothing: lights are chosen by what they can contribute".to_owned(),
        );
    }
    Some(weight)
}

/// `to_world` of light from beyond the scene, which has no place and no size.
fn rotation(query: &Query<'_>) -> Transform {
    let to_world = query.transform("to_world");
    if !to_world.is_rigid(LOOSEST_LENGTH) {
        query.error(
            SceneError::at(
                &query.place("to_world"),
                "The transform of light from all around scales",
                "expected a transform that only rotates",
            )
            .with_remedy("leave out <scale>: it would not make the surroundings larger, only distort them"),
        );
        return Transform::IDENTITY;
    }
    to_world
}

fn environment_map(query: &Query<'_>) -> Option<LightKind> {
    let to_world = rotation(query);
    let scale = factor(query);
    if query.has("mis_compensation") {
        query.boolean("mis_compensation", false);
        let text = "mis_compensation changes nothing: it is a matter of noise";
        query.reader.remark(&query.place("mis_compensation"), text.to_owned());
    }
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
    if image.values.iter().any(|&value| value < 0.0) {
        let text = "negative values of the picture count as 0, as in Mitsuba 3";
        query.reader.assumption(&query.place("filename"), text.to_owned());
    }
    Some(LightKind::EnvironmentMap { to_world, file, image, scale })
}

/// What moves a light, if anything does.
type Motion = Option<Arc<Animation>>;

/// `to_world` of a light that shines in some directions more than in others.
fn rigid(query: &Query<'_>) -> (Transform, Motion) {
    let (to_world, motion) = query.placement();
    if let Some(motion) = &motion
        && motion.keys.iter().any(|(_, to_world)| !to_world.is_rigid(LOOSEST_LENGTH))
    {
        let problem = "The light is scaled while it moves";
        let error = SceneError::at(&motion.place, problem, "expected keyframes that only rotate and move");
        query.error(error.with_remedy("leave out <scale>: it would change what the light's angles mean"));
    }
    (to_world, motion)
}

fn point(query: &Query<'_>, motion: &mut Motion) -> LightKind {
    let to_world;
    (to_world, *motion) = query.placement();
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

fn spot(query: &Query<'_>, motion: &mut Motion) -> LightKind {
    let to_world;
    (to_world, *motion) = rigid(query);
    let intensity = spectra::emission(query, "intensity");
    let cutoff_angle = query.float("cutoff_angle").unwrap_or(20.0);
    if !(cutoff_angle > 0.0 && cutoff_angle <= 180.0) {
        query.error(
            SceneError::at(
                &query.place("cutoff_angle"),
                format!("The spot ends at {cutoff_angle} degrees from its axis"),
                "expected an angle above 0 and up to 180 degrees",
            )
            .with_remedy("the angle is that between the axis and the edge of the cone"),
        );
    }
    let beam_width = query.float("beam_width").unwrap_or(0.75 * cutoff_angle);
    if !(0.0..=180.0).contains(&beam_width) {
        query.error(SceneError::at(
            &query.place("beam_width"),
            format!("The spot begins to fall off at {beam_width} degrees from its axis"),
            "expected an angle from 0 to 180 degrees",
        ));
    }
    let texture = spectra::read(query, "texture", Use::Emission);
    let slide = |source: &SpectrumSource| {
        let nowhere =
            matches!(source.kind, SpectrumKind::MeshAttribute { .. }) || patterns::is_in_space(source);
        textures::varies(source) && !nowhere
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
    LightKind::Spot { to_world, intensity, cutoff_angle, beam_width, texture }
}

fn projector(query: &Query<'_>, motion: &mut Motion) -> LightKind {
    let to_world;
    (to_world, *motion) = rigid(query);
    let irradiance = spectra::radiance(query, "irradiance");
    if matches!(irradiance.kind, SpectrumKind::MeshAttribute { .. } | SpectrumKind::Volume(_))
        || patterns::is_in_space(&irradiance)
    {
        query.error(SceneError::at(
            &irradiance.place,
            "A projector has no surface and no place to look its picture up at",
            "expected a bitmap, a checkerboard, or what is the same everywhere",
        ));
    }
    LightKind::Projector {
        to_world,
        irradiance,
        scale: factor(query),
        field_of_view: sensors::field_of_view(query),
    }
}

/// `scale`, a factor on what is emitted.
fn factor(query: &Query<'_>) -> f64 {
    let scale = query.float("scale").unwrap_or(1.0);
    if scale < 0.0 {
        query.error(
            SceneError::at(
                &query.place("scale"),
                format!("The light is scaled by {scale}"),
                "expected a factor of at least 0",
            )
            .with_remedy("light cannot be taken away"),
        );
    }
    scale
}

fn directional(query: &Query<'_>, motion: &mut Motion) -> Option<LightKind> {
    let to_world;
    (to_world, *motion) = rigid(query);
    let direction = query.vector("direction");
    let irradiance = spectra::emission(query, "irradiance");
    if direction.is_some() && query.has("to_world") {
        query.error(SceneError::at(
            &query.place("direction"),
            "The direction is given twice",
            "expected either direction or to_world",
        ));
    }
    let along = to_world.vector(Vec3::Z);
    if direction.is_none() && (along.length() - 1.0).abs() > LOOSEST_LENGTH {
        query.error(
            SceneError::at(
                &query.place("to_world"),
                "The directional light's transform scales",
                "expected a transform that keeps the length of the z axis",
            )
            .with_remedy(
                "Mitsuba 3 would take the length for a part of the angle at which surfaces are lit; scale the irradiance instead",
            ),
        );
    }
    let travels = direction.unwrap_or(along);
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
