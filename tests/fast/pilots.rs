//! How a picture is rendered is found by pilots.

use crate::common::{compiled, described_file};
use abbe::integrator::Estimator;
use abbe::render::{Chosen, Progress, Schedule, Settings, WavelengthCount, Work, render};
use abbe::sampling::SamplerKind;
use abbe::scene::CompileOptions;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

/// Takes note of what the pilots choose, and ends the render there.
#[derive(Default)]
struct Noted {
    chosen: OnceLock<Chosen>,
    stop: AtomicBool,
}

impl Progress for Noted {
    fn pilots_done(&self, chosen: &Chosen) {
        self.chosen.set(*chosen).expect("pilots end once");
        self.stop.store(true, Ordering::Relaxed);
    }

    fn advanced(&self, _: u64) {}

    fn pass_done(&self, _: &Work) {}

    fn stop(&self) -> &AtomicBool {
        &self.stop
    }
}

/// How many wavelengths the paths of a scene of `tests/scenes` carry.
fn wavelengths(name: &str, asked: Option<WavelengthCount>) -> WavelengthCount {
    let mut description = described_file(&format!("tests/scenes/{name}.xml"), &[]);
    (description.sensor.film.width, description.sensor.film.height) = (192, 192);
    let scene = compiled(&description, &CompileOptions::default());
    let settings = Settings {
        schedule: Schedule::of(SamplerKind::Sobol, 64),
        seed: 1,
        sampler: SamplerKind::Sobol,
        wavelengths: asked,
        estimator: Estimator::Shared,
        bins: None,
    };
    let noted = Noted::default();
    let film = render(&scene, &settings, &noted);
    assert_eq!(film.measured_samples(), 0, "it ends with the pilots");
    noted.chosen.get().expect("the pilots have ended").wavelengths
}

/// Where a lamp lights a floor, wavelengths are what varies; behind a pane of glass it is the light, and four
/// have the same squared error in 0.93 of the CPU time.
#[test]
fn eight_wavelengths_are_for_what_is_smooth() {
    let [light, pane] = ["smooth/light", "agreement/window"];
    assert_eq!(wavelengths(light, None), WavelengthCount::Eight);
    assert_eq!(wavelengths(pane, None), WavelengthCount::Four);
    for asked in [WavelengthCount::One, WavelengthCount::Four] {
        assert_eq!(wavelengths(light, Some(asked)), asked);
    }
}
