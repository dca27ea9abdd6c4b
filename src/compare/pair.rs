//! Which channels of two sides are set against one another. A side is one picture, or several of one scene.

use super::flip::Rgb;
use super::noise::{Noise, Stored};
use crate::output::Colour;
use crate::output::exr::Channels;
use crate::scene::description::AovKind;
use crate::spectrum::colour::{Xyz, rec709_to_xyz};
use std::collections::BTreeSet;
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
    /// Its name in both files, without the layer where they have it in different ones.
    pub name: String,
    /// Whether it is of light. What tells of the scene or of the render is compared and not tested.
    pub is_light: bool,
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
    /// The channels that both files have, those of light first.
    pub channels: Vec<Channel<'a>>,
    /// What the colours are, and where in `channels` they stand; `None` for files without any.
    pub colour: Option<(Colour, Vec<usize>)>,
    /// Layers that the colours of each side are of; empty where they are of none.
    pub layers: [String; 2],
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
        let light = [first_a, first_b].map(light_names);
        let differ = |[light_a, light_b]: [Vec<String>; 2]| {
            Err(Mismatch::Channels([(label_a, light_a), (label_b, light_b)]))
        };
        let Some(colours) = colours([&light[0], &light[1]]) else { return differ(light.map(colours_or_all)) };
        let names = sides.map(measured_names);
        let is_colour = |name: &String| colours.names.iter().flatten().any(|colour| colour == name);
        let is_common = |name: &&String| names[1].contains(name) && !is_colour(name);
        let channel = |name: &str, [of_a, of_b]: [&String; 2]| {
            Some(Channel {
                name: name.to_owned(),
                is_light: light[0].contains(of_a) && light[1].contains(of_b),
                a: Measurement::of(a, of_a)?,
                b: Measurement::of(b, of_b)?,
            })
        };
        // Colours come first, and in their usual order.
        let coloured =
            colours.told.iter().enumerate().filter_map(|(place, told)| {
                channel(told, [&colours.names[0][place], &colours.names[1][place]])
            });
        let others = names[0].iter().filter(is_common).filter_map(|name| channel(name, [name, name]));
        let mut channels: Vec<Channel> = coloured.chain(others).collect();
        channels.sort_by_key(|channel| !channel.is_light);
        if !channels.first().is_some_and(|channel| channel.is_light) {
            return differ(light);
        }
        let left_out = [0, 1].map(|side| {
            let is_alone = |name: &&String| !names[1 - side].contains(name) && !is_colour(name);
            names[side].iter().filter(is_alone).cloned().collect()
        });
        let count = colours.told.len();
        let colour = (count > 0).then(|| (kind(count, &colours.told[0]), (0..count).collect()));
        let layers = colours.layers;
        Ok(Self { width: first_a.width, height: first_a.height, channels, colour, layers, left_out })
    }

    /// The channels of light.
    pub fn light(&self) -> impl Iterator<Item = &Channel<'a>> {
        self.channels.iter().take_while(|channel| channel.is_light)
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

    /// Whether a pixel can be compared: all pictures have finite values and errors of it in every channel of
    /// light.
    pub fn is_good(&self, pixel: usize) -> bool {
        self.light().all(|channel| channel.a.is_good(pixel) && channel.b.is_good(pixel))
    }

    /// Whether a picture of A has a value that is not finite there; whether one of B has.
    pub fn is_bad(&self, pixel: usize) -> [bool; 2] {
        [
            self.light().any(|channel| !channel.a.values[pixel].is_finite()),
            self.light().any(|channel| !channel.b.values[pixel].is_finite()),
        ]
    }
}

/// Several pictures of one side must have one size, the same channels, and noise of their own.
fn check_alike(side: usize, pictures: &[Channels], first: &Channels) -> Result<(), Mismatch> {
    let label = |index| label(side, index, pictures.len());
    for (index, picture) in pictures.iter().enumerate().skip(1) {
        check_sizes([(&label(0), first), (&label(index), picture)])?;
        let names = [first, picture].map(light_names);
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

/// What all pictures of a side hold, but for what belongs to another channel or to the render.
fn measured_names(pictures: &[Channels]) -> Vec<String> {
    let is_measured = |name: &str| !name.starts_with("error.") && name != "samples";
    let [first, others @ ..] = pictures else { return Vec::new() };
    let names = first.channels.iter().map(|(name, _)| name);
    let is_common = |name: &&String| others.iter().all(|other| other.channel(name).is_some());
    names.filter(|name| is_measured(name)).filter(is_common).cloned().collect()
}

/// The channels of light, in the order of the file: those that the file calls so, else those whose names do
/// not say something else.
fn light_names(picture: &Channels) -> Vec<String> {
    let names = measured_names(std::slice::from_ref(picture));
    let is_light: Box<dyn Fn(&str) -> bool> = match picture.light() {
        Some(light) => {
            let light: BTreeSet<&str> = light.collect();
            Box::new(move |name| light.contains(name))
        }
        None => Box::new(|name| may_be_light(name, picture)),
    };
    names.into_iter().filter(|name| is_light(name)).collect()
}

/// Whether the name of a channel leaves open that it is of light: it says neither alpha nor depth, nor what
/// images of the scene are called here and in other programs.
fn may_be_light(name: &str, picture: &Channels) -> bool {
    let (layer, last) = name.split_at(layer_of(name).len());
    let is_depth = last == "Z" && picture.channel(&format!("{layer}X")).is_none();
    let of_scene = |part: &str| {
        let known = AovKind::NAMES.iter().map(|&(known, _)| known).chain(["normal"]);
        known.into_iter().any(|known| known.eq_ignore_ascii_case(part))
    };
    !(last == "A" || is_depth || name.split('.').any(of_scene))
}

/// The layer of a channel, with the dot behind it; empty where it is of none.
fn layer_of(name: &str) -> &str {
    name.rfind('.').map_or("", |dot| &name[..=dot])
}

/// A colour of linear Rec. 709 for [`super::flip`].
pub(super) fn rec709(xyz: Xyz) -> Rgb {
    crate::spectrum::colour::xyz_to_rec709(xyz)
}

/// The colours that two sides have in common.
#[derive(Default)]
struct Colours {
    /// Their channels of each side.
    names: [Vec<String>; 2],
    /// What they are called in what is told.
    told: Vec<String>,
    /// The layer of each side, without its dot.
    layers: [String; 2],
}

/// The channels of light that are the colours of both sides: those of no layer, else of the first layer that
/// has any, or of the layer that the other side has. No channels where neither side has colours; `None` where
/// one side has colours of another kind than the other, or alone.
fn colours(names: [&[String]; 2]) -> Option<Colours> {
    let found = names.map(coloured_layers);
    let (first_a, first_b) = match found.each_ref().map(|layers| layers.first()) {
        [None, None] => return Some(Colours::default()),
        [Some(a), Some(b)] => (*a, *b),
        _ => return None,
    };
    let [a, b] = match () {
        () if found[1].contains(&first_a) => [first_a; 2],
        () if found[0].contains(&first_b) => [first_b; 2],
        () if first_a.1 == first_b.1 => [first_a, first_b],
        () => return None,
    };
    let named = |layer: &str| a.1.iter().map(|name| format!("{layer}{name}")).collect::<Vec<_>>();
    let told = named(if a.0 == b.0 { a.0 } else { "" });
    let layers = [a.0, b.0].map(|layer| layer.trim_end_matches('.').to_owned());
    Some(Colours { names: [named(a.0), named(b.0)], told, layers })
}

/// The layers that have colours, with what these are called, those of no layer first. The kind is told from
/// the names.
fn coloured_layers(names: &[String]) -> Vec<(&str, &'static [&'static str])> {
    const SETS: [&[&str]; 3] = [&["R", "G", "B"], &["X", "Y", "Z"], &["Y"]];
    let mut layers: Vec<&str> = names.iter().map(|name| layer_of(name)).collect();
    layers.sort_by_key(|layer| !layer.is_empty());
    layers.dedup();
    let has = |layer: &str, name: &str| names.iter().any(|known| *known == format!("{layer}{name}"));
    let set = |layer: &str| SETS.into_iter().find(|set| set.iter().all(|name| has(layer, name)));
    layers.into_iter().filter_map(|layer| Some((layer, set(layer)?))).collect()
}

/// Those names of channels of light that are colours, in their usual order; all where there are none.
fn colours_or_all(names: Vec<String>) -> Vec<String> {
    let layers = coloured_layers(&names);
    let named = layers.iter().flat_map(|(layer, set)| set.iter().map(move |name| format!("{layer}{name}")));
    let colours: Vec<String> = named.collect();
    if colours.is_empty() { names } else { colours }
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
                "error: the pictures measure different things: {a} has {}, and {b} has {}\n\
                 help: nothing is converted: render both with the same pixel_format of the film, which is rgb (R, G, B), \
                 xyz (X, Y, Z) or luminance (Y)",
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
        count if count > MOST => format!("{} and {} more", names[..MOST].join(", "), count - MOST),
        _ => names.join(", "),
    }
}
