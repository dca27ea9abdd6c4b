//! Renders that end at an error: whether it is reached as surely as is said, and whether ending there makes
//! the picture wrong.

use crate::common::{self, stress};
use abbe::film::Film;
use abbe::integrator::Estimator;
use abbe::output::target::{CONFIDENCE, Target};
use abbe::render::{NoProgress, Progress, Schedule, Settings, WavelengthCount, Work, go_on, render};
use abbe::sampling::SamplerKind;
use abbe::scene::Scene;
use abbe::spectrum::colour::{Xyz, assumed_white, delta_e_2000, rec709_to_xyz};
use abbe::units::WavelengthRange;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

/// A picture at which a render ends.
struct Ended {
    colours: Vec<Xyz>,
    samples: f64,
}

/// Notes where `abbe render --until` ends for each of several targets, and ends the render when all are
/// reached: until then the samples are the same.
struct Until<'a> {
    targets: &'a [Target],
    ended: Mutex<Vec<Option<Ended>>>,
    stop: AtomicBool,
}

impl Progress for Until<'_> {
    fn advanced(&self, _: u64) {}

    fn pass_done(&self, work: &Work) {
        if !work.samples_per_replicate().is_some_and(Target::decides_at) {
            return;
        }
        let film = work.film();
        let mut ended = self.ended.lock().expect("no test has failed");
        for (target, ended) in self.targets.iter().zip(ended.iter_mut()) {
            if ended.is_none() && target.is_met(target.estimate(film)) {
                let samples = *film.samples_per_pixel().end() as f64;
                *ended = Some(Ended { colours: colours(film), samples });
            }
        }
        if ended.iter().all(Option::is_some) {
            self.stop.store(true, Ordering::Relaxed);
        }
    }

    fn stop(&self) -> &AtomicBool {
        &self.stop
    }
}

fn settings(samples: u32, seed: u64) -> Settings {
    Settings {
        schedule: Schedule::new(samples),
        seed,
        sampler: SamplerKind::Sobol,
        wavelengths: Some(WavelengthCount::Four),
        estimator: Estimator::Shared,
        bins: None,
    }
}

fn colours(film: &Film) -> Vec<Xyz> {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    film.shown().map(|(x, y)| Xyz::from(axes.map(|weights| film.combined(x, y, weights).mean))).collect()
}

fn luminance(colours: &[Xyz]) -> Vec<f64> {
    colours.iter().map(|colour| colour.y).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The pictures that renders with these targets end with.
fn ended(scene: &Scene, targets: &[Target], seed: u64) -> Vec<Ended> {
    let settings = settings(1 << 14, seed);
    let none = targets.iter().map(|_| None).collect();
    let until = Until { targets, ended: Mutex::new(none), stop: AtomicBool::new(false) };
    go_on(scene, &settings, Work::new(scene, &settings, None), &until);
    let ended = until.ended.into_inner().expect("no test has failed");
    ended.into_iter().map(|ended| ended.expect("the target is reached")).collect()
}

/// With 20 renders a target that is reached in four of five is seen, and a bias of four fifths of a standard
/// error.
#[test]
fn errors_are_reached_and_pictures_stay_right() {
    let seeds = stress::count(20, 2000);
    let scene = common::scene("tests/scenes/targets.xml", &[], WavelengthRange::VISIBLE);
    // More than thirty times those of the pictures that are judged by it.
    let of_truth = stress::count(1 << 13, 1 << 14);
    let truth = colours(&render(&scene, &settings(of_truth, 99_999), &NoProgress::new()));
    let white = rec709_to_xyz([1.0; 3]) * assumed_white(luminance(&truth));
    let (of_colours, truth) = (truth.clone(), luminance(&truth));
    let scale = mean(&truth);
    // Chance decides whether these take one number of samples or twice that.
    let texts = ["relmse<9e-4", "error<0.85%", "de<0.345"];
    let targets = texts.map(|text| text.parse::<Target>().expect("a target"));
    let renders: Vec<_> = (0..seeds).map(|seed| ended(&scene, &targets, seed)).collect();
    for (i, (text, target)) in texts.into_iter().zip(targets).enumerate() {
        let (mut reached, mut means, mut samples) = (0, Vec::new(), Vec::new());
        for Ended { colours: seen, samples: taken } in renders.iter().map(|ended| &ended[i]) {
            let picture = luminance(seen);
            samples.push(*taken);
            means.push(mean(&picture));
            let pairs = || picture.iter().zip(&truth);
            let error = match text.split_once('<') {
                Some(("relmse", _)) => {
                    let of_pixel = |(a, b): (&f64, &f64)| (a - b) * (a - b) / (b * b + 0.01 * scale * scale);
                    mean(&pairs().map(of_pixel).collect::<Vec<_>>())
                }
                Some(("de", _)) => {
                    let difference = |(a, b): (&Xyz, &Xyz)| delta_e_2000(a.to_lab(white), b.to_lab(white));
                    mean(&seen.iter().zip(&of_colours).map(difference).collect::<Vec<_>>())
                }
                // The mean of a normal deviate's size is √(2/π) of its standard error.
                _ => mean(&pairs().map(|(a, b)| (a - b).abs()).collect::<Vec<_>>()) / scale * 1.2533,
            };
            reached += u32::from(error < target.bound);
        }
        let n = f64::from(seeds as u32);
        // A share of successes has this standard error.
        let share = f64::from(reached) / n;
        let slack = 3.0 * (CONFIDENCE * (1.0 - CONFIDENCE) / n).sqrt();
        let sigma = (means.iter().map(|m| (m - mean(&means)).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
        let bias = (mean(&means) - scale) / sigma;
        let of_bias = (1.0 / n + mean(&samples) / f64::from(of_truth)).sqrt();
        assert!(samples.iter().any(|&count| count != samples[0]), "{text}: nothing is decided");
        println!(
            "{text}: reached by {:.1} %, {:.0} samples, mean off by {bias:.3} ± {:.3} of its standard error",
            100.0 * share,
            mean(&samples),
            of_bias
        );
        assert!(share > CONFIDENCE - slack, "{text}: {share} of {seeds} reach it");
        assert!(bias.abs() < 0.1 + 3.0 * of_bias, "{text}: {bias} of a standard error");
    }
}
