//! Hints in messages: which name was probably meant, and what to do without a plugin that only Mitsuba 3 has.

use super::super::source::{Place, SceneError};
use super::names::{mitsuba_plugins, plugins};
use super::tree::Class;

/// The known name that a mistyped one is most like, if any is like it.
pub(in crate::scene) fn nearest<'a>(wrong: &str, known: &[&'a str]) -> Option<&'a str> {
    let lower = wrong.to_lowercase();
    let best = known
        .iter()
        .map(|&name| (strsim::jaro_winkler(&lower, &name.to_lowercase()), name))
        // The first of equals, so that the answer does not depend on anything else.
        .fold((0.0, ""), |best, next| if next.0 > best.0 { next } else { best });
    let edits = strsim::damerau_levenshtein(&lower, &best.1.to_lowercase());
    let plausible = best.0 > 0.84 || edits <= 1 + wrong.chars().count() / 5;
    (plausible && !best.1.is_empty()).then_some(best.1)
}

/// Names that are listed.
const MOST: usize = 12;

/// Names in a row, the first dozen of them.
pub(in crate::scene) fn listing(names: &[&str]) -> String {
    let mut text = names.iter().take(MOST).copied().collect::<Vec<_>>().join(", ");
    if names.len() > MOST {
        text.push_str(&format!(" and {} more", names.len() - MOST));
    }
    text
}

/// "a, b or c".
pub(in crate::scene) fn either(names: &[&str]) -> String {
    match names {
        [] => String::new(),
        [only] => (*only).to_owned(),
        [first @ .., last] => format!("{} or {last}", first.join(", ")),
    }
}

/// The message about a plugin that its class does not have.
pub(in crate::scene) fn unknown_plugin(class: Class, plugin: &str, place: &Place) -> SceneError {
    let word = class.word();
    let known = plugins(class);
    let expected = format!("expected {}", if known.len() > MOST { listing(&known) } else { either(&known) });
    if mitsuba_plugins(class).contains(&plugin) {
        let problem = super::query::capital(&format!("{word} \"{plugin}\" is not supported"));
        let error = SceneError::at(place, problem, expected);
        return match instead(class, plugin) {
            Some(remedy) => error.with_remedy(remedy),
            None => error,
        };
    }
    let error = SceneError::at(place, format!("There is no {word} \"{plugin}\""), expected);
    if let Some(remedy) = formerly(class, plugin) {
        return error.with_remedy(remedy);
    }
    let elsewhere =
        Class::ELEMENTS.iter().find(|(_, other)| *other != class && plugins(*other).contains(&plugin));
    match (nearest(plugin, &known), elsewhere) {
        (_, Some((other, _))) => error.with_remedy(format!("did you mean <{other} type=\"{plugin}\">?")),
        (Some(near), None) => error.with_remedy(format!("did you mean \"{near}\"?")),
        (None, None) => error,
    }
}

/// What to do without a plugin that Mitsuba 3 has.
fn instead(class: Class, plugin: &str) -> Option<&'static str> {
    Some(match (class, plugin) {
        (Class::Integrator, "stokes") => {
            "write the integrator within it by itself: light is not polarised here"
        }
        (Class::Integrator, _) => "use \"path\": its picture is the same in expectation",
        (Class::Bsdf, "pplastic") => "use \"plastic\": light is not polarised here",
        (Class::Bsdf, "polarizer" | "retarder" | "circular" | "measured_polarized") => {
            "light is not polarised here"
        }
        _ => return None,
    })
}

/// What has taken the place of a plugin that Mitsuba had before version 2.
fn formerly(class: Class, plugin: &str) -> Option<&'static str> {
    Some(match (class, plugin) {
        (Class::Bsdf, "roughdiffuse") => "Mitsuba 3 has none either: \"diffuse\" is the most like it",
        (Class::Bsdf, "phong" | "ward") => {
            "Mitsuba 3 has none either: \"roughplastic\" and \"roughconductor\" are the most like it"
        }
        (Class::Bsdf, "coating" | "roughcoating") => {
            "Mitsuba 3 has none either: \"plastic\" and \"roughplastic\" are coats on a diffuse base"
        }
        (Class::Bsdf, "mixturebsdf") => "use \"blendbsdf\", which mixes two",
        _ => return None,
    })
}

/// What has taken the place of a property that Mitsuba had before version 2.
pub(in crate::scene) fn formerly_property(class: Class, name: &str) -> Option<&'static str> {
    Some(match (class, name) {
        (Class::Medium, "sigma_a" | "sigma_s" | "sigmaA" | "sigmaS") => {
            "Mitsuba 3 has sigma_t = sigma_a + sigma_s, and albedo = sigma_s / sigma_t"
        }
        (Class::Integrator, "strict_normals" | "strictNormals") => "leave it out, as for Mitsuba 3",
        (Class::Bsdf, "ext_eta" | "extEta") => "give eta and k over this index, and leave it out",
        _ => return None,
    })
}

/// The message about a plugin that no class has.
pub(in crate::scene) fn no_such_plugin(plugin: &str, place: &Place) -> SceneError {
    let known: Vec<&str> = Class::ELEMENTS
        .iter()
        .flat_map(|&(_, class)| plugins(class))
        .chain(["spectrum", "rgb", "ref"])
        .collect();
    let problem = format!("There is no plugin \"{plugin}\"");
    let error = SceneError::at(place, problem, "expected the name of a plugin such as sphere or diffuse");
    match nearest(plugin, &known) {
        Some(near) => error.with_remedy(format!("did you mean \"{near}\"?")),
        None => error,
    }
}

#[cfg(test)]
mod tests;
