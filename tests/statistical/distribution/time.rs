//! How well time is sampled: what a pixel that is covered for a part of the time varies by.

use super::{coverage, flat_camera, pixels, settings};
use crate::common;
use abbe::film::Film;
use abbe::sampling::SamplerKind;
use abbe::stats::Moments;

/// Part of the time for which each pixel is covered.
const PART: f64 = 0.3;
const SAMPLES: u32 = 16;

/// A slab that is over each pixel for [`PART`] of the time, from a moment on that changes over the width of
/// the film by the length of one of the strata: fast enough that the width of a pixel does not matter.
fn film(sampler: SamplerKind) -> Film {
    const WIDTH: u32 = 64;
    let speed = f64::from(WIDTH * SAMPLES);
    let half = 0.5 * PART * speed;
    // Its front reaches the left edge after a tenth of the time.
    let start = -0.5 * f64::from(WIDTH) - 0.1 * speed - half;
    let keys = [0.0, 1.0].map(|time| {
        format!(
            r#"<transform time="{time}"><scale x="{half}" y="100"/><translate x="{}"/></transform>"#,
            start + speed * time
        )
    });
    let shutter = r#"<float name="shutter_open" value="0"/><float name="shutter_close" value="1"/>"#;
    let scene = super::compiled(&format!(
        r#"{}<shape type="rectangle"><animation name="to_world">{}</animation></shape>"#,
        flat_camera(WIDTH, 32, shutter),
        keys.concat()
    ));
    common::expose(&scene, &settings(sampler, 16, SAMPLES, 4))
}

/// The variance of a pixel of [`SAMPLES`] samples, over all pixels.
fn variance(sampler: SamplerKind) -> Moments {
    let film = film(sampler);
    let of_pixel = |(x, y)| coverage(&film, x, y).variance * f64::from(film.replicates);
    pixels(&film).map(of_pixel).collect()
}

fn check(sampler: SamplerKind, expected: f64) {
    let found = variance(sampler).estimate();
    let z = (found.mean - expected) / found.error();
    println!(
        "{sampler:?}: variance {:.6} ± {:.6}, expected {expected:.6}, z {z:+.2}",
        found.mean,
        found.error()
    );
    assert!(found.error() < 0.03 * expected, "{sampler:?}: {}", found.error() / expected);
    assert!(z.abs() < 3.3, "{sampler:?}: {} is not {expected}", found.mean);
}

#[test]
fn independent_times_vary_as_p_times_1_minus_p_over_n() {
    check(SamplerKind::Independent, PART * (1.0 - PART) / f64::from(SAMPLES));
}

/// Only the strata in which the slab comes and goes are random, each by 1/6 of a sample on the average.
#[test]
fn jittered_times_vary_by_one_over_three_n_squared() {
    check(SamplerKind::Jittered, 1.0 / (3.0 * f64::from(SAMPLES).powi(2)));
}
