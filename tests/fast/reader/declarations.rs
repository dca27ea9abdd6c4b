//! What plugins declare is what the reader knows of them.

use abbe::scene::{Declaration, Parameter, Takes, plugins};
use std::path::Path;

/// A property as a file could have it.
fn property(parameter: &Parameter) -> String {
    properties(parameter).remove(0)
}

/// The same with each word of a choice.
fn properties(parameter: &Parameter) -> Vec<String> {
    let name = parameter.name;
    let value = |element: &str, value: &str| format!(r#"<{element} name="{name}" value="{value}"/>"#);
    if let Takes::Choice(words) = &parameter.takes {
        return words.iter().map(|word| value("string", word)).collect();
    }
    vec![match &parameter.takes {
        Takes::Float(_) => value("float", "0.5"),
        Takes::Integer(..) => value("integer", "1"),
        Takes::Boolean => value("boolean", "true"),
        Takes::Text | Takes::File | Takes::Choice(_) => value("string", "nothing"),
        Takes::Numbers => value("string", "1, 2"),
        Takes::Points(count) => value("string", &"1 2 3"[..2 * count - 1]),
        Takes::Vector => value("vector", "1, 2, 3"),
        Takes::Rgb => value("rgb", "0.1, 0.2, 0.3"),
        Takes::Transform | Takes::Placement => format!(r#"<transform name="{name}"/>"#),
        Takes::Spectrum(_) | Takes::Index => value("float", "0.5"),
        Takes::Object(element) => {
            let plugin = match *element {
                "volume" => "constvolume",
                "shape" => "sphere",
                _ => "homogeneous",
            };
            format!(r#"<{element} name="{name}" type="{plugin}"/>"#)
        }
    }]
}

/// What reading a scene with one object of a plugin says about it.
fn said_of(plugin: &Declaration, inside: &str) -> String {
    let Declaration { element, name, .. } = plugin;
    let object = format!(r#"<{element} type="{name}">{inside}</{element}>"#);
    let within = |outer: &str| format!(r#"<sensor type="perspective"/><shape type="sphere">{outer}</shape>"#);
    let named = |role: &str, object: &str| object.replacen(' ', &format!(r#" name="{role}" "#), 1);
    let scene = match *element {
        "sensor" if *name == "irradiancemeter" => format!(r#"<shape type="sphere">{object}</shape>"#),
        "film" | "sampler" => format!(r#"<sensor type="perspective">{object}</sensor>"#),
        "rfilter" => format!(r#"<sensor type="perspective"><film type="hdrfilm">{object}</film></sensor>"#),
        "emitter" if name.ends_with("area") => within(&object),
        "medium" => within(&named("interior", &object)),
        "phase" => within(&format!(r#"<medium name="interior" type="homogeneous">{object}</medium>"#)),
        "spectrum" if ["sellmeier", "cauchy"].contains(name) => {
            within(&format!(r#"<bsdf type="dielectric">{}</bsdf>"#, named("int_ior", &object)))
        }
        "spectrum" => within(&format!(r#"<bsdf type="diffuse">{}</bsdf>"#, named("reflectance", &object))),
        _ => format!(r#"<sensor type="perspective"/>{object}"#),
    };
    let scene = format!(r#"<scene version="3.0.0">{scene}</scene>"#);
    let read = abbe::scene::read_str(scene, Path::new("scene.xml"), &Default::default());
    read.err().map_or_else(String::new, |errors| {
        let lines = errors.errors.iter().map(|error| {
            format!("{} {} {}\n", error.problem, error.expected, error.remedy.clone().unwrap_or_default())
        });
        lines.collect()
    })
}

/// Shapes that hold shapes know nothing else.
fn simple() -> impl Iterator<Item = Declaration> {
    plugins().into_iter().filter(|plugin| plugin.element != "shape" || !plugin.common.is_empty())
}

/// A field that several parameters make lists them apart from where it asks for them.
#[test]
fn what_is_declared_is_read() {
    let mut wrong = Vec::new();
    for plugin in simple() {
        let all: Vec<&Parameter> = plugin.parameters.iter().chain(&plugin.common).collect();
        let named = || all.iter().filter(|parameter| !parameter.name.is_empty());
        for parameter in named() {
            let refused = |others: &str| {
                let said = said_of(&plugin, &format!("{others}{}", property(parameter)));
                said.contains(&format!("has no property \"{}\"", parameter.name))
            };
            // Some mean something only beside another.
            let beside = |other: &&&Parameter| {
                !std::ptr::eq(**other, *parameter) && properties(other).iter().any(|other| !refused(other))
            };
            if refused("") && !named().any(|other| beside(&other)) {
                wrong.push(format!("{} {}: {}", plugin.element, plugin.name, parameter.name));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn what_is_read_is_declared() {
    let mut wrong = Vec::new();
    for plugin in simple() {
        let said = said_of(&plugin, r#"<string name="zzzzz" value="1"/>"#);
        let line = said.lines().find(|line| line.contains("has no property \"zzzzz\"")).unwrap_or_default();
        let (_, known) = line.split_once("it knows ").or(line.split_once("expected ")).unwrap_or_default();
        let known = known.split(" and ").next().unwrap_or_default().replace(" or ", ", ");
        for word in known.split(", ").map(str::trim).filter(|word| !word.is_empty() && *word != "no property")
        {
            let all = plugin.parameters.iter().chain(&plugin.common);
            if !all.map(|parameter| parameter.name).any(|name| name == word) {
                wrong.push(format!("{} {}: {word}", plugin.element, plugin.name));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn every_plugin_and_parameter_is_documented() {
    for plugin in plugins() {
        assert!(!plugin.doc.is_empty(), "{}", plugin.name);
        for parameter in plugin.parameters.iter().chain(&plugin.common) {
            assert!(!parameter.doc.is_empty(), "{}: {}", plugin.name, parameter.name);
        }
    }
}
