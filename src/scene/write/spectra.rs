use super::super::description::{SpectrumKind, SpectrumSource};
use super::super::plugins::textures;
use super::{Value, Writer};
use std::rc::Rc;

/// A spectrum as a value where there is one, otherwise as a plugin.
pub(in crate::scene) fn write(source: &SpectrumSource) -> Value {
    let SpectrumSource { kind, scale, .. } = source;
    match kind {
        SpectrumKind::Constant(value) => Value::Flat(value * scale),
        SpectrumKind::Irregular { nm, values, file } => Value::List {
            nm: nm.clone(),
            values: values.iter().map(|value| value * scale).collect(),
            file: file.clone(),
        },
        _ => Value::Object(Rc::new(textures::node(source, &mut Writer::default()))),
    }
}
