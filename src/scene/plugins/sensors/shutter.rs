//! When light is let in.

use super::super::fields::{Choices, Float};
use super::super::{Field, Parameter, Simple, Takes, choice, float};
use crate::camera::{Shutter, ShutterKind};
use crate::scene::read::Query;
use crate::scene::source::SceneError;
use crate::scene::write::{Node, Writer};

const MOST_FLASHES: i64 = 65_536;
const DEFAULT_FLASHES: u32 = 2;

const OPEN: Simple<Float> = float("shutter_open", 0.0, "when the shutter opens");
const CLOSE: Simple<Float> = float("shutter_close", 0.0, "when it closes");
const KIND: Simple<Choices<ShutterKind>> = choice(
    "shutter",
    ShutterKind::Box,
    &[
        ("box", ShutterKind::Box),
        ("triangle", ShutterKind::Triangle),
        ("strobe", ShutterKind::Strobe { flashes: DEFAULT_FLASHES }),
    ],
    "how much light is let in meanwhile",
)
.extension("light let in over time");

/// The shutter of a sensor.
pub struct Exposure;

impl Field for Exposure {
    type Value = Shutter;

    fn parameters(&self) -> Vec<Parameter> {
        let flashes = Parameter::new("strobe_flashes", Takes::Integer(1, MOST_FLASHES));
        let flashes = Parameter {
            default: DEFAULT_FLASHES.to_string(),
            doc: "number of flashes of a `strobe`",
            is_extension: true,
            ..flashes
        };
        [OPEN.parameters(), CLOSE.parameters(), KIND.parameters(), vec![flashes]].concat()
    }

    fn read(&self, query: &Query<'_>) -> Option<Shutter> {
        let (open, close) = (OPEN.read(query)?, CLOSE.read(query)?);
        if open > close {
            let problem = format!("The shutter closes ({close}) before it opens ({open})");
            let place = query.place(if query.has("shutter_open") { "shutter_open" } else { "shutter_close" });
            query.error(SceneError::at(&place, problem, "expected shutter_open not after shutter_close"));
        }
        let mut kind = if query.has("shutter") { KIND.read(query)? } else { ShutterKind::Box };
        if let ShutterKind::Strobe { flashes } = &mut kind
            && let Some(count) = query.integer("strobe_flashes", 1, MOST_FLASHES)
        {
            *flashes = count as u32;
        }
        if !query.reader.anything_moves() {
            for name in
                ["shutter_open", "shutter_close", "shutter"].into_iter().filter(|name| query.has(name))
            {
                query.reader.remark(&query.place(name), format!("{name} changes nothing: nothing moves"));
            }
        } else if open == close {
            let text = "the shutter opens and closes at the same time: what moves is seen where it is then";
            query.reader.remark(&query.object.place, text.to_owned());
        }
        Some(Shutter { open, close, kind })
    }

    fn write(&self, node: Node, shutter: &Shutter, _: &mut Writer) -> Node {
        if *shutter == Shutter::INSTANT {
            return node;
        }
        let node = node.float("shutter_open", shutter.open).float("shutter_close", shutter.close);
        match shutter.kind {
            ShutterKind::Box => node,
            ShutterKind::Triangle => node.text("shutter", "triangle"),
            ShutterKind::Strobe { flashes } => {
                node.text("shutter", "strobe").integer("strobe_flashes", flashes)
            }
        }
    }
}
