//! From the reflectance that a surface shows at normal incidence to its refractive index.
//!
//! Fresnel's equations at normal incidence, from vacuum onto `n + i k`, give
//! `R = ((n − 1)² + k²) / ((n + 1)² + k²)`. One number cannot tell both n and k:
//! - taken as a dielectric (`k = 0`, `n ≥ 1`), `n = (1 + √R) / (1 − √R)` (Glassner, *An Introduction to Ray
//!   Tracing*, ch. 4, eq. 18);
//! - with a known n, `k² = (R (n + 1)² − (n − 1)²) / (1 − R)`.
//!
//! The first is exact for dielectrics and an assumption for metals, where it errs off normal incidence.
//! It is also sensitive: `dn/dR = 1 / (√R (1 − √R)²)`, 7.7 for crown glass, so that a reflectance known to
//! 1e-4 leaves the index uncertain by a tenth of that glass's dispersion.

use super::{Sampled, Spectrum};
use crate::units::WavelengthRange;
use std::fmt;

/// Why a reflectance has no index.
#[derive(Clone, Debug, PartialEq)]
pub enum ReflectanceError {
    /// A reflectance lies in [0, 1); at 1 the index would be infinite. `nm` is absent for a single value.
    OutOfRange {
        /// The wavelength, nm; `None` for a constant.
        nm: Option<f64>,
        /// The reflectance.
        reflectance: f64,
    },
    /// A given index is positive and finite.
    BadIndex {
        /// The wavelength, nm; `None` for a constant.
        nm: Option<f64>,
        /// The index.
        n: f64,
    },
    /// No k explains so small a reflectance: a surface with this n reflects at least `least`.
    BelowIndex {
        /// The wavelength, nm; `None` for a constant.
        nm: Option<f64>,
        /// The reflectance.
        reflectance: f64,
        /// The index n that is assumed.
        n: f64,
        /// The least reflectance that this index has.
        least: f64,
    },
}

impl fmt::Display for ReflectanceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let nm = match self {
            Self::OutOfRange { nm, reflectance } => {
                write!(
                    f,
                    "expected a normal-incidence reflectance of at least 0 and below 1, found {reflectance}"
                )?;
                nm
            }
            Self::BadIndex { nm, n } => {
                write!(f, "expected a positive refractive index, found {n}")?;
                nm
            }
            Self::BelowIndex { nm, reflectance, n, least } => {
                write!(
                    f,
                    "a surface of index {n} reflects at least {least}, found a reflectance of {reflectance}"
                )?;
                nm
            }
        };
        nm.map_or(Ok(()), |nm| write!(f, " at {nm} nm"))
    }
}

impl std::error::Error for ReflectanceError {}

impl ReflectanceError {
    fn at(self, place: f64) -> Self {
        let nm = Some(place);
        match self {
            Self::OutOfRange { reflectance, .. } => Self::OutOfRange { nm, reflectance },
            Self::BadIndex { n, .. } => Self::BadIndex { nm, n },
            Self::BelowIndex { reflectance, n, least, .. } => Self::BelowIndex { nm, reflectance, n, least },
        }
    }
}

/// Reflectance at normal incidence, from vacuum, of a surface with complex index `n + i k`.
pub fn reflectance_of_index(n: f64, k: f64) -> f64 {
    ((n - 1.0) * (n - 1.0) + k * k) / ((n + 1.0) * (n + 1.0) + k * k)
}

/// Index (n ≥ 1, k = 0) of the dielectric that reflects `reflectance` at normal incidence.
///
/// # Errors
/// A reflectance outside [0, 1).
pub fn index_of_reflectance(reflectance: f64) -> Result<f64, ReflectanceError> {
    match (0.0..1.0).contains(&reflectance) {
        true => Ok(dielectric_index(reflectance)),
        false => Err(ReflectanceError::OutOfRange { nm: None, reflectance }),
    }
}

/// `(1 + √R) / (1 − √R)`, written with `1 − √R = (1 − R) / (1 + √R)`: exact to a few units in the last place
/// as R → 1, where `1 − √R` would cancel.
pub(crate) fn dielectric_index(reflectance: f64) -> f64 {
    let above = 1.0 + reflectance.sqrt();
    above * above / (1.0 - reflectance)
}

/// Extinction coefficient k of the surface that has index `n` and reflects `reflectance` at normal incidence.
///
/// # Errors
/// A reflectance outside [0, 1) or below what a surface of this index reflects without any extinction
/// (beyond rounding), an index that is not positive.
pub fn extinction_of_reflectance(reflectance: f64, n: f64) -> Result<f64, ReflectanceError> {
    if !(0.0..1.0).contains(&reflectance) {
        return Err(ReflectanceError::OutOfRange { nm: None, reflectance });
    }
    if !(n > 0.0 && n.is_finite()) {
        return Err(ReflectanceError::BadIndex { nm: None, n });
    }
    let least = reflectance_of_index(n, 0.0);
    if reflectance < least * (1.0 - 1e-12) {
        return Err(ReflectanceError::BelowIndex { nm: None, reflectance, n, least });
    }
    Ok(extinction(reflectance, n))
}

/// `√((R (n + 1)² − (n − 1)²) / (1 − R))` with the difference of squares factored, which cancels less; zero
/// where rounding makes it negative.
pub(crate) fn extinction(reflectance: f64, n: f64) -> f64 {
    let (root, gap) = (reflectance.sqrt() * (n + 1.0), (n - 1.0).abs());
    (((root - gap) * (root + gap)).max(0.0) / (1.0 - reflectance)).sqrt()
}

/// Reflectance of one face of a polished, clear slab from that of the whole slab, whose back face reflects
/// too: `R_slab = 2 F / (1 + F)`, so `F = R_slab / (2 − R_slab)`. Maps [0, 1] onto itself.
pub fn front_face_of_slab(slab: f64) -> f64 {
    slab / (2.0 - slab)
}

/// The optical constants of a surface known by its reflectance at normal incidence.
///
/// Holds the measurement and converts at each look-up, so that it is exact for the measurement's own
/// interpolation. (A converted table would not be: n changes faster than R as R → 1.)
#[derive(Clone, Debug, PartialEq)]
pub struct NormalReflectance {
    reflectance: Spectrum,
    index: Option<Spectrum>,
    slab: bool,
}

impl NormalReflectance {
    /// A dielectric: k = 0 and n from the reflectance, which must lie in [0, 1) all over `range`.
    ///
    /// # Errors
    /// The first wavelength at which it does not.
    pub fn dielectric(reflectance: Spectrum, range: WavelengthRange) -> Result<Self, ReflectanceError> {
        Self { reflectance, index: None, slab: false }.checked(range)
    }

    /// A metal of known index n(λ): k from the reflectance.
    ///
    /// # Errors
    /// The first wavelength of `range` at which no k gives that reflectance.
    pub fn conductor(
        reflectance: Spectrum,
        n: Spectrum,
        range: WavelengthRange,
    ) -> Result<Self, ReflectanceError> {
        Self { reflectance, index: Some(n), slab: false }.checked(range)
    }

    /// A dielectric whose reflectance was measured on a polished, clear slab, and so contains its back face
    /// (see [`front_face_of_slab`]).
    ///
    /// # Errors
    /// As [`NormalReflectance::dielectric`].
    pub fn slab(reflectance: Spectrum, range: WavelengthRange) -> Result<Self, ReflectanceError> {
        Self { reflectance, index: None, slab: true }.checked(range)
    }

    /// The spectra that n and k follow from.
    pub fn measured(&self) -> Vec<&Spectrum> {
        std::iter::once(&self.reflectance).chain(&self.index).collect()
    }

    /// n and k at one wavelength (nm).
    pub fn at(&self, nm: f64) -> (f64, f64) {
        let reflectance = self.front_face(self.reflectance.at(nm));
        match &self.index {
            None => (dielectric_index(reflectance), 0.0),
            Some(index) => {
                let n = index.at(nm);
                (n, extinction(reflectance, n))
            }
        }
    }

    /// n and k at the wavelengths (nm) of one path.
    #[inline]
    pub fn sample<const C: usize>(&self, nm: &[f64; C]) -> (Sampled<C>, Sampled<C>) {
        let reflectance = self.reflectance.sample(nm).map(|value| self.front_face(value));
        match &self.index {
            None => (reflectance.map(dielectric_index), Sampled::ZERO),
            Some(index) => {
                let n = index.sample(nm);
                (n, reflectance.zip(n, extinction))
            }
        }
    }

    fn front_face(&self, reflectance: f64) -> f64 {
        if self.slab { front_face_of_slab(reflectance) } else { reflectance }
    }

    /// Looks at every node of both spectra and at every nanometre between.
    fn checked(self, range: WavelengthRange) -> Result<Self, ReflectanceError> {
        let mut places: Vec<f64> =
            (0..).map(|i| range.min + f64::from(i)).take_while(|&nm| nm < range.max).collect();
        places.push(range.max);
        places.extend(self.reflectance.nodes());
        places.extend(self.index.iter().flat_map(Spectrum::nodes));
        places.retain(|&nm| range.contains(nm));
        places.sort_by(f64::total_cmp);
        for nm in places {
            let reflectance = self.reflectance.at(nm);
            let checked = match &self.index {
                None => index_of_reflectance(reflectance),
                Some(index) => extinction_of_reflectance(reflectance, index.at(nm)),
            };
            checked.map_err(|error| error.at(nm))?;
        }
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::Extrapolation;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    /// n → R → n and back: exact to rounding times the conditioning `dn/dR · R / n = √R / (1 − R)`.
    #[test]
    fn index_survives_the_round_trip() {
        for step in 0..=10_000 {
            let n = 1.0003 + 1.4997 * f64::from(step) / 10_000.0;
            let back = index_of_reflectance(reflectance_of_index(n, 0.0)).unwrap();
            assert!((back / n - 1.0).abs() < 1e-12, "{n}: {back}");
        }
    }

    /// For reflectances that are squares of dyadic numbers √R is exact, and n is a ratio of two integers.
    #[test]
    fn index_has_full_precision_up_to_mirrors() {
        let scale = f64::from(1 << 20);
        for root in (0..(1 << 20)).step_by(37) {
            let root = f64::from(root);
            let exact = (scale + root) / (scale - root);
            let found = index_of_reflectance((root / scale) * (root / scale)).unwrap();
            assert!((found / exact - 1.0).abs() < 1e-15 * 4.0, "√R = {root}/2²⁰: {found}, {exact}");
        }
        // 0.9999 is not exact in binary; its relative error is amplified by 1/(1 − R) only.
        let found = index_of_reflectance(0.9999).unwrap();
        assert!((found / 39_997.999_974_998_44 - 1.0).abs() < 1e-11, "{found}");
    }

    /// Glassner's table: from reflectance to index.
    #[test]
    fn known_pairs() {
        let pairs = [(0.02, 1.3294), (0.04, 1.5), (0.1, 1.9250), (0.25, 3.0), (0.5, 5.8284), (0.9, 37.974)];
        for (reflectance, n) in pairs {
            let found = index_of_reflectance(reflectance).unwrap();
            assert!((found / n - 1.0).abs() < 4e-5, "{reflectance}: {found}");
        }
        let pairs = [(1.33, 0.020059), (1.46, 0.034966), (1.52, 0.042580), (1.66, 0.061564), (2.4, 0.169550)];
        for (n, reflectance) in pairs {
            assert!((reflectance_of_index(n, 0.0) - reflectance).abs() < 5e-7);
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        use ReflectanceError::*;
        for reflectance in [-1e-9, 1.0, 1.5, f64::NAN] {
            assert!(matches!(index_of_reflectance(reflectance), Err(OutOfRange { .. })));
            assert!(matches!(extinction_of_reflectance(reflectance, 0.5), Err(OutOfRange { .. })));
        }
        assert!(matches!(extinction_of_reflectance(0.5, 0.0), Err(BadIndex { .. })));
        assert!(matches!(extinction_of_reflectance(0.03, 1.5), Err(BelowIndex { .. })));
        assert_eq!(extinction_of_reflectance(0.04, 1.5).unwrap(), 0.0);
    }

    /// n, k → R → k: the error of k² is rounding of R (n + 1)² over 1 − R.
    #[test]
    fn extinction_survives_the_round_trip() {
        let mut random = Pcg64Mcg::seed_from_u64(1);
        for _ in 0..1000 {
            let (n, k) = (random.random_range(0.05..5.0), random.random_range(0.0..15.0));
            let reflectance = reflectance_of_index(n, k);
            let back = extinction_of_reflectance(reflectance, n).unwrap();
            let rounding = 16.0 * f64::EPSILON * reflectance * (n + 1.0) * (n + 1.0) / (1.0 - reflectance);
            let amplified = rounding * (1.0 + (1.0 + k * k) / (1.0 - reflectance));
            assert!((back * back - k * k).abs() <= amplified, "{n}: {back} {k}");
        }
    }

    #[test]
    fn front_face_and_slab_are_inverse() {
        let mut random = Pcg64Mcg::seed_from_u64(2);
        for _ in 0..1000 {
            let face: f64 = random.random();
            let slab = 2.0 * face / (1.0 + face);
            assert!((front_face_of_slab(slab) - face).abs() < 1e-15 * 4.0, "{face}");
        }
    }

    /// A slab of N-BK7-like glass: both faces together reflect 8.2 %, one face gives back the index.
    #[test]
    fn the_back_face_can_be_taken_away() {
        let face = reflectance_of_index(1.5168, 0.0);
        let slab = Spectrum::Constant(2.0 * face / (1.0 + face));
        let glass = NormalReflectance::slab(slab, WavelengthRange::VISIBLE).unwrap();
        assert!((glass.at(550.0).0 - 1.5168).abs() < 1e-14);
        assert_eq!(glass.sample(&[550.0]).0.hero(), glass.at(550.0).0);
    }

    #[test]
    fn a_spectrum_is_checked_everywhere() {
        let bad = Spectrum::regular(360.0, 830.0, &[0.5, 1.2, 0.5], Extrapolation::Zero).unwrap();
        let error = NormalReflectance::dielectric(bad, WavelengthRange::VISIBLE).unwrap_err();
        assert!(
            matches!(error, ReflectanceError::OutOfRange { nm: Some(nm), .. } if nm > 500.0 && nm < 530.0)
        );
        // R and n are possible at both nodes, but not halfway between.
        let reflectance = Spectrum::regular(360.0, 830.0, &[0.9, 0.05], Extrapolation::Zero).unwrap();
        let n = Spectrum::regular(360.0, 830.0, &[15.0, 1.0], Extrapolation::Zero).unwrap();
        let error = NormalReflectance::conductor(reflectance, n, WavelengthRange::VISIBLE).unwrap_err();
        assert!(matches!(error, ReflectanceError::BelowIndex { .. }), "{error}");
    }

    #[test]
    fn lanes_agree_with_single_values() {
        let reflectance = Spectrum::regular(360.0, 830.0, &[0.4, 0.95, 0.9], Extrapolation::Hold).unwrap();
        let n = Spectrum::regular(360.0, 830.0, &[1.5, 0.4, 0.1], Extrapolation::Hold).unwrap();
        let range = WavelengthRange::VISIBLE;
        for surface in [
            NormalReflectance::dielectric(reflectance.clone(), range).unwrap(),
            NormalReflectance::conductor(reflectance, n, range).unwrap(),
        ] {
            let nm = [360.0, 444.4, 555.5, 830.0];
            let (n, k) = surface.sample(&nm);
            for lane in 0..4 {
                assert_eq!((n[lane], k[lane]), surface.at(nm[lane]));
                let reflected = reflectance_of_index(n[lane], k[lane]);
                assert!((reflected - surface.reflectance.at(nm[lane])).abs() < 1e-13);
            }
        }
    }

    /// The error of the index that a noisy reflectance gives stays within the linear estimate
    /// `dn = dR / (√R (1 − √R)²)`.
    #[test]
    fn conditioning_is_as_documented() {
        let n: f64 = 1.5168;
        let reflectance = reflectance_of_index(n, 0.0);
        let root = reflectance.sqrt();
        let slope = 1.0 / (root * (1.0 - root) * (1.0 - root));
        assert!((slope - 7.7).abs() < 0.1, "{slope}");
        for noise in [-1e-5, 1e-5] {
            let error = index_of_reflectance(reflectance + noise).unwrap() - n;
            assert!((error / (slope * noise) - 1.0).abs() < 1e-3);
        }
    }
}
