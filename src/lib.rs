//! abbe: a spectral, physically based Monte Carlo renderer.
//!
//! Data flows one way: a scene file is read into a [`scene::Description`], compiled into a
//! [`scene::Scene`], rendered into a [`film::Film`], and developed into EXR, PNG and a report.
//! A room knows only the rooms above it in the list below.
//!
//! What a material is at a wavelength:
//!
//! ```
//! use abbe::bsdf::fresnel;
//! use abbe::spectrum::catalogue;
//!
//! let glass = catalogue::dielectric("N-BK7").unwrap();
//! assert!((glass.at(587.5618) - 1.51680).abs() < 1e-5);
//! assert!((glass.abbe_number() - 64.17).abs() < 0.01);
//! let at_normal_incidence = fresnel::dielectric(1.0, glass.at(587.5618)).reflectance;
//! assert!((at_normal_incidence - 0.0422).abs() < 1e-4);
//! ```
//!
//! A scene from a text, rendered, with the mean luminance of a pixel and its standard error:
//!
//! ```
//! use abbe::film::Quantity;
//! use abbe::integrator::Estimator;
//! use abbe::render::{NoProgress, Schedule, Settings, WavelengthCount, render};
//! use abbe::sampling::SamplerKind;
//! use abbe::scene::{CompileOptions, ReadOptions, compile, read_str};
//! use std::path::Path;
//!
//! // A diffuse ball of albedo 0.5 in a uniform sky of radiance 1.
//! let text = r#"<scene version="3.0.0">
//!     <integrator type="path"/>
//!     <sensor type="perspective">
//!         <transform name="to_world"><lookat origin="0, 0, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
//!         <film type="hdrfilm"><integer name="width" value="9"/><integer name="height" value="9"/></film>
//!     </sensor>
//!     <shape type="sphere">
//!         <bsdf type="diffuse"><spectrum name="reflectance" value="0.5"/></bsdf>
//!     </shape>
//!     <emitter type="constant"><spectrum name="radiance" value="1"/></emitter>
//! </scene>"#;
//! let description = read_str(text, Path::new("ball.xml"), &ReadOptions::default()).unwrap();
//! let scene = compile(&description, &CompileOptions::default()).unwrap();
//! let settings = Settings {
//!     schedule: Schedule::new(64),
//!     seed: 0,
//!     sampler: SamplerKind::Sobol,
//!     wavelengths: Some(WavelengthCount::Four),
//!     estimator: Estimator::Shared,
//!     bins: None,
//! };
//! let film = render(&scene, &settings, &NoProgress::new());
//! let luminance = Quantity::Combined([0.0, 1.0, 0.0]);
//! let [ball, sky] = [[4, 4], [0, 0]].map(|[x, y]| film.measured(x, y, luminance));
//! assert!(ball.error > 0.0 && ball.error < 0.01);
//! assert!((ball.mean / sky.mean - 0.5).abs() < 0.02);
//! ```
//!
//! What a ray meets:
//!
//! ```
//! use abbe::accel::Accel;
//! use abbe::geometry::{Ray, Transform, Vec3};
//! use abbe::shape::{Shape, Sphere};
//!
//! let ball = Shape::Sphere(Sphere::new(&Transform::IDENTITY, Vec3::ZERO, 1.0, false).unwrap());
//! let accel = Accel::build(&[ball]);
//! let hit = accel.closest(&Ray::new(Vec3::new(0.0, 0.0, 4.0), Vec3::NEG_Z), 0.0).unwrap();
//! assert_eq!(hit.t, 3.0);
//! ```
//!
//! Two pictures, and whether they differ by more than their noise:
//!
//! ```
//! use abbe::compare::{Options, compare};
//! use abbe::output::exr;
//! use std::path::Path;
//! # fn judge() -> Result<(), Box<dyn std::error::Error>> {
//! let [a, b] = [exr::read(Path::new("a.exr"))?, exr::read(Path::new("b.exr"))?];
//! let comparison = compare(&[a], &[b], &Options::default()).map_err(|error| error.to_string())?;
//! println!("relMSE {}", comparison.figures.relmse);
//! if let Some(verdict) = comparison.verdict() {
//!     println!("p = {} that noise alone differs so much", verdict.p);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! A measured spectrum:
//!
//! ```
//! use abbe::spectrum::catalogue;
//!
//! let red = catalogue::reflectance("colorchecker/red").unwrap();
//! assert!(red.at(650.0) > 5.0 * red.at(500.0));
//! ```

pub mod units;

pub mod lanes;

pub mod geometry;
pub mod stats;

pub mod plot;

pub mod sampling;
pub mod spectrum;

pub mod raster;

pub mod shape;
pub mod texture;

pub mod accel;
pub mod bsdf;
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
#[path = "../tests/common/mutation.rs"]
mod mutation;

#[cfg(test)]
#[path = "../tests/common/stress.rs"]
mod stress;
