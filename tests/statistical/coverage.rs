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

/// With a probability of 90 % the test finds error bars that are 10 % too small or 6 % too large whatever the
/// number of samples, and those that are a quarter too small at one number of them.
///
/// The truth is a picture of 2048 samples, whose own error the intervals hold. That is a third of their
/// square at 1024 samples, and where only the bars of pictures with so many are wrong, they are found where
/// they are two fifths too small.
#[test]
fn intervals_of_95_percent_hold_the_truth_in_95_percent_of_pixels() {
    const SAMPLES: [u32; 4] = [16, 64, 256, 1024];
    let mut counts = [[0.0; 2]; SAMPLES.len()];
    for name in ["diffuse", "metals", "frosted"] {
        let scene = scene(&format!("tests/scenes/agreement/{name}.xml"), &[], WavelengthRange::VISIBLE);
        let render = |samples, seed| expose(&scene, &settings(samples, WavelengthCount::Four, seed));
        let (truth, truth_error, _) = developed(&render(2048, 99));
        for (samples, [held, all]) in SAMPLES.into_iter().zip(&mut counts) {
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
            (*held, *all) = (*held + own_held, *all + own_all);
        }
    }
    for (samples, [held, all]) in SAMPLES.into_iter().zip(counts) {
        let (coverage, error) = (held / all, chance(all));
        assert!((coverage - 0.95).abs() < 0.015 + 3.0 * error, "{samples} samples: {coverage}");
        assert!(error < 0.009, "{samples} samples: {all} pixels tell little");
    }
    let [held, all] = [0, 1].map(|i| counts.iter().map(|count| count[i]).sum::<f64>());
    let coverage = held / all;
    assert!((coverage - 0.95).abs() < 0.015, "{coverage}");
    assert!(chance(all) < 0.002, "{all} pixels tell little");
}

/// Standard error of the share of so many intervals that hold the truth.
fn chance(intervals: f64) -> f64 {
    (0.95 * 0.05 / intervals).sqrt()
}
