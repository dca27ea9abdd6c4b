//! `sunsky`: the sky's parameters and the sun's place, given or computed.

use super::placements::rotation;
use crate::geometry::{Transform, Vec3};
use crate::light::sky::{self, SunTime};
use crate::scene::plugins::fields::{Float, Integer};
use crate::scene::plugins::{Field, Parameter, Range, Simple, Takes, float, integer};
use crate::scene::read::Query;
use crate::scene::source::SceneError;
use crate::scene::write::{Node, Writer};

/// What says when and where the sun is looked at.
const TIME: [&str; 9] =
    ["year", "month", "day", "hour", "minute", "second", "latitude", "longitude", "timezone"];

const REMEDY: &str = "times and places outside the calendar and the globe have no sun";

const fn number(
    name: &'static str,
    default: f64,
    [low, high]: [f64; 2],
    unit: &'static str,
    doc: &'static str,
) -> Simple<Float> {
    float(name, default, doc).within(Range::between(low, high)).remedy(REMEDY).unit(unit)
}

// Mitsuba 3's defaults: a summer afternoon in Tokyo.
const DATE: [Simple<Integer<i32>>; 3] = [
    integer("year", 2010, [-4000, 10_000], "year"),
    integer("month", 7, [1, 12], "month"),
    integer("day", 10, [1, 31], "day of the month"),
];

const CLOCK_AND_PLACE: [Simple<Float>; 6] = [
    number("hour", 15.0, [0.0, 24.0], "hours", "time of day"),
    number("minute", 0.0, [0.0, 60.0], "minutes", "added to it"),
    number("second", 0.0, [0.0, 60.0], "seconds", "added to it"),
    number("latitude", 35.6894, [-90.0, 90.0], "degrees", "latitude, north above 0"),
    number("longitude", 139.6917, [-180.0, 180.0], "degrees", "longitude, east above 0"),
    number("timezone", 9.0, [-12.0, 14.0], "hours", "time of the clock less universal time"),
];

/// Where the sun is: a direction in the world, or a time and a place.
pub struct Sun;

impl Field for Sun {
    type Value = Vec3;

    fn parameters(&self) -> Vec<Parameter> {
        let direction = Parameter::new("sun_direction", Takes::Vector);
        let direction =
            Parameter { doc: "direction to the sun; otherwise time and place say it", ..direction };
        let date = DATE.iter().flat_map(Field::parameters);
        std::iter::once(direction)
            .chain(date)
            .chain(CLOCK_AND_PLACE.iter().flat_map(Field::parameters))
            .collect()
    }

    fn read(&self, query: &Query<'_>) -> Option<Vec3> {
        let to_world = rotation(query);
        let direction = sun(query, &to_world);
        if direction.is_some_and(|direction| to_world.inverse().vector(direction).z < 0.0) {
            let place = query.place("sun_direction");
            query.reader.remark(&place, "the sun is below the horizon: the sky is dark".to_owned());
        }
        direction
    }

    fn write(&self, node: Node, direction: &Vec3, _: &mut Writer) -> Node {
        node.vector("sun_direction", *direction)
    }
}

/// In the world. A given direction is one of the world already, a computed one is turned with the sky
/// (Mitsuba 3).
fn sun(query: &Query<'_>, to_world: &Transform) -> Option<Vec3> {
    let given = query.vector("sun_direction");
    let time = time(query)?;
    if !query.has("sun_direction") {
        return Some(to_world.vector(sky::sun_direction(&time)));
    }
    if let Some(name) = TIME.into_iter().find(|&name| query.has(name)) {
        query.error(
            SceneError::at(
                &query.place(name),
                "The sun's place is given twice",
                "expected either sun_direction or time and place",
            )
            .with_remedy(format!("leave out sun_direction, or {name} and its like")),
        );
    }
    let direction = given?;
    if direction.try_normalize().is_none() {
        query.error(SceneError::at(
            &query.place("sun_direction"),
            "The direction to the sun has no length",
            "expected a direction such as 0 0 1",
        ));
        return None;
    }
    Some(direction)
}

fn time(query: &Query<'_>) -> Option<SunTime> {
    let [Some(year), Some(month), Some(day)] = DATE.map(|field| field.read(query)) else { return None };
    let [Some(hour), Some(minute), Some(second), Some(latitude), Some(longitude), Some(timezone)] =
        CLOCK_AND_PLACE.map(|field| field.read(query))
    else {
        return None;
    };
    Some(SunTime { year, month, day, hour, minute, second, latitude, longitude, timezone })
}
