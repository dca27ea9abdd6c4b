//! Functions of wavelength, the wavelengths of a path, and colour.

mod sampled;
mod wavelengths;

pub use sampled::Sampled;
pub use wavelengths::{WavelengthDensity, Wavelengths};
/// To come.
#[derive(Clone, Debug)]
pub struct DispersionFormula;
