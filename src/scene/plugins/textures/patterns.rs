//! What textures that are computed are made of.

use crate::scene::description::{PatternSpace, SpectrumKind, SpectrumSource};
use crate::scene::plugins::fields::{Float, Integer};
use crate::scene::plugins::{Field, Parameter, Range, Simple, Takes, float, integer};
use crate::scene::read::Query;
use crate::scene::read::spectra::{self, Use};
use crate::scene::source::SceneError;
use crate::scene::write::{Node, Writer};
use crate::texture::{self, Veins};

/// What the pattern's values stand for, from the least to the greatest. Two of them have defaults.
const COLOURS: [&str; 8] = ["color0", "color1", "color2", "color3", "color4", "color5", "color6", "color7"];

/// Octaves of noise, with how many there are where the file says nothing.
pub struct Octaves(pub u32);

impl Octaves {
    const GAIN: Simple<Float> = float("gain", 0.5, "how strong each octave is beside the one before")
        .within(Range::between(0.0, 1.0))
        .said("Each octave is {} times as strong as the one before", "expected a factor from 0 to 1");
    const SEED: Simple<Integer<u64>> = integer("seed", 0, [0, i64::MAX], "what the noise follows from");

    fn count(&self) -> Simple<Integer<u32>> {
        integer("octaves", self.0, [1, i64::from(texture::Octaves::MOST)], "number of octaves of noise")
    }
}

impl Field for Octaves {
    type Value = texture::Octaves;

    fn parameters(&self) -> Vec<Parameter> {
        [self.count().parameters(), Self::GAIN.parameters(), Self::SEED.parameters()].concat()
    }

    fn read(&self, query: &Query<'_>) -> Option<texture::Octaves> {
        let (count, gain, seed) =
            (self.count().read(query)?, Self::GAIN.read(query)?, Self::SEED.read(query)?);
        Some(texture::Octaves { count, gain, seed })
    }

    fn write(&self, node: Node, octaves: &texture::Octaves, writer: &mut Writer) -> Node {
        let node = Self::GAIN.write(self.count().write(node, &octaves.count, writer), &octaves.gain, writer);
        Self::SEED.write(node, &octaves.seed, writer)
    }
}

/// Veins or rings that noise bends, with the number of its octaves.
pub struct Bent(pub u32);

impl Bent {
    const TURBULENCE: Simple<Float> = float("turbulence", 2.0, "by how many periods they are bent");
}

impl Field for Bent {
    type Value = Veins;

    fn parameters(&self) -> Vec<Parameter> {
        [Octaves(self.0).parameters(), Self::TURBULENCE.parameters()].concat()
    }

    fn read(&self, query: &Query<'_>) -> Option<Veins> {
        Some(Veins { octaves: Octaves(self.0).read(query)?, strength: Self::TURBULENCE.read(query)? })
    }

    fn write(&self, node: Node, veins: &Veins, writer: &mut Writer) -> Node {
        let node = Octaves(self.0).write(node, &veins.octaves, writer);
        Self::TURBULENCE.write(node, &veins.strength, writer)
    }
}

/// What a pattern is computed from, with the transform of it.
pub struct Space;

impl Field for Space {
    type Value = PatternSpace;

    fn parameters(&self) -> Vec<Parameter> {
        let of = |name, takes, doc| Parameter { doc, ..Parameter::new(name, takes) };
        let space = of(
            "space",
            Takes::Choice(vec!["world", "uv"]),
            "whether it lies in space, sticking to what moves, or on u and v",
        );
        vec![
            Parameter { default: "world".to_owned(), ..space },
            of("to_world", Takes::Transform, "where it stands in space"),
            of("to_uv", Takes::Transform, "where it lies on u and v"),
        ]
    }

    fn read(&self, query: &Query<'_>) -> Option<PatternSpace> {
        Some(space(query))
    }

    fn write(&self, node: Node, space: &PatternSpace, _: &mut Writer) -> Node {
        match space {
            PatternSpace::World(to_world) => node.text("space", "world").transform("to_world", to_world),
            PatternSpace::Uv(to_uv) => node.text("space", "uv").transform("to_uv", to_uv),
        }
    }
}

/// Two colours or more.
pub struct Colours;

impl Field for Colours {
    type Value = Vec<SpectrumSource>;

    fn parameters(&self) -> Vec<Parameter> {
        let colour = |(index, name): (usize, &'static str)| Parameter {
            default: ["0", "1"].get(index).map_or(String::new(), |&default| default.to_owned()),
            doc: if index == 0 { "spectrum or texture at the least value" } else { "at the next" },
            ..Parameter::new(name, Takes::Spectrum(Use::Part))
        };
        COLOURS.into_iter().enumerate().map(colour).collect()
    }

    fn read(&self, query: &Query<'_>) -> Option<Vec<SpectrumSource>> {
        colours(query)
    }

    fn write(&self, node: Node, colours: &Vec<SpectrumSource>, _: &mut Writer) -> Node {
        COLOURS.into_iter().zip(colours).fold(node, |node, (name, colour)| node.spectrum(name, colour))
    }
}

/// Refuses values that are spread over no range.
pub fn ascending(query: &Query<'_>, range: [f64; 2]) {
    if range[0] < range[1] {
        return;
    }
    let name = if query.has("low") { "low" } else { "high" };
    query.error(
        SceneError::at(
            &query.place(name),
            format!("The values of {} begin at {} and end at {}", query.title(), range[0], range[1]),
            "expected a low that is below high",
        )
        .with_remedy("interpolate false makes a sharp edge halfway between them"),
    );
}

/// Whether it is a pattern that is looked up by the place in space.
pub fn is_in_space(source: &SpectrumSource) -> bool {
    matches!(&source.kind, SpectrumKind::Procedural(procedural) if matches!(procedural.space, PatternSpace::World(_)))
}

fn colours(query: &Query<'_>) -> Option<Vec<SpectrumSource>> {
    let last = COLOURS.iter().rposition(|name| query.has(name)).unwrap_or(1).max(1);
    if let Some(missing) = COLOURS[..=last].iter().skip(2).find(|name| !query.has(name)) {
        query.error(SceneError::at(
            &query.place(COLOURS[last]),
            format!("There is a \"{}\" but no \"{missing}\"", COLOURS[last]),
            "expected colours that are numbered without a gap",
        ));
    }
    let defaults = [0.0, 1.0];
    // All of them, so that each that is wrong is reported.
    let read: Vec<_> = COLOURS[..=last]
        .iter()
        .enumerate()
        .map(|(index, name)| spectra::part(query, name, defaults[index.min(1)]))
        .collect();
    read.into_iter().collect()
}

fn space(query: &Query<'_>) -> PatternSpace {
    let in_uv = query.choice("space", &[("world", false), ("uv", true)], false).unwrap_or(false);
    let (fits, other, remedy) = match in_uv {
        true => ("to_uv", "to_world", "leave out space: a pattern in space is moved by to_world"),
        false => ("to_world", "to_uv", "<string name=\"space\" value=\"uv\"/> lays the pattern on u and v"),
    };
    if let Some(entry) = query.entry(other) {
        let problem =
            format!("\"{other}\" means nothing to a pattern in {}", if in_uv { "u and v" } else { "space" });
        let error = SceneError::at(&entry.place, problem, format!("expected \"{fits}\""));
        query.error(error.with_remedy(remedy));
    }
    let transform = query.transform(fits);
    if in_uv { PatternSpace::Uv(transform) } else { PatternSpace::World(transform) }
}
