//! Functions of wavelength, the wavelengths of a path, and colour.

mod sampled;

pub use sampled::Sampled;
/// To come.
#[derive(Clone, Debug)]
pub struct DispersionFormula;
