//! "Principled" surfaces, with and without a body.

use crate::scene::description::{BsdfKind, PrincipledBase, SpectrumSource};
use crate::scene::read::query::Query;
use crate::scene::read::spectra::{self, Use};
use crate::scene::source::SceneError;

pub(super) fn read(query: &Query<'_>) -> BsdfKind {
    let base = base(query);
    ignore_rates(
        query,
        &["diffuse_reflectance_sampling_rate", "main_specular_sampling_rate", "clearcoat_sampling_rate"],
    );
    let eta = principled_index(query, &base.spec_trans);
    BsdfKind::Principled {
        base,
        metallic: fraction(query, "metallic", 0.0),
        clearcoat: spectra::read_or(query, "clearcoat", Use::Amount, 0.0),
        clearcoat_gloss: fraction(query, "clearcoat_gloss", 0.0),
        eta,
        conserve_energy: conserve_energy(query),
    }
}

pub(super) fn read_thin(query: &Query<'_>) -> BsdfKind {
    ignore_rates(
        query,
        &[
            "diffuse_reflectance_sampling_rate",
            "diffuse_transmittance_sampling_rate",
            "specular_reflectance_sampling_rate",
            "specular_transmittance_sampling_rate",
        ],
    );
    let diff_trans = spectra::read_or(query, "diff_trans", Use::Amount, 0.0);
    if let Some(value) = diff_trans.constant().filter(|value| *value > 2.0) {
        let problem = format!("\"diff_trans\" is {value}");
        query.error(
            SceneError::at(&query.place("diff_trans"), problem, "expected a number from 0 to 2")
                .with_remedy("1 sends half of the diffuse light through, 2 all of it"),
        );
    }
    let eta = spectra::read_or(query, "eta", Use::Amount, 1.5);
    let conserve_energy = conserve_energy(query);
    if conserve_energy && eta.constant().is_none() {
        query.error(
            SceneError::at(
                &eta.place,
                "A sheet that conserves energy has the same index everywhere",
                "expected a number",
            )
            .with_remedy("leave out conserve_energy, or the texture"),
        );
    }
    BsdfKind::PrincipledThin { base: base(query), diff_trans, eta, conserve_energy }
}

/// Whether the surface is kept from returning more than it gets, which in Mitsuba 3 it may.
fn conserve_energy(query: &Query<'_>) -> bool {
    if query.has("conserve_energy") {
        let text = "conserve_energy: whether values are divided by what the surface would return beyond what it gets";
        query.reader.extension(&query.place("conserve_energy"), text.to_owned());
    }
    query.boolean("conserve_energy", false)
}

fn base(query: &Query<'_>) -> PrincipledBase {
    PrincipledBase {
        base_color: spectra::read_or(query, "base_color", Use::Reflectance, 0.5),
        roughness: fraction(query, "roughness", 0.5),
        anisotropic: fraction(query, "anisotropic", 0.0),
        spec_trans: fraction(query, "spec_trans", 0.0),
        spec_tint: fraction(query, "spec_tint", 0.0),
        sheen: spectra::read_or(query, "sheen", Use::Amount, 0.0),
        sheen_tint: fraction(query, "sheen_tint", 0.0),
        flatness: fraction(query, "flatness", 0.0),
    }
}

fn fraction(query: &Query<'_>, name: &'static str, default: f64) -> SpectrumSource {
    spectra::read_or(query, name, Use::Fraction, default)
}

/// Given as `eta`, or as `specular`: 12.5 times the reflectance at normal incidence. Where light is
/// transmitted, Mitsuba 3 keeps a facet to refract it: an `eta` of 1 becomes 1.001, a `specular` of 0 becomes
/// 0.001.
fn principled_index(query: &Query<'_>, spec_trans: &SpectrumSource) -> f64 {
    /// Value of `specular` at which the surface reflects everything.
    const LIMIT: f64 = 12.5;
    let glass = spec_trans.constant() != Some(0.0);
    let of_specular = |specular: f64| 2.0 / (1.0 - (specular / LIMIT).sqrt()) - 1.0;
    if query.has("eta") && query.has("specular") {
        query.error(SceneError::at(
            &query.place("specular"),
            "The index is given twice",
            "expected either eta or specular",
        ));
    }
    if query.has("eta") {
        let eta = query.positive("eta", 1.5);
        return if glass && (eta - 1.0).abs() < 1e-4 { 1.001 } else { eta };
    }
    let specular = query.float("specular").unwrap_or(0.5);
    if !(0.0..LIMIT).contains(&specular) {
        query.error(
            SceneError::at(
                &query.place("specular"),
                format!("\"specular\" is {specular}"),
                "expected a number of at least 0 and below 12.5",
            )
            .with_remedy("from 0 to 1 it reflects from 0 to 8 % at normal incidence"),
        );
        return of_specular(0.5);
    }
    of_specular(if glass && specular < 1e-7 { 1e-3 } else { specular })
}

/// How often lobes are sampled changes the noise in Mitsuba 3, never the picture.
fn ignore_rates(query: &Query<'_>, names: &[&'static str]) {
    for name in names {
        if query.float(name).is_some() {
            query.reader.remark(
                &query.place(name),
                format!("{name} changes nothing: lobes are sampled by what they carry"),
            );
        }
    }
}
