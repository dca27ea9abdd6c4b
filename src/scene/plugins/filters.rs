//! Reconstruction filters.

use super::{Range, declare, float, integer};
use crate::film::FilterKind;
use crate::scene::read::{Class, Query};

/// Mitsuba 3's default.
pub const DEFAULT: FilterKind = FilterKind::Gaussian { stddev: 0.5 };

/// Widest radius of a filter, pixels. Each sample is added to all pixels within it.
const WIDEST: f64 = 128.0;

/// Above 0 and up to a bound.
const fn up_to(high: f64) -> Range {
    Range { high, with_high: true, ..Range::POSITIVE }
}

declare! {
    Class::Filter => FilterKind;

    "box", "each sample belongs to the pixel that it falls into" => FilterKind::Box {} {};
    "tent", "falls linearly to 0" => FilterKind::Tent { radius } {
        radius: float("radius", 1.0, "distance at which it is 0").within(up_to(WIDEST)).unit("pixels"),
    };
    "gaussian", "a bell, cut off at four standard deviations, the default" => FilterKind::Gaussian { stddev } {
        stddev: float("stddev", 0.5, "standard deviation").within(up_to(WIDEST / 4.0)).unit("pixels"),
    };
    "mitchell", "the cubic filters of Mitchell and Netravali" => FilterKind::Mitchell { b, c } {
        b: float("B", 1.0 / 3.0, "blur"),
        c: float("C", 1.0 / 3.0, "ringing"),
    };
    "catmullrom", "the sharpest of the cubic filters, B = 0 and C = 1/2" => FilterKind::CatmullRom {} {};
    "lanczos", "a windowed sinc" => FilterKind::Lanczos { lobes } {
        lobes: integer("lobes", 3, [1, 32], "number of lobes on each side"),
    };
}

/// The filter of the film that is asked.
pub fn of_film(film: &Query<'_>) -> FilterKind {
    let Some((_, id)) = film.object(Class::Filter) else { return DEFAULT };
    let query = Query::new(film.reader, id);
    let Some(filter) = read(&query) else { return DEFAULT };
    let place = query.object.place.clone();
    query.finish();
    // Mitsuba 3 takes every filter that is just a pixel wide for a box.
    if filter.radius() == 0.5 && filter != FilterKind::Box {
        let text = "a filter of radius 0.5 is a box, as in Mitsuba 3".to_owned();
        film.reader.remark(&place, text);
        return FilterKind::Box;
    }
    filter
}
