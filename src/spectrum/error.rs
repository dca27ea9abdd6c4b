//! What can be wrong with a function of wavelength.

use std::fmt;

/// Why a spectrum could not be made. Wavelengths are in nm; `index` counts from 0.
#[derive(Clone, Debug, PartialEq)]
pub enum SpectrumError {
    /// A table needs two nodes to say anything about what lies between.
    TooFewNodes {
        /// How many there are.
        found: usize,
    },
    /// Every wavelength needs one value.
    LengthsDiffer {
        /// Number of wavelengths.
        wavelengths: usize,
        /// Number of values.
        values: usize,
    },
    /// A wavelength is a positive, finite number of nanometres.
    BadWavelength {
        /// Which node, counted from 0.
        index: usize,
        /// The wavelength, nm.
        nm: f64,
    },
    /// Wavelengths increase strictly.
    NotIncreasing {
        /// Which node, counted from 0.
        index: usize,
        /// The wavelength before it, nm.
        previous_nm: f64,
        /// Its wavelength, nm.
        nm: f64,
    },
    /// A value is a finite number.
    BadValue {
        /// Which node, counted from 0.
        index: usize,
        /// Its wavelength, nm.
        nm: f64,
        /// The value.
        value: f64,
    },
    /// A temperature is a finite number of kelvin, at least 0.
    BadTemperature {
        /// The temperature, K.
        kelvin: f64,
    },
    /// CIE daylight is defined for correlated colour temperatures from 4000 to 25000 K.
    NotDaylight {
        /// The temperature, K.
        kelvin: f64,
    },
}

impl fmt::Display for SpectrumError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::TooFewNodes { found } => {
                write!(f, "a tabulated spectrum needs at least 2 wavelengths, found {found}")
            }
            Self::LengthsDiffer { wavelengths, values } => {
                write!(
                    f,
                    "expected one value per wavelength, found {wavelengths} wavelengths and {values} values"
                )
            }
            Self::BadWavelength { index, nm } => {
                write!(f, "expected a positive wavelength in nm, found {nm} at place {}", index + 1)
            }
            Self::NotIncreasing { index, previous_nm, nm } => write!(
                f,
                "expected strictly increasing wavelengths, found {nm} nm after {previous_nm} nm at place {}",
                index + 1
            ),
            Self::BadValue { index, nm, value } => {
                write!(f, "expected a finite value, found {value} at {nm} nm (place {})", index + 1)
            }
            Self::BadTemperature { kelvin } => {
                write!(f, "expected a temperature of at least 0 K, found {kelvin}")
            }
            Self::NotDaylight { kelvin } => {
                write!(f, "expected a daylight temperature from 4000 to 25000 K, found {kelvin}")
            }
        }
    }
}

impl std::error::Error for SpectrumError {}

#[cfg(test)]
mod tests {
    use super::SpectrumError;

    #[test]
    fn messages_say_what_was_expected_and_where() {
        let error = SpectrumError::NotIncreasing { index: 3, previous_nm: 500.0, nm: 490.5 };
        let text = "expected strictly increasing wavelengths, found 490.5 nm after 500 nm at place 4";
        assert_eq!(error.to_string(), text);
    }
}
