//! Media: what fills space, and which of them a ray is in.

mod atmosphere;
mod density;
mod emission;
mod grid;
mod stack;
mod substance;
#[cfg(test)]
mod tests;

pub use atmosphere::Exponential;
pub use density::{Density, Diluted};
pub use emission::{Emission, Segment};
pub use grid::GridExtinction;
pub use stack::{Body, Entered, Filling, Media, MediumStack, Refraction, refracting};
pub use substance::{Extinction, FreeFlight, Medium, Scattering};
