//! Functions of other spectra as tables.

use super::{Extrapolation, Spectrum, SpectrumError};
use crate::units::WavelengthRange;

impl Spectrum {
    /// A function `at` of the spectra `of` as a table over a range, in equal steps of at most `step` nm.
    ///
    /// Where a spectrum has nodes between the steps, or is zero beyond an end that is not, these are nodes of
    /// the table too, and gaps narrower than a step are divided where the function is curved: however narrow
    /// a line is, it has its shape. Spectra whose nodes lie on the steps are looked up on a regular grid.
    ///
    /// # Errors
    /// A range without a width, and values that are not finite.
    pub fn tabulated(
        range: WavelengthRange,
        step: f64,
        of: &[&Self],
        outside: Extrapolation,
        at: impl Fn(f64) -> f64,
    ) -> Result<Self, SpectrumError> {
        let steps = (range.width() / step).ceil().max(1.0);
        let even = |i: f64| range.min + range.width() * i / steps;
        let is_even = |nm: f64| {
            let nearest = even(((nm - range.min) / range.width() * steps).round());
            (nearest - nm).abs() <= 4.0 * f64::EPSILON * range.max
        };
        let mut nodes: Vec<f64> = of.iter().flat_map(|spectrum| spectrum.nodes()).collect();
        nodes.retain(|&nm| range.contains(nm) && !is_even(nm));
        let jumps = of.iter().flat_map(|spectrum| spectrum.jumps());
        nodes.extend(jumps.filter(|jump| jump.iter().all(|&nm| range.contains(nm))).flatten());
        let even = (0..=steps as usize).map(|i| even(i as f64));
        if nodes.is_empty() {
            let values: Vec<f64> = even.map(at).collect();
            return Self::regular(range.min, range.max, &values, outside);
        }
        nodes.extend(even);
        nodes.sort_by(f64::total_cmp);
        nodes.dedup();
        // Rounding makes no step narrow.
        let narrow = 0.999 * range.width() / steps;
        let mut table: Vec<[f64; 2]> = Vec::with_capacity(nodes.len());
        for nm in nodes {
            let divisions = match table.last() {
                Some(before) if nm - before[0] < narrow => MOST_DIVISIONS,
                _ => 0,
            };
            append(&mut table, [nm, at(nm)], divisions, &at);
        }
        let (nodes, values): (Vec<f64>, Vec<f64>) = table.into_iter().map(|[nm, value]| (nm, value)).unzip();
        Self::irregular(&nodes, &values, outside)
    }

    /// Where a table ends at a value that is not zero and is zero beyond: each end and the number next to it.
    fn jumps(&self) -> Vec<[f64; 2]> {
        let Some(table) = self.table().filter(|table| table.outside() == Extrapolation::Zero) else {
            return Vec::new();
        };
        let known = table.domain();
        let ends = [[known.min, known.min.next_down()], [known.max, known.max.next_up()]];
        ends.into_iter().filter(|end| table.at(end[0]) != 0.0).collect()
    }
}

/// How often a gap between two nodes is halved at most.
const MOST_DIVISIONS: u32 = 8;

/// Adds a node, and others before it where the function is not about linear from the last one on.
fn append(table: &mut Vec<[f64; 2]>, to: [f64; 2], divisions: u32, at: &impl Fn(f64) -> f64) {
    /// Difference from the straight line, as a part of the value, that is not worth a node.
    const TOLERANCE: f64 = 1e-3;
    if let Some(&from) = table.last().filter(|_| divisions > 0) {
        let nm = 0.5 * (from[0] + to[0]);
        let value = at(nm);
        let off = (value - 0.5 * (from[1] + to[1])).abs();
        let greatest = from[1].abs().max(value.abs()).max(to[1].abs());
        if off > TOLERANCE * greatest && from[0] < nm && nm < to[0] {
            append(table, [nm, value], divisions - 1, at);
            append(table, to, divisions - 1, at);
            return;
        }
    }
    table.push(to);
}

#[cfg(test)]
mod tests {
    use super::*;
    use Extrapolation::Zero;

    const RANGE: WavelengthRange = WavelengthRange { min: 400.0, max: 700.0 };

    fn irregular(nm: &[f64], values: &[f64]) -> Spectrum {
        Spectrum::irregular(nm, values, Zero).unwrap()
    }

    fn product(a: &Spectrum, b: &Spectrum) -> Spectrum {
        Spectrum::tabulated(RANGE, 1.0, &[a, b], Zero, |nm| a.at(nm) * b.at(nm)).unwrap()
    }

    /// Two lines that overlap between two steps, as one factor rises and the other falls: the integral of
    /// 100 t (1 − t) over 0.4 nm.
    #[test]
    fn narrow_lines_keep_their_shape() {
        let rising = irregular(&[589.2, 589.6, 589.7], &[0.0, 100.0, 0.0]);
        let falling = irregular(&[589.1, 589.2, 589.6], &[0.0, 1.0, 0.0]);
        let found = product(&rising, &falling).integral(RANGE);
        let exact = 100.0 * 0.4 / 6.0;
        assert!((found / exact - 1.0).abs() < 2e-3, "{found}, not {exact}");
    }

    #[test]
    fn ends_of_a_table_are_as_sharp_as_they_were() {
        for [from, to] in [[589.25, 589.75], [589.0, 591.0], [400.0, 700.0]] {
            let band = irregular(&[from, to], &[3.0, 3.0]);
            let found = product(&band, &Spectrum::Constant(2.0));
            let within = [from, to].map(|nm| found.at(nm));
            assert_eq!(within, [6.0, 6.0], "{from} to {to}");
            assert_eq!([from - 1e-9, to + 1e-9].map(|nm| found.at(nm)), [0.0, 0.0], "{from} to {to}");
            assert!((found.integral(RANGE) / (6.0 * (to - from)) - 1.0).abs() < 1e-9, "{from} to {to}");
        }
    }

    #[test]
    fn nodes_on_the_steps_need_no_others() {
        let line = irregular(&[588.0, 589.0, 591.0], &[0.0, 5.0, 0.0]);
        let smooth = Spectrum::blackbody(3000.0).unwrap();
        let found = product(&line, &smooth);
        let values: Vec<f64> = (400..=700).map(f64::from).map(|nm| line.at(nm) * smooth.at(nm)).collect();
        assert_eq!(found, Spectrum::regular(400.0, 700.0, &values, Zero).unwrap());
    }

    /// A sum of linear functions is linear between their nodes.
    #[test]
    fn what_is_linear_is_not_divided() {
        let nm: Vec<f64> = (0..5000).map(|i| 450.003 + 0.02 * f64::from(i)).collect();
        let values: Vec<f64> = (0..5000).map(|i| f64::from(i % 7)).collect();
        let lines = irregular(&nm, &values);
        let sum = Spectrum::tabulated(RANGE, 1.0, &[&lines], Zero, |nm| 2.0 + lines.at(nm)).unwrap();
        let most = nm.len() + 301 + 4;
        assert!(sum.nodes().len() <= most, "{}", sum.nodes().len());
        let exact = 2.0 * RANGE.width() + lines.integral(RANGE);
        assert!((sum.integral(RANGE) / exact - 1.0).abs() < 1e-9);
    }

    #[test]
    fn a_range_without_width_is_refused() {
        let none = WavelengthRange { min: 500.0, max: 500.0 };
        for of in [Spectrum::ONE, irregular(&[499.5, 500.5], &[1.0, 1.0])] {
            assert!(Spectrum::tabulated(none, 1.0, &[&of], Zero, |nm| of.at(nm)).is_err());
        }
    }
}
