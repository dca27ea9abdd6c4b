//! Fields of spectra and textures.

use super::{Field, Parameter, Takes};
use crate::scene::description::SpectrumSource;
use crate::scene::read::Query;
use crate::scene::read::spectra::{self, Use};
use crate::scene::write::{Node, Writer};

/// A spectrum, a texture, a colour or a number.
#[derive(Clone, Copy)]
pub struct Spectral {
    name: &'static str,
    purpose: Use,
    /// `None` where there is none, and the property has to be there.
    default: Option<f64>,
    doc: &'static str,
}

pub const fn spectrum(name: &'static str, purpose: Use, default: f64, doc: &'static str) -> Spectral {
    Spectral { name, purpose, default: Some(default), doc }
}

pub const fn required(name: &'static str, purpose: Use, doc: &'static str) -> Spectral {
    Spectral { name, purpose, default: None, doc }
}

impl Field for Spectral {
    type Value = SpectrumSource;

    fn parameters(&self) -> Vec<Parameter> {
        vec![Parameter {
            name: self.name,
            takes: Takes::Spectrum(self.purpose),
            default: self.default.map_or(String::new(), |default| default.to_string()),
            is_required: self.default.is_none(),
            unit: "",
            doc: self.doc,
            is_extension: false,
        }]
    }

    fn read(&self, query: &Query<'_>) -> Option<SpectrumSource> {
        let given = spectra::read(query, self.name, self.purpose);
        match self.default {
            Some(default) => Some(given.unwrap_or_else(|| spectra::constant(&query.object.place, default))),
            None => query.required(self.name, given),
        }
    }

    fn write(&self, node: Node, value: &SpectrumSource, _: &mut Writer) -> Node {
        node.spectrum(self.name, value)
    }
}
