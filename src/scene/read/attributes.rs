//! Attributes of an element: `$name` replaced, each with its place, and what values their texts stand for.

use super::super::source::{Place, SceneError};
use super::hints;
use crate::geometry::Vec3;
use roxmltree::Node;
use std::collections::{BTreeMap, BTreeSet};
use std::num::{IntErrorKind, ParseIntError};

/// Values for `$name`: from the command line, then from `<default>`; the first to set a name wins.
#[derive(Debug, Default)]
pub(super) struct Defaults {
    values: BTreeMap<String, String>,
    given: BTreeSet<String>,
    used: BTreeSet<String>,
}

impl Defaults {
    pub fn new(defines: &[(String, String)]) -> Self {
        let mut defaults = Self::default();
        for (name, value) in defines {
            defaults.values.entry(name.clone()).or_insert_with(|| value.clone());
            defaults.given.insert(name.clone());
        }
        defaults
    }

    pub fn set(&mut self, name: &str, value: String) {
        self.values.entry(name.to_owned()).or_insert(value);
    }

    /// `text` with every `$name` replaced.
    fn replace(&mut self, text: &str) -> Result<String, Unreplaced> {
        let mut result = String::new();
        let mut rest = text;
        while let Some(dollar) = rest.find('$') {
            result.push_str(&rest[..dollar]);
            rest = &rest[dollar + 1..];
            let end = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
            let (name, after) = rest.split_at(end);
            result.push_str(self.values.get(name).ok_or_else(|| Unreplaced::Undefined(name.to_owned()))?);
            // Parameters made of parameters can double and double again.
            if result.len() > LONGEST_REPLACED {
                return Err(Unreplaced::TooLong);
            }
            self.used.insert(name.to_owned());
            rest = after;
        }
        result.push_str(rest);
        Ok(result)
    }

    /// Command-line definitions that no `$name` asked for.
    pub fn unused(&self) -> impl Iterator<Item = SceneError> + '_ {
        self.given.difference(&self.used).map(|name| {
            let used: Vec<&str> = self.used.iter().map(String::as_str).collect();
            let remedy = match hints::nearest(name, &used) {
                Some(near) => format!("did you mean -D {near}=...?"),
                None if used.is_empty() => {
                    format!("write ${name} where the value belongs, or leave out -D {name}")
                }
                None => format!("this scene uses: {}", hints::listing(&used)),
            };
            SceneError {
                place: None,
                problem: format!("The scene never uses ${name}, which the command line sets"),
                expected: format!("expected the name of a parameter of this scene after -D, found {name}"),
                remedy: Some(remedy),
            }
        })
    }

    fn undefined(&self, name: &str, place: &Place) -> SceneError {
        if name.is_empty() {
            return SceneError::at(
                place,
                "A parameter has no name",
                "expected a name after $, as in $radius",
            )
            .with_remedy("write $name without braces, with letters, digits and underscores only");
        }
        let known: Vec<&str> = self.values.keys().map(String::as_str).collect();
        let error = SceneError::at(
            place,
            format!("The parameter ${name} has no value"),
            "expected a parameter that a <default> before this place or -D defines",
        );
        match hints::nearest(name, &known) {
            Some(near) => error.with_remedy(format!("did you mean ${near}?")),
            None => error.with_remedy(format!(
                "write <default name=\"{name}\" value=\"...\"/> above, or give -D {name}=... on the command line"
            )),
        }
    }
}

/// Why a text could not be completed.
enum Unreplaced {
    /// The first name that has no value.
    Undefined(String),
    TooLong,
}

/// Most bytes of a text with parameters in it.
const LONGEST_REPLACED: usize = 1 << 20;

/// The value of an attribute.
#[derive(Clone, Debug)]
pub(super) struct Attribute {
    pub text: String,
    pub place: Place,
    /// Whether the text stands in the file as it is, so that a place within it can be pointed at.
    literal: bool,
}

impl Attribute {
    /// A text whose parts are not told apart.
    pub fn new(text: String, place: Place) -> Self {
        Self { text, place, literal: false }
    }

    /// The place of `length` bytes from `offset` on, as far as it can be told.
    pub fn part(&self, offset: usize, length: usize) -> Place {
        let start = self.place.span.start + offset;
        let end = (start + length.max(1)).min(self.place.span.end);
        if self.literal && start < end {
            Place { file: self.place.file, span: start..end }
        } else {
            self.place.clone()
        }
    }
}

/// The attributes of one element.
#[derive(Debug)]
pub(super) struct Attributes(BTreeMap<String, Attribute>);

impl Attributes {
    /// `None` where something is wrong: an attribute that is missing or unknown, a parameter without value.
    pub fn read(
        node: Node<'_, '_>,
        file: usize,
        required: &[&str],
        optional: &[&str],
        defaults: &mut Defaults,
        errors: &mut Vec<SceneError>,
    ) -> Option<Self> {
        let before = errors.len();
        let tag = node.tag_name().name();
        let known: Vec<&str> = required.iter().chain(optional).copied().collect();
        let mut found = BTreeMap::new();
        for attribute in node.attributes() {
            let name_place = Place {
                file,
                span: attribute.range().start..attribute.range().start + attribute.range_qname().len(),
            };
            if !known.contains(&attribute.name()) {
                errors.push(unknown(tag, attribute.name(), &name_place, &known));
                continue;
            }
            let place = Place { file, span: attribute.range_value() };
            match defaults.replace(attribute.value()) {
                Ok(text) => {
                    let source = node.document().input_text().get(place.span.clone());
                    let literal = source == Some(text.as_str());
                    found.insert(attribute.name().to_owned(), Attribute { text, place, literal });
                }
                Err(Unreplaced::Undefined(name)) => errors.push(defaults.undefined(&name, &place)),
                Err(Unreplaced::TooLong) => errors.push(SceneError::at(
                    &place,
                    "The text becomes too long when its parameters are replaced",
                    format!("expected at most {LONGEST_REPLACED} bytes"),
                )),
            }
        }
        for name in required {
            if !node.has_attribute(*name) {
                errors.push(SceneError::at(
                    &start_tag(node, file),
                    format!("<{tag}> has no attribute \"{name}\""),
                    format!("expected {name}=\"...\" here"),
                ));
            }
        }
        (errors.len() == before).then_some(Self(found))
    }

    pub fn get(&self, name: &str) -> Option<&Attribute> {
        self.0.get(name)
    }

    pub fn text(&self, name: &str) -> Option<String> {
        self.get(name).map(|attribute| attribute.text.clone())
    }
}

fn unknown(tag: &str, name: &str, place: &Place, known: &[&str]) -> SceneError {
    let error = SceneError::at(
        place,
        format!("<{tag}> has no attribute \"{name}\""),
        format!(
            "expected {}",
            if known.is_empty() { "no attribute".to_owned() } else { hints::either(known) }
        ),
    );
    match hints::nearest(name, known) {
        Some(near) => error.with_remedy(format!("did you mean \"{near}\"?")),
        None => error,
    }
}

/// The start tag of an element; the whole of it where it has no content.
pub(super) fn start_tag(node: Node<'_, '_>, file: usize) -> Place {
    let range = node.range();
    let end = node.first_child().map_or(range.end, |child| child.range().start);
    Place { file, span: range.start..end.max(range.start) }
}

/// Numbers beyond single precision are infinite in Mitsuba 3. Here they would become so when they are
/// multiplied.
pub(in crate::scene) const GREATEST: f64 = f32::MAX as f64;

/// A number as Mitsuba 3 writes it, at most [`GREATEST`].
pub(in crate::scene) fn number(text: &str) -> Option<f64> {
    text.trim().parse::<f64>().ok().filter(|number| number.abs() <= GREATEST)
}

/// The message about a text that is no [`number`].
fn not_a_number(text: &str, place: &Place, expected: &str) -> SceneError {
    let error = SceneError::at(place, format!("\"{text}\" is not a number"), expected);
    match text.trim().parse::<f64>() {
        Ok(number) if !number.is_nan() => error.with_remedy("numbers may be as large as 3.4e38"),
        _ => error,
    }
}

pub(super) fn float(attribute: &Attribute) -> Result<f64, SceneError> {
    number(&attribute.text).ok_or_else(|| {
        not_a_number(&attribute.text, &attribute.place, "expected a finite number such as 0.5 or 2e-3")
    })
}

pub(super) fn integer(attribute: &Attribute) -> Result<i64, SceneError> {
    attribute.text.trim().parse().map_err(|error: ParseIntError| {
        let wrong = SceneError::at(
            &attribute.place,
            format!("\"{}\" is not an integer", attribute.text),
            "expected a whole number such as 16",
        );
        match error.kind() {
            IntErrorKind::PosOverflow | IntErrorKind::NegOverflow => {
                beyond_integers(&attribute.place, &format!("\"{}\"", attribute.text))
            }
            _ if number(&attribute.text).is_some() => {
                wrong.with_remedy("leave out the decimals; a property of type float is another thing")
            }
            _ => wrong,
        }
    })
}

/// The message about a whole number that has more digits than an integer may have.
pub(super) fn beyond_integers(place: &Place, what: &str) -> SceneError {
    let expected = format!("expected one from {} to {}", i64::MIN, i64::MAX);
    SceneError::at(place, format!("{what} does not fit an integer"), expected)
}

pub(super) fn boolean(attribute: &Attribute) -> Result<bool, SceneError> {
    match attribute.text.to_lowercase().as_str() {
        "true" => Ok(true),
        "false" => Ok(false),
        _ => Err(SceneError::at(
            &attribute.place,
            format!("\"{}\" is not a boolean", attribute.text),
            "expected true or false",
        )),
    }
}

/// Numbers separated by commas, blanks or both.
pub(super) fn numbers(attribute: &Attribute) -> Result<Vec<f64>, SceneError> {
    let separates = |c: char| c == ',' || c.is_whitespace();
    let words = attribute.text.split(separates).filter(|word| !word.is_empty());
    words
        .map(|word| {
            number(word).ok_or_else(|| {
                let offset = word.as_ptr() as usize - attribute.text.as_ptr() as usize;
                let place = attribute.part(offset, word.len());
                not_a_number(word, &place, "expected finite numbers separated by commas or blanks")
            })
        })
        .collect()
}

/// Three numbers, or one that stands for all three.
pub(super) fn triple(attribute: &Attribute, one_for_all: bool) -> Result<Vec3, SceneError> {
    let found = numbers(attribute)?;
    match found[..] {
        [x, y, z] => Ok(Vec3::new(x, y, z)),
        [all] if one_for_all => Ok(Vec3::splat(all)),
        _ => Err(SceneError::at(
            &attribute.place,
            format!("A vector has 3 components, not {}", found.len()),
            if one_for_all { "expected 3 numbers, or 1 for all three" } else { "expected 3 numbers" },
        )),
    }
}

/// A colour: three numbers, or one for grey.
pub(super) fn rgb(attribute: &Attribute) -> Result<[f64; 3], SceneError> {
    let found = numbers(attribute).map_err(|error| match attribute.text.trim().starts_with('#') {
        true => {
            error.with_remedy("Mitsuba 3 knows no hexadecimal colours: write three linear values from 0 to 1")
        }
        false => error,
    })?;
    match found[..] {
        [r, g, b] => Ok([r, g, b]),
        [grey] => Ok([grey; 3]),
        _ => Err(SceneError::at(
            &attribute.place,
            format!("A colour has 3 components, not {}", found.len()),
            "expected 3 numbers for red, green and blue, or 1 for grey",
        )),
    }
}

/// A vector in either form: `value="1 2 3"`, or `x`, `y`, `z`, each of which is `absent` where it is left
/// out (and required where `absent` is `None`).
pub(super) fn vector(
    attributes: &Attributes,
    place: &Place,
    absent: Option<f64>,
) -> Result<Vec3, SceneError> {
    let components = ["x", "y", "z"].map(|name| attributes.get(name));
    if let Some(value) = attributes.get("value") {
        return match components.into_iter().flatten().next() {
            None => triple(value, true),
            Some(extra) => Err(SceneError::at(
                &extra.place,
                "A vector is given twice",
                "expected either value or x, y, z, not both",
            )),
        };
    }
    let mut result = [0.0; 3];
    for ((component, name), slot) in components.into_iter().zip(["x", "y", "z"]).zip(&mut result) {
        *slot = match (component, absent) {
            (Some(component), _) => float(component)?,
            (None, Some(absent)) => absent,
            (None, None) => {
                return Err(SceneError::at(
                    place,
                    format!("The {name} component is missing"),
                    "expected value=\"1 2 3\" or x=\"1\" y=\"2\" z=\"3\"",
                ));
            }
        };
    }
    Ok(Vec3::from_array(result))
}
