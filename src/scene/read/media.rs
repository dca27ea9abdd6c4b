//! Media: absorption without scattering.

use super::super::description::Medium;
use super::super::description::{SpectrumKind, SpectrumSource};
use super::super::source::SceneError;
use super::Reader;
use super::query::Query;
use super::spectra::{self, Use};
use super::tree::{Class, ObjectId};

/// `None` where the medium is wrong, which is reported.
pub(super) fn read(reader: &Reader, id: ObjectId) -> Option<Medium> {
    let query = Query::new(reader, id);
    let object = query.object;
    if object.plugin != "homogeneous" {
        reader.unknown_plugin(object);
        return None;
    }
    let extinction = spectra::read_or(&query, "sigma_t", Use::Absorption, 1.0);
    let scale = query.float("scale").unwrap_or(1.0);
    if scale < 0.0 {
        let problem = format!("The medium is scaled by {scale}");
        query.error(SceneError::at(&query.place("scale"), problem, "expected a factor of at least 0"));
    }
    albedo(&query);
    if query.object(Class::Phase).is_some() {
        reader.remark(
            &object.place,
            "the phase function changes nothing: the medium does not scatter".to_owned(),
        );
    }
    for name in ["sample_emitters", "has_spectral_extinction"] {
        if query.has(name) {
            query.boolean(name, true);
            reader.remark(&query.place(name), format!("{name} changes nothing: attenuation is exact here"));
        }
    }
    query.finish();
    let absorption = SpectrumSource { scale: extinction.scale * scale, ..extinction };
    Some(Medium { place: object.place.clone(), id: object.id.clone(), absorption })
}

fn albedo(query: &Query<'_>) {
    let scatters = match spectra::read(query, "albedo", Use::Reflectance) {
        Some(albedo) => !(matches!(albedo.kind, SpectrumKind::Constant(0.0)) || albedo.scale == 0.0),
        // Mitsuba 3's default is 0.75. A value that was refused is not complained about twice.
        None => !query.has("albedo"),
    };
    if scatters {
        let problem = if query.has("albedo") {
            "A scattering medium is not supported yet"
        } else {
            "A medium scatters unless it says otherwise: albedo is 0.75 by default"
        };
        query.error(
            SceneError::at(&query.place("albedo"), problem, "expected a medium that only absorbs")
                .with_remedy("write <float name=\"albedo\" value=\"0\"/> and give the absorption as sigma_t"),
        );
    }
}
