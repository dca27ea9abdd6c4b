//! Errors relative to what they are errors of.

/// What relMSE divides a squared error by, for a value and the mean of all values of its picture: dark places
/// count as if they were a tenth as bright as the mean.
pub fn relmse_scale(value: f64, mean: f64) -> f64 {
    value * value + 0.01 * mean * mean
}
