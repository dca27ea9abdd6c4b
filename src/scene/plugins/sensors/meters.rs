//! Sensors that measure a single value: along a ray, on a surface, or from far away.

use super::super::{Field, Parameter, Takes, shapes};
use crate::geometry::Vec3;
use crate::scene::description::{DistantTarget, ShapeDescription};
use crate::scene::read::{Class, ObjectId, Query, Reader, Value};
use crate::scene::source::SceneError;
use crate::scene::write::{Node, Writer};
use std::sync::Arc;

fn parameter(name: &'static str, takes: Takes, doc: &'static str) -> Parameter {
    Parameter { doc, ..Parameter::new(name, takes) }
}

/// The ray along which radiance is measured: its origin and its direction.
pub struct Line;

impl Field for Line {
    type Value = (Vec3, Vec3);

    fn parameters(&self) -> Vec<Parameter> {
        vec![
            parameter("origin", Takes::Vector, "where it stands; otherwise the origin"),
            parameter("direction", Takes::Vector, "where it looks; otherwise along +z"),
            parameter("to_world", Takes::Transform, "instead of both"),
        ]
    }

    fn read(&self, query: &Query<'_>) -> Option<(Vec3, Vec3)> {
        let (origin, direction) = (query.vector("origin"), query.vector("direction"));
        let (given_origin, given_direction) = (query.has("origin"), query.has("direction"));
        if query.has("to_world") {
            let to_world = query.transform("to_world");
            if given_origin || given_direction {
                let place = query.place(if given_origin { "origin" } else { "direction" });
                query.reader.remark(&place, "to_world goes before origin and direction".to_owned());
            }
            return Some((to_world.point(Vec3::ZERO), to_world.vector(Vec3::Z)));
        }
        if given_origin != given_direction {
            let (given, missing) =
                if given_origin { ("origin", "direction") } else { ("direction", "origin") };
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
            return Some((Vec3::ZERO, Vec3::Z));
        }
        Some((origin?, some_way(query, direction?)))
    }

    fn write(&self, node: Node, (origin, direction): &(Vec3, Vec3), _: &mut Writer) -> Node {
        node.vector("origin", *origin).vector("direction", *direction)
    }
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

/// The shape around an irradiance meter.
pub struct ItsShape;

impl Field for ItsShape {
    type Value = Arc<ShapeDescription>;

    fn parameters(&self) -> Vec<Parameter> {
        Vec::new()
    }

    fn read(&self, query: &Query<'_>) -> Option<Self::Value> {
        if query.has("to_world") {
            query.entry("to_world");
            query.error(
                SceneError::at(
                    &query.place("to_world"),
                    "An irradiance meter has no transform of its own",
                    "its place is that of the shape around it",
                )
                .with_remedy("move the transform into the <shape>"),
            );
        }
        let Some(shape) = query.shape else {
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
        surface(query.reader, shape)
    }

    /// The meter is written into its shape.
    fn write(&self, node: Node, _: &Self::Value, _: &mut Writer) -> Node {
        node
    }
}

fn surface(reader: &Reader, shape: ObjectId) -> Option<Arc<ShapeDescription>> {
    shapes::of_scene(reader, shape).map(Arc::new)
}

/// Where a distant sensor looks.
pub struct Toward;

impl Field for Toward {
    type Value = Vec3;

    fn parameters(&self) -> Vec<Parameter> {
        vec![
            parameter("direction", Takes::Vector, "where it looks; otherwise along +z"),
            parameter("to_world", Takes::Transform, "instead, what turns +z there"),
        ]
    }

    fn read(&self, query: &Query<'_>) -> Option<Vec3> {
        let direction = query.vector("direction").map(|direction| some_way(query, direction));
        if query.has("direction") && query.has("to_world") {
            query.error(SceneError::at(
                &query.place("to_world"),
                "The direction is given twice",
                "expected either direction or to_world",
            ));
        }
        let to_world = query.transform("to_world");
        Some(direction.unwrap_or_else(|| to_world.vector(Vec3::Z)))
    }

    fn write(&self, node: Node, direction: &Vec3, _: &mut Writer) -> Node {
        node.vector("direction", *direction)
    }
}

/// What a distant sensor looks at.
pub struct Target;

impl Field for Target {
    type Value = DistantTarget;

    fn parameters(&self) -> Vec<Parameter> {
        vec![
            parameter("target", Takes::Vector, "a point that it looks at; otherwise all of the scene"),
            parameter("target", Takes::Object("shape"), "instead, a surface that it looks at"),
        ]
    }

    fn read(&self, query: &Query<'_>) -> Option<DistantTarget> {
        let Some(entry) = query.entry("target") else { return Some(DistantTarget::Scene) };
        Some(match entry.value {
            Value::Vector(point) => DistantTarget::Point(point),
            Value::Object(id) if query.reader.tree.get(id).class == Class::Shape => {
                surface(query.reader, id).map_or(DistantTarget::Scene, DistantTarget::Surface)
            }
            _ => {
                query.error(query.wrong_type(entry, "target", "<point> or <shape>"));
                DistantTarget::Scene
            }
        })
    }

    fn write(&self, node: Node, target: &DistantTarget, writer: &mut Writer) -> Node {
        match target {
            DistantTarget::Scene => node.remark("looks at all of the scene"),
            DistantTarget::Point(point) => node.vector("target", *point),
            DistantTarget::Surface(surface) => node.named("target", shapes::node(surface, writer)),
        }
    }
}
