//! What only a whole scene tells: where its integrator shows more here than in Mitsuba 3, or less.

use super::super::description::{BsdfKind, Integrator, IntegratorKind, ShapeDescription};
use super::super::source::SceneError;
use super::Reader;
use super::tree::{Class, Object};

/// Checks `shapes`, all that are seen, under the integrator.
pub(super) fn check(reader: &Reader, integrator: &Integrator, shapes: &[&ShapeDescription]) {
    media_count(reader, integrator, shapes);
    check_light_tracing(reader, shapes);
}

/// Says where a medium means more here than in Mitsuba 3.
fn media_count(reader: &Reader, integrator: &Integrator, shapes: &[&ShapeDescription]) {
    if !matches!(integrator.kind, IntegratorKind::Path | IntegratorKind::Direct) {
        return;
    }
    for medium in shapes.iter().flat_map(|shape| [&shape.interior, &shape.exterior]).flatten() {
        reader.assumption(
            &medium.place,
            "the medium counts, although Mitsuba 3's path and direct would ignore it".to_owned(),
        );
    }
}

/// Says where a scene's `ptracer` shows more here than in Mitsuba 3, and refuses what it alone shows.
fn check_light_tracing(reader: &Reader, shapes: &[&ShapeDescription]) {
    let is_tracer = |object: &&Object| object.class == Class::Integrator && object.plugin == "ptracer";
    let Some(tracer) = reader.tree.objects.iter().find(is_tracer) else { return };
    if shapes.iter().any(|shape| shape.bsdf.kind.any(&is_smooth)) {
        let text = "smooth surfaces show what they mirror or transmit to the camera, although Mitsuba 3's ptracer \
                    would leave it dark";
        reader.assumption(&tracer.plugin_place, text.to_owned());
    }
    if let Some(light) = reader.tree.objects.iter().find(|object| object.plugin == "directionalarea") {
        let problem = "\"ptracer\" with a \"directionalarea\" is refused: no path from the camera finds its \
                       light, which Mitsuba 3's ptracer shows";
        let error = SceneError::at(&light.place, problem, "expected another light");
        reader.error(error.with_remedy(
            "take a distant `spot` or `projector`, whose light is nearly parallel, or \"path\", which leaves \
             this light dark in Mitsuba 3, too",
        ));
    }
}

/// Whether a BSDF sends light on in single directions, which light subpaths that aim at a camera never find.
fn is_smooth(kind: &BsdfKind) -> bool {
    match kind {
        BsdfKind::Conductor { roughness, .. } | BsdfKind::Dielectric { roughness, .. } => roughness.is_none(),
        BsdfKind::Plastic { coat, .. } => coat.is_none(),
        BsdfKind::ThinDielectric { .. } => true,
        _ => false,
    }
}
