//! Sample values: where the randomness of every estimate comes from.
//!
//! A value is a pure function of (seed, pixel, sequence, index, dimension): images depend neither on
//! threads nor on tiles, and any path can be replayed alone. The samples of a pixel are dealt into a
//! few *sequences*, each stratified in itself and independent of the others, so that their spread
//! gives an honest standard error.

mod bilinear;
mod bluenoise;
mod cells;
mod density;
mod grid;
mod independent;
mod parametric;
mod permutation;
pub mod poisson;
pub mod quadrature;
mod sobol;
mod table;
pub mod warp;

use crate::lanes::{self, LANES, Mask, Register, Row, WIDTH, ZERO, lanes_of};
pub use bilinear::PiecewiseBilinearGrid;
use bluenoise::Layout;
use cells::Cells;
pub use density::Density;
pub use grid::PiecewiseConstantGrid;
pub use parametric::{Around, ParametricDensity, ParametricGrid};
use poisson::Patterns;
use serde::{Deserialize, Serialize};
use sobol::Role;
use std::fmt;
pub use table::PiecewiseConstant;

/// How sample values are made. All kinds are interchangeable: they differ in noise, never in expectation, but
/// for the regular grid, which has no expectation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SamplerKind {
    /// The same grid in every pixel: each sample at the centre of its part. Nothing is random, so there are
    /// no replicates and no error bars, and what the grid misses is missed in every pixel. For studies of
    /// aliasing.
    Regular,
    /// Independent random numbers (PCG).
    Independent,
    /// One random point in each of as many equal parts as a sequence has samples.
    Jittered,
    /// Poisson disk patterns in the first two dimensions of each set, equal parts in the others.
    Poisson,
    /// Owen-scrambled Sobol points: twelve dimensions together for film, lens and first light, others padded
    /// in sets of four.
    Sobol,
    /// The same, with the error arranged as blue noise over the picture.
    BlueNoise,
}

impl SamplerKind {
    /// The samplers by the names that scene files and the command line have for them.
    pub const NAMES: [(&str, Self); 6] = [
        ("regular", Self::Regular),
        ("independent", Self::Independent),
        ("jittered", Self::Jittered),
        ("poisson", Self::Poisson),
        ("sobol", Self::Sobol),
        ("bluenoise", Self::BlueNoise),
    ];

    /// The sampler of that name, if there is one.
    pub fn named(name: &str) -> Option<Self> {
        Self::NAMES.iter().find(|(known, _)| *known == name).map(|&(_, kind)| kind)
    }

    /// The name that the command line has for it.
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|&&(_, kind)| kind == self).map_or("", |&(name, _)| name)
    }

    /// Whether there are independent replicates of a sequence: whether the seed changes anything.
    pub fn is_random(self) -> bool {
        self != Self::Regular
    }
}

impl fmt::Display for SamplerKind {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A set of four sample values that are stratified together. Each has a meaning of its own, the same in every
/// scene; a set that a scene has no use for is never drawn. Light subpaths have streams of their own, and
/// their values the meanings in brackets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimensions {
    /// Film position (0, 1) \[where on the source, or its direction\], wavelength (2), time (3).
    Camera,
    /// Point on the lens (0, 1), the light whose light falls onto a measuring surface (2, 3) \[toward which
    /// place of a body (0, 1), which body (2), which source (3)\].
    Lens,
    /// Scattering at the path's n-th vertex: direction (0, 1), lobe (2), survival (3).
    Scattering(u32),
    /// Light at the path's n-th vertex: which light and which point on it (0, 1) \[the point on the lens\],
    /// the point on the light of a place near a lamp on the way there, or whether a place in a medium asks
    /// for light (2), which material of the surface (3).
    Light(u32),
    /// The flight to the path's n-th vertex through media that scatter: how far (0), where light of media is
    /// looked up (1), the distance near a lamp (2), the light for it (3).
    Flight(u32),
}

impl Dimensions {
    fn set(self) -> u32 {
        match self {
            Self::Camera => 0,
            Self::Light(0) => 1,
            Self::Lens => 2,
            Self::Scattering(vertex) => 3 + 2 * vertex,
            Self::Light(vertex) => 2 + 2 * vertex,
            // Apart from the others, so that what scenes without such media draw stays the same.
            Self::Flight(vertex) => 1 << 31 | vertex,
        }
    }
}

/// The place of a pixel in a group whose pixels share one sequence.
#[derive(Clone, Copy, Debug)]
pub struct Member {
    /// The group's corner on the film, which stands for the group.
    pub origin: [u32; 2],
    /// Among the members of the group, below the number that [`Sampler::for_groups`] was given.
    pub number: u32,
}

/// The sample values of a whole render.
#[derive(Clone, Debug)]
pub struct Sampler {
    kind: SamplerKind,
    seed: u64,
    /// Samples of a sequence. More may be drawn: they begin another sequence.
    samples: u32,
    /// The binary logarithm of the power of two that is not less than that.
    sample_bits: u32,
    /// The binary logarithm of the length of a Sobol sequence, which all members of a group share.
    length: u32,
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
            sample_bits: bits_for(samples.max(1)),
            length: bits_for(samples.max(1)),
            cells: Cells::new(samples),
            layout: Layout::new(samples),
            patterns: (kind == SamplerKind::Poisson).then(|| Patterns::new(samples, seed)),
        }
    }

    /// The same for groups of so many pixels.
    #[must_use]
    pub fn for_groups(mut self, members: u32) -> Self {
        self.length = (self.sample_bits + bits_for(members)).min(u32::BITS);
        self
    }

    /// The `index`-th path of a member of a group of pixels. With the Sobol sampler all members take runs of
    /// one sequence, each as well stratified as a sequence of its own, and all of them together are; the
    /// others have a sequence for each pixel.
    pub fn member_stream(&self, member: Member, pixel: [u32; 2], sequence: u32, index: u32) -> Stream<'_> {
        let stream = self.stream(pixel, sequence, index);
        if self.kind != SamplerKind::Sobol {
            return stream;
        }
        let run = member.number.checked_shl(self.sample_bits).unwrap_or(0);
        let key = self.key(member.origin, sequence, index / self.samples);
        Stream { key: mix(key ^ GROUP), index: (run | (index % self.samples)).reverse_bits(), ..stream }
    }

    /// Stands for a place on the film, a sequence, and how often this began anew.
    fn key(&self, place: [u32; 2], sequence: u32, round: u32) -> u64 {
        let key = mix(self.seed ^ mix(u64::from(place[0]) << 32 | u64::from(place[1])));
        mix(key ^ (u64::from(round) << 32 | u64::from(sequence)))
    }

    /// The `index`-th path of a pixel's `sequence`-th sequence. Up to 2³² paths a sequence.
    pub fn stream(&self, pixel: [u32; 2], sequence: u32, index: u32) -> Stream<'_> {
        let key = |place: [u32; 2], round: u32| self.key(place, sequence, round);
        let (round, within) = match self.kind {
            SamplerKind::Independent => (0, index),
            _ => (index / self.samples, index % self.samples),
        };
        let (key, index) = match self.kind {
            SamplerKind::BlueNoise => {
                (key(self.layout.block(pixel), round), self.layout.index(pixel, within))
            }
            SamplerKind::Regular => (0, within),
            SamplerKind::Sobol => (key(pixel, round), within.reverse_bits()),
            _ => (key(pixel, round), within),
        };
        Stream { sampler: self, kind: self.kind, key, index }
    }
}

/// Tells the sequences of groups from those of the pixels at their corners.
const GROUP: u64 = 0x0067_726f_7570;

/// Tells what [`Stream::spread`] chooses from sample values.
const SPREAD: u64 = 0x7370_7265_6164;

/// The binary logarithm of the power of two that is not less than `count`, which is above 0.
fn bits_for(count: u32) -> u32 {
    u32::BITS - (count - 1).leading_zeros()
}

/// The sample values of one path.
#[derive(Clone, Copy, Debug)]
pub struct Stream<'a> {
    sampler: &'a Sampler,
    kind: SamplerKind,
    /// Stands for seed, sequence, and pixel or block of pixels.
    key: u64,
    /// Index of the sample; for the Sobol sampler with its bits in reverse.
    index: u32,
}

impl Stream<'_> {
    /// The sample values of a branch of the path, by its number: as well stratified, and independent of the
    /// other branches'. Of the sets that are padded, which are those of all but the first surface.
    pub fn branch(self, branch: u32) -> Self {
        Self { key: mix(self.key ^ mix(u64::from(branch))), ..self }
    }

    /// The four values of a set, each in (0, 1).
    pub fn draw(&self, dimensions: Dimensions) -> [f64; 4] {
        let set = dimensions.set();
        match self.kind {
            SamplerKind::Sobol => {
                let (order, role) = self.order_of(set);
                sobol::scrambled(self.index, self.sampler.length, order, role, self.key_of(set)).map(unit)
            }
            SamplerKind::Independent => {
                independent::draw(mix(self.key ^ u64::from(self.index)), set).map(unit)
            }
            _ => self.draw_from_layout(set),
        }
    }

    /// The values of a set of streams of one sampler, for the lanes asked for: what [`Self::draw`] gives.
    pub fn draw_in_lanes(streams: &[&Self; LANES], dimensions: Dimensions, asked: Mask) -> [Row; 4] {
        let first = streams[0];
        let alike = streams.iter().all(|stream| stream.key == first.key);
        if first.kind != SamplerKind::Sobol || !alike {
            let mut values = [ZERO; 4];
            for lane in lanes_of(asked) {
                for (row, value) in values.iter_mut().zip(streams[lane].draw(dimensions)) {
                    lanes::set(row, lane, value);
                }
            }
            return values;
        }
        let mut values = [ZERO; 4];
        let indices = streams.map(|stream| stream.index);
        let set = dimensions.set();
        let (order, role) = first.order_of(set);
        let bits = sobol::scrambled_in_lanes(&indices, first.sampler.length, order, role, first.key_of(set));
        for (row, bits) in values.iter_mut().zip(bits) {
            for (register, bits) in row.iter_mut().zip(bits.chunks_exact(WIDTH)) {
                *register = Register::new(std::array::from_fn(|lane| unit(bits[lane])));
            }
        }
        values
    }

    /// A value of one dimension, moved within its stratum, so that what is left of it modulo 1 / `parts` is
    /// well spread, too: as finely as in a sequence `parts` times as long. For companions at equal steps from
    /// a value, which would else fall close to those of other values.
    ///
    /// In a Sobol sequence they lie at equal steps, from a random place on: the mean of a smooth function
    /// over such places is all but exact. A value without companions stays as it is.
    pub fn spread(&self, value: f64, parts: u32) -> f64 {
        let strata = match self.kind {
            SamplerKind::Independent => 1,
            SamplerKind::Sobol | SamplerKind::BlueNoise => 1 << self.sampler.sample_bits.min(u32::BITS - 1),
            SamplerKind::Regular | SamplerKind::Jittered | SamplerKind::Poisson => self.sampler.samples,
        };
        if parts == 1 || !strata.is_multiple_of(parts) {
            return value;
        }
        let place = value * f64::from(strata);
        let stratum = place as u32;
        // Strata at equal steps meet in one, and each takes another part of that: which, is random.
        let (step, met) = (stratum / (strata / parts), stratum % (strata / parts));
        let first = mix(self.key ^ mix(SPREAD ^ u64::from(met))) as u32;
        let part = step.wrapping_add(first % parts) % parts;
        // One place for all of a sequence. A sequence of blue noise serves many pixels, whose errors would be
        // alike.
        let within = match self.kind {
            SamplerKind::Sobol => unit((mix(self.key ^ SPREAD) >> 32) as u32),
            _ => place.fract(),
        };
        inside((f64::from(stratum) + (f64::from(part) + within) / f64::from(parts)) / f64::from(strata))
    }

    /// Apart, so that the common samplers stay small where they are inlined.
    #[inline(never)]
    fn draw_from_layout(&self, set: u32) -> [f64; 4] {
        let (key, sampler) = (self.key_of(set), self.sampler);
        match (self.kind, &sampler.patterns) {
            (SamplerKind::BlueNoise, _) => {
                let (order, role) = self.order_of(set);
                sampler.layout.sample(self.index, order, role, key).map(unit)
            }
            (SamplerKind::Poisson, Some(patterns)) => patterns.sample(sampler.cells, self.index, key),
            (SamplerKind::Regular, _) => sampler.cells.centres(self.index, key),
            _ => sampler.cells.jittered(self.index, key),
        }
    }

    /// What stands for the order of the points of the Sobol sequence that a set belongs to, and its role in
    /// it.
    fn order_of(&self, set: u32) -> (u64, Role) {
        match set {
            0 => (!self.key, Role::Camera),
            1 => (!self.key, Role::FirstLight),
            2 => (!self.key, Role::Lens),
            _ => (mix(!self.key ^ u64::from(set) << 32), Role::Padded),
        }
    }

    fn key_of(&self, set: u32) -> u64 {
        mix(self.key ^ (u64::from(set) << 32))
    }
}

/// The centre of one of 2³² equal parts of the unit interval: never 0 and never 1.
fn unit(bits: u32) -> f64 {
    (f64::from(bits) + 0.5) * (1.0 / 4_294_967_296.0)
}

/// Clamps to (0, 1) what rounding led out of it.
fn inside(x: f64) -> f64 {
    x.clamp(f64::EPSILON / 2.0, 1.0 - f64::EPSILON / 2.0)
}

/// Whether an event of some probability happens; what is left of the choice is as good as new.
pub fn decide(choice: &mut f64, probability: f64) -> bool {
    let happens = *choice < probability;
    *choice = if happens { *choice / probability } else { (*choice - probability) / (1.0 - probability) };
    *choice = choice.clamp(0.0, 1f64.next_down());
    happens
}

/// A 64-bit finaliser with full avalanche (Stafford's variant 13 of the MurmurHash3 mixer, as in SplitMix64:
/// Steele, Lea, Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014), of the next counter
/// value.
pub(crate) fn mix(state: u64) -> u64 {
    let z = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// Many words as one: a chain of [`mix`], so that every bit of every word changes about half of the bits.
pub(crate) fn digest(words: impl Iterator<Item = u64>) -> u64 {
    words.fold(0, |chain, word| mix(chain ^ word))
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

    /// A z-test of independence over many pixels, of every pair of values.
    #[test]
    fn dimensions_are_uncorrelated_over_pixels() {
        const VALUES: usize = 4 * SETS.len();
        for (name, kind) in SamplerKind::NAMES.into_iter().filter(|(_, kind)| kind.is_random()) {
            let sampler = Sampler::new(kind, 5, 16);
            let pixels = 40_000;
            let mut sums = [[[0.0; 2]; VALUES]; VALUES];
            for pixel in 0..pixels {
                let stream = sampler.stream([pixel, 3], 0, 3);
                let values: [f64; VALUES] = std::array::from_fn(|i| stream.draw(SETS[i / 4])[i % 4] - 0.5);
                for (i, row) in sums.iter_mut().enumerate() {
                    for (j, [sum, square]) in row.iter_mut().enumerate().take(i) {
                        let product = values[i] * values[j];
                        *sum += product;
                        *square += product * product;
                    }
                }
            }
            for (i, j) in (0..VALUES).flat_map(|i| (0..i).map(move |j| (i, j))) {
                let [sum, square] = sums[i][j];
                let z = sum / (square - sum * sum / f64::from(pixels)).sqrt();
                // 190 pairs for each of five samplers: a two-sided level of 1 % after Šidák's correction.
                let pair = format!("{:?}[{}] with {:?}[{}]", SETS[i / 4], i % 4, SETS[j / 4], j % 4);
                assert!(z.abs() < 4.5, "{name}: {pair}: z = {z}");
            }
        }
    }

    #[test]
    fn neighbouring_pixels_and_sequences_are_uncorrelated() {
        for (name, kind) in SamplerKind::NAMES.into_iter().filter(|(_, kind)| kind.is_random()) {
            let sampler = Sampler::new(kind, 1, 16);
            for (dx, ds) in [(1, 0), (0, 1)] {
                let (mut sum, n) = (0.0, 100_000u32);
                for x in 0..n {
                    let u = sampler.stream([2 * x, 0], 0, 1).draw(Dimensions::Camera)[0];
                    let v = sampler.stream([2 * x + dx, 0], ds, 1).draw(Dimensions::Camera)[0];
                    sum += (u - 0.5) * (v - 0.5);
                }
                let z = sum / (f64::from(n).sqrt() / 12.0);
                assert!(z.abs() < 4.0, "{name} {dx} {ds}: z = {z}");
            }
        }
    }

    /// Values stay in their strata, and they and their companions have a stratum of a fourth of the length
    /// each, in Sobol sequences at equal steps.
    #[test]
    fn spread_values_have_companions_that_are_spread() {
        const SAMPLES: u32 = 64;
        for kind in [SamplerKind::Sobol, SamplerKind::BlueNoise, SamplerKind::Jittered, SamplerKind::Poisson]
        {
            let sampler = Sampler::new(kind, 3, SAMPLES);
            let (mut quarters, mut within) = ([0; 4], [0; 4]);
            for x in 0..100 {
                let mut finest = [0; 4 * SAMPLES as usize];
                let mut steps = Vec::new();
                for index in 0..SAMPLES {
                    let stream = sampler.stream([x, 7], 0, index);
                    let value = stream.draw(Dimensions::Camera)[2];
                    let spread = stream.spread(value, 4);
                    let stratum = |value: f64| (value * f64::from(SAMPLES)) as u32;
                    assert_eq!(stratum(spread), stratum(value), "{kind}");
                    for companion in 0..4 {
                        let place = (spread + f64::from(companion) / 4.0).fract();
                        finest[(place * 4.0 * f64::from(SAMPLES)) as usize] += 1;
                    }
                    let step = spread * 4.0 * f64::from(SAMPLES);
                    steps.push(step.fract());
                    if index == 0 {
                        quarters[(4.0 * (spread * f64::from(SAMPLES)).fract()) as usize] += 1;
                        within[(4.0 * step.fract()) as usize] += 1;
                    }
                }
                assert_eq!(finest, [1; 4 * SAMPLES as usize], "{kind}");
                let is_even = steps.iter().all(|step| (step - steps[0]).abs() < 1e-12);
                assert_eq!(is_even, kind == SamplerKind::Sobol, "{kind}");
            }
            // Binomials of 100 with 1/4: a two-sided level of 1 % after Šidák's correction for 16 numbers of
            // each kind.
            assert!(
                quarters.iter().chain(&within).all(|&n| f64::abs(f64::from(n) - 25.0) < 3.4 * 4.33),
                "{kind}: {quarters:?} {within:?}"
            );
        }
    }

    #[test]
    fn lanes_have_the_values_of_their_streams() {
        for (name, kind) in SamplerKind::NAMES {
            for members in [1, 16] {
                let sampler = Sampler::new(kind, 3, 64).for_groups(members);
                let stream = |number: u32| {
                    let member = Member { origin: [4, 8], number: number % members };
                    sampler.member_stream(member, [4 + number, 8], 1, 5 + number / members)
                };
                let streams: [Stream; LANES] = std::array::from_fn(|number| stream(number as u32));
                for set in SETS {
                    let values = Stream::draw_in_lanes(&streams.each_ref(), set, lanes::ALL);
                    for (lane, stream) in streams.iter().enumerate() {
                        let of_lane = values.each_ref().map(|row| lanes::get(row, lane));
                        assert_eq!(of_lane, stream.draw(set), "{name}, {members} members, {set:?}");
                    }
                }
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

    /// One bit of one word, over 64 lists of words: of 4096 bits half change, within five standard errors.
    #[test]
    fn a_digest_depends_on_each_bit_of_each_word() {
        // Numbers of a scene: round ones.
        let lists: Vec<[u64; 4]> =
            (0..64).map(|i| [0.25, 1.0, 7.0, 50.0].map(|step| (step * f64::from(i)).to_bits())).collect();
        for word in 0..4 {
            for bit in 0..64 {
                let changes = |words: &[u64; 4]| {
                    let mut other = *words;
                    other[word] ^= 1 << bit;
                    (digest(words.iter().copied()) ^ digest(other.into_iter())).count_ones()
                };
                let changed: u32 = lists.iter().map(changes).sum();
                assert!(changed.abs_diff(2048) <= 160, "bit {bit} of word {word}: {changed} bits");
            }
        }
    }
}
