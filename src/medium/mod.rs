//! Media: what fills space, and which of them a ray is in.

mod grid;
mod stack;
mod substance;
#[cfg(test)]
mod tests;

pub use grid::GridExtinction;
pub use stack::{Body, Entered, Filling, Media, MediumStack, Refraction, refracting};
pub use substance::{Extinction, FreeFlight, Medium, Scattering};
