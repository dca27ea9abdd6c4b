//! Reconstruction filters. The samples of a picture are splatted onto all pixels that their filter reaches.
//! Images of what the camera sees first draw each sample from its own pixel's filter (Ernst, Stamminger,
//! Greiner, "Filter Importance Sampling", 2006).

use super::Region;
use crate::lanes::{Real, Register, WIDTH};
use crate::sampling::PiecewiseConstant;
use smallvec::{SmallVec, smallvec};
use std::f64::consts::PI;

/// A separable reconstruction filter over the image plane, in pixels, with Mitsuba 3's names and defaults.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FilterKind {
    /// One pixel wide: each sample belongs to the pixel that it falls into.
    Box,
    /// Falls off linearly.
    Tent {
        /// Where it ends, in pixels. Above 0.
        radius: f64,
    },
    /// Cut off at four standard deviations and lowered to be zero there.
    Gaussian {
        /// Standard deviation, in pixels. Above 0.
        stddev: f64,
    },
    /// Mitchell and Netravali, "Reconstruction filters in computer graphics", SIGGRAPH 1988.
    Mitchell {
        /// The parameter B, ⅓ by default.
        b: f64,
        /// The parameter C, ⅓ by default.
        c: f64,
    },
    /// Catmull and Rom's cubic: Mitchell's with B = 0 and C = ½.
    CatmullRom,
    /// A sinc windowed by a wider sinc.
    Lanczos {
        /// Lobes to each side, which is also the radius in pixels. At least 1.
        lobes: u32,
    },
}

impl FilterKind {
    /// Half width, pixels.
    pub fn radius(self) -> f64 {
        match self {
            Self::Box => 0.5,
            Self::Tent { radius } => radius,
            Self::Gaussian { stddev } => 4.0 * stddev,
            Self::Mitchell { .. } | Self::CatmullRom => 2.0,
            Self::Lanczos { lobes } => f64::from(lobes),
        }
    }

    /// Value at a distance from the centre along one axis, up to a factor; zero beyond the radius.
    pub fn at(self, x: f64) -> f64 {
        let radius = self.radius();
        if x.abs() > radius {
            return 0.0;
        }
        match self {
            Self::Box => 1.0,
            Self::Tent { .. } => 1.0 - x.abs() / radius,
            Self::Gaussian { stddev } => lowered_bell(x / stddev),
            Self::Mitchell { b, c } => cubic(x.abs(), b, c),
            Self::CatmullRom => cubic(x.abs(), 0.0, 0.5),
            Self::Lanczos { .. } => sinc(x) * sinc(x / radius),
        }
    }
}

/// The pixels that a sample is splatted onto, and what each weighs it with: columns times rows.
#[derive(Clone, Debug)]
pub struct Footprint {
    /// The first column and the first row. They may lie outside the film.
    pub first: [i64; 2],
    /// Weight of each column from the first on.
    pub columns: SmallVec<[f64; 6]>,
    /// Weight of each row from the first on.
    pub rows: SmallVec<[f64; 6]>,
}

impl Footprint {
    /// Visits each pixel, by column and row, with its weight.
    #[inline(always)]
    pub fn for_each(&self, mut visit: impl FnMut([i64; 2], f64)) {
        for (row, down) in (self.first[1]..).zip(&self.rows) {
            for (column, across) in (self.first[0]..).zip(&self.columns) {
                visit([column, row], across * down);
            }
        }
    }

    /// The weight of one pixel; zero of those that the sample does not reach.
    pub fn weight(&self, pixel: [i64; 2]) -> f64 {
        let along = |axis: usize, weights: &[f64]| {
            let number = usize::try_from(pixel[axis] - self.first[axis]).ok();
            number.and_then(|number| weights.get(number)).copied().unwrap_or(0.0)
        };
        along(0, &self.columns) * along(1, &self.rows)
    }
}

impl FilterKind {
    /// How many pixels away from its own pixel a sample may reach.
    pub fn reach(self) -> u32 {
        (self.radius() - 0.5).ceil().max(0.0) as u32
    }

    /// The pixels that a sample at a place reaches, in pixels from the film's corner.
    pub fn footprint(self, place: [f64; 2]) -> Footprint {
        if self == Self::Box {
            return Footprint {
                first: place.map(|place| place.floor() as i64),
                columns: smallvec![1.0],
                rows: smallvec![1.0],
            };
        }
        let axis = |place: f64| {
            // The middle of a pixel is half a pixel from its corner.
            let first = (place - 0.5 - self.radius()).ceil();
            let last = (place - 0.5 + self.radius()).floor();
            let count = (last - first + 1.0) as usize;
            let from = place - 0.5 - first;
            let weights = match self {
                Self::Gaussian { stddev } => gaussian_weights(from, count, stddev),
                _ => (0..count).map(|i| self.at(from - i as f64)).collect(),
            };
            (first as i64, weights)
        };
        let [(left, columns), (top, rows)] = place.map(axis);
        Footprint { first: [left, top], columns, rows }
    }
}

/// The bell curve, lowered to be zero at four standard deviations.
#[inline(always)]
fn lowered_bell<R: Real>(deviations: R) -> R {
    /// e⁻⁸.
    const LEAST: f64 = 3.354_626_279_025_118_4e-4;
    (deviations * deviations * R::of(-0.5)).exp() - R::of(LEAST)
}

/// What a gaussian filter weighs pixels with, whose distances from a place fall from the first by one each.
fn gaussian_weights(first: f64, count: usize, stddev: f64) -> SmallVec<[f64; 6]> {
    let from = |start: usize| {
        let steps = Register::new(std::array::from_fn(|step| (start + step) as f64));
        lowered_bell((Register::splat(first) - steps) / Register::splat(stddev)).to_array()
    };
    /// The default filter has no more.
    const FEW: usize = 4;
    if count <= FEW {
        let [a, b, c, d, ..] = from(0);
        return SmallVec::from_buf_and_len([a, b, c, d, 0.0, 0.0], count);
    }
    let starts = (0..count).step_by(WIDTH);
    starts.flat_map(|start| from(start).into_iter().take(count - start)).collect()
}

/// The family of cubics of Mitchell and Netravali (1988, eq. 8), for 0 ≤ x ≤ 2.
fn cubic(x: f64, b: f64, c: f64) -> f64 {
    let (x2, x3) = (x * x, x * x * x);
    if x < 1.0 {
        ((12.0 - 9.0 * b - 6.0 * c) * x3 + (-18.0 + 12.0 * b + 6.0 * c) * x2 + (6.0 - 2.0 * b)) / 6.0
    } else {
        ((-b - 6.0 * c) * x3 + (6.0 * b + 30.0 * c) * x2 + (-12.0 * b - 48.0 * c) * x + (8.0 * b + 24.0 * c))
            / 6.0
    }
}

fn sinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) }
}

/// Bins of the sampling table per pixel.
const BINS: f64 = 64.0;

/// Where a pixel's samples fall, for every pixel of a window of a film. Pixels and places are those of the
/// whole film.
///
/// Where no samples are taken outside the window, a filter is cut off at its border and normalised again, as
/// in Mitsuba 3.
#[derive(Clone, Debug)]
pub struct FilterSampler {
    kind: FilterKind,
    columns: Axis,
    rows: Axis,
}

/// The filter along one axis: for each pixel, which of the distinct cuts of the filter is its own.
#[derive(Clone, Debug)]
struct Axis {
    /// The first pixel of the window.
    first: u32,
    cuts: Vec<Cut>,
    cut_of: Vec<u16>,
}

#[derive(Clone, Debug)]
struct Cut {
    low: f64,
    high: f64,
    table: PiecewiseConstant,
    /// 1 / ∫ filter over the cut.
    normalisation: f64,
}

impl FilterSampler {
    /// `sample_border`: whether pixels at the border have samples outside the window.
    pub fn new(kind: FilterKind, window: Region, sample_border: bool) -> Self {
        let [columns, rows] =
            [0, 1].map(|axis| Axis::new(kind, window.offset[axis], window.size[axis], sample_border));
        Self { kind, columns, rows }
    }

    /// The film position of a sample of the pixel at (`x`, `y`), in pixels from the whole film's corner, and
    /// its weight: 1 on average, negative where the filter is.
    pub fn sample(&self, pixel: [u32; 2], u: [f64; 2]) -> ([f64; 2], f64) {
        let centre = pixel.map(|p| f64::from(p) + 0.5);
        if self.kind == FilterKind::Box {
            return ([centre[0] + u[0] - 0.5, centre[1] + u[1] - 0.5], 1.0);
        }
        let (x, across) = self.columns.sample(self.kind, pixel[0], u[0]);
        let (y, down) = self.rows.sample(self.kind, pixel[1], u[1]);
        ([centre[0] + x, centre[1] + y], across * down)
    }
}

impl FilterSampler {
    /// The pixels whose filters reach a film position, and the value of each filter there, per pixel of area:
    /// its integral is 1. Zero outside the window.
    pub fn footprint(&self, position: [f64; 2]) -> Footprint {
        let mut footprint = self.kind.footprint(position);
        let [left, top] = footprint.first;
        self.columns.cut_off(left, position[0], &mut footprint.columns);
        self.rows.cut_off(top, position[1], &mut footprint.rows);
        footprint
    }
}

impl Axis {
    /// Makes weights of pixels those of their cut filters.
    fn cut_off(&self, first: i64, position: f64, weights: &mut [f64]) {
        for (pixel, weight) in (first..).zip(weights) {
            let number = usize::try_from(pixel - i64::from(self.first)).ok();
            let cut = number.and_then(|number| Some(&self.cuts[usize::from(*self.cut_of.get(number)?)]));
            let x = position - pixel as f64 - 0.5;
            // Each place between two pixels belongs to one of them.
            let cut = cut.filter(|cut| x >= cut.low && x < cut.high);
            *weight *= cut.map_or(0.0, |cut| cut.normalisation);
        }
    }

    fn new(kind: FilterKind, first: u32, size: u32, sample_border: bool) -> Self {
        let radius = kind.radius();
        let mut cuts: Vec<Cut> = Vec::new();
        let cut_of = (0..size)
            .map(|pixel| {
                let (low, high) = if sample_border {
                    (-radius, radius)
                } else {
                    ((-radius).max(-0.5 - f64::from(pixel)), radius.min(f64::from(size - pixel) - 0.5))
                };
                let known = cuts.iter().position(|cut| cut.low == low && cut.high == high);
                known.unwrap_or_else(|| {
                    cuts.push(Cut::new(kind, low, high));
                    cuts.len() - 1
                }) as u16
            })
            .collect();
        Self { first, cuts, cut_of }
    }

    fn cut(&self, pixel: u32) -> &Cut {
        &self.cuts[usize::from(self.cut_of[(pixel - self.first) as usize])]
    }

    fn sample(&self, kind: FilterKind, pixel: u32, u: f64) -> (f64, f64) {
        let cut = self.cut(pixel);
        let (x, density) = cut.table.sample(u);
        (x, kind.at(x) * cut.normalisation / density)
    }
}

impl Cut {
    fn new(kind: FilterKind, low: f64, high: f64) -> Self {
        let bins = ((high - low) * BINS).ceil().max(1.0) as usize;
        let edges: Vec<f64> = (0..=bins).map(|i| low + (high - low) * i as f64 / bins as f64).collect();
        // Simpson's rule in each bin: the filters are smooth at this scale, with kinks at whole pixels, which
        // are edges.
        let integrate = |f: &dyn Fn(f64) -> f64| -> Vec<f64> {
            let bin = |e: &[f64]| (f(e[0]) + 4.0 * f(0.5 * (e[0] + e[1])) + f(e[1])) * (e[1] - e[0]) / 6.0;
            edges.windows(2).map(bin).collect()
        };
        let normalisation = 1.0 / integrate(&|x| kind.at(x)).iter().sum::<f64>();
        let magnitudes = integrate(&|x| kind.at(x).abs());
        let table = PiecewiseConstant::new(edges.clone(), &magnitudes)
            .expect("edges ascend and no filter vanishes over its whole cut");
        Self { low, high, table, normalisation }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::Rng;
    use rand_pcg::Pcg64Mcg;

    const ALL: [FilterKind; 6] = [
        FilterKind::Box,
        FilterKind::Tent { radius: 1.0 },
        FilterKind::Gaussian { stddev: 0.5 },
        FilterKind::Mitchell { b: 1.0 / 3.0, c: 1.0 / 3.0 },
        FilterKind::CatmullRom,
        FilterKind::Lanczos { lobes: 3 },
    ];

    /// ∫ f·g / ∫ f with g = exp(x) over the part of a filter that lies between two distances from its centre,
    /// by brute force.
    fn expected(kind: FilterKind, low: f64, high: f64) -> f64 {
        let (mut product, mut sum, n) = (0.0, 0.0, 1_000_000);
        for i in 0..n {
            let x = low + (high - low) * (f64::from(i) + 0.5) / f64::from(n);
            let value = kind.at(x);
            product += value * x.exp();
            sum += value;
        }
        product / sum
    }

    /// The same by the samples of a pixel, whose distances must lie in the same range.
    fn sampled(sampler: &FilterSampler, pixel: u32, low: f64, high: f64) -> f64 {
        // Equal steps of u: the quadrature error falls as 1/n.
        let n = 400_000;
        let (mut sum, mut weights) = (0.0, 0.0);
        for i in 0..n {
            let u = (f64::from(i) + 0.5) / f64::from(n);
            let ([x, _], weight) = sampler.sample([pixel, 0], [u, 0.5]);
            let distance = x - f64::from(pixel) - 0.5;
            assert!((low..=high).contains(&distance), "{sampler:?} {x}");
            sum += weight * distance.exp();
            weights += weight;
        }
        // 0.5 in the other axis is the centre of the only row, where a weight is not 1 for filters with
        // a table; it cancels in the ratio.
        sum / weights
    }

    #[test]
    fn samples_weigh_as_the_filter_does_inside_and_at_the_border() {
        for kind in ALL {
            for sample_border in [false, true] {
                let sampler = FilterSampler::new(kind, Region::whole([9, 1]), sample_border);
                for pixel in [0, 1, 4, 8] {
                    let (mut low, mut high) = (-kind.radius(), kind.radius());
                    if !sample_border {
                        low = low.max(-0.5 - f64::from(pixel));
                        high = high.min(8.5 - f64::from(pixel));
                    }
                    let (found, truth) = (sampled(&sampler, pixel, low, high), expected(kind, low, high));
                    assert!(
                        (found / truth - 1.0).abs() < 1e-4,
                        "{kind:?} at {pixel}, {sample_border}: {found} against {truth}"
                    );
                }
            }
        }
    }

    /// What a filter weighs a place with is what its samples make of the place.
    #[test]
    fn filters_weigh_places_as_they_sample_them() {
        const SAMPLES: u32 = 100_000;
        let measure = |[x, y]: [f64; 2]| (0.7 * x - 0.3 * y).sin();
        let mut generator = Pcg64Mcg::new(3);
        let mut next = || (generator.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        for (kind, sample_border) in ALL.into_iter().flat_map(|kind| [(kind, false), (kind, true)]) {
            let sampler = FilterSampler::new(kind, Region::whole([5, 4]), sample_border);
            for pixel in [[0, 0], [2, 1], [4, 3]] {
                let (mut sum, mut squares) = (0.0, 0.0);
                for _ in 0..SAMPLES {
                    let (place, weight) = sampler.sample(pixel, [next(), next()]);
                    sum += weight * measure(place);
                    squares += (weight * measure(place)).powi(2);
                }
                let n = f64::from(SAMPLES);
                let (sampled, error) = (sum / n, ((squares / n - (sum / n).powi(2)) / n).sqrt());
                // The middles of small cells, of which the edges of all filters are edges.
                const FINE: u32 = 13 * 32;
                let middle = |i: u32| -4.0 + (f64::from(i) + 0.5) / 32.0;
                let (mut weighed, mut whole) = (0.0, 0.0);
                for place in (0..FINE * FINE).map(|i| [middle(i / FINE), middle(i % FINE)]) {
                    let at = sampler.footprint(place).weight(pixel.map(i64::from)) / (32.0 * 32.0);
                    weighed += at * measure(place);
                    whole += at;
                }
                assert!((whole - 1.0).abs() < 1e-3, "{kind:?} {pixel:?}: {whole}");
                let off = (sampled - weighed).abs();
                assert!(off < 4.5 * error + 1e-3, "{kind:?} {pixel:?}: {sampled} ± {error}, {weighed}");
            }
        }
    }
}
