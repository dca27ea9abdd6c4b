//! The film that is exposed, and what begins a path.

use crate::camera::SensorRay;
use crate::film::{Extent, FilterKind};
use crate::spectrum::Spectrum;

/// The film that is exposed.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmPlan {
    /// The exposed pixels within the whole film.
    pub extent: Extent,
    /// Reconstruction filter.
    pub filter: FilterKind,
    /// Whether samples fall outside of the window that is exposed.
    pub sample_border: bool,
    /// Whether alpha is measured.
    pub alpha: bool,
    /// Whether the second moments of the samples are measured, too.
    pub moments: bool,
    /// The sensor's own channels, if it has any.
    pub channels: Vec<FilmChannel>,
}

/// A channel of the sensor: what it measures is the integral of spectral radiance over its response.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmChannel {
    /// What the file calls it.
    pub name: String,
    /// Response by wavelength, at least 0.
    pub response: Spectrum,
    /// Integral of the response over the range of wavelengths, nm. Above 0.
    pub integral: f64,
}

/// What begins a path.
#[derive(Clone, Copy, Debug)]
pub struct CameraSample<'a> {
    /// The camera ray.
    pub sensor: SensorRay<'a>,
    /// The sample value that chooses the wavelengths.
    pub wavelength: f64,
    /// When the whole path happens.
    pub time: f64,
}
