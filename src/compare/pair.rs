//! Which channels of two files are set against one another.

use super::flip::Rgb;
use crate::output::Colour;
use crate::output::exr::Channels;
use crate::spectrum::colour::{Xyz, rec709_to_xyz};
use std::fmt;

/// One channel as one file has it.
#[derive(Clone, Copy, Debug)]
pub struct Measurement<'a> {
    pub values: &'a [f32],
    /// Standard error of each value.
    pub errors: Option<&'a [f32]>,
    /// Half a unit in the last place over the value: what storing it may have changed, at most.
    pub rounding: f64,
}

/// A channel of both files.
#[derive(Clone, Debug)]
pub struct Channel<'a> {
    pub name: String,
    pub a: Measurement<'a>,
    pub b: Measurement<'a>,
}

/// Two files of equal size and all that both have measured.
#[derive(Clone, Debug)]
pub struct Pair<'a> {
    pub width: usize,
    pub height: usize,
    pub channels: Vec<Channel<'a>>,
    /// What the colours are, and where in `channels` they stand; `None` for files without any.
    pub colour: Option<(Colour, Vec<usize>)>,
    /// Channels that only one file has: not compared.
    pub left_out: [Vec<String>; 2],
    /// Replicates behind the errors of each file, where it says so.
    pub replicates: [Option<u32>; 2],
    /// Degrees of freedom of each file's errors; infinite where it does not say.
    pub degrees: [f64; 2],
}

/// Why two files cannot be compared.
#[derive(Clone, Debug, PartialEq)]
pub enum Mismatch {
    Size([[usize; 2]; 2]),
    Channels([Vec<String>; 2]),
}

/// Channels that tell of the render and the scene, not of light.
fn is_measured(name: &str) -> bool {
    let beside = ["error.", "albedo.", "normal."];
    !(beside.iter().any(|prefix| name.starts_with(prefix)) || ["samples", "depth"].contains(&name))
}

impl<'a> Pair<'a> {
    /// What `a` and `b`, the reference, have in common. Their colours must be of one kind; channels beside them that only
    /// one file has are left out.
    pub fn new(a: &'a Channels, b: &'a Channels) -> Result<Self, Mismatch> {
        let sizes = [a, b].map(|side| [side.width, side.height]);
        if sizes[0] != sizes[1] {
            return Err(Mismatch::Size(sizes));
        }
        let names = [a, b].map(|side| -> Vec<String> {
            side.channels.iter().map(|(name, _)| name.clone()).filter(|name| is_measured(name)).collect()
        });
        let colours = [0, 1].map(|side| colours(&names[side]));
        let common: Vec<String> = names[0].iter().filter(|name| names[1].contains(name)).cloned().collect();
        if colours[0] != colours[1] || common.is_empty() {
            return Err(Mismatch::Channels(names));
        }
        let left_out = [0, 1].map(|side| {
            names[side].iter().filter(|&name| !names[1 - side].contains(name)).cloned().collect()
        });
        let mut channels: Vec<Channel> = common
            .into_iter()
            .filter_map(|name| {
                let (a, b) = (measurement(a, &name)?, measurement(b, &name)?);
                Some(Channel { name, a, b })
            })
            .collect();
        // Colours come first, and in their usual order.
        let [colours, _] = colours;
        let wanted = colours.map_or(Vec::new(), |(_, names)| names);
        channels.sort_by_key(|channel| {
            wanted.iter().position(|name| *name == channel.name).unwrap_or(wanted.len())
        });
        let colour =
            (!wanted.is_empty()).then(|| (kind(wanted.len(), &wanted[0]), (0..wanted.len()).collect()));
        let replicates = [a, b].map(|side| side.attribute("abbe.replicates")?.parse().ok());
        let degrees = [0, 1].map(|side| {
            let stated = [a, b][side].attribute("abbe.degreesOfFreedom").and_then(|text| text.parse().ok());
            let own = || replicates[side].map(|count: u32| f64::from(count.saturating_sub(1)));
            stated.or_else(own).filter(|degrees| *degrees > 0.0).unwrap_or(f64::INFINITY)
        });
        Ok(Self { width: a.width, height: a.height, channels, colour, left_out, replicates, degrees })
    }

    /// The colour of a pixel of both files. `None` for files without colours.
    pub fn xyz(&self, pixel: usize) -> Option<[Xyz; 2]> {
        let (kind, places) = self.colour.as_ref()?;
        let value = |place: usize, first: bool| {
            let channel = &self.channels[place];
            f64::from(if first { channel.a.values[pixel] } else { channel.b.values[pixel] })
        };
        Some([true, false].map(|first| match (kind, places.as_slice()) {
            (Colour::Rec709, &[r, g, b]) => rec709_to_xyz([r, g, b].map(|place| value(place, first))),
            (Colour::Xyz, &[x, y, z]) => [x, y, z].map(|place| value(place, first)).into(),
            // Luminance alone is taken as that of the white of Rec. 709.
            (_, places) => rec709_to_xyz([value(places[0], first); 3]),
        }))
    }

    /// The channel that stands for all where one has to: luminance, green, or the first.
    pub fn middle(&self) -> usize {
        match &self.colour {
            Some((_, places)) => places[places.len() / 2],
            None => 0,
        }
    }

    /// Whether a pixel can be compared: both files have finite values and errors of it in every channel.
    pub fn is_good(&self, pixel: usize) -> bool {
        self.channels.iter().all(|channel| channel.a.is_good(pixel) && channel.b.is_good(pixel))
    }

    /// Whether the first file has a value that is not finite there; whether the second has.
    pub fn is_bad(&self, pixel: usize) -> [bool; 2] {
        [
            self.channels.iter().any(|channel| !channel.a.values[pixel].is_finite()),
            self.channels.iter().any(|channel| !channel.b.values[pixel].is_finite()),
        ]
    }
}

impl Measurement<'_> {
    fn is_good(&self, pixel: usize) -> bool {
        self.values[pixel].is_finite() && self.errors.is_none_or(|errors| errors[pixel].is_finite())
    }
}

/// A colour of linear Rec. 709 for [`super::flip`].
pub(super) fn rec709(xyz: Xyz) -> Rgb {
    crate::spectrum::colour::xyz_to_rec709(xyz)
}

fn measurement<'a>(side: &'a Channels, name: &str) -> Option<Measurement<'a>> {
    // 11 and 24 significant bits.
    let rounding = if side.half.iter().any(|half| half == name) { 2f64.powi(-11) } else { 2f64.powi(-24) };
    Some(Measurement {
        values: side.channel(name)?,
        errors: side.channel(&format!("error.{name}")),
        rounding,
    })
}

/// The channels that are the picture's colours: those of no layer, else of the first layer that has any. The kind is told
/// from the names.
fn colours(names: &[String]) -> Option<(usize, Vec<String>)> {
    let mut prefixes: Vec<&str> =
        names.iter().map(|name| name.rfind('.').map_or("", |dot| &name[..=dot])).collect();
    prefixes.sort_by_key(|prefix| !prefix.is_empty());
    prefixes.dedup();
    let sets: [&[&str]; 3] = [&["R", "G", "B"], &["X", "Y", "Z"], &["Y"]];
    let found = |prefix: &str, set: &[&str]| -> Option<Vec<String>> {
        let full: Vec<String> = set.iter().map(|name| format!("{prefix}{name}")).collect();
        full.iter().all(|name| names.contains(name)).then_some(full)
    };
    let all = prefixes.iter().flat_map(|prefix| sets.iter().map(move |set| found(prefix, set)));
    all.flatten().next().map(|names| (names.len(), names))
}

fn kind(count: usize, first: &str) -> Colour {
    match (count, first.chars().last()) {
        (3, Some('R')) => Colour::Rec709,
        (3, _) => Colour::Xyz,
        _ => Colour::Luminance,
    }
}

impl fmt::Display for Mismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Size([[wa, ha], [wb, hb]]) => write!(
                f,
                "error: the pictures differ in size: A has {wa}×{ha} pixels, B {wb}×{hb}\n\
                 help: render both with the same --size"
            ),
            Self::Channels([a, b]) => write!(
                f,
                "error: the pictures measure different things: A has {}, B {}\n\
                 help: render both with the same film: its pixel_format decides between R G B, X Y Z and Y",
                listed(a),
                listed(b)
            ),
        }
    }
}

/// The first names of a list that may be long.
pub fn listed(names: &[String]) -> String {
    const MOST: usize = 8;
    match names.len() {
        0 => "no channels of light".to_owned(),
        count if count > MOST => format!("{} and {} more", names[..MOST].join(" "), count - MOST),
        _ => names.join(" "),
    }
}
