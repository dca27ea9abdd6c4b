//! BSDFs.

mod nesting;

use super::query::Query;
use super::spectra::{self, Use};
use super::tree::{ObjectId, Value};
use super::{Reader, indices};
use crate::scene::description::{Bsdf, BsdfKind, ConductorIndex, Distribution, MetalAssumption, Roughness};
use crate::scene::source::{Place, SceneError};
use crate::spectrum::catalogue::Kind;
use std::sync::Arc;

/// Mitsuba 3's default for `alpha`.
const DEFAULT_ALPHA: f64 = 0.1;

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
        "roughconductor" => Some(conductor(&query, Some(roughness(&query)))),
        "dielectric" => Some(dielectric(&query, None)),
        "roughdielectric" => Some(dielectric(&query, Some(roughness(&query)))),
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
        return ConductorIndex::NormalReflectance { assumption: metal(query, assume, n), reflectance };
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
            Some(name) => {
                spectra::lookup(query.reader, &entry.value_place, Kind::Conductor, name);
                query.reader.assumption(
                    &entry.value_place,
                    format!(
                        "material \"{name}\": abbe's table, which is not the one that comes with Mitsuba 3"
                    ),
                );
                ConductorIndex::Named { place: entry.value_place.clone(), name: name.to_owned() }
            }
        };
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
            note("normal_reflectance with a known eta: k follows from both");
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

fn roughness(query: &Query<'_>) -> Roughness {
    const DISTRIBUTIONS: [(&str, Distribution); 2] =
        [("beckmann", Distribution::Beckmann), ("ggx", Distribution::Ggx)];
    let distribution = query.choice("distribution", &DISTRIBUTIONS, true).unwrap_or(Distribution::Beckmann);
    if query.has("sample_visible") {
        query.boolean("sample_visible", true);
        query.reader.remark(
            &query.place("sample_visible"),
            "sample_visible changes nothing: visible normals are always sampled".to_owned(),
        );
    }
    let alpha = alpha(query, "alpha");
    let along = [alpha_along(query, "alpha_u"), alpha_along(query, "alpha_v")];
    let alpha = match (alpha, along) {
        (None, [None, None]) => [DEFAULT_ALPHA; 2],
        (Some(alpha), [None, None]) => [alpha; 2],
        (None, [Some(u), Some(v)]) => [u, v],
        _ => {
            let given = if query.has("alpha_u") { "alpha_u" } else { "alpha_v" };
            query.error(SceneError::at(
                &query.place(given),
                "The roughness is not clear",
                "expected either alpha, or both alpha_u and alpha_v",
            ));
            [DEFAULT_ALPHA; 2]
        }
    };
    Roughness { distribution, alpha }
}

fn alpha_along(query: &Query<'_>, name: &'static str) -> Option<f64> {
    alpha(query, name)
}

/// A roughness; one that varies over the surface is a texture, which is not supported yet.
fn alpha(query: &Query<'_>, name: &'static str) -> Option<f64> {
    let entry = query.entry(name)?;
    let value = match entry.value {
        Value::Float(value) | Value::Flat(value) => value,
        Value::Integer(value) => value as f64,
        Value::Object(_) => {
            query.error(SceneError::at(
                &entry.place,
                "A textured roughness is not supported yet",
                "expected <float>",
            ));
            return Some(DEFAULT_ALPHA);
        }
        _ => {
            query.error(query.wrong_type(entry, name, "<float>"));
            return Some(DEFAULT_ALPHA);
        }
    };
    if value > 0.0 {
        return Some(value);
    }
    let smooth = query.object.plugin.trim_start_matches("rough");
    query.error(
        SceneError::at(
            &entry.value_place,
            format!("The roughness \"{name}\" is {value}"),
            "expected a number above 0",
        )
        .with_remedy(format!("for a smooth surface use \"{smooth}\"")),
    );
    Some(DEFAULT_ALPHA)
}
