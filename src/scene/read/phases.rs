//! Phase functions: in what directions media scatter.

use super::super::description::{Phase, PhaseKind, SpectrumKind};
use super::super::source::SceneError;
use super::Reader;
use super::query::{Query, capital};
use super::spectra::{self, Use, numbers};
use super::textures::varies;
use super::tree::{Class, ObjectId, Value};
use crate::phase::PhaseTable;

/// Mitsuba 3's.
const DEFAULT_MEAN_COSINE: f64 = 0.8;

/// The phase function of a medium: isotropic where the file names none, or a wrong one, which is reported.
pub(super) fn of_medium(query: &Query<'_>) -> Phase {
    let named = query.object(Class::Phase).and_then(|(_, id)| read(query.reader, id));
    named.unwrap_or_else(|| Phase { place: query.object.place.clone(), kind: PhaseKind::Isotropic })
}

/// `None` where it is wrong, which is reported.
pub(super) fn read(reader: &Reader, id: ObjectId) -> Option<Phase> {
    let query = Query::new(reader, id);
    let object = query.object;
    let kind = match object.plugin.as_str() {
        "isotropic" => Some(PhaseKind::Isotropic),
        "hg" => henyey_greenstein(&query),
        "rayleigh" => Some(PhaseKind::Rayleigh),
        "tabphase" => tabulated(&query),
        "blendphase" => blend(&query),
        _ => {
            reader.unknown_plugin(object);
            return None;
        }
    };
    query.finish();
    Some(Phase { place: object.place.clone(), kind: kind? })
}

fn henyey_greenstein(query: &Query<'_>) -> Option<PhaseKind> {
    let g = query.float("g").unwrap_or(DEFAULT_MEAN_COSINE);
    if !(-1.0 < g && g < 1.0) {
        let problem = format!("The mean cosine \"g\" is {g}");
        let expected = "expected a number between -1 (straight back) and 1 (straight ahead)";
        query.error(SceneError::at(&query.place("g"), problem, expected));
        return None;
    }
    Some(PhaseKind::HenyeyGreenstein { g })
}

fn tabulated(query: &Query<'_>) -> Option<PhaseKind> {
    let values = query.required("values", numbers(query, "values"))?;
    if PhaseTable::new(&values).is_none() {
        let problem = "The table is no phase function";
        let expected = "expected two values or more, of at least 0 and not all 0";
        let error = SceneError::at(&query.place("values"), problem, expected);
        query.error(error.with_remedy(
            "they stand at equal steps of the cosine of the angle, from -1 (straight back) to 1 (straight ahead)",
        ));
        return None;
    }
    Some(PhaseKind::Tabulated { values })
}

fn blend(query: &Query<'_>) -> Option<PhaseKind> {
    let weight = query.required("weight", spectra::read(query, "weight", Use::Weight));
    if let Some(source) = weight.as_ref().filter(|source| varies(source))
        && !matches!(source.kind, SpectrumKind::Volume(_))
    {
        let problem = "The weight of a blend of phase functions varies over a surface";
        let expected = "expected a number or a <volume>";
        query.error(SceneError::at(&query.place("weight"), problem, expected));
        return None;
    }
    let nested = query.objects(Class::Phase);
    let found = nested.len();
    let phases: Vec<Phase> = nested.into_iter().filter_map(|(_, id)| read(query.reader, id)).collect();
    if found != 2 && !query.object.entries.iter().any(|entry| matches!(entry.value, Value::Broken)) {
        let plural = if found == 1 { "" } else { "s" };
        let problem = format!("{} holds {found} phase function{plural}", capital(&query.title()));
        query.error(SceneError::at(&query.object.place, problem, "expected two"));
    }
    let nested = <[Phase; 2]>::try_from(phases).ok()?;
    Some(PhaseKind::Blend { weight: weight?, nested: Box::new(nested) })
}
