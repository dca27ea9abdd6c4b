//! The names of plugins by class: those that can be read, and those that Mitsuba 3 has besides.

use super::super::plugins::{
    bsdfs, films, filters, integrators, lights, media, phases, samplers, sensors, shapes, textures,
    textures::volumes,
};
use super::tree::Class;

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
    // The names that two classes share: the spectrum cannot be without values, the BSDF not without a file.
    match plugin {
        "regular" => {
            let values = parameters.any(|name| name == "values");
            return Some(if values { Class::Spectrum } else { Class::Sampler });
        }
        "measured" => {
            let file = parameters.any(|name| name == "filename");
            return Some(if file { Class::Bsdf } else { Class::Spectrum });
        }
        _ => {}
    }
    let classes = || Class::ELEMENTS.iter().map(|&(_, class)| class);
    let here = classes().find(|&class| plugins(class).contains(&plugin));
    here.or_else(|| classes().find(|&class| mitsuba_plugins(class).contains(&plugin)))
}

/// Plugins of Mitsuba 3.9 that are not here.
pub(in crate::scene) fn mitsuba_plugins(class: Class) -> &'static [&'static str] {
    match class {
        Class::Integrator => &["stokes", "time_gated_path", "volprim_rf_basic"],
        Class::Shape => &["ellipsoids", "ellipsoidsmesh", "blender"],
        Class::Bsdf => &["circular", "measured_polarized", "polarizer", "pplastic", "retarder"],
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
