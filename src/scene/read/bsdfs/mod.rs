//! BSDFs.

mod nesting;
mod plastic;
mod principled;
mod roughness;

use super::query::Query;
use super::spectra::{self, Use};
use super::tree::ObjectId;
use super::{Reader, indices, metals, textures};
use crate::scene::description::{Bsdf, BsdfKind, ConductorIndex, MetalAssumption, Roughness};
use crate::scene::source::{Place, SceneError};
use std::sync::Arc;

/// What a shape without `bsdf` has: half of the light back, or none where it emits.
pub(super) fn default(place: &Place, emits: bool) -> Arc<Bsdf> {
    let reflectance = spectra::constant(place, if emits { 0.0 } else { 0.5 });
    Arc::new(Bsdf { place: place.clone(), id: None, kind: BsdfKind::Diffuse { reflectance } })
}

/// Reads a BSDF once, however often it is referred to. One that is wrong is reported and becomes the default.
pub(super) fn read(reader: &Reader, id: ObjectId) -> Arc<Bsdf> {
    if let Some(known) = reader.bsdfs.borrow().get(&id) {
        return Arc::clone(known);
    }
    let query = Query::new(reader, id);
    let object = query.object;
    let kind = match object.plugin.as_str() {
        "diffuse" => Some(BsdfKind::Diffuse {
            reflectance: spectra::read_or(&query, "reflectance", Use::Reflectance, 0.5),
        }),
        "diffusetransmitter" => Some(diffuse_transmitter(&query)),
        "conductor" => Some(conductor(&query, None)),
        "roughconductor" => Some(conductor(&query, Some(roughness::read(&query)))),
        "dielectric" => Some(dielectric(&query, None)),
        "roughdielectric" => Some(dielectric(&query, Some(roughness::read(&query)))),
        "thindielectric" => Some(thin_dielectric(&query)),
        "plastic" => Some(plastic::read(&query, None)),
        "roughplastic" => Some(plastic::read(&query, Some(roughness::read_coat(&query)))),
        "principled" => Some(principled::read(&query)),
        "principledthin" => Some(principled::read_thin(&query)),
        "twosided" => nesting::two_sided(&query),
        "null" => Some(BsdfKind::Null),
        "mask" => nesting::mask(&query),
        "blendbsdf" => nesting::blend(&query),
        "bumpmap" => nesting::bump_map(&query),
        "normalmap" => nesting::normal_map(&query),
        _ => {
            reader.unknown_plugin(object);
            None
        }
    };
    let bsdf = match kind {
        Some(kind) => {
            query.finish();
            Arc::new(Bsdf { place: object.place.clone(), id: object.id.clone(), kind })
        }
        None => default(&object.place, false),
    };
    reader.bsdfs.borrow_mut().insert(id, Arc::clone(&bsdf));
    bsdf
}

fn diffuse_transmitter(query: &Query<'_>) -> BsdfKind {
    query.reader.extension(
        &query.object.plugin_place,
        "bsdf \"diffusetransmitter\": Lambertian reflection and transmission".to_owned(),
    );
    let reflectance = spectra::read_or(query, "reflectance", Use::Reflectance, 0.25);
    let transmittance = spectra::read_or(query, "transmittance", Use::Reflectance, 0.25);
    // Room for the rounding of values such as 0.7 + 0.3.
    if let Some((nm, sum)) =
        spectra::greatest_sum(&reflectance, &transmittance).filter(|(_, sum)| *sum > 1.0 + 1e-9)
    {
        let name = if query.has("transmittance") { "transmittance" } else { "reflectance" };
        query.error(
            SceneError::at(
                &query.place(name),
                format!("Reflectance and transmittance sum up to {sum:.6} at {nm} nm"),
                "expected a sum of at most 1 at every wavelength",
            )
            .with_remedy("each is 0.25 where it is not given"),
        );
    }
    BsdfKind::DiffuseTransmitter { reflectance, transmittance }
}

fn conductor(query: &Query<'_>, roughness: Option<Roughness>) -> BsdfKind {
    BsdfKind::Conductor {
        index: conductor_index(query),
        specular_reflectance: spectra::read_or(query, "specular_reflectance", Use::Reflectance, 1.0),
        roughness,
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
    n: Option<crate::scene::description::SpectrumSource>,
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

fn dielectric(query: &Query<'_>, roughness: Option<Roughness>) -> BsdfKind {
    BsdfKind::Dielectric {
        interior: indices::interior(query),
        exterior: indices::read(query, "ext_ior"),
        specular_reflectance: spectra::read_or(query, "specular_reflectance", Use::Reflectance, 1.0),
        specular_transmittance: spectra::read_or(query, "specular_transmittance", Use::Reflectance, 1.0),
        roughness,
    }
}

fn thin_dielectric(query: &Query<'_>) -> BsdfKind {
    BsdfKind::ThinDielectric {
        interior: indices::interior(query),
        exterior: indices::read(query, "ext_ior"),
        specular_reflectance: spectra::read_or(query, "specular_reflectance", Use::Reflectance, 1.0),
        specular_transmittance: spectra::read_or(query, "specular_transmittance", Use::Reflectance, 1.0),
    }
}
