//! The plugins of scene files, each declared once: its name, what it is for, and its parameters with their
//! type, unit, default and range. Reading, hints for mistyped names, what `abbe info` writes and hashes, and
//! the reference in docs/scene-format.md follow from that; only `compile` is written apart.
//!
//! There is one file for each class of plugin. In it [`declare!`] lists them, each with the value that it
//! stands for. That value is written once: it is what the reader makes of the fields that follow, and the
//! pattern by which the writer takes it apart again.

pub mod bsdfs;
mod fields;
pub mod films;
pub mod filters;
mod indices;
pub mod integrators;
pub mod lights;
pub mod media;
pub mod phases;
mod reference;
pub mod samplers;
pub mod sensors;
pub mod shapes;
mod spectral;
pub mod textures;
pub mod view;

pub use super::read::spectra::Use;
use super::read::{Class, Query};
use super::write::{Node, Writer};
use fields::{Ignored, Simple, boolean, choice, float, ignored, integer, numbers, optional, text, vector};
pub use reference::reference;
use std::fmt;

/// A plugin of scene files, for documents and for who makes scenes.
#[derive(Clone, Debug)]
pub struct Declaration {
    /// The XML element that writes it.
    pub element: &'static str,
    /// The value of `type`.
    pub name: &'static str,
    /// What it is, in one line.
    pub doc: &'static str,
    /// Whether Mitsuba 3 does not have it.
    pub is_extension: bool,
    /// In the order in which they are written.
    pub parameters: Vec<Parameter>,
    /// Parameters that others of its class have, too.
    pub common: Vec<Parameter>,
}

/// A parameter of a plugin.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// The value of `name`; empty for an object that needs none.
    pub name: &'static str,
    /// What it may be.
    pub takes: Takes,
    /// What it is where the file leaves it out; empty where that is nothing.
    pub default: String,
    /// Whether there is no such object without it.
    pub is_required: bool,
    /// Empty for a number without unit, and for what is no number.
    pub unit: &'static str,
    /// What it means, in one line.
    pub doc: &'static str,
    /// Whether Mitsuba 3 does not have it.
    pub is_extension: bool,
}

/// What a parameter may be.
#[derive(Clone, Debug, PartialEq)]
pub enum Takes {
    /// A `<float>` or an `<integer>`.
    Float(Range),
    /// An `<integer>` from the first to the second number.
    Integer(i64, i64),
    /// A `<boolean>`.
    Boolean,
    /// One of these words in a `<string>`.
    Choice(Vec<&'static str>),
    /// A `<string>`.
    Text,
    /// Numbers in a `<string>`.
    Numbers,
    /// Points of a number of coordinates each, in a `<string>`.
    Points(usize),
    /// The name of a file in a `<string>`.
    File,
    /// A `<point>` or `<vector>`.
    Vector,
    /// A `<transform>`.
    Transform,
    /// A `<transform>` or an `<animation>`.
    Placement,
    /// An `<rgb>`.
    Rgb,
    /// A `<spectrum>`, `<rgb>`, `<texture>` or number that fits what it is for.
    Spectrum(Use),
    /// A number, the name of a material in a `<string>`, or a `<spectrum>`.
    Index,
    /// An object of this element.
    Object(&'static str),
}

impl Parameter {
    /// One that may be left out.
    fn new(name: &'static str, takes: Takes) -> Self {
        Self {
            name,
            takes,
            default: String::new(),
            is_required: false,
            unit: "",
            doc: "",
            is_extension: false,
        }
    }
}

/// Numbers that a parameter may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The least, or what all are above.
    pub low: f64,
    /// Whether `low` is allowed.
    pub with_low: bool,
    /// The greatest, or what all are below.
    pub high: f64,
    /// Whether `high` is allowed.
    pub with_high: bool,
}

impl Range {
    /// Every number.
    pub const ALL: Self =
        Self { low: f64::NEG_INFINITY, with_low: false, high: f64::INFINITY, with_high: false };
    /// Above 0.
    pub const POSITIVE: Self = Self { low: 0.0, ..Self::ALL };
    /// At least 0.
    pub const NOT_NEGATIVE: Self = Self { with_low: true, ..Self::POSITIVE };

    /// From one number to another, both included.
    pub const fn between(low: f64, high: f64) -> Self {
        Self { low, with_low: true, high, with_high: true }
    }

    /// Whether a number lies in it.
    pub fn contains(&self, number: f64) -> bool {
        let above = number > self.low || self.with_low && number == self.low;
        let below = number < self.high || self.with_high && number == self.high;
        above && below
    }
}

/// "above 0", "from 0 to 1": what follows "a number" in messages.
impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { low, with_low, high, with_high } = self;
        match (low.is_finite(), high.is_finite()) {
            (false, false) => Ok(()),
            (true, false) if *with_low => write!(f, "of at least {low}"),
            (true, false) => write!(f, "above {low}"),
            (false, true) => write!(f, "{} {high}", if *with_high { "of at most" } else { "below" }),
            (true, true) => match (with_low, with_high) {
                (true, true) => write!(f, "from {low} to {high}"),
                (true, false) => write!(f, "of at least {low} and below {high}"),
                (false, true) => write!(f, "above {low} and up to {high}"),
                (false, false) => write!(f, "between {low} and {high}"),
            },
        }
    }
}

/// Parameters that say one thing together; mostly it is one parameter.
pub trait Field {
    /// What the description holds of them.
    type Value;

    /// What they are called and may be.
    fn parameters(&self) -> Vec<Parameter>;

    /// `None` where they are wrong or missing so that there is nothing to go on with, which is reported.
    fn read(&self, query: &Query<'_>) -> Option<Self::Value>;

    /// Adds them to the object that they belong to.
    fn write(&self, node: Node, value: &Self::Value, writer: &mut Writer) -> Node;
}

/// Notes that a plugin is an extension, where the file names it.
fn note_extension(query: &Query<'_>, note: &str) {
    let object = query.object;
    let (place, text) = match object.class {
        Class::Shape | Class::Sensor => (&object.place, format!("{}: {note}", object.plugin)),
        _ => (&object.plugin_place, format!("{}: {note}", query.title())),
    };
    query.reader.extension(place, text);
}

/// Declares the plugins of a class: the functions `read`, `write` and `declarations`, and `NAMES`.
///
/// Each plugin is a name, `extension "..."` with the note for `abbe info` where Mitsuba 3 does not have it, a
/// line of documentation unless the note is one, the value that it stands for, and its fields in the order in
/// which they are written. `ignoring [...]` lists parameters that are checked and change nothing; `then`
/// names a function that checks the whole value. `common` after the class names a function that gives the
/// parameters that all its plugins have.
macro_rules! declare {
    (@ ($($field:ident),*)) => {
        &($($field.clone()),*)
    };
    (@ $field:ident) => {
        $field
    };
    (
        $class:expr => $kind:ty $(, common $common:path)?;
        $(
            $name:literal $(extension $note:literal)? $(, $doc:literal)?
            => $kind_name:ident::$variant:ident $body:tt
            { $($field:tt: $codec:expr),* $(,)? }
            $(ignoring [$($ignored:expr),* $(,)?])?
            $(then $then:path)?;
        )*
    ) => {
        /// The names of the plugins.
        pub const NAMES: &[&str] = &[$($name),*];

        /// What the plugin that is asked stands for; `None` where it is wrong or unknown, which is reported.
        #[allow(irrefutable_let_patterns, reason = "some plugins have no fields")]
        pub fn read(query: &$crate::scene::read::Query<'_>) -> Option<$kind> {
            match query.object.plugin.as_str() {
                $($name => {
                    // Apart from the others, for objects nest and their frames must fit into the stack.
                    #[inline(never)]
                    fn one(query: &$crate::scene::read::Query<'_>) -> Option<$kind> {
                        let _ = query;
                        $($crate::scene::plugins::note_extension(query, $note);)?
                        // All are asked, so that each that is wrong is reported.
                        let fields = ($($crate::scene::plugins::Field::read(&$codec, query),)*);
                        $($($crate::scene::plugins::Ignored::read(&$ignored, query);)*)?
                        let ($(Some($field),)*) = fields else { return None };
                        let value = $kind_name::$variant $body;
                        $(let value = $then(query, value)?;)?
                        Some(value)
                    }
                    one(query)
                })*
                _ => {
                    query.reader.unknown_plugin(query.object);
                    None
                }
            }
        }

        /// The object that stands for a value. Where several plugins do, it is the first.
        #[allow(unreachable_patterns, reason = "several of Mitsuba 3's plugins are the same here")]
        pub fn write(
            value: &$kind,
            place: &$crate::scene::Place,
            writer: &mut $crate::scene::write::Writer,
        ) -> $crate::scene::write::Node {
            let _ = &writer;
            match value {
                $($kind_name::$variant $body => {
                    let node = $crate::scene::write::Node::new($class, $name, place);
                    $(let node = $crate::scene::plugins::Field::write(&$codec, node, declare!(@ $field), writer);)*
                    node
                })*
            }
        }

        /// What the plugins are and take.
        pub fn declarations() -> Vec<$crate::scene::plugins::Declaration> {
            let common: Vec<$crate::scene::plugins::Parameter> = Vec::new();
            $(let common = [common, $common()].concat();)?
            vec![$($crate::scene::plugins::Declaration {
                element: $class.word(),
                name: $name,
                doc: [$($note,)? $($doc,)?].last().copied().unwrap_or_default(),
                is_extension: !<[&str]>::is_empty(&[$($note)?]),
                parameters: <[Vec<$crate::scene::plugins::Parameter>]>::concat(&[
                    $($crate::scene::plugins::Field::parameters(&$codec),)*
                    $($(vec![$crate::scene::plugins::Ignored::parameter(&$ignored)],)*)?
                ]),
                common: common.clone(),
            }),*]
        }
    };
}
use declare;

/// Every plugin that a scene file may name.
pub fn plugins() -> Vec<Declaration> {
    [
        shapes::all(),
        bsdfs::declarations(),
        lights::declarations(),
        textures::declarations(),
        textures::volumes::declarations(),
        media::declarations(),
        phases::declarations(),
        integrators::declarations(),
        sensors::declarations(),
        films::declarations(),
        filters::declarations(),
        samplers::declarations(),
    ]
    .concat()
}
