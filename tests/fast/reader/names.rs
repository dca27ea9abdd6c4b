//! Names of plugins: which are read, which Mitsuba 3 has besides, and which are mistyped.

use abbe::scene::{ReadOptions, plugins, read_str};
use std::path::Path;

/// Plugins of Mitsuba 3.9 that abbe does not have, with their elements.
const MISSING: [(&str, &[&str]); 4] = [
    ("integrator", &["stokes", "time_gated_path", "volprim_rf_basic"]),
    ("shape", &["ellipsoids", "ellipsoidsmesh", "blender"]),
    ("bsdf", &["circular", "measured_polarized", "polarizer", "pplastic", "retarder"]),
    ("emitter", &["timed_sunsky"]),
];

/// What reading a scene with one object of a plugin says about it. Where the object is meant to stand is
/// seen to; that it lacks what it cannot be without is no matter.
fn said_of(element: &str, plugin: &str) -> String {
    let object = format!("<{element} type=\"{plugin}\"/>");
    let film = |content: &str| format!("<film type=\"hdrfilm\">{content}</film>");
    let sensor = |content: &str| format!("<sensor type=\"perspective\">{content}</sensor>");
    let within = |content: &str| format!("{}<shape type=\"sphere\">{content}</shape>", sensor(""));
    let medium = |kind: &str, content: &str| {
        within(&format!("<medium name=\"interior\" type=\"{kind}\">{content}</medium>"))
    };
    let scene = match element {
        "sensor" if plugin == "irradiancemeter" => format!("<shape type=\"sphere\">{object}</shape>"),
        "sensor" => object,
        "film" | "sampler" => sensor(&object),
        "rfilter" => sensor(&film(&object)),
        "emitter" if plugin.ends_with("area") => within(&object),
        "medium" => medium(plugin, ""),
        "phase" => medium("homogeneous", &object),
        _ => sensor("") + &object,
    };
    let scene = format!("<scene version=\"3.0.0\">{scene}</scene>");
    let read = read_str(scene, Path::new("scene.xml"), &ReadOptions::default());
    read.map_or_else(|errors| errors.to_string(), |_| String::new())
}

/// Whether a message says that there is no such plugin.
fn refuses(message: &str, element: &str, plugin: &str) -> bool {
    let named = format!("{element} \"{plugin}\"");
    message.to_lowercase().contains(&format!("{named} is not supported"))
        || message.contains(&format!("There is no {named}"))
}

/// The lists are what hints are made of. One that lags behind the reader tells nobody of what there is.
#[test]
fn the_reader_accepts_what_is_declared_and_nothing_that_is_said_to_be_missing() {
    let mut wrong = Vec::new();
    for plugin in plugins() {
        if refuses(&said_of(plugin.element, plugin.name), plugin.element, plugin.name) {
            wrong.push(format!("{} is declared and not read", plugin.name));
        }
    }
    for (element, name) in
        MISSING.iter().flat_map(|(element, names)| names.iter().map(move |name| (element, name)))
    {
        if !said_of(element, name).to_lowercase().contains(&format!("{element} \"{name}\" is not supported"))
        {
            wrong.push(format!("{name} is not said to be missing"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn a_mistyped_plugin_gets_a_hint() {
    for (element, wrong, right) in [
        ("bsdf", "plastik", "plastic"),
        ("bsdf", "roughplastik", "roughplastic"),
        ("bsdf", "principaled", "principled"),
        ("bsdf", "thindielektric", "thindielectric"),
        ("shape", "spher", "sphere"),
    ] {
        let said = said_of(element, wrong);
        assert!(said.contains(&format!("did you mean \"{right}\"?")), "{said}");
    }
}
