//! The index of refraction of metals.

use crate::scene::description::{ConductorIndex, MetalAssumption, SpectrumSource};
use crate::scene::plugins::{Field, Parameter, Takes, indices};
use crate::scene::read::spectra::{self, Use};
use crate::scene::read::{Query, metals, textures};
use crate::scene::source::SceneError;
use crate::scene::write::{Node, Writer};

/// What a metal is: by name, by `eta` and `k`, or by what it reflects at normal incidence.
pub struct Metal;

impl Field for Metal {
    type Value = ConductorIndex;

    fn parameters(&self) -> Vec<Parameter> {
        let index =
            |name, doc| Parameter { doc, ..Parameter::new(name, Takes::Spectrum(Use::ConductorIndex)) };
        let material = Parameter::new("material", Takes::Text);
        let normal = Parameter::new("normal_reflectance", Takes::Spectrum(Use::NormalReflectance));
        let assume = Parameter::new("assume", Takes::Choice(vec!["k=0", "n=1"]));
        vec![
            Parameter {
                default: "none".to_owned(),
                doc: "name of a metal, as in `abbe spectrum --list`; `none` mirrors everything",
                ..material
            },
            index("eta", "real part of its index, beside `k`"),
            index("k", "imaginary part of its index, beside `eta`"),
            Parameter {
                doc: "its reflectance at normal incidence, from which the index follows",
                is_extension: true,
                ..normal
            },
            Parameter {
                default: "k=0".to_owned(),
                doc: "what closes the gap that `normal_reflectance` leaves, unless `eta` does",
                is_extension: true,
                ..assume
            },
        ]
    }

    fn read(&self, query: &Query<'_>) -> Option<ConductorIndex> {
        Some(conductor_index(query))
    }

    fn write(&self, node: Node, index: &ConductorIndex, _: &mut Writer) -> Node {
        match index {
            ConductorIndex::Mirror => node.text("material", "none").remark("a perfect mirror"),
            ConductorIndex::Complex { n, k } => node.spectrum("eta", n).spectrum("k", k),
            ConductorIndex::Named { name, .. } => node.text("material", name),
            ConductorIndex::NormalReflectance { reflectance, assumption } => {
                let node = node.spectrum("normal_reflectance", reflectance);
                match assumption {
                    MetalAssumption::NoAbsorption => node.text("assume", "k=0"),
                    MetalAssumption::UnitIndex => node.text("assume", "n=1"),
                    MetalAssumption::KnownIndex(n) => node.spectrum("eta", n),
                }
            }
        }
    }
}

fn conductor_index(query: &Query<'_>) -> ConductorIndex {
    let n = spectra::read(query, "eta", Use::ConductorIndex);
    let k = spectra::read(query, "k", Use::ConductorIndex);
    let reflectance = indices::normal_reflectance(query);
    let assume = assumption(query, reflectance.is_some());
    if let Some(reflectance) = reflectance {
        refuse_slab(query);
        query.reader.held("normal_reflectance", &reflectance);
        for name in ["material", "k"] {
            if let Some(entry) = query.entry(name) {
                query.error(
                    SceneError::at(
                        &entry.place,
                        "The index is given twice",
                        "expected normal_reflectance without this",
                    )
                    .with_remedy(
                        "beside normal_reflectance only a known n fits, as eta; k follows from both",
                    ),
                );
            }
        }
        return ConductorIndex::NormalReflectance {
            assumption: metal(query, assume, n, textures::varies(&reflectance)),
            reflectance,
        };
    }
    if let Some(entry) = query.entry("material") {
        if query.has("eta") || query.has("k") {
            query.error(SceneError::at(
                &entry.place,
                "The index is given twice",
                "expected either material, or eta and k",
            ));
        }
        return match query.text("material") {
            None | Some("none") => ConductorIndex::Mirror,
            Some(name) => metals::named(query, &entry.value_place, name),
        };
    }
    for (name, table) in [("eta", &n), ("k", &k)] {
        table.iter().for_each(|table| query.reader.held(name, table));
    }
    match (n, k) {
        (None, None) => ConductorIndex::Mirror,
        (n, k) => ConductorIndex::Complex {
            // Mitsuba 3's values for the one that is left out.
            n: n.unwrap_or_else(|| spectra::constant(&query.object.place, 0.0)),
            k: k.unwrap_or_else(|| spectra::constant(&query.object.place, 1.0)),
        },
    }
}

/// Light that gets into a metal does not come back from a far side.
fn refuse_slab(query: &Query<'_>) {
    if query.choice("specimen", &[("face", false), ("slab", true)], false) == Some(true) {
        query.error(
            SceneError::at(
                &query.place("specimen"),
                "A metal has no back face that reflects too",
                "expected face, which is the default, or a dielectric",
            )
            .with_remedy("a slab is of clear glass: dielectric, roughdielectric or thindielectric"),
        );
    }
}

fn assumption(query: &Query<'_>, allowed: bool) -> Option<bool> {
    if !allowed {
        return None;
    }
    query.choice("assume", &[("k=0", false), ("n=1", true)], false)
}

fn metal(
    query: &Query<'_>,
    unit_index: Option<bool>,
    n: Option<SpectrumSource>,
    varies: bool,
) -> MetalAssumption {
    let place = query.place("normal_reflectance");
    let note = |text: &str| query.reader.assumption(&place, text.to_owned());
    match (n, unit_index) {
        (Some(_), Some(_)) => {
            query.error(SceneError::at(
                &query.place("assume"),
                "A known eta leaves nothing to assume",
                "expected either eta or assume",
            ));
            MetalAssumption::NoAbsorption
        }
        (Some(n), None) => {
            if varies {
                query.error(
                    SceneError::at(
                        &place,
                        "With a known eta the reflectance cannot vary over the surface",
                        "expected a normal_reflectance that is the same everywhere",
                    )
                    .with_remedy("leave out eta: assume says what takes its place"),
                );
            }
            note("normal_reflectance with a known eta: k follows from both");
            query.reader.held("eta", &n);
            MetalAssumption::KnownIndex(n)
        }
        (None, Some(true)) => {
            note("normal_reflectance with n = 1: k = 2 √(R / (1 − R))");
            MetalAssumption::UnitIndex
        }
        (None, _) => {
            note(
                "normal_reflectance with k = 0: n = (1 + √R) / (1 − √R), which is wrong for metals off normal incidence",
            );
            MetalAssumption::NoAbsorption
        }
    }
}
