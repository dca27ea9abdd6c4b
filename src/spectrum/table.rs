//! Tabulated functions of wavelength: the table as published, and two ways to look it up quickly.
//!
//! Between nodes a table is linear; that is how Mitsuba 3 reads a spectrum and how CIE 15 interpolates its
//! 5 nm illuminants. A look-up structure never changes the function: a grid is used only if every node
//! lies on it.

use super::Sampled;
use super::error::SpectrumError;
use crate::units::WavelengthRange;
use std::sync::Arc;

/// What a table means outside its first and last wavelength.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extrapolation {
    /// Zero: right for emission and sensitivity, and what Mitsuba does with every table.
    Zero,
    /// The value of the nearest end: for measured materials, where zero would be unphysical.
    Hold,
}

/// A table as published: strictly increasing wavelengths (nm) and one finite value at each.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    nodes: Arc<[f64]>,
    values: Arc<[f64]>,
    outside: Extrapolation,
}

impl Table {
    /// # Errors
    /// See [`SpectrumError`]: too few nodes, lengths that differ, wavelengths out of order, numbers that
    /// are not finite.
    pub fn new(nodes: &[f64], values: &[f64], outside: Extrapolation) -> Result<Self, SpectrumError> {
        if nodes.len() != values.len() {
            return Err(SpectrumError::LengthsDiffer { wavelengths: nodes.len(), values: values.len() });
        }
        if nodes.len() < 2 {
            return Err(SpectrumError::TooFewNodes { found: nodes.len() });
        }
        for (index, (&nm, &value)) in nodes.iter().zip(values).enumerate() {
            if !(nm > 0.0 && nm.is_finite()) {
                return Err(SpectrumError::BadWavelength { index, nm });
            }
            if index > 0 && nodes[index - 1] >= nm {
                return Err(SpectrumError::NotIncreasing { index, previous_nm: nodes[index - 1], nm });
            }
            if !value.is_finite() {
                return Err(SpectrumError::BadValue { index, nm, value });
            }
        }
        Ok(Self { nodes: nodes.into(), values: values.into(), outside })
    }

    /// The wavelengths, nm.
    pub fn nodes(&self) -> &[f64] {
        &self.nodes
    }

    /// The value at each node.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// What it is beyond its ends.
    pub fn outside(&self) -> Extrapolation {
        self.outside
    }

    /// Range from the first to the last wavelength.
    pub fn domain(&self) -> WavelengthRange {
        WavelengthRange { min: self.nodes[0], max: self.nodes[self.nodes.len() - 1] }
    }

    /// The value at `nm` by bisection: slow, and the standard that the quick look-ups are held against.
    pub fn at(&self, nm: f64) -> f64 {
        let known = self.domain();
        if !known.contains(nm) {
            return match self.outside {
                Extrapolation::Zero => 0.0,
                Extrapolation::Hold if nm < known.min => self.values[0],
                Extrapolation::Hold => self.values[self.values.len() - 1],
            };
        }
        let i = self.nodes.partition_point(|&node| node <= nm).clamp(1, self.nodes.len() - 1) - 1;
        let fraction = (nm - self.nodes[i]) / (self.nodes[i + 1] - self.nodes[i]);
        self.values[i] * (1.0 - fraction) + self.values[i + 1] * fraction
    }

    /// Least and greatest value over `range`.
    pub fn bounds(&self, range: WavelengthRange) -> (f64, f64) {
        let inside = self.nodes.iter().zip(self.values.iter()).filter(|&(&nm, _)| range.contains(nm));
        let ends = [self.at(range.min), self.at(range.max)];
        inside
            .map(|(_, &value)| value)
            .chain(ends)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, greatest), v| (least.min(v), greatest.max(v)))
    }

    /// Exact integral of the piecewise linear function over `range`.
    pub fn integral(&self, range: WavelengthRange) -> f64 {
        let known = self.domain();
        let mut sum = 0.0;
        if self.outside == Extrapolation::Hold {
            sum += self.values[0] * (range.max.min(known.min) - range.min).max(0.0);
            sum += self.values[self.values.len() - 1] * (range.max - range.min.max(known.max)).max(0.0);
        }
        for segment in self.nodes.windows(2) {
            let (from, to) = (segment[0].max(range.min), segment[1].min(range.max));
            if from < to {
                sum += self.at(0.5 * (from + to)) * (to - from);
            }
        }
        sum
    }

    /// Whether every wavelength has the same value.
    pub fn is_constant(&self) -> bool {
        let all_equal = self.values.iter().all(|&value| value == self.values[0]);
        all_equal && (self.outside == Extrapolation::Hold || self.values[0] == 0.0)
    }

    fn scaled(&self, factor: f64) -> Self {
        Self { values: self.values.iter().map(|value| value * factor).collect(), ..self.clone() }
    }
}

/// A table on a regular grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Uniform {
    start: f64,
    end: f64,
    per_step: f64,
    /// For each cell its value at the lower end and the difference to that at the upper one; and one for the
    /// last node alone.
    cells: Arc<[[f64; 2]]>,
    held: bool,
    source: Table,
}

/// A finer grid than this (values) would cost more in cache than the guide table costs in steps.
const LARGEST_GRID: usize = 4096;

/// Steps (nm) in which published tables are commonly given.
const COMMON_STEPS: [f64; 6] = [5.0, 2.0, 1.0, 0.5, 0.2, 0.1];

impl Uniform {
    /// `values` at equal steps from `min` to `max`.
    pub(super) fn new(
        min: f64,
        max: f64,
        values: &[f64],
        outside: Extrapolation,
    ) -> Result<Self, SpectrumError> {
        let steps = values.len().saturating_sub(1) as f64;
        let node = |i: usize| if i as f64 == steps { max } else { min + (max - min) * (i as f64 / steps) };
        let nodes: Vec<f64> = (0..values.len()).map(node).collect();
        let source = Table::new(&nodes, values, outside)?;
        Ok(Self::on_grid(source, values))
    }

    /// The same function on a regular grid, if there is one that contains every node.
    pub(super) fn from_table(table: &Table) -> Option<Self> {
        let known = table.domain();
        let least_gap = table.nodes.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
        let steps = std::iter::once(least_gap).chain(COMMON_STEPS);
        let cells = steps.map(|step| (known.width() / step).round()).find(|&cells| {
            let rounding = 4.0 * f64::EPSILON * known.max;
            // Nodes as close as that would be one.
            least_gap > 2.0 * rounding
                && (1.0..LARGEST_GRID as f64).contains(&cells)
                && table.nodes.iter().all(|&nm| {
                    let cell = ((nm - known.min) * (cells / known.width())).round();
                    (known.min + known.width() * (cell / cells) - nm).abs() <= rounding
                })
        })?;
        let node = |i: usize| (known.min + known.width() * (i as f64 / cells)).min(known.max);
        let grid: Vec<f64> = (0..=cells as usize).map(|i| table.at(node(i))).collect();
        Some(Self::on_grid(table.clone(), &grid))
    }

    fn on_grid(source: Table, grid: &[f64]) -> Self {
        let WavelengthRange { min: start, max: end } = source.domain();
        let per_step = (grid.len() - 1) as f64 / (end - start);
        let cells = grid.windows(2).map(|pair| [pair[0], pair[1] - pair[0]]);
        let cells = cells.chain([[grid[grid.len() - 1], 0.0]]).collect();
        Self { start, end, per_step, cells, held: source.outside == Extrapolation::Hold, source }
    }

    /// The value at `nm`.
    pub fn at(&self, nm: f64) -> f64 {
        self.sample(&[nm]).hero()
    }

    /// The values at the wavelengths (nm) of one path.
    #[inline]
    pub fn sample<const C: usize>(&self, nm: &[f64; C]) -> Sampled<C> {
        /// Numbers around it have no fraction: what is added to it is rounded to an integer, which are its
        /// last bits.
        const WHOLE: f64 = 1.5 * (1u64 << 52) as f64;
        let last = self.cells.len() - 1;
        let end = last as f64;
        // Step by step for all lanes, so that each step but the look-up is one for vectors.
        let place = Sampled::<C>::from_fn(|lane| {
            let place = (nm[lane] - self.start) * self.per_step;
            let place = if place > 0.0 { place } else { 0.0 };
            if place < end { place } else { end }
        });
        // At a node either of its cells will do.
        let whole = place.map(|place| (place - 0.5) + WHOLE);
        let within = place - whole.map(|whole| whole - WHOLE);
        let (mut value, mut rise) = (Sampled::<C>::ZERO, Sampled::<C>::ZERO);
        for lane in 0..C {
            let cell = whole[lane].to_bits() as u32 as usize;
            [value[lane], rise[lane]] = self.cells[cell.min(last)];
        }
        let found = value + rise * within;
        if self.held {
            return found;
        }
        let known = |nm: f64| nm >= self.start && nm <= self.end;
        Sampled::from_fn(|lane| if known(nm[lane]) { found[lane] } else { 0.0 })
    }

    /// The table as published.
    pub fn source(&self) -> &Table {
        &self.source
    }

    /// Distance of the grid's points, nm.
    pub fn step(&self) -> f64 {
        1.0 / self.per_step
    }

    pub(super) fn scaled(&self, factor: f64) -> Self {
        let cells = self.cells.iter().map(|cell| cell.map(|value| value * factor)).collect();
        Self { cells, source: self.source.scaled(factor), ..self.clone() }
    }

    pub(super) fn with_extrapolation(&self, outside: Extrapolation) -> Self {
        let source = Table { outside, ..self.source.clone() };
        Self { held: outside == Extrapolation::Hold, source, ..self.clone() }
    }
}

/// A table with arbitrary nodes. A guide table of equal cells says between which nodes to look, so that the
/// cost does not grow with the table unless its nodes crowd into one cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Irregular {
    source: Table,
    slopes: Arc<[f64]>,
    per_cell: f64,
    /// For each cell, the last node at or before its left edge; one more for the right end.
    guide: Arc<[u32]>,
}

impl Irregular {
    pub(super) fn from_table(source: Table) -> Self {
        let known = source.domain();
        let cells = 2 * source.nodes.len();
        let width = known.width() / cells as f64;
        let last_segment = source.nodes.len() - 2;
        let before = |nm: f64| source.nodes.partition_point(|&node| node <= nm).saturating_sub(1);
        // A look-up may round into the neighbouring cell: its lower bound starts a little earlier, and its
        // upper bound is the next cell's (see `at`).
        let slack = 1e-9 * width;
        let mut guide: Vec<u32> = (0..=cells)
            .map(|cell| before(known.min + cell as f64 * width - slack).min(last_segment) as u32)
            .collect();
        guide[cells] = last_segment as u32;
        let gaps = source.nodes.windows(2).map(|pair| pair[1] - pair[0]);
        let rises = source.values.windows(2).map(|pair| pair[1] - pair[0]);
        let slopes = rises.zip(gaps).map(|(rise, gap)| rise / gap).collect();
        Self { per_cell: 1.0 / width, slopes, guide: guide.into(), source }
    }

    /// The value at `nm`.
    #[inline]
    pub fn at(&self, nm: f64) -> f64 {
        let nodes = &self.source.nodes;
        let last = nodes.len() - 1;
        let inside = nm >= nodes[0] && nm <= nodes[last];
        if !inside && self.source.outside == Extrapolation::Zero {
            return 0.0;
        }
        let nm = nm.clamp(nodes[0], nodes[last]);
        let cell = (((nm - nodes[0]) * self.per_cell) as usize).min(self.guide.len() - 2);
        let low = self.guide[cell] as usize;
        let high = self.guide[(cell + 2).min(self.guide.len() - 1)] as usize;
        let segment = low + nodes[low + 1..=high].partition_point(|&node| node <= nm);
        self.source.values[segment] + (nm - nodes[segment]) * self.slopes[segment]
    }

    /// The table as published.
    pub fn source(&self) -> &Table {
        &self.source
    }

    pub(super) fn scaled(&self, factor: f64) -> Self {
        let slopes = self.slopes.iter().map(|slope| slope * factor).collect();
        Self { slopes, source: self.source.scaled(factor), ..self.clone() }
    }

    pub(super) fn with_extrapolation(&self, outside: Extrapolation) -> Self {
        Self { source: Table { outside, ..self.source.clone() }, ..self.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    /// At, just before and just after every node and every edge of the guide's cells, however the nodes
    /// crowd.
    #[test]
    fn guided_lookups_find_the_segment() {
        let mut random = Pcg64Mcg::seed_from_u64(1);
        for _ in 0..300 {
            let mut nodes = vec![360.0];
            for _ in 0..random.random_range(1..40) {
                let (fraction, power): (f64, i32) = (random.random(), random.random_range(-9..3));
                nodes.push(nodes[nodes.len() - 1] + (0.1 + fraction) * 10f64.powi(power));
            }
            let heights: Vec<f64> = nodes.iter().map(|_| random.random_range(-5.0..5.0)).collect();
            let table = Table::new(&nodes, &heights, Extrapolation::Hold).unwrap();
            let guided = Irregular::from_table(table.clone());
            let cells = 2 * nodes.len();
            let edges = (0..=cells).map(|i| 360.0 + table.domain().width() * i as f64 / cells as f64);
            for place in nodes.iter().copied().chain(edges) {
                for nm in [place.next_down(), place, place.next_up()] {
                    // Rounding of the wavelength within its segment, times a slope of up to 10 / gap.
                    let tolerance = 1e-12 + 8.0 * f64::EPSILON * nm * steepest(&table);
                    let (found, expected) = (guided.at(nm), table.at(nm));
                    assert!((found - expected).abs() <= tolerance, "{nm} nm: {found} {expected}");
                }
            }
        }
    }

    fn steepest(table: &Table) -> f64 {
        let pairs = table.nodes.windows(2).zip(table.values.windows(2));
        pairs.map(|(nm, v)| ((v[1] - v[0]) / (nm[1] - nm[0])).abs()).fold(0.0, f64::max)
    }
}
