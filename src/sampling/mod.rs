//! Sample values.

/// How sample values are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SamplerKind {
    /// Owen-scrambled Sobol.
    Sobol,
    /// Independent random numbers (rand_pcg).
    Independent,
}
