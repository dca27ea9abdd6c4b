//! Sensors side by side.

use super::super::{Field, Parameter, Takes, shapes};
use crate::scene::description::{Film, FilmContent, Sensor};
use crate::scene::read::{Class, Query, Reader};
use crate::scene::source::SceneError;
use crate::scene::write::{Node, Writer};

/// The sensors of a batch, from left to right.
pub struct Sensors;

impl Field for Sensors {
    type Value = Vec<Sensor>;

    fn parameters(&self) -> Vec<Parameter> {
        let held = |element, doc| Parameter { doc, ..Parameter::new("", Takes::Object(element)) };
        vec![
            Parameter { is_required: true, ..held("sensor", "each is shown in a column of the film") },
            held("shape", "one with an `irradiancemeter` in it, which is such a sensor, too"),
            Parameter { doc: "changes nothing", ..Parameter::new("to_world", Takes::Transform) },
        ]
    }

    fn read(&self, query: &Query<'_>) -> Option<Vec<Sensor>> {
        let found = super::children(query);
        query.objects(Class::Sensor);
        for (entry, shape) in query.objects(Class::Shape) {
            if !found.iter().any(|child| child.shape == Some(shape)) {
                let problem = "A shape in a batch holds no sensor";
                query.error(
                    SceneError::at(&entry.place, problem, "expected a sensor in it")
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
        let read: Vec<_> = found.into_iter().map(|child| super::one(query.reader, child, true)).collect();
        read.into_iter().collect()
    }

    fn write(&self, node: Node, sensors: &Vec<Sensor>, writer: &mut Writer) -> Node {
        sensors.iter().fold(node, |node, sensor| {
            let child = super::node(sensor, writer);
            node.child(match super::surface(sensor) {
                Some(surface) => shapes::node(surface, writer).child(child),
                None => child,
            })
        })
    }
}

/// What the film of a batch cannot be.
pub fn check_film(reader: &Reader, film: &Film, sensors: &[Sensor]) {
    if let FilmContent::Responses(_) = film.content {
        reader.error(
            SceneError::at(
                &film.place,
                "A batch cannot have a specfilm",
                "expected an hdrfilm: in a batch Mitsuba 3 weighs responses wrongly",
            )
            .with_remedy("give each sensor its own specfilm outside of a batch; -s chooses one of them"),
        );
    }
    if !(film.width as usize).is_multiple_of(sensors.len()) {
        let problem =
            format!("A film {} pixels wide cannot be shared by {} sensors", film.width, sensors.len());
        let expected = "expected a width that the number of sensors divides";
        reader.error(SceneError::at(&film.place, problem, expected));
    }
    for medium in sensors.iter().filter_map(|sensor| sensor.medium.as_ref()) {
        let text = "this medium changes nothing: that of the batch counts".to_owned();
        reader.remark(&medium.place, text);
    }
}
