//! Where the sun stands at a time and place (Blanco-Muriel et al., "Computing the Solar Vector", Solar Energy
//! 70(5), 2001).
//!
//! In single precision, in which the day since 2000 has steps of a quarter of a day, as in Mitsuba 3: the sun
//! is up to 0.01° off what the formulae give, but the shadows of both programs agree.

use crate::geometry::Vec3;
use std::f32::consts::{PI, TAU};

/// A time of the civil calendar and a place on Earth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunTime {
    /// Year, Gregorian, from -4000 to 10000.
    pub year: i32,
    /// Month, from 1 to 12.
    pub month: i32,
    /// Day of the month, from 1 to 31.
    pub day: i32,
    /// Local time; hours may have a fraction.
    pub hour: f64,
    /// Minute, from 0 to 60.
    pub minute: f64,
    /// Second, from 0 to 60.
    pub second: f64,
    /// Degrees, north positive.
    pub latitude: f64,
    /// Degrees, east positive.
    pub longitude: f64,
    /// Hours that local time is ahead of universal time.
    pub timezone: f64,
}

/// Earth's mean radius over the distance to the sun.
const PARALLAX: f32 = (6371.01 / 149_597_890.0) as f32;

/// The direction to the sun, with the zenith at +z and north at −x.
pub fn sun_direction(time: &SunTime) -> Vec3 {
    let (theta, phi) = angles(time);
    let (sin, cos) = f64::from(theta).sin_cos();
    let (sin_phi, cos_phi) = f64::from(phi).sin_cos();
    Vec3::new(cos_phi * sin, sin_phi * sin, cos)
}

/// Angle from the zenith and azimuth.
fn angles(time: &SunTime) -> (f32, f32) {
    let SunTime { year, month, day, .. } = *time;
    let [hour, minute, second] = [time.hour, time.minute, time.second].map(|x| x as f32);
    let [latitude, longitude, timezone] = [time.latitude, time.longitude, time.timezone].map(|x| x as f32);
    let hours = hour - timezone + (minute + second / 60.0) / 60.0;
    // The number of the Julian day; divisions round toward zero.
    let turn = (month - 14) / 12;
    let day_number = (1461 * (year + 4800 + turn)) / 4 + (367 * (month - 2 - 12 * turn)) / 12
        - (3 * ((year + 4900 + turn) / 100)) / 4
        + day
        - 32075;
    let days = (day_number as f32 - 0.5 + hours / 24.0) - 2_451_545.0;

    let node = 2.1429 - 0.001_039_459_4 * days;
    let mean_longitude = 4.895_063 + 0.017_202_792 * days;
    let anomaly = 6.240_06 + 0.017_201_97 * days;
    let longitude_of_sun =
        mean_longitude + 0.033_416_07 * anomaly.sin() + 0.000_348_94 * (2.0 * anomaly).sin()
            - 0.000_113_4
            - 0.000_020_3 * node.sin();
    let obliquity = 0.409_092_8 - 6.214e-9 * days + 0.000_039_6 * node.cos();

    let sin_longitude = longitude_of_sun.sin();
    let ascension = (obliquity.cos() * sin_longitude).atan2(longitude_of_sun.cos());
    let ascension = if ascension < 0.0 { ascension + TAU } else { ascension };
    let declination = (obliquity.sin() * sin_longitude).asin();

    let sidereal = 6.697_424_4 + 0.065_709_83 * days + hours;
    let hour_angle = (sidereal * 15.0 + longitude).to_radians() - ascension;
    let (sin_latitude, cos_latitude) = latitude.to_radians().sin_cos();
    let theta =
        (cos_latitude * hour_angle.cos() * declination.cos() + declination.sin() * sin_latitude).acos();
    let azimuth =
        (-hour_angle.sin()).atan2(declination.tan() * cos_latitude - sin_latitude * hour_angle.cos());
    let azimuth = if azimuth < 0.0 { azimuth + TAU } else { azimuth };
    (theta + PARALLAX * theta.sin(), azimuth - PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mitsuba 3.9.1: the middle of the disc that `sunsky` shows, found to 0.001°.
    #[test]
    fn the_sun_stands_where_mitsubas_does() {
        let tokyo = SunTime {
            year: 2010,
            month: 7,
            day: 10,
            hour: 15.0,
            minute: 0.0,
            second: 0.0,
            latitude: 35.6894,
            longitude: 139.6917,
            timezone: 9.0,
        };
        let munich = SunTime {
            year: 2024,
            month: 12,
            day: 21,
            hour: 10.0,
            minute: 30.0,
            second: 20.0,
            latitude: 48.1,
            longitude: 11.5,
            timezone: 1.0,
        };
        let cape_town = SunTime {
            year: 1999,
            month: 6,
            day: 21,
            hour: 9.5,
            minute: 15.0,
            second: 0.0,
            latitude: -33.9,
            longitude: 18.4,
            timezone: 2.0,
        };
        for (time, expected) in
            [(tokyo, [43.920, 85.752]), (munich, [75.108, -24.117]), (cape_town, [71.969, -136.279])]
        {
            let (theta, phi) = angles(&time);
            let found = [theta, phi].map(|angle| f64::from(angle).to_degrees());
            assert!(
                (found[0] - expected[0]).abs() < 2e-3 && (found[1] - expected[1]).abs() < 2e-3,
                "{found:?}"
            );
        }
    }
}
