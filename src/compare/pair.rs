//! Which channels of two sides are set against one another. A side is one picture, or several of one scene.

use super::flip::Rgb;
use super::noise::{Noise, Stored};
use crate::output::Colour;
use crate::output::exr::Channels;
use crate::spectrum::colour::{Xyz, rec709_to_xyz};
use std::fmt;

/// One channel as one side has it.
#[derive(Clone, Debug)]
pub struct Measurement<'a> {
    /// Means over the pictures.
    pub values: Vec<f64>,
    /// Where its errors come from.
    pub noise: Noise,
    pub(super) pictures: Vec<Stored<'a>>,
}

/// A channel of both sides.
#[derive(Clone, Debug)]
pub struct Channel<'a> {
    /// Name of the channel, as both files have it.
    pub name: String,
    /// The picture.
    pub a: Measurement<'a>,
    /// Its reference.
    pub b: Measurement<'a>,
}

/// Two sides of equal size and all that both have measured.
#[derive(Clone, Debug)]
pub struct Pair<'a> {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The channels that both files have.
    pub channels: Vec<Channel<'a>>,
    /// What the colours are, and where in `channels` they stand; `None` for files without any.
    pub colour: Option<(Colour, Vec<usize>)>,
    /// Channels that only one side has: not compared.
    pub left_out: [Vec<String>; 2],
}

/// Why two sides cannot be compared. Each picture is named: A, or picture 2 of B.
#[derive(Clone, Debug, PartialEq)]
pub enum Mismatch {
    /// They differ in size: name, and columns and rows of each.
    Size([(String, [usize; 2]); 2]),
    /// They have no channel in common: name, and channels of each.
    Channels([(String, Vec<String>); 2]),
    /// Two pictures of one side hold the same values.
    Twice([String; 2]),
    /// A side has no picture.
    Nothing(&'static str),
}

/// Channels that tell of the render and the scene, not of light.
fn is_measured(name: &str) -> bool {
    let beside = ["error.", "albedo.", "normal."];
    !(beside.iter().any(|prefix| name.starts_with(prefix)) || ["samples", "depth"].contains(&name))
}

/// What a picture is called in messages.
pub(super) fn label(side: usize, index: usize, count: usize) -> String {
    let side = SIDES[side];
    if count == 1 { side.to_owned() } else { format!("picture {} of {side}", index + 1) }
}

pub(super) const SIDES: [&str; 2] = ["A", "B"];

impl<'a> Pair<'a> {
    /// What the pictures `a` and `b`, the reference, have in common. Their colours must be of one kind;
    /// channels beside them that only one side has are left out. Several pictures of a side must measure the
    /// same.
    pub fn new(a: &'a [Channels], b: &'a [Channels]) -> Result<Self, Mismatch> {
        let sides = [a, b];
        let mut firsts = Vec::new();
        for (side, pictures) in sides.into_iter().enumerate() {
            let first = pictures.first().ok_or(Mismatch::Nothing(SIDES[side]))?;
            check_alike(side, pictures, first)?;
            firsts.push((label(side, 0, pictures.len()), first));
        }
        let [(label_a, first_a), (label_b, first_b)] = [firsts[0].clone(), firsts[1].clone()];
        check_sizes([(&label_a, first_a), (&label_b, first_b)])?;
        let names = [first_a, first_b].map(measured_names);
        let colours = [0, 1].map(|side| colours(&names[side]));
        let common: Vec<String> = names[0].iter().filter(|name| names[1].contains(name)).cloned().collect();
        if colours[0] != colours[1] || common.is_empty() {
            let [names_a, names_b] = names;
            return Err(Mismatch::Channels([(label_a, names_a), (label_b, names_b)]));
        }
        let left_out = [0, 1].map(|side| {
            names[side].iter().filter(|&name| !names[1 - side].contains(name)).cloned().collect()
        });
        let mut channels: Vec<Channel> = common
            .into_iter()
            .filter_map(|name| {
                let (a, b) = (Measurement::of(a, &name)?, Measurement::of(b, &name)?);
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
        Ok(Self { width: first_a.width, height: first_a.height, channels, colour, left_out })
    }

    /// The colour of a pixel of both sides. `None` for files without colours.
    pub fn xyz(&self, pixel: usize) -> Option<[Xyz; 2]> {
        let (kind, places) = self.colour.as_ref()?;
        let value = |place: usize, first: bool| {
            let channel = &self.channels[place];
            if first { channel.a.values[pixel] } else { channel.b.values[pixel] }
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

    /// Whether a pixel can be compared: all pictures have finite values and errors of it in every channel.
    pub fn is_good(&self, pixel: usize) -> bool {
        self.channels.iter().all(|channel| channel.a.is_good(pixel) && channel.b.is_good(pixel))
    }

    /// Whether a picture of A has a value that is not finite there; whether one of B has.
    pub fn is_bad(&self, pixel: usize) -> [bool; 2] {
        [
            self.channels.iter().any(|channel| !channel.a.values[pixel].is_finite()),
            self.channels.iter().any(|channel| !channel.b.values[pixel].is_finite()),
        ]
    }
}

/// Several pictures of one side must have one size, the same channels, and noise of their own.
fn check_alike(side: usize, pictures: &[Channels], first: &Channels) -> Result<(), Mismatch> {
    let label = |index| label(side, index, pictures.len());
    for (index, picture) in pictures.iter().enumerate().skip(1) {
        check_sizes([(&label(0), first), (&label(index), picture)])?;
        let names = [first, picture].map(measured_names);
        if names[0] != names[1] {
            let [first, own] = names;
            return Err(Mismatch::Channels([(label(0), first), (label(index), own)]));
        }
        if let Some(earlier) = pictures[..index].iter().position(|other| is_equal(other, picture, &names[0]))
        {
            return Err(Mismatch::Twice([label(earlier), label(index)]));
        }
    }
    Ok(())
}

/// Whether two pictures hold the same in some channels, bit for bit.
fn is_equal(a: &Channels, b: &Channels, names: &[String]) -> bool {
    let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect::<Vec<u32>>();
    names.iter().all(|name| a.channel(name).map(bits) == b.channel(name).map(bits))
}

fn check_sizes(pictures: [(&str, &Channels); 2]) -> Result<(), Mismatch> {
    let sizes = pictures.map(|(label, picture)| (label.to_owned(), [picture.width, picture.height]));
    if sizes[0].1 == sizes[1].1 { Ok(()) } else { Err(Mismatch::Size(sizes)) }
}

/// The channels of light, in the order of the file.
fn measured_names(picture: &Channels) -> Vec<String> {
    picture.channels.iter().map(|(name, _)| name.clone()).filter(|name| is_measured(name)).collect()
}

/// A colour of linear Rec. 709 for [`super::flip`].
pub(super) fn rec709(xyz: Xyz) -> Rgb {
    crate::spectrum::colour::xyz_to_rec709(xyz)
}

/// The channels that are the picture's colours: those of no layer, else of the first layer that has any. The
/// kind is told from the names.
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
            Self::Size([(a, [wa, ha]), (b, [wb, hb])]) => write!(
                f,
                "error: the pictures differ in size: {a} has {wa}×{ha} pixels, {b} {wb}×{hb}\n\
                 help: render both with the same --size"
            ),
            Self::Channels([(a, of_a), (b, of_b)]) => write!(
                f,
                "error: the pictures measure different things: {a} has {}, {b} {}\n\
                 help: render both with the same film: its pixel_format decides between R G B, X Y Z and Y",
                listed(of_a),
                listed(of_b)
            ),
            Self::Twice([first, second]) => write!(
                f,
                "error: {first} and {second} are equal in every pixel: their spread is not that of noise\n\
                 help: render each picture with a seed of its own; give a picture without noise once"
            ),
            Self::Nothing(side) => {
                write!(f, "error: {side} has no picture\nhelp: give one picture at least of each side")
            }
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
