//! Sensors that measure a single value: along a ray, on a surface, or from far away.

use super::super::Reader;
use super::super::query::Query;
use super::super::tree::{Class, ObjectId, Value};
use crate::geometry::Vec3;
use crate::scene::description::{DistantTarget, SensorKind, ShapeDescription};
use crate::scene::plugins::shapes;
use crate::scene::source::SceneError;
use std::sync::Arc;

pub(super) fn radiance_meter(query: &Query<'_>) -> Option<SensorKind> {
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

pub(super) fn irradiance_meter(query: &Query<'_>, shape: Option<ObjectId>) -> Option<SensorKind> {
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

fn surface(reader: &Reader, shape: ObjectId) -> Option<Arc<ShapeDescription>> {
    shapes::of_scene(reader, shape).map(Arc::new)
}

pub(super) fn distant(query: &Query<'_>) -> SensorKind {
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
