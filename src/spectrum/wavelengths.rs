//! The wavelengths of a path and how they are chosen.
//!
//! A path is decided by its hero's wavelength. Its companions lie at equal steps of the cumulated density
//! around the hero, so any of them could have been the hero of the same set: their contributions are weighed
//! by the balance heuristic over the whole path's densities (Wilkie et al., "Hero Wavelength Spectral
//! Sampling", EGSR 2014). What a scene does not emit is not sampled.

use super::{Sampled, Spectrum};
use crate::sampling::PiecewiseConstant;
use crate::units::WavelengthRange;
use std::collections::HashMap;

/// The wavelengths that one path carries; the hero first.
#[derive(Clone, Copy, Debug)]
pub struct Wavelengths<const C: usize> {
    /// Wavelengths, nm, the hero's first.
    pub nm: [f64; C],
    /// Density, per nm, with which each could have been chosen as the hero.
    pub density: Sampled<C>,
}

/// A light's part in the density over wavelength.
#[derive(Clone, Copy, Debug)]
pub struct Emission<'a> {
    /// What is emitted, by wavelength.
    pub spectrum: &'a Spectrum,
    /// What the light weighs against others, beside its spectrum.
    pub weight: f64,
}

/// A channel of the sensor in the density over wavelength.
#[derive(Clone, Copy, Debug)]
pub struct Response<'a> {
    /// The sensor's response, by wavelength.
    pub spectrum: &'a Spectrum,
    /// The channel's weight, up to a factor.
    pub weight: f64,
}

/// The density over wavelength that the paths of a render share.
#[derive(Clone, Debug)]
pub struct WavelengthDensity {
    table: PiecewiseConstant,
}

/// Step of the density's table where no emission spectrum asks for a finer one, nm.
const STEP: f64 = 1.0;

/// Share of the density that follows the emission alone, whatever the sensor sees of it: it bounds the weight
/// of a wavelength that the sensor hardly sees but a spectral output asks for.
const DEFENSIVE: f64 = 0.1;

impl WavelengthDensity {
    /// Each channel of the sensor has its fraction of the density, which follows its response × the emission
    /// of the lights: what little blue a candle has matters for the blue it is seen with. Of the emission,
    /// each light weighs half by its fraction of the whole and half as much as any other, so that a weak
    /// light of another colour than the rest is still seen. Zero only where no light emits.
    ///
    /// Without any emission within the range, or with an infinite one, all wavelengths are alike.
    pub fn new(range: WavelengthRange, sensor: &[Response], lights: &[Emission]) -> Self {
        let spectra = lights.iter().map(|l| l.spectrum).chain(sensor.iter().map(|channel| channel.spectrum));
        let edges = edges(range, nodes(spectra));
        // The trapezoid rule on the halves of each bin: no node lies within a bin.
        let integrate = |spectrum: &Spectrum| -> Vec<f64> {
            let part = |a: f64, b: f64| {
                // A table may jump at a node, so never look at one itself.
                let inside = 1e-9 * (b - a);
                let [low, middle, high] = [a + inside, 0.5 * (a + b), b - inside].map(|nm| spectrum.at(nm));
                (low + 2.0 * middle + high) * 0.25 * (b - a)
            };
            edges.windows(2).map(|edge| part(edge[0], edge[1])).collect()
        };
        let mut emitted = vec![0.0; edges.len() - 1];
        // There may be very many lights, and few that differ in their spectra.
        let mut known = HashMap::new();
        let mut each = |take: &mut dyn FnMut(&[f64], f64)| {
            for Emission { spectrum, weight } in lights {
                match spectrum.identity().filter(|key| known.len() < MOST_KNOWN || known.contains_key(key)) {
                    Some(key) => take(known.entry(key).or_insert_with(|| integrate(spectrum)), *weight),
                    None => take(&integrate(spectrum), *weight),
                }
            }
        };
        let mut total = 0.0;
        each(&mut |integrals, weight| total += weight * integrals.iter().sum::<f64>());
        each(&mut |integrals, weight| {
            let power = weight * integrals.iter().sum::<f64>();
            if power > 0.0 {
                let factor = weight * (0.5 / total + 0.5 / (power * lights.len() as f64));
                for (sum, value) in emitted.iter_mut().zip(integrals) {
                    *sum += factor * value;
                }
            }
        });
        // Lights that are stronger than numbers go say nothing either.
        let widths: Vec<f64> = edges.windows(2).map(|edge| edge[1] - edge[0]).collect();
        if !(total > 0.0 && total.is_finite()) {
            emitted.clone_from(&widths);
        }
        let middles: Vec<f64> = edges.windows(2).map(|edge| 0.5 * (edge[0] + edge[1])).collect();
        let whole: f64 = sensor.iter().map(|channel| channel.weight).sum();
        let defence = DEFENSIVE / (1.0 - DEFENSIVE) * if whole > 0.0 { whole } else { 1.0 };
        let defence = Response { spectrum: &Spectrum::ONE, weight: defence };
        let mut integrals = vec![0.0; emitted.len()];
        for Response { spectrum, weight } in sensor.iter().copied().chain([defence]) {
            let seen: Vec<f64> =
                middles.iter().zip(&emitted).map(|(&nm, e)| e * spectrum.at(nm).max(0.0)).collect();
            let sum: f64 = seen.iter().sum();
            if sum > 0.0 {
                integrals.iter_mut().zip(&seen).for_each(|(integral, seen)| *integral += weight * seen / sum);
            }
        }
        let table = PiecewiseConstant::new(edges.clone(), &integrals)
            .or_else(|| PiecewiseConstant::new(edges, &widths))
            .expect("edges ascend, so that their distances make a density");
        Self { table }
    }

    /// The hero at the fraction `u` of the density and its companions at equal steps from it.
    pub fn sample<const C: usize>(&self, u: f64) -> Wavelengths<C> {
        let (mut nm, mut density) = ([0.0; C], Sampled::ZERO);
        for lane in 0..C {
            let turned = (u + lane as f64 / C as f64).fract();
            (nm[lane], density[lane]) = self.table.sample(turned);
        }
        Wavelengths { nm, density }
    }

    /// Per nm.
    pub fn density(&self, nm: f64) -> f64 {
        self.table.density(nm)
    }
}

/// Number of tables whose integrals are kept for other lights that share them.
const MOST_KNOWN: usize = 1024;

/// The nodes of all, without those that only repeat the ones before.
fn nodes<'a>(spectra: impl Iterator<Item = &'a Spectrum>) -> impl Iterator<Item = f64> {
    let mut last: &[f64] = &[];
    let mut fresh = Vec::new();
    for table in spectra.filter_map(Spectrum::table) {
        if table.nodes() != last {
            last = table.nodes();
            fresh.extend_from_slice(last);
        }
    }
    fresh.into_iter()
}

/// Every [`STEP`] over the range, and every node that lies inside it and not next to another.
fn edges(range: WavelengthRange, nodes: impl Iterator<Item = f64>) -> Vec<f64> {
    let steps = (range.width() / STEP).ceil().max(1.0) as usize;
    let mut edges: Vec<f64> =
        (0..=steps).map(|i| range.min + range.width() * i as f64 / steps as f64).collect();
    // Where the range itself is narrow, less: its own ends always stay.
    let apart = f64::min(1e-6, 1e-3 * range.width() / steps as f64);
    edges.extend(nodes.filter(|&nm| nm - range.min >= apart && range.max - nm >= apart));
    edges.sort_by(f64::total_cmp);
    edges.dedup_by(|b, a| *b - *a < apart);
    edges
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::Extrapolation;

    const RANGE: WavelengthRange = WavelengthRange::VISIBLE;

    const FLAT: Response = Response { spectrum: &Spectrum::ONE, weight: 1.0 };

    fn line() -> Spectrum {
        Spectrum::irregular(&[588.9, 589.1], &[5.0, 5.0], Extrapolation::Zero).unwrap()
    }

    fn one(spectrum: &Spectrum) -> Emission<'_> {
        Emission { spectrum, weight: 1.0 }
    }

    #[test]
    fn a_range_may_be_as_narrow_as_numbers_are() {
        let mut range = WavelengthRange { min: 550.0, max: 550.000001 };
        let node =
            Spectrum::irregular(&[540.0, 550.0000005, 560.0], &[1.0, 2.0, 1.0], Extrapolation::Zero).unwrap();
        for max in [550.000001, 550f64.next_up().next_up(), 550f64.next_up()] {
            range.max = max;
            let density = WavelengthDensity::new(range, &[FLAT], &[one(&node)]);
            for path in [1e-9, 0.25, 0.5, 1.0 - 1e-9].map(|u| density.sample::<4>(u)) {
                assert!(path.nm.iter().all(|nm| (range.min..=range.max).contains(nm)), "{:?}", path.nm);
                assert!(path.density.0.iter().all(|p| (p * range.width() - 1.0).abs() < 1e-6));
            }
        }
    }

    #[test]
    fn what_is_not_emitted_is_not_sampled() {
        let density = WavelengthDensity::new(RANGE, &[FLAT], &[one(&line())]);
        for i in 0..1000 {
            let path = density.sample::<8>((f64::from(i) + 0.5) / 1000.0);
            for (nm, p) in path.nm.into_iter().zip(path.density.0) {
                assert!((588.9..=589.1).contains(&nm), "{nm}");
                assert!((p - 5.0).abs() < 1e-3 * p, "{p}");
            }
        }
        assert_eq!(density.density(560.0), 0.0);
    }

    #[test]
    fn the_density_integrates_to_one_and_estimates_are_unbiased() {
        let tungsten = Spectrum::blackbody(2856.0).unwrap();
        let sensor =
            Spectrum::irregular(&[450.0, 550.0, 700.0], &[0.0, 1.0, 0.0], Extrapolation::Zero).unwrap();
        let density = WavelengthDensity::new(
            RANGE,
            &[Response { spectrum: &sensor, weight: 1.0 }],
            &[one(&tungsten), one(&line())],
        );
        let n = 100_000;
        let mut estimate = 0.0;
        for i in 0..n {
            let path = density.sample::<4>((f64::from(i) + 0.5) / f64::from(n));
            estimate +=
                path.nm.map(|nm| tungsten.at(nm)).iter().zip(path.density.0).map(|(f, p)| f / p).sum::<f64>()
                    / 4.0;
        }
        let step = 0.01;
        let exact: f64 = (0..47_000).map(|i| tungsten.at(360.0 + step * (f64::from(i) + 0.5)) * step).sum();
        assert!((estimate / f64::from(n) / exact - 1.0).abs() < 1e-4, "{} {exact}", estimate / f64::from(n));
    }

    #[test]
    fn companions_are_heroes_of_the_same_set() {
        let density = WavelengthDensity::new(RANGE, &[FLAT], &[one(&Spectrum::blackbody(4000.0).unwrap())]);
        let one = density.sample::<4>(0.1);
        let other = density.sample::<4>(0.35);
        assert!((one.nm[1] - other.nm[0]).abs() < 1e-9);
        assert!((one.nm[0] - other.nm[3]).abs() < 1e-9);
    }

    #[test]
    fn darkness_has_a_density_too() {
        let density = WavelengthDensity::new(RANGE, &[FLAT], &[one(&Spectrum::ZERO)]);
        assert!((density.density(500.0) - 1.0 / 470.0).abs() < 1e-12);
    }
}
