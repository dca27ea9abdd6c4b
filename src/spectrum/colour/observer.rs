//! Colour-matching functions, and the integrals that they are made for.

use super::Xyz;
use crate::spectrum::data;
use crate::spectrum::table_file::TableFile;
use crate::spectrum::{Extrapolation, Sampled, Spectrum};
use crate::units::WavelengthRange;
use std::sync::OnceLock;

/// What Mitsuba 3 divides by where it turns spectral radiance into XYZ: the integral of its own (5 nm) table
/// of ȳ, nm.
///
/// `hdrfilm` states `XYZ = ∫ L(λ) (x̄, ȳ, z̄) dλ / MITSUBA_Y_INTEGRAL`. With the 1 nm tables used here a flat
/// radiance of 1 gives Y = 1.001, because `∫ ȳ dλ` is 106.857 nm.
pub const MITSUBA_Y_INTEGRAL: f64 = 106.750_259_399_414_06;

/// A standard observer: three colour-matching functions at 1 nm, linear between, zero outside.
#[derive(Clone, Debug)]
pub struct Observer {
    name: &'static str,
    start: f64,
    end: f64,
    values: Box<[[f64; 3]]>,
}

macro_rules! observers {
    ($($function:ident, $name:literal, $file:literal, $about:literal;)*) => {
        $(
            #[doc = $about]
            pub fn $function() -> &'static Self {
                static OBSERVER: OnceLock<Observer> = OnceLock::new();
                OBSERVER.get_or_init(|| Self::from_table($name, $file))
            }
        )*
    };
}

impl Observer {
    observers! {
        cie1931, "CIE 1931 2°", "cie/cmf_cie1931_2deg_1nm",
        "The CIE 1931 standard colorimetric observer (2°), 360–830 nm: the default everywhere.";
        cie1964, "CIE 1964 10°", "cie/cmf_cie1964_10deg_1nm",
        "The CIE 1964 standard colorimetric observer (10°), 360–830 nm.";
        cie2015_2deg, "CIE 2015 2°", "cie/cmf_cie2015_2deg_1nm",
        "The cone-fundamental-based observer of CIE 170-2:2015 for 2°, 390–830 nm.";
        cie2015_10deg, "CIE 2015 10°", "cie/cmf_cie2015_10deg_1nm",
        "The cone-fundamental-based observer of CIE 170-2:2015 for 10°, 390–830 nm.";
    }

    /// The CIE 1931 observer as Mitsuba 3 tabulates it: every 5 nm, linear between. For comparisons with it
    /// to less than 0.1 %; by up to 1.6 % wrong in Z for a narrow line near 545 nm.
    pub fn cie1931_5nm() -> &'static Self {
        static OBSERVER: OnceLock<Observer> = OnceLock::new();
        OBSERVER.get_or_init(|| {
            let fine = Self::cie1931();
            let values = (0..fine.values.len()).map(|i| {
                let (node, rest) = (i / 5 * 5, (i % 5) as f64 / 5.0);
                let next = (node + 5).min(fine.values.len() - 1);
                [0, 1, 2].map(|k| fine.values[node][k] * (1.0 - rest) + fine.values[next][k] * rest)
            });
            Self { name: "CIE 1931 2°, every 5 nm", values: values.collect(), ..fine.clone() }
        })
    }

    fn from_table(name: &'static str, file: &str) -> Self {
        let read = || {
            let table = TableFile::parse(data::text(file))?;
            let column = |name: &str| table.numbers(name);
            Ok::<_, crate::spectrum::table_file::TableError>((
                column("wavelength_nm")?,
                [column("xbar")?, column("ybar")?, column("zbar")?],
            ))
        };
        let (nm, [x, y, z]) = read().expect("the built-in tables are well formed, which a test checks");
        let values = x.iter().zip(&y).zip(&z).map(|((&x, &y), &z)| [x, y, z]).collect();
        Self { name, start: nm[0], end: nm[nm.len() - 1], values }
    }

    /// The name that the command line has for it.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// The wavelengths that the tables cover.
    pub fn domain(&self) -> WavelengthRange {
        WavelengthRange { min: self.start, max: self.end }
    }

    /// x̄, ȳ, z̄ at one wavelength (nm).
    #[inline]
    pub fn at(&self, nm: f64) -> [f64; 3] {
        if !(nm >= self.start && nm <= self.end) {
            return [0.0; 3];
        }
        // The tables have a step of 1 nm (a test holds this against them).
        let place = nm - self.start;
        let cell = (place as i32 as usize).min(self.values.len() - 2);
        let fraction = place - cell as i32 as f64;
        let [a, b] = [self.values[cell], self.values[cell + 1]];
        let lerp = |i: usize| a[i] * (1.0 - fraction) + b[i] * fraction;
        [lerp(0), lerp(1), lerp(2)]
    }

    /// x̄, ȳ, z̄ at the wavelengths (nm) of one path.
    #[inline]
    pub fn sample<const C: usize>(&self, nm: &[f64; C]) -> [Sampled<C>; 3] {
        let lanes = nm.map(|nm| self.at(nm));
        std::array::from_fn(|i| Sampled(lanes.map(|lane| lane[i])))
    }

    /// x̄, ȳ and z̄ as spectra, for building a sampling density over wavelength.
    pub fn spectra(&self) -> [Spectrum; 3] {
        std::array::from_fn(|i| {
            let values: Vec<f64> = self.values.iter().map(|triple| triple[i]).collect();
            Spectrum::regular(self.start, self.end, &values, Extrapolation::Zero)
                .expect("the built-in tables are regular and finite")
        })
    }

    /// `∫ s(λ) (x̄, ȳ, z̄) dλ` over `range`, in the spectrum's unit times nm.
    pub fn xyz_of(&self, spectrum: &Spectrum, range: WavelengthRange) -> Xyz {
        self.xyz_of_product(spectrum, &Spectrum::ONE, range)
    }

    /// `∫ s(λ) r(λ) (x̄, ȳ, z̄) dλ` over `range`.
    ///
    /// Exact, up to rounding, for tables: between neighbouring nodes of the three functions their product is
    /// a cubic, which the two-point Gauss rule integrates exactly. It never looks at a node itself, where a
    /// table may jump.
    pub fn xyz_of_product(&self, spectrum: &Spectrum, factor: &Spectrum, range: WavelengthRange) -> Xyz {
        let (from, to) = (range.min.max(self.start), range.max.min(self.end));
        let mut nodes: Vec<f64> = (0..self.values.len()).map(|i| self.start + i as f64).collect();
        nodes.extend(spectrum.nodes());
        nodes.extend(factor.nodes());
        nodes.extend([from, to]);
        nodes.retain(|nm| (from..=to).contains(nm));
        nodes.sort_by(f64::total_cmp);
        nodes.dedup();
        let mut sum = [0.0; 3];
        for segment in nodes.windows(2) {
            let (middle, half) = (0.5 * (segment[0] + segment[1]), 0.5 * (segment[1] - segment[0]));
            for sign in [-1.0, 1.0] {
                let nm = middle + sign * half / 3f64.sqrt();
                let weight = half * spectrum.at(nm) * factor.at(nm);
                let matching = self.at(nm);
                for i in 0..3 {
                    sum[i] += weight * matching[i];
                }
            }
        }
        sum.into()
    }

    /// Colour of a reflectance under an illuminant, relative: a perfect white reflector has Y = 1.
    pub fn reflected(&self, illuminant: &Spectrum, reflectance: &Spectrum, range: WavelengthRange) -> Xyz {
        self.xyz_of_product(illuminant, reflectance, range) / self.xyz_of(illuminant, range).y
    }

    /// The illuminant's own colour with Y = 1.
    pub fn white(&self, illuminant: &Spectrum, range: WavelengthRange) -> Xyz {
        let white = self.xyz_of(illuminant, range);
        white / white.y
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coarse_table_has_the_nodes_of_the_fine_one_and_lies_above_it_between() {
        let (coarse, fine) = (Observer::cie1931_5nm(), Observer::cie1931());
        assert_eq!(coarse.at(545.0), fine.at(545.0));
        assert_eq!(coarse.at(830.0), fine.at(830.0));
        // Z̄ is convex here, so the chord lies above the curve.
        assert!(coarse.at(547.5)[2] > fine.at(547.5)[2]);
    }

    fn all() -> [&'static Observer; 4] {
        [Observer::cie1931(), Observer::cie1964(), Observer::cie2015_2deg(), Observer::cie2015_10deg()]
    }

    #[test]
    fn tables_have_a_step_of_one_nanometre() {
        for observer in all() {
            assert_eq!(
                observer.values.len() as f64,
                observer.end - observer.start + 1.0,
                "{}",
                observer.name
            );
        }
        for file in data::FILES.iter().map(|(name, _)| *name).filter(|name| name.starts_with("cie/cmf")) {
            let nm = TableFile::parse(data::text(file)).unwrap().numbers("wavelength_nm").unwrap();
            assert!(nm.windows(2).all(|pair| pair[1] - pair[0] == 1.0), "{file}");
        }
    }

    #[test]
    fn three_functions_at_once_agree_with_three_spectra() {
        for observer in all() {
            let spectra = observer.spectra();
            for i in 0..6000 {
                let nm = [340.0 + 0.1 * f64::from(i), 555.55, 360.0, 830.0];
                let sampled = observer.sample(&nm);
                for (lanes, spectrum) in sampled.iter().zip(&spectra) {
                    for lane in 0..4 {
                        assert!(
                            (lanes[lane] - spectrum.at(nm[lane])).abs() < 1e-12,
                            "{} {nm:?}",
                            observer.name
                        );
                    }
                }
            }
        }
    }

    /// Equal energy has the chromaticity (0.33331, 0.33329) (CIE 15:2018), and ȳ peaks at 1 at 555 nm.
    #[test]
    fn equal_energy_is_neutral() {
        let observer = Observer::cie1931();
        let white = observer.white(&Spectrum::ONE, WavelengthRange::VISIBLE);
        let (x, y) = white.chromaticity().unwrap();
        assert!((x - 0.33331).abs() < 5e-6 && (y - 0.33329).abs() < 5e-6, "{x} {y}");
        assert_eq!(observer.at(555.0)[1], 1.0);
    }

    #[test]
    fn flat_radiance_is_one_in_mitsubas_unit() {
        let flat = Observer::cie1931().xyz_of(&Spectrum::ONE, WavelengthRange::VISIBLE) / MITSUBA_Y_INTEGRAL;
        assert!((flat.y - 1.001).abs() < 2e-5, "{flat:?}");
    }

    /// The product of three piecewise linear functions, against a fine midpoint sum.
    #[test]
    fn products_are_integrated_exactly() {
        let light =
            Spectrum::irregular(&[400.3, 500.0, 500.9, 720.0], &[0.2, 1.0, 8.0, 0.1], Extrapolation::Zero)
                .unwrap();
        let paint =
            Spectrum::irregular(&[380.0, 512.34, 690.0], &[0.9, 0.1, 0.7], Extrapolation::Hold).unwrap();
        let range = WavelengthRange { min: 410.7, max: 801.2 };
        let observer = Observer::cie1931();
        let exact: [f64; 3] = observer.xyz_of_product(&light, &paint, range).into();
        let cells = 4_000_000;
        let width = range.width() / f64::from(cells);
        let mut sum = [0.0; 3];
        for cell in 0..cells {
            let nm = range.min + (f64::from(cell) + 0.5) * width;
            let weight = light.at(nm) * paint.at(nm) * width;
            observer.at(nm).iter().zip(&mut sum).for_each(|(value, sum)| *sum += weight * value);
        }
        for (exact, sum) in exact.iter().zip(sum) {
            assert!((exact / sum - 1.0).abs() < 1e-6, "{exact} {sum}");
        }
    }
}
