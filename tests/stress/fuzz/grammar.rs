//! What scenes are made of: the plugins as they are declared ([`abbe::scene::plugins`]), so that what is
//! added is tried without being named here, and properties as the scenes of the repository write them.

use super::change::Random;
use abbe::scene::{Declaration, Takes};
use roxmltree::{Document, Node};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Elements that stand for objects.
const OBJECTS: [&str; 12] = [
    "integrator",
    "sensor",
    "film",
    "sampler",
    "rfilter",
    "shape",
    "bsdf",
    "emitter",
    "medium",
    "phase",
    "texture",
    "volume",
];

/// Properties of each type.
const PLAIN: [(&str, &str); 9] = [
    ("float", r#"<float name="NAME" value="0.5"/>"#),
    ("integer", r#"<integer name="NAME" value="1"/>"#),
    ("boolean", r#"<boolean name="NAME" value="true"/>"#),
    ("string", r#"<string name="NAME" value="zzz"/>"#),
    ("point", r#"<point name="NAME" x="0.1" y="0.2" z="0.3"/>"#),
    ("rgb", r#"<rgb name="NAME" value="0.2, 0.3, 0.4"/>"#),
    ("spectrum", r#"<spectrum name="NAME" value="0.5"/>"#),
    ("transform", r#"<transform name="NAME"><scale value="0.5"/></transform>"#),
    (
        "animation",
        r#"<animation name="NAME"><transform time="0"><scale value="0.5"/></transform><transform time="1"/></animation>"#,
    ),
];

/// What one plugin takes.
#[derive(Debug, Default)]
struct Plugin {
    /// By name: types of properties and elements of objects that are accepted.
    properties: BTreeMap<String, Vec<&'static str>>,
    /// Those without which there is no such object.
    required: BTreeSet<String>,
    /// Words that a string may be.
    choices: BTreeMap<String, Vec<String>>,
    /// Objects that it holds without asking for their names, and whether it is little without them.
    holds: Vec<(&'static str, bool)>,
    /// Properties as scenes of the repository write them.
    examples: BTreeMap<String, Vec<String>>,
}

/// All plugins.
#[derive(Debug)]
pub struct Grammar {
    plugins: BTreeMap<(&'static str, String), Plugin>,
    /// Names of plugins and properties, and what strings may be.
    words: Vec<String>,
}

/// What sensors without a picture ask for.
const SMALLEST_FILM: &str = r#"<film type="hdrfilm"><integer name="width" value="1"/><integer name="height" value="1"/><rfilter type="box"/></film>"#;

/// A scene with an object of this element in its place.
fn around(element: &str, object: &str) -> String {
    const SENSOR: &str = r#"<sensor type="perspective"/>"#;
    let inner = match element {
        "sensor" => object.to_owned(),
        "film" | "sampler" => format!(r#"<sensor type="perspective">{object}</sensor>"#),
        "rfilter" => format!(r#"<sensor type="perspective"><film type="hdrfilm">{object}</film></sensor>"#),
        "phase" => format!(r#"{SENSOR}<medium type="homogeneous" id="m">{object}</medium>"#),
        "texture" => {
            format!(r#"{SENSOR}<shape type="sphere"><bsdf type="diffuse">{object}</bsdf></shape>"#)
        }
        _ => format!("{SENSOR}{object}"),
    };
    format!(r#"<scene version="3.0.0">{inner}</scene>"#)
}

/// A spectrum needs a name wherever it stands.
fn opening(element: &str, plugin: &str) -> String {
    match element {
        "texture" => format!(r#"<texture type="{plugin}" name="reflectance">"#),
        "volume" | "medium" => format!(r#"<{element} type="{plugin}" id="it">"#),
        _ => format!(r#"<{element} type="{plugin}">"#),
    }
}

impl Grammar {
    /// `scenes` are texts with the folders that their files are relative to.
    pub fn learned<'a>(scenes: impl Iterator<Item = (&'a str, &'a Path)>) -> Self {
        let (mut plugins, mut words) = (BTreeMap::new(), BTreeSet::new());
        for declaration in abbe::scene::plugins() {
            let plugin = Self::declared(&declaration);
            words.insert(declaration.name.to_owned());
            words.extend(plugin.properties.keys().chain(plugin.choices.values().flatten()).cloned());
            let element = if declaration.element == "spectrum" { "texture" } else { declaration.element };
            plugins.insert((element, declaration.name.to_owned()), plugin);
        }
        let mut grammar = Self { plugins, words: words.into_iter().collect() };
        for (text, folder) in scenes {
            grammar.take_examples(text, folder);
        }
        grammar
    }

    fn declared(declaration: &Declaration) -> Plugin {
        let mut plugin = Plugin::default();
        for parameter in declaration.parameters.iter().chain(&declaration.common) {
            let types: &[&'static str] = match &parameter.takes {
                Takes::Object(held) if parameter.name.is_empty() => {
                    // What sensors without a picture ask for stands in a film.
                    plugin.holds.push((*held, parameter.is_required || *held == "film"));
                    continue;
                }
                Takes::Object(held) => &[*held],
                Takes::Float(_) => &["float", "integer"],
                Takes::Integer(..) => &["integer"],
                Takes::Boolean => &["boolean"],
                Takes::Choice(words) => {
                    let words = words.iter().map(|word| (*word).to_owned()).collect();
                    plugin.choices.insert(parameter.name.to_owned(), words);
                    &["string"]
                }
                Takes::Text | Takes::Numbers | Takes::Points(_) | Takes::File => &["string"],
                Takes::Vector => &["point"],
                Takes::Rgb => &["rgb"],
                Takes::Transform => &["transform"],
                Takes::Placement => &["transform", "animation"],
                Takes::Spectrum(_) => &["float", "rgb", "spectrum", "texture"],
                Takes::Index => &["float", "string", "spectrum", "texture"],
            };
            // The channels of a film have any names.
            let name = if parameter.name.is_empty() { "band1" } else { parameter.name };
            if parameter.is_required {
                plugin.required.insert(name.to_owned());
            }
            plugin.properties.entry(name.to_owned()).or_default().extend(types);
        }
        plugin
    }

    /// Remembers how a scene writes the properties of its objects, with absolute paths.
    fn take_examples(&mut self, text: &str, folder: &Path) {
        let Ok(document) = Document::parse(text) else { return };
        for node in document.descendants().filter(Node::is_element) {
            let element =
                if node.tag_name().name() == "spectrum" { "texture" } else { node.tag_name().name() };
            let Some(plugin) = node.attribute("type") else { continue };
            let Some(element) = OBJECTS.into_iter().find(|object| *object == element) else { continue };
            let Some(known) = self.plugins.get_mut(&(element, plugin.to_owned())) else { continue };
            for child in node.children().filter(Node::is_element) {
                let Some(name) = child.attribute("name") else { continue };
                let mut snippet = text[child.range()].to_owned();
                if snippet.contains('$') || snippet.contains("<ref") || snippet.len() > 2000 {
                    continue;
                }
                for attribute in child.descendants().flat_map(|inner| inner.attributes()) {
                    let path = folder.join(attribute.value());
                    let is_name = ["value", "filename"].contains(&attribute.name());
                    if is_name
                        && path.is_file()
                        && let Ok(path) = path.canonicalize()
                    {
                        snippet = snippet.replace(attribute.value(), &path.display().to_string());
                    }
                }
                let examples = known.examples.entry(name.to_owned()).or_default();
                if examples.len() < 20 && !examples.contains(&snippet) {
                    examples.push(snippet);
                }
            }
        }
    }

    /// Every plugin, as element and name.
    pub fn plugins(&self) -> impl Iterator<Item = (&'static str, &str)> {
        self.plugins.keys().map(|(element, name)| (*element, name.as_str()))
    }

    pub fn properties(&self) -> usize {
        self.plugins.values().map(|plugin| plugin.properties.len()).sum()
    }

    /// A scene around an object of any plugin, and which that is.
    pub fn scene(&self, random: &mut Random) -> (String, (&'static str, &str)) {
        let chosen = random.below(self.plugins.len());
        let ((element, name), _) = self.plugins.iter().nth(chosen).expect("a plugin");
        let mut writer = Writer { grammar: self, random, is_wild: false, left: 24 };
        writer.is_wild = writer.random.below(3) == 0;
        let object = writer.object(element, name, "", 0);
        let mut extra = String::new();
        for _ in 0..writer.random.below(3) {
            let element = ["shape", "emitter", "integrator", "shape"][writer.random.below(4)];
            extra += &writer.any(element, "", 0);
        }
        let text = match *element {
            // Where an object shows.
            "bsdf" | "medium" => {
                let object = object.replacen("id=\"it\"", "name=\"interior\"", 1);
                let shape = ["sphere", "rectangle", "cube", "cylinder"][writer.random.below(4)];
                // Light gets into a medium only through what lets it through.
                let bsdf = if *element == "medium" { r#"<bsdf type="null"/>"# } else { "" };
                around("shape", &format!(r#"<shape type="{shape}">{bsdf}{object}</shape>{extra}"#))
            }
            "emitter" if name.contains("area") => {
                around("shape", &format!(r#"<shape type="sphere">{object}</shape>{extra}"#))
            }
            "sensor" if name == "irradiancemeter" => {
                format!(r#"<scene version="3.0.0"><shape type="rectangle">{object}</shape>{extra}</scene>"#)
            }
            "shape" if name == "instance" => {
                let group = r#"<shape type="shapegroup" id="group">"#;
                let shown = object.replacen("</shape>", r#"<ref id="group"/></shape>"#, 1);
                let inner = writer.any("shape", "", 3);
                // Half of the groups show another.
                let nested = match writer.random.below(2) {
                    0 => format!(
                        r#"<shape type="shapegroup" id="inner">{}</shape>{group}<shape type="instance"><ref id="inner"/>
                        </shape>{inner}</shape>"#,
                        writer.any("shape", "", 3)
                    ),
                    _ => format!("{group}{inner}</shape>"),
                };
                around("shape", &format!("{nested}{shown}{extra}"))
            }
            "texture" => {
                let (bsdf, of) = [
                    ("diffuse", "reflectance"),
                    ("dielectric", "int_ior"),
                    ("roughconductor", "alpha"),
                    ("dielectric", "normal_reflectance"),
                ][writer.random.below(4)];
                let object = object.replacen("\"reflectance\"", &format!("\"{of}\""), 1);
                let shape =
                    format!(r#"<shape type="sphere"><bsdf type="{bsdf}">{object}</bsdf></shape>{extra}"#);
                around("shape", &shape)
            }
            "shape" | "emitter" | "volume" => around("shape", &format!("{object}{extra}")),
            element => around(element, &object),
        };
        (text, (element, name))
    }
}

/// Writes objects.
struct Writer<'a> {
    grammar: &'a Grammar,
    random: &'a mut Random,
    /// Whether numbers may be anything.
    is_wild: bool,
    /// How many more objects there may be.
    left: usize,
}

impl Writer<'_> {
    fn any(&mut self, element: &'static str, attributes: &str, depth: usize) -> String {
        let names: Vec<&String> =
            self.grammar.plugins.keys().filter(|(of, _)| *of == element).map(|(_, name)| name).collect();
        if names.is_empty() {
            return String::new();
        }
        let name = names[self.random.below(names.len())];
        self.object(element, name, attributes, depth)
    }

    fn object(&mut self, element: &'static str, name: &str, attributes: &str, depth: usize) -> String {
        let Some(plugin) = self.grammar.plugins.get(&(element, name.to_owned())) else {
            return String::new();
        };
        self.left = self.left.saturating_sub(1);
        let mut text = match attributes {
            "" => opening(element, name),
            attributes => format!(r#"<{element} type="{name}" {attributes}>"#),
        };
        let share = if self.random.below(2) == 0 { 8 } else { 2 };
        let only_examples = plugin.examples.keys().filter(|name| !plugin.properties.contains_key(*name));
        let none = Vec::new();
        let all = plugin.properties.iter().chain(only_examples.map(|name| (name, &none)));
        for (property, types) in all {
            if !plugin.required.contains(property) && self.random.below(share) > 0 {
                continue;
            }
            let examples = plugin.examples.get(property).map_or(&[][..], Vec::as_slice);
            if !examples.is_empty() && (types.is_empty() || self.random.below(2) == 0) {
                text += &examples[self.random.below(examples.len())];
                continue;
            }
            let of_type = types[self.random.below(types.len())];
            text += &self.property(plugin, property, of_type, depth);
        }
        for (held, is_needed) in &plugin.holds {
            if *held == "film" && self.random.below(2) == 0 {
                text += SMALLEST_FILM;
                continue;
            }
            let is_left_out = if *is_needed { self.random.below(6) == 0 } else { self.random.below(6) > 0 };
            if depth >= 4 || self.left == 0 || is_left_out {
                continue;
            }
            text += &self.any(held, "id=\"of\"", depth + 1).replace(" id=\"of\"", "");
        }
        if self.random.below(40) == 0 {
            let word = &self.grammar.words[self.random.below(self.grammar.words.len())];
            text += &PLAIN[self.random.below(PLAIN.len())].1.replace("NAME", word);
        }
        text + &format!("</{element}>")
    }

    fn property(&mut self, plugin: &Plugin, name: &str, of_type: &'static str, depth: usize) -> String {
        let numbers = |writer: &mut Self, count: usize| -> String {
            let numbers: Vec<String> = (0..count).map(|_| writer.number()).collect();
            numbers.join(", ")
        };
        match of_type {
            "float" => format!(r#"<float name="{name}" value="{}"/>"#, self.number()),
            "integer" => {
                let number = match self.random.below(if self.is_wild { 8 } else { 4 }) {
                    0 => 1,
                    1 => 2,
                    2 => 5,
                    3 => 16,
                    4 => 0,
                    5 => -1,
                    6 => i64::from(u32::MAX),
                    _ => 1_000_000,
                };
                format!(r#"<integer name="{name}" value="{number}"/>"#)
            }
            "boolean" => {
                let value = self.random.below(2) == 0;
                format!(r#"<boolean name="{name}" value="{value}"/>"#)
            }
            "string" => {
                let value = match plugin.choices.get(name) {
                    Some(choices) => choices[self.random.below(choices.len())].clone(),
                    None if self.random.below(2) == 0 => {
                        let count = [1, 2, 3, 4, 6, 9, 10, 12, 16][self.random.below(9)];
                        numbers(self, count)
                    }
                    None => self.grammar.words[self.random.below(self.grammar.words.len())].clone(),
                };
                format!(r#"<string name="{name}" value="{value}"/>"#)
            }
            "point" => {
                let [x, y, z] = std::array::from_fn(|_| self.number());
                format!(r#"<point name="{name}" x="{x}" y="{y}" z="{z}"/>"#)
            }
            "rgb" => format!(r#"<rgb name="{name}" value="{}"/>"#, numbers(self, 3)),
            "spectrum" => {
                let value = match self.random.below(3) {
                    0 => format!("400:{}, 550:{}, 700:{}", self.number(), self.number(), self.number()),
                    _ => self.number(),
                };
                format!(r#"<spectrum name="{name}" value="{value}"/>"#)
            }
            "transform" => format!(r#"<transform name="{name}">{}</transform>"#, self.steps()),
            "animation" => format!(
                r#"<animation name="{name}"><transform time="0">{}</transform><transform time="{}">{}</transform></animation>"#,
                self.steps(),
                self.number(),
                self.steps()
            ),
            object if depth < 4 && self.left > 0 => self.any(object, &format!("name=\"{name}\""), depth + 1),
            _ => String::new(),
        }
    }

    fn steps(&mut self) -> String {
        let count = self.random.below(4);
        (0..count).map(|_| self.step()).collect()
    }

    fn step(&mut self) -> String {
        let [x, y, z] = std::array::from_fn(|_| self.number());
        match self.random.below(6) {
            0 => format!(r#"<scale value="{x}"/>"#),
            1 => format!(r#"<scale x="{x}" y="{y}" z="{z}"/>"#),
            2 => format!(r#"<rotate x="{x}" y="{y}" z="{z}" angle="{x}"/>"#),
            3 => format!(r#"<lookat origin="{x}, {y}, {z}" target="0, 0, 0" up="0, 1, 0"/>"#),
            4 => {
                let numbers: Vec<String> = (0..16).map(|_| self.number()).collect();
                format!(r#"<matrix value="{}"/>"#, numbers.join(" "))
            }
            _ => format!(r#"<translate x="{x}" y="{y}" z="{z}"/>"#),
        }
    }

    fn number(&mut self) -> String {
        const WILD: [&str; 16] = [
            "0",
            "-1",
            "1e300",
            "-1e300",
            "1e-300",
            "nan",
            "inf",
            "-0",
            "1e-12",
            "1e12",
            "4294967296",
            "1e38",
            "-1e-7",
            "3e5",
            "1",
            "1e-30",
        ];
        if self.is_wild && self.random.below(4) == 0 {
            return WILD[self.random.below(WILD.len())].to_owned();
        }
        match self.random.below(4) {
            0 => "1".to_owned(),
            1 => format!("{}", self.random.below(1000) as f64 / 100.0),
            _ => format!("{}", self.random.below(1000) as f64 / 1000.0),
        }
    }
}
