//! Statistics by which random results are judged: never by a guessed tolerance.

mod fourier;
mod goodness;
mod moments;
mod relative;
mod sphere;
mod welch;

pub use fourier::fourier;
pub use goodness::{ChiSquare, Uniformity, chi_square, sidak, sidak_corrected, uniformity};
pub use moments::{Estimate, Moments};
pub use relative::relmse_scale;
pub use sphere::{SphereCells, sphere_chi_square};
pub use welch::{Welch, student_quantile, welch};
