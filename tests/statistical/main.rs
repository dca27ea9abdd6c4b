//! What is judged by its standard error: estimators against one another and against closed forms, samplers
//! and BSDFs against their densities, error bars against the truth. Each test says what difference it can
//! see.

mod agreement;
mod allocation;
mod bsdf;
mod closed_forms;
#[path = "../common/mod.rs"]
mod common;
mod coverage;
mod distribution;
mod glow;
mod history;
mod media;
mod sampling;
mod sensors;
mod shared_noise;
mod targets;
mod textures;
