//! A phase function that is tabulated over the angle and the wavelength.

use super::table::Piecewise;
use crate::sampling::decide;
use crate::units::WavelengthRange;

/// Densities over the cosine at equal steps of the wavelength: linear between the cosines, and between the
/// wavelengths, of which each has integral 1.
#[derive(Clone, Debug)]
pub struct SpectralTable {
    range: WavelengthRange,
    /// Ascending, from −1 to 1.
    cosines: Vec<f64>,
    rows: Vec<Piecewise>,
}

impl SpectralTable {
    /// From values at cosines, of each row up to a factor. `None` unless each row is a density.
    pub fn new(range: WavelengthRange, cosines: &[f64], rows: Vec<Vec<f64>>) -> Option<Self> {
        let rows = rows.into_iter().map(|row| Piecewise::new(cosines, row)).collect::<Option<Vec<_>>>()?;
        (!rows.is_empty()).then(|| Self { range, cosines: cosines.to_vec(), rows })
    }

    /// The row below a wavelength, and the fraction of the next one.
    fn row(&self, nm: f64) -> (usize, f64) {
        let last = self.rows.len() - 1;
        if last == 0 {
            return (0, 0.0);
        }
        let place = ((nm - self.range.min) / self.range.width()).clamp(0.0, 1.0) * last as f64;
        let index = (place as usize).min(last - 1);
        (index, place - index as f64)
    }

    /// Densities per unit of the cosine at some wavelengths.
    pub fn density<const C: usize>(&self, cos: f64, nm: &[f64; C]) -> [f64; C] {
        let above = self.cosines.partition_point(|&cosine| cosine <= cos);
        let index = above.clamp(1, self.cosines.len() - 1) - 1;
        let [low, high] = [self.cosines[index], self.cosines[index + 1]];
        let fraction = ((cos - low) / (high - low)).clamp(0.0, 1.0);
        nm.map(|nm| {
            let (row, next) = self.row(nm);
            let first = self.rows[row].between(index, fraction);
            if next == 0.0 {
                first
            } else {
                first * (1.0 - next) + self.rows[row + 1].between(index, fraction) * next
            }
        })
    }

    /// A cosine for a wavelength by a uniform number, and one that chooses between two rows.
    pub fn sample(&self, nm: f64, u: f64, mut choice: f64) -> f64 {
        let (row, next) = self.row(nm);
        let row = if next > 0.0 && decide(&mut choice, next) { row + 1 } else { row };
        self.rows[row].sample(&self.cosines, u)
    }
}
