//! Whether the error bars of one EXR hold the truth as often as they say: 95 % intervals, from few samples
//! and from many. `validation/noise/coverage` measures it over all scenes.

use crate::common::folder::Folder;
use crate::common::{expose, scene, settings};
use abbe::film::Film;
use abbe::output::{Colour, Content, Picture, exr};
use abbe::render::WavelengthCount;
use abbe::stats::student_quantile;
use abbe::units::WavelengthRange;

/// What a reader of the file that is written of a film finds: luminance, its error and the error's degrees of
/// freedom.
fn developed(film: &Film) -> (Vec<f32>, Vec<f32>, f64) {
    let picture = Picture {
        film,
        content: Content::Colour(Colour::Luminance),
        moments: None,
        auxiliary: Vec::new(),
        attributes: Vec::new(),
    };
    let folder = Folder::new("coverage");
    exr::write(&folder.path("x.exr"), &picture).expect("the file can be written");
    let file = folder.picture("x.exr");
    let channel = |name: &str| file.channel(name).expect("the channel is there").to_vec();
    let degrees = file.attribute("abbe.degreesOfFreedom").and_then(|text| text.parse().ok());
    (channel("Y"), channel("error.Y"), degrees.expect("a number"))
}

#[test]
fn intervals_of_95_percent_hold_the_truth_in_95_percent_of_pixels() {
    let (mut held, mut all) = (0.0, 0.0);
    for name in ["diffuse", "metals", "frosted"] {
        let scene = scene(&format!("tests/scenes/agreement/{name}.xml"), &[], WavelengthRange::VISIBLE);
        let render = |samples, seed| expose(&scene, &settings(samples, WavelengthCount::Four, seed));
        let (truth, truth_error, _) = developed(&render(2048, 99));
        for samples in [16, 64, 256, 1024] {
            let (mut own_held, mut own_all) = (0.0, 0.0);
            for seed in 0..u64::from((512 / samples).clamp(1, 8)) {
                let (mean, error, degrees) = developed(&render(samples, seed));
                let quantile = student_quantile(0.975, degrees);
                for i in (0..mean.len()).filter(|&i| error[i] > 0.0) {
                    let interval = quantile * f64::from(error[i]).hypot(f64::from(truth_error[i]));
                    own_held += f64::from(u8::from(f64::from((mean[i] - truth[i]).abs()) <= interval));
                    own_all += 1.0;
                }
            }
            println!("{name}, {samples} samples: {:.2} % of {own_all}", 100.0 * own_held / own_all);
            (held, all) = (held + own_held, all + own_all);
        }
    }
    let coverage: f64 = held / all;
    assert!((coverage - 0.95).abs() < 0.015, "{coverage}");
}
