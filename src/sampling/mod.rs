//! Sample values: where the randomness of every estimate comes from.
//!
//! A value is a pure function of (seed, pixel, sequence, index, dimension): images depend neither on
//! threads nor on tiles, and any path can be replayed alone. The samples of a pixel are dealt into a
//! few *sequences*, each stratified in itself and independent of the others, so that their spread
//! gives an honest standard error.

mod bluenoise;
mod cells;
mod grid;
mod independent;
mod permutation;
pub mod poisson;
pub mod quadrature;
mod sobol;
mod table;
pub mod warp;

use bluenoise::Layout;
use cells::Cells;
pub use grid::PiecewiseConstantGrid;
use poisson::Patterns;
pub use table::PiecewiseConstant;

/// How sample values are made. All kinds are interchangeable: they differ in noise, never in expectation, but for
/// the regular grid, which has no expectation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SamplerKind {
    /// The same grid in every pixel: each sample at the centre of its share. Nothing is random, so there are no replicates
    /// and no error bars, and what the grid misses is missed in every pixel. For studies of aliasing.
    Regular,
    /// Independent random numbers (PCG).
    Independent,
    /// One random point in each of as many equal shares as a sequence has samples.
    Jittered,
    /// Poisson disk patterns in the first two dimensions of each set, equal shares in the others.
    Poisson,
    /// Owen-scrambled Sobol points, padded in sets of four dimensions.
    Sobol,
    /// The same, with the error arranged as blue noise over the picture.
    BlueNoise,
}

impl SamplerKind {
    pub const NAMES: [(&str, Self); 6] = [
        ("regular", Self::Regular),
        ("independent", Self::Independent),
        ("jittered", Self::Jittered),
        ("poisson", Self::Poisson),
        ("sobol", Self::Sobol),
        ("bluenoise", Self::BlueNoise),
    ];

    pub fn named(name: &str) -> Option<Self> {
        Self::NAMES.iter().find(|(known, _)| *known == name).map(|&(_, kind)| kind)
    }

    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|&&(_, kind)| kind == self).map_or("", |&(name, _)| name)
    }

    /// Whether there are independent replicates of a sequence: whether the seed changes anything.
    pub fn is_random(self) -> bool {
        self != Self::Regular
    }
}

/// A set of four sample values that are stratified together. Each has a meaning of its own, the same
/// in every scene; a set that a scene has no use for is never drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimensions {
    /// Film position (0, 1), wavelength (2), time (3).
    Camera,
    /// Point on the lens (0, 1).
    Lens,
    /// Scattering at the path's n-th vertex: direction (0, 1), lobe (2), survival (3).
    Scattering(u32),
    /// Light at the path's n-th vertex: point on it (0, 1), which light (2).
    Light(u32),
}

impl Dimensions {
    fn set(self) -> u32 {
        match self {
            Self::Camera => 0,
            Self::Lens => 1,
            Self::Scattering(vertex) => 2 + 2 * vertex,
            Self::Light(vertex) => 3 + 2 * vertex,
        }
    }
}

/// The sample values of a whole render.
#[derive(Clone, Debug)]
pub struct Sampler {
    kind: SamplerKind,
    seed: u64,
    /// Samples of a sequence. More may be drawn: they begin another sequence.
    samples: u32,
    cells: Cells,
    layout: Layout,
    patterns: Option<Patterns>,
}

impl Sampler {
    /// With sequences `samples` long. For `poisson` this makes its patterns, which takes up to half a second.
    pub fn new(kind: SamplerKind, seed: u64, samples: u32) -> Self {
        Self {
            kind,
            seed,
            samples: samples.max(1),
            cells: Cells::new(samples),
            layout: Layout::new(samples),
            patterns: (kind == SamplerKind::Poisson).then(|| Patterns::new(samples, seed)),
        }
    }

    /// The `index`-th path of a pixel's `sequence`-th sequence. Up to 2³² paths a sequence.
    pub fn stream(&self, pixel: [u32; 2], sequence: u32, index: u32) -> Stream<'_> {
        let key = |place: [u32; 2], round: u32| {
            let key = mix(self.seed ^ mix(u64::from(place[0]) << 32 | u64::from(place[1])));
            mix(key ^ (u64::from(round) << 32 | u64::from(sequence)))
        };
        let (round, within) = match self.kind {
            SamplerKind::Independent | SamplerKind::Sobol => (0, index),
            _ => (index / self.samples, index % self.samples),
        };
        let (key, index) = match self.kind {
            SamplerKind::BlueNoise => {
                (key(self.layout.block(pixel), round), self.layout.index(pixel, within))
            }
            SamplerKind::Regular => (0, within),
            _ => (key(pixel, round), within),
        };
        Stream { sampler: self, key, index }
    }
}

/// The sample values of one path.
#[derive(Clone, Copy, Debug)]
pub struct Stream<'a> {
    sampler: &'a Sampler,
    /// Stands for seed, sequence, and pixel or block of pixels.
    key: u64,
    index: u32,
}

impl Stream<'_> {
    /// The four values of a set, each in (0, 1).
    pub fn draw(&self, dimensions: Dimensions) -> [f64; 4] {
        let set = dimensions.set();
        let key = self.key ^ (u64::from(set) << 32);
        let bits = match (self.sampler.kind, &self.sampler.patterns) {
            (SamplerKind::Sobol, _) => sobol::scrambled(self.index, mix(key)),
            (SamplerKind::BlueNoise, _) => self.sampler.layout.sample(self.index, mix(key)),
            (SamplerKind::Poisson, Some(patterns)) => {
                return patterns.sample(self.sampler.cells, self.index, mix(key));
            }
            (SamplerKind::Jittered | SamplerKind::Poisson, _) => {
                return self.sampler.cells.jittered(self.index, mix(key));
            }
            (SamplerKind::Regular, _) => return self.sampler.cells.centres(self.index, mix(key)),
            (SamplerKind::Independent, _) => independent::draw(mix(self.key ^ u64::from(self.index)), set),
        };
        bits.map(unit)
    }
}

/// The centre of one of 2³² equal parts of the unit interval: never 0 and never 1.
fn unit(bits: u32) -> f64 {
    (f64::from(bits) + 0.5) * (1.0 / 4_294_967_296.0)
}

/// Into (0, 1) where rounding led out of it.
fn inside(x: f64) -> f64 {
    x.clamp(f64::EPSILON / 2.0, 1.0 - f64::EPSILON / 2.0)
}

/// A 64-bit finaliser with full avalanche (Stafford's variant 13 of the MurmurHash3 mixer, as in SplitMix64:
/// Steele, Lea, Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014), of the next counter value.
pub(crate) fn mix(state: u64) -> u64 {
    let z = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETS: [Dimensions; 5] = [
        Dimensions::Camera,
        Dimensions::Lens,
        Dimensions::Scattering(0),
        Dimensions::Light(0),
        Dimensions::Scattering(7),
    ];

    /// Mean and variance of a product of centred values over many pixels, for a z-test of independence.
    fn correlation(sampler: &Sampler, a: (Dimensions, usize), b: (Dimensions, usize)) -> f64 {
        let (mut sum, mut square, n) = (0.0, 0.0, 40_000);
        for pixel in 0..n {
            let stream = sampler.stream([pixel, 3], 0, 3);
            let product = (stream.draw(a.0)[a.1] - 0.5) * (stream.draw(b.0)[b.1] - 0.5);
            sum += product;
            square += product * product;
        }
        let n = f64::from(n);
        sum / (square - sum * sum / n).sqrt()
    }

    #[test]
    fn dimensions_are_uncorrelated_over_pixels() {
        for kind in [SamplerKind::Sobol, SamplerKind::Independent] {
            let sampler = Sampler::new(kind, 5, 16);
            for (i, &a) in SETS.iter().enumerate() {
                for (j, &b) in SETS.iter().enumerate() {
                    for (p, q) in (0..4).flat_map(|p| (0..4).map(move |q| (p, q))) {
                        if (i, p) < (j, q) {
                            let z = correlation(&sampler, (a, p), (b, q));
                            // 190 pairs: a two-sided level of 1 % after Šidák's correction.
                            assert!(z.abs() < 4.2, "{kind:?}: {a:?}[{p}] with {b:?}[{q}]: z = {z}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn neighbouring_pixels_and_sequences_are_uncorrelated() {
        for kind in [SamplerKind::Sobol, SamplerKind::Independent] {
            let sampler = Sampler::new(kind, 1, 16);
            for (dx, ds) in [(1, 0), (0, 1)] {
                let (mut sum, n) = (0.0, 100_000u32);
                for x in 0..n {
                    let u = sampler.stream([2 * x, 0], 0, 1).draw(Dimensions::Camera)[0];
                    let v = sampler.stream([2 * x + dx, 0], ds, 1).draw(Dimensions::Camera)[0];
                    sum += (u - 0.5) * (v - 0.5);
                }
                let z = sum / (f64::from(n).sqrt() / 12.0);
                assert!(z.abs() < 4.0, "{kind:?} {dx} {ds}: z = {z}");
            }
        }
    }

    #[test]
    fn a_value_depends_on_nothing_but_its_coordinates() {
        for (name, kind) in SamplerKind::NAMES {
            let [sampler, again] = [(); 2].map(|()| Sampler::new(kind, 9, 16));
            let stream = sampler.stream([4, 5], 6, 7);
            let first = stream.draw(Dimensions::Light(3));
            stream.draw(Dimensions::Camera);
            assert_eq!(first, again.stream([4, 5], 6, 7).draw(Dimensions::Light(3)), "{name}");
            let reseeded = Sampler::new(kind, 10, 16).stream([4, 5], 6, 7).draw(Dimensions::Light(3));
            assert_eq!(first != reseeded, kind.is_random(), "{name}");
        }
    }
}
