//! abbe: a spectral, physically based Monte Carlo renderer.
//!
//! Data flows one way: a scene file is read into a [`scene::Description`], compiled into a
//! [`scene::Scene`], rendered into a [`film::Film`], and developed into EXR, PNG and a report.
//! A room knows only the rooms above it in the list below.

pub mod units;

pub mod geometry;
pub mod stats;

pub mod plot;

pub mod sampling;
pub mod spectrum;

pub mod lanes;
pub mod raster;

pub mod bsdf;
pub mod shape;
pub mod texture;

pub mod accel;
pub mod light;
pub mod material;
pub mod phase;

pub mod medium;

pub mod camera;
pub mod film;

pub mod scene;

pub mod integrator;
pub mod render;

pub mod output;

pub mod compare;

pub mod study;

#[cfg(test)]
#[path = "../tests/common/stress.rs"]
mod stress;
