//! Whole paths: small pictures of the scenes that `validation/speed` measures, on one thread.

use super::Kernel;
use abbe::integrator::Estimator;
use abbe::render::{NoProgress, Schedule, Settings, WavelengthCount, render};
use abbe::sampling::SamplerKind;
use abbe::scene::{CompileOptions, ReadOptions, Scene, compile, read};
use std::path::Path;

const SIZE: usize = 16;
const SAMPLES: u32 = 8;

/// A scene of `validation/speed`, small.
pub fn compiled(name: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("speed/scenes/{name}.xml"));
    let options =
        ReadOptions { defines: vec![("size".to_owned(), SIZE.to_string())], ..ReadOptions::default() };
    let description = read(&path, &options).unwrap_or_else(|errors| panic!("{errors}"));
    compile(&description, &CompileOptions::default()).unwrap_or_else(|errors| panic!("{errors}"))
}

/// Renders a small picture of a scene.
pub fn picture(name: String, scene: Scene) -> Kernel {
    let settings = Settings {
        schedule: Schedule::new(SAMPLES),
        seed: 1,
        sampler: SamplerKind::Sobol,
        wavelengths: Some(WavelengthCount::Four),
        estimator: Estimator::Plain,
        bins: None,
    };
    let work = move || drop(render(&scene, &settings, &NoProgress::new()));
    Kernel { name, items: SIZE * SIZE * SAMPLES as usize, work: Box::new(work) }
}

pub fn kernels() -> Vec<Kernel> {
    let kernel = |name: &str| picture(name.to_owned(), compiled(name));
    ["cornell", "caustic", "absorber", "sodium"].map(kernel).into()
}
