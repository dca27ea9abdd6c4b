//! Sensors: where the camera stands, what it sees, and with which film and sampler.

use super::super::description::{FieldOfView, Film, FovAxis, Lens, Medium, Sampler, Sensor};
use super::super::source::{Place, SceneError};
use super::query::Query;
use super::spectra::required;
use super::tree::{Class, ObjectId};
use super::{Reader, films, media};
use crate::geometry::Transform;
use crate::sampling::SamplerKind;
use glam::DMat3;

/// Mitsuba 3's default number of samples per pixel.
const DEFAULT_SAMPLES: u32 = 4;

/// How far a camera's axes may be from orthonormal, as matrices written with few digits are.
const LOOSEST_FRAME: f64 = 1e-3;

/// `None` where the sensor is wrong, which is reported.
pub(super) fn read(reader: &Reader, id: ObjectId) -> Option<Sensor> {
    let query = Query::new(reader, id);
    let object = query.object;
    let thin_lens = match object.plugin.as_str() {
        "perspective" => false,
        "thinlens" => true,
        _ => {
            reader.unknown_plugin(object);
            return None;
        }
    };
    let near_clip = query.positive("near_clip", 1e-2);
    let far_clip = query.positive("far_clip", 1e4);
    if near_clip >= far_clip {
        let problem = format!("The near plane ({near_clip}) is not before the far plane ({far_clip})");
        let place = query.place(if query.has("near_clip") { "near_clip" } else { "far_clip" });
        query.error(SceneError::at(&place, problem, "expected near_clip below far_clip"));
    }
    let principal_point = if thin_lens {
        [0.0; 2]
    } else {
        ["principal_point_offset_x", "principal_point_offset_y"].map(|name| query.float(name).unwrap_or(0.0))
    };
    let sensor = Sensor {
        place: object.place.clone(),
        to_world: to_world(&query),
        field_of_view: field_of_view(&query),
        principal_point,
        near_clip,
        far_clip,
        lens: if thin_lens { lens(&query, far_clip) } else { None },
        medium: medium(&query),
        film: film(&query),
        sampler: sampler(&query),
    };
    shutter(&query);
    query.finish();
    Some(sensor)
}

fn to_world(query: &Query<'_>) -> Transform {
    let to_world = query.transform("to_world");
    let axes = DMat3::from_mat4(to_world.matrix());
    if !(axes.transpose() * axes).abs_diff_eq(DMat3::IDENTITY, LOOSEST_FRAME) {
        query.error(
            SceneError::at(
                &query.place("to_world"),
                "The camera's transform scales",
                "expected a transform that only rotates and moves",
            )
            .with_remedy("leave out <scale>; a rotation axis must have length 1"),
        );
        return Transform::IDENTITY;
    }
    to_world
}

pub(super) fn field_of_view(query: &Query<'_>) -> FieldOfView {
    const AXES: [(&str, FovAxis); 5] = [
        ("x", FovAxis::X),
        ("y", FovAxis::Y),
        ("diagonal", FovAxis::Diagonal),
        ("smaller", FovAxis::Smaller),
        ("larger", FovAxis::Larger),
    ];
    let axis = query.choice("fov_axis", &AXES, false);
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
        Some(length) if length > 0.0 => length,
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
    let aperture_radius = required(query, "aperture_radius", query.float("aperture_radius"))?;
    if aperture_radius < 0.0 {
        let problem = format!("The aperture has a radius of {aperture_radius}");
        query.error(SceneError::at(&query.place("aperture_radius"), problem, "expected at least 0"));
    }
    Some(Lens { aperture_radius, focus_distance })
}

fn shutter(query: &Query<'_>) {
    let open = query.float("shutter_open").unwrap_or(0.0);
    let close = query.float("shutter_close").unwrap_or(0.0);
    if open > close {
        let problem = format!("The shutter closes ({close}) before it opens ({open})");
        let place = query.place(if query.has("shutter_open") { "shutter_open" } else { "shutter_close" });
        query.error(SceneError::at(&place, problem, "expected shutter_open not after shutter_close"));
    }
    for name in ["shutter_open", "shutter_close"] {
        if query.has(name) {
            query.reader.remark(&query.place(name), format!("{name} changes nothing: nothing moves"));
        }
    }
}

/// What the camera is in. Mitsuba 3 takes it under any name.
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

fn sampler(query: &Query<'_>) -> Sampler {
    // Mitsuba 3 takes independent numbers where a file names no sampler; the picture is the same in expectation.
    let default = |place: &Place| Sampler {
        place: place.clone(),
        kind: SamplerKind::Sobol,
        sample_count: DEFAULT_SAMPLES,
        seed: 0,
    };
    let Some((_, id)) = query.object(Class::Sampler) else { return default(&query.object.place) };
    let query = Query::new(query.reader, id);
    let object = query.object;
    let kind = match object.plugin.as_str() {
        "independent" => SamplerKind::Independent,
        "sobol" => {
            query
                .reader
                .extension(&object.plugin_place, "sampler \"sobol\": Owen-scrambled Sobol".to_owned());
            SamplerKind::Sobol
        }
        name @ ("stratified" | "multijitter" | "orthogonal" | "ldsampler") => {
            query
                .reader
                .remark(&object.plugin_place, format!("sampler \"{name}\" stands for \"sobol\" here"));
            if query.has("jitter") {
                query.boolean("jitter", true);
                query.reader.remark(&query.place("jitter"), "jitter changes nothing".to_owned());
            }
            if name == "orthogonal" && query.integer("strength", 1, i64::MAX).is_some() {
                query.reader.remark(&query.place("strength"), "strength changes nothing".to_owned());
            }
            SamplerKind::Sobol
        }
        _ => {
            query.reader.unknown_plugin(object);
            return default(&object.place);
        }
    };
    let sample_count = query.integer("sample_count", 1, i64::from(u32::MAX));
    let seed = query.integer("seed", 0, i64::MAX);
    query.finish();
    Sampler {
        place: object.place.clone(),
        kind,
        sample_count: sample_count.map_or(DEFAULT_SAMPLES, |count| count as u32),
        seed: seed.unwrap_or(0) as u64,
    }
}
