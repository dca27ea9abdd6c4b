//! How two pictures differ: what artists, colour scientists and statisticians ask for, each with its
//! definition.
//!
//! A is judged, B is the reference; either may be several pictures of one scene, whose means are compared.
//! Bias and noise are kept apart: figures such as relMSE see both, Welch's t-test sees only what the errors
//! do not explain, stated ones or those that the spread of several pictures shows. Model of the tests: a mean
//! over replicates is distributed so that Student's t applies, and noise that pixels have in common is as the
//! file states it; pixels of a file that states errors alone are independent.

mod bias;
mod condition;
mod figures;
pub mod flip;
mod maps;
mod noise;
mod pair;
mod report;

pub use bias::{CELLS, LEVEL, POWER, TILE, Tests};
pub use condition::{Condition, Unmet};
pub use figures::{Figures, PerceivedDifference};
pub use maps::{Map, MapKind};
pub use noise::Noise;
pub use pair::{Channel, Measurement, Mismatch, Pair, listed};

use crate::output::exr::{Channels, Layout};
use crate::stats::sidak_corrected;
use pair::SIDES;

/// What can be chosen in a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Luminance that is white for ΔE and ꟻLIP, in the unit of the files; `None` lets the reference decide.
    pub white: Option<f64>,
    /// Pixels per degree of visual angle, for ꟻLIP.
    pub pixels_per_degree: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self { white: None, pixels_per_degree: flip::PIXELS_PER_DEGREE }
    }
}

/// How two pictures differ.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Columns of either picture.
    pub width: usize,
    /// Rows of either picture.
    pub height: usize,
    /// Pixels with values that are not finite, in A and in B, and pixels whose error is infinite because too
    /// few samples were taken of them. All figures leave them out.
    pub bad: [u64; 2],
    /// Pixels whose error is infinite, likewise left out.
    pub unmeasured: u64,
    /// Figures of luminance, or their means over the channels of files without colours.
    pub figures: Figures,
    /// Figures of what is seen, for files with colours.
    pub seen: Option<PerceivedDifference>,
    /// Figures and tests of each channel.
    pub channels: Vec<ChannelResult>,
    /// The channel that stands for all in pictures: luminance, green, or the first.
    pub middle: usize,
    /// Replicates behind the errors of each side: those of its pictures together, where they say so, or the
    /// pictures themselves, where the errors are their spread.
    pub replicates: [Option<u32>; 2],
    /// Where the errors of each side come from.
    pub noise: [Noise; 2],
    /// The pixels in which A is brightest over B, the most first: what `abbe explain` may be asked about.
    pub outliers: Vec<Outlier>,
    /// What was assumed because the files do not say: it may be wrong, and the tests with it.
    pub assumptions: Vec<String>,
    /// What else a reader of the figures should know.
    pub notes: Vec<String>,
}

/// A pixel, and what A and B have there in the channel that stands for all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outlier {
    /// Column and row from the upper left corner of the files.
    pub pixel: [usize; 2],
    /// The values of A and of B.
    pub values: [f64; 2],
}

/// Number of outliers that are reported.
const OUTLIERS: usize = 3;

/// How one channel differs.
#[derive(Clone, Debug)]
pub struct ChannelResult {
    /// Name of the channel, as [`Channel`] has it.
    pub name: String,
    /// How large the difference is.
    pub figures: Figures,
    /// A minus B; NaN where they cannot be compared.
    pub difference: Vec<f64>,
    /// Tests of a channel of light, if at least one side knows its noise.
    pub tests: Option<Tests>,
}

/// The tests of all channels together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict {
    /// How likely something as extreme is in means, tiles or pixels of any channel if the pictures differ by
    /// noise alone: the smallest of the three p-values below, corrected for their number.
    pub p: f64,
    /// Smallest p-value of the means.
    pub p_mean: f64,
    /// Smallest p-value of the tiles.
    pub p_tiles: f64,
    /// Smallest p-value of the pixels.
    pub p_pixels: f64,
    /// Not part of `p`: it judges the error bars as much as the means.
    pub p_uniform: f64,
    /// The largest over the channels.
    pub detectable: f64,
    /// The same for tiles, over the reference's mean.
    pub detectable_tile: f64,
}

/// Compares a picture with its reference, either of which may be several: seeds of one scene.
pub fn compare(a: &[Channels], b: &[Channels], options: &Options) -> Result<Comparison, Mismatch> {
    let pair = Pair::new(a, b)?;
    let pixels = pair.width * pair.height;
    let good: Vec<bool> = (0..pixels).map(|pixel| pair.is_good(pixel)).collect();
    let (mut bad, mut unmeasured) = ([0, 0], 0);
    for pixel in (0..pixels).filter(|&pixel| !good[pixel]) {
        let [in_a, in_b] = pair.is_bad(pixel);
        bad[0] += u64::from(in_a);
        bad[1] += u64::from(in_b);
        unmeasured += u64::from(!in_a && !in_b);
    }
    let channels: Vec<ChannelResult> = pair
        .channels
        .iter()
        .map(|channel| {
            let (a, b) = (&channel.a.values, &channel.b.values);
            let difference = (0..pixels).map(|i| if good[i] { a[i] - b[i] } else { f64::NAN }).collect();
            let is_known = [channel.a.noise, channel.b.noise] != [Noise::Unknown; 2];
            ChannelResult {
                name: channel.name.clone(),
                figures: Figures::of(a, b, &good),
                difference,
                tests: (channel.is_light && is_known).then(|| bias::test(&pair, channel, &good)),
            }
        })
        .collect();
    let figures = match pair.colour {
        Some(_) => {
            let luminance: Vec<[f64; 2]> =
                (0..pixels).filter_map(|i| Some(pair.xyz(i)?.map(|xyz| xyz.y))).collect();
            let side = |side: usize| luminance.iter().map(|both| both[side]).collect::<Vec<f64>>();
            Figures::of(&side(0), &side(1), &good)
        }
        // Those of light come first.
        None => Figures::mean(channels[..pair.light().count()].iter().map(|channel| &channel.figures)),
    };
    let noise = [|channel: &Channel| channel.a.noise, |channel: &Channel| channel.b.noise].map(|side| {
        let known = pair.light().map(side).find(|noise| *noise != Noise::Unknown);
        known.unwrap_or(Noise::Unknown)
    });
    let replicates = [0, 1].map(|side| match noise[side] {
        Noise::Spread => Some([a, b][side].len() as u32),
        _ => [a, b][side].iter().map(noise::replicates).sum(),
    });
    let mut comparison = Comparison {
        width: pair.width,
        height: pair.height,
        bad,
        unmeasured,
        figures,
        seen: PerceivedDifference::of(&pair, &good, options),
        channels,
        middle: pair.middle(),
        replicates,
        noise,
        outliers: outliers(&pair, &good),
        assumptions: Vec::new(),
        notes: Vec::new(),
    };
    let pictures = pictures([a, b]);
    comparison.assumptions = assumptions(&comparison, &pictures);
    comparison.notes = notes(&comparison, &pair, &pictures);
    Ok(comparison)
}

impl Comparison {
    /// `None` where neither side knows its noise.
    pub fn verdict(&self) -> Option<Verdict> {
        let tests: Vec<&Tests> = self.channels.iter().filter_map(|channel| channel.tests.as_ref()).collect();
        if tests.is_empty() {
            return None;
        }
        let smallest = |p: fn(&Tests) -> f64| {
            sidak_corrected(tests.iter().map(|&tests| p(tests)).fold(1.0, f64::min), tests.len())
        };
        let largest =
            |fraction: fn(&Tests) -> f64| tests.iter().map(|&tests| fraction(tests)).fold(f64::NAN, f64::max);
        let parts = [smallest(|t| t.p_mean), smallest(|t| t.p_tiles), smallest(|t| t.p_pixels)];
        let [p_mean, p_tiles, p_pixels] = parts;
        Some(Verdict {
            p: sidak_corrected(parts.into_iter().fold(1.0, f64::min), parts.len()),
            p_mean,
            p_tiles,
            p_pixels,
            p_uniform: smallest(|t| t.p_uniform),
            detectable: largest(|t| t.detectable),
            detectable_tile: largest(|t| t.detectable_tile),
        })
    }
}

/// The good pixels in which A exceeds B the most.
fn outliers(pair: &Pair, good: &[bool]) -> Vec<Outlier> {
    let Some(Channel { a, b, .. }) = pair.channels.get(pair.middle()) else { return Vec::new() };
    let over = |&pixel: &usize| a.values[pixel] - b.values[pixel];
    let mut pixels: Vec<usize> = (0..good.len()).filter(|pixel| good[*pixel] && over(pixel) > 0.0).collect();
    pixels.sort_by(|first, second| over(second).total_cmp(&over(first)));
    let outlier = |pixel: usize| Outlier {
        pixel: [pixel % pair.width, pixel / pair.width],
        values: [a.values[pixel], b.values[pixel]],
    };
    pixels.into_iter().take(OUTLIERS).map(outlier).collect()
}

/// All pictures of both sides, with what messages call them.
fn pictures(sides: [&[Channels]; 2]) -> Vec<(String, &Channels)> {
    let named = |side: usize| {
        let count = sides[side].len();
        sides[side].iter().enumerate().map(move |(i, picture)| (pair::label(side, i, count), picture))
    };
    named(0).chain(named(1)).collect()
}

fn assumptions(comparison: &Comparison, pictures: &[(String, &Channels)]) -> Vec<String> {
    let mut assumptions = Vec::new();
    for (side, name) in SIDES.into_iter().enumerate() {
        let (own, other) = (comparison.noise[side], comparison.noise[1 - side]);
        if own == Noise::Unknown && other != Noise::Unknown {
            assumptions.push(format!(
                "{name} is one picture that states no errors (channels error.*): it is taken to be exact, so that its noise \
                 passes for bias and p-values are far too small if it has any. Give several renders of it that differ in \
                 the seed; their spread then is its error"
            ));
        }
        if own == Noise::Stated && comparison.replicates[side].is_none() {
            assumptions.push(format!(
                "{name} does not say how many replicates its errors come from (attribute abbe.replicates): they are taken to be exact"
            ));
        }
    }
    let [(of_first, first), others @ ..] = pictures else { return assumptions };
    let Layout { offset: [x, y], .. } = first.layout;
    if let Some((label, apart)) = others.iter().find(|(_, other)| other.layout.offset != [x, y]) {
        let [own_x, own_y] = apart.layout.offset;
        assumptions.push(format!(
            "{of_first} begins at pixel {x},{y} of its film and {label} at {own_x},{own_y} (their data windows differ): \
             they are taken to show the same"
        ));
    }
    assumptions
}

fn notes(comparison: &Comparison, pair: &Pair, pictures: &[(String, &Channels)]) -> Vec<String> {
    let mut notes = Vec::new();
    let pixels = comparison.width * comparison.height;
    for (name, count) in SIDES.into_iter().zip(comparison.bad) {
        if count > 0 {
            notes.push(format!(
                "{count} of {pixels} pixels of {name} are not finite; all figures leave them out"
            ));
        }
    }
    if comparison.unmeasured > 0 {
        notes.push(format!("{} of {pixels} pixels have no error yet: left out", comparison.unmeasured));
    }
    if pair.layers.iter().any(|layer| !layer.is_empty()) {
        let [a, b] = pair.layers.each_ref().map(|layer| match layer.as_str() {
            "" => "those of no layer".to_owned(),
            layer => format!("those of the layer {layer}"),
        });
        notes.push(match a == b {
            true => format!("the colours are {a}"),
            false => format!("the colours of A are {a}, of B {b}"),
        });
    }
    let beside = pair.channels[pair.light().count()..].iter();
    let beside: Vec<String> = beside.map(|channel| channel.name.clone()).collect();
    if !beside.is_empty() {
        notes.push(format!("not of light, and so compared but not tested: {}", listed(&beside)));
    }
    for (name, left_out) in SIDES.into_iter().zip(&pair.left_out) {
        if !left_out.is_empty() {
            notes.push(format!("only {name} has {}: left out", listed(left_out)));
        }
    }
    if comparison.noise == [Noise::Unknown; 2] {
        notes.push(
            "neither side states errors (channels error.*) or is several pictures: noise and bias cannot be told apart"
                .to_owned(),
        );
    }
    for (i, (first, a)) in pictures.iter().enumerate() {
        for (second, b) in &pictures[i + 1..] {
            let same = |name: &str| a.attribute(name).is_some_and(|value| b.attribute(name) == Some(value));
            if ["abbe.sceneHash", "abbe.seed", "abbe.sampler"].iter().all(|name| same(name)) {
                notes.push(format!(
                    "{first} and {second} are renders of one scene with one seed: they share their noise, so the tests \
                     say little"
                ));
            }
        }
    }
    for (label, Channels { layout, .. }) in pictures {
        if !layout.other_parts.is_empty() {
            let parts = layout.other_parts.join(", ");
            notes.push(format!("{label} is the first part of its file; it also has {parts}"));
        }
    }
    notes.extend(settings_apart(pictures));
    notes
}

/// What else than noise makes pictures differ, by what their files say of how they were made.
fn settings_apart(pictures: &[(String, &Channels)]) -> Vec<String> {
    let [(of_first, first), others @ ..] = pictures else { return Vec::new() };
    let settings = [
        ("abbe.observer", "the observers differ", "the same light has other X, Y and Z"),
        (
            "abbe.wavelengthRange",
            "the ranges of wavelengths differ",
            "light beyond one of them is in the other alone",
        ),
    ];
    let apart = |(name, what, so)| {
        let own = first.attribute(name)?;
        let differs =
            |(_, picture): &&(String, &Channels)| picture.attribute(name).is_some_and(|of| of != own);
        let (label, other) = others.iter().find(differs)?;
        let other = other.attribute(name)?;
        Some(format!("{what} ({of_first}: {own}, {label}: {other}), so {so}"))
    };
    settings.into_iter().filter_map(apart).collect()
}
