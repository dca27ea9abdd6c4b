//! The reference of the scene format, as Markdown, from the declarations.

use super::{Declaration, Parameter, Takes, Use};
use std::fmt::Write;

/// Headings of the classes by their elements, with what stands below.
const CLASSES: [(&str, &str, &str); 12] = [
    (
        "shape",
        "Shapes",
        "Lengths are in the scene's own unit, in the coordinates that `to_world` takes to the scene. One that \
         mirrors turns spheres inside out, and meshes without vertex normals or with `face_normals`, as in \
         Mitsuba; cylinders, disks, rectangles, cubes and other meshes keep their outside. `flip_normals` turns a \
         shape back. Parts of a solid face out of it in any case. `to_world` moves the control points of a \
         `linearcurve` or `bsplinecurve` and leaves the radii. Vertex normals that a mesh lacks are computed after `to_world`. A shape that an `<animation>` moves is \
         what it is at rest where it stands in the middle of the time that the shutter is open; scales that \
         change meanwhile stretch it from there, with its radii and normals.",
    ),
    ("bsdf", "BSDFs", ""),
    ("emitter", "Emitters", "`area` and `directionalarea` stand in shapes, the others in the scene."),
    ("spectrum", "Spectra and textures", "`<spectrum>` and `<texture>` mean the same."),
    ("volume", "Volumes", "A volume stands in a medium, in a `blendphase`, or in the texture `volume`."),
    ("medium", "Media", "A medium stands in a shape, as `interior` or `exterior`, or in a sensor."),
    ("phase", "Phase functions", ""),
    ("integrator", "Integrators", ""),
    ("sensor", "Sensors", ""),
    ("film", "Films", "A film stands in a sensor."),
    ("rfilter", "Reconstruction filters", "A filter stands in a film."),
    ("sampler", "Samplers", "A sampler stands in a sensor."),
];

/// All plugins that are declared, with their parameters.
pub fn reference() -> String {
    let all = super::plugins();
    let mut text = String::new();
    for (element, heading, below) in CLASSES {
        let plugins: Vec<&Declaration> = all.iter().filter(|plugin| plugin.element == element).collect();
        let _ = write!(text, "### {heading}\n\n");
        if !below.is_empty() {
            let _ = write!(text, "{below}\n\n");
        }
        for (index, plugin) in plugins.iter().enumerate() {
            let mark = if plugin.is_extension { " *(extension)*" } else { "" };
            let _ = write!(text, "**`{}`**{mark}: {}\n\n", plugin.name, plugin.doc);
            // A table once is enough for those that are the same.
            let before = index.checked_sub(1).map(|before| &plugins[before].parameters);
            if plugin.doc != "the same" || before != Some(&plugin.parameters) {
                table(&mut text, &plugin.parameters);
            }
        }
        if let Some(first) = plugins.iter().find(|plugin| !plugin.common.is_empty()) {
            let all = plugins.iter().all(|plugin| !plugin.common.is_empty());
            let but = if all { "" } else { ", but for those that are made of others," };
            let _ = write!(text, "**Each of these**{but} takes also\n\n");
            table(&mut text, &first.common);
        }
    }
    text.trim_end().to_owned() + "\n"
}

fn table(text: &mut String, parameters: &[Parameter]) {
    if parameters.is_empty() {
        return;
    }
    text.push_str("| parameter | what it may be | default | what it means |\n| --- | --- | --- | --- |\n");
    for parameter in parameters {
        let Parameter { name, takes, default, is_required, unit, doc, is_extension } = parameter;
        let name = if name.is_empty() { String::new() } else { format!("`{name}`") };
        let unit = if unit.is_empty() { String::new() } else { format!(", {unit}") };
        let default = if *is_required { "required" } else { default };
        let mark = if *is_extension { " *(extension)*" } else { "" };
        let row = format!("{name} | {takes}{unit} | {default} | {doc}{mark}");
        let _ = writeln!(text, "| {} |", row.trim_start());
    }
    text.push('\n');
}

/// In words, for the page.
impl std::fmt::Display for Takes {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Self::Float(range) => f.write_str(format!("number {range}").trim_end()),
            Self::Integer(least, most) if *most >= i64::from(i32::MAX) => match *least {
                least if least <= i64::from(i32::MIN) => f.write_str("integer"),
                least => write!(f, "integer of at least {least}"),
            },
            Self::Integer(least, most) => write!(f, "integer from {least} to {most}"),
            Self::Boolean => f.write_str("boolean"),
            Self::Choice(words) => {
                let words: Vec<String> = words.iter().map(|word| format!("`{word}`")).collect();
                f.write_str(&words.join(", "))
            }
            Self::Text => f.write_str("string"),
            Self::Numbers => f.write_str("numbers in a string"),
            Self::Points(count) => write!(f, "points of {count} numbers in a string"),
            Self::File => f.write_str("name of a file"),
            Self::Vector => f.write_str("point or vector"),
            Self::Transform => f.write_str("transform"),
            Self::Rgb => f.write_str("colour"),
            Self::Placement => f.write_str("transform or animation"),
            Self::Spectrum(Use::Normals) => f.write_str("texture of normals"),
            Self::Spectrum(Use::Height) => f.write_str("texture of numbers"),
            Self::Spectrum(purpose) => {
                let kind = if purpose.is_spectral() { "spectrum" } else { "number or texture" };
                let values = purpose.expected().trim_start_matches("expected ");
                write!(f, "{kind}, {values}")
            }
            Self::Index => f.write_str("number above 0, name of a material, or spectrum"),
            Self::Object(element) => write!(f, "`<{element}>`"),
        }
    }
}
