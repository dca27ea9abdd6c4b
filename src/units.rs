//! Physical constants and the units that the program computes in.
//!
//! Wavelengths are vacuum wavelengths in nanometres, spectral radiance is in W·m⁻²·sr⁻¹·nm⁻¹,
//! absorption coefficients are per scene unit of length (a metre unless the scene says otherwise).

/// Planck constant, J·s. Exact in the SI since 2019 (BIPM, SI Brochure, 9th edition).
pub const PLANCK: f64 = 6.626_070_15e-34;

/// Speed of light in vacuum, m·s⁻¹. Exact in the SI (BIPM, SI Brochure, 9th edition).
pub const SPEED_OF_LIGHT: f64 = 299_792_458.0;

/// Photons of a wavelength (nm) in a joule: λ / (h c). So many photons a second make up a watt.
pub fn photons_per_joule(nm: f64) -> f64 {
    nm * 1e-9 / (PLANCK * SPEED_OF_LIGHT)
}

/// Boltzmann constant, J·K⁻¹. Exact in the SI since 2019 (BIPM, SI Brochure, 9th edition).
pub const BOLTZMANN: f64 = 1.380_649e-23;

/// Fraunhofer F line (hydrogen), nm: one of the three lines that define the Abbe number.
pub const FRAUNHOFER_F: f64 = 486.1327;

/// Fraunhofer d line (helium), nm: the wavelength at which catalogues state an index.
pub const FRAUNHOFER_D: f64 = 587.5618;

/// Fraunhofer C line (hydrogen), nm.
pub const FRAUNHOFER_C: f64 = 656.2725;

/// An interval of vacuum wavelengths, nm.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct WavelengthRange {
    /// Shortest wavelength, nm. Above 0.
    pub min: f64,
    /// Longest wavelength, nm. Above `min`.
    pub max: f64,
}

impl WavelengthRange {
    /// 360–830 nm: the domain of the CIE 1931 observer, and Mitsuba's range.
    pub const VISIBLE: Self = Self { min: 360.0, max: 830.0 };

    /// All that can be simulated: from soft X-rays to the far infrared. It bounds what is tabulated in steps.
    pub const WIDEST: Self = Self { min: 1.0, max: 1e5 };

    /// What two ranges have in common; empty (`max` below `min`) where that is nothing.
    pub fn common(self, other: Self) -> Self {
        Self { min: self.min.max(other.min), max: self.max.min(other.max) }
    }

    /// Its extent, nm.
    pub fn width(self) -> f64 {
        self.max - self.min
    }

    /// Whether a wavelength lies in it; both ends do.
    pub fn contains(self, nm: f64) -> bool {
        (self.min..=self.max).contains(&nm)
    }
}
