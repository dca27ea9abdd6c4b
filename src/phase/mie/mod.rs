//! Scattering by spheres of many sizes: cross-sections and phase function by wavelength.
//!
//! The spheres scatter independently of one another, so their cross-sections add up. What is dense, such as
//! milk with more than some per cent of fat, scatters less than that.

mod sizes;
mod sphere;

pub use sizes::Sizes;
pub use sphere::{Amplitudes, Sphere};

use super::SpectralTable;
use crate::spectrum::{Extrapolation, Spectrum};
use crate::units::WavelengthRange;
use rayon::prelude::*;
use rustfft::num_complex::Complex64;
use std::f64::consts::PI;

/// Spheres of one material in a medium that absorbs nothing.
#[derive(Clone, Debug)]
pub struct Population {
    /// How large the spheres are.
    pub sizes: Sizes,
    /// n and k of the spheres.
    pub index: [Spectrum; 2],
    /// n of the medium around them.
    pub host: Spectrum,
}

/// What a population does to light.
#[derive(Clone, Debug)]
pub struct Optics {
    /// Phase function by wavelength and angle.
    pub phase: SpectralTable,
    /// Extinction and scattering coefficient, µm⁻¹, of as many spheres as fill all of space: those of a
    /// dilution follow by its volume fraction.
    pub extinction: Spectrum,
    /// Scattering coefficient, likewise.
    pub scattering: Spectrum,
}

/// Why scattering by spheres cannot be computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MieError {
    /// The largest spheres have this size parameter.
    TooLarge {
        /// Circumference over the wavelength.
        size: f64,
    },
    /// So many wavelengths inside them is the circumference of some spheres at this wavelength.
    TooDense {
        /// Circumference over the wavelength, times the modulus of the relative index.
        size: f64,
        /// Wavelength, nm.
        nm: f64,
    },
    /// The index of spheres or medium is no positive number at this wavelength, nm, or k is below 0.
    NoIndex {
        /// Wavelength, nm.
        nm: f64,
    },
}

impl std::fmt::Display for MieError {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Self::TooLarge { size } => write!(
                f,
                "the circumference of the largest spheres is {size:.0} wavelengths, more than {LARGEST}"
            ),
            Self::TooDense { size, nm } => write!(
                f,
                "at {nm} nm the circumference of some spheres is {size:.0} wavelengths inside them, more than {LARGEST_INSIDE}"
            ),
            Self::NoIndex { nm } => write!(f, "the spheres or what is around them have no index at {nm} nm"),
        }
    }
}

/// The largest size parameter: a table for larger spheres would take minutes.
pub const LARGEST: f64 = 4000.0;

/// The largest size parameter times the modulus of the relative index: as many steps and numbers as a sphere
/// takes. Of the largest spheres it is an index of 100, far above that of any metal.
const LARGEST_INSIDE: f64 = 100.0 * LARGEST;

/// Steps of the tables over wavelength, nm: phase functions take long, and of many sizes they change slowly.
const PHASE_STEP: f64 = 15.0;
const COEFFICIENT_STEP: f64 = 2.5;

impl Population {
    /// Tables over a range of wavelengths.
    ///
    /// # Errors
    /// Spheres that are too large, and no index.
    pub fn optics(&self, range: WavelengthRange) -> Result<Optics, MieError> {
        let middle = 0.5 * (range.min + range.max);
        let per_radius = |nm: f64| 2e3 * PI * self.host.at(nm) / nm;
        let nodes = self.sizes.nodes(per_radius(middle));
        let largest = nodes.iter().map(|node| node.radius).fold(0.0, f64::max);
        let size = largest * per_radius(range.min);
        if size > LARGEST {
            return Err(MieError::TooLarge { size });
        }
        let fine = steps(range, COEFFICIENT_STEP);
        let coefficients: Vec<[f64; 2]> =
            fine.par_iter().map(|&nm| self.coefficients(&nodes, nm)).collect::<Result<_, _>>()?;
        let table = |of: usize| {
            let values: Vec<f64> = coefficients.iter().map(|pair| pair[of]).collect();
            Spectrum::regular(range.min, range.max, &values, Extrapolation::Hold)
                .map_err(|_| MieError::NoIndex { nm: range.min })
        };
        let cosines = cosines(size);
        let rows = steps(range, PHASE_STEP);
        let rows: Vec<Vec<f64>> =
            rows.par_iter().map(|&nm| self.intensities(&nodes, nm, &cosines)).collect::<Result<_, _>>()?;
        let phase = SpectralTable::new(range, &cosines, rows).ok_or(MieError::NoIndex { nm: range.min })?;
        Ok(Optics { phase, extinction: table(0)?, scattering: table(1)? })
    }

    /// The size parameter of a radius of 1 µm and the relative index.
    fn at(&self, nm: f64) -> Result<(f64, Complex64), MieError> {
        let host = self.host.at(nm);
        let [n, k] = [0, 1].map(|i| self.index[i].at(nm));
        if !(host > 0.0 && n > 0.0 && k >= 0.0 && host.is_finite() && n.is_finite() && k.is_finite()) {
            return Err(MieError::NoIndex { nm });
        }
        Ok((2e3 * PI * host / nm, Complex64::new(n, k) / host))
    }

    /// Extinction and scattering, µm⁻¹, at a volume fraction of 1.
    fn coefficients(&self, nodes: &[sizes::Node], nm: f64) -> Result<[f64; 2], MieError> {
        let (per_radius, index) = self.at(nm)?;
        let mut sum = [0.0; 2];
        for node in nodes {
            let sphere = sphere(node.radius * per_radius, index, nm)?;
            let area = PI * node.radius * node.radius * node.number;
            sum[0] += area * sphere.extinction();
            sum[1] += area * sphere.scattering();
        }
        // Rounding must not make what absorbs nothing scatter more than it takes.
        let [extinction, scattering] = sum.map(|sum| sum / self.sizes.mean_volume());
        let scattering = if index.im == 0.0 { extinction } else { scattering.min(extinction) };
        Ok([extinction, scattering])
    }

    /// What goes by each of the cosines, up to a factor.
    fn intensities(&self, nodes: &[sizes::Node], nm: f64, cosines: &[f64]) -> Result<Vec<f64>, MieError> {
        let (per_radius, index) = self.at(nm)?;
        let mut amplitudes = Amplitudes::new(cosines.to_vec());
        let mut sum = vec![0.0; cosines.len()];
        for node in nodes {
            amplitudes.add(&sphere(node.radius * per_radius, index, nm)?);
            let intensities = amplitudes.intensities();
            sum.iter_mut().zip(intensities).for_each(|(sum, intensity)| *sum += node.number * intensity);
        }
        Ok(sum)
    }
}

/// A sphere of a size parameter and a relative index.
fn sphere(size: f64, index: Complex64, nm: f64) -> Result<Sphere, MieError> {
    let inside = size * index.norm();
    if inside > LARGEST_INSIDE {
        return Err(MieError::TooDense { size: inside, nm });
    }
    Ok(Sphere::new(size, index))
}

/// The ends of about equal steps over a range.
fn steps(range: WavelengthRange, step: f64) -> Vec<f64> {
    let count = (range.width() / step).ceil().max(1.0) as usize;
    (0..=count).map(|i| range.min + range.width() * i as f64 / count as f64).collect()
}

/// Cosines from −1 to 1 at which spheres up to a size parameter are tabulated. The forward peak and the glory
/// are about 1/x wide: near both ends angles are that much closer together.
fn cosines(size: f64) -> Vec<f64> {
    let finest = (0.12 / size).clamp(1e-5, 0.02);
    // The angles at fractions s are π (s − (1 − w) sin(2πs) / 2π): steps of πw/N at the ends.
    const ENDS: f64 = 0.12;
    let count = (PI * ENDS / finest).ceil().clamp(128.0, 4096.0) as usize;
    let angle = |i: usize| {
        let s = i as f64 / count as f64;
        PI * (s - (1.0 - ENDS) * (2.0 * PI * s).sin() / (2.0 * PI))
    };
    let mut cosines: Vec<f64> = (0..=count).rev().map(|i| angle(i).cos()).collect();
    (cosines[0], cosines[count]) = (-1.0, 1.0);
    cosines
}

#[cfg(test)]
mod tests;
