//! Media: what absorbs and scatters in space.

use super::super::description::{Medium, SpectrumKind, SpectrumSource};
use super::super::source::SceneError;
use super::query::Query;
use super::spectra::{self, Use};
use super::textures::varies;
use super::tree::ObjectId;
use super::{Reader, phases};

/// Mitsuba 3's.
const DEFAULT_ALBEDO: f64 = 0.75;

/// `None` where the medium is wrong, which is reported.
pub(super) fn read(reader: &Reader, id: ObjectId) -> Option<Medium> {
    let query = Query::new(reader, id);
    let object = query.object;
    let heterogeneous = match object.plugin.as_str() {
        "homogeneous" => false,
        "heterogeneous" => true,
        _ => {
            reader.unknown_plugin(object);
            return None;
        }
    };
    let extinction = spectra::read_or(&query, "sigma_t", Use::Absorption, 1.0);
    let scale = query.float("scale").unwrap_or(1.0);
    if scale < 0.0 {
        let problem = format!("The medium is scaled by {scale}");
        query.error(SceneError::at(&query.place("scale"), problem, "expected a factor of at least 0"));
    }
    let albedo = spectra::read_or(&query, "albedo", Use::Albedo, DEFAULT_ALBEDO);
    refuse_variation(&query, "sigma_t", &extinction, heterogeneous);
    refuse_variation(&query, "albedo", &albedo, heterogeneous);
    let phase = phases::of_medium(&query);
    for name in ["sample_emitters", "has_spectral_extinction"] {
        if query.has(name) {
            query.boolean(name, true);
            reader.remark(
                &query.place(name),
                format!("{name} changes nothing: lights are sampled, and all wavelengths are weighed"),
            );
        }
    }
    query.finish();
    let extinction = SpectrumSource { scale: extinction.scale * scale, ..extinction };
    let (place, id) = (object.place.clone(), object.id.clone());
    Some(Medium { place, id, varies: heterogeneous, extinction, albedo, phase })
}

/// Refuses what varies where the medium is the same everywhere, and what varies over surfaces alone.
fn refuse_variation(query: &Query<'_>, name: &'static str, source: &SpectrumSource, heterogeneous: bool) {
    let is_grid = matches!(source.kind, SpectrumKind::Volume(_));
    if !varies(source) || heterogeneous && is_grid {
        return;
    }
    let problem = format!("\"{name}\" of {} varies from place to place", query.title());
    let error = SceneError::at(&query.place(name), problem, "expected a number or a spectrum");
    query.error(match (heterogeneous, is_grid) {
        (false, true) => error.with_remedy("use a `heterogeneous` medium"),
        _ => error.with_remedy("in a `heterogeneous` medium it may be a <volume type=\"gridvolume\">"),
    });
}
