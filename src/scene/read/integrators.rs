//! Integrators.

use super::super::description::{BsdfKind, Integrator, IntegratorKind, Moments, ShapeDescription};
use super::super::source::{Place, SceneError};
use super::query::{Query, capital};
use super::tree::{Class, Object, ObjectId};
use super::{Reader, aovs};
use crate::scene::Techniques;

/// Mitsuba 3's default.
const DEFAULT_RR_DEPTH: u32 = 5;

/// The default of the integrators of Mitsuba 3 that differentiate.
const DEFAULT_DIFFERENTIATED_DEPTH: u32 = 6;

/// What a scene without integrator has: Mitsuba 3's `path`.
pub(super) fn default(place: &Place) -> Integrator {
    Integrator {
        place: place.clone(),
        kind: IntegratorKind::Path,
        max_depth: None,
        rr_depth: DEFAULT_RR_DEPTH,
        hide_emitters: false,
        techniques: Techniques::Both,
        aovs: Vec::new(),
        moments: None,
    }
}

pub(super) fn read(reader: &Reader, id: ObjectId) -> Integrator {
    let query = Query::new(reader, id);
    let object = query.object;
    let mut integrator = default(&object.place);
    let mut changes_nothing: Vec<&'static str> = vec!["samples_per_pass", "block_size"];
    match object.plugin.as_str() {
        plugin @ ("path" | "volpath" | "volpathmis" | "ptracer") => {
            depths(&query, &mut integrator, None);
            if plugin == "volpathmis" && query.has("use_spectral_mis") {
                query.boolean("use_spectral_mis", true);
                reader
                    .remark(&query.place("use_spectral_mis"), "use_spectral_mis changes nothing".to_owned());
            }
            if plugin.starts_with("vol") {
                integrator.kind = IntegratorKind::VolPath;
            }
            if plugin == "ptracer" {
                let text = "integrator \"ptracer\" stands for \"path\", whose picture is the same in expectation but for \
                            surfaces with shading normals: light is traced from the lamps where that finds caustics";
                reader.remark(&object.plugin_place, text.to_owned());
            }
        }
        "walk" => {
            reader.extension(
                &object.plugin_place,
                "integrator \"walk\": a random walk that does not sample lights".to_owned(),
            );
            depths(&query, &mut integrator, None);
            integrator.kind = IntegratorKind::Walk;
        }
        "direct" => {
            integrator.techniques = shading_samples(&query);
            integrator.kind = IntegratorKind::Direct;
            integrator.max_depth = Some(2);
        }
        plugin @ ("prb" | "prb_basic" | "prb_projective" | "prbvolpath" | "direct_projective") => {
            differentiated(&query, plugin, &mut integrator);
            changes_nothing.extend(["sppc", "sppp", "sppi", "guiding_rounds"]);
        }
        "depth" => integrator.kind = IntegratorKind::Depth,
        "aov" => integrator = with_aovs(&query),
        "moment" => integrator = with_moments(&query),
        _ => {
            reader.unknown_plugin(object);
            return default(&object.place);
        }
    }
    if ["aov", "moment", "depth"].contains(&object.plugin.as_str()) {
        ignored(&query, "hide_emitters", |query| {
            query.boolean("hide_emitters", false);
        });
    } else {
        integrator.hide_emitters = query.boolean("hide_emitters", false);
    }
    for name in changes_nothing {
        ignored(&query, name, |query| {
            query.integer(name, 0, i64::from(u32::MAX));
        });
    }
    if query.float("timeout").is_some() {
        reader.remark(&query.place("timeout"), "timeout changes nothing: all samples are taken".to_owned());
    }
    query.finish();
    integrator
}

/// A property that is checked and of which nothing depends.
fn ignored(query: &Query<'_>, name: &'static str, read: impl FnOnce(&Query<'_>)) {
    if query.has(name) {
        read(query);
        query.reader.remark(&query.place(name), format!("{name} changes nothing"));
    }
}

/// Most segments of a path and the number from which they may end at random; `default` is for a file that
/// names no number.
fn depths(query: &Query<'_>, integrator: &mut Integrator, default: Option<u32>) {
    let most = i64::from(u32::MAX);
    integrator.max_depth = match query.integer("max_depth", -1, most) {
        Some(depth) => u32::try_from(depth).ok(),
        None => default,
    };
    integrator.rr_depth = query.integer("rr_depth", 1, most).map_or(DEFAULT_RR_DEPTH, |depth| depth as u32);
}

/// The integrators of Mitsuba 3 that also find derivatives: their pictures are those of others.
fn differentiated(query: &Query<'_>, plugin: &str, integrator: &mut Integrator) {
    depths(query, integrator, Some(DEFAULT_DIFFERENTIATED_DEPTH));
    let stands_for = match plugin {
        "prbvolpath" => {
            integrator.kind = IntegratorKind::VolPath;
            "volpath"
        }
        "direct_projective" => {
            integrator.kind = IntegratorKind::Direct;
            integrator.max_depth = Some(2);
            "direct"
        }
        _ => "path",
    };
    let text = format!("integrator \"{plugin}\" stands for \"{stands_for}\": nothing is differentiated here");
    query.reader.remark(&query.object.plugin_place, text);
    ignored(query, "guiding", |query| {
        query.text("guiding");
    });
    ignored(query, "guiding_proj", |query| {
        query.boolean("guiding_proj", true);
    });
    ignored(query, "project_seed", |query| {
        query.text("project_seed");
    });
}

/// `aov`: the picture of the integrator in it, and images beside it.
fn with_aovs(query: &Query<'_>) -> Integrator {
    let own = aovs::read(query);
    let mut integrator = match nested(query) {
        Some((name, mut inner)) => {
            inner.aovs.iter_mut().for_each(|aov| aov.name = format!("{name}.{}", aov.name));
            if let Some(Moments { within, .. }) = &mut inner.moments {
                let inside = within.take().map_or(String::new(), |inside| format!(".{inside}"));
                *within = Some(format!("{name}{inside}"));
            }
            inner
        }
        None => {
            let text = "the picture is black: no integrator stands in \"aov\"";
            query.reader.remark(&query.object.plugin_place, text.to_owned());
            Integrator { max_depth: Some(0), ..default(&query.object.place) }
        }
    };
    integrator.aovs.splice(0..0, own);
    aovs::check(query, &integrator.aovs);
    integrator
}

/// `moment`: the picture of the integrator in it, and the second moments of its samples.
fn with_moments(query: &Query<'_>) -> Integrator {
    let place = &query.object.place;
    let refuse = |problem: &str, expected: &str, remedy: &str| {
        query.error(SceneError::at(place, problem, expected).with_remedy(remedy));
    };
    let Some((name, mut inner)) = nested(query) else {
        if !query.has_broken() {
            refuse(
                "The integrator \"moment\" holds none",
                "expected one integrator in it",
                "put <integrator type=\"path\"/> into it",
            );
        }
        return default(place);
    };
    if !inner.aovs.is_empty() {
        let expected = "moments are those of the picture alone";
        refuse("An \"aov\" within a \"moment\"", expected, "put the \"moment\" into the \"aov\"");
    }
    if inner.moments.is_some() {
        refuse("A \"moment\" within a \"moment\"", "expected one of them", "leave one of them out");
    }
    inner.moments = Some(Moments { within: None, of: name });
    inner
}

/// The integrator in another, with its name.
fn nested(query: &Query<'_>) -> Option<(String, Integrator)> {
    let found = query.objects(Class::Integrator);
    if let Some((second, _)) = found.get(1) {
        let problem = format!("{} holds several integrators", capital(&query.title()));
        let error = SceneError::at(&second.place, problem, "expected one: a render has one picture");
        query.error(error.with_remedy("write a scene file for each of them"));
    }
    let &(entry, id) = found.first()?;
    let name = entry.name.clone().unwrap_or_else(|| query.unnamed(entry));
    Some((name, read(query.reader, id)))
}

/// Says where a scene's `ptracer` shows more here than in Mitsuba 3, and refuses what it alone shows.
pub(super) fn check_light_tracing<'a>(
    reader: &Reader,
    mut shapes: impl Iterator<Item = &'a ShapeDescription>,
) {
    let is_tracer = |object: &&Object| object.class == Class::Integrator && object.plugin == "ptracer";
    let Some(tracer) = reader.tree.objects.iter().find(is_tracer) else { return };
    if shapes.any(|shape| shape.bsdf.kind.any(&is_smooth)) {
        let text = "smooth surfaces show what they mirror or transmit to the camera, although Mitsuba 3's ptracer \
                    would leave it dark";
        reader.assumption(&tracer.plugin_place, text.to_owned());
    }
    if let Some(light) = reader.tree.objects.iter().find(|object| object.plugin == "directionalarea") {
        let problem =
            "\"ptracer\" shows the light of a \"directionalarea\", which no path from the camera finds";
        let error = SceneError::at(
            &light.place,
            problem,
            "expected another light, or \"path\", which leaves it dark",
        );
        reader.error(error.with_remedy("a distant spot or projector has nearly parallel light"));
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

/// How many samples of which kind Mitsuba 3's `direct` takes at a hit: the picture is the same for any
/// number, as long as no kind is left out.
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
