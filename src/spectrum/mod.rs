//! Functions of wavelength, the wavelengths of a path, and colour.

mod sampled;

pub use sampled::Sampled;
