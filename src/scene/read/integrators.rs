//! Integrators.

use super::super::description::{Integrator, IntegratorKind};
use super::super::source::{Place, SceneError};
use super::Reader;
use super::query::Query;
use super::tree::ObjectId;
use crate::integrator::Techniques;

/// Mitsuba 3's default.
const DEFAULT_RR_DEPTH: u32 = 5;

/// What a scene without integrator has: Mitsuba 3's `path`.
pub(super) fn default(place: &Place) -> Integrator {
    Integrator {
        place: place.clone(),
        kind: IntegratorKind::Path,
        max_depth: None,
        rr_depth: DEFAULT_RR_DEPTH,
        hide_emitters: false,
        techniques: Techniques::Both,
    }
}

pub(super) fn read(reader: &Reader, id: ObjectId) -> Integrator {
    let query = Query::new(reader, id);
    let object = query.object;
    let mut techniques = Techniques::Both;
    let (kind, max_depth, rr_depth) = match object.plugin.as_str() {
        plugin @ ("path" | "volpath" | "volpathmis") => {
            let (max_depth, rr_depth) = depths(&query);
            if plugin == "volpathmis" && query.has("use_spectral_mis") {
                query.boolean("use_spectral_mis", true);
                reader
                    .remark(&query.place("use_spectral_mis"), "use_spectral_mis changes nothing".to_owned());
            }
            let kind = if plugin == "path" { IntegratorKind::Path } else { IntegratorKind::VolPath };
            (kind, max_depth, rr_depth)
        }
        "walk" => {
            reader.extension(
                &object.plugin_place,
                "integrator \"walk\": a random walk that does not sample lights".to_owned(),
            );
            let (max_depth, rr_depth) = depths(&query);
            (IntegratorKind::Walk, max_depth, rr_depth)
        }
        "direct" => {
            techniques = shading_samples(&query);
            (IntegratorKind::Direct, Some(2), DEFAULT_RR_DEPTH)
        }
        _ => {
            reader.unknown_plugin(object);
            return default(&object.place);
        }
    };
    let hide_emitters = query.boolean("hide_emitters", false);
    for name in ["samples_per_pass", "block_size"] {
        if query.integer(name, 0, i64::from(u32::MAX)).is_some() {
            reader.remark(&query.place(name), format!("{name} changes nothing"));
        }
    }
    if query.float("timeout").is_some() {
        reader.remark(&query.place("timeout"), "timeout changes nothing: all samples are taken".to_owned());
    }
    query.finish();
    Integrator { place: object.place.clone(), kind, max_depth, rr_depth, hide_emitters, techniques }
}

fn depths(query: &Query<'_>) -> (Option<u32>, u32) {
    let most = i64::from(u32::MAX);
    let max_depth =
        query.integer("max_depth", -1, most).filter(|&depth| depth >= 0).map(|depth| depth as u32);
    let rr_depth = query.integer("rr_depth", 1, most).map_or(DEFAULT_RR_DEPTH, |depth| depth as u32);
    (max_depth, rr_depth)
}

/// How many samples of which kind Mitsuba 3's `direct` takes at a hit: the picture is the same for any number, as long as
/// no kind is left out.
fn shading_samples(query: &Query<'_>) -> Techniques {
    let both = query.integer("shading_samples", 1, i64::from(u32::MAX));
    let [of_lights, of_bsdfs] = ["emitter_samples", "bsdf_samples"].map(|name| {
        let count = query.integer(name, 0, i64::from(u32::MAX));
        if count.is_some() && both.is_some() {
            query.error(SceneError::at(
                &query.place(name),
                "The samples are given twice",
                format!("expected either shading_samples or {name}"),
            ));
        }
        count != Some(0)
    });
    for name in ["shading_samples", "emitter_samples", "bsdf_samples"] {
        if query.has(name) && of_lights && of_bsdfs {
            query.reader.remark(
                &query.place(name),
                format!("{name} changes nothing: one of each kind is taken per path"),
            );
        }
    }
    match (of_lights, of_bsdfs) {
        (true, true) => Techniques::Both,
        (false, true) => Techniques::Scattering,
        (true, false) => Techniques::LightSamples,
        (false, false) => {
            query.error(SceneError::at(
                &query.place("bsdf_samples"),
                "Without samples of lights and of BSDFs no light is found",
                "expected emitter_samples or bsdf_samples of at least 1",
            ));
            Techniques::Both
        }
    }
}
