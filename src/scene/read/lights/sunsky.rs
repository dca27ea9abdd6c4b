//! `sunsky`: the sky's parameters and the sun's place, given or computed.

use super::super::query::Query;
use super::super::spectra::{self, Use};
use super::rotation;
use crate::geometry::{Transform, Vec3};
use crate::light::sky::{self, SunTime};
use crate::scene::description::LightKind;
use crate::scene::source::SceneError;

/// What says when and where the sun is looked at.
const TIME: [&str; 9] =
    ["year", "month", "day", "hour", "minute", "second", "latitude", "longitude", "timezone"];

pub(super) fn read(query: &Query<'_>) -> Option<LightKind> {
    let turbidity = between(query, "turbidity", 3.0, 1.0, 10.0, "1 is clear air, 10 a heavy haze");
    let albedo = spectra::read_or(query, "albedo", Use::Reflectance, 0.3);
    let sky_scale = between(query, "sky_scale", 1.0, 0.0, f64::INFINITY, "light cannot be taken away");
    let sun_scale = between(query, "sun_scale", 1.0, 0.0, f64::INFINITY, "light cannot be taken away");
    let sun_aperture = query.float("sun_aperture").unwrap_or(0.5358);
    if !(sun_aperture > 0.0 && sun_aperture < 180.0) {
        query.error(SceneError::at(
            &query.place("sun_aperture"),
            format!("The sun is {sun_aperture} degrees wide"),
            "expected an angle above 0 and below 180 degrees",
        ));
    }
    let complex_sun = query.boolean("complex_sun", false);
    let to_world = rotation(query);
    let sun_direction = sun(query, &to_world);
    if sun_direction.is_some_and(|direction| to_world.inverse().vector(direction).z < 0.0) {
        let place = query.place("sun_direction");
        query.reader.remark(&place, "the sun is below the horizon: the sky is dark".to_owned());
    }
    Some(LightKind::SunSky {
        to_world,
        turbidity,
        albedo,
        sun_direction: sun_direction?,
        sky_scale,
        sun_scale,
        sun_aperture,
        complex_sun,
    })
}

fn between(query: &Query<'_>, name: &'static str, default: f64, least: f64, most: f64, remedy: &str) -> f64 {
    let value = query.float(name).unwrap_or(default);
    if !(least..=most).contains(&value) {
        let expected = match most.is_finite() {
            true => format!("expected a number from {least} to {most}"),
            false => format!("expected a number of at least {least}"),
        };
        let problem = format!("\"{name}\" of {} is {value}", query.title());
        query.error(SceneError::at(&query.place(name), problem, expected).with_remedy(remedy));
        return default;
    }
    value
}

/// In the world. A given direction is one of the world already, a computed one is turned with the sky
/// (Mitsuba 3).
fn sun(query: &Query<'_>, to_world: &Transform) -> Option<Vec3> {
    let given = query.vector("sun_direction");
    let time = time(query);
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

/// Mitsuba 3's defaults: a summer afternoon in Tokyo.
fn time(query: &Query<'_>) -> SunTime {
    let integer = |name, default: i32, least, most| {
        query.integer(name, least, most).map_or(default, |number| number as i32)
    };
    let float = |name, default: f64, least: f64, most: f64| {
        between(
            query,
            name,
            default,
            least,
            most,
            "times and places outside the calendar and the globe have no sun",
        )
    };
    SunTime {
        year: integer("year", 2010, -4000, 10_000),
        month: integer("month", 7, 1, 12),
        day: integer("day", 10, 1, 31),
        hour: float("hour", 15.0, 0.0, 24.0),
        minute: float("minute", 0.0, 0.0, 60.0),
        second: float("second", 0.0, 0.0, 60.0),
        latitude: float("latitude", 35.6894, -90.0, 90.0),
        longitude: float("longitude", 139.6917, -180.0, 180.0),
        timezone: float("timezone", 9.0, -12.0, 14.0),
    }
}
