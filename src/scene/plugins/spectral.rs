//! Fields of spectra and textures.

use super::textures::volumes;
use super::{Field, Parameter, Takes};
use crate::scene::description::{SpectrumKind, SpectrumSource};
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

/// A spectrum that may be left out.
pub struct OptionalSpectral(pub Spectral);

impl Field for OptionalSpectral {
    type Value = Option<SpectrumSource>;

    fn parameters(&self) -> Vec<Parameter> {
        let all = self.0.parameters().into_iter();
        all.map(|parameter| Parameter { is_required: false, ..parameter }).collect()
    }

    fn read(&self, query: &Query<'_>) -> Option<Option<SpectrumSource>> {
        Some(spectra::read(query, self.0.name, self.0.purpose))
    }

    fn write(&self, node: Node, value: &Option<SpectrumSource>, _: &mut Writer) -> Node {
        match value {
            Some(value) => node.spectrum(self.0.name, value),
            None => node,
        }
    }
}

/// A number or a spectrum in space: what varies is a `<volume>`.
pub struct Quantity {
    pub name: &'static str,
    pub purpose: Use,
    /// `None` where there is none, and the property has to be there.
    pub default: Option<f64>,
    pub doc: &'static str,
}

impl Quantity {
    fn spectral(&self) -> Spectral {
        Spectral { name: self.name, purpose: self.purpose, default: self.default, doc: self.doc }
    }
}

impl Field for Quantity {
    type Value = SpectrumSource;

    fn parameters(&self) -> Vec<Parameter> {
        self.spectral().parameters()
    }

    fn read(&self, query: &Query<'_>) -> Option<SpectrumSource> {
        self.spectral().read(query)
    }

    /// A grid is written by itself: the texture `volume` around it is for surfaces.
    fn write(&self, node: Node, value: &SpectrumSource, writer: &mut Writer) -> Node {
        match &value.kind {
            SpectrumKind::Volume(volume) => {
                node.named(self.name, volumes::node(volume, &value.place, writer))
            }
            _ => node.spectrum(self.name, value),
        }
    }
}

/// What a light sends out: that many times D65 for a number, D65 where the file says nothing.
pub struct Emission {
    pub name: &'static str,
    /// Whether a texture fits.
    pub may_vary: bool,
    pub doc: &'static str,
}

impl Field for Emission {
    type Value = SpectrumSource;

    fn parameters(&self) -> Vec<Parameter> {
        let takes = Takes::Spectrum(Use::Emission);
        vec![Parameter { default: "d65".to_owned(), doc: self.doc, ..Parameter::new(self.name, takes) }]
    }

    fn read(&self, query: &Query<'_>) -> Option<SpectrumSource> {
        Some(match self.may_vary {
            true => spectra::radiance(query, self.name),
            false => spectra::emission(query, self.name),
        })
    }

    fn write(&self, node: Node, value: &SpectrumSource, _: &mut Writer) -> Node {
        node.spectrum(self.name, value)
    }
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
