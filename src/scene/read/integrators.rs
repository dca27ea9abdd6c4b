//! Integrators.

use super::super::description::{Integrator, IntegratorKind};
use super::super::source::{Place, SceneError};
use super::Reader;
use super::query::Query;
use super::tree::ObjectId;

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
    }
}

pub(super) fn read(reader: &Reader, id: ObjectId) -> Integrator {
    let query = Query::new(reader, id);
    let object = query.object;
    let (kind, max_depth, rr_depth) = match object.plugin.as_str() {
        plugin @ ("path" | "volpath" | "volpathmis") => {
            let (max_depth, rr_depth) = depths(&query);
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
            shading_samples(&query);
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
    Integrator { place: object.place.clone(), kind, max_depth, rr_depth, hide_emitters }
}

fn depths(query: &Query<'_>) -> (Option<u32>, u32) {
    let most = i64::from(u32::MAX);
    let max_depth =
        query.integer("max_depth", -1, most).filter(|&depth| depth >= 0).map(|depth| depth as u32);
    let rr_depth = query.integer("rr_depth", 1, most).map_or(DEFAULT_RR_DEPTH, |depth| depth as u32);
    (max_depth, rr_depth)
}

/// How many samples of which kind Mitsuba 3's `direct` takes at a hit. The picture stays the same, unless one
/// kind is left out.
fn shading_samples(query: &Query<'_>) {
    let both = query.integer("shading_samples", 1, i64::from(u32::MAX));
    for name in ["emitter_samples", "bsdf_samples"] {
        let Some(count) = query.integer(name, 0, i64::from(u32::MAX)) else { continue };
        let place = query.place(name);
        if both.is_some() {
            query.error(SceneError::at(
                &place,
                "The samples are given twice",
                format!("expected either shading_samples or {name}"),
            ));
        }
        if count == 0 {
            query.error(
                SceneError::at(
                    &place,
                    format!("With {name} 0, light would be left out"),
                    "expected at least 1",
                )
                .with_remedy("without one kind of sample, point lights or mirrors would be black"),
            );
        }
    }
    for name in ["shading_samples", "emitter_samples", "bsdf_samples"] {
        if query.has(name) {
            query.reader.remark(
                &query.place(name),
                format!("{name} changes nothing: one of each kind is taken per path"),
            );
        }
    }
}
