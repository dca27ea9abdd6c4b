//! Densities of sampled directions.

/// A density always comes with its measure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Density {
    /// Per steradian.
    PerSolidAngle(f64),
    /// One of finitely many directions; no other technique can find it.
    Discrete,
}
