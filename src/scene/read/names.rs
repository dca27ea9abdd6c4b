//! Names: which was probably meant, and which exist in Mitsuba 3 but not here.

use super::super::plugins::{
    bsdfs, films, filters, integrators, lights, media, phases, samplers, sensors, shapes, textures,
    textures::volumes,
};
use super::super::source::{Place, SceneError};
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

/// The plugins that can be read, by class.
pub(in crate::scene) fn plugins(class: Class) -> Vec<&'static str> {
    let names: &[&str] = match class {
        Class::Integrator => integrators::NAMES,
        Class::Sensor => sensors::NAMES,
        Class::Film => films::NAMES,
        Class::Sampler => samplers::NAMES,
        Class::Filter => filters::NAMES,
        Class::Shape => return shapes::names(),
        Class::Bsdf => bsdfs::NAMES,
        Class::Emitter => lights::NAMES,
        Class::Medium => media::NAMES,
        Class::Spectrum => textures::NAMES,
        Class::Phase => phases::NAMES,
        Class::Volume => volumes::NAMES,
        Class::Scene => &[],
    };
    names.to_vec()
}

/// Whether what a plugin of class [`Class::Spectrum`] describes varies over surfaces.
pub(in crate::scene) fn is_texture(plugin: &str) -> bool {
    textures::TEXTURES.contains(&plugin)
}

/// The class that has a plugin of this name, here or in Mitsuba 3, for an object with these parameters.
pub(in crate::scene) fn class_of<'a>(
    plugin: &str,
    mut parameters: impl Iterator<Item = &'a str>,
) -> Option<Class> {
    // The one name that two classes share: the spectrum cannot be without values.
    if plugin == "regular" {
        let values = parameters.any(|name| name == "values");
        return Some(if values { Class::Spectrum } else { Class::Sampler });
    }
    let classes = || Class::ELEMENTS.iter().map(|&(_, class)| class);
    let here = classes().find(|&class| plugins(class).contains(&plugin));
    here.or_else(|| classes().find(|&class| mitsuba_plugins(class).contains(&plugin)))
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

/// Plugins of Mitsuba 3.9 that are not here.
pub(in crate::scene) fn mitsuba_plugins(class: Class) -> &'static [&'static str] {
    match class {
        Class::Integrator => &["stokes", "time_gated_path", "volprim_rf_basic"],
        Class::Shape => &["ellipsoids", "ellipsoidsmesh", "blender"],
        Class::Bsdf => {
            &["circular", "hair", "measured", "measured_polarized", "polarizer", "pplastic", "retarder"]
        }
        Class::Emitter => &["timed_sunsky"],
        Class::Scene
        | Class::Sensor
        | Class::Film
        | Class::Medium
        | Class::Phase
        | Class::Spectrum
        | Class::Volume
        | Class::Sampler
        | Class::Filter => &[],
    }
}

#[cfg(test)]
mod tests;
