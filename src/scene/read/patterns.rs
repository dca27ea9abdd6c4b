//! Textures that are computed: `noise`, `turbulence`, `marble`, `wood`, `bands`.

use super::super::description::{PatternSpace, ProceduralSource, SpectrumKind, SpectrumSource};
use super::super::source::SceneError;
use super::query::Query;
use super::spectra;
use crate::texture::{Octaves, Pattern, Veins};
use std::sync::Arc;

/// The plugins of this file.
pub(super) const PATTERNS: [&str; 5] = ["noise", "turbulence", "marble", "wood", "bands"];

/// What the pattern's values stand for, from the least to the greatest. Two of them have defaults.
pub(in crate::scene) const COLOURS: [&str; 8] =
    ["color0", "color1", "color2", "color3", "color4", "color5", "color6", "color7"];

/// A texture of this file; `None` where it is none of them, or wrong, which is reported.
pub(in crate::scene) fn kind(query: &Query<'_>) -> Option<SpectrumKind> {
    let pattern = match query.object.plugin.as_str() {
        "noise" => Pattern::Noise(octaves(query, 1)),
        "turbulence" => Pattern::Turbulence(octaves(query, 6)),
        "marble" => Pattern::Marble(veins(query, 6, 2.0)),
        "wood" => Pattern::Wood(veins(query, 3, 2.0)),
        "bands" => Pattern::Bands,
        _ => return None,
    };
    let plugin = &query.object.plugin;
    query
        .reader
        .extension(&query.object.plugin_place, format!("texture \"{plugin}\": a pattern that is computed"));
    let space = space(query);
    let period = query.positive("period", 1.0);
    let range = [query.float("low").unwrap_or(0.0), query.float("high").unwrap_or(1.0)];
    if range[0] >= range[1] {
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
    let mixed = query.boolean("interpolate", pattern != Pattern::Bands);
    let colours = colours(query)?;
    Some(SpectrumKind::Procedural(Arc::new(ProceduralSource {
        pattern,
        space,
        period,
        colours,
        range,
        mixed,
    })))
}

/// Whether it is a pattern that is looked up by the place in space.
pub(in crate::scene) fn is_in_space(source: &SpectrumSource) -> bool {
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

fn octaves(query: &Query<'_>, default: u32) -> Octaves {
    let count = query.integer("octaves", 1, i64::from(Octaves::MOST)).map_or(default, |count| count as u32);
    let gain = query.float("gain").unwrap_or(0.5);
    if !(0.0..=1.0).contains(&gain) {
        let problem = format!("Each octave is {gain} times as strong as the one before");
        query.error(SceneError::at(&query.place("gain"), problem, "expected a factor from 0 to 1"));
    }
    let seed = query.integer("seed", 0, i64::MAX).unwrap_or(0) as u64;
    Octaves { count, gain, seed }
}

fn veins(query: &Query<'_>, octaves: u32, strength: f64) -> Veins {
    Veins { octaves: self::octaves(query, octaves), strength: query.float("turbulence").unwrap_or(strength) }
}
