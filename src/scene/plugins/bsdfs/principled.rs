//! "Principled" surfaces, with and without a body.

use crate::scene::description::{BsdfKind, PrincipledBase, SpectrumSource};
use crate::scene::plugins::spectral::{Spectral, spectrum};
use crate::scene::plugins::{Field, Ignored, Parameter, Range, Takes, ignored};
use crate::scene::read::Query;
use crate::scene::read::spectra::Use;
use crate::scene::source::SceneError;
use crate::scene::write::{Node, Writer};

/// What both have in common.
pub struct Base;

impl Base {
    const FIELDS: [Spectral; 8] = [
        spectrum("base_color", Use::Reflectance, 0.5, "colour"),
        spectrum("roughness", Use::Fraction, 0.5, "roughness; its square is the slope of the facets"),
        spectrum("anisotropic", Use::Fraction, 0.0, "how much smoother it is along u than along v"),
        spectrum("spec_trans", Use::Fraction, 0.0, "fraction that is glass"),
        spectrum("spec_tint", Use::Fraction, 0.0, "how much reflections take the base colour"),
        spectrum("sheen", Use::Amount, 0.0, "strength of the gloss of cloth at grazing angles"),
        spectrum("sheen_tint", Use::Fraction, 0.0, "how much that takes the base colour"),
        spectrum("flatness", Use::Fraction, 0.0, "how much the diffuse part is like subsurface scattering"),
    ];
}

impl Field for Base {
    type Value = PrincipledBase;

    fn parameters(&self) -> Vec<Parameter> {
        Self::FIELDS.iter().flat_map(Field::parameters).collect()
    }

    fn read(&self, query: &Query<'_>) -> Option<PrincipledBase> {
        let [
            Some(base_color),
            Some(roughness),
            Some(anisotropic),
            Some(spec_trans),
            Some(spec_tint),
            Some(sheen),
            Some(sheen_tint),
            Some(flatness),
        ] = Self::FIELDS.map(|field| field.read(query))
        else {
            return None;
        };
        Some(PrincipledBase {
            base_color,
            roughness,
            anisotropic,
            spec_trans,
            spec_tint,
            sheen,
            sheen_tint,
            flatness,
        })
    }

    fn write(&self, node: Node, base: &PrincipledBase, writer: &mut Writer) -> Node {
        let values = [
            &base.base_color,
            &base.roughness,
            &base.anisotropic,
            &base.spec_trans,
            &base.spec_tint,
            &base.sheen,
            &base.sheen_tint,
            &base.flatness,
        ];
        // Mitsuba 3 takes a surface that states `spec_trans` for one that transmits, whatever its value.
        let is_left_out =
            |value: &SpectrumSource| std::ptr::eq(value, &base.spec_trans) && value.constant() == Some(0.0);
        let fields = Self::FIELDS.iter().zip(values).filter(|(_, value)| !is_left_out(value));
        fields.fold(node, |node, (field, value)| field.write(node, value, writer))
    }
}

/// How often lobes are sampled changes the noise in Mitsuba 3, never the picture.
pub fn rate(name: &'static str) -> Ignored {
    ignored(name, Takes::Float(Range::ALL), "lobes are sampled by what they carry")
}

/// The index below over that above, given as `eta`, or as `specular`: 12.5 times the reflectance at normal
/// incidence.
pub struct RelativeIndex;

impl RelativeIndex {
    fn of_specular(specular: f64) -> f64 {
        /// Value of `specular` at which the surface reflects everything.
        const LIMIT: f64 = 12.5;
        2.0 / (1.0 - (specular / LIMIT).sqrt()) - 1.0
    }
}

impl Field for RelativeIndex {
    type Value = f64;

    fn parameters(&self) -> Vec<Parameter> {
        let eta = Parameter::new("eta", Takes::Float(Range::POSITIVE));
        let range = Range { low: 0.0, with_low: true, high: 12.5, with_high: false };
        let specular = Parameter::new("specular", Takes::Float(range));
        vec![
            Parameter { doc: "index below the surface over that above", ..eta },
            Parameter {
                default: "0.5".to_owned(),
                doc: "instead of `eta`, 12.5 times the reflectance at normal incidence",
                ..specular
            },
        ]
    }

    fn read(&self, query: &Query<'_>) -> Option<f64> {
        if query.has("eta") && query.has("specular") {
            query.error(SceneError::at(
                &query.place("specular"),
                "The index is given twice",
                "expected either eta or specular",
            ));
        }
        if query.has("eta") {
            return Some(query.positive("eta", 1.5));
        }
        let specular = query.float("specular").unwrap_or(0.5);
        if !(0.0..12.5).contains(&specular) {
            query.error(
                SceneError::at(
                    &query.place("specular"),
                    format!("\"specular\" is {specular}"),
                    "expected a number of at least 0 and below 12.5",
                )
                .with_remedy("from 0 to 1 it reflects from 0 to 8 % at normal incidence"),
            );
            return Some(Self::of_specular(0.5));
        }
        Some(Self::of_specular(specular))
    }

    fn write(&self, node: Node, eta: &f64, _: &mut Writer) -> Node {
        node.float("eta", *eta)
    }
}

/// Where light is transmitted, Mitsuba 3 keeps a facet to refract it: an `eta` of 1 becomes 1.001, a
/// `specular` of 0 becomes 0.001.
pub fn with_refraction(query: &Query<'_>, mut kind: BsdfKind) -> Option<BsdfKind> {
    if let BsdfKind::Principled { base, eta, .. } = &mut kind
        && base.spec_trans.constant() != Some(0.0)
    {
        if query.has("eta") {
            *eta = if (*eta - 1.0).abs() < 1e-4 { 1.001 } else { *eta };
        } else if query.float("specular").is_some_and(|specular| specular < 1e-7) {
            *eta = RelativeIndex::of_specular(1e-3);
        }
    }
    Some(kind)
}

/// Refuses a sheet that sends through more than all light, or whose index varies where it must not.
pub fn sound_sheet(query: &Query<'_>, kind: BsdfKind) -> Option<BsdfKind> {
    let BsdfKind::PrincipledThin { diff_trans, eta, conserve_energy, .. } = &kind else { return Some(kind) };
    if let Some(value) = diff_trans.constant().filter(|value| *value > 2.0) {
        let problem = format!("\"diff_trans\" is {value}");
        query.error(
            SceneError::at(&query.place("diff_trans"), problem, "expected a number from 0 to 2")
                .with_remedy("1 sends half of the diffuse light through, 2 all of it"),
        );
    }
    if *conserve_energy && eta.constant().is_none() {
        query.error(
            SceneError::at(
                &eta.place,
                "A sheet that conserves energy has the same index everywhere",
                "expected a number",
            )
            .with_remedy("leave out conserve_energy, or the texture"),
        );
    }
    Some(kind)
}
