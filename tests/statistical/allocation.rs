//! Samples that are allocated over the picture leave it as it is: where cells of few samples and of many
//! meet, and in how many samples a pixel has.

use crate::common::{expose, made, settings};
use abbe::film::{Film, Quantity};
use abbe::integrator::Estimator;
use abbe::render::{Schedule, Settings, WavelengthCount};
use abbe::scene::CompileOptions;
use abbe::stats::{Estimate, welch};

/// A third of the picture shows a wall under two lamps, the rest nothing. The wall's edge is within the reach
/// of the filter from where cells of 16 pixels meet.
const SCENE: &str = r#"
    <integrator type="path"/>
    <sensor type="orthographic">
        <transform name="to_world"><lookat origin="0, 0, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="96"/><integer name="height" value="96"/>
            <rfilter type="gaussian"/></film>
    </sensor>
    <shape type="rectangle"><transform name="to_world"><scale y="2"/><translate x="1.345"/></transform></shape>
    <shape type="sphere"><point name="center" x="0.7" y="0.5" z="0.5"/><float name="radius" value="0.1"/>
        <emitter type="area"><spectrum name="radiance" value="10"/></emitter></shape>
    <shape type="sphere"><point name="center" x="0.7" y="-0.5" z="0.5"/><float name="radius" value="0.1"/>
        <emitter type="area"><spectrum name="radiance" value="400:0, 700:20"/></emitter></shape>"#;

const REPLICATES: u32 = 16;

fn film(estimator: Estimator, samples: u32, seed: u64) -> Film {
    let scene = made(SCENE, &CompileOptions::default());
    let schedule = Schedule::independent(REPLICATES, samples / REPLICATES);
    expose(&scene, &Settings { schedule, estimator, ..settings(samples, WavelengthCount::Four, seed) })
}

#[test]
fn pixels_between_cells_are_those_of_an_even_picture() {
    let even = film(Estimator::Plain, 512, 0);
    // By a pilot which finds that it pays: the picture's samples are independent of the pilot's.
    let is_allocated = |film: &Film| {
        let counts = film.samples_per_pixel();
        *counts.start() <= 256 && *counts.end() >= 1024
    };
    let mut films = (1..8).map(|seed| film(Estimator::Shared, 512, seed));
    let allocated = films.find(is_allocated).expect("a pilot of several");
    let mean = allocated.total_samples() as f64 / (96.0 * 96.0);
    assert!((300.0..=512.0).contains(&mean), "{mean} samples per pixel");
    let column = |film: &Film, x: u32| {
        let measured = film.mean_over((0..96).map(|y| (x, y)), Quantity::Combined([0.0, 1.0, 0.0]));
        let degrees = f64::from(REPLICATES - 1);
        Estimate { mean: measured.mean, variance: measured.error.powi(2), degrees }
    };
    for x in 0..96 {
        let [a, b] = [&allocated, &even].map(|film| column(film, x));
        let test = welch(&a, &b);
        assert!(test.p_value > 0.001 / 96.0, "column {x}: {test:?}");
    }
}
